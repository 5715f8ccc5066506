/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast plan: what a job will take, measured on some of its frames. */
#include "plan/plan.h"
#include "render/run.h"

/* The numbers of nodes that are told unless --nodes says otherwise. */
static const int usual_nodes[] = {1, 4, 16};
enum { RUNS = SC_COUNT_OF(usual_nodes) };
/* How far the table of nodes goes at least. */
enum { SCALE_NODES = 64 };

/* Everything that is told. */
typedef struct job_plan {
    const sc_session *session;
    sc_plan_probe probe;
    sc_plan_disk disk;
    double draw_cpu_s, encode_cpu_s; /* of the whole job */
    sc_plan_run runs[RUNS];
    int run_count;
    sc_unit_costs costs;
    sc_plan_scale scale;
} job_plan;

/* Fill in what follows from plan->probe and plan->costs. @return SC_ERR_MEMORY. */
static sc_status conclude(const sc_app *app, job_plan *plan)
{
    const sc_job *job = &plan->session->job;
    const sc_options *o = &app->options;
    const int cores = sc_usable_cores();
    const sc_plan_nodes nodes = {.most = o->plan.nodes > SCALE_NODES ? o->plan.nodes : SCALE_NODES,
                                 .cores = cores,
                                 .memory_bytes = sc_machine_memory(),
                                 .ranks = o->plan.ranks,
                                 .threads = o->limits.threads};
    const int run_count = o->plan.nodes ? 1 : RUNS;

    plan->draw_cpu_s = plan->probe.draw_cpu_s * job->animation.frames;
    plan->encode_cpu_s = sc_plan_encode_cpu_s(job, &plan->probe);
    plan->run_count = run_count;
    for (int i = 0; i < run_count; i++) {
        plan->runs[i] =
            sc_plan_run_on(job, &plan->probe, o->plan.nodes ? o->plan.nodes : usual_nodes[i],
                           o->plan.ranks ? o->plan.ranks : 1, cores, o->limits.threads);
        SC_PASS(sc_plan_simulate(app->ctx, job, &plan->probe, &plan->costs, cores, &plan->runs[i]));
    }
    plan->disk = sc_plan_disk_of(job, &plan->probe, plan->runs[0].threads);
    return sc_plan_scale_to(app->ctx, job, &plan->probe, &plan->costs, &nodes, &plan->scale);
}

/* @return the CPU seconds of the whole job. */
static double all_cpu_s(const job_plan *plan)
{
    return plan->draw_cpu_s + plan->encode_cpu_s + plan->probe.prepare_cpu_s;
}

/* ---- JSON ---- */

/* The array `runs`; NULL if there is no memory. The caller owns it. */
static json_t *runs_json(const job_plan *plan)
{
    json_t *runs = json_array();

    for (int i = 0; i < plan->run_count && runs; i++) {
        const sc_plan_run *run = &plan->runs[i];
        json_t *item = json_pack(
            "{s:i, s:i, s:i, s:i, s:f, s:f, s:f, s:f, s:f, s:s, s:I, s:I}", "nodes", run->nodes,
            "ranks_per_node", run->ranks, "threads_per_rank", run->threads, "gops_encoded_by_ranks",
            run->gops, "wall_s", run->wall_s, "prepare_s", run->prepare_s, "draw_s", run->draw_s,
            "root_encode_s", run->encode_s, "efficiency", run->efficiency, "limited_by", run->limit,
            "first_node_bytes", (json_int_t)run->first_node_bytes, "other_node_bytes",
            (json_int_t)run->other_node_bytes);

        runs = sc_json_with(runs, item);
    }
    return runs;
}

/* The object `scaling`; NULL if there is no memory. The caller owns it. */
static json_t *scaling_json(const job_plan *plan)
{
    const sc_plan_scale *scale = &plan->scale;
    json_t *rows = json_array();

    for (int i = 0; i < scale->count && rows; i++) {
        const sc_plan_row *row = &scale->rows[i];
        const sc_plan_run *run = &row->run;
        json_t *item = json_pack(
            "{s:i, s:i, s:i, s:s, s:f, s:f, s:f, s:s, s:I}", "nodes", run->nodes, "ranks_per_node",
            run->ranks, "threads_per_rank", run->threads, "encode", sc_job_encode_word(row->encode),
            "wall_s", run->wall_s, "core_hours", row->core_hours, "efficiency", run->efficiency,
            "limited_by", run->limit, "first_node_bytes", (json_int_t)run->first_node_bytes);

        rows = sc_json_with(rows, item);
    }
    return json_pack("{s:b, s:i, s:o}", "costs_measured", plan->costs.measured, "pays_to_nodes",
                     scale->pays_to, "nodes", rows);
}

/* Print the plan as JSON. @return SC_ERR_MEMORY. */
static sc_status print_json(const sc_ctx *ctx, const job_plan *plan)
{
    const sc_job *job = &plan->session->job;
    const sc_plan_probe *p = &plan->probe;
    const sc_plan_disk *disk = &plan->disk;
    json_t *json = json_pack(
        "{s:s, s:i, s:[i,i], s:i, s:i, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:{s:I, s:I, s:I, "
        "s:I, s:I, s:I}, s:{s:I, s:I, s:I, s:I, s:I, s:I}, s:o, s:o}",
        "schema", "segcast-plan-1", "frames", job->animation.frames, "size", job->output.size_px[0],
        job->output.size_px[1], "frames_measured", p->partly_drawn, "frames_encoded", p->encoded,
        "draw_cpu_s_per_frame", p->draw_cpu_s, "draw_cpu_s", plan->draw_cpu_s,
        "encode_cpu_s_per_frame", plan->encode_cpu_s / job->animation.frames, "encode_cpu_s",
        plan->encode_cpu_s, "prepare_cpu_s", p->prepare_cpu_s, "prepare_wall_s", p->prepare_wall_s,
        "core_hours", all_cpu_s(plan) / 3600, "memory", "prepared_bytes",
        (json_int_t)p->prepared_bytes, "derived_bytes", (json_int_t)p->derived_bytes,
        "loaded_bytes", (json_int_t)p->loaded_bytes, "program_bytes", (json_int_t)p->program_bytes,
        "renderer_bytes", (json_int_t)p->renderer_bytes, "encoder_bytes",
        (json_int_t)p->encoder_bytes, "disk", "video_bytes", (json_int_t)disk->video, "png_bytes",
        (json_int_t)disk->frames, "records_bytes", (json_int_t)disk->records, "end_bytes",
        (json_int_t)disk->end, "peak_bytes", (json_int_t)disk->peak, "phase_file_bytes",
        (json_int_t)p->phase_file_bytes, "runs", runs_json(plan), "scaling", scaling_json(plan));

    return sc_print_json(ctx, json, JSON_INDENT(1) | JSON_REAL_PRECISION(9), "plan");
}

/* ---- for people ---- */

/* Print what the outputs take on disk. */
static void print_disk(const job_plan *plan)
{
    const sc_plan_disk *disk = &plan->disk;
    char video[24], frames[24], records[24], peak[24];

    printf("disk             %s video, ", sc_size_text((double)disk->video, video));
    if (disk->frames)
        printf("%s PNG frames, ", sc_size_text((double)disk->frames, frames));
    printf("%s records; at most %s at a time\n", sc_size_text((double)disk->records, records),
           sc_size_text((double)disk->peak, peak));
}

/* Print what a run on some nodes takes. */
static void print_run(const sc_plan_run *run)
{
    char first[24], other[24];

    printf("wall time        %.0f s on %d node%s, %d rank%s of %d thread%s each; limited by %s\n",
           run->wall_s, run->nodes, run->nodes == 1 ? "" : "s", run->ranks,
           run->ranks == 1 ? "" : "s", run->threads, run->threads == 1 ? "" : "s", run->limit);
    printf("  memory         %s", sc_size_text((double)run->first_node_bytes, first));
    if (run->nodes > 1)
        printf(" on the node of rank 0, %s on each other",
               sc_size_text((double)run->other_node_bytes, other));
    printf("\n");
}

/* Print the table of nodes. */
static void print_scaling(const job_plan *plan)
{
    const sc_plan_scale *scale = &plan->scale;

    printf("scaling           nodes  ranks x threads   encode    wall time  core hours  efficiency "
           " limited by\n");
    for (int i = 0; i < scale->count; i++) {
        const sc_plan_row *row = &scale->rows[i];
        const sc_plan_run *run = &row->run;

        printf("                 %6d  %5d x %-7d   %-8s %9.1f s  %10.4f  %10.2f  %s\n", run->nodes,
               run->ranks, run->threads, sc_job_encode_word(row->encode), run->wall_s,
               row->core_hours, run->efficiency, run->limit);
    }
    printf("                 adding nodes pays up to %d%s; messages, network and disk are %s\n",
           scale->pays_to,
           scale->pays_to == scale->rows[scale->count - 1].run.nodes ? " and may do so beyond" : "",
           plan->costs.measured ? "as segcast plan --calibrate has measured them"
                                : "assumed (segcast plan --calibrate measures them)");
}

/* Print the plan for people. */
static void print_text(const job_plan *plan)
{
    const sc_session *session = plan->session;
    const sc_job *job = &session->job;
    const sc_plan_probe *p = &plan->probe;
    const int *size_px = job->output.size_px;
    const sc_kernel *kernel = sc_renderer_kernel(sc_session_renderer(session, 0));
    const sc_prepared *v = sc_session_view(session);
    char prepared[24], encoder[24], files[24], loaded[24];

    printf("frames           %d of %d x %d\n", job->animation.frames, size_px[0], size_px[1]);
    printf("kernel           %s, %s\n", kernel->name, kernel->cpu);
    printf("volume           %d x %d x %d voxels, %d label%s, %s prepared\n", v->size[0],
           v->size[1], v->size[2], v->label_count - 1, v->label_count == 2 ? "" : "s",
           sc_size_text((double)p->prepared_bytes, prepared));
    for (int s = 1; s < sc_subject_count(job); s++) {
        v = &session->inputs->all[s].volume;
        printf("  compared with  %d x %d x %d voxels\n", v->size[0], v->size[1], v->size[2]);
    }
    if (p->phase_file_bytes)
        printf("phases           %d, in files of %s in all in %s; %s of them in memory at a time\n",
               session->inputs->count, sc_size_text((double)p->phase_file_bytes, files),
               sc_temporary_folder(), sc_size_text((double)p->loaded_bytes, loaded));
    printf("measured         bands of %d frames, %d whole frames\n", p->partly_drawn, p->encoded);
    printf("preparing        %.1f CPU s, %.1f s here\n", p->prepare_cpu_s, p->prepare_wall_s);
    printf("drawing          %.1f CPU s, %.3f per frame\n", plan->draw_cpu_s, p->draw_cpu_s);
    printf("encoding         %.1f CPU s, %.3f per frame", plan->encode_cpu_s,
           plan->encode_cpu_s / job->animation.frames);
    if (p->encoder_bytes)
        printf("; an encoder takes %s", sc_size_text((double)p->encoder_bytes, encoder));
    printf("\nin all           %.4f core hours\n", all_cpu_s(plan) / 3600);
    print_disk(plan);
    for (int i = 0; i < plan->run_count; i++)
        print_run(&plan->runs[i]);
    print_scaling(plan);
}

sc_status sc_cmd_plan(sc_app *app)
{
    const uint64_t program_bytes = sc_peak_rss();
    const sc_options *o = &app->options;
    const long ranks = (long)(o->plan.nodes ? o->plan.nodes : usual_nodes[RUNS - 1]) *
                       (o->plan.ranks ? o->plan.ranks : 1);
    SC_OWN(sc_session_clear) sc_session session = {0};
    job_plan plan = {.session = &session};

    app->measures = true;
    if (o->plan.calibrate)
        return sc_calibrate(app);
    if (ranks > SC_PLAN_RANKS_MOST)
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "%ld ranks in all, expected at most %d; choose fewer by --nodes or --ranks",
                       ranks, SC_PLAN_RANKS_MOST);
    SC_PASS(sc_session_job(app, app->options.input, &session));
    SC_PASS(sc_run_check_encoder(app->ctx, &session.job));
    SC_PASS(sc_run_check_encode_key(app->ctx, &session.job));
    SC_PASS(sc_session_volume(app, &session));
    SC_PASS(sc_plan_measure(app, &session, program_bytes, &plan.probe));
    plan.costs = sc_calibration_load(app->ctx);
    SC_PASS(conclude(app, &plan));
    sc_display_end_stage(app);
    if (app->options.json)
        return print_json(app->ctx, &plan);
    print_text(&plan);
    return SC_OK;
}
