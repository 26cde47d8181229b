// A text taken through the whole language under small limits, for the targets that want a scene.
#ifndef TESTS_SCENE_TEXT_H
#define TESTS_SCENE_TEXT_H

#include "base/mem.h"
#include "fuzz.h"
#include "lang/lang.h"
#include "render/render.h"

#include <string.h>

typedef struct SceneText {
    Lang lang;
    Scene scene;
    ParamSetting setting;
    uint64_t live; // blocks of memory before
    bool good;
} SceneText;

// Small enough that nothing that a scene may ask for takes long.
static inline Limits small_limits(void)
{
    Limits limits = limits_default();
    limits.call_depth = 100;
    limits.import_depth = 4;
    limits.list_length = 3000;
    limits.objects = 1000;
    limits.steps = 10000;
    limits.memory = 16 << 20;
    limits.pixels = 1 << 20;
    limits.diagnostics = 50;
    return limits;
}

// A folder with files to import, to read meshes and lamps from.
static inline Sandbox *fuzz_sandbox(void)
{
    static Sandbox sandbox;
    if (sandbox.root_count == 0) {
        sandbox_init(&sandbox);
        sandbox.max_file_bytes = 1 << 16;
        fuzz_require(sandbox_allow(&sandbox, SCN_SOURCE_DIR "/tests/fuzz/files") == IO_OK,
                     "the folder with files to import is there");
    }
    return &sandbox;
}

// A first line "//set name=value" is a setting, as --set gives one.
static inline bool take_setting(const char *bytes, size_t size, ParamSetting *out)
{
    static const char mark[] = "//set ";
    const size_t length = sizeof mark - 1;
    if (size < length || memcmp(bytes, mark, length) != 0) {
        return false;
    }
    const char *line_end = memchr(bytes, '\n', size), *end = line_end ? line_end : bytes + size;
    const char *name = bytes + length, *equals = memchr(name, '=', (size_t)(end - name));
    if (!equals) {
        return false;
    }
    *out =
        (ParamSetting){{name, (size_t)(equals - name)}, {equals + 1, (size_t)(end - equals - 1)}};
    return true;
}

// `whole`: nothing is evaluated before all was read.
static inline void scene_text_load(SceneText *text, const uint8_t *bytes, size_t size, bool whole)
{
    const Schema *schema = render_schema();
    Sandbox *sandbox = fuzz_sandbox();
    text->live = mem_live_count();
    fuzz_require(lang_init(&text->lang, schema, sandbox) &&
                     scene_init(&text->scene, schema, sandbox),
                 "beginning takes little memory");
    text->lang.whole = whole;
    text->lang.limits = small_limits();
    text->lang.sink.limit = (uint32_t)text->lang.limits.diagnostics;
    if (take_setting((const char *)bytes, size, &text->setting)) {
        text->lang.settings = &text->setting;
        text->lang.setting_count = 1;
    }
    text->good =
        lang_load_text(&text->lang, (Str){(const char *)bytes, size},
                       SCN_SOURCE_DIR "/tests/fuzz/files/input.scn", "input.scn", &text->scene);
}

static inline void scene_text_begin(SceneText *text, const uint8_t *bytes, size_t size)
{
    scene_text_load(text, bytes, size, false);
}

static inline void scene_text_end(SceneText *text)
{
    scene_free(&text->scene);
    lang_free(&text->lang);
    fuzz_require(mem_live_count() == text->live, "all memory is given back");
}

#endif
