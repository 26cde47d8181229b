// A film made of pictures, through ffmpeg where that is installed.
#ifndef CLI_FILM_FILE_H
#define CLI_FILM_FILE_H

#include <stdbool.h>
#include <stddef.h>

// Is it the name of a film (.mp4 or .gif)?
bool film_file_is(const char *name);
// The extensions that it may have, ".mp4 or .gif".
const char *film_file_extensions(void);
// Finds ffmpeg, before anything is rendered for it. An ExitCode, after a message.
int film_file_check(const char *path);

typedef struct FilmFile {
    const char *path;
    double rate; // pictures a second
    size_t count;
    // The name of picture i, a PNG; NULL without memory. It is good until the next call.
    const char *(*picture)(void *context, size_t i);
    // Not 0 once it is to be given up: an exit status.
    int (*stopped)(void *context);
    void *context;
} FilmFile;

// Replaces the file `path` as a whole. An ExitCode, after a message if it isn't EXIT_OK or what
// `stopped` gave.
int film_file_write(const FilmFile *film);

#endif
