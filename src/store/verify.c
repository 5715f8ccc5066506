/* SPDX-License-Identifier: BSD-3-Clause */
/* A finished directory, proven from its files alone. */
#include "internal.h"

#include <math.h>
#include <string.h>

typedef struct finding {
    const char *directory;
    sc_head head;
} finding;

static sc_status read_head(const sc_ctx *ctx, void *user, const char *name)
{
    finding *found = user;
    sc_journal journal = {0};
    char path[2 * SC_NAME_BYTES];
    sc_status status;

    if (found->head.known || !sc_is_manifest_name(name))
        return SC_OK;
    snprintf(path, sizeof path, "%s/%s", found->directory, name);
    status = sc_journal_read(ctx, path, &journal);
    if (status == SC_OK)
        found->head = journal.head;
    return status;
}

sc_status sc_store_identify(const sc_ctx *ctx, const char *directory, sc_store_job *job,
                            char *version)
{
    finding found = {.directory = directory};
    sc_status status = sc_each_file(ctx, directory, &found, read_head);

    if (status != SC_OK)
        return status;
    if (!found.head.known)
        return sc_fail(ctx, SC_ERR_MISSING, "%s: holds no run: there is no manifest.jsonl",
                       directory);
    snprintf(version, 64, "%s", found.head.version);
    job->version = version;
    job->job_hash = found.head.job_hash;
    job->volume_hash = found.head.volume_hash;
    job->frames = found.head.frames;
    job->settings.width_px = found.head.size_px[0];
    job->settings.height_px = found.head.size_px[1];
    return SC_OK;
}

typedef struct video_proof {
    const sc_ctx *ctx;
    const char *path;
    const sc_store_job *job;
    int frames;
} video_proof;

static sc_status check_video_frame(void *user, int k, double time_s, const sc_image *image)
{
    video_proof *p = user;
    const int width_px = (p->job->settings.width_px + 1) & ~1;
    const int height_px = (p->job->settings.height_px + 1) & ~1;
    const double expected_s = (double)k / p->job->settings.fps;

    p->frames = k + 1;
    if (fabs(time_s - expected_s) > 1e-3)
        return sc_fail(p->ctx, SC_ERR_DATA, "%s: frame %d is shown at %.4f s, expected %.4f",
                       p->path, k, time_s, expected_s);
    if (image->width_px != width_px || image->height_px != height_px)
        return sc_fail(p->ctx, SC_ERR_DATA, "%s: frame %d has %d x %d pixels, expected %d x %d",
                       p->path, k, image->width_px, image->height_px, width_px, height_px);
    return SC_OK;
}

static sc_status verify_video(const sc_ctx *ctx, const char *directory, const sc_store_job *job,
                              const sc_end *end)
{
    char path[2 * SC_NAME_BYTES];
    video_proof proof = {.ctx = ctx, .path = path, .job = job};
    sc_status status;

    snprintf(path, sizeof path, "%s/%s", directory, job->video);
    if (!sc_file_is(path, end->video_bytes, end->video_hash))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: is not the file of %llu bytes and hash %016llx that the manifest names",
                       path, (unsigned long long)end->video_bytes,
                       (unsigned long long)end->video_hash);
    status = sc_video_decode(ctx, path, check_video_frame, &proof);
    if (status == SC_OK && proof.frames != job->frames)
        return sc_fail(ctx, SC_ERR_DATA, "%s: holds %d frames, expected %d", path, proof.frames,
                       job->frames);
    return status;
}

static sc_status verify_frames(const sc_ctx *ctx, const char *directory, const sc_store_job *job,
                               const sc_journal *journal)
{
    void *proven;
    sc_status status = sc_alloc(ctx, (size_t)job->frames, sizeof(bool), &proven);

    if (status != SC_OK)
        return status;
    sc_prove_frames(directory, journal->lines, job->frames, job->threads, proven);
    for (int k = 0; k < job->frames && status == SC_OK; k++) {
        if (!((bool *)proven)[k])
            status = sc_fail(ctx, SC_ERR_DATA,
                             "%s/frames/%06d.png: is missing, torn, or not the picture of hash "
                             "%016llx that the manifest names",
                             directory, k, (unsigned long long)journal->lines[k].done.hash);
    }
    sc_free(proven);
    return status;
}

sc_status sc_store_verify(const sc_ctx *ctx, const char *directory, const sc_store_job *job)
{
    char path[2 * SC_NAME_BYTES];
    sc_journal journal = {.frames = job->frames};
    void *lines = NULL;
    sc_status status;

    snprintf(path, sizeof path, "%s/manifest.jsonl", directory);
    SC_TRY(sc_zalloc(ctx, (size_t)job->frames, sizeof *journal.lines, &lines));
    journal.lines = lines;
    SC_TRY(sc_journal_read(ctx, path, &journal));
    if (!journal.end.known) {
        status = sc_fail(ctx, SC_ERR_INCOMPLETE, "%s: has no end: %d of %d frames are there", path,
                         journal.count, job->frames);
        goto out;
    }
    for (int k = 0; k < job->frames; k++) {
        if (!journal.lines[k].known) {
            status = sc_fail(ctx, SC_ERR_DATA, "%s: frame %d is not named", path, k);
            goto out;
        }
    }
    if (journal.count != job->frames) {
        status = sc_fail(ctx, SC_ERR_DATA, "%s: names %d frames, expected %d", path, journal.count,
                         job->frames);
        goto out;
    }
    if (job->png)
        SC_TRY(verify_frames(ctx, directory, job, &journal));
    if (strcmp(job->video, "none") != 0)
        SC_TRY(verify_video(ctx, directory, job, &journal.end));
out:
    sc_free(lines);
    return status;
}
