/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_INTERRUPT_H
#define FEWRAY_PIPELINE_INTERRUPT_H

/* Signals, for the command. */

/* From now on no end of the process, by SIGINT, SIGTERM, SIGHUP or a library's exit(), leaves
 * temporary files; a pipe that nobody reads and a file above the size limit are errors of write(),
 * not the end. Signals that are ignored at the start stay so. */
void interrupt_start(void);

/* From now on the first SIGINT, SIGTERM or SIGHUP only sets the returned flag; the second one ends
 * the process at once. */
const volatile int *interrupt_watch(void);

#endif
