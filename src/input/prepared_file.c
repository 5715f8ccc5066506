/* SPDX-License-Identifier: BSD-3-Clause */
/* Prepared files: every rank maps the file; a node holds it once, and checks it once. */
#include "recipe.h"

#include <unistd.h>

/* What the first rank of a node tells the others of the file that it has mapped and checked. */
typedef struct checked_file {
    sc_file_identity identity;
    uint64_t hash; /* of the file */
    int64_t word;  /* HAS_CHECKED, HAS_FAILED; 0 of those that only listen */
} checked_file;
enum { HAS_CHECKED = 1, HAS_FAILED = 2 };

/* @return what the one rank of a team that has checked its file says, of @p all [count]. */
static const checked_file *word_of(const checked_file *all, int count)
{
    int i = 0;

    while (i < count - 1 && !all[i].word)
        i++;
    return &all[i];
}

/* What a rank reports of the file that it has mapped. Sent as bytes. */
typedef struct mapped_file {
    uint64_t hash;
    int32_t status;
    char host[SC_HOST_BYTES];
} mapped_file;

/* @return words for what a rank has mapped instead of rank 0's file. */
static const char *difference_of(const mapped_file *file)
{
    return file->status == SC_OK            ? "another file"
           : file->status == SC_ERR_MISSING ? "no such file"
                                            : "a damaged file";
}

/* Make sure that all ranks have mapped the same file: the same path can name different files on
 * different nodes (a node's own disk, a copy that was not renewed). Rank 0 compares and logs.
 * @param mine the return code of mapping on this rank. Collective, the same result on all ranks. */
static sc_status agree_on_file(const sc_app *app, const char *path, const sc_input *input,
                               sc_status mine)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    const int ranks = sc_comm_size(app->comm);
    mapped_file file = {.hash = input->volume.file_hash, .status = mine};
    int different = 0, example = 0;
    SC_OWN(sc_free_at) mapped_file *all = NULL;
    sc_status status = mine;

    sc_host_name(file.host);
    SC_PASS(sc_comm_gather(app->ctx, app->comm, &file, sizeof file, &all));
    for (int i = ranks - 1; first && i > 0; i--) {
        if (all[i].status != SC_OK || all[i].hash != all[0].hash) {
            different++;
            example = i;
        }
    }
    if (mine == SC_OK && different &&
        (all[example].status == SC_ERR_MEMORY || all[example].status == SC_ERR_WRITE))
        status =
            sc_fail(app->ctx, (sc_status)all[example].status,
                    "%s: rank %d on %s could not map the file into memory: %s", path, example,
                    all[example].host,
                    all[example].status == SC_ERR_MEMORY ? "out of memory" : "reading it failed");
    else if (mine == SC_OK && different)
        status = sc_fail(app->ctx, SC_ERR_DATA,
                         "%s: is not the same on all nodes: rank 0 has mapped it on %s, but %d of "
                         "%d ranks have not, the first of them rank %d, which has %s on %s; copy "
                         "the file to all nodes, or put it on a file system that they share",
                         path, all[0].host, different, ranks, example, difference_of(&all[example]),
                         all[example].host);
    if (!first)
        status = SC_OK; /* rank 0 decides for all */
    return sc_comm_agree(app->comm, status);
}

sc_status sc_share_labels(const sc_app *app, const sc_label *labels, sc_input *input)
{
    const size_t bytes = (size_t)input->volume.label_count * sizeof *labels;
    SC_OWN(sc_free_at) sc_label *copy = NULL;

    SC_PASS(sc_comm_agree(app->comm, sc_alloc(app->ctx, bytes, 1, &copy)));
    if (sc_comm_rank(app->comm) == 0)
        memcpy(copy, labels, bytes);
    sc_comm_broadcast(app->comm, copy, bytes);
    sc_free(input->labels);
    input->volume.labels = copy;
    SC_HAND_OVER(copy, &input->labels);
    return SC_OK;
}

/* Give the labels of a mapped file the names and colours of the job's label table, which rank 0
 * reads. Collective, the same result on all ranks. */
static sc_status name_labels(const sc_app *app, const sc_job *job, sc_input *input)
{
    sc_volume named = sc_volume_of_prepared(&input->volume);
    sc_status status = SC_OK;

    SC_PASS(sc_share_labels(app, input->volume.labels, input));
    named.labels = input->labels;
    if (sc_comm_rank(app->comm) == 0)
        status = sc_name_mapped(app, job, input, &named);
    SC_PASS(sc_comm_agree(app->comm, status));
    return sc_share_labels(app, input->labels, input);
}

/* @return whether a mapped file holds the grid from which the job's surfaces are taken. */
static bool has_grid(const sc_app *app, const sc_prepared *v, const sc_needs *n)
{
    const sc_volume view = sc_volume_of_prepared(v);
    const sc_ctx silent = {.rank = 0};
    sc_drawn_grid grid;

    if (n->as_prepared)
        return true;
    if (n->resize && memcmp(v->size, n->size, sizeof n->size) != 0)
        return false;
    if (!n->resample || v->how.resampled)
        return n->resample == v->how.resampled;
    if (v->how.as_drawn)
        return true;
    return sc_find_drawn_grid(&silent, &view, app->threads, &grid) == SC_OK &&
           !sc_is_resampled(&grid);
}

/* @return whether the tissues of a mapped file that the job shows are smoothed as it wants. */
static bool has_strengths(const sc_prepared *v, const sc_needs *n)
{
    for (int id = 1; id < v->label_count && !n->as_prepared; id++) {
        if (v->stats[id].voxels && !n->hidden[id] &&
            !sc_strength_is_same(v->how.smooth[id], n->tissue_smooth[id]))
            return false;
    }
    return true;
}

/* Does the prepared file hold what the job needs? @param why if not, what it was prepared with
 * instead; otherwise NULL. */
static bool fits(const sc_app *app, const sc_prepared *v, const sc_needs *n, const char **why)
{
    *why = NULL;
    if (!has_grid(app, v, n))
        *why = "another grid of voxels";
    else if (!has_strengths(v, n))
        *why = "another strength of smoothing";
    else if (n->local_thickness && !v->thickness)
        *why = "no local thickness";
    for (int id = 1; id < v->label_count && !*why; id++) {
        if (n->hidden[id] && !v->how.hidden[id] && v->stats[id].voxels)
            *why = "tissues that the job hides";
    }
    return !*why;
}

/* Refuse a prepared file in which a tissue that the job shows was turned into background. */
static sc_status check_hidden(const sc_ctx *ctx, const char *path, const sc_input *input,
                              const sc_needs *n)
{
    const sc_prepared *v = &input->volume;

    for (int id = 1; id < v->label_count && !input->measure; id++) {
        if (v->how.hidden[id] && !n->hidden[id])
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s: was prepared without \"%s\" (label %lld), which the job shows; "
                           "prepare it again",
                           path, v->labels[id].name, (long long)v->labels[id].value);
    }
    return SC_OK;
}

/* Map a prepared file, and have a message name it, should it be changed meanwhile. */
static sc_status map_file(const sc_ctx *ctx, const char *path, sc_watched_file **out)
{
    const size_t bytes = 4 * strlen(path) + 1; /* a byte is shown by 4 characters at most */
    sc_watched_file file = {.file = -1};
    const void *begin = NULL;
    void *block = NULL, *name;
    sc_status status;

    SC_TRY(sc_file_map_identified(ctx, path, &begin, &file.bytes, &file.identity, &file.file));
    SC_TRY(sc_alloc(ctx, bytes, 1, &name));
    file.name = name;
    sc_printable(path, name, bytes);
    SC_TRY(sc_alloc(ctx, 1, sizeof file, &block));
    file.begin = begin;
    *out = block;
    **out = file;
    sc_signals_watch_file(*out);
    return SC_OK;
out:
    sc_free(file.name);
    sc_file_unmap(begin, file.bytes);
    if (file.file >= 0)
        close(file.file);
    return status;
}

sc_status sc_map_prepared(const sc_app *app, const sc_ctx *ctx, const char *path,
                          sc_watched_file **file, sc_prepared *out)
{
    const sc_ctx silent = {.rank = 0};
    checked_file mine = {.word = 0};
    const checked_file *told;
    sc_team *team = NULL;
    void *all = NULL;
    bool first = true, trusted = false;
    sc_status status = map_file(ctx, path, file);

    if (status == SC_OK)
        mine.identity = (*file)->identity;
    if (sc_team_open(&silent, app->comm, 1, NULL, &team) == SC_OK)
        first = sc_team_is_first(team);
    if (first && status == SC_OK)
        status = sc_prepared_file_view(ctx, path, (*file)->begin, (*file)->bytes, out);
    if (first) {
        mine.hash = out->file_hash;
        mine.word = status == SC_OK ? HAS_CHECKED : HAS_FAILED;
    }
    if (team && sc_team_collect(&silent, team, &mine, sizeof mine, &all) == SC_OK) {
        told = word_of(all, sc_team_ranks(team));
        trusted = told->word == HAS_CHECKED &&
                  !memcmp(&told->identity, &mine.identity, sizeof mine.identity);
        mine.hash = told->hash;
    }
    if (!first && status == SC_OK && trusted) {
        status = sc_prepared_view(ctx, (*file)->begin, (*file)->bytes, out);
        out->file_hash = mine.hash;
    } else if (!first && status == SC_OK) {
        status = sc_prepared_file_view(ctx, path, (*file)->begin, (*file)->bytes, out);
    }
    sc_team_close(team);
    return status;
}

void sc_unmap_prepared(sc_watched_file **file)
{
    if (!*file)
        return;
    sc_signals_forget_file(*file);
    sc_file_unmap((*file)->begin, (*file)->bytes);
    close((*file)->file);
    sc_free((*file)->name);
    sc_free(*file);
    *file = NULL;
}

sc_status sc_inputs_check_files(const sc_ctx *ctx, const sc_inputs *inputs)
{
    for (int i = 0; i < 2 * inputs->count; i++) {
        const sc_input *input = &inputs->all[i / 2];
        const sc_watched_file *file = i % 2 ? input->kept : input->mapped;

        if (file && sc_watched_file_is_changed(file))
            return sc_fail(ctx, SC_ERR_WRITE,
                           "%s: was written into while frames were drawn from it; what was drawn "
                           "since is not kept. Run again with --resume when it is as it was",
                           file->name);
    }
    return SC_OK;
}

sc_status sc_input_map(const sc_app *app, sc_job *job, sc_input *input, bool *usable)
{
    const char *path = job->volume.path, *why = NULL;
    uint8_t fitting;
    const bool first = sc_comm_rank(app->comm) == 0;
    const sc_ctx silent = {.rank = 0};
    const sc_ctx *ctx = first ? app->ctx : &silent;
    SC_OWN(sc_needs_clear) sc_needs n = {0};
    sc_status status;

    if (sc_edits_volume(job) && job->volume.is_replaced) {
        sc_info(ctx,
                "%s: is prepared; what the job reads, merges, keeps and crops of its own volume is "
                "not done with it",
                path);
        sc_forget_volume_edits(job);
    }
    if (sc_edits_volume(job))
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: is prepared, and level, box, merge, keep and resample change a volume "
            "before that: "
            "give them to `segcast convert JOB.yaml -o FILE.segc`, or the volume that it was made "
            "from",
            path);
    sc_stage_begin(ctx, "checking the prepared volume", 0, 0);
    status = sc_map_prepared(app, ctx, path, &input->mapped, &input->volume);
    SC_PASS(agree_on_file(app, path, input, status));
    SC_PASS(name_labels(app, job, input));
    status = sc_needs_find(app, job, input->measure, input->volume.labels,
                           input->volume.label_count, &n);
    SC_PASS(sc_comm_agree(app->comm, status));
    SC_PASS(check_hidden(ctx, path, input, &n));
    if (input->volume.how.resampled && !n.resample && !input->measure)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: was prepared with render.smooth: auto, which has changed its grid of "
                       "voxels; prepare the volume again with the settings of this job",
                       path);
    /* Rank 0 decides for all: measuring the grid takes memory, which may fail on one rank only. */
    fitting = first && fits(app, &input->volume, &n, &why);
    sc_comm_broadcast(app->comm, &fitting, sizeof fitting);
    *usable = fitting != 0;
    if (*usable)
        input->bytes = input->mapped->bytes;
    else if (first)
        sc_warn(
            app->ctx,
            "%s: was prepared with %s; that is done anew, and kept only where the cache is used "
            "(SEGCAST_CACHE): `segcast convert` with the job instead of the volume makes a "
            "file that fits",
            path, why);
    return SC_OK;
}
