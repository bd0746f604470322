/* SPDX-License-Identifier: Apache-2.0 */
/* Maps out of memory and back. What is read is only trusted so far that no lookup can leave its
 * arrays. */

#include "guide/odis/maps_state.h"

#include <stdlib.h>

#include "guide/odis/gather.h"
#include "guide/odis/probes.h"

/* Of each used slot a number of its own would be right; below count is what lookups need. A free
 * slot ends each search. */
static bool is_sound_table(const struct voxel_table *t) {
    uint32_t used = 0;
    for (uint32_t i = 0; i < t->size; i++) {
        used += t->keys[i] != 0;
        if (t->keys[i] && (t->numbers[i] < 0 || t->numbers[i] >= t->count))
            return false;
    }
    return used == (uint32_t)t->count && (used < t->size || !t->size);
}

static bool move_table(struct stream *s, struct voxel_table *t) {
    void *keys = t->keys, *numbers = t->numbers;
    bool moved = STREAM_MOVE(s, t->side) && STREAM_MOVE(s, t->count) && STREAM_MOVE(s, t->size) &&
                 stream_demand(s, t->count >= 0 && (t->size & (t->size - 1)) == 0);
    moved = moved && stream_array(s, &keys, t->size, sizeof *t->keys);
    t->keys = keys;
    moved = moved && stream_array(s, &numbers, t->size, sizeof *t->numbers);
    t->numbers = numbers;
    return moved && stream_demand(s, is_sound_table(t));
}

static bool move_level(struct stream *s, struct probe_level *level) {
    void *probes = level->probes;
    bool moved = move_table(s, &level->voxels) &&
                 stream_array(s, &probes, (size_t)level->voxels.count, sizeof *level->probes);
    level->probes = probes;
    return moved;
}

static bool move_probes(struct stream *s, struct probes **probes) {
    int any = *probes != NULL;
    if (!STREAM_MOVE(s, any) || !any)
        return !s->fault;
    if (s->read && !(*probes = calloc(1, sizeof **probes))) {
        s->fault = STREAM_NO_MEMORY;
        return false;
    }
    return move_level(s, &(*probes)->fine) && move_level(s, &(*probes)->coarse);
}

/* Numbers of maps, least..count - 1. */
static bool are_maps(const int32_t *numbers, size_t n, int least, int count) {
    for (size_t i = 0; i < n; i++)
        if (numbers[i] < least || numbers[i] >= count)
            return false;
    return true;
}

static bool move_places(struct stream *s, struct fewray_maps *maps) {
    int any = maps->place_maps != NULL;
    void *place_maps = maps->place_maps;
    if (!STREAM_MOVE(s, any) || !any)
        return !s->fault;
    const bool moved =
        move_table(s, &maps->places) &&
        stream_array(s, &place_maps, (size_t)maps->places.count, sizeof *maps->place_maps);
    maps->place_maps = place_maps;
    return moved &&
           stream_demand(s, are_maps(maps->place_maps, (size_t)maps->places.count, 0, maps->count));
}

static bool move_arrays(struct stream *s, struct fewray_maps *maps) {
    const size_t blocks = (size_t)maps->columns * (size_t)maps->rows, count = (size_t)maps->count;
    void *of_maps = maps->maps, *index = maps->index, *noise = maps->look_noise, *sums = maps->sums;
    int learns = maps->sums != NULL;
    bool moved = stream_array(s, &of_maps, count, sizeof *maps->maps);
    maps->maps = of_maps;
    moved = moved && stream_array(s, &index, blocks, sizeof *maps->index);
    maps->index = index;
    moved = moved && stream_array(s, &noise, blocks, sizeof *maps->look_noise);
    maps->look_noise = noise;
    moved = moved && STREAM_MOVE(s, learns);
    if (moved && learns)
        moved = stream_array(s, &sums, count, map_sums_bytes());
    maps->sums = sums;
    return moved && stream_demand(s, are_maps(maps->index, blocks, -1, maps->count));
}

/* Not every byte is a bool. */
static bool move_flag(struct stream *s, bool *flag) {
    int number = *flag;
    const bool moved = STREAM_MOVE(s, number);
    *flag = number != 0;
    return moved;
}

bool maps_move(struct stream *s, int width, int height, struct fewray_maps **out) {
    if (s->read && !(*out = calloc(1, sizeof **out))) {
        s->fault = STREAM_NO_MEMORY;
        return false;
    }
    struct fewray_maps *maps = *out;
    if (s->read) {
        maps->width = width;
        maps->height = height;
        maps->columns = (width + BLOCK_SIZE - 1) / BLOCK_SIZE;
        maps->rows = (height + BLOCK_SIZE - 1) / BLOCK_SIZE;
    }
    return STREAM_MOVE(s, maps->count) && stream_demand(s, maps->count >= 0) &&
           STREAM_MOVE(s, maps->merge) && move_flag(s, &maps->fixed_fraction) &&
           stream_demand(s, maps->merge >= 0 && maps->merge <= SPHERE_ROWS) &&
           move_arrays(s, maps) && move_probes(s, &maps->probes) && move_places(s, maps);
}
