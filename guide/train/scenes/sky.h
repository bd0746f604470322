/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TRAIN_SKY_H
#define FEWRAY_TRAIN_SKY_H

/* What lies outside the windows: a constant, or a procedural sky that is written as a
 * latitude-longitude picture. */

#include "fewray/features.h"
#include "guide/train/scenes/random.h"
#include "guide/vec.h"

enum sky_kind { SKY_NONE, SKY_CONSTANT, SKY_MAP };

#define SKY_PANELS 8

struct sky {
    enum sky_kind kind;
    float strength; /* multiplies all that follows */
    struct vec3 zenith, horizon, ground;
    struct vec3 sun_dir;                   /* unit, towards the sun */
    struct vec3 sun;                       /* radiance of its disc, zero = none */
    float sun_cos;                         /* cosine of its angular radius */
    float glow, glow_power;                /* halo around the sun */
    float cloud, cloud_scale, cloud_light; /* cover 0..1, frequency, brightness */
    float skyline,
        skyline_scale; /* height of hills and houses over the horizon, sine of elevation */
    int panel_count;   /* soft boxes and street lamps: discs of light */
    struct vec3 panel_dir[SKY_PANELS], panel[SKY_PANELS];
    float panel_cos[SKY_PANELS];
    uint32_t noise_seed;
};

/* A random sky with mean radiance of about 1. */
void sky_random(struct sky *sky, struct random *r);
/* Radiance from a unit direction; without the sun's disc where with_sun is false. */
struct vec3 sky_radiance(const struct sky *sky, struct vec3 dir, bool with_sun);
/* Writes the sky as an EXR for Mitsuba's envmap (its own to_world: identity). */
int sky_write(const struct sky *sky, const char *path, struct fewray_error *error);

#endif
