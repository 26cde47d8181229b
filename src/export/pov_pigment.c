// Textures as POV-Ray's pigments.
#include "export/pov.h"

#include <string.h>

static const SceneNode *texture_node(const Pov *pov, uint32_t texture)
{
    return scene_node(pov->e->scene, CATEGORY_TEXTURE, texture);
}

unsigned pov_texture_uses(const Pov *pov, uint32_t texture)
{
    if (texture == NONE_ID) {
        return 0;
    }
    const SceneNode *node = texture_node(pov, texture);
    if (export_is(pov->e, node, "checker")) {
        const char *space = export_choice(pov->e, node, "space");
        return strcmp(space, "uv") == 0       ? POV_USES_UV
               : strcmp(space, "object") == 0 ? POV_USES_OBJECT
                                              : POV_USES_WORLD;
    }
    return export_is(pov->e, node, "image") ? POV_USES_UV : 0;
}

static Rgb mean_of(const Pov *pov, ColorTex color)
{
    return color.texture == NONE_ID ? color.value
                                    : rgb_mul(color.value, pov_texture_mean(pov, color.texture));
}

Rgb pov_texture_mean(const Pov *pov, uint32_t texture)
{
    const SceneNode *node = texture_node(pov, texture);
    if (export_is(pov->e, node, "checker")) {
        Rgb a = mean_of(pov, export_color_tex(pov->e, node, "a"));
        Rgb b = mean_of(pov, export_color_tex(pov->e, node, "b"));
        return rgb_scale(rgb_add(a, b), 0.5f);
    }
    return rgb_gray(export_is(pov->e, node, "vertex_color") ? 1 : 0.5f);
}

static void plain(const Pov *pov, Rgb color, const char *indent)
{
    fprintf(pov->e->out, "%spigment { ", indent);
    pov_rgb(pov, color);
    fputs(" }\n", pov->e->out);
}

// Where a pattern in uv comes to lie on the shape; closes the pigment.
static void close_uv(const Pov *pov, const PovUv *uv, const char *indent)
{
    if (uv->kind == POV_UV_MAP) {
        fputc('\n', pov->e->out);
        pov_texture_matrix(pov, &uv->map, indent);
        fprintf(pov->e->out, "%s}\n", indent);
    } else {
        fputs(" }\n", pov->e->out);
    }
}

static void open_pigment(const Pov *pov, bool in_uv, const PovUv *uv, const char *indent)
{
    bool own = in_uv && uv->kind == POV_UV_OWN;
    fprintf(pov->e->out, "%spigment { %s", indent, own ? "uv_mapping " : "");
}

static void checker(const Pov *pov, const SceneNode *node, Rgb factor, const PovUv *uv,
                    const char *indent)
{
    FILE *out = pov->e->out;
    ColorTex a = export_color_tex(pov->e, node, "a"), b = export_color_tex(pov->e, node, "b");
    Vec2 scale = export_vec2(pov->e, node, "scale");
    bool in_uv = strcmp(export_choice(pov->e, node, "space"), "uv") == 0;
    if (a.texture != NONE_ID || b.texture != NONE_ID) {
        export_note(pov->e, node->at,
                    "textures as the colors of a checker: their middle colors are written");
    }
    open_pigment(pov, in_uv, uv, indent);
    fputs("checker ", out);
    pov_rgb(pov, rgb_mul(mean_of(pov, a), factor));
    fputs(" ", out);
    pov_rgb(pov, rgb_mul(mean_of(pov, b), factor));
    fputs(" scale ", out);
    if (in_uv) {
        pov_triple(pov, vec3(1 / scale.x, 1 / scale.y, 1));
        close_uv(pov, uv, indent);
    } else { // mirrored, so that the cells are numbered as in the scene
        pov_triple(pov, vec3(1 / scale.x, 1 / scale.x, -1 / scale.x));
        fputs(" }\n", out);
    }
}

// "png" for "a/b.PNG" where POV-Ray reads such files, else NULL.
static const char *image_type(const char *file)
{
    static const struct {
        const char *ending, *type;
    } types[] = {{".png", "png"},  {".jpg", "jpeg"},  {".jpeg", "jpeg"}, {".exr", "exr"},
                 {".tif", "tiff"}, {".tiff", "tiff"}, {".hdr", "hdr"},   {".tga", "tga"}};
    const char *dot = strrchr(file, '.');
    for (size_t i = 0; dot && i < sizeof types / sizeof *types; ++i) {
        if (strcasecmp(dot, types[i].ending) == 0) {
            return types[i].type;
        }
    }
    return NULL;
}

static void image(const Pov *pov, const SceneNode *node, Rgb factor, const PovUv *uv, Span at,
                  const char *indent)
{
    FILE *out = pov->e->out;
    const char *file = export_file(pov->e, node, "file"), *type = file ? image_type(file) : NULL;
    if (!type || strpbrk(file, "\"\\\n")) {
        export_note(pov->e, node->at, "POV-Ray can't read this picture: gray 0.5 is written");
        plain(pov, rgb_scale(factor, 0.5f), indent);
        return;
    }
    if (factor.r != 1 || factor.g != 1 || factor.b != 1) {
        export_note(pov->e, at, "a picture times a color: the color is left out");
    }
    const char *encoding = export_choice(pov->e, node, "encoding");
    const char *wrap = export_choice(pov->e, node, "wrap");
    bool near = strcmp(export_choice(pov->e, node, "filter"), "nearest") == 0;
    if (strcmp(wrap, "repeat") != 0) {
        export_note(pov->e, node->at, "`wrap` other than \"repeat\": the picture is repeated");
    }
    export_note(pov->e, node->at,
                "a picture is filtered POV-Ray's way: its texels may lie half a texel apart");
    Vec2 scale = export_vec2(pov->e, node, "scale"), offset = export_vec2(pov->e, node, "offset");
    open_pigment(pov, true, uv, indent);
    fprintf(out, "image_map { %s \"%s\"", type, file);
    if (strcmp(encoding, "auto") != 0) {
        fputs(strcmp(encoding, "srgb") == 0 ? " gamma srgb" : " gamma 1", out);
    }
    fprintf(out, "%s } translate ", near ? "" : " interpolate 2");
    pov_triple(pov, vec3(-offset.x, -offset.y, 0));
    fputs(" scale ", out);
    pov_triple(pov, vec3(1 / scale.x, 1 / scale.y, 1));
    close_uv(pov, uv, indent);
}

void pov_pigment(const Pov *pov, uint32_t texture, Rgb factor, const PovUv *uv, Span at,
                 const char *indent)
{
    if (texture == NONE_ID) {
        plain(pov, factor, indent);
        return;
    }
    const SceneNode *node = texture_node(pov, texture);
    unsigned uses = pov_texture_uses(pov, texture);
    bool lost = uses == 0 || ((uses & POV_USES_UV) && uv->kind == POV_UV_NONE);
    if (lost) {
        export_note(pov->e, node->at, "`%s` %s: one color in its middle is written",
                    export_kind(pov->e, node),
                    uses ? "on this kind of shape, whose uv POV-Ray lays out in another way"
                         : "has no partner");
        plain(pov, rgb_mul(factor, pov_texture_mean(pov, texture)), indent);
    } else if (export_is(pov->e, node, "checker")) {
        checker(pov, node, factor, uv, indent);
    } else {
        image(pov, node, factor, uv, at, indent);
    }
}
