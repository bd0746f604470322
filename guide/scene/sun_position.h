/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_SUN_POSITION_H
#define FEWRAY_GUIDE_SCENE_SUN_POSITION_H

/* Where the sun stands, after Blanco-Muriel, Alarcon-Padilla, Lopez-Moratalla, Lara-Coira 2001,
 * "Computing the Solar Vector" (the PSA algorithm), as Mitsuba's `sunsky`. */

#include "guide/vec.h"

struct sun_time {
    double latitude, longitude; /* degrees, north and east */
    double timezone;            /* hours ahead of universal time */
    int year, month, day;
    double hour, minute, second;
};

/* Unit, towards the sun: x south, y west, z up. */
struct vec3 sun_position(const struct sun_time *time);

#endif
