/* SPDX-License-Identifier: Apache-2.0 */
/* Jobs of numbers that make no picture are refused before anything is loaded. */

#include "tests/unit/check.h"

#include <string.h>

#include "fewray/pipeline.h"

static void spp(struct fewray_job *job, double v) {
    job->settings.spp = (int)v;
}
static void initial(struct fewray_job *job, double v) {
    job->settings.initial = (int)v;
}
static void width(struct fewray_job *job, double v) {
    job->settings.width = (int)v;
}
static void height(struct fewray_job *job, double v) {
    job->settings.height = (int)v;
}
static void threads(struct fewray_job *job, double v) {
    job->settings.threads = (int)v;
}
static void max_depth(struct fewray_job *job, double v) {
    job->settings.max_depth = (int)v;
}
static void max_spp(struct fewray_job *job, double v) {
    job->goal.max_spp = (int)v;
}
static void seconds(struct fewray_job *job, double v) {
    job->goal.seconds = v;
}
static void goal_error(struct fewray_job *job, double v) {
    job->goal.error = v;
}

static void test_numbers_that_make_no_picture_are_refused(void **state) {
    (void)state;
    static const struct {
        void (*set)(struct fewray_job *job, double value);
        double value;
        const char *says;
    } cases[] = {
        {spp, 0, "spp can't be 0; it is 1 or more"},
        {spp, -1, "spp can't be -1"},
        {initial, 0, "initial can't be 0"},
        {width, -4, "width can't be -4; it is 0 or more"},
        {height, -4, "height can't be -4"},
        {threads, -1, "threads can't be -1"},
        {max_depth, -2, "max_depth can't be -2; it is -1 or more"},
        {max_spp, -1, "max_spp can't be -1"},
        {seconds, -1, "seconds can't be -1"},
        {seconds, NAN, "seconds can't be nan"},
        {goal_error, -0.5, "error can't be -0.5"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct fewray_job job;
        struct fewray_error error = {.line = 0};
        struct fewray_frame *picture = NULL;
        fewray_job_init(&job);
        job.scene_path = "there is no such scene.xml"; /* which would be told if it were loaded */
        cases[i].set(&job, cases[i].value);
        assert_int_equal(fewray_job_run(&job, &picture, NULL, &error), FEWRAY_ERROR_ARGUMENT);
        assert_null(picture);
        if (!strstr(error.what, cases[i].says))
            fail_msg("'%s' doesn't say '%s'", error.what, cases[i].says);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_numbers_that_make_no_picture_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
