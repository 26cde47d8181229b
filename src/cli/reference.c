// scnrender reference: docs/reference.md, the whole manual of the language as Markdown, from the
// tables that the program runs on.
#include "cli/commands.h"
#include "cli/explain.h"

#include "base/diag.h"
#include "lang/lang.h"
#include "render/render.h"

#include <string.h>

static void print_kind(const NodeType *type)
{
    printf("\n### `%s`\n\n%s\n", type->name, type->doc);
    if (type->param_count > 0) {
        puts("\n| field | takes | default | |\n|---|---|---|---|");
    }
    for (size_t i = 0; i < type->param_count; ++i) {
        const Param *param = &type->params[i];
        printf("| `%s` | ", param->name);
        print_field_type(stdout, param);
        bool required = param->flags & PARAM_REQUIRED;
        bool code = !required && param->default_text;
        printf(" | %s%s%s | %s |\n", code ? "`" : "",
               required              ? "required"
               : param->default_text ? param->default_text
                                     : "",
               code ? "`" : "", param->doc);
    }
    if (type->formula) {
        printf("\n```text\n%s\n```\n", type->formula);
    }
    if (type->example) {
        printf("\n```scn\n%s\n```\n", type->example);
    }
}

static void print_category(const Schema *schema, Category category)
{
    printf("\n## Kinds: %s\n", category_name(category));
    uint32_t fields = category_common_fields(category);
    if (fields) {
        printf("\nEvery %s also takes:\n\n", category_name(category));
    }
    for (uint32_t field = 1; field && field <= fields; field <<= 1) {
        if (fields & field) {
            printf("- `%s`: %s\n", common_field_name((CommonField)field),
                   common_field_doc((CommonField)field));
        }
    }
    for (size_t i = 0; i < schema->type_count; ++i) {
        if (schema->types[i]->category == category && !schema->types[i]->internal) {
            print_kind(schema->types[i]);
        }
    }
}

static void print_units(void)
{
    puts("\n## Units\n\n| unit | dimension | in SI |\n|---|---|---|");
    for (size_t i = 0; i < schema_unit_count; ++i) {
        const UnitInfo *unit = &schema_units[i];
        printf("| `%s` | %s | %.10g %s |\n", unit->name, dim_info(unit->dim)->name, unit->factor,
               dim_info(unit->dim)->si_unit);
    }
}

static void print_functions(void)
{
    puts("\n## Functions\n");
    for (size_t i = 0; i < lang_builtin_count; ++i) {
        printf("- `%s`: %s\n", lang_builtins[i].signature, lang_builtins[i].doc);
    }
}

static void print_limits(void)
{
    puts("\n## Limits\n\nEach is raised with `--limit NAME=N`.\n\n| name | default | "
         "|\n|---|---|---|");
#define LIMIT(id, value, text)                                                                     \
    printf("| `%s` | %llu | %s |\n", #id, (unsigned long long)(value), text);
    LIMITS(LIMIT)
#undef LIMIT
}

static void print_diagnostics(void)
{
    puts("\n## Diagnostics");
    for (int code = 0; code < DIAG_CODE_COUNT; ++code) {
        const DiagInfo *info = diag_info((DiagCode)code);
        printf("\n### %s: %s\n\n%s\n", info->name, info->title, info->paragraph);
        if (info->example && *info->example) {
            printf("\n```scn\n%s\n```\n", info->example);
        }
    }
}

int command_reference(const Options *options)
{
    (void)options;
    const Schema *schema = render_schema();
    puts("# Reference of the scene language\n\n"
         "Made by `scnrender reference` from the tables that the program runs on; not to be "
         "edited.");
    for (int category = 0; category < CATEGORY_COUNT; ++category) {
        print_category(schema, (Category)category);
    }
    print_units();
    print_functions();
    print_limits();
    print_diagnostics();
    return EXIT_OK;
}
