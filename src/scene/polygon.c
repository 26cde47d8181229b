#include "scene/polygon.h"

#include "base/mem.h"

void polygon_scratch_free(PolygonScratch *scratch)
{
    mem_free(scratch->points);
    mem_free(scratch->next);
    mem_free(scratch->before);
    *scratch = (PolygonScratch){0};
}

static bool make_room(PolygonScratch *scratch, size_t count)
{
    if (count <= scratch->capacity) {
        return true;
    }
    size_t capacity = count + count / 2;
    polygon_scratch_free(scratch);
    scratch->points = mem_alloc(capacity, sizeof *scratch->points);
    scratch->next = mem_alloc(capacity, sizeof *scratch->next);
    scratch->before = mem_alloc(capacity, sizeof *scratch->before);
    scratch->capacity = capacity;
    if (scratch->points && scratch->next && scratch->before) {
        return true;
    }
    polygon_scratch_free(scratch);
    return false;
}

// Newell's normal: twice the vector area, whatever the corners' plane.
static Vec3 newell_normal(const Vec3 *corners, uint32_t count)
{
    Vec3 normal = vec3(0, 0, 0);
    for (uint32_t i = 1; i + 1 < count; ++i) {
        normal = add(normal, cross(sub(corners[i], corners[0]), sub(corners[i + 1], corners[0])));
    }
    return normal;
}

// The corners without the axis along which the normal is longest, turned so that the polygon winds
// counter-clockwise. Dropping an axis, unlike turning the polygon, adds no rounding.
static void project(const Vec3 *corners, uint32_t count, Vec2 *points)
{
    Vec3 normal = newell_normal(corners, count), size = vec3_abs(normal);
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    bool flipped = vec3_get(normal, axis) < 0;
    for (uint32_t i = 0; i < count; ++i) {
        double u = vec3_get(corners[i], (axis + 1) % 3), v = vec3_get(corners[i], (axis + 2) % 3);
        points[i] = flipped ? (Vec2){v, u} : (Vec2){u, v};
    }
}

// Twice the area of a, b, c; positive where they turn left.
static double turn(Vec2 a, Vec2 b, Vec2 c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static int sign(double x)
{
    return (x > 0) - (x < 0);
}

// Left turns only, and once around: a pentagram turns left all the time, too, but its edges change
// their direction along x more than twice.
static bool is_strictly_convex(const Vec2 *points, uint32_t count)
{
    int changes = 0, last = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const Vec2 *a = &points[i], *b = &points[(i + 1) % count], *c = &points[(i + 2) % count];
        if (!(turn(*a, *b, *c) > 0)) {
            return false;
        }
        int direction = sign(b->x - a->x);
        changes += direction && last && direction != last;
        last = direction ? direction : last;
    }
    return changes <= 2;
}

static bool same(Vec2 a, Vec2 b)
{
    return a.x == b.x && a.y == b.y;
}

// True when no other corner lies in the triangle at corner `i`, its border included; corners at the
// very place of the triangle's own don't count.
static bool is_ear(const PolygonScratch *s, uint32_t i)
{
    const Vec2 a = s->points[s->before[i]], b = s->points[i], c = s->points[s->next[i]];
    if (!(turn(a, b, c) > 0)) {
        return false;
    }
    for (uint32_t j = s->next[s->next[i]]; j != s->before[i]; j = s->next[j]) {
        const Vec2 p = s->points[j];
        if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0 && !same(p, a) &&
            !same(p, b) && !same(p, c)) {
            return false;
        }
    }
    return true;
}

// The corner to cut where no ear is left (the polygon crosses or touches itself, or has no area):
// the one with the largest turn.
static uint32_t widest_turn(const PolygonScratch *s, uint32_t start)
{
    uint32_t best = start;
    double widest = -INFINITY;
    uint32_t i = start;
    do {
        double area = turn(s->points[s->before[i]], s->points[i], s->points[s->next[i]]);
        if (area > widest) {
            widest = area;
            best = i;
        }
        i = s->next[i];
    } while (i != start);
    return best;
}

static void clip_ears(PolygonScratch *s, uint32_t count, uint32_t *triangles)
{
    for (uint32_t i = 0; i < count; ++i) {
        s->next[i] = i + 1 < count ? i + 1 : 0;
        s->before[i] = i ? i - 1 : count - 1;
    }
    uint32_t at = 0, tried = 0;
    for (uint32_t left = count; left >= 3;) {
        bool ear = left == 3 || is_ear(s, at);
        if (!ear && ++tried < left) {
            at = s->next[at];
            continue;
        }
        at = ear ? at : widest_turn(s, at);
        *triangles++ = s->before[at];
        *triangles++ = at;
        *triangles++ = s->next[at];
        s->next[s->before[at]] = s->next[at];
        s->before[s->next[at]] = s->before[at];
        // The corner after the next: going on here would make a fan of slivers.
        at = s->next[s->next[at]];
        tried = 0;
        --left;
    }
}

static void make_fan(uint32_t count, uint32_t *triangles)
{
    for (uint32_t i = 1; i + 1 < count; ++i) {
        *triangles++ = 0;
        *triangles++ = i;
        *triangles++ = i + 1;
    }
}

PolygonResult polygon_triangulate(PolygonScratch *scratch, const Vec3 *corners, uint32_t count,
                                  uint32_t *triangles)
{
    if (count == 3) {
        make_fan(count, triangles);
        return POLYGON_OK;
    }
    if (!make_room(scratch, count)) {
        return POLYGON_NO_MEMORY;
    }
    project(corners, count, scratch->points);
    if (is_strictly_convex(scratch->points, count)) {
        make_fan(count, triangles);
        return POLYGON_OK;
    }
    if (count > POLYGON_LONGEST_CONCAVE) {
        return POLYGON_TOO_LONG;
    }
    clip_ears(scratch, count, triangles);
    return POLYGON_OK;
}
