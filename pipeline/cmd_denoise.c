/* SPDX-License-Identifier: Apache-2.0 */
/* fewray denoise: a noisy EXR, ours or another renderer's, to a clean one. */

#include <string.h>

#include "pipeline/clock.h"
#include "pipeline/command.h"
#include "pipeline/interrupt.h"
#include "pipeline/layer_names.h"
#include "pipeline/options.h"
#include "pipeline/outputs.h"
#include "pipeline/progress.h"
#include "pipeline/stats.h"

enum { THREADS_MAX = 1024 };

static const char *const NAMINGS[] = {"auto", "fewray", "mitsuba", "blender",
                                      NULL}; /* as enum layer_naming */
static const char *const ISAS[] = {"auto", "plain", "avx2", "avx512", NULL};

struct denoise_options {
    struct fewray_outputs outputs;
    struct fewray_denoise_options denoise;
    int naming, isa;
};

static enum parse_result parse(struct denoise_options *options, int argc, char **argv,
                               int *first_file) {
    struct fewray_outputs *outputs = &options->outputs;
    const struct option_spec specs[] = {
        {"output", 'o', OPTION_TEXT, &outputs->exr, "OUT.exr",
         "the picture; other channels are kept", 0, 0, NULL},
        {"layers", 0, OPTION_CHOICE, &options->naming, NULL,
         "whose channel names the file has (auto)", 0, 0, NAMINGS},
        {"stats", 0, OPTION_TEXT, &outputs->stats, "STATS.json", "seconds and counts of the run", 0,
         0, NULL},
        {"png", 0, OPTION_TEXT, &outputs->png, "OUT.png", "the picture in sRGB as well", 0, 0,
         NULL},
        {"threads", 0, OPTION_INT, &options->denoise.threads, "N", "all cores if not given", 1,
         THREADS_MAX, NULL},
        {"float", 0, OPTION_FLAG, &outputs->float32, NULL,
         "32-bit floats in the EXR instead of half", 0, 0, NULL},
        {"denoise-weights", 0, OPTION_TEXT, &options->denoise.weights_path, "FILE",
         "another network", 0, 0, NULL},
        {"isa", 0, OPTION_CHOICE, &options->isa, NULL, "highest instruction set to use", 0, 0,
         ISAS},
        {0},
    };
    const struct command_line line = {
        "denoise",
        "IN.exr -o OUT.exr [options]",
        "Filters R, G, B by the albedo, normals, depth and variance that the file has; "
        "what R, G, B were is\nkept as noisy.R, noisy.G, noisy.B.",
        specs,
        1,
        1};
    return parse_command_line(&line, argc, argv, first_file);
}

static void denoise_progress(void *user, double fraction) {
    progress_update(user, "denoise", fraction);
}

/* A file that was denoised before is denoised again from its noisy layer, which the denoiser's
 * input is. */
static void undo_denoising(struct fewray_frame *frame) {
    float *color[3], *noisy[3];
    if (!fewray_frame_layer(frame, FEWRAY_COLOR, color) ||
        !fewray_frame_layer(frame, FEWRAY_NOISY, noisy))
        return;
    for (int c = 0; c < 3; c++)
        memcpy(color[c], noisy[c], sizeof(float) * (size_t)frame->width * (size_t)frame->height);
}

static int denoise_file(const struct denoise_options *options, const char *path,
                        struct fewray_error *error) {
    struct fewray_run_stats stats = {.threads = options->denoise.threads, .spp = 0};
    struct fewray_denoise_stats work = {0};
    struct fewray_frame *frame = NULL;
    struct fewray_denoiser *denoiser = NULL;
    const double start = clock_seconds();
    double lap = start;
    int status;

    if ((status = outputs_check(&options->outputs, error)) ||
        (status = read_picture(path, options->naming, &frame, error)))
        goto done;
    undo_denoising(frame);
    stats.repaired = fewray_frame_repair(frame);
    stats.width = frame->width;
    stats.height = frame->height;
    stats.load_s = clock_lap(&lap);

    if ((status = fewray_denoiser_create(&options->denoise, &denoiser, error)) ||
        (status = fewray_denoise_frame(denoiser, frame, &work, error)))
        goto done;
    stats.tiles = work.tiles;
    stats.tiles_denoised = work.tiles_denoised;
    stats.denoise_s = clock_lap(&lap);

    status = outputs_write(&options->outputs, frame, &stats, start, error);
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
    options.denoise.threads = stats_threads(options.denoise.threads);
    options.denoise.isa = ISAS[options.isa];
    options.denoise.progress = denoise_progress;
    options.denoise.progress_user = &progress;
    options.denoise.cancel = interrupt_watch();
    struct fewray_error error;
    const int status = denoise_file(&options, argv[first_file], &error);
    progress_end(&progress);
    return status ? report_failure(&error) : EXIT_DONE;
}
