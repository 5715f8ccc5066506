/* SPDX-License-Identifier: BSD-3-Clause */
/* Which tissues a film shows, how much of each in a frame, and what they are called. */
#include "internal.h"

#include <math.h>
#include <string.h>

#define CUT_FADE 0.05 /* share of a tissue's extent that is left when it begins to fade */

/* @return how far one clip plane has left a tissue: 1 if much of it, 0 if nothing. */
static double share_kept(const sc_prepared *volume, int id, const sc_plane *plane)
{
    const sc_label_stats *s = &volume->stats[id];
    double most = -HUGE_VAL, least = HUGE_VAL;

    for (int corner = 0; corner < 8; corner++) {
        double at[3], distance;

        for (int i = 0; i < 3; i++)
            at[i] = corner >> i & 1 ? s->high[i] + 0.5 : s->low[i] - 0.5;
        distance = sc_vec3_dot(plane->normal, sc_affine_point(&volume->to_ras_mm,
                                                              (sc_vec3){at[0], at[1], at[2]})) +
                   plane->offset_mm;
        most = fmax(most, distance);
        least = fmin(least, distance);
    }
    return fmin(1, fmax(0, most / fmax(CUT_FADE * (most - least), 1e-9)));
}

/* @return how much of a tissue the clip planes of a scene have left, as of share_kept. */
static double share_uncut(const sc_annotations *a, const sc_scene *scene, int id)
{
    const uint32_t planes = scene->clip_sets[a->tissues[id].clip_set];
    const bool keeps = scene->clip_mode == SC_CLIP_KEEP;
    double out = keeps || !planes ? 1 : 0;

    for (int i = 0; i < scene->plane_count; i++) {
        const double kept = planes >> i & 1 ? share_kept(a->volume, id, &scene->planes[i]) : out;

        out = keeps ? fmin(out, kept) : fmax(out, kept);
    }
    return out;
}

int sc_shown_alpha(const sc_annotations *a, const sc_scene *scene, int id)
{
    const double fade = scene->fades ? fmin(1, (double)scene->fades[id]) : 1;

    return (int)(255 * fade * share_uncut(a, scene, id) + 0.5);
}

bool sc_is_in_film(const sc_annotations *a, int id)
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

/* Sort @p ids [count]. */
static void sort_ids(int *ids, int count)
{
    for (int i = 1; i < count; i++) {
        const int id = ids[i];
        int j = i;

        for (; j > 0 && ids[j - 1] > id; j--)
            ids[j] = ids[j - 1];
        ids[j] = id;
    }
}

int sc_choose_tissues(const sc_annotations *a, int room, int *ids)
{
    int all = 0, count = 0;

    for (int id = 1; id < a->volume->label_count; id++)
        all += sc_is_in_film(a, id);
    while (count < room && count < all) {
        int best = 0;

        for (int id = 1; id < a->volume->label_count; id++) {
            if (sc_is_in_film(a, id) && (!count || is_before(a->volume, ids[count - 1], id)) &&
                (!best || is_before(a->volume, id, best)))
                best = id;
        }
        ids[count++] = best;
    }
    sort_ids(ids, count);
    return all;
}

sc_status sc_name_of(const sc_ctx *ctx, const sc_annotations *a, int id, sc_line_list *list,
                     const char **out)
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
                "the name of tissue \"%s\" (label %lld) cannot be written onto pictures: "
                "U+%04X %s; give it another name in a label table (labels), or leave out "
                "overlays.legend",
                label->name, (long long)label->value,
                sc_utf8_code(label->name + at, bytes ? bytes : 1), why);
    }
    if (!label->name[0])
        snprintf(name, sizeof name, "label %lld", (long long)label->value);
    else
        snprintf(name, sizeof name, "%s", label->name);
    for (char *c = name; *c; c++)
        *c = (char)(*c == '_' ? ' ' : *c);
    return sc_keep_text(ctx, list, name, out);
}
