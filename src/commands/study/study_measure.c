/* SPDX-License-Identifier: BSD-3-Clause */
/* Measures a cell of a study: some of the ranks open its session and draw its frames through the
 * farm, as a render does, but keep only times and hashes. */
#include "render/run.h"
#include "study/study.h"

#include <time.h>

enum { PASSES_MAX = 1000 };

/* What a rank reports of a measurement; sent as bytes. */
typedef struct rank_times {
    sc_rank_record record; /* sums over all passes; reading, preparing and sharing once */
    double derive_cpu_s;   /* of preparing, what opening the scene took */
} rank_times;

/* A cell while it is measured, on one rank of its communicator. */
typedef struct visit {
    sc_study_state *state;
    sc_app *app; /* of the communicator */
    sc_session *session;
    int *frames, frame_count;
    double derive_s, derive_cpu_s; /* what opening its scene took */
    sc_rank_record times;          /* sums over all passes */
    /* on rank 0 */
    uint64_t rays, samples, contributions; /* of all passes */
    uint64_t hash;                         /* of the pass */
    double wall_s, accept_s, energy_j;     /* of all passes */
} visit;

/* ---- the farm ---- */

static sc_status draw(void *user, int frame, int row, int rows, sc_image *image,
                      sc_frame_result *result)
{
    visit *v = user;
    const sc_rows part = {row, row + rows};

    return sc_session_draw_frame(v->app, v->session, frame, &part, image, result);
}

/* Nothing is kept of a frame but its hash. Frames come in order. */
static sc_status accept_frame(void *user, const sc_frame_result *result, const sc_image *image)
{
    visit *v = user;

    v->rays += result->rays;
    v->samples += result->samples;
    v->contributions += result->contributions;
    v->hash = sc_hash_bytes(&result->hash, sizeof result->hash, v->hash);
    return SC_OK;
}

/* Draw the first @p count frames once, and add up what that takes. Collective on the ranks of the
 * cell. */
static sc_status draw_once(visit *v, int count)
{
    const sc_job *job = &v->session->job;
    const sc_farm farm = {.width_px = job->output.size_px[0],
                          .height_px = job->output.size_px[1],
                          .partition = (sc_partition)job->farm.partition,
                          .frames = v->frames,
                          .frame_count = count,
                          .gop_frames = 1,
                          .total_frames = job->animation.frames,
                          .calls.draw = draw,
                          .share_frames = job->farm.share,
                          .spoils_other_rows = sc_job_has_views(job),
                          .calls.accept_frame = accept_frame,
                          .stop = sc_signals_catch_stop(),
                          .calls.user = v};
    sc_farm_times times = {0};
    double wall_s, cpu_s, energy_j;

    v->hash = 0;
    SC_PASS(sc_comm_agree(v->app->comm, SC_OK)); /* all begin at the same time */
    wall_s = sc_wall_s();
    cpu_s = sc_cpu_s();
    energy_j = sc_energy_j();
    SC_PASS(sc_comm_agree(v->app->comm, sc_farm_run(v->app->ctx, v->app->comm, &farm, &times)));
    v->wall_s += sc_wall_s() - wall_s;
    v->energy_j += sc_energy_j() - energy_j;
    v->times.cpu_s += sc_cpu_s() - cpu_s;
    v->times.phases[SC_PHASE_RENDER].wall_s += times.render_wall_s;
    v->times.phases[SC_PHASE_RENDER].cpu_s += times.render_cpu_s;
    v->times.phases[SC_PHASE_IDLE].wall_s += times.idle_s;
    v->times.phases[SC_PHASE_GATHER].wall_s += times.gather_wall_s;
    v->accept_s += times.accept_wall_s;
    return SC_OK;
}

/* Forget what has been added up. */
static void begin_counting(visit *v)
{
    v->times = (sc_rank_record){0};
    v->rays = v->samples = v->contributions = 0;
    v->wall_s = v->accept_s = v->energy_j = 0;
}

/* Draw the frame list as often as the time says. @param passes how often. Collective on the ranks
 * of the cell. */
static sc_status draw_passes(visit *v, const sc_study_way *way, int *passes)
{
    int32_t count;

    *passes = 1;
    if (way->pilot)
        return draw_once(v, 1);
    SC_PASS(draw_once(v, 1)); /* warms up caches and threads; not counted */
    begin_counting(v);
    SC_PASS(draw_once(v, v->frame_count));
    count = v->wall_s < SC_MEASURED_S ? (int32_t)(SC_MEASURED_S / (v->wall_s + 1e-6)) : 0;
    count = count < PASSES_MAX ? count : PASSES_MAX - 1;
    sc_comm_broadcast(v->app->comm, &count, sizeof count);
    for (; *passes <= count; ++*passes)
        SC_PASS(draw_once(v, v->frame_count));
    return SC_OK;
}

/* ---- the session ---- */

/* Close the session that is held, on the ranks that have one. */
static void drop_held(sc_study_state *state)
{
    if (state->held.is_here)
        sc_session_clear(&state->held.session);
    state->held.is_here = false;
    state->held.is_anywhere = false;
}

/* Does the held session have the volume that @p cell needs, on the same ranks and threads? The same
 * on all ranks. */
static bool can_keep_volume(const sc_study_state *state, int cell)
{
    return state->held.is_anywhere &&
           sc_cells_share_volume(&state->cells[state->held.cell], &state->cells[cell]);
}

/* Fill state->held.session with the session of @p cell, with the volume of the one before if that
 * is the same. @param keeps can_keep_volume. Collective on the ranks of the cell. */
static sc_status open_session(visit *v, int cell, bool keeps)
{
    sc_study_state *state = v->state;
    const char *job = state->study.job[0] ? state->study.job : NULL;
    SC_OWN(sc_session_clear) sc_session before = state->held.session;
    double wall_s, cpu_s;
    sc_status status = SC_OK;

    state->held.session = (sc_session){0};
    if (sc_comm_rank(v->app->comm) == 0)
        status = sc_study_cell_options(state, cell, &v->app->options);
    SC_PASS(sc_comm_agree(v->app->comm, status));
    SC_PASS(sc_session_job(v->app, job, &state->held.session));
    if (keeps) {
        sc_session_move_inputs(&before, &state->held.session);
    } else {
        SC_PASS(sc_session_load(v->app, &state->held.session));
        state->held.load = state->held.session.times;
    }
    wall_s = sc_wall_s();
    cpu_s = sc_cpu_s();
    SC_PASS(sc_session_scene(v->app, &state->held.session));
    v->derive_s = sc_wall_s() - wall_s;
    v->derive_cpu_s = sc_cpu_s() - cpu_s;
    return SC_OK;
}

/* Send the frames that are measured from rank 0 to the others. Collective on the ranks of the cell.
 */
static sc_status share_frames(visit *v)
{
    sc_app *app = v->app;
    sc_status status = SC_OK;

    if (sc_comm_rank(app->comm) == 0)
        status = sc_study_frames(v->state, &v->session->job, &v->frames, &v->frame_count);
    SC_PASS(sc_comm_agree(app->comm, status));
    sc_comm_broadcast(app->comm, &v->frame_count, sizeof v->frame_count);
    return SC_BROADCAST(app, (size_t)v->frame_count, &v->frames);
}

/* ---- results ---- */

/* Add what one of @p ranks ranks has taken for @p passes passes to the measurement of one. */
static void add_rank(const sc_rank_record *r, int ranks, int passes, sc_measurement *m)
{
    const sc_phase_time *phases = r->phases;
    const double draw_s = phases[SC_PHASE_RENDER].wall_s / passes;

    m->cpu_s += r->cpu_s / passes;
    m->draw.cpu_s += phases[SC_PHASE_RENDER].cpu_s / passes;
    m->draw.most_s = fmax(m->draw.most_s, draw_s);
    m->draw.mean_s += draw_s / ranks;
    m->idle_mean_s += phases[SC_PHASE_IDLE].wall_s / passes / ranks;
    m->gather_mean_s += phases[SC_PHASE_GATHER].wall_s / passes / ranks;
    m->start.cpu_s +=
        phases[SC_PHASE_READ].cpu_s + phases[SC_PHASE_PREPARE].cpu_s + phases[SC_PHASE_SHARE].cpu_s;
    m->memory.peak_sum_bytes += r->peak_rss_bytes;
    if (r->peak_rss_bytes > m->memory.peak_most_bytes)
        m->memory.peak_most_bytes = r->peak_rss_bytes;
}

/* Gather the reports of all ranks, and make the measurement of them on rank 0. Collective on the
 * ranks of the cell. */
static sc_status report(visit *v, int cell, const sc_study_way *way, int passes,
                        sc_measurement *out)
{
    const sc_app *app = v->app;
    const sc_phase_time *phases = v->state->held.load.phases;
    const int ranks = sc_comm_size(app->comm);
    rank_times mine = {v->times, v->derive_cpu_s};
    SC_OWN(sc_free_at) rank_times *all = NULL;

    memcpy(mine.record.phases, phases, (SC_PHASE_SHARE + 1) * sizeof *phases);
    mine.record.phases[SC_PHASE_PREPARE].cpu_s += v->derive_cpu_s;
    mine.record.peak_rss_bytes = sc_peak_rss_since();
    SC_PASS(sc_comm_gather(app->ctx, app->comm, &mine, sizeof mine, &all));
    if (all) {
        *out = (sc_measurement){
            .cell = cell,
            .round = way->round,
            .passes = passes,
            .frames = way->pilot ? 1 : v->frame_count,
            .ranks = ranks,
            .nodes = sc_comm_node_count(app->comm),
            .threads = app->threads,
            .begin_unix_s = (int64_t)time(NULL),
            .wall_s = v->wall_s / passes,
            .accept_s = v->accept_s / passes,
            .start = {.read_s = phases[SC_PHASE_READ].wall_s,
                      .prepare_s = phases[SC_PHASE_PREPARE].wall_s + v->derive_s,
                      .share_s = phases[SC_PHASE_SHARE].wall_s,
                      .derive_s = v->derive_s},
            .work = {.rays = v->rays / (uint64_t)passes,
                     .samples = v->samples / (uint64_t)passes,
                     .contributions = v->contributions / (uint64_t)passes},
            .memory.prepared_bytes = sc_inputs_bytes(v->session->inputs),
            .energy_j = sc_energy_j() >= 0 && v->energy_j >= 0 ? v->energy_j / passes : -1,
            .pixels_hash = v->hash};
        for (int i = 0; i < ranks; i++) {
            add_rank(&all[i].record, ranks, passes, out);
            out->start.derive_cpu_s += all[i].derive_cpu_s;
        }
    }
    return SC_OK;
}

/* ---- whole jobs ---- */

/* For sc_run_measured, with a measurement as user: fill it from the record of the run. */
static void take_record(void *user, const sc_run_record *record)
{
    sc_measurement *m = user;
    const sc_phase_time *first = record->rank_records[0].phases;

    m->frames = record->frame_count;
    m->ranks = record->ranks;
    m->nodes = record->nodes;
    m->threads = record->rank_records[0].threads;
    m->wall_s = record->wall_s;
    m->start.read_s = first[SC_PHASE_READ].wall_s;
    m->start.prepare_s = first[SC_PHASE_PREPARE].wall_s;
    m->start.share_s = first[SC_PHASE_SHARE].wall_s;
    m->memory.prepared_bytes = record->memory.prepared;
    m->accept_s = record->rank_records[0].accept_wall_s;
    for (int i = 0; i < record->ranks; i++)
        add_rank(&record->rank_records[i], record->ranks, 1, m);
    for (int i = 0; i < record->frame_count; i++) {
        const sc_frame_result *f = &record->frames[i];

        m->work.rays += f->rays;
        m->work.samples += f->samples;
        m->work.contributions += f->contributions;
        m->pixels_hash = sc_hash_bytes(&f->hash, sizeof f->hash, m->pixels_hash);
    }
}

/* Do the whole job of a cell, with its outputs, in the directory `work` of the study. Collective on
 * the ranks of the cell. */
static sc_status measure_job(sc_study_state *state, sc_app *app, int cell, const sc_study_way *way,
                             sc_measurement *out)
{
    const char *job = state->study.job[0] ? state->study.job : NULL;
    const double energy_j = sc_energy_j();
    sc_measurement m = {
        .cell = cell, .round = way->round, .passes = 1, .begin_unix_s = (int64_t)time(NULL)};
    sc_status status = SC_OK;

    if (sc_comm_rank(app->comm) == 0)
        status = sc_study_cell_options(state, cell, &app->options);
    SC_PASS(sc_comm_agree(app->comm, status));
    app->options.output = state->work;
    app->options.overwrite = true;
    app->options.resume = false;
    SC_PASS(sc_run_measured(app, job, take_record, &m));
    m.energy_j = energy_j >= 0 && sc_energy_j() >= energy_j ? sc_energy_j() - energy_j : -1;
    *out = m;
    return SC_OK;
}

/* ---- ranks ---- */

/* Find or open the communicator of a cell. @param out NULL on ranks that are not in it.
 * Collective. */
static sc_status find_part(sc_study_state *state, const sc_cell_info *info, sc_comm **out)
{
    const sc_ctx *ctx = state->app->ctx;

    for (int i = 0; i < state->part_count; i++) {
        if (state->parts[i].ranks == info->ranks && state->parts[i].placement == info->placement) {
            *out = state->parts[i].comm;
            return SC_OK;
        }
    }
    if (state->part_count == SC_STUDY_PARTS)
        sc_study_release(state);
    SC_PASS(sc_comm_part(ctx, state->app->comm, info->ranks, (sc_comm_choice)info->placement, out));
    state->parts[state->part_count].ranks = info->ranks;
    state->parts[state->part_count].placement = info->placement;
    state->parts[state->part_count++].comm = *out;
    return SC_OK;
}

void sc_study_release(sc_study_state *state)
{
    drop_held(state);
    for (int i = 0; i < state->part_count; i++)
        sc_comm_close(state->parts[i].comm);
    state->part_count = 0;
}

/* Measure a cell on the ranks of @p part. @param keeps can_keep_volume. Collective there. */
static sc_status measure_on(sc_study_state *state, sc_comm *part, int cell, const sc_study_way *way,
                            bool keeps, sc_measurement *out)
{
    sc_app *app = &state->held.app;
    sc_ctx ctx = *state->app->ctx;
    visit v = {.state = state, .app = app, .session = &state->held.session};
    int passes;
    sc_status status;

    /* What is wrong with a cell is told when it is measured for the first time. */
    ctx.level = state->told && !state->told[cell] ? SC_LOG_WARN : SC_LOG_ERROR;
    ctx.stage = NULL; /* progress is that of the study */
    *app = *state->app;
    app->ctx = &ctx;
    app->comm = part;
    app->threads = state->cells[cell].threads;
    sc_peak_rss_restart();
    /* Preparing may take long, and everything measured is on disk: a signal ends the study at once.
     */
    sc_signals_stop_in_order(false);
    if (state->whole_jobs) {
        status = measure_job(state, app, cell, way, out);
        goto told;
    }
    state->held.is_here = true;
    SC_TRY(open_session(&v, cell, keeps));
    sc_signals_stop_in_order(true);
    SC_TRY(share_frames(&v));
    SC_TRY(draw_passes(&v, way, &passes));
    status = report(&v, cell, way, passes, out);
told:
    if (state->told)
        state->told[cell] = 1;
out:
    sc_signals_stop_in_order(true);
    sc_free(v.frames);
    app->ctx = state->app->ctx;
    return status;
}

sc_status sc_study_measure(sc_study_state *state, int cell, const sc_study_way *way,
                           sc_measurement *out)
{
    const sc_cell_info *info = &state->cells[cell];
    const bool keeps = can_keep_volume(state, cell);
    sc_comm *part = NULL;
    sc_status status;

    if (!keeps)
        drop_held(state);
    SC_PASS(find_part(state, info, &part));
    status = part ? measure_on(state, part, cell, way, keeps, out) : SC_OK;
    status = sc_comm_agree(state->app->comm, status);
    state->held.is_anywhere = !state->whole_jobs;
    state->held.cell = cell;
    return status;
}
