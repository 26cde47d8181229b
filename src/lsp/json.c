#include "lsp/json.h"

#include "base/mem.h"
#include "base/utf8.h"

#include <stdlib.h>

const cJSON *json_at(const cJSON *object, const char *path)
{
    char name[64];
    while (object) {
        size_t length = strcspn(path, ".");
        if (length >= sizeof name) {
            return NULL;
        }
        memcpy(name, path, length);
        name[length] = '\0';
        object = cJSON_GetObjectItemCaseSensitive(object, name);
        if (!path[length]) {
            return object;
        }
        path += length + 1;
    }
    return NULL;
}

const char *json_get_string(const cJSON *object, const char *path)
{
    return cJSON_GetStringValue(json_at(object, path));
}

double json_get_number(const cJSON *object, const char *path, double other)
{
    const cJSON *item = json_at(object, path);
    return cJSON_IsNumber(item) ? item->valuedouble : other;
}

bool json_get_true(const cJSON *object, const char *path)
{
    return cJSON_IsTrue(json_at(object, path));
}

bool json_lists(const cJSON *object, const char *path, const char *string)
{
    const cJSON *item;
    cJSON_ArrayForEach(item, json_at(object, path))
    {
        if (cJSON_IsString(item) && strcmp(item->valuestring, string) == 0) {
            return true;
        }
    }
    return false;
}

cJSON *json_text(Str text)
{
    char *copy = mem_alloc(text.length * 3 + 1, 1), *out = copy;
    if (!copy) {
        return NULL;
    }
    for (const char *at = text.at, *end = text.at + text.length; at < end;) {
        uint32_t code;
        int length = utf8_decode(at, end, &code);
        if (code == UTF8_INVALID || code == 0) {
            out += utf8_encode(0xfffd, out);
        } else {
            memcpy(out, at, (size_t)length);
            out += length;
        }
        at += length;
    }
    *out = '\0';
    cJSON *string = cJSON_CreateString(copy);
    mem_free(copy);
    return string;
}

void json_add_text(cJSON *object, const char *name, Str text)
{
    cJSON_AddItemToObject(object, name, json_text(text));
}

FILE *memo_begin(Memo *memo)
{
    *memo = (Memo){0};
    memo->out = open_memstream(&memo->text, &memo->length);
    return memo->out;
}

Str memo_text(Memo *memo)
{
    if (memo->out) {
        fclose(memo->out);
        memo->out = NULL;
    }
    return (Str){memo->text ? memo->text : "", memo->text ? memo->length : 0};
}

void memo_free(Memo *memo)
{
    memo_text(memo);
    free(memo->text); // open_memstream's
    *memo = (Memo){0};
}
