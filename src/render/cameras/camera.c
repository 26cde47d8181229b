#include "render/camera.h"

#include "base/hot.h"
#include "render/disc.h"

void camera_setup(Camera *camera, const CameraParams *params, const Affine *transform, int width,
                  int height)
{
    camera->params = *params;
    camera->to_world = affine_multiply(transform, &params->frame);
    const double aspect = (double)width / height;
    if (params->projection == CAMERA_ORTHOGRAPHIC) {
        camera->half_height = params->height / 2;
    } else if (params->projection == CAMERA_PERSPECTIVE) {
        camera->half_height = tan(params->fov / 2);
    } else {
        camera->half_height = params->fov / 2; // fisheye: an angle
    }
    camera->half_width = camera->half_height * aspect;
    camera->pinhole = params->projection == CAMERA_PERSPECTIVE && !(params->aperture > 0);
}

void camera_prepare(Camera *camera, const Scene *scene, uint32_t node, int width, int height)
{
    const SceneNode *camera_node = scene_node(scene, CATEGORY_CAMERA, node);
    camera_setup(camera, scene_params(scene, camera_node),
                 &scene->transforms.items[camera_node->transform], width, height);
}

void camera_default(Camera *camera, Box3 bounds, int width, int height)
{
    if (box3_is_empty(bounds) || !vec3_is_finite(sub(bounds.max, bounds.min))) {
        bounds = (Box3){{-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}};
    }
    const Vec3 center = box3_center(bounds);
    const double radius = fmax(length(sub(bounds.max, bounds.min)) / 2, 1e-9);
    const double fov = 40 * PI / 180;
    // The sphere about the box must fit into the narrower of both angles.
    const double aspect = (double)width / height;
    const double half = atan(tan(fov / 2) * fmin(1, aspect));
    const Vec3 from = normalize(vec3(0.5, 0.4, 1));
    CameraParams params = {
        .position = add_scaled(center, from, 1.05 * radius / sin(half)),
        .look_at = center,
        .up = {0, 1, 0},
        .fov = fov,
        .projection = CAMERA_PERSPECTIVE,
    };
    const Affine identity = affine_identity();
    if (!affine_look_at(params.position, center, params.up, &params.frame)) {
        // Bounds so far away that the step from their centre was lost to rounding.
        params.frame = affine_translation(params.position);
    }
    camera_setup(camera, &params, &identity, width, height);
}

uint32_t scene_find_camera(const Scene *scene, Str name)
{
    const SceneNodeArray *cameras = &scene->nodes[CATEGORY_CAMERA];
    for (size_t i = 0; i < cameras->count; ++i) {
        const uint32_t own = cameras->items[i].name;
        if (own != 0 && str_equal(str_from(scene->names.items[own]), name)) {
            return (uint32_t)i;
        }
    }
    return NONE_ID;
}

// Moves the chief ray's start over the lens; the point in the plane of focus stays where it is.
static void through_lens(const CameraParams *params, float u, float v, Vec3 *origin,
                         Vec3 *direction)
{
    const Vec2 on_lens = sample_disc(u, v);
    const Vec3 shift = vec3(params->aperture * on_lens.x, params->aperture * on_lens.y, 0);
    // direction.z = -1: the plane of focus is focus_distance directions away.
    *direction = sub(scale(*direction, params->focus_distance), shift);
    *origin = add(*origin, shift);
}

// In the camera's own frame; *direction of any length.
static bool local_ray(const Camera *camera, double x, double y, float lens_u, float lens_v,
                      Vec3 *origin, Vec3 *direction)
{
    const double right = (2 * x - 1) * camera->half_width, top = (1 - 2 * y) * camera->half_height;
    *origin = vec3(0, 0, 0);
    switch (camera->params.projection) {
    case CAMERA_ORTHOGRAPHIC:
        *origin = vec3(right, top, 0);
        *direction = vec3(0, 0, -1);
        break;
    case CAMERA_FISHEYE: {
        const double angle = sqrt(right * right + top * top);
        const double k = angle > 0 ? sin(angle) / angle : 1;
        *direction = vec3(right * k, top * k, -cos(angle));
        return angle <= PI;
    }
    case CAMERA_PANORAMA: {
        const double longitude = (2 * x - 1) * PI, latitude = (0.5 - y) * PI;
        *direction =
            vec3(sin(longitude) * cos(latitude), sin(latitude), -cos(longitude) * cos(latitude));
        return true;
    }
    default:
        *direction = vec3(right, top, -1);
    }
    if (camera->params.aperture > 0) {
        through_lens(&camera->params, lens_u, lens_v, origin, direction);
    }
    return true;
}

APART static bool other_ray(const Camera *camera, double x, double y, float lens_u, float lens_v,
                            Ray *ray)
{
    Vec3 origin, direction;
    if (!local_ray(camera, x, y, lens_u, lens_v, &origin, &direction)) {
        return false;
    }
    ray->origin = transform_point(&camera->to_world, origin);
    ray->direction = normalize(transform_vector(&camera->to_world, direction));
    return true;
}

// What local_ray's default is, moved to the world.
static inline void pinhole_ray(const Camera *camera, double x, double y, Ray *ray)
{
    const Affine *a = &camera->to_world;
    const double right = (2 * x - 1) * camera->half_width, top = (1 - 2 * y) * camera->half_height;
    ray->origin = vec3(a->m[0][3], a->m[1][3], a->m[2][3]);
    ray->direction = normalize(vec3(a->m[0][0] * right + a->m[0][1] * top - a->m[0][2],
                                    a->m[1][0] * right + a->m[1][1] * top - a->m[1][2],
                                    a->m[2][0] * right + a->m[2][1] * top - a->m[2][2]));
}

HOT bool camera_ray(const Camera *camera, double x, double y, float lens_u, float lens_v, Ray *ray)
{
    ray->tmin = 0;
    ray->tmax = INFINITY;
    memset(&ray->ends, 0, sizeof ray->ends); // of all at once, it would be one slow instruction
    if (!camera->pinhole) {
        return other_ray(camera, x, y, lens_u, lens_v, ray);
    }
    pinhole_ray(camera, x, y, ray);
    return true;
}

// Where a point of the camera's own frame is seen; *blur: how far from there by way of the lens's
// rim. Both as local_ray's right and top.
static bool local_film_place(const CameraParams *params, Vec3 p, Vec2 *place, double *blur)
{
    const double depth = -p.z, focus = params->focus_distance;
    if (!(depth > 0) || !vec3_is_finite(p)) {
        return false;
    }
    // The inverse of through_lens: p = shift + (direction focus - shift) depth / focus.
    if (params->projection == CAMERA_ORTHOGRAPHIC) {
        *place = (Vec2){p.x, p.y};
        *blur = params->aperture > 0 ? params->aperture * fabs(1 - depth / focus) : 0;
    } else {
        *place = (Vec2){p.x / depth, p.y / depth};
        *blur = params->aperture > 0 ? params->aperture * fabs(1 / depth - 1 / focus) : 0;
    }
    return true;
}

bool camera_film_box(const Camera *camera, Box3 bounds, FilmBox *out)
{
    const CameraParams *params = &camera->params;
    const bool flat =
        params->projection == CAMERA_PERSPECTIVE || params->projection == CAMERA_ORTHOGRAPHIC;
    Affine to_camera;
    if (!flat || box3_is_empty(bounds) || !affine_inverse(&camera->to_world, &to_camera)) {
        return false;
    }
    *out = (FilmBox){INFINITY, INFINITY, -INFINITY, -INFINITY};
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p = box3_corner(bounds, corner);
        Vec2 place;
        double blur;
        if (!local_film_place(params, transform_point(&to_camera, p), &place, &blur)) {
            return false;
        }
        out->x0 = fmin(out->x0, ((place.x - blur) / camera->half_width + 1) / 2);
        out->x1 = fmax(out->x1, ((place.x + blur) / camera->half_width + 1) / 2);
        out->y0 = fmin(out->y0, (1 - (place.y + blur) / camera->half_height) / 2);
        out->y1 = fmax(out->y1, (1 - (place.y - blur) / camera->half_height) / 2);
    }
    return true;
}

// The film's coordinates (right, top) of the ray that leads to q, in the camera's own frame,
// through the point `lens` of the lens; where it begins; how much of film coordinates there is, at
// q, over the area of a surface there times the cosine times the length of `speed`, along which the
// ray goes.
typedef struct LocalView {
    double right, top, per_area;
    Vec3 from, speed;
} LocalView;

static bool view_flat(const Camera *camera, Vec3 q, Vec3 lens, LocalView *out)
{
    const double depth = -q.z, focus = camera->params.focus_distance;
    if (!(depth > 0)) {
        return false;
    }
    if (camera->params.projection == CAMERA_ORTHOGRAPHIC) {
        // The ray (right, top, 0) + lens + t ((0, 0, -focus) - lens), t = depth / focus.
        const bool blurs = camera->params.aperture > 0;
        out->speed = blurs ? scale(sub(vec3(0, 0, -focus), lens), 1 / focus) : vec3(0, 0, -1);
        out->from = add_scaled(q, out->speed, -depth);
        out->from.z = 0;
        out->right = out->from.x - lens.x;
        out->top = out->from.y - lens.y;
        out->per_area = 1;
        return true;
    }
    out->from = lens;
    out->speed = sub(q, lens);
    out->right = out->speed.x / depth + (lens.x != 0 ? lens.x / focus : 0);
    out->top = out->speed.y / depth + (lens.y != 0 ? lens.y / focus : 0);
    out->per_area = 1 / (depth * depth * depth);
    return true;
}

static bool view_round(const Camera *camera, Vec3 q, LocalView *out)
{
    const double r = length(q), flat = sqrt(q.x * q.x + q.y * q.y);
    if (!(r > 0)) {
        return false;
    }
    out->from = vec3(0, 0, 0);
    out->speed = q;
    out->per_area = 1 / (r * r * r);
    if (camera->params.projection == CAMERA_FISHEYE) {
        const double angle = atan2(flat, -q.z), k = flat > 0 ? angle / flat : 0;
        out->right = q.x * k;
        out->top = q.y * k;
        out->per_area *= flat > 0 ? k * r : 1; // θ / sin θ
        return true;
    }
    // A panorama's half sizes aren't asked for: its film is all longitudes and latitudes.
    const double across = sqrt(q.x * q.x + q.z * q.z);
    out->right = atan2(q.x, -q.z) / PI * camera->half_width;
    out->top = atan2(q.y, across) / (PI / 2) * camera->half_height;
    out->per_area *= r / across * 2 / (PI * PI) * camera->half_width * camera->half_height;
    return across > 0;
}

bool camera_view(const Camera *camera, Vec3 p, float lens_u, float lens_v, CameraView *out)
{
    const CameraParams *params = &camera->params;
    Affine to_camera;
    if (!affine_inverse(&camera->to_world, &to_camera)) {
        return false;
    }
    const Vec3 q = transform_point(&to_camera, p);
    Vec3 lens = vec3(0, 0, 0);
    if (params->aperture > 0) {
        const Vec2 on_lens = sample_disc(lens_u, lens_v);
        lens = vec3(params->aperture * on_lens.x, params->aperture * on_lens.y, 0);
    }
    LocalView local;
    const bool round =
        params->projection == CAMERA_FISHEYE || params->projection == CAMERA_PANORAMA;
    if (!(round ? view_round(camera, q, &local) : view_flat(camera, q, lens, &local))) {
        return false;
    }
    // An area vector n dA becomes det(M^-1) M^T n dA, so that its product with the local speed is
    // det(M^-1) n · M speed dA.
    const double determinant = fabs(affine_determinant(&to_camera));
    const Vec3 speed = transform_vector(&camera->to_world, local.speed);
    const double pace = length(speed);
    out->x = (local.right / camera->half_width + 1) / 2;
    out->y = (1 - local.top / camera->half_height) / 2;
    out->from = transform_point(&camera->to_world, local.from);
    const Vec3 way = sub(out->from, p);
    out->distance = length(way);
    out->direction = scale(speed, -1 / pace);
    out->film_area =
        determinant * pace * local.per_area / (4 * camera->half_width * camera->half_height);
    return out->distance > 0 && out->film_area > 0 && out->film_area < INFINITY;
}

double camera_depth(const Camera *camera, Vec3 p)
{
    const Affine *a = &camera->to_world;
    const Vec3 d = sub(p, vec3(a->m[0][3], a->m[1][3], a->m[2][3]));
    if (camera->params.projection == CAMERA_FISHEYE ||
        camera->params.projection == CAMERA_PANORAMA) {
        return length(d);
    }
    // The axis is normal to the film's plane, also where the transform isn't rigid.
    const Vec3 right = vec3(a->m[0][0], a->m[1][0], a->m[2][0]);
    const Vec3 top = vec3(a->m[0][1], a->m[1][1], a->m[2][1]);
    const Vec3 back = vec3(a->m[0][2], a->m[1][2], a->m[2][2]);
    const Vec3 normal = normalize(cross(right, top));
    return dot(normal, back) > 0 ? -dot(d, normal) : dot(d, normal);
}
