/* SPDX-License-Identifier: BSD-3-Clause */
#include "internal.h"

#include <string.h>

int sc_farm_group_count(const sc_farm *farm, int index)
{
    const int left = farm->total - farm->groups[index];

    return left < farm->group_frames ? left : farm->group_frames;
}

size_t sc_farm_message_bytes(const sc_farm *farm)
{
    const size_t pixels = (size_t)farm->width_px * (size_t)farm->height_px * 3;
    const size_t group = (size_t)farm->group_frames * sizeof(sc_frame_result) + sizeof(uint64_t);

    return sizeof(sc_done_message) + (pixels > group ? pixels : group);
}

double sc_farm_rows(const sc_farm *farm, const sc_unit *unit)
{
    if (unit->kind == SC_UNIT_GROUP)
        return (double)farm->height_px * sc_farm_group_count(farm, unit->index);
    return unit->rows;
}

void sc_farm_draw(void *user, sc_lane_job *lane_job)
{
    const sc_farm *farm = user;
    sc_draw_job *job = (sc_draw_job *)lane_job;
    const sc_unit *unit = &job->unit;

    if (unit->kind == SC_UNIT_GROUP) {
        const int count = sc_farm_group_count(farm, unit->index);

        memset(job->results, 0, (size_t)count * sizeof *job->results);
        job->results[0].wait_s = lane_job->waited_s;
        job->payload = (sc_payload){0};
        job->status = farm->draw_group(farm->user, farm->groups[unit->index], count, job->results,
                                       &job->payload);
        return;
    }
    job->result =
        (sc_frame_result){.frame = farm->frames[unit->index], .wait_s = lane_job->waited_s};
    farm->draw(farm->user, farm->frames[unit->index], unit->row, unit->rows, job->image,
               &job->result);
    if (unit->kind == SC_UNIT_FRAME)
        job->result.hash = sc_image_hash(job->image);
}

sc_status sc_farm_run(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm, sc_farm_times *times)
{
    const double begin_s = sc_wall_s();
    sc_status status;

    *times = (sc_farm_times){0};
    if (sc_comm_rank(comm) == 0)
        status = sc_farm_serve(ctx, comm, farm, times);
    else
        status = sc_farm_work(ctx, comm, farm, times);
    status = sc_comm_agree(comm, status);
    times->wall_s = sc_wall_s() - begin_s;
    return status;
}
