/* SPDX-License-Identifier: Apache-2.0 */
/* Sampling maps from the first look: where they stand, and how they are made. */

#include <stdlib.h>
#include <string.h>

#include "features/cancel.h"
#include "guide/odis/gather.h"
#include "guide/odis/irradiance.h"
#include "guide/odis/maps.h"
#include "guide/odis/network.h"
#include "guide/odis/probes.h"
#include "guide/trace/film.h"
#include "guide/trace/team.h"
#include "guide/trace/tiles.h"

/* What four blocks must show to share a map, at GROUP_PROBES x GROUP_PROBES pixels of theirs: */
#define GROUP_PROBES   4
#define FLAT_COSINE    0.99f /* least, of a normal to the middle's: 8 degrees, less than a bin */
#define FLAT_ELEVATION 0.03f /* most, off the middle's tangent plane, in distances from there */
#define FLAT_DEPTHS    1.3f  /* most, of the largest to the smallest depth */

#define LEAST_VARIANCE 0.05f /* that a map is trusted to leave, of the BSDF's second moment */

#define NOISE_RADIUS 4 /* blocks around a block whose maps tell its look's weight */

/* Where a map is to be made. */
struct place {
    struct block_range blocks; /* that use it; i1 = i0: none */
    int x, y;                  /* the pixel whose surface it stands on */
};

static const struct look_record *first_hit(const struct fewray_look *look, int x, int y) {
    const struct look_record *r =
        look->records + ((size_t)y * (size_t)look->width + (size_t)x) * (size_t)look->samples;
    for (int s = 0; s < look->samples; s++)
        if (r[s].depth > 0)
            return &r[s];
    return NULL;
}

/* Puts the place on its blocks' middle pixel or, where that one sees no surface, the nearest of
 * theirs that does; without any the place is emptied. */
static void find_pixel(const struct fewray_look *look, struct place *p) {
    int x0 = p->blocks.i0 * BLOCK_SIZE, x1 = p->blocks.i1 * BLOCK_SIZE, nearest = -1;
    int y0 = p->blocks.j0 * BLOCK_SIZE, y1 = p->blocks.j1 * BLOCK_SIZE;
    x1 = x1 < look->width ? x1 : look->width;
    y1 = y1 < look->height ? y1 : look->height;
    int middle_x = p->x = (x0 + x1) / 2, middle_y = p->y = (y0 + y1) / 2;
    if (first_hit(look, middle_x, middle_y))
        return;
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++) {
            int distance2 = (x - middle_x) * (x - middle_x) + (y - middle_y) * (y - middle_y);
            if ((nearest < 0 || distance2 < nearest) && first_hit(look, x, y)) {
                nearest = distance2;
                p->x = x;
                p->y = y;
            }
        }
    if (nearest < 0)
        p->blocks.i1 = p->blocks.i0;
}

/* Whether the group's blocks show one even surface. */
static bool is_flat(const struct fewray_look *look, const struct place *group) {
    const struct look_record *middle = first_hit(look, group->x, group->y);
    float nearest = middle->depth, farthest = middle->depth;
    int x0 = group->blocks.i0 * BLOCK_SIZE, y0 = group->blocks.j0 * BLOCK_SIZE;
    for (int k = 0; k < GROUP_PROBES * GROUP_PROBES; k++) {
        int x = x0 + k % GROUP_PROBES * (2 * BLOCK_SIZE - 1) / (GROUP_PROBES - 1);
        int y = y0 + k / GROUP_PROBES * (2 * BLOCK_SIZE - 1) / (GROUP_PROBES - 1);
        const struct look_record *r = first_hit(look, x < look->width ? x : look->width - 1,
                                                y < look->height ? y : look->height - 1);
        if (!r || !(dot(r->normal, middle->normal) >= FLAT_COSINE))
            return false;
        struct vec3 d = sub(r->position, middle->position);
        float height = dot(d, middle->normal);
        if (height * height > FLAT_ELEVATION * FLAT_ELEVATION * dot(d, d))
            return false;
        nearest = fminf(nearest, r->depth);
        farthest = fmaxf(farthest, r->depth);
    }
    return farthest <= FLAT_DEPTHS * nearest;
}

/* Sets places[0..3] for a group of 2 x 2 blocks (fewer at the edges): one for all, where they may
 * share, or one each. */
static void plan_group(const struct fewray_look *look, const struct fewray_maps *maps, bool share,
                       int i0, int j0, struct place places[4]) {
    int i1 = i0 + 2 < maps->columns ? i0 + 2 : maps->columns;
    int j1 = j0 + 2 < maps->rows ? j0 + 2 : maps->rows;
    for (int k = 0; k < 4; k++)
        places[k] = (struct place){.blocks = {i0, j0, i0, j0}};
    struct place group = {.blocks = {i0, j0, i1, j1}};
    find_pixel(look, &group);
    if (group.blocks.i1 == group.blocks.i0)
        return;
    if (share && is_flat(look, &group)) {
        places[0] = group;
        return;
    }
    for (int j = j0; j < j1; j++)
        for (int i = i0; i < i1; i++, places++) {
            *places = (struct place){.blocks = {i, j, i + 1, j + 1}};
            find_pixel(look, places);
        }
}

/* The places of all maps, owned by the caller. Returns their number, or -1 without memory. */
static int plan(const struct fewray_look *look, const struct fewray_maps *maps,
                const struct fewray_render_settings *settings, struct place **out) {
    int columns = (maps->columns + 1) / 2, groups = columns * ((maps->rows + 1) / 2), count = 0;
    struct place *places = *out = malloc(4 * (size_t)groups * sizeof(*places));
    if (!places)
        return -1;
#pragma omp parallel for schedule(static) num_threads(film_threads(settings))
    for (int g = 0; g < groups; g++)
        plan_group(look, maps, settings->share_maps, 2 * (g % columns), 2 * (g / columns),
                   places + 4 * (size_t)g);
    for (int k = 0; k < 4 * groups; k++)
        if (places[k].blocks.i1 > places[k].blocks.i0)
            places[count++] = places[k];
    return count;
}

/* Blocks around its own whose records a map is gathered from as well. */
static int gather_ring(const struct fewray_look *look) {
    return look->samples < 8 ? 1 : 0;
}

/* Sets the moments that sum_b t_b^2 / p_b gives for each density. wanted: t, up to a factor. */
static void set_moments(struct map *map, const float wanted[SPHERE_BINS],
                        const float cosine[SPHERE_BINS]) {
    float a = map->bsdf_fraction, of_look = 0, of_map = 0, of_bsdf = 0;
    for (int b = 0; b < SPHERE_BINS; b++) {
        float bsdf = cosine[b] * (1 / PI_F), pdf = a * bsdf + (1 - a) * map->density[b];
        float t2 = wanted[b] * wanted[b];
        of_look += t2 * (1 / LOOK_PDF);
        of_map += pdf > 0 ? t2 / pdf : 0;
        of_bsdf += bsdf > 0 ? t2 / bsdf : 0;
    }
    map->look_moment = of_bsdf > 0 ? of_look / of_bsdf : 1;
    map->map_moment = of_bsdf > 0 ? of_map / of_bsdf : 1;
}

/* Which process of a team makes a map. */
static int map_owner(const void *user, struct team_deal deal, size_t m) {
    const struct place *p = (const struct place *)user + m;
    return team_owner(deal, p->blocks.i0 * BLOCK_SIZE / TILE_SIZE,
                      p->blocks.j0 * BLOCK_SIZE / TILE_SIZE);
}

/* Makes the map at a place; false where the look tells too little. */
static bool make_map(const struct fewray_look *look, const struct place *p, float bsdf_fraction,
                     struct odis_network *network, struct gathered *g, struct fewray_maps *maps,
                     int m) {
    struct map *map = &maps->maps[m];
    float wanted[SPHERE_BINS], radiance[SPHERE_BINS];
    int ring = gather_ring(look);
    const struct block_range *own = &p->blocks;
    gather(look, own->i0 - ring, own->j0 - ring, own->i1 + ring, own->j1 + ring, p->x, p->y, g);
    if (!g->valid)
        return false;
    odis_network_run(network, g, wanted, radiance, &map->bsdf_fraction);
    map->bsdf_fraction =
        bsdf_fraction >= 0 ? bsdf_fraction : fmaxf(map->bsdf_fraction, MAP_LEAST_FRACTION);
    if (maps->sums)
        map_sums_start(maps, m, wanted, g->scale);
    map->position = g->position;
    map->normal = g->normal;
    struct irradiance irradiance =
        irradiance_gather(look, (own->i0 - ring) * BLOCK_SIZE, (own->j0 - ring) * BLOCK_SIZE,
                          (own->i1 + ring) * BLOCK_SIZE, (own->j1 + ring) * BLOCK_SIZE, g->normal);
    map->irradiance = irradiance.value;
    map->confidence = irradiance.confidence;
    map->blocks = p->blocks;
    float t[SPHERE_BINS];
    for (int b = 0; b < SPHERE_BINS; b++)
        t[b] = wanted[b] * g->cosine[b];
    if (!maps_set(maps, map, g->cosine, wanted))
        return false;
    set_moments(map, t, g->cosine);
    return true;
}

/* Sets the maps of all blocks; returns the number of maps that could be made. */
static int set_index(struct fewray_maps *maps) {
    int made = 0;
    for (int m = 0; m < maps->count; m++) {
        const struct block_range *blocks = &maps->maps[m].blocks;
        for (int j = blocks->j0; j < blocks->j1; j++)
            for (int i = blocks->i0; i < blocks->i1; i++)
                maps->index[(size_t)j * (size_t)maps->columns + (size_t)i] = m;
        made += blocks->i1 > blocks->i0;
    }
    return made;
}

static void count_maps(const struct fewray_maps *maps, int made,
                       struct fewray_render_stats *stats) {
    stats->grids += (long long)maps->columns * maps->rows;
    stats->grids_inferred += made;
    for (int k = 0; k < maps->columns * maps->rows; k++)
        stats->grids_shared += maps->index[k] >= 0;
    stats->grids_shared -= made;
}

static int fill_maps(const struct fewray_look *look, const struct fewray_render_settings *settings,
                     const struct odis_weights *weights, const struct place *places,
                     struct fewray_maps *maps, struct fewray_error *error) {
    int done = 0;
    const struct team_deal deal = team_deal(settings->team);
    const int rank = settings->team ? settings->team->rank : 0;
    bool no_memory = false, cancelled = false;
#pragma omp parallel num_threads(film_threads(settings))
    {
        struct odis_network *network = odis_network_create(weights);
        struct gathered *g = malloc(sizeof(*g));
        if (!network || !g) {
#pragma omp atomic write
            no_memory = true;
        }
#pragma omp for schedule(dynamic, 16)
        for (int m = 0; m < maps->count; m++) {
            if (!network || !g || map_owner(places, deal, (size_t)m) != rank)
                continue;
            if (cancel_wanted(settings->cancel)) {
#pragma omp atomic write
                cancelled = true;
                continue;
            }
            if (!make_map(look, &places[m], settings->bsdf_fraction, network, g, maps, m))
                maps->maps[m].blocks = (struct block_range){0, 0, 0, 0};
            int now;
#pragma omp atomic capture
            now = ++done;
            if (now % 64 == 0 && settings->progress) {
#pragma omp critical(fewray_maps)
                settings->progress(settings->progress_user, "guide",
                                   fmin(1, (double)now * deal.size / maps->count));
            }
        }
        free(g);
        odis_network_destroy(&network);
    }
    int status = FEWRAY_OK;
    if (no_memory)
        status =
            fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the guide's network");
    else if (cancelled)
        status = fewray_fail(error, FEWRAY_ERROR_CANCELLED, NULL, 0, "interrupted");
    status = fewray_team_agree(settings->team, status, error);
    return status ? status
                  : team_share(settings->team, maps->maps, sizeof(*maps->maps), (size_t)maps->count,
                               map_owner, places, error);
}

/* Whether a map was gathered from the block (i, j), too. */
static bool saw_block(const struct map *map, int i, int j, int ring) {
    const struct block_range *b = &map->blocks;
    return i >= b->i0 - ring && i < b->i1 + ring && j >= b->j0 - ring && j < b->j1 + ring;
}

/* What the maps around a block expect, without those that the block's own look has shaped: the
 * weight of a look's sample must not depend on the sample. */
static float noise_around(const struct fewray_maps *maps, int i, int j, int ring,
                          const struct fewray_render_settings *pilot) {
    double look = 0, map = 0;
    int count = 0;
    for (int y = j - NOISE_RADIUS; y <= j + NOISE_RADIUS; y++)
        for (int x = i - NOISE_RADIUS; x <= i + NOISE_RADIUS; x++) {
            if (x < 0 || y < 0 || x >= maps->columns || y >= maps->rows)
                continue;
            int32_t m = maps->index[(size_t)y * (size_t)maps->columns + (size_t)x];
            if (m < 0 || saw_block(&maps->maps[m], i, j, ring))
                continue;
            look += logf(maps->maps[m].look_moment);
            map += logf(maps->maps[m].map_moment);
            count++;
        }
    if (!count)
        return 1;
    /* Of the BSDF's variance: that of each kind of bounce; squared mean = moment / (1 + variance).
     */
    float square = 1 / (1 + pilot->bounce_variance), other = 1 - pilot->bounce_share;
    float unit = 1 / fmaxf(1 - square, LEAST_VARIANCE);
    float of_look = fmaxf((float)exp(look / count) - square, LEAST_VARIANCE) * unit;
    float of_map = fmaxf((float)exp(map / count) - square, LEAST_VARIANCE) * unit;
    return (pilot->bounce_share * of_look + other) / (pilot->bounce_share * of_map + other);
}

static void set_look_noise(struct fewray_maps *maps, int ring,
                           const struct fewray_render_settings *settings) {
    int blocks = maps->columns * maps->rows;
#pragma omp parallel for schedule(static) num_threads(film_threads(settings))
    for (int k = 0; k < blocks; k++)
        maps->look_noise[k] =
            noise_around(maps, k % maps->columns, k / maps->columns, ring, settings);
}

/* Plans the maps, allocates and fills them. */
static int build_maps(const struct fewray_look *look, const struct fewray_render_settings *settings,
                      const struct odis_weights *weights, struct fewray_maps *maps,
                      struct fewray_render_stats *stats, struct fewray_error *error) {
    struct place *places = NULL;
    int status = FEWRAY_OK;
    maps->width = look->width;
    maps->height = look->height;
    maps->fixed_fraction = settings->bsdf_fraction >= 0;
    maps->columns = (look->width + BLOCK_SIZE - 1) / BLOCK_SIZE;
    maps->rows = (look->height + BLOCK_SIZE - 1) / BLOCK_SIZE;
    size_t index_bytes = (size_t)maps->columns * (size_t)maps->rows * sizeof(*maps->index);
    maps->index = malloc(index_bytes);
    maps->look_noise =
        malloc((size_t)maps->columns * (size_t)maps->rows * sizeof(*maps->look_noise));
    bool fits = settings->map_bins > 0 && SPHERE_ROWS % settings->map_bins == 0;
    maps->merge = fits ? SPHERE_ROWS / settings->map_bins : 1;
    maps->count = plan(look, maps, settings, &places);
    if (maps->count > 0)
        maps->maps = malloc((size_t)maps->count * sizeof(*maps->maps));
    bool learns = settings->refine && settings->spp > MAPS_LEARN_SPP && maps->count > 0;
    if (learns)
        maps->sums = map_sums_create(maps->count);
    if (!maps->index || !maps->look_noise || maps->count < 0 || (maps->count > 0 && !maps->maps) ||
        (learns && !maps->sums))
        status =
            fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the sampling maps");
    status = fewray_team_agree(settings->team, status, error);
    if (!status)
        status = fill_maps(look, settings, weights, places, maps, error);
    if (!status) {
        memset(maps->index, 0xff, index_bytes); /* -1 */
        count_maps(maps, set_index(maps), stats);
        set_look_noise(maps, gather_ring(look), settings);
    }
    free(places);
    return status;
}

int fewray_maps_check_weights(const char *path, struct fewray_error *error) {
    struct odis_weights *weights = NULL;
    const int status = odis_weights_load(path, &weights, error);
    odis_weights_destroy(&weights);
    return status;
}

int fewray_maps_create(struct fewray_look *look, const struct fewray_render_settings *settings,
                       struct fewray_maps **out, struct fewray_render_stats *stats,
                       struct fewray_error *error) {
    *out = NULL;
    struct odis_weights *weights = NULL;
    int status = settings->paper_weights && !settings->weights_path
                     ? odis_weights_load_paper(&weights, error)
                     : odis_weights_load(settings->weights_path, &weights, error);
    struct fewray_maps *maps = calloc(1, sizeof(*maps));
    if (!status && !maps)
        status =
            fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the sampling maps");
    if (!settings->probes || !look->seconds)
        probes_do_without(look, film_threads(settings));
    else if (!status)
        status = probes_create(look, film_threads(settings), &maps->probes, error);
    status = fewray_team_agree(settings->team, status, error);
    if (!status)
        status = build_maps(look, settings, weights, maps, stats, error);
    if (!status && maps->probes && !maps_find_places(maps))
        status =
            fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the sampling maps");
    odis_weights_destroy(&weights);
    if (status && maps)
        fewray_maps_destroy(&maps);
    *out = maps;
    return status;
}

void fewray_maps_destroy(struct fewray_maps **maps) {
    if (!*maps)
        return;
    free((*maps)->maps);
    free((*maps)->index);
    free((*maps)->sums);
    free((*maps)->look_noise);
    free((*maps)->place_maps);
    voxel_table_clear(&(*maps)->places);
    probes_destroy(&(*maps)->probes);
    free(*maps);
    *maps = NULL;
}
