// Scenes that load are rendered, a few pixels and samples of them: no sample is ever negative or
// not finite, whatever a scene may ask for.
#include "scene_text.h"

// Some scenes take long without being wrong: meshes of many triangles, deep instances.
static bool is_small(const Scene *scene)
{
    return scene->nodes[CATEGORY_SHAPE].count <= 200 && scene->instances.count <= 100 &&
           scene->nodes[CATEGORY_LIGHT].count <= 100;
}

static void render(SceneText *text)
{
    const RenderOptions options = {
        .threads = 1, .width = 5, .height = 4, .samples = 2, .seed = -1, .aovs = true};
    Renderer *renderer = renderer_new(&text->scene, &options, &text->lang.sink);
    RenderStats stats = {0};
    if (renderer && renderer_run(renderer, &stats)) {
        fuzz_require(stats.bad_samples == 0, "every sample is finite and not negative");
    }
    renderer_free(renderer);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    SceneText text;
    scene_text_begin(&text, bytes, size);
    if (text.good && is_small(&text.scene)) {
        render(&text);
    }
    scene_text_end(&text);
    return 0;
}
