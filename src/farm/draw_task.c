/* SPDX-License-Identifier: BSD-3-Clause */
/* Draws work units by the callbacks of the farm, on a worker thread. */
#include "internal.h"

/* Both draw the unit of @p task and fill its members that are results (see sc_draw_task).
 *
 * A GOP: zero its results, and call farm->draw_gop. */
static void draw_gop(const sc_farm *farm, sc_draw_task *task)
{
    const int count = sc_farm_gop_frames(farm, task->unit.index);

    memset(task->results, 0, (size_t)count * sizeof *task->results);
    task->results[0].wait_s = task->task.waited_s;
    task->payload = (sc_payload){0};
    task->status = farm->calls.draw_gop(farm->calls.user, farm->gops[task->unit.index], count,
                                        task->results, &task->payload);
}

/* A frame or band: draw its rows into task->image; only a whole frame that was drawn is hashed. */
static void draw_rows(const sc_farm *farm, sc_draw_task *task)
{
    const sc_work_unit *unit = &task->unit;
    const int frame = sc_farm_frame(farm, unit);

    task->result = (sc_frame_result){.frame = frame, .wait_s = task->task.waited_s};
    task->status = farm->calls.draw(farm->calls.user, frame, unit->row, unit->rows, task->image,
                                    &task->result);
    if (task->status == SC_OK && unit->kind == SC_UNIT_FRAME)
        task->result.hash = sc_image_hash(task->image);
}

void sc_draw_task_run(void *user, sc_task *task)
{
    sc_draw_task *draw = (sc_draw_task *)task;

    if (draw->unit.kind == SC_UNIT_GOP)
        draw_gop(user, draw);
    else
        draw_rows(user, draw);
}
