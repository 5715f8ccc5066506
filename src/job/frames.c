/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/job.h"

#include <stdlib.h>

/* Read a non-negative number, and move *at behind it and the blanks around it. @return false if
 * there is none. */
static bool read_number(const char **at, long *out)
{
    char *end;

    *at += strspn(*at, " ");
    if (**at < '0' || **at > '9')
        return false;
    *out = strtol(*at, &end, 10);
    *at = end + strspn(end, " ");
    return true;
}

/* Read one range: a, a-b or a-b:step, and move *at behind it. @return false if it is none, or the
 * step is 0. */
static bool read_range(const char **at, long *first, long *last, long *step)
{
    if (!read_number(at, first))
        return false;
    *last = *first;
    *step = 1;
    if (**at != '-')
        return true;
    (*at)++;
    if (!read_number(at, last))
        return false;
    if (**at != ':')
        return true;
    (*at)++;
    return read_number(at, step) && *step > 0;
}

/* Write the frames of the list to @p frames as they follow each other there, and set wanted[k] for
 * each frame k of them. */
static sc_status read_frames(const sc_ctx *ctx, const char *text, int total, char *wanted,
                             int *frames, int *count)
{
    const char *at = text;

    *count = 0;

    for (;;) {
        long first, last, step;

        if (!read_range(&at, &first, &last, &step) || (*at && *at != ','))
            return sc_fail(ctx, SC_ERR_USAGE, "--frames is \"%s\", expected for example 0-35:2,40",
                           text);
        if (last < first || last >= total)
            return sc_fail(ctx, SC_ERR_USAGE,
                           "--frames %ld-%ld is not within the animation's frames 0-%d", first,
                           last, total - 1);
        for (long k = first;; k += step) {
            if (wanted[k])
                return sc_fail(ctx, SC_ERR_USAGE, "--frames \"%s\" names frame %ld twice", text, k);
            wanted[k] = 1;
            frames[(*count)++] = (int)k;
            if (step > last - k) /* k + step could overflow */
                break;
        }
        if (!*at)
            return SC_OK;
        at++;
    }
}

sc_status sc_frames_parse_order(const sc_ctx *ctx, const char *text, int total, int **out,
                                int *count)
{
    SC_OWN(sc_free_at) char *wanted = NULL;
    SC_OWN(sc_free_at) int *frames = NULL;

    SC_PASS(SC_ZALLOC(ctx, (size_t)total, &wanted));
    SC_PASS(SC_ALLOC(ctx, (size_t)total, &frames));
    SC_PASS(read_frames(ctx, text, total, wanted, frames, count));
    SC_HAND_OVER(frames, out);
    return SC_OK;
}

static int compare_frames(const void *a, const void *b)
{
    const int x = *(const int *)a, y = *(const int *)b;

    return (x > y) - (x < y);
}

sc_status sc_frames_parse(const sc_ctx *ctx, const char *text, int total, int **out, int *count)
{
    if (text) {
        SC_PASS(sc_frames_parse_order(ctx, text, total, out, count));
        qsort(*out, (size_t)*count, sizeof **out, compare_frames);
        return SC_OK;
    }
    SC_PASS(SC_ALLOC(ctx, (size_t)total, out));
    for (int k = 0; k < total; k++)
        (*out)[k] = k;
    *count = total;
    return SC_OK;
}

sc_status sc_frames_slice(const sc_ctx *ctx, int i, int n, int gop, int total, int **out,
                          int *count)
{
    const long gops = (total + gop - 1) / gop;
    const long first = gops * i / n * gop, next = gops * (i + 1) / n * gop;
    const long end = next < total ? next : total;

    SC_PASS(SC_ALLOC(ctx, (size_t)(end - first) + 1, out));
    for (long k = first; k < end; k++)
        (*out)[k - first] = (int)k;
    *count = (int)(end - first);
    return SC_OK;
}
