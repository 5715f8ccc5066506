/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a film comes from: what it is made from, noted with its statistics, and the RO-Crate that
 * is made of those. */
#include "render/run.h"

#include <stdlib.h>
#include <string.h>
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

/* The names of what is in a directory. */
typedef struct part_list {
    sc_text names; /* each with a NUL byte behind it */
    int count;
} part_list;

/* For sc_store_each_part with a part_list as user. The crate is no part of itself. */
static sc_status note_part(const sc_ctx *ctx, void *user, const char *name)
{
    part_list *list = user;

    if (!strcmp(name, SC_CRATE_NAME))
        return SC_OK;
    list->count++;
    return sc_text_add(ctx, &list->names, "%s%c", name, '\0');
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
    SC_OWN(sc_text_clear) sc_text text = {0};
    SC_OWN(sc_free_at) char *path = NULL, *video = NULL;
    SC_OWN(sc_free_at) const char **names = NULL;
    SC_OWN(sc_history_clear) sc_history runs = {0};
    part_list parts = {.count = 0};
    char about[64];
    sc_crate crate = {.runs = &runs,
                      .job = {store_job->job_hash, store_job->volume_hash},
                      .version = store_job->version,
                      .name =
                          job->output.title[0] ? job->output.title : "Film of a segmented volume",
                      .about = about,
                      .done = "frames drawn",
                      .author = job->output.author,
                      .video = job->output.video};
    struct stat info;
    sc_status status = sc_store_each_part(ctx, directory, &parts, note_part);

    snprintf(about, sizeof about, "A film of %d frames, drawn", store_job->frames);
    if (status == SC_OK)
        status = SC_ALLOC(ctx, (size_t)parts.count + 1, &names);
    for (const char *name = parts.names.data; status == SC_OK && crate.part_count < parts.count;
         name += strlen(name) + 1)
        names[crate.part_count++] = name;
    crate.parts = names;
    SC_TRY(status);
    SC_TRY(read_runs(ctx, directory, &crate.job, &runs));
    SC_TRY(sc_path_join(ctx, directory, job->output.video, &video));
    if (is_complete && !stat(video, &info))
        crate.video_bytes = (uint64_t)info.st_size;
    SC_TRY(sc_crate_make(ctx, &crate, &text));
    SC_TRY(sc_path_join(ctx, directory, SC_CRATE_NAME, &path));
    status = sc_file_write(ctx, path, text.data, text.length_bytes);
out:
    sc_text_clear(&parts.names);
    return status;
}
