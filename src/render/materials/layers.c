#include "render/materials/layers.h"

#include "base/hash.h"
#include "render/world.h"

#include <string.h>

// --- Points
// ---------------------------------------------------------------------------------------

void layers_at(const ShadingPoint *point, uint32_t coat, uint32_t base, Rgb depth, Layers *out)
{
    Frame f = point->frame;
    if (point->wo_side <= 0) {
        f = (Frame){f.s, neg(f.t), neg(f.n)};
    }
    out->surface = *point->surface;
    out->surface.geometric = out->surface.shading = f.n;
    out->surface.front = true;
    out->point = *point;
    out->point.surface = &out->surface;
    out->point.frame = f;
    out->point.geometric = vec3(0, 0, 1);
    out->coat = coat;
    out->base = base;
    out->depth = depth;
}

static float absorbed(float depth, double cosine)
{
    return depth > 0 ? (float)exp(-(double)depth / cosine) : 1;
}

// What is left of light that crosses the coat in direction w.
static Rgb crossed(const Layers *layers, Vec3 w)
{
    double c = fabs(w.z);
    Rgb d = layers->depth;
    return rgb(absorbed(d.r, c), absorbed(d.g, c), absorbed(d.b, c));
}

// --- Random numbers
// -------------------------------------------------------------------------------

typedef struct WalkRandom {
    uint64_t state;
} WalkRandom;

static float draw(WalkRandom *random)
{
    return (float)(hash_u64(random->state++) >> 40) * 0x1p-24f;
}

static uint64_t hash_vec3(Vec3 v)
{
    uint64_t bits[3];
    memcpy(bits, &v, sizeof bits);
    return hash_u64(bits[0] ^ hash_u64(bits[1] ^ hash_u64(bits[2])));
}

// Symmetric in the directions.
static WalkRandom walk_random(const Layers *layers, Vec3 a, Vec3 b)
{
    return (WalkRandom){hash_u64(hash_vec3(a) + hash_vec3(b)) ^ hash_vec3(layers->surface.p)};
}

static bool sample_coat(const Layers *layers, Vec3 w, MaterialLayer part, WalkRandom *random,
                        BsdfSample *out)
{
    ShadingPoint point = layers_coat(layers, w, part);
    float lobe = draw(random), u = draw(random), v = draw(random);
    return material_sample(&point, layers->coat, lobe, u, v, out);
}

static bool sample_base(const Layers *layers, Vec3 w, WalkRandom *random, BsdfSample *out)
{
    ShadingPoint point = layers_base(layers, w);
    float lobe = draw(random), u = draw(random), v = draw(random);
    return material_sample(&point, layers->base, lobe, u, v, out) && out->wi.z > 0;
}

// --- From the light ---------------------------------------------------------------------------

// Ways on which light reaches a place between the layers meeting delta lobes alone, or at first one
// smooth lobe of the coat. Every path is made once: its last smooth event is the one at which a
// walk from the viewer is joined to one of these. Only the coat's smooth transmission at the
// light's end is found in two ways, which are weighted against each other.
enum { CHAIN_LENGTH = 16 };

typedef struct ChainLink {
    Vec3 w;     // direction away from the layer where the link before it ended: down to the base,
                // or up to the coat
    Rgb weight; // radiance that arrives at its end over the light's
    bool down;
} ChainLink;

typedef struct Chain {
    ChainLink links[CHAIN_LENGTH];
    int count;
    bool smooth; // the first link came through a smooth lobe; then it is the only one
    float pdf;   // of its direction then
} Chain;

static void chain_add(Chain *chain, const Layers *layers, Vec3 w, Rgb *weight)
{
    *weight = rgb_mul(*weight, crossed(layers, w));
    chain->links[chain->count++] = (ChainLink){w, *weight, w.z < 0};
}

// Light from `light` is followed as a viewer's ray would be: the same but for eta².
static void make_chain(const Layers *layers, Vec3 light, WalkRandom *random, Chain *chain)
{
    BsdfSample s;
    chain->count = 0;
    if (!sample_coat(layers, light, LAYER_TRANSMIT, random, &s) || s.wi.z > 0) {
        return;
    }
    Rgb weight = rgb_scale(s.weight, s.eta * s.eta);
    chain->smooth = !(s.lobes & LOBE_DELTA);
    chain->pdf = s.pdf;
    chain_add(chain, layers, s.wi, &weight);
    while (!chain->smooth && chain->count < CHAIN_LENGTH - 1) {
        if (!sample_base(layers, neg(s.wi), random, &s) || !(s.lobes & LOBE_DELTA)) {
            return;
        }
        weight = rgb_mul(weight, s.weight);
        chain_add(chain, layers, s.wi, &weight);
        if (!sample_coat(layers, neg(s.wi), LAYER_REFLECT, random, &s) || !(s.lobes & LOBE_DELTA) ||
            s.wi.z > 0) {
            return;
        }
        weight = rgb_mul(weight, s.weight);
        chain_add(chain, layers, s.wi, &weight);
    }
}

static float power_weight(float p, float q)
{
    float ratio = q / p;
    return p > 0 ? 1 / (1 + ratio * ratio) : 0;
}

// What the chain's links that end at the coat (or at the base) send to a viewer who sees that layer
// at `point`.
static Rgb join(const Chain *chain, const ShadingPoint *point, uint32_t material, bool at_base)
{
    Rgb sum = rgb_gray(0);
    for (int i = 0; i < chain->count; ++i) {
        const ChainLink *link = &chain->links[i];
        if (link->down != at_base) {
            continue;
        }
        BsdfEval e = material_eval(point, material, neg(link->w));
        float weight = (float)(1 / fabs(link->w.z));
        if (chain->smooth) {
            weight *= power_weight(chain->pdf, e.pdf);
        }
        sum = rgb_add(sum, rgb_scale(rgb_mul(e.value, link->weight), weight));
    }
    return sum;
}

// --- From the viewer --------------------------------------------------------------------------

// Roulette begins after this many times at the base.
enum { ROULETTE_START = 3 };

typedef struct Walk {
    const Layers *layers;
    Vec3 light;
    Chain chain;
    WalkRandom random;
    Rgb weight; // radiance that the viewer sees over that at the walk's end
    float squeeze;
    Rgb sum;
} Walk;

static void gather(Walk *walk, Rgb part)
{
    walk->sum = rgb_add(walk->sum, rgb_mul(walk->weight, part));
}

// The coat from below: light that comes in through a smooth lobe, and chains.
static void gather_at_coat(Walk *walk, Vec3 w, const BsdfSample *from_base)
{
    const Layers *layers = walk->layers;
    ShadingPoint below = layers_coat(layers, w, LAYER_COAT);
    Rgb through = material_eval(&below, layers->coat, walk->light).value;
    if (!rgb_is_black(through)) {
        float weight = (float)(1 / walk->light.z);
        if (!(from_base->lobes & LOBE_DELTA)) {
            ShadingPoint above = layers_coat(layers, walk->light, LAYER_TRANSMIT);
            weight *= power_weight(from_base->pdf, material_eval(&above, layers->coat, w).pdf);
        }
        gather(walk, rgb_scale(through, weight));
    }
    gather(walk, join(&walk->chain, &below, layers->coat, false));
}

static bool survives(Walk *walk, int times)
{
    float chance = fminf(rgb_max(walk->weight) * walk->squeeze, 1);
    if (times < ROULETTE_START || chance == 1) {
        return chance > 0;
    }
    if (!(draw(&walk->random) < chance)) {
        return false;
    }
    walk->weight = rgb_scale(walk->weight, 1 / chance);
    return true;
}

// An estimate from one end.
static Rgb walk_from(const Layers *layers, Vec3 viewer, Vec3 light, WalkRandom random)
{
    Walk walk = {.layers = layers, .light = light, .random = random};
    make_chain(layers, light, &walk.random, &walk.chain);
    walk.weight = rgb_gray(1);
    ShadingPoint above = layers_coat(layers, viewer, LAYER_COAT);
    gather(&walk, join(&walk.chain, &above, layers->coat, false));
    BsdfSample s;
    if (!sample_coat(layers, viewer, LAYER_TRANSMIT, &walk.random, &s) || s.wi.z > 0) {
        return walk.sum;
    }
    walk.squeeze = s.eta * s.eta;
    walk.weight = s.weight;
    for (int times = 0; survives(&walk, times); ++times) {
        walk.weight = rgb_mul(walk.weight, crossed(layers, s.wi));
        Vec3 up = neg(s.wi);
        ShadingPoint base = layers_base(layers, up);
        gather(&walk, join(&walk.chain, &base, layers->base, true));
        if (!sample_base(layers, up, &walk.random, &s)) {
            break;
        }
        walk.weight = rgb_mul(rgb_mul(walk.weight, s.weight), crossed(layers, s.wi));
        Vec3 down = neg(s.wi);
        gather_at_coat(&walk, down, &s);
        if (!sample_coat(layers, down, LAYER_REFLECT, &walk.random, &s) || s.wi.z > 0) {
            break;
        }
        walk.weight = rgb_mul(walk.weight, s.weight);
    }
    return walk.sum;
}

// An order of directions, so that both ends draw the same lot.
static bool comes_before(Vec3 a, Vec3 b)
{
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
}

// From one end or the other by chance, which costs half of what the mean of both does and is hardly
// less even.
Rgb layers_walk(const Layers *layers, Vec3 viewer, Vec3 light)
{
    WalkRandom random = walk_random(layers, viewer, light);
    const bool turned = draw(&random) < 0.5f;
    return turned == comes_before(viewer, light) ? walk_from(layers, light, viewer, random)
                                                 : walk_from(layers, viewer, light, random);
}

// --- Delta lobes alone ------------------------------------------------------------------------

// A path goes to and fro at most so often; what is left is the interface's reflection to that
// power.
enum { DELTA_DEPTH = 12 };

typedef struct DeltaPaths {
    const Layers *layers;
    BsdfSample *out;
    int count, room;
} DeltaPaths;

// Paths that leave in one direction are one lobe.
static void leave(DeltaPaths *paths, Vec3 w, Rgb weight)
{
    for (int i = 0; i < paths->count; ++i) {
        if (length_squared(sub(paths->out[i].wi, w)) < 1e-18) {
            paths->out[i].weight = rgb_add(paths->out[i].weight, weight);
            return;
        }
    }
    if (paths->count < paths->room) {
        paths->out[paths->count++] = (BsdfSample){w, weight, 1, 1, LOBE_REFLECT | LOBE_DELTA};
    }
}

// Follows light of the given weight that travels in direction w: down to the base, or up to the
// coat.
static void follow(DeltaPaths *paths, Vec3 w, Rgb weight, int depth)
{
    const Layers *layers = paths->layers;
    weight = rgb_mul(weight, crossed(layers, w));
    if (depth == 0 || rgb_max(weight) < 1e-7f) {
        return;
    }
    bool at_base = w.z < 0;
    ShadingPoint point =
        at_base ? layers_base(layers, neg(w)) : layers_coat(layers, neg(w), LAYER_COAT);
    BsdfSample next[DELTA_ROOM];
    int count = material_deltas(&point, at_base ? layers->base : layers->coat, next, DELTA_ROOM);
    for (int i = 0; i < count; ++i) {
        Rgb part = rgb_mul(weight, next[i].weight);
        if (!at_base && next[i].wi.z > 0) {
            leave(paths, next[i].wi, part);
        } else if (next[i].wi.z * w.z < 0) {
            follow(paths, next[i].wi, part, depth - 1);
        }
    }
}

int layers_deltas(const Layers *layers, Vec3 viewer, BsdfSample *out, int room)
{
    DeltaPaths paths = {layers, out, 0, room};
    ShadingPoint point = layers_coat(layers, viewer, LAYER_COAT);
    BsdfSample first[DELTA_ROOM];
    int count = material_deltas(&point, layers->coat, first, DELTA_ROOM);
    for (int i = 0; i < count; ++i) {
        if (first[i].wi.z > 0) {
            leave(&paths, first[i].wi, first[i].weight);
        } else {
            follow(&paths, first[i].wi, first[i].weight, 2 * DELTA_DEPTH);
        }
    }
    return paths.count;
}
