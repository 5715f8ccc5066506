/* SPDX-License-Identifier: BSD-3-Clause */
/* What earlier runs on a job have measured, from several files of statistics, so that the next run
 * can write it again. */
#include "internal.h"

#include <dirent.h>
#include <stdlib.h>

/* The largest stats.json that is read: that of about 4 million frames. */
#define STATS_BYTES_MAX ((size_t)1 << 30)

/* A run of two histories that are merged. */
typedef struct numbered_run {
    const sc_run_entry *run;
    int number; /* its index, those of the second history behind those of the first */
} numbered_run;

/* For qsort of numbered_run: entries of the same run one after the other, in the order of their
 * numbers. */
static int by_id(const void *a, const void *b)
{
    const numbered_run *x = a, *y = b;

    return x->run->id != y->run->id ? (x->run->id < y->run->id ? -1 : 1) : x->number - y->number;
}

/* For qsort of sc_past_frame: by number of the frame; of the same frame a measured one first, then
 * that of the latest run, then one that was there before. */
static int by_frame_and_age(const void *a, const void *b)
{
    const sc_past_frame *x = a, *y = b;

    if (x->result.frame != y->result.frame)
        return x->result.frame < y->result.frame ? -1 : 1;
    if (x->measured != y->measured)
        return x->measured ? -1 : 1;
    return x->run != y->run ? y->run - x->run : x->is_new - y->is_new;
}

/* Sort frames, and keep of each number the first in that order. */
static void sort_frames(sc_history *h)
{
    int kept = 0;

    qsort(h->frames, (size_t)h->frame_count, sizeof *h->frames, by_frame_and_age);
    for (int i = 0; i < h->frame_count; i++) {
        if (kept == 0 || h->frames[kept - 1].result.frame != h->frames[i].result.frame)
            h->frames[kept++] = h->frames[i];
    }
    h->frame_count = kept;
}

/* Move the run @p from to @p to, which owns nothing. */
static void move_run(sc_run_entry *from, sc_run_entry *to)
{
    *to = *from;
    from->hosts = NULL;
    from->rank_hosts = NULL;
    from->made_from = NULL;
}

/* Move the runs of both histories to the empty history @p all, each once: of entries of the same
 * run one that has ended. @param sorted room for all of them. @param place [their number] gets the
 * index in @p all by the number of the run. */
static void move_runs(sc_history *to, sc_history *more, numbered_run *sorted, int *place,
                      sc_history *all)
{
    const int count = to->run_count + more->run_count;

    for (int i = 0; i < count; i++)
        sorted[i] =
            (numbered_run){i < to->run_count ? &to->runs[i] : &more->runs[i - to->run_count], i};
    qsort(sorted, (size_t)count, sizeof *sorted, by_id);
    /* First the number of the first entry of the same run, which is never the larger one. */
    for (int i = 0; i < count; i++)
        place[sorted[i].number] = i > 0 && sorted[i - 1].run->id == sorted[i].run->id
                                      ? place[sorted[i - 1].number]
                                      : sorted[i].number;
    for (int i = 0; i < count; i++) {
        sc_run_entry *run = i < to->run_count ? &to->runs[i] : &more->runs[i - to->run_count];

        if (place[i] == i) {
            place[i] = all->run_count++;
            move_run(run, &all->runs[place[i]]);
            continue;
        }
        place[i] = place[place[i]];
        if (run->ended && !all->runs[place[i]].ended) {
            sc_run_entry_clear(&all->runs[place[i]]);
            move_run(run, &all->runs[place[i]]);
        }
    }
}

/* Add what @p more holds to @p to: runs that are not there yet, at the end, and of each frame the
 * record of its latest run. The runs of the added frames get their index in @p to. Takes what the
 * runs of @p more own. @return SC_ERR_MEMORY, both untouched. */
static sc_status merge(const sc_ctx *ctx, sc_history *to, sc_history *more)
{
    const size_t runs = (size_t)to->run_count + (size_t)more->run_count;
    SC_OWN(sc_history_clear) sc_history all = {0};
    SC_OWN(sc_free_at) void *sorted = NULL, *place = NULL;

    SC_PASS(sc_alloc(ctx, runs, sizeof(numbered_run), &sorted));
    SC_PASS(sc_alloc(ctx, runs, sizeof(int), &place));
    SC_PASS(
        sc_history_allocate(ctx, runs, (size_t)to->frame_count + (size_t)more->frame_count, &all));
    move_runs(to, more, sorted, place, &all);
    for (int i = 0; i < to->frame_count + more->frame_count; i++) {
        const bool is_new = i >= to->frame_count;
        sc_past_frame past = is_new ? more->frames[i - to->frame_count] : to->frames[i];

        if (past.run >= 0)
            past.run = ((const int *)place)[past.run + (is_new ? to->run_count : 0)];
        all.frames[all.frame_count++] = past;
    }
    sort_frames(&all);
    sc_history_clear(to);
    SC_HAND_OVER(all, to);
    return SC_OK;
}

sc_status sc_history_add(const sc_ctx *ctx, sc_history *history, const sc_frame_result *frames,
                         int count, int run)
{
    SC_OWN(sc_history_clear) sc_history more = {0};
    sc_status status;

    SC_TRY(sc_history_allocate(ctx, 0, (size_t)count, &more));
    for (int i = 0; i < count; i++)
        more.frames[more.frame_count++] =
            (sc_past_frame){.result = frames[i], .run = -1, .is_new = true};
    status = merge(ctx, history, &more);
    for (int i = 0; i < history->frame_count && status == SC_OK; i++) {
        sc_past_frame *past = &history->frames[i];

        /* Those that were there keep the run that they have, also if it is unknown; and a rank that
         * the run has not, which a forged manifest may name, is not of that run. */
        if (past->is_new && run >= 0 && past->result.rank < history->runs[run].ranks)
            past->run = run;
        past->is_new = false;
    }
out:
    return status;
}

sc_status sc_history_read(const sc_ctx *ctx, const char *path, const sc_job_hashes *job,
                          sc_history *history)
{
    const sc_ctx quiet = sc_quiet(ctx);
    const char *problem = NULL;
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes;
    SC_OWN(sc_history_clear) sc_history found = {0};
    sc_status status = sc_file_read(&quiet, path, STATS_BYTES_MAX, &text, &bytes);

    if (status == SC_ERR_MISSING)
        return SC_OK;
    if (status == SC_ERR_DATA) {
        problem = "is too large";
        status = SC_OK;
    } else if (status == SC_OK) {
        status = sc_stats_parse(ctx, text, job, &found, &problem);
    }
    if (status == SC_OK && problem)
        sc_warn(ctx, "%s: %s; what it says of earlier runs is left out", path, problem);
    else if (status == SC_OK)
        status = merge(ctx, history, &found);
    return status;
}

/* Is it the name of a file "stats.SLICE.json"? For scandir. */
static int is_stats_of_slice(const struct dirent *entry)
{
    const size_t length = strlen(entry->d_name), around = strlen("stats.") + strlen(".json");

    return length > around && !strncmp(entry->d_name, "stats.", strlen("stats.")) &&
           !strcmp(entry->d_name + length - strlen(".json"), ".json");
}

sc_status sc_history_read_slices(const sc_ctx *ctx, const char *directory, const sc_job_hashes *job,
                                 sc_history *history)
{
    struct dirent **entries;
    const int count = scandir(directory, &entries, is_stats_of_slice, alphasort);
    sc_status status = SC_OK;

    for (int i = 0; i < count; i++) {
        SC_OWN(sc_free_at) char *path = NULL;

        if (status == SC_OK)
            status = sc_path_join(ctx, directory, entries[i]->d_name, &path);
        if (status == SC_OK)
            status = sc_history_read(ctx, path, job, history);
        free(entries[i]);
    }
    if (count >= 0)
        free(entries);
    return status;
}

void sc_run_entry_clear(sc_run_entry *run)
{
    sc_free(run->hosts);
    sc_free(run->rank_hosts);
    sc_free(run->made_from);
    *run = (sc_run_entry){0};
}

void sc_history_clear(sc_history *history)
{
    for (int i = 0; i < history->run_count; i++)
        sc_run_entry_clear(&history->runs[i]);
    sc_free(history->runs);
    sc_free(history->frames);
    *history = (sc_history){0};
}
