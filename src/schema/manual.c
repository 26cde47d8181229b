#include "schema/manual.h"

#include <math.h>
#include <string.h>

// --- Text
// ------------------------------------------------------------------------------------------

void manual_write_wrapped(FILE *out, const char *text, int indent, int at, int width)
{
    bool first = true;
    while (*text) {
        size_t length = strcspn(text, " \n");
        if (length > 0) {
            if (!first && at + 1 + (int)length > width) {
                fprintf(out, "\n%*s", indent, "");
                at = indent;
                first = true;
            }
            fprintf(out, "%s%.*s", first ? "" : " ", (int)length, text);
            at += (int)length + (first ? 0 : 1);
            first = false;
        }
        text += length;
        if (*text == '\n') {
            fprintf(out, "\n%*s", indent, "");
            at = indent;
            first = true;
        }
        text += *text != '\0';
    }
    fputc('\n', out);
}

void manual_write_code(FILE *out, const char *text, const char *language, ManualStyle style)
{
    if (!text || !*text) {
        return;
    }
    if (style == MANUAL_MARKDOWN) {
        fprintf(out, "\n```%s\n%s\n```\n", language, text);
        return;
    }
    fputc('\n', out);
    while (*text) {
        size_t length = strcspn(text, "\n");
        fprintf(out, "    %.*s\n", (int)length, text);
        text += length + (text[length] == '\n');
    }
}

void manual_write_picture(FILE *out, const char *name)
{
    fprintf(out, "\n![%s](kinds/%s.png)\n", name, name);
}

void manual_write_cell(FILE *out, const char *text)
{
    for (; *text; ++text) {
        if (*text == '|') {
            fputc('\\', out);
        }
        fputc(*text == '\n' ? ' ' : *text, out);
    }
}

static const char *article(const char *noun)
{
    return strchr("aeiou", *noun) ? "an" : "a";
}

// --- What a field takes
// ----------------------------------------------------------------------------

static bool is_angle_only(const Param *param)
{
    return param->dims == DIM_BIT(DIM_ANGLE);
}

// "power or luminous flux, bare in W": with the unit that a bare number is taken in.
static void write_dimensions(FILE *out, const Param *param)
{
    const char *between = "";
    for (int dim = 0; dim < DIM_COUNT; ++dim) {
        if ((param->dims & DIM_BIT(dim)) && dim != DIM_NONE) {
            fprintf(out, "%s%s", between, dim_info((Dim)dim)->name);
            between = " or ";
        }
    }
    if (param->si) {
        fprintf(out, "%s in %s", *between ? ", bare" : "number", param->si);
        return;
    }
    // The first is the one that a bare number is taken in; a bare angle is an error.
    for (int dim = DIM_NONE + 1; dim < DIM_COUNT; ++dim) {
        if (param->dims & DIM_BIT(dim)) {
            if (dim != DIM_ANGLE) {
                fprintf(out, ", bare in %s", dim_info((Dim)dim)->si_unit);
            }
            return;
        }
    }
}

static bool has_dimension(const Param *param)
{
    return (param->dims & ~DIM_BIT(DIM_NONE)) != 0 || param->si;
}

static void write_choices(FILE *out, const Param *param)
{
    for (size_t i = 0; param->choices[i]; ++i) {
        fprintf(out, "%s\"%s\"", i ? ", " : "", param->choices[i]);
    }
}

// What it takes: "length, bare in m"; "number or texture (angle, with its unit)"; "material".
static void write_type(FILE *out, const Param *param)
{
    bool plain = param->type == PARAM_NUMBER || param->type == PARAM_QUANTITY;
    switch (param->type) {
    case PARAM_CHOICE:
        write_choices(out, param);
        return;
    case PARAM_NODE:
        fputs(category_name(param->category), out);
        return;
    default:
        break;
    }
    if (plain && has_dimension(param)) {
        write_dimensions(out, param);
        return;
    }
    fputs(param->flags & PARAM_UNIT_VECTOR ? "direction" : param_type_name(param->type), out);
    if (has_dimension(param) && !(param->flags & PARAM_UNIT_VECTOR)) {
        fputs(" (", out);
        write_dimensions(out, param);
        fputc(')', out);
    }
}

static bool has_range(const Param *param)
{
    return (param->min != 0 || param->max != 0) && (isfinite(param->min) || isfinite(param->max));
}

// Angles are kept in radians, but nobody thinks in them.
static void write_bound(FILE *out, const Param *param, double bound)
{
    if (is_angle_only(param)) {
        fprintf(out, "%.6gdeg", bound * (180 / PI));
    } else {
        fprintf(out, "%.10g", bound);
    }
}

// "0 to 1", "above 0", "at least 1", "above 0deg and below 180deg".
static void write_range(FILE *out, const Param *param)
{
    bool min = isfinite(param->min), max = isfinite(param->max);
    bool open = (param->flags & (PARAM_EXCLUDE_MIN | PARAM_EXCLUDE_MAX)) != 0;
    if (min && max && !open) {
        write_bound(out, param, param->min);
        fputs(" to ", out);
        write_bound(out, param, param->max);
        return;
    }
    if (min) {
        fputs(param->flags & PARAM_EXCLUDE_MIN ? "above " : "at least ", out);
        write_bound(out, param, param->min);
    }
    if (max) {
        fprintf(out, "%s%s ", min ? " and " : "",
                param->flags & PARAM_EXCLUDE_MAX ? "below" : "at most");
        write_bound(out, param, param->max);
    }
}

// --- Fields
// ----------------------------------------------------------------------------------------

void manual_write_takes(const Param *param, FILE *out)
{
    write_type(out, param);
    if (has_range(param)) {
        fputs("; ", out);
        write_range(out, param);
    }
    if (param->flags & PARAM_REQUIRED) {
        fputs("; required", out);
    } else if (param->default_text) {
        fprintf(out, "; default %s", param->default_text);
    }
}

static void write_field_text(const Param *param, FILE *out)
{
    int at = fprintf(out, "  %-*s", MANUAL_NAME_COLUMN - 2, param->name);
    if (at > MANUAL_NAME_COLUMN) {
        fprintf(out, "\n%*s", MANUAL_NAME_COLUMN, "");
    }
    manual_write_takes(param, out);
    fprintf(out, "\n%*s", MANUAL_NAME_COLUMN, "");
    manual_write_wrapped(out, param->doc, MANUAL_NAME_COLUMN, MANUAL_NAME_COLUMN, MANUAL_WIDTH);
}

static void write_field_row(const Param *param, FILE *out)
{
    fprintf(out, "| `%s` | ", param->name);
    write_type(out, param);
    fputs(" | ", out);
    if (has_range(param)) {
        write_range(out, param);
    }
    fputs(" | ", out);
    if (param->flags & PARAM_REQUIRED) {
        fputs("required", out);
    } else if (param->default_text) {
        fprintf(out, "`%s`", param->default_text);
    }
    fputs(" | ", out);
    manual_write_cell(out, param->doc);
    fputs(" |\n", out);
}

static void write_fields(const NodeType *type, FILE *out, ManualStyle style)
{
    if (type->param_count == 0) {
        return;
    }
    fputs(style == MANUAL_TEXT
              ? "\nFields:\n"
              : "\n| field | takes | range | default | meaning |\n|---|---|---|---|---|\n",
          out);
    for (size_t i = 0; i < type->param_count; ++i) {
        if (style == MANUAL_TEXT) {
            write_field_text(&type->params[i], out);
        } else {
            write_field_row(&type->params[i], out);
        }
    }
}

const char *manual_common_takes(CommonField field)
{
    switch (field) {
    case COMMON_TRANSFORM:
        return "transform, or a list of them";
    case COMMON_MATERIAL:
        return "material";
    case COMMON_NAME:
        return "string";
    case COMMON_COLOR:
        return "color";
    }
    return "";
}

void manual_write_common_fields(Category category, FILE *out, ManualStyle style)
{
    uint32_t fields = category_common_fields(category);
    if (!fields) {
        return;
    }
    fprintf(out, style == MANUAL_TEXT ? "\nFields of every %s:\n" : "\nEvery %s takes:\n\n",
            category_name(category));
    if (style == MANUAL_MARKDOWN) {
        fputs("| field | takes | meaning |\n|---|---|---|\n", out);
    }
    for (uint32_t bit = 1; bit <= fields; bit <<= 1) {
        CommonField field = (CommonField)bit;
        if (!(fields & bit)) {
            continue;
        }
        if (style == MANUAL_TEXT) {
            fprintf(out, "  %-*s", MANUAL_NAME_COLUMN - 2, common_field_name(field));
            manual_write_wrapped(out, common_field_doc(field), MANUAL_NAME_COLUMN,
                                 MANUAL_NAME_COLUMN, MANUAL_WIDTH);
        } else {
            fprintf(out, "| `%s` | %s | %s |\n", common_field_name(field),
                    manual_common_takes(field), common_field_doc(field));
        }
    }
}

// --- Kinds
// -----------------------------------------------------------------------------------------

static void write_kind_text(const NodeType *type, FILE *out)
{
    const char *category = category_name(type->category);
    fprintf(out, "%s: %s %s\n\n", type->name, article(category), category);
    manual_write_wrapped(out, type->doc, 0, 0, MANUAL_WIDTH);
    write_fields(type, out, MANUAL_TEXT);
    manual_write_common_fields(type->category, out, MANUAL_TEXT);
    if (type->formula) {
        fputs("\nFormula:\n\n    ", out);
        manual_write_wrapped(out, type->formula, 4, 4, MANUAL_WIDTH);
    }
    if (type->example) {
        fputs("\nExample:\n", out);
        manual_write_code(out, type->example, "scn", MANUAL_TEXT);
    }
}

static void write_kind_markdown(const NodeType *type, FILE *out)
{
    fprintf(out, "\n### `%s`\n\n%s\n", type->name, type->doc);
    write_fields(type, out, MANUAL_MARKDOWN);
    if (type->role == ROLE_GROUP) {
        fputs("\nBeside fields it takes items: what they emit belongs to it.\n", out);
    }
    manual_write_code(out, type->formula, "text", MANUAL_MARKDOWN);
    if (type->example) {
        manual_write_picture(out, type->name);
    }
    manual_write_code(out, type->example, "scn", MANUAL_MARKDOWN);
}

void manual_write_kind(const NodeType *type, FILE *out, ManualStyle style)
{
    if (style == MANUAL_TEXT) {
        write_kind_text(type, out);
    } else {
        write_kind_markdown(type, out);
    }
}

static void write_kind_names(const Schema *schema, Category category, FILE *out)
{
    int at = fprintf(out, "%s:", category_name(category));
    for (size_t i = 0; i < schema->type_count; ++i) {
        const NodeType *type = schema->types[i];
        if (type->category != category || type->internal) {
            continue;
        }
        int length = (int)strlen(type->name) + 1;
        if (at + length > MANUAL_WIDTH) {
            at = fprintf(out, "\n   ") - 1;
        }
        at += fprintf(out, " %s", type->name);
    }
    fputc('\n', out);
}

void manual_write_category(const Schema *schema, Category category, FILE *out, ManualStyle style)
{
    if (style == MANUAL_TEXT) {
        write_kind_names(schema, category, out);
        return;
    }
    const char *name = category_name(category);
    fprintf(out, "\n## %c%ss\n", name[0] - 'a' + 'A', name + 1);
    manual_write_common_fields(category, out, MANUAL_MARKDOWN);
    for (size_t i = 0; i < schema->type_count; ++i) {
        if (schema->types[i]->category == category && !schema->types[i]->internal) {
            manual_write_kind(schema->types[i], out, MANUAL_MARKDOWN);
        }
    }
}

void manual_write_units(FILE *out, ManualStyle style)
{
    if (style == MANUAL_MARKDOWN) {
        fputs("| unit | dimension | in SI |\n|---|---|---|\n", out);
    }
    for (size_t i = 0; i < schema_unit_count; ++i) {
        const UnitInfo *unit = &schema_units[i];
        const DimInfo *dim = dim_info(unit->dim);
        fprintf(out, style == MANUAL_TEXT ? "  %-6s%-20s%.10g %s\n" : "| `%s` | %s | %.10g %s |\n",
                unit->name, dim->name, unit->factor, dim->si_unit);
    }
}
