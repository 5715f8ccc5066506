/* SPDX-License-Identifier: BSD-3-Clause */
/* A communicator whose ranks are threads of one process, so that the farm can be tested with
 * several ranks under a thread sanitizer and with callbacks that fail. As with MPI, what is posted
 * is read from the sender's buffer when it is received. */
#ifndef SC_TEST_THREAD_COMM_H
#define SC_TEST_THREAD_COMM_H

#include "../../src/comm/comm_ops.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { THREAD_RANKS_MAX = 8 };

/* A message that was posted and is not yet received. */
typedef struct thread_post {
    int source, tag;
    const void *data;
    size_t bytes;
    struct thread_post *next;
} thread_post;

/* What the ranks have in common. */
typedef struct thread_world {
    pthread_mutex_t lock;
    pthread_cond_t all_here;
    int size;       /* number of ranks */
    int here;       /* ranks that have called the present collective function */
    int generation; /* number of collective calls that all ranks have made */
    sc_status smallest, agreed;
    const void *sources[THREAD_RANKS_MAX]; /* what each rank offers in a collective call */
    void *block;                           /* of sc_shared_alloc */
    bool shares;                           /* false: sc_shared_alloc fails */
    thread_post *inbox[THREAD_RANKS_MAX];  /* messages to each rank, in order of arrival */
    int pending[THREAD_RANKS_MAX];         /* messages from each rank that are not yet received */
} thread_world;

typedef struct thread_comm {
    sc_comm base;
    thread_world *world;
} thread_comm;

static sc_status thread_agree(sc_comm *comm, sc_status mine)
{
    thread_world *w = ((thread_comm *)comm)->world;
    sc_status agreed;

    pthread_mutex_lock(&w->lock);
    w->smallest = mine < w->smallest ? mine : w->smallest;
    if (++w->here == w->size) {
        w->agreed = w->smallest;
        w->smallest = SC_OK;
        w->here = 0;
        w->generation++;
        pthread_cond_broadcast(&w->all_here);
    } else {
        const int generation = w->generation;

        while (generation == w->generation)
            pthread_cond_wait(&w->all_here, &w->lock);
    }
    agreed = w->agreed;
    pthread_mutex_unlock(&w->lock);
    return agreed;
}

static void thread_broadcast(sc_comm *comm, void *data, size_t bytes)
{
    thread_world *w = ((thread_comm *)comm)->world;

    if (comm->rank == 0)
        w->sources[0] = data;
    (void)thread_agree(comm, SC_OK);
    if (comm->rank != 0)
        memcpy(data, w->sources[0], bytes);
    (void)thread_agree(comm, SC_OK);
}

static void thread_gather(sc_comm *comm, const void *mine, size_t bytes, void *all)
{
    thread_world *w = ((thread_comm *)comm)->world;

    w->sources[comm->rank] = mine;
    (void)thread_agree(comm, SC_OK);
    for (int rank = 0; comm->rank == 0 && rank < w->size; rank++)
        memcpy((char *)all + (size_t)rank * bytes, w->sources[rank], bytes);
    (void)thread_agree(comm, SC_OK);
}

typedef struct thread_shared {
    sc_shared base;
    sc_comm *comm;
} thread_shared;

static void thread_unshare(sc_shared *base)
{
    sc_comm *comm = ((thread_shared *)base)->comm;

    (void)thread_agree(comm, SC_OK);
    if (comm->rank == 0)
        free(base->data);
    free(base);
}

static sc_status thread_share(const sc_ctx *ctx, sc_comm *comm, size_t bytes, const char *folder,
                              sc_shared **out)
{
    thread_world *w = ((thread_comm *)comm)->world;
    thread_shared *shared;

    if (!w->shares)
        return SC_ERR_MEMORY;
    if (comm->rank == 0)
        w->block = calloc(1, bytes);
    (void)thread_agree(comm, SC_OK);
    shared = malloc(sizeof *shared);
    *shared = (thread_shared){{.data = w->block, .bytes = bytes, .free = thread_unshare}, comm};
    (void)thread_agree(comm, SC_OK); /* all have read the address before the next one is set */
    *out = &shared->base;
    return SC_OK;
}

static bool thread_has_room(const sc_comm *comm, uint64_t bytes)
{
    return ((const thread_comm *)comm)->world->shares && bytes <= SIZE_MAX / 2;
}

static void thread_publish(sc_comm *comm, sc_shared *shared)
{
    (void)thread_agree(comm, SC_OK);
}

static void thread_send(sc_comm *comm, int target, int tag, const void *data, size_t bytes)
{
    thread_world *w = ((thread_comm *)comm)->world;
    thread_post *post = malloc(sizeof *post), **end;

    *post = (thread_post){comm->rank, tag, data, bytes, NULL};
    pthread_mutex_lock(&w->lock);
    for (end = &w->inbox[target]; *end; end = &(*end)->next)
        ;
    *end = post;
    w->pending[comm->rank]++;
    pthread_mutex_unlock(&w->lock);
}

static int thread_pending(sc_comm *comm)
{
    thread_world *w = ((thread_comm *)comm)->world;
    int pending;

    pthread_mutex_lock(&w->lock);
    pending = w->pending[comm->rank];
    pthread_mutex_unlock(&w->lock);
    return pending;
}

static void thread_flush(sc_comm *comm)
{
    while (thread_pending(comm) > 0)
        sc_sleep_s(50e-6);
}

static bool thread_poll(sc_comm *comm, sc_message *out)
{
    thread_world *w = ((thread_comm *)comm)->world;
    const thread_post *post;

    pthread_mutex_lock(&w->lock);
    post = w->inbox[comm->rank];
    if (post)
        *out = (sc_message){post->source, post->tag, post->bytes};
    pthread_mutex_unlock(&w->lock);
    return post != NULL;
}

static void thread_receive(sc_comm *comm, const sc_message *message, void *data)
{
    thread_world *w = ((thread_comm *)comm)->world;
    thread_post *post;

    pthread_mutex_lock(&w->lock);
    post = w->inbox[comm->rank];
    w->inbox[comm->rank] = post->next;
    memcpy(data, post->data, post->bytes);
    w->pending[post->source]--;
    pthread_mutex_unlock(&w->lock);
    free(post);
}

static const sc_comm_ops thread_ops = {.agree = thread_agree,
                                       .broadcast = thread_broadcast,
                                       .gather = thread_gather,
                                       .share = thread_share,
                                       .publish = thread_publish,
                                       .node_agree = thread_agree,
                                       .node_share = thread_share,
                                       .has_room = thread_has_room,
                                       .post = thread_send,
                                       .pending = thread_pending,
                                       .flush = thread_flush,
                                       .poll = thread_poll,
                                       .receive = thread_receive};

typedef void thread_rank_fn(sc_comm *comm, void *user);

typedef struct thread_start {
    thread_comm comm;
    thread_rank_fn *body;
    void *user;
} thread_start;

static void *thread_enter(void *user)
{
    thread_start *start = user;

    start->body(&start->comm.base, start->user);
    return NULL;
}

/* Call @p body on @p ranks threads, each with a communicator of its own; returns when all threads
 * have ended. @param shares whether sc_shared_alloc succeeds. */
static void run_ranks(int ranks, bool shares, thread_rank_fn *body, void *user)
{
    thread_world world = {.lock = PTHREAD_MUTEX_INITIALIZER,
                          .all_here = PTHREAD_COND_INITIALIZER,
                          .size = ranks,
                          .shares = shares};
    thread_start starts[THREAD_RANKS_MAX];
    pthread_t threads[THREAD_RANKS_MAX];

    for (int rank = 0; rank < ranks; rank++) {
        starts[rank] = (thread_start){{{.ops = &thread_ops,
                                        .rank = rank,
                                        .size = ranks,
                                        .node_rank = rank,
                                        .node_size = ranks,
                                        .node_count = 1,
                                        .near_root = true},
                                       &world},
                                      body,
                                      user};
        pthread_create(&threads[rank], NULL, thread_enter, &starts[rank]);
    }
    for (int rank = 0; rank < ranks; rank++)
        pthread_join(threads[rank], NULL);
}

#endif
