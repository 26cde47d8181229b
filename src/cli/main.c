// scnrender: from the command line to a command.
#include "cli/commands.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

// A program may be started with these closed; the next file to be opened would then take the place
// of, say, standard error.
static void occupy_standard_files(void)
{
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd) {
        if (fcntl(fd, F_GETFD) < 0 && errno == EBADF) {
            // Writing to a closed output stays an error.
            (void)!open("/dev/null", fd == STDERR_FILENO ? O_WRONLY : O_RDONLY);
        }
    }
}

// A closed pipe and a file that has grown too large become errors of the write.
static void ignore_write_signals(void)
{
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
}

static int run(const Options *options)
{
    switch (options->command) {
    case COMMAND_RENDER:
        return command_render(options);
    case COMMAND_WATCH:
        return command_watch(options);
    case COMMAND_MERGE:
        return command_merge(options);
    case COMMAND_CHECK:
        return command_check(options);
    case COMMAND_TEST:
        return command_test(options);
    case COMMAND_FURNACE:
        return command_furnace(options);
    case COMMAND_LIGHTS:
        return command_lights(options);
    case COMMAND_PARAMS:
        return command_params(options);
    case COMMAND_FMT:
        return command_fmt(options);
    case COMMAND_EXPORT:
        return command_export(options);
    case COMMAND_LSP:
        return command_lsp(options);
    case COMMAND_EXPLAIN:
        return command_explain(options);
    case COMMAND_REFERENCE:
        return command_reference(options);
    case COMMAND_HELP:
        return command_help(options);
    case COMMAND_COMPLETION:
        return command_completion(options);
    case COMMAND_VERSION:
        return command_version(options);
    case COMMAND_COUNT:
        break;
    }
    return EXIT_USAGE;
}

// What was printed must have got there.
static int finish_output(int code)
{
    errno = 0;
    if (fflush(stdout) == 0 && !ferror(stdout)) {
        return code;
    }
    fprintf(stderr, "scnrender: can't write to the standard output: %s\n",
            strerror(errno ? errno : EIO));
    return code == EXIT_OK ? EXIT_FILES : code;
}

int main(int argc, char **argv)
{
    occupy_standard_files();
    ignore_write_signals();
    Options options;
    int code = options_parse(&options, argc, argv, stderr) ? run(&options)
               : options.out_of_memory                     ? EXIT_NO_MEMORY
                                                           : EXIT_USAGE;
    options_free(&options);
    return finish_output(code);
}
