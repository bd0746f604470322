/* SPDX-License-Identifier: Apache-2.0 */
/* Measures the steps after the last sample on a small picture. */

#include "pipeline/probe.h"

#include <stdlib.h>

#include "pipeline/clock.h"

enum { SIDE = 128 }; /* pixels: two by two of the denoiser's tiles, enough for all threads */
enum { RUNS = 3 };

static void fill_by_noise(float *plane, uint32_t *state) {
    for (int i = 0; i < SIDE * SIDE; i++) {
        *state = *state * 1664525u + 1013904223u;
        plane[i] = (float)(*state >> 8) * 0x1p-24f;
    }
}

/* What a render's frame holds, but noise; it compresses worse than a picture. */
static int make_frame(struct fewray_frame **out, struct fewray_error *error) {
    static const enum fewray_layer layers[] = {
        FEWRAY_COLOR,         FEWRAY_VARIANCE,   FEWRAY_ALBEDO,
        FEWRAY_SHADED_ALBEDO, FEWRAY_NORMAL,     FEWRAY_EMISSION,
        FEWRAY_DEPTH,         FEWRAY_IRRADIANCE, FEWRAY_IRRADIANCE_CONFIDENCE};
    uint32_t state = 1;
    int status = fewray_frame_create(SIDE, SIDE, out, error);
    for (size_t k = 0; k < sizeof layers / sizeof *layers && !status; k++) {
        float *planes[3] = {NULL, NULL, NULL};
        if (!fewray_frame_add_layer(*out, layers[k], planes))
            return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the planner");
        /* an emitter that shines everywhere would leave nothing to filter */
        for (int c = 0; c < 3 && layers[k] != FEWRAY_EMISSION; c++)
            if (planes[c])
                fill_by_noise(planes[c], &state);
    }
    return status;
}

static int probe_denoiser(const struct fewray_job *job, int threads,
                          enum fewray_denoise_model model, double *seconds,
                          struct fewray_error *error) {
    struct fewray_denoise_options options = job->denoise;
    options.threads = threads;
    options.model = model;
    options.cancel = NULL;
    options.progress = NULL;
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_frame *frame = NULL;
    int status = fewray_denoiser_create(&options, &denoiser, error);
    if (!status)
        status = make_frame(&frame, error);
    for (int k = 0; k < RUNS && !status; k++) { /* the first also fetches memory and threads */
        double lap = clock_seconds();
        status = fewray_denoise_frame(denoiser, frame, NULL, error);
        const double run = clock_lap(&lap);
        *seconds = k == 0 || run < *seconds ? run : *seconds;
    }
    fewray_frame_destroy(&frame);
    fewray_denoiser_destroy(&denoiser);
    return status;
}

static int probe_files(const struct fewray_outputs *outputs, double *seconds,
                       struct fewray_error *error) {
    struct fewray_frame *frame = NULL;
    char *exr = outputs->exr ? fewray_temporary_name(outputs->exr) : NULL;
    char *png = outputs->png ? fewray_temporary_name(outputs->png) : NULL;
    int status = make_frame(&frame, error);
    double lap = clock_seconds();
    if (!status && exr)
        status = fewray_frame_write_exr(frame, exr, outputs->float32, error);
    if (!status && png)
        status = fewray_frame_write_png(frame, png, error);
    *seconds = clock_lap(&lap);
    if (exr)
        fewray_discard_file(exr);
    if (png)
        fewray_discard_file(png);
    free(exr);
    free(png);
    fewray_frame_destroy(&frame);
    return status;
}

int probe_run(const struct fewray_job *job, int threads, long long pixels,
              struct probe_seconds *seconds, struct fewray_error *error) {
    const double scale = (double)pixels / (SIDE * SIDE);
    *seconds = (struct probe_seconds){0};
    int status = FEWRAY_OK;
    for (int model = 0; model < 2 && job->denoised && !status; model++)
        status = probe_denoiser(job, threads, (enum fewray_denoise_model)model,
                                &seconds->denoise[model], error);
    if (!status && (job->outputs.exr || job->outputs.png))
        status = probe_files(&job->outputs, &seconds->write, error);
    seconds->denoise[0] *= scale;
    seconds->denoise[1] *= scale;
    seconds->write *= scale;
    return status;
}
