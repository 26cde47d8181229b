#include "watch/inspect.h"

#include "base/hash.h"
#include "base/mem.h"
#include "schema/photometry.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

enum { MOST_LIGHTS = 1024, LIGHT_SAMPLES = 16384, SAMPLES_OF_LIGHT = 256, LISTED_LIGHTS = 3 };

typedef struct Seen {
    const Snapshot *picture;
    Loaded *loaded;
    const World *world;
    Ray ray;
    Hit hit;
    Surface surface;
    bool has_ray, is_hit;
} Seen;

static Seen look_at(const Snapshot *picture, double x, double y)
{
    Seen seen = {.picture = picture, .loaded = picture->loaded, .world = picture->loaded->world};
    seen.has_ray = camera_ray(&picture->camera, x, y, 0.5f, 0.5f, &seen.ray);
    seen.is_hit = seen.has_ray && accel_intersect(seen.world->accel, &seen.ray, &seen.hit);
    if (seen.is_hit) {
        accel_surface(seen.world->accel, &seen.ray, &seen.hit, &seen.surface);
    }
    return seen;
}

double inspect_depth(const Snapshot *picture, double x, double y)
{
    Seen seen = look_at(picture, x, y);
    return seen.is_hit ? camera_depth(&picture->camera, seen.surface.p) : NAN;
}

double inspect_pivot(const Snapshot *picture)
{
    Seen seen = look_at(picture, 0.5, 0.5);
    if (seen.is_hit) {
        return seen.hit.t;
    }
    Box3 box = accel_bounds(picture->loaded->world->accel);
    double depth = box3_is_empty(box) ? NAN : camera_depth(&picture->camera, box3_center(box));
    return isfinite(depth) && depth > 1e-6 ? depth : world_radius(picture->loaded->world);
}

// --- Names and places ----------------------------------------------------------------------------

static void add_place(Loaded *loaded, Span at, cJSON *json)
{
    const Source *source = source_get(&loaded->lang.sources, at.file);
    if (!source) {
        return;
    }
    pthread_mutex_lock(&loaded->lock);
    Place place = source_place(&loaded->lang.sources, at.file, at.begin);
    Str line = source_line(&loaded->lang.sources, at.file, place.line);
    pthread_mutex_unlock(&loaded->lock);
    char text[200];
    size_t length = line.length < sizeof text - 1 ? line.length : sizeof text - 1;
    memcpy(text, line.at, length);
    while (length > 0 && line.length > length && ((unsigned char)text[length] & 0xc0) == 0x80) {
        --length;
    }
    text[length] = '\0';
    cJSON_AddStringToObject(json, "file", source->path);
    cJSON_AddNumberToObject(json, "line", place.line);
    cJSON_AddNumberToObject(json, "column", place.column);
    cJSON_AddStringToObject(json, "source", text);
}

static cJSON *node_json(Loaded *loaded, Category category, uint32_t id)
{
    const Scene *scene = &loaded->scene;
    const SceneNode *node = scene_node(scene, category, id);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "kind", scene_node_type(scene, node)->name);
    cJSON_AddStringToObject(json, "name", scene->names.items[node->name]);
    add_place(loaded, node->at, json);
    return json;
}

static cJSON *object_json(const Seen *seen)
{
    const Scene *scene = &seen->loaded->scene;
    cJSON *json = node_json(seen->loaded, CATEGORY_SHAPE, seen->surface.shape);
    if (seen->surface.instance != NONE_ID) {
        const SceneInstance *instance = &scene->instances.items[seen->surface.instance];
        cJSON *of = cJSON_AddObjectToObject(json, "instance");
        cJSON_AddNumberToObject(of, "number", (double)seen->surface.instance + 1);
        cJSON_AddStringToObject(of, "name", scene->names.items[instance->name]);
        add_place(seen->loaded, instance->at, of);
    }
    return json;
}

static cJSON *material_json(const Seen *seen)
{
    uint32_t id = seen->surface.material;
    if (id < seen->loaded->scene.nodes[CATEGORY_MATERIAL].count) {
        return node_json(seen->loaded, CATEGORY_MATERIAL, id);
    }
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "kind", id == MATERIAL_BLACK ? "black" : "lambert");
    cJSON_AddStringToObject(json, "name",
                            id == MATERIAL_BLACK ? "a lamp's body" : "the default material");
    return json;
}

static cJSON *light_json(const Seen *seen, uint32_t index)
{
    const Light *light = light_set_get(seen->world->lights, index);
    return light->node != NONE_ID ? node_json(seen->loaded, CATEGORY_LIGHT, light->node)
                                  : node_json(seen->loaded, CATEGORY_SHAPE, light->shape);
}

// --- Lights --------------------------------------------------------------------------------------

// The k-th point of a sequence that fills the unit cube evenly: Roberts 2018, "The Unreasonable
// Effectiveness of Quasirandom Sequences", R3.
static Vec3 even_point(uint32_t k)
{
    const double g = 1.22074408460575947536;
    double x = 0.5 + k / g, y = 0.5 + k / (g * g), z = 0.5 + k / (g * g * g);
    return vec3(x - floor(x), y - floor(y), z - floor(z));
}

// One estimate of what a light gives to the side of the surface that is seen: irradiance as its
// luminance, W/m², with what stands in between.
static double sample_light(const Seen *seen, Vec3 normal, const Light *light, Vec3 u)
{
    const Surface *surface = &seen->surface;
    LightSample sample;
    if (!light->class->sample ||
        !light->class->sample(seen->world, light, surface->p, u.x, u.y, u.z, &sample)) {
        return 0;
    }
    double cosine = dot(normal, sample.direction);
    if (!(cosine > 0) || !(sample.pdf > 0)) {
        return 0;
    }
    Ray ray = light_sample_ray(surface, &sample);
    Rgb passed = rgb_mul(sample.value, world_visibility(seen->world, &ray));
    double estimate = (double)luminance(passed) * cosine / (double)sample.pdf;
    return isfinite(estimate) ? estimate : 0;
}

// The irradiance from each light of the world at the point that is seen, estimated.
static double *light_irradiances(const Seen *seen, size_t count)
{
    double *sums = mem_alloc_zeroed(count, sizeof *sums);
    const LightSet *lights = seen->world->lights;
    Vec3 normal = seen->surface.geometric;
    normal = dot(normal, seen->ray.direction) > 0 ? neg(normal) : normal;
    if (sums && count <= MOST_LIGHTS) {
        uint32_t samples = (uint32_t)(LIGHT_SAMPLES / count);
        samples = samples < SAMPLES_OF_LIGHT ? samples : SAMPLES_OF_LIGHT;
        for (size_t i = 0; i < count; ++i) {
            for (uint32_t k = 0; k < samples; ++k) {
                sums[i] += sample_light(seen, normal, light_set_get(lights, i), even_point(k));
            }
            sums[i] /= samples;
        }
    } else if (sums) {
        LightReceiver receiver = {seen->surface.p, normal};
        for (uint32_t k = 0; k < LIGHT_SAMPLES; ++k) {
            float chance;
            double choice = (double)hash_to_float(hash_u32(k));
            uint32_t i = light_choose(lights, &receiver, choice, &chance);
            if (i != NONE_ID && chance > 0) {
                sums[i] += sample_light(seen, normal, light_set_get(lights, i), even_point(k)) /
                           (double)chance / LIGHT_SAMPLES;
            }
        }
    }
    return sums;
}

static void add_lights(const Seen *seen, cJSON *json)
{
    size_t count = light_set_count(seen->world->lights);
    double *irradiances = count > 0 ? light_irradiances(seen, count) : NULL;
    cJSON *list = cJSON_AddArrayToObject(json, "lights");
    double all = 0;
    for (size_t i = 0; irradiances && i < count; ++i) {
        all += irradiances[i];
    }
    cJSON_AddNumberToObject(json, "irradiance", all);
    for (int rank = 0; irradiances && rank < LISTED_LIGHTS; ++rank) {
        size_t best = 0;
        for (size_t i = 1; i < count; ++i) {
            best = irradiances[i] > irradiances[best] ? i : best;
        }
        if (!(irradiances[best] > 0)) {
            break;
        }
        cJSON *light = light_json(seen, (uint32_t)best);
        cJSON_AddNumberToObject(light, "irradiance", irradiances[best]);
        cJSON_AddNumberToObject(light, "illuminance", irradiances[best] * LUMENS_PER_WATT);
        cJSON_AddNumberToObject(light, "share", irradiances[best] / all);
        cJSON_AddItemToArray(list, light);
        irradiances[best] = 0;
    }
    mem_free(irradiances);
}

// The lights at infinity that a ray into the open sees.
static void add_surroundings(const Seen *seen, cJSON *json)
{
    cJSON *list = cJSON_AddArrayToObject(json, "lights");
    uint32_t count;
    const uint32_t *infinite = light_set_infinite(seen->world->lights, &count);
    for (uint32_t i = 0; seen->has_ray && i < count && i < LISTED_LIGHTS; ++i) {
        const Light *light = light_set_get(seen->world->lights, infinite[i]);
        Rgb radiance = light->class->escaped
                           ? light->class->escaped(seen->world, light, seen->ray.direction)
                           : rgb_gray(0);
        if (!rgb_is_black(radiance)) {
            cJSON_AddItemToArray(list, light_json(seen, infinite[i]));
        }
    }
}

// --- The report ----------------------------------------------------------------------------------

static void add_vector(cJSON *json, const char *name, Vec3 v)
{
    cJSON_AddItemToObject(json, name, cJSON_CreateDoubleArray((double[]){v.x, v.y, v.z}, 3));
}

static void add_radiance(const Snapshot *picture, double x, double y, cJSON *json)
{
    uint32_t column = (uint32_t)(x * picture->width), row = (uint32_t)(y * picture->height);
    column = column < picture->width ? column : picture->width - 1;
    row = row < picture->height ? row : picture->height - 1;
    size_t p = (size_t)row * picture->width + column;
    const float *r = picture->radiance + 3 * p;
    double seen = (double)luminance(rgb(r[0], r[1], r[2]));
    cJSON_AddNumberToObject(json, "x", column);
    cJSON_AddNumberToObject(json, "y", row);
    cJSON_AddBoolToObject(json, "coarse", picture->coarse);
    add_vector(json, "radiance", vec3((double)r[0], (double)r[1], (double)r[2]));
    cJSON_AddNumberToObject(json, "luminance", seen * LUMENS_PER_WATT);
    double error = sqrt((double)picture->variance[p]) * LUMENS_PER_WATT;
    if (isfinite(error)) {
        cJSON_AddNumberToObject(json, "luminance_error", error);
    }
}

Text inspect_json(const Snapshot *picture, double x, double y)
{
    Seen seen = look_at(picture, x, y);
    cJSON *json = cJSON_CreateObject();
    add_radiance(picture, x, y, json);
    cJSON_AddBoolToObject(json, "hit", seen.is_hit);
    if (seen.is_hit) {
        cJSON_AddItemToObject(json, "object", object_json(&seen));
        cJSON_AddItemToObject(json, "material", material_json(&seen));
        add_vector(json, "position", seen.surface.p);
        add_vector(json, "normal", seen.surface.shading);
        cJSON_AddBoolToObject(json, "front", seen.surface.front);
        cJSON_AddNumberToObject(json, "depth", camera_depth(&picture->camera, seen.surface.p));
        cJSON_AddNumberToObject(json, "distance", seen.hit.t);
        uint32_t own = light_of_surface(seen.world, &seen.surface);
        if (own != NONE_ID) {
            cJSON_AddItemToObject(json, "emits", light_json(&seen, own));
        }
        add_lights(&seen, json);
    } else {
        add_surroundings(&seen, json);
    }
    Text text = {0};
    char *printed = cJSON_PrintUnformatted(json);
    if (printed) {
        text_write(&text, printed, strlen(printed));
        cJSON_free(printed);
    } else {
        text.failed = true;
    }
    cJSON_Delete(json);
    return text;
}
