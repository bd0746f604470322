/* SPDX-License-Identifier: Apache-2.0 */
/* Sample points, directions and their densities: each density integrates to 1 and the samples
 * follow it. */

#include "tests/unit/check.h"
#include "tests/unit/lambert_shading.h"

#include "guide/basis.h"
#include "guide/bsdf/bsdf.h"
#include "guide/light/distribution.h"
#include "guide/odis/sphere_grid.h"
#include "guide/trace/sampler.h"

/* Every elementary interval of 2^n points of a (0,2)-sequence holds exactly one of them. */
static void test_sobol_points_are_stratified(void **state) {
    (void)state;
    for (uint32_t seed = 0; seed < 20; seed++)
        for (int log_x = 0; log_x <= 6; log_x++) {
            int nx = 1 << log_x, ny = 64 / nx, hits[64] = {0};
            for (uint32_t i = 0; i < 64; i++) {
                float u[2];
                sobol_point(i, hash_u32(seed), u);
                assert_true(u[0] >= 0 && u[0] < 1 && u[1] >= 0 && u[1] < 1);
                hits[(int)(u[0] * (float)nx) * ny + (int)(u[1] * (float)ny)]++;
            }
            for (int i = 0; i < 64; i++)
                assert_int_equal(hits[i], 1);
        }
}

static void test_pixels_are_decorrelated(void **state) {
    (void)state;
    double sum = 0;
    for (uint32_t pixel = 0; pixel < 10000; pixel++) {
        float u[2], v[2];
        sobol_point(0, hash_combine(7, pixel), u);
        sobol_point(0, hash_combine(7, pixel + 1), v);
        sum += (u[0] - 0.5) * (v[0] - 0.5);
    }
    assert_near(sum / 10000 * 12, 0, 0.05);
}

/* Of a pixel's four samples, the look's and the rest's, each pair of dimensions before the branch
 * falls into the four quarters of the square, and into the quarters of either axis. */
static void test_samples_before_a_branch_are_stratified(void **state) {
    (void)state;
    for (uint32_t pixel = 0; pixel < 200; pixel++) {
        int hits[3][12] = {{0}};
        for (uint32_t i = 0; i < 4; i++) {
            struct sampler sampler = sampler_start(hash_combine(11, pixel), i);
            for (int pair = 0; pair < 3; pair++) {
                float u[2];
                sampler_2d(&sampler, u);
                hits[pair][(int)(2 * u[0]) * 2 + (int)(2 * u[1])]++;
                hits[pair][4 + (int)(4 * u[0])]++;
                hits[pair][8 + (int)(4 * u[1])]++;
            }
        }
        for (int k = 0; k < 36; k++)
            assert_int_equal(hits[k / 12][k % 12], 1);
    }
}

/* After it, equal dimensions are independent, those of one sample and of neighbouring ones. */
static void test_branches_are_independent(void **state) {
    (void)state;
    enum { N = 10000 };
    for (uint32_t index = 0; index < 2; index++) {
        double products = 0;
        for (uint32_t pixel = 0; pixel < N; pixel++) {
            struct sampler a = sampler_start(hash_combine(12, pixel), 0);
            struct sampler b = sampler_start(hash_combine(12, pixel), index);
            float u[2], v[2];
            sampler_2d(&a, u), sampler_2d(&b, v);
            assert_true((u[0] == v[0] && u[1] == v[1]) == (index == 0));
            sampler_branch(&a, 1), sampler_branch(&b, 2);
            sampler_2d(&a, u), sampler_2d(&b, v);
            assert_true(u[0] != v[0] || u[1] != v[1]);
            products += (u[0] - 0.5) * (v[0] - 0.5) + (u[1] - 0.5) * (v[1] - 0.5);
        }
        assert_near(products / (2 * N) * 12, 0, 0.03);
    }
}

static void test_cdf_follows_weights(void **state) {
    (void)state;
    const float weights[5] = {1, 0, 3, 0.5f, 0};
    float cdf[6];
    assert_near(cdf_build(weights, 5, cdf), 4.5, 1e-6);
    double counts[5] = {0};
    for (int i = 0; i < 45000; i++) {
        float u = ((float)i + 0.5f) / 45000;
        size_t k = cdf_sample(cdf, 5, &u);
        assert_true(u >= 0 && u < 1);
        counts[k]++;
    }
    for (int k = 0; k < 5; k++)
        assert_near(counts[k], weights[k] * 10000, 2);
}

typedef struct vec3 (*direction_sampler)(const struct environment_table *, const float *, float *);

static struct vec3 lambert_sample(const struct environment_table *unused, const float u[2],
                                  float *pdf) {
    (void)unused;
    struct shading s = lambert_shading(normalize(vec(0.3f, 0.8f, -0.5f)));
    struct bsdf_sample sample;
    assert_true(bsdf_sample(&s, 0, u, &sample));
    *pdf = bsdf_pdf(&s, sample.direction);
    assert_near(sample.pdf, *pdf, 1e-5);
    return sample.direction;
}

static float lambert_pdf(struct vec3 d) {
    struct shading s = lambert_shading(normalize(vec(0.3f, 0.8f, -0.5f)));
    return bsdf_pdf(&s, d);
}

/* Integrates a density over each bin of the sphere and compares with where 2^18 samples fall. */
static void check_directions(direction_sampler sample, const struct environment_table *table,
                             bool lambert) {
    static double observed[SPHERE_BINS], expected[SPHERE_BINS];
    const int n = 1 << 18;
    double total = 0;
    for (int b = 0; b < SPHERE_BINS; b++) {
        observed[b] = expected[b] = 0;
        for (int k = 0; k < 1024; k++) {
            struct vec3 d =
                sphere_direction(b / SPHERE_COLUMNS, b % SPHERE_COLUMNS,
                                 ((float)(k / 32) + 0.5f) / 32, ((float)(k % 32) + 0.5f) / 32);
            expected[b] += (lambert ? lambert_pdf(d) : environment_pdf(table, d)) *
                           SPHERE_BIN_SOLID_ANGLE / 1024;
        }
        total += expected[b];
        expected[b] *= n;
    }
    assert_near(total, 1, 0.01);
    int other_cell = 0; /* rounding may put a direction on a cell's border into the next one */
    for (int i = 0; i < n; i++) {
        /* Plain pseudo-random numbers: the statistic is for independent samples. */
        float u[2] = {to_unit_float(hash_combine(1, (uint32_t)i)),
                      to_unit_float(hash_combine(2, (uint32_t)i))},
              pdf;
        struct vec3 d = sample(table, u, &pdf);
        assert_near(length(d), 1, 1e-4);
        if (!lambert)
            other_cell += fabsf(environment_pdf(table, d) / pdf - 1) > 0.01f;
        observed[sphere_bin(d)]++;
    }
    assert_true(other_cell <= n / 10000);
    int degrees;
    double statistic = chi_square(observed, expected, SPHERE_BINS, &degrees);
    assert_true(degrees > 100);
    assert_true(statistic < chi_square_limit(degrees));
}

static void test_lambert_samples_follow_pdf(void **state) {
    (void)state;
    check_directions(lambert_sample, NULL, true);
}

static void test_constant_environment_samples_follow_pdf(void **state) {
    (void)state;
    struct environment e = {.kind = ENVIRONMENT_CONSTANT, .radiance = {1, 1, 1}};
    struct environment_table table;
    assert_int_equal(environment_table_create(&e, &table, NULL), 0);
    check_directions(environment_sample, &table, false);
    environment_table_clear(&table);
}

static void test_environment_map_samples_follow_pdf(void **state) {
    (void)state;
    enum { W = 32, H = 32 };
    float pixels[W * H * 3];
    for (int i = 0; i < W * H; i++)
        pixels[3 * i] = pixels[3 * i + 1] = pixels[3 * i + 2] =
            0.1f + (float)(i % W == 7 && i / W == 9) * 30;
    struct fewray_image image = {W, H, 3, NULL, pixels};
    struct environment e = {.kind = ENVIRONMENT_MAP,
                            .image = &image,
                            .scale = 1,
                            .to_local = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    struct environment_table table;
    assert_int_equal(environment_table_create(&e, &table, NULL), 0);
    check_directions(environment_sample, &table, false);
    environment_table_clear(&table);
}

static void test_sphere_bins_hold_their_directions(void **state) {
    (void)state;
    for (int b = 0; b < SPHERE_BINS; b++)
        for (int k = 0; k < 16; k++) {
            struct vec3 d = sphere_direction(b / SPHERE_COLUMNS, b % SPHERE_COLUMNS,
                                             0.01f + 0.98f * (float)(k / 4) / 3,
                                             0.01f + 0.98f * (float)(k % 4) / 3);
            assert_int_equal(sphere_bin(d), b);
        }
}

static void test_power_heuristic_sums_to_one(void **state) {
    (void)state;
    const float pdfs[] = {1e-20f, 1e-6f, 0.3f, 1, 7, 1e10f, 1e30f};
    for (int i = 0; i < 7; i++)
        for (int k = 0; k < 7; k++)
            assert_near(power_heuristic(pdfs[i], pdfs[k]) + power_heuristic(pdfs[k], pdfs[i]), 1,
                        1e-6);
    assert_near(power_heuristic(0, 1), 0, 0);
    assert_near(power_heuristic(1, 0), 1, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sobol_points_are_stratified),
        cmocka_unit_test(test_pixels_are_decorrelated),
        cmocka_unit_test(test_samples_before_a_branch_are_stratified),
        cmocka_unit_test(test_branches_are_independent),
        cmocka_unit_test(test_cdf_follows_weights),
        cmocka_unit_test(test_lambert_samples_follow_pdf),
        cmocka_unit_test(test_constant_environment_samples_follow_pdf),
        cmocka_unit_test(test_environment_map_samples_follow_pdf),
        cmocka_unit_test(test_sphere_bins_hold_their_directions),
        cmocka_unit_test(test_power_heuristic_sums_to_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
