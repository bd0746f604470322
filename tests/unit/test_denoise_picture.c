/* SPDX-License-Identifier: Apache-2.0 */
/* What the denoiser promises for any picture, whatever its weights have learned: means of what is
 * there, no invented light, the same bits on any number of threads, parts without seams, no work
 * where there is no noise. */

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "denoise/denoise.h"

/* Interleaved layers of a picture. */
struct picture {
    int width, height;
    float *color, *variance, *albedo, *normal, *emission, *depth, *out;
};

static float uniform(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) * 0x1p-24f;
}

static float *layer(const struct picture *p, int channels) {
    return calloc((size_t)p->width * (size_t)p->height * (size_t)channels, sizeof(float));
}

static struct picture picture_new(int width, int height) {
    struct picture p = {.width = width, .height = height};
    p.color = layer(&p, 3);
    p.variance = layer(&p, 3);
    p.albedo = layer(&p, 3);
    p.normal = layer(&p, 3);
    p.emission = layer(&p, 3);
    p.depth = layer(&p, 1);
    p.out = layer(&p, 3);
    return p;
}

static void picture_clear(struct picture *p) {
    float *layers[] = {p->color, p->variance, p->albedo, p->normal, p->emission, p->depth, p->out};
    for (int i = 0; i < 7; i++)
        free(layers[i]);
}

/* A tiled floor under a smooth, noisy light, as 4 samples a pixel give it; a lamp; nothing behind
 * the upper left. */
static struct picture room(int width, int height) {
    struct picture p = picture_new(width, height);
    uint32_t seed = 7;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            int i = y * width + x;
            if (x + y < width / 8)
                continue;
            float light = 1.0f + 0.5f * sinf(0.02f * (float)x), noise = 0;
            for (int s = 0; s < 4; s++)
                noise += uniform(&seed) < 0.3f ? 0.25f / 0.3f : 0.0f;
            bool lamp = x > width / 2 && x < width / 2 + 20 && y > height / 3 && y < height / 3 + 9;
            for (int c = 0; c < 3; c++) {
                float albedo = ((x / 16 + y / 16) & 1 ? 0.8f : 0.3f) * (1.0f - 0.2f * (float)c);
                p.albedo[3 * i + c] = albedo;
                p.emission[3 * i + c] = lamp ? 15.0f : 0.0f;
                p.color[3 * i + c] = albedo * light * noise + p.emission[3 * i + c];
                p.variance[3 * i + c] = 0.25f * albedo * albedo * light * noise;
            }
            p.normal[3 * i + 1] = 1.0f;
            p.depth[i] = 2.0f + 0.01f * (float)y;
        }
    return p;
}

static struct fewray_denoise_input color_alone(const struct picture *p) {
    return (struct fewray_denoise_input){
        .width = p->width, .height = p->height, .color = fewray_interleaved(p->color, p->width)};
}

static struct fewray_denoise_input all_layers(const struct picture *p) {
    struct fewray_denoise_input in = color_alone(p);
    in.variance = fewray_interleaved(p->variance, p->width);
    in.albedo = fewray_interleaved(p->albedo, p->width);
    in.normal = fewray_interleaved(p->normal, p->width);
    in.emission = fewray_interleaved(p->emission, p->width);
    in.depth = (struct fewray_channels){{p->depth}, 1, p->width};
    return in;
}

/* What fewray_denoiser_run() returns; options may be NULL. */
static int try_denoise(const struct fewray_denoise_input *in, float *out,
                       const struct fewray_denoise_options *options,
                       struct fewray_denoise_stats *stats) {
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_error error;
    assert_int_equal(fewray_denoiser_create(options, &denoiser, &error), FEWRAY_OK);
    int status = fewray_denoiser_run(denoiser, in, out, stats, &error);
    fewray_denoiser_destroy(&denoiser);
    assert_null(denoiser);
    return status;
}

static struct fewray_denoise_stats denoise(const struct fewray_denoise_input *in, float *out,
                                           int threads, size_t memory) {
    struct fewray_denoise_options options;
    struct fewray_denoise_stats stats;
    fewray_denoise_options_init(&options);
    options.threads = threads;
    options.max_memory = memory;
    assert_int_equal(try_denoise(in, out, &options, &stats), FEWRAY_OK);
    return stats;
}

static size_t count(const struct picture *p) {
    return (size_t)p->width * (size_t)p->height * 3;
}

static double mean(const float *values, size_t n) {
    double sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += values[i];
    return sum / (double)n;
}

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
    compare_with_whole(463, 143, 4);
    compare_with_whole(37, 611, 1);
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

/* The pixel's own noise is lost, but what is far away hardly notices it, and what is near isn't
 * flooded. */
static void test_outlier_is_weighted_away(void **state) {
    (void)state;
    static const float strengths[] = {1e3f, 1e6f};
    struct picture p = room(640, 400);
    struct fewray_denoise_input in = all_layers(&p);
    float *clean = layer(&p, 3);
    denoise(&in, clean, 2, 0);
    int ox = 130, oy = 300, o = 3 * (oy * p.width + ox);
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

static void cancel_halfway(void *user, double fraction) {
    assert_true(fraction >= 0 && fraction <= 1.0001);
    if (fraction > 0.5)
        *(volatile int *)user = 1;
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
        *(volatile int *)user = 1;
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
        cmocka_unit_test(test_constant_picture_stays_constant),
        cmocka_unit_test(test_black_stays_black_and_is_skipped),
        cmocka_unit_test(test_picture_of_emitters_alone_is_kept),
        cmocka_unit_test(test_mean_is_kept_and_noise_falls),
        cmocka_unit_test(test_output_lies_between_the_smallest_and_largest_irradiance),
        cmocka_unit_test(test_threads_give_the_same_bits),
        cmocka_unit_test(test_bands_and_columns_equal_the_whole),
        cmocka_unit_test(test_empty_background_is_no_work),
        cmocka_unit_test(test_what_lies_between_noisy_parts_is_no_work),
        cmocka_unit_test(test_one_noisy_pixel_makes_its_tile_work),
        cmocka_unit_test(test_too_little_memory_is_an_error),
        cmocka_unit_test(test_outlier_is_weighted_away),
        cmocka_unit_test(test_damaged_values_stay_where_they_are),
        cmocka_unit_test(test_smallest_pictures),
        cmocka_unit_test(test_frame_keeps_the_noisy_picture),
        cmocka_unit_test(test_progress_and_cancel),
        cmocka_unit_test(test_cancelled_frame_keeps_its_colour),
        cmocka_unit_test(test_wrong_options_are_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
