// A coat over a base: lacquer on wood, varnish on paint.
#include "render/materials/layers.h"
#include "render/materials/refracts.h"
#include "render/world.h"

typedef struct Layered {
    uint32_t coat, base;
    NumberTex thickness;
    ColorTex absorption;
} Layered;

enum { COAT, BASE, THICKNESS, ABSORPTION };

static const Param PARAMS[] = {
    [COAT] = {.name = "coat",
              .type = PARAM_NODE,
              PARAM_AT(Layered, coat),
              .category = CATEGORY_MATERIAL,
              .flags = PARAM_REQUIRED,
              .doc = "The upper layer: a `fresnel`, or a `ggx` with `ior` or `f0`, which here lets "
                     "through what it doesn't reflect; alone or within others (`mask`, `mix`, "
                     "`normal_map`, …)."},
    [BASE] = {.name = "base",
              .type = PARAM_NODE,
              PARAM_AT(Layered, base),
              .category = CATEGORY_MATERIAL,
              .flags = PARAM_REQUIRED,
              .doc = "The lower layer: any opaque material, a `layered`, too."},
    [THICKNESS] = {.name = "thickness",
                   .type = PARAM_NUMBER_TEX,
                   PARAM_AT(Layered, thickness),
                   .dims = DIM_BIT(DIM_LENGTH),
                   .min = 0,
                   .max = INFINITY,
                   .default_text = "0",
                   .doc = "Of the coat, along the normal. A texture gives metres."},
    [ABSORPTION] = {.name = "absorption",
                    .type = PARAM_COLOR_TEX,
                    PARAM_AT(Layered, absorption),
                    .min = 0,
                    .max = INFINITY,
                    .default_text = "rgb(0, 0, 0)",
                    .doc = "Of the coat, per metre: what is left after a way d in it is "
                           "exp(-absorption d). A coat of `fresnel` adds its own."},
};

static bool finish(NodeFinish *finish)
{
    const Layered *layered = finish->params;
    if (material_refracts(finish->scene, layered->base)) {
        finish->report(finish, BASE, E0952, "the base of `layered` must be opaque");
        return false;
    }
    if (!material_coats(finish->scene, layered->coat)) {
        finish->report(finish, COAT, W0952,
                       "this coat lets nothing through, so that the base isn't seen");
    }
    return true;
}

static uint32_t lobes(const World *world, const void *params)
{
    const Layered *layered = params;
    uint32_t coat = material_lobes(world, layered->coat),
             base = material_lobes(world, layered->base);
    uint32_t kinds = (coat | base) & (LOBE_SMOOTH | LOBE_EMIT);
    return LOBE_REFLECT | kinds | (coat & LOBE_DELTA);
}

static void layers_of(const ShadingPoint *point, const Layered *layered, Layers *out)
{
    const World *world = point->world;
    Medium medium;
    Rgb absorption = positive_tex(world->textures, &layered->absorption, point->surface);
    const float thickness = number_tex(world->textures, &layered->thickness, point->surface);
    if (material_medium(world, layered->coat, &medium)) {
        absorption = rgb_add(absorption, medium.absorption);
    }
    layers_at(point, layered->coat, layered->base, rgb_scale(absorption, fmaxf(thickness, 0)), out);
}

// --- Choosing directions
// --------------------------------------------------------------------------

// Lobes that are easy to choose from stand for the stack's: its delta lobes, the coat's reflection,
// the base's as if it lay bare, and a cosine. How far they are from the truth costs noise alone.
typedef struct Proxy {
    BsdfSample deltas[DELTA_ROOM];
    int delta_count;
    double delta;  // chance to choose one of the deltas,
    double coat;   // and where not, the coat's reflection; else
    double base;   // the base's reflection; else a cosine
    double albedo; // of all deltas
} Proxy;

// About how much the coat reflects.
static Rgb coat_reflectance(const Layers *layers, Vec3 w)
{
    ShadingPoint point = layers_coat(layers, w, LAYER_REFLECT);
    BsdfSample s;
    bool found = material_sample(&point, layers->coat, 0, 0.5f, 0.5f, &s) && s.wi.z > 0;
    return found ? s.weight : rgb_gray(0);
}

static double clamped(double x, double low, double high)
{
    return lesser(greater(x, low), high);
}

static void make_proxy(const Layers *layers, Vec3 wo, Proxy *out)
{
    const World *world = layers->point.world;
    uint32_t coat = material_lobes(world, layers->coat), base = material_lobes(world, layers->base);
    *out = (Proxy){0};
    if (coat & LOBE_DELTA) {
        out->delta_count = layers_deltas(layers, wo, out->deltas, DELTA_ROOM);
    }
    for (int i = 0; i < out->delta_count; ++i) {
        out->albedo += (double)luminance(out->deltas[i].weight);
    }
    ShadingPoint below = layers_base(layers, wo);
    double top = lesser((double)luminance(coat_reflectance(layers, wo)), 1);
    double bottom = (1 - top) * (double)luminance(material_albedo(&below, layers->base));
    if (!((coat | base) & LOBE_SMOOTH)) {
        out->delta = 1;
        return;
    }
    if (out->albedo > 0) {
        out->delta = clamped(out->albedo / (out->albedo + bottom), 0.05, 0.95);
    }
    if (coat & LOBE_SMOOTH) {
        out->coat = clamped(top + bottom > 0 ? top / (top + bottom) : 1, 0.1, 0.9);
        // Over a mirror all light has the spread of the coat's lobe.
        out->coat = base & LOBE_SMOOTH ? out->coat : greater(out->coat, 0.7);
    }
    out->base = base & LOBE_SMOOTH ? 0.5 : 0;
}

static float proxy_pdf(const Layers *layers, const Proxy *proxy, Vec3 wo, Vec3 wi)
{
    double pdf = 0;
    if (proxy->delta == 1) {
        return 0;
    }
    if (proxy->coat > 0) {
        ShadingPoint point = layers_coat(layers, wo, LAYER_REFLECT);
        pdf += proxy->coat * (double)material_eval(&point, layers->coat, wi).pdf;
    }
    double rest = (1 - proxy->base) * wi.z / PI;
    if (proxy->base > 0) {
        ShadingPoint point = layers_base(layers, wo);
        rest += proxy->base * (double)material_eval(&point, layers->base, wi).pdf;
    }
    return (float)((1 - proxy->delta) * (pdf + (1 - proxy->coat) * rest));
}

// Takes the number's part below `chance` (true) or the rest, and spreads it over [0, 1) again.
static bool below(double *number, double chance)
{
    bool taken = *number < chance;
    *number = taken ? *number / chance : (*number - chance) / (1 - chance);
    return taken;
}

static bool proxy_sample(const Layers *layers, const Proxy *proxy, Vec3 wo, double lobe, float u,
                         float v, Vec3 *wi)
{
    BsdfSample s;
    ShadingPoint point;
    uint32_t material;
    if (below(&lobe, proxy->coat)) {
        point = layers_coat(layers, wo, LAYER_REFLECT);
        material = layers->coat;
    } else if (below(&lobe, proxy->base)) {
        point = layers_base(layers, wo);
        material = layers->base;
    } else {
        *wi = sample_cosine_hemisphere(u, v);
        return wi->z > 0;
    }
    float number = fminf((float)lobe, 0x1.fffffep-1f);
    if (!material_sample(&point, material, number, u, v, &s) || s.lobes & LOBE_DELTA) {
        return false;
    }
    *wi = s.wi;
    return s.wi.z > 0;
}

// --- The class
// ------------------------------------------------------------------------------------

static Rgb smooth_value(const Layers *layers, Vec3 wo, Vec3 wi)
{
    ShadingPoint point = layers_coat(layers, wo, LAYER_COAT);
    Rgb top = material_eval(&point, layers->coat, wi).value;
    return rgb_add(top, rgb_scale(layers_walk(layers, wo, wi), (float)wi.z));
}

static BsdfEval eval(const ShadingPoint *point, const void *params, Vec3 wi)
{
    Layers layers;
    Proxy proxy;
    layers_of(point, params, &layers);
    Vec3 wo = layers_turn(point, point->wo);
    wi = layers_turn(point, wi);
    if (!(wo.z > 0 && wi.z > 0)) {
        return (BsdfEval){{0, 0, 0}, 0};
    }
    make_proxy(&layers, wo, &proxy);
    if (proxy.delta == 1) {
        return (BsdfEval){{0, 0, 0}, 0};
    }
    return (BsdfEval){smooth_value(&layers, wo, wi), proxy_pdf(&layers, &proxy, wo, wi)};
}

static bool sample_delta(const ShadingPoint *point, const Proxy *proxy, double lobe,
                         BsdfSample *out)
{
    double rest = proxy->albedo; // of those not yet passed over
    for (int i = 0; i < proxy->delta_count; ++i) {
        double part = (double)luminance(proxy->deltas[i].weight), share = part / proxy->albedo;
        bool last = i == proxy->delta_count - 1;
        if (last || below(&lobe, part / rest)) {
            *out = proxy->deltas[i];
            out->wi = layers_turn(point, out->wi);
            out->pdf = (float)(proxy->delta * share);
            out->weight = rgb_scale(out->weight, 1 / out->pdf);
            return out->pdf > 0;
        }
        rest -= part;
    }
    return false;
}

static bool sample(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                   BsdfSample *out)
{
    Layers layers;
    Proxy proxy;
    layers_of(point, params, &layers);
    Vec3 wo = layers_turn(point, point->wo), wi;
    if (!(wo.z > 0)) {
        return false;
    }
    make_proxy(&layers, wo, &proxy);
    double number = (double)lobe;
    if (below(&number, proxy.delta)) {
        return sample_delta(point, &proxy, number, out);
    }
    if (!proxy_sample(&layers, &proxy, wo, number, u, v, &wi)) {
        return false;
    }
    float pdf = proxy_pdf(&layers, &proxy, wo, wi);
    if (!(pdf > 0) || !isfinite(pdf)) {
        return false;
    }
    Rgb value = smooth_value(&layers, wo, wi);
    *out = (BsdfSample){layers_turn(point, wi), rgb_scale(value, 1 / pdf), pdf, 1,
                        LOBE_REFLECT | LOBE_SMOOTH};
    return true;
}

static int deltas(const ShadingPoint *point, const void *params, BsdfSample *out, int room)
{
    Layers layers;
    layers_of(point, params, &layers);
    Vec3 wo = layers_turn(point, point->wo);
    int count = wo.z > 0 ? layers_deltas(&layers, wo, out, room) : 0;
    for (int i = 0; i < count; ++i) {
        out[i].wi = layers_turn(point, out[i].wi);
    }
    return count;
}

static Rgb complement(Rgb c)
{
    return rgb(fmaxf(1 - c.r, 0), fmaxf(1 - c.g, 0), fmaxf(1 - c.b, 0));
}

static Rgb albedo(const ShadingPoint *point, const void *params)
{
    Layers layers;
    layers_of(point, params, &layers);
    Vec3 wo = layers_turn(point, point->wo);
    ShadingPoint base = layers_base(&layers, wo);
    Rgb top = coat_reflectance(&layers, wo);
    Rgb bottom = rgb_mul(complement(top), material_albedo(&base, layers.base));
    return rgb_add(top, bottom);
}

static Rgb emitted(const World *world, const void *params, const Surface *surface)
{
    const Layered *layered = params;
    return rgb_add(material_emitted(world, layered->coat, surface),
                   material_emitted(world, layered->base, surface));
}

static Rgb emitted_mean(const World *world, const void *params)
{
    const Layered *layered = params;
    return rgb_add(material_emitted_mean(world, layered->coat),
                   material_emitted_mean(world, layered->base));
}

// The terms of the coat, and those of the base dimmed by what the coat reflects on the way in and
// out: no noise, no light that goes to and fro.
static LocalTerms local(const ShadingPoint *point, const void *params, Vec3 l)
{
    Layers layers;
    layers_of(point, params, &layers);
    Vec3 wo = layers_turn(point, point->wo);
    l = layers_turn(point, l);
    ShadingPoint above = layers_coat(&layers, wo, LAYER_COAT), below = layers_base(&layers, wo);
    LocalTerms terms = material_local(&below, layers.base, l);
    Rgb out = complement(coat_reflectance(&layers, wo));
    if (l.z > 0) {
        Rgb both = rgb_mul(out, complement(coat_reflectance(&layers, l)));
        LocalTerms coat = material_local(&above, layers.coat, l);
        terms.diffuse = rgb_add(rgb_mul(terms.diffuse, both), coat.diffuse);
        terms.specular = rgb_add(rgb_mul(terms.specular, both), coat.specular);
    }
    terms.ambient = rgb_mul(terms.ambient, out);
    return terms;
}

MATERIAL_EVAL(eval)

const MaterialClass layered_material = {
    .node = {.name = "layered",
             .category = CATEGORY_MATERIAL,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(Layered),
             .doc =
                 "A coat over a base: light crosses the coat, is reflected below, and crosses it "
                 "back, reflected down again as often as it happens. Energy is conserved, light "
                 "and viewer can change places; the same from both sides. Each value is "
                 "estimated by a short random walk, so it costs more noise than other materials; "
                 "what the base emits shines through undimmed. Base colors look more saturated "
                 "under a coat, as they do in nature.",
             .formula =
                 "f = f_coat + E[walks between the layers]   (Guo, Hašan and Zhao 2018; slides, "
                 "section 3.5),\n"
                 "exp(-absorption thickness/|cos θ|) for each crossing",
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: "
                        "(0, 0, 1.5) }, radiance: 12 }\n"
                        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], "
                        "space: \"uv\" } }\n"
                        "plane {\n"
                        "  material: lambert { color: checker { a: gray(0.6), b: gray(0.35), "
                        "space: \"world\", scale: 2 } }\n"
                        "}\n"
                        "for (i in 0..2) {\n"
                        "  sphere {\n"
                        "    center: (1.05 * (i - 1), 0.5, 0), radius: 0.5\n"
                        "    material: layered {\n"
                        "      coat: ggx { ior: 1.5, alpha: [0.001, 0.02, 0.3][i] }\n"
                        "      base: burley { color: #a02818, roughness: 0.7 }\n"
                        "      thickness: 0.1mm, absorption: rgb(200, 800, 2000)\n"
                        "    }\n"
                        "  }\n"
                        "}",
             .finish = finish},
    .lobes = lobes,
    .eval = eval_into,
    .sample = sample,
    .deltas = deltas,
    .albedo = albedo,
    .emitted = emitted,
    .emitted_mean = emitted_mean,
    .local = local,
};
