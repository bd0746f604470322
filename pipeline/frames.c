/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers of frames on the command line and in files' names. */

#include "pipeline/frames.h"

#include <ctype.h>
#include <dirent.h>
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

/* --- files that are there */

static int by_number(const void *a, const void *b) {
    const int x = *(const int *)a, y = *(const int *)b;
    return (x > y) - (x < y);
}

/* The number in a file's name, or -1. */
static int number_of(const char *pattern, const char *name) {
    size_t length;
    int digits, number;
    const char *place = find_place(pattern, &length, &digits);
    const size_t before = (size_t)(place - pattern);
    if (strncmp(pattern, name, before))
        return -1;
    const char *text = name + before;
    if (!read_number(&text, &number) || strcmp(text, place + length))
        return -1;
    char *again = frames_name(pattern, number); /* 7 isn't 0007 */
    const bool same = again && !strcmp(again, name);
    free(again);
    return same ? number : -1;
}

int frames_find(const char *pattern, int **numbers, int *count, struct fewray_error *error) {
    const char *slash = strrchr(pattern, '/');
    const char *file = slash ? slash + 1 : pattern;
    char *folder = slash ? strndup(pattern, (size_t)(file - pattern)) : strdup(".");
    int room = 0, status = FEWRAY_OK;
    *numbers = NULL;
    *count = 0;
    if (!frames_name_has_place(file)) {
        free(folder);
        return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, pattern, 0,
                           "the file's name has no one place for the frame's number");
    }
    DIR *files = folder ? opendir(folder) : NULL;
    if (!files)
        status = fewray_fail(error, FEWRAY_ERROR_IO, pattern, 0, "can't look into the folder: %s",
                             folder ? strerror(errno) : "out of memory");
    for (struct dirent *entry; !status && (entry = readdir(files));) {
        const int number = number_of(file, entry->d_name);
        if (number < 0)
            continue;
        if (*count == room) {
            room = room ? 2 * room : 64;
            int *more = realloc(*numbers, (size_t)room * sizeof **numbers);
            if (!more) {
                status = fewray_fail(error, FEWRAY_ERROR_MEMORY, pattern, 0, "out of memory");
                break;
            }
            *numbers = more;
        }
        (*numbers)[(*count)++] = number;
    }
    if (*count)
        qsort(*numbers, (size_t)*count, sizeof **numbers, by_number);
    if (files)
        closedir(files);
    free(folder);
    return status;
}
