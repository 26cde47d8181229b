// Cameras: where things come to lie in the picture, the lens, and the checks of the `camera` kind.
#include "../../trust.h"
#include "render/camera.h"

#include "near.h"

#include <stdio.h>
#include <string.h>

extern const NodeType camera_kind;

// --- A stand-in for the evaluator: fields that count as set, and what finish reports -----------

typedef struct Reports {
    int count;
    DiagCode codes[8];
    int params[8];
    Diag diag;
} Reports;

static Diag *report(NodeFinish *self, int param, DiagCode code, const char *format, ...)
{
    (void)format;
    Reports *reports = self->caller;
    assert_true(reports->count < 8);
    reports->codes[reports->count] = code;
    reports->params[reports->count++] = param;
    return &reports->diag;
}

static int field(const char *name)
{
    const int index = node_type_find_param(&camera_kind, str_from(name));
    assert_true(index >= 0);
    return index;
}

// Finishes with the fields named in `set` (separated by blanks) given by the author.
static bool finish(CameraParams *params, const char *set, Reports *reports)
{
    Arena arena = {0};
    DiagSink sink;
    diag_sink_init(&sink, &arena);
    *reports = (Reports){0};
    NodeFinish f = {
        .type = &camera_kind,
        .params = params,
        .report = report,
        .sink = &sink,
        .caller = reports,
    };
    char names[200];
    snprintf(names, sizeof names, "%s", set);
    for (char *name = strtok(names, " "); name; name = strtok(NULL, " ")) {
        f.set |= UINT64_C(1) << field(name);
    }
    const bool ok = camera_kind.finish(&f);
    diag_sink_free(&sink);
    arena_free(&arena);
    return ok;
}

static CameraParams plain(void)
{
    return (CameraParams){
        .position = {0, 0, 5},
        .look_at = {0, 0, 0},
        .up = {0, 1, 0},
        .fov = 40 * PI / 180,
    };
}

static Camera ready(CameraParams params, const char *set, int width, int height)
{
    Reports reports;
    assert_true(finish(&params, set, &reports));
    assert_int_equal(reports.count, 0);
    Camera camera;
    const Affine identity = affine_identity();
    camera_setup(&camera, &params, &identity, width, height);
    return camera;
}

static Ray ray_at(const Camera *camera, double x, double y, float u, float v)
{
    Ray ray;
    assert_true(camera_ray(camera, x, y, u, v, &ray));
    assert_near(length(ray.direction), 1, 1e-12);
    assert_true(ray.tmin == 0 && ray.tmax == INFINITY);
    return ray;
}

static void assert_vec(Vec3 v, double x, double y, double z, double tolerance)
{
    assert_near(v.x, x, tolerance);
    assert_near(v.y, y, tolerance);
    assert_near(v.z, z, tolerance);
}

// --- Projections -------------------------------------------------------------------------------

static void picture_is_upright(void **state)
{
    (void)state;
    const Camera camera = ready(plain(), "position look_at", 200, 100);
    const double t = tan(20 * PI / 180);
    const Ray middle = ray_at(&camera, 0.5, 0.5, 0, 0);
    assert_vec(middle.origin, 0, 0, 5, 1e-12);
    assert_vec(middle.direction, 0, 0, -1, 1e-12);
    // Top left: to the left and up; fov is vertical and pixels are square.
    const Ray corner = ray_at(&camera, 0, 0, 0, 0);
    assert_near(corner.direction.y / -corner.direction.z, t, 1e-12);
    assert_near(corner.direction.x / -corner.direction.z, -2 * t, 1e-12);
    const Ray lower_right = ray_at(&camera, 1, 1, 0, 0);
    assert_near(lower_right.direction.y / -lower_right.direction.z, -t, 1e-12);
    assert_near(lower_right.direction.x / -lower_right.direction.z, 2 * t, 1e-12);
}

// From elsewhere, with another up: +x of the picture is view × up.
static void view_follows_look_at_and_up(void **state)
{
    (void)state;
    CameraParams params = plain();
    params.position = vec3(3, -2, 7);
    params.look_at = vec3(-1, 4, 2);
    params.up = normalize(vec3(1, 1, 0.2));
    const Camera camera = ready(params, "position look_at up", 100, 100);
    const Vec3 view = normalize(sub(params.look_at, params.position));
    const Vec3 right = normalize(cross(view, params.up));
    const Vec3 top = cross(right, view);
    const Vec3 middle = ray_at(&camera, 0.5, 0.5, 0, 0).direction;
    assert_vec(sub(middle, view), 0, 0, 0, 1e-12);
    const Vec3 d = ray_at(&camera, 0.75, 0.25, 0, 0).direction;
    assert_near(dot(d, right) / dot(d, view), tan(params.fov / 2) / 2, 1e-12);
    assert_near(dot(d, top) / dot(d, view), tan(params.fov / 2) / 2, 1e-12);
}

static bool hits_sphere(const Ray *ray, Vec3 center, double radius)
{
    const Vec3 to = sub(center, ray->origin);
    const double along = dot(to, ray->direction);
    return length_squared(to) - along * along < radius * radius;
}

// A sphere on the axis at distance d has an outline of radius r / √(d² - r²) at focal length 1.
static void sphere_projects_to_its_outline(void **state)
{
    (void)state;
    const Camera camera = ready(plain(), "position look_at", 1000, 1000);
    const double r = 0.8, d = 5, want = r / sqrt(d * d - r * r);
    double worst = 0;
    for (int turn = 0; turn < 8; ++turn) {
        const double c = cos(turn * PI / 4), s = sin(turn * PI / 4);
        double inside = 0, outside = 0.5;
        for (int i = 0; i < 60; ++i) {
            const double middle = (inside + outside) / 2;
            const Ray ray = ray_at(&camera, 0.5 + c * middle, 0.5 + s * middle, 0, 0);
            *(hits_sphere(&ray, vec3(0, 0, 0), r) ? &inside : &outside) = middle;
        }
        // 0.5 of the film is tan(fov / 2) at focal length 1.
        worst = fmax(worst, fabs(inside / 0.5 * tan(20 * PI / 180) - want));
    }
    assert_true(trust_at_most("24 outline of a sphere through the camera, off by", 1e-9, worst));
}

// Where on the film a ray from the lens place (u, v) passes through p: the ray's place at p's depth
// is linear in x, so two rays give it.
static double film_x_through(const Camera *camera, Vec3 p, float u, float v)
{
    double at[2];
    for (int i = 0; i < 2; ++i) {
        const Ray ray = ray_at(camera, i, 0.5, u, v);
        const double t = (p.z - ray.origin.z) / ray.direction.z;
        at[i] = ray.origin.x + t * ray.direction.x - p.x;
    }
    return at[0] / (at[0] - at[1]);
}

// Circle of confusion: 50 mm f/2, focused at 2 m, a point at 4 m: A·|d−s|/d·f/(s−f) = .320513 mm on
// the sensor, whose distance from the lens is fs/(s − f).
static void circle_of_confusion(void **state)
{
    (void)state;
    CameraParams params = plain();
    params.f_stop = 2;
    params.focal_length = 0.05;
    params.focus_distance = 2;
    const Camera camera =
        ready(params, "position look_at f_stop focal_length focus_distance", 300, 200);
    const double f = 0.05, s = 2, sensor = f * s / (s - f);
    const double film_width = 2 * tan(params.fov / 2) * 1.5 * sensor;
    const Vec3 far = vec3(0, 0, 5 - 4);
    // The lens numbers (0, .5) and (1, .5) are the lens's left and right edge.
    const double left = film_x_through(&camera, far, 0, 0.5f);
    const double right = film_x_through(&camera, far, 1, 0.5f);
    assert_true(trust_near("25 circle of confusion, mm", 0.320513,
                           1000 * fabs(right - left) * film_width, 1e-6));
    // In the plane of focus all rays of a film place meet.
    const Vec3 sharp = vec3(0.1, 0, 5 - 2);
    assert_near(film_x_through(&camera, sharp, 0, 0.5f), film_x_through(&camera, sharp, 1, 0.5f),
                1e-12);
}

static void lens_is_a_uniform_disc(void **state)
{
    (void)state;
    CameraParams params = plain();
    params.aperture = 0.5;
    const Camera camera = ready(params, "position look_at aperture", 10, 10);
    enum { N = 400 };
    double square = 0, x_sum = 0, y_sum = 0;
    for (int i = 0; i < N; ++i) {
        for (int j = 0; j < N; ++j) {
            const Ray ray =
                ray_at(&camera, 0.3, 0.8, (float)((i + 0.5) / N), (float)((j + 0.5) / N));
            const double r2 = ray.origin.x * ray.origin.x + ray.origin.y * ray.origin.y;
            assert_true(r2 <= 0.25 * (1 + 1e-12));
            assert_near(ray.origin.z, 5, 1e-12);
            square += r2 / ((double)N * N);
            x_sum += ray.origin.x;
            y_sum += ray.origin.y;
            // Focus is on look_at's plane, 5 m away, where the pinhole ray meets it.
            const double t = -ray.origin.z / ray.direction.z;
            const double half = 5 * tan(params.fov / 2);
            assert_near(ray.origin.x + t * ray.direction.x, -0.4 * half, 1e-9);
            assert_near(ray.origin.y + t * ray.direction.y, -0.6 * half, 1e-9);
        }
    }
    assert_near(square, 0.25 / 2, 1e-5); // mean r² of a disc is R²/2
    assert_near(x_sum / (N * N), 0, 1e-9);
    assert_near(y_sum / (N * N), 0, 1e-9);
}

static void orthographic_rays_are_parallel(void **state)
{
    (void)state;
    CameraParams params = plain();
    params.projection = CAMERA_ORTHOGRAPHIC;
    params.height = 2;
    const Camera camera = ready(params, "position look_at projection height", 300, 100);
    const Ray ray = ray_at(&camera, 0, 0, 0, 0);
    assert_vec(ray.direction, 0, 0, -1, 1e-15);
    assert_vec(ray.origin, -3, 1, 5, 1e-12);
    assert_vec(ray_at(&camera, 1, 1, 0, 0).origin, 3, -1, 5, 1e-12);
}

static void fisheye_is_equidistant(void **state)
{
    (void)state;
    CameraParams params = plain();
    params.projection = CAMERA_FISHEYE;
    params.fov = PI;
    const Camera camera = ready(params, "position look_at projection fov", 100, 100);
    assert_vec(ray_at(&camera, 0.5, 0, 0, 0).direction, 0, 1, 0, 1e-12);
    assert_vec(ray_at(&camera, 1, 0.5, 0, 0).direction, 1, 0, 0, 1e-12);
    assert_vec(ray_at(&camera, 0.75, 0.5, 0, 0).direction, sqrt(0.5), 0, -sqrt(0.5), 1e-12);
    assert_vec(ray_at(&camera, 0.5, 0.5, 0, 0).direction, 0, 0, -1, 1e-12);
    params.fov = 2 * PI;
    const Camera all = ready(params, "position look_at projection fov", 100, 100);
    Ray ray;
    assert_vec(ray_at(&all, 0.5, 0, 0, 0).direction, 0, 0, 1, 1e-12);
    assert_false(camera_ray(&all, 0.01, 0.01, 0, 0, &ray)); // beyond 180 degrees off the axis
}

static void panorama_sees_all(void **state)
{
    (void)state;
    CameraParams params = plain();
    params.projection = CAMERA_PANORAMA;
    const Camera camera = ready(params, "position look_at projection", 200, 100);
    assert_vec(ray_at(&camera, 0.5, 0.5, 0, 0).direction, 0, 0, -1, 1e-12);
    assert_vec(ray_at(&camera, 0.75, 0.5, 0, 0).direction, 1, 0, 0, 1e-12);
    assert_vec(ray_at(&camera, 0.25, 0.5, 0, 0).direction, -1, 0, 0, 1e-12);
    assert_vec(ray_at(&camera, 0, 0.5, 0, 0).direction, 0, 0, 1, 1e-12);
    assert_vec(ray_at(&camera, 0.3, 0, 0, 0).direction, 0, 1, 0, 1e-12);
    assert_vec(ray_at(&camera, 0.3, 1, 0, 0).direction, 0, -1, 0, 1e-12);
}

static void node_transform_moves_the_camera(void **state)
{
    (void)state;
    CameraParams params = plain();
    Reports reports;
    assert_true(finish(&params, "position look_at", &reports));
    const Affine turn = affine_rotation(vec3(0, 1, 0), PI / 2);
    const Affine move = affine_translation(vec3(10, 0, 0));
    const Affine both = affine_multiply(&move, &turn);
    Camera camera;
    camera_setup(&camera, &params, &both, 100, 100);
    const Ray ray = ray_at(&camera, 0.5, 0.5, 0, 0);
    assert_vec(ray.origin, 15, 0, 0, 1e-12);
    assert_vec(ray.direction, -1, 0, 0, 1e-12);
    assert_near(camera_depth(&camera, vec3(12, 1, 1)), 3, 1e-12);
}

static void depth_is_along_the_axis(void **state)
{
    (void)state;
    Camera camera = ready(plain(), "position look_at", 100, 100);
    assert_near(camera_depth(&camera, vec3(3, -2, 1)), 4, 1e-12);
    camera.params.projection = CAMERA_PANORAMA;
    assert_near(camera_depth(&camera, vec3(3, 0, 1)), 5, 1e-12);
}

// All corners of the box are in the picture, whatever its shape.
static void default_camera_sees_the_bounds(void **state)
{
    (void)state;
    const Box3 boxes[] = {
        {{-1, -1, -1}, {1, 1, 1}},
        {{100, 200, -300}, {100.5, 290, -299}},
        {{0, 0, 0}, {0, 0, 0}},
        {{-1e6, 0, -1e6}, {1e6, 1, 1e6}},
    };
    const int sizes[][2] = {{960, 540}, {100, 400}, {1, 1}};
    for (size_t b = 0; b < sizeof boxes / sizeof *boxes; ++b) {
        for (size_t s = 0; s < 3; ++s) {
            Camera camera;
            camera_default(&camera, boxes[b], sizes[s][0], sizes[s][1]);
            Affine inverse;
            assert_true(affine_inverse(&camera.to_world, &inverse));
            for (int c = 0; c < 8; ++c) {
                const Vec3 p =
                    transform_point(&inverse, vec3(c & 1 ? boxes[b].max.x : boxes[b].min.x,
                                                   c & 2 ? boxes[b].max.y : boxes[b].min.y,
                                                   c & 4 ? boxes[b].max.z : boxes[b].min.z));
                assert_true(p.z < 0);
                assert_true(fabs(p.x / p.z) <= camera.half_width);
                assert_true(fabs(p.y / p.z) <= camera.half_height);
            }
        }
    }
    Camera camera;
    camera_default(&camera, box3_empty(), 100, 100);
    assert_true(vec3_is_finite(camera.params.position));
    camera_default(&camera, (Box3){{-INFINITY, 0, 0}, {INFINITY, 1, 1}}, 100, 100);
    assert_true(vec3_is_finite(camera.params.position));
}

// --- The kind's checks ---------------------------------------------------------------------

static void assert_fails(CameraParams params, const char *set, DiagCode code, const char *at)
{
    Reports reports;
    assert_false(finish(&params, set, &reports));
    assert_int_equal(reports.count, 1);
    assert_int_equal(reports.codes[0], code);
    assert_int_equal(reports.params[0], at ? field(at) : -1);
}

static void view_must_be_defined(void **state)
{
    (void)state;
    CameraParams params = plain();
    params.direction = vec3(0, 0, -1);
    assert_fails(params, "position", E0920, NULL);
    assert_fails(params, "position look_at direction", E0920, "direction");
    params.look_at = params.position;
    assert_fails(params, "position look_at", E0921, "look_at");
    params.look_at = vec3(0, -10, 5);
    assert_fails(params, "position look_at", E0921, NULL);
    assert_fails(params, "position look_at up", E0921, "up");
    params.direction = vec3(0, 1, 0);
    assert_fails(params, "position direction", E0921, NULL);
}

static void projection_must_fit(void **state)
{
    (void)state;
    CameraParams params = plain();
    params.fov = PI;
    assert_fails(params, "position look_at fov", E0922, "fov");
    params.fov = PI * 0.999;
    ready(params, "position look_at fov", 10, 10);
    params.projection = CAMERA_ORTHOGRAPHIC;
    assert_fails(params, "position look_at projection", E0923, NULL);
}

static void fields_without_effect_are_told(void **state)
{
    (void)state;
    static const struct {
        int32_t projection;
        const char *set, *field;
    } cases[] = {
        {CAMERA_PERSPECTIVE, "position look_at height", "height"},
        {CAMERA_ORTHOGRAPHIC, "position look_at height fov", "fov"},
        {CAMERA_PANORAMA, "position look_at fov", "fov"},
        {CAMERA_FISHEYE, "position look_at aperture", "aperture"},
        {CAMERA_PANORAMA, "position look_at focus_at", "focus_at"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        CameraParams params = plain();
        params.projection = cases[i].projection;
        params.height = 1;
        Reports reports;
        assert_true(finish(&params, cases[i].set, &reports));
        assert_int_equal(reports.count, 1);
        assert_int_equal(reports.codes[0], W0920);
        assert_int_equal(reports.params[0], field(cases[i].field));
        assert_true(params.aperture == 0);
    }
}

static void lens_must_be_defined(void **state)
{
    (void)state;
    CameraParams params = plain();
    params.direction = vec3(0, 0, -1);
    params.aperture = 0.1;
    params.f_stop = 2;
    params.focal_length = 0.05;
    params.focus_distance = 3;
    params.focus_at = vec3(1, 2, 1);
    assert_fails(params, "position look_at aperture f_stop focal_length", E0924, "f_stop");
    assert_fails(params, "position look_at f_stop", E0924, "f_stop");
    assert_fails(params, "position look_at focal_length", E0924, "focal_length");
    assert_fails(params, "position look_at focus_at focus_distance", E0925, "focus_at");
    assert_fails(params, "position direction aperture", E0925, NULL);

    Camera camera = ready(params, "position direction aperture focus_at", 10, 10);
    assert_near(camera.params.focus_distance, 4, 1e-12); // along the axis
    camera = ready(params, "position look_at f_stop focal_length", 10, 10);
    assert_near(camera.params.aperture, 0.0125, 1e-15);
    assert_near(camera.params.focus_distance, 5, 1e-12);
    camera = ready(params, "position direction", 10, 10);
    assert_true(camera.params.aperture == 0);

    params.focus_at = vec3(0, 0, 6);
    assert_fails(params, "position direction aperture focus_at", E0925, "focus_at");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(picture_is_upright),
        cmocka_unit_test(view_follows_look_at_and_up),
        cmocka_unit_test(sphere_projects_to_its_outline),
        cmocka_unit_test(circle_of_confusion),
        cmocka_unit_test(lens_is_a_uniform_disc),
        cmocka_unit_test(orthographic_rays_are_parallel),
        cmocka_unit_test(fisheye_is_equidistant),
        cmocka_unit_test(panorama_sees_all),
        cmocka_unit_test(node_transform_moves_the_camera),
        cmocka_unit_test(depth_is_along_the_axis),
        cmocka_unit_test(default_camera_sees_the_bounds),
        cmocka_unit_test(view_must_be_defined),
        cmocka_unit_test(projection_must_fit),
        cmocka_unit_test(fields_without_effect_are_told),
        cmocka_unit_test(lens_must_be_defined),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
