// A session's page, served on loopback.
//
// Whoever knows the address may do all that the page can, and nothing else: it holds a token of 128
// random bits, and a request that lacks it, names a host that isn't this machine's own, or comes
// from another site's page, is refused. No file is served; the page is part of the program.
#ifndef WATCH_SERVER_H
#define WATCH_SERVER_H

#include "watch/session.h"

typedef struct Server Server;

// Serves at *port of 127.0.0.1 (0: any that is free, which is then told). NULL with a message.
Server *server_new(Session *session, uint16_t *port, char *message, size_t message_size);
// "http://127.0.0.1:40123/0f…/"
const char *server_address(const Server *server);
// Closes the session, and waits for all who are connected. NULL is fine.
void server_free(Server *server);

#endif
