/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/scene.h"

/* The group whose planes are @p planes, made if it is new; -1 if there are too many. */
static int group_of(uint32_t planes, uint32_t *groups, int *count)
{
    for (int g = 0; g < *count; g++) {
        if (groups[g] == planes)
            return g;
    }
    if (*count == SC_GROUPS_MAX)
        return -1;
    groups[*count] = planes;
    return (*count)++;
}

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

sc_status sc_clip_groups(const sc_ctx *ctx, const sc_prepared *volume, int plane_count,
                         const sc_clip_exception *exceptions, size_t exception_count,
                         sc_tissue *tissues, uint32_t *groups, int *group_count)
{
    const uint32_t all = (1u << plane_count) - 1;
    sc_status status = check_exceptions(ctx, volume, exceptions, exception_count);
    int count = 1;

    if (status != SC_OK)
        return status;
    groups[0] = all;
    for (int id = 1; id < volume->label_count; id++) {
        uint32_t planes = all;
        int group;

        for (size_t i = 0; i < exception_count; i++) {
            if (sc_label_matches(&volume->labels[id], exceptions[i].pattern))
                planes &= ~(1u << exceptions[i].plane);
        }
        group = group_of(planes, groups, &count);
        if (group < 0)
            return sc_fail(ctx, SC_ERR_USAGE,
                           "the exceptions of the clip planes make more than %d different groups "
                           "of tissues",
                           SC_GROUPS_MAX);
        tissues[id].clip_group = (uint8_t)group;
    }
    *group_count = count;
    return SC_OK;
}
