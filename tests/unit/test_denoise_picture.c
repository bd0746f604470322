/* SPDX-License-Identifier: Apache-2.0 */
/* What the denoiser promises for any picture, whatever its weights have learned: means of what is
 * there, no invented light, outliers and damage kept small. */

#include <float.h>

#include "tests/unit/denoise_room.h"

static void test_constant_picture_stays_constant(void **state) {
    (void)state;
    static const float levels[] = {1e-6f, 0.3f, 1e5f};
    for (int level = 0; level < 3; level++) {
        struct picture p = picture_new(61, 45);
        for (size_t i = 0; i < count(&p); i++)
            p.color[i] = levels[level];
        struct fewray_denoise_input in = color_alone(&p);
        denoise(&in, p.out, 2, 0);
        for (size_t i = 0; i < count(&p); i++)
            assert_float_equal(p.out[i] / levels[level], 1.0f, 1e-3f);
        picture_clear(&p);
    }
}

static void test_black_stays_black_and_is_skipped(void **state) {
    (void)state;
    struct picture p = picture_new(100, 30);
    struct fewray_denoise_input in = all_layers(&p);
    memset(p.out, 1, count(&p) * sizeof(float));
    struct fewray_denoise_stats stats = denoise(&in, p.out, 2, 0);
    assert_int_equal(stats.tiles, 2);
    assert_int_equal(stats.tiles_denoised, 0);
    assert_int_equal(stats.regions, 0);
    for (size_t i = 0; i < count(&p); i++)
        assert_true(p.out[i] == 0.0f);
    picture_clear(&p);
}

static void test_picture_of_emitters_alone_is_kept(void **state) {
    (void)state;
    struct picture p = picture_new(70, 50);
    for (size_t i = 0; i < count(&p); i++)
        p.color[i] = p.emission[i] = (float)(i % 97);
    struct fewray_denoise_input in = all_layers(&p);
    denoise(&in, p.out, 2, 0);
    assert_memory_equal(p.out, p.emission, count(&p) * sizeof(float));
    picture_clear(&p);
}

static double mean(const float *values, size_t n) {
    double sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += values[i];
    return sum / (double)n;
}

static void test_mean_is_kept_and_noise_falls(void **state) {
    (void)state;
    struct picture p = room(203, 150);
    for (int layers = 0; layers < 2; layers++) {
        struct fewray_denoise_input in = layers ? all_layers(&p) : color_alone(&p);
        denoise(&in, p.out, 2, 0);
        double before = mean(p.color, count(&p)), after = mean(p.out, count(&p));
        /* Colour alone can't tell the lamp's edge from noise, and loses some of its light. */
        assert_true(fabs(after / before - 1.0) < (layers ? 0.05 : 0.10));
    }
    double noise[2] = {0, 0};
    for (int y = 60; y < 140; y++)
        for (int x = 4; x < 90; x++) {
            int i = 3 * (y * p.width + x);
            double wanted = p.albedo[i] * (1.0 + 0.5 * sin(0.02 * x));
            noise[0] += pow(p.color[i] - wanted, 2);
            noise[1] += pow(p.out[i] - wanted, 2);
        }
    assert_true(noise[1] < 0.1 * noise[0]);
    picture_clear(&p);
}

static void test_output_lies_between_the_smallest_and_largest_irradiance(void **state) {
    (void)state;
    struct picture p = room(90, 75);
    struct fewray_denoise_input in = all_layers(&p);
    denoise(&in, p.out, 2, 0);
    float largest = 0;
    for (size_t i = 0; i < count(&p); i++) {
        float irradiance = (p.color[i] - p.emission[i]) / fmaxf(p.albedo[i], 0.01f);
        largest = fmaxf(largest, irradiance);
    }
    for (size_t i = 0; i < count(&p); i++) {
        float irradiance = (p.out[i] - p.emission[i]) / fmaxf(p.albedo[i], 0.01f);
        assert_true(irradiance >= 0.0f && irradiance <= largest * 1.0001f);
    }
    picture_clear(&p);
}

/* The pixel's own noise is lost, but what is far away hardly notices it, and what is near isn't
 * flooded. */
static void test_outlier_is_weighted_away(void **state) {
    (void)state;
    static const float strengths[] = {1e3f, 1e6f};
    struct picture p = room(448, 256);
    struct fewray_denoise_input in = all_layers(&p);
    float *clean = layer(&p, 3);
    denoise(&in, clean, 2, 0);
    int ox = 130, oy = 190, o = 3 * (oy * p.width + ox);
    for (int s = 0; s < 2; s++) {
        for (int c = 0; c < 3; c++) {
            p.color[o + c] = strengths[s] * p.albedo[o + c];
            p.variance[o + c] = p.color[o + c] * p.color[o + c];
        }
        denoise(&in, p.out, 2, 0);
        double sum = 0;
        for (int y = 0; y < p.height; y++)
            for (int x = 0; x < p.width; x++)
                for (int c = 0; c < 3; c++) {
                    int i = 3 * (y * p.width + x) + c;
                    if (abs(x - ox) >= 200)
                        assert_float_equal(p.out[i], clean[i], 1e-3f * (1e-3f + clean[i]));
                    else if (i / 3 != o / 3)
                        sum += fabsf(p.out[i] - clean[i]);
                }
        /* Smeared, it would add about its strength. */
        assert_true(sum < 0.05 * strengths[s]);
    }
    free(clean);
    picture_clear(&p);
}

static void test_damaged_values_stay_where_they_are(void **state) {
    (void)state;
    struct picture p = room(64, 64);
    float bad[] = {NAN, INFINITY, -1.0f, FLT_MAX, -INFINITY, 1e-42f};
    float *layers[] = {p.color, p.variance, p.albedo, p.normal, p.emission};
    for (int l = 0; l < 5; l++)
        for (int i = 0; i < 6; i++)
            layers[l][3 * (1200 + 300 * l + 40 * i) + i % 3] = bad[i];
    for (int i = 0; i < 6; i++)
        p.depth[900 + 11 * i] = bad[i];
    struct fewray_denoise_input in = all_layers(&p);
    denoise(&in, p.out, 2, 0);
    for (size_t i = 0; i < count(&p); i++)
        assert_true(isfinite(p.out[i]) && p.out[i] >= 0.0f);
    picture_clear(&p);
}

static void test_smallest_pictures(void **state) {
    (void)state;
    static const int sizes[][2] = {{1, 1}, {1, 40}, {33, 1}, {2, 3}, {16, 16}, {17, 15}};
    for (int s = 0; s < 6; s++) {
        struct picture p = room(sizes[s][0], sizes[s][1]);
        struct fewray_denoise_input in = all_layers(&p);
        denoise(&in, p.out, 2, 0);
        for (size_t i = 0; i < count(&p); i++)
            assert_true(isfinite(p.out[i]));
        picture_clear(&p);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_constant_picture_stays_constant),
        cmocka_unit_test(test_black_stays_black_and_is_skipped),
        cmocka_unit_test(test_picture_of_emitters_alone_is_kept),
        cmocka_unit_test(test_mean_is_kept_and_noise_falls),
        cmocka_unit_test(test_output_lies_between_the_smallest_and_largest_irradiance),
        cmocka_unit_test(test_outlier_is_weighted_away),
        cmocka_unit_test(test_damaged_values_stay_where_they_are),
        cmocka_unit_test(test_smallest_pictures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
