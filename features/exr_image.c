/* SPDX-License-Identifier: Apache-2.0 */
/* EXR files as images: textures and environment maps. */
#include "features/features_private.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The channel of the layer that a plane's name begins with: "beauty." or "". */
static const float *layer_channel(const struct fewray_frame *frame, const char *red, char channel) {
    char name[FEWRAY_NAME_MAX];
    snprintf(name, sizeof name, "%s", red);
    name[strlen(name) - 1] = channel;
    return fewray_frame_plane(frame, name);
}

/* Finds the channels; returns their number. */
static int find_channels(const struct fewray_frame *frame, const float *channels[4]) {
    for (size_t i = 0; i < frame->plane_count; i++) {
        const char *name = frame->planes[i].name, *dot = strrchr(name, '.');
        if (strcmp(dot ? dot + 1 : name, "R") != 0 || (dot && fewray_frame_plane(frame, "R")))
            continue;
        for (int c = 0; c < 4; c++)
            channels[c] = layer_channel(frame, name, "RGBA"[c]);
        if (channels[1] && channels[2])
            return channels[3] ? 4 : 3;
    }
    static const char *const grey[] = {"Y", "R"};
    channels[0] = frame->planes[0].data;
    for (int i = 1; i >= 0; i--)
        if (fewray_frame_plane(frame, grey[i]))
            channels[0] = fewray_frame_plane(frame, grey[i]);
    return 1;
}

int exr_image(const struct fewray_frame *frame, const char *path, struct fewray_image **out,
              struct fewray_error *error) {
    const size_t pixels = (size_t)frame->width * (size_t)frame->height;
    const float *from[4];
    const int channels = find_channels(frame, from);
    struct fewray_image *image = *out = calloc(1, sizeof *image);
    if (image)
        image->floats = malloc(pixels * (size_t)channels * sizeof(float));
    if (!image || !image->floats) {
        fewray_image_destroy(out);
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0, "out of memory");
    }
    image->width = frame->width;
    image->height = frame->height;
    image->channels = channels;
    for (size_t i = 0; i < pixels; i++)
        for (int c = 0; c < channels; c++)
            image->floats[i * (size_t)channels + (size_t)c] = from[c][i];
    return FEWRAY_OK;
}
