/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_OPENCV_H
#define FEWRAY_PIPELINE_OPENCV_H

/* The C face of OpenCV, which has no C API of its own: image metrics and a canvas to draw on.
 * It is a module (features/module.h). Nothing throws. */

#include "fewray/pipeline.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A canvas is (height, width, 3) bytes, RGB. A drawing call that fails makes pixels() return NULL,
 * so that the layout needn't ask after each line. */
struct canvas;
struct box {
    int x, y, width, height; /* pixels */
};
typedef unsigned int canvas_color; /* 0xRRGGBB */

/* What the module "opencv" exports as fewray_opencv. */
struct opencv {
    /* Three (height, width) planes each; noise, the reference's standard error, may be NULL. Fills
     * every metric. */
    int (*metrics)(float *const test[3], float *const reference[3], float *const noise[3],
                   int width, int height, struct fewray_metrics *metrics,
                   struct fewray_error *error);

    struct canvas *(*create)(int width, int height, canvas_color background); /* or NULL */
    void (*destroy)(struct canvas **canvas);
    const uint8_t *(*pixels)(const struct canvas *canvas);

    /* Draws a part of a (height, width, 3) byte picture, scaled into place: by pixel copies when it
     * grows, by averages when it shrinks. */
    void (*paste)(struct canvas *canvas, const uint8_t *rgb, int width, int height, struct box part,
                  struct box place);
    void (*fill)(struct canvas *canvas, struct box place, canvas_color color);
    void (*outline)(struct canvas *canvas, struct box place, int thickness, canvas_color color);
    /* Points are x, y pairs in pixels, fractions count; the centre of the first pixel is 0, 0.
     * Lines and edges are smooth. */
    void (*polyline)(struct canvas *canvas, const double *points, int count, int thickness,
                     canvas_color color);
    void (*polygon)(struct canvas *canvas, const double *points, int count,
                    canvas_color color); /* filled */
    void (*disc)(struct canvas *canvas, double x, double y, double radius, canvas_color color);
    /* size: height of a capital, pixels; x, y: lower left corner. ASCII only. */
    void (*text)(struct canvas *canvas, int x, int y, double size, canvas_color color,
                 const char *text);
    int (*text_width)(double size, const char *text); /* pixels */

    /* The heat of each value: (count, 3) bytes, RGB, from black (0) through red to pale yellow
     * (255). False without memory. */
    bool (*heat_colors)(const uint8_t *values, int count, uint8_t *rgb);
};
FEWRAY_API extern const struct opencv fewray_opencv;

/* Opens the module; NULL, with *error filled, where it can't be had. */
const struct opencv *opencv_open(struct fewray_error *error);

#ifdef __cplusplus
}
#endif
#endif
