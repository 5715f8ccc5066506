/* SPDX-License-Identifier: BSD-3-Clause */
/* Parallel loops over the threads of all ranks of a node, and the arrays that these see. */
#include "segcast/team.h"

#include "comm_ops.h"

/* What the ranks claim chunks from: one counter for the present loop and one for the next, so that
 * a counter is set back when nobody can be using it. */
typedef struct team_counters {
    _Atomic uint64_t next[2];
} team_counters;
#if ATOMIC_LLONG_LOCK_FREE != 2
#error "processes can share counters only where these need no lock"
#endif

/* An array of the team, as this rank sees it. */
typedef struct team_array {
    void *data;
    size_t bytes;
    sc_shared *shared; /* NULL: this rank's own memory */
    struct team_array *next;
} team_array;

struct sc_team {
    sc_comm *comm; /* NULL: this rank is alone */
    int threads;
    const char *folder;
    team_array *arrays;      /* owned */
    team_counters *counters; /* one of the arrays; NULL if the rank is alone */
    uint64_t loops;          /* how many have been done */
};

int sc_team_ranks(const sc_team *team)
{
    return team->comm ? team->comm->node_size : 1;
}

int sc_team_threads(const sc_team *team)
{
    return team->threads;
}

bool sc_team_is_first(const sc_team *team)
{
    return !team->comm || team->comm->node_rank == 0;
}

uint64_t sc_team_bytes(const sc_team *team)
{
    uint64_t bytes = 0;

    for (const team_array *a = team->arrays; a; a = a->next)
        bytes += a->bytes;
    return bytes;
}

sc_status sc_team_agree(sc_team *team, sc_status mine)
{
    return team->comm ? team->comm->ops->node_agree(team->comm, mine) : mine;
}

bool sc_team_has_room(sc_team *team, uint64_t bytes)
{
    const bool fits =
        !sc_team_is_first(team) || !team->comm || team->comm->ops->has_room(team->comm, bytes);

    return sc_team_agree(team, fits ? SC_OK : SC_ERR_MEMORY) == SC_OK;
}

/* Free an array that is in no list any more. */
static void free_array(team_array *array)
{
    if (array->shared)
        sc_shared_free(array->shared);
    else
        sc_free(array->data);
    sc_free(array);
}

/* Have @p array hold array->bytes that all ranks see. Collective. */
static sc_status share_array(const sc_ctx *ctx, sc_team *team, team_array *array)
{
    const sc_status status = team->comm->ops->node_share(
        ctx, team->comm, array->bytes ? array->bytes : 1, team->folder, &array->shared);

    if (status != SC_OK)
        return sc_fail(ctx, status, "there is no room for %zu bytes that the ranks of a node share",
                       array->bytes);
    array->data = sc_shared_data(array->shared);
    return SC_OK;
}

sc_status sc_team_alloc(const sc_ctx *ctx, sc_team *team, size_t count, size_t size, void *out)
{
    SC_OWN(sc_free_at) team_array *array = NULL;
    size_t bytes = 0;
    sc_status status = SC_OK;

    if (!sc_mul_size(count, size, &bytes))
        status =
            sc_fail(ctx, SC_ERR_MEMORY, "a size overflows: %zu elements of %zu bytes", count, size);
    if (status == SC_OK)
        status = SC_ZALLOC(ctx, 1, &array);
    SC_PASS(sc_team_agree(team, status));
    array->bytes = bytes;
    if (team->comm)
        SC_PASS(share_array(ctx, team, array));
    else
        SC_PASS(sc_zalloc(ctx, count, size, &array->data));
    array->next = team->arrays;
    team->arrays = array;
    memcpy(out, &array->data, sizeof array->data); /* as sc_alloc does */
    array = NULL;
    return SC_OK;
}

void sc_team_advise(sc_team *team, sc_memory_use use)
{
    for (team_array *a = team->arrays; a; a = a->next) {
        if (a->shared)
            sc_shared_advise(a->shared, use);
    }
}

void sc_team_free(sc_team *team, void *data)
{
    for (team_array **at = &team->arrays; *at; at = &(*at)->next) {
        team_array *array = *at;

        if (array->data == data) {
            *at = array->next;
            free_array(array);
            return;
        }
    }
}

sc_status sc_team_collect(const sc_ctx *ctx, sc_team *team, const void *mine, size_t bytes,
                          void *all)
{
    const size_t rank = team->comm ? (size_t)team->comm->node_rank : 0;
    char *block;

    SC_PASS(sc_team_alloc(ctx, team, (size_t)sc_team_ranks(team), bytes, &block));
    memcpy(block + rank * bytes, mine, bytes);
    memcpy(all, &block, sizeof block);
    return sc_team_agree(team, SC_OK);
}

sc_status sc_team_open(const sc_ctx *ctx, sc_comm *comm, int threads, const char *folder,
                       sc_team **out)
{
    /* A rank that is alone needs no communicator, unless for files. */
    sc_comm *several = comm && (comm->node_size > 1 || comm->prefers_files) ? comm : NULL;
    SC_OWN(sc_free_at) sc_team *team = NULL;
    const sc_status status = SC_ZALLOC(ctx, 1, &team);

    SC_PASS(several ? several->ops->node_agree(several, status) : status);
    *team = (sc_team){.comm = several, .threads = threads, .folder = folder};
    if (several)
        SC_PASS(sc_team_alloc(ctx, team, 1, sizeof *team->counters, &team->counters));
    SC_HAND_OVER(team, out);
    return SC_OK;
}

void sc_team_close(sc_team *team)
{
    if (!team)
        return;
    while (team->arrays) {
        team_array *array = team->arrays;

        team->arrays = array->next;
        free_array(array);
    }
    sc_free(team);
}

/* A loop that is being done, as one rank sees it. */
typedef struct team_loop {
    _Atomic uint64_t *next; /* the chunk that nobody has claimed yet */
    size_t count, chunk;
    sc_range_fn *body;
    void *user;
    const sc_ctx *ctx; /* whose stage counts what is done */
    uint64_t worth;    /* of the loop in that stage */
    _Atomic uint64_t counted;
} team_loop;

/* Count, in the stage, what is done when all items before @p end have been done by any rank. */
static void count_up(team_loop *loop, size_t end)
{
    const uint64_t done = (uint64_t)((double)loop->worth * (double)end / (double)loop->count);
    uint64_t before = atomic_load(&loop->counted);

    while (before < done && !atomic_compare_exchange_weak(&loop->counted, &before, done)) {
    }
    if (before < done)
        sc_stage_add(loop->ctx, done - before);
}

/* Claim chunks until none is left; an sc_range_fn on a team_loop, called once per thread. */
static void claim_chunks(void *user, size_t begin, size_t end, int thread)
{
    team_loop *loop = user;
    const size_t chunks = (loop->count + loop->chunk - 1) / loop->chunk;

    for (;;) {
        const uint64_t mine = atomic_fetch_add(loop->next, 1);
        const size_t first = (size_t)mine * loop->chunk;
        const size_t rest = loop->count - first;
        const size_t last = first + (rest < loop->chunk ? rest : loop->chunk);

        if (mine >= chunks)
            return;
        loop->body(loop->user, first, last, thread);
        count_up(loop, last);
    }
}

void sc_team_stage_for(const sc_ctx *ctx, uint64_t worth, sc_team *team, size_t count, size_t chunk,
                       sc_range_fn *body, void *user)
{
    team_loop loop = {
        .count = count, .chunk = chunk, .body = body, .user = user, .ctx = ctx, .worth = worth};

    if (!team->comm) {
        sc_stage_for(ctx, worth, team->threads, count, chunk, body, user);
        return;
    }
    loop.next = &team->counters->next[team->loops++ % 2];
    sc_parallel_for(team->threads, (size_t)team->threads, 1, claim_chunks, &loop);
    /* The other counter was that of the loop before, which all ranks have left. */
    if (team->comm->node_rank == 0)
        atomic_store(&team->counters->next[team->loops % 2], 0);
    team->comm->ops->node_agree(team->comm, SC_OK);
    sc_stage_add(ctx, worth - atomic_load(&loop.counted)); /* the last chunk was another rank's */
}

void sc_team_for(sc_team *team, size_t count, size_t chunk, sc_range_fn *body, void *user)
{
    sc_team_stage_for(NULL, 0, team, count, chunk, body, user);
}
