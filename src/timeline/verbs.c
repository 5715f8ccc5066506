/* SPDX-License-Identifier: BSD-3-Clause */
/* Verbs and key frames: what they do to the opacity of each tissue, and how opaque that is in a
 * frame. */
#include "motion.h"

#include <stdlib.h>

/* A factor below this is none: the tissue is not there. The ends of parts of the animation are
 * rounded, so that a tissue would else be left a trace of in the frame in which it begins to
 * appear. */
#define LEAST_FACTOR 1e-6

/* ---- the tissues of a verb ---- */

/* A tissue of a verb, and where it comes in the order of the verb. */
typedef struct member {
    int id;
    double rank; /* the least comes first; of equal ones the one that is listed first */
    size_t listed;
} member;

static int compare_members(const void *a, const void *b)
{
    const member *left = a, *right = b;

    if (left->rank < right->rank || left->rank > right->rank)
        return left->rank < right->rank ? -1 : 1;
    return (left->listed > right->listed) - (left->listed < right->listed);
}

/* Can a tissue be seen at all, so that a verb changes anything? */
static bool is_seen(const sc_tissue *tissue)
{
    return tissue->visible && (tissue->opacity > 0 || tissue->interior_opacity > 0);
}

/* @return where a tissue comes in an order. */
static double rank_of(const sc_prepared *volume, int id, sc_verb_order order)
{
    const sc_label_stats *s = &volume->stats[id];
    const sc_vec3 middle = {0.5 * (s->low[0] + s->high[0]), 0.5 * (s->low[1] + s->high[1]),
                            0.5 * (s->low[2] + s->high[2])};

    switch (order) {
    case SC_ORDER_LIST:
        return 0;
    case SC_ORDER_LARGEST:
        return -(double)s->voxels;
    case SC_ORDER_SMALLEST:
        return (double)s->voxels;
    default:
        return sc_vec3_dot(sc_order_direction(order), sc_affine_point(&volume->to_ras_mm, middle));
    }
}

/* The tissues of an animation while its verbs are resolved. */
typedef struct resolving {
    const sc_prepared *volume;
    const sc_tissue *tissues;
    const sc_verbs *verbs;
    bool *taken;      /* [label_count]: by the present verb; owned */
    member *members;  /* room for [label_count]; owned */
    sc_changes fades; /* owned */
} resolving;

static void clear_resolving(resolving *r)
{
    sc_free(r->taken);
    sc_free(r->members);
    sc_free(r->fades.all);
}

/* Find the tissues of verb @p v that can be seen, each once. @param taken [label_count]: set for
 * these. @param members room for [label_count], or NULL. @return how many there are. */
static size_t each_member(const sc_prepared *volume, const sc_tissue *tissues,
                          const sc_verbs *verbs, size_t v, bool *taken, member *members)
{
    size_t count = 0;

    memset(taken, 0, (size_t)volume->label_count);
    for (size_t i = 0; i < verbs->list_count; i++) {
        const sc_pattern pattern = sc_pattern_of(verbs->list[i].pattern);
        const sc_match best = verbs->list[i].of == (int)v
                                  ? sc_pattern_match(volume->labels, volume->label_count, &pattern)
                                  : SC_MATCH_NONE;

        for (int id = 1; id < volume->label_count && best != SC_MATCH_NONE; id++) {
            if (taken[id] || !is_seen(&tissues[id]) ||
                sc_label_match(&volume->labels[id], &pattern) != best)
                continue;
            taken[id] = true;
            if (members)
                members[count] = (member){id, rank_of(volume, id, verbs->verbs[v].order), count};
            count++;
        }
    }
    return count;
}

int sc_verb_members(const sc_prepared *volume, const sc_tissue *tissues, const sc_verbs *verbs,
                    size_t v, bool *out)
{
    return (int)each_member(volume, tissues, verbs, v, out, NULL);
}

/* Find the tissues of verb @p v that can be seen, each once, in its order: r->members. @return how
 * many there are. */
static size_t find_members(resolving *r, size_t v)
{
    const size_t count = each_member(r->volume, r->tissues, r->verbs, v, r->taken, r->members);

    qsort(r->members, count, sizeof *r->members, compare_members);
    return count;
}

/* @return what the verb multiplies the opacity of a tissue by in the end. */
static double factor_of(const sc_verb *verb, const sc_tissue *tissue)
{
    if (verb->kind == SC_VERB_APPEAR)
        return 1;
    if (verb->to_factor)
        return verb->to;
    return tissue->opacity > 0 ? verb->to / tissue->opacity : verb->to / tissue->interior_opacity;
}

/* Append what a verb does to each of its tissues, r->members [@p count]. @return SC_ERR_MEMORY. */
static sc_status add_fades(const sc_ctx *ctx, resolving *r, const sc_verb *verb, size_t count)
{
    const double stagger = verb->kind == SC_VERB_APPEAR ? verb->stagger : 0;
    const double each = (verb->end - verb->begin) / (1 + stagger * ((double)count - 1));

    for (size_t i = 0; i < count; i++) {
        const double begin = verb->begin + (double)i * stagger * each;

        SC_PASS(sc_changes_add(
            ctx,
            &(sc_change){.id = r->members[i].id,
                         .kind = verb->kind,
                         .begin = begin,
                         .end = i + 1 == count ? verb->end : fmin(begin + each, verb->end),
                         .ease = verb->ease,
                         .to = {factor_of(verb, &r->tissues[r->members[i].id]), 0, 0},
                         .times = verb->times,
                         .replaces = verb->kind != SC_VERB_APPEAR && !verb->to_factor &&
                                     r->tissues[r->members[i].id].opacity_track},
            &r->fades));
    }
    return SC_OK;
}

/* ---- lists of changes ---- */

static bool is_same_ease(const sc_ease *a, const sc_ease *b)
{
    bool same = a->kind == b->kind;

    for (size_t i = 0; i < SC_COUNT_OF(a->bezier); i++)
        same = same && fabs(a->bezier[i] - b->bezier[i]) < 1e-9;
    return same;
}

size_t sc_changes_of_first(const sc_change *changes, size_t count)
{
    size_t n = 1;

    while (n < count && changes[n].id == changes[0].id)
        n++;
    return n;
}

bool sc_changes_same(const sc_change *a, const sc_change *b, size_t count)
{
    bool same = true;

    for (size_t i = 0; i < count && same; i++) {
        same = a[i].kind == b[i].kind && a[i].times == b[i].times &&
               a[i].replaces == b[i].replaces && fabs(a[i].begin - b[i].begin) < 1e-9 &&
               fabs(a[i].end - b[i].end) < 1e-9 && is_same_ease(&a[i].ease, &b[i].ease) &&
               sc_vec3_length(sc_vec3_sub(a[i].to, b[i].to)) < 1e-9;
    }
    return same;
}

/* Does @p a come after @p b: by the tissue, then by when they begin? */
static bool comes_after(const sc_change *a, const sc_change *b)
{
    return a->id != b->id ? a->id > b->id : a->begin > b->begin;
}

sc_status sc_changes_add(const sc_ctx *ctx, const sc_change *change, sc_changes *out)
{
    SC_PASS(SC_GROW(ctx, out->count, &out->room, &out->all));
    out->all[out->count++] = *change;
    return SC_OK;
}

sc_status sc_changes_sort(const sc_ctx *ctx, sc_changes *changes)
{
    const size_t count = changes->count;
    sc_change *all = changes->all;
    SC_OWN(sc_free_at) sc_change *room = NULL;

    SC_PASS(SC_ALLOC(ctx, count, &room));
    for (size_t width = 1; width < count; width *= 2) { /* by merging */
        for (size_t low = 0; low < count; low += 2 * width) {
            const size_t middle = low + width < count ? low + width : count;
            const size_t high = middle + width < count ? middle + width : count;
            size_t left = low, right = middle;

            for (size_t to = low; to < high; to++)
                room[to] = right == high || (left < middle && !comes_after(&all[left], &all[right]))
                               ? all[left++]
                               : all[right++];
        }
        memcpy(all, room, count * sizeof *all);
    }
    return SC_OK;
}

/* ---- groups of tissues that fade alike ---- */

/* All that changes the opacity of one tissue, and how it compares with that of others. */
typedef struct track {
    int id;
    const sc_change *fades; /* [count] */
    size_t count;
    int numbers[2];          /* of the key frames of opacity and visibility; 0: none */
    const sc_track *keys[2]; /* these; NULL: none */
    double middle;           /* of the times of all of them: in its order tracks are put together */
} track;

/* Are the key frames the same, or are there none of both? */
static bool have_same_keys(const sc_track *a, const sc_track *b)
{
    bool same = (a != NULL) == (b != NULL) && (!a || a->count == b->count);

    for (int i = 0; a && same && i < a->count; i++)
        same = a->keys[i].at == b->keys[i].at && is_same_ease(&a->keys[i].ease, &b->keys[i].ease) &&
               a->keys[i].value.x == b->keys[i].value.x;
    return same;
}

/* Do the same to two tissues? */
static bool is_same(const track *a, const track *b)
{
    return a->count == b->count && have_same_keys(a->keys[0], b->keys[0]) &&
           have_same_keys(a->keys[1], b->keys[1]) && sc_changes_same(a->fades, b->fades, a->count);
}

static int compare_tracks(const void *a, const void *b)
{
    const track *left = a, *right = b;

    if (left->middle < right->middle || left->middle > right->middle)
        return left->middle < right->middle ? -1 : 1;
    for (int i = 0; i < 2; i++) { /* those of one rule stay side by side */
        if (left->numbers[i] != right->numbers[i])
            return left->numbers[i] < right->numbers[i] ? -1 : 1;
    }
    return (left->id > right->id) - (left->id < right->id);
}

const sc_track *sc_track_number(const sc_track *tracks, int number)
{
    return number && tracks ? &tracks[number - 1] : NULL;
}

/* @return the middle of the times at which something begins or ends to change a tissue. */
static double middle_of(const track *t)
{
    double sum = 0, count = (double)t->count;

    for (size_t i = 0; i < t->count; i++)
        sum += t->fades[i].begin + t->fades[i].end;
    for (int i = 0; i < 2; i++) {
        const sc_track *keys = t->keys[i];

        for (int j = 0; keys && j < keys->count; j++)
            sum += 2 * keys->keys[j].at;
        count += keys ? keys->count : 0;
    }
    return sum / count;
}

/* Find the tracks: one for each tissue whose opacity changes. @param fades [count]. @param tracks
 * room for [label_count]. @return how many there are. */
static size_t find_tracks(const resolving *r, const sc_change *fades, size_t count, track *tracks)
{
    size_t n = 0, i = 0;

    for (int id = 1; id < r->volume->label_count; id++) {
        const sc_tissue *tissue = &r->tissues[id];
        track t = {
            .id = id,
            .fades = count ? fades + i : NULL,
            .count = i < count && fades[i].id == id ? sc_changes_of_first(fades + i, count - i) : 0,
            .numbers = {tissue->opacity_track, tissue->visible_track}};

        i += t.count;
        for (int j = 0; j < 2; j++)
            t.keys[j] = sc_track_number(r->verbs->tracks, t.numbers[j]);
        if (!t.count && ((!t.keys[0] && !t.keys[1]) || !is_seen(tissue)))
            continue;
        t.middle = middle_of(&t);
        tracks[n++] = t;
    }
    return n;
}

/* Set fade_group of the tissues that fade: those that do so alike share one. Where there would be
 * more than SC_FADE_GROUPS_MAX, those that do so nearly at the same time do, too. @param tracks
 * room for [label_count]. */
static void set_groups(const resolving *r, track *tracks, sc_tissue *tissues)
{
    const size_t n = find_tracks(r, r->fades.all, r->fades.count, tracks);
    size_t kinds = 0, kind = 0;

    qsort(tracks, n, sizeof *tracks, compare_tracks);
    for (size_t i = 0; i < n; i++)
        kinds += i == 0 || !is_same(&tracks[i - 1], &tracks[i]);
    for (size_t i = 0; i < n; i++) {
        kind += i > 0 && !is_same(&tracks[i - 1], &tracks[i]);
        tissues[tracks[i].id].fade_group =
            (uint8_t)(1 + (kinds <= SC_FADE_GROUPS_MAX ? kind : kind * SC_FADE_GROUPS_MAX / kinds));
    }
}

/* ---- resolving ---- */

/* Append the fades of all verbs. @return the first mistake; all are logged. */
static sc_status resolve_all(const sc_ctx *ctx, resolving *r)
{
    sc_status status = SC_OK;

    for (size_t v = 0; v < r->verbs->verb_count; v++) {
        const sc_verb *verb = &r->verbs->verbs[v];
        const bool needs_tissues = !sc_verb_is_move(verb->kind) || verb->kind == SC_VERB_FRAME;
        const size_t members = needs_tissues ? find_members(r, v) : 0;

        if (needs_tissues && !members)
            status = sc_fail(ctx, SC_ERR_DATA,
                             "%s%sno tissue of this verb is shown, by the label table or the "
                             "tissues of the job; expected one that is%s",
                             verb->where, verb->where[0] ? ": " : "",
                             sc_verb_fades(verb->kind) ? ": a verb multiplies its opacity" : "");
        else if (sc_verb_fades(verb->kind) && add_fades(ctx, r, verb, members) != SC_OK)
            return SC_ERR_MEMORY;
    }
    return status;
}

sc_status sc_verbs_resolve(const sc_ctx *ctx, const sc_prepared *volume, sc_tissue *tissues,
                           const sc_verbs *verbs, sc_change **out, size_t *count)
{
    const size_t labels = (size_t)volume->label_count;
    SC_OWN(clear_resolving)
    resolving r = {.volume = volume, .tissues = tissues, .verbs = verbs};
    SC_OWN(sc_free_at) track *tracks = NULL;

    for (int id = 0; id < volume->label_count; id++)
        tissues[id].fade_group = 0;
    SC_PASS(SC_ALLOC(ctx, labels, &r.taken));
    SC_PASS(SC_ALLOC(ctx, labels, &r.members));
    SC_PASS(SC_ALLOC(ctx, labels, &tracks));
    SC_PASS(resolve_all(ctx, &r));
    SC_PASS(sc_changes_sort(ctx, &r.fades));
    set_groups(&r, tracks, tissues);
    *count = r.fades.count;
    SC_HAND_OVER(r.fades.all, out);
    return SC_OK;
}

/* ---- frames ---- */

/* @return how far a pulse has gone to its end and come back, 0 to 1. */
static double pulse_at(const sc_change *fade, double at)
{
    const double beats =
        fade->times * sc_progress(fade->begin, fade->end, (sc_ease){.kind = SC_EASE_LINEAR}, at);
    const double beat = beats - floor(beats);

    return sc_ease_value(fade->ease, beat < 0.5 ? 2 * beat : 2 - 2 * beat);
}

/* @return the opacity of a tissue, which without verbs is @p own at that time. Fades leave a share
 * of it, and put an opacity in the place of the rest. Pulses multiply both, and those to an opacity
 * reach that, as far as fades leave the tissue there. @param greatest of its key frames, above 0.
 * @param fades [count] all of the tissue. */
static double opacity_at(double own, double greatest, const sc_change *fades, size_t count,
                         double at)
{
    double share = 1, put = 0, beaten = 1, beats = 0;
    bool first = true;

    for (size_t i = 0; i < count; i++) {
        const sc_change *f = &fades[i];
        const double to_share = f->replaces ? 0 : f->to.x;
        const double to_put = f->replaces ? f->to.x * greatest : 0;
        double done;

        if (f->kind == SC_VERB_PULSE) {
            done = pulse_at(f, at);
            beats =
                beats * (1 + (to_share - 1) * done) + to_put * done * (beaten + beats / greatest);
            beaten *= 1 + (to_share - 1) * done;
            continue;
        }
        if (first && f->kind == SC_VERB_APPEAR)
            share = 0;
        first = false;
        done = sc_progress(f->begin, f->end, f->ease, at);
        share += (to_share - share) * done;
        put += (to_put - put) * done;
    }
    return (share * own + put) * beaten + (share + put / greatest) * beats;
}

/* @return what the opacity of a tissue is multiplied by. @param fades [count] all of it. */
static double factor_of_tissue(const sc_looks *looks, int id, const sc_change *fades, size_t count,
                               double at)
{
    const sc_tissue *tissue = &looks->tissues[id];
    const sc_track *key = sc_track_number(looks->tissue_tracks, tissue->opacity_track);
    const sc_track *visible = sc_track_number(looks->tissue_tracks, tissue->visible_track);
    const double greatest = key ? tissue->opacity : 1;
    const double own = key ? sc_track_value(key, at).x : 1;
    const double factor = opacity_at(own, greatest, fades, count, at) / greatest;

    return factor < LEAST_FACTOR || (visible && !(sc_track_step(visible, at).x > 0)) ? 0 : factor;
}

void sc_fades_at(const sc_looks *looks, double time, float *out)
{
    size_t at = 0;

    for (int id = 0; id < looks->label_count; id++) {
        size_t count = 0;

        while (at + count < looks->fade_count && looks->fades[at + count].id == id)
            count++;
        out[id] = (float)factor_of_tissue(looks, id, count ? looks->fades + at : NULL, count, time);
        at += count;
    }
}
