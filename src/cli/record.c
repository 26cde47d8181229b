#include "cli/record.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_RECORD_BYTES = 1 << 24, HASH_SIZE = 17 };
static const uint64_t MOST_PICTURE_BYTES = (uint64_t)1 << 36;

static void hash_text(uint64_t hash, char text[HASH_SIZE])
{
    snprintf(text, HASH_SIZE, "%016" PRIx64, hash);
}

static bool path_of(const Record *record, size_t picture, char path[PATH_MAX])
{
    const int length = snprintf(path, PATH_MAX, "%s/%s", record->folder, record->pictures[picture]);
    return length > 0 && length < PATH_MAX;
}

static bool hash_of_picture(const Record *record, size_t picture, char text[HASH_SIZE])
{
    char path[PATH_MAX];
    FileBytes bytes;
    if (!path_of(record, picture, path) || file_read(path, MOST_PICTURE_BYTES, &bytes) != IO_OK) {
        return false;
    }
    hash_text(sandbox_content_hash(path, &bytes), text);
    file_bytes_free(&bytes);
    return true;
}

// --- Writing -------------------------------------------------------------------------------------

static bool add_text(cJSON *object, const char *name, const char *text)
{
    return cJSON_AddStringToObject(object, name, text) != NULL;
}

static bool add_all(cJSON *root, const Record *record)
{
    char hash[HASH_SIZE];
    bool good = add_text(root, "settings", record->settings) && !record->read->incomplete;
    cJSON *files = cJSON_AddObjectToObject(root, "files");
    for (size_t i = 0; files && good && i < record->read->items.count; ++i) {
        hash_text(record->read->items.items[i].hash, hash);
        good = add_text(files, record->read->items.items[i].name, hash);
    }
    cJSON *pictures = cJSON_AddObjectToObject(root, "pictures");
    for (size_t i = 0; pictures && good && i < record->picture_count; ++i) {
        good = hash_of_picture(record, i, hash) && add_text(pictures, record->pictures[i], hash);
    }
    return good && files && pictures;
}

static bool write_text(const char *path, const char *text, char *message, size_t message_size)
{
    AtomicFile file;
    if (!atomic_file_open(&file, path, message, message_size)) {
        return false;
    }
    fputs(text, file.stream);
    fputc('\n', file.stream);
    return atomic_file_commit(&file, message, message_size);
}

bool record_write(const char *path, const Record *record, char *message, size_t message_size)
{
    cJSON *root = cJSON_CreateObject();
    char *text = root && add_all(root, record) ? cJSON_Print(root) : NULL;
    bool good = false;
    if (text) {
        good = write_text(path, text, message, message_size);
    } else {
        snprintf(message, message_size, "`%s` can't be made", path);
    }
    cJSON_free(text);
    cJSON_Delete(root);
    return good;
}

// --- Checking ------------------------------------------------------------------------------------

void record_checker_free(RecordChecker *checker)
{
    array_free(&checker->known.items);
    arena_free(&checker->arena);
}

// The hash that the file has now; it is read once a run.
static bool hash_now(RecordChecker *checker, const char *name, uint64_t *hash)
{
    for (size_t i = 0; i < checker->known.items.count; ++i) {
        if (strcmp(checker->known.items.items[i].name, name) == 0) {
            *hash = checker->known.items.items[i].hash;
            return true;
        }
    }
    FileBytes bytes;
    const char *kept = arena_copy_string(&checker->arena, name, strlen(name));
    const char *path =
        name[0] == '/' ? kept : arena_printf(&checker->arena, "%s%s", checker->base, name);
    if (!kept || !path || sandbox_read(checker->sandbox, path, &bytes) != IO_OK) {
        return false;
    }
    *hash = sandbox_content_hash(path, &bytes);
    file_bytes_free(&bytes);
    return array_push(&checker->known.items, (RecordedFile){kept, *hash});
}

static bool files_are_the_same(RecordChecker *checker, const cJSON *files)
{
    const cJSON *file;
    cJSON_ArrayForEach(file, files)
    {
        uint64_t hash;
        char text[HASH_SIZE];
        if (!cJSON_IsString(file) || !hash_now(checker, file->string, &hash)) {
            return false;
        }
        hash_text(hash, text);
        if (strcmp(text, file->valuestring) != 0) {
            return false;
        }
    }
    return cJSON_IsObject(files) && files->child; // the scene, at least
}

static bool pictures_are_the_same(const Record *record, const cJSON *pictures)
{
    for (size_t i = 0; i < record->picture_count; ++i) {
        const cJSON *there = cJSON_GetObjectItemCaseSensitive(pictures, record->pictures[i]);
        char hash[HASH_SIZE];
        if (!cJSON_IsString(there) || !hash_of_picture(record, i, hash) ||
            strcmp(hash, there->valuestring) != 0) {
            return false;
        }
    }
    return true;
}

bool record_fits(RecordChecker *checker, const char *path, const Record *record)
{
    FileBytes bytes;
    if (file_read(path, MOST_RECORD_BYTES, &bytes) != IO_OK) {
        return false;
    }
    cJSON *root = cJSON_ParseWithLength(bytes.bytes, bytes.size);
    const cJSON *settings = cJSON_GetObjectItemCaseSensitive(root, "settings");
    const bool fits =
        cJSON_IsString(settings) && strcmp(settings->valuestring, record->settings) == 0 &&
        files_are_the_same(checker, cJSON_GetObjectItemCaseSensitive(root, "files")) &&
        pictures_are_the_same(record, cJSON_GetObjectItemCaseSensitive(root, "pictures"));
    cJSON_Delete(root);
    file_bytes_free(&bytes);
    return fits;
}
