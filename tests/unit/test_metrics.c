/* SPDX-License-Identifier: Apache-2.0 */
/* The metrics against values that NumPy, scikit-image and flip-evaluator computed independently for
 * the stored pair of pictures, which has pixels that aren't finite on both sides, highlights and
 * dark parts. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <jansson.h>

#include "fewray/pipeline.h"

static struct fewray_frame *read_frame(const char *path) {
    struct fewray_frame *frame = NULL;
    struct fewray_error error;
    if (fewray_frame_read_exr(path, &frame, &error))
        fail_msg("%s", error.what);
    return frame;
}

static struct fewray_frame *make_frame(int width, int height, float value) {
    struct fewray_frame *frame = NULL;
    float *planes[3];
    assert_int_equal(fewray_frame_create(width, height, &frame, NULL), 0);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, planes));
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < width * height; i++)
            planes[c][i] = value;
    return frame;
}

static void expect_within(json_t *expected, const char *key, double value, double tolerance) {
    const double wanted = json_number_value(json_object_get(expected, key));
    if (!(fabs(value - wanted) <= tolerance * fabs(wanted)))
        fail_msg("%s is %.8g, expected %.8g", key, value, wanted);
}

static void expect_close(json_t *expected, const char *key, double value) {
    expect_within(expected, key, value, 5e-5);
}

static void test_metrics_equal_independent_values(void **state) {
    (void)state;
    struct fewray_frame *test = read_frame(TEST_DATA "/metrics/test.exr");
    struct fewray_frame *reference = read_frame(TEST_DATA "/metrics/reference.exr");
    json_t *expected = json_load_file(TEST_DATA "/metrics/expected.json", 0, NULL);
    assert_non_null(expected);
    struct fewray_metrics m;
    assert_int_equal(fewray_compare(test, reference, &m, NULL), 0);
    expect_close(expected, "mrse", m.mrse);
    expect_close(expected, "mrse_trimmed", m.mrse_trimmed);
    expect_close(expected, "mrse_top1", m.mrse_top1);
    expect_close(expected, "mse", m.mse);
    expect_close(expected, "mape", m.mape);
    expect_close(expected, "l1", m.l1);
    expect_close(expected, "psnr", m.psnr);
    expect_close(expected, "ssim_loss", m.ssim_loss);
    expect_within(expected, "flip", m.flip, 2e-4); /* both in single precision */
    expect_close(expected, "ref_mrse", m.ref_mrse);
    expect_close(expected, "mrse_net", m.mrse_net);
    expect_close(expected, "n_nonfinite", (double)m.n_nonfinite);
    expect_close(expected, "n_ref_nonfinite", (double)m.n_ref_nonfinite);
    json_decref(expected);
    fewray_frame_destroy(&test);
    fewray_frame_destroy(&reference);
}

static void test_equal_pictures_have_no_error(void **state) {
    (void)state;
    struct fewray_frame *frame = make_frame(16, 12, 0.3f);
    struct fewray_metrics m;
    assert_int_equal(fewray_compare(frame, frame, &m, NULL), 0);
    assert_true(m.mrse == 0 && m.mrse_top1 == 0 && m.mse == 0 && m.l1 == 0 && m.mape == 0);
    assert_true(fabs(m.ssim_loss) < 1e-12);
    assert_true(m.flip == 0);
    assert_true(isinf(m.psnr));
    assert_true(isnan(m.ref_mrse) && isnan(m.mrse_net));
    fewray_frame_destroy(&frame);
}

static void test_pictures_below_the_ssim_window_have_no_ssim(void **state) {
    (void)state;
    struct fewray_frame *one = make_frame(10, 12, 0.3f), *two = make_frame(10, 12, 0.4f);
    struct fewray_metrics m;
    assert_int_equal(fewray_compare(one, two, &m, NULL), 0);
    assert_true(isnan(m.ssim_loss));
    assert_true(fabs(m.l1 - 0.1) < 1e-6);
    fewray_frame_destroy(&one);
    fewray_frame_destroy(&two);
}

static void test_other_sizes_and_bad_references_are_refused(void **state) {
    (void)state;
    struct fewray_frame *one = make_frame(10, 12, 0.3f), *two = make_frame(12, 10, 0.3f);
    struct fewray_frame *bad = make_frame(10, 12, NAN);
    struct fewray_metrics m;
    assert_int_equal(fewray_compare(one, two, &m, NULL), FEWRAY_ERROR_ARGUMENT);
    assert_int_equal(fewray_compare(one, bad, &m, NULL), FEWRAY_ERROR_ARGUMENT);
    fewray_frame_destroy(&one);
    fewray_frame_destroy(&two);
    fewray_frame_destroy(&bad);
}

static struct fewray_frame *colored_frame(float red, float green, float blue) {
    struct fewray_frame *frame = make_frame(48, 40, 0);
    const float color[3] = {red, green, blue};
    float *planes[3];
    assert_true(fewray_frame_layer(frame, FEWRAY_COLOR, planes));
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 48 * 40; i++)
            planes[c][i] = color[c];
    return frame;
}

static double flip_between(const struct fewray_frame *one, const struct fewray_frame *two) {
    struct fewray_metrics m;
    assert_int_equal(fewray_compare(one, two, &m, NULL), 0);
    return m.flip;
}

/* Andersson et al. 2020: no two colours of a display differ more than its green and its blue. */
static void test_flip_is_largest_between_green_and_blue(void **state) {
    (void)state;
    struct fewray_frame *green = colored_frame(0, 1, 0), *blue = colored_frame(0, 0, 1),
                        *red = colored_frame(1, 0, 0), *bright = colored_frame(0, 7, 0);
    assert_true(fabs(flip_between(green, blue) - 1) < 1e-4);
    assert_true(flip_between(red, blue) < 0.99 && flip_between(red, green) < 0.99);
    assert_true(flip_between(green, bright) == 0); /* a display shows no more than 1 */
    fewray_frame_destroy(&green);
    fewray_frame_destroy(&blue);
    fewray_frame_destroy(&red);
    fewray_frame_destroy(&bright);
}

/* A lone pixel's difference is seen where it makes a point, and less where its neighbours take it
 * back: from afar their mean is seen. */
static void test_flip_sees_means_and_features(void **state) {
    (void)state;
    struct fewray_frame *grey = make_frame(64, 64, 0.2f), *point = make_frame(64, 64, 0.2f),
                        *weave = make_frame(64, 64, 0.2f), *shifted = make_frame(64, 64, 0.3f);
    for (int c = 0; c < 3; c++) {
        const char *const names[3] = {"R", "G", "B"};
        fewray_frame_plane(point, names[c])[32 * 64 + 32] = 1;
        for (int i = 0; i < 64 * 64; i++)
            fewray_frame_plane(weave, names[c])[i] += (i + i / 64) % 2 ? 0.1f : -0.1f;
    }
    assert_true(flip_between(point, grey) > 0);
    assert_true(flip_between(weave, grey) < 0.2 * flip_between(shifted, grey));
    assert_true(fabs(flip_between(point, weave) - flip_between(weave, point)) < 1e-7);
    fewray_frame_destroy(&grey);
    fewray_frame_destroy(&point);
    fewray_frame_destroy(&weave);
    fewray_frame_destroy(&shifted);
}

/* Adds errors of deviation 0.5 (uniform ones) and a constant bias; a stderr layer that tells 0.5.
 */
static struct fewray_frame *noisy_frame(double bias) {
    struct fewray_frame *frame = make_frame(80, 80, 2);
    static const char *const names[] = {"stderr.R", "stderr.G", "stderr.B", "R", "G", "B"};
    uint32_t seed = 1;
    for (int c = 0; c < 3; c++) {
        float *told = fewray_frame_add(frame, names[c]),
              *x = fewray_frame_plane(frame, names[3 + c]);
        for (int i = 0; i < 80 * 80; i++) {
            seed = seed * 1664525u + 1013904223u;
            told[i] = 0.5f;
            x[i] += (float)((seed / 4294967296.0 - 0.5) * sqrt(3) + bias);
        }
    }
    return frame;
}

static void test_block_scores_tell_noise_from_bias(void **state) {
    (void)state;
    struct fewray_frame *flat = make_frame(80, 80, 2);
    struct fewray_block_scores s;
    struct fewray_frame *noise = noisy_frame(0), *biased = noisy_frame(0.1);
    assert_int_equal(fewray_block_zscores(flat, noise, 4, &s, NULL), 0);
    assert_int_equal(s.count, 3 * 20 * 20);
    assert_true(fabs(s.mean) < 0.12 && s.deviation > 0.9 && s.deviation < 1.1);
    assert_int_equal(fewray_block_zscores(flat, biased, 4, &s, NULL), 0);
    assert_true(s.mean < -0.6 && s.ratio_of_means < 0.98);
    assert_int_equal(fewray_block_zscores(flat, noise, 100, &s, NULL), FEWRAY_ERROR_ARGUMENT);
    assert_int_equal(fewray_block_zscores(noise, flat, 4, &s, NULL), FEWRAY_ERROR_FORMAT);
    /* Next to no standard error: z of 1e30, far from any bin, belongs to the last ones. */
    static const char *const names[] = {"stderr.R", "stderr.G", "stderr.B"};
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 80 * 80; i++)
            fewray_frame_plane(noise, names[c])[i] = 1e-30f;
    assert_int_equal(fewray_block_zscores(flat, noise, 4, &s, NULL), 0);
    assert_int_equal(s.histogram[0] + s.histogram[FEWRAY_SCORE_BINS - 1], 3 * 20 * 20);
    fewray_frame_destroy(&flat);
    fewray_frame_destroy(&noise);
    fewray_frame_destroy(&biased);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_metrics_equal_independent_values),
        cmocka_unit_test(test_equal_pictures_have_no_error),
        cmocka_unit_test(test_flip_is_largest_between_green_and_blue),
        cmocka_unit_test(test_flip_sees_means_and_features),
        cmocka_unit_test(test_pictures_below_the_ssim_window_have_no_ssim),
        cmocka_unit_test(test_other_sizes_and_bad_references_are_refused),
        cmocka_unit_test(test_block_scores_tell_noise_from_bias),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
