// Files: read whole, replaced atomically, and opened only where a scene may read.
#ifndef BASE_IO_H
#define BASE_IO_H

#include "base/arena.h"
#include "base/str.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

// Why a file couldn't be had; io_error_text says it in words.
typedef enum IoError {
    IO_OK,
    IO_NOT_FOUND,
    IO_FORBIDDEN,   // permissions
    IO_OUTSIDE,     // outside the sandbox, or a link leads out of it
    IO_NOT_REGULAR, // a folder, device, FIFO, socket
    IO_TOO_LARGE,
    IO_FAILED, // a read error; errno text in io_error_text
    IO_NO_MEMORY,
} IoError;

const char *io_error_text(IoError error);
// The nearest IoError to a value of errno.
IoError io_error_from_errno(int code);

typedef struct FileBytes {
    char *bytes; // size bytes and a NUL after them
    size_t size;
    // In pages of its own rather than on the heap. They hold a copy: a mapping of the file itself
    // would crash the program when somebody shortens the file while it is read.
    bool mapped;
} FileBytes;

// The folders below which a scene may read. Everything is resolved by the kernel with openat2's
// RESOLVE_BENEATH (or by walking with O_NOFOLLOW where that is missing), so that neither "..",
// links nor a race can lead out. A link that leads to another place inside is followed.
typedef struct Sandbox {
    struct SandboxRoot {
        int fd;
        char *path;  // absolute, links resolved
        char *given; // absolute, as it was named; "/" at neither end but for the root folder
    } roots[16];
    int root_count;
    uint64_t max_file_bytes;
    unsigned threads; // that read a large file; 0 counts as 1
    bool allow_all;   // for the scene's own tools; never set from a scene
    // Told the path of each file that is to be opened, whether or not it is there, before it is
    // opened; from the thread that opens it. NULL: nobody is.
    void (*on_open)(void *context, const char *path);
    void *on_open_context;
    // Told of each file that was read, with sandbox_content_hash of it; NULL: nobody is.
    void (*on_read)(void *context, const char *path, uint64_t hash);
    void *on_read_context;
    // Over the names (without folders) and the contents of all files read so far, in whatever order
    // they were read: two runs that read the same files end with the same number.
    atomic_uint_least64_t content_hash;
} Sandbox;

void sandbox_init(Sandbox *sandbox);
void sandbox_free(Sandbox *sandbox);
// Allows reading below `folder`. IO_OK, or why not.
IoError sandbox_allow(Sandbox *sandbox, const char *folder);
// Resolves `path`, relative to the folder of the file `from` (an absolute path; NULL: the first
// root), to an absolute one inside the sandbox, in *out (arena). Only names are looked at; opening
// checks again.
IoError sandbox_resolve(const Sandbox *sandbox, Arena *arena, const char *from, Str path,
                        const char **out);
// Opens an absolute path for reading: a regular file inside the sandbox, of at most max_file_bytes.
// Returns the descriptor in *fd, its size in *size. Never waits (for a FIFO's other end, say).
IoError sandbox_open(const Sandbox *sandbox, const char *path, int *fd, uint64_t *size);
// True where sandbox_open would find such a file.
bool sandbox_has(const Sandbox *sandbox, const char *path);
// Reads a whole file; give it back with file_bytes_free.
IoError sandbox_read(Sandbox *sandbox, const char *path, FileBytes *out);
// XXH3 of bytes, of those of large blocks in pieces, by threads; it doesn't depend on how many.
uint64_t content_hash(const void *bytes, size_t size, uint64_t seed, unsigned threads);
// Of a file's name (without folders) and content.
uint64_t sandbox_content_hash(const char *path, const FileBytes *file);
// sandbox_read without a sandbox, for files that the user named on the command line ("-" is stdin);
// they may be pipes.
IoError file_read(const char *path, uint64_t max_bytes, FileBytes *out);
void file_bytes_free(FileBytes *bytes);

// A file that appears whole or not at all: written without a name (under a temporary one where the
// file system can't do that) beside `path`, flushed to the disk, then renamed over it. Where `path`
// is a link, the file that it leads to is replaced and the link stays; the new file gets the
// permissions of the old one. Only regular files are replaced.
typedef struct AtomicFile {
    char *path, *temporary;
    FILE *stream;  // write here
    bool nameless; // so far: `temporary` is only the name that it will have for a moment
} AtomicFile;
// False, with a message in `error`, when it can't be created; then there is nothing to give back.
bool atomic_file_open(AtomicFile *file, const char *path, char *error, size_t error_size);
// Commits; false (with a message; the old file intact and nothing left behind) if any write failed.
bool atomic_file_commit(AtomicFile *file, char *error, size_t error_size);
void atomic_file_abandon(AtomicFile *file);
// For writers that want a name, not a stream: makes an empty temporary file beside `path` and
// returns its name (arena), to be passed to the writer and then to atomic_rename, which flushes and
// renames (or removes it and returns false with a message), or to atomic_discard. NULL with a
// message when it can't be made.
char *atomic_temporary_name(Arena *arena, const char *path, char *error, size_t error_size);
bool atomic_rename(const char *temporary, const char *path, char *error, size_t error_size);
void atomic_discard(const char *temporary);

#endif
