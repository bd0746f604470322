/* SPDX-License-Identifier: Apache-2.0 */
/* Files that Cycles and Mitsuba wrote (tests/data/foreign/README.md): the layers are found, what
 * `fewray denoise` writes is otherwise the file, and passes still add up to the picture. */

#include "tests/unit/check.h"

#include <stdio.h>
#include <string.h>

#include "foreign_file.h"
#include "pipeline/denoise_job.h"
#include "pipeline/pass_sums.h"
#include "tests/unit/scratch_folder.h"

static const struct {
    const char *name;
    const char *layers[FEWRAY_LAYER_COUNT]; /* first channel that each is taken from */
    const char *result;
    int sums;                     /* that hold */
    const char *changed, *passes; /* channels, without and with --aov auto */
} FILES[] = {
    {"cycles-plain",
     {[FEWRAY_COLOR] = "ViewLayer.Combined.R",
      [FEWRAY_ALBEDO] = "ViewLayer.Denoising Albedo.R",
      [FEWRAY_NORMAL] = "ViewLayer.Denoising Normal.X",
      [FEWRAY_DEPTH] = "ViewLayer.Denoising Depth.Z",
      [FEWRAY_EMISSION] = "ViewLayer.Emission.R"},
     "ViewLayer.Combined.R",
     1,
     "Combined",
     "Combined,Diffuse Direct,Diffuse Indirect,Glossy Direct,Glossy Indirect,Transmission "
     "Direct,Transmission Indirect"},
    {"cycles-denoised",
     {[FEWRAY_COLOR] = "ViewLayer.Noisy Image.R",
      [FEWRAY_ALBEDO] = "ViewLayer.Denoising Albedo.R",
      [FEWRAY_NORMAL] = "ViewLayer.Denoising Normal.X",
      [FEWRAY_DEPTH] = "ViewLayer.Denoising Depth.Z",
      [FEWRAY_EMISSION] = "ViewLayer.Emission.R"},
     "ViewLayer.Combined.R",
     1,
     "Combined",
     "Combined,Diffuse Direct,Diffuse Indirect,Glossy Direct,Glossy Indirect,Transmission "
     "Direct,Transmission Indirect"},
    {"cycles-groups",
     {[FEWRAY_COLOR] = "ViewLayer.Combined.R",
      [FEWRAY_ALBEDO] = "ViewLayer.Denoising Albedo.R",
      [FEWRAY_NORMAL] = "ViewLayer.Denoising Normal.X",
      [FEWRAY_DEPTH] = "ViewLayer.Denoising Depth.Z",
      [FEWRAY_EMISSION] = "ViewLayer.Emission.R"},
     "ViewLayer.Combined.R",
     2,
     "Combined",
     "Combined,Diffuse Direct,Diffuse Indirect,Glossy Direct,Glossy Indirect,Transmission "
     "Direct,Transmission Indirect,Combined_lamp,Combined_sky"},
    {"mitsuba-aovs",
     {[FEWRAY_COLOR] = "R",
      [FEWRAY_ALBEDO] = "albedo.R",
      [FEWRAY_NORMAL] = "nn.X",
      [FEWRAY_DEPTH] = "dd.y.T"},
     "R",
     0,
     "",
     ""},
    {"mitsuba-moments",
     {[FEWRAY_COLOR] = "R",
      [FEWRAY_ALBEDO] = "nested.albedo.R",
      [FEWRAY_NORMAL] = "nested.nn.X",
      [FEWRAY_DEPTH] = "nested.dd.y.T"},
     "R",
     0,
     "",
     ""},
};
enum { FILE_COUNT = (int)(sizeof FILES / sizeof *FILES) };

static void path_of(int k, char path[300]) {
    snprintf(path, 300, TEST_DATA "/foreign/%s.exr", FILES[k].name);
}

static void denoise(const char *input, const char *output, const char *aov) {
    struct name_list aovs = {.count = 0};
    struct denoise_job job = {.input = input, .outputs = {.exr = output}, .aovs = &aovs};
    struct fewray_denoiser *denoiser = NULL;
    struct run_progress progress = {0};
    struct fewray_run_stats stats = {.threads = 1};
    struct fewray_error error;
    fewray_denoise_options_init(&job.denoise);
    job.denoise.threads = 1;
    if (aov)
        snprintf(aovs.names[aovs.count++], sizeof *aovs.names, "%s", aov);
    run_progress_start_denoise(&progress);
    if (denoise_job_run(&job, &denoiser, &progress, &stats, &error))
        fail_msg("%s: %s", input, error.what);
    fewray_denoiser_destroy(&denoiser);
}

static void test_layers_are_found(void **state) {
    (void)state;
    for (int k = 0; k < FILE_COUNT; k++) {
        struct adoption adoption;
        struct fewray_frame *frame = NULL;
        char path[300];
        path_of(k, path);
        assert_int_equal(read_noisy_picture(path, NAMING_AUTO, &adoption, &frame, NULL), 0);
        for (int layer = 0; layer < FEWRAY_LAYER_COUNT; layer++) {
            const char *wanted = FILES[k].layers[layer];
            if (adoption.layers[layer].found != (wanted != NULL))
                fail_msg("%s: layer %d", FILES[k].name, layer);
            if (wanted)
                assert_string_equal(adoption.layers[layer].names[0], wanted);
        }
        assert_string_equal(adoption.result[0], FILES[k].result);
        fewray_frame_destroy(&frame);
    }
}

/* "Combined,Diffuse Direct" as channels. */
static void channels_of(const char *layers, char *text, size_t size) {
    size_t used = (size_t)snprintf(text, size, "R,G,B,A");
    while (*layers) {
        const int length = (int)strcspn(layers, ",");
        for (int c = 0; c < 3; c++)
            used += (size_t)snprintf(text + used, size - used, ",ViewLayer.%.*s.%c", length, layers,
                                     "RGB"[c]);
        layers += length + (layers[length] == ',');
    }
}

static void test_all_else_is_kept(void **state) {
    (void)state;
    for (int k = 0; k < FILE_COUNT; k++)
        for (int automatic = 0; automatic < 2; automatic++) {
            char path[300], out[64], changed[2000], why[256];
            path_of(k, path);
            snprintf(out, sizeof out, "%s/out.exr", folder);
            denoise(path, out, automatic ? "auto" : NULL);
            channels_of(automatic ? FILES[k].passes : FILES[k].changed, changed, sizeof changed);
            if (!foreign_is_kept(path, out, changed, why, sizeof why))
                fail_msg("%s: %s", FILES[k].name, why);
        }
}

static void check_sums(const char *path, int wanted, double bound) {
    struct adoption adoption;
    struct fewray_frame *frame = NULL;
    struct pass_sums *sums = malloc(sizeof *sums);
    int holding = 0;
    assert_non_null(sums);
    assert_int_equal(fewray_frame_read_exr(path, &frame, NULL), 0);
    adopt_layers(frame, NAMING_AUTO, false, &adoption);
    pass_sums_find(frame, &adoption, NAMING_AUTO, false, sums);
    for (int s = 0; s < sums->count; s++)
        holding += sums->sums[s].error < bound;
    if (holding != wanted)
        fail_msg("%s: %d sums hold, not %d", path, holding, wanted);
    fewray_frame_destroy(&frame);
    free(sums);
}

static void test_sums_hold_before_and_behind_the_denoiser(void **state) {
    (void)state;
    for (int k = 0; k < FILE_COUNT; k++) {
        char path[300], out[64];
        path_of(k, path);
        snprintf(out, sizeof out, "%s/sum.exr", folder);
        if (strcmp(FILES[k].name, "cycles-denoised")) /* its passes are noisy, its picture isn't */
            check_sums(path, FILES[k].sums, 0.001);
        denoise(path, out, "auto");
        check_sums(out, FILES[k].sums, 0.001);
        if (FILES[k].sums) {
            denoise(path, out, NULL);
            check_sums(out, 0, 0.02);
        }
    }
}

static void test_denoising_again_starts_from_the_noisy_picture(void **state) {
    (void)state;
    for (int k = 0; k < FILE_COUNT; k++) {
        char path[300], once[64], twice[64], why[256];
        path_of(k, path);
        snprintf(once, sizeof once, "%s/once.exr", folder);
        snprintf(twice, sizeof twice, "%s/twice.exr", folder);
        denoise(path, once, "auto");
        denoise(once, twice, "auto");
        if (!foreign_is_kept(once, twice, "", why, sizeof why))
            fail_msg("%s: %s", FILES[k].name, why);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_layers_are_found),
        cmocka_unit_test(test_all_else_is_kept),
        cmocka_unit_test(test_sums_hold_before_and_behind_the_denoiser),
        cmocka_unit_test(test_denoising_again_starts_from_the_noisy_picture),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
