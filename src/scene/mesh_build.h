// What the readers of meshes share: from vertices and polygons to a Mesh.
#ifndef SCENE_MESH_BUILD_H
#define SCENE_MESH_BUILD_H

#include "scene/polygon.h"
#include "scene/scene.h"

// A mesh being made. `mesh` has its vertices; faces are added one by one.
typedef struct MeshBuilder {
    Mesh mesh;
    size_t triangle_capacity; // of mesh.triangles, in triangles
    Vec3 *corners;            // of the face at hand
    uint32_t *cut;            // its triangles
    size_t corner_capacity;
    PolygonScratch polygon;
} MeshBuilder;

// Takes room for `triangles` triangles from the arena. False when memory runs out.
bool mesh_builder_begin(MeshBuilder *builder, Arena *arena, Mesh vertices, size_t triangles);
// Gives back what was needed on the way; the mesh's own memory is the arena's.
void mesh_builder_free(MeshBuilder *builder);
// Adds a face, cut into triangles; its indices must be below the count of vertices, and the faces'
// triangles (corners - 2 each) must fit the room taken at the beginning. Triangles without area
// (and faces of fewer than three corners), and those with a corner that isn't finite, are counted
// instead.
PolygonResult mesh_builder_add(MeshBuilder *builder, const uint32_t *indices, uint32_t count);

// Makes mesh->positions of `count` points in double: chooses the origin (zero, unless the mesh is
// farther from it than it is large) and rounds what is left to float. False when memory runs out.
bool mesh_set_positions(Mesh *mesh, Arena *arena, const Vec3 *points, uint32_t count);

// Joins the vertices that are equal in everything. False when memory runs out.
bool mesh_join(Mesh *mesh);

// Two triangles that meet at an edge at a larger angle than this keep their crease when normals are
// made for a file that has none. In degrees.
enum { MESH_CREASE_ANGLE = 50 };

// Makes a normal for each vertex: the mean of the triangles around it, weighted by their angles
// there (Thürmer and Wüthrich 1998), not across creases; a vertex on a crease becomes one vertex
// for each side. Vertices at the same place count as one. The new arrays are the arena's. False
// when memory runs out.
bool mesh_make_normals(Mesh *mesh, Arena *arena);

// Makes every normal of unit length, and every texture coordinate and color finite. A normal that
// is zero or not finite becomes the mean of the triangles around it; other bad values become zero.
// Returns how many vertices were mended.
uint32_t mesh_mend_attributes(Mesh *mesh);

// Has the mesh's arrays copied into `arena`. False when memory runs out; *mesh is of no use then.
bool mesh_copy(Mesh *mesh, Arena *arena);

// From the sRGB encoding (IEC 61966-2-1) to linear light.
float mesh_srgb_to_linear(float encoded);

#endif
