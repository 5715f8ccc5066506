/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  A job: what is to be drawn, from which volume and to where, read from a YAML file, the
 * environment and the command line, and written back as resolved. Local functions; nothing is
 * collective. */
#ifndef SEGCAST_JOB_H
#define SEGCAST_JOB_H

#include "segcast/render.h"
#include "segcast/timeline.h"

enum { SC_PATH_BYTES = 1024 };

typedef enum sc_frames_kind { SC_FRAMES_NONE, SC_FRAMES_PNG } sc_frames_kind;

/* One picture, or slices beside it. */
typedef enum sc_layout { SC_LAYOUT_PICTURE, SC_LAYOUT_VIEWS } sc_layout;

typedef struct sc_output {
    char directory[SC_PATH_BYTES];
    char video[SC_PATH_BYTES]; /* "none": no video */
    int size_px[2];
    int fps;
    int frames; /* sc_frames_kind */
    int crf, preset;
    int layout; /* sc_layout */
} sc_output;

/* The paper's pictures: as it had them at first, and by its accelerated method. */
typedef enum sc_mode { SC_MODE_STANDARD, SC_MODE_PAPER, SC_MODE_PAPER_ACCELERATED } sc_mode;

typedef struct sc_render_options {
    int mode;    /* sc_mode: other defaults for the rest */
    int surface; /* sc_surface */
    int skip, cpu, caps, samples;
    int antialiasing; /* 0 adaptive, 1 full */
    int thickness;    /* 0 per tissue, 1 local */
    double smooth, step_voxels, cap_outline;
    uint8_t background[3];
} sc_render_options;

/* Who encodes: rank 0, or the ranks, each a group of pictures at a time. The bytes are the same. */
typedef enum sc_encode { SC_ENCODE_AUTO, SC_ENCODE_ROOT, SC_ENCODE_SEGMENTS } sc_encode;

typedef struct sc_farm_options {
    int partition, tile_px; /* sc_partition */
    int encode;             /* sc_encode */
    bool share;             /* ranks of one node share frames, not only the volume */
} sc_farm_options;

/* Plain data but for two arrays, so that it can be sent to other ranks. */
typedef struct sc_job {
    char volume[SC_PATH_BYTES]; /* a path, or "phantom", or "phantom:WxDxH" */
    char labels[SC_PATH_BYTES]; /* empty: from the volume */
    int labels_format;          /* sc_table_format */
    sc_output output;
    sc_render_options render;
    sc_lighting light;
    sc_animation animation;
    sc_farm_options farm;
    sc_tissue_rule *rules;
    size_t rule_count;
    sc_clip_exception *exceptions;
    size_t exception_count;
} sc_job;

/* Where the parts of a job come from, the later winning. */
typedef struct sc_job_sources {
    const char *path;            /* job file, or NULL */
    const char *const *settings; /* "key.path=value" of the command line */
    size_t setting_count;
    const char *const *environment; /* "SEGCAST_RENDER_SAMPLES=2", NULL-terminated, or NULL */
} sc_job_sources;

/* Read, check and resolve a job: paths of the file become relative to the working directory.
 * SC_ERR_USAGE, SC_ERR_DATA or SC_ERR_MISSING, with file and line. Caller owns: sc_job_clear. */
sc_status sc_job_load(const sc_ctx *ctx, const sc_job_sources *sources, sc_job *out);
void sc_job_clear(sc_job *job);
/* The job as YAML, every key given. @p identity: only what changes the pictures. */
sc_status sc_job_write(const sc_ctx *ctx, const sc_job *job, bool identity, sc_text *text);
/* Name of the encoder preset. */
const char *sc_job_preset(const sc_job *job);

/* "0-35:2,40": whole numbers in [0, total), no doubles, sorted. Grammar: OpenJD IntRangeExpr.
 * @p text NULL: all. Caller owns *out: sc_free. */
sc_status sc_frames_parse(const sc_ctx *ctx, const char *text, int total, int **out, int *count);

/* Frames of slice @p i of @p n: whole groups of @p group frames, so that no two slices share one.
 * Caller owns *out: sc_free. */
sc_status sc_frames_slice(const sc_ctx *ctx, int i, int n, int group, int total, int **out,
                          int *count);

#endif
