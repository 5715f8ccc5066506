/* SPDX-License-Identifier: BSD-3-Clause */
/* Names beside the tissues: their text, and how they are drawn with their leader lines. */
#include "internal.h"

#include <math.h>

#define WIDEST 0.26    /* share of the picture that a name may fill */
#define LINE 0.075     /* width of a leader line, in font sizes */
#define HALO 0.085     /* ... of its halo, on each side */
#define DOT 0.19       /* radius of the dot at its end */
#define GAP 0.35       /* between a line and its name */
#define HALO_ALPHA 0.7 /* as opaque as the line, times this */
enum { LEAST_PX = 8 }; /* the smallest font */

double sc_names_px(const sc_annotations *a)
{
    return fmax(LEAST_PX, a->overlays->names_percent / 100 * a->within.height_px);
}

sc_status sc_add_names(const sc_ctx *ctx, const sc_annotations *a, sc_font *font,
                       sc_line_list *list)
{
    const double rows = 2 * floor(a->within.height_px / (1.2 * sc_names_px(a)));
    const int room = rows < SC_NAMES_MAX ? (int)rows : SC_NAMES_MAX;
    sc_text_line line = {.kind = SC_WORD_NAME, .size_px = sc_names_px(a)};
    SC_OWN(sc_text_clear) sc_text text = {0};
    int ids[SC_NAMES_MAX], all;

    SC_PASS(sc_choose_tissues(ctx, a, SC_USE_NAMES, room, ids, &all));
    for (int i = 0; i < room && i < all; i++) {
        line.number = ids[i];
        SC_PASS(sc_name_of(ctx, a, ids[i], "overlays.names", list, &line.text));
        line.bytes = strlen(line.text);
        SC_PASS(sc_add_cut_line(ctx, font, WIDEST * a->within.width_px, &text, &line, list));
    }
    if (all > room)
        sc_warn(ctx,
                "overlays.names: there is room for the names of %d tissues; those of the %d "
                "smallest of %d are left out",
                room, all - room, all);
    return SC_OK;
}

/* A leader line, from the dot to the name. */
typedef struct leader {
    double points[3][2];
    double alpha; /* 0 to 1 */
    double size_px;
} leader;

/* Draw the part of a leader line, or of its halo, that lies in a rectangle. */
static sc_status draw_part(const sc_ctx *ctx, const sc_drawing *d, const leader *l, bool halo,
                           const sc_viewport *part)
{
    const uint8_t *rgb = halo ? d->letters.halo : d->letters.rgb;
    const double alpha = halo ? HALO_ALPHA * l->alpha : l->alpha;
    const double around_px = halo ? HALO * l->size_px : 0;
    const double width_px = fmax(1, LINE * l->size_px) + 2 * around_px;
    sc_overlay *overlay;

    if (part->width_px <= 0 || part->height_px <= 0)
        return SC_OK;
    SC_PASS(sc_overlay_begin_within(ctx, d->image, part, d->rows, &overlay));
    sc_overlay_leader(overlay, (const double(*)[2])l->points, 3, width_px,
                      DOT * l->size_px + around_px, rgb, alpha);
    return sc_overlay_finish(ctx, overlay);
}

/* Draw a leader line or its halo: in two rectangles, because that around the whole line is far
 * larger than they are. */
static sc_status draw_leader(const sc_ctx *ctx, const sc_drawing *d, const leader *l, bool halo)
{
    const int around = (int)ceil((DOT + HALO) * l->size_px) + 1;
    const double(*p)[2] = (const double(*)[2])l->points;
    const bool is_right = p[1][0] >= p[0][0];
    const int dot = (int)floor(p[0][0]), elbow = (int)floor(p[1][0]), end = (int)floor(p[2][0]);
    const int row = (int)floor(p[0][1]), top = (int)floor(fmin(p[1][1], p[2][1])) - around;
    const int bottom = (int)floor(fmax(p[1][1], p[2][1])) + around;
    const sc_viewport level = {is_right ? dot - around : elbow, row - around,
                               (is_right ? elbow - dot : dot - elbow) + around, 2 * around};
    const sc_viewport turn = {is_right ? elbow : end - around, top,
                              (is_right ? end - elbow : elbow - end) + around, bottom - top};

    SC_PASS(draw_part(ctx, d, l, halo, &level));
    return draw_part(ctx, d, l, halo, &turn);
}

/* @return the leader line of a name. */
static leader leader_of(const sc_annotations *a, const sc_name_place *place)
{
    const double size_px = sc_names_px(a), gap_px = place->is_right ? -GAP : GAP;

    return (leader){
        .points = {{(double)place->dot_px[0], (double)place->dot_px[1]},
                   {(double)place->elbow_px, (double)place->dot_px[1]},
                   {(double)place->label_px[0] + gap_px * size_px, (double)place->label_px[1]}},
        .alpha = place->alpha / 255.0,
        .size_px = size_px};
}

/* Draw a name. */
static void draw_name(const sc_drawing *d, const sc_word *word, const sc_name_place *place)
{
    const double x = (double)place->label_px[0] - (place->is_right ? 0 : word->advance_px);
    const double y = (double)place->label_px[1] + word->capitals_px / 2.0;

    sc_lettering_draw(d->a->lettering, word, (int)floor(x + 0.5), (int)floor(y + 0.5), &d->letters,
                      place->alpha, d->image, d->rows);
}

sc_status sc_draw_names(const sc_ctx *ctx, sc_drawing *d, const sc_scene *scene)
{
    const sc_lettering *lettering = d->a->lettering;
    const sc_name_plan *plan = d->a->names;
    const int k = scene->frame;

    if (!plan || k >= plan->frames)
        return SC_OK;
    for (int layer = 0; layer < 3; layer++) { /* halos, lines, names */
        int n = 0;

        for (uint64_t i = 0; i < lettering->count; i++) {
            const sc_word *word = &lettering->words[i];
            const sc_name_place *place;
            leader l;

            if (word->kind != SC_WORD_NAME || n == plan->count)
                continue;
            place = &plan->places[(size_t)k * (size_t)plan->count + (size_t)n++];
            if (!place->alpha)
                continue;
            l = leader_of(d->a, place);
            if (layer < 2)
                SC_PASS(draw_leader(ctx, d, &l, !layer));
            else
                draw_name(d, word, place);
        }
    }
    return SC_OK;
}
