/* SPDX-License-Identifier: Apache-2.0 */
/* How far a pixel reaches, and how exposure passes through the denoiser. */

#include "denoise/kpn.h"
#include "denoise_stage.h"

/* Dark at the left, so that damage there leaves the picture's median, and with it the exposure that
 * the network sees, as it is. */
enum { WIDTH = 448, HEIGHT = 16, DARK = 32, BAD_X = 5, BAD_Y = 6 };

static struct picture strip(void) {
    struct picture p = room(WIDTH, HEIGHT);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < DARK; x++)
            for (int c = 0; c < 3; c++)
                p.color[3 * (y * WIDTH + x) + c] *= 0.01f;
    return p;
}

/* Beyond KPN_OVERLAP pixels nothing of a pixel is seen: the same bits. */
static void test_damage_ends_at_the_receptive_field(void **state) {
    (void)state;
    static const float values[] = {NAN, -INFINITY, -1.0f, 1e-41f, 0.0f};
    struct picture p = strip();
    float *good = layer(&p, 3);
    struct stage stage;
    stage_open(&stage);
    for (int model = 0; model < MODELS; model++)
        for (int layers = 0; layers < 2; layers++) {
            const struct fewray_denoise_input in = layers ? all_layers(&p) : color_alone(&p);
            stage_run(&stage, model, &in, good);
            for (size_t v = 0; v < sizeof values / sizeof *values; v++) {
                float *bad = p.color + 3 * (BAD_Y * WIDTH + BAD_X), kept = *bad;
                *bad = values[v];
                stage_run(&stage, model, &in, p.out);
                *bad = kept;
                for (int y = 0; y < HEIGHT; y++)
                    assert_memory_equal(p.out + 3 * (y * WIDTH + BAD_X + KPN_OVERLAP + 1),
                                        good + 3 * (y * WIDTH + BAD_X + KPN_OVERLAP + 1),
                                        sizeof(float) * 3 * (WIDTH - BAD_X - KPN_OVERLAP - 1));
            }
        }
    stage_close(&stage);
    free(good);
    picture_clear(&p);
}

/* A firefly moves its block of 4x4 pixels above the median: the median's place moves by one rank of
 * 448, at most a bin of 1/32 octave. What the network then sees is another exposure, of which the
 * picture depends by less than this part. */
#define FIREFLY_ELSEWHERE 0.02

static void test_a_firefly_of_1e12_stays_in_its_surroundings(void **state) {
    (void)state;
    struct picture p = strip();
    float *good = layer(&p, 3);
    struct stage stage;
    stage_open(&stage);
    for (int model = 0; model < MODELS; model++) {
        const struct fewray_denoise_input in = all_layers(&p);
        stage_run(&stage, model, &in, good);
        float *bad = p.color + 3 * (BAD_Y * WIDTH + BAD_X), kept = *bad;
        *bad = 1e12f;
        stage_run(&stage, model, &in, p.out);
        *bad = kept;
        assert_all_finite(p.out, count(&p), "firefly");
        for (int y = 0; y < HEIGHT; y++)
            for (int i = 3 * (BAD_X + KPN_OVERLAP + 1); i < 3 * WIDTH; i++) {
                const double expected = good[3 * y * WIDTH + i];
                assert_near(p.out[3 * y * WIDTH + i], expected, FIREFLY_ELSEWHERE * expected);
            }
    }
    stage_close(&stage);
    free(good);
    picture_clear(&p);
}

/* Means over five levels of 5x5 pixels, each twice as wide as the one below, the parent's own
 * place rounded: 2 * (1 + 2 + 4 + 8 + 16) and 2 more a level; what lies farther has no weight. */
enum { MEAN_REACH = 64 };

static void test_output_lies_between_the_least_and_most_light_around(void **state) {
    (void)state;
    enum { W = 208, H = 16 };
    struct picture p = picture_new(W, H);
    uint32_t seed = 5;
    for (int i = 0; i < W * H; i++) /* decades of light from left to right, noise of two */
        for (int c = 0; c < 3; c++)
            p.color[3 * i + c] = powf(10, (float)(i % W) * 0.05f - 5 + 2 * uniform(&seed));
    struct stage stage;
    stage_open(&stage);
    for (int model = 0; model < MODELS; model++) {
        const struct fewray_denoise_input in = color_alone(&p);
        stage_run(&stage, model, &in, p.out);
        for (int c = 0; c < 3; c++)
            for (int x = 0; x < W; x++) {
                double least = INFINITY, most = 0;
                for (int y = 0; y < H; y++)
                    for (int u = x - MEAN_REACH; u <= x + MEAN_REACH; u++) {
                        const int inside = u < 0 ? 0 : u < W ? u : W - 1;
                        const double v = p.color[3 * (y * W + inside) + c];
                        least = fmin(least, v);
                        most = fmax(most, v);
                    }
                for (int y = 0; y < H; y++) {
                    const double v = p.out[3 * (y * W + x) + c];
                    assert_true(v >= least * (1 - MEAN_ERROR) && v <= most * (1 + MEAN_ERROR));
                }
            }
    }
    stage_close(&stage);
    picture_clear(&p);
}

/* Radiance times a power of two: the exposure is found again but for the rounding of its logarithm,
 * and the network works on nearly the same numbers. */
#define SCALE_ERROR 1e-3

static void scale_layers(struct picture *to, const struct picture *from, float scale) {
    for (size_t i = 0; i < count(to); i++) {
        to->color[i] = from->color[i] * scale;
        to->variance[i] = from->variance[i] * scale * scale;
        to->emission[i] = from->emission[i] * scale;
    }
}

static void test_output_scales_with_radiance(void **state) {
    (void)state;
    /* To 1e-12 and up to 1e12: the room's brightest pixel is at 31. */
    static const int exponents[] = {-40, -20, -7, 7, 20, 30, 35};
    struct picture one = room(64, 48), p = room(64, 48);
    float *expected = layer(&one, 3);
    struct stage stage;
    stage_open(&stage);
    for (int model = 0; model < MODELS; model++)
        for (int layers = 0; layers < 2; layers++) {
            const struct fewray_denoise_input in = layers ? all_layers(&one) : color_alone(&one);
            stage_run(&stage, model, &in, expected);
            for (size_t e = 0; e < sizeof exponents / sizeof *exponents; e++) {
                const float scale = ldexpf(1, exponents[e]);
                scale_layers(&p, &one, scale);
                const struct fewray_denoise_input scaled =
                    layers ? all_layers(&p) : color_alone(&p);
                stage_run(&stage, model, &scaled, p.out);
                for (size_t i = 0; i < count(&p); i++)
                    if (!(fabs(p.out[i] / scale - expected[i]) <= SCALE_ERROR * expected[i]))
                        fail_msg("%s, 2^%d: value %zu is %g times the scale, not %g",
                                 MODEL_NAMES[model], exponents[e], i, (double)(p.out[i] / scale),
                                 (double)expected[i]);
            }
        }
    stage_close(&stage);
    free(expected);
    picture_clear(&one);
    picture_clear(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_damage_ends_at_the_receptive_field),
        cmocka_unit_test(test_a_firefly_of_1e12_stays_in_its_surroundings),
        cmocka_unit_test(test_output_lies_between_the_least_and_most_light_around),
        cmocka_unit_test(test_output_scales_with_radiance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
