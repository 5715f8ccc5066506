/* SPDX-License-Identifier: BSD-3-Clause */
/* How far the verb explode, offsets and their key frames move each tissue, and which tissues move
 * together. */
#include "motion.h"

/* A middle that lies nearer to the center than this, in mm, has no direction from there. */
#define NO_DIRECTION_MM 1e-6

/* A box in voxels that grows; low is above high as long as it holds nothing. */
typedef struct voxel_box {
    double low[3], high[3];
} voxel_box;

static voxel_box empty_box(void)
{
    return (voxel_box){{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
}

/* Let a box hold that of a tissue, if it has voxels. */
static void add_tissue(const sc_prepared *volume, int id, voxel_box *box)
{
    const sc_label_stats *s = &volume->stats[id];

    for (int i = 0; i < 3 && s->low[0] <= s->high[0]; i++) {
        box->low[i] = fmin(box->low[i], s->low[i]);
        box->high[i] = fmax(box->high[i], s->high[i]);
    }
}

/* @return the middle of a box, RAS mm; that of the volume if it holds nothing. */
static sc_vec3 middle_of(const sc_prepared *volume, const voxel_box *box)
{
    double at[3];

    for (int i = 0; i < 3; i++)
        at[i] = box->low[i] <= box->high[i] ? 0.5 * (box->low[i] + box->high[i])
                                            : 0.5 * (volume->size[i] - 1);
    return sc_affine_point(&volume->to_ras_mm, (sc_vec3){at[0], at[1], at[2]});
}

/* What is resolved, and what comes of it. */
typedef struct resolving {
    const sc_prepared *volume;
    const sc_tissue *tissues;
    const sc_verbs *verbs;
    bool *members;     /* [label_count]: of the present verb; owned */
    sc_vec3 middle_mm; /* of all that is visible */
    sc_changes shifts; /* owned */
} resolving;

static void clear_resolving(resolving *r)
{
    sc_free(r->members);
    sc_free(r->shifts.all);
}

/* Append a shift, unless it leads nowhere. */
static sc_status add_shift(const sc_ctx *ctx, resolving *r, const sc_change *shift)
{
    return sc_vec3_length(shift->to) > 0 ? sc_changes_add(ctx, shift, &r->shifts) : SC_OK;
}

/* @return how far a verb moves what has its middle at @p middle_mm. */
static sc_vec3 way_of(const resolving *r, const sc_verb *verb, sc_vec3 middle_mm)
{
    const sc_vec3 center = verb->line.has_point ? verb->line.point_mm : r->middle_mm;
    const sc_vec3 apart = sc_vec3_sub(middle_mm, center);
    const double share = verb->by.value / 100;

    if (verb->line.has_axis)
        return sc_vec3_scale(verb->line.axis, verb->by.percent
                                                  ? share * sc_vec3_dot(apart, verb->line.axis)
                                                  : verb->by.value);
    if (verb->by.percent)
        return sc_vec3_scale(apart, share);
    if (sc_vec3_length(apart) < NO_DIRECTION_MM)
        return (sc_vec3){0, 0, 0};
    return sc_vec3_scale(sc_vec3_unit(apart), verb->by.value);
}

/* Append the shifts of verb @p v. */
static sc_status add_shifts(const sc_ctx *ctx, resolving *r, size_t v)
{
    const sc_verb *verb = &r->verbs->verbs[v];
    voxel_box common = empty_box();

    (void)sc_verb_members(r->volume, r->tissues, r->verbs, v, r->members);
    for (int id = 1; id < r->volume->label_count && verb->together; id++) {
        if (r->members[id])
            add_tissue(r->volume, id, &common);
    }
    for (int id = 1; id < r->volume->label_count; id++) {
        voxel_box box = verb->together ? common : empty_box();
        sc_vec3 by_mm;

        if (!r->members[id] || !r->volume->stats[id].voxels)
            continue;
        if (!verb->together)
            add_tissue(r->volume, id, &box);
        by_mm = way_of(r, verb, middle_of(r->volume, &box));
        SC_PASS(add_shift(ctx, r,
                          &(sc_change){.id = id,
                                       .kind = SC_VERB_EXPLODE,
                                       .begin = verb->begin,
                                       .end = verb->end,
                                       .ease = verb->ease,
                                       .to = by_mm}));
    }
    return SC_OK;
}

/* Append the shifts by which a tissue has its offset: the constant one, or the first, from the
 * beginning on, and those from each key frame to the next. */
static sc_status add_offset(const sc_ctx *ctx, resolving *r, int id)
{
    const sc_tissue *tissue = &r->tissues[id];
    const sc_track *track = sc_track_number(r->verbs->tracks, tissue->offset_track);

    if (!tissue->visible || !(tissue->opacity + tissue->interior_opacity > 0) ||
        !r->volume->stats[id].voxels)
        return SC_OK;
    SC_PASS(add_shift(ctx, r,
                      &(sc_change){.id = id,
                                   .kind = SC_VERB_EXPLODE,
                                   .to = track ? track->keys[0].value : tissue->offset_mm}));
    for (int i = 1; track && i < track->count; i++) {
        const sc_key_frame *from = &track->keys[i - 1], *to = &track->keys[i];

        SC_PASS(add_shift(ctx, r,
                          &(sc_change){.id = id,
                                       .kind = SC_VERB_EXPLODE,
                                       .begin = from->at,
                                       .end = to->at,
                                       .ease = to->ease,
                                       .to = sc_vec3_sub(to->value, from->value)}));
    }
    return SC_OK;
}

/* ---- parts ---- */

/* Find the part of a tissue whose shifts are the @p n from @p at on: that of a tissue before it
 * with the same shifts, or a new one. @return it, or -1 if there are too many. */
static int find_part(const sc_change *shifts, const sc_tissue *tissues, size_t at, size_t n,
                     int *parts)
{
    for (size_t i = 0; i < at; i += sc_changes_of_first(shifts + i, at - i)) {
        if (sc_changes_of_first(shifts + i, at - i) == n &&
            sc_changes_same(shifts + i, shifts + at, n))
            return tissues[shifts[i].id].part;
    }
    if (*parts == SC_PARTS_MAX)
        return -1;
    return (*parts)++;
}

/* Say that more tissues move each by itself than there may be parts. @return SC_ERR_DATA. */
static sc_status too_many(const sc_ctx *ctx, const resolving *r)
{
    for (size_t v = 0; v < r->verbs->verb_count; v++) {
        const sc_verb *verb = &r->verbs->verbs[v];

        if (verb->kind == SC_VERB_EXPLODE)
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s%sexplode: more than %d tissues move each by itself; expected fewer, "
                           "or together: true, which moves those of a verb as one",
                           verb->where, verb->where[0] ? ": " : "", SC_PARTS_MAX - 1);
    }
    return sc_fail(ctx, SC_ERR_DATA,
                   "tissues: more than %d have each an offset of its own; expected fewer, or the "
                   "same for some of them, which move as one",
                   SC_PARTS_MAX - 1);
}

/* Set part of all tissues. @return SC_ERR_DATA, logged. */
static sc_status set_parts(const sc_ctx *ctx, const resolving *r, sc_tissue *tissues)
{
    const sc_changes *s = &r->shifts;
    int parts = 1;
    size_t n;

    for (size_t at = 0; at < s->count; at += n) {
        int part;

        n = sc_changes_of_first(s->all + at, s->count - at);
        part = find_part(s->all, tissues, at, n, &parts);
        if (part < 0)
            return too_many(ctx, r);
        tissues[s->all[at].id].part = (uint8_t)part;
    }
    return SC_OK;
}

/* Append the shifts of all verbs and offsets. */
static sc_status add_all(const sc_ctx *ctx, resolving *r)
{
    for (size_t v = 0; v < r->verbs->verb_count; v++) {
        if (r->verbs->verbs[v].kind == SC_VERB_EXPLODE)
            SC_PASS(add_shifts(ctx, r, v));
    }
    for (int id = 1; id < r->volume->label_count; id++)
        SC_PASS(add_offset(ctx, r, id));
    return sc_changes_sort(ctx, &r->shifts);
}

sc_status sc_explodes_resolve(const sc_ctx *ctx, const sc_prepared *volume, sc_tissue *tissues,
                              const sc_verbs *verbs, sc_change **out, size_t *count)
{
    SC_OWN(clear_resolving)
    resolving r = {.volume = volume, .tissues = tissues, .verbs = verbs};
    voxel_box visible = empty_box();

    for (int id = 0; id < volume->label_count; id++) {
        tissues[id].part = 0;
        if (id && tissues[id].visible)
            add_tissue(volume, id, &visible);
    }
    r.middle_mm = middle_of(volume, &visible);
    SC_PASS(SC_ALLOC(ctx, (size_t)volume->label_count, &r.members));
    SC_PASS(add_all(ctx, &r));
    SC_PASS(set_parts(ctx, &r, tissues));
    *count = r.shifts.count;
    SC_HAND_OVER(r.shifts.all, out);
    return SC_OK;
}

/* ---- frames ---- */

/* @return how far the shifts [count] of one tissue have moved it at a time. */
static sc_vec3 offset_at(const sc_change *shifts, size_t count, double at)
{
    sc_vec3 out = {0, 0, 0};

    for (size_t i = 0; i < count; i++)
        out = sc_vec3_along(out, sc_progress(shifts[i].begin, shifts[i].end, shifts[i].ease, at),
                            shifts[i].to);
    return out;
}

sc_vec3 sc_tissue_corner(const sc_prepared *volume, int id, int i)
{
    const sc_label_stats *s = &volume->stats[id];
    const sc_box3 box = {{s->low[0] - 0.5, s->low[1] - 0.5, s->low[2] - 0.5},
                         {s->high[0] + 0.5, s->high[1] + 0.5, s->high[2] + 0.5}};

    return sc_affine_point(&volume->to_ras_mm, sc_box3_corner(&box, i));
}

void sc_shifts_reach(const sc_prepared *volume, const sc_change *shifts, size_t count, sc_vec3 *out)
{
    size_t n;

    for (size_t at = 0; at < count; at += n) {
        n = sc_changes_of_first(shifts + at, count - at);
        for (size_t i = 0; i < 8 * n; i++) {
            const sc_vec3 offset = offset_at(shifts + at, n, shifts[at + i / 8].end);

            *out++ = sc_vec3_add(sc_tissue_corner(volume, shifts[at].id, (int)i), offset);
        }
    }
}

size_t sc_shifts_reach_at(const sc_prepared *volume, const sc_change *shifts, size_t count,
                          double time, sc_vec3 *out)
{
    size_t n, found = 0;

    for (size_t at = 0; at < count; at += n) {
        sc_vec3 offset;

        n = sc_changes_of_first(shifts + at, count - at);
        offset = offset_at(shifts + at, n, time);
        for (size_t i = 0; i < 8 && sc_vec3_length(offset) > 0; i++)
            out[found++] = sc_vec3_add(sc_tissue_corner(volume, shifts[at].id, (int)i), offset);
    }
    return found;
}

bool sc_offsets_at(const sc_looks *looks, double time, sc_vec3 *out)
{
    bool any = false;
    size_t n;

    memset(out, 0, (size_t)looks->label_count * sizeof *out);
    for (size_t at = 0; at < looks->shift_count; at += n) {
        const sc_change *shifts = &looks->shifts[at];

        n = sc_changes_of_first(shifts, looks->shift_count - at);
        out[shifts->id] = offset_at(shifts, n, time);
        any = any || sc_vec3_length(out[shifts->id]) > 0;
    }
    return any;
}
