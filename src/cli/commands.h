// The commands, one file each. All return an ExitCode.
#ifndef CLI_COMMANDS_H
#define CLI_COMMANDS_H

#include "cli/options.h"

int command_render(const Options *options);
int command_watch(const Options *options);
int command_merge(const Options *options);
int command_check(const Options *options);
int command_test(const Options *options);
int command_furnace(const Options *options);
int command_lights(const Options *options);
int command_params(const Options *options);
int command_fmt(const Options *options);
int command_export(const Options *options);
int command_lsp(const Options *options);
int command_explain(const Options *options);
int command_reference(const Options *options);
int command_help(const Options *options);
int command_completion(const Options *options);
int command_version(const Options *options);

#endif
