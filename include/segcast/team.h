/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Teams: the ranks of a node, with the threads of each, do parallel loops together, over arrays
 *  that all of them see. So what a node needs once is made once, by all its cores, and held once.
 *
 *  A rank may also be a team of its own: then arrays are its own memory, loops are those of
 *  sc_parallel_for, and none of these functions waits for another rank. All functions are called
 *  from the main thread. "Collective" means here: called by all ranks of the team, in the same
 *  order, with the same sizes and counts. */
#ifndef SEGCAST_TEAM_H
#define SEGCAST_TEAM_H

#include "segcast/comm.h"

/** A team, as one of its ranks sees it. */
typedef struct sc_team sc_team;

/** Open the team of all ranks on this rank's node. Collective. @param comm borrowed for the team's
 *  life; NULL, or with one rank on this node: the rank is a team of its own. @param threads how
 *  many this rank uses, at least 1; they may differ between ranks. @param folder where the files of
 *  arrays are made if /dev/shm has no room for them; that of the first rank counts; borrowed for
 *  the team's life. @return SC_ERR_MEMORY, logged, the same on all ranks. Caller owns *out:
 *  sc_team_close. */
SC_MUST_USE sc_status sc_team_open(const sc_ctx *ctx, sc_comm *comm, int threads,
                                   const char *folder, sc_team **out);
/** Free the team and its arrays, which this rank may not use any more; others still may. NULL is
 *  allowed. */
void sc_team_close(sc_team *team);
SC_CLOSE_AT(sc_team_close, sc_team)
/** @return how many ranks the team has. */
int sc_team_ranks(const sc_team *team);
/** @return how many threads this rank uses, as given to sc_team_open. */
int sc_team_threads(const sc_team *team);
/** @return whether this rank is the first one of the team, which does what only one can do. */
bool sc_team_is_first(const sc_team *team);
/** @return the bytes of the arrays that the team holds now: once, whatever its ranks. */
uint64_t sc_team_bytes(const sc_team *team);
/** @return on every rank the smallest return code that any rank of the team has passed. Blocks
 *  until all have called it; what they wrote to arrays before can be read then. Collective. */
SC_MUST_USE sc_status sc_team_agree(sc_team *team, sc_status mine);
/** @return whether the memory that the ranks share has room for so many bytes, and still for what
 *  others need there; the same on all ranks; true for a rank alone. Collective. */
bool sc_team_has_room(sc_team *team, uint64_t bytes);
/** Allocate an array of @p count elements of @p size bytes that all ranks of the team see, aligned
 *  to 64 bytes, all bytes 0. Collective. @return SC_ERR_MEMORY, logged, the same on all ranks: they
 *  can still be told to do without each other. @param out address of a pointer of any type. The
 *  team owns the array; each rank may free it before: sc_team_free. */
SC_MUST_USE sc_status sc_team_alloc(const sc_ctx *ctx, sc_team *team, size_t count, size_t size,
                                    void *out);
/** Tell the system what this rank will do with all arrays of the team: see sc_shared_advise. Not
 *  collective. */
void sc_team_advise(sc_team *team, sc_memory_use use);
/** Free @p data, an array of the team, on this rank. Not collective; NULL is allowed. */
void sc_team_free(sc_team *team, void *data);
/** Copy @p bytes (the same number on all ranks) of each rank's @p mine to an array [ranks][bytes],
 *  in an order of ranks that is the same on all of them. Collective. @param all as out of
 *  sc_team_alloc. @return as of that. */
SC_MUST_USE sc_status sc_team_collect(const sc_ctx *ctx, sc_team *team, const void *mine,
                                      size_t bytes, void *all);
/** Call @p body for all of [0, count), in chunks of @p chunk items that all threads of all ranks
 *  claim one after the other; returns when all items are done on all ranks, and what @p body wrote
 *  to arrays of the team can be read by all. Which rank and thread does which chunk differs from
 *  call to call, and results must not depend on it. @param body gets the number of the thread on
 *  its rank. @param user of this rank; what it points to is not shared, but for arrays of the team.
 *  Collective. */
void sc_team_for(sc_team *team, size_t count, size_t chunk, sc_range_fn *body, void *user);
/** As sc_team_for, and count what all ranks have done as @p worth of the stage of @p ctx, while it
 *  goes on: see sc_stage_for. */
void sc_team_stage_for(const sc_ctx *ctx, uint64_t worth, sc_team *team, size_t count, size_t chunk,
                       sc_range_fn *body, void *user);

#endif
