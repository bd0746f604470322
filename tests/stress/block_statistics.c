/* SPDX-License-Identifier: Apache-2.0 */
/* The bias study's own arithmetic: no false alarms, and no bias overlooked. */

#include "tests/unit/check.h"

#include "block_means.h"
#include "guide/trace/sampler.h"

/* Box and Muller 1958. */
static double normal(uint32_t stream, uint32_t i) {
    const double u = to_unit_float(hash_combine(stream, 2 * i)) + 0x1p-25;
    return sqrt(-2 * log(u)) * cos(2 * M_PI * to_unit_float(hash_combine(stream, 2 * i + 1)));
}

/* Against tables of the distributions. */
static void test_limits_are_the_tables(void **state) {
    (void)state;
    assert_near(normal_limit(0.0026998), 3, 1e-4);
    assert_near(normal_limit(0.05), 1.959964, 1e-5);
    assert_near(normal_limit(1e-6), 4.891638, 1e-5);
    assert_int_equal(binomial_limit(10, 0.5, 0.001),
                     9); /* P(10) = 1 / 1024, P(9, 10) = 11 / 1024 */
    assert_int_equal(binomial_limit(10, 0.5, 0.0005), 10);
    assert_int_equal(binomial_limit(1000, 0.0026998, 0.001), 9);
}

enum { SETS = 4000 };

/* z of `SETS` blocks whose means are off by `shift` standard deviations of a render's; how many are
 * beyond 3, and their mean. */
static int simulate(int a_renders, int b_renders, double b_spread, double shift, double *mean) {
    int over = 0;
    *mean = 0;
    for (uint32_t s = 0; s < SETS; s++) {
        struct block_sum a = {0, 0}, b = {0, 0};
        for (int i = 0; i < a_renders; i++)
            block_sum_add(&a, 10 + shift + normal(2 * s, (uint32_t)i), i + 1);
        for (int i = 0; i < b_renders; i++)
            block_sum_add(&b, 10 + b_spread * normal(2 * s + 1, (uint32_t)i), i + 1);
        const double z = block_z(&a, a_renders, &b, b_renders);
        over += fabs(z) > 3;
        *mean += z / SETS;
    }
    return over;
}

/* Few and many renders, equal and unequal noise: as many beyond 3 as the normal distribution has,
 * at a level of 1e-4, and on both sides alike. */
static void test_equal_expectations_give_no_alarm(void **state) {
    (void)state;
    const struct {
        int a, b;
        double spread;
    } cases[] = {{64, 64, 1}, {64, 64, 0.2}, {24, 48, 3}, {12, 12, 1}, {12, 12, 0.3}};
    for (int k = 0; k < 5; k++) {
        double mean;
        const int over = simulate(cases[k].a, cases[k].b, cases[k].spread, 0, &mean);
        if (over > binomial_limit(SETS, BLOCK_BEYOND_3, 1e-4) || over == 0)
            fail_msg("%d and %d renders, spread %g: %d of %d beyond 3", cases[k].a, cases[k].b,
                     cases[k].spread, over, SETS);
        assert_near(mean, 0, 4 / sqrt(SETS));
    }
}

/* 5 standard errors of 64 and 64 renders: seen by 96 to 99 of 100 blocks. */
static void test_bias_is_seen(void **state) {
    (void)state;
    double mean;
    const int over = simulate(64, 64, 1, 5 * sqrt(2.0 / 64), &mean);
    assert_true(over > 0.95 * SETS && mean > 4.5 && mean < 5.2);
}

static void test_blocks_cover_the_picture_once(void **state) {
    (void)state;
    enum { WIDTH = 19, HEIGHT = 11 };
    float plane[WIDTH * HEIGHT];
    struct block_means means = {0};
    double sum = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        plane[i] = (float)(i + 1);
    const float *const planes[3] = {plane, plane, plane};
    assert_true(block_means_add(&means, planes, WIDTH, HEIGHT));
    assert_int_equal(means.columns * means.rows, 6);
    for (int b = 0; b < 6; b++)
        sum += means.blocks[b].mean * (b % 3 < 2 ? 8 : 3) * (b < 3 ? 8 : 3);
    assert_near(sum, WIDTH * HEIGHT * (WIDTH * HEIGHT + 1) / 2.0, 1e-6);
    assert_near(means.picture.mean, (WIDTH * HEIGHT + 1) / 2.0, 1e-9);
    free(means.blocks);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_limits_are_the_tables),
        cmocka_unit_test(test_equal_expectations_give_no_alarm),
        cmocka_unit_test(test_bias_is_seen),
        cmocka_unit_test(test_blocks_cover_the_picture_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
