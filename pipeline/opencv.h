/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_OPENCV_H
#define FEWRAY_PIPELINE_OPENCV_H

/* The C face of OpenCV, which has no C API of its own: image metrics and a canvas to draw on.
 * Nothing throws. */

#include "pipeline/pipeline.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Three (height, width) planes each; noise, the reference's standard error, may be NULL. Fills
 * every metric. */
int opencv_metrics(float *const test[3], float *const reference[3], float *const noise[3],
                   int width, int height, struct fewray_metrics *metrics,
                   struct fewray_error *error);

/* A canvas is (height, width, 3) bytes, RGB. A drawing call that fails makes canvas_pixels() return
 * NULL, so that the layout needn't ask after each line. */
struct canvas;
struct box {
    int x, y, width, height; /* pixels */
};
typedef unsigned int canvas_color; /* 0xRRGGBB */

struct canvas *canvas_create(int width, int height, canvas_color background);
void canvas_destroy(struct canvas **canvas);
const uint8_t *canvas_pixels(const struct canvas *canvas);

/* Draws a part of a (height, width, 3) byte picture, scaled into place: by pixel copies when it
 * grows, by averages when it shrinks. */
void canvas_paste(struct canvas *canvas, const uint8_t *rgb, int width, int height, struct box part,
                  struct box place);
void canvas_fill(struct canvas *canvas, struct box place, canvas_color color);
void canvas_outline(struct canvas *canvas, struct box place, int thickness, canvas_color color);
/* size: height of a capital, pixels; x, y: lower left corner. ASCII only. */
void canvas_text(struct canvas *canvas, int x, int y, double size, canvas_color color,
                 const char *text);
int canvas_text_width(double size, const char *text); /* pixels */

/* The heat of each value: (count, 3) bytes, RGB, from black (0) through red to pale yellow (255).
 * False without memory. */
bool heat_colors(const uint8_t *values, int count, uint8_t *rgb);

#ifdef __cplusplus
}
#endif
#endif
