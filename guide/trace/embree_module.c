/* SPDX-License-Identifier: Apache-2.0 */
/* The module "embree": the table of its functions, and what links the library. */

#include "guide/trace/embree.h"

FEWRAY_API extern const struct embree_functions fewray_embree_functions;

#define EMBREE_ADDRESS(name) .name = name,
const struct embree_functions fewray_embree_functions = {EMBREE_FUNCTIONS(EMBREE_ADDRESS)};
