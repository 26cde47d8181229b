// Light transport against numbers that were derived on paper.
#include "paired.h"

#include "base/mem.h"

typedef struct Lab {
    SceneMaker maker;
    World *world;
} Lab;

static CheckTable table;

static void open_lab(Lab *lab)
{
    maker_init(&lab->maker);
    lab->world = NULL;
}

// Makes the world ready with a bounce limit.
static World *build(Lab *lab, int64_t bounces)
{
    world_free(lab->world);
    lab->world = world_build(&lab->maker.scene, 1, &lab->maker.sink);
    if (!lab->world) {
        for (uint32_t i = 0; i < lab->maker.sink.count; ++i) {
            fprintf(stderr, "%s\n", lab->maker.sink.items[i].message);
        }
        abort();
    }
    lab->world->bounces = bounces;
    lab->world->russian_roulette = false; // the one source of noise in many of these scenes
    return lab->world;
}

static void close_lab(Lab *lab)
{
    world_free(lab->world);
    maker_free(&lab->maker);
}

// --- Rays ---------------------------------------------------------------------------------------

static Vec3 sphere_direction(float u, float v)
{
    double z = 1 - 2 * (double)u, phi = 2 * PI * (double)v, s = sqrt(fmax(0, 1 - z * z));
    return vec3(s * cos(phi), s * sin(phi), z);
}

// From one point in all directions.
static double all_around(const void *context, const float n[4], Ray *ray)
{
    ray->origin = *(const Vec3 *)context;
    ray->direction = sphere_direction(n[0], n[1]);
    return 1;
}

// One ray.
static double single_ray(const void *context, const float n[4], Ray *ray)
{
    (void)n;
    const Ray *fixed = context;
    ray->origin = fixed->origin;
    ray->direction = normalize(fixed->direction);
    return 1;
}

// Down on a point of a horizontal Lambert surface: the weight makes irradiance of radiance.
typedef struct Meter {
    Vec3 at;
    double size; // of a square about it (0: the point itself)
    double albedo;
} Meter;

static double meter(const void *context, const float n[4], Ray *ray)
{
    const Meter *m = context;
    double x = m->size * ((double)n[0] - 0.5), z = m->size * ((double)n[1] - 0.5);
    ray->origin = add(m->at, vec3(x, 1e-3, z));
    ray->direction = vec3(0, -1, 0);
    return PI / m->albedo;
}

// At a point of a cube's inner walls, uniform by area; the cube is centred at the origin.
static double wall_meter(const void *context, const float n[4], Ray *ray)
{
    const Meter *m = context;
    double half = m->size / 2, a = m->size * ((double)n[0] - 0.5),
           b = m->size * ((double)n[1] - 0.5);
    int face = (int)(6 * n[2]);
    double side = face < 3 ? half : -half, inset = side * (1 - 1e-4);
    Vec3 p[3] = {{inset, a, b}, {b, inset, a}, {a, b, inset}};
    Vec3 d[3] = {{side, 0, 0}, {0, side, 0}, {0, 0, side}};
    ray->origin = p[face % 3];
    ray->direction = normalize(d[face % 3]);
    return PI / m->albedo;
}

// --- Checks -------------------------------------------------------------------------------------

// 1. In a closed room that emits Le and reflects ρ everywhere, light that was scattered k times
// adds Le ρ^k: L = Le (1 - ρ^(n + 1)) / (1 - ρ) for at most n scatterings, Le / (1 - ρ) for all
// (what is lost beyond 100 is 2e-10).
static void furnace(const char *shape, double albedo, int64_t bounces, double expected,
                    uint32_t samples)
{
    char name[64];
    Lab lab;
    open_lab(&lab);
    uint32_t white = PUT(&lab.maker, "lambert", {"color", {albedo}});
    uint32_t room =
        strcmp(shape, "sphere") == 0
            ? PUT_LIGHT_SHAPE(&lab.maker, "sphere", {"radius", {2}}, {"material", {white}})
            : PUT_LIGHT_SHAPE(&lab.maker, "box", {"min", {-1, -2, -1}}, {"max", {2, 1, 1}},
                              {"material", {white}});
    PUT(&lab.maker, "area_light", {"shape", {room}}, {"radiance", {1}}, {"two_sided", {1}});
    Vec3 from = vec3(0.3, 0.2, -0.4);
    if (!NEAR(expected, (1 - pow(albedo, (double)bounces + 1)) / (1 - albedo), 1e-8)) {
        abort();
    }
    snprintf(name, sizeof name, "1 furnace, %s, albedo %g, %lld bounces", shape, albedo,
             (long long)bounces);
    check_mean(&table, name, expected,
               estimate(build(&lab, bounces), all_around, &from, samples, 1), 1.5e-3);
    close_lab(&lab);
}

// The same with paths ended by roulette: noisy, but right.
static void furnace_with_roulette(void)
{
    Lab lab;
    open_lab(&lab);
    uint32_t white = PUT(&lab.maker, "lambert", {"color", {0.5}});
    uint32_t room = PUT_LIGHT_SHAPE(&lab.maker, "sphere", {"radius", {2}}, {"material", {white}});
    PUT(&lab.maker, "area_light", {"shape", {room}}, {"radiance", {1}}, {"two_sided", {1}});
    Vec3 from = vec3(0.3, 0.2, -0.4);
    build(&lab, 1000)->russian_roulette = true;
    check_mean(&table, "1 furnace, sphere, with roulette", 2,
               estimate(lab.world, all_around, &from, 1 << 16, 7), 1e-3);
    close_lab(&lab);
}

// 2. The inside of a unit sphere of albedo 1/2 shows L = 1 for each of three lights.
static void lit_sphere(void)
{
    for (int kind = 0; kind < 3; ++kind) {
        static const char *const NAMES[] = {"2 unit sphere, point light pi",
                                            "2 unit sphere, four of pi/4",
                                            "2 unit sphere, Le = 1/2"};
        Lab lab;
        open_lab(&lab);
        uint32_t half = PUT(&lab.maker, "lambert", {"color", {0.5}});
        if (kind == 2) {
            uint32_t shape =
                PUT_LIGHT_SHAPE(&lab.maker, "sphere", {"radius", {1}}, {"material", {half}});
            PUT(&lab.maker, "area_light", {"shape", {shape}}, {"radiance", {0.5}},
                {"two_sided", {1}});
        } else {
            PUT(&lab.maker, "sphere", {"radius", {1}}, {"material", {half}});
            for (int i = 0; i < (kind == 0 ? 1 : 4); ++i) {
                PUT(&lab.maker, "point_light", {"position", {0, 0, 0}},
                    {"intensity", {kind == 0 ? PI : PI / 4}});
            }
        }
        Vec3 from = vec3(0.1, -0.5, 0.2);
        check_mean(&table, NAMES[kind], 1, estimate(build(&lab, 40), all_around, &from, 1 << 6, 3),
                   1e-3);
        close_lab(&lab);
    }
}

// 3. Mean irradiance in a closed room: Φ / A of direct light, and ρ times as much with each
// scattering, Φ / (A (1 - ρ)) in all; 4 m cube, 10 klm.
static void closed_room(void)
{
    static const int64_t BOUNCES[] = {1, 8, 30};
    for (int i = 0; i < 3; ++i) {
        char name[64];
        Lab lab;
        open_lab(&lab);
        uint32_t half = PUT(&lab.maker, "lambert", {"color", {0.5}});
        PUT(&lab.maker, "box", {"min", {-2, -2, -2}}, {"max", {2, 2, 2}}, {"material", {half}});
        PUT(&lab.maker, "point_light", {"position", {0.2, 0.1, -0.3}},
            {"power", {10000}, .dim = DIM_LUMINOUS_FLUX});
        Meter walls = {.size = 4, .albedo = 0.5 / 683};
        build(&lab, BOUNCES[i])->russian_roulette = i == 2;
        Running lux = estimate(lab.world, wall_meter, &walls, 1u << (i == 0 ? 14 : 15), 4);
        snprintf(name, sizeof name, "3 closed room, lux, %lld bounces", (long long)BOUNCES[i]);
        check_mean(&table, name, 10000.0 / 96 * (1 - pow(0.5, (double)BOUNCES[i])) / 0.5, lux,
                   i == 0 ? 1e-3 : 3e-3);
        close_lab(&lab);
    }
}

// A hemispherical bowl of albedo ρ, open upwards to a uniform sky, seen from its edge level or
// above: of light that leaves a point of it, the part f = 1/2 falls upon the bowl again (1 - the
// opening's share, π R² / 2π R²), and so does that of what it is lit by, uniformly (Jacques 1955):
// L / Lsky = ρ (1 - f) / (1 - ρ f).
static double into_the_bowl(const void *context, const float n[4], Ray *ray)
{
    (void)context;
    // From above, uniform over the opening; downwards by the cosine.
    double r = sqrt((double)n[0]) * 0.999, a = 2 * PI * (double)n[1];
    double s = sqrt((double)n[2]), b = 2 * PI * (double)n[3], c = sqrt(1 - s * s);
    ray->direction = vec3(s * cos(b), -c, s * sin(b));
    ray->origin = add_scaled(vec3(r * cos(a), 0, r * sin(a)), ray->direction, -0.01);
    return 1;
}

// A mesh: a sphere can't be cut open. Its flat pieces lie within 4e-5 of the sphere.
static void put_bowl(SceneMaker *maker, uint32_t material)
{
    enum { ROWS = 128, COLUMNS = 512 };
    Vec3 *v = arena_array(&maker->arena, (ROWS + 1) * COLUMNS, sizeof *v);
    uint32_t *f = arena_array(&maker->arena, ROWS * COLUMNS * 6, sizeof *f), count = 0;
    for (uint32_t i = 0; i <= ROWS; ++i) {
        for (uint32_t j = 0; j < COLUMNS; ++j) {
            double theta = PI / 2 * i / ROWS, phi = 2 * PI * j / COLUMNS;
            v[i * COLUMNS + j] = vec3(sin(theta) * cos(phi), -cos(theta), sin(theta) * sin(phi));
        }
    }
    for (uint32_t i = 0; i < ROWS; ++i) {
        for (uint32_t j = 0; j < COLUMNS; ++j) {
            uint32_t a = i * COLUMNS + j, b = i * COLUMNS + (j + 1) % COLUMNS;
            const uint32_t two[6] = {a, b + COLUMNS, b, a, a + COLUMNS, b + COLUMNS};
            for (uint32_t k = i == 0 ? 3 : 0; k < 6; ++k) {
                f[count++] = two[k];
            }
        }
    }
    PUT(maker, "mesh", {"vertices", .list = v, .count = (ROWS + 1) * COLUMNS},
        {"faces", .list = f, .count = count}, {"smooth", {0}}, {"material", {material}});
}

// 4. It isn't a furnace: it catches wrong directions that a furnace lets pass.
static void bowl(void)
{
    static const double ALBEDOS[] = {0.5, 0.8};
    for (int i = 0; i < 2; ++i) {
        char name[64];
        Lab lab;
        open_lab(&lab);
        uint32_t white = PUT(&lab.maker, "lambert", {"color", {ALBEDOS[i]}});
        put_bowl(&lab.maker, white);
        PUT(&lab.maker, "environment_light", {"radiance", {1}});
        snprintf(name, sizeof name, "4 bowl under the sky, albedo %g", ALBEDOS[i]);
        check_mean(&table, name, i == 0 ? 1.0 / 3 : 2.0 / 3,
                   estimate(build(&lab, 60), into_the_bowl, NULL, 1 << 14, 8), 8e-3);
        close_lab(&lab);
    }
}

// 6. A Lambert sphere in directional light at phase α: the mean radiance of its disc is
// (2ρE / 3π²) (sin α + (π - α) cos α); E ρ / π of it is a surface that faces the light.
static double at_the_disc(const void *context, const float n[4], Ray *ray)
{
    (void)context;
    double r = sqrt((double)n[0]), a = 2 * PI * (double)n[1];
    ray->origin = vec3(r * cos(a), r * sin(a), 5);
    ray->direction = vec3(0, 0, -1);
    return 1;
}

static void phases(void)
{
    for (int degrees = 0; degrees < 180; degrees += 50) {
        char name[64];
        Lab lab;
        open_lab(&lab);
        double a = degrees * PI / 180;
        uint32_t white = PUT(&lab.maker, "lambert", {"color", {0.8}});
        PUT(&lab.maker, "sphere", {"radius", {1}}, {"material", {white}});
        PUT(&lab.maker, "directional_light", {"direction", {-sin(a), 0, -cos(a)}},
            {"irradiance", {10}});
        snprintf(name, sizeof name, "6 Lambert sphere, phase %d degrees", degrees);
        check_mean(&table, name, 2 * 0.8 * 10 / (3 * PI * PI) * (sin(a) + (PI - a) * cos(a)),
                   estimate(build(&lab, 1), at_the_disc, NULL, 1 << 14, 9), 1e-3);
        close_lab(&lab);
    }
}

// 5. White things in uniform surroundings can't be seen.
static void white_in_white(void)
{
    Lab lab;
    open_lab(&lab);
    uint32_t white = PUT(&lab.maker, "lambert", {"color", {1}});
    PUT(&lab.maker, "sphere", {"center", {0, 0, 0}}, {"radius", {1}}, {"material", {white}});
    PUT(&lab.maker, "sphere", {"center", {1.4, 0.3, 0}}, {"radius", {0.6}}, {"material", {white}});
    PUT(&lab.maker, "disc", {"center", {0, -1.2, 0}}, {"normal", {0, 1, 0}}, {"radius", {3}},
        {"material", {white}});
    PUT(&lab.maker, "environment_light", {"radiance", {1}});
    Ray ray = {.origin = {0, 0.3, 6}, .direction = {0.75, -0.25, -6}};
    check_mean(&table, "5 white Lambert in uniform surroundings", 1,
               estimate(build(&lab, 10000), single_ray, &ray, 1 << 15, 6), 1e-3);
    close_lab(&lab);
}

// 7. Light sampling, BSDF sampling and both have one mean; so have roulette on and off.
static void sampling_strategies(void)
{
    Lab lab;
    open_lab(&lab);
    SceneMaker *m = &lab.maker;
    uint32_t white = PUT(m, "lambert", {"color", {0.8}}), red = PUT(m, "lambert", {"color", {0.6}});
    uint32_t checker = PUT(m, "checker", {"a", {6}}, {"b", {3}}, {"scale", {2, 2, 0}});
    uint32_t glow = PUT(m, "emissive", {"radiance", {checker}, .texture = true}, {"base", {white}});
    PUT(m, "rectangle", {"corner", {-2, -2, -2}}, {"u", {0, 0, 4}}, {"v", {4, 0, 0}},
        {"material", {white}});
    PUT(m, "rectangle", {"corner", {-2, -2, -2}}, {"u", {4, 0, 0}}, {"v", {0, 4, 0}},
        {"material", {red}});
    PUT(m, "rectangle", {"corner", {-1.9, 1.9, -1.9}}, {"u", {3, 0, 0}}, {"v", {0, 0, 3}},
        {"material", {glow}});
    PUT(m, "sphere", {"center", {0.5, -1, 0}}, {"radius", {1}}, {"material", {red}});
    PUT(m, "sphere", {"center", {-1.2, -1.5, 0.8}}, {"radius", {0.5}}, {"material", {glow}});
    uint32_t sky = PUT(m, "checker", {"a", {1.5}}, {"b", {0.5}}, {"scale", {6, 3, 0}});
    PUT(m, "environment_light", {"radiance", {sky}, .texture = true});
    Ray ray = {.origin = {0, 0, 6}, .direction = {-0.1, -1.9, -5}};
    static const Way ROULETTE = {"roulette", &path_integrator, SAMPLING_MIS, true};
    static Rivals rivals;
    rivals = (Rivals){.world = build(&lab, 3),
                      .ray = single_ray,
                      .context = &ray,
                      .first = MIS,
                      .samples = 1 << 15,
                      .seconds = 200};
    rivals_compare(&table, &rivals, "7 light sampling = mis", &LIGHT, 1.2e-2);
    rivals_compare(&table, &rivals, "7 BSDF sampling = mis", &BSDF, 8e-3);
    rivals = (Rivals){.world = build(&lab, 8),
                      .ray = single_ray,
                      .context = &ray,
                      .first = MIS,
                      .samples = 1 << 14,
                      .seconds = 200};
    rivals_compare(&table, &rivals, "7 roulette on = off", &ROULETTE, 8e-3);
    close_lab(&lab);
}

// 9. A point light over a Lambert plane, no noise at all.
static int point_light(void)
{
    double worst = 0;
    Lab lab;
    open_lab(&lab);
    uint32_t grey = PUT(&lab.maker, "lambert", {"color", {0.7}});
    PUT(&lab.maker, "plane", {"material", {grey}});
    PUT(&lab.maker, "point_light", {"position", {0, 1.5, 0}}, {"intensity", {4}});
    build(&lab, 1);
    for (double x = 0; x <= 4; x += 0.5) {
        Ray ray = ray_make(vec3(x, 3, 1), normalize(vec3(0, -3, -1)), 0, INFINITY);
        Sampler sampler;
        IntegratorStats stats = {0};
        sampler_start(&sampler, 0, 0, 0, 0);
        Rgb found = path_integrator.radiance(lab.world, &ray, &sampler, NULL, &stats);
        double expected = 0.7 / PI * 4 * 1.5 / pow(1.5 * 1.5 + x * x, 1.5);
        worst = fmax(worst, fabs((double)found.g / expected - 1));
    }
    close_lab(&lab);
    return !trust_at_most("9 point light over a plane, relative error", 1e-6, worst);
}

// 8. Between two mirrors that reflect R the k-th image of a wall of radiance L has L R^k: in the
// unfolded corridor a ray crosses k mirrors on its way.
static int mirror_corridor(void)
{
    int failures = 0;
    Lab lab;
    open_lab(&lab);
    uint32_t mirror = PUT(&lab.maker, "mirror", {"color", {0.7}});
    uint32_t glow = PUT(&lab.maker, "emissive", {"radiance", {3}});
    PUT(&lab.maker, "rectangle", {"corner", {0, -50, -50}}, {"u", {0, 100, 0}}, {"v", {0, 0, 100}},
        {"material", {mirror}});
    PUT(&lab.maker, "rectangle", {"corner", {1, -50, -50}}, {"u", {0, 0, 100}}, {"v", {0, 100, 0}},
        {"material", {mirror}});
    PUT(&lab.maker, "rectangle", {"corner", {-5, -5, -40}}, {"u", {10, 0, 0}}, {"v", {0, 10, 0}},
        {"material", {glow}});
    build(&lab, 20);
    for (int k = 0; k <= 8; ++k) {
        char name[64];
        Ray ray = ray_make(vec3(0.5, 0, 0), normalize(vec3(k, 0, -40)), 0, INFINITY);
        Sampler sampler;
        IntegratorStats stats = {0};
        sampler_start(&sampler, 0, 0, 0, 0);
        const double expected = 3 * pow(0.7, k);
        Rgb found = path_integrator.radiance(lab.world, &ray, &sampler, NULL, &stats);
        snprintf(name, sizeof name, "8 mirror corridor, image %d", k);
        failures += !trust_near(name, expected, (double)found.g, 1e-6 * expected);
    }
    close_lab(&lab);
    return failures;
}

// The irradiance at a point of the plane y = 0 under lights that `lab` holds, by each way of
// sampling.
static void irradiance_checks(Lab *lab, const char *what, Meter at, double expected,
                              uint32_t samples, uint32_t bsdf_samples)
{
    static const char *const WAYS[] = {"mis", "light", "bsdf"};
    for (int sampling = 0; sampling < (bsdf_samples ? 3 : 2); ++sampling) {
        uint32_t count = sampling == SAMPLING_BSDF ? bsdf_samples : samples;
        char name[64];
        snprintf(name, sizeof name, "%s, %s", what, WAYS[sampling]);
        build(lab, 1)->sampling = sampling;
        check_mean(&table, name, expected,
                   estimate(lab->world, meter, &at, count, 30 + (uint32_t)sampling), 1.5e-3);
    }
}

static void put_ground(Lab *lab)
{
    uint32_t grey = PUT(&lab->maker, "lambert", {"color", {0.5}});
    PUT(&lab->maker, "plane", {"material", {grey}});
}

// 10 to 12. Area lights over a plane; E is over the radiance 1.
static void area_lights(void)
{
    Lab lab;
    open_lab(&lab);
    put_ground(&lab);
    uint32_t shape = PUT_LIGHT_SHAPE(&lab.maker, "rectangle", {"corner", {-0.5, 1, -0.5}},
                                     {"u", {1, 0, 0}}, {"v", {0, 0, 1}});
    PUT(&lab.maker, "area_light", {"shape", {shape}}, {"radiance", {1}});
    Meter at = {.albedo = 0.5};
    // Four times a rectangle seen from below its corner: the formula of configuration factors.
    double x = 0.5 / sqrt(1.25), square = 4 * x * atan(x);
    irradiance_checks(&lab, "10 square light", at, square, 1 << 12, 1 << 16);
    at.size = 1;
    irradiance_checks(&lab, "12 parallel squares", at, PI * 0.199824896, 1 << 15, 0);
    close_lab(&lab);

    static const double FACTORS[] = {0.5, 0.2763932, 0.0527864};
    for (int i = 0; i < 3; ++i) {
        char name[64];
        open_lab(&lab);
        put_ground(&lab);
        shape = PUT_LIGHT_SHAPE(&lab.maker, "disc", {"center", {i, 1, 0}}, {"normal", {0, -1, 0}},
                                {"radius", {1}});
        PUT(&lab.maker, "area_light", {"shape", {shape}}, {"radiance", {1}});
        snprintf(name, sizeof name, "10 disc light, x = %d", i);
        irradiance_checks(&lab, name, (Meter){.albedo = 0.5}, PI * FACTORS[i], 1 << 12,
                          1u << (i == 2 ? 18 : 16));
        close_lab(&lab);
    }

    open_lab(&lab);
    put_ground(&lab);
    shape = PUT_LIGHT_SHAPE(&lab.maker, "sphere", {"center", {2, 3, 0}}, {"radius", {1}});
    PUT(&lab.maker, "area_light", {"shape", {shape}}, {"radiance", {1}});
    irradiance_checks(&lab, "11 sphere light", (Meter){.albedo = 0.5}, PI / 13 * 3 / sqrt(13),
                      1 << 12, 1 << 17);
    close_lab(&lab);
}

// A closed shape's triangles as a mesh: box, or a sphere or disc cut finely.
static uint32_t put_mesh(SceneMaker *maker, const Vec3 *vertices, uint32_t vertex_count,
                         const uint32_t *triangles, uint32_t index_count)
{
    return PUT_LIGHT_SHAPE(maker, "mesh", {"vertices", .list = vertices, .count = vertex_count},
                           {"faces", .list = triangles, .count = index_count}, {"smooth", {0}});
}

static uint32_t put_box_mesh(SceneMaker *maker, Vec3 min, Vec3 max)
{
    Vec3 v[8];
    for (int i = 0; i < 8; ++i) {
        v[i] = vec3(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z);
    }
    static const uint32_t FACES[36] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                       2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
    return put_mesh(maker, v, 8, FACES, 36);
}

// A unit sphere about `center` of `rows` × 2 rows cells, its area within 4 / rows² of the sphere's.
static uint32_t put_sphere_mesh(SceneMaker *maker, Vec3 center, uint32_t rows)
{
    uint32_t columns = 2 * rows, count = 0;
    Vec3 *v = arena_array(&maker->arena, (size_t)(rows + 1) * columns, sizeof *v);
    uint32_t *f = arena_array(&maker->arena, (size_t)rows * columns, 6 * sizeof *f);
    for (uint32_t i = 0; i <= rows; ++i) {
        for (uint32_t j = 0; j < columns; ++j) {
            double theta = PI * i / rows, phi = 2 * PI * j / columns;
            v[i * columns + j] =
                add(center, vec3(sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi)));
        }
    }
    for (uint32_t i = 0; i < rows; ++i) {
        for (uint32_t j = 0; j < columns; ++j) {
            uint32_t next = (j + 1) % columns;
            uint32_t a = i * columns + j, b = i * columns + next, c = a + columns, d = b + columns;
            const uint32_t two[6] = {a, b, d, a, d, c};
            uint32_t first = i == 0 ? 3 : 0, last = i == rows - 1 ? 3 : 6;
            for (uint32_t k = first; k < last; ++k) {
                f[count++] = two[k];
            }
        }
    }
    return put_mesh(maker, v, (rows + 1) * columns, f, count);
}

// 13. A light's shape as a primitive and as a mesh.
static void primitive_and_mesh(void)
{
    static const char *const NAMES[] = {"13 rectangle = mesh", "13 box = mesh", "13 sphere = mesh"};
    estimate_pairs = true;
    for (int kind = 0; kind < 3; ++kind) {
        Running means[2];
        for (int mesh = 0; mesh < 2; ++mesh) {
            Lab lab;
            open_lab(&lab);
            put_ground(&lab);
            SceneMaker *m = &lab.maker;
            static const Vec3 CORNERS[4] = {
                {-0.5, 1, -0.5}, {0.5, 1, -0.5}, {0.5, 1, 1.5}, {-0.5, 1, 1.5}};
            static const uint32_t TWO[6] = {0, 1, 2, 0, 2, 3};
            uint32_t shape;
            switch (2 * kind + mesh) {
            case 0:
                shape = PUT_LIGHT_SHAPE(m, "rectangle", {"corner", {-0.5, 1, -0.5}},
                                        {"u", {1, 0, 0}}, {"v", {0, 0, 2}});
                break;
            case 1:
                shape = put_mesh(m, CORNERS, 4, TWO, 6);
                break;
            case 2:
                shape = PUT_LIGHT_SHAPE(m, "box", {"min", {-0.5, 1, 0.2}}, {"max", {1, 2, 1}});
                break;
            case 3:
                shape = put_box_mesh(m, vec3(-0.5, 1, 0.2), vec3(1, 2, 1));
                break;
            case 4:
                shape = PUT_LIGHT_SHAPE(m, "sphere", {"center", {1, 2, 0}}, {"radius", {1}});
                break;
            default:
                shape = put_sphere_mesh(m, vec3(1, 2, 0), 400);
                break;
            }
            PUT(m, "area_light", {"shape", {shape}}, {"radiance", {1}});
            Meter at = {.albedo = 0.5};
            means[mesh] = estimate(build(&lab, 1), meter, &at, 1 << 15, 40 + (uint32_t)mesh);
            close_lab(&lab);
        }
        check_equal(&table, NAMES[kind], means[0], means[1], 2e-3);
    }
    estimate_pairs = false;
}

// Surroundings and lights whose radiance comes from a texture, against quadrature: the upper
// hemisphere of a checkered sky, and a checkered square.
static void textured_lights(void)
{
    Lab lab;
    open_lab(&lab);
    put_ground(&lab);
    uint32_t checker = PUT(&lab.maker, "checker", {"a", {3}}, {"b", {0.25}}, {"scale", {5, 7, 0}});
    PUT(&lab.maker, "environment_light", {"radiance", {checker}, .texture = true});
    double sky = 0;
    enum { STEPS = 7000 }; // cells end at multiples of 1/7 of v and 1/5 of u
    for (int i = 0; i < STEPS; ++i) {
        double v = 0.5 + 0.5 * (i + 0.5) / STEPS, theta = PI * (1 - v);
        // Three of five columns have one color in even rows, two in odd ones.
        bool even = (int)floor(7 * v) % 2 == 0;
        double mean = even ? (3 * 3 + 2 * 0.25) / 5 : (3 * 0.25 + 2 * 3) / 5;
        sky += mean * cos(theta) * sin(theta) * 2 * PI * (PI / 2 / STEPS);
    }
    irradiance_checks(&lab, "textured sky", (Meter){.albedo = 0.5}, sky, 1 << 19, 1 << 14);
    close_lab(&lab);

    open_lab(&lab);
    put_ground(&lab);
    uint32_t squares = PUT(&lab.maker, "checker", {"a", {3}}, {"b", {0.25}}, {"scale", {3, 2, 0}});
    uint32_t glow = PUT(&lab.maker, "emissive", {"radiance", {squares}, .texture = true});
    PUT(&lab.maker, "rectangle", {"corner", {-0.5, 1, -0.5}}, {"u", {1, 0, 0}}, {"v", {0, 0, 2}},
        {"material", {glow}});
    double sum = 0;
    enum { PARTS = 1200 };
    for (int i = 0; i < PARTS * PARTS; ++i) {
        double u = (i % PARTS + 0.5) / PARTS, v = ((double)(i / PARTS) + 0.5) / PARTS;
        double x = u - 0.5, z = 2 * v - 0.5, r2 = x * x + z * z + 1;
        bool even = ((int)(3 * u) + (int)(2 * v)) % 2 == 0;
        sum += (even ? 3 : 0.25) / (r2 * r2) * 2 / ((double)PARTS * PARTS);
    }
    irradiance_checks(&lab, "textured square", (Meter){.albedo = 0.5}, sum, 1 << 13, 1 << 16);
    close_lab(&lab);
}

// A hundred lights of very different power, and glowing spheres in instances.
static void many_lights(void)
{
    Lab lab;
    open_lab(&lab);
    put_ground(&lab);
    TestRandom random = {11};
    double expected = 0;
    for (int i = 0; i < 100; ++i) {
        Vec3 p = vec3(8 * (double)test_random(&random) - 4, 0.5 + 2 * (double)test_random(&random),
                      8 * (double)test_random(&random) - 4);
        double intensity = exp(6 * (double)test_random(&random));
        expected += intensity * p.y / pow(length_squared(p), 1.5);
        PUT(&lab.maker, "point_light", {"position", {p.x, p.y, p.z}}, {"intensity", {intensity}});
    }
    Meter at = {.albedo = 0.5};
    check_mean(&table, "100 point lights", expected,
               estimate(build(&lab, 1), meter, &at, 1 << 14, 50), 2e-3);
    close_lab(&lab);

    open_lab(&lab);
    put_ground(&lab);
    uint32_t glow = PUT(&lab.maker, "emissive", {"radiance", {2}});
    lab.maker.prototype = scene_add_prototype(&lab.maker.scene, 0, (Span){0});
    PUT(&lab.maker, "sphere", {"center", {0, 1, 0}}, {"radius", {0.5}}, {"material", {glow}});
    expected = 0;
    for (int i = 0; i < 5; ++i) {
        Affine grow = affine_scaling(vec3(1 + 0.1 * i, 1 + 0.1 * i, 1 + 0.1 * i));
        Affine move = affine_translation(vec3(3.0 * i - 6, 1 + 0.2 * i, 0.3));
        Affine both = affine_multiply(&move, &grow);
        SceneInstance instance = {.prototype = lab.maker.prototype,
                                  .transform = scene_add_transform(&lab.maker.scene, &both),
                                  .material = NONE_ID};
        if (!array_push(&lab.maker.scene.instances, instance)) {
            abort();
        }
        Vec3 p = transform_point(&both, vec3(0, 1, 0));
        double r = 0.5 * (1 + 0.1 * i);
        expected += 2 * PI * r * r * p.y / pow(length_squared(p), 1.5);
    }
    // None hides another from the origin.
    irradiance_checks(&lab, "glowing instances", at, expected, 1 << 14, 1 << 17);
    close_lab(&lab);
}

// 24. Constant surroundings are seen exactly.
static int constant_sky(void)
{
    Lab lab;
    open_lab(&lab);
    PUT(&lab.maker, "environment_light", {"radiance", {0.3, 0.7, 11}});
    build(&lab, 12);
    int failures = 0;
    for (uint32_t i = 0; i < 1000; ++i) {
        Sampler sampler;
        IntegratorStats stats = {0};
        sampler_start(&sampler, 0, i, 0, 0);
        float u = sampler_1d(&sampler), v = sampler_1d(&sampler);
        Ray ray = ray_make(vec3(1, 2, 3), sphere_direction(u, v), 0, INFINITY);
        Rgb found = path_integrator.radiance(lab.world, &ray, &sampler, NULL, &stats);
        failures += found.r != 0.3f || found.g != 0.7f || found.b != 11.0f;
    }
    close_lab(&lab);
    return !trust_none("24 constant sky, rays that see something else", failures, 1000);
}

int main(void)
{
    furnace("sphere", 0.5, 1, 1.5, 1 << 7);
    furnace("sphere", 0.5, 30, 2, 1 << 6);
    furnace("sphere", 0.8, 1, 1.8, 1 << 7);
    furnace("sphere", 0.8, 100, 5, 1 << 6);
    furnace("box", 0.5, 1, 1.5, 1 << 15);
    furnace("box", 0.5, 8, 1.99609375, 1 << 14);
    furnace_with_roulette();
    lit_sphere();
    closed_room();
    bowl();
    phases();
    white_in_white();
    sampling_strategies();
    area_lights();
    primitive_and_mesh();
    textured_lights();
    many_lights();
    int failures = mirror_corridor() + point_light() + constant_sky();
    failures += check_judge(&table, "transport");
    return failures ? EXIT_FAILURE : EXIT_SUCCESS;
}
