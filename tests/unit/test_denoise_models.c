/* SPDX-License-Identifier: Apache-2.0 */
/* Networks of any widths: each that is built in denoises, those of a file get their channels from
 * it, and files whose layers don't fit together are refused. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "denoise/kpn.h"
#include "fewray/denoise.h"

enum { WIDTH = 96, HEIGHT = 80, PIXELS = WIDTH * HEIGHT };

static float uniform(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) * 0x1p-24f;
}

/* --- built-in models */

static void denoise(enum fewray_denoise_model model, const float *color, float *out) {
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    fewray_denoise_options_init(&options);
    options.threads = 2;
    options.model = model;
    struct fewray_denoise_input in = {
        .width = WIDTH, .height = HEIGHT, .color = fewray_interleaved(color, WIDTH)};
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, NULL), FEWRAY_OK);
    assert_int_equal(fewray_denoiser_run(denoiser, &in, out, NULL, NULL), FEWRAY_OK);
    fewray_denoiser_destroy(&denoiser);
}

static void test_models_keep_constants_and_lower_noise(void **state) {
    (void)state;
    static float color[3 * PIXELS], out[3 * PIXELS], first[3 * PIXELS];
    for (int model = FEWRAY_DENOISE_DEFAULT; model <= FEWRAY_DENOISE_FAST; model++) {
        for (int i = 0; i < 3 * PIXELS; i++)
            color[i] = 0.7f;
        denoise((enum fewray_denoise_model)model, color, out);
        for (int i = 0; i < 3 * PIXELS; i++)
            assert_float_equal(out[i], 0.7f, 1e-3f);

        uint32_t seed = 5;
        double before = 0, after = 0;
        for (int i = 0; i < 3 * PIXELS; i++)
            color[i] = 0.5f + uniform(&seed) + uniform(&seed) - uniform(&seed) * uniform(&seed);
        double mean = 0;
        for (int i = 0; i < 3 * PIXELS; i++)
            mean += color[i] / (3.0 * PIXELS);
        denoise((enum fewray_denoise_model)model, color, out);
        for (int i = 0; i < 3 * PIXELS; i++) {
            before += pow(color[i] - mean, 2);
            after += pow(out[i] - mean, 2);
        }
        assert_true(after < 0.1 * before);
        if (model == FEWRAY_DENOISE_DEFAULT)
            memcpy(first, out, sizeof out);
        else
            assert_memory_not_equal(first, out, sizeof out);
    }
}

/* Why training needs no pictures of other exposures: powers of two scale everything exactly. */
static void test_exposure_does_not_matter(void **state) {
    (void)state;
    static float color[3 * PIXELS], first[3 * PIXELS], out[3 * PIXELS];
    static const float factors[] = {1.0f, 0x1p-8f, 0x1p8f};
    for (int f = 0; f < 3; f++) {
        uint32_t seed = 9;
        for (int i = 0; i < 3 * PIXELS; i++)
            color[i] = factors[f] * (0.1f + uniform(&seed));
        denoise(FEWRAY_DENOISE_DEFAULT, color, f ? out : first);
        for (int i = 0; i < 3 * PIXELS && f; i++)
            assert_float_equal(out[i] / factors[f], first[i], 1e-5f);
    }
}

static void test_unknown_model_is_an_error(void **state) {
    (void)state;
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_error error;
    fewray_denoise_options_init(&options);
    options.model = (enum fewray_denoise_model)77;
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, &error), FEWRAY_ERROR_ARGUMENT);
    assert_null(denoiser);
}

/* --- weights of other widths */

enum { LAYERS = 28, PARITIES = 3, SCALES = 5, TENSORS = 2 * LAYERS + PARITIES + SCALES };

/* Random weights whose levels have these channels. */
static void weights_new(struct nn_weights *weights, const int widths[4]) {
    const int a = widths[0], b = widths[1], c = widths[2], d = widths[3];
    const struct {
        const char *name;
        int kernel, in, out;
    } layers[LAYERS] = {
        {"enc0a", 3, 64, a},    {"enc0b", 3, a, a},    {"enc1a", 3, a, b},
        {"enc1b", 3, b, b},     {"enc2a", 3, b, c},    {"enc2b", 3, c, c},
        {"enc3a", 3, c, d},     {"enc3b", 3, d, d},    {"up2", 1, d, c},
        {"dec2a", 3, c, c},     {"dec2b", 3, c, c},    {"up1", 1, c, b},
        {"dec1a", 3, b, b},     {"dec1b", 3, b, b},    {"up0", 1, b, a},
        {"dec0a", 3, a, a},     {"dec0b", 3, a, a},    {"down0", 1, a, 4},
        {"down1", 1, a, 1},     {"down2", 1, b, 1},    {"down3", 1, c, 1},
        {"kernel0", 1, a, 136}, {"kernel1", 1, a, 34}, {"kernel2", 1, b, 34},
        {"kernel3", 1, c, 34},  {"kernel4", 1, d, 25}, {"key_raw", 1, 64, 32},
        {"key", 1, a, 32},
    };
    size_t floats = PARITIES * 36 + SCALES * 14, at = 0;
    for (int i = 0; i < LAYERS; i++)
        floats +=
            (size_t)(layers[i].out * (1 + layers[i].in * layers[i].kernel * layers[i].kernel));
    *weights = (struct nn_weights){TENSORS, calloc(TENSORS, sizeof *weights->tensors), NULL,
                                   malloc(floats * sizeof(float)), NULL};
    uint32_t seed = 11;
    for (size_t i = 0; i < floats; i++)
        weights->storage[i] = 0.2f * (uniform(&seed) - 0.5f);
    for (int i = 0; i < TENSORS; i++) {
        struct nn_weight *tensor = &weights->tensors[i];
        int l = i / 2, parity = i - 2 * LAYERS + 1;
        if (parity > PARITIES) {
            snprintf(tensor->name, sizeof tensor->name, "scale%d", parity - PARITIES - 1);
            memcpy(tensor->shape, (int[4]){2, 7, 1, 1}, sizeof tensor->shape);
        } else if (parity > 0) {
            snprintf(tensor->name, sizeof tensor->name, "parity%d", parity);
            memcpy(tensor->shape, (int[4]){4, 9, 1, 1}, sizeof tensor->shape);
        } else if (i % 2) {
            snprintf(tensor->name, sizeof tensor->name, "%s.bias", layers[l].name);
            memcpy(tensor->shape, (int[4]){layers[l].out, 1, 1, 1}, sizeof tensor->shape);
        } else {
            snprintf(tensor->name, sizeof tensor->name, "%s.weight", layers[l].name);
            memcpy(tensor->shape,
                   (int[4]){layers[l].out, layers[l].in, layers[l].kernel, layers[l].kernel},
                   sizeof tensor->shape);
        }
        tensor->data = weights->storage + at;
        at += (size_t)(tensor->shape[0] * tensor->shape[1] * tensor->shape[2] * tensor->shape[3]);
    }
    assert_int_equal(at, floats);
}

static void weights_clear(struct nn_weights *weights) {
    free(weights->tensors);
    free(weights->storage);
}

/* out of the network on a picture of one colour and one with noise. */
static void filter(const struct nn_weights *weights, enum nn_isa isa, const float *color,
                   float *out) {
    struct fewray_denoise_input in = {
        .width = WIDTH, .height = HEIGHT, .color = fewray_interleaved(color, WIDTH)};
    struct kpn *kpn = NULL;
    struct kpn_scale scale;
    assert_int_equal(kpn_create(weights, nn_kernels_get(isa), &kpn, NULL), FEWRAY_OK);
    assert_int_equal(kpn_measure(&in, 1, &scale, NULL), FEWRAY_OK);
    struct kpn_region all = {0, 0, WIDTH, HEIGHT};
    size_t bytes = kpn_memory(kpn, 1, HEIGHT, WIDTH, 2, 0);
    unsigned char *memory = aligned_alloc(64, bytes + 64);
    memset(memory, 0x7f, bytes + 64); /* what padding channels hold must not matter; guard bytes */
    struct kpn_output output = {{out, out + 1, out + 2}, 3, 3 * WIDTH};
    struct kpn_job job = {.in = &in,
                          .scale = &scale,
                          .region = all,
                          .core = all,
                          .memory = memory,
                          .memory_bytes = bytes,
                          .threads = 2,
                          .out = &output};
    assert_int_equal(kpn_run(kpn, &job, NULL), FEWRAY_OK);
    for (int i = 0; i < 64; i++)
        assert_int_equal(memory[bytes + (size_t)i], 0x7f);
    free(memory);
    kpn_destroy(&kpn);
}

static void test_any_widths_run(void **state) {
    (void)state;
    static float color[3 * PIXELS], out[3 * PIXELS], plain[3 * PIXELS];
    static const int widths[][4] = {
        {16, 16, 16, 16}, {8, 24, 40, 56}, {5, 17, 3, 33}, {48, 64, 96, 128}};
    for (int w = 0; w < 4; w++) {
        struct nn_weights weights;
        weights_new(&weights, widths[w]);
        for (int i = 0; i < 3 * PIXELS; i++)
            color[i] = 2.0f;
        filter(&weights, NN_ISA_AUTO, color, out);
        for (int i = 0; i < 3 * PIXELS; i++)
            assert_float_equal(out[i], 2.0f, 1e-4f);
        uint32_t seed = 3;
        for (int i = 0; i < 3 * PIXELS; i++)
            color[i] = uniform(&seed);
        filter(&weights, NN_ISA_AUTO, color, out);
        filter(&weights, NN_ISA_PLAIN, color, plain);
        for (int i = 0; i < 3 * PIXELS; i++)
            assert_float_equal(out[i], plain[i], 1e-4f);
        weights_clear(&weights);
    }
}

static void test_layers_that_do_not_fit_are_refused(void **state) {
    (void)state;
    struct nn_weights weights;
    weights_new(&weights, (int[4]){16, 32, 16, 16});
    for (int i = 0; i < TENSORS; i++) {
        for (int wrong = 0; wrong < 3; wrong++) {
            static const int values[] = {0, 2048, 24};
            struct kpn *kpn = NULL;
            struct fewray_error error = {0};
            int shape = weights.tensors[i].shape[0];
            weights.tensors[i].shape[0] = values[wrong];
            assert_int_equal(kpn_create(&weights, nn_kernels_get(NN_ISA_AUTO), &kpn, &error),
                             FEWRAY_ERROR_FORMAT);
            assert_null(kpn);
            assert_non_null(strstr(error.what, "weights of another network"));
            weights.tensors[i].shape[0] = shape;
        }
    }
    weights_clear(&weights);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_models_keep_constants_and_lower_noise),
        cmocka_unit_test(test_exposure_does_not_matter),
        cmocka_unit_test(test_unknown_model_is_an_error),
        cmocka_unit_test(test_any_widths_run),
        cmocka_unit_test(test_layers_that_do_not_fit_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
