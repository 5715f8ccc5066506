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
#define CUT_FADE 0.05  /* share of a tissue's extent that is left when its row begins to fade */
enum { LEAST_PX = 8 }; /* the smallest font */

/* ---- what is seen ---- */

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

/* ---- rows ---- */

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

/* Find the tissues of the legend, all or the @p room largest ones, by rising id. @return how many
 * tissues there are in the film. */
static int choose(const sc_annotations *a, int room, int *ids)
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

/* @return how many rows of this font size fit into the picture, at most SC_LEGEND_ROWS_MAX. */
static int rows_in(const sc_annotations *a, double size_px)
{
    const double rows = floor(TALLEST * a->within.height_px / ceil(ROW * size_px));

    return rows < 1 ? 1 : rows > SC_LEGEND_ROWS_MAX ? SC_LEGEND_ROWS_MAX : (int)rows;
}

/* Append a row: the beginning of a text, with dots if it is too wide. @param room where the dots
 * are put behind the text. */
static sc_status add_row(const sc_ctx *ctx, const sc_annotations *a, sc_font *font, sc_text *room,
                         sc_text_line *line, sc_line_list *list)
{
    const double widest = WIDEST * a->within.width_px;
    size_t bytes = line->bytes;
    sc_status status;

    if (sc_font_width_px(font, line->text, bytes, line->size_px) > widest) {
        do {
            do
                bytes--;
            while (bytes > 1 && ((unsigned char)line->text[bytes] & 0xc0) == 0x80);
        } while (bytes > 1 &&
                 sc_font_width_px(font, line->text, bytes, line->size_px) + line->size_px > widest);
        room->length_bytes = 0;
        SC_TRY(sc_text_add(ctx, room, "%.*s...", (int)bytes, line->text));
        SC_TRY(sc_keep_text(ctx, list, room->data, &line->text));
        line->bytes = strlen(line->text);
    }
    status = sc_add_line(ctx, list, line);
out:
    return status;
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

/* @return the colour of a tissue as a number: red, green and blue from the highest byte on. */
static int32_t color_of(const sc_srgb_table *table, const sc_tissue *tissue)
{
    int32_t out = 0;

    for (int c = 0; c < 3; c++)
        out = out << 8 | sc_srgb_level(table, tissue->rgb_linear[c]);
    return out;
}

sc_status sc_add_legend(const sc_ctx *ctx, const sc_annotations *a, sc_font *font,
                        sc_line_list *list)
{
    const double full_px = fmax(LEAST_PX, SIZE * sc_text_px(a));
    const double least_px = fmax(LEAST_PX, SMALLEST * full_px);
    int ids[SC_LEGEND_ROWS_MAX];
    const int all = choose(a, SC_LEGEND_ROWS_MAX, ids);
    const int fit = rows_in(a, least_px), rows = all <= fit ? all : fit - 1;
    sc_text_line line = {.kind = SC_WORD_LEGEND, .size_px = full_px};
    sc_srgb_table table;
    sc_text text = {0};
    char more[64];
    sc_status status = SC_OK;

    while (line.size_px > least_px && rows_in(a, line.size_px) < all)
        line.size_px = fmax(least_px, 0.95 * line.size_px);
    sc_srgb_table_init(&table);
    (void)choose(a, rows, ids);
    for (int i = 0; i < rows; i++) {
        line.number = ids[i];
        line.data = color_of(&table, &a->tissues[ids[i]]);
        SC_TRY(sc_name_of(ctx, a, ids[i], list, &line.text));
        line.bytes = strlen(line.text);
        SC_TRY(add_row(ctx, a, font, &text, &line, list));
    }
    if (rows < all) {
        snprintf(more, sizeof more, "and %d more", all - rows);
        line.kind = SC_WORD_MORE;
        line.number = 0;
        SC_TRY(sc_keep_text(ctx, list, more, &line.text));
        line.bytes = strlen(line.text);
        status = add_row(ctx, a, font, &text, &line, list);
    }
out:
    sc_text_clear(&text);
    return status;
}

/* ---- drawing ---- */

/* Draw the square in the colour of a row, with an outline as that of letters. */
static void draw_square(const sc_drawing *d, const sc_word *word, int x, int y, int alpha)
{
    const uint8_t rgb[3] = {(uint8_t)(word->data >> 16), (uint8_t)(word->data >> 8),
                            (uint8_t)word->data};
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
    sc_viewport room;

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
            draw_square(d, word, room.x_px, y, alpha);
        }
        sc_lettering_draw(lettering, word, room.x_px + 2 * capitals, y + capitals, &d->letters,
                          alpha, d->image, d->rows);
        row++;
    }
}
