/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_REST_H
#define FEWRAY_GUIDE_REST_H

/* What a render's state needs of the samples after the look. */

#include <stdbool.h>
#include <stdint.h>

#define KEPT_SAMPLES 2 /* of a pixel between two refinements, for new probes */

struct fewray_look;
struct fewray_rest;

/* Records that the next refinement needs; NULL: none. rest may be NULL, here and below. */
const struct fewray_look *rest_kept(const struct fewray_rest *rest);
/* Of the samples: see struct integrator. */
uint32_t rest_part(const struct fewray_rest *rest);

/* Whether renders of spp_a and spp_b samples a pixel trace the same samples in the same way before
 * tile `next` of the pass that begins with sample `first` after the look. refine: there are maps
 * that may learn. */
bool rest_passes_agree(bool refine, int look, int spp_a, int spp_b, int first, int next);

#endif
