// What the accelerator asks of a mesh beyond what it asks of every shape.
#ifndef RENDER_SHAPES_MESH_H
#define RENDER_SHAPES_MESH_H

#include "render/shape.h"

// The Mesh of a `mesh` node, from its parameters.
const Mesh *mesh_of(const Scene *scene, const void *params);

// A vertex in the mesh node's own space.
static inline Vec3 mesh_vertex(const Mesh *mesh, uint32_t vertex)
{
    const float *p = mesh->positions + 3 * (size_t)vertex;
    return vec3(mesh->origin.x + (double)p[0], mesh->origin.y + (double)p[1],
                mesh->origin.z + (double)p[2]);
}

#endif
