// Materials as POV-Ray's textures, finishes and interiors.
#include "export/pov.h"

#include "schema/photometry.h"

// A material as the sum that a single finish can say. Colors are of the slides' raw expressions:
// what a light of S = 1 gives (in `direct` and `path` the 1/π is in the lights).
typedef struct Surface {
    uint32_t texture;     // that diffuse and ambient are multiplied by, or NONE_ID
    Rgb diffuse, ambient; // ambient: times the sum of the lights
    Rgb phong, blinn;     // highlights: color, and exponent
    double phong_exponent, blinn_exponent;
    Rgb reflection, emission;
    const SceneNode *glass; // the whole is glass: nothing else counts
} Surface;

static const SceneNode *material_node(const Pov *pov, uint32_t material)
{
    return scene_node(pov->e->scene, CATEGORY_MATERIAL, material);
}

static double constant(const Pov *pov, const SceneNode *node, const char *field)
{
    NumberTex number = export_number_tex(pov->e, node, field);
    if (number.texture == NONE_ID) {
        return number.value;
    }
    export_note(pov->e, node->at, "a texture for `%s`: its middle value is written", field);
    return number.value * (double)luminance(pov_texture_mean(pov, number.texture));
}

static Rgb constant_color(const Pov *pov, const SceneNode *node, const char *field)
{
    ColorTex color = export_color_tex(pov->e, node, field);
    if (color.texture == NONE_ID) {
        return color.value;
    }
    export_note(pov->e, node->at, "a texture for `%s`: its middle color is written", field);
    return rgb_mul(color.value, pov_texture_mean(pov, color.texture));
}

// --- The kinds -----------------------------------------------------------------------------------

static void read_lambert(const Pov *pov, const SceneNode *node, Surface *out)
{
    ColorTex color = export_color_tex(pov->e, node, "color");
    out->texture = color.texture;
    out->diffuse = color.value;
}

static void read_phong(const Pov *pov, const SceneNode *node, bool half_vector, Surface *out)
{
    ColorTex color = export_color_tex(pov->e, node, "color");
    double e = constant(pov, node, "shininess"), k = constant(pov, node, "specular");
    double ambient = constant(pov, node, "ambient");
    Rgb tint = constant_color(pov, node, "specular_color");
    out->texture = color.texture;
    out->diffuse = rgb_scale(color.value, (float)constant(pov, node, "diffuse"));
    if (pov->local && ambient > 0) {
        out->ambient = rgb_scale(color.value, (float)ambient);
        if (pov->ambient_partial) {
            export_note(pov->e, node->at,
                        "the ambient light of lights that fall off has no partner: only that of "
                        "the others is written");
        }
    }
    if (!pov->local && k > 0) {
        // (e+2)/(2π) and (e+2)(e+4)/(8π(2^(-e/2)+e)), with the 1/π in the lights.
        k *= half_vector ? (e + 2) * (e + 4) / (8 * (exp2(-e / 2) + e)) : (e + 2) / 2;
        export_note(pov->e, node->at,
                    "POV-Ray's highlight has no factor n·l: with light from the side it is "
                    "brighter (the same only in the integrator \"local\")");
    }
    if (half_vector) {
        out->blinn = rgb_scale(tint, (float)k);
        out->blinn_exponent = e;
    } else {
        out->phong = rgb_scale(tint, (float)k);
        out->phong_exponent = e;
    }
}

static void read_ggx(const Pov *pov, const SceneNode *node, Surface *out)
{
    PairTex alpha = export_pair_tex(pov->e, node, "alpha");
    Rgb f0 = constant_color(pov, node, "f0");
    Rgb eta = constant_color(pov, node, "eta"), k = constant_color(pov, node, "k");
    double ior = constant(pov, node, "ior");
    if (eta.r > 0 || k.r > 0) {
        const float n[3] = {eta.r, eta.g, eta.b}, x[3] = {k.r, k.g, k.b};
        float f[3];
        for (int i = 0; i < 3; ++i) {
            f[i] =
                ((n[i] - 1) * (n[i] - 1) + x[i] * x[i]) / ((n[i] + 1) * (n[i] + 1) + x[i] * x[i]);
        }
        f0 = rgb(f[0], f[1], f[2]);
    } else if (ior > 0) {
        f0 = rgb_gray((float)((ior - 1) * (ior - 1) / ((ior + 1) * (ior + 1))));
    }
    double a2 = fmax(alpha.value.x * alpha.value.y, 1e-6);
    if (alpha.texture != NONE_ID) {
        a2 = 0.04;
    }
    // Walter et al. 2007: GGX of alpha is near Blinn's lobe of exponent 2/alpha² - 2; at normal
    // incidence its BRDF is f0 (e+2)/(8π).
    double e = fmax(2 / a2 - 2, 0.01);
    out->blinn = rgb_scale(f0, (float)((e + 2) / 8));
    out->blinn_exponent = e;
    export_note(pov->e, node->at,
                "`ggx` has no partner: a half-vector highlight of exponent %.4g is written, which "
                "shows lights but not the surroundings",
                e);
}

static void read_mirror(const Pov *pov, const SceneNode *node, Surface *out)
{
    Rgb eta = constant_color(pov, node, "eta"), k = constant_color(pov, node, "k");
    if (pov->local) {
        return; // black there
    }
    if (eta.r > 0 || k.r > 0) {
        const float n[3] = {eta.r, eta.g, eta.b}, x[3] = {k.r, k.g, k.b};
        float f[3];
        for (int i = 0; i < 3; ++i) {
            f[i] =
                ((n[i] - 1) * (n[i] - 1) + x[i] * x[i]) / ((n[i] + 1) * (n[i] + 1) + x[i] * x[i]);
        }
        out->reflection = rgb(f[0], f[1], f[2]);
        export_note(pov->e, node->at,
                    "a metal's reflectance at normal incidence is written for all angles");
        return;
    }
    out->reflection = constant_color(pov, node, "color");
}

static void read_glass(const Pov *pov, const SceneNode *node, Surface *out)
{
    if (pov->local) {
        return; // black there, when smooth
    }
    PairTex alpha = export_pair_tex(pov->e, node, "alpha");
    if (alpha.texture != NONE_ID || alpha.value.x > 1e-4 || alpha.value.y > 1e-4) {
        export_note(pov->e, node->at, "frosted glass has no partner: clear glass is written");
    }
    if (export_choice(pov->e, node, "approximation")[0] == 's') {
        export_note(pov->e, node->at,
                    "Schlick's approximation has no partner: Fresnel's exact formula is written");
    }
    if (export_int(pov->e, node, "priority") != 0) {
        export_note(pov->e, node->at,
                    "`priority` has no partner: where bodies overlap the picture differs");
    }
    if (!rgb_is_black(export_rgb(pov->e, node, "absorption"))) {
        export_note(pov->e, node->at,
                    "POV-Ray absorbs nothing of light that is reflected inside: only the light "
                    "that goes straight through is dimmed the same");
    }
    out->glass = node;
}

static Surface read_material(const Pov *pov, uint32_t material, int depth);

static Rgb blend(Rgb a, Rgb b, float w)
{
    return rgb_add(rgb_scale(a, 1 - w), rgb_scale(b, w));
}

static bool merge_lobe(Rgb *color, double *exponent, Rgb other, double other_exponent, float w)
{
    bool clash = !rgb_is_black(*color) && !rgb_is_black(other) && *exponent != other_exponent;
    if (rgb_is_black(*color) || (clash && luminance(other) * w > luminance(*color) * (1 - w))) {
        *exponent = other_exponent;
    }
    *color = blend(*color, other, w);
    return !clash;
}

static void read_mix(const Pov *pov, const SceneNode *node, int depth, Surface *out)
{
    Surface a = read_material(pov, export_id(pov->e, node, "a"), depth + 1);
    Surface b = read_material(pov, export_id(pov->e, node, "b"), depth + 1);
    float w = (float)constant(pov, node, "weight");
    if (a.glass || b.glass) {
        export_note(pov->e, node->at, "glass in a `mix`: the heavier part alone is written");
        *out = w > 0.5f ? b : a;
        return;
    }
    // A texture stands for one of them; where both differ, its middle color does.
    Surface *parts[2] = {&a, &b};
    bool differ = a.texture != b.texture;
    for (int i = 0; differ && i < 2; ++i) {
        Surface *part = parts[i];
        bool other_black =
            rgb_is_black(parts[1 - i]->diffuse) && rgb_is_black(parts[1 - i]->ambient);
        if (part->texture == NONE_ID || other_black) {
            continue;
        }
        export_note(pov->e, node->at, "a texture in a `mix`: its middle color is written");
        Rgb mean = pov_texture_mean(pov, part->texture);
        part->diffuse = rgb_mul(part->diffuse, mean);
        part->ambient = rgb_mul(part->ambient, mean);
        part->texture = NONE_ID;
    }
    *out = a;
    out->texture = a.texture != NONE_ID ? a.texture : b.texture;
    out->diffuse = blend(a.diffuse, b.diffuse, w);
    out->ambient = blend(a.ambient, b.ambient, w);
    out->reflection = blend(a.reflection, b.reflection, w);
    out->emission = blend(a.emission, b.emission, w);
    bool fits = merge_lobe(&out->phong, &out->phong_exponent, b.phong, b.phong_exponent, w);
    fits = merge_lobe(&out->blinn, &out->blinn_exponent, b.blinn, b.blinn_exponent, w) && fits;
    if (!fits) {
        export_note(pov->e, node->at,
                    "two highlights of one kind in a `mix`: they get the stronger one's exponent");
    }
}

static Rgb emission_of(const Pov *pov, uint32_t material)
{
    const SceneNode *node = material_node(pov, material);
    Emission radiance = export_emission(pov->e, node, "radiance");
    Rgb rgb_value = rgb_gray(0);
    emission_to_rgb(&radiance, rgb_gray(1), &rgb_value);
    if (radiance.texture != NONE_ID) {
        rgb_value = rgb_mul(rgb_value, pov_texture_mean(pov, radiance.texture));
    }
    return rgb_value;
}

static void read_emissive(const Pov *pov, const SceneNode *node, uint32_t material, int depth,
                          Surface *out)
{
    uint32_t base = export_id(pov->e, node, "base");
    if (base != NONE_ID) {
        *out = read_material(pov, base, depth + 1);
    }
    if (pov->local) {
        return; // emission isn't seen there
    }
    if (export_emission(pov->e, node, "radiance").texture != NONE_ID) {
        export_note(pov->e, node->at, "a texture for `radiance`: its middle color is written");
    }
    export_note(pov->e, node->at, "what emits is bright from both sides in POV-Ray");
    out->emission = rgb_add(out->emission, emission_of(pov, material));
}

enum { MOST_NESTED = 64 };

static Surface read_material(const Pov *pov, uint32_t material, int depth)
{
    Surface out = {.texture = NONE_ID};
    if (material == NONE_ID || depth > MOST_NESTED) {
        out.diffuse = rgb_gray(0.5f);
        return out;
    }
    const SceneNode *node = material_node(pov, material);
    if (export_is(pov->e, node, "lambert")) {
        read_lambert(pov, node, &out);
    } else if (export_is(pov->e, node, "phong")) {
        read_phong(pov, node, false, &out);
    } else if (export_is(pov->e, node, "blinn_phong")) {
        read_phong(pov, node, true, &out);
    } else if (export_is(pov->e, node, "burley")) {
        read_lambert(pov, node, &out);
        export_note(pov->e, node->at, "`burley` has no partner: Lambert's law is written");
    } else if (export_is(pov->e, node, "mirror")) {
        read_mirror(pov, node, &out);
    } else if (export_is(pov->e, node, "ggx")) {
        read_ggx(pov, node, &out);
    } else if (export_is(pov->e, node, "fresnel")) {
        read_glass(pov, node, &out);
    } else if (export_is(pov->e, node, "mix")) {
        read_mix(pov, node, depth, &out);
    } else if (export_is(pov->e, node, "emissive")) {
        read_emissive(pov, node, material, depth, &out);
    } else {
        export_note(pov->e, node->at, "`%s` has no partner: gray 0.5 by Lambert's law is written",
                    export_kind(pov->e, node));
        out.diffuse = rgb_gray(0.5f);
    }
    return out;
}

// --- Writing -------------------------------------------------------------------------------------

static float over(float a, float b)
{
    return b > 0 ? a / b : 0;
}

// `emission` is multiplied by the pigment: this keeps the pigment from being 0 where it must shine.
static Rgb visible_pigment(Rgb diffuse, Rgb shine)
{
    float least = 1e-6f * rgb_max(shine);
    return rgb(shine.r > 0 ? fmaxf(diffuse.r, least) : diffuse.r,
               shine.g > 0 ? fmaxf(diffuse.g, least) : diffuse.g,
               shine.b > 0 ? fmaxf(diffuse.b, least) : diffuse.b);
}

static bool is_gray(Rgb c)
{
    return c.r == c.g && c.g == c.b;
}

// A colored highlight takes its color from the pigment of its layer, by `metallic`.
static void write_highlight(const Pov *pov, const char *amount_name, const char *size_name,
                            double amount, double size)
{
    fprintf(pov->e->out, " %s ", amount_name);
    pov_number(pov, amount);
    fprintf(pov->e->out, " %s ", size_name);
    pov_number(pov, size);
}

static double blinn_roughness(double e)
{
    return 1 / fmax(e, 1e-9);
}

static void write_colored(const Pov *pov, Rgb color, bool blinn, double e, const char *indent)
{
    float amount = rgb_max(color);
    fprintf(pov->e->out, "%stexture { pigment { rgbt <", indent);
    pov_number(pov, (double)(color.r / amount));
    fputs(", ", pov->e->out);
    pov_number(pov, (double)(color.g / amount));
    fputs(", ", pov->e->out);
    pov_number(pov, (double)(color.b / amount));
    fputs(", 1> } finish { ambient 0 diffuse 0 metallic", pov->e->out);
    if (blinn) {
        write_highlight(pov, "specular", "roughness", (double)amount, blinn_roughness(e));
    } else {
        write_highlight(pov, "phong", "phong_size", (double)amount, e);
    }
    fputs(" } }\n", pov->e->out);
}

static void write_finish(const Pov *pov, const Surface *s, Rgb shine, bool lit)
{
    FILE *out = pov->e->out;
    fprintf(out, "finish { ambient 0 diffuse %d", lit ? 1 : 0);
    if (!rgb_is_black(s->phong) && is_gray(s->phong)) {
        write_highlight(pov, "phong", "phong_size", (double)s->phong.r, s->phong_exponent);
    }
    if (!rgb_is_black(s->blinn) && is_gray(s->blinn)) {
        write_highlight(pov, "specular", "roughness", (double)s->blinn.r,
                        blinn_roughness(s->blinn_exponent));
    }
    if (!rgb_is_black(s->reflection)) {
        fputs(" reflection { ", out);
        pov_rgb(pov, s->reflection);
        fputs(" }", out);
    }
    if (!rgb_is_black(shine)) {
        fputs(" emission ", out);
        pov_rgb(pov, shine);
    }
    fputs(" }\n", out);
}

static void write_surface(const Pov *pov, const Surface *s, const PovUv *uv, Span at,
                          const char *indent)
{
    FILE *out = pov->e->out;
    char deeper[32];
    snprintf(deeper, sizeof deeper, "%s  ", indent);
    Rgb shine = rgb_add(s->emission, rgb_mul(s->ambient, pov->ambient_light));
    bool lit = !rgb_is_black(s->diffuse);
    Rgb pigment = lit ? visible_pigment(s->diffuse, shine) : rgb_gray(1);
    if (lit) {
        shine = rgb(over(shine.r, pigment.r), over(shine.g, pigment.g), over(shine.b, pigment.b));
    }
    if (s->texture != NONE_ID && !rgb_is_black(s->emission)) {
        export_note(pov->e, at, "what is emitted is multiplied by the texture, too");
    }
    if (!lit && rgb_is_black(shine)) {
        pigment = rgb_gray(0);
    }
    fprintf(out, "%stexture {\n", indent);
    pov_pigment(pov, lit || !rgb_is_black(s->ambient) ? s->texture : NONE_ID, pigment, uv, at,
                deeper);
    fputs(deeper, out);
    write_finish(pov, s, shine, lit);
    fprintf(out, "%s}\n", indent);
    bool colored = false;
    if (!rgb_is_black(s->phong) && !is_gray(s->phong)) {
        write_colored(pov, s->phong, false, s->phong_exponent, indent);
        colored = true;
    }
    if (!rgb_is_black(s->blinn) && !is_gray(s->blinn)) {
        write_colored(pov, s->blinn, true, s->blinn_exponent, indent);
        colored = true;
    }
    if (colored) {
        export_note(pov->e, at, "a colored highlight turns white with light from the side");
    }
}

static void write_glass(const Pov *pov, const SceneNode *node, const char *indent)
{
    FILE *out = pov->e->out;
    Rgb color = constant_color(pov, node, "color"), a = export_rgb(pov->e, node, "absorption");
    double inside = export_number(pov->e, node, "ior");
    double outside = export_number(pov->e, node, "outside");
    fprintf(out, "%stexture {\n%s  pigment { rgbf <", indent, indent);
    pov_number(pov, (double)color.r);
    fputs(", ", out);
    pov_number(pov, (double)color.g);
    fputs(", ", out);
    pov_number(pov, (double)color.b);
    fprintf(out,
            ", 1> }\n%s  finish { ambient 0 diffuse 0 reflection { 0, 1 fresnel on } "
            "conserve_energy }\n%s}\n%sinterior { ior ",
            indent, indent, indent);
    pov_number(pov, inside / outside);
    if (!rgb_is_black(a)) { // exp(-(1 - fade_color) d / fade_distance)
        float most = rgb_max(a);
        fputs(" fade_power 1001 fade_distance ", out);
        pov_number(pov, 1 / (double)most);
        fputs(" fade_color ", out);
        pov_rgb(pov, rgb(1 - a.r / most, 1 - a.g / most, 1 - a.b / most));
    }
    fputs(" }\n", out);
}

static void write_material(const Pov *pov, uint32_t material, const PovUv *uv, const char *indent)
{
    Surface s = read_material(pov, material, 0);
    Span at = material == NONE_ID ? (Span){0, 0, 0} : material_node(pov, material)->at;
    if (s.glass) {
        write_glass(pov, s.glass, indent);
    } else {
        write_surface(pov, &s, uv, at, indent);
    }
}

// --- For the others ------------------------------------------------------------------------------

bool pov_is_glass(const Pov *pov, uint32_t material)
{
    return material != NONE_ID && !pov->local &&
           export_is(pov->e, material_node(pov, material), "fresnel");
}

Rgb pov_emitted(const Pov *pov, uint32_t material)
{
    if (material == NONE_ID || !export_is(pov->e, material_node(pov, material), "emissive")) {
        return rgb_gray(0);
    }
    return emission_of(pov, material);
}

unsigned pov_material_uses(const Pov *pov, uint32_t material)
{
    return pov_texture_uses(pov, read_material(pov, material, 0).texture);
}

void pov_declare_materials(const Pov *pov)
{
    FILE *out = pov->e->out;
    const SceneNodeArray *nodes = &pov->e->scene->nodes[CATEGORY_MATERIAL];
    const PovUv uv = {POV_UV_OWN, affine_identity()};
    fputs(
        "// --- Materials\n\n#default { texture { pigment { rgb 0.5 } finish { ambient 0 diffuse 1 "
        "} } }\n\n",
        out);
    for (uint32_t id = 0; id < nodes->count; ++id) {
        pov_comment(pov, export_kind(pov->e, &nodes->items[id]), nodes->items[id].name,
                    nodes->items[id].at, "");
        fprintf(out, "#declare Material_%u = material {\n", (unsigned)id);
        write_material(pov, id, &uv, "  ");
        fputs("}\n\n", out);
    }
}

void pov_use_material(const Pov *pov, uint32_t material, const PovUv *uv, const char *indent)
{
    char deeper[32];
    snprintf(deeper, sizeof deeper, "%s  ", indent);
    if (material == NONE_ID) {
        return; // the default, or the instance's
    }
    if (uv->kind == POV_UV_OWN || !(pov_material_uses(pov, material) & POV_USES_UV)) {
        fprintf(pov->e->out, "%smaterial { Material_%u }\n", indent, (unsigned)material);
        return;
    }
    fprintf(pov->e->out, "%smaterial {\n", indent);
    write_material(pov, material, uv, deeper);
    fprintf(pov->e->out, "%s}\n", indent);
}
