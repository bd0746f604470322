/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_PIPELINE_RANKS_H
#define FEWRAY_PIPELINE_RANKS_H

/* The processes that mpirun, or another starter of MPI programs, started together. */

#include "fewray/guide.h"
#include "pipeline/mpi_module.h"

struct ranks {
    const struct mpi_module *module; /* NULL: this process was started alone */
    struct fewray_team team;
    int threads; /* that this process should use; 0: all cores */
};

/* Whether this process isn't the first of several, by its environment alone: then others say what
 * is to be said. */
bool ranks_is_silent(void);

/* Opens the module "mpi" and joins the others where there are some. */
int ranks_start(struct ranks *ranks, struct fewray_error *error);
/* NULL where this process was started alone. */
const struct fewray_team *ranks_team(const struct ranks *ranks);
/* Waits until all have come here. Does nothing where ranks_start() failed. */
void ranks_finish(struct ranks *ranks);

#endif
