/* SPDX-License-Identifier: Apache-2.0 */
/* The history of a sequence: surfaces are found again, noise falls, what isn't there any more is
 * dropped. */

#include "tests/unit/check.h"

#include <string.h>

#include "fewray/denoise.h"

enum { WIDTH = 40, HEIGHT = 24, PIXELS = WIDTH * HEIGHT };

struct picture {
    float color[3 * PIXELS], variance[3 * PIXELS], albedo[3 * PIXELS], normal[3 * PIXELS];
    float emission[3 * PIXELS], depth[PIXELS], motion_x[PIXELS], motion_y[PIXELS], past[PIXELS];
};

static float noise(uint32_t *seed) {
    *seed = *seed * 1664525u + 1013904223u;
    return (float)(*seed >> 8) / 16777216.0f * 2 - 1;
}

/* A wall at depth 4 of this light plus noise, its texture in the albedo, that moved by (dx, dy)
 * since the frame before. */
static void wall(struct picture *p, float light, float spread, float dx, float dy, uint32_t seed) {
    memset(p, 0, sizeof *p);
    for (int i = 0; i < PIXELS; i++) {
        const float albedo = 0.4f + 0.1f * (float)(i % WIDTH % 3);
        const float l = light + spread * noise(&seed);
        for (int c = 0; c < 3; c++) {
            p->albedo[3 * i + c] = albedo;
            p->emission[3 * i + c] = 0.25f;
            p->color[3 * i + c] = albedo * l + 0.25f;
            p->variance[3 * i + c] = albedo * albedo * spread * spread / 3;
        }
        p->normal[3 * i + 2] = 1;
        p->depth[i] = p->past[i] = 4;
        p->motion_x[i] = dx;
        p->motion_y[i] = dy;
    }
}

static struct fewray_denoise_input input_of(const struct picture *p) {
    struct fewray_denoise_input in = {.width = WIDTH, .height = HEIGHT};
    in.color = fewray_interleaved(p->color, WIDTH);
    in.variance = fewray_interleaved(p->variance, WIDTH);
    in.albedo = fewray_interleaved(p->albedo, WIDTH);
    in.normal = fewray_interleaved(p->normal, WIDTH);
    in.emission = fewray_interleaved(p->emission, WIDTH);
    in.depth = (struct fewray_channels){{p->depth}, 1, WIDTH, {NULL}};
    return in;
}

static struct fewray_denoise_motion motion_of(const struct picture *p) {
    return (struct fewray_denoise_motion){{{p->motion_x, p->motion_y}, 1, WIDTH, {NULL}},
                                          {{p->past}, 1, WIDTH, {NULL}}};
}

static void add(struct fewray_denoise_history *history, const struct picture *p, bool moved,
                struct fewray_denoise_input *out) {
    const struct fewray_denoise_input in = input_of(p);
    const struct fewray_denoise_motion motion = motion_of(p);
    assert_int_equal(fewray_denoise_history_add(history, &in, moved ? &motion : NULL, out, NULL),
                     FEWRAY_OK);
}

static float value(const struct fewray_channels *channels, int x, int y) {
    return channels->channel[0][y * channels->row_stride + x * channels->pixel_stride];
}

static struct fewray_denoise_history *history_of(float frames) {
    struct fewray_denoise_history_options options;
    struct fewray_denoise_history *history = NULL;
    fewray_denoise_history_options_init(&options);
    options.frames = frames;
    options.threads = 2;
    assert_int_equal(fewray_denoise_history_create(&options, &history, NULL), FEWRAY_OK);
    return history;
}

static float light_of(const struct fewray_denoise_input *out, const struct picture *p, int x,
                      int y) {
    const int i = 3 * (y * WIDTH + x);
    return (value(&out->color, x, y) - p->emission[i]) / p->albedo[i];
}

/* A ramp of light that moves by whole and broken pixels comes back exactly, texture and emission
 * untouched by the interpolation. */
static void test_a_moved_plane_is_found_again(void **state) {
    (void)state;
    static const float moves[3][2] = {{3, -2}, {-1.25f, 0.5f}, {0, 0}};
    for (int m = 0; m < 3; m++) {
        static struct picture first, second;
        struct fewray_denoise_history *history = history_of(8);
        struct fewray_denoise_input out;
        wall(&first, 2, 0, 0, 0, 1);
        wall(&second, 2, 0, moves[m][0], moves[m][1], 1);
        for (int i = 0; i < PIXELS; i++) {
            const float x = (float)(i % WIDTH), y = (float)(i / WIDTH);
            for (int c = 0; c < 3; c++) {
                first.color[3 * i + c] = 0.25f + first.albedo[3 * i] * (2 + 0.05f * x + 0.02f * y);
                second.color[3 * i + c] =
                    0.25f + second.albedo[3 * i] *
                                (2 + 0.05f * (x + moves[m][0]) + 0.02f * (y + moves[m][1]));
            }
        }
        add(history, &first, false, &out);
        add(history, &second, true, &out);
        for (int y = 4; y < HEIGHT - 4; y++)
            for (int x = 4; x < WIDTH - 4; x++)
                assert_near(light_of(&out, &second, x, y),
                            2 + 0.05 * (x + moves[m][0]) + 0.02 * (y + moves[m][1]), 1e-4);
        fewray_denoise_history_destroy(&history);
    }
}

static void test_noise_falls_with_the_frames_and_the_variance_tells(void **state) {
    (void)state;
    static struct picture p;
    struct fewray_denoise_history *history = history_of(8);
    struct fewray_denoise_input out;
    for (int frame = 0; frame < 8; frame++) {
        wall(&p, 2, 0.6f, frame ? 1 : 0, 0, 77u + 1000u * (uint32_t)frame);
        add(history, &p, frame > 0, &out);
    }
    double squares = 0, variance = 0;
    int count = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH - 8; x++, count++) {
            const double d = light_of(&out, &p, x, y) - 2;
            squares += d * d;
            variance += value(&out.variance, x, y) / pow(p.albedo[3 * (y * WIDTH + x)], 2);
        }
    /* 0.36 / 3 over eight frames. */
    assert_near(squares / count, 0.12 / 8, 0.12 / 8 * 0.25);
    assert_near(variance / count, 0.12 / 8, 0.12 / 8 * 0.25);
    fewray_denoise_history_destroy(&history);
}

/* Depth, normal or albedo of something else: the pixel is as the frame has it, to the bit. */
static void test_what_wasnt_seen_before_is_not_mixed(void **state) {
    (void)state;
    for (int what = 0; what < 4; what++) {
        static struct picture first, second, alone;
        struct fewray_denoise_history *history = history_of(8), *fresh = history_of(8);
        struct fewray_denoise_input out, expected;
        wall(&first, 2, 0.05f, 0, 0, 1);
        wall(&second, 2, 0.05f, 0, 0, 2);
        for (int i = PIXELS / 2; i < PIXELS; i++) {
            if (what == 0)
                second.depth[i] = second.past[i] = 6;
            if (what == 1)
                second.normal[3 * i + 2] = 0, second.normal[3 * i] = 1;
            if (what == 2)
                second.past[i] = 0;
            if (what == 3)
                second.motion_x[i] = 1000;
        }
        alone = second;
        add(history, &first, false, &out);
        add(history, &second, true, &out);
        add(fresh, &alone, false, &expected);
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++) {
                const bool same = value(&out.color, x, y) == value(&expected.color, x, y);
                assert_int_equal(same, y >= HEIGHT / 2);
            }
        fewray_denoise_history_destroy(&history);
        fewray_denoise_history_destroy(&fresh);
    }
}

/* A lamp that is switched off leaves nothing behind. */
static void test_light_that_changes_is_not_mixed(void **state) {
    (void)state;
    static struct picture bright, dark;
    struct fewray_denoise_history *history = history_of(8);
    struct fewray_denoise_input out;
    for (int frame = 0; frame < 6; frame++) {
        wall(&bright, 4, 1, 0, 0, 5u + (uint32_t)frame);
        add(history, &bright, frame > 0, &out);
    }
    wall(&dark, 1, 0.5f, 0, 0, 99);
    add(history, &dark, true, &out);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            assert_near(light_of(&out, &dark, x, y), 1, 0.5 + 1e-4);
    fewray_denoise_history_destroy(&history);
}

static void test_layers_still_add_up(void **state) {
    (void)state;
    static struct picture p;
    static float direct[3 * PIXELS], indirect[3 * PIXELS];
    struct fewray_denoise_history *history = history_of(8);
    struct fewray_denoise_input out;
    for (int frame = 0; frame < 3; frame++) {
        wall(&p, 2, 0.6f, 0.5f, 0.25f, 7u + (uint32_t)frame);
        for (int i = 0; i < 3 * PIXELS; i++) {
            indirect[i] = 0.3f * (p.color[i] - p.emission[i]);
            direct[i] = p.color[i] - indirect[i];
        }
        const struct fewray_denoise_layer layers[2] = {
            {.in = fewray_interleaved(direct, WIDTH), .emission = FEWRAY_EMISSION_INSIDE},
            {.in = fewray_interleaved(indirect, WIDTH)}};
        struct fewray_denoise_input in = input_of(&p);
        const struct fewray_denoise_motion motion = motion_of(&p);
        in.layers = layers;
        in.layer_count = 2;
        assert_int_equal(fewray_denoise_history_add(history, &in, &motion, &out, NULL), FEWRAY_OK);
    }
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            assert_near(value(&out.layers[0].in, x, y) + value(&out.layers[1].in, x, y),
                        value(&out.color, x, y), 1e-5);
    fewray_denoise_history_destroy(&history);
}

static void test_a_first_frame_is_as_it_is(void **state) {
    (void)state;
    static struct picture p;
    struct fewray_denoise_history *history = history_of(8);
    struct fewray_denoise_input out;
    wall(&p, 2, 0.6f, 0, 0, 3);
    add(history, &p, true, &out);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            assert_near(value(&out.color, x, y), p.color[3 * (y * WIDTH + x)], 1e-6);
    fewray_denoise_history_destroy(&history);
    assert_null(history);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_moved_plane_is_found_again),
        cmocka_unit_test(test_noise_falls_with_the_frames_and_the_variance_tells),
        cmocka_unit_test(test_what_wasnt_seen_before_is_not_mixed),
        cmocka_unit_test(test_light_that_changes_is_not_mixed),
        cmocka_unit_test(test_layers_still_add_up),
        cmocka_unit_test(test_a_first_frame_is_as_it_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
