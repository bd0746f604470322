/* SPDX-License-Identifier: Apache-2.0 */
/* What a run is told not to do, and which part of a picture it makes. */

#include <string.h>

#include "pipeline/run.h"

/* Numbers that make no picture. */
static int check_numbers(const struct fewray_job *job, struct fewray_error *error) {
    const struct fewray_render_settings *s = &job->settings;
    const struct {
        const char *name;
        double value, least;
    } numbers[] = {{"spp", s->spp, 1},
                   {"initial", s->initial, 1},
                   {"width", s->width, 0},
                   {"height", s->height, 0},
                   {"threads", s->threads, 0},
                   {"max_depth", s->max_depth, -1},
                   {"the goal's max_spp", job->goal.max_spp, 0},
                   {"the goal's seconds", job->goal.seconds, 0},
                   {"the goal's error", job->goal.error, 0}};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        if (!(numbers[i].value >= numbers[i].least)) /* nor NaN */
            return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                               "%s can't be %g; it is %g or more", numbers[i].name,
                               numbers[i].value, numbers[i].least);
    return FEWRAY_OK;
}

/* Samples are counted by 32-bit numbers, the look's directions by 256 for each. */
static int check_part(const struct fewray_job *job, const struct fewray_render_settings *settings,
                      struct fewray_error *error) {
    if (!job->parts)
        return FEWRAY_OK;
    if (job->part < 1 || job->part > job->parts)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0, "there is no part %d of %d",
                           job->part, job->parts);
    if (job->guided && job->ppg)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, job->scene_path, 0,
                           "practical path guiding can't render in parts; take another guide");
    if ((long long)job->parts * settings->spp > INT32_MAX ||
        (long long)job->parts * settings->initial > INT32_MAX / 256)
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "%d parts of %d samples a pixel are more than can be counted; make "
                           "fewer parts",
                           job->parts, settings->spp);
    return FEWRAY_OK;
}

/* The checkpoint is removed in the end: an output of that name would be, too. */
static int check_checkpoint(const struct run *run, struct fewray_error *error) {
    const struct fewray_job *job = run->job;
    const struct fewray_outputs *o = &job->outputs;
    const char *const outputs[] = {o->exr, o->png, o->stats, o->preview, job->scene_path};
    if (!job->checkpoint)
        return FEWRAY_OK;
    if (planner_has_goal(&job->goal) || run->shot || (job->guided && job->ppg) ||
        (run->settings.team && run->settings.team->size > 1))
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, job->checkpoint, 0,
                           "checkpoints are of one picture of a given number of samples by one "
                           "process, not of time or error goals, frames, mpirun or path guiding");
    for (size_t i = 0; i < sizeof outputs / sizeof *outputs; i++)
        if (outputs[i] && !strcmp(outputs[i], job->checkpoint))
            return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, job->checkpoint, 0,
                               "the checkpoint has the name of another file; give its own");
    return outputs_check(&(struct fewray_outputs){.exr = job->checkpoint}, error);
}

/* A render that ran all night shouldn't end with a damaged file. */
static int check_weights(const struct fewray_job *job, struct fewray_error *error) {
    struct fewray_denoiser *denoiser = NULL;
    int status = FEWRAY_OK;
    if (job->denoised && job->denoise.weights_path)
        status = fewray_denoiser_create(&job->denoise, &denoiser, error);
    fewray_denoiser_destroy(&denoiser);
    if (!status && job->guided && !job->ppg && job->settings.weights_path)
        status = fewray_maps_check_weights(job->settings.weights_path, error);
    return status;
}

int run_check(const struct run *run, struct fewray_error *error) {
    if (run->settings.team && run->settings.team->size > 1 && run->job->guided && run->job->ppg)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, run->job->scene_path, 0,
                           "practical path guiding learns within one process; start it without "
                           "mpirun, or take another guide");
    if (run->settings.team && run->settings.team->size > 1 && run->job->outputs.preview)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, run->job->outputs.preview, 0,
                           "a preview shows what one process traces; start it without mpirun");
    if (planner_has_goal(&run->job->goal) &&
        (run->job->parts || run->shot || (run->settings.team && run->settings.team->size > 1)))
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, run->job->scene_path, 0,
                           "samples are planned for a whole picture in one process; give "
                           "parts, frames and mpirun a number of samples");
    int status = check_numbers(run->job, error);
    if (!status)
        status = check_part(run->job, &run->settings, error);
    if (!status)
        status = check_checkpoint(run, error);
    if (!status)
        status = check_weights(run->job, error);
    return status ? status : outputs_check(&run->outputs, error);
}

int run_label_part(struct run *run) {
    int width, height;
    if (!run->job->parts)
        return FEWRAY_OK;
    fewray_film_size(run->film, &width, &height);
    part_label_of_job(run->job, &run->settings, fewray_scene_fingerprint(run->scene), width, height,
                      &run->label);
    run->stats.kept =
        run->job->skip_existing && run->outputs.exr && part_is_there(&run->label, run->outputs.exr);
    return run->stats.kept ? PART_IS_THERE : FEWRAY_OK;
}
