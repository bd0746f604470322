/* SPDX-License-Identifier: Apache-2.0 */
/* Time left of a whole run, on made-up clocks, and the line that tells it. */

#include "tests/unit/check.h"

#include <string.h>

#include "pipeline/estimate.h"
#include "pipeline/progress.h"

enum { OTHER, TRACING };

/* Steps that a phase reports, as tiles do. */
#define STEPS 50

static const struct estimate_phase phases[] = {{"load", OTHER, 0},      {"look", TRACING, 1},
                                               {"guide", OTHER, 0.5},   {"render", TRACING, 7},
                                               {"edges", TRACING, 0.5}, {"write", OTHER, 1}};
enum { PHASES = sizeof phases / sizeof *phases };

/* What a run showed. */
struct seen {
    double last_fraction, largest_fall; /* of the fraction */
    double worst_left;                  /* |told - true| / true seconds left, from `after` on */
    double largest_jump;                /* of the expected end between two updates, seconds */
    double end;
    int told;
};

/* Runs all phases, the k-th in took[k] seconds; rates are judged after `after` seconds. */
static struct seen run(struct estimate *e, const double took[PHASES], double after) {
    struct seen seen = {0};
    double all = 0, now = 1000, end = 0;
    for (int k = 0; k < PHASES; k++)
        all += took[k];
    end = now + all;
    estimate_start(e, phases, PHASES, now);
    for (int k = 0; k < PHASES; k++)
        for (int step = 0; step <= STEPS; step++) {
            now += step ? took[k] / STEPS : 0;
            estimate_update(e, phases[k].name, (double)step / STEPS, now);
            const double fraction = estimate_fraction(e), left = estimate_left(e);
            assert_true(fraction >= 0 && fraction <= 1);
            seen.largest_fall = fmax(seen.largest_fall, seen.last_fraction - fraction);
            seen.last_fraction = fraction;
            if (left < 0)
                continue;
            if (seen.told++)
                seen.largest_jump = fmax(seen.largest_jump, fabs(now + left - seen.end));
            seen.end = now + left;
            if (all - (end - now) >= after && end - now > 0.05 * all)
                seen.worst_left = fmax(seen.worst_left, fabs(left / (end - now) - 1));
        }
    return seen;
}

static void test_right_expectations_count_down_like_a_clock(void **state) {
    (void)state;
    static const double took[PHASES] = {0, 1, 0.5, 7, 0.5, 1};
    struct estimate e;
    const struct seen seen = run(&e, took, 0.3);
    assert_true(seen.worst_left < 1e-9);
    assert_true(seen.largest_jump < 1e-9);
    assert_near(seen.last_fraction, 1, 1e-9);
    assert_near(estimate_left(&e), 0, 1e-9);
}

static void test_the_first_phase_corrects_the_later_ones_of_its_kind(void **state) {
    (void)state;
    /* The scene is six times as slow to trace, and took long to load. */
    static const double took[PHASES] = {5, 6, 0.5, 42, 3, 1};
    struct estimate e;
    const struct seen seen = run(&e, took, 6.5); /* a quarter of the look */
    assert_true(seen.worst_left < 0.15);
    assert_near(seen.last_fraction, 1, 1e-9);
}

static void test_the_fraction_never_falls_and_the_end_is_never_doubled_at_once(void **state) {
    (void)state;
    /* Guided samples take three times what the look promised; edges are left out. */
    static const double took[PHASES] = {0.1, 1, 0.5, 21, 0, 4};
    struct estimate e;
    const struct seen seen = run(&e, took, 0);
    assert_true(seen.largest_fall == 0);
    assert_true(seen.largest_jump < 0.15 * 26);
    assert_true(seen.told > 4 * STEPS);
    assert_near(seen.last_fraction, 1, 1e-9);
}

static void test_nothing_is_told_before_something_is_measured(void **state) {
    (void)state;
    struct estimate e;
    estimate_start(&e, phases, PHASES, 0);
    estimate_update(&e, "load", 0, 3);
    assert_true(estimate_left(&e) < 0 && estimate_fraction(&e) == 0);
    estimate_update(&e, "look", 0, 3);
    estimate_update(&e, "look", 0.01, 3.01);
    assert_true(estimate_left(&e) < 0);
    estimate_update(&e, "look", 0.5, 3.5);
    assert_near(estimate_left(&e), 9.5, 1e-6);
    assert_near(estimate_fraction(&e), 3.5 / 13, 1e-6);
    estimate_update(&e, "no such phase", 0.9, 3.6);
    estimate_update(&e, "load", 0.9, 3.6); /* over */
    assert_near(estimate_left(&e), 9.5, 1e-6);
}

static void test_what_is_learnt_of_coming_phases_counts(void **state) {
    (void)state;
    struct estimate e;
    estimate_start(&e, phases, PHASES, 0);
    estimate_expect(&e, "render", 3);
    estimate_expect(&e, "guide", 0);
    estimate_update(&e, "look", 0, 0);
    estimate_update(&e, "look", 0.5, 0.5);
    estimate_expect(&e, "look", 100); /* has begun */
    estimate_update(&e, "look", 0.5, 0.5);
    assert_near(estimate_left(&e), 0.5 + 3 + 0.5 + 1, 1e-6);
}

static void test_previews_do_not_slow_a_phase(void **state) {
    (void)state;
    struct estimate e;
    estimate_start(&e, phases, PHASES, 0);
    estimate_update(&e, "look", 0, 0);
    estimate_except(&e, 0.5);
    estimate_update(&e, "look", 0.5, 1); /* half a second of work, half a one of preview */
    assert_near(estimate_left(&e), 9.5, 1e-6);
}

static void expect_line(double fraction, double left, int columns, const char *expected) {
    char line[256];
    const struct fewray_progress now = {"render", fraction, left};
    progress_line(&now, columns, line, sizeof line);
    assert_string_equal(line, expected);
}

static void test_the_line_fits_into_the_terminal(void **state) {
    (void)state;
    expect_line(0.12, 8.4, 80, "[###...........................]  12 %  render  8.4 s left");
    expect_line(0.12, 8.4, 50, "[#.........]  12 %  render  8.4 s left");
    expect_line(0.12, 119, 50, "[#.........]  12 %  render  119 s left");
    expect_line(0.12, 8.4, 47, " 12 %  render  8.4 s left");
    expect_line(0.12, 8.4, 12, " 12 %  rend");
    expect_line(0.12, 8.4, 1, "");
    expect_line(0, -1, 30, "  0 %  render");
    expect_line(1, 0, 30, " 99 %  render  0.0 s left"); /* until it is over */
}

static void test_seconds_become_minutes_and_hours(void **state) {
    (void)state;
    expect_line(0.5, 9.96, 34, " 50 %  render  10 s left");
    expect_line(0.5, 119, 34, " 50 %  render  119 s left");
    expect_line(0.5, 125, 34, " 50 %  render  2 min 05 s left");
    expect_line(0.5, 7500, 34, " 50 %  render  2 h 05 min left");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_right_expectations_count_down_like_a_clock),
        cmocka_unit_test(test_the_first_phase_corrects_the_later_ones_of_its_kind),
        cmocka_unit_test(test_the_fraction_never_falls_and_the_end_is_never_doubled_at_once),
        cmocka_unit_test(test_nothing_is_told_before_something_is_measured),
        cmocka_unit_test(test_what_is_learnt_of_coming_phases_counts),
        cmocka_unit_test(test_previews_do_not_slow_a_phase),
        cmocka_unit_test(test_the_line_fits_into_the_terminal),
        cmocka_unit_test(test_seconds_become_minutes_and_hours),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
