/* SPDX-License-Identifier: BSD-3-Clause */
/* Encodes pictures to segments, and joins segments to the video. */
#include "internal.h"

sc_status sc_store_write_segment(const sc_ctx *ctx, sc_store *store, int gop,
                                 const sc_segment *segment)
{
    char path[SC_FILE_BYTES];

    sc_store_path(store->directory, path, "segments/%06d.seg", gop);
    SC_PASS(sc_file_write(ctx, path, segment->data, segment->bytes));
    store->outputs.has_segment[gop] = true;
    sc_partial_remove(&store->partial, gop, gop * store->gop_frames,
                      sc_store_gop_frames(store, gop));
    return sc_manifest_sync(ctx, store->manifest.writer);
}

/* End the GOP that the encoder works on, and write its segment; no GOP is begun then, after an
 * error, too. */
static sc_status finish_gop(const sc_ctx *ctx, sc_store *store)
{
    const int gop = store->encoding;
    SC_OWN(sc_segment_free) sc_segment segment = {0};

    store->encoding = -1;
    SC_PASS(
        sc_encoder_finish(ctx, store->encoder, store->identity, gop * store->gop_frames, &segment));
    return sc_store_write_segment(ctx, store, gop, &segment);
}

/* Is every picture of the GOP in a partial GOP, or will this process accept it? */
static bool can_encode(const sc_store *store, int gop)
{
    const int first = gop * store->gop_frames;

    for (int k = first; k < first + sc_store_gop_frames(store, gop); k++) {
        if (store->partial.locations[k].file < 0 && !store->outputs.wanted[k])
            return false;
    }
    return true;
}

sc_status sc_store_open_encoder(const sc_ctx *ctx, sc_store *store)
{
    char path[SC_FILE_BYTES];

    if (store->encoder)
        return SC_OK;
    sc_store_path(store->directory, path, "%s", store->job.video);
    return sc_encoder_open(ctx, path, &store->job.settings, &store->encoder);
}

/* Set store->encoding to @p gop, with the encoder open and empty. A GOP that was begun before is
 * dropped; its pictures are in partial GOPs. */
static sc_status begin_gop(const sc_ctx *ctx, sc_store *store, int gop)
{
    SC_PASS(sc_store_open_encoder(ctx, store));
    if (sc_encoder_count(store->encoder) > 0)
        sc_encoder_drop(store->encoder);
    store->encoding = gop;
    return SC_OK;
}

/* Encode the next pictures of the GOP store->encoding up to the first one that is in no partial
 * GOP, and write its segment if that was its last. Pictures are read back from the partial GOPs,
 * except that of @p frame, which is given (-1 and NULL: all are read). */
static sc_status encode_available(const sc_ctx *ctx, sc_store *store, int frame,
                                  const void *picture)
{
    const int first = store->encoding * store->gop_frames;
    const int end = first + sc_store_gop_frames(store, store->encoding);

    for (int k = first + sc_encoder_count(store->encoder); k < end; k++) {
        const void *from = picture;

        if (store->partial.locations[k].file < 0)
            break;
        if (k != frame) {
            SC_PASS(sc_partial_read(ctx, &store->partial, k, store->picture));
            from = store->picture;
        }
        SC_PASS(sc_encoder_push(ctx, store->encoder, from, store->partial.locations[k].hash));
    }
    return first + sc_encoder_count(store->encoder) == end ? finish_gop(ctx, store) : SC_OK;
}

sc_status sc_store_encode(const sc_ctx *ctx, sc_store *store, int frame, const void *picture)
{
    const int gop = frame / store->gop_frames;
    sc_status status = SC_OK;

    if (store->encoding != gop) {
        if (!can_encode(store, gop))
            return SC_OK; /* the process that finds all of its pictures encodes it */
        status = begin_gop(ctx, store, gop);
    }
    return status == SC_OK ? encode_available(ctx, store, frame, picture) : status;
}

sc_status sc_store_encode_partial(const sc_ctx *ctx, sc_store *store)
{
    sc_stage_begin(ctx, "encoding", 0, (uint64_t)store->gop_count);
    for (int gop = 0; gop < store->gop_count; gop++) {
        const int first = gop * store->gop_frames;
        bool all = !store->outputs.has_segment[gop];

        sc_stage_add(ctx, 1);
        for (int k = first; k < first + sc_store_gop_frames(store, gop); k++)
            all = all && store->partial.locations[k].file >= 0;
        if (!all)
            continue;
        SC_PASS(begin_gop(ctx, store, gop));
        SC_PASS(encode_available(ctx, store, -1, NULL));
    }
    return SC_OK;
}

sc_status sc_store_join(const sc_ctx *ctx, sc_store *store, const char *path, int gops)
{
    sc_video_settings settings = store->job.settings;
    SC_OWN(sc_muxer_close_at) sc_muxer *muxer = NULL;

    settings.version = store->job.version;
    settings.job_hash = store->job.job_hash;
    settings.volume_hash = store->job.volume_hash;
    sc_stage_begin(ctx, "joining the video", 0, (uint64_t)gops);
    SC_PASS(sc_muxer_open(ctx, path, &settings, &muxer));
    for (int gop = 0; gop < gops; gop++) {
        char name[SC_FILE_BYTES];
        sc_segment segment = {0};
        SC_OWN(sc_free_at) char *data = NULL;

        /* Read, not mapped: the file may be cut meanwhile. */
        sc_store_path(store->directory, name, "segments/%06d.seg", gop);
        SC_PASS(sc_file_read(ctx, name, SC_SEGMENT_MAX_BYTES, &data, &segment.bytes));
        segment.data = data;
        SC_PASS(sc_muxer_add(ctx, muxer, &segment));
        sc_stage_add(ctx, 1);
    }
    return sc_muxer_finish(ctx, muxer, path, true);
}
