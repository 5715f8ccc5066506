/* SPDX-License-Identifier: BSD-3-Clause */
/* The legend: a row for each tissue that the film shows, in the same place in all frames, as opaque
 * as the tissue is shown in this one. Where there is no room for so many rows, each frame has those
 * of the largest tissues that are shown in it. */
#include "internal.h"

#include <math.h>
#include <stdlib.h>

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

/* @return the size of the smallest font of a legend. */
static double least_size_px(const sc_annotations *a)
{
    return fmax(LEAST_PX, SMALLEST * fmax(LEAST_PX, SIZE * sc_text_px(a)));
}

/* Append the parts of the last row, which says how many tissues are shown that have none.
 * @param without how many cannot have a row in any frame; they count in all of them. */
static sc_status add_more(const sc_ctx *ctx, double size_px, int without, sc_line_list *list)
{
    static const char *const parts[] = {"0", "1", "2", "3", "4",    "5",
                                        "6", "7", "8", "9", "and ", " more"};

    for (size_t i = 0; i < SC_COUNT_OF(parts); i++)
        SC_PASS(sc_add_line(ctx, list,
                            &(sc_text_line){.kind = SC_WORD_MORE,
                                            .number = parts[i][parts[i][0] == ' '],
                                            .data = without,
                                            .text = parts[i],
                                            .bytes = strlen(parts[i]),
                                            .size_px = size_px}));
    return SC_OK;
}

sc_status sc_add_legend(const sc_ctx *ctx, const sc_annotations *a, sc_font *font,
                        sc_line_list *list)
{
    const double least_px = least_size_px(a);
    int ids[SC_LEGEND_TISSUES_MAX];
    int all, count;
    sc_text_line line = {.kind = SC_WORD_LEGEND, .size_px = fmax(LEAST_PX, SIZE * sc_text_px(a))};
    sc_srgb_table table;
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(sc_choose_tissues(ctx, a, SC_USE_LEGEND, SC_LEGEND_TISSUES_MAX, ids, &all));
    count = all < SC_LEGEND_TISSUES_MAX ? all : SC_LEGEND_TISSUES_MAX;
    while (line.size_px > least_px && rows_in(a, line.size_px) < all)
        line.size_px = fmax(least_px, 0.95 * line.size_px);
    sc_srgb_table_init(&table);
    sort_ids(ids, count); /* as they follow one another in the volume */
    for (int i = 0; i < count; i++) {
        line.number = ids[i];
        line.data = color_of(&table, a->tissues[ids[i]].rgb_linear);
        SC_PASS(sc_name_of(ctx, a, ids[i], "overlays.legend", list, &line.text));
        line.bytes = strlen(line.text);
        SC_PASS(sc_add_cut_line(ctx, font, WIDEST * a->within.width_px, &text, &line, list));
    }
    if (all > rows_in(a, line.size_px))
        return add_more(ctx, line.size_px, all - count, list);
    return SC_OK;
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

/* A row of the legend in a frame. */
typedef struct legend_row {
    const sc_word *word;
    uint64_t voxels; /* of the tissue */
    int alpha;
} legend_row;

/* Compare for qsort: the largest tissues first. */
static int compare_sizes(const void *a, const void *b)
{
    const legend_row *left = a, *right = b;

    if (left->voxels != right->voxels)
        return left->voxels > right->voxels ? -1 : 1;
    return left->word->number - right->word->number;
}

/* Compare for qsort: as the tissues follow one another in the volume. */
static int compare_ids(const void *a, const void *b)
{
    return ((const legend_row *)a)->word->number - ((const legend_row *)b)->word->number;
}

/* What the legend of a frame consists of. */
typedef struct legend {
    legend_row rows[SC_LEGEND_TISSUES_MAX]; /* [count] */
    int count;
    int room;                 /* rows that it has room for */
    int more;                 /* tissues without a row, which the last row counts */
    int widest_px;            /* of the text of all rows of the film */
    int line_px, capitals_px; /* as of sc_word */
} legend;

/* Leave the rows of the largest tissues that are shown, if there is no room for all. */
static void choose_rows(legend *l, int without)
{
    int shown = 0;

    for (int i = 0; i < l->count; i++) {
        if (l->rows[i].alpha > 0)
            l->rows[shown++] = l->rows[i];
    }
    l->count = shown;
    if (shown + (without > 0) <= l->room)
        l->more = without;
    else {
        qsort(l->rows, (size_t)shown, sizeof *l->rows, compare_sizes);
        l->count = shown < l->room - 1 ? shown : l->room - 1;
        l->more = shown - l->count + without;
        if (l->count > 0)
            qsort(l->rows, (size_t)l->count, sizeof *l->rows, compare_ids);
    }
}

/* @return the width of the last row where its number has as many digits as @p most. */
static int more_px(const sc_lettering *lettering, int most)
{
    int digit_px = 0, digits = 1, out = 0;

    for (int digit = '0'; digit <= '9'; digit++) {
        const sc_word *word = sc_lettering_find(lettering, SC_WORD_MORE, digit);

        digit_px = word && word->advance_px > digit_px ? word->advance_px : digit_px;
    }
    for (; most >= 10; most /= 10)
        digits++;
    for (const char *c = "am"; *c; c++) {
        const sc_word *word = sc_lettering_find(lettering, SC_WORD_MORE, *c);

        out += word ? word->advance_px : 0;
    }
    return out + digits * digit_px;
}

/* Find the rows of a frame. */
static void find_rows(const sc_annotations *a, const sc_scene *scene, legend *l)
{
    const sc_lettering *lettering = a->lettering;
    const sc_word *more = sc_lettering_find(lettering, SC_WORD_MORE, 'm');

    *l = (legend){.room = more ? rows_in(a, least_size_px(a)) : 0};
    for (uint64_t i = 0; i < lettering->count; i++) {
        const sc_word *word = &lettering->words[i];

        if (word->kind != SC_WORD_LEGEND || l->count == SC_LEGEND_TISSUES_MAX)
            continue;
        l->rows[l->count++] = (legend_row){word, a->volume->stats[word->number].voxels,
                                           sc_shown_alpha(a, scene, word->number)};
        l->widest_px = word->advance_px > l->widest_px ? word->advance_px : l->widest_px;
        l->line_px = word->line_px;
        l->capitals_px = word->capitals_px;
    }
    if (more) {
        const int most_px = more_px(lettering, l->count + more->data);

        l->widest_px = most_px > l->widest_px ? most_px : l->widest_px;
        choose_rows(l, more->data);
    } else
        l->room = l->count;
}

/* Draw the last row from @p x on, on the base line @p y. */
static void draw_more(const sc_drawing *d, const legend *l, int x, int y)
{
    const sc_lettering *lettering = d->a->lettering;
    char parts[16];

    snprintf(parts, sizeof parts, "a%dm", l->more);
    for (const char *c = parts; *c; c++) {
        const sc_word *word = sc_lettering_find(lettering, SC_WORD_MORE, *c);

        if (word) {
            sc_lettering_draw(lettering, word, x, y, &d->letters, 255, d->image, d->rows);
            x += word->advance_px;
        }
    }
}

void sc_draw_legend(sc_drawing *d, const sc_scene *scene)
{
    sc_srgb_table table;
    sc_viewport room;
    legend l;
    int x, y;

    if (!d->a->overlays->legend)
        return;
    sc_srgb_table_init(&table);
    find_rows(d->a, scene, &l);
    if (!l.room)
        return;
    room = sc_take_room(d, d->a->overlays->legend, l.widest_px + 2 * l.capitals_px,
                        (l.room - 1) * l.line_px + l.capitals_px);
    x = room.x_px + 2 * l.capitals_px;
    y = room.y_px;
    if (d->a->overlays->legend > SC_PLACE_TOP_RIGHT) /* rows end at the lower edge */
        y += (l.room - l.count - (l.more > 0)) * l.line_px;
    for (int i = 0; i < l.count; i++, y += l.line_px) {
        const legend_row *row = &l.rows[i];

        draw_square(d, row->word,
                    scene->colors ? color_of(&table, scene->colors[row->word->number])
                                  : row->word->data,
                    room.x_px, y, row->alpha);
        sc_lettering_draw(d->a->lettering, row->word, x, y + l.capitals_px, &d->letters, row->alpha,
                          d->image, d->rows);
    }
    if (l.more)
        draw_more(d, &l, x, y + l.capitals_px);
}
