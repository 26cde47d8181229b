// Cameras: from a place on the film to a ray.
#ifndef RENDER_CAMERA_H
#define RENDER_CAMERA_H

#include "render/sampler.h"
#include "render/shape.h"

typedef enum Projection {
    CAMERA_PERSPECTIVE,
    CAMERA_ORTHOGRAPHIC,
    CAMERA_FISHEYE,  // equidistant: the angle off the axis grows with the distance on the film
    CAMERA_PANORAMA, // all directions, by longitude and latitude
} Projection;

// The `camera` kind's fields, as written and as derived by its finish.
typedef struct CameraParams {
    Vec3 position, look_at, direction, up;
    double fov;         // vertical, radians
    int32_t projection; // Projection
    double height;      // of the view volume: orthographic
    double aperture; // radius of the lens, m; 0: a pinhole. Derived from f_stop where that is set
    double f_stop, focal_length;
    double focus_distance; // from the lens to the plane in focus, m; derived where not set
    Vec3 focus_at;
    // derived
    Affine frame; // camera's own frame to the node's: looks along -z, +y up, +x right
} CameraParams;

typedef struct Camera {
    CameraParams params;
    Affine to_world; // camera's own frame to the world, the node's transform included
    double half_width,
        half_height; // of the film's picture at distance 1 (orthographic: of the view)
    bool pinhole;    // a perspective without a lens: all rays begin in one point
} Camera;

// Ready to make rays on a film of width × height pixels (square ones); `node` is a camera's id.
void camera_prepare(Camera *camera, const Scene *scene, uint32_t node, int width, int height);
// The same from finished parameters and the transform of their node.
void camera_setup(Camera *camera, const CameraParams *params, const Affine *transform, int width,
                  int height);
// The camera of a scene without one: it looks with a field of view of 40 degrees at the centre of
// `bounds` from the direction (0.5, 0.4, 1), from where all of the box is in the picture. A box
// that is empty or not finite counts as the unit cube about the origin.
void camera_default(Camera *camera, Box3 bounds, int width, int height);
// The id of the first camera of that name, or NONE_ID.
uint32_t scene_find_camera(const Scene *scene, Str name);

// The ray through film position (x, y), (0, 0) the top left corner of the picture, (1, 1) the
// bottom right one (places outside are fine), with lens numbers (lens_u, lens_v) in [0, 1)².
// direction is of unit length; false where the projection has no ray.
bool camera_ray(const Camera *camera, double x, double y, float lens_u, float lens_v, Ray *ray);
// Part of the film, in the same measure.
typedef struct FilmBox {
    double x0, y0, x1, y1;
} FilmBox;
// Where on the film all of a box in the world is seen, by way of the whole lens. False where that
// can't be told: it reaches behind the camera, or the projection isn't flat.
bool camera_film_box(const Camera *camera, Box3 bounds, FilmBox *out);
// How a camera sees a point of the world.
typedef struct CameraView {
    double x, y;      // where on the film, as for camera_ray
    Vec3 from;        // where the ray to the point begins
    Vec3 direction;   // unit, from the point to there
    double distance;  // to there
    double film_area; // of the film, the whole being 1, over the area of a surface at the point
                      // that faces the camera, m²
} CameraView;
// Finds the ray through the lens numbers that leads to the point; false where there is none.
bool camera_view(const Camera *camera, Vec3 p, float lens_u, float lens_v, CameraView *out);
// How deep a point of the world lies: along the camera's axis, or (fisheye, panorama) from the
// camera; in metres of the world.
double camera_depth(const Camera *camera, Vec3 p);

#endif
