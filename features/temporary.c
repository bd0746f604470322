/* SPDX-License-Identifier: Apache-2.0 */
/* Names of temporary files, and the list of those in use: who ends the process at once removes
 * them. The list is of fixed size and free of locks, so that a signal handler can walk it. */
#include "features/features_private.h"

#include <errno.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* A run has four outputs, each written by a name of its own beside its staged one, and a preview.
 * More than the list holds are temporary all the same, only not removed by a signal. */
enum { SLOTS = 32 };
enum { SLOT_FREE, SLOT_CHANGING, SLOT_USED };

static struct {
    atomic_int state;
    char name[PATH_MAX];
} slots[SLOTS];

static void remember(const char *name) {
    if (strlen(name) >= sizeof slots[0].name)
        return;
    for (int i = 0; i < SLOTS; i++) {
        int expected = SLOT_FREE;
        if (!atomic_compare_exchange_strong(&slots[i].state, &expected, SLOT_CHANGING))
            continue;
        strcpy(slots[i].name, name);
        atomic_store(&slots[i].state, SLOT_USED);
        return;
    }
}

void temporary_forget(const char *name) {
    for (int i = 0; i < SLOTS; i++)
        if (atomic_load(&slots[i].state) == SLOT_USED && !strcmp(slots[i].name, name))
            atomic_store(&slots[i].state, SLOT_FREE);
}

char *fewray_temporary_name(const char *path) {
    static atomic_uint serial;
    const char *slash = strrchr(path, '/');
    const int folder = slash ? (int)(slash - path) + 1 : 0;
    /* The clock keeps apart processes of the same id on two machines that share the folder. */
    struct timespec now = {0};
    clock_gettime(CLOCK_REALTIME, &now);
    const size_t size = (size_t)folder + 64;
    char *name = malloc(size);
    if (!name)
        return NULL;
    /* The name doesn't contain the file's own, which may already be as long as names can be. */
    snprintf(name, size, "%.*s.fewray-%ld-%lx-%u.tmp", folder, path, (long)getpid(),
             (unsigned long)now.tv_nsec, atomic_fetch_add(&serial, 1u));
    remember(name);
    return name;
}

void fewray_discard_file(const char *temporary) {
    const int kept = errno;
    unlink(temporary);
    temporary_forget(temporary);
    errno = kept;
}

void fewray_discard_all_files(void) {
    const int kept = errno;
    for (int i = 0; i < SLOTS; i++)
        if (atomic_load(&slots[i].state) == SLOT_USED)
            unlink(slots[i].name);
    errno = kept;
}
