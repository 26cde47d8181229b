#include "cli/film_file.h"

#include "base/io.h"
#include "cli/load.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

enum { MOST_ARGUMENTS = 40, MOST_COMPLAINT = 400 };

typedef struct FilmType {
    const char *extension;
    const char *arguments[24]; // of ffmpeg, for what is written; NULL at the end
} FilmType;

// sRGB pictures, told as such. H.264 has whole pairs of rows and columns, so that an odd last one
// is left out; a GIF has one palette, of all its pictures.
static const FilmType types[] = {
    {".mp4",
     {"-vf",
      "crop=trunc(iw/2)*2:trunc(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv",
      "-c:v",
      "libx264",
      "-preset",
      "medium",
      "-crf",
      "17",
      "-pix_fmt",
      "yuv420p",
      "-color_primaries",
      "bt709",
      "-color_trc",
      "iec61966-2-1",
      "-colorspace",
      "bt709",
      "-color_range",
      "tv",
      "-movflags",
      "+faststart",
      "-f",
      "mp4",
      NULL}},
    {".gif",
     {"-filter_complex", "split[a][b];[a]palettegen[p];[b][p]paletteuse=diff_mode=rectangle",
      "-loop", "0", "-f", "gif", NULL}},
};
enum { TYPE_COUNT = sizeof types / sizeof types[0] };

static const FilmType *type_of(const char *name)
{
    const size_t length = strlen(name);
    for (int i = 0; i < TYPE_COUNT; ++i) {
        const size_t end = strlen(types[i].extension);
        if (length > end && strcasecmp(name + length - end, types[i].extension) == 0) {
            return &types[i];
        }
    }
    return NULL;
}

bool film_file_is(const char *name)
{
    return type_of(name) != NULL;
}

const char *film_file_extensions(void)
{
    return ".mp4 or .gif";
}

// --- ffmpeg --------------------------------------------------------------------------------------

// The program, from the folders of $PATH.
static bool find_program(char path[PATH_MAX])
{
    const char *folders = getenv("PATH");
    while (folders && *folders) {
        const size_t length = strcspn(folders, ":");
        const int written =
            snprintf(path, PATH_MAX, "%.*s%sffmpeg", (int)length, folders, length ? "/" : "./");
        if (written > 0 && written < PATH_MAX && access(path, X_OK) == 0) {
            return true;
        }
        folders += length + (folders[length] == ':');
    }
    return false;
}

int film_file_check(const char *path)
{
    char program[PATH_MAX];
    if (find_program(program)) {
        return EXIT_OK;
    }
    return complain(
        EXIT_FILES,
        "`%s` wants ffmpeg, which isn't installed; `-o NAME.png` gives the pictures alone", path);
}

typedef struct Encoder {
    pid_t process;
    int pictures, complaints; // descriptors: the pipe that it reads, a file that it writes
} Encoder;

static void fill_arguments(const FilmFile *film, char *rate, char *temporary, char **arguments)
{
    static const char *const before[] = {"ffmpeg", "-hide_banner", "-loglevel",  "error",
                                         "-y",     "-f",           "image2pipe", "-c:v",
                                         "png",    "-framerate"};
    size_t count = 0;
    for (size_t i = 0; i < sizeof before / sizeof before[0]; ++i) {
        arguments[count++] = (char *)(uintptr_t)before[i];
    }
    arguments[count++] = rate;
    arguments[count++] = "-i";
    arguments[count++] = "-";
    const char *const *of_type = type_of(film->path)->arguments;
    for (size_t i = 0; of_type[i]; ++i) {
        arguments[count++] = (char *)(uintptr_t)of_type[i];
    }
    arguments[count++] = temporary;
    arguments[count] = NULL;
}

// With signals as a program expects them: ours are blocked or ignored.
static int spawn(const char *program, char *const *arguments, int pictures, int complaints,
                 pid_t *process)
{
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    sigset_t none, usual;
    sigemptyset(&none);
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE);
    sigaddset(&usual, SIGXFSZ);
    posix_spawn_file_actions_init(&files);
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_adddup2(&files, pictures, STDIN_FILENO);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&files, complaints, STDERR_FILENO);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &usual);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    const int error = posix_spawn(process, program, &files, &attributes, arguments, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return error;
}

// False with errno.
static bool start(const FilmFile *film, char *temporary, Encoder *encoder)
{
    char program[PATH_MAX], rate[32];
    char *arguments[MOST_ARGUMENTS];
    int ends[2];
    if (!find_program(program)) {
        errno = ENOENT;
        return false;
    }
    snprintf(rate, sizeof rate, "%.10g", film->rate);
    fill_arguments(film, rate, temporary, arguments);
    encoder->complaints = memfd_create("ffmpeg", MFD_CLOEXEC);
    if (encoder->complaints < 0) {
        return false;
    }
    if (pipe2(ends, O_CLOEXEC) != 0) {
        close(encoder->complaints);
        return false;
    }
    const int error = spawn(program, arguments, ends[0], encoder->complaints, &encoder->process);
    close(ends[0]);
    encoder->pictures = ends[1];
    if (error) {
        close(ends[1]);
        close(encoder->complaints);
    }
    errno = error;
    return error == 0;
}

// --- Feeding it ----------------------------------------------------------------------------------

// False once it doesn't read any more.
static bool feed_bytes(int fd, const char *bytes, size_t size)
{
    while (size > 0) {
        const ssize_t n = write(fd, bytes, size);
        if (n < 0 && errno != EINTR) {
            return false;
        }
        if (n > 0) {
            bytes += n;
            size -= (size_t)n;
        }
    }
    return true;
}

static int feed(const FilmFile *film, const Encoder *encoder)
{
    for (size_t i = 0; i < film->count; ++i) {
        const int stopped = film->stopped(film->context);
        if (stopped) {
            return stopped;
        }
        const char *name = film->picture(film->context, i);
        FileBytes bytes;
        const IoError error = name ? file_read(name, (uint64_t)1 << 34, &bytes) : IO_NO_MEMORY;
        if (error != IO_OK) {
            return complain(error == IO_NO_MEMORY ? EXIT_NO_MEMORY : EXIT_FILES,
                            "can't read `%s`: %s", name ? name : "a picture", io_error_text(error));
        }
        const bool taken = feed_bytes(encoder->pictures, bytes.bytes, bytes.size);
        file_bytes_free(&bytes);
        if (!taken) {
            return EXIT_OK; // why, it says itself
        }
    }
    return EXIT_OK;
}

// The first line of what it wrote.
static void read_complaint(int fd, char *text, size_t size)
{
    const ssize_t n = pread(fd, text, size - 1, 0);
    text[n > 0 ? n : 0] = '\0';
    text[strcspn(text, "\n")] = '\0';
}

// Waits for its end. An ExitCode, after a message.
static int end(const FilmFile *film, const Encoder *encoder, int fed)
{
    int status = 0;
    char complaint[MOST_COMPLAINT];
    close(encoder->pictures);
    while (waitpid(encoder->process, &status, 0) < 0 && errno == EINTR) {
    }
    read_complaint(encoder->complaints, complaint, sizeof complaint);
    close(encoder->complaints);
    if (fed != EXIT_OK || (WIFEXITED(status) && WEXITSTATUS(status) == 0)) {
        return fed;
    }
    const int stopped = film->stopped(film->context);
    return stopped ? stopped
                   : complain(EXIT_FILES, "`%s` can't be made: ffmpeg says: %s", film->path,
                              *complaint ? complaint : "nothing");
}

static int write_temporary(const FilmFile *film, char *temporary)
{
    Encoder encoder;
    if (!start(film, temporary, &encoder)) {
        return complain(EXIT_FILES, "ffmpeg can't be started: %s", strerror(errno));
    }
    return end(film, &encoder, feed(film, &encoder));
}

int film_file_write(const FilmFile *film)
{
    Arena arena = {0};
    char message[1024];
    char *temporary = atomic_temporary_name(&arena, film->path, message, sizeof message);
    int code = temporary ? write_temporary(film, temporary) : complain(EXIT_FILES, "%s", message);
    if (code == EXIT_OK && !atomic_rename(temporary, film->path, message, sizeof message)) {
        code = complain(EXIT_FILES, "%s", message);
    } else if (code != EXIT_OK && temporary) {
        atomic_discard(temporary);
    }
    arena_free(&arena);
    return code;
}
