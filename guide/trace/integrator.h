/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_INTEGRATOR_H
#define FEWRAY_GUIDE_INTEGRATOR_H

/* Unidirectional path tracing with next-event estimation, combined by multiple importance sampling.
 */

#include "guide/basis.h"
#include "guide/odis/look.h"
#include "guide/trace/proposal.h"
#include "guide/trace/sampler.h"
#include "guide/trace/vertex_log.h"

/* A pixel's samples, the look's and the rest, share one sequence for the camera and for next-event
 * estimation at the first hit, so that they are stratified together. What a map learns from mustn't
 * tell where the samples that it guides lie: from the bounce on they are independent, and so are
 * the parts between which maps learn. */
enum { BRANCH_LOOK = 1, BRANCH_PATHS };

struct integrator {
    const struct fewray_world *world;
    int width, height;       /* picture, pixels */
    int max_depth, rr_depth; /* as Mitsuba counts; max_depth < 0: no limit */
    struct guides guides;
    uint32_t part; /* of the samples: guides don't change within one */
};

/* Whether a path goes on from vertex `depth`, 0 being the camera's first hit. */
static inline bool may_scatter(const struct integrator *in, int depth) {
    return in->max_depth < 0 || depth + 1 < in->max_depth;
}

/* One camera path and what its first hit showed. */
struct path_sample {
    struct vec3 radiance; /* emission included */
    struct vec3 emission; /* seen by the camera, directly or by perfectly specular surfaces alone */
    struct vec3 bounce;   /* what came by the first vertex's bounce */
    struct vec3 indirect; /* of that what another surface reflected */
    struct vec3 albedo, normal; /* of the first vertex: the first that isn't perfectly specular;
                                   albedo times what the specular ones before let through */
    float depth;                /* the camera's way to the first vertex; 0 = miss */
    float alpha;                /* 1 where something is seen: a surface or an environment */
    bool guided;                /* the first bounce could be drawn from a guide */
    int rays;
};

/* What a ray that leaves a surface brings back. */
struct incident {
    struct vec3 emission;  /* of the ray's end */
    float light_pdf;       /* with which next-event estimation draws that point (solid angle) */
    struct vec3 reflected; /* one estimate of what the ray's end reflects */
    float distance;        /* to the ray's end; 0 = none */
    struct vec3 normal;    /* at the ray's end, towards the ray */
    int rays;
};

/* What a vertex's sample brings beside next-event estimation where its direction has density pdf.
 */
static inline struct vec3 incident_radiance(const struct incident *i, float pdf) {
    return add(scale(i->emission, power_heuristic(pdf, i->light_pdf)), i->reflected);
}

/* What a path hands on to its next part. */
struct path_state {
    int depth;              /* vertices so far: 1 after the camera's first hit */
    struct vec3 throughput; /* for Russian roulette and the log */
    float eta;              /* product of the relative indices of refraction crossed */
    struct vertex_log *log; /* NULL: none */
};

/* A ray by which a path leaves a surface. */
struct path_ray {
    struct vec3 position, geometric_normal;
    struct vec3 normal;    /* by which lights were picked there: see lights_sample() */
    struct vec3 direction; /* unit */
    float pdf;             /* with which it was drawn (solid angle); INFINITY: perfectly specular */
};

/* Estimates the radiance along a ray. *second, where not NULL, gets what the ray's end saw. */
struct incident trace_incident(const struct integrator *in, struct sampler *sampler,
                               struct path_state state, struct path_ray ray,
                               struct look_second *second);

/* What a path tells beside its radiance; each may be NULL. */
struct path_notes {
    struct vertex_log *log;
    struct look_record *record;
    struct look_second *second;
};

/* A camera path through the pixel (x, y); directions are drawn from the guides where there are
 * some, else from the BSDF. notes may be NULL. */
struct path_sample trace_path(const struct integrator *in, int x, int y, struct sampler *sampler,
                              const struct path_notes *notes);

/* The same with a first bounce in the direction that `u` warps to uniformly over the hemisphere. */
struct path_sample trace_look_path(const struct integrator *in, int x, int y,
                                   struct sampler *sampler, const float u[2],
                                   const struct path_notes *notes);

/* What a camera ray shows: emission, albedo, normal, depth and alpha, without a path beyond. (x,
 * y): in pixels from the upper left corner. */
struct path_sample trace_features(const struct integrator *in, float x, float y,
                                  struct sampler *sampler);

#endif
