/* SPDX-License-Identifier: Apache-2.0 */
/* Values at their worst in each layer that the denoiser reads: what comes out is finite and a mean
 * of the light that goes in. */

#include "denoise_stage.h"

enum { SIDE = 32, PIXELS = SIDE * SIDE };

/* What the denoiser's headers say of impossible values: NaN and negatives are 0, more than 1e12 is
 * 1e12; light is (color - emission) / albedo, which counts as 0.01 to 1000. */
static double cleaned(double v) {
    return v > 0 ? fmin(v, 1e12) : 0;
}

static double divisor_of(double albedo) {
    return albedo > 0.01 ? fmin(albedo, 1e3) : 0.01;
}

enum layer_kind {
    COLOR,
    VARIANCE,
    ALBEDO,
    SHADED_ALBEDO,
    NORMAL,
    EMISSION,
    DEPTH,
    IRRADIANCE,
    CONFIDENCE,
    LAYERS
};
static const char *const LAYER_NAMES[LAYERS] = {
    "color",    "variance", "albedo",     "shaded albedo", "normal",
    "emission", "depth",    "irradiance", "confidence",
};
static const int CHANNELS[LAYERS] = {3, 3, 3, 3, 3, 3, 1, 3, 1};

/* A picture with every layer there is. */
struct whole {
    float values[LAYERS][3 * PIXELS], out[3 * PIXELS];
};

static void make_whole(struct whole *w) {
    struct picture p = room(SIDE, SIDE);
    const float *from[LAYERS] = {p.color,    p.variance, p.albedo, p.albedo, p.normal,
                                 p.emission, p.depth,    p.color,  p.depth};
    for (int k = 0; k < LAYERS; k++)
        memcpy(w->values[k], from[k], sizeof(float) * PIXELS * (size_t)CHANNELS[k]);
    for (int i = 0; i < PIXELS; i++)
        w->values[CONFIDENCE][i] = 0.5f;
    picture_clear(&p);
}

static struct fewray_denoise_input whole_input(const struct whole *w, bool color_alone) {
    struct fewray_denoise_input in = {
        .width = SIDE, .height = SIDE, .color = fewray_interleaved(w->values[COLOR], SIDE)};
    if (color_alone)
        return in;
    struct fewray_channels *const to[LAYERS] = {&in.color,         &in.variance,   &in.albedo,
                                                &in.shaded_albedo, &in.normal,     &in.emission,
                                                &in.depth,         &in.irradiance, &in.confidence};
    for (int k = 0; k < LAYERS; k++)
        *to[k] = CHANNELS[k] == 3 ? fewray_interleaved(w->values[k], SIDE)
                                  : (struct fewray_channels){.channel = {w->values[k]},
                                                             .pixel_stride = 1,
                                                             .row_stride = SIDE};
    return in;
}

/* out = mean of light * albedo + emission, the mean between the least and the most light of the
 * channel; all within MEAN_ERROR. */
static void assert_means_of_light(const struct whole *w, bool color_alone, const char *what) {
    double least[3] = {INFINITY, INFINITY, INFINITY}, most[3] = {0};
    for (int i = 0; i < 3 * PIXELS; i++) {
        const double emission = color_alone ? 0 : cleaned(w->values[EMISSION][i]);
        const double albedo = color_alone ? 1 : divisor_of(w->values[SHADED_ALBEDO][i]);
        const double light = cleaned(cleaned(w->values[COLOR][i]) - emission) / albedo;
        least[i % 3] = fmin(least[i % 3], light);
        most[i % 3] = fmax(most[i % 3], light);
    }
    for (int i = 0; i < 3 * PIXELS; i++) {
        const double emission = color_alone ? 0 : cleaned(w->values[EMISSION][i]);
        const double albedo = color_alone ? 1 : divisor_of(w->values[ALBEDO][i]);
        const double low = least[i % 3] * albedo + emission, high = most[i % 3] * albedo + emission;
        /* 64 denormals: products of weights and denormals are rounded to whole ones. */
        if (!(w->out[i] >= low * (1 - MEAN_ERROR) - 64 * 0x1p-149 &&
              w->out[i] <= high * (1 + MEAN_ERROR) + 64 * 0x1p-149))
            fail_msg("%s: value %d is %.9g, not from %.9g to %.9g", what, i, (double)w->out[i], low,
                     high);
    }
}

static const struct {
    const char *name;
    float value;
} VALUES[] = {
    {"NaN", NAN},         {"infinite", INFINITY}, {"minus infinite", -INFINITY},
    {"negative", -3.0f},  {"zero", 0.0f},         {"denormal", 1e-41f},
    {"1e-12", 1e-12f},    {"1e12", 1e12f},        {"largest", FLT_MAX},
    {"lowest", -FLT_MAX},
};
enum { VALUE_COUNT = sizeof VALUES / sizeof *VALUES };

static const struct {
    const char *name;
    int x0, y0, x1, y1;
} PLACES[] = {
    {"one pixel", 13, 14, 14, 15},
    {"two rows", 0, 20, SIDE, 22},
    {"all pixels", 0, 0, SIDE, SIDE},
};
enum { PLACE_COUNT = sizeof PLACES / sizeof *PLACES };

static void damage(struct whole *w, int kind, int value, int place) {
    for (int y = PLACES[place].y0; y < PLACES[place].y1; y++)
        for (int x = PLACES[place].x0; x < PLACES[place].x1; x++)
            for (int c = 0; c < CHANNELS[kind]; c++)
                w->values[kind][(y * SIDE + x) * CHANNELS[kind] + c] = VALUES[value].value;
}

static void try_damage(const struct stage *stage, int model, int kind, int value, int place,
                       bool color_alone) {
    static struct whole w;
    char what[128];
    snprintf(what, sizeof what, "%s, %s %s in %s%s", MODEL_NAMES[model], LAYER_NAMES[kind],
             VALUES[value].name, PLACES[place].name, color_alone ? ", no other layer" : "");
    make_whole(&w);
    damage(&w, kind, value, place);
    const struct fewray_denoise_input in = whole_input(&w, color_alone);
    stage_run(stage, model, &in, w.out);
    assert_all_finite(w.out, 3 * PIXELS, what);
    assert_means_of_light(&w, color_alone, what);
}

static void test_any_value_in_any_layer_leaves_means_of_light(void **state) {
    (void)state;
    struct stage stage;
    stage_open(&stage);
    /* The models differ in their weights alone: each meets every value and place, the fast one in
     * the colour. */
    for (int kind = 0; kind < LAYERS; kind++)
        for (int value = 0; value < VALUE_COUNT; value++)
            for (int place = 0; place < PLACE_COUNT; place++)
                try_damage(&stage, 0, kind, value, place, false);
    for (int model = 0; model < MODELS; model++)
        for (int value = 0; value < VALUE_COUNT; value++)
            for (int place = 0; place < PLACE_COUNT; place++)
                try_damage(&stage, model, COLOR, value, place, model == 0);
    stage_close(&stage);
}

/* Blocks that are copied because they have no noise are no way past the checks. */
static void test_settled_blocks_with_damage_are_finite(void **state) {
    (void)state;
    static struct whole w;
    struct fewray_denoise_options options;
    fewray_denoise_options_init(&options);
    options.threads = 1;
    struct stage stage;
    stage_open_with(&stage, &options);
    for (int value = 0; value < VALUE_COUNT; value++) {
        for (int i = 0; i < 3 * PIXELS; i++) {
            w.values[COLOR][i] = w.values[ALBEDO][i] = w.values[SHADED_ALBEDO][i] = 0.5f;
            w.values[VARIANCE][i] = 1e-12f;
            w.values[EMISSION][i] = 0;
        }
        for (int c = 0; c < 3; c++) { /* a hole in the scene, which counts as settled, too */
            w.values[COLOR][3 * 70 + c] = VALUES[value].value;
            w.values[ALBEDO][3 * 70 + c] = w.values[SHADED_ALBEDO][3 * 70 + c] = 0;
        }
        const struct fewray_denoise_input in = whole_input(&w, false);
        stage_run(&stage, 0, &in, w.out);
        assert_all_finite(w.out, 3 * PIXELS, VALUES[value].name);
        for (int i = 0; i < 3 * PIXELS; i++)
            assert_true(w.out[i] >= 0);
    }
    stage_close(&stage);
}

/* Layers beside the beauty: radiance stays finite and not negative, coverage in 0..1. */
static void test_any_value_in_other_layers_stays_finite(void **state) {
    (void)state;
    static struct whole w;
    static float direct[3 * PIXELS], coverage[PIXELS], out[4][3 * PIXELS];
    struct stage stage;
    stage_open(&stage);
    for (int value = 0; value < VALUE_COUNT; value++)
        for (int place = 0; place < PLACE_COUNT; place++)
            for (int part = FEWRAY_EMISSION_ELSEWHERE; part <= FEWRAY_EMISSION_SHARED; part++) {
                make_whole(&w);
                damage(&w, COLOR, value, place);
                memcpy(direct, w.values[COLOR], sizeof direct);
                for (int i = 0; i < PIXELS; i++)
                    coverage[i] = direct[3 * i];
                struct fewray_denoise_layer layers[2] = {
                    {.in = fewray_interleaved(direct, SIDE),
                     .emission = (enum fewray_emission_part)part,
                     .out = {out[0], out[1], out[2]},
                     .out_pixel_stride = 1,
                     .out_row_stride = SIDE},
                    {.in = {.channel = {coverage}, .pixel_stride = 1, .row_stride = SIDE},
                     .coverage = true,
                     .out = {out[3]},
                     .out_pixel_stride = 1,
                     .out_row_stride = SIDE}};
                struct fewray_denoise_input in = whole_input(&w, false);
                in.layers = layers;
                in.layer_count = 2;
                stage_run(&stage, 1, &in, w.out);
                assert_all_finite(w.out, 3 * PIXELS, VALUES[value].name);
                for (int i = 0; i < PIXELS; i++) {
                    for (int c = 0; c < 3; c++)
                        assert_true(out[c][i] >= 0 && isfinite(out[c][i]));
                    assert_true(out[3][i] >= 0 && out[3][i] <= 1);
                }
            }
    stage_close(&stage);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_any_value_in_any_layer_leaves_means_of_light),
        cmocka_unit_test(test_settled_blocks_with_damage_are_finite),
        cmocka_unit_test(test_any_value_in_other_layers_stays_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
