#include "render/lamps.h"

#include "base/mem.h"

#include <string.h>

// A lamp no larger than this in both directions would be missed by trial rays; pixels.
static const double small_lamp = 4;

typedef struct Marks {
    uint8_t *items;
    uint32_t width, height;
    double reach;
} Marks;

static uint32_t clamp_to(double value, uint32_t most)
{
    return value > 0 ? (value < most ? (uint32_t)value : most) : 0;
}

// Marks the pixels whose filter reaches into the box.
static void mark_box(const Marks *marks, const FilmBox *box)
{
    const double left = box->x0 * marks->width, right = box->x1 * marks->width;
    const double top = box->y0 * marks->height, bottom = box->y1 * marks->height;
    const bool small = right - left < small_lamp && bottom - top < small_lamp;
    const uint8_t mark = small ? LAMP_EDGE : LAMP_MAYBE;
    const double reach = marks->reach + 0.5; // from a pixel's upper left corner to both sides
    const uint32_t x0 = clamp_to(floor(left - reach), marks->width);
    const uint32_t x1 = clamp_to(ceil(right + reach), marks->width);
    const uint32_t y0 = clamp_to(floor(top - reach), marks->height);
    const uint32_t y1 = clamp_to(ceil(bottom + reach), marks->height);
    for (uint32_t y = y0; y < y1; ++y) {
        for (uint32_t x = x0; x < x1; ++x) {
            uint8_t *item = &marks->items[(size_t)y * marks->width + x];
            *item = *item > mark ? *item : mark;
        }
    }
}

bool lamp_marks(const World *world, const Camera *camera, uint32_t width, uint32_t height,
                double reach, uint8_t **marks)
{
    *marks = NULL;
    if (!world->shape_lights) {
        return true;
    }
    const size_t pixels = (size_t)width * height;
    Marks all = {mem_alloc_zeroed(pixels, 1), width, height, reach};
    if (!all.items) {
        return false;
    }
    for (size_t i = 0; i < light_set_count(world->lights); ++i) {
        const Light *light = light_set_get(world->lights, i);
        FilmBox box;
        if (light->shape == NONE_ID) {
            continue;
        }
        if (!camera_film_box(camera, light->bounds, &box)) {
            // It may be seen anywhere.
            memset(all.items, LAMP_MAYBE, pixels);
            break;
        }
        mark_box(&all, &box);
    }
    *marks = all.items;
    return true;
}
