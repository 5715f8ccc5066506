/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/job.h"

#include <stdlib.h>
#include <string.h>

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
    void *wanted = NULL, *frames = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, (size_t)total, 1, &wanted));
    SC_TRY(sc_alloc(ctx, (size_t)total, sizeof(int), &frames));
    SC_TRY(read_frames(ctx, text, total, wanted, frames, count));
    *out = frames;
    frames = NULL;
out:
    sc_free(wanted);
    sc_free(frames);
    return status;
}

static int compare_frames(const void *a, const void *b)
{
    const int x = *(const int *)a, y = *(const int *)b;

    return (x > y) - (x < y);
}

sc_status sc_frames_parse(const sc_ctx *ctx, const char *text, int total, int **out, int *count)
{
    void *frames;
    sc_status status;

    if (text) {
        status = sc_frames_parse_order(ctx, text, total, out, count);
        if (status == SC_OK)
            qsort(*out, (size_t)*count, sizeof **out, compare_frames);
        return status;
    }
    SC_TRY(sc_alloc(ctx, (size_t)total, sizeof(int), &frames));
    for (int k = 0; k < total; k++)
        ((int *)frames)[k] = k;
    *out = frames;
    *count = total;
out:
    return status;
}

sc_status sc_frames_slice(const sc_ctx *ctx, int i, int n, int gop, int total, int **out,
                          int *count)
{
    const long gops = (total + gop - 1) / gop;
    const long first = gops * i / n * gop, next = gops * (i + 1) / n * gop;
    const long end = next < total ? next : total;
    void *frames;
    sc_status status = sc_alloc(ctx, (size_t)(end - first) + 1, sizeof(int), &frames);

    if (status != SC_OK)
        return status;
    for (long k = first; k < end; k++)
        ((int *)frames)[k - first] = (int)k;
    *out = frames;
    *count = (int)(end - first);
    return SC_OK;
}
