/* SPDX-License-Identifier: Apache-2.0 */
/* Previews: what the film holds, made smaller where the picture is large, denoised by the fast
 * network, as a PNG. */

#include "pipeline/preview.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "pipeline/clock.h"
#include "pipeline/coarse.h"

#define PREVIEW_SHARE  0.04      /* of the time since the tracing's start, for all previews */
#define PREVIEW_PIXELS (1 << 20) /* about; larger pictures are made smaller */

double preview_next(double start, double now, double spent, double interval) {
    return fmax(now + interval, start + spent / PREVIEW_SHARE);
}

int preview_factor(int width, int height) {
    return (int)ceil(sqrt((double)width * height / PREVIEW_PIXELS));
}

void preview_start(struct preview *preview, const struct fewray_job *job,
                   const struct fewray_world *world,
                   const struct fewray_render_settings *settings) {
    *preview = (struct preview){.path = job->outputs.preview,
                                .interval = job->preview_interval,
                                .start = clock_seconds(),
                                .world = world,
                                .settings = *settings,
                                /* Path guiding's film tells no variance before its end. */
                                .denoised = job->denoised && !(job->guided && job->ppg),
                                .options = job->denoise};
    preview->due = preview->start + preview->interval;
    preview->options.model = FEWRAY_DENOISE_FAST;
    preview->options.weights_path = NULL;
    preview->options.threads = settings->threads;
    preview->options.cancel = settings->cancel;
    preview->options.progress = NULL;
}

void preview_end(struct preview *preview) {
    fewray_frame_destroy(&preview->coarse);
    fewray_denoiser_destroy(&preview->denoiser);
}

bool preview_due(struct preview *preview) {
    const double now = clock_seconds();
    if (!preview->path || now < preview->due)
        return false;
    double nobody = 0;
    atomic_compare_exchange_strong(&preview->noticed, &nobody, now);
    return true;
}

/* One plane, `scale` times the means over blocks of factor x factor pixels. */
static void shrink_plane(const float *from, int width, int height, int factor, float scale,
                         float *to) {
    const int columns = (width + factor - 1) / factor, rows = (height + factor - 1) / factor;
    for (int j = 0; j < rows; j++)
        for (int i = 0; i < columns; i++) {
            float sum = 0;
            int count = 0;
            for (int y = j * factor; y < (j + 1) * factor && y < height; y++)
                for (int x = i * factor; x < (i + 1) * factor && x < width; x++, count++)
                    sum += from[(size_t)y * (size_t)width + (size_t)x];
            to[(size_t)j * (size_t)columns + (size_t)i] = scale * sum / (float)count;
        }
}

int preview_shrink(const struct fewray_frame *frame, int factor, int threads,
                   struct fewray_frame **out, struct fewray_error *error) {
    int status = fewray_frame_create((frame->width + factor - 1) / factor,
                                     (frame->height + factor - 1) / factor, out, error);
    for (size_t k = 0; !status && k < frame->plane_count; k++)
        if (!fewray_frame_add(*out, frame->planes[k].name))
            status = fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the preview");
    if (status) {
        fewray_frame_destroy(out);
        return status;
    }
#pragma omp parallel for schedule(dynamic) num_threads(threads)
    for (size_t k = 0; k < frame->plane_count; k++) {
        const bool variance = !strncmp(frame->planes[k].name, "variance.", 9);
        const float scale = variance ? 1.0f / (float)(factor * factor) : 1;
        shrink_plane(frame->planes[k].data, frame->width, frame->height, factor, scale,
                     (*out)->planes[k].data);
    }
    return FEWRAY_OK;
}

/* A noisy preview is better than none, so that a failure only ends the filtering. */
static void start_denoiser(struct preview *preview) {
    if (preview->denoised && !preview->denoiser)
        preview->denoised = !fewray_denoiser_create(&preview->options, &preview->denoiser, NULL);
}

/* Filters the frame; pixels without a sample get the coarse picture's colour. */
static int finish(struct preview *preview, struct fewray_frame *frame) {
    bool *mask = NULL;
    int status = FEWRAY_OK;
    if (!preview->covered && !preview->coarse)
        status = coarse_trace(preview->world, &preview->settings, frame->width, frame->height,
                              preview->denoiser, &preview->coarse, NULL);
    if (!status && !preview->covered)
        mask = malloc((size_t)frame->width * (size_t)frame->height * sizeof(*mask));
    if (mask)
        coarse_mask(frame, mask);
    if (!status && preview->denoised)
        status = fewray_denoise_frame(preview->denoiser, frame, NULL, NULL);
    if (!status && mask)
        coarse_fill(preview->coarse, mask, frame);
    free(mask);
    return status;
}

static int write_preview(struct preview *preview, const struct fewray_film *film,
                         const struct fewray_maps *maps) {
    struct fewray_frame *frame = NULL, *small = NULL;
    int status = fewray_film_frame(film, maps, &frame, NULL);
    const int factor = status ? 1 : preview_factor(frame->width, frame->height);
    if (!status && factor > 1) {
        status = preview_shrink(frame, factor, preview->options.threads, &small, NULL);
        fewray_frame_destroy(&frame);
        frame = small;
    }
    start_denoiser(preview);
    if (!status)
        status = finish(preview, frame);
    if (!status)
        status = fewray_frame_write_png(frame, preview->path, NULL);
    fewray_frame_destroy(&frame);
    return status;
}

double preview_show(struct preview *preview, const struct fewray_film *film,
                    const struct fewray_maps *maps, bool whole_pass) {
    const double begin = clock_seconds();
    const bool due = begin >= preview->due, first = !preview->shown && whole_pass;
    preview->covered |= whole_pass;
    if (preview->covered)
        fewray_frame_destroy(&preview->coarse);
    const double noticed = atomic_exchange(&preview->noticed, 0);
    if (!preview->path || !(due || first))
        return 0;
    preview->shown += write_preview(preview, film, maps) == FEWRAY_OK;
    /* Threads that had finished their tiles waited for the last one. */
    const double now = clock_seconds(), took = now - (noticed > 0 ? noticed : begin);
    preview->spent += took;
    preview->due = preview_next(preview->start, now, preview->spent, preview->interval);
    return took;
}
