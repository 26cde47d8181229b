#include "base/vec.h"

Affine affine_multiply(const Affine *a, const Affine *b)
{
    Affine out;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 4; ++j) {
            out.m[i][j] = a->m[i][0] * b->m[0][j] + a->m[i][1] * b->m[1][j] +
                          a->m[i][2] * b->m[2][j] + (j == 3 ? a->m[i][3] : 0);
        }
    }
    return out;
}

double affine_determinant(const Affine *a)
{
    return a->m[0][0] * (a->m[1][1] * a->m[2][2] - a->m[1][2] * a->m[2][1]) -
           a->m[0][1] * (a->m[1][0] * a->m[2][2] - a->m[1][2] * a->m[2][0]) +
           a->m[0][2] * (a->m[1][0] * a->m[2][1] - a->m[1][1] * a->m[2][0]);
}

bool affine_inverse(const Affine *a, Affine *out)
{
    double determinant = affine_determinant(a);
    if (!isfinite(determinant) || determinant == 0 || !isfinite(1 / determinant)) {
        return false;
    }
    double d = 1 / determinant;
    Affine inverse;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            int r0 = (j + 1) % 3, r1 = (j + 2) % 3, c0 = (i + 1) % 3, c1 = (i + 2) % 3;
            inverse.m[i][j] = (a->m[r0][c0] * a->m[r1][c1] - a->m[r0][c1] * a->m[r1][c0]) * d;
        }
        inverse.m[i][3] = 0;
    }
    Vec3 moved = transform_vector(&inverse, vec3(a->m[0][3], a->m[1][3], a->m[2][3]));
    inverse.m[0][3] = -moved.x;
    inverse.m[1][3] = -moved.y;
    inverse.m[2][3] = -moved.z;
    *out = inverse;
    return true;
}

Affine affine_translation(Vec3 by)
{
    return (Affine){{{1, 0, 0, by.x}, {0, 1, 0, by.y}, {0, 0, 1, by.z}}};
}

Affine affine_scaling(Vec3 by)
{
    return (Affine){{{by.x, 0, 0, 0}, {0, by.y, 0, 0}, {0, 0, by.z, 0}}};
}

Affine affine_rotation(Vec3 axis, double angle)
{
    Vec3 u = normalize(axis);
    double c = cos(angle), s = sin(angle), k = 1 - c;
    return (Affine){{{c + u.x * u.x * k, u.x * u.y * k - u.z * s, u.x * u.z * k + u.y * s, 0},
                     {u.y * u.x * k + u.z * s, c + u.y * u.y * k, u.y * u.z * k - u.x * s, 0},
                     {u.z * u.x * k - u.y * s, u.z * u.y * k + u.x * s, c + u.z * u.z * k, 0}}};
}

bool affine_look_at(Vec3 eye, Vec3 target, Vec3 up, Affine *out)
{
    Vec3 back = sub(eye, target), right = cross(up, back);
    if (!(length_squared(back) > 0) ||
        !(length_squared(right) > 1e-24 * length_squared(up) * length_squared(back))) {
        return false;
    }
    back = normalize(back);
    right = normalize(right);
    Vec3 top = cross(back, right);
    *out = (Affine){{{right.x, top.x, back.x, eye.x},
                     {right.y, top.y, back.y, eye.y},
                     {right.z, top.z, back.z, eye.z}}};
    return true;
}

bool affine_is_identity(const Affine *a)
{
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 4; ++j) {
            if (a->m[i][j] != (i == j)) {
                return false;
            }
        }
    }
    return true;
}

// Where infinities meet, corner by corner.
static Box3 transform_corners(const Affine *a, Box3 box)
{
    Box3 out = box3_empty();
    for (int corner = 0; corner < 8; ++corner) {
        out = box3_add(out, transform_point(a, box3_corner(box, corner)));
    }
    return out;
}

Box3 transform_box(const Affine *a, Box3 box)
{
    const double lower[3] = {box.min.x, box.min.y, box.min.z};
    const double upper[3] = {box.max.x, box.max.y, box.max.z};
    double least[3], most[3];
    bool finite = true;
    for (int row = 0; row < 3; ++row) {
        double from[3], to[3];
        for (int column = 0; column < 3; ++column) {
            const double x = a->m[row][column] * lower[column];
            const double y = a->m[row][column] * upper[column];
            from[column] = lesser(x, y);
            to[column] = greater(x, y);
        }
        // In the order of transform_point, and rounding keeps order: what the least and the
        // greatest of the corners have.
        least[row] = from[0] + from[1] + from[2] + a->m[row][3];
        most[row] = to[0] + to[1] + to[2] + a->m[row][3];
        finite = finite && isfinite(least[row]) && isfinite(most[row]);
    }
    return finite ? (Box3){vec3(least[0], least[1], least[2]), vec3(most[0], most[1], most[2])}
                  : transform_corners(a, box);
}
