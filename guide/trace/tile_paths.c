/* SPDX-License-Identifier: Apache-2.0 */
/* From pixels to bundles and back. */

#include "guide/trace/tile_paths.h"

static void finish_pixel(struct tile_paths *p) {
    if (p->sums.count + p->sums.dropped == 0)
        return;
    p->stats->dropped += p->sums.dropped;
    p->stats->pixels_guided += p->guided;
    film_add(p->film, p->x, p->y, p->group, &p->sums);
    p->sums = (struct pixel_sums){0};
    p->guided = false;
}

/* What a sample saw that the film drops isn't to be learnt from: one infinity would spoil the maps
 * of all blocks around. */
static void forget(const struct bundle_start *start) {
    if (start->record)
        start->record->depth = 0;
    if (start->second)
        start->second->albedo = 0;
}

static void trace_bundle(struct tile_paths *p) {
    struct path_sample samples[BUNDLE_LANES];
    if (p->count)
        p->trace(p->integrator, p->count, p->starts, samples);
    for (int i = 0; i < p->count; i++) {
        if (p->starts[i].x != p->x || p->starts[i].y != p->y)
            finish_pixel(p);
        p->x = p->starts[i].x;
        p->y = p->starts[i].y;
        if (!pixel_sums_add(&p->sums, &samples[i]))
            forget(&p->starts[i]);
        p->guided |= samples[i].guided;
        p->stats->rays += samples[i].rays;
        if (p->learning)
            maps_learn(p->learning, p->x, p->y, p->starts[i].record);
    }
    p->stats->paths += p->count;
    p->count = 0;
}

void tile_paths_add(struct tile_paths *p, const struct bundle_start *start) {
    p->starts[p->count] = *start;
    if (p->learning && !start->record)
        p->starts[p->count].record = &p->records[p->count];
    p->count++;
    if (p->count == BUNDLE_LANES)
        trace_bundle(p);
}

void tile_paths_end(struct tile_paths *p) {
    trace_bundle(p);
    finish_pixel(p);
}
