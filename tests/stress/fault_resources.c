/* SPDX-License-Identifier: Apache-2.0 */
/* Few files, no threads, a small stack, little memory, no home, another language. Bound of every
 * case: the same picture as ever, or exit code 1 with a line; no hang, no signal, no temporary
 * file. */

#include "tests/stress/fault_command.h"

#include <errno.h>

#include "fewray/features.h"

/* The exit code of the dynamic linker. */
enum { NOT_STARTED = 127 };

static char usual[1 << 17];
static size_t usual_size;

static int prepare(void **state) {
    if (make_folder(state))
        return -1;
    expect_success(RENDER_WHOLE " -o usual.exr");
    usual_size = read_text(in_folder("usual.exr"), usual, sizeof usual);
    return 0;
}

static void expect_usual_picture(const char *what) {
    static char text[sizeof usual];
    const size_t size = read_text(in_folder("a.exr"), text, sizeof text);
    if (size != usual_size || memcmp(text, usual, size))
        fail_msg("%s: another picture", what);
}

/* Either the usual picture or an error. Returns whether it was the picture. */
static bool expect_picture_or_line(const char *what, const struct outcome *outcome) {
    if (outcome->code == 0)
        expect_usual_picture(what);
    else
        expect_failure(what, outcome, NULL, NULL);
    expect_tidy(what);
    return outcome->code == 0;
}

static void test_few_files_are_enough_or_an_error(void **state) {
    (void)state;
    int pictures = 0;
    /* What the caller has open counts, too: with the least the dynamic linker can't open a library,
     * and the command doesn't start. */
    for (rlim_t files = 4; files <= 16; files += files < 10 ? 1 : 6) {
        char what[32];
        const struct limit limit = {RLIMIT_NOFILE, files};
        snprintf(what, sizeof what, "%d files", (int)files);
        unlink(in_folder("a.exr"));
        const struct outcome outcome = run_command(RENDER_WHOLE " -o a.exr", NULL, &limit);
        if (outcome.code != NOT_STARTED)
            pictures += expect_picture_or_line(what, &outcome);
    }
    assert_true(pictures > 0); /* 16 suffice */
}

/* OpenMP can't do without its threads and ends the process; its line, not ours, says so. The second
 * thread is ours, which tries whether Embree can have its own: where the system refuses only that,
 * the scheduler of Embree ends the process by SIGABRT. */
static void test_no_more_threads_is_an_error_not_a_hang(void **state) {
    (void)state;
    static const char *const lines[] = {"libgomp: Thread creation failed", "fewray: the system"};
    if (!FAULT_PRELOADS || !count_calls(RENDER_WHOLE " -o a.exr", "parallel", "-"))
        skip();
    for (int i = 1; i <= 2; i++) {
        char rule[64];
        snprintf(rule, sizeof rule, "thread %d - fail %d", i, EAGAIN);
        unlink(in_folder("a.exr"));
        const struct outcome outcome = run_command(RENDER_WHOLE " -o a.exr", rule, NULL);
        expect_tidy(rule);
        if (outcome.code != 1 || !strstr(outcome.messages, lines[i - 1]) ||
            !access(in_folder("a.exr"), F_OK))
            fail_msg("%s: exit %d: %s", rule, outcome.code, outcome.messages);
    }
}

/* 256 KiB; usual are 8 MiB. Stacks of OpenMP's threads go by it, too. */
static void test_small_stack_is_enough(void **state) {
    (void)state;
    const struct limit limit = {RLIMIT_STACK, 256 << 10};
    const struct outcome outcome = run_command(RENDER_WHOLE " -o a.exr", NULL, &limit);
    if (outcome.code)
        fail_msg("exit %d: %s", outcome.code, outcome.messages);
    expect_usual_picture("stack");
}

/* Address space. Libraries that can't even be mapped are reported by the linker or by us. */
static void test_little_memory_is_an_error(void **state) {
    (void)state;
    if (!FAULT_PRELOADS)
        skip(); /* sanitizers reserve terabytes */
    for (int mib = 40; mib <= 440; mib += 80) {
        char what[32];
        const struct limit limit = {RLIMIT_AS, (rlim_t)mib << 20};
        snprintf(what, sizeof what, "%d MiB", mib);
        unlink(in_folder("a.exr"));
        const struct outcome outcome = run_command(RENDER_WHOLE " -o a.exr", NULL, &limit);
        expect_tidy(what);
        if (outcome.code == 0)
            expect_usual_picture(what);
        else if (outcome.code < 0 || !outcome.messages[0] ||
                 (!access(in_folder("a.exr"), F_OK) && !strstr(outcome.messages, "undenoised")))
            fail_msg("%s: exit %d: %s", what, outcome.code, outcome.messages);
    }
}

/* What was rendered is kept, to the bit. */
static void test_denoiser_without_memory_leaves_the_noisy_picture(void **state) {
    (void)state;
    static const char *const channels[] = {"R", "G", "B"};
    const struct outcome outcome =
        run_command(RENDER_WHOLE " --max-memory 4K -o a.exr", NULL, NULL);
    struct fewray_frame *noisy = NULL, *kept = NULL;
    expect_failure("--max-memory 4K", &outcome, NULL, "the picture is written undenoised");
    expect_success(RENDER_WHOLE " --denoise off -o noisy.exr");
    assert_int_equal(fewray_frame_read_exr(in_folder("a.exr"), &kept, NULL), FEWRAY_OK);
    assert_int_equal(fewray_frame_read_exr(in_folder("noisy.exr"), &noisy, NULL), FEWRAY_OK);
    for (int c = 0; c < 3; c++)
        assert_memory_equal(fewray_frame_plane(kept, channels[c]),
                            fewray_frame_plane(noisy, channels[c]),
                            (size_t)noisy->width * (size_t)noisy->height * sizeof(float));
    fewray_frame_destroy(&noisy);
    fewray_frame_destroy(&kept);
}

/* Decimal points stay points, files need no home and no place for temporary ones. */
static void test_environment_changes_nothing(void **state) {
    (void)state;
    static const struct {
        const char *name, *value;
    } cases[] = {
        {"HOME", NULL},          {"TMPDIR", "/nowhere"}, {"PATH", NULL}, {"LC_ALL", "de_DE.UTF-8"},
        {"LC_NUMERIC", "de_DE"}, {"TERM", NULL},
    };
    char stats[2048];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *value = getenv(cases[i].name);
        char *before = value ? strdup(value) : NULL;
        if (cases[i].value)
            setenv(cases[i].name, cases[i].value, 1);
        else
            unsetenv(cases[i].name);
        expect_success(RENDER_WHOLE " -o a.exr --stats a.json");
        if (before)
            setenv(cases[i].name, before, 1);
        else
            unsetenv(cases[i].name);
        free(before);
        expect_usual_picture(cases[i].name);
        read_text(in_folder("a.json"), stats, sizeof stats);
        const char *seconds = strstr(stats, "\"total_s\": ");
        assert_non_null(seconds);
        seconds += strcspn(seconds, "0123456789");
        assert_int_equal(seconds[strspn(seconds, "0123456789")], '.');
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_few_files_are_enough_or_an_error),
        cmocka_unit_test(test_no_more_threads_is_an_error_not_a_hang),
        cmocka_unit_test(test_small_stack_is_enough),
        cmocka_unit_test(test_little_memory_is_an_error),
        cmocka_unit_test(test_denoiser_without_memory_leaves_the_noisy_picture),
        cmocka_unit_test(test_environment_changes_nothing),
    };
    return cmocka_run_group_tests(tests, prepare, remove_folder);
}
