/* SPDX-License-Identifier: BSD-3-Clause */
/* Until when there is time. */
#include "app.h"

#include <stdlib.h>
#include <time.h>

double sc_deadline_s(const sc_app *app)
{
    const char *end_text = getenv("SLURM_JOB_END_TIME"); /* seconds of the Unix clock */
    const double now_s = sc_wall_s();
    double left_s =
        app->options.time_limit_s > 0 ? app->begin_s + app->options.time_limit_s - now_s : 0;
    double margin_s;
    char *end;

    if (end_text) {
        const double end_s = strtod(end_text, &end);
        const double slurm_left_s = end_s - (double)time(NULL);

        if (end != end_text && !*end && slurm_left_s < 10 * 365 * 86400.0 &&
            (left_s == 0 || slurm_left_s < left_s))
            left_s = slurm_left_s > 1e-3 ? slurm_left_s : 1e-3;
    }
    if (left_s == 0)
        return 0;
    /* for joining the video and writing the records */
    margin_s = 0.05 * left_s;
    margin_s = margin_s < 1 ? 1 : margin_s > 60 ? 60 : margin_s;
    return now_s + left_s - margin_s;
}
