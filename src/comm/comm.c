/* SPDX-License-Identifier: BSD-3-Clause */
#include "comm_ops.h"
#include "shared_file.h"

sc_status sc_comm_open(const sc_ctx *ctx, bool launched, sc_comm **out)
{
#if SC_HAVE_MPI
    if (launched)
        return sc_comm_mpi_open(ctx, out);
#else
    if (launched)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "started by an MPI launcher, but this segcast was built without MPI");
#endif
    return sc_comm_self_open(ctx, out);
}

void sc_comm_library(char *text, size_t size)
{
#if SC_HAVE_MPI
    sc_comm_mpi_library(text, size);
#else
    snprintf(text, size, "none");
#endif
}

void sc_comm_close(sc_comm *comm)
{
    if (comm)
        comm->ops->close(comm);
}

sc_status sc_comm_part(const sc_ctx *ctx, sc_comm *comm, int count, sc_comm_choice choice,
                       sc_comm **out)
{
    return comm->ops->part(ctx, comm, count, choice, out);
}

int sc_comm_rank(const sc_comm *comm)
{
    return comm->rank;
}

int sc_comm_size(const sc_comm *comm)
{
    return comm->size;
}

int sc_comm_node_count(const sc_comm *comm)
{
    return comm->node_count;
}

bool sc_comm_is_near_root(const sc_comm *comm)
{
    return comm->near_root;
}

sc_status sc_comm_agree(sc_comm *comm, sc_status mine)
{
    return comm->ops->agree(comm, mine);
}

void sc_comm_broadcast(sc_comm *comm, void *data, size_t bytes)
{
    comm->ops->broadcast(comm, data, bytes);
}

sc_status sc_comm_gather(const sc_ctx *ctx, sc_comm *comm, const void *mine, size_t bytes,
                         void *all)
{
    void *array = NULL;
    sc_status status = SC_OK;

    if (comm->rank == 0)
        status = sc_alloc(ctx, (size_t)comm->size, bytes, &array);
    status = sc_comm_agree(comm, status);
    if (status == SC_OK) {
        comm->ops->gather(comm, mine, bytes, array);
    } else {
        sc_free(array);
        array = NULL;
    }
    memcpy(all, &array, sizeof array); /* pointers of all types are alike: POSIX */
    return status;
}

sc_status sc_shared_alloc(const sc_ctx *ctx, sc_comm *comm, size_t bytes, const char *folder,
                          sc_shared **out)
{
    return comm->ops->share(ctx, comm, bytes, folder, out);
}

void sc_comm_prefer_files(sc_comm *comm, bool prefers)
{
    comm->prefers_files = prefers;
}

sc_shared_place sc_shared_place_of(const sc_shared *shared)
{
    return shared->place;
}

int sc_shared_file_error(const sc_shared *shared)
{
    return shared->file_error;
}

void sc_shared_advise(sc_shared *shared, sc_memory_use use)
{
    if (shared->place == SC_SHARED_IN_FILE)
        sc_file_advise(shared->data, shared->bytes, use);
}

sc_status sc_comm_agree_room(sc_comm *comm, const char *folder, uint64_t bytes)
{
    const bool fits = bytes <= SIZE_MAX && sc_shared_folder_has_room(folder, (size_t)bytes, 0);

    return sc_comm_agree(comm, comm->node_rank > 0 || fits ? SC_OK : SC_ERR_MEMORY);
}

void *sc_shared_data(const sc_shared *shared)
{
    return shared->data;
}

void sc_shared_publish(sc_comm *comm, sc_shared *shared)
{
    comm->ops->publish(comm, shared);
}

void sc_shared_free(sc_shared *shared)
{
    if (shared)
        shared->free(shared);
}

void sc_comm_post(sc_comm *comm, int target, int tag, const void *data, size_t bytes)
{
    comm->ops->post(comm, target, tag, data, bytes);
}

int sc_comm_pending(sc_comm *comm)
{
    return comm->ops->pending(comm);
}

void sc_comm_flush(sc_comm *comm)
{
    comm->ops->flush(comm);
}

bool sc_comm_poll(sc_comm *comm, sc_message *out)
{
    return comm->ops->poll(comm, out);
}

void sc_comm_receive(sc_comm *comm, const sc_message *message, void *data)
{
    comm->ops->receive(comm, message, data);
}
