// The flat scene as JSON, driven by the schema:
//
//     {"version": 1, "hash": "…", "camera": 0,
//      "params": [{"name", "value"}],
//      "shapes": [{"id", "kind", "name", "prototype", "light_only", "material", "transform",
//                  "fields", "place"}],
//      "materials": […], "textures": […], "lights": [… "color" …], "falloffs": […],
//      "attenuations": […], "cameras": […], "rules": […], "settings": […],
//      "prototypes": [{"id", "name", "shapes", "place"}],
//      "instances": [{"id", "prototype", "name", "material", "transform", "place"}],
//      "meshes": [{"id", "vertices", "triangles", "bounds", …}]}
//
// `fields` holds every field of the kind by its name: vectors and colors as arrays, a quantity as
// {"value", "unit"}, what may be textured as {"value", "texture"}, nodes as ids in their category
// (null: none), choices as their text. A transform is three rows of four numbers, or null for the
// identity. An id is a node's place in its array.
#ifndef SCENE_DUMP_H
#define SCENE_DUMP_H

#include "scene/scene.h"

#include <stdio.h>

// Writes the whole scene, one node a line; places as "file:line:column" through `sources`, which
// may be NULL: then they are null. Numbers read back as the same doubles. False on a write error.
bool scene_dump_json(const Scene *scene, Sources *sources, FILE *out);
// The same with all of each mesh beside its summary: "origin", "positions" (offsets from it),
// "vertex_normals", "vertex_uvs", "vertex_colors" (null where there are none) and "indices", three
// a triangle; each one flat list.
bool scene_export_json(const Scene *scene, Sources *sources, FILE *out);

#endif
