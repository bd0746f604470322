/* SPDX-License-Identifier: Apache-2.0 */
/* fewray bench: error against time as CSV, JSON, plot and table. */

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "pipeline/bench.h"
#include "pipeline/command.h"
#include "pipeline/interrupt.h"
#include "pipeline/options.h"
#include "pipeline/outputs.h"
#include "pipeline/progress.h"

enum { SEEDS_MAX = 1000, SPP_MOST = 65536, THREADS_MAX = 1024, DEPTH_MAX = 65536 };

struct bench_options {
    struct bench_settings settings;
    struct text_list defines;
    struct name_list spp;
    const char *folder, *python;
    int max_depth;
    bool peers;
};

static enum parse_result parse(struct bench_options *options, int argc, char **argv,
                               int *first_file) {
    struct bench_settings *settings = &options->settings;
    const struct option_spec specs[] = {
        {"reference", 'r', OPTION_TEXT, &settings->reference_path, "REF.exr",
         "the picture without noise; its size is the bench's", 0, 0, NULL},
        {"output", 'o', OPTION_TEXT, &options->folder, "DIR",
         "gets bench.csv, bench.json and bench.png", 0, 0, NULL},
        {"spp", 0, OPTION_NAMES, &options->spp, "N[,N...]", "samples a pixel (1,2,4,8,16,32,64)", 0,
         0, NULL},
        {"seeds", 0, OPTION_INT, &settings->seeds, "N", "pictures of each kind (3)", 1, SEEDS_MAX,
         NULL},
        {"keep-pictures", 0, OPTION_INT, &settings->keep_spp, "N",
         "leave the first seed's pictures of N samples a pixel in DIR, for `fewray report`", 1,
         SPP_MOST, NULL},
        {"peers", 0, OPTION_FLAG, &options->peers, NULL,
         "add Mitsuba 3 and Open Image Denoise, where Python has them", 0, 0, NULL},
        {"python", 0, OPTION_TEXT, &options->python, "FILE",
         "for --peers; else that of $FEWRAY_PYTHON, else python3", 0, 0, NULL},
        {"max-depth", 0, OPTION_INT, &options->max_depth, "D",
         "path length, 1 = emission only, -1 = no limit; else the scene's own", -1, DEPTH_MAX,
         NULL},
        {"threads", 0, OPTION_INT, &settings->render.threads, "N", "all cores if not given", 1,
         THREADS_MAX, NULL},
        {"define", 'D', OPTION_DEFINE, &options->defines, "NAME=VALUE", "for $NAME in the scene", 0,
         0, NULL},
        {"lenient", 0, OPTION_FLAG, &settings->scene.lenient, NULL, LENIENT_HELP, 0, 0, NULL},
        {0},
    };
    const struct command_line line = {
        "bench",
        "SCENE --reference REF.exr -o DIR [options]",
        "Measures error against time: path traced, guided, denoised, and both.",
        specs,
        1,
        1};
    return parse_command_line(&line, argc, argv, first_file);
}

static int compare_ints(const void *a, const void *b) {
    const int x = *(const int *)a, y = *(const int *)b;
    return (x > y) - (x < y);
}

/* The list of samples a pixel, ascending. Returns an exit code. */
static int set_spp(const struct name_list *names, struct bench_settings *settings) {
    if (names->count > BENCH_SPP_MAX)
        return report_usage("bench: --spp takes at most %d numbers", BENCH_SPP_MAX);
    for (int i = 0; i < names->count; i++) {
        char *end;
        const long value = strtol(names->names[i], &end, 10);
        if (*end || value < 1 || value > SPP_MOST)
            return report_usage("bench: --spp can't have '%s'; it takes numbers of 1..%d",
                                names->names[i], SPP_MOST);
        settings->spp[settings->spp_count++] = (int)value;
    }
    for (int spp = 1; names->count == 0 && spp <= 64; spp *= 2)
        settings->spp[settings->spp_count++] = spp;
    qsort(settings->spp, (size_t)settings->spp_count, sizeof *settings->spp, compare_ints);
    for (int i = 1; i < settings->spp_count; i++)
        if (settings->spp[i] == settings->spp[i - 1])
            return report_usage("bench: --spp has %d twice", settings->spp[i]);
    return EXIT_DONE;
}

/* Returns an exit code. */
static int check_keep(const struct bench_settings *settings) {
    for (int i = 0; i < settings->spp_count; i++)
        if (settings->keep_spp == settings->spp[i])
            return EXIT_DONE;
    return settings->keep_spp == 0
               ? EXIT_DONE
               : report_usage("bench: --keep-pictures %d isn't one of the bench's samples a pixel",
                              settings->keep_spp);
}

/* Returns an exit code. */
static int check(struct bench_options *options) {
    if (!options->settings.reference_path)
        return report_usage("bench: no reference; give --reference REF.exr");
    if (!options->folder)
        return report_usage("bench: no folder for the results; give -o DIR");
    if (options->max_depth == 0)
        return report_usage("bench: --max-depth can't be 0; it takes -1 or 1..%d", DEPTH_MAX);
    const int code = set_spp(&options->spp, &options->settings);
    return code ? code : check_keep(&options->settings);
}

static const char *choose_python(const struct bench_options *options) {
    const char *named = getenv("FEWRAY_PYTHON");
    if (!options->peers)
        return NULL;
    if (options->python)
        return options->python;
    return named && *named ? named : "python3";
}

struct bench_paths {
    char csv[1024], json[1024], png[1024];
};

/* Makes the folder, where it isn't there yet, and tries whether the files can be written. */
static int prepare_folder(const char *folder, struct bench_paths *paths,
                          struct fewray_error *error) {
    if (strlen(folder) > sizeof paths->csv - sizeof "/bench.json")
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, folder, 0,
                           "the folder's name is too long");
    if (mkdir(folder, 0777) && errno != EEXIST)
        return fewray_fail(error, FEWRAY_ERROR_IO, folder, 0, "the folder can't be made: %s",
                           strerror(errno));
    snprintf(paths->csv, sizeof paths->csv, "%s/bench.csv", folder);
    snprintf(paths->json, sizeof paths->json, "%s/bench.json", folder);
    snprintf(paths->png, sizeof paths->png, "%s/bench.png", folder);
    const struct fewray_outputs outputs = {
        .exr = paths->csv, .png = paths->png, .stats = paths->json};
    return outputs_check(&outputs, error);
}

static int write_all(const struct bench *bench, const struct bench_paths *paths,
                     struct fewray_error *error) {
    int status = bench_write_csv(bench, paths->csv, error);
    if (!status)
        status = bench_write_json(bench, paths->json, error);
    if (!status)
        status = bench_plot(bench, paths->png, error);
    return status;
}

/* Warnings come amid the work. */
static void warn_below_bar(void *user, const char *text) {
    progress_end(user);
    report_warning(NULL, text);
}

/* Runs, and writes also what an interrupted or failed run has done. */
static int run(const struct bench_settings *settings, const struct bench_paths *paths,
               struct progress *progress, struct fewray_error *error) {
    struct bench bench;
    struct fewray_error other;
    int status = bench_run(settings, &bench, error);
    progress_end(progress);
    bench_summarize(&bench);
    int written = FEWRAY_OK;
    if (bench.row_count > 0) {
        written = write_all(&bench, paths, status ? &other : error);
        bench_print(&bench);
    }
    if (status == FEWRAY_ERROR_CANCELLED)
        fewray_fail(error, FEWRAY_ERROR_CANCELLED, settings->scene_path, 0, "interrupted; %s",
                    bench.row_count == 0 ? "nothing was done yet, so nothing is written"
                    : written            ? "what was done couldn't be written"
                                         : "what was done is written");
    else if (!status)
        status = written;
    bench_destroy(&bench);
    return status;
}

int cmd_bench(int argc, char **argv) {
    enum { DEPTH_NOT_GIVEN = -2 };
    struct bench_options options = {.max_depth = DEPTH_NOT_GIVEN};
    struct bench_settings *settings = &options.settings;
    fewray_render_settings_init(&settings->render);
    settings->seeds = 3;
    int first_file;
    const enum parse_result parsed = parse(&options, argc, argv, &first_file);
    if (parsed != PARSE_OK)
        return parsed == PARSE_HELP ? EXIT_DONE : EXIT_WRONG_COMMAND_LINE;
    const int code = check(&options);
    if (code)
        return code;

    struct progress progress;
    struct bench_paths paths;
    struct fewray_error error;
    int status = prepare_folder(options.folder, &paths, &error);
    if (status)
        return report_failure(&error);
    progress_start(&progress);
    settings->scene_path = argv[first_file];
    settings->keep_folder = options.folder;
    settings->scene.defines = options.defines.items;
    settings->scene.define_count = options.defines.count;
    settings->render.max_depth = options.max_depth == DEPTH_NOT_GIVEN ? 0 : options.max_depth;
    settings->render.progress = progress_update_phase;
    settings->render.progress_user = &progress;
    settings->render.cancel = interrupt_watch();
    settings->python = choose_python(&options);
    settings->warn = warn_below_bar;
    settings->warn_user = &progress;
    status = run(settings, &paths, &progress, &error);
    return status ? report_failure(&error) : EXIT_DONE;
}
