#include "cli/keep.h"

#include "base/io.h"
#include "cli/load.h"
#include "render/resume.h"

// --- Before rendering ----------------------------------------------------------------------------

int keep_check(const Options *options)
{
    if (!options->checkpoint) {
        return EXIT_OK;
    }
    char message[1024];
    Checkpoint old;
    CheckpointResult result = checkpoint_open(&old, options->checkpoint, message, sizeof message);
    if (result == CHECKPOINT_SOUND) {
        checkpoint_close(&old);
    } else if (result == CHECKPOINT_FOREIGN) {
        return complain(EXIT_FILES, "`%s` is something else than a checkpoint, and stays as it is",
                        options->checkpoint);
    } else if (result == CHECKPOINT_UNREADABLE || result == CHECKPOINT_NO_MEMORY) {
        return complain(result == CHECKPOINT_NO_MEMORY ? EXIT_NO_MEMORY : EXIT_FILES, "%s",
                        message);
    }
    Arena arena = {0};
    char *temporary = atomic_temporary_name(&arena, options->checkpoint, message, sizeof message);
    if (temporary) {
        atomic_discard(temporary);
    }
    arena_free(&arena);
    return temporary ? EXIT_OK : complain(EXIT_FILES, "%s", message);
}

// The nearest range that can be rendered apart.
static int refuse_range(const Options *options, int64_t whole)
{
    int64_t first = options->range_first / SAMPLE_BLOCK * SAMPLE_BLOCK;
    int64_t end = (options->range_last / SAMPLE_BLOCK + 1) * SAMPLE_BLOCK;
    return complain(EXIT_USAGE,
                    "parts begin and end where blocks of %d samples do: say `--sample-range "
                    "%lld..%lld`",
                    SAMPLE_BLOCK, (long long)first, (long long)((end < whole ? end : whole) - 1));
}

int keep_check_range(const Options *options, int64_t whole)
{
    if (options->range_last < 0) {
        return EXIT_OK;
    }
    if (options->range_last >= whole) {
        return complain(EXIT_USAGE,
                        "the picture has %lld samples a pixel, numbered from 0: a part can't end "
                        "with %lld",
                        (long long)whole, (long long)options->range_last);
    }
    int64_t end = options->range_last + 1;
    bool begins = options->range_first % SAMPLE_BLOCK == 0;
    bool ends = end % SAMPLE_BLOCK == 0 || end == whole;
    return begins && ends ? EXIT_OK : refuse_range(options, whole);
}

// --- Taking up, and putting away -----------------------------------------------------------------

int keep_resume(const Options *options, Renderer *renderer, bool *resumed)
{
    *resumed = false;
    if (!options->resume) {
        return EXIT_OK;
    }
    char message[1024];
    switch (renderer_load(renderer, options->checkpoint, message, sizeof message)) {
    case CHECKPOINT_SOUND:
        *resumed = true;
        return *message && !options->quiet ? complain(EXIT_OK, "%s", message) : EXIT_OK;
    case CHECKPOINT_MISSING:
        return EXIT_OK; // so that one command begins a rendering and goes on with it
    case CHECKPOINT_NO_MEMORY:
        return complain(EXIT_NO_MEMORY, "%s", message);
    default:
        return complain(EXIT_FILES, "%s", message);
    }
}

int keep_save(const Options *options, Renderer *renderer, CheckpointTexts notes, char *message,
              size_t message_size)
{
    return renderer_save(renderer, notes, options->checkpoint, message, message_size) ? EXIT_OK
                                                                                      : EXIT_FILES;
}
