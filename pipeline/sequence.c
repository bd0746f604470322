/* SPDX-License-Identifier: Apache-2.0 */
/* The frames of a sequence, one after another. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "pipeline/frames.h"
#include "pipeline/outputs.h"
#include "pipeline/shot.h"

/* Older frames count for less than a part in a hundred of what is filtered. */
#define FRAMES_REMEMBERED 32

struct sequence_run {
    const struct fewray_sequence *sequence;
    struct fewray_job job; /* of the frame: its outputs, seed and $frame */
    const struct fewray_job *shared;
    struct shot shot;
    int frame; /* of the one that is rendered, for the progress */
    char *names[3];
    char number[16];
};

void fewray_sequence_init(struct fewray_sequence *sequence) {
    *sequence = (struct fewray_sequence){.frames = {0, 0, 1}, .fps = 24, .temporal = true};
}

/* Seeds far apart for any seed and frame (Steele, Lea, Flood 2014, "Fast splittable pseudorandom
 * number generators": the finalizer). */
static uint64_t frame_seed(uint64_t seed, int frame) {
    uint64_t z = seed + 0x9e3779b97f4a7c15u * ((uint64_t)frame + 1);
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

static void free_names(struct sequence_run *run) {
    for (int i = 0; i < 3; i++)
        free(run->names[i]);
    memset(run->names, 0, sizeof run->names);
}

/* The job of this frame. */
static int set_frame(struct sequence_run *run, int frame, struct fewray_error *error) {
    const struct fewray_outputs *patterns = &run->shared->outputs;
    const char *const wanted[3] = {patterns->exr, patterns->png, patterns->stats};
    free_names(run);
    for (int i = 0; i < 3; i++)
        if (wanted[i] && !(run->names[i] = frames_name(wanted[i], frame)))
            return fewray_fail(error, FEWRAY_ERROR_MEMORY, wanted[i], 0,
                               "no memory for a file name");
    run->job.outputs.exr = run->names[0];
    run->job.outputs.png = run->names[1];
    run->job.outputs.stats = run->names[2];
    snprintf(run->number, sizeof run->number, "%d", frame);
    run->job.scene.frame = run->number;
    run->job.settings.seed = frame_seed(run->shared->settings.seed, frame);
    run->shot.time = frame / (double)run->sequence->fps;
    return FEWRAY_OK;
}

static bool exists(const struct sequence_run *run) {
    struct stat info;
    bool all = run->names[0] || run->names[1] || run->names[2];
    for (int i = 0; i < 3; i++)
        all = all && (!run->names[i] || !stat(run->names[i], &info));
    return all;
}

/* Loads the scene for frames that aren't rendered, whose camera the history needs. */
static int load_for_camera(struct sequence_run *run, struct fewray_error *error) {
    struct fewray_scene_options options = run->job.scene;
    options.threads = run->job.settings.threads;
    int status = FEWRAY_OK;
    if (!run->shot.scene)
        status = fewray_scene_load(run->job.scene_path, &options, &run->shot.scene, error);
    if (!status)
        fewray_scene_set_time(run->shot.scene, run->shot.time);
    return status;
}

/* A scene with $frame is another one in each frame. */
static void end_frame(struct sequence_run *run) {
    if (run->shot.scene && fewray_scene_summarize(run->shot.scene).uses_frame)
        shot_forget_scene(&run->shot);
}

static int remember(struct sequence_run *run, int frame, struct fewray_error *error) {
    const char *parts[2];
    int part_count = 0;
    if (run->job.settings.direct)
        parts[part_count++] = "direct";
    if (run->job.settings.indirect)
        parts[part_count++] = "indirect";
    struct fewray_denoise_options options = run->job.denoise;
    options.threads = run->job.settings.threads;
    options.cancel = run->job.settings.cancel;
    int status = set_frame(run, frame, error);
    if (!status)
        status = load_for_camera(run, error);
    if (!status)
        status = shot_remember(&run->shot, &options, run->names[0], parts, part_count, error);
    end_frame(run);
    return status;
}

/* A frame's progress as that of the sequence. */
static void frame_progress(void *user, const struct fewray_progress *of_frame) {
    const struct sequence_run *run = user;
    const struct fewray_frames *frames = &run->sequence->frames;
    const int before = (run->frame - frames->first) / frames->step, count = frames_count(frames);
    struct fewray_progress now = *of_frame;
    now.fraction = (before + of_frame->fraction) / count;
    if (of_frame->seconds_left >= 0 && of_frame->fraction < 1) /* later frames take as long */
        now.seconds_left *= 1 + (count - before - 1) / (1 - of_frame->fraction);
    run->shared->progress(run->shared->progress_user, &now);
}

static int render(struct sequence_run *run, int frame, struct fewray_error *error) {
    struct fewray_run_stats stats;
    run->frame = frame;
    int status = shot_run_frame(&run->job, &run->shot, NULL, &stats, error);
    end_frame(run);
    if (status == FEWRAY_ERROR_CANCELLED && error) { /* those before it are written in any case */
        char what[sizeof error->what];
        memcpy(what, error->what, sizeof what);
        fewray_fail(error, status, run->job.scene_path, 0, "frame %d: %s", frame, what);
    }
    run->job.warn = NULL; /* once is enough */
    if (!status && run->sequence->frame_done)
        run->sequence->frame_done(run->sequence->user, frame, &stats);
    return status;
}

/* Renders what isn't there yet. What lies directly before goes into the history first. */
static int run_frames(struct sequence_run *run, struct fewray_error *error) {
    const struct fewray_frames *frames = &run->sequence->frames;
    int skipped = 0, status = FEWRAY_OK;
    for (int frame = frames->first; frame <= frames->last && !status; frame += frames->step) {
        if ((status = set_frame(run, frame, error)))
            break;
        if (run->sequence->skip_existing && exists(run)) {
            skipped++;
            continue;
        }
        int known = run->shot.history && run->names[0] ? skipped : 0;
        known = known < FRAMES_REMEMBERED ? known : FRAMES_REMEMBERED;
        for (; known > 0 && !status; known--)
            status = remember(run, frame - known * frames->step, error);
        skipped = 0;
        if (!status)
            status = set_frame(run, frame, error);
        if (!status)
            status = render(run, frame, error);
    }
    return status;
}

static int check(const struct fewray_job *job, const struct fewray_sequence *sequence,
                 struct fewray_error *error) {
    const struct fewray_outputs *outputs = &job->outputs;
    const char *const names[3] = {outputs->exr, outputs->png, outputs->stats};
    const struct fewray_frames *frames = &sequence->frames;
    if (frames->first < 0 || frames->last < frames->first || frames->step < 1 ||
        !(sequence->fps > 0))
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                           "frames %d..%d in steps of %d at %g frames a second can't be rendered",
                           frames->first, frames->last, frames->step, (double)sequence->fps);
    for (int i = 0; i < 3 && frames_count(frames) > 1; i++)
        if (names[i] && !frames_name_has_place(names[i]))
            return fewray_fail(
                error, FEWRAY_ERROR_ARGUMENT, names[i], 0,
                "the name has no one place for the frame's number: write #### there");
    return FEWRAY_OK;
}

int fewray_sequence_run(const struct fewray_job *job, const struct fewray_sequence *sequence,
                        struct fewray_error *error) {
    struct sequence_run run = {.sequence = sequence, .job = *job, .shared = job};
    if (job->progress) {
        run.job.progress = frame_progress;
        run.job.progress_user = &run;
    }
    int status = check(job, sequence, error);
    if (!status && job->denoised && sequence->temporal && frames_count(&sequence->frames) > 1) {
        struct fewray_denoise_history_options options;
        fewray_denoise_history_options_init(&options);
        options.threads = job->settings.threads;
        status = fewray_denoise_history_create(&options, &run.shot.history, error);
    }
    if (!status)
        status = run_frames(&run, error);
    free_names(&run);
    shot_end(&run.shot);
    return status;
}
