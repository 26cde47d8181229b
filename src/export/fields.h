// Fields of a node by their names in the language. The parameter structs are the renderer's own;
// the schema says where in them a field lies.
#ifndef EXPORT_FIELDS_H
#define EXPORT_FIELDS_H

#include "export/export.h"

// All of these give zeros (NULL, NONE_ID) after a note where the kind has no such field, which a
// renamed field would be.
double export_number(Export *e, const SceneNode *node, const char *field);
bool export_bool(Export *e, const SceneNode *node, const char *field);
int64_t export_int(Export *e, const SceneNode *node, const char *field);
Vec2 export_vec2(Export *e, const SceneNode *node, const char *field);
Vec3 export_vec3(Export *e, const SceneNode *node, const char *field);
Rgb export_rgb(Export *e, const SceneNode *node, const char *field);
Quantity export_quantity(Export *e, const SceneNode *node, const char *field);
Emission export_emission(Export *e, const SceneNode *node, const char *field);
NumberTex export_number_tex(Export *e, const SceneNode *node, const char *field);
PairTex export_pair_tex(Export *e, const SceneNode *node, const char *field);
ColorTex export_color_tex(Export *e, const SceneNode *node, const char *field);
const char *export_file(Export *e, const SceneNode *node, const char *field);
NumberList export_numbers(Export *e, const SceneNode *node, const char *field);
RgbList export_rgbs(Export *e, const SceneNode *node, const char *field);
uint32_t export_id(Export *e, const SceneNode *node, const char *field);
// The text of a choice; "" for none.
const char *export_choice(Export *e, const SceneNode *node, const char *field);

// A field of a settings kind ("film", "render"), or its default where the scene has no such
// setting: whole numbers, choices and bools.
int64_t export_setting_int(Export *e, const char *kind, const char *field);
bool export_setting_bool(Export *e, const char *kind, const char *field);
// Copied into `out` of `size` bytes.
const char *export_setting_choice(Export *e, const char *kind, const char *field, char *out,
                                  size_t size);

// The name of a node's kind.
const char *export_kind(const Export *e, const SceneNode *node);
bool export_is(const Export *e, const SceneNode *node, const char *kind);
// The map of a node to its prototype's (or the world's) space.
const Affine *export_transform(const Export *e, uint32_t transform);

#endif
