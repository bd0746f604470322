/* SPDX-License-Identifier: Apache-2.0 */
/* Opens Embree when the first world is built. */

#include "guide/trace/embree.h"

#include "features/module.h"

struct embree_functions embree;

int embree_load(struct fewray_error *error) {
    int status = FEWRAY_OK;
#pragma omp critical(fewray_embree)
    if (!embree.rtcNewDevice) {
        const struct embree_functions *functions =
            fewray_module_symbol("embree", "fewray_embree_functions", error);
        if (functions)
            embree = *functions;
        else
            status = FEWRAY_ERROR_UNSUPPORTED;
    }
    return status;
}
