// The sweep's kernels, all that the processor can run, against double precision: what is hit is
// always proposed, no farther than it is, and little else is.
#include "base/hash.h"
#include "base/vec.h"
#include "render/sweep_kernel.h"

#include <setjmp.h>
#include <stdalign.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

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
    SweepKernel *kernels[4];
    const int kernel_count = sweep_kernels(kernels);
    for (int k = 0; k < kernel_count; ++k) {
        static const uint32_t counts[] = {1, 3, 8, 15, 16, 17, 32};
        uint32_t proposed = 0, hits = 0;
        for (size_t i = 0; i < sizeof counts / sizeof *counts; ++i) {
            check_kernel(kernels[k], counts[i], &proposed, &hits);
        }
        printf("kernel %d: %u hits, %u proposed\n", k, hits, proposed);
        // All but those aimed at edges: about half of these miss.
        assert_true(hits > RAYS && proposed < 2 * hits);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_is_hit_is_proposed)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
