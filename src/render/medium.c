#include "render/medium.h"

#include "render/world.h"

// So many surfaces are passed by one ray; more block it.
enum { MAX_PASSES = 256 };

// The place of the medium that fills the place; count where there is none.
static uint32_t current_index(const MediumStack *stack)
{
    uint32_t best = stack->count;
    for (uint32_t i = 0; i < stack->count; ++i) {
        if (best == stack->count ||
            stack->items[i].medium->priority >= stack->items[best].medium->priority) {
            best = i;
        }
    }
    return best;
}

const Medium *medium_current(const MediumStack *stack)
{
    uint32_t i = current_index(stack);
    return i < stack->count ? stack->items[i].medium : NULL;
}

// The place of the body whose surface this is; count where the ray isn't in it.
static uint32_t find(const MediumStack *stack, const Surface *surface)
{
    for (uint32_t i = stack->count; i-- > 0;) {
        if (stack->items[i].shape == surface->shape &&
            stack->items[i].instance == surface->instance) {
            return i;
        }
    }
    return stack->count;
}

static void remove_at(MediumStack *stack, uint32_t index)
{
    for (uint32_t i = index + 1; i < stack->count; ++i) {
        stack->items[i - 1] = stack->items[i];
    }
    --stack->count;
}

MediumBoundary medium_boundary(const World *world, const MediumStack *stack, const Surface *surface)
{
    MediumBoundary boundary = {.medium = world_material(world, surface->material)->medium};
    if (!boundary.medium) {
        return boundary;
    }
    MediumStack front = *stack; // what else there is on both sides
    uint32_t own = surface->front ? stack->count : find(stack, surface);
    bool entered = own < stack->count;
    if (entered) {
        remove_at(&front, own);
    }
    const Medium *other = medium_current(&front);
    if (surface->front) {
        boundary.hidden = other && other->priority > boundary.medium->priority;
    } else if (entered) {
        boundary.hidden = current_index(stack) != own;
    } else { // the ray began inside: as if this had been entered first
        boundary.hidden = other && other->priority >= boundary.medium->priority;
    }
    boundary.outside = other ? other->ior : boundary.medium->outside;
    return boundary;
}

void medium_cross(const World *world, MediumStack *stack, const Surface *surface)
{
    const Medium *medium = world_material(world, surface->material)->medium;
    if (!medium) {
        return;
    }
    if (!surface->front) {
        uint32_t own = find(stack, surface);
        if (own < stack->count) {
            remove_at(stack, own);
        }
        return;
    }
    if (stack->count == MEDIUM_DEPTH) {
        remove_at(stack, 0);
    }
    stack->items[stack->count].medium = medium;
    stack->items[stack->count].shape = surface->shape;
    stack->items[stack->count].instance = surface->instance;
    ++stack->count;
}

static float transmitted(float absorption, double distance)
{
    return absorption > 0 ? (float)exp(-(double)absorption * distance) : 1;
}

Rgb medium_transmittance(const Medium *medium, double distance)
{
    if (!medium) {
        return rgb_gray(1);
    }
    Rgb a = medium->absorption;
    return rgb(transmitted(a.r, distance), transmitted(a.g, distance), transmitted(a.b, distance));
}

Rgb medium_visibility(const World *world, const MediumStack *stack, const Ray *ray)
{
    if (stack->count == 0) {
        return world_visibility(world, ray);
    }
    MediumStack media = *stack;
    Rgb left = rgb_gray(1);
    Ray rest = *ray;
    for (int i = 0; i < MAX_PASSES; ++i) {
        Hit hit;
        bool free = !accel_intersect(world->accel, &rest, &hit);
        double way = free ? rest.tmax : hit.t;
        left = rgb_mul(left, medium_transmittance(medium_current(&media), way));
        if (free) {
            return left;
        }
        Surface surface;
        accel_surface(world->accel, &rest, &hit, &surface);
        if (medium_boundary(world, &media, &surface).hidden) {
            medium_cross(world, &media, &surface);
        } else {
            left = rgb_mul(left, material_pass(world, surface.material, &surface));
        }
        if (rgb_is_black(left)) {
            return left;
        }
        Ray next = surface_spawn(&surface, rest.direction);
        next.tmax = rest.tmax - dot(sub(next.origin, rest.origin), rest.direction);
        if (!(next.tmax > next.tmin)) {
            return left;
        }
        rest = next;
    }
    return rgb_gray(0);
}

MediumStack medium_around(const World *world, Vec3 point)
{
    MediumStack inside = {0}, entered = {0};
    // No axis and no diagonal, along which edges would lie.
    Ray ray = ray_make(point, normalize(vec3(0.29, 0.83, 0.47)), 0, INFINITY);
    for (int i = 0; i < MAX_PASSES; ++i) {
        Hit hit;
        if (!accel_intersect(world->accel, &ray, &hit)) {
            break;
        }
        Surface surface;
        accel_surface(world->accel, &ray, &hit, &surface);
        const Medium *medium = world_material(world, surface.material)->medium;
        if (medium && !surface.front && find(&entered, &surface) == entered.count) {
            surface.front = true; // left without having been entered: the point lies in it
            medium_cross(world, &inside, &surface);
        } else {
            medium_cross(world, &entered, &surface);
        }
        ray = surface_spawn(&surface, ray.direction);
    }
    // What is left first is innermost, as if it had been entered last.
    MediumStack out = {.count = inside.count};
    for (uint32_t i = 0; i < inside.count; ++i) {
        out.items[i] = inside.items[inside.count - 1 - i];
    }
    return out;
}
