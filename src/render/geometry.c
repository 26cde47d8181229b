#include "render/geometry.h"

#include <string.h>

Affine affine_cofactors(const Affine *a)
{
    Affine out;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            int r0 = (i + 1) % 3, r1 = (i + 2) % 3, c0 = (j + 1) % 3, c1 = (j + 2) % 3;
            out.m[i][j] = a->m[r0][c0] * a->m[r1][c1] - a->m[r0][c1] * a->m[r1][c0];
        }
        out.m[i][3] = 0;
    }
    return out;
}

Vec3 map_normal(const Affine *cofactors, bool mirrored, Vec3 normal)
{
    Vec3 n = normalize(transform_vector(cofactors, normal));
    return mirrored ? neg(n) : n;
}

bool affine_is_similarity(const Affine *a, double *scale_out)
{
    Vec3 x = vec3(a->m[0][0], a->m[1][0], a->m[2][0]);
    Vec3 y = vec3(a->m[0][1], a->m[1][1], a->m[2][1]);
    Vec3 z = vec3(a->m[0][2], a->m[1][2], a->m[2][2]);
    double s = length_squared(x), tolerance = 1e-9 * s;
    *scale_out = sqrt(s);
    return s > 0 && fabs(length_squared(y) - s) <= tolerance &&
           fabs(length_squared(z) - s) <= tolerance && fabs(dot(x, y)) <= tolerance &&
           fabs(dot(y, z)) <= tolerance && fabs(dot(z, x)) <= tolerance;
}

double affine_stretch(const Affine *a)
{
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            sum += a->m[i][j] * a->m[i][j];
        }
    }
    return sqrt(sum);
}

// |M| |p| + |t|: what the rounding errors of transform_point are proportional to.
static Vec3 absolute_map(const Affine *a, Vec3 p)
{
    double out[3];
    for (int i = 0; i < 3; ++i) {
        out[i] = fabs(a->m[i][0]) * fabs(p.x) + fabs(a->m[i][1]) * fabs(p.y) +
                 fabs(a->m[i][2]) * fabs(p.z) + fabs(a->m[i][3]);
    }
    return vec3(out[0], out[1], out[2]);
}

static bool is_smooth(const ShapePoint *point)
{
    const Vec3 a = point->geometric, b = point->shading;
    return a.x != b.x || a.y != b.y || a.z != b.z;
}

void shape_point_map(const Affine *to_world, ShapePoint *point)
{
    Affine cofactors = affine_cofactors(to_world);
    bool mirrored = affine_determinant(to_world) < 0;
    double rounding = 4 * ROUNDING * max_component(absolute_map(to_world, point->p));
    point->p = transform_point(to_world, point->p);
    point->error = affine_stretch(to_world) * point->error + rounding;
    bool smooth = is_smooth(point);
    point->geometric = map_normal(&cofactors, mirrored, point->geometric);
    point->shading = smooth ? map_normal(&cofactors, mirrored, point->shading) : point->geometric;
    point->tangent = transform_vector(to_world, point->tangent);
    point->bitangent = transform_vector(to_world, point->bitangent);
}

static double largest_row(const double m[3][4])
{
    double most = 0;
    for (int i = 0; i < 3; ++i) {
        most = larger(most, fabs(m[i][0]) + fabs(m[i][1]) + fabs(m[i][2]));
    }
    return most;
}

SpaceMap space_map(const Affine *a, const Affine *inverse)
{
    SpaceMap map = {.normals = affine_cofactors(a), .stretch = affine_stretch(a)};
    if (affine_determinant(a) < 0) {
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                map.normals.m[i][j] = -map.normals.m[i][j];
            }
        }
    }
    // |M| |M^-1| and |M| |t'|, t' the inverse's translation.
    double both[3][4] = {{0}}, shift = 0, back = 0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 4; ++j) {
            for (int k = 0; k < 3; ++k) {
                both[i][j] += fabs(a->m[i][k]) * fabs(inverse->m[k][j]);
            }
        }
        shift = larger(shift, fabs(a->m[i][3]));
        back = larger(back, both[i][3]);
    }
    // Of the way there, each product and sum is rounded, and the entries of `inverse` are, too,
    // which counts like another rounding; of the way back, the map itself and one estimate more.
    map.after = 8 * ROUNDING * largest_row((const double(*)[4])both);
    map.before = 8 * ROUNDING * largest_row(a->m);
    map.fixed = 8 * ROUNDING * (back + shift);
    return map;
}

void space_map_point(const SpaceMap *map, const Affine *a, ShapePoint *point)
{
    const Vec3 p = transform_point(a, point->p);
    point->error = map->stretch * point->error + map->fixed + map->before * max_abs(point->p) +
                   map->after * max_abs(p);
    point->p = p;
    const bool smooth = is_smooth(point);
    point->geometric = normalize(transform_vector(&map->normals, point->geometric));
    point->shading =
        smooth ? normalize(transform_vector(&map->normals, point->shading)) : point->geometric;
    point->tangent = transform_vector(a, point->tangent);
    point->bitangent = transform_vector(a, point->bitangent);
}

// splitmix64 (Steele, Lea, Flood 2014)
static uint64_t mix(uint64_t x)
{
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

Rejection rejection_begin(double u0, double u1, double u2)
{
    uint64_t bits[3];
    memcpy(&bits[0], &u0, 8);
    memcpy(&bits[1], &u1, 8);
    memcpy(&bits[2], &u2, 8);
    return (Rejection){mix(bits[0] ^ mix(bits[1] ^ mix(bits[2])))};
}

double rejection_next(Rejection *rejection)
{
    rejection->state += 0x9e3779b97f4a7c15u;
    return (double)(mix(rejection->state) >> 11) * 0x1p-53;
}

// R_F and R_D by duplication, then R_G from both (DLMF 19.21.10). x, y, z sorted so that z > 0.
double carlson_rg(double x, double y, double z)
{
    double big = fmax(x, fmax(y, z));
    if (!(big > 0)) {
        return 0;
    }
    // z the middle one keeps the two terms of the sum below from cancelling.
    double small = fmin(x, fmin(y, z)), middle = x + y + z - big - small;
    x = small, y = big, z = fmax(middle, 0);
    if (!(z > 0)) {
        return sqrt(big) / 2; // R_G(0, 0, c)
    }
    double ax = x, ay = y, az = z, sum = 0, factor = 1;
    for (int i = 0; i < 40; ++i) {
        double rx = sqrt(ax), ry = sqrt(ay), rz = sqrt(az);
        double lambda = rx * (ry + rz) + ry * rz;
        sum += factor / (rz * (az + lambda));
        factor /= 4;
        ax = (ax + lambda) / 4;
        ay = (ay + lambda) / 4;
        az = (az + lambda) / 4;
        if (fmax(ax, fmax(ay, az)) - fmin(ax, fmin(ay, az)) < 1e-4 * az) {
            break;
        }
    }
    // R_F: Taylor about the mean.
    double mean = (ax + ay + az) / 3;
    double dx = 1 - ax / mean, dy = 1 - ay / mean, dz = -(dx + dy);
    double e2 = dx * dy - dz * dz, e3 = dx * dy * dz;
    double rf = (1 + (e2 / 24 - 0.1 - 3 * e3 / 44) * e2 + e3 / 14) / sqrt(mean);
    // R_D: the mean weighs z three times.
    mean = (ax + ay + 3 * az) / 5;
    dx = (mean - ax) / mean, dy = (mean - ay) / mean, dz = (mean - az) / mean;
    double ea = dx * dy, eb = dz * dz, ec = ea - eb, ed = ea - 6 * eb, ee = ed + ec + ec;
    double rd =
        3 * sum + factor *
                      (1 + ed * (-3.0 / 14 + 0.25 * 9.0 / 22 * ed - 1.5 * 3.0 / 26 * dz * ee) +
                       dz * (ee / 6 + dz * (-9.0 / 22 * ec + dz * 3.0 / 26 * ea))) /
                      (mean * sqrt(mean));
    return (z * rf - (x - z) * (y - z) * rd / 3 + sqrt(x * y / z)) / 2;
}

Vec3 affine_gram_eigenvalues(const Affine *a)
{
    double g[3][3];
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            g[i][j] = a->m[0][i] * a->m[0][j] + a->m[1][i] * a->m[1][j] + a->m[2][i] * a->m[2][j];
        }
    }
    for (int sweep = 0; sweep < 12; ++sweep) {
        for (int p = 0; p < 2; ++p) {
            for (int q = p + 1; q < 3; ++q) {
                if (g[p][q] == 0) {
                    continue;
                }
                // The rotation that makes g[p][q] zero (Golub, Van Loan, 8.5).
                double tau = (g[q][q] - g[p][p]) / (2 * g[p][q]);
                double t = copysign(1 / (fabs(tau) + sqrt(1 + tau * tau)), tau);
                double c = 1 / sqrt(1 + t * t), s = t * c;
                for (int k = 0; k < 3; ++k) {
                    double kp = g[k][p], kq = g[k][q];
                    g[k][p] = c * kp - s * kq;
                    g[k][q] = s * kp + c * kq;
                }
                for (int k = 0; k < 3; ++k) {
                    double pk = g[p][k], qk = g[q][k];
                    g[p][k] = c * pk - s * qk;
                    g[q][k] = s * pk + c * qk;
                }
            }
        }
    }
    return vec3(fmax(g[0][0], 0), fmax(g[1][1], 0), fmax(g[2][2], 0));
}
