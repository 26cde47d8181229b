#include "render/world.h"

#include "base/mem.h"
#include "render/camera.h"
#include "render/materials/lambert.h"
#include "render/render.h"

// The commonest material's albedo, where it depends on nothing.
static void keep_albedo(WorldMaterial *material)
{
    const Lambert *lambert = material->class == &lambert_material ? material->params : NULL;
    material->is_even = lambert && lambert->color.texture == NONE_ID;
    material->albedo = material->is_even ? unit_color(lambert->color.value) : rgb_gray(0);
}

bool world_resolve_materials(World *world)
{
    const Scene *scene = world->scene;
    size_t count = scene->nodes[CATEGORY_MATERIAL].count;
    WorldMaterial *materials = arena_array(&world->arena, count + 2, sizeof *materials);
    if (!materials || count >= NONE_ID) {
        return false;
    }
    world->materials = materials;
    world->material_count = (uint32_t)count;
    for (uint32_t i = 0; i < count; ++i) {
        const SceneNode *node = scene_node(scene, CATEGORY_MATERIAL, i);
        materials[i].class = (const MaterialClass *)scene_node_type(scene, node);
        materials[i].params = scene_params(scene, node);
        materials[i].medium = NULL;
    }
    materials[count] = (WorldMaterial){.class = &lambert_material, .params = &lambert_default};
    materials[count + 1] = (WorldMaterial){.class = &lambert_material, .params = &lambert_black};
    for (uint32_t i = 0; i < count + 2; ++i) {
        keep_albedo(&materials[i]);
    }
    for (uint32_t i = 0; i <= count; ++i) {
        materials[i].lobes = material_lobes(world, i);
        materials[i].whole = material_needs_whole(world, i);
        world->all_lobes |= materials[i].lobes;
        Medium medium;
        if (material_medium(world, i, &medium)) {
            Medium *kept = ARENA_NEW(&world->arena, Medium);
            if (!kept) {
                return false;
            }
            *kept = medium;
            materials[i].medium = kept;
            world->media = true;
        }
    }
    return true;
}

// The bodies that a camera stands in, for the indices and absorption of the first way.
static void find_camera_media(World *world, const Camera *camera)
{
    bool any = false;
    for (uint32_t i = 0; i < world->material_count; ++i) {
        any |= world->materials[i].medium != NULL;
    }
    Ray ray;
    if (any && camera_ray(camera, 0.5, 0.5, 0.5f, 0.5f, &ray)) {
        world->camera_media = medium_around(world, ray.origin);
    }
}

// Until world_set_camera names another.
static void find_scene_camera_media(World *world)
{
    const Scene *scene = world->scene;
    if (scene->camera < scene->nodes[CATEGORY_CAMERA].count) {
        Camera camera;
        camera_prepare(&camera, scene, scene->camera, 1, 1);
        find_camera_media(world, &camera);
    }
}

// Geometry that can't be hit is left out, but not silently.
static void report_issues(const Accel *accel, DiagSink *sink)
{
    const AccelIssues issues = accel_issues(accel);
    if (issues.degenerate) {
        diag_report(sink, W0801, (Span){0},
                    "%llu shapes or triangles have no area where their transforms bring them",
                    (unsigned long long)issues.degenerate);
    }
    if (issues.not_finite) {
        diag_report(sink, W0802, (Span){0},
                    "%llu shapes are not finite where their transforms bring them",
                    (unsigned long long)issues.not_finite);
    }
}

static bool build_parts(World *world, unsigned threads, DiagSink *sink)
{
    const Scene *scene = world->scene;
    world->textures = texture_set_build(scene, sink);
    if (!world->textures) {
        return false;
    }
    world->accel = accel_build(scene, threads);
    if (!world->accel || !world_resolve_materials(world)) {
        diag_report(sink, E0001, (Span){0}, "no memory to make the scene ready for rendering");
        return false;
    }
    find_scene_camera_media(world);
    report_issues(world->accel, sink);
    world->lights = light_set_build(world, &world->arena, sink);
    if (!world->lights) {
        return false;
    }
    world->light_items = light_set_items(world->lights);
    world->only_light = light_set_only(world->lights);
    if (scene_render(scene).caustics != CAUSTICS_PLAIN &&
        !guide_build(world, &world->arena, &world->guide)) {
        diag_report(sink, E0001, (Span){0}, "no memory to look for light by way of mirrors");
        return false;
    }
    return true;
}

World *world_build(const Scene *scene, unsigned threads, DiagSink *sink)
{
    World *world = mem_alloc_zeroed(1, sizeof *world);
    if (!world) {
        diag_report(sink, E0001, (Span){0}, "no memory to make the scene ready for rendering");
        return NULL;
    }
    RenderParams settings = scene_render(scene);
    world->scene = scene;
    world->bounces = settings.bounces;
    world->sampling = settings.sampling;
    world->shadows = settings.shadows;
    world->russian_roulette = settings.russian_roulette;
    world->clamp = (float)settings.clamp;
    world->ao_distance = settings.ao_distance > 0 ? settings.ao_distance : INFINITY;
    world->far = INFINITY;
    if (!build_parts(world, threads, sink)) {
        world_free(world);
        return NULL;
    }
    return world;
}

void world_set_camera(World *world, const Camera *camera)
{
    const Box3 box = accel_bounds(world->accel);
    const bool axis = camera->params.projection == CAMERA_PERSPECTIVE ||
                      camera->params.projection == CAMERA_ORTHOGRAPHIC;
    find_camera_media(world, camera);
    world->camera = camera;
    world->near = INFINITY;
    world->far = 0;
    if (box3_is_empty(box)) {
        world->near = 0;
        world->far = INFINITY;
        return;
    }
    for (int corner = 0; corner < 8; ++corner) {
        const double depth = camera_depth(camera, box3_corner(box, corner));
        world->near = fmin(world->near, depth);
        world->far = fmax(world->far, depth);
    }
    // By distance, what is nearest is not a corner.
    world->near = axis ? fmax(world->near, 0) : 0;
}

void world_free(World *world)
{
    if (!world) {
        return;
    }
    light_set_free(world->lights);
    accel_free(world->accel);
    texture_set_free(world->textures);
    arena_free(&world->arena);
    mem_free(world);
}

double world_radius(const World *world)
{
    Box3 box = accel_bounds(world->accel);
    double radius = box3_is_empty(box) ? 1 : length(sub(box.max, box.min)) / 2;
    return isfinite(radius) && radius > 0 ? radius : 1;
}

// So many surfaces that let light pass are crossed by one shadow ray; more block it.
enum { MAX_PASSES = 256 };

Rgb world_visibility(const World *world, const Ray *ray)
{
    if (!(world->all_lobes & LOBE_PASS)) {
        return rgb_gray(accel_occluded(world->accel, ray) ? 0.0f : 1.0f);
    }
    Rgb passed = rgb_gray(1);
    Ray rest = *ray;
    for (int i = 0; i < MAX_PASSES; ++i) {
        Hit hit;
        if (!accel_intersect(world->accel, &rest, &hit)) {
            return passed;
        }
        Surface surface;
        accel_surface(world->accel, &rest, &hit, &surface);
        passed = rgb_mul(passed, material_pass(world, surface.material, &surface));
        if (rgb_is_black(passed)) {
            return passed;
        }
        // The rest of the way, from beyond the surface.
        Ray next = surface_spawn(&surface, rest.direction);
        next.tmax = rest.tmax - dot(sub(next.origin, rest.origin), rest.direction);
        if (!(next.tmax > next.tmin)) {
            return passed;
        }
        rest = next;
    }
    return rgb_gray(0);
}
