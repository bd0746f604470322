/* SPDX-License-Identifier: Apache-2.0 */
/* What a bench makes of its rows: ticks of logarithmic axes, curves, medians. */

#include <stdio.h>
#include <string.h>

#include "check.h"
#include "pipeline/axis.h"
#include "pipeline/bench.h"
#include "pipeline/curve.h"

/* The labels of an axis with spaces between. */
static const char *labels_of(double least, double most, int room) {
    static char text[512];
    struct axis_tick ticks[AXIS_TICKS_MAX];
    const struct axis axis = {least, most};
    const int count = axis_ticks(axis, room, ticks);
    text[0] = 0;
    for (int i = 0; i < count; i++) {
        assert_true(i == 0 || ticks[i].value > ticks[i - 1].value);
        assert_in_range((int)(1e6 * axis_place(axis, ticks[i].value) + 1), 0, 1000001);
        if (ticks[i].label[0]) {
            strcat(text, text[0] ? " " : "");
            strcat(text, ticks[i].label);
        }
    }
    return text;
}

static void test_axis_labels_are_as_dense_as_fits(void **state) {
    (void)state;
    assert_string_equal(labels_of(0.09, 11, 8), "0.1 0.2 0.5 1 2 5 10");
    assert_string_equal(labels_of(0.09, 11, 6), "0.1 1 10");
    assert_string_equal(labels_of(1e-6, 1e6, 7), "1e-06 0.0001 0.01 1 100 10000 1e+06");
    assert_string_equal(labels_of(1e-6, 1e6, 6), "1e-06 0.001 1 1000 1e+06");
    assert_string_equal(labels_of(0.1, 1, 9), "0.1 0.2 0.5 1"); /* both ends have theirs */
    assert_string_equal(labels_of(3, 4.5, 9), "");              /* nothing round in between */
    labels_of(1e-300, 1e300, 9); /* not more ticks than there can be */
}

static void test_small_ticks_stand_at_every_digit(void **state) {
    (void)state;
    struct axis_tick ticks[AXIS_TICKS_MAX];
    assert_int_equal(axis_ticks((struct axis){0.1, 10}, 9, ticks), 19);
    assert_near(ticks[7].value, 0.8, 1e-12);
    assert_string_equal(ticks[7].label, "");
}

static void test_axis_has_room_around_its_values(void **state) {
    (void)state;
    const struct axis wide = axis_around(0.1, 10), one = axis_around(3, 3);
    assert_true(axis_place(wide, 0.1) > 0.02 && axis_place(wide, 10) < 0.98);
    assert_near(axis_place(wide, 1), 0.5, 1e-12);
    assert_near(axis_place(one, 3), 0.5, 1e-12);
    assert_true(one.most / one.least >= 2 * (1 - 1e-12));
}

/* Error falls as the square root of time: what a curve of two points must give between them. */
static void test_curves_follow_power_laws(void **state) {
    (void)state;
    struct curve curve = {0};
    curve_add(&curve, 4, 0.5);
    curve_add(&curve, 1, 1); /* in any order */
    assert_near(curve_error_at(&curve, 2), 1 / sqrt(2), 1e-12);
    assert_near(curve_error_at(&curve, 1), 1, 0);
    assert_near(curve_seconds_to(&curve, 0.8), 1 / 0.64, 1e-12);
    assert_near(curve_seconds_to(&curve, 3), 1, 0); /* the first point is as good already */
}

static void test_curves_tell_nothing_beyond_their_points(void **state) {
    (void)state;
    struct curve curve = {0};
    assert_true(isnan(curve_error_at(&curve, 1)) && isnan(curve_seconds_to(&curve, 1)));
    curve_add(&curve, 1, 1);
    curve_add(&curve, 4, 0.5);
    curve_add(&curve, 8, -0.1); /* below the reference's noise */
    curve_add(&curve, NAN, 0.1);
    assert_int_equal(curve.count, 2);
    assert_true(isnan(curve_error_at(&curve, 0.99)) && isnan(curve_error_at(&curve, 4.01)));
    assert_true(isnan(curve_seconds_to(&curve, 0.49)));
}

static struct bench_row make_row(enum bench_method method, int spp, double seconds, double error) {
    return (struct bench_row){.method = method,
                              .spp = spp,
                              .work_s = seconds,
                              .wall_s = method == BENCH_MITSUBA ? NAN : 2 * seconds,
                              .guide = "off",
                              .metrics = {.mrse = error, .flip = error / 2}};
}

static void test_points_are_medians_and_least_times(void **state) {
    (void)state;
    struct bench_row rows[] = {
        make_row(BENCH_MITSUBA, 4, 3, 7), make_row(BENCH_PT, 4, 1.2, 5),
        make_row(BENCH_PT, 1, 0.5, 9),    make_row(BENCH_PT, 4, 1.0, 1),
        make_row(BENCH_PT, 4, 1.1, 2),    make_row(BENCH_MITSUBA, 4, 2, 8),
    };
    struct bench bench = {.settings = {.spp = {1, 4}, .spp_count = 2}, .rows = rows};
    bench.row_count = sizeof rows / sizeof *rows;
    bench_summarize(&bench);
    assert_int_equal(bench.point_count, 3);
    const struct bench_point *point = &bench.points[1];
    assert_true(point->method == BENCH_PT && point->spp == 4 && point->rows == 3);
    assert_true(point->work_s == 1.0 && point->wall_s == 2.0);
    assert_true(point->errors[BENCH_MRSE].median == 2 && point->errors[BENCH_MRSE].least == 1 &&
                point->errors[BENCH_MRSE].most == 5);
    assert_true(point->errors[BENCH_FLIP].median == 1);
    assert_true(bench.points[2].errors[BENCH_MRSE].median == 7.5); /* of an even number: between */
    assert_true(isnan(bench.points[2].wall_s));
    assert_true(bench_has_points(&bench, BENCH_MITSUBA) && !bench_has_points(&bench, BENCH_GUIDED));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_axis_labels_are_as_dense_as_fits),
        cmocka_unit_test(test_small_ticks_stand_at_every_digit),
        cmocka_unit_test(test_axis_has_room_around_its_values),
        cmocka_unit_test(test_curves_follow_power_laws),
        cmocka_unit_test(test_curves_tell_nothing_beyond_their_points),
        cmocka_unit_test(test_points_are_medians_and_least_times),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
