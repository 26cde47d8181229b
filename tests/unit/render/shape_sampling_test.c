// Points chosen on shapes: areas against integrals, uniformity by chi-squared, solid angles against
// closed forms, and view factors.
#include "../../trust.h"
#include "shapes.h"

// --- Shapes as patches -----------------------------------------------------------------------

// A shape as patches over the unit square, in its own space: where a parameter pair lies, and back.
typedef struct Patches {
    const char *name;
    Params params;
    int count;
    Vec3 (*at)(const struct Patches *patches, int patch, double u, double v);
    int (*locate)(const struct Patches *patches, Vec3 p, double *u, double *v); // the patch
    Frame frame;                                                                // n the axis
    Vec3 o, eu, ev;
    double r0, r1, h;
} Patches;

static double turn_of(double x, double y)
{
    double a = atan2(y, x) / (2 * PI);
    return a < 0 ? a + 1 : a;
}
static Vec3 in_frame(const Patches *s, double x, double y, double z)
{
    return add(s->o, from_local(&s->frame, vec3(x, y, z)));
}
static Vec3 own(const Patches *s, Vec3 p)
{
    return to_local(&s->frame, sub(p, s->o));
}

static Vec3 sphere_at(const Patches *s, int patch, double u, double v)
{
    (void)patch;
    double polar = PI * v;
    return in_frame(s, s->r0 * sin(polar) * cos(2 * PI * u), s->r0 * sin(polar) * sin(2 * PI * u),
                    s->r0 * cos(polar));
}
static int sphere_locate(const Patches *s, Vec3 p, double *u, double *v)
{
    Vec3 q = own(s, p);
    *u = turn_of(q.x, q.y);
    *v = acos(fmin(fmax(q.z / s->r0, -1), 1)) / PI;
    return 0;
}
static Vec3 flat_at(const Patches *s, int patch, double u, double v)
{
    (void)patch;
    return add(s->o, add(scale(s->eu, u), scale(s->ev, v)));
}
static int flat_locate(const Patches *s, Vec3 p, double *u, double *v)
{
    Vec3 f = sub(p, s->o);
    double a = dot(s->eu, s->eu), b = dot(s->eu, s->ev), c = dot(s->ev, s->ev);
    double x = dot(f, s->eu), y = dot(f, s->ev), det = a * c - b * b;
    *u = (x * c - y * b) / det;
    *v = (y * a - x * b) / det;
    return 0;
}
// A triangle as a square with one side drawn together: (u, v) -> ((1 - v) u, v).
static Vec3 triangle_at(const Patches *s, int patch, double u, double v)
{
    return flat_at(s, patch, (1 - v) * u, v);
}
static int triangle_locate(const Patches *s, Vec3 p, double *u, double *v)
{
    flat_locate(s, p, u, v);
    *u /= fmax(1 - *v, 1e-12);
    return 0;
}
static Vec3 ring_at(const Patches *s, int patch, double u, double v)
{
    (void)patch;
    double r = s->r1 + (s->r0 - s->r1) * v;
    return in_frame(s, r * cos(2 * PI * u), r * sin(2 * PI * u), 0);
}
static int ring_locate(const Patches *s, Vec3 p, double *u, double *v)
{
    Vec3 q = own(s, p);
    *u = turn_of(q.x, q.y);
    *v = (sqrt(q.x * q.x + q.y * q.y) - s->r1) / (s->r0 - s->r1);
    return 0;
}
static Vec3 frustum_at(const Patches *s, int patch, double u, double v)
{
    double r = patch == 0 ? s->r0 + (s->r1 - s->r0) * v : (patch == 1 ? s->r0 : s->r1) * v;
    double z = patch == 0 ? s->h * v : patch == 1 ? 0 : s->h;
    return in_frame(s, r * cos(2 * PI * u), r * sin(2 * PI * u), z);
}
static int frustum_locate(const Patches *s, Vec3 p, double *u, double *v)
{
    Vec3 q = own(s, p);
    double r = sqrt(q.x * q.x + q.y * q.y), side = s->r0 + (s->r1 - s->r0) * q.z / s->h;
    *u = turn_of(q.x, q.y);
    if (fabs(r - side) < 1e-9) {
        *v = q.z / s->h;
        return 0;
    }
    int cap = q.z < s->h / 2 ? 1 : 2;
    *v = r / (cap == 1 ? s->r0 : s->r1);
    return cap;
}
static Vec3 torus_at(const Patches *s, int patch, double u, double v)
{
    (void)patch;
    double ring = s->r0 + s->r1 * cos(2 * PI * v);
    return in_frame(s, ring * cos(2 * PI * u), ring * sin(2 * PI * u), s->r1 * sin(2 * PI * v));
}
static int torus_locate(const Patches *s, Vec3 p, double *u, double *v)
{
    Vec3 q = own(s, p);
    *u = turn_of(q.x, q.y);
    *v = turn_of(sqrt(q.x * q.x + q.y * q.y) - s->r0, q.z);
    return 0;
}
// Faces -x +x -y +y -z +z of the box o, o + (eu.x, eu.y, eu.z).
static Vec3 box_at(const Patches *s, int patch, double u, double v)
{
    double c[3];
    c[patch / 2] = patch % 2;
    c[(patch / 2 + 1) % 3] = u;
    c[(patch / 2 + 2) % 3] = v;
    return add(s->o, vec3(c[0] * s->eu.x, c[1] * s->eu.y, c[2] * s->eu.z));
}
static int box_locate(const Patches *s, Vec3 p, double *u, double *v)
{
    Vec3 f = sub(p, s->o);
    double c[3] = {f.x / s->eu.x, f.y / s->eu.y, f.z / s->eu.z};
    for (int patch = 0; patch < 6; ++patch) {
        if (fabs(c[patch / 2] - patch % 2) < 1e-9) {
            *u = c[(patch / 2 + 1) % 3];
            *v = c[(patch / 2 + 2) % 3];
            return patch;
        }
    }
    fail_msg("a point beside the box");
    return 0;
}

static int make_patches(Patches *out)
{
    int n = 0;
    Vec3 o = vec3(0.3, -0.2, 0.5), axis = vec3(0.4, 1.1, -0.7);
    Frame frame = frame_from_normal(normalize(axis));
    Vec3 eu = vec3(1, 0.3, -0.2), ev = vec3(-0.3, 0.8, 0.5), to = add(o, axis);
    double h = length(axis);
    out[n++] = (Patches){.name = "sphere",
                         .params = sphere_params_of(o, 0.8),
                         .count = 1,
                         .at = sphere_at,
                         .locate = sphere_locate,
                         .frame = frame,
                         .o = o,
                         .r0 = 0.8};
    out[n++] = (Patches){.name = "rectangle",
                         .params = rectangle_params_of(o, eu, ev),
                         .count = 1,
                         .at = flat_at,
                         .locate = flat_locate,
                         .o = o,
                         .eu = eu,
                         .ev = ev};
    out[n++] = (Patches){.name = "triangle",
                         .params = triangle_params_of(o, add(o, eu), add(o, ev)),
                         .count = 1,
                         .at = triangle_at,
                         .locate = triangle_locate,
                         .o = o,
                         .eu = eu,
                         .ev = ev};
    out[n++] = (Patches){.name = "disc",
                         .params = disc_params_of(o, axis, 0.9, 0),
                         .count = 1,
                         .at = ring_at,
                         .locate = ring_locate,
                         .frame = frame,
                         .o = o,
                         .r0 = 0.9};
    out[n++] = (Patches){.name = "ring",
                         .params = disc_params_of(o, axis, 0.9, 0.4),
                         .count = 1,
                         .at = ring_at,
                         .locate = ring_locate,
                         .frame = frame,
                         .o = o,
                         .r0 = 0.9,
                         .r1 = 0.4};
    out[n++] = (Patches){.name = "box",
                         .params = box_params_of(o, add(o, vec3(1, 0.4, 0.7))),
                         .count = 6,
                         .at = box_at,
                         .locate = box_locate,
                         .o = o,
                         .eu = vec3(1, 0.4, 0.7)};
    const double radii[5][3] = {
        {0.4, 0.4, 1}, {0.4, 0.4, 0}, {0.7, 0.2, 1}, {0, 0.6, 1}, {0.6, 0, 0}};
    const char *names[5] = {"cylinder", "tube", "cone", "cone from a tip", "open cone"};
    for (int i = 0; i < 5; ++i) {
        bool caps = radii[i][2] > 0;
        out[n++] =
            (Patches){.name = names[i],
                      .params = i < 2 ? cylinder_params_of(o, to, radii[i][0], caps)
                                      : cone_params_of(o, to, radii[i][0], radii[i][1], caps),
                      .count = caps ? 3 : 1,
                      .at = frustum_at,
                      .locate = frustum_locate,
                      .frame = frame,
                      .o = o,
                      .r0 = radii[i][0],
                      .r1 = radii[i][1],
                      .h = h};
    }
    out[n++] = (Patches){.name = "torus",
                         .params = torus_params_of(o, axis, 0.9, 0.35),
                         .count = 1,
                         .at = torus_at,
                         .locate = torus_locate,
                         .frame = frame,
                         .o = o,
                         .r0 = 0.9,
                         .r1 = 0.35};
    return n;
}

// The world's area of a part of a patch, by `steps` squared small quadrilaterals' area vectors.
static double cell_area(const Patches *s, int patch, const Affine *to, double u0, double u1,
                        double v0, double v1, int steps)
{
    double sum = 0, du = (u1 - u0) / steps, dv = (v1 - v0) / steps;
    for (int i = 0; i < steps; ++i) {
        for (int j = 0; j < steps; ++j) {
            double u = u0 + i * du, v = v0 + j * dv;
            Vec3 a = transform_point(to, s->at(s, patch, u, v));
            Vec3 b = transform_point(to, s->at(s, patch, u + du, v));
            Vec3 c = transform_point(to, s->at(s, patch, u + du, v + dv));
            Vec3 d = transform_point(to, s->at(s, patch, u, v + dv));
            sum += length(cross(sub(c, a), sub(d, b))) / 2;
        }
    }
    return sum;
}

// With the error of the second order taken out (Richardson).
static double patches_area(const Patches *s, const Affine *to)
{
    double sum = 0;
    for (int patch = 0; patch < s->count; ++patch) {
        double coarse = cell_area(s, patch, to, 0, 1, 0, 1, 200);
        double fine = cell_area(s, patch, to, 0, 1, 0, 1, 400);
        sum += fine + (fine - coarse) / 3;
    }
    return sum;
}

static void areas_are_integrals(void **state)
{
    (void)state;
    Random r = random_make("areas", 51);
    Patches patches[16];
    int count = make_patches(patches);
    for (int k = 0; k < count; ++k) {
        const Patches *s = &patches[k];
        for (int i = 0; i < 4; ++i) {
            Affine to = i ? random_affine(&r, 3) : affine_identity();
            double area = class_of(&s->params)->area(NULL, s->params.bytes, &to);
            double wanted = patches_area(s, &to);
            assert_near(area / wanted, 1, 1e-6);
        }
    }
}

static double sphere_area_of(double a, double b, double c)
{
    Params unit = sphere_params_of(vec3(0, 0, 0), 1);
    Affine to = affine_scaling(vec3(a, b, c));
    return class_of(&unit)->area(NULL, unit.bytes, &to);
}

static void areas_are_those_of_books(void **state)
{
    (void)state;
    assert_near(sphere_area_of(2, 2, 2), 16 * PI, 1e-12);
    double e = sqrt(0.75); // oblate and prolate spheroids, half axes 2 and 1
    assert_near(sphere_area_of(2, 1, 2), 8 * PI * (1 + 0.25 / e * atanh(e)), 1e-11);
    assert_near(sphere_area_of(1, 2, 1), 2 * PI * (1 + 2 / e * asin(e)), 1e-11);
    assert_near(sphere_area_of(1, 1e-9, 1), 2 * PI, 1e-6);                    // a disc, both sides
    assert_near(sphere_area_of(1e-9, 1e3, 1e-9) / (PI * PI * 1e-6), 1, 1e-6); // a needle
    assert_near(sphere_area_of(1e-6, 1e-6, 1e-6), 4e-12 * PI, 1e-24);
    assert_near(carlson_rg(0, 16, 16), PI, 1e-14); // DLMF 19.20
    assert_near(carlson_rg(2, 3, 4), 1.7255030280692, 1e-12);
    assert_near(carlson_rg(0, 0.0796, 4), 1.0284758090288, 1e-12);
    Params torus = torus_params_of(vec3(1, 2, 3), vec3(1, 1, 0), 3, 0.5);
    Affine identity = affine_identity();
    assert_near(class_of(&torus)->area(NULL, torus.bytes, &identity), 6 * PI * PI, 1e-12);
    Params cone = cone_params_of(vec3(0, 0, 0), vec3(0, 4, 0), 3, 0, true);
    assert_near(class_of(&cone)->area(NULL, cone.bytes, &identity), 24 * PI, 1e-12);
}

// --- Chi-squared ------------------------------------------------------------------------------

// The normal quantile that a chi-squared value corresponds to (Wilson, Hilferty 1931).
static double chi_squared_z(double value, int degrees)
{
    double k = 2.0 / (9.0 * degrees);
    return (cbrt(value / degrees) - (1 - k)) / sqrt(k);
}

typedef struct Histogram {
    double *expected; // of all, summing to 1
    int *observed;
    int cells, samples;
} Histogram;

static Histogram histogram_make(int cells)
{
    Histogram h = {calloc((size_t)cells, sizeof(double)), calloc((size_t)cells, sizeof(int)), cells,
                   0};
    assert_true(h.expected && h.observed);
    return h;
}
// Cells with fewer than five expected are pooled. One in 1e4 histograms of good samples fails.
static void histogram_check(Histogram *h, const char *what)
{
    double value = 0, pooled = 0, total = 0;
    int pooled_observed = 0, degrees = -1;
    for (int i = 0; i < h->cells; ++i) {
        total += h->expected[i];
    }
    for (int i = 0; i < h->cells; ++i) {
        double expected = h->expected[i] / total * h->samples;
        if (expected < 5) {
            pooled += expected;
            pooled_observed += h->observed[i];
            continue;
        }
        value += (h->observed[i] - expected) * (h->observed[i] - expected) / expected;
        ++degrees;
    }
    if (pooled >= 5) {
        value += (pooled_observed - pooled) * (pooled_observed - pooled) / pooled;
        ++degrees;
    } else {
        assert_true(pooled_observed < 30);
    }
    double z = chi_squared_z(value, degrees);
    if (!(z < 3.9 && degrees > 10)) {
        fail_msg("%s: chi-squared %g with %d degrees, z = %g", what, value, degrees, z);
    }
    free(h->expected);
    free(h->observed);
}

enum { BINS = 16 };

static int bin_of(double u)
{
    int i = (int)(u * BINS);
    return i < 0 ? 0 : i >= BINS ? BINS - 1 : i;
}

// Uniform by area under similarities and under general transforms; the same without the table.
static void points_are_uniform_by_area(void **state)
{
    (void)state;
    Random r = random_make("uniform", 52);
    Patches patches[16];
    int count = make_patches(patches);
    for (int k = 0; k < count; ++k) {
        const Patches *s = &patches[k];
        const ShapeClass *class = class_of(&s->params);
        for (int round = 0; round < 3; ++round) {
            Affine to = affine_scaling(vec3(1.5, 1.5, 1.5));
            if (round) {
                to = random_affine(&r, 3);
            }
            Affine back;
            assert_true(affine_inverse(&to, &back));
            Arena arena = {0};
            void *table = class->prepare_sampling
                              ? class->prepare_sampling(NULL, s->params.bytes, &to, &arena)
                              : NULL;
            Histogram h = histogram_make(s->count * BINS * BINS);
            for (int c = 0; c < h.cells; ++c) {
                int i = c / BINS % BINS, j = c % BINS;
                h.expected[c] =
                    cell_area(s, c / BINS / BINS, &to, (double)i / BINS, (double)(i + 1) / BINS,
                              (double)j / BINS, (double)(j + 1) / BINS, 12);
            }
            h.samples = 100000;
            double area = class->area(NULL, s->params.bytes, &to);
            for (int n = 0; n < h.samples; ++n) {
                ShapeSample sample;
                double u0 = uniform(&r), u1 = uniform(&r), u2 = uniform(&r), u, v;
                class->sample_area(NULL, s->params.bytes, &to, table, u0, u1, u2, &sample);
                assert_near(sample.pdf * area, 1, 1e-9);
                Vec3 p = transform_point(&back, sample.point.p);
                int patch = s->locate(s, p, &u, &v);
                ++h.observed[(patch * BINS + bin_of(u)) * BINS + bin_of(v)];
                if (n < 20) {
                    ShapeSample same;
                    class->sample_area(NULL, s->params.bytes, &to, NULL, u0, u1, u2, &same);
                    assert_true(length(sub(same.point.p, sample.point.p)) < 1e-12);
                    assert_near(same.pdf / sample.pdf, 1, 1e-12);
                }
            }
            histogram_check(&h, s->name);
            arena_free(&arena);
        }
    }
}

// A sampled point is the same as the one that a ray finds there.
static void sampled_points_are_those_of_rays(void **state)
{
    (void)state;
    Random r = random_make("sampled", 53);
    Patches patches[16];
    int count = make_patches(patches);
    for (int k = 0; k < count; ++k) {
        const Patches *s = &patches[k];
        const ShapeClass *class = class_of(&s->params);
        Affine to = random_affine(&r, 3), back;
        if (k % 2) {
            Affine mirror = affine_scaling(vec3(1, -1, 1));
            to = affine_multiply(&to, &mirror);
        }
        assert_true(affine_inverse(&to, &back));
        int compared = 0;
        Arena arena = {0};
        void *table = class->prepare_sampling
                          ? class->prepare_sampling(NULL, s->params.bytes, &to, &arena)
                          : NULL;
        for (int n = 0; n < 2000; ++n) {
            ShapeSample sample;
            class->sample_area(NULL, s->params.bytes, &to, table, uniform(&r), uniform(&r),
                               uniform(&r), &sample);
            const ShapePoint *p = &sample.point;
            assert_true(p->error > 0 && p->error < 1e-12);
            Vec3 from = add_scaled(p->p, p->geometric, 1e-3);
            Ray ray = ray_make(transform_point(&back, from),
                               transform_vector(&back, neg(p->geometric)), 0, 1);
            ShapeHit hit;
            ShapePoint q;
            if (!class->intersect(s->params.bytes, &ray, &hit)) {
                continue; // at an edge
            }
            class->point(NULL, s->params.bytes, &ray, &hit, &q);
            shape_point_map(&to, &q);
            if (hit.primitive != sample.primitive || length(sub(q.p, p->p)) > 1e-8) {
                continue; // another part of the shape in front of it
            }
            assert_true(length(sub(q.geometric, p->geometric)) < 1e-6);
            assert_true(length(sub(q.shading, p->shading)) < 1e-6);
            if (length(p->tangent) > 0.05) {
                assert_true(length(sub(q.tangent, p->tangent)) < 1e-5);
                assert_true(length(sub(q.bitangent, p->bitangent)) < 1e-5);
            }
            assert_near(fmod(q.uv.x - p->uv.x + 1.5, 1), 0.5, 1e-5);
            assert_near(q.uv.y, p->uv.y, 1e-6);
            assert_near(dot(p->geometric, p->tangent) / length(p->tangent), 0, 1e-9);
            ++compared;
        }
        assert_true(compared > 1800);
        arena_free(&arena);
    }
}

// --- Meshes -----------------------------------------------------------------------------------

static void mesh_triangles_are_chosen_by_area(void **state)
{
    (void)state;
    Random r = random_make("mesh", 54);
    Scene *scene = calloc(1, sizeof *scene);
    assert_true(scene && scene_init(scene, render_schema(), NULL));
    Params p = bumpy_mesh(scene, vec3(1, 2, 3), 2, 8);
    const Mesh *mesh = &scene->meshes.items[0];
    const ShapeClass *class = class_of(&p);
    Affine to = random_affine(&r, 3);
    Arena arena = {0};
    void *table = class->prepare_sampling(scene, p.bytes, &to, &arena);
    assert_non_null(table);
    Histogram h = histogram_make((int)mesh->triangle_count * 4);
    double total = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; ++i) {
        Vec3 c[3];
        for (uint32_t k = 0; k < 3; ++k) {
            const float *f = mesh->positions + 3 * (size_t)mesh->triangles[3 * i + k];
            c[k] = add(mesh->origin, vec3((double)f[0], (double)f[1], (double)f[2]));
            c[k] = transform_point(&to, c[k]);
        }
        double area = length(cross(sub(c[1], c[0]), sub(c[2], c[0]))) / 2;
        total += area;
        for (int quarter = 0; quarter < 4; ++quarter) {
            h.expected[4 * i + (uint32_t)quarter] = area / 4;
        }
    }
    assert_near(class->area(scene, p.bytes, &to) / total, 1, 1e-12);
    h.samples = 200000;
    for (int n = 0; n < h.samples; ++n) {
        ShapeSample s;
        class->sample_area(scene, p.bytes, &to, table, uniform(&r), uniform(&r), uniform(&r), &s);
        assert_near(s.pdf * total, 1, 1e-12);
        // The quarter of the triangle: each corner's, or the middle one.
        double u = s.point.uv.x, v = s.point.uv.y;
        int quarter = u > 0.5 ? 1 : v > 0.5 ? 2 : u + v < 0.5 ? 0 : 3;
        ++h.observed[4 * s.primitive + (uint32_t)quarter];
    }
    histogram_check(&h, "mesh");
    arena_free(&arena);
    scene_free(scene);
    free(scene);
}

// --- Solid angles -----------------------------------------------------------------------------

typedef long double Real;

// Van Oosterom, Strackee 1983.
static Real triangle_solid_angle(Vec3 o, Vec3 a, Vec3 b, Vec3 c)
{
    Real m[3][3] = {{(Real)a.x - o.x, (Real)a.y - o.y, (Real)a.z - o.z},
                    {(Real)b.x - o.x, (Real)b.y - o.y, (Real)b.z - o.z},
                    {(Real)c.x - o.x, (Real)c.y - o.y, (Real)c.z - o.z}};
    Real l[3], d[3];
    for (int i = 0; i < 3; ++i) {
        int j = (i + 1) % 3;
        l[i] = sqrtl(m[i][0] * m[i][0] + m[i][1] * m[i][1] + m[i][2] * m[i][2]);
        d[i] = m[i][0] * m[j][0] + m[i][1] * m[j][1] + m[i][2] * m[j][2];
    }
    Real volume = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                  m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                  m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    return 2 * atan2l(fabsl(volume), l[0] * l[1] * l[2] + d[0] * l[2] + d[1] * l[0] + d[2] * l[1]);
}

static Real solid_angle_of(const Patches *s, const Affine *to, Vec3 reference)
{
    if (s->r0 > 0) { // the sphere
        double factor;
        assert_true(affine_is_similarity(to, &factor));
        Vec3 c = sub(transform_point(to, s->o), reference);
        Real d2 = (Real)c.x * c.x + (Real)c.y * c.y + (Real)c.z * c.z;
        Real sine2 = (Real)s->r0 * s->r0 * factor * factor / d2;
        return 2 * (Real)PI * sine2 / (1 + sqrtl(1 - sine2));
    }
    Vec3 a = transform_point(to, s->o), b = transform_point(to, add(s->o, s->eu));
    Vec3 c = transform_point(to, add(s->o, s->ev));
    Real first = triangle_solid_angle(reference, a, b, c);
    return s->at == flat_at ? first + triangle_solid_angle(reference, b, c, sub(add(b, c), a))
                            : first;
}

static int make_seen(Patches *out)
{
    Vec3 o = vec3(0.3, -0.2, 0.5), eu = vec3(1, 0.3, -0.2), ev = cross(eu, vec3(0.2, 0.5, 0.4));
    out[0] = (Patches){.name = "sphere",
                       .params = sphere_params_of(o, 0.8),
                       .count = 1,
                       .at = sphere_at,
                       .locate = sphere_locate,
                       .frame = frame_from_normal(vec3(0, 1, 0)),
                       .o = o,
                       .r0 = 0.8};
    out[1] = (Patches){.name = "rectangle",
                       .params = rectangle_params_of(o, eu, ev),
                       .count = 1,
                       .at = flat_at,
                       .locate = flat_locate,
                       .o = o,
                       .eu = eu,
                       .ev = ev};
    out[2] = (Patches){.name = "triangle",
                       .params = triangle_params_of(o, add(o, eu), add(o, ev)),
                       .count = 1,
                       .at = triangle_at,
                       .locate = triangle_locate,
                       .o = o,
                       .eu = eu,
                       .ev = ev};
    return 3;
}

static Affine random_similarity(Random *r)
{
    double s = exp(between(r, -2, 2));
    Affine a = random_rotation(r), b = affine_scaling(vec3(s, s, s));
    Affine c = affine_translation(scale(random_direction(r), 3));
    a = affine_multiply(&b, &a);
    return affine_multiply(&c, &a);
}

// pdf = 1 / solid angle, thus of integral 1; the point sampled is what the ray to it hits first.
static void solid_angle_densities_are_one_over_it(void **state)
{
    (void)state;
    Random r = random_make("solid angle", 55);
    Patches patches[3];
    int count = make_seen(patches);
    for (int k = 0; k < count; ++k) {
        const Patches *s = &patches[k];
        const ShapeClass *class = class_of(&s->params);
        int seen = 0;
        for (int n = 0; n < 20000; ++n) {
            Affine to = random_similarity(&r), back;
            if (k == 2 && n % 2) {
                to = random_affine(&r, 2);
            }
            assert_true(affine_inverse(&to, &back));
            // From close by to a million times the shape's size.
            double away = pow(10, between(&r, -3, 6));
            Vec3 near = s->at(s, 0, uniform(&r), uniform(&r));
            Vec3 reference = transform_point(&to, add_scaled(near, random_direction(&r), away));
            ShapeSample sample;
            bool found = class->sample_solid_angle(s->params.bytes, &to, NULL, reference,
                                                   uniform(&r), uniform(&r), &sample);
            Vec3 way = vec3(0, 0, 0);
            if (found) {
                way = normalize(sub(sample.point.p, reference));
            }
            double pdf = class->solid_angle_pdf(s->params.bytes, &to, NULL, reference, way);
            if (!found) {
                assert_true(pdf == 0);
                continue;
            }
            ++seen;
            assert_true(pdf == sample.pdf);
            Real wanted = solid_angle_of(s, &to, reference);
            double tolerance = k == 0 ? 1e-7 : 1e-9 + 2e-14 / (double)wanted;
            assert_near(pdf * (double)wanted, 1, tolerance);
            double distance = length(sub(sample.point.p, reference));
            Ray ray = ray_make(transform_point(&back, reference), transform_vector(&back, way), 0,
                               INFINITY);
            ShapeHit hit;
            if (class->intersect(s->params.bytes, &ray, &hit)) {
                assert_near(hit.t / distance, 1, 1e-5);
            } else {
                // At the rim, by rounding.
                Vec3 p = transform_point(&back, sample.point.p);
                double u, v;
                s->locate(s, p, &u, &v);
                double rim = fmin(fmin(u, 1 - u), fmin(v, 1 - v));
                assert_true(k == 0 ? fabs(dot(way, sample.point.geometric)) < 1e-3 : rim < 1e-5);
            }
        }
        print_message("  %s: %d seen\n", s->name, seen);
        assert_true(seen > 5000);
    }
}

// Where it can't be: inside, on the surface, in the plane, under other transforms.
static void solid_angles_know_their_limits(void **state)
{
    (void)state;
    Patches patches[3];
    make_seen(patches);
    Affine identity = affine_identity(), uneven = affine_scaling(vec3(1, 2, 1));
    ShapeSample sample;
    const Patches *sphere = &patches[0];
    const ShapeClass *class = class_of(&sphere->params);
    Vec3 on = add(sphere->o, vec3(0, 0.8, 0)), outside = add(sphere->o, vec3(0, 9, 0));
    const void *bytes = sphere->params.bytes;
    assert_false(class->sample_solid_angle(bytes, &identity, NULL, sphere->o, 0.5, 0.5, &sample));
    assert_false(class->sample_solid_angle(bytes, &identity, NULL, on, 0.5, 0.5, &sample));
    assert_false(class->sample_solid_angle(bytes, &uneven, NULL, outside, 0.5, 0.5, &sample));
    assert_true(class->solid_angle_pdf(bytes, &uneven, NULL, outside, vec3(0, -1, 0)) == 0);
    assert_true(class->sample_solid_angle(bytes, &identity, NULL, outside, 0.5, 0.5, &sample));
    for (int k = 1; k < 3; ++k) {
        const Patches *s = &patches[k];
        class = class_of(&s->params);
        Vec3 inside = add(s->o, scale(add(s->eu, s->ev), 0.3));
        assert_false(
            class->sample_solid_angle(s->params.bytes, &identity, NULL, inside, 0.5, 0.5, &sample));
        Vec3 beside = add(s->o, scale(s->eu, 5));
        assert_false(
            class->sample_solid_angle(s->params.bytes, &identity, NULL, beside, 0.5, 0.5, &sample));
    }
    Affine shear = affine_identity();
    shear.m[0][1] = 0.4;
    class = class_of(&patches[1].params);
    assert_false(class->sample_solid_angle(patches[1].params.bytes, &shear, NULL, outside, 0.5, 0.5,
                                           &sample));
}

// Uniform by solid angle: the sphere in bands of its cone, the others in cells of the surface whose
// solid angles are summed from triangles.
static void directions_are_uniform_by_solid_angle(void **state)
{
    (void)state;
    Random r = random_make("directions", 56);
    Patches patches[3];
    int count = make_seen(patches);
    for (int k = 0; k < count; ++k) {
        const Patches *s = &patches[k];
        const ShapeClass *class = class_of(&s->params);
        for (int round = 0; round < 6; ++round) {
            const double aways[6] = {0.05, 0.3, 1, 3, 100, 300};
            Affine to = random_similarity(&r), back;
            assert_true(affine_inverse(&to, &back));
            Vec3 normal = k ? normalize(cross(s->eu, s->ev)) : vec3(0, 1, 0);
            Vec3 near = k ? add(s->o, scale(add(s->eu, s->ev), 0.3)) : add(s->o, vec3(0, 0.8, 0));
            Vec3 own_reference = add_scaled(near, normal, round % 2 ? -aways[round] : aways[round]);
            if (k == 0) {
                own_reference = add_scaled(near, normal, aways[round]);
            }
            Vec3 reference = transform_point(&to, own_reference);
            if (k == 1 && length(sub(own_reference, add(s->o, scale(add(s->eu, s->ev), 0.5)))) >
                              1.25 * (length(s->eu) + length(s->ev))) {
                ShapeSample none; // a rectangle that is seen from afar is sampled by area
                assert_false(class->sample_solid_angle(s->params.bytes, &to, NULL, reference, 0.5,
                                                       0.5, &none));
                continue;
            }
            Histogram h = histogram_make(BINS * BINS);
            h.samples = 100000;
            Vec3 axis = normalize(sub(transform_point(&to, s->o), reference));
            Frame about = frame_from_normal(axis);
            double distance = length(sub(s->o, own_reference));
            double sine = s->r0 / distance, least = sine * sine / (1 + sqrt(1 - sine * sine));
            for (int c = 0; c < h.cells; ++c) {
                if (k == 0) {
                    h.expected[c] = 1;
                    continue;
                }
                enum { FINE = 16 };
                double total = 0, step = 1.0 / BINS / FINE;
                for (int f = 0; f < FINE * FINE; ++f) {
                    double u = (c / BINS * FINE + f / FINE) * step;
                    double v = (c % BINS * FINE + f % FINE) * step;
                    Vec3 p = s->at(s, 0, u, v), q = s->at(s, 0, u + step, v);
                    Vec3 a = s->at(s, 0, u + step, v + step), b = s->at(s, 0, u, v + step);
                    total += (double)(triangle_solid_angle(own_reference, p, q, a) +
                                      triangle_solid_angle(own_reference, p, a, b));
                }
                h.expected[c] = total;
            }
            for (int n = 0; n < h.samples; ++n) {
                ShapeSample sample;
                assert_true(class->sample_solid_angle(s->params.bytes, &to, NULL, reference,
                                                      uniform(&r), uniform(&r), &sample));
                double u, v;
                if (k == 0) {
                    Vec3 w = to_local(&about, normalize(sub(sample.point.p, reference)));
                    // 1 - cos from the sine, which doesn't cancel.
                    double s2 = w.x * w.x + w.y * w.y;
                    u = s2 / (1 + sqrt(1 - s2)) / least;
                    v = turn_of(w.x, w.y);
                } else {
                    s->locate(s, transform_point(&back, sample.point.p), &u, &v);
                }
                ++h.observed[bin_of(u) * BINS + bin_of(v)];
            }
            histogram_check(&h, s->name);
        }
    }
}

// A sphere of a nanometre seen from a metre, and a planet seen from a kilometre above its ground.
static void tiny_and_huge_spheres_are_seen_right(void **state)
{
    (void)state;
    Affine identity = affine_identity();
    const double radii[] = {1e-9, 1e-6, 1, 6.371e6}, distances[] = {1, 1e3, 1e8, 6.372e6};
    for (int i = 0; i < 4; ++i) {
        Params p = sphere_params_of(vec3(0, 0, distances[i]), radii[i]);
        Real sine = (Real)radii[i] / distances[i];
        Real wanted = 2 * (Real)PI * sine * sine / (1 + sqrtl(1 - sine * sine));
        ShapeSample sample;
        for (int n = 0; n < 100; ++n) {
            assert_true(class_of(&p)->sample_solid_angle(p.bytes, &identity, NULL, vec3(0, 0, 0),
                                                         (n + 0.5) / 100, 0.3, &sample));
            assert_near(sample.pdf * (double)wanted, 1, 1e-12);
            Vec3 from = sub(sample.point.p, vec3(0, 0, distances[i]));
            assert_near(length(from), radii[i], sample.point.error);
            // On the near side, in the cone.
            assert_true(sample.point.p.z < distances[i]);
            double across = sqrt(from.x * from.x + from.y * from.y) / sample.point.p.z;
            double edge = radii[i] / sqrt(distances[i] * distances[i] - radii[i] * radii[i]);
            assert_true(across <= edge * (1 + 1e-6) + 1e-12);
        }
    }
}

// --- Integrals that others have computed ------------------------------------------------------

// Means over batches, each of a Kronecker sequence of four dimensions with a random shift, so that
// the batches' spread tells the error of their mean.
enum { BATCHES = 64 };
// So many that the worst of these checks finds a bias of 0.15 %, in a full run of 0.1 %.
static int batch_size(void)
{
    return full_run() ? 32768 : 8192;
}

typedef struct Mean {
    double sums[BATCHES];
} Mean;

typedef struct Points {
    double shift[4];
} Points;

static Points points_begin(Random *r)
{
    Points p;
    for (int i = 0; i < 4; ++i) {
        p.shift[i] = uniform(r);
    }
    return p;
}
static void points_at(const Points *p, int n, double out[4])
{
    double power = 1; // of the root of x^5 = x + 1
    for (int i = 0; i < 4; ++i) {
        power /= 1.16730397826141868;
        out[i] = fmod(p->shift[i] + n * power, 1);
    }
}

// |z| below 4.5 (Student's t with 63 degrees: one in 30,000 fails); and the standard error must be
// so small that a bias of 0.1 % would show.
static void mean_check(const Mean *m, double wanted, const char *what)
{
    double mean = 0, squares = 0;
    for (int i = 0; i < BATCHES; ++i) {
        mean += m->sums[i] / batch_size() / BATCHES;
    }
    for (int i = 0; i < BATCHES; ++i) {
        double d = m->sums[i] / batch_size() - mean;
        squares += d * d;
    }
    double error = sqrt(squares / (BATCHES - 1) / BATCHES);
    // The wanted numbers are given to six or more digits.
    double z = (mean - wanted) / fmax(error, 1e-6 * wanted);
    trust_mean(what, wanted, mean, fmax(error, 1e-6 * wanted), BATCHES - 1, 1e-3);
    assert_true(error < 2e-4 * wanted);
    assert_true(fabs(z) < 4.5);
}

static double cosine_at(const ShapeSample *s, Vec3 from)
{
    return fabs(dot(s->point.geometric, normalize(sub(from, s->point.p))));
}

// Reference check 12, by area and by solid angle: the fraction of light from one square that falls
// on another.
static void view_factors_of_squares(void **state)
{
    (void)state;
    Random r = random_make("view factors", 57);
    Params a = rectangle_params_of(vec3(0, 0, 0), vec3(0, 0, 1), vec3(1, 0, 0));
    Params other[2] = {rectangle_params_of(vec3(0, 1, 0), vec3(1, 0, 0), vec3(0, 0, 1)),
                       rectangle_params_of(vec3(0, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1))};
    const double wanted[2] = {0.199824896, 0.200043776};
    assert_near(wanted[0] + 4 * wanted[1], 1, 1e-8);
    Affine identity = affine_identity();
    const ShapeClass *class = class_of(&a);
    for (int k = 0; k < 2; ++k) {
        Mean by_area = {{0}}, by_angle = {{0}};
        Points points = {{0}};
        for (int n = 0; n < BATCHES * batch_size(); ++n) {
            points = n % batch_size() ? points : points_begin(&r);
            double u[4];
            points_at(&points, n % batch_size(), u);
            ShapeSample p, q;
            class->sample_area(NULL, a.bytes, &identity, NULL, u[0], u[1], 0, &p);
            if (k == 0) { // the perpendicular ones touch, where this has no finite variance
                class->sample_area(NULL, other[k].bytes, &identity, NULL, u[2], u[3], 0, &q);
                Vec3 d = sub(q.point.p, p.point.p);
                double c = fabs(dot(p.point.geometric, normalize(d))) * cosine_at(&q, p.point.p);
                by_area.sums[n / batch_size()] += c / (PI * dot(d, d)) / q.pdf;
            }
            if (class->sample_solid_angle(other[k].bytes, &identity, NULL, p.point.p, u[2], u[3],
                                          &q)) {
                Vec3 d = normalize(sub(q.point.p, p.point.p));
                by_angle.sums[n / batch_size()] += fabs(dot(p.point.geometric, d)) / PI / q.pdf;
            }
        }
        if (k == 0) {
            mean_check(&by_area, wanted[k], "12 parallel squares by area");
        }
        mean_check(&by_angle, wanted[k],
                   k ? "12 perpendicular squares by solid angle"
                     : "12 parallel squares by solid angle");
    }
}

// Reference checks 10 and 11: irradiance over radiance under a square, discs, a sphere.
static void irradiance_under_lights(void **state)
{
    (void)state;
    Random r = random_make("irradiance", 58);
    Affine identity = affine_identity();
    Params square = rectangle_params_of(vec3(-0.5, 1, -0.5), vec3(1, 0, 0), vec3(0, 0, 1));
    Params disc = disc_params_of(vec3(0, 1, 0), vec3(0, -1, 0), 1, 0);
    Params sphere = sphere_params_of(vec3(1, 2, 0.5), 0.7);
    Mean m[6] = {{{0}}};
    Points points = {{0}};
    for (int n = 0; n < BATCHES * batch_size(); ++n) {
        ShapeSample s;
        points = n % batch_size() ? points : points_begin(&r);
        double u[4];
        points_at(&points, n % batch_size(), u);
        const int batch = n / batch_size();
        Vec3 o = vec3(0, 0, 0);
        class_of(&square)->sample_solid_angle(square.bytes, &identity, NULL, o, u[0], u[1], &s);
        m[0].sums[batch] += normalize(s.point.p).y / s.pdf;
        class_of(&square)->sample_area(NULL, square.bytes, &identity, NULL, u[0], u[1], 0, &s);
        m[1].sums[batch] +=
            normalize(s.point.p).y * cosine_at(&s, o) / dot(s.point.p, s.point.p) / s.pdf;
        for (int k = 0; k < 3; ++k) {
            Vec3 at = vec3(k, 0, 0);
            class_of(&disc)->sample_area(NULL, disc.bytes, &identity, NULL, u[0], u[1], 0, &s);
            Vec3 d = sub(s.point.p, at);
            m[2 + k].sums[batch] += normalize(d).y * cosine_at(&s, at) / dot(d, d) / s.pdf / PI;
        }
        class_of(&sphere)->sample_solid_angle(sphere.bytes, &identity, NULL, o, u[0], u[1], &s);
        m[5].sums[batch] += normalize(s.point.p).y / s.pdf;
    }
    mean_check(&m[0], 0.752275, "10 square by solid angle");
    mean_check(&m[1], 0.752275, "10 square by area");
    mean_check(&m[2], 0.5, "10 disc, x = 0, by area");
    mean_check(&m[3], 0.276393, "10 disc, x = 1, by area");
    mean_check(&m[4], 0.0527864, "10 disc, x = 2, by area");
    mean_check(&m[5], PI * 0.49 / 5.25 * 2 / sqrt(5.25), "11 sphere by solid angle");
}

// Reference check 24, second half: a sphere on the axis projects to radius r/√(d²−r²).
static void spheres_project_to_their_outline(void **state)
{
    (void)state;
    const double radii[] = {1, 0.5, 1e-3, 30}, distances[] = {2, 7, 1, 30.5};
    int wrong = 0;
    for (int i = 0; i < 4; ++i) {
        double r = radii[i], d = distances[i], edge = r / sqrt(d * d - r * r);
        Params p = sphere_params_of(vec3(0, 0, -d), r);
        for (int k = 0; k < 100; ++k) {
            double angle = 2 * PI * k / 100;
            for (int side = -1; side <= 1; side += 2) {
                double x = edge * (1 + side * 1e-9);
                Ray ray =
                    ray_make(vec3(0, 0, 0), normalize(vec3(x * cos(angle), x * sin(angle), -1)), 0,
                             INFINITY);
                ShapeHit hit;
                wrong += class_of(&p)->intersect(p.bytes, &ray, &hit) != (side < 0);
            }
        }
    }
    assert_true(trust_none("24 rays a billionth inside or outside r/sqrt(d2-r2)", wrong, 800));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(areas_are_integrals),
        cmocka_unit_test(areas_are_those_of_books),
        cmocka_unit_test(points_are_uniform_by_area),
        cmocka_unit_test(sampled_points_are_those_of_rays),
        cmocka_unit_test(mesh_triangles_are_chosen_by_area),
        cmocka_unit_test(solid_angle_densities_are_one_over_it),
        cmocka_unit_test(solid_angles_know_their_limits),
        cmocka_unit_test(directions_are_uniform_by_solid_angle),
        cmocka_unit_test(tiny_and_huge_spheres_are_seen_right),
        cmocka_unit_test(view_factors_of_squares),
        cmocka_unit_test(irradiance_under_lights),
        cmocka_unit_test(spheres_project_to_their_outline),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
