/* SPDX-License-Identifier: BSD-3-Clause */
/* The communicator over MPI; the only file that includes <mpi.h>.
 *
 * Ranks exchange messages only; one-sided communication is not used, because between nodes it fails
 * in widely used builds of MPI. The ranks of a node also share windows of memory. Waiting is a loop
 * of test and sleep: a blocking MPI call would spin on a core that the threads of other ranks need.
 * Errors of MPI are fatal (they end all ranks) except where a call is checked.
 *
 * The functions mpi_* are those of sc_comm_ops and of sc_shared: segcast/comm.h has their contract.
 */
#include "comm_ops.h"

#include <mpi.h>
#include <string.h>

typedef struct mpi_comm {
    sc_comm base;
    MPI_Comm world;        /* all ranks; a copy of MPI_COMM_WORLD, owned like the next two */
    MPI_Comm node;         /* the ranks of this node */
    MPI_Comm leaders;      /* the first rank of each node; MPI_COMM_NULL on the others */
    MPI_Request *requests; /* [request_capacity], owned: of posted messages that have not left */
    int request_count, request_capacity;
    sc_ctx silent; /* for an allocation whose failure is no error: see reserve_request */
} mpi_comm;

/* A block of memory that the ranks of a node share; base.data points into the window. */
typedef struct mpi_shared {
    sc_shared base;
    MPI_Win window;
} mpi_shared;

/* Large blocks are broadcast in pieces, several of which are under way at a time, so that a node
 * can pass on the first while it receives the next. */
enum { PIECE_BYTES = 4 << 20, PIECES = 4 };

enum { FIRST_REQUESTS = 64 }; /* posted messages that can be pending before the list has to grow */

/* Between two tests of a request a rank sleeps: first this long, then longer by a half each time.
 */
#define FIRST_NAP_S 20e-6
#define NAP_GROWTH 1.5
/* The longest sleep in a collective call, which ranks reach at different times, and in a receive,
 * where the fragments of a message follow each other quickly. */
#define COLLECTIVE_NAP_S 0.001
#define RECEIVE_NAP_S 200e-6

/* Block until @p request is complete, asleep between two tests for about @p longest_nap_s at most.
 * MPI frees the request. */
static void wait_asleep(MPI_Request *request, double longest_nap_s)
{
    double nap_s = FIRST_NAP_S;
    int done = 0;

    for (;;) {
        MPI_Test(request, &done, MPI_STATUS_IGNORE);
        if (done)
            return;
        sc_sleep_s(nap_s);
        nap_s = nap_s < longest_nap_s ? nap_s * NAP_GROWTH : nap_s;
    }
}

/* Copy @p bytes at @p data of rank 0 of @p comm to @p data of all its other ranks; blocks until
 * they are here. Collective in @p comm; any number of bytes. */
static void broadcast_in(MPI_Comm comm, char *data, size_t bytes)
{
    MPI_Request requests[PIECES];
    size_t piece = 0;

    for (size_t at = 0; at < bytes; at += PIECE_BYTES, piece++) {
        const size_t count = bytes - at < PIECE_BYTES ? bytes - at : PIECE_BYTES;
        MPI_Request *request = &requests[piece % PIECES];

        if (piece >= PIECES)
            wait_asleep(request, COLLECTIVE_NAP_S);
        MPI_Ibcast(data + at, (int)count, MPI_BYTE, 0, comm, request);
    }
    for (size_t i = piece > PIECES ? piece - PIECES : 0; i < piece; i++)
        wait_asleep(&requests[i % PIECES], COLLECTIVE_NAP_S);
}

static void mpi_broadcast(sc_comm *base, void *data, size_t bytes)
{
    broadcast_in(((mpi_comm *)base)->world, data, bytes);
}

/* Errors are negative, and the worst is the smallest: see sc_status. */
static sc_status mpi_agree(sc_comm *base, sc_status mine)
{
    mpi_comm *comm = (mpi_comm *)base;
    int local = mine, smallest = mine;
    MPI_Request request;

    MPI_Iallreduce(&local, &smallest, 1, MPI_INT, MPI_MIN, comm->world, &request);
    wait_asleep(&request, COLLECTIVE_NAP_S);
    return (sc_status)smallest;
}

/* Block until this rank's part has left; on rank 0, until all parts are in @p all. */
static void mpi_gather(sc_comm *base, const void *mine, size_t bytes, void *all)
{
    mpi_comm *comm = (mpi_comm *)base;
    MPI_Request request;

    MPI_Igather(mine, (int)bytes, MPI_BYTE, all, (int)bytes, MPI_BYTE, 0, comm->world, &request);
    wait_asleep(&request, COLLECTIVE_NAP_S);
}

/* Block until all ranks have called it. */
static void mpi_barrier(sc_comm *base)
{
    MPI_Request request;

    MPI_Ibarrier(((mpi_comm *)base)->world, &request);
    wait_asleep(&request, COLLECTIVE_NAP_S);
}

/* Free the block and its window. Collective among the ranks of a node, and blocks for them. */
static void mpi_unshare(sc_shared *base)
{
    mpi_shared *shared = (mpi_shared *)base;

    MPI_Win_free(&shared->window);
    sc_free(shared);
}

/* The first rank of each node allocates the whole block, the others nothing; then every rank asks
 * for the address of the first one's part. All ranks agree on the return code twice: before the
 * window is made, which is collective, and after it. */
static sc_status mpi_share(const sc_ctx *ctx, sc_comm *base, size_t bytes, sc_shared **out)
{
    mpi_comm *comm = (mpi_comm *)base;
    const MPI_Aint mine = base->node_rank == 0 ? (MPI_Aint)bytes : 0;
    MPI_Aint size;
    int unit;
    void *data = NULL, *block = NULL;
    mpi_shared *shared;
    sc_status status;

    status = mpi_agree(base, sc_zalloc(ctx, 1, sizeof(mpi_shared), &block));
    if (status != SC_OK) {
        sc_free(block);
        return status;
    }
    shared = block;
    MPI_Comm_set_errhandler(comm->node, MPI_ERRORS_RETURN);
    if (MPI_Win_allocate_shared(mine, 1, MPI_INFO_NULL, comm->node, &data, &shared->window))
        status =
            sc_fail(ctx, SC_ERR_MEMORY,
                    "%zu bytes of shared memory could not be had; is /dev/shm too small?", bytes);
    MPI_Comm_set_errhandler(comm->node, MPI_ERRORS_ARE_FATAL);
    status = mpi_agree(base, status);
    if (status != SC_OK) {
        sc_free(block);
        return status;
    }
    MPI_Win_shared_query(shared->window, 0, &size, &unit, &data);
    shared->base = (sc_shared){.data = data, .bytes = bytes, .free = mpi_unshare};
    *out = &shared->base;
    return SC_OK;
}

/* Copy the block between the first ranks of the nodes; the fence makes the bytes visible to the
 * other ranks of each node, and the barrier lets no rank continue before all may read. */
static void mpi_publish(sc_comm *base, sc_shared *shared)
{
    mpi_comm *comm = (mpi_comm *)base;

    if (comm->leaders != MPI_COMM_NULL)
        broadcast_in(comm->leaders, shared->data, shared->bytes);
    MPI_Win_fence(0, ((mpi_shared *)shared)->window);
    mpi_barrier(base);
}

/* Test all posted messages, which lets them progress, and remove the requests of those that have
 * left from the list. @return how many remain. */
static int mpi_pending(sc_comm *base)
{
    mpi_comm *comm = (mpi_comm *)base;

    for (int i = 0; i < comm->request_count;) {
        int done = 0;

        MPI_Test(&comm->requests[i], &done, MPI_STATUS_IGNORE);
        if (done)
            comm->requests[i] = comm->requests[--comm->request_count];
        else
            i++;
    }
    return comm->request_count;
}

/* Make room in the list for one more request, which blocks only without memory: where there is no
 * memory for a longer list, wait until a message has left: the other rank receives it without
 * waiting for this one, because it sends nothing that is too large to be buffered (see server.c).
 */
static void reserve_request(mpi_comm *comm)
{
    const int capacity = 2 * comm->request_capacity;
    void *grown;

    if (mpi_pending(&comm->base) < comm->request_capacity)
        return;
    if (sc_alloc(&comm->silent, (size_t)capacity, sizeof(MPI_Request), &grown) != SC_OK) {
        while (mpi_pending(&comm->base) == comm->request_capacity)
            sc_sleep_s(RECEIVE_NAP_S);
        return;
    }
    memcpy(grown, comm->requests, (size_t)comm->request_count * sizeof(MPI_Request));
    sc_free(comm->requests);
    comm->requests = grown;
    comm->request_capacity = capacity;
}

/* Start sending, and put the request at the end of the list. */
static void mpi_post(sc_comm *base, int target, int tag, const void *data, size_t bytes)
{
    mpi_comm *comm = (mpi_comm *)base;
    const int count = bytes <= INT32_MAX ? (int)bytes : -1; /* MPI refuses -1 and ends the job */

    reserve_request(comm);
    MPI_Isend(data, count, MPI_BYTE, target, tag, comm->world,
              &comm->requests[comm->request_count++]);
}

/* Block until all posted messages have left; the list is empty then. */
static void mpi_flush(sc_comm *base)
{
    mpi_comm *comm = (mpi_comm *)base;

    for (int i = 0; i < comm->request_count; i++)
        wait_asleep(&comm->requests[i], COLLECTIVE_NAP_S);
    comm->request_count = 0;
}

/* Test for a message without receiving it. MPI also makes progress in the call. */
static bool mpi_poll(sc_comm *base, sc_message *out)
{
    mpi_comm *comm = (mpi_comm *)base;
    MPI_Status status;
    int here = 0, bytes = 0;

    MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, comm->world, &here, &status);
    if (!here)
        return false;
    MPI_Get_count(&status, MPI_BYTE, &bytes);
    *out = (sc_message){.source = status.MPI_SOURCE, .tag = status.MPI_TAG, .bytes = (size_t)bytes};
    return true;
}

/* Receive the message that mpi_poll has described: the next one of this source and tag. */
static void mpi_receive(sc_comm *base, const sc_message *message, void *data)
{
    MPI_Request request;

    /* A large message arrives in fragments, which its sender sends only while it calls MPI. */
    MPI_Irecv(data, (int)message->bytes, MPI_BYTE, message->source, message->tag,
              ((mpi_comm *)base)->world, &request);
    wait_asleep(&request, RECEIVE_NAP_S);
}

/* Send what is posted, free everything, and end MPI. Collective. */
static void mpi_close(sc_comm *base)
{
    mpi_comm *comm = (mpi_comm *)base;

    mpi_flush(base);
    sc_free(comm->requests);
    if (comm->leaders != MPI_COMM_NULL)
        MPI_Comm_free(&comm->leaders);
    MPI_Comm_free(&comm->node);
    MPI_Comm_free(&comm->world);
    sc_free(comm);
    MPI_Finalize();
}

static const sc_comm_ops mpi_ops = {
    .close = mpi_close,
    .agree = mpi_agree,
    .broadcast = mpi_broadcast,
    .gather = mpi_gather,
    .share = mpi_share,
    .publish = mpi_publish,
    .post = mpi_post,
    .pending = mpi_pending,
    .flush = mpi_flush,
    .poll = mpi_poll,
    .receive = mpi_receive,
};

/* Set node, leaders and all numbers of comm->base from comm->world, which has to be there.
 * Collective. */
static void fill_ranks(mpi_comm *comm)
{
    int leader, nodes, root;

    MPI_Comm_rank(comm->world, &comm->base.rank);
    MPI_Comm_size(comm->world, &comm->base.size);
    MPI_Comm_split_type(comm->world, MPI_COMM_TYPE_SHARED, comm->base.rank, MPI_INFO_NULL,
                        &comm->node);
    MPI_Comm_rank(comm->node, &comm->base.node_rank);
    leader = comm->base.node_rank == 0;
    MPI_Comm_split(comm->world, leader ? 0 : MPI_UNDEFINED, comm->base.rank, &comm->leaders);
    MPI_Allreduce(&leader, &nodes, 1, MPI_INT, MPI_SUM, comm->world);
    /* The first rank of a node has its lowest number, which is 0 on the node of rank 0. */
    root = comm->base.rank;
    MPI_Bcast(&root, 1, MPI_INT, 0, comm->node);
    comm->base.near_root = root == 0;
    comm->base.node_count = nodes;
}

sc_status sc_comm_mpi_open(const sc_ctx *ctx, sc_comm **out)
{
    int granted;
    void *block = NULL, *requests = NULL;
    mpi_comm *comm;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, 1, sizeof(mpi_comm), &block));
    SC_TRY(sc_alloc(ctx, FIRST_REQUESTS, sizeof(MPI_Request), &requests));
    /* Funneled: only the main thread calls MPI. */
    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &granted)) {
        status = sc_fail(ctx, SC_ERR_INTERNAL, "MPI could not be started");
        goto out;
    }
    comm = block;
    comm->base.ops = &mpi_ops;
    comm->requests = requests;
    comm->request_capacity = FIRST_REQUESTS;
    comm->silent.alloc_budget = ctx->alloc_budget;
    MPI_Comm_dup(MPI_COMM_WORLD, &comm->world);
    fill_ranks(comm);
    *out = &comm->base;
    return SC_OK;
out:
    sc_free(requests);
    sc_free(block);
    return status;
}

void sc_comm_mpi_library(char *text, size_t size)
{
    char version[MPI_MAX_LIBRARY_VERSION_STRING];
    int length;

    MPI_Get_library_version(version, &length);
    snprintf(text, size, "%.*s", (int)strcspn(version, ",\n"), version);
}
