// The reader of PLY. The file is walked over twice: first to see that everything its header
// announces is there and to count triangles, without taking memory; then into arrays of just the
// right size.
#include "scene/mesh.h"

#include "scene/mesh_build.h"
#include "scene/ply.h"

#include <inttypes.h>
#include <string.h>

typedef struct PlyReader {
    Ply ply;
    Arena *arena;
    MeshBuilder builder;
    uint64_t triangles; // as many as the faces may be cut into
    uint32_t *indices;  // of the face at hand
    size_t index_capacity;
    Vec3 *points;          // positions that are wider than float
    bool role[ROLE_COUNT]; // the vertices have it
    PlyType type[ROLE_COUNT];
    float decoded[256]; // 8-bit colors
} PlyReader;

static bool fails_for_memory(Ply *ply)
{
    return ply_fail(ply, "not enough memory for the mesh");
}

// --- First walk: is it all there?
// ------------------------------------------------------------------

static void count_triangles(PlyReader *reader, uint32_t corners)
{
    reader->triangles += corners > 2 ? corners - 2 : 0;
}

// Passes over one instance; counts the triangles of its list of indices.
static bool survey_instance(PlyReader *reader, const PlyElement *element)
{
    Ply *ply = &reader->ply;
    const PlyProperty *property = &ply->properties[element->first];
    for (uint32_t i = 0; i < element->property_count; ++i, ++property) {
        uint32_t count = 1;
        if (property->count_type != PLY_NONE && !ply_list_count(ply, property, &count)) {
            return false;
        }
        if (property->role == ROLE_INDICES) {
            count_triangles(reader, count);
            if (ply->ascii) {
                return true; // the second walk looks at the rest of the line
            }
        }
        if (!ply_skip(ply, property, count)) {
            return false;
        }
    }
    return true;
}

static bool survey_lines(PlyReader *reader, const PlyElement *element)
{
    Ply *ply = &reader->ply;
    bool counts = element->kind == PLY_FACE || element->kind == PLY_STRIPS;
    for (uint64_t i = 0; i < element->count; ++i) {
        if (!ply_next_line(ply)) {
            return ply_fail(ply,
                            "the file ends after %" PRIu64 " of the %" PRIu64
                            " lines announced for element `%.*s`",
                            i, element->count, (int)element->name.length, element->name.at);
        }
        if (counts && !survey_instance(reader, element)) {
            return false;
        }
    }
    return true;
}

static bool survey_binary(PlyReader *reader, const PlyElement *element)
{
    Ply *ply = &reader->ply;
    size_t left = (size_t)(ply->end - ply->at);
    if (element->stride) {
        if (element->count > left / element->stride) {
            return ply_fail(ply,
                            "element `%.*s` is to have %" PRIu64 " times %zu bytes, but only "
                            "%zu bytes are left",
                            (int)element->name.length, element->name.at, element->count,
                            element->stride, left);
        }
        ply->at += element->count * element->stride;
        return true;
    }
    for (uint64_t i = 0; i < element->count; ++i) {
        if (!survey_instance(reader, element)) {
            return false;
        }
    }
    return true;
}

// Data behind the last element means that a count is too small, or that something is lost.
static bool survey_end(Ply *ply)
{
    if (ply->ascii) {
        return !ply_next_line(ply) || ply_fail(ply, "more data than the header announces");
    }
    for (const char *at = ply->at; at < ply->end; ++at) {
        if (*at != '\0' && *at != '\n' && *at != '\r' && *at != ' ') {
            return ply_fail(ply, "the file goes on for %zu bytes behind what its header announces",
                            (size_t)(ply->end - ply->at));
        }
    }
    return true;
}

static bool survey(PlyReader *reader)
{
    Ply *ply = &reader->ply;
    for (uint32_t i = 0; i < ply->element_count; ++i) {
        PlyElement *element = &ply->elements[i];
        if (element->property_count == 0) {
            continue; // nothing stands in the file for it
        }
        ply_leave_line(ply);
        element->start = ply->at;
        element->line = ply->line;
        if (element->kind == PLY_VERTEX && element->count >= UINT32_MAX) {
            return ply_fail(ply, "%" PRIu64 " vertices are more than a mesh can have",
                            element->count);
        }
        if (!(ply->ascii ? survey_lines(reader, element) : survey_binary(reader, element))) {
            return false;
        }
        if (reader->triangles > UINT32_MAX / 3) {
            return ply_fail(ply, "%" PRIu64 " triangles are more than a mesh can have",
                            reader->triangles);
        }
    }
    return survey_end(ply);
}

// --- Second walk: the vertices -------------------------------------------------------------------

// Goes back to where the element's data begins.
static void rewind_to(Ply *ply, const PlyElement *element)
{
    ply->at = element->start;
    ply->line = element->line;
    ply->line_end = ply->newline = NULL;
}

static const PlyElement *find_element(const Ply *ply, PlyElementKind kind)
{
    for (uint32_t i = 0; i < ply->element_count; ++i) {
        if (ply->elements[i].kind == kind) {
            return &ply->elements[i];
        }
    }
    return NULL;
}

// By custom whole-number colors are sRGB-encoded, and floating ones linear.
static float decode_color(const PlyReader *reader, PlyRole role, double value)
{
    const PlyTypeInfo *type = ply_type_info(reader->type[role]);
    if (reader->type[role] == PLY_UINT8) {
        return reader->decoded[(uint8_t)value];
    }
    return type->whole ? mesh_srgb_to_linear((float)(fmax(value, 0) / type->max)) : (float)value;
}

static void store_vertex(PlyReader *reader, size_t i, const double *values)
{
    Mesh *mesh = &reader->builder.mesh;
    if (reader->points) {
        reader->points[i] = vec3(values[ROLE_X], values[ROLE_Y], values[ROLE_Z]);
    }
    for (size_t c = 0; c < 3; ++c) {
        if (!reader->points) {
            mesh->positions[3 * i + c] = (float)values[ROLE_X + c];
        }
        if (mesh->normals) {
            mesh->normals[3 * i + c] = (float)values[ROLE_NX + c];
        }
        if (mesh->colors) {
            mesh->colors[3 * i + c] =
                decode_color(reader, (PlyRole)(ROLE_RED + c), values[ROLE_RED + c]);
        }
    }
    if (mesh->uvs) {
        mesh->uvs[2 * i] = (float)values[ROLE_U];
        mesh->uvs[2 * i + 1] = (float)values[ROLE_V];
    }
}

static bool read_vertex(Ply *ply, const PlyElement *element, double *values)
{
    const PlyProperty *property = &ply->properties[element->first];
    for (uint32_t i = 0; i < element->property_count; ++i, ++property) {
        uint32_t count = 1;
        double ignored;
        if (property->count_type != PLY_NONE) {
            if (!ply_list_count(ply, property, &count) || !ply_skip(ply, property, count)) {
                return false;
            }
        } else if (!ply_number(ply, property->type, property,
                               property->role < ROLE_COUNT ? &values[property->role] : &ignored)) {
            return false;
        }
    }
    return ply_end_of_line(ply, element);
}

static bool has_roles(const PlyReader *reader, int first, int count)
{
    bool all = true;
    for (int i = 0; i < count; ++i) {
        all = all && reader->role[first + i];
    }
    return all;
}

// Positions of a type that float can't hold exactly go through double, so that an origin can be
// chosen for them.
static bool is_wide(PlyType type)
{
    return type == PLY_FLOAT64 || type == PLY_INT32 || type == PLY_UINT32;
}

static bool make_vertex_room(PlyReader *reader, uint32_t count)
{
    Mesh *mesh = &reader->builder.mesh;
    Arena *arena = reader->arena;
    mesh->vertex_count = count;
    bool wide = is_wide(reader->type[ROLE_X]) || is_wide(reader->type[ROLE_Y]) ||
                is_wide(reader->type[ROLE_Z]);
    if (wide) {
        reader->points = mem_alloc(count, sizeof *reader->points);
    } else {
        mesh->positions = arena_array(arena, count, 3 * sizeof(float));
    }
    bool normals = has_roles(reader, ROLE_NX, 3), uvs = has_roles(reader, ROLE_U, 2),
         colors = has_roles(reader, ROLE_RED, 3);
    mesh->normals = normals ? arena_array(arena, count, 3 * sizeof(float)) : NULL;
    mesh->uvs = uvs ? arena_array(arena, count, 2 * sizeof(float)) : NULL;
    mesh->colors = colors ? arena_array(arena, count, 3 * sizeof(float)) : NULL;
    return (wide ? reader->points != NULL : mesh->positions != NULL) &&
           (mesh->normals || !normals) && (mesh->uvs || !uvs) && (mesh->colors || !colors);
}

static bool read_vertices(PlyReader *reader)
{
    Ply *ply = &reader->ply;
    const PlyElement *element = find_element(ply, PLY_VERTEX);
    for (uint32_t i = 0; i < element->property_count; ++i) {
        const PlyProperty *property = &ply->properties[element->first + i];
        if (property->role < ROLE_COUNT) {
            reader->role[property->role] = true;
            reader->type[property->role] = property->type;
        }
    }
    for (int i = 0; i < 256; ++i) {
        reader->decoded[i] = mesh_srgb_to_linear((float)i / 255.0f);
    }
    if (!make_vertex_room(reader, (uint32_t)element->count)) {
        return fails_for_memory(ply);
    }
    rewind_to(ply, element);
    for (size_t i = 0; i < element->count; ++i) {
        double values[ROLE_COUNT] = {0};
        if ((ply->ascii && !ply_next_line(ply)) || !read_vertex(ply, element, values)) {
            return false;
        }
        store_vertex(reader, i, values);
    }
    return !reader->points ||
           mesh_set_positions(&reader->builder.mesh, reader->arena, reader->points,
                              (uint32_t)element->count) ||
           fails_for_memory(ply);
}

// --- Second walk: faces --------------------------------------------------------------------------

static bool make_index_room(PlyReader *reader, size_t count)
{
    if (count <= reader->index_capacity) {
        return true;
    }
    mem_free(reader->indices);
    reader->index_capacity = count + count / 2;
    reader->indices = mem_alloc(reader->index_capacity, sizeof *reader->indices);
    reader->index_capacity = reader->indices ? reader->index_capacity : 0;
    return reader->indices != NULL;
}

// Reads the list of indices; in strips -1 ends a strip and is kept as UINT32_MAX.
static bool read_indices(PlyReader *reader, const PlyElement *element, const PlyProperty *property,
                         uint64_t number, uint32_t *count)
{
    Ply *ply = &reader->ply;
    uint32_t vertices = reader->builder.mesh.vertex_count;
    if (!ply_list_count(ply, property, count)) {
        return false;
    }
    if (!make_index_room(reader, *count)) {
        return fails_for_memory(ply);
    }
    for (uint32_t i = 0; i < *count; ++i) {
        const char *before = ply->at;
        double index;
        if (!ply_number(ply, property->type, property, &index)) {
            return false;
        }
        if (index >= 0 && index < (double)vertices) {
            reader->indices[i] = (uint32_t)index;
        } else if (element->kind == PLY_STRIPS && index == -1) {
            reader->indices[i] = UINT32_MAX;
        } else {
            ply->at = before;
            return ply_fail(ply,
                            "face %" PRIu64 " refers to vertex %.0f, but there are %" PRIu32
                            " vertices, counted from 0",
                            number, index, vertices);
        }
    }
    return true;
}

static bool add_face(PlyReader *reader, const uint32_t *indices, uint32_t count)
{
    switch (mesh_builder_add(&reader->builder, indices, count)) {
    case POLYGON_OK:
        return true;
    case POLYGON_NO_MEMORY:
        return fails_for_memory(&reader->ply);
    case POLYGON_TOO_LONG:
        break;
    }
    return ply_fail(&reader->ply,
                    "a face of %" PRIu32 " corners that isn't convex; at most %d can "
                    "be cut into triangles",
                    count, POLYGON_LONGEST_CONCAVE);
}

// Every further index of a strip makes a triangle with the two before it, turned in alternation.
static bool add_strips(PlyReader *reader, uint32_t count)
{
    const uint32_t *indices = reader->indices;
    uint32_t begin = 0;
    for (uint32_t i = 0; i < count; ++i) {
        if (indices[i] == UINT32_MAX) {
            begin = i + 1;
        } else if (i >= begin + 2) {
            bool odd = (i - begin) % 2 != 0;
            uint32_t triangle[3] = {indices[odd ? i - 1 : i - 2], indices[odd ? i - 2 : i - 1],
                                    indices[i]};
            if (!add_face(reader, triangle, 3)) {
                return false;
            }
        }
    }
    return true;
}

static bool read_face(PlyReader *reader, const PlyElement *element, uint64_t number)
{
    Ply *ply = &reader->ply;
    const PlyProperty *property = &ply->properties[element->first];
    uint32_t corners = 0;
    for (uint32_t i = 0; i < element->property_count; ++i, ++property) {
        uint32_t count = 1;
        bool good =
            property->role == ROLE_INDICES
                ? read_indices(reader, element, property, number, &corners)
                : (property->count_type == PLY_NONE || ply_list_count(ply, property, &count)) &&
                      ply_skip(ply, property, count);
        if (!good) {
            return false;
        }
    }
    return ply_end_of_line(ply, element) &&
           (element->kind == PLY_STRIPS ? add_strips(reader, corners)
                                        : add_face(reader, reader->indices, corners));
}

static bool read_faces(PlyReader *reader, const PlyElement *element)
{
    if (!element || element->property_count == 0) {
        return true;
    }
    rewind_to(&reader->ply, element);
    for (uint64_t i = 0; i < element->count; ++i) {
        if ((reader->ply.ascii && !ply_next_line(&reader->ply)) || !read_face(reader, element, i)) {
            return false;
        }
    }
    return true;
}

static bool read_body(PlyReader *reader)
{
    Ply *ply = &reader->ply;
    if (!survey(reader) || !read_vertices(reader)) {
        return false;
    }
    if (!mesh_builder_begin(&reader->builder, reader->arena, reader->builder.mesh,
                            (size_t)reader->triangles)) {
        return fails_for_memory(ply);
    }
    return read_faces(reader, find_element(ply, PLY_FACE)) &&
           read_faces(reader, find_element(ply, PLY_STRIPS));
}

bool ply_read(Arena *arena, const char *bytes, size_t size, Mesh *mesh, char *message,
              size_t message_size)
{
    PlyReader *reader = mem_alloc_zeroed(1, sizeof *reader);
    if (!reader) {
        snprintf(message, message_size, "not enough memory for the mesh");
        return false;
    }
    reader->arena = arena;
    reader->ply = (Ply){.bytes = bytes,
                        .at = bytes,
                        .end = bytes + size,
                        .message = message,
                        .message_size = message_size};
    bool good = ply_read_header(&reader->ply) && read_body(reader);
    if (good) {
        *mesh = reader->builder.mesh;
    }
    mesh_builder_free(&reader->builder);
    mem_free(reader->indices);
    mem_free(reader->points);
    mem_free(reader);
    return good;
}
