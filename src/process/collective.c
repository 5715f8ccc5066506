/* SPDX-License-Identifier: BSD-3-Clause */
/* What all ranks do together: agree on a return code, and get copies of what rank 0 has; what they
 * note of the time that it takes, and where they make files that they share. */
#include "segcast/process.h"

#include <stdlib.h>

sc_status sc_agree_aloud(const sc_app *app, sc_status mine)
{
    const sc_status agreed = sc_comm_agree(app->comm, mine);

    if (mine == SC_ERR_MEMORY && sc_comm_rank(app->comm) > 0)
        return sc_fail(app->ctx, agreed, "out of memory");
    return agreed;
}

sc_status sc_broadcast_array(sc_app *app, void *array, size_t count, size_t size)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    void *mine = NULL;
    sc_status status = SC_OK;

    if (first)
        memcpy(&mine, array, sizeof mine);
    else
        status = sc_alloc(app->ctx, count, size, &mine);
    status = sc_comm_agree(app->comm, status);
    if (status == SC_OK && count)
        sc_comm_broadcast(app->comm, mine, count * size);
    if (status != SC_OK && !first) {
        sc_free(mine);
        mine = NULL;
    }
    memcpy(array, &mine, sizeof mine); /* pointers of all types are alike: POSIX */
    return status;
}

void sc_add_time(const sc_app *app, sc_rank_record *times, sc_phase phase, double wall_s,
                 double cpu_s)
{
    static const sc_trace_kind kinds[SC_PHASE_COUNT] = {[SC_PHASE_READ] = SC_TRACE_READ,
                                                        [SC_PHASE_PREPARE] = SC_TRACE_PREPARE,
                                                        [SC_PHASE_SHARE] = SC_TRACE_SHARE};

    if (!times)
        return;
    if (app->trace && phase <= SC_PHASE_SHARE)
        sc_trace_add(app->trace, kinds[phase], 0, -1, wall_s, sc_wall_s());
    times->phases[phase].wall_s += sc_wall_s() - wall_s;
    times->phases[phase].cpu_s += sc_cpu_s() - cpu_s;
}

sc_status sc_cache_path(const sc_ctx *ctx, const char *name, char **out)
{
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    SC_OWN(sc_text_clear) sc_text path = {0};

    /* a relative name is to be ignored, says the specification */
    if (cache && cache[0] != '/')
        cache = NULL;
    if (!cache && (!home || home[0] != '/'))
        return sc_fail(ctx, SC_ERR_CREATE,
                       "there is no cache directory: neither XDG_CACHE_HOME nor HOME is an "
                       "absolute path; set one of them");
    SC_PASS(sc_text_add(ctx, &path, "%s%s/segcast/%s", cache ? cache : home, cache ? "" : "/.cache",
                        name));
    SC_HAND_OVER(path.data, out);
    return SC_OK;
}

const char *sc_temporary_folder(void)
{
    const char *folder = getenv("TMPDIR");

    return folder && folder[0] ? folder : "/tmp";
}
