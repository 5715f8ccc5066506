/* SPDX-License-Identifier: BSD-3-Clause */
/* Scenes: room for what they say of tissues. */
#include "segcast/scene.h"

sc_status sc_scene_room_init(const sc_ctx *ctx, int label_count, sc_scene_room *out)
{
    const size_t labels = (size_t)label_count;
    void *block;
    const sc_status status = sc_zalloc(
        ctx, labels, sizeof *out->offsets_mm + sizeof *out->colors + sizeof *out->fades, &block);

    if (status != SC_OK)
        return status;
    out->offsets_mm = block;
    out->colors = (float(*)[3])(void *)(out->offsets_mm + labels);
    out->fades = (float *)(out->colors + labels);
    return SC_OK;
}

void sc_scene_room_clear(sc_scene_room *room)
{
    sc_free(room->offsets_mm);
    *room = (sc_scene_room){0};
}
