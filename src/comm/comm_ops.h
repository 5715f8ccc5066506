/* SPDX-License-Identifier: BSD-3-Clause */
/* The functions of a communicator, which each implementation provides; segcast/comm.h says what
 * they do. */
#ifndef SC_COMM_OPS_H
#define SC_COMM_OPS_H

#include "segcast/comm.h"

/* One function for each of sc_comm_* and sc_shared_*, with the same contract, and three for teams
 * (segcast/team.h); none is NULL. */
typedef struct sc_comm_ops {
    void (*close)(sc_comm *comm);
    sc_status (*part)(const sc_ctx *ctx, sc_comm *comm, int count, sc_comm_choice choice,
                      sc_comm **out);
    sc_status (*agree)(sc_comm *comm, sc_status mine);
    void (*broadcast)(sc_comm *comm, void *data, size_t bytes);
    void (*gather)(sc_comm *comm, const void *mine, size_t bytes, void *all);
    sc_status (*share)(const sc_ctx *ctx, sc_comm *comm, size_t bytes, const char *folder,
                       sc_shared **out);
    void (*publish)(sc_comm *comm, sc_shared *shared);
    /* As agree, among the ranks of this node, whose writes to memory that they share before the
     * call are seen by all after it. */
    sc_status (*node_agree)(sc_comm *comm, sc_status mine);
    /* As share, among the ranks of this node, for memory that is really shared, if need be by a
     * file in @p folder (NULL: none), all bytes 0. @return the same on them: SC_ERR_MEMORY, not
     * logged. */
    sc_status (*node_share)(const sc_ctx *ctx, sc_comm *comm, size_t bytes, const char *folder,
                            sc_shared **out);
    /* Has the memory in which node_share puts blocks room for so many bytes? */
    bool (*has_room)(const sc_comm *comm, uint64_t bytes);
    void (*post)(sc_comm *comm, int target, int tag, const void *data, size_t bytes);
    int (*pending)(sc_comm *comm);
    void (*flush)(sc_comm *comm);
    bool (*poll)(sc_comm *comm, sc_message *out);
    void (*receive)(sc_comm *comm, const sc_message *message, void *data);
} sc_comm_ops;

/* What all implementations have in common, as the first member of their own structs. */
struct sc_comm {
    const sc_comm_ops *ops;
    int rank, size;     /* number of this rank, and number of ranks */
    int node_rank;      /* number of this rank among those of its node, from 0 */
    int node_size;      /* number of ranks of this node */
    int node_count;     /* number of nodes */
    bool near_root;     /* on the node of rank 0 */
    bool prefers_files; /* of sc_comm_prefer_files */
};

/* A shared block, as one rank sees it. */
struct sc_shared {
    void *data; /* address in this process; NULL for a block of 0 bytes */
    size_t bytes;
    sc_shared_place place;
    int file_error; /* of sc_shared_file_error */
    void (*free)(sc_shared *shared);
};

/* The two implementations of sc_comm_open, for a single process and for those that an MPI launcher
 * has started. The second starts MPI, blocks until all ranks have called it, and is collective.
 * @return SC_ERR_MEMORY, SC_ERR_INTERNAL if MPI cannot be started. Caller owns *out:
 * sc_comm_close. */
sc_status sc_comm_self_open(const sc_ctx *ctx, sc_comm **out);
sc_status sc_comm_mpi_open(const sc_ctx *ctx, sc_comm **out);
/* As sc_comm_library, in a build with MPI. */
void sc_comm_mpi_library(char *text, size_t size);

#endif
