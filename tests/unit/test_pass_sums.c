/* SPDX-License-Identifier: Apache-2.0 */
/* Passes of each renderer that sum up to the picture are found, and still do behind the denoiser;
 * those that don't are told apart. */

#include "tests/unit/check.h"

#include <stdio.h>
#include <string.h>

#include "fewray/denoise.h"
#include "pipeline/pass_sums.h"

enum { SIDE = 40, COUNT = SIDE * SIDE };

/* Layers of R, G, B, separated by commas; "A*B" is A times the colour B. */
static const struct {
    const char *what, *passes, *emission;
    enum layer_naming naming;
    int count;
} SUMS[] = {
    {"direct and indirect light", "direct,indirect", NULL, NAMING_FEWRAY, 2},
    {"lobes",
     "VL.DiffDir*VL.DiffCol,VL.DiffInd*VL.DiffCol,VL.GlossDir*VL.GlossCol,VL.GlossInd*VL.GlossCol,"
     "VL.VolumeDir",
     "VL.Emit", NAMING_BLENDER, 5},
    {"lobes", "VL.Diffuse Direct*VL.Diffuse Color,VL.Diffuse Indirect*VL.Diffuse Color",
     "VL.Emission", NAMING_BLENDER, 2},
    {"light groups", "VL.Combined_key,VL.Combined_fill,VL.Combined_sky", NULL, NAMING_BLENDER, 3},
    {"lobes", "diffuse_direct,diffuse_indirect,specular,coat,sss", "emission", NAMING_ARNOLD, 5},
    {"lobes", "diffuse,specular,transmission", NULL, NAMING_ARNOLD, 3},
    {"light groups", "RGBA_key,RGBA_fill,RGBA_default", NULL, NAMING_ARNOLD, 3},
    {"direct and indirect light", "directDiffuse,indirectDiffuse,directSpecular,indirectSpecular",
     "emissive", NAMING_RENDERMAN, 4},
    {"elements", "VRayGlobalIllumination,VRayLighting,VRayReflection,VRayRefraction,VRaySpecular",
     "VRaySelfIllumination", NAMING_VRAY, 5},
    {"elements", "gi,lighting,reflection,refraction", "selfIllumination", NAMING_VRAY, 4},
    {"lights", "VRayLightSelect_key,VRayLightSelect_sun", NULL, NAMING_VRAY, 2},
    {"lobes", "directdiffuse,indirectdiffuse,directglossyreflection,sss", NULL, NAMING_KARMA, 4},
};
enum { SUM_COUNT = (int)(sizeof SUMS / sizeof *SUMS) };

static uint32_t seed;

static float random_value(void) {
    seed = seed * 1664525u + 1013904223u;
    return (float)(seed >> 8) * 0x1p-24f;
}

static float *add(struct fewray_frame *frame, const char *layer, int length, int c) {
    char name[FEWRAY_NAME_MAX];
    snprintf(name, sizeof name, "%.*s.%c", length, layer, "RGB"[c]);
    float *data = fewray_frame_plane(frame, name);
    if (data)
        return data;
    data = fewray_frame_add(frame, name);
    assert_non_null(data);
    for (int i = 0; i < COUNT; i++)
        data[i] = random_value();
    return data;
}

/* A picture that is the sum of its passes. Colours are black in parts of the picture. */
static struct fewray_frame *make_picture(int k) {
    struct fewray_frame *frame = NULL;
    float *color[3], *albedo[3];
    assert_int_equal(fewray_frame_create(SIDE, SIDE, &frame, NULL), 0);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, color));
    assert_true(fewray_frame_add_layer(frame, FEWRAY_ALBEDO, albedo));
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < COUNT; i++)
            albedo[c][i] = 0.5f;
        for (const char *pass = SUMS[k].passes; *pass;) {
            const int whole = (int)strcspn(pass, ","), length = (int)strcspn(pass, "*,");
            const float *data = add(frame, pass, length, c);
            float *factor =
                length < whole ? add(frame, pass + length + 1, whole - length - 1, c) : NULL;
            for (int i = 0; factor && i < COUNT; i++)
                if ((i % SIDE < SIDE / 4) == !strstr(pass, "Diff"))
                    factor[i] = 0;
            for (int i = 0; i < COUNT; i++)
                color[c][i] += data[i] * (factor ? factor[i] : 1);
            pass += whole + (pass[whole] == ',');
        }
        const float *emission = SUMS[k].emission
                                    ? add(frame, SUMS[k].emission, (int)strlen(SUMS[k].emission), c)
                                    : NULL;
        for (int i = 0; emission && i < COUNT; i++)
            color[c][i] += emission[i];
    }
    return frame;
}

static const struct pass_sum *find_sum(const struct pass_sums *sums, int k) {
    for (int s = 0; s < sums->count; s++)
        if (sums->sums[s].holds && sums->sums[s].count == SUMS[k].count)
            return &sums->sums[s];
    return NULL;
}

static void test_sums_are_found(void **state) {
    (void)state;
    struct pass_sums *sums = malloc(sizeof *sums);
    for (int k = 0; k < SUM_COUNT; k++) {
        struct adoption adoption;
        struct fewray_frame *frame = make_picture(k);
        adopt_layers(frame, NAMING_AUTO, true, &adoption);
        pass_sums_find(frame, &adoption, NAMING_AUTO, true, sums);
        const struct pass_sum *sum = find_sum(sums, k);
        if (!sum)
            fail_msg("%s isn't found", SUMS[k].passes);
        assert_string_equal(sum->what, SUMS[k].what);
        assert_int_equal(sum->emission, SUMS[k].emission != NULL);
        assert_true(sum->error < 1e-5);
        pass_sums_find(frame, &adoption, SUMS[k].naming, true, sums);
        assert_non_null(find_sum(sums, k));
        fewray_frame_destroy(&frame);
    }
    free(sums);
}

static void test_a_picture_that_is_more_than_the_sum_is_told(void **state) {
    (void)state;
    struct pass_sums *sums = malloc(sizeof *sums);
    for (int k = 0; k < SUM_COUNT; k++) {
        struct adoption adoption;
        struct fewray_frame *frame = make_picture(k);
        float *color[3];
        assert_true(fewray_frame_layer(frame, FEWRAY_COLOR, color));
        for (int c = 0; c < 3; c++)
            for (int i = 0; i < COUNT; i++)
                color[c][i] *= 1.02f;
        adopt_layers(frame, NAMING_AUTO, true, &adoption);
        pass_sums_find(frame, &adoption, NAMING_AUTO, true, sums);
        assert_true(sums->count > 0);
        for (int s = 0; s < sums->count; s++)
            assert_false(sums->sums[s].holds);
        assert_near(sums->sums[0].error, 0.02 / 1.02, 1e-4);
        fewray_frame_destroy(&frame);
    }
    free(sums);
}

/* Filters the picture and its passes, and adds those up again. */
static void check_filtered(int k, struct fewray_denoiser *denoiser) {
    struct pass_sums *sums = malloc(sizeof *sums);
    struct adoption adoption;
    struct fewray_frame *frame = make_picture(k);
    char names[PASSES_MAX][80];
    const char *list[PASSES_MAX];
    float *color[3], *emission[3] = {NULL, NULL, NULL};
    int count = 0, changed = 0;
    adopt_layers(frame, NAMING_AUTO, true, &adoption);
    pass_sums_find(frame, &adoption, SUMS[k].naming, true, sums);
    assert_int_equal(pass_sums_start(frame, sums, names, &count, NULL), 0);
    assert_int_equal(count, SUMS[k].count);
    for (int i = 0; i < count; i++)
        list[i] = names[i];
    assert_int_equal(fewray_denoise_frame_layers(denoiser, frame, list, count, NULL, NULL), 0);
    pass_sums_finish(frame, sums);
    const struct pass_sum *sum = find_sum(sums, k);
    assert_true(fewray_frame_layer(frame, FEWRAY_COLOR, color));
    if (sum->emission)
        assert_true(fewray_frame_layer(frame, FEWRAY_EMISSION, emission));
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < COUNT; i++) {
            double value = sum->emission ? emission[c][i] : 0;
            bool shown = false; /* a pass has a colour */
            for (int p = 0; p < count; p++) {
                const struct light_pass *pass = &sum->passes[p];
                shown |= !pass->color[c] || pass->color[c][i] > 0.01f;
                const float *filtered = pass_sums_plane(frame, (int)(pass - sums->passes), c);
                value += filtered[i] * (pass->color[c] ? pass->color[c][i] : 1.0f);
                changed += filtered[i] != pass->data[c][i];
            }
            if (shown)
                assert_near(value, color[c][i], 1e-4 * (1 + color[c][i]));
        }
    assert_true(changed > COUNT);
    fewray_frame_destroy(&frame);
    free(sums);
}

static void test_filtered_passes_still_sum_up(void **state) {
    (void)state;
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    fewray_denoise_options_init(&options);
    options.threads = 1;
    assert_int_equal(fewray_denoiser_create(&options, &denoiser, NULL), 0);
    for (int k = 0; k < SUM_COUNT; k++)
        check_filtered(k, denoiser);
    fewray_denoiser_destroy(&denoiser);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sums_are_found),
        cmocka_unit_test(test_a_picture_that_is_more_than_the_sum_is_told),
        cmocka_unit_test(test_filtered_passes_still_sum_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
