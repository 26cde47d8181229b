#include "watch/inspect.h"

#include "base/hash.h"
#include "base/mem.h"
#include "render/integrators/surface_hit.h"
#include "schema/photometry.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

enum { MOST_LIGHTS = 1024, LIGHT_SAMPLES = 16384, SAMPLES_OF_LIGHT = 256, LISTED_LIGHTS = 3 };
enum { MATERIAL_SAMPLES = 1024 };

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

// What a light does at the point that is seen, with what stands in between, as luminances.
typedef struct LightEffect {
    double irradiance; // on the side that is seen, W/m²
    double radiance;   // that is scattered from it to the viewer by the material, W/m²/sr
} LightEffect;

// The k-th point of a sequence that fills the unit cube evenly: Roberts 2018, "The Unreasonable
// Effectiveness of Quasirandom Sequences", R3.
static Vec3 even_point(uint32_t k)
{
    const double g = 1.22074408460575947536;
    double x = 0.5 + k / g, y = 0.5 + k / (g * g), z = 0.5 + k / (g * g * g);
    return vec3(x - floor(x), y - floor(y), z - floor(z));
}

// Where lights are looked for, and how the material looks from the camera.
typedef struct Receiver {
    const Seen *seen;
    LightReceiver at;
    ShadingPoint point;
    const WorldMaterial *material;
} Receiver;

static Receiver make_receiver(const Seen *seen)
{
    Receiver r = {.seen = seen, .material = world_material(seen->world, seen->surface.material)};
    shading_point(seen->world, &seen->surface, seen->ray.direction, &r.point);
    Vec3 normal = seen->surface.geometric;
    r.at = (LightReceiver){seen->surface.p,
                           dot(normal, seen->ray.direction) > 0 ? neg(normal) : normal};
    return r;
}

static double finite_luminance(Rgb color, double weight)
{
    const double value = (double)luminance(color) * weight;
    return isfinite(value) ? value : 0;
}

// One estimate by a direction to the light; `weight` is what stands for the choice of the light.
// The radiance is weighted against sample_material, which finds the same light.
static void sample_light(const Receiver *r, const Light *light, float chance, double weight, Vec3 u,
                         LightEffect *sum)
{
    const Seen *seen = r->seen;
    LightSample sample;
    if (!light->class->sample ||
        !light->class->sample(seen->world, light, seen->surface.p, u.x, u.y, u.z, &sample) ||
        !(sample.pdf > 0)) {
        return;
    }
    Ray ray;
    light_sample_ray(&seen->surface, &sample, &ray);
    const Rgb passed = rgb_mul(sample.value, world_visibility(seen->world, &ray));
    if (rgb_is_black(passed)) {
        return;
    }
    weight /= (double)sample.pdf;
    const double cosine = dot(r->at.normal, sample.direction);
    if (cosine > 0) {
        sum->irradiance += finite_luminance(passed, cosine * weight);
    }
    if (r->material->lobes & LOBE_SMOOTH) {
        BsdfEval bsdf;
        material_evaluate(&r->point, r->material, to_local(&r->point.frame, sample.direction),
                          &bsdf);
        const float part = sample.delta ? 1 : power_heuristic(sample.pdf * chance, bsdf.pdf);
        sum->radiance += finite_luminance(rgb_mul(passed, bsdf.value), (double)part * weight);
    }
}

// The chance that `light` is the one that sample_light is asked about, where lights are chosen.
static float chance_of(const Receiver *r, uint32_t light, size_t count)
{
    return count <= MOST_LIGHTS ? 1 : light_chance(r->seen->world->lights, &r->at, light);
}

// The part of what a ray found that isn't sample_light's.
static float hit_part(const Receiver *r, uint32_t index, Vec3 direction, const Surface *hit,
                      const BsdfSample *s, size_t count)
{
    const Light *light = light_set_get(r->seen->world->lights, index);
    if (s->lobes & LOBE_DELTA || !light->class->pdf || !light->class->sample) {
        return 1;
    }
    return power_heuristic(s->pdf,
                           chance_of(r, index, count) *
                               light->class->pdf(r->seen->world, light, r->at.p, direction, hit));
}

// One estimate by a direction that the material chooses: what mirrors show, and lights that are
// hard to sample.
static void sample_material(const Receiver *r, Vec3 u, size_t count, double weight,
                            LightEffect *effects)
{
    const World *world = r->seen->world;
    BsdfSample s;
    if (!material_choose(&r->point, r->material, (float)u.z, (float)u.x, (float)u.y, &s) ||
        s.lobes & LOBE_PASS) {
        return;
    }
    const Vec3 direction = renormalize(from_local(&r->point.frame, s.wi));
    const Ray ray = surface_spawn(&r->seen->surface, direction);
    Hit hit;
    if (accel_intersect(world->accel, &ray, &hit)) {
        Surface surface;
        accel_surface(world->accel, &ray, &hit, &surface);
        const uint32_t index = light_of_surface(world, &surface);
        const Light *light = index != NONE_ID ? light_set_get(world->lights, index) : NULL;
        if (light && light->class->emitted) {
            const Rgb found = rgb_mul(s.weight, light->class->emitted(world, light, &surface));
            const float part = hit_part(r, index, direction, &surface, &s, count);
            effects[index].radiance += finite_luminance(found, (double)part * weight);
        }
        return;
    }
    uint32_t infinite_count;
    const uint32_t *infinite = light_set_infinite(world->lights, &infinite_count);
    for (uint32_t i = 0; i < infinite_count; ++i) {
        const Light *light = light_set_get(world->lights, infinite[i]);
        const Rgb found = rgb_mul(s.weight, light->class->escaped(world, light, direction, NULL));
        const float part = hit_part(r, infinite[i], direction, NULL, &s, count);
        effects[infinite[i]].radiance += finite_luminance(found, (double)part * weight);
    }
}

// The effects of all lights of the world at the point that is seen, estimated.
static LightEffect *light_effects(const Seen *seen, size_t count)
{
    LightEffect *effects = mem_alloc_zeroed(count, sizeof *effects);
    const LightSet *lights = seen->world->lights;
    if (!effects) {
        return NULL;
    }
    const Receiver r = make_receiver(seen);
    uint32_t samples = (uint32_t)(LIGHT_SAMPLES / count);
    samples = samples < SAMPLES_OF_LIGHT ? samples : SAMPLES_OF_LIGHT;
    for (size_t i = 0; count <= MOST_LIGHTS && i < count; ++i) {
        for (uint32_t k = 0; k < samples; ++k) {
            sample_light(&r, light_set_get(lights, i), 1, 1.0 / samples, even_point(k),
                         &effects[i]);
        }
    }
    for (uint32_t k = 0; count > MOST_LIGHTS && k < LIGHT_SAMPLES; ++k) {
        float chance;
        const uint32_t i = light_choose(lights, &r.at, (double)hash_to_float(hash_u32(k)), &chance);
        if (i != NONE_ID && chance > 0) {
            sample_light(&r, light_set_get(lights, i), chance, 1 / ((double)chance * LIGHT_SAMPLES),
                         even_point(k), &effects[i]);
        }
    }
    for (uint32_t k = 0; k < MATERIAL_SAMPLES; ++k) {
        sample_material(&r, even_point(k), count, 1.0 / MATERIAL_SAMPLES, effects);
    }
    return effects;
}

// Those that give the viewer most; where the material sends nothing to the viewer (it is black, or
// what is seen is behind it), those that give the surface most.
static void add_lights(const Seen *seen, cJSON *json)
{
    const size_t count = light_set_count(seen->world->lights);
    LightEffect *effects = count > 0 ? light_effects(seen, count) : NULL;
    cJSON *list = cJSON_AddArrayToObject(json, "lights");
    double irradiance = 0, radiance = 0;
    for (size_t i = 0; effects && i < count; ++i) {
        irradiance += effects[i].irradiance;
        radiance += effects[i].radiance;
    }
    cJSON_AddNumberToObject(json, "irradiance", irradiance);
    cJSON_AddNumberToObject(json, "direct_luminance", radiance * LUMENS_PER_WATT);
    for (int rank = 0; effects && rank < LISTED_LIGHTS; ++rank) {
        size_t best = 0;
        double most = 0;
        for (size_t i = 0; i < count; ++i) {
            const double effect = radiance > 0 ? effects[i].radiance : effects[i].irradiance;
            best = effect > most ? i : best;
            most = fmax(effect, most);
        }
        if (!(most > 0)) {
            break;
        }
        cJSON *light = light_json(seen, (uint32_t)best);
        cJSON_AddNumberToObject(light, "irradiance", effects[best].irradiance);
        cJSON_AddNumberToObject(light, "illuminance", effects[best].irradiance * LUMENS_PER_WATT);
        cJSON_AddNumberToObject(light, "luminance", effects[best].radiance * LUMENS_PER_WATT);
        cJSON_AddNumberToObject(light, "share", most / (radiance > 0 ? radiance : irradiance));
        cJSON_AddItemToArray(list, light);
        effects[best] = (LightEffect){0, 0};
    }
    mem_free(effects);
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
                           ? light->class->escaped(seen->world, light, seen->ray.direction, NULL)
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
