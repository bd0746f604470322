/* SPDX-License-Identifier: Apache-2.0 */
/* What the denoiser promises for any picture, whatever its weights have learned: means of what is
 * there, no invented light, the same bits on any number of threads, tiles without seams. */

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

static struct fewray_denoise_stats denoise(const struct fewray_denoise_input *in, float *out,
                                           int threads, size_t memory) {
    struct fewray_denoise_options options;
    struct fewray_denoise_stats stats;
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_error error;
    fewray_denoise_options_init(&options);
    options.threads = threads;
    options.max_memory = memory;
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, &error), FEWRAY_OK);
    assert_int_equal(fewray_denoiser_run(denoiser, in, out, &stats, &error), FEWRAY_OK);
    fewray_denoiser_destroy(&denoiser);
    assert_null(denoiser);
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
    assert_int_equal(stats.tiles, 1);
    assert_int_equal(stats.tiles_denoised, 0);
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

static void test_tiles_equal_the_whole(void **state) {
    (void)state;
    struct picture p = room(701, 523);
    struct fewray_denoise_input in = all_layers(&p);
    float *whole = layer(&p, 3);
    struct fewray_denoise_stats one = denoise(&in, whole, 2, 0);
    struct fewray_denoise_stats many = denoise(&in, p.out, 2, one.buffer_bytes * 6 / 10);
    assert_int_equal(one.tiles, 1);
    assert_true(many.tiles > 2);
    assert_true(many.buffer_bytes <= one.buffer_bytes * 6 / 10);
    for (size_t i = 0; i < count(&p); i++)
        assert_float_equal(p.out[i], whole[i], 1e-5f * (1e-3f + fabsf(whole[i])));
    free(whole);
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
        cmocka_unit_test(test_tiles_equal_the_whole),
        cmocka_unit_test(test_too_little_memory_is_an_error),
        cmocka_unit_test(test_outlier_is_weighted_away),
        cmocka_unit_test(test_damaged_values_stay_where_they_are),
        cmocka_unit_test(test_smallest_pictures),
        cmocka_unit_test(test_frame_keeps_the_noisy_picture),
        cmocka_unit_test(test_progress_and_cancel),
        cmocka_unit_test(test_wrong_options_are_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
