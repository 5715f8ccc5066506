/* SPDX-License-Identifier: BSD-3-Clause */
/* What the work units of a farm amount to (frames, rows, bytes), and what ranks tell of them. */
#include "internal.h"

bool sc_farm_gathers(const sc_farm *farm, int ranks)
{
    return farm->gather && farm->gop_count > 0 && ranks > 1;
}

/* @return what there is to do for @p ranks ranks. */
static sc_work work_of(const sc_farm *farm, int ranks)
{
    const bool gathers = sc_farm_gathers(farm, ranks);

    return (sc_work){.ranks = ranks,
                     .gops = gathers ? 0 : farm->gop_count,
                     .frames = farm->frame_count,
                     .gathered = gathers ? farm->gop_count : 0,
                     .gop_frames = farm->gop_frames,
                     .encoders_most = farm->encoders_most,
                     .alpha = farm->alpha,
                     .width_px = farm->width_px,
                     .height_px = farm->height_px,
                     .partition = farm->partition};
}

sc_work sc_farm_work(const sc_farm *farm, const sc_comm *comm)
{
    return work_of(farm, sc_comm_size(comm));
}

int sc_farm_gop_frames(const sc_farm *farm, int index)
{
    const int left = farm->total_frames - farm->gops[index];

    return left < farm->gop_frames ? left : farm->gop_frames;
}

double sc_farm_unit_rows(const sc_farm *farm, const sc_work_unit *unit)
{
    if (unit->kind == SC_UNIT_GOP)
        return (double)farm->height_px * sc_farm_gop_frames(farm, unit->index);
    return unit->rows;
}

int sc_farm_frame(const sc_farm *farm, const sc_work_unit *unit)
{
    return unit->encoder > 0 ? farm->gops[unit->gop] + unit->place : farm->frames[unit->index];
}

void sc_frame_result_add(sc_frame_result *sum, const sc_frame_result *part)
{
    sum->rank = part->rank;
    sum->render_wall_s += part->render_wall_s;
    sum->render_cpu_s += part->render_cpu_s;
    sum->wait_s += part->wait_s;
    sum->rays += part->rays;
    sum->samples += part->samples;
    sum->contributions += part->contributions;
    sum->hash = part->hash;
}

void sc_farm_post_payload(sc_comm *comm, const sc_farm *farm, const sc_payload *payload)
{
    const size_t piece_bytes = sc_farm_message_bytes(farm);

    for (size_t at = 0; at < payload->bytes; at += piece_bytes) {
        const size_t left = payload->bytes - at;

        sc_comm_post(comm, 0, SC_TAG_PIECE, (const char *)payload->data + at,
                     left < piece_bytes ? left : piece_bytes);
    }
}

size_t sc_farm_message_bytes(const sc_farm *farm)
{
    const size_t pixels = sc_farm_frame_bytes(farm);
    const size_t gop = (size_t)farm->gop_frames * sizeof(sc_frame_result) + sizeof(uint64_t);

    return sizeof(sc_result_message) + (pixels > gop ? pixels : gop);
}

sc_farm_memory sc_farm_memory_of(const sc_farm *farm, int ranks)
{
    const sc_work work = work_of(farm, ranks);
    const sc_handout handout = sc_handout_begin(&work);
    const size_t frame = sc_farm_frame_bytes(farm);
    const size_t message = sc_farm_message_bytes(farm);
    const size_t window = (size_t)handout.window * frame;
    const size_t own = farm->spoils_other_rows ? SC_UNITS_PER_RANK * frame : 0;
    const int gop = work.gathered > 0 ? work.gop_frames : 0;
    const int few = (handout.gather_window_least + handout.encoders - 1) / handout.encoders;
    const int ahead = few > gop ? few : gop;

    return (sc_farm_memory){.window = window,
                            .root = message + own,
                            .worker = SC_WORKER_BUFFERS * message,
                            .encoder = gop ? message + (size_t)(gop + ahead) * frame : 0};
}
