/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_LAYER_ALIASES_H
#define FEWRAY_PIPELINE_LAYER_ALIASES_H

/* What other renderers call the layers that a denoiser wants. */

#include "pipeline/layer_names.h"

struct layer_alias {
    enum layer_naming naming; /* NAMING_AUTO: of many programs */
    enum fewray_layer layer;
    const char *stem; /* what stands before the component, without Blender's view layer and the
                         name of Mitsuba's outer integrators; case doesn't count */
    const char *components; /* the letter of each channel, or words with commas between; "": the
                               stem is the whole name */
    bool only_asked;        /* another renderer means another thing by it */
};

/* For each layer the best first. */
const struct layer_alias *layer_aliases(int *count);

/* Radiance of what is seen directly, which is added to the emission: NULL-terminated stems of R, G,
 * B. */
const char *const *layer_backgrounds(void);

#endif
