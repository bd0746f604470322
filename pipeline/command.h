/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_COMMAND_H
#define FEWRAY_PIPELINE_COMMAND_H

/* What the subcommands of `fewray` share: exit codes and the one line that an error is. */

#include "fewray/features.h"

enum exit_code { EXIT_DONE = 0, EXIT_FAILED = 1, EXIT_WRONG_COMMAND_LINE = 2 };

/* Of --lenient, which several have. */
#define LENIENT_HELP "draw BSDFs that aren't supported diffuse, leave such lights and media out"

/* Each takes the arguments after `fewray`, its own name first, and returns an exit code. */
int cmd_render(int argc, char **argv);
int cmd_denoise(int argc, char **argv);
int cmd_compare(int argc, char **argv);
int cmd_composite(int argc, char **argv);
int cmd_bench(int argc, char **argv);
int cmd_report(int argc, char **argv);
int cmd_info(int argc, char **argv);
int cmd_merge(int argc, char **argv);

/* Prints `fewray: FILE:LINE: what` on stderr; returns EXIT_FAILED. */
int report_failure(const struct fewray_error *error);
/* Prints `fewray: ...` on stderr as one line; returns EXIT_WRONG_COMMAND_LINE. */
int report_usage(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* Prints `fewray: text`, news of a run that goes on. */
void report_note(const char *text);
/* Prints `fewray: warning: text`; user is ignored. */
void report_warning(void *user, const char *text);

#endif
