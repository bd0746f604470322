/* SPDX-License-Identifier: Apache-2.0 */
/* A small picture, made as large as the preview. */

#include "pipeline/coarse.h"

#include <math.h>

#define COARSE_PIXELS 4 /* of the picture for one path, along one side */
#define CAMERA_RAYS   8 /* of a pixel at an edge: a path's alone is a ragged one */

static const char *const RGB[3] = {"R", "G", "B"};

static int trace_small(const struct fewray_world *world,
                       const struct fewray_render_settings *settings, int width, int height,
                       struct fewray_frame **out, struct fewray_error *error) {
    struct fewray_render_settings small = *settings;
    struct fewray_render_stats stats = {0};
    struct fewray_film *film = NULL;
    small.width = width;
    small.height = height;
    small.spp = small.initial = 1;
    small.direct = small.indirect = false;
    small.camera_rays = CAMERA_RAYS;
    small.progress = NULL;
    small.pause_due = NULL;
    int status = fewray_film_create(world, &small, &film, error);
    if (!status)
        status = fewray_trace_rest(world, NULL, &small, film, &stats, error);
    if (!status)
        status = fewray_trace_edges(world, &small, film, &stats, error);
    if (!status)
        status = fewray_film_frame(film, NULL, out, error);
    fewray_film_destroy(&film);
    return status;
}

/* Place of pixel i of `to` between two pixels of `from`: the first one, and the second one's share.
 */
static int place(int i, int from, int to, float *share) {
    const float center = fmaxf(((float)i + 0.5f) * (float)from / (float)to - 0.5f, 0);
    int first = (int)center;
    first = first < from - 1 ? first : from - 1;
    *share = first < from - 1 ? center - (float)first : 0;
    return first;
}

/* Bilinear interpolation of one plane. */
static void enlarge(const float *small, int columns, int rows, float *large, int width,
                    int height) {
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            float u, v;
            const int i = place(x, columns, width, &u), j = place(y, rows, height, &v);
            const float *above = small + (size_t)j * (size_t)columns + (size_t)i;
            const float *below = v > 0 ? above + columns : above;
            const int right = u > 0;
            large[(size_t)y * (size_t)width + (size_t)x] =
                (1 - v) * ((1 - u) * above[0] + u * above[right]) +
                v * ((1 - u) * below[0] + u * below[right]);
        }
}

int coarse_trace(const struct fewray_world *world, const struct fewray_render_settings *settings,
                 int width, int height, struct fewray_denoiser *denoiser, struct fewray_frame **out,
                 struct fewray_error *error) {
    struct fewray_frame *small = NULL;
    *out = NULL;
    int status = trace_small(world, settings, (width + COARSE_PIXELS - 1) / COARSE_PIXELS,
                             (height + COARSE_PIXELS - 1) / COARSE_PIXELS, &small, error);
    if (!status && denoiser)
        status = fewray_denoise_frame(denoiser, small, NULL, error);
    if (!status)
        status = fewray_frame_create(width, height, out, error);
    for (int c = 0; c < 3 && !status; c++) {
        float *plane = fewray_frame_add(*out, RGB[c]);
        if (plane)
            enlarge(fewray_frame_plane(small, RGB[c]), small->width, small->height, plane, width,
                    height);
        else
            status = fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the preview");
    }
    if (status)
        fewray_frame_destroy(out);
    fewray_frame_destroy(&small);
    return status;
}

void coarse_mask(const struct fewray_frame *frame, bool *mask) {
    float *color[3], *albedo[3], *depth[3];
    const size_t pixels = (size_t)frame->width * (size_t)frame->height;
    const bool complete = fewray_frame_layer(frame, FEWRAY_COLOR, color) &&
                          fewray_frame_layer(frame, FEWRAY_ALBEDO, albedo) &&
                          fewray_frame_layer(frame, FEWRAY_DEPTH, depth);
    for (size_t i = 0; i < pixels; i++) {
        mask[i] = complete && depth[0][i] == 0;
        for (int c = 0; c < 3 && mask[i]; c++)
            mask[i] = color[c][i] == 0 && albedo[c][i] == 0;
    }
}

void coarse_fill(const struct fewray_frame *coarse, const bool *mask, struct fewray_frame *frame) {
    const size_t pixels = (size_t)frame->width * (size_t)frame->height;
    for (int c = 0; c < 3; c++) {
        const float *from = fewray_frame_plane(coarse, RGB[c]);
        float *to = fewray_frame_plane(frame, RGB[c]);
        for (size_t i = 0; i < pixels; i++)
            if (mask[i])
                to[i] = from[i];
    }
}
