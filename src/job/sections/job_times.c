/* SPDX-License-Identifier: BSD-3-Clause */
/* Parts of the animation and times of key frames, which may be given in frames, seconds or minutes.
 * Only the whole job knows how many frames there are, and how many make a second: so its nodes have
 * a clock when they are read. */
#include "key.h"
#include "segcast/job.h"

#include <math.h>
#include <stdlib.h>

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

/* Read a time that is no share. @param frame where it lies, in frames from the beginning. @return
 * false if @p node is anything else. */
static bool parse_time(const sc_yaml *node, double *frame)
{
    const bool is_text = node->kind == SC_YAML_SCALAR && node->clock;
    const sc_time_kind kind = is_text ? sc_time_of_text(node->text, frame) : SC_TIME_NONE;

    if (kind != SC_TIME_FRAMES && kind != SC_TIME_SECONDS)
        return false;
    if (kind == SC_TIME_SECONDS)
        *frame *= node->clock->fps;
    if (fabs(*frame - floor(*frame + 0.5)) < 1e-9 * *frame) /* 1.1s at 30 fps are frame 33 */
        *frame = floor(*frame + 0.5);
    return true;
}

/* @return the share of the animation at which a frame lies. It is rounded down, so that what
 * happens at a frame happens there and not one later, and is the one that is written. */
static double share_of(const sc_clock *clock, double frame)
{
    const double share = clock->frames > 1 ? fmin(frame / (clock->frames - 1), 1) : 0;
    char digits[40];

    snprintf(digits, sizeof digits, "%.12g", floor(share * 100 * 1e9) / 1e9);
    return strtod(digits, NULL) / 100;
}

/* Say where the length of the animation is given, unless it is beside the time @p node: that of a
 * shot is in the shot, while the time may be the film's. @param out [bytes]; empty: beside it. */
static void name_length(const sc_yaml *length, const sc_yaml *node, char *out, size_t bytes)
{
    out[0] = '\0';
    if (!length || (length->line == node->line && !strcmp(length->origin, node->origin)))
        return;
    if (length->line > 0)
        snprintf(out, bytes, ", by %s:%d", length->origin, length->line);
    else
        snprintf(out, bytes, ", by %s", length->origin);
}

sc_status sc_read_time(const sc_ctx *ctx, const char *key, const sc_yaml *node, double *at,
                       bool *is_time)
{
    const sc_clock *clock = node->clock;
    const char *unit;
    char elsewhere[192];
    double frame;

    if (!parse_time(node, &frame)) {
        *is_time = sc_parse_position(node, at, &unit) && *unit == '%' && *at >= 0 && *at <= 100;
        *at /= 100;
        return SC_OK;
    }
    *is_time = true;
    *at = !clock->is_film ? share_of(clock, frame) : frame > 0 ? -frame / clock->fps : 0;
    if (clock->is_film || frame <= clock->frames * (1 + 1e-9))
        return SC_OK;
    name_length(clock->length, node, elsewhere, sizeof elsewhere);
    return sc_yaml_fail(ctx, node,
                        "%s: %s is behind the end of the animation, which has %.0f frame%s at %g "
                        "frames per second: %.6g s%s",
                        key, node->text, clock->frames, clock->frames > 1 ? "s" : "", clock->fps,
                        clock->frames / clock->fps, elsewhere);
}
