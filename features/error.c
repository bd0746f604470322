/* SPDX-License-Identifier: Apache-2.0 */
/* Errors: one line of text with the place where it happened. */
#include "fewray/features.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Messages hold names and words from files: nothing in them may start another line. */
static void flatten(char *text) {
    size_t length = strlen(text);
    for (size_t i = 0; i < length; i++)
        if ((unsigned char)text[i] < ' ' || text[i] == 127)
            text[i] = ' ';
    while (length > 0 && text[length - 1] == ' ')
        text[--length] = '\0';
}

int fewray_fail(struct fewray_error *error, enum fewray_status status, const char *file, int line,
                const char *format, ...) {
    if (!error)
        return status;
    error->file[0] = '\0';
    if (file)
        snprintf(error->file, sizeof error->file, "%s", file);
    error->line = line;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->what, sizeof error->what, format, arguments);
    va_end(arguments);
    flatten(error->file);
    flatten(error->what);
    return status;
}

const char *fewray_error_text(const struct fewray_error *error, char *text, size_t size) {
    if (!error->file[0])
        snprintf(text, size, "%s", error->what);
    else if (error->line > 0)
        snprintf(text, size, "%s:%d: %s", error->file, error->line, error->what);
    else
        snprintf(text, size, "%s: %s", error->file, error->what);
    return text;
}
