#include "export/export.h"

#include "export/targets.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

const ExportTarget export_targets[] = {
    {"povray", "POV-Ray 3.7", "pov", "a scene for POV-Ray 3.7", povray_write},
    {"blender", "Blender 3.4", "py", "a Python script that builds the scene in Blender, for Cycles",
     blender_write},
    {"json", "JSON", "json", "the flat scene, for any program (docs/scene.schema.json)",
     json_write},
    {0},
};

const ExportTarget *export_target_find(const char *name)
{
    for (const ExportTarget *target = export_targets; target->name; ++target) {
        if (strcmp(target->name, name) == 0) {
            return target;
        }
    }
    return NULL;
}

// --- Notes ---------------------------------------------------------------------------------------

static bool same_span(Span a, Span b)
{
    return a.file == b.file && a.begin == b.begin && a.end == b.end;
}

void export_note(Export *e, Span at, const char *format, ...)
{
    if (!e->collecting) {
        return;
    }
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    ExportNotes *notes = e->notes;
    for (size_t i = 0; i < notes->list.count; ++i) {
        if (same_span(notes->list.items[i].at, at) &&
            strcmp(notes->list.items[i].text, text) == 0) {
            return;
        }
    }
    const char *kept = arena_copy_string(&notes->arena, text, strlen(text));
    if (!kept || !array_push(&notes->list, (ExportNote){at, kept})) {
        notes->out_of_memory = true;
    }
}

static int compare_notes(const void *a, const void *b)
{
    const ExportNote *x = a, *y = b;
    if (x->at.file != y->at.file) {
        return x->at.file < y->at.file ? -1 : 1;
    }
    if (x->at.begin != y->at.begin) {
        return x->at.begin < y->at.begin ? -1 : 1;
    }
    return strcmp(x->text, y->text);
}

void export_notes_free(ExportNotes *notes)
{
    array_free(&notes->list);
    arena_free(&notes->arena);
}

const char *export_place(const Export *e, Span at, char *buffer, size_t size)
{
    const Source *source = e->sources && at.file ? source_get(e->sources, at.file) : NULL;
    buffer[0] = '\0';
    if (source) {
        const char *slash = strrchr(source->path, '/');
        Place place = source_place(e->sources, at.file, at.begin);
        snprintf(buffer, size, "%s:%" PRIu32, slash ? slash + 1 : source->path, place.line);
    }
    return buffer;
}

void export_write_notes(const Export *e, const char *prefix)
{
    for (size_t i = 0; i < e->notes->list.count; ++i) {
        const ExportNote *note = &e->notes->list.items[i];
        char place[512];
        export_place(e, note->at, place, sizeof place);
        fprintf(e->out, "%s%s%s%s\n", prefix, place, *place ? ": " : "", note->text);
    }
}

// --- Both passes ---------------------------------------------------------------------------------

bool export_check(const ExportTarget *target, const Scene *scene, Sources *sources,
                  ExportNotes *notes)
{
    FILE *nowhere = fopen("/dev/null", "w");
    if (!nowhere) {
        return false;
    }
    Export e = {scene, sources, "", nowhere, notes, true};
    target->write(&e);
    fclose(nowhere);
    if (notes->list.count > 1) {
        qsort(notes->list.items, notes->list.count, sizeof *notes->list.items, compare_notes);
    }
    return !notes->out_of_memory;
}

void export_write(const ExportTarget *target, const Scene *scene, Sources *sources,
                  const char *title, ExportNotes *notes, FILE *out)
{
    Export e = {scene, sources, title, out, notes, false};
    target->write(&e);
}
