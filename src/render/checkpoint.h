// Checkpoints: a film on its way in one file, so that another run goes on from there or joins it
// with other parts.
//
// The file, all numbers little-endian:
//
//     magic, version   8 bytes, uint32
//     texts            uint32: how many; each: uint32 kind, uint32 length of the name and of the
//                      value, their bytes
//     numbers          CheckpointNumbers
//     checksum         uint64: of all above
//     sums             the film's arrays as they lie in memory: pixels, layers, blocks, the layers'
//                      blocks, the gains; those that the numbers tell of; then what else the
//                      renderer keeps
//     checksum         uint64: of all above
//
// A checksum is XXH3 (64 bits) of the last piece (a number, a length, a string, an array, a
// checksum) seeded with that of the piece before, the first with 0.
//
// The size of a sound file follows from its head.
#ifndef RENDER_CHECKPOINT_H
#define RENDER_CHECKPOINT_H

#include "base/arena.h"
#include "render/film.h"

#include <stdio.h>

enum { CHECKPOINT_VERSION = 2 };

typedef enum CheckpointKind {
    CHECKPOINT_IDENTITY, // must be the same for sums to belong together: the scene, the seed, …
    CHECKPOINT_NOTE,     // told to whoever makes a picture of it; follows from the identity
} CheckpointKind;

// What a checkpoint says of itself in words.
typedef struct CheckpointText {
    uint32_t kind; // CheckpointKind
    const char *name, *value;
} CheckpointText;

typedef struct CheckpointTexts {
    const CheckpointText *items;
    uint32_t count;
} CheckpointTexts;

enum { CHECKPOINT_MOST_TEXTS = 64 };

typedef struct CheckpointNumbers {
    uint32_t width, height;
    uint32_t first_sample, samples; // the range that was asked for: its first and how many
    uint32_t whole;                 // samples of the whole picture, of which the range is a part
    uint32_t samples_done;          // of every pixel
    uint32_t block_count;           // kept apart (film.h)
    uint32_t aovs;                  // 1: with layers
    uint64_t rays, shadow_rays, samples_taken, bad_samples;
    uint64_t more;  // bytes behind the film's arrays
    double seconds; // of rendering
    double quantum; // of the gains; 0: there are none
    uint32_t reach; // of the sharing
    uint32_t unused;
} CheckpointNumbers;

// Bytes behind the film's arrays.
typedef struct CheckpointBytes {
    void *at;
    uint64_t size;
} CheckpointBytes;
typedef struct CheckpointMore {
    const CheckpointBytes *items;
    uint32_t count;
} CheckpointMore;

// Writes to a stream that the caller opened, and checks when closing it. Texts of more than a
// mebibyte are cut.
void checkpoint_write(FILE *file, CheckpointTexts texts, const CheckpointNumbers *numbers,
                      const Film *film, CheckpointMore more);

// A file that is being read.
typedef struct Checkpoint {
    CheckpointTexts texts;
    CheckpointNumbers numbers;
    // private
    const char *path;
    Arena arena; // of the texts
    FILE *file;
    uint64_t hash; // of what was read
} Checkpoint;

typedef enum CheckpointResult {
    CHECKPOINT_SOUND,
    CHECKPOINT_MISSING, // there is no such file
    CHECKPOINT_UNREADABLE,
    CHECKPOINT_FOREIGN, // the file is something else than a checkpoint
    CHECKPOINT_OTHER,   // of another version of the format, of another scene, …
    CHECKPOINT_DAMAGED, // cut off, or not what was written
    CHECKPOINT_NO_MEMORY,
} CheckpointResult;

// Opens the file at `path` (which must stay) and reads its head. Anything but CHECKPOINT_SOUND
// comes with a message of one line and leaves nothing to be closed.
CheckpointResult checkpoint_open(Checkpoint *checkpoint, const char *path, char *message,
                                 size_t message_size);
// Reads the sums into a film that was made (film_init) for numbers like the checkpoint's, and what
// stands behind them (which must have the size that the numbers tell) into `more`, and holds the
// whole file to its checksum. After an error, which comes with a message, both hold nonsense.
CheckpointResult checkpoint_read_film(Checkpoint *checkpoint, Film *film, CheckpointMore more,
                                      char *message, size_t message_size);
void checkpoint_close(Checkpoint *checkpoint);

// The value of the text called `name`; NULL where there is none.
const char *checkpoint_text(CheckpointTexts texts, const char *name);
// The name of an identity in which two sets of texts differ (one that only one of them has does,
// too); NULL where they agree.
const char *checkpoint_difference(CheckpointTexts a, CheckpointTexts b);

#endif
