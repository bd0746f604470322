/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_CROPS_H
#define FEWRAY_PIPELINE_CROPS_H

/* Where to look closer: places for magnified crops. */

#include "fewray/pipeline.h"

/* Picks FEWRAY_CROPS places of (crop_width, crop_height) pixels, which don't overlap where the
 * picture has room: the first where the denoised display picture is farthest from the target, the
 * second where the denoiser changed most of what has detail, the third where detail is finest. All
 * pictures are (height, width, 3) bytes; target is the reference, or the denoised picture again.
 * False without memory. */
bool crops_pick(const uint8_t *noisy, const uint8_t *denoised, const uint8_t *target, int width,
                int height, int crop_width, int crop_height,
                struct fewray_crop crops[FEWRAY_CROPS]);

#endif
