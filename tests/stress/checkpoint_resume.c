/* SPDX-License-Identifier: Apache-2.0 */
/* A render that was interrupted and goes on gives the picture of one that never was. The bound of
 * every case: no byte of the EXR (32-bit floats, every layer) and no count differs. */

#include "checkpoint_job.h"

struct kind {
    const char *name;
    bool guided, denoised, split; /* split: direct and indirect light apart */
    bool no_probes, no_refine;
    int initial, part, parts;
};

static const struct kind KINDS[] = {
    {.name = "plain"},
    {.name = "plain part", .part = 2, .parts = 3},
    {.name = "guided", .guided = true, .initial = 1},
    {.name = "guided, denoised", .guided = true, .denoised = true, .initial = 1},
    {.name = "guided, split", .guided = true, .split = true, .initial = 1},
    {.name = "guided, long look", .guided = true, .initial = 3},
    {.name = "guided without probes", .guided = true, .no_probes = true, .initial = 1},
    {.name = "guided, maps don't learn", .guided = true, .no_refine = true, .initial = 2},
    {.name = "guided part", .guided = true, .initial = 1, .part = 3, .parts = 3},
};
enum { KIND_COUNT = sizeof KINDS / sizeof *KINDS, PLAIN = 0, GUIDED = 2, DENOISED = 3 };

static struct fewray_job job_of(const struct kind *kind, const char *exr, const char *checkpoint) {
    struct fewray_job job = small_job(exr, checkpoint);
    job.guided = kind->guided;
    job.denoised = kind->denoised;
    job.settings.direct = job.settings.indirect = kind->split;
    job.settings.initial = kind->guided ? kind->initial : 1;
    job.settings.probes = !kind->no_probes;
    job.settings.refine = !kind->no_refine;
    job.part = kind->part;
    job.parts = kind->parts;
    return job;
}

/* The render that nobody interrupts. */
static void render_whole(const struct kind *kind, struct fewray_run_stats *stats) {
    struct fewray_job job = job_of(kind, scratch_name("whole.exr"), NULL);
    job.settings.threads = 2;
    assert_int_equal(fewray_job_run(&job, NULL, stats, NULL), FEWRAY_OK);
    assert_int_equal(stats->resumes, 0);
}

static void expect_same(const struct kind *kind, const char *where,
                        const struct fewray_run_stats *whole,
                        const struct fewray_run_stats *resumed) {
    if (!same_files(scratch_name("whole.exr"), scratch_name("resumed.exr")))
        fail_msg("%s, %s: another picture", kind->name, where);
    if (memcmp(&whole->counts, &resumed->counts, sizeof whole->counts))
        fail_msg("%s, %s: %lld paths and %lld rays, not %lld and %lld", kind->name, where,
                 resumed->counts.paths, resumed->counts.rays, whole->counts.paths,
                 whole->counts.rays);
    if (exists(scratch_name("state")))
        fail_msg("%s, %s: the checkpoint is left", kind->name, where);
}

/* One thread and three in turn, each stopped after a few tiles. */
static void test_a_render_of_many_runs_is_that_of_one(void **state) {
    (void)state;
    for (int k = 0; k < KIND_COUNT; k++) {
        struct fewray_run_stats whole, stats;
        render_whole(&KINDS[k], &whole);
        int runs = 0, status;
        do {
            struct stopper stopper = {.calls = 3};
            struct fewray_job job =
                job_of(&KINDS[k], scratch_name("resumed.exr"), scratch_name("state"));
            job.settings.threads = runs % 2 ? 3 : 1;
            status = run_until(job, &stopper, &stats, NULL);
            assert_true(status == FEWRAY_OK || status == FEWRAY_ERROR_CANCELLED);
            assert_int_equal(stats.resumes, runs);
            assert_int_equal(stopper.notes, runs > 0);
            runs++;
        } while (status && runs < 100);
        expect_same(&KINDS[k], "stopped after every three tiles", &whole, &stats);
        /* a run does at most 3 tiles and the 2 that other threads have begun */
        assert_true(runs >= 3 * TILES / 5);
    }
}

/* Where in a run the interrupt comes, and what of it the next run can leave out. */
static const struct interrupt {
    const char *name;
    int kind;
    const char *phase;
    int calls;
    double least_spp; /* samples a pixel, that the next run starts with at least */
} INTERRUPTS[] = {
    {"while it loads: a tile is done all the same", GUIDED, "load", 1, 0.25},
    {"at the look's first tile", GUIDED, "first look", 2, 0.25},
    {"at the look's last tile", GUIDED, "first look", 5, 1},
    {"before the maps", GUIDED, "guide", 1, 1},
    {"before the rest", GUIDED, "render", 1, 1},
    {"at the last tile before maps learn", GUIDED, "render", 1 + TILES, 4},
    {"amid a learning pass", GUIDED, "render", 1 + TILES + 2, 4},
    {"at the very last tile", GUIDED, "render", 1 + 3 * TILES, 20},
    {"before the edges", GUIDED, "edges", 1, 20},
    {"while it denoises", DENOISED, "denoise", 1, 20},
    {"before it writes", DENOISED, "write", 1, 20},
    {"before a plain render", PLAIN, "render", 1, 0},
    {"at the last tile of a plain one", PLAIN, "render", 1 + 3 * TILES, 20},
    {"at its edges", PLAIN, "edges", 2, 20},
};

static void test_an_interrupt_at_any_step_keeps_what_is_done(void **state) {
    (void)state;
    struct fewray_run_stats whole = {0};
    for (size_t i = 0; i < sizeof INTERRUPTS / sizeof *INTERRUPTS; i++) {
        const struct interrupt *at = &INTERRUPTS[i];
        const struct kind *kind = &KINDS[at->kind];
        struct fewray_run_stats stats;
        struct fewray_error error = {0};
        if (i == 0 || at->kind != INTERRUPTS[i - 1].kind)
            render_whole(kind, &whole);
        const char *checkpoint = scratch_name("state");
        struct stopper stopper = {.phase = at->phase, .calls = at->calls};
        struct fewray_job job = job_of(kind, scratch_name("resumed.exr"), checkpoint);
        job.settings.threads = 1;
        const int status = run_until(job, &stopper, &stats, &error);
        if (status == FEWRAY_OK) { /* nothing asked any more: it was as good as done */
            assert_string_equal(at->phase, "write");
            expect_same(kind, at->name, &whole, &stats);
            continue;
        }
        assert_int_equal(status, FEWRAY_ERROR_CANCELLED);
        if (exists(checkpoint) != (at->least_spp >= 0))
            fail_msg("%s: %s checkpoint", at->name, exists(checkpoint) ? "a" : "no");
        if (exists(checkpoint))
            assert_non_null(strstr(error.what, "--resume"));
        struct stopper never = {.calls = -1};
        job.settings.threads = 3;
        job.must_resume = at->least_spp >= 0;
        assert_int_equal(run_until(job, &never, &stats, NULL), FEWRAY_OK);
        if (!(stats.resumed_spp >= at->least_spp - 1e-9))
            fail_msg("%s: resumed at %g samples, expected %g", at->name, stats.resumed_spp,
                     at->least_spp);
        expect_same(kind, at->name, &whole, &stats);
    }
}

/* More samples than the interrupted render was to have: the same bits, or refused. */
static const struct {
    const char *name;
    int kind, tiles; /* done at the interrupt, passes' ends are 4, 16, 20 */
    int spp;
    bool fits;
} SIZES[] = {
    {"more, before the last pass", PLAIN, 2 * TILES - 1, 24, true},
    {"more, after a whole pass", PLAIN, 2 * TILES, 24, true},
    {"more, amid the last pass", PLAIN, 2 * TILES + 1, 24, false},
    {"fewer, before they are passed", PLAIN, 2 * TILES - 1, 16, true},
    {"fewer, all of them done", PLAIN, 2 * TILES, 16, true},
    {"fewer than done", PLAIN, 2 * TILES, 12, false},
    {"more, guided, maps still learn", GUIDED, TILES + 2 * TILES - 1, 24, true},
    {"more, guided, amid the last pass", GUIDED, TILES + 2 * TILES + 1, 24, false},
    {"fewer, guided, maps wouldn't learn", GUIDED, TILES + TILES + 1, 16, false},
    {"more, guided, amid the look", GUIDED, 2, 24, true},
};

static void
test_another_number_of_samples_gives_the_bits_of_that_number_or_is_refused(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof SIZES / sizeof *SIZES; i++) {
        const struct kind *kind = &KINDS[SIZES[i].kind];
        struct fewray_run_stats stats;
        struct fewray_error error = {0};
        struct stopper stopper = {.calls = SIZES[i].tiles}, never = {.calls = -1};
        struct fewray_job job = job_of(kind, scratch_name("resumed.exr"), scratch_name("state"));
        job.settings.threads = 1;
        assert_int_equal(run_until(job, &stopper, NULL, NULL), FEWRAY_ERROR_CANCELLED);
        job.settings.spp = SIZES[i].spp;
        const int status = run_until(job, &never, &stats, &error);
        if ((status == FEWRAY_OK) != SIZES[i].fits)
            fail_msg("%s: %s", SIZES[i].name, status ? error.what : "taken");
        if (status) {
            assert_non_null(strstr(error.what, "--spp"));
            unlink(job.checkpoint);
            continue;
        }
        struct fewray_job whole = job_of(kind, scratch_name("whole.exr"), NULL);
        whole.settings.spp = SIZES[i].spp;
        assert_int_equal(fewray_job_run(&whole, NULL, NULL, NULL), FEWRAY_OK);
        if (!same_files(scratch_name("whole.exr"), scratch_name("resumed.exr")))
            fail_msg("%s: another picture", SIZES[i].name);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_render_of_many_runs_is_that_of_one),
        cmocka_unit_test(test_an_interrupt_at_any_step_keeps_what_is_done),
        cmocka_unit_test(
            test_another_number_of_samples_gives_the_bits_of_that_number_or_is_refused),
    };
    return cmocka_run_group_tests(tests, scratch_create, scratch_remove);
}
