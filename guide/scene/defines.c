/* SPDX-License-Identifier: Apache-2.0 */
/* Values for $name: the caller's, then the file's <default>s. */

#include "guide/scene/defines.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "guide/scene/memory.h"

/* <default>s of <default>s double at each level, as XML's entities do. */
#define MAX_EXPANDED (16 << 20)

static bool is_name_character(char c) {
    return isalnum((unsigned char)c) || c == '_' || c == '-';
}

static struct define *find(const struct defines *defines, const char *name, size_t length) {
    for (size_t i = 0; i < defines->count; i++)
        if (strlen(defines->items[i].name) == length &&
            !memcmp(defines->items[i].name, name, length))
            return &defines->items[i];
    return NULL;
}

static bool append(struct defines *defines, const char *name, size_t length, const char *value,
                   bool from_caller) {
    if (!array_reserve((void **)&defines->items, &defines->capacity, defines->count + 1,
                       sizeof(*defines->items)))
        return false;
    struct define item = {blocks_copy(&defines->blocks, name, length),
                          blocks_copy(&defines->blocks, value, strlen(value)), from_caller, false};
    if (!item.name || !item.value)
        return false;
    defines->items[defines->count++] = item;
    return true;
}

int defines_init(struct defines *defines, const char *const *pairs, int count,
                 struct fewray_error *error) {
    for (int i = 0; i < count; i++) {
        const char *equals = strchr(pairs[i], '=');
        if (!equals || equals == pairs[i])
            return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0,
                               "-D %s: write it as name=value", pairs[i]);
        size_t length = (size_t)(equals - pairs[i]);
        if (find(defines, pairs[i], length))
            return fewray_fail(error, FEWRAY_ERROR_ARGUMENT, NULL, 0, "-D %.*s is given twice",
                               (int)length, pairs[i]);
        if (!append(defines, pairs[i], length, equals + 1, true))
            return fewray_fail(error, FEWRAY_ERROR_MEMORY, NULL, 0, "out of memory");
    }
    return FEWRAY_OK;
}

void defines_free(struct defines *defines) {
    free(defines->items);
    blocks_free(&defines->blocks);
}

bool defines_add_default(struct defines *defines, const char *name, const char *value) {
    return find(defines, name, strlen(name)) || append(defines, name, strlen(name), value, false);
}

/* The define whose name stands at text; the longest where several do ("$spp" and "$spp_final"). */
static struct define *match(const struct defines *defines, const char *text) {
    struct define *best = NULL;
    for (size_t i = 0; i < defines->count; i++) {
        struct define *item = &defines->items[i];
        size_t length = strlen(item->name);
        if (!strncmp(text, item->name, length) && (!best || length > strlen(best->name)))
            best = item;
    }
    return best;
}

/* Writes the expansion to out (NULL: only measures). Returns its length, or -1 with *unknown at the
 * name. */
static long expand_into(struct defines *defines, const char *text, char *out,
                        const char **unknown) {
    long length = 0;
    while (*text) {
        if (*text != '$') {
            if (out)
                out[length] = *text;
            length++;
            text++;
            continue;
        }
        struct define *item = match(defines, text + 1);
        if (!item) {
            *unknown = text + 1;
            return -1;
        }
        item->used = true;
        size_t value_length = strlen(item->value);
        if (out)
            memcpy(out + length, item->value, value_length);
        length += (long)value_length;
        text += 1 + strlen(item->name);
    }
    return length;
}

char *defines_expand(struct defines *defines, const char *text, void **blocks, const char *file,
                     int line, struct fewray_error *error) {
    const char *unknown = NULL;
    long length = expand_into(defines, text, NULL, &unknown);
    if (length < 0) {
        int name_length = 0;
        while (is_name_character(unknown[name_length]))
            name_length++;
        fewray_fail(error, FEWRAY_ERROR_FORMAT, file, line,
                    "$%.*s is not defined: add a <default> or give -D %.*s=VALUE", name_length,
                    unknown, name_length, unknown);
        return NULL;
    }
    if (strchr(text, '$'))
        defines->expanded += (size_t)length;
    if (defines->expanded > MAX_EXPANDED) {
        fewray_fail(error, FEWRAY_ERROR_FORMAT, file, line,
                    "the values of its $names are longer than %d MiB together", MAX_EXPANDED >> 20);
        return NULL;
    }
    char *out = blocks_allocate(blocks, (size_t)length + 1);
    if (!out) {
        fewray_fail(error, FEWRAY_ERROR_MEMORY, file, line, "out of memory");
        return NULL;
    }
    expand_into(defines, text, out, &unknown);
    return out;
}

const char *defines_unused(const struct defines *defines) {
    for (size_t i = 0; i < defines->count; i++)
        if (defines->items[i].from_caller && !defines->items[i].used)
            return defines->items[i].name;
    return NULL;
}

bool defines_default_used(const struct defines *defines, const char *name) {
    const struct define *item = find(defines, name, strlen(name));
    return item && item->used && !item->from_caller;
}
