/* SPDX-License-Identifier: BSD-3-Clause */
/* mpirun -n 3 test_parts: parts of a communicator hold the right ranks, work while the other ranks
 * wait, and can be closed one after the other while the whole goes on. */
#include "segcast/comm.h"

/* On the chosen ranks: send a number from rank 0 to all, and agree. @return what is wrong, or 0. */
static int use(sc_comm *part, int count)
{
    int number = sc_comm_rank(part) == 0 ? 41 + count : 0;

    if (sc_comm_size(part) != count || sc_comm_node_count(part) != 1)
        return 1;
    sc_comm_broadcast(part, &number, sizeof number);
    if (number != 41 + count)
        return 2;
    return sc_comm_agree(part, sc_comm_rank(part) == count - 1 ? SC_ERR_DATA : SC_OK) != SC_ERR_DATA
               ? 3
               : 0;
}

/* Make and use one part. @return what is wrong with it on this rank, or 0. */
static int try_part(const sc_ctx *ctx, sc_comm *comm, int count, sc_comm_choice choice)
{
    sc_comm *part = NULL;
    int wrong = 0;

    if (sc_comm_part(ctx, comm, count, choice, &part) != SC_OK)
        return 4;
    if ((part != NULL) != (sc_comm_rank(comm) < count))
        wrong = 5;
    else if (part && sc_comm_rank(part) != sc_comm_rank(comm))
        wrong = 6;
    else if (part)
        wrong = use(part, count);
    sc_comm_close(part);
    return wrong;
}

int main(void)
{
    long budget = 1000;
    const sc_ctx ctx = {.write = sc_log_to_stderr, .alloc_budget = &budget};
    sc_comm *comm, *part;
    int wrong = 0;

    if (sc_comm_open(&ctx, true, &comm) != SC_OK || sc_comm_size(comm) != 3)
        return 70;
    for (int count = 1; count <= 3 && !wrong; count++) {
        wrong = try_part(&ctx, comm, count, SC_COMM_PACKED);
        if (!wrong)
            wrong = try_part(&ctx, comm, count, SC_COMM_SPREAD);
    }
    /* One rank without memory: all are told, and none waits. */
    if (sc_comm_rank(comm) == 2)
        budget = 0;
    if (!wrong && sc_comm_part(&ctx, comm, 2, SC_COMM_PACKED, &part) != SC_ERR_MEMORY)
        wrong = 7;
    if (sc_comm_agree(comm, wrong ? SC_ERR_INTERNAL : SC_OK) != SC_OK && !wrong)
        wrong = 8;
    sc_comm_close(comm);
    return wrong;
}
