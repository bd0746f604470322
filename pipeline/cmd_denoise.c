/* SPDX-License-Identifier: Apache-2.0 */
/* fewray denoise: a noisy EXR, ours or another renderer's, to a clean one. */

#include <omp.h>
#include <stdio.h>
#include <sys/stat.h>

#include "pipeline/command.h"
#include "pipeline/denoise_job.h"
#include "pipeline/denoiser_options.h"
#include "pipeline/frames.h"
#include "pipeline/interrupt.h"
#include "pipeline/options.h"
#include "pipeline/outputs.h"
#include "pipeline/progress.h"
#include "pipeline/stats.h"

enum { THREADS_MAX = 1024 };

struct denoise_options {
    struct fewray_outputs outputs;
    struct fewray_denoise_options denoise;
    struct name_list aovs;
    const char *frames; /* NULL: all that are there */
    int naming, isa, model;
    bool verbose, skip_existing;
};

static enum parse_result parse(struct denoise_options *options, int argc, char **argv,
                               int *first_file) {
    struct fewray_outputs *outputs = &options->outputs;
    const struct option_spec specs[] = {
        {"output", 'o', OPTION_TEXT, &outputs->exr, "OUT.exr",
         "the picture; all else of the file is kept", 0, 0, NULL},
        {"layers", 0, OPTION_CHOICE, &options->naming, NULL,
         "whose channel names the file has (auto)", 0, 0, LAYER_NAMINGS},
        {"aov", 0, OPTION_NAMES, &options->aovs, "NAME[,NAME...]",
         "layers to filter by the same weights: NAME.R/G/B or a coverage; auto: passes that sum up",
         0, 0, NULL},
        {"frames", 0, OPTION_TEXT, &options->frames, "A..B[xSTEP]",
         "of a sequence in.####.exr; all that are there if not given", 0, 0, NULL},
        {"skip-existing", 0, OPTION_FLAG, &options->skip_existing, NULL,
         "leave frames that are there already", 0, 0, NULL},
        {"stats", 0, OPTION_TEXT, &outputs->stats, "STATS.json", "seconds and counts of the run", 0,
         0, NULL},
        {"png", 0, OPTION_TEXT, &outputs->png, "OUT.png", "the picture in sRGB as well", 0, 0,
         NULL},
        {"threads", 0, OPTION_INT, &options->denoise.threads, "N", "all cores if not given", 1,
         THREADS_MAX, NULL},
        {"float", 0, OPTION_FLAG, &outputs->float32, NULL,
         "what is denoised as 32-bit floats, not as the file has it", 0, 0, NULL},
        DENOISER_OPTIONS(&options->denoise, &options->model, &options->isa),
        {"verbose", 'v', OPTION_FLAG, &options->verbose, NULL, "tell what was done", 0, 0, NULL},
        {0},
    };
    const struct command_line line = {
        "denoise",
        "IN.exr|IN.####.exr -o OUT.exr|OUT.####.exr [options]",
        "Filters R, G, B by the albedo, normals, depth and variance that the file has; "
        "what R, G, B were is\nkept as noisy.R, noisy.G, noisy.B. Likewise A, unless it is 1 "
        "everywhere, and the layers\nof --aov: what added up to R, G, B still does. The unfiltered "
        "emission is taken to be in\nthe layer `direct` or in one that is called NAME:emission; in "
        "all by their shares where\nthe file has no emission. Frames of a sequence are denoised "
        "each for itself.",
        specs,
        1,
        1};
    return parse_command_line(&line, argc, argv, first_file);
}

static void denoise_progress(void *user, double fraction) {
    run_progress_update(user, "denoise", fraction);
}

static void tell_run(const struct fewray_run_stats *stats) {
    fprintf(
        stderr,
        "%dx%d, %d threads: load %.2f s, denoise %.2f s, write %.2f s; %d of %d tiles needed no "
        "filter\n",
        stats->width, stats->height, stats->threads, stats->load_s, stats->denoise_s,
        stats->write_s, stats->tiles - stats->tiles_denoised, stats->tiles);
}

/* Whether the input is a pattern: a file of just that name comes first. */
static bool is_sequence(const char *input) {
    struct stat info;
    return frames_name_has_place(input) && stat(input, &info);
}

struct listener {
    struct progress progress;
    bool verbose;
};

static void tell_frame(void *user, int frame, const struct fewray_run_stats *stats) {
    struct listener *listener = user;
    char warning[160], text[200];
    if (stats_half_warning(stats, warning, sizeof warning)) {
        progress_end(&listener->progress);
        snprintf(text, sizeof text, "frame %d: %s", frame, warning);
        report_warning(NULL, text);
    }
    if (!listener->verbose)
        return;
    progress_end(&listener->progress);
    fprintf(stderr, "frame %d: ", frame);
    tell_run(stats);
}

/* Returns an exit code where the command line doesn't fit. */
static int check(const struct denoise_options *options, const char *input,
                 struct fewray_frames *frames) {
    const struct fewray_outputs *outputs = &options->outputs;
    const char *const names[3] = {outputs->exr, outputs->png, outputs->stats};
    if (!outputs->exr)
        return report_usage("denoise: no output; give -o OUT.exr");
    if (outputs_clash(outputs))
        return report_usage("denoise: two outputs have the same name; give each its own");
    if (!is_sequence(input))
        return options->frames || options->skip_existing
                   ? report_usage("denoise: %s goes with a name like in.####.exr",
                                  options->frames ? "--frames" : "--skip-existing")
                   : EXIT_DONE;
    if (options->frames && !frames_parse(options->frames, frames))
        return report_usage("denoise: --frames can't be '%s'; it takes 7, 1..48 or 1..48x2",
                            options->frames);
    for (int i = 0; i < 3; i++)
        if (names[i] && !frames_name_has_place(names[i]))
            return report_usage("denoise: %s has no one place for the frame's number: write "
                                "#### there",
                                names[i]);
    return EXIT_DONE;
}

static int run_one(const struct denoise_options *options, struct denoise_job *job,
                   struct progress *progress, int threads, struct fewray_error *error) {
    struct fewray_run_stats stats = {.threads = threads};
    struct fewray_denoiser *denoiser = NULL;
    struct run_progress run = {.tell = progress_update, .user = progress};
    run_progress_start_denoise(&run);
    job->denoise.progress_user = &run;
    const int status = denoise_job_run(job, &denoiser, &run, &stats, error);
    fewray_denoiser_destroy(&denoiser);
    progress_end(progress);
    char warning[160];
    if (!status && stats_half_warning(&stats, warning, sizeof warning))
        report_warning(NULL, warning);
    if (!status && options->verbose)
        tell_run(&stats);
    return status;
}

int cmd_denoise(int argc, char **argv) {
    struct denoise_options options = {.naming = NAMING_AUTO};
    fewray_denoise_options_init(&options.denoise);
    struct fewray_frames frames = {0, 0, 1};
    int first_file;
    const enum parse_result parsed = parse(&options, argc, argv, &first_file);
    if (parsed != PARSE_OK)
        return parsed == PARSE_HELP ? EXIT_DONE : EXIT_WRONG_COMMAND_LINE;
    const int code = check(&options, argv[first_file], &frames);
    if (code)
        return code;

    struct listener listener = {.verbose = options.verbose};
    progress_start(&listener.progress);
    const int threads = stats_threads(options.denoise.threads);
    omp_set_num_threads(threads); /* for files, too */
    options.denoise.isa = ISAS[options.isa];
    options.denoise.model = (enum fewray_denoise_model)options.model;
    options.denoise.progress = denoise_progress;
    options.denoise.cancel = interrupt_watch();
    struct denoise_job job = {.input = argv[first_file],
                              .outputs = options.outputs,
                              .denoise = options.denoise,
                              .aovs = &options.aovs,
                              .naming = (enum layer_naming)options.naming,
                              .note = report_note};
    const struct denoise_sequence sequence = {.frames = options.frames ? &frames : NULL,
                                              .skip_existing = options.skip_existing,
                                              .tell = progress_update,
                                              .tell_user = &listener.progress,
                                              .frame_done = tell_frame,
                                              .frame_user = &listener};
    struct fewray_error error;
    const int status = is_sequence(job.input)
                           ? denoise_sequence_run(&job, &sequence, threads, &error)
                           : run_one(&options, &job, &listener.progress, threads, &error);
    progress_end(&listener.progress);
    return status ? report_failure(&error) : EXIT_DONE;
}
