/* SPDX-License-Identifier: Apache-2.0 */
/* Voxels by hashing. */

#include "guide/odis/voxel_table.h"

#include <stdlib.h>

#include "guide/trace/sampler.h"

#define KEY_BITS    20
#define KEY_OFFSET  (1 << (KEY_BITS - 1))
#define LEAST_TABLE 4096

static uint64_t main_axis(struct vec3 n) {
    float x = fabsf(n.x), y = fabsf(n.y), z = fabsf(n.z);
    if (x >= y && x >= z)
        return n.x < 0;
    return y >= z ? 2 + (n.y < 0) : 4 + (n.z < 0);
}

/* Wraps around where a scene lies far from the origin, so that its voxels stay apart. */
static uint64_t voxel_index(float x, float voxel) {
    float i = floorf(x / voxel + 0.5f) + KEY_OFFSET; /* planes through 0 aren't a border */
    return fabsf(i) < 0x1p62f ? (uint64_t)(int64_t)i & (2 * KEY_OFFSET - 1) : 0;
}

static uint64_t make_key(float voxel, struct vec3 position, struct vec3 normal) {
    uint64_t x = voxel_index(position.x, voxel), y = voxel_index(position.y, voxel),
             z = voxel_index(position.z, voxel);
    return ((main_axis(normal) + 1) << (3 * KEY_BITS)) | (z << (2 * KEY_BITS)) | (y << KEY_BITS) |
           x;
}

/* The slot that holds a key, or the free one where it belongs. */
static uint32_t slot_of(const struct voxel_table *t, uint64_t key) {
    uint32_t slot = hash_combine((uint32_t)key, (uint32_t)(key >> 32)) & (t->size - 1);
    while (t->keys[slot] && t->keys[slot] != key)
        slot = (slot + 1) & (t->size - 1);
    return slot;
}

/* Makes the table twice as large. */
static bool grow_table(struct voxel_table *t) {
    struct voxel_table old = *t;
    t->size = old.size ? 2 * old.size : LEAST_TABLE;
    t->keys = calloc(t->size, sizeof(*t->keys));
    t->numbers = malloc(t->size * sizeof(*t->numbers));
    if (!t->keys || !t->numbers) {
        free(t->keys);
        free(t->numbers);
        *t = old;
        return false;
    }
    for (uint32_t i = 0; i < old.size; i++)
        if (old.keys[i]) {
            uint32_t slot = slot_of(t, old.keys[i]);
            t->keys[slot] = old.keys[i];
            t->numbers[slot] = old.numbers[i];
        }
    free(old.keys);
    free(old.numbers);
    return true;
}

int voxel_table_add(struct voxel_table *t, struct vec3 position, struct vec3 normal) {
    if (2 * (uint32_t)t->count >= t->size && !grow_table(t))
        return -1;
    uint64_t key = make_key(t->side, position, normal);
    uint32_t slot = slot_of(t, key);
    if (!t->keys[slot]) {
        t->keys[slot] = key;
        t->numbers[slot] = t->count++;
    }
    return t->numbers[slot];
}

int voxel_table_find(const struct voxel_table *t, struct vec3 position, struct vec3 normal) {
    if (!t->size)
        return -1;
    uint32_t slot = slot_of(t, make_key(t->side, position, normal));
    return t->keys[slot] ? t->numbers[slot] : -1;
}

void voxel_table_clear(struct voxel_table *t) {
    free(t->keys);
    free(t->numbers);
    *t = (struct voxel_table){.side = t->side};
}
