/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Floor 1: the group of processes that does one job, as a table of functions. Two exist: MPI
 *  (comm_mpi.c, the only file that includes <mpi.h>) and a single process (comm_self.c).
 *
 *  Every function is called from the main thread only. "Collective" means: by all ranks, in the
 *  same order. Waiting ranks sleep instead of spinning, so that they take nothing from the cores
 *  that others compute on. An error of the message layer itself ends all ranks of the job.
 */
#ifndef SEGCAST_COMM_H
#define SEGCAST_COMM_H

#include "segcast/base.h"

typedef struct sc_comm sc_comm;
typedef struct sc_shared sc_shared;

/** A message that has arrived and can be received without waiting. */
typedef struct sc_message {
    int source, tag;
    size_t bytes;
} sc_message;

/** Join the group. @p launched: this process was started by an MPI launcher; otherwise, and in a
 *  build without MPI, it is alone. Collective. Caller owns: sc_comm_close. */
SC_MUST_USE sc_status sc_comm_open(const sc_ctx *ctx, bool launched, sc_comm **out);
/** Leave the group. Collective. */
void sc_comm_close(sc_comm *comm);

int sc_comm_rank(const sc_comm *comm);
int sc_comm_size(const sc_comm *comm);
int sc_comm_node_count(const sc_comm *comm);
/** Is this rank on the node of rank 0, so that blocks of sc_shared_alloc are common to both? */
bool sc_comm_is_near_root(const sc_comm *comm);
/** Name and version of the message layer into @p text; callable before sc_comm_open. */
void sc_comm_library(char *text, size_t size);

/** All ranks get the smallest status of all. Collective. */
SC_MUST_USE sc_status sc_comm_agree(sc_comm *comm, sc_status mine);
/** Copy @p bytes from rank 0 to all. Collective. */
void sc_comm_broadcast(sc_comm *comm, void *data, size_t bytes);
/** @p bytes of every rank, in rank order, to @p all on rank 0 (NULL elsewhere). Collective. */
void sc_comm_gather(sc_comm *comm, const void *mine, size_t bytes, void *all);

/** One block of memory per node, the same for all its ranks; not initialised. Collective;
 *  all ranks of a node name the same size, all ranks get the same status. Caller owns:
 *  sc_shared_free. */
SC_MUST_USE sc_status sc_shared_alloc(const sc_ctx *ctx, sc_comm *comm, size_t bytes,
                                      sc_shared **out);
/** The block as seen by this rank. */
void *sc_shared_data(const sc_shared *shared);
/** Copy rank 0's block to every node's; returns when all may read. Collective. */
void sc_shared_publish(sc_comm *comm, sc_shared *shared);
/** Collective; NULL is allowed (on all ranks). */
void sc_shared_free(sc_shared *shared);

/** Start sending @p bytes, at most INT32_MAX; @p data stays borrowed until the message has left
 *  (sc_comm_pending, sc_comm_flush). Cannot fail, so that no rank waits for a message that was
 * never sent. Returns at once, except that without memory to keep track of one more message it
 * waits until an earlier one has left. */
void sc_comm_post(sc_comm *comm, int target, int tag, const void *data, size_t bytes);
/** How many posted messages still need their buffers; also moves them along. */
int sc_comm_pending(sc_comm *comm);
/** Wait until everything posted has left its buffers. */
void sc_comm_flush(sc_comm *comm);
/** Look for a message. @return false if none is here now. */
bool sc_comm_poll(sc_comm *comm, sc_message *out);
/** Receive the message that sc_comm_poll announced. */
void sc_comm_receive(sc_comm *comm, const sc_message *message, void *data);

#endif
