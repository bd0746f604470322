/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_MEMORY_H
#define FEWRAY_GUIDE_SCENE_MEMORY_H

/* Small pieces of memory that are freed together, and arrays that grow. */

#include <stdbool.h>
#include <stddef.h>

/* size bytes, zeroed; NULL without memory. *blocks is NULL at first. */
void *blocks_allocate(void **blocks, size_t size);
/* length bytes of text and a NUL. */
char *blocks_copy(void **blocks, const char *text, size_t length);
void blocks_free(void **blocks);

/* Makes room for count items of the given size in *items, *capacity of which are allocated. False
 * without memory. */
bool array_reserve(void **items, size_t *capacity, size_t count, size_t size);

#endif
