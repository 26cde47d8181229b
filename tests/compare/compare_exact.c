// Holds two linear pictures of one scene against each other, pixel by pixel.
//
//     compare_exact OURS THEIRS LEAST [MAP.ppm]
//
// A pixel agrees where every channel is within 0.1 % of the other (POV-Ray's OpenEXR files hold
// half floats, which are known to 0.05 %). Exit status 0 if at least LEAST percent of the pixels
// agree. The map shows those that don't, in white.
#include "base/io.h"
#include "image/image.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

// Below the least normal half float precision is lost.
static const double TOLERANCE = 1e-3, DARK = 6.2e-5;

static bool load(const char *path, Image *image)
{
    char message[512] = "";
    FileBytes bytes;
    IoError error = file_read(path, 1u << 28, &bytes);
    bool ok = error == IO_OK;
    if (ok) {
        ok = image_read(path, bytes.bytes, bytes.size, (ImageLimits){1 << 26}, image, message,
                        sizeof message);
        file_bytes_free(&bytes);
    }
    if (!ok) {
        fprintf(stderr, "%s: %s\n", path, error == IO_OK ? message : io_error_text(error));
    }
    return ok;
}

static const float *pixel(const Image *image, int x, int y)
{
    return image->pixels + ((size_t)y * (size_t)image->width + (size_t)x) * (size_t)image->channels;
}

// The largest difference of a channel over the larger of both values.
static double difference(const Image *a, const Image *b, int x, int y)
{
    double worst = 0;
    for (int c = 0; c < 3; ++c) {
        double p = (double)pixel(a, x, y)[c < a->channels ? c : 0];
        double q = (double)pixel(b, x, y)[c < b->channels ? c : 0];
        double d = fabs(p - q) / fmax(fmax(fabs(p), fabs(q)), DARK);
        worst = d <= worst ? worst : d; // a NaN counts
    }
    return worst;
}

static double distance(const Image *a, const Image *b, int x, int y)
{
    const float *p = pixel(a, x, y), *q = pixel(b, x, y);
    return fabs((double)p[0] - (double)q[0]) + fabs((double)p[1] - (double)q[1]) +
           fabs((double)p[2] - (double)q[2]);
}

static bool shows_more(const Image *a, const Image *b, int x, int y, int other)
{
    return !(distance(a, b, x, y) <= distance(a, b, other % a->width, other / a->width));
}

static void print_pixel(const Image *a, const Image *b, int x, int y)
{
    const float *p = pixel(a, x, y), *q = pixel(b, x, y);
    printf("    farthest apart at (%d, %d): %g %g %g here, %g %g %g there\n", x, y, (double)p[0],
           (double)p[1], (double)p[2], (double)q[0], (double)q[1], (double)q[2]);
}

int main(int argc, char **argv)
{
    Image ours, theirs;
    if (argc < 4 || !load(argv[1], &ours) || !load(argv[2], &theirs)) {
        return 2;
    }
    if (ours.width != theirs.width || ours.height != theirs.height) {
        fprintf(stderr, "the pictures differ in size\n");
        return 2;
    }
    FILE *map = argc > 4 ? fopen(argv[4], "w") : NULL;
    if (map) {
        fprintf(map, "P2 %d %d 255\n", ours.width, ours.height);
    }
    int worst = -1; // the pixel whose values are farthest apart
    long same = 0, all = (long)ours.width * ours.height;
    for (int y = 0; y < ours.height; ++y) {
        for (int x = 0; x < ours.width; ++x) {
            bool agrees = difference(&ours, &theirs, x, y) <= TOLERANCE;
            same += agrees;
            if (!agrees && !(worst >= 0 && !shows_more(&ours, &theirs, x, y, worst))) {
                worst = y * ours.width + x;
            }
            if (map) {
                fprintf(map, "%d\n", agrees ? 0 : 255);
            }
        }
    }
    if (map) {
        fclose(map);
    }
    double percent = 100.0 * (double)same / (double)all;
    printf("%.3f %% of the pixels are within 0.1 %%\n", percent);
    if (worst >= 0) {
        print_pixel(&ours, &theirs, worst % ours.width, worst / ours.width);
    }
    image_free(&ours);
    image_free(&theirs);
    return percent >= atof(argv[3]) ? 0 : 1;
}
