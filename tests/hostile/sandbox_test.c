// Scenes that try to read what they may not: a hundred and more names, each as an import, a mesh, a
// picture, a photometric file and a light's surroundings. All of them lead (or would, if they were
// decoded, joined or followed carelessly) to files that are sound, so that a reading that succeeds
// shows: its statement has no error.
//     sandbox_test PROGRAM FOLDER PICTURE LAMP        PICTURE, LAMP: a sound PNG and IES file
#include "program.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

// FOLDER/
//     in/scene.scn      the scene; below in/ it may read
//     in/sub/           a folder; in/part.scn and so on: sound
//     out/secret.*      what it may not read; in-not/ is another folder beside in/
//     in/links…         lead out
// In a name, %B is the absolute path of FOLDER, %X the extension, %P that path without its first
// "/", %N FOLDER's own name.
static const char *const names[] = {
    // Upwards.
    "../out/secret.%X",
    "./../out/secret.%X",
    "sub/../../out/secret.%X",
    "sub/../sub/../../out/secret.%X",
    "..//out//secret.%X",
    ".././out/./secret.%X",
    "../in/../out/secret.%X",
    "../out/../out/secret.%X",
    "sub/./../../out/secret.%X",
    "sub//..//..//out/secret.%X",
    "../../%N/out/secret.%X",
    "nowhere/../../out/secret.%X",
    "part.scn/../../out/secret.%X",
    "part.scn/../secret.%X",
    "sub/../../in-not/secret.%X",
    "../in-not/secret.%X",
    "../out/secret.%X/",
    "../out/secret.%X/.",
    "../out/./secret.%X",
    "../out/sub/../secret.%X",
    "../out//secret.%X",
    "./././../out/secret.%X",
    "../../../../../../../../../../../../../../../../..%B/out/secret.%X",
    "sub/../../../../../../../../../../../../../../..%B/out/secret.%X",
    // Absolute.
    "%B/out/secret.%X",
    "/%B/out/secret.%X",
    "//%B/out/secret.%X",
    "%B//out/secret.%X",
    "%B/in/../out/secret.%X",
    "%B/in/sub/../../out/secret.%X",
    "%B/in-not/secret.%X",
    "/.%B/out/secret.%X",
    "/..%B/out/secret.%X",
    "/../..%B/out/secret.%X",
    "/./%P/out/secret.%X",
    "%B/./out/secret.%X",
    "%B/in/./../out/secret.%X",
    "%B/in/nowhere/../../out/secret.%X",
    // Links.
    "link.%X",
    "absolute_link.%X",
    "linked/secret.%X",
    "linked/../secret.%X",
    "linked/../out/secret.%X",
    "absolute_linked/secret.%X",
    "linked_up/out/secret.%X",
    "linked_up/in-not/secret.%X",
    "linked_root%B/out/secret.%X",
    "link_to_link.%X",
    "link_through_in.%X",
    "sub/link.%X",
    "sub/deep_link.%X",
    "loop.%X",
    "loop_a/secret.%X",
    "dangling.%X",
    "./link.%X",
    "sub/../link.%X",
    "linked/./secret.%X",
    "linked//secret.%X",
    "%B/in/link.%X",
    "%B/in/linked/secret.%X",
    "linked_up/../out/secret.%X",
    // By way of /proc and descriptors.
    "/proc/self/root%B/out/secret.%X",
    "/proc/self/cwd/../out/secret.%X",
    "/proc/thread-self/root%B/out/secret.%X",
    "/proc/1/root%B/out/secret.%X",
    "/proc/self/cwd/secret.%X",
    "proc_root%B/out/secret.%X",
    "proc_cwd/../out/secret.%X",
    "proc_fd/3/../out/secret.%X",
    "/proc/self/fd/3",
    "/proc/self/fd/4",
    "/proc/self/fd/5",
    "/dev/fd/3",
    "/dev/fd/4",
    "/dev/stdin",
    "/proc/self/environ",
    "/proc/self/maps",
    "/proc/self/mem",
    "/proc/self/exe",
    "/proc/kcore",
    "proc_environ.%X",
    "proc_exe.%X",
    // Devices, folders, FIFOs, sockets.
    "/dev/zero",
    "/dev/random",
    "/dev/tty",
    "/dev/mem",
    "/dev/null",
    "zero.%X",
    "random.%X",
    "null.%X",
    "tty.%X",
    "fifo.%X",
    "fifo_link.%X",
    "socket.%X",
    "socket_link.%X",
    "folder.%X",
    ".",
    "..",
    "/",
    "sub",
    "sub/",
    "%B/in",
    "%B/out",
    "../out",
    "../out/fifo.%X",
    // The usual targets.
    "/etc/passwd",
    "/etc/shadow",
    "/root/.ssh/id_rsa",
    "~/.ssh/id_rsa",
    "~root/secret.%X",
    "$HOME/secret.%X",
    "${HOME}/secret.%X",
    "/etc/hostname",
    "../../../../../../../../etc/passwd",
    "/sys/kernel/notes",
    "/run/secrets/secret.%X",
    // Names that mean another one when they are decoded.
    "%25%2e%2e/out/secret.%X",
    "%%2e%%2e/out/secret.%X",
    "%%2e%%2e%%2fout%%2fsecret.%X",
    "..%%2fout%%2fsecret.%X",
    "%%252e%%252e/out/secret.%X",
    "..%%c0%%afout%%c0%%afsecret.%X",
    "..\\\\out\\\\secret.%X",
    "..\\u{2215}out\\u{2215}secret.%X",
    "\\u{ff0e}\\u{ff0e}/out/secret.%X",
    "\\u{2025}/out/secret.%X",
    "..\\u{ff0f}out/secret.%X",
    "file://%B/out/secret.%X",
    "file:%B/out/secret.%X",
    "file:../out/secret.%X",
    "FILE://%B/out/secret.%X",
    "http://127.0.0.1/secret.%X",
    "data:,secret.%X",
    "\\\\\\\\?\\\\%B\\\\out\\\\secret.%X",
    "C:%B/out/secret.%X",
    "..;/out/secret.%X",
    ".. /out/secret.%X",
    " ../out/secret.%X",
    "../out/secret.%X ",
    "../out/secret.%X\\n",
    "\\u{202e}../out/secret.%X",
    "..\\u{200b}/out/secret.%X",
    "..\\t/out/secret.%X",
    "|cat ../out/secret.%X",
    "`cat ../out/secret.%X`",
    "$(cat ../out/secret.%X)",
    "../out/secret.%X;part.scn",
    "part.%X:../out/secret.%X",
    "../out/*.%X",
    "../out/secret.??",
    "std/../../out/secret.%X",
    "std/../../../%B/out/secret.%X",
    "std//../out/secret.%X",
    "std/../std/../../out/secret.%X",
    "",
    " ",
    "...",
    ".../secret.%X",
    "../out/secret.%X#.%X",
    "../out/secret.%X?.%X",
};
enum { NAME_COUNT = sizeof names / sizeof names[0] };

// How a scene names files, and the extension of such a file.
static const struct {
    const char *extension, *format;
} ways[] = {
    {"scn", "import \"%s\" as _secret\n"},
    {"ply", "mesh { file: \"%s\" }\n"},
    {"obj", "mesh { file: \"%s\" }\n"},
    {"png", "sphere { material: lambert { color: image { file: \"%s\" } } }\n"},
    {"ies", "photometric_light { position: (0, 0, 1), file: \"%s\" }\n"},
    {"png", "environment_light { radiance: image { file: \"%s\" } }\n"},
};
enum { WAYS = sizeof ways / sizeof ways[0] };

// --- The place -----------------------------------------------------------------------------------

static const char *base;
static char path[8192];

static const char *at(const char *name)
{
    snprintf(path, sizeof path, "%s/%s", base, name);
    return path;
}

static void must(bool good, const char *what)
{
    if (!good) {
        fprintf(stderr, "%s: %s\n", what, strerror(errno));
        exit(2);
    }
}

static void write_file(const char *name, const char *bytes, size_t size)
{
    FILE *out = fopen(at(name), "wb");
    must(out && fwrite(bytes, 1, size, out) == size && fclose(out) == 0, name);
}

static void copy_file(const char *from, const char *name)
{
    static char bytes[1 << 20];
    FILE *in = fopen(from, "rb");
    must(in, from);
    size_t size = fread(bytes, 1, sizeof bytes, in);
    fclose(in);
    write_file(name, bytes, size);
}

static void make_folder(const char *name)
{
    must(mkdir(at(name), 0755) == 0 || errno == EEXIST, name);
}

static void make_link(const char *target, const char *name)
{
    unlink(at(name));
    must(symlink(target, path) == 0, name);
}

static void make_socket(const char *name)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM, 0);
    unlink(at(name));
    char here[4096];
    must(strlen(name) < sizeof address.sun_path, name);
    must(fd >= 0 && getcwd(here, sizeof here) && chdir(base) == 0, name); // its name must be short
    memcpy(address.sun_path, name, strlen(name));
    must(bind(fd, (struct sockaddr *)&address, sizeof address) == 0 && chdir(here) == 0, name);
    close(fd);
}

static const char mesh[] = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                           "property float y\nproperty float z\nelement face 1\n"
                           "property list uchar int vertex_indices\nend_header\n"
                           "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
static const char object[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
static const char part[] = "let secret = 1\n";
static const char *picture, *lamp;

static void put_sound(const char *folder, const char *stem)
{
    char name[200];
    snprintf(name, sizeof name, "%s/%s.scn", folder, stem);
    write_file(name, part, sizeof part - 1);
    snprintf(name, sizeof name, "%s/%s.ply", folder, stem);
    write_file(name, mesh, sizeof mesh - 1);
    snprintf(name, sizeof name, "%s/%s.obj", folder, stem);
    write_file(name, object, sizeof object - 1);
    snprintf(name, sizeof name, "%s/%s.png", folder, stem);
    copy_file(picture, name);
    snprintf(name, sizeof name, "%s/%s.ies", folder, stem);
    copy_file(lamp, name);
}

static void link_in(const char *stem, const char *extension, const char *target)
{
    char name[200];
    snprintf(name, sizeof name, "in/%s.%s", stem, extension);
    make_link(target, name);
}

static void make_links(const char *extension)
{
    char target[8192];
    snprintf(target, sizeof target, "../out/secret.%s", extension);
    link_in("link", extension, target);
    snprintf(target, sizeof target, "%s/out/secret.%s", base, extension);
    link_in("absolute_link", extension, target);
    snprintf(target, sizeof target, "link.%s", extension);
    link_in("link_to_link", extension, target);
    snprintf(target, sizeof target, "../../out/secret.%s", extension);
    link_in("sub/deep_link", extension, target);
    snprintf(target, sizeof target, "../link.%s", extension);
    link_in("sub/link", extension, target);
    snprintf(target, sizeof target, "../in/../out/secret.%s", extension);
    link_in("link_through_in", extension, target);
    snprintf(target, sizeof target, "loop.%s", extension);
    link_in("loop", extension, target);
    link_in("dangling", extension, "../out/nowhere");
    link_in("proc_environ", extension, "/proc/self/environ");
    link_in("proc_exe", extension, "/proc/self/exe");
    link_in("zero", extension, "/dev/zero");
    link_in("random", extension, "/dev/random");
    link_in("null", extension, "/dev/null");
    link_in("tty", extension, "/dev/tty");
    snprintf(target, sizeof target, "../out/fifo.%s", extension);
    link_in("fifo_link", extension, target);
    snprintf(target, sizeof target, "../out/socket.%s", extension);
    link_in("socket_link", extension, target);
    static const char *const folders[] = {"in", "out"};
    for (int i = 0; i < 2; ++i) {
        char name[200];
        snprintf(name, sizeof name, "%s/fifo.%s", folders[i], extension);
        must(mkfifo(at(name), 0644) == 0 || errno == EEXIST, name);
        snprintf(name, sizeof name, "%s/socket.%s", folders[i], extension);
        make_socket(name);
    }
    char name[200];
    snprintf(name, sizeof name, "in/folder.%s", extension);
    make_folder(name);
}

static void make_place(void)
{
    static const char *const folders[] = {"in", "in/sub", "out", "out/sub", "in-not"};
    for (size_t i = 0; i < sizeof folders / sizeof folders[0]; ++i) {
        make_folder(folders[i]);
    }
    put_sound("out", "secret");
    put_sound("in-not", "secret");
    put_sound(".", "secret");
    put_sound("in", "part");
    make_link("../out", "in/linked");
    make_link(at("out"), "in/absolute_linked");
    make_link("..", "in/linked_up");
    make_link("/", "in/linked_root");
    make_link("loop_b", "in/loop_a");
    make_link("loop_a", "in/loop_b");
    make_link("/proc/self/root", "in/proc_root");
    make_link("/proc/self/cwd", "in/proc_cwd");
    make_link("/proc/self/fd", "in/proc_fd");
    for (int i = 0; i < WAYS; ++i) {
        make_links(ways[i].extension);
    }
}

// --- Tries ---------------------------------------------------------------------------------------

static void spell(const char *name, const char *extension, char *out, size_t size)
{
    size_t length = 0;
    for (const char *c = name; *c && length + 1 < size; ++c) {
        const char *put = NULL;
        const char *folder = strrchr(base, '/');
        if (*c == '%') {
            ++c;
            put = *c == 'B'   ? base
                  : *c == 'P' ? base + 1
                  : *c == 'N' ? folder + 1
                  : *c == 'X' ? extension
                  : *c == '2' ? "%2"
                              : "%";
        }
        length += (size_t)(put ? snprintf(out + length, size - length, "%s", put)
                               : snprintf(out + length, size - length, "%c", *c));
    }
    out[length < size ? length : size - 1] = '\0';
}

// The statements, one a line; each must have an error of its own.
static int write_scene(const char *name)
{
    static char text[1 << 16];
    size_t length = 0;
    for (int i = 0; i < WAYS; ++i) {
        char file[8192];
        spell(name, ways[i].extension, file, sizeof file);
        length += (size_t)snprintf(text + length, sizeof text - length, ways[i].format, file);
    }
    write_file("in/scene.scn", text, length);
    return WAYS;
}

// An error (no warning) about a file or a name of one.
static bool has_error_in_line(const ProgramRun *run, int line)
{
    char place[64];
    snprintf(place, sizeof place, "\n  --> scene.scn:%d:", line);
    for (const char *found = run->errors; (found = strstr(found, place)); ++found) {
        const char *begin = found + 1;
        do { // to the line that isn't indented: names may have line ends in them
            do {
                --begin;
            } while (begin > run->errors && begin[-1] != '\n');
        } while (begin > run->errors && *begin == ' ');
        if (strncmp(begin, "error[E06", 9) == 0 || strncmp(begin, "error[E085", 10) == 0) {
            return true;
        }
    }
    return false;
}

// Under the line of each statement there is an error that tells of a file, and nothing else.
static bool all_refused(const ProgramRun *run, int statements)
{
    for (int line = 1; line <= statements; ++line) {
        if (!has_error_in_line(run, line)) {
            return false;
        }
    }
    return true;
}

static bool try_name(const char *program, const char *name, bool sound)
{
    static const char *const command[] = {"check", "scene.scn", NULL};
    char folder[4200];
    snprintf(folder, sizeof folder, "%s/in", base);
    int statements = write_scene(name);
    ProgramRun run;
    program_run(program, command, folder, 120, &run);
    bool good = sound ? run.status == 0 : run.status == 1 && all_refused(&run, statements);
    if (!good) {
        printf("`%s`: status %d\n%.3000s\n", name, run.status, run.errors);
    }
    return good;
}

int main(int argc, char **argv)
{
    if (argc < 5) {
        fputs("usage: sandbox_test PROGRAM FOLDER PICTURE LAMP\n", stderr);
        return 2;
    }
    base = argv[2];
    picture = argv[3];
    lamp = argv[4];
    make_place();
    // What lies in the folder can be read, so that a refusal isn't for something else.
    if (!try_name(argv[1], "part.%X", true) || !try_name(argv[1], "sub/../part.%X", true)) {
        puts("not even a file beside the scene is read");
        return 1;
    }
    int failed = 0;
    for (int i = 0; i < NAME_COUNT; ++i) {
        failed += !try_name(argv[1], names[i], false);
    }
    printf("%d names, each in %d ways: %d tries to read outside of the sandbox, of %d names one or "
           "more succeeded\n",
           NAME_COUNT, WAYS, NAME_COUNT * WAYS, failed);
    return failed ? 1 : 0;
}
