/* SPDX-License-Identifier: BSD-3-Clause */
/* What all ranks do together: agree on a return code, and get copies of what rank 0 has. */
#include "app.h"

sc_status sc_agree_aloud(const sc_app *app, sc_status mine)
{
    const sc_status agreed = sc_comm_agree(app->comm, mine);

    if (mine == SC_ERR_MEMORY && sc_comm_rank(app->comm) > 0)
        return sc_fail(app->ctx, agreed, "out of memory");
    return agreed;
}

sc_status sc_broadcast_array(sc_app *app, void **array, size_t count, size_t size)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    void *mine = NULL;
    sc_status status = SC_OK;

    if (!first)
        status = sc_alloc(app->ctx, count, size, &mine);
    status = sc_comm_agree(app->comm, status);
    if (status == SC_OK && count)
        sc_comm_broadcast(app->comm, first ? *array : mine, count * size);
    if (status != SC_OK) {
        sc_free(mine);
        mine = NULL;
    }
    if (!first)
        *array = mine;
    return status;
}
