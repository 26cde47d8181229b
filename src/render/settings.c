// The `film`, `render` and `test` kinds.
#include "render/filter.h"
#include "render/meter.h"
#include "render/render.h"

// The defaults that a scene without these settings gets, too; written once.
#define TEXT(x)                 TEXT_OF(x)
#define TEXT_OF(x)              #x
#define DEFAULT_WIDTH           960
#define DEFAULT_HEIGHT          540
#define DEFAULT_EXPOSURE        0
#define DEFAULT_SAMPLES         64
#define DEFAULT_BOUNCES         12
#define DEFAULT_SEED            0
#define DEFAULT_CONFIDENCE      0.999
#define DEFAULT_TEST_SAMPLES    16777216
#define DEFAULT_STOP_CONFIDENCE 0.95
enum { DEFAULT_FILTER = FILTER_BLACKMAN_HARRIS, DEFAULT_TONE = TONE_SRGB };

static const char *const filters[] = {"box", "tent", "gaussian", "blackman_harris", "center", NULL};
static const char *const ways_to_caustics[] = {"plain", "guided", "traced", NULL};
static const char *const samplings[] = {"mis", "light", "bsdf", NULL};
static const char *const integrators[] = {
#define INTEGRATOR(id) #id,
#include "render/nodes.def"
    NULL,
};

enum { FILM_AOVS = 7 };

static const Param film_params[] = {
    {.name = "width",
     .type = PARAM_INT,
     PARAM_AT(FilmParams, width),
     .min = 1,
     .max = 1 << 20,
     .default_text = TEXT(DEFAULT_WIDTH),
     .doc = "pixels from left to right"},
    {.name = "height",
     .type = PARAM_INT,
     PARAM_AT(FilmParams, height),
     .min = 1,
     .max = 1 << 20,
     .default_text = TEXT(DEFAULT_HEIGHT),
     .doc = "pixels from top to bottom"},
    {.name = "filter",
     .type = PARAM_CHOICE,
     PARAM_AT(FilmParams, filter),
     .choices = filters,
     .default_text = "\"blackman_harris\"",
     .doc = "how a pixel weighs the light around its centre"},
    {.name = "filter_width",
     .type = PARAM_NUMBER,
     PARAM_AT(FilmParams, filter_width),
     .min = 0,
     .max = 32,
     .flags = PARAM_NO_DEFAULT | PARAM_EXCLUDE_MIN,
     .doc =
         "of the whole filter, in pixels; its own: box 1, tent 2, gaussian and blackman_harris 3; "
         "center has none"},
    {.name = "exposure",
     .type = PARAM_NUMBER,
     PARAM_AT(FilmParams, exposure),
     .min = -100,
     .max = 100,
     .default_text = TEXT(DEFAULT_EXPOSURE),
     .doc = "stops: 1 shows the picture twice as bright; not for linear files such as EXR"},
    {.name = "tone",
     .type = PARAM_CHOICE,
     PARAM_AT(FilmParams, tone),
     .choices = tone_names,
     .default_text = "\"srgb\"",
     .doc = "the curve from light to a display's values; not for linear files such as EXR"},
    {.name = "file",
     .type = PARAM_STRING,
     PARAM_AT(FilmParams, file),
     .flags = PARAM_NO_DEFAULT,
     .doc = "name of the picture, where the command line gives none"},
    [FILM_AOVS] = {.name = "aovs",
                   .type = PARAM_STRING_LIST,
                   PARAM_AT(FilmParams, aovs),
                   .default_text = "[]",
                   .doc = "further layers of an EXR: albedo, normal, depth, position, object_id, "
                          "material_id, variance, alpha"},
};

static bool film_finish(NodeFinish *finish)
{
    const FilmParams *film = finish->params;
    bool ok = true;
    for (uint32_t i = 0; i < film->aovs.count; ++i) {
        const Str name = str_from(film->aovs.items[i]);
        if (film_find_aov(name) >= 0) {
            continue;
        }
        Diag *diag =
            finish->report(finish, FILM_AOVS, E0926, "`%s` is not a layer that can be rendered",
                           film->aovs.items[i]);
        diag_note(finish->sink, diag,
                  "layers are albedo, normal, depth, position, object_id, material_id, variance, "
                  "alpha");
        ok = false;
    }
    return ok;
}

const NodeType film_kind = {
    .name = "film",
    .category = CATEGORY_SETTING,
    .params = film_params,
    .param_count = sizeof film_params / sizeof *film_params,
    .size = sizeof(FilmParams),
    .doc = "The picture: its size, how pixels are filtered, and how light becomes what a display "
           "shows.",
    .formula =
        "Filters: box; tent 1 - |2x/w|; gaussian exp(-18 (x/w)^2); blackman_harris, the four-term "
        "window (Harris 1978); w is filter_width; center sends every sample through the pixel's "
        "centre, for pictures that are compared pixel by pixel. Tone curves: srgb clips to [0, 1]; "
        "linear clips "
        "and isn't encoded; aces is Stephen Hill's fit of the ACES RRT and sRGB ODT; filmic is "
        "Hable "
        "2010 (Uncharted 2) with white at 11.2. All but linear end with the sRGB transfer "
        "function.",
    .example =
        "film { width: 480, height: 300, exposure: 0.5, tone: \"filmic\", filter: \"gaussian\" }\n"
        "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: (0, 0, 1.5) }, "
        "radiance: 12 }\n"
        "environment_light { radiance: gradient { colors: [#50483f, #dce8ff], space: \"uv\" } }\n"
        "plane { material: lambert { color: gray(0.5) } }\n"
        "for (i in 0..2) {\n"
        "  sphere {\n"
        "    center: (1.05 * (i - 1), 0.5, 0)\n"
        "    radius: 0.5\n"
        "    material: ggx { f0: hsv(40deg * i, 0.5, 0.9), alpha: 0.3 }\n"
        "  }\n"
        "}",
    .finish = film_finish,
};

enum { RENDER_SAMPLES = 1 };

static const Param render_params[] = {
    {.name = "integrator",
     .type = PARAM_CHOICE,
     PARAM_AT(RenderParams, integrator),
     .choices = integrators,
     .default_text = "\"path\"",
     .doc =
         "what finds the light along a ray: each is explained by `scnrender explain NAME` and in "
         "the manual's chapter on integrators"},
    [RENDER_SAMPLES] =
        {.name = "samples",
         .type = PARAM_INT,
         PARAM_AT(RenderParams, samples),
         .min = 1,
         .max = 1 << 30,
         .default_text = TEXT(DEFAULT_SAMPLES),
         .doc = "of each pixel; the most of them where `stop` or `time_limit` is given, and then "
                "65536 by default"},
    {.name = "bounces",
     .type = PARAM_INT,
     PARAM_AT(RenderParams, bounces),
     .min = 0,
     .max = 1 << 16,
     .default_text = TEXT(DEFAULT_BOUNCES),
     .doc = "most scattering events of a path: 0 sees lights only, 1 is direct light"},
    {.name = "seed",
     .type = PARAM_INT,
     PARAM_AT(RenderParams, seed),
     .min = 0,
     .max = UINT32_MAX,
     .default_text = TEXT(DEFAULT_SEED),
     .doc = "another seed gives other noise; the same one the same bytes"},
    {.name = "sampling",
     .type = PARAM_CHOICE,
     PARAM_AT(RenderParams, sampling),
     .choices = samplings,
     .default_text = "\"mis\"",
     .doc =
         "how light is looked for: towards lights, where the material scatters, or both, weighted "
         "(mis); all have the same mean"},
    {.name = "shadows",
     .type = PARAM_BOOL,
     PARAM_AT(RenderParams, shadows),
     .default_text = "true",
     .doc = "whether things cast shadows; for the \"local\" integrator"},
    {.name = "russian_roulette",
     .type = PARAM_BOOL,
     PARAM_AT(RenderParams, russian_roulette),
     .default_text = "true",
     .doc = "whether faint paths are ended at random; the mean stays the same"},
    {.name = "caustics",
     .type = PARAM_CHOICE,
     PARAM_AT(RenderParams, caustics),
     .choices = ways_to_caustics,
     .default_text = "\"plain\"",
     .doc = "how the \"path\" integrator finds light that mirrors and glass throw on something "
            "matt: by luck (plain), also where rays sent from the lamps say that it comes from "
            "(guided), or, but for what is seen in mirrors and glass, by following light from the "
            "lamps (traced); the mean stays the same, but that traced also finds the caustics of "
            "lamps without a size"},
    {.name = "ao_distance",
     .type = PARAM_NUMBER,
     PARAM_AT(RenderParams, ao_distance),
     .dims = DIM_BIT(DIM_LENGTH),
     .min = 0,
     .max = INFINITY,
     .flags = PARAM_NO_DEFAULT | PARAM_EXCLUDE_MIN,
     .doc = "how far the \"ambient_occlusion\" integrator looks for what hides the surroundings; "
            "without it, any distance"},
    {.name = "clamp",
     .type = PARAM_NUMBER,
     PARAM_AT(RenderParams, clamp),
     .min = 0,
     .max = INFINITY,
     .flags = PARAM_NO_DEFAULT | PARAM_EXCLUDE_MIN,
     .doc = "largest radiance that a sample of indirect light may bring; makes fireflies, and the "
            "mean, darker"},
    {.name = "stop",
     .type = PARAM_NODE,
     PARAM_AT(RenderParams, stop),
     .category = CATEGORY_RULE,
     .flags = PARAM_NO_DEFAULT,
     .doc =
         "when a part of the picture is good enough, so that it gets no more samples; without it "
         "all pixels get the same number"},
    {.name = "time_limit",
     .type = PARAM_NUMBER,
     PARAM_AT(RenderParams, time_limit),
     .dims = DIM_BIT(DIM_TIME),
     .min = 0,
     .max = INFINITY,
     .flags = PARAM_NO_DEFAULT | PARAM_EXCLUDE_MIN,
     .doc = "how long to render; what is done then is the picture, whose bytes depend on the "
            "machine's speed"},
};

static bool render_finish(NodeFinish *finish)
{
    RenderParams *render = finish->params;
    render->samples_given = (finish->set & UINT64_C(1) << RENDER_SAMPLES) != 0;
    return true;
}

const NodeType render_kind = {
    .name = "render",
    .category = CATEGORY_SETTING,
    .params = render_params,
    .param_count = sizeof render_params / sizeof *render_params,
    .size = sizeof(RenderParams),
    .doc = "How the picture is computed.",
    .example = "render { samples: 256, bounces: 8, seed: 7 }\n"
               "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
               "rectangle {\n"
               "  corner: (-2, 0, 2)\n"
               "  u: (4, 0, 0)\n"
               "  v: (0, 0, -3)\n"
               "  material: lambert { color: gray(0.7) }\n"
               "}\n"
               "rectangle { corner: (-2, 0, -1), u: (4, 0, 0), v: (0, 3, 0), material: lambert { "
               "color: #b04030 } }\n"
               "area_light { shape: rectangle { corner: (-1, 2.4, -0.5), u: (2, 0, 0), v: (0, 0, "
               "1) }, radiance: 5 }\n"
               "sphere { center: (0, 0.5, 0), radius: 0.5, material: fresnel { ior: 1.5 } }",
    .finish = render_finish,
};

static const Param test_params[] = {
    {.name = "confidence",
     .type = PARAM_NUMBER,
     PARAM_AT(TestParams, confidence),
     .min = 0.5,
     .max = 1,
     .flags = PARAM_EXCLUDE_MAX,
     .default_text = TEXT(DEFAULT_CONFIDENCE),
     .doc = "the chance that a verdict on a measured expectation is right, at least"},
    {.name = "samples",
     .type = PARAM_INT,
     PARAM_AT(TestParams, samples),
     .min = 1,
     .max = 1e12,
     .default_text = TEXT(DEFAULT_TEST_SAMPLES),
     .doc = "rays from the camera that a measured expectation may take at most; 8192 are the "
            "fewest"},
};

const NodeType test_kind = {
    .name = "test",
    .category = CATEGORY_SETTING,
    .params = test_params,
    .param_count = sizeof test_params / sizeof *test_params,
    .size = sizeof(TestParams),
    .doc = "How `scnrender test` measures what the scene expects of its light.",
    .formula = "Samples are doubled until the confidence interval of the mean lies wholly on one "
               "side of what is expected: Student's t over 32 independent randomizations of the "
               "sampler, with Bonferroni's correction for the looks and channels.",
    .example = "// Under an even sky a matt ball that stands alone sends back its color, whatever "
               "its shape.\n"
               "film { width: 240, height: 150 }\n"
               "test { confidence: 0.9999, samples: 1e6 }\n"
               "camera { position: (0, 0, 4), look_at: (0, 0, 0), fov: 30deg }\n"
               "environment_light { radiance: 1 }\n"
               "for (i in 0..2) {\n"
               "  sphere {\n"
               "    center: (1.2 * (i - 1), 0, 0)\n"
               "    radius: 0.4\n"
               "    material: lambert { color: gray(0.2 + 0.3 * i) }\n"
               "  }\n"
               "}\n"
               "expect radiance(region((115, 70), (125, 80))) within 1% of 0.5\n"
               "expect radiance(region((30, 70), (40, 80))) within 1% of 0.2",
};

TestParams scene_test(const Scene *scene)
{
    const TestParams *own = scene_setting(scene, "test");
    return own ? *own
               : (TestParams){.confidence = DEFAULT_CONFIDENCE, .samples = DEFAULT_TEST_SAMPLES};
}

static const Param until_params[] = {
    {.name = "error",
     .type = PARAM_NUMBER,
     PARAM_AT(StopRule, error),
     .min = 0,
     .max = INFINITY,
     .flags = PARAM_REQUIRED | PARAM_EXCLUDE_MIN,
     .doc = "how far pixels may lie from the truth, as a part of the light around them: 0.02 is 2 "
            "%"},
    {.name = "confidence",
     .type = PARAM_NUMBER,
     PARAM_AT(StopRule, confidence),
     .min = 0,
     .max = 1,
     .flags = PARAM_EXCLUDE_MIN | PARAM_EXCLUDE_MAX,
     .default_text = TEXT(DEFAULT_STOP_CONFIDENCE),
     .doc = "how sure of that to be"},
};

const NodeType until_kind = {
    .name = "until",
    .category = CATEGORY_RULE,
    .params = until_params,
    .param_count = sizeof until_params / sizeof *until_params,
    .size = sizeof(StopRule),
    .doc = "Cells of 8 x 8 pixels get samples until their error is small enough, or `samples` are "
           "reached. The picture's mean stays right: the samples that decide how many are averaged "
           "are never the averaged ones.",
    .formula =
        "A cell is done when z sqrt(mean variance of its pixels' luminance) <= error max(mean "
        "luminance of the cell, a tenth of the picture's); z is the normal distribution's, 1.96 "
        "for "
        "0.95. Two independent streams sample each pixel, each decides for the other, and the "
        "pixel "
        "is the even mean of the two (after Kirk and Arvo 1991, Unbiased Sampling Techniques for "
        "Image Synthesis).",
    .example =
        "// The lamp's soft shadow needs many samples, the open floor few.\n"
        "render { samples: 4096, stop: until { error: 0.05, confidence: 0.95 }, time_limit: 60s }\n"
        "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
        "area_light { shape: rectangle { corner: (-2, 3, 0), u: (1.5, 0, 0), v: (0, 0, 1.5) }, "
        "radiance: 12 }\n"
        "plane { material: lambert { color: gray(0.6) } }\n"
        "for (i in 0..2) {\n"
        "  sphere {\n"
        "    center: (1.05 * (i - 1), 0.5, 0), radius: 0.5\n"
        "    material: burley { color: hsv(50deg * i, 0.6, 0.7) }\n"
        "  }\n"
        "}",
};

const StopRule *scene_stop_rule(const Scene *scene, const RenderParams *render)
{
    return render->stop == NONE_ID
               ? NULL
               : scene_params(scene, scene_node(scene, CATEGORY_RULE, render->stop));
}

FilmParams scene_film(const Scene *scene)
{
    const FilmParams *own = scene_setting(scene, "film");
    if (own) {
        return *own;
    }
    return (FilmParams){
        .width = DEFAULT_WIDTH,
        .height = DEFAULT_HEIGHT,
        .filter = DEFAULT_FILTER,
        .exposure = DEFAULT_EXPOSURE,
        .tone = DEFAULT_TONE,
    };
}

static int32_t default_integrator(void)
{
    for (int32_t i = 0; integrators[i]; ++i) {
        if (str_equal(str_from(integrators[i]), STR("path"))) {
            return i;
        }
    }
    return 0;
}

RenderParams scene_render(const Scene *scene)
{
    const RenderParams *own = scene_setting(scene, "render");
    if (own) {
        return *own;
    }
    return (RenderParams){
        .integrator = default_integrator(),
        .samples = DEFAULT_SAMPLES,
        .bounces = DEFAULT_BOUNCES,
        .seed = DEFAULT_SEED,
        .sampling = SAMPLING_MIS,
        .shadows = true,
        .russian_roulette = true,
        .caustics = CAUSTICS_PLAIN,
        .stop = NONE_ID,
    };
}
