/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SUNSKY_TABLE_H
#define FEWRAY_GUIDE_SUNSKY_TABLE_H

/* Control points of the Hosek-Wilkie model for the turbidities 1..10. */

/* (turbidity, albedo 0 and 1, elevation's control point, RGB, A..G, I and H of eq. 8) */
extern const float sunsky_parameters[10 * 2 * 6 * 3 * 9];
/* (turbidity, albedo 0 and 1, elevation's control point, RGB): the sky's mean radiance */
extern const float sunsky_radiance[10 * 2 * 6 * 3];
/* (turbidity, elevation 2, 5, 8, ..., 89 degrees, RGB): the sun's radiance, mean over its disk;
 * blue goes below 0 where the colour leaves the gamut */
extern const float sunsky_sun[10 * 30 * 3];

#endif
