#include "scene/scene.h"

#include <string.h>

bool scene_init(Scene *scene, const Schema *schema, Sandbox *sandbox)
{
    *scene = (Scene){.schema = schema, .sandbox = sandbox, .camera = NONE_ID};
    scene->tables = mem_alloc_zeroed(schema->type_count, sizeof *scene->tables);
    const Affine identity = affine_identity();
    if (scene->tables && array_push(&scene->transforms, identity) &&
        array_push(&scene->inverses, identity) && array_push(&scene->names, "") &&
        array_push(&scene->prototypes, (Prototype){0})) {
        return true;
    }
    scene_free(scene);
    return false;
}

void scene_free(Scene *scene)
{
    if (!scene->schema) {
        return;
    }
    for (size_t i = 0; scene->tables && i < scene->schema->type_count; ++i) {
        mem_free(scene->tables[i].items);
    }
    mem_free(scene->tables);
    for (int i = 0; i < CATEGORY_COUNT; ++i) {
        array_free(&scene->nodes[i]);
    }
    array_free(&scene->light_colors);
    array_free(&scene->transforms);
    array_free(&scene->inverses);
    array_free(&scene->names);
    array_free(&scene->prototypes);
    array_free(&scene->instances);
    array_free(&scene->meshes);
    array_free(&scene->params);
    array_free(&scene->bindings);
    array_free(&scene->expectations);
    arena_free(&scene->arena);
    *scene = (Scene){.camera = NONE_ID};
}

bool scene_clear(Scene *scene)
{
    const Schema *schema = scene->schema;
    Sandbox *sandbox = scene->sandbox;
    struct PictureCache *pictures = scene->pictures;
    struct MeshCache *mesh_cache = scene->mesh_cache;
    scene_free(scene);
    if (!scene_init(scene, schema, sandbox)) {
        return false;
    }
    scene->pictures = pictures;
    scene->mesh_cache = mesh_cache;
    return true;
}

// Ids have 32 bits, and the last stands for none.
static bool has_room(size_t count)
{
    return count < NONE_ID;
}

static uint32_t newest(size_t count)
{
    return (uint32_t)(count - 1);
}

// A kind without parameters has slots of one byte, so that the table's address is never NULL.
static bool table_push(SceneTable *table, const void *params, size_t size)
{
    size_t step = size ? size : 1;
    if (!array_grow((void **)(void *)&table->items, &table->capacity, table->count, 1, step)) {
        return false;
    }
    if (size) {
        memcpy(table->items + table->count * size, params, size);
    }
    ++table->count;
    return true;
}

uint32_t scene_add_node(Scene *scene, uint16_t type, const void *params, SceneNode node)
{
    const NodeType *kind = scene->schema->types[type];
    SceneNodeArray *nodes = &scene->nodes[kind->category];
    SceneTable *table = &scene->tables[type];
    bool is_light = kind->category == CATEGORY_LIGHT;
    if (!has_room(nodes->count) || !array_reserve(nodes, 1) ||
        (is_light && !array_reserve(&scene->light_colors, 1)) ||
        !table_push(table, params, kind->size)) {
        return NONE_ID;
    }
    node.type = type;
    node.index = newest(table->count);
    nodes->items[nodes->count++] = node;
    if (is_light) {
        scene->light_colors.items[scene->light_colors.count++] = (Rgb){1, 1, 1};
    }
    if (kind->category == CATEGORY_SHAPE) {
        ++scene->prototypes.items[node.prototype].shape_count;
    }
    return newest(nodes->count);
}

static bool is_finite(const Affine *map)
{
    bool finite = true;
    for (int i = 0; i < 12; ++i) {
        finite = finite && isfinite(map->m[i / 4][i % 4]);
    }
    return finite;
}

uint32_t scene_add_transform(Scene *scene, const Affine *transform)
{
    if (affine_is_identity(transform)) {
        return 0;
    }
    AffineArray *all = &scene->transforms;
    if (memcmp(&all->items[all->count - 1], transform, sizeof *transform) == 0) {
        return newest(all->count);
    }
    Affine inverse;
    if (!has_room(all->count) || !is_finite(transform) || !affine_inverse(transform, &inverse) ||
        !is_finite(&inverse) || !array_reserve(all, 1) || !array_push(&scene->inverses, inverse)) {
        return NONE_ID;
    }
    all->items[all->count++] = *transform;
    return newest(all->count);
}

uint32_t scene_add_name(Scene *scene, Str name)
{
    if (name.length == 0) {
        return 0;
    }
    NameArray *names = &scene->names;
    if (str_equal(name, str_from(names->items[names->count - 1]))) {
        return newest(names->count);
    }
    if (!has_room(names->count) || !array_reserve(names, 1)) {
        return NONE_ID;
    }
    const char *copy = arena_copy_string(&scene->arena, name.at, name.length);
    if (!copy) {
        return NONE_ID;
    }
    names->items[names->count++] = copy;
    return newest(names->count);
}

uint32_t scene_add_prototype(Scene *scene, uint32_t name, Span at)
{
    PrototypeArray *all = &scene->prototypes;
    return has_room(all->count) && array_push(all, (Prototype){.name = name, .at = at})
               ? newest(all->count)
               : NONE_ID;
}

uint32_t scene_add_instance(Scene *scene, SceneInstance instance)
{
    SceneInstanceArray *all = &scene->instances;
    return has_room(all->count) && array_push(all, instance) ? newest(all->count) : NONE_ID;
}

uint32_t scene_add_mesh(Scene *scene, Mesh mesh)
{
    MeshArray *all = &scene->meshes;
    return has_room(all->count) && array_push(all, mesh) ? newest(all->count) : NONE_ID;
}

static const SceneNode *find_setting(const Scene *scene, const char *kind)
{
    const SceneNodeArray *settings = &scene->nodes[CATEGORY_SETTING];
    for (size_t i = settings->count; i-- > 0;) {
        if (strcmp(scene_node_type(scene, &settings->items[i])->name, kind) == 0) {
            return &settings->items[i];
        }
    }
    return NULL;
}

const void *scene_setting(const Scene *scene, const char *kind)
{
    const SceneNode *node = find_setting(scene, kind);
    return node ? scene_params(scene, node) : NULL;
}

Span scene_setting_at(const Scene *scene, const char *kind)
{
    const SceneNode *node = find_setting(scene, kind);
    return node ? node->at : (Span){0};
}
