/* SPDX-License-Identifier: Apache-2.0 */
/* Previews: never half a file, never another picture in the end, never more than their share of the
 * time. */

#include "tests/unit/scene_scratch.h"

#include <omp.h>

#include "features/cancel.h"
#include "fewray/pipeline.h"
#include "pipeline/coarse.h"
#include "pipeline/preview.h"

#define SCENE EXAMPLES "/cornell-box.xml"

static struct fewray_job small_job(const char *exr, const char *preview) {
    struct fewray_job job;
    fewray_job_init(&job);
    job.scene_path = SCENE;
    job.settings.width = 64;
    job.settings.height = 48;
    job.settings.spp = 6;
    job.settings.threads = 2;
    job.pilot = false;
    job.outputs.exr = exr;
    job.outputs.float32 = true;
    job.outputs.preview = preview;
    job.preview_interval = 0;
    return job;
}

/* What a viewer sees that reloads the file whenever a phase tells its progress. */
struct viewer {
    const char *path;
    int whole, broken; /* reads */
    int dark;          /* bytes of the first one's last quarter that are 0 */
};

static void view(void *user, const char *phase, double part) {
    (void)phase, (void)part;
    struct viewer *viewer = user;
    struct fewray_image *image = NULL;
    if (access(viewer->path, F_OK))
        return;
    const bool readable = !fewray_image_read(viewer->path, &image, NULL);
    if (readable && !viewer->whole && !viewer->broken)
        for (int i = image->width * image->height * 9 / 4; i < image->width * image->height * 3;
             i++)
            viewer->dark += !image->bytes[i];
    if (!readable)
        viewer->broken++;
    else
        viewer->whole += image->width == 64 && image->height == 48 && image->channels == 3;
    fewray_image_destroy(&image);
}

static void test_a_viewer_never_sees_half_a_file(void **state) {
    (void)state;
    struct fewray_job job = small_job(scratch_path("a.exr"), scratch_path("a.png"));
    struct viewer viewer = {.path = job.outputs.preview};
    job.settings.progress = view;
    job.settings.progress_user = &viewer;
    struct fewray_run_stats stats;
    assert_int_equal(fewray_job_run(&job, NULL, &stats, NULL), FEWRAY_OK);
    assert_true(stats.previews >= 1 && stats.preview_s > 0);
    assert_true(viewer.whole > 0);
    assert_int_equal(viewer.broken, 0);
    /* Seen after the first tiles: the rest of the room is there, if coarse. */
    assert_true(viewer.dark < 64 * 48 / 4 * 3 / 10);
}

static void test_the_picture_is_the_same_with_and_without_preview(void **state) {
    (void)state;
    for (int guide = 0; guide < 3; guide++) {
        struct fewray_job job = small_job(scratch_path("with.exr"), scratch_path("with.png"));
        job.guided = guide > 0;
        job.denoised = guide == 1;
        job.ppg = guide == 2;
        struct fewray_run_stats stats;
        assert_int_equal(fewray_job_run(&job, NULL, &stats, NULL), FEWRAY_OK);
        assert_true(stats.previews >= 1);
        job.outputs.exr = scratch_path("without.exr");
        job.outputs.preview = NULL;
        job.outputs.png = scratch_path("without.png");
        job.settings.threads = 1;
        assert_int_equal(fewray_job_run(&job, NULL, &stats, NULL), FEWRAY_OK);
        assert_int_equal(stats.previews, 0);
        assert_true(same_files(scratch_path("with.exr"), scratch_path("without.exr")));
        /* in the end the preview is the picture */
        assert_true(same_files(scratch_path("with.png"), scratch_path("without.png")));
    }
}

/* Pauses whenever it is asked. */
struct pauses {
    int count, whole, within; /* within: other threads */
};

static bool always(void *user) {
    (void)user;
    return true;
}

static void count_pause(void *user, bool whole_pass) {
    struct pauses *pauses = user;
    pauses->count++;
    pauses->whole += whole_pass;
    pauses->within += omp_in_parallel() != 0;
}

static void test_tracing_pauses_between_tiles_and_after_each_pass(void **state) {
    (void)state;
    struct fewray_job job = small_job(scratch_path("free.exr"), NULL);
    job.denoised = false;
    assert_int_equal(fewray_job_run(&job, NULL, NULL, NULL), FEWRAY_OK);
    struct pauses pauses = {0, 0, 0};
    job.outputs.exr = scratch_path("paused.exr");
    job.settings.pause_due = always;
    job.settings.paused = count_pause;
    job.settings.pause_user = &pauses;
    assert_int_equal(fewray_job_run(&job, NULL, NULL, NULL), FEWRAY_OK);
    assert_true(same_files(scratch_path("free.exr"), scratch_path("paused.exr")));
    /* passes up to 1 (the look), 4 and 6 samples and the edges; 12 tiles by two threads */
    assert_int_equal(pauses.whole, 4);
    assert_true(pauses.count >= 4 * 6);
    assert_int_equal(pauses.within, 0);
}

/* Cancels during the last samples. */
struct canceller {
    volatile int cancel;
};

static void cancel_late(void *user, const char *phase, double part) {
    struct canceller *canceller = user;
    if (!strcmp(phase, "render") && part > 0.5)
        cancel_set(&canceller->cancel);
}

static void test_a_cancelled_run_leaves_what_is_done_in_the_preview(void **state) {
    (void)state;
    struct canceller canceller = {0};
    struct fewray_job job = small_job(scratch_path("cut.exr"), scratch_path("cut.png"));
    job.outputs.png = scratch_path("cut-too.png");
    job.denoised = false;
    job.settings.progress = cancel_late;
    job.settings.progress_user = &canceller;
    job.settings.cancel = &canceller.cancel;
    assert_int_equal(fewray_job_run(&job, NULL, NULL, NULL), FEWRAY_ERROR_CANCELLED);
    struct fewray_frame *frame = NULL;
    assert_int_equal(fewray_frame_read_exr(job.outputs.exr, &frame, NULL), FEWRAY_OK);
    fewray_frame_destroy(&frame);
    assert_true(same_files(job.outputs.png, job.outputs.preview));
}

struct listener {
    double last;
    int calls, falls, unsure;
};

static void listen(void *user, const struct fewray_progress *progress) {
    struct listener *listener = user;
    listener->calls++;
    listener->falls += progress->fraction < listener->last;
    listener->unsure += progress->seconds_left < 0;
    listener->last = progress->fraction;
}

static void test_progress_of_the_whole_run_never_falls(void **state) {
    (void)state;
    struct listener listener = {0, 0, 0, 0};
    struct fewray_job job = small_job(scratch_path("told.exr"), NULL);
    job.progress = listen;
    job.progress_user = &listener;
    assert_int_equal(fewray_job_run(&job, NULL, NULL, NULL), FEWRAY_OK);
    assert_true(listener.calls > 4 * 12);
    assert_int_equal(listener.falls, 0);
    assert_true(listener.unsure < listener.calls / 2);
    assert_true(listener.last > 0.3 && listener.last <= 1);
}

static void test_previews_keep_to_their_share_of_the_time(void **state) {
    (void)state;
    /* cheap ones: every interval */
    assert_near(preview_next(100, 110, 0.01, 1), 111, 1e-9);
    /* dear ones wait until all of them are a few per cent */
    const double cost = 2;
    double now = 100, spent = 0;
    for (int k = 0; k < 20; k++) {
        now += cost;
        spent += cost;
        now = preview_next(100, now, spent, 1);
        assert_true(spent <= 0.05 * (now - 100));
    }
    assert_true(spent >= 0.03 * (now - 100));
}

static void test_large_pictures_are_made_smaller(void **state) {
    (void)state;
    assert_int_equal(preview_factor(1, 1), 1);
    assert_int_equal(preview_factor(1280, 720), 1);
    assert_int_equal(preview_factor(1920, 1080), 2);
    assert_int_equal(preview_factor(7680, 4320), 6);
    struct fewray_frame *frame = NULL, *small = NULL;
    assert_int_equal(fewray_frame_create(5, 3, &frame, NULL), FEWRAY_OK);
    float *color = fewray_frame_add(frame, "R"), *variance = fewray_frame_add(frame, "variance.R");
    for (int i = 0; i < 15; i++) {
        color[i] = (float)i;
        variance[i] = 8;
    }
    assert_int_equal(preview_shrink(frame, 2, 2, &small, NULL), FEWRAY_OK);
    assert_int_equal(small->width, 3);
    assert_int_equal(small->height, 2);
    const float expected[6] = {3, 5, 6.5f, 10.5f, 12.5f, 14};
    for (int i = 0; i < 6; i++) {
        assert_near(fewray_frame_plane(small, "R")[i], expected[i], 1e-6);
        assert_near(fewray_frame_plane(small, "variance.R")[i], 2, 1e-6);
    }
    fewray_frame_destroy(&frame);
    fewray_frame_destroy(&small);
}

static void test_only_pixels_without_a_sample_are_filled_from_the_coarse_picture(void **state) {
    (void)state;
    struct fewray_frame *frame = NULL, *coarse = NULL;
    float *color[3], *albedo[3], *depth[3], *from[3];
    bool mask[4];
    assert_int_equal(fewray_frame_create(4, 1, &frame, NULL), FEWRAY_OK);
    assert_int_equal(fewray_frame_create(4, 1, &coarse, NULL), FEWRAY_OK);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, color) &&
                fewray_frame_add_layer(frame, FEWRAY_ALBEDO, albedo) &&
                fewray_frame_add_layer(frame, FEWRAY_DEPTH, depth) &&
                fewray_frame_add_layer(coarse, FEWRAY_COLOR, from));
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 4; i++)
            from[c][i] = 7;
    color[2][0] = 1;  /* the sky */
    albedo[1][1] = 1; /* a surface in the dark */
    depth[0][2] = 1;  /* a black one */
    coarse_mask(frame, mask);
    coarse_fill(coarse, mask, frame);
    assert_false(mask[0] || mask[1] || mask[2]);
    assert_true(mask[3]);
    assert_true(color[2][0] == 1 && color[0][1] == 0 && color[0][2] == 0 && color[0][3] == 7);
    fewray_frame_destroy(&frame);
    fewray_frame_destroy(&coarse);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_viewer_never_sees_half_a_file),
        cmocka_unit_test(test_the_picture_is_the_same_with_and_without_preview),
        cmocka_unit_test(test_tracing_pauses_between_tiles_and_after_each_pass),
        cmocka_unit_test(test_a_cancelled_run_leaves_what_is_done_in_the_preview),
        cmocka_unit_test(test_progress_of_the_whole_run_never_falls),
        cmocka_unit_test(test_previews_keep_to_their_share_of_the_time),
        cmocka_unit_test(test_large_pictures_are_made_smaller),
        cmocka_unit_test(test_only_pixels_without_a_sample_are_filled_from_the_coarse_picture),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
