/* SPDX-License-Identifier: BSD-3-Clause */
/* Finished frames and GOPs are given to the callbacks of the farm, on a worker thread of rank 0. */
#include "internal.h"

/* Accept the full frame in @p slot; frames drawn in bands get their hash here, all others were
 * hashed where they were drawn. @return the error of drawing it, if any; it is not accepted then.
 */
static sc_status accept_frame(const sc_farm *farm, sc_frame_slot *slot)
{
    if (slot->drawn != SC_OK)
        return slot->drawn;
    if (slot->in_bands)
        slot->result.hash = sc_image_hash(&slot->image);
    return farm->calls.accept_frame(farm->calls.user, &slot->result, &slot->image);
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

        accept->status =
            farm->calls.accept_gop(farm->calls.user, gop->results, gop->count, &gop->payload);
    } else {
        accept->status = accept_frame(farm, (sc_frame_slot *)accept);
    }
    accept->accepted = accept->status == SC_OK;
    acceptor->status = accept->status;
}

sc_status sc_gop_new(const sc_ctx *ctx, const sc_frame_result *results, int count, sc_gop **out)
{
    SC_OWN(sc_free_at) sc_gop *gop = NULL;

    SC_PASS(SC_ZALLOC(ctx, 1, &gop));
    SC_PASS(SC_ALLOC(ctx, (size_t)count, &gop->results));
    memcpy(gop->results, results, (size_t)count * sizeof *results);
    gop->accept.is_gop = true;
    gop->count = count;
    SC_HAND_OVER(gop, out);
    return SC_OK;
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
    SC_OWN(sc_free_at) sc_frame_slot *frame = NULL;

    SC_PASS(SC_ZALLOC(ctx, 1, &frame));
    SC_PASS(sc_image_init_alpha(ctx, farm->width_px, farm->height_px, farm->alpha, &frame->image));
    memcpy(frame->image.rgb, rows, sc_image_bytes(&frame->image));
    frame->result = *result;
    frame->rescued = true;
    SC_HAND_OVER(frame, out);
    return SC_OK;
}

void sc_rescued_free(sc_frame_slot *frame)
{
    sc_image_clear(&frame->image);
    sc_free(frame);
}
