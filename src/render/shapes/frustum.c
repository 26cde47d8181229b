#include "render/shapes/frustum.h"

Frustum frustum_make(Vec3 from, Vec3 to, double r0, double r1, bool caps)
{
    Vec3 axis = sub(to, from);
    double height = length(axis);
    return (Frustum){from, frame_from_normal(scale(axis, 1 / height)), height, r0, r1, caps};
}

static double frustum_size(const Frustum *f)
{
    return max_abs(f->from) + f->height + fmax(f->r0, f->r1);
}

Box3 frustum_bounds(const Frustum *f)
{
    Vec3 n = f->frame.n, to = add_scaled(f->from, n, f->height);
    Vec3 reach =
        vec3(sqrt(n.y * n.y + n.z * n.z), sqrt(n.z * n.z + n.x * n.x), sqrt(n.x * n.x + n.y * n.y));
    double e = rounding_error(frustum_size(f));
    Vec3 more = vec3(e, e, e);
    Vec3 a = add(scale(reach, f->r0), more), b = add(scale(reach, f->r1), more);
    return box3_union((Box3){sub(f->from, a), add(f->from, a)}, (Box3){sub(to, b), add(to, b)});
}

// A ray in the frustum's frame, brought near where it came from far away, since squares of large
// coordinates would drown the radius. A ray from nearby stays as it is: the sign of its first root
// tells on which side it begins.
typedef struct FrustumRay {
    Vec3 o, d;
    double shift; // t of o
} FrustumRay;

static FrustumRay frustum_ray(const Frustum *f, const Ray *ray)
{
    Vec3 from = sub(ray->origin, f->from);
    FrustumRay out = {to_local(&f->frame, from), to_local(&f->frame, ray->direction), 0};
    double size = f->height + fmax(f->r0, f->r1);
    Vec3 middle = vec3(out.o.x, out.o.y, out.o.z - f->height / 2);
    if (length_squared(middle) > 16 * size * size) {
        out.shift = -dot(middle, out.d) / length_squared(out.d);
        out.o = add_scaled(out.o, out.d, out.shift);
    }
    return out;
}

static void take_nearer(const Ray *ray, const FrustumRay *r, double t, uint32_t part, ShapeHit *hit)
{
    t += r->shift;
    if (t > ray->tmin && t < hit->t) {
        hit->t = t;
        hit->primitive = part;
    }
}

// The side: x² + y² = (r0 + k z)², with the half b of the linear coefficient; roots q/a and c/q.
// Side and caps overlap by rounding errors, so that no ray slips through between them.
static void side_intersect(const Frustum *f, const Ray *ray, const FrustumRay *r, double slack,
                           ShapeHit *hit)
{
    double k = (f->r1 - f->r0) / f->height, radius = f->r0 + k * r->o.z;
    double a = r->d.x * r->d.x + r->d.y * r->d.y - k * k * r->d.z * r->d.z;
    double b = r->o.x * r->d.x + r->o.y * r->d.y - k * r->d.z * radius;
    double around = sqrt(r->o.x * r->o.x + r->o.y * r->o.y);
    double c = (around - radius) * (around + radius);
    double discriminant = b * b - a * c;
    if (!(discriminant >= 0)) {
        return;
    }
    double q = -(b + copysign(sqrt(discriminant), b));
    double roots[2] = {q / a, c / q};
    for (int i = 0; i < 2; ++i) {
        double z = r->o.z + roots[i] * r->d.z;
        if (z >= -slack && z <= f->height + slack) {
            take_nearer(ray, r, roots[i], FRUSTUM_SIDE, hit);
        }
    }
}

static void cap_intersect(const Frustum *f, const Ray *ray, const FrustumRay *r, uint32_t part,
                          double slack, ShapeHit *hit)
{
    double z = part == FRUSTUM_FROM ? 0 : f->height, radius = part == FRUSTUM_FROM ? f->r0 : f->r1;
    double t = (z - r->o.z) / r->d.z;
    double x = r->o.x + t * r->d.x, y = r->o.y + t * r->d.y;
    if (radius > 0 && x * x + y * y <= (radius + slack) * (radius + slack)) {
        take_nearer(ray, r, t, part, hit);
    }
}

bool frustum_intersect(const Frustum *f, const Ray *ray, ShapeHit *hit)
{
    FrustumRay r = frustum_ray(f, ray);
    double slack = 4 * ROUNDING * frustum_size(f);
    *hit = (ShapeHit){.t = ray->tmax};
    side_intersect(f, ray, &r, f->caps ? slack : 0, hit);
    if (f->caps) {
        cap_intersect(f, ray, &r, FRUSTUM_FROM, slack, hit);
        cap_intersect(f, ray, &r, FRUSTUM_TO, slack, hit);
    }
    return hit->t < ray->tmax;
}

// `direction` is the unit vector across the axis to the point, z its height. On the side u runs
// around the axis and v along it; on the caps v runs from the rim inwards.
static void point_at(const Frustum *f, uint32_t part, double x, double y, double z, double r,
                     ShapePoint *out)
{
    double k = (f->r1 - f->r0) / f->height, end = part == FRUSTUM_FROM ? f->r0 : f->r1;
    double around = atan2(y, x) / (2 * PI);
    // The one at `from` looks the other way, so u runs backwards there.
    double turn = part == FRUSTUM_FROM ? -1 : 1;
    around *= turn;
    Vec3 n = part == FRUSTUM_SIDE ? normalize(vec3(x, y, -k)) : vec3(0, 0, turn);
    n = from_local(&f->frame, n);
    double tangent = r > 0 ? 2 * PI * r * turn : 1;
    Vec3 along = part == FRUSTUM_SIDE ? vec3(x * (f->r1 - f->r0), y * (f->r1 - f->r0), f->height)
                                      : vec3(-x * end, -y * end, 0);
    *out = (ShapePoint){.p = add(f->from, from_local(&f->frame, vec3(x * r, y * r, z))),
                        .geometric = n,
                        .shading = n,
                        .tangent = scale(from_local(&f->frame, vec3(-y, x, 0)), tangent),
                        .bitangent = from_local(&f->frame, along),
                        .uv = {around < 0 ? around + 1 : around,
                               part == FRUSTUM_SIDE ? z / f->height : (end - r) / end},
                        .color = {1, 1, 1},
                        .error = rounding_error(frustum_size(f))};
}

void frustum_point(const Frustum *f, const Ray *ray, const ShapeHit *hit, ShapePoint *out)
{
    Vec3 from = add_scaled(sub(ray->origin, f->from), ray->direction, hit->t);
    Vec3 p = to_local(&f->frame, from);
    double r = sqrt(p.x * p.x + p.y * p.y);
    double x = r > 0 ? p.x / r : 1, y = r > 0 ? p.y / r : 0;
    double z = fmin(fmax(p.z, 0), f->height);
    if (hit->primitive == FRUSTUM_SIDE) {
        r = f->r0 + (f->r1 - f->r0) * (z / f->height);
    } else {
        z = hit->primitive == FRUSTUM_FROM ? 0 : f->height;
        r = fmin(r, hit->primitive == FRUSTUM_FROM ? f->r0 : f->r1);
    }
    point_at(f, hit->primitive, x, y, z, r, out);
}

// |C n| of the side's (unnormalized) area vector at an angle: r dz dphi times it is the world's
// area.
static double side_factor(const Frustum *f, const Affine *cofactors, double x, double y)
{
    double k = (f->r1 - f->r0) / f->height;
    return length(transform_vector(cofactors, from_local(&f->frame, vec3(x, y, -k))));
}

FrustumTable frustum_table(const Frustum *f, const Affine *to_world)
{
    Affine cofactors = affine_cofactors(to_world);
    double cap = length(transform_vector(&cofactors, f->frame.n)), factor;
    FrustumTable table = {.similar = affine_is_similarity(to_world, &factor)};
    // The mean around the axis by the trapezoid rule, which for a smooth periodic function is
    // exact to rounding soon; the largest value with what may lie between two nodes.
    enum { NODES = 1024 };
    int nodes = table.similar ? 1 : NODES;
    double sum = 0, most = 0, jump = 0, last = side_factor(f, &cofactors, 1, 0);
    for (int i = 0; i < nodes; ++i) {
        double angle = 2 * PI * (i + 1) / nodes;
        double here = side_factor(f, &cofactors, cos(angle), sin(angle));
        sum += here;
        most = fmax(most, here);
        jump = fmax(jump, fabs(here - last));
        last = here;
    }
    table.most = most + jump;
    table.area[FRUSTUM_SIDE] = sum / nodes * PI * f->height * (f->r0 + f->r1);
    table.area[FRUSTUM_FROM] = f->caps ? PI * f->r0 * f->r0 * cap : 0;
    table.area[FRUSTUM_TO] = f->caps ? PI * f->r1 * f->r1 * cap : 0;
    table.total = table.area[0] + table.area[1] + table.area[2];
    return table;
}

static void sample_side(const Frustum *f, const Affine *to_world, const FrustumTable *table,
                        double u0, double u1, double u2, ShapePoint *out)
{
    // Height with density proportional to the radius there.
    double squared = f->r0 * f->r0 + u0 * (f->r1 * f->r1 - f->r0 * f->r0);
    double under = f->r0 + sqrt(fmax(0, squared));
    double z = under > 0 ? f->height * fmin(1, u0 * (f->r0 + f->r1) / under) : 0;
    Affine cofactors = affine_cofactors(to_world);
    Rejection more = rejection_begin(u0, u1, u2);
    double x = 1, y = 0;
    for (int tries = 0; tries < REJECTION_TRIES; ++tries) {
        x = cos(2 * PI * u1);
        y = sin(2 * PI * u1);
        if (table->similar || u2 * table->most <= side_factor(f, &cofactors, x, y)) {
            break;
        }
        u1 = rejection_next(&more);
        u2 = rejection_next(&more);
    }
    point_at(f, FRUSTUM_SIDE, x, y, z, f->r0 + (f->r1 - f->r0) * (z / f->height), out);
}

void frustum_sample_area(const Frustum *f, const Affine *to_world, const FrustumTable *table,
                         double u0, double u1, double u2, ShapeSample *out)
{
    double at = u2 * table->total;
    uint32_t part = FRUSTUM_SIDE;
    while (part < FRUSTUM_TO && at >= table->area[part]) {
        at -= table->area[part++];
    }
    if (part == FRUSTUM_SIDE) {
        sample_side(f, to_world, table, u0, u1, at / table->area[part], &out->point);
    } else {
        double r = (part == FRUSTUM_FROM ? f->r0 : f->r1) * sqrt(u0);
        point_at(f, part, cos(2 * PI * u1), sin(2 * PI * u1), part == FRUSTUM_FROM ? 0 : f->height,
                 r, &out->point);
    }
    shape_point_map(to_world, &out->point);
    out->primitive = part;
    out->pdf = 1 / table->total;
}
