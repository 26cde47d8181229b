// What the files of the POV-Ray writer share.
//
// POV-Ray's axes are left-handed: every point is written with z mirrored, and every map M as F M F
// with F = diag(1, 1, -1), so that the picture is the same.
//
// Light: POV-Ray's `diffuse 1` under a light of rgb 1 from straight above gives the albedo, without
// 1/π. In the `local` integrator a point of intensity I gives k C n·l I f(r), so that I is written
// as it is. `direct` and `path` have BRDFs of C/π: there I/π is written. What emits or reflects is
// written as it is in all of them.
#ifndef EXPORT_POV_H
#define EXPORT_POV_H

#include "export/fields.h"

typedef struct Pov {
    Export *e;
    bool local; // the integrator is `local`
    bool shadows;
    double light_scale; // what intensities are multiplied by: 1 or 1/π
    // Σ S_i of the lights whose S_i is the same everywhere, for the ambient term of `local`; and
    // whether others, which have no such constant, are left out.
    Rgb ambient_light;
    bool ambient_partial;
    double radius;      // of a sphere about the origin that holds what is finite
    uint32_t prototype; // that is being written; 0: the world
} Pov;

// --- Text (pov_text.c) ---------------------------------------------------------------------------

void pov_number(const Pov *pov, double number);
// <x, y, -z>
void pov_point(const Pov *pov, Vec3 v);
// <x, y, z>, for what isn't a place
void pov_triple(const Pov *pov, Vec3 v);
void pov_pair(const Pov *pov, double x, double y);
// rgb <r, g, b>
void pov_rgb(const Pov *pov, Rgb color);
// matrix <…> of a map of the scene; nothing for the identity.
void pov_matrix(const Pov *pov, const Affine *map, const char *indent);
// The same of a map from texture coordinates, which are not mirrored, to the scene.
void pov_texture_matrix(const Pov *pov, const Affine *map, const char *indent);
// "// sphere `ball`, shelf.scn:8"
void pov_comment(const Pov *pov, const char *kind, uint32_t name, Span at, const char *indent);

// --- Textures and materials (pov_pigment.c, pov_material.c) --------------------------------------

// How a shape has texture coordinates.
typedef enum PovUvKind { POV_UV_OWN, POV_UV_MAP, POV_UV_NONE } PovUvKind;
typedef struct PovUv {
    PovUvKind kind;
    Affine map; // POV_UV_MAP: (u, v, w) to the shape's space, w = 0.5 on the surface
} PovUv;

// Which spaces a material's textures live in.
enum { POV_USES_UV = 1, POV_USES_OBJECT = 2, POV_USES_WORLD = 4 };
unsigned pov_texture_uses(const Pov *pov, uint32_t texture);
unsigned pov_material_uses(const Pov *pov, uint32_t material);

// The pigment of a texture times `factor`; `at` is the material's place.
void pov_pigment(const Pov *pov, uint32_t texture, Rgb factor, const PovUv *uv, Span at,
                 const char *indent);
// A texture's middle color, where something simpler must stand in for it.
Rgb pov_texture_mean(const Pov *pov, uint32_t texture);

// #declare of every material whose textures don't depend on the shape.
void pov_declare_materials(const Pov *pov);
// "material { Material_3 }", or the whole of it where a texture's coordinates are the shape's.
void pov_use_material(const Pov *pov, uint32_t material, const PovUv *uv, const char *indent);
// Is it glass? Then shapes of it are written twice: see pov_shape.c.
bool pov_is_glass(const Pov *pov, uint32_t material);
// What a material emits (before a texture); black for most.
Rgb pov_emitted(const Pov *pov, uint32_t material);

// --- The rest ------------------------------------------------------------------------------------

void pov_declare_meshes(const Pov *pov);
void pov_declare_prototypes(const Pov *pov);
void pov_shapes(const Pov *pov);
void pov_lights(const Pov *pov);
// The radiance that an area_light's surface shows.
Rgb pov_area_radiance(const Pov *pov, uint32_t light);
// Fills ambient_light and ambient_partial.
void pov_sum_ambient(Pov *pov);

#endif
