/* SPDX-License-Identifier: Apache-2.0 */
/* Metrics, block scores, composites and merged parts of pictures at their worst, against sums in
 * double precision. */

#include <float.h>
#include <string.h>

#include "pipeline/part.h"
#include "tests/unit/scratch_folder.h"

static struct fewray_frame *frame_of(int width, int height, float *planes[3]) {
    struct fewray_frame *frame = NULL;
    assert_int_equal(fewray_frame_create(width, height, &frame, NULL), FEWRAY_OK);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, planes));
    return frame;
}

static struct fewray_frame *constant_frame(int width, int height, float value) {
    float *planes[3];
    struct fewray_frame *frame = frame_of(width, height, planes);
    for (int i = 0; i < width * height; i++)
        planes[0][i] = planes[1][i] = planes[2][i] = value;
    return frame;
}

static const float VALUES[] = {0,       1e-41f,   1e-12f, 0.5f,     1,     65504, 1e12f,
                               FLT_MAX, -FLT_MAX, -1,     INFINITY, -0.0f, NAN,   -INFINITY};
enum { VALUE_COUNT = sizeof VALUES / sizeof *VALUES };

/* --- compare */

/* Both sum doubles, in another order: n * 2^-53 of the sum, n below 3000. */
#define SUM_ERROR 1e-12

/* pipeline.h's definitions; a pixel is finite in all channels or in none. */
static struct fewray_metrics reference_metrics(float *const x[3], float *const r[3], int pixels) {
    struct fewray_metrics m = {0};
    long long good = 0;
    for (int i = 0; i < pixels; i++) {
        if (!isfinite(r[0][i]) || !isfinite(r[1][i]) || !isfinite(r[2][i])) {
            m.n_ref_nonfinite++;
            continue;
        }
        const bool bad = !isfinite(x[0][i]) || !isfinite(x[1][i]) || !isfinite(x[2][i]);
        m.n_nonfinite += bad;
        good++;
        for (int c = 0; c < 3; c++) {
            const double b = r[c][i], a = bad ? 2 * b + 1 : x[c][i], d = a - b;
            m.mrse += d * d / (b * b + 0.01) / 3;
            m.mse += d * d / 3;
            m.l1 += fabs(d) / 3;
            m.mape += fabs(d) / (fabs(b) + 0.01) / 3;
        }
    }
    double *const sums[] = {&m.mrse, &m.mse, &m.l1, &m.mape};
    for (int k = 0; k < 4; k++)
        *sums[k] /= (double)good;
    return m;
}

static void expect_metrics(float *const x[3], float *const r[3], int width, int height,
                           const struct fewray_metrics *m) {
    const struct fewray_metrics expected = reference_metrics(x, r, width * height);
    assert_near(m->mrse, expected.mrse, SUM_ERROR * expected.mrse);
    assert_near(m->mse, expected.mse, SUM_ERROR * expected.mse);
    assert_near(m->l1, expected.l1, SUM_ERROR * expected.l1);
    assert_near(m->mape, expected.mape, SUM_ERROR * expected.mape);
    assert_int_equal(m->n_nonfinite, expected.n_nonfinite);
    assert_int_equal(m->n_ref_nonfinite, expected.n_ref_nonfinite);
    assert_true(m->mrse_top1 >= 0 && m->mrse_top1 <= 1);
    /* The trimmed mean leaves out the worst pixel and has one less to divide by. */
    const double n = width * height - (double)m->n_ref_nonfinite;
    assert_true(n <= 1 || (m->mrse_trimmed >= 0 &&
                           m->mrse_trimmed <= m->mrse * n / (n - 1) * (1 + SUM_ERROR)));
    assert_true(m->flip >= 0 && m->flip <= 1);
    assert_true(m->psnr >= 0); /* display images lie in 0..1; infinite for equal ones */
    if (width >= 11 && height >= 11)
        assert_true(m->ssim_loss >= 0 - SUM_ERROR && m->ssim_loss <= 2);
    else
        assert_true(isnan(m->ssim_loss));
    assert_true(isnan(m->ref_mrse) && isnan(m->mrse_net)); /* no stderr */
}

static void test_metrics_of_any_values_are_double_precisions(void **state) {
    (void)state;
    static const int sizes[][2] = {{14, 14}, {1, 14}, {14, 1}, {3, 5}, {11, 11}, {2, 40}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        const int width = sizes[s][0], height = sizes[s][1];
        float *x[3], *r[3];
        struct fewray_frame *test = frame_of(width, height, x);
        struct fewray_frame *reference = frame_of(width, height, r);
        for (int i = 0; i < width * height; i++) /* all pairs where there are enough pixels */
            for (int c = 0; c < 3; c++) {
                x[c][i] = VALUES[i % VALUE_COUNT];
                r[c][i] = VALUES[i / VALUE_COUNT % VALUE_COUNT];
            }
        struct fewray_metrics m;
        struct fewray_error error = {0};
        if (fewray_compare(test, reference, &m, &error))
            fail_msg("%d x %d: %s", width, height, error.what);
        expect_metrics(x, r, width, height, &m);
        fewray_frame_destroy(&test);
        fewray_frame_destroy(&reference);
    }
}

static void test_single_pixels_of_any_value(void **state) {
    (void)state;
    for (int a = 0; a < VALUE_COUNT; a++)
        for (int b = 0; b < VALUE_COUNT; b++) {
            float *x[3], *r[3];
            struct fewray_frame *test = constant_frame(1, 1, VALUES[a]);
            struct fewray_frame *reference = constant_frame(1, 1, VALUES[b]);
            fewray_frame_layer(test, FEWRAY_COLOR, x);
            fewray_frame_layer(reference, FEWRAY_COLOR, r);
            struct fewray_metrics m;
            const int status = fewray_compare(test, reference, &m, NULL);
            assert_int_equal(status, isfinite(VALUES[b]) ? FEWRAY_OK : FEWRAY_ERROR_ARGUMENT);
            if (!status)
                expect_metrics(x, r, 1, 1, &m);
            fewray_frame_destroy(&test);
            fewray_frame_destroy(&reference);
        }
}

static void test_equal_constants_have_no_error(void **state) {
    (void)state;
    for (int a = 0; a < VALUE_COUNT; a++) {
        if (!isfinite(VALUES[a]))
            continue;
        struct fewray_frame *test = constant_frame(12, 12, VALUES[a]);
        struct fewray_metrics m;
        assert_int_equal(fewray_compare(test, test, &m, NULL), FEWRAY_OK);
        assert_true(m.mrse == 0 && m.mse == 0 && m.l1 == 0 && m.mape == 0 && m.mrse_top1 == 0);
        assert_true(m.flip == 0 && m.psnr == INFINITY);
        assert_near(m.ssim_loss, 0, SUM_ERROR);
        fewray_frame_destroy(&test);
    }
}

/* The reference's noise isn't known where it isn't finite anywhere. */
static void test_noise_that_is_not_finite_is_not_known(void **state) {
    (void)state;
    static const char *const names[3] = {"stderr.R", "stderr.G", "stderr.B"};
    for (int a = 0; a < VALUE_COUNT; a++) {
        struct fewray_frame *test = constant_frame(4, 4, 1), *reference = constant_frame(4, 4, 2);
        for (int c = 0; c < 3; c++)
            fewray_frame_add(reference, names[c])[5] = VALUES[a];
        struct fewray_metrics m;
        assert_int_equal(fewray_compare(test, reference, &m, NULL), FEWRAY_OK);
        const double expected = (double)VALUES[a] * VALUES[a] / 4.01 / 16;
        if (isfinite(VALUES[a])) {
            assert_near(m.ref_mrse, expected, SUM_ERROR * expected);
            assert_near(m.mrse_net, 1 / 4.01 - expected, SUM_ERROR * (1 + expected));
        } else {
            assert_true(isnan(m.ref_mrse) && isnan(m.mrse_net));
        }
        fewray_frame_destroy(&test);
        fewray_frame_destroy(&reference);
    }
}

static void test_other_sizes_and_missing_channels_are_refused(void **state) {
    (void)state;
    static const int sizes[][2] = {{5, 4}, {4, 5}, {1, 20}, {20, 1}};
    struct fewray_frame *test = constant_frame(4, 4, 1);
    struct fewray_metrics m;
    for (int s = 0; s < 4; s++) {
        struct fewray_error error = {0};
        struct fewray_frame *other = constant_frame(sizes[s][0], sizes[s][1], 1);
        assert_int_equal(fewray_compare(test, other, &m, &error), FEWRAY_ERROR_ARGUMENT);
        assert_true(error.what[0]);
        fewray_frame_destroy(&other);
    }
    static const char *const channels[3] = {"R", "G", "B"};
    for (int c = 0; c < 3; c++) {
        struct fewray_frame *other = constant_frame(4, 4, 1);
        fewray_frame_remove(other, channels[c]);
        assert_int_equal(fewray_compare(test, other, &m, NULL), FEWRAY_ERROR_ARGUMENT);
        assert_int_equal(fewray_compare(other, test, &m, NULL), FEWRAY_ERROR_ARGUMENT);
        fewray_frame_destroy(&other);
    }
    fewray_frame_destroy(&test);
}

static void test_block_scores_of_any_values_are_finite(void **state) {
    (void)state;
    static const char *const names[3] = {"stderr.R", "stderr.G", "stderr.B"};
    static const int blocks[] = {1, 2, 3, 8, 9, 4096, INT32_MAX};
    for (int a = 0; a < VALUE_COUNT; a++)
        for (int place = 0; place < 3; place++) { /* test, reference, standard error */
            struct fewray_frame *test = constant_frame(8, 8, 1),
                                *reference = constant_frame(8, 8, 1);
            float *x[3], *r[3], *noise[3];
            fewray_frame_layer(test, FEWRAY_COLOR, x);
            fewray_frame_layer(reference, FEWRAY_COLOR, r);
            for (int c = 0; c < 3; c++) {
                noise[c] = fewray_frame_add(reference, names[c]);
                for (int i = 0; i < 64; i++)
                    noise[c][i] = 0.1f;
                float *const damaged[3] = {x[c], r[c], noise[c]};
                damaged[place][9] = VALUES[a];
            }
            for (size_t b = 0; b < sizeof blocks / sizeof *blocks; b++) {
                struct fewray_block_scores s;
                const int status = fewray_block_zscores(test, reference, blocks[b], &s, NULL);
                if (status) {
                    assert_int_equal(status, FEWRAY_ERROR_ARGUMENT);
                    assert_true(blocks[b] >= 8); /* smaller ones leave whole sound blocks */
                    continue;
                }
                assert_true(isfinite(s.mean) && isfinite(s.deviation) && isfinite(s.largest));
                assert_true(isfinite(s.ratio_of_means));
                long long sum = 0;
                for (int k = 0; k < FEWRAY_SCORE_BINS; k++)
                    sum += s.histogram[k];
                assert_int_equal(sum, s.count);
            }
            fewray_frame_destroy(&test);
            fewray_frame_destroy(&reference);
        }
}

/* --- composites */

static void draw(int width, int height, float value,
                 const struct fewray_composite_options *options) {
    char path[64];
    struct fewray_error error = {0};
    struct fewray_image *image = NULL;
    struct fewray_frame *noisy = constant_frame(width, height, 0.3f),
                        *denoised = constant_frame(width, height, value),
                        *reference = constant_frame(width, height, 0.5f);
    float *planes[3];
    fewray_frame_layer(reference, FEWRAY_COLOR, planes);
    if (width * height > 1)
        planes[1][0] = value;
    snprintf(path, sizeof path, "%s/composite.png", folder);
    if (fewray_composite(noisy, denoised, reference, options, path, &error))
        fail_msg("%d x %d of %g: %s", width, height, (double)value, error.what);
    assert_int_equal(fewray_image_read(path, &image, NULL), FEWRAY_OK);
    assert_true(image->width >= 3 * 420); /* a column for each picture */
    fewray_image_destroy(&image);
    fewray_frame_destroy(&noisy);
    fewray_frame_destroy(&denoised);
    fewray_frame_destroy(&reference);
}

static void test_composites_of_any_shape_value_and_exposure_are_drawn(void **state) {
    (void)state;
    static const int sizes[][2] = {{1, 1}, {1, 301}, {3, 5}, {2500, 3}, {3, 2500}};
    static const float values[] = {NAN, INFINITY, -FLT_MAX, FLT_MAX};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        draw(sizes[s][0], sizes[s][1], 0.7f, NULL);
    for (size_t v = 0; v < sizeof values / sizeof *values; v++)
        draw(5, 3, values[v], NULL);
    static const float exposures[] = {-200, INFINITY, NAN}; /* stops */
    for (size_t e = 0; e < sizeof exposures / sizeof *exposures; e++)
        draw(3, 4, 0, &(struct fewray_composite_options){.exposure = exposures[e]});
}

static void test_crops_are_cut_to_the_picture_or_refused(void **state) {
    (void)state;
    static const struct {
        struct fewray_crop crop;
        bool drawn;
    } cases[] = {
        {{0, 0, 1, 1}, true},
        {{6, 4, 1, 1}, true},
        {{0, 0, INT32_MAX, INT32_MAX}, true},
        {{6, 4, INT32_MAX, INT32_MAX}, true},
        {{0, 4, 7, 1}, true},
        {{7, 0, 1, 1}, false},
        {{0, 5, 1, 1}, false},
        {{-1, 0, 3, 3}, false},
        {{0, 0, 0, 3}, false},
        {{0, 0, 3, -1}, false},
        {{INT32_MAX, INT32_MAX, INT32_MAX, INT32_MAX}, false},
        {{INT32_MIN, 0, INT32_MAX, 1}, false},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const struct fewray_composite_options options = {.crop_count = 1, .crops = {cases[k].crop}};
        if (cases[k].drawn) {
            draw(7, 5, 0.7f, &options);
            continue;
        }
        struct fewray_frame *frame = constant_frame(7, 5, 1);
        struct fewray_error error = {0};
        assert_int_equal(fewray_composite(frame, frame, NULL, &options, "none.png", &error),
                         FEWRAY_ERROR_ARGUMENT);
        assert_true(error.what[0]);
        fewray_frame_destroy(&frame);
    }
}

/* --- merged parts */

static struct fewray_frame *part_of(float mean, float deviation, float count) {
    static const char *const names[] = {"R", "G", "B", "part.mean.R", "part.mean.G", "part.mean.B"};
    static const char *const deviations[] = {"part.deviation.R", "part.deviation.G",
                                             "part.deviation.B"};
    struct fewray_frame *frame = NULL;
    float *variance[3];
    assert_int_equal(fewray_frame_create(1, 1, &frame, NULL), FEWRAY_OK);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_VARIANCE, variance));
    for (int i = 0; i < 6; i++)
        fewray_frame_add(frame, names[i])[0] = mean;
    for (int i = 0; i < 3; i++)
        fewray_frame_add(frame, deviations[i])[0] = deviation;
    fewray_frame_add(frame, "part.count")[0] = count;
    fewray_frame_add(frame, "part.factor")[0] = count > 0 ? 1 / count : 0;
    return frame;
}

/* The mean weighted by the samples, within two roundings to float of each; the variance finite and
 * not negative, at most the 1e30 that stand for more. */
static void test_parts_of_any_radiance_merge_to_finite_pixels(void **state) {
    (void)state;
    static const float means[] = {0, 1e-41f, 1e-12f, 1, 1e12f, 1e25f, FLT_MAX, -1e12f};
    static const float counts[] = {0, 1, 2, 16777216, 1e12f};
    enum { MEANS = sizeof means / sizeof *means, COUNTS = sizeof counts / sizeof *counts };
    for (int a = 0; a < MEANS; a++)
        for (int b = 0; b < MEANS; b++)
            for (int k = 0; k < COUNTS * COUNTS; k++) {
                const float na = counts[k / COUNTS], nb = counts[k % COUNTS];
                struct fewray_frame *sum = part_of(means[a], fabsf(means[a]), na),
                                    *part = part_of(means[b], fabsf(means[b]), nb);
                assert_true(part_add(sum, part));
                part_finish(sum);
                const double expected =
                    nb > 0 ? ((double)na * means[a] + (double)nb * means[b]) / ((double)na + nb)
                           : means[a];
                const double bound = 0x1p-22 * fmax(fabs(means[a]), fabs(means[b])) + 0x1p-148;
                assert_near(fewray_frame_plane(sum, "G")[0], expected, bound);
                const float variance = fewray_frame_plane(sum, "variance.G")[0];
                assert_true(variance >= 0 && variance <= 1e30f);
                fewray_frame_destroy(&sum);
                fewray_frame_destroy(&part);
            }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_metrics_of_any_values_are_double_precisions),
        cmocka_unit_test(test_single_pixels_of_any_value),
        cmocka_unit_test(test_equal_constants_have_no_error),
        cmocka_unit_test(test_noise_that_is_not_finite_is_not_known),
        cmocka_unit_test(test_other_sizes_and_missing_channels_are_refused),
        cmocka_unit_test(test_block_scores_of_any_values_are_finite),
        cmocka_unit_test(test_composites_of_any_shape_value_and_exposure_are_drawn),
        cmocka_unit_test(test_crops_are_cut_to_the_picture_or_refused),
        cmocka_unit_test(test_parts_of_any_radiance_merge_to_finite_pixels),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
