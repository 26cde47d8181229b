// Sharing among pixels: gains are those of the balance heuristic, so that each pixel's mean is what
// its filter says; they add up to nothing; bytes don't depend on threads and tiles; the error
// falls.
#include "render/share.h"

#include "../test_support.h"

#include "../../render/scene_maker.h"
#include "../../trust.h"
#include "base/hash.h"
#include "base/mem.h"
#include "render/renderer.h"
#include "render/resume.h"

#include <unistd.h>

// --- Weights -------------------------------------------------------------------------------------

// A renderer of a picture `width` pixels wide and one high, as far as sharing looks at it.
static void begin_row(Renderer *r, FilterKind kind, double filter_width, uint32_t width)
{
    *r = (Renderer){.sharing = {.per_radiance = 0x1p28}};
    filter_init(&r->filter, kind, filter_width);
    assert_true(film_init(&r->film, width, 1, 0, 64, false));
    assert_true(film_share(&r->film, 0x1p-28, (uint32_t)ceil(r->filter.width) - 1));
    r->tiles = (TileList){.width = width, .height = 1, .tile_width = width, .tile_height = 1};
    r->options.threads = 1;
    share_fill_cells(&r->sharing, &r->filter);
    const size_t border = 2 * (size_t)r->film.reach;
    r->sharing.windows = mem_alloc_zeroed(1, sizeof *r->sharing.windows);
    assert_non_null(r->sharing.windows);
    r->sharing.windows->columns = width + border;
    r->sharing.windows->rows = 1 + border;
    r->sharing.windows->sums =
        mem_alloc_zeroed((width + border) * (1 + border), sizeof(ShareQuanta));
    assert_non_null(r->sharing.windows->sums);
}

static void end_row(Renderer *r)
{
    share_end(r);
    film_free(&r->film);
}

// Light that varies much within a pixel, and has an edge.
static float light_at(double place)
{
    return (float)(2 + sin(3 * place) + (place > 2.3 ? 3 : 0));
}

enum { ROW = 9, STEPS = 4096 };

// The mean gain of each pixel, relative to its light, by all places at which filters are sampled:
// E[gain of q] = Σ_p E_p[w_q L] - E_q[L] = 0, at the picture's rim as well. Returns the largest.
static double worst_mean_gain(FilterKind kind, double filter_width)
{
    Renderer r;
    begin_row(&r, kind, filter_width, ROW);
    const Tile tile = {0, 0, ROW, 1};
    ShareWindow *window = share_open(&r, 0, &tile);
    for (uint32_t x = 0; x < ROW; ++x) {
        for (int i = 0; i < STEPS; ++i) {
            const double offset[2] = {filter_sample(&r.filter, ((float)i + 0.5F) / STEPS),
                                      filter_sample(&r.filter, (float)(i * 1663 % STEPS) / STEPS)};
            share_add(&r, window, x, 0, offset, rgb_gray(light_at(x + offset[0])));
            if (i % 64 == 63) {
                share_keep(&r, window, x, 0);
            }
        }
    }
    share_close(&r, window);
    double worst = 0, all = 0, most = 0;
    for (uint32_t x = 0; x < ROW; ++x) {
        const double gain = (double)r.film.gains[x].sum[1] * r.film.quantum / STEPS;
        worst = fmax(worst, fabs(gain));
        all += gain;
    }
    for (uint32_t x = 0; x < ROW; ++x) {
        most = fmax(most, (double)r.film.gains[x].sum[0]);
    }
    assert_true(fabs(all) < 1e-6); // what one pixel gets others give
    assert_true(most > 0);
    end_row(&r);
    return worst;
}

static void gains_are_none_in_the_mean(void **state)
{
    (void)state;
    static const struct {
        FilterKind kind;
        double width;
    } filters[] = {{FILTER_BOX, 1.7},
                   {FILTER_BOX, 3},
                   {FILTER_TENT, 0},
                   {FILTER_TENT, 2.4},
                   {FILTER_GAUSSIAN, 0},
                   {FILTER_GAUSSIAN, 1.3},
                   {FILTER_GAUSSIAN, 4},
                   {FILTER_BLACKMAN_HARRIS, 0},
                   {FILTER_BLACKMAN_HARRIS, 3.6}};
    for (size_t i = 0; i < TEST_COUNT(filters); ++i) {
        // Sums instead of integrals over light with an edge: an error of some 6 / STEPS.
        assert_true(worst_mean_gain(filters[i].kind, filters[i].width) < 2e-3);
    }
}

static void what_is_dropped_and_what_is_too_bright_counts_for_nothing(void **state)
{
    (void)state;
    Renderer r;
    begin_row(&r, FILTER_BLACKMAN_HARRIS, 0, ROW);
    const Tile tile = {0, 0, ROW, 1};
    ShareWindow *window = share_open(&r, 0, &tile);
    const double offset[2] = {0.4, -0.2};
    share_add(&r, window, 4, 0, offset, rgb_gray(1));
    share_drop(window);
    share_add(&r, window, 4, 0, offset, rgb_gray(0x1p14F));
    share_add(&r, window, 4, 0, offset, rgb_gray(0));
    share_keep(&r, window, 4, 0);
    share_close(&r, window);
    for (uint32_t x = 0; x < ROW; ++x) {
        assert_int_equal(r.film.gains[x].sum[1], 0);
    }
    share_add(&r, window, 4, 0, offset, rgb_gray(0x1p12F));
    share_keep(&r, window, 4, 0);
    share_close(&r, window);
    assert_true(r.film.gains[5].sum[1] > 0);
    end_row(&r);
}

// A place at the very end of the support, where no other pixel's filter reaches: all stays.
static void ends_of_filters_are_within_them(void **state)
{
    (void)state;
    for (double width = 1.05; width <= SHARE_WIDTH; width += 0.01) {
        for (int kind = FILTER_BOX; kind <= FILTER_BLACKMAN_HARRIS; ++kind) {
            Renderer r;
            begin_row(&r, (FilterKind)kind, width, 1);
            const Tile tile = {0, 0, 1, 1};
            ShareWindow *window = share_open(&r, 0, &tile);
            const double low = filter_sample(&r.filter, 0);
            const double high = filter_sample(&r.filter, 0x1.fffffep-1F);
            const double offset[2] = {low, high};
            assert_true(filter_density(&r.filter, low) > 0 && filter_density(&r.filter, high) > 0);
            share_add(&r, window, 0, 0, offset, rgb_gray(1));
            share_keep(&r, window, 0, 0);
            share_close(&r, window);
            assert_int_equal(r.film.gains[0].sum[0], 0);
            end_row(&r);
        }
    }
}

// --- The film ------------------------------------------------------------------------------------

// Gains count where all that share have as many samples, and nowhere else.
static void ragged_pixels_show_their_own_samples(void **state)
{
    (void)state;
    Film film;
    assert_true(film_init(&film, 9, 1, 0, 64, false));
    assert_true(film_share(&film, 0.25, 2));
    for (size_t p = 0; p < 9; ++p) {
        for (size_t i = 0; i < (p < 5 ? 4 : 1); ++i) {
            film_pixel_add(&film.pixels[p], rgb_gray(2));
        }
        film.gains[p] = (FilmGain){{8, -8, -(INT64_C(1) << 40)}};
    }
    for (size_t p = 0; p < 9; ++p) {
        const Rgb color = film_color(&film, p, false);
        const bool agree = p < 3 || p > 6;
        const double gain = agree ? 0.7 * (p < 5 ? 0.5 : 2) : 0;
        assert_true(fabs((double)color.r - 2 - gain) < 1e-6);
        assert_true(fabs((double)color.g - 2 + gain) < 1e-6);
        assert_true(color.b == (agree ? 0 : 2)); // never below it
    }
    film_free(&film);
}

static void gains_of_other_quanta_are_merged(void **state)
{
    (void)state;
    Film head, part, other;
    assert_true(film_init(&head, 1, 1, 0, 64, false) && film_share(&head, 0.5, 1));
    assert_true(film_init(&part, 1, 1, 64, 64, false) && film_share(&part, 0.25, 1));
    assert_true(film_init(&other, 1, 1, 64, 64, false));
    head.samples_done = head.pixels->samples = 64;
    part.samples_done = part.pixels->samples = 64;
    other.samples_done = other.pixels->samples = 64;
    head.gains->sum[0] = 10;
    part.gains->sum[0] = -6;
    head.gains->sum[1] = part.gains->sum[1] = INT64_MAX; // a file may say so
    assert_int_equal(film_merge(&head, &other), FILM_MERGE_SIZE);
    assert_int_equal(film_merge(&head, &part), FILM_MERGED);
    assert_int_equal(head.gains->sum[0], 7);
    film_free(&head);
    film_free(&part);
    film_free(&other);
}

// --- Pictures ------------------------------------------------------------------------------------

enum { WIDTH = 24, HEIGHT = 18, PIXELS = WIDTH * HEIGHT };

// A corner of a room with a mirror and a glass ball: light that is scattered often.
static void put_scene(SceneMaker *m, const char *filter)
{
    PUT(m, "film", {"width", {WIDTH}}, {"height", {HEIGHT}}, {"filter", {0}, filter});
    PUT(m, "render", {"samples", {16}}, {"bounces", {5}});
    PUT(m, "camera", {"position", {0, 1, 4}}, {"look_at", {0, 1, 0}}, {"fov", {0.7}});
    const uint32_t matt = PUT(m, "lambert", {"color", {0.8, 0.7, 0.6}});
    const uint32_t mirror = PUT(m, "mirror", {"color", {0.9}});
    const uint32_t glass = PUT(m, "fresnel", {"ior", {1.5}});
    const uint32_t lamp = PUT(m, "emissive", {"radiance", {8}});
    PUT(m, "box", {"min", {-2, 0, -2}}, {"max", {2, 3, 5}}, {"material", {matt}});
    PUT(m, "sphere", {"center", {-0.6, 0.5, 0}}, {"radius", {0.5}}, {"material", {mirror}});
    PUT(m, "sphere", {"center", {0.6, 0.5, 0}}, {"radius", {0.5}}, {"material", {glass}});
    PUT(m, "sphere", {"center", {0.3, 2.4, 4.5}}, {"radius", {0.2}}, {"material", {lamp}});
}

static Renderer *rendered(SceneMaker *m, RenderOptions options)
{
    Renderer *r = renderer_new(&m->scene, &options, &m->sink);
    assert_non_null(r);
    RenderStats stats;
    assert_true(renderer_run(r, &stats));
    assert_int_equal(stats.bad_samples, 0);
    return r;
}

static void bytes_depend_on_neither_threads_nor_tiles(void **state)
{
    (void)state;
    static const RenderOptions ways[] = {
        {.threads = 3, .seed = 5},
        {.threads = 2, .seed = 5, .tile_width = 1, .tile_height = 1},
        {.threads = 2, .seed = 5, .tile_width = 5, .tile_height = 300},
    };
    SceneMaker m;
    maker_init(&m);
    put_scene(&m, "blackman_harris");
    Renderer *one = rendered(&m, (RenderOptions){.threads = 1, .seed = 5});
    const Film *film = renderer_film(one);
    assert_non_null(film->gains);
    int64_t sum = 0, most = 0;
    for (int p = 0; p < PIXELS; ++p) {
        sum += film->gains[p].sum[1];
        most = film->gains[p].sum[1] > most ? film->gains[p].sum[1] : most;
    }
    assert_true(most > 1 << 20 && llabs(sum) < 1 << 20); // roundings
    for (size_t i = 0; i < TEST_COUNT(ways); ++i) {
        Renderer *other = rendered(&m, ways[i]);
        assert_memory_equal(film->gains, renderer_film(other)->gains, PIXELS * sizeof(FilmGain));
        renderer_free(other);
    }
    renderer_free(one);
    maker_free(&m);
}

typedef struct Sums {
    double mean[PIXELS], square[PIXELS];
} Sums;

static void add_to(Sums *sums, int p, double value)
{
    sums->mean[p] += value;
    sums->square[p] += value * value;
}

static double variance(const Sums *sums, int n)
{
    double all = 0;
    for (int p = 0; p < PIXELS; ++p) {
        const double mean = sums->mean[p] / n;
        all += (sums->square[p] / n - mean * mean) / (n - 1);
    }
    return all / PIXELS;
}

// Groups of pixels in which a fault of the weights would show: the picture's rim, where neighbours
// are missing, and the brighter half, which gives to the darker what edges between them let
// through.
typedef enum Group { RIM, BRIGHT, GROUPS } Group;
static const char *const group_names[] = {"sharing among pixels, the picture's rim",
                                          "sharing among pixels, the brighter half"};

static bool is_in(Group group, const Renderer *model, int p)
{
    const int x = p % WIDTH, y = p / WIDTH;
    const FilmPixel *pixels = renderer_film(model)->pixels;
    return group == RIM ? x < 2 || x >= WIDTH - 2 || y < 2 || y >= HEIGHT - 2
                        : film_luminance(&pixels[p]) > film_luminance(&pixels[PIXELS / 2]);
}

// What a group's light is with sharing, in parts of what it is without.
static double share_of(Group group, const Renderer *model, const Film *film)
{
    double own = 0, shared = 0;
    for (int p = 0; p < PIXELS; ++p) {
        if (is_in(group, model, p)) {
            own += film_luminance(&film->pixels[p]);
            shared += (double)luminance(film_color(film, (size_t)p, true));
        }
    }
    return shared / own;
}

// No pixel's mean gain is further from 0 than 6 of its standard errors (a chance of 1e-6 for all
// 432 pixels of 60 pictures, with Student's t for 59 degrees of freedom), nor a group's; and the
// squared error is at most four fifths of that of the pixels' own samples (it is about two thirds).
static void errors_fall_and_means_stay(void **state)
{
    (void)state;
    const int pictures = full_run() ? 4000 : 60;
    static Sums own, shared, gain;
    double mean[GROUPS] = {0}, square[GROUPS] = {0};
    own = shared = gain = (Sums){{0}};
    SceneMaker m;
    maker_init(&m);
    put_scene(&m, "blackman_harris");
    Renderer *model = rendered(&m, (RenderOptions){.threads = 2, .seed = 99, .samples = 256});
    for (int i = 0; i < pictures; ++i) {
        Renderer *r = rendered(&m, (RenderOptions){.threads = 2, .seed = 100 + i, .samples = 16});
        const Film *film = renderer_film(r);
        for (int p = 0; p < PIXELS; ++p) {
            const double a = film_luminance(&film->pixels[p]);
            const double b = (double)luminance(film_color(film, (size_t)p, true));
            add_to(&own, p, a);
            add_to(&shared, p, b);
            add_to(&gain, p, b - a);
        }
        for (int g = 0; g < GROUPS; ++g) {
            const double share = share_of((Group)g, model, film);
            mean[g] += share / pictures;
            square[g] += share * share / pictures;
        }
        renderer_free(r);
    }
    for (int g = 0; g < GROUPS; ++g) {
        const double error = sqrt((square[g] - mean[g] * mean[g]) / (pictures - 1));
        trust_mean(group_names[g], 1, mean[g], error, pictures - 1, 0.001);
        print_message("%s: %.5f, standard error %.5f\n", group_names[g], mean[g], error);
        assert_true(fabs(mean[g] - 1) < 6 * error);
    }
    double worst = 0;
    for (int p = 0; p < PIXELS; ++p) {
        const double average = gain.mean[p] / pictures;
        const double error2 = (gain.square[p] / pictures - average * average) / (pictures - 1);
        worst = fmax(worst, fabs(average) / sqrt(error2));
    }
    const double ratio = variance(&shared, pictures) / variance(&own, pictures);
    print_message("seeds 100 to %d: worst gain %.2f standard errors, squared error %.3f of the own "
                  "samples'\n",
                  99 + pictures, worst, ratio);
    assert_true(worst < 6 && ratio < 0.8);
    renderer_free(model);
    maker_free(&m);
}

// A checkpoint's quantum is gone on with, whatever this processor would choose; and pictures may be
// narrower than filters.
static void checkpoints_bring_their_quantum(void **state)
{
    (void)state;
    enum { NARROW = 1, HIGH = 5 };
    char path[] = "/tmp/scn_share_XXXXXX", message[512];
    const int fd = mkstemp(path);
    assert_true(fd >= 0);
    close(fd);
    SceneMaker m;
    maker_init(&m);
    put_scene(&m, "blackman_harris");
    RenderOptions options = {
        .threads = 1, .seed = 5, .samples = 4, .width = NARROW, .height = HIGH};
    Renderer *first = rendered(&m, options);
    const double quantum = first->film.quantum;
    for (int p = 0; p < NARROW * HIGH; ++p) { // as of a processor with quanta half as large
        for (int c = 0; c < 3; ++c) {
            first->film.gains[p].sum[c] *= 2;
        }
    }
    first->film.quantum = quantum / 2;
    assert_true(renderer_save(first, (CheckpointTexts){0}, path, message, sizeof message));
    options.samples = 64;
    Renderer *second = renderer_new(&m.scene, &options, &m.sink);
    assert_non_null(second);
    assert_true(second->film.quantum == quantum);
    assert_int_equal(renderer_load(second, path, message, sizeof message), CHECKPOINT_SOUND);
    assert_true(second->film.quantum == quantum / 2);
    assert_true(renderer_run(second, NULL));
    Renderer *whole = rendered(&m, options);
    for (size_t p = 0; p < NARROW * HIGH; ++p) {
        const Rgb a = film_color(&second->film, p, true), b = film_color(&whole->film, p, true);
        assert_true(b.g > 0 && fabs((double)a.g - (double)b.g) < 1e-6 * (double)b.g);
        // With the other quantum all that came since would count half, or double.
        assert_true(llabs(second->film.gains[p].sum[1] - 2 * whole->film.gains[p].sum[1]) <
                    1 << 12);
    }
    renderer_free(first);
    renderer_free(second);
    renderer_free(whole);
    maker_free(&m);
    unlink(path);
}

// Nothing to share: filters that don't overlap, light that is scattered once, a rule to stop by.
static void other_pictures_share_nothing(void **state)
{
    (void)state;
    static const char *const filters[] = {"box", "center"};
    for (size_t i = 0; i < TEST_COUNT(filters); ++i) {
        SceneMaker m;
        maker_init(&m);
        put_scene(&m, filters[i]);
        Renderer *r = rendered(&m, (RenderOptions){.threads = 1, .seed = 1, .samples = 1});
        assert_null(renderer_film(r)->gains);
        renderer_free(r);
        maker_free(&m);
    }
    SceneMaker m;
    maker_init(&m);
    PUT(&m, "film", {"width", {WIDTH}}, {"height", {HEIGHT}});
    PUT(&m, "render", {"samples", {16}}, {"bounces", {1}});
    PUT(&m, "environment_light", {"radiance", {0.3}});
    PUT(&m, "plane", {"material", {PUT(&m, "lambert", {"color", {0.8}})}});
    Renderer *r = rendered(&m, (RenderOptions){.threads = 1, .seed = 1});
    assert_null(renderer_film(r)->gains);
    renderer_free(r);
    maker_free(&m);
}

// Each allocation fails in turn.
static void memory_running_out_is_reported(void **state)
{
    (void)state;
    SceneMaker m;
    maker_init(&m);
    put_scene(&m, "tent");
    const RenderOptions options = {.threads = 1, .seed = 1};
    const uint64_t live = mem_live_count();
    bool made = false;
    for (uint64_t i = 0; !made; ++i) {
        mem_fail_after(i);
        Renderer *r = renderer_new(&m.scene, &options, &m.sink);
        mem_fail_after(UINT64_MAX);
        made = r && renderer_film(r)->gains;
        renderer_free(r);
        assert_true(i < 10000);
    }
    assert_int_equal(mem_live_count(), live);
    maker_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gains_are_none_in_the_mean),
        cmocka_unit_test(what_is_dropped_and_what_is_too_bright_counts_for_nothing),
        cmocka_unit_test(ends_of_filters_are_within_them),
        cmocka_unit_test(ragged_pixels_show_their_own_samples),
        cmocka_unit_test(gains_of_other_quanta_are_merged),
        cmocka_unit_test(bytes_depend_on_neither_threads_nor_tiles),
        cmocka_unit_test(errors_fall_and_means_stay),
        cmocka_unit_test(checkpoints_bring_their_quantum),
        cmocka_unit_test(other_pictures_share_nothing),
        cmocka_unit_test(memory_running_out_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
