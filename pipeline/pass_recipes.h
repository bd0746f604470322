/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_PASS_RECIPES_H
#define FEWRAY_PIPELINE_PASS_RECIPES_H

/* Which passes of a renderer sum up to its picture. */

#include "pipeline/layer_names.h"

struct pass_term {
    const char *names;  /* alternatives, separated by |; a * at the end: any that begin so */
    const char *color;  /* NULL, or what the pass has to be multiplied by */
    const char *unless; /* NULL, or a pass that is a part of this one */
};

struct pass_recipe {
    enum layer_naming naming;
    const char *what;
    bool emission_apart;           /* what is seen shining is a pass of its own */
    bool emission_inside;          /* it is in the first term */
    const struct pass_term *terms; /* ends with NULL names */
};

const struct pass_recipe *pass_recipes(int *count);

#endif
