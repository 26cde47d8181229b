// What the files of the Blender writer share.
//
// The written file is a Python script. Its first part (blender_prelude.py) knows how things are
// made in Blender and Cycles; what is written here are calls of it, with the scene's own numbers:
// points and maps are those of the .scn file, and the prelude turns them to Blender's axes.
#ifndef EXPORT_BLENDER_H
#define EXPORT_BLENDER_H

#include "export/fields.h"

typedef struct Blender {
    Export *e;
    bool local;    // the integrator is `local`
    bool shadows;  // things cast shadows
    double lights; // what intensities are multiplied by: π in `local`, else 1
    Box3 box;      // around what is finite
    Vec3 eye;      // the camera's place
} Blender;

// --- Text (blender_text.c) -----------------------------------------------------------------------

void blender_print(const Blender *b, const char *format, ...) __attribute__((format(printf, 2, 3)));
void blender_number(const Blender *b, double number);
void blender_vec3(const Blender *b, Vec3 v); // (x, y, z)
void blender_rgb(const Blender *b, Rgb color);
void blender_string(const Blender *b, const char *text);
// The three rows of a map; "None" for the identity.
void blender_matrix(const Blender *b, const Affine *map);
// A name for people, as a string: the node's own, or its kind and place.
void blender_name(const Blender *b, const char *kind, uint32_t name, Span at);
// "# sphere "ball", shelf.scn:8"
void blender_comment(const Blender *b, const char *indent, const char *kind, uint32_t name,
                     Span at);

// --- Textures and materials (blender_material.c) -------------------------------------------------

// Functions `texture_N(n)` and `material_N(n)`, which build their nodes.
void blender_define_textures(const Blender *b);
void blender_define_materials(const Blender *b);
// An expression: a value, or a call of a texture's function.
void blender_color_tex(const Blender *b, ColorTex color);
// Do a material's textures use the shape's own space? Then its sphere can't be the unit sphere.
bool blender_uses_object_space(const Blender *b, uint32_t material);
// Does a material, or a part of it, emit?
bool blender_emits(const Blender *b, uint32_t material);
bool blender_is_glass(const Blender *b, uint32_t material);

// --- The rest ------------------------------------------------------------------------------------

// Lights that belong to a prototype, as statements that add them to the collection `into`.
void blender_lights(const Blender *b, uint32_t prototype, const char *indent);
void blender_surroundings(const Blender *b, const char *indent);
// The area_light that a shape stands in, or NONE_ID.
uint32_t blender_light_of_shape(const Blender *b, uint32_t shape);

void blender_define_meshes(const Blender *b);
void blender_define_prototypes(const Blender *b);
void blender_shapes(const Blender *b, uint32_t prototype, const char *indent);
void blender_instances(const Blender *b, const char *indent);

#endif
