// Checkpoints: what is written comes back; what is cut off, changed or of something else is
// refused, whatever byte it is; a renderer that was put away and taken up again, however often,
// makes the bytes of one that never was.
#include "render/resume.h"

#include "../test_support.h"
#include "base/hash.h"
#include "base/io.h"
#include "render/render.h"

#include <limits.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

// --- Files ---------------------------------------------------------------------------------------

static char folder[64];

static char *path_of(const char *name)
{
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static int make_folder(void **state)
{
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/scn_checkpoint_XXXXXX");
    return mkdtemp(folder) ? 0 : 1;
}

static int remove_folder(void **state)
{
    (void)state;
    static const char *const names[] = {"whole", "changed", "fifo", "part"};
    for (size_t i = 0; i < TEST_COUNT(names); ++i) {
        unlink(path_of(names[i]));
    }
    return rmdir(folder);
}

static FileBytes file_of(const char *name)
{
    FileBytes bytes;
    assert_int_equal(file_read(path_of(name), 1 << 24, &bytes), IO_OK);
    return bytes;
}

static void write_file(const char *name, const char *bytes, size_t size)
{
    FILE *file = fopen(path_of(name), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

// Places in a file at which it is changed: all of the head's, and some of the sums'.
static size_t next_place(size_t at)
{
    return at < 330 ? at + 1 : at + 17;
}

// --- The format ----------------------------------------------------------------------------------

static const CheckpointText texts[] = {
    {CHECKPOINT_IDENTITY, "scene", "0123456789abcdef"},
    {CHECKPOINT_IDENTITY, "seed", "7"},
    {CHECKPOINT_NOTE, "scnrender:scene", "a b\n\"c\".scn"},
    {CHECKPOINT_NOTE, "empty", ""},
};

enum { W = 3, H = 2, PART_FIRST = 128, PART_SAMPLES = 100 };

// A part with layers that shares: all five arrays are there.
static void fill_part(Film *film)
{
    assert_true(film_init(film, W, H, PART_FIRST, PART_SAMPLES, true));
    assert_true(film_share(film, 0x1p-30, 2));
    uint32_t next = 1;
    for (size_t p = 0; p < W * H; ++p) {
        for (uint32_t i = 0; i < PART_SAMPLES; ++i) {
            film_pixel_add(&film->pixels[p], rgb((float)next, 2, 3));
            ++next;
            const AovSample aov = {.object = next, .depth = 1.0 / next};
            film_aov_add(&film->aovs[p], &aov);
        }
        film->blocks[p] = film->pixels[p];
        film->aov_blocks[p] = film->aovs[p];
        film->gains[p] = (FilmGain){{next, -(int64_t)next, -(INT64_C(1) << 50)}};
    }
    film->samples_done = PART_SAMPLES;
}

static CheckpointNumbers numbers_of(const Film *film)
{
    return (CheckpointNumbers){.width = W,
                               .height = H,
                               .first_sample = PART_FIRST,
                               .samples = PART_SAMPLES,
                               .whole = PART_FIRST + PART_SAMPLES,
                               .samples_done = film->samples_done,
                               .block_count = film->block_count,
                               .aovs = 1,
                               .rays = UINT64_C(1) << 40,
                               .seconds = 1.25,
                               .quantum = film->quantum,
                               .reach = film->reach};
}

static void write_part(const char *name)
{
    Film film;
    fill_part(&film);
    const CheckpointNumbers numbers = numbers_of(&film);
    FILE *file = fopen(path_of(name), "wb");
    assert_non_null(file);
    checkpoint_write(file, (CheckpointTexts){texts, TEST_COUNT(texts)}, &numbers, &film,
                     (CheckpointMore){0});
    assert_int_equal(fclose(file), 0);
    film_free(&film);
}

// Reads it as a stranger would who knows nothing of it.
static CheckpointResult read_any(const char *name)
{
    char message[512] = "";
    Checkpoint checkpoint;
    CheckpointResult result = checkpoint_open(&checkpoint, path_of(name), message, sizeof message);
    if (result == CHECKPOINT_SOUND) {
        const CheckpointNumbers *n = &checkpoint.numbers;
        Film film;
        assert_true(film_init(&film, n->width, n->height, n->first_sample, n->samples, n->aovs));
        assert_true(n->quantum == 0 || film_share(&film, n->quantum, n->reach));
        result =
            checkpoint_read_film(&checkpoint, &film, (CheckpointMore){0}, message, sizeof message);
        film_free(&film);
        checkpoint_close(&checkpoint);
    }
    if (result != CHECKPOINT_SOUND) {
        assert_true(strlen(message) > 0 && !strchr(message, '\n'));
    }
    return result;
}

static void what_was_written_comes_back(void **state)
{
    (void)state;
    write_part("whole");
    char message[512];
    Checkpoint c;
    assert_int_equal(checkpoint_open(&c, path_of("whole"), message, sizeof message),
                     CHECKPOINT_SOUND);
    assert_int_equal(c.texts.count, TEST_COUNT(texts));
    for (size_t i = 0; i < TEST_COUNT(texts); ++i) {
        assert_int_equal(c.texts.items[i].kind, texts[i].kind);
        assert_string_equal(checkpoint_text(c.texts, texts[i].name), texts[i].value);
    }
    assert_null(checkpoint_text(c.texts, "sce"));
    Film film, read;
    fill_part(&film);
    const CheckpointNumbers numbers = numbers_of(&film);
    assert_memory_equal(&c.numbers, &numbers, sizeof numbers);
    assert_true(film_init(&read, W, H, PART_FIRST, PART_SAMPLES, true));
    assert_true(film_share(&read, c.numbers.quantum, c.numbers.reach));
    assert_int_equal(checkpoint_read_film(&c, &read, (CheckpointMore){0}, message, sizeof message),
                     CHECKPOINT_SOUND);
    assert_int_equal(read.samples_done, PART_SAMPLES);
    assert_int_equal(read.block_count, 2);
    assert_memory_equal(film.pixels, read.pixels, W * H * sizeof *film.pixels);
    assert_memory_equal(film.aovs, read.aovs, W * H * sizeof *film.aovs);
    assert_memory_equal(film.blocks, read.blocks, (size_t)2 * W * H * sizeof *film.blocks);
    assert_memory_equal(film.aov_blocks, read.aov_blocks,
                        (size_t)2 * W * H * sizeof *film.aov_blocks);
    assert_memory_equal(film.gains, read.gains, W * H * sizeof *film.gains);
    checkpoint_close(&c);
    film_free(&film);
    film_free(&read);
}

static void every_cut_is_found(void **state)
{
    (void)state;
    write_part("whole");
    const FileBytes whole = file_of("whole");
    for (size_t size = 0; size < whole.size; size = next_place(size)) {
        write_file("changed", whole.bytes, size);
        const CheckpointResult result = read_any("changed");
        if (size < 8 ? result != CHECKPOINT_FOREIGN : result != CHECKPOINT_DAMAGED) {
            fail_msg("cut to %zu of %zu bytes: %d", size, whole.size, (int)result);
        }
    }
    char *longer = malloc(whole.size + 1);
    memcpy(longer, whole.bytes, whole.size);
    longer[whole.size] = 0;
    write_file("changed", longer, whole.size + 1);
    assert_int_equal(read_any("changed"), CHECKPOINT_DAMAGED);
    free(longer);
    FileBytes give_back = whole;
    file_bytes_free(&give_back);
}

static void every_changed_byte_is_found(void **state)
{
    (void)state;
    write_part("whole");
    FileBytes whole = file_of("whole");
    for (size_t i = 0; i < whole.size; i = next_place(i)) {
        const char old = whole.bytes[i];
        whole.bytes[i] = (char)(old ^ 1 << i % 8);
        write_file("changed", whole.bytes, whole.size);
        const CheckpointResult result = read_any("changed");
        const CheckpointResult wanted = i < 8    ? CHECKPOINT_FOREIGN
                                        : i < 12 ? CHECKPOINT_OTHER
                                                 : CHECKPOINT_DAMAGED;
        if (result != wanted) {
            fail_msg("byte %zu of %zu changed: %d, not %d", i, whole.size, (int)result,
                     (int)wanted);
        }
        whole.bytes[i] = old;
    }
    file_bytes_free(&whole);
}

static void other_files_are_refused(void **state)
{
    (void)state;
    assert_int_equal(read_any("missing"), CHECKPOINT_MISSING);
    write_file("changed", "sphere {}\n", 10);
    assert_int_equal(read_any("changed"), CHECKPOINT_FOREIGN);
    assert_int_equal(mkfifo(path_of("fifo"), 0600), 0);
    assert_int_equal(read_any("fifo"), CHECKPOINT_FOREIGN); // and doesn't wait for a writer
    assert_int_equal(read_any("."), CHECKPOINT_FOREIGN);
}

static void differences_are_named(void **state)
{
    (void)state;
    const CheckpointTexts all = {texts, TEST_COUNT(texts)};
    assert_null(checkpoint_difference(all, all));
    const CheckpointText other[] = {texts[0], {CHECKPOINT_IDENTITY, "seed", "8"}};
    assert_string_equal(checkpoint_difference(all, (CheckpointTexts){other, 2}), "seed");
    assert_string_equal(checkpoint_difference(all, (CheckpointTexts){other, 1}), "seed");
    assert_string_equal(checkpoint_difference((CheckpointTexts){other, 1}, all), "seed");
    const CheckpointText note[] = {texts[0], texts[1], {CHECKPOINT_NOTE, "empty", "no longer"}};
    assert_null(checkpoint_difference(all, (CheckpointTexts){note, 3}));
}

// --- Renderers -----------------------------------------------------------------------------------

static atomic_int stop;
static atomic_long left; // samples until the stop

// Hashes the ray, and stops in the middle of tiles and blocks.
static Rgb hashed_radiance(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                           IntegratorStats *stats)
{
    (void)world;
    ++stats->rays;
    if (atomic_fetch_sub(&left, 1) == 1) {
        atomic_store(&stop, 1);
    }
    uint64_t bits;
    memcpy(&bits, &ray->direction.x, sizeof bits);
    const uint32_t key = (uint32_t)(hash_u64(bits) >> 32);
    if (aov && key % 4 != 0) {
        *aov = (AovSample){.albedo = {sampler_1d(sampler), 0.5f, 0.25f},
                           .normal = neg(ray->direction),
                           .position = add_scaled(ray->origin, ray->direction, 3),
                           .object = key % 7 + 1,
                           .material = key % 3 + 1};
    }
    sampler_seek(sampler, 8);
    const float v = sampler_1d(sampler);
    return rgb(v * exp2f((float)(key % 25) - 12), v, hash_to_float(key));
}
static const IntegratorClass hashed = {
    .name = "hashed", .doc = "of the test", .radiance = hashed_radiance};

typedef struct Fixture {
    Arena arena;
    DiagSink sink;
    Sandbox sandbox;
    Scene scene;
} Fixture;

static void fixture_init(Fixture *f)
{
    memset(f, 0, sizeof *f);
    diag_sink_init(&f->sink, &f->arena);
    sandbox_init(&f->sandbox);
    assert_true(scene_init(&f->scene, render_schema(), &f->sandbox));
    f->scene.hash = 99;
}

static uint32_t add_node(Scene *scene, const char *kind, const void *params)
{
    const int type = schema_find(scene->schema, str_from(kind));
    assert_true(type >= 0);
    const SceneNode node = {.material = NONE_ID};
    return scene_add_node(scene, (uint16_t)type, params, node);
}

static void fixture_free(Fixture *f)
{
    scene_free(&f->scene);
    sandbox_free(&f->sandbox);
    diag_sink_free(&f->sink);
    arena_free(&f->arena);
}

static RenderOptions options_of(unsigned threads, int64_t first, int64_t samples)
{
    return (RenderOptions){.threads = threads,
                           .width = 23,
                           .height = 19,
                           .seed = 5,
                           .first_sample = first,
                           .samples = samples,
                           .whole_samples = first > 0 ? 200 : 0,
                           .aovs = true,
                           .stop = &stop,
                           .integrator = &hashed};
}

static bool same_film(const Film *a, const Film *b)
{
    const size_t n = film_pixel_count(a), blocks = n * a->block_count;
    return n == film_pixel_count(b) && a->samples_done == b->samples_done &&
           a->block_count == b->block_count &&
           memcmp(a->pixels, b->pixels, n * sizeof *a->pixels) == 0 && !a->gains == !b->gains &&
           (!a->gains || memcmp(a->gains, b->gains, n * sizeof *a->gains) == 0) &&
           memcmp(a->aovs, b->aovs, n * sizeof *a->aovs) == 0 &&
           (blocks == 0 || memcmp(a->blocks, b->blocks, blocks * sizeof *a->blocks) == 0);
}

static Renderer *renderer_of(Fixture *f, RenderOptions options)
{
    Renderer *r = renderer_new(&f->scene, &options, &f->sink);
    assert_non_null(r);
    return r;
}

// Renders in as many processes' worth of renderers as the stops make; returns how many.
static int render_in_pieces(Fixture *f, RenderOptions options, Film *film, Renderer **last)
{
    char message[1024];
    RenderStats stats;
    for (int pieces = 1;; ++pieces) {
        options.threads = (unsigned)pieces % 3 + 1;
        options.tile_width = pieces % 20 + 1;
        Renderer *r = renderer_of(f, options);
        if (pieces > 1) {
            assert_int_equal(renderer_load(r, path_of("part"), message, sizeof message),
                             CHECKPOINT_SOUND);
            assert_string_equal(message, "");
        }
        atomic_store(&stop, 0);
        atomic_store(&left, 500 + (long)(hash_u32((uint32_t)pieces) % 19000));
        assert_true(renderer_run(r, &stats));
        if (!stats.stopped) {
            *film = *renderer_film(r);
            *last = r;
            return pieces;
        }
        assert_true(renderer_save(r, (CheckpointTexts){texts, TEST_COUNT(texts)}, path_of("part"),
                                  message, sizeof message));
        renderer_free(r);
        assert_in_range(pieces, 1, 200);
    }
}

static void pieces_make_the_bytes_of_the_whole(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f);
    static const int64_t ranges[][2] = {{0, 150}, {64, 136}};
    for (size_t i = 0; i < 2; ++i) {
        const RenderOptions options = options_of(2, ranges[i][0], ranges[i][1]);
        atomic_store(&stop, 0);
        atomic_store(&left, LONG_MAX);
        Renderer *whole = renderer_of(&f, options), *last;
        RenderStats stats;
        assert_true(renderer_run(whole, &stats));
        Film film;
        assert_true(render_in_pieces(&f, options, &film, &last) > 5);
        assert_true(same_film(renderer_film(whole), &film));
        RenderStats pieces;
        renderer_stats(last, &pieces);
        assert_int_equal(pieces.samples, stats.samples);
        assert_true(pieces.rays >= stats.rays); // what stops cut short was rendered again
        renderer_free(last);
        renderer_free(whole);
    }
    fixture_free(&f);
}

static Renderer *saved(Fixture *f, RenderOptions options, long samples)
{
    char message[512];
    atomic_store(&stop, 0);
    atomic_store(&left, samples);
    Renderer *r = renderer_of(f, options);
    assert_true(renderer_run(r, NULL));
    assert_true(renderer_save(r, (CheckpointTexts){0}, path_of("part"), message, sizeof message));
    return r;
}

static void expect_refused(Fixture *f, RenderOptions options, const char *why)
{
    char message[512] = "";
    Renderer *r = renderer_of(f, options);
    const CheckpointResult result = renderer_load(r, path_of("part"), message, sizeof message);
    if (result != CHECKPOINT_OTHER || !strstr(message, why)) {
        fail_msg("%d and \"%s\", not \"%s\"", (int)result, message, why);
    }
    renderer_free(r);
}

// The same where cells stop when they are good enough: what decides is kept, too.
static void adaptive_pieces_make_the_bytes_of_the_whole(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f);
    const StopRule rule = {.error = 0.315, .confidence = 0.9};
    RenderParams render = scene_render(&f.scene);
    render.stop = add_node(&f.scene, "until", &rule);
    assert_true(add_node(&f.scene, "render", &render) != NONE_ID);
    const RenderOptions options = options_of(2, 0, 700);
    atomic_store(&stop, 0);
    atomic_store(&left, LONG_MAX);
    Renderer *whole = renderer_of(&f, options), *last;
    assert_true(renderer_run(whole, NULL));
    const Film *film = renderer_film(whole);
    uint32_t most = 0;
    for (size_t p = 0; p < film_pixel_count(film); ++p) {
        most = film->pixels[p].samples > most ? film->pixels[p].samples : most;
    }
    print_message("%u to %u samples\n", film->samples_done, most);
    assert_true(film->samples_done < most);
    Film pieces;
    assert_true(render_in_pieces(&f, options, &pieces, &last) > 5);
    assert_true(same_film(film, &pieces));
    renderer_free(last);
    // One with other samples isn't gone on with, nor one without the rule.
    renderer_free(saved(&f, options, 20000));
    expect_refused(&f, options_of(2, 0, 800), "of another range of samples");
    RenderOptions even = options;
    even.even = true;
    expect_refused(&f, even, "of another kind of sampling: adaptive, not even");
    renderer_free(whole);
    fixture_free(&f);
}

static void what_does_not_fit_is_refused(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f);
    const RenderOptions options = options_of(2, 0, 150);
    renderer_free(saved(&f, options, 9000));
    RenderOptions other = options;
    other.seed = 6;
    expect_refused(&f, other, "of another seed: 5, not 6");
    other = options;
    other.width = 24;
    expect_refused(&f, other, "of another size: 23 x 19, not 24 x 19");
    other = options;
    other.aovs = false;
    expect_refused(&f, other, "of another choice of layers");
    other = options;
    other.integrator = NULL;
    expect_refused(&f, other, "of another integrator: hashed, not path");
    other = options_of(2, 64, 86);
    expect_refused(&f, other, "of another range of samples: 0..149 of 150, not 64..149 of 200");
    f.scene.hash = 98;
    expect_refused(&f, options, "of another scene: 0000000000000063, not 0000000000000062");
    f.scene.hash = 99;
    atomic_store(&f.sandbox.content_hash, 1);
    expect_refused(&f, options, "of another state of the scene's files");
    atomic_store(&f.sandbox.content_hash, 0);
    char message[512];
    Renderer *r = renderer_of(&f, options);
    assert_int_equal(renderer_load(r, path_of("part"), message, sizeof message), CHECKPOINT_SOUND);
    renderer_free(r);
    fixture_free(&f);
}

// More samples can be added where a block ends, or within the first; then the bytes are those of
// one run.
static void samples_can_be_added_to_whole_blocks(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f);
    char message[512];
    atomic_store(&stop, 0);
    atomic_store(&left, LONG_MAX);
    Renderer *whole = renderer_of(&f, options_of(2, 0, 200));
    assert_true(renderer_run(whole, NULL));
    static const int64_t sums[] = {20, 64, 128};
    for (size_t i = 0; i < TEST_COUNT(sums); ++i) {
        renderer_free(saved(&f, options_of(2, 0, sums[i]), LONG_MAX));
        Renderer *more = renderer_of(&f, options_of(1, 0, 200));
        assert_int_equal(renderer_load(more, path_of("part"), message, sizeof message),
                         CHECKPOINT_SOUND);
        assert_true(renderer_run(more, NULL));
        assert_true(same_film(renderer_film(whole), renderer_film(more)));
        renderer_free(more);
    }
    renderer_free(saved(&f, options_of(2, 0, 100), LONG_MAX));
    expect_refused(&f, options_of(2, 0, 200), "ends within a block of 64 samples, at 100");
    expect_refused(&f, options_of(2, 0, 80),
                   "more samples a pixel than are asked for: 100, not 80");
    renderer_free(whole);
    fixture_free(&f);
}

// A run that can't be written leaves the old checkpoint.
static void an_old_checkpoint_stays(void **state)
{
    (void)state;
    Fixture f;
    fixture_init(&f);
    char message[512];
    Renderer *r = saved(&f, options_of(2, 0, 20), LONG_MAX);
    const FileBytes before = file_of("part");
    char impossible[160];
    snprintf(impossible, sizeof impossible, "%s/part/below", folder);
    assert_false(renderer_save(r, (CheckpointTexts){0}, impossible, message, sizeof message));
    assert_non_null(strstr(message, "Not a directory"));
    FileBytes after = file_of("part"), first = before;
    assert_int_equal(before.size, after.size);
    assert_memory_equal(before.bytes, after.bytes, before.size);
    file_bytes_free(&after);
    file_bytes_free(&first);
    renderer_free(r);
    fixture_free(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_was_written_comes_back),
        cmocka_unit_test(every_cut_is_found),
        cmocka_unit_test(every_changed_byte_is_found),
        cmocka_unit_test(other_files_are_refused),
        cmocka_unit_test(differences_are_named),
        cmocka_unit_test(pieces_make_the_bytes_of_the_whole),
        cmocka_unit_test(adaptive_pieces_make_the_bytes_of_the_whole),
        cmocka_unit_test(what_does_not_fit_is_refused),
        cmocka_unit_test(samples_can_be_added_to_whole_blocks),
        cmocka_unit_test(an_old_checkpoint_stays),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
