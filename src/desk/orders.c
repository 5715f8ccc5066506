/* SPDX-License-Identifier: BSD-3-Clause */
#include "desk.h"

void sc_desk_tell(const sc_desk *desk, const sc_order *order)
{
    sc_comm *comm = desk->app.comm;

    for (int rank = 1; rank < sc_comm_size(comm) && sc_comm_rank(comm) == 0; rank++)
        sc_comm_post(comm, rank, SC_TAG_ORDER, order, sizeof *order);
    sc_comm_flush(comm);
}
