// Each limit at the number that a scene needs, which is enough, and at one less, which is told of.
//     limits_test PROGRAM FOLDER
#include "program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Case {
    const char *limit;
    uint64_t needed;
    const char *code; // what one less gives
    const char *text;
} Case;

static const Case cases[] = {
    {"nesting", 11, "E0701", "let _a = ((((((((((1))))))))))"},
    {"nesting", 8, "E0701", "group { group { group { sphere {} } } }"}, // two for each
    {"call_depth", 10, "E0703", "fn f(n) = if (n == 0) 0 else f(n - 1)\nassert(f(9) == 0)"},
    {"import_depth", 2, "E0705", "import \"b.scn\" as _b\n"}, // which imports c.scn
    {"file_bytes", 11, "E0601", "let _a = 1\n"},
    {"list_length", 5, "E0706", "assert(len([1, 2, 3, 4, 5]) == 5)"},
    {"list_length", 5, "E0706", "for (i in 0..<5) {}"},
    {"list_length", 5, "E0706", "assert(len(range(5)) == 5)"},
    {"list_length", 6, "E0706", "assert(len(concat([1, 2, 3], [4, 5, 6])) == 6)"},
    {"objects", 3, "E0707", "sphere {} sphere {} sphere {}"},
    {"objects", 5, "E0707", "for (i in 0..<5) { sphere {} }"},
    {"objects", 3, "E0707", "let g = group { sphere {} }\ninstance { of: g } instance { of: g }"},
    {"steps", 50, "E0708", "for (i in 0..<50) {}"},
    {"parts", 5, "E0712",
     "let a = lambert {}\nsphere { material: mix { a: a, b: mix { a: a, b: a } } }"},
    {"pixels", 70, "E0711", "film { width: 10, height: 7 }"},
};

static const char *program, *folder;

static void write_file(const char *name, const char *text)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *out = fopen(path, "w");
    if (!out || fputs(text, out) < 0 || fclose(out) != 0) {
        perror(path);
        exit(2);
    }
}

static void run(const char *limit, uint64_t value, ProgramRun *out)
{
    char setting[100];
    snprintf(setting, sizeof setting, "%s=%llu", limit, (unsigned long long)value);
    const char *command[] = {"check", "scene.scn", "--limit", setting, NULL};
    program_run(program, command, folder, 120, out);
}

static bool check(const Case *one)
{
    ProgramRun enough, less;
    write_file("scene.scn", one->text);
    run(one->limit, one->needed, &enough);
    run(one->limit, one->needed - 1, &less);
    bool good = enough.status == 0 && less.status == 1 && strstr(less.errors, one->code);
    if (!good) {
        printf("%s: status %d at %llu, %d at one less\n%s%s\n%.1000s\n", one->limit, enough.status,
               (unsigned long long)one->needed, less.status, one->text, enough.errors, less.errors);
    }
    return good;
}

// What a scene takes of memory is nothing to write down: the least that is enough is looked for.
static bool check_memory(void)
{
    uint64_t few = 0, many = (uint64_t)1 << 30;
    ProgramRun out;
    write_file("scene.scn",
               "let a = [for (i in 0..<100_000) (i, i, i)]\nassert(len(a) == 100_000)");
    while (many - few > 1) {
        uint64_t middle = few + (many - few) / 2;
        run("memory", middle, &out);
        *(out.status == 0 ? &many : &few) = middle;
    }
    run("memory", many, &out);
    bool good = out.status == 0;
    run("memory", many - 1, &out);
    good = good && out.status == 1 && strstr(out.errors, "E0709") && many > 4 << 20;
    printf("memory: %llu bytes are enough%s\n", (unsigned long long)many, good ? "" : ": wrong");
    return good;
}

static int count(const char *text, const char *word)
{
    int found = 0;
    while ((text = strstr(text, word))) {
        ++found;
        ++text;
    }
    return found;
}

static bool check_diagnostics(void)
{
    ProgramRun enough, less;
    write_file("scene.scn", "let _a = b\nlet _c = d\nlet _e = f\n");
    run("diagnostics", 3, &enough);
    run("diagnostics", 2, &less);
    bool good = count(enough.errors, "error[") == 3 && count(less.errors, "error[") == 2 &&
                !strstr(enough.errors, "more") && strstr(less.errors, "more");
    if (!good) {
        printf("diagnostics: %s%s\n", enough.errors, less.errors);
    }
    return good;
}

int main(int argc, char **argv)
{
    if (argc < 3) {
        fputs("usage: limits_test PROGRAM FOLDER\n", stderr);
        return 2;
    }
    program = argv[1];
    folder = argv[2];
    write_file("b.scn", "import \"c.scn\" as _c\n");
    write_file("c.scn", "let c = 1\n");
    int failed = !check_memory() + !check_diagnostics();
    const int number = sizeof cases / sizeof cases[0];
    for (int i = 0; i < number; ++i) {
        failed += !check(&cases[i]);
    }
    printf("%d limits at N and N - 1, %d wrong\n", number + 2, failed);
    return failed ? 1 : 0;
}
