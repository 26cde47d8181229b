#include "render/meter.h"

#include "base/mem.h"
#include "base/statistics.h"
#include "base/thread.h"
#include "render/camera.h"
#include "render/filter.h"
#include "render/render.h"
#include "render/world.h"

enum { CHUNK = 4096 }; // samples that one thread takes at a time

// Sums of floats are never exact: a millionth is never significant.
static const double ROUNDING = 1e-6;

struct Meter {
    MeterOptions options;
    const Scene *scene;
    FilmParams film;
    const IntegratorClass *integrator;
    World *world;
    PixelFilter filter;
    Camera camera; // that the world was told of last
    uint32_t seed;
    double confidence;
    uint64_t most; // samples of one measurement
};

void meter_reseed(Meter *m, int64_t seed)
{
    m->seed = (uint32_t)seed ^ (uint32_t)((uint64_t)seed >> 32);
}

Meter *meter_new(const Scene *scene, const MeterOptions *options, DiagSink *sink)
{
    Meter *m = mem_alloc_zeroed(1, sizeof *m);
    if (!m) {
        diag_report(sink, E0001, (Span){0}, "not enough memory to measure");
        return NULL;
    }
    RenderParams params = scene_render(scene);
    TestParams test = scene_test(scene);
    meter_reseed(m, options->seed >= 0 ? options->seed : params.seed);
    m->options = *options;
    m->options.threads = options->threads ? options->threads : thread_processor_count();
    m->scene = scene;
    m->film = scene_film(scene);
    m->integrator = integrator_classes[params.integrator];
    m->confidence = options->confidence > 0 ? options->confidence : test.confidence;
    m->most = (uint64_t)(options->samples > 0 ? options->samples : test.samples);
    filter_init(&m->filter, (FilterKind)m->film.filter, m->film.filter_width);
    m->world = world_build(scene, m->options.threads, sink);
    if (!m->world) {
        meter_free(m);
        return NULL;
    }
    if (m->integrator->check) {
        m->integrator->check(m->world, sink);
    }
    return m;
}

void meter_free(Meter *m)
{
    if (m) {
        world_free(m->world);
        mem_free(m);
    }
}

// --- Samples -------------------------------------------------------------------------------------

typedef struct LeafSums {
    double sum[3], least[3], most[3]; // least and most: of the samples, and 0 where there are none
    uint64_t samples, bad;
} LeafSums;

static void add_value(LeafSums *sums, const double value[3])
{
    for (int c = 0; c < 3; ++c) {
        sums->sum[c] += value[c];
        sums->least[c] = sums->samples ? fmin(sums->least[c], value[c]) : value[c];
        sums->most[c] = sums->samples ? fmax(sums->most[c], value[c]) : value[c];
    }
    ++sums->samples;
}

static void join_sums(LeafSums *sums, const LeafSums *more)
{
    for (int c = 0; c < 3; ++c) {
        sums->sum[c] += more->sum[c];
        sums->least[c] = sums->samples ? fmin(sums->least[c], more->least[c]) : more->least[c];
        sums->most[c] = sums->samples ? fmax(sums->most[c], more->most[c]) : more->most[c];
    }
    sums->samples += more->samples;
    sums->bad += more->bad;
}

// Samples [from, to) of all replicates of a leaf, cut into chunks.
typedef struct Batch {
    Meter *meter;
    const MeasureLeaf *leaf;
    const uint8_t *seen; // by object + 1: whether it is the leaf's; NULL: all
    uint32_t from, to, chunks;
    LeafSums *sums; // [replicate * chunks + chunk]
} Batch;

static bool leaf_ray(const Meter *m, const Sight *sight, Sampler *sampler, Ray *ray)
{
    float u, v, lens_u, lens_v;
    sampler_2d(sampler, &u, &v);
    sampler_2d(sampler, &lens_u, &lens_v);
    if (sight->kind == SIGHT_RAY) {
        *ray = ray_make(sight->origin, sight->direction, 0, INFINITY);
        return true;
    }
    // A place in the region is in a pixel; what is left of it chooses the place in its filter.
    double x = sight->x0 + (double)u * (sight->x1 - sight->x0);
    double y = sight->y0 + (double)v * (sight->y1 - sight->y0);
    double column = floor(x), row = floor(y);
    double filter_x = filter_sample(&m->filter, (float)(x - column));
    double filter_y = filter_sample(&m->filter, (float)(y - row));
    return camera_ray(&m->camera, (column + 0.5 + filter_x) / (double)m->film.width,
                      (row + 0.5 + filter_y) / (double)m->film.height, lens_u, lens_v, ray);
}

// The sample's value; black where it is bad, which is counted, or not the leaf's object.
static Rgb take_value(const Batch *batch, Sampler *sampler, LeafSums *sums)
{
    const Meter *m = batch->meter;
    Ray ray;
    AovSample aov = {.object = 0};
    IntegratorStats stats = {0};
    if (!leaf_ray(m, &batch->leaf->sight, sampler, &ray)) {
        return rgb_gray(0);
    }
    Rgb radiance = m->integrator->radiance(m->world, &ray, sampler, &aov, &stats);
    bool bad = !rgb_is_finite(radiance) || radiance.r < 0 || radiance.g < 0 || radiance.b < 0;
    sums->bad += bad;
    if (bad || (batch->seen && !batch->seen[aov.object])) {
        return rgb_gray(0);
    }
    return batch->leaf->coverage ? rgb_gray(1) : radiance;
}

static void take_sample(const Batch *batch, uint32_t replicate, uint32_t number, LeafSums *sums)
{
    Sampler sampler;
    sampler_start(&sampler, batch->meter->seed, replicate, 0, number);
    Rgb value = take_value(batch, &sampler, sums);
    add_value(sums, (const double[3]){(double)value.r, (double)value.g, (double)value.b});
}

static void take_chunk(void *context, uint64_t item, unsigned worker)
{
    (void)worker;
    const Batch *batch = context;
    uint32_t replicate = (uint32_t)(item / batch->chunks), chunk = (uint32_t)(item % batch->chunks);
    uint32_t begin = batch->from + chunk * CHUNK;
    uint32_t end = batch->to - begin < CHUNK ? batch->to : begin + CHUNK;
    for (uint32_t i = begin; i < end; ++i) {
        take_sample(batch, replicate, i, &batch->sums[item]);
    }
}

// Which objects are a leaf's, to be given back with mem_free; NULL without memory.
static uint8_t *find_seen(const Scene *scene, const char *name)
{
    const SceneNodeArray *shapes = &scene->nodes[CATEGORY_SHAPE];
    uint8_t *seen = mem_alloc_zeroed(shapes->count + 1, 1);
    for (size_t i = 0; seen && i < shapes->count; ++i) {
        seen[i + 1] = strcmp(scene->names.items[shapes->items[i].name], name) == 0;
    }
    return seen;
}

// Looks from where the leaf's rays start.
static void take_place(Meter *m, const Sight *sight)
{
    if (sight->kind == SIGHT_RAY) {
        m->world->camera_media = medium_around(m->world, sight->origin);
        return;
    }
    const int width = (int)m->film.width, height = (int)m->film.height;
    uint32_t id = sight->camera_id != NONE_ID ? sight->camera_id : m->scene->camera;
    if (id < m->scene->nodes[CATEGORY_CAMERA].count) {
        camera_prepare(&m->camera, m->scene, id, width, height);
    } else {
        camera_default(&m->camera, accel_bounds(m->world->accel), width, height);
    }
    world_set_camera(m->world, &m->camera);
}

static bool stopped(const Meter *m)
{
    return m->options.stop && atomic_load_explicit(m->options.stop, memory_order_relaxed) != 0;
}

// Adds samples [from, to) to the leaf's sums of each replicate. False without memory or at a stop.
static bool sample_leaf(Meter *m, const MeasureLeaf *leaf, uint32_t from, uint32_t to,
                        LeafSums sums[METER_REPLICATES])
{
    uint32_t chunks = (to - from + CHUNK - 1) / CHUNK;
    uint64_t count = (uint64_t)METER_REPLICATES * chunks;
    uint8_t *seen = leaf->sight.object ? find_seen(m->scene, leaf->sight.object) : NULL;
    LeafSums *parts = mem_alloc_zeroed(count, sizeof *parts);
    bool good = parts && (seen || !leaf->sight.object);
    if (good) {
        take_place(m, &leaf->sight);
        Batch batch = {m, leaf, seen, from, to, chunks, parts};
        parallel_for(count, m->options.threads, take_chunk, &batch, m->options.stop);
        good = !stopped(m);
    }
    for (uint64_t i = 0; good && i < count; ++i) {
        join_sums(&sums[i / chunks], &parts[i]);
    }
    mem_free(parts);
    mem_free(seen);
    return good;
}

// --- Formulas ------------------------------------------------------------------------------------

static double operate(MeasureOp op, double a, double b)
{
    switch (op) {
    case MEASURE_ADD:
        return a + b;
    case MEASURE_SUBTRACT:
        return a - b;
    case MEASURE_MULTIPLY:
        return a * b;
    default:
        return a / b;
    }
}

// The formula's value where leaf l has the mean means[l].
static void evaluate(const SceneMeasure *measure, const double (*means)[3], double (*values)[3],
                     double out[3])
{
    for (uint32_t i = 0; i < measure->step_count; ++i) {
        const MeasureStep *step = &measure->steps[i];
        for (int c = 0; c < 3; ++c) {
            switch (step->op) {
            case MEASURE_LEAF:
                values[i][c] = means[step->a][c];
                break;
            case MEASURE_CONSTANT:
                values[i][c] = step->constant[c];
                break;
            case MEASURE_LUMINANCE: {
                const double *v = values[step->a];
                values[i][c] = 0.2126 * v[0] + 0.7152 * v[1] + 0.0722 * v[2];
                break;
            }
            case MEASURE_CHANNEL:
                values[i][c] = values[step->a][step->b];
                break;
            default:
                values[i][c] = operate(step->op, values[step->a][c], values[step->b][c]);
            }
        }
    }
    memcpy(out, values[measure->step_count - 1], 3 * sizeof(double));
}

// One measurement under way.
typedef struct Measurement {
    Meter *meter;
    const SceneMeasure *measure;
    MeterResult *result;
    LeafSums (*sums)[METER_REPLICATES]; // by leaf
    double (*means)[3];                 // by leaf
    double (*values)[3];                // by step
    uint32_t taken;                     // samples of each replicate
    double level;                       // 1 - confidence of each interval
} Measurement;

// The mean of each leaf over all replicates but `left_out` (METER_REPLICATES: over all), and the
// formula's value there.
static void value_without(Measurement *m, int left_out, double out[3])
{
    for (uint32_t leaf = 0; leaf < m->measure->leaf_count; ++leaf) {
        for (int c = 0; c < 3; ++c) {
            double sum = 0;
            for (int r = 0; r < METER_REPLICATES; ++r) {
                sum += r == left_out ? 0 : m->sums[leaf][r].sum[c];
            }
            int replicates = METER_REPLICATES - (left_out < METER_REPLICATES);
            m->means[leaf][c] = sum / ((double)replicates * m->taken);
        }
    }
    evaluate(m->measure, (const double(*)[3])m->means, m->values, out);
}

// How far the value may be off because samples are whole ones: see meter.h.
static void find_grain(Measurement *m, const double whole[3], double grain[3])
{
    double off[3];
    for (uint32_t leaf = 0; leaf < m->measure->leaf_count; ++leaf) {
        LeafSums all = {0};
        for (int r = 0; r < METER_REPLICATES; ++r) {
            join_sums(&all, &m->sums[leaf][r]);
        }
        value_without(m, METER_REPLICATES, off);
        for (int c = 0; c < 3; ++c) {
            m->means[leaf][c] += 2 * (all.most[c] - all.least[c]) / (double)all.samples;
        }
        evaluate(m->measure, (const double(*)[3])m->means, m->values, off);
        for (int c = 0; c < 3; ++c) {
            grain[c] += fabs(off[c] - whole[c]);
        }
    }
}

// The jackknife's pseudo-values give the mean and its standard error.
static void estimate(Measurement *m)
{
    MeterResult *result = m->result;
    double whole[3], part[3], grain[3] = {0};
    Running pseudo[3] = {0};
    value_without(m, METER_REPLICATES, whole);
    find_grain(m, whole, grain);
    for (int r = 0; r < METER_REPLICATES; ++r) {
        value_without(m, r, part);
        for (int c = 0; c < 3; ++c) {
            running_add(&pseudo[c], METER_REPLICATES * whole[c] - (METER_REPLICATES - 1) * part[c]);
        }
    }
    double t = student_quantile(m->level, METER_REPLICATES - 1);
    for (uint32_t c = 0; c < result->channels; ++c) {
        result->mean[c] = pseudo[c].mean;
        double error = hypot(running_error(&pseudo[c]), grain[c]);
        result->half[c] = t * error + ROUNDING * fabs(pseudo[c].mean);
    }
}

// --- Verdicts ------------------------------------------------------------------------------------

// How far a channel's mean lies on the good side of the nearest limit; negative: on the bad one.
static double margin(const SceneMeasure *measure, uint32_t channel, double mean)
{
    double off = mean - measure->target[channel];
    switch (measure->relation) {
    case MEASURE_WITHIN:
        return measure->allowed - fabs(off);
    case MEASURE_BELOW:
        return -off;
    default:
        return off;
    }
}

static void judge(Measurement *m)
{
    MeterResult *result = m->result;
    bool met = true, not_met = false;
    double slowest = 1, quickest = INFINITY; // needed, as a multiple of what was taken
    for (uint32_t c = 0; c < result->channels; ++c) {
        double room = margin(m->measure, c, result->mean[c]), half = result->half[c];
        met = met && room >= half; // false for what is not a number, too
        not_met = not_met || room <= -half;
        double ratio = half / room, factor = room != 0 ? ratio * ratio : INFINITY;
        if (room > 0) {
            slowest = fmax(slowest, factor);
        } else {
            quickest = fmin(quickest, factor);
        }
    }
    result->verdict = met ? METER_MET : not_met ? METER_NOT_MET : METER_UNDECIDED;
    result->needed =
        (isfinite(quickest) ? quickest : slowest) * METER_REPLICATES * (double)m->taken;
}

// Each leaf counts: a formula of two takes twice the samples.
static uint64_t samples_of(const Measurement *m, uint32_t taken)
{
    return (uint64_t)METER_REPLICATES * taken * m->measure->leaf_count;
}

static bool take_more(Measurement *m, uint32_t to)
{
    for (uint32_t leaf = 0; leaf < m->measure->leaf_count; ++leaf) {
        if (!sample_leaf(m->meter, &m->measure->leaves[leaf], m->taken, to, m->sums[leaf])) {
            return false;
        }
    }
    m->taken = to;
    m->result->samples = samples_of(m, to);
    m->result->bad_samples = 0;
    for (uint32_t leaf = 0; leaf < m->measure->leaf_count; ++leaf) {
        for (int r = 0; r < METER_REPLICATES; ++r) {
            m->result->bad_samples += m->sums[leaf][r].bad;
        }
    }
    return true;
}

// Looks, takes as many samples again, …; true unless memory ran out.
static bool run(Measurement *m)
{
    uint64_t most = m->meter->most;
    double looks = 1;
    for (uint32_t taken = METER_FIRST; samples_of(m, taken) <= most / 2 && taken < 1u << 30;
         taken *= 2) {
        ++looks;
    }
    m->level = (1 - m->meter->confidence) / (looks * m->measure->channels);
    for (uint32_t to = METER_FIRST;; to *= 2) {
        if (!take_more(m, to)) {
            m->result->stopped = stopped(m->meter);
            return m->result->stopped;
        }
        estimate(m);
        judge(m);
        if (m->result->verdict != METER_UNDECIDED || --looks < 1) {
            return true;
        }
    }
}

bool meter_measure(Meter *meter, const SceneMeasure *measure, MeterResult *result)
{
    *result = (MeterResult){.verdict = METER_UNDECIDED,
                            .channels = measure->channels,
                            .confidence = meter->confidence,
                            .needed = INFINITY};
    Measurement m = {
        .meter = meter,
        .measure = measure,
        .result = result,
        .sums = mem_alloc_zeroed(measure->leaf_count, sizeof *m.sums),
        .means = mem_alloc_zeroed(measure->leaf_count, sizeof *m.means),
        .values = mem_alloc_zeroed(measure->step_count, sizeof *m.values),
    };
    bool good = m.sums && m.means && m.values && run(&m);
    mem_free(m.sums);
    mem_free(m.means);
    mem_free(m.values);
    return good;
}
