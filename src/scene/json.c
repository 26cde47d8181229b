#include "scene/json.h"

#include "base/utf8.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static bool write_special(FILE *out, double value)
{
    if (isfinite(value)) {
        return false;
    }
    fputs(isnan(value) ? "\"nan\"" : value > 0 ? "\"inf\"" : "\"-inf\"", out);
    return true;
}

void json_number(FILE *out, double value)
{
    char text[32];
    if (write_special(out, value)) {
        return;
    }
    for (int digits = 15; digits <= 17; ++digits) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value) {
            break;
        }
    }
    fputs(text, out);
}

void json_float(FILE *out, float value)
{
    char text[32];
    if (write_special(out, (double)value)) {
        return;
    }
    for (int digits = 6; digits <= 9; ++digits) {
        snprintf(text, sizeof text, "%.*g", digits, (double)value);
        if (strtof(text, NULL) == value) {
            break;
        }
    }
    fputs(text, out);
}

static void write_ascii(FILE *out, unsigned char c)
{
    switch (c) {
    case '"':
        fputs("\\\"", out);
        break;
    case '\\':
        fputs("\\\\", out);
        break;
    case '\n':
        fputs("\\n", out);
        break;
    case '\t':
        fputs("\\t", out);
        break;
    default:
        if (c < 0x20 || c == 0x7f) {
            fprintf(out, "\\u%04x", c);
        } else {
            fputc(c, out);
        }
    }
}

void json_string(FILE *out, const char *text)
{
    if (!text) {
        fputs("null", out);
        return;
    }
    const char *end = text + strlen(text);
    fputc('"', out);
    for (int length; text < end; text += length) {
        uint32_t code;
        length = utf8_decode(text, end, &code);
        if (code == UTF8_INVALID) {
            fputs("\\ufffd", out);
        } else if (length == 1) {
            write_ascii(out, (unsigned char)code);
        } else {
            fwrite(text, 1, (size_t)length, out);
        }
    }
    fputc('"', out);
}

void json_key(FILE *out, const char *key)
{
    json_string(out, key);
    fputs(": ", out);
}

void json_vec3(FILE *out, Vec3 v)
{
    fputc('[', out);
    json_number(out, v.x);
    fputs(", ", out);
    json_number(out, v.y);
    fputs(", ", out);
    json_number(out, v.z);
    fputc(']', out);
}

void json_rgb(FILE *out, Rgb color)
{
    fputc('[', out);
    json_float(out, color.r);
    fputs(", ", out);
    json_float(out, color.g);
    fputs(", ", out);
    json_float(out, color.b);
    fputc(']', out);
}

void json_affine(FILE *out, const Affine *map)
{
    for (int i = 0; i < 3; ++i) {
        fputs(i ? ", [" : "[[", out);
        for (int j = 0; j < 4; ++j) {
            fputs(j ? ", " : "", out);
            json_number(out, map->m[i][j]);
        }
        fputc(']', out);
    }
    fputc(']', out);
}
