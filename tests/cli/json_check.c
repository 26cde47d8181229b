// Succeeds if the standard input is JSON; with "lines", if every line of it is, and there is one.
#include <cjson/cJSON.h>

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_json(const char *text)
{
    const char *end = NULL;
    cJSON *json = cJSON_ParseWithOpts(text, &end, 1);
    cJSON_Delete(json);
    return json != NULL;
}

int main(int argc, char **argv)
{
    size_t size = 0, capacity = 1 << 16;
    char *text = malloc(capacity);
    for (size_t got; text && (got = fread(text + size, 1, capacity - size - 1, stdin)) > 0;) {
        size += got;
        if (capacity - size < 2) {
            text = realloc(text, capacity *= 2);
        }
    }
    if (!text) {
        return 2;
    }
    text[size] = '\0';
    bool good = size > 0;
    if (argc > 1 && strcmp(argv[1], "lines") == 0) {
        for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n")) {
            good &= is_json(line);
        }
    } else {
        good &= is_json(text);
    }
    free(text);
    return good ? 0 : 1;
}
