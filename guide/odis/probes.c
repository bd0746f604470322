/* SPDX-License-Identifier: Apache-2.0 */
/* Probes: pooling of the look's second vertices, lookup. */

#include "guide/odis/probes.h"

#include <stdlib.h>

#include "guide/odis/density.h"
#include "guide/odis/probe_build.h"

#define VOXELS_PER_DISTANCE 14 /* fine ones, to the median first hit */
#define COARSE              5  /* fine voxels a side; odd, so that none straddles two coarse ones */
#define DEPTH_SAMPLES       1024
#define LEAST_RECORDS       6 /* fewer say nothing */

static int compare_floats(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Median distance of the first hits, of evenly spaced records; 0 where nothing was hit. */
static float median_depth(const struct fewray_look *look) {
    size_t n = (size_t)look->width * (size_t)look->height * (size_t)look->samples;
    size_t step = n / DEPTH_SAMPLES + 1;
    float depths[DEPTH_SAMPLES];
    size_t count = 0;
    for (size_t i = 0; i < n && count < DEPTH_SAMPLES; i += step)
        if (look->records[i].depth > 0)
            depths[count++] = look->records[i].depth;
    if (!count)
        return 0;
    qsort(depths, count, sizeof(float), compare_floats);
    return depths[count / 2];
}

/* Which records a probe pools. */
struct pooling {
    size_t records;
    int32_t *probe;    /* (records) a record's probe; -1 = it has no second vertex */
    uint32_t *indices; /* records sorted by probe, in their own order */
    uint32_t *first;   /* (probes + 1) where a probe's indices begin */
};

static void pooling_clear(struct pooling *pooling) {
    free(pooling->probe);
    free(pooling->indices);
    free(pooling->first);
}

static struct vec3 second_position(const struct look_record *r) {
    return add(r->position, scale(r->direction, r->distance));
}

/* Numbers the voxels that hold second vertices. */
static bool find_voxels(const struct fewray_look *look, struct voxel_table *voxels,
                        struct pooling *pooling) {
    for (size_t i = 0; i < pooling->records; i++) {
        const struct look_record *r = &look->records[i];
        pooling->probe[i] = -1;
        if (!(look->seconds[i].albedo > 0))
            continue;
        pooling->probe[i] = voxel_table_add(voxels, second_position(r), r->second_normal);
        if (pooling->probe[i] < 0)
            return false;
    }
    return true;
}

/* Counting sort of the records by probe. */
static bool sort_records(int probes, struct pooling *pooling) {
    pooling->first = calloc((size_t)probes + 2, sizeof(*pooling->first));
    pooling->indices = malloc((pooling->records + 1) * sizeof(*pooling->indices));
    if (!pooling->first || !pooling->indices)
        return false;
    uint32_t *next = pooling->first + 1;
    for (size_t i = 0; i < pooling->records; i++)
        if (pooling->probe[i] >= 0)
            next[pooling->probe[i] + 1]++;
    for (int k = 0; k < probes; k++)
        next[k + 1] += next[k];
    for (size_t i = 0; i < pooling->records; i++)
        if (pooling->probe[i] >= 0)
            pooling->indices[next[pooling->probe[i]]++] = (uint32_t)i;
    return true;
}

/* Sorts the look's second vertices into voxels. */
static bool pool(const struct fewray_look *look, struct probe_level *level,
                 struct pooling *pooling) {
    pooling->records = (size_t)look->width * (size_t)look->height * (size_t)look->samples;
    pooling->probe = malloc((pooling->records + 1) * sizeof(*pooling->probe));
    if (!pooling->probe || !find_voxels(look, &level->voxels, pooling) ||
        !sort_records(level->voxels.count, pooling))
        return false;
    level->probes = malloc(((size_t)level->voxels.count + 1) * sizeof(*level->probes));
    return level->probes != NULL;
}

static void keep_record(struct look_record *r) {
    r->mean = r->moment = r->emitted + r->reflected;
}

/* A record's mean and moment, from a probe that pools enough. */
static void pool_record(const struct probes *p, const struct look_second *second,
                        struct look_record *r) {
    const struct probe *probe =
        second->albedo > 0 ? probes_at(p, second_position(r), r->second_normal) : NULL;
    if (!probe) {
        keep_record(r);
        return;
    }
    float e = r->emitted, mean = second->albedo * probe->mean;
    r->mean = e + mean;
    r->moment = sqrtf(e * (e + 2 * mean) + second->albedo * second->albedo * probe->moment);
}

/* The coarse voxel that a fine one lies in. */
static int parent_of(const struct fewray_look *look, const struct probes *p, uint32_t record) {
    const struct look_record *r = &look->records[record];
    return voxel_table_find(&p->coarse.voxels, second_position(r), r->second_normal);
}

static void build_probes(const struct fewray_look *look, struct probes *p,
                         const struct pooling *fine, const struct pooling *coarse,
                         struct probe_prior *priors, int threads) {
#pragma omp parallel num_threads(threads)
    {
#pragma omp for schedule(dynamic, 16)
        for (int k = 0; k < p->coarse.voxels.count; k++) {
            uint32_t first = coarse->first[k], end = coarse->first[k + 1];
            probe_build(look, coarse->indices + first, (int)(end - first), NULL,
                        &p->coarse.probes[k], &priors[k]);
        }
#pragma omp for schedule(dynamic, 64)
        for (int k = 0; k < p->fine.voxels.count; k++) {
            uint32_t first = fine->first[k], end = fine->first[k + 1];
            int parent = parent_of(look, p, fine->indices[first]);
            probe_build(look, fine->indices + first, (int)(end - first),
                        parent < 0 ? NULL : &priors[parent], &p->fine.probes[k], NULL);
        }
    }
}

int probes_create(struct fewray_look *look, int threads, struct probes **out,
                  struct fewray_error *error) {
    *out = NULL;
    struct pooling fine = {0}, coarse = {0};
    struct probe_prior *priors = NULL;
    struct probes *p = calloc(1, sizeof(*p));
    bool complete = p != NULL;
    if (complete) {
        float depth = median_depth(look);
        p->fine.voxels.side = depth > 0 ? depth / VOXELS_PER_DISTANCE : 1;
        p->coarse.voxels.side = COARSE * p->fine.voxels.side;
        complete = pool(look, &p->fine, &fine) && pool(look, &p->coarse, &coarse);
    }
    if (complete) {
        priors = malloc(((size_t)p->coarse.voxels.count + 1) * sizeof(*priors));
        complete = priors != NULL;
    }
    if (complete) {
        build_probes(look, p, &fine, &coarse, priors, threads);
#pragma omp parallel for schedule(static) num_threads(threads)
        for (size_t i = 0; i < fine.records; i++)
            pool_record(p, &look->seconds[i], &look->records[i]);
        *out = p;
    } else {
        probes_destroy(&p);
    }
    free(priors);
    pooling_clear(&fine);
    pooling_clear(&coarse);
    return complete ? FEWRAY_OK
                    : fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                                  "no memory for the guide's probes");
}

void probes_do_without(struct fewray_look *look, int threads) {
    size_t n = (size_t)look->width * (size_t)look->height * (size_t)look->samples;
#pragma omp parallel for schedule(static) num_threads(threads)
    for (size_t i = 0; i < n; i++)
        keep_record(&look->records[i]);
}

static void level_clear(struct probe_level *level) {
    free(level->probes);
    voxel_table_clear(&level->voxels);
}

void probes_destroy(struct probes **probes) {
    if (!*probes)
        return;
    level_clear(&(*probes)->fine);
    level_clear(&(*probes)->coarse);
    free(*probes);
    *probes = NULL;
}

static const struct probe *level_at(const struct probe_level *level, struct vec3 position,
                                    struct vec3 normal) {
    int k = voxel_table_find(&level->voxels, position, normal);
    return k >= 0 && level->probes[k].records >= LEAST_RECORDS ? &level->probes[k] : NULL;
}

const struct probe *probes_at(const struct probes *p, struct vec3 position, struct vec3 normal) {
    const struct probe *probe = level_at(&p->fine, position, normal);
    return probe ? probe : level_at(&p->coarse, position, normal);
}

struct vec3 probe_sample(const struct probe *probe, const float u[2]) {
    return density_sample(probe->row_cdf, probe->density, PROBE_SIZE, u);
}

float probe_pdf(const struct probe *probe, struct vec3 direction) {
    return probe->density[density_bin(direction, PROBE_SIZE)];
}
