/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_INTERRUPT_H
#define FEWRAY_PIPELINE_INTERRUPT_H

/* Ctrl-C ends the work early instead of losing it. */

/* From now on the first SIGINT or SIGTERM makes the returned flag non-zero; the second one kills as
 * usual. */
const volatile int *interrupt_watch(void);

#endif
