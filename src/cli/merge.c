// scnrender merge PART… -o FILE: a picture of parts that were rendered apart, with the bytes of one
// run.
#include "cli/commands.h"
#include "cli/load.h"
#include "cli/picture.h"
#include "render/checkpoint.h"

#include <stdlib.h>
#include <string.h>

typedef struct Part {
    const char *path;
    CheckpointNumbers numbers;
} Part;

typedef struct Merging {
    const Options *options;
    Arena arena;
    Part *parts; // in the order of their samples
    size_t count;
    Checkpoint head; // the first part's, open
    bool has_head;
    Film film;
    Picture picture;
} Merging;

static int code_of(CheckpointResult result)
{
    return result == CHECKPOINT_NO_MEMORY ? EXIT_NO_MEMORY : EXIT_FILES;
}

// --- Do they belong together? --------------------------------------------------------------------

static int by_first_sample(const void *a, const void *b)
{
    const Part *x = a, *y = b;
    uint32_t i = x->numbers.first_sample, j = y->numbers.first_sample;
    return i != j ? (i > j) - (i < j) : strcmp(x->path, y->path);
}

static int read_heads(Merging *m)
{
    char message[1024];
    m->count = m->options->operand_count;
    m->parts = arena_array(&m->arena, m->count, sizeof *m->parts);
    if (!m->parts) {
        return complain_no_memory();
    }
    for (size_t i = 0; i < m->count; ++i) {
        Checkpoint part;
        m->parts[i].path = m->options->operands[i];
        CheckpointResult result = checkpoint_open(&part, m->parts[i].path, message, sizeof message);
        if (result != CHECKPOINT_SOUND) {
            return complain(code_of(result), "%s", message);
        }
        m->parts[i].numbers = part.numbers;
        checkpoint_close(&part);
    }
    qsort(m->parts, m->count, sizeof *m->parts, by_first_sample);
    return EXIT_OK;
}

// Each part begins where the one before ends, the first with sample 0 and the last with the
// picture's last.
static int check_ranges(const Merging *m)
{
    uint32_t whole = m->parts[0].numbers.whole, next = 0;
    for (size_t i = 0; i < m->count; ++i) {
        const CheckpointNumbers *n = &m->parts[i].numbers;
        uint32_t end = n->first_sample + n->samples;
        if (n->more > 0) {
            return complain(EXIT_FILES,
                            "`%s` is of a picture that stops where it is good enough, which has no "
                            "parts",
                            m->parts[i].path);
        }
        if (n->whole != whole) {
            return complain(EXIT_FILES,
                            "`%s` is of a picture of %u samples a pixel, `%s` of one of %u",
                            m->parts[0].path, whole, m->parts[i].path, n->whole);
        }
        if (n->first_sample > next) {
            return complain(EXIT_FILES, "no part has the samples %u..%u", next,
                            n->first_sample - 1);
        }
        if (n->first_sample < next) {
            return complain(EXIT_FILES, "`%s` and `%s` both have sample %u", m->parts[i - 1].path,
                            m->parts[i].path, n->first_sample);
        }
        if (n->samples_done < n->samples) {
            return complain(EXIT_FILES,
                            "`%s` isn't done: it has %u of its %u samples; go on with --resume",
                            m->parts[i].path, n->samples_done, n->samples);
        }
        next = end;
    }
    return next == whole ? EXIT_OK
                         : complain(EXIT_FILES, "no part has the samples %u..%u", next, whole - 1);
}

// --- Joining -------------------------------------------------------------------------------------

// Opens a part again and reads its sums into a new film.
static int read_part(const Merging *m, const Part *part, Checkpoint *checkpoint, Film *film)
{
    char message[1024];
    CheckpointResult result = checkpoint_open(checkpoint, part->path, message, sizeof message);
    if (result != CHECKPOINT_SOUND) {
        return complain(code_of(result), "%s", message);
    }
    const CheckpointNumbers *n = &checkpoint->numbers;
    const char *difference =
        m->has_head ? checkpoint_difference(m->head.texts, checkpoint->texts) : NULL;
    int code = EXIT_OK;
    if (memcmp(n, &part->numbers, sizeof *n) != 0) {
        code = complain(EXIT_FILES, "`%s` was changed meanwhile", part->path);
    } else if (difference) {
        code = complain(EXIT_FILES, "`%s` and `%s` don't belong together: of another %s",
                        m->parts[0].path, part->path, difference);
    } else if (!film_init(film, n->width, n->height, n->first_sample, n->samples, n->aovs) ||
               (n->quantum != 0 && !film_share(film, n->quantum, n->reach))) {
        code = complain(EXIT_NO_MEMORY, "not enough memory for the samples of `%s`", part->path);
    } else {
        result =
            checkpoint_read_film(checkpoint, film, (CheckpointMore){0}, message, sizeof message);
        code = result == CHECKPOINT_SOUND ? EXIT_OK : complain(code_of(result), "%s", message);
    }
    if (code != EXIT_OK) {
        film_free(film);
        checkpoint_close(checkpoint);
    }
    return code;
}

static int join_part(Merging *m, const Part *part)
{
    Checkpoint checkpoint;
    Film film = {0};
    int code = read_part(m, part, &checkpoint, &film);
    if (code != EXIT_OK) {
        return code;
    }
    const char *here = checkpoint_text(m->head.texts, "processor");
    const char *there = checkpoint_text(checkpoint.texts, "processor");
    if (here && there && strcmp(here, there) != 0 && !m->options->quiet) {
        complain(EXIT_OK,
                 "`%s` and `%s` were rendered on different processors (%.40s, %.40s): the last "
                 "places of some samples may differ from one run's",
                 m->parts[0].path, part->path, here, there);
    }
    if (film_merge(&m->film, &film) != FILM_MERGED) {
        code = complain(EXIT_FILES, "`%s` lacks samples", part->path);
    }
    film_free(&film);
    checkpoint_close(&checkpoint);
    return code;
}

static int join(Merging *m)
{
    int code = read_part(m, &m->parts[0], &m->head, &m->film);
    m->has_head = code == EXIT_OK;
    for (size_t i = 1; code == EXIT_OK && i < m->count; ++i) {
        code = join_part(m, &m->parts[i]);
    }
    return code;
}

static int write_picture(Merging *m)
{
    char message[1024];
    int code = picture_recall(&m->picture, m->options, m->head.texts, m->film.aovs, &m->arena);
    if (code != EXIT_OK) {
        return code;
    }
    code = picture_write(&m->picture, &m->film, message, sizeof message);
    if (code != EXIT_OK) {
        return complain(code, "%s", message);
    }
    if (!m->options->quiet) {
        fprintf(stderr, "%s: %u x %u, %u sample%s, of %zu part%s\n", m->picture.path,
                (unsigned)m->film.width, (unsigned)m->film.height, (unsigned)m->film.samples_done,
                m->film.samples_done == 1 ? "" : "s", m->count, m->count == 1 ? "" : "s");
    }
    return EXIT_OK;
}

int command_merge(const Options *options)
{
    Merging merging = {.options = options};
    int code = read_heads(&merging);
    if (code == EXIT_OK) {
        code = check_ranges(&merging);
    }
    if (code == EXIT_OK) {
        code = join(&merging);
    }
    if (code == EXIT_OK) {
        code = write_picture(&merging);
    }
    film_free(&merging.film);
    if (merging.has_head) {
        checkpoint_close(&merging.head);
    }
    arena_free(&merging.arena);
    return code;
}
