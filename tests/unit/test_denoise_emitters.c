/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures with albedo and without an emission layer: lamps stay and don't flood what is beside
 * them, black surfaces and outliers are no lamps, mirrors are filtered. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "denoise/emitters.h"

enum { WIDTH = 96, HEIGHT = 64, COUNT = WIDTH * HEIGHT };
#define WINDOW_LIGHT 1000.0f

struct picture {
    float color[3 * COUNT], albedo[3 * COUNT], emission[3 * COUNT], out[3 * COUNT];
};

static float uniform(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) * 0x1p-24f;
}

static bool in_window(int x, int y) {
    return x >= 20 && x < 60 && y >= 20 && y < 50 && x % 8 != 3; /* thin bars */
}

static bool in_mirror(int x, int y) {
    return x >= 70 && x < 90 && y >= 20 && y < 50;
}

/* A noisily lit wall of mean 0.6 with a window and a mirror, which have no albedo. */
static struct picture *room(void) {
    struct picture *p = calloc(1, sizeof *p);
    assert_non_null(p);
    uint32_t seed = 3;
    for (int i = 0; i < COUNT; i++) {
        const int x = i % WIDTH, y = i / WIDTH;
        const float light = uniform(&seed) + uniform(&seed);
        for (int c = 0; c < 3; c++) {
            const bool black = in_window(x, y) || in_mirror(x, y);
            p->albedo[3 * i + c] = black ? 0 : 0.6f;
            p->color[3 * i + c] = in_window(x, y) ? WINDOW_LIGHT : 0.6f * light;
        }
    }
    return p;
}

static struct fewray_denoise_input input_of(const struct picture *p) {
    return (struct fewray_denoise_input){.width = WIDTH,
                                         .height = HEIGHT,
                                         .color = fewray_interleaved(p->color, WIDTH),
                                         .albedo = fewray_interleaved(p->albedo, WIDTH)};
}

static void denoise(const struct fewray_denoise_input *in, float *out) {
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_denoise_options options;
    fewray_denoise_options_init(&options);
    options.threads = 1;
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, NULL), FEWRAY_OK);
    assert_int_equal(fewray_denoiser_run(denoiser, in, out, NULL, NULL), FEWRAY_OK);
    fewray_denoiser_destroy(&denoiser);
}

static void test_a_window_stays_and_floods_nothing(void **state) {
    (void)state;
    struct picture *p = room();
    const struct fewray_denoise_input in = input_of(p);
    denoise(&in, p->out);
    for (int i = 0; i < COUNT; i++) {
        const float out = p->out[3 * i];
        if (in_window(i % WIDTH, i / WIDTH))
            assert_float_equal(out, WINDOW_LIGHT, 0.02f * WINDOW_LIGHT);
        else if (out > 3.0f)
            fail_msg("%g beside a window, at %d, %d", out, i % WIDTH, i / WIDTH);
    }
    free(p);
}

static void test_a_mirror_is_filtered(void **state) {
    (void)state;
    struct picture *p = room();
    const struct fewray_denoise_input in = input_of(p);
    denoise(&in, p->out);
    double before = 0, after = 0, mean = 0;
    int count = 0;
    for (int i = 0; i < COUNT; i++)
        if (in_mirror(i % WIDTH, i / WIDTH)) {
            before += pow(p->color[3 * i] - 0.6, 2);
            after += pow(p->out[3 * i] - 0.6, 2);
            mean += p->out[3 * i];
            count++;
        }
    assert_true(after < 0.35 * before);
    assert_float_equal(mean / count, 0.6, 0.1);
    free(p);
}

static void test_only_what_is_black_and_bright_changes(void **state) {
    (void)state;
    struct picture *p = room();
    const int dark = 3 * (5 * WIDTH + 5), outlier = 3 * (5 * WIDTH + 40);
    for (int c = 0; c < 3; c++) {
        p->albedo[dark + c] = p->albedo[outlier + c] = 0.005f;
        p->color[dark + c] = 0.005f;
        p->color[outlier + c] = 1e4f;
    }
    const struct fewray_denoise_input in = input_of(p);
    const struct kpn_scale scale = {.exposure = 1};
    struct emitters emitters;
    assert_int_equal(emitters_find(&in, &scale, 1, &emitters, NULL), FEWRAY_OK);
    float *albedo = malloc(sizeof p->albedo);
    assert_non_null(albedo);
    for (int y = 0; y < HEIGHT; y++)
        for (int c = 0; c < 3; c++) {
            float raised[WIDTH + 9], emitted[WIDTH + 9] = {0};
            for (int x = 0; x < WIDTH + 9; x++)
                raised[x] = p->albedo[3 * (y * WIDTH + (x < WIDTH ? x : WIDTH - 1)) + c];
            emitters_raise_albedo(&emitters, y, 0, WIDTH + 9, raised);
            emitters_add_emission(&emitters, &in, c, y, 0, WIDTH + 9, emitted);
            for (int x = 0; x < WIDTH; x++) {
                albedo[3 * (y * WIDTH + x) + c] = raised[x];
                p->emission[3 * (y * WIDTH + x) + c] = emitted[x];
            }
            assert_true(raised[WIDTH + 8] == raised[WIDTH - 1]);
        }
    for (int i = 0; i < COUNT; i++) {
        const int x = i % WIDTH, y = i / WIDTH;
        if (in_window(x, y))
            assert_true(p->emission[3 * i] > 0.99f * WINDOW_LIGHT && albedo[3 * i] == 0);
        else if (!in_mirror(x, y))
            assert_true(p->emission[3 * i] == 0); /* the bars show nothing of the window */
        if (p->albedo[3 * i] > 0.5f)
            assert_true(albedo[3 * i] == p->albedo[3 * i]);
    }
    assert_true(albedo[dark] == 0.005f && albedo[outlier] == 0.005f);
    emitters_clear(&emitters);
    free(albedo);
    free(p);
}

static void test_an_emission_layer_is_believed(void **state) {
    (void)state;
    struct picture *p = room();
    struct fewray_denoise_input in = input_of(p);
    in.emission = fewray_interleaved(p->emission, WIDTH); /* tells of none */
    denoise(&in, p->out);
    float *out = malloc(sizeof p->out);
    assert_non_null(out);
    memcpy(out, p->out, sizeof p->out);
    in.emission = (struct fewray_channels){0};
    denoise(&in, p->out);
    assert_memory_not_equal(out, p->out, sizeof p->out);
    free(out);
    free(p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_window_stays_and_floods_nothing),
        cmocka_unit_test(test_a_mirror_is_filtered),
        cmocka_unit_test(test_only_what_is_black_and_bright_changes),
        cmocka_unit_test(test_an_emission_layer_is_believed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
