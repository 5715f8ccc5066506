/* SPDX-License-Identifier: BSD-3-Clause */
/* Title cards: a title and what stands below it, in the middle of the picture. */
#include "internal.h"

#include <math.h>

/* Shares of the height of the picture. */
#define TITLE 0.1     /* font size */
#define SUBTITLE 0.05 /* likewise */
#define HEIGHT 0.8    /* the most that all lines take */
#define WIDTH 0.86    /* of its width: the most that a line takes */
#define SMALLEST 0.3  /* what both sizes may shrink to, as a share of themselves */

enum { LINES = 2 * SC_CAPTION_LINES_MAX, LEAST_PX = 9 };

/* Break title and subtitle into lines, with the distance of each from the one above as data.
 * @param scale of their font sizes. @param out [LINES]. @return how many there are, 0 if they do
 * not fit. */
static int layout(const sc_annotations *a, sc_font *font, double scale, sc_text_line *out)
{
    const double height = a->within.height_px, width = WIDTH * a->within.width_px;
    const double title_px = fmax(LEAST_PX, scale * TITLE * height);
    const double subtitle_px = fmax(LEAST_PX, scale * SUBTITLE * height);
    const int titles = sc_break_lines(a->card->title, font, title_px, width, LINES / 2, out);
    double all_px = 0;
    int count = titles;

    if (titles > LINES / 2)
        return 0;
    if (a->card->has_subtitle)
        count +=
            sc_break_lines(a->card->subtitle, font, subtitle_px, width, LINES / 2, out + titles);
    if (count - titles > LINES / 2)
        return 0;
    for (int i = 0; i < count; i++) {
        if (sc_font_width_px(font, out[i].text, out[i].bytes, out[i].size_px) > width)
            return 0;
        out[i].kind = SC_WORD_CARD;
        out[i].number = i;
        out[i].data = (int32_t)ceil((i == titles ? 2 : 1.3) * out[i].size_px);
        all_px += out[i].data;
    }
    return all_px <= HEIGHT * height ? count : 0;
}

sc_status sc_add_card(const sc_ctx *ctx, const sc_annotations *a, sc_font *font, sc_line_list *list)
{
    sc_text_line lines[LINES];
    int count = 0;

    for (double scale = 1; scale >= SMALLEST && !count; scale *= 0.93)
        count = layout(a, font, scale, lines);
    if (!count)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s%sthe text of the title card does not fit into a picture of %d x %d "
                       "pixels; expected lines that fill at most %g%% of its height; shorten it",
                       a->card->where, a->card->where[0] ? ": " : "", a->within.width_px,
                       a->within.height_px, 100 * HEIGHT);
    for (int i = 0; i < count; i++)
        SC_PASS(sc_add_line(ctx, list, &lines[i]));
    return SC_OK;
}

void sc_draw_card(sc_drawing *d)
{
    const sc_lettering *lettering = d->a->lettering;
    const sc_viewport *within = &d->a->within;
    const sc_word *word = sc_lettering_find(lettering, SC_WORD_CARD, 0);
    int height = word ? word->capitals_px : 0, y;

    if (!d->a->card)
        return;
    for (int i = 1; (word = sc_lettering_find(lettering, SC_WORD_CARD, i)) != NULL; i++)
        height += word->data;
    y = within->y_px + (within->height_px - height) / 2;
    for (int i = 0; (word = sc_lettering_find(lettering, SC_WORD_CARD, i)) != NULL; i++) {
        y += i ? word->data : word->capitals_px;
        sc_lettering_draw(lettering, word, within->x_px + (within->width_px - word->advance_px) / 2,
                          y, &d->letters, 255, d->image, d->rows);
    }
}
