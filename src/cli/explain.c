// scnrender explain [NAME]: a kind, a category, a built-in function, an integrator or a
// diagnostic's code.
#include "cli/commands.h"

#include "base/diag.h"
#include "lang/lang.h"
#include "render/integrator.h"
#include "render/render.h"
#include "schema/manual.h"

#include <string.h>

// --- Entries -------------------------------------------------------------------------------------

// A paragraph of its own.
static void print_paragraph(const char *text)
{
    if (text && *text) {
        fputc('\n', stdout);
        manual_write_wrapped(stdout, text, 0, 0, MANUAL_WIDTH);
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
        manual_write_code(stdout, info->example, "scn", MANUAL_TEXT);
    }
}

static void explain_builtin(const BuiltinInfo *builtin)
{
    printf("%s\n", builtin->signature);
    print_paragraph(builtin->doc);
}

static void explain_constant(const ConstantInfo *constant)
{
    if (constant->moment >= 0) {
        printf("%s: a %s\n", constant->name, dim_info(constant->dim)->name);
    } else {
        printf("%s = %.15g\n", constant->name, constant->value);
    }
    print_paragraph(constant->doc);
}

static void explain_integrator(const IntegratorClass *integrator)
{
    printf("render { integrator: \"%s\" }\n", integrator->name);
    print_paragraph(integrator->doc);
    puts("\nExample:");
    manual_write_code(stdout, integrator->example, "scn", MANUAL_TEXT);
}

static void list_all(const Schema *schema)
{
    puts("Kinds, by what they are:\n");
    for (int category = 0; category < CATEGORY_COUNT; ++category) {
        manual_write_category(schema, (Category)category, stdout, MANUAL_TEXT);
    }
    fputs("integrator:", stdout);
    for (size_t i = 0; integrator_classes[i]; ++i) {
        printf(" %s", integrator_classes[i]->name);
    }
    fputs("\n\nFunctions:", stdout);
    int at = 10;
    for (size_t i = 0; i < lang_builtin_count; ++i) {
        int length = (int)strlen(lang_builtins[i].name) + 1;
        if (at + length > MANUAL_WIDTH) {
            at = printf("\n   ") - 1;
        }
        printf(" %s", lang_builtins[i].name);
        at += length;
    }
    fputs("\n\nQuantities:", stdout);
    for (size_t i = 0; i < lang_constant_count; ++i) {
        printf(" %s", lang_constants[i].name);
    }
    puts("\n\n`scnrender explain NAME` explains each of them, and codes like E0301.");
}

// --- Look-up -------------------------------------------------------------------------------------

static bool try_category(const Schema *schema, const char *name)
{
    for (int category = 0; category < CATEGORY_COUNT; ++category) {
        if (strcmp(category_name((Category)category), name) == 0) {
            manual_write_category(schema, (Category)category, stdout, MANUAL_TEXT);
            manual_write_common_fields((Category)category, stdout, MANUAL_TEXT);
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

// `again`: an entry of that name stands above.
static bool try_builtin(const char *name, bool again)
{
    bool found = false;
    for (size_t i = 0; i < lang_builtin_count; ++i) {
        if (strcmp(lang_builtins[i].name, name) == 0) {
            fputs(again ? "\n" : "", stdout);
            explain_builtin(&lang_builtins[i]);
            found = true;
        }
    }
    for (size_t i = 0; i < lang_constant_count; ++i) {
        if (strcmp(lang_constants[i].name, name) == 0) {
            fputs(again || found ? "\n" : "", stdout);
            explain_constant(&lang_constants[i]);
            found = true;
        }
    }
    return found;
}

static bool try_integrator(const char *name)
{
    for (size_t i = 0; integrator_classes[i]; ++i) {
        if (strcmp(integrator_classes[i]->name, name) == 0) {
            explain_integrator(integrator_classes[i]);
            return true;
        }
    }
    return false;
}

// Takes `other` for the nearest name so far if it is nearer.
static void consider(const char *name, const char *other, const char **near, size_t *nearest)
{
    size_t distance = str_distance(str_from(name), str_from(other), *nearest);
    if (distance < *nearest && distance < strlen(name)) {
        *nearest = distance;
        *near = other;
    }
}

static const char *nearest_entry(const Schema *schema, const char *name)
{
    const char *near = schema_suggest_type(schema, str_from(name), CATEGORY_COUNT);
    size_t nearest = near ? str_distance(str_from(name), str_from(near), 3) : 3;
    for (size_t i = 0; i < lang_builtin_count; ++i) {
        consider(name, lang_builtins[i].name, &near, &nearest);
    }
    for (size_t i = 0; i < lang_constant_count; ++i) {
        consider(name, lang_constants[i].name, &near, &nearest);
    }
    for (size_t i = 0; integrator_classes[i]; ++i) {
        consider(name, integrator_classes[i]->name, &near, &nearest);
    }
    return near;
}

// The example of the entry, or NULL.
static const char *example_of(const Schema *schema, const char *name)
{
    int kind = schema_find(schema, str_from(name));
    if (kind >= 0 && schema->types[kind]->example) {
        return schema->types[kind]->example;
    }
    for (size_t i = 0; integrator_classes[i]; ++i) {
        if (strcmp(integrator_classes[i]->name, name) == 0) {
            return integrator_classes[i]->example;
        }
    }
    DiagCode code = diag_find(str_from(name));
    return code == DIAG_CODE_COUNT || !*diag_info(code)->example ? NULL : diag_info(code)->example;
}

static int print_example(const Schema *schema, const char *name)
{
    const char *example = name ? example_of(schema, name) : NULL;
    if (!example) {
        fprintf(stderr, "scnrender: %s%s%s has no example\n", name ? "`" : "",
                name ? name : "no entry", name ? "`" : "");
        return EXIT_USAGE;
    }
    puts(example);
    return EXIT_OK;
}

int command_explain(const Options *options)
{
    const Schema *schema = render_schema();
    const char *name = options->operand;
    if (options->example) {
        return print_example(schema, name);
    }
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
        manual_write_kind(schema->types[kind], stdout, MANUAL_TEXT);
    }
    found |= try_builtin(name, found);
    found |= try_integrator(name);
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
