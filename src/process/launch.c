/* SPDX-License-Identifier: BSD-3-Clause */
/* How this process was started, found out by the variables that launchers of parallel programs set,
 * and how many threads it can have. */
#include "segcast/process.h"

#include <stdlib.h>
#include <unistd.h>

/* Variables that give a process its number; each is set for every process, also for a single one.
 */
static const char *const rank_names[] = {
    "OMPI_COMM_WORLD_RANK", /* mpirun of Open MPI */
    "PMIX_RANK",            /* PMIx: srun --mpi=pmix, prun */
    "PMI_RANK",             /* PMI 1 and 2: MPICH, Intel MPI, srun --mpi=pmi2, PALS, Flux */
    "PALS_RANKID",          /* PALS, and srun --mpi=cray_shasta */
    "ALPS_APP_PE",          /* aprun of Cray */
    "MV2_COMM_WORLD_RANK",  /* MVAPICH */
    "FLUX_TASK_RANK",       /* Flux */
};
/* Variables that give the number of processes. */
static const char *const size_names[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE",
                                         "FLUX_JOB_SIZE", "SLURM_STEP_NUM_TASKS"};

/* @return the largest number in the variables @p names [count], or -1 if none of them is set.
 * @param where receives the name of the variable that holds it, if there is one. */
static int largest(const char *const *names, size_t count, const char **where)
{
    int found = -1;

    for (size_t i = 0; i < count; i++) {
        const char *text = getenv(names[i]);

        if (text && atoi(text) > found) {
            found = atoi(text);
            *where = names[i];
        }
    }
    return found;
}

/* Was this process started by a launcher, as one of several, or as one of an unknown number? */
static bool is_one_of_several(void)
{
    const char *where;
    const int rank = largest(rank_names, SC_COUNT_OF(rank_names), &where);
    const int size = largest(size_names, SC_COUNT_OF(size_names), &where);

    return (rank >= 0 || getenv("PMI_FD")) && size != 1;
}

/* Was this process started by a launcher of parallel programs, be it as the only one? */
static bool was_launched(void)
{
    const char *where;

    return largest(rank_names, SC_COUNT_OF(rank_names), &where) >= 0 || getenv("PMI_FD");
}

sc_status sc_launch_mode(const sc_ctx *ctx, bool *use_mpi)
{
    const char *text = getenv("SEGCAST_MPI");

    if (!text || !strcmp(text, "auto"))
        *use_mpi = is_one_of_several();
    else if (!strcmp(text, "yes") || !strcmp(text, "no"))
        *use_mpi = text[0] == 'y';
    else
        return sc_fail(ctx, SC_ERR_USAGE, "SEGCAST_MPI is \"%s\", expected yes, no or auto", text);
    return SC_OK;
}

sc_status sc_launch(const sc_ctx *ctx, sc_comm **out)
{
    bool use_mpi = false;

    SC_PASS(sc_launch_mode(ctx, &use_mpi));
    return sc_comm_open(ctx, use_mpi, out);
}

sc_status sc_check_communicator(const sc_ctx *ctx, const sc_comm *comm)
{
    const char *override = getenv("SEGCAST_MPI"), *where = "";
    const int rank = largest(rank_names, SC_COUNT_OF(rank_names), &where);
    const char *rank_name = where;
    const int size = largest(size_names, SC_COUNT_OF(size_names), &where);

    if (sc_comm_size(comm) > 1 || (override && !strcmp(override, "no")))
        return SC_OK;
    if (size > 1)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "%d processes were started (%s) that cannot see each other; use srun "
                       "--mpi=pmix (or what `srun --mpi=list` offers for this MPI), or its own "
                       "mpirun; SEGCAST_MPI=no lets each work alone",
                       size, where);
    if (rank > 0)
        return sc_fail(
            ctx, SC_ERR_USAGE,
            "this is process %d of several (%s), but they cannot see each other; use the launcher "
            "that belongs to the MPI of segcast; SEGCAST_MPI=no lets each work alone",
            rank, rank_name);
    return SC_OK;
}

/* Threads of a process besides those that draw: the two worker threads of the farm, and what two
 * encoders start for themselves. */
enum { OTHER_THREADS = 2 + 2 * 5 };
/* More threads than this for each core only wait for each other and take memory. */
enum { THREADS_PER_CORE = 32, THREADS_MIN = 64 };

/* @return how many threads have to be startable for a process whose parallel loops have @p threads:
 * the thread that draws has its own set of them beside that of the main thread. */
static int needed(int threads)
{
    return 2 * (threads - 1) + OTHER_THREADS;
}

/* Lower app->threads to what the cores make sensible and the limits of the system allow, and warn
 * if that is less than was asked for: a thread that OpenMP cannot start would end the process.
 * Tries it out, by starting so many. Collective. @return SC_ERR_SYSTEM, logged, if there is no room
 * even for one thread that draws; SC_ERR_MEMORY. */
static sc_status bound_threads(sc_app *app)
{
    const int cores = sc_usable_cores();
    const int most =
        cores * THREADS_PER_CORE > THREADS_MIN ? cores * THREADS_PER_CORE : THREADS_MIN;
    const int wanted = app->threads;
    const char *rest = "more would only wait for each other";
    sc_thread_probe *probe = NULL;
    sc_status status = SC_OK;
    int started;

    if (app->threads > most)
        app->threads = most;
    status = sc_thread_probe_start(app->ctx, needed(app->threads), &probe, &started);
    /* All ranks hold their threads until all have tried: those of a node have one limit together.
     */
    status = sc_comm_agree(app->comm, status);
    sc_thread_probe_end(probe);
    if (status != SC_OK)
        return status;
    if (started < needed(1))
        status = sc_fail(
            app->ctx, SC_ERR_SYSTEM,
            "only %d threads can be started beside the first, and %d are needed; raise the limit "
            "of processes (ulimit -u), of the control group (pids.max) or of memory (ulimit -v)",
            started, needed(1));
    else if (started < needed(app->threads)) {
        app->threads = (started - OTHER_THREADS) / 2 + 1;
        rest = "the system allows no more (ulimit -u, pids.max of the control group, ulimit -v)";
    }
    if (status == SC_OK && app->threads < wanted)
        sc_warn(app->ctx, "%d threads instead of %d on %d core%s: %s", app->threads, wanted, cores,
                cores == 1 ? "" : "s", rest);
    return sc_comm_agree(app->comm, status);
}

/* Execute a command. If it has the option --threads, app->threads is first lowered to what the
 * cores make sensible and the limits of the system allow, with a warning. Collective. @return as
 * the command, or SC_ERR_SYSTEM, logged, if not even the fewest threads can be started. */
static sc_status execute_bounded(sc_app *app, const sc_command *command)
{
    SC_PASS(sc_command_has_threads(command) ? bound_threads(app) : SC_OK);
    return command->execute(app);
}

/* Execute a command for one process: on rank 0, with a communicator of its own, while the other
 * ranks wait for the return code. */
static sc_status execute_alone(sc_app *app, const sc_command *command)
{
    sc_comm *all = app->comm, *alone = NULL;
    sc_status status;

    SC_PASS(sc_comm_open(app->ctx, false, &alone));
    app->comm = alone;
    status = execute_bounded(app, command);
    app->comm = all;
    sc_comm_close(alone);
    return status;
}

sc_status sc_execute(sc_app *app, const sc_command *command)
{
    const bool is_root = sc_comm_rank(app->comm) == 0;
    sc_status status = SC_OK;

    app->display = is_root ? sc_display_start(app, was_launched() ? getppid() : 0) : NULL;
    if (command->by_all || app->options.plan.calibrate)
        status = execute_bounded(app, command);
    else if (is_root)
        status = execute_alone(app, command);
    sc_display_stop(app->display);
    app->display = NULL;
    return status;
}
