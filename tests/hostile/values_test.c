// Values where they don't belong: each built-in function with values of every type, each operator
// and statement with every pair, each field of each kind with every one. What is wrong is told of;
// nothing crashes, hangs, or is taken for a picture.
//     values_test PROGRAM FOLDER [N]    N: each Nth scene only
#include "program.h"

#include "render/render.h"
#include "schema/schema.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const values[] = {"true",
                                     "1",
                                     "-2.5",
                                     "1e300",
                                     "90deg",
                                     "3m",
                                     "5W",
                                     "2s",
                                     "\"text\"",
                                     "\"\"",
                                     "(1, 2)",
                                     "(1, 2, 3)",
                                     "(1m, 2m, 3m)",
                                     "(1, 2, 3, 4)",
                                     "rgb(1, 0.5, 0)",
                                     "[1, 2]",
                                     "[]",
                                     "[(1, 2, 3), (4, 5, 6)]",
                                     "[[0, 1, 2]]",
                                     "[\"a\", \"b\"]",
                                     "[sphere {}]",
                                     "[rgb(1, 1, 1), 1]",
                                     "0..<3",
                                     "fn(x) = x",
                                     "fn(x, y) = x",
                                     "sphere {}",
                                     "group { sphere {} }",
                                     "lambert {}",
                                     "checker {}",
                                     "translate(1, 2, 3)",
                                     "bounds(sphere {})",
                                     "print(\"\")",
                                     "radiance()",
                                     "picture()",
                                     "sin",
                                     "point_light { position: (1, 1, 1) }"};
enum { VALUES = sizeof values / sizeof values[0] };

static const char *const functions[] = {
#define BUILTIN(name, least, most, signature, doc) #name,
#include "lang/builtins.def"
};
enum { FUNCTIONS = sizeof functions / sizeof functions[0] };

// Statements with two values, and an operator between them or what is like one.
static const char *const pairs[] = {"let _v = %s + %s",
                                    "let _v = %s - %s",
                                    "let _v = %s * %s",
                                    "let _v = %s / %s",
                                    "let _v = %s %% %s",
                                    "let _v = %s ^ %s",
                                    "let _v = %s == %s",
                                    "let _v = %s != %s",
                                    "let _v = %s < %s",
                                    "let _v = %s >= %s",
                                    "let _v = %s and %s",
                                    "let _v = %s or %s",
                                    "let _v = %s[%s]",
                                    "let _v = %s%s",
                                    "let _v = %s ..< %s",
                                    "let _v = %s .. %s",
                                    "let _v = %s with { radius: %s }",
                                    "expect %s == %s",
                                    "expect %s < %s",
                                    "expect %s within 1%% of %s",
                                    "expect 1 within %s of %s",
                                    "let _v = [%s, %s]",
                                    "let _v = (%s, %s)",
                                    "let _v = if %s 1 else %s",
                                    "for (i in %s) { let _w = %s }",
                                    "let _v = [for (i in %s) %s]",
                                    "assert(%s, %s)",
                                    "param p: number = %s in 1..%s"};
enum { PAIRS = sizeof pairs / sizeof pairs[0] };
static const char *const singles[] = {"let _v = -%s",
                                      "let _v = not %s",
                                      "let _v = %s.x",
                                      "let _v = %s.r",
                                      "let _v = %s.min",
                                      "let _v = %s.zyx",
                                      "let _v = %s.nothing",
                                      "%s",
                                      "expect %s",
                                      "group { items: %s }",
                                      "instance { of: %s }",
                                      "if %s { sphere {} }",
                                      "param p: int = %s",
                                      "param p: color = %s",
                                      "param p: string = %s",
                                      "param p: bool = %s",
                                      "param p: number = %s",
                                      "param p: vector = %s",
                                      "import %s as _m",
                                      "sphere { transform: %s }",
                                      "sphere { transform: [%s, scale(2)] }",
                                      "sphere { material: %s }",
                                      "point_light { color: %s position: (1, 1, 1) }"};
enum { SINGLES = sizeof singles / sizeof singles[0] };

// --- Scenes --------------------------------------------------------------------------------------

static const char *program, *folder;
static FILE *scene;
static int scenes, statements, failed;
static Worst worst;
// Which scenes are run.
static int given_count;
static char **given;
static unsigned number;

static void begin_scene(void)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/scene.scn", folder);
    scene = fopen(path, "w");
    if (!scene) {
        perror(path);
        exit(2);
    }
}

// A statement, or more of one.
__attribute__((format(printf, 1, 2))) static void state(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vfprintf(scene, format, arguments);
    va_end(arguments);
    fputc('\n', scene);
    ++statements;
}

static void end_scene(const char *what)
{
    static const char *const command[] = {"check",   "scene.scn",          "-q",
                                          "--limit", "diagnostics=100000", NULL};
    ProgramRun run;
    if (fclose(scene) != 0) {
        perror("scene.scn");
        exit(2);
    }
    program_run(program, command, folder, 300, &run);
    if (run.status != 0 && run.status != 1) {
        printf("%s: status %d\n%.500s\n", what, run.status, run.errors);
        ++failed;
    }
    worst_take(&worst, &run, what);
    ++scenes;
}

static bool is_taken(void)
{
    return program_takes(given_count, given, number++);
}

static void try_function(const char *name)
{
    enum { MORE = 300 };
    uint64_t random = 1;
    begin_scene();
    state("let _v = %s()", name);
    state("let _f = %s", name);
    for (int i = 0; i < VALUES; ++i) {
        state("let _%d = %s(%s)", i, name, values[i]);
        for (int k = 0; k < VALUES; ++k) {
            state("let _%d_%d = %s(%s, %s)", i, k, name, values[i], values[k]);
        }
    }
    for (int i = 0; i < MORE; ++i) {
        const char *a = values[program_random(&random) % VALUES],
                   *b = values[program_random(&random) % VALUES];
        state("let _m%d = %s(%s, %s, %s)", i, name, a, i % 2 ? b : a,
              values[program_random(&random) % VALUES]);
        state("let _n%d = %s(%s, %s, %s, %s)", i, name, a, b, i % 2 ? b : a,
              values[program_random(&random) % VALUES]);
    }
    end_scene(name);
}

// Names that are declared twice are errors that hide others: `_v` becomes one of its own.
static void state_anew(const char *format, const char *a, const char *b)
{
    static unsigned times;
    char text[1024], left[200], right[200];
    snprintf(left, sizeof left, "(%s)", a); // `fn` and others reach as far as they can
    snprintf(right, sizeof right, "(%s)", b);
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
    snprintf(text, sizeof text, format, left, right);
#pragma GCC diagnostic pop
    char *name = strstr(text, "_v");
    char *param = strstr(text, "param p:");
    ++times;
    if (name) {
        state("%.*s_v%u%s", (int)(name - text), text, times, name + 2);
    } else if (param == text) {
        state("param p%u:%s", times, text + strlen("param p:"));
    } else {
        state("%s", text);
    }
}

static void try_statements(void)
{
    for (int p = 0; p < PAIRS; ++p) {
        if (!is_taken()) {
            continue;
        }
        begin_scene();
        for (int i = 0; i < VALUES; ++i) {
            for (int k = 0; k < VALUES; ++k) {
                state_anew(pairs[p], values[i], values[k]);
            }
        }
        end_scene(pairs[p]);
    }
    for (int s = 0; s < SINGLES; ++s) {
        if (!is_taken()) {
            continue;
        }
        begin_scene();
        for (int i = 0; i < VALUES; ++i) {
            state_anew(singles[s], values[i], "");
        }
        end_scene(singles[s]);
    }
}

static void try_kind(const NodeType *type)
{
    begin_scene();
    for (size_t i = 0; i < type->param_count; ++i) {
        for (int k = 0; k < VALUES; ++k) {
            state("%s { %s: %s }", type->name, type->params[i].name, values[k]);
            state("let _%zu_%d = %s { %s: %s }", i, k, type->name, type->params[i].name, values[k]);
        }
    }
    end_scene(type->name);
}

int main(int argc, char **argv)
{
    if (argc < 3) {
        fputs("usage: values_test PROGRAM FOLDER\n", stderr);
        return 2;
    }
    program = argv[1];
    folder = argv[2];
    given_count = argc;
    given = argv;
    for (int i = 0; i < FUNCTIONS; ++i) {
        if (is_taken()) {
            try_function(functions[i]);
        }
    }
    try_statements();
    const Schema *schema = render_schema();
    for (uint32_t i = 0; i < schema->type_count; ++i) {
        if (is_taken()) {
            try_kind(schema->types[i]);
        }
    }
    printf("%d statements in %d scenes, %d scenes ended badly; the slowest took %.2f s of the "
           "processor\n",
           statements, scenes, failed, worst.seconds);
    return failed ? 1 : 0;
}
