// The flat scene: arrays and integer ids, no pointers between nodes. What the evaluator, an
// importer or a program makes, and what the renderer and the exporters read.
#ifndef SCENE_SCENE_H
#define SCENE_SCENE_H

#include "base/arena.h"
#include "base/array.h"
#include "base/io.h"
#include "base/source.h"
#include "base/vec.h"
#include "scene/expectation.h"
#include "schema/schema.h"

// One shape, material, texture, light, falloff, attenuation or camera. Its parameters are the
// `index`th struct of scene->tables[type].
typedef struct SceneNode {
    uint16_t type; // number in the schema
    uint16_t flags;
    uint32_t index;     // slot in tables[type]
    uint32_t transform; // index into scene->transforms; 0 is the identity
    uint32_t material;  // shapes: a material's id or NONE_ID
    uint32_t prototype; // shapes: the prototype that this belongs to; 0 is the world itself
    uint32_t name;      // index into scene->names; 0 is no name
    Span at;
} SceneNode;

// SceneNode.flags
enum {
    NODE_LIGHT_ONLY =
        1, // a shape that stands in an area_light only: it is seen, but was not emitted
};

typedef struct SceneTable {
    char *items; // count structs of schema->types[type]->size bytes
    size_t count, capacity;
} SceneTable;

typedef ARRAY(SceneNode) SceneNodeArray;
typedef ARRAY(Affine) AffineArray;
typedef ARRAY(const char *) NameArray;
typedef ARRAY(Rgb) RgbArray;

// A shared piece of geometry: the shapes whose `prototype` is its number. Prototype 0 is the world,
// whose shapes are there once, where they stand.
typedef struct Prototype {
    uint32_t name;
    uint32_t shape_count;
    Span at;
} Prototype;

typedef struct SceneInstance {
    uint32_t prototype; // never 0
    uint32_t transform; // prototype to world
    uint32_t material;  // for shapes of the prototype that have none; or NONE_ID
    uint32_t name;
    Span at;
} SceneInstance;

// A triangle mesh. Positions are float offsets from `origin`, so that a mesh far from the world's
// origin keeps its detail.
typedef struct Mesh {
    Vec3 origin;
    float *positions;    // 3 * vertex_count
    float *normals;      // 3 * vertex_count, unit; or NULL
    float *uvs;          // 2 * vertex_count; or NULL
    float *colors;       // 3 * vertex_count, linear; or NULL
    uint32_t *triangles; // 3 * triangle_count vertex indices, counter-clockwise from the front
    uint32_t vertex_count, triangle_count;
    uint32_t degenerate, not_finite; // triangles left out on loading, by reason
    uint32_t mended;                 // vertices whose attributes could not be used as they were
    const char *file;                // where it comes from, in the scene's arena; NULL: from lists
    bool smooth;                     // as it was asked for
} Mesh;

typedef ARRAY(Prototype) PrototypeArray;
typedef ARRAY(SceneInstance) SceneInstanceArray;
typedef ARRAY(Mesh) MeshArray;

// A `param` of the scene file with its value, for the picture's metadata.
typedef struct SceneParam {
    const char *name, *value_text;
} SceneParam;
typedef ARRAY(SceneParam) SceneParamArray;

// A material that a `let` of the scene file names: "gold", or "paints[2]" in a list.
typedef struct SceneBinding {
    const char *name;
    uint32_t material;
    Span at;
} SceneBinding;
typedef ARRAY(SceneBinding) SceneBindingArray;

typedef struct Scene {
    const Schema *schema;                 // not owned
    Arena arena;                          // strings, lists, meshes
    SceneTable *tables;                   // [schema->type_count]
    SceneNodeArray nodes[CATEGORY_COUNT]; // by category; a node's id is its place here
    RgbArray light_colors;                // `color` of each light, by light id
    AffineArray transforms;               // [0] is the identity
    AffineArray inverses;                 // of the same
    NameArray names;                      // [0] is ""
    PrototypeArray prototypes;            // [0] is the world
    SceneInstanceArray instances;
    MeshArray meshes;
    SceneParamArray params;
    SceneBindingArray bindings;         // where they were asked for (lang.h)
    SceneExpectationArray expectations; // in the order in which they were run first
    Sandbox *sandbox;                   // through which files are opened; not owned
    // Pictures that were decoded for an earlier version of the scene; not owned; NULL: none are
    // kept.
    struct PictureCache *pictures;
    struct MeshCache *mesh_cache; // the same of files of meshes
    uint64_t hash;                // of the sources' bytes and the parameters
    uint32_t camera;              // id of the camera to use, or NONE_ID
} Scene;

// False when memory runs out. `schema` and `sandbox` must outlive the scene.
bool scene_init(Scene *scene, const Schema *schema, Sandbox *sandbox);
void scene_free(Scene *scene);
// As scene_init left it; the schema, the sandbox and the pictures stay. False (and the scene is
// freed) when memory runs out.
bool scene_clear(Scene *scene);

// Each returns the new id, or NONE_ID when memory runs out.
// Appends a node with a copy of its parameter struct; its category follows from the type, and
// node.type and node.index are filled in. A light gets the color white; the caller may change it in
// light_colors. A shape is counted in its prototype. The other ids in `node` must be valid.
uint32_t scene_add_node(Scene *scene, uint16_t type, const void *params, SceneNode node);
// A transform and its inverse. NONE_ID also if the map is singular or not finite (affine_inverse
// tells which). The identity is always 0; a transform equal to the last one shares its id.
uint32_t scene_add_transform(Scene *scene, const Affine *transform);
// A copy; "" is always 0, and a name equal to the last one shares its id.
uint32_t scene_add_name(Scene *scene, Str name);
uint32_t scene_add_prototype(Scene *scene, uint32_t name, Span at);
uint32_t scene_add_instance(Scene *scene, SceneInstance instance);
// The mesh's arrays must live as long as the scene: in its arena.
uint32_t scene_add_mesh(Scene *scene, Mesh mesh);

static inline const SceneNode *scene_node(const Scene *scene, Category category, uint32_t id)
{
    return &scene->nodes[category].items[id];
}
static inline const NodeType *scene_node_type(const Scene *scene, const SceneNode *node)
{
    return scene->schema->types[node->type];
}
// The parameter struct of a node.
static inline const void *scene_params(const Scene *scene, const SceneNode *node)
{
    return scene->tables[node->type].items + node->index * scene->schema->types[node->type]->size;
}
// The parameters of a settings kind ("film", "render"): the last one set, or NULL where none was.
const void *scene_setting(const Scene *scene, const char *kind);
// Where it was set; no place where it wasn't.
Span scene_setting_at(const Scene *scene, const char *kind);

#endif
