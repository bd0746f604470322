/* SPDX-License-Identifier: Apache-2.0 */
/* Small pieces of memory that are freed together, and arrays that grow. */

#include "guide/scene/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define BLOCK_BYTES 65536

struct block {
    struct block *next;
    size_t used, size;
    max_align_t data[];
};

void *blocks_allocate(void **blocks, size_t size) {
    const size_t align = sizeof(max_align_t);
    if (size > SIZE_MAX / 4)
        return NULL;
    size = (size + align - 1) / align * align;
    struct block *block = *blocks;
    if (!block || block->size - block->used < size) {
        size_t capacity = size > BLOCK_BYTES ? size : BLOCK_BYTES;
        block = calloc(1, sizeof(*block) + capacity);
        if (!block)
            return NULL;
        block->size = capacity;
        block->next = *blocks;
        *blocks = block;
    }
    char *piece = (char *)block->data + block->used;
    block->used += size;
    return piece;
}

char *blocks_copy(void **blocks, const char *text, size_t length) {
    char *copy = blocks_allocate(blocks, length + 1);
    if (copy)
        memcpy(copy, text, length);
    return copy;
}

void blocks_free(void **blocks) {
    struct block *block = *blocks;
    while (block) {
        struct block *next = block->next;
        free(block);
        block = next;
    }
    *blocks = NULL;
}

bool array_reserve(void **items, size_t *capacity, size_t count, size_t size) {
    if (count <= *capacity)
        return true;
    size_t larger = *capacity < 16 ? 16 : *capacity + *capacity / 2;
    if (larger < count)
        larger = count;
    if (larger > SIZE_MAX / 2 / size)
        return false;
    void *grown = realloc(*items, larger * size);
    if (!grown)
        return false;
    *items = grown;
    *capacity = larger;
    return true;
}
