/* SPDX-License-Identifier: Apache-2.0 */
/* An allocator that fails on purpose, and knows which blocks are in use. */

#include "tests/stress/fault_wrap.h"

#include <errno.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *block, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
void __real_free(void *block);
void *__real_mmap(void *at, size_t size, int protection, int flags, int fd, off_t offset);
char *__real_strdup(const char *text);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *block, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
void __wrap_free(void *block);
void *__wrap_mmap(void *at, size_t size, int protection, int flags, int fd, off_t offset);
char *__wrap_strdup(const char *text);

/* Blocks in use, by open addressing; a freed place stays taken for the search. */
enum { PLACES = 1 << 18 };
static const char freed;
static const void *places[PLACES];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static long counted, failing, live;
static bool all_later;

static size_t place_of(const void *block) {
    return (size_t)(((uintptr_t)block >> 4) * 0x9e3779b97f4a7c15u >> 46) % PLACES;
}

static void *remember(void *block) {
    if (!block)
        return NULL;
    pthread_mutex_lock(&lock);
    size_t i = place_of(block);
    while (places[i] && places[i] != &freed)
        i = (i + 1) % PLACES;
    places[i] = block;
    live++;
    pthread_mutex_unlock(&lock);
    return block;
}

/* False for a block that a library allocated. */
static bool forget(const void *block) {
    bool known = false;
    pthread_mutex_lock(&lock);
    for (size_t i = place_of(block), k = 0; places[i] && k < PLACES; i = (i + 1) % PLACES, k++)
        if (places[i] == block) {
            places[i] = &freed;
            known = true;
            live--;
            break;
        }
    pthread_mutex_unlock(&lock);
    return known;
}

static bool fails(void) {
    pthread_mutex_lock(&lock);
    counted++;
    const bool now = failing > 0 && (counted == failing || (all_later && counted > failing));
    pthread_mutex_unlock(&lock);
    if (now)
        errno = ENOMEM;
    return now;
}

void wrap_fail(long n, int later) {
    pthread_mutex_lock(&lock);
    if (live == 0)
        memset(places, 0, sizeof places);
    counted = 0;
    failing = n;
    all_later = later;
    pthread_mutex_unlock(&lock);
}

long wrap_count(void) {
    return counted;
}

long wrap_live(void) {
    return live;
}

void *__wrap_malloc(size_t size) {
    return fails() ? NULL : remember(__real_malloc(size));
}

void *__wrap_calloc(size_t count, size_t size) {
    return fails() ? NULL : remember(__real_calloc(count, size));
}

void *__wrap_realloc(void *block, size_t size) {
    if (fails())
        return NULL;
    if (block)
        forget(block);
    return remember(__real_realloc(block, size));
}

void *__wrap_aligned_alloc(size_t alignment, size_t size) {
    return fails() ? NULL : remember(__real_aligned_alloc(alignment, size));
}

char *__wrap_strdup(const char *text) {
    return fails() ? NULL : remember(__real_strdup(text));
}

void __wrap_free(void *block) {
    if (block)
        forget(block);
    __real_free(block);
}

void *__wrap_mmap(void *at, size_t size, int protection, int flags, int fd, off_t offset) {
    return fails() ? MAP_FAILED : __real_mmap(at, size, protection, flags, fd, offset);
}
