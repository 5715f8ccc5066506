/* SPDX-License-Identifier: BSD-3-Clause */
/* Which clip planes cut which tissues. */
#include "segcast/scene.h"

#include <string.h>

/* Find the clip set that is the same, and append it to clip_sets [*count] if it is new. @return its
 * index; -1 if there are already SC_CLIP_SETS_MAX others. */
static int find_or_add(const sc_clip_set *set, sc_clip_set *clip_sets, int *count)
{
    for (int i = 0; i < *count; i++) {
        if (!memcmp(clip_sets[i].spares, set->spares, sizeof set->spares))
            return i;
    }
    if (*count == SC_CLIP_SETS_MAX)
        return -1;
    clip_sets[*count] = *set;
    return (*count)++;
}

/* Note an exception in the sets of the tissues that it names. @param sets [label_count] of each. */
static void apply_exception(const sc_prepared *volume, const sc_clip_exception *exception,
                            sc_clip_set *sets)
{
    const sc_pattern pattern = sc_pattern_of(exception->pattern);
    const sc_match best = sc_pattern_match(volume->labels, volume->label_count, &pattern);

    for (int id = 1; id < volume->label_count && best != SC_MATCH_NONE; id++) {
        if (sc_label_match(&volume->labels[id], &pattern) == best)
            sets[id].spares[exception->plane] |= (uint64_t)1 << exception->span;
    }
}

sc_status sc_clip_sets_find(const sc_ctx *ctx, const sc_prepared *volume,
                            const sc_clip_exception *exceptions, size_t exception_count,
                            sc_tissue *tissues, sc_clip_set *clip_sets, int *clip_set_count)
{
    SC_OWN(sc_free_at) sc_clip_set *sets = NULL;
    int count = 1;

    SC_PASS(SC_ZALLOC(ctx, (size_t)volume->label_count, &sets));
    for (size_t i = 0; i < exception_count; i++)
        apply_exception(volume, &exceptions[i], sets);
    clip_sets[0] = (sc_clip_set){{0}};
    for (int id = 1; id < volume->label_count; id++) {
        const int set = find_or_add(&sets[id], clip_sets, &count);

        if (set < 0)
            return sc_fail(ctx, SC_ERR_USAGE,
                           "the exceptions of the clip planes make more than %d different sets "
                           "of planes; let more tissues share the same exceptions",
                           SC_CLIP_SETS_MAX);
        tissues[id].clip_set = (uint8_t)set;
    }
    *clip_set_count = count;
    return SC_OK;
}
