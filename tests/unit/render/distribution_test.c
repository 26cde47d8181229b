#include "../test_support.h"

#include "render/distribution.h"

#include "../../render/statistics.h"

// The chance that a table gives each item, read off its slots.
static void table_chances(const AliasTable *table, double *out)
{
    for (uint32_t i = 0; i < table->count; ++i) {
        out[i] = 0;
    }
    for (uint32_t i = 0; i < table->count; ++i) {
        out[i] += (double)table->threshold[i] / table->count;
        out[table->alias[i]] += (1 - (double)table->threshold[i]) / table->count;
    }
}

static void alias_table_holds_its_weights(void **state)
{
    (void)state;
    static const double weights[][6] = {
        {1, 1, 1, 1, 1, 1}, {1, 2, 3, 4, 5, 6},    {1e9, 1, 1e-9, 0, 0, 1},
        {0, 0, 7, 0, 0, 0}, {1e-3, 1, 0, 5, 0, 2},
    };
    for (size_t k = 0; k < TEST_COUNT(weights); ++k) {
        Arena arena = {0};
        AliasTable table;
        assert_true(alias_table_build(&table, &arena, weights[k], 6));
        double total = 0, chances[6];
        for (int i = 0; i < 6; ++i) {
            total += weights[k][i];
        }
        table_chances(&table, chances);
        for (int i = 0; i < 6; ++i) {
            assert_true(NEAR(chances[i], weights[k][i] / total, 1e-7));
            assert_true(NEAR(table.chance[i], weights[k][i] / total, 1e-7));
        }
        arena_free(&arena);
    }
}

static void alias_table_of_many(void **state)
{
    (void)state;
    enum { COUNT = 100000 };
    Arena arena = {0};
    double *weights = arena_array(&arena, COUNT, sizeof *weights);
    double *chances = arena_array(&arena, COUNT, sizeof *chances);
    TestRandom random = {1};
    double total = 0;
    for (int i = 0; i < COUNT; ++i) {
        weights[i] = exp(10 * (double)test_random(&random));
        total += weights[i];
    }
    AliasTable table;
    assert_true(alias_table_build(&table, &arena, weights, COUNT));
    table_chances(&table, chances);
    for (int i = 0; i < COUNT; ++i) {
        assert_true(fabs(chances[i] - weights[i] / total) < 1e-7 / COUNT + 1e-6 * chances[i]);
        uint32_t chosen = alias_table_choose(&table, (i + 0.5) / COUNT);
        assert_true(chosen == (uint32_t)i || chosen == table.alias[i]);
    }
    assert_int_equal(alias_table_choose(&table, 1 - 0x1p-53) < COUNT, 1);
    arena_free(&arena);
}

static void alias_table_without_weight_is_uniform(void **state)
{
    (void)state;
    Arena arena = {0};
    AliasTable table;
    double weights[3] = {0, 0, 0}, chances[3];
    assert_true(alias_table_build(&table, &arena, weights, 3));
    table_chances(&table, chances);
    for (int i = 0; i < 3; ++i) {
        assert_true(NEAR(chances[i], 1.0 / 3, 1e-7));
    }
    arena_free(&arena);
}

static void grid_chooses_by_weight(void **state)
{
    (void)state;
    enum { W = 5, H = 4, SAMPLES = 400000 };
    static const double weights[H][W] = {
        {0, 0, 0, 0, 0}, {1, 2, 0, 4, 0.5}, {0, 0, 30, 0, 0}, {3, 0, 0, 0, 9}};
    Arena arena = {0};
    Grid grid;
    assert_true(grid_allocate(&grid, &arena, W, H));
    double total = 0, observed[W * H] = {0}, expected[W * H];
    for (int y = 0; y < H; ++y) {
        for (int x = 0; x < W; ++x) {
            grid.cells[y * (W + 1) + x + 1] = weights[y][x];
            total += weights[y][x];
        }
    }
    grid_sum(&grid);
    TestRandom random = {7};
    double mean_x = 0, mean_y = 0;
    for (int i = 0; i < SAMPLES; ++i) {
        uint32_t x, y;
        double in_x, in_y;
        double u = (double)test_random(&random), v = (double)test_random(&random);
        assert_true(grid_choose(&grid, u, v, &x, &y, &in_x, &in_y));
        assert_true(weights[y][x] > 0 && in_x >= 0 && in_x < 1 && in_y >= 0 && in_y < 1);
        observed[y * W + x] += 1;
        mean_x += in_x / SAMPLES;
        mean_y += in_y / SAMPLES;
    }
    for (uint32_t i = 0; i < W * H; ++i) {
        expected[i] = SAMPLES * weights[i / W][i % W] / total;
        assert_true(NEAR(grid_chance(&grid, i % W, i / W), expected[i] / SAMPLES, 1e-12));
    }
    // Two means and one chi-squared at a family's 1e-3.
    double level = sidak(1e-3, 3), error = sqrt(1.0 / 12 / SAMPLES);
    assert_true(chi_squared_test(observed, expected, W * H) > level);
    assert_true(student_p((mean_x - 0.5) / error, SAMPLES) > level);
    assert_true(student_p((mean_y - 0.5) / error, SAMPLES) > level);
    arena_free(&arena);
}

static void grid_without_weight_chooses_nothing(void **state)
{
    (void)state;
    Arena arena = {0};
    Grid grid;
    uint32_t x, y;
    double in_x, in_y;
    assert_false(grid_allocate(&grid, &arena, 0, 3));
    assert_true(grid_allocate(&grid, &arena, 2, 1));
    grid.cells[1] = grid.cells[2] = 0;
    grid_sum(&grid);
    assert_false(grid_choose(&grid, 0.5, 0.5, &x, &y, &in_x, &in_y));
    assert_true(grid_chance(&grid, 0, 0) == 0);
    arena_free(&arena);
}

// The helper itself, against tables.
static void statistics_are_right(void **state)
{
    (void)state;
    assert_true(NEAR(chi_squared_p(3.841459, 1), 0.05, 1e-6));
    assert_true(NEAR(chi_squared_p(124.342, 100), 0.05, 1e-5));
    assert_true(NEAR(student_p(2.228139, 10), 0.05, 1e-6));
    assert_true(NEAR(student_quantile(0.001, 31), 3.633456, 1e-5));
    assert_true(NEAR(sidak(0.05, 10), 0.0051162, 1e-6));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(alias_table_holds_its_weights),
        cmocka_unit_test(alias_table_of_many),
        cmocka_unit_test(alias_table_without_weight_is_uniform),
        cmocka_unit_test(grid_chooses_by_weight),
        cmocka_unit_test(grid_without_weight_chooses_nothing),
        cmocka_unit_test(statistics_are_right),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
