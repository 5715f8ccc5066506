/* SPDX-License-Identifier: BSD-3-Clause */
/* Which tissues a film shows, how much of each in a frame, and what they are called. */
#include "internal.h"

#include <math.h>

#define CUT_FADE 0.05 /* share of a tissue's extent that is left when it begins to fade */

/* @return how far one clip plane has left a tissue: 1 if much of it, 0 if nothing. */
static double share_kept(const sc_prepared *volume, int id, const sc_plane *plane)
{
    double most = -HUGE_VAL, least = HUGE_VAL;

    for (int corner = 0; corner < 8; corner++) {
        const double distance =
            sc_vec3_dot(plane->normal, sc_tissue_corner(volume, id, corner)) + plane->offset_mm;

        most = fmax(most, distance);
        least = fmin(least, distance);
    }
    return fmin(1, fmax(0, most / fmax(CUT_FADE * (most - least), 1e-9)));
}

/* @return how much of a tissue the clip planes of a scene have left, as of share_kept. */
static double share_uncut(const sc_annotations *a, const sc_scene *scene, int id)
{
    const uint32_t planes = scene->clip.sets[a->tissues[id].clip_set];
    const bool keeps = scene->clip.mode == SC_CLIP_KEEP;
    double out = keeps || !planes ? 1 : 0;

    for (int i = 0; i < scene->clip.count; i++) {
        const double kept =
            planes >> i & 1 ? share_kept(a->volume, id, &scene->clip.planes[i]) : out;

        out = keeps ? fmin(out, kept) : fmax(out, kept);
    }
    return out;
}

int sc_shown_alpha(const sc_annotations *a, const sc_scene *scene, int id)
{
    const double fade = scene->fades ? fmin(1, (double)scene->fades[id]) : 1;

    return (int)(255 * fade * share_uncut(a, scene, id) + 0.5);
}

/* @return whether a tissue can be seen in the film at all. */
static bool is_in_film(const sc_annotations *a, int id)
{
    const sc_tissue *t = &a->tissues[id];

    return t->visible && (t->opacity + t->interior_opacity > 0 || t->opacity_auto) &&
           a->volume->stats[id].low[0] <= a->volume->stats[id].high[0];
}

/* @return whether tissue @p a stands before @p b among the largest. */
static bool is_before(const sc_prepared *volume, int a, int b)
{
    const uint64_t first = volume->stats[a].voxels, second = volume->stats[b].voxels;

    return first > second || (first == second && a < b);
}

bool sc_annotations_names(const sc_annotations *annotations)
{
    for (size_t i = 0; i < annotations->lists.tissue_count; i++) {
        if (annotations->lists.tissues[i].of == SC_USE_NAMES)
            return true;
    }
    return false;
}

/* Find the tissues that are chosen for an overlay and are seen in the film.
 * @param is_wanted [label_count], all false. @return how many there are. */
static int find_wanted(const sc_annotations *a, sc_tissue_use use, bool *is_wanted)
{
    const sc_prepared *volume = a->volume;
    bool is_listed = false;
    int count = 0;

    for (size_t i = 0; i < a->lists.tissue_count; i++) {
        const sc_pattern pattern = sc_pattern_of(a->lists.tissues[i].pattern);
        const sc_match best = sc_pattern_match(volume->labels, volume->label_count, &pattern);

        if (a->lists.tissues[i].of != (int)use)
            continue;
        is_listed = true;
        for (int id = 1; id < volume->label_count && best != SC_MATCH_NONE; id++)
            is_wanted[id] = is_wanted[id] || sc_label_match(&volume->labels[id], &pattern) == best;
    }
    for (int id = 1; id < volume->label_count; id++) {
        is_wanted[id] =
            (is_wanted[id] || (!is_listed && use == SC_USE_LEGEND)) && is_in_film(a, id);
        count += is_wanted[id];
    }
    return count;
}

sc_status sc_choose_tissues(const sc_ctx *ctx, const sc_annotations *a, sc_tissue_use use, int room,
                            int *ids, int *all)
{
    SC_OWN(sc_free_at) bool *is_wanted = NULL;

    SC_PASS(SC_ZALLOC(ctx, (size_t)a->volume->label_count, &is_wanted));
    *all = find_wanted(a, use, is_wanted);
    for (int count = 0; count < room && count < *all; count++) {
        int best = 0;

        for (int id = 1; id < a->volume->label_count; id++) {
            if (is_wanted[id] && (!best || is_before(a->volume, id, best)))
                best = id;
        }
        is_wanted[best] = false;
        ids[count] = best;
    }
    return SC_OK;
}

sc_status sc_name_of(const sc_ctx *ctx, const sc_annotations *a, int id, const char *key,
                     sc_line_list *list, const char **out)
{
    const sc_label *label = &a->volume->labels[id];
    char name[SC_NAME_BYTES];

    for (size_t at = 0, bytes; label->name[at]; at += bytes ? bytes : 1) {
        const char *why;

        bytes = sc_utf8_bytes(label->name + at);
        why = sc_font_refuses(sc_utf8_code(label->name + at, bytes ? bytes : 1));
        if (why)
            return sc_fail(
                ctx, SC_ERR_DATA,
                "the name of tissue \"%s\" (label %lld) cannot be written onto pictures: U+%04X "
                "%s; give it another name in a label table (labels), or leave out %s",
                label->name, (long long)label->value,
                sc_utf8_code(label->name + at, bytes ? bytes : 1), why, key);
    }
    if (!label->name[0])
        snprintf(name, sizeof name, "label %lld", (long long)label->value);
    else
        snprintf(name, sizeof name, "%s", label->name);
    for (char *c = name; *c; c++)
        *c = (char)(*c == '_' ? ' ' : *c);
    return sc_keep_text(ctx, list, name, out);
}
