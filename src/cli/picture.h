// The picture on the disk: its name, and its content from a film.
#ifndef CLI_PICTURE_H
#define CLI_PICTURE_H

#include "cli/load.h"
#include "render/render.h"

typedef struct Picture {
    const Loading *loading;
    const char *path; // where it will stand
    int bits;
    bool aovs[AOV_COUNT];
    // What the attributes say; set before the first picture_write.
    const FilmParams *film_params;
    const RenderParams *render_params;
    const char *camera; // as text, where it isn't one of the scene's; else NULL
} Picture;

// Finds out where the picture goes and with which layers, and that it can be written there. An
// ExitCode, after a message if it isn't EXIT_OK. Strings are the scene's arena's.
int picture_begin(Picture *picture, Loading *loading);
// True if any layer but the picture itself is to be written.
bool picture_has_layers(const Picture *picture);
// Replaces the picture by what the film holds. EXIT_OK, or EXIT_FILES or EXIT_NO_MEMORY with a
// message.
int picture_write(const Picture *picture, const Film *film, char *message, size_t message_size);

#endif
