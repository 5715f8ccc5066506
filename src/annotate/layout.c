/* SPDX-License-Identifier: BSD-3-Clause */
/* Where overlays lie, and text that changes from frame to frame. */
#include "internal.h"

#include <math.h>

enum { TEXT_LEAST_PX = 9 };

double sc_text_px(const sc_annotations *a)
{
    return fmax(TEXT_LEAST_PX, a->overlays->text_percent / 100 * a->within.height_px);
}

int sc_margin_px(const sc_annotations *a)
{
    return (int)(0.8 * sc_text_px(a) + 0.5);
}

sc_drawing sc_drawing_begin(const sc_annotations *a, const sc_scene *scene, sc_image *image,
                            const sc_rows *rows)
{
    sc_drawing d = {.a = a, .image = image, .rows = rows, .margin_px = sc_margin_px(a)};

    sc_text_colors(scene->dark_text, d.letters.rgb, d.letters.halo);
    return d;
}

void sc_hold(sc_viewport *around, const sc_viewport *other)
{
    const sc_viewport a = *around;
    const int right = a.x_px + a.width_px, other_right = other->x_px + other->width_px;
    const int bottom = a.y_px + a.height_px, other_bottom = other->y_px + other->height_px;

    if (!other->width_px)
        return;
    if (!a.width_px) {
        *around = *other;
        return;
    }
    around->x_px = a.x_px < other->x_px ? a.x_px : other->x_px;
    around->y_px = a.y_px < other->y_px ? a.y_px : other->y_px;
    around->width_px = (right > other_right ? right : other_right) - around->x_px;
    around->height_px = (bottom > other_bottom ? bottom : other_bottom) - around->y_px;
}

sc_viewport sc_take_room(sc_drawing *d, int place, int width_px, int height_px)
{
    const sc_viewport *within = &d->a->within;
    const bool is_top = place <= SC_PLACE_TOP_RIGHT;
    const int column = (place - SC_PLACE_TOP_LEFT) % 3;
    const int right = within->x_px + within->width_px - d->margin_px - width_px;
    const int edge = d->margin_px + d->used_px[place];
    sc_viewport out = {.width_px = width_px, .height_px = height_px};

    out.x_px = column == 0   ? within->x_px + d->margin_px
               : column == 1 ? within->x_px + (within->width_px - width_px) / 2
                             : right;
    out.y_px = is_top ? within->y_px + edge : within->y_px + within->height_px - edge - height_px;
    d->used_px[place] += height_px + d->margin_px;
    sc_hold(&d->taken[place], &out);
    return out;
}

/* @return the width of the cell in which a digit stands: that of the widest. */
static int digit_px(const sc_lettering *lettering)
{
    int widest = 0;

    for (int digit = '0'; digit <= '9'; digit++) {
        const sc_word *word = sc_lettering_find(lettering, SC_WORD_GLYPH, digit);

        if (word && word->advance_px > widest)
            widest = word->advance_px;
    }
    return widest;
}

/* Find a glyph and the width of its cell. @return NULL if the lettering lacks it. */
static const sc_word *find_glyph(const sc_lettering *lettering, char c, int *cell_px)
{
    const sc_word *word = sc_lettering_find(lettering, SC_WORD_GLYPH, c);

    *cell_px = !word ? 0 : c >= '0' && c <= '9' ? digit_px(lettering) : word->advance_px;
    return word;
}

int sc_glyphs_width(const sc_lettering *lettering, const char *text)
{
    int width = 0, cell;

    for (; *text; text++) {
        (void)find_glyph(lettering, *text, &cell);
        width += cell;
    }
    return width;
}

void sc_draw_glyphs(const sc_drawing *d, const char *text, int x, int y)
{
    int cell;

    for (; *text; text++, x += cell) {
        const sc_word *word = find_glyph(d->a->lettering, *text, &cell);

        if (word)
            sc_lettering_draw(d->a->lettering, word, x + (cell - word->advance_px) / 2, y,
                              &d->letters, 255, d->image, d->rows);
    }
}

int sc_glyphs_capitals(const sc_lettering *lettering)
{
    const sc_word *word = sc_lettering_find(lettering, SC_WORD_GLYPH, '0');

    return word ? word->capitals_px : 0;
}
