/* SPDX-License-Identifier: BSD-3-Clause */
/* How a process finds out that a launcher has started it, with the variables that launchers set. */
#include "check.h"

#include "segcast/process.h"

static const char *const names[] = {
    "OMPI_COMM_WORLD_RANK",
    "OMPI_COMM_WORLD_SIZE",
    "PMIX_RANK",
    "PMI_RANK",
    "PMI_SIZE",
    "PMI_FD",
    "PALS_RANKID",
    "ALPS_APP_PE",
    "MV2_COMM_WORLD_RANK",
    "MV2_COMM_WORLD_SIZE",
    "FLUX_TASK_RANK",
    "FLUX_JOB_SIZE",
    "SLURM_STEP_NUM_TASKS",
    "SLURM_PROCID",
    "PMI_LOCAL_RANK",
    "SEGCAST_MPI",
};

/* An environment, as "NAME=VALUE ...", and what follows from it. */
typedef struct launch {
    const char *variables;
    bool use_mpi;
    sc_status alone; /* the outcome if MPI then sees only one process */
} launch;

/* Set exactly the variables of @p text among those of names[]. */
static void set_environment(const char *text)
{
    char copy[256], *rest = copy, *word;

    for (size_t i = 0; i < SC_COUNT_OF(names); i++)
        unsetenv(names[i]);
    snprintf(copy, sizeof copy, "%s", text);
    while ((word = strtok_r(rest, " ", &rest))) {
        char *equals = strchr(word, '=');

        *equals = '\0';
        setenv(word, equals + 1, 1);
    }
}

TEST(launchers_are_recognized)
{
    static const launch launches[] = {
        {"", false, SC_OK},
        {"OMPI_COMM_WORLD_RANK=0 OMPI_COMM_WORLD_SIZE=2", true, SC_ERR_USAGE},
        {"OMPI_COMM_WORLD_RANK=0 OMPI_COMM_WORLD_SIZE=1", false, SC_OK}, /* mpirun -n 1 */
        {"PMIX_RANK=3 SLURM_STEP_NUM_TASKS=4", true, SC_ERR_USAGE},      /* srun --mpi=pmix */
        {"PMIX_RANK=0 SLURM_STEP_NUM_TASKS=1", false, SC_OK},
        {"PMI_RANK=1 PMI_SIZE=2 PMI_FD=5", true, SC_ERR_USAGE}, /* MPICH, srun --mpi=pmi2 */
        {"PMI_FD=5", true, SC_OK},
        {"PALS_RANKID=2", true, SC_ERR_USAGE}, /* PALS without PMI */
        {"PALS_RANKID=0 PMI_RANK=0 PMI_SIZE=8", true, SC_ERR_USAGE},
        {"PALS_RANKID=0 SLURM_STEP_NUM_TASKS=8", true, SC_ERR_USAGE}, /* srun --mpi=cray_shasta */
        {"ALPS_APP_PE=7", true, SC_ERR_USAGE},
        {"MV2_COMM_WORLD_RANK=0 MV2_COMM_WORLD_SIZE=2", true, SC_ERR_USAGE},
        {"FLUX_TASK_RANK=1 FLUX_JOB_SIZE=2", true, SC_ERR_USAGE},
        {"SLURM_STEP_NUM_TASKS=4 SLURM_PROCID=0", false, SC_ERR_USAGE}, /* srun --mpi=none */
        {"SLURM_STEP_NUM_TASKS=1 SLURM_PROCID=0", false, SC_OK},
        {"SEGCAST_MPI=no PMI_RANK=1 PMI_SIZE=2", false, SC_OK},
        {"SEGCAST_MPI=yes", true, SC_OK},
        {"SEGCAST_MPI=auto PMIX_RANK=1", true, SC_ERR_USAGE},
    };
    sc_comm *one;

    assert_ok(sc_comm_open(&quiet, false, &one));
    for (size_t i = 0; i < SC_COUNT_OF(launches); i++) {
        bool use_mpi = !launches[i].use_mpi;

        set_environment(launches[i].variables);
        assert_ok(sc_launch_mode(&quiet, &use_mpi));
        if (use_mpi != launches[i].use_mpi)
            fail_msg("\"%s\": MPI %d, expected %d", launches[i].variables, use_mpi,
                     launches[i].use_mpi);
        if (sc_check_communicator(&quiet, one) != launches[i].alone)
            fail_msg("\"%s\": a single process gives %d, expected %d", launches[i].variables,
                     sc_check_communicator(&quiet, one), launches[i].alone);
    }
    sc_comm_close(one);
}

TEST(another_mode_is_refused)
{
    bool use_mpi;

    set_environment("SEGCAST_MPI=maybe");
    assert_int_equal(sc_launch_mode(&quiet, &use_mpi), SC_ERR_USAGE);
}

RUN_TESTS(NULL, NULL)
