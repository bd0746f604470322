/* SPDX-License-Identifier: Apache-2.0 */
/* Frames denoised in place, progress, cancelling, and options that are wrong. */

#include "features/cancel.h"
#include "tests/unit/denoise_room.h"

static void test_frame_keeps_the_noisy_picture(void **state) {
    (void)state;
    struct fewray_frame *frame = NULL;
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_denoise_options options;
    float *color[3], *noisy[3];
    assert_int_equal(fewray_frame_create(40, 30, &frame, NULL), FEWRAY_OK);
    fewray_denoise_options_init(&options);
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, NULL), FEWRAY_OK);
    assert_int_equal(fewray_denoise_frame(denoiser, frame, NULL, NULL), FEWRAY_ERROR_FORMAT);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, color));
    uint32_t seed = 3;
    for (int i = 0; i < 1200; i++)
        for (int c = 0; c < 3; c++)
            color[c][i] = uniform(&seed);
    float first = color[1][7];
    assert_int_equal(fewray_denoise_frame(denoiser, frame, NULL, NULL), FEWRAY_OK);
    assert_true(fewray_frame_layer(frame, FEWRAY_NOISY, noisy));
    assert_true(noisy[1][7] == first);
    assert_true(color[1][7] != first);
    fewray_denoiser_destroy(&denoiser);
    fewray_frame_destroy(&frame);
}

/* Layers whose values half floats hold exactly can be compact: the same picture of half the memory.
 */
static void test_compact_layers_give_the_same_bits(void **state) {
    (void)state;
    enum { WIDTH = 75, HEIGHT = 50, COUNT = WIDTH * HEIGHT };
    static float result[2][3][COUNT];
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_denoise_options options;
    fewray_denoise_options_init(&options);
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, NULL), FEWRAY_OK);
    for (int compact = 0; compact < 2; compact++) {
        struct fewray_frame *frame = NULL;
        float *color[3], *albedo[3], *normal[3], *depth[3];
        const uint16_t *half[3];
        assert_int_equal(fewray_frame_create(WIDTH, HEIGHT, &frame, NULL), FEWRAY_OK);
        assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, color));
        assert_true(fewray_frame_add_layer(frame, FEWRAY_ALBEDO, albedo));
        assert_true(fewray_frame_add_layer(frame, FEWRAY_NORMAL, normal));
        assert_true(fewray_frame_add_layer(frame, FEWRAY_DEPTH, depth));
        uint32_t seed = 5;
        for (int i = 0; i < COUNT; i++) {
            const bool lamp = i % WIDTH > 40 && i % WIDTH < 52 && i / WIDTH > 30;
            depth[0][i] = 1e-3f * (float)(i + 1); /* no half floats */
            for (int c = 0; c < 3; c++) {
                albedo[c][i] = lamp ? 0.0f : 0x1p-7f * (float)((i + c) % 128);
                normal[c][i] = c == 1 ? -0.5f : 0x1p-24f;
                color[c][i] = lamp ? 300.0f : albedo[c][i] * 2.0f * uniform(&seed);
            }
        }
        if (compact)
            fewray_frame_compact(frame);
        assert_int_equal(fewray_frame_compact_layer(frame, FEWRAY_ALBEDO, half), compact);
        assert_int_equal(fewray_frame_compact_layer(frame, FEWRAY_NORMAL, half), compact);
        assert_false(fewray_frame_compact_layer(frame, FEWRAY_DEPTH, half));
        assert_true(fewray_frame_plane(frame, "depth.Z") == depth[0]);
        assert_int_equal(fewray_denoise_frame(denoiser, frame, NULL, NULL), FEWRAY_OK);
        for (int c = 0; c < 3; c++)
            memcpy(result[compact][c], color[c], sizeof result[compact][c]);
        fewray_frame_destroy(&frame);
    }
    assert_memory_equal(result[0], result[1], sizeof result[0]);
    fewray_denoiser_destroy(&denoiser);
}

static void cancel_halfway(void *user, double fraction) {
    assert_true(fraction >= 0 && fraction <= 1.0001);
    if (fraction > 0.5)
        cancel_set(user);
}

static void test_progress_and_cancel(void **state) {
    (void)state;
    struct picture p = room(64, 64);
    struct fewray_denoise_input in = all_layers(&p);
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    volatile int cancel = 0;
    fewray_denoise_options_init(&options);
    options.progress = cancel_halfway;
    options.progress_user = (void *)&cancel;
    options.cancel = &cancel;
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, NULL), FEWRAY_OK);
    assert_int_equal(fewray_denoiser_run(denoiser, &in, p.out, NULL, NULL), FEWRAY_ERROR_CANCELLED);
    fewray_denoiser_destroy(&denoiser);
    picture_clear(&p);
}

static void cancel_late(void *user, double fraction) {
    if (fraction > 0.9)
        cancel_set(user);
}

static void test_cancelled_frame_keeps_its_colour(void **state) {
    (void)state;
    struct fewray_frame *frame = NULL;
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_denoise_options options;
    volatile int cancel = 0;
    float *color[3];
    assert_int_equal(fewray_frame_create(40, 900, &frame, NULL), FEWRAY_OK);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, color));
    for (int i = 0; i < 40 * 900; i++)
        for (int c = 0; c < 3; c++)
            color[c][i] = (float)((i * 7 + c) % 101);
    fewray_denoise_options_init(&options);
    options.max_memory = 4 << 20; /* little, so that rows are written long before the end */
    options.progress = cancel_late;
    options.progress_user = (void *)&cancel;
    options.cancel = &cancel;
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, NULL), FEWRAY_OK);
    assert_int_equal(fewray_denoise_frame(denoiser, frame, NULL, NULL), FEWRAY_ERROR_CANCELLED);
    for (int i = 0; i < 40 * 900; i++)
        for (int c = 0; c < 3; c++)
            assert_true(color[c][i] == (float)((i * 7 + c) % 101));
    fewray_denoiser_destroy(&denoiser);
    fewray_frame_destroy(&frame);
}

static void test_wrong_options_are_errors(void **state) {
    (void)state;
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_error error;
    fewray_denoise_options_init(&options);
    options.isa = "sse9";
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, &error), FEWRAY_ERROR_ARGUMENT);
    options.isa = NULL;
    options.weights_path = TEST_DATA "/no-such-file.bin";
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, &error), FEWRAY_ERROR_IO);
    options.weights_path = TEST_DATA "/kpn_reference.bin"; /* whole, but not a network */
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, &error), FEWRAY_ERROR_FORMAT);
    assert_null(denoiser);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_frame_keeps_the_noisy_picture),
        cmocka_unit_test(test_compact_layers_give_the_same_bits),
        cmocka_unit_test(test_progress_and_cancel),
        cmocka_unit_test(test_cancelled_frame_keeps_its_colour),
        cmocka_unit_test(test_wrong_options_are_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
