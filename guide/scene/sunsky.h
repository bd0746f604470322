/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SUNSKY_H
#define FEWRAY_GUIDE_SUNSKY_H

/* The sky and sun of Hosek and Wilkie ("An Analytic Model for Full Spectral Sky-Dome Radiance",
 * 2012, and "Adding a Solar-Radiance Function to the Hosek-Wilkie Skylight Model", 2013), as
 * Mitsuba's `sunsky` shows them in RGB. */

#include "guide/scene/scene.h"

struct sunsky {
    float turbidity; /* 1..10 */
    float sun_scale, sky_scale;
    float sun_aperture;        /* the disk's full angle, degrees, above 0 and below 180; the sun's
                                  irradiance doesn't depend on it */
    struct vec3 sun_direction; /* unit, towards the sun, in the emitter's own space: z is up */
    struct vec3 albedo;        /* of the ground, 0..1 */
};

/* *out gets the sky without its sun, a latitude-longitude image for an environment map; its own y
 * is up. The map's space and the emitter's differ by a quarter turn around x:
 *
 *     map (x, y, z) = emitter (x, z, -y)
 *
 * so with R the rotation of the emitter's to_world, the environment's to_local has the rows
 * R's column 0, R's column 2, and minus R's column 1. *sun gets a LIGHT_SUN whose direction is in
 * the emitter's space (turn it by R) and whose radiance is the mean over the disk; both are
 * black where its centre is below the horizon. The caller owns *out. */
int sunsky_create(const struct sunsky *parameters, struct fewray_image **out, struct light *sun,
                  struct fewray_error *error);

#endif
