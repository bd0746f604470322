/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_PREVIEW_H
#define FEWRAY_PIPELINE_PREVIEW_H

/* A picture of the samples so far, for a person who waits: a PNG that is replaced now and then, as
 * a whole, for as little time as a few per cent of the render's. */

#include <stdatomic.h>

#include "fewray/pipeline.h"

struct preview {
    const char *path;       /* NULL: none is wanted */
    double interval;        /* seconds between two previews, at least */
    double start;           /* of the tracing; seconds, as all times here */
    double due;             /* time of the next one; changes only while no thread traces */
    _Atomic double noticed; /* when the first thread stopped because it was due; 0: none has */
    double spent;           /* seconds of wall time on previews so far */
    int shown;              /* previews so far */
    const struct fewray_world *world;
    struct fewray_render_settings settings;
    bool covered;                /* every pixel has a sample */
    struct fewray_frame *coarse; /* stands in for pixels without one until then; NULL: not needed */
    bool denoised;
    struct fewray_denoise_options options;
    struct fewray_denoiser *denoiser; /* made for the first preview */
};

/* Previews of the job, which traces this world by these settings, from now on. */
void preview_start(struct preview *preview, const struct fewray_job *job,
                   const struct fewray_world *world, const struct fewray_render_settings *settings);
void preview_end(struct preview *preview);

/* Whether the next preview's time has come. From any thread. */
bool preview_due(struct preview *preview);
/* Writes the film's picture where that is due; the first one after a whole pass over the picture
 * in any case. Nobody may trace meanwhile. What fails is left out: the previous preview stays.
 * Returns the seconds that it took. */
double preview_show(struct preview *preview, const struct fewray_film *film,
                    const struct fewray_maps *maps, bool whole_pass);

/* When the next preview is due after one that ended at `now`, with `spent` seconds on all previews
 * since the tracing's start. */
double preview_next(double start, double now, double spent, double interval);
/* Pixels of the picture, along one side, for one of the preview. */
int preview_factor(int width, int height);
/* Means over factor x factor pixels of every plane; variance becomes that of the means. *out is
 * owned by the caller. */
int preview_shrink(const struct fewray_frame *frame, int factor, int threads,
                   struct fewray_frame **out, struct fewray_error *error);

#endif
