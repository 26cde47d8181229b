// How far pictures lie from a reference: the measure of noise of tools/bench.
//
//     picture_error REFERENCE... -- PICTURE...
//
// All are linear (EXR) and of one size. The reference is the mean of the first ones, which have
// equal numbers of samples and independent seeds: what they differ from each other tells the
// reference's own noise, which is subtracted. Prints a line of JSON for each picture, and a last
// one for the mean of all pictures:
//   mse       the mean squared error of the luminance over all pixels
//   dark_mse  the same without the pixels of lamps, those which are at least a quarter as bright as
//   the
//             brightest of the reference, and their neighbours
//   mean      the mean luminance
//   reference the reference's mean luminance
#include "base/io.h"
#include "image/image.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Picture {
    int width, height;
    double *luminance; // width * height
} Picture;

// Means of squares: over all pixels, and over those away from lamps.
typedef struct Squares {
    double all, dark;
} Squares;

static size_t pixels_of(const Picture *p)
{
    return (size_t)p->width * (size_t)p->height;
}

static double luminance_at(const Image *image, size_t pixel)
{
    const float *p = image->pixels + pixel * (size_t)image->channels;
    return image->channels < 3
               ? (double)p[0]
               : 0.2126 * (double)p[0] + 0.7152 * (double)p[1] + 0.0722 * (double)p[2];
}

// Adds a picture's luminance to the sum, which the first one makes.
static bool add(const char *path, Picture *sum)
{
    char message[512] = "";
    FileBytes bytes;
    Image image;
    const IoError error = file_read(path, 1u << 30, &bytes);
    bool ok = error == IO_OK;
    if (ok) {
        ok = image_read(path, bytes.bytes, bytes.size, (ImageLimits){1 << 28}, &image, message,
                        sizeof message);
        file_bytes_free(&bytes);
    }
    if (!ok) {
        fprintf(stderr, "picture_error: %s: %s\n", path, *message ? message : io_error_text(error));
        return false;
    }
    if (!sum->luminance) {
        sum->width = image.width;
        sum->height = image.height;
        sum->luminance = calloc(pixels_of(sum), sizeof *sum->luminance);
    }
    ok = sum->luminance && sum->width == image.width && sum->height == image.height;
    if (!ok) {
        fprintf(stderr, "picture_error: %s: not of the reference's size\n", path);
    }
    for (size_t i = 0; ok && i < pixels_of(sum); ++i) {
        sum->luminance[i] += luminance_at(&image, i);
    }
    image_free(&image);
    return ok;
}

static void divide(Picture *sum, int count)
{
    for (size_t i = 0; i < pixels_of(sum); ++i) {
        sum->luminance[i] /= count;
    }
}

// Whether a pixel or one of its neighbours is of a lamp.
static bool near_lamp(const Picture *reference, int x, int y, double bright)
{
    for (int j = y > 0 ? y - 1 : 0; j <= y + 1 && j < reference->height; ++j) {
        for (int i = x > 0 ? x - 1 : 0; i <= x + 1 && i < reference->width; ++i) {
            if (reference->luminance[(size_t)j * (size_t)reference->width + (size_t)i] >= bright) {
                return true;
            }
        }
    }
    return false;
}

static bool *away_from_lamps(const Picture *reference)
{
    bool *dark = malloc(pixels_of(reference));
    double brightest = 0;
    for (size_t i = 0; i < pixels_of(reference); ++i) {
        brightest = fmax(brightest, reference->luminance[i]);
    }
    for (size_t i = 0; dark && i < pixels_of(reference); ++i) {
        dark[i] = !near_lamp(reference, (int)(i % (size_t)reference->width),
                             (int)(i / (size_t)reference->width), brightest / 4);
    }
    return dark;
}

static double mean_of(const Picture *picture)
{
    double sum = 0;
    for (size_t i = 0; i < pixels_of(picture); ++i) {
        sum += picture->luminance[i];
    }
    return sum / (double)pixels_of(picture);
}

static Squares squares(const Picture *reference, const Picture *picture, const bool *dark)
{
    double all = 0, away = 0;
    size_t count = 0;
    for (size_t i = 0; i < pixels_of(reference); ++i) {
        const double d = picture->luminance[i] - reference->luminance[i];
        all += d * d;
        away += dark[i] ? d * d : 0;
        count += dark[i];
    }
    return (Squares){all / (double)pixels_of(reference), away / (double)(count ? count : 1)};
}

// The squared error of the mean of n pictures: what they spread about it, over n (n - 1).
static bool own_noise(char **paths, int n, const Picture *mean, const bool *dark, Squares *out)
{
    *out = (Squares){0};
    for (int i = 0; n > 1 && i < n; ++i) {
        Picture one = {0};
        const bool ok = add(paths[i], &one);
        if (ok) {
            const Squares s = squares(mean, &one, dark);
            out->all += s.all / ((double)n * (n - 1));
            out->dark += s.dark / ((double)n * (n - 1));
        }
        free(one.luminance);
        if (!ok) {
            return false;
        }
    }
    return true;
}

static bool sum_of(char **paths, int n, Picture *out)
{
    for (int i = 0; i < n; ++i) {
        if (!add(paths[i], out)) {
            return false;
        }
    }
    divide(out, n);
    return true;
}

static bool report(char **paths, int n, const Picture *reference, const bool *dark, Squares noise)
{
    Picture picture = {0};
    const bool ok = sum_of(paths, n, &picture) && pixels_of(&picture) == pixels_of(reference);
    if (ok) {
        const Squares s = squares(reference, &picture, dark);
        printf("{\"mse\": %.6e, \"dark_mse\": %.6e, \"mean\": %.8g, \"reference\": %.8g}\n",
               s.all - noise.all, s.dark - noise.dark, mean_of(&picture), mean_of(reference));
    }
    free(picture.luminance);
    return ok;
}

int main(int argc, char **argv)
{
    int references = 0;
    while (references + 1 < argc && strcmp(argv[references + 1], "--") != 0) {
        ++references;
    }
    char **pictures = argv + references + 2;
    const int count = argc - references - 2;
    if (references < 1 || count < 1) {
        fprintf(stderr, "usage: picture_error REFERENCE... -- PICTURE...\n");
        return 2;
    }
    Picture reference = {0};
    Squares noise;
    bool *dark = NULL;
    bool ok = sum_of(argv + 1, references, &reference);
    ok = ok && (dark = away_from_lamps(&reference)) != NULL &&
         own_noise(argv + 1, references, &reference, dark, &noise);
    for (int i = 0; ok && i < count; ++i) {
        ok = report(pictures + i, 1, &reference, dark, noise);
    }
    ok = ok && report(pictures, count, &reference, dark, noise);
    free(dark);
    free(reference.luminance);
    return ok ? 0 : 3;
}
