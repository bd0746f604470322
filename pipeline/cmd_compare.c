/* SPDX-License-Identifier: Apache-2.0 */
/* fewray compare: the error of a picture against a reference, as lines or JSON. */

#include <jansson.h>
#include <math.h>
#include <stdio.h>

#include "fewray/pipeline.h"
#include "pipeline/command.h"
#include "pipeline/layer_names.h"
#include "pipeline/options.h"

/* JSON has no infinity and no NaN: null. */
static json_t *json_number(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

static int print_metrics(const struct fewray_metrics *m, bool as_json) {
    const struct {
        const char *name;
        double value;
    } rows[] = {
        {"mrse", m->mrse},           {"mrse_trimmed", m->mrse_trimmed},
        {"mrse_top1", m->mrse_top1}, {"mse", m->mse},
        {"mape", m->mape},           {"l1", m->l1},
        {"ssim_loss", m->ssim_loss}, {"flip", m->flip},
        {"psnr", m->psnr},           {"ref_mrse", m->ref_mrse},
        {"mrse_net", m->mrse_net},
    };
    json_t *object = json_object();
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        if (isnan(rows[i].value) && i >= 9) /* a reference without its own noise */
            continue;
        json_object_set_new(object, rows[i].name, json_number(rows[i].value));
        if (!as_json)
            printf("%s: %.6g\n", rows[i].name, rows[i].value);
    }
    json_object_set_new(object, "n_nonfinite", json_integer(m->n_nonfinite));
    json_object_set_new(object, "n_ref_nonfinite", json_integer(m->n_ref_nonfinite));
    if (as_json) {
        json_dumpf(object, stdout, 0);
        putchar('\n');
    } else {
        printf("n_nonfinite: %lld\nn_ref_nonfinite: %lld\n", m->n_nonfinite, m->n_ref_nonfinite);
    }
    json_decref(object);
    return EXIT_DONE;
}

static void print_scores(const struct fewray_block_scores *s, int block) {
    printf("ratio of means, test / reference: %.5f\n", s->ratio_of_means);
    printf(
        "z-scores of %d x %d pixel blocks: count %lld, mean %.3f, deviation %.3f, largest %.2f\n",
        block, block, s->count, s->mean, s->deviation, s->largest);
    printf("|z| > 2: %.2f %% (normal: 4.55 %%), |z| > 3: %.2f %% (normal: 0.27 %%)\n",
           100.0 * (double)s->beyond_2 / (double)s->count,
           100.0 * (double)s->beyond_3 / (double)s->count);
    for (int i = 0; i < FEWRAY_SCORE_BINS; i++)
        printf("z %+d to %+d: %lld\n", i - FEWRAY_SCORE_BINS / 2, i + 1 - FEWRAY_SCORE_BINS / 2,
               s->histogram[i]);
}

int cmd_compare(int argc, char **argv) {
    bool as_json = false;
    int block = 0;
    const struct option_spec specs[] = {
        {"json", 0, OPTION_FLAG, &as_json, NULL, "one JSON object instead of lines", 0, 0, NULL},
        {"blocks", 0, OPTION_INT, &block, "N",
         "instead: z-scores of blocks of N x N pixels, by the reference's standard errors", 1, 4096,
         NULL},
        {0},
    };
    const struct command_line line = {
        "compare",
        "TEST.exr REF.exr [--json | --blocks N]",
        "Prints the error of TEST against REF; lower is better but for psnr.",
        specs,
        2,
        2};
    int first_file;
    const enum parse_result parsed = parse_command_line(&line, argc, argv, &first_file);
    if (parsed != PARSE_OK)
        return parsed == PARSE_HELP ? EXIT_DONE : EXIT_WRONG_COMMAND_LINE;

    struct fewray_frame *test = NULL, *reference = NULL;
    struct fewray_metrics metrics;
    struct fewray_block_scores scores;
    struct fewray_error error;
    int status;
    if (!(status = read_picture(argv[first_file], NAMING_AUTO, &test, &error)) &&
        !(status = read_picture(argv[first_file + 1], NAMING_AUTO, &reference, &error)) &&
        (status = block ? fewray_block_zscores(test, reference, block, &scores, &error)
                        : fewray_compare(test, reference, &metrics, &error)))
        snprintf(error.file, sizeof error.file, "%s", argv[first_file]);
    fewray_frame_destroy(&test);
    fewray_frame_destroy(&reference);
    if (status)
        return report_failure(&error);
    if (block) {
        print_scores(&scores, block);
        return EXIT_DONE;
    }
    return print_metrics(&metrics, as_json);
}
