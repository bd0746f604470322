/* SPDX-License-Identifier: Apache-2.0 */
/* A disk that is full, limits of file sizes, renames that fail. Bound of every case:
 * exit code 1, one line that names an output and the reason, every old output the same byte by
 * byte, no temporary file. */

#include "tests/stress/fault_command.h"

#include <errno.h>

#define OLD "what was there before\n"

/* Commands and the outputs of each. */
static const struct {
    const char *arguments;
    const char *outputs[4];
} COMMANDS[] = {
    {RENDER_PLAIN " -o a.exr --png a.png --stats a.json", {"a.exr", "a.png", "a.json"}},
    {RENDER_PLAIN " --part 1/2 -o a.exr", {"a.exr"}},
    {RENDER_PLAIN " --frames 3 -o a.####.exr", {"a.0003.exr"}},
    {"merge part-1.exr part-2.exr -o a.exr --png a.png", {"a.exr", "a.png"}},
    {"denoise in.exr -o a.exr --png a.png --stats a.json", {"a.exr", "a.png", "a.json"}},
    {"composite in.exr in.exr in.exr -o a.png", {"a.png"}},
    {"report pictures -o a.html", {"a.html"}},
};
enum { COMMAND_COUNT = sizeof COMMANDS / sizeof *COMMANDS, OUTPUT_MAX = 4 };

static void put_old(int command) {
    for (int i = 0; i < OUTPUT_MAX && COMMANDS[command].outputs[i]; i++)
        write_text(in_folder(COMMANDS[command].outputs[i]), OLD);
}

static void expect_old(const char *what, int command) {
    char text[64];
    for (int i = 0; i < OUTPUT_MAX && COMMANDS[command].outputs[i]; i++) {
        read_text(in_folder(COMMANDS[command].outputs[i]), text, sizeof text);
        if (strcmp(text, OLD))
            fail_msg("%s: %s isn't what it was", what, COMMANDS[command].outputs[i]);
    }
}

/* The file's name in the line must be one of the outputs. */
static void expect_undone(const char *what, int command, const struct outcome *outcome,
                          const char *reason) {
    bool named = false;
    for (int i = 0; i < OUTPUT_MAX && COMMANDS[command].outputs[i]; i++)
        named = named || strstr(outcome->messages, COMMANDS[command].outputs[i]);
    if (!named)
        fail_msg("%s: no output is named: %s", what, outcome->messages);
    expect_failure(what, outcome, NULL, reason);
    expect_old(what, command);
}

static void break_call(int command, const char *call, int first, int code) {
    char rule[64], what[256];
    snprintf(rule, sizeof rule, "%s %d .tmp fail %d", call, first, code);
    snprintf(what, sizeof what, "%s: %s", COMMANDS[command].arguments, rule);
    put_old(command);
    const struct outcome outcome = run_command(COMMANDS[command].arguments, rule, NULL);
    expect_undone(what, command, &outcome, strerror(code));
}

/* The disk is full from the first write on, from the second, from half of them, and at the last. */
static void test_full_disk_leaves_every_old_output(void **state) {
    (void)state;
    if (!FAULT_PRELOADS)
        skip();
    for (int k = 0; k < COMMAND_COUNT; k++) {
        const int writes = count_calls(COMMANDS[k].arguments, "write", ".tmp");
        assert_true(writes > 0);
        const int first[] = {1, 2, writes / 2, writes};
        for (int i = 0; i < 4; i++)
            if (first[i] > 0 && first[i] <= writes && (i == 0 || first[i] > first[i - 1]))
                break_call(k, "write", first[i], ENOSPC);
    }
}

/* Network file systems tell of a full disk, or of a broken one, only at close(). */
static void test_failing_close_leaves_every_old_output(void **state) {
    (void)state;
    if (!FAULT_PRELOADS)
        skip();
    for (int k = 0; k < COMMAND_COUNT; k++)
        break_call(k, "close", 1, EDQUOT);
}

/* LLVM's OpenMP library writes a file before main() has a say in what that signals. */
#ifdef __clang__
#define LIBOMP true
#else
#define LIBOMP false
#endif

/* No file may be larger than 0, 1 or 400 bytes: any output fails at its beginning or within; only
 * in the last case the line on stderr, a file too, has room. */
static void test_file_size_limit_leaves_every_old_output(void **state) {
    (void)state;
    if (LIBOMP)
        skip();
    static const rlim_t sizes[] = {0, 1, 400};
    for (int k = 0; k < COMMAND_COUNT; k++)
        for (int i = k % 2; i < 3; i += 2 - k % 2) {
            const struct limit limit = {RLIMIT_FSIZE, sizes[i]};
            put_old(k);
            const struct outcome outcome = run_command(COMMANDS[k].arguments, NULL, &limit);
            if (sizes[i] == 400)
                expect_undone(COMMANDS[k].arguments, k, &outcome, strerror(EFBIG));
            assert_int_equal(outcome.code, 1);
            expect_tidy(COMMANDS[k].arguments);
            expect_old(COMMANDS[k].arguments, k);
        }
}

/* A rename that fails takes the outputs renamed before it back. */
static void test_failing_rename_leaves_every_old_output(void **state) {
    (void)state;
    if (!FAULT_PRELOADS)
        skip();
    for (int k = 0; k < COMMAND_COUNT; k++)
        for (int i = 0; i < OUTPUT_MAX && COMMANDS[k].outputs[i]; i++) {
            char rule[64];
            snprintf(rule, sizeof rule, "rename 1 %s fail %d", COMMANDS[k].outputs[i], EACCES);
            put_old(k);
            const struct outcome outcome = run_command(COMMANDS[k].arguments, rule, NULL);
            expect_undone(rule, k, &outcome, strerror(EACCES));
            expect_failure(rule, &outcome, COMMANDS[k].outputs[i], NULL);
        }
}

static void test_failing_rename_leaves_no_output_where_none_was(void **state) {
    (void)state;
    if (!FAULT_PRELOADS)
        skip();
    unlink(in_folder("a.exr"));
    unlink(in_folder("a.png"));
    unlink(in_folder("a.json"));
    const struct outcome outcome = run_command(RENDER_PLAIN " -o a.exr --png a.png --stats a.json",
                                               "rename 1 a.json fail 13", NULL);
    expect_failure("rename", &outcome, "a.json", strerror(EACCES));
    assert_true(access(in_folder("a.exr"), F_OK) && access(in_folder("a.png"), F_OK) &&
                access(in_folder("a.json"), F_OK));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_full_disk_leaves_every_old_output),
        cmocka_unit_test(test_failing_close_leaves_every_old_output),
        cmocka_unit_test(test_file_size_limit_leaves_every_old_output),
        cmocka_unit_test(test_failing_rename_leaves_every_old_output),
        cmocka_unit_test(test_failing_rename_leaves_no_output_where_none_was),
    };
    return cmocka_run_group_tests(tests, make_inputs, remove_folder);
}
