// The call at hand: its function's parameters, with the one that is being written.
#include "lsp/context.h"
#include "lsp/features.h"
#include "lsp/hover.h"

#include <ctype.h>

// Adds a signature to the list; `label` is "name(a, b = 2)", and its parameters are what stands
// between commas at the outermost level.
static void add_signature(Server *server, cJSON *list, Str label, Str documentation,
                          const Context *context)
{
    cJSON *signature = cJSON_CreateObject();
    json_add_text(signature, "label", label);
    if (documentation.length > 0) {
        json_add_text(signature, "documentation", documentation);
    }
    cJSON *parameters = cJSON_AddArrayToObject(signature, "parameters");
    const char *open = memchr(label.at, '(', label.length);
    int depth = 0, count = 0, active = -1;
    size_t begin = open ? (size_t)(open - label.at) + 1 : label.length;
    for (size_t i = begin; open && i < label.length; ++i) {
        char c = label.at[i];
        bool ends = depth == 0 && (c == ',' || c == ')');
        depth += c == '(' || c == '[' || c == '{';
        depth -= (c == ')' || c == ']' || c == '}') && depth > 0;
        if (!ends) {
            continue;
        }
        while (begin < i && isspace((unsigned char)label.at[begin])) {
            ++begin;
        }
        if (begin < i) {
            Str text = {label.at + begin, i - begin};
            size_t name = 0;
            while (name < text.length &&
                   (isalnum((unsigned char)text.at[name]) || text.at[name] == '_')) {
                ++name;
            }
            bool named = context->argument_name.length > 0 &&
                         str_equal(context->argument_name, (Str){text.at, name});
            bool rest = text.length == 3 && memcmp(text.at, "…", 3) == 0;
            int place = (int)context->argument;
            active = named || (context->argument_name.length == 0 &&
                               (place == count || (rest && place >= count)))
                         ? count
                         : active;
            int offsets[2] = {
                (int)buffer_units((Str){label.at, begin}, server->encoding),
                (int)buffer_units((Str){label.at, i}, server->encoding),
            };
            cJSON *parameter = cJSON_CreateObject();
            cJSON_AddItemToObject(parameter, "label", cJSON_CreateIntArray(offsets, 2));
            cJSON_AddItemToArray(parameters, parameter);
            ++count;
        }
        begin = i + 1;
        if (c == ')') {
            break;
        }
    }
    // Beyond the last: no parameter is at hand.
    cJSON_AddNumberToObject(signature, "activeParameter", active >= 0 ? active : count);
    cJSON_AddItemToArray(list, signature);
}

// "min(a, b, …) or min(list)" are two.
static void add_builtin(Server *server, cJSON *list, const BuiltinInfo *builtin,
                        const Context *context)
{
    const char *at = builtin->signature;
    while (*at) {
        size_t length = strcspn(at, ")");
        length += at[length] == ')';
        add_signature(server, list, (Str){at, length}, str_from(builtin->doc), context);
        at += length;
        at += strspn(at, ", ");
        at += strncmp(at, "or ", 3) == 0 ? 3 : 0;
    }
}

// The fewest parameters that hold the argument.
static int best_signature(const cJSON *list, uint32_t argument)
{
    int index = 0, best = 0;
    const cJSON *signature;
    cJSON_ArrayForEach(signature, list)
    {
        int count = cJSON_GetArraySize(json_at(signature, "parameters"));
        if (json_get_number(signature, "activeParameter", 0) < count) {
            return index;
        }
        best = (uint32_t)count > argument ? index : best;
        ++index;
    }
    return best;
}

static void add_function(Server *server, cJSON *list, const Analysis *analysis, uint32_t file,
                         AstId fn, Str called, const Context *context)
{
    Str text = hover_declaration(analysis, file, fn);
    const char *open = memchr(text.at, '(', text.length);
    Memo label, comment;
    FILE *out = memo_begin(&label);
    if (out && open) {
        fprintf(out, "%.*s%.*s", (int)called.length, called.at, (int)(text.at + text.length - open),
                open);
    }
    out = memo_begin(&comment);
    if (out) {
        const Ast *ast = survey_ast(analysis->survey, file);
        hover_comment(tree_text(analysis, file), ast_node(ast, fn)->begin, out);
    }
    Str documentation = memo_text(&comment);
    if (open) {
        add_signature(server, list, memo_text(&label), documentation, context);
    }
    memo_free(&label);
    memo_free(&comment);
}

static void add_signatures(Server *server, cJSON *list, const Analysis *analysis,
                           const Context *context)
{
    Str text = tree_text(analysis, 0);
    Str called = {text.at + context->callee_begin, context->callee_end - context->callee_begin};
    AstId item = context_find(analysis, context->callee_begin, called);
    uint32_t file = 0;
    AstId fn = item ? tree_function(analysis, &file, item) : 0;
    if (!item) {
        for (size_t i = 0; i < lang_builtin_count; ++i) {
            if (str_equal(called, str_from(lang_builtins[i].name))) {
                add_builtin(server, list, &lang_builtins[i], context);
                return;
            }
        }
        // `space.name`
        const char *point = memchr(called.at, '.', called.length);
        size_t head = point ? (size_t)(point - called.at) : 0;
        AstId import =
            point ? context_find(analysis, context->callee_begin, (Str){called.at, head}) : 0;
        const Ast *ast = survey_ast(analysis->survey, 0);
        int64_t other = import && ast_node(ast, import)->tag == AST_IMPORT
                            ? survey_import(analysis->survey, 0, import)
                            : -1;
        AstId member = other >= 0 ? survey_find_global(analysis->survey, (uint32_t)other,
                                                       (Str){point + 1, called.length - head - 1})
                                  : 0;
        file = (uint32_t)other;
        fn = member ? tree_function(analysis, &file, member) : 0;
    }
    if (fn) {
        add_function(server, list, analysis, file, fn, called, context);
    }
}

cJSON *feature_signature_help(Server *server, Document *document, const cJSON *params)
{
    const Analysis *analysis = document_analysis(server, document);
    Context context;
    context_at(server, document, server_offset(server, document, json_at(params, "position")),
               &context);
    if (!analysis || !context.in_call) {
        return NULL;
    }
    cJSON *help = cJSON_CreateObject();
    cJSON *list = cJSON_AddArrayToObject(help, "signatures");
    add_signatures(server, list, analysis, &context);
    if (cJSON_GetArraySize(list) == 0) {
        cJSON_Delete(help);
        return NULL;
    }
    int best = best_signature(list, context.argument);
    cJSON_AddNumberToObject(help, "activeSignature", best);
    cJSON_AddNumberToObject(help, "activeParameter",
                            json_get_number(cJSON_GetArrayItem(list, best), "activeParameter", 0));
    return help;
}
