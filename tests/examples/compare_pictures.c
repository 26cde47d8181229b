// Holds a small rendering against a larger picture of the same scene.
//
//     compare_pictures --quarter PICTURE      prints a quarter of its size, WxH
//     compare_pictures PICTURE SMALL          exit status 0 if they show the same
//
// The larger one is averaged down to the smaller. Noise of a few samples a pixel moves single
// pixels, not the means of 4x4 blocks of them, so the blocks' root mean square difference is what
// counts.
#include "base/io.h"
#include "image/image.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double LARGEST_RMS = 0.03; // of encoded values in [0, 1]
enum { BLOCK = 4 };

static bool load(const char *path, Image *image)
{
    char message[512];
    FileBytes bytes;
    IoError error = file_read(path, 1u << 28, &bytes);
    if (error != IO_OK) {
        fprintf(stderr, "%s: %s\n", path, io_error_text(error));
        return false;
    }
    bool ok = image_read(path, bytes.bytes, bytes.size, (ImageLimits){1 << 26}, image, message,
                         sizeof message);
    if (!ok) {
        fprintf(stderr, "%s: %s\n", path, message);
    }
    file_bytes_free(&bytes);
    return ok;
}

// The mean of channel c over the part of the image that block (bx, by) of (nx, ny) covers.
static double block_mean(const Image *image, int bx, int by, int nx, int ny, int c)
{
    int x0 = bx * image->width / nx, x1 = (bx + 1) * image->width / nx;
    int y0 = by * image->height / ny, y1 = (by + 1) * image->height / ny;
    double sum = 0;
    for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x) {
            sum += (double)image->pixels[((size_t)y * (size_t)image->width + (size_t)x) *
                                             (size_t)image->channels +
                                         (size_t)(c < image->channels ? c : 0)];
        }
    }
    return sum / ((x1 - x0) * (y1 - y0));
}

int main(int argc, char **argv)
{
    Image picture, small;
    if (argc != 3) {
        fprintf(stderr, "usage: compare_pictures PICTURE SMALL | --quarter PICTURE\n");
        return 2;
    }
    if (strcmp(argv[1], "--quarter") == 0) {
        if (!load(argv[2], &picture)) {
            return 1;
        }
        printf("%dx%d\n", (picture.width + 3) / 4, (picture.height + 3) / 4);
        image_free(&picture);
        return 0;
    }
    if (!load(argv[1], &picture) || !load(argv[2], &small)) {
        return 1;
    }
    int nx = small.width / BLOCK, ny = small.height / BLOCK;
    if (nx < 2 || ny < 2) {
        fprintf(stderr, "%s is too small to compare\n", argv[2]);
        return 1;
    }
    double square = 0, worst = 0;
    for (int y = 0; y < ny; ++y) {
        for (int x = 0; x < nx; ++x) {
            for (int c = 0; c < 3; ++c) {
                double d =
                    block_mean(&picture, x, y, nx, ny, c) - block_mean(&small, x, y, nx, ny, c);
                square += d * d;
                worst = fmax(worst, fabs(d));
            }
        }
    }
    double rms = sqrt(square / (3.0 * nx * ny));
    printf("root mean square difference %.4f (at most %.4f), worst block %.3f\n", rms, LARGEST_RMS,
           worst);
    image_free(&picture);
    image_free(&small);
    return rms <= LARGEST_RMS ? 0 : 1;
}
