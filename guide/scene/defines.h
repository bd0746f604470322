/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_DEFINES_H
#define FEWRAY_GUIDE_SCENE_DEFINES_H

/* Values for $name: the caller's, then the file's <default>s. */

#include <stdbool.h>
#include <stddef.h>

#include "fewray/features.h"

struct define {
    char *name, *value;
    bool from_caller, used;
};

struct defines {
    struct define *items;
    size_t count, capacity;
    void *blocks;
    size_t expanded; /* bytes of all that defines_expand() made of texts with a $name */
};

/* Takes "name=value" pairs. */
int defines_init(struct defines *defines, const char *const *pairs, int count,
                 struct fewray_error *error);
void defines_free(struct defines *defines);

/* A <default>: doesn't replace a value that is there already, as in Mitsuba. False without memory.
 */
bool defines_add_default(struct defines *defines, const char *name, const char *value);

/* Replaces each $name of text; NULL with the error set where a name is unknown. *blocks owns the
 * result. */
char *defines_expand(struct defines *defines, const char *text, void **blocks, const char *file,
                     int line, struct fewray_error *error);

/* Whether the file has $name and the caller doesn't say what it is. */
bool defines_default_used(const struct defines *defines, const char *name);

/* The first of the caller's names that the file never used, or NULL. */
const char *defines_unused(const struct defines *defines);

#endif
