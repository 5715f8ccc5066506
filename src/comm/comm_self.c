/* SPDX-License-Identifier: BSD-3-Clause */
/* The communicator of a single process: it never waits, and no message is ever sent or received.
 * The functions self_* are those of sc_comm_ops; where there is no other rank to deal with they do
 * nothing. */
#include "comm_ops.h"
#include "shared_file.h"

#include <errno.h>
#include <sys/mman.h>
#include <unistd.h>

static void self_close(sc_comm *comm)
{
    sc_free(comm);
}

/* The only rank is the whole of any part. */
static sc_status self_part(const sc_ctx *ctx, sc_comm *comm, int count, sc_comm_choice choice,
                           sc_comm **out)
{
    return sc_comm_self_open(ctx, out);
}

static sc_status self_agree(sc_comm *comm, sc_status mine)
{
    return mine;
}

static void self_broadcast(sc_comm *comm, void *data, size_t bytes)
{
}

/* The only rank is rank 0, so that @p all is never NULL. */
static void self_gather(sc_comm *comm, const void *mine, size_t bytes, void *all)
{
    memcpy(all, mine, bytes);
}

static void self_nothing(sc_comm *comm)
{
}

static void self_unshare(sc_shared *shared)
{
    sc_free(shared->data);
    sc_free(shared);
}

static void self_unmap(sc_shared *shared)
{
    munmap(shared->data, shared->bytes);
    sc_free(shared);
}

/* Map a file without a name in @p folder. @param error set to the errno after an error. @return
 * SC_ERR_MEMORY, SC_ERR_CREATE, not logged. Caller owns *out: munmap. */
static sc_status map_file(const char *folder, size_t bytes, void **out, int *error)
{
    sc_shared_name name;
    int file;
    sc_status status = sc_shared_file_make(folder, bytes, 0, &name, &file);

    if (status != SC_OK) {
        *error = errno;
        return status;
    }
    sc_shared_file_remove(&name);
    status = sc_shared_file_reserve(file, bytes);
    if (status == SC_OK)
        status = sc_shared_file_map(file, bytes, out);
    if (status != SC_OK)
        *error = errno;
    close(file);
    return status;
}

/* Allocate the block from the heap, zeroed; self_unshare frees it. Or from a file, if that is
 * preferred; then self_unmap does. */
static sc_status self_share(const sc_ctx *ctx, sc_comm *comm, size_t bytes, const char *folder,
                            sc_shared **out)
{
    void *block, *data = NULL;
    int error = 0;
    sc_status status = sc_zalloc(ctx, 1, sizeof(sc_shared), &block);
    sc_shared *shared = block;

    if (status != SC_OK)
        return status;
    if (comm->prefers_files && folder && bytes && map_file(folder, bytes, &data, &error) == SC_OK) {
        *shared = (sc_shared){
            .data = data, .bytes = bytes, .place = SC_SHARED_IN_FILE, .free = self_unmap};
        *out = shared;
        return SC_OK;
    }
    status = sc_zalloc(ctx, bytes, 1, &data);
    if (status != SC_OK) {
        sc_free(shared);
        return status;
    }
    *shared = (sc_shared){.data = data, .bytes = bytes, .file_error = error, .free = self_unshare};
    *out = shared;
    return SC_OK;
}

static void self_publish(sc_comm *comm, sc_shared *shared)
{
}

/* There is no rank to send to. */
static void self_post(sc_comm *comm, int target, int tag, const void *data, size_t bytes)
{
}

static int self_pending(sc_comm *comm)
{
    return 0;
}

/* Find no message: there is nobody who could send one, so that self_receive is never called. */
static bool self_has_room(const sc_comm *comm, uint64_t bytes)
{
    return true;
}

static bool self_poll(sc_comm *comm, sc_message *out)
{
    return false;
}

static void self_receive(sc_comm *comm, const sc_message *message, void *data)
{
}

static const sc_comm_ops self_ops = {
    .close = self_close,
    .part = self_part,
    .agree = self_agree,
    .broadcast = self_broadcast,
    .gather = self_gather,
    .share = self_share,
    .publish = self_publish,
    .node_agree = self_agree,
    .node_share = self_share,
    .has_room = self_has_room,
    .post = self_post,
    .pending = self_pending,
    .flush = self_nothing,
    .poll = self_poll,
    .receive = self_receive,
};

sc_status sc_comm_self_open(const sc_ctx *ctx, sc_comm **out)
{
    SC_PASS(SC_ZALLOC(ctx, 1, out));
    **out =
        (sc_comm){.ops = &self_ops, .size = 1, .node_size = 1, .node_count = 1, .near_root = true};
    return SC_OK;
}
