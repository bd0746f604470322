/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers of frames on the command line and in files' names. */

#include "tests/unit/check.h"

#include <string.h>

#include "pipeline/frames.h"

static void test_ranges(void **state) {
    (void)state;
    static const struct {
        const char *text;
        int first, last, step, count;
    } good[] = {{"7", 7, 7, 1, 1},         {"0", 0, 0, 1, 1},      {"1..48", 1, 48, 1, 48},
                {"1..48x2", 1, 48, 2, 24}, {"1..4x5", 1, 4, 5, 1}, {"0012..0013", 12, 13, 1, 2}};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) {
        struct fewray_frames f;
        assert_true(frames_parse(good[i].text, &f));
        assert_int_equal(f.first, good[i].first);
        assert_int_equal(f.last, good[i].last);
        assert_int_equal(f.step, good[i].step);
        assert_int_equal(frames_count(&f), good[i].count);
    }
    static const char *const bad[] = {
        "",     "x",      "-1",    "1..",     "1...3",
        "3..1", "1..4x0", "1..4x", "1..4x-1", "1..4x2,7",
        " 1",   "1 ",     "1.5",   "7x2",     "1..99999999999999999999"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        struct fewray_frames f;
        if (frames_parse(bad[i], &f))
            fail_msg("'%s' was taken", bad[i]);
    }
}

static void test_names(void **state) {
    (void)state;
    static const struct {
        const char *pattern;
        int frame;
        const char *name;
    } cases[] = {{"shot.####.exr", 7, "shot.0007.exr"}, {"#", 12, "12"},
                 {"a/b.%04d.exr", 12, "a/b.0012.exr"},  {"b%d", 3, "b3"},
                 {"s.##.exr", 1234, "s.1234.exr"},      {"still.exr", 5, "still.exr"},
                 {"100%.####.exr", 5, "100%.0005.exr"}, {"%s.####", 5, "%s.0005"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char *name = frames_name(cases[i].pattern, cases[i].frame);
        assert_string_equal(name, cases[i].name);
        free(name);
    }
    assert_true(frames_name_has_place("shot.####.exr"));
    assert_true(frames_name_has_place("shot.%04d.exr"));
    static const char *const none[] = {"shot.exr", "a.##.##.exr", "a.##.%04d.exr",
                                       "%04x",     "%99999d",     "a.##########.exr"};
    for (size_t i = 0; i < sizeof none / sizeof *none; i++)
        if (frames_name_has_place(none[i]))
            fail_msg("'%s' was taken", none[i]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ranges),
        cmocka_unit_test(test_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
