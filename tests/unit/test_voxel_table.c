/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers of voxels: stable, apart by place and side, safe with any input. */

#include "tests/unit/check.h"

#include "guide/odis/voxel_table.h"
#include "guide/trace/sampler.h"

static const struct vec3 axes[6] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                    {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};

static float uniform(uint32_t stream, uint32_t i) {
    return to_unit_float(hash_combine(stream, i));
}

static void test_numbers_are_apart_by_voxel_and_axis(void **state) {
    (void)state;
    struct voxel_table t = {.side = 0.25f};
    const struct vec3 places[] = {
        {0, 0, 0}, {0.25f, 0, 0}, {0, 0.25f, 0}, {0, 0, 0.25f}, {-0.25f, 0, 0}};
    assert_int_equal(voxel_table_find(&t, places[0], axes[0]), -1);
    for (int i = 0; i < 30; i++) {
        assert_int_equal(voxel_table_find(&t, places[i / 6], axes[i % 6]), -1);
        assert_int_equal(voxel_table_add(&t, places[i / 6], axes[i % 6]), i);
    }
    assert_int_equal(t.count, 30);
    for (int i = 29; i >= 0; i--) { /* anywhere in the voxel, by the normal's main axis */
        struct vec3 p = add(places[i / 6], vec(0.12f, -0.12f, 0.06f)), n = axes[i % 6];
        n = normalize(add(n, vec(0.3f, 0.3f, -0.3f)));
        assert_int_equal(voxel_table_find(&t, p, n), i);
        assert_int_equal(voxel_table_add(&t, p, n), i);
        assert_int_equal(voxel_table_find(&t, add(p, vec(0, 1, 0)), n), -1);
    }
    assert_int_equal(t.count, 30);
    voxel_table_clear(&t);
}

/* The table grows from 4096 slots, at half full: five times. */
static void test_numbers_stay_while_the_table_grows(void **state) {
    (void)state;
    enum { VOXELS = 50000, SIDE = 37 };
    struct voxel_table t = {.side = 2};
    int growths = 0;
    for (int round = 0; round < 2; round++)
        for (int i = 0; i < VOXELS; i++) {
            struct vec3 p =
                vec(2.0f * (float)(i % SIDE - SIDE / 2), 2.0f * (float)(i / SIDE % SIDE - SIDE / 2),
                    2.0f * (float)(i / SIDE / SIDE - SIDE / 2));
            uint32_t size = t.size;
            assert_int_equal(voxel_table_find(&t, p, axes[i % 6]), round ? i : -1);
            assert_int_equal(voxel_table_add(&t, p, axes[i % 6]), i);
            growths += size > 0 && t.size > size;
            assert_true((uint32_t)t.count <= t.size / 2 + 1);
        }
    assert_int_equal(t.count, VOXELS);
    assert_int_equal(growths, 5);
    voxel_table_clear(&t);
}

/* Floors and walls through the origin, as most scenes have them, are one voxel thick. */
static void test_planes_through_the_origin_do_not_flicker(void **state) {
    (void)state;
    const float sides[] = {0.03f, 0.5f, 7, 1e3f};
    for (int k = 0; k < 4; k++)
        for (int axis = 0; axis < 3; axis++) {
            struct voxel_table t = {.side = sides[k]};
            for (uint32_t i = 0; i < 1000; i++) {
                float p[3];
                for (uint32_t c = 0; c < 3; c++)
                    p[c] = sides[k] * 0.98f * (uniform(c, i) - 0.5f);
                p[axis] = 2e-5f * (uniform(9, i) - 0.5f);
                assert_int_equal(voxel_table_add(&t, vec(p[0], p[1], p[2]), axes[2 * axis]), 0);
            }
            assert_int_equal(t.count, 1);
            voxel_table_clear(&t);
        }
}

static void test_far_coordinates_stay_apart(void **state) {
    (void)state;
    const float far[] = {1e6f, -1e6f};
    for (int k = 0; k < 2; k++) {
        struct voxel_table t = {.side = 0.5f};
        for (int i = 0; i < 1000; i++) {
            struct vec3 p = vec(far[k] + 0.5f * (float)(i % 10), far[k] + 0.5f * (float)(i / 100),
                                far[k] + 0.5f * (float)(i / 10 % 10));
            assert_int_equal(voxel_table_add(&t, p, axes[2]), i);
            assert_int_equal(voxel_table_find(&t, p, axes[2]), i);
        }
        assert_int_equal(voxel_table_find(&t, vec(0, 0, 0), axes[2]), -1);
        voxel_table_clear(&t);
    }
}

static void test_bad_values_are_safe(void **state) {
    (void)state;
    const float bad[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f, 1e-40f, 0};
    struct voxel_table t = {.side = 0.5f};
    for (int i = 0; i < 7 * 7 * 7; i++)
        for (int k = 0; k < 2; k++) {
            struct vec3 b = vec(bad[i % 7], bad[i / 7 % 7], bad[i / 49]);
            struct vec3 p = k ? vec(1, 2, 3) : b, n = k ? b : axes[3];
            int number = voxel_table_add(&t, p, n);
            assert_true(number >= 0 && number < t.count);
            assert_int_equal(voxel_table_find(&t, p, n), number);
        }
    assert_true(t.count < 64); /* all that is bad shares a few voxels */
    voxel_table_clear(&t);
}

static void test_cleared_tables_are_new(void **state) {
    (void)state;
    struct voxel_table t = {.side = 3};
    voxel_table_clear(&t); /* nothing was added yet */
    for (int round = 0; round < 2; round++) {
        assert_int_equal(voxel_table_find(&t, vec(0, 0, 0), axes[0]), -1);
        assert_int_equal(voxel_table_add(&t, vec(9, 0, 0), axes[0]), 0);
        assert_int_equal(voxel_table_add(&t, vec(0, 0, 0), axes[0]), 1);
        voxel_table_clear(&t);
        assert_true(!t.keys && !t.numbers && !t.size && !t.count);
        assert_near(t.side, 3, 0);
        voxel_table_clear(&t);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_numbers_are_apart_by_voxel_and_axis),
        cmocka_unit_test(test_numbers_stay_while_the_table_grows),
        cmocka_unit_test(test_planes_through_the_origin_do_not_flicker),
        cmocka_unit_test(test_far_coordinates_stay_apart),
        cmocka_unit_test(test_bad_values_are_safe),
        cmocka_unit_test(test_cleared_tables_are_new),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
