/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures that half floats can't hold: the user is told, and 32-bit floats keep them. */

#include "scene_stage.h"

#include "fewray/pipeline.h"

/* The camera looks into a sky of this radiance. */
#define SKY                                                                                        \
    "<scene version='3.0.0'><sensor type='perspective'><film type='hdrfilm'>"                      \
    "<integer name='width' value='16'/><integer name='height' value='12'/></film></sensor>"        \
    "<emitter type='constant'><rgb name='radiance' value='%g'/></emitter></scene>"

static char warned[512];

static void note_warning(void *user, const char *text) {
    (void)user;
    snprintf(warned, sizeof(warned), "%s", text);
}

static void test_what_half_floats_lose_is_said(void **state) {
    (void)state;
    static const struct {
        double radiance;
        bool float32;
        const char *warning;   /* NULL: none */
        double written, bound; /* relative */
        long long clipped;
    } cases[] = {
        {1, false, NULL, 1, 0, 0},
        {65504, false, NULL, 65504, 0, 0},
        {1e5, false, "192 pixels are brighter than 65504", 65504, 0, 192},
        {1e12, false, "192 pixels are brighter than 65504", 65504, 0, 192},
        {1e12, true, NULL, 1e12, 6e-8, 0},
        {7e-5, false, NULL, 7e-5, 4.9e-4, 0}, /* 2^-11: 11 bits of mantissa */
        {1e-5, false, NULL, 1e-5, 3e-3, 0},   /* half of 2^-24 of it */
        {1e-12, false, "192 pixels with light are below 3e-8", 0, 0, 0},
        {1e-12, true, NULL, 1e-12, 6e-8, 0},
    };
    for (int i = 0; i < COUNT(cases); i++) {
        char text[512], scene[256], exr[256];
        struct fewray_job job;
        struct fewray_run_stats stats;
        struct fewray_error error;
        struct fewray_frame *frame = NULL;
        snprintf(text, sizeof(text), SKY, cases[i].radiance);
        snprintf(scene, sizeof(scene), "%s", scratch_text("sky.xml", text));
        snprintf(exr, sizeof(exr), "%s", scratch_path("sky.exr"));
        fewray_job_init(&job);
        job.scene_path = scene;
        job.settings.threads = 1;
        job.settings.spp = 1;
        job.guided = job.denoised = false;
        job.outputs.exr = exr;
        job.outputs.float32 = cases[i].float32;
        job.warn = note_warning;
        warned[0] = '\0';
        if (fewray_job_run(&job, NULL, &stats, &error) ||
            fewray_frame_read_exr(exr, &frame, &error))
            fail_msg("%s", error.what);
        const float *r = fewray_frame_plane(frame, "R");
        for (int k = 0; k < 16 * 12; k++)
            if (!(fabs((double)r[k] - cases[i].written) <= cases[i].bound * cases[i].written))
                fail_msg("%g was written as %g", cases[i].radiance, (double)r[k]);
        if (cases[i].warning ? !strstr(warned, cases[i].warning) : warned[0])
            fail_msg("at %g the user hears \"%s\"", cases[i].radiance, warned);
        assert_int_equal(stats.clipped, cases[i].clipped);
        fewray_frame_destroy(&frame);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_half_floats_lose_is_said),
    };
    omp_set_num_threads(1);
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
