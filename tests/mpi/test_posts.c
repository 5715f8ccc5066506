/* SPDX-License-Identifier: BSD-3-Clause */
/* mpirun -n 2 test_posts: rank 1 posts more messages than its list of requests has room for, while
 * no allocation succeeds any more. All of them must arrive, in order. */
#include "segcast/comm.h"

#include <stdlib.h>
#include <string.h>

enum { MESSAGES = 300, MESSAGE_BYTES = 1 << 18 }; /* so large that each waits for its receiver */

static int post_all(sc_comm *comm, long *budget)
{
    char *buffers = malloc((size_t)MESSAGES * MESSAGE_BYTES);

    *budget = 0;
    for (int i = 0; i < MESSAGES; i++) {
        memset(buffers + (size_t)i * MESSAGE_BYTES, i, MESSAGE_BYTES);
        sc_comm_post(comm, 0, i, buffers + (size_t)i * MESSAGE_BYTES, MESSAGE_BYTES);
    }
    sc_comm_flush(comm);
    free(buffers);
    return 0;
}

static int receive_all(sc_comm *comm)
{
    unsigned char *data = malloc(MESSAGE_BYTES);
    sc_message message;
    int wrong = 0;

    sc_sleep_s(0.2); /* let messages pile up */
    for (int i = 0; i < MESSAGES; i++) {
        while (!sc_comm_poll(comm, &message))
            sc_sleep_s(20e-6);
        sc_comm_receive(comm, &message, data);
        wrong += message.tag != i || data[0] != (i & 255) || data[MESSAGE_BYTES - 1] != (i & 255);
    }
    free(data);
    return wrong != 0;
}

int main(void)
{
    long budget = 1000;
    const sc_ctx ctx = {.write = sc_log_to_stderr, .alloc_budget = &budget};
    sc_comm *comm;
    int code;

    if (sc_comm_open(&ctx, true, &comm) != SC_OK || sc_comm_size(comm) != 2)
        return 70;
    code = sc_comm_rank(comm) == 0 ? receive_all(comm) : post_all(comm, &budget);
    sc_comm_close(comm);
    return code;
}
