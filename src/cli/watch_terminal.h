// `scnrender watch --terminal`: the terminal itself, its size, its keys and its end.
#ifndef CLI_WATCH_TERMINAL_H
#define CLI_WATCH_TERMINAL_H

#include "cli/options.h"
#include "watch/session.h"

#include <signal.h>

// Shows the session until a key or one of the signals (which are blocked) ends it. An ExitCode.
int watch_on_terminal(const Options *options, Session *session, const sigset_t *signals);

#endif
