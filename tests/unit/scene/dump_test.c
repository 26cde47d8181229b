#include "../test_support.h"
#include "scene/dump.h"
#include "scene/json.h"

#include <cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// One field of every type.
typedef struct Everything {
#define PARAM_TYPE(id, type, name) type field_##id;
    PARAM_TYPES(PARAM_TYPE)
#undef PARAM_TYPE
} Everything;

static const char *const choices[] = {"small", "large", NULL};
static const Param everything_params[] = {
#define PARAM_TYPE(id, c_type, text)                                                               \
    {.name = #id,                                                                                  \
     .type = PARAM_##id,                                                                           \
     PARAM_AT(Everything, field_##id),                                                             \
     .choices = choices,                                                                           \
     .doc = "x"},
    PARAM_TYPES(PARAM_TYPE)
#undef PARAM_TYPE
};
static const NodeType everything = {.name = "everything",
                                    .category = CATEGORY_SHAPE,
                                    .params = everything_params,
                                    .param_count = TEST_COUNT(everything_params),
                                    .size = sizeof(Everything)};
static const NodeType lamp = {.name = "lamp", .category = CATEGORY_LIGHT};
static const NodeType paint = {.name = "paint", .category = CATEGORY_MATERIAL};
static const NodeType *const types[] = {&everything, &lamp, &paint};
static const Schema schema = {types, TEST_COUNT(types)};

static cJSON *parse_dump(const Scene *scene, Sources *sources)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_true(scene_dump_json(scene, sources, out));
    fclose(out);
    cJSON *json = cJSON_ParseWithOpts(text, NULL, true);
    if (!json) {
        fail_msg("not JSON: %s\n%s", cJSON_GetErrorPtr(), text);
    }
    free(text);
    return json;
}

static cJSON *at(cJSON *json, const char *key)
{
    cJSON *item = cJSON_GetObjectItemCaseSensitive(json, key);
    if (!item) {
        fail_msg("no key `%s`", key);
    }
    return item;
}

// The text of a part, without blanks.
static void expect(cJSON *json, const char *key, const char *expected)
{
    char *text = cJSON_PrintUnformatted(at(json, key));
    assert_string_equal(text, expected);
    free(text);
}

static void every_type_is_written(void **state)
{
    (void)state;
    double numbers[] = {1, -0.5};
    Vec2 pairs[] = {{1, 2}, {3, 4}};
    Vec3 points[] = {{1, 2, 3}};
    Rgb colors[] = {{0.1f, 0.2f, 0.3f}};
    uint32_t indices[] = {0, 1, 2, 2, 1, 0, 3}, sizes[] = {3, 4, 0};
    const char *strings[] = {"a", "b\n"};
    const Everything values = {
        .field_BOOL = true,
        .field_INT = INT64_MIN,
        .field_NUMBER = 0.1,
        .field_QUANTITY = {60, DIM_LUMINOUS_FLUX},
        .field_PAIR = {0.25, 0.5},
        .field_VEC2 = {-1, 1e300},
        .field_VEC3 = {1, 2, (double)INFINITY},
        .field_COLOR = {0.1f, 1, 2},
        .field_EMISSION = {{5, 5, 5}, DIM_LUMINANCE, NONE_ID, true},
        .field_NUMBER_TEX = {0.3, NONE_ID},
        .field_PAIR_TEX = {{1, 2}, 7},
        .field_COLOR_TEX = {{1, 1, 1}, 3},
        .field_STRING = "say \"hi\"\\ \x01 \xc3\xa9 \xff",
        .field_CHOICE = 1,
        .field_FILE = NULL,
        .field_NODE = NONE_ID,
        .field_NUMBER_LIST = {numbers, 2},
        .field_VEC2_LIST = {pairs, 2},
        .field_VEC3_LIST = {points, 1},
        .field_COLOR_LIST = {colors, 1},
        .field_FACE_LIST = {indices, sizes, 7, 3},
        .field_STRING_LIST = {strings, 2},
    };
    Scene scene;
    assert_true(scene_init(&scene, &schema, NULL));
    scene_add_node(&scene, 0, &values, (SceneNode){.material = NONE_ID});
    cJSON *json = parse_dump(&scene, NULL);
    cJSON *fields = at(cJSON_GetArrayItem(at(json, "shapes"), 0), "fields");
    assert_int_equal(cJSON_GetArraySize(fields), PARAM_TYPE_COUNT);
    expect(fields, "BOOL", "true");
    assert_true(at(fields, "INT")->valuedouble == -0x1p63);
    assert_true(at(fields, "NUMBER")->valuedouble == 0.1);
    expect(fields, "QUANTITY", "{\"value\":60,\"unit\":\"lm\"}");
    expect(fields, "PAIR", "[0.25,0.5]");
    expect(fields, "VEC2", "[-1,1e+300]");
    expect(fields, "VEC3", "[1,2,\"inf\"]");
    expect(fields, "COLOR", "[0.1,1,2]");
    expect(fields, "EMISSION", "{\"value\":5,\"unit\":\"nit\",\"texture\":null}");
    expect(fields, "NUMBER_TEX", "{\"value\":0.3,\"texture\":null}");
    expect(fields, "PAIR_TEX", "{\"value\":[1,2],\"texture\":7}");
    expect(fields, "COLOR_TEX", "{\"value\":[1,1,1],\"texture\":3}");
    assert_string_equal(at(fields, "STRING")->valuestring,
                        "say \"hi\"\\ \x01 \xc3\xa9 \xef\xbf\xbd");
    expect(fields, "CHOICE", "\"large\"");
    expect(fields, "FILE", "null");
    expect(fields, "NODE", "null");
    expect(fields, "NUMBER_LIST", "[1,-0.5]");
    expect(fields, "VEC2_LIST", "[[1,2],[3,4]]");
    expect(fields, "VEC3_LIST", "[[1,2,3]]");
    expect(fields, "COLOR_LIST", "[[0.1,0.2,0.3]]");
    expect(fields, "FACE_LIST", "[[0,1,2],[2,1,0,3],[]]");
    expect(fields, "STRING_LIST", "[\"a\",\"b\\n\"]");
    cJSON_Delete(json);
    scene_free(&scene);
}

static void everything_else_is_there(void **state)
{
    (void)state;
    Arena arena = {0};
    Sources sources;
    sources_init(&sources, &arena);
    uint32_t file = sources_add(&sources, "d\xc3\xadr/a \"b\".scn", "/x/a.scn",
                                STR("one\ntwo three\n"), (Span){0});
    Scene scene;
    assert_true(scene_init(&scene, &schema, NULL));
    scene.hash = 0x0123456789abcdef;
    array_push(&scene.params, (SceneParam){"count", "9"});
    Affine move = affine_translation(vec3(1, 2, 3));
    uint32_t transform = scene_add_transform(&scene, &move);
    uint32_t name = scene_add_name(&scene, STR("hero"));
    scene_add_node(&scene, 2, NULL, (SceneNode){.name = name});
    scene_add_node(&scene, 1, NULL, (SceneNode){.at = {file, 4, 7}});
    scene.light_colors.items[0] = (Rgb){1, 0.5f, 0.25f};
    uint32_t prototype = scene_add_prototype(&scene, name, (Span){file, 0, 3});
    Everything values = {.field_NODE = NONE_ID};
    scene_add_node(&scene, 0, &values,
                   (SceneNode){.material = 0,
                               .transform = transform,
                               .prototype = prototype,
                               .name = name,
                               .flags = NODE_LIGHT_ONLY,
                               .at = {file, 8, 13}});
    scene_add_instance(&scene, (SceneInstance){prototype, transform, NONE_ID, 0, {file, 8, 9}});
    float positions[] = {0, 0, 0, 1, 0, 0, 0, 2, -1};
    uint32_t triangle[] = {0, 1, 2};
    scene_add_mesh(&scene, (Mesh){.origin = {10, 0, 0},
                                  .positions = positions,
                                  .uvs = positions,
                                  .triangles = triangle,
                                  .vertex_count = 3,
                                  .triangle_count = 1,
                                  .degenerate = 4});
    scene_add_mesh(&scene, (Mesh){0});
    cJSON *json = parse_dump(&scene, &sources);
    expect(json, "version", "1");
    expect(json, "hash", "\"0123456789abcdef\"");
    expect(json, "camera", "null");
    expect(json, "params", "[{\"name\":\"count\",\"value\":\"9\"}]");
    expect(json, "materials",
           "[{\"id\":0,\"kind\":\"paint\",\"name\":\"hero\",\"fields\":{},\"place\":null}]");
    expect(json, "lights",
           "[{\"id\":0,\"kind\":\"lamp\",\"name\":null,\"color\":[1,0.5,0.25],\"transform\":null,"
           "\"fields\":{},\"place\":\"d\xc3\xadr/a \\\"b\\\".scn:2:1\"}]");
    cJSON *shape = cJSON_GetArrayItem(at(json, "shapes"), 0);
    expect(shape, "name", "\"hero\"");
    expect(shape, "prototype", "1");
    expect(shape, "light_only", "true");
    expect(shape, "material", "0");
    expect(shape, "transform", "[[1,0,0,1],[0,1,0,2],[0,0,1,3]]");
    expect(shape, "place", "\"d\xc3\xadr/a \\\"b\\\".scn:2:5\"");
    expect(json, "prototypes",
           "[{\"id\":0,\"shapes\":0,\"name\":null,\"place\":null},{\"id\":1,\"shapes\":1,"
           "\"name\":\"hero\",\"place\":\"d\xc3\xadr/a \\\"b\\\".scn:1:1\"}]");
    expect(json, "instances",
           "[{\"id\":0,\"prototype\":1,\"name\":null,\"material\":null,"
           "\"transform\":[[1,0,0,1],[0,1,0,2],[0,0,1,3]],"
           "\"place\":\"d\xc3\xadr/a \\\"b\\\".scn:2:5\"}]");
    expect(json, "meshes",
           "[{\"id\":0,\"vertices\":3,\"triangles\":1,\"normals\":false,\"uvs\":true,"
           "\"colors\":false,\"degenerate\":4,\"not_finite\":0,"
           "\"bounds\":[[10,0,-1],[11,2,0]]},"
           "{\"id\":1,\"vertices\":0,\"triangles\":0,\"normals\":false,\"uvs\":false,"
           "\"colors\":false,\"degenerate\":0,\"not_finite\":0,\"bounds\":null}]");
    static const char *const empty[] = {"textures", "falloffs", "attenuations", "cameras",
                                        "settings"};
    for (size_t i = 0; i < TEST_COUNT(empty); ++i) {
        expect(json, empty[i], "[]");
    }
    cJSON_Delete(json);
    scene_free(&scene);
    sources_free(&sources);
    arena_free(&arena);
}

static void numbers_read_back(void **state)
{
    (void)state;
    uint64_t bits = 1234567;
    for (int i = 0; i < 100000; ++i) {
        bits = bits * 6364136223846793005u + 1442695040888963407u;
        double value;
        memcpy(&value, &bits, sizeof value);
        float narrow;
        memcpy(&narrow, &bits, sizeof narrow);
        char *text = NULL;
        size_t size;
        FILE *out = open_memstream(&text, &size);
        json_number(out, value);
        fputc(' ', out);
        json_float(out, narrow);
        fclose(out);
        char *after = text;
        if (isfinite(value)) {
            assert_true(strtod(text, &after) == value);
        }
        if (isfinite(narrow)) {
            assert_true(strtof(strchr(text, ' '), NULL) == narrow);
        }
        assert_true(size < 50);
        free(text);
    }
}

// A full disk is noticed.
static void write_errors_are_noticed(void **state)
{
    (void)state;
    Scene scene;
    assert_true(scene_init(&scene, &schema, NULL));
    FILE *full = fopen("/dev/full", "w");
    assert_non_null(full);
    setvbuf(full, NULL, _IONBF, 0);
    assert_false(scene_dump_json(&scene, NULL, full));
    fclose(full);
    scene_free(&scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_is_written),
        cmocka_unit_test(everything_else_is_there),
        cmocka_unit_test(numbers_read_back),
        cmocka_unit_test(write_errors_are_noticed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
