// Runs of curved shapes that are one primitive of Embree's each.
//
// Programs list the shapes that they make along the rows of a grid, along curves, or branch by
// branch. So the boxes of a few that follow one another are often hardly larger than their own
// together, and a hierarchy of such runs is built in half of the time, in less memory, while rays
// lose nothing to speak of: what they save on the way down they spend on the shapes of a run.
#include "base/thread.h"
#include "render/accel_parts.h"

#include <stdatomic.h>

enum { PIECE = 1 << 14 };
// A shape joins a run whose box stays below this many times the surfaces of its shapes' boxes.
static const double MOST_GROWTH = 2.5;
// Where no ray of Embree's comes.
static const double NOWHERE = 1e6;
// With fewer shapes for each run nothing is won.
static const double LEAST_SHAPES = 1.5;

typedef struct Maker {
    const AccelKind *kind;
    uint32_t *runs;   // the pieces' first shapes of runs, each piece from its own place on
    uint32_t *counts; // by piece
    uint32_t pieces;
    atomic_bool scattered; // the parameters aren't in a row
} Maker;

static double half_surface(Box3 box)
{
    const Vec3 d = sub(box.max, box.min);
    return box3_is_empty(box) ? 0 : d.x * d.y + d.y * d.z + d.z * d.x;
}

static void make_piece(void *context, uint64_t piece, unsigned worker)
{
    (void)worker;
    Maker *maker = context;
    const AccelKind *kind = maker->kind;
    const Scene *scene = kind->accel->scene;
    const uint32_t begin = (uint32_t)piece * PIECE;
    const uint32_t end = kind->count - begin > PIECE ? begin + PIECE : kind->count;
    uint32_t *runs = maker->runs + begin, count = 0;
    Box3 all = box3_empty();
    double own = 0;
    const uint32_t first = scene_node(scene, CATEGORY_SHAPE, kind->ids[0])->index;
    bool scattered = false;
    for (uint32_t i = begin; i < end; ++i) {
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, kind->ids[i]);
        scattered = scattered || node->transform != 0 || node->index != first + i;
        const Box3 box = accel_shape_box(scene, node);
        const Box3 joined = box3_union(all, box);
        own += half_surface(box);
        if (count > 0 && i - runs[count - 1] < RUN_LONGEST &&
            half_surface(joined) <= MOST_GROWTH * own) {
            all = joined;
        } else {
            runs[count++] = i;
            all = box;
            own = half_surface(box);
        }
    }
    maker->counts[piece] = count;
    if (scattered) {
        atomic_store_explicit(&maker->scattered, true, memory_order_relaxed);
    }
}

// Moves the pieces' runs together; how many there are.
static uint32_t join_pieces(const Maker *maker)
{
    uint32_t count = 0;
    for (uint32_t piece = 0; piece < maker->pieces; ++piece) {
        memmove(maker->runs + count, maker->runs + (size_t)piece * PIECE,
                maker->counts[piece] * sizeof *maker->runs);
        count += maker->counts[piece];
    }
    maker->runs[count] = maker->kind->count;
    return count;
}

// --- Balls
// ----------------------------------------------------------------------------------------

static void fill_balls(void *context, uint64_t piece, unsigned worker)
{
    (void)worker;
    const AccelKind *kind = context;
    const Vec3 center = kind->group->center;
    const double inverse_scale = kind->group->inverse_scale;
    const uint32_t begin = (uint32_t)piece * PIECE;
    const uint32_t end = kind->run_count - begin > PIECE ? begin + PIECE : kind->run_count;
    for (uint32_t run = begin; run < end; ++run) {
        BallRun *balls = &kind->balls[run];
        const uint32_t first = kind->runs[run], count = kind->runs[run + 1] - first;
        for (uint32_t i = 0; i < RUN_LONGEST; ++i) {
            Vec3 p = vec3(NOWHERE, NOWHERE, NOWHERE);
            double radius = -kind->group->scale;
            if (i < count) {
                p = kind->class->ball(kind->row + (first + i) * kind->class->node.size, &radius);
                p = scale(sub(p, center), inverse_scale);
            }
            balls->x[i] = (float)p.x;
            balls->y[i] = (float)p.y;
            balls->z[i] = (float)p.z;
            balls->radius[i] = (float)(radius * inverse_scale);
        }
    }
}

// Without memory there are none.
static void make_balls(AccelKind *kind)
{
    enum { LINE = 64 };
    kind->balls_memory = mem_alloc((size_t)kind->run_count + 1, sizeof *kind->balls);
    if (!kind->balls_memory) {
        return;
    }
    const uintptr_t at = (uintptr_t)kind->balls_memory;
    kind->balls = (BallRun *)((at + LINE - 1) & ~(uintptr_t)(LINE - 1));
    const Scene *scene = kind->accel->scene;
    kind->row = scene_params(scene, scene_node(scene, CATEGORY_SHAPE, kind->ids[0]));
    parallel_for((kind->run_count - 1) / PIECE + 1, kind->accel->threads, fill_balls, kind, NULL);
}

static void make_runs(AccelKind *kind)
{
    Maker maker = {.kind = kind, .pieces = (kind->count - 1) / PIECE + 1};
    maker.runs = mem_alloc((size_t)kind->count + 1, sizeof *maker.runs);
    maker.counts = mem_alloc(maker.pieces, sizeof *maker.counts);
    if (maker.runs && maker.counts) {
        parallel_for(maker.pieces, kind->accel->threads, make_piece, &maker, NULL);
        const uint32_t count = join_pieces(&maker);
        if (count * LEAST_SHAPES <= kind->count) {
            kind->runs = maker.runs;
            kind->run_count = count;
            if (!atomic_load(&maker.scattered) && kind->class->ball) {
                make_balls(kind);
            }
        }
    }
    if (!kind->runs) {
        mem_free(maker.runs);
    }
    mem_free(maker.counts);
}

void accel_make_runs(AccelGroup *group)
{
    for (uint32_t k = 0; k < group->kind_count; ++k) {
        AccelKind *kind = &group->kinds[k];
        if (!kind->native && kind->count > 0 && group->accel->issues.not_finite == 0) {
            make_runs(kind);
        }
    }
}
