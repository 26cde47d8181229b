#include "render/light_tree.h"

#include "base/mem.h"

struct LightTreeNode {
    Vec3 center; // of the sphere about the box of the lights below
    double radius;
    float axis[3]; // of the cone: all normals within θo of it, all emission within θe of those
    float intensity;
    float cos_normals, sin_normals, cos_emission;
    uint32_t child; // the second child's number (the first follows its parent), or LEAF | item
};

#define LEAF 0x80000000u

// --- Importance ----------------------------------------------------------------------------------

// Cosines this little beyond a cone's border still count as inside: the cone's own numbers are
// floats. What is inside counts by its cosine, but not by less than FLOOR.
#define SLACK 1e-5
#define FLOOR 1e-3

// cos max(0, a - b) and its sine; angles in [0, π].
static double cos_less(double cos_a, double sin_a, double cos_b, double sin_b)
{
    return cos_a > cos_b ? 1 : cos_a * cos_b + sin_a * sin_b;
}
static double sin_less(double cos_a, double sin_a, double cos_b, double sin_b)
{
    return cos_a > cos_b ? 0 : sin_a * cos_b - cos_a * sin_b;
}

static double sine(double cosine)
{
    return sqrt(fmax(0, 1 - cosine * cosine));
}

// A bound on how the emission towards the point falls off with the angle: the angle from the cone's
// axis, less θo, less θu, under which the lights are seen. 0 beyond θe.
static double emission_factor(const LightTreeNode *node, Vec3 to_light, double cos_u, double sin_u)
{
    double cos_a = -((double)node->axis[0] * to_light.x + (double)node->axis[1] * to_light.y +
                     (double)node->axis[2] * to_light.z);
    double sin_a = sine(cos_a), cos_o = (double)node->cos_normals,
           sin_o = (double)node->sin_normals;
    double cos_b = cos_less(cos_a, sin_a, cos_o, sin_o);
    double sin_b = sin_less(cos_a, sin_a, cos_o, sin_o);
    double cosine = cos_less(cos_b, sin_b, cos_u, sin_u);
    return cosine < (double)node->cos_emission - SLACK ? 0 : fmax(cosine, FLOOR);
}

static double reception_factor(Vec3 normal, Vec3 to_light, double cos_u, double sin_u)
{
    double cos_i = dot(normal, to_light);
    double cosine = cos_less(cos_i, sine(cos_i), cos_u, sin_u);
    return cosine < -SLACK ? 0 : fmax(cosine, FLOOR);
}

// Nearer than this part of the radius, squared, a light is not taken to be. A square that emits
// diffusely gives π L at most, where its distance counts as 0.8 radii. Of a group the nearest light
// can be as near as it likes: with the paper's 1 the relative variance under 2500 lamps is 22, with
// 1/3 5, with 1/10 and less 3 (tests/unit/render/light_choice_test.c).
#define NEAREST_LIGHT 0.64
#define NEAREST_GROUP 0.1

// The paper's equation 3: intensity, falling off with the square of the distance, bounded by both
// cosines.
static double importance(const LightTreeNode *node, const LightReceiver *at)
{
    Vec3 to = sub(node->center, at->p);
    double d2 = length_squared(to), r2 = node->radius * node->radius;
    double nearest = node->child & LEAF ? NEAREST_LIGHT : NEAREST_GROUP;
    double irradiance = (double)node->intensity / fmax(d2, nearest * r2);
    if (!(irradiance < 1e150)) {
        return r2 > 0 || d2 > 0 ? 1e150 : 0;
    }
    if (d2 <= r2) {
        return irradiance;
    }
    double inverse = 1 / sqrt(d2), sin_u = node->radius * inverse, cos_u = sine(sin_u);
    Vec3 direction = scale(to, inverse);
    irradiance *= emission_factor(node, direction, cos_u, sin_u);
    if (irradiance > 0 && length_squared(at->normal) > 0) {
        irradiance *= reception_factor(at->normal, direction, cos_u, sin_u);
    }
    return irradiance;
}

double light_tree_importance(const LightTree *tree, const LightReceiver *at)
{
    return importance(tree->nodes, at);
}

// The chance of the first of a node's two children; negative where none shines on the point.
static double first_chance(const LightTree *tree, uint32_t node, const LightReceiver *at)
{
    double first = importance(&tree->nodes[node + 1], at);
    double second = importance(&tree->nodes[tree->nodes[node].child], at);
    return first + second > 0 ? first / (first + second) : -1;
}

uint32_t light_tree_choose(const LightTree *tree, const LightReceiver *at, double u, double *chance)
{
    uint32_t node = 0;
    *chance = 1;
    while (!(tree->nodes[node].child & LEAF)) {
        double p = first_chance(tree, node, at);
        if (p < 0) {
            return NONE_ID;
        }
        if (u < p) {
            u /= p;
            *chance *= p;
            node = node + 1;
        } else {
            u = (u - p) / (1 - p);
            *chance *= 1 - p;
            node = tree->nodes[node].child;
        }
        u = fmin(u, 1 - 0x1p-53);
    }
    return tree->nodes[node].child & ~LEAF;
}

double light_tree_chance(const LightTree *tree, const LightReceiver *at, uint32_t item)
{
    uint32_t node = 0;
    double chance = 1;
    for (uint64_t trail = tree->trails[item]; !(tree->nodes[node].child & LEAF); trail >>= 1) {
        double p = first_chance(tree, node, at);
        p = trail & 1 ? 1 - p : p;
        if (!(p > 0) || p > 1) {
            return 0;
        }
        chance *= p;
        node = trail & 1 ? tree->nodes[node].child : node + 1;
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

enum { BUCKETS = 12, DEEP = 31 };

typedef struct Cluster {
    Box3 bounds;
    LightCone cone;
    double intensity;
    uint32_t count;
} Cluster;

typedef struct TreeBuilder {
    LightTree *tree;
    const LightTreeItem *items;
    uint32_t *order; // numbers of items; a node's are a run of it
    uint32_t used;   // nodes
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

static void set_node(LightTreeNode *node, const Cluster *cluster)
{
    node->center = box3_center(cluster->bounds);
    // Rounded up, so that the sphere holds the box.
    double diagonal = length(sub(cluster->bounds.max, cluster->bounds.min));
    node->radius = diagonal / 2 * (1 + 1e-12) + 1e-15 * length(node->center) * (diagonal > 0);
    node->axis[0] = (float)cluster->cone.axis.x;
    node->axis[1] = (float)cluster->cone.axis.y;
    node->axis[2] = (float)cluster->cone.axis.z;
    node->intensity = (float)fmin(fmax(cluster->intensity, 1e-37), 1e38);
    node->cos_normals = (float)cos(cluster->cone.normals);
    node->sin_normals = (float)sin(cluster->cone.normals);
    node->cos_emission = (float)cos(cluster->cone.emission);
}

static uint32_t build_node(TreeBuilder *b, uint32_t first, uint32_t count, int depth,
                           uint64_t trail)
{
    uint32_t number = b->used++;
    LightTreeNode *node = &b->tree->nodes[number];
    Cluster cluster = {0};
    for (uint32_t i = first; i < first + count; ++i) {
        cluster_add_item(&cluster, &b->items[b->order[i]]);
    }
    set_node(node, &cluster);
    if (count == 1) {
        node->child = LEAF | b->order[first];
        b->tree->trails[b->order[first]] = trail;
        return number;
    }
    uint32_t left = divide(b, first, count, depth);
    build_node(b, first, left, depth + 1, trail);
    node->child =
        build_node(b, first + left, count - left, depth + 1, trail | UINT64_C(1) << depth);
    return number;
}

bool light_tree_build(LightTree *tree, Arena *arena, const LightTreeItem *items, uint32_t count)
{
    *tree = (LightTree){.count = count};
    if (count == 0) {
        return true;
    }
    uint32_t *order = mem_alloc(count, sizeof *order);
    tree->nodes =
        count < LEAF / 2 ? arena_array(arena, 2 * (size_t)count - 1, sizeof *tree->nodes) : NULL;
    tree->trails = arena_array(arena, count, sizeof *tree->trails);
    bool good = order && tree->nodes && tree->trails;
    if (good) {
        for (uint32_t i = 0; i < count; ++i) {
            order[i] = i;
        }
        TreeBuilder builder = {tree, items, order, 0};
        build_node(&builder, 0, count, 0, 0);
    }
    mem_free(order);
    return good;
}
