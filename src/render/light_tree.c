#include "render/light_tree.h"

#include "base/mem.h"

#include <string.h>

#define LEAF 0x80000000u

// Each node has up to eight children, side by side so that vectors hold them, in single precision.
// Lengths are in units of the tree's radius, intensities parts of the whole.
enum { WIDTH = 8 };
// Below DEEP lights are halved by number.
enum { DEEP = 31, MAX_DEPTH = 64 };

struct LightTreeNode {
    double x[WIDTH], y[WIDTH], z[WIDTH]; // of the sphere about the box of the lights below, m
    float radius[WIDTH];
    float least[WIDTH]; // square of the distance that the lights are taken to have at least
    float intensity[WIDTH];
    // Of the cone: all normals within θo of its axis, all emission within θe of those.
    float axis_x[WIDTH], axis_y[WIDTH], axis_z[WIDTH];
    float cos_normals[WIDTH], sin_normals[WIDTH], cos_emission[WIDTH];
    uint32_t child[WIDTH]; // a node, or LEAF | item
    uint32_t place;        // where it hangs: its parent's number times WIDTH plus the child's
    bool all_around;       // all children shine in all directions
};

// --- Importance ----------------------------------------------------------------------------------

// Cosines this little beyond a cone's border still count as inside, since all numbers are floats.
// What is inside counts by its cosine, but not by less than FLOOR.
#define SLACK 1e-5F
#define FLOOR 1e-3F

// Nearer than this part of the radius, squared, a light is not taken to be. A square that emits
// diffusely gives π L at most, where its distance counts as 0.8 radii. Of a group the nearest light
// can be as near as it likes: the relative variance under 2500 lamps is 1.21, and 1.38 with 1/4
// (tests/unit/render/light_choice_test.c).
#define NEAREST_LIGHT 0.64
#define NEAREST_GROUP 0.1
#define NEAREST       1e-30F

static inline float least_of(float a, float b)
{
    return a < b ? a : b;
}
static inline float most_of(float a, float b)
{
    return a > b ? a : b;
}
static inline float sine(float cosine)
{
    return sqrtf(most_of(0, 1 - cosine * cosine));
}

// Under which the children are seen.
typedef struct Seen {
    float x[WIDTH], y[WIDTH], z[WIDTH]; // unit directions to the middles
    float cos_u[WIDTH], sin_u[WIDTH];   // of the angle θu that covers a child about its middle
} Seen;

// The paper's equation 3: intensity, falling off with the square of the distance …
static inline void weigh_by_distance(const LightTreeNode *node, double scale, Vec3 p, Seen *seen,
                                     float weights[WIDTH])
{
    for (int i = 0; i < WIDTH; ++i) {
        seen->x[i] = (float)((node->x[i] - p.x) * scale);
        seen->y[i] = (float)((node->y[i] - p.y) * scale);
        seen->z[i] = (float)((node->z[i] - p.z) * scale);
    }
    for (int i = 0; i < WIDTH; ++i) {
        const float x = seen->x[i], y = seen->y[i], z = seen->z[i];
        const float d2 = x * x + y * y + z * z;
        const float inverse = 1 / sqrtf(most_of(d2, NEAREST));
        const float sin_u = least_of(node->radius[i] * inverse, 1);
        weights[i] = node->intensity[i] / most_of(d2, node->least[i]);
        seen->x[i] = x * inverse;
        seen->y[i] = y * inverse;
        seen->z[i] = z * inverse;
        seen->sin_u[i] = sin_u;
        seen->cos_u[i] = sin_u < 1 ? sine(sin_u) : -1; // from inside nothing is told apart
    }
}

// … times how the emission towards the point falls off with the angle: the angle from the cone's
// axis, less θo, less θu, is a bound, which is 0 beyond θe; counted is what lies midway between it
// and the angle less θo alone, since that is nearer to the mean over a group …
static inline void weigh_by_emission(const LightTreeNode *node, const Seen *seen,
                                     float weights[WIDTH])
{
    for (int i = 0; i < WIDTH; ++i) {
        const float cos_o = node->cos_normals[i], sin_o = node->sin_normals[i];
        const float cos_u = seen->cos_u[i], sin_u = seen->sin_u[i];
        const float cos_a = -(node->axis_x[i] * seen->x[i] + node->axis_y[i] * seen->y[i] +
                              node->axis_z[i] * seen->z[i]);
        const float sin_a = sine(cos_a);
        const float cos_b = cos_a > cos_o ? 1 : cos_a * cos_o + sin_a * sin_o;
        const float sin_b = cos_a > cos_o ? 0 : sin_a * cos_o - cos_a * sin_o;
        const float cosine = cos_b > cos_u ? 1 : cos_b * cos_u + sin_b * sin_u;
        const float midway = 0.5F * (cosine + most_of(cos_b, 0));
        weights[i] *= cosine < node->cos_emission[i] - SLACK ? 0 : most_of(midway, FLOOR);
    }
}

// … and the cosine at the point, in the same way.
static inline void weigh_by_reception(Vec3 normal, const Seen *seen, float weights[WIDTH])
{
    const float nx = (float)normal.x, ny = (float)normal.y, nz = (float)normal.z;
    for (int i = 0; i < WIDTH; ++i) {
        const float cos_u = seen->cos_u[i], sin_u = seen->sin_u[i];
        const float cos_i = nx * seen->x[i] + ny * seen->y[i] + nz * seen->z[i];
        const float cosine = cos_i > cos_u ? 1 : cos_i * cos_u + sine(cos_i) * sin_u;
        const float midway = 0.5F * (cosine + most_of(cos_i, 0));
        weights[i] *= cosine < -SLACK ? 0 : most_of(midway, FLOOR);
    }
}

// The importance of a node's children, and their sum.
static double weigh(const LightTree *tree, const LightTreeNode *node, const LightReceiver *at,
                    float weights[WIDTH])
{
    Seen seen;
    weigh_by_distance(node, tree->scale, at->p, &seen, weights);
    if (!node->all_around) {
        weigh_by_emission(node, &seen, weights);
    }
    if (at->normal.x != 0 || at->normal.y != 0 || at->normal.z != 0) {
        weigh_by_reception(at->normal, &seen, weights);
    }
    double sum = 0;
    for (int i = 0; i < WIDTH; ++i) {
        sum += (double)weights[i];
    }
    return sum;
}

double light_tree_importance(const LightTree *tree, const LightReceiver *at)
{
    float weights[WIDTH];
    return weigh(tree, tree->nodes, at, weights) * tree->unit;
}

uint32_t light_tree_choose(const LightTree *tree, const LightReceiver *at, double u, double *chance)
{
    uint32_t number = 0;
    *chance = 1;
    for (;;) {
        const LightTreeNode *node = &tree->nodes[number];
        float weights[WIDTH];
        const double sum = weigh(tree, node, at, weights);
        if (!(sum > 0)) {
            return NONE_ID;
        }
        double rest = u * sum;
        uint32_t i = 0, last = 0;
        for (; i < WIDTH && !(rest < (double)weights[i]); ++i) {
            rest -= (double)weights[i];
            last = weights[i] > 0 ? i : last;
        }
        if (i == WIDTH) { // by rounding
            i = last;
            rest = (double)weights[i];
        }
        u = smaller(rest / (double)weights[i], 1 - 0x1p-53);
        *chance *= (double)weights[i] / sum;
        number = node->child[i];
        if (number & LEAF) {
            return number & ~LEAF;
        }
    }
}

double light_tree_chance(const LightTree *tree, const LightReceiver *at, uint32_t item)
{
    uint32_t way[MAX_DEPTH], length = 0; // places from the item up to the root
    for (uint32_t place = tree->places[item]; length < MAX_DEPTH;) {
        way[length++] = place;
        if (place / WIDTH == 0) {
            break;
        }
        place = tree->nodes[place / WIDTH].place;
    }
    double chance = 1;
    while (length > 0 && chance > 0) {
        const uint32_t place = way[--length];
        float weights[WIDTH];
        const double sum = weigh(tree, &tree->nodes[place / WIDTH], at, weights);
        chance = sum > 0 ? chance * ((double)weights[place % WIDTH] / sum) : 0;
    }
    return chance;
}

// --- Cones ---------------------------------------------------------------------------------------

static double angle_between(Vec3 a, Vec3 b)
{
    return atan2(length(cross(a, b)), dot(a, b));
}

// The smallest cone about two: the paper's algorithm 1.
static LightCone cone_union(LightCone a, LightCone b)
{
    if (b.normals > a.normals) {
        LightCone swap = a;
        a = b;
        b = swap;
    }
    double between = angle_between(a.axis, b.axis), emission = fmax(a.emission, b.emission);
    if (fmin(between + b.normals, PI) <= a.normals) {
        return (LightCone){a.axis, a.normals, emission};
    }
    double normals = (a.normals + between + b.normals) / 2;
    Vec3 turn = cross(a.axis, b.axis);
    if (normals >= PI || !(length_squared(turn) > 0)) {
        return (LightCone){a.axis, PI, emission};
    }
    Affine rotation = affine_rotation(turn, normals - a.normals);
    return (LightCone){normalize(transform_vector(&rotation, a.axis)), normals, emission};
}

// The paper's M_Ω: the solid angle that a cone shines into, weighted by the cosine beyond θo.
static double cone_measure(LightCone cone)
{
    double o = cone.normals, w = fmin(o + cone.emission, PI);
    return 2 * PI * (1 - cos(o)) +
           PI / 2 * (2 * w * sin(o) - cos(o - 2 * w) - 2 * o * sin(o) + cos(o));
}

// --- Building ------------------------------------------------------------------------------------

enum { BUCKETS = 12 };

typedef struct Cluster {
    Box3 bounds;
    LightCone cone;
    double intensity;
    uint32_t count;
} Cluster;

// A node of the tree of two children each that is built first.
typedef struct Pair {
    Vec3 center;
    double radius, intensity, cost;
    LightCone cone;
    uint32_t child; // the second child's number (the first follows its parent), or LEAF | item
} Pair;

typedef struct TreeBuilder {
    LightTree *tree;
    Pair *pairs;
    const LightTreeItem *items;
    uint32_t *order; // numbers of items; a node's are a run of it
    uint32_t used;   // pairs
} TreeBuilder;

static void cluster_add(Cluster *cluster, Box3 bounds, LightCone cone, double intensity,
                        uint32_t count)
{
    if (count == 0) {
        return;
    }
    cluster->cone = cluster->count ? cone_union(cluster->cone, cone) : cone;
    cluster->bounds = cluster->count ? box3_union(cluster->bounds, bounds) : bounds;
    cluster->intensity += intensity;
    cluster->count += count;
}

static void cluster_add_item(Cluster *cluster, const LightTreeItem *item)
{
    cluster_add(cluster, item->bounds, item->cone, item->intensity, 1);
}

// Surface area orientation heuristic, but for the measure of a box: its area would vanish for
// lights in a row, the square of its diagonal does not.
static double cluster_cost(const Cluster *cluster)
{
    Vec3 size = sub(cluster->bounds.max, cluster->bounds.min);
    return cluster->intensity * cone_measure(cluster->cone) * length_squared(size);
}

static uint32_t bucket_of(const LightTreeItem *item, Box3 centers, int axis)
{
    double low = vec3_get(centers.min, axis), size = vec3_get(centers.max, axis) - low;
    double place = (vec3_get(box3_center(item->bounds), axis) - low) / size * BUCKETS;
    return place < BUCKETS ? (uint32_t)place : BUCKETS - 1;
}

// The cheapest of the splits between buckets along one axis: the items of buckets up to *split go
// to the first child.
static double best_split(const TreeBuilder *b, uint32_t first, uint32_t count, Box3 centers,
                         int axis, uint32_t *split)
{
    Cluster buckets[BUCKETS] = {0}, below = {0};
    double costs[BUCKETS] = {0}, best = INFINITY;
    for (uint32_t i = first; i < first + count; ++i) {
        const LightTreeItem *item = &b->items[b->order[i]];
        cluster_add_item(&buckets[bucket_of(item, centers, axis)], item);
    }
    Cluster above = {0};
    for (int i = BUCKETS - 1; i > 0; --i) {
        const Cluster *k = &buckets[i];
        cluster_add(&above, k->bounds, k->cone, k->intensity, k->count);
        costs[i - 1] = above.count ? cluster_cost(&above) : INFINITY;
    }
    for (uint32_t i = 0; i + 1 < BUCKETS; ++i) {
        const Cluster *k = &buckets[i];
        cluster_add(&below, k->bounds, k->cone, k->intensity, k->count);
        double cost = below.count ? cluster_cost(&below) + costs[i] : INFINITY;
        if (cost < best) {
            best = cost;
            *split = i;
        }
    }
    return best;
}

// Moves the items of the first child to the front; returns how many they are.
static uint32_t partition(TreeBuilder *b, uint32_t first, uint32_t count, Box3 centers, int axis,
                          uint32_t split)
{
    uint32_t end = first;
    for (uint32_t i = first; i < first + count; ++i) {
        uint32_t item = b->order[i];
        if (bucket_of(&b->items[item], centers, axis) <= split) {
            b->order[i] = b->order[end];
            b->order[end++] = item;
        }
    }
    return end - first;
}

// Halves by number where nothing tells the items apart, and below a depth that a sensible tree
// doesn't reach, so that no way is longer than 64.
static uint32_t divide(TreeBuilder *b, uint32_t first, uint32_t count, int depth)
{
    Box3 centers = box3_empty();
    for (uint32_t i = first; i < first + count; ++i) {
        centers = box3_add(centers, box3_center(b->items[b->order[i]].bounds));
    }
    Vec3 size = sub(centers.max, centers.min);
    double best = INFINITY, longest = max_component(size);
    int best_axis = -1;
    uint32_t best_at = 0;
    for (int axis = 0; axis < 3 && depth < DEEP; ++axis) {
        uint32_t split = 0;
        double extent = vec3_get(size, axis);
        if (!(extent > 0)) {
            continue;
        }
        // Thin boxes are discouraged by the ratio of the axes.
        double cost = best_split(b, first, count, centers, axis, &split) * (longest / extent);
        if (cost < best) {
            best = cost;
            best_axis = axis;
            best_at = split;
        }
    }
    uint32_t left = best_axis < 0 ? 0 : partition(b, first, count, centers, best_axis, best_at);
    return left > 0 && left < count ? left : count / 2;
}

static void set_pair(Pair *pair, const Cluster *cluster)
{
    pair->center = box3_center(cluster->bounds);
    // Rounded up, so that the sphere holds the box.
    double diagonal = length(sub(cluster->bounds.max, cluster->bounds.min));
    pair->radius = diagonal / 2 * (1 + 1e-12) + 1e-15 * length(pair->center) * (diagonal > 0);
    pair->intensity = cluster->intensity;
    pair->cone = cluster->cone;
    pair->cost = cluster_cost(cluster);
}

static uint32_t build_pair(TreeBuilder *b, uint32_t first, uint32_t count, int depth)
{
    uint32_t number = b->used++;
    Pair *pair = &b->pairs[number];
    Cluster cluster = {0};
    for (uint32_t i = first; i < first + count; ++i) {
        cluster_add_item(&cluster, &b->items[b->order[i]]);
    }
    set_pair(pair, &cluster);
    if (count == 1) {
        pair->child = LEAF | b->order[first];
        return number;
    }
    uint32_t left = divide(b, first, count, depth);
    build_pair(b, first, left, depth + 1);
    pair->child = build_pair(b, first + left, count - left, depth + 1);
    return number;
}

// --- From pairs to nodes -------------------------------------------------------------------------

// The children of a node: the dearest pair is opened until there are eight.
static uint32_t gather(const TreeBuilder *b, uint32_t root, uint32_t out[WIDTH])
{
    uint32_t count = 1;
    out[0] = root;
    while (count < WIDTH) {
        uint32_t dearest = WIDTH;
        for (uint32_t i = 0; i < count; ++i) {
            const Pair *pair = &b->pairs[out[i]];
            if (!(pair->child & LEAF) &&
                (dearest == WIDTH || pair->cost > b->pairs[out[dearest]].cost)) {
                dearest = i;
            }
        }
        if (dearest == WIDTH) {
            break;
        }
        const uint32_t opened = out[dearest];
        out[dearest] = opened + 1;
        out[count++] = b->pairs[opened].child;
    }
    return count;
}

// Children that aren't there have no intensity.
static void set_child(const TreeBuilder *b, LightTreeNode *node, uint32_t i, const Pair *pair)
{
    const LightTree *tree = b->tree;
    const Vec3 axis = pair->cone.axis;
    const double nearest = pair->child & LEAF ? NEAREST_LIGHT : NEAREST_GROUP;
    const double radius = smaller(pair->radius * tree->scale, 2);
    node->x[i] = pair->center.x;
    node->y[i] = pair->center.y;
    node->z[i] = pair->center.z;
    node->radius[i] = (float)(radius * (1 + 1e-6));
    node->least[i] = most_of((float)(nearest * radius * radius), NEAREST);
    node->intensity[i] = (float)larger(pair->intensity / b->pairs[0].intensity, (double)NEAREST);
    node->axis_x[i] = (float)axis.x;
    node->axis_y[i] = (float)axis.y;
    node->axis_z[i] = (float)axis.z;
    node->cos_normals[i] = (float)cos(pair->cone.normals);
    node->sin_normals[i] = (float)sin(pair->cone.normals);
    node->cos_emission[i] = (float)cos(pair->cone.emission);
    node->all_around = node->all_around && pair->cone.normals >= PI;
}

static uint32_t set_node(TreeBuilder *b, uint32_t root, uint32_t place)
{
    const uint32_t number = b->used++;
    LightTreeNode *node = &b->tree->nodes[number];
    uint32_t pairs[WIDTH];
    const uint32_t count = gather(b, root, pairs);
    *node = (LightTreeNode){.place = place, .all_around = true};
    for (uint32_t i = 0; i < WIDTH; ++i) {
        node->least[i] = 1;
    }
    for (uint32_t i = 0; i < count; ++i) {
        const Pair *pair = &b->pairs[pairs[i]];
        set_child(b, node, i, pair);
        if (pair->child & LEAF) {
            node->child[i] = pair->child;
            b->tree->places[pair->child & ~LEAF] = number * WIDTH + i;
        } else {
            node->child[i] = set_node(b, pairs[i], number * WIDTH + i);
        }
    }
    return number;
}

static uint32_t count_nodes(const TreeBuilder *b, uint32_t root)
{
    uint32_t pairs[WIDTH], sum = 1;
    const uint32_t count = gather(b, root, pairs);
    for (uint32_t i = 0; i < count; ++i) {
        sum += b->pairs[pairs[i]].child & LEAF ? 0 : count_nodes(b, pairs[i]);
    }
    return sum;
}

static bool build(TreeBuilder *b, Arena *arena, uint32_t count)
{
    LightTree *tree = b->tree;
    for (uint32_t i = 0; i < count; ++i) {
        b->order[i] = i;
    }
    build_pair(b, 0, count, 0);
    const Pair *root = &b->pairs[0];
    tree->scale = root->radius > 0 ? 1 / root->radius : 1;
    tree->unit = root->intensity * tree->scale * tree->scale;
    tree->nodes = arena_array(arena, count_nodes(b, 0), sizeof *tree->nodes);
    tree->places = arena_array(arena, count, sizeof *tree->places);
    if (!tree->nodes || !tree->places) {
        return false;
    }
    b->used = 0;
    set_node(b, 0, 0);
    return true;
}

bool light_tree_build(LightTree *tree, Arena *arena, const LightTreeItem *items, uint32_t count)
{
    *tree = (LightTree){.count = count};
    if (count == 0) {
        return true;
    }
    if (count >= LEAF / WIDTH) {
        return false;
    }
    TreeBuilder b = {.tree = tree,
                     .pairs = mem_alloc(2 * (size_t)count - 1, sizeof *b.pairs),
                     .order = mem_alloc(count, sizeof *b.order),
                     .items = items};
    const bool good = b.pairs && b.order && build(&b, arena, count);
    mem_free(b.pairs);
    mem_free(b.order);
    return good;
}
