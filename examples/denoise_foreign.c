/* SPDX-License-Identifier: Apache-2.0 */
/* The denoiser alone, on another renderer's picture: denoise_foreign IN.exr OUT.exr
 *
 * Shows how to hand over buffers of one's own: here the channels R, G, B and, where the file has
 * them, albedo.R/G/B and normal.X/Y/Z. */

#include <stdio.h>
#include <stdlib.h>

#include "fewray/denoise.h"

/* The channels as the denoiser wants them, or none where the file lacks the layer. */
static struct fewray_channels find_channels(const struct fewray_frame *frame,
                                            enum fewray_layer layer) {
    float *planes[3];
    if (!fewray_frame_layer(frame, layer, planes))
        return (struct fewray_channels){.channel = {NULL}};
    return fewray_planar(planes, frame->width);
}

static int denoise(struct fewray_frame *frame, struct fewray_error *error) {
    const struct fewray_denoise_input in = {
        .width = frame->width,
        .height = frame->height,
        .color = find_channels(frame, FEWRAY_COLOR),
        .albedo = find_channels(frame, FEWRAY_ALBEDO),
        .normal = find_channels(frame, FEWRAY_NORMAL),
    };
    float *color[3];
    if (!fewray_frame_layer(frame, FEWRAY_COLOR, color))
        return fewray_fail(error, FEWRAY_ERROR_FORMAT, NULL, 0, "the file has no channels R, G, B");
    const size_t count = (size_t)frame->width * (size_t)frame->height;
    float *rgb = malloc(sizeof(float) * 3 * count);
    if (!rgb)
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the picture");

    struct fewray_denoise_options options;
    fewray_denoise_options_init(&options);
    struct fewray_denoiser *denoiser = NULL;
    int status = fewray_denoiser_create(&options, &denoiser, error);
    if (!status)
        status = fewray_denoiser_run(denoiser, &in, rgb, NULL, error);
    for (size_t i = 0; !status && i < count; i++)
        for (int c = 0; c < 3; c++)
            color[c][i] = rgb[3 * i + c];
    fewray_denoiser_destroy(&denoiser);
    free(rgb);
    return status;
}

int main(int argc, char **argv) {
    if (argc != 3) {
        fprintf(stderr, "usage: denoise_foreign IN.exr OUT.exr\n");
        return 2;
    }
    struct fewray_frame *frame = NULL;
    struct fewray_error error;
    int status = fewray_frame_read_exr(argv[1], &frame, &error);
    if (!status) {
        printf("%zu bad pixels repaired\n", fewray_frame_repair(frame));
        status = denoise(frame, &error);
    }
    if (!status)
        status = fewray_frame_write_exr(frame, argv[2], false, &error);
    fewray_frame_destroy(&frame);
    if (status) {
        char text[1024];
        fprintf(stderr, "%s\n", fewray_error_text(&error, text, sizeof text));
    }
    return status ? 1 : 0;
}
