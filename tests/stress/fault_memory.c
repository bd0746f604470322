/* SPDX-License-Identifier: Apache-2.0 */
/* The n-th allocation of our own code fails: once, or with all after it. Bound of every case: the
 * work succeeds (the block wasn't needed) or fails with a line that says memory; no block and no
 * file is left, outputs are whole or not there. n takes some 40 values over the run; all of them
 * where the environment has FEWRAY_TEST_ALL. */

#include "tests/stress/fault_wrap.h"

#include <dirent.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "tests/unit/scratch_folder.h"

#include "fewray/features.h"
#include "fewray/pipeline.h"
#include "pipeline/page/page.h"

#define SCENE EXAMPLES "/cornell-box.xml"

static char in_exr[64], out_exr[64], out_png[64], out_html[64], out_stats[64], parts[2][64],
    frames[64];

static struct fewray_job small_job(void) {
    struct fewray_job job;
    fewray_job_init(&job);
    job.scene_path = SCENE;
    job.settings.width = 16;
    job.settings.spp = 2;
    job.settings.threads = 1;
    job.pilot = false;
    return job;
}

static int render(struct fewray_error *error) {
    struct fewray_job job = small_job();
    job.outputs = (struct fewray_outputs){.exr = out_exr, .png = out_png, .stats = out_stats};
    struct fewray_frame *picture;
    const int status = fewray_job_run(&job, &picture, NULL, error);
    fewray_frame_destroy(&picture);
    return status;
}

/* To a goal, by a pilot and with layers. */
static int render_to_error(struct fewray_error *error) {
    struct fewray_job job = small_job();
    job.pilot = true;
    job.denoised = false;
    job.goal.error = 10;
    job.goal.max_spp = 2;
    job.goal.adaptive = true;
    job.settings.direct = job.settings.indirect = true;
    job.outputs.exr = out_exr;
    return fewray_job_run(&job, NULL, NULL, error);
}

static int render_by_path_guiding(struct fewray_error *error) {
    struct fewray_job job = small_job();
    job.ppg = true;
    job.denoised = false;
    job.outputs.exr = out_exr;
    return fewray_job_run(&job, NULL, NULL, error);
}

static int render_frames(struct fewray_error *error) {
    struct fewray_job job = small_job();
    struct fewray_sequence sequence;
    fewray_sequence_init(&sequence);
    job.guided = false;
    sequence.frames = (struct fewray_frames){1, 2, 1};
    job.outputs.exr = frames;
    return fewray_sequence_run(&job, &sequence, error);
}

static int merge(struct fewray_error *error) {
    const char *const paths[2] = {parts[0], parts[1]};
    struct fewray_merge_job job;
    fewray_merge_job_init(&job);
    job.paths = paths;
    job.count = 2;
    job.threads = 1;
    job.outputs.exr = out_exr;
    return fewray_merge_run(&job, NULL, NULL, error);
}

static int denoise(struct fewray_error *error) {
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_frame *frame = NULL;
    fewray_denoise_options_init(&options);
    options.threads = 1;
    int status = fewray_frame_read_exr(in_exr, &frame, error);
    if (!status)
        fewray_frame_repair(frame);
    if (!status)
        status = fewray_denoiser_create(&options, &denoiser, error);
    if (!status)
        status = fewray_denoise_frame(denoiser, frame, NULL, error);
    if (!status)
        status = fewray_frame_write_exr(frame, out_exr, false, error);
    fewray_denoiser_destroy(&denoiser);
    fewray_frame_destroy(&frame);
    return status;
}

static int compare(struct fewray_error *error) {
    struct fewray_frame *test = NULL, *reference = NULL;
    struct fewray_metrics metrics;
    int status = fewray_frame_read_exr(in_exr, &test, error);
    if (!status)
        status = fewray_frame_read_exr(in_exr, &reference, error);
    if (!status)
        status = fewray_compare(test, reference, &metrics, error);
    if (!status)
        status = fewray_composite(test, test, reference, NULL, out_png, error);
    fewray_frame_destroy(&test);
    fewray_frame_destroy(&reference);
    return status;
}

static int report(struct fewray_error *error) {
    const struct page_options options = {
        .folder = folder, .output = out_html, .reference = in_exr, .max_width = 1920};
    return page_write(&options, error);
}

/* As `fewray info` does. */
static int load(struct fewray_error *error) {
    static const struct fewray_scene_options options = {.threads = 1};
    struct fewray_scene *scene = NULL;
    const int status =
        fewray_scene_load(EXAMPLES "/glossy-still-life.xml", &options, &scene, error);
    fewray_scene_destroy(&scene);
    return status;
}

static int load_gltf(struct fewray_error *error) {
    static const struct fewray_scene_options options = {.threads = 1};
    struct fewray_scene *scene = NULL;
    const int status = fewray_scene_load(EXAMPLES "/lamp.gltf", &options, &scene, error);
    fewray_scene_destroy(&scene);
    return status;
}

static int prepare(void **state) {
    if (make_folder(state))
        return -1;
    snprintf(in_exr, sizeof in_exr, "%s/in.exr", folder);
    snprintf(out_exr, sizeof out_exr, "%s/out.exr", folder);
    snprintf(out_png, sizeof out_png, "%s/out.png", folder);
    snprintf(out_html, sizeof out_html, "%s/out.html", folder);
    snprintf(out_stats, sizeof out_stats, "%s/out.json", folder);
    snprintf(frames, sizeof frames, "%s/out.##.exr", folder);
    struct fewray_job job = small_job();
    job.denoised = job.guided = false;
    job.outputs.exr = in_exr;
    int status = fewray_job_run(&job, NULL, NULL, NULL);
    for (int i = 0; i < 2 && !status; i++) {
        snprintf(parts[i], sizeof parts[i], "%s/part-%d.exr", folder, i);
        job.outputs.exr = parts[i];
        job.part = i + 1;
        job.parts = 2;
        status = fewray_job_run(&job, NULL, NULL, NULL);
    }
    return status;
}

/* Removes outputs; they must be readable, and there only where the work is done, all but for the
 * denoiser maybe. */
static void check_outputs(const char *what, bool done) {
    DIR *entries = opendir(folder);
    assert_non_null(entries);
    for (struct dirent *entry; (entry = readdir(entries));) {
        char path[512];
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (!strncmp(entry->d_name, ".fewray", 7))
            fail_msg("%s: leaves %s", what, entry->d_name);
        if (strncmp(entry->d_name, "out.", 4))
            continue;
        struct fewray_frame *frame = NULL;
        if (strstr(entry->d_name, ".exr") && fewray_frame_read_exr(path, &frame, NULL))
            fail_msg("%s: %s is damaged", what, entry->d_name);
        fewray_frame_destroy(&frame);
        /* One frame of two may be done; else outputs come together. */
        if (!done && !strstr(entry->d_name, "out.01"))
            fail_msg("%s: %s is there", what, entry->d_name);
        unlink(path);
    }
    closedir(entries);
}

static const struct work {
    const char *name;
    int (*run)(struct fewray_error *error);
    int points; /* where an allocation fails, without FEWRAY_TEST_ALL */
} WORKS[] = {
    {"render", render, 16},
    {"render --error", render_to_error, 8},
    {"render --guide ppg", render_by_path_guiding, 8},
    {"render --frames", render_frames, 8},
    {"merge", merge, 12},
    {"denoise", denoise, 16},
    {"compare, composite", compare, 8},
    {"report", report, 12},
    {"info", load, 12},
    {"info of glTF", load_gltf, 12},
};

static void fail_at(const struct work *work, long n, int later) {
    char what[128];
    struct fewray_error error = {0};
    const long before = wrap_live();
    snprintf(what, sizeof what, "%s, allocation %ld%s", work->name, n,
             later ? " and all later" : "");
    wrap_fail(n, later);
    const int status = work->run(&error);
    wrap_fail(0, 0);
    if (getenv("FEWRAY_TEST_VERBOSE"))
        fprintf(stderr, "%s: %d %s: %s\n", what, status, error.file, error.what);
    if (wrap_live() != before)
        fail_msg("%s: leaks %ld blocks (%s)", what, wrap_live() - before, error.what);
    if (status && !strstr(error.what, "memory"))
        fail_msg("%s: status %d doesn't say memory: %s", what, status, error.what);
    check_outputs(what, !status || strstr(error.what, "undenoised"));
}

static void test_failing_allocation_ends_the_work_with_a_line(void **state) {
    (void)state;
    const bool all = getenv("FEWRAY_TEST_ALL") != NULL;
    for (size_t k = 0; k < sizeof WORKS / sizeof *WORKS; k++) {
        const struct work *work = &WORKS[k];
        struct fewray_error error = {0};
        if (getenv("FEWRAY_TEST_ONLY") && strcmp(getenv("FEWRAY_TEST_ONLY"), work->name))
            continue;
        const long before = wrap_live();
        wrap_fail(0, 0);
        if (work->run(&error))
            fail_msg("%s: %s", work->name, error.what);
        const long count = wrap_count();
        check_outputs(work->name, true);
        assert_int_equal(wrap_live(), before);
        assert_true(count > 0);
        const long points = all || count < work->points ? count : work->points;
        for (long i = 0; i < points; i++) {
            const long n = points > 1 ? 1 + i * (count - 1) / (points - 1) : 1;
            fail_at(work, n, all ? 0 : i % 2);
            if (all)
                fail_at(work, n, 1);
        }
        if (all)
            print_message("%s: %ld allocations\n", work->name, count);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_failing_allocation_ends_the_work_with_a_line),
    };
    return cmocka_run_group_tests(tests, prepare, remove_folder);
}
