// scnrender watch FILE: a scene and its picture, which follow each other, until a signal ends it.
#include "cli/commands.h"
#include "cli/load.h"
#include "cli/watch_terminal.h"
#include "watch/server.h"
#include "watch/tev.h"

#include <errno.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

static SessionOptions session_options(const Options *options)
{
    return (SessionOptions){
        .scene = {.file = options->operand,
                  .settings = options->settings,
                  .setting_count = options->setting_count,
                  .folders = options->folders,
                  .folder_count = options->folder_count,
                  .limits = options->limits,
                  .threads = options->threads,
                  .print_to = options->quiet || options->terminal ? NULL : stderr},
        .camera = options->camera,
        .width = options->width,
        .height = options->height,
        .samples = options->samples,
        .seed = options->seed,
        .polling = options->poll};
}

static int check(const Options *options)
{
    if (strcmp(options->operand, "-") == 0) {
        return complain(EXIT_USAGE, "`watch` wants a file, which can change; not standard input");
    }
    if (access(options->operand, R_OK) != 0) {
        return complain(EXIT_FILES, "can't read `%s`: %s", options->operand, strerror(errno));
    }
    uint64_t pixels = (uint64_t)options->width * (uint64_t)options->height;
    if (pixels > options->limits.pixels) {
        return complain(EXIT_USAGE, "%d x %d pixels are more than the limit of %llu",
                        options->width, options->height,
                        (unsigned long long)options->limits.pixels);
    }
    return EXIT_OK;
}

// The signals that end the program, held back so that they can be waited for.
static sigset_t hold_signals(void)
{
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &signals, NULL);
    return signals;
}

static int serve(const Options *options, Session *session, const sigset_t *signals)
{
    char message[500];
    uint16_t port = options->port;
    Server *server = server_new(session, &port, message, sizeof message);
    if (!server) {
        return complain(EXIT_FILES, "%s", message);
    }
    puts(server_address(server));
    fflush(stdout);
    if (!options->quiet) {
        fprintf(stderr, "scnrender: open that address in a browser; Ctrl+C ends\n");
    }
    int signal_number;
    sigwait(signals, &signal_number);
    // Ending waits for what can't be broken off, as an accelerator that is built; a second signal
    // doesn't.
    pthread_sigmask(SIG_UNBLOCK, signals, NULL);
    server_free(server);
    return EXIT_OK;
}

int command_watch(const Options *options)
{
    int code = check(options);
    if (code != EXIT_OK) {
        return code;
    }
    sigset_t signals = hold_signals();
    char message[500];
    SessionOptions session_of = session_options(options);
    Session *session = session_new(&session_of, message, sizeof message);
    if (!session) {
        return complain(EXIT_NO_MEMORY, "%s", message);
    }
    const char *slash = strrchr(options->operand, '/');
    const char *name = slash ? slash + 1 : options->operand;
    TevSender *tev =
        options->tev ? tev_new(session, options->tev, name, message, sizeof message) : NULL;
    if (options->tev && !tev) {
        code = complain(EXIT_USAGE, "%s", message);
    } else if (options->terminal) {
        code = watch_on_terminal(options, session, &signals);
    } else {
        code = serve(options, session, &signals);
    }
    tev_free(tev);
    session_free(session);
    return code;
}
