/* SPDX-License-Identifier: BSD-3-Clause */
/* The volumes of a job, one after the other: the only one, the phases of a beat, those between them
 * that are interpolated, or the subjects of a comparison. The first phase decides how the tissues
 * of all look. */
#include "recipe.h"

#include <errno.h>
#include <unistd.h>

sc_status sc_expect_series(sc_app *app)
{
    const char *input = app->options.input;
    int count = 1;
    double step_s;

    if (strpbrk(input, "*?") && access(input, F_OK) != 0)
        return sc_options_default(app->ctx, &app->options, "cine.bpm", "60");
    if (sc_comm_rank(app->comm) > 0) /* the job is read by rank 0 */
        return SC_OK;
    SC_PASS(sc_volume_phases(app->ctx, input, &count, &step_s));
    if (count > 1)
        return sc_options_default(app->ctx, &app->options, "cine.loop", "true");
    return SC_OK;
}

int sc_subject_count(const sc_job *job)
{
    return job->given.compare ? 1 + job->compare.count : 1;
}

void sc_job_keep_tissues(sc_job *job, sc_tissue_use use)
{
    size_t first = 0, count = 0;

    while (first < job->overlay_lists.tissue_count &&
           job->overlay_lists.tissues[first].of != (int)use)
        first++;
    while (first + count < job->overlay_lists.tissue_count &&
           job->overlay_lists.tissues[first + count].of == (int)use)
        count++;
    job->overlay_lists.tissues = count ? job->overlay_lists.tissues + first : NULL;
    job->overlay_lists.tissue_count = count;
}

void sc_job_of_input(const sc_job *job, int i, sc_job *out)
{
    const sc_subject *other = i && job->given.compare ? &job->compare.others[i - 1] : NULL;

    *out = *job;
    if (job->volume.phase_count) {
        memcpy(out->volume.path, job->volume.phases[i].path, sizeof out->volume.path);
        out->volume.phase = job->volume.phases[i].phase;
        out->given.cine = false;
        out->volume.phases = NULL;
        out->volume.phase_count = 0;
    }
    if (!other)
        return;
    sc_job_keep_tissues(out, SC_USE_NAMES); /* the legend is that of all */
    strcpy(out->volume.path, other->volume);
    strcpy(out->lines.volume, other->where);
    if (other->labels[0])
        strcpy(out->volume.labels, other->labels);
    if (!strcmp(other->image, "none")) {
        out->given.image = false;
        out->image = (sc_grey_options){0};
    } else if (other->image[0]) {
        strcpy(out->image.path, other->image);
        snprintf(out->lines.image, sizeof out->lines.image, "%s", other->where);
    }
}

uint64_t sc_inputs_hash(const sc_inputs *inputs)
{
    uint64_t hash = inputs->all[0].volume.volume_hash;

    for (int i = 1; i < inputs->count; i++) {
        const uint64_t next = inputs->all[i].volume.volume_hash;

        hash = sc_hash_bytes(&next, sizeof next, hash);
    }
    return hash;
}

uint64_t sc_inputs_bytes(const sc_inputs *inputs)
{
    uint64_t bytes = 0;

    for (int i = 0; i < inputs->count; i++)
        bytes += inputs->all[i].bytes;
    return bytes;
}

void sc_input_advise(const sc_input *input, sc_memory_use use)
{
    if (input->shared)
        sc_shared_advise(input->shared, use);
    if (input->mapped)
        sc_file_advise(input->mapped->begin, input->mapped->bytes, use);
    if (input->kept)
        sc_file_advise(input->kept->begin, input->kept->bytes, use);
}

void sc_inputs_free(sc_inputs *inputs)
{
    if (!inputs)
        return;
    for (int i = 0; i < inputs->count; i++)
        sc_input_clear(&inputs->all[i]);
    sc_free(inputs->all);
    sc_free(inputs);
}

/* Make room for the volumes of a job, @p each for each that it names. */
static sc_status new_inputs(const sc_ctx *ctx, const sc_job *job, int each, bool measure,
                            sc_inputs **out)
{
    const int count =
        job->volume.phase_count ? (int)job->volume.phase_count * each : sc_subject_count(job);

    SC_PASS(SC_ZALLOC(ctx, 1, out));
    SC_PASS(SC_ZALLOC(ctx, (size_t)count, &(*out)->all));
    (*out)->count = count;
    for (int i = 0; i < count; i++)
        (*out)->all[i].measure = measure;
    return SC_OK;
}

/* ---- phases ---- */

/* How messages call a phase. */
typedef struct phase_name {
    char text[SC_PATH_BYTES + 32];
} phase_name;

/* @return the first label, by number, that @p a has and @p b has not; NULL: none. */
static const sc_label *missing_label(const sc_prepared *a, const sc_prepared *b)
{
    int at = 0;

    for (int i = 0; i < a->label_count; i++) {
        while (at < b->label_count && b->labels[at].value < a->labels[i].value)
            at++;
        if (at == b->label_count || b->labels[at].value != a->labels[i].value)
            return &a->labels[i];
    }
    return NULL;
}

/* Do two grids lie in the same place, to a thousandth of a voxel? */
static bool is_same_place(const sc_prepared *a, const sc_prepared *b)
{
    sc_affine to_voxel;

    if (!sc_affine_invert(&a->to_ras_mm, &to_voxel))
        return true; /* which is refused as what it is */
    for (int corner = 0; corner < 8; corner++) {
        const sc_vec3 at = {corner & 1 ? a->size[0] : 0, corner & 2 ? a->size[1] : 0,
                            corner & 4 ? a->size[2] : 0};
        const sc_vec3 there = sc_affine_point(&to_voxel, sc_affine_point(&b->to_ras_mm, at));

        if (sc_vec3_length(sc_vec3_sub(there, at)) > 1e-3)
            return false;
    }
    return true;
}

/* Write how messages call a phase: its path and, of those in one file, its number. */
static void name_phase(const sc_job *job, int phase, phase_name *out)
{
    const sc_volume_path *p = &job->volume.phases[phase];

    if (p->phase)
        snprintf(out->text, sizeof out->text, "%s, phase %d", p->path, p->phase - 1);
    else
        snprintf(out->text, sizeof out->text, "%s", p->path);
}

sc_status sc_check_phase(const sc_ctx *ctx, const sc_job *job, const sc_prepared *a,
                         const sc_prepared *b, int index, bool all)
{
    const char *where = job->cine.where, *colon = *where ? ": " : "";
    const sc_label *lost = all ? missing_label(a, b) : NULL;
    const sc_label *more = all && !lost ? missing_label(b, a) : NULL, *label = lost ? lost : more;
    phase_name names[2];
    const char *first = names[0].text, *path = names[1].text;

    name_phase(job, 0, &names[0]);
    name_phase(job, index, &names[1]);
    if (memcmp(a->size, b->size, sizeof a->size) != 0)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s%s%s has %d x %d x %d voxels, but %s, the first phase, %d x %d x %d; "
                       "expected phases of the same grid",
                       where, colon, path, b->size[0], b->size[1], b->size[2], first, a->size[0],
                       a->size[1], a->size[2]);
    if (!is_same_place(a, b))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s%s%s lies elsewhere than %s, the first phase, or has voxels of another "
                       "size; expected phases of the same grid",
                       where, colon, path, first);
    if (a->how.resampled != b->how.resampled)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s%sof %s and %s, one was prepared on another grid (render.smooth: auto); "
                       "prepare all phases together: `segcast convert` with the job",
                       where, colon, first, path);
    if (label)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s%s%s has no label %lld%s%s%s, which %s has; expected the same labels in "
                       "all phases, or keep: or merge: under volume, which leave some out",
                       where, colon, lost ? path : first, (long long)label->value,
                       label->name[0] ? " (" : "", label->name, label->name[0] ? ")" : "",
                       lost ? first : path);
    return SC_OK;
}

sc_status sc_phase_path(const sc_ctx *ctx, const char *path, const char *ending, int phase,
                        int count, sc_text *text)
{
    const int stem = (int)(strlen(path) - strlen(ending));
    int digits = 2;

    for (int last = (count - 1) / 100; last > 0; last /= 10)
        digits++;
    return sc_text_add(ctx, text, "%.*s-%0*d%s", stem, path, digits, phase, path + stem);
}

/* ---- where phases are held ---- */

/* What is derived from a phase, from which pictures are drawn, takes about half as much again. */
#define DERIVED_SHARE 0.5

/* @return about how many bytes the volumes of all phases take with what is derived from them, of
 * which the first is loaded. @param files only what files have to be made for */
static double bytes_of_all(const sc_job *job, const sc_input *first, bool files)
{
    const double each = (double)first->bytes;
    const int between = job->cine.cine.between;
    const double count = (double)job->volume.phase_count, all = count * (1 + between);

    /* Of prepared files, what lies between them and what is derived are made here. */
    return each * (DERIVED_SHARE * all +
                   (files && !first->shared && !first->kept ? count * between : all));
}

/* @return whether the phases can be held in files: the first is, and there is room for all of them.
 * The same on all ranks. @param error if not, set to the errno that says why, or to 0 on ranks that
 * do not know it. */
static bool can_be_files(const sc_app *app, const sc_job *job, const sc_input *first, int *error)
{
    const sc_shared *shared = first->shared;
    const bool in_file = !shared || sc_shared_place_of(shared) == SC_SHARED_IN_FILE;
    const double more = bytes_of_all(job, first, true) - (shared ? (double)first->bytes : 0);

    *error = in_file ? 0 : sc_shared_file_error(shared);
    if (sc_comm_agree(app->comm, in_file ? SC_OK : SC_ERR_CREATE) != SC_OK)
        return false;
    *error = ENOSPC;
    return sc_comm_agree_room(app->comm, sc_temporary_folder(), (uint64_t)more) == SC_OK;
}

/* Decide where all phases but the first, which is loaded, are held: in files, or if there can be
 * none in memory, which rank 0 tells. Collective. @return SC_ERR_SYSTEM, logged by rank 0, if the
 * memory is too small for that. */
static sc_status choose_place(const sc_app *app, const sc_job *job, sc_inputs *inputs)
{
    const uint64_t limit = app->ctx->memory_max_bytes, machine = sc_machine_memory();
    const double most = (double)(limit && limit < machine ? limit : machine);
    const double bytes = bytes_of_all(job, inputs->all, false);
    const int count = inputs->count;
    int error;
    const bool in_files = can_be_files(app, job, inputs->all, &error);
    const char *why = error ? strerror(error) : "other nodes cannot make them";
    char size[24], room[24];
    sc_status status = SC_OK;

    sc_comm_prefer_files(app->comm, in_files);
    inputs->in_files = in_files;
    if (sc_comm_rank(app->comm) > 0)
        return sc_comm_agree(app->comm, SC_OK);
    sc_size_text(bytes, size);
    if (in_files)
        sc_info(
            app->ctx,
            "the %d phases take about %s, in files without names in %s; a rank has %d of them in "
            "memory at a time",
            count, size, sc_temporary_folder(), SC_PHASES_LOADED);
    else if (bytes > most)
        status =
            sc_fail(app->ctx, SC_ERR_SYSTEM,
                    "the %d phases take about %s, more than the memory of %s, and no files for "
                    "them can be made in %s: %s; name a directory that has room: "
                    "TMPDIR=DIRECTORY",
                    count, size, sc_size_text(most, room), sc_temporary_folder(), why);
    else
        sc_warn(app->ctx,
                "the %d phases take about %s and are all held in memory, because no files for them "
                "can be made in %s: %s; name a directory that has room: TMPDIR=DIRECTORY",
                count, size, sc_temporary_folder(), why);
    return sc_comm_agree(app->comm, status);
}

/* Tell, on rank 0, which volumes are the phases, in which order, and what comes between. */
static void tell_phases(const sc_app *app, const sc_job *job)
{
    const int count = (int)job->volume.phase_count;
    const char *first = sc_file_name(job->volume.phases[0].path);

    if (sc_comm_rank(app->comm) > 0)
        return;
    if (job->volume.phases[0].phase)
        sc_info(app->ctx, "%d phases of %s, from %d to %d; %g beats a minute", count, first,
                job->volume.phases[0].phase - 1, job->volume.phases[count - 1].phase - 1,
                job->cine.cine.bpm);
    else
        sc_info(app->ctx, "%d phases, from %s to %s; %g beats a minute", count, first,
                sc_file_name(job->volume.phases[count - 1].path), job->cine.cine.bpm);
    if (job->cine.cine.between)
        sc_info(app->ctx, "borders move between phases: %d are interpolated behind each of %d",
                job->cine.cine.between, count);
}

void sc_input_begin_phase(const sc_input *first, sc_input *out)
{
    *out = (sc_input){.measure = first->measure,
                      .is_later_phase = true,
                      .drawn = first->drawn,
                      .drawn_known = first->drawn_known};
}

void sc_input_begin_between(const sc_prepared *before, const sc_input *first, sc_input *out)
{
    sc_input_begin_phase(first, out);
    out->volume.how.resampled = before->how.resampled;
    out->volume.how.as_drawn = before->how.as_drawn;
    out->is_between = true;
}

/* ---- loading ---- */

/* The loading of all volumes of a job. */
typedef struct loading {
    sc_app *app;
    sc_job *job;
    sc_inputs *inputs;
    int each;         /* so many come of each that the job names: phases that are interpolated */
    bool prepares;    /* else they are only inspected, */
    bool header_only; /* without their voxels */
    sc_rank_record *times;
} loading;

static sc_status load_one(const loading *l, sc_app *app, sc_job *job, sc_input *input)
{
    return l->prepares ? sc_input_load(app, job, l->times, input)
                       : sc_input_inspect(app, job, l->header_only, input);
}

/* Let a phase leave the memory of this rank, if it is in a file. */
static void unload(const loading *l, int i)
{
    if (l->job->volume.phase_count)
        sc_input_advise(&l->inputs->all[i], SC_MEMORY_NOT_NEEDED);
}

/* Prepare the phases between phase @p from and that @p each behind it, or the first behind the
 * last, which are loaded. Collective. */
static sc_status load_gap(const loading *l, sc_app *app, int from)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    const int count = l->inputs->count, next = (from + l->each) % count;
    const sc_prepared *a = &l->inputs->all[from].volume;
    const sc_volume low = sc_volume_of_prepared(a);
    const sc_volume high = sc_volume_of_prepared(&l->inputs->all[next].volume);
    SC_OWN(sc_between_free_at) sc_between *between = NULL;
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    sc_job job;
    sc_status status = SC_OK;

    sc_job_of_input(l->job, from / l->each, &job);
    sc_stage_turn(app->ctx, from + 2, count);
    sc_stage_begin(app->ctx, "interpolating phases", 0, 0);
    if (first)
        status = sc_between_find(app->ctx, &low, &high, app->threads, &between);
    SC_PASS(sc_comm_agree(app->comm, status));
    for (int i = 1; i < l->each; i++) {
        sc_input *phase = &l->inputs->all[from + i];

        sc_input_begin_between(a, &l->inputs->all[0], phase);
        phase->given = first ? &volume : NULL;
        sc_stage_turn(app->ctx, from + i + 1, count);
        if (first)
            status = sc_copy_prepared(app->ctx, a, &volume);
        SC_PASS(sc_comm_agree(app->comm, status));
        if (first)
            sc_between_at(between, (double)i / l->each, &volume);
        SC_PASS(sc_input_load(app, &job, l->times, phase));
        phase->given = NULL;
        unload(l, from + i);
    }
    unload(l, from);
    unload(l, next);
    return SC_OK;
}

/* Load all volumes but the first, and those between phases. What is to be said of all phases has
 * been said of the first: only errors are logged. Collective. */
static sc_status load_others(const loading *l)
{
    const bool is_series = l->job->volume.phase_count > 0;
    const int count = l->inputs->count;
    sc_input *first = &l->inputs->all[0];
    sc_ctx errors = *l->app->ctx;
    sc_app later = *l->app;
    sc_job job;
    sc_status status = SC_OK;

    errors.level = SC_LOG_ERROR;
    if (is_series)
        later.ctx = &errors;
    later.label_source = NULL; /* it holds the table of the first */
    later.overlaps = NULL;
    sc_comm_broadcast(later.comm, &first->drawn, sizeof first->drawn);
    sc_comm_broadcast(later.comm, &first->drawn_known, sizeof first->drawn_known);
    for (int i = l->each; i < count; i += l->each) {
        sc_input *input = &l->inputs->all[i];

        sc_job_of_input(l->job, i / l->each, &job);
        if (is_series) {
            sc_input_begin_phase(first, input);
            sc_stage_turn(later.ctx, i + 1, count);
        }
        SC_PASS(load_one(l, &later, &job, input));
        if (is_series && sc_comm_rank(later.comm) == 0)
            status = sc_check_phase(l->app->ctx, l->job, &first->volume, &input->volume,
                                    i / l->each, !l->header_only);
        SC_PASS(sc_comm_agree(later.comm, status));
        unload(l, i);
    }
    for (int i = 0; i < count && l->each > 1; i += l->each)
        SC_PASS(load_gap(l, &later, i));
    return SC_OK;
}

/* Load all volumes of a job. */
static sc_status load_all(const loading *l)
{
    sc_app *app = l->app;
    const bool is_series = l->job->volume.phase_count > 0;
    sc_status status;

    sc_comm_prefer_files(app->comm, is_series && l->prepares);
    if (is_series) {
        tell_phases(app, l->job);
        sc_stage_turn(app->ctx, 1, l->inputs->count);
    }
    SC_TRY(load_one(l, app, l->job, &l->inputs->all[0]));
    if (is_series && l->prepares)
        SC_TRY(choose_place(app, l->job, l->inputs));
    unload(l, 0);
    status = load_others(l);
out:
    sc_stage_turn(app->ctx, 0, 0);
    return status;
}

sc_status sc_begin_phase_store(sc_app *app, const sc_job *job, sc_app *out)
{
    *out = *app;
    out->phase_store = NULL;
    if (!job->volume.phase_count || !job->volume.phases[0].phase || sc_comm_rank(app->comm) > 0)
        return SC_OK;
    return sc_phase_store_new(app->ctx, sc_temporary_folder(), &out->phase_store);
}

/* The same, with a store for phases that one file holds. Collective. */
static sc_status load_with_store(sc_app *app, const loading *how, bool measure, sc_inputs **out)
{
    sc_app own;
    loading l = *how;
    sc_status status;

    *out = NULL;
    status = sc_comm_agree(app->comm, sc_begin_phase_store(app, l.job, &own));
    if (status == SC_OK)
        status = sc_comm_agree(app->comm, new_inputs(app->ctx, l.job, l.each, measure, out));
    l.app = &own;
    l.inputs = *out;
    if (status == SC_OK)
        status = load_all(&l);
    sc_phase_store_free(own.phase_store);
    return status;
}

sc_status sc_inputs_load(sc_app *app, sc_job *job, bool measure, sc_rank_record *times,
                         sc_inputs **out)
{
    const loading l = {.job = job,
                       .each = job->volume.phase_count ? 1 + job->cine.cine.between : 1,
                       .prepares = true,
                       .times = times};

    return load_with_store(app, &l, measure, out);
}

sc_status sc_inputs_inspect(sc_app *app, sc_job *job, bool header_only, sc_inputs **out)
{
    const loading l = {.job = job, .each = 1, .header_only = header_only};

    return load_with_store(app, &l, false, out);
}
