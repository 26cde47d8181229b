// A Python script for Blender: its head, the prelude, the definitions and the scene's own build().
#include "export/blender.h"
#include "export/quantities.h"
#include "export/targets.h"

#include "blender_prelude.inc"

#include <inttypes.h>
#include <string.h>

// --- Head ----------------------------------------------------------------------------------------

static void write_head(const Blender *b)
{
    Export *e = b->e;
    blender_print(b, "# %s, for Blender 3.4 and later with Cycles: written by scnrender.\n",
                  e->title);
    blender_print(
        b, "#\n"
           "# From Blender: open this file in the Text Editor and run it (Alt P). It makes a "
           "new scene and\n# changes no other.\n"
           "# As a batch, into a linear picture of 32-bit floats:\n"
           "#     blender -b --factory-startup -P <this file> -- --output FILE.exr "
           "[--samples N] [--seeds N,...]\n#\n");
    if (e->notes->list.count == 0) {
        blender_print(b, "# All of the scene has an exact partner.\n");
    } else {
        blender_print(b, "# What has no exact partner:\n");
        export_write_notes(e, "#   ");
    }
    blender_print(b, "\n");
}

// --- Settings ------------------------------------------------------------------------------------

static double setting_number(const Blender *b, const char *kind, const char *field)
{
    const Scene *scene = b->e->scene;
    int number = schema_find(scene->schema, str_from(kind));
    const char *params = scene_setting(scene, kind);
    if (number < 0 || !params) {
        return 0;
    }
    const NodeType *type = scene->schema->types[number];
    int index = node_type_find_param(type, str_from(field));
    bool good = index >= 0 && type->params[index].type == PARAM_NUMBER;
    return good ? *(const double *)(const void *)(params + type->params[index].offset) : 0;
}

// Cycles' widths are of its own: half of ours for Blackman-Harris; its Gaussian exp(-18 (x/w)^2)
// has w = 1.5 widths and ends twice as far out.
static void write_film(const Blender *b, int64_t width, int64_t height)
{
    char filter[64];
    Span nowhere = {0, 0, 0};
    export_setting_choice(b->e, "film", "filter", filter, sizeof filter);
    double size = setting_number(b, "film", "filter_width");
    const char *type = "BOX";
    if (strcmp(filter, "blackman_harris") == 0) {
        type = "BLACKMAN_HARRIS";
        size = (size > 0 ? size : 3) / 2;
    } else if (strcmp(filter, "gaussian") == 0) {
        type = "GAUSSIAN";
        size = (size > 0 ? size : 3) * 2 / 3;
        export_note(b->e, nowhere, "the Gaussian filter ends at twice the width");
    } else if (strcmp(filter, "center") == 0) {
        type = "BLACKMAN_HARRIS";
        size = 0.01; // Cycles' least: a hundredth of a pixel to either side
    } else if (strcmp(filter, "tent") == 0) {
        export_note(b->e, nowhere, "the tent filter has no partner: a box is written");
        size = 1;
    } else {
        if (size > 0 && size != 1) {
            export_note(b->e, nowhere, "Cycles' box filter is 1 pixel wide");
        }
        size = 1;
    }
    size = fmax(size, 0.01);
    blender_print(b, "    film(%" PRId64 ", %" PRId64 ", \"%s\", ", width, height, type);
    blender_number(b, size);
    blender_print(b, ", ");
    blender_number(b, setting_number(b, "film", "exposure"));
    blender_print(b, ")\n");
}

static void write_render(const Blender *b, const char *integrator)
{
    Span nowhere = {0, 0, 0};
    int64_t bounces = export_setting_int(b->e, "render", "bounces");
    double clamp = setting_number(b, "render", "clamp");
    bool path = strcmp(integrator, "path") == 0;
    if (!path && !b->local && strcmp(integrator, "direct") != 0) {
        export_note(b->e, nowhere, "the integrator \"%s\" has no partner: \"direct\" is written",
                    integrator);
    }
    if (bounces < 1) {
        export_note(b->e, nowhere, "`bounces: 0` has no partner: direct light is computed, too");
    }
    if (clamp > 0) {
        export_note(b->e, nowhere, "`clamp` is Cycles' own, which holds down a whole path's sum");
    }
    // Cycles counts indirect bounces, the scene scattering events.
    int64_t indirect = bounces < 1 ? 0 : bounces > 1025 ? 1024 : bounces - 1;
    blender_print(b, "    render_settings(%" PRId64 ", %" PRId64 ", %d, %d, ",
                  export_setting_int(b->e, "render", "samples"),
                  export_setting_int(b->e, "render", "seed") & 0x7fffffff,
                  b->local ? 0 : (int)indirect, path ? (int)indirect : 0);
    blender_number(b, clamp);
    blender_print(b, ")\n\n");
}

static double column_length(const Affine *map, int i)
{
    return length(vec3(map->m[0][i], map->m[1][i], map->m[2][i]));
}

static Affine without_scale(const Affine *map)
{
    Affine out = *map;
    for (int i = 0; i < 3; ++i) {
        double l = column_length(map, i);
        for (int row = 0; row < 3; ++row) {
            out.m[row][i] /= l > 0 ? l : 1;
        }
    }
    return out;
}

static void write_camera(const Blender *b, const ExportView *view, bool square)
{
    Affine frame = without_scale(&view->frame);
    double right = column_length(&view->frame, 0), up = column_length(&view->frame, 1);
    double back = column_length(&view->frame, 2);
    bool orthographic = strcmp(view->projection, "orthographic") == 0;
    bool even = fabs(right - up) < 1e-6 * up && (orthographic || fabs(back - up) < 1e-6 * up);
    Span at = view->node ? view->node->at : (Span){0, 0, 0};
    if (!even) {
        export_note(b->e, at, "a camera's transform that stretches: it is left out");
    }
    if (strcmp(view->projection, "fisheye") == 0 && !square) {
        export_note(b->e, at, "Cycles' fisheye is round and fits the picture's longer side");
    }
    blender_print(b, "    camera(");
    blender_name(b, "camera", view->node ? view->node->name : 0, at);
    blender_print(b, ", ");
    blender_matrix(b, &frame);
    blender_print(b, ", \"%s\", ", view->projection);
    blender_number(b, view->fov);
    if (orthographic) {
        blender_print(b, ", height=");
        blender_number(b, 2 * view->half_height * up);
    }
    if (view->aperture > 0 && strcmp(view->projection, "perspective") == 0) {
        blender_print(b, ", aperture=");
        blender_number(b, view->aperture * up);
        blender_print(b, ", focus=");
        blender_number(b, view->focus * back);
    }
    blender_print(b, ")\n");
}

// --- The file ------------------------------------------------------------------------------------

static void write_build(const Blender *b, const ExportView *view, const char *integrator)
{
    int64_t width = export_setting_int(b->e, "film", "width");
    int64_t height = export_setting_int(b->e, "film", "height");
    blender_print(b, "def build():\n    into, material = None, None\n");
    write_film(b, width, height);
    write_render(b, integrator);
    if (view->node) {
        blender_comment(b, "    ", "camera", view->node->name, view->node->at);
    }
    write_camera(b, view, width == height);
    blender_print(b, "\n    # Lights\n\n");
    blender_surroundings(b, "    ");
    blender_lights(b, 0, "    ");
    blender_print(b, "    # Shapes\n\n");
    blender_shapes(b, 0, "    ");
    blender_instances(b, "    ");
    blender_print(b, "\nif __name__ == \"__main__\":\n    main(");
    blender_string(b, b->e->title);
    blender_print(b, ", build)\n");
}

void blender_write(Export *e)
{
    char integrator[64];
    export_setting_choice(e, "render", "integrator", integrator, sizeof integrator);
    int64_t width = export_setting_int(e, "film", "width");
    int64_t height = export_setting_int(e, "film", "height");
    Box3 box = export_scene_box(e->scene);
    ExportView view = export_view(e, box, (double)width / (double)(height > 0 ? height : 1));
    Blender b = {.e = e, .local = strcmp(integrator, "local") == 0, .box = box};
    b.eye = vec3(view.frame.m[0][3], view.frame.m[1][3], view.frame.m[2][3]);
    b.shadows = !b.local || export_setting_bool(e, "render", "shadows");
    b.lights = b.local ? PI : 1;
    write_head(&b);
    fwrite(blender_prelude, 1, sizeof blender_prelude, e->out);
    blender_print(&b,
                  "# --- The scene "
                  "-----------------------------------------------------------------------------"
                  "-------\n\n\n");
    blender_define_textures(&b);
    blender_define_materials(&b);
    blender_define_meshes(&b);
    blender_define_prototypes(&b);
    write_build(&b, &view, integrator);
}
