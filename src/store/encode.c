/* SPDX-License-Identifier: BSD-3-Clause */
/* From pictures to segments, and from segments to the video. */
#include "internal.h"

#include <string.h>
#include <unistd.h>

sc_status sc_store_publish_segment(const sc_ctx *ctx, sc_store *store, int group,
                                   const sc_segment *segment)
{
    char path[2 * SC_NAME_BYTES];
    sc_status status;

    sc_store_path(store, path, "segments/%06d.seg", group);
    SC_TRY(sc_file_write(ctx, path, segment->data, segment->bytes));
    store->segment[group] = true;
    sc_parts_remove(&store->parts, group, group * store->group,
                    sc_store_group_frames(store, group));
    SC_TRY(sc_manifest_sync(ctx, store->manifest));
out:
    return status;
}

static sc_status end_group(const sc_ctx *ctx, sc_store *store)
{
    const int group = store->encoding;
    sc_segment segment = {0};
    sc_status status;

    store->encoding = -1;
    SC_TRY(sc_encoder_finish(ctx, store->encoder, store->identity, group * store->group, &segment));
    SC_TRY(sc_store_publish_segment(ctx, store, group, &segment));
out:
    sc_segment_free(&segment);
    return status;
}

/* Will all pictures of the group pass through this process, or are they here? */
static bool can_encode(const sc_store *store, int group)
{
    const int first = group * store->group;

    for (int k = first; k < first + sc_store_group_frames(store, group); k++) {
        if (store->parts.places[k].file < 0 && !store->wanted[k])
            return false;
    }
    return true;
}

sc_status sc_store_open_encoder(const sc_ctx *ctx, sc_store *store)
{
    char path[2 * SC_NAME_BYTES];

    if (store->encoder)
        return SC_OK;
    sc_store_path(store, path, "%s", store->job.video);
    return sc_encoder_open(ctx, path, &store->job.settings, &store->encoder);
}

static sc_status begin_group(const sc_ctx *ctx, sc_store *store, int group)
{
    sc_status status = sc_store_open_encoder(ctx, store);

    if (status != SC_OK)
        return status;
    if (sc_encoder_count(store->encoder) > 0)
        sc_encoder_drop(store->encoder);
    store->encoding = group;
    return SC_OK;
}

/* Push the pictures that follow and are here; @p frame's own is @p picture. */
static sc_status push_what_is_here(const sc_ctx *ctx, sc_store *store, int frame,
                                   const void *picture)
{
    const int first = store->encoding * store->group;
    const int end = first + sc_store_group_frames(store, store->encoding);
    sc_status status = SC_OK;

    for (int k = first + sc_encoder_count(store->encoder); k < end && status == SC_OK; k++) {
        const void *from = picture;

        if (store->parts.places[k].file < 0)
            break;
        if (k != frame) {
            status = sc_parts_read(ctx, &store->parts, k, store->picture);
            from = store->picture;
        }
        if (status == SC_OK)
            status = sc_encoder_push(ctx, store->encoder, from, store->parts.places[k].hash);
    }
    if (status == SC_OK && first + sc_encoder_count(store->encoder) == end)
        status = end_group(ctx, store);
    return status;
}

sc_status sc_store_encode(const sc_ctx *ctx, sc_store *store, int frame, const void *picture)
{
    const int group = frame / store->group;
    sc_status status = SC_OK;

    if (store->encoding != group) {
        if (!can_encode(store, group))
            return SC_OK; /* kept as a part; encoded when the rest is there */
        status = begin_group(ctx, store, group);
    }
    return status == SC_OK ? push_what_is_here(ctx, store, frame, picture) : status;
}

sc_status sc_store_encode_parts(const sc_ctx *ctx, sc_store *store)
{
    sc_status status = SC_OK;

    for (int g = 0; g < store->group_count && status == SC_OK; g++) {
        const int first = g * store->group;
        bool all = !store->segment[g];

        for (int k = first; k < first + sc_store_group_frames(store, g); k++)
            all = all && store->parts.places[k].file >= 0;
        if (!all)
            continue;
        status = begin_group(ctx, store, g);
        if (status == SC_OK)
            status = push_what_is_here(ctx, store, -1, NULL);
    }
    return status;
}

sc_status sc_store_join(const sc_ctx *ctx, sc_store *store, const char *path, int groups)
{
    sc_muxer *muxer = NULL;
    sc_status status;

    SC_TRY(sc_muxer_open(ctx, path, &muxer));
    for (int g = 0; g < groups && status == SC_OK; g++) {
        char name[2 * SC_NAME_BYTES];
        sc_segment segment = {0};
        const void *data;

        sc_store_path(store, name, "segments/%06d.seg", g);
        SC_TRY(sc_file_map(ctx, name, &data, &segment.bytes));
        segment.data = (void *)(uintptr_t)data;
        status = sc_muxer_add(ctx, muxer, &segment);
        sc_file_unmap(data, segment.bytes);
    }
    if (status == SC_OK)
        status = sc_muxer_finish(ctx, muxer, path);
out:
    sc_muxer_close(muxer);
    return status;
}
