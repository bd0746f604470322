/* SPDX-License-Identifier: Apache-2.0 */
/* `fewray denoise` of files with numbers: all of them or those of a range, missing ones named,
 * those that are there left alone, whole files behind an interrupt. */

#include "tests/unit/check.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "pipeline/denoise_job.h"
#include "pipeline/frames.h"
#include "tests/unit/scratch_folder.h"

enum { SIDE = 16, COUNT = SIDE * SIDE };

static char pattern_in[96], pattern_out[96], noted[900];
static int frames_done, cancel_after;
static volatile int cancel;
static const struct name_list no_layers;

static void note(const char *text) {
    snprintf(noted, sizeof noted, "%s", text);
}

static void frame_done(void *user, int frame, const struct fewray_run_stats *stats) {
    (void)user;
    assert_int_equal(stats->width, SIDE);
    frames_done = 100 * frames_done + frame;
    if (frame == cancel_after)
        cancel = 1;
}

static void write_frame(int number) {
    struct fewray_frame *frame = NULL;
    float *color[3];
    char *name = frames_name(pattern_in, number);
    assert_int_equal(fewray_frame_create(SIDE, SIDE, &frame, NULL), 0);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, color));
    for (int i = 0; i < 3 * COUNT; i++)
        color[i / COUNT][i % COUNT] = (float)(i * 7919 % 17) * 0.125f;
    assert_int_equal(fewray_frame_write_exr(frame, name, false, NULL), 0);
    fewray_frame_destroy(&frame);
    free(name);
}

static bool is_there(int number) {
    char *name = frames_name(pattern_out, number);
    struct fewray_frame *frame = NULL;
    const bool whole = !fewray_frame_read_exr(name, &frame, NULL);
    fewray_frame_destroy(&frame);
    free(name);
    return whole;
}

static int run(const char *range, bool skip, struct fewray_error *error) {
    struct fewray_frames frames;
    struct denoise_job job = {
        .input = pattern_in, .outputs = {.exr = pattern_out}, .aovs = &no_layers, .note = note};
    struct denoise_sequence sequence = {.skip_existing = skip, .frame_done = frame_done};
    fewray_denoise_options_init(&job.denoise);
    job.denoise.threads = 1;
    job.denoise.cancel = &cancel;
    if (range) {
        assert_true(frames_parse(range, &frames));
        sequence.frames = &frames;
    }
    noted[0] = 0;
    frames_done = 0;
    cancel = 0;
    return denoise_sequence_run(&job, &sequence, 1, error);
}

static void test_files_of_a_pattern_are_found(void **state) {
    (void)state;
    static const char *const names[] = {"x.12.exr", "x.012.exr", "x.7.exr",
                                        "x.exr",    "x.1a.exr",  "y.3.exr"};
    char path[96];
    int *numbers = NULL, count = 0;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        FILE *file = fopen(path, "w");
        assert_non_null(file);
        fclose(file);
    }
    snprintf(path, sizeof path, "%s/x.#.exr", folder);
    assert_int_equal(frames_find(path, &numbers, &count, NULL), 0);
    assert_int_equal(count, 2);
    assert_true(numbers[0] == 7 && numbers[1] == 12);
    free(numbers);
    snprintf(path, sizeof path, "%s/x.###.exr", folder);
    assert_int_equal(frames_find(path, &numbers, &count, NULL), 0);
    assert_int_equal(count, 1);
    free(numbers);
    assert_true(frames_find("nowhere/x.###.exr", &numbers, &count, NULL) < 0);
    free(numbers);
}

static void test_all_that_are_there_and_gaps_are_told(void **state) {
    (void)state;
    assert_int_equal(run(NULL, false, NULL), 0);
    assert_int_equal(frames_done, 20308);
    assert_non_null(strstr(noted, "between frames 2 and 8 these are missing: 4..7"));
    assert_true(is_there(2) && is_there(3) && is_there(8));
}

static void test_missing_frames_are_named_before_any_work(void **state) {
    (void)state;
    struct fewray_error error;
    assert_int_equal(run("1..9", false, &error), FEWRAY_ERROR_IO);
    assert_string_equal(error.what, "6 of 9 frames are missing: 1, 4..7, 9");
    assert_int_equal(frames_done, 0);
    assert_int_equal(run("2..3", false, &error), 0);
    assert_int_equal(frames_done, 203);
}

static void test_frames_that_are_there_stay(void **state) {
    (void)state;
    char *name = frames_name(pattern_out, 3);
    assert_int_equal(run(NULL, false, NULL), 0);
    assert_int_equal(unlink(name), 0);
    assert_int_equal(run(NULL, true, NULL), 0);
    assert_int_equal(frames_done, 3);
    assert_true(is_there(3));
    free(name);
}

static void test_an_interrupt_leaves_whole_frames(void **state) {
    (void)state;
    for (int frame = 2; frame <= 8; frame++) {
        char *name = frames_name(pattern_out, frame);
        unlink(name);
        free(name);
    }
    cancel_after = 2;
    struct fewray_error error;
    assert_int_equal(run(NULL, false, &error), FEWRAY_ERROR_CANCELLED);
    cancel_after = 0;
    assert_true(is_there(2) && !is_there(3) && !is_there(8));
}

static int start(void **state) {
    const int status = make_folder(state);
    snprintf(pattern_in, sizeof pattern_in, "%s/in.####.exr", folder);
    snprintf(pattern_out, sizeof pattern_out, "%s/out.####.exr", folder);
    write_frame(2);
    write_frame(3);
    write_frame(8);
    return status;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_files_of_a_pattern_are_found),
        cmocka_unit_test(test_all_that_are_there_and_gaps_are_told),
        cmocka_unit_test(test_missing_frames_are_named_before_any_work),
        cmocka_unit_test(test_frames_that_are_there_stay),
        cmocka_unit_test(test_an_interrupt_leaves_whole_frames),
    };
    return cmocka_run_group_tests(tests, start, remove_folder);
}
