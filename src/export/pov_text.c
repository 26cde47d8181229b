// Numbers, vectors and maps in POV-Ray's syntax.
#include "export/pov.h"

#include "scene/json.h"

void pov_number(const Pov *pov, double number)
{
    json_number(pov->e->out, number == 0 ? 0 : number); // no "-0"
}

void pov_triple(const Pov *pov, Vec3 v)
{
    FILE *out = pov->e->out;
    fputc('<', out);
    pov_number(pov, v.x);
    fputs(", ", out);
    pov_number(pov, v.y);
    fputs(", ", out);
    pov_number(pov, v.z);
    fputc('>', out);
}

void pov_point(const Pov *pov, Vec3 v)
{
    pov_triple(pov, vec3(v.x, v.y, -v.z));
}

void pov_pair(const Pov *pov, double x, double y)
{
    fputc('<', pov->e->out);
    pov_number(pov, x);
    fputs(", ", pov->e->out);
    pov_number(pov, y);
    fputc('>', pov->e->out);
}

void pov_rgb(const Pov *pov, Rgb color)
{
    FILE *out = pov->e->out;
    fputs("rgb <", out);
    json_float(out, color.r);
    fputs(", ", out);
    json_float(out, color.g);
    fputs(", ", out);
    json_float(out, color.b);
    fputc('>', out);
}

static double mirror(int axis)
{
    return axis == 2 ? -1 : 1;
}

// POV-Ray multiplies row vectors: the rows are the images of the axes, then of the origin.
static void write_matrix(const Pov *pov, const Affine *map, bool from_scene, const char *indent)
{
    fprintf(pov->e->out, "%smatrix <", indent);
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 3; ++row) {
            double sign = mirror(row) * (from_scene ? mirror(column) : 1);
            pov_number(pov, sign * map->m[row][column]);
            fputs(column == 3 && row == 2 ? ">\n" : row == 2 ? ",  " : ", ", pov->e->out);
        }
    }
}

void pov_matrix(const Pov *pov, const Affine *map, const char *indent)
{
    if (!affine_is_identity(map)) {
        write_matrix(pov, map, true, indent);
    }
}

void pov_texture_matrix(const Pov *pov, const Affine *map, const char *indent)
{
    write_matrix(pov, map, false, indent);
}

void pov_comment(const Pov *pov, const char *kind, uint32_t name, Span at, const char *indent)
{
    char place[512];
    const char *text = name ? pov->e->scene->names.items[name] : "";
    fprintf(pov->e->out, "%s// %s", indent, kind);
    if (*text) {
        fputs(" \"", pov->e->out);
        for (; *text; ++text) { // a line break would end the comment
            fputc((unsigned char)*text < ' ' ? ' ' : *text, pov->e->out);
        }
        fputc('"', pov->e->out);
    }
    export_place(pov->e, at, place, sizeof place);
    fprintf(pov->e->out, "%s%s\n", *place ? ", " : "", place);
}
