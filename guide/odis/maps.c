/* SPDX-License-Identifier: Apache-2.0 */
/* How pixels between grid points use the sampling maps. */

#include "guide/odis/maps.h"

#include "guide/odis/density.h"
#include "guide/odis/gather.h"

#define LEAST_SHARE   1e-3f /* of the bilinear shares: below, the maps belong to other surfaces */
#define WORTHLESS_MAP 0.95f /* BSDF fraction above which a map isn't worth its lookups */
#define CUT_COSINE    0.03f /* that stands for a bin which the horizon cuts below its centre */
#define HIDDEN_SHARE  3e-5f /* of the mean in the bins beyond, which curved surfaces may see */

bool map_set_density(struct map *map, const float values[SPHERE_BINS]) {
    return density_build(values, SPHERE_ROWS, map->row_cdf, map->density);
}

/* Means over merge x merge bins. */
static void merge_bins(float values[SPHERE_BINS], int merge) {
    for (int row = 0; row < SPHERE_ROWS; row += merge)
        for (int column = 0; column < SPHERE_COLUMNS; column += merge) {
            float *corner = values + row * SPHERE_COLUMNS + column, sum = 0;
            for (int k = 0; k < merge * merge; k++)
                sum += corner[k / merge * SPHERE_COLUMNS + k % merge];
            for (int k = 0; k < merge * merge; k++)
                corner[k / merge * SPHERE_COLUMNS + k % merge] = sum / (float)(merge * merge);
        }
}

/* Whether a bin below the horizon touches one above. */
static bool is_cut(const float cosine[SPHERE_BINS], int bin) {
    int row = bin / SPHERE_COLUMNS, column = bin % SPHERE_COLUMNS;
    const float *here = cosine + row * SPHERE_COLUMNS;
    return here[(column + 1) % SPHERE_COLUMNS] > 0 ||
           here[(column + SPHERE_COLUMNS - 1) % SPHERE_COLUMNS] > 0 ||
           (row > 0 && cosine[bin - SPHERE_COLUMNS] > 0) ||
           (row + 1 < SPHERE_ROWS && cosine[bin + SPHERE_COLUMNS] > 0);
}

/* Gives bins whose centres lie below the horizon what they need for no direction to be missed. */
static void cover_horizon(const float cosine[SPHERE_BINS], float values[SPHERE_BINS]) {
    float sum = 0, cosines = 0;
    for (int b = 0; b < SPHERE_BINS; b++) {
        sum += values[b];
        cosines += cosine[b];
    }
    float mean = sum / cosines;
    for (int b = 0; b < SPHERE_BINS; b++)
        if (!(cosine[b] > 0))
            values[b] = mean * (is_cut(cosine, b) ? CUT_COSINE : HIDDEN_SHARE);
}

bool maps_set(const struct fewray_maps *maps, struct map *map, const float cosine[SPHERE_BINS],
              float wanted[SPHERE_BINS]) {
    for (int b = 0; b < SPHERE_BINS; b++)
        wanted[b] *= cosine[b];
    if (!(map->bsdf_fraction > 0))
        cover_horizon(cosine, wanted);
    if (maps->merge > 1)
        merge_bins(wanted, maps->merge);
    return map_set_density(map, wanted);
}

/* The two blocks whose centres enclose pixel x of an axis, and the second one's share. */
static float enclose(int x, int blocks, int *first, int *second) {
    int from_centre = 2 * x + 1 - BLOCK_SIZE; /* half pixels from the first block's centre */
    int i = from_centre < 0 ? 0 : from_centre / (2 * BLOCK_SIZE);
    *first = i < blocks ? i : blocks - 1;
    *second = i + 1 < blocks ? i + 1 : *first;
    return from_centre < 0 ? 0 : (float)(from_centre % (2 * BLOCK_SIZE)) / (2 * BLOCK_SIZE);
}

/* The up to four maps around a pixel and their bilinear shares; returns their number. */
static int neighbours(const struct fewray_maps *maps, int x, int y, const struct map *around[4],
                      float share[4]) {
    int i[2], j[2], count = 0;
    float fx = enclose(x, maps->columns, &i[0], &i[1]), fy = enclose(y, maps->rows, &j[0], &j[1]);
    const float shares[4] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
    for (int k = 0; k < 4; k++) {
        int32_t m = maps->index[(size_t)j[k / 2] * (size_t)maps->columns + (size_t)i[k % 2]];
        if (m < 0 || !(shares[k] > 0))
            continue;
        int n = 0;
        while (n < count && around[n] != &maps->maps[m])
            n++;
        if (n == count) {
            around[count] = &maps->maps[m];
            share[count++] = 0;
        }
        share[n] += shares[k];
    }
    return count;
}

/* 1 where a map's surface continues the point's, falling to 0 with the angle between the normals.
 */
static float same_side(const struct map *map, struct vec3 normal) {
    float d = dot(map->normal, normal);
    if (!(d > 0))
        return 0;
    d *= d;
    d *= d;
    return d * d;
}

/* 1 on the point's tangent plane, falling with the elevation above or below it: about
 * exp(-25 sin^2), without the call. */
static float same_plane(const struct map *map, struct vec3 position, struct vec3 normal) {
    struct vec3 d = sub(map->position, position);
    float distance2 = dot(d, d), height = dot(d, normal);
    if (!(distance2 > 0))
        return 1;
    float w = distance2 / (distance2 + (25.0f / 8) * height * height);
    w *= w;
    w *= w;
    return w * w;
}

struct map_mixture maps_at(const struct fewray_maps *maps, int x, int y, struct vec3 position,
                           struct vec3 normal) {
    const struct map *around[4];
    float share[4], sum = 0, kept = 0;
    int count = neighbours(maps, x, y, around, share);
    struct map_mixture mixture = {.count = 0};
    for (int k = 0; k < count; k++) {
        float s = share[k] * same_side(around[k], normal) * same_plane(around[k], position, normal);
        if (!(s > 0))
            continue;
        sum += s;
        if (around[k]->bsdf_fraction > WORTHLESS_MAP) {
            mixture.bsdf_fraction += s;
            continue;
        }
        mixture.bsdf_fraction += s * around[k]->bsdf_fraction;
        mixture.maps[mixture.count] = around[k];
        mixture.share[mixture.count++] = s;
        kept += s;
    }
    if (!(sum > LEAST_SHARE))
        mixture.count = 0;
    mixture.bsdf_fraction = mixture.count ? mixture.bsdf_fraction / sum : 1;
    for (int k = 0; k < mixture.count; k++)
        mixture.share[k] /= kept;
    return mixture;
}

struct vec3 map_mixture_sample(const struct map_mixture *mixture, const float u[2]) {
    float a = u[0];
    int k = 0;
    while (k + 1 < mixture->count && a >= mixture->share[k])
        a -= mixture->share[k++];
    a /= mixture->share[k];
    a = a < 1 ? a : 0x1.fffffep-1f;
    const struct map *map = mixture->maps[k];
    return density_sample(map->row_cdf, map->density, SPHERE_ROWS, (float[2]){a, u[1]});
}

float map_mixture_pdf(const struct map_mixture *mixture, struct vec3 direction) {
    int bin = sphere_bin(direction);
    float pdf = 0;
    for (int k = 0; k < mixture->count; k++)
        pdf += mixture->share[k] * mixture->maps[k]->density[bin];
    return pdf;
}

struct vec3 maps_irradiance(const struct fewray_maps *maps, int x, int y, struct vec3 normal,
                            float *confidence) {
    const struct map *around[4];
    float share[4], sum = 0;
    int count = neighbours(maps, x, y, around, share);
    float trust = 0;
    struct vec3 e = vec(0, 0, 0), n = normalize(normal);
    for (int k = 0; k < count; k++) {
        float s = share[k] * same_side(around[k], n);
        e = add(e, scale(around[k]->irradiance, s));
        trust += s * around[k]->confidence;
        sum += s;
    }
    /* Where the maps' surfaces fit badly the sum is small, and so is what they are worth. */
    *confidence = sum > LEAST_SHARE ? fminf(trust, 1) : 0;
    return sum > LEAST_SHARE ? scale(e, 1 / sum) : vec(0, 0, 0);
}

float maps_look_noise(const struct fewray_maps *maps, int x, int y) {
    return maps
        ->look_noise[(size_t)(y / BLOCK_SIZE) * (size_t)maps->columns + (size_t)(x / BLOCK_SIZE)];
}
