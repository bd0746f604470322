/* SPDX-License-Identifier: Apache-2.0 */
/* Other layers under the beauty's own weights: sums stay sums, and the beauty doesn't notice. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "fewray/denoise.h"

enum { DIRECT, INDIRECT, LIGHTS };

/* Interleaved; direct and indirect, with the lamp in direct, add up to color. */
struct picture {
    int width, height;
    float *color, *variance, *albedo, *normal, *emission, *alpha, *light[LIGHTS];
    float *out, *out_light[LIGHTS], *out_alpha;
};

static float uniform(uint32_t *state) {
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) * 0x1p-24f;
}

static float *values(const struct picture *p, int channels) {
    return calloc((size_t)p->width * (size_t)p->height * (size_t)channels, sizeof(float));
}

static size_t count(const struct picture *p) {
    return (size_t)p->width * (size_t)p->height * 3;
}

/* A tiled floor with a lamp; the upper left is background, where the other half of a pixel's
 * samples may lie. */
static struct picture room(int width, int height) {
    struct picture p = {.width = width, .height = height};
    float **three[] = {&p.color,
                       &p.variance,
                       &p.albedo,
                       &p.normal,
                       &p.emission,
                       &p.light[DIRECT],
                       &p.light[INDIRECT],
                       &p.out,
                       &p.out_light[DIRECT],
                       &p.out_light[INDIRECT]};
    for (size_t i = 0; i < sizeof three / sizeof *three; i++)
        *three[i] = values(&p, 3);
    p.alpha = values(&p, 1);
    p.out_alpha = values(&p, 1);
    uint32_t seed = 5;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const int i = y * width + x;
            p.alpha[i] = x + y > width / 8 ? 1.0f : x + y == width / 8 ? 0.25f : 0.0f;
            if (p.alpha[i] == 0.0f)
                continue;
            const float direct = uniform(&seed) < 0.3f ? 2.0f : 0.0f;
            const float indirect = uniform(&seed) < 0.2f ? 1.5f : 0.1f;
            const bool lamp = abs(x - width / 2) < 9 && abs(y - height / 3) < 5;
            for (int c = 0; c < 3; c++) {
                const int k = 3 * i + c;
                const float tile = (x / 16 + y / 16) & 1 ? 0.8f : 0.3f;
                p.albedo[k] = lamp ? 0.0f : p.alpha[i] * tile * (1.0f - 0.2f * (float)c);
                p.emission[k] = lamp ? 15.0f : 0.0f;
                p.light[DIRECT][k] = p.emission[k] + p.albedo[k] * direct;
                p.light[INDIRECT][k] = p.albedo[k] * indirect * (1.0f + 0.1f * (float)c);
                p.color[k] = p.light[DIRECT][k] + p.light[INDIRECT][k];
                p.variance[k] = 0.5f * p.albedo[k] * p.albedo[k];
                p.normal[k] = c == 1;
            }
        }
    return p;
}

static void picture_clear(struct picture *p) {
    float *all[] = {p->color,
                    p->variance,
                    p->albedo,
                    p->normal,
                    p->emission,
                    p->alpha,
                    p->light[DIRECT],
                    p->light[INDIRECT],
                    p->out,
                    p->out_light[DIRECT],
                    p->out_light[INDIRECT],
                    p->out_alpha};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        free(all[i]);
}

static struct fewray_denoise_input beauty(const struct picture *p) {
    return (struct fewray_denoise_input){.width = p->width,
                                         .height = p->height,
                                         .color = fewray_interleaved(p->color, p->width),
                                         .variance = fewray_interleaved(p->variance, p->width),
                                         .albedo = fewray_interleaved(p->albedo, p->width),
                                         .normal = fewray_interleaved(p->normal, p->width),
                                         .emission = fewray_interleaved(p->emission, p->width)};
}

static struct fewray_denoise_layer radiance(const struct picture *p, const float *in, float *out,
                                            enum fewray_emission_part emission) {
    return (struct fewray_denoise_layer){.in = fewray_interleaved(in, p->width),
                                         .emission = emission,
                                         .out = {out, out + 1, out + 2},
                                         .out_pixel_stride = 3,
                                         .out_row_stride = 3 * p->width};
}

static struct fewray_denoise_layer coverage(const struct picture *p, const float *in, float *out) {
    return (struct fewray_denoise_layer){.in = {{in, NULL, NULL}, 1, p->width},
                                         .coverage = true,
                                         .out = {out, NULL, NULL},
                                         .out_pixel_stride = 1,
                                         .out_row_stride = p->width};
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
    if (fewray_denoiser_run(denoiser, in, out, &stats, &error))
        fail_msg("%s", error.what);
    fewray_denoiser_destroy(&denoiser);
    return stats;
}

/* Direct, indirect and alpha beside the beauty. */
static struct fewray_denoise_stats denoise_layers(const struct picture *p,
                                                  struct fewray_denoise_input in, bool shared,
                                                  int threads, size_t memory) {
    const struct fewray_denoise_layer layers[] = {
        radiance(p, p->light[DIRECT], p->out_light[DIRECT],
                 shared ? FEWRAY_EMISSION_SHARED : FEWRAY_EMISSION_INSIDE),
        coverage(p, p->alpha, p->out_alpha),
        radiance(p, p->light[INDIRECT], p->out_light[INDIRECT],
                 shared ? FEWRAY_EMISSION_SHARED : FEWRAY_EMISSION_ELSEWHERE),
    };
    in.layers = layers;
    in.layer_count = 3;
    return denoise(&in, p->out, threads, memory);
}

static void expect_sum(const struct picture *p) {
    double changed = 0;
    for (size_t i = 0; i < count(p); i++) {
        const float sum = p->out_light[DIRECT][i] + p->out_light[INDIRECT][i];
        assert_float_equal(sum, p->out[i], 3e-6f * (1e-3f + p->out[i]));
        changed += fabsf(p->out_light[INDIRECT][i] - p->light[INDIRECT][i]);
    }
    assert_true(changed > 0.05 * (double)count(p)); /* filtered, not copied */
}

static void test_filtered_layers_add_up_to_the_filtered_beauty(void **state) {
    (void)state;
    struct picture p = room(203, 150);
    denoise_layers(&p, beauty(&p), false, 2, 0);
    expect_sum(&p);
    picture_clear(&p);
}

static void test_sums_hold_without_albedo(void **state) {
    (void)state;
    struct picture p = room(130, 100);
    struct fewray_denoise_input in = beauty(&p);
    in.albedo = (struct fewray_channels){0};
    denoise_layers(&p, in, false, 2, 0);
    expect_sum(&p);
    picture_clear(&p);
}

static void test_sums_hold_with_an_albedo_of_the_samples(void **state) {
    (void)state;
    struct picture p = room(130, 100);
    struct fewray_denoise_input in = beauty(&p);
    in.shaded_albedo = in.albedo;
    in.albedo = fewray_interleaved(p.normal, p.width);
    denoise_layers(&p, in, false, 2, 0);
    expect_sum(&p);
    picture_clear(&p);
}

/* What the denoiser itself takes for a lamp belongs to the layers by their shares. */
static void test_sums_hold_where_no_layer_tells_of_emission(void **state) {
    (void)state;
    struct picture p = room(130, 100);
    struct fewray_denoise_input in = beauty(&p);
    in.emission = (struct fewray_channels){0};
    denoise_layers(&p, in, true, 2, 0);
    expect_sum(&p);
    picture_clear(&p);
}

static void test_sums_hold_over_several_tiles(void **state) {
    (void)state;
    struct picture p = room(1100, 140);
    const size_t all = denoise_layers(&p, beauty(&p), false, 2, 0).buffer_bytes;
    const struct fewray_denoise_stats stats =
        denoise_layers(&p, beauty(&p), false, 2, all * 6 / 10);
    assert_true(stats.regions > 1);
    assert_true(stats.buffer_bytes <= all * 6 / 10);
    expect_sum(&p);
    picture_clear(&p);
}

/* Blocks that are copied or hold no light: the layers go the beauty's way. */
static void test_sums_hold_where_nothing_is_filtered(void **state) {
    (void)state;
    struct picture p = room(600, 130);
    for (int y = 0; y < p.height; y++)
        for (int x = 0; x < p.width; x++)
            for (int c = 0; c < 3; c++) {
                const int i = 3 * (y * p.width + x) + c;
                p.variance[i] = x < 128 ? 0.0f : p.variance[i]; /* settled where lit */
                if (x >= 384)                                   /* in the dark */
                    p.color[i] = p.light[DIRECT][i] = p.emission[i] = p.light[INDIRECT][i] = 0.0f;
            }
    const struct fewray_denoise_stats stats = denoise_layers(&p, beauty(&p), false, 2, 0);
    assert_true(stats.tiles_denoised < stats.tiles);
    for (size_t i = 0; i < count(&p); i++)
        assert_float_equal(p.out_light[DIRECT][i] + p.out_light[INDIRECT][i], p.out[i],
                           3e-6f * (1e-3f + p.out[i]));
    assert_true(p.out_alpha[p.width - 1] == 1.0f && p.out_alpha[0] == 0.0f);
    picture_clear(&p);
}

static void test_layers_leave_the_beautys_bits(void **state) {
    (void)state;
    struct picture p = room(150, 117);
    const struct fewray_denoise_input in = beauty(&p);
    float *alone = values(&p, 3);
    denoise(&in, alone, 2, 0);
    denoise_layers(&p, in, false, 2, 0);
    assert_memory_equal(p.out, alone, count(&p) * sizeof(float));
    free(alone);
    picture_clear(&p);
}

static void test_the_colour_as_a_layer_becomes_the_beauty(void **state) {
    (void)state;
    struct picture p = room(150, 117);
    struct fewray_denoise_input in = beauty(&p);
    const struct fewray_denoise_layer layer =
        radiance(&p, p.color, p.out_light[DIRECT], FEWRAY_EMISSION_INSIDE);
    in.layers = &layer;
    in.layer_count = 1;
    denoise(&in, p.out, 2, 0);
    for (size_t i = 0; i < count(&p); i++)
        assert_float_equal(p.out_light[DIRECT][i], p.out[i], 1e-6f * p.out[i]);
    picture_clear(&p);
}

/* Three coverages and no radiance: slots without RGB. */
static void test_coverage_is_filtered_like_a_grey_picture(void **state) {
    (void)state;
    struct picture p = room(97, 80);
    float *outs[3];
    struct fewray_denoise_layer layers[3];
    struct fewray_denoise_input in = beauty(&p);
    in.albedo = in.emission = in.variance = in.normal = (struct fewray_channels){0};
    for (size_t i = 0; i < count(&p); i++)
        p.color[i] = p.alpha[i / 3];
    for (int k = 0; k < 3; k++) {
        outs[k] = values(&p, 1);
        layers[k] = coverage(&p, p.alpha, outs[k]);
    }
    in.layers = layers;
    in.layer_count = 3;
    denoise(&in, p.out, 2, 0);
    for (int k = 0; k < 3; k++) {
        for (size_t i = 0; i < count(&p) / 3; i++) {
            assert_true(outs[k][i] >= 0.0f && outs[k][i] <= 1.0f);
            assert_float_equal(outs[k][i], p.out[3 * i], 2e-6f);
        }
        free(outs[k]);
    }
    picture_clear(&p);
}

static void test_threads_give_the_same_bits(void **state) {
    (void)state;
    struct picture p = room(150, 117);
    float *first = values(&p, 3), *first_alpha = values(&p, 1);
    denoise_layers(&p, beauty(&p), false, 1, 0);
    memcpy(first, p.out_light[INDIRECT], count(&p) * sizeof(float));
    memcpy(first_alpha, p.out_alpha, count(&p) / 3 * sizeof(float));
    for (int threads = 2; threads <= 4; threads++) {
        denoise_layers(&p, beauty(&p), false, threads, 0);
        assert_memory_equal(p.out_light[INDIRECT], first, count(&p) * sizeof(float));
        assert_memory_equal(p.out_alpha, first_alpha, count(&p) / 3 * sizeof(float));
    }
    free(first);
    free(first_alpha);
    picture_clear(&p);
}

static void test_damaged_layers_stay_finite(void **state) {
    (void)state;
    static const float bad[] = {NAN, INFINITY, -1.0f, -INFINITY, 1e-42f};
    struct picture p = room(97, 80);
    for (int i = 0; i < 5; i++) {
        p.light[DIRECT][9000 + 40 * i] = p.light[INDIRECT][9700 + 41 * i] = bad[i];
        p.alpha[3000 + 43 * i] = p.alpha[i] = bad[i];
    }
    for (int shared = 0; shared < 2; shared++) {
        denoise_layers(&p, beauty(&p), shared, 2, 0);
        for (size_t i = 0; i < count(&p); i++)
            for (int k = 0; k < LIGHTS; k++)
                assert_true(isfinite(p.out_light[k][i]) && p.out_light[k][i] >= 0.0f);
        for (size_t i = 0; i < count(&p) / 3; i++)
            assert_true(p.out_alpha[i] >= 0.0f && p.out_alpha[i] <= 1.0f);
    }
    picture_clear(&p);
}

static void test_incomplete_layers_are_refused(void **state) {
    (void)state;
    struct picture p = room(20, 20);
    struct fewray_denoise_layer layer =
        radiance(&p, p.color, p.out_light[DIRECT], FEWRAY_EMISSION_INSIDE);
    struct fewray_denoise_input in = beauty(&p);
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    in.layers = &layer;
    in.layer_count = 1;
    fewray_denoise_options_init(&options);
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, NULL), FEWRAY_OK);
    layer.out[2] = NULL;
    assert_int_equal(fewray_denoiser_run(denoiser, &in, p.out, NULL, NULL), FEWRAY_ERROR_ARGUMENT);
    layer = coverage(&p, NULL, p.out_alpha);
    assert_int_equal(fewray_denoiser_run(denoiser, &in, p.out, NULL, NULL), FEWRAY_ERROR_ARGUMENT);
    fewray_denoiser_destroy(&denoiser);
    picture_clear(&p);
}

/* --- frames */

static const char *const PLANES[] = {"R",          "G",          "B",          "A",
                                     "direct.R",   "direct.G",   "direct.B",   "indirect.R",
                                     "indirect.G", "indirect.B", "albedo.R",   "albedo.G",
                                     "albedo.B",   "emission.R", "emission.G", "emission.B"};

static struct fewray_frame *frame_of(const struct picture *p) {
    const float *const from[] = {p->color, p->light[DIRECT], p->light[INDIRECT], p->albedo,
                                 p->emission};
    struct fewray_frame *frame = NULL;
    assert_int_equal(fewray_frame_create(p->width, p->height, &frame, NULL), FEWRAY_OK);
    for (size_t k = 0; k < sizeof PLANES / sizeof *PLANES; k++) {
        float *plane = fewray_frame_add(frame, PLANES[k]);
        for (size_t i = 0; i < count(p) / 3; i++)
            plane[i] = k == 3 ? p->alpha[i]
                              : from[k < 3 ? 0 : (k - 1) / 3][3 * i + (k < 3 ? k : (k - 1) % 3)];
    }
    return frame;
}

static int denoise_frame(struct fewray_frame *frame, const char *const *names, int name_count,
                         struct fewray_error *error) {
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    fewray_denoise_options_init(&options);
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, NULL), FEWRAY_OK);
    const int status = fewray_denoise_frame_layers(denoiser, frame, names, name_count, NULL, error);
    fewray_denoiser_destroy(&denoiser);
    return status;
}

static void test_named_layers_of_a_frame(void **state) {
    (void)state;
    static const char *const names[] = {"direct", "indirect", "direct"};
    struct picture p = room(90, 70);
    struct fewray_frame *frame = frame_of(&p);
    struct fewray_error error;
    if (denoise_frame(frame, names, 3, &error))
        fail_msg("%s", error.what);
    const float *sum = fewray_frame_plane(frame, "G"),
                *direct = fewray_frame_plane(frame, "direct.G"),
                *indirect = fewray_frame_plane(frame, "indirect.G"),
                *noisy = fewray_frame_plane(frame, "noisy.indirect.G"),
                *noisy_alpha = fewray_frame_plane(frame, "noisy.A"),
                *alpha = fewray_frame_plane(frame, "A");
    assert_true(noisy && noisy_alpha);
    bool filtered = false;
    for (size_t i = 0; i < count(&p) / 3; i++) {
        assert_float_equal(direct[i] + indirect[i], sum[i], 3e-6f * (1e-3f + sum[i]));
        assert_true(noisy[i] == p.light[INDIRECT][3 * i + 1]);
        assert_true(noisy_alpha[i] == p.alpha[i]);
        filtered |= alpha[i] != p.alpha[i];
    }
    assert_true(filtered);
    fewray_frame_destroy(&frame);
    picture_clear(&p);
}

/* A failure leaves the frame's values; full coverage isn't filtered at all. */
static void test_a_frame_without_the_layer_keeps_its_values(void **state) {
    (void)state;
    static const char *const wrong[][2] = {
        {"direct", "nothing"}, {"direct", "albedo"}, {"R", "direct"}, {"direct", "A:emission"}};
    struct picture p = room(40, 30);
    for (size_t i = 0; i < count(&p) / 3; i++)
        p.alpha[i] = 1.0f;
    struct fewray_frame *frame = frame_of(&p);
    struct fewray_error error;
    for (int k = 0; k < 4; k++) {
        assert_true(denoise_frame(frame, wrong[k], 2, &error) < 0);
        for (size_t i = 0; i < count(&p) / 3; i++)
            assert_true(fewray_frame_plane(frame, "direct.B")[i] == p.light[DIRECT][3 * i + 2] &&
                        fewray_frame_plane(frame, "B")[i] == p.color[3 * i + 2]);
    }
    assert_int_equal(denoise_frame(frame, NULL, 0, &error), FEWRAY_OK);
    assert_null(fewray_frame_plane(frame, "noisy.A"));
    fewray_frame_destroy(&frame);
    picture_clear(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_filtered_layers_add_up_to_the_filtered_beauty),
        cmocka_unit_test(test_sums_hold_without_albedo),
        cmocka_unit_test(test_sums_hold_with_an_albedo_of_the_samples),
        cmocka_unit_test(test_sums_hold_where_no_layer_tells_of_emission),
        cmocka_unit_test(test_sums_hold_over_several_tiles),
        cmocka_unit_test(test_sums_hold_where_nothing_is_filtered),
        cmocka_unit_test(test_layers_leave_the_beautys_bits),
        cmocka_unit_test(test_the_colour_as_a_layer_becomes_the_beauty),
        cmocka_unit_test(test_coverage_is_filtered_like_a_grey_picture),
        cmocka_unit_test(test_threads_give_the_same_bits),
        cmocka_unit_test(test_damaged_layers_stay_finite),
        cmocka_unit_test(test_incomplete_layers_are_refused),
        cmocka_unit_test(test_named_layers_of_a_frame),
        cmocka_unit_test(test_a_frame_without_the_layer_keeps_its_values),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
