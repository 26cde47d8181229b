#include "scene/mesh_build.h"

#include <float.h>
#include <string.h>

bool mesh_builder_begin(MeshBuilder *builder, Arena *arena, Mesh vertices, size_t triangles)
{
    *builder = (MeshBuilder){.mesh = vertices, .triangle_capacity = triangles};
    size_t bytes;
    if (__builtin_mul_overflow(triangles, 3 * sizeof(uint32_t), &bytes) ||
        triangles >= UINT32_MAX) {
        return false;
    }
    builder->mesh.triangles = arena_alloc(arena, bytes);
    builder->mesh.triangle_count = 0;
    return builder->mesh.triangles != NULL;
}

void mesh_builder_free(MeshBuilder *builder)
{
    mem_free(builder->corners);
    mem_free(builder->cut);
    polygon_scratch_free(&builder->polygon);
}

static bool make_corner_room(MeshBuilder *builder, size_t count)
{
    if (count <= builder->corner_capacity) {
        return true;
    }
    size_t capacity = count + count / 2;
    mem_free(builder->corners);
    mem_free(builder->cut);
    builder->corners = mem_alloc(capacity, sizeof *builder->corners);
    builder->cut = mem_alloc(capacity, 3 * sizeof *builder->cut);
    builder->corner_capacity = builder->corners && builder->cut ? capacity : 0;
    return builder->corner_capacity != 0;
}

static Vec3 position(const Mesh *mesh, uint32_t vertex)
{
    const float *p = mesh->positions + 3 * (size_t)vertex;
    return vec3((double)p[0], (double)p[1], (double)p[2]);
}

static void add_triangle(MeshBuilder *builder, const Vec3 *corners, const uint32_t *indices,
                         uint32_t a, uint32_t b, uint32_t c)
{
    Mesh *mesh = &builder->mesh;
    Vec3 normal = cross(sub(corners[b], corners[a]), sub(corners[c], corners[a]));
    if (!(length_squared(normal) > 0)) {
        ++mesh->degenerate;
        return;
    }
    uint32_t *triangle = mesh->triangles + 3 * (size_t)mesh->triangle_count++;
    triangle[0] = indices[a];
    triangle[1] = indices[b];
    triangle[2] = indices[c];
}

// The usual quadrilateral, which either diagonal cuts well or, where it is concave, only one; false
// where neither does.
static bool add_quad(MeshBuilder *builder, const Vec3 *p, const uint32_t *indices)
{
    Vec3 normal = cross(sub(p[2], p[0]), sub(p[3], p[1]));
    for (uint32_t i = 0; i < 2; ++i) {
        uint32_t a = i, b = i + 1, c = i + 2, d = (i + 3) % 4;
        Vec3 diagonal = sub(p[c], p[a]);
        if (dot(cross(sub(p[b], p[a]), diagonal), normal) > 0 &&
            dot(cross(diagonal, sub(p[d], p[a])), normal) > 0) {
            add_triangle(builder, p, indices, a, b, c);
            add_triangle(builder, p, indices, a, c, d);
            return true;
        }
    }
    return false;
}

PolygonResult mesh_builder_add(MeshBuilder *builder, const uint32_t *indices, uint32_t count)
{
    if (count < 3) {
        ++builder->mesh.degenerate;
        return POLYGON_OK;
    }
    if (!make_corner_room(builder, count)) {
        return POLYGON_NO_MEMORY;
    }
    Vec3 *corners = builder->corners;
    bool finite = true;
    for (uint32_t i = 0; i < count; ++i) {
        corners[i] = position(&builder->mesh, indices[i]);
        finite = finite && vec3_is_finite(corners[i]);
    }
    if (!finite) {
        builder->mesh.not_finite += count - 2;
        return POLYGON_OK;
    }
    if (count == 3) {
        add_triangle(builder, corners, indices, 0, 1, 2);
        return POLYGON_OK;
    }
    if (count == 4 && add_quad(builder, corners, indices)) {
        return POLYGON_OK;
    }
    PolygonResult result = polygon_triangulate(&builder->polygon, corners, count, builder->cut);
    for (uint32_t i = 0; result == POLYGON_OK && i < count - 2; ++i) {
        const uint32_t *cut = builder->cut + 3 * (size_t)i;
        add_triangle(builder, corners, indices, cut[0], cut[1], cut[2]);
    }
    return result;
}

bool mesh_set_positions(Mesh *mesh, Arena *arena, const Vec3 *points, uint32_t count)
{
    Box3 bounds = box3_empty();
    for (uint32_t i = 0; i < count; ++i) {
        if (vec3_is_finite(points[i]) && max_component(vec3_abs(points[i])) <= (double)FLT_MAX) {
            bounds = box3_add(bounds, points[i]);
        }
    }
    mesh->origin = vec3(0, 0, 0);
    if (!box3_is_empty(bounds)) {
        Vec3 center = box3_center(bounds);
        double size = max_component(sub(bounds.max, bounds.min));
        mesh->origin = max_component(vec3_abs(center)) > 2 * size ? center : mesh->origin;
    }
    mesh->positions = arena_array(arena, count, 3 * sizeof(float));
    mesh->vertex_count = count;
    for (uint32_t i = 0; mesh->positions && i < count; ++i) {
        Vec3 p = sub(points[i], mesh->origin);
        float *out = mesh->positions + 3 * (size_t)i;
        // What a float can't hold becomes infinite, and its triangles are counted as not finite.
        out[0] = (float)p.x;
        out[1] = (float)p.y;
        out[2] = (float)p.z;
    }
    return mesh->positions != NULL;
}

float mesh_srgb_to_linear(float encoded)
{
    return encoded <= 0.04045f ? encoded / 12.92f : powf((encoded + 0.055f) / 1.055f, 2.4f);
}

static uint32_t mend(float *values, uint32_t count, int components)
{
    uint32_t mended = 0;
    for (uint32_t i = 0; values && i < count; ++i) {
        float *value = values + (size_t)components * i;
        bool finite = true;
        for (int c = 0; c < components; ++c) {
            finite = finite && isfinite(value[c]);
        }
        if (!finite) {
            memset(value, 0, (size_t)components * sizeof *value);
            ++mended;
        }
    }
    return mended;
}

static void set_normal(float *normal, Vec3 n)
{
    double size = length(n);
    n = size > 0 ? scale(n, 1 / size) : vec3(0, 0, 1);
    normal[0] = (float)n.x;
    normal[1] = (float)n.y;
    normal[2] = (float)n.z;
}

// Puts the mean of the triangles around each vertex whose normal is zero in its place.
static uint32_t mend_normals(Mesh *mesh)
{
    uint32_t bad = 0;
    for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
        float *n = mesh->normals + 3 * (size_t)i;
        double size = length(vec3((double)n[0], (double)n[1], (double)n[2]));
        if (isfinite(size) && size > 0) {
            set_normal(n, vec3((double)n[0], (double)n[1], (double)n[2]));
        } else {
            n[0] = n[1] = n[2] = 0;
            ++bad;
        }
    }
    for (size_t i = 0; bad && i < 3 * (size_t)mesh->triangle_count; ++i) {
        const uint32_t *t = mesh->triangles + i - i % 3;
        float *n = mesh->normals + 3 * (size_t)mesh->triangles[i];
        double size = length(vec3((double)n[0], (double)n[1], (double)n[2]));
        // Good ones are of unit length; those being summed are made longer than any of these.
        if (size == 0 || size > 1.5) {
            Vec3 face = normalize(cross(sub(position(mesh, t[1]), position(mesh, t[0])),
                                        sub(position(mesh, t[2]), position(mesh, t[0]))));
            n[0] += 1e3f * (float)face.x;
            n[1] += 1e3f * (float)face.y;
            n[2] += 1e3f * (float)face.z;
        }
    }
    for (uint32_t i = 0; bad && i < mesh->vertex_count; ++i) {
        float *n = mesh->normals + 3 * (size_t)i;
        set_normal(n, vec3((double)n[0], (double)n[1], (double)n[2]));
    }
    return bad;
}

uint32_t mesh_mend_attributes(Mesh *mesh)
{
    uint32_t mended =
        mend(mesh->uvs, mesh->vertex_count, 2) + mend(mesh->colors, mesh->vertex_count, 3);
    return mended + (mesh->normals ? mend_normals(mesh) : 0);
}

// --- Copies --------------------------------------------------------------------------------------

// A copy in `arena`, or NULL where there is nothing to copy; clears *good when memory runs out.
static void *copied(Arena *arena, const void *array, size_t count, size_t size, bool *good)
{
    void *copy = array && *good ? arena_array(arena, count, size) : NULL;
    if (copy) {
        memcpy(copy, array, count * size);
    }
    *good = *good && (copy || !array);
    return copy;
}

bool mesh_copy(Mesh *mesh, Arena *arena)
{
    bool good = true;
    size_t vertices = mesh->vertex_count;
    mesh->positions = copied(arena, mesh->positions, vertices, 3 * sizeof(float), &good);
    mesh->normals = copied(arena, mesh->normals, vertices, 3 * sizeof(float), &good);
    mesh->uvs = copied(arena, mesh->uvs, vertices, 2 * sizeof(float), &good);
    mesh->colors = copied(arena, mesh->colors, vertices, 3 * sizeof(float), &good);
    mesh->triangles =
        copied(arena, mesh->triangles, mesh->triangle_count, 3 * sizeof(uint32_t), &good);
    return good;
}
