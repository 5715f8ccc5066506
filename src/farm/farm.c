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
    job->status = farm->draw(farm->user, farm->frames[unit->index], unit->row, unit->rows,
                             job->image, &job->result);
    if (job->status == SC_OK && unit->kind == SC_UNIT_FRAME)
        job->result.hash = sc_image_hash(job->image);
}

sc_work sc_farm_amount(const sc_farm *farm, const sc_comm *comm)
{
    return (sc_work){.ranks = sc_comm_size(comm),
                     .groups = farm->group_count,
                     .frames = farm->frame_count,
                     .width_px = farm->width_px,
                     .height_px = farm->height_px,
                     .partition = farm->partition};
}

/* Try to have the window in memory that rank 0's node shares; without it pixels are sent. */
static sc_shared *share_slots(sc_comm *comm, const sc_farm *farm, sc_slots *out)
{
    const sc_work work = sc_farm_amount(farm, comm);
    const size_t row_bytes = (size_t)farm->width_px * 3;
    const size_t stride = ((size_t)farm->height_px * row_bytes + 4095) / 4096 * 4096;
    const int window = sc_handout_begin(&work).window;
    const size_t bytes = sc_comm_is_near_root(comm) ? stride * (size_t)window : 0;
    const sc_ctx silent = {.rank = 0};
    sc_shared *shared = NULL;

    *out = (sc_slots){.stride = stride, .window = window};
    if (sc_comm_size(comm) == 1 || !farm->share_frames ||
        sc_comm_agree(comm, bytes > sc_machine_shared_room() / 2 ? SC_ERR_MEMORY : SC_OK) !=
            SC_OK ||
        sc_shared_alloc(&silent, comm, bytes, &shared) != SC_OK)
        return NULL;
    if (sc_comm_is_near_root(comm))
        out->pixels = sc_shared_data(shared);
    return shared;
}

sc_status sc_farm_run(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm, sc_farm_times *times)
{
    const double begin_s = sc_wall_s();
    sc_slots slots;
    sc_shared *shared = share_slots(comm, farm, &slots);
    sc_status status;

    *times = (sc_farm_times){0};
    if (sc_comm_rank(comm) == 0)
        status = sc_farm_serve(ctx, comm, farm, &slots, times);
    else
        status = sc_farm_work(ctx, comm, farm, &slots, times);
    status = sc_comm_agree(comm, status);
    sc_shared_free(shared);
    times->wall_s = sc_wall_s() - begin_s;
    return status;
}
