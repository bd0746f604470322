/* SPDX-License-Identifier: Apache-2.0 */
/* Sampling maps: densities, samples, mixtures, and the gather that they are made from. */

#include "tests/unit/check.h"

#include <string.h>

#include "guide/odis/gather.h"
#include "guide/odis/maps.h"
#include "guide/trace/sampler.h"

static void fill_map(struct map *map, uint32_t seed, struct vec3 normal) {
    float values[SPHERE_BINS];
    for (int b = 0; b < SPHERE_BINS; b++) {
        float v = to_unit_float(hash_combine(seed, (uint32_t)b));
        values[b] = v < 0.5f ? 0 : v * v * v * 100;
    }
    memset(map, 0, sizeof(*map));
    map->normal = normal;
    map->valid = map_set_density(map, values);
    assert_true(map->valid);
}

static void test_mixture_samples_follow_pdf(void **state) {
    (void)state;
    static struct map a, b;
    fill_map(&a, 1, vec(0, 1, 0));
    fill_map(&b, 2, vec(0, 1, 0));
    struct map_mixture mixture = {2, {&a, &b}, {0.3f, 0.7f}};
    static double observed[SPHERE_BINS], expected[SPHERE_BINS];
    double total = 0;
    const int n = 1 << 18;
    for (int i = 0; i < SPHERE_BINS; i++) {
        observed[i] = 0;
        struct vec3 centre = sphere_direction(i / SPHERE_COLUMNS, i % SPHERE_COLUMNS, 0.5f, 0.5f);
        expected[i] = map_mixture_pdf(&mixture, centre) * SPHERE_BIN_SOLID_ANGLE;
        total += expected[i];
        expected[i] *= n;
    }
    assert_near(total, 1, 1e-4);
    for (int i = 0; i < n; i++) {
        float u[2] = {to_unit_float(hash_combine(3, (uint32_t)i)),
                      to_unit_float(hash_combine(4, (uint32_t)i))};
        struct vec3 d = map_mixture_sample(&mixture, u);
        assert_near(length(d), 1, 1e-4);
        assert_true(map_mixture_pdf(&mixture, d) > 0);
        observed[sphere_bin(d)]++;
    }
    int degrees;
    double statistic = chi_square(observed, expected, SPHERE_BINS, &degrees);
    assert_true(statistic < chi_square_limit(degrees));
}

static void test_map_without_light_is_refused(void **state) {
    (void)state;
    static struct map map;
    float values[SPHERE_BINS] = {0};
    assert_false(map_set_density(&map, values));
    values[5] = NAN;
    assert_false(map_set_density(&map, values));
    values[5] = INFINITY;
    assert_false(map_set_density(&map, values));
}

static void test_extreme_random_numbers_are_safe(void **state) {
    (void)state;
    static struct map map;
    float values[SPHERE_BINS] = {0};
    values[SPHERE_BINS - 1] = 1e-20f;
    assert_true(map_set_density(&map, values));
    struct map_mixture mixture = {1, {&map}, {1}};
    const float ends[] = {0, 0x1.fffffep-1f};
    for (int i = 0; i < 4; i++) {
        struct vec3 d = map_mixture_sample(&mixture, (float[2]){ends[i / 2], ends[i % 2]});
        assert_true(isfinite(d.x + d.y + d.z));
        assert_int_equal(sphere_bin(d), SPHERE_BINS - 1);
    }
}

/* A 2 x 2 grid over 16 x 16 pixels: normals and planes decide which maps a point may use. */
static void test_maps_of_other_surfaces_are_left_out(void **state) {
    (void)state;
    static struct map grid[4];
    for (int i = 0; i < 4; i++) {
        fill_map(&grid[i], (uint32_t)i, vec(0, 1, 0));
        grid[i].position = vec((float)(i % 2), 0, (float)(i / 2));
    }
    struct fewray_maps maps = {.columns = 2, .rows = 2, .width = 9, .height = 9, .maps = grid};
    struct map_mixture m = maps_at(&maps, 4, 4, vec(0.5f, 0, 0.5f), vec(0, 1, 0));
    assert_int_equal(m.count, 4);
    for (int k = 0; k < 4; k++)
        assert_near(m.share[k], 0.25, 1e-5);
    assert_int_equal(maps_at(&maps, 4, 4, vec(0.5f, 0, 0.5f), vec(1, 0, 0)).count, 0);
    grid[0].position.y = 5;
    m = maps_at(&maps, 4, 4, vec(0.5f, 0, 0.5f), vec(0, 1, 0));
    for (int k = 0; k < m.count; k++)
        assert_true(m.maps[k] != &grid[0] || m.share[k] < 1e-3);
    m = maps_at(&maps, 8, 8, vec(1, 0, 1), vec(0, 1, 0));
    assert_int_equal(m.count, 1);
    assert_ptr_equal(m.maps[0], &grid[3]);
}

static void test_range_compressor_inverts(void **state) {
    (void)state;
    for (float x = 1e-4f; x < 100; x *= 3)
        assert_near(range_expand(range_compress(x)) / x, 1, 1e-3);
    assert_near(range_compress(1), 1, 1e-6);
}

/* All pixels on one plane, all light from one direction: the gather must find it there. */
static void test_gather_finds_the_light(void **state) {
    (void)state;
    enum { N = 24 };
    static struct look_record records[N * N];
    struct fewray_look look = {N, N, 1, records};
    for (int i = 0; i < N * N; i++) {
        struct vec3 d = sphere_direction((int)(hash_u32((uint32_t)i) % 16),
                                         (int)(hash_u32((uint32_t)i + 999) % 32), 0.5f, 0.5f);
        bool lit = sphere_bin(d) == 5 * SPHERE_COLUMNS + 3;
        records[i] = (struct look_record){.position = vec((float)(i % N), 0, (float)(i / N)),
                                          .normal = vec(0, 1, 0),
                                          .depth = 2,
                                          .direction = d,
                                          .radiance = lit ? vec(3, 2, 1) : vec(0, 0, 0),
                                          .weighted = lit ? 2 : 0,
                                          .distance = 1,
                                          .second_normal = negate(d)};
    }
    static struct gathered g;
    gather(&look, 12, 12, &g);
    assert_true(g.valid);
    assert_near(g.tint.x, 1.5, 1e-4);
    int brightest = 0;
    for (int b = 0; b < SPHERE_BINS; b++) {
        assert_true(isfinite(g.fill[b]));
        assert_true(b < 512 ? g.cosine[b] > 0 : g.cosine[b] <= 0);
        brightest = g.fill[b] > g.fill[brightest] ? b : brightest;
    }
    assert_int_equal(brightest, 5 * SPHERE_COLUMNS + 3);
    for (int i = 0; i < N * N; i++)
        records[i].radiance = vec(0, 0, 0);
    gather(&look, 12, 12, &g);
    assert_false(g.valid);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mixture_samples_follow_pdf),
        cmocka_unit_test(test_map_without_light_is_refused),
        cmocka_unit_test(test_extreme_random_numbers_are_safe),
        cmocka_unit_test(test_maps_of_other_surfaces_are_left_out),
        cmocka_unit_test(test_range_compressor_inverts),
        cmocka_unit_test(test_gather_finds_the_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
