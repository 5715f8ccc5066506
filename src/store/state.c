/* SPDX-License-Identifier: BSD-3-Clause */
/* What the store knows of frames and GOPs. */
#include "internal.h"

uint64_t sc_identity_of(uint64_t job_hash, uint64_t volume_hash, int frames, const char *version)
{
    const uint64_t numbers[] = {job_hash, volume_hash, (uint64_t)frames};

    return sc_hash_bytes(version, strlen(version), sc_hash_bytes(numbers, sizeof numbers, 0));
}

int sc_store_gop_frames(const sc_store *store, int gop)
{
    const int left = store->job.frames - gop * store->gop_frames;

    return left < store->gop_frames ? left : store->gop_frames;
}

bool sc_store_is_segment_of(const sc_store *store, const sc_segment_info *info, int gop)
{
    const sc_video_settings *s = &store->job.settings;

    return info->identity == store->identity && info->first_frame == gop * store->gop_frames &&
           info->frame_count == sc_store_gop_frames(store, gop) &&
           info->width_px == ((s->width_px + 1) & ~1) &&
           info->height_px == ((s->height_px + 1) & ~1) && info->fps == s->fps &&
           info->codec == sc_video_codec_id(store->job.video, s->codec);
}

bool sc_store_has_picture(const sc_store *store, int k)
{
    return store->outputs.has_segment[k / store->gop_frames] ||
           store->partial.locations[k].file >= 0;
}

bool sc_store_has(const sc_store *store, int k)
{
    return store->complete ||
           (store->data.lines[k].known && (!store->job.png || store->outputs.has_png[k]) &&
            (!store->has_video || sc_store_has_picture(store, k)));
}

const sc_done_frame *sc_store_done(const sc_store *store, int k)
{
    return store->data.lines && store->data.lines[k].known ? &store->data.lines[k].done : NULL;
}
