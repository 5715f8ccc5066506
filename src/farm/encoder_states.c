/* SPDX-License-Identifier: BSD-3-Clause */
/* What rank 0 knows of the encoders of gathered GOPs: what they have taken, what they still get,
 * and what encoding costs. */
#include "internal.h"

sc_status sc_encoders_open(const sc_ctx *ctx, sc_comm *comm, const sc_handout *handout,
                           sc_encoders *out)
{
    *out = (sc_encoders){.comm = comm};
    SC_PASS(SC_ZALLOC(ctx, (size_t)handout->gather_window, &out->taken));
    return SC_ZALLOC(ctx, (size_t)handout->work.ranks, &out->parts);
}

void sc_encoders_clear(sc_encoders *encoders)
{
    sc_free(encoders->taken);
    sc_free(encoders->parts);
}

void sc_encoders_unit_done(sc_encoders *encoders, const sc_work_unit *unit)
{
    encoders->parts[unit->encoder]++;
}

void sc_encoders_take(sc_encoders *encoders, sc_handout *handout, const sc_taken_message *message)
{
    bool *taken = encoders->taken;

    encoders->encode_s += message->encode_s;
    encoders->frames++;
    taken[message->index % handout->gather_window] = true;
    while (taken[handout->taken % handout->gather_window]) {
        taken[handout->taken % handout->gather_window] = false;
        handout->taken++;
    }
}

bool sc_encoders_have_yielded(sc_encoders *encoders, const sc_handout *handout)
{
    if (!sc_handout_finished(handout))
        return false;
    for (int rank = 1; !encoders->told && rank < handout->work.ranks; rank++) {
        if (encoders->parts[rank] == 0)
            continue;
        sc_comm_post(encoders->comm, rank, SC_TAG_YIELD, &encoders->parts[rank],
                     sizeof encoders->parts[rank]);
        encoders->yielding++;
    }
    encoders->told = true;
    return encoders->yielding == 0;
}
