// Rendered light of spots, luminaires and suns against figures: reference checks 9, 14 and 15
// through the whole path tracer, and crowds of lights of all kinds.
#include "paired.h"

#include "render/attenuation.h"
#include "scene/ies.h"

typedef struct Lab {
    SceneMaker maker;
    World *world;
} Lab;

static CheckTable table;

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
    return lab->world;
}

static void open_lab(Lab *lab)
{
    maker_init(&lab->maker);
    lab->world = NULL;
}

static void close_lab(Lab *lab)
{
    world_free(lab->world);
    maker_free(&lab->maker);
}

// Down on a point of the ground, y = 0, of albedo 1/2; the weight makes irradiance of radiance.
static double meter(const void *context, const float n[4], Ray *ray)
{
    (void)n;
    ray->origin = add(*(const Vec3 *)context, vec3(0, 1e-3, 0));
    ray->direction = vec3(0, -1, 0);
    return PI / 0.5;
}

// At a point of the inner walls of a 4 m cube about the origin, uniform by area.
static double wall_meter(const void *context, const float n[4], Ray *ray)
{
    (void)context;
    double a = 4 * ((double)n[0] - 0.5), b = 4 * ((double)n[1] - 0.5);
    int face = (int)(6 * n[2]);
    double side = face < 3 ? 2 : -2, inset = side * (1 - 1e-4);
    Vec3 p[3] = {{inset, a, b}, {b, inset, a}, {a, b, inset}};
    Vec3 d[3] = {{side, 0, 0}, {0, side, 0}, {0, 0, side}};
    ray->origin = p[face % 3];
    ray->direction = normalize(d[face % 3]);
    return PI / 0.5;
}

static uint32_t put_ground(Lab *lab)
{
    uint32_t half = PUT(&lab->maker, "lambert", {"color", {0.5}});
    PUT(&lab->maker, "plane", {"point", {0, 0, 0}}, {"normal", {0, 1, 0}}, {"material", {half}});
    return half;
}

// 14. What a spot or a luminaire sends out arrives at the walls of a closed room: Φ / A directly.
static void closed_rooms(void)
{
    static const char *const NAMES[] = {"14 room, smooth cone", "14 room, cosine lobe",
                                        "15 room, batwing luminaire"};
    static char file[512];
    snprintf(file, sizeof file, "%s/examples/slides/photometric/batwing.ies", SCN_SOURCE_DIR);
    for (int kind = 0; kind < 3; ++kind) {
        Lab lab;
        open_lab(&lab);
        uint32_t half = PUT(&lab.maker, "lambert", {"color", {0.5}});
        PUT(&lab.maker, "box", {"min", {-2, -2, -2}}, {"max", {2, 2, 2}}, {"material", {half}});
        double flux = 100;
        if (kind == 2) {
            PUT(&lab.maker, "photometric_light", {"file", .text = file},
                {"position", {0.5, 0.3, -0.2}}, {"direction", {0.3, -1, 0.4}}, {"scale", {10}});
            Arena arena = {0};
            FileBytes bytes;
            IesError error;
            if (file_read(file, 1 << 20, &bytes) != IO_OK) {
                abort();
            }
            flux =
                10 / 683.0 * ies_lumens(ies_read(&arena, (Str){bytes.bytes, bytes.size}, &error));
            file_bytes_free(&bytes);
            arena_free(&arena);
        } else {
            uint32_t falloff =
                kind == 0 ? PUT(&lab.maker, "smooth_cone", {"inner", {0.5}}, {"outer", {1.4}})
                          : PUT(&lab.maker, "cosine_lobe", {"exponent", {3}});
            PUT(&lab.maker, "spot_light", {"position", {0.5, 0.3, -0.2}},
                {"direction", {0.3, -1, 0.4}}, {"power", {100}, .dim = DIM_POWER},
                {"falloff", {falloff}});
        }
        check_mean(&table, NAMES[kind], flux / 96,
                   estimate(build(&lab, 1), wall_meter, NULL, 1 << 14, (uint32_t)kind), 1e-3);
        close_lab(&lab);
    }
}

// 9. Directional: E cos θ; and a sun's disc of the same irradiance, by each way of sampling. The
// sampling of directions finds the wider one only.
static void suns(void)
{
    const double angles[] = {0, 0.01, 0.5};
    for (int i = 0; i < 3; ++i) {
        Lab lab;
        open_lab(&lab);
        put_ground(&lab);
        PUT(&lab.maker, "directional_light", {"direction", {1, -1, 0.5}}, {"irradiance", {2}},
            {"angle", {angles[i]}});
        const Vec3 at = vec3(3, 0, 4);
        double expected = 2 / sqrt(2.25);
        char name[64];
        snprintf(name, sizeof name, "9 directional, angle %g, mis", angles[i]);
        check_mean(&table, name, expected, estimate(build(&lab, 1), meter, &at, 1 << 10, 5), 2e-3);
        lab.world->sampling = SAMPLING_LIGHT;
        snprintf(name, sizeof name, "9 directional, angle %g, light", angles[i]);
        check_mean(&table, name, expected, estimate(lab.world, meter, &at, 1 << 10, 6), 2e-3);
        if (i == 2) {
            lab.world->sampling = SAMPLING_BSDF;
            check_mean(&table, "9 directional, angle 0.5, bsdf", expected,
                       estimate(lab.world, meter, &at, 1 << 18, 7), 1.5e-3);
        }
        close_lab(&lab);
    }
}

// The sum of all lights of a crowd, each by its formula.
static double put_crowd(Lab *lab, int count, Vec3 at)
{
    TestRandom random = {17};
    double sum = 0;
    for (int i = 0; i < count; ++i) {
        Vec3 p =
            vec3(40 * (double)test_random(&random) - 20, 0.3 + 2 * (double)test_random(&random),
                 40 * (double)test_random(&random) - 20);
        double intensity = exp(3 * (double)test_random(&random));
        Vec3 to = sub(at, p);
        double r = length(to), cosine = p.y / r;
        if (i % 2) {
            PUT(&lab->maker, "point_light", {"position", {p.x, p.y, p.z}},
                {"intensity", {intensity}});
            sum += intensity * cosine / (r * r);
        } else {
            PUT(&lab->maker, "spot_light", {"position", {p.x, p.y, p.z}}, {"direction", {0, -1, 0}},
                {"intensity", {intensity}});
            sum +=
                intensity * falloff_factor(&lab->maker.scene, NONE_ID, cosine) * cosine / (r * r);
        }
    }
    return sum;
}

static void crowds(void)
{
    for (int far = 0; far < 2; ++far) {
        Lab lab;
        open_lab(&lab);
        put_ground(&lab);
        const Vec3 at = vec3(1, 0, 2);
        double expected = put_crowd(&lab, 2000, at);
        if (far) {
            PUT(&lab.maker, "environment_light", {"radiance", {1}});
            PUT(&lab.maker, "directional_light", {"direction", {0, -1, 0}}, {"irradiance", {3}});
            PUT(&lab.maker, "directional_light", {"direction", {0, 1, 0}}, {"irradiance", {3}});
            expected += PI + 3;
        }
        check_mean(&table, far ? "2000 lamps, suns and sky" : "2000 lamps", expected,
                   estimate(build(&lab, 1), meter, &at, 1 << 16, 8), 1e-3);
        close_lab(&lab);
    }
}

// Two hundred glowing rectangles that look in all directions, by the three ways of sampling: the
// choice's chances count in the weights of light that rays hit.
static void glowing_crowd(void)
{
    Lab lab;
    open_lab(&lab);
    put_ground(&lab);
    TestRandom random = {23};
    uint32_t glow = PUT(&lab.maker, "emissive", {"radiance", {5}});
    for (int i = 0; i < 200; ++i) {
        double n[9];
        for (int k = 0; k < 9; ++k) {
            n[k] = 2 * (double)test_random(&random) - 1;
        }
        PUT(&lab.maker, "rectangle", {"corner", {4 * n[0], 2.6 + n[1], 4 * n[2]}},
            {"u", {0.5 * n[3], 0.5 * n[4], 0.5 * n[5]}},
            {"v", {0.5 * n[6], 0.5 * n[7], 0.5 * n[8]}}, {"material", {glow}});
    }
    const Vec3 at = vec3(0.1, 0, 0.2);
    static Rivals rivals;
    rivals = (Rivals){.world = build(&lab, 1),
                      .ray = meter,
                      .context = &at,
                      .first = MIS,
                      .samples = 1 << 13,
                      .seconds = 200};
    rivals_compare(&table, &rivals, "7 200 rectangles, light = mis", &LIGHT, 1e-2);
    rivals_compare(&table, &rivals, "7 200 rectangles, bsdf = mis", &BSDF, 2e-2);
    close_lab(&lab);
}

int main(void)
{
    closed_rooms();
    suns();
    crowds();
    glowing_crowd();
    return check_judge(&table, "beams") ? EXIT_FAILURE : EXIT_SUCCESS;
}
