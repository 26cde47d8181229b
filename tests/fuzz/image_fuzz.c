// Images: what is peeked from a header before a decoder sees it, and the decoder behind the module.
// The first byte's lowest bit names the file (Targa has no magic of its own); the rest is the file.
// Whatever the bytes: an image no larger than the limit and than its header said, or a message.
#include "base/mem.h"
#include "fuzz.h"
#include "image/image.h"
#include "image/peek.h"

#include <string.h>

// Decoders leak where an error leaps over a destructor (libpng's longjmp); ours is what the shim
// takes, which is counted below.
const char *__asan_default_options(void);
const char *__asan_default_options(void)
{
    return "detect_leaks=0";
}

static void check_peeks(const uint8_t *bytes, size_t size)
{
    static const char *const formats[] = {"openexr", "png",   "jpeg", "webp", "gif",
                                          "bmp",     "targa", "tiff", "hdr"};
    for (size_t i = 0; i < sizeof formats / sizeof formats[0]; ++i) {
        PeekedSize peeked;
        (void)image_peek(formats[i], bytes, size, &peeked);
        fuzz_require(peeked.width >= 0 && peeked.height >= 0 && peeked.tile_width >= 0 &&
                         peeked.tile_height >= 0,
                     "sizes are not negative");
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    char message[512] = "";
    fuzz_require(image_available("", message, sizeof message), message);
    if (size == 0) {
        return 0;
    }
    const char *name = bytes[0] & 1 ? "picture.tga" : "picture.png";
    ++bytes;
    --size;
    check_peeks(bytes, size);
    Image image;
    const uint64_t live = mem_live_count();
    const ImageLimits limits = {1 << 16};
    if (image_read(name, bytes, size, limits, &image, message, sizeof message)) {
        fuzz_require(image.width > 0 && image.height > 0 && image.channels >= 1 &&
                         image.channels <= 4,
                     "an image has pixels");
        fuzz_require((int64_t)image.width * image.height <= limits.max_pixels,
                     "no more pixels than allowed");
        volatile float last =
            image.pixels[(size_t)image.width * (size_t)image.height * (size_t)image.channels - 1];
        (void)last;
        image_free(&image);
    } else {
        fuzz_require(message[0] != '\0' && !strchr(message, '\n'), "a message of one line");
    }
    fuzz_require(mem_live_count() == live, "all memory is given back");
    return 0;
}
