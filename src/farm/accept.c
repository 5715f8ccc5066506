/* SPDX-License-Identifier: BSD-3-Clause */
/* Finished frames and GOPs are given to the callbacks of the farm, on a worker thread of rank 0. */
#include "internal.h"

#include <string.h>

/* Accept the full frame in @p slot; frames drawn in bands get their hash here, all others were
 * hashed where they were drawn. @return the error of drawing it, if any; it is not accepted then.
 */
static sc_status accept_frame(const sc_farm *farm, sc_frame_slot *slot)
{
    if (slot->drawn != SC_OK)
        return slot->drawn;
    if (slot->in_bands)
        slot->result.hash = sc_image_hash(&slot->image);
    return farm->accept_frame(farm->user, &slot->result, &slot->image);
}

void sc_accept_task_run(void *user, sc_task *task)
{
    sc_acceptor *acceptor = user;
    const sc_farm *farm = acceptor->farm;
    sc_accept_task *accept = (sc_accept_task *)task;

    accept->status = SC_OK;
    accept->accepted = false;
    if (acceptor->status != SC_OK)
        return;
    if (accept->is_gop) {
        const sc_gop *gop = (const sc_gop *)accept;

        accept->status = farm->accept_gop(farm->user, gop->results, gop->count, &gop->payload);
    } else {
        accept->status = accept_frame(farm, (sc_frame_slot *)accept);
    }
    accept->accepted = accept->status == SC_OK;
    acceptor->status = accept->status;
}

sc_status sc_gop_new(const sc_ctx *ctx, const sc_frame_result *results, int count, sc_gop **out)
{
    void *block = NULL, *copy = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, 1, sizeof(sc_gop), &block));
    SC_TRY(sc_alloc(ctx, (size_t)count, sizeof *results, &copy));
    memcpy(copy, results, (size_t)count * sizeof *results);
    *out = block;
    **out = (sc_gop){.accept.is_gop = true, .results = copy, .count = count};
    return SC_OK;
out:
    sc_free(block);
    return status;
}

void sc_gop_free(sc_gop *gop)
{
    sc_free(gop->results);
    sc_free(gop->payload.data);
    sc_free(gop);
}

sc_status sc_rescued_new(const sc_ctx *ctx, const sc_farm *farm, const sc_frame_result *result,
                         const void *rows, sc_frame_slot **out)
{
    sc_frame_slot *frame;
    void *block = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, 1, sizeof *frame, &block));
    frame = block;
    SC_TRY(sc_image_init_alpha(ctx, farm->width_px, farm->height_px, farm->alpha, &frame->image));
    memcpy(frame->image.rgb, rows, sc_image_bytes(&frame->image));
    frame->result = *result;
    frame->rescued = true;
    *out = frame;
    return SC_OK;
out:
    sc_free(block);
    return status;
}

void sc_rescued_free(sc_frame_slot *frame)
{
    sc_image_clear(&frame->image);
    sc_free(frame);
}
