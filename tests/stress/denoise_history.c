/* SPDX-License-Identifier: Apache-2.0 */
/* The mean over frames with motion, depth and layers at their worst: what comes out is finite and a
 * mean of the light that went in. */

#include "denoise_stage.h"

enum { SIDE = 12, PIXELS = SIDE * SIDE };

/* Two products, their sum and the division by albedo and its undoing, a frame. */
#define JOIN_ERROR (2 * 8 * 0x1p-24)

struct shot {
    float color[3 * PIXELS], variance[3 * PIXELS], albedo[3 * PIXELS], normal[3 * PIXELS];
    float depth[PIXELS], offset[2 * PIXELS], previous_depth[PIXELS];
};

static void make_shot(struct shot *s, float light) {
    for (int i = 0; i < PIXELS; i++) {
        for (int c = 0; c < 3; c++) {
            s->color[3 * i + c] = light * (1 + 0.1f * (float)((i + c) % 5));
            s->variance[3 * i + c] = 0.3f;
            s->albedo[3 * i + c] = 1;
            s->normal[3 * i + c] = c == 2;
        }
        s->depth[i] = s->previous_depth[i] = 3;
        s->offset[2 * i] = 0.3f;
        s->offset[2 * i + 1] = -0.6f;
    }
}

static struct fewray_channels plane(const float *values) {
    return (struct fewray_channels){.channel = {values}, .pixel_stride = 1, .row_stride = SIDE};
}

static struct fewray_denoise_input input_of(const struct shot *s) {
    return (struct fewray_denoise_input){.width = SIDE,
                                         .height = SIDE,
                                         .color = fewray_interleaved(s->color, SIDE),
                                         .variance = fewray_interleaved(s->variance, SIDE),
                                         .albedo = fewray_interleaved(s->albedo, SIDE),
                                         .normal = fewray_interleaved(s->normal, SIDE),
                                         .depth = plane(s->depth)};
}

/* Adds both frames; out gets the second one's mean. */
static void add_both(const struct shot *first, const struct shot *second, int threads,
                     float out[3 * PIXELS]) {
    struct fewray_denoise_history_options options;
    struct fewray_denoise_history *history = NULL;
    fewray_denoise_history_options_init(&options);
    options.threads = threads;
    const struct fewray_denoise_motion motion = {
        .offset = {.channel = {second->offset, second->offset + 1},
                   .pixel_stride = 2,
                   .row_stride = 2 * SIDE},
        .previous_depth = plane(second->previous_depth)};
    const struct fewray_denoise_input a = input_of(first), b = input_of(second);
    struct fewray_denoise_input result;
    assert_int_equal(fewray_denoise_history_create(&options, &history, NULL), FEWRAY_OK);
    assert_int_equal(fewray_denoise_history_add(history, &a, NULL, &result, NULL), FEWRAY_OK);
    assert_int_equal(fewray_denoise_history_add(history, &b, &motion, &result, NULL), FEWRAY_OK);
    for (int i = 0; i < 3 * PIXELS; i++) {
        const ptrdiff_t at =
            i / 3 / SIDE * result.color.row_stride + i / 3 % SIDE * result.color.pixel_stride;
        out[i] = result.color.channel[i % 3][at];
        assert_true(isfinite(result.variance.channel[i % 3][at]));
        assert_true(result.variance.channel[i % 3][at] >= 0);
    }
    fewray_denoise_history_destroy(&history);
}

static double cleaned(double v) {
    return v > 0 ? fmin(v, 1e12) : 0;
}

static double divisor_of(double albedo) {
    return albedo > 0.01 ? fmin(albedo, 1e3) : 0.01;
}

static void assert_means_of_both(const struct shot *first, const struct shot *second,
                                 const float *out, const char *what) {
    double least = INFINITY, most = 0;
    for (int i = 0; i < 3 * PIXELS; i++) {
        const double a = cleaned(first->color[i]) / divisor_of(first->albedo[i]),
                     b = cleaned(second->color[i]) / divisor_of(second->albedo[i]);
        least = fmin(least, fmin(a, b));
        most = fmax(most, fmax(a, b));
    }
    for (int i = 0; i < 3 * PIXELS; i++) {
        const double albedo = divisor_of(second->albedo[i]);
        if (!(out[i] >= least * albedo * (1 - JOIN_ERROR) - 64 * 0x1p-149 &&
              out[i] <= most * albedo * (1 + JOIN_ERROR) + 64 * 0x1p-149))
            fail_msg("%s: value %d is %g, light is from %g to %g", what, i, (double)out[i], least,
                     most);
    }
}

static const float VALUES[] = {NAN,     INFINITY, -INFINITY, 0,       -1,       1e-41f,
                               1e-12f,  1e12f,    1e30f,     -1e30f,  FLT_MAX,  -FLT_MAX,
                               0x1p31f, -0x1p31f, 0x1p63f,   11.999f, -11.999f, 12};
enum { VALUE_COUNT = sizeof VALUES / sizeof *VALUES };

static const struct {
    const char *name;
    size_t offset; /* in struct shot */
    int floats;
} LAYERS[] = {
    {"color", offsetof(struct shot, color), 3 * PIXELS},
    {"variance", offsetof(struct shot, variance), 3 * PIXELS},
    {"albedo", offsetof(struct shot, albedo), 3 * PIXELS},
    {"normal", offsetof(struct shot, normal), 3 * PIXELS},
    {"depth", offsetof(struct shot, depth), PIXELS},
    {"motion", offsetof(struct shot, offset), 2 * PIXELS},
    {"previous depth", offsetof(struct shot, previous_depth), PIXELS},
};
enum { LAYER_COUNT = sizeof LAYERS / sizeof *LAYERS };

static void damage(struct shot *s, int layer, float value, int step) {
    float *values = (float *)(void *)((char *)s + LAYERS[layer].offset);
    for (int i = 0; i < LAYERS[layer].floats; i += step)
        values[i] = value;
}

static void test_any_value_in_any_layer_leaves_means_of_light(void **state) {
    (void)state;
    static struct shot first, second;
    static float out[3 * PIXELS];
    for (int layer = 0; layer < LAYER_COUNT; layer++)
        for (int v = 0; v < VALUE_COUNT; v++)
            for (int which = 1; which < 4; which++) /* first frame, second, both */
                for (int step = 1; step <= 11; step += 10) {
                    make_shot(&first, 1);
                    make_shot(&second, 1.1f);
                    if (which & 1)
                        damage(&first, layer, VALUES[v], step);
                    if (which & 2)
                        damage(&second, layer, VALUES[v], step);
                    add_both(&first, &second, 1, out);
                    assert_means_of_both(&first, &second, out, LAYERS[layer].name);
                }
}

/* A place or depth that is none leaves the frame as it is: the same bits, as albedo is 1. */
static void test_impossible_motion_finds_nothing(void **state) {
    (void)state;
    static const struct {
        const char *name;
        float x, y, depth;
    } cases[] = {
        {"NaN in x", NAN, 0, 3},
        {"NaN in y", 0, NAN, 3},
        {"infinite", INFINITY, 0, 3},
        {"minus infinite", 0, -INFINITY, 3},
        {"beyond integers", 1e30f, 0, 3},
        {"depth NaN", 0, 0, NAN},
        {"depth infinite", 0, 0, INFINITY},
        {"depth 0", 0, 0, 0},
        {"depth negative", 0, 0, -3},
    };
    static struct shot first, second;
    static float out[3 * PIXELS];
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        make_shot(&first, 1);
        make_shot(&second, 1.1f);
        for (int i = 0; i < PIXELS; i++) {
            second.offset[2 * i] = cases[k].x;
            second.offset[2 * i + 1] = cases[k].y;
            second.previous_depth[i] = cases[k].depth;
        }
        add_both(&first, &second, 1, out);
        if (memcmp(out, second.color, sizeof out))
            fail_msg("%s: something was found", cases[k].name);
    }
}

static void test_bits_do_not_depend_on_threads(void **state) {
    (void)state;
    static struct shot first, second;
    static float one[3 * PIXELS], out[3 * PIXELS];
    make_shot(&first, 1);
    make_shot(&second, 1.1f);
    damage(&second, 0, NAN, 17);
    damage(&first, 1, INFINITY, 13);
    add_both(&first, &second, 1, one);
    assert_memory_not_equal(one, second.color, sizeof one); /* the first frame has its share */
    static const int threads[] = {2, 7};
    for (int t = 0; t < 2; t++) {
        add_both(&first, &second, threads[t], out);
        assert_memory_equal(out, one, sizeof out);
    }
}

/* Radiance times a power of two changes no decision: the very bits, scaled. */
static void test_the_mean_scales_with_radiance(void **state) {
    (void)state;
    static const int exponents[] = {-40, -12, 12, 38};
    static struct shot first, second;
    static float one[3 * PIXELS], out[3 * PIXELS];
    make_shot(&first, 1);
    make_shot(&second, 1.1f);
    add_both(&first, &second, 1, one);
    for (int e = 0; e < 4; e++) {
        struct shot *const shots[2] = {&first, &second};
        for (int s = 0; s < 2; s++) {
            make_shot(shots[s], s ? 1.1f : 1);
            for (int i = 0; i < 3 * PIXELS; i++) {
                shots[s]->color[i] = ldexpf(shots[s]->color[i], exponents[e]);
                shots[s]->variance[i] = ldexpf(shots[s]->variance[i], 2 * exponents[e]);
            }
        }
        add_both(&first, &second, 1, out);
        for (int i = 0; i < 3 * PIXELS; i++)
            assert_true(ldexpf(out[i], -exponents[e]) == one[i]);
    }
}

static void test_incomplete_motion_and_colour_are_refused(void **state) {
    (void)state;
    static struct shot s;
    make_shot(&s, 1);
    struct fewray_denoise_history *history = NULL;
    struct fewray_denoise_input in = input_of(&s), out;
    struct fewray_error error = {0};
    const struct fewray_denoise_motion half = {.offset = plane(s.offset),
                                               .previous_depth = plane(s.previous_depth)};
    assert_int_equal(fewray_denoise_history_create(NULL, &history, &error), FEWRAY_OK);
    assert_int_equal(fewray_denoise_history_add(history, &in, &half, &out, &error),
                     FEWRAY_ERROR_ARGUMENT);
    in.color.channel[2] = NULL;
    assert_int_equal(fewray_denoise_history_add(history, &in, NULL, &out, &error),
                     FEWRAY_ERROR_ARGUMENT);
    fewray_denoise_history_destroy(&history);
    static const float bad[][2] = {{0, 1}, {NAN, 1}, {8, 0}, {8, NAN}, {-INFINITY, 1}};
    for (int k = 0; k < 5; k++) {
        const struct fewray_denoise_history_options options = {bad[k][0], bad[k][1], 1};
        assert_int_equal(fewray_denoise_history_create(&options, &history, &error),
                         FEWRAY_ERROR_ARGUMENT);
        assert_null(history);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_any_value_in_any_layer_leaves_means_of_light),
        cmocka_unit_test(test_impossible_motion_finds_nothing),
        cmocka_unit_test(test_bits_do_not_depend_on_threads),
        cmocka_unit_test(test_the_mean_scales_with_radiance),
        cmocka_unit_test(test_incomplete_motion_and_colour_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
