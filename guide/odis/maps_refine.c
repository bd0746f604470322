/* SPDX-License-Identifier: Apache-2.0 */
/* Sampling maps that learn from the samples they draw: the network's map is the prior. */

#include <float.h>
#include <stdlib.h>

#include "guide/odis/gather.h"
#include "guide/odis/maps.h"
#include "guide/trace/team.h"
#include "guide/trace/tiles.h"

#define PRIOR_SAMPLES 16.0f /* of a bin that the network's estimate counts for */

#define SAME_SIDE        0.8f /* least cosine between the normals of a sample and of its map */
#define FRACTION_SAMPLES 2000 /* of a map after which the network's BSDF fraction has halved */

struct map_sums {
    float prior[SPHERE_BINS];  /* squared root second moment that the network expects */
    float moment[SPHERE_BINS]; /* sum of squared samples */
    float count[SPHERE_BINS];
    float bsdf_fraction; /* the network's */
    int samples;
};

struct map_sums *map_sums_create(int maps) {
    return calloc((size_t)maps + 1, sizeof(struct map_sums));
}

size_t map_sums_bytes(void) {
    return sizeof(struct map_sums);
}

void map_sums_start(struct fewray_maps *maps, int m, const float wanted[SPHERE_BINS], float unit) {
    struct map_sums *sums = &maps->sums[m];
    for (int b = 0; b < SPHERE_BINS; b++)
        sums->prior[b] = wanted[b] * wanted[b] * unit * unit;
    sums->bsdf_fraction = maps->maps[m].bsdf_fraction;
}

void maps_learn(struct fewray_maps *maps, int x, int y, const struct look_record *record) {
    int m =
        maps->index[(size_t)(y / BLOCK_SIZE) * (size_t)maps->columns + (size_t)(x / BLOCK_SIZE)];
    float value = record->emitted + record->reflected;
    if (m < 0 || !(record->depth > 0) || !(value * value < FLT_MAX) ||
        !(dot(record->normal, maps->maps[m].normal) > SAME_SIDE))
        return;
    struct map_sums *sums = &maps->sums[m];
    sums->moment[record->bin] += value * value;
    sums->count[record->bin] += 1;
    sums->samples++;
}

static void refine_map(const struct fewray_maps *maps, struct map *map,
                       const struct map_sums *sums) {
    float cosine[SPHERE_BINS], wanted[SPHERE_BINS];
    sphere_cosines(map->normal, cosine);
    for (int b = 0; b < SPHERE_BINS; b++) {
        float moment =
            (sums->moment[b] + PRIOR_SAMPLES * sums->prior[b]) / (sums->count[b] + PRIOR_SAMPLES);
        wanted[b] = sqrtf(moment);
    }
    if (!maps_set(maps, map, cosine, wanted))
        return;
    if (maps->fixed_fraction)
        return;
    float fraction =
        sums->bsdf_fraction * FRACTION_SAMPLES / (float)(FRACTION_SAMPLES + sums->samples);
    map->bsdf_fraction = fmaxf(fraction, fminf(sums->bsdf_fraction, MAP_LEAST_FRACTION));
}

void maps_refine(struct fewray_maps *maps, int threads) {
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads)
    for (int m = 0; m < maps->count; m++)
        if (maps->sums[m].samples > 0)
            refine_map(maps, &maps->maps[m], &maps->sums[m]);
}

static int map_owner(const void *user, struct team_deal deal, size_t m) {
    const struct block_range *blocks = &((const struct map *)user)[m].blocks;
    return team_owner(deal, blocks->i0 * BLOCK_SIZE / TILE_SIZE,
                      blocks->j0 * BLOCK_SIZE / TILE_SIZE);
}

int maps_exchange(struct fewray_maps *maps, const struct fewray_team *team,
                  struct fewray_error *error) {
    return team_share(team, maps->maps, sizeof(*maps->maps), (size_t)maps->count, map_owner,
                      maps->maps, error);
}
