/* SPDX-License-Identifier: BSD-3-Clause */
#include "internal.h"

void sc_farm_draw(const sc_farm *farm, int unit, double wait_s, sc_image *image,
                  sc_frame_result *result)
{
    *result = (sc_frame_result){.frame = farm->frames[unit], .wait_s = wait_s};
    farm->draw(farm->user, farm->frames[unit], image, result);
    result->hash = sc_image_hash(image);
}

sc_status sc_farm_run(const sc_ctx *ctx, sc_comm *comm, const sc_farm *farm, sc_farm_times *times)
{
    sc_status status;

    *times = (sc_farm_times){0};
    if (sc_comm_rank(comm) == 0)
        status = sc_farm_serve(ctx, comm, farm, times);
    else
        status = sc_farm_work(ctx, comm, farm, times);
    return sc_comm_agree(comm, status);
}
