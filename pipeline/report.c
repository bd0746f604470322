/* SPDX-License-Identifier: Apache-2.0 */
/* Errors and warnings of the command: one line each on stderr. */

#include "pipeline/command.h"

#include <stdarg.h>
#include <stdio.h>

#include "pipeline/ranks.h"

/* A file name or a value from the command line may hold anything; a line of ours stays one line. */
static void print_line(const char *prefix, char *text) {
    if (ranks_is_silent())
        return;
    for (char *c = text; *c; c++)
        if ((unsigned char)*c < ' ')
            *c = ' ';
    fprintf(stderr, "fewray: %s%s\n", prefix, text);
}

int report_failure(const struct fewray_error *error) {
    char text[1200];
    fewray_error_text(error, text, sizeof text);
    print_line("", text);
    return EXIT_FAILED;
}

int report_usage(const char *format, ...) {
    char text[1200];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    print_line("", text);
    return EXIT_WRONG_COMMAND_LINE;
}

void report_note(const char *note) {
    char text[1200];
    snprintf(text, sizeof text, "%s", note);
    print_line("", text);
}

void report_warning(void *user, const char *warning) {
    (void)user;
    char text[1200];
    snprintf(text, sizeof text, "%s", warning);
    print_line("warning: ", text);
}
