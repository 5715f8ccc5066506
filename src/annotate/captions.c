/* SPDX-License-Identifier: BSD-3-Clause */
/* Captions: broken into lines before the film, by one process; drawn in their part of it. */
#include "internal.h"

#include <math.h>

#define SIZE 1.25        /* of the font, times that of other text */
#define SMALLEST 0.6     /* what a long caption's font may shrink to, as a share of SIZE */
#define MIDDLE_WIDTH 0.9 /* of the picture: the most that a caption in the middle takes */
#define CORNER_WIDTH 0.4
#define BESIDE_WIDTH 0.55 /* ... in the middle between what stands in the corners */
#define HEIGHT 0.4        /* of the picture: the most that a caption takes */

bool sc_caption_is_shown(const sc_caption *caption, double at)
{
    return at >= caption->begin && at < caption->end;
}

/* @return whether something else stands in a corner of the same edge as @p place. */
static bool has_neighbours(const sc_annotations *a, int place)
{
    const int left = place <= SC_PLACE_TOP_RIGHT ? SC_PLACE_TOP_LEFT : SC_PLACE_BOTTOM_LEFT;
    const sc_overlays *o = a->overlays;
    const int places[] = {o->time,        o->scale_bar, o->color_bar,
                          o->orientation, o->legend,    o->logo[0] ? o->logo_place : SC_PLACE_NONE};

    for (size_t i = 0; i < SC_COUNT_OF(places); i++) {
        if (places[i] == left || places[i] == left + 2)
            return true;
    }
    return sc_annotations_names(a);
}

/* @return the width, in pixels, that a caption at this place may take. */
static double width_at(const sc_annotations *a, int place)
{
    const bool is_middle = place == SC_PLACE_TOP || place == SC_PLACE_BOTTOM;

    return a->within.width_px * (!is_middle                 ? CORNER_WIDTH
                                 : has_neighbours(a, place) ? BESIDE_WIDTH
                                                            : MIDDLE_WIDTH);
}

/* @return how many bytes of @p text belong to its first line, which ends at a line break, before a
 * blank, or, if its first word is wider than @p width, within the word. */
static size_t line_bytes(sc_font *font, const char *text, double size_px, double width)
{
    size_t at = 0, blank = 0;

    while (text[at] && text[at] != '\n') {
        const size_t bytes = sc_utf8_bytes(text + at);
        const size_t next = at + (bytes ? bytes : 1);

        if (text[at] == ' ')
            blank = at;
        else if (at > 0 && sc_font_width_px(font, text, next, size_px) > width)
            return blank > 0 ? blank : at;
        at = next;
    }
    return at;
}

int sc_break_lines(const char *text, sc_font *font, double size_px, double width, int room,
                   sc_text_line *out)
{
    int count = 0;

    while (*text && count <= room) {
        const size_t bytes = line_bytes(font, text, size_px, width);

        if (count < room)
            out[count] = (sc_text_line){.text = text, .bytes = bytes, .size_px = size_px};
        count++;
        text += bytes;
        text += *text == '\n' ? 1 : strspn(text, " ");
    }
    return count;
}

/* Append lines of the caption @p index. */
static sc_status add_lines(const sc_ctx *ctx, int index, sc_text_line *lines, int count,
                           sc_line_list *list)
{
    for (int i = 0; i < count; i++) {
        lines[i].kind = SC_WORD_CAPTION;
        lines[i].number = index * SC_CAPTION_LINES_MAX + i;
        SC_PASS(sc_add_line(ctx, list, &lines[i]));
    }
    return SC_OK;
}

/* @return how high the lines of a caption may be in all. */
static double highest_px(const sc_annotations *a, double size_px)
{
    return fmax(HEIGHT * a->within.height_px, 1.3 * size_px);
}

/* Append as many lines of a caption as fit, at least one. */
static sc_status add_beginning(const sc_ctx *ctx, const sc_annotations *a, int index, sc_font *font,
                               double size_px, sc_line_list *list)
{
    const sc_caption *caption = &a->lists.captions[index];
    const int fit = (int)(highest_px(a, size_px) / ceil(1.3 * size_px));
    const int room = fit < 1 ? 1 : fit < SC_CAPTION_LINES_MAX ? fit : SC_CAPTION_LINES_MAX;
    sc_text_line lines[SC_CAPTION_LINES_MAX];
    const int count =
        sc_break_lines(caption->text, font, size_px, width_at(a, caption->place), room, lines);

    return add_lines(ctx, index, lines, count < room ? count : room, list);
}

/* Append the lines of a caption, in the largest font size in which it fits. */
static sc_status add_caption(const sc_ctx *ctx, const sc_annotations *a, int index, sc_font *font,
                             sc_line_list *list)
{
    const sc_caption *caption = &a->lists.captions[index];
    const double full_px = SIZE * sc_text_px(a), least_px = SMALLEST * full_px;
    double size_px = full_px;
    const double width = width_at(a, caption->place);
    sc_text_line lines[SC_CAPTION_LINES_MAX];

    do {
        const int count =
            sc_break_lines(caption->text, font, size_px, width, SC_CAPTION_LINES_MAX, lines);

        if (count <= SC_CAPTION_LINES_MAX && count * ceil(1.3 * size_px) <= highest_px(a, size_px))
            return add_lines(ctx, index, lines, count, list);
        size_px *= 0.93;
    } while (size_px >= least_px);
    if (caption->may_be_cut)
        return add_beginning(ctx, a, index, font, least_px, list);
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s%sa caption of %zu bytes does not fit into a picture of %d x %d pixels: "
                   "expected at most %d lines that fill %g%% of its height; shorten it, or make "
                   "overlays.text_size smaller",
                   caption->where, caption->where[0] ? ": " : "", strlen(caption->text),
                   a->within.width_px, a->within.height_px, SC_CAPTION_LINES_MAX, 100 * HEIGHT);
}

sc_status sc_add_captions(const sc_ctx *ctx, const sc_annotations *a, sc_font *font,
                          sc_line_list *list)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < a->lists.caption_count; i++) {
        const sc_status one = add_caption(ctx, a, (int)i, font, list);

        if (one != SC_OK && one != SC_ERR_DATA)
            return one;
        status = status == SC_OK ? one : status;
    }
    return status;
}

/* Draw a caption, whose lines stand below one another, aligned as its place is. */
static void draw_caption(sc_drawing *d, int index)
{
    const sc_lettering *lettering = d->a->lettering;
    const int place = d->a->lists.captions[index].place, column = (place - SC_PLACE_TOP_LEFT) % 3;
    const sc_word *words[SC_CAPTION_LINES_MAX];
    int count = 0, width = 0;
    sc_viewport room;

    for (; count < SC_CAPTION_LINES_MAX; count++) {
        const sc_word *word =
            sc_lettering_find(lettering, SC_WORD_CAPTION, index * SC_CAPTION_LINES_MAX + count);

        if (!word)
            break;
        words[count] = word;
        width = word->advance_px > width ? word->advance_px : width;
    }
    if (!count)
        return;
    room = sc_take_room(d, place, width, words[0]->capitals_px + (count - 1) * words[0]->line_px);
    for (int i = 0; i < count; i++)
        sc_lettering_draw(lettering, words[i],
                          room.x_px + (width - words[i]->advance_px) * column / 2,
                          room.y_px + words[i]->capitals_px + i * words[i]->line_px, &d->letters,
                          255, d->image, d->rows);
}

void sc_draw_captions(sc_drawing *d, double at)
{
    for (size_t i = 0; i < d->a->lists.caption_count; i++) {
        if (sc_caption_is_shown(&d->a->lists.captions[i], at))
            draw_caption(d, (int)i);
    }
}
