// The whole program while the system fails it: every allocation, thread, file to be opened, read,
// write, flush, rename in turn, once and from there on. Each run ends with a documented status and
// a message, gives all its memory back, leaves the old picture or the right new one, and nothing
// else.
//     faults_test PROGRAM FOLDER ALLOCATIONS [MOST]
// FOLDER: where the scenes are written; ALLOCATIONS: the library of allocations.c, or "" to go
// without; MOST: runs for each command and kind of failure, spread over all
// calls of the kind (0: all of them).
#include "faults.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MOST_BYTES = 1 << 20, MOST_WORDS = 12 };

typedef struct Bytes {
    char at[MOST_BYTES];
    size_t size;
} Bytes;

typedef struct Command {
    const char *name;
    const char *words[MOST_WORDS];
    const char *output; // NULL: none
} Command;

static const Command commands[] = {
    {"render",
     {"scene.scn", "-q", "-o", "out.png", "--threads", "2", "--checkpoint", "part"},
     "out.png"},
    {"render an EXR", {"scene.scn", "-q", "-o", "out.exr", "--threads", "2"}, "out.exr"},
    {"check", {"check", "scene.scn"}, NULL},
    {"dump", {"--dump", "scene", "scene.scn"}, NULL},
    {"test", {"test", "scene.scn", "--samples", "8192"}, NULL},
    {"fmt", {"fmt", "scene.scn"}, "scene.scn"},
    {"export", {"export", "scene.scn", "-q", "--to", "povray", "-o", "out.pov"}, "out.pov"},
    {"export for Blender",
     {"export", "scene.scn", "-q", "--to", "blender", "-o", "out.py"},
     "out.py"},
};

static const struct {
    FaultKind kind;
    const char *name;
    unsigned statuses; // bits: which are right
} kinds[] = {
    {FAULT_ALLOCATION, "allocations", 1 << 0 | 1 << 1 | 1 << 3 | 1 << 4},
    {FAULT_PAGES, "mappings", 1 << 0 | 1 << 1 | 1 << 3 | 1 << 4},
    {FAULT_THREAD, "threads", 1 << 0 | 1 << 3 | 1 << 4},
    {FAULT_OPEN, "opened files", 1 << 0 | 1 << 1 | 1 << 3 | 1 << 4},
    {FAULT_READ, "reads", 1 << 0 | 1 << 1 | 1 << 3},
    {FAULT_WRITE, "writes", 1 << 0 | 1 << 3},
    {FAULT_FLUSH, "flushes", 1 << 0 | 1 << 3},
    {FAULT_RENAME, "renames", 1 << 3},
    {FAULT_LINK, "links", 1 << 0 | 1 << 3},
    {FAULT_CLOSE, "closes", 1 << 0 | 1 << 3},
};

static const char scene[] = "import \"part.scn\" as part\n"
                            "film {\nwidth: 16,\nheight: 16 }\n"
                            "render { samples: 4 }\n"
                            "camera { position: (0, 0, 5), look_at: (0, 0, 0) }\n"
                            "sphere { material: part.painted }\n"
                            "mesh { file: \"three.ply\" }\n"
                            "point_light { position: (3, 3, 3), power: 100W }\n"
                            "for (i in 0..<3) { box { min: (i, 2, 0), max: (i + 0.5, 2.5, 1) } }\n"
                            "expect radiance() < rgb(100, 100, 100)\n";
static const char part[] = "let painted = lambert { color: image { file: \"t.png\" } }\n";
static const char mesh[] = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                           "property float y\nproperty float z\nelement face 1\n"
                           "property list uchar int vertex_indices\nend_header\n"
                           "-2 -1 0\n-1 -1 0\n-2 0 0\n3 0 1 2\n";
static const char old[] = "what was there before\n";

// --- Files ---------------------------------------------------------------------------------------

static const char *folder;

static FILE *open_in_folder(const char *name, const char *mode)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return fopen(path, mode);
}

static void put(const char *name, const char *text, size_t size)
{
    FILE *out = open_in_folder(name, "wb");
    if (!out || fwrite(text, 1, size, out) != size || fclose(out) != 0) {
        perror(name);
        exit(2);
    }
}

static bool get(const char *name, Bytes *out)
{
    FILE *in = open_in_folder(name, "rb");
    out->size = in ? fread(out->at, 1, MOST_BYTES, in) : 0;
    return in && fclose(in) == 0;
}

static bool is_known(const char *name, const Command *command)
{
    static const char *const known[] = {".",         "..",    "scene.scn", "part.scn",
                                        "three.ply", "t.png", "part"};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; ++i) {
        if (strcmp(name, known[i]) == 0) {
            return true;
        }
    }
    return command->output && strcmp(name, command->output) == 0;
}

// Removes what doesn't belong here; the name of one such file in *stray.
static bool clean(const Command *command, char *stray, size_t size)
{
    DIR *files = opendir(folder);
    bool good = files;
    for (struct dirent *file; files && (file = readdir(files));) {
        if (!is_known(file->d_name, command)) {
            char path[4096];
            snprintf(path, sizeof path, "%s/%s", folder, file->d_name);
            unlink(path);
            snprintf(stray, size, "%s", file->d_name);
            good = false;
        }
    }
    if (files) {
        closedir(files);
    }
    return good;
}

static void set_up(const Command *command)
{
    char path[4096];
    put("scene.scn", scene, sizeof scene - 1);
    snprintf(path, sizeof path, "%s/part", folder);
    unlink(path);
    if (command->output && strcmp(command->output, "scene.scn") != 0) {
        put(command->output, old, sizeof old - 1);
    }
}

// --- Runs ----------------------------------------------------------------------------------------

static Bytes right, found;
static const char *list[MOST_WORDS + 2];

static const char *judge(const Command *command, FaultKind kind, unsigned statuses,
                         const FaultRun *run)
{
    static char why[600];
    char stray[300];
    if (!clean(command, stray, sizeof stray)) {
        snprintf(why, sizeof why, "it left `%s`", stray);
        return why;
    }
    // Libraries in C++ that get no memory at all may end the program: not ours to mend. What lies
    // in the folder must be right all the same.
    bool ended = kind == FAULT_PAGES && strstr(run->errors, "'std::bad_alloc'");
    if (!ended && (run->status < 0 || run->status > 4 || !(statuses >> run->status & 1))) {
        return "a status that isn't right";
    }
    if (run->status != 0 && !run->errors[0]) {
        return "no message";
    }
    if (run->live > 0) {
        snprintf(why, sizeof why, "%lld blocks were never given back", (long long)run->live);
        return why;
    }
    // A checkpoint that can't be written is told of after the picture has been written.
    const bool either = run->status == 3 && strstr(run->errors, "`part`");
    if (command->output) {
        const bool is_source = strcmp(command->output, "scene.scn") == 0;
        const char *before = is_source ? scene : old;
        if (!get(command->output, &found)) {
            return "the old output is gone";
        }
        bool is_old = found.size == strlen(before) && memcmp(found.at, before, found.size) == 0;
        bool is_new = found.size == right.size && memcmp(found.at, right.at, found.size) == 0;
        if ((run->status == 0 ? !is_new : !is_old) && !(either && is_new)) {
            return run->status == 0 ? "not the right output" : "the old output has changed";
        }
    }
    return NULL;
}

typedef struct Tally {
    uint64_t runs, failures, tolerated;
} Tally;

static void one(const Command *command, size_t k, uint64_t at, bool goes_on, Tally *tally)
{
    FaultRun run;
    set_up(command);
    fault_run(list, folder, kinds[k].kind, at, goes_on, &run);
    const char *why = judge(command, kinds[k].kind, kinds[k].statuses, &run);
    ++tally->runs;
    tally->tolerated += run.status == 0;
    if (why) {
        ++tally->failures;
        printf("%s, number %llu of the %s%s: %s (status %d)\n%.400s\n", command->name,
               (unsigned long long)at, kinds[k].name, goes_on ? " and all later ones" : "", why,
               run.status, run.errors);
    }
}

static bool begin_command(const Command *command, const char *program)
{
    FaultRun run;
    list[0] = program;
    memcpy(list + 1, command->words, sizeof command->words);
    char stray[300];
    clean(command, stray, sizeof stray);
    set_up(command);
    fault_run(list, folder, FAULT_NONE, 0, false, &run);
    if (run.status != 0 || (command->output && !get(command->output, &right))) {
        printf("%s: status %d without any failure\n%.400s\n", command->name, run.status,
               run.errors);
        return false;
    }
    return true;
}

static bool make_texture(const char *program)
{
    const char *words[] = {program, "scene.scn", "-q", "-o", "t.png", NULL};
    static const char plain[] = "film { width: 4, height: 4 }\nrender { samples: 1 }\n"
                                "camera { position: (0, 0, 5), look_at: (0, 0, 0) }\nsphere {}\n";
    FaultRun run;
    put("scene.scn", plain, sizeof plain - 1);
    put("part.scn", part, sizeof part - 1);
    put("three.ply", mesh, sizeof mesh - 1);
    return fault_run(words, folder, FAULT_NONE, 0, false, &run) && run.status == 0;
}

int main(int argc, char **argv)
{
    if (argc < 4) {
        fputs("usage: faults_test PROGRAM FOLDER ALLOCATIONS [MOST]\n", stderr);
        return 2;
    }
    folder = argv[2];
    fault_preload = argv[3];
    const uint64_t most = argc > 4 ? strtoull(argv[4], NULL, 10) : 0;
    Tally all = {0};
    if (!make_texture(argv[1])) {
        fputs("no texture could be made\n", stderr);
        return 2;
    }
    for (size_t c = 0; c < sizeof commands / sizeof commands[0]; ++c) {
        const Command *command = &commands[c];
        if (!begin_command(command, argv[1])) {
            return 1;
        }
        for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; ++k) {
            FaultRun run;
            Tally tally = {0};
            if (kinds[k].kind == FAULT_ALLOCATION && !fault_preload[0]) {
                continue;
            }
            set_up(command);
            if (!fault_run(list, folder, kinds[k].kind, 0, false, &run)) {
                puts("this system can't answer system calls for a program: nothing is tested");
                return 77;
            }
            uint64_t step = most && run.count > most ? (run.count + most - 1) / most : 1;
            for (uint64_t at = 1; at <= run.count; at += step) {
                one(command, k, at, false, &tally);
                if (at == 1 || step == 1) {
                    one(command, k, at, true, &tally);
                }
            }
            printf("%s: %llu %s, %llu runs, %llu of them not harmed, %llu wrong\n", command->name,
                   (unsigned long long)run.count, kinds[k].name, (unsigned long long)tally.runs,
                   (unsigned long long)tally.tolerated, (unsigned long long)tally.failures);
            fflush(stdout);
            all.runs += tally.runs;
            all.failures += tally.failures;
        }
    }
    printf("%llu runs with a failure of the system, %llu wrong\n", (unsigned long long)all.runs,
           (unsigned long long)all.failures);
    return all.failures ? 1 : 0;
}
