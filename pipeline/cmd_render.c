/* SPDX-License-Identifier: Apache-2.0 */
/* fewray render */

#include <omp.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "fewray/pipeline.h"
#include "pipeline/command.h"
#include "pipeline/denoiser_options.h"
#include "pipeline/frames.h"
#include "pipeline/interrupt.h"
#include "pipeline/options.h"
#include "pipeline/outputs.h"
#include "pipeline/progress.h"
#include "pipeline/ranks.h"

enum {
    SIZE_MAX_PIXELS = 65536,
    SPP_MAX = 65536,
    THREADS_MAX = 1024,
    DEPTH_MAX = 65536,
    PARTS_MAX = 65536,
    DEPTH_NOT_GIVEN = -2
};
#define PIXELS_MAX (1ll << 28)

enum { GUIDE_OFF, GUIDE_ODIS, GUIDE_PAPER, GUIDE_PPG };
static const char *const GUIDES[] = {"off", "odis", "paper", "ppg", NULL};
static const char *const MAP_BINS[] = {"32", "16", "8", NULL};
static const char *const AOVS[] = {"direct", "indirect", NULL};
static const char *const SWITCH[] = {"off", "on", NULL};

/* What the guide's preset says unless it is given. */
struct guide_options {
    int guide;
    int probes, share_maps, refine, map_bins; /* index; negative: not given */
    float bsdf_fraction, look_weight;         /* negative: not given */
};

struct render_options {
    struct fewray_job job;
    struct text_list defines;
    struct name_list aovs;
    struct guide_options guide;
    const char *part; /* "I/N" */
    const char *checkpoint, *resume;
    double checkpoint_every; /* 0: not given */
    int pilot, denoise, isa, model;
    int spp, adaptive, max_spp; /* 0, negative, 0: not given */
    float error;                /* 0: not given */
    bool verbose;
    const char *frames; /* NULL: one picture */
    int temporal;
    struct fewray_sequence sequence;
};

static enum parse_result parse(struct render_options *options, int argc, char **argv,
                               int *first_file) {
    struct fewray_job *job = &options->job;
    struct fewray_render_settings *settings = &job->settings;
    struct guide_options *guide = &options->guide;
    const struct option_spec specs[] = {
        {"output", 'o', OPTION_TEXT, &job->outputs.exr, "OUT.exr", "the picture and its layers", 0,
         0, NULL},
        {"spp", 0, OPTION_INT, &options->spp, "N", "samples a pixel, the first look included (4)",
         1, SPP_MAX, NULL},
        {"time", 0, OPTION_TIME, &job->goal.seconds, "T",
         "as many samples as the run has time for, 5s or 500ms or 2m; depends on the machine", 0, 0,
         NULL},
        {"error", 0, OPTION_FLOAT, &options->error, "E",
         "as many samples as an estimated mrse of the result needs, 0.02", 1e-6, 100, NULL},
        {"max-spp", 0, OPTION_INT, &options->max_spp, "N",
         "samples a pixel at most, for --error (4096)", 1, SPP_MAX, NULL},
        {"adaptive", 0, OPTION_CHOICE, &options->adaptive, NULL,
         "more samples where more error is expected (on with --time, --error)", 0, 0, SWITCH},
        {"initial", 0, OPTION_INT, &settings->initial, "N",
         "samples a pixel of the guide's first look (1)", 1, SPP_MAX, NULL},
        {"guide", 0, OPTION_CHOICE, &guide->guide, NULL,
         "what guides: our network, the paper's, path guiding (odis)", 0, 0, GUIDES},
        {"pilot", 0, OPTION_CHOICE, &options->pilot, NULL,
         "look first whether a guide pays in this scene, else do without (on)", 0, 0, SWITCH},
        {"denoise", 0, OPTION_CHOICE, &options->denoise, NULL, "filter the picture (on)", 0, 0,
         SWITCH},
        {"aovs", 0, OPTION_NAMES, &options->aovs, "direct,indirect",
         "layers whose sum is the picture, filtered like it", 0, 0, AOVS},
        {"max-depth", 0, OPTION_INT, &settings->max_depth, "D",
         "path length, 1 = emission only, -1 = no limit", -1, DEPTH_MAX, NULL},
        {"width", 0, OPTION_INT, &settings->width, "W", "pixels; alone: the scene's aspect is kept",
         1, SIZE_MAX_PIXELS, NULL},
        {"height", 0, OPTION_INT, &settings->height, "H", "pixels", 1, SIZE_MAX_PIXELS, NULL},
        {"camera-rays", 0, OPTION_INT, &settings->camera_rays, "N",
         "of a pixel at an edge, for what the camera sees (32)", 0, SPP_MAX, NULL},
        {"seed", 0, OPTION_SEED, &settings->seed, "S", "another seed, another noise", 0, 0, NULL},
        {"threads", 0, OPTION_INT, &settings->threads, "N", "all cores if not given", 1,
         THREADS_MAX, NULL},
        {"define", 'D', OPTION_DEFINE, &options->defines, "NAME=VALUE", "for $NAME in the scene", 0,
         0, NULL},
        {"lenient", 0, OPTION_FLAG, &job->scene.lenient, NULL, LENIENT_HELP, 0, 0, NULL},
        {"stats", 0, OPTION_TEXT, &job->outputs.stats, "STATS.json",
         "seconds and counts of the run", 0, 0, NULL},
        {"part", 0, OPTION_TEXT, &options->part, "I/N",
         "the I-th of N shares of the samples, --spp each, for `fewray merge`", 0, 0, NULL},
        {"skip-existing", 0, OPTION_FLAG, &job->skip_existing, NULL,
         "leave a part or frames that are there already", 0, 0, NULL},
        {"checkpoint", 0, OPTION_TEXT, &options->checkpoint, "FILE",
         "keep the state there; where it exists, go on with it; removed in the end", 0, 0, NULL},
        {"resume", 0, OPTION_TEXT, &options->resume, "FILE", "the same, but FILE must exist", 0, 0,
         NULL},
        {"checkpoint-every", 0, OPTION_TIME, &options->checkpoint_every, "T",
         "between two states, at least: 90s, 5m (300)", 0, 0, NULL},
        {"png", 0, OPTION_TEXT, &job->outputs.png, "OUT.png", "the picture in sRGB as well", 0, 0,
         NULL},
        {"preview", 0, OPTION_TEXT, &job->outputs.preview, "FILE.png",
         "the samples so far, replaced while they come", 0, 0, NULL},
        {"preview-interval", 0, OPTION_FLOAT, &job->preview_interval, "SECONDS",
         "between two previews, at least (1)", 0, 86400, NULL},
        {"float", 0, OPTION_FLAG, &job->outputs.float32, NULL,
         "32-bit floats in the EXR instead of half", 0, 0, NULL},
        {"bsdf-fraction", 0, OPTION_FLOAT, &guide->bsdf_fraction, "F",
         "of guided samples drawn from the BSDF", 0, 1, NULL},
        {"look-weight", 0, OPTION_FLOAT, &guide->look_weight, "F",
         "weight of the first look in the picture", 0, 1, NULL},
        {"probes", 0, OPTION_CHOICE, &guide->probes, NULL,
         "pool second vertices, guide later bounces (on)", 0, 0, SWITCH},
        {"refine", 0, OPTION_CHOICE, &guide->refine, NULL,
         "maps learn from the samples, above 4 spp (on)", 0, 0, SWITCH},
        {"share-maps", 0, OPTION_CHOICE, &guide->share_maps, NULL,
         "one map for 16x16 pixels of a flat surface (on)", 0, 0, SWITCH},
        {"map-bins", 0, OPTION_CHOICE, &guide->map_bins, NULL,
         "rows and columns of a map over the sphere (32)", 0, 0, MAP_BINS},
        {"guide-weights", 0, OPTION_TEXT, &settings->weights_path, "FILE",
         "another network for the guide", 0, 0, NULL},
        DENOISER_OPTIONS(&job->denoise, &options->model, &options->isa),
        {"frames", 0, OPTION_TEXT, &options->frames, "A..B[xSTEP]",
         "a sequence, its outputs named as shot.####.exr; or one frame of it", 0, 0, NULL},
        {"fps", 0, OPTION_FLOAT, &options->sequence.fps, "F",
         "frames of a second of the camera's animation (24)", 0.001, 1e6, NULL},
        {"temporal", 0, OPTION_CHOICE, &options->temporal, NULL,
         "what a sequence denoises is the mean over its frames so far (on)", 0, 0, SWITCH},
        {"verbose", 'v', OPTION_FLAG, &options->verbose, NULL, "tell what was done", 0, 0, NULL},
        {0},
    };
    const struct command_line line = {
        "render",
        "SCENE -o OUT.exr [options]",
        "Renders a scene by few samples a pixel, guided and denoised.",
        specs,
        1,
        1};
    return parse_command_line(&line, argc, argv, first_file);
}

/* "3/10" into the job. Returns an exit code. */
static int parse_part(struct render_options *options) {
    struct fewray_job *job = &options->job;
    char rest;
    if (!options->part)
        return job->skip_existing && !options->frames
                   ? report_usage("render: --skip-existing goes with --part I/N or --frames A..B")
                   : EXIT_DONE;
    if (options->frames)
        return report_usage("render: --part shares out one frame; take --frames or --part");
    if (sscanf(options->part, "%6d/%6d%c", &job->part, &job->parts, &rest) != 2 || job->part < 1 ||
        job->part > job->parts || job->parts > PARTS_MAX)
        return report_usage("render: --part '%s' isn't I/N with 1 <= I <= N <= %d", options->part,
                            PARTS_MAX);
    if (job->outputs.png || job->outputs.preview)
        return report_usage("render: a part is no picture yet; give --png to `fewray merge`");
    if (options->guide.guide == GUIDE_PPG)
        return report_usage("render: --guide ppg can't render in parts; take another guide");
    return EXIT_DONE;
}

/* What --frames says, and whether each frame has a name. Returns an exit code. */
static int check_frames(struct render_options *options) {
    const struct fewray_outputs *outputs = &options->job.outputs;
    const char *const names[3] = {outputs->exr, outputs->png, outputs->stats};
    struct fewray_frames *frames = &options->sequence.frames;
    options->sequence.skip_existing = options->job.skip_existing;
    if (!options->frames)
        return EXIT_DONE;
    if (!frames_parse(options->frames, frames))
        return report_usage("render: --frames can't be '%s'; it takes 7, 1..48 or 1..48x2",
                            options->frames);
    for (int i = 0; i < 3 && frames_count(frames) > 1; i++)
        if (names[i] && !frames_name_has_place(names[i]))
            return report_usage("render: '%s' has no place for the frame's number; write one #### "
                                "(or %%04d) into the name",
                                names[i]);
    return EXIT_DONE;
}

/* A state goes on with its own file. Returns an exit code. */
static int check_checkpoint(struct render_options *options) {
    struct fewray_job *job = &options->job;
    const struct fewray_outputs *o = &job->outputs;
    const char *file = options->resume ? options->resume : options->checkpoint;
    if (!file)
        return options->checkpoint_every > 0
                   ? report_usage("render: --checkpoint-every goes with --checkpoint FILE")
                   : EXIT_DONE;
    if (options->resume && options->checkpoint && strcmp(options->resume, options->checkpoint))
        return report_usage("render: --resume goes on with its own file; leave out --checkpoint");
    if (job->goal.seconds > 0 || options->error > 0 || options->adaptive > 0 || options->frames ||
        options->guide.guide == GUIDE_PPG)
        return report_usage("render: --checkpoint and --resume go with --spp, not with --time, "
                            "--error, --adaptive, --frames and --guide ppg");
    if (outputs_clash(&(struct fewray_outputs){
            .exr = o->exr, .png = o->png, .stats = o->stats, .preview = file}) ||
        (o->preview && !strcmp(o->preview, file)))
        return report_usage("render: the checkpoint has the name of an output; give it its own");
    job->checkpoint = file;
    job->must_resume = options->resume != NULL;
    if (options->checkpoint_every > 0)
        job->checkpoint_interval = options->checkpoint_every;
    return EXIT_DONE;
}

/* What no single option can tell. Returns an exit code. */
static int check(const struct render_options *options) {
    const struct fewray_render_settings *settings = &options->job.settings;
    const struct fewray_outputs *outputs = &options->job.outputs;
    if (!outputs->exr)
        return report_usage("render: no output; give -o OUT.exr");
    const bool timed = options->job.goal.seconds > 0, judged = options->error > 0;
    if ((options->spp > 0) + timed + judged > 1)
        return report_usage("render: --spp, --time and --error exclude each other; give one");
    if (options->max_spp && !judged)
        return report_usage("render: --max-spp needs --error");
    if ((timed || judged || options->adaptive > 0) && options->guide.guide == GUIDE_PPG)
        return report_usage("render: --time, --error and --adaptive don't go with --guide ppg");
    if ((timed || judged || options->adaptive > 0) && (options->part || options->frames))
        return report_usage("render: --time, --error and --adaptive don't go with --part and "
                            "--frames; give those --spp");
    if (outputs_clash(outputs))
        return report_usage("render: two outputs have the same name; give each its own");
    if (settings->max_depth == 0)
        return report_usage("render: --max-depth can't be 0; it takes -1 or 1..%d", DEPTH_MAX);
    if ((long long)settings->width * settings->height > PIXELS_MAX)
        return report_usage(
            "render: %dx%d are more than %lld pixels; give a smaller --width and --height",
            settings->width, settings->height, PIXELS_MAX);
    return EXIT_DONE;
}

static void tell_run(const struct fewray_run_stats *stats) {
    fprintf(stderr,
            "%dx%d, %d spp, %d threads: load %.2f s, bvh %.2f s, look %.2f s, guide %.2f s, render "
            "%.2f s, "
            "denoise %.2f s (%d of %d tiles needed no filter), write %.2f s; %.1f M rays/s; %lld "
            "samples dropped\n",
            stats->width, stats->height, stats->spp, stats->threads, stats->load_s, stats->bvh_s,
            stats->initial_s, stats->guide_s, stats->render_s, stats->denoise_s,
            stats->tiles - stats->tiles_denoised, stats->tiles, stats->write_s,
            1e-6 * (double)stats->counts.rays / (stats->initial_s + stats->render_s + 1e-9),
            stats->counts.dropped);
}

static void tell_frame(void *user, int frame, const struct fewray_run_stats *stats) {
    progress_end(user);
    fprintf(stderr, "frame %d: ", frame);
    tell_run(stats);
}

static void tell_plan(const struct fewray_run_stats *stats) {
    const struct fewray_plan *plan = &stats->plan;
    for (int i = 0; i < plan->reason_count; i++)
        fprintf(stderr, "plan: %s\n", plan->reasons[i]);
    fprintf(stderr, "plan: %.2f samples a pixel in %d passes; predicted %.2f s, took %.2f s\n",
            plan->spp, plan->passes, plan->predicted_s, stats->total_s);
}

/* Seconds of this process before now, loading of libraries included. */
static double seconds_spent(void) {
    struct timespec spent;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &spent);
    return (double)spent.tv_sec + 1e-9 * (double)spent.tv_nsec;
}

static void set_goal(const struct render_options *given, struct fewray_job *job) {
    struct fewray_goal *goal = &job->goal;
    const bool planned = goal->seconds > 0 || given->error > 0;
    if (given->spp)
        job->settings.spp = given->spp;
    goal->spent = seconds_spent();
    goal->error = given->error;
    goal->max_spp = given->max_spp;
    goal->adaptive = given->adaptive >= 0 ? given->adaptive : planned;
    goal->any_model = given->model < 0 && !job->denoise.weights_path;
}

/* Warnings come after the work, but the bar may still stand. */
static void warn_below_bar(void *user, const char *text) {
    progress_end(user);
    report_warning(NULL, text);
}

static void note_below_bar(void *user, const char *text) {
    progress_end(user);
    report_note(text);
}

static void set_guide(const struct guide_options *given, struct fewray_job *job) {
    struct fewray_render_settings *settings = &job->settings;
    job->guided = given->guide != GUIDE_OFF;
    job->ppg = given->guide == GUIDE_PPG;
    if (given->guide == GUIDE_PAPER)
        fewray_render_settings_paper(settings);
    if (given->probes >= 0)
        settings->probes = given->probes;
    if (given->share_maps >= 0)
        settings->share_maps = given->share_maps;
    if (given->refine >= 0)
        settings->refine = given->refine;
    if (given->map_bins >= 0)
        settings->map_bins = 32 >> given->map_bins;
    if (given->bsdf_fraction >= 0)
        settings->bsdf_fraction = given->bsdf_fraction;
    if (given->look_weight >= 0)
        settings->look_weight = given->look_weight;
}

int cmd_render(int argc, char **argv) {
    struct render_options options = {.guide = {GUIDE_ODIS, -1, -1, -1, -1, -1, -1},
                                     .pilot = 1,
                                     .denoise = 1,
                                     .temporal = 1,
                                     .adaptive = -1,
                                     .model = -1};
    fewray_job_init(&options.job);
    fewray_sequence_init(&options.sequence);
    int first_file;
    options.job.settings.max_depth = DEPTH_NOT_GIVEN;
    const enum parse_result parsed = parse(&options, argc, argv, &first_file);
    if (parsed != PARSE_OK)
        return parsed == PARSE_HELP ? EXIT_DONE : EXIT_WRONG_COMMAND_LINE;
    int code = check(&options);
    if (!code)
        code = parse_part(&options);
    if (!code)
        code = check_frames(&options);
    if (!code)
        code = check_checkpoint(&options);
    if (code)
        return code;
    if (options.job.settings.max_depth == DEPTH_NOT_GIVEN)
        options.job.settings.max_depth = 0;

    struct ranks ranks;
    struct fewray_error error;
    if (ranks_start(&ranks, &error))
        return report_failure(&error);
    struct progress progress;
    progress_start(&progress);
    struct fewray_job *job = &options.job;
    job->scene_path = argv[first_file];
    job->scene.defines = options.defines.items;
    job->scene.define_count = options.defines.count;
    job->settings.team = ranks_team(&ranks);
    if (!job->settings.threads)
        job->settings.threads = ranks.threads;
    if (job->settings.threads > 0)
        omp_set_num_threads(job->settings.threads); /* for files, too */
    job->progress = ranks_is_silent() ? NULL : progress_update;
    job->progress_user = &progress;
    job->settings.cancel = interrupt_watch();
    job->warn = warn_below_bar;
    job->warn_user = &progress;
    job->note = note_below_bar;
    job->note_user = &progress;
    set_guide(&options.guide, job);
    for (int k = 0; k < options.aovs.count; k++)
        if (!strcmp(options.aovs.names[k], "direct"))
            job->settings.direct = true;
        else
            job->settings.indirect = true;
    job->pilot = options.pilot && options.guide.guide == GUIDE_ODIS;
    job->denoised = options.denoise;
    job->denoise.isa = ISAS[options.isa];
    job->denoise.model =
        options.model < 0 ? FEWRAY_DENOISE_DEFAULT : (enum fewray_denoise_model)options.model;
    set_goal(&options, job);

    options.sequence.temporal = options.temporal;
    options.sequence.frame_done = options.verbose ? tell_frame : NULL;
    options.sequence.user = &progress;

    struct fewray_run_stats stats;
    const int status = options.frames ? fewray_sequence_run(job, &options.sequence, &error)
                                      : fewray_job_run(job, NULL, &stats, &error);
    progress_end(&progress);
    if (status)
        report_failure(&error);
    else if (options.verbose && !options.frames && stats.kept)
        fprintf(stderr, "%s is there already\n", job->outputs.exr);
    else if (options.verbose && !options.frames && !ranks_is_silent()) {
        if (stats.plan.made)
            tell_plan(&stats);
        tell_run(&stats);
    }
    /* After what is to be said: mpirun ends all processes with the first that fails. */
    ranks_finish(&ranks);
    return status ? EXIT_FAILED : EXIT_DONE;
}
