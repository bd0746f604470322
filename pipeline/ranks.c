/* SPDX-License-Identifier: Apache-2.0 */
/* Whether mpirun started this process, and with how many others. */

#include "pipeline/ranks.h"

#include <stdlib.h>

#include "features/module.h"

/* Of Open MPI's mpirun, of MPICH's and its relatives', and of starters that speak PMIx alone. */
static const char *const SIZES[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"};
static const char *const RANKS[] = {"OMPI_COMM_WORLD_RANK", "PMI_RANK", "PMIX_RANK"};
enum {
    SIZE_COUNT = sizeof SIZES / sizeof *SIZES,
    RANK_COUNT = sizeof RANKS / sizeof *RANKS,
};

/* Value of the first of these variables that is set, else -1. */
static int number_from(const char *const *names, int count) {
    for (int i = 0; i < count; i++)
        if (getenv(names[i]))
            return atoi(getenv(names[i]));
    return -1;
}

bool ranks_is_silent(void) {
    return number_from(RANKS, RANK_COUNT) > 0;
}

int ranks_start(struct ranks *ranks, struct fewray_error *error) {
    *ranks = (struct ranks){.module = NULL};
    const int size = number_from(SIZES, SIZE_COUNT), rank = number_from(RANKS, RANK_COUNT);
    if (size == 1 || (size < 0 && rank < 0))
        return FEWRAY_OK;
    struct fewray_error why;
    const struct mpi_module *module = fewray_module_symbol("mpi", "fewray_mpi", &why);
    if (!module)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, NULL, 0,
                           "mpirun started %s processes, which need MPI to share the work: %s",
                           size > 1 ? "several" : "this and perhaps more", why.what);
    const int status = module->start(&ranks->team, &ranks->threads, error);
    if (!status)
        ranks->module = module;
    return status;
}

const struct fewray_team *ranks_team(const struct ranks *ranks) {
    return ranks->module ? &ranks->team : NULL;
}

void ranks_finish(struct ranks *ranks) {
    if (ranks->module)
        ranks->module->finish(&ranks->team);
    ranks->module = NULL;
}
