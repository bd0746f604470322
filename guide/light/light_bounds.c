/* SPDX-License-Identifier: Apache-2.0 */
/* Bounds of clusters of lights and their cost. */

#include "guide/light/light_bounds.h"

struct light_bounds light_bounds_none(void) {
    struct light_bounds b = {.axis = {0, 0, 1}};
    b.low = vec(INFINITY, INFINITY, INFINITY);
    b.high = negate(b.low);
    return b;
}

struct vec3 light_bounds_centre(const struct light_bounds *b) {
    return add(scale(b->low, 0.5f), scale(b->high, 0.5f));
}

float light_bounds_radius(const struct light_bounds *b) {
    return b->phi > 0 ? 0.5f * length(sub(b->high, b->low)) : 0;
}

/* The cone around both cones of normals (algorithm 1). */
static void unite_cones(const struct light_bounds *a, const struct light_bounds *b,
                        struct light_bounds *out) {
    if (b->theta_o > a->theta_o) {
        const struct light_bounds *swap = a;
        a = b;
        b = swap;
    }
    float between = angle_between(a->axis, b->axis);
    out->axis = a->axis;
    out->theta_o = a->theta_o;
    if (fminf(between + b->theta_o, PI_F) <= a->theta_o)
        return;
    float theta = 0.5f * (a->theta_o + between + b->theta_o);
    struct vec3 across = sub(b->axis, scale(a->axis, dot(a->axis, b->axis)));
    float l = length(across);
    out->theta_o = fminf(theta, PI_F);
    if (theta >= PI_F || !(l > 1e-6f)) {
        /* The same axes, but for rounding; or opposite ones. */
        out->theta_o = between < 1 ? fminf(a->theta_o + between, PI_F) : PI_F;
        return;
    }
    float turn = theta - a->theta_o;
    out->axis = normalize(add(scale(a->axis, cosf(turn)), scale(across, sinf(turn) / l)));
}

struct light_bounds light_bounds_union(const struct light_bounds *a, const struct light_bounds *b) {
    if (!(a->phi > 0))
        return *b;
    if (!(b->phi > 0))
        return *a;
    struct light_bounds out = {.theta_e = fmaxf(a->theta_e, b->theta_e), .phi = a->phi + b->phi};
    out.low = vec(fminf(a->low.x, b->low.x), fminf(a->low.y, b->low.y), fminf(a->low.z, b->low.z));
    out.high =
        vec(fmaxf(a->high.x, b->high.x), fmaxf(a->high.y, b->high.y), fmaxf(a->high.z, b->high.z));
    unite_cones(a, b, &out);
    return out;
}

float light_bounds_cost(const struct light_bounds *b) {
    float o = b->theta_o, w = fminf(o + b->theta_e, PI_F), radius = light_bounds_radius(b);
    float directions =
        2 * PI_F * (1 - cosf(o)) +
        0.5f * PI_F * (2 * w * sinf(o) - cosf(o - 2 * w) - 2 * o * sinf(o) + cosf(o));
    return b->phi * directions * radius * radius;
}
