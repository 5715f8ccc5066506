/* SPDX-License-Identifier: BSD-3-Clause */
/* What the work units of a farm amount to: frames, rows, bytes. */
#include "internal.h"

/* @return what there is to do for @p ranks ranks. */
static sc_work work_of(const sc_farm *farm, int ranks)
{
    return (sc_work){.ranks = ranks,
                     .gops = farm->gop_count,
                     .frames = farm->frame_count,
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

size_t sc_farm_message_bytes(const sc_farm *farm)
{
    const size_t pixels = (size_t)farm->width_px * (size_t)farm->height_px * 3;
    const size_t gop = (size_t)farm->gop_frames * sizeof(sc_frame_result) + sizeof(uint64_t);

    return sizeof(sc_result_message) + (pixels > gop ? pixels : gop);
}

sc_farm_memory sc_farm_memory_of(const sc_farm *farm, int ranks)
{
    const sc_work work = work_of(farm, ranks);
    const size_t frame = (size_t)farm->width_px * (size_t)farm->height_px * 3;
    const size_t message = sc_farm_message_bytes(farm);

    return (sc_farm_memory){.window = (size_t)sc_handout_begin(&work).window * frame,
                            .root =
                                message + (farm->spoils_other_rows ? SC_UNITS_PER_RANK * frame : 0),
                            .worker = SC_WORKER_BUFFERS * message};
}
