#include "watch/server.h"

#include "base/mem.h"
#include "base/module.h"
#include "watch/httpd_module.h"
#include "watch/inspect.h"
#include "watch/page.h"
#include "watch/save.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/random.h>

enum { TOKEN_BYTES = 16, KEEPALIVE_MS = 10000, EVENT_ROOM = 64 << 10 };

struct Server {
    Session *session;
    const HttpdFunctions *http;
    void *daemon;
    char token[2 * TOKEN_BYTES + 1];
    char address[100];
};

// --- Replies -------------------------------------------------------------------------------------

static void add_header(HttpReply *reply, const char *name, const char *value)
{
    for (int i = 0; i < HTTP_MOST_HEADERS; ++i) {
        if (!reply->headers[i].name) {
            reply->headers[i] = (HttpHeader){name, value};
            return;
        }
    }
}

static void reply_with(HttpReply *reply, unsigned status, const char *type)
{
    reply->status = status;
    add_header(reply, "Content-Type", type);
    add_header(reply, "Cache-Control", "no-store");
    add_header(reply, "X-Content-Type-Options", "nosniff");
    add_header(reply, "Referrer-Policy", "no-referrer");
}

// `text` must stay.
static void reply_text(HttpReply *reply, unsigned status, const char *text)
{
    reply_with(reply, status, "text/plain; charset=utf-8");
    reply->bytes = text;
    reply->size = strlen(text);
}

static void reply_json(HttpReply *reply, Text json)
{
    if (json.failed) {
        text_free(&json);
        reply_text(reply, 500, "not enough memory\n");
        return;
    }
    reply_with(reply, 200, "application/json");
    reply->bytes = reply->owner = json.bytes;
    reply->size = json.length;
    reply->release = mem_free;
}

static void reply_done(HttpReply *reply, bool good, const char *message)
{
    Text text = {0};
    if (good) {
        reply_with(reply, 204, "text/plain; charset=utf-8");
        return;
    }
    text_print(&text, "%s", message);
    reply_json(reply, text);
    reply->status = reply->status == 200 ? 422 : reply->status;
    reply->headers[0].value = "text/plain; charset=utf-8";
}

// --- The page ------------------------------------------------------------------------------------

static void serve_page(const char *name, HttpReply *reply)
{
    for (size_t i = 0; i < page_file_count; ++i) {
        if (strcmp(page_files[i].name, *name ? name : "index.html") == 0) {
            reply_with(reply, 200, page_files[i].type);
            add_header(reply, "Content-Security-Policy",
                       "default-src 'none'; script-src 'self'; style-src 'self'; "
                       "img-src 'self' data: blob:; connect-src 'self'; form-action 'none'; "
                       "base-uri 'none'");
            reply->bytes = page_files[i].bytes;
            reply->size = page_files[i].size;
            return;
        }
    }
    reply_text(reply, 404, "not found\n");
}

// --- Events --------------------------------------------------------------------------------------

typedef struct Events {
    Session *session;
    SessionNews seen;
    Text pending; // what is to be sent before news are looked at again
    size_t sent;
} Events;

static void add_event(Text *text, const char *name, Text json)
{
    if (!json.failed) {
        text_print(text, "event: %s\ndata: ", name);
        text_write(text, json.bytes, json.length);
        text_print(text, "\n\n");
    }
    text_free(&json);
}

// News are the newest state, never a queue: who reads slowly misses what has passed.
static bool wait_for_events(Events *events)
{
    SessionNews before = events->seen;
    if (!session_wait(events->session, &events->seen, KEEPALIVE_MS)) {
        return false;
    }
    Text *out = &events->pending;
    if (events->seen.scene != before.scene) {
        add_event(out, "scene", session_scene_json(events->session));
    }
    if (events->seen.view != before.view) {
        add_event(out, "view", session_view_json(events->session));
    }
    if (events->seen.status != before.status) {
        add_event(out, "status", session_status_json(events->session));
    }
    if (events->seen.picture != before.picture) {
        text_print(out, "event: picture\ndata: %llu\n\n", (unsigned long long)events->seen.picture);
    }
    if (out->length == 0) {
        text_print(out, ": still here\n\n");
    }
    return !out->failed;
}

static int64_t read_events(void *stream, char *buffer, size_t room)
{
    Events *events = stream;
    if (events->sent == events->pending.length) {
        text_free(&events->pending);
        events->sent = 0;
        if (!wait_for_events(events)) {
            return -1;
        }
    }
    size_t left = events->pending.length - events->sent, part = left < room ? left : room;
    memcpy(buffer, events->pending.bytes + events->sent, part);
    events->sent += part;
    return (int64_t)part;
}

static void end_events(void *stream)
{
    Events *events = stream;
    text_free(&events->pending);
    mem_free(events);
}

static void serve_events(Session *session, HttpReply *reply)
{
    Events *events = mem_alloc_zeroed(1, sizeof *events);
    if (!events) {
        reply_text(reply, 500, "not enough memory\n");
        return;
    }
    events->session = session;
    reply_with(reply, 200, "text/event-stream");
    reply->read = read_events;
    reply->end = end_events;
    reply->stream = events;
}

// All that the stream tells, as it is now.
static void serve_state(Session *session, HttpReply *reply)
{
    Text parts[] = {session_scene_json(session), session_view_json(session),
                    session_status_json(session)};
    Text all = {0};
    text_print(&all, "{\"scene\":%s,\"view\":%s,\"status\":%s}", parts[0].bytes, parts[1].bytes,
               parts[2].bytes);
    for (int i = 0; i < 3; ++i) {
        all.failed |= parts[i].failed;
        text_free(&parts[i]);
    }
    reply_json(reply, all);
}

// --- Pictures ------------------------------------------------------------------------------------

static void serve_picture(Session *session, HttpReply *reply)
{
    SessionLook look;
    Snapshot *picture = session_picture(session, &look);
    if (!picture) {
        reply_text(reply, 404, "there is no picture yet\n");
        return;
    }
    size_t size = (size_t)picture->width * picture->height * 4;
    unsigned char *rgba = mem_alloc(size, 1);
    if (rgba) {
        snapshot_develop(picture, look.exposure, look.tone, rgba);
        reply_with(reply, 200, "application/octet-stream");
        snprintf(reply->text, sizeof reply->text, "%u %u %u %llu", picture->width, picture->height,
                 picture->samples, (unsigned long long)picture->number);
        add_header(reply, "X-Picture", reply->text);
        reply->bytes = reply->owner = rgba;
        reply->size = size;
        reply->release = mem_free;
    } else {
        reply_text(reply, 500, "not enough memory\n");
    }
    snapshot_release(picture);
}

static bool number_argument(const HttpRequest *request, const char *name, double *number)
{
    const char *text = request->argument(request, name);
    char *end;
    if (!text || !*text || strlen(text) > 40) {
        return false;
    }
    *number = strtod(text, &end);
    return *end == '\0' && isfinite(*number);
}

static bool place_argument(const HttpRequest *request, double *x, double *y)
{
    return number_argument(request, "x", x) && number_argument(request, "y", y) && *x >= 0 &&
           *x <= 1 && *y >= 0 && *y <= 1;
}

static void serve_pixel(Session *session, const HttpRequest *request, HttpReply *reply)
{
    double x, y;
    if (!place_argument(request, &x, &y)) {
        reply_text(reply, 400, "x and y are numbers from 0 to 1\n");
        return;
    }
    SessionLook look;
    Snapshot *picture = session_picture(session, &look);
    if (picture) {
        reply_json(reply, inspect_json(picture, x, y));
    } else {
        reply_text(reply, 404, "there is no picture yet\n");
    }
    snapshot_release(picture);
}

static void serve_save(Session *session, const HttpRequest *request, HttpReply *reply)
{
    const char *type = request->argument(request, "type");
    bool exr = type && strcmp(type, "exr") == 0;
    SessionLook look;
    Snapshot *picture = session_picture(session, &look);
    char message[500] = "there is no picture yet";
    FileBytes *bytes =
        picture ? save_picture(picture, look, exr ? "exr" : "png", message, sizeof message) : NULL;
    snapshot_release(picture);
    if (!bytes) {
        reply_done(reply, false, message);
        return;
    }
    reply_with(reply, 200, exr ? "image/x-exr" : "image/png");
    add_header(reply, "Content-Disposition", "attachment");
    reply->bytes = bytes->bytes;
    reply->size = bytes->size;
    reply->owner = bytes;
    reply->release = save_release;
}

// --- Requests that change something --------------------------------------------------------------

typedef struct Action {
    Session *session;
    const HttpRequest *request;
    char message[200];
} Action;

static bool do_set(Action *a)
{
    const char *name = a->request->argument(a->request, "name");
    snprintf(a->message, sizeof a->message, "a param is missing");
    return name && session_set(a->session, name, a->request->argument(a->request, "value"),
                               a->message, sizeof a->message);
}

static bool do_reset(Action *a)
{
    session_reset(a->session);
    return true;
}

static bool do_camera(Action *a)
{
    double number;
    bool named = number_argument(a->request, "number", &number) && number >= 0 && number < 1e9;
    return session_choose_camera(a->session, named ? (uint32_t)number : NONE_ID, a->message,
                                 sizeof a->message);
}

static bool do_move(Action *a)
{
    static const char *const kinds[] = {[MOVE_ORBIT] = "orbit",
                                        [MOVE_PAN] = "pan",
                                        [MOVE_DOLLY] = "dolly",
                                        [MOVE_FOV] = "fov",
                                        [MOVE_APERTURE] = "aperture"};
    const char *kind = a->request->argument(a->request, "kind");
    CameraMove move = {0};
    snprintf(a->message, sizeof a->message, "a move is a kind, x and y");
    if (!kind || !number_argument(a->request, "x", &move.x)) {
        return false;
    }
    number_argument(a->request, "y", &move.y);
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i) {
        if (strcmp(kind, kinds[i]) == 0) {
            move.kind = (CameraMoveKind)i;
            return session_move_camera(a->session, move, a->message, sizeof a->message);
        }
    }
    return false;
}

static bool do_focus(Action *a)
{
    double x, y;
    snprintf(a->message, sizeof a->message, "x and y are numbers from 0 to 1");
    return place_argument(a->request, &x, &y) &&
           session_focus(a->session, x, y, a->message, sizeof a->message);
}

static bool do_look(Action *a)
{
    double exposure = NAN, tone = -1;
    number_argument(a->request, "exposure", &exposure);
    number_argument(a->request, "tone", &tone);
    return session_set_look(a->session, exposure, tone >= 0 && tone < 100 ? (int)tone : -1,
                            a->message, sizeof a->message);
}

static bool do_pause(Action *a)
{
    const char *on = a->request->argument(a->request, "on");
    session_pause(a->session, on && strcmp(on, "1") == 0);
    return true;
}

static const struct {
    const char *name;
    bool (*act)(Action *action);
} actions[] = {{"set", do_set},     {"reset", do_reset}, {"camera", do_camera}, {"move", do_move},
               {"focus", do_focus}, {"look", do_look},   {"pause", do_pause}};

static void serve_action(Session *session, const char *name, const HttpRequest *request,
                         HttpReply *reply)
{
    Action action = {.session = session, .request = request};
    for (size_t i = 0; i < sizeof actions / sizeof actions[0]; ++i) {
        if (strcmp(name, actions[i].name) == 0) {
            bool good = actions[i].act(&action);
            reply_done(reply, good, action.message);
            return;
        }
    }
    reply_text(reply, 404, "not found\n");
}

// --- Who may ask ---------------------------------------------------------------------------------

// "localhost:8000": a name that can't lead to a foreign machine, so that a page of a site whose
// name was made to mean 127.0.0.1 gets nothing. Any port: the address may be forwarded.
static bool is_own_host(const char *host)
{
    static const char *const names[] = {"127.0.0.1", "localhost", "[::1]"};
    for (size_t i = 0; host && i < sizeof names / sizeof names[0]; ++i) {
        size_t length = strlen(names[i]);
        if (strncasecmp(host, names[i], length) == 0) {
            const char *port = host + length;
            return !*port || (*port == ':' && strspn(port + 1, "0123456789") == strlen(port + 1));
        }
    }
    return false;
}

// A browser says where a request that changes something, or one from a script, comes from.
static bool is_own_origin(const HttpRequest *request)
{
    if (request->fetch_site && strcmp(request->fetch_site, "cross-site") == 0 &&
        strcmp(request->method, "GET") != 0) {
        return false;
    }
    const char *origin = request->origin;
    return !origin ||
           (strncmp(origin, "http://", 7) == 0 && strcmp(origin + 7, request->host) == 0);
}

// "/TOKEN/rest" -> "rest"; NULL where the token is wrong. Takes as long for any wrong token.
static const char *after_token(const Server *server, const char *path)
{
    size_t length = strlen(server->token);
    unsigned char difference = path[0] != '/';
    for (size_t i = 0; path[0] && i < length; ++i) {
        if (!path[i + 1]) {
            return NULL;
        }
        difference |= (unsigned char)(path[i + 1] ^ server->token[i]);
    }
    return !path[0] || difference || path[length + 1] != '/' ? NULL : path + length + 2;
}

static void handle(void *context, const HttpRequest *request, HttpReply *reply)
{
    const Server *server = context;
    bool is_get = strcmp(request->method, "GET") == 0, is_post = !strcmp(request->method, "POST");
    const char *name = after_token(server, request->path);
    if (!is_own_host(request->host) || !is_own_origin(request)) {
        reply_text(reply, 403, "refused: the request comes from elsewhere\n");
    } else if (!name) {
        reply_text(reply, 403, "refused: the address is the one that `scnrender watch` printed\n");
    } else if (request->has_body) {
        reply_text(reply, 413, "a request has no body here\n");
    } else if (is_post) {
        serve_action(server->session, name, request, reply);
    } else if (!is_get) {
        reply_text(reply, 405, "GET and POST are known\n");
    } else if (strcmp(name, "events") == 0) {
        serve_events(server->session, reply);
    } else if (strcmp(name, "state") == 0) {
        serve_state(server->session, reply);
    } else if (strcmp(name, "picture") == 0) {
        serve_picture(server->session, reply);
    } else if (strcmp(name, "pixel") == 0) {
        serve_pixel(server->session, request, reply);
    } else if (strcmp(name, "save") == 0) {
        serve_save(server->session, request, reply);
    } else {
        serve_page(name, reply);
    }
}

// --- Beginning and end ---------------------------------------------------------------------------

static bool make_token(char *token)
{
    unsigned char bytes[TOKEN_BYTES];
    if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes) {
        return false;
    }
    for (size_t i = 0; i < sizeof bytes; ++i) {
        snprintf(token + 2 * i, 3, "%02x", bytes[i]);
    }
    return true;
}

Server *server_new(Session *session, uint16_t *port, char *message, size_t message_size)
{
    void *module = module_open("scn_httpd", message, message_size);
    const HttpdFunctions *http = module ? module_symbol(module, HTTPD_MODULE_SYMBOL) : NULL;
    if (!http) {
        return NULL;
    }
    if (http->version != HTTPD_MODULE_VERSION) {
        snprintf(message, message_size, "the module scn_httpd.so is of another version");
        return NULL;
    }
    Server *server = mem_alloc_zeroed(1, sizeof *server);
    if (!server || !make_token(server->token)) {
        snprintf(message, message_size,
                 server ? "no random numbers are to be had" : "not enough memory");
        mem_free(server);
        return NULL;
    }
    server->session = session;
    server->http = http;
    server->daemon = http->start(port, handle, server, message, message_size);
    if (!server->daemon) {
        mem_free(server);
        return NULL;
    }
    snprintf(server->address, sizeof server->address, "http://127.0.0.1:%u/%s/", *port,
             server->token);
    return server;
}

const char *server_address(const Server *server)
{
    return server->address;
}

void server_free(Server *server)
{
    if (server) {
        session_close(server->session);
        server->http->stop(server->daemon);
        mem_free(server);
    }
}
