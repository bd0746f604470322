/* SPDX-License-Identifier: Apache-2.0 */
/* Composites of every shape are drawn, and crops stand where the error is. */

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "fewray/pipeline.h"
#include "pipeline/crops.h"

static struct fewray_frame *make_frame(int width, int height, unsigned seed) {
    struct fewray_frame *frame = NULL;
    float *planes[3];
    assert_int_equal(fewray_frame_create(width, height, &frame, NULL), 0);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, planes));
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < width * height; i++)
            planes[c][i] = (float)((seed = seed * 1664525u + 1013904223u) >> 8) / 16777216.0f;
    return frame;
}

static void draw(int width, int height, bool with_reference,
                 const struct fewray_composite_options *options) {
    char path[] = "composite-XXXXXX";
    const int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    struct fewray_frame *noisy = make_frame(width, height, 1),
                        *denoised = make_frame(width, height, 2);
    struct fewray_frame *reference = with_reference ? make_frame(width, height, 3) : NULL;
    struct fewray_error error;
    if (fewray_composite(noisy, denoised, reference, options, path, &error))
        fail_msg("%dx%d: %s", width, height, error.what);
    struct fewray_image *image = NULL;
    assert_int_equal(fewray_image_read(path, &image, &error), 0);
    assert_true(image->width > 2 * 420 && image->channels == 3);
    fewray_image_destroy(&image);
    fewray_frame_destroy(&noisy);
    fewray_frame_destroy(&denoised);
    fewray_frame_destroy(&reference);
    unlink(path);
}

static void test_composites_of_odd_sizes(void **state) {
    (void)state;
    static const int sizes[][2] = {{1, 1}, {3, 5}, {64, 64}, {700, 40}, {9, 1500}, {2000, 16}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        draw(sizes[i][0], sizes[i][1], true, NULL);
        draw(sizes[i][0], sizes[i][1], false, NULL);
    }
}

static void test_asked_crops_and_caption_are_drawn(void **state) {
    (void)state;
    const struct fewray_composite_options options = {
        .caption = "a caption of some words that is far too long for the width of a composite with "
                   "two small pictures in "
                   "it, and so is drawn smaller",
        .exposure = 1,
        .crop_count = 2,
        .crops = {{10, 5, 20, 20}, {50, 30, 100, 4}},
    };
    draw(64, 48, true, &options);
}

static void test_crops_outside_and_other_sizes_are_refused(void **state) {
    (void)state;
    const struct fewray_composite_options options = {.crop_count = 1, .crops = {{64, 0, 4, 4}}};
    struct fewray_frame *one = make_frame(64, 48, 1), *two = make_frame(48, 64, 2);
    assert_int_equal(fewray_composite(one, one, NULL, &options, "never.png", NULL),
                     FEWRAY_ERROR_ARGUMENT);
    assert_int_equal(fewray_composite(one, two, NULL, NULL, "never.png", NULL),
                     FEWRAY_ERROR_ARGUMENT);
    assert_int_equal(access("never.png", F_OK), -1);
    fewray_frame_destroy(&one);
    fewray_frame_destroy(&two);
}

static void test_the_first_crop_stands_on_the_error(void **state) {
    (void)state;
    enum { WIDTH = 80, HEIGHT = 60 };
    static uint8_t noisy[WIDTH * HEIGHT * 3], denoised[WIDTH * HEIGHT * 3],
        target[WIDTH * HEIGHT * 3];
    memset(denoised + 3 * (40 * WIDTH + 60), 255, 12);
    struct fewray_crop crops[FEWRAY_CROPS];
    assert_true(crops_pick(noisy, denoised, target, WIDTH, HEIGHT, 10, 8, crops));
    assert_true(crops[0].x <= 60 && crops[0].x + 10 > 60 && crops[0].y <= 40 &&
                crops[0].y + 8 > 40);
    for (int i = 0; i < FEWRAY_CROPS; i++)
        assert_true(crops[i].x >= 0 && crops[i].x + crops[i].width <= WIDTH && crops[i].y >= 0 &&
                    crops[i].y + crops[i].height <= HEIGHT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_composites_of_odd_sizes),
        cmocka_unit_test(test_asked_crops_and_caption_are_drawn),
        cmocka_unit_test(test_crops_outside_and_other_sizes_are_refused),
        cmocka_unit_test(test_the_first_crop_stands_on_the_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
