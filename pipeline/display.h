/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_DISPLAY_H
#define FEWRAY_PIPELINE_DISPLAY_H

/* What a display is sent for a radiance. */

#include <math.h>
#include <stdint.h>

/* sRGB transfer function (IEC 61966-2-1) of 0..1, 8 bits; NaN becomes black. */
static inline uint8_t display_byte(double linear) {
    if (!(linear > 0))
        return 0;
    if (linear >= 1)
        return 255;
    return (uint8_t)(255 * (linear <= 0.0031308 ? 12.92 * linear
                                                : 1.055 * pow(linear, 1 / 2.4) - 0.055) +
                     0.5);
}

#endif
