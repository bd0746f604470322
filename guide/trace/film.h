/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_FILM_H
#define FEWRAY_GUIDE_FILM_H

/* Means and spreads of each pixel's samples, the first look apart from the rest. */

#include "fewray/guide.h"
#include "guide/trace/integrator.h"

enum { GROUP_LOOK, GROUP_REST, GROUP_COUNT };

/* Means over the samples of one group of a pixel, and the sum of squared deviations of the
 * radiance. */
struct pixel_group {
    int count;
    float radiance[3], deviation[3]; /* mean; sum of (x - mean)^2 */
    float emission[3], albedo[3], normal[3], depth, alpha;
};

/* What the camera sees of a pixel at an edge, from rays of its own: it replaces what the samples
 * saw, where those are fewer. */
struct pixel_edge {
    int rays; /* 0: none */
    float emission[3], albedo[3], normal[3], depth;
};

struct fewray_film {
    int width, height; /* pixels */
    int threads;       /* that make the frame of it */
    float look_weight; /* see struct fewray_render_settings */
    /* Each (height, width); of a render without a look the system never gives GROUP_LOOK memory,
     * because nothing writes there. */
    struct pixel_group *group[GROUP_COUNT];
    float (*indirect)[3]; /* (height, width, GROUP_COUNT) means; NULL: not kept apart */
    bool wants_direct, wants_indirect; /* layers of the frame */
    struct pixel_edge *edges;          /* (height, width) */
};

/* Sums of one pixel's samples in double precision; 0-initialised. */
struct pixel_sums {
    int count, dropped;
    double radiance[3], deviation[3];
    double emission[3], albedo[3], normal[3], depth, alpha;
    double indirect[3];
};

/* Adds a sample; one with a NaN or an infinity is dropped and counted instead: false. */
bool pixel_sums_add(struct pixel_sums *sums, const struct path_sample *sample);
/* Adds the sums to those that a pixel's group has already. The stored mean is rounded to floats
 * each time, so that after n of them it is within n 2^-24 of the greatest mean on the way. */
void film_add(struct fewray_film *film, int x, int y, int group, const struct pixel_sums *sums);

/* Share of the look in a pixel's value, whose groups are given. */
float film_look_share(const struct fewray_film *film, const struct fewray_maps *maps, int x, int y,
                      const struct pixel_group *look, const struct pixel_group *rest);

/* Integrator settings that a picture needs, without guides. */
struct integrator film_integrator(const struct fewray_world *world, const struct fewray_film *film,
                                  const struct fewray_render_settings *settings);
int film_threads(const struct fewray_render_settings *settings);

static inline int film_tile_columns(const struct fewray_film *film) {
    return (film->width + FEWRAY_TILE_SIZE - 1) / FEWRAY_TILE_SIZE;
}

static inline int film_tile_count(const struct fewray_film *film) {
    return film_tile_columns(film) * ((film->height + FEWRAY_TILE_SIZE - 1) / FEWRAY_TILE_SIZE);
}

#endif
