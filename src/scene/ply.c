#include "scene/ply.h"

#include "base/number.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const PlyTypeInfo types[PLY_TYPE_COUNT] = {
    [PLY_NONE] = {"", "", 0, false, 0, 0},
    [PLY_INT8] = {"char", "int8", 1, true, INT8_MIN, INT8_MAX},
    [PLY_UINT8] = {"uchar", "uint8", 1, true, 0, UINT8_MAX},
    [PLY_INT16] = {"short", "int16", 2, true, INT16_MIN, INT16_MAX},
    [PLY_UINT16] = {"ushort", "uint16", 2, true, 0, UINT16_MAX},
    [PLY_INT32] = {"int", "int32", 4, true, INT32_MIN, INT32_MAX},
    [PLY_UINT32] = {"uint", "uint32", 4, true, 0, UINT32_MAX},
    [PLY_FLOAT32] = {"float", "float32", 4, false, 0, 0},
    [PLY_FLOAT64] = {"double", "float64", 8, false, 0, 0},
};

const PlyTypeInfo *ply_type_info(PlyType type)
{
    return &types[type];
}

bool ply_fail(Ply *ply, const char *format, ...)
{
    int used = ply->in_body && !ply->ascii
                   ? snprintf(ply->message, ply->message_size,
                              "byte %zu: ", (size_t)(ply->at - ply->bytes))
                   : snprintf(ply->message, ply->message_size, "line %" PRIu64 ": ", ply->line);
    if (used >= 0 && (size_t)used < ply->message_size) {
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(ply->message + used, ply->message_size - (size_t)used, format, arguments);
        va_end(arguments);
    }
    return false;
}

// --- Lines and words -----------------------------------------------------------------------------

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

// Lines end with \n, \r\n or \r alone.
void ply_leave_line(Ply *ply)
{
    const char *end = ply->line_end;
    if (end) {
        bool windows = end + 1 < ply->end && *end == '\r' && end[1] == '\n';
        ply->at = end + (windows ? 2 : end < ply->end);
        ply->line_end = NULL;
    }
}

static bool next_raw_line(Ply *ply)
{
    ply_leave_line(ply);
    if (ply->at >= ply->end) {
        return false;
    }
    ++ply->line;
    if (!ply->newline || ply->newline < ply->at) {
        const char *newline = memchr(ply->at, '\n', (size_t)(ply->end - ply->at));
        ply->newline = newline ? newline : ply->end;
    }
    const char *carriage = memchr(ply->at, '\r', (size_t)(ply->newline - ply->at));
    ply->line_end = carriage ? carriage : ply->newline;
    return true;
}

bool ply_next_line(Ply *ply)
{
    while (next_raw_line(ply)) {
        while (ply->at < ply->line_end && is_blank(*ply->at)) {
            ++ply->at;
        }
        if (ply->at < ply->line_end) {
            return true;
        }
    }
    return false;
}

// The next word of the line; empty at its end.
static Str next_word(Ply *ply)
{
    while (ply->at < ply->line_end && is_blank(*ply->at)) {
        ++ply->at;
    }
    const char *begin = ply->at;
    while (ply->at < ply->line_end && !is_blank(*ply->at)) {
        ++ply->at;
    }
    return (Str){begin, (size_t)(ply->at - begin)};
}

// For messages: words of a damaged file may be long.
static int shown(Str word)
{
    return (int)(word.length < 40 ? word.length : 40);
}

// --- Header --------------------------------------------------------------------------------------

static PlyType find_type(Str name)
{
    for (int i = PLY_NONE + 1; i < PLY_TYPE_COUNT; ++i) {
        if (str_equal(name, str_from(types[i].name)) ||
            str_equal(name, str_from(types[i].other_name))) {
            return (PlyType)i;
        }
    }
    return PLY_NONE;
}

static PlyRole find_role(const PlyElement *element, Str name, bool list)
{
    static const struct {
        const char *name;
        PlyRole role;
    } roles[] = {
        {"x", ROLE_X},
        {"y", ROLE_Y},
        {"z", ROLE_Z},
        {"nx", ROLE_NX},
        {"ny", ROLE_NY},
        {"nz", ROLE_NZ},
        {"u", ROLE_U},
        {"v", ROLE_V},
        {"s", ROLE_U},
        {"t", ROLE_V},
        {"texture_u", ROLE_U},
        {"texture_v", ROLE_V},
        {"texture_s", ROLE_U},
        {"texture_t", ROLE_V},
        {"red", ROLE_RED},
        {"green", ROLE_GREEN},
        {"blue", ROLE_BLUE},
        {"r", ROLE_RED},
        {"g", ROLE_GREEN},
        {"b", ROLE_BLUE},
        {"diffuse_red", ROLE_RED},
        {"diffuse_blue", ROLE_BLUE},
        {"diffuse_green", ROLE_GREEN},
    };
    if (list) {
        bool indices =
            str_equal(name, STR("vertex_indices")) || str_equal(name, STR("vertex_index"));
        return indices && (element->kind == PLY_FACE || element->kind == PLY_STRIPS) ? ROLE_INDICES
                                                                                     : ROLE_OTHER;
    }
    for (size_t i = 0; element->kind == PLY_VERTEX && i < sizeof roles / sizeof roles[0]; ++i) {
        if (str_equal(name, str_from(roles[i].name))) {
            return roles[i].role;
        }
    }
    return ROLE_OTHER;
}

static bool has_role(const Ply *ply, const PlyElement *element, PlyRole role)
{
    for (uint32_t i = 0; i < element->property_count; ++i) {
        if (ply->properties[element->first + i].role == role) {
            return true;
        }
    }
    return false;
}

static bool read_type(Ply *ply, PlyType *type)
{
    Str name = next_word(ply);
    *type = find_type(name);
    return *type != PLY_NONE ||
           ply_fail(ply,
                    "`%.*s` is not a type of PLY (char, uchar, short, ushort, int, uint, "
                    "float, double)",
                    shown(name), name.at);
}

// property TYPE NAME | property list COUNT_TYPE TYPE NAME
static bool read_property(Ply *ply)
{
    if (ply->element_count == 0) {
        return ply_fail(ply, "a property before the first element");
    }
    if (ply->property_count == PLY_MOST_PROPERTIES) {
        return ply_fail(ply, "more than %d properties", PLY_MOST_PROPERTIES);
    }
    PlyElement *element = &ply->elements[ply->element_count - 1];
    PlyProperty *property = &ply->properties[ply->property_count];
    *property = (PlyProperty){0};
    const char *before = ply->at;
    bool list = str_equal(next_word(ply), STR("list"));
    if (!list) {
        ply->at = before;
    } else if (!read_type(ply, &property->count_type)) {
        return false;
    } else if (!types[property->count_type].whole) {
        return ply_fail(ply, "the length of a list can't be a %s",
                        types[property->count_type].name);
    }
    if (!read_type(ply, &property->type)) {
        return false;
    }
    property->name = next_word(ply);
    if (property->name.length == 0) {
        return ply_fail(ply, "a property without a name");
    }
    property->role = find_role(element, property->name, list);
    if (property->role != ROLE_OTHER && has_role(ply, element, property->role)) {
        property->role = ROLE_OTHER; // the first of `u` and `s`
    }
    if (property->role == ROLE_INDICES && !types[property->type].whole) {
        return ply_fail(ply, "indices of vertices can't be of type %s", types[property->type].name);
    }
    ++ply->property_count;
    ++element->property_count;
    return true;
}

// element NAME COUNT
static bool read_element(Ply *ply)
{
    if (ply->element_count == PLY_MOST_ELEMENTS) {
        return ply_fail(ply, "more than %d elements", PLY_MOST_ELEMENTS);
    }
    Str name = next_word(ply), count = next_word(ply);
    uint64_t number = 0;
    bool good = count.length > 0;
    for (size_t i = 0; good && i < count.length; ++i) {
        good = count.at[i] >= '0' && count.at[i] <= '9' && number < UINT64_MAX / 10 - 1;
        number = number * 10 + (uint64_t)(count.at[i] - '0');
    }
    if (!good) {
        return ply_fail(ply, "`%.*s` is not a count of elements", shown(count), count.at);
    }
    PlyElementKind kind = str_equal(name, STR("vertex"))      ? PLY_VERTEX
                          : str_equal(name, STR("face"))      ? PLY_FACE
                          : str_equal(name, STR("tristrips")) ? PLY_STRIPS
                                                              : PLY_OTHER;
    for (uint32_t i = 0; i < ply->element_count; ++i) {
        if (str_equal(ply->elements[i].name, name)) {
            return ply_fail(ply, "a second element `%.*s`", shown(name), name.at);
        }
    }
    ply->elements[ply->element_count++] =
        (PlyElement){.name = name, .kind = kind, .count = number, .first = ply->property_count};
    return true;
}

// format ascii|binary_little_endian|binary_big_endian 1.0
static bool read_format(Ply *ply)
{
    Str format = next_word(ply), version = next_word(ply);
    ply->ascii = str_equal(format, STR("ascii"));
    ply->big_endian = str_equal(format, STR("binary_big_endian"));
    if (!ply->ascii && !ply->big_endian && !str_equal(format, STR("binary_little_endian"))) {
        return ply_fail(ply, "`%.*s` is not a format of PLY", shown(format), format.at);
    }
    return str_equal(version, STR("1.0")) ||
           ply_fail(ply, "version `%.*s` of PLY is not known", shown(version), version.at);
}

static bool check_element(Ply *ply, PlyElement *element)
{
    size_t stride = 0;
    bool fixed = true;
    for (uint32_t i = 0; i < element->property_count; ++i) {
        const PlyProperty *property = &ply->properties[element->first + i];
        fixed = fixed && property->count_type == PLY_NONE;
        stride += types[property->type].size;
    }
    element->stride = fixed ? stride : 0;
    if (element->kind == PLY_VERTEX) {
        static const char *const names[] = {"x", "y", "z"};
        for (int i = 0; i < 3; ++i) {
            if (!has_role(ply, element, (PlyRole)(ROLE_X + i))) {
                return ply_fail(ply, "the vertices have no property `%s`", names[i]);
            }
        }
    }
    if ((element->kind == PLY_FACE || element->kind == PLY_STRIPS) && element->count &&
        !has_role(ply, element, ROLE_INDICES)) {
        return ply_fail(ply, "element `%.*s` has no list `vertex_indices`", shown(element->name),
                        element->name.at);
    }
    return true;
}

static bool finish_header(Ply *ply, bool has_format)
{
    bool has_vertices = false;
    if (!has_format) {
        return ply_fail(ply, "the header names no format");
    }
    for (uint32_t i = 0; i < ply->element_count; ++i) {
        has_vertices = has_vertices || ply->elements[i].kind == PLY_VERTEX;
        if (!check_element(ply, &ply->elements[i])) {
            return false;
        }
    }
    if (!has_vertices) {
        return ply_fail(ply, "the header announces no vertices");
    }
    ply_leave_line(ply);
    ply->in_body = true;
    return true;
}

bool ply_read_header(Ply *ply)
{
    bool has_format = false;
    if (!next_raw_line(ply) || !str_equal(next_word(ply), STR("ply"))) {
        ply->line = 1;
        return ply_fail(ply, "a PLY file begins with the word `ply`");
    }
    while (next_raw_line(ply)) {
        Str word = next_word(ply);
        bool good = true;
        if (str_equal(word, STR("end_header"))) {
            return finish_header(ply, has_format);
        }
        if (str_equal(word, STR("format"))) {
            good = read_format(ply);
            has_format = true;
        } else if (str_equal(word, STR("element"))) {
            good = read_element(ply);
        } else if (str_equal(word, STR("property"))) {
            good = read_property(ply);
        } else if (word.length && !str_equal(word, STR("comment")) &&
                   !str_equal(word, STR("obj_info"))) {
            good = ply_fail(ply, "`%.*s` is not a word of PLY's header", shown(word), word.at);
        }
        if (!good) {
            return false;
        }
    }
    return ply_fail(ply, "the file ends within its header");
}

// --- Data ----------------------------------------------------------------------------------------

static bool fails_early(Ply *ply, const PlyProperty *property)
{
    return ply_fail(ply, "the %s ends before `%.*s`", ply->ascii ? "line" : "file",
                    shown(property->name), property->name.at);
}

static uint64_t load_bits(const Ply *ply, size_t size)
{
    uint8_t raw[8] = {0};
    memcpy(raw, ply->at, size);
    uint64_t bits = 0;
    for (size_t i = 0; i < size; ++i) {
        bits |= (uint64_t)raw[ply->big_endian ? size - 1 - i : i] << (8 * i);
    }
    return bits;
}

static double load_binary(const Ply *ply, PlyType type)
{
    switch (type) {
    case PLY_INT8:
        return (int8_t)load_bits(ply, 1);
    case PLY_UINT8:
        return (uint8_t)*ply->at;
    case PLY_INT16:
        return (int16_t)load_bits(ply, 2);
    case PLY_UINT16:
        return (double)load_bits(ply, 2);
    case PLY_INT32:
        return (int32_t)load_bits(ply, 4);
    case PLY_UINT32:
        return (double)load_bits(ply, 4);
    case PLY_FLOAT32: {
        uint32_t bits = (uint32_t)load_bits(ply, 4);
        float value;
        memcpy(&value, &bits, sizeof value);
        return (double)value;
    }
    default: {
        uint64_t bits = load_bits(ply, 8);
        double value;
        memcpy(&value, &bits, sizeof value);
        return value;
    }
    }
}

// What C libraries print for numbers that are not finite: nan, -nan(0x…), inf, infinity, 1.#QNAN.
static bool parse_special(Str word, double *value)
{
    size_t sign = word.length && (*word.at == '-' || *word.at == '+');
    Str rest = {word.at + sign, word.length - sign};
    if (rest.length < 3) {
        return false;
    }
    char lower[3];
    for (int i = 0; i < 3; ++i) {
        lower[i] = (char)(rest.at[i] | 0x20);
    }
    bool infinite = memcmp(lower, "inf", 3) == 0;
    bool microsoft = rest.length > 3 && memcmp(rest.at, "1.#", 3) == 0;
    if (!infinite && !microsoft && memcmp(lower, "nan", 3) != 0) {
        return false;
    }
    infinite = infinite || (microsoft && (rest.at[3] | 0x20) == 'i' && rest.length > 5 &&
                            (rest.at[5] | 0x20) == 'f');
    *value = infinite ? (double)INFINITY : (double)NAN;
    return true;
}

static bool read_word(Ply *ply, PlyType type, const PlyProperty *property, double *value)
{
    while (ply->at < ply->line_end && is_blank(*ply->at)) {
        ++ply->at;
    }
    if (ply->at == ply->line_end) {
        return fails_early(ply, property);
    }
    const PlyTypeInfo *info = &types[type];
    const char *end = number_parse(ply->at, ply->line_end, value);
    if (!end || (end < ply->line_end && !is_blank(*end))) {
        Str word = next_word(ply);
        if (info->whole || !parse_special(word, value)) {
            return ply_fail(ply, "`%.*s` is not a number", shown(word), word.at);
        }
        return true;
    }
    ply->at = end;
    if (info->whole && !(*value >= info->min && *value <= info->max && *value == floor(*value))) {
        return ply_fail(ply, "%g is not a value of type %s, which `%.*s` has", *value, info->name,
                        shown(property->name), property->name.at);
    }
    return true;
}

bool ply_number(Ply *ply, PlyType type, const PlyProperty *property, double *value)
{
    if (ply->ascii) {
        return read_word(ply, type, property, value);
    }
    if ((size_t)(ply->end - ply->at) < types[type].size) {
        return fails_early(ply, property);
    }
    *value = load_binary(ply, type);
    ply->at += types[type].size;
    return true;
}

bool ply_list_count(Ply *ply, const PlyProperty *property, uint32_t *count)
{
    const char *before = ply->at;
    double value;
    if (!ply_number(ply, property->count_type, property, &value)) {
        return false;
    }
    // In ASCII each item takes a blank and a digit at least.
    size_t left = ply->ascii ? (size_t)(ply->line_end - ply->at) / 2
                             : (size_t)(ply->end - ply->at) / types[property->type].size;
    if (value < 0 || value > (double)left || value > (double)UINT32_MAX) {
        ply->at = before;
        return ply_fail(ply, "the list `%.*s` is to have %.0f items, but the %s ends before",
                        shown(property->name), property->name.at, value,
                        ply->ascii ? "line" : "file");
    }
    *count = (uint32_t)value;
    return true;
}

bool ply_skip(Ply *ply, const PlyProperty *property, uint64_t count)
{
    if (!ply->ascii) {
        size_t size = types[property->type].size;
        if (count > (size_t)(ply->end - ply->at) / size) {
            return fails_early(ply, property);
        }
        ply->at += count * size;
        return true;
    }
    for (uint64_t i = 0; i < count; ++i) {
        if (next_word(ply).length == 0) {
            return fails_early(ply, property);
        }
    }
    return true;
}

bool ply_end_of_line(Ply *ply, const PlyElement *element)
{
    if (!ply->ascii) {
        return true;
    }
    Str word = next_word(ply);
    return word.length == 0 ||
           ply_fail(ply, "`%.*s` is more than element `%.*s` has properties", shown(word), word.at,
                    shown(element->name), element->name.at);
}
