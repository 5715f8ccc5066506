/* SPDX-License-Identifier: BSD-3-Clause */
/* What is told of a tissue that a job names and the volume has not. */
#include "segcast/scene.h"

#include <string.h>

enum { OFFERED_MAX = 3 }; /* names in a message */

/* Log that a pattern matches nothing in a volume whose labels have no names. */
static sc_status fail_nameless(const sc_ctx *ctx, const sc_prepared *volume, const char *pattern,
                               const char *where, const char *colon)
{
    if (volume->label_count < 2)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s%stissue \"%s\" cannot be found: no label of the volume is known", where,
                       colon, pattern);
    return sc_fail(
        ctx, SC_ERR_DATA,
        "%s%stissue \"%s\" cannot be found: the labels of the volume have no names; name "
        "tissues by number (%lld to %lld), or give a table with their names (labels:)",
        where, colon, pattern, (long long)volume->labels[1].value,
        (long long)volume->labels[volume->label_count - 1].value);
}

/* Log that a pattern matches nothing, with the nearest names. @return SC_ERR_DATA; SC_ERR_MEMORY.
 */
static sc_status fail_unknown(const sc_ctx *ctx, const sc_prepared *volume,
                              const sc_pattern *pattern, const char *where)
{
    const char *nearest[OFFERED_MAX], *colon = where[0] ? ": " : "";
    char offered[OFFERED_MAX * (SC_NAME_BYTES + 8)] = "";
    bool has_names = false;
    size_t count, used = 0;
    SC_OWN(sc_free_at) const char **names = NULL;

    SC_PASS(SC_ZALLOC(ctx, (size_t)volume->label_count, &names));
    for (int id = 1; id < volume->label_count; id++) {
        names[id] = volume->labels[id].name[0] ? volume->labels[id].name : NULL;
        has_names = has_names || names[id];
    }
    count =
        sc_nearest_words(pattern->text, names, (size_t)volume->label_count, OFFERED_MAX, nearest);
    for (size_t i = 0; i < count; i++)
        used += (size_t)snprintf(offered + used, sizeof offered - used, "%s\"%s\"",
                                 i == 0           ? "; did you mean "
                                 : i + 1 == count ? " or "
                                                  : ", ",
                                 nearest[i]);
    if (!has_names && !pattern->is_number)
        return fail_nameless(ctx, volume, pattern->text, where, colon);
    return sc_fail(ctx, SC_ERR_DATA, "%s%stissue \"%s\" matches no label of the volume%s%s", where,
                   colon, pattern->text, offered, count ? "?" : "");
}

/* Refuse a name that is not written as in the volume and could stand for labels of different names.
 * @p best how well it fits. */
static sc_status check_clear(const sc_ctx *ctx, const sc_prepared *volume,
                             const sc_pattern *pattern, sc_match best, const char *where)
{
    const sc_label *first = NULL;

    if (pattern->is_glob || best == SC_MATCH_EXACT)
        return SC_OK;
    for (int id = 1; id < volume->label_count; id++) {
        const sc_label *label = &volume->labels[id];

        if (sc_label_match(label, pattern) != best)
            continue;
        if (!first)
            first = label;
        else if (strcmp(first->name, label->name))
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s%stissue \"%s\" could be \"%s\" (label %lld) or \"%s\" (label %lld); "
                           "write the name exactly as it is there, or the number",
                           where, where[0] ? ": " : "", pattern->text, first->name,
                           (long long)first->value, label->name, (long long)label->value);
    }
    return SC_OK;
}

sc_status sc_pattern_check(const sc_ctx *ctx, const sc_prepared *volume, const char *pattern,
                           const char *where)
{
    const sc_pattern p = sc_pattern_of(pattern);
    const sc_match best = sc_pattern_match(volume->labels, volume->label_count, &p);

    if (p.is_all) /* allowed even where there are no labels */
        return SC_OK;
    return best == SC_MATCH_NONE ? fail_unknown(ctx, volume, &p, where)
                                 : check_clear(ctx, volume, &p, best, where);
}
