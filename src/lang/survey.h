// What an editor asks of a scene's text: the trees of all its files, and what the names in them
// mean. A survey parses and resolves as lang_load does, and reports the same mistakes, but
// evaluates nothing, so that it can be made anew with each key pressed.
#ifndef LANG_SURVEY_H
#define LANG_SURVEY_H

#include "lang/ast.h"
#include "lang/lang.h"

typedef struct Survey Survey;

// Surveys `text` as the file at `path` (absolute), shown as `shown`; the text must live as long as
// the survey. Mistakes are reported to lang->sink. NULL without memory (reported). It needs a
// stack of some MiB. To be given back with survey_free before lang_free.
Survey *survey_open(Lang *lang, Str text, const char *path, const char *shown);
void survey_free(Survey *survey);

// The files by number: 0 is the surveyed one, the others are imported. Not for files that could
// not be read.
uint32_t survey_file_count(const Survey *survey);
// The tree of a file. Its nodes are those that ast.h describes, but for what the resolver keeps in
// NAMEs, MEMBERs, NUMBERs, COLORs and `aux`: ask below, and read the source. root may be 0.
const Ast *survey_ast(const Survey *survey, uint32_t file);
// The number of the file whose absolute path is `real`, or -1.
int64_t survey_find_file(const Survey *survey, const char *real);

typedef enum MeaningKind {
    MEANS_NOTHING, // unknown, or a part of a value (`v.x`)
    MEANS_ITEM,    // `item`: a LET, FN, PARAM, IMPORT, PARAMETER, or FOR for its variable
    MEANS_BUILTIN, // lang_builtins[number]
    MEANS_CONSTANT // lang_constants[number]
} MeaningKind;

typedef struct Meaning {
    MeaningKind kind;
    uint32_t file; // that `item` stands in
    AstId item;
    uint32_t number;
} Meaning;

// What a NAME or MEMBER node stands for.
Meaning survey_meaning(const Survey *survey, uint32_t file, AstId node);
// The file that an IMPORT brings, or -1 where it could not be read.
int64_t survey_import(const Survey *survey, uint32_t file, AstId item);
// The item that the file itself declares under a name, or 0.
AstId survey_find_global(const Survey *survey, uint32_t file, Str name);
// Where and how a declaration (see MEANS_ITEM) is called.
Span survey_name_span(const Survey *survey, uint32_t file, AstId item);
Str survey_name(const Survey *survey, uint32_t file, AstId item);
// The value of a NUMBER in SI, with its dimension.
Quantity survey_number(const Survey *survey, uint32_t file, AstId node);
// The linear components of a color that is written out: a COLOR, or a CALL of a built-in function
// of colors whose arguments are numbers written out. False for anything else, and for mistakes.
bool survey_color(const Survey *survey, uint32_t file, AstId node, double color[3]);
// A FIELD of a KIND (see schema.h): its parameter, or NULL and *common, or NULL and 0 for `items`,
// `of` and unknown ones.
const Param *survey_field(const Survey *survey, const NodeType *type, const AstNode *field,
                          CommonField *common);

#endif
