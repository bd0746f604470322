/* SPDX-License-Identifier: Apache-2.0 */
/* Parts of a picture: what they merge to, and which are refused. */

#include "tests/unit/scratch_folder.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "pipeline/part.h"

enum { WIDTH = 24, HEIGHT = 18, PIXELS = WIDTH * HEIGHT };

/* The path of a file in the folder; valid until the next call but 31. */
static const char *path_of(const char *name) {
    static char paths[32][64];
    static int next;
    char *path = paths[next++ % 32];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static struct fewray_job small_job(int spp) {
    struct fewray_job job;
    fewray_job_init(&job);
    job.scene_path = EXAMPLES "/cornell-box.xml";
    job.settings.width = WIDTH;
    job.settings.height = HEIGHT;
    job.settings.spp = spp;
    job.guided = job.denoised = job.pilot = false;
    return job;
}

static void render(struct fewray_job job, const char *path, struct fewray_run_stats *stats) {
    struct fewray_error error = {.line = 0};
    job.outputs.exr = path;
    if (fewray_job_run(&job, NULL, stats, &error))
        fail_msg("%s: %s", error.file, error.what);
}

static void render_part(struct fewray_job job, int part, int parts, const char *path) {
    job.part = part;
    job.parts = parts;
    render(job, path, NULL);
}

static struct fewray_frame *merge(const char *const *paths, int count) {
    struct fewray_merge_job job;
    struct fewray_frame *frame = NULL;
    struct fewray_error error = {.line = 0};
    fewray_merge_job_init(&job);
    job.paths = paths;
    job.count = count;
    job.denoised = false;
    if (fewray_merge_run(&job, &frame, NULL, &error))
        fail_msg("%s: %s", error.file, error.what);
    return frame;
}

static void expect_refusal(const char *const *paths, int count, const char *named) {
    struct fewray_merge_job job;
    struct fewray_error error = {.line = 0};
    char text[1200];
    fewray_merge_job_init(&job);
    job.paths = paths;
    job.count = count;
    job.outputs.exr = path_of("refused.exr");
    assert_int_not_equal(fewray_merge_run(&job, NULL, NULL, &error), FEWRAY_OK);
    fewray_error_text(&error, text, sizeof text);
    if (!strstr(text, named))
        fail_msg("'%s' doesn't tell '%s'", text, named);
    assert_int_not_equal(access(path_of("refused.exr"), F_OK), 0);
}

/* --- arithmetic */

/* One pixel of a part, made of known samples of equal weight. */
static struct fewray_frame *part_of(const float *samples, int count) {
    static const char *const colors[3] = {"R", "G", "B"};
    struct fewray_frame *frame = NULL;
    float *variance[3];
    char name[32];
    double mean = 0, deviation = 0;
    for (int s = 0; s < count; s++)
        mean += samples[s] / (double)count;
    for (int s = 0; s < count; s++)
        deviation += (samples[s] - mean) * (samples[s] - mean);
    assert_int_equal(fewray_frame_create(1, 1, &frame, NULL), FEWRAY_OK);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_VARIANCE, variance));
    fewray_frame_add(frame, "part.count")[0] = (float)count;
    fewray_frame_add(frame, "part.factor")[0] = count ? 1 / (float)count : 0;
    for (int c = 0; c < 3; c++) {
        fewray_frame_add(frame, colors[c])[0] = (float)mean;
        snprintf(name, sizeof name, "part.mean.%s", colors[c]);
        fewray_frame_add(frame, name)[0] = (float)mean;
        snprintf(name, sizeof name, "part.deviation.%s", colors[c]);
        fewray_frame_add(frame, name)[0] = (float)deviation;
    }
    return frame;
}

/* Parts of 3, 0 and 5 samples against all 8 at once. */
static void test_parts_merge_to_mean_and_variance_of_all_samples(void **state) {
    (void)state;
    static const float x[8] = {1, 4, 2, 8, 0.5f, 3, 7, 0};
    double mean = 0, variance = 0;
    for (int s = 0; s < 8; s++)
        mean += x[s] / 8.0;
    for (int s = 0; s < 8; s++)
        variance += (x[s] - mean) * (x[s] - mean) / (7 * 8.0);
    struct fewray_frame *sum = part_of(x, 3), *none = part_of(x, 0), *rest = part_of(x + 3, 5);
    assert_true(part_add(sum, none));
    assert_true(part_add(sum, rest));
    part_finish(sum);
    assert_near(fewray_frame_plane(sum, "G")[0], mean, 1e-6);
    assert_near(fewray_frame_plane(sum, "variance.G")[0], variance, 1e-6);
    assert_null(fewray_frame_plane(sum, "part.count"));
    assert_false(part_add(sum, rest)); /* other planes now */
    fewray_frame_destroy(&sum);
    fewray_frame_destroy(&none);
    fewray_frame_destroy(&rest);
}

/* Two estimates of one irradiance 2 with confidence 0.8, variance 1: their mean has variance 0.5.
 */
static void test_confidence_grows_with_the_parts(void **state) {
    (void)state;
    static const float x[2] = {1, 2};
    struct fewray_frame *parts[2];
    float *e[3], *confidence[3];
    for (int k = 0; k < 2; k++) {
        parts[k] = part_of(x, 2);
        assert_true(fewray_frame_add_layer(parts[k], FEWRAY_IRRADIANCE, e) &&
                    fewray_frame_add_layer(parts[k], FEWRAY_IRRADIANCE_CONFIDENCE, confidence));
        e[0][0] = e[1][0] = e[2][0] = 2;
        confidence[0][0] = 0.8f;
    }
    assert_true(part_add(parts[0], parts[1]));
    assert_near(fewray_frame_plane(parts[0], "irradiance.G")[0], 2, 1e-6);
    assert_near(fewray_frame_plane(parts[0], "irradiance.confidence")[0], 4 / 4.5, 1e-6);
    fewray_frame_destroy(&parts[0]);
    fewray_frame_destroy(&parts[1]);
}

/* --- renders */

/* The parts' samples are those of one render of all: unguided they make the same picture but for
 * rounding, variance included. */
static void test_merged_parts_equal_one_render_of_all_samples(void **state) {
    (void)state;
    struct fewray_job job = small_job(2), whole = small_job(6);
    job.settings.camera_rays = whole.settings.camera_rays = 0;
    const char *const paths[3] = {path_of("1.exr"), path_of("2.exr"), path_of("3.exr")};
    struct fewray_frame *expected = NULL;
    for (int i = 0; i < 3; i++)
        render_part(job, i + 1, 3, paths[i]);
    assert_int_equal(fewray_job_run(&whole, &expected, NULL, NULL), FEWRAY_OK);
    struct fewray_frame *merged = merge(paths, 3);
    assert_int_equal(merged->plane_count, expected->plane_count);
    for (size_t k = 0; k < merged->plane_count; k++) {
        const float *other = fewray_frame_plane(expected, merged->planes[k].name);
        assert_non_null(other);
        for (int i = 0; i < PIXELS; i++)
            assert_near(merged->planes[k].data[i], other[i], 1e-5 * (1 + fabsf(other[i])));
    }
    assert_string_equal(fewray_frame_attribute(merged, "fewray.spp"), "6");
    fewray_frame_destroy(&merged);
    fewray_frame_destroy(&expected);
}

static void test_the_order_of_the_files_makes_no_difference(void **state) {
    (void)state;
    const char *const one[3] = {path_of("1.exr"), path_of("2.exr"), path_of("3.exr")};
    const char *const other[3] = {one[2], one[0], one[1]};
    struct fewray_frame *a = merge(one, 3), *b = merge(other, 3);
    for (size_t k = 0; k < a->plane_count; k++)
        assert_memory_equal(a->planes[k].data, b->planes[k].data, PIXELS * sizeof(float));
    fewray_frame_destroy(&a);
    fewray_frame_destroy(&b);
}

static double mean_of(const struct fewray_frame *frame, const char *name) {
    const float *plane = fewray_frame_plane(frame, name);
    double sum = 0;
    for (int i = 0; i < PIXELS; i++)
        sum += plane[i];
    return sum / PIXELS;
}

/* Each part has a look and maps of its own; the standard error is that of the variance layers. */
static void test_guided_parts_merge_without_bias(void **state) {
    (void)state;
    struct fewray_job job = small_job(4), plain = small_job(256);
    const char *paths[16];
    char names[16][64];
    struct fewray_frame *expected = NULL;
    job.guided = true;
    for (int i = 0; i < 16; i++) {
        snprintf(names[i], sizeof names[i], "%s/g%d.exr", folder, i);
        paths[i] = names[i];
        render_part(job, i + 1, 16, paths[i]);
    }
    struct fewray_frame *merged = merge(paths, 16);
    assert_int_equal(fewray_job_run(&plain, &expected, NULL, NULL), FEWRAY_OK);
    const double error =
        sqrt((mean_of(merged, "variance.G") + mean_of(expected, "variance.G")) / PIXELS);
    assert_near(mean_of(merged, "G"), mean_of(expected, "G"), 4 * error);
    assert_true(error < 0.02 * mean_of(expected, "G"));
    fewray_frame_destroy(&merged);
    fewray_frame_destroy(&expected);
}

/* --- refusals */

static void test_parts_of_other_pictures_are_refused(void **state) {
    (void)state;
    struct fewray_job job = small_job(2), other;
    job.settings.camera_rays = 0;
    const char *paths[3] = {path_of("1.exr"), path_of("2.exr"), path_of("other.exr")};
    other = job;
    other.settings.seed = 9;
    render_part(other, 3, 3, paths[2]);
    expect_refusal(paths, 3, "the seed differs");
    other = job;
    other.settings.width = WIDTH + 1;
    render_part(other, 3, 3, paths[2]);
    expect_refusal(paths, 3, "size differs");
    other = job;
    other.settings.spp = 3;
    render_part(other, 3, 3, paths[2]);
    expect_refusal(paths, 3, "samples a pixel differs");
    other = job;
    other.settings.max_depth = 3;
    render_part(other, 3, 3, paths[2]);
    expect_refusal(paths, 3, "the settings differs");
    other = job;
    other.scene_path = EXAMPLES "/window-room.xml";
    render_part(other, 3, 3, paths[2]);
    expect_refusal(paths, 3, "the scene differs");
    render_part(job, 3, 4, paths[2]);
    expect_refusal(paths, 3, "number of parts differs");
}

static void test_missing_and_repeated_parts_are_named(void **state) {
    (void)state;
    struct fewray_job job = small_job(1);
    const char *paths[4] = {path_of("a.exr"), path_of("b.exr"), path_of("c.exr"), path_of("b.exr")};
    render_part(job, 2, 9, paths[0]);
    render_part(job, 4, 9, paths[1]);
    render_part(job, 8, 9, paths[2]);
    expect_refusal(paths, 3, "1, 3, 5-7, 9");
    expect_refusal(paths, 4, "part 4 is given twice");
    struct fewray_merge_job merging;
    struct fewray_frame *frame = NULL;
    fewray_merge_job_init(&merging);
    merging.paths = paths;
    merging.count = 3;
    merging.partial = true;
    assert_int_equal(fewray_merge_run(&merging, &frame, NULL, NULL), FEWRAY_OK);
    assert_non_null(fewray_frame_plane(frame, "noisy.R"));
    assert_string_equal(fewray_frame_attribute(frame, "fewray.part"), "merged 3 of 9");
    fewray_frame_destroy(&frame);
}

static void test_damaged_and_foreign_files_are_refused_by_name(void **state) {
    (void)state;
    const char *paths[3] = {path_of("1.exr"), path_of("2.exr"), path_of("bad.exr")};
    expect_refusal(&paths[2], 1, "bad.exr");
    render(small_job(1), paths[2], NULL); /* a picture */
    expect_refusal(paths, 3, "bad.exr: this is no part");
    struct fewray_frame *part = NULL;
    assert_int_equal(fewray_frame_read_exr(path_of("3.exr"), &part, NULL), FEWRAY_OK);
    fewray_frame_plane(part, "part.count")[7] = -1;
    assert_int_equal(fewray_frame_write_exr(part, paths[2], true, NULL), FEWRAY_OK);
    expect_refusal(paths, 3, "bad.exr: the part is damaged");
    fewray_frame_remove(part, "part.count");
    assert_int_equal(fewray_frame_write_exr(part, paths[2], true, NULL), FEWRAY_OK);
    expect_refusal(paths, 3, "bad.exr: the part is damaged");
    assert_int_equal(truncate(paths[2], 9000), 0);
    expect_refusal(paths, 3, "bad.exr");
    fewray_frame_destroy(&part);
}

/* --- resuming */

static void test_only_a_whole_part_of_the_same_picture_is_kept(void **state) {
    (void)state;
    struct fewray_job job = small_job(2);
    struct fewray_run_stats stats;
    const char *path = path_of("kept.exr");
    job.part = 2;
    job.parts = 3;
    job.skip_existing = true;
    render(job, path, &stats);
    assert_false(stats.kept);
    render(job, path, &stats);
    assert_true(stats.kept && stats.counts.paths == 0);
    job.part = 1; /* another one */
    render(job, path, &stats);
    assert_false(stats.kept);
    job.settings.seed = 5;
    render(job, path, &stats);
    assert_false(stats.kept);
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(truncate(path, info.st_size - 100), 0);
    render(job, path, &stats);
    assert_false(stats.kept);
    render(job, path, &stats);
    assert_true(stats.kept);
}

static void test_an_interrupted_part_leaves_nothing(void **state) {
    (void)state;
    const volatile int cancel = 1;
    struct fewray_job job = small_job(2);
    struct fewray_error error;
    job.part = job.parts = 1;
    job.outputs.exr = path_of("cut.exr");
    job.settings.cancel = &cancel;
    assert_int_equal(fewray_job_run(&job, NULL, NULL, &error), FEWRAY_ERROR_CANCELLED);
    assert_int_not_equal(access(path_of("cut.exr"), F_OK), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parts_merge_to_mean_and_variance_of_all_samples),
        cmocka_unit_test(test_confidence_grows_with_the_parts),
        cmocka_unit_test(test_merged_parts_equal_one_render_of_all_samples),
        cmocka_unit_test(test_the_order_of_the_files_makes_no_difference),
        cmocka_unit_test(test_guided_parts_merge_without_bias),
        cmocka_unit_test(test_parts_of_other_pictures_are_refused),
        cmocka_unit_test(test_missing_and_repeated_parts_are_named),
        cmocka_unit_test(test_damaged_and_foreign_files_are_refused_by_name),
        cmocka_unit_test(test_only_a_whole_part_of_the_same_picture_is_kept),
        cmocka_unit_test(test_an_interrupted_part_leaves_nothing),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
