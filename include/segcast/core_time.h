/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Where the time of cores went: drawing, and the parallel overhead split by cause. A rank has as
 *  many cores as threads that draw, for as long as the run or the measurement lasts. Pure functions
 *  of the module study. */
#ifndef SEGCAST_CORE_TIME_H
#define SEGCAST_CORE_TIME_H

#include "segcast/measurements.h"
#include "segcast/study.h"

/** What the time of a core was spent on. */
typedef enum sc_cause {
    SC_CAUSE_DRAW,    /**< CPU time of drawing: all else is overhead */
    SC_CAUSE_READ,    /**< reading the volume */
    SC_CAUSE_PREPARE, /**< preprocessing */
    SC_CAUSE_SHARE,   /**< copying the prepared volume to all nodes */
    SC_CAUSE_WAIT,    /**< waiting for other ranks outside of the farm, which read or prepare */
    SC_CAUSE_IDLE,    /**< no work unit */
    SC_CAUSE_GATHER,  /**< CPU time of passing messages */
    SC_CAUSE_ENCODE,  /**< CPU time of encoding and writing; of a measurement of frames: nothing */
    SC_CAUSE_THREADS, /**< threads that draw a frame waited for each other, or for a core */
    SC_CAUSE_OTHER,   /**< all that is left, such as completing the video */
    SC_CAUSE_COUNT
} sc_cause;

/** @return the key of a cause in stats.json and cells.csv, such as "draw_s". Static text. */
const char *sc_cause_key(sc_cause cause);

/** The time of all cores, in seconds. The causes add up to core_s, or to more if threads shared
 *  cores. */
typedef struct sc_core_time {
    double core_s;
    double causes_s[SC_CAUSE_COUNT]; /**< none is negative */
} sc_core_time;

/** @return the core time of a run, all of its ranks together. */
sc_core_time sc_run_core_time(const sc_run_record *run);
/** @return the core time of a measurement, of one pass. Messages are not told apart there, and
 *  waiting is counted as idle. @param whole_job what comes before the first frame counts, as does
 *  encoding. */
sc_core_time sc_measurement_core_time(const sc_measurement *m, bool whole_job);

#endif
