/* SPDX-License-Identifier: Apache-2.0 */
/* A team of MPI processes: the module "mpi", opened only where mpirun started this process. */

#include "pipeline/mpi_module.h"

#include <limits.h>
#include <mpi.h>
#include <sched.h>
#include <stdlib.h>
#include <time.h>

#define WAIT_LEAST_NS 20000 /* between two looks whether the others have come */
#define WAIT_MOST_NS  1000000

/* MPI itself would wait at full load, and take cores from processes that still work. */
static bool wait_for(MPI_Request *request) {
    struct timespec pause = {.tv_nsec = WAIT_LEAST_NS};
    for (int done = 0;;) {
        if (MPI_Test(request, &done, MPI_STATUS_IGNORE) != MPI_SUCCESS)
            return false;
        if (done)
            return true;
        nanosleep(&pause, NULL);
        if (pause.tv_nsec < WAIT_MOST_NS)
            pause.tv_nsec += pause.tv_nsec / 2;
    }
}

static bool gather(void *user, const void *mine, void *all, size_t bytes) {
    MPI_Request request;
    (void)user;
    return bytes <= INT_MAX &&
           MPI_Iallgather(mine, (int)bytes, MPI_BYTE, all, (int)bytes, MPI_BYTE, MPI_COMM_WORLD,
                          &request) == MPI_SUCCESS &&
           wait_for(&request);
}

/* Each core that several processes of this machine may use is shared evenly among them. Without an
 * answer it is all of them. */
static int share_of_cores(void) {
    MPI_Comm machine;
    cpu_set_t mine, *all = NULL;
    int processes = 1;
    double share = 0;
    CPU_ZERO(&mine);
    if (sched_getaffinity(0, sizeof(mine), &mine))
        return 1;
    if (MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine) !=
        MPI_SUCCESS)
        return CPU_COUNT(&mine);
    MPI_Comm_size(machine, &processes);
    all = calloc((size_t)processes, sizeof(*all));
    if (all)
        MPI_Allgather(&mine, sizeof(mine), MPI_BYTE, all, sizeof(mine), MPI_BYTE, machine);
    for (int core = 0; all && core < CPU_SETSIZE; core++) {
        int users = 0;
        for (int p = 0; p < processes; p++)
            users += CPU_ISSET(core, &all[p]) != 0;
        share += CPU_ISSET(core, &mine) ? 1.0 / users : 0;
    }
    free(all);
    MPI_Comm_free(&machine);
    return share > 1 ? (int)(share + 1e-6) : 1;
}

static void finish(struct fewray_team *team) {
    free(team->messages);
    team->messages = NULL;
    MPI_Finalize();
}

static int start(struct fewray_team *team, int *threads, struct fewray_error *error) {
    int level;
    *team = (struct fewray_team){.gather = gather};
    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &level) != MPI_SUCCESS)
        return fewray_fail(error, FEWRAY_ERROR_UNSUPPORTED, NULL, 0, "MPI can't be started");
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    MPI_Comm_rank(MPI_COMM_WORLD, &team->rank);
    MPI_Comm_size(MPI_COMM_WORLD, &team->size);
    *threads = share_of_cores();
    team->messages = malloc((size_t)team->size * FEWRAY_TEAM_MESSAGE);
    if (!team->messages) /* nobody can be told but by ending them */
        MPI_Abort(MPI_COMM_WORLD, 1);
    return FEWRAY_OK;
}

FEWRAY_API extern const struct mpi_module fewray_mpi;
const struct mpi_module fewray_mpi = {start, finish};
