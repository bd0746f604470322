/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_FEATURES_EXR_REWRITE_H
#define FEWRAY_FEATURES_EXR_REWRITE_H

/* What the two files of fewray_exr_rewrite() share. */

#include "features/exr_file.h"

/* What is copied. */
struct rewriting {
    exr_context_t source;
    const struct fewray_exr_change *changes;
    int change_count;
    int width, height; /* of the changes' pixels */
    int home;          /* the part that gets the channels that the source lacks */
    bool float32;
    uint64_t source_size; /* bytes */
    int *owner;           /* (change_count): the part that has the channel; -1: it is new */
    exr_result_t fault;   /* of reading */
};

/* The change of a channel of the source, or -1. */
int exr_rewriting_find(const struct rewriting *work, int part, const char *channel);
/* Writes the pixels of a part that changes, whose header `out` has already. */
exr_result_t exr_rewrite_part(struct rewriting *work, exr_context_t out, int part);

#endif
