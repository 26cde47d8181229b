// Holds JSON from the standard input to a JSON Schema: schema_check SCHEMA.json
// Knows what docs/scene.schema.json uses: type, enum, properties, required, additionalProperties,
// items, minItems, maxItems, anyOf and $ref into $defs; any other word of a schema is an error.
#include <cjson/cJSON.h>

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const KNOWN[] = {"$schema",     "$defs",    "title",
                                    "description", "type",     "enum",
                                    "properties",  "required", "additionalProperties",
                                    "items",       "minItems", "maxItems",
                                    "anyOf",       "$ref",     NULL};

typedef struct Check {
    const cJSON *root;
    bool loud;
} Check;

static bool fail(const Check *check, const char *what, const char *name)
{
    if (check->loud) {
        fprintf(stderr, "%s: %s\n", what, name ? name : "");
    }
    return false;
}

static bool has_type(const cJSON *value, const char *type)
{
    return strcmp(type, "object") == 0    ? cJSON_IsObject(value)
           : strcmp(type, "array") == 0   ? cJSON_IsArray(value)
           : strcmp(type, "string") == 0  ? cJSON_IsString(value)
           : strcmp(type, "boolean") == 0 ? cJSON_IsBool(value)
           : strcmp(type, "null") == 0    ? cJSON_IsNull(value)
           : strcmp(type, "number") == 0  ? cJSON_IsNumber(value)
           : strcmp(type, "integer") == 0
               ? cJSON_IsNumber(value) && value->valuedouble == (double)(long)value->valuedouble
               : false;
}

static bool valid(const Check *check, const cJSON *schema, const cJSON *value);

static bool known_words(const Check *check, const cJSON *schema)
{
    for (const cJSON *word = schema->child; word; word = word->next) {
        int i = 0;
        while (KNOWN[i] && strcmp(KNOWN[i], word->string) != 0) {
            ++i;
        }
        if (!KNOWN[i]) {
            fprintf(stderr, "the schema says `%s`, which this check doesn't know\n", word->string);
            return fail(check, "schema", word->string);
        }
    }
    return true;
}

static bool valid_object(const Check *check, const cJSON *schema, const cJSON *value)
{
    const cJSON *properties = cJSON_GetObjectItemCaseSensitive(schema, "properties"), *name;
    const cJSON *more = cJSON_GetObjectItemCaseSensitive(schema, "additionalProperties");
    cJSON_ArrayForEach(name, cJSON_GetObjectItemCaseSensitive(schema, "required"))
    {
        if (!cJSON_GetObjectItemCaseSensitive(value, name->valuestring)) {
            return fail(check, "is missing", name->valuestring);
        }
    }
    for (const cJSON *item = value->child; item; item = item->next) {
        const cJSON *own = cJSON_GetObjectItemCaseSensitive(properties, item->string);
        own = own ? own : more;
        if (own && (cJSON_IsFalse(own) || (cJSON_IsObject(own) && !valid(check, own, item)))) {
            return fail(check, "in", item->string);
        }
    }
    return true;
}

static bool valid_array(const Check *check, const cJSON *schema, const cJSON *value)
{
    const cJSON *least = cJSON_GetObjectItemCaseSensitive(schema, "minItems");
    const cJSON *most = cJSON_GetObjectItemCaseSensitive(schema, "maxItems");
    const cJSON *items = cJSON_GetObjectItemCaseSensitive(schema, "items");
    int count = cJSON_GetArraySize(value);
    if ((least && count < least->valueint) || (most && count > most->valueint)) {
        return fail(check, "wrong number of items", NULL);
    }
    for (const cJSON *item = value->child; items && item; item = item->next) {
        if (!valid(check, items, item)) {
            return fail(check, "in an item", NULL);
        }
    }
    return true;
}

static bool one_of(const Check *check, const cJSON *list, const cJSON *value, bool schemas)
{
    const Check quiet = {check->root, false};
    const cJSON *item;
    cJSON_ArrayForEach(item, list)
    {
        if (schemas ? valid(&quiet, item, value) : cJSON_Compare(item, value, 1)) {
            return true;
        }
    }
    return fail(check, "is none of what may stand there", value->string);
}

static bool valid(const Check *check, const cJSON *schema, const cJSON *value)
{
    const cJSON *ref = cJSON_GetObjectItemCaseSensitive(schema, "$ref");
    const cJSON *type = cJSON_GetObjectItemCaseSensitive(schema, "type");
    const cJSON *any = cJSON_GetObjectItemCaseSensitive(schema, "anyOf");
    const cJSON *values = cJSON_GetObjectItemCaseSensitive(schema, "enum");
    if (!known_words(check, schema)) {
        return false;
    }
    if (ref) {
        const cJSON *all = cJSON_GetObjectItemCaseSensitive(check->root, "$defs");
        const cJSON *other =
            cJSON_GetObjectItemCaseSensitive(all, ref->valuestring + strlen("#/$defs/"));
        return other ? valid(check, other, value) : fail(check, "no such $ref", ref->valuestring);
    }
    if (type && !has_type(value, type->valuestring)) {
        return fail(check, "isn't of type", type->valuestring);
    }
    if ((any && !one_of(check, any, value, true)) ||
        (values && !one_of(check, values, value, false))) {
        return false;
    }
    if (cJSON_IsObject(value) && !valid_object(check, schema, value)) {
        return false;
    }
    return !cJSON_IsArray(value) || valid_array(check, schema, value);
}

static cJSON *read_json(FILE *in)
{
    size_t size = 0, capacity = 1 << 20;
    char *text = malloc(capacity);
    for (size_t got; in && text && (got = fread(text + size, 1, capacity - size - 1, in)) > 0;) {
        size += got;
        if (capacity - size < 2) {
            text = realloc(text, capacity *= 2);
        }
    }
    cJSON *json = text ? cJSON_ParseWithLength(text, size) : NULL;
    free(text);
    return json;
}

int main(int argc, char **argv)
{
    FILE *file = argc > 1 ? fopen(argv[1], "r") : NULL;
    cJSON *schema = read_json(file), *value = read_json(stdin);
    const Check check = {schema, true};
    bool good = schema && value && valid(&check, schema, value);
    if (!schema || !value) {
        fprintf(stderr, "%s isn't JSON\n", schema ? "the standard input" : "the schema");
    }
    if (file) {
        fclose(file);
    }
    cJSON_Delete(schema);
    cJSON_Delete(value);
    return good ? 0 : 1;
}
