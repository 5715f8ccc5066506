/* SPDX-License-Identifier: BSD-3-Clause */
/* The communicator over MPI; the only file that includes <mpi.h>.
 *
 * Ranks exchange messages only; one-sided communication is not used, because between nodes it fails
 * in widely used builds of MPI. The ranks of a node also share memory. That is a file which they
 * all map, and no window of MPI: where there is no room for a window, some ranks never come back
 * from making it. Waiting is a loop of test and sleep: a blocking MPI call would spin on a core
 * that the threads of other ranks need. Errors of MPI are fatal: they end all ranks.
 *
 * The functions mpi_* are those of sc_comm_ops and of sc_shared: segcast/comm.h has their contract.
 */
#include "comm_ops.h"
#include "shared_file.h"

#include <errno.h>
#include <mpi.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

typedef struct mpi_comm {
    sc_comm base;
    MPI_Comm world;        /* all ranks; a copy of MPI_COMM_WORLD, owned like the next two */
    MPI_Comm node;         /* the ranks of this node */
    MPI_Comm leaders;      /* the first rank of each node; MPI_COMM_NULL on the others */
    MPI_Request *requests; /* [request_capacity], owned: of posted messages that have not left */
    int request_count, request_capacity;
    bool is_part;  /* of another communicator: MPI goes on when it is closed */
    sc_ctx silent; /* for an allocation whose failure is no error: see reserve_request */
} mpi_comm;

/* Where the files are made that the ranks of a node map, if there is room: files in memory. What
 * stays free there is for the message layer, which puts memory of its own there and is killed by
 * the system if it finds no room when it first writes to it. */
#define SHARED_MEMORY "/dev/shm"
enum { SPARE_BYTES = 64 << 20, SPARE_BYTES_PER_RANK = 16 << 20 };

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

/* @return the smallest return code of the ranks of @p comm; blocks until all have called it. Errors
 * are negative, and the worst is the smallest: see sc_status. Collective in @p comm. */
static sc_status agree_in(MPI_Comm comm, sc_status mine)
{
    int local = mine, smallest = mine;
    MPI_Request request;

    MPI_Iallreduce(&local, &smallest, 1, MPI_INT, MPI_MIN, comm, &request);
    wait_asleep(&request, COLLECTIVE_NAP_S);
    return (sc_status)smallest;
}

static sc_status mpi_agree(sc_comm *base, sc_status mine)
{
    return agree_in(((mpi_comm *)base)->world, mine);
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

/* ---- memory that the ranks of a node share ---- */

/* Free this rank's mapping or copy, and @p shared. Local. */
static void mpi_unshare(sc_shared *shared)
{
    if (shared->place == SC_SHARED_COPIED)
        sc_free(shared->data);
    else if (shared->data)
        munmap(shared->data, shared->bytes);
    sc_free(shared);
}

/* Note errno in *error after a function that has failed. @return what it has returned. */
static sc_status note(sc_status status, int *error)
{
    if (status != SC_OK)
        *error = errno;
    return status;
}

/* Make a file in @p folder and map it on all ranks of the node: the first of them makes it, and
 * removes its name when all have opened it, so that nothing is left behind whatever happens later.
 * It gets its room only then, and before anybody writes to it: without it, writing would kill.
 * Collective in comm->node, where all get the same return code; nothing is mapped after an error.
 * @param spare_bytes must stay free in @p folder. @param error set to the errno on those ranks that
 * have failed. @return SC_ERR_MEMORY, SC_ERR_CREATE, or SC_ERR_MISSING if the ranks do not see the
 * same folder. Caller owns *out: munmap. */
static sc_status map_file(mpi_comm *comm, const char *folder, size_t bytes, size_t spare_bytes,
                          void **out, int *error)
{
    const bool first = comm->base.node_rank == 0;
    struct {
        sc_shared_name name;
        int32_t status;
    } made = {.status = SC_OK};
    int file = -1;
    void *data = NULL;
    sc_status status;

    if (first)
        made.status =
            note(sc_shared_file_make(folder, bytes, spare_bytes, &made.name, &file), error);
    broadcast_in(comm->node, (char *)&made, sizeof made);
    if (made.status != SC_OK)
        return (sc_status)made.status;
    SC_TRY(
        agree_in(comm->node, first ? SC_OK : note(sc_shared_file_open(&made.name, &file), error)));
    if (first) {
        sc_shared_file_remove(&made.name);
        status = note(sc_shared_file_reserve(file, bytes), error);
    }
    SC_TRY(agree_in(comm->node, status));
    status = agree_in(comm->node, note(sc_shared_file_map(file, bytes, &data), error));
    if (status == SC_OK)
        *out = data;
    else if (data)
        munmap(data, bytes);
out:
    if (first && status != SC_OK)
        sc_shared_file_remove(&made.name);
    if (file >= 0)
        close(file);
    return status;
}

/* @return what must stay free in SHARED_MEMORY. */
static size_t spare_bytes_of(const sc_comm *comm)
{
    return SPARE_BYTES + (size_t)comm->node_size * (size_t)SPARE_BYTES_PER_RANK;
}

/* Find room for shared->bytes that the ranks of this node really share, in memory or as a file in
 * @p folder if it is not NULL, first in that which is preferred. Sets data and place. Collective in
 * comm->node, where all get the same result. @return SC_ERR_MEMORY, not logged. */
static sc_status find_common_place(mpi_comm *comm, const char *folder, sc_shared *shared)
{
    const size_t spare_bytes = spare_bytes_of(&comm->base);
    int unused;

    shared->place = SC_SHARED_IN_FILE;
    if (folder && comm->base.prefers_files &&
        map_file(comm, folder, shared->bytes, 0, &shared->data, &shared->file_error) == SC_OK)
        return SC_OK;
    shared->place = SC_SHARED_IN_MEMORY;
    if (map_file(comm, SHARED_MEMORY, shared->bytes, spare_bytes, &shared->data, &unused) == SC_OK)
        return SC_OK;
    shared->place = SC_SHARED_IN_FILE;
    if (folder && !comm->base.prefers_files &&
        map_file(comm, folder, shared->bytes, 0, &shared->data, &unused) == SC_OK)
        return SC_OK;
    return SC_ERR_MEMORY;
}

/* As find_common_place; where there is no such place and @p folder is not NULL, every rank gets a
 * copy. */
static sc_status find_place(mpi_comm *comm, const char *folder, sc_shared *shared)
{
    if (shared->bytes == 0)
        return SC_OK;
    if (find_common_place(comm, folder, shared) == SC_OK)
        return SC_OK;
    if (!folder)
        return SC_ERR_MEMORY;
    shared->place = SC_SHARED_COPIED;
    return agree_in(comm->node, sc_alloc(&comm->silent, shared->bytes, 1, &shared->data));
}

/* All ranks agree on the return code twice, so that none waits for one that has failed; between
 * the two only the ranks of a node deal with each other. */
static sc_status mpi_share(const sc_ctx *ctx, sc_comm *base, size_t bytes, const char *folder,
                           sc_shared **out)
{
    sc_shared *shared = NULL;
    sc_status status = mpi_agree(base, SC_ZALLOC(ctx, 1, &shared));

    if (status != SC_OK) {
        sc_free(shared);
        return status;
    }
    *shared = (sc_shared){.bytes = bytes, .free = mpi_unshare};
    status = mpi_agree(base, find_place((mpi_comm *)base, folder, shared));
    if (status != SC_OK) {
        mpi_unshare(shared);
        return base->rank > 0
                   ? status
                   : sc_fail(ctx, status,
                             "there is no room for %zu bytes that the ranks of a node share, "
                             "neither in " SHARED_MEMORY
                             " nor in %s nor in the memory of every rank; use fewer ranks per node",
                             bytes, folder ? folder : "a directory");
    }
    *out = shared;
    return SC_OK;
}

static sc_status mpi_node_agree(sc_comm *base, sc_status mine)
{
    sc_status status;

    __atomic_thread_fence(__ATOMIC_SEQ_CST);
    status = agree_in(((mpi_comm *)base)->node, mine);
    __atomic_thread_fence(__ATOMIC_SEQ_CST);
    return status;
}

static sc_status mpi_node_share(const sc_ctx *ctx, sc_comm *base, size_t bytes, const char *folder,
                                sc_shared **out)
{
    mpi_comm *comm = (mpi_comm *)base;
    sc_shared *shared = NULL;
    sc_status status = agree_in(comm->node, SC_ZALLOC(ctx, 1, &shared));

    if (status == SC_OK) {
        *shared = (sc_shared){.bytes = bytes, .free = mpi_unshare};
        status = find_common_place(comm, folder, shared);
    }
    if (status == SC_OK)
        *out = shared;
    else
        sc_free(shared);
    return status;
}

static bool mpi_has_room(const sc_comm *comm, uint64_t bytes)
{
    return bytes <= SIZE_MAX &&
           sc_shared_folder_has_room(SHARED_MEMORY, (size_t)bytes, spare_bytes_of(comm));
}

/* Copy the block between the first ranks of the nodes, and where every rank has a copy, from the
 * first rank to the others. The fence and the barrier let no rank continue before it may read. */
static void mpi_publish(sc_comm *base, sc_shared *shared)
{
    mpi_comm *comm = (mpi_comm *)base;

    if (comm->leaders != MPI_COMM_NULL)
        broadcast_in(comm->leaders, shared->data, shared->bytes);
    if (shared->place == SC_SHARED_COPIED)
        broadcast_in(comm->node, shared->data, shared->bytes);
    __atomic_thread_fence(__ATOMIC_SEQ_CST);
    mpi_barrier(base);
    __atomic_thread_fence(__ATOMIC_SEQ_CST);
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

    if (mpi_pending(&comm->base) < comm->request_capacity)
        return;
    if (SC_RESIZE(&comm->silent, (size_t)comm->request_count, (size_t)capacity, &comm->requests) !=
        SC_OK) {
        while (mpi_pending(&comm->base) == comm->request_capacity)
            sc_sleep_s(RECEIVE_NAP_S);
        return;
    }
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

/* Send what is posted, free everything, and end MPI unless this is a part. Collective. */
static void mpi_close(sc_comm *base)
{
    mpi_comm *comm = (mpi_comm *)base;
    const bool is_part = comm->is_part;

    mpi_flush(base);
    sc_free(comm->requests);
    if (comm->leaders != MPI_COMM_NULL)
        MPI_Comm_free(&comm->leaders);
    MPI_Comm_free(&comm->node);
    MPI_Comm_free(&comm->world);
    sc_free(comm);
    if (!is_part)
        MPI_Finalize();
}

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
    MPI_Comm_size(comm->node, &comm->base.node_size);
    leader = comm->base.node_rank == 0;
    MPI_Comm_split(comm->world, leader ? 0 : MPI_UNDEFINED, comm->base.rank, &comm->leaders);
    MPI_Allreduce(&leader, &nodes, 1, MPI_INT, MPI_SUM, comm->world);
    /* The first rank of a node has its lowest number, which is 0 on the node of rank 0. */
    root = comm->base.rank;
    MPI_Bcast(&root, 1, MPI_INT, 0, comm->node);
    comm->base.near_root = root == 0;
    comm->base.node_count = nodes;
}

static const sc_comm_ops mpi_ops;

/* Allocate a communicator without ranks. @param out what fill_ranks fills; freed by drop. */
static sc_status allocate(const sc_ctx *ctx, mpi_comm **out)
{
    SC_OWN(sc_free_at) mpi_comm *comm = NULL;

    SC_PASS(SC_ZALLOC(ctx, 1, &comm));
    SC_PASS(sc_alloc(ctx, FIRST_REQUESTS, sizeof(MPI_Request), &comm->requests));
    comm->base.ops = &mpi_ops;
    comm->request_capacity = FIRST_REQUESTS;
    comm->silent.alloc_budget = ctx->alloc_budget;
    SC_HAND_OVER(comm, out);
    return SC_OK;
}

/* Free what allocate has given. NULL is allowed. */
static void drop(mpi_comm *comm)
{
    if (comm)
        sc_free(comm->requests);
    sc_free(comm);
}

/* @return this rank's place in the order in which sc_comm_part chooses ranks. @param places room
 * for two numbers of each rank. Collective. */
static int place_of(const mpi_comm *comm, sc_comm_choice choice, int *places)
{
    int mine[2] = {comm->base.node_rank, comm->base.rank}, place = 0;

    /* All ranks of a node know it by the number of its first rank. */
    MPI_Bcast(&mine[1], 1, MPI_INT, 0, comm->node);
    MPI_Allgather(mine, 2, MPI_INT, places, 2, MPI_INT, comm->world);
    if (choice == SC_COMM_PACKED)
        return comm->base.rank;
    for (int i = 0; i < comm->base.size; i++) {
        const int *other = places + (ptrdiff_t)2 * i;

        place += other[0] < mine[0] || (other[0] == mine[0] && other[1] < mine[1]);
    }
    return place;
}

static sc_status mpi_part(const sc_ctx *ctx, sc_comm *base, int count, sc_comm_choice choice,
                          sc_comm **out)
{
    mpi_comm *whole = (mpi_comm *)base, *comm = NULL;
    void *places = NULL;
    int place;
    bool chosen;
    sc_status status = allocate(ctx, &comm);

    if (status == SC_OK)
        status = sc_alloc(ctx, (size_t)base->size, 2 * sizeof(int), &places);
    SC_TRY(mpi_agree(base, status));
    place = place_of(whole, choice, places);
    chosen = place < count;
    MPI_Comm_split(whole->world, chosen ? 0 : MPI_UNDEFINED, place, &comm->world);
    *out = NULL;
    if (chosen) {
        comm->is_part = true;
        fill_ranks(comm);
        *out = &comm->base;
        comm = NULL;
    }
out:
    drop(comm);
    sc_free(places);
    return status;
}

static const sc_comm_ops mpi_ops = {
    .close = mpi_close,
    .part = mpi_part,
    .agree = mpi_agree,
    .broadcast = mpi_broadcast,
    .gather = mpi_gather,
    .share = mpi_share,
    .publish = mpi_publish,
    .node_agree = mpi_node_agree,
    .node_share = mpi_node_share,
    .has_room = mpi_has_room,
    .post = mpi_post,
    .pending = mpi_pending,
    .flush = mpi_flush,
    .poll = mpi_poll,
    .receive = mpi_receive,
};

sc_status sc_comm_mpi_open(const sc_ctx *ctx, sc_comm **out)
{
    int granted, mine, smallest;
    mpi_comm *comm = NULL;
    sc_status status;

    /* MPI asks hwloc for the topology of the machine, and hwloc's plug-in for graphics cards looks
     * for displays of X, on the host "localhost" too: without /etc/hosts that takes the 5 seconds
     * after which a name server is given up. */
    setenv("HWLOC_COMPONENTS", "-gl", 0);
    /* Funneled: only the main thread calls MPI. */
    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &granted))
        return sc_fail(ctx, SC_ERR_INTERNAL, "MPI could not be started");
    status = allocate(ctx, &comm);
    /* A rank without memory must not leave the others waiting for it. */
    mine = status;
    MPI_Allreduce(&mine, &smallest, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    if (smallest != SC_OK) {
        drop(comm);
        MPI_Finalize();
        return (sc_status)smallest;
    }
    MPI_Comm_dup(MPI_COMM_WORLD, &comm->world);
    fill_ranks(comm);
    *out = &comm->base;
    return SC_OK;
}

void sc_comm_mpi_library(char *text, size_t size)
{
    char version[MPI_MAX_LIBRARY_VERSION_STRING];
    int length;

    MPI_Get_library_version(version, &length);
    snprintf(text, size, "%.*s", (int)strcspn(version, ",\n"), version);
}
