/* SPDX-License-Identifier: BSD-3-Clause */
/* The colour bar: which colours stand for which values, the same in all frames. */
#include "internal.h"

#include <math.h>

#define SIZE 0.85    /* of the font, times that of other text */
#define SMALLEST 0.6 /* what the font of a long title may shrink to, as a share of SIZE */
#define BAR 0.22     /* shares of the width of the picture: of the bar */
#define WIDEST 0.4   /* ... and the most of its title */
enum {
    LEAST_PX = 8, /* the smallest font */
    DIGITS = 9,   /* the most of a value */
    VALUE_BYTES = 72
};

/* Append a text. */
static sc_status add_text(const sc_ctx *ctx, int number, const char *text, double size_px,
                          sc_line_list *list)
{
    sc_text_line line = {.kind = SC_WORD_COLOR_BAR, .number = number, .size_px = size_px};

    SC_PASS(sc_keep_text(ctx, list, text, &line.text));
    line.bytes = strlen(line.text);
    return sc_add_line(ctx, list, &line);
}

/* Write a value with so many digits. */
static void print_value(double value, int digits, char text[VALUE_BYTES])
{
    const bool whole = fabs(value) >= 1e3 && fabs(value) < 1e7 && digits <= 3;
    char plain[VALUE_BYTES / 3];
    size_t used = 0;

    if (whole)
        snprintf(plain, sizeof plain, "%.0f", value);
    else
        snprintf(plain, sizeof plain, "%.*g", digits, value);
    text[0] = '\0';
    for (const char *c = plain; *c; c++) /* U+2212, the minus sign, is as wide as the digits */
        used += (size_t)snprintf(text + used, VALUE_BYTES - used, "%.*s", *c == '-' ? 3 : 1,
                                 *c == '-' ? "\xe2\x88\x92" : c);
}

/* Append the values of the ends and of the middle of the bar, with three digits, or as many more as
 * tell them from each other. */
static sc_status add_values(const sc_ctx *ctx, const sc_color_scale *scale, double size_px,
                            sc_line_list *list)
{
    const double values[] = {scale->low, scale->low / 2 + scale->high / 2, scale->high};
    char texts[3][VALUE_BYTES];
    int digits = 3;

    do {
        for (int i = 0; i < 3; i++)
            print_value(values[i], digits, texts[i]);
    } while ((!strcmp(texts[0], texts[1]) || !strcmp(texts[1], texts[2])) && digits++ < DIGITS);
    SC_PASS(add_text(ctx, SC_BAR_LOW, texts[0], size_px, list));
    if (scale->low < scale->high) {
        SC_PASS(add_text(ctx, SC_BAR_MIDDLE, texts[1], size_px, list));
        SC_PASS(add_text(ctx, SC_BAR_HIGH, texts[2], size_px, list));
    }
    return SC_OK;
}

/* Refuse a title with characters that cannot be drawn. */
static sc_status check_title(const sc_ctx *ctx, const char *title)
{
    for (size_t at = 0, bytes; title[at]; at += bytes ? bytes : 1) {
        unsigned code;
        const char *why;

        bytes = sc_utf8_bytes(title + at);
        code = sc_utf8_code(title + at, bytes ? bytes : 1);
        why = sc_font_refuses(code);
        if (why)
            return sc_fail(ctx, SC_ERR_DATA,
                           "the title of the colour bar, \"%s\", cannot be written onto pictures: "
                           "U+%04X %s; give it another title (color_by.title)",
                           title, code, why);
    }
    return SC_OK;
}

/* Append the title, smaller or with dots at its end if it is long. */
static sc_status add_title(const sc_ctx *ctx, const sc_annotations *a, sc_font *font,
                           double size_px, sc_line_list *list)
{
    const double widest = WIDEST * a->within.width_px;
    char title[SC_NAME_BYTES + 4];
    size_t bytes = strlen(a->scale->title);
    double width;

    memcpy(title, a->scale->title, bytes + 1);
    for (char *c = title; *c; c++)
        *c = (char)(*c == '_' ? ' ' : *c);
    width = sc_font_width_px(font, title, bytes, size_px);
    size_px = fmax(LEAST_PX, size_px * fmin(1, fmax(SMALLEST, widest / fmax(width, 1))));
    while (bytes > 1 && sc_font_width_px(font, title, strlen(title), size_px) > widest) {
        do
            bytes--;
        while (bytes > 1 && ((unsigned char)title[bytes] & 0xc0) == 0x80);
        memcpy(title + bytes, "...", 4);
    }
    return add_text(ctx, SC_BAR_TITLE, title, size_px, list);
}

sc_status sc_add_color_bar(const sc_ctx *ctx, const sc_annotations *a, sc_font *font,
                           sc_line_list *list)
{
    const sc_color_scale *scale = a->scale;
    const double size_px = fmax(LEAST_PX, SIZE * sc_text_px(a));

    SC_PASS(check_title(ctx, scale->title));
    if (scale->title[0])
        SC_PASS(add_title(ctx, a, font, size_px, list));
    SC_PASS(add_values(ctx, scale, size_px, list));
    if (scale->lacks_some)
        return add_text(ctx, SC_BAR_MISSING, "no value", size_px, list);
    return SC_OK;
}

/* ---- drawing ---- */

/* Draw a rectangle with the outline that letters have. */
static void draw_frame(const sc_drawing *d, const sc_viewport *box, int edge)
{
    const sc_viewport outer = {box->x_px - edge, box->y_px - edge, box->width_px + 2 * edge,
                               box->height_px + 2 * edge};

    sc_overlay_fill(d->image, &outer, d->letters.rgb, 255, d->rows);
}

/* Draw the colours of the map from left to right. */
static void draw_map(const sc_drawing *d, const sc_viewport *bar)
{
    const sc_color_scale *scale = d->a->scale;
    uint8_t rgb[3];

    for (int x = 0; x < bar->width_px; x++) {
        sc_color_map_at((sc_color_map)scale->map,
                        scale->low < scale->high ? (x + 0.5) / bar->width_px : 0.5, rgb);
        sc_overlay_fill(d->image, &(sc_viewport){bar->x_px + x, bar->y_px, 1, bar->height_px}, rgb,
                        255, d->rows);
    }
}

/* Draw a word if there is one. */
static void draw_word(const sc_drawing *d, const sc_word *word, int x, int y)
{
    if (word)
        sc_lettering_draw(d->a->lettering, word, x, y, &d->letters, 255, d->image, d->rows);
}

/* Draw the values below the bar; that of its middle only if there is room between the others. */
static void draw_values(const sc_drawing *d, const sc_word *const words[SC_BAR_TEXTS],
                        const sc_viewport *bar, int y)
{
    const sc_word *low = words[SC_BAR_LOW], *middle = words[SC_BAR_MIDDLE];
    const sc_word *high = words[SC_BAR_HIGH];
    const int end = bar->x_px + bar->width_px;

    if (!high) { /* all values are the same */
        draw_word(d, low, bar->x_px + (bar->width_px - low->advance_px) / 2, y);
        return;
    }
    draw_word(d, low, bar->x_px, y);
    draw_word(d, high, end - high->advance_px, y);
    if (middle) {
        const int x = bar->x_px + (bar->width_px - middle->advance_px) / 2, gap = low->capitals_px;

        if (x > bar->x_px + low->advance_px + gap &&
            x + middle->advance_px < end - high->advance_px - gap)
            draw_word(d, middle, x, y);
    }
}

void sc_draw_color_bar(sc_drawing *d)
{
    const sc_word *words[SC_BAR_TEXTS], *low, *title, *missing;
    int width = (int)(BAR * d->a->within.width_px + 0.5), capitals, gap, edge, y;
    sc_viewport room, bar;

    if (!d->a->overlays->color_bar)
        return;
    for (int i = 0; i < SC_BAR_TEXTS; i++)
        words[i] = sc_lettering_find(d->a->lettering, SC_WORD_COLOR_BAR, i);
    low = words[SC_BAR_LOW];
    title = words[SC_BAR_TITLE];
    missing = words[SC_BAR_MISSING];
    if (!low)
        return;
    capitals = low->capitals_px;
    gap = (3 * capitals + 2) / 4;
    edge = capitals / 8 > 1 ? capitals / 8 : 1;
    width = title && title->advance_px > width ? title->advance_px : width;
    room = sc_take_room(d, d->a->overlays->color_bar, width,
                        (title ? title->capitals_px + gap : 0) + 2 * capitals + gap +
                            (missing ? capitals + gap : 0));
    y = room.y_px;
    if (title) {
        draw_word(d, title, room.x_px, y + title->capitals_px);
        y += title->capitals_px + gap;
    }
    bar = (sc_viewport){room.x_px, y, width, capitals};
    draw_frame(d, &bar, edge);
    draw_map(d, &bar);
    draw_values(d, words, &bar, y + 2 * capitals + gap);
    if (missing) {
        const sc_viewport square = {room.x_px, y + 2 * capitals + 2 * gap, capitals, capitals};

        draw_frame(d, &square, edge);
        sc_overlay_fill(d->image, &square, d->a->scale->missing, 255, d->rows);
        draw_word(d, missing, square.x_px + 2 * capitals, square.y_px + capitals);
    }
}
