/* SPDX-License-Identifier: Apache-2.0 */
/* When checkpoints are written, and what of a run goes into them. */

#include "pipeline/run_checkpoint.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

#include "features/cancel.h"
#include "pipeline/clock.h"
#include "pipeline/run.h"

#define REST_PER_SECOND 50 /* seconds without one after one that took a second: 2 % of the time */

static void note(const struct run *run, const char *text) {
    if (run->job->note)
        run->job->note(run->job->note_user, text);
}

static bool is_interrupted(const struct run *run) {
    return cancel_wanted(run->job->settings.cancel);
}

int run_checkpoint_open(struct run *run, struct fewray_error *error) {
    struct run_checkpoint *checkpoint = &run->checkpoint;
    const char *path = run->job->checkpoint;
    if (!path)
        return FEWRAY_OK;
    const int status = checkpoint_open(path, run->job->must_resume, &checkpoint->from, error);
    return status ? status : fewray_state_create(&checkpoint->state, error);
}

static void label_run(struct run *run) {
    int width, height;
    fewray_film_size(run->film, &width, &height);
    checkpoint_info_init(&run->checkpoint.info);
    part_label_of_job(run->job, &run->settings, fewray_scene_fingerprint(run->scene), width, height,
                      &run->checkpoint.info.label);
}

/* What the user sees of it. */
static void tell_resumed(struct run *run) {
    struct run_checkpoint *checkpoint = &run->checkpoint;
    const double samples = fewray_state_samples(checkpoint->state);
    const int spp = run->settings.spp;
    const bool looking = !fewray_state_is_behind_look(checkpoint->state);
    const int look = run->maps ? run->settings.initial : 0, rest = spp - look;
    char text[128];
    snprintf(text, sizeof text, "resumed at %.4g of %d samples a pixel", samples, spp);
    note(run, text);
    run->stats.resumes = checkpoint->info.resumes;
    run->stats.resumed_spp = samples;
    run->stats.earlier_s = checkpoint->earlier_s;
    run->progress.resumed_phase = looking ? "first look" : "render";
    run->progress.resumed_part = looking    ? samples / run->settings.initial
                                 : rest > 0 ? (samples - look) / rest
                                            : 1;
}

int run_checkpoint_resume(struct run *run, struct fewray_error *error) {
    struct run_checkpoint *checkpoint = &run->checkpoint;
    if (!checkpoint->state)
        return FEWRAY_OK;
    label_run(run);
    checkpoint->start = clock_seconds();
    checkpoint->due = checkpoint->start + run->job->checkpoint_interval;
    if (!checkpoint->from.file)
        return FEWRAY_OK;
    int status = checkpoint_check(&checkpoint->from, &checkpoint->info.label, error);
    if (!status) {
        status = fewray_state_read(checkpoint->state, &run->settings, run->film, &run->maps,
                                   &run->stats.counts, checkpoint_read, &checkpoint->from,
                                   checkpoint->from.left, error);
        if (status && error)
            snprintf(error->file, sizeof error->file, "%s", checkpoint->from.path);
    }
    checkpoint->info.resumes = checkpoint->from.info.resumes + 1;
    checkpoint->earlier_s = checkpoint->from.info.seconds;
    checkpoint_close(&checkpoint->from);
    if (!status && fewray_state_is_behind_look(checkpoint->state))
        run->guided = run->maps != NULL;
    if (!status)
        tell_resumed(run);
    return status;
}

static bool write_state(void *user, bool (*write)(void *out, const void *bytes, size_t size),
                        void *out) {
    const struct run *run = user;
    const struct run_checkpoint *checkpoint = &run->checkpoint;
    return fewray_state_write(checkpoint->state, &run->settings, run->film, run->maps,
                              checkpoint->traced ? &checkpoint->counts : &run->stats.counts, write,
                              out);
}

/* Writes the file; a failure is told once, and the older file stays. */
static bool save(struct run *run) {
    struct run_checkpoint *checkpoint = &run->checkpoint;
    struct fewray_error error = {0};
    checkpoint->info.seconds = checkpoint->earlier_s + clock_seconds() - run->start;
    checkpoint->info.samples = fewray_state_samples(checkpoint->state);
    const int status =
        checkpoint_write(run->job->checkpoint, &checkpoint->info, write_state, run, &error);
    run->stats.checkpoints += !status;
    if (status && !checkpoint->failing) {
        char reason[600], text[700];
        fewray_error_text(&error, reason, sizeof reason);
        snprintf(text, sizeof text, "%s; %s", reason,
                 is_interrupted(run) ? "an older one stays as it is"
                                     : "rendering goes on, an older one stays as it is");
        note(run, text);
    }
    checkpoint->failing = status != FEWRAY_OK;
    return !status;
}

/* --- between tiles */

static bool pause_due(void *user) {
    struct run *run = user;
    struct run_checkpoint *checkpoint = &run->checkpoint;
    if (preview_due(&run->preview) || is_interrupted(run))
        return true;
    const double now = clock_seconds();
    if (now < checkpoint->due)
        return false;
    double nobody = 0;
    atomic_compare_exchange_strong(&checkpoint->noticed, &nobody, now);
    return true;
}

static void paused(void *user, bool whole_pass) {
    struct run *run = user;
    struct run_checkpoint *checkpoint = &run->checkpoint;
    const double begin = clock_seconds(), noticed = atomic_exchange(&checkpoint->noticed, 0);
    const bool interrupted = is_interrupted(run);
    if (run->preview.path && !interrupted)
        run_show_preview(run, whole_pass);
    if (interrupted ? checkpoint->stopped : begin < checkpoint->due)
        return;
    const bool saved = save(run);
    if (interrupted) {
        checkpoint->stopped = saved;
        cancel_set(&checkpoint->stop);
        return;
    }
    const double now = clock_seconds(), took = now - (noticed > 0 ? noticed : begin);
    const double interval = run->job->checkpoint_interval;
    checkpoint->due = now + (interval > 0 ? fmax(interval, REST_PER_SECOND * took) : 0);
    run->stats.checkpoint_s += took;
    estimate_except(&run->progress.estimate, took);
}

struct fewray_render_settings run_checkpoint_settings(struct run *run) {
    struct fewray_render_settings settings = run->settings;
    if (!run->checkpoint.state)
        return settings;
    settings.state = run->checkpoint.state;
    settings.cancel = &run->checkpoint.stop;
    settings.pause_due = pause_due;
    settings.paused = paused;
    settings.pause_user = run;
    return settings;
}

void run_checkpoint_traced(struct run *run) {
    run->checkpoint.traced = true;
    run->checkpoint.counts = run->stats.counts;
}

bool run_checkpoint_stop(struct run *run) {
    struct run_checkpoint *checkpoint = &run->checkpoint;
    if (checkpoint->state && !cancel_wanted(&checkpoint->stop) && run->film &&
        fewray_state_can_be_written(checkpoint->state))
        checkpoint->stopped = save(run);
    return checkpoint->stopped;
}

void run_checkpoint_remove(struct run *run) {
    const char *const outputs[] = {run->outputs.exr, run->outputs.png, run->outputs.stats};
    if (!run->checkpoint.state)
        return;
    for (size_t i = 0; i < sizeof outputs / sizeof *outputs; i++)
        if (outputs[i])
            checkpoint_sync(outputs[i]);
    unlink(run->job->checkpoint);
}

void run_checkpoint_end(struct run *run) {
    checkpoint_close(&run->checkpoint.from);
    fewray_state_destroy(&run->checkpoint.state);
}
