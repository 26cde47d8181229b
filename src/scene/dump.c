#include "scene/dump.h"

#include "scene/json.h"

#include <inttypes.h>

typedef struct Dump {
    const Scene *scene;
    Sources *sources;
    FILE *out;
    bool mesh_data;
} Dump;

static void write_id(FILE *out, uint32_t id)
{
    if (id == NONE_ID) {
        fputs("null", out);
    } else {
        fprintf(out, "%" PRIu32, id);
    }
}

static void write_vec2(FILE *out, Vec2 v)
{
    fputc('[', out);
    json_number(out, v.x);
    fputs(", ", out);
    json_number(out, v.y);
    fputc(']', out);
}

static void write_unit(FILE *out, uint32_t dim)
{
    fputs(", \"unit\": ", out);
    json_string(out, dim_info((Dim)dim)->si_unit);
}

static void write_texture(FILE *out, uint32_t texture)
{
    fputs(", \"texture\": ", out);
    write_id(out, texture);
    fputc('}', out);
}

static void write_emission(FILE *out, const Emission *emission)
{
    fputs("{\"value\": ", out);
    if (emission->is_number) {
        json_float(out, emission->value.r);
    } else {
        json_rgb(out, emission->value);
    }
    write_unit(out, emission->dim);
    write_texture(out, emission->texture);
}

static void write_choice(FILE *out, const Param *param, int32_t chosen)
{
    for (int32_t i = 0; param->choices && param->choices[i]; ++i) {
        if (i == chosen) {
            json_string(out, param->choices[i]);
            return;
        }
    }
    fputs("null", out);
}

static void write_faces(FILE *out, const FaceList *faces)
{
    const uint32_t *index = faces->indices;
    fputc('[', out);
    for (uint32_t f = 0; f < faces->count; ++f) {
        fputs(f ? ", [" : "[", out);
        for (uint32_t i = 0; i < faces->sizes[f]; ++i) {
            fprintf(out, "%s%" PRIu32, i ? ", " : "", *index++);
        }
        fputc(']', out);
    }
    fputc(']', out);
}

// The items of a list of any type through `write`.
#define WRITE_LIST(out, list, write)                                                               \
    do {                                                                                           \
        fputc('[', out);                                                                           \
        for (uint32_t item = 0; item < (list)->count; ++item) {                                    \
            fputs(item ? ", " : "", out);                                                          \
            write(out, (list)->items[item]);                                                       \
        }                                                                                          \
        fputc(']', out);                                                                           \
    } while (0)

static void write_list(FILE *out, ParamType type, const void *value)
{
    switch (type) {
    case PARAM_NUMBER_LIST:
        WRITE_LIST(out, (const NumberList *)value, json_number);
        break;
    case PARAM_VEC2_LIST:
        WRITE_LIST(out, (const Vec2List *)value, write_vec2);
        break;
    case PARAM_VEC3_LIST:
        WRITE_LIST(out, (const Vec3List *)value, json_vec3);
        break;
    case PARAM_COLOR_LIST:
        WRITE_LIST(out, (const RgbList *)value, json_rgb);
        break;
    case PARAM_STRING_LIST:
        WRITE_LIST(out, (const StringList *)value, json_string);
        break;
    default:
        write_faces(out, value);
        break;
    }
}

// A value that may come from a texture.
static void write_textured(FILE *out, ParamType type, const void *value)
{
    fputs("{\"value\": ", out);
    switch (type) {
    case PARAM_NUMBER_TEX:
        json_number(out, ((const NumberTex *)value)->value);
        write_texture(out, ((const NumberTex *)value)->texture);
        break;
    case PARAM_PAIR_TEX:
        write_vec2(out, ((const PairTex *)value)->value);
        write_texture(out, ((const PairTex *)value)->texture);
        break;
    default:
        json_rgb(out, ((const ColorTex *)value)->value);
        write_texture(out, ((const ColorTex *)value)->texture);
        break;
    }
}

static void write_quantity(FILE *out, const Quantity *quantity)
{
    fputs("{\"value\": ", out);
    json_number(out, quantity->value);
    write_unit(out, quantity->dim);
    fputc('}', out);
}

static void write_value(FILE *out, const Param *param, const void *value)
{
    switch (param->type) {
    case PARAM_BOOL:
        fputs(*(const bool *)value ? "true" : "false", out);
        break;
    case PARAM_INT:
        fprintf(out, "%" PRId64, *(const int64_t *)value);
        break;
    case PARAM_NUMBER:
        json_number(out, *(const double *)value);
        break;
    case PARAM_QUANTITY:
        write_quantity(out, value);
        break;
    case PARAM_PAIR:
    case PARAM_VEC2:
        write_vec2(out, *(const Vec2 *)value);
        break;
    case PARAM_VEC3:
        json_vec3(out, *(const Vec3 *)value);
        break;
    case PARAM_COLOR:
        json_rgb(out, *(const Rgb *)value);
        break;
    case PARAM_EMISSION:
        write_emission(out, value);
        break;
    case PARAM_NUMBER_TEX:
    case PARAM_PAIR_TEX:
    case PARAM_COLOR_TEX:
        write_textured(out, param->type, value);
        break;
    case PARAM_STRING:
    case PARAM_FILE:
        json_string(out, *(const char *const *)value);
        break;
    case PARAM_CHOICE:
        write_choice(out, param, *(const int32_t *)value);
        break;
    case PARAM_NODE:
        write_id(out, *(const uint32_t *)value);
        break;
    case PARAM_NUMBER_LIST:
    case PARAM_VEC2_LIST:
    case PARAM_VEC3_LIST:
    case PARAM_COLOR_LIST:
    case PARAM_FACE_LIST:
    case PARAM_STRING_LIST:
        write_list(out, param->type, value);
        break;
    case PARAM_TYPE_COUNT:
        break;
    }
}

static void write_fields(FILE *out, const NodeType *type, const char *params)
{
    fputs(", \"fields\": {", out);
    for (size_t i = 0; i < type->param_count; ++i) {
        fputs(i ? ", " : "", out);
        json_key(out, type->params[i].name);
        write_value(out, &type->params[i], params + type->params[i].offset);
    }
    fputc('}', out);
}

static void write_place(const Dump *dump, Span at)
{
    const Source *source = dump->sources && at.file ? source_get(dump->sources, at.file) : NULL;
    fputs(", \"place\": ", dump->out);
    if (!source) {
        fputs("null", dump->out);
        return;
    }
    Place place = source_place(dump->sources, at.file, at.begin);
    char numbers[32];
    snprintf(numbers, sizeof numbers, ":%" PRIu32 ":%" PRIu32, place.line, place.column);
    // json_string wants one string; a path is seldom long, and is cut rather than lost.
    char text[4096];
    snprintf(text, sizeof text, "%.*s%s", (int)(sizeof text - sizeof numbers), source->path,
             numbers);
    json_string(dump->out, text);
}

static void write_name(const Dump *dump, uint32_t name)
{
    fputs(", \"name\": ", dump->out);
    json_string(dump->out, name ? dump->scene->names.items[name] : NULL);
}

static void write_transform(const Dump *dump, uint32_t transform)
{
    fputs(", \"transform\": ", dump->out);
    if (transform) {
        json_affine(dump->out, &dump->scene->transforms.items[transform]);
    } else {
        fputs("null", dump->out);
    }
}

static void write_reference(FILE *out, const char *key, uint32_t id)
{
    fprintf(out, ", \"%s\": ", key);
    write_id(out, id);
}

static void write_node(const Dump *dump, Category category, uint32_t id)
{
    const SceneNode *node = scene_node(dump->scene, category, id);
    const NodeType *type = scene_node_type(dump->scene, node);
    uint32_t common = category_common_fields(category);
    fprintf(dump->out, "{\"id\": %" PRIu32 ", \"kind\": ", id);
    json_string(dump->out, type->name);
    if (common & COMMON_NAME) {
        write_name(dump, node->name);
    }
    if (category == CATEGORY_SHAPE) {
        write_reference(dump->out, "prototype", node->prototype);
        fprintf(dump->out, ", \"light_only\": %s",
                node->flags & NODE_LIGHT_ONLY ? "true" : "false");
    }
    if (common & COMMON_MATERIAL) {
        write_reference(dump->out, "material", node->material);
    }
    if (common & COMMON_COLOR) {
        fputs(", \"color\": ", dump->out);
        json_rgb(dump->out, dump->scene->light_colors.items[id]);
    }
    if (common & COMMON_TRANSFORM) {
        write_transform(dump, node->transform);
    }
    if (type->mesh) {
        write_reference(dump->out, "mesh", type->mesh(scene_params(dump->scene, node)));
    }
    write_fields(dump->out, type, scene_params(dump->scene, node));
    write_place(dump, node->at);
    fputc('}', dump->out);
}

static void write_prototype(const Dump *dump, uint32_t id)
{
    const Prototype *prototype = &dump->scene->prototypes.items[id];
    fprintf(dump->out, "{\"id\": %" PRIu32 ", \"shapes\": %" PRIu32, id, prototype->shape_count);
    write_name(dump, prototype->name);
    write_place(dump, prototype->at);
    fputc('}', dump->out);
}

static void write_instance(const Dump *dump, uint32_t id)
{
    const SceneInstance *instance = &dump->scene->instances.items[id];
    fprintf(dump->out, "{\"id\": %" PRIu32, id);
    write_reference(dump->out, "prototype", instance->prototype);
    write_name(dump, instance->name);
    write_reference(dump->out, "material", instance->material);
    write_transform(dump, instance->transform);
    write_place(dump, instance->at);
    fputc('}', dump->out);
}

static void write_floats(FILE *out, const char *key, const float *values, size_t count)
{
    fprintf(out, ",\n  \"%s\": ", key);
    if (!values) {
        fputs("null", out);
        return;
    }
    fputc('[', out);
    for (size_t i = 0; i < count; ++i) {
        fputs(i ? ", " : "", out);
        json_float(out, values[i]);
    }
    fputc(']', out);
}

static void write_mesh_data(FILE *out, const Mesh *mesh)
{
    size_t vertices = mesh->vertex_count, indices = 3 * (size_t)mesh->triangle_count;
    fputs(", \"origin\": ", out);
    json_vec3(out, mesh->origin);
    write_floats(out, "positions", mesh->positions, 3 * vertices);
    write_floats(out, "vertex_normals", mesh->normals, 3 * vertices);
    write_floats(out, "vertex_uvs", mesh->uvs, 2 * vertices);
    write_floats(out, "vertex_colors", mesh->colors, 3 * vertices);
    fputs(",\n  \"indices\": [", out);
    for (size_t i = 0; i < indices; ++i) {
        fprintf(out, "%s%" PRIu32, i ? ", " : "", mesh->triangles[i]);
    }
    fputc(']', out);
}

static void write_mesh(const Dump *dump, uint32_t id)
{
    FILE *out = dump->out;
    const Mesh *mesh = &dump->scene->meshes.items[id];
    Box3 bounds = box3_empty();
    for (size_t i = 0; i < mesh->vertex_count; ++i) {
        const float *p = mesh->positions + 3 * i;
        bounds = box3_add(bounds, vec3((double)p[0], (double)p[1], (double)p[2]));
    }
    fprintf(out, "{\"id\": %" PRIu32 ", \"vertices\": %" PRIu32 ", \"triangles\": %" PRIu32, id,
            mesh->vertex_count, mesh->triangle_count);
    fprintf(out, ", \"normals\": %s, \"uvs\": %s, \"colors\": %s", mesh->normals ? "true" : "false",
            mesh->uvs ? "true" : "false", mesh->colors ? "true" : "false");
    fprintf(out, ", \"degenerate\": %" PRIu32 ", \"not_finite\": %" PRIu32 ", \"bounds\": ",
            mesh->degenerate, mesh->not_finite);
    if (box3_is_empty(bounds)) {
        fputs("null", out);
    } else {
        fputc('[', out);
        json_vec3(out, add(mesh->origin, bounds.min));
        fputs(", ", out);
        json_vec3(out, add(mesh->origin, bounds.max));
        fputc(']', out);
    }
    if (dump->mesh_data) {
        write_mesh_data(out, mesh);
    }
    fputc('}', out);
}

static void write_param(const Dump *dump, uint32_t id)
{
    fputs("{\"name\": ", dump->out);
    json_string(dump->out, dump->scene->params.items[id].name);
    fputs(", \"value\": ", dump->out);
    json_string(dump->out, dump->scene->params.items[id].value_text);
    fputc('}', dump->out);
}

// "key": [ one item a line ]
static void write_all(const Dump *dump, const char *key, size_t count,
                      void (*write)(const Dump *dump, uint32_t id))
{
    fprintf(dump->out, ",\n\"%s\": [", key);
    for (size_t i = 0; i < count; ++i) {
        fputs(i ? ",\n" : "\n", dump->out);
        write(dump, (uint32_t)i);
    }
    fputs(count ? "\n]" : "]", dump->out);
}

static bool write_scene(const Scene *scene, Sources *sources, FILE *out, bool mesh_data)
{
    Dump dump = {scene, sources, out, mesh_data};
    fprintf(out, "{\"version\": 1, \"hash\": \"%016" PRIx64 "\"", scene->hash);
    write_reference(out, "camera", scene->camera);
    write_all(&dump, "params", scene->params.count, write_param);
    for (int category = 0; category < CATEGORY_COUNT; ++category) {
        fprintf(out, ",\n\"%ss\": [", category_name((Category)category));
        size_t count = scene->nodes[category].count;
        for (size_t i = 0; i < count; ++i) {
            fputs(i ? ",\n" : "\n", out);
            write_node(&dump, (Category)category, (uint32_t)i);
        }
        fputs(count ? "\n]" : "]", out);
    }
    write_all(&dump, "prototypes", scene->prototypes.count, write_prototype);
    write_all(&dump, "instances", scene->instances.count, write_instance);
    write_all(&dump, "meshes", scene->meshes.count, write_mesh);
    fputs("\n}\n", out);
    return !ferror(out);
}

bool scene_dump_json(const Scene *scene, Sources *sources, FILE *out)
{
    return write_scene(scene, sources, out, false);
}

bool scene_export_json(const Scene *scene, Sources *sources, FILE *out)
{
    return write_scene(scene, sources, out, true);
}
