// Sorts the scene's shapes into groups and decides how each is held; see accel_parts.h.
#include "base/thread.h"
#include "render/accel_parts.h"
#include "render/geometry.h"
#include "render/shapes/mesh.h"

#include <stdlib.h>
#include <string.h>

static bool box_is_finite(Box3 box)
{
    return vec3_is_finite(box.min) && vec3_is_finite(box.max);
}

Box3 accel_shape_box(const Scene *scene, const SceneNode *node)
{
    Box3 box = scene_node_type(scene, node)->bounds(scene, scene_params(scene, node));
    return node->transform == 0 || box3_is_empty(box)
               ? box
               : transform_box(&scene->transforms.items[node->transform], box);
}

Box3 accel_instance_box(const Accel *accel, uint32_t instance)
{
    const SceneInstance *it = &accel->scene->instances.items[instance];
    Box3 box = accel->groups[it->prototype].bounds;
    return box3_is_empty(box) ? box
                              : transform_box(&accel->scene->transforms.items[it->transform], box);
}

// nextafterf(x, INFINITY), of which a million boxes need twelve each. `x` is finite.
static float float_above(float x)
{
    uint32_t bits;
    x += 0; // never -0
    memcpy(&bits, &x, sizeof bits);
    bits += x < 0 ? UINT32_MAX : 1;
    memcpy(&x, &bits, sizeof x);
    return x;
}

bool accel_float_box(const AccelGroup *group, Box3 box, float lower[3], float upper[3])
{
    if (box3_is_empty(box) || !box_is_finite(box)) {
        return false;
    }
    for (int axis = 0; axis < 3; ++axis) {
        double center = vec3_get(group->center, axis);
        double low = (vec3_get(box.min, axis) - center) / group->scale;
        double high = (vec3_get(box.max, axis) - center) / group->scale;
        lower[axis] = -float_above(-(float)(low - BOX_MARGIN));
        upper[axis] = float_above((float)(high + BOX_MARGIN));
    }
    return true;
}

// Puts Embree's cube around the group's box.
static void group_set_bounds(AccelGroup *group, Box3 box)
{
    group->bounds = box;
    group->center = vec3(0, 0, 0);
    group->scale = 1;
    group->inverse_scale = 1;
    if (box3_is_empty(box)) {
        return;
    }
    // Halves first: the difference of two finite numbers may overflow.
    group->center = add(scale(box.min, 0.5), scale(box.max, 0.5));
    double half = max_component(sub(scale(box.max, 0.5), scale(box.min, 0.5)));
    half = fmax(half, max_abs(group->center) * 0x1p-40);
    if (half > 0) {
        int exponent;
        frexp(half, &exponent);
        group->scale = ldexp(1, exponent < -1000 ? -1000 : exponent > 1000 ? 1000 : exponent);
        group->inverse_scale = 1 / group->scale;
    }
}

// --- Sorting ------------------------------------------------------------------------------------

// Counting sort of `ids` by a key below `key_count`; starts[key] is the first place of each key,
// starts[key_count] the end.
typedef uint32_t ShapeKey(const Scene *scene, uint32_t id);

static void sort_ids(const Scene *scene, ShapeKey *key, uint32_t key_count, const uint32_t *ids,
                     uint32_t count, uint32_t *starts, uint32_t *out)
{
    memset(starts, 0, (key_count + 1) * sizeof *starts);
    starts[0] = key_count == 1 ? count : 0;
    for (uint32_t i = 0; key_count > 1 && i < count; ++i) {
        ++starts[key(scene, ids ? ids[i] : i)];
    }
    uint32_t sum = 0, used = 0;
    for (uint32_t k = 0; k <= key_count; ++k) {
        uint32_t here = starts[k];
        used += here > 0;
        starts[k] = sum;
        sum += here;
    }
    for (uint32_t i = 0; used == 1 && i < count; ++i) {
        out[i] = ids ? ids[i] : i;
    }
    if (used == 1) {
        return;
    }
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t id = ids ? ids[i] : i;
        out[starts[key(scene, id)]++] = id;
    }
    for (uint32_t k = key_count; k > 0; --k) {
        starts[k] = starts[k - 1];
    }
    starts[0] = 0;
}

static uint32_t prototype_key(const Scene *scene, uint32_t id)
{
    return scene->nodes[CATEGORY_SHAPE].items[id].prototype;
}
static uint32_t type_key(const Scene *scene, uint32_t id)
{
    return scene->nodes[CATEGORY_SHAPE].items[id].type;
}

// --- Groups -----------------------------------------------------------------------------------

typedef ARRAY(AccelKind) KindArray;
typedef ARRAY(AccelGroup) GroupArray;
typedef ARRAY(uint32_t) IdArray;
typedef ARRAY(AccelUnbounded) UnboundedArray;

typedef struct Collector {
    Accel *accel;
    const Scene *scene;
    GroupArray pockets; // groups after those of the prototypes
    IdArray group_pockets;
    KindArray kinds;
    UnboundedArray unbounded; // `instance` is the prototype for now
    uint32_t *type_starts, *sorted;
} Collector;

static double box_half(Box3 box)
{
    return max_component(sub(scale(box.max, 0.5), scale(box.min, 0.5)));
}

// The shortest edge of a flat shape in its group's space; NAN where it isn't finite.
static double shortest_edge(const Scene *scene, const SceneNode *node, bool *degenerate)
{
    Vec3 corners[4];
    int count = shape_class(scene, node)->corners(scene_params(scene, node), corners);
    const Affine *to_group = &scene->transforms.items[node->transform];
    for (int i = 0; i < count; ++i) {
        corners[i] = transform_point(to_group, corners[i]);
        if (!vec3_is_finite(corners[i])) {
            return NAN;
        }
    }
    Vec3 u = sub(corners[1], corners[0]), v = sub(corners[count - 1], corners[0]);
    *degenerate = !(length_squared(cross(u, v)) > 0);
    double least = INFINITY;
    for (int i = 0; i < count; ++i) {
        least = fmin(least, length(sub(corners[(i + 1) % count], corners[i])));
    }
    return least;
}

static AccelKind kind_make(Collector *c, const ShapeClass *class, uint16_t type,
                           const uint32_t *ids, uint32_t count, bool native)
{
    AccelKind kind = {.accel = c->accel,
                      .class = class,
                      .params = c->scene->tables[type].items,
                      .ids = ids,
                      .count = count,
                      .native = native};
    if (class->holding == HOLD_TRIANGLES) {
        const SceneNode *node = scene_node(c->scene, CATEGORY_SHAPE, ids[0]);
        kind.mesh = mesh_of(c->scene, scene_params(c->scene, node));
        kind.transform = node->transform;
    }
    return kind;
}

// Flat shapes: those that single precision holds well come first and become Embree's triangles; the
// others follow and are intersected in double.
static bool collect_flats(Collector *c, const AccelGroup *group, const ShapeClass *class,
                          uint16_t type, uint32_t *ids, uint32_t count)
{
    uint32_t native = 0, kept = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const SceneNode *node = scene_node(c->scene, CATEGORY_SHAPE, ids[i]);
        bool degenerate = false;
        double edge = shortest_edge(c->scene, node, &degenerate);
        if (isnan(edge) || degenerate) {
            ++*(degenerate ? &c->accel->issues.degenerate : &c->accel->issues.not_finite);
            continue;
        }
        uint32_t id = ids[i];
        ids[kept] = id;
        if (edge >= FLAT_SIZE * group->scale) {
            uint32_t other = ids[native];
            ids[native++] = id;
            ids[kept] = other;
        }
        ++kept;
    }
    AccelKind triangles = kind_make(c, class, type, ids, native, true);
    AccelKind others = kind_make(c, class, type, ids + native, kept - native, false);
    Vec3 corners[4];
    const SceneNode *any = scene_node(c->scene, CATEGORY_SHAPE, ids[0]);
    triangles.corners = class->corners(scene_params(c->scene, any), corners);
    return (native == 0 || array_push(&c->kinds, triangles)) &&
           (kept == native || array_push(&c->kinds, others));
}

static bool collect_pocket(Collector *c, AccelKind kind, Box3 box)
{
    AccelGroup pocket = {.accel = c->accel};
    group_set_bounds(&pocket, box);
    pocket.kinds = mem_alloc(1, sizeof kind);
    if (!pocket.kinds) {
        return false;
    }
    pocket.kinds[0] = kind;
    pocket.kind_count = 1;
    uint32_t number = (uint32_t)(c->scene->prototypes.count + c->pockets.count);
    if (!array_push(&c->pockets, pocket)) {
        mem_free(pocket.kinds);
        return false;
    }
    return array_push(&c->group_pockets, number);
}

static bool collect_meshes(Collector *c, const AccelGroup *group, const ShapeClass *class,
                           uint16_t type, const uint32_t *ids, uint32_t count)
{
    for (uint32_t i = 0; i < count; ++i) {
        const SceneNode *node = scene_node(c->scene, CATEGORY_SHAPE, ids[i]);
        Box3 box = accel_shape_box(c->scene, node);
        if (box3_is_empty(box) || !box_is_finite(box)) {
            continue; // counted when the bounds were taken
        }
        AccelKind kind = kind_make(c, class, type, ids + i, 1, true);
        bool small = box_half(box) < POCKET_SIZE * group->scale;
        if (!(small ? collect_pocket(c, kind, box) : array_push(&c->kinds, kind))) {
            return false;
        }
    }
    return true;
}

static bool collect_kind(Collector *c, const AccelGroup *group, uint32_t prototype, uint16_t type,
                         uint32_t *ids, uint32_t count)
{
    const ShapeClass *class = (const ShapeClass *)(const void *)c->scene->schema->types[type];
    switch (class->holding) {
    case HOLD_FLAT:
        return collect_flats(c, group, class, type, ids, count);
    case HOLD_TRIANGLES:
        return collect_meshes(c, group, class, type, ids, count);
    case HOLD_UNBOUNDED:
        for (uint32_t i = 0; i < count; ++i) {
            if (!array_push(&c->unbounded, (AccelUnbounded){ids[i], prototype})) {
                return false;
            }
        }
        return true;
    case HOLD_USER:
        break;
    }
    return array_push(&c->kinds, kind_make(c, class, type, ids, count, false));
}

// A shape's box; empty for what can't be hit through a hierarchy.
static Box3 bounded_box(const Scene *scene, const SceneNode *node, AccelIssues *issues)
{
    const ShapeHolding holding = shape_class(scene, node)->holding;
    bool degenerate = false;
    // Flat shapes are counted by collect_flats.
    if (holding == HOLD_UNBOUNDED ||
        (holding == HOLD_FLAT && (isnan(shortest_edge(scene, node, &degenerate)) || degenerate))) {
        return box3_empty();
    }
    const Box3 box = accel_shape_box(scene, node);
    if (box_is_finite(box)) {
        return box;
    }
    const bool nothing = isinf(box.min.x) && isinf(box.max.x) && box.min.x > box.max.x;
    issues->not_finite += !nothing;
    return box3_empty();
}

// --- Outliers -----------------------------------------------------------------------------------
// A sun at its true distance would leave everything else to the last digits of single precision.
// Where a group's shapes fall into two scales with nothing between, the smaller scale becomes a
// pocket.

enum {
    EXPONENTS = 2100,
    EXPONENT_ZERO = 1050,
    LEAST_GAP = 8,
    MOST_NESTED = 8,
    MEDIAN_SAMPLES = 1023
};

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// About the median of the shapes' middles, by every so many of them.
static Vec3 median_middle(const Scene *scene, const uint32_t *ids, uint32_t count)
{
    double values[3][MEDIAN_SAMPLES];
    const uint32_t step = count / MEDIAN_SAMPLES + 1;
    uint32_t n = 0;
    AccelIssues ignored = {0, 0};
    for (uint32_t i = 0; i < count; i += step) {
        const Box3 box = bounded_box(scene, scene_node(scene, CATEGORY_SHAPE, ids[i]), &ignored);
        if (!box3_is_empty(box)) {
            const Vec3 middle = add(scale(box.min, 0.5), scale(box.max, 0.5));
            values[0][n] = middle.x, values[1][n] = middle.y, values[2][n++] = middle.z;
        }
    }
    if (n == 0) {
        return vec3(0, 0, 0);
    }
    for (int axis = 0; axis < 3; ++axis) {
        qsort(values[axis], n, sizeof values[axis][0], compare_doubles);
    }
    return vec3(values[0][n / 2], values[1][n / 2], values[2][n / 2]);
}

// The exponent of a box's farthest coordinate from `middle`, as an index.
static int reach_exponent(Box3 box, Vec3 middle)
{
    if (box3_is_empty(box)) {
        return 0;
    }
    const double reach = larger(max_abs(sub(box.min, middle)), max_abs(sub(box.max, middle)));
    uint64_t bits;
    memcpy(&bits, &reach, sizeof bits);
    int exponent = (int)(bits >> 52) - 1022; // as frexp has it, for what is normal
    if (bits >> 52 == 0) {
        frexp(reach, &exponent);
    }
    return exponent + EXPONENT_ZERO < 0            ? 0
           : exponent + EXPONENT_ZERO >= EXPONENTS ? EXPONENTS - 1
                                                   : exponent + EXPONENT_ZERO;
}

// --- All boxes ----------------------------------------------------------------------------------
// A million shapes are looked at in pieces, by threads; what comes out of them all doesn't depend
// on how.

enum { PIECE = 1 << 14 };

// How many shapes reach how far from a middle: by reach_exponent.
typedef struct Reaches {
    Vec3 middle;
    _Atomic uint32_t histogram[EXPONENTS];
} Reaches;

typedef struct Boxes {
    const Accel *accel;
    const uint32_t *ids; // shapes; NULL: the instances
    uint32_t count;
    AccelIssues *issues;
    Reaches *reaches; // or NULL
    pthread_mutex_t mutex;
    Box3 all;
} Boxes;

static Box3 finite_instance_box(const Accel *accel, uint32_t instance, AccelIssues *issues)
{
    const Box3 box = accel_instance_box(accel, instance);
    if (box3_is_empty(box) || box_is_finite(box)) {
        return box;
    }
    ++issues->not_finite;
    return box3_empty();
}

static void add_boxes(void *context, uint64_t piece, unsigned worker)
{
    (void)worker;
    Boxes *boxes = context;
    const Scene *scene = boxes->accel->scene;
    Reaches *reaches = boxes->reaches;
    const uint32_t begin = (uint32_t)piece * PIECE;
    const uint32_t end = boxes->count - begin > PIECE ? begin + PIECE : boxes->count;
    Box3 all = box3_empty();
    AccelIssues issues = {0, 0};
    uint32_t histogram[EXPONENTS] = {0};
    for (uint32_t i = begin; i < end; ++i) {
        const Box3 box =
            boxes->ids
                ? bounded_box(scene, scene_node(scene, CATEGORY_SHAPE, boxes->ids[i]), &issues)
                : finite_instance_box(boxes->accel, i, &issues);
        if (!box3_is_empty(box)) {
            all = box3_union(all, box);
        }
        if (reaches) {
            ++histogram[reach_exponent(box, reaches->middle)];
        }
    }
    for (int i = 0; reaches && i < EXPONENTS; ++i) {
        if (histogram[i]) {
            atomic_fetch_add_explicit(&reaches->histogram[i], histogram[i], memory_order_relaxed);
        }
    }
    pthread_mutex_lock(&boxes->mutex);
    boxes->all = box3_union(boxes->all, all);
    boxes->issues->not_finite += issues.not_finite;
    pthread_mutex_unlock(&boxes->mutex);
}

// The box of all shapes, or (ids NULL) of all instances, and how far they reach, if that is asked.
static Box3 all_boxes(const Accel *accel, const uint32_t *ids, uint32_t count, AccelIssues *issues,
                      Reaches *reaches)
{
    Boxes boxes = {.accel = accel,
                   .ids = ids,
                   .count = count,
                   .issues = issues,
                   .reaches = reaches,
                   .mutex = PTHREAD_MUTEX_INITIALIZER,
                   .all = box3_empty()};
    const uint64_t pieces = count / PIECE + (count % PIECE != 0);
    parallel_for(pieces, accel->threads, add_boxes, &boxes, NULL);
    return boxes.all;
}

// Brings the shapes of the largest scale to the front and returns how many they are; `count` where
// there is but one scale. *instances: whether the world's instances belong to the smaller scale.
static uint32_t split_outliers(const Scene *scene, uint32_t *ids, uint32_t count, Reaches *reaches,
                               Box3 instances_box, bool *instances)
{
    const Vec3 middle = reaches->middle;
    _Atomic uint32_t *histogram = reaches->histogram;
    AccelIssues ignored = {0, 0};
    const int instance_exponent = reach_exponent(instances_box, middle);
    histogram[instance_exponent] += !box3_is_empty(instances_box);
    int top = EXPONENTS - 1, below;
    while (top > 0 && histogram[top] == 0) {
        --top;
    }
    // Downwards from each occupied exponent to the next, until they are far apart.
    for (below = top;; top = below) {
        do {
            --below;
        } while (below > 0 && histogram[below] == 0);
        if (below <= 0) {
            return count;
        }
        if (top - below >= LEAST_GAP) {
            break;
        }
    }
    *instances = instance_exponent <= below;
    uint32_t outer = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t id = ids[i];
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, id);
        if (reach_exponent(bounded_box(scene, node, &ignored), middle) > below) {
            ids[i] = ids[outer];
            ids[outer++] = id;
        }
    }
    return outer;
}

// --- Collecting ---------------------------------------------------------------------------------

static bool move_array(void **out, uint32_t *out_count, const void *items, size_t count,
                       size_t size)
{
    *out = mem_alloc(count, size);
    if (!*out) {
        return false;
    }
    if (count) {
        memcpy(*out, items, count * size);
    }
    *out_count = (uint32_t)count;
    return true;
}

// The one type that all of the scene's shapes are of; NONE_ID: they are of several.
static uint32_t only_type(const Scene *scene)
{
    uint32_t only = NONE_ID;
    for (uint32_t type = 0; type < scene->schema->type_count; ++type) {
        if (scene->schema->types[type]->category == CATEGORY_SHAPE && scene->tables[type].count) {
            if (only != NONE_ID) {
                return NONE_ID;
            }
            only = type;
        }
    }
    return only;
}

// Sorts a group's shapes by their types; c->type_starts[type] is then the first of each.
static void sort_types(Collector *c, uint32_t *ids, uint32_t count)
{
    const uint32_t type_count = (uint32_t)c->scene->schema->type_count;
    const uint32_t only = only_type(c->scene);
    if (only == NONE_ID) {
        sort_ids(c->scene, type_key, type_count, ids, count, c->type_starts, c->sorted);
        memcpy(ids, c->sorted, count * sizeof *ids);
        return;
    }
    for (uint32_t type = 0; type <= type_count; ++type) {
        c->type_starts[type] = type <= only ? 0 : count;
    }
}

// The kinds of a group whose bounds are set; `inner` is a pocket that it has already, or 0.
static bool collect_kinds(Collector *c, AccelGroup *group, uint32_t prototype, uint32_t *ids,
                          uint32_t count, uint32_t inner)
{
    const uint32_t type_count = (uint32_t)c->scene->schema->type_count;
    sort_types(c, ids, count);
    c->kinds.count = c->group_pockets.count = 0;
    if (inner && !array_push(&c->group_pockets, inner)) {
        return false;
    }
    for (uint32_t type = 0; type < type_count; ++type) {
        const uint32_t begin = c->type_starts[type], end = c->type_starts[type + 1];
        if (begin < end &&
            !collect_kind(c, group, prototype, (uint16_t)type, ids + begin, end - begin)) {
            return false;
        }
    }
    return move_array((void **)&group->kinds, &group->kind_count, c->kinds.items, c->kinds.count,
                      sizeof *group->kinds) &&
           move_array((void **)&group->pockets, &group->pocket_count, c->group_pockets.items,
                      c->group_pockets.count, sizeof *group->pockets);
}

// A group of shapes and, where `instances` isn't empty, of the world's instances.
static bool collect_group(Collector *c, AccelGroup *group, uint32_t prototype, uint32_t *ids,
                          uint32_t count, Box3 instances, int nested)
{
    // What isn't finite is counted once.
    AccelIssues ignored = {0, 0}, *issues = nested ? &ignored : &c->accel->issues;
    Reaches reaches = {.middle = median_middle(c->scene, ids, count)};
    Box3 box = all_boxes(c->accel, ids, count, issues, &reaches);
    if (!box3_is_empty(instances)) {
        box = box3_union(box, instances);
    }
    group_set_bounds(group, box);
    bool inside = false;
    const uint32_t outer = nested < MOST_NESTED
                               ? split_outliers(c->scene, ids, count, &reaches, instances, &inside)
                               : count;
    uint32_t number = 0;
    if (outer < count || inside) {
        AccelGroup inner = {.accel = c->accel};
        const bool ok = collect_group(c, &inner, prototype, ids + outer, count - outer,
                                      inside ? instances : box3_empty(), nested + 1);
        number = (uint32_t)(c->scene->prototypes.count + c->pockets.count);
        if (!ok || !array_push(&c->pockets, inner)) {
            mem_free(inner.kinds);
            mem_free(inner.pockets);
            return false;
        }
    }
    if (!inside && !box3_is_empty(instances)) {
        group->instance_count = (uint32_t)c->scene->instances.count;
    }
    return collect_kinds(c, group, prototype, ids, outer, number);
}

// Unbounded shapes of prototypes once for each instance.
static bool spread_unbounded(Collector *c)
{
    const Scene *scene = c->scene;
    UnboundedArray all = {0};
    bool ok = true;
    for (size_t i = 0; ok && i < c->unbounded.count; ++i) {
        AccelUnbounded it = c->unbounded.items[i];
        if (it.instance == 0) {
            ok = array_push(&all, (AccelUnbounded){it.shape, NONE_ID});
            continue;
        }
        for (size_t k = 0; ok && k < scene->instances.count; ++k) {
            if (scene->instances.items[k].prototype == it.instance) {
                ok = array_push(&all, (AccelUnbounded){it.shape, (uint32_t)k});
            }
        }
    }
    c->accel->unbounded = all.items;
    c->accel->unbounded_count = (uint32_t)all.count;
    return ok;
}

// Joins the pockets to the groups, and tells every part where it belongs.
static bool join_groups(Collector *c)
{
    Accel *accel = c->accel;
    size_t prototypes = c->scene->prototypes.count;
    AccelGroup *groups = mem_realloc(accel->groups, prototypes + c->pockets.count, sizeof *groups);
    if (!groups) {
        return false;
    }
    accel->groups = groups;
    if (c->pockets.count) {
        memcpy(groups + prototypes, c->pockets.items, c->pockets.count * sizeof *groups);
    }
    accel->group_count = (uint32_t)(prototypes + c->pockets.count);
    c->pockets.count = 0; // their kinds belong to the accelerator now
    for (uint32_t g = 0; g < accel->group_count; ++g) {
        for (uint32_t k = 0; k < groups[g].kind_count; ++k) {
            groups[g].kinds[k].group = &groups[g];
        }
    }
    return true;
}

static bool collect_all(Collector *c, uint32_t *starts)
{
    Accel *accel = c->accel;
    const Scene *scene = c->scene;
    uint32_t prototypes = (uint32_t)scene->prototypes.count;
    uint32_t count = (uint32_t)scene->nodes[CATEGORY_SHAPE].count;
    sort_ids(scene, prototype_key, prototypes, NULL, count, starts, accel->order);
    // The world last, since its box has those of the instances.
    for (uint32_t left = prototypes; left-- > 0;) {
        uint32_t *ids = accel->order + starts[left], size = starts[left + 1] - starts[left];
        const Box3 instances = left == 0 ? all_boxes(accel, NULL, (uint32_t)scene->instances.count,
                                                     &accel->issues, NULL)
                                         : box3_empty();
        if (!collect_group(c, &accel->groups[left], left, ids, size, instances, 0)) {
            return false;
        }
    }
    return spread_unbounded(c) && join_groups(c);
}

bool accel_collect(Accel *accel)
{
    const Scene *scene = accel->scene;
    size_t prototypes = scene->prototypes.count, shapes = scene->nodes[CATEGORY_SHAPE].count;
    Collector c = {.accel = accel, .scene = scene};
    uint32_t *starts = mem_alloc(prototypes + 1, sizeof *starts);
    c.type_starts = mem_alloc(scene->schema->type_count + 1, sizeof *c.type_starts);
    c.sorted = mem_alloc(shapes, sizeof *c.sorted);
    accel->order = mem_alloc(shapes, sizeof *accel->order);
    accel->groups = mem_alloc_zeroed(prototypes, sizeof *accel->groups);
    bool ok = starts && c.type_starts && c.sorted && accel->order && accel->groups;
    if (ok) {
        accel->group_count = (uint32_t)prototypes;
        for (size_t i = 0; i < prototypes; ++i) {
            accel->groups[i].accel = accel;
        }
        ok = collect_all(&c, starts);
    }
    for (size_t i = 0; i < c.pockets.count; ++i) {
        mem_free(c.pockets.items[i].kinds);
        mem_free(c.pockets.items[i].pockets);
    }
    array_free(&c.pockets);
    array_free(&c.group_pockets);
    array_free(&c.kinds);
    array_free(&c.unbounded);
    mem_free(starts);
    mem_free(c.type_starts);
    mem_free(c.sorted);
    return ok;
}

// Maps are kept for the first transforms only: where each of a million shapes has its own, making
// one anew costs less than a miss in all caches, and memory.
enum { KEPT_MAPS = 1 << 14 };

bool accel_keep_maps(Accel *accel)
{
    const Scene *scene = accel->scene;
    const size_t count = scene->transforms.count;
    accel->map_count = count < KEPT_MAPS ? count : KEPT_MAPS;
    accel->maps = mem_alloc(accel->map_count, sizeof *accel->maps);
    for (size_t i = 0; accel->maps && i < accel->map_count; ++i) {
        accel->maps[i] = space_map(&scene->transforms.items[i], &scene->inverses.items[i]);
    }
    return accel->maps != NULL;
}

void accel_collect_free(Accel *accel)
{
    for (uint32_t i = 0; i < accel->group_count; ++i) {
        for (uint32_t k = 0; k < accel->groups[i].kind_count; ++k) {
            mem_free(accel->groups[i].kinds[k].runs);
            mem_free(accel->groups[i].kinds[k].balls_memory);
        }
        mem_free(accel->groups[i].kinds);
        mem_free(accel->groups[i].pockets);
        mem_free(accel->groups[i].geometries);
        mem_free(accel->groups[i].sweep_memory);
    }
    mem_free(accel->groups);
    mem_free(accel->flats);
    mem_free(accel->maps);
    mem_free(accel->order);
    mem_free(accel->unbounded);
}
