/* SPDX-License-Identifier: Apache-2.0 */
/* fewray merge */

#include <stdio.h>

#include "fewray/pipeline.h"
#include "pipeline/command.h"
#include "pipeline/denoiser_options.h"
#include "pipeline/interrupt.h"
#include "pipeline/options.h"
#include "pipeline/outputs.h"
#include "pipeline/progress.h"
#include "pipeline/stats.h"

enum { PARTS_MAX = 65536, THREADS_MAX = 1024 };

static const char *const SWITCH[] = {"off", "on", NULL};

struct merge_options {
    struct fewray_merge_job job;
    int denoise, isa, model;
    bool verbose;
};

static enum parse_result parse(struct merge_options *options, int argc, char **argv,
                               int *first_file) {
    struct fewray_merge_job *job = &options->job;
    const struct option_spec specs[] = {
        {"output", 'o', OPTION_TEXT, &job->outputs.exr, "OUT.exr", "the picture and its layers", 0,
         0, NULL},
        {"partial", 0, OPTION_FLAG, &job->partial, NULL,
         "merge what is there, parts may be missing", 0, 0, NULL},
        {"denoise", 0, OPTION_CHOICE, &options->denoise, NULL, "filter the picture (on)", 0, 0,
         SWITCH},
        {"threads", 0, OPTION_INT, &job->threads, "N", "all cores if not given", 1, THREADS_MAX,
         NULL},
        {"stats", 0, OPTION_TEXT, &job->outputs.stats, "STATS.json",
         "seconds and counts of the run", 0, 0, NULL},
        {"png", 0, OPTION_TEXT, &job->outputs.png, "OUT.png", "the picture in sRGB as well", 0, 0,
         NULL},
        {"float", 0, OPTION_FLAG, &job->outputs.float32, NULL,
         "32-bit floats in the EXR instead of half", 0, 0, NULL},
        DENOISER_OPTIONS(&job->denoise, &options->model, &options->isa),
        {"verbose", 'v', OPTION_FLAG, &options->verbose, NULL, "tell what was done", 0, 0, NULL},
        {0},
    };
    const struct command_line line = {
        "merge",
        "PART.exr... -o OUT.exr [options]",
        "Makes the picture of the parts that `fewray render --part` wrote, weighted by their "
        "samples,\nand filters it.",
        specs,
        1,
        PARTS_MAX};
    return parse_command_line(&line, argc, argv, first_file);
}

int cmd_merge(int argc, char **argv) {
    struct merge_options options = {.denoise = 1};
    struct fewray_merge_job *job = &options.job;
    fewray_merge_job_init(job);
    int first_file;
    const enum parse_result parsed = parse(&options, argc, argv, &first_file);
    if (parsed != PARSE_OK)
        return parsed == PARSE_HELP ? EXIT_DONE : EXIT_WRONG_COMMAND_LINE;
    if (!job->outputs.exr)
        return report_usage("merge: no output; give -o OUT.exr");
    if (outputs_clash(&job->outputs))
        return report_usage("merge: two outputs have the same name; give each its own");

    struct progress progress;
    progress_start(&progress);
    job->paths = (const char *const *)argv + first_file;
    job->count = argc - first_file;
    job->denoised = options.denoise;
    job->denoise.isa = ISAS[options.isa];
    job->denoise.model = (enum fewray_denoise_model)options.model;
    job->progress = progress_update_phase;
    job->progress_user = &progress;
    job->cancel = interrupt_watch();
    struct fewray_run_stats stats;
    struct fewray_error error;
    const int status = fewray_merge_run(job, NULL, &stats, &error);
    progress_end(&progress);
    if (status)
        return report_failure(&error);
    char warning[160];
    if (stats_half_warning(&stats, warning, sizeof warning))
        report_warning(NULL, warning);
    if (options.verbose)
        fprintf(stderr, "%dx%d, %d parts, %d spp: merge %.2f s, denoise %.2f s, write %.2f s\n",
                stats.width, stats.height, job->count, stats.spp, stats.load_s, stats.denoise_s,
                stats.write_s);
    return EXIT_DONE;
}
