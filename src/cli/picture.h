// The picture on the disk: its name, and its content from a film.
#ifndef CLI_PICTURE_H
#define CLI_PICTURE_H

#include "cli/load.h"
#include "image/image.h"
#include "render/checkpoint.h"
#include "render/render.h"

// Of the error that a picture tells, where its scene has no `stop`.
static const double ERROR_CONFIDENCE = 0.95;

typedef struct Picture {
    const char *path; // where it will stand; NULL: there is none
    int bits;
    bool aovs[AOV_COUNT];
    const char *camera; // as text, where it isn't one of the scene's; else NULL
    // Set before the first picture_write, by picture_describe or picture_recall.
    double exposure;
    int32_t tone;
    unsigned threads;                // that develop it
    double confidence, wanted_error; // of the error that is told; wanted: 0 where none is
    CheckpointTexts facts; // where it comes from: attributes of the file, and notes of a checkpoint
} Picture;

// Finds out where the picture goes and with which layers, and that it can be written there; a part
// (--sample-range) has none unless a name is given for it. An ExitCode, after a message if it isn't
// EXIT_OK. Strings are the scene's arena's.
int picture_begin(Picture *picture, Loading *loading);
// Describes a picture of what the renderer renders. False without memory.
bool picture_describe(Picture *picture, Loading *loading, const Renderer *renderer);
// The same picture at `path`, without further layers and with the bits of its type.
Picture picture_copy(const Picture *picture, const char *path);
// Describes it from the notes of a checkpoint, which must outlive it; its name, bits and, where any
// are named, layers are of the options. An ExitCode, after a message if it isn't EXIT_OK.
int picture_recall(Picture *picture, const Options *options, CheckpointTexts notes, bool has_layers,
                   Arena *arena);
// True if any layer but the picture itself is to be written.
bool picture_has_layers(const Picture *picture);
// Replaces the picture by what the film holds. EXIT_OK, or EXIT_FILES or EXIT_NO_MEMORY with a
// message.
int picture_write(const Picture *picture, const Film *film, char *message, size_t message_size);
// Replaces the file `path` by any image; the type follows from its name. As picture_write.
int picture_replace(const char *path, const ImageFile *file, Arena *arena, char *message,
                    size_t message_size);

#endif
