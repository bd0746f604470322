/* SPDX-License-Identifier: Apache-2.0 */
/* A probe's averages, map and shadow-ray chances. */

#include "guide/odis/probe_build.h"

#include <string.h>

#include "guide/odis/density.h"

#define SMOOTHING     1.0f  /* events that an even spread within a coarser bin counts for */
#define PRIOR_EVENTS  20.0f /* events that the coarse probe's shares count for */
#define BSDF_FRACTION 0.25f /* where a probe found light */
#define DARK_RAYS     16 /* shadow rays in vain from which on a probe that saw no light is dark */
/* Chance of a shadow ray in a dark probe: light that was overlooked weighs twice at most. */
#define DARK_CHANCE 0.5f

/* Sums of one level of bins. */
struct level {
    float value[PROBE_BINS]; /* of the events: radiance over density */
    float events[PROBE_BINS];
};

/* False where there is nothing to add. */
static bool add_event(struct level *level, struct vec3 direction, float value) {
    if (!(value > 0) || !(value < LOOK_RADIANCE_MAX))
        return false;
    int b = density_bin(direction, PROBE_SIZE);
    level->value[b] += value;
    level->events[b] += 1;
    return true;
}

/* Sums over 2 x 2 bins. */
static void coarsen(const struct level *fine, int size, struct level *coarse) {
    int half = size / 2;
    for (int y = 0; y < half; y++)
        for (int x = 0; x < half; x++) {
            int i = 2 * y * size + 2 * x, o = y * half + x;
            const int four[4] = {i, i + 1, i + size, i + size + 1};
            coarse->value[o] = coarse->events[o] = 0;
            for (int k = 0; k < 4; k++) {
                coarse->value[o] += fine->value[four[k]];
                coarse->events[o] += fine->events[four[k]];
            }
        }
}

/* How a level's values spread over its bins, from coarse to fine: a bin gets of its parent's share
 * what its own events say, drawn towards an even quarter as if SMOOTHING events had said so
 * (hierarchical Dirichlet prior). */
static void spread(const struct level *level, int size, float share[PROBE_BINS]) {
    if (size == 1) {
        share[0] = 1;
        return;
    }
    int half = size / 2;
    struct level parent = {{0}, {0}};
    float parent_share[PROBE_BINS];
    coarsen(level, size, &parent);
    spread(&parent, half, parent_share);
    for (int y = 0; y < size; y++)
        for (int x = 0; x < size; x++) {
            int i = y * size + x, o = y / 2 * half + x / 2;
            float prior = parent.events[o] > 0 ? SMOOTHING * parent.value[o] / parent.events[o] : 1;
            share[i] =
                parent_share[o] * (level->value[i] + 0.25f * prior) / (parent.value[o] + prior);
        }
}

/* The same with a coarse probe's shares, which count for PRIOR_EVENTS, instead of the hierarchy. */
static void spread_over_prior(const struct level *level, const struct probe_prior *prior,
                              float share[PROBE_BINS]) {
    float value = 0, events = 0;
    for (int b = 0; b < PROBE_BINS; b++) {
        value += level->value[b];
        events += level->events[b];
    }
    float weight = events > 0 ? PRIOR_EVENTS * value / events : 1;
    for (int b = 0; b < PROBE_BINS; b++)
        share[b] = (level->value[b] + weight * prior->share[b]) / (value + weight);
}

static void set_map(struct probe *probe, float share[PROBE_BINS]) {
    for (int b = 0; b < PROBE_BINS; b++) {
        struct vec3 centre =
            density_direction(b / PROBE_SIZE, b % PROBE_SIZE, 0.5f, 0.5f, PROBE_SIZE);
        float cosine = dot(centre, probe->normal);
        /* A bin whose centre is just below the horizon still has a part above. */
        share[b] *= fmaxf(cosine, 0) + (cosine > -0.1f ? 0.05f : 0);
    }
    bool lit = density_build(share, PROBE_SIZE, probe->row_cdf, probe->density);
    probe->bsdf_fraction = lit ? BSDF_FRACTION : 1;
}

void probe_build(const struct fewray_look *look, const uint32_t *indices, int count,
                 const struct probe_prior *prior, struct probe *probe,
                 struct probe_prior *as_prior) {
    struct level level = {{0}, {0}};
    struct vec3 normal = vec(0, 0, 0);
    double mean = 0, moment = 0;
    int shadow_rays = 0, events = 0;
    for (int i = 0; i < count; i++) {
        const struct look_record *record = &look->records[indices[i]];
        const struct look_second *second = &look->seconds[indices[i]];
        double reflected = record->reflected / second->albedo;
        normal = add(normal, record->second_normal);
        if (fabs(reflected) < (double)LOOK_RADIANCE_MAX) {
            mean += reflected;
            moment += reflected * reflected;
        }
        shadow_rays += second->light_sent;
        events += add_event(&level, second->light, second->light_value);
        events += add_event(&level, second->bounce, second->bounce_value);
    }
    probe->records = count;
    probe->normal = normalize(normal);
    probe->mean = (float)(mean / count);
    probe->moment = (float)(moment / count);
    probe->light_chance = !events && shadow_rays >= DARK_RAYS ? DARK_CHANCE : 1;
    probe->bsdf_fraction = 1;
    float share[PROBE_BINS];
    if (prior && prior->lit)
        spread_over_prior(&level, prior, share);
    else
        spread(&level, PROBE_SIZE, share);
    if (as_prior) {
        memcpy(as_prior->share, share, sizeof(share));
        as_prior->lit = events > 0;
    }
    if (events || (prior && prior->lit))
        set_map(probe, share);
}
