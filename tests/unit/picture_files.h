/* SPDX-License-Identifier: Apache-2.0 */
#ifndef PICTURE_FILES_H
#define PICTURE_FILES_H

#include <stdbool.h>

/* EXRs as other renderers write them, made by OpenImageIO: several parts, half or float, any
 * channel names. */

#ifdef __cplusplus
extern "C" {
#endif

struct picture_part {
    const char *name;     /* NULL: the part has none */
    const char *channels; /* their names, separated by commas */
};

/* Writes parts of width x height pixels. The value of channel c of part p at pixel i, row 0 on top,
 * is picture_value(p, c, i). spp > 0 is written as samplesPerPixel. False with a message on stderr
 * where it can't. */
bool picture_write(const char *path, int width, int height, bool half, int spp,
                   const struct picture_part *parts, int part_count);

/* Small multiples of 1/64, which half floats hold. */
static inline float picture_value(int part, int channel, int pixel) {
    return (float)(1 + part * 8 + channel + 16 * (pixel % 7)) * 0.015625f;
}

#ifdef __cplusplus
}
#endif
#endif
