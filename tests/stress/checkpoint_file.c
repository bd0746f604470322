/* SPDX-License-Identifier: Apache-2.0 */
/* Files that aren't this render's checkpoint: each is refused, with what is wrong, before anything
 * is rendered; the file stays as it is and no output appears. */

#include "checkpoint_job.h"

#include <sys/stat.h>

#include "pipeline/checkpoint.h"

enum { SMALL = 6, HEADER_BYTES = 24 };

/* A checkpoint of a few thousand bytes, of a plain render of 6 x 6 pixels with 8 of 16 samples. */
static struct fewray_job tiny_job(void) {
    struct fewray_job job = small_job(scratch_name("out.exr"), scratch_name("state"));
    job.guided = false;
    job.settings.width = job.settings.height = SMALL;
    job.settings.threads = 1;
    return job;
}

static unsigned char *make_checkpoint(size_t *size) {
    struct fewray_job job = tiny_job();
    struct stopper stopper = {.calls = 1};
    unlink(job.checkpoint);
    assert_int_equal(run_until(job, &stopper, NULL, NULL), FEWRAY_ERROR_CANCELLED);
    unlink(job.outputs.exr);
    FILE *file = fopen(job.checkpoint, "rb");
    assert_non_null(file);
    unsigned char *bytes = malloc(1 << 20);
    *size = fread(bytes, 1, 1 << 20, file);
    fclose(file);
    assert_true(*size > sizeof(struct checkpoint_info) && *size < 1 << 20);
    return bytes;
}

/* What opening says of the file; empty: it is sound. */
static const char *open_error(const void *bytes, size_t size) {
    static struct fewray_error error;
    struct checkpoint_file file;
    memset(&error, 0, sizeof error);
    const char *path = scratch_write("damaged", bytes, size);
    const int status = checkpoint_open(path, true, &file, &error);
    checkpoint_close(&file);
    assert_true(status == FEWRAY_OK || strstr(error.file, "damaged"));
    return status ? error.what : "";
}

/* Bytes 0..7 magic, 8..11 version, 12..15 CRC, 16..23 length; then what the CRC is of. */
static const char *expected_at(size_t byte) {
    return byte < 8 ? "no checkpoint" : byte < 12 ? "version" : "damaged";
}

static void test_a_flip_of_any_byte_is_found(void **state) {
    (void)state;
    size_t size;
    unsigned char *bytes = make_checkpoint(&size);
    assert_string_equal(open_error(bytes, size), "");
    /* of the rest every 11th: each field is longer, or has such a neighbour under the same CRC */
    for (size_t i = 0; i < size; i += i < HEADER_BYTES ? 1 : 11) {
        bytes[i] ^= (unsigned char)(1u << i % 8);
        const char *what = open_error(bytes, size);
        if (!strstr(what, expected_at(i)))
            fail_msg("byte %zu: '%s', expected '%s'", i, what, expected_at(i));
        bytes[i] ^= (unsigned char)(1u << i % 8);
    }
    free(bytes);
}

static void test_a_file_cut_anywhere_or_grown_is_found(void **state) {
    (void)state;
    size_t size;
    unsigned char *bytes = make_checkpoint(&size);
    for (size_t cut = 0; cut < size; cut += cut < 2 * HEADER_BYTES ? 1 : 61)
        if (!strstr(open_error(bytes, cut), cut < 8 ? "no checkpoint" : "cut off"))
            fail_msg("cut at byte %zu: '%s'", cut, open_error(bytes, cut));
    bytes[size] = 0;
    assert_non_null(strstr(open_error(bytes, size + 1), "bytes follow"));
    free(bytes);
}

/* --- sound, but of something else */

static void set_seed(struct fewray_job *job) {
    job->settings.seed++;
}
static void set_width(struct fewray_job *job) {
    job->settings.width++;
}
static void set_depth(struct fewray_job *job) {
    job->settings.max_depth = 3;
}
static void set_guide(struct fewray_job *job) {
    job->guided = true;
}
static void set_initial(struct fewray_job *job) {
    job->settings.initial = 2;
}
static void set_probes(struct fewray_job *job) {
    job->settings.probes = false;
}
static void set_part(struct fewray_job *job) {
    job->part = 2;
    job->parts = 4;
}
static void set_layers(struct fewray_job *job) {
    job->settings.direct = true;
}
static void set_scene(struct fewray_job *job) {
    job->scene_path = EXAMPLES "/door-ajar.xml";
}
static void set_fewer(struct fewray_job *job) {
    job->settings.spp = 1;
}

static const struct {
    void (*change)(struct fewray_job *job);
    const char *named;
} OTHERS[] = {
    {set_seed, "seed 7, not 8"},
    {set_width, "6x6 pixels, not 7x6"},
    {set_depth, "max_depth=0, not max_depth=3"},
    {set_guide, "guide=off, not guide=odis"},
    {set_initial, "initial=1, not initial=2"},
    {set_probes, "probes=1, not probes=0"},
    {set_part, "a whole picture, not part 2 of 4"},
    {set_layers, "direct=0, not direct=1"},
    {set_scene, "cornell-box.xml"},
    {set_fewer, "--spp 20"},
};

static void test_a_checkpoint_of_another_render_is_refused_by_what_differs(void **state) {
    (void)state;
    size_t size;
    unsigned char *bytes = make_checkpoint(&size);
    for (size_t i = 0; i < sizeof OTHERS / sizeof *OTHERS; i++) {
        struct fewray_job job = tiny_job();
        struct fewray_error error = {0};
        scratch_write("before", bytes, size);
        OTHERS[i].change(&job);
        assert_int_equal(fewray_job_run(&job, NULL, NULL, &error), FEWRAY_ERROR_ARGUMENT);
        if (!strstr(error.what, OTHERS[i].named) || strcmp(error.file, job.checkpoint))
            fail_msg("expected '%s', got %s: %s", OTHERS[i].named, error.file, error.what);
        assert_false(exists(job.outputs.exr));
        assert_true(same_files(scratch_name("before"), job.checkpoint));
    }
    free(bytes);
}

static void test_what_may_differ_gives_the_same_picture(void **state) {
    (void)state;
    size_t size;
    free(make_checkpoint(&size));
    struct fewray_job job = tiny_job();
    job.settings.threads = 3;
    job.outputs.png = scratch_name("out.png");
    assert_int_equal(fewray_job_run(&job, NULL, NULL, NULL), FEWRAY_OK);
    struct fewray_job whole = tiny_job();
    whole.checkpoint = NULL;
    whole.outputs.exr = scratch_name("whole.exr");
    assert_int_equal(fewray_job_run(&whole, NULL, NULL, NULL), FEWRAY_OK);
    assert_true(same_files(job.outputs.exr, whole.outputs.exr));
    unlink(job.outputs.exr);
}

/* --- impossible wishes: the status, and a word of the message */

static void want_goal(struct fewray_job *job) {
    job->goal.error = 0.1;
}
static void want_ppg(struct fewray_job *job) {
    job->guided = job->ppg = true;
}
static void want_output(struct fewray_job *job) {
    job->checkpoint = job->outputs.exr;
}
static void want_nowhere(struct fewray_job *job) {
    job->checkpoint = "/dev/null/state";
}
static void want_folder(struct fewray_job *job) {
    job->checkpoint = scratch_folder;
}
static void want_missing(struct fewray_job *job) {
    job->must_resume = true;
}
static void want_foreign(struct fewray_job *job) {
    job->checkpoint = scratch_text("foreign", "a file that is dear to somebody");
}
static void want_empty(struct fewray_job *job) {
    job->checkpoint = scratch_text("empty", "");
}

static const struct {
    void (*change)(struct fewray_job *job);
    int status;
    const char *named;
} WISHES[] = {
    {want_goal, FEWRAY_ERROR_UNSUPPORTED, "given number of samples"},
    {want_ppg, FEWRAY_ERROR_UNSUPPORTED, "path guiding"},
    {want_output, FEWRAY_ERROR_ARGUMENT, "name of another file"},
    {want_nowhere, FEWRAY_ERROR_IO, ""},
    {want_folder, FEWRAY_ERROR_IO, "regular file"},
    {want_missing, FEWRAY_ERROR_IO, "No such file"},
    {want_foreign, FEWRAY_ERROR_FORMAT, "no checkpoint"},
    {want_empty, FEWRAY_ERROR_FORMAT, "no checkpoint"},
};

static void test_what_cannot_be_is_told_before_anything_is_rendered(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof WISHES / sizeof *WISHES; i++) {
        struct fewray_job job = tiny_job();
        struct fewray_error error = {0};
        unlink(job.checkpoint);
        WISHES[i].change(&job);
        const int status = fewray_job_run(&job, NULL, NULL, &error);
        if (status != WISHES[i].status || !strstr(error.what, WISHES[i].named))
            fail_msg("wish %zu: status %d, %s", i, status, error.what);
        assert_false(exists(scratch_name("out.exr")));
    }
    assert_true(exists(scratch_name("foreign")));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_flip_of_any_byte_is_found),
        cmocka_unit_test(test_a_file_cut_anywhere_or_grown_is_found),
        cmocka_unit_test(test_a_checkpoint_of_another_render_is_refused_by_what_differs),
        cmocka_unit_test(test_what_may_differ_gives_the_same_picture),
        cmocka_unit_test(test_what_cannot_be_is_told_before_anything_is_rendered),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
