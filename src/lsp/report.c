#include "lsp/report.h"

#include "lsp/json.h"

#include <stdlib.h>

void report_free(Report *report)
{
    array_free(&report->items);
    array_free(&report->values);
    arena_free(&report->arena);
    *report = (Report){0};
}

static const char *copy(Report *report, const char *text)
{
    return text ? arena_copy_string(&report->arena, text, strlen(text)) : NULL;
}

// --- From a run ----------------------------------------------------------------------------------

// The paths of the sources, copied once each.
typedef struct Paths {
    const char **items;
    uint32_t count;
} Paths;

static Paths copy_paths(Report *report, const Sources *sources)
{
    uint32_t count = sources->count + 1;
    Paths paths = {arena_array(&report->arena, count, sizeof *paths.items), count};
    for (uint32_t i = 0; paths.items && i < count; ++i) {
        const Source *source = source_get(sources, i);
        paths.items[i] = source ? copy(report, source->real) : NULL;
    }
    return paths;
}

static FilePlace place(Paths paths, Span span)
{
    const char *path = paths.items && span.file < paths.count ? paths.items[span.file] : NULL;
    return (FilePlace){path, span.begin, span.end};
}

static void take_notes(Report *report, ReportItem *item, const DiagNote *notes)
{
    for (const DiagNote *note = notes; note; note = note->next) {
        ++item->note_count;
    }
    item->notes = arena_array(&report->arena, item->note_count, sizeof *item->notes);
    if (!item->notes) {
        item->note_count = 0;
        return;
    }
    uint32_t i = 0;
    for (const DiagNote *note = notes; note; note = note->next) {
        item->notes[i++] = copy(report, note->text);
    }
}

static void take_links(Report *report, ReportItem *item, const Diag *diag, Paths paths)
{
    for (const DiagFrame *frame = diag->frames; frame; frame = frame->next) {
        ++item->link_count;
    }
    item->links = arena_array(&report->arena, item->link_count, sizeof *item->links);
    if (!item->links) {
        item->link_count = 0;
        return;
    }
    uint32_t i = 0;
    for (const DiagFrame *frame = diag->frames; frame; frame = frame->next) {
        item->links[i++] = (ReportLink){place(paths, frame->at), copy(report, frame->text)};
    }
}

static bool take_diag(Report *report, const Diag *diag, Paths paths)
{
    ReportItem item = {.code = diag->code,
                       .severity = diag->severity,
                       .at = place(paths, diag->at),
                       .fix_at = place(paths, diag->fix_at),
                       .message = copy(report, diag->message),
                       .label = copy(report, diag->label),
                       .fix_text = copy(report, diag->fix_text)};
    take_notes(report, &item, diag->notes);
    take_links(report, &item, diag, paths);
    return item.message && array_push(&report->items, item);
}

bool report_take(Report *report, Lang *lang, const Observations *observed)
{
    Paths paths = copy_paths(report, &lang->sources);
    bool good = paths.items != NULL;
    for (uint32_t i = 0; i < lang->sink.count; ++i) {
        good = take_diag(report, &lang->sink.items[i], paths) && good;
    }
    for (size_t i = 0; observed && i < observed->items.count; ++i) {
        const Observation *seen = &observed->items.items[i];
        ReportValue value = {.name = place(paths, seen->name),
                             .times = seen->times,
                             .varies = seen->varies,
                             .type = copy(report, seen->type),
                             .text = copy(report, seen->text)};
        if (value.type && value.text) {
            good = array_push(&report->values, value) && good;
        }
    }
    return good;
}

// --- Changes of the text -------------------------------------------------------------------------

typedef struct Edit {
    const char *path;
    uint32_t begin, end, length;
} Edit;

// False where the place was changed itself.
static bool move_place(FilePlace *at, const Edit *edit)
{
    if (!at->path || at->end < edit->begin || strcmp(at->path, edit->path) != 0) {
        return true;
    }
    if (at->begin >= edit->end && (at->begin > edit->begin || edit->end > edit->begin)) {
        at->begin = at->begin - (edit->end - edit->begin) + edit->length;
        at->end = at->end - (edit->end - edit->begin) + edit->length;
        return true;
    }
    return at->end == edit->begin && at->end > at->begin;
}

void report_edit(Report *report, const char *path, uint32_t begin, uint32_t end, uint32_t length)
{
    Edit edit = {path, begin, end, length};
    for (size_t i = 0; i < report->items.count; ++i) {
        ReportItem *item = &report->items.items[i];
        item->gone |= !move_place(&item->at, &edit);
        if (item->fix_text && !move_place(&item->fix_at, &edit)) {
            item->fix_text = NULL;
        }
        for (uint32_t k = 0; k < item->link_count; ++k) {
            move_place(&item->links[k].at, &edit);
        }
    }
    size_t kept = 0;
    for (size_t i = 0; i < report->values.count; ++i) {
        ReportValue value = report->values.items[i];
        if (move_place(&value.name, &edit)) {
            report->values.items[kept++] = value;
        }
    }
    report->values.count = kept;
}

static bool same_place(const FilePlace *a, const FilePlace *b)
{
    return a->begin == b->begin && a->end == b->end && !a->path == !b->path &&
           (!a->path || strcmp(a->path, b->path) == 0);
}

bool report_has(const Report *report, const ReportItem *item)
{
    for (size_t i = 0; i < report->items.count; ++i) {
        const ReportItem *other = &report->items.items[i];
        if (other->code == item->code && same_place(&other->at, &item->at)) {
            return true;
        }
    }
    return false;
}

// --- Values --------------------------------------------------------------------------------------

static int compare_places(const char *path, uint32_t begin, const FilePlace *other)
{
    int order = strcmp(path, other->path);
    return order ? order : (begin > other->begin) - (begin < other->begin);
}

static int compare_values(const void *a, const void *b)
{
    const ReportValue *left = a, *right = b;
    return compare_places(left->name.path, left->name.begin, &right->name);
}

static void sort_values(Report *report)
{
    if (report->values.count > 0) {
        qsort(report->values.items, report->values.count, sizeof(ReportValue), compare_values);
    }
}

const ReportValue *report_value(const Report *report, const char *path, uint32_t begin)
{
    size_t low = 0, high = report->values.count;
    while (path && low < high) {
        size_t middle = low + (high - low) / 2;
        const ReportValue *value = &report->values.items[middle];
        int order = compare_places(path, begin, &value->name);
        if (order == 0) {
            return value;
        }
        low = order > 0 ? middle + 1 : low;
        high = order < 0 ? middle : high;
    }
    return NULL;
}

// --- As JSON -------------------------------------------------------------------------------------

static cJSON *place_to_json(const FilePlace *at)
{
    cJSON *list = cJSON_CreateArray();
    cJSON_AddItemToArray(list, at->path ? cJSON_CreateString(at->path) : cJSON_CreateNull());
    cJSON_AddItemToArray(list, cJSON_CreateNumber(at->begin));
    cJSON_AddItemToArray(list, cJSON_CreateNumber(at->end));
    return list;
}

static cJSON *item_to_json(const ReportItem *item)
{
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "code", diag_info(item->code)->name);
    cJSON_AddItemToObject(json, "at", place_to_json(&item->at));
    json_add_text(json, "message", str_from(item->message));
    if (item->label) {
        json_add_text(json, "label", str_from(item->label));
    }
    if (item->fix_text) {
        cJSON_AddItemToObject(json, "fix_at", place_to_json(&item->fix_at));
        json_add_text(json, "fix", str_from(item->fix_text));
    }
    cJSON *notes = cJSON_AddArrayToObject(json, "notes");
    for (uint32_t i = 0; i < item->note_count; ++i) {
        cJSON_AddItemToArray(notes, json_text(str_from(item->notes[i] ? item->notes[i] : "")));
    }
    cJSON *links = cJSON_AddArrayToObject(json, "links");
    for (uint32_t i = 0; i < item->link_count; ++i) {
        cJSON *link = cJSON_CreateObject();
        cJSON_AddItemToObject(link, "at", place_to_json(&item->links[i].at));
        json_add_text(link, "text", str_from(item->links[i].text ? item->links[i].text : ""));
        cJSON_AddItemToArray(links, link);
    }
    return json;
}

cJSON *report_to_json(const Report *report)
{
    cJSON *json = cJSON_CreateObject();
    cJSON *items = cJSON_AddArrayToObject(json, "items");
    for (size_t i = 0; i < report->items.count; ++i) {
        cJSON_AddItemToArray(items, item_to_json(&report->items.items[i]));
    }
    cJSON *values = cJSON_AddArrayToObject(json, "values");
    for (size_t i = 0; i < report->values.count; ++i) {
        const ReportValue *value = &report->values.items[i];
        cJSON *entry = cJSON_CreateObject();
        cJSON_AddItemToObject(entry, "at", place_to_json(&value->name));
        cJSON_AddNumberToObject(entry, "times", value->times);
        cJSON_AddBoolToObject(entry, "varies", value->varies);
        json_add_text(entry, "type", str_from(value->type));
        json_add_text(entry, "text", str_from(value->text));
        cJSON_AddItemToArray(values, entry);
    }
    return json;
}

// Places of one file share its path.
static FilePlace place_from_json(Report *report, const cJSON *json, const char **last)
{
    const char *path = cJSON_GetStringValue(cJSON_GetArrayItem(json, 0));
    if (path && (!*last || strcmp(*last, path) != 0)) {
        *last = copy(report, path);
    }
    const cJSON *begin = cJSON_GetArrayItem(json, 1), *end = cJSON_GetArrayItem(json, 2);
    bool good = cJSON_IsNumber(begin) && cJSON_IsNumber(end) && begin->valuedouble >= 0 &&
                end->valuedouble >= begin->valuedouble && end->valuedouble < UINT32_MAX;
    return good ? (FilePlace){path ? *last : NULL, (uint32_t)begin->valuedouble,
                              (uint32_t)end->valuedouble}
                : (FilePlace){0};
}

static bool item_from_json(Report *report, const cJSON *json, const char **last)
{
    const char *name = json_get_string(json, "code"), *message = json_get_string(json, "message");
    DiagCode code = name ? diag_find(str_from(name)) : DIAG_CODE_COUNT;
    if (code == DIAG_CODE_COUNT || !message) {
        return false;
    }
    const cJSON *notes = json_at(json, "notes"), *links = json_at(json, "links"), *entry;
    ReportItem item = {.code = code,
                       .severity = diag_info(code)->severity,
                       .at = place_from_json(report, json_at(json, "at"), last),
                       .fix_at = place_from_json(report, json_at(json, "fix_at"), last),
                       .message = copy(report, message),
                       .label = copy(report, json_get_string(json, "label")),
                       .fix_text = copy(report, json_get_string(json, "fix"))};
    size_t note_count = (size_t)cJSON_GetArraySize(notes);
    size_t link_count = (size_t)cJSON_GetArraySize(links);
    item.notes = arena_array(&report->arena, note_count, sizeof *item.notes);
    item.links = arena_array(&report->arena, link_count, sizeof *item.links);
    if (!item.notes || !item.links || !item.message) {
        return false;
    }
    cJSON_ArrayForEach(entry, notes)
    {
        item.notes[item.note_count++] = copy(report, cJSON_GetStringValue(entry));
    }
    cJSON_ArrayForEach(entry, links)
    {
        item.links[item.link_count++] =
            (ReportLink){place_from_json(report, json_at(entry, "at"), last),
                         copy(report, json_get_string(entry, "text"))};
    }
    return array_push(&report->items, item);
}

bool report_from_json(Report *report, const cJSON *json)
{
    const char *last = NULL;
    const cJSON *entry;
    bool good = cJSON_IsObject(json);
    cJSON_ArrayForEach(entry, json_at(json, "items"))
    {
        good = item_from_json(report, entry, &last) && good;
    }
    cJSON_ArrayForEach(entry, json_at(json, "values"))
    {
        ReportValue value = {.name = place_from_json(report, json_at(entry, "at"), &last),
                             .times = (uint32_t)json_get_number(entry, "times", 1),
                             .varies = json_get_true(entry, "varies"),
                             .type = copy(report, json_get_string(entry, "type")),
                             .text = copy(report, json_get_string(entry, "text"))};
        good = value.name.path && value.type && value.text && array_push(&report->values, value) &&
               good;
    }
    sort_values(report);
    return good;
}
