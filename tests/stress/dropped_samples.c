/* SPDX-License-Identifier: Apache-2.0 */
/* A sample with a NaN or an infinity is dropped and counted where it is born: the film doesn't hold
 * it, and the guide doesn't learn from it. */

#include "guide_stage.h"

#include <omp.h>

#include "guide/trace/tile_paths.h"

enum { PATHS = 3 * BUNDLE_LANES + 5 };

static const float faults[] = {NAN, INFINITY, -INFINITY};

static bool is_faulty(int x) {
    return x % 3 == 1;
}

/* Instead of the path tracer: each path brings 2, every third a fault. */
static void trace(const struct integrator *in, int count, const struct bundle_start *starts,
                  struct path_sample *samples) {
    (void)in;
    for (int i = 0; i < count; i++) {
        const int x = starts[i].x;
        const float value = is_faulty(x) ? faults[x / 3 % 3] : 2;
        samples[i] = (struct path_sample){.radiance = {value, 2, 2}, .depth = 1, .rays = 1};
        *starts[i].record =
            (struct look_record){.depth = 1, .reflected = value, .radiance = {value, 2, 2}};
        *starts[i].second = (struct look_second){.albedo = 0.5f, .light_value = value};
    }
}

static void test_faulty_samples_are_neither_shown_nor_learnt(void **state) {
    (void)state;
    static struct look_record records[PATHS];
    static struct look_second seconds[PATHS];
    struct stage s;
    struct fewray_film *film = NULL;
    struct fewray_error error = {.line = 0};
    struct fewray_render_stats stats = {0};
    stage_open(&s, 1, 4);
    s.settings.width = PATHS;
    s.settings.height = 1;
    stage_must(fewray_film_create(s.world, &s.settings, &film, &error), &error);
    struct tile_paths paths = {.film = film, .stats = &stats, .trace = trace, .group = GROUP_LOOK};
    int faulty = 0;
    for (int x = 0; x < PATHS; x++) {
        const struct bundle_start start = {
            .x = x, .y = 0, .record = &records[x], .second = &seconds[x]};
        tile_paths_add(&paths, &start);
        faulty += is_faulty(x);
    }
    tile_paths_end(&paths);
    assert_int_equal(stats.paths, PATHS);
    assert_int_equal(stats.dropped, faulty);
    for (int x = 0; x < PATHS; x++) {
        assert_int_equal(film->group[GROUP_LOOK][x].count, !is_faulty(x));
        assert_near(film->group[GROUP_LOOK][x].radiance[0], is_faulty(x) ? 0 : 2, 0);
        assert_near(records[x].depth, is_faulty(x) ? 0 : 1, 0);
        assert_near(seconds[x].albedo, is_faulty(x) ? 0 : 0.5, 0);
    }
    fewray_film_destroy(&film);
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_faulty_samples_are_neither_shown_nor_learnt)};
    omp_set_num_threads(1); /* for scenes so small threads cost more than they bring */
    return cmocka_run_group_tests(tests, NULL, NULL);
}
