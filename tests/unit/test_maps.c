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
    map->bsdf_fraction = 0.25f;
    assert_true(map_set_density(map, values));
}

static void test_mixture_samples_follow_pdf(void **state) {
    (void)state;
    static struct map a, b;
    fill_map(&a, 1, vec(0, 1, 0));
    fill_map(&b, 2, vec(0, 1, 0));
    struct map_mixture mixture = {2, {&a, &b}, {0.3f, 0.7f}, 0.25f};
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
    struct map_mixture mixture = {1, {&map}, {1}, 0.25f};
    const float ends[] = {0, 0x1.fffffep-1f};
    for (int i = 0; i < 4; i++) {
        struct vec3 d = map_mixture_sample(&mixture, (float[2]){ends[i / 2], ends[i % 2]});
        assert_true(isfinite(d.x + d.y + d.z));
        assert_int_equal(sphere_bin(d), SPHERE_BINS - 1);
    }
}

/* 2 x 2 blocks with a map each, on a plane. */
static struct fewray_maps four_maps(struct map grid[4], int32_t index[4]) {
    for (int i = 0; i < 4; i++) {
        fill_map(&grid[i], (uint32_t)i, vec(0, 1, 0));
        grid[i].position = vec((float)(i % 2), 0, (float)(i / 2));
        index[i] = i;
    }
    return (struct fewray_maps){.columns = 2,
                                .rows = 2,
                                .width = 2 * BLOCK_SIZE,
                                .height = 2 * BLOCK_SIZE,
                                .count = 4,
                                .maps = grid,
                                .index = index};
}

static void test_maps_of_other_surfaces_are_left_out(void **state) {
    (void)state;
    static struct map grid[4];
    int32_t index[4];
    struct fewray_maps maps = four_maps(grid, index);
    struct vec3 up = vec(0, 1, 0), middle = vec(0.5f, 0, 0.5f);
    struct map_mixture m = maps_at(&maps, 7, 8, middle, up);
    const float expected[4] = {0.5625f * 0.4375f, 0.4375f * 0.4375f, 0.5625f * 0.5625f,
                               0.4375f * 0.5625f};
    assert_int_equal(m.count, 4);
    for (int k = 0; k < 4; k++)
        assert_near(m.share[k], expected[k], 1e-5);
    assert_near(m.bsdf_fraction, 0.25, 1e-5);
    assert_int_equal(maps_at(&maps, 7, 8, middle, vec(1, 0, 0)).count, 0);
    assert_int_equal(maps_at(&maps, 15, 15, vec(1, 0, 1), up).count, 1);
    assert_ptr_equal(maps_at(&maps, 15, 15, vec(1, 0, 1), up).maps[0], &grid[3]);
    assert_ptr_equal(maps_at(&maps, 0, 0, vec(0, 0, 0), up).maps[0], &grid[0]);
    grid[0].position.y = 5;
    m = maps_at(&maps, 7, 8, middle, up);
    for (int k = 0; k < m.count; k++)
        assert_true(m.maps[k] != &grid[0] || m.share[k] < 1e-3);
}

static void test_blocks_of_one_map_count_once(void **state) {
    (void)state;
    static struct map grid[4];
    int32_t index[4];
    struct fewray_maps maps = four_maps(grid, index);
    index[1] = index[2] = 0;
    index[3] = -1;
    struct map_mixture m = maps_at(&maps, 7, 7, vec(0.5f, 0, 0.5f), vec(0, 1, 0));
    assert_int_equal(m.count, 1);
    assert_near(m.share[0], 1, 1e-6);
    index[0] = index[1] = index[2] = -1;
    assert_int_equal(maps_at(&maps, 7, 7, vec(0.5f, 0, 0.5f), vec(0, 1, 0)).count, 0);
    float confidence;
    assert_near(maps_irradiance(&maps, 7, 7, vec(0, 1, 0), &confidence).x, 0, 0);
    assert_near(confidence, 0, 0);
}

static void test_maps_that_get_few_samples_are_left_out(void **state) {
    (void)state;
    static struct map grid[4];
    int32_t index[4];
    struct fewray_maps maps = four_maps(grid, index);
    struct vec3 up = vec(0, 1, 0), middle = vec(0.5f, 0, 0.5f);
    grid[0].bsdf_fraction = grid[1].bsdf_fraction = 0.97f;
    struct map_mixture m = maps_at(&maps, 7, 8, middle, up);
    assert_int_equal(m.count, 2);
    assert_near(m.share[0] + m.share[1], 1, 1e-6);
    assert_near(m.bsdf_fraction, 0.4375 + 0.5625 * 0.25, 1e-5);
    grid[2].bsdf_fraction = grid[3].bsdf_fraction = 1;
    assert_int_equal(maps_at(&maps, 7, 8, middle, up).count, 0);
}

static void test_range_compressor_inverts(void **state) {
    (void)state;
    for (float x = 1e-7f; x < 1000; x *= 1.7f) {
        double exact = log1p(5000.0 * x) / log1p(5000.0);
        assert_near(range_compress(x) / exact, 1, 1e-6);
        assert_near(range_expand((float)exact) / x, 1, 1e-5);
    }
}

/* A look of random records over rough ground, with some holes and some bounces into the void. */
enum { LOOK_WIDTH = 37, LOOK_HEIGHT = 29, LOOK_SAMPLES = 2 };

static float random_float(uint32_t record, uint32_t k) {
    return to_unit_float(hash_combine(record, k));
}

static struct fewray_look random_look(struct look_record *records) {
    for (uint32_t i = 0; i < LOOK_WIDTH * LOOK_HEIGHT * LOOK_SAMPLES; i++) {
        struct look_record *r = &records[i];
        float y = 1 - 2 * random_float(i, 1), phi = 2 * PI_F * random_float(i, 2);
        float value = powf(10, 6 * random_float(i, 3) - 4);
        *r = (struct look_record){
            .depth = random_float(i, 4) < 0.1f ? 0 : 1 + random_float(i, 5),
            .direction = vec(sqrtf(1 - y * y) * sinf(phi), y, sqrtf(1 - y * y) * cosf(phi)),
            .radiance = vec(value, 2 * value, 3 * value),
            .emitted = value,
            .reflected = value * random_float(i, 6),
            .mean = value * (0.5f + random_float(i, 7)),
            .moment = value * (1.5f + random_float(i, 8))};
        r->normal = normalize(vec(random_float(i, 9) - 0.5f, 1, random_float(i, 10) - 0.5f));
        r->bin = (uint16_t)sphere_bin(r->direction);
        if (random_float(i, 11) < 0.8f) {
            r->distance = powf(10, 8 * random_float(i, 12) - 3);
            r->second_normal = negate(r->direction);
        }
    }
    records[(10 * LOOK_WIDTH + 20) * LOOK_SAMPLES].depth = 1.5f;
    return (struct fewray_look){LOOK_WIDTH, LOOK_HEIGHT, LOOK_SAMPLES, records, NULL};
}

/* The values that gather() promises for one bin, in double precision; false: the bin is empty. */
static bool bin_planes(const struct fewray_look *look, int x0, int y0, int x1, int y1,
                       const struct gathered *g, int bin, float depth, double p[GATHER_PLANES]) {
    double n = 0, hits = 0;
    memset(p, 0, GATHER_PLANES * sizeof(*p));
    for (int y = y0; y < y1; y++)
        for (int i = x0 * look->samples; i < x1 * look->samples; i++) {
            const struct look_record *r = &look->records[y * look->width * look->samples + i];
            if (r->bin != bin || r->depth <= 0 || dot(r->direction, g->normal) <= 0)
                continue;
            double own = (double)r->emitted + r->reflected;
            n++;
            p[GATHER_RADIANCE] += r->mean;
            p[GATHER_POOLED_MOMENT] += (double)r->moment * r->moment;
            p[GATHER_MOMENT] += own * own;
            p[GATHER_DEPTH] += r->depth;
            hits += r->distance > 0;
            p[GATHER_DISTANCE] += r->distance;
            const float *normal = &r->normal.x, *second = &r->second_normal.x;
            for (int k = 0; k < 3; k++) {
                p[GATHER_NORMAL + k] += normal[k];
                p[GATHER_SECOND_NORMAL + k] += second[k];
            }
        }
    if (n == 0)
        return false;
    p[GATHER_COUNT] = log2(1 + n) / 4;
    for (int k = 0; k < GATHER_PLANES; k++)
        if (k != GATHER_COUNT)
            p[k] /= k < GATHER_DISTANCE ? n : fmax(hits, 1);
    p[GATHER_RADIANCE] = log1p(5000 * p[GATHER_RADIANCE] / g->scale) / log(5001);
    p[GATHER_POOLED_MOMENT] = log1p(5000 * sqrt(p[GATHER_POOLED_MOMENT]) / g->scale) / log(5001);
    p[GATHER_MOMENT] = log1p(5000 * sqrt(p[GATHER_MOMENT]) / g->scale) / log(5001);
    p[GATHER_DEPTH] = fmin(p[GATHER_DEPTH] / depth, 4);
    p[GATHER_DISTANCE] = log1p(fmin(p[GATHER_DISTANCE] / depth, 1e4));
    return true;
}

/* Planes against the plain computation: sums, clamping to the picture, and the logarithms over
 * seven decades of radiance and distance. */
static void test_gather_equals_plain_computation(void **state) {
    (void)state;
    static struct look_record records[LOOK_WIDTH * LOOK_HEIGHT * LOOK_SAMPLES];
    struct fewray_look look = random_look(records);
    static struct gathered g;
    gather(&look, 1, -1, 5, 3, 20, 10, &g); /* columns 8..36, rows 0..23 */
    assert_true(g.valid);
    double scale_sum = 0, filled = 0;
    for (int b = 0; b < SPHERE_BINS; b++) {
        double p[GATHER_PLANES];
        struct vec3 centre = sphere_direction(b / SPHERE_COLUMNS, b % SPHERE_COLUMNS, 0.5f, 0.5f);
        assert_near(g.cosine[b], fmaxf(0, dot(centre, g.normal)), 1e-5);
        bool full = bin_planes(&look, 8, 0, LOOK_WIDTH, 24, &g, b, 1.5f, p) && g.cosine[b] > 0;
        assert_near(g.mask[b], full, 0);
        for (int k = 0; k < GATHER_PLANES; k++)
            assert_near(g.planes[k][b], full ? p[k] : 0, 2e-6 * (1 + fabs(p[k])));
        if (full) {
            scale_sum += (exp(p[GATHER_RADIANCE] * log(5001)) - 1) / 5000 * g.scale;
            filled++;
        }
    }
    assert_near(g.scale * filled / scale_sum, 1, 1e-5);
}

/* One record in each bin: the fill is the mean of the record and of the coarser levels' means. */
static void test_fill_is_push_pull_of_pooled_moment(void **state) {
    (void)state;
    enum { N = 32 };
    static struct look_record records[N * N];
    static double mean[N * N], finer[N * N];
    struct fewray_look look = {N, N, 1, records, NULL};
    for (int b = 0; b < N * N; b++) {
        float value = powf(10, 5 * random_float((uint32_t)b, 1) - 3);
        struct vec3 d = sphere_direction(b / N, b % N, 0.5f, 0.5f);
        records[b] = (struct look_record){.normal = vec(0, 1, 0),
                                          .depth = 1,
                                          .direction = d,
                                          .bin = (uint16_t)b,
                                          .radiance = vec(1, 1, 1),
                                          .mean = value,
                                          .moment = value};
    }
    static struct gathered g;
    gather(&look, 0, 0, 4, 4, 16, 16, &g);
    assert_true(g.valid);
    for (int size = 1; size <= N; size *= 2) {
        int cell = N / size;
        for (int y = 0; y < size; y++)
            for (int x = 0; x < size; x++) {
                double n = 0, sum = 0;
                for (int k = 0; k < cell * cell; k++) {
                    int b = (y * cell + k / cell) * N + x * cell + k % cell;
                    if (b < N * N / 2) { /* above the horizon */
                        n++;
                        sum += (double)records[b].moment * records[b].moment;
                    }
                }
                double coarse = size > 1 ? mean[y / 2 * (size / 2) + x / 2] : 0;
                finer[y * size + x] = size > 1 ? (sum + coarse) / (n + 1) : sum / n;
            }
        memcpy(mean, finer, sizeof(mean));
    }
    for (int b = 0; b < N * N; b++)
        assert_near(g.fill[b], log(sqrt(mean[b]) / g.scale + 1e-3), 1e-5);
}

static void test_gather_without_light_or_surface_is_invalid(void **state) {
    (void)state;
    static struct look_record records[LOOK_WIDTH * LOOK_HEIGHT * LOOK_SAMPLES];
    struct fewray_look look = random_look(records);
    static struct gathered g;
    for (int i = 0; i < LOOK_WIDTH * LOOK_HEIGHT * LOOK_SAMPLES; i++)
        records[i].mean = 0;
    gather(&look, 1, 0, 4, 3, 20, 10, &g);
    assert_false(g.valid);
    random_look(records);
    for (int s = 0; s < LOOK_SAMPLES; s++)
        records[(10 * LOOK_WIDTH + 20) * LOOK_SAMPLES + s].depth = 0;
    gather(&look, 1, 0, 4, 3, 20, 10, &g);
    assert_false(g.valid);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mixture_samples_follow_pdf),
        cmocka_unit_test(test_map_without_light_is_refused),
        cmocka_unit_test(test_extreme_random_numbers_are_safe),
        cmocka_unit_test(test_maps_of_other_surfaces_are_left_out),
        cmocka_unit_test(test_blocks_of_one_map_count_once),
        cmocka_unit_test(test_maps_that_get_few_samples_are_left_out),
        cmocka_unit_test(test_range_compressor_inverts),
        cmocka_unit_test(test_gather_equals_plain_computation),
        cmocka_unit_test(test_fill_is_push_pull_of_pooled_moment),
        cmocka_unit_test(test_gather_without_light_or_surface_is_invalid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
