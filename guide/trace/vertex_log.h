/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_VERTEX_LOG_H
#define FEWRAY_GUIDE_VERTEX_LOG_H

/* A path's vertices with what each sampled direction brought, for guides that learn while
 * rendering. */

#include "guide/vec.h"

#define VERTEX_LOG_MAX 32 /* vertices of a path that are remembered */

struct path_vertex {
    struct vec3 position, normal; /* world space; shading normal towards the previous vertex */
    struct vec3 direction;        /* sampled there, unit */
    struct vec3 weight;           /* f cos / pdf of that sample */
    struct vec3 incident; /* radiance estimate from there: emission weighted against next-event
                             estimation, and what is reflected */
    float pdf, bsdf_pdf, guide_pdf; /* of the direction (solid angle): the mixture, its parts */
};

struct vertex_log {
    int count;
    struct path_vertex vertices[VERTEX_LOG_MAX];
    struct vec3 throughput[VERTEX_LOG_MAX]; /* product of the weights before each vertex */
};

#endif
