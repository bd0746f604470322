/* SPDX-License-Identifier: Apache-2.0 */
/* Piecewise constant densities over the sphere, at each size that guides use. */

#include "tests/unit/check.h"

#include "guide/odis/density.h"
#include "guide/trace/sampler.h"

static const int sizes[] = {8, 16, 32};

static float uniform(uint32_t stream, uint32_t i) {
    return to_unit_float(hash_combine(stream, i));
}

static void test_directions_lie_in_their_bin(void **state) {
    (void)state;
    const float inside[] = {density_inside(0), 0.25f, 0.5f, 0.7501f, density_inside(1)};
    for (int k = 0; k < 3; k++)
        for (int b = 0; b < sizes[k] * sizes[k]; b++)
            for (int i = 0; i < 25; i++) {
                struct vec3 d = density_direction(b / sizes[k], b % sizes[k], inside[i / 5],
                                                  inside[i % 5], sizes[k]);
                assert_near(length(d), 1, 1e-5);
                assert_int_equal(density_bin(d, sizes[k]), b);
            }
}

static void test_samples_follow_density(void **state) {
    (void)state;
    enum { MOST = SPHERE_BINS };
    static float values[MOST], density[MOST];
    static double observed[MOST], expected[MOST];
    float row_cdf[SPHERE_ROWS + 1];
    const int n = 1 << 16;
    for (int k = 0; k < 3; k++) {
        int size = sizes[k], bins = size * size, degrees;
        for (int b = 0; b < bins; b++) {
            float v = uniform(1, (uint32_t)b);
            values[b] = v < 0.3f || b / size == 2 ? 0 : 1e6f * v * v;
        }
        assert_true(density_build(values, size, row_cdf, density));
        double total = 0;
        for (int b = 0; b < bins; b++) {
            observed[b] = 0;
            expected[b] = density[b] * 4 * (double)PI_F / bins;
            total += expected[b];
            expected[b] *= n;
        }
        assert_near(total, 1, 1e-5);
        for (int i = 0; i < n; i++) {
            const float u[2] = {uniform(2, (uint32_t)i), uniform(3, (uint32_t)i)};
            struct vec3 d = density_sample(row_cdf, density, size, u);
            assert_near(length(d), 1, 1e-5);
            assert_true(density[density_bin(d, size)] > 0);
            observed[density_bin(d, size)]++;
        }
        double statistic = chi_square(observed, expected, bins, &degrees);
        assert_true(degrees > bins / 2 && statistic < chi_square_limit(degrees));
    }
}

/* Even within a bin: the chi-square over 32 x 32 bins of what a coarser density draws. */
static void test_coarse_bins_are_filled_evenly(void **state) {
    (void)state;
    float values[64] = {[9] = 1, [50] = 3}, density[64], row_cdf[9];
    static double observed[SPHERE_BINS], expected[SPHERE_BINS];
    const int n = 1 << 14;
    assert_true(density_build(values, 8, row_cdf, density));
    for (int b = 0; b < SPHERE_BINS; b++) {
        int coarse = b / SPHERE_COLUMNS / 4 * 8 + b % SPHERE_COLUMNS / 4;
        observed[b] = 0;
        expected[b] = n * (double)values[coarse] / 4 / 16;
    }
    for (int i = 0; i < n; i++) {
        const float u[2] = {uniform(4, (uint32_t)i), uniform(5, (uint32_t)i)};
        observed[sphere_bin(density_sample(row_cdf, density, 8, u))]++;
    }
    int degrees;
    assert_true(chi_square(observed, expected, SPHERE_BINS, &degrees) < chi_square_limit(31));
    assert_int_equal(degrees, 31);
}

static void test_one_bin_and_extreme_random_numbers(void **state) {
    (void)state;
    const float ends[] = {0, 0x1.fffffep-1f};
    for (int k = 0; k < 3; k++) {
        static float values[SPHERE_BINS], density[SPHERE_BINS];
        float row_cdf[SPHERE_ROWS + 1];
        int bins = sizes[k] * sizes[k], bin = bins / 2 + 3;
        for (int b = 0; b < bins; b++)
            values[b] = 0;
        assert_false(density_build(values, sizes[k], row_cdf, density));
        values[bin] = NAN;
        assert_false(density_build(values, sizes[k], row_cdf, density));
        values[bin] = INFINITY;
        assert_false(density_build(values, sizes[k], row_cdf, density));
        values[bin] = 1e-30f;
        assert_true(density_build(values, sizes[k], row_cdf, density));
        for (int i = 0; i < 4; i++) {
            const float u[2] = {ends[i / 2], ends[i % 2]};
            struct vec3 d = density_sample(row_cdf, density, sizes[k], u);
            assert_int_equal(density_bin(d, sizes[k]), bin);
        }
    }
}

/* The last random number ends in the row's last filled bin, whichever way its sum was rounded. */
static void test_rounding_at_the_end_of_a_row(void **state) {
    (void)state;
    for (uint32_t seed = 0; seed < 500; seed++) {
        float values[64], density[64], row_cdf[9];
        for (uint32_t b = 0; b < 64; b++)
            values[b] = b % 8 == 0 || b % 8 > 5 ? 0 : uniform(seed + 100, b);
        assert_true(density_build(values, 8, row_cdf, density));
        for (int row = 0; row < 8; row++) {
            const float u[2] = {0.5f * (row_cdf[row] + row_cdf[row + 1]), 0x1.fffffep-1f};
            assert_int_equal(density_bin(density_sample(row_cdf, density, 8, u), 8), row * 8 + 5);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_directions_lie_in_their_bin),
        cmocka_unit_test(test_samples_follow_density),
        cmocka_unit_test(test_coarse_bins_are_filled_evenly),
        cmocka_unit_test(test_rounding_at_the_end_of_a_row),
        cmocka_unit_test(test_one_bin_and_extreme_random_numbers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
