// Every kind of shape against its definition: an implicit function in long double, sampled densely
// along rays.
#include "shapes.h"

typedef long double Real;
typedef struct Real3 {
    Real x, y, z;
} Real3;

static Real3 real3(Vec3 v)
{
    return (Real3){v.x, v.y, v.z};
}
static Real rdot(Real3 a, Real3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static Real3 rsub(Real3 a, Real3 b)
{
    return (Real3){a.x - b.x, a.y - b.y, a.z - b.z};
}
static Real3 along(const Ray *ray, Real t)
{
    return (Real3){ray->origin.x + t * ray->direction.x, ray->origin.y + t * ray->direction.y,
                   ray->origin.z + t * ray->direction.z};
}

// A solid: negative inside, positive outside, with a gradient near 1 at the surface.
typedef struct Solid {
    const char *name;
    Params params;
    Real (*side)(const struct Solid *solid, Real3 p);
    Vec3 a, b;
    double r0, r1;
} Solid;

static Real sphere_side(const Solid *s, Real3 p)
{
    Real3 f = rsub(p, real3(s->a));
    return sqrtl(rdot(f, f)) - s->r0;
}
static Real box_side(const Solid *s, Real3 p)
{
    Real x = fmaxl(s->a.x - p.x, p.x - s->b.x), y = fmaxl(s->a.y - p.y, p.y - s->b.y);
    return fmaxl(fmaxl(x, y), fmaxl(s->a.z - p.z, p.z - s->b.z));
}
static Real cone_side(const Solid *s, Real3 p)
{
    Real3 axis = rsub(real3(s->b), real3(s->a)), f = rsub(p, real3(s->a));
    Real h = sqrtl(rdot(axis, axis)), z = rdot(f, axis) / h;
    Real across = sqrtl(fmaxl(0, rdot(f, f) - z * z)), k = (s->r1 - s->r0) / h;
    Real side = (across - (s->r0 + k * z)) / sqrtl(1 + k * k);
    return fmaxl(side, fmaxl(-z, z - h));
}
static Real torus_side(const Solid *s, Real3 p)
{
    Real3 f = rsub(p, real3(s->a)), n = real3(s->b);
    Real z = rdot(f, n) / sqrtl(rdot(n, n));
    Real across = sqrtl(fmaxl(0, rdot(f, f) - z * z)) - s->r0;
    return sqrtl(across * across + z * z) - s->r1;
}

static int make_solids(Solid *out)
{
    int n = 0;
    Vec3 o = vec3(0.3, -0.2, 0.5), d = vec3(0.4, 1.1, -0.7);
    out[n++] = (Solid){"sphere", sphere_params_of(o, 0.8), sphere_side, o, o, 0.8, 0};
    out[n++] = (Solid){"box",
                       box_params_of(vec3(-0.5, -0.2, 0.1), vec3(0.7, 0.9, 0.6)),
                       box_side,
                       vec3(-0.5, -0.2, 0.1),
                       vec3(0.7, 0.9, 0.6),
                       0,
                       0};
    out[n++] = (Solid){"cylinder", cylinder_params_of(o, d, 0.4, true), cone_side, o, d, 0.4, 0.4};
    out[n++] = (Solid){"cone", cone_params_of(o, d, 0.6, 0.2, true), cone_side, o, d, 0.6, 0.2};
    out[n++] =
        (Solid){"cone to a tip", cone_params_of(o, d, 0.7, 0, true), cone_side, o, d, 0.7, 0};
    out[n++] =
        (Solid){"cone from a tip", cone_params_of(o, d, 0, 0.5, true), cone_side, o, d, 0, 0.5};
    out[n++] = (Solid){"torus", torus_params_of(o, d, 0.9, 0.3), torus_side, o, d, 0.9, 0.3};
    out[n++] = (Solid){"thin torus", torus_params_of(o, d, 1, 0.01), torus_side, o, d, 1, 0.01};
    out[n++] = (Solid){"fat torus", torus_params_of(o, d, 0.6, 0.58), torus_side, o, d, 0.6, 0.58};
    return n;
}

// A place to send a ray to: in the box, or, which finds thin shapes, on the surface.
static Vec3 target_of(const Solid *s, Random *r)
{
    double u0 = uniform(r), u1 = uniform(r), u2 = uniform(r);
    if (uniform(r) < 0.5) {
        return random_in_box(r, s->params.type->bounds(NULL, s->params.bytes));
    }
    Affine identity = affine_identity();
    ShapeSample sample;
    class_of(&s->params)->sample_area(NULL, s->params.bytes, &identity, NULL, u0, u1, u2, &sample);
    return sample.point.p;
}

static Box3 grow(Box3 box, double by)
{
    Vec3 v = vec3(by, by, by);
    return (Box3){sub(box.min, v), add(box.max, v)};
}

// The first crossing of the surface along a ray by dense sampling; INFINITY: none. Two crossings
// between neighbouring samples are missed, so a miss proves nothing, but a hit does.
static Real dense_hit(const Solid *s, const Ray *ray, Real end, int samples)
{
    Real t0 = 0, f0 = s->side(s, along(ray, 0));
    for (int i = 1; i <= samples; ++i) {
        Real t1 = end * i / samples, f1 = s->side(s, along(ray, t1));
        if ((f0 < 0) != (f1 < 0)) {
            for (int k = 0; k < 80; ++k) {
                Real m = (t0 + t1) / 2;
                *((s->side(s, along(ray, m)) < 0) == (f0 < 0) ? &t0 : &t1) = m;
            }
            return t1;
        }
        t0 = t1;
        f0 = f1;
    }
    return INFINITY;
}

static void rays_hit_what_dense_sampling_finds(void **state)
{
    (void)state;
    Random r = random_make("dense", 20241);
    Solid solids[16];
    int count = make_solids(solids);
    for (int k = 0; k < count; ++k) {
        Solid *s = &solids[k];
        const ShapeClass *class = class_of(&s->params);
        Box3 box = s->params.type->bounds(NULL, s->params.bytes), around = grow(box, 1);
        int hits = 0, unseen = 0;
        for (int i = 0; i < 4000; ++i) {
            // The direction's length differs from 1 on purpose.
            Vec3 from = random_in_box(&r, around), to = target_of(s, &r);
            double speed = exp(between(&r, -3, 3));
            Ray ray = ray_make(from, scale(normalize(sub(to, from)), speed), 0, INFINITY);
            Real expected = dense_hit(s, &ray, 8 / speed, 1000);
            ShapeHit hit;
            bool found = class->intersect(s->params.bytes, &ray, &hit);
            if (!isinf(expected)) {
                ++hits;
                if (!found) {
                    fail_msg("%s: ray %d misses", s->name, i);
                }
                if (hit.t < (double)expected * (1 - 1e-9) - 1e-12 / speed) {
                    // A thin piece between two samples: it must be on the surface all the same.
                    ++unseen;
                } else if (fabs(hit.t - (double)expected) * speed > 1e-7) {
                    fail_msg("%s: ray %d hits at %.17g, not %.17g", s->name, i, hit.t,
                             (double)expected);
                }
            }
            if (found) {
                Real residual = s->side(s, along(&ray, hit.t));
                assert_near((double)residual, 0, 1e-7);
            }
        }
        print_message("  %s: %d hits, %d seen only by the shape\n", s->name, hits, unseen);
        assert_true(hits > 500 && unseen < hits / 10);
    }
}

// Normal, bounds, uv, tangent, error and range of t at points that rays hit.
static void points_lie_on_the_surface(void **state)
{
    (void)state;
    Random r = random_make("points", 20242);
    Solid solids[16];
    int count = make_solids(solids);
    for (int k = 0; k < count; ++k) {
        Solid *s = &solids[k];
        const ShapeClass *class = class_of(&s->params);
        Box3 box = s->params.type->bounds(NULL, s->params.bytes);
        int checked = 0;
        for (int i = 0; i < 20000; ++i) {
            Vec3 from = random_in_box(&r, grow(box, 2)), to = target_of(s, &r);
            Ray ray = ray_make(from, normalize(sub(to, from)), 0, INFINITY);
            ShapeHit hit;
            if (!class->intersect(s->params.bytes, &ray, &hit)) {
                continue;
            }
            ShapePoint p;
            class->point(NULL, s->params.bytes, &ray, &hit, &p);
            assert_true(p.error > 0 && p.error < 1e-13);
            Real residual = s->side(s, real3(p.p));
            if (fabsl(residual) > (Real)p.error) {
                fail_msg("%s: %Lg off the surface, more than %g", s->name, residual, p.error);
            }
            assert_true(length(sub(p.p, add_scaled(ray.origin, ray.direction, hit.t))) < 1e-7);
            Box3 close = grow(box, p.error);
            assert_true(p.p.x >= close.min.x && p.p.x <= close.max.x && p.p.y >= close.min.y &&
                        p.p.y <= close.max.y && p.p.z >= close.min.z && p.p.z <= close.max.z);
            assert_near(length(p.geometric), 1, 1e-12);
            assert_near(dot(p.geometric, p.tangent) / length(p.tangent), 0, 1e-9);
            assert_true(p.uv.x >= 0 && p.uv.x <= 1 && p.uv.y >= -1e-12 && p.uv.y <= 1 + 1e-12);
            // The gradient by differences, off the edges, where it is defined.
            double e = 1e-6;
            Vec3 g;
            g.x = (double)(s->side(s, real3(add(p.p, vec3(e, 0, 0)))) -
                           s->side(s, real3(sub(p.p, vec3(e, 0, 0)))));
            g.y = (double)(s->side(s, real3(add(p.p, vec3(0, e, 0)))) -
                           s->side(s, real3(sub(p.p, vec3(0, e, 0)))));
            g.z = (double)(s->side(s, real3(add(p.p, vec3(0, 0, e)))) -
                           s->side(s, real3(sub(p.p, vec3(0, 0, e)))));
            g = scale(g, 1 / (2 * e));
            if (fabs(length(g) - 1) < 1e-6) {
                assert_true(length(sub(g, p.geometric)) < 1e-3);
                ++checked;
            }
            // The open interval (tmin, tmax).
            ShapeHit other;
            Ray cut = ray;
            cut.tmax = hit.t - 1e-7;
            assert_false(class->intersect(s->params.bytes, &cut, &other));
            cut.tmax = INFINITY;
            cut.tmin = hit.t + 1e-7;
            if (class->intersect(s->params.bytes, &cut, &other)) {
                assert_true(other.t > cut.tmin);
            }
        }
        assert_true(checked > 3000);
    }
}

// dp/du by differences of the points at neighbouring hits, and u × v on the side of the normal.
static void uv_follow_the_tangents(void **state)
{
    (void)state;
    Random r = random_make("uv", 20243);
    Solid solids[16];
    int count = make_solids(solids);
    for (int k = 0; k < count; ++k) {
        Solid *s = &solids[k];
        const ShapeClass *class = class_of(&s->params);
        Box3 box = s->params.type->bounds(NULL, s->params.bytes);
        int checked = 0;
        for (int i = 0; i < 4000; ++i) {
            Vec3 from = random_in_box(&r, grow(box, 2)), to = target_of(s, &r);
            Ray ray = ray_make(from, normalize(sub(to, from)), 0, INFINITY);
            ShapeHit hit;
            if (!class->intersect(s->params.bytes, &ray, &hit)) {
                continue;
            }
            ShapePoint p, q[2];
            class->point(NULL, s->params.bytes, &ray, &hit, &p);
            Vec3 side[2];
            side[0] = normalize(p.tangent);
            side[1] = cross(p.geometric, side[0]);
            bool smooth = true;
            double h = 1e-6;
            for (int j = 0; j < 2; ++j) {
                // Straight down from above a neighbouring point.
                Ray down = ray_make(add(add_scaled(p.p, side[j], h), scale(p.geometric, 1e-4)),
                                    neg(p.geometric), 0, 1);
                ShapeHit near;
                smooth = smooth && class->intersect(s->params.bytes, &down, &near) &&
                         near.primitive == hit.primitive;
                if (smooth) {
                    class->point(NULL, s->params.bytes, &down, &near, &q[j]);
                    smooth = length(sub(q[j].p, p.p)) < 3 * h && fabs(q[j].uv.x - p.uv.x) < 0.5 &&
                             fabs(q[j].uv.y - p.uv.y) < 0.5;
                }
            }
            // Near tips and poles uv are curved at the scale of the difference.
            if (!smooth || length(p.tangent) < 0.05) {
                continue;
            }
            double du = (q[0].uv.x - p.uv.x) / h;
            assert_near(du * length(p.tangent), 1, 2e-2);
            assert_near(q[0].uv.y, p.uv.y, 1e-3 * h + 2e-9 + 1e-4 * fabs(q[0].uv.x - p.uv.x));
            assert_true(q[1].uv.y > p.uv.y); // v grows to the left of u, seen from outside
            double dv = (q[1].uv.y - p.uv.y) / h;
            assert_near(dv * dot(p.bitangent, side[1]), 1, 2e-2);
            assert_near(dot(p.geometric, p.bitangent) / length(p.bitangent), 0, 1e-9);
            ++checked;
        }
        print_message("  %s: %d\n", s->name, checked);
        assert_true(checked > 200);
    }
}

// From any point, inside or out, the surface is crossed an odd or even number of times.
static void crossings_tell_inside_from_outside(void **state)
{
    (void)state;
    Random r = random_make("parity", 20244);
    Solid solids[16];
    int count = make_solids(solids);
    for (int k = 0; k < count; ++k) {
        Solid *s = &solids[k];
        const ShapeClass *class = class_of(&s->params);
        assert_true(class->closed(s->params.bytes));
        Box3 box = s->params.type->bounds(NULL, s->params.bytes);
        int inside = 0, most = 0;
        for (int i = 0; i < 20000; ++i) {
            Vec3 from = i % 2 ? random_in_box(&r, grow(box, 0.2))
                              : add_scaled(target_of(s, &r), random_direction(&r), 0.01);
            Real side = s->side(s, real3(from));
            if (fabsl(side) < 1e-9L) {
                continue;
            }
            Ray ray = ray_make(from, random_direction(&r), 0, INFINITY);
            int crossings = 0;
            double last = 0;
            ShapeHit hit;
            bool in = side < 0;
            while (class->intersect(s->params.bytes, &ray, &hit) && crossings < 9) {
                ShapePoint p;
                class->point(NULL, s->params.bytes, &ray, &hit, &p);
                if (last > 0 && hit.t - last < 1e-9) {
                    // Both sides of an edge in one place.
                    crossings = in;
                    break;
                }
                assert_true(in ? dot(p.geometric, ray.direction) >= -1e-5
                               : dot(p.geometric, ray.direction) <= 1e-5);
                in = !in;
                ++crossings;
                last = hit.t;
                ray.tmin = hit.t + 1e-12;
            }
            if ((crossings & 1) != (side < 0)) {
                fail_msg("%s: %d crossings from a point at %Lg", s->name, crossings, side);
            }
            inside += side < 0;
            most = crossings > most ? crossings : most;
        }
        assert_true(inside > 30);
        assert_true(most <= (strstr(s->name, "torus") ? 4 : 2));
    }
}

// A ray that starts at a point's offset along the normal and stays on that side of a convex surface
// never comes back, however flat it leaves, at any scale and place; through the surface it does.
static void no_convex_shape_hits_itself(void **state)
{
    (void)state;
    Random r = random_make("self", 20245);
    for (int round = 0; round < 60; ++round) {
        double size = pow(10, between(&r, -6, 6)), away = size * pow(10, between(&r, -3, 5));
        Vec3 o = scale(random_direction(&r), round % 3 ? away : 0);
        Vec3 d = add_scaled(o, random_direction(&r), size);
        Params shapes[4] = {
            sphere_params_of(o, size),
            cylinder_params_of(o, d, size * 0.3, true),
            cone_params_of(o, d, size * 0.5, size * 0.1, true),
            box_params_of(o, add(o, vec3(size, size * 0.5, size * 0.8))),
        };
        for (int k = 0; k < 4; ++k) {
            const ShapeClass *class = class_of(&shapes[k]);
            Box3 box = shapes[k].type->bounds(NULL, shapes[k].bytes);
            for (int i = 0; i < 2000; ++i) {
                Vec3 from = add_scaled(box3_center(box), random_direction(&r), 10 * size);
                Vec3 to = random_in_box(&r, box);
                Ray ray = ray_make(from, normalize(sub(to, from)), 0, INFINITY);
                ShapeHit hit;
                if (!class->intersect(shapes[k].bytes, &ray, &hit)) {
                    continue;
                }
                ShapePoint p;
                class->point(NULL, shapes[k].bytes, &ray, &hit, &p);
                Vec3 out = random_about(&r, p.geometric);
                if (i % 2) { // grazing
                    double flat = pow(10, between(&r, -12, 0));
                    out = normalize(
                        add_scaled(out, p.geometric,
                                   flat * fabs(dot(out, p.geometric)) - dot(out, p.geometric)));
                }
                Ray leave = ray_make(add_scaled(p.p, p.geometric, 4 * p.error), out, 0, INFINITY);
                if (class->intersect(shapes[k].bytes, &leave, &hit)) {
                    fail_msg("%s of size %g at %g hit itself at %g", shapes[k].type->name, size,
                             length(o), hit.t);
                }
                Vec3 in = neg(random_about(&r, p.geometric));
                if (dot(in, p.geometric) > -1e-3) {
                    continue;
                }
                Ray enter = ray_make(add_scaled(p.p, p.geometric, -4 * p.error), in, 0, INFINITY);
                if (!class->intersect(shapes[k].bytes, &enter, &hit)) {
                    // From an edge or a rim the offset may lead out again.
                    Ray deep = ray_make(add_scaled(p.p, in, 64 * p.error), in, 0, INFINITY);
                    assert_false(class->intersect(shapes[k].bytes, &deep, &hit) &&
                                 hit.t > 1e-6 * size);
                }
            }
        }
    }
}

// The torus has hollow sides, so a ray that leaves may rightly come back; what it hits must then be
// away from where it left.
static void torus_hits_itself_only_elsewhere(void **state)
{
    (void)state;
    Random r = random_make("torus", 20246);
    for (int round = 0; round < 60; ++round) {
        double size = pow(10, between(&r, -6, 6)), fat = pow(10, between(&r, -2, -0.01));
        Vec3 o = scale(random_direction(&r), round % 3 ? size * pow(10, between(&r, -2, 4)) : 0);
        Params torus = torus_params_of(o, random_direction(&r), size, size * fat);
        Solid s = {"torus", torus, torus_side, o, vec3(0, 0, 0), size, size * fat};
        memcpy(&s.b, torus.bytes + sizeof(Vec3), sizeof s.b);
        const ShapeClass *class = class_of(&torus);
        for (int i = 0; i < 4000; ++i) {
            Vec3 from = add_scaled(o, random_direction(&r), 4 * size);
            Vec3 to = random_in_box(&r, torus.type->bounds(NULL, torus.bytes));
            Ray ray = ray_make(from, normalize(sub(to, from)), 0, INFINITY);
            ShapeHit hit;
            if (!class->intersect(torus.bytes, &ray, &hit)) {
                continue;
            }
            ShapePoint p;
            class->point(NULL, torus.bytes, &ray, &hit, &p);
            assert_true(fabsl(s.side(&s, real3(p.p))) <= (Real)p.error);
            Vec3 out = random_about(&r, p.geometric);
            Ray leave = ray_make(add_scaled(p.p, p.geometric, 4 * p.error), out, 0, INFINITY);
            if (class->intersect(torus.bytes, &leave, &hit)) {
                // Between start and hit the ray must have been outside for real.
                Real half = s.side(&s, along(&leave, hit.t / 2));
                if (half <= 0) {
                    fail_msg("torus %g, %g at %g hit itself at %g", size, fat, length(o), hit.t);
                }
            }
        }
    }
}

// Rectangle, triangle, disc and plane against a plane equation solved in long double.
static void flat_shapes_meet_their_plane(void **state)
{
    (void)state;
    Random r = random_make("flat", 20247);
    Vec3 c = vec3(0.2, -0.4, 0.1), u = vec3(1, 0.3, -0.2), v = vec3(-0.3, 0.8, 0.5);
    Vec3 n = normalize(cross(u, v));
    Params shapes[4] = {rectangle_params_of(c, u, v), triangle_params_of(c, add(c, u), add(c, v)),
                        disc_params_of(c, n, 1, 0.4), plane_params_of(c, n)};
    int hits[4] = {0};
    for (int i = 0; i < 40000; ++i) {
        Vec3 from = vec3(between(&r, -3, 3), between(&r, -3, 3), between(&r, -3, 3));
        Vec3 to = add(add_scaled(c, u, between(&r, -1, 1.5)), scale(v, between(&r, -1, 1.5)));
        Ray ray = ray_make(from, normalize(sub(to, from)), 0, INFINITY);
        Real3 d = real3(ray.direction), f = rsub(real3(ray.origin), real3(c)), rn = real3(n);
        Real3 nn = {(Real)u.y * v.z - (Real)u.z * v.y, (Real)u.z * v.x - (Real)u.x * v.z,
                    (Real)u.x * v.y - (Real)u.y * v.x};
        Real t = -rdot(f, nn) / rdot(d, nn);
        Real3 p = rsub(along(&ray, t), real3(c));
        // Coordinates by the edges.
        Real uu = rdot(real3(u), real3(u)), vv = rdot(real3(v), real3(v));
        Real uv = rdot(real3(u), real3(v)), pu = rdot(p, real3(u)), pv = rdot(p, real3(v));
        Real det = uu * vv - uv * uv, a = (pu * vv - pv * uv) / det, b = (pv * uu - pu * uv) / det;
        Real radius = sqrtl(rdot(p, p));
        Real margins[4] = {fminl(fminl(a, 1 - a), fminl(b, 1 - b)), fminl(fminl(a, b), 1 - a - b),
                           fminl(radius - 0.4L, 1 - radius), 1};
        (void)rn;
        for (int k = 0; k < 4; ++k) {
            if (fabsl(margins[k]) < 1e-12L) {
                continue;
            }
            ShapeHit hit;
            bool found = class_of(&shapes[k])->intersect(shapes[k].bytes, &ray, &hit);
            if (found != (margins[k] > 0 && t > 0)) {
                fail_msg("%s: %d at %Lg, margin %Lg", shapes[k].type->name, found, t, margins[k]);
            }
            if (!found) {
                continue;
            }
            ++hits[k];
            assert_near(hit.t, (double)t, 1e-12 * (1 + fabs((double)t)));
            ShapePoint point;
            class_of(&shapes[k])->point(NULL, shapes[k].bytes, &ray, &hit, &point);
            assert_true(fabsl(rdot(rsub(real3(point.p), real3(c)), real3(n))) < point.error);
            assert_true(length(sub(point.p, add_scaled(from, ray.direction, hit.t))) < 1e-12);
            assert_true(length(sub(point.geometric, n)) < 1e-12);
            assert_near(dot(point.tangent, n), 0, 1e-12);
            if (k < 2) {
                assert_near(point.uv.x, (double)a, 1e-12);
                assert_near(point.uv.y, (double)b, 1e-12);
            }
        }
    }
    for (int k = 0; k < 4; ++k) {
        assert_true(hits[k] > 1000);
    }
}

// Ends without caps are open: from inside one can look out.
static void cylinders_can_be_open(void **state)
{
    (void)state;
    Params open = cylinder_params_of(vec3(0, 0, 0), vec3(0, 1, 0), 0.5, false);
    Params closed = cylinder_params_of(vec3(0, 0, 0), vec3(0, 1, 0), 0.5, true);
    Ray up = ray_make(vec3(0.1, 0.5, 0.1), vec3(0, 1, 0), 0, INFINITY);
    ShapeHit hit;
    assert_false(class_of(&open)->intersect(open.bytes, &up, &hit));
    assert_true(class_of(&closed)->intersect(closed.bytes, &up, &hit));
    assert_near(hit.t, 0.5, 1e-15);
    assert_false(class_of(&open)->closed(open.bytes));
    Ray across = ray_make(vec3(0, 0.5, 0), vec3(0, 0, 1), 0, INFINITY);
    assert_true(class_of(&open)->intersect(open.bytes, &across, &hit));
    assert_near(hit.t, 0.5, 1e-15);
}

static void expect_report(Params p, DiagCode code, int field)
{
    assert_false(shape_finish(NULL, &p, NULL));
    assert_int_equal(p.code, code);
    assert_int_equal(p.field, field);
}

static Params with_vectors(const char *kind, const char *a, Vec3 va, const char *b, Vec3 vb,
                           const char *c, Vec3 vc)
{
    Params p = params_of(kind);
    set_vec3(&p, a, va);
    set_vec3(&p, b, vb);
    if (c) {
        set_vec3(&p, c, vc);
    }
    return p;
}

static void degenerate_shapes_are_reported(void **state)
{
    (void)state;
    Vec3 o = vec3(0, 0, 0), x = vec3(1, 0, 0), y = vec3(0, 1, 0);
    expect_report(with_vectors("rectangle", "corner", o, "u", o, "v", y), E0801, 1);
    expect_report(with_vectors("rectangle", "corner", o, "u", x, "v", o), E0801, 2);
    expect_report(with_vectors("rectangle", "corner", o, "u", x, "v", scale(x, -3)), E0802, 2);
    expect_report(with_vectors("triangle", "a", x, "b", x, "c", y), E0801, 1);
    expect_report(with_vectors("triangle", "a", x, "b", y, "c", y), E0801, 2);
    expect_report(with_vectors("triangle", "a", o, "b", x, "c", scale(x, 2)), E0802, 2);
    expect_report(with_vectors("cylinder", "from", x, "to", x, NULL, o), E0801, 1);
    expect_report(with_vectors("cone", "from", x, "to", x, NULL, o), E0801, 1);
    Params tip = with_vectors("cone", "from", o, "to", x, NULL, o);
    set_number(&tip, "radius_from", 0);
    set_number(&tip, "radius_to", 0);
    expect_report(tip, E0805, 2);
    expect_report(with_vectors("box", "min", o, "max", x, NULL, o), E0801, 1);
    expect_report(with_vectors("box", "min", vec3(0, 2, 0), "max", vec3(1, 1, 1), NULL, o), E0803,
                  1);
    expect_report(with_vectors("box", "min", o, "size", vec3(1, 1, 1), NULL, o), E0804, -1);
    expect_report(with_vectors("box", "center", vec3(1e20, 0, 0), "size", vec3(1, 1, 1), NULL, o),
                  E0801, 3);
    Params none = params_of("box");
    expect_report(none, E0804, -1);
    Params ring = with_vectors("disc", "center", o, "normal", y, NULL, o);
    set_number(&ring, "radius", 1);
    set_number(&ring, "inner_radius", 1);
    expect_report(ring, E0805, 3);
    Params torus = with_vectors("torus", "center", o, "axis", y, NULL, o);
    set_number(&torus, "major_radius", 1);
    set_number(&torus, "minor_radius", 1);
    expect_report(torus, E0805, 3);
    Params empty = params_of("mesh");
    expect_report(empty, E0804, -1);
    Params both = params_of("mesh");
    const char *file = "a.ply";
    set_bytes(&both, "file", PARAM_FILE, &file, sizeof file);
    field_of(&both, "vertices", PARAM_VEC3_LIST);
    expect_report(both, E0804, -1);
    Vec3 vertices[3] = {o, x, y};
    Vec2 uv = {0, 0};
    Params lists = params_of("mesh");
    set_bytes(&lists, "vertices", PARAM_VEC3_LIST, &(Vec3List){vertices, 3}, sizeof(Vec3List));
    field_of(&lists, "faces", PARAM_FACE_LIST);
    set_bytes(&lists, "uvs", PARAM_VEC2_LIST, &(Vec2List){&uv, 1}, sizeof(Vec2List));
    expect_report(lists, E0806, 4);
}

static void box_by_center_is_box_by_corners(void **state)
{
    (void)state;
    Params a = box_params_of(vec3(-1, 0, 2), vec3(1, 4, 3)), b = params_of("box");
    set_vec3(&b, "center", vec3(0, 2, 2.5));
    set_vec3(&b, "size", vec3(2, 4, 1));
    finish_well(NULL, &b);
    assert_memory_equal(a.bytes, b.bytes, a.type->size);
}

static void tables_are_sound(void **state)
{
    (void)state;
    char buffer[200];
    const char *wrong = schema_check(render_schema(), buffer, sizeof buffer);
    if (wrong) {
        fail_msg("%s", wrong);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_hit_what_dense_sampling_finds),
        cmocka_unit_test(points_lie_on_the_surface),
        cmocka_unit_test(uv_follow_the_tangents),
        cmocka_unit_test(crossings_tell_inside_from_outside),
        cmocka_unit_test(no_convex_shape_hits_itself),
        cmocka_unit_test(torus_hits_itself_only_elsewhere),
        cmocka_unit_test(flat_shapes_meet_their_plane),
        cmocka_unit_test(cylinders_can_be_open),
        cmocka_unit_test(degenerate_shapes_are_reported),
        cmocka_unit_test(box_by_center_is_box_by_corners),
        cmocka_unit_test(tables_are_sound),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
