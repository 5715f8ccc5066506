/* SPDX-License-Identifier: BSD-3-Clause */
/* The volumes of a series, which are shown as the phases of a beat. The first is the volume of the
 * session, and decides how tissues look; of the others, each has a session of its own, which holds
 * nothing but its volume. */
#include "phases.h"
#include "segcast/resample.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

sc_status sc_expect_series(sc_app *app)
{
    const char *input = app->options.input;
    int count = 1;
    double step_s;
    sc_status status;

    if (strpbrk(input, "*?") && access(input, F_OK) != 0)
        return sc_options_default(app->ctx, &app->options, "cine.bpm", "60");
    if (sc_comm_rank(app->comm) > 0) /* the job is read by rank 0 */
        return SC_OK;
    SC_TRY(sc_volume_phases(app->ctx, input, &count, &step_s));
    if (count > 1)
        status = sc_options_default(app->ctx, &app->options, "cine.loop", "true");
out:
    return status;
}

uint64_t sc_phases_hash(const sc_session *session)
{
    uint64_t hash = session->volume.volume_hash;

    for (int i = 1; i < sc_session_phase_count(session); i++) {
        const uint64_t next = sc_session_phase_volume(session, i)->volume_hash;

        hash = sc_hash_bytes(&next, sizeof next, hash);
    }
    return hash;
}

/* ---- loading ---- */

/* How messages call a phase. */
typedef struct phase_name {
    char text[SC_PATH_BYTES + 32];
} phase_name;

void sc_session_begin_phase(const sc_session *session, int phase, sc_session *out)
{
    const sc_volume_path *file = &session->job.phases[phase];

    *out = (sc_session){.measure = session->measure,
                        .job = session->job,
                        .drawn = session->drawn,
                        .drawn_known = session->drawn_known,
                        .is_later_phase = phase > 0,
                        .times = {.threads = session->times.threads}};
    memcpy(out->job.volume, file->path, sizeof out->job.volume);
    out->job.volume_phase = file->phase;
    out->job.has_cine = false;
    out->job.phases = NULL;
    out->job.phase_count = 0;
}

void sc_session_end_phase(sc_session *phase)
{
    sc_session_clear_volume(phase);
    *phase = (sc_session){0}; /* its job is another session's */
}

void sc_phases_free(sc_phases *phases)
{
    if (!phases)
        return;
    for (int i = 0; i < phases->count; i++)
        sc_session_end_phase(&phases->all[i]);
    sc_free(phases->all);
    sc_free(phases);
}

/* Make room for the phases of a session: @p each for each volume of the job. */
static sc_status new_phases(const sc_ctx *ctx, int each, sc_session *session)
{
    const size_t count = session->job.phase_count * (size_t)each - 1;
    void *block = NULL, *all = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, 1, sizeof *session->phases, &block));
    SC_TRY(sc_zalloc(ctx, count, sizeof(sc_session), &all));
    session->phases = block;
    *session->phases = (sc_phases){.count = (int)count,
                                   .all = all,
                                   .first_shared = session->shared,
                                   .first_mapped = session->mapped,
                                   .first_mapped_bytes = session->mapped_bytes};
    return SC_OK;
out:
    sc_free(block);
    return status;
}

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
static void name_phase(const sc_session *session, int phase, phase_name *out)
{
    const sc_volume_path *p = &session->job.phases[phase];

    if (p->phase)
        snprintf(out->text, sizeof out->text, "%s, phase %d", p->path, p->phase - 1);
    else
        snprintf(out->text, sizeof out->text, "%s", p->path);
}

sc_status sc_check_phase(const sc_ctx *ctx, const sc_session *session, const sc_prepared *a,
                         const sc_prepared *b, int index, bool all)
{
    const char *where = session->job.cine.where, *colon = *where ? ": " : "";
    const sc_label *lost = all ? missing_label(a, b) : NULL;
    const sc_label *more = all && !lost ? missing_label(b, a) : NULL, *label = lost ? lost : more;
    phase_name names[2];
    const char *first = names[0].text, *path = names[1].text;

    name_phase(session, 0, &names[0]);
    name_phase(session, index, &names[1]);
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
    if (a->resampled != b->resampled)
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

/* Add what loading @p phase took to the times of @p session. */
static void add_times(sc_session *session, const sc_session *phase)
{
    for (int i = 0; i < SC_PHASE_COUNT; i++) {
        session->times.phases[i].wall_s += phase->times.phases[i].wall_s;
        session->times.phases[i].cpu_s += phase->times.phases[i].cpu_s;
    }
}

/* How the volume of a session is loaded. */
typedef sc_status load_fn(sc_app *app, bool header_only, sc_session *session);

static sc_status load_prepared(sc_app *app, bool header_only, sc_session *session)
{
    (void)header_only;
    return sc_session_load_one(app, session);
}

/* ---- phases between those of files ---- */

void sc_session_begin_between(const sc_session *session, int phase, const sc_prepared *before,
                              sc_session *out)
{
    sc_session_begin_phase(session, phase, out);
    out->volume.resampled = before->resampled;
    out->volume.as_drawn = before->as_drawn;
    out->as_given = true;
}

/* Prepare the phases between phase @p from of a session and that @p each behind it, or the first
 * behind the last, which are loaded. Collective. */
static sc_status load_gap(sc_app *app, int from, int each, sc_session *session)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    const int next = (from + each) % (session->phases->count + 1);
    const sc_prepared *a = sc_session_phase_volume(session, from);
    const sc_volume low = sc_volume_of_prepared(a);
    const sc_volume high = sc_volume_of_prepared(sc_session_phase_volume(session, next));
    sc_between *between = NULL;
    sc_volume volume = {0};
    sc_status status = SC_OK;

    sc_stage_turn(app->ctx, from + 2, session->phases->count + 1);
    sc_stage_begin(app->ctx, "interpolating phases", 0, 0);
    if (first)
        status = sc_between_find(app->ctx, &low, &high, app->threads, &between);
    SC_TRY(sc_comm_agree(app->comm, status));
    for (int i = 1; i < each; i++) {
        sc_session *phase = &session->phases->all[from + i - 1];

        sc_session_begin_between(session, from / each, a, phase);
        phase->given = first ? &volume : NULL;
        sc_stage_turn(app->ctx, from + i + 1, session->phases->count + 1);
        if (first)
            status = sc_copy_prepared(app->ctx, a, &volume);
        SC_TRY(sc_comm_agree(app->comm, status));
        if (first)
            sc_between_at(between, (double)i / each, &volume);
        SC_TRY(sc_session_load_one(app, phase));
        phase->given = NULL;
        sc_session_unload_phase(session, from + i);
        add_times(session, phase);
        session->shared_bytes += phase->shared_bytes;
    }
    sc_session_unload_phase(session, from);
    sc_session_unload_phase(session, next);
out:
    sc_volume_clear(&volume);
    sc_between_free(between);
    return status;
}

/* @return how many phases of a session come of each volume of its job, where voxels are read. */
static int phases_each(const sc_session *session, load_fn *load)
{
    return load == load_prepared ? 1 + session->job.cine.cine.between : 1;
}

/* Load the volumes of all phases but the first by @p load, and then those between them. What is to
 * be said of all of them has been said of the first: only errors are logged. Collective. */
static sc_status load_phases(sc_app *app, load_fn *load, bool header_only, sc_session *session)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    const int each = phases_each(session, load), count = (int)session->job.phase_count;
    sc_ctx errors = *app->ctx;
    sc_app quieter = *app;
    sc_status status;

    errors.level = SC_LOG_ERROR;
    quieter.ctx = &errors;
    quieter.label_source = NULL;
    quieter.overlaps = NULL;
    sc_comm_broadcast(app->comm, &session->drawn, sizeof session->drawn);
    sc_comm_broadcast(app->comm, &session->drawn_known, sizeof session->drawn_known);
    for (int i = 1; i < count; i++) {
        sc_session *phase = &session->phases->all[i * each - 1];

        sc_session_begin_phase(session, i, phase);
        sc_stage_turn(app->ctx, i * each + 1, each * count);
        SC_TRY(load(&quieter, header_only, phase));
        if (first)
            status = sc_check_phase(app->ctx, session, &session->volume, &phase->volume, i,
                                    !header_only);
        SC_TRY(sc_comm_agree(app->comm, status));
        sc_session_unload_phase(session, i * each);
        add_times(session, phase);
        session->shared_bytes += phase->shared_bytes;
    }
    for (int i = 0; i < count && each > 1; i++)
        SC_TRY(load_gap(&quieter, i * each, each, session));
out:
    return status;
}

/* ---- where phases are held ---- */

/* What is derived from a phase, from which pictures are drawn, takes about half as much again. */
#define DERIVED_SHARE 0.5

/* @return about how many bytes the volumes of all phases take with what is derived from them, of
 * which the first is loaded. @param files only what files have to be made for */
static double bytes_of_all(const sc_session *session, bool files)
{
    const double each = (double)session->shared_bytes;
    const int between = session->job.cine.cine.between;
    const double count = (double)session->job.phase_count, all = count * (1 + between);

    /* Of prepared files, what lies between them and what is derived are made here. */
    return each * (DERIVED_SHARE * all + (files && !session->shared ? count * between : all));
}

/* @return whether the phases can be held in files: the first is, and there is room for all of them.
 * The same on all ranks. @param error if not, set to the errno that says why, or to 0 on ranks that
 * do not know it. */
static bool can_be_files(const sc_app *app, const sc_session *session, int *error)
{
    const sc_shared *shared = session->shared;
    const bool in_file = !shared || sc_shared_place_of(shared) == SC_SHARED_IN_FILE;
    const double more = bytes_of_all(session, true) - (shared ? (double)session->shared_bytes : 0);

    *error = in_file ? 0 : sc_shared_file_error(shared);
    if (sc_comm_agree(app->comm, in_file ? SC_OK : SC_ERR_CREATE) != SC_OK)
        return false;
    *error = ENOSPC;
    return sc_comm_agree_room(app->comm, sc_temporary_folder(), (uint64_t)more) == SC_OK;
}

/* Decide where all phases but the first, which is loaded, are held: in files, or if there can be
 * none in memory, which rank 0 tells. Collective. @return SC_ERR_SYSTEM, logged by rank 0, if the
 * memory is too small for that. */
static sc_status choose_place(const sc_app *app, const sc_session *session)
{
    const uint64_t limit = app->ctx->memory_max_bytes, machine = sc_machine_memory();
    const double most = (double)(limit && limit < machine ? limit : machine);
    const double bytes = bytes_of_all(session, false);
    const int count = session->phases->count + 1;
    int error;
    const bool in_files = can_be_files(app, session, &error);
    const char *why = error ? strerror(error) : "other nodes cannot make them";
    char size[24], room[24];
    sc_status status = SC_OK;

    sc_comm_prefer_files(app->comm, in_files);
    session->phases->in_files = in_files;
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
static void tell_phases(const sc_app *app, const sc_session *session)
{
    const sc_job *job = &session->job;
    const int count = (int)job->phase_count;
    const char *first = strrchr(job->phases[0].path, '/');
    const char *last = strrchr(job->phases[count - 1].path, '/');

    if (sc_comm_rank(app->comm) > 0)
        return;
    if (job->phases[0].phase)
        sc_info(app->ctx, "%d phases of %s, from %d to %d; %g beats a minute", count,
                first ? first + 1 : job->phases[0].path, job->phases[0].phase - 1,
                job->phases[count - 1].phase - 1, job->cine.cine.bpm);
    else
        sc_info(app->ctx, "%d phases, from %s to %s; %g beats a minute", count,
                first ? first + 1 : job->phases[0].path,
                last ? last + 1 : job->phases[count - 1].path, job->cine.cine.bpm);
    if (job->cine.cine.between)
        sc_info(app->ctx, "borders move between phases: %d are interpolated behind each of %d",
                job->cine.cine.between, count);
}

/* Load all phases by @p load. */
static sc_status load_series(sc_app *app, load_fn *load, bool header_only, sc_session *session)
{
    const bool is_series = session->job.phase_count > 0, draws = load == load_prepared;
    sc_status status;

    sc_comm_prefer_files(app->comm, is_series && draws);
    if (!is_series)
        return load(app, header_only, session);
    tell_phases(app, session);
    sc_stage_turn(app->ctx, 1, (int)session->job.phase_count * phases_each(session, load));
    SC_TRY(load(app, header_only, session));
    SC_TRY(sc_comm_agree(app->comm, new_phases(app->ctx, phases_each(session, load), session)));
    if (draws)
        SC_TRY(choose_place(app, session));
    sc_session_unload_phase(session, 0);
    status = load_phases(app, load, header_only, session);
out:
    sc_stage_turn(app->ctx, 0, 0);
    return status;
}

sc_status sc_begin_phase_store(sc_app *app, const sc_session *session, sc_app *out)
{
    *out = *app;
    out->phase_store = NULL;
    if (!session->job.phase_count || !session->job.phases[0].phase || sc_comm_rank(app->comm) > 0)
        return SC_OK;
    return sc_phase_store_new(app->ctx, sc_temporary_folder(), &out->phase_store);
}

/* The same, with a store for phases that one file holds. */
static sc_status load_all(sc_app *app, load_fn *load, bool header_only, sc_session *session)
{
    sc_app own;
    sc_status status = sc_comm_agree(app->comm, sc_begin_phase_store(app, session, &own));

    if (status == SC_OK)
        status = load_series(&own, load, header_only, session);
    sc_phase_store_free(own.phase_store);
    return status;
}

sc_status sc_session_load(sc_app *app, sc_session *session)
{
    return load_all(app, load_prepared, false, session);
}

sc_status sc_session_inspect_all(sc_app *app, bool header_only, sc_session *session)
{
    return load_all(app, sc_session_inspect, header_only, session);
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
