// scnrender reference: docs/reference.md, the whole manual of the language as Markdown, from the
// tables that the program runs on.
#include "cli/commands.h"

#include "base/diag.h"
#include "lang/lang.h"
#include "render/integrator.h"
#include "render/render.h"
#include "schema/manual.h"

#include <string.h>

static bool has_kinds(const Schema *schema, int category)
{
    for (size_t i = 0; i < schema->type_count; ++i) {
        if ((int)schema->types[i]->category == category && !schema->types[i]->internal) {
            return true;
        }
    }
    return false;
}

static void print_contents(const Schema *schema)
{
    puts(
        "# Reference of the scene language\n\n"
        "Made by `tools/docs` from the tables that the program runs on; not to be edited. The same "
        "text, entry by entry, is behind `scnrender explain NAME`. The grammar is in "
        "[grammar/scn.ebnf](../grammar/scn.ebnf).\n\nEach example is a scene: `scnrender explain "
        "--example ggx >ggx.scn` writes one down. Files that examples name lie in `examples/`.\n");
    for (int category = 0; category < CATEGORY_COUNT; ++category) {
        const char *name = category_name((Category)category);
        if (!has_kinds(schema, category)) {
            continue;
        }
        printf("- [%c%ss](#%ss)\n", name[0] - 'a' + 'A', name + 1, name);
    }
    puts("- [Integrators](#integrators)\n- [Units](#units)\n- [Functions](#functions)\n"
         "- [Limits](#limits)\n- [Diagnostics](#diagnostics)");
}

static void print_integrators(void)
{
    puts("\n## Integrators\n\nWhat finds the light along a ray, chosen by `render { integrator: "
         "\"path\" }`.");
    for (size_t i = 0; integrator_classes[i]; ++i) {
        const IntegratorClass *integrator = integrator_classes[i];
        printf("\n### `%s`\n\n%s\n", integrator->name, integrator->doc);
        manual_write_picture(stdout, integrator->name);
        manual_write_code(stdout, integrator->example, "scn", MANUAL_MARKDOWN);
    }
}

static void print_units(void)
{
    puts("\n## Units\n\nA unit stands directly behind its number: `40deg`, `2.5m`, `800lm`. A bare "
         "number is taken in the unit that the field's table names; angles always need a unit.\n");
    manual_write_units(stdout, MANUAL_MARKDOWN);
}

static void print_functions(void)
{
    puts("\n## Functions\n\n| function | |\n|---|---|");
    for (size_t i = 0; i < lang_builtin_count; ++i) {
        fputs("| `", stdout);
        manual_write_cell(stdout, lang_builtins[i].signature);
        fputs("` | ", stdout);
        manual_write_cell(stdout, lang_builtins[i].doc);
        puts(" |");
    }
    puts("\nNames of quantities:\n\n| name | |\n|---|---|");
    for (size_t i = 0; i < lang_constant_count; ++i) {
        printf("| `%s` | ", lang_constants[i].name);
        manual_write_cell(stdout, lang_constants[i].doc);
        puts(" |");
    }
}

static void print_limits(void)
{
    puts("\n## Limits\n\nEach is raised with `--limit NAME=N`; crossing one is reported at the "
         "place that crosses it.\n\n| name | default | of |\n|---|---|---|");
#define LIMIT(id, value, text)                                                                     \
    printf("| `%s` | %llu | %s |\n", #id, (unsigned long long)(value), text);
    LIMITS(LIMIT)
#undef LIMIT
}

static void print_diagnostics(void)
{
    puts("\n## Diagnostics\n\nE is an error, after which there is no picture; W is a warning; N is "
         "a note.");
    for (int code = 0; code < DIAG_CODE_COUNT; ++code) {
        const DiagInfo *info = diag_info((DiagCode)code);
        printf("\n### %s: %s\n\n%s\n", info->name, info->title, info->paragraph);
        manual_write_code(stdout, info->example, "scn", MANUAL_MARKDOWN);
    }
}

int command_reference(const Options *options)
{
    (void)options;
    const Schema *schema = render_schema();
    print_contents(schema);
    for (int category = 0; category < CATEGORY_COUNT; ++category) {
        if (has_kinds(schema, category)) {
            manual_write_category(schema, (Category)category, stdout, MANUAL_MARKDOWN);
        }
    }
    print_integrators();
    print_units();
    print_functions();
    print_limits();
    print_diagnostics();
    return EXIT_OK;
}
