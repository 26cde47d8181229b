#include "base/io.h"

#include "base/mem.h"
#include "base/thread.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

enum {
    OWN_PAGES_FROM = 64 * 1024, // larger files get pages of their own
    FIRST_READ = 64 * 1024,     // of a pipe, whose size isn't known
    PIECES_FROM = 4 << 20,      // larger files are read by threads
    MOST_PIECES = 16,
};

const char *io_error_text(IoError error)
{
    switch (error) {
    case IO_OK:
        return "no error";
    case IO_NOT_FOUND:
        return "there is no such file";
    case IO_FORBIDDEN:
        return "its permissions forbid reading it";
    case IO_OUTSIDE:
        return "it lies outside the folders that a scene may read";
    case IO_NOT_REGULAR:
        return "it is not a regular file";
    case IO_TOO_LARGE:
        return "it is too large";
    case IO_FAILED:
        return "it could not be read";
    case IO_NO_MEMORY:
        return "there is not enough memory for it";
    }
    return "unknown error";
}

IoError io_error_from_errno(int code)
{
    switch (code) {
    case ENOENT:
    case ENOTDIR:
    case ENAMETOOLONG:
        return IO_NOT_FOUND;
    case EACCES:
    case EPERM:
        return IO_FORBIDDEN;
    case EXDEV:
    case ELOOP:
        return IO_OUTSIDE;
    case ENXIO: // a socket
    case ENODEV:
    case EISDIR:
        return IO_NOT_REGULAR;
    case EFBIG:
    case EOVERFLOW:
        return IO_TOO_LARGE;
    case ENOMEM:
        return IO_NO_MEMORY;
    default:
        return IO_FAILED;
    }
}

void file_bytes_free(FileBytes *bytes)
{
    if (bytes->mapped) {
        munmap(bytes->bytes, bytes->size + 1);
    } else {
        mem_free(bytes->bytes);
    }
    *bytes = (FileBytes){0};
}

static bool file_bytes_alloc(FileBytes *out, size_t size)
{
    *out = (FileBytes){.size = size, .mapped = size >= OWN_PAGES_FROM};
    if (!out->mapped) {
        out->bytes = mem_alloc(size + 1, 1);
        return out->bytes != NULL;
    }
    void *pages = mmap(NULL, size + 1, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    out->bytes = pages == MAP_FAILED ? NULL : pages;
    return out->bytes != NULL;
}

// Up to `size` bytes from fd; fewer at the end of the file. False on a read error.
static bool read_up_to(int fd, char *bytes, size_t size, size_t *got)
{
    *got = 0;
    while (*got < size) {
        size_t wanted = size - *got < SSIZE_MAX ? size - *got : SSIZE_MAX;
        ssize_t n = read(fd, bytes + *got, wanted);
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n < 0) {
            return false;
        }
        if (n == 0) {
            break;
        }
        *got += (size_t)n;
    }
    return true;
}

// A large file is read in pieces, by threads: what it costs is copying it.
typedef struct Pieces {
    int fd;
    FileBytes *out;
    size_t got[MOST_PIECES]; // bytes of each
    atomic_bool failed;
} Pieces;

static size_t piece_begin(const FileBytes *file, size_t piece)
{
    return file->size / MOST_PIECES * piece;
}

static void read_piece(void *context, uint64_t piece, unsigned worker)
{
    (void)worker;
    Pieces *pieces = context;
    const size_t begin = piece_begin(pieces->out, piece);
    const size_t end =
        piece + 1 == MOST_PIECES ? pieces->out->size : piece_begin(pieces->out, piece + 1);
    size_t *got = &pieces->got[piece];
    while (begin + *got < end) {
        const size_t at = begin + *got;
        const ssize_t n = pread(pieces->fd, pieces->out->bytes + at, end - at, (off_t)at);
        if (n == 0 || (n < 0 && errno != EINTR)) {
            if (n < 0) {
                atomic_store(&pieces->failed, true);
            }
            return;
        }
        *got += n > 0 ? (size_t)n : 0;
    }
}

// As read_up_to for all of the file; *got ends with the first piece that isn't whole.
static bool read_pieces(int fd, FileBytes *out, unsigned threads, size_t *got)
{
    Pieces pieces = {.fd = fd, .out = out};
    parallel_for(MOST_PIECES, threads, read_piece, &pieces, NULL);
    *got = 0;
    for (size_t i = 0; i < MOST_PIECES && *got == piece_begin(out, i); ++i) {
        *got += pieces.got[i];
    }
    return !atomic_load(&pieces.failed);
}

// A file that shrinks meanwhile gives fewer bytes; one that grows is cut at its first size.
static IoError read_sized(int fd, uint64_t size, unsigned threads, FileBytes *out)
{
    if (size >= PTRDIFF_MAX || !file_bytes_alloc(out, (size_t)size)) {
        *out = (FileBytes){0};
        return IO_NO_MEMORY;
    }
    size_t got, pages = out->size;
    const bool read = threads > 1 && size >= PIECES_FROM
                          ? read_pieces(fd, out, threads, &got)
                          : read_up_to(fd, out->bytes, out->size, &got);
    if (!read) {
        file_bytes_free(out);
        return IO_FAILED;
    }
    out->bytes[got] = '\0';
    if (got < pages && !out->mapped) {
        out->size = got;
    } else if (got < pages) { // file_bytes_free wants to know how much was mapped
        FileBytes smaller;
        bool copied = file_bytes_alloc(&smaller, got);
        if (copied) {
            memcpy(smaller.bytes, out->bytes, got);
            smaller.bytes[got] = '\0';
        }
        file_bytes_free(out);
        *out = copied ? smaller : (FileBytes){0};
        return copied ? IO_OK : IO_NO_MEMORY;
    }
    return IO_OK;
}

// Reads a pipe or the like to its end.
static IoError read_stream(int fd, uint64_t max_bytes, FileBytes *out)
{
    size_t capacity = FIRST_READ, size = 0;
    char *bytes = mem_alloc(capacity + 1, 1);
    while (bytes) {
        size_t got;
        if (!read_up_to(fd, bytes + size, capacity - size, &got)) {
            mem_free(bytes);
            return IO_FAILED;
        }
        size += got;
        if (size > max_bytes) {
            mem_free(bytes);
            return IO_TOO_LARGE;
        }
        if (size < capacity) {
            bytes[size] = '\0';
            *out = (FileBytes){bytes, size, false};
            return IO_OK;
        }
        char *grown = capacity > PTRDIFF_MAX / 4 ? NULL : mem_realloc(bytes, capacity * 2 + 1, 1);
        if (!grown) {
            mem_free(bytes);
        }
        bytes = grown;
        capacity *= 2;
    }
    return IO_NO_MEMORY;
}

IoError file_read(const char *path, uint64_t max_bytes, FileBytes *out)
{
    *out = (FileBytes){0};
    bool standard_input = strcmp(path, "-") == 0;
    int fd = standard_input ? STDIN_FILENO : open(path, O_RDONLY | O_CLOEXEC | O_NOCTTY);
    if (fd < 0) {
        return errno == ELOOP ? IO_NOT_FOUND : io_error_from_errno(errno);
    }
    struct stat info;
    IoError error;
    if (fstat(fd, &info) != 0) {
        error = IO_FAILED;
    } else if (S_ISDIR(info.st_mode)) {
        error = IO_NOT_REGULAR;
    } else if (S_ISREG(info.st_mode) && info.st_size > 0 && !standard_input) {
        error = (uint64_t)info.st_size > max_bytes ? IO_TOO_LARGE
                                                   : read_sized(fd, (uint64_t)info.st_size, 1, out);
    } else {
        error = read_stream(fd, max_bytes, out);
    }
    if (!standard_input) {
        close(fd);
    }
    return error;
}

typedef struct Hashing {
    const char *bytes;
    size_t size;
    uint64_t pieces[MOST_PIECES];
} Hashing;

static void hash_piece(void *context, uint64_t piece, unsigned worker)
{
    (void)worker;
    Hashing *hashing = context;
    const size_t each = hashing->size / MOST_PIECES, begin = each * (size_t)piece;
    const size_t size = piece + 1 == MOST_PIECES ? hashing->size - begin : each;
    hashing->pieces[piece] = XXH3_64bits(hashing->bytes + begin, size);
}

uint64_t content_hash(const void *bytes, size_t size, uint64_t seed, unsigned threads)
{
    if (size < PIECES_FROM) {
        return XXH3_64bits_withSeed(bytes, size, seed);
    }
    Hashing hashing = {.bytes = bytes, .size = size};
    parallel_for(MOST_PIECES, threads, hash_piece, &hashing, NULL);
    return XXH3_64bits_withSeed(hashing.pieces, sizeof hashing.pieces, seed);
}

static uint64_t hash_file(const char *path, const FileBytes *file, unsigned threads)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    uint64_t seed = XXH3_64bits(name, strlen(name));
    return content_hash(file->bytes, file->size, seed, threads);
}

uint64_t sandbox_content_hash(const char *path, const FileBytes *file)
{
    return hash_file(path, file, 1);
}

// A sum, so that the order doesn't matter.
static void count_content(Sandbox *sandbox, const char *path, const FileBytes *file)
{
    const uint64_t hash = hash_file(path, file, sandbox->threads);
    atomic_fetch_add(&sandbox->content_hash, hash);
    if (sandbox->on_read) {
        sandbox->on_read(sandbox->on_read_context, path, hash);
    }
}

IoError sandbox_read(Sandbox *sandbox, const char *path, FileBytes *out)
{
    *out = (FileBytes){0};
    int fd;
    uint64_t size;
    IoError error = sandbox_open(sandbox, path, &fd, &size);
    if (error == IO_OK) {
        error = read_sized(fd, size, sandbox->threads, out);
        close(fd);
    }
    if (error == IO_OK) {
        count_content(sandbox, path, out);
    }
    return error;
}
