/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_KEPT_H
#define FEWRAY_PIPELINE_KEPT_H

/* What of a denoised file changes: all else stays as it was. */

#include "pipeline/layer_names.h"
#include "pipeline/outputs.h"
#include "pipeline/pass_sums.h"

/* Refuses, before any work, a file that couldn't be written again; `kept->half` says whether its
 * colour (the channel of adoption->result) is of half floats. */
int kept_start(const char *path, const struct adoption *adoption, bool float32,
               struct kept_file *kept, struct fewray_error *error);
/* The changes of a frame that fewray_denoise_frame_layers() filtered: what it kept as noisy.NAME,
 * and NAME; and the passes, which may be NULL. The frame must live as long as they are used. */
int kept_changes(const struct fewray_frame *frame, const struct adoption *adoption,
                 const struct pass_sums *passes, struct kept_file *kept,
                 struct fewray_error *error);
void kept_end(struct kept_file *kept);

#endif
