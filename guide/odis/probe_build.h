/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_PROBE_BUILD_H
#define FEWRAY_GUIDE_PROBE_BUILD_H

/* One probe from the second vertices that it pools. */

#include "guide/odis/probes.h"

/* What a coarse probe tells the fine ones inside it. */
struct probe_prior {
    float share[PROBE_BINS]; /* of the light that arrives, by direction; sums to 1 */
    bool lit;                /* some light was found; else the shares are even */
};

/* The records and second vertices at `indices` (count > 0) of the look become *probe. prior: NULL =
 * nothing is known beside them. *as_prior, where not NULL, gets what this probe tells in turn. */
void probe_build(const struct fewray_look *look, const uint32_t *indices, int count,
                 const struct probe_prior *prior, struct probe *probe,
                 struct probe_prior *as_prior);

#endif
