// A scene's text through the whole language: lexer, parser, resolver, evaluator, the kinds' own
// checks and their defaults. Whatever the bytes: a scene, or diagnostics that lie in the text; and
// never more steps, memory or objects than the limits say. Nor does it matter whether statements
// are evaluated while the text is read.
#include "scene/dump.h"
#include "scene_text.h"

#include <stdlib.h>

static bool lies_inside(const Lang *lang, Span at)
{
    const Source *source = source_get(&lang->sources, at.file);
    return at.file == 0 || (source && at.begin <= at.end && at.end <= source->text.length);
}

static void check(const Lang *lang, const Scene *scene, bool good)
{
    const DiagSink *sink = &lang->sink;
    fuzz_require(good == (sink->errors == 0), "success if and only if no error was reported");
    fuzz_require(sink->count <= lang->limits.diagnostics, "no more diagnostics than allowed");
    for (uint32_t i = 0; i < sink->count; ++i) {
        const Diag *diag = &sink->items[i];
        fuzz_require(lies_inside(lang, diag->at), "a diagnostic lies in its text");
        fuzz_require(!diag->fix_text || lies_inside(lang, diag->fix_at), "so does a fix");
    }
    size_t nodes = scene->instances.count + scene->nodes[CATEGORY_SHAPE].count +
                   scene->nodes[CATEGORY_LIGHT].count;
    fuzz_require(!good || nodes <= 2 * lang->limits.objects, "no more objects than allowed");
}

typedef struct Told {
    char *text;
    size_t size;
} Told;

// The diagnostics, and the scene where there is one.
static Told tell(SceneText *text)
{
    Told told;
    FILE *out = open_memstream(&told.text, &told.size);
    fuzz_require(out != NULL, "there is memory");
    diag_write_text(&text->lang.sink, &text->lang.sources, out, DIAG_PLAIN);
    if (text->good) {
        scene_dump_json(&text->scene, &text->lang.sources, out);
    }
    fclose(out);
    return told;
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    SceneText text;
    Told told[2];
    for (int whole = 0; whole < 2; ++whole) {
        scene_text_load(&text, bytes, size, whole);
        check(&text.lang, &text.scene, text.good);
        told[whole] = tell(&text);
        scene_text_end(&text);
    }
    fuzz_require(told[0].size == told[1].size &&
                     memcmp(told[0].text, told[1].text, told[0].size) == 0,
                 "it doesn't matter when statements are evaluated");
    free(told[0].text);
    free(told[1].text);
    return 0;
}
