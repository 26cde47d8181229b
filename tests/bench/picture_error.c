// How far pictures lie from a reference: the measure of noise of tools/bench.
//
//     picture_error REFERENCE PICTURE...
//
// All are linear (EXR) and of one size. Prints a line for each picture: the mean squared error of
// the luminance over all pixels; the same without the pixels of lamps, those which are at least a
// quarter as bright as the brightest of the reference, and their neighbours; the relative mean
// squared error, each square over that of the reference's luminance plus 1e-4; and the mean
// luminance over the reference's.
#include "base/io.h"
#include "image/image.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static bool load(const char *path, Image *out)
{
    char message[512] = "";
    FileBytes bytes;
    const IoError error = file_read(path, 1u << 30, &bytes);
    bool ok = error == IO_OK;
    if (ok) {
        ok = image_read(path, bytes.bytes, bytes.size, (ImageLimits){1 << 28}, out, message,
                        sizeof message);
        file_bytes_free(&bytes);
    }
    if (!ok) {
        fprintf(stderr, "picture_error: %s: %s\n", path, *message ? message : io_error_text(error));
    }
    return ok;
}

static double luminance_at(const Image *image, int x, int y)
{
    const float *p =
        image->pixels + ((size_t)y * (size_t)image->width + (size_t)x) * (size_t)image->channels;
    return image->channels < 3
               ? (double)p[0]
               : 0.2126 * (double)p[0] + 0.7152 * (double)p[1] + 0.0722 * (double)p[2];
}

// Whether a pixel or one of its neighbours is of a lamp.
static bool near_lamp(const Image *reference, int x, int y, double bright)
{
    for (int j = y > 0 ? y - 1 : 0; j <= y + 1 && j < reference->height; ++j) {
        for (int i = x > 0 ? x - 1 : 0; i <= x + 1 && i < reference->width; ++i) {
            if (luminance_at(reference, i, j) >= bright) {
                return true;
            }
        }
    }
    return false;
}

static void compare(const char *path, const Image *reference, const Image *picture)
{
    double brightest = 0, sum = 0, sum_dark = 0, sum_relative = 0, mean = 0, wanted = 0;
    for (int y = 0; y < reference->height; ++y) {
        for (int x = 0; x < reference->width; ++x) {
            brightest = fmax(brightest, luminance_at(reference, x, y));
        }
    }
    long all = (long)reference->width * reference->height, dark = 0;
    for (int y = 0; y < reference->height; ++y) {
        for (int x = 0; x < reference->width; ++x) {
            const double r = luminance_at(reference, x, y), p = luminance_at(picture, x, y);
            const double square = (p - r) * (p - r);
            sum += square;
            sum_relative += square / (r * r + 1e-4);
            mean += p;
            wanted += r;
            if (!near_lamp(reference, x, y, brightest / 4)) {
                sum_dark += square;
                ++dark;
            }
        }
    }
    printf("%s mse %.4e without-lamps %.4e relative %.4e mean %.5f\n", path, sum / (double)all,
           sum_dark / (double)(dark ? dark : 1), sum_relative / (double)all, mean / wanted);
}

int main(int argc, char **argv)
{
    Image reference;
    if (argc < 3) {
        fprintf(stderr, "usage: picture_error REFERENCE PICTURE...\n");
        return 2;
    }
    if (!load(argv[1], &reference)) {
        return 3;
    }
    for (int i = 2; i < argc; ++i) {
        Image picture;
        if (!load(argv[i], &picture)) {
            return 3;
        }
        if (picture.width != reference.width || picture.height != reference.height) {
            fprintf(stderr, "picture_error: %s: not of the reference's size\n", argv[i]);
            return 1;
        }
        compare(argv[i], &reference, &picture);
        image_free(&picture);
    }
    image_free(&reference);
    return 0;
}
