// Stopping where it's good enough doesn't pull the mean: adaptive sampling against known light, and
// beside it what everybody would write first, whose mean is wrong by far.
//
// The naive way looks at the samples that it averages: a cell whose samples look even stops. It is
// built here from the passes of an ordinary rendering, with the same cells, numbers and criterion.
#include "estimate.h"

#include "base/mem.h"

#include <string.h>

static CheckTable table;
static double effort = 1; // times as many seeds: SCN_EFFORT

enum { SIDE = 16, CELLS = (SIDE / ADAPTIVE_CELL) * (SIDE / ADAPTIVE_CELL) };

// --- Light ---------------------------------------------------------------------------------------

// Numbers that know nothing of each other: a sample's strata would help.
static float independent(const Sampler *sampler)
{
    const uint32_t pixel = hash_combine(sampler->seed, sampler->place);
    return hash_to_float(hash_combine(pixel, sampler->reversed_index));
}

// A little light always, and a flash in one sample of so many: mean 1.
static double flash_rarity;

static Rgb flash_radiance(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                          IntegratorStats *stats)
{
    (void)world, (void)ray, (void)aov, (void)stats;
    const bool flash = (double)independent(sampler) * flash_rarity < 1;
    return rgb_gray((float)(0.1 + (flash ? 0.9 * flash_rarity : 0)));
}
static const IntegratorClass flashes = {
    .name = "flashes", .doc = "of the test", .radiance = flash_radiance};

// Even noise between 0 and 2.
static Rgb even_radiance(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                         IntegratorStats *stats)
{
    (void)world, (void)ray, (void)aov, (void)stats;
    return rgb_gray(2 * independent(sampler));
}
static const IntegratorClass even = {
    .name = "even", .doc = "of the test", .radiance = even_radiance};

// --- Pictures ------------------------------------------------------------------------------------

typedef struct Setup {
    SceneMaker maker;
    World *world;
    const IntegratorClass *integrator;
    double error, expected;
} Setup;

// A camera that looks down on a square of `size`, all of whose samples pass the pixels' centres.
static void begin(Setup *setup, double error, int samples, double size)
{
    SceneMaker *m = &setup->maker;
    maker_init(m);
    setup->error = error;
    setup->world = NULL;
    PUT(m, "camera", {"position", {0, 1, 0}}, {"direction", {0, -1, 0}}, {"up", {0, 0, -1}},
        {"projection", .text = "orthographic"}, {"height", {size}});
    PUT(m, "film", {"width", {SIDE}}, {"height", {SIDE}}, {"filter", .text = "center"});
    const uint32_t rule = PUT(m, "until", {"error", {error}});
    PUT(m, "render", {"samples", {samples}}, {"bounces", {1}}, {"stop", {rule}});
}

static void build(Setup *setup)
{
    setup->world = world_build(&setup->maker.scene, 1, &setup->maker.sink);
    if (!setup->world || setup->maker.errors) {
        abort();
    }
}

static void end(Setup *setup)
{
    world_free(setup->world);
    maker_free(&setup->maker);
}

static double mean_of(const FilmPixel *pixels, size_t first, size_t width, size_t height)
{
    double sum = 0;
    for (size_t y = 0; y < height; ++y) {
        for (size_t x = 0; x < width; ++x) {
            sum += film_luminance(&pixels[first + y * SIDE + x]);
        }
    }
    return sum / (double)(width * height);
}

static double adaptive_mean(const Setup *setup, int64_t seed, double *samples)
{
    const RenderOptions options = {
        .threads = 1, .seed = seed, .integrator = setup->integrator, .world = setup->world};
    DiagSink sink;
    Arena arena = {0};
    diag_sink_init(&sink, &arena);
    Renderer *r = renderer_new(&setup->maker.scene, &options, &sink);
    if (!r || !renderer_run(r, NULL)) {
        abort();
    }
    const FilmPixel *pixels = renderer_film(r)->pixels;
    const double mean = mean_of(pixels, 0, SIDE, SIDE);
    for (size_t p = 0; p < SIDE * SIDE; ++p) {
        *samples += pixels[p].samples;
    }
    renderer_free(r);
    diag_sink_free(&sink);
    arena_free(&arena);
    return mean;
}

// The naive way, fed by the passes of an ordinary rendering.
typedef struct Naive {
    double error, floor;
    double means[CELLS];
    bool done[CELLS];
} Naive;

static void look_at_pass(void *context, const RenderProgress *progress)
{
    Naive *naive = context;
    const Film *film = progress->film;
    if (!progress->pass_done || film->samples_done < 16) {
        return;
    }
    if (naive->floor < 0) {
        naive->floor = 0.1 * mean_of(film->pixels, 0, SIDE, SIDE);
    }
    for (size_t c = 0; c < CELLS; ++c) {
        const size_t first = c / (SIDE / ADAPTIVE_CELL) * ADAPTIVE_CELL * SIDE +
                             c % (SIDE / ADAPTIVE_CELL) * ADAPTIVE_CELL;
        if (naive->done[c]) {
            continue;
        }
        double variance = 0;
        for (size_t i = 0; i < ADAPTIVE_CELL * ADAPTIVE_CELL; ++i) {
            variance +=
                film_variance(&film->pixels[first + i / ADAPTIVE_CELL * SIDE + i % ADAPTIVE_CELL]);
        }
        naive->means[c] = mean_of(film->pixels, first, ADAPTIVE_CELL, ADAPTIVE_CELL);
        const double error = 1.959964 * sqrt(variance / (ADAPTIVE_CELL * ADAPTIVE_CELL)) /
                             fmax(naive->means[c], naive->floor);
        naive->done[c] = error <= naive->error;
    }
}

static double naive_mean(const Setup *setup, int64_t seed)
{
    Naive naive = {.error = setup->error, .floor = -1};
    const RenderOptions options = {.threads = 1,
                                   .seed = seed,
                                   .integrator = setup->integrator,
                                   .world = setup->world,
                                   .even = true,
                                   .progress = look_at_pass,
                                   .context = &naive};
    DiagSink sink;
    Arena arena = {0};
    diag_sink_init(&sink, &arena);
    Renderer *r = renderer_new(&setup->maker.scene, &options, &sink);
    if (!r || !renderer_run(r, NULL)) {
        abort();
    }
    renderer_free(r);
    diag_sink_free(&sink);
    arena_free(&arena);
    double sum = 0;
    for (int c = 0; c < CELLS; ++c) {
        sum += naive.means[c];
    }
    return sum / CELLS;
}

// --- Many seeds ----------------------------------------------------------------------------------

typedef struct Batch {
    const Setup *setup;
    int seeds; // of a replicate
    bool naive;
    double means[REPLICATES], samples[REPLICATES];
} Batch;

static void run_batch(void *context, uint64_t item, unsigned worker)
{
    (void)worker;
    Batch *batch = context;
    double sum = 0;
    for (int i = 0; i < batch->seeds; ++i) {
        const int64_t seed = (int64_t)item * batch->seeds + i;
        sum += batch->naive ? naive_mean(batch->setup, seed)
                            : adaptive_mean(batch->setup, seed, &batch->samples[item]);
    }
    batch->means[item] = sum / batch->seeds;
}

static Running run_all(const Setup *setup, int seeds, bool naive, double *samples)
{
    Batch batch = {.setup = setup, .seeds = (int)(seeds * effort), .naive = naive};
    parallel_for(REPLICATES, 0, run_batch, &batch, NULL);
    Running mean = {0};
    for (int i = 0; i < REPLICATES; ++i) {
        running_add(&mean, batch.means[i]);
        *samples += batch.samples[i];
    }
    *samples /= (double)REPLICATES * batch.seeds * SIDE * SIDE;
    return mean;
}

static double ours(const Setup *setup, const char *name, int seeds, double wanted)
{
    double samples = 0;
    full_bias = wanted; // of rare light a full run finds no less, since it would take days
    check_mean(&table, name, setup->expected, run_all(setup, seeds, false, &samples), wanted);
    return samples;
}

// Ours must have the mean, the naive way must be seen not to have it: else the test would show
// nothing. Returns how many of the two fail the second.
static int compare(const Setup *setup, const char *name, int seeds, double wanted)
{
    double none = 0;
    const double samples = ours(setup, name, seeds, wanted);
    const Running naive = run_all(setup, seeds, true, &none);
    const double z = (naive.mean - setup->expected) / running_error(&naive);
    printf("%-44s naive stopping: mean %.4f of %.4f, z = %.1f; ours: %.1f samples a pixel\n", name,
           naive.mean, setup->expected, z, samples);
    if (!(fabs(z) > 8)) {
        printf("%s: naive stopping isn't seen to be biased\n", name);
        return 1;
    }
    return 0;
}

// --- Tests ---------------------------------------------------------------------------------------

// Cells that have seen no flash look perfectly even, and a naive mean keeps them so.
static int rare_flashes(void)
{
    static const struct {
        double rarity, error;
        const char *name;
        int seeds;
        double wanted;
    } RARITIES[] = {{2048, 0.3, "flash in 2048 samples", 20, 0.15},
                    {512, 6, "flash in 512 samples", 40, 0.05}};
    int failures = 0;
    for (size_t i = 0; i < sizeof RARITIES / sizeof *RARITIES; ++i) {
        Setup setup = {.integrator = &flashes, .expected = 1};
        flash_rarity = RARITIES[i].rarity;
        begin(&setup, RARITIES[i].error, 256, 1);
        build(&setup);
        failures += compare(&setup, RARITIES[i].name, RARITIES[i].seeds, RARITIES[i].wanted);
        end(&setup);
    }
    return failures;
}

// Frequent ones, where little bias can be found: a thousandth in a full run.
static void frequent_flashes(void)
{
    Setup setup = {.integrator = &flashes, .expected = 1};
    flash_rarity = 16;
    begin(&setup, 1.5, 256, 1);
    build(&setup);
    ours(&setup, "flash in 16 samples", full_run() ? 24 * 256 : 24, full_run() ? 1e-3 : 0.02);
    end(&setup);
}

// A small lamp over a plane, which only rays that the material chooses find: one in some thousands.
// E = π L (r/d)² cos θ.
static int small_lamp(void)
{
    Setup setup = {.expected = 0.5 * 40 * pow(0.03 / 1.5, 2)};
    begin(&setup, 0.5, 256, 1e-3);
    SceneMaker *m = &setup.maker;
    PUT(m, "plane", {"material", {PUT(m, "lambert", {"color", {0.5}})}});
    const uint32_t ball = PUT_LIGHT_SHAPE(m, "sphere", {"center", {0, 1.5, 0}}, {"radius", {0.03}});
    PUT(m, "area_light", {"shape", {ball}}, {"radiance", {40}});
    build(&setup);
    setup.world->bounces = 1;
    setup.world->sampling = SAMPLING_BSDF;
    const int failures = compare(&setup, "small lamp found by chance", 6, 0.35);
    end(&setup);
    return failures;
}

// The confidence: of pixels of plain noise so many lie as near to the truth as was asked for.
static int confidence(void)
{
    Setup setup = {.integrator = &even, .expected = 1};
    begin(&setup, 0.1, 1 << 14, 1);
    build(&setup);
    int near_pixels = 0, all = 0;
    for (int64_t seed = 0; seed < (int64_t)(40 * effort); ++seed) {
        const RenderOptions options = {
            .threads = 1, .seed = seed, .integrator = &even, .world = setup.world};
        Renderer *r = renderer_new(&setup.maker.scene, &options, &setup.maker.sink);
        if (!r || !renderer_run(r, NULL)) {
            abort();
        }
        for (size_t p = 0; p < SIDE * SIDE; ++p) {
            near_pixels += fabs(film_luminance(&renderer_film(r)->pixels[p]) - 1) <= 0.1;
            ++all;
        }
        if (film_error(renderer_film(r), 0.95, 0.1).met < 0.9) {
            printf("cells stopped before they met the error\n");
            return 1;
        }
        renderer_free(r);
    }
    end(&setup);
    const double share = (double)near_pixels / all;
    printf("%-44s %.4f of the pixels lie within the error, of which 0.95 were asked for\n",
           "confidence", share);
    return share >= 0.95 && share < 0.99 ? 0 : 1; // the last step overshoots a little
}

int main(void)
{
    const char *text = getenv("SCN_EFFORT");
    effort = text ? atof(text) : 1;
    int failures = rare_flashes() + small_lamp() + confidence();
    frequent_flashes();
    failures += check_judge(&table, "adaptive");
    return failures ? EXIT_FAILURE : EXIT_SUCCESS;
}
