// The arguments of options, checked and taken; see options.c.
#ifndef CLI_OPTION_ARGUMENTS_H
#define CLI_OPTION_ARGUMENTS_H

#include "cli/options.h"

// What is being parsed. Lists have room for every argument of the command line.
typedef struct OptionParser {
    Options *options;
    FILE *err;
    const char **aovs, **folders;
    ParamSetting *settings;
    Sweep *sweeps;
    bool help, version;
} OptionParser;

// `--samples` alone may be larger for `test`.
#define MOST_SAMPLES ((int64_t)INT32_MAX)

// Takes an option's argument (NULL where it has none). False after a message.
bool option_take(OptionParser *parser, OptionId id, const char *text);
// A message that memory ran out; false.
bool option_out_of_memory(const OptionParser *parser);
// A message of a wrong use; false.
bool option_wrong(const OptionParser *parser, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

#endif
