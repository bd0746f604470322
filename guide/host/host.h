/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_HOST_H
#define FEWRAY_GUIDE_HOST_H

/* Another renderer's first look as our records. */

#include "fewray/guiding.h"
#include "guide/odis/look.h"

/* Checks the arrays, leaves bad records out and counts them in stats. *out is owned by the caller:
 * fewray_look_destroy(). */
int host_look_create(const struct fewray_guide_look *look, int threads, struct fewray_look **out,
                     struct fewray_guide_stats *stats, struct fewray_error *error);

#endif
