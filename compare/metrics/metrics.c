// Holds the pictures of two renderers against each other, region by region, and makes what the
// report shows.
//
//     scn_metrics IDS.tif REGIONS.txt PREFIX OURS.exr... -- THEIRS.exr...
//
// OURS and THEIRS are linear pictures of one size, one a seed. IDS holds the number of the object
// in each pixel, 0 for none; a line "NUMBER<TAB>NAME" of REGIONS names the region of an object.
// PREFIX gets _ours.exr, _theirs.exr (means over the seeds) and, as PNG, _ours, _theirs under one
// exposure, _difference, _relative and _flip. Standard output gets JSON: for each region the mean
// radiance of either side in R, G, B and their mean, with its standard error from the seeds; what
// part of the pixels agrees within 0.1 %; and the mean of ꟻLIP.
//
// A pixel counts to a region where its eight neighbours show objects of the same region, so that no
// filter brings another one's light; the others are the region "(edges)".
#include "base/io.h"
#include "flip.h"
#include "image/image.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_SEEDS = 256, MOST_REGIONS = 4096, MOST_OBJECTS = 1 << 20, NAME_SIZE = 128 };

// A pixel agrees where each channel is within 0.1 % of the other side's. POV-Ray's OpenEXR holds
// half floats: below the least normal one (6.1e-5) precision is lost.
static const double TOLERANCE = 1e-3, DARK = 6.2e-5;

typedef struct Side {
    Image pictures[MOST_SEEDS];
    int count;
    float *mean; // width * height * 3
} Side;

typedef struct Region {
    char name[NAME_SIZE];
    long pixels;
} Region;

typedef struct Job {
    int width, height;
    Side sides[2];
    Region regions[MOST_REGIONS];
    int region_count;
    int *region_of; // of each pixel; -1: none
    bool *inside;   // no silhouette in its neighbourhood
} Job;

static size_t pixel_count(const Job *job)
{
    return (size_t)job->width * (size_t)job->height;
}

static bool complain(const char *path, const char *message)
{
    fprintf(stderr, "scn_metrics: %s: %s\n", path, message);
    return false;
}

static bool load(const char *path, Image *image)
{
    char message[512] = "";
    FileBytes bytes;
    IoError error = file_read(path, 1u << 30, &bytes);
    if (error != IO_OK) {
        return complain(path, io_error_text(error));
    }
    bool ok = image_read(path, bytes.bytes, bytes.size, (ImageLimits){1 << 28}, image, message,
                         sizeof message);
    file_bytes_free(&bytes);
    return ok || complain(path, message);
}

static double channel(const Image *image, size_t pixel, int c)
{
    return (double)
        image->pixels[pixel * (size_t)image->channels + (size_t)(c < image->channels ? c : 0)];
}

// --- Reading -------------------------------------------------------------------------------------

static bool add_picture(Job *job, Side *side, const char *path)
{
    Image *image = &side->pictures[side->count];
    if (side->count == MOST_SEEDS) {
        return complain(path, "too many pictures");
    }
    if (!load(path, image)) {
        return false;
    }
    side->count++;
    if (job->width == 0) {
        job->width = image->width;
        job->height = image->height;
    }
    return (image->width == job->width && image->height == job->height) ||
           complain(path, "another size than the pictures before it");
}

static bool average(const Job *job, Side *side)
{
    size_t count = pixel_count(job);
    side->mean = malloc(count * 3 * sizeof *side->mean);
    for (size_t i = 0; side->mean && i < 3 * count; ++i) {
        double sum = 0;
        for (int k = 0; k < side->count; ++k) {
            sum += channel(&side->pictures[k], i / 3, (int)(i % 3));
        }
        side->mean[i] = (float)(sum / side->count);
    }
    return side->mean != NULL;
}

static int region_number(Job *job, const char *name)
{
    for (int i = 0; i < job->region_count; ++i) {
        if (strcmp(job->regions[i].name, name) == 0) {
            return i;
        }
    }
    if (job->region_count == MOST_REGIONS) {
        return MOST_REGIONS - 1;
    }
    Region *region = &job->regions[job->region_count];
    snprintf(region->name, sizeof region->name, "%s", name);
    return job->region_count++;
}

// regions[n]: the region of object n. NULL on failure.
static int *read_names(Job *job, const char *path)
{
    int *regions = malloc(MOST_OBJECTS * sizeof *regions);
    FILE *in = fopen(path, "r");
    char line[1024];
    int rest = region_number(job, "(others)");
    for (int i = 0; regions && i < MOST_OBJECTS; ++i) {
        regions[i] = rest;
    }
    while (in && regions && fgets(line, sizeof line, in)) {
        char *tab = strchr(line, '\t');
        long number = strtol(line, NULL, 10);
        if (tab && number >= 0 && number < MOST_OBJECTS) {
            tab[strcspn(tab, "\r\n")] = '\0';
            regions[number] = region_number(job, tab + 1);
        }
    }
    if (!in || !regions) {
        complain(path, "can't be read");
        free(regions);
        regions = NULL;
    }
    if (in) {
        fclose(in);
    }
    return regions;
}

// Whole numbers of 32 bits are read as parts of the largest.
static long object_at(const Image *ids, int x, int y)
{
    size_t pixel = (size_t)y * (size_t)ids->width + (size_t)x;
    long id = lround(channel(ids, pixel, 0) * 4294967295.0);
    return id >= 0 && id < MOST_OBJECTS ? id : 0;
}

static bool is_inside(const Job *job, const int *own, int x, int y)
{
    int region = own[y * job->width + x];
    for (int j = y > 0 ? y - 1 : y; j <= y + 1 && j < job->height; ++j) {
        for (int i = x > 0 ? x - 1 : x; i <= x + 1 && i < job->width; ++i) {
            if (own[j * job->width + i] != region) {
                return false;
            }
        }
    }
    return true;
}

static bool sort_pixels(Job *job, const Image *ids, const int *regions)
{
    int *own = malloc(pixel_count(job) * sizeof *own), edges = region_number(job, "(edges)");
    job->region_of = malloc(pixel_count(job) * sizeof *job->region_of);
    job->inside = malloc(pixel_count(job) * sizeof *job->inside);
    bool ok = own && job->region_of && job->inside;
    for (int i = 0; ok && i < job->width * job->height; ++i) {
        own[i] = regions[object_at(ids, i % job->width, i / job->width)];
    }
    for (int i = 0; ok && i < job->width * job->height; ++i) {
        job->inside[i] = is_inside(job, own, i % job->width, i / job->width);
        job->region_of[i] = job->inside[i] ? own[i] : edges;
        job->regions[job->region_of[i]].pixels++;
    }
    free(own);
    return ok;
}

// --- Figures -------------------------------------------------------------------------------------

// The mean radiance of a region (-1: the whole picture) in one picture.
static void region_mean(const Job *job, const Image *image, int region, double out[3])
{
    long n = 0;
    out[0] = out[1] = out[2] = 0;
    for (size_t i = 0; i < pixel_count(job); ++i) {
        if (region < 0 || job->region_of[i] == region) {
            for (int c = 0; c < 3; ++c) {
                out[c] += channel(image, i, c);
            }
            ++n;
        }
    }
    for (int c = 0; c < 3; ++c) {
        out[c] /= n > 0 ? (double)n : 1;
    }
}

// The mean over the seeds, and the standard error of the mean of the three channels.
static double seed_statistics(const Job *job, const Side *side, int region, double mean[3])
{
    double sum = 0, squares = 0;
    int n = side->count;
    mean[0] = mean[1] = mean[2] = 0;
    double *values = malloc((size_t)n * sizeof *values);
    for (int k = 0; values && k < n; ++k) {
        double rgb[3];
        region_mean(job, &side->pictures[k], region, rgb);
        for (int c = 0; c < 3; ++c) {
            mean[c] += rgb[c] / n;
        }
        sum += values[k] = (rgb[0] + rgb[1] + rgb[2]) / 3;
    }
    for (int k = 0; values && k < n; ++k) {
        squares += (values[k] - sum / n) * (values[k] - sum / n);
    }
    free(values);
    return n > 1 ? sqrt(squares / (n - 1) / n) : 0;
}

static void print_side(const Job *job, const char *name, const Side *side, int region)
{
    double rgb[3], error = seed_statistics(job, side, region, rgb);
    printf("\"%s\": {\"rgb\": [%.9g, %.9g, %.9g], \"mean\": %.9g, \"error\": %.9g}", name, rgb[0],
           rgb[1], rgb[2], (rgb[0] + rgb[1] + rgb[2]) / 3, error);
}

static void print_name(const char *name)
{
    putchar('"');
    for (; *name; ++name) {
        if (*name == '"' || *name == '\\') {
            putchar('\\');
        }
        putchar((unsigned char)*name < ' ' ? ' ' : *name);
    }
    putchar('"');
}

static void print_region(const Job *job, int region)
{
    printf("{\"name\": ");
    print_name(region < 0 ? "(picture)" : job->regions[region].name);
    printf(", \"pixels\": %ld, ",
           region < 0 ? (long)pixel_count(job) : job->regions[region].pixels);
    print_side(job, "ours", &job->sides[0], region);
    printf(", ");
    print_side(job, "theirs", &job->sides[1], region);
    printf("}");
}

// The largest difference of a channel over the larger of both values; a NaN counts.
static double difference(const Job *job, size_t pixel, double dark)
{
    double worst = 0;
    for (size_t c = 0; c < 3; ++c) {
        double p = (double)job->sides[0].mean[3 * pixel + c];
        double q = (double)job->sides[1].mean[3 * pixel + c];
        double d = fabs(p - q) / fmax(fmax(fabs(p), fabs(q)), dark);
        worst = d <= worst ? worst : d;
    }
    return worst;
}

static void print_agreement(const Job *job)
{
    long same = 0, edges = 0, inside = 0;
    for (size_t i = 0; i < pixel_count(job); ++i) {
        if (difference(job, i, DARK) <= TOLERANCE) {
            ++same;
        } else {
            *(job->inside[i] ? &inside : &edges) += 1;
        }
    }
    printf("\"agree\": {\"percent\": %.6g, \"pixels\": %ld, \"differ_on_silhouettes\": %ld, "
           "\"differ_elsewhere\": %ld}",
           100.0 * (double)same / (double)pixel_count(job), (long)pixel_count(job), edges, inside);
}

// --- Pictures ------------------------------------------------------------------------------------

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

// What our brightest hundredth of the pixels begins with becomes white.
static double exposure_of(const Job *job)
{
    size_t count = pixel_count(job);
    float *sorted = malloc(count * sizeof *sorted);
    if (!sorted) {
        return 1;
    }
    for (size_t i = 0; i < count; ++i) {
        const float *p = job->sides[0].mean + 3 * i;
        float most = fmaxf(p[0], fmaxf(p[1], p[2]));
        sorted[i] = isfinite(most) ? most : 0;
    }
    qsort(sorted, count, sizeof *sorted, compare_floats);
    double white = (double)sorted[count - 1 - count / 100];
    free(sorted);
    return white > 0 ? 1 / white : 1;
}

static bool write(const char *prefix, const char *suffix, const Job *job, const float *pixels)
{
    static const char *const names[] = {"R", "G", "B"};
    char path[4096], message[512] = "";
    ImageLayer layer = {"", 3, names, pixels, NULL};
    ImageFile file = {
        .width = job->width, .height = job->height, .layers = &layer, .layer_count = 1};
    snprintf(path, sizeof path, "%s%s", prefix, suffix);
    return image_write(path, path, &file, message, sizeof message) || complain(path, message);
}

static float encode(double x)
{
    x = x > 0 ? fmin(x, 1) : 0;
    return (float)(x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055);
}

static void expose(const Job *job, const Side *side, double exposure, float *out)
{
    for (size_t i = 0; i < 3 * pixel_count(job); ++i) {
        out[i] = encode((double)side->mean[i] * exposure);
    }
}

// From black over purple and orange to pale yellow.
static void false_color(double t, float out[3])
{
    static const double stops[5][3] = {
        {0, 0, 0.02}, {0.34, 0.06, 0.43}, {0.74, 0.22, 0.33}, {0.98, 0.56, 0.04}, {0.99, 1, 0.64}};
    t = (t > 0 ? fmin(t, 1) : 0) * 4;
    int k = t >= 4 ? 3 : (int)t;
    for (int c = 0; c < 3; ++c) {
        out[c] = (float)(stops[k][c] + (stops[k + 1][c] - stops[k][c]) * (t - k));
    }
}

// Relative error on a logarithmic scale, from 0.01 % (black) to 100 % (pale). What differs on a
// silhouette, where the sides of an edge are mixed, is turquoise.
static void relative_map(const Job *job, double exposure, float *out)
{
    for (size_t i = 0; i < pixel_count(job); ++i) {
        double d = difference(job, i, 1e-3 / exposure);
        false_color(d > 0 ? 1 + log10(d) / 4 : 0, out + 3 * i);
        if (d > TOLERANCE && !job->inside[i]) {
            double bright = fmin(0.7 + 0.1 * log10(d), 1);
            out[3 * i] = 0;
            out[3 * i + 1] = out[3 * i + 2] = (float)bright;
        }
    }
}

// Theirs brighter is red, ours blue; full color is a tenth of white.
static void difference_map(const Job *job, double exposure, float *out)
{
    for (size_t i = 0; i < pixel_count(job); ++i) {
        double sum = 0;
        for (size_t c = 0; c < 3; ++c) {
            sum += (double)job->sides[1].mean[3 * i + c] - (double)job->sides[0].mean[3 * i + c];
        }
        double t = fmin(fmax(sum / 3 * exposure * 10, -1), 1), k = 1 - fabs(t);
        out[3 * i] = (float)(t > 0 ? 1 - 0.3 * t : k);
        out[3 * i + 1] = (float)(k * (1 - 0.1 * fabs(t)));
        out[3 * i + 2] = (float)(t < 0 ? 1 + 0.3 * t : k);
    }
}

static bool write_flip(const char *prefix, const Job *job, double exposure, float *out)
{
    size_t count = pixel_count(job);
    float *a = malloc(count * 3 * sizeof *a), *b = malloc(count * 3 * sizeof *b);
    float *error = malloc(count * sizeof *error);
    bool ok = a && b && error;
    for (size_t i = 0; ok && i < 3 * count; ++i) {
        a[i] = (float)((double)job->sides[0].mean[i] * exposure);
        b[i] = (float)((double)job->sides[1].mean[i] * exposure);
    }
    ok = ok && flip(a, b, job->width, job->height, flip_pixels_per_degree(0.7, 0.7, 3840), error);
    double sum = 0;
    for (size_t i = 0; ok && i < count; ++i) {
        sum += (double)error[i];
        false_color((double)error[i], out + 3 * i);
    }
    printf("\"flip\": %.6g", sum / (double)count);
    free(a);
    free(b);
    free(error);
    return ok && write(prefix, "_flip.png", job, out);
}

static bool write_pictures(const Job *job, const char *prefix)
{
    float *out = malloc(pixel_count(job) * 3 * sizeof *out);
    double exposure = exposure_of(job);
    bool ok = out && write(prefix, "_ours.exr", job, job->sides[0].mean) &&
              write(prefix, "_theirs.exr", job, job->sides[1].mean);
    if (ok) {
        expose(job, &job->sides[0], exposure, out);
        ok = write(prefix, "_ours.png", job, out);
    }
    if (ok) {
        expose(job, &job->sides[1], exposure, out);
        ok = write(prefix, "_theirs.png", job, out);
    }
    if (ok) {
        difference_map(job, exposure, out);
        ok = write(prefix, "_difference.png", job, out);
    }
    if (ok) {
        relative_map(job, exposure, out);
        ok = write(prefix, "_relative.png", job, out);
    }
    ok = ok && write_flip(prefix, job, exposure, out);
    printf(", \"exposure\": %.9g", exposure);
    free(out);
    return ok;
}

// --- All -----------------------------------------------------------------------------------------

static bool read_all(Job *job, int argc, char **argv)
{
    int side = 0;
    for (int i = 4; i < argc; ++i) {
        if (strcmp(argv[i], "--") == 0) {
            side = 1;
        } else if (!add_picture(job, &job->sides[side], argv[i])) {
            return false;
        }
    }
    return (job->sides[0].count > 0 && job->sides[1].count > 0) ||
           complain(argv[0], "needs pictures of both sides");
}

static bool read_regions(Job *job, const char *ids_path, const char *names_path)
{
    Image ids = {0};
    int *regions = load(ids_path, &ids) ? read_names(job, names_path) : NULL;
    bool ok = regions != NULL;
    if (ok && (ids.width != job->width || ids.height != job->height)) {
        ok = complain(ids_path, "another size than the pictures");
    }
    ok = ok && sort_pixels(job, &ids, regions);
    image_free(&ids);
    free(regions);
    return ok;
}

static void free_job(Job *job)
{
    for (int s = 0; s < 2; ++s) {
        for (int k = 0; k < job->sides[s].count; ++k) {
            image_free(&job->sides[s].pictures[k]);
        }
        free(job->sides[s].mean);
    }
    free(job->region_of);
    free(job->inside);
    free(job);
}

int main(int argc, char **argv)
{
    if (argc < 7) {
        fprintf(stderr,
                "usage: scn_metrics IDS.tif REGIONS.txt PREFIX OURS.exr... -- THEIRS.exr...\n");
        return 2;
    }
    Job *job = calloc(1, sizeof *job);
    bool ok = job && read_all(job, argc, argv) && read_regions(job, argv[1], argv[2]) &&
              average(job, &job->sides[0]) && average(job, &job->sides[1]);
    if (ok) {
        printf("{\"regions\": [");
        print_region(job, -1);
        for (int i = 0; i < job->region_count; ++i) {
            if (job->regions[i].pixels > 0) {
                printf(",\n");
                print_region(job, i);
            }
        }
        printf("],\n");
        print_agreement(job);
        printf(", ");
        ok = write_pictures(job, argv[3]);
        printf("}\n");
    }
    if (job) {
        free_job(job);
    }
    return ok ? 0 : 1;
}
