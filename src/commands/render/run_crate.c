/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a film comes from: what it is made from, noted with its statistics, and the RO-Crate that
 * is made of those. */
#include "render/run.h"

#include <stdlib.h>
#include <sys/stat.h>

sc_status sc_run_note_inputs(sc_run *run)
{
    const sc_inputs *inputs = run->session.inputs;
    SC_OWN(sc_made_from_clear) sc_made_from from = {.app = run->app};
    sc_text text = {0};
    sc_status status;

    /* A store of which a part or a coarser level is read may be too large to be read as a whole: no
     * more of it is than the voxels take that are, in the widest type. */
    for (int i = 0; i < inputs->count; i++) {
        const int *n = inputs->all[i].volume.size;

        from.store_most_bytes += (uint64_t)n[0] * (uint64_t)n[1] * (uint64_t)n[2] * 8;
    }
    sc_stage_begin(run->app->ctx, "hashing inputs", 0, 0);
    status = sc_made_from_add(&from, &run->session.job);
    sc_stage_end(run->app->ctx);
    if (status == SC_OK)
        status = sc_made_from_text(&from, &text);
    run->root.made_from = text.data;
    return status;
}

/* For qsort of sc_run_entry: by the time at which they began. */
static int by_begin(const void *a, const void *b)
{
    const sc_run_entry *x = a, *y = b;
    const int order = strcmp(x->begin, y->begin);

    return order ? order : (x->id > y->id) - (x->id < y->id);
}

/* Read all runs, in the order in which they began; their frames, which are known by the places of
 * runs, are of no use then. */
static sc_status read_runs(const sc_ctx *ctx, const char *directory, const sc_job_hashes *job,
                           sc_history *out)
{
    SC_OWN(sc_free_at) char *path = NULL;

    SC_PASS(sc_path_join(ctx, directory, "stats.json", &path));
    SC_PASS(sc_history_read(ctx, path, job, out));
    SC_PASS(sc_history_read_slices(ctx, directory, job, out));
    qsort(out->runs, (size_t)out->run_count, sizeof *out->runs, by_begin);
    return SC_OK;
}

sc_status sc_write_crate(const sc_ctx *ctx, const char *directory, const sc_job *job,
                         const sc_store_job *store_job, bool is_complete)
{
    const sc_output *output = &job->output;
    SC_OWN(sc_text_clear) sc_text text = {0}, parts = {0};
    SC_OWN(sc_free_at) char *path = NULL, *video = NULL;
    SC_OWN(sc_history_clear) sc_history runs = {0};
    char about[64];
    sc_crate crate = {.runs = &runs,
                      .job = {store_job->job_hash, store_job->volume_hash},
                      .version = store_job->version,
                      .name = output->title[0] ? output->title : "Film of a segmented volume",
                      .about = about,
                      .done = "frames drawn",
                      .author = output->author,
                      .video = output->video};
    struct stat info;

    snprintf(about, sizeof about, "A film of %d frames, drawn", store_job->frames);
    SC_PASS(sc_store_parts(ctx, directory, &parts));
    crate.parts = parts;
    SC_PASS(read_runs(ctx, directory, &crate.job, &runs));
    SC_PASS(sc_path_join(ctx, directory, output->video, &video));
    if (is_complete && !stat(video, &info))
        crate.video_bytes = (uint64_t)info.st_size;
    SC_PASS(sc_crate_make(ctx, &crate, &text));
    SC_PASS(sc_path_join(ctx, directory, SC_CRATE_NAME, &path));
    return sc_file_write(ctx, path, text.data, text.length_bytes);
}
