// Materials and textures as functions that build Cycles' nodes.
#include "export/blender.h"

#include "schema/photometry.h"

#include <string.h>

static const SceneNode *material_node(const Blender *b, uint32_t material)
{
    return scene_node(b->e->scene, CATEGORY_MATERIAL, material);
}

static const SceneNode *texture_node(const Blender *b, uint32_t texture)
{
    return scene_node(b->e->scene, CATEGORY_TEXTURE, texture);
}

static void note(const Blender *b, const SceneNode *node, const char *text)
{
    export_note(b->e, node->at, "%s", text);
}

// --- Values --------------------------------------------------------------------------------------

void blender_color_tex(const Blender *b, ColorTex color)
{
    bool plain = color.value.r == 1 && color.value.g == 1 && color.value.b == 1;
    if (color.texture == NONE_ID) {
        blender_rgb(b, color.value);
    } else if (plain) {
        blender_print(b, "texture_%u(n)", (unsigned)color.texture);
    } else {
        blender_print(b, "n.arithmetic(\"multiply\", texture_%u(n), ", (unsigned)color.texture);
        blender_rgb(b, color.value);
        blender_print(b, ")");
    }
}

static void color_field(const Blender *b, const SceneNode *node, const char *field)
{
    blender_color_tex(b, export_color_tex(b->e, node, field));
}

static void number_tex(const Blender *b, NumberTex number)
{
    if (number.texture == NONE_ID) {
        blender_number(b, number.value);
    } else if (number.value == 1) {
        blender_print(b, "n.gray(texture_%u(n))", (unsigned)number.texture);
    } else {
        blender_print(b, "n.math(\"MULTIPLY\", n.gray(texture_%u(n)), ", (unsigned)number.texture);
        blender_number(b, number.value);
        blender_print(b, ")");
    }
}

static void number_field(const Blender *b, const SceneNode *node, const char *field)
{
    number_tex(b, export_number_tex(b->e, node, field));
}

// A number for a pair of equals, else the pair.
static void alpha_field(const Blender *b, const SceneNode *node)
{
    PairTex alpha = export_pair_tex(b->e, node, "alpha");
    if (alpha.texture != NONE_ID || alpha.value.x == alpha.value.y) {
        number_tex(b, (NumberTex){alpha.value.x, alpha.texture});
        return;
    }
    blender_print(b, "(");
    blender_number(b, fmax(alpha.value.x, 1e-4));
    blender_print(b, ", ");
    blender_number(b, fmax(alpha.value.y, 1e-4));
    blender_print(b, ")");
}

static bool is_pair(PairTex alpha)
{
    return alpha.texture == NONE_ID && alpha.value.x != alpha.value.y;
}

// --- Textures ------------------------------------------------------------------------------------

static void write_checker(const Blender *b, const SceneNode *node)
{
    Vec2 scale = export_vec2(b->e, node, "scale");
    const char *space = export_choice(b->e, node, "space");
    bool uv = strcmp(space, "uv") == 0;
    blender_print(b, "n.checker(");
    color_field(b, node, "a");
    blender_print(b, ", ");
    color_field(b, node, "b");
    blender_print(b, ", ");
    blender_vec3(b, uv ? vec3(scale.x, scale.y, 1) : vec3(scale.x, scale.x, scale.x));
    blender_print(b, ", \"%s\")", space);
}

static void write_pair(const Blender *b, Vec2 pair)
{
    blender_print(b, "(");
    blender_number(b, pair.x);
    blender_print(b, ", ");
    blender_number(b, pair.y);
    blender_print(b, ")");
}

// "True", "False", or "None" where the file's own type decides.
static const char *is_linear(const Blender *b, const SceneNode *node)
{
    const char *encoding = export_choice(b->e, node, "encoding");
    return strcmp(encoding, "linear") == 0 ? "True"
           : strcmp(encoding, "srgb") == 0 ? "False"
                                           : "None";
}

static void write_image(const Blender *b, const SceneNode *node)
{
    const char *wrap = export_choice(b->e, node, "wrap");
    const char *extension = strcmp(wrap, "clamp") == 0   ? "EXTEND"
                            : strcmp(wrap, "black") == 0 ? "CLIP"
                                                         : "REPEAT";
    bool nearest = strcmp(export_choice(b->e, node, "filter"), "nearest") == 0;
    if (strcmp(wrap, "mirror") == 0) {
        note(b, node, "`wrap: \"mirror\"`: the picture is repeated");
    }
    if (!nearest) {
        note(b, node,
             "a picture: Cycles interpolates bytes before it decodes them, so that steep edges "
             "between texels differ a little");
    }
    blender_print(b, "n.image(");
    blender_string(b, export_file(b->e, node, "file"));
    blender_print(b, ", %s, %s, \"%s\", ", is_linear(b, node), nearest ? "True" : "False",
                  extension);
    write_pair(b, export_vec2(b->e, node, "scale"));
    blender_print(b, ", ");
    write_pair(b, export_vec2(b->e, node, "offset"));
    blender_print(b, ")");
}

static void write_numbers(const Blender *b, NumberList list)
{
    for (uint32_t i = 0; i < list.count; ++i) {
        blender_print(b, i ? ", " : "[");
        blender_number(b, list.items[i]);
    }
    blender_print(b, list.count ? "]" : "[]");
}

static void write_gradient(const Blender *b, const SceneNode *node)
{
    Export *e = b->e;
    NumberTex value = export_number_tex(e, node, "value");
    RgbList colors = export_rgbs(e, node, "colors");
    Vec3 from = export_vec3(e, node, "from"), to = export_vec3(e, node, "to");
    bool has_value = value.texture != NONE_ID || value.value != 0;
    blender_print(b, "n.gradient([");
    for (uint32_t i = 0; i < colors.count; ++i) {
        blender_print(b, i ? ", " : "");
        blender_rgb(b, colors.items[i]);
    }
    blender_print(b, "], ");
    write_numbers(b, export_numbers(e, node, "positions"));
    blender_print(b, ", \"%s\", ", export_choice(e, node, "wrap"));
    if (has_value) {
        number_tex(b, value);
    } else {
        blender_print(b, "n.along(\"%s\", \"%s\", ", export_choice(e, node, "space"),
                      export_choice(e, node, "form"));
        blender_vec3(b, from);
        blender_print(b, ", ");
        blender_vec3(b, sub(to, from));
        blender_print(b, ")");
    }
    blender_print(b, ")");
}

static void write_noise(const Blender *b, const SceneNode *node)
{
    note(b, node, "`noise` has no partner: Cycles' own noise is written, of about the same size");
    blender_print(b, "n.noise(");
    color_field(b, node, "a");
    blender_print(b, ", ");
    color_field(b, node, "b");
    blender_print(b, ", \"%s\", ", export_choice(b->e, node, "space"));
    blender_number(b, export_number(b->e, node, "scale"));
    blender_print(b, ", %d)", (int)export_int(b->e, node, "octaves"));
}

static void write_texture(const Blender *b, const SceneNode *node)
{
    if (export_is(b->e, node, "gradient")) {
        write_gradient(b, node);
    } else if (export_is(b->e, node, "noise")) {
        write_noise(b, node);
    } else if (export_is(b->e, node, "checker")) {
        write_checker(b, node);
    } else if (export_is(b->e, node, "image")) {
        write_image(b, node);
    } else if (export_is(b->e, node, "vertex_color")) {
        blender_print(b, "n.vertex_color()");
    } else if (export_is(b->e, node, "texture_math")) {
        blender_print(b, "n.arithmetic(\"%s\", ", export_choice(b->e, node, "op"));
        color_field(b, node, "a");
        blender_print(b, ", ");
        color_field(b, node, "b");
        blender_print(b, ")");
    } else {
        export_note(b->e, node->at, "the texture `%s` has no partner: gray 0.5 is written",
                    export_kind(b->e, node));
        blender_print(b, "(0.5, 0.5, 0.5)");
    }
}

void blender_define_textures(const Blender *b)
{
    const SceneNodeArray *nodes = &b->e->scene->nodes[CATEGORY_TEXTURE];
    for (uint32_t id = 0; id < nodes->count; ++id) {
        const SceneNode *node = &nodes->items[id];
        blender_print(b, "def texture_%u(n):\n", (unsigned)id);
        blender_comment(b, "    ", export_kind(b->e, node), node->name, node->at);
        blender_print(b, "    return ");
        write_texture(b, node);
        blender_print(b, "\n\n\n");
    }
}

static bool uses_object_space(const Blender *b, const SceneNode *node, int depth);

static bool texture_uses_object_space(const Blender *b, uint32_t texture, int depth)
{
    return texture != NONE_ID && uses_object_space(b, texture_node(b, texture), depth + 1);
}

// --- Materials -----------------------------------------------------------------------------------

// Cycles' lobes of half vectors: alpha of an exponent e.
static double exponent_alpha(double e)
{
    return sqrt(2 / (fmax(e, 0) + 2));
}

// color times a number, or a texture.
static void scaled_color(const Blender *b, const SceneNode *node, const char *color,
                         const char *number)
{
    NumberTex k = export_number_tex(b->e, node, number);
    ColorTex c = export_color_tex(b->e, node, color);
    if (k.texture == NONE_ID) {
        c.value = rgb_scale(c.value, (float)k.value);
        blender_color_tex(b, c);
        return;
    }
    blender_print(b, "n.arithmetic(\"multiply\", ");
    blender_color_tex(b, c);
    blender_print(b, ", n.join(*[");
    number_tex(b, k);
    blender_print(b, "] * 3))");
}

static void write_phong(const Blender *b, const SceneNode *node, bool half_vector)
{
    NumberTex specular = export_number_tex(b->e, node, "specular");
    NumberTex shininess = export_number_tex(b->e, node, "shininess");
    NumberTex ambient = export_number_tex(b->e, node, "ambient");
    if (b->local && (ambient.value > 0 || ambient.texture != NONE_ID)) {
        note(b, node, "the ambient term has no partner: it is left out");
    }
    bool shines = specular.value > 0 || specular.texture != NONE_ID;
    blender_print(b, shines ? "n.sum(n.diffuse(" : "n.diffuse(");
    scaled_color(b, node, "color", "diffuse");
    blender_print(b, ")");
    if (!shines) {
        return;
    }
    if (shininess.texture != NONE_ID) {
        note(b, node, "a texture for `shininess`: 20 is written");
        shininess = (NumberTex){20, NONE_ID};
    }
    // Phong's lobe about the mirror direction is about as wide as Blinn's of the fourfold exponent.
    double e = shininess.value * (half_vector ? 1 : 4);
    export_note(
        b->e, node->at,
        "the highlight of `%s` has no partner: Ashikhmin and Shirley's lobe of the exponent "
        "%g is written",
        export_kind(b->e, node), e);
    blender_print(b, ", n.ggx(");
    // In `local` the raw expression: 1 in the mirror direction, where this lobe has (e + 1)/(8 π).
    NumberTex k = specular;
    k.value *= b->local ? 8 / (e + 1) : 1;
    blender_print(b, "n.arithmetic(\"multiply\", ");
    color_field(b, node, "specular_color");
    blender_print(b, ", n.join(*[");
    number_tex(b, k);
    blender_print(b, "] * 3)), ");
    blender_number(b, exponent_alpha(e));
    blender_print(b, ", distribution=\"ASHIKHMIN_SHIRLEY\"))");
}

static bool is_set(ColorTex color)
{
    return color.texture != NONE_ID || color.value.r > 0 || color.value.g > 0 || color.value.b > 0;
}

static bool is_white(ColorTex color)
{
    return color.texture == NONE_ID && color.value.r >= 1 && color.value.g >= 1 &&
           color.value.b >= 1;
}

// A metal's reflectance, at the surface's angle or (`normal`) along its normal.
static void write_conductor(const Blender *b, const SceneNode *node, bool normal)
{
    blender_print(b, "n.conductor(");
    color_field(b, node, "eta");
    blender_print(b, ", ");
    color_field(b, node, "k");
    blender_print(b, normal ? ", 1.0)" : ", n.cosine())");
}

static bool is_metal(const Blender *b, const SceneNode *node)
{
    return is_set(export_color_tex(b->e, node, "eta")) || is_set(export_color_tex(b->e, node, "k"));
}

static void note_roughness(const Blender *b, const SceneNode *node, PairTex alpha)
{
    if (alpha.texture != NONE_ID || fmax(alpha.value.x, alpha.value.y) > 0.15) {
        note(b, node,
             "until Blender 3.6 Cycles' microfacets hide each other by Smith's separable factor, "
             "not the height-correlated one: rough ones are darker at grazing angles (2 % at 60 "
             "degrees for alpha 0.5)");
    }
    if (export_choice(b->e, node, "energy")[0] == 'p') {
        note(b, node,
             "`energy: \"preserve\"`: Cycles' own multiple scattering is written, which a random "
             "walk between facets gives");
    }
}

static void write_ggx(const Blender *b, const SceneNode *node)
{
    Export *e = b->e;
    PairTex alpha = export_pair_tex(e, node, "alpha");
    ColorTex f0 = export_color_tex(e, node, "f0");
    NumberTex ior = export_number_tex(e, node, "ior");
    const char *fresnel = export_choice(e, node, "fresnel");
    bool smooth = alpha.texture == NONE_ID && fmax(alpha.value.x, alpha.value.y) < 1e-4;
    bool metal = is_metal(b, node), pair = is_pair(alpha);
    bool dielectric = !metal && (ior.value > 0 || ior.texture != NONE_ID);
    if (!smooth) {
        note_roughness(b, node, alpha);
    }
    bool preserve = export_choice(e, node, "energy")[0] == 'p';
    if (smooth && metal) {
        blender_print(b, "n.mirror(");
        write_conductor(b, node, false);
        blender_print(b, ")");
        return;
    }
    if (!metal && !dielectric && is_white(f0)) {
        blender_print(b, smooth ? "n.mirror((1, 1, 1)" : "n.ggx((1, 1, 1), ");
        if (!smooth) {
            alpha_field(b, node);
            blender_print(b, ", ");
            number_field(b, node, "rotation");
            blender_print(b, preserve ? ", \"MULTI_GGX\"" : "");
        }
        blender_print(b, ")");
        return;
    }
    if (dielectric) {
        if (fresnel[0] == 's') {
            note(b, node, "Schlick's approximation has no partner: the exact formula is written");
        }
        blender_print(b, "n.ggx_ior(");
        number_tex(b, ior);
    } else {
        note(b, node,
             metal ? "a rough metal's exact reflectance has no partner: it rises from its value at "
                     "the normal to white, as a dielectric's does"
                   : "Schlick's approximation has no partner: the reflectance rises from f0 to "
                     "white as that of glass does");
        blender_print(b, "n.ggx_tinted(");
        if (metal) {
            write_conductor(b, node, true);
        } else {
            blender_color_tex(b, f0);
        }
    }
    blender_print(b, ", ");
    alpha_field(b, node);
    if (pair) {
        blender_print(b, ", ");
        number_field(b, node, "rotation");
    }
    blender_print(b, preserve ? ", distribution=\"MULTI_GGX\")" : ")");
}

static void write_mirror(const Blender *b, const SceneNode *node)
{
    blender_print(b, "n.mirror(");
    if (is_metal(b, node)) {
        write_conductor(b, node, false);
    } else {
        color_field(b, node, "color");
    }
    blender_print(b, ")");
}

static void write_glass(const Blender *b, const SceneNode *node)
{
    Export *e = b->e;
    PairTex alpha = export_pair_tex(e, node, "alpha");
    Rgb absorption = export_rgb(e, node, "absorption");
    bool schlick = export_choice(e, node, "approximation")[0] == 's';
    bool rough = alpha.texture != NONE_ID || fmax(alpha.value.x, alpha.value.y) >= 1e-4;
    double outside = export_number(e, node, "outside");
    if (is_pair(alpha)) {
        note(b, node, "a pair of `alpha` in glass: its mean is written");
        alpha.value.x = sqrt(alpha.value.x * alpha.value.y);
    }
    if (rough) {
        note(b, node,
             "until Blender 3.6 Cycles' frosted glass takes Fresnel's factor at the surface's "
             "normal, not at the facet's: at grazing angles the parts differ");
    }
    if (export_int(e, node, "priority") != 0) {
        note(b, node, "`priority` has no partner: where bodies overlap the picture differs");
    }
    if (outside != 1) {
        note(b, node, "Cycles leaves out the factor (nt/ni)^2 of radiance within a body");
    }
    blender_print(b, "n.glass(");
    blender_number(b, export_number(e, node, "ior") / outside);
    blender_print(b, ", ");
    color_field(b, node, "color");
    blender_print(b, ", ");
    if (rough) {
        number_tex(b, (NumberTex){alpha.value.x, alpha.texture});
    } else {
        blender_print(b, "0.0");
    }
    if (!rgb_is_black(absorption)) {
        blender_print(b, ", absorption=");
        blender_rgb(b, absorption);
    }
    blender_print(b, schlick ? ", schlick=True)" : ")");
}

static void write_part(const Blender *b, uint32_t material)
{
    if (material == NONE_ID) {
        blender_print(b, "n.diffuse((0.5, 0.5, 0.5))");
    } else {
        blender_print(b, "material_%u(n)", (unsigned)material);
    }
}

static void write_emissive(const Blender *b, const SceneNode *node)
{
    uint32_t base = export_id(b->e, node, "base");
    if (b->local) { // emission isn't seen there
        write_part(b, base);
        return;
    }
    Emission radiance = export_emission(b->e, node, "radiance");
    Rgb value = rgb_gray(0);
    emission_to_rgb(&radiance, rgb_gray(1), &value);
    blender_print(b, "n.emissive(");
    blender_color_tex(b, (ColorTex){value, radiance.texture});
    blender_print(b, ", ");
    if (base == NONE_ID) {
        blender_print(b, "None");
    } else {
        write_part(b, base);
    }
    blender_print(b, ")");
}

static void write_mix(const Blender *b, const SceneNode *node)
{
    uint32_t a = export_id(b->e, node, "a"), c = export_id(b->e, node, "b");
    if (blender_is_glass(b, a) != blender_is_glass(b, c)) {
        note(b, node, "absorption of glass in a `mix` counts in full");
    }
    blender_print(b, "n.mix(");
    write_part(b, a);
    blender_print(b, ", ");
    write_part(b, c);
    blender_print(b, ", ");
    number_field(b, node, "weight");
    blender_print(b, ")");
}

// A coat over its base, without what happens between them.
static void write_layered(const Blender *b, const SceneNode *node)
{
    uint32_t coat = export_id(b->e, node, "coat");
    const SceneNode *top = coat == NONE_ID ? NULL : material_node(b, coat);
    double ior = 0;
    if (top && export_is(b->e, top, "fresnel")) {
        ior = export_number(b->e, top, "ior");
    } else if (top && export_is(b->e, top, "ggx")) {
        ior = export_number_tex(b->e, top, "ior").value;
    }
    note(b, node,
         "`layered` has no partner: the coat's reflection over the base is written, mixed by "
         "Fresnel's factor, without what is reflected between them or absorbed");
    blender_print(b, "n.coated(");
    write_part(b, export_id(b->e, node, "base"));
    blender_print(b, ", ");
    blender_number(b, ior > 1 ? ior : 1.5);
    blender_print(b, ", ");
    if (top && (export_is(b->e, top, "fresnel") || export_is(b->e, top, "ggx"))) {
        PairTex alpha = export_pair_tex(b->e, top, "alpha");
        number_tex(b, (NumberTex){alpha.value.x, alpha.texture});
    } else {
        blender_print(b, "0.0");
    }
    blender_print(b, ")");
}

static void write_sides(const Blender *b, const SceneNode *node)
{
    uint32_t front = export_id(b->e, node, "front"), back = export_id(b->e, node, "back");
    blender_print(b, "n.two_sided(material_%u, material_%u)", (unsigned)front,
                  (unsigned)(back == NONE_ID ? front : back));
}

static void write_bent(const Blender *b, const SceneNode *node, bool normals)
{
    note(b, node,
         normals ? "Cycles' own tangents are used: where texture coordinates are curved or skewed "
                   "the normals turn a little"
                 : "Cycles takes slopes over a pixel, not over 1/1024 of the texture coordinates");
    blender_print(b, normals ? "n.normal_map(" : "n.bump_map(");
    write_part(b, export_id(b->e, node, "base"));
    blender_print(b, ", ");
    if (normals) {
        color_field(b, node, "map");
    } else {
        number_field(b, node, "map");
    }
    blender_print(b, ", ");
    number_field(b, node, "strength");
    blender_print(b, ")");
}

static void write_material(const Blender *b, const SceneNode *node)
{
    Export *e = b->e;
    if (export_is(e, node, "lambert")) {
        blender_print(b, "n.diffuse(");
        color_field(b, node, "color");
        blender_print(b, ")");
    } else if (export_is(e, node, "phong") || export_is(e, node, "blinn_phong")) {
        write_phong(b, node, export_is(e, node, "blinn_phong"));
    } else if (export_is(e, node, "burley")) {
        blender_print(b, "n.burley(");
        color_field(b, node, "color");
        blender_print(b, ", ");
        number_field(b, node, "roughness");
        blender_print(b, ")");
    } else if (export_is(e, node, "ggx")) {
        write_ggx(b, node);
    } else if (b->local && (export_is(e, node, "mirror") || export_is(e, node, "fresnel"))) {
        blender_print(b, "n.black()"); // as the integrator `local` shows them
    } else if (export_is(e, node, "mirror")) {
        write_mirror(b, node);
    } else if (export_is(e, node, "fresnel")) {
        write_glass(b, node);
    } else if (export_is(e, node, "emissive")) {
        write_emissive(b, node);
    } else if (export_is(e, node, "mix")) {
        write_mix(b, node);
    } else if (export_is(e, node, "layered")) {
        write_layered(b, node);
    } else if (export_is(e, node, "two_sided")) {
        write_sides(b, node);
    } else if (export_is(e, node, "mask")) {
        blender_print(b, "n.mask(");
        number_field(b, node, "opacity");
        blender_print(b, ", ");
        write_part(b, export_id(e, node, "base"));
        blender_print(b, ")");
    } else if (export_is(e, node, "normal_map") || export_is(e, node, "bump_map")) {
        write_bent(b, node, export_is(e, node, "normal_map"));
    } else {
        export_note(e, node->at, "`%s` has no partner: gray 0.5 by Lambert's law is written",
                    export_kind(e, node));
        blender_print(b, "n.diffuse((0.5, 0.5, 0.5))");
    }
}

void blender_define_materials(const Blender *b)
{
    const SceneNodeArray *nodes = &b->e->scene->nodes[CATEGORY_MATERIAL];
    for (uint32_t id = 0; id < nodes->count; ++id) {
        const SceneNode *node = &nodes->items[id];
        blender_print(b, "def material_%u(n):\n", (unsigned)id);
        blender_comment(b, "    ", export_kind(b->e, node), node->name, node->at);
        blender_print(b, "    return ");
        write_material(b, node);
        blender_print(b, "\n\n\nmaterial_%u.title = ", (unsigned)id);
        blender_name(b, export_kind(b->e, node), node->name, node->at);
        blender_print(b, "\n\n\n");
    }
}

// --- For the others ------------------------------------------------------------------------------

bool blender_is_glass(const Blender *b, uint32_t material)
{
    return material != NONE_ID && export_is(b->e, material_node(b, material), "fresnel");
}

static bool emits(const Blender *b, uint32_t material, int depth)
{
    if (material == NONE_ID || depth > 64) {
        return false;
    }
    const SceneNode *node = material_node(b, material);
    const NodeType *type = scene_node_type(b->e->scene, node);
    const char *params = scene_params(b->e->scene, node);
    bool found = export_is(b->e, node, "emissive");
    for (size_t i = 0; i < type->param_count && !found; ++i) {
        const Param *param = &type->params[i];
        if (param->type == PARAM_NODE && param->category == CATEGORY_MATERIAL) {
            const void *value = params + param->offset;
            found = emits(b, *(const uint32_t *)value, depth + 1);
        }
    }
    return found;
}

bool blender_emits(const Blender *b, uint32_t material)
{
    return emits(b, material, 0);
}

// Its own `space`, or any texture or material that any of its fields names.
static bool uses_object_space(const Blender *b, const SceneNode *node, int depth)
{
    const NodeType *type = scene_node_type(b->e->scene, node);
    const char *params = scene_params(b->e->scene, node);
    for (size_t i = 0; i < type->param_count && depth < 64; ++i) {
        const Param *param = &type->params[i];
        const void *value = params + param->offset;
        uint32_t texture = NONE_ID, material = NONE_ID;
        if (param->type == PARAM_COLOR_TEX) {
            texture = ((const ColorTex *)value)->texture;
        } else if (param->type == PARAM_NUMBER_TEX) {
            texture = ((const NumberTex *)value)->texture;
        } else if (param->type == PARAM_PAIR_TEX) {
            texture = ((const PairTex *)value)->texture;
        } else if (param->type == PARAM_EMISSION) {
            texture = ((const Emission *)value)->texture;
        } else if (param->type == PARAM_NODE && param->category == CATEGORY_MATERIAL) {
            material = *(const uint32_t *)value;
        } else if (strcmp(param->name, "space") == 0 &&
                   strcmp(export_choice(b->e, node, "space"), "object") == 0) {
            return true;
        }
        if (texture_uses_object_space(b, texture, depth) ||
            (material != NONE_ID && uses_object_space(b, material_node(b, material), depth + 1))) {
            return true;
        }
    }
    return false;
}

bool blender_uses_object_space(const Blender *b, uint32_t material)
{
    return material != NONE_ID && uses_object_space(b, material_node(b, material), 0);
}
