/* SPDX-License-Identifier: Apache-2.0 */
/* The planner: its decisions on made-up measurements, and whole renders to a goal. */

#include "tests/unit/check.h"

#include <stdio.h>
#include <string.h>

#include "fewray/pipeline.h"
#include "pipeline/change.h"
#include "pipeline/plan.h"

/* Passes as planned, each taking `slower` times what the clock says before it is measured. */
static double spend(struct plan_clock clock, double slower, double *done) {
    double used = clock.total - clock.left;
    *done = 0;
    for (int pass = 0; pass < 100; pass++) {
        clock.left = clock.total - used;
        const struct plan_step step = plan_step_in_time(&clock, *done);
        if (step.more <= 0)
            return used + clock.tail;
        if (pass == 0)
            clock.sample *= slower;
        clock.measured = true;
        used += step.more * clock.sample + (step.picture ? clock.picture : 0);
        *done += step.more;
    }
    fail_msg("the render never ends");
    return 0;
}

static void test_passes_fill_the_time_and_not_more(void **state) {
    (void)state;
    for (double total = 1; total < 100; total *= 1.7)
        for (double slower = 0.5; slower < 2.5; slower *= 2) {
            const struct plan_clock clock = {total, total * 0.95, 0.1, 0.05, 0.03, false};
            double done;
            const double used = spend(clock, slower, &done);
            assert_true(used <= 1.01 * total);
            assert_true(used >= 0.9 * total);
        }
}

static void test_one_sample_is_rendered_however_short_the_time(void **state) {
    (void)state;
    const struct plan_clock clock = {1, -3, 0.1, 5, 0.03, false};
    double done;
    spend(clock, 1, &done);
    assert_near(done, 1, 1e-9);
}

static void test_more_time_never_means_fewer_samples(void **state) {
    (void)state;
    double before = 0;
    for (double total = 0.2; total < 60; total *= 1.2) {
        const struct plan_clock clock = {total, total, 0.1, 0.05, 0.03, false};
        double done;
        spend(clock, 1, &done);
        assert_true(done >= before);
        before = done * 0.9; /* pictures on the way cost as much as a few samples */
    }
}

static void test_the_error_wanted_decides_the_samples(void **state) {
    (void)state;
    assert_true(plan_step_for_error(8, 0.01, 0.02, 64).more <= 0);
    assert_true(plan_step_for_error(64, 0.03, 0.02, 64).more <= 0);
    assert_near(plan_step_for_error(0, -1, 0.02, 64).more, 2, 1e-12);
    assert_near(plan_step_for_error(4, -1, 0.02, 64).more, 4, 1e-12);
    assert_near(plan_step_for_error(48, 1, 0.02, 64).more, 16, 1e-12);
    const double near = plan_step_for_error(8, 0.021, 0.02, 64).more;
    const double far = plan_step_for_error(8, 0.025, 0.02, 64).more;
    assert_true(near > 0 && far > near && far <= 8);
}

static void test_a_guide_needs_time_to_pay(void **state) {
    (void)state;
    const struct plan_clock shortly = {1, 0.5, 0.2, 0.1, 0, false};
    const struct plan_clock long_run = {100, 99, 0.2, 0.1, 0, false};
    assert_false(plan_guide_fits(&shortly, 0.2, 1.5));
    assert_true(plan_guide_fits(&long_run, 0.2, 1.5));
    assert_false(plan_guide_fits(&long_run, 0.2, 0.9));
}

static void test_samples_are_dealt_by_need_within_the_budget(void **state) {
    (void)state;
    enum { TILES = 1000 };
    static float needs[TILES];
    static int have[TILES], more[TILES];
    double sum = 0;
    for (int t = 0; t < TILES; t++) {
        needs[t] = 0.001f * (float)(t + 1);
        have[t] = 8;
    }
    plan_deal(needs, have, TILES, 8, 1, more);
    for (int t = 0; t < TILES; t++) {
        sum += more[t];
        assert_true(more[t] >= 2 && more[t] <= 32);
        assert_true(t < 100 || more[t] + 1 >= more[t - 100]);
    }
    assert_near(sum / TILES, 8, 0.1);
    assert_true(more[TILES - 1] > more[0]);
    plan_deal(NULL, have, TILES, 3, 1, more);
    for (int t = 0; t < TILES; t++)
        assert_int_equal(more[t], 3);
    memset(needs, 0, sizeof needs); /* a black picture */
    plan_deal(needs, have, TILES, 3, 1, more);
    for (int t = 0; t < TILES; t++)
        assert_int_equal(more[t], 3);
}

static void test_a_tile_is_not_judged_by_its_own_cells(void **state) {
    (void)state;
    enum { TILES = 5, CELLS = 2 * TILES };
    float cells[CELLS * CELLS] = {0}, needs[TILES * TILES];
    for (int y = 4; y < 6; y++)
        for (int x = 4; x < 6; x++)
            cells[y * CELLS + x] = 1;
    plan_needs(cells, CELLS, CELLS, needs, TILES, TILES);
    assert_true(needs[2 * TILES + 2] == 0);
    assert_true(needs[2 * TILES + 1] > 0 && needs[2 * TILES + 3] > 0);
    assert_near(needs[2 * TILES + 1], needs[2 * TILES + 3], 1e-6);
    assert_near(needs[1 * TILES + 2], needs[3 * TILES + 2], 1e-6);
}

/* Pictures of white noise around 1, as 4 and as 8 samples leave it. */
static void test_change_tells_the_error_of_independent_noise(void **state) {
    (void)state;
    enum { SIDE = 64 };
    int four[16], eight[16];
    struct change *change = NULL;
    struct fewray_error error;
    struct fewray_frame *frame = NULL;
    float *planes[3];
    uint32_t random = 1;
    static float sums[3][SIDE * SIDE];
    assert_int_equal(change_create(SIDE, SIDE, &change, &error), FEWRAY_OK);
    assert_int_equal(fewray_frame_create(SIDE, SIDE, &frame, &error), FEWRAY_OK);
    assert_true(fewray_frame_add_layer(frame, FEWRAY_COLOR, planes));
    for (int t = 0; t < 16; t++) {
        four[t] = 4;
        eight[t] = 8;
    }
    for (int n = 1; n <= 8; n++) {
        for (int c = 0; c < 3; c++)
            for (int i = 0; i < SIDE * SIDE; i++) {
                random = random * 1664525u + 1013904223u;
                sums[c][i] += 1 + ((float)(random >> 8) * 0x1p-24f - 0.5f) * sqrtf(12) * 0.2f;
                planes[c][i] = sums[c][i] / (float)n;
            }
        if (n == 4 || n == 8)
            change_see(change, frame, n == 4 ? four : eight, false);
        assert_true((change->error >= 0) == (n == 8));
    }
    assert_near(change->error, 0.04 / 8 / 1.01, 0.0003);
    change_destroy(&change);
    fewray_frame_destroy(&frame);
}

static struct fewray_frame *render(struct fewray_job *job, struct fewray_run_stats *stats) {
    struct fewray_frame *frame = NULL;
    struct fewray_error error;
    if (fewray_job_run(job, &frame, stats, &error))
        fail_msg("%s", error.what);
    return frame;
}

static struct fewray_job small_job(const char *scene) {
    struct fewray_job job;
    fewray_job_init(&job);
    job.scene_path = scene;
    job.settings.width = 64;
    job.settings.height = 48;
    return job;
}

static void test_an_error_gives_the_same_bits_on_any_number_of_threads(void **state) {
    (void)state;
    struct fewray_run_stats stats;
    struct fewray_job job = small_job(EXAMPLES "/door-ajar.xml");
    job.goal = (struct fewray_goal){.error = 0.02, .max_spp = 16, .adaptive = true};
    job.pilot = false;
    job.settings.bsdf_fraction = 0.25f;
    job.settings.threads = 1;
    struct fewray_frame *one = render(&job, &stats);
    assert_true(stats.plan.adaptive && stats.plan.most_spp > stats.plan.least_spp);
    job.settings.threads = 3;
    struct fewray_frame *three = render(&job, &stats);
    assert_int_equal(one->plane_count, three->plane_count);
    for (size_t p = 0; p < one->plane_count; p++)
        assert_memory_equal(one->planes[p].data, three->planes[p].data, 64 * 48 * sizeof(float));
    fewray_frame_destroy(&one);
    fewray_frame_destroy(&three);
}

/* Mean radiance of noisy pictures and its standard error. */
static double mean_of_seeds(struct fewray_job *job, int seeds, double *error) {
    double sum = 0, squares = 0;
    for (int k = 0; k < seeds; k++) {
        struct fewray_run_stats stats;
        job->settings.seed = 500 + (uint64_t)k;
        struct fewray_frame *frame = render(job, &stats);
        const size_t pixels = (size_t)frame->width * (size_t)frame->height;
        const float *g = fewray_frame_plane(frame, "G");
        double mean = 0;
        for (size_t i = 0; i < pixels; i++)
            mean += g[i] / (double)pixels;
        sum += mean / seeds;
        squares += mean * mean / seeds;
        assert_true(!job->goal.adaptive || stats.plan.adaptive);
        fewray_frame_destroy(&frame);
    }
    *error = sqrt(fmax(0, squares - sum * sum) / (seeds - 1));
    return sum;
}

static void test_the_adaptive_mean_equals_the_plain_mean(void **state) {
    (void)state;
    struct fewray_job job = small_job(EXAMPLES "/door-ajar.xml");
    job.guided = job.denoised = false;
    double plain_error, adaptive_error;
    job.settings.spp = 32;
    const double plain = mean_of_seeds(&job, 6, &plain_error);
    job.settings.spp = 12;
    job.goal.adaptive = true;
    const double adaptive = mean_of_seeds(&job, 16, &adaptive_error);
    /* 3 standard errors; the seeds are fixed */
    assert_near(adaptive, plain,
                3 * sqrt(plain_error * plain_error + adaptive_error * adaptive_error));
    assert_true(adaptive_error < 0.05 * adaptive);
}

static void test_a_goal_without_time_says_what_was_planned(void **state) {
    (void)state;
    struct fewray_run_stats stats;
    struct fewray_job job = small_job(EXAMPLES "/cornell-box.xml");
    job.goal = (struct fewray_goal){.error = 1e-5, .max_spp = 8};
    struct fewray_frame *frame = render(&job, &stats);
    assert_true(stats.plan.made && stats.plan.hit_max_spp && stats.plan.reason_count > 0);
    assert_near(stats.plan.spp, 8, 1e-9);
    assert_true(stats.plan.estimated_error > 1e-5 && stats.plan.estimated_error < 1);
    fewray_frame_destroy(&frame);
    job.goal = (struct fewray_goal){.seconds = 1e-6};
    frame = render(&job, &stats);
    assert_true(stats.plan.too_short && stats.counts.paths >= 64 * 48);
    assert_true(isnan(stats.plan.estimated_error));
    fewray_frame_destroy(&frame);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_passes_fill_the_time_and_not_more),
        cmocka_unit_test(test_one_sample_is_rendered_however_short_the_time),
        cmocka_unit_test(test_more_time_never_means_fewer_samples),
        cmocka_unit_test(test_the_error_wanted_decides_the_samples),
        cmocka_unit_test(test_a_guide_needs_time_to_pay),
        cmocka_unit_test(test_samples_are_dealt_by_need_within_the_budget),
        cmocka_unit_test(test_a_tile_is_not_judged_by_its_own_cells),
        cmocka_unit_test(test_change_tells_the_error_of_independent_noise),
        cmocka_unit_test(test_an_error_gives_the_same_bits_on_any_number_of_threads),
        cmocka_unit_test(test_the_adaptive_mean_equals_the_plain_mean),
        cmocka_unit_test(test_a_goal_without_time_says_what_was_planned),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
