// What stands under the pointer: the manual's text, declarations with their comments, values.
#include "lsp/hover.h"

#include "lang/lexer.h"
#include "lsp/features.h"

#include <ctype.h>

enum { SHOWN_LINES = 8, SHOWN_BYTES = 500 };

ManualStyle hover_style(const Server *server)
{
    return server->client.markdown ? MANUAL_MARKDOWN : MANUAL_TEXT;
}

static void code(FILE *out, ManualStyle style, Str text)
{
    bool markdown = style == MANUAL_MARKDOWN;
    fprintf(out, "%s%.*s%s", markdown ? "```scn\n" : "", (int)text.length, text.at,
            markdown ? "\n```\n" : "\n");
}

// --- Declarations --------------------------------------------------------------------------------

static Str trim(Str text)
{
    while (text.length > 0 && isspace((unsigned char)text.at[text.length - 1])) {
        --text.length;
    }
    return text;
}

// The beginning of a long text, in whole lines.
static Str shorten(Str text)
{
    size_t lines = 0, at = 0;
    while (at < text.length && at < SHOWN_BYTES && lines < SHOWN_LINES) {
        lines += text.at[at++] == '\n';
    }
    while (at < text.length && at > 0 && ((unsigned char)text.at[at] & 0xc0) == 0x80) {
        --at;
    }
    return trim((Str){text.at, at});
}

Str hover_declaration(const Analysis *analysis, uint32_t file, AstId item)
{
    const Ast *ast = survey_ast(analysis->survey, file);
    const AstNode *node = ast_node(ast, item);
    Str text = tree_text(analysis, file);
    uint32_t begin = node->begin, end = node->end;
    if (node->tag == AST_FN) { // up to its body
        AstId body = tree_words(ast, node)[2];
        end = body ? ast_node(ast, body)->begin : end;
        while (end > begin && (isspace((unsigned char)text.at[end - 1]) ||
                               text.at[end - 1] == '=' || text.at[end - 1] == '{')) {
            --end;
        }
    } else if (node->tag == AST_FOR) { // `i in 0..<3`
        const uint32_t *words = tree_words(ast, node);
        begin = words[0];
        end = words[2] ? ast_node(ast, words[2])->end : words[1];
    }
    return end <= text.length && begin <= end ? shorten((Str){text.at + begin, end - begin})
                                              : STR("");
}

// Writes the `//` lines that stand directly above byte `at`, without their marks.
void hover_comment(Str text, uint32_t at, FILE *out)
{
    uint32_t line = at;
    while (line > 0 && text.at[line - 1] != '\n') {
        --line;
    }
    uint32_t first = line;
    for (uint32_t end = line; end > 0;) {
        uint32_t begin = end - 1;
        while (begin > 0 && text.at[begin - 1] != '\n') {
            --begin;
        }
        uint32_t mark = begin;
        while (mark < end && (text.at[mark] == ' ' || text.at[mark] == '\t')) {
            ++mark;
        }
        if (end - mark < 2 || text.at[mark] != '/' || text.at[mark + 1] != '/') {
            break;
        }
        first = end = begin;
    }
    while (first < line) {
        const char *begin = text.at + first;
        const char *end = memchr(begin, '\n', line - first);
        first += (uint32_t)(end - begin) + 1;
        begin += strspn(begin, " \t");
        begin += 2;
        begin += *begin == ' ';
        fprintf(out, "%.*s\n", (int)trim((Str){begin, (size_t)(end - begin)}).length, begin);
    }
}

static void write_value(const Document *document, const Analysis *analysis, uint32_t file,
                        AstId item, FILE *out)
{
    Span name = survey_name_span(analysis->survey, file, item);
    const ReportValue *value =
        report_value(&document->found, tree_file_path(analysis, file), name.begin);
    if (!value) {
        return;
    }
    fprintf(out, "\n%s: %s", value->type, value->text);
    if (value->varies) {
        fprintf(out, " at first; evaluated %u times", value->times);
    }
    fputc('\n', out);
}

static const char *role(AstTag tag)
{
    return tag == AST_PARAMETER ? "parameter " : tag == AST_FOR ? "for " : "";
}

static void write_item(const Document *document, const Analysis *analysis, const Meaning *meaning,
                       FILE *out, ManualStyle style)
{
    const Ast *ast = survey_ast(analysis->survey, meaning->file);
    AstTag tag = (AstTag)ast_node(ast, meaning->item)->tag;
    char text[SHOWN_BYTES + 64];
    Str declaration = hover_declaration(analysis, meaning->file, meaning->item);
    int length =
        snprintf(text, sizeof text, "%s%.*s", role(tag), (int)declaration.length, declaration.at);
    code(out, style, (Str){text, (size_t)length});
    if (tag != AST_PARAMETER && tag != AST_FOR) {
        fputc('\n', out);
        hover_comment(tree_text(analysis, meaning->file), ast_node(ast, meaning->item)->begin, out);
    }
    if (tag == AST_LET || tag == AST_PARAM) {
        write_value(document, analysis, meaning->file, meaning->item, out);
    }
}

// --- The manual ----------------------------------------------------------------------------------

void hover_builtin(const BuiltinInfo *builtin, FILE *out, ManualStyle style)
{
    code(out, style, str_from(builtin->signature));
    fprintf(out, "\n%s\n", builtin->doc);
}

void hover_field(const Param *param, FILE *out, ManualStyle style)
{
    fprintf(out, style == MANUAL_MARKDOWN ? "`%s`: " : "%s: ", param->name);
    manual_write_takes(param, out);
    fprintf(out, "\n\n%s\n", param->doc);
}

void hover_common_field(CommonField field, FILE *out, ManualStyle style)
{
    fprintf(out, style == MANUAL_MARKDOWN ? "`%s`: %s\n\n%s\n" : "%s: %s\n\n%s\n",
            common_field_name(field), manual_common_takes(field), common_field_doc(field));
}

static void write_field(const Target *target, FILE *out, ManualStyle style)
{
    if (target->param) {
        hover_field(target->param, out, style);
    } else if (target->common) {
        hover_common_field(target->common, out, style);
    } else if (target->type) {
        manual_write_kind(target->type, out, style);
    }
}

static void write_number(const Analysis *analysis, const Target *target, FILE *out)
{
    Quantity quantity = survey_number(analysis->survey, 0, target->node);
    const DimInfo *dim = dim_info((Dim)quantity.dim);
    Str text = tree_text(analysis, 0);
    int length = (int)(target->end - target->begin);
    if (quantity.dim == DIM_NONE) {
        fprintf(out, "%.*s: a bare number", length, text.at + target->begin);
        return;
    }
    fprintf(out, "%.*s: %s %s, %.10g %s", length, text.at + target->begin,
            strchr("aeio", dim->name[0]) ? "an" : "a", dim->name, quantity.value, dim->si_unit);
    if (quantity.dim == DIM_ANGLE) {
        fprintf(out, ", %.10gdeg", quantity.value * (180 / PI));
    }
    fputc('\n', out);
}

static void write_color(const Analysis *analysis, const Target *target, FILE *out)
{
    double color[3];
    if (survey_color(analysis->survey, 0, target->node, color)) {
        fprintf(out, "linear: rgb(%.4g, %.4g, %.4g)\n", color[0], color[1], color[2]);
    }
}

static void write_type(const Analysis *analysis, const Target *target, FILE *out)
{
    Str name = {tree_text(analysis, 0).at + target->begin, target->end - target->begin};
    for (size_t i = 0; i < lang_param_type_count; ++i) {
        if (str_equal(name, str_from(lang_param_types[i].name))) {
            fprintf(out, "%s: %s\n", lang_param_types[i].name, lang_param_types[i].doc);
        }
    }
}

static void write_constant(const ConstantInfo *constant, FILE *out)
{
    if (constant->moment >= 0) {
        fprintf(out, "%s: a %s\n\n%s\n", constant->name, dim_info(constant->dim)->name,
                constant->doc);
    } else {
        fprintf(out, "%s = %.15g\n\n%s\n", constant->name, constant->value, constant->doc);
    }
}

static void write_target(const Document *document, const Analysis *analysis, const Target *target,
                         FILE *out, ManualStyle style)
{
    switch (target->kind) {
    case TARGET_NAME:
        if (target->meaning.kind == MEANS_BUILTIN) {
            hover_builtin(&lang_builtins[target->meaning.number], out, style);
        } else if (target->meaning.kind == MEANS_CONSTANT) {
            write_constant(&lang_constants[target->meaning.number], out);
        } else {
            write_item(document, analysis, &target->meaning, out, style);
        }
        break;
    case TARGET_KIND:
        manual_write_kind(target->type, out, style);
        if (style == MANUAL_MARKDOWN) {
            manual_write_common_fields(target->type->category, out, style);
        }
        break;
    case TARGET_FIELD:
    case TARGET_STRING:
        write_field(target, out, style);
        break;
    case TARGET_NUMBER:
        write_number(analysis, target, out);
        break;
    case TARGET_COLOR:
        write_color(analysis, target, out);
        break;
    case TARGET_TYPE:
        write_type(analysis, target, out);
        break;
    case TARGET_IMPORT:
    case TARGET_NONE:
        break;
    }
}

// --- Words of the language -----------------------------------------------------------------------

typedef struct WordInfo {
    TokenKind kind;
    const char *form, *doc;
} WordInfo;

static const WordInfo words[] = {
    {TOKEN_IMPORT, "import \"file.scn\" as name",
     "Brings the names of another file, as `name.member`. The path is relative to this file."},
    {TOKEN_PARAM, "param name: type = default in range \"text\"",
     "A value that can be given from outside: `--set name=value`, and the controls of `watch`."},
    {TOKEN_LET, "let name = value", "Names a value. Names never change what they mean."},
    {TOKEN_FN, "fn name(a, b = 2) = value",
     "A function; in braces, `fn name(a) { items }`, its value is a group of what the items emit."},
    {TOKEN_EXPECT, "expect value == 3",
     "What is to hold of this scene; `scnrender test` checks it."},
    {TOKEN_FOR, "for (i in 0..<n) { items }",
     "The items once for each element; in a list, values."},
    {TOKEN_IF, "if (condition) a else b", "A choice; of items, it needs no `else`."},
    {TOKEN_ELSE, "if (condition) a else b", "What counts where the condition is false."},
    {TOKEN_WITH, "value with { field: other }", "A copy of a kind's value with other fields."},
    {TOKEN_TRUE, "true", "A bool."},
    {TOKEN_FALSE, "false", "A bool."},
};

static void write_word(uint8_t kind, FILE *out, ManualStyle style)
{
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i) {
        if (words[i].kind == kind) {
            code(out, style, str_from(words[i].form));
            fprintf(out, "\n%s\n", words[i].doc);
        }
    }
}

static const DocumentToken *token_at(const DocumentTokens *tokens, uint32_t offset)
{
    for (size_t i = 0; i < tokens->count && tokens->items[i].begin <= offset; ++i) {
        if (offset <= tokens->items[i].end) {
            return &tokens->items[i];
        }
    }
    return NULL;
}

// --- Diagnostics ---------------------------------------------------------------------------------

static void write_codes(const Document *document, const Report *report, uint32_t offset, FILE *out)
{
    for (size_t i = 0; i < report->items.count; ++i) {
        const ReportItem *item = &report->items.items[i];
        bool here = !item->gone && item->at.path && item->at.begin <= offset &&
                    offset <= item->at.end && strcmp(item->at.path, document->real) == 0;
        if (here) {
            const DiagInfo *info = diag_info(item->code);
            fprintf(out, "\n%s: %s\n", info->name, info->paragraph);
        }
    }
}

cJSON *feature_hover(Server *server, Document *document, const cJSON *params)
{
    const Analysis *analysis = document_analysis(server, document);
    uint32_t offset = server_offset(server, document, json_at(params, "position"));
    Memo memo;
    FILE *out = memo_begin(&memo);
    if (!analysis || !out) {
        memo_free(&memo);
        return NULL;
    }
    ManualStyle style = hover_style(server);
    Target target = target_at(analysis, offset);
    if (target.kind == TARGET_NONE) {
        const DocumentToken *token = token_at(document_tokens(server, document), offset);
        if (token) {
            target.begin = token->begin;
            target.end = token->end;
            write_word(token->kind, out, style);
        }
    } else {
        write_target(document, analysis, &target, out, style);
    }
    write_codes(document, &document->said, offset, out);
    write_codes(document, &document->found, offset, out);
    Str text = memo_text(&memo);
    cJSON *hover = NULL;
    if (text.length > 0) {
        hover = cJSON_CreateObject();
        cJSON *contents = cJSON_AddObjectToObject(hover, "contents");
        cJSON_AddStringToObject(contents, "kind",
                                style == MANUAL_MARKDOWN ? "markdown" : "plaintext");
        json_add_text(contents, "value", text);
        if (target.end > target.begin) {
            cJSON_AddItemToObject(hover, "range",
                                  json_range(server, &document->text, target.begin, target.end));
        }
    }
    memo_free(&memo);
    return hover;
}
