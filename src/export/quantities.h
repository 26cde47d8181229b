// What the writers for other renderers compute from a scene: light in W, cameras, sizes.
#ifndef EXPORT_QUANTITIES_H
#define EXPORT_QUANTITIES_H

#include "export/fields.h"

// W/sr on the axis of a point or spot light; `steradians` is its power over its intensity.
Rgb export_intensity(Export *e, uint32_t light, double steradians);
// W/m² of a directional light.
Rgb export_irradiance(Export *e, uint32_t light);
// A light's quantity times its color.
Rgb export_colored(Export *e, uint32_t light, Quantity quantity);

// ∫ g dω of the slides' falloff of two angles.
double export_cone_steradians(double inner, double outer);
// The same of any falloff (NULL: none, 4π).
double export_falloff_steradians(Export *e, const SceneNode *falloff);
// A spot light's axis in its own space, not normalized.
Vec3 export_spot_axis(Export *e, const SceneNode *light);

// What the camera looks through: a map from its own axes (right, up, back) to the world; a lens of
// half_width and half_height at a distance of 1 (orthographic: in metres). `node` is NULL where the
// scene has no camera, and the one that the renderer makes then is given.
typedef struct ExportView {
    const SceneNode *node;
    Affine frame;
    const char *projection; // "perspective", …
    double fov, half_height;
    double aperture, focus; // 0: all is in focus
} ExportView;
ExportView export_view(Export *e, Box3 bounds, double aspect);

// The box of what is finite; empty without memory, or where nothing is.
Box3 export_scene_box(const Scene *scene);

#endif
