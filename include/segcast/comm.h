/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  The communicator: the ranks that do a job together, and what they can send each other. There are
 *  two implementations: MPI (comm_mpi.c, the only file that includes <mpi.h>) and a single process
 *  (comm_self.c).
 *
 *  All functions but sc_comm_library are called from the main thread of a rank only. "Collective"
 * means: called by all ranks, in the same order; a collective function may block until all have
 * called it. A rank that waits sleeps between two tests instead of spinning, so that the cores stay
 * free for threads that compute. An error within the message layer itself (a lost connection, a
 * killed rank) ends all ranks. */
#ifndef SEGCAST_COMM_H
#define SEGCAST_COMM_H

#include "segcast/base.h"

/** A communicator, as one rank sees it. */
typedef struct sc_comm sc_comm;
/** A block of memory that the ranks of a node share. */
typedef struct sc_shared sc_shared;

/** A message that has arrived and can be received without waiting. */
typedef struct sc_message {
    int source, tag; /**< the rank that has posted it, and the tag it gave */
    size_t bytes;
} sc_message;

/** Open the communicator of all ranks. Collective. @param launched whether an MPI launcher has
 *  started this process; if not, it is the only rank. @return SC_ERR_USAGE for a launched process
 * in a build without MPI, SC_ERR_MEMORY, SC_ERR_INTERNAL. @p ctx is borrowed for the communicator's
 *  life. Caller owns *out: sc_comm_close. */
SC_MUST_USE sc_status sc_comm_open(const sc_ctx *ctx, bool launched, sc_comm **out);
/** Wait until all posted messages have left, leave the communicator and free it; the communicator
 * of sc_comm_open with MPI also ends MPI. Collective. NULL is allowed. */
void sc_comm_close(sc_comm *comm);

/** Which ranks sc_comm_part takes. */
typedef enum sc_comm_choice {
    SC_COMM_PACKED, /**< the first ones, which launchers put on as few nodes as possible */
    SC_COMM_SPREAD  /**< the first rank of each node, then the second of each, and so on */
} sc_comm_choice;
/** Open a communicator of @p count of the ranks of @p comm, 1 to its size; rank 0 is among them and
 *  has the number 0 there, too. Collective in @p comm. @param out on ranks that are not chosen:
 *  NULL. @return on all ranks the same: SC_ERR_MEMORY. Caller owns *out: sc_comm_close, before
 *  @p comm is closed, and collective in *out. */
SC_MUST_USE sc_status sc_comm_part(const sc_ctx *ctx, sc_comm *comm, int count,
                                   sc_comm_choice choice, sc_comm **out);

/** @return the number of this rank, from 0. */
int sc_comm_rank(const sc_comm *comm);
/** @return the number of ranks. */
int sc_comm_size(const sc_comm *comm);
/** @return the number of nodes (hosts) that the ranks run on. */
int sc_comm_node_count(const sc_comm *comm);
/** @return whether this rank runs on the node of rank 0, so that both see the same block of
 *  sc_shared_alloc. */
bool sc_comm_is_near_root(const sc_comm *comm);
/** Write name and version of the message layer, or "none" in a build without MPI, into @p text, of
 *  @p size bytes; what is too long is cut off. Callable before sc_comm_open. */
void sc_comm_library(char *text, size_t size);

/** @return on every rank the smallest return code that any rank has passed, so that all take the
 *  same branch. Blocks until all ranks have called it. Collective. */
SC_MUST_USE sc_status sc_comm_agree(sc_comm *comm, sc_status mine);
/** Copy @p bytes (the same number on all ranks) from rank 0's @p data to that of all others, where
 *  it has to be allocated; blocks until they are here. Collective. */
void sc_comm_broadcast(sc_comm *comm, void *data, size_t bytes);
/** Copy @p bytes (the same number on all ranks, at most INT32_MAX) of each rank's @p mine to an
 *  array of rank 0, in the order of ranks. Blocks there until all are here. @param all the address
 *  of a pointer of any type, which becomes that array, and NULL on the others and after an error;
 *  the caller owns it: sc_free. Collective. @return SC_ERR_MEMORY, the same on all ranks. */
SC_MUST_USE sc_status sc_comm_gather(const sc_ctx *ctx, sc_comm *comm, const void *mine,
                                     size_t bytes, void *all);

/** Where a node holds a block that its ranks share. */
typedef enum sc_shared_place {
    SC_SHARED_IN_MEMORY, /**< in memory that all its ranks see (/dev/shm), or in that of the only
                              rank */
    SC_SHARED_IN_FILE,   /**< in a file without a name, on disk, that all its ranks map */
    SC_SHARED_COPIED     /**< every rank has a copy, and changes of one are not seen by others */
} sc_shared_place;

/** Allocate one block of memory per node, common to all its ranks; not initialised. All ranks of a
 *  node pass the same size; with 0 nothing is allocated. Asks for room first and keeps some free
 * for the message layer. @param folder where a file is made if there is no room in /dev/shm; if
 * there is none in the folder either, every rank gets a copy, which sc_shared_publish fills. NULL:
 * only memory that is really shared will do. Of the ranks of a node the first one's folder counts.
 *  Collective. @return on all ranks the same: SC_ERR_MEMORY, logged by rank 0. Caller owns *out:
 *  sc_shared_free. */
SC_MUST_USE sc_status sc_shared_alloc(const sc_ctx *ctx, sc_comm *comm, size_t bytes,
                                      const char *folder, sc_shared **out);
/** Choose where blocks are made from now on for which a folder is given: @p prefers says in a file
 *  there, if it has room, of which the system holds in memory what is used; otherwise, as at first,
 *  in memory if that has room. All ranks choose the same. Not collective. */
void sc_comm_prefer_files(sc_comm *comm, bool prefers);
/** @return where this rank's node holds the block. */
sc_shared_place sc_shared_place_of(const sc_shared *shared);
/** @return the errno that says why the block is not in a file although that was preferred; 0: it
 * is, or was not, or another rank of the node knows. */
int sc_shared_file_error(const sc_shared *shared);
/** Tell the system what this rank will do with the block: see sc_file_advise. A block that is in no
 *  file stays in memory as it is. Not collective: other ranks of the node may be reading it. */
void sc_shared_advise(sc_shared *shared, sc_memory_use use);
/** @return on all ranks SC_OK if on each node the folder has room for @p bytes bytes more, or if
 *  the system does not tell; else SC_ERR_MEMORY, not logged. Of the ranks of a node the first one's
 *  @p folder and @p bytes count. Collective. */
SC_MUST_USE sc_status sc_comm_agree_room(sc_comm *comm, const char *folder, uint64_t bytes);
/** @return the block at its address in this process. */
void *sc_shared_data(const sc_shared *shared);
/** Copy the block of rank 0's node to those of the other nodes, in place of what they hold; blocks
 *  until all ranks may read. Collective. */
void sc_shared_publish(sc_comm *comm, sc_shared *shared);
/** Free the block, which no rank may use any more. Collective; NULL is allowed (on all ranks). */
void sc_shared_free(sc_shared *shared);

/** Start sending @p bytes, at most INT32_MAX, to rank @p target, another one; @p tag, from 0, tells
 *  it what they are. A single process sends nothing. @p data stays borrowed until the
 *  message has left (sc_comm_pending, sc_comm_flush). Messages between two ranks arrive in the
 * order in which they were posted. Cannot fail, so that no rank waits for a message that was never
 * sent. Returns at once, except that without memory to keep track of one more message it waits
 * until an earlier one has left. */
void sc_comm_post(sc_comm *comm, int target, int tag, const void *data, size_t bytes);
/** Let posted messages progress, without waiting. @return how many still need their buffers. */
int sc_comm_pending(sc_comm *comm);
/** Block until no posted message needs its buffer any more: their receivers must receive them. */
void sc_comm_flush(sc_comm *comm);
/** Test, without waiting, for a message from any rank, and describe it in @p out; it stays to be
 *  received. @return false, with @p out untouched, if none has arrived. */
bool sc_comm_poll(sc_comm *comm, sc_message *out);
/** Receive the message that sc_comm_poll has found into @p data, which has room for message->bytes.
 *  Blocks until all of it is there: a large message arrives in fragments. */
void sc_comm_receive(sc_comm *comm, const sc_message *message, void *data);

#endif
