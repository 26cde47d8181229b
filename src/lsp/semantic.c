// Semantic tokens: what each word is, so that kinds, fields and functions are told apart.
#include "lsp/features.h"
#include "lsp/tree.h"

#include "base/mem.h"
#include "lang/lexer.h"

// TOKEN_TYPE(id, name) and the modifiers, in the order of the legend.
#define TOKEN_TYPES(TOKEN_TYPE)                                                                    \
    TOKEN_TYPE(NAMESPACE, "namespace")                                                             \
    TOKEN_TYPE(TYPE, "type")                                                                       \
    TOKEN_TYPE(PROPERTY, "property")                                                               \
    TOKEN_TYPE(FUNCTION, "function")                                                               \
    TOKEN_TYPE(PARAMETER, "parameter")                                                             \
    TOKEN_TYPE(VARIABLE, "variable")                                                               \
    TOKEN_TYPE(KEYWORD, "keyword")                                                                 \
    TOKEN_TYPE(NUMBER, "number")                                                                   \
    TOKEN_TYPE(STRING, "string")                                                                   \
    TOKEN_TYPE(OPERATOR, "operator")                                                               \
    TOKEN_TYPE(COMMENT, "comment")

typedef enum TokenType {
#define TOKEN_TYPE(id, name) TYPE_##id,
    TOKEN_TYPES(TOKEN_TYPE)
#undef TOKEN_TYPE
        TYPE_COUNT
} TokenType;

enum { MODIFIER_DECLARATION = 1, MODIFIER_READONLY = 2, MODIFIER_LIBRARY = 4 };

static const char *const type_names[] = {
#define TOKEN_TYPE(id, name) name,
    TOKEN_TYPES(TOKEN_TYPE)
#undef TOKEN_TYPE
};
static const char *const modifier_names[] = {"declaration", "readonly", "defaultLibrary"};

cJSON *semantic_token_legend(void)
{
    cJSON *legend = cJSON_CreateObject();
    cJSON_AddItemToObject(legend, "tokenTypes", cJSON_CreateStringArray(type_names, TYPE_COUNT));
    cJSON_AddItemToObject(legend, "tokenModifiers", cJSON_CreateStringArray(modifier_names, 3));
    return legend;
}

// --- What the words are --------------------------------------------------------------------------

// By the byte that a word begins at: its type + 1 and modifiers.
typedef struct Role {
    uint8_t type, modifiers;
} Role;

typedef struct Roles {
    const Analysis *analysis;
    const Ast *ast;
    Role *items;
    size_t count;
} Roles;

static void set(Roles *roles, uint32_t at, TokenType type, int modifiers)
{
    if (at < roles->count) {
        roles->items[at] = (Role){(uint8_t)(type + 1), (uint8_t)modifiers};
    }
}

static void set_item(Roles *roles, uint32_t at, uint32_t file, AstId item, int modifiers)
{
    switch ((AstTag)ast_node(survey_ast(roles->analysis->survey, file), item)->tag) {
    case AST_FN:
        set(roles, at, TYPE_FUNCTION, modifiers);
        break;
    case AST_IMPORT:
        set(roles, at, TYPE_NAMESPACE, modifiers);
        break;
    case AST_PARAMETER:
        set(roles, at, TYPE_PARAMETER, modifiers);
        break;
    default: {
        uint32_t other = file;
        bool is_function = tree_function(roles->analysis, &other, item) != 0;
        set(roles, at, is_function ? TYPE_FUNCTION : TYPE_VARIABLE, modifiers | MODIFIER_READONLY);
    }
    }
}

static void set_meaning(Roles *roles, uint32_t at, AstId id)
{
    Meaning meaning = survey_meaning(roles->analysis->survey, 0, id);
    switch (meaning.kind) {
    case MEANS_ITEM:
        set_item(roles, at, meaning.file, meaning.item, 0);
        break;
    case MEANS_BUILTIN:
        set(roles, at, TYPE_FUNCTION, MODIFIER_LIBRARY);
        break;
    case MEANS_CONSTANT:
        set(roles, at, TYPE_VARIABLE, MODIFIER_READONLY | MODIFIER_LIBRARY);
        break;
    case MEANS_NOTHING:
        break;
    }
}

static uint32_t member_begin(const Roles *roles, const AstNode *node)
{
    const char *text = tree_text(roles->analysis, 0).at;
    uint32_t at = node->end, least = ast_node(roles->ast, node->a)->end;
    while (at > least && text[at - 1] != '.' && (unsigned char)text[at - 1] > ' ') {
        --at;
    }
    return at;
}

static void set_node(Roles *roles, AstId id)
{
    const AstNode *node = ast_node(roles->ast, id);
    switch ((AstTag)node->tag) {
    case AST_KIND:
        set(roles, node->begin, TYPE_TYPE, tree_kind(roles->analysis, node) ? MODIFIER_LIBRARY : 0);
        break;
    case AST_FIELD:
        set(roles, node->begin, TYPE_PROPERTY, 0);
        break;
    case AST_ARGUMENT:
        set(roles, node->begin, TYPE_PARAMETER, 0);
        break;
    case AST_NAME:
        set_meaning(roles, node->begin, id);
        break;
    case AST_MEMBER: {
        uint32_t at = member_begin(roles, node);
        set(roles, at, TYPE_PROPERTY, 0);
        set_meaning(roles, at, id);
        break;
    }
    case AST_PARAM:
        set(roles, tree_words(roles->ast, node)[6], TYPE_TYPE, MODIFIER_LIBRARY);
        set_item(roles, survey_name_span(roles->analysis->survey, 0, id).begin, 0, id,
                 MODIFIER_DECLARATION);
        break;
    case AST_FN:
        if (!node->a) {
            break;
        }
        set_item(roles, survey_name_span(roles->analysis->survey, 0, id).begin, 0, id,
                 MODIFIER_DECLARATION);
        break;
    case AST_LET:
    case AST_IMPORT:
    case AST_PARAMETER:
    case AST_FOR:
        set_item(roles, survey_name_span(roles->analysis->survey, 0, id).begin, 0, id,
                 MODIFIER_DECLARATION);
        break;
    default:
        break;
    }
}

static bool find_roles(Roles *roles, const Analysis *analysis, size_t length)
{
    roles->analysis = analysis;
    roles->count = length;
    roles->items = mem_alloc_zeroed(length + 1, sizeof *roles->items);
    if (!roles->items) {
        return false;
    }
    roles->ast = survey_ast(analysis->survey, 0);
    for (AstId id = 1; id < roles->ast->nodes.count; ++id) {
        set_node(roles, id);
    }
    return true;
}

// --- Encoding ------------------------------------------------------------------------------------

typedef ARRAY(uint32_t) Numbers;

typedef struct Encoder {
    const Server *server;
    const Buffer *text;
    Numbers out;
    uint32_t line, line_at, column; // of the last token; where its line begins
    uint32_t seen, seen_column;     // a byte of that line and its column, to count on from
} Encoder;

static uint32_t column_of(Encoder *e, uint32_t at)
{
    if (e->seen < e->line_at || e->seen > at) {
        e->seen = e->line_at;
        e->seen_column = 0;
    }
    Str run = {e->text->bytes.items + e->seen, at - e->seen};
    e->seen_column += buffer_units(run, e->server->encoding);
    e->seen = at;
    return e->seen_column;
}

static void put(Encoder *e, uint32_t begin, uint32_t end, Role role)
{
    uint32_t line = e->line;
    while (line + 1 < e->text->lines.count && e->text->lines.items[line + 1] <= begin) {
        ++line;
    }
    if (end <= begin) {
        return;
    }
    bool same = line == e->line;
    uint32_t before = same ? e->column : 0;
    uint32_t lines = line - e->line;
    e->line = line;
    e->line_at = e->text->lines.items[line];
    uint32_t column = column_of(e, begin), width = column_of(e, end) - column;
    uint32_t numbers[] = {lines, column - before, width, role.type - 1u, role.modifiers};
    e->column = column;
    for (int i = 0; i < 5; ++i) {
        array_push(&e->out, numbers[i]);
    }
}

// Comments over several lines are told line by line.
static void put_lines(Encoder *e, uint32_t begin, uint32_t end, Role role)
{
    const char *bytes = e->text->bytes.items;
    while (begin < end) {
        uint32_t stop = begin;
        while (stop < end && bytes[stop] != '\n' && bytes[stop] != '\r') {
            ++stop;
        }
        put(e, begin, stop, role);
        begin = stop;
        while (begin < end && (bytes[begin] == '\n' || bytes[begin] == '\r')) {
            ++begin;
        }
    }
}

static Role token_role(const Roles *roles, const DocumentToken *token, const char *bytes)
{
    Role found = token->begin < roles->count ? roles->items[token->begin] : (Role){0};
    uint8_t kind = token->kind;
    if (kind == TOKEN_KIND_COUNT) {
        return (Role){TYPE_COMMENT + 1, 0};
    }
    if (kind == TOKEN_NAME) {
        uint32_t length = token->end - token->begin;
        bool word = (length == 3 && memcmp(bytes + token->begin, "scn", 3) == 0) ||
                    (length == 2 && memcmp(bytes + token->begin, "of", 2) == 0);
        return found.type ? found : word ? (Role){TYPE_KEYWORD + 1, 0} : (Role){0};
    }
    if (kind == TOKEN_NUMBER || kind == TOKEN_COLOR) {
        return (Role){TYPE_NUMBER + 1, 0};
    }
    if (kind == TOKEN_STRING) {
        return (Role){TYPE_STRING + 1, 0};
    }
    if (kind >= TOKEN_IMPORT && kind <= TOKEN_NOT) {
        return (Role){TYPE_KEYWORD + 1, 0};
    }
    bool is_operator = kind == TOKEN_RANGE || kind == TOKEN_RANGE_BELOW || kind >= TOKEN_ASSIGN;
    return is_operator ? (Role){TYPE_OPERATOR + 1, 0} : (Role){0};
}

// The tokens that touch bytes [begin, end).
static bool encode(Server *server, Document *document, uint32_t begin, uint32_t end, Numbers *out)
{
    const Analysis *analysis = document_analysis(server, document);
    const DocumentTokens *tokens = document_tokens(server, document);
    Roles roles;
    if (!analysis || !find_roles(&roles, analysis, document->text.bytes.count)) {
        return false;
    }
    Encoder e = {.server = server, .text = &document->text};
    const char *bytes = buffer_content(&document->text).at;
    for (size_t i = 0; i < tokens->count && tokens->items[i].begin < end; ++i) {
        const DocumentToken *token = &tokens->items[i];
        Role role = token_role(&roles, token, bytes);
        if (role.type && token->end > begin) {
            put_lines(&e, token->begin, token->end, role);
        }
    }
    mem_free(roles.items);
    *out = e.out;
    return true;
}

// --- Answers -------------------------------------------------------------------------------------

// Printed here: a cJSON number for each would take ten times as long.
static cJSON *numbers_to_json(const uint32_t *numbers, size_t count)
{
    char *text = mem_alloc(count * 11 + 3, 1), *out = text;
    if (!text) {
        return NULL;
    }
    *out++ = '[';
    for (size_t i = 0; i < count; ++i) {
        char digits[10];
        int length = 0;
        uint32_t number = numbers[i];
        do {
            digits[length++] = (char)('0' + number % 10);
        } while ((number /= 10) > 0);
        if (i > 0) {
            *out++ = ',';
        }
        while (length > 0) {
            *out++ = digits[--length];
        }
    }
    *out++ = ']';
    *out = '\0';
    cJSON *json = cJSON_CreateRaw(text);
    mem_free(text);
    return json;
}

static void keep_sent(Document *document, Numbers *numbers)
{
    mem_free(document->sent_tokens);
    document->sent_tokens = numbers->items;
    document->sent_count = numbers->count;
    ++document->sent_number;
}

static void add_result_id(cJSON *result, const Document *document)
{
    char id[16];
    snprintf(id, sizeof id, "%u", document->sent_number);
    cJSON_AddStringToObject(result, "resultId", id);
}

cJSON *feature_semantic_tokens(Server *server, Document *document, const cJSON *params)
{
    (void)params;
    Numbers numbers = {0};
    if (!encode(server, document, 0, UINT32_MAX, &numbers)) {
        return NULL;
    }
    cJSON *result = cJSON_CreateObject();
    keep_sent(document, &numbers);
    add_result_id(result, document);
    cJSON_AddItemToObject(result, "data", numbers_to_json(numbers.items, numbers.count));
    return result;
}

cJSON *feature_semantic_tokens_delta(Server *server, Document *document, const cJSON *params)
{
    char id[16];
    snprintf(id, sizeof id, "%u", document->sent_number);
    const char *previous = json_get_string(params, "previousResultId");
    Numbers numbers = {0};
    if (!previous || strcmp(previous, id) != 0 || !document->sent_tokens) {
        return feature_semantic_tokens(server, document, params);
    }
    if (!encode(server, document, 0, UINT32_MAX, &numbers)) {
        return NULL;
    }
    const uint32_t *old = document->sent_tokens;
    size_t before = document->sent_count, after = numbers.count, head = 0, tail = 0;
    while (head < before && head < after && old[head] == numbers.items[head]) {
        ++head;
    }
    while (tail < before - head && tail < after - head &&
           old[before - 1 - tail] == numbers.items[after - 1 - tail]) {
        ++tail;
    }
    cJSON *result = cJSON_CreateObject(), *edits = cJSON_AddArrayToObject(result, "edits");
    if (before - head - tail > 0 || after - head - tail > 0) {
        cJSON *edit = cJSON_CreateObject();
        cJSON_AddNumberToObject(edit, "start", (double)head);
        cJSON_AddNumberToObject(edit, "deleteCount", (double)(before - head - tail));
        cJSON_AddItemToObject(
            edit, "data",
            numbers_to_json(after ? &numbers.items[head] : NULL, after - head - tail));
        cJSON_AddItemToArray(edits, edit);
    }
    keep_sent(document, &numbers);
    add_result_id(result, document);
    return result;
}

cJSON *feature_semantic_tokens_range(Server *server, Document *document, const cJSON *params)
{
    uint32_t begin, end;
    server_range(server, document, json_at(params, "range"), &begin, &end);
    Numbers numbers = {0};
    if (!encode(server, document, begin, end, &numbers)) {
        return NULL;
    }
    cJSON *result = cJSON_CreateObject();
    cJSON_AddItemToObject(result, "data", numbers_to_json(numbers.items, numbers.count));
    array_free(&numbers);
    return result;
}
