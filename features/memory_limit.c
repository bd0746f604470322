/* SPDX-License-Identifier: Apache-2.0 */
/* How much memory there is for one picture, mesh or file. */
#include "features/features_private.h"

#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

static uint64_t least(uint64_t a, uint64_t b) {
    return a < b ? a : b;
}

/* A number in a file of the kernel's; "max" or no such file: no limit. */
static uint64_t limit_in(const char *path) {
    unsigned long long value = 0;
    FILE *file = fopen(path, "re");
    const bool found = file && fscanf(file, "%llu", &value) == 1;
    if (file)
        fclose(file);
    return found ? value : UINT64_MAX;
}

static uint64_t own_limit(int resource) {
    struct rlimit limit;
    return getrlimit(resource, &limit) || limit.rlim_cur == RLIM_INFINITY ? UINT64_MAX
                                                                          : limit.rlim_cur;
}

uint64_t fewray_memory_limit(void) {
    const long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    uint64_t limit = pages > 0 && page > 0 ? (uint64_t)pages * (uint64_t)page : UINT64_MAX;
    limit = least(limit, limit_in("/sys/fs/cgroup/memory.max"));
    limit = least(limit, limit_in("/sys/fs/cgroup/memory/memory.limit_in_bytes"));
    return least(limit, least(own_limit(RLIMIT_AS), own_limit(RLIMIT_DATA)));
}

int fewray_memory_check(const char *path, const char *what, double bytes,
                        struct fewray_error *error) {
    const double gib = 1u << 30;
    if (bytes < 0x1p28) /* every machine has 256 MiB, or malloc() will tell */
        return FEWRAY_OK;
    const double limit = (double)fewray_memory_limit();
    if (bytes <= limit)
        return FEWRAY_OK;
    return fewray_fail(error, FEWRAY_ERROR_MEMORY, path, 0,
                       "%s would need %.1f GiB of memory, of which there are %.1f GiB", what,
                       bytes / gib, limit / gib);
}
