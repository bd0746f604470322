/* SPDX-License-Identifier: Apache-2.0 */
/* fewray report: the pictures of a folder as one HTML page. */

#include "pipeline/command.h"
#include "pipeline/options.h"
#include "pipeline/page/page.h"

int cmd_report(int argc, char **argv) {
    struct page_options options = {.max_width = 1920};
    const struct option_spec specs[] = {
        {"output", 'o', OPTION_TEXT, &options.output, "FILE.html", "the page (DIR/report.html)", 0,
         0, NULL},
        {"reference", 'r', OPTION_TEXT, &options.reference, "REF.exr",
         "what the others are judged by (DIR/reference.exr, where it is there)", 0, 0, NULL},
        {"title", 0, OPTION_TEXT, &options.title, "TEXT", "else the folder's name", 0, 0, NULL},
        {"exposure", 0, OPTION_FLOAT, &options.exposure, "STOPS", "brighter or darker (0)", -32, 32,
         NULL},
        {"max-width", 0, OPTION_INT, &options.max_width, "N",
         "show pictures of more pixels smaller (1920)", 16, 16384, NULL},
        {0},
    };
    const struct command_line line = {
        "report",
        "DIR [-o FILE.html] [options]",
        "Makes one HTML page, which needs no network, of the EXRs in DIR: a divider between any "
        "two of\nthem and, against the reference, error maps and metrics. NAME.json is taken for "
        "the --stats of\nNAME.exr; bench.json, which `fewray bench` leaves, gives curves. A "
        "picture with noisy.R, noisy.G,\nnoisy.B is shown before and after the denoiser.",
        specs,
        1,
        1};
    int first_file;
    const enum parse_result parsed = parse_command_line(&line, argc, argv, &first_file);
    if (parsed != PARSE_OK)
        return parsed == PARSE_HELP ? EXIT_DONE : EXIT_WRONG_COMMAND_LINE;
    if (options.output && !options.output[0])
        return report_usage("report: -o has no name");
    options.folder = argv[first_file];
    struct fewray_error error;
    return page_write(&options, &error) ? report_failure(&error) : EXIT_DONE;
}
