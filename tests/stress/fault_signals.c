/* SPDX-License-Identifier: Apache-2.0 */
/* SIGINT, SIGTERM and SIGHUP in every phase. The signal comes at the n-th parallel region of the
 * command, whose number goes through loading, first look, guide, samples, edges and denoiser, or at
 * the n-th write. Bound of every case: the picture is whole, finite and of the right size, or there
 * is none and the line says so; no temporary file. */

#include "tests/stress/fault_command.h"

#include "fewray/features.h"

#define DONE "interrupted; what was done is written"

enum { SIDE = 16 };

static bool is_there(const char *name) {
    return !access(in_folder(name), F_OK);
}

/* Readable, of the size that was asked for, finite; seen by at least one sample. */
static void expect_picture(const char *what, const char *name) {
    struct fewray_frame *frame = NULL;
    struct fewray_error error;
    if (fewray_frame_read_exr(in_folder(name), &frame, &error))
        fail_msg("%s: %s: %s", what, name, error.what);
    assert_int_equal(frame->width, SIDE);
    assert_int_equal(frame->height, SIDE);
    double sum = 0;
    for (size_t k = 0; k < frame->plane_count; k++)
        for (size_t i = 0; i < (size_t)SIDE * SIDE; i++) {
            if (!isfinite(frame->planes[k].data[i]))
                fail_msg("%s: %s isn't finite", what, frame->planes[k].name);
            sum += fabs((double)frame->planes[k].data[i]);
        }
    if (!(sum > 0))
        fail_msg("%s: %s is empty", what, name);
    fewray_frame_destroy(&frame);
}

/* One run. A signal that comes too late changes nothing. */
static void interrupt(const char *arguments, const char *call, int number, int signal_number,
                      const char *picture) {
    char rule[64], what[512];
    snprintf(rule, sizeof rule, "%s %d - signal %d", call, number, signal_number);
    snprintf(what, sizeof what, "%s: %s", arguments, rule);
    unlink(in_folder(picture));
    const struct outcome outcome = run_command(arguments, rule, NULL);
    /* Of two frames the line tells of the second. */
    const bool written =
        outcome.code == 0 || strstr(outcome.messages, DONE) || strstr(outcome.messages, "frame 2");
    if (outcome.code != 0)
        expect_failure(what, &outcome, NULL, "interrupted; ");
    expect_tidy(what);
    if (is_there(picture) != written)
        fail_msg("%s: exit %d, %s %s: %s", what, outcome.code, picture,
                 written ? "is missing" : "is there", outcome.messages);
    if (written)
        expect_picture(what, picture);
}

static const struct {
    const char *arguments, *picture;
    int points; /* where the signal comes, evenly over the run; all, with FEWRAY_TEST_ALL set */
} RUNS[] = {
    {RENDER_WHOLE " -o a.exr", "a.exr", 8},
    {RENDER_WHOLE " --guide ppg -o a.exr", "a.exr", 3},
    {RENDER_WHOLE " --guide off --frames 1..2 -o a.####.exr", "a.0001.exr", 2},
    {"render " SCENE " --width 16 --threads 2 -o a.exr --denoise off --error 10 --max-spp 4",
     "a.exr", 3},
    {"denoise in.exr -o a.exr", "a.exr", 3},
    {"merge part-1.exr part-2.exr -o a.exr", "a.exr", 3},
};

static void test_signal_in_every_phase_leaves_a_picture_or_says_that_none(void **state) {
    (void)state;
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    const bool all = getenv("FEWRAY_TEST_ALL") != NULL;
    if (!FAULT_PRELOADS)
        skip();
    for (size_t k = 0; k < sizeof RUNS / sizeof *RUNS; k++) {
        const int regions = count_calls(RUNS[k].arguments, "parallel", "-");
        if (!regions)
            skip(); /* another OpenMP than GCC's */
        const int points = all ? regions : RUNS[k].points;
        for (int i = 0; i < points; i++)
            interrupt(RUNS[k].arguments, "parallel",
                      points > 1 ? 1 + i * (regions - 1) / (points - 1) : 1, numbers[i % 3],
                      RUNS[k].picture);
    }
}

/* The work is done: the picture appears. */
static void test_signal_while_writing_leaves_the_whole_picture(void **state) {
    (void)state;
    if (!FAULT_PRELOADS)
        skip();
    interrupt(RENDER_PLAIN " -o a.exr", "write", 3, SIGINT, "a.exr");
    interrupt(RENDER_PLAIN " -o a.exr", "rename", 1, SIGTERM, "a.exr");
    assert_true(is_there("a.exr"));
}

/* A part is for merging: it is whole or not there. */
static void test_interrupted_part_is_not_written(void **state) {
    (void)state;
    if (!FAULT_PRELOADS)
        skip();
    const int regions = count_calls(RENDER_PLAIN " --part 1/2 -o a.exr", "parallel", "-");
    unlink(in_folder("a.exr"));
    const struct outcome outcome =
        run_command(RENDER_PLAIN " --part 1/2 -o a.exr", "parallel 1 - signal 15", NULL);
    if (!regions)
        skip();
    expect_failure("part", &outcome, "a.exr", "whole or not at all");
    assert_false(is_there("a.exr"));
}

/* Two signals, the second at once: the process ends by it, with the old output and no temporary
 * file, even amid writing. */
static void test_second_signal_ends_at_once_and_tidily(void **state) {
    (void)state;
    static const struct {
        const char *arguments, *rule;
    } cases[] = {
        {RENDER_PLAIN " -o a.exr", "parallel 1 - signals 2"},
        {RENDER_PLAIN " -o a.exr", "write 9 .tmp signals 2"},
        {RENDER_PLAIN " -o a.exr --png a.png", "write 30 .tmp signals 2"},
        {"denoise in.exr -o a.exr", "write 9 .tmp signals 2"},
        {"composite in.exr in.exr -o a.exr", "write 1 .tmp signal 2"}, /* the first suffices */
        {"merge part-1.exr part-2.exr -o a.exr", "write 9 .tmp signals 2"},
    };
    char text[32];
    if (!FAULT_PRELOADS)
        skip();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        write_text(in_folder("a.exr"), "old");
        const struct outcome outcome = run_command(cases[i].arguments, cases[i].rule, NULL);
        if (outcome.code != -SIGINT && !strstr(cases[i].rule, "parallel"))
            fail_msg("%s: exit %d", cases[i].rule, outcome.code);
        expect_tidy(cases[i].arguments);
        read_text(in_folder("a.exr"), text, sizeof text);
        if (outcome.code == -SIGINT)
            assert_string_equal(text, "old");
    }
}

/* As nohup does it. */
static void test_ignored_signals_stay_ignored(void **state) {
    (void)state;
    if (!FAULT_PRELOADS)
        skip();
    signal(SIGHUP, SIG_IGN);
    const struct outcome outcome =
        run_command(RENDER_PLAIN " -o a.exr", "write 1 .tmp signals 1", NULL);
    signal(SIGHUP, SIG_DFL);
    assert_int_equal(outcome.code, 0);
    expect_picture("nohup", "a.exr");
}

/* A bench keeps the rows it has; none here, and says so. */
static void test_interrupted_bench_says_what_it_leaves(void **state) {
    (void)state;
    if (!FAULT_PRELOADS || !count_calls(RENDER_PLAIN " -o a.exr", "parallel", "-"))
        skip();
    const struct outcome outcome =
        run_command("bench " SCENE " --reference in.exr -o bench --spp 1 --seeds 1",
                    "parallel 2 - signal 2", NULL);
    expect_failure("bench", &outcome, "cornell-box.xml", "interrupted; nothing was done yet");
}

/* Nobody reads what is printed: an error like any other, not a death. */
static void test_closed_pipe_is_an_error_with_a_line(void **state) {
    (void)state;
    int ends[2], before = dup(STDOUT_FILENO);
    assert_true(before >= 0 && !pipe(ends));
    close(ends[0]);
    fflush(stdout);
    dup2(ends[1], STDOUT_FILENO);
    close(ends[1]);
    const int status = system(FEWRAY_COMMAND " info " SCENE " 2> err-pipe.txt");
    dup2(before, STDOUT_FILENO);
    close(before);
    char text[256];
    read_text("err-pipe.txt", text, sizeof text);
    unlink("err-pipe.txt");
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 1);
    assert_string_equal(text, "fewray: stdout: can't be written: Broken pipe\n");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_signal_in_every_phase_leaves_a_picture_or_says_that_none),
        cmocka_unit_test(test_signal_while_writing_leaves_the_whole_picture),
        cmocka_unit_test(test_interrupted_part_is_not_written),
        cmocka_unit_test(test_second_signal_ends_at_once_and_tidily),
        cmocka_unit_test(test_ignored_signals_stay_ignored),
        cmocka_unit_test(test_interrupted_bench_says_what_it_leaves),
        cmocka_unit_test(test_closed_pipe_is_an_error_with_a_line),
    };
    return cmocka_run_group_tests(tests, make_inputs, remove_folder);
}
