#include "render/shapes/mesh.h"

#include "render/geometry.h"
#include "scene/mesh.h"

enum {
    MESH_FILE,
    MESH_VERTICES,
    MESH_FACES,
    MESH_NORMALS,
    MESH_UVS,
    MESH_COLORS,
};

static const Param mesh_params[] = {
    {.name = "file",
     .type = PARAM_FILE,
     PARAM_AT(MeshParams, file),
     .flags = PARAM_NO_DEFAULT,
     .doc = "A file of triangles or polygons: PLY, OBJ, STL, glTF, GLB, 3DS, OFF, DAE, FBX, LWO, X "
            "or 3MF. All its parts become one mesh, in the file's own coordinates; its materials "
            "are not read. Vertex colors are linear in glTF, and in PLY where they are "
            "floating-point numbers; elsewhere they are sRGB-encoded."},
    {.name = "vertices",
     .type = PARAM_VEC3_LIST,
     PARAM_AT(MeshParams, vertices),
     .flags = PARAM_NO_DEFAULT,
     .dims = DIM_BIT(DIM_LENGTH),
     .doc = "The corners, instead of a file; with `faces`."},
    {.name = "faces",
     .type = PARAM_FACE_LIST,
     PARAM_AT(MeshParams, faces),
     .flags = PARAM_NO_DEFAULT,
     .doc = "Lists of three or more indices of vertices from 0, counter-clockwise from the front."},
    {.name = "normals",
     .type = PARAM_VEC3_LIST,
     PARAM_AT(MeshParams, normals),
     .flags = PARAM_NO_DEFAULT,
     .doc = "Shading normals, one for each vertex."},
    {.name = "uvs",
     .type = PARAM_VEC2_LIST,
     PARAM_AT(MeshParams, uvs),
     .flags = PARAM_NO_DEFAULT,
     .doc = "Texture coordinates, one pair for each vertex."},
    {.name = "colors",
     .type = PARAM_COLOR_LIST,
     PARAM_AT(MeshParams, colors),
     .flags = PARAM_NO_DEFAULT,
     .doc = "Colors for `vertex_color`, one for each vertex."},
    {.name = "smooth",
     .type = PARAM_BOOL,
     PARAM_AT(MeshParams, smooth),
     .default_text = "true",
     .doc =
         "Whether shading normals are interpolated: the given ones, or else the mean of the faces "
         "around each vertex, except across edges where faces meet at more than 50 degrees. false: "
         "every face is flat."},
};

static bool list_fits(NodeFinish *finish, int field, uint32_t count)
{
    const MeshParams *mesh = finish->params;
    if (count == 0 || count == mesh->vertices.count) {
        return true;
    }
    finish->report(finish, field, E0806, "`%s` has %u entr%s, but there are %u vertices",
                   mesh_params[field].name, count, count == 1 ? "y" : "ies", mesh->vertices.count);
    return false;
}

static bool mesh_finish(NodeFinish *finish)
{
    MeshParams *mesh = finish->params;
    bool file = finish->set >> MESH_FILE & 1, vertices = finish->set >> MESH_VERTICES & 1;
    bool faces = finish->set >> MESH_FACES & 1;
    uint64_t lists = 1u << MESH_VERTICES | 1u << MESH_FACES | 1u << MESH_NORMALS | 1u << MESH_UVS |
                     1u << MESH_COLORS;
    if (file ? (finish->set & lists) != 0 : !(vertices && faces)) {
        finish->report(finish, -1, E0804, "a mesh takes `file`, or `vertices` and `faces`");
        return false;
    }
    int field = file ? MESH_FILE : MESH_FACES;
    MeshReport report = {.sink = finish->sink,
                         .at = finish->place ? finish->place(finish, field) : (Span){0, 0, 0}};
    if (file) {
        mesh->mesh = mesh_load(finish->scene, mesh->file, mesh->smooth, report);
        return mesh->mesh != NONE_ID;
    }
    bool fits = list_fits(finish, MESH_NORMALS, mesh->normals.count);
    fits = list_fits(finish, MESH_UVS, mesh->uvs.count) && fits;
    fits = list_fits(finish, MESH_COLORS, mesh->colors.count) && fits;
    if (!fits) {
        return false;
    }
    mesh->mesh = mesh_from_lists(finish->scene, mesh->vertices, mesh->faces, mesh->normals,
                                 mesh->uvs, mesh->colors, mesh->smooth, report);
    return mesh->mesh != NONE_ID;
}

const Mesh *mesh_of(const Scene *scene, const void *params)
{
    const MeshParams *mesh = params;
    return &scene->meshes.items[mesh->mesh];
}

static Box3 mesh_bounds(const Scene *scene, const void *params)
{
    const Mesh *mesh = mesh_of(scene, params);
    Box3 box = box3_empty();
    for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
        box = box3_add(box, mesh_vertex(mesh, i));
    }
    return box;
}

typedef struct Corners {
    uint32_t vertex[3];
    Vec3 a, u, v; // the first corner, the edges to the others
    double weight[3];
} Corners;

static Corners mesh_corners(const Mesh *mesh, uint32_t triangle, double u, double v)
{
    const uint32_t *t = mesh->triangles + 3 * (size_t)triangle;
    Corners c = {
        .vertex = {t[0], t[1], t[2]}, .a = mesh_vertex(mesh, t[0]), .weight = {1 - u - v, u, v}};
    c.u = sub(mesh_vertex(mesh, t[1]), c.a);
    c.v = sub(mesh_vertex(mesh, t[2]), c.a);
    return c;
}

static Vec3 interpolate(const float *values, const Corners *c)
{
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < 3; ++i) {
        const float *at = values + 3 * (size_t)c->vertex[i];
        sum = add_scaled(sum, vec3((double)at[0], (double)at[1], (double)at[2]), c->weight[i]);
    }
    return sum;
}

static Vec2 mesh_uv(const Mesh *mesh, uint32_t vertex)
{
    const float *uv = mesh->uvs + 2 * (size_t)vertex;
    return (Vec2){(double)uv[0], (double)uv[1]};
}

// The uv, and dp/du: the combination of the edges along which u grows by 1 and v stays; dp/dv
// likewise.
static void mesh_texture(const Mesh *mesh, const Corners *c, ShapePoint *out)
{
    Vec2 a = mesh_uv(mesh, c->vertex[0]), b = mesh_uv(mesh, c->vertex[1]);
    Vec2 d = mesh_uv(mesh, c->vertex[2]);
    out->uv.x = a.x * c->weight[0] + b.x * c->weight[1] + d.x * c->weight[2];
    out->uv.y = a.y * c->weight[0] + b.y * c->weight[1] + d.y * c->weight[2];
    double u1 = b.x - a.x, v1 = b.y - a.y, u2 = d.x - a.x, v2 = d.y - a.y;
    double determinant = u1 * v2 - u2 * v1;
    if (fabs(determinant) > 1e-12 * (fabs(u1 * v2) + fabs(u2 * v1))) {
        out->tangent = scale(sub(scale(c->u, v2), scale(c->v, v1)), 1 / determinant);
        out->bitangent = scale(sub(scale(c->v, u1), scale(c->u, u2)), 1 / determinant);
    }
}

static void mesh_point_at(const Mesh *mesh, uint32_t triangle, double u, double v, ShapePoint *out)
{
    Corners c = mesh_corners(mesh, triangle, u, v);
    Vec3 normal = cross(c.u, c.v);
    double lu = length(c.u), lv = length(c.v), inverse_area = 1 / length(normal);
    normal = scale(normal, inverse_area);
    // The normal of a thin triangle is uncertain by the rounding of its cross product.
    double size = max_abs(c.a) + max_abs(mesh->origin) + (lu + lv) * (lu * lv * inverse_area);
    *out = (ShapePoint){.p = add_scaled(add_scaled(c.a, c.u, u), c.v, v),
                        .geometric = normal,
                        .shading = normal,
                        .tangent = c.u,
                        .bitangent = c.v,
                        .uv = {u, v},
                        .color = {1, 1, 1},
                        .error = rounding_error(size)};
    if (mesh->normals) {
        Vec3 n = interpolate(mesh->normals, &c);
        double l = length(n);
        if (l > 1e-6) {
            out->shading = scale(n, (dot(n, normal) < 0 ? -1 : 1) / l);
        }
    }
    if (mesh->uvs) {
        mesh_texture(mesh, &c, out);
    }
    if (mesh->colors) {
        Vec3 color = interpolate(mesh->colors, &c);
        out->color = (Rgb){(float)color.x, (float)color.y, (float)color.z};
    }
}

static void mesh_point(const Scene *scene, const void *params, const Ray *ray, const ShapeHit *hit,
                       ShapePoint *out)
{
    (void)ray;
    mesh_point_at(mesh_of(scene, params), hit->primitive, hit->u, hit->v, out);
}

// --- Sampling ---------------------------------------------------------------------------------

// Sums of the triangles' areas in the world, each with those before it.
typedef struct MeshTable {
    double *sums;
} MeshTable;

static double triangle_area(const Mesh *mesh, uint32_t triangle, const Affine *to_world)
{
    Corners c = mesh_corners(mesh, triangle, 0, 0);
    return 0.5 * length(cross(transform_vector(to_world, c.u), transform_vector(to_world, c.v)));
}

static double mesh_area(const Scene *scene, const void *params, const Affine *to_world)
{
    const Mesh *mesh = mesh_of(scene, params);
    double sum = 0;
    for (uint32_t i = 0; i < mesh->triangle_count; ++i) {
        sum += triangle_area(mesh, i, to_world);
    }
    return sum;
}

static void *mesh_prepare_sampling(const Scene *scene, const void *params, const Affine *to_world,
                                   Arena *arena)
{
    const Mesh *mesh = mesh_of(scene, params);
    MeshTable *table = ARENA_NEW(arena, MeshTable);
    double *sums = arena_array(arena, mesh->triangle_count, sizeof *sums), sum = 0;
    if (!table || !sums) {
        return NULL;
    }
    for (uint32_t i = 0; i < mesh->triangle_count; ++i) {
        sum += triangle_area(mesh, i, to_world);
        sums[i] = sum;
    }
    table->sums = sums;
    return table;
}

static void mesh_sample_area(const Scene *scene, const void *params, const Affine *to_world,
                             const void *table, double u0, double u1, double u2, ShapeSample *out)
{
    const Mesh *mesh = mesh_of(scene, params);
    const double *sums = ((const MeshTable *)table)->sums;
    uint32_t low = 0, high = mesh->triangle_count - 1;
    double total = sums[high], at = u2 * total;
    // The first triangle whose sum is beyond `at`: one without area is never taken.
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (sums[middle] > at) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    double root = sqrt(u0);
    mesh_point_at(mesh, low, 1 - root, u1 * root, &out->point);
    shape_point_map(to_world, &out->point);
    out->primitive = low;
    out->pdf = 1 / total;
}

static uint32_t mesh_number(const void *params)
{
    const MeshParams *mesh = params;
    return mesh->mesh;
}

const ShapeClass mesh_shape = {
    .node = {.name = "mesh",
             .category = CATEGORY_SHAPE,
             .params = mesh_params,
             .param_count = sizeof mesh_params / sizeof *mesh_params,
             .size = sizeof(MeshParams),
             .doc =
                 "Triangles and polygons, from a file or from lists. Polygons are cut into "
                 "triangles. A closed mesh whose faces run counter-clockwise from outside can be "
                 "of glass.",
             .formula = "Hits are found in single precision by Embree, without gaps between "
                        "neighbouring triangles, and then computed in double precision.",
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: "
                        "(0, 0, 1.5) }, radiance: 12 }\n"
                        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], "
                        "space: \"uv\" } }\n"
                        "plane { material: lambert { color: gray(0.5) } }\n"
                        "let n = 24\n"
                        "fn face(k) = [k, k + 1, k + n + 2, k + n + 1]\n"
                        "fn height(i, j) = 0.25 + 0.2 * noise((i / 5, j / 5)) + 0.25 * cos(i / 4) "
                        "* cos(j / 4)\n"
                        "mesh {\n"
                        "  vertices: [for (i in 0..n) for (j in 0..n) (0.1 * i - 1.2, height(i, "
                        "j), 0.1 * j - 1.2)]\n"
                        "  faces: [for (i in 0..<n) for (j in 0..<n) face(i * (n + 1) + j)]\n"
                        "  material: lambert { color: #7f9f5f }\n"
                        "}",
             .finish = mesh_finish,
             .bounds = mesh_bounds,
             .mesh = mesh_number},
    .holding = HOLD_TRIANGLES,
    .closed = shape_is_open,
    .point = mesh_point,
    .area = mesh_area,
    .sample_area = mesh_sample_area,
    .prepare_sampling = mesh_prepare_sampling,
};
