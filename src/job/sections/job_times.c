/* SPDX-License-Identifier: BSD-3-Clause */
/* Parts of the animation and times of key frames that are given in frames, seconds or minutes. They
 * are turned into shares of the animation in the tree, before it is read by the table of keys: only
 * the whole job knows how many frames there are, and how many make a second. */
#include "key.h"
#include "segcast/job.h"

#include <math.h>
#include <stdlib.h>

/* What turns times into shares. */
typedef struct clock_of_job {
    bool is_film;          /* the shares are those of its shots: times become seconds */
    double frames, fps;    /* of the animation; both above 0 */
    const sc_yaml *length; /* where these frames are given, for messages; NULL: by default */
} clock_of_job;

/* @return the number at @p path, if it lies in the range from 1 to @p most, else @p fallback: what
 * is wrong is told when the key itself is read. */
static double number_at(const sc_yaml *root, const char *path, double most, double fallback)
{
    const sc_yaml *node = sc_key_node(root, path);
    double number;

    return node && sc_parse_number(node, &number) && number >= 1 && number <= most ? number
                                                                                   : fallback;
}

/* @return frames and frames per second of the job in the tree @p root. @param job holds the
 * defaults. */
static clock_of_job clock_of(const sc_ctx *ctx, const sc_yaml *root, const sc_job *job)
{
    const sc_ctx quiet = sc_quiet(ctx);
    const sc_key key = {.name = "frames", .type = &sc_type_duration};
    clock_of_job out = {.fps = number_at(root, "output.fps", 1e6, job->output.fps),
                        .length = sc_key_node(root, "animation.frames")};
    double seconds;

    out.frames = number_at(root, "animation.frames", SC_JOB_FRAMES_MAX, job->animation.frames);
    if (out.length && !sc_parse_number(out.length, &seconds) &&
        key.type->read(&quiet, &key, out.length, &seconds) == SC_OK)
        out.frames = fmax(floor(seconds * out.fps + 0.5), 1);
    return out;
}

/* Read digits and what stands behind a point, nothing else. @param end what follows. @return false
 * if there are none. */
static bool parse_digits(const char *text, double *number, const char **end)
{
    char *behind;

    *end = text + strspn(text, "0123456789.");
    *number = strtod(text, &behind);
    return behind == *end && behind != text;
}

/* Read a time that is no share. @param frame where it lies, in frames from the beginning. @return
 * false if @p node is anything else. */
static bool parse_time(const clock_of_job *clock, const sc_yaml *node, double *frame)
{
    const char *end;
    double number, seconds;

    if (node->kind != SC_YAML_SCALAR || !parse_digits(node->text, &number, &end))
        return false;
    if (*end == ':' && !strchr(end + 1, ':') && sc_parse_clock(node->text, &seconds))
        number = seconds;
    else if (sc_time_unit(end + strspn(end, " "), &seconds))
        number *= seconds > 0 ? seconds : 1 / clock->fps;
    else
        return false;
    *frame = number * clock->fps;
    if (fabs(*frame - floor(*frame + 0.5)) < 1e-9 * *frame) /* 45f, which are 1.5s, are frame 45 */
        *frame = floor(*frame + 0.5);
    return true;
}

/* Put a text in the place of the time @p node. */
static sc_status put_text(const sc_ctx *ctx, const char *text, sc_yaml *node)
{
    char *copy;

    SC_PASS(sc_text_copy(ctx, text, &copy));
    sc_free(node->given);
    node->given = node->text;
    node->text = copy;
    return SC_OK;
}

/* Put a share, 0 to 1, in percent in the place of the time @p node. It is rounded down, so that
 * what happens at a frame happens there and not one later. */
static sc_status put_share(const sc_ctx *ctx, double share, sc_yaml *node)
{
    char digits[40];

    snprintf(digits, sizeof digits, "%.12g%%", floor(share * 100 * 1e9) / 1e9);
    return put_text(ctx, digits, node);
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

/* Turn a time into a share, if it is one, or into seconds, of a film; a time behind the end of the
 * animation, which is a mistake, becomes the end. @param key the name of the value in messages. */
static sc_status resolve_time(const sc_ctx *ctx, const clock_of_job *clock, const char *key,
                              sc_yaml *node)
{
    char elsewhere[192]; /* or the seconds */
    double frame;
    sc_status status = SC_OK, put;

    if (!parse_time(clock, node, &frame))
        return SC_OK;
    if (clock->is_film) {
        snprintf(elsewhere, sizeof elsewhere, "%.17gs", frame / clock->fps);
        return put_text(ctx, elsewhere, node);
    }
    if (frame > clock->frames * (1 + 1e-9)) {
        name_length(clock->length, node, elsewhere, sizeof elsewhere);
        status = sc_yaml_fail(ctx, node,
                              "%s: %s is behind the end of the animation, which has %.0f frame%s "
                              "at %g frames per second: %.6g s%s",
                              key, node->text, clock->frames, clock->frames > 1 ? "s" : "",
                              clock->fps, clock->frames / clock->fps, elsewhere);
    }
    put = put_share(ctx, clock->frames > 1 ? fmin(frame / (clock->frames - 1), 1) : 0, node);
    return put == SC_OK ? status : put;
}

/* Are both ends of a part of the animation times or shares, and times in their order? Others are
 * left as they are, so that the message of the mistake quotes what stands in the file. */
static bool is_resolved(const clock_of_job *clock, const sc_yaml *list)
{
    double frames[2];
    int times = 0;

    for (size_t i = 0; i < list->count; i++) {
        const sc_yaml *node = list->items[i];

        if (times < 2 && parse_time(clock, node, &frames[times]))
            times++;
        else if (node->kind != SC_YAML_SCALAR || !strchr(node->text, '%'))
            return false;
    }
    return list->count == 2 && (times < 2 || frames[0] <= frames[1]);
}

/* As resolve_time, if the key of @p item is a time: then it is that of a key frame in the track @p
 * map. */
static sc_status resolve_key(const sc_ctx *ctx, const clock_of_job *clock, const sc_yaml *map,
                             sc_yaml *item)
{
    sc_yaml time = {
        .kind = SC_YAML_SCALAR, .line = item->line, .origin = item->origin, .text = item->key};
    const sc_status status = resolve_time(ctx, clock, map->key, &time);

    item->key = time.text;
    if (time.given) {
        sc_free(item->key_given);
        item->key_given = time.given;
    }
    return status;
}

/* Turn all times in the lists called "during" and of key frames in and below @p node into shares.
 */
static sc_status resolve_below(const sc_ctx *ctx, const clock_of_job *clock, sc_yaml *node)
{
    const bool is_part = node->kind == SC_YAML_LIST && node->key && !strcmp(node->key, "during");
    sc_status status = SC_OK;

    if (is_part && !is_resolved(clock, node))
        return SC_OK;
    for (size_t i = 0; i < node->count; i++) {
        sc_yaml *item = node->items[i];
        sc_status found = SC_OK;

        if (node->kind == SC_YAML_MAP)
            found = resolve_key(ctx, clock, node, item);
        if (found == SC_OK)
            found = is_part ? resolve_time(ctx, clock, node->key, item)
                            : resolve_below(ctx, clock, item);
        if (!sc_goes_on(&status, found))
            break;
    }
    return status;
}

sc_status sc_times_resolve(const sc_ctx *ctx, const sc_job *job, bool is_film, sc_yaml *root)
{
    static const char *const maps[] = {"animation", "color_by", "compare", "image",
                                       "light",     "overlays", "render"};
    clock_of_job clock = clock_of(ctx, root, job);
    sc_yaml *tissues = sc_yaml_member(root, "tissues");
    sc_status status = SC_OK;

    clock.is_film = is_film;
    for (size_t i = 0; tissues && i < tissues->count; i++) { /* whose keys are names, even "2s" */
        if (!sc_goes_on(&status, resolve_below(ctx, &clock, tissues->items[i])))
            return status;
    }
    for (size_t i = 0; i < SC_COUNT_OF(maps); i++) {
        sc_yaml *map = sc_yaml_member(root, maps[i]);

        if (map && !sc_goes_on(&status, resolve_below(ctx, &clock, map)))
            break;
    }
    return status;
}
