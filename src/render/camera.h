// Cameras: one file a projection in cameras/.
#ifndef RENDER_CAMERA_H
#define RENDER_CAMERA_H

#include "render/sampler.h"
#include "render/shape.h"

// The `camera` kind's fields, as written and as derived by its finish.
typedef struct CameraParams {
    Vec3 position, look_at, direction, up;
    double fov;         // vertical, radians
    int32_t projection; // CAMERA_PERSPECTIVE, …
    double height;      // of the view volume: orthographic
    double aperture;    // radius of the lens, m; 0: a pinhole
    double f_stop, focal_length;
    double focus_distance; // from the lens to the plane in focus, m
    Vec3 focus_at;
    // derived
    Affine to_world; // camera frame: looks along -z, +y up, +x right; node transform included
} CameraParams;

enum { CAMERA_PERSPECTIVE, CAMERA_ORTHOGRAPHIC };

typedef struct Camera {
    CameraParams params;
    double aspect; // width / height of the film
} Camera;

// Ready to make rays; `node` is a camera's id in the scene.
void camera_prepare(Camera *camera, const Scene *scene, uint32_t node, int width, int height);
// The ray through film position (x, y) in [0, 1)², (0, 0) the top left corner, with lens numbers
// (lens_u, lens_v) in [0, 1)². direction is of unit length; false where the projection has no ray.
bool camera_ray(const Camera *camera, double x, double y, float lens_u, float lens_v, Ray *ray);

#endif
