/* SPDX-License-Identifier: Apache-2.0 */
/* Whether threads can be had, found out by starting some. */

#include "guide/trace/spare_threads.h"

#include <pthread.h>

/* Waits until all are started: they must be there at the same time. */
static void *wait_for_others(void *gate) {
    pthread_mutex_lock(gate);
    pthread_mutex_unlock(gate);
    return NULL;
}

int spare_threads(int wanted) {
    pthread_mutex_t gate = PTHREAD_MUTEX_INITIALIZER;
    pthread_t threads[SPARE_THREADS_MAX];
    int started = 0;
    pthread_mutex_lock(&gate);
    while (started < wanted && started < SPARE_THREADS_MAX &&
           !pthread_create(&threads[started], NULL, wait_for_others, &gate))
        started++;
    pthread_mutex_unlock(&gate);
    for (int i = 0; i < started; i++)
        pthread_join(threads[i], NULL);
    pthread_mutex_destroy(&gate);
    return started;
}
