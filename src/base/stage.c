/* SPDX-License-Identifier: BSD-3-Clause */
/* What a command is at: set by whoever does the work, read by whoever shows it. */
#include "segcast/base.h"

void sc_stage_begin(const sc_ctx *ctx, const char *name, uint64_t done, uint64_t total)
{
    sc_stage *stage = ctx ? ctx->stage : NULL;

    if (!stage)
        return;
    /* A reader that meets the new counts with the old name shows them for a tenth of a second. */
    atomic_store(&stage->name, NULL);
    atomic_store(&stage->begun_with, done);
    atomic_store(&stage->done, done);
    atomic_store(&stage->total, total);
    atomic_store(&stage->begin_s, sc_wall_s());
    atomic_store(&stage->name, name);
}

void sc_stage_add(const sc_ctx *ctx, uint64_t count)
{
    if (ctx && ctx->stage)
        atomic_fetch_add_explicit(&ctx->stage->done, count, memory_order_relaxed);
}

void sc_stage_turn(const sc_ctx *ctx, int number, int count)
{
    if (ctx && ctx->stage)
        atomic_store(&ctx->stage->turn, (uint32_t)number << 16 | (uint32_t)count);
}

void sc_stage_end(const sc_ctx *ctx)
{
    sc_stage_begin(ctx, NULL, 0, 0);
}

/* A parallel loop whose items are counted; for sc_stage_for. */
typedef struct counted_loop {
    const sc_ctx *ctx;
    sc_range_fn *body;
    void *user;
    size_t count;
    uint64_t worth;
} counted_loop;

/* Do a part of a counted_loop, and count it. The parts of the worth are such that their sum is the
 * worth. */
static void do_and_count(void *user, size_t begin, size_t end, int thread)
{
    const counted_loop *loop = user;
    const double each = (double)loop->worth / (double)loop->count;

    loop->body(loop->user, begin, end, thread);
    sc_stage_add(loop->ctx, (uint64_t)(each * (double)end) - (uint64_t)(each * (double)begin));
}

void sc_stage_for(const sc_ctx *ctx, uint64_t worth, int threads, size_t count, size_t chunk,
                  sc_range_fn *body, void *user)
{
    counted_loop loop = {ctx, body, user, count, worth};

    sc_parallel_for(threads, count, chunk, do_and_count, &loop);
}
