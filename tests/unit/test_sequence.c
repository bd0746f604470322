/* SPDX-License-Identifier: Apache-2.0 */
/* Sequences through the public API: motion of views, frames by themselves, resumed sequences. */

#include "tests/unit/check.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "fewray/pipeline.h"

static char folder[] = "sequence-XXXXXX";
static char pattern[64];

static int create_folder(void **state) {
    (void)state;
    if (!mkdtemp(folder))
        return -1;
    snprintf(pattern, sizeof pattern, "%s/s.##.exr", folder);
    return 0;
}

static const char *name_of(int frame) {
    static char name[64];
    snprintf(name, sizeof name, "%s/s.%02d.exr", folder, frame);
    return name;
}

static int remove_folder(void **state) {
    (void)state;
    for (int frame = 0; frame < 8; frame++)
        unlink(name_of(frame));
    return rmdir(folder);
}

static void run(int first, int last, bool temporal, bool skip_existing) {
    struct fewray_job job;
    struct fewray_sequence sequence;
    struct fewray_error error = {.line = 0};
    fewray_job_init(&job);
    fewray_sequence_init(&sequence);
    job.scene_path = EXAMPLES "/cornell-box-move.xml";
    job.settings.width = job.settings.height = 48;
    job.settings.spp = 2;
    job.guided = false;
    job.outputs.exr = pattern;
    job.outputs.float32 = true;
    sequence.frames = (struct fewray_frames){first, last, 1};
    sequence.temporal = temporal;
    sequence.skip_existing = skip_existing;
    if (fewray_sequence_run(&job, &sequence, &error))
        fail_msg("%s: %s", error.file, error.what);
}

static struct fewray_frame *read_frame(int frame) {
    struct fewray_frame *picture = NULL;
    assert_int_equal(fewray_frame_read_exr(name_of(frame), &picture, NULL), FEWRAY_OK);
    return picture;
}

/* The largest difference of two frames' red, and frees both. */
static double difference(struct fewray_frame *a, struct fewray_frame *b, const char *plane) {
    const float *x = fewray_frame_plane(a, plane), *y = fewray_frame_plane(b, plane);
    double most = 0;
    for (int i = 0; i < a->width * a->height; i++)
        most = fmax(most, fabs((double)x[i] - y[i]));
    fewray_frame_destroy(&a);
    fewray_frame_destroy(&b);
    return most;
}

static void test_without_the_past_a_frame_is_what_it_is_alone(void **state) {
    (void)state;
    run(2, 4, false, false);
    struct fewray_frame *in_sequence = read_frame(4), *neighbour = read_frame(3);
    run(4, 4, true, false);
    assert_true(difference(neighbour, read_frame(4), "noisy.R") > 1e-3);
    assert_true(difference(in_sequence, read_frame(4), "R") == 0);
}

static void test_a_resumed_sequence_goes_on(void **state) {
    (void)state;
    run(2, 5, true, false);
    struct fewray_frame *first = read_frame(5), *noisy = read_frame(5), *kept = read_frame(4);
    unlink(name_of(5));
    run(2, 5, true, true);
    assert_true(difference(kept, read_frame(4), "R") == 0);
    assert_true(difference(noisy, read_frame(5), "noisy.R") == 0);
    assert_true(difference(first, read_frame(5), "R") < 1e-5);
    /* And the past did count. */
    first = read_frame(5);
    run(5, 5, true, false);
    assert_true(difference(first, read_frame(5), "R") > 1e-3);
}

/* A camera at the origin that looks along +z sees a plane z = 4; it moved by 0.5 to its left. */
static void test_motion_of_a_plane(void **state) {
    (void)state;
    enum { WIDTH = 16, HEIGHT = 8 };
    struct fewray_view now = {.to_world = {1, 0, 0, 0.5f, 0, 1, 0, 0, 0, 0, 1, 0}, .fov_x = 1.2f},
                       before = now;
    float depth[WIDTH * HEIGHT], x[WIDTH * HEIGHT], y[WIDTH * HEIGHT], past[WIDTH * HEIGHT];
    const double half = tan(0.6);
    before.to_world[3] = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const double u = (1 - 2 * (i % WIDTH + 0.5) / WIDTH) * half;
        const double v = (1 - 2 * (i / WIDTH + 0.5) / HEIGHT) * half * HEIGHT / WIDTH;
        depth[i] = i == 5 ? 0 : (float)(4 * sqrt(1 + u * u + v * v));
    }
    fewray_view_motion(&now, &before, WIDTH, HEIGHT, depth, x, y, past);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        assert_near(x[i], i == 5 ? 0 : -0.5 / (4 * half) * WIDTH / 2, 1e-4);
        assert_near(y[i], 0, 1e-4);
        assert_true((past[i] > 0) == (i != 5));
    }
    fewray_view_motion(&now, &now, WIDTH, HEIGHT, depth, x, y, past);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        assert_near(x[i], 0, 1e-4);
        assert_near(past[i], depth[i], 1e-4);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_without_the_past_a_frame_is_what_it_is_alone),
        cmocka_unit_test(test_a_resumed_sequence_goes_on),
        cmocka_unit_test(test_motion_of_a_plane),
    };
    return cmocka_run_group_tests(tests, create_folder, remove_folder);
}
