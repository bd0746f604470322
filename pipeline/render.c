/* SPDX-License-Identifier: Apache-2.0 */
/* The whole way of a picture: load, look, guide, render, denoise, write. */

#include <math.h>

#include "pipeline/clock.h"
#include "pipeline/run.h"
#include "pipeline/stats.h"

void fewray_job_init(struct fewray_job *job) {
    *job = (struct fewray_job){.guided = true, .denoised = true, .pilot = true};
    fewray_render_settings_init(&job->settings);
    fewray_denoise_options_init(&job->denoise);
    job->settings.spp = 4;
    job->settings.initial = 1;
    job->preview_interval = 1;
    job->checkpoint_interval = 300;
}

/* Whether the render has a first look and maps made of it. */
static bool has_maps(const struct run *run) {
    return run->guided && !run->job->ppg;
}

/* --- who waits: progress of the whole run, and previews */

/* A phase begins. */
static void tell(struct run *run, const char *phase) {
    run_progress_update(&run->progress, phase, 0);
}

static void expect(struct run *run, bool guided) {
    const struct fewray_render_settings *settings = &run->settings;
    const bool maps = guided && !run->job->ppg;
    const int look = maps ? settings->initial : 0;
    int width, height;
    fewray_film_size(run->film, &width, &height);
    const struct run_work work = {.pixels = (long long)width * height,
                                  .threads = settings->threads,
                                  .look = look,
                                  .rest = settings->spp - look,
                                  .maps = maps,
                                  .edges = settings->spp < settings->camera_rays,
                                  .denoised = run->job->denoised,
                                  .pictures =
                                      !!run->job->outputs.png + !!run->job->outputs.preview};
    run_progress_expect(&run->progress, &work);
}

static bool preview_is_due(void *user) {
    return preview_due(&((struct run *)user)->preview);
}

void run_show_preview(struct run *run, bool whole_pass) {
    const double seconds = preview_show(&run->preview, run->film, run->maps, whole_pass);
    estimate_except(&run->progress.estimate, seconds);
    run->stats.previews = run->preview.shown;
    run->stats.preview_s = run->preview.spent;
}

static void show_preview(void *user, bool whole_pass) {
    run_show_preview(user, whole_pass);
}

static void start_run(struct run *run, const struct fewray_job *job) {
    *run = (struct run){.job = job, .settings = job->settings, .model = job->denoise.model};
    if (run_is_first(run))
        run->outputs = job->outputs;
    struct fewray_render_settings *settings = &run->settings;
    settings->threads = stats_threads(settings->threads);
    if (job->parts) {
        settings->part = job->part - 1;
        run->outputs.float32 = true;
    }
    if (settings->initial > settings->spp)
        settings->initial = settings->spp;
    run->progress = (struct run_progress){.tell = job->progress,
                                          .user = job->progress_user,
                                          .tell_phase = job->settings.progress,
                                          .phase_user = job->settings.progress_user};
    run_progress_start(&run->progress);
    settings->progress = run_progress_update;
    settings->progress_user = &run->progress;
    if (job->outputs.preview) {
        settings->pause_due = preview_is_due;
        settings->paused = show_preview;
        settings->pause_user = run;
    }
    run->stats.threads = settings->threads;
    run->stats.spp = settings->spp;
    run->start = run->lap = clock_seconds();
}

/* --- the steps */

/* Scene file to acceleration structure and empty film. */
static int load(struct run *run, struct fewray_error *error) {
    struct fewray_scene_options options = run->job->scene;
    options.threads = run->settings.threads;
    tell(run, "load");
    int status = FEWRAY_OK;
    if (!run->scene)
        status = fewray_scene_load(run->job->scene_path, &options, &run->scene, error);
    if (!status && run->shot) {
        run->shot->scene = run->scene;
        fewray_scene_set_time(run->scene, run->shot->time);
    }
    run->stats.load_s = clock_lap(&run->lap);
    if (status)
        return status;
    const struct fewray_scene_summary summary = fewray_scene_summarize(run->scene);
    run->stats.unused_textures = summary.unused_textures;
    run->stats.no_images = !summary.images;
    tell(run, "bvh");
    if (!run->world)
        status = fewray_world_create(run->scene, run->settings.threads, &run->world, error);
    if (!status)
        status = fewray_film_create(run->world, &run->settings, &run->film, error);
    run->stats.bvh_s = clock_lap(&run->lap);
    preview_start(&run->preview, run->job, run->world, &run->settings);
    if (!status)
        expect(run, run->job->guided);
    return status;
}

/* What a few paths tell: whether to guide at all; and how to reach the goal, where there is one. */
static int decide(struct run *run, struct fewray_error *error) {
    const bool planned = planner_has_goal(&run->job->goal) && !run->job->ppg;
    run->guided = run->job->guided;
    if (!planned && (!run->guided || !run->job->pilot))
        return FEWRAY_OK;
    struct fewray_pilot pilot;
    tell(run, "pilot");
    double lap = clock_seconds();
    int status = fewray_trace_pilot(run->world, &run->settings, run->film, &pilot,
                                    &run->stats.counts, error);
    if (!status && run->guided && run->job->pilot)
        run->guided = fewray_pilot_wants_guide(&pilot);
    if (!status && pilot.bounce_variance > 0) {
        run->settings.bounce_share = fminf(pilot.bounce_variance / pilot.variance, 1);
        run->settings.bounce_variance = pilot.bounce_variance;
    }
    double pilot_s = clock_lap(&lap);
    if (!status && run->job->goal.seconds > 0) { /* again, with memory and threads warm */
        struct fewray_pilot again;
        status = fewray_trace_pilot(run->world, &run->settings, run->film, &again,
                                    &run->stats.counts, error);
        pilot_s = fmin(pilot_s, clock_lap(&lap));
    }
    if (!status && planned)
        status = planner_create(run->job, run->start, &run->planner, error);
    if (!status && planned)
        status = planner_prepare(run->planner, &pilot, pilot_s, &run->settings, &run->guided,
                                 &run->model, error);
    run->stats.guide_skipped = run->job->guided && !run->guided;
    expect(run, run->guided);
    if (run->job->goal.seconds > 0)
        estimate_expect(&run->progress.estimate, "render",
                        fmax(0, run->job->goal.seconds - (clock_seconds() - run->start)));
    return status;
}

/* Goes on with what an earlier run has left. */
static int resume(struct run *run, struct fewray_error *error) {
    const int status = run_checkpoint_resume(run, error);
    if (!status && run->stats.resumes)
        expect(run, run->guided);
    return status;
}

/* The first samples of each pixel, and what they saw. */
static int look(struct run *run, struct fewray_error *error) {
    if (!has_maps(run) || run->maps)
        return FEWRAY_OK;
    tell(run, "first look");
    const struct fewray_render_settings settings = run_checkpoint_settings(run);
    const int status =
        fewray_trace_look(run->world, &settings, run->film, &run->look, &run->stats.counts, error);
    run->stats.initial_s = clock_lap(&run->lap);
    return status;
}

/* Sampling maps; also where no sample is left for them, because the irradiance layer comes from
 * them. */
static int guide(struct run *run, struct fewray_error *error) {
    if (!has_maps(run) || run->maps)
        return FEWRAY_OK;
    tell(run, "guide");
    run->stats.first_look_was_all = run->settings.initial == run->settings.spp;
    const int status =
        fewray_maps_create(run->look, &run->settings, &run->maps, &run->stats.counts, error);
    if (!status) {
        if (run->checkpoint.state)
            fewray_state_has_maps(run->checkpoint.state);
        fewray_look_destroy(&run->look);
    }
    run->stats.guide_s = clock_lap(&run->lap);
    return status;
}

/* Who asked for a guide finds its layers even where the scene didn't need it: no estimate,
 * confidence 0. */
static int add_empty_irradiance(struct fewray_frame *frame, struct fewray_error *error) {
    float *planes[3];
    if (fewray_frame_add_layer(frame, FEWRAY_IRRADIANCE, planes) &&
        fewray_frame_add_layer(frame, FEWRAY_IRRADIANCE_CONFIDENCE, planes))
        return FEWRAY_OK;
    return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the picture's layers");
}

int run_develop(struct run *run, struct fewray_error *error) {
    int status = fewray_film_frame(run->film, run->maps, &run->frame, error);
    if (!status && run->stats.guide_skipped)
        status = add_empty_irradiance(run->frame, error);
    if (!status && run->job->parts) {
        status = fewray_film_add_moments(run->film, run->maps, run->frame, error);
        if (!status && !part_label_write(&run->label, run->frame))
            status = fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "no memory for the header");
    }
    if (!status) {
        run->stats.width = run->frame->width;
        run->stats.height = run->frame->height;
    }
    return status;
}

static void denoise_progress(void *user, double fraction) {
    const struct fewray_render_settings *settings = user;
    settings->progress(settings->progress_user, "denoise", fraction);
}

int run_denoise(struct run *run, struct fewray_error *error) {
    const char *parts[2];
    int part_count = 0;
    if (run->settings.direct)
        parts[part_count++] = "direct";
    if (run->settings.indirect)
        parts[part_count++] = "indirect";
    if (!run->job->denoised || run->job->parts || !run_is_first(run) ||
        fewray_frame_plane(run->frame, "noisy.R"))
        return FEWRAY_OK;
    if (!run->planner) /* it looks at pictures while it renders */
        tell(run, "denoise");
    struct fewray_denoise_options options = run->job->denoise;
    options.model = run->model;
    options.threads = run->job->settings.threads;
    options.cancel = run->settings.cancel;
    options.progress = run->planner ? NULL : denoise_progress;
    options.progress_user = &run->settings;
    struct fewray_denoiser *denoiser = NULL;
    struct fewray_denoise_stats stats = {0};
    int status = fewray_denoiser_create(&options, &denoiser, error);
    if (!status && run->shot && run->shot->history)
        status = shot_denoise(run->shot, denoiser, run->frame, parts, part_count, &stats, error);
    else if (!status)
        status =
            fewray_denoise_frame_layers(denoiser, run->frame, parts, part_count, &stats, error);
    fewray_denoiser_destroy(&denoiser);
    run->undenoised = status && status != FEWRAY_ERROR_CANCELLED;
    run->stats.tiles = stats.tiles;
    run->stats.tiles_denoised = stats.tiles_denoised;
    run->stats.denoise_s += clock_lap(&run->lap);
    return status;
}

/* The remaining samples. */
static int render(struct run *run, struct fewray_error *error) {
    struct fewray_render_stats *counts = &run->stats.counts;
    bool ppg = run->guided && run->job->ppg;
    tell(run, "render");
    if (run->planner)
        return run_to_goal(run, error);
    const struct fewray_render_settings settings = run_checkpoint_settings(run);
    int status =
        ppg ? fewray_trace_ppg(run->world, &settings, run->film, counts, error)
            : fewray_trace_rest(run->world, run->maps, &settings, run->film, counts, error);
    if (!status) {
        run_checkpoint_traced(run);
        status = fewray_trace_edges(run->world, &run->settings, run->film, counts, error);
    }
    if (!status && run_is_first(run))
        status = run_develop(run, error);
    if (!status && !run->checkpoint.state) { /* the denoiser gets their memory */
        fewray_film_destroy(&run->film);
        fewray_maps_destroy(&run->maps);
    }
    run->stats.render_s = clock_lap(&run->lap);
    return status;
}

static int write(struct run *run, struct fewray_error *error) {
    if (!run_is_first(run))
        return FEWRAY_OK;
    tell(run, "write");
    const int status = outputs_write(&run->outputs, run->frame, &run->stats, run->start, error);
    run->lap = clock_seconds();
    return status;
}

/* A cancelled run still leaves the samples that it has. Returns FEWRAY_ERROR_CANCELLED, or why it
 * couldn't. */
static int write_what_is_done(struct run *run, struct fewray_error *error) {
    const bool safe = run_checkpoint_stop(run);
    const char *how = safe ? "; go on with --resume " : "",
               *file = safe ? run->job->checkpoint : "";
    if (run->job->parts)
        return fewray_fail(error, FEWRAY_ERROR_CANCELLED, run->outputs.exr, 0,
                           "interrupted; a part is written whole or not at all%s%s", how, file);
    int status = run->film || run->frame ? FEWRAY_OK : FEWRAY_ERROR_CANCELLED;
    if (!status && run->film)
        status = fewray_film_share(run->film, run->settings.team, error);
    if (!status && !run->frame && run_is_first(run) && fewray_film_is_empty(run->film))
        status = FEWRAY_ERROR_CANCELLED;
    if (!status && !run->frame && run_is_first(run))
        status = run_develop(run, error);
    if (!status)
        status = write(run, error);
    status = run_agree(run, status, error);
    if (status && status != FEWRAY_ERROR_CANCELLED)
        return status;
    return fewray_fail(
        error, FEWRAY_ERROR_CANCELLED, run->job->scene_path, 0, "interrupted; %s%s%s",
        run->frame ? "what was done is written" : "nothing was done yet, so nothing is written",
        how, file);
}

/* The samples aren't lost to a denoiser that fails. */
static void write_undenoised(struct run *run, int status, struct fewray_error *error) {
    if (write(run, NULL) || !error)
        return;
    const struct fewray_error why = *error;
    fewray_fail(error, status, why.file, why.line, "%s; the picture is written undenoised",
                why.what);
}

static void tell_warnings(const struct run *run) {
    const struct fewray_scene_summary summary = fewray_scene_summarize(run->scene);
    for (int i = 0; i < summary.warning_count; i++)
        run->job->warn(run->job->warn_user, summary.warnings[i]);
    if (run->stats.plan.too_short)
        run->job->warn(
            run->job->warn_user,
            "the time is too short for one sample a pixel; that was rendered all the same");
    if (run->stats.plan.hit_max_spp)
        run->job->warn(run->job->warn_user,
                       "the error wasn't reached with the most samples allowed; raise --max-spp");
    char text[160];
    if (stats_half_warning(&run->stats, text, sizeof text))
        run->job->warn(run->job->warn_user, text);
}

static void end_run(struct run *run) {
    run_checkpoint_end(run);
    planner_destroy(&run->planner);
    preview_end(&run->preview);
    fewray_frame_destroy(&run->frame);
    fewray_maps_destroy(&run->maps);
    fewray_look_destroy(&run->look);
    fewray_film_destroy(&run->film);
    if (run->shot) {
        run->shot->world = run->world;
        return;
    }
    fewray_world_destroy(&run->world);
    fewray_scene_destroy(&run->scene);
}

int shot_run_frame(const struct fewray_job *job, struct shot *shot, struct fewray_frame **picture,
                   struct fewray_run_stats *stats, struct fewray_error *error) {
    if (picture)
        *picture = NULL;
    struct run run;
    start_run(&run, job);
    if (shot) {
        run.shot = shot;
        run.scene = shot->scene;
        run.world = shot->world;
    }
    int status = run_agree(&run, run_check(&run, error), error);
    if (status)
        return status;
    if ((status = run_agree(&run, run_checkpoint_open(&run, error), error)) ||
        (status = run_agree(&run, load(&run, error), error)) ||
        (status = run_agree(&run, run_label_part(&run), error)) ||
        (status = run_agree(&run, decide(&run, error), error)) ||
        (status = run_agree(&run, resume(&run, error), error)) ||
        (status = run_agree(&run, look(&run, error), error)) ||
        (status = run_agree(&run, guide(&run, error), error)) ||
        (status = run_agree(&run, render(&run, error), error)) ||
        (status = run_agree(&run, run_denoise(&run, error), error)) ||
        (status = run_agree(&run, write(&run, error), error))) {
        if (status == FEWRAY_ERROR_CANCELLED)
            status = write_what_is_done(&run, error);
        else if (status == PART_IS_THERE)
            status = FEWRAY_OK;
        else {
            if (run.checkpoint.traced) /* a full disk, say: the samples aren't lost */
                run_checkpoint_stop(&run);
            if (run.undenoised)
                write_undenoised(&run, status, error);
        }
    } else {
        run_checkpoint_remove(&run);
        if (job->warn)
            tell_warnings(&run);
    }

    if (picture && (!status || status == FEWRAY_ERROR_CANCELLED)) {
        *picture = run.frame;
        run.frame = NULL;
    }
    if (stats)
        *stats = run.stats;
    end_run(&run);
    return status;
}

int fewray_job_run(const struct fewray_job *job, struct fewray_frame **picture,
                   struct fewray_run_stats *stats, struct fewray_error *error) {
    return shot_run_frame(job, NULL, picture, stats, error);
}
