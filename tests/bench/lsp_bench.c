// How long the language server takes for a key: a scene of many lines is opened, and characters are
// typed into its middle, each followed by what editors ask for.
//
// usage: lsp_bench SCNRENDER [LINES] [KEYS]
//
// Times are from writing the message to having read the answer: for a key, until its diagnostics
// have arrived. --check M: only the keys; exit with 1 where one takes more than M milliseconds of
// the processor (which other work on the machine doesn't change).
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

typedef struct Peer {
    int to, from;
    pid_t process;
    char *bytes; // received
    size_t count, capacity;
} Peer;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static void die(const char *what)
{
    fprintf(stderr, "lsp_bench: %s: %s\n", what, strerror(errno));
    exit(1);
}

static void start(Peer *peer, const char *program)
{
    int in[2], out[2];
    if (pipe(in) != 0 || pipe(out) != 0) {
        die("pipe");
    }
    peer->process = fork();
    if (peer->process == 0) {
        dup2(in[0], STDIN_FILENO);
        dup2(out[1], STDOUT_FILENO);
        close(in[1]);
        close(out[0]);
        execl(program, program, "lsp", (char *)NULL);
        _exit(127);
    }
    close(in[0]);
    close(out[1]);
    peer->to = in[1];
    peer->from = out[0];
}

static void write_all(const Peer *peer, const char *bytes, size_t length)
{
    while (length > 0) {
        ssize_t size = write(peer->to, bytes, length);
        if (size < 0) {
            die("write");
        }
        bytes += size;
        length -= (size_t)size;
    }
}

static void send_body(const Peer *peer, const char *body, size_t length)
{
    char header[64];
    int size = snprintf(header, sizeof header, "Content-Length: %zu\r\n\r\n", length);
    write_all(peer, header, (size_t)size);
    write_all(peer, body, length);
}

__attribute__((format(printf, 2, 3))) static void send_text(const Peer *peer, const char *format,
                                                            ...)
{
    static char body[1 << 16];
    va_list arguments;
    va_start(arguments, format);
    int size = vsnprintf(body, sizeof body, format, arguments);
    va_end(arguments);
    send_body(peer, body, (size_t)size);
}

// Takes the next message; its text is NUL-terminated and good until the next call.
static char *receive(Peer *peer, size_t *length)
{
    static size_t taken;
    if (taken > 0) {
        memmove(peer->bytes, peer->bytes + taken, peer->count - taken);
        peer->count -= taken;
        taken = 0;
    }
    for (;;) {
        char *stop = peer->count ? memmem(peer->bytes, peer->count, "\r\n\r\n", 4) : NULL;
        if (stop) {
            size_t head = (size_t)(stop + 4 - peer->bytes);
            size_t size = strtoul(peer->bytes + 16, NULL, 10);
            if (peer->count >= head + size) {
                taken = head + size;
                *length = size;
                return peer->bytes + head;
            }
        }
        if (peer->capacity - peer->count < 1 << 16) {
            peer->capacity = peer->capacity * 2 + (1 << 17);
            peer->bytes = realloc(peer->bytes, peer->capacity);
            if (!peer->bytes) {
                die("realloc");
            }
        }
        ssize_t size =
            read(peer->from, peer->bytes + peer->count, peer->capacity - peer->count - 1);
        if (size <= 0) {
            die("the server is gone");
        }
        peer->count += (size_t)size;
    }
}

// Reads messages until one holds `text`; returns its length.
static size_t await(Peer *peer, const char *text)
{
    for (;;) {
        size_t length;
        char *message = receive(peer, &length);
        if (memmem(message, length, text, strlen(text))) {
            return length;
        }
    }
}

// --- The scene -----------------------------------------------------------------------------------

// A line of it; those of all kinds that a scene has.
static int scene_line(char *out, size_t size, int i)
{
    switch (i % 10) {
    case 0:
        return snprintf(out, size, "let paint_%d = lambert { color: #%06x }", i,
                        (unsigned)i * 2654435761u & 0xffffffu);
    case 1:
        return snprintf(out, size, "let width_%d = %d.%dcm + 2 * 1mm  // a comment", i, i % 97,
                        i % 7);
    case 2:
        return snprintf(out, size, "fn ball_%d(at, r = 5cm) = sphere { center: at, radius: r }", i);
    case 3:
        return snprintf(out, size,
                        "sphere { center: (%d, 0.5, -%d), radius: width_%d, material: paint_%d }",
                        i, i, i - 2, i - 3);
    case 4:
        return snprintf(out, size, "ball_%d((%d, 1, 2), r: width_%d)", i - 2, i, i - 3);
    case 5:
        return snprintf(out, size, "group { transform: [scale(2), translate(%d, 0, 0)]", i);
    case 6:
        return snprintf(out, size, "  for (i in 0..<3) { ball_%d((i, 0, 0)) }", i - 4);
    case 7:
        return snprintf(out, size, "}");
    case 8:
        return snprintf(
            out, size,
            "point_light { position: (0, %d, 0), power: %dlm, color: rgb(1, 0.%d, 0.2) }", i,
            100 + i % 900, i % 9);
    default:
        return snprintf(out, size,
                        "box { min: (%d, 0, 0), max: (%d, 1, width_%d), material: paint_%d }", i,
                        i + 1, i - 8, i - 9);
    }
}

static char *open_message(int lines, size_t *length)
{
    size_t capacity = (size_t)lines * 120 + 1024;
    char *message = malloc(capacity);
    if (!message) {
        die("malloc");
    }
    size_t at = (size_t)snprintf(
        message, capacity,
        "{\"jsonrpc\":\"2.0\",\"method\":\"textDocument/didOpen\",\"params\":{\"textDocument\":{"
        "\"uri\":\"file:///tmp/bench.scn\",\"languageId\":\"scn\",\"version\":1,\"text\":\"");
    for (int i = 0; i < lines; ++i) {
        at += (size_t)scene_line(message + at, capacity - at, i);
        at += (size_t)snprintf(message + at, capacity - at, "\\n");
    }
    at += (size_t)snprintf(message + at, capacity - at, "\"}}}");
    *length = at;
    return message;
}

// Processor time of a process so far, in milliseconds: what other work on the machine leaves alone.
static double processor_time(pid_t process)
{
    char path[64], text[1024];
    snprintf(path, sizeof path, "/proc/%d/stat", (int)process);
    FILE *file = fopen(path, "r");
    size_t size = file ? fread(text, 1, sizeof text - 1, file) : 0;
    if (file) {
        fclose(file);
    }
    text[size] = '\0';
    unsigned long user = 0, system = 0;
    const char *rest = strrchr(text, ')');
    if (rest) {
        sscanf(rest, ") %*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %lu %lu", &user, &system);
    }
    return (double)(user + system) * 1e3 / (double)sysconf(_SC_CLK_TCK);
}

// --- Times ---------------------------------------------------------------------------------------

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double report(const char *what, double *times, int count, size_t bytes)
{
    qsort(times, (size_t)count, sizeof *times, compare);
    printf("%-34s median %7.2f ms   95 %% %7.2f   most %7.2f", what, times[count / 2],
           times[count * 95 / 100], times[count - 1]);
    printf(bytes ? "   %zu bytes\n" : "\n", bytes);
    return times[count / 2];
}

typedef struct Question {
    const char *method, *params;
} Question;

static const Question questions[] = {
    {"textDocument/completion", ""},
    {"textDocument/hover", ""},
    {"textDocument/signatureHelp", ""},
    {"textDocument/semanticTokens/full/delta", ",\"previousResultId\":\"1\""},
    {"textDocument/documentSymbol", ""},
    {"textDocument/foldingRange", ""},
    {"textDocument/documentColor", ""},
    {"textDocument/documentLink", ""},
    {"textDocument/formatting", ",\"options\":{}"},
    {"textDocument/codeAction", ",\"context\":{\"diagnostics\":[]}"},
    {"textDocument/inlayHint", ""},
};

enum { MOST_KEYS = 10000 };

static double type_keys(Peer *peer, int lines, int keys, double *times)
{
    double before = processor_time(peer->process);
    static const char word[] = "sphere { center: (0, 1, 2), radius: 4cm }";
    for (int i = 0; i < keys; ++i) {
        int column = i % (int)(sizeof word - 1);
        char version[32];
        snprintf(version, sizeof version, "\"version\":%d,", i + 2);
        double begin = now();
        send_text(
            peer,
            "{\"jsonrpc\":\"2.0\",\"method\":\"textDocument/didChange\",\"params\":{"
            "\"textDocument\":{\"uri\":\"file:///tmp/bench.scn\",\"version\":%d},"
            "\"contentChanges\":[{\"range\":{\"start\":{\"line\":%d,\"character\":%d},\"end\":{"
            "\"line\":%d,\"character\":%d}},\"text\":\"%c\"}]}}",
            i + 2, lines / 20 * 10, column, lines / 20 * 10, column, word[column]);
        await(peer, version);
        times[i] = now() - begin;
        if (column == (int)sizeof word - 2) { // a line is full
            send_text(peer,
                      "{\"jsonrpc\":\"2.0\",\"method\":\"textDocument/didChange\",\"params\":{"
                      "\"textDocument\":{\"uri\":\"file:///tmp/bench.scn\",\"version\":%d},"
                      "\"contentChanges\":[{\"range\":{\"start\":{\"line\":%d,\"character\":0},"
                      "\"end\":{\"line\":%d,\"character\":0}},\"text\":\"\\n\"}]}}",
                      i + 2, lines / 20 * 10, lines / 20 * 10);
        }
    }
    double spent = processor_time(peer->process) - before;
    report("a key, until its diagnostics", times, keys, 0);
    printf("%-34s mean   %7.2f ms of the processor\n", "", spent / keys);
    return spent / keys;
}

static void ask(Peer *peer, int lines, const Question *question, double *times)
{
    enum { TIMES = 9 };
    size_t bytes = 0;
    static int id = 100;
    for (int i = 0; i < TIMES; ++i) {
        char answer[32];
        int line = lines / 2;
        // Each answer is made for a text that has just changed.
        send_text(
            peer,
            "{\"jsonrpc\":\"2.0\",\"method\":\"textDocument/didChange\",\"params\":{"
            "\"textDocument\":{\"uri\":\"file:///tmp/bench.scn\",\"version\":%d},"
            "\"contentChanges\":[{\"range\":{\"start\":{\"line\":%d,\"character\":0},\"end\":{"
            "\"line\":%d,\"character\":0}},\"text\":\" \"}]}}",
            MOST_KEYS + ++id, line, line);
        snprintf(answer, sizeof answer, "\"id\":%d,", id);
        double begin = now();
        send_text(peer,
                  "{\"jsonrpc\":\"2.0\",\"id\":%d,\"method\":\"%s\",\"params\":{\"textDocument\":{"
                  "\"uri\":\"file:///tmp/bench.scn\"},\"position\":{\"line\":%d,\"character\":9},"
                  "\"range\":{\"start\":{\"line\":%d,\"character\":0},\"end\":{\"line\":%d,"
                  "\"character\":0}}%s}}",
                  id, question->method, line, line, line + 50, question->params);
        bytes = await(peer, answer);
        times[i] = now() - begin;
    }
    report(question->method, times, TIMES, bytes);
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        fprintf(stderr, "usage: lsp_bench SCNRENDER [LINES] [KEYS] [--check MILLISECONDS]\n");
        return 2;
    }
    double most = argc > 3 && strcmp(argv[argc - 2], "--check") == 0 ? atof(argv[argc - 1]) : 0;
    argc -= most > 0 ? 2 : 0;
    int lines = argc > 2 ? atoi(argv[2]) : 10000, keys = argc > 3 ? atoi(argv[3]) : 200;
    keys = keys < 1 ? 1 : keys > MOST_KEYS ? MOST_KEYS : keys;
    static double times[MOST_KEYS];
    Peer peer = {0};
    start(&peer, argv[1]);
    send_text(&peer, "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"initialize\",\"params\":{"
                     "\"capabilities\":{\"textDocument\":{\"documentSymbol\":{"
                     "\"hierarchicalDocumentSymbolSupport\":true}}}}}");
    await(&peer, "\"id\":1,");
    send_text(&peer, "{\"jsonrpc\":\"2.0\",\"method\":\"initialized\",\"params\":{}}");
    size_t length;
    char *open = open_message(lines, &length);
    printf("%d lines, %zu bytes\n", lines, length);
    double begin = now();
    send_body(&peer, open, length);
    await(&peer, "\"version\":1,");
    times[0] = now() - begin;
    report("opening, until its diagnostics", times, 1, 0);
    double key = type_keys(&peer, lines, keys, times);
    send_text(&peer,
              "{\"jsonrpc\":\"2.0\",\"id\":2,\"method\":\"textDocument/semanticTokens/full\","
              "\"params\":{\"textDocument\":{\"uri\":\"file:///tmp/bench.scn\"}}}");
    await(&peer, "\"id\":2,");
    for (size_t i = 0; most <= 0 && i < sizeof questions / sizeof *questions; ++i) {
        ask(&peer, lines, &questions[i], times);
    }
    send_text(&peer, "{\"jsonrpc\":\"2.0\",\"id\":3,\"method\":\"shutdown\"}");
    await(&peer, "\"id\":3,");
    send_text(&peer, "{\"jsonrpc\":\"2.0\",\"method\":\"exit\"}");
    waitpid(peer.process, NULL, 0);
    free(open);
    free(peer.bytes);
    if (most > 0 && key > most) {
        printf("a key takes more than %.0f ms\n", most);
        return 1;
    }
    return 0;
}
