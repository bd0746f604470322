/* SPDX-License-Identifier: Apache-2.0 */
/* Command lines: what is taken, and what is refused to the last character. */

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "pipeline/options.h"

static const char *const SWITCH[] = {"off", "on", NULL};

struct values {
    int count, choice;
    float share;
    bool flag;
    uint64_t seed;
    size_t size;
    double time;
    const char *text;
    struct text_list list;
};

static enum parse_result parse(struct values *values, int *first_file,
                               const char *const *arguments) {
    const struct option_spec specs[] = {
        {"count", 'c', OPTION_INT, &values->count, "N", "", 1, 64, NULL},
        {"share", 0, OPTION_FLOAT, &values->share, "F", "", 0, 1, NULL},
        {"choice", 0, OPTION_CHOICE, &values->choice, NULL, "", 0, 0, SWITCH},
        {"flag", 0, OPTION_FLAG, &values->flag, NULL, "", 0, 0, NULL},
        {"seed", 0, OPTION_SEED, &values->seed, "S", "", 0, 0, NULL},
        {"size", 0, OPTION_SIZE, &values->size, "SIZE", "", 0, 0, NULL},
        {"time", 0, OPTION_TIME, &values->time, "T", "", 0, 0, NULL},
        {"text", 0, OPTION_TEXT, &values->text, "T", "", 0, 0, NULL},
        {"define", 'D', OPTION_DEFINE, &values->list, "NAME=VALUE", "", 0, 0, NULL},
        {0},
    };
    const struct command_line line = {"test", "FILE", "", specs, 1, 1};
    char *argv[16] = {"test"};
    int argc = 1;
    for (; arguments[argc - 1]; argc++)
        argv[argc] = (char *)arguments[argc - 1];
    return parse_command_line(&line, argc, argv, first_file);
}

#define ARGUMENTS(...) ((const char *const[]){__VA_ARGS__, NULL})

static void test_every_kind_of_option_is_read(void **state) {
    (void)state;
    struct values values = {0};
    int first_file = 0;
    assert_int_equal(
        parse(&values, &first_file,
              ARGUMENTS("-c", "64", "file", "--share=0.25", "--choice", "on", "--flag", "--seed",
                        "18446744073709551615", "--text", "-x", "-Da=1", "-D", "b=")),
        PARSE_OK);
    assert_int_equal(values.count, 64);
    assert_true(values.share == 0.25f);
    assert_int_equal(values.choice, 1);
    assert_true(values.flag);
    assert_true(values.seed == UINT64_MAX);
    assert_string_equal(values.text, "-x");
    assert_int_equal(values.list.count, 2);
    assert_string_equal(values.list.items[1], "b=");
}

static void test_sizes_have_units(void **state) {
    (void)state;
    static const struct {
        const char *text;
        size_t bytes;
    } sizes[] = {
        {"12345", 12345}, {"3K", 3072}, {"512M", (size_t)512 << 20}, {"2g", (size_t)2 << 30}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        struct values values = {0};
        int first_file;
        assert_int_equal(parse(&values, &first_file, ARGUMENTS("--size", sizes[i].text, "file")),
                         PARSE_OK);
        assert_int_equal(values.size, sizes[i].bytes);
    }
}

static void test_times_have_units(void **state) {
    (void)state;
    static const struct {
        const char *text;
        double seconds;
    } times[] = {{"500ms", 0.5}, {"5s", 5}, {"2m", 120}, {"7", 7}, {"0.25", 0.25}, {"1.5m", 90}};
    for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
        struct values values = {0};
        int first_file;
        assert_int_equal(parse(&values, &first_file, ARGUMENTS("--time", times[i].text, "file")),
                         PARSE_OK);
        assert_true(fabs(values.time - times[i].seconds) < 1e-12);
    }
}

static void test_wrong_values_are_refused(void **state) {
    (void)state;
    static const char *const wrong[][2] = {
        {"--count", "0"},
        {"--count", "65"},
        {"--count", "4x"},
        {"--count", ""},
        {"--count", " 4"},
        {"--count", "0.5"},
        {"--count", "four"},
        {"--count", "99999999999999999999"},
        {"--share", "nan"},
        {"--share", "1.01"},
        {"--share", "-1"},
        {"--share", "0,5"},
        {"--choice", "ON"},
        {"--choice", ""},
        {"--seed", "-1"},
        {"--seed", "1e3"},
        {"--seed", "18446744073709551616"},
        {"--size", ""},
        {"--size", "0"},
        {"--size", "M"},
        {"--size", "-1M"},
        {"--size", "1.5G"},
        {"--size", "1T"},
        {"--size", "1MB"},
        {"--size", " 1M"},
        {"--size", "17179869184G"},
        {"--size", "99999999999999999999"},
        {"--time", ""},
        {"--time", "0"},
        {"--time", "-1s"},
        {"--time", "5 s"},
        {"--time", " 5s"},
        {"--time", "s"},
        {"--time", "5h"},
        {"--time", "5ss"},
        {"--time", "nan"},
        {"--time", "0x5"},
        {"--time", "1e300"},
        {"--text", ""},
        {"-D", "novalue"},
        {"-D", "=value"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct values values = {0};
        int first_file;
        if (parse(&values, &first_file, ARGUMENTS(wrong[i][0], wrong[i][1], "file")) != PARSE_WRONG)
            fail_msg("%s '%s' was taken", wrong[i][0], wrong[i][1]);
    }
}

static void test_wrong_shapes_of_a_command_line_are_refused(void **state) {
    (void)state;
    struct values values = {0};
    int first_file;
    assert_int_equal(parse(&values, &first_file, ARGUMENTS("--count", "1")), PARSE_WRONG);
    assert_int_equal(parse(&values, &first_file, ARGUMENTS("one", "two")), PARSE_WRONG);
    assert_int_equal(parse(&values, &first_file, ARGUMENTS("file", "--count")), PARSE_WRONG);
    assert_int_equal(parse(&values, &first_file, ARGUMENTS("file", "--flag=1")), PARSE_WRONG);
    assert_int_equal(parse(&values, &first_file, ARGUMENTS("file", "--frobnicate")), PARSE_WRONG);
    assert_int_equal(parse(&values, &first_file, ARGUMENTS("file", "-z")), PARSE_WRONG);
}

static void test_help_is_no_error(void **state) {
    (void)state;
    struct values values = {0};
    int first_file;
    assert_int_equal(parse(&values, &first_file, ARGUMENTS("--help")), PARSE_HELP);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_kind_of_option_is_read),
        cmocka_unit_test(test_sizes_have_units),
        cmocka_unit_test(test_times_have_units),
        cmocka_unit_test(test_wrong_values_are_refused),
        cmocka_unit_test(test_wrong_shapes_of_a_command_line_are_refused),
        cmocka_unit_test(test_help_is_no_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
