#include "render/geometry.h"

typedef struct Box {
    Vec3 min, max;
    Vec3 center, size;
} Box;

enum { BOX_MIN, BOX_MAX, BOX_CENTER, BOX_SIZE };

static const Param box_params[] = {
    {.name = "min",
     .type = PARAM_VEC3,
     PARAM_AT(Box, min),
     .flags = PARAM_NO_DEFAULT,
     .dims = DIM_BIT(DIM_LENGTH),
     .doc = "The corner with the smallest coordinates; with `max`."},
    {.name = "max",
     .type = PARAM_VEC3,
     PARAM_AT(Box, max),
     .flags = PARAM_NO_DEFAULT,
     .dims = DIM_BIT(DIM_LENGTH),
     .doc = "The corner with the largest coordinates; with `min`."},
    {.name = "center",
     .type = PARAM_VEC3,
     PARAM_AT(Box, center),
     .flags = PARAM_NO_DEFAULT,
     .dims = DIM_BIT(DIM_LENGTH),
     .doc = "The middle; with `size`, and then (0, 0, 0) where it is left out."},
    {.name = "size",
     .type = PARAM_VEC3,
     PARAM_AT(Box, size),
     .flags = PARAM_NO_DEFAULT | PARAM_EXCLUDE_MIN,
     .dims = DIM_BIT(DIM_LENGTH),
     .min = 0,
     .max = INFINITY,
     .doc = "The lengths of the edges along x, y and z."},
};

static const char axis_names[] = "xyz";

static bool box_is_sound(NodeFinish *finish, const Box *box)
{
    for (int axis = 0; axis < 3; ++axis) {
        double low = vec3_get(box->min, axis), high = vec3_get(box->max, axis);
        if (low > high) {
            finish->report(finish, BOX_MAX, E0803, "%c of `max` is %g, less than %g of `min`",
                           axis_names[axis], high, low);
            return false;
        }
        if (!(low < high)) {
            finish->report(finish, BOX_MAX, E0801,
                           "the box is flat along %c: `min` and `max` are equal", axis_names[axis]);
            return false;
        }
    }
    return true;
}

// Both ways of writing a box end as all four fields.
static bool box_finish(NodeFinish *finish)
{
    Box *box = finish->params;
    bool has[4];
    for (int i = 0; i < 4; ++i) {
        has[i] = finish->set >> i & 1;
    }
    bool corners = has[BOX_MIN] && has[BOX_MAX] && !has[BOX_CENTER] && !has[BOX_SIZE];
    bool middle = has[BOX_SIZE] && !has[BOX_MIN] && !has[BOX_MAX];
    if (!corners && !middle) {
        finish->report(finish, -1, E0804, "a box takes `min` and `max`, or `center` and `size`");
        return false;
    }
    if (middle) {
        if (!has[BOX_CENTER]) {
            box->center = vec3(0, 0, 0);
        }
        Vec3 half = scale(box->size, 0.5);
        box->min = sub(box->center, half);
        box->max = add(box->center, half);
        if (!(box->min.x < box->max.x && box->min.y < box->max.y && box->min.z < box->max.z)) {
            finish->report(finish, BOX_SIZE, E0801,
                           "the box is flat: its size is lost in the rounding of its center");
            return false;
        }
        return true;
    }
    box->center = box3_center((Box3){box->min, box->max});
    box->size = sub(box->max, box->min);
    return box_is_sound(finish, box);
}

static Box3 box_bounds(const Scene *scene, const void *params)
{
    (void)scene;
    const Box *box = params;
    return (Box3){box->min, box->max};
}

// The faces are numbered -x, +x, -y, +y, -z, +z.
static bool box_intersect(const void *params, const Ray *ray, ShapeHit *hit)
{
    const Box *box = params;
    const double origin[3] = {ray->origin.x, ray->origin.y, ray->origin.z};
    const double direction[3] = {ray->direction.x, ray->direction.y, ray->direction.z};
    const double low[3] = {box->min.x, box->min.y, box->min.z};
    const double high[3] = {box->max.x, box->max.y, box->max.z};
    double enter = -INFINITY, leave = INFINITY;
    uint32_t enter_face = 0, leave_face = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        double o = origin[axis], d = direction[axis];
        if (d == 0) {
            if (o < low[axis] || o > high[axis]) {
                return false;
            }
            continue;
        }
        double inverse = 1 / d;
        double a = ((d > 0 ? low : high)[axis] - o) * inverse;
        double b = ((d > 0 ? high : low)[axis] - o) * inverse;
        if (a > enter) {
            enter = a;
            enter_face = 2 * axis + (d < 0);
        }
        if (b < leave) {
            leave = b;
            leave_face = 2 * axis + (d > 0);
        }
    }
    if (!(enter <= leave)) {
        return false;
    }
    bool first = enter > ray->tmin;
    *hit = (ShapeHit){.t = first ? enter : leave, .primitive = first ? enter_face : leave_face};
    return hit->t > ray->tmin && hit->t < ray->tmax;
}

typedef struct BoxFace {
    Vec3 corner, u, v; // u x v points outwards
} BoxFace;

static BoxFace box_face(const Box *box, uint32_t face)
{
    Vec3 a = box->min, b = box->max, s = sub(b, a);
    switch (face) {
    case 0:
        return (BoxFace){a, vec3(0, 0, s.z), vec3(0, s.y, 0)};
    case 1:
        return (BoxFace){vec3(b.x, a.y, b.z), vec3(0, 0, -s.z), vec3(0, s.y, 0)};
    case 2:
        return (BoxFace){a, vec3(s.x, 0, 0), vec3(0, 0, s.z)};
    case 3:
        return (BoxFace){vec3(a.x, b.y, b.z), vec3(s.x, 0, 0), vec3(0, 0, -s.z)};
    case 4:
        return (BoxFace){vec3(b.x, a.y, a.z), vec3(-s.x, 0, 0), vec3(0, s.y, 0)};
    default:
        return (BoxFace){vec3(a.x, a.y, b.z), vec3(s.x, 0, 0), vec3(0, s.y, 0)};
    }
}

static void box_point_at(const Box *box, uint32_t face, double u, double v, ShapePoint *out)
{
    BoxFace f = box_face(box, face);
    Vec3 p = add_scaled(add_scaled(f.corner, f.u, u), f.v, v);
    // Onto the face exactly, whatever the sum above was rounded to.
    double at = vec3_get(face & 1 ? box->max : box->min, (int)face / 2);
    *(face / 2 == 0 ? &p.x : face / 2 == 1 ? &p.y : &p.z) = at;
    Vec3 n = vec3(0, 0, 0);
    *(face / 2 == 0 ? &n.x : face / 2 == 1 ? &n.y : &n.z) = face & 1 ? 1 : -1;
    *out = (ShapePoint){.p = p,
                        .geometric = n,
                        .shading = n,
                        .tangent = f.u,
                        .bitangent = f.v,
                        .uv = {u, v},
                        .color = {1, 1, 1},
                        .error = rounding_error(fmax(max_abs(box->min), max_abs(box->max)))};
}

static void box_point(const Scene *scene, const void *params, const Ray *ray, const ShapeHit *hit,
                      ShapePoint *out)
{
    (void)scene;
    const Box *box = params;
    BoxFace f = box_face(box, hit->primitive);
    Vec3 from = add_scaled(sub(ray->origin, f.corner), ray->direction, hit->t);
    double u = dot(from, f.u) / length_squared(f.u), v = dot(from, f.v) / length_squared(f.v);
    box_point_at(box, hit->primitive, fmin(fmax(u, 0), 1), fmin(fmax(v, 0), 1), out);
}

// Areas of the pairs of faces along x, y, z in the world.
static Vec3 box_areas(const Box *box, const Affine *to_world)
{
    Affine c = affine_cofactors(to_world);
    Vec3 s = sub(box->max, box->min);
    return scale(vec3(s.y * s.z * length(vec3(c.m[0][0], c.m[1][0], c.m[2][0])),
                      s.z * s.x * length(vec3(c.m[0][1], c.m[1][1], c.m[2][1])),
                      s.x * s.y * length(vec3(c.m[0][2], c.m[1][2], c.m[2][2]))),
                 2);
}

static double box_area(const Scene *scene, const void *params, const Affine *to_world)
{
    (void)scene;
    Vec3 areas = box_areas(params, to_world);
    return areas.x + areas.y + areas.z;
}

static void box_sample_area(const Scene *scene, const void *params, const Affine *to_world,
                            const void *table, double u0, double u1, double u2, ShapeSample *out)
{
    (void)scene;
    (void)table;
    Vec3 areas = box_areas(params, to_world);
    double total = areas.x + areas.y + areas.z, at = u2 * total;
    uint32_t axis = at < areas.x ? 0 : at < areas.x + areas.y ? 1 : 2;
    double within = at - (axis > 0 ? areas.x : 0) - (axis > 1 ? areas.y : 0);
    out->primitive = 2 * axis + (within >= vec3_get(areas, (int)axis) / 2);
    box_point_at(params, out->primitive, u0, u1, &out->point);
    shape_point_map(to_world, &out->point);
    out->pdf = 1 / total;
}

const ShapeClass box_shape = {
    .node = {.name = "box",
             .category = CATEGORY_SHAPE,
             .params = box_params,
             .param_count = sizeof box_params / sizeof *box_params,
             .size = sizeof(Box),
             .doc = "A box along the axes, by two opposite corners or by its middle and its size. "
                    "Each face has its own uv from 0 to 1, upright on the sides.",
             .formula =
                 "min <= p <= max, by the slab method in double precision (Kay, Kajiya 1986)",
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: "
                        "(0, 0, 1.5) }, radiance: 12 }\n"
                        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], "
                        "space: \"uv\" } }\n"
                        "plane { material: lambert { color: gray(0.5) } }\n"
                        "let clay = lambert { color: #c0704a }\n"
                        "box { center: (-0.6, 0.4, 0), size: (0.8, 0.8, 0.8), material: clay }\n"
                        "box {\n"
                        "  min: (-0.5, 0, -0.2), max: (0.5, 0.3, 0.2), material: clay\n"
                        "  transform: [rotate_y(30deg), translate(0.6, 0, 0.2)]\n"
                        "}",
             .finish = box_finish,
             .bounds = box_bounds},
    .holding = HOLD_USER,
    .closed = shape_is_closed,
    .intersect = box_intersect,
    .point = box_point,
    .area = box_area,
    .sample_area = box_sample_area,
};
