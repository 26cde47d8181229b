// The evaluation of a document in a process of its own: it may take long, and need memory that is
// best given back at once; ended at the next key, it leaves nothing behind.
#include "lsp/server.h"

#include "base/clock.h"
#include "base/mem.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

enum { KILL_AFTER = 3 }; // seconds, where asking to stop doesn't help

// --- In the process ------------------------------------------------------------------------------

// Nothing that runs here may write to the client or take its messages.
static void leave_client(void)
{
    int nowhere = open("/dev/null", O_RDWR);
    if (nowhere >= 0) {
        dup2(nowhere, STDIN_FILENO);
        dup2(nowhere, STDOUT_FILENO);
    }
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    setpriority(PRIO_PROCESS, 0, 5);
}

static void write_report(const Report *report, int to)
{
    cJSON *json = report_to_json(report);
    char *text = json ? cJSON_PrintUnformatted(json) : NULL;
    size_t length = text ? strlen(text) : 0;
    for (size_t at = 0; at < length;) {
        ssize_t size = write(to, text + at, length - at);
        if (size < 0 && errno != EINTR) {
            break;
        }
        at += size > 0 ? (size_t)size : 0;
    }
}

// A limit that is the server's own, or that time ran out, is no mistake of the scene.
static bool is_own_limit(const ReportItem *item, const Limits *limits)
{
    Limits standard = limits_default();
    return (item->code == E0708 && limits->steps < standard.steps) ||
           (item->code == E0707 && limits->objects < standard.objects) ||
           (item->code == E0709 && limits->memory < standard.memory);
}

_Noreturn static void evaluate(Server *server, const Document *document, int to, atomic_int *stop)
{
    leave_client();
    Sandbox sandbox;
    Lang lang;
    Scene scene;
    Observations observed = {0};
    Report report = {0};
    document_sandbox(server, document, &sandbox);
    document_lang(server, &lang, &sandbox);
    lang.stop = stop;
    lang.observed = &observed;
    if (scene_init(&scene, server->host->schema, &sandbox)) {
        bool good = lang_load(&lang, document->real, document->path, &scene);
        if (good && server->host->check && !atomic_load(stop)) {
            server->host->check(&scene, &lang.sink);
        }
        report_take(&report, &lang, &observed);
        size_t kept = 0;
        for (size_t i = 0; i < report.items.count; ++i) {
            if (!is_own_limit(&report.items.items[i], &lang.limits)) {
                report.items.items[kept++] = report.items.items[i];
            }
        }
        report.items.count = kept;
        write_report(&report, to);
    }
    _exit(0);
}

// --- In the server -------------------------------------------------------------------------------

// The flag that asks the process to stop.
static bool share_flag(Evaluation *evaluation)
{
    if (!evaluation->stop) {
        void *page = mmap(NULL, sizeof *evaluation->stop, PROT_READ | PROT_WRITE,
                          MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        evaluation->stop = page == MAP_FAILED ? NULL : page;
    }
    if (evaluation->stop) {
        atomic_store(evaluation->stop, 0);
    }
    return evaluation->stop != NULL;
}

void evaluation_start(Server *server, Document *document)
{
    Evaluation *evaluation = &server->evaluation;
    evaluation_cancel(server);
    int ends[2];
    if (!document_analysis(server, document) || !share_flag(evaluation) ||
        pipe2(ends, O_CLOEXEC) != 0) {
        return;
    }
    pid_t process = fork();
    if (process == 0) {
        close(ends[0]);
        evaluate(server, document, ends[1], evaluation->stop);
    }
    close(ends[1]);
    if (process < 0) {
        close(ends[0]);
        return;
    }
    double now = clock_seconds();
    evaluation->document = document;
    evaluation->process = process;
    evaluation->from = ends[0];
    evaluation->bytes.count = 0;
    evaluation->stop_at = now + server->settings.seconds;
    evaluation->kill_at = evaluation->stop_at + KILL_AFTER;
}

static void end_process(Evaluation *evaluation)
{
    close(evaluation->from);
    kill(evaluation->process, SIGKILL);
    while (waitpid(evaluation->process, NULL, 0) < 0 && errno == EINTR) {
    }
    evaluation->document = NULL;
}

// What was said of other open files is said anew.
static void tell_others(Server *server, const Report *report)
{
    for (size_t i = 0; i < report->items.count; ++i) {
        Document *other = document_by_path(server, report->items.items[i].at.path);
        if (other) {
            other->is_told = false;
        }
    }
}

// What the survey says itself, and says anew with each key, is left out.
static void keep_new(Document *document)
{
    size_t kept = 0;
    for (size_t i = 0; i < document->found.items.count; ++i) {
        ReportItem item = document->found.items.items[i];
        if (!report_has(&document->said, &item)) {
            document->found.items.items[kept++] = item;
        }
    }
    document->found.items.count = kept;
}

static void take_report(Server *server, Document *document, Str bytes)
{
    cJSON *json = cJSON_ParseWithLength(bytes.at, bytes.length);
    Report report = {0};
    if (json && report_from_json(&report, json)) {
        tell_others(server, &document->found);
        report_free(&document->found);
        document->found = report;
        document_analysis(server, document);
        document_excuse(document, &document->found);
        keep_new(document);
        tell_others(server, &document->found);
        document->is_told = false;
    } else { // it died, or was killed: what was found before stays
        report_free(&report);
        server_log(server, "the evaluation of a scene was given up");
    }
    cJSON_Delete(json);
}

void evaluation_read(Server *server)
{
    enum { ROOM = 64 << 10 };
    Evaluation *evaluation = &server->evaluation;
    if (!array_reserve(&evaluation->bytes, ROOM)) {
        evaluation_cancel(server);
        return;
    }
    ssize_t size = read(evaluation->from, evaluation->bytes.items + evaluation->bytes.count, ROOM);
    if (size > 0) {
        evaluation->bytes.count += (size_t)size;
    } else if (size == 0) {
        Document *document = evaluation->document;
        end_process(evaluation);
        take_report(server, document, (Str){evaluation->bytes.items, evaluation->bytes.count});
    } else if (errno != EINTR && errno != EAGAIN) {
        evaluation_cancel(server);
    }
}

void evaluation_watch(Server *server, double now)
{
    Evaluation *evaluation = &server->evaluation;
    if (!evaluation->document) {
        return;
    }
    if (now >= evaluation->kill_at) {
        evaluation_cancel(server);
        server_log(server, "the evaluation of a scene took too long and was given up");
    } else if (now >= evaluation->stop_at) {
        atomic_store(evaluation->stop, 1);
    }
}

void evaluation_cancel(Server *server)
{
    if (server->evaluation.document) {
        end_process(&server->evaluation);
    }
}

void evaluation_free(Server *server)
{
    evaluation_cancel(server);
    array_free(&server->evaluation.bytes);
    if (server->evaluation.stop) {
        munmap(server->evaluation.stop, sizeof *server->evaluation.stop);
        server->evaluation.stop = NULL;
    }
}
