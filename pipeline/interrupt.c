/* SPDX-License-Identifier: Apache-2.0 */
/* The command's state that signal handlers need, for they can reach no other. */

#include "pipeline/interrupt.h"

#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>

#include "features/cancel.h"
#include "fewray/features.h"

static volatile sig_atomic_t watched;
static volatile int interrupted;

static void end_process(int number) {
    fewray_discard_all_files();
    signal(number, SIG_DFL);
    raise(number); /* comes when this handler returns */
}

static void note_signal(int number) {
    if (!watched || cancel_wanted(&interrupted))
        end_process(number);
    cancel_set(&interrupted);
}

/* nohup and a shell's background jobs ignore signals on purpose. */
static void listen(int number) {
    struct sigaction before, action = {.sa_handler = note_signal, .sa_flags = SA_RESTART};
    sigemptyset(&action.sa_mask);
    if (!sigaction(number, NULL, &before) && before.sa_handler != SIG_IGN)
        sigaction(number, &action, NULL);
}

void interrupt_start(void) {
    listen(SIGINT);
    listen(SIGTERM);
    listen(SIGHUP);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    atexit(fewray_discard_all_files);
}

const volatile int *interrupt_watch(void) {
    watched = 1;
    return &interrupted;
}
