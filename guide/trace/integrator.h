/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_INTEGRATOR_H
#define FEWRAY_GUIDE_INTEGRATOR_H

/* Unidirectional path tracing with next-event estimation, combined by multiple importance sampling.
 */

#include "guide/odis/look.h"
#include "guide/odis/maps.h"
#include "guide/trace/bsdf.h"
#include "guide/trace/sampler.h"

struct integrator {
    const struct fewray_world *world;
    int width, height;              /* picture, pixels */
    int max_depth, rr_depth;        /* as Mitsuba counts; max_depth < 0: no limit */
    const struct fewray_maps *maps; /* NULL: not guided */
    float bsdf_fraction;
};

/* One camera path and what its first hit showed. */
struct path_sample {
    struct vec3 radiance; /* emission included */
    struct vec3 emission; /* of the first hit, or the background */
    struct vec3 albedo, normal;
    float depth; /* distance of the first hit; 0 = miss */
    float alpha; /* 1 where something is seen: a surface or an environment */
    bool guided; /* a map could be sampled */
    int rays;
};

/* What a ray that leaves a surface brings back. */
struct incident {
    struct vec3 radiance; /* emission at the ray's end weighted against next-event estimation */
    struct vec3 full;     /* the same with the emission unweighted: the incident radiance itself */
    float distance;       /* to the ray's end; 0 = none */
    struct vec3 normal;   /* at the ray's end, towards the ray */
    int rays;
};

/* Estimates the radiance along a unit direction from a surface point. pdf: density (solid angle)
 * with which the direction was drawn. depth: vertices on the path so far (1 at the camera's first
 * hit). throughput: of the path so far, for Russian roulette alone. */
struct incident trace_incident(const struct integrator *in, struct sampler *sampler,
                               struct vec3 position, struct vec3 geometric_normal,
                               struct vec3 direction, float pdf, int depth, struct vec3 throughput);

/* A camera path through the pixel (x, y); the first bounce is drawn from the maps where there are
 * some, else from the BSDF. */
struct path_sample trace_path(const struct integrator *in, int x, int y, struct sampler *sampler);

/* Radiance that is emitted by what the camera sees at (x, y), in pixels from the upper left corner.
 */
struct vec3 trace_emission(const struct integrator *in, float x, float y);

/* A camera path whose first bounce has the direction that `u` warps to uniformly over the
 * hemisphere; fills *record. */
struct path_sample trace_look_path(const struct integrator *in, int x, int y,
                                   struct sampler *sampler, const float u[2],
                                   struct look_record *record);

#endif
