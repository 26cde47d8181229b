// A weighted sum of two materials.
#include "render/world.h"

typedef struct Mix {
    uint32_t a, b;
    NumberTex weight;
} Mix;

static const Param PARAMS[] = {
    {.name = "a",
     .type = PARAM_NODE,
     PARAM_AT(Mix, a),
     .category = CATEGORY_MATERIAL,
     .flags = PARAM_REQUIRED,
     .doc = "The material of weight 0."},
    {.name = "b",
     .type = PARAM_NODE,
     PARAM_AT(Mix, b),
     .category = CATEGORY_MATERIAL,
     .flags = PARAM_REQUIRED,
     .doc = "The material of weight 1."},
    {.name = "weight",
     .type = PARAM_NUMBER_TEX,
     PARAM_AT(Mix, weight),
     .min = 0,
     .max = 1,
     .default_text = "0.5",
     .doc = "How much there is of `b`."},
};

static float weight_at(const World *world, const Mix *mix, const Surface *surface)
{
    return fraction_tex(world->textures, &mix->weight, surface);
}

static Rgb blend(Rgb a, Rgb b, float weight)
{
    return rgb_add(rgb_scale(a, 1 - weight), rgb_scale(b, weight));
}

static uint32_t lobes(const World *world, const void *params)
{
    const Mix *mix = params;
    return material_lobes(world, mix->a) | material_lobes(world, mix->b);
}

static BsdfEval eval(const ShadingPoint *point, const void *params, Vec3 wi)
{
    const Mix *mix = params;
    float w = weight_at(point->world, mix, point->surface);
    BsdfEval a = {{0, 0, 0}, 0}, b = a;
    if (w < 1) {
        a = material_eval(point, mix->a, wi);
    }
    if (w > 0) {
        b = material_eval(point, mix->b, wi);
    }
    return (BsdfEval){blend(a.value, b.value, w), (1 - w) * a.pdf + w * b.pdf};
}

static bool sample(const ShadingPoint *point, const void *params, float lobe, float u, float v,
                   BsdfSample *out)
{
    const Mix *mix = params;
    float w = weight_at(point->world, mix, point->surface);
    bool second = lobe < w; // the number is used again, spread over [0, 1)
    float chance = second ? w : 1 - w;
    lobe = fminf((second ? lobe : lobe - w) / chance, 0x1.fffffep-1f);
    if (!material_sample(point, second ? mix->b : mix->a, lobe, u, v, out)) {
        return false;
    }
    if (out->lobes & LOBE_DELTA) {
        out->pdf *= chance; // the weight is the lobe's share over that chance: unchanged
        return true;
    }
    // A direction that both may have chosen.
    BsdfEval e = eval(point, params, out->wi);
    if (!(e.pdf > 0)) {
        return false;
    }
    out->pdf = e.pdf;
    out->weight = rgb_scale(e.value, 1 / e.pdf);
    return true;
}

// Those of one of the two, times its share.
static int share_deltas(const ShadingPoint *point, uint32_t id, float share, BsdfSample *out,
                        int room)
{
    int count = share > 0 ? material_deltas(point, id, out, room) : 0;
    for (int i = 0; i < count; ++i) {
        out[i].weight = rgb_scale(out[i].weight, share);
    }
    return count;
}

static int deltas(const ShadingPoint *point, const void *params, BsdfSample *out, int room)
{
    const Mix *mix = params;
    float w = weight_at(point->world, mix, point->surface);
    int a = share_deltas(point, mix->a, 1 - w, out, room);
    int b = a < 0 ? a : share_deltas(point, mix->b, w, out + a, room - a);
    return b < 0 ? b : a + b;
}

static Rgb albedo(const ShadingPoint *point, const void *params)
{
    const Mix *mix = params;
    return blend(material_albedo(point, mix->a), material_albedo(point, mix->b),
                 weight_at(point->world, mix, point->surface));
}

static Rgb emitted(const World *world, const void *params, const Surface *surface)
{
    const Mix *mix = params;
    return blend(material_emitted(world, mix->a, surface), material_emitted(world, mix->b, surface),
                 weight_at(world, mix, surface));
}

static Rgb emitted_mean(const World *world, const void *params)
{
    const Mix *mix = params;
    float w = (float)mix->weight.value;
    if (mix->weight.texture != NONE_ID) {
        w *= luminance(texture_mean(world->textures, mix->weight.texture));
    }
    return blend(material_emitted_mean(world, mix->a), material_emitted_mean(world, mix->b),
                 fminf(fmaxf(w, 0), 1));
}

static Rgb pass(const World *world, const void *params, const Surface *surface)
{
    const Mix *mix = params;
    return blend(material_pass(world, mix->a, surface), material_pass(world, mix->b, surface),
                 weight_at(world, mix, surface));
}

static bool medium(const World *world, const void *params, Medium *out)
{
    const Mix *mix = params;
    return material_medium(world, mix->a, out) || material_medium(world, mix->b, out);
}

static LocalTerms local(const ShadingPoint *point, const void *params, Vec3 l)
{
    const Mix *mix = params;
    float w = weight_at(point->world, mix, point->surface);
    LocalTerms a = material_local(point, mix->a, l), b = material_local(point, mix->b, l);
    return (LocalTerms){blend(a.ambient, b.ambient, w), blend(a.diffuse, b.diffuse, w),
                        blend(a.specular, b.specular, w)};
}

MATERIAL_EVAL(eval)

const MaterialClass mix_material = {
    .node = {.name = "mix",
             .category = CATEGORY_MATERIAL,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(Mix),
             .doc =
                 "A weighted sum of two materials, of any kinds and nested as you like. A weight "
                 "of 0 is all a, 1 is all b; a texture may say how much where.",
             .formula = "f = (1 - weight) f_a + weight f_b   (slides, section 3.5)",
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
                        "    material: mix {\n"
                        "      a: lambert { color: #7f2018 }\n"
                        "      b: ggx { f0: gray(0.9), alpha: 0.1 }\n"
                        "      weight: [0.1, 0.5, 0.9][i]\n"
                        "    }\n"
                        "  }\n"
                        "}"},
    .lobes = lobes,
    .eval = eval_into,
    .sample = sample,
    .deltas = deltas,
    .albedo = albedo,
    .emitted = emitted,
    .emitted_mean = emitted_mean,
    .pass = pass,
    .medium = medium,
    .local = local,
};
