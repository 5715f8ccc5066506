/* SPDX-License-Identifier: BSD-3-Clause */
/* What the store knows of frames and GOPs. */
#include "internal.h"

int sc_store_gop_frames(const sc_store *store, int gop)
{
    const int left = store->job.frames - gop * store->gop_frames;

    return left < store->gop_frames ? left : store->gop_frames;
}

bool sc_store_has_picture(const sc_store *store, int k)
{
    return store->has_segment[k / store->gop_frames] || store->partial.locations[k].file >= 0;
}

bool sc_store_has(const sc_store *store, int k)
{
    return store->complete ||
           (store->data.lines[k].known && (!store->job.png || store->has_png[k]) &&
            (!store->has_video || sc_store_has_picture(store, k)));
}
