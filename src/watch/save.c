#include "watch/save.h"

#include "base/mem.h"
#include "image/image.h"
#include "watch/text.h"

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
        ImageLayer layer = {"", 3, names, pixels, NULL};
        ImageAttribute software = {"Software", "scnrender " SCN_VERSION};
        ImageFile file = {(int)picture->width, (int)picture->height, 0, &layer, 1, &software, 1};
        good = write_and_read(&file, type, bytes, message, message_size);
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
