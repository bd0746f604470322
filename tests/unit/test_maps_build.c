/* SPDX-License-Identifier: Apache-2.0 */
/* Sampling maps from made-up looks: which blocks share one, and what they tell of the look's noise.
 */

#include "tests/unit/check.h"

#include <string.h>

#include "guide/odis/gather.h"
#include "guide/odis/maps.h"
#include "guide/trace/sampler.h"

static float random_float(uint32_t record, uint32_t k) {
    return to_unit_float(hash_combine(record, k));
}

enum { GROUND_WIDTH = 44, GROUND_HEIGHT = 32 }; /* 6 x 4 blocks, the last column half */

/* Ground under a lit sky; bumps: height of waves eight pixels long. The left blocks see nothing. */
static struct fewray_look ground_look(struct look_record *records, float bumps) {
    for (int i = 0; i < GROUND_WIDTH * GROUND_HEIGHT; i++) {
        int x = i % GROUND_WIDTH, y = i / GROUND_WIDTH;
        float slope = bumps * cosf((float)x * (PI_F / 4));
        struct vec3 d = normalize(
            vec(random_float((uint32_t)i, 1) - 0.5f, 0.8f, random_float((uint32_t)i, 2) - 0.5f));
        float value = random_float((uint32_t)i, 3);
        records[i] = (struct look_record){
            .position = vec((float)x, bumps * sinf((float)x * (PI_F / 4)), (float)y),
            .normal = normalize(vec(-slope, 1, 0)),
            .depth = x < BLOCK_SIZE ? 0 : 20,
            .direction = d,
            .bin = (uint16_t)sphere_bin(d),
            .radiance = vec(value, value, value),
            .emitted = value,
            .mean = value,
            .moment = value};
    }
    static struct look_second seconds[GROUND_WIDTH * GROUND_HEIGHT];
    return (struct fewray_look){GROUND_WIDTH, GROUND_HEIGHT, 1, records, seconds};
}

static struct fewray_maps *build_maps(struct fewray_look *look,
                                      const struct fewray_render_settings *settings,
                                      struct fewray_render_stats *stats) {
    struct fewray_maps *maps = NULL;
    struct fewray_error error;
    memset(stats, 0, sizeof(*stats));
    assert_int_equal(fewray_maps_create(look, settings, &maps, stats, &error), FEWRAY_OK);
    assert_int_equal(maps->columns, 6);
    assert_int_equal(maps->rows, 4);
    assert_int_equal(stats->grids, 24);
    assert_int_equal(stats->grids_inferred, maps->count);
    return maps;
}

static struct fewray_maps *make_maps(struct fewray_look *look, float bsdf_fraction,
                                     struct fewray_render_stats *stats) {
    struct fewray_render_settings settings;
    fewray_render_settings_init(&settings);
    settings.bsdf_fraction = bsdf_fraction;
    settings.threads = 2;
    return build_maps(look, &settings, stats);
}

static void test_flat_blocks_share_a_map(void **state) {
    (void)state;
    static struct look_record records[GROUND_WIDTH * GROUND_HEIGHT];
    struct fewray_look look = ground_look(records, 0);
    struct fewray_render_stats stats;
    struct fewray_maps *maps = make_maps(&look, 0.5f, &stats);
    assert_int_equal(maps->count, 4 + 4); /* those beside the void have their own */
    for (int b = 0; b < 24; b++) {
        int i = b % 6, j = b / 6, m = maps->index[b];
        assert_true(i == 0 ? m == -1 : m >= 0 && m < maps->count);
        if (i >= 2)
            assert_int_equal(m, maps->index[(j & ~1) * 6 + (i & ~1)]);
        if (i == 1 && j > 0)
            assert_int_not_equal(m, maps->index[b - 6]);
    }
    const struct map *map = &maps->maps[maps->index[2]];
    assert_near(map->position.x, 24, 0);
    assert_near(map->position.z, 8, 0);
    assert_near(map->bsdf_fraction, 0.5, 0);
    assert_true(map->irradiance.x > 0);
    fewray_maps_destroy(&maps);
    assert_null(maps);
}

static void test_bumpy_blocks_have_maps_of_their_own(void **state) {
    (void)state;
    static struct look_record records[GROUND_WIDTH * GROUND_HEIGHT];
    struct fewray_look look = ground_look(records, 0.5f);
    for (int i = 0; i < 8 * GROUND_WIDTH; i++) /* the first row of blocks shows one pixel each */
        if (i / GROUND_WIDTH != 2 || i % GROUND_WIDTH % BLOCK_SIZE != 1)
            records[i].depth = 0;
    struct fewray_render_stats stats;
    struct fewray_maps *maps = make_maps(&look, -1, &stats);
    assert_int_equal(maps->count, 20);
    static int uses[20];
    for (int b = 0; b < 24; b++)
        if (maps->index[b] >= 0)
            uses[maps->index[b]]++;
    for (int m = 0; m < 20; m++)
        assert_int_equal(uses[m], 1);
    const struct map *map = &maps->maps[maps->index[3]];
    assert_near(map->position.x, 25, 0);
    assert_near(map->position.z, 2, 0);
    assert_true(map->bsdf_fraction >= 0.05f && map->bsdf_fraction <= 1);
    fewray_maps_destroy(&maps);
}

/* maps_look_noise() of all blocks. Without probes, which pool the light of blocks far apart. */
static void look_noise(struct fewray_look *look, bool share_maps, float bounce_share,
                       float noise[24]) {
    struct fewray_render_settings settings;
    struct fewray_render_stats stats;
    fewray_render_settings_init(&settings);
    settings.threads = 2;
    settings.share_maps = share_maps;
    settings.bounce_share = bounce_share;
    settings.probes = false;
    struct fewray_maps *maps = build_maps(look, &settings, &stats);
    for (int b = 0; b < 24; b++) {
        noise[b] = maps_look_noise(maps, b % 6 * BLOCK_SIZE + 1, b / 6 * BLOCK_SIZE + 7);
        assert_true(noise[b] > 0 && isfinite(noise[b]));
    }
    fewray_maps_destroy(&maps);
}

/* Gives the records of one block other light. */
static void change_light(struct look_record *records, int block) {
    for (int k = 0; k < BLOCK_SIZE * BLOCK_SIZE; k++) {
        int x = block % 6 * BLOCK_SIZE + k % BLOCK_SIZE;
        int y = block / 6 * BLOCK_SIZE + k / BLOCK_SIZE, i = y * GROUND_WIDTH + x;
        if (x >= GROUND_WIDTH)
            continue;
        float value = k % 3 ? 0.01f : 50;
        records[i].radiance = vec(value, value, value);
        records[i].emitted = records[i].mean = records[i].moment = value;
    }
}

/* A weight that depended on the samples it weighs would bias the picture. */
static void test_look_noise_is_blind_to_the_blocks_own_look(void **state) {
    (void)state;
    static struct look_record records[GROUND_WIDTH * GROUND_HEIGHT];
    for (int share = 0; share < 2; share++) {
        float before[24], after[24];
        struct fewray_look look = ground_look(records, 0);
        look_noise(&look, share, 1, before);
        const int blocks[] = {1, 5, 9, 16, 20, 23}; /* borders and corners, too */
        for (int k = 0; k < 6; k++) {
            ground_look(records, 0);
            change_light(records, blocks[k]);
            look_noise(&look, share, 1, after);
            assert_memory_equal(&after[blocks[k]], &before[blocks[k]], sizeof(float));
            int changed = 0;
            for (int b = 0; b < 24; b++)
                changed += after[b] != before[b];
            assert_true(changed >= 3);
        }
    }
}

/* Bounces spread evenly over the hemisphere, and light by their direction: of a lamp of 10 degrees'
 * radius, or of an even sky. */
static void set_light(struct look_record *records, bool lamp) {
    struct vec3 to_lamp = normalize(vec(0.5f, 0.8f, 0.2f));
    for (uint32_t i = 0; i < GROUND_WIDTH * GROUND_HEIGHT; i++) {
        float u[2];
        sobol_point(i, 5, u);
        float radius = sqrtf(1 - u[0] * u[0]), phi = 2 * PI_F * u[1];
        struct vec3 d = vec(radius * cosf(phi), u[0], radius * sinf(phi));
        float value = !lamp ? 1 : dot(d, to_lamp) > 0.985f ? 100 : 0.01f;
        struct look_record *r = &records[i];
        r->direction = d;
        r->bin = (uint16_t)sphere_bin(d);
        r->radiance = vec(value, value, value);
        r->emitted = r->mean = r->moment = value;
    }
}

/* Even directions suit an even sky nearly as well as the cosine's (4/3 of its second moment), and
 * waste all but a few samples on a lamp. */
static void test_look_noise_tells_lamps_from_skies(void **state) {
    (void)state;
    static struct look_record records[GROUND_WIDTH * GROUND_HEIGHT];
    float noise[24];
    struct fewray_look look = ground_look(records, 0);
    set_light(records, false);
    look_noise(&look, false, 1, noise);
    for (int b = 0; b < 24; b++)
        assert_true(noise[b] > 1 && noise[b] < 2);
    set_light(records, true);
    look_noise(&look, false, 1, noise);
    for (int b = 0; b < 24; b++)
        assert_true(noise[b] > 4);
}

/* The less of the noise comes by the first bounce, the less its sampling matters. */
static void test_look_noise_fades_with_the_bounces_share(void **state) {
    (void)state;
    static struct look_record records[GROUND_WIDTH * GROUND_HEIGHT];
    struct fewray_look look = ground_look(records, 0);
    set_light(records, true);
    float none[24], some[24], all[24];
    look_noise(&look, false, 0, none);
    look_noise(&look, false, 0.3f, some);
    look_noise(&look, false, 1, all);
    for (int b = 0; b < 24; b++) {
        assert_near(none[b], 1, 1e-6);
        assert_true(some[b] > 1 && some[b] < all[b]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_flat_blocks_share_a_map),
        cmocka_unit_test(test_bumpy_blocks_have_maps_of_their_own),
        cmocka_unit_test(test_look_noise_is_blind_to_the_blocks_own_look),
        cmocka_unit_test(test_look_noise_tells_lamps_from_skies),
        cmocka_unit_test(test_look_noise_fades_with_the_bounces_share),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
