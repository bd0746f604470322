/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_ORIGIN_H
#define FEWRAY_PIPELINE_ORIGIN_H

/* Where figures come from: the machine, and the command line of this process. */

#include <stdbool.h>
#include <stddef.h>

/* "AMD EPYC ..." of this machine; "unknown CPU". */
void origin_cpu(char *name, size_t size);

/* The command line, quoted as a shell takes it, the program without its folder. False, where the
 * system doesn't tell it or it is longer than size. */
bool origin_command(char *text, size_t size);

#endif
