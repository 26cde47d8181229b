// The features: each takes a request's document and params and gives its result (NULL: null). Those
// that fail call server_fail.
#ifndef LSP_FEATURES_H
#define LSP_FEATURES_H

#include "lsp/server.h"

typedef cJSON *Feature(Server *server, Document *document, const cJSON *params);

Feature feature_completion;
Feature feature_hover;
Feature feature_signature_help;
Feature feature_definition;
Feature feature_references;
Feature feature_highlight;
Feature feature_prepare_rename;
Feature feature_rename;
Feature feature_document_symbols;
Feature feature_colors;
Feature feature_color_presentations;
Feature feature_formatting;
Feature feature_range_formatting;
Feature feature_code_actions;
Feature feature_semantic_tokens;
Feature feature_semantic_tokens_delta;
Feature feature_semantic_tokens_range;
Feature feature_inlay_hints;
Feature feature_folding_ranges;
Feature feature_selection_ranges;
Feature feature_links;

// Requests without a document.
cJSON *feature_resolve_completion(Server *server, const cJSON *params);
cJSON *feature_workspace_symbols(Server *server, const cJSON *params);

// "legend" of the semantic tokens.
cJSON *semantic_token_legend(void);

#endif
