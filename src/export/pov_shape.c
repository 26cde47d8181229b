// Shapes, meshes and instances.
#include "export/pov.h"

static const SceneNode *shape_node(const Pov *pov, uint32_t shape)
{
    return scene_node(pov->e->scene, CATEGORY_SHAPE, shape);
}

static Affine columns(Vec3 x, Vec3 y, Vec3 z, Vec3 origin)
{
    return (Affine){
        {{x.x, y.x, z.x, origin.x}, {x.y, y.y, z.y, origin.y}, {x.z, y.z, z.z, origin.z}}};
}

// --- Meshes --------------------------------------------------------------------------------------

// "  vertex_vectors { 3, <…> <…> }", `width` numbers each; of 3 the last one is mirrored.
static void mesh_vectors(const Pov *pov, const char *name, const float *values, uint32_t count,
                         int width, Vec3 origin)
{
    FILE *out = pov->e->out;
    fprintf(out, "  %s { %u", name, (unsigned)count);
    for (size_t i = 0; i < count; ++i) {
        const float *v = values + i * (size_t)width;
        fputs(i % 4 ? ", " : ",\n    ", out);
        if (width == 2) {
            pov_pair(pov, (double)v[0], (double)v[1]);
        } else {
            pov_point(pov, add(origin, vec3((double)v[0], (double)v[1], (double)v[2])));
        }
    }
    fputs(" }\n", out);
}

static void mesh_faces(const Pov *pov, const Mesh *mesh)
{
    FILE *out = pov->e->out;
    fprintf(out, "  face_indices { %u", (unsigned)mesh->triangle_count);
    for (size_t i = 0; i < mesh->triangle_count; ++i) {
        const uint32_t *t = mesh->triangles + 3 * i;
        fprintf(out, "%s<%u, %u, %u>", i % 6 ? ", " : ",\n    ", (unsigned)t[0], (unsigned)t[1],
                (unsigned)t[2]);
    }
    fputs(" }\n", out);
}

static void write_mesh(const Pov *pov, const Mesh *mesh)
{
    const Vec3 none = {0, 0, 0};
    mesh_vectors(pov, "vertex_vectors", mesh->positions, mesh->vertex_count, 3, mesh->origin);
    if (mesh->normals) {
        mesh_vectors(pov, "normal_vectors", mesh->normals, mesh->vertex_count, 3, none);
    }
    if (mesh->uvs) {
        mesh_vectors(pov, "uv_vectors", mesh->uvs, mesh->vertex_count, 2, none);
    }
    mesh_faces(pov, mesh);
}

void pov_declare_meshes(const Pov *pov)
{
    const MeshArray *meshes = &pov->e->scene->meshes;
    fputs(meshes->count ? "// --- Meshes\n\n" : "", pov->e->out);
    for (size_t i = 0; i < meshes->count; ++i) {
        fprintf(pov->e->out, "#declare Mesh_%zu = mesh2 {\n", i);
        write_mesh(pov, &meshes->items[i]);
        fputs("}\n\n", pov->e->out);
    }
}

// A triangle, or the parallelogram of three of its corners.
static void flat(const Pov *pov, Vec3 a, Vec3 u, Vec3 v, bool whole)
{
    const Vec3 corners[4] = {a, add(a, u), add(a, v), add(add(a, u), v)};
    const int count = whole ? 4 : 3;
    FILE *out = pov->e->out;
    fprintf(out, "mesh2 {\n  vertex_vectors { %d", count);
    for (int i = 0; i < count; ++i) {
        fputs(", ", out);
        pov_point(pov, corners[i]);
    }
    fprintf(out, " }\n  uv_vectors { %d, <0, 0>, <1, 0>, <0, 1>%s }\n", count,
            whole ? ", <1, 1>" : "");
    fprintf(out, "  face_indices { %s }\n", whole ? "2, <0, 1, 3>, <0, 3, 2>" : "1, <0, 1, 2>");
}

// --- Kinds ---------------------------------------------------------------------------------------

static void number_after(const Pov *pov, const char *before, double number, const char *after)
{
    fputs(before, pov->e->out);
    pov_number(pov, number);
    fputs(after, pov->e->out);
}

static void write_torus(const Pov *pov, const SceneNode *node)
{
    Frame f = frame_from_normal(export_vec3(pov->e, node, "axis"));
    Affine place = columns(f.s, f.n, f.t, export_vec3(pov->e, node, "center"));
    number_after(pov, "torus { ", export_number(pov->e, node, "major_radius"), ", ");
    pov_number(pov, export_number(pov->e, node, "minor_radius"));
    fputs(" sturm\n", pov->e->out);
    pov_matrix(pov, &place, "  ");
}

static void write_frustum(const Pov *pov, const SceneNode *node, bool cone)
{
    Export *e = pov->e;
    fputs(cone ? "cone { " : "cylinder { ", e->out);
    pov_point(pov, export_vec3(e, node, "from"));
    if (cone) {
        number_after(pov, ", ", export_number(e, node, "radius_from"), "");
    }
    fputs(", ", e->out);
    pov_point(pov, export_vec3(e, node, "to"));
    number_after(pov, ", ", export_number(e, node, cone ? "radius_to" : "radius"), "");
    fputs(export_bool(e, node, "caps") ? "\n" : " open\n", e->out);
}

static void write_disc(const Pov *pov, const SceneNode *node)
{
    Export *e = pov->e;
    fputs("disc { ", e->out);
    pov_point(pov, export_vec3(e, node, "center"));
    fputs(", ", e->out);
    pov_point(pov, export_vec3(e, node, "normal"));
    number_after(pov, ", ", export_number(e, node, "radius"), "");
    double inner = export_number(e, node, "inner_radius");
    if (inner > 0) {
        number_after(pov, ", ", inner, "");
    }
    fputc('\n', e->out);
}

static void write_plane(const Pov *pov, const SceneNode *node, PovUv *uv)
{
    Vec3 p = export_vec3(pov->e, node, "point"), n = export_vec3(pov->e, node, "normal");
    fputs("plane { ", pov->e->out);
    pov_point(pov, n);
    number_after(pov, ", ", dot(p, n), "\n");
    // The axes of u and v as the renderer lays them (render/shapes/plane.c).
    Frame f = frame_from_tangent(n, fabs(n.x) < 0.9 ? vec3(1, 0, 0) : vec3(0, 0, -1));
    uv->kind = POV_UV_MAP;
    uv->map = columns(f.s, f.t, n, add_scaled(p, n, -0.5));
}

// The beginning of a shape, "sphere { <…>, 1\n", without transform, material and closing brace.
// False after a note where there is none.
static bool begin_shape(const Pov *pov, const SceneNode *node, PovUv *uv)
{
    Export *e = pov->e;
    const NodeType *type = scene_node_type(e->scene, node);
    *uv = (PovUv){POV_UV_NONE, affine_identity()};
    if (type->mesh) {
        fprintf(e->out, "object { Mesh_%u\n", (unsigned)type->mesh(scene_params(e->scene, node)));
        uv->kind = POV_UV_OWN;
    } else if (export_is(e, node, "sphere")) {
        fputs("sphere { ", e->out);
        pov_point(pov, export_vec3(e, node, "center"));
        number_after(pov, ", ", export_number(e, node, "radius"), "\n");
    } else if (export_is(e, node, "box")) {
        Vec3 low = export_vec3(e, node, "min"), high = export_vec3(e, node, "max");
        fputs("box { ", e->out);
        pov_point(pov, vec3(low.x, low.y, high.z));
        fputs(", ", e->out);
        pov_point(pov, vec3(high.x, high.y, low.z));
        fputc('\n', e->out);
    } else if (export_is(e, node, "plane")) {
        write_plane(pov, node, uv);
    } else if (export_is(e, node, "disc")) {
        write_disc(pov, node);
    } else if (export_is(e, node, "rectangle")) {
        flat(pov, export_vec3(e, node, "corner"), export_vec3(e, node, "u"),
             export_vec3(e, node, "v"), true);
        uv->kind = POV_UV_OWN;
    } else if (export_is(e, node, "triangle")) {
        Vec3 a = export_vec3(e, node, "a");
        flat(pov, a, sub(export_vec3(e, node, "b"), a), sub(export_vec3(e, node, "c"), a), false);
        uv->kind = POV_UV_OWN;
    } else if (export_is(e, node, "cylinder") || export_is(e, node, "cone")) {
        write_frustum(pov, node, export_is(e, node, "cone"));
    } else if (export_is(e, node, "torus")) {
        write_torus(pov, node);
    } else {
        export_note(e, node->at, "`%s` has no partner: it is left out", type->name);
        return false;
    }
    return true;
}

// --- Shapes --------------------------------------------------------------------------------------

// What a shape that stands in an area_light emits from its own surface, as the camera sees it.
static Rgb light_only_radiance(const Pov *pov, uint32_t shape)
{
    const Scene *scene = pov->e->scene;
    for (uint32_t id = 0; id < scene->nodes[CATEGORY_LIGHT].count; ++id) {
        const SceneNode *light = scene_node(scene, CATEGORY_LIGHT, id);
        if (export_is(pov->e, light, "area_light") && export_id(pov->e, light, "shape") == shape) {
            return pov_area_radiance(pov, id);
        }
    }
    return rgb_gray(0);
}

// The material where it stands in the right space: before the shape's transform or after it.
static void transform_and_material(const Pov *pov, const SceneNode *node, const PovUv *uv)
{
    unsigned uses = pov_material_uses(pov, node->material);
    const Affine *map = export_transform(pov->e, node->transform);
    if ((uses & POV_USES_WORLD) && pov->prototype != 0) {
        export_note(pov->e, node->at,
                    "a texture in the world's space on what is instanced: it moves with the "
                    "instance");
    }
    if (uses & POV_USES_WORLD) {
        pov_matrix(pov, map, "  ");
        pov_use_material(pov, node->material, uv, "  ");
    } else {
        pov_use_material(pov, node->material, uv, "  ");
        pov_matrix(pov, map, "  ");
    }
}

static void write_lamp(const Pov *pov, const SceneNode *node, Rgb radiance)
{
    fputs("  texture { pigment { rgb 1 } finish { ambient 0 diffuse 0 emission ", pov->e->out);
    pov_rgb(pov, radiance);
    fputs(" } }\n  no_shadow // it would hide its own light\n", pov->e->out);
    pov_matrix(pov, export_transform(pov->e, node->transform), "  ");
    if (node->material != NONE_ID) {
        export_note(pov->e, node->at, "a lamp's own reflection is left out");
    }
}

// Light from a point can't find its way through glass: a surface in its shadow is dark. POV-Ray
// would let it through straight, so that a second, black body that only shadows see stands there.
static void write_shadow_of_glass(const Pov *pov, const SceneNode *node)
{
    PovUv uv;
    fputs("// (its shadow)\n", pov->e->out);
    begin_shape(pov, node, &uv);
    fputs("  pigment { rgb 0 } no_image no_reflection\n", pov->e->out);
    pov_matrix(pov, export_transform(pov->e, node->transform), "  ");
    fputs("}\n\n", pov->e->out);
}

static void write_shape(const Pov *pov, uint32_t id)
{
    const SceneNode *node = shape_node(pov, id);
    FILE *out = pov->e->out;
    PovUv uv;
    pov_comment(pov, export_kind(pov->e, node), node->name, node->at, "");
    if (!begin_shape(pov, node, &uv)) {
        return;
    }
    bool lamp = (node->flags & NODE_LIGHT_ONLY) && !pov->local;
    bool emits = !rgb_is_black(pov_emitted(pov, node->material));
    bool glass = pov_is_glass(pov, node->material);
    if (lamp) {
        write_lamp(pov, node, light_only_radiance(pov, id));
    } else {
        transform_and_material(pov, node, &uv);
        if (!pov->shadows || emits || (glass && pov->prototype == 0) ||
            (node->flags & NODE_LIGHT_ONLY)) {
            fputs("  no_shadow\n", out);
        }
    }
    if (lamp || emits) {
        export_note(pov->e, node->at, "what shines casts no shadow in the light of others");
    }
    fputs("}\n\n", out);
    if (glass && pov->prototype == 0) {
        write_shadow_of_glass(pov, node);
    } else if (glass) {
        export_note(pov->e, node->at, "instanced glass lets light through into its shadow");
    }
}

void pov_shapes(const Pov *pov)
{
    const Scene *scene = pov->e->scene;
    FILE *out = pov->e->out;
    fputs("// --- Shapes\n\n", out);
    for (uint32_t id = 0; id < scene->nodes[CATEGORY_SHAPE].count; ++id) {
        if (shape_node(pov, id)->prototype == 0) {
            write_shape(pov, id);
        }
    }
    for (size_t i = 0; i < scene->instances.count; ++i) {
        const SceneInstance *instance = &scene->instances.items[i];
        pov_comment(pov, "instance", instance->name, instance->at, "");
        fprintf(out, "object { Prototype_%u\n", (unsigned)instance->prototype);
        if (instance->material != NONE_ID) {
            fprintf(out, "  material { Material_%u }\n", (unsigned)instance->material);
        }
        fputs(pov->shadows ? "" : "  no_shadow\n", out);
        pov_matrix(pov, export_transform(pov->e, instance->transform), "  ");
        fputs("}\n\n", out);
    }
}

void pov_declare_prototypes(const Pov *pov)
{
    const Scene *scene = pov->e->scene;
    Pov inside = *pov;
    for (uint32_t p = 1; p < scene->prototypes.count; ++p) {
        const Prototype *prototype = &scene->prototypes.items[p];
        fputs(p == 1 ? "// --- Pieces that are placed many times\n\n" : "", pov->e->out);
        pov_comment(pov, "prototype", prototype->name, prototype->at, "");
        fprintf(pov->e->out, "#declare Prototype_%u = union {\n\n", (unsigned)p);
        inside.prototype = p;
        for (uint32_t id = 0; id < scene->nodes[CATEGORY_SHAPE].count; ++id) {
            if (shape_node(pov, id)->prototype == p) {
                write_shape(&inside, id);
            }
        }
        fputs("}\n\n", pov->e->out);
    }
}
