#include "render/furnace.h"

#include "base/mem.h"
#include "base/statistics.h"
#include "base/thread.h"
#include "render/sampler.h"

// Results are sums of floats.
static const double ROUNDING = 1e-5, RECIPROCITY_TOLERANCE = 1e-3, LEVEL = 1e-4;

// A place in the middle of nowhere, for what is asked of a single point.
static const Vec2 SOME_UV = {0.3, 0.6};

// --- The piece of material -----------------------------------------------------------------------

// Not to be copied: `point` refers to `surface`.
typedef struct Piece {
    Surface surface;
    ShadingPoint point;
} Piece;

// In the plane z = 0, its front upwards, seen from wo.
static void piece_seen_from(const World *world, uint32_t material, Vec2 uv, Vec3 wo, Piece *out)
{
    out->surface = (Surface){.p = {uv.x, uv.y, 0},
                             .geometric = {0, 0, 1},
                             .shading = {0, 0, 1},
                             .tangent = {1, 0, 0},
                             .bitangent = {0, 1, 0},
                             .object_p = {uv.x, uv.y, 0},
                             .uv = uv,
                             .color = {1, 1, 1},
                             .shape = NONE_ID,
                             .instance = NONE_ID,
                             .material = material,
                             .front = wo.z > 0};
    shading_point(world, &out->surface, neg(wo), &out->point);
}

static Vec3 direction(double cos_theta, double phi)
{
    double s = sqrt(fmax(0, 1 - cos_theta * cos_theta));
    return vec3(s * cos(phi), s * sin(phi), cos_theta);
}

// --- Albedo --------------------------------------------------------------------------------------

typedef struct Furnace {
    const World *world;
    uint32_t material;
    const FurnaceOptions *options;
    uint32_t samples; // of each replicate
    FurnaceReport *report;
} Furnace;

typedef struct Weights {
    double reflected[3], transmitted[3];
} Weights;

// Means of replicates and, for the grain, the range of the samples.
typedef struct Albedo {
    Running means[3];
    double least[3], most[3];
} Albedo;

static void albedo_see(Albedo *albedo, int channel, double value)
{
    albedo->least[channel] = fmin(albedo->least[channel], value);
    albedo->most[channel] = fmax(albedo->most[channel], value);
}

static double albedo_error(const Albedo *albedo, int channel, double samples)
{
    double grain = 2 * (albedo->most[channel] - albedo->least[channel]) / samples;
    return hypot(running_error(&albedo->means[channel]), grain);
}

// What one sample reflects or transmits; both are 0 where nothing is scattered.
static Weights take_sample(const Furnace *f, bool front, uint32_t angle, uint32_t replicate,
                           uint32_t number, double cos_theta, double fixed_phi)
{
    Weights weights = {0};
    Sampler sampler;
    sampler_start(&sampler, f->options->seed, replicate, 2 * angle + front, number);
    float u, v;
    Vec2 uv;
    sampler_2d(&sampler, &u, &v);
    float lobe = sampler_1d(&sampler), turn = sampler_1d(&sampler);
    uv.x = (double)sampler_1d(&sampler);
    uv.y = (double)sampler_1d(&sampler);
    double phi = fixed_phi >= 0 ? fixed_phi : 2 * PI * (double)turn;
    Vec3 wo = direction(front ? cos_theta : -cos_theta, phi);
    Piece piece;
    BsdfSample s;
    piece_seen_from(f->world, f->material, uv, wo, &piece);
    if (!material_sample(&piece.point, f->material, lobe, u, v, &s)) {
        return weights;
    }
    bool passes = (s.lobes & (LOBE_TRANSMIT | LOBE_PASS)) != 0;
    double squeeze = passes && !(s.lobes & LOBE_PASS) ? (double)s.eta * (double)s.eta : 1;
    double *to = passes ? weights.transmitted : weights.reflected;
    to[0] = squeeze * (double)s.weight.r;
    to[1] = squeeze * (double)s.weight.g;
    to[2] = squeeze * (double)s.weight.b;
    return weights;
}

// phi < 0: averaged over all azimuths.
static void measure_point(const Furnace *f, bool front, uint32_t number, double angle, double phi,
                          FurnacePoint *out)
{
    enum { REFLECTED, TRANSMITTED, TOTAL, KINDS };
    Albedo albedos[KINDS] = {0};
    for (int i = 0; i < KINDS * 3; ++i) {
        albedos[i / 3].least[i % 3] = INFINITY;
    }
    const double cos_theta = cos(angle);
    for (uint32_t r = 0; r < FURNACE_REPLICATES; ++r) {
        double sums[KINDS][3] = {{0}};
        for (uint32_t i = 0; i < f->samples; ++i) {
            Weights w = take_sample(f, front, number, r, i, cos_theta, phi);
            for (int c = 0; c < 3; ++c) {
                double parts[KINDS] = {w.reflected[c], w.transmitted[c],
                                       w.reflected[c] + w.transmitted[c]};
                for (int k = 0; k < KINDS; ++k) {
                    sums[k][c] += parts[k];
                    albedo_see(&albedos[k], c, parts[k]);
                }
            }
        }
        for (int i = 0; i < KINDS * 3; ++i) {
            running_add(&albedos[i / 3].means[i % 3], sums[i / 3][i % 3] / f->samples);
        }
    }
    out->angle = angle;
    double samples = (double)FURNACE_REPLICATES * f->samples;
    for (int c = 0; c < 3; ++c) {
        out->reflected[c] = albedos[REFLECTED].means[c].mean;
        out->transmitted[c] = albedos[TRANSMITTED].means[c].mean;
        out->total[c] = albedos[TOTAL].means[c].mean;
        out->reflected_error[c] = albedo_error(&albedos[REFLECTED], c, samples);
        out->transmitted_error[c] = albedo_error(&albedos[TRANSMITTED], c, samples);
        out->total_error[c] = albedo_error(&albedos[TOTAL], c, samples);
    }
}

static double angle_of(uint32_t i)
{
    return (i + 1 == FURNACE_ANGLES ? 89 : 2.5 * i) * PI / 180;
}

// The axes of anisotropy, beside the averages over azimuths: for the law of energy alone.
enum { AXIS_ANGLES = 4, AXES = 2, AXIS_POINTS = AXIS_ANGLES * AXES };
static const double AXIS_DEGREES[AXIS_ANGLES] = {10, 35, 60, 80};

typedef struct AlbedoWork {
    const Furnace *furnace;
    FurnacePoint axes[2][AXIS_POINTS];
    bool front;
} AlbedoWork;

static void measure_albedo(void *context, uint64_t item, unsigned worker)
{
    (void)worker;
    AlbedoWork *work = context;
    uint32_t i = (uint32_t)item;
    if (i < FURNACE_ANGLES) {
        measure_point(work->furnace, work->front, i, angle_of(i), -1,
                      &work->furnace->report->sides[!work->front][i]);
        return;
    }
    uint32_t axis = i - FURNACE_ANGLES;
    double angle = AXIS_DEGREES[axis / AXES] * PI / 180;
    measure_point(work->furnace, work->front, i, angle, PI / 2 * (axis % AXES),
                  &work->axes[!work->front][axis]);
}

// --- Whether the sides differ --------------------------------------------------------------------

// Of what is scattered: how much in each channel, and about where to.
enum { TRAITS = 5, TRAIT_SAMPLES = 128 };

static void add_traits(const Furnace *f, bool front, Sampler *sampler, double sum[TRAITS])
{
    float u, v;
    sampler_2d(sampler, &u, &v);
    float lobe = sampler_1d(sampler);
    double cos_theta = 0.05 + 0.9 * (double)sampler_1d(sampler);
    Piece piece;
    BsdfSample s;
    piece_seen_from(f->world, f->material, SOME_UV, direction(front ? cos_theta : -cos_theta, 0.4),
                    &piece);
    if (material_sample(&piece.point, f->material, lobe, u, v, &s)) {
        double weight = (double)luminance(s.weight);
        double traits[TRAITS] = {(double)s.weight.r, (double)s.weight.g, (double)s.weight.b,
                                 weight * fabs(s.wi.z), weight * s.wi.x};
        for (int i = 0; i < TRAITS; ++i) {
            sum[i] += traits[i];
        }
    }
}

// They don't where what they scatter is the same but for noise. What lets light through has two
// sides in any case.
static bool sides_differ(const Furnace *f)
{
    if (f->report->lobes & (LOBE_TRANSMIT | LOBE_PASS)) {
        return true;
    }
    Running means[2][TRAITS] = {0};
    for (uint32_t r = 0; r < FURNACE_REPLICATES; ++r) {
        for (int side = 0; side < 2; ++side) {
            double sum[TRAITS] = {0};
            for (uint32_t i = 0; i < TRAIT_SAMPLES; ++i) {
                Sampler sampler;
                sampler_start(&sampler, f->options->seed, r, 1000, i);
                add_traits(f, side == 0, &sampler, sum);
            }
            for (int i = 0; i < TRAITS; ++i) {
                running_add(&means[side][i], sum[i] / TRAIT_SAMPLES);
            }
        }
    }
    for (int i = 0; i < TRAITS; ++i) {
        const Running *a = &means[0][i], *b = &means[1][i];
        double noise = hypot(running_error(a), running_error(b));
        // Where both draw the same numbers they agree to the last digits; else, by chance alone,
        // one in a million differs by 6 errors.
        if (fabs(a->mean - b->mean) > 6 * noise + 1e-5) {
            return true;
        }
    }
    return false;
}

// --- Energy --------------------------------------------------------------------------------------

typedef struct EnergyJudge {
    FurnaceReport *report;
    double critical; // Student's t at the level of each comparison
    bool gained;
} EnergyJudge;

static void judge_point(EnergyJudge *judge, const FurnacePoint *point, bool front)
{
    FurnaceReport *report = judge->report;
    FurnaceExtreme here = {.value = -1, .angle = point->angle, .front = front};
    for (int c = 0; c < 3; ++c) {
        double error = point->total_error[c];
        judge->gained |= point->total[c] - judge->critical * error > 1 + ROUNDING;
        if (point->total[c] > here.value) {
            here.value = point->total[c];
            here.error = error;
        }
    }
    report->most = here.value > report->most.value ? here : report->most;
    report->least = here.value < report->least.value ? here : report->least;
}

static void judge_energy(const AlbedoWork *work, FurnaceReport *report)
{
    int sides = report->both_sides ? 2 : 1;
    double comparisons = 3.0 * sides * (FURNACE_ANGLES + AXIS_POINTS);
    EnergyJudge judge = {
        report, student_quantile(2 * sidak(LEVEL, comparisons), FURNACE_REPLICATES - 1), false};
    report->most.value = -INFINITY;
    report->least.value = INFINITY;
    for (int side = 0; side < sides; ++side) {
        for (int i = 0; i < FURNACE_ANGLES; ++i) {
            judge_point(&judge, &report->sides[side][i], side == 0);
        }
        for (int i = 0; i < AXIS_POINTS; ++i) {
            judge_point(&judge, &work->axes[side][i], side == 0);
        }
    }
    report->energy = judge.gained ? FURNACE_BROKEN : FURNACE_HOLDS;
}

// --- Reciprocity ---------------------------------------------------------------------------------

static double eta_of(const World *world, uint32_t material, Vec3 w)
{
    Medium medium;
    return !material_medium(world, material, &medium) ? 1 : w.z > 0 ? medium.outside : medium.ior;
}

// f(o, i) / eta_o², as its luminance.
static double transported(const Furnace *f, Vec3 o, Vec3 i)
{
    Piece piece;
    piece_seen_from(f->world, f->material, SOME_UV, o, &piece);
    double value = (double)luminance(material_eval(&piece.point, f->material, i).value);
    double eta = eta_of(f->world, f->material, o);
    return value / (fabs(i.z) * eta * eta);
}

// Half of the pairs are drawn evenly, the others by the material, since it may scatter into small
// cones.
static bool draw_pair(const Furnace *f, uint32_t number, Vec3 *o, Vec3 *i)
{
    Sampler sampler;
    sampler_start(&sampler, f->options->seed, FURNACE_REPLICATES, 0, number);
    float n[5];
    for (int k = 0; k < 5; ++k) {
        n[k] = sampler_1d(&sampler);
    }
    bool down = f->report->both_sides && number % 4 >= 2;
    *o = direction(down ? -(double)n[0] : (double)n[0], 2 * PI * (double)n[1]);
    bool across = f->report->lobes & LOBE_TRANSMIT && number % 8 >= 4;
    *i = direction(copysign((double)n[2], across ? -o->z : o->z), 2 * PI * (double)n[3]);
    if (number % 2) {
        Piece piece;
        BsdfSample s;
        piece_seen_from(f->world, f->material, SOME_UV, *o, &piece);
        if (!material_sample(&piece.point, f->material, n[4], n[2], n[3], &s) ||
            s.lobes & (LOBE_DELTA | LOBE_PASS)) {
            return false;
        }
        *i = from_local(&piece.point.frame, s.wi);
    }
    return fabs(o->z) > 1e-3 && fabs(i->z) > 1e-3;
}

static void test_reciprocity(const Furnace *f)
{
    FurnaceReport *report = f->report;
    if (!(report->lobes & LOBE_SMOOTH)) {
        return;
    }
    double largest = 0;
    for (int pass = 0; pass < 2; ++pass) { // the second knows what is too little to matter
        for (uint32_t k = 0; k < FURNACE_PAIRS; ++k) {
            Vec3 o, i;
            if (!draw_pair(f, k, &o, &i)) {
                continue;
            }
            double there = transported(f, o, i), back = transported(f, i, o);
            double most = fmax(there, back);
            if (pass == 0) {
                largest = fmax(largest, most);
            } else if (most > 1e-6 * largest) {
                report->asymmetry = fmax(report->asymmetry, fabs(there - back) / most);
            }
        }
    }
    report->reciprocity =
        report->asymmetry <= RECIPROCITY_TOLERANCE ? FURNACE_HOLDS : FURNACE_BROKEN;
}

// --- Sampling ------------------------------------------------------------------------------------

// Fine cells see narrow lobes, coarse ones (BLOCK² of them) what is wrong over wide ones.
enum { ROWS = 80, COLUMNS = 160, CELLS = ROWS * COLUMNS, TRIES = 50000, FINEST = 64 };
enum { BLOCK = 8, BLOCKS = CELLS / (BLOCK * BLOCK) };

typedef struct SamplingWork {
    const Furnace *furnace;
    double p[6];
    bool no_memory[6];
} SamplingWork;

// The density's integral over a cell of equal θ and φ by the midpoint rule on `steps`² parts.
static double mass_by_steps(const Piece *piece, uint32_t material, int cell, int steps)
{
    int row = cell / COLUMNS, column = cell % COLUMNS;
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
        double theta = PI * (row + (i + 0.5) / steps) / ROWS;
        for (int j = 0; j < steps; ++j) {
            double phi = 2 * PI * (column + (j + 0.5) / steps) / COLUMNS;
            sum += sin(theta) *
                   (double)material_eval(&piece->point, material, direction(cos(theta), phi)).pdf;
        }
    }
    return sum * (PI / ROWS) * (2 * PI / COLUMNS) / (steps * steps);
}

// As fine as the count in it calls for.
static double cell_mass(const Piece *piece, uint32_t material, int cell, double observed)
{
    double mass = mass_by_steps(piece, material, cell, 2);
    if (observed == 0 && mass * TRIES < 0.1) {
        return mass;
    }
    for (int steps = 4; steps <= FINEST; steps *= 2) {
        double finer = mass_by_steps(piece, material, cell, steps);
        bool close = fabs(finer - mass) * TRIES < 0.05 * sqrt(fmax(finer * TRIES, 1));
        mass = finer;
        if (close) {
            break;
        }
    }
    return mass;
}

// Counts the cells of sampled directions; returns how many there were, delta lobes left out.
static double count_directions(const Furnace *f, const Piece *piece, uint32_t number,
                               double *observed)
{
    double count = 0;
    for (uint32_t i = 0; i < TRIES; ++i) {
        Sampler sampler;
        // Independent numbers, as the test wants them: a sequence of its own for each.
        sampler_start(&sampler, f->options->seed, i, FURNACE_REPLICATES + 1 + number, 0);
        float u, v;
        sampler_2d(&sampler, &u, &v);
        BsdfSample s;
        if (!material_sample(&piece->point, f->material, sampler_1d(&sampler), u, v, &s) ||
            s.lobes & (LOBE_DELTA | LOBE_PASS)) {
            continue;
        }
        double phi = atan2(s.wi.y, s.wi.x);
        int row = (int)(acos(fmin(fmax(s.wi.z, -1), 1)) / PI * ROWS);
        int column = (int)((phi < 0 ? phi + 2 * PI : phi) / (2 * PI) * COLUMNS);
        row = row < ROWS ? row : ROWS - 1;
        column = column < COLUMNS ? column : COLUMNS - 1;
        observed[row * COLUMNS + column] += 1;
        ++count;
    }
    return count;
}

// Both grids' p-values together.
static double both_grids(const double *observed, const double *expected)
{
    double coarse[2][BLOCKS] = {{0}};
    for (int cell = 0; cell < CELLS; ++cell) {
        int block = cell / COLUMNS / BLOCK * (COLUMNS / BLOCK) + cell % COLUMNS / BLOCK;
        coarse[0][block] += observed[cell];
        coarse[1][block] += expected[cell];
    }
    double fine = chi_squared_test(observed, expected, CELLS);
    return fmin(1, 2 * fmin(fine, chi_squared_test(coarse[0], coarse[1], BLOCKS)));
}

// Pearson's test of the directions among those that were scattered, and that as many are scattered
// as the density says.
static double sampling_p(const Furnace *f, const Piece *piece, uint32_t number, double *observed,
                         double *expected)
{
    double count = count_directions(f, piece, number, observed), sum = 0;
    for (int cell = 0; cell < CELLS; ++cell) {
        expected[cell] = TRIES * cell_mass(piece, f->material, cell, observed[cell]);
        sum += expected[cell];
    }
    double deviation = sqrt(fmax(count * (1 - count / TRIES), 0));
    if (fabs(sum - count) > 5 * deviation + 0.01 * TRIES || (sum <= 0 && count > 0)) {
        return 0;
    }
    for (int cell = 0; cell < CELLS; ++cell) {
        expected[cell] = fmax(expected[cell] * count / sum, 1e-9);
    }
    return count > 0 ? both_grids(observed, expected) : 1;
}

static void test_directions(void *context, uint64_t item, unsigned worker)
{
    (void)worker;
    static const double DEGREES[3] = {5, 45, 75};
    SamplingWork *work = context;
    const Furnace *f = work->furnace;
    double *observed = mem_alloc_zeroed(CELLS, sizeof *observed);
    double *expected = mem_alloc_zeroed(CELLS, sizeof *expected);
    work->no_memory[item] = !observed || !expected;
    if (!work->no_memory[item]) {
        double cos_theta = cos(DEGREES[item % 3] * PI / 180);
        Piece piece;
        piece_seen_from(f->world, f->material, SOME_UV,
                        direction(item >= 3 ? -cos_theta : cos_theta, 0.7), &piece);
        work->p[item] = sampling_p(f, &piece, (uint32_t)item, observed, expected);
    }
    mem_free(observed);
    mem_free(expected);
}

static bool test_sampling(const Furnace *f)
{
    FurnaceReport *report = f->report;
    if (!(report->lobes & LOBE_SMOOTH)) {
        return true;
    }
    SamplingWork work = {.furnace = f};
    uint64_t count = report->both_sides ? 6 : 3;
    parallel_for(count, f->options->threads, test_directions, &work, f->options->stop);
    double least = 1;
    for (uint64_t i = 0; i < count; ++i) {
        if (work.no_memory[i]) {
            return false;
        }
        least = fmin(least, work.p[i]);
    }
    report->sampling_p = -expm1((double)count * log1p(-fmin(least, 1 - 1e-12)));
    report->sampling = report->sampling_p >= LEVEL ? FURNACE_HOLDS : FURNACE_BROKEN;
    return true;
}

// --- Together ------------------------------------------------------------------------------------

// The first that the kind, or one of the materials within, says. Materials refer to ones before
// them.
static const char *find_caveat(const World *world, uint32_t material)
{
    const WorldMaterial *m = world_material(world, material);
    const char *caveat = m->class->caveat;
    for (size_t i = 0; !caveat && i < m->class->node.param_count; ++i) {
        const Param *param = &m->class->node.params[i];
        uint32_t inner = NONE_ID;
        if (param->type == PARAM_NODE && param->category == CATEGORY_MATERIAL) {
            memcpy(&inner, (const char *)m->params + param->offset, sizeof inner);
        }
        caveat = inner != NONE_ID ? find_caveat(world, inner) : NULL;
    }
    return caveat;
}

static bool stopped(const Furnace *f)
{
    return f->options->stop && atomic_load_explicit(f->options->stop, memory_order_relaxed) != 0;
}

bool furnace_measure(const World *world, uint32_t material, const FurnaceOptions *options,
                     FurnaceReport *out)
{
    FurnaceOptions own = *options;
    own.threads = options->threads ? options->threads : thread_processor_count();
    int64_t samples = options->samples > 0 ? options->samples : FURNACE_SAMPLES;
    *out = (FurnaceReport){.lobes = material_lobes(world, material),
                           .caveat = find_caveat(world, material)};
    Furnace f = {world, material, &own,
                 (uint32_t)fmax(1, ceil((double)samples / FURNACE_REPLICATES)), out};
    out->both_sides = sides_differ(&f);
    AlbedoWork work = {.furnace = &f};
    for (int side = 0; side <= out->both_sides; ++side) {
        work.front = side == 0;
        parallel_for(FURNACE_ANGLES + AXIS_POINTS, own.threads, measure_albedo, &work, own.stop);
    }
    bool good = stopped(&f) || test_sampling(&f);
    if (good && !stopped(&f)) {
        judge_energy(&work, out);
        test_reciprocity(&f);
    }
    out->stopped = stopped(&f);
    return good;
}
