// The module scn_httpd.so: HTTP through libmicrohttpd, a thread for each connection.
#include "watch/httpd_module.h"

#include <arpa/inet.h>
#include <errno.h>
#include <microhttpd.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

enum {
    MOST_CONNECTIONS = 64,
    REQUEST_MEMORY = 24 << 10, // for a request's line, headers and query together
    IDLE_SECONDS = 30,
    STREAM_BLOCK = 64 << 10,
};

// 0.9.71 gave the results of callbacks a type of their own.
#if MHD_VERSION >= 0x00097002
typedef enum MHD_Result HttpResult;
#else
typedef int HttpResult;
#endif

typedef struct Server {
    struct MHD_Daemon *daemon;
    HttpHandle *handle;
    void *context;
} Server;

static const char *argument(const HttpRequest *request, const char *name)
{
    return MHD_lookup_connection_value(request->connection, MHD_GET_ARGUMENT_KIND, name);
}

static const char *header(struct MHD_Connection *connection, const char *name)
{
    return MHD_lookup_connection_value(connection, MHD_HEADER_KIND, name);
}

typedef struct Stream {
    int64_t (*read)(void *stream, char *buffer, size_t room);
    void (*end)(void *stream);
    void *stream;
} Stream;

static ssize_t read_stream(void *context, uint64_t position, char *buffer, size_t room)
{
    (void)position;
    const Stream *stream = context;
    int64_t length = stream->read(stream->stream, buffer, room);
    return length > 0 ? (ssize_t)length : MHD_CONTENT_READER_END_OF_STREAM;
}

static void end_stream(void *context)
{
    Stream *stream = context;
    if (stream->end) {
        stream->end(stream->stream);
    }
    free(stream);
}

static struct MHD_Response *make_stream(const HttpReply *reply)
{
    Stream *stream = malloc(sizeof *stream);
    if (!stream) {
        return NULL;
    }
    *stream = (Stream){reply->read, reply->end, reply->stream};
    struct MHD_Response *response = MHD_create_response_from_callback(
        MHD_SIZE_UNKNOWN, STREAM_BLOCK, read_stream, stream, end_stream);
    if (!response) {
        free(stream);
    }
    return response;
}

static struct MHD_Response *make_response(const HttpReply *reply)
{
    if (reply->read) {
        return make_stream(reply);
    }
    union { // the body isn't written to
        const void *in;
        void *out;
    } bytes = {reply->size > 0 ? reply->bytes : ""};
    return reply->release
               ? MHD_create_response_from_buffer_with_free_callback_cls(
                     reply->size, bytes.out, reply->release, reply->owner)
               : MHD_create_response_from_buffer(reply->size, bytes.out, MHD_RESPMEM_PERSISTENT);
}

static void drop_body(const HttpReply *reply)
{
    if (reply->read && reply->end) {
        reply->end(reply->stream);
    } else if (!reply->read && reply->release) {
        reply->release(reply->owner);
    }
}

static HttpResult answer(struct MHD_Connection *connection, const HttpReply *reply)
{
    struct MHD_Response *response = make_response(reply);
    if (!response) {
        drop_body(reply);
        return MHD_NO; // closes the connection
    }
    for (int i = 0; i < HTTP_MOST_HEADERS && reply->headers[i].name; ++i) {
        MHD_add_response_header(response, reply->headers[i].name, reply->headers[i].value);
    }
    HttpResult result = MHD_queue_response(connection, reply->status, response);
    MHD_destroy_response(response);
    return result;
}

static HttpResult on_request(void *context, struct MHD_Connection *connection, const char *path,
                             const char *method, const char *version, const char *upload,
                             size_t *upload_size, void **state)
{
    (void)version;
    (void)upload;
    static int seen_headers;
    const char *length = header(connection, "Content-Length");
    bool has_body = header(connection, "Transfer-Encoding") ||
                    (length && strspn(length, "0") != strlen(length));
    if (!*state && !has_body) {
        *state = &seen_headers; // the request is whole at the next call
        return MHD_YES;
    }
    *upload_size = 0;
    const Server *server = context;
    const HttpRequest request = {
        .method = method,
        .path = path,
        .host = header(connection, "Host"),
        .origin = header(connection, "Origin"),
        .fetch_site = header(connection, "Sec-Fetch-Site"),
        .has_body = has_body,
        .argument = argument,
        .connection = connection,
    };
    HttpReply reply = {0};
    server->handle(server->context, &request, &reply);
    return answer(connection, &reply);
}

// Nothing is printed: who isn't understood gets an error.
static void say_nothing(void *context, const char *format, va_list arguments)
{
    (void)context;
    (void)format;
    (void)arguments;
}

static uint16_t bound_port(struct MHD_Daemon *daemon)
{
    const union MHD_DaemonInfo *info = MHD_get_daemon_info(daemon, MHD_DAEMON_INFO_BIND_PORT);
    return info ? info->port : 0;
}

static void *start(uint16_t *port, HttpHandle *handle, void *context, char *message,
                   size_t message_size)
{
    Server *server = calloc(1, sizeof *server);
    if (!server) {
        snprintf(message, message_size, "not enough memory");
        return NULL;
    }
    server->handle = handle;
    server->context = context;
    struct sockaddr_in loopback = {
        .sin_family = AF_INET, .sin_port = htons(*port), .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    errno = 0;
    server->daemon = MHD_start_daemon(
        MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_THREAD_PER_CONNECTION | MHD_USE_POLL |
            MHD_USE_ERROR_LOG,
        *port, NULL, NULL, on_request, server, MHD_OPTION_EXTERNAL_LOGGER, say_nothing, NULL,
        MHD_OPTION_SOCK_ADDR, &loopback, MHD_OPTION_CONNECTION_LIMIT, (unsigned)MOST_CONNECTIONS,
        MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)REQUEST_MEMORY, MHD_OPTION_CONNECTION_TIMEOUT,
        (unsigned)IDLE_SECONDS, MHD_OPTION_END);
    if (!server->daemon) {
        snprintf(message, message_size, "can't listen at port %u of 127.0.0.1: %s", *port,
                 errno ? strerror(errno) : "libmicrohttpd refuses");
        free(server);
        return NULL;
    }
    *port = bound_port(server->daemon);
    return server;
}

static void stop(void *opaque)
{
    Server *server = opaque;
    MHD_stop_daemon(server->daemon);
    free(server);
}

extern const HttpdFunctions scn_httpd_functions;
const HttpdFunctions scn_httpd_functions = {HTTPD_MODULE_VERSION, start, stop};
