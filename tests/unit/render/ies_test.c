// Photometric files: what they say, in all editions and coordinate systems, and what is wrong with
// damaged ones.
#include "../../trust.h"
#include "../test_support.h"

#include "../../render/scene_maker.h"
#include "../../render/statistics.h"
#include "render/world.h"
#include "scene/ies.h"

static const char HEAD[] = "IESNA:LM-63-2002\n[TEST] one\n[MANUFAC] nobody\n";

// Type C, one plane.
static const char ROUND[] = "TILT=NONE\n1 -1 2 5 1 1 2 0 0 0\n1 1 50\n0 30 60 80 90\n0\n"
                            "100 90 50 10 0\n";

static const IesWeb *read_text(Arena *arena, const char *text, IesError *error)
{
    return ies_read(arena, str_from(text), error);
}

static const IesWeb *read_good(Arena *arena, const char *text)
{
    IesError error;
    const IesWeb *web = read_text(arena, text, &error);
    if (!web) {
        print_message("line %u: %s\n", error.line, error.message);
    }
    assert_non_null(web);
    return web;
}

static const char *join(Arena *arena, const char *a, const char *b)
{
    return arena_printf(arena, "%s%s", a, b);
}

// The intensity at angles in degrees, by the definition of the coordinate system.
static double at_angles(const IesWeb *web, double vertical, double horizontal)
{
    double v = vertical * PI / 180, h = horizontal * PI / 180;
    switch (web->type) {
    case IES_TYPE_C:
        return ies_candela(web, cos(v), sin(v) * cos(h), -sin(v) * sin(h));
    case IES_TYPE_B:
        return ies_candela(web, cos(h) * cos(v), cos(h) * sin(v), sin(h));
    default:
        return ies_candela(web, cos(v) * cos(h), sin(v), cos(v) * sin(h));
    }
}

// The flux by sums over small pieces of the sphere, without regard to the table.
static double numeric_flux(const IesWeb *web)
{
    enum { ROWS = 720, COLUMNS = 1440 };
    double sum = 0;
    for (int i = 0; i < ROWS; ++i) {
        double a = PI * i / ROWS, b = PI * (i + 1) / ROWS, t = (a + b) / 2;
        for (int k = 0; k < COLUMNS; ++k) {
            double phi = 2 * PI * (k + 0.5) / COLUMNS;
            sum += (cos(a) - cos(b)) * 2 * PI / COLUMNS *
                   ies_candela(web, cos(t), sin(t) * cos(phi), sin(t) * sin(phi));
        }
    }
    return sum;
}

static void round_luminaire(void **state)
{
    (void)state;
    Arena arena = {0};
    const IesWeb *web = read_good(&arena, join(&arena, HEAD, ROUND));
    assert_int_equal(web->edition, 2002);
    assert_int_equal(web->type, IES_TYPE_C);
    assert_int_equal(web->symmetry, IES_ROTATIONAL);
    assert_true(web->lumens_per_lamp == -1 && web->lamps == 1 && web->watts == 50);
    const double expected[][2] = {{0, 200}, {15, 190}, {30, 180}, {45, 140}, {60, 100}, {70, 60},
                                  {80, 20}, {85, 10},  {90, 0},   {91, 0},   {135, 0},  {180, 0}};
    for (size_t i = 0; i < TEST_COUNT(expected); ++i) {
        for (double h = 0; h < 360; h += 30) {
            assert_true(NEAR(at_angles(web, expected[i][0], h), expected[i][1], 1e-9));
        }
    }
    assert_true(NEAR(ies_reach(web), PI / 2, 1e-12));
    // By hand: a constant 1 over a hemisphere is 2π.
    const IesWeb *even = read_good(&arena, "TILT=NONE\n1 -1 1 2 1 1 1 0 0 0 1 1 0\n0 90\n0\n3 3");
    assert_int_equal(even->edition, 1986);
    assert_true(NEAR(ies_lumens(even), 6 * PI, 1e-12));
    arena_free(&arena);
}

// Each factor of the file counts once.
static void all_multipliers_count(void **state)
{
    (void)state;
    Arena arena = {0};
    const IesWeb *web = read_good(&arena, "IESNA91\n[TEST] x\n[MANUFAC] y\nTILT=NONE\n"
                                          "2 1000 3 2 1 1 1 -1 0 0\n0.5 0.25 100\n0 90 0 8 16\n");
    assert_int_equal(web->edition, 1991);
    assert_true(web->lamps == 2 && web->lumens_per_lamp == 1000);
    assert_true(NEAR(at_angles(web, 0, 0), 8 * 3 * 0.5 * 0.25, 1e-12));
    assert_true(NEAR(at_angles(web, 90, 0), 16 * 3 * 0.5 * 0.25, 1e-12));
    arena_free(&arena);
}

// A table of type C with 5 vertical angles, `count` horizontal ones from `first` to `last`, and
// intensities that differ everywhere but at the poles.
static const char *type_c(Arena *arena, double first, double last, int count)
{
    char *text = arena_printf(arena, "%sTILT=NONE\n1 -1 1 5 %d 1 2 0 0 0\n1 1 1\n0 40 90 130 180\n",
                              HEAD, count);
    for (int i = 0; i < count; ++i) {
        text = arena_printf(arena, "%s%g ", text, first + (last - first) * i / (count - 1));
    }
    for (int i = 0; i < count; ++i) {
        int k = last > 300 && i == count - 1 ? 0 : i; // 360° is 0°
        text = arena_printf(arena, "%s\n7 %d %d %d 3", text, 10 + k, 20 + 2 * k, 5 + k * k);
    }
    return text;
}

static void sectors_are_mirrored(void **state)
{
    (void)state;
    Arena arena = {0};
    const IesWeb *quadrant = read_good(&arena, type_c(&arena, 0, 90, 4));
    const IesWeb *half = read_good(&arena, type_c(&arena, 0, 180, 7));
    const IesWeb *sideways = read_good(&arena, type_c(&arena, 90, 270, 7));
    const IesWeb *full = read_good(&arena, type_c(&arena, 0, 360, 13));
    assert_int_equal(quadrant->symmetry, IES_QUADRANT);
    assert_int_equal(half->symmetry, IES_HALF);
    assert_int_equal(sideways->symmetry, IES_HALF_90);
    assert_int_equal(full->symmetry, IES_FULL);
    for (int h = 0; h < 360; h += 10) {
        // The values at 40° go up by 1 for every 30°.
        double folded = h > 180 ? 360 - h : h;
        double around = h < 330 ? 10 + h / 30.0 : 21 - 11 * (h - 330) / 30.0;
        double back = h < 90 ? 180 - h : h > 270 ? 540 - h : h;
        assert_true(NEAR(at_angles(quadrant, 40, h), 10 + fmin(folded, 180 - folded) / 30, 1e-9));
        assert_true(NEAR(at_angles(half, 40, h), 10 + folded / 30, 1e-9));
        assert_true(NEAR(at_angles(sideways, 40, h), 10 + (back - 90) / 30, 1e-9));
        assert_true(NEAR(at_angles(full, 40, h), around, 1e-9));
        assert_true(NEAR(at_angles(full, 20, h), (7 + around) / 2, 1e-9));
        assert_true(NEAR(at_angles(full, 0, h), 7, 1e-9));
        assert_true(NEAR(at_angles(full, 180, h), 3, 1e-9));
    }
    const IesWeb *webs[] = {quadrant, half, sideways, full};
    static const char *const NAMES[] = {"15 flux of a quarter, lm", "15 flux of a half, lm",
                                        "15 flux of a half about 90, lm", "15 flux of a whole, lm"};
    for (size_t i = 0; i < TEST_COUNT(webs); ++i) {
        double flux = ies_lumens(webs[i]), numeric = numeric_flux(webs[i]);
        assert_true(trust_near(NAMES[i], numeric, flux, 1e-4 * numeric)); // 0.2 % is asked for
    }
    arena_free(&arena);
}

// A circle that lacks its 360° is closed, as other programs do.
static void open_circles_are_closed(void **state)
{
    (void)state;
    Arena arena = {0};
    IesError error;
    const IesWeb *web = read_good(&arena, type_c(&arena, 0, 270, 4));
    assert_int_equal(web->horizontal_count, 5);
    assert_true(NEAR(at_angles(web, 40, 270), 13, 1e-9));
    assert_true(NEAR(at_angles(web, 40, 315), 11.5, 1e-9));
    assert_true(NEAR(at_angles(web, 40, 359.99999), 10, 1e-5));
    assert_null(read_text(&arena, type_c(&arena, 0, 200, 5), &error));
    assert_null(read_text(&arena, type_c(&arena, 0, 45, 5), &error));
    assert_null(read_text(&arena, type_c(&arena, 30, 180, 5), &error));
    assert_non_null(strstr(error.message, "0, 90, 180 or 360"));
    arena_free(&arena);
}

// Types A and B. `type` is the file's number; all values differ.
static const char *type_ab(Arena *arena, int type, double v_first, double h_first)
{
    char *text =
        arena_printf(arena, "IESNA:LM-63-1995\nTILT=NONE\n1 -1 1 4 3 %d 2 0 0 0\n1 1 1\n", type);
    for (int i = 0; i < 4; ++i) {
        text = arena_printf(arena, "%s%.17g ", text, v_first + (90 - v_first) * i / 3);
    }
    for (int i = 0; i < 3; ++i) {
        text = arena_printf(arena, "%s%.17g ", text, h_first + (90 - h_first) * i / 2);
    }
    return join(arena, text, "\n1 2 3 4\n12 15 18 13\n8 6 5 4\n");
}

static void types_a_and_b(void **state)
{
    (void)state;
    Arena arena = {0};
    for (int type = 2; type <= 3; ++type) {
        for (int k = 0; k < 4; ++k) {
            double v_first = k & 1 ? -90 : 0, h_first = k & 2 ? -90 : 0;
            const IesWeb *web = read_good(&arena, type_ab(&arena, type, v_first, h_first));
            assert_int_equal(web->type, type);
            double step_v = (90 - v_first) / 3, step_h = (90 - h_first) / 2;
            // Given angles, one cell's middle, and the mirror images of both.
            double v = v_first + step_v, h = h_first + step_h;
            assert_true(NEAR(at_angles(web, v, h), 15, 1e-9));
            assert_true(NEAR(at_angles(web, v + step_v / 2, h), 16.5, 1e-9));
            assert_true(NEAR(at_angles(web, v, h + step_h / 2), 10.5, 1e-9));
            if (v_first == 0) {
                assert_true(NEAR(at_angles(web, -v, h), 15, 1e-9));
            }
            if (h_first == 0) {
                assert_true(NEAR(at_angles(web, v, -h - step_h / 2), 10.5, 1e-9));
            }
            assert_true(ies_candela(web, -1, 0, 0) == 0); // nothing backwards
            double flux = ies_lumens(web), numeric = numeric_flux(web);
            print_message("type %c: %.6f lm, by small pieces %.6f\n", type == 2 ? 'B' : 'A', flux,
                          numeric);
            assert_true(fabs(flux / numeric - 1) < 1e-3);
        }
    }
    // Even light over the front hemisphere.
    const IesWeb *even =
        read_good(&arena, "TILT=NONE\n1 -1 1 2 2 2 1 0 0 0 1 1 0 -90 90 -90 90 2 2 2 2");
    assert_true(NEAR(ies_lumens(even), 4 * PI, 1e-12));
    arena_free(&arena);
}

static void tilt_is_read(void **state)
{
    (void)state;
    Arena arena = {0};
    IesError error;
    const char *rest = ROUND + strlen("TILT=NONE\n");
    const IesWeb *web =
        read_good(&arena, arena_printf(&arena, "%sTILT=INCLUDE\n1\n4\n0 30 60 90\n1 .9 .8 .6\n%s",
                                       HEAD, rest));
    assert_int_equal(web->tilt_count, 4);
    assert_true(NEAR(at_angles(web, 0, 0), 200, 1e-9));
    const double expected[][2] = {{0, 1}, {15, 0.95}, {60, 0.8}, {75, 0.7}, {90, 0.6}, {120, 0.6}};
    for (size_t i = 0; i < TEST_COUNT(expected); ++i) {
        double factor = ies_tilt_factor(web, expected[i][0] * PI / 180);
        assert_true(NEAR(factor, expected[i][1], 1e-12));
    }
    assert_true(ies_tilt_factor(read_good(&arena, ROUND), 1) == 1);
    assert_null(read_text(&arena, join(&arena, "a\nb\nTILT=lamp 5.tlt\n", rest), &error));
    assert_int_equal(error.line, 3);
    assert_non_null(strstr(error.message, "TILT=lamp"));
    assert_null(read_text(&arena, join(&arena, "TILT=INCLUDE\n4\n1\n0\n1\n", rest), &error));
    assert_int_equal(error.line, 2);
    arena_free(&arena);
}

// The same table, written in ways that files are written in.
static void forms_of_text(void **state)
{
    (void)state;
    Arena arena = {0};
    const char *forms[] = {
        // no keywords at all; wrapped lines; commas; a number a line; Fortran's style
        "TILT=NONE\n1 -1 2 5 1 1 2 0 0 0\n1 1 50\n0 30 60 80 90\n0\n100 90 50 10 0",
        "a luminaire of 1986\nwithout keywords\nTILT=NONE\n1,-1,2,5,1,1,2,0,0,0\n1,1,50\n"
        "0,30,60,80,90\n0\n100,90,50,10,0\n",
        "IESNA91\r\n[TEST] x\r\nTILT=NONE\r\n1 -1 2 5 1\r\n1 2 0 0 0 1 1 50 0 30 60\r\n80 90\r\n"
        "0\r\n100 90\r\n50 10 0\r\n\x1a",
        "IESNA:LM-63-1995\rTILT=NONE\r1 -1. 2.0 5 1 1 2 .0 0. 0\r1.0E+0 1e0 +50\r"
        "0 3.0e1 60 80 90\r0\r100. 90 50 10 .0\r",
        "\xef\xbb\xbfIESNA:LM-63-2002\n[BLOCK]\n[LUMINAIRE] inner [BLOCK]\n[MORE] TILTED\n"
        "[ENDBLOCK]\n[_OWN] TILT=\n[OTHER\n  tilt = none \n\n 1 -1 2 5 1 1 2 0 0 0 \n\n1 1 50\n"
        "\t0 30, 60 ,80 90 0\n100 90 50 10 0 \n\n\n",
        "IES:LM-63-2019\nTILT=NONE\n1 -1 2 5 1 1 2 0 0 0\n1 1 50\n0 30 60 80 90\n0\n100 90 50 10 "
        "0\n",
    };
    const int editions[] = {1986, 1986, 1991, 1995, 2002, 2019};
    for (size_t i = 0; i < TEST_COUNT(forms); ++i) {
        const IesWeb *web = read_good(&arena, forms[i]);
        assert_int_equal(web->edition, editions[i]);
        assert_true(NEAR(at_angles(web, 45, 10), 140, 1e-9));
        assert_true(web->watts == 50);
    }
    arena_free(&arena);
}

static void damage_is_found_at_its_line(void **state)
{
    (void)state;
    static const struct {
        const char *text, *message;
        uint32_t line;
    } cases[] = {
        {"", "no line `TILT=`", 1},
        {"IESNA91\n[TEST]\n", "no line `TILT=`", 3},
        {"TILT=NONE\n", "file ends where the number of lamps", 2},
        {"TILT=NONE\n1 -1 x", "`x` stands where the candela multiplier", 2},
        {"TILT=NONE\n1 -1 1x2", "`1x2` stands", 2},
        {"TILT=NONE\n1 -1 nan", "`nan` stands", 2},
        {"TILT=NONE\n1 -1 1e999", "`1e999` stands", 2},
        {"TILT=NONE\n1 -7 1\n2 1 1 1 0 0 0 1 1 1 0 90 0 1 1", "negative is only -1", 3},
        {"TILT=NONE\n1 -1 -1", "candela multiplier is negative", 2},
        {"TILT=NONE\n1 -1 1\n2.5", "number of vertical angles is 2.5", 3},
        {"TILT=NONE\n1 -1 1\n1 1", "number of vertical angles is 1", 3},
        {"TILT=NONE\n1 -1 1\n4294967297 1", "only 2 bytes follow", 3},
        {"TILT=NONE\n1 -1 1\n1e300 1", "only 2 bytes follow", 3},
        {"TILT=NONE\n1 -1 1\n9 9 1 1 0 0 0 1 1 1\n0 10 20 30 40 50 60", "9 vertical times 9", 3},
        {"TILT=NONE\n1 -1 1\n2 1 4 1 0 0 0 1 1 1", "photometric type is 4", 3},
        {"TILT=NONE\n1 -1 1\n2 1 0 1 0 0 0 1 1 1", "photometric type is 0", 3},
        {"TILT=NONE\n1 -1 1\n2 1 1 3 0 0 0 1 1 1", "type of units is 3", 3},
        {"TILT=NONE\n1 -1 1\n2 1 1 1 0 0 0 1 1 1\n0 200\n0\n1 1", "vertical angle is 200", 4},
        {"TILT=NONE\n1 -1 1\n2 1 1 1 0 0 0 1 1 1\n90 0\n0\n1 1", "0 follows 90", 4},
        {"TILT=NONE\n1 -1 1\n2 1 1 1 0 0 0 1 1 1\n0 0\n0\n1 1", "0 follows 0", 4},
        {"TILT=NONE\n1 -1 1\n2 1 1 1 0 0 0 1 1 1\n0 90\n-5\n1 1", "horizontal angle is -5", 5},
        {"TILT=NONE\n1 -1 1\n2 1 2 1 0 0 0 1 1 1\n0 90\n0\n1 1", "two horizontal angles", 5},
        {"TILT=NONE\n1 -1 1\n2 1 1 1 0 0 0 1 1 1\n0 90\n0\n1 -1", "intensity is negative", 6},
        {"TILT=NONE\n1 -1 1e300\n2 1 1 1 0 0 0 1 1 1\n0 90\n0\n1 1e300", "too large", 6},
        {"TILT=NONE\n1 -1 1\n2 1 1 1 0 0 0 1 1 1\n0 90\n0\n1", "file ends where an intensity", 6},
        {"TILT=NONE\n1 -1 1\n2 1 1 1 0 0 0 1 1 1\n0 90\n0\n1 2\n3", "more numbers follow", 7},
        {"TILT=INCLUDE\n1\n900000000\n", "number of tilt angles is 900000000", 3},
    };
    Arena arena = {0};
    for (size_t i = 0; i < TEST_COUNT(cases); ++i) {
        IesError error;
        assert_null(read_text(&arena, cases[i].text, &error));
        if (!strstr(error.message, cases[i].message) || error.line != cases[i].line) {
            print_message("case %zu: line %u: %s\n", i, error.line, error.message);
        }
        assert_non_null(strstr(error.message, cases[i].message));
        assert_int_equal(error.line, cases[i].line);
    }
    arena_free(&arena);
}

// Cut off at every byte, and with every byte replaced: an error or a table, no more. The bytes lie
// at the end of their allocation, so that a sanitizer sees a step beyond.
static void any_bytes_are_safe(void **state)
{
    (void)state;
    Arena arena = {0};
    const char *texts[] = {arena_printf(&arena, "%sTILT=INCLUDE\n1\n2\n0 90\n1 .6\n%s", HEAD,
                                        ROUND + strlen("TILT=NONE\n")),
                           type_c(&arena, 0, 270, 4), type_ab(&arena, 2, 0, -90)};
    int good = 0, tries = 0;
    for (size_t t = 0; t < TEST_COUNT(texts); ++t) {
        size_t size = strlen(texts[t]);
        for (size_t i = 0; i <= 4 * size; ++i) {
            static const char OTHERS[] = {'9', '-', '\n'};
            size_t length = i <= size ? i : size;
            char *copy = malloc(length + (length == 0));
            memcpy(copy, texts[t], length);
            if (i > size) {
                copy[(i - size - 1) % size] = OTHERS[(i - size - 1) / size];
            }
            ArenaMark mark = arena_mark(&arena);
            IesError error;
            const IesWeb *web = ies_read(&arena, (Str){copy, length}, &error);
            ++tries;
            if (web) {
                ++good;
                assert_true(isfinite(ies_lumens(web)) && ies_lumens(web) >= 0);
                assert_true(isfinite(at_angles(web, 33, 44)));
            } else {
                assert_true(error.line > 0 && error.message[0]);
            }
            arena_rewind(&arena, mark);
            free(copy);
        }
    }
    print_message("%d of %d damaged files still make a table\n", good, tries);
    assert_true(good > 0 && good < tries / 2);
    arena_free(&arena);
}

static void memory_may_run_out(void **state)
{
    (void)state;
    Arena texts = {0};
    const char *text = type_c(&texts, 0, 270, 4);
    for (size_t limit = 1; limit < 4; ++limit) {
        Arena arena = {.limit = limit};
        IesError error;
        assert_null(read_text(&arena, text, &error));
        assert_int_equal(error.line, 0);
        arena_free(&arena);
    }
    arena_free(&texts);
}

// --- The light -----------------------------------------------------------------------------------

static const char *example(const char *name)
{
    static char path[512];
    snprintf(path, sizeof path, "%s/examples/slides/photometric/%s.ies", SCN_SOURCE_DIR, name);
    return path;
}

static double irradiance(const World *world, size_t index, Vec3 p, Vec3 normal)
{
    const Light *light = light_set_get(world->lights, index);
    LightSample s;
    if (!light->class->sample(world, light, p, 0, 0, 0, &s)) {
        return 0;
    }
    assert_true(s.delta && s.pdf == 1);
    return (double)luminance(s.value) * dot(s.direction, normal);
}

// Reference check 15: on a floor at depth h, E = I(θ) cos³θ / h² at ten angles, in lux.
static void floor_under_a_luminaire(void **state)
{
    (void)state;
    static const char *const NAMES[] = {"downlight", "batwing", "narrow"};
    for (size_t n = 0; n < TEST_COUNT(NAMES); ++n) {
        SceneMaker maker;
        maker_init(&maker);
        PUT(&maker, "photometric_light", {"file", .text = example(NAMES[n])},
            {"position", {1, 2.5, 3}}, {"color", {1, 0.5, 0.25}});
        World *world = world_build(&maker.scene, 1, &maker.sink);
        assert_non_null(world);
        FileBytes bytes;
        Arena arena = {0};
        assert_int_equal(file_read(example(NAMES[n]), 1 << 20, &bytes), IO_OK);
        IesError error;
        const IesWeb *web = ies_read(&arena, (Str){bytes.bytes, bytes.size}, &error);
        assert_non_null(web);
        const Light *light = light_set_get(world->lights, 0);
        double lumens = ies_lumens(web), numeric = numeric_flux(web), worst = 0;
        char name[64];
        snprintf(name, sizeof name, "15 flux of %s.ies, lm", NAMES[n]);
        assert_true(trust_near(name, numeric, lumens, 2e-3 * numeric) && lumens > 100);
        assert_true(fabs(light->power * 683 / lumens - 1) < 1e-6);
        for (int k = 0; k < 2; ++k) { // along C0, which is +x; along C90, which is -z
            for (int i = 0; i < 10; ++i) {
                double theta = (8.3 * i + 1) * PI / 180, h = 2.5;
                Vec3 along = k ? vec3(0, 0, -1) : vec3(1, 0, 0);
                Vec3 p = add_scaled(vec3(1, 0, 3), along, h * tan(theta));
                double expected =
                    at_angles(web, theta * 180 / PI, k ? 90 : 0) * pow(cos(theta), 3) / (h * h);
                double lux = 683 * irradiance(world, 0, p, vec3(0, 1, 0));
                worst = fmax(worst, (fabs(lux - expected) - 1e-9) / expected);
            }
        }
        snprintf(name, sizeof name, "15 I cos3/h2 under %s.ies, relative", NAMES[n]);
        assert_true(trust_at_most(name, 1e-5, worst));
        file_bytes_free(&bytes);
        arena_free(&arena);
        world_free(world);
        maker_free(&maker);
    }
}

// Writes a file for one test.
static const char *write_file(const char *name, const char *text)
{
    static char path[512];
    snprintf(path, sizeof path, "%s/tests/%s", SCN_BINARY_DIR, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    return path;
}

// Turned by `direction`, `up` and transforms; tilted; scaled; attenuated.
static void luminaires_are_placed(void **state)
{
    (void)state;
    Arena arena = {0};
    SceneMaker maker;
    maker_init(&maker);
    char full[512], tilted[512];
    snprintf(full, sizeof full, "%s", write_file("ies_full.ies", type_c(&arena, 0, 360, 13)));
    snprintf(tilted, sizeof tilted, "%s",
             write_file("ies_tilted.ies",
                        "TILT=INCLUDE\n1 2 0 90 1 .5\n1 -1 1 2 1 1 1 0 0 0 1 1 0 0 180 0 683 683"));
    Affine turn = affine_rotation(vec3(0, 1, 0), 0.3), mirror = affine_scaling(vec3(1, 1, -2));
    uint32_t turned = scene_add_transform(&maker.scene, &turn);
    uint32_t mirrored = scene_add_transform(&maker.scene, &mirror);
    uint32_t constant = PUT_DEFAULT(&maker, "constant");
    PUT(&maker, "photometric_light", {"file", .text = full}, {"position", {0, 0, 0}},
        {"scale", {683}});
    PUT(&maker, "photometric_light", {"file", .text = full}, {"position", {0, 0, 0}},
        {"scale", {683}}, {"transform", {turned}});
    PUT(&maker, "photometric_light", {"file", .text = full}, {"position", {0, 0, 0}},
        {"scale", {683}}, {"transform", {mirrored}});
    PUT(&maker, "photometric_light", {"file", .text = full}, {"position", {0, 0, 0}},
        {"scale", {683}}, {"direction", {0, 0, -1}}, {"up", {1, 5, 1}});
    PUT(&maker, "photometric_light", {"file", .text = tilted}, {"position", {0, 0, 0}},
        {"direction", {1, -1, 0}}, {"attenuation", {constant}});
    World *world = world_build(&maker.scene, 1, &maker.sink);
    assert_non_null(world);
    // The first four share one table: the file was read once.
    const IesWeb *web = read_good(&arena, type_c(&arena, 0, 360, 13));
    for (double v = 5; v < 180; v += 35) {
        for (double h = 3; h < 360; h += 40) {
            double a = v * PI / 180, c = h * PI / 180, expected = at_angles(web, v, h);
            // Down is -y, C0 is +x, C90 is -z.
            Vec3 d = vec3(sin(a) * cos(c), -cos(a), -sin(a) * sin(c));
            assert_true(fabs(irradiance(world, 0, d, neg(d)) / expected - 1) < 1e-5);
            Vec3 t = transform_vector(&turn, d), m = vec3(d.x, d.y, -d.z);
            assert_true(fabs(irradiance(world, 1, t, neg(t)) / expected - 1) < 1e-5);
            assert_true(fabs(irradiance(world, 2, m, neg(m)) / expected - 1) < 1e-5);
            // Along -z with C0 near up: (1, 5) / √26; C90 is d × u's opposite.
            Vec3 u = normalize(vec3(1, 5, 0)), s = cross(vec3(0, 0, -1), u);
            Vec3 q = add(add(scale(vec3(0, 0, -1), cos(a)), scale(u, sin(a) * cos(c))),
                         scale(s, -sin(a) * sin(c)));
            assert_true(fabs(irradiance(world, 3, q, neg(q)) / expected - 1) < 1e-5);
        }
    }
    // 45° of tilt: 0.75 of 1 W/sr, at any distance.
    assert_true(NEAR(irradiance(world, 4, vec3(0, 0, 7), vec3(0, 0, -1)), 0.75, 1e-6));
    world_free(world);
    maker_free(&maker);
    arena_free(&arena);
}

static void wrong_lights_are_refused(void **state)
{
    (void)state;
    SceneMaker maker;
    maker_init(&maker);
    PUT(&maker, "photometric_light", {"file", .text = "/nowhere/missing.ies"},
        {"position", {0, 0, 0}});
    assert_int_equal(maker.sink.items[0].code, E0938);
    PUT(&maker, "photometric_light", {"file", .text = write_file("ies_bad.ies", "TILT=NONE\n1\n")},
        {"position", {0, 0, 0}});
    assert_int_equal(maker.sink.items[1].code, E0939);
    PUT(&maker, "photometric_light", {"file", .text = example("narrow")}, {"position", {0, 0, 0}},
        {"up", {0, 1, 0}});
    assert_int_equal(maker.sink.items[2].code, E0937);
    PUT(&maker, "photometric_light", {"file", .text = example("narrow")}, {"position", {0, 0, 0}},
        {"color", {0, 0, 0}});
    assert_int_equal(maker.sink.items[3].code, E0932);
    maker_free(&maker);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_luminaire),
        cmocka_unit_test(all_multipliers_count),
        cmocka_unit_test(sectors_are_mirrored),
        cmocka_unit_test(open_circles_are_closed),
        cmocka_unit_test(types_a_and_b),
        cmocka_unit_test(tilt_is_read),
        cmocka_unit_test(forms_of_text),
        cmocka_unit_test(damage_is_found_at_its_line),
        cmocka_unit_test(any_bytes_are_safe),
        cmocka_unit_test(memory_may_run_out),
        cmocka_unit_test(floor_under_a_luminaire),
        cmocka_unit_test(luminaires_are_placed),
        cmocka_unit_test(wrong_lights_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
