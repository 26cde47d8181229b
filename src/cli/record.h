// What a picture of a series was made of, kept in a small file (JSON) beside the pictures, so that
// another run knows which of them are there already: the settings, and the names and hashes of all
// files that were read and of the pictures themselves.
#ifndef CLI_RECORD_H
#define CLI_RECORD_H

#include "base/array.h"
#include "base/io.h"

typedef struct RecordedFile {
    const char *name; // files that were read: below the scene's folder, or absolute
    uint64_t hash;    // sandbox_content_hash
} RecordedFile;

typedef struct RecordedFiles {
    ARRAY(RecordedFile) items;
    bool incomplete; // memory ran out
} RecordedFiles;

typedef struct Record {
    const char *settings;      // in words
    const RecordedFiles *read; // when the picture was made
    const char *const *pictures;
    size_t picture_count;
    const char *folder; // where the pictures lie
} Record;

// Writes it to the file `path`, with the pictures' hashes as they are now. False with a message.
bool record_write(const char *path, const Record *record, char *message, size_t message_size);

// Files whose hashes were found out in this run.
typedef struct RecordChecker {
    Sandbox *sandbox;    // through which files are read; not owned
    const char *base;    // the scene's folder, with a / at its end
    Arena arena;         // of the names
    RecordedFiles known; // all that is known
} RecordChecker;

void record_checker_free(RecordChecker *checker);
// Does the file `path` say that the pictures (of which record->read is ignored) were made with
// these settings, of files that still are as they were, and are they untouched? False also where it
// is missing or damaged.
bool record_fits(RecordChecker *checker, const char *path, const Record *record);

#endif
