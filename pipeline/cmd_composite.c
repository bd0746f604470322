/* SPDX-License-Identifier: Apache-2.0 */
/* fewray composite: before and after in one PNG. */

#include <stdio.h>

#include "fewray/pipeline.h"
#include "pipeline/command.h"
#include "pipeline/layer_names.h"
#include "pipeline/options.h"
#include "pipeline/outputs.h"
#include "pipeline/stats.h"

struct composite_options {
    struct fewray_composite_options draw;
    struct fewray_outputs outputs;
    const char *stats_path;
    char caption[512]; /* with what the stats say */
    struct text_list crops;
};

static enum parse_result parse(struct composite_options *options, int argc, char **argv,
                               int *first_file) {
    const struct option_spec specs[] = {
        {"output", 'o', OPTION_TEXT, &options->outputs.png, "OUT.png", "the picture", 0, 0, NULL},
        {"crop", 0, OPTION_LIST, &options->crops, "X,Y,W,H",
         "magnify this place; up to three times", 0, 0, NULL},
        {"caption", 0, OPTION_TEXT, &options->draw.caption, "TEXT", "a line below the pictures", 0,
         0, NULL},
        {"stats", 0, OPTION_TEXT, &options->stats_path, "STATS.json",
         "of the render: its spp and seconds join the caption", 0, 0, NULL},
        {"exposure", 0, OPTION_FLOAT, &options->draw.exposure, "STOPS", "brighter or darker (0)",
         -32, 32, NULL},
        {0},
    };
    const struct command_line line = {"composite",
                                      "NOISY.exr DENOISED.exr [REF.exr] -o OUT.png [options]",
                                      "Draws noisy | denoised | reference, magnified crops and "
                                      "error heat maps. A NOISY.exr with noisy.R, noisy.G,\n"
                                      "noisy.B is shown by them, so that one file can be both.",
                                      specs,
                                      2,
                                      3};
    return parse_command_line(&line, argc, argv, first_file);
}

static int parse_crops(struct composite_options *options) {
    if (options->crops.count > FEWRAY_CROPS)
        return report_usage("composite: --crop can be given %d times at most", FEWRAY_CROPS);
    for (int i = 0; i < options->crops.count; i++) {
        struct fewray_crop *crop = &options->draw.crops[i];
        char tail;
        const char *text = options->crops.items[i];
        if (sscanf(text, "%7d,%7d,%7d,%7d%c", &crop->x, &crop->y, &crop->width, &crop->height,
                   &tail) != 4 ||
            crop->x < 0 || crop->y < 0 || crop->width < 1 || crop->height < 1)
            return report_usage(
                "composite: --crop can't be '%s'; it takes X,Y,WIDTH,HEIGHT in pixels", text);
    }
    options->draw.crop_count = options->crops.count;
    return EXIT_DONE;
}

static int composite_files(struct composite_options *options, int count, char **paths,
                           struct fewray_error *error) {
    struct fewray_frame *frames[3] = {NULL};
    char summary[256];
    int status = outputs_check(&options->outputs, error);
    if (!status && options->stats_path) {
        status = stats_read_summary(options->stats_path, summary, sizeof summary, error);
        snprintf(options->caption, sizeof options->caption, "%s%s%s",
                 options->draw.caption ? options->draw.caption : "",
                 options->draw.caption ? ": " : "", summary);
        options->draw.caption = options->caption;
    }
    for (int i = 0; i < count && !status; i++)
        status = read_picture(paths[i], NAMING_AUTO, &frames[i], error);
    if (!status)
        status = fewray_composite(frames[0], frames[1], frames[2], &options->draw,
                                  options->outputs.png, error);
    for (int i = 0; i < 3; i++)
        fewray_frame_destroy(&frames[i]);
    return status;
}

int cmd_composite(int argc, char **argv) {
    struct composite_options options = {0};
    int first_file;
    const enum parse_result parsed = parse(&options, argc, argv, &first_file);
    if (parsed != PARSE_OK)
        return parsed == PARSE_HELP ? EXIT_DONE : EXIT_WRONG_COMMAND_LINE;
    if (!options.outputs.png)
        return report_usage("composite: no output; give -o OUT.png");
    const int code = parse_crops(&options);
    if (code)
        return code;
    struct fewray_error error;
    return composite_files(&options, argc - first_file, argv + first_file, &error)
               ? report_failure(&error)
               : EXIT_DONE;
}
