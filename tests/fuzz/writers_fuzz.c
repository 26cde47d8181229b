// All that is written of a scene: its diagnostics as text and as JSON, and the scene as JSON and
// for other programs. What calls itself JSON is read by cJSON; text that goes to a terminal is
// UTF-8 without control characters; a string and a number read back as what they were.
#include "scene_text.h"

#include "base/utf8.h"
#include "export/export.h"
#include "scene/dump.h"
#include "scene/json.h"

#include <cjson/cJSON.h>
#include <math.h>

typedef struct Written {
    char *text;
    size_t size;
    FILE *out;
} Written;

static FILE *begin(Written *written)
{
    *written = (Written){0};
    written->out = open_memstream(&written->text, &written->size);
    fuzz_require(written->out != NULL, "there is memory for what is written");
    return written->out;
}

static void finish(Written *written)
{
    fclose(written->out);
    free(written->text);
}

static cJSON *parsed(Written *written)
{
    fflush(written->out);
    const char *end = NULL;
    cJSON *json = cJSON_ParseWithOpts(written->text, &end, 1);
    fuzz_require(json != NULL, "JSON that cJSON reads");
    return json;
}

static bool is_utf8(const char *text, const char *end)
{
    for (uint32_t code; text < end; text += utf8_decode(text, end, &code)) {
        utf8_decode(text, end, &code);
        if (code == UTF8_INVALID) {
            return false;
        }
    }
    return true;
}

// --- Values --------------------------------------------------------------------------------------

static void check_string(const char *text)
{
    Written written;
    json_string(begin(&written), text);
    cJSON *json = parsed(&written);
    fuzz_require(cJSON_IsString(json), "a string");
    fuzz_require(!is_utf8(text, text + strlen(text)) || strcmp(json->valuestring, text) == 0,
                 "the same string");
    cJSON_Delete(json);
    finish(&written);
}

static void check_number(double value)
{
    Written written;
    json_number(begin(&written), value);
    cJSON *json = parsed(&written);
    fuzz_require(!isfinite(value) || (cJSON_IsNumber(json) && json->valuedouble == value),
                 "the same number");
    cJSON_Delete(json);
    finish(&written);
}

static void check_values(const uint8_t *bytes, size_t size)
{
    char text[256];
    size_t length = size < sizeof text - 1 ? size : sizeof text - 1;
    memcpy(text, bytes, length);
    text[length] = '\0';
    check_string(text);
    double number;
    if (size >= sizeof number) {
        memcpy(&number, bytes, sizeof number);
        check_number(number);
    }
}

// --- Diagnostics and scenes ----------------------------------------------------------------------

static void check_terminal(const Written *written)
{
    const char *at = written->text, *end = at + written->size;
    while (at < end) {
        uint32_t code;
        at += utf8_decode(at, end, &code);
        fuzz_require(code != UTF8_INVALID, "UTF-8");
        fuzz_require((code >= 0x20 && code != 0x7f && (code < 0x80 || code > 0x9f)) || code == '\n',
                     "no control characters");
    }
}

static void check_diagnostics(SceneText *scene)
{
    Written written;
    diag_write_text(&scene->lang.sink, &scene->lang.sources, begin(&written), DIAG_PLAIN);
    fflush(written.out);
    check_terminal(&written);
    finish(&written);
    diag_write_json(&scene->lang.sink, &scene->lang.sources, begin(&written));
    fflush(written.out);
    uint32_t lines = 0;
    for (char *rest = written.text, *line; (line = strtok_r(rest, "\n", &rest)) != NULL; ++lines) {
        cJSON *json = cJSON_Parse(line);
        fuzz_require(cJSON_IsObject(json), "a JSON object a line");
        cJSON_Delete(json);
    }
    fuzz_require(lines == scene->lang.sink.count, "a line for each diagnostic");
    finish(&written);
}

static void check_scene(SceneText *scene)
{
    Written written;
    bool good = scene_dump_json(&scene->scene, &scene->lang.sources, begin(&written));
    fuzz_require(good, "no write error");
    cJSON_Delete(parsed(&written));
    finish(&written);
    for (const ExportTarget *target = export_targets; target->name; ++target) {
        ExportNotes notes = {0};
        if (export_check(target, &scene->scene, &scene->lang.sources, &notes)) {
            export_write(target, &scene->scene, &scene->lang.sources, "input", &notes,
                         begin(&written));
            finish(&written);
        }
        export_notes_free(&notes);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    check_values(bytes, size);
    SceneText text;
    scene_text_begin(&text, bytes, size);
    check_diagnostics(&text);
    if (text.good) {
        check_scene(&text);
    }
    scene_text_end(&text);
    return 0;
}
