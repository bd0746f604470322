/* SPDX-License-Identifier: Apache-2.0 */
/* However the denoiser shares and cuts its work, the picture is the same: any number of threads,
 * bands and columns for little memory, no work where there is no noise. */

#include "tests/unit/denoise_room.h"

static void test_threads_give_the_same_bits(void **state) {
    (void)state;
    struct picture p = room(150, 117);
    struct fewray_denoise_input in = all_layers(&p);
    float *first = layer(&p, 3);
    denoise(&in, first, 1, 0);
    for (int threads = 2; threads <= 5; threads++) {
        denoise(&in, p.out, threads, 0);
        assert_memory_equal(p.out, first, count(&p) * sizeof(float));
    }
    free(first);
    picture_clear(&p);
}

/* With less and less memory the picture goes through the network in lower bands of rows, then in
 * more and more columns, down to the narrowest. */
static void compare_with_whole(int width, int height, int least_regions) {
    struct picture p = room(width, height);
    struct fewray_denoise_input in = all_layers(&p);
    float *whole = layer(&p, 3);
    struct fewray_denoise_stats one = denoise(&in, whole, 2, 0), part = one;
    struct fewray_denoise_options options;
    fewray_denoise_options_init(&options);
    options.threads = 2;
    assert_int_equal(one.regions, 1);
    int sizes = 0, status = FEWRAY_OK;
    for (size_t memory = one.buffer_bytes - 1; !status; memory = part.buffer_bytes - 1, sizes++) {
        options.max_memory = memory;
        status = try_denoise(&in, p.out, &options, &part);
        if (status == FEWRAY_ERROR_ARGUMENT)
            break;
        assert_true(part.buffer_bytes <= memory);
        for (size_t i = 0; i < count(&p); i++)
            assert_float_equal(p.out[i], whole[i], 1e-5f * fabsf(whole[i]));
    }
    assert_true(sizes > 1);
    assert_true(part.regions >= least_regions);
    free(whole);
    picture_clear(&p);
}

static void test_bands_and_columns_equal_the_whole(void **state) {
    (void)state;
    compare_with_whole(463, 79, 4);
    compare_with_whole(37, 451, 1);
    compare_with_whole(150, 330, 1);
}

static void test_empty_background_is_no_work(void **state) {
    (void)state;
    struct picture p = room(448, 130);
    for (int y = 0; y < p.height; y++) /* only the first two tiles of each row are no background */
        for (int x = 128; x < p.width; x++)
            for (int c = 0; c < 3; c++) {
                int i = 3 * (y * p.width + x) + c;
                p.albedo[i] = p.variance[i] = 0;
                p.color[i] = p.emission[i] = 0.25f + 0.125f * (float)c;
            }
    struct fewray_denoise_input in = all_layers(&p);
    struct fewray_denoise_stats stats = denoise(&in, p.out, 2, 0);
    assert_int_equal(stats.tiles, 7 * 3);
    assert_int_equal(stats.tiles_denoised, 2 * 3);
    for (int y = 0; y < p.height; y++)
        for (int i = 3 * (y * p.width + 128); i < 3 * (y + 1) * p.width; i++)
            assert_true(p.out[i] == p.color[i]);
    picture_clear(&p);
}

/* Far parts of a picture are regions of their own, with the network's result of the whole. */
static void test_what_lies_between_noisy_parts_is_no_work(void **state) {
    (void)state;
    struct picture p = room(40, 900);
    float *whole = layer(&p, 3);
    struct fewray_denoise_input in = all_layers(&p);
    struct fewray_denoise_options options;
    struct fewray_denoise_stats stats;
    fewray_denoise_options_init(&options);
    options.settled_error = -1;
    for (int y = 192; y < 704; y++)
        for (int i = 3 * y * p.width; i < 3 * (y + 1) * p.width; i++)
            p.variance[i] = 0.25e-6f * p.color[i] * p.color[i];
    for (int i = 0; i < p.width * p.height; i++) /* one black pixel can't tell its noise */
        for (int c = 0; c < 3; c++)
            p.color[3 * i + c] += 0.01f;
    assert_int_equal(try_denoise(&in, whole, &options, &stats), FEWRAY_OK);
    assert_int_equal(stats.tiles_denoised, 15);
    assert_int_equal(stats.regions, 1);
    options.settled_error = 0;
    assert_int_equal(try_denoise(&in, p.out, &options, &stats), FEWRAY_OK);
    assert_int_equal(stats.tiles, 15);
    assert_int_equal(stats.tiles_denoised, 15 - 8);
    assert_int_equal(stats.regions, 2);
    for (int y = 0; y < p.height; y++)
        for (int i = 3 * y * p.width; i < 3 * (y + 1) * p.width; i++)
            if (y >= 192 && y < 704)
                assert_true(p.out[i] == p.color[i]);
            else
                assert_float_equal(p.out[i], whole[i], 1e-5f * whole[i]);
    free(whole);
    picture_clear(&p);
}

static void test_one_noisy_pixel_makes_its_tile_work(void **state) {
    (void)state;
    struct picture p = room(128, 64);
    for (size_t i = 0; i < count(&p); i++) {
        p.color[i] += 0.01f;
        p.variance[i] = 4e-6f * p.color[i] * p.color[i];
    }
    struct fewray_denoise_input in = all_layers(&p);
    struct fewray_denoise_options options;
    struct fewray_denoise_stats stats;
    fewray_denoise_options_init(&options);
    assert_int_equal(try_denoise(&in, p.out, &options, &stats), FEWRAY_OK);
    assert_int_equal(stats.tiles_denoised, 2); /* 0.2 % is more than the default */
    options.settled_error = 0.0021f;
    assert_int_equal(try_denoise(&in, p.out, &options, &stats), FEWRAY_OK);
    assert_int_equal(stats.tiles_denoised, 0);
    p.variance[3 * (20 * 128 + 100) + 1] *= 9;
    assert_int_equal(try_denoise(&in, p.out, &options, &stats), FEWRAY_OK);
    assert_int_equal(stats.tiles_denoised, 1);
    p.variance[3 * (20 * 128 + 20)] = NAN;
    assert_int_equal(try_denoise(&in, p.out, &options, &stats), FEWRAY_OK);
    assert_int_equal(stats.tiles_denoised, 2);
    in.variance = (struct fewray_channels){0};
    assert_int_equal(try_denoise(&in, p.out, &options, &stats), FEWRAY_OK);
    assert_int_equal(stats.tiles_denoised, 2);
    picture_clear(&p);
}

static void test_too_little_memory_is_an_error(void **state) {
    (void)state;
    struct picture p = room(256, 256);
    struct fewray_denoise_input in = all_layers(&p);
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_error error;
    fewray_denoise_options_init(&options);
    options.max_memory = 1 << 16;
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, &error), FEWRAY_OK);
    assert_int_equal(fewray_denoiser_run(denoiser, &in, p.out, NULL, &error),
                     FEWRAY_ERROR_ARGUMENT);
    fewray_denoiser_destroy(&denoiser);
    picture_clear(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_threads_give_the_same_bits),
        cmocka_unit_test(test_bands_and_columns_equal_the_whole),
        cmocka_unit_test(test_empty_background_is_no_work),
        cmocka_unit_test(test_what_lies_between_noisy_parts_is_no_work),
        cmocka_unit_test(test_one_noisy_pixel_makes_its_tile_work),
        cmocka_unit_test(test_too_little_memory_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
