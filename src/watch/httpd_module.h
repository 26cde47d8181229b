// Between httpd.c and the module that speaks HTTP (module_httpd.c, with libmicrohttpd): the module
// links nothing of ours, and is loaded by those who serve pages only.
//
// It listens on the loopback address and nowhere else, takes requests without a body, of bounded
// size, from a bounded number of connections, and drops those who are too slow.
#ifndef WATCH_HTTPD_MODULE_H
#define WATCH_HTTPD_MODULE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { HTTPD_MODULE_VERSION = 1 }; // to be raised with every change here
enum { HTTP_MOST_HEADERS = 8 };

// Strings live until the handler returns; NULL where the request has none.
typedef struct HttpRequest {
    const char *method, *path;              // the path is decoded and has no query
    const char *host, *origin, *fetch_site; // headers
    bool has_body; // it was refused already: any reply closes the connection
    // The value of `name` in the query, decoded; NULL where there is none.
    const char *(*argument)(const struct HttpRequest *request, const char *name);
    void *connection; // the module's own
} HttpRequest;

typedef struct HttpHeader {
    const char *name, *value;
} HttpHeader;

typedef struct HttpReply {
    unsigned status;
    HttpHeader headers[HTTP_MOST_HEADERS]; // up to the first without a name
    // The body: `size` bytes, given back by release(owner) (NULL: they stay for ever).
    const void *bytes;
    size_t size;
    void (*release)(void *owner);
    void *owner;
    // Or a stream, where `read` isn't NULL: it fills the buffer with the next bytes (at least one),
    // waiting for them, or returns -1 at the end; then end(stream) is called, as when the client
    // goes.
    int64_t (*read)(void *stream, char *buffer, size_t room);
    void (*end)(void *stream);
    void *stream;
    char text[64]; // room for a header's value
} HttpReply;

// Called from a thread of the connection's own.
typedef void HttpHandle(void *context, const HttpRequest *request, HttpReply *reply);

typedef struct HttpdFunctions {
    uint32_t version;
    // Serves on 127.0.0.1 at *port (0: any that is free, which is then told). NULL with a message.
    void *(*start)(uint16_t *port, HttpHandle *handle, void *context, char *message,
                   size_t message_size);
    // Waits for all handlers and streams to end.
    void (*stop)(void *server);
} HttpdFunctions;

#define HTTPD_MODULE_SYMBOL "scn_httpd_functions"

#endif
