/* SPDX-License-Identifier: Apache-2.0 */
/* The `fewray` command: finds the subcommand and hands over. */

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "pipeline/command.h"
#include "pipeline/interrupt.h"

static const struct {
    const char *name, *about;
    int (*run)(int argc, char **argv);
} COMMANDS[] = {
#if FEWRAY_RENDERER
    {"render", "scene to picture: guided, denoised", cmd_render},
    {"merge", "parts of a picture, rendered by many machines, to the picture", cmd_merge},
#endif
    {"denoise", "noisy EXR to clean EXR", cmd_denoise},
#if FEWRAY_RENDERER
    {"compare", "error of a picture against a reference", cmd_compare},
    {"composite", "before/after PNG with error maps and crops", cmd_composite},
    {"bench", "error against time: table, CSV, JSON, plot", cmd_bench},
    {"report", "the pictures of a folder as one HTML page", cmd_report},
#endif
    {"info", "what a scene or an EXR holds", cmd_info},
};
enum { COMMAND_COUNT = sizeof COMMANDS / sizeof *COMMANDS };

static void print_help(void) {
    puts("usage: fewray COMMAND ...\n\n"
         "Turns a few paths per pixel into a finished picture: a guided path tracer and a\n"
         "kernel-predicting denoiser.\n\ncommands:");
    for (int i = 0; i < COMMAND_COUNT; i++)
        printf("  %-12s %s\n", COMMANDS[i].name, COMMANDS[i].about);
    puts("\n`fewray COMMAND --help` tells the options. Exit codes: 0 done, 1 the work failed,\n"
         "2 the command line is wrong.");
}

/* All that the commands know of themselves (options.h), behind a line for each: about NAME TEXT. */
static int print_table(void) {
    printf("version\t%s\n", FEWRAY_VERSION);
    for (int i = 0; i < COMMAND_COUNT; i++)
        printf("about\t%s\t%s\n", COMMANDS[i].name, COMMANDS[i].about);
    int code = EXIT_DONE;
    for (int i = 0; i < COMMAND_COUNT && code == EXIT_DONE; i++) {
        char *argv[] = {(char *)COMMANDS[i].name, (char *)"--help=table", NULL};
        code = COMMANDS[i].run(2, argv);
    }
    return code;
}

static int dispatch(int argc, char **argv) {
    if (argc < 2)
        return report_usage("give a command; `fewray --help` lists them");
    if (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h")) {
        print_help();
        return EXIT_DONE;
    }
    if (!strcmp(argv[1], "--help=table"))
        return print_table();
    if (!strcmp(argv[1], "--version")) {
        puts("fewray " FEWRAY_VERSION);
        return EXIT_DONE;
    }
    for (int i = 0; i < COMMAND_COUNT; i++)
        if (!strcmp(argv[1], COMMANDS[i].name))
            return COMMANDS[i].run(argc - 1, argv + 1);
    return report_usage("there is no command '%s'; `fewray --help` lists them", argv[1]);
}

int main(int argc, char **argv) {
    interrupt_start();
    const int code = dispatch(argc, argv);
    if (fflush(stdout) && code == EXIT_DONE) {
        struct fewray_error error;
        fewray_fail(&error, FEWRAY_ERROR_IO, "stdout", 0, "can't be written: %s", strerror(errno));
        return report_failure(&error);
    }
    return code;
}
