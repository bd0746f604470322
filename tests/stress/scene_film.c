/* SPDX-License-Identifier: Apache-2.0 */
/* The film's sums of a million samples a pixel against sums of long doubles, however they are
 * handed over: at once, in tiles' passes, or one by one. */

#include "../unit/check.h"

#include <stdio.h>

#include "guide/trace/film.h"

enum { SAMPLES = 1000000 };

/* A sample's value, of a mean that the table tells. */
static float even(uint32_t i) {
    return 1 + 1e-3f * to_unit_float(hash_u32(i));
}
static float spread(uint32_t i) {
    return 2 * to_unit_float(hash_u32(i));
}
/* One in a thousand samples brings all the light. */
static float rare(uint32_t i) {
    return hash_u32(i) % 1000 == 0 ? 1000 : 0;
}
static float bright(uint32_t i) {
    return 1e12f * spread(i);
}
static float dim(uint32_t i) {
    return 1e-12f * spread(i);
}
/* Falling all the time: what is added later is always below the mean. */
static float falling(uint32_t i) {
    return 2 - 2e-6f * (float)i;
}

/* Sums are double; each hand-over rounds the stored mean and the stored deviation to floats, by at
 * most 2^-24 and, as it is the sum of two products, 2^-22 of what they are then. */
#define EPSILON 5.96e-8

static const struct {
    const char *name;
    float (*value)(uint32_t);
    int batch;      /* samples handed over at once */
    double highest; /* of the stored mean on the way, over the final one */
} cases[] = {
    {"even, at once", even, SAMPLES, 1.001}, {"even, by 4096", even, 4096, 1.001},
    {"even, one by one", even, 1, 1.001},    {"spread, at once", spread, SAMPLES, 1},
    {"spread, by 64", spread, 64, 1.2},      {"spread, one by one", spread, 1, 2},
    {"rare, by 4096", rare, 4096, 2},        {"rare, one by one", rare, 1, 2},
    {"bright, by 4096", bright, 4096, 1.1},  {"dim, by 4096", dim, 4096, 1.1},
    {"falling, one by one", falling, 1, 2},
};

static void assert_close(const char *name, const char *of, double value, double right,
                         double bound) {
    if (!(fabs(value / right - 1) <= bound))
        fail_msg("%s: %s is off by %.3g, bound %.3g", name, of, value / right - 1, bound);
}

static void add_samples(struct fewray_film *film, float (*value)(uint32_t), int batch) {
    for (int begin = 0; begin < SAMPLES; begin += batch) {
        struct pixel_sums sums = {.count = 0};
        for (int i = begin; i < begin + batch && i < SAMPLES; i++) {
            float v = value((uint32_t)i);
            struct path_sample sample = {.radiance = {v, v, v}, .emission = {v, v, v}, .depth = v};
            pixel_sums_add(&sums, &sample);
        }
        film_add(film, 0, 0, GROUP_REST, &sums);
    }
}

static void test_a_million_samples_keep_their_mean(void **state) {
    (void)state;
    for (size_t k = 0; k < sizeof(cases) / sizeof(*cases); k++) {
        struct pixel_group groups[GROUP_COUNT] = {{0}};
        struct fewray_film film = {
            .width = 1, .height = 1, .group = {&groups[GROUP_LOOK], &groups[GROUP_REST]}};
        long double sum = 0, deviation = 0;
        for (uint32_t i = 0; i < SAMPLES; i++)
            sum += (long double)cases[k].value(i);
        for (uint32_t i = 0; i < SAMPLES; i++) {
            long double d = (long double)cases[k].value(i) - sum / SAMPLES;
            deviation += d * d;
        }
        add_samples(&film, cases[k].value, cases[k].batch);
        const struct pixel_group *g = &groups[GROUP_REST];
        double mean = (double)(sum / SAMPLES);
        double hand_overs = ceil((double)SAMPLES / cases[k].batch);
        double bound = EPSILON * hand_overs * cases[k].highest;
        assert_close(cases[k].name, "radiance", (double)g->radiance[0], mean, bound);
        assert_close(cases[k].name, "emission", (double)g->emission[1], mean, bound);
        assert_close(cases[k].name, "depth", (double)g->depth, mean, bound);
        assert_close(cases[k].name, "deviation", (double)g->deviation[2], (double)deviation,
                     4 * bound);
        assert_int_equal(g->count, SAMPLES);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_million_samples_keep_their_mean),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
