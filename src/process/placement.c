/* SPDX-License-Identifier: BSD-3-Clause */
/* The placement of ranks: which cores each may use, and a warning where that makes the run slow. */
#include "segcast/process.h"

#include <stdlib.h>

/* The placement of one rank, as it reports it. */
typedef struct placement {
    char host[SC_HOST_BYTES];
    sc_core_set cores;
    int threads;
    uint64_t memory_bytes;
} placement;

/* The table has a line for each of so many ranks; of further ranks only the number is logged. */
enum { LINES_MAX = 16 };

static int count_cores(const sc_core_set *set)
{
    int count = 0;

    for (int i = 0; i < 64 * SC_CORE_WORDS; i++)
        count += (int)(set->words[i / 64] >> (i % 64) & 1);
    return count;
}

/* Print the cores as ranges, such as "0-3,8", into @p text. */
static void list_cores(const sc_core_set *set, char *text, size_t size)
{
    size_t used = 0;

    text[0] = '\0';
    for (int i = 0; i < 64 * SC_CORE_WORDS; i++) {
        int end = i;

        if (!(set->words[i / 64] >> (i % 64) & 1))
            continue;
        while (end + 1 < 64 * SC_CORE_WORDS && set->words[(end + 1) / 64] >> ((end + 1) % 64) & 1)
            end++;
        if (used < size)
            used += (size_t)snprintf(text + used, size - used, end > i ? "%s%d-%d" : "%s%d",
                                     used ? "," : "", i, end);
        i = end;
    }
}

static bool same_host(const placement *a, const placement *b)
{
    return !strcmp(a->host, b->host);
}

/* The sums over all ranks of a host. A core that several ranks may use counts once. */
typedef struct host_sum {
    int ranks, threads, cores;
} host_sum;

/* @return the sums over all ranks on the host of @p one. */
static host_sum sum_host(const placement *all, int count, const placement *one)
{
    host_sum sum = {0};
    sc_core_set together = {{0}};

    for (int i = 0; i < count; i++) {
        if (!same_host(&all[i], one))
            continue;
        sum.ranks++;
        sum.threads += all[i].threads;
        for (int w = 0; w < SC_CORE_WORDS; w++)
            together.words[w] |= all[i].cores.words[w];
    }
    sum.cores = count_cores(&together);
    return sum;
}

/* Log a line for each rank, up to LINES_MAX. */
static void log_table(const sc_app *app, const placement *all, int count)
{
    sc_info(app->ctx, "rank  host              threads  cores             memory share");
    for (int i = 0; i < count && i < LINES_MAX; i++) {
        const host_sum sum = sum_host(all, count, &all[i]);
        char cores[3 * 64 * SC_CORE_WORDS]; /* "1023," for every other core, at most */

        list_cores(&all[i].cores, cores, sizeof cores);
        sc_info(app->ctx, "%4d  %-16s  %7d  %-16s  %.1f GB", i, all[i].host, all[i].threads, cores,
                (double)all[i].memory_bytes / sum.ranks / 1e9);
    }
    if (count > LINES_MAX)
        sc_info(app->ctx, " ...  and %d more ranks", count - LINES_MAX);
}

/* Warn of the first rank or host that has more threads than cores, and name the options that help.
 * One warning is enough: it is the same mistake on all of them. */
static void warn_of_sharing(const sc_app *app, const placement *all, int count)
{
    for (int i = 0; i < count; i++) {
        const placement *p = &all[i];
        const host_sum sum = sum_host(all, count, p);
        const int cores = count_cores(&p->cores), each = sum.cores / sum.ranks;

        if (p->threads > cores) {
            sc_warn(app->ctx,
                    "%d threads of rank %d share %d core%s of %s; use mpirun --map-by slot:PE=%d "
                    "(or --bind-to none), srun --cpus-per-task=%d, or --threads %d",
                    p->threads, i, cores, cores == 1 ? "" : "s", p->host, p->threads, p->threads,
                    cores);
            return;
        }
        if (sum.threads > sum.cores) {
            sc_warn(
                app->ctx,
                "%d ranks with %d threads in all share %d core%s of %s; use fewer ranks or "
                "--threads %d, and mpirun --map-by slot:PE=THREADS or srun --cpus-per-task=THREADS",
                sum.ranks, sum.threads, sum.cores, sum.cores == 1 ? "" : "s", p->host,
                each > 0 ? each : 1);
            return;
        }
    }
}

/* Under Slurm a task without --cpus-per-task gets one core; the other cores of the node are idle.
 */
static void warn_of_idle_cores(const sc_app *app, const placement *all, int count)
{
    const char *on_node = getenv("SLURM_CPUS_ON_NODE");
    const host_sum sum = sum_host(all, count, &all[0]);
    const int allotted = on_node ? atoi(on_node) : 0;

    if (sum.ranks > 0 && allotted >= 2 * sum.threads && !getenv("SRUN_CPUS_PER_TASK"))
        sc_warn(app->ctx,
                "%d threads use %d of the %d CPUs that Slurm allotted on %s; was --cpus-per-task "
                "forgotten? give --cpus-per-task=%d, export SRUN_CPUS_PER_TASK=%d and "
                "OMP_NUM_THREADS=%d",
                sum.threads, sum.threads, allotted, all[0].host, allotted / sum.ranks,
                allotted / sum.ranks, allotted / sum.ranks);
}

sc_status sc_report_placement(sc_app *app)
{
    const int ranks = sc_comm_size(app->comm);
    SC_OWN(sc_free_at) placement *all = NULL;
    placement mine;

    memset(&mine, 0, sizeof mine); /* the gaps between the members are sent, too */
    sc_host_name(mine.host);
    mine.cores = sc_core_set_of_process();
    mine.threads = app->threads;
    mine.memory_bytes = sc_machine_memory();
    SC_PASS(sc_comm_gather(app->ctx, app->comm, &mine, sizeof mine, &all));
    if (!all)
        return SC_OK;
    log_table(app, all, ranks);
    warn_of_sharing(app, all, ranks);
    warn_of_idle_cores(app, all, ranks);
    return SC_OK;
}
