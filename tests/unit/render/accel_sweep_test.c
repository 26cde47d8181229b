// The ways to sweep, all that the processor can go. Their kernels against double precision: what is
// hit is always proposed, no farther than it is, and little else is. And that all find the same.
#include "base/hash.h"
#include "render/accel_parts.h"
#include "shapes.h"

#include <stdalign.h>

enum { RAYS = 20000 };

static uint32_t seed = 1;

static double number(void) // in [-1, 1)
{
    seed = hash_u32(seed + 0x9e3779b9u);
    return (double)(seed >> 8) * 0x1p-23 - 1;
}

static Vec3 direction(void)
{
    for (;;) {
        const Vec3 d = vec3(number(), number(), number());
        if (length_squared(d) > 0.01 && length_squared(d) < 1) {
            return normalize(d);
        }
    }
}

// A piece: the points corner + s u + t v with s, t, 1 - s - over t and 1 - t - over s >= 0.
typedef struct Piece {
    Vec3 corner, u, v, normal, along_u, along_v;
    double over;
} Piece;

static void put(float to[4][SWEEP_BLOCK], uint32_t lane, Vec3 gradient, Vec3 corner)
{
    to[0][lane] = (float)gradient.x;
    to[1][lane] = (float)gradient.y;
    to[2][lane] = (float)gradient.z;
    to[3][lane] = (float)-dot(gradient, corner);
}

// Within the cube [-1, 1]³, now and then along its axes.
static Piece make_piece(uint32_t i, SweepBlock *block, uint32_t lane)
{
    Piece p = {.corner = scale(vec3(number(), number(), number()), 0.5)};
    do {
        p.u = i % 4 == 0 ? vec3(0.5, 0, 0) : scale(direction(), 0.4);
        p.v = i % 4 == 0 ? vec3(0, 0, 0.5) : scale(direction(), 0.4);
    } while (length(cross(p.u, p.v)) < 0.05);
    p.over = i % 2;
    const Vec3 across = cross(p.u, p.v);
    const double area2 = length_squared(across);
    p.normal = normalize(across);
    p.along_u = scale(cross(p.v, across), 1 / area2);
    p.along_v = scale(cross(across, p.u), 1 / area2);
    put(block->plane, lane, p.normal, p.corner);
    put(block->s, lane, p.along_u, p.corner);
    put(block->t, lane, p.along_v, p.corner);
    block->over_s[lane] = block->over_t[lane] = (float)p.over;
    const double steep = larger(length(p.along_u), length(p.along_v));
    const double both = length(add(p.along_u, p.along_v)) * p.over;
    block->steep[lane] = (float)larger(steep, both);
    return p;
}

static bool piece_hit(const Piece *p, Vec3 origin, Vec3 towards, double end, double *at)
{
    *at = dot(sub(p->corner, origin), p->normal) / dot(towards, p->normal);
    const Vec3 from = sub(add_scaled(origin, towards, *at), p->corner);
    const double s = dot(p->along_u, from), t = dot(p->along_v, from);
    return *at > 0 && *at < end && s >= 0 && t >= 0 && 1 - s - p->over * t >= 0 &&
           1 - t - p->over * s >= 0;
}

static void check_kernel(SweepKernel *kernel, uint32_t count, uint32_t *proposed, uint32_t *hits)
{
    alignas(64) SweepBlock blocks[2] = {{.steep = {0}}};
    Piece pieces[SWEEP_MOST];
    for (uint32_t i = 0; i < count; ++i) {
        pieces[i] = make_piece(i, &blocks[i / SWEEP_BLOCK], i % SWEEP_BLOCK);
    }
    for (int i = 0; i < RAYS; ++i) {
        Vec3 origin = vec3(number(), number(), number()), towards = direction();
        const Piece *aim = &pieces[(uint32_t)i % count];
        if (i % 2) { // at a corner or along an edge, where it is decided closely
            const Vec3 to = i % 4 == 1 ? aim->corner : add_scaled(aim->corner, aim->u, 0.3);
            towards = normalize(sub(to, origin));
        } else if (i % 16 == 0) { // within the piece's plane
            origin = aim->corner;
            towards = normalize(add(aim->u, aim->v));
        }
        const double end = i % 3 ? INFINITY : 0.5;
        const SweepRay ray = {{(float)origin.x, (float)origin.y, (float)origin.z},
                              {(float)towards.x, (float)towards.y, (float)towards.z},
                              (float)end};
        float from[SWEEP_MOST];
        const uint32_t bits = kernel(blocks, count, &ray, from);
        assert_int_equal((uint64_t)bits >> count, 0);
        for (uint32_t k = 0; k < count; ++k) {
            double at;
            const bool hit = piece_hit(&pieces[k], origin, towards, end, &at);
            const bool asked = bits >> k & 1;
            *hits += hit;
            *proposed += asked;
            if (hit && (!asked || (double)from[k] > at)) {
                fail_msg("ray %d, piece %u: hit at %.17g, %s from %.9g", i, k, at,
                         asked ? "proposed" : "not proposed", (double)from[k]);
            }
        }
    }
}

static void what_is_hit_is_proposed(void **state)
{
    (void)state;
    const SweepWay *ways[4];
    const int way_count = accel_sweep_ways(ways);
    for (int k = 0; k < way_count; ++k) {
        static const uint32_t counts[] = {1, 3, 8, 15, 16, 17, 32};
        uint32_t proposed = 0, hits = 0;
        for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i) {
            check_kernel(ways[k]->kernel, counts[i], &proposed, &hits);
        }
        printf("kernel %d: %u hits, %u proposed\n", k, hits, proposed);
        // All but those aimed at edges: about half of these miss.
        assert_true(hits > RAYS && proposed < 2 * hits);
    }
}

// Flat shapes alone, which are all swept; those of a prototype stand in two instances.
static Scene *flat_scene(Random *r, int count, uint32_t *prototype)
{
    Scene *scene = calloc(1, sizeof *scene);
    assert_non_null(scene);
    assert_true(scene_init(scene, render_schema(), NULL));
    *prototype = scene_add_prototype(scene, 0, (Span){0});
    for (int i = 0; i < 2 * count; ++i) {
        const Vec3 p = scale(random_direction(r), uniform(r));
        const Vec3 d = random_direction(r), e = random_direction(r);
        Params params =
            i % 3 ? rectangle_params_of(p, d, e) : triangle_params_of(p, add(p, d), add(p, e));
        add_shape(scene, &params, NULL, i % 2 ? *prototype : 0);
    }
    for (int i = 0; i < 2; ++i) {
        const Affine to = affine_translation(vec3(3 + 2 * i, i, 0));
        const SceneInstance instance = {.prototype = *prototype,
                                        .transform = scene_add_transform(scene, &to),
                                        .material = NONE_ID};
        assert_true(array_push(&scene->instances, instance));
    }
    return scene;
}

// What the ways find along a ray, to the bit; *hit as the first finds it.
static bool found_by_all(const AccelGroup *group, const Ray *ray, uint32_t instance, Hit *hit)
{
    const SweepWay *ways[4];
    const int count = accel_sweep_ways(ways);
    const bool found = ways[0]->intersect(group, ray, instance, hit);
    for (int k = 0; k < count; ++k) {
        Hit other;
        assert_int_equal(ways[k]->occluded(group, ray, instance), found);
        assert_int_equal(ways[k]->intersect(group, ray, instance, &other), found);
        if (found) {
            assert_true(other.t == hit->t && other.local.u == hit->local.u &&
                        other.local.v == hit->local.v);
            assert_int_equal(other.flat, hit->flat);
            assert_int_equal(other.inside, hit->inside);
            assert_int_equal(other.instance, instance);
        }
    }
    return found;
}

// A ray from anywhere near the pieces, and where it meets one, a ray from there.
static uint32_t check_ways(const Accel *accel, const AccelGroup *group, uint32_t instance,
                           Random *r)
{
    const Vec3 from = scale(random_direction(r), between(r, 0, 3));
    const Vec3 to = scale(random_direction(r), uniform(r));
    const double pace = instance == NONE_ID ? 1 : between(r, 0.5, 2);
    Ray ray = ray_make(from, scale(normalize(sub(to, from)), pace), 0, INFINITY);
    if (uniform(r) < 0.3) {
        ray.tmin = uniform(r);
        ray.tmax = ray.tmin + 3 * uniform(r);
    }
    Hit hit;
    if (!found_by_all(group, &ray, instance, &hit)) {
        return 0;
    }
    if (instance == NONE_ID) {
        Surface surface;
        accel_surface_plain(accel, &ray, &hit, &surface);
        const Ray next = surface_spawn(&surface, random_direction(r));
        found_by_all(group, &next, instance, &hit);
    }
    return 1;
}

static void all_ways_find_the_same(void **state)
{
    (void)state;
    static const int counts[] = {1, 7, 16, 17, 32};
    Random r = random_make("ways to sweep", 34);
    for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i) {
        uint32_t prototype, hits = 0;
        Scene *scene = flat_scene(&r, counts[i], &prototype);
        Accel *accel = accel_build(scene, 1);
        assert_non_null(accel);
        const AccelGroup *world = &accel->groups[0], *inner = &accel->groups[prototype];
        assert_int_equal(world->sweep_count, counts[i]);
        assert_int_equal(inner->sweep_count, counts[i]);
        for (int k = 0; k < RAYS / 4; ++k) {
            hits += check_ways(accel, world, NONE_ID, &r);
            hits += check_ways(accel, inner, 1, &r);
        }
        printf("%d pieces: %u of %d rays hit\n", counts[i], hits, RAYS / 2);
        assert_true(hits > RAYS / 100);
        accel_free(accel);
        scene_free(scene);
        free(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_is_hit_is_proposed),
                                       cmocka_unit_test(all_ways_find_the_same)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
