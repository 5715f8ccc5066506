/* SPDX-License-Identifier: BSD-3-Clause */
/* Parts of the animation and times of key frames, which may be given in frames, seconds or minutes.
 * Only the whole job knows how many frames there are, and how many make a second: so its nodes have
 * a clock when they are read. */
#include "key.h"
#include "segcast/job.h"

#include <math.h>

/* @return the number at @p path, if it lies in the range from 1 to @p most, else @p fallback: what
 * is wrong is told when the key itself is read. */
static double number_at(const sc_yaml *root, const char *path, double most, double fallback)
{
    const sc_yaml *node = sc_key_node(root, path);
    double number;

    return node && sc_parse_number(node, &number) && number >= 1 && number <= most ? number
                                                                                   : fallback;
}

/* Give all nodes a clock. */
static void set_clock(const sc_clock *clock, sc_yaml *node)
{
    node->clock = clock;
    for (size_t i = 0; i < node->count; i++)
        set_clock(clock, node->items[i]);
}

void sc_clock_start(const sc_job *job, bool is_film, sc_yaml *root, sc_clock *clock)
{
    double seconds;

    *clock = (sc_clock){
        .is_film = is_film,
        .frames = number_at(root, "animation.frames", SC_JOB_FRAMES_MAX, job->animation.frames),
        .fps = number_at(root, "output.fps", 1e6, job->output.fps),
        .length = sc_key_node(root, "animation.frames")};
    if (clock->length && !sc_parse_number(clock->length, &seconds) &&
        sc_parse_duration(clock->length, &seconds))
        clock->frames = fmax(floor(seconds * clock->fps + 0.5), 1);
    set_clock(clock, root);
}
