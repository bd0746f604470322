/* SPDX-License-Identifier: Apache-2.0 */
/* Bad pixels of a picture are mended from their surroundings, and good ones left alone. */
#include "fewray/features.h"

#include <setjmp.h>
#include <stdarg.h>
/* cmocka wants the three above first */
#include <cmocka.h>
#include <math.h>

static struct fewray_frame *new_frame(int width, int height) {
    struct fewray_frame *frame = NULL;
    assert_int_equal(fewray_frame_create(width, height, &frame, NULL), FEWRAY_OK);
    return frame;
}

/* A 16 x 12 picture of 1 in all channels of the layer. */
static struct fewray_frame *flat_layer(enum fewray_layer layer, float *planes[3]) {
    struct fewray_frame *frame = new_frame(16, 12);
    assert_true(fewray_frame_add_layer(frame, layer, planes));
    for (int c = 0; c < 3 && planes[c]; c++)
        for (int i = 0; i < 16 * 12; i++)
            planes[c][i] = 1.0f;
    return frame;
}

static void test_single_bad_radiance_becomes_its_neighbours_median(void **state) {
    (void)state;
    const enum fewray_layer layers[] = {FEWRAY_COLOR, FEWRAY_NOISY, FEWRAY_EMISSION};
    const float bad[] = {NAN, INFINITY, -INFINITY, -5.0f, 1e30f, 2e5f};
    const int places[] = {0, 15, 5 * 16 + 7, 11 * 16, 12 * 16 - 1};
    for (int l = 0; l < 3; l++)
        for (size_t b = 0; b < sizeof bad / sizeof bad[0]; b++)
            for (size_t p = 0; p < sizeof places / sizeof places[0]; p++) {
                float *planes[3];
                struct fewray_frame *frame = flat_layer(layers[l], planes);
                planes[0][places[p]] = planes[2][places[p]] = bad[b];
                assert_int_equal(fewray_frame_repair(frame), 1);
                for (int i = 0; i < 16 * 12; i++)
                    assert_true(planes[0][i] == 1.0f && planes[1][i] == 1.0f &&
                                planes[2][i] == 1.0f && !signbit(planes[0][i]));
                fewray_frame_destroy(&frame);
            }
}

static void test_repairs_use_original_values_only(void **state) {
    (void)state;
    float *planes[3];
    struct fewray_frame *frame = flat_layer(FEWRAY_COLOR, planes);
    for (int i = 0; i < 16 * 12; i++)
        planes[1][i] = (float)(i % 16);
    /* A run of four: what is between 3 and 8 in the rows above and below. */
    for (int x = 4; x < 8; x++)
        planes[1][6 * 16 + x] = x % 2 ? NAN : 1e20f;
    assert_int_equal(fewray_frame_repair(frame), 4);
    for (int x = 4; x < 8; x++)
        assert_in_range((int)planes[1][6 * 16 + x], x - 1, x + 1);
    assert_int_equal(fewray_frame_repair(frame), 0);
    fewray_frame_destroy(&frame);
}

static void test_lights_of_an_area_stay(void **state) {
    (void)state;
    float *planes[3];
    struct fewray_frame *frame = flat_layer(FEWRAY_EMISSION, planes);
    for (int c = 0; c < 3; c++)
        planes[c][3 * 16 + 3] = planes[c][3 * 16 + 4] = planes[c][4 * 16 + 3] =
            planes[c][4 * 16 + 4] = 5e5f;
    planes[0][9 * 16 + 9] = 9e4f;
    assert_int_equal(fewray_frame_repair(frame), 0);
    assert_true(planes[0][3 * 16 + 3] == 5e5f && planes[2][4 * 16 + 4] == 5e5f);
    assert_true(planes[0][9 * 16 + 9] == 9e4f);
    fewray_frame_destroy(&frame);
}

static void test_nothing_but_bad_pixels_becomes_black(void **state) {
    (void)state;
    float *planes[3];
    struct fewray_frame *frame = flat_layer(FEWRAY_COLOR, planes);
    for (int i = 0; i < 16 * 12; i++)
        planes[0][i] = NAN;
    assert_int_equal(fewray_frame_repair(frame), 16 * 12);
    for (int i = 0; i < 16 * 12; i++)
        assert_true(planes[0][i] == 0.0f && planes[1][i] == 1.0f);
    fewray_frame_destroy(&frame);

    frame = new_frame(1, 1);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, planes));
    planes[0][0] = 1e30f;
    planes[1][0] = -INFINITY;
    assert_int_equal(fewray_frame_repair(frame), 1);
    assert_true(planes[0][0] == 1e12f && planes[1][0] == 0.0f);
    fewray_frame_destroy(&frame);
}

static void test_bad_auxiliary_values_become_zero(void **state) {
    (void)state;
    const struct {
        enum fewray_layer layer;
        float most;
    } cases[] = {{FEWRAY_VARIANCE, 1e24f},
                 {FEWRAY_ALBEDO, 1.0f},
                 {FEWRAY_NORMAL, 1.0f},
                 {FEWRAY_DEPTH, 1e10f},
                 {FEWRAY_IRRADIANCE, 1e12f}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        float *planes[3];
        struct fewray_frame *frame = flat_layer(cases[i].layer, planes);
        float *plane = planes[0];
        plane[0] = NAN;
        plane[1] = INFINITY;
        plane[2] = -INFINITY;
        plane[3] = -0.5f;
        plane[4] = 1e30f;
        plane[5] = 0.25f;
        const bool is_normal = cases[i].layer == FEWRAY_NORMAL;
        assert_int_equal(fewray_frame_repair(frame), is_normal ? 3 : 4);
        assert_true(plane[0] == 0.0f && plane[1] == 0.0f && plane[2] == 0.0f);
        assert_true(plane[3] == (is_normal ? -0.5f : 0.0f));
        assert_true(plane[4] == cases[i].most && plane[5] == 0.25f && plane[6] == 1.0f);
        fewray_frame_destroy(&frame);
    }
}

static void test_unknown_planes_are_left_alone(void **state) {
    (void)state;
    struct fewray_frame *frame = new_frame(2, 2);
    float *plane = fewray_frame_add(frame, "crypto00.R");
    plane[0] = NAN;
    plane[1] = -1e30f;
    assert_int_equal(fewray_frame_repair(frame), 0);
    assert_true(isnan(plane[0]) && plane[1] == -1e30f);
    fewray_frame_destroy(&frame);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_single_bad_radiance_becomes_its_neighbours_median),
        cmocka_unit_test(test_repairs_use_original_values_only),
        cmocka_unit_test(test_lights_of_an_area_stay),
        cmocka_unit_test(test_nothing_but_bad_pixels_becomes_black),
        cmocka_unit_test(test_bad_auxiliary_values_become_zero),
        cmocka_unit_test(test_unknown_planes_are_left_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
