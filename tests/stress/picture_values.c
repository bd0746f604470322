/* SPDX-License-Identifier: Apache-2.0 */
/* Values at their worst on their way through files: half and 32-bit EXR, PNG, repair. */

#include <float.h>
#include <string.h>

#include "fewray/features.h"
#include "tests/unit/scratch_folder.h"

static const char *path_of(const char *name) {
    static char path[64];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static struct fewray_frame *frame_of(int width, int height, float *planes[3]) {
    struct fewray_frame *frame = NULL;
    assert_int_equal(fewray_frame_create(width, height, &frame, NULL), FEWRAY_OK);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, planes));
    return frame;
}

/* Writes the frame and reads it again. */
static struct fewray_frame *round_trip(const struct fewray_frame *frame, bool float32) {
    struct fewray_frame *back = NULL;
    struct fewray_error error = {0};
    const char *path = path_of("trip.exr");
    if (fewray_frame_write_exr(frame, path, float32, &error) ||
        fewray_frame_read_exr(path, &back, &error))
        fail_msg("%s", error.what);
    return back;
}

/* --- EXR */

/* half: what features.h promises; NaN for NaN. */
static const struct {
    float value, half;
} VALUES[] = {
    {0, 0},
    {-0.0f, -0.0f},
    {1, 1},
    {65504, 65504}, /* the largest half */
    {65519, 65504},
    {65520, 65504}, /* would round to infinity */
    {1e12f, 65504},
    {FLT_MAX, 65504},
    {INFINITY, 65504},
    {-65505, -65504},
    {-INFINITY, -65504},
    {NAN, NAN},
    {0x1p-14f, 0x1p-14f},   /* the least normal half */
    {0x1p-24f, 0x1p-24f},   /* the least denormal */
    {0x1.8p-24f, 0x1p-23f}, /* a tie goes to the even one */
    {0x1p-25f, 0},
    {0x1.000002p-25f, 0x1p-24f},
    {1e-12f, 0},
    {1e-41f, 0},
    {1.00049f, 1.0009765625f},
    {1.00048f, 1},
};
enum { VALUE_COUNT = sizeof VALUES / sizeof *VALUES };

static void test_exr_files_hold_what_the_header_promises(void **state) {
    (void)state;
    for (int float32 = 0; float32 < 2; float32++) {
        float *planes[3];
        struct fewray_frame *frame = frame_of(VALUE_COUNT, 1, planes);
        for (int i = 0; i < VALUE_COUNT; i++)
            planes[0][i] = planes[1][i] = planes[2][i] = VALUES[i].value;
        struct fewray_frame *back = round_trip(frame, float32);
        const float *found = fewray_frame_plane(back, "G");
        for (int i = 0; i < VALUE_COUNT; i++) {
            const float expected = float32 ? VALUES[i].value : VALUES[i].half;
            if (!(isnan(expected) ? isnan(found[i])
                                  : !memcmp(&found[i], &expected, sizeof expected)))
                fail_msg("%g became %g instead of %g", (double)VALUES[i].value, (double)found[i],
                         (double)expected);
        }
        fewray_frame_destroy(&back);
        fewray_frame_destroy(&frame);
    }
}

/* Rounding to half is off by at most half of the last of 11 bits, or of the least denormal. */
static void test_half_rounding_is_within_its_bound(void **state) {
    (void)state;
    enum { COUNT = 4096 };
    float *planes[3];
    struct fewray_frame *frame = frame_of(COUNT, 1, planes);
    for (int i = 0; i < COUNT; i++) /* 2^-26 to 2^16, all of it below 65504 */
        planes[0][i] = planes[1][i] = planes[2][i] = exp2f(-26 + 41.9f * (float)i / COUNT);
    struct fewray_frame *back = round_trip(frame, false);
    const float *found = fewray_frame_plane(back, "B");
    for (int i = 0; i < COUNT; i++)
        assert_near(found[i], planes[2][i], fmax(planes[2][i] * 0x1p-11, 0x1p-25));
    fewray_frame_destroy(&back);
    fewray_frame_destroy(&frame);
}

static void test_losses_of_half_floats_are_counted(void **state) {
    (void)state;
    static const struct {
        float value;
        size_t clipped, lost;
    } cases[] = {
        {0, 0, 0},     {1, 0, 0},      {65504, 0, 0},    {65505, 1, 0},
        {1e12f, 1, 0}, {1e-12f, 0, 1}, {0x1p-25f, 0, 1}, {0x1.000002p-25f, 0, 0},
        {NAN, 0, 0},   {-1, 0, 0},     {-1e12f, 0, 0},   {INFINITY, 1, 0},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        float *planes[3];
        size_t clipped = 7, lost = 7;
        struct fewray_frame *frame = frame_of(3, 2, planes);
        planes[1][4] = cases[k].value; /* one channel of one pixel, the others black */
        fewray_frame_half_losses(frame, &clipped, &lost);
        assert_int_equal(clipped, cases[k].clipped);
        assert_int_equal(lost, cases[k].lost);
        fewray_frame_destroy(&frame);
    }
    struct fewray_frame *empty = NULL;
    size_t clipped = 7, lost = 7;
    assert_int_equal(fewray_frame_create(2, 2, &empty, NULL), FEWRAY_OK);
    fewray_frame_half_losses(empty, &clipped, &lost);
    assert_int_equal(clipped + lost, 0);
    fewray_frame_destroy(&empty);
}

/* --- PNG */

/* sRGB in double precision; the byte may be the neighbour where the value lies within a float's
 * rounding, 1e-4 of a step, of the border between two. */
static double srgb_steps(double linear) {
    if (!(linear > 0))
        return 0;
    if (linear >= 1)
        return 255;
    return 255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055);
}

static void test_png_shows_any_value(void **state) {
    (void)state;
    enum { RAMP = 400, COUNT = VALUE_COUNT + RAMP };
    float *planes[3];
    struct fewray_frame *frame = frame_of(COUNT, 1, planes);
    for (int i = 0; i < COUNT; i++)
        planes[0][i] = planes[1][i] = planes[2][i] =
            i < VALUE_COUNT ? VALUES[i].value
                            : exp2f(-16 + 16.1f * (float)(i - VALUE_COUNT) / RAMP);
    const char *path = path_of("values.png");
    struct fewray_image *image = NULL;
    assert_int_equal(fewray_frame_write_png(frame, path, NULL), FEWRAY_OK);
    assert_int_equal(fewray_image_read(path, &image, NULL), FEWRAY_OK);
    for (int i = 0; i < COUNT; i++)
        for (int c = 0; c < 3; c++)
            assert_near(image->bytes[3 * i + c], srgb_steps(planes[c][i]), 0.5 + 1e-4);
    fewray_image_destroy(&image);
    fewray_frame_destroy(&frame);
}

static void test_png_of_any_shape(void **state) {
    (void)state;
    static const int sizes[][2] = {{1, 1}, {1, 300}, {300, 1}, {2, 2}, {3, 5}, {16384, 4}};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
        float *planes[3];
        struct fewray_frame *frame = frame_of(sizes[s][0], sizes[s][1], planes);
        const int last = sizes[s][0] * sizes[s][1] - 1;
        planes[1][last] = INFINITY;
        const char *path = path_of("shape.png");
        struct fewray_image *image = NULL;
        assert_int_equal(fewray_frame_write_png(frame, path, NULL), FEWRAY_OK);
        assert_int_equal(fewray_image_read(path, &image, NULL), FEWRAY_OK);
        assert_int_equal(image->width, sizes[s][0]);
        assert_int_equal(image->height, sizes[s][1]);
        assert_int_equal(image->bytes[3 * last], 0);
        assert_int_equal(image->bytes[3 * last + 1], 255);
        fewray_image_destroy(&image);
        fewray_frame_destroy(&frame);
    }
}

/* --- repair */

static const struct {
    enum fewray_layer layer;
    const char *channel;
    float least, most; /* what may be left: features.h */
} RULES[] = {
    {FEWRAY_COLOR, "G", 0, 1e12f},
    {FEWRAY_NOISY, "noisy.G", 0, 1e12f},
    {FEWRAY_EMISSION, "emission.G", 0, 1e12f},
    {FEWRAY_VARIANCE, "variance.G", 0, 1e24f},
    {FEWRAY_ALBEDO, "albedo.G", 0, 1},
    {FEWRAY_SHADED_ALBEDO, "shaded_albedo.G", 0, 1},
    {FEWRAY_NORMAL, "normal.Y", -1, 1},
    {FEWRAY_DEPTH, "depth.Z", 0, 1e10f},
    {FEWRAY_IRRADIANCE, "irradiance.G", 0, 1e12f},
    {FEWRAY_IRRADIANCE_CONFIDENCE, "irradiance.confidence", 0, 1},
};
enum { RULE_COUNT = sizeof RULES / sizeof *RULES };

/* Any value, alone, in lines, everywhere, in pictures of any shape: nothing beyond the layer's
 * range is left, a second repair finds nothing, and values within the range stay as they are. */
static void test_repair_leaves_each_layer_in_its_range(void **state) {
    (void)state;
    static const int sizes[][2] = {{1, 1}, {1, 9}, {9, 1}, {2, 2}, {3, 5}, {17, 6}};
    static const int steps[] = {1, 2, 7, 1000}; /* 1: everywhere; 1000: the first pixel */
    for (int r = 0; r < RULE_COUNT; r++)
        for (int v = 0; v < VALUE_COUNT; v++)
            for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
                for (int k = 0; k < 4; k++) {
                    float *planes[3], kept[17 * 6];
                    const int pixels = sizes[s][0] * sizes[s][1];
                    struct fewray_frame *frame = NULL;
                    fewray_frame_create(sizes[s][0], sizes[s][1], &frame, NULL);
                    assert_true(fewray_frame_add_layer(frame, RULES[r].layer, planes));
                    float *plane = fewray_frame_plane(frame, RULES[r].channel);
                    for (int i = 0; i < pixels; i++)
                        plane[i] = i % steps[k] ? 0.5f : VALUES[v].value;
                    memcpy(kept, plane, sizeof(float) * (size_t)pixels);
                    fewray_frame_repair(frame);
                    for (int i = 0; i < pixels; i++) {
                        if (!(plane[i] >= RULES[r].least && plane[i] <= RULES[r].most))
                            fail_msg("%s: %g became %g", RULES[r].channel, (double)kept[i],
                                     (double)plane[i]);
                        const bool sound = kept[i] >= RULES[r].least && kept[i] <= RULES[r].most &&
                                           kept[i] <= 1e5f;
                        assert_true(!sound || plane[i] == kept[i]);
                    }
                    assert_int_equal(fewray_frame_repair(frame), 0);
                    fewray_frame_destroy(&frame);
                }
}

/* Bright as it may be, a picture keeps its radiance: only what stands alone is taken for damage. */
static void test_repair_keeps_bright_pictures(void **state) {
    (void)state;
    static const float scales[] = {1e-12f, 1, 1e5f, 1e8f, 1e11f};
    for (size_t k = 0; k < sizeof scales / sizeof *scales; k++) {
        float *planes[3];
        struct fewray_frame *frame = frame_of(20, 10, planes);
        for (int i = 0; i < 200; i++)
            for (int c = 0; c < 3; c++)
                planes[c][i] = scales[k] * (1 + (float)((i * 7 + c) % 9));
        assert_int_equal(fewray_frame_repair(frame), 0);
        for (int i = 0; i < 200; i++)
            for (int c = 0; c < 3; c++)
                assert_true(planes[c][i] == scales[k] * (1 + (float)((i * 7 + c) % 9)));
        planes[1][87] = INFINITY;
        assert_int_equal(fewray_frame_repair(frame), 1);
        assert_true(planes[1][87] >= scales[k] && planes[1][87] <= 9 * scales[k]);
        fewray_frame_destroy(&frame);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exr_files_hold_what_the_header_promises),
        cmocka_unit_test(test_half_rounding_is_within_its_bound),
        cmocka_unit_test(test_losses_of_half_floats_are_counted),
        cmocka_unit_test(test_png_shows_any_value),
        cmocka_unit_test(test_png_of_any_shape),
        cmocka_unit_test(test_repair_leaves_each_layer_in_its_range),
        cmocka_unit_test(test_repair_keeps_bright_pictures),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
