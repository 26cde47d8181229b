// Vectors, affine maps, boxes and colours. Geometry is double: a float holds 24 bits, too few for
// points that lie far from the origin.
#ifndef BASE_VEC_H
#define BASE_VEC_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

typedef struct Vec2 {
    double x, y;
} Vec2;

typedef struct Vec3 {
    double x, y, z;
} Vec3;

// Linear Rec.709, unbounded.
typedef struct Rgb {
    float r, g, b;
} Rgb;

// p -> m p + t, rows first: m[row][column], column 3 the translation.
typedef struct Affine {
    double m[3][4];
} Affine;

typedef struct Box3 {
    Vec3 min, max;
} Box3;

// An orthonormal frame; n is the third axis.
typedef struct Frame {
    Vec3 s, t, n;
} Frame;

#define PI 3.14159265358979323846

static inline Vec3 vec3(double x, double y, double z)
{
    return (Vec3){x, y, z};
}
static inline Vec3 add(Vec3 a, Vec3 b)
{
    return vec3(a.x + b.x, a.y + b.y, a.z + b.z);
}
static inline Vec3 sub(Vec3 a, Vec3 b)
{
    return vec3(a.x - b.x, a.y - b.y, a.z - b.z);
}
static inline Vec3 scale(Vec3 a, double s)
{
    return vec3(a.x * s, a.y * s, a.z * s);
}
static inline Vec3 neg(Vec3 a)
{
    return vec3(-a.x, -a.y, -a.z);
}
// a + s b
static inline Vec3 add_scaled(Vec3 a, Vec3 b, double s)
{
    return vec3(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s);
}
static inline double dot(Vec3 a, Vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline Vec3 cross(Vec3 a, Vec3 b)
{
    return vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline double length_squared(Vec3 a)
{
    return dot(a, a);
}
static inline double length(Vec3 a)
{
    return sqrt(dot(a, a));
}
// The unit vector along a; a itself must not be zero.
static inline Vec3 normalize(Vec3 a)
{
    return scale(a, 1 / length(a));
}
// The same for a vector whose length is 1 up to rounding: a step of Newton's method, without
// division and square root.
static inline Vec3 renormalize(Vec3 a)
{
    return scale(a, 1.5 - 0.5 * dot(a, a));
}
static inline double vec3_get(Vec3 a, int axis)
{
    return axis == 0 ? a.x : axis == 1 ? a.y : a.z;
}
// For numbers that aren't NaN: fmax and fmin, which mind them, are calls.
static inline double larger(double a, double b)
{
    return a > b ? a : b;
}
static inline double smaller(double a, double b)
{
    return a < b ? a : b;
}
// fmin and fmax without the call: a NaN gives way.
static inline double lesser(double a, double b)
{
    return b < a || a != a ? b : a;
}
static inline double greater(double a, double b)
{
    return b > a || a != a ? b : a;
}
static inline double max_component(Vec3 a)
{
    return larger(larger(a.x, a.y), a.z);
}
static inline Vec3 vec3_abs(Vec3 a)
{
    return vec3(fabs(a.x), fabs(a.y), fabs(a.z));
}
static inline bool vec3_is_finite(Vec3 a)
{
    return isfinite(a.x) && isfinite(a.y) && isfinite(a.z);
}

// Duff et al. 2017, "Building an Orthonormal Basis, Revisited"; n must be of unit length.
static inline Frame frame_from_normal(Vec3 n)
{
    double sign = copysign(1.0, n.z);
    double a = -1.0 / (sign + n.z), b = n.x * n.y * a;
    return (Frame){vec3(1 + sign * n.x * n.x * a, sign * b, -sign * n.x),
                   vec3(b, sign + n.y * n.y * a, -n.y), n};
}
// The frame about n whose s axis lies as near to `tangent` as it can.
static inline Frame frame_from_tangent(Vec3 n, Vec3 tangent)
{
    Vec3 s = add_scaled(tangent, n, -dot(tangent, n));
    double l = length_squared(s);
    if (!(l > 1e-24 * length_squared(tangent))) {
        return frame_from_normal(n);
    }
    s = scale(s, 1 / sqrt(l));
    return (Frame){s, cross(n, s), n};
}
static inline Vec3 to_local(const Frame *f, Vec3 v)
{
    return vec3(dot(v, f->s), dot(v, f->t), dot(v, f->n));
}
static inline Vec3 from_local(const Frame *f, Vec3 v)
{
    return add(add(scale(f->s, v.x), scale(f->t, v.y)), scale(f->n, v.z));
}

// The numbers read one by one. Compilers read two neighbours at once where they can; but if they
// were stored one by one shortly before, the processor has to wait until both are in its cache.
static inline double read_alone(const double *from)
{
#if defined(__x86_64__)
    double x;
    __asm__("movsd %1, %0" : "=x"(x) : "m"(*from));
    return x;
#else
    return *from;
#endif
}
static inline Vec3 vec3_apart(const Vec3 *a)
{
    return vec3(read_alone(&a->x), read_alone(&a->y), read_alone(&a->z));
}

static inline Rgb rgb(float r, float g, float b)
{
    return (Rgb){r, g, b};
}
static inline Rgb rgb_gray(float v)
{
    return (Rgb){v, v, v};
}
static inline Rgb rgb_add(Rgb a, Rgb b)
{
    return (Rgb){a.r + b.r, a.g + b.g, a.b + b.b};
}
static inline Rgb rgb_mul(Rgb a, Rgb b)
{
    return (Rgb){a.r * b.r, a.g * b.g, a.b * b.b};
}
static inline Rgb rgb_scale(Rgb a, float s)
{
    return (Rgb){a.r * s, a.g * s, a.b * s};
}
// a (1 - t) + b t.
static inline Rgb rgb_lerp(Rgb a, Rgb b, float t)
{
    return (Rgb){a.r + t * (b.r - a.r), a.g + t * (b.g - a.g), a.b + t * (b.b - a.b)};
}
static inline float rgb_max(Rgb a)
{
    const float rg = a.r > a.g ? a.r : a.g;
    return rg > a.b ? rg : a.b;
}
static inline bool rgb_is_black(Rgb a)
{
    // By their bits but for the signs: three comparisons of floats would be six branches.
    uint32_t r, g, b;
    memcpy(&r, &a.r, sizeof r);
    memcpy(&g, &a.g, sizeof g);
    memcpy(&b, &a.b, sizeof b);
    return (r | g | b) << 1 == 0;
}
static inline bool rgb_is_finite(Rgb a)
{
    return isfinite(a.r) && isfinite(a.g) && isfinite(a.b);
}
// Relative luminance (Rec.709 primaries).
static inline float luminance(Rgb a)
{
    return 0.2126f * a.r + 0.7152f * a.g + 0.0722f * a.b;
}

static inline Affine affine_identity(void)
{
    return (Affine){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}
static inline Vec3 transform_point(const Affine *a, Vec3 p)
{
    return vec3(a->m[0][0] * p.x + a->m[0][1] * p.y + a->m[0][2] * p.z + a->m[0][3],
                a->m[1][0] * p.x + a->m[1][1] * p.y + a->m[1][2] * p.z + a->m[1][3],
                a->m[2][0] * p.x + a->m[2][1] * p.y + a->m[2][2] * p.z + a->m[2][3]);
}
static inline Vec3 transform_vector(const Affine *a, Vec3 v)
{
    return vec3(a->m[0][0] * v.x + a->m[0][1] * v.y + a->m[0][2] * v.z,
                a->m[1][0] * v.x + a->m[1][1] * v.y + a->m[1][2] * v.z,
                a->m[2][0] * v.x + a->m[2][1] * v.y + a->m[2][2] * v.z);
}
// The transpose of the linear part applied to v: with the inverse map it carries normals.
static inline Vec3 transform_transposed(const Affine *a, Vec3 v)
{
    return vec3(a->m[0][0] * v.x + a->m[1][0] * v.y + a->m[2][0] * v.z,
                a->m[0][1] * v.x + a->m[1][1] * v.y + a->m[2][1] * v.z,
                a->m[0][2] * v.x + a->m[1][2] * v.y + a->m[2][2] * v.z);
}
// a after b: (a b)(p) = a(b(p)).
Affine affine_multiply(const Affine *a, const Affine *b);
double affine_determinant(const Affine *a);
// False when the map is singular (or not finite); *out is then untouched.
bool affine_inverse(const Affine *a, Affine *out);
Affine affine_translation(Vec3 by);
Affine affine_scaling(Vec3 by);
// A rotation by `angle` radians about the axis through the origin (Rodrigues), counter-clockwise
// seen against the axis; axis need not be of unit length but must not be zero.
Affine affine_rotation(Vec3 axis, double angle);
// A map whose -z axis looks from `eye` towards `target`, +y as near to up as can be: a camera's own
// frame to the world. False when eye = target or up is parallel.
bool affine_look_at(Vec3 eye, Vec3 target, Vec3 up, Affine *out);
bool affine_is_identity(const Affine *a);

static inline Box3 box3_empty(void)
{
    return (Box3){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}
static inline Box3 box3_add(Box3 b, Vec3 p)
{
    return (Box3){{lesser(b.min.x, p.x), lesser(b.min.y, p.y), lesser(b.min.z, p.z)},
                  {greater(b.max.x, p.x), greater(b.max.y, p.y), greater(b.max.z, p.z)}};
}
static inline Box3 box3_union(Box3 a, Box3 b)
{
    // Not the corners of b one by one: those of an empty box are infinite on the wrong sides.
    return (Box3){
        {lesser(a.min.x, b.min.x), lesser(a.min.y, b.min.y), lesser(a.min.z, b.min.z)},
        {greater(a.max.x, b.max.x), greater(a.max.y, b.max.y), greater(a.max.z, b.max.z)}};
}
static inline bool box3_is_empty(Box3 b)
{
    return !(b.min.x <= b.max.x && b.min.y <= b.max.y && b.min.z <= b.max.z);
}
static inline bool box3_equal(Box3 a, Box3 b)
{
    return a.min.x == b.min.x && a.min.y == b.min.y && a.min.z == b.min.z && a.max.x == b.max.x &&
           a.max.y == b.max.y && a.max.z == b.max.z;
}
// Corner 0 to 7: bits 0 to 2 say where x, y and z are the greatest.
static inline Vec3 box3_corner(Box3 b, int corner)
{
    return vec3(corner & 1 ? b.max.x : b.min.x, corner & 2 ? b.max.y : b.min.y,
                corner & 4 ? b.max.z : b.min.z);
}
static inline Vec3 box3_center(Box3 b)
{
    return scale(add(b.min, b.max), 0.5);
}
// The box of the eight mapped corners.
Box3 transform_box(const Affine *a, Box3 box);

#endif
