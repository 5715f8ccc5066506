/* SPDX-License-Identifier: BSD-3-Clause */
/* The legend: a row for each tissue that the film shows, in the same place in all frames, as opaque
 * as the tissue is shown in this one. */
#include "internal.h"

#include <math.h>
#include <string.h>

#define SIZE 0.85      /* of the font, times that of other text */
#define SMALLEST 0.65  /* what the font of many rows may shrink to, as a share of SIZE */
#define ROW 1.35       /* distance of rows, in font sizes */
#define TALLEST 0.7    /* shares of the picture that a legend may fill */
#define WIDEST 0.3     /* ... and one of its names */
enum { LEAST_PX = 8 }; /* the smallest font */

/* ---- rows ---- */

/* @return how many rows of this font size fit into the picture, at most SC_LEGEND_ROWS_MAX. */
static int rows_in(const sc_annotations *a, double size_px)
{
    const double rows = floor(TALLEST * a->within.height_px / ceil(ROW * size_px));

    return rows < 1 ? 1 : rows > SC_LEGEND_ROWS_MAX ? SC_LEGEND_ROWS_MAX : (int)rows;
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

/* @return a colour, in linear light, as a number: red, green and blue from the highest byte on. */
static int32_t color_of(const sc_srgb_table *table, const float linear[3])
{
    int32_t out = 0;

    for (int c = 0; c < 3; c++)
        out = out << 8 | sc_srgb_level(table, linear[c]);
    return out;
}

sc_status sc_add_legend(const sc_ctx *ctx, const sc_annotations *a, sc_font *font,
                        sc_line_list *list)
{
    const double full_px = fmax(LEAST_PX, SIZE * sc_text_px(a));
    const double least_px = fmax(LEAST_PX, SMALLEST * full_px);
    int ids[SC_LEGEND_ROWS_MAX];
    const int fit = rows_in(a, least_px);
    int all, rows;
    sc_text_line line = {.kind = SC_WORD_LEGEND, .size_px = full_px};
    sc_srgb_table table;
    sc_text text = {0};
    char more[64];
    sc_status status;

    SC_TRY(sc_choose_tissues(ctx, a, SC_USE_LEGEND, SC_LEGEND_ROWS_MAX, ids, &all));
    rows = all <= fit ? all : fit - 1;
    while (line.size_px > least_px && rows_in(a, line.size_px) < all)
        line.size_px = fmax(least_px, 0.95 * line.size_px);
    sc_srgb_table_init(&table);
    sort_ids(ids, rows); /* the largest, as they follow one another in the volume */
    for (int i = 0; i < rows; i++) {
        line.number = ids[i];
        line.data = color_of(&table, a->tissues[ids[i]].rgb_linear);
        SC_TRY(sc_name_of(ctx, a, ids[i], "overlays.legend", list, &line.text));
        line.bytes = strlen(line.text);
        SC_TRY(sc_add_cut_line(ctx, font, WIDEST * a->within.width_px, &text, &line, list));
    }
    if (rows < all) {
        snprintf(more, sizeof more, "and %d more", all - rows);
        line.kind = SC_WORD_MORE;
        line.number = 0;
        SC_TRY(sc_keep_text(ctx, list, more, &line.text));
        line.bytes = strlen(line.text);
        status = sc_add_cut_line(ctx, font, WIDEST * a->within.width_px, &text, &line, list);
    }
out:
    sc_text_clear(&text);
    return status;
}

/* ---- drawing ---- */

/* Draw the square in a colour, as of color_of, beside a row, with an outline as that of letters. */
static void draw_square(const sc_drawing *d, const sc_word *word, int32_t color, int x, int y,
                        int alpha)
{
    const uint8_t rgb[3] = {(uint8_t)(color >> 16), (uint8_t)(color >> 8), (uint8_t)color};
    const int side = word->capitals_px, edge = side / 8 > 1 ? side / 8 : 1;

    const sc_viewport edges[] = {{x - edge, y - edge, side + 2 * edge, edge},
                                 {x - edge, y + side, side + 2 * edge, edge},
                                 {x - edge, y, edge, side},
                                 {x + side, y, edge, side}};

    for (size_t i = 0; i < SC_COUNT_OF(edges); i++)
        sc_overlay_fill(d->image, &edges[i], d->letters.rgb, alpha, d->rows);
    sc_overlay_fill(d->image, &(sc_viewport){x, y, side, side}, rgb, alpha, d->rows);
}

void sc_draw_legend(sc_drawing *d, const sc_scene *scene)
{
    const sc_lettering *lettering = d->a->lettering;
    int rows = 0, widest = 0, pitch = 0, capitals = 0, row = 0;
    sc_srgb_table table;
    sc_viewport room;

    sc_srgb_table_init(&table);
    for (uint64_t i = 0; i < lettering->count; i++) {
        const sc_word *word = &lettering->words[i];

        if (word->kind != SC_WORD_LEGEND && word->kind != SC_WORD_MORE)
            continue;
        rows++;
        widest = word->advance_px > widest ? word->advance_px : widest;
        pitch = word->line_px;
        capitals = word->capitals_px;
    }
    if (!d->a->overlays->legend || !rows)
        return;
    room = sc_take_room(d, d->a->overlays->legend, widest + 2 * capitals,
                        (rows - 1) * pitch + capitals);
    for (uint64_t i = 0; i < lettering->count; i++) {
        const sc_word *word = &lettering->words[i];
        const bool is_tissue = word->kind == SC_WORD_LEGEND;
        const int y = room.y_px + row * pitch;
        int alpha = 255;

        if (!is_tissue && word->kind != SC_WORD_MORE)
            continue;
        if (is_tissue) {
            alpha = sc_shown_alpha(d->a, scene, word->number);
            draw_square(d, word,
                        scene->colors ? color_of(&table, scene->colors[word->number]) : word->data,
                        room.x_px, y, alpha);
        }
        sc_lettering_draw(lettering, word, room.x_px + 2 * capitals, y + capitals, &d->letters,
                          alpha, d->image, d->rows);
        row++;
    }
}
