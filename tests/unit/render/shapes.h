// Scenes of shapes made without the language, random numbers, and shapes as implicit functions in
// long double, which the shapes' own code is compared with.
#ifndef TESTS_SHAPES_H
#define TESTS_SHAPES_H

#include "base/mem.h"
#include "near.h"
#include "render/geometry.h"
#include "render/render.h"
#include "render/shape.h"
#include "scene/mesh.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// --- Random numbers ------------------------------------------------------------------------------

typedef struct Random {
    uint64_t state;
} Random;

// The seed is printed, and taken from SCN_TEST_SEED if that is set.
static inline Random random_make(const char *what, uint64_t seed)
{
    const char *given = getenv("SCN_TEST_SEED");
    if (given) {
        seed = strtoull(given, NULL, 0);
    }
    print_message("%s: seed %llu\n", what, (unsigned long long)seed);
    return (Random){seed};
}
static inline uint64_t random_bits(Random *r)
{
    uint64_t x = r->state += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}
static inline double uniform(Random *r)
{
    return (double)(random_bits(r) >> 11) * 0x1p-53;
}
static inline double between(Random *r, double a, double b)
{
    return a + (b - a) * uniform(r);
}
static inline Vec3 random_in_box(Random *r, Box3 box)
{
    double x = between(r, box.min.x, box.max.x), y = between(r, box.min.y, box.max.y);
    return vec3(x, y, between(r, box.min.z, box.max.z));
}
static inline Vec3 random_direction(Random *r)
{
    double z = between(r, -1, 1), angle = between(r, 0, 2 * PI), s = sqrt(1 - z * z);
    return vec3(s * cos(angle), s * sin(angle), z);
}
static inline Vec3 random_about(Random *r, Vec3 normal)
{
    Vec3 d = random_direction(r);
    return dot(d, normal) < 0 ? neg(d) : d;
}

// --- Scenes --------------------------------------------------------------------------------------

static inline const NodeType *find_type(const char *kind, uint16_t *number)
{
    const Schema *schema = render_schema();
    for (size_t i = 0; i < schema->type_count; ++i) {
        if (strcmp(schema->types[i]->name, kind) == 0) {
            *number = (uint16_t)i;
            return schema->types[i];
        }
    }
    fail_msg("no kind %s", kind);
    return NULL;
}

// Parameters of a shape, to be filled with set_…, then finished by shape_finish.
typedef struct Params {
    const NodeType *type;
    uint16_t number;
    _Alignas(16) char bytes[512];
    uint64_t set;
    DiagCode code; // of the report that finish made; DIAG_CODE_COUNT: none
    int field;
} Params;

static inline Params params_of(const char *kind)
{
    Params p = {.code = DIAG_CODE_COUNT};
    p.type = find_type(kind, &p.number);
    assert_true(p.type->size <= sizeof p.bytes);
    return p;
}
static inline void *field_of(Params *p, const char *name, ParamType type)
{
    for (size_t i = 0; i < p->type->param_count; ++i) {
        if (strcmp(p->type->params[i].name, name) == 0) {
            assert_int_equal(p->type->params[i].type, type);
            p->set |= (uint64_t)1 << i;
            return p->bytes + p->type->params[i].offset;
        }
    }
    fail_msg("%s has no field %s", p->type->name, name);
    return NULL;
}
// By memcpy, since the bytes are no struct.
static inline void set_bytes(Params *p, const char *name, ParamType type, const void *value,
                             size_t size)
{
    memcpy(field_of(p, name, type), value, size);
}
static inline void set_number(Params *p, const char *name, double value)
{
    set_bytes(p, name, PARAM_NUMBER, &value, sizeof value);
}
static inline void set_vec3(Params *p, const char *name, Vec3 value)
{
    set_bytes(p, name, PARAM_VEC3, &value, sizeof value);
}
static inline void set_bool(Params *p, const char *name, bool value)
{
    set_bytes(p, name, PARAM_BOOL, &value, sizeof value);
}

__attribute__((format(printf, 4, 5))) static inline Diag *
note_report(NodeFinish *self, int field, DiagCode code, const char *format, ...)
{
    static Diag spare;
    (void)format;
    Params *p = self->caller;
    p->code = code;
    p->field = field;
    return &spare;
}

static inline bool shape_finish(Scene *scene, Params *p, DiagSink *sink)
{
    if (!p->type->finish) {
        return true;
    }
    NodeFinish finish = {.type = p->type,
                         .params = p->bytes,
                         .set = p->set,
                         .scene = scene,
                         .report = note_report,
                         .sink = sink,
                         .caller = p};
    return p->type->finish(&finish);
}

static inline uint32_t add_shape(Scene *scene, Params *p, const Affine *to, uint32_t prototype)
{
    SceneNode node = {.material = NONE_ID, .prototype = prototype};
    if (to) {
        node.transform = scene_add_transform(scene, to);
        assert_int_not_equal(node.transform, NONE_ID);
    }
    uint32_t id = scene_add_node(scene, p->number, p->bytes, node);
    assert_int_not_equal(id, NONE_ID);
    return id;
}

static inline void finish_well(Scene *scene, Params *p)
{
    Arena arena = {0};
    DiagSink sink;
    diag_sink_init(&sink, &arena);
    if (!shape_finish(scene, p, &sink)) {
        fail_msg("%s: finish failed with %s", p->type->name,
                 p->code < DIAG_CODE_COUNT ? diag_info(p->code)->name : "?");
    }
    diag_sink_free(&sink);
    arena_free(&arena);
}

static inline Params sphere_params_of(Vec3 center, double radius)
{
    Params p = params_of("sphere");
    set_vec3(&p, "center", center);
    set_number(&p, "radius", radius);
    finish_well(NULL, &p);
    return p;
}
static inline Params box_params_of(Vec3 min, Vec3 max)
{
    Params p = params_of("box");
    set_vec3(&p, "min", min);
    set_vec3(&p, "max", max);
    finish_well(NULL, &p);
    return p;
}
static inline Params rectangle_params_of(Vec3 corner, Vec3 u, Vec3 v)
{
    Params p = params_of("rectangle");
    set_vec3(&p, "corner", corner);
    set_vec3(&p, "u", u);
    set_vec3(&p, "v", v);
    finish_well(NULL, &p);
    return p;
}
static inline Params triangle_params_of(Vec3 a, Vec3 b, Vec3 c)
{
    Params p = params_of("triangle");
    set_vec3(&p, "a", a);
    set_vec3(&p, "b", b);
    set_vec3(&p, "c", c);
    finish_well(NULL, &p);
    return p;
}
static inline Params plane_params_of(Vec3 point, Vec3 normal)
{
    Params p = params_of("plane");
    set_vec3(&p, "point", point);
    set_vec3(&p, "normal", normalize(normal));
    finish_well(NULL, &p);
    return p;
}
static inline Params disc_params_of(Vec3 center, Vec3 normal, double radius, double inner)
{
    Params p = params_of("disc");
    set_vec3(&p, "center", center);
    set_vec3(&p, "normal", normalize(normal));
    set_number(&p, "radius", radius);
    set_number(&p, "inner_radius", inner);
    finish_well(NULL, &p);
    return p;
}
static inline Params cylinder_params_of(Vec3 from, Vec3 to, double radius, bool caps)
{
    Params p = params_of("cylinder");
    set_vec3(&p, "from", from);
    set_vec3(&p, "to", to);
    set_number(&p, "radius", radius);
    set_bool(&p, "caps", caps);
    finish_well(NULL, &p);
    return p;
}
static inline Params cone_params_of(Vec3 from, Vec3 to, double r0, double r1, bool caps)
{
    Params p = params_of("cone");
    set_vec3(&p, "from", from);
    set_vec3(&p, "to", to);
    set_number(&p, "radius_from", r0);
    set_number(&p, "radius_to", r1);
    set_bool(&p, "caps", caps);
    finish_well(NULL, &p);
    return p;
}
static inline Params torus_params_of(Vec3 center, Vec3 axis, double major, double minor)
{
    Params p = params_of("torus");
    set_vec3(&p, "center", center);
    set_vec3(&p, "axis", normalize(axis));
    set_number(&p, "major_radius", major);
    set_number(&p, "minor_radius", minor);
    finish_well(NULL, &p);
    return p;
}
// A mesh of triangles, its arrays in the scene's arena; the node's parameters.
static inline Params mesh_params_of(Scene *scene, const Vec3 *vertices, uint32_t vertex_count,
                                    const uint32_t *triangles, uint32_t triangle_count)
{
    Mesh mesh = {.vertex_count = vertex_count, .triangle_count = triangle_count};
    mesh.origin = vertices[0];
    mesh.positions = arena_array(&scene->arena, 3 * (size_t)vertex_count, sizeof(float));
    mesh.triangles = arena_array(&scene->arena, 3 * (size_t)triangle_count, sizeof(uint32_t));
    assert_true(mesh.positions && mesh.triangles);
    for (uint32_t i = 0; i < vertex_count; ++i) {
        Vec3 d = sub(vertices[i], mesh.origin);
        mesh.positions[3 * i] = (float)d.x;
        mesh.positions[3 * i + 1] = (float)d.y;
        mesh.positions[3 * i + 2] = (float)d.z;
    }
    memcpy(mesh.triangles, triangles, 3 * (size_t)triangle_count * sizeof(uint32_t));
    Params p = params_of("mesh");
    MeshParams params = {.mesh = scene_add_mesh(scene, mesh)};
    memcpy(p.bytes, &params, sizeof params);
    return p;
}

static inline const ShapeClass *class_of(const Params *p)
{
    return (const ShapeClass *)(const void *)p->type;
}

// A closed mesh about a point: a sphere of `rings` × `rings` with bumps, poles as single vertices.
static inline Params bumpy_mesh(Scene *scene, Vec3 center, double radius, uint32_t rings)
{
    uint32_t around = 2 * rings, vertex_count = 2 + (rings - 1) * around;
    uint32_t triangle_count = 2 * around * (rings - 1);
    Vec3 *vertices = malloc(vertex_count * sizeof *vertices);
    uint32_t *triangles = malloc(3 * (size_t)triangle_count * sizeof *triangles);
    assert_true(vertices && triangles);
    uint32_t n = 0, t = 0;
    vertices[n++] = add(center, vec3(0, radius, 0));
    for (uint32_t i = 1; i < rings; ++i) {
        for (uint32_t j = 0; j < around; ++j) {
            double polar = PI * i / rings, angle = 2 * PI * j / around;
            double r = radius * (1 + 0.1 * sin(5 * angle) * sin(polar) * sin(3 * polar));
            vertices[n++] = add(center, vec3(r * sin(polar) * sin(angle), r * cos(polar),
                                             r * sin(polar) * cos(angle)));
        }
    }
    vertices[n++] = sub(center, vec3(0, radius, 0));
    for (uint32_t j = 0; j < around; ++j) {
        uint32_t k = (j + 1) % around, last = n - 1 - around;
        uint32_t caps[6] = {0, 1 + j, 1 + k, n - 1, last + k, last + j};
        memcpy(triangles + 3 * t, caps, sizeof caps);
        t += 2;
    }
    for (uint32_t i = 0; i + 2 < rings; ++i) {
        for (uint32_t j = 0; j < around; ++j) {
            uint32_t k = (j + 1) % around, a = 1 + i * around, b = a + around;
            uint32_t quad[6] = {a + j, b + j, b + k, a + j, b + k, a + k};
            memcpy(triangles + 3 * t, quad, sizeof quad);
            t += 2;
        }
    }
    assert_int_equal(n, vertex_count);
    assert_int_equal(t, triangle_count);
    Params p = mesh_params_of(scene, vertices, vertex_count, triangles, triangle_count);
    free(vertices);
    free(triangles);
    return p;
}

static inline Affine random_rotation(Random *r)
{
    return affine_rotation(random_direction(r), between(r, 0, 2 * PI));
}
// Rotation, uneven scale, another rotation (thus a shear), translation.
static inline Affine random_affine(Random *r, double reach)
{
    Affine a = random_rotation(r);
    Affine s = affine_scaling(
        vec3(exp(between(r, -1, 1)), exp(between(r, -1, 1)), exp(between(r, -1, 1))));
    Affine b = random_rotation(r);
    Affine t = affine_translation(
        vec3(between(r, -reach, reach), between(r, -reach, reach), between(r, -reach, reach)));
    a = affine_multiply(&s, &a);
    a = affine_multiply(&b, &a);
    return affine_multiply(&t, &a);
}

#endif
