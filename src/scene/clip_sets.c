/* SPDX-License-Identifier: BSD-3-Clause */
/* Which clip planes cut which tissues. */
#include "segcast/scene.h"

/* Find the clip set with these planes, and append it to clip_sets [*count] if it is new. @return
 * its index; -1 if there are already SC_CLIP_SETS_MAX others. */
static int find_or_add(uint32_t planes, uint32_t *clip_sets, int *count)
{
    for (int i = 0; i < *count; i++) {
        if (clip_sets[i] == planes)
            return i;
    }
    if (*count == SC_CLIP_SETS_MAX)
        return -1;
    clip_sets[*count] = planes;
    return (*count)++;
}

/* Returns SC_ERR_DATA, logged, for the first exception that matches no label, else SC_OK. */
static sc_status check_exceptions(const sc_ctx *ctx, const sc_prepared *volume,
                                  const sc_clip_exception *exceptions, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        bool matched = false;

        for (int id = 1; id < volume->label_count && !matched; id++)
            matched = sc_label_matches(&volume->labels[id], exceptions[i].pattern);
        if (!matched)
            return sc_tissue_unknown(ctx, volume, exceptions[i].pattern, exceptions[i].where);
    }
    return SC_OK;
}

sc_status sc_clip_sets_find(const sc_ctx *ctx, const sc_prepared *volume, int plane_count,
                            const sc_clip_exception *exceptions, size_t exception_count,
                            sc_tissue *tissues, uint32_t *clip_sets, int *clip_set_count)
{
    const uint32_t all = (1u << plane_count) - 1;
    sc_status status = check_exceptions(ctx, volume, exceptions, exception_count);
    int count = 1;

    if (status != SC_OK)
        return status;
    clip_sets[0] = all;
    for (int id = 1; id < volume->label_count; id++) {
        uint32_t planes = all;
        int set;

        for (size_t i = 0; i < exception_count; i++) {
            if (sc_label_matches(&volume->labels[id], exceptions[i].pattern))
                planes &= ~(1u << exceptions[i].plane);
        }
        set = find_or_add(planes, clip_sets, &count);
        if (set < 0)
            return sc_fail(ctx, SC_ERR_USAGE,
                           "the exceptions of the clip planes make more than %d different sets of "
                           "planes; let more tissues share the same exceptions",
                           SC_CLIP_SETS_MAX);
        tissues[id].clip_set = (uint8_t)set;
    }
    *clip_set_count = count;
    return SC_OK;
}
