/* SPDX-License-Identifier: Apache-2.0 */
/* Maps that learn from their samples: the network's map as prior, the samples' moments in the end.
 */

#include "tests/unit/check.h"

#include <string.h>

#include "guide/odis/gather.h"
#include "guide/odis/maps.h"
#include "guide/trace/sampler.h"

enum { MAPS = 5 };

static float uniform(uint32_t stream, uint32_t i) {
    return to_unit_float(hash_combine(stream, i));
}

/* One row of blocks, a map each, all facing up; the last block has none. */
static struct fewray_maps *make_maps(float bsdf_fraction) {
    struct fewray_maps *maps = calloc(1, sizeof(*maps));
    *maps = (struct fewray_maps){.columns = MAPS + 1,
                                 .rows = 1,
                                 .width = (MAPS + 1) * BLOCK_SIZE,
                                 .height = BLOCK_SIZE,
                                 .count = MAPS,
                                 .maps = calloc(MAPS, sizeof(*maps->maps)),
                                 .index = calloc(MAPS + 1, sizeof(*maps->index)),
                                 .sums = map_sums_create(MAPS)};
    for (int m = 0; m < MAPS; m++) {
        maps->index[m] = m;
        maps->maps[m].normal = vec(0, 1, 0);
        maps->maps[m].bsdf_fraction = bsdf_fraction;
    }
    maps->index[MAPS] = -1;
    return maps;
}

/* Root second moments that the "network" expects, relative to `unit`. */
static void start(struct fewray_maps *maps, const float wanted[SPHERE_BINS], float unit) {
    float cosine[SPHERE_BINS], values[SPHERE_BINS];
    sphere_cosines(vec(0, 1, 0), cosine);
    for (int b = 0; b < SPHERE_BINS; b++)
        values[b] = cosine[b] * wanted[b];
    for (int m = 0; m < MAPS; m++) {
        map_sums_start(maps, m, wanted, unit);
        assert_true(map_set_density(&maps->maps[m], values));
    }
}

static float prior_of(int bin) {
    return 0.1f + 3 * uniform(7, (uint32_t)bin);
}

static void prior(float wanted[SPHERE_BINS]) {
    for (int b = 0; b < SPHERE_BINS; b++)
        wanted[b] = b < SPHERE_BINS / 2 ? prior_of(b) : 0;
}

static void learn(struct fewray_maps *maps, int m, int bin, float value) {
    struct look_record record = {.normal = vec(0, 1, 0),
                                 .depth = 1,
                                 .bin = (uint16_t)bin,
                                 .emitted = 0.25f * value,
                                 .reflected = 0.75f * value};
    maps_learn(maps, m * BLOCK_SIZE + bin % BLOCK_SIZE, bin / 8 % BLOCK_SIZE, &record);
}

/* What map m should be of these root second moments. */
static void assert_map(const struct fewray_maps *maps, int m, const double moment[SPHERE_BINS],
                       double tolerance) {
    float cosine[SPHERE_BINS];
    double total = 0, density = 0;
    sphere_cosines(vec(0, 1, 0), cosine);
    for (int b = 0; b < SPHERE_BINS; b++) {
        total += cosine[b] * moment[b] * SPHERE_BIN_SOLID_ANGLE;
        density += maps->maps[m].density[b] * SPHERE_BIN_SOLID_ANGLE;
    }
    assert_near(density, 1, 1e-4);
    for (int b = 0; b < SPHERE_BINS; b++) {
        double expected = cosine[b] * moment[b] / total;
        assert_near(maps->maps[m].density[b], expected, tolerance * expected);
    }
}

static void destroy(struct fewray_maps *maps) {
    fewray_maps_destroy(&maps);
}

/* Samples are all or nothing: their root second moment is not their mean. */
static void test_map_converges_to_root_second_moment(void **state) {
    (void)state;
    struct fewray_maps *maps = make_maps(0.5f);
    float wanted[SPHERE_BINS];
    double moment[SPHERE_BINS];
    prior(wanted);
    start(maps, wanted, 1);
    for (int b = 0; b < SPHERE_BINS; b++) {
        double radiance = 0.5 + 20 * pow(uniform(8, (uint32_t)b), 4),
               chance = 0.3 + 0.7 * uniform(9, (uint32_t)b);
        moment[b] = b < SPHERE_BINS / 2 ? radiance / sqrt(chance) : 0;
        for (uint32_t i = 0; b < SPHERE_BINS / 2 && i < 6000; i++)
            learn(maps, 1, b,
                  uniform((uint32_t)b + 100, i) < chance ? (float)(radiance / chance) : 0);
    }
    maps_refine(maps, 2);
    assert_map(maps, 1, moment, 0.07);
    destroy(maps);
}

static void test_prior_and_samples_are_weighed_by_their_numbers(void **state) {
    (void)state;
    struct fewray_maps *maps = make_maps(0.5f);
    float wanted[SPHERE_BINS];
    double moment[SPHERE_BINS];
    const float unit = 7;
    prior(wanted);
    start(maps, wanted, unit);
    for (int b = 0; b < SPHERE_BINS; b++)
        moment[b] = unit * wanted[b];
    learn(maps, 0, 40, unit * wanted[40]); /* as expected: changes nothing */
    learn(maps, 1, 50, 0);
    for (int k = 0; k < 1000; k++)
        learn(maps, 2, 60, 0);
    maps_refine(maps, 1);
    assert_map(maps, 0, moment, 1e-4);
    moment[50] *= sqrt(16.0 / 17);
    assert_map(maps, 1, moment, 1e-4);
    moment[50] = unit * wanted[50];
    moment[60] *= sqrt(16.0 / 1016);
    assert_map(maps, 2, moment, 1e-4);
    for (int m = 0; m < 3; m++) /* what the network expects is never ruled out */
        for (int b = 0; b < SPHERE_BINS / 2; b++)
            assert_true(maps->maps[m].density[b] > 0);
    destroy(maps);
}

/* What was learnt before counts on. */
static void test_refining_twice_is_refining_once(void **state) {
    (void)state;
    struct fewray_maps *maps = make_maps(0.5f);
    float wanted[SPHERE_BINS];
    prior(wanted);
    start(maps, wanted, 1);
    for (uint32_t i = 0; i < 2000; i++)
        for (int m = 0; m < 2; m++) {
            learn(maps, m, (int)(uniform(1, i) * SPHERE_BINS / 2), 5 * uniform(2, i));
            if (m == 1 && i % 500 == 0)
                maps_refine(maps, 1);
        }
    maps_refine(maps, 1);
    assert_memory_equal(&maps->maps[0], &maps->maps[1], sizeof(struct map));
    destroy(maps);
}

static void test_bsdf_fraction_falls_with_samples(void **state) {
    (void)state;
    const float first[] = {0.8f, 0.05f};
    for (int k = 0; k < 2; k++) {
        struct fewray_maps *maps = make_maps(first[k]);
        float wanted[SPHERE_BINS], last = first[k];
        prior(wanted);
        start(maps, wanted, 1);
        for (int round = 0; round < 5; round++) {
            for (int i = 0; i < 300 << (2 * round); i++)
                learn(maps, 3, i % (SPHERE_BINS / 2), 1);
            maps_refine(maps, 1);
            float fraction = maps->maps[3].bsdf_fraction;
            assert_true(fraction <= last && fraction >= fminf(first[k], 0.1f));
            last = fraction;
        }
        assert_near(last, k == 0 ? 0.1 : 0.05, 1e-6);
        assert_near(maps->maps[2].bsdf_fraction, first[k], 0); /* it learnt nothing */
        destroy(maps);
    }
}

static void test_bad_samples_are_safe(void **state) {
    (void)state;
    struct fewray_maps *maps = make_maps(0.5f);
    float wanted[SPHERE_BINS];
    prior(wanted);
    start(maps, wanted, 1);
    struct map before = maps->maps[0];
    learn(maps, 0, 33, NAN);
    learn(maps, 0, 33, INFINITY);
    struct look_record miss = {.depth = 0, .emitted = 5};
    maps_learn(maps, 3, 3, &miss);
    learn(maps, MAPS, 33, 1); /* no map there */
    learn(maps, 1, 33, 1e30f);
    learn(maps, 2, SPHERE_BINS - 1, 1e10f); /* below the horizon */
    learn(maps, 4, 33, NAN);
    learn(maps, 4, 50, 0);
    maps_refine(maps, 2);
    double moment[SPHERE_BINS]; /* the good sample counts in spite of the bad one */
    for (int b = 0; b < SPHERE_BINS; b++)
        moment[b] = wanted[b] * (b == 50 ? sqrt(16.0 / 17) : 1);
    assert_map(maps, 4, moment, 1e-4);
    assert_memory_equal(&before, &maps->maps[0], sizeof(before));
    for (int m = 0; m < 3; m++) {
        double sum = 0;
        for (int b = 0; b < SPHERE_BINS; b++) {
            assert_true(b < SPHERE_BINS / 2 ? maps->maps[m].density[b] >= 0
                                            : maps->maps[m].density[b] == 0);
            sum += maps->maps[m].density[b] * SPHERE_BIN_SOLID_ANGLE;
        }
        assert_near(sum, 1, 1e-4);
    }
    destroy(maps);
}

static void test_same_bits_on_any_number_of_threads(void **state) {
    (void)state;
    struct fewray_maps *both[2];
    for (int k = 0; k < 2; k++) {
        both[k] = make_maps(0.5f);
        float wanted[SPHERE_BINS];
        prior(wanted);
        start(both[k], wanted, 3);
        for (uint32_t i = 0; i < 5000; i++)
            learn(both[k], (int)(i % MAPS), (int)(uniform(1, i) * SPHERE_BINS / 2),
                  5 * uniform(2, i));
        maps_refine(both[k], k == 0 ? 1 : 3);
    }
    assert_memory_equal(both[0]->maps, both[1]->maps, MAPS * sizeof(struct map));
    destroy(both[0]);
    destroy(both[1]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_map_converges_to_root_second_moment),
        cmocka_unit_test(test_prior_and_samples_are_weighed_by_their_numbers),
        cmocka_unit_test(test_refining_twice_is_refining_once),
        cmocka_unit_test(test_bsdf_fraction_falls_with_samples),
        cmocka_unit_test(test_bad_samples_are_safe),
        cmocka_unit_test(test_same_bits_on_any_number_of_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
