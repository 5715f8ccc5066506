/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Floor 7: timing records of a run and the files that hold them. Collected in memory, written
 *  once. */
#ifndef SEGCAST_STUDY_H
#define SEGCAST_STUDY_H

#include "segcast/farm.h"

typedef enum sc_phase {
    SC_PHASE_READ,
    SC_PHASE_PREPARE,
    SC_PHASE_SHARE,
    SC_PHASE_RENDER,
    SC_PHASE_GATHER,
    SC_PHASE_ENCODE,
    SC_PHASE_WRITE,
    SC_PHASE_IDLE,
    SC_PHASE_COUNT
} sc_phase;

typedef struct sc_phase_time {
    double wall_s, cpu_s;
} sc_phase_time;

/** What one rank reports. A value, sent as bytes. */
typedef struct sc_rank_record {
    sc_phase_time phases[SC_PHASE_COUNT];
    uint64_t peak_rss_bytes;
    double cpu_s;
    int32_t threads;
} sc_rank_record;

/** A run as written to stats.json and frames.csv. All pointers are borrowed. */
typedef struct sc_run_record {
    const char *version, *host;
    int ranks, nodes;
    double wall_s;
    const sc_rank_record *rank_records; /**< [ranks] */
    const sc_frame_result *frames;      /**< [frame_count], in rising order of frames */
    int frame_count;
    uint64_t volume_bytes, prepared_bytes;
} sc_run_record;

/** Largest over mean of the ranks' render time, minus 1: 0 is perfect balance. */
double sc_run_imbalance(const sc_run_record *run);
/** Write @p directory/stats.json and frames.csv. @return SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_run_write(const sc_ctx *ctx, const sc_run_record *run,
                                   const char *directory);

#endif
