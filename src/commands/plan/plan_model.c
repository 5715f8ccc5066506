/* SPDX-License-Identifier: BSD-3-Clause */
/* What follows for a whole job from what segcast plan has measured: disk, memory, wall time. */
#include "plan/plan.h"
#include "segcast/report.h"

/* Sizes in bytes of what the records of a run hold, as they are on the average. */
enum {
    MANIFEST_LINE = 125, /* a frame in manifest.jsonl, */
    PNG_LINE = 55,       /* and what is added to it for a PNG file */
    STATS_FRAME = 235,   /* a frame in stats.json */
    CSV_LINE = 80,       /* a frame in frames.csv */
    TRACE_EVENT = 100,   /* an event in trace.json */
    REPORT = 65000,      /* report.html without its pictures */
    RECORDS = 6700,      /* everything that does not grow with the frames */
    PICTURE_HEAD = 48    /* before each picture of a partial GOP */
};
/* A pixel of the pictures in report.html. */
#define REPORT_PIXEL 0.9
/* All ranks together keep no more events than this for the trace. */
#define EVENTS_MAX (1 << 20)

/* @return the length of the job's GOPs in frames. */
static int gop_frames(const sc_job *job)
{
    const sc_video_settings video = sc_run_video_settings(job);

    return sc_video_gop_frames(&video);
}

/* @return the number of GOPs that @p frames frames in a row make. */
static int gops_of(const sc_job *job, int frames)
{
    return (frames + gop_frames(job) - 1) / gop_frames(job);
}

/* @return the cost of encoding @p frames frames in a row, PNG files included. */
static sc_plan_cost cost_of(const sc_job *job, const sc_plan_probe *p, int frames)
{
    const double firsts = gops_of(job, frames), nexts = frames - firsts;

    return (sc_plan_cost){firsts * p->first.cpu_s + nexts * p->next.cpu_s + frames * p->png.cpu_s,
                          firsts * p->first.wall_s + nexts * p->next.wall_s +
                              frames * p->png.wall_s,
                          firsts * p->first.bytes + nexts * p->next.bytes + frames * p->png.bytes};
}

double sc_plan_encode_cpu_s(const sc_job *job, const sc_plan_probe *probe)
{
    return cost_of(job, probe, job->animation.frames).cpu_s;
}

/* @return the size of report.html in bytes. */
static double report_bytes(const sc_job *job)
{
    const double width = job->output.size_px[0], height = job->output.size_px[1];
    const double side = width > height ? width : height;
    const double scale = side > SC_REPORT_PICTURE_SIDE ? SC_REPORT_PICTURE_SIDE / side : 1;
    const int frames = job->animation.frames;
    const int pictures = frames < SC_REPORT_PICTURES ? frames : SC_REPORT_PICTURES;

    return REPORT + REPORT_PIXEL * pictures * scale * scale * width * height;
}

sc_plan_disk sc_plan_disk_of(const sc_job *job, const sc_plan_probe *p, int threads)
{
    const sc_video_settings video = sc_run_video_settings(job);
    const double frames = job->animation.frames;
    const double events = frames * (threads + 1);
    const bool png = job->output.frames == SC_FRAMES_PNG;
    const int together = frames < gop_frames(job) ? (int)frames : gop_frames(job);
    const double share = sc_video_segment_share(job->output.video);
    double partial = 0, peak, segments;
    sc_plan_disk disk = {.frames = (uint64_t)(frames * p->png.bytes)};

    segments = cost_of(job, p, job->animation.frames).bytes - (double)disk.frames;
    disk.video = (uint64_t)(share * segments);
    disk.records =
        (uint64_t)(RECORDS + report_bytes(job) + (double)p->job_bytes +
                   frames * (MANIFEST_LINE + (png ? PNG_LINE : 0) + STATS_FRAME + CSV_LINE) +
                   TRACE_EVENT * (events < EVENTS_MAX ? events : EVENTS_MAX));
    disk.end = disk.video + disk.frames + disk.records;
    if (sc_run_has_video(job))
        partial = together * ((double)sc_picture_bytes(job->output.video, &video) + PICTURE_HEAD);
    /* While the video is joined, its segments are there, too, for a GIF twice; before that, the
     * pictures of the GOP that is encoded. */
    segments *= share < 1 ? 2 : 1;
    peak = partial > segments ? partial : segments;
    disk.peak = disk.end + (uint64_t)peak;
    return disk;
}

/* @return how many ranks of a node encode gathered GOPs: those of two groups, which overlap. */
static uint64_t encoders_per_node(const sc_job *job, const sc_plan_probe *p, const sc_plan_run *run)
{
    const int frames = job->animation.frames;
    const int wanted = sc_handout_encoders(run->nodes * run->ranks, p->draw_cpu_s / run->threads,
                                           cost_of(job, p, frames).wall_s / frames);
    const int group =
        run->encoders_most > 0 && run->encoders_most < wanted ? run->encoders_most : wanted;
    const int both = 2 * group < run->gops ? 2 * group : run->gops;
    const int each = (both + run->nodes - 1) / run->nodes;

    return (uint64_t)(each < run->ranks ? each : run->ranks);
}

/* Fill first_node_bytes and other_node_bytes of @p run. @param rest number of frames that are not
 * drawn in whole GOPs. */
static void find_memory(const sc_job *job, const sc_plan_probe *p, int rest, sc_plan_run *run)
{
    const int *size_px = job->output.size_px;
    const sc_farm farm = {.width_px = size_px[0],
                          .height_px = size_px[1],
                          .alpha = job->render.background.is_none,
                          .partition = (sc_partition)job->farm.partition,
                          .frame_count = rest,
                          .gop_count = run->gops,
                          .gather = run->gather,
                          .gop_frames = gop_frames(job),
                          .total_frames = job->animation.frames,
                          .spoils_other_rows = sc_job_has_views(job)};
    const sc_farm_memory memory = sc_farm_memory_of(&farm, run->nodes * run->ranks);
    const uint64_t ranks = (uint64_t)run->ranks;
    const uint64_t encoding_bytes =
        p->encoder_bytes + 2 * (uint64_t)cost_of(job, p, gop_frames(job)).bytes;
    uint64_t node_bytes = p->loaded_bytes;
    uint64_t rank_bytes = p->program_bytes + p->renderer_bytes;
    uint64_t root_bytes = memory.window + memory.root + p->encoder_bytes;

    /* A rank that encodes holds an encoder, the files of a GOP twice, and, if it draws them itself,
     * a frame. */
    if (run->gops > 0 && run->gather)
        node_bytes += encoders_per_node(job, p, run) * (memory.encoder + encoding_bytes);
    else if (run->gops > 0)
        rank_bytes += (uint64_t)size_px[0] * (uint64_t)size_px[1] *
                          sc_pixel_bytes(job->render.background.is_none) +
                      encoding_bytes;
    run->other_node_bytes = node_bytes + ranks * (rank_bytes + memory.worker);
    run->first_node_bytes =
        node_bytes + ranks * rank_bytes + (ranks - 1) * memory.worker + root_bytes;
    if (p->prepare_bytes + (ranks - 1) * p->program_bytes > run->first_node_bytes)
        run->first_node_bytes = p->prepare_bytes + (ranks - 1) * p->program_bytes;
}

sc_plan_run sc_plan_run_on(const sc_job *job, const sc_plan_probe *p, int nodes, int ranks,
                           int cores, int threads)
{
    const int frames = job->animation.frames, all = nodes * ranks;
    const int whole = sc_run_has_video(job) ? gops_of(job, frames) : 0;
    const int own = threads ? threads : cores > ranks ? cores / ranks : 1;
    const double busy = (double)nodes * (ranks * own < cores ? ranks * own : cores);
    const int full = sc_run_has_video(job) ? frames / gop_frames(job) : 0;
    const sc_run_ranks where = {
        .ranks = all, .nodes = nodes, .memory_max_bytes = p->memory_max_bytes};
    const sc_run_encoding encoding = sc_run_encoding_of(job, whole, full, &where);
    sc_plan_run run = {.nodes = nodes,
                       .ranks = ranks,
                       .threads = own,
                       .gops = encoding.gops,
                       .gather = encoding.gather,
                       .encoders_most = encoding.encoders_most};
    const int of_ranks = run.gops * gop_frames(job) < frames ? run.gops * gop_frames(job) : frames;
    const int rest = frames - of_ranks;
    const sc_plan_cost ranks_encode = cost_of(job, p, of_ranks), root = cost_of(job, p, rest);
    double both_s, apart_s;

    run.prepare_s = p->prepare_cpu_s / own;
    run.prepare_s = run.prepare_s > p->prepare_wall_s ? run.prepare_s : p->prepare_wall_s;
    /* Either all cores are busy, or those of a rank wait while it encodes. */
    both_s = (frames * p->draw_cpu_s + ranks_encode.cpu_s + root.cpu_s) / busy;
    apart_s = frames * p->draw_cpu_s / busy + ranks_encode.wall_s / all;
    run.draw_s = both_s > apart_s ? both_s : apart_s;
    run.encode_s = root.wall_s;
    run.wall_s = run.prepare_s + (run.draw_s > run.encode_s ? run.draw_s : run.encode_s);
    run.limit =
        run.prepare_s > run.wall_s / 2 ? "preparing"
        : run.encode_s > run.draw_s || ranks_encode.cpu_s + root.cpu_s > frames * p->draw_cpu_s
            ? "encoding"
            : "drawing";
    find_memory(job, p, rest, &run);
    return run;
}
