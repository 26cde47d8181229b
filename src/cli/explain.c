// scnrender explain [NAME]: a kind, a category, a built-in function or a diagnostic's code.
#include "cli/explain.h"

#include "base/diag.h"
#include "cli/commands.h"
#include "lang/lang.h"
#include "render/render.h"

#include <ctype.h>
#include <math.h>
#include <string.h>
#include <strings.h>

enum { WIDTH = 80, NAME_COLUMN = 18 };

// --- Text ----------------------------------------------------------------------------------------

void print_wrapped(FILE *out, const char *text, int indent, int at, int width)
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

// A paragraph of its own.
static void print_paragraph(const char *text)
{
    if (text && *text) {
        fputc('\n', stdout);
        print_wrapped(stdout, text, 0, 0, WIDTH);
    }
}

// Lines as they are, set in.
static void print_code(const char *text)
{
    if (!text || !*text) {
        return;
    }
    fputc('\n', stdout);
    while (*text) {
        size_t length = strcspn(text, "\n");
        printf("    %.*s\n", (int)length, text);
        text += length + (text[length] == '\n');
    }
}

// --- Fields --------------------------------------------------------------------------------------

static void print_range(FILE *out, const Param *param)
{
    if (param->min == 0 && param->max == 0) {
        return;
    }
    const char *above = param->flags & PARAM_EXCLUDE_MIN ? ">" : ">=";
    const char *below = param->flags & PARAM_EXCLUDE_MAX ? "<" : "<=";
    bool min = isfinite(param->min), max = isfinite(param->max);
    if (min) {
        fprintf(out, " %s %.10g", above, param->min);
    }
    if (max) {
        fprintf(out, "%s %s %.10g", min ? " and" : "", below, param->max);
    }
}

static void print_dimensions(FILE *out, const Param *param)
{
    const char *between = "";
    for (int dim = 0; dim < DIM_COUNT; ++dim) {
        if (param->dims & DIM_BIT(dim)) {
            fprintf(out, "%s%s", between, dim_info((Dim)dim)->name);
            between = " or ";
        }
    }
}

void print_field_type(FILE *out, const Param *param)
{
    if (param->type == PARAM_CHOICE) {
        for (size_t i = 0; param->choices[i]; ++i) {
            fprintf(out, "%s\"%s\"", i ? ", " : "", param->choices[i]);
        }
        return;
    }
    if (param->type == PARAM_NODE) {
        fputs(category_name(param->category), out);
        return;
    }
    bool number = param->type == PARAM_NUMBER || param->type == PARAM_QUANTITY;
    if (number && param->dims) {
        print_dimensions(out, param);
    } else {
        fputs(param_type_name(param->type), out);
        if (param->dims & ~DIM_BIT(DIM_NONE)) {
            fputs(" (", out);
            print_dimensions(out, param);
            fputc(')', out);
        }
    }
    print_range(out, param);
    if (param->si) {
        fprintf(out, " (bare numbers: %s)", param->si);
    }
}

static void print_field(const Param *param)
{
    int at = printf("  %-*s", NAME_COLUMN - 2, param->name);
    if (at > NAME_COLUMN) {
        printf("\n%*s", NAME_COLUMN, "");
    }
    print_field_type(stdout, param);
    if (param->flags & PARAM_REQUIRED) {
        fputs("; required", stdout);
    } else if (param->default_text) {
        printf("; default %s", param->default_text);
    }
    printf("\n%*s", NAME_COLUMN, "");
    print_wrapped(stdout, param->doc, NAME_COLUMN, NAME_COLUMN, WIDTH);
}

static void print_common_fields(Category category)
{
    uint32_t fields = category_common_fields(category);
    for (uint32_t field = 1; field && field <= fields; field <<= 1) {
        if (fields & field) {
            printf("  %-*s", NAME_COLUMN - 2, common_field_name((CommonField)field));
            print_wrapped(stdout, common_field_doc((CommonField)field), NAME_COLUMN, NAME_COLUMN,
                          WIDTH);
        }
    }
}

// --- Entries -------------------------------------------------------------------------------------

static void explain_kind(const NodeType *type)
{
    printf("%s: a %s\n", type->name, category_name(type->category));
    print_paragraph(type->doc);
    if (type->param_count > 0) {
        puts("\nFields:");
    }
    for (size_t i = 0; i < type->param_count; ++i) {
        print_field(&type->params[i]);
    }
    if (category_common_fields(type->category)) {
        printf("\nFields of every %s:\n", category_name(type->category));
        print_common_fields(type->category);
    }
    if (type->formula) {
        fputs("\nFormula:\n\n    ", stdout);
        print_wrapped(stdout, type->formula, 4, 4, WIDTH);
    }
    if (type->example) {
        puts("\nExample:");
        print_code(type->example);
    }
}

static void explain_code(const DiagInfo *info)
{
    const char *severity = info->severity == SEVERITY_ERROR     ? "error"
                           : info->severity == SEVERITY_WARNING ? "warning"
                                                                : "note";
    printf("%s[%s]: %s\n", severity, info->name, info->title);
    print_paragraph(info->paragraph);
    if (info->example && *info->example) {
        puts("\nExample:");
        print_code(info->example);
    }
}

static void explain_builtin(const BuiltinInfo *builtin)
{
    printf("%s\n", builtin->signature);
    print_paragraph(builtin->doc);
}

static void list_kinds(const Schema *schema, Category category)
{
    printf("%s:", category_name(category));
    int at = (int)strlen(category_name(category)) + 1;
    for (size_t i = 0; i < schema->type_count; ++i) {
        const NodeType *type = schema->types[i];
        if (type->category != category || type->internal) {
            continue;
        }
        int length = (int)strlen(type->name) + 1;
        if (at + length > WIDTH) {
            at = printf("\n   ") - 1;
        }
        printf(" %s", type->name);
        at += length;
    }
    fputc('\n', stdout);
}

static void list_all(const Schema *schema)
{
    puts("Kinds, by what they are:\n");
    for (int category = 0; category < CATEGORY_COUNT; ++category) {
        list_kinds(schema, (Category)category);
    }
    fputs("\nFunctions:", stdout);
    int at = 10;
    for (size_t i = 0; i < lang_builtin_count; ++i) {
        int length = (int)strlen(lang_builtins[i].name) + 1;
        if (at + length > WIDTH) {
            at = printf("\n   ") - 1;
        }
        printf(" %s", lang_builtins[i].name);
        at += length;
    }
    puts("\n\n`scnrender explain NAME` explains each of them, and codes like E0301.");
}

// --- Look-up -------------------------------------------------------------------------------------

static bool try_category(const Schema *schema, const char *name)
{
    for (int category = 0; category < CATEGORY_COUNT; ++category) {
        if (strcmp(category_name((Category)category), name) == 0) {
            list_kinds(schema, (Category)category);
            if (category_common_fields((Category)category)) {
                printf("\nFields of every %s:\n", name);
                print_common_fields((Category)category);
            }
            return true;
        }
    }
    return false;
}

static bool try_unit(const char *name)
{
    const UnitInfo *unit = unit_find(str_from(name));
    if (unit) {
        printf("%s: a unit of %s; 1%s = %.10g %s\n", unit->name, dim_info(unit->dim)->name,
               unit->name, unit->factor, dim_info(unit->dim)->si_unit);
    }
    return unit != NULL;
}

static bool try_builtin(const char *name)
{
    bool found = false;
    for (size_t i = 0; i < lang_builtin_count; ++i) {
        if (strcmp(lang_builtins[i].name, name) == 0) {
            explain_builtin(&lang_builtins[i]);
            found = true;
        }
    }
    return found;
}

static const char *nearest_entry(const Schema *schema, const char *name)
{
    const char *near = schema_suggest_type(schema, str_from(name), CATEGORY_COUNT);
    size_t nearest = near ? str_distance(str_from(name), str_from(near), 3) : 3;
    for (size_t i = 0; i < lang_builtin_count; ++i) {
        const char *other = lang_builtins[i].name;
        size_t distance = str_distance(str_from(name), str_from(other), nearest);
        if (distance < nearest && distance < strlen(name)) {
            nearest = distance;
            near = other;
        }
    }
    return near;
}

int command_explain(const Options *options)
{
    const Schema *schema = render_schema();
    const char *name = options->operand;
    if (!name) {
        list_all(schema);
        return EXIT_OK;
    }
    DiagCode code = diag_find(str_from(name));
    if (code != DIAG_CODE_COUNT) {
        explain_code(diag_info(code));
        return EXIT_OK;
    }
    int kind = schema_find(schema, str_from(name));
    bool found = kind >= 0 && !schema->types[kind]->internal;
    if (found) {
        explain_kind(schema->types[kind]);
    }
    found |= try_builtin(name);
    if (found || try_category(schema, name) || try_unit(name)) {
        return EXIT_OK;
    }
    const char *near = nearest_entry(schema, name);
    fprintf(stderr, "scnrender: nothing is called `%s`", name);
    if (near) {
        fprintf(stderr, "; did you mean `%s`?", near);
    }
    fputs("\n`scnrender explain` lists all names\n", stderr);
    return EXIT_USAGE;
}
