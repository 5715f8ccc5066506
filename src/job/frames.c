/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/job.h"

#include <stdlib.h>
#include <string.h>

/* A non-negative number; *at moves behind it and blanks around it. */
static bool number(const char **at, long *out)
{
    char *end;

    *at += strspn(*at, " ");
    if (**at < '0' || **at > '9')
        return false;
    *out = strtol(*at, &end, 10);
    *at = end + strspn(end, " ");
    return true;
}

/* One element: a, a-b or a-b:step. */
static bool element(const char **at, long *first, long *last, long *step)
{
    if (!number(at, first))
        return false;
    *last = *first;
    *step = 1;
    if (**at != '-')
        return true;
    (*at)++;
    if (!number(at, last))
        return false;
    if (**at != ':')
        return true;
    (*at)++;
    return number(at, step) && *step > 0;
}

static sc_status mark(const sc_ctx *ctx, const char *text, int total, char *wanted)
{
    const char *at = text;

    for (;;) {
        long first, last, step;

        if (!element(&at, &first, &last, &step) || (*at && *at != ','))
            return sc_fail(ctx, SC_ERR_USAGE, "--frames is \"%s\", expected for example 0-35:2,40",
                           text);
        if (last < first || last >= total)
            return sc_fail(ctx, SC_ERR_USAGE,
                           "--frames %ld-%ld is not within the animation's frames 0-%d", first,
                           last, total - 1);
        for (long k = first; k <= last; k += step) {
            if (wanted[k])
                return sc_fail(ctx, SC_ERR_USAGE, "--frames \"%s\" names frame %ld twice", text, k);
            wanted[k] = 1;
        }
        if (!*at)
            return SC_OK;
        at++;
    }
}

sc_status sc_frames_parse(const sc_ctx *ctx, const char *text, int total, int **out, int *count)
{
    void *wanted = NULL, *frames = NULL;
    int found = 0;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, (size_t)total, 1, &wanted));
    SC_TRY(sc_alloc(ctx, (size_t)total, sizeof(int), &frames));
    if (text)
        SC_TRY(mark(ctx, text, total, wanted));
    else
        memset(wanted, 1, (size_t)total);
    for (int k = 0; k < total; k++) {
        if (((const char *)wanted)[k])
            ((int *)frames)[found++] = k;
    }
    *out = frames;
    *count = found;
    frames = NULL;
out:
    sc_free(wanted);
    sc_free(frames);
    return status;
}

sc_status sc_frames_slice(const sc_ctx *ctx, int i, int n, int group, int total, int **out,
                          int *count)
{
    const long groups = (total + group - 1) / group;
    const long first = groups * i / n * group, next = groups * (i + 1) / n * group;
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
