/* SPDX-License-Identifier: Apache-2.0 */
/* Outputs that can't be where they are wanted, or are the inputs; processes killed while they
 * write. Bound of every case: exit code 1, one line that names the output and the reason, old files
 * the same byte by byte, no temporary file. */

#include "tests/stress/fault_command.h"

#include <errno.h>

#define OLD "what was there before\n"

/* Of benches, CSV, JSON and plot are whole, each by itself. */
static void test_bench_on_a_full_disk_leaves_whole_files(void **state) {
    (void)state;
    static const char *const arguments =
        "bench " SCENE " --reference in.exr -o bench --spp 1 --seeds 1";
    static const char *const faults[] = {"write 1 .tmp fail 28", "write 2 .tmp fail 28",
                                         "rename 1 bench.png fail 28"};
    if (!FAULT_PRELOADS)
        skip();
    for (int i = 0; i < 3; i++) {
        const struct outcome outcome = run_command(arguments, faults[i], NULL);
        expect_failure(faults[i], &outcome, "bench/bench.", strerror(ENOSPC));
    }
    DIR *entries = opendir(in_folder("bench"));
    assert_non_null(entries);
    for (struct dirent *entry; (entry = readdir(entries));)
        assert_true(strncmp(entry->d_name, ".fewray", 7));
    closedir(entries);
}

/* Targets that can't be: known before the work begins. */
static void test_impossible_targets_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *arguments, *fault, *named, *reason;
    } cases[] = {
        {RENDER_PLAIN " -o none/a.exr", NULL, "none/a.exr", "No such file"},
        {RENDER_PLAIN " -o dir", NULL, "dir", "regular file"},
        {RENDER_PLAIN " -o /dev/null", NULL, "/dev/null", "regular file"},
        {RENDER_PLAIN " -o in.exr/a.exr", NULL, "in.exr/a.exr", "Not a directory"},
        {RENDER_PLAIN " -o a.exr --stats dir", NULL, "dir", "regular file"},
        {RENDER_PLAIN " -o a.exr", "open 1 .tmp fail 30", "a.exr", "Read-only file system"},
        {RENDER_PLAIN " -o a.exr", "open 1 .tmp fail 13", "a.exr", "Permission denied"},
        {"denoise in.exr -o dir", NULL, "dir", "regular file"},
        {"denoise in.exr -o none/a.exr", NULL, "none/a.exr", "No such file"},
        {"denoise in.exr -o a.exr", "open 1 .tmp fail 30", "a.exr", "Read-only file system"},
        {"merge part-1.exr part-2.exr -o dir", NULL, "dir", "regular file"},
        {"composite in.exr in.exr -o dir", NULL, "dir", "regular file"},
        {"composite in.exr in.exr -o none/a.png", NULL, "none/a.png", "No such file"},
        {"composite in.exr in.exr -o a.png", "open 1 .tmp fail 30", "a.png", "Read-only"},
        {"report pictures -o dir", NULL, "dir", "regular file"},
        {"report pictures -o none/a.html", NULL, "none/a.html", "No such file"},
        {"report in.exr -o a.html", NULL, "in.exr", "Not a directory"},
        {"bench " SCENE " --reference in.exr -o in.exr", NULL, "in.exr", "Not a directory"},
        {"bench " SCENE " --reference in.exr -o csv", NULL, "csv/bench.csv", "regular file"},
    };
    mkdir(in_folder("dir"), 0777);
    mkdir(in_folder("csv"), 0777);
    mkdir(in_folder("csv/bench.csv"), 0777);
    unlink(in_folder("a.exr"));
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        if (cases[i].fault && !FAULT_PRELOADS)
            continue;
        const struct outcome outcome = run_command(cases[i].arguments, cases[i].fault, NULL);
        expect_failure(cases[i].arguments, &outcome, cases[i].named, cases[i].reason);
        assert_true(access(in_folder("a.exr"), F_OK));
    }
}

/* The input is the output: it changes as a whole, or stays. */
static void test_denoising_in_place_keeps_the_input_until_the_end(void **state) {
    (void)state;
    static char before[1 << 18], after[1 << 18];
    const size_t size = read_text(in_folder("in.exr"), before, sizeof before);
    static const char *const faults[] = {"write 1 .tmp fail 28", "write 9 .tmp fail 28",
                                         "rename 1 in.exr fail 28"};
    for (int i = 0; i < 3 && FAULT_PRELOADS; i++) {
        const struct outcome outcome = run_command("denoise in.exr -o in.exr", faults[i], NULL);
        expect_failure(faults[i], &outcome, "in.exr", strerror(ENOSPC));
        assert_int_equal(read_text(in_folder("in.exr"), after, sizeof after), size);
        assert_memory_equal(before, after, size);
    }
    expect_success("denoise in.exr -o other.exr");
    expect_success("denoise in.exr -o in.exr");
    const size_t other = read_text(in_folder("other.exr"), before, sizeof before);
    assert_int_equal(read_text(in_folder("in.exr"), after, sizeof after), other);
    assert_memory_equal(before, after, other);
}

/* SIGKILL within the write: the old output stays, what is left disturbs no later run. */
static void test_killed_process_leaves_the_old_output(void **state) {
    (void)state;
    char text[64];
    if (!FAULT_PRELOADS)
        skip();
    write_text(in_folder("a.exr"), OLD);
    const struct outcome outcome =
        run_command(RENDER_PLAIN " -o a.exr", "write 20 .tmp signal 9", NULL);
    assert_int_equal(outcome.code, -SIGKILL);
    read_text(in_folder("a.exr"), text, sizeof text);
    assert_string_equal(text, OLD);
    const struct outcome again = run_command(RENDER_PLAIN " -o a.exr", NULL, NULL);
    assert_int_equal(again.code, 0);
    const struct outcome whole = run_command("info a.exr", NULL, NULL);
    assert_int_equal(whole.code, 0);
}

/* A preview is replaced while the picture is made, always by a whole one. */
static void test_preview_on_a_full_disk_is_old_or_whole(void **state) {
    (void)state;
    static char text[1 << 16];
    static const char *const faults[] = {"write 1 .tmp fail 28", "write 2 .tmp fail 28",
                                         "rename 1 p.png fail 28"};
    if (!FAULT_PRELOADS)
        skip();
    for (int i = 0; i < 3; i++) {
        write_text(in_folder("p.png"), OLD);
        const struct outcome outcome =
            run_command(RENDER_PLAIN " -o b.exr --preview p.png", faults[i], NULL);
        expect_failure(faults[i], &outcome, NULL, strerror(ENOSPC));
        const size_t size = read_text(in_folder("p.png"), text, sizeof text);
        if (strcmp(text, OLD)) /* a PNG ends with an empty chunk, its name and checksum */
            assert_true(size > 8 && !memcmp(text + size - 8, "IEND", 4));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bench_on_a_full_disk_leaves_whole_files),
        cmocka_unit_test(test_impossible_targets_are_refused),
        cmocka_unit_test(test_denoising_in_place_keeps_the_input_until_the_end),
        cmocka_unit_test(test_preview_on_a_full_disk_is_old_or_whole),
        /* The last one: it leaves a temporary file. */
        cmocka_unit_test(test_killed_process_leaves_the_old_output),
    };
    return cmocka_run_group_tests(tests, make_inputs, remove_folder);
}
