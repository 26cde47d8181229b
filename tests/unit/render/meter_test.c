// The meter's verdicts over many seeds: how often its intervals hold what they should, that wrong
// expectations fail and right ones pass.
#include "render/meter.h"

#include "../../render/scene_maker.h"
#include "../../render/statistics.h"
#include "base/mem.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

// A white floor under a disc of light of radius 1 at the height 1, which is found by scattering
// alone, so that each sample is 1 or 0: the mean is the view factor, one half.
typedef struct Lab {
    SceneMaker maker;
    MeasureLeaf leaves[2];
    MeasureStep steps[3];
    SceneMeasure measure;
} Lab;

static MeasureLeaf floor_at(double x)
{
    return (MeasureLeaf){.sight = {.kind = SIGHT_RAY,
                                   .camera_id = NONE_ID,
                                   .origin = {x, 0.5, 0},
                                   .direction = {0, -1, 0}}};
}

static void open_lab(Lab *lab)
{
    *lab = (Lab){.leaves = {floor_at(0), floor_at(1)},
                 .steps = {{.op = MEASURE_LEAF, .a = 0}},
                 .measure = {.leaf_count = 1,
                             .step_count = 1,
                             .channels = 3,
                             .unit = "",
                             .target = {0.5, 0.5, 0.5}}};
    lab->measure.leaves = lab->leaves;
    lab->measure.steps = lab->steps;
    maker_init(&lab->maker);
    uint32_t white = PUT(&lab->maker, "lambert", {"color", {1}});
    PUT(&lab->maker, "plane", {"material", {white}});
    uint32_t disc = PUT_LIGHT_SHAPE(&lab->maker, "disc", {"center", {0, 1, 0}},
                                    {"normal", {0, -1, 0}}, {"radius", {1}});
    PUT(&lab->maker, "area_light", {"shape", {disc}}, {"radiance", {1}});
    PUT(&lab->maker, "render", {"bounces", {1}}, {"sampling", {0}, "bsdf"});
    PUT(&lab->maker, "film", {"width", {16}}, {"height", {16}}, {"filter", {0}, "box"});
}

static void close_lab(Lab *lab)
{
    maker_free(&lab->maker);
}

static Meter *new_meter(Lab *lab, MeterOptions options)
{
    Meter *meter = meter_new(&lab->maker.scene, &options, &lab->maker.sink);
    assert_non_null(meter);
    return meter;
}

static MeterResult measure_seed(Lab *lab, Meter *meter, int64_t seed)
{
    MeterResult result;
    meter_reseed(meter, seed);
    assert_true(meter_measure(meter, &lab->measure, &result));
    return result;
}

static MeterResult measure_with(Lab *lab, MeterOptions options)
{
    Meter *meter = new_meter(lab, options);
    MeterResult result = measure_seed(lab, meter, options.seed);
    meter_free(meter);
    return result;
}

static void expect_within(Lab *lab, double target, double allowed)
{
    lab->measure.relation = MEASURE_WITHIN;
    lab->measure.target[0] = lab->measure.target[1] = lab->measure.target[2] = target;
    lab->measure.allowed = allowed;
}

// Of 300 intervals at the confidence 0.9 on one channel, looked at once, 270 hold the mean: between
// 252 and 287 with a chance of 0.999. Looking up to three times, at least as many do at the end,
// where a measurement ends as soon as one doesn't.
static void intervals_are_honest(void **state)
{
    (void)state;
    enum { RUNS = 300 };
    Lab lab;
    open_lab(&lab);
    lab.measure.channels = 1;
    expect_within(&lab, 0.5, 1e-9);
    for (int looks = 1; looks <= 3; looks += 2) {
        int held = 0;
        Meter *meter = new_meter(
            &lab, (MeterOptions){.confidence = 0.9, .samples = 4096 << looks, .threads = 1});
        for (int seed = 0; seed < RUNS / looks; ++seed) {
            MeterResult result = measure_seed(&lab, meter, seed);
            held += result.verdict != METER_NOT_MET;
            assert_true((fabs(result.mean[0] - 0.5) <= result.half[0] + 1e-9) ==
                        (result.verdict != METER_NOT_MET));
        }
        meter_free(meter);
        print_message("%d of %d intervals hold the mean, %d looks\n", held, RUNS / looks, looks);
        assert_true(held > (looks == 1 ? 252 : 0.8 * RUNS / looks));
        assert_true(looks > 1 || held < 287);
    }
    close_lab(&lab);
}

// Verdicts of 100 seeds each on a mean of one half with a tolerance of 0.02: right, off by twice
// the tolerance, and just at its edge, where no more than one in a thousand may be decided either
// way (so that 3 of 100 have a chance of 2e-4).
static void wrong_expectations_fail(void **state)
{
    (void)state;
    enum { RUNS = 100 };
    static const struct {
        double target;
        int least_met, most_met, least_not, most_not;
    } cases[] = {{0.5, RUNS, RUNS, 0, 0}, {0.54, 0, 0, RUNS, RUNS}, {0.52, 0, 2, 0, 2}};
    Lab lab;
    open_lab(&lab);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        int met = 0, not_met = 0;
        expect_within(&lab, cases[i].target, 0.02);
        Meter *meter = new_meter(&lab, (MeterOptions){.samples = i < 2 ? 1 << 20 : 1 << 14});
        for (int seed = 0; seed < RUNS; ++seed) {
            MeterResult result = measure_seed(&lab, meter, 1000 + seed);
            met += result.verdict == METER_MET;
            not_met += result.verdict == METER_NOT_MET;
        }
        meter_free(meter);
        print_message("0.5 within 0.02 of %g: %d met, %d not met, of %d\n", cases[i].target, met,
                      not_met, RUNS);
        assert_in_range(met, cases[i].least_met, cases[i].most_met);
        assert_in_range(not_met, cases[i].least_not, cases[i].most_not);
    }
    close_lab(&lab);
}

// Twice as many samples as it says would decide do so.
static void says_what_it_needs(void **state)
{
    (void)state;
    Lab lab;
    open_lab(&lab);
    expect_within(&lab, 0.5, 0.002);
    for (int seed = 0; seed < 5; ++seed) {
        MeterResult few = measure_with(&lab, (MeterOptions){.seed = seed, .samples = 8192});
        assert_int_equal(few.verdict, METER_UNDECIDED);
        assert_true(few.needed > 8192 && few.needed < 1e9);
        MeterResult enough = measure_with(
            &lab, (MeterOptions){.seed = seed, .samples = (int64_t)fmax(2 * few.needed, 1e5)});
        assert_int_equal(enough.verdict, METER_MET);
    }
    close_lab(&lab);
}

// View factors 0.5 and 0.276393: their ratio, difference, and sides.
static void formulas(void **state)
{
    (void)state;
    static const double SECOND = 0.276393;
    static const struct {
        MeasureOp op;
        MeasureRelation relation;
        double target;
        MeterVerdict verdict;
    } cases[] = {
        {MEASURE_DIVIDE, MEASURE_WITHIN, 0.5 / SECOND, METER_MET},
        {MEASURE_DIVIDE, MEASURE_WITHIN, 1.05 * 0.5 / SECOND, METER_NOT_MET},
        {MEASURE_SUBTRACT, MEASURE_WITHIN, 0.5 - SECOND, METER_MET},
        {MEASURE_MULTIPLY, MEASURE_WITHIN, 0.5 * SECOND, METER_MET},
        {MEASURE_ADD, MEASURE_BELOW, 0.8, METER_MET},
        {MEASURE_ADD, MEASURE_BELOW, 0.75, METER_NOT_MET},
        {MEASURE_ADD, MEASURE_ABOVE, 0.75, METER_MET},
        {MEASURE_ADD, MEASURE_ABOVE, 0.8, METER_NOT_MET},
    };
    Lab lab;
    open_lab(&lab);
    lab.measure.leaf_count = 2;
    lab.measure.step_count = 3;
    lab.steps[1] = (MeasureStep){.op = MEASURE_LEAF, .a = 1};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        lab.steps[2] = (MeasureStep){.op = cases[i].op, .a = 0, .b = 1};
        expect_within(&lab, cases[i].target, 0.005 * cases[i].target);
        lab.measure.relation = cases[i].relation;
        MeterResult result = measure_with(&lab, (MeterOptions){.seed = 7});
        assert_int_equal(result.verdict, cases[i].verdict);
    }
    close_lab(&lab);
}

// The points of a sequence are so even that a board over 0.2501 of the picture is met by just a
// quarter of each replicate's: that they agree doesn't make it true.
static void grains_are_counted(void **state)
{
    (void)state;
    Lab lab;
    open_lab(&lab);
    Scene *scene = &lab.maker.scene;
    PUT(&lab.maker, "camera", {"position", {0, 5, 5}}, {"direction", {0, 0, -1}},
        {"projection", {0}, "orthographic"}, {"height", {1}});
    uint32_t board = PUT(&lab.maker, "rectangle", {"corner", {-9, -9, 4}},
                         {"u", {9 - 0.5 + 0.2501, 0, 0}}, {"v", {0, 99, 0}});
    scene->nodes[CATEGORY_SHAPE].items[board].name = scene_add_name(scene, STR("board"));
    scene->camera = 0;
    lab.measure.channels = 1;
    lab.leaves[0] = (MeasureLeaf){
        .coverage = true,
        .sight = {
            .kind = SIGHT_CAMERA, .x1 = 16, .y1 = 16, .camera_id = NONE_ID, .object = "board"}};
    expect_within(&lab, 0.2501, 1e-9);
    Meter *meter = new_meter(&lab, (MeterOptions){.samples = 8192});
    int alike = 0;
    for (int seed = 0; seed < 50; ++seed) {
        MeterResult result = measure_seed(&lab, meter, seed);
        alike += result.mean[0] == 0.25;
        assert_int_equal(result.verdict, METER_UNDECIDED);
    }
    print_message("%d of 50 times all replicates were alike\n", alike);
    assert_true(alike > 10);
    meter_free(meter);
    close_lab(&lab);
}

// 2 x - x is x, however it is noisy: both come from the same samples.
static void leaves_are_correlated(void **state)
{
    (void)state;
    Lab lab;
    open_lab(&lab);
    lab.steps[1] = (MeasureStep){.op = MEASURE_DIVIDE, .a = 0, .b = 0};
    lab.measure.step_count = 2;
    expect_within(&lab, 1, 1e-5);
    MeterResult result = measure_with(&lab, (MeterOptions){.seed = 1});
    assert_int_equal(result.verdict, METER_MET);
    assert_int_equal(result.samples, 8192);
    close_lab(&lab);
}

static void threads_do_not_matter(void **state)
{
    (void)state;
    Lab lab;
    open_lab(&lab);
    expect_within(&lab, 0.5, 0.002);
    MeterResult one = measure_with(&lab, (MeterOptions){.seed = 3, .threads = 1});
    MeterResult four = measure_with(&lab, (MeterOptions){.seed = 3, .threads = 4});
    assert_true(one.samples > 8192);
    assert_int_equal(one.samples, four.samples);
    assert_memory_equal(one.mean, four.mean, sizeof one.mean);
    assert_memory_equal(one.half, four.half, sizeof one.half);
    close_lab(&lab);
}

static void stops(void **state)
{
    (void)state;
    Lab lab;
    open_lab(&lab);
    atomic_int stop;
    atomic_init(&stop, 2);
    MeterResult result = measure_with(&lab, (MeterOptions){.seed = -1, .stop = &stop});
    assert_int_equal(result.verdict, METER_UNDECIDED);
    assert_true(result.stopped);
    assert_int_equal(result.samples, 0);
    close_lab(&lab);
}

static void runs_out_of_memory(void **state)
{
    (void)state;
    Lab lab;
    open_lab(&lab);
    MeterOptions options = {.seed = -1, .threads = 1};
    Meter *meter = meter_new(&lab.maker.scene, &options, &lab.maker.sink);
    assert_non_null(meter);
    expect_within(&lab, 0.5, 0.1);
    bool good = false;
    for (uint64_t allocations = 0; !good; ++allocations) {
        MeterResult result;
        mem_fail_after(allocations);
        good = meter_measure(meter, &lab.measure, &result);
        mem_fail_after(UINT64_MAX);
        assert_true(allocations < 100);
    }
    meter_free(meter);
    close_lab(&lab);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(intervals_are_honest),  cmocka_unit_test(wrong_expectations_fail),
        cmocka_unit_test(says_what_it_needs),    cmocka_unit_test(formulas),
        cmocka_unit_test(grains_are_counted),    cmocka_unit_test(leaves_are_correlated),
        cmocka_unit_test(threads_do_not_matter), cmocka_unit_test(stops),
        cmocka_unit_test(runs_out_of_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
