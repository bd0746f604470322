/* SPDX-License-Identifier: Apache-2.0 */
/* The same seed gives the same bits on any number of threads, by each way to render: looks, bundles
 * of paths that teach maps, camera rays at edges, the denoiser. (Processes: tests/unit/test_mpi.c,
 * test_team.c.) */

#include "tests/unit/check.h"

#include <string.h>

#include "picture_jobs.h"

static void assert_same(const char *name, int threads, const struct fewray_frame *a,
                        const struct fewray_frame *b) {
    assert_int_equal(a->plane_count, b->plane_count);
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    for (size_t k = 0; k < a->plane_count; k++) {
        assert_string_equal(a->planes[k].name, b->planes[k].name);
        for (int i = 0; i < a->width * a->height; i++)
            if (memcmp(&a->planes[k].data[i], &b->planes[k].data[i], sizeof(float)))
                fail_msg("%s: %s of pixel %d is %.9g on %d threads, %.9g on one", name,
                         a->planes[k].name, i, (double)b->planes[k].data[i], threads,
                         (double)a->planes[k].data[i]);
    }
}

static void test_any_number_of_threads_gives_the_same_bits(void **state) {
    (void)state;
    const int threads[] = {2, 7};
    for (int p = 0; p < PICTURES; p++) {
        struct fewray_frame *one = picture_render(&pictures[p], 1, NULL);
        for (int t = 0; t < 2; t++) {
            struct fewray_frame *more = picture_render(&pictures[p], threads[t], NULL);
            assert_same(pictures[p].name, threads[t], one, more);
            fewray_frame_destroy(&more);
        }
        fewray_frame_destroy(&one);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_any_number_of_threads_gives_the_same_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
