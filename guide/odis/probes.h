/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_PROBES_H
#define FEWRAY_GUIDE_PROBES_H

/* World-space probes: what the first look's second vertices saw, pooled over the vertices that
 * share a voxel and a normal's main axis. They guide every vertex after the first, tell which
 * shadow rays are futile, and turn the look's own radiance, each a single draw, into averages. */

#include <stdbool.h>

#include "guide/odis/look.h"
#include "guide/odis/voxel_table.h"

#define PROBE_SIZE 16 /* rows and columns of bins, as of sphere_grid.h */
#define PROBE_BINS (PROBE_SIZE * PROBE_SIZE)

struct probe {
    int records;         /* that it was built from */
    struct vec3 normal;  /* mean, unit */
    float bsdf_fraction; /* of the directions here; 1: no light was found */
    float light_chance;  /* with which a shadow ray should be traced here, (0, 1] */
    float mean, moment;  /* reflected radiance / albedo: mean, and mean of the square */
    float row_cdf[PROBE_SIZE + 1];
    float density[PROBE_BINS]; /* pdf (solid angle); integrates to 1 over the sphere */
};

struct probe_level {
    struct voxel_table voxels;
    struct probe *probes; /* (voxels.count) */
};

struct probes {
    struct probe_level fine;
    struct probe_level coarse; /* what the fine ones assume beside what they saw, and stands in
                                  where there is no fine one */
};

/* Builds the probes from a look, and sets each record's mean and moment from them. *out is owned by
 * the caller. */
int probes_create(struct fewray_look *look, int threads, struct probes **out,
                  struct fewray_error *error);
void probes_destroy(struct probes **probes);
/* Instead: sets each record's mean and moment to its own values. */
void probes_do_without(struct fewray_look *look, int threads);

/* The probe at a surface point; NULL where there is none. normal: unit, towards the path. */
const struct probe *probes_at(const struct probes *probes, struct vec3 position,
                              struct vec3 normal);

struct vec3 probe_sample(const struct probe *probe, const float u[2]);
float probe_pdf(const struct probe *probe, struct vec3 direction);

#endif
