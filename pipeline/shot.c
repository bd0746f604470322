/* SPDX-License-Identifier: Apache-2.0 */
/* What the frames of a sequence hand on to each other. */

#include "pipeline/shot.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Motion since the previous frame: offsets in x and y, then the previous depth; (3, height, width),
 * malloc'd. NULL: out of memory. */
static float *make_motion(const struct shot *shot, const struct fewray_view *now,
                          const struct fewray_frame *frame) {
    float *depth[3];
    const size_t pixels = (size_t)frame->width * (size_t)frame->height;
    float *motion = malloc(3 * pixels * sizeof *motion);
    if (motion && fewray_frame_layer(frame, FEWRAY_DEPTH, depth))
        fewray_view_motion(now, &shot->view, frame->width, frame->height, depth[0], motion,
                           motion + pixels, motion + 2 * pixels);
    return motion;
}

int shot_denoise(struct shot *shot, struct fewray_denoiser *denoiser, struct fewray_frame *frame,
                 const char *const *parts, int part_count, struct fewray_denoise_stats *stats,
                 struct fewray_error *error) {
    const struct fewray_view now = fewray_scene_view(shot->scene);
    const size_t pixels = (size_t)frame->width * (size_t)frame->height;
    float *depth[3], *buffer = NULL;
    struct fewray_denoise_motion motion = {.offset = {.channel = {NULL}}};
    const bool moved = shot->has_view && fewray_frame_layer(frame, FEWRAY_DEPTH, depth);
    if (moved && !(buffer = make_motion(shot, &now, frame)))
        return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the motion");
    if (moved) {
        float *const offset[3] = {buffer, buffer + pixels, NULL};
        float *const previous[3] = {buffer + 2 * pixels, NULL, NULL};
        motion.offset = fewray_planar(offset, frame->width);
        motion.previous_depth = fewray_planar(previous, frame->width);
    }
    int status = fewray_denoise_frame_after(denoiser, shot->history, moved ? &motion : NULL, frame,
                                            parts, part_count, stats, error);
    free(buffer);
    shot->view = now;
    shot->has_view = !status;
    return status;
}

/* NAME.R/G/B becomes what noisy.NAME.R/G/B is; false where the file has none. */
static bool restore_noisy(struct fewray_frame *frame, const char *prefix) {
    for (int c = 0; c < 3; c++) {
        char name[FEWRAY_NAME_MAX + 2], noisy_name[FEWRAY_NAME_MAX + 8];
        snprintf(name, sizeof name, "%s%c", prefix, "RGB"[c]);
        snprintf(noisy_name, sizeof noisy_name, "noisy.%s", name);
        float *to = fewray_frame_plane(frame, name);
        const float *from = fewray_frame_plane(frame, noisy_name);
        if (!to || !from)
            return false;
        memcpy(to, from, (size_t)frame->width * (size_t)frame->height * sizeof *to);
    }
    return true;
}

/* Denoised again, for the file holds the mean over the frames before, too. */
static int denoise_again(struct shot *shot, const struct fewray_denoise_options *options,
                         struct fewray_frame *frame, const char *const *parts, int part_count,
                         struct fewray_error *error) {
    struct fewray_denoiser *denoiser = NULL;
    int status = fewray_denoiser_create(options, &denoiser, error);
    if (!status)
        status = shot_denoise(shot, denoiser, frame, parts, part_count, NULL, error);
    fewray_denoiser_destroy(&denoiser);
    return status;
}

int shot_remember(struct shot *shot, const struct fewray_denoise_options *options, const char *exr,
                  const char *const *parts, int part_count, struct fewray_error *error) {
    struct fewray_frame *frame = NULL;
    int status = fewray_frame_read_exr(exr, &frame, error);
    if (status)
        return status;
    fewray_frame_repair(frame);
    bool noisy = restore_noisy(frame, "");
    for (int i = 0; i < part_count && noisy; i++) {
        char prefix[FEWRAY_NAME_MAX];
        snprintf(prefix, sizeof prefix, "%s.", parts[i]);
        noisy = restore_noisy(frame, prefix);
    }
    if (noisy)
        status = denoise_again(shot, options, frame, parts, part_count, error);
    else
        shot->has_view = false; /* the sequence begins anew behind it */
    fewray_frame_destroy(&frame);
    return status;
}

void shot_forget_scene(struct shot *shot) {
    fewray_world_destroy(&shot->world);
    fewray_scene_destroy(&shot->scene);
}

void shot_end(struct shot *shot) {
    shot_forget_scene(shot);
    fewray_denoise_history_destroy(&shot->history);
}
