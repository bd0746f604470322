/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_LOOK_H
#define FEWRAY_GUIDE_LOOK_H

/* The first look: what the initial samples saw at their first bounce (paper, section 3.3), and what
 * the bounce's end, the second vertex, saw in turn. */

#include <stdbool.h>

#include "fewray/guide.h"
#include "guide/vec.h"

#define LOOK_PDF                                                                                   \
    (0.5f / PI_F) /* solid angle; of the look's first bounces, uniform over the hemisphere */

/* Above, a value is a fault: its square would leave a float. */
#define LOOK_RADIANCE_MAX 1e15f

struct look_record {
    struct vec3 position; /* first hit, world space */
    struct vec3
        normal;  /* first hit, shading normal towards the viewer; zero: the camera ray missed */
    float depth; /* camera to first hit, scene units; 0: nothing was hit, or it doesn't scatter */
    struct vec3 direction; /* of the first bounce, unit, world space */
    uint16_t bin;          /* sphere_bin() of it */
    struct vec3 direct;    /* next-event estimation at the first hit, over the albedo, weighted
                              against a bounce of LOOK_PDF */
    struct vec3 radiance;  /* incident from there: emission and one estimate of what is reflected */
    float emitted;         /* mean of RGB of the emission alone, weighted against next-event
                              estimation as if the direction had LOOK_PDF */
    float reflected;       /* mean of RGB of the rest */
    float distance;        /* first to second hit; 0 = none */
    struct vec3 second_normal; /* second hit, towards the first; zero = none */
    /* From the samples of all records whose second vertex is near this one's (probes_create());
     * without a probe the record's own values. */
    float mean;   /* of emitted + reflected */
    float moment; /* root of the mean of (emitted + reflected)^2 */
};

/* What a record's second vertex found by its own two samples. */
struct look_second {
    float albedo;                    /* mean of RGB; 0: there is no such vertex */
    struct vec3 light, bounce;       /* unit directions: of next-event estimation, of the BSDF */
    float light_value, bounce_value; /* incident radiance (mean of RGB; 0 where blocked) over the
                                        summed densities of both techniques */
    bool light_sent;                 /* a shadow ray was traced */
};

struct fewray_look {
    int width, height;
    int samples;                 /* records a pixel */
    struct look_record *records; /* (height, width, samples) */
    struct look_second *seconds; /* likewise; NULL: not wanted, there will be no probes */
};

/* A look without records yet. seconds: whether second vertices are wanted. *out is owned by the
 * caller: fewray_look_destroy(). */
int look_create(int width, int height, int samples, bool seconds, struct fewray_look **out,
                struct fewray_error *error);
/* Gives each process of a team (may be NULL) all records. */
int look_exchange(struct fewray_look *look, const struct fewray_team *team,
                  struct fewray_error *error);

/* The look's random numbers of a picture's seed. */
uint32_t look_seed(uint64_t seed);
/* What a sample's direction is made of, in [0, 1)^2: one (0,2)-sequence for the 256 pixels of a
 * tile in Morton order, so that any small window of pixels has its directions spread evenly, and
 * few bins of the window's grid stay empty. seed: look_seed(). */
void look_square(uint32_t seed, int x, int y, int sample, float u[2]);

#endif
