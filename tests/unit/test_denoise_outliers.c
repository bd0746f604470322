/* SPDX-License-Identifier: Apache-2.0 */
/* Fireflies are weighted away, not smeared, and detail that only the albedo carries stays. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fewray/denoise.h"

enum { WIDTH = 128, HEIGHT = 96, COUNT = WIDTH * HEIGHT, AROUND = 5 };

struct picture {
    float color[3 * COUNT], variance[3 * COUNT], albedo[3 * COUNT], out[3 * COUNT];
};

static struct fewray_denoiser *denoiser;

static float uniform(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) * 0x1p-24f;
}

/* What the mean of 4 samples of an irradiance of 1 looks like where 30 % of them find the lamp;
 * *variance of that mean. */
static float noisy_light(uint32_t *seed, float *variance) {
    float sum = 0, square = 0;
    for (int s = 0; s < 4; s++) {
        const float sample = uniform(seed) < 0.3f ? 2.0f * uniform(seed) / 0.3f : 0.0f;
        sum += sample;
        square += sample * sample;
    }
    *variance = (square - sum * sum / 4) / 12;
    return sum / 4;
}

/* A wall of albedo 0.5, or of checks of this many pixels of 0.2 and 0.8, under noisy light of
 * mean 1. */
static struct picture *wall(int check, uint32_t seed) {
    struct picture *p = calloc(1, sizeof *p);
    assert_non_null(p);
    for (int i = 0; i < COUNT; i++) {
        float variance;
        const float light = noisy_light(&seed, &variance);
        const bool bright = check && (i % WIDTH / check + i / WIDTH / check) & 1;
        const float albedo = !check ? 0.5f : bright ? 0.8f : 0.2f;
        for (int c = 0; c < 3; c++) {
            p->albedo[3 * i + c] = albedo;
            p->color[3 * i + c] = albedo * light;
            p->variance[3 * i + c] = albedo * albedo * variance;
        }
    }
    return p;
}

static void denoise(struct picture *p, bool variance, bool albedo) {
    struct fewray_denoise_input in = {
        .width = WIDTH, .height = HEIGHT, .color = fewray_interleaved(p->color, WIDTH)};
    if (variance)
        in.variance = fewray_interleaved(p->variance, WIDTH);
    if (albedo)
        in.albedo = fewray_interleaved(p->albedo, WIDTH);
    assert_int_equal(fewray_denoiser_run(denoiser, &in, p->out, NULL, NULL), FEWRAY_OK);
}

static const int PLACES[3][2] = {{40, 40}, {101, 61}, {62, 75}};

static void put_outliers(struct picture *p, float strength) {
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < 3; c++) {
            const int i = 3 * (PLACES[k][1] * WIDTH + PLACES[k][0]) + c;
            p->color[i] = strength * p->albedo[i];
            p->variance[i] = p->color[i] * p->color[i];
        }
}

/* The outlier and the 11 x 11 pixels around against what they are without it. */
static void check_around(const struct picture *p, const float *without, int x0, int y0) {
    double mean = 0;
    for (int y = y0 - AROUND; y <= y0 + AROUND; y++)
        for (int x = x0 - AROUND; x <= x0 + AROUND; x++) {
            const int i = 3 * (y * WIDTH + x) + 1;
            const double ratio = p->out[i] / without[i];
            if (!(ratio < 4 && ratio > 0.25))
                fail_msg("%+d, %+d of an outlier is %g times what it is without", x - x0, y - y0,
                         ratio);
            mean += ratio / ((2 * AROUND + 1) * (2 * AROUND + 1));
        }
    assert_true(fabs(mean - 1) < 0.15);
}

static void test_outliers_are_weighted_away(void **state) {
    (void)state;
    static const float strengths[] = {1e3f, 3e4f, 1e6f};
    float *without = malloc(3 * COUNT * sizeof *without);
    assert_non_null(without);
    for (int setting = 0; setting < 8; setting++) {
        const bool variance = setting & 1, albedo = setting & 2;
        struct picture *p = wall(setting & 4 ? 4 : 0, 5);
        denoise(p, variance, albedo);
        memcpy(without, p->out, 3 * COUNT * sizeof *without);
        for (int s = 0; s < 3; s++) {
            put_outliers(p, strengths[s]);
            denoise(p, variance, albedo);
            for (int k = 0; k < 3; k++)
                check_around(p, without, PLACES[k][0], PLACES[k][1]);
        }
        free(p);
    }
    free(without);
}

/* The mean of the bright checks over that of the dark ones stays the ratio of the albedos, and so
 * does each pixel's over its right neighbour's, on average. */
static void test_detail_of_the_albedo_stays(void **state) {
    (void)state;
    static const int checks[] = {1, 2, 5};
    for (int setting = 0; setting < 6; setting++) {
        struct picture *p = wall(checks[setting / 2], 9);
        denoise(p, setting & 1, true);
        double bright = 0, dark = 0, step = 0;
        int bright_count = 0, steps = 0;
        for (int i = 0; i + 1 < COUNT; i++) {
            const bool is_bright = p->albedo[3 * i] > 0.5f;
            *(is_bright ? &bright : &dark) += p->out[3 * i];
            bright_count += is_bright;
            if (i % WIDTH < WIDTH - 1 && p->albedo[3 * i] < p->albedo[3 * i + 3]) {
                step += log(p->out[3 * i + 3] / p->out[3 * i]);
                steps++;
            }
        }
        const double contrast = bright / bright_count * (COUNT - 1 - bright_count) / dark;
        if (!(fabs(contrast / 4 - 1) < 0.02 && fabs(exp(step / steps) / 4 - 1) < 0.02))
            fail_msg("checks of %d pixels: contrast %g, steps of %g, not 4", checks[setting / 2],
                     contrast, exp(step / steps));
        free(p);
    }
}

static int create_denoiser(void **state) {
    (void)state;
    struct fewray_denoise_options options;
    fewray_denoise_options_init(&options);
    options.threads = 1;
    return fewray_denoiser_create(&options, &denoiser, NULL);
}

static int destroy_denoiser(void **state) {
    (void)state;
    fewray_denoiser_destroy(&denoiser);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_outliers_are_weighted_away),
        cmocka_unit_test(test_detail_of_the_albedo_stays),
    };
    return cmocka_run_group_tests(tests, create_denoiser, destroy_denoiser);
}
