// scnrender completion SHELL: what a shell needs to complete the command line, from the tables of
// options.def.
#include "cli/commands.h"

#include <string.h>

// What an option's argument, or a command's operand, can be.
typedef enum Expected {
    EXPECT_WORD,
    EXPECT_FILE,
    EXPECT_SCENE,
    EXPECT_FOLDER,
    EXPECT_LIST
} Expected;

typedef struct Choice {
    const char *argument; // or operand, as the tables have it
    Expected expected;
    const char *words; // EXPECT_LIST
} Choice;

static const char *const command_list = "@commands";

static Choice option_choice(OptionId id)
{
    const char *argument = option_infos[id].argument;
    switch (id) {
    case OPTION_BITS:
        return (Choice){argument, EXPECT_LIST, "8 16 32"};
    case OPTION_TONE:
        return (Choice){argument, EXPECT_LIST, "srgb linear aces filmic"};
    case OPTION_DUMP:
        return (Choice){argument, EXPECT_LIST, "tokens ast scene"};
    case OPTION_DIAGNOSTICS:
        return (Choice){argument, EXPECT_LIST, "text json"};
    case OPTION_AOV:
        return (Choice){argument, EXPECT_LIST,
                        "alpha albedo normal depth position object_id material_id variance"};
    default:
        return (Choice){argument,
                        strcmp(argument, "FILE") == 0  ? EXPECT_FILE
                        : strcmp(argument, "DIR") == 0 ? EXPECT_FOLDER
                                                       : EXPECT_WORD,
                        NULL};
    }
}

static Choice operand_choice(Command command)
{
    const char *operand = command_infos[command].operand;
    if (strncmp(operand, "FILE", 4) == 0) {
        return (Choice){operand, EXPECT_SCENE, NULL};
    }
    return command == COMMAND_HELP         ? (Choice){operand, EXPECT_LIST, command_list}
           : command == COMMAND_COMPLETION ? (Choice){operand, EXPECT_LIST, "bash zsh fish"}
                                           : (Choice){operand, EXPECT_WORD, NULL};
}

static bool wants_argument(const OptionInfo *info)
{
    return option_wants_argument((OptionId)(info - option_infos));
}

static bool takes(Command command, int option)
{
    return (option_infos[option].commands & 1u << command) != 0;
}

static void print_command_names(void)
{
    for (int i = 0; i < COMMAND_COUNT; ++i) {
        printf("%s%s", i ? " " : "", command_infos[i].name);
    }
}

static void print_words(Choice choice)
{
    if (choice.words == command_list) {
        print_command_names();
    } else {
        fputs(choice.words, stdout);
    }
}

// Between single quotes of any of the shells.
static void print_quoted(const char *text, const char *escaped)
{
    for (; *text; ++text) {
        if (*text == '\'') {
            fputs("'\\''", stdout);
        } else {
            if (strchr(escaped, *text)) {
                putchar('\\');
            }
            putchar(*text);
        }
    }
}

// --- bash ----------------------------------------------------------------------------------------

static void bash_choice(Choice choice)
{
    switch (choice.expected) {
    case EXPECT_FILE:
        puts("IFS=$'\\n' COMPREPLY=($(compgen -f -- \"$word\"))");
        break;
    case EXPECT_SCENE:
        puts("IFS=$'\\n' COMPREPLY=($(compgen -f -X '!*.scn' -- \"$word\") $(compgen -d -- "
             "\"$word\"))");
        break;
    case EXPECT_FOLDER:
        puts("IFS=$'\\n' COMPREPLY=($(compgen -d -- \"$word\"))");
        break;
    case EXPECT_LIST:
        fputs("COMPREPLY=($(compgen -W '", stdout);
        print_words(choice);
        puts("' -- \"$word\"))");
        break;
    case EXPECT_WORD:
        puts("COMPREPLY=()");
        break;
    }
}

static void bash_options(void)
{
    puts("    case $before in");
    for (int i = 0; i < OPTION_COUNT; ++i) {
        if (option_wants_argument((OptionId)i)) {
            printf("    --%s", option_infos[i].name);
            if (option_infos[i].letter) {
                printf(" | -%c", option_infos[i].letter);
            }
            fputs(")\n        ", stdout);
            bash_choice(option_choice((OptionId)i));
            puts("        return ;;");
        }
    }
    puts("    esac");
}

static void bash_commands(void)
{
    puts("    case $command in");
    for (int i = 0; i < COMMAND_COUNT; ++i) {
        printf("    %s)\n        options='", command_infos[i].name);
        for (int k = 0; k < OPTION_COUNT; ++k) {
            if (takes((Command)i, k)) {
                printf("--%s ", option_infos[k].name);
            }
        }
        fputs("'\n        ", stdout);
        bash_choice(operand_choice((Command)i));
        puts("        ;;");
    }
    puts("    esac");
}

static void print_bash(void)
{
    fputs("# Completion of scnrender for bash, made by `scnrender completion bash`.\n"
          "_scnrender() {\n"
          "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}\n"
          "    local command=render options='' first='' i IFS=$' \\t\\n'\n"
          "    COMPREPLY=()\n"
          "    if [[ $word == '=' ]]; then word=''; fi\n"
          "    if [[ $before == '=' && COMP_CWORD -ge 2 ]]; then "
          "before=${COMP_WORDS[COMP_CWORD-2]}; fi\n",
          stdout);
    bash_options();
    fputs("    for ((i = 1; i < COMP_CWORD; ++i)); do\n"
          "        if [[ ${COMP_WORDS[i]} != -* ]]; then first=${COMP_WORDS[i]}; break; fi\n"
          "    done\n"
          "    case $first in\n    ",
          stdout);
    for (int i = 0; i < COMMAND_COUNT; ++i) {
        printf("%s%s", i ? " | " : "", command_infos[i].name);
    }
    puts(") command=$first ;;\n    esac");
    bash_commands();
    fputs("    IFS=$' \\t\\n'\n"
          "    if [[ $word == -* ]]; then\n"
          "        COMPREPLY=($(compgen -W \"$options\" -- \"$word\"))\n"
          "    elif [[ -z $first ]]; then\n"
          "        COMPREPLY+=($(compgen -W '",
          stdout);
    print_command_names();
    puts("' -- \"$word\"))\n    fi\n}\n"
         "complete -o filenames -o bashdefault -F _scnrender scnrender");
}

// --- zsh -----------------------------------------------------------------------------------------

static void zsh_choice(Choice choice)
{
    switch (choice.expected) {
    case EXPECT_FILE:
        fputs(":file:_files", stdout);
        break;
    case EXPECT_SCENE:
        fputs(":scene:_files -g \"*.scn(-.)\"", stdout);
        break;
    case EXPECT_FOLDER:
        fputs(":folder:_files -/", stdout);
        break;
    case EXPECT_LIST:
        printf(":%s:(", choice.argument);
        print_words(choice);
        putchar(')');
        break;
    case EXPECT_WORD:
        printf(":%s: ", choice.argument);
        break;
    }
}

static void zsh_option(int option)
{
    const OptionInfo *info = &option_infos[option];
    const char *equals = wants_argument(info) ? "=" : "";
    if (info->letter) {
        printf(" \\\n            '(-%c --%s)'{-%c%s,--%s%s}'[", info->letter, info->name,
               info->letter, wants_argument(info) ? "+" : "", info->name, equals);
    } else {
        printf(" \\\n            '*--%s%s[", info->name, equals);
    }
    print_quoted(info->text, "[]:");
    putchar(']');
    if (wants_argument(info)) {
        zsh_choice(option_choice((OptionId)option));
    }
    putchar('\'');
}

static void zsh_command(Command command)
{
    printf("    %s)\n        _arguments -s", command_infos[command].name);
    for (int i = 0; i < OPTION_COUNT; ++i) {
        if (takes(command, i)) {
            zsh_option(i);
        }
    }
    if (*command_infos[command].operand) {
        fputs(" \\\n            '*", stdout);
        zsh_choice(operand_choice(command));
        putchar('\'');
    }
    puts(" ;;");
}

static void print_zsh(void)
{
    fputs("#compdef scnrender\n"
          "# Completion of scnrender for zsh, made by `scnrender completion zsh`.\n"
          "_scnrender() {\n"
          "    local command=render\n"
          "    local -a commands\n"
          "    commands=(\n",
          stdout);
    for (int i = 0; i < COMMAND_COUNT; ++i) {
        printf("        '%s:", command_infos[i].name);
        print_quoted(command_infos[i].text, ":");
        puts("'");
    }
    fputs("    )\n"
          "    if (( CURRENT == 2 )) && [[ $words[2] != -* ]]; then\n"
          "        _describe command commands\n"
          "        _files -g '*.scn(-.)'\n"
          "        return\n"
          "    fi\n"
          "    if (( ${commands[(I)$words[2]:*]} )); then\n"
          "        command=$words[2]\n"
          "        shift words\n"
          "        (( CURRENT-- ))\n"
          "    fi\n"
          "    case $command in\n",
          stdout);
    for (int i = 0; i < COMMAND_COUNT; ++i) {
        zsh_command((Command)i);
    }
    puts("    esac\n}\n"
         "if [[ $funcstack[1] == _scnrender ]]; then _scnrender \"$@\"; "
         "else compdef _scnrender scnrender; fi");
}

// --- fish ----------------------------------------------------------------------------------------

static void fish_condition(unsigned commands)
{
    unsigned all = (1u << COMMAND_COUNT) - 1;
    if ((commands & all) == all) {
        return;
    }
    fputs(" -n '", stdout);
    const char *separator = "";
    if (commands & 1u << COMMAND_RENDER) { // also where no command is named
        fputs("not __fish_seen_subcommand_from ", stdout);
        for (int i = 0; i < COMMAND_COUNT; ++i) {
            if (!(commands & 1u << i)) {
                printf("%s%s", separator, command_infos[i].name);
                separator = " ";
            }
        }
    } else {
        fputs("__fish_seen_subcommand_from", stdout);
        for (int i = 0; i < COMMAND_COUNT; ++i) {
            if (commands & 1u << i) {
                printf(" %s", command_infos[i].name);
            }
        }
    }
    putchar('\'');
}

static void fish_choice(Choice choice)
{
    switch (choice.expected) {
    case EXPECT_FILE:
        fputs(" -r -F", stdout);
        break;
    case EXPECT_SCENE:
        fputs(" -a '(__fish_complete_suffix .scn)'", stdout);
        break;
    case EXPECT_FOLDER:
        fputs(" -x -a '(__fish_complete_directories)'", stdout);
        break;
    case EXPECT_LIST:
        fputs(" -x -a '", stdout);
        print_words(choice);
        putchar('\'');
        break;
    case EXPECT_WORD:
        fputs(" -x", stdout);
        break;
    }
}

static void print_fish(void)
{
    puts("# Completion of scnrender for fish, made by `scnrender completion fish`.\n"
         "complete -c scnrender -f");
    for (int i = 0; i < COMMAND_COUNT; ++i) {
        printf("complete -c scnrender -n __fish_use_subcommand -a %s -d '", command_infos[i].name);
        print_quoted(command_infos[i].text, "");
        puts("'");
        Choice choice = operand_choice((Command)i);
        if (choice.expected != EXPECT_WORD) {
            fputs("complete -c scnrender", stdout);
            fish_condition(1u << i);
            fish_choice(choice);
            putchar('\n');
        }
    }
    for (int i = 0; i < OPTION_COUNT; ++i) {
        const OptionInfo *info = &option_infos[i];
        fputs("complete -c scnrender", stdout);
        fish_condition(info->commands);
        if (info->letter) {
            printf(" -s %c", info->letter);
        }
        printf(" -l %s", info->name);
        if (wants_argument(info)) {
            fish_choice(option_choice((OptionId)i));
        }
        fputs(" -d '", stdout);
        print_quoted(info->text, "");
        puts("'");
    }
}

int command_completion(const Options *options)
{
    static const struct {
        const char *name;
        void (*print)(void);
    } shells[] = {{"bash", print_bash}, {"zsh", print_zsh}, {"fish", print_fish}};
    for (size_t i = 0; i < sizeof shells / sizeof shells[0]; ++i) {
        if (strcmp(shells[i].name, options->operand) == 0) {
            shells[i].print();
            return EXIT_OK;
        }
    }
    fprintf(stderr, "scnrender: completions are made for bash, zsh and fish, not for `%s`\n",
            options->operand);
    return EXIT_USAGE;
}
