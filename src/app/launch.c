/* SPDX-License-Identifier: BSD-3-Clause */
/* How this process was started, found out by the variables that MPI launchers set. */
#include "app.h"

#include <stdlib.h>

bool sc_launched_by_mpi(void)
{
    static const char *const variables[] = {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK",
                                            "PMI_SIZE", "PMI_FD"};

    for (size_t i = 0; i < SC_COUNT_OF(variables); i++) {
        if (getenv(variables[i]))
            return true;
    }
    return false;
}

sc_status sc_check_communicator(const sc_ctx *ctx, const sc_comm *comm)
{
    const char *tasks = getenv("SLURM_STEP_NUM_TASKS");

    if (tasks && atoi(tasks) > 1 && sc_comm_size(comm) == 1)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "srun started %s tasks that cannot see each other; use srun --mpi=pmix (or "
                       "what `srun --mpi=list` offers for this MPI), or mpirun",
                       tasks);
    return SC_OK;
}
