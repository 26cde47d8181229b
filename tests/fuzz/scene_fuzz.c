// A scene's text through the whole language: lexer, parser, resolver, evaluator, the kinds' own
// checks and their defaults. Whatever the bytes: a scene, or diagnostics that lie in the text; and
// never more steps, memory or objects than the limits say.
#include "scene_text.h"

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

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    SceneText text;
    scene_text_begin(&text, bytes, size);
    check(&text.lang, &text.scene, text.good);
    scene_text_end(&text);
    return 0;
}
