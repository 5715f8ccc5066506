/* SPDX-License-Identifier: BSD-3-Clause */
/* Begins and ends a farm: the shared window, the role of this rank, and the common return code. */
#include "internal.h"

enum { PAGE_BYTES = 4096 }; /* slots begin at pages of their own */

/* Put rank 0's window into memory that the ranks of its node share, if there is room and the farm
 * asks for it; otherwise pixels are sent as messages. @p out is set on all ranks, with pixels NULL
 * on other nodes. Collective; no failure is an error. @return the block, which the caller frees
 * after the farm (sc_shared_free), or NULL if nothing is shared, which is the same on all ranks. */
static sc_shared *share_slots(sc_comm *comm, const sc_farm *farm, sc_slots *out)
{
    const sc_work work = sc_farm_work(farm, comm);
    const size_t row_bytes = sc_farm_row_bytes(farm);
    const size_t stride =
        ((size_t)farm->height_px * row_bytes + PAGE_BYTES - 1) / PAGE_BYTES * PAGE_BYTES;
    const int window = sc_handout_begin(&work).window;
    const size_t bytes = sc_comm_is_near_root(comm) ? stride * (size_t)window : 0;
    const sc_ctx silent = {.rank = 0};
    sc_shared *shared = NULL;
    sc_status room;

    *out = (sc_slots){.stride = stride, .window = window};
    if (sc_comm_size(comm) == 1 || !farm->share_frames)
        return NULL;
    /* the other half of the node's shared memory stays free for the message layer */
    room = bytes > sc_machine_shared_room() / 2 ? SC_ERR_MEMORY : SC_OK;
    if (sc_comm_agree(comm, room) != SC_OK ||
        sc_shared_alloc(&silent, comm, bytes, NULL, &shared) != SC_OK)
        return NULL;
    if (sc_comm_is_near_root(comm))
        out->pixels = sc_shared_data(shared);
    return shared;
}

sc_status sc_farm_run(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm, sc_farm_times *times)
{
    const double begin_s = sc_wall_s();
    sc_slots slots;
    sc_shared *shared = share_slots(comm, farm, &slots);
    sc_status status;

    *times = (sc_farm_times){0};
    if (sc_comm_rank(comm) == 0)
        status = sc_farm_serve(ctx, comm, farm, &slots, times);
    else
        status = sc_farm_draw(ctx, comm, farm, &slots, times);
    status = sc_comm_agree(comm, status);
    sc_shared_free(shared);
    times->wall_s = sc_wall_s() - begin_s;
    return status;
}
