/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers of frames on the command line and in files' names. */

#include "pipeline/frames.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FRAME_MAX = 9999999, DIGITS_MAX = 9 };

/* A number without sign; *text moves behind it. */
static bool read_number(const char **text, int *out) {
    char *end;
    errno = 0;
    if (!isdigit((unsigned char)**text))
        return false;
    const long value = strtol(*text, &end, 10);
    *text = end;
    *out = (int)value;
    return !errno && value <= FRAME_MAX;
}

bool frames_parse(const char *text, struct fewray_frames *out) {
    struct fewray_frames frames = {.step = 1};
    if (!read_number(&text, &frames.first))
        return false;
    frames.last = frames.first;
    if (!strncmp(text, "..", 2)) {
        text += 2;
        if (!read_number(&text, &frames.last) || frames.last < frames.first)
            return false;
        if (*text == 'x' && (text++, !read_number(&text, &frames.step) || frames.step == 0))
            return false;
    }
    *out = frames;
    return !*text;
}

int frames_count(const struct fewray_frames *frames) {
    return (frames->last - frames->first) / frames->step + 1;
}

/* The place of the number: *length characters, and how many digits are asked for. NULL: there is
 * none, or there are several. */
static const char *find_place(const char *pattern, size_t *length, int *digits) {
    const char *found = NULL;
    for (const char *c = pattern; *c;) {
        size_t size = strspn(c, "#");
        int width = (int)size;
        if (!size && *c == '%') {
            const char *d = c + 1;
            width = 0;
            while (isdigit((unsigned char)*d) && width <= DIGITS_MAX)
                width = 10 * width + (*d++ - '0');
            size = *d == 'd' ? (size_t)(d + 1 - c) : 0;
        }
        if (size && (found || width > DIGITS_MAX))
            return NULL;
        if (size) {
            found = c;
            *length = size;
            *digits = width;
        }
        c += size ? size : 1;
    }
    return found;
}

bool frames_name_has_place(const char *pattern) {
    size_t length;
    int digits;
    return find_place(pattern, &length, &digits) != NULL;
}

char *frames_name(const char *pattern, int frame) {
    size_t length = 0;
    int digits = 0;
    const char *place = find_place(pattern, &length, &digits);
    if (!place)
        return strdup(pattern);
    const size_t size = strlen(pattern) + DIGITS_MAX + 2;
    char *name = malloc(size);
    if (name)
        snprintf(name, size, "%.*s%0*d%s", (int)(place - pattern), pattern, digits, frame,
                 place + length);
    return name;
}
