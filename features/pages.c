/* SPDX-License-Identifier: Apache-2.0 */
/* Anonymous mappings, aligned to huge pages. */

#include "features/pages.h"

#include <stdint.h>
#include <sys/mman.h>

#define HUGE_PAGE ((size_t)2 << 20)

static size_t whole_pages(size_t bytes) {
    return (bytes + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE;
}

void *pages_create(size_t bytes) {
    const size_t size = whole_pages(bytes);
    if (size < bytes || size + HUGE_PAGE < size)
        return NULL;
    char *map =
        mmap(NULL, size + HUGE_PAGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (map == MAP_FAILED)
        return NULL;
    const size_t before = (HUGE_PAGE - (uintptr_t)map % HUGE_PAGE) % HUGE_PAGE;
    if (before > 0)
        munmap(map, before);
    if (before < HUGE_PAGE)
        munmap(map + before + size, HUGE_PAGE - before);
#ifdef MADV_HUGEPAGE
    if (bytes >= HUGE_PAGE)
        madvise(map + before, size, MADV_HUGEPAGE);
#endif
    return map + before;
}

void pages_destroy(void *memory, size_t bytes) {
    if (memory)
        munmap(memory, whole_pages(bytes));
}
