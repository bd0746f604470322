/* SPDX-License-Identifier: Apache-2.0 */
/* What Linux tells of the machine and of this process. */

#include "pipeline/origin.h"

#include <stdio.h>
#include <string.h>

void origin_cpu(char *name, size_t size) {
    char line[256];
    FILE *file = fopen("/proc/cpuinfo", "r");
    snprintf(name, size, "unknown CPU");
    while (file && fgets(line, sizeof line, file)) {
        const char *value = strchr(line, ':');
        if (strncmp(line, "model name", 10) || !value)
            continue;
        snprintf(name, size, "%.*s", (int)strcspn(value + 2, "\n"), value + 2);
        break;
    }
    if (file)
        fclose(file);
}

/* Appends one character; false where there is no room for it and the end. */
static bool put(char *text, size_t size, size_t *length, char c) {
    if (*length + 1 >= size)
        return false;
    text[(*length)++] = c;
    text[*length] = 0;
    return true;
}

static bool is_plain(const char *word) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                "_-./=,:+@%";
    return word[0] && word[strspn(word, plain)] == 0;
}

static bool put_word(char *text, size_t size, size_t *length, const char *word) {
    const bool quoted = !is_plain(word);
    bool fits = !quoted || put(text, size, length, '\'');
    for (const char *c = word; *c && fits; c++)
        if (*c == '\'') /* ends the quotes, stands by itself, begins them again */
            for (const char *end = "'\\''"; *end && fits; end++)
                fits = put(text, size, length, *end);
        else
            fits = put(text, size, length, *c);
    return fits && (!quoted || put(text, size, length, '\''));
}

bool origin_command(char *text, size_t size) {
    char words[8192];
    FILE *file = fopen("/proc/self/cmdline", "r");
    const size_t bytes = file ? fread(words, 1, sizeof words - 1, file) : 0;
    if (file)
        fclose(file);
    if (bytes == 0 || bytes == sizeof words - 1)
        return false;
    words[bytes] = 0;
    const char *slash = strrchr(words, '/'); /* in the first word alone: a 0 ends it */
    const char *word = slash ? slash + 1 : words;
    bool fits = true;
    size_t length = 0;
    while (fits && word < words + bytes) {
        fits =
            (length == 0 || put(text, size, &length, ' ')) && put_word(text, size, &length, word);
        word += strlen(word) + 1;
    }
    return fits && length > 0;
}
