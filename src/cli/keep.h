// The checkpoint of a rendering: where it lies, when it is due, what it says to the user.
#ifndef CLI_KEEP_H
#define CLI_KEEP_H

#include "cli/options.h"
#include "render/checkpoint.h"
#include "render/render.h"

// Finds out, before anything is rendered, whether the checkpoint that the options name can be
// written: it may replace an older one, but no other file. An ExitCode, after a message if it isn't
// EXIT_OK; EXIT_OK where none is named.
int keep_check(const Options *options);
// Takes up the checkpoint where that is asked for, and where there is one; *resumed tells. An
// ExitCode, after a message if it isn't EXIT_OK.
int keep_resume(const Options *options, Renderer *renderer, bool *resumed);
// Writes it, with notes for `scnrender merge`. EXIT_OK, or EXIT_FILES with a message.
int keep_save(const Options *options, Renderer *renderer, CheckpointTexts notes, char *message,
              size_t message_size);

// The range of samples that is asked for against the samples of the whole picture: a part begins
// and ends where blocks do. An ExitCode, after a message if it isn't EXIT_OK.
int keep_check_range(const Options *options, int64_t whole);

#endif
