// Joining equal vertices, and the normals of meshes that come without.
#include "base/hash.h"
#include "scene/mesh_build.h"

#include <stdlib.h>
#include <string.h>

// --- Classes of equal vertices -----------------------------------------------------------------

typedef struct Attribute {
    float *values;
    size_t components;
} Attribute;

typedef struct Attributes {
    Attribute items[4];
    int count;
} Attributes;

static Attributes attributes_of(const Mesh *mesh, bool all)
{
    Attributes attributes = {.items = {{mesh->positions, 3}}, .count = 1};
    const Attribute others[] = {{mesh->normals, 3}, {mesh->uvs, 2}, {mesh->colors, 3}};
    for (int i = 0; all && i < 3; ++i) {
        if (others[i].values) {
            attributes.items[attributes.count++] = others[i];
        }
    }
    return attributes;
}

static uint64_t hash_vertex(const Attributes *attributes, uint32_t vertex)
{
    uint64_t hash = 0;
    for (int a = 0; a < attributes->count; ++a) {
        const Attribute *attribute = &attributes->items[a];
        for (size_t c = 0; c < attribute->components; ++c) {
            // Adding zero makes -0 and 0 one.
            float value = attribute->values[attribute->components * vertex + c] + 0.0f;
            uint32_t bits;
            memcpy(&bits, &value, sizeof bits);
            hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
            hash ^= hash >> 29;
        }
    }
    return hash_u64(hash);
}

static bool equal_vertices(const Attributes *attributes, uint32_t v, uint32_t w)
{
    for (int a = 0; a < attributes->count; ++a) {
        const Attribute *attribute = &attributes->items[a];
        for (size_t c = 0; c < attribute->components; ++c) {
            if (attribute->values[attribute->components * v + c] !=
                attribute->values[attribute->components * w + c]) {
                return false;
            }
        }
    }
    return true;
}

// The first vertex of each vertex's class: those that are equal in their positions or, where `all`
// is set, in everything. NULL when memory runs out; to be given back with mem_free.
static uint32_t *classify(const Mesh *mesh, bool all)
{
    const Attributes attributes = attributes_of(mesh, all);
    size_t slots = 16;
    while (slots < 2 * (size_t)mesh->vertex_count) {
        slots *= 2;
    }
    uint32_t *first = mem_alloc(mesh->vertex_count, sizeof *first);
    uint32_t *table = mem_alloc_zeroed(slots, sizeof *table); // vertex + 1; 0 is free
    for (uint32_t v = 0; first && table && v < mesh->vertex_count; ++v) {
        size_t slot = hash_vertex(&attributes, v) & (slots - 1);
        while (table[slot] && !equal_vertices(&attributes, table[slot] - 1, v)) {
            slot = (slot + 1) & (slots - 1);
        }
        table[slot] = table[slot] ? table[slot] : v + 1;
        first[v] = table[slot] - 1;
    }
    if (!table) {
        mem_free(first);
        first = NULL;
    }
    mem_free(table);
    return first;
}

bool mesh_join(Mesh *mesh)
{
    uint32_t *number = classify(mesh, true);
    if (!number) {
        return false;
    }
    const Attributes attributes = attributes_of(mesh, true);
    uint32_t kept = 0;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        if (number[v] != v) {
            number[v] = number[number[v]]; // an earlier one, which has its new number already
            continue;
        }
        for (int a = 0; a < attributes.count; ++a) {
            const Attribute *attribute = &attributes.items[a];
            memmove(attribute->values + attribute->components * kept,
                    attribute->values + attribute->components * v,
                    attribute->components * sizeof(float));
        }
        number[v] = kept++;
    }
    for (size_t i = 0; i < 3 * (size_t)mesh->triangle_count; ++i) {
        mesh->triangles[i] = number[mesh->triangles[i]];
    }
    mesh->vertex_count = kept;
    mem_free(number);
    return true;
}

// --- Normals -------------------------------------------------------------------------------------

// A corner of a triangle at the place that is being looked at.
typedef struct Corner {
    uint32_t corner; // index into mesh->triangles
    uint32_t vertex; // which it refers to
    uint32_t group;  // smallest number of a corner that it is joined to
    Vec3 weighted;   // the triangle's normal times its angle here
    Vec3 normal;
} Corner;

// An edge that leaves the place: the two triangles beside it have the same `to`.
typedef struct Edge {
    uint32_t to, corner;
} Edge;

typedef struct Split {
    uint32_t vertex; // of which it is a copy
    float normal[3];
} Split;

typedef struct Smoother {
    Mesh *mesh;
    uint32_t *first;   // class of each vertex
    uint32_t *starts;  // of each class in `corners`; vertex_count + 1
    uint32_t *corners; // by class
    float *normals;    // of the vertices that were there
    ARRAY(Split) splits;
    Corner *around; // corners and edges of one place
    Edge *edges;
    size_t capacity;
} Smoother;

// The vertex that was there before; triangles may refer to copies of it by now.
static uint32_t original(const Smoother *s, uint32_t vertex)
{
    uint32_t before = s->mesh->vertex_count;
    return vertex < before ? vertex : s->splits.items[vertex - before].vertex;
}

static Vec3 vertex_position(const Smoother *s, uint32_t corner)
{
    const float *p = s->mesh->positions + 3 * (size_t)original(s, s->mesh->triangles[corner]);
    return vec3((double)p[0], (double)p[1], (double)p[2]);
}

// Counting sort of all corners by the class of their vertex.
static void sort_corners(Smoother *s)
{
    const Mesh *mesh = s->mesh;
    size_t count = 3 * (size_t)mesh->triangle_count;
    for (size_t i = 0; i < count; ++i) {
        ++s->starts[s->first[mesh->triangles[i]] + 1];
    }
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        s->starts[v + 1] += s->starts[v];
    }
    // Filling moves each start to the next one's place; moving back mends that.
    for (size_t i = 0; i < count; ++i) {
        s->corners[s->starts[s->first[mesh->triangles[i]]]++] = (uint32_t)i;
    }
    memmove(s->starts + 1, s->starts, mesh->vertex_count * sizeof *s->starts);
    s->starts[0] = 0;
}

static bool make_smoother_room(Smoother *s, size_t count)
{
    if (count <= s->capacity) {
        return true;
    }
    s->capacity = 0;
    mem_free(s->around);
    mem_free(s->edges);
    s->around = mem_alloc(count + count / 2, sizeof *s->around);
    s->edges = mem_alloc(count + count / 2, 2 * sizeof *s->edges);
    s->capacity = s->around && s->edges ? count + count / 2 : 0;
    return s->capacity != 0;
}

static double angle_between(Vec3 a, Vec3 b)
{
    return atan2(length(cross(a, b)), dot(a, b));
}

// Fills s->around with the corners at one place; returns the sum of their weighted normals.
static Vec3 gather(Smoother *s, const uint32_t *corners, uint32_t count)
{
    const Mesh *mesh = s->mesh;
    Vec3 sum = vec3(0, 0, 0);
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t corner = corners[i], third = corner - corner % 3;
        Vec3 here = vertex_position(s, corner);
        Vec3 u = sub(vertex_position(s, third + (corner + 1) % 3), here);
        Vec3 v = sub(vertex_position(s, third + (corner + 2) % 3), here);
        Vec3 normal = normalize(cross(u, v));
        s->around[i] = (Corner){corner, mesh->triangles[corner], i,
                                scale(normal, angle_between(u, v)), normal};
        sum = add(sum, s->around[i].weighted);
    }
    return sum;
}

// All triangles lie within half the crease angle of the mean, so no two are farther apart.
static bool is_all_smooth(const Smoother *s, uint32_t count, Vec3 mean)
{
    const double half = cos(MESH_CREASE_ANGLE / 2.0 * PI / 180);
    for (uint32_t i = 0; i < count; ++i) {
        if (!(dot(s->around[i].normal, mean) >= half)) {
            return false;
        }
    }
    return true;
}

static uint32_t group_of(Corner *around, uint32_t i)
{
    while (around[i].group != i) {
        around[i].group = around[around[i].group].group;
        i = around[i].group;
    }
    return i;
}

static int compare_edges(const void *left, const void *right)
{
    const Edge *a = left, *b = right;
    return a->to != b->to ? (a->to < b->to ? -1 : 1)
                          : (a->corner > b->corner) - (a->corner < b->corner);
}

// Joins the triangles that meet at an edge without a crease.
static void join_groups(Smoother *s, uint32_t count)
{
    const double limit = cos(MESH_CREASE_ANGLE * PI / 180);
    const uint32_t *triangles = s->mesh->triangles;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t corner = s->around[i].corner, third = corner - corner % 3;
        for (uint32_t j = 0; j < 2; ++j) {
            uint32_t other = triangles[third + (corner + 1 + j) % 3];
            s->edges[2 * (size_t)i + j] = (Edge){s->first[original(s, other)], i};
        }
    }
    qsort(s->edges, 2 * (size_t)count, sizeof *s->edges, compare_edges);
    for (size_t e = 1; e < 2 * (size_t)count; ++e) {
        uint32_t a = s->edges[e - 1].corner, b = s->edges[e].corner;
        if (s->edges[e - 1].to == s->edges[e].to &&
            dot(s->around[a].normal, s->around[b].normal) >= limit) {
            a = group_of(s->around, a);
            b = group_of(s->around, b);
            s->around[a > b ? a : b].group = a > b ? b : a;
        }
    }
}

static int compare_corners(const void *left, const void *right)
{
    const Corner *a = left, *b = right;
    return a->vertex != b->vertex ? (a->vertex < b->vertex ? -1 : 1)
                                  : (a->group > b->group) - (a->group < b->group);
}

static void store_normal(float out[3], Vec3 sum)
{
    Vec3 n = length_squared(sum) > 0 ? normalize(sum) : vec3(0, 0, 1);
    out[0] = (float)n.x;
    out[1] = (float)n.y;
    out[2] = (float)n.z;
}

// Gives the corners at one place their normals; each further group of a vertex gets a copy of it.
static bool split_place(Smoother *s, uint32_t count)
{
    join_groups(s, count);
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t group = group_of(s->around, i);
        s->around[i].group = group;
        if (group != i) {
            s->around[group].weighted = add(s->around[group].weighted, s->around[i].weighted);
        }
    }
    // The sums stand at the groups' own places, which the sorting below would lose.
    for (uint32_t i = count; i-- > 0;) {
        s->around[i].weighted = s->around[s->around[i].group].weighted;
    }
    qsort(s->around, count, sizeof *s->around, compare_corners);
    for (uint32_t i = 0; i < count; ++i) {
        const Corner *corner = &s->around[i], *last = i ? corner - 1 : NULL;
        if (!last || last->vertex != corner->vertex) {
            store_normal(s->normals + 3 * (size_t)corner->vertex, corner->weighted);
            continue;
        }
        if (last->group != corner->group) {
            Split split = {.vertex = corner->vertex};
            store_normal(split.normal, corner->weighted);
            if (s->splits.count >= UINT32_MAX - s->mesh->vertex_count - 1 ||
                !array_push(&s->splits, split)) {
                return false;
            }
        }
        // The last split is this vertex's if its group isn't the vertex's first.
        s->mesh->triangles[corner->corner] =
            last->group != corner->group ? s->mesh->vertex_count + (uint32_t)s->splits.count - 1
                                         : s->mesh->triangles[last->corner];
    }
    return true;
}

static bool smooth_place(Smoother *s, uint32_t class)
{
    uint32_t count = s->starts[class + 1] - s->starts[class];
    if (!make_smoother_room(s, count)) {
        return false;
    }
    Vec3 sum = gather(s, s->corners + s->starts[class], count);
    if (!is_all_smooth(s, count, normalize(sum))) {
        return split_place(s, count);
    }
    for (uint32_t i = 0; i < count; ++i) {
        store_normal(s->normals + 3 * (size_t)s->around[i].vertex, sum);
    }
    return true;
}

// One array of the mesh with the copies behind it.
static bool extend(float **values, size_t components, const Smoother *s, Arena *arena)
{
    const Mesh *mesh = s->mesh;
    if (!*values || s->splits.count == 0) {
        return true;
    }
    float *longer =
        arena_array(arena, mesh->vertex_count + s->splits.count, components * sizeof *longer);
    if (!longer) {
        return false;
    }
    memcpy(longer, *values, mesh->vertex_count * components * sizeof *longer);
    for (size_t i = 0; i < s->splits.count; ++i) {
        memcpy(longer + components * (mesh->vertex_count + i),
               *values + components * s->splits.items[i].vertex, components * sizeof *longer);
    }
    *values = longer;
    return true;
}

static bool store_normals(Smoother *s, Arena *arena)
{
    Mesh *mesh = s->mesh;
    size_t count = mesh->vertex_count + s->splits.count;
    float *normals = arena_array(arena, count, 3 * sizeof *normals);
    if (!normals || !extend(&mesh->positions, 3, s, arena) || !extend(&mesh->uvs, 2, s, arena) ||
        !extend(&mesh->colors, 3, s, arena)) {
        return false;
    }
    memcpy(normals, s->normals, 3 * (size_t)mesh->vertex_count * sizeof *normals);
    for (size_t i = 0; i < s->splits.count; ++i) {
        memcpy(normals + 3 * (mesh->vertex_count + i), s->splits.items[i].normal,
               sizeof s->splits.items[i].normal);
    }
    mesh->normals = normals;
    mesh->vertex_count = (uint32_t)count;
    return true;
}

static bool smooth_all(Smoother *s, Arena *arena)
{
    Mesh *mesh = s->mesh;
    size_t vertices = mesh->vertex_count;
    s->first = classify(mesh, false);
    s->starts = mem_alloc_zeroed(vertices + 1, sizeof *s->starts);
    s->corners = mem_alloc(mesh->triangle_count, 3 * sizeof *s->corners);
    s->normals = mem_alloc(vertices, 3 * sizeof *s->normals);
    if (!s->first || !s->starts || !s->corners || !s->normals) {
        return false;
    }
    for (size_t i = 0; i < vertices; ++i) {
        store_normal(s->normals + 3 * i, vec3(0, 0, 1)); // those that no triangle uses keep it
    }
    sort_corners(s);
    for (uint32_t class = 0; class < vertices; ++class) {
        if (s->starts[class + 1] > s->starts[class] && !smooth_place(s, class)) {
            return false;
        }
    }
    return store_normals(s, arena);
}

bool mesh_make_normals(Mesh *mesh, Arena *arena)
{
    if (mesh->triangle_count > UINT32_MAX / 3) {
        return false;
    }
    Smoother smoother = {.mesh = mesh};
    bool done = smooth_all(&smoother, arena);
    mem_free(smoother.first);
    mem_free(smoother.starts);
    mem_free(smoother.corners);
    mem_free(smoother.normals);
    mem_free(smoother.around);
    mem_free(smoother.edges);
    array_free(&smoother.splits);
    return done;
}
