/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_LOOK_H
#define FEWRAY_GUIDE_LOOK_H

/* The first look: what the initial samples saw at their first bounce (paper, section 3.3). */

#include "guide/guide.h"
#include "guide/vec.h"

struct look_record {
    struct vec3 position; /* first hit, world space */
    struct vec3
        normal;  /* first hit, shading normal towards the viewer; zero: the camera ray missed */
    float depth; /* camera to first hit, scene units */
    struct vec3 direction; /* of the first bounce, unit, world space */
    struct vec3 radiance;  /* incident from there: emission and one estimate of what is reflected */
    float weighted;        /* the same, mean of RGB, with the emission weighted against next-event
                              estimation */
    float distance;        /* first to second hit; 0 = none */
    struct vec3 second_normal; /* second hit, towards the first; zero = none */
};

struct fewray_look {
    int width, height;
    int samples;                 /* records a pixel */
    struct look_record *records; /* (height, width, samples) */
};

#endif
