#include "lang/aside.h"

#include "base/thread.h"

// A unit's evaluator and scene, and where its parts of the scene go.
typedef struct Unit {
    Eval ev;
    Scene scene;
    Arena reports; // of the sink, for what passes by report()
    DiagSink sink;
    bool done, whole;
    uint32_t nodes, transforms, instances; // the whole scene's counts before it
    uint32_t *tables;                      // by type
    uint32_t *map; // its transforms' ids in the whole scene; NULL: they follow one another
} Unit;

struct Asides {
    Eval *outer;
    AsideWork *work;
    void *context;
    uint32_t count, ready;
    const ListMaker *list; // whose elements are made; NULL: parts of a scene are
    Unit *units;
};

enum { UNITS_EACH = 8, MOST_UNITS = 256, MOST_REFUSALS = 16, LEAST_STEPS = 1 << 16 };

static const Scene empty_scene = {.camera = NONE_ID};

// Likewise, of a list's elements: these don't touch the scene.
static uint32_t units_of_values(const Eval *ev)
{
    const Lang *lang = ev->lang;
    const bool alone = ev->aside || lang->threads < 2 || lang->observed || lang->stack ||
                       ev->region + 1 >= REGION_COUNT || ev->asides_refused >= MOST_REFUSALS;
    const uint32_t most =
        lang->threads < MOST_UNITS / UNITS_EACH ? lang->threads * UNITS_EACH : MOST_UNITS;
    return alone ? 0 : most;
}

uint32_t aside_units(const Eval *ev)
{
    const bool alone =
        ev->emitter->collecting || ev->emitter->record || ev->emitter->prototype || ev->forcing;
    return alone ? 0 : units_of_values(ev);
}

uint64_t aside_least(const Eval *ev)
{
    return ev->lang->aside_always ? 0 : LEAST_STEPS;
}

// --- Units -----------------------------------------------------------------------------------

static bool unit_init(Unit *unit, const Schema *schema)
{
    *unit = (Unit){.scene = empty_scene};
    unit->tables = mem_alloc(schema->type_count, sizeof *unit->tables);
    return unit->tables && scene_init(&unit->scene, schema, NULL);
}

static void unit_free(Unit *unit)
{
    mem_free(unit->tables);
    mem_free(unit->map);
    diag_sink_free(&unit->sink);
    arena_free(&unit->reports);
    scene_free(&unit->scene);
}

static struct Asides *make_units(Eval *ev, uint32_t count)
{
    struct Asides *all = ev->asides;
    if (!all) {
        all = ev->asides = mem_alloc_zeroed(1, sizeof *all);
    }
    if (!all || count <= all->ready) {
        return all;
    }
    Unit *units = mem_realloc(all->units, count, sizeof *units); // none is in use
    if (!units) {
        return NULL;
    }
    all->units = units;
    for (; all->ready < count; ++all->ready) {
        Unit *unit = &units[all->ready];
        if (!unit_init(unit, ev->scene->schema)) {
            unit_free(unit);
            return NULL;
        }
    }
    return all;
}

void asides_free(Eval *ev)
{
    struct Asides *all = ev->asides;
    for (uint32_t i = 0; all && i < all->ready; ++i) {
        unit_free(&all->units[i]);
    }
    if (all) {
        mem_free(all->units);
        mem_free(all);
    }
}

// As scene_init left it, with the room that it has.
static void clear_scene(Scene *scene)
{
    for (size_t i = 0; i < scene->schema->type_count; ++i) {
        scene->tables[i].count = 0;
    }
    for (int i = 0; i < CATEGORY_COUNT; ++i) {
        scene->nodes[i].count = 0;
    }
    scene->transforms.count = scene->inverses.count = scene->names.count = 1;
    scene->prototypes.items[0].shape_count = 0;
    scene->instances.count = 0;
}

// The outer evaluator as it stands, with memory and a scene of the unit's own. Of `count` units
// each may take its part of what is left of the memory; whatever wants more is done alone.
static bool begin_unit(Unit *unit, const Eval *outer, uint32_t count, bool is_caller,
                       bool of_values)
{
    enum { STACK_KEPT = 512 << 10 };
    Eval *ev = &unit->ev;
    *ev = *outer;
    const uintptr_t floor = (uintptr_t)__builtin_frame_address(0) - STACK_KEPT;
    ev->stack_floor = is_caller && outer->stack_floor > floor ? outer->stack_floor : floor;
    ev->aside = true;
    ev->asides = NULL;
    ev->aside_region = outer->region;
    const size_t left = outer->memory.limit - outer->memory.reserved;
    ev->memory = (ArenaFamily){.limit = left / count + 1}; // 0 would be none
    for (int i = 0; i < REGION_COUNT; ++i) {
        ev->regions[i] = (Arena){.on_oom = &ev->on_oom, .family = &ev->memory};
    }
    ev->region += of_values; // frames of its own are known by that
    ev->arena = &ev->regions[ev->region];
    ev->stack = (ValueArray){0};
    diag_sink_init(&unit->sink, &unit->reports);
    ev->sink = &unit->sink;
    ev->scene = &unit->scene;
    clear_scene(&unit->scene);
    ev->consed_transforms = mem_alloc_zeroed(CONS_SLOTS, sizeof *ev->consed_transforms);
    ev->first_transforms = mem_alloc(CONS_SLOTS, sizeof *ev->first_transforms);
    ev->first_transform_count = 0;
    return ev->consed_transforms && ev->first_transforms;
}

static void end_unit(Unit *unit, bool keep_values)
{
    Eval *ev = &unit->ev;
    diag_sink_free(&unit->sink);
    arena_free(&unit->reports);
    if (!keep_values) {
        array_free(&ev->stack);
    }
    for (int i = 0; i < REGION_COUNT; ++i) {
        if (!keep_values || &ev->regions[i] != ev->arena) {
            arena_free(&ev->regions[i]);
        }
    }
}

static void run_unit(void *context, uint64_t item, unsigned worker)
{
    struct Asides *all = context;
    Unit *unit = &all->units[item];
    unit->done = unit->whole = false;
    const bool values = all->list != NULL;
    if (!begin_unit(unit, all->outer, all->count, worker == 0, values)) {
        return;
    }
    if (setjmp(unit->ev.on_oom) == 0) {
        unit->whole = all->work(&unit->ev, all->context, (uint32_t)item, worker);
        unit->done = unit->ev.stop == STOP_NOT && unit->sink.count == 0;
    }
    unit->ev.arena = &unit->ev.regions[all->outer->region + values];
    end_unit(unit, values && unit->done);
}

// --- Joining ---------------------------------------------------------------------------------

// Its own 0 is the identity, as the whole scene's is.
static uint32_t joined_transform(const Unit *unit, uint32_t id)
{
    return id == 0 ? 0 : unit->map ? unit->map[id] : unit->transforms + id - 1;
}

static uint32_t new_transforms(const Unit *unit)
{
    return (uint32_t)unit->scene.transforms.count - 1;
}

// A transform of the whole scene, perhaps one that lies with a unit still.
static const Affine *find_transform(const struct Asides *all, uint32_t units, size_t before,
                                    uint32_t id)
{
    if (id < before) {
        return &all->outer->scene->transforms.items[id];
    }
    for (uint32_t u = units; u-- > 0;) {
        const Unit *unit = &all->units[u];
        if (id < unit->transforms) {
            continue;
        }
        uint32_t own = id - unit->transforms + 1;
        while (unit->map && unit->map[own] != id) { // behind, since some were left out
            ++own;
        }
        return &unit->scene.transforms.items[own];
    }
    return NULL;
}

// Where the first transforms that the unit put into its slots are those that the whole scene's
// slots hold, they would have been shared.
static bool share_transforms(struct Asides *all, uint32_t number, size_t before)
{
    Unit *unit = &all->units[number];
    const Eval *ev = &unit->ev;
    const uint32_t count = new_transforms(unit);
    for (uint32_t i = 0; i < ev->first_transform_count; ++i) {
        const uint32_t slot = ev->first_transforms[i].slot, id = ev->first_transforms[i].id;
        const ConsSlot *whole = &all->outer->consed_transforms[slot];
        if (!whole->type || whole->hash != ev->first_transforms[i].hash ||
            memcmp(find_transform(all, number, before, whole->id),
                   &unit->scene.transforms.items[id], sizeof(Affine)) != 0) {
            continue;
        }
        if (!unit->map) {
            unit->map = mem_alloc_zeroed((size_t)count + 1, sizeof *unit->map);
            if (!unit->map) {
                return false;
            }
        }
        unit->map[id] = whole->id;
    }
    uint32_t next = unit->transforms;
    for (uint32_t id = 1; unit->map && id <= count; ++id) {
        unit->map[id] = unit->map[id] ? unit->map[id] : next++;
    }
    return true;
}

static uint32_t added_transforms(const Unit *unit)
{
    const uint32_t count = new_transforms(unit);
    uint32_t added = unit->map ? 0 : count;
    for (uint32_t id = 1; unit->map && id <= count; ++id) {
        added += unit->map[id] >= unit->transforms;
    }
    return added;
}

static bool limits_allow(const Eval *outer, const Unit *unit, uint64_t steps, uint64_t objects)
{
    const Limits *limits = &outer->lang->limits;
    const Scene *scene = outer->scene;
    return outer->steps + steps <= limits->steps && outer->objects + objects <= limits->objects &&
           scene->nodes[CATEGORY_SHAPE].count + unit->scene.nodes[CATEGORY_SHAPE].count < NONE_ID &&
           scene->transforms.count + unit->scene.transforms.count < NONE_ID &&
           scene->instances.count + unit->scene.instances.count < NONE_ID;
}

typedef struct Count {
    uint64_t steps, objects;
} Count;

// Gives the unit's parts their ids. False where they aren't to be in the scene.
static bool place_unit(struct Asides *all, uint32_t number, size_t before, Count begun)
{
    Unit *unit = &all->units[number];
    Eval *outer = all->outer;
    Scene *scene = outer->scene;
    const uint64_t steps = unit->ev.steps - begun.steps;
    const uint64_t objects = unit->ev.objects - begun.objects;
    unit->nodes = (uint32_t)scene->nodes[CATEGORY_SHAPE].count;
    unit->transforms = (uint32_t)scene->transforms.count;
    unit->instances = (uint32_t)scene->instances.count;
    mem_free(unit->map);
    unit->map = NULL;
    if (!unit->done || !limits_allow(outer, unit, steps, objects) ||
        !share_transforms(all, number, before)) {
        return false;
    }
    for (size_t type = 0; type < scene->schema->type_count; ++type) {
        unit->tables[type] = (uint32_t)scene->tables[type].count;
        scene->tables[type].count += unit->scene.tables[type].count;
    }
    for (uint32_t slot = 0; slot < CONS_SLOTS; ++slot) {
        const ConsSlot *own = &unit->ev.consed_transforms[slot];
        if (own->type) {
            outer->consed_transforms[slot] = *own;
            outer->consed_transforms[slot].id = joined_transform(unit, own->id);
        }
    }
    scene->nodes[CATEGORY_SHAPE].count += unit->scene.nodes[CATEGORY_SHAPE].count;
    scene->prototypes.items[0].shape_count += unit->scene.prototypes.items[0].shape_count;
    scene->transforms.count += added_transforms(unit);
    scene->inverses.count = scene->transforms.count;
    scene->instances.count += unit->scene.instances.count;
    outer->steps += steps;
    outer->objects += objects;
    return true;
}

// Room for all that the units made.
static bool reserve(struct Asides *all)
{
    Scene *scene = all->outer->scene;
    size_t nodes = 0, transforms = 0, instances = 0;
    for (uint32_t u = 0; u < all->count; ++u) {
        nodes += all->units[u].scene.nodes[CATEGORY_SHAPE].count;
        transforms += all->units[u].scene.transforms.count;
        instances += all->units[u].scene.instances.count;
    }
    bool good = array_reserve(&scene->nodes[CATEGORY_SHAPE], nodes) &&
                array_reserve(&scene->transforms, transforms) &&
                array_reserve(&scene->inverses, transforms) &&
                array_reserve(&scene->instances, instances);
    for (size_t type = 0; good && type < scene->schema->type_count; ++type) {
        size_t count = 0;
        for (uint32_t u = 0; u < all->count; ++u) {
            count += all->units[u].scene.tables[type].count;
        }
        const size_t size = scene->schema->types[type]->size;
        SceneTable *table = &scene->tables[type];
        good = array_grow((void **)(void *)&table->items, &table->capacity, table->count, count,
                          size ? size : 1);
    }
    return good;
}

static void copy_transforms(Scene *scene, const Unit *unit)
{
    const Scene *own = &unit->scene;
    const uint32_t count = new_transforms(unit);
    if (!unit->map) {
        memcpy(scene->transforms.items + unit->transforms, own->transforms.items + 1,
               count * sizeof(Affine));
        memcpy(scene->inverses.items + unit->transforms, own->inverses.items + 1,
               count * sizeof(Affine));
        return;
    }
    for (uint32_t id = 1; id <= count; ++id) {
        if (unit->map[id] >= unit->transforms) {
            scene->transforms.items[unit->map[id]] = own->transforms.items[id];
            scene->inverses.items[unit->map[id]] = own->inverses.items[id];
        }
    }
}

static void copy_unit(void *context, uint64_t item, unsigned worker)
{
    (void)worker;
    const struct Asides *all = context;
    const Unit *unit = &all->units[item];
    const Scene *own = &unit->scene;
    Scene *scene = all->outer->scene;
    copy_transforms(scene, unit);
    SceneNode *nodes = scene->nodes[CATEGORY_SHAPE].items + unit->nodes;
    for (size_t i = 0; i < own->nodes[CATEGORY_SHAPE].count; ++i) {
        nodes[i] = own->nodes[CATEGORY_SHAPE].items[i];
        nodes[i].index += unit->tables[nodes[i].type];
        nodes[i].transform = joined_transform(unit, nodes[i].transform);
    }
    for (size_t type = 0; type < scene->schema->type_count; ++type) {
        const size_t size = scene->schema->types[type]->size;
        if (own->tables[type].count && size) {
            memcpy(scene->tables[type].items + unit->tables[type] * size, own->tables[type].items,
                   own->tables[type].count * size);
        }
    }
    SceneInstance *instances = scene->instances.items + unit->instances;
    for (size_t i = 0; i < own->instances.count; ++i) {
        instances[i] = own->instances.items[i];
        instances[i].transform = joined_transform(unit, instances[i].transform);
    }
}

// How many of the units, from the first on, are in the scene.
static uint32_t join_units(struct Asides *all)
{
    const size_t before = all->outer->scene->transforms.count;
    uint32_t joined = 0;
    if (!reserve(all)) {
        return 0;
    }
    const Count begun = {all->outer->steps, all->outer->objects}; // what each unit began with
    bool more = true;
    while (more && joined < all->count && place_unit(all, joined, before, begun)) {
        more = all->units[joined++].whole;
    }
    parallel_for(joined, all->outer->lang->threads, copy_unit, all, NULL);
    return joined;
}

// Puts the elements of a unit on the stack, and what they point to where they would lie. False
// where they aren't to be there.
static bool place_values(struct Asides *all, Unit *unit, Count begun)
{
    Eval *outer = all->outer, *ev = &unit->ev;
    const size_t count = ev->stack.count, before = outer->stack.count - all->list->base;
    const ArenaFamily *memory = &outer->memory;
    if (!unit->done || !limits_allow(outer, unit, ev->steps - begun.steps, 0) ||
        before + count > outer->lang->limits.list_length ||
        ev->arena->reserved > memory->limit - memory->reserved ||
        !array_reserve(&outer->stack, count)) {
        return false;
    }
    if (count) {
        memcpy(outer->stack.items + outer->stack.count, ev->stack.items,
               count * sizeof *ev->stack.items);
    }
    outer->stack.count += count;
    arena_adopt(outer->arena, ev->arena);
    outer->steps += ev->steps - begun.steps;
    outer->serial = ev->serial > outer->serial ? ev->serial : outer->serial;
    return true;
}

static uint32_t join_values(struct Asides *all)
{
    const Count begun = {all->outer->steps, all->outer->objects};
    uint32_t joined = 0;
    while (joined < all->count && place_values(all, &all->units[joined], begun)) {
        ++joined;
    }
    for (uint32_t u = 0; u < all->count; ++u) {
        Unit *unit = &all->units[u];
        if (unit->done) {
            arena_free(unit->ev.arena);
            array_free(&unit->ev.stack);
        }
    }
    return joined;
}

static uint32_t run_units(Eval *ev, AsideWork *work, void *context, uint32_t count,
                          const ListMaker *list)
{
    struct Asides *all = make_units(ev, count);
    if (!all) {
        ev->asides_refused = MOST_REFUSALS;
        return 0;
    }
    all->outer = ev;
    all->work = work;
    all->context = context;
    all->count = count;
    all->list = list;
    parallel_for(count, ev->lang->threads, run_unit, all, NULL);
    const uint32_t joined = list ? join_values(all) : join_units(all);
    for (uint32_t u = 0; u < count; ++u) {
        mem_free(all->units[u].ev.consed_transforms);
        mem_free(all->units[u].ev.first_transforms);
    }
    ev->asides_refused += joined < count;
    return joined;
}

uint32_t aside_run(Eval *ev, AsideWork *work, void *context, uint32_t count)
{
    return run_units(ev, work, context, count, NULL);
}

// --- Loops -----------------------------------------------------------------------------------

static uint32_t units_end(const Loop *loop, uint32_t units)
{
    const uint64_t end = loop->next + (uint64_t)units * loop->unit;
    return end < loop->sequence.count ? (uint32_t)end : loop->sequence.count;
}

static bool run_loop_unit(Eval *ev, void *context, uint32_t unit, unsigned worker)
{
    (void)worker;
    Loop loop = *(const Loop *)context;
    ListMaker list = {.base = ev->stack.count};
    loop.list = loop.list ? &list : NULL;
    const uint32_t end = units_end(&loop, unit + 1);
    for (uint32_t i = units_end(&loop, unit); i < end && loop.iteration(ev, &loop, i); ++i) {
    }
    if (list.failed) {
        must_be_alone(ev);
    }
    return true;
}

static uint32_t units_of_loop(const Eval *ev, const Loop *loop)
{
    return loop->list ? units_of_values(ev) : aside_units(ev);
}

// Further iterations, beside one another, while that goes well; `steps` is what each took so far.
static void run_beside(Eval *ev, Loop *loop, double steps)
{
    const double share = (double)(loop->sequence.count - loop->next) / units_of_loop(ev, loop);
    const double unit = ev->lang->aside_always ? 2 : fmin(ASIDE_UNIT_STEPS / steps, share);
    loop->unit = unit < 1 ? 1 : (uint32_t)unit;
    bool good = true;
    while (good && loop->next < loop->sequence.count && !ev->stop) {
        const uint32_t left = (loop->sequence.count - loop->next - 1) / loop->unit + 1;
        uint32_t units = units_of_loop(ev, loop);
        units = left < units ? left : units;
        const uint32_t done = units ? run_units(ev, run_loop_unit, loop, units, loop->list) : 0;
        loop->next = units_end(loop, done);
        good = units > 0 && done == units;
    }
}

void loop_run(Eval *ev, Loop *loop)
{
    const uint64_t begun = ev->steps;
    uint32_t look = 2; // the first iterations gave what they all need its value
    while (loop->next < loop->sequence.count && loop->iteration(ev, loop, loop->next)) {
        if (++loop->next != look) {
            continue;
        }
        look *= 2;
        const double steps = (double)(ev->steps - begun) / loop->next;
        const double left = (double)(loop->sequence.count - loop->next) * steps;
        if (left > (double)aside_least(ev) && units_of_loop(ev, loop)) {
            look = 0; // once
            run_beside(ev, loop, steps);
        }
    }
}
