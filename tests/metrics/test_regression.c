/* SPDX-License-Identifier: Apache-2.0 */
/* Metric regressions: renders the scene of a folder plain, guided, denoised and both, and fails
 * where an error against the stored reference has grown beyond the tolerance.
 *
 *     test_regression FOLDER               checks
 *     test_regression --update FOLDER      measures again and stores the errors as the expected
 * ones test_regression --reference FOLDER   renders reference.exr again (minutes); --update it
 * afterwards
 *
 * A new case is a folder with an expected.json that has everything but "expected"; then --reference
 * and --update. */

#include <stdio.h>
#include <string.h>

#include "fewray/pipeline.h"
#include "regression_case.h"

enum { REFERENCE_SEED = 1000000 };

static bool complain(const struct fewray_error *error) {
    char text[1200];
    fprintf(stderr, "%s\n", fewray_error_text(error, text, sizeof text));
    return false;
}

static struct fewray_job make_job(const struct regression_case *test, char *scene_path,
                                  size_t size) {
    snprintf(scene_path, size, "%s/%s", EXAMPLES, test->scene);
    struct fewray_job job;
    fewray_job_init(&job);
    job.scene_path = scene_path;
    job.settings.width = test->width;
    job.settings.height = test->height;
    job.settings.spp = test->spp;
    job.pilot = false; /* the guide is to be measured, at a size where it would be left out */
    return job;
}

static bool render_reference(const struct regression_case *test, const char *path) {
    char scene[1024];
    struct fewray_job job = make_job(test, scene, sizeof scene);
    job.guided = job.denoised = false; /* the reference must not share a fault of the guide */
    job.settings.spp = test->reference_spp;
    job.settings.seed = REFERENCE_SEED;
    struct fewray_frame *picture = NULL, *reference = NULL;
    struct fewray_error error;
    float *from[3], *to[3];
    bool done = !fewray_job_run(&job, &picture, NULL, &error) &&
                !fewray_frame_create(test->width, test->height, &reference, &error);
    if (done && fewray_frame_layer(picture, FEWRAY_COLOR, from) &&
        fewray_frame_add_layer(reference, FEWRAY_COLOR, to)) {
        for (int c = 0; c < 3; c++) /* the colour alone: a small file */
            memcpy(to[c], from[c], sizeof(float) * (size_t)test->width * (size_t)test->height);
        done = !fewray_frame_write_exr(reference, path, false, &error);
    }
    fewray_frame_destroy(&picture);
    fewray_frame_destroy(&reference);
    return done || complain(&error);
}

/* Errors of one mode, means over the seeds. */
static bool measure(const struct regression_case *test, const struct regression_mode *mode,
                    const struct fewray_frame *reference, double errors[METRIC_COUNT]) {
    char scene[1024];
    struct fewray_job job = make_job(test, scene, sizeof scene);
    job.guided = mode->guided;
    job.denoised = mode->denoised;
    errors[0] = errors[1] = 0;
    for (int seed = 1; seed <= test->seeds; seed++) {
        struct fewray_frame *picture = NULL;
        struct fewray_metrics metrics;
        struct fewray_error error;
        job.settings.seed = (uint64_t)seed;
        const bool done = !fewray_job_run(&job, &picture, NULL, &error) &&
                          !fewray_compare(picture, reference, &metrics, &error);
        fewray_frame_destroy(&picture);
        if (!done)
            return complain(&error);
        errors[0] += metrics.mrse / test->seeds;
        errors[1] += metrics.mrse_trimmed / test->seeds;
    }
    return true;
}

static const char *verdict_of(double error, double expected, double tolerance) {
    if (expected == 0)
        return "FAIL: nothing expected yet; --update stores it";
    if (!(error <= expected * (1 + tolerance)))
        return "FAIL: grown";
    return error < expected / (1 + tolerance) ? "ok: less; --update keeps it so" : "ok";
}

/* Prints a line for each error; false where one has grown too much. */
static bool judge(const struct regression_case *test, int mode, const double errors[METRIC_COUNT]) {
    bool good = true;
    for (int k = 0; k < METRIC_COUNT; k++) {
        const double expected = test->expected[mode][k];
        const char *verdict = verdict_of(errors[k], expected, test->tolerance);
        printf("%-16s %-13s %10.5g, expected %10.5g + %.0f %%  %s\n", REGRESSION_MODES[mode].name,
               REGRESSION_METRICS[k], errors[k], expected, 100 * test->tolerance, verdict);
        good = good && verdict[0] == 'o';
    }
    return good;
}

static bool check(struct regression_case *test, const char *reference_path, bool update) {
    struct fewray_frame *reference = NULL;
    struct fewray_error error;
    if (fewray_frame_read_exr(reference_path, &reference, &error))
        return complain(&error);
    bool good = true;
    for (int mode = 0; mode < MODE_COUNT; mode++) {
        double errors[METRIC_COUNT];
        if (!measure(test, &REGRESSION_MODES[mode], reference, errors)) {
            good = false;
            break;
        }
        if (update)
            memcpy(test->expected[mode], errors, sizeof errors);
        good = judge(test, mode, errors) && good;
    }
    fewray_frame_destroy(&reference);
    return good;
}

int main(int argc, char **argv) {
    const bool update = argc == 3 && !strcmp(argv[1], "--update");
    const bool make_reference = argc == 3 && !strcmp(argv[1], "--reference");
    if (argc != 2 && !update && !make_reference) {
        fprintf(stderr, "usage: test_regression [--update | --reference] FOLDER\n");
        return 2;
    }
    char json_path[1024], reference_path[1024];
    snprintf(json_path, sizeof json_path, "%s/expected.json", argv[argc - 1]);
    snprintf(reference_path, sizeof reference_path, "%s/reference.exr", argv[argc - 1]);
    struct regression_case test;
    if (!regression_case_read(json_path, &test))
        return 1;
    if (make_reference)
        return render_reference(&test, reference_path) ? 0 : 1;
    const bool good = check(&test, reference_path, update);
    return good && (!update || regression_case_write(json_path, &test)) ? 0 : 1;
}
