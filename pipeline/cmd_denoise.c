/* SPDX-License-Identifier: Apache-2.0 */
/* fewray denoise: a noisy EXR, ours or another renderer's, to a clean one. */

#include <omp.h>
#include <stdio.h>
#include <string.h>

#include "pipeline/clock.h"
#include "pipeline/command.h"
#include "pipeline/denoiser_options.h"
#include "pipeline/interrupt.h"
#include "pipeline/layer_names.h"
#include "pipeline/options.h"
#include "pipeline/outputs.h"
#include "pipeline/progress.h"
#include "pipeline/run_progress.h"
#include "pipeline/stats.h"

enum { THREADS_MAX = 1024 };

static const char *const NAMINGS[] = {"auto",    "fewray", "mitsuba",
                                      "blender", "pbrt",   NULL}; /* as enum layer_naming */

struct denoise_options {
    struct fewray_outputs outputs;
    struct fewray_denoise_options denoise;
    struct name_list aovs;
    int naming, isa, model;
    bool verbose;
};

static enum parse_result parse(struct denoise_options *options, int argc, char **argv,
                               int *first_file) {
    struct fewray_outputs *outputs = &options->outputs;
    const struct option_spec specs[] = {
        {"output", 'o', OPTION_TEXT, &outputs->exr, "OUT.exr",
         "the picture; other channels are kept", 0, 0, NULL},
        {"layers", 0, OPTION_CHOICE, &options->naming, NULL,
         "whose channel names the file has (auto)", 0, 0, NAMINGS},
        {"aov", 0, OPTION_NAMES, &options->aovs, "NAME[,NAME...]",
         "layers to filter by the same weights: NAME.R/G/B or a coverage", 0, 0, NULL},
        {"stats", 0, OPTION_TEXT, &outputs->stats, "STATS.json", "seconds and counts of the run", 0,
         0, NULL},
        {"png", 0, OPTION_TEXT, &outputs->png, "OUT.png", "the picture in sRGB as well", 0, 0,
         NULL},
        {"threads", 0, OPTION_INT, &options->denoise.threads, "N", "all cores if not given", 1,
         THREADS_MAX, NULL},
        {"float", 0, OPTION_FLAG, &outputs->float32, NULL,
         "32-bit floats in the EXR instead of half", 0, 0, NULL},
        DENOISER_OPTIONS(&options->denoise, &options->model, &options->isa),
        {"verbose", 'v', OPTION_FLAG, &options->verbose, NULL, "tell what was done", 0, 0, NULL},
        {0},
    };
    const struct command_line line = {
        "denoise",
        "IN.exr -o OUT.exr [options]",
        "Filters R, G, B by the albedo, normals, depth and variance that the file has; "
        "what R, G, B were is\nkept as noisy.R, noisy.G, noisy.B. Likewise A, unless it is 1 "
        "everywhere, and the layers\nof --aov: what added up to R, G, B still does. The unfiltered "
        "emission is taken to be in\nthe layer `direct` or in one that is called NAME:emission; in "
        "all by their shares where\nthe file has no emission.",
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

/* Whether a channel belongs to a layer of the list, "NAME" or "NAME:emission". */
static bool is_named(const struct name_list *aovs, const char *channel) {
    for (int k = 0; k < aovs->count; k++) {
        const size_t length = strcspn(aovs->names[k], ":");
        if (!strncmp(aovs->names[k], channel, length) &&
            (channel[length] == '.' || channel[length] == 0))
            return true;
    }
    return false;
}

/* What was denoised before is denoised again from its noisy layers, which the denoiser's input is.
 */
static void undo_denoising(struct fewray_frame *frame, const struct name_list *aovs) {
    for (size_t i = 0; i < frame->plane_count; i++) {
        const char *name = frame->planes[i].name;
        if (strncmp(name, "noisy.", 6))
            continue;
        name += 6;
        const bool wanted = (*name && strchr("RGBA", *name) && !name[1]) || is_named(aovs, name);
        float *denoised = wanted ? fewray_frame_plane(frame, name) : NULL;
        if (denoised)
            memcpy(denoised, frame->planes[i].data,
                   sizeof(float) * (size_t)frame->width * (size_t)frame->height);
    }
}

/* Bad pixels of the layers that the denoiser is to filter, as in the colour. */
static void repair_aovs(const struct fewray_frame *frame, const struct name_list *aovs) {
    for (int k = 0; k < aovs->count; k++)
        for (int c = 0; c < 3; c++) {
            char channel[sizeof *aovs->names + 2];
            const int length = (int)strcspn(aovs->names[k], ":");
            snprintf(channel, sizeof channel, "%.*s.%c", length, aovs->names[k], "RGB"[c]);
            float *data = fewray_frame_plane(frame, channel);
            if (data)
                fewray_frame_repair_radiance(frame, data);
        }
}

static int denoise_file(const struct denoise_options *options, const char *path,
                        struct run_progress *progress, struct fewray_run_stats *stats,
                        struct fewray_error *error) {
    struct fewray_denoise_stats work = {0};
    struct fewray_frame *frame = NULL;
    struct fewray_denoiser *denoiser = NULL;
    const double start = clock_seconds();
    double lap = start;
    int status;
    const char *names[NAME_LIST_MAX];
    for (int k = 0; k < options->aovs.count; k++)
        names[k] = options->aovs.names[k];

    run_progress_update(progress, "load", 0);
    if ((status = outputs_check(&options->outputs, error)) ||
        (status = read_picture(path, options->naming, &frame, error)))
        goto done;
    undo_denoising(frame, &options->aovs);
    stats->repaired = fewray_frame_repair(frame);
    repair_aovs(frame, &options->aovs);
    fewray_frame_compact(frame);
    stats->width = frame->width;
    stats->height = frame->height;
    stats->load_s = clock_lap(&lap);

    const struct run_work expected = {.pixels = (long long)frame->width * frame->height,
                                      .threads = options->denoise.threads,
                                      .denoised = true,
                                      .pictures = !!options->outputs.png};
    run_progress_expect(progress, &expected);
    if ((status = fewray_denoiser_create(&options->denoise, &denoiser, error)) ||
        (status = fewray_denoise_frame_layers(denoiser, frame, names, options->aovs.count, &work,
                                              error)))
        goto done;
    stats->tiles = work.tiles;
    stats->tiles_denoised = work.tiles_denoised;
    stats->denoise_s = clock_lap(&lap);

    run_progress_update(progress, "write", 0);
    status = outputs_write(&options->outputs, frame, stats, start, error);
done:
    if (status == FEWRAY_ERROR_CANCELLED)
        fewray_fail(error, FEWRAY_ERROR_CANCELLED, path, 0, "interrupted; nothing is written");
    fewray_denoiser_destroy(&denoiser);
    fewray_frame_destroy(&frame);
    return status;
}

int cmd_denoise(int argc, char **argv) {
    struct denoise_options options = {.naming = NAMING_AUTO};
    fewray_denoise_options_init(&options.denoise);
    int first_file;
    const enum parse_result parsed = parse(&options, argc, argv, &first_file);
    if (parsed != PARSE_OK)
        return parsed == PARSE_HELP ? EXIT_DONE : EXIT_WRONG_COMMAND_LINE;
    if (!options.outputs.exr)
        return report_usage("denoise: no output; give -o OUT.exr");
    if (outputs_clash(&options.outputs))
        return report_usage("denoise: two outputs have the same name; give each its own");

    struct progress progress;
    progress_start(&progress);
    struct fewray_run_stats stats = {.threads = stats_threads(options.denoise.threads)};
    omp_set_num_threads(stats.threads); /* for files, too */
    struct run_progress run = {.tell = progress_update, .user = &progress};
    run_progress_start_denoise(&run);
    options.denoise.isa = ISAS[options.isa];
    options.denoise.model = (enum fewray_denoise_model)options.model;
    options.denoise.progress = denoise_progress;
    options.denoise.progress_user = &run;
    options.denoise.cancel = interrupt_watch();
    struct fewray_error error;
    const int status = denoise_file(&options, argv[first_file], &run, &stats, &error);
    progress_end(&progress);
    if (status)
        return report_failure(&error);
    char warning[160];
    if (stats_half_warning(&stats, warning, sizeof warning))
        report_warning(NULL, warning);
    if (options.verbose)
        tell_run(&stats);
    return EXIT_DONE;
}
