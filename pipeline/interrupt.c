/* SPDX-License-Identifier: Apache-2.0 */
/* The one piece of global state: a signal handler can reach nothing else. */

#include "pipeline/interrupt.h"

#include <signal.h>
#include <stddef.h>

static volatile int interrupted;

static void note_signal(int number) {
    (void)number;
    interrupted = 1;
}

const volatile int *interrupt_watch(void) {
    struct sigaction action = {.sa_handler = note_signal,
                               .sa_flags = (int)SA_RESETHAND | SA_RESTART};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    return &interrupted;
}
