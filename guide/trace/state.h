/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_STATE_H
#define FEWRAY_GUIDE_STATE_H

/* Where in its samples a render stands, and all that it has found until there, as bytes: the memory
 * of this program as it is, for the same program. One function for both directions moves each
 * thing, so that they can't differ. */

#include "fewray/guide.h"
#include "guide/trace/stream.h"

struct fewray_rest;

enum state_phase {
    STATE_NOWHERE, /* no sample counts yet */
    STATE_LOOK,    /* within the first look, or after it and before its maps */
    STATE_REST,    /* within the samples after it, or after them all */
};

struct fewray_state {
    enum state_phase phase;
    int first;       /* samples a pixel, without the look's, before the pass over the picture */
    int next, tiles; /* of the pass: done, all; tiles = 0: before the first */
    int end;         /* of the pass, as first */
    int look_samples;
    struct fewray_render_stats counts; /* of the pass */
    /* What the tracing functions work on meanwhile; NULL: nothing */
    const struct fewray_look *look;
    const struct fewray_rest *rest;
    /* What was read, until the tracing functions take it. */
    bool resumes; /* the next pass begins with tile `next` and these counts */
    struct fewray_look *read_look, *read_kept;
    uint32_t read_part;
};

/* The samples begin, or go on where the state that was read has them. */
static inline bool state_resumes(const struct fewray_state *state, enum state_phase phase) {
    return state && state->resumes && state->phase == phase;
}

/* A pass begins. */
void state_enter(struct fewray_state *state, enum state_phase phase, int first, int end);

#endif
