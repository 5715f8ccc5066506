/* SPDX-License-Identifier: BSD-3-Clause */
#include "internal.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- names ---- */

void sc_store_path(const sc_store *store, char out[2 * SC_NAME_BYTES], const char *fmt, ...)
{
    const int used = snprintf(out, 2 * SC_NAME_BYTES, "%s/", store->directory);
    va_list args;

    va_start(args, fmt);
    vsnprintf(out + used, (size_t)(2 * SC_NAME_BYTES - used), fmt, args);
    va_end(args);
}

void sc_store_manifest_path(const sc_store *store, char out[2 * SC_NAME_BYTES])
{
    if (store->slice)
        sc_store_path(store, out, "manifest.%s.jsonl", store->slice);
    else
        sc_store_path(store, out, "manifest.jsonl");
}

int sc_store_group_frames(const sc_store *store, int g)
{
    const int left = store->job.frames - g * store->group;

    return left < store->group ? left : store->group;
}

bool sc_store_has_picture(const sc_store *store, int k)
{
    return store->segment[k / store->group] || store->parts.places[k].file >= 0;
}

bool sc_store_has(const sc_store *store, int k)
{
    return store->complete ||
           (store->journal.lines[k].known && (!store->job.png || store->png[k]) &&
            (!store->has_video || sc_store_has_picture(store, k)));
}

bool sc_store_is_complete(const sc_store *store)
{
    return store->complete;
}

uint64_t sc_store_identity(const sc_store *store)
{
    return store->identity;
}

sc_store_times sc_store_time(const sc_store *store)
{
    return store->times;
}

static uint64_t identity_of(const sc_store_job *job)
{
    const uint64_t numbers[] = {job->job_hash, job->volume_hash, (uint64_t)job->frames};

    return sc_hash_bytes(job->version, strlen(job->version),
                         sc_hash_bytes(numbers, sizeof numbers, 0));
}

/* ---- opening ---- */

typedef struct presence {
    const sc_store *store;
    bool mine, whole, any;
} presence;

static sc_status look_for_manifest(const sc_ctx *ctx, void *user, const char *name)
{
    presence *p = user;
    char path[2 * SC_NAME_BYTES];

    (void)ctx;
    if (!sc_is_manifest_name(name))
        return SC_OK;
    sc_store_manifest_path(p->store, path);
    p->any = true;
    p->whole = p->whole || !strcmp(name, "manifest.jsonl");
    p->mine = p->mine || !strcmp(name, strrchr(path, '/') + 1);
    return SC_OK;
}

/* A new run needs a directory without one; slices may share it. */
static sc_status refuse_others(const sc_ctx *ctx, const sc_store *store)
{
    presence p = {.store = store};
    sc_status status = sc_each_file(ctx, store->directory, &p, look_for_manifest);

    if (status != SC_OK || (store->slice ? !p.mine && !p.whole : !p.any))
        return status;
    return sc_fail(ctx, SC_ERR_CREATE,
                   "%s: holds a run already; --resume goes on with it%s, or choose another "
                   "directory with -o",
                   store->directory, store->slice ? "" : ", --overwrite begins anew");
}

sc_status sc_store_check_new(const sc_ctx *ctx, const char *directory, const char *slice)
{
    sc_store probe = {.slice = slice};

    snprintf(probe.directory, sizeof probe.directory, "%s", directory);
    return refuse_others(ctx, &probe);
}

static sc_status remove_file(const sc_ctx *ctx, void *user, const char *name)
{
    const sc_store *store = user;
    char path[2 * SC_NAME_BYTES];

    (void)ctx;
    sc_store_path(store, path, "segments/%s", name);
    unlink(path);
    return SC_OK;
}

static sc_status remove_manifest(const sc_ctx *ctx, void *user, const char *name)
{
    const sc_store *store = user;
    char path[2 * SC_NAME_BYTES];

    (void)ctx;
    sc_store_path(store, path, "%s", name);
    if (sc_is_manifest_name(name))
        unlink(path);
    return SC_OK;
}

/* Frames of ours have six digits and more, and nothing else. */
static sc_status remove_frame(const sc_ctx *ctx, void *user, const char *name)
{
    const sc_store *store = user;
    const size_t digits = strspn(name, "0123456789");
    char path[2 * SC_NAME_BYTES];

    (void)ctx;
    sc_store_path(store, path, "frames/%s", name);
    if (digits >= 6 && !strcmp(name + digits, ".png"))
        unlink(path);
    return SC_OK;
}

static void remove_segments(const sc_ctx *ctx, sc_store *store)
{
    char path[2 * SC_NAME_BYTES];

    sc_store_path(store, path, "segments");
    sc_remove_temporaries(path, true);
    if (sc_each_file(ctx, path, store, remove_file) == SC_OK)
        rmdir(path); /* what is not ours stays */
}

static void remove_partial(const sc_ctx *ctx, const sc_store *store)
{
    char path[2 * SC_NAME_BYTES];
    sc_text partial = {0};

    sc_store_path(store, path, "%s", store->job.video);
    if (store->has_video && sc_video_partial_name(ctx, path, &partial) == SC_OK)
        unlink(partial.data);
    sc_text_clear(&partial);
}

static sc_status overwrite(const sc_ctx *ctx, sc_store *store)
{
    char path[2 * SC_NAME_BYTES];
    sc_status status = sc_each_file(ctx, store->directory, store, remove_manifest);

    remove_segments(ctx, store);
    remove_partial(ctx, store);
    sc_store_path(store, path, "%s", store->job.video);
    if (store->has_video)
        unlink(path);
    sc_store_path(store, path, "frames");
    return status == SC_OK ? sc_each_file(ctx, path, store, remove_frame) : status;
}

static sc_status allocate(const sc_ctx *ctx, sc_store *store)
{
    const size_t frames = (size_t)store->job.frames, groups = (size_t)store->group_count;
    void *block;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, frames, sizeof *store->journal.lines, &block));
    store->journal.lines = block;
    store->journal.frames = store->job.frames;
    SC_TRY(sc_zalloc(ctx, frames, sizeof *store->wanted, &block));
    store->wanted = block;
    SC_TRY(sc_zalloc(ctx, frames, sizeof *store->png, &block));
    store->png = block;
    SC_TRY(sc_zalloc(ctx, groups, sizeof *store->segment, &block));
    store->segment = block;
    SC_TRY(sc_alloc(ctx, sc_picture_bytes(&store->job.settings), 1, &store->picture));
out:
    return status;
}

/* The folders, and a manifest with the lines of what is proven. */
static sc_status begin(const sc_ctx *ctx, sc_store *store, const int *wanted, int wanted_count)
{
    char path[2 * SC_NAME_BYTES];
    void *keep = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, (size_t)store->job.frames, sizeof(bool), &keep));
    for (int i = 0; i < wanted_count; i++)
        ((bool *)keep)[wanted[i]] = sc_store_has(store, wanted[i]);
    for (int k = 0; k < store->job.frames; k++)
        store->journal.lines[k].known = store->journal.lines[k].known && sc_store_has(store, k);
    for (int i = 0; i < wanted_count; i++)
        store->wanted[wanted[i]] = !((bool *)keep)[wanted[i]];
    if (store->has_video) {
        sc_store_path(store, path, "segments");
        SC_TRY(sc_make_directory(ctx, path));
    }
    if (store->job.png) {
        sc_store_path(store, path, "frames");
        SC_TRY(sc_make_directory(ctx, path));
    }
    if (wanted_count == 0)
        goto out;         /* only to join what others did */
    if (store->has_video) /* one that is not there is told of before the work */
        SC_TRY(sc_store_open_encoder(ctx, store));
    sc_store_manifest_path(store, path);
    SC_TRY(sc_manifest_begin(ctx, path, &store->job, store->journal.lines, keep, &store->manifest));
out:
    sc_free(keep);
    return status;
}

sc_status sc_store_open(const sc_ctx *ctx, const char *directory, const sc_store_job *job,
                        const int *wanted, int wanted_count, const char *slice, sc_store_mode mode,
                        sc_store **out)
{
    sc_store *store = NULL;
    char path[2 * SC_NAME_BYTES];
    void *block;
    sc_status status = sc_zalloc(ctx, 1, sizeof *store, &block);

    if (status != SC_OK)
        return status;
    store = block;
    store->job = *job;
    store->slice = slice;
    store->has_video = strcmp(job->video, "none") != 0;
    store->identity = identity_of(job);
    store->encoding = -1;
    store->group = sc_video_gop_frames(&job->settings);
    store->group_count = (job->frames + store->group - 1) / store->group;
    snprintf(store->directory, sizeof store->directory, "%s", directory);
    SC_TRY(allocate(ctx, store));
    sc_store_path(store, path, "segments");
    SC_TRY(sc_parts_open(ctx, path, store->identity, sc_picture_bytes(&job->settings), job->frames,
                         &store->parts));
    SC_TRY(sc_make_directory(ctx, directory));
    if (mode == SC_STORE_NEW)
        SC_TRY(refuse_others(ctx, store));
    if (mode == SC_STORE_OVERWRITE)
        SC_TRY(overwrite(ctx, store));
    SC_TRY(sc_store_survey(ctx, store));
    if (!store->complete)
        SC_TRY(begin(ctx, store, wanted, wanted_count));
    *out = store;
    return SC_OK;
out:
    sc_store_close(store);
    return status;
}

void sc_store_close(sc_store *store)
{
    if (!store)
        return;
    sc_manifest_close(store->manifest);
    sc_encoder_close(store->encoder);
    sc_parts_close(&store->parts);
    sc_free(store->journal.lines);
    sc_free(store->wanted);
    sc_free(store->png);
    sc_free(store->segment);
    sc_free(store->picture);
    sc_free(store);
}

sc_status sc_store_whole_groups(const sc_ctx *ctx, const sc_store *store, int **out, int *count)
{
    void *firsts;
    int found = 0;
    sc_status status = sc_alloc(ctx, (size_t)store->group_count, sizeof(int), &firsts);

    if (status != SC_OK)
        return status;
    for (int g = 0; g < store->group_count && store->has_video; g++) {
        const int first = g * store->group;
        bool whole = true;

        for (int k = first; k < first + sc_store_group_frames(store, g); k++)
            whole = whole && store->wanted[k] && !sc_store_has_picture(store, k);
        if (whole)
            ((int *)firsts)[found++] = first;
    }
    *out = firsts;
    *count = found;
    return SC_OK;
}

/* ---- taking ---- */

static sc_status note_done(const sc_ctx *ctx, sc_store *store, const sc_done_frame *done)
{
    const double now_s = sc_wall_s();
    sc_line *line = &store->journal.lines[done->frame];
    sc_status status = sc_manifest_add(ctx, store->manifest, done);

    *line = (sc_line){true, *done};
    if (status == SC_OK && now_s > store->synced_s + 1) {
        status = sc_manifest_sync(ctx, store->manifest);
        store->synced_s = sc_wall_s();
    }
    return status;
}

static sc_status take_picture(const sc_ctx *ctx, sc_store *store, const sc_done_frame *done,
                              const sc_image *image)
{
    const int k = done->frame, group = k / store->group;
    const void *picture;
    sc_status status;

    picture = sc_encoder_convert(store->encoder, image);
    if (store->parts.places[k].file < 0)
        SC_TRY(sc_parts_add(ctx, &store->parts, group, k, picture, done->hash));
    status = sc_store_encode(ctx, store, k, picture);
out:
    return status;
}

sc_status sc_store_take(const sc_ctx *ctx, sc_store *store, const sc_done_frame *done,
                        const sc_image *image)
{
    const double begin_s = sc_wall_s();
    double encoded_s;
    sc_status status = SC_OK;

    if (store->has_video && !store->segment[done->frame / store->group])
        SC_TRY(take_picture(ctx, store, done, image));
    encoded_s = sc_wall_s();
    store->times.encode_wall_s += encoded_s - begin_s;
    if (store->job.png) {
        char path[2 * SC_NAME_BYTES];

        sc_store_path(store, path, "frames/%06d.png", done->frame);
        SC_TRY(sc_image_save_png(ctx, image, path));
        store->png[done->frame] = true;
    }
    status = note_done(ctx, store, done);
    store->times.write_wall_s += sc_wall_s() - encoded_s;
out:
    return status;
}

sc_status sc_store_take_group(const sc_ctx *ctx, sc_store *store, const sc_done_frame *done,
                              int count, const sc_segment *segment, const sc_segment *png)
{
    const double begin_s = sc_wall_s();
    const int first = done[0].frame, group = first / store->group;
    sc_segment_info info;
    sc_status status;

    if (!sc_segment_inspect(segment, &info) || info.identity != store->identity ||
        info.first_frame != first || info.frame_count != count ||
        count != sc_store_group_frames(store, group))
        return sc_fail(ctx, SC_ERR_INTERNAL, "frames %d to %d: came back as another segment", first,
                       first + count - 1);
    for (int i = 0; i < count; i++) {
        char path[2 * SC_NAME_BYTES];

        sc_store_path(store, path, "frames/%06d.png", first + i);
        if (png)
            SC_TRY(sc_file_write(ctx, path, png[i].data, png[i].bytes));
        store->png[first + i] = png != NULL;
        SC_TRY(note_done(ctx, store, &done[i]));
    }
    SC_TRY(sc_store_publish_segment(ctx, store, group, segment));
    store->times.write_wall_s += sc_wall_s() - begin_s;
out:
    return status;
}

/* ---- finishing ---- */

/* What is there from the beginning on, to be looked at. */
static sc_status write_partial(const sc_ctx *ctx, sc_store *store)
{
    char path[2 * SC_NAME_BYTES];
    sc_text partial = {0};
    int groups = 0;
    sc_status status = SC_OK;

    while (groups < store->group_count && store->segment[groups])
        groups++;
    if (!store->has_video || groups == 0)
        return SC_OK;
    sc_store_path(store, path, "%s", store->job.video);
    SC_TRY(sc_video_partial_name(ctx, path, &partial));
    status = sc_store_join(ctx, store, partial.data, groups);
out:
    sc_text_clear(&partial);
    return status;
}

static sc_status hash_video(const sc_ctx *ctx, const char *path, sc_end *out)
{
    const void *data;
    size_t bytes;
    sc_status status = sc_file_map(ctx, path, &data, &bytes);

    if (status != SC_OK)
        return status;
    *out = (sc_end){true, bytes, sc_hash_bytes(data, bytes, 0)};
    sc_file_unmap(data, bytes);
    return SC_OK;
}

static sc_status remove_slice(const sc_ctx *ctx, void *user, const char *name)
{
    return strcmp(name, "manifest.jsonl") != 0 ? remove_manifest(ctx, user, name) : SC_OK;
}

/* Every frame is there: the video, and a manifest of all with its end line. */
static sc_status complete(const sc_ctx *ctx, sc_store *store)
{
    char path[2 * SC_NAME_BYTES];
    const char *slice = store->slice;
    void *keep = NULL;
    sc_end end = {.known = true};
    sc_status status = SC_OK;

    if (store->has_video) {
        sc_store_path(store, path, "%s", store->job.video);
        SC_TRY(sc_store_join(ctx, store, path, store->group_count));
        SC_TRY(hash_video(ctx, path, &end));
    }
    SC_TRY(sc_alloc(ctx, (size_t)store->job.frames, sizeof(bool), &keep));
    memset(keep, true, (size_t)store->job.frames);
    sc_manifest_close(store->manifest);
    store->manifest = NULL;
    store->slice = NULL;
    sc_store_manifest_path(store, path);
    SC_TRY(sc_manifest_begin(ctx, path, &store->job, store->journal.lines, keep, &store->manifest));
    SC_TRY(sc_manifest_end(ctx, store->manifest, &store->job, &end));
    SC_TRY(sc_manifest_sync(ctx, store->manifest));
    if (slice)
        SC_TRY(sc_each_file(ctx, store->directory, store, remove_slice));
    remove_segments(ctx, store);
    remove_partial(ctx, store);
    sc_store_path(store, path, "frames");
    sc_remove_temporaries(path, true);
    sc_remove_temporaries(store->directory, false);
    store->complete = true;
out:
    store->slice = slice;
    sc_free(keep);
    return status;
}

static int count_missing(const sc_store *store)
{
    int missing = 0;

    for (int k = 0; k < store->job.frames; k++)
        missing += !sc_store_has(store, k);
    return missing;
}

/* Lines of all processes: a quick look whether this may be the last one. */
static sc_status count_lines(const sc_ctx *ctx, void *user, const char *name)
{
    sc_store *store = user;
    sc_journal journal = {0};
    char path[2 * SC_NAME_BYTES];
    sc_status status = SC_OK;

    if (!sc_is_manifest_name(name))
        return SC_OK;
    sc_store_path(store, path, "%s", name);
    if (access(path, R_OK) == 0)
        status = sc_journal_read(ctx, path, &journal);
    store->journal.count += journal.count;
    return status;
}

/* Make the video, if every frame is there. */
static sc_status try_to_complete(const sc_ctx *ctx, sc_store *store, int *missing)
{
    sc_status status = SC_OK;

    if (store->slice) {
        store->journal.count = 0;
        SC_TRY(sc_each_file(ctx, store->directory, store, count_lines));
        if (store->journal.count >= store->job.frames)
            SC_TRY(sc_store_survey(ctx, store));
    }
    *missing = store->complete ? 0 : count_missing(store);
    if (*missing > 0 || store->complete)
        goto out;
    if (store->has_video)
        SC_TRY(sc_store_encode_parts(ctx, store));
    SC_TRY(complete(ctx, store));
out:
    return status;
}

sc_status sc_store_finish(const sc_ctx *ctx, sc_store *store, int *missing)
{
    const double begin_s = sc_wall_s();
    const sc_ctx silent = {.rank = 0};
    sc_status status;

    *missing = 0;
    if (store->complete)
        return SC_OK;
    SC_TRY(sc_parts_sync(ctx, &store->parts));
    SC_TRY(sc_manifest_sync(ctx, store->manifest));
    /* Of two slices that end together the other may be clearing up what this one reads. */
    status = store->slice ? try_to_complete(&silent, store, missing) : SC_ERR_INTERNAL;
    if (status != SC_OK)
        SC_TRY(try_to_complete(ctx, store, missing));
    if (*missing > 0 && !store->slice)
        SC_TRY(write_partial(ctx, store));
out:
    store->times.encode_wall_s += sc_wall_s() - begin_s;
    return status;
}
