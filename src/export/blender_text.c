// Numbers, vectors, maps and names in Python's syntax. JSON's numbers, strings and lists are
// Python's, too.
#include "export/blender.h"

#include "scene/json.h"

#include <stdarg.h>
#include <string.h>

void blender_print(const Blender *b, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vfprintf(b->e->out, format, arguments);
    va_end(arguments);
}

void blender_number(const Blender *b, double number)
{
    if (isfinite(number)) {
        json_number(b->e->out, number == 0 ? 0 : number); // no "-0"
    } else {
        fprintf(b->e->out, "float(\"%s\")", isnan(number) ? "nan" : number > 0 ? "inf" : "-inf");
    }
}

void blender_vec3(const Blender *b, Vec3 v)
{
    fputc('(', b->e->out);
    blender_number(b, v.x);
    fputs(", ", b->e->out);
    blender_number(b, v.y);
    fputs(", ", b->e->out);
    blender_number(b, v.z);
    fputc(')', b->e->out);
}

void blender_rgb(const Blender *b, Rgb color)
{
    FILE *out = b->e->out;
    fputc('(', out);
    json_float(out, color.r);
    fputs(", ", out);
    json_float(out, color.g);
    fputs(", ", out);
    json_float(out, color.b);
    fputc(')', out);
}

void blender_string(const Blender *b, const char *text)
{
    json_string(b->e->out, text ? text : "");
}

void blender_matrix(const Blender *b, const Affine *map)
{
    if (affine_is_identity(map)) {
        fputs("None", b->e->out);
    } else {
        json_affine(b->e->out, map);
    }
}

void blender_name(const Blender *b, const char *kind, uint32_t name, Span at)
{
    char place[512], text[640];
    if (name) {
        blender_string(b, b->e->scene->names.items[name]);
        return;
    }
    export_place(b->e, at, place, sizeof place);
    snprintf(text, sizeof text, "%s%s%s", kind, *place ? " " : "", place);
    blender_string(b, text);
}

void blender_comment(const Blender *b, const char *indent, const char *kind, uint32_t name, Span at)
{
    char place[512];
    const char *text = name ? b->e->scene->names.items[name] : "";
    FILE *out = b->e->out;
    fprintf(out, "%s# %s", indent, kind);
    if (*text) {
        fputs(" \"", out);
        for (; *text; ++text) { // a line break would end the comment
            fputc((unsigned char)*text < ' ' ? ' ' : *text, out);
        }
        fputc('"', out);
    }
    export_place(b->e, at, place, sizeof place);
    fprintf(out, "%s%s\n", *place ? ", " : "", place);
}
