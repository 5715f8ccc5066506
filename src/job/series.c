/* SPDX-License-Identifier: BSD-3-Clause */
/* The volumes of a series: files whose names differ in a number. */
#include "key.h"
#include "segcast/job.h"

#include <ctype.h>
#include <errno.h>
#include <glob.h>
#include <math.h>
#include <stdlib.h>

/* @return how many digits stand at the beginning of @p text. */
static size_t digits_at(const char *text)
{
    return strspn(text, "0123456789");
}

int sc_natural_order(const char *a, const char *b)
{
    const char *const whole_a = a, *const whole_b = b;

    while (*a && *b) {
        if (digits_at(a) && digits_at(b)) {
            const char *x = a + strspn(a, "0"), *y = b + strspn(b, "0");
            const size_t m = digits_at(x), n = digits_at(y);
            const int order = m != n ? (m < n ? -1 : 1) : strncmp(x, y, n);

            if (order)
                return order;
            a = x + m;
            b = y + n;
        } else if (*a != *b) {
            return (unsigned char)*a < (unsigned char)*b ? -1 : 1;
        } else {
            a++;
            b++;
        }
    }
    return *a || *b ? (*a ? 1 : -1) : strcmp(whole_a, whole_b);
}

static int compare_paths(const void *a, const void *b)
{
    return sc_natural_order(*(char *const *)a, *(char *const *)b);
}

/* Find where the number stands in which @p path differs from @p other. @return false if they differ
 * in anything else. */
static bool find_number(const char *path, const char *other, size_t *out)
{
    size_t at = 0;

    while (path[at] && path[at] == other[at])
        at++;
    while (at && isdigit((unsigned char)path[at - 1]))
        at--;
    if (!digits_at(path + at) || !digits_at(other + at) ||
        strcmp(path + at + digits_at(path + at), other + at + digits_at(other + at)) != 0)
        return false;
    *out = at;
    return true;
}

/* @return the step from the number of one name to that of the next. */
static double step_between(const char *path, const char *next, size_t at)
{
    return strtod(next + at, NULL) - strtod(path + at, NULL);
}

/* Check that names which are in their order have numbers in equal steps, so that no volume of the
 * series is missing. @return as sc_yaml_fail. */
static sc_status check_numbers(const sc_ctx *ctx, const sc_yaml *node, const char *key,
                               char *const *paths, size_t count)
{
    double least = HUGE_VAL;
    size_t at = 0, place = 0;

    for (size_t i = 0; i + 1 < count; i++) {
        if (!find_number(paths[i], paths[i + 1], &place) || (i && place != at))
            return sc_yaml_fail(ctx, node,
                                "%s: %s and %s differ in more than one number, so that their order "
                                "is not known; expected a list of the files: [%s, ...]",
                                key, sc_file_name(paths[i]), sc_file_name(paths[i + 1]),
                                sc_file_name(paths[0]));
        at = place;
        least = fmin(least, step_between(paths[i], paths[i + 1], at));
    }
    for (size_t i = 0; i + 1 < count && least == 0; i++) {
        if (step_between(paths[i], paths[i + 1], at) == 0)
            return sc_yaml_fail(ctx, node,
                                "%s: %s and %s have the same number; expected a list of the files",
                                key, sc_file_name(paths[i]), sc_file_name(paths[i + 1]));
    }
    for (size_t i = 0; i + 1 < count; i++) {
        if (step_between(paths[i], paths[i + 1], at) > least)
            return sc_yaml_fail(
                ctx, node,
                "%s: there is no file between %s and %s, while the numbers of others differ by "
                "%.0f; expected all files of the series, or a list of those that are to be shown",
                key, sc_file_name(paths[i]), sc_file_name(paths[i + 1]), least);
    }
    return SC_OK;
}

sc_status sc_series_alloc(const sc_ctx *ctx, const sc_yaml *node, size_t count, sc_job *job)
{
    sc_volume_path *phases;

    if (count == 0 || count > SC_PHASES_MAX)
        return sc_yaml_fail(ctx, node, "volume has %zu phases, expected 1 to %d", count,
                            SC_PHASES_MAX);
    SC_PASS(SC_ZALLOC(ctx, count, &phases));
    sc_free(job->volume.phases);
    job->volume.phases = phases;
    job->volume.phase_count = count;
    return SC_OK;
}

/* Log that no file matches a pattern. @return SC_ERR_MISSING. */
static sc_status tell_none(const sc_ctx *ctx, const sc_yaml *node, const char *key,
                           const char *pattern)
{
    if (node->line > 0)
        return sc_fail(ctx, SC_ERR_MISSING, "%s:%d: %s: no file matches %s", node->origin,
                       node->line, key, pattern);
    if (!strcmp(node->origin, key)) /* set by a command, from its argument */
        return sc_fail(ctx, SC_ERR_MISSING, "%s: no file matches", pattern);
    return sc_fail(ctx, SC_ERR_MISSING, "%s: no file matches %s", node->origin, pattern);
}

/* @return how many parts of a path, between slashes, have wildcards. */
static int count_wild_parts(const char *pattern)
{
    int count = 0;

    while (*pattern) {
        const size_t length = strcspn(pattern, "/");

        count += strcspn(pattern, "*?[") < length;
        pattern += length + (pattern[length] == '/');
    }
    return count;
}

sc_status sc_series_find(const sc_ctx *ctx, const sc_yaml *node, const char *key,
                         const char *pattern, sc_job *job)
{
    enum { WILD_PARTS_MAX = 2 }; /* each more may multiply what is looked through by thousands */
    SC_OWN(globfree) glob_t found = {0};
    int result;

    if (count_wild_parts(pattern) > WILD_PARTS_MAX)
        return sc_yaml_fail(ctx, node,
                            "%s: %s has wildcards in %d parts of the path, expected at most %d; "
                            "name the directories",
                            key, job->volume.path, count_wild_parts(pattern), WILD_PARTS_MAX);
    result = glob(pattern, GLOB_NOSORT, NULL, &found);
    if (result == GLOB_NOSPACE)
        return sc_fail(ctx, SC_ERR_MEMORY, "out of memory while %s was looked for", pattern);
    if (result)
        return tell_none(ctx, node, key, job->volume.path);
    qsort(found.gl_pathv, found.gl_pathc, sizeof *found.gl_pathv, compare_paths);
    SC_PASS(check_numbers(ctx, node, key, found.gl_pathv, found.gl_pathc));
    SC_PASS(sc_series_alloc(ctx, node, found.gl_pathc, job));
    for (size_t i = 0; i < found.gl_pathc; i++) {
        SC_OWN(sc_free_at) char *absolute = realpath(found.gl_pathv[i], NULL);

        if (!absolute)
            return sc_tell_missing(ctx, node, key, found.gl_pathv[i], errno);
        if (strlen(absolute) >= SC_PATH_BYTES)
            return sc_yaml_fail(ctx, node, "the path has %zu characters, expected less than %d",
                                strlen(absolute), SC_PATH_BYTES);
        strcpy(job->volume.phases[i].path, absolute);
    }
    return SC_OK;
}
