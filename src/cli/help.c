// scnrender help [COMMAND]: made from the tables of options.def; 80 columns wide; the page of
// all commands fits a terminal of 24 lines.
#include "cli/commands.h"

#include "lang/lang.h"

#include <string.h>

enum { OPTION_COLUMN = 24 };

static void print_option(const OptionInfo *info)
{
    char left[64];
    char letter[8] = "    ";
    if (info->letter) {
        snprintf(letter, sizeof letter, "-%c, ", info->letter);
    }
    snprintf(left, sizeof left, "  %s--%s%s%s", letter, info->name,
             option_wants_argument((OptionId)(info - option_infos)) ? " " : "", info->argument);
    printf("%-*s  %s\n", OPTION_COLUMN, left, info->text);
}

static void print_options(Command command)
{
    for (int i = 0; i < OPTION_COUNT; ++i) {
        if (option_infos[i].commands & 1u << command) {
            print_option(&option_infos[i]);
        }
    }
}

static void print_main(void)
{
    puts("Usage: scnrender FILE.scn [options]\n"
         "       scnrender COMMAND ...    (`scnrender help COMMAND` tells its options)\n");
    for (int i = 0; i < COMMAND_COUNT; ++i) {
        if (i == COMMAND_REFERENCE || i == COMMAND_COMPLETION || i == COMMAND_VERSION) {
            continue; // below, in one line
        }
        char left[32];
        snprintf(left, sizeof left, "%s %s", command_infos[i].name, command_infos[i].operand);
        printf("  %-19s %s\n", left, command_infos[i].text);
    }
    puts("  reference  completion  version");
    puts("\nThe picture stands beside the scene under its name, or where -o says; FILE `-`\n"
         "is the standard input. Often used: -o FILE, --samples N, --size WxH, --set X=1;\n"
         "a sheet of pictures: --sweep X=A,B; numbered ones, or a film: --frames A..B.\n"
         "Exit status: 0 done, 1 a scene has errors or fails its test, 2 wrong use, 3 a\n"
         "file can't be read or written, 4 out of memory, 130 interrupted.");
}

static void print_limits(void)
{
    static const struct {
        const char *name, *text;
        uint64_t value;
    } limits[] = {
#define LIMIT(id, value, text) {#id, text, value},
        LIMITS(LIMIT)
#undef LIMIT
    };
    puts("\nLimits and what they are unless raised:");
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; ++i) {
        printf("  %-13s %12llu  %s\n", limits[i].name, (unsigned long long)limits[i].value,
               limits[i].text);
    }
}

static void print_command(Command command)
{
    const CommandInfo *info = &command_infos[command];
    printf("Usage: scnrender %s%s%s%s\n\n%s\n\n", info->name, *info->operand ? " " : "",
           info->operand, option_infos[OPTION_QUIET].commands & 1u << command ? " [options]" : "",
           info->text);
    print_options(command);
    if (command == COMMAND_CHECK) {
        print_limits();
    }
}

static const char *command_name(size_t i)
{
    return i < COMMAND_COUNT ? command_infos[i].name : NULL;
}

int command_help(const Options *options)
{
    if (!options->operand) {
        print_main();
        return EXIT_OK;
    }
    Command command = command_find(options->operand);
    if (command != COMMAND_COUNT) {
        print_command(command);
        return EXIT_OK;
    }
    const char *near = nearest_name(options->operand, command_name);
    fprintf(stderr, "scnrender: there is no command `%s`", options->operand);
    if (near) {
        fprintf(stderr, "; did you mean `%s`?", near);
    }
    fputc('\n', stderr);
    return EXIT_USAGE;
}
