// The table of flat pieces of surface, and tests of pieces in double precision; see accel_parts.h.
#include "base/mem.h"
#include "render/accel_meet.h"
#include "render/geometry.h"
#include "render/shapes/mesh.h"

#include <stdlib.h>

// --- Meeting -------------------------------------------------------------------------------------

// The corner across from `corner`, where both other edges meet, in s and t.
static Vec2 far_corner(const AccelFlat *flat)
{
    const double apart = 1 / (1 - flat->over_s * flat->over_t);
    return (Vec2){(1 - flat->over_s) * apart, (1 - flat->over_t) * apart};
}

bool accel_pull_inside(const AccelFlat *flat, Vec3 from, Meeting *met)
{
    // Less than by how much rays are offset, which would meet the edges of neighbours otherwise.
    if (!(met->least >= -(flat->error + 4 * ROUNDING * max_abs(from)) * flat->steep)) {
        return false;
    }
    const double s = larger(met->s, 0), t = larger(met->t, 0);
    const double over = larger(s + flat->over_s * t, t + flat->over_t * s);
    met->s = s / larger(1, over);
    met->t = t / larger(1, over);
    return true;
}

bool accel_meet_flat(const Accel *accel, uint32_t number, const Ray *ray, uint32_t instance,
                     Hit *hit)
{
    const AccelFlat *flat = &accel->flats[number];
    Meeting met;
    if (!meet(flat, ray, ray->tmax, false, &met)) {
        return false;
    }
    complete_hit(flat, number, &met, instance, hit);
    return true;
}

ShapeHit accel_primitive_hit(const AccelFlat *flat, const ShapeHit *hit)
{
    ShapeHit out = *hit;
    if (flat->pair) {
        const Vec2 far = far_corner(flat);
        const bool second = hit->u * far.y < hit->v * far.x;
        const double along = second ? hit->u / far.x : hit->v / far.y; // the diagonal
        out.primitive += second;
        out.u = second ? along : hit->u - along * far.x;
        out.v = second ? hit->v - along * far.y : along;
    }
    return out;
}

void accel_complete_hit(const Accel *accel, Hit *hit)
{
    const AccelFlat *flat = &accel->flats[hit->flat - 1];
    Meeting met = {.distance = hit->t, .s = hit->local.u, .t = hit->local.v};
    if (flat->pair) {
        const Vec2 far = far_corner(flat);
        const bool second = hit->local.primitive != flat->primitive;
        const double along = second ? met.s : met.t, beside = second ? met.t : met.s;
        met.s = along * far.x + (second ? 0 : beside);
        met.t = along * far.y + (second ? beside : 0);
    }
    met.least = least_inside(flat, met.s, met.t);
    complete_hit(flat, hit->flat - 1, &met, hit->instance, hit);
}

bool accel_meet_mesh(const AccelKind *kind, uint32_t triangle, const Ray *ray, uint32_t instance,
                     Hit *hit)
{
    const Ray local = kind->transform == 0
                          ? *ray
                          : ray_map(&kind->accel->scene->inverses.items[kind->transform], ray);
    const Mesh *mesh = kind->mesh;
    const uint32_t *index = mesh->triangles + 3 * (size_t)triangle;
    const Vec3 a = mesh_vertex(mesh, index[0]);
    const Vec3 eu = sub(mesh_vertex(mesh, index[1]), a), ev = sub(mesh_vertex(mesh, index[2]), a);
    const Vec3 normal = cross(eu, ev), from = sub(a, local.origin);
    const double t = dot(normal, from) / dot(normal, local.direction);
    const Vec3 at = sub(scale(local.direction, t), from);
    const double nn = length_squared(normal);
    const double u = dot(cross(at, ev), normal) / nn, v = dot(cross(eu, at), normal) / nn;
    if (!(t > ray->tmin && t < ray->tmax && u >= 0 && v >= 0 && u + v <= 1)) {
        return false;
    }
    hit->t = t;
    hit->shape = kind->ids[0];
    hit->instance = instance;
    hit->local = (ShapeHit){.t = t, .primitive = triangle, .u = u, .v = v};
    hit->flat = kind->first + triangle + 1;
    // Distances from the edges: u |normal| / |ev| and so on.
    const double uu = length_squared(eu), vv = length_squared(ev);
    const double ww = length_squared(sub(ev, eu)), w = 1 - u - v;
    const double inset = kind->inset * kind->inset;
    hit->inside = u * u * nn > inset * vv && v * v * nn > inset * uu && w * w * nn > inset * ww &&
                  nn > LIFT_LEAST_SINE * LIFT_LEAST_SINE * uu * vv;
    return true;
}

// --- Making pieces -------------------------------------------------------------------------------

// What follows from corner, u, v, over_s and over_t. False where there is no area.
static bool complete(AccelFlat *flat, double scale_of_group)
{
    const Vec3 normal = cross(flat->u, flat->v);
    const double nn = length_squared(normal);
    if (!(nn > 0)) {
        return false;
    }
    const Vec3 s = scale(cross(flat->v, normal), 1 / nn), t = scale(cross(normal, flat->u), 1 / nn);
    flat->along_u = s;
    flat->along_v = t;
    flat->steep =
        larger(larger(length(s), length(t)), larger(length(add_scaled(s, t, flat->over_s)),
                                                    length(add_scaled(t, s, flat->over_t))));
    flat->inset = (float)(FLAT_INSET * scale_of_group * flat->steep);
    // Embree takes its plane from a corner.
    const double uu = length_squared(flat->u), vv = length_squared(flat->v);
    if (!(nn > LIFT_LEAST_SINE * LIFT_LEAST_SINE * uu * vv)) {
        flat->inset = INFINITY;
    }
    return true;
}

// The piece that is a primitive of a shape; false where it has no area.
static bool make_flat(const AccelKind *kind, uint32_t shape, uint32_t primitive, bool four,
                      AccelFlat *out)
{
    const Scene *scene = kind->accel->scene;
    const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, shape);
    ShapePoint at[3];
    for (int i = 0; i < 3; ++i) {
        const ShapeHit hit = {.primitive = primitive, .u = i == 1, .v = i == 2};
        kind->class->point(scene, scene_params(scene, node), NULL, &hit, &at[i]);
        if (node->transform) {
            accel_map_out(kind->accel, node->transform, &at[i]);
        }
    }
    const Vec3 u = sub(at[1].p, at[0].p), v = sub(at[2].p, at[0].p);
    const double error = larger(larger(at[0].error, at[1].error), at[2].error);
    *out = (AccelFlat){
        .corner = at[0].p,
        .u = u,
        .v = v,
        .normal = at[0].geometric,
        .over_s = !four,
        .over_t = !four,
        .error = error + rounding_error(max_abs(at[0].p) + max_abs(u) + max_abs(v)),
        .kind = kind,
        .shape = shape,
        .primitive = primitive,
        .four = four,
        .material = accel_node_material(node, NULL),
        .lamp = node->flags & NODE_LIGHT_ONLY,
        .smooth = kind->mesh && kind->mesh->normals,
    };
    return complete(out, kind->group->scale);
}

// Makes one piece of triangles a b c and a c d if they lie in one plane and their union is convex.
static bool join(const AccelFlat *first, const AccelFlat *second, double scale_of_group,
                 AccelFlat *out)
{
    *out = *first;
    out->v = second->v; // to d
    out->over_s = out->over_t = 0;
    if (dot(first->normal, second->normal) < 0.5 || !complete(out, scale_of_group)) {
        return false;
    }
    // c in the coordinates along ab and ad.
    const double s = dot(out->along_u, first->v), t = dot(out->along_v, first->v);
    const double off = dot(first->normal, second->v);
    const bool plane = fabs(off) <= 0.5 * first->error;
    if (!plane || !(s > 0x1p-10 && t > 0x1p-10 && s + t > 1 + 0x1p-10)) {
        return false;
    }
    out->over_s = (1 - s) / t;
    out->over_t = (1 - t) / s;
    out->error = larger(first->error, second->error) + fabs(off);
    out->four = out->pair = true;
    return complete(out, scale_of_group);
}

static bool share_diagonal(const Mesh *mesh, uint32_t first)
{
    const uint32_t *index = mesh->triangles + 3 * (size_t)first;
    return first + 1 < mesh->triangle_count && index[0] == index[3] && index[2] == index[4];
}

// --- The table -----------------------------------------------------------------------------------

typedef ARRAY(AccelFlat) FlatArray;

static bool add_flat_kind(FlatArray *flats, const AccelKind *kind)
{
    for (uint32_t i = 0; i < kind->count; ++i) {
        AccelFlat flat; // without area by rounding alone: those that have none have been left out
        if (make_flat(kind, kind->ids[i], 0, kind->corners == 4, &flat) &&
            !array_push(flats, flat)) {
            return false;
        }
    }
    return true;
}

static bool add_mesh_kind(FlatArray *flats, const AccelKind *kind, AccelIssues *issues)
{
    const Mesh *mesh = kind->mesh;
    for (uint32_t i = 0; i < mesh->triangle_count; ++i) {
        AccelFlat flat[3];
        if (!make_flat(kind, kind->ids[0], i, false, &flat[0])) {
            ++issues->degenerate;
            continue;
        }
        const bool pair = share_diagonal(mesh, i) &&
                          make_flat(kind, kind->ids[0], i + 1, false, &flat[1]) &&
                          join(&flat[0], &flat[1], kind->group->scale, &flat[2]);
        i += pair;
        if (!array_push(flats, pair ? flat[2] : flat[0])) {
            return false;
        }
    }
    return true;
}

// Half the surface of a piece's box.
static double box_area(const AccelFlat *flat)
{
    Box3 box = box3_add(box3_add(box3_empty(), flat->corner), add(flat->corner, flat->u));
    box = box3_add(box, add(flat->corner, flat->v));
    const Vec3 d = sub(box.max, box.min);
    return d.x * d.y + d.y * d.z + d.z * d.x;
}

static int compare_areas(const void *a, const void *b)
{
    const AccelFlat *x = a, *y = b;
    const double ax = box_area(x), ay = box_area(y);
    if (ax != ay) {
        return ax > ay ? -1 : 1;
    }
    return x->shape != y->shape ? (x->shape > y->shape) - (x->shape < y->shape)
                                : (x->primitive > y->primitive) - (x->primitive < y->primitive);
}

static int compare_corners(const void *a, const void *b)
{
    const AccelFlat *x = a, *y = b;
    if (x->four != y->four) {
        return x->four ? -1 : 1;
    }
    return x->shape != y->shape ? (x->shape > y->shape) - (x->shape < y->shape)
                                : (x->primitive > y->primitive) - (x->primitive < y->primitive);
}

#if defined(SCN_NO_SWEEP)
enum { SWEEPS = 0 };
#else
enum { SWEEPS = 1 };
#endif

// Orders a group's pieces, from `first` on, and chooses those that are swept.
static void arrange(FlatArray *all, AccelGroup *group)
{
    AccelFlat *flats = all->items + group->first_flat;
    const size_t count = all->count - group->first_flat;
    uint32_t swept = 0;
    if (!SWEEPS) {
        qsort(flats, count, sizeof *flats, compare_corners);
    } else if (count <= SWEEP_MOST) {
        swept = (uint32_t)count;
    } else {
        qsort(flats, count, sizeof *flats, compare_areas);
        const Vec3 d = sub(group->bounds.max, group->bounds.min);
        const double least = SWEEP_AREA * (d.x * d.y + d.y * d.z + d.z * d.x);
        while (swept < SWEEP_MOST / 2 && box_area(&flats[swept]) >= least) {
            ++swept;
        }
        qsort(flats + swept, count - swept, sizeof *flats, compare_corners);
    }
    group->sweep_count = swept;
    for (uint32_t i = 0; i < swept; ++i) {
        flats[i].swept = true;
    }
    for (size_t i = swept; i < count; ++i) {
        group->quad_count += flats[i].four;
        group->triangle_count += !flats[i].four;
    }
}

static bool tabulate_group(FlatArray *all, AccelGroup *group, AccelIssues *issues)
{
    group->first_flat = (uint32_t)all->count;
    group->geometries = mem_alloc((size_t)group->kind_count + 1, sizeof(AccelKind *));
    if (!group->geometries) {
        return false;
    }
    for (uint32_t k = 0; k < group->kind_count; ++k) {
        AccelKind *kind = &group->kinds[k];
        const bool small = kind->mesh && kind->mesh->triangle_count <= TABLE_MESH &&
                           all->count + kind->mesh->triangle_count <= TABLE_COUNT;
        kind->tabled = kind->native && (small || !kind->mesh);
        if (!kind->tabled) {
            group->geometries[group->geometry_count++] = kind;
        } else if (!(kind->mesh ? add_mesh_kind(all, kind, issues) : add_flat_kind(all, kind))) {
            return false;
        }
    }
    if (all->count > group->first_flat) {
        arrange(all, group);
    }
    return all->count < NONE_ID / 2;
}

// Numbers the triangles of meshes outside the table after its pieces. False where they are too
// many.
static bool number_meshes(Accel *accel)
{
    uint64_t next = accel->flat_count;
    for (uint32_t g = 0; g < accel->group_count; ++g) {
        AccelGroup *group = &accel->groups[g];
        group->first_mesh = (uint32_t)next;
        for (uint32_t k = 0; k < group->kind_count; ++k) {
            AccelKind *kind = &group->kinds[k];
            if (!kind->mesh || kind->tabled) {
                continue;
            }
            kind->first = (uint32_t)next;
            next += kind->mesh->triangle_count;
            // What stretches most on the way to the mesh's space.
            const Affine *inverse = &accel->scene->inverses.items[kind->transform];
            kind->inset =
                FLAT_INSET * group->scale * (kind->transform ? affine_stretch(inverse) : 1);
            if (next >= NONE_ID) {
                return false;
            }
        }
        group->mesh_triangles = (uint32_t)next - group->first_mesh;
    }
    return true;
}

bool accel_tabulate(Accel *accel)
{
    FlatArray all = {0};
    bool ok = true;
    for (uint32_t g = 0; ok && g < accel->group_count; ++g) {
        ok = tabulate_group(&all, &accel->groups[g], &accel->issues);
    }
    accel->flats = all.items;
    accel->flat_count = (uint32_t)all.count;
    ok = ok && number_meshes(accel);
    for (uint32_t g = 0; ok && g < accel->group_count; ++g) {
        ok = accel_make_sweep(&accel->groups[g]);
    }
    return ok;
}
