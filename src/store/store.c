/* SPDX-License-Identifier: BSD-3-Clause */
/* Opens the directory of a job, and accepts frames and GOPs. */
#include "internal.h"

#include <sys/stat.h>
#include <unistd.h>

bool sc_store_is_complete(const sc_store *store)
{
    return store->complete;
}

bool sc_store_is_sealed(const sc_store *store)
{
    return store->sealed;
}

bool sc_store_is_replaced(const sc_store *store)
{
    const sc_file_id *id = &store->manifest.id;
    char path[SC_FILE_BYTES];

    if (!id->inode)
        return false;
    sc_store_manifest_path(store, path);
    return !sc_file_has_id(path, id);
}

uint64_t sc_store_identity(const sc_store *store)
{
    return store->identity;
}

sc_store_times sc_store_time(const sc_store *store)
{
    return store->times;
}

/* ---- opening ---- */

/* Which manifests are in the directory: filled by find_manifest, from all false. */
typedef struct manifest_search {
    const sc_store *store; /* only directory and slice are read */
    bool own;              /* that of this slice, or of the whole job if this process does it */
    bool whole, any;       /* that of the whole job; any manifest */
} manifest_search;

/* For sc_each_file with a manifest_search as user: set its flags. */
static sc_status find_manifest(const sc_ctx *ctx, void *user, const char *path, const char *name)
{
    const sc_ctx quiet = sc_quiet(ctx);
    manifest_search *search = user;
    SC_OWN(sc_manifest_data_clear) sc_manifest_data data = {.frames = 0};
    const sc_status status = sc_manifest_read_head(&quiet, path, &data);
    char own[SC_FILE_BYTES];

    if (status != SC_OK || !data.head.known || sc_head_has_no_hashes(&data.head))
        return sc_is_of_input(status) ? SC_OK : status;
    sc_store_manifest_path(search->store, own);
    search->any = true;
    search->whole = search->whole || !strcmp(name, "manifest.jsonl");
    search->own = search->own || !strcmp(name, strrchr(own, '/') + 1);
    return SC_OK;
}

/* Refuse, with a message, a directory that holds a run: any manifest. A slice shares it with other
 * slices, and is refused only by its own manifest and by that of the whole job.
 * @return SC_ERR_CREATE. Reads directory and slice of the store alone. */
static sc_status refuse_run(const sc_ctx *ctx, const sc_store *store)
{
    manifest_search search = {.store = store};
    sc_status status =
        sc_each_file(ctx, store->directory, sc_is_manifest_name, &search, find_manifest);

    if (status != SC_OK || (store->role.slice ? !search.own && !search.whole : !search.any))
        return status;
    return sc_fail(ctx, SC_ERR_CREATE,
                   "%s: already holds a run; use --resume to continue it%s, or choose another "
                   "directory with -o",
                   store->directory, store->role.slice ? "" : ", --overwrite to begin anew");
}

/* What sc_store_check does, for a store of which directory, job and slice are set; what the run
 * owns is added to store->data.owned. @param fresh see sc_store_place. */
static sc_status check(const sc_ctx *ctx, sc_store *store, sc_store_mode mode, bool fresh)
{
    const sc_store_place place = {.directory = store->directory,
                                  .slice = store->role.slice,
                                  .video = store->job.video,
                                  .png = store->job.png,
                                  .joins = store->role.joins,
                                  .fresh = fresh,
                                  .frames = store->job.frames};
    sc_status status = sc_store_check_place(ctx, &place, &store->data.owned, &store->owns_more);

    return status == SC_OK && mode == SC_STORE_NEW ? refuse_run(ctx, store) : status;
}

/* Set the path of the directory. @return SC_ERR_CREATE if it is too long. */
static sc_status set_directory(const sc_ctx *ctx, sc_store *store, const char *directory)
{
    if (strlen(directory) > SC_DIRECTORY_MAX)
        return sc_fail(ctx, SC_ERR_CREATE,
                       "%.60s...: the path of the directory has %zu bytes, expected at most %d",
                       directory, strlen(directory), SC_DIRECTORY_MAX);
    strcpy(store->directory, directory);
    return SC_OK;
}

/* For SC_OWN, of a store that was not opened. */
static void clear_probe(sc_store *store)
{
    sc_manifest_data_clear(&store->data);
}

sc_status sc_store_check(const sc_ctx *ctx, const char *directory, const sc_store_job *job,
                         const char *slice, sc_store_mode mode)
{
    SC_OWN(clear_probe) sc_store probe = {.job = *job, .role.slice = slice};

    SC_PASS(set_directory(ctx, &probe, directory));
    return check(ctx, &probe, mode, false);
}

/* ---- before the volume is read ---- */

/* Set *may to whether the run may write status.json although the manifest @p path is there: it is
 * one of a run that was not completed. @param none whether it is none of a run at all.
 * @return the failure of the machine, logged, because of which neither is known. */
static sc_status may_write_beside(const sc_ctx *ctx, const char *path, bool *may, bool *none)
{
    const sc_ctx quiet = sc_quiet(ctx);
    SC_OWN(sc_manifest_data_clear) sc_manifest_data data = {.frames = 0};
    const sc_status status =
        access(path, F_OK) == 0 ? sc_manifest_read(&quiet, path, &data) : SC_ERR_MISSING;
    const bool known = status == SC_OK && data.head.known;
    const bool complete = known && (data.end.known || data.closed);

    *none = !known || sc_head_has_no_hashes(&data.head);
    *may = !*none && !complete;
    return sc_is_of_input(status) ? SC_OK : status;
}

/* Fill the paths and numbers of @p begun, of what is going to be made. */
static sc_status note_begun(const sc_ctx *ctx, const sc_store *store, sc_store_begun *begun)
{
    char path[SC_FILE_BYTES];
    sc_text text = {0};

    SC_PASS(sc_text_add(ctx, &text, "%s/", store->directory));
    begun->directory = text.data;
    text = (sc_text){0};
    sc_store_manifest_path(store, path);
    SC_PASS(sc_text_copy(ctx, path, &begun->manifest));
    SC_PASS(sc_text_add(ctx, &text, "%s/status%s%s.json", store->directory,
                        store->role.slice ? "." : "", store->role.slice ? store->role.slice : ""));
    begun->status = text.data;
    if (begun->made_directory)
        begun->numbers[0] = sc_unfinished_add(begun->directory);
    begun->numbers[1] = sc_unfinished_add(begun->manifest);
    begun->numbers[2] = sc_unfinished_add(begun->status);
    begun->made = true;
    return SC_OK;
}

sc_status sc_store_begin(const sc_ctx *ctx, const char *directory, const sc_store_job *job,
                         const char *slice, sc_store_mode mode, sc_store_begun *out)
{
    SC_OWN(clear_probe) sc_store store = {.job = *job, .role.slice = slice};
    SC_OWN(sc_store_unbegin) sc_store_begun begun = {.numbers = {-1, -1, -1}};
    char path[SC_FILE_BYTES];
    bool none, none_whole, may;

    SC_PASS(set_directory(ctx, &store, directory));
    begun.made_directory = access(directory, F_OK) != 0;
    sc_store_manifest_path(&store, path);
    SC_PASS(may_write_beside(ctx, path, &may, &none));
    begun.may_write = may && mode == SC_STORE_RESUME;
    if (slice) { /* the records beside the manifest of a complete job are proven by that */
        sc_store_path(store.directory, path, "manifest.jsonl");
        SC_PASS(may_write_beside(ctx, path, &may, &none_whole));
        begun.may_write = begun.may_write && none_whole;
        none = none && none_whole;
        sc_store_manifest_path(&store, path);
    }
    if (none) {
        /* First the check: what is noted as begun is removed after an error. */
        SC_PASS(check(ctx, &store, mode, false));
        SC_PASS(note_begun(ctx, &store, &begun));
        SC_PASS(sc_make_directory(ctx, directory));
        store.job.job_hash = store.job.volume_hash = 0;
        SC_PASS(sc_manifest_create(ctx, path, &store.job, &store.data, NULL, false, NULL, NULL));
        begun.may_write = true;
    }
    SC_HAND_OVER(begun, out);
    return SC_OK;
}

void sc_store_unbegin(sc_store_begun *begun)
{
    if (begun->made) {
        unlink(begun->status);
        unlink(begun->manifest);
        if (begun->made_directory)
            rmdir(begun->directory);
    }
    sc_store_begun_clear(begun);
}

void sc_store_begun_clear(sc_store_begun *begun)
{
    for (int i = 0; begun->made && i < (int)SC_COUNT_OF(begun->numbers); i++)
        sc_unfinished_drop(begun->numbers[i]);
    sc_free(begun->directory);
    sc_free(begun->manifest);
    sc_free(begun->status);
    *begun = (sc_store_begun){0};
}

/* Allocate the arrays of the store, zeroed, and the buffer for a picture. Needs job and gop_count.
 * Also after an error sc_store_close frees them. */
static sc_status allocate(const sc_ctx *ctx, sc_store *store)
{
    const size_t frames = (size_t)store->job.frames, gops = (size_t)store->gop_count;

    SC_PASS(SC_ZALLOC(ctx, frames, &store->data.lines));
    store->data.frames = store->job.frames;
    SC_PASS(SC_ZALLOC(ctx, frames, &store->outputs.wanted));
    SC_PASS(SC_ZALLOC(ctx, frames, &store->outputs.has_png));
    SC_PASS(SC_ZALLOC(ctx, gops, &store->outputs.has_segment));
    return sc_alloc(ctx, sc_picture_bytes(store->job.video, &store->job.settings), 1,
                    &store->picture);
}

/* Make segments/ and frames/, as far as the job needs them. After an error those that were not
 * there before are not there: nobody would know who made them once the manifest is removed. */
static sc_status make_folders(const sc_ctx *ctx, const sc_store *store)
{
    const char *const names[] = {store->has_video ? "segments" : NULL,
                                 store->job.png ? "frames" : NULL};
    bool made[SC_COUNT_OF(names)] = {false};
    char path[SC_FILE_BYTES];
    sc_status status = SC_OK;

    for (size_t i = 0; i < SC_COUNT_OF(names); i++) {
        bool existed;

        if (!names[i])
            continue;
        sc_store_path(store->directory, path, "%s", names[i]);
        existed = access(path, F_OK) == 0;
        SC_TRY(sc_make_directory(ctx, path));
        made[i] = !existed;
    }
out:
    for (size_t i = 0; i < SC_COUNT_OF(names) && status != SC_OK; i++) {
        if (!made[i])
            continue;
        sc_store_path(store->directory, path, "%s", names[i]);
        rmdir(path);
    }
    return status;
}

/* For sc_each_record with the store as user: remove the line of a record, which is written anew. */
static sc_status drop_record(const sc_ctx *ctx, void *user, const char *name)
{
    sc_store *store = user;

    sc_file_lines_remove(&store->data.files, name);
    return SC_OK;
}

/* Begin the run after a scan: set store->wanted to the frames of @p wanted that are not there, make
 * the folders, open the encoder, and write the manifest of this process with the lines of those
 * that are. Lines of frames that are not there become unknown. Without any wanted frames the
 * encoder is left out. */
static sc_status begin_run(const sc_ctx *ctx, sc_store *store, const int *wanted, int wanted_count)
{
    char path[SC_FILE_BYTES];
    SC_OWN(sc_free_at) bool *keep = NULL;

    SC_PASS(SC_ZALLOC(ctx, (size_t)store->job.frames, &keep));
    for (int k = 0; k < store->job.frames; k++)
        store->data.lines[k].known = sc_store_has(store, k);
    for (int i = 0; i < wanted_count; i++) {
        keep[wanted[i]] = sc_store_has(store, wanted[i]);
        store->outputs.wanted[wanted[i]] = !keep[wanted[i]];
    }
    if (wanted_count > 0 && store->has_video)
        SC_PASS(sc_store_open_encoder(ctx, store)); /* if it fails, then before anything is drawn */
    if (!store->role.joins)
        SC_PASS(sc_each_record(ctx, store->role.slice, store, drop_record));
    store->data.end = (sc_manifest_end){.known = false};
    /* The manifest says what segcast makes here, and is on disk before anything else is made. */
    sc_store_manifest_path(store, path);
    if (!store->role.joins || store->owns_more)
        SC_PASS(sc_manifest_create(ctx, path, &store->job, &store->data, keep, store->role.joins,
                                   store->role.joins ? NULL : &store->manifest.id,
                                   store->role.joins ? NULL : &store->manifest.writer));
    return make_folders(ctx, store);
}

/* Remove what a run that ended by an accident, after it had completed the job, has left, and forget
 * the lines of the records, which are written again. */
static sc_status clean_up(const sc_ctx *ctx, sc_store *store)
{
    sc_store_remove_unfinished(ctx, store);
    if (!store->role.joins)
        (void)sc_each_record(ctx, store->role.slice, store, drop_record);
    return sc_store_remove_slices(ctx, store);
}

/* Remove what earlier runs have made; the run then owns what it makes itself, and no more. */
static sc_status begin_anew(const sc_ctx *ctx, sc_store *store)
{
    char path[SC_FILE_BYTES];

    SC_PASS(sc_store_remove_run(ctx, store));
    sc_file_lines_clear(&store->data.owned);
    /* This stays until it is replaced. */
    SC_PASS(sc_names_add(ctx, &store->data.owned, "job.yaml"));
    SC_PASS(sc_job_texts_put_file(ctx, store->directory, &store->data.jobs));
    SC_PASS(check(ctx, store, SC_STORE_OVERWRITE, true));
    sc_store_path(store->directory, path, "manifest.jsonl");
    return sc_manifest_create(ctx, path, &store->job, &store->data, NULL, false, NULL, NULL);
}

sc_status sc_store_open(const sc_ctx *ctx, const char *directory, const sc_store_job *job,
                        const int *wanted, int wanted_count, const char *slice, sc_store_mode mode,
                        sc_store **out)
{
    SC_OWN(sc_store_close_at) sc_store *store = NULL;
    char path[SC_FILE_BYTES];

    SC_PASS(SC_ZALLOC(ctx, 1, &store));
    store->job = *job;
    store->role.slice = slice;
    store->role.joins = !wanted;
    store->has_video = strcmp(job->video, "none") != 0;
    store->identity = sc_identity_of(job->job_hash, job->volume_hash, job->frames, job->version);
    store->encoding = -1;
    store->gop_frames = sc_video_gop_frames(&job->settings);
    store->gop_count = (job->frames + store->gop_frames - 1) / store->gop_frames;
    SC_PASS(set_directory(ctx, store, directory));
    SC_PASS(allocate(ctx, store));
    sc_store_path(store->directory, path, "segments");
    SC_PASS(sc_partial_open(ctx, path, store->identity,
                            sc_picture_bytes(job->video, &job->settings), job->frames,
                            &store->partial));
    SC_PASS(sc_make_directory(ctx, directory));
    SC_PASS(check(ctx, store, mode, false));
    if (mode == SC_STORE_OVERWRITE)
        SC_PASS(begin_anew(ctx, store));
    sc_remove_temporaries(directory, false); /* what a run that was killed has left */
    SC_PASS(sc_store_scan(ctx, store));
    store->role.takes_over = mode == SC_STORE_RESUME;
    for (int i = 0; i < wanted_count; i++)
        store->role.takes_over = store->role.takes_over && sc_store_has(store, wanted[i]);
    SC_PASS(sc_store_set_all_aside(ctx, store));
    if (store->complete && store->sealed)
        sc_store_remove_unfinished(ctx, store); /* what a run has left that the last one replaced */
    else if (store->complete)
        SC_PASS(clean_up(ctx, store));
    if (!store->complete)
        SC_PASS(begin_run(ctx, store, wanted, wanted_count));
    SC_HAND_OVER(store, out);
    return SC_OK;
}

void sc_store_close(sc_store *store)
{
    if (!store)
        return;
    sc_manifest_close(store->manifest.writer);
    sc_encoder_close(store->encoder);
    sc_partial_close(&store->partial);
    sc_free(store->data.lines);
    sc_manifest_data_clear(&store->data);
    sc_free(store->outputs.wanted);
    sc_free(store->outputs.has_png);
    sc_free(store->outputs.has_segment);
    sc_free(store->picture);
    sc_free(store);
}

sc_status sc_store_whole_gops(const sc_ctx *ctx, const sc_store *store, int **out, int *count)
{
    int *firsts, found = 0;

    SC_PASS(SC_ALLOC(ctx, (size_t)store->gop_count, &firsts));
    for (int gop = 0; gop < store->gop_count && store->has_video; gop++) {
        const int first = gop * store->gop_frames;
        bool whole = true;

        for (int k = first; k < first + sc_store_gop_frames(store, gop); k++)
            whole = whole && store->outputs.wanted[k] && !sc_store_has_picture(store, k);
        if (whole)
            firsts[found++] = first;
    }
    *out = firsts;
    *count = found;
    return SC_OK;
}

/* ---- accepting frames and GOPs ---- */

/* Write the line of a frame to the manifest and to store->data.lines. The manifest is flushed to
 * disk once a second at most. */
static sc_status add_line(const sc_ctx *ctx, sc_store *store, const sc_done_frame *done)
{
    const double now_s = sc_wall_s();
    sc_status status = sc_manifest_add_frame(ctx, store->manifest.writer, done);

    store->data.lines[done->frame] = (sc_frame_line){true, *done};
    if (status == SC_OK && now_s > store->manifest.synced_s + 1) {
        status = sc_manifest_sync(ctx, store->manifest.writer);
        store->manifest.synced_s = sc_wall_s();
    }
    return status;
}

/* Keep the picture of a frame in a partial GOP, unless one is there, and encode it as far as
 * sc_store_encode can. Only for a GOP without a segment. */
static sc_status add_picture(const sc_ctx *ctx, sc_store *store, const sc_done_frame *done,
                             const sc_image *image)
{
    const int k = done->frame;
    const void *picture = sc_encoder_convert(store->encoder, image);

    if (store->partial.locations[k].file < 0 || store->partial.locations[k].hash != done->hash)
        SC_PASS(
            sc_partial_add(ctx, &store->partial, k / store->gop_frames, k, picture, done->hash));
    return sc_store_encode(ctx, store, k, picture);
}

/* Write the PNG file of a frame, and put its size and hash into @p done. */
static sc_status write_png(const sc_ctx *ctx, sc_store *store, const void *data, size_t bytes,
                           sc_done_frame *done)
{
    char path[SC_FILE_BYTES];
    sc_status status;

    sc_store_path(store->directory, path, "frames/%06d.png", done->frame);
    status = sc_file_write(ctx, path, data, bytes);
    done->png_bytes = bytes;
    done->png_hash = sc_store_hash_bytes(data, bytes);
    store->outputs.has_png[done->frame] = status == SC_OK;
    return status;
}

/* Compress @p image and write it as write_png does. */
static sc_status compress_png(const sc_ctx *ctx, sc_store *store, const sc_image *image,
                              sc_done_frame *done)
{
    SC_OWN(sc_free_at) char *data = NULL;
    size_t bytes;

    SC_PASS(sc_image_compress_png(ctx, image, "a frame in memory", &data, &bytes));
    return write_png(ctx, store, data, bytes, done);
}

sc_status sc_store_add_frame(const sc_ctx *ctx, sc_store *store, const sc_done_frame *done,
                             const sc_image *image)
{
    const double begin_s = sc_wall_s();
    sc_done_frame line = *done;
    double encoded_s;

    if (sc_store_is_replaced(store))
        return SC_ERR_INCOMPLETE;
    if (store->has_video && !store->outputs.has_segment[done->frame / store->gop_frames])
        SC_PASS(add_picture(ctx, store, done, image));
    encoded_s = sc_wall_s();
    store->times.encode_wall_s += encoded_s - begin_s;
    if (store->job.png)
        SC_PASS(compress_png(ctx, store, image, &line));
    SC_PASS(add_line(ctx, store, &line));
    store->times.write_wall_s += sc_wall_s() - encoded_s;
    return SC_OK;
}

sc_status sc_store_add_gop(const sc_ctx *ctx, sc_store *store, const sc_done_frame *done, int count,
                           const sc_segment *segment, const sc_segment *png)
{
    const double begin_s = sc_wall_s();
    const int first = done[0].frame, gop = first / store->gop_frames;
    sc_segment_info info;

    if (sc_store_is_replaced(store))
        return SC_ERR_INCOMPLETE;
    if (!sc_segment_inspect(segment, &info) || !sc_store_is_segment_of(store, &info, gop) ||
        info.first_frame != first || info.frame_count != count)
        return sc_fail(ctx, SC_ERR_INTERNAL,
                       "frames %d to %d: the segment that a rank sent is damaged or holds other "
                       "frames",
                       first, first + count - 1);
    for (int i = 0; i < count; i++) {
        sc_done_frame line = done[i];

        if (png)
            SC_PASS(write_png(ctx, store, png[i].data, png[i].bytes, &line));
        SC_PASS(add_line(ctx, store, &line));
    }
    SC_PASS(sc_store_write_segment(ctx, store, gop, segment));
    store->times.write_wall_s += sc_wall_s() - begin_s;
    return SC_OK;
}
