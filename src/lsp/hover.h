// Pieces of the manual and of declarations that hover, completion and signatures show.
#ifndef LSP_HOVER_H
#define LSP_HOVER_H

#include "lsp/tree.h"
#include "schema/manual.h"

ManualStyle hover_style(const Server *server);
// A declaration as it stands in its file, shortened; a function without its body.
Str hover_declaration(const Analysis *analysis, uint32_t file, AstId item);
void hover_comment(Str text, uint32_t at, FILE *out);
void hover_builtin(const BuiltinInfo *builtin, FILE *out, ManualStyle style);
void hover_field(const Param *param, FILE *out, ManualStyle style);
void hover_common_field(CommonField field, FILE *out, ManualStyle style);

#endif
