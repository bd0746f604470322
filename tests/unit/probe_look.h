/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_PROBE_LOOK_H
#define FEWRAY_TESTS_PROBE_LOOK_H

/* Made-up looks whose second vertices lie in known voxels, for the tests of the probes. */

#include "tests/unit/check.h"

#include "guide/odis/density.h"
#include "guide/odis/probes.h"
#include "guide/trace/sampler.h"

#define DEPTH 7.0f /* of all first hits: 14 fine voxels, which are thus 0.5 wide */

/* What one group of second vertices is like; all lie in one voxel. */
struct group {
    struct vec3 centre, normal;
    int records;
    int lit;         /* records whose shadow ray saw the sun */
    int shadow_rays; /* the others that were traced saw nothing */
};

/* Voxels at a quarter of their width, three apart: far from any border. */
#define PLACE(i) (0.5f * (3 * (i) + 0.25f))

/* Number of the coarse voxel, along an axis, that lies around a coordinate. */
static inline int coarse_cell(float x) {
    return (int)floorf(x / (5 * 0.5f) + 0.5f);
}

/* Towards the middle of one of the probes' bins, 50 degrees off both normals. */
static inline struct vec3 sun_direction(void) {
    return density_direction(3, 13, 0.5f, 0.5f, PROBE_SIZE);
}

static inline float uniform(uint32_t record, uint32_t k) {
    return to_unit_float(hash_combine(record + 77, k));
}

static inline struct vec3 around(struct vec3 d, float spread, uint32_t record, uint32_t k) {
    return normalize(
        add(d, vec(spread * (uniform(record, k) - 0.5f), spread * (uniform(record, k + 1) - 0.5f),
                   spread * (uniform(record, k + 2) - 0.5f))));
}

struct scene {
    struct fewray_look look;
    int capacity;
    uint32_t group_of[1 << 17];
};

static inline void scene_init(struct scene *s, int capacity) {
    *s = (struct scene){.capacity = capacity};
    s->look = (struct fewray_look){.width = 0, .height = 1, .samples = 1};
    s->look.records = calloc((size_t)capacity, sizeof(*s->look.records));
    s->look.seconds = calloc((size_t)capacity, sizeof(*s->look.seconds));
    assert_true(s->look.records && s->look.seconds);
}

static inline void scene_clear(struct scene *s) {
    free(s->look.records);
    free(s->look.seconds);
}

static inline void add_record(struct scene *s, const struct group *g, uint32_t number, int k) {
    assert_true(s->look.width < s->capacity);
    uint32_t i = (uint32_t)s->look.width++;
    struct vec3 jitter = vec(uniform(i, 1) - 0.5f, uniform(i, 2) - 0.5f, uniform(i, 3) - 0.5f);
    struct vec3 end = add(g->centre, scale(jitter, 0.04f));
    struct vec3 back = around(g->normal, 0.8f, i, 4);
    float distance = 0.5f + uniform(i, 7);
    s->group_of[i] = number;
    s->look.records[i] = (struct look_record){.position = add(end, scale(back, distance)),
                                              .normal = negate(back),
                                              .depth = DEPTH,
                                              .direction = negate(back),
                                              .bin = (uint16_t)sphere_bin(negate(back)),
                                              .emitted = uniform(i, 8) < 0.2f ? uniform(i, 9) : 0,
                                              .reflected = powf(10, 3 * uniform(i, 10) - 2),
                                              .distance = distance,
                                              .second_normal = around(g->normal, 0.3f, i, 11)};
    s->look.seconds[i] = (struct look_second){.albedo = 0.2f + 0.8f * uniform(i, 14),
                                              .light = around(sun_direction(), 0.1f, i, 15),
                                              .bounce = around(g->normal, 1.5f, i, 18),
                                              .light_value = k < g->lit ? 30 : 0,
                                              .light_sent = k < g->shadow_rays};
}

static inline void add_groups(struct scene *s, const struct group *groups, int count) {
    for (int k = 0; k < 64; k++)
        for (int g = 0; g < count; g++)
            if (k < groups[g].records)
                add_record(s, &groups[g], (uint32_t)g, k);
}

static inline struct probes *make_probes(struct scene *s, int threads) {
    struct probes *probes = NULL;
    struct fewray_error error;
    assert_int_equal(probes_create(&s->look, threads, &probes, &error), FEWRAY_OK);
    return probes;
}

static inline const struct probe *probe_of(const struct probes *probes, const struct group *g) {
    return probes_at(probes, g->centre, g->normal);
}

static inline double integral(const struct probe *probe) {
    double sum = 0;
    for (int b = 0; b < PROBE_BINS; b++) {
        struct vec3 d = density_direction(b / PROBE_SIZE, b % PROBE_SIZE, 0.5f, 0.5f, PROBE_SIZE);
        assert_true(probe_pdf(probe, d) >= 0);
        sum += probe_pdf(probe, d);
    }
    return sum * 4 * (double)PI_F / PROBE_BINS;
}

#endif
