/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_MPI_MODULE_H
#define FEWRAY_PIPELINE_MPI_MODULE_H

/* What the module "mpi" exports as fewray_mpi. */

#include "fewray/guide.h"

struct mpi_module {
    /* Joins the processes that mpirun started with this one; *threads gets how many this one should
     * use: its share of the cores that it may run on. */
    int (*start)(struct fewray_team *team, int *threads, struct fewray_error *error);
    /* Leaves them, after all have come here. */
    void (*finish)(struct fewray_team *team);
};

#endif
