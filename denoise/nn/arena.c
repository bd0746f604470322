/* SPDX-License-Identifier: Apache-2.0 */
/* Plans one block of memory for buffers that live at different times. */

#include <assert.h>

#include "denoise/nn/nn.h"

#define MAX_BUFFERS 64

static size_t round_up(size_t bytes) {
    return (bytes + 63) & ~(size_t)63;
}

static bool live_together(const struct nn_buffer *a, const struct nn_buffer *b) {
    return a->first <= b->last && b->first <= a->last;
}

/* The lowest offset where buffer i overlaps none of the placed ones that live at the same time. */
static size_t lowest_offset(const struct nn_buffer *buffers, const size_t *offsets,
                            const int *placed, int placed_count, int i) {
    size_t offset = 0;
    bool moved = true;
    while (moved) { /* each move passes the end of a placed buffer, so this ends */
        moved = false;
        for (int k = 0; k < placed_count; ++k) {
            int j = placed[k];
            size_t end = offsets[j] + round_up(buffers[j].bytes);
            if (live_together(&buffers[i], &buffers[j]) && offset < end &&
                offsets[j] < offset + round_up(buffers[i].bytes)) {
                offset = end;
                moved = true;
            }
        }
    }
    return offset;
}

size_t nn_arena_plan(const struct nn_buffer *buffers, int count, size_t *offsets) {
    assert(count >= 0 && count <= MAX_BUFFERS);
    int order[MAX_BUFFERS];
    for (int i = 0; i < count; ++i) { /* insertion sort: largest first, ties in their given order */
        int k = i;
        for (; k > 0 && buffers[order[k - 1]].bytes < buffers[i].bytes; --k)
            order[k] = order[k - 1];
        order[k] = i;
    }
    size_t total = 0;
    for (int k = 0; k < count; ++k) {
        int i = order[k];
        offsets[i] = lowest_offset(buffers, offsets, order, k, i);
        size_t end = offsets[i] + round_up(buffers[i].bytes);
        total = end > total ? end : total;
    }
    return total;
}
