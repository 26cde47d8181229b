#include "render/checkpoint.h"

#include "render/share.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

// Like PNG's: shows where a transfer took it for text.
static const char magic[8] = {'\x93', 'S', 'C', 'N', '\r', '\n', '\x1a', '\n'};

enum { MOST_TEXT_BYTES = 1 << 20, MOST_SHOWN = 200 };

// Sums and numbers lie in the file as in memory.
_Static_assert(sizeof(FilmPixel) == 40 && sizeof(AovPixel) == 96 && sizeof(FilmGain) == 24,
               "the format's sizes");
_Static_assert(sizeof(CheckpointNumbers) == 96, "the format's sizes");
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the format's order of bytes");

enum { ARRAYS = 5 };

// The sizes in bytes of a film's arrays, in the order of the file. False where one overflows.
static bool array_sizes(const CheckpointNumbers *n, uint64_t sizes[ARRAYS])
{
    const uint64_t pixels = (uint64_t)n->width * n->height;
    const uint64_t layers = n->aovs ? pixels : 0, shared = n->quantum != 0 ? pixels : 0;
    const uint64_t counts[ARRAYS][3] = {{pixels, 1, sizeof(FilmPixel)},
                                        {layers, 1, sizeof(AovPixel)},
                                        {pixels, n->block_count, sizeof(FilmPixel)},
                                        {layers, n->block_count, sizeof(AovPixel)},
                                        {shared, 1, sizeof(FilmGain)}};
    for (int i = 0; i < ARRAYS; ++i) {
        if (__builtin_mul_overflow(counts[i][0], counts[i][1], &sizes[i]) ||
            __builtin_mul_overflow(sizes[i], counts[i][2], &sizes[i])) {
            return false;
        }
    }
    return true;
}

// --- Writing -------------------------------------------------------------------------------------

typedef struct Writer {
    FILE *file;
    uint64_t hash;
} Writer;

static void put(Writer *writer, const void *bytes, size_t size)
{
    if (size > 0) {
        writer->hash = XXH3_64bits_withSeed(bytes, size, writer->hash);
        fwrite(bytes, 1, size, writer->file); // the stream remembers errors
    }
}

static void put_number(Writer *writer, size_t number)
{
    const uint32_t value = (uint32_t)number;
    put(writer, &value, sizeof value);
}

static void put_checksum(Writer *writer)
{
    const uint64_t hash = writer->hash;
    put(writer, &hash, sizeof hash);
}

static void put_text(Writer *writer, const CheckpointText *text)
{
    const size_t name = strlen(text->name), value = strnlen(text->value, MOST_TEXT_BYTES);
    put_number(writer, text->kind);
    put_number(writer, name);
    put_number(writer, value);
    put(writer, text->name, name);
    put(writer, text->value, value);
}

void checkpoint_write(FILE *file, CheckpointTexts texts, const CheckpointNumbers *numbers,
                      const Film *film, CheckpointMore more)
{
    const void *arrays[ARRAYS] = {film->pixels, film->aovs, film->blocks, film->aov_blocks,
                                  film->gains};
    uint64_t sizes[ARRAYS] = {0};
    array_sizes(numbers, sizes); // the film is there, so they don't overflow
    Writer writer = {.file = file};
    put(&writer, magic, sizeof magic);
    put_number(&writer, CHECKPOINT_VERSION);
    put_number(&writer, texts.count);
    for (uint32_t i = 0; i < texts.count; ++i) {
        put_text(&writer, &texts.items[i]);
    }
    put(&writer, numbers, sizeof *numbers);
    put_checksum(&writer);
    for (int i = 0; i < ARRAYS; ++i) {
        put(&writer, arrays[i], sizes[i]);
    }
    for (uint32_t i = 0; i < more.count; ++i) {
        put(&writer, more.items[i].at, more.items[i].size);
    }
    put_checksum(&writer);
}

// --- Reading -------------------------------------------------------------------------------------

typedef struct Reason {
    char *message;
    size_t size;
} Reason;

static CheckpointResult refuse(const Checkpoint *checkpoint, Reason reason, CheckpointResult result,
                               const char *why)
{
    snprintf(reason.message, reason.size, "the checkpoint `%.*s` can't be used: %s", MOST_SHOWN,
             checkpoint->path, why);
    return result;
}

static CheckpointResult damaged(const Checkpoint *checkpoint, Reason reason)
{
    return refuse(checkpoint, reason, CHECKPOINT_DAMAGED,
                  feof(checkpoint->file) ? "it is cut off" : "it is damaged");
}

static bool get(Checkpoint *checkpoint, void *bytes, size_t size)
{
    if (size == 0) {
        return true;
    }
    if (fread(bytes, 1, size, checkpoint->file) != size) {
        return false;
    }
    checkpoint->hash = XXH3_64bits_withSeed(bytes, size, checkpoint->hash);
    return true;
}

static bool get_number(Checkpoint *checkpoint, uint32_t *number)
{
    return get(checkpoint, number, sizeof *number);
}

static bool get_checksum(Checkpoint *checkpoint)
{
    const uint64_t hash = checkpoint->hash;
    uint64_t written;
    return get(checkpoint, &written, sizeof written) && written == hash;
}

static CheckpointResult get_string(Checkpoint *checkpoint, uint32_t length, const char **out,
                                   Reason reason)
{
    char *text = arena_alloc_zeroed(&checkpoint->arena, (size_t)length + 1);
    if (!text) {
        return refuse(checkpoint, reason, CHECKPOINT_NO_MEMORY, "there is not enough memory");
    }
    *out = text;
    return get(checkpoint, text, length) ? CHECKPOINT_SOUND : damaged(checkpoint, reason);
}

static CheckpointResult get_text(Checkpoint *checkpoint, CheckpointText *text, Reason reason)
{
    uint32_t name, value;
    if (!get_number(checkpoint, &text->kind) || !get_number(checkpoint, &name) ||
        !get_number(checkpoint, &value) || name > MOST_TEXT_BYTES || value > MOST_TEXT_BYTES) {
        return damaged(checkpoint, reason);
    }
    const CheckpointResult result = get_string(checkpoint, name, &text->name, reason);
    return result == CHECKPOINT_SOUND ? get_string(checkpoint, value, &text->value, reason)
                                      : result;
}

static CheckpointResult get_texts(Checkpoint *checkpoint, Reason reason)
{
    uint32_t count;
    if (!get_number(checkpoint, &count) || count > CHECKPOINT_MOST_TEXTS) {
        return damaged(checkpoint, reason);
    }
    CheckpointText *texts = arena_array(&checkpoint->arena, (size_t)count + 1, sizeof *texts);
    if (!texts) {
        return refuse(checkpoint, reason, CHECKPOINT_NO_MEMORY, "there is not enough memory");
    }
    CheckpointResult result = CHECKPOINT_SOUND;
    for (uint32_t i = 0; result == CHECKPOINT_SOUND && i < count; ++i) {
        result = get_text(checkpoint, &texts[i], reason);
    }
    checkpoint->texts = (CheckpointTexts){texts, count};
    return result;
}

// Of sharing, 0 and 0, or a power of two and a pixel or more.
static bool sharing_makes_sense(const CheckpointNumbers *n)
{
    int exponent;
    return n->quantum == 0
               ? n->reach == 0
               : frexp(n->quantum, &exponent) == 0.5 && n->reach > 0 && n->reach <= SHARE_REACH;
}

// The numbers must make sense, and the file must have the length that follows from them.
static bool numbers_fit(const CheckpointNumbers *n, uint64_t read, uint64_t file_size)
{
    uint64_t sizes[ARRAYS], wanted;
    if (n->width == 0 || n->height == 0 || n->aovs > 1 || n->samples_done > n->samples ||
        n->samples > n->whole || n->first_sample > n->whole - n->samples ||
        n->first_sample % SAMPLE_BLOCK != 0 || !sharing_makes_sense(n) || !array_sizes(n, sizes) ||
        __builtin_add_overflow(read + sizeof(uint64_t), n->more, &wanted)) {
        return false;
    }
    for (int i = 0; i < ARRAYS; ++i) {
        if (__builtin_add_overflow(wanted, sizes[i], &wanted)) {
            return false;
        }
    }
    const uint32_t blocks = n->samples / SAMPLE_BLOCK + (n->samples % SAMPLE_BLOCK != 0);
    return wanted == file_size && n->block_count == (n->first_sample > 0 ? blocks : 0);
}

static CheckpointResult read_head(Checkpoint *checkpoint, uint64_t file_size, Reason reason)
{
    char start[sizeof magic];
    uint32_t version;
    if (!get(checkpoint, start, sizeof start) || memcmp(start, magic, sizeof magic) != 0) {
        return refuse(checkpoint, reason, CHECKPOINT_FOREIGN, "it is not a checkpoint");
    }
    if (!get_number(checkpoint, &version)) {
        return damaged(checkpoint, reason);
    }
    if (version != CHECKPOINT_VERSION) {
        return refuse(checkpoint, reason, CHECKPOINT_OTHER,
                      "it was written by another version of scnrender");
    }
    const CheckpointResult result = get_texts(checkpoint, reason);
    if (result != CHECKPOINT_SOUND) {
        return result;
    }
    CheckpointNumbers *numbers = &checkpoint->numbers;
    if (!get(checkpoint, numbers, sizeof *numbers) || !get_checksum(checkpoint)) {
        return damaged(checkpoint, reason);
    }
    const long read = ftell(checkpoint->file);
    if (read < 0 || !numbers_fit(numbers, (uint64_t)read, file_size)) {
        return refuse(checkpoint, reason, CHECKPOINT_DAMAGED, "it is cut off or damaged");
    }
    return CHECKPOINT_SOUND;
}

// Never waits, as for the other end of a FIFO.
static CheckpointResult open_file(Checkpoint *checkpoint, uint64_t *size, Reason reason)
{
    const int fd = open(checkpoint->path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    struct stat info;
    if (fd < 0) {
        return refuse(checkpoint, reason,
                      errno == ENOENT ? CHECKPOINT_MISSING : CHECKPOINT_UNREADABLE,
                      strerror(errno));
    }
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode)) {
        close(fd);
        return refuse(checkpoint, reason, CHECKPOINT_FOREIGN, "it is not a regular file");
    }
    *size = (uint64_t)info.st_size;
    checkpoint->file = fdopen(fd, "r");
    if (!checkpoint->file) {
        close(fd);
        return refuse(checkpoint, reason, CHECKPOINT_NO_MEMORY, strerror(errno));
    }
    return CHECKPOINT_SOUND;
}

CheckpointResult checkpoint_open(Checkpoint *checkpoint, const char *path, char *message,
                                 size_t message_size)
{
    *checkpoint = (Checkpoint){.path = path};
    const Reason reason = {message, message_size};
    uint64_t size;
    CheckpointResult result = open_file(checkpoint, &size, reason);
    if (result == CHECKPOINT_SOUND) {
        result = read_head(checkpoint, size, reason);
    }
    if (result != CHECKPOINT_SOUND) {
        checkpoint_close(checkpoint);
    }
    return result;
}

// Whatever the file says, no pixel has more samples than the range.
static bool counts_make_sense(const Film *film, const CheckpointNumbers *n)
{
    for (size_t p = 0; p < film_pixel_count(film); ++p) {
        const uint32_t samples = film->pixels[p].samples;
        if (samples < n->samples_done || samples > n->samples) {
            return false;
        }
    }
    return true;
}

CheckpointResult checkpoint_read_film(Checkpoint *checkpoint, Film *film, CheckpointMore more,
                                      char *message, size_t message_size)
{
    const Reason reason = {message, message_size};
    void *arrays[ARRAYS] = {film->pixels, film->aovs, film->blocks, film->aov_blocks, film->gains};
    uint64_t sizes[ARRAYS];
    if (!array_sizes(&checkpoint->numbers, sizes)) {
        return damaged(checkpoint, reason);
    }
    for (int i = 0; i < ARRAYS; ++i) {
        if (!get(checkpoint, arrays[i], sizes[i])) {
            return damaged(checkpoint, reason);
        }
    }
    for (uint32_t i = 0; i < more.count; ++i) {
        if (!get(checkpoint, more.items[i].at, more.items[i].size)) {
            return damaged(checkpoint, reason);
        }
    }
    if (!get_checksum(checkpoint) || !counts_make_sense(film, &checkpoint->numbers)) {
        return damaged(checkpoint, reason);
    }
    film->samples_done = checkpoint->numbers.samples_done;
    return CHECKPOINT_SOUND;
}

void checkpoint_close(Checkpoint *checkpoint)
{
    if (checkpoint->file) {
        fclose(checkpoint->file);
    }
    arena_free(&checkpoint->arena);
    *checkpoint = (Checkpoint){0};
}

// --- Texts ---------------------------------------------------------------------------------------

const char *checkpoint_text(CheckpointTexts texts, const char *name)
{
    for (uint32_t i = 0; i < texts.count; ++i) {
        if (strcmp(texts.items[i].name, name) == 0) {
            return texts.items[i].value;
        }
    }
    return NULL;
}

static const char *missing_or_different(CheckpointTexts a, CheckpointTexts b)
{
    for (uint32_t i = 0; i < a.count; ++i) {
        const CheckpointText *text = &a.items[i];
        const char *other = checkpoint_text(b, text->name);
        if (text->kind == CHECKPOINT_IDENTITY && (!other || strcmp(text->value, other) != 0)) {
            return text->name;
        }
    }
    return NULL;
}

const char *checkpoint_difference(CheckpointTexts a, CheckpointTexts b)
{
    const char *name = missing_or_different(a, b);
    return name ? name : missing_or_different(b, a);
}
