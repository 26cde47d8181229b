#include "watch/save.h"

#include "base/mem.h"
#include "image/image.h"
#include "watch/session_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static float *developed(const Snapshot *picture, SessionLook look, bool linear)
{
    size_t count = (size_t)picture->width * picture->height;
    float *pixels = mem_alloc(count, 3 * sizeof *pixels);
    float gain = (float)exp2(look.exposure);
    for (size_t p = 0; pixels && p < count; ++p) {
        const float *from = picture->radiance + 3 * p;
        Rgb color = rgb(from[0], from[1], from[2]);
        if (!linear) {
            color = tone_apply(look.tone, rgb_scale(color, gain));
        }
        pixels[3 * p] = color.r;
        pixels[3 * p + 1] = color.g;
        pixels[3 * p + 2] = color.b;
    }
    return pixels;
}

// The writer wants a file; it is nobody else's, and gone afterwards.
static bool write_and_read(const ImageFile *file, const char *type, FileBytes *bytes, char *message,
                           size_t message_size)
{
    const char *folder = getenv("TMPDIR");
    Text path = {0}, format_of = {0};
    text_print(&path, "%s/scnrender.XXXXXX", folder && *folder ? folder : "/tmp");
    text_print(&format_of, "picture.%s", type);
    int fd = path.failed || format_of.failed ? -1 : mkstemp(path.bytes);
    bool good = fd >= 0;
    if (good) {
        good = image_write(path.bytes, format_of.bytes, file, message, message_size);
        IoError error = good ? file_read(path.bytes, (uint64_t)1 << 34, bytes) : IO_OK;
        if (error != IO_OK) {
            snprintf(message, message_size, "%s", io_error_text(error));
            good = false;
        }
        unlink(path.bytes);
        close(fd);
    } else {
        snprintf(message, message_size, "no file can be made for it");
    }
    text_free(&path);
    text_free(&format_of);
    return good;
}

// --- What a file tells of itself -----------------------------------------------------------------

enum { MOST_FACTS = 16 };

typedef struct Facts {
    ImageAttribute items[MOST_FACTS];
    Text texts[MOST_FACTS]; // what the items point to
    int count;
} Facts;

// A fact that can't be told, without memory, is left out.
static void add_fact(Facts *facts, const char *name, Text text)
{
    if (text.bytes && !text.failed && facts->count < MOST_FACTS) {
        facts->items[facts->count] = (ImageAttribute){name, text.bytes};
        facts->texts[facts->count++] = text;
    } else {
        text_free(&text);
    }
}

static void add_number(Facts *facts, const char *name, const char *format, double number)
    __attribute__((format(printf, 3, 0)));

static void add_number(Facts *facts, const char *name, const char *format, double number)
{
    Text text = {0};
    text_print(&text, format, number);
    add_fact(facts, name, text);
}

static void add_word(Facts *facts, const char *name, const char *word)
{
    Text text = {0};
    text_write(&text, word, strlen(word));
    add_fact(facts, name, text);
}

// Under the names that `scnrender render` gives them, as far as it has them.
static void add_facts(Facts *facts, const Snapshot *picture, SessionLook look)
{
    const Loaded *loaded = picture->loaded;
    const Source *source = source_get(&loaded->lang.sources, 1);
    Text hash = {0}, command = {0};
    text_print(&hash, "%016llx", (unsigned long long)loaded->scene.hash);
    add_word(facts, "Software", "scnrender " SCN_VERSION);
    add_word(facts, "scnrender:version", SCN_VERSION);
    if (source) {
        const char *slash = strrchr(source->path, '/');
        add_word(facts, "scnrender:scene", slash ? slash + 1 : source->path);
    }
    add_fact(facts, "scnrender:scene_hash", hash);
    if (picture->command && !picture->coarse) {
        text_write(&command, picture->command, strlen(picture->command));
        session_command_look(&command, &picture->film, look.exposure, (int)look.tone);
        add_fact(facts, "scnrender:command", command);
    }
    add_number(facts, "scnrender:samples", "%.0f", picture->samples);
    if (!isnan(picture->relative.mean)) {
        add_number(facts, "scnrender:error", "%.4g", picture->relative.mean);
        add_number(facts, "scnrender:error_worst", "%.4g", picture->relative.worst);
        add_number(facts, "scnrender:error_confidence", "%.6g", SNAPSHOT_CONFIDENCE);
    }
}

static void free_facts(Facts *facts)
{
    for (int i = 0; i < facts->count; ++i) {
        text_free(&facts->texts[i]);
    }
}

FileBytes *save_picture(const Snapshot *picture, SessionLook look, const char *type, char *message,
                        size_t message_size)
{
    static const char *const names[] = {"R", "G", "B"};
    Text format_of = {0};
    text_print(&format_of, "picture.%s", type);
    bool linear = !format_of.failed && image_is_linear(format_of.bytes, 0);
    text_free(&format_of);
    float *pixels = developed(picture, look, linear);
    FileBytes *bytes = mem_alloc_zeroed(1, sizeof *bytes);
    bool good = pixels && bytes;
    if (good) {
        Facts facts = {.count = 0};
        add_facts(&facts, picture, look);
        ImageLayer layer = {"", 3, names, pixels, NULL};
        ImageFile file = {(int)picture->width, (int)picture->height, 0, &layer, 1,
                          facts.items,         facts.count,          1};
        good = write_and_read(&file, type, bytes, message, message_size);
        free_facts(&facts);
    } else {
        snprintf(message, message_size, "not enough memory");
    }
    mem_free(pixels);
    if (!good) {
        mem_free(bytes);
        return NULL;
    }
    return bytes;
}

void save_release(void *bytes)
{
    file_bytes_free(bytes);
    mem_free(bytes);
}
