/* SPDX-License-Identifier: BSD-3-Clause */
/* The deadline of a run: when it has to be finished. */
#include "segcast/process.h"

#include <stdlib.h>
#include <time.h>

/* The margin in which the video is joined and the records are written: a share of the time that is
 * left, within bounds. */
#define MARGIN_SHARE 0.05
#define MARGIN_MIN_S 1.0
#define MARGIN_MAX_S 60.0

/* Slurm states the end of an unlimited job as a time many years from now. */
#define UNLIMITED_S (10 * 365 * 86400.0)

double sc_deadline_s(const sc_app *app)
{
    const char *end_text = getenv("SLURM_JOB_END_TIME"); /* seconds of the Unix clock */
    const double now_s = sc_wall_s();
    double left_s = app->options.part.time_limit_s > 0
                        ? app->begin_s + app->options.part.time_limit_s - now_s
                        : 0;
    double margin_s;
    char *end;

    if (end_text) {
        const double end_s = strtod(end_text, &end);
        const double slurm_left_s = end_s - (double)time(NULL);

        /* If the allocation has ended already, the limit is a moment from now: 0 would mean none.
         */
        if (end != end_text && !*end && slurm_left_s < UNLIMITED_S &&
            (left_s == 0 || slurm_left_s < left_s))
            left_s = slurm_left_s > 1e-3 ? slurm_left_s : 1e-3;
    }
    if (left_s == 0)
        return 0;
    margin_s = MARGIN_SHARE * left_s;
    margin_s = margin_s < MARGIN_MIN_S   ? MARGIN_MIN_S
               : margin_s > MARGIN_MAX_S ? MARGIN_MAX_S
                                         : margin_s;
    return now_s + left_s - margin_s;
}
