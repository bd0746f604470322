/* SPDX-License-Identifier: Apache-2.0 */
/* Sampling maps from the first look, and how pixels between grid points use them. */

#include "guide/odis/maps.h"

#include <stdlib.h>

#include "guide/odis/gather.h"
#include "guide/odis/network.h"
#include "guide/trace/distribution.h"
#include "guide/trace/film.h"

#define LEAST_SHARE 1e-3f /* of the bilinear shares: below, the maps belong to other surfaces */

bool map_set_density(struct map *map, const float values[SPHERE_BINS]) {
    float rows[SPHERE_ROWS];
    double total = 0;
    for (int r = 0; r < SPHERE_ROWS; r++) {
        float sum = 0;
        for (int c = 0; c < SPHERE_COLUMNS; c++)
            sum += values[r * SPHERE_COLUMNS + c];
        rows[r] = sum;
        total += sum;
    }
    if (!(total > 0) || !isfinite(total))
        return false;
    cdf_build(rows, SPHERE_ROWS, map->row_cdf);
    float to_density = (float)(1 / (total * SPHERE_BIN_SOLID_ANGLE));
    for (int b = 0; b < SPHERE_BINS; b++)
        map->density[b] = values[b] * to_density;
    return true;
}

/* Position in [0, 1) that grid points a < b enclose x. */
static float between(int x, int a, int b) {
    return b > a ? (float)(x - a) / (float)(b - a) : 0;
}

/* The four grid points around a pixel and their bilinear shares. */
static void neighbours(const struct fewray_maps *maps, int x, int y, const struct map *around[4],
                       float share[4]) {
    int i = x / MAP_STRIDE, j = y / MAP_STRIDE;
    int i1 = i + 1 < maps->columns ? i + 1 : i, j1 = j + 1 < maps->rows ? j + 1 : j;
    float fx = between(x, map_pixel(i, maps->width), map_pixel(i1, maps->width));
    float fy = between(y, map_pixel(j, maps->height), map_pixel(j1, maps->height));
    const struct map *row0 = maps->maps + (size_t)j * (size_t)maps->columns;
    const struct map *row1 = maps->maps + (size_t)j1 * (size_t)maps->columns;
    around[0] = row0 + i, share[0] = (1 - fx) * (1 - fy);
    around[1] = row0 + i1, share[1] = fx * (1 - fy);
    around[2] = row1 + i, share[2] = (1 - fx) * fy;
    around[3] = row1 + i1, share[3] = fx * fy;
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

/* 1 on the point's tangent plane, falling with the elevation above or below it. */
static float same_plane(const struct map *map, struct vec3 position, struct vec3 normal) {
    struct vec3 d = sub(map->position, position);
    float distance2 = dot(d, d), height = dot(d, normal);
    return distance2 > 0 ? expf(-25 * height * height / distance2) : 1;
}

struct map_mixture maps_at(const struct fewray_maps *maps, int x, int y, struct vec3 position,
                           struct vec3 normal) {
    const struct map *around[4];
    float share[4], sum = 0;
    neighbours(maps, x, y, around, share);
    struct map_mixture mixture = {.count = 0};
    for (int k = 0; k < 4; k++) {
        if (!around[k]->valid || !(share[k] > 0))
            continue;
        float s = share[k] * same_side(around[k], normal) * same_plane(around[k], position, normal);
        if (!(s > 0))
            continue;
        mixture.maps[mixture.count] = around[k];
        mixture.share[mixture.count++] = s;
        sum += s;
    }
    if (!(sum > LEAST_SHARE))
        mixture.count = 0;
    for (int k = 0; k < mixture.count; k++)
        mixture.share[k] /= sum;
    return mixture;
}

/* A position within a bin, kept off its borders so that rounding can't lead into a bin of another
 * density. */
static float inside(float position) {
    return fminf(fmaxf(position, 1e-5f), 1 - 1e-5f);
}

struct vec3 map_mixture_sample(const struct map_mixture *mixture, const float u[2]) {
    float a = u[0], b = u[1];
    int k = 0;
    while (k + 1 < mixture->count && a >= mixture->share[k])
        a -= mixture->share[k++];
    a = fminf(a / mixture->share[k], 0x1.fffffep-1f);
    const struct map *map = mixture->maps[k];
    int row = (int)cdf_sample(map->row_cdf, SPHERE_ROWS, &a);
    const float *density = map->density + row * SPHERE_COLUMNS;
    float total = 0;
    for (int c = 0; c < SPHERE_COLUMNS; c++)
        total += density[c];
    b *= total;
    int column = 0, last = 0;
    for (; column < SPHERE_COLUMNS && b >= density[column]; column++) {
        b -= density[column];
        if (density[column] > 0)
            last = column;
    }
    if (column == SPHERE_COLUMNS) /* rounding at the row's end */
        column = last, b = density[last];
    return sphere_direction(row, column, inside(a), inside(b / density[column]));
}

float map_mixture_pdf(const struct map_mixture *mixture, struct vec3 direction) {
    int bin = sphere_bin(direction);
    float pdf = 0;
    for (int k = 0; k < mixture->count; k++)
        pdf += mixture->share[k] * mixture->maps[k]->density[bin];
    return pdf;
}

struct vec3 maps_irradiance(const struct fewray_maps *maps, int x, int y, struct vec3 normal) {
    const struct map *around[4];
    float share[4], sum = 0;
    neighbours(maps, x, y, around, share);
    struct vec3 e = vec(0, 0, 0), n = normalize(normal);
    for (int k = 0; k < 4; k++) {
        float s = around[k]->valid ? share[k] * same_side(around[k], n) : 0;
        e = add(e, scale(around[k]->irradiance, s));
        sum += s;
    }
    return sum > LEAST_SHARE ? scale(e, 1 / sum) : vec(0, 0, 0);
}

/* Turns a grid point's gathered look into its map. */
static void make_map(const struct gathered *g, struct odis_network *network, struct map *map) {
    float wanted[SPHERE_BINS], radiance[SPHERE_BINS], values[SPHERE_BINS];
    odis_network_run(network, g, wanted, radiance);
    float irradiance = 0;
    for (int b = 0; b < SPHERE_BINS; b++) {
        irradiance += radiance[b] * g->cosine[b];
        values[b] = g->cosine[b] * wanted[b];
    }
    map->position = g->position;
    map->normal = g->normal;
    map->valid = map_set_density(map, values);
    map->irradiance = scale(g->tint, irradiance * g->scale * SPHERE_BIN_SOLID_ANGLE / PI_F);
}

static int build_maps(const struct fewray_look *look, const struct fewray_render_settings *settings,
                      const struct odis_weights *weights, struct fewray_maps *maps,
                      struct fewray_render_stats *stats, struct fewray_error *error) {
    int count = maps->columns * maps->rows, done = 0;
    long long inferred = 0;
    bool no_memory = false, cancelled = false;
#pragma omp parallel num_threads(film_threads(settings)) reduction(+ : inferred)
    {
        struct odis_network *network = odis_network_create(weights);
        struct gathered *g = malloc(sizeof(*g));
#pragma omp for schedule(dynamic, 16)
        for (int i = 0; i < count; i++) {
            if (!network || !g || (settings->cancel && *settings->cancel)) {
#pragma omp atomic write
                cancelled = true;
                continue;
            }
            gather(look, map_pixel(i % maps->columns, maps->width),
                   map_pixel(i / maps->columns, maps->height), g);
            if (g->valid) {
                make_map(g, network, &maps->maps[i]);
                inferred++;
            }
#pragma omp critical(fewray_maps)
            if (++done % 64 == 0 && settings->progress)
                settings->progress(settings->progress_user, "guide", (double)done / count);
        }
        if (!network || !g) {
#pragma omp atomic write
            no_memory = true;
        }
        free(g);
        odis_network_destroy(&network);
    }
    stats->grids += count;
    stats->grids_inferred += inferred;
    if (no_memory)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0,
                           "no memory for the guide's network");
    if (cancelled)
        return fewray_fail(error, FEWRAY_ERROR_CANCELLED, NULL, 0, "interrupted");
    return FEWRAY_OK;
}

int fewray_maps_create(const struct fewray_look *look,
                       const struct fewray_render_settings *settings, struct fewray_maps **out,
                       struct fewray_render_stats *stats, struct fewray_error *error) {
    *out = NULL;
    struct odis_weights *weights = NULL;
    int status = odis_weights_load(settings->weights_path, &weights, error);
    if (status)
        return status;
    struct fewray_maps *maps = calloc(1, sizeof(*maps));
    if (maps) {
        maps->width = look->width;
        maps->height = look->height;
        maps->columns = (look->width - 1 + MAP_STRIDE - 1) / MAP_STRIDE + 1;
        maps->rows = (look->height - 1 + MAP_STRIDE - 1) / MAP_STRIDE + 1;
        maps->maps = calloc((size_t)maps->columns * (size_t)maps->rows, sizeof(*maps->maps));
    }
    if (!maps || !maps->maps)
        status =
            fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the sampling maps");
    else
        status = build_maps(look, settings, weights, maps, stats, error);
    odis_weights_destroy(&weights);
    if (status)
        fewray_maps_destroy(&maps);
    *out = maps;
    return status;
}

void fewray_maps_destroy(struct fewray_maps **maps) {
    if (!*maps)
        return;
    free((*maps)->maps);
    free(*maps);
    *maps = NULL;
}
