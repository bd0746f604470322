/* SPDX-License-Identifier: Apache-2.0 */
/* fewray-shrink: a smaller reference for the studies. Each pixel becomes the mean of a block of
 * pixels, which is what a box filter of that size sees; stderr.R/G/B become those of the means.
 *
 *     fewray-shrink IN.exr WIDTHxHEIGHT OUT.exr
 */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "fewray/features.h"

/* spreads: the values are standard errors of independent pixels. */
static float block_mean(const float *block, int stride, int width, int height, bool spreads) {
    double sum = 0;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            double value = block[(size_t)y * (size_t)stride + (size_t)x];
            sum += spreads ? value * value : value;
        }
    return (float)((spreads ? sqrt(sum) : sum) / (width * height));
}

static int shrink(const struct fewray_frame *in, int width, int height, struct fewray_frame **out,
                  struct fewray_error *error) {
    if (width < 1 || height < 1 || in->width % width || in->height % height)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "%dx%d doesn't divide the picture's %dx%d", width, height, in->width,
                           in->height);
    int status = fewray_frame_create(width, height, out, error);
    int bw = in->width / width, bh = in->height / height;
    for (size_t p = 0; !status && p < in->plane_count; p++) {
        const struct fewray_plane *plane = &in->planes[p];
        bool spreads = !strncmp(plane->name, "stderr.", 7);
        float *to = fewray_frame_add(*out, plane->name);
        if (!to)
            return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the picture");
        for (int y = 0; y < height; y++)
            for (int x = 0; x < width; x++)
                to[(size_t)y * (size_t)width + (size_t)x] = block_mean(
                    plane->data + (size_t)(y * bh) * (size_t)in->width + (size_t)(x * bw),
                    in->width, bw, bh, spreads);
    }
    return status;
}

int main(int argc, char **argv) {
    int width, height;
    char text[1100], after;
    if (argc != 4 || sscanf(argv[2], "%dx%d%c", &width, &height, &after) != 2) {
        fprintf(stderr, "usage: %s IN.exr WIDTHxHEIGHT OUT.exr\n", argv[0]);
        return 2;
    }
    struct fewray_frame *in = NULL, *out = NULL;
    struct fewray_error error;
    int status = fewray_frame_read_exr(argv[1], &in, &error);
    status = status ? status : shrink(in, width, height, &out, &error);
    status = status ? status : fewray_frame_write_exr(out, argv[3], true, &error);
    if (status)
        fprintf(stderr, "fewray-shrink: %s\n", fewray_error_text(&error, text, sizeof(text)));
    fewray_frame_destroy(&in);
    fewray_frame_destroy(&out);
    return status ? 1 : 0;
}
