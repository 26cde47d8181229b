// A scene for POV-Ray 3.7: its head, its camera, and the order of the rest.
#include "export/pov.h"
#include "export/quantities.h"
#include "export/targets.h"

#include <inttypes.h>
#include <string.h>

// --- Camera --------------------------------------------------------------------------------------

static Vec3 column(const Affine *map, int i)
{
    return vec3(map->m[0][i], map->m[1][i], map->m[2][i]);
}

static void write_view(const Pov *pov, const Affine *frame, double half_width, double half_height)
{
    FILE *out = pov->e->out;
    fputs("  location ", out);
    pov_point(pov, column(frame, 3));
    fputs("\n  right ", out);
    pov_point(pov, scale(column(frame, 0), 2 * half_width));
    fputs("\n  up ", out);
    pov_point(pov, scale(column(frame, 1), 2 * half_height));
    fputs("\n  direction ", out);
    pov_point(pov, neg(column(frame, 2)));
    fputs("\n}\n\n", out);
}

static void write_lens(const Pov *pov, const ExportView *view)
{
    if (!(view->aperture > 0)) {
        return;
    }
    export_note(pov->e, view->node->at,
                "POV-Ray's lens blurs by its own law: the plane in focus is the same, the blur "
                "about as large");
    FILE *out = pov->e->out;
    fputs("  aperture ", out);
    pov_number(pov, 2 * view->aperture);
    fputs(" focal_point ", out);
    pov_point(pov, sub(column(&view->frame, 3), scale(column(&view->frame, 2), view->focus)));
    fputs(" blur_samples 64 variance 0\n", out);
}

static void write_camera(const Pov *pov, const ExportView *view, double aspect)
{
    FILE *out = pov->e->out;
    double half = view->half_height;
    if (view->node) {
        pov_comment(pov, "camera", view->node->name, view->node->at, "");
    }
    if (strcmp(view->projection, "orthographic") == 0) {
        fputs("camera {\n  orthographic\n", out);
    } else if (strcmp(view->projection, "perspective") == 0) {
        fputs("camera {\n  perspective // vertical field of view: ", out);
        pov_number(pov, view->fov * 180 / PI);
        fputs(" degrees\n", out);
        write_lens(pov, view);
    } else if (strcmp(view->projection, "panorama") == 0) {
        half = 0.5;
        fputs("camera {\n  spherical angle 360 180\n", out);
    } else {
        half = 0.5;
        export_note(pov->e, view->node->at, "POV-Ray's fisheye is dark beyond its circle");
        fputs("camera {\n  fisheye angle ", out);
        pov_number(pov, view->fov * 180 / PI);
        fputc('\n', out);
    }
    write_view(pov, &view->frame, half * aspect, half);
}

// The distance from the origin that nothing finite exceeds.
static double box_radius(Box3 box)
{
    return box3_is_empty(box) ? 1 : fmax(length(box.min), length(box.max));
}

// --- The file ------------------------------------------------------------------------------------

static void check_integrator(const Pov *pov, const char *integrator, int64_t bounces)
{
    Span nowhere = {0, 0, 0};
    if (strcmp(integrator, "path") == 0 && bounces > 1) {
        export_note(pov->e, nowhere,
                    "global illumination has no partner: direct light, mirrors and refraction "
                    "only, as in the integrator \"direct\"");
    } else if (!pov->local && strcmp(integrator, "path") != 0 &&
               strcmp(integrator, "direct") != 0) {
        export_note(pov->e, nowhere, "the integrator \"%s\" has no partner: \"direct\" is written",
                    integrator);
    }
}

static void write_head(const Pov *pov, int64_t width, int64_t height, const char *integrator)
{
    FILE *out = pov->e->out;
    fprintf(out, "// %s, for POV-Ray 3.7: written by scnrender from integrator \"%s\".\n",
            pov->e->title, integrator);
    fprintf(out,
            "// Render it with one ray a pixel into a linear picture:\n"
            "//     povray +I<this file> +W%" PRId64 " +H%" PRId64 " +FE -A -D\n"
            "// Lights are written as %s; z is mirrored.\n",
            width, height,
            pov->local ? "their intensity, since `local` takes the raw expressions"
                       : "their intensity over pi, which POV-Ray's diffuse lacks");
    if (pov->e->notes->list.count == 0) {
        fputs("// All of the scene has an exact partner.\n", out);
    } else {
        fputs("// What has no exact partner:\n", out);
        export_write_notes(pov->e, "//   ");
    }
    fputs("\n#version 3.7;\n", out);
}

void povray_write(Export *e)
{
    char integrator[64];
    int64_t width = export_setting_int(e, "film", "width");
    int64_t height = export_setting_int(e, "film", "height");
    int64_t bounces = export_setting_int(e, "render", "bounces");
    export_setting_choice(e, "render", "integrator", integrator, sizeof integrator);
    Box3 box = export_scene_box(e->scene);
    Pov pov = {.e = e, .local = strcmp(integrator, "local") == 0, .radius = box_radius(box)};
    pov.shadows = !pov.local || export_setting_bool(e, "render", "shadows");
    pov.light_scale = pov.local ? 1 : 1 / PI;
    pov_sum_ambient(&pov);
    check_integrator(&pov, integrator, bounces);
    write_head(&pov, width, height, integrator);
    // The bailout is that of the integrator `direct`: fainter branches are cut off.
    int64_t level = pov.local ? 1 : bounces < 1 ? 1 : bounces > 256 ? 256 : bounces;
    fprintf(e->out, "global_settings { assumed_gamma 1 adc_bailout 0.0001 max_trace_level %d }\n\n",
            (int)level);
    double aspect = (double)width / (double)(height > 0 ? height : 1);
    ExportView view = export_view(e, box, aspect);
    write_camera(&pov, &view, aspect);
    pov_declare_materials(&pov);
    pov_declare_meshes(&pov);
    pov_declare_prototypes(&pov);
    pov_lights(&pov);
    pov_shapes(&pov);
}
