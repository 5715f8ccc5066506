/* SPDX-License-Identifier: BSD-3-Clause */
/* Lines of text, drawn by cairo into masks that are kept in one block. */
#include "segcast/lettering.h"

#include "blend.h"
#include "font.h"

#include <errno.h>
#include <math.h>

/* Width of the halo around letters, and of its line, as shares of the font size; its opacity. */
#define HALO 0.11
#define HALO_ALPHA 217
/* Distance of base lines; height of capital letters as a share of the ascent of the font, about. */
#define LINE 1.3
#define CAPITALS 0.76

/* A line of text on its way into pixels. */
typedef struct drawn_line {
    cairo_path_t *path;
    sc_word word; /* all but .at */
} drawn_line;

/* Get the outlines of a line and how much room it takes. Caller owns out->path. */
static void outline_line(sc_font *font, const sc_text_line *line, cairo_t *cairo, drawn_line *out)
{
    const double halo = fmax(1, HALO * line->size_px);
    double left, top, right, bottom, advance;

    cairo_new_path(cairo);
    cairo_move_to(cairo, 0, 0);
    advance = sc_font_outline(font, line->text, line->bytes, line->size_px, cairo);
    cairo_path_extents(cairo, &left, &top, &right, &bottom);
    out->word =
        (sc_word){.kind = line->kind,
                  .number = line->number,
                  .data = line->data,
                  .left_px = (int32_t)floor(left - halo) - 1,
                  .top_px = (int32_t)floor(top - halo) - 1,
                  .width_px = (int32_t)(ceil(right + halo) - floor(left - halo)) + 2,
                  .height_px = (int32_t)(ceil(bottom + halo) - floor(top - halo)) + 2,
                  .advance_px = (int32_t)ceil(advance),
                  .capitals_px = (int32_t)(CAPITALS * sc_font_ascent(font, line->size_px) + 0.5),
                  .line_px = (int32_t)ceil(LINE * line->size_px)};
    out->path = cairo_copy_path(cairo);
}

/* Draw a line into a mask [height_px][width_px]: its letters, or its halo, which also lies under
 * them. @return false if there is no memory. */
static bool fill_mask(const drawn_line *line, double size_px, bool halo, uint8_t *mask)
{
    const sc_word *word = &line->word;
    const size_t width = (size_t)word->width_px;
    cairo_surface_t *surface =
        cairo_image_surface_create(CAIRO_FORMAT_A8, word->width_px, word->height_px);
    cairo_t *cairo = cairo_create(surface);
    const uint8_t *from;
    bool ok;
    int stride;

    errno = 0;
    cairo_translate(cairo, -word->left_px, -word->top_px);
    cairo_append_path(cairo, line->path);
    cairo_set_line_join(cairo, CAIRO_LINE_JOIN_ROUND);
    cairo_set_line_width(cairo, 2 * fmax(1, HALO * size_px));
    if (halo)
        cairo_stroke_preserve(cairo);
    cairo_fill(cairo);
    cairo_surface_flush(surface);
    from = cairo_image_surface_get_data(surface);
    stride = cairo_image_surface_get_stride(surface);
    /* cairo forgets some failures of malloc, which leave letters out. */
    ok = from && cairo_status(cairo) == CAIRO_STATUS_SUCCESS && errno != ENOMEM;
    for (int y = 0; ok && y < word->height_px; y++)
        memcpy(mask + (size_t)y * width, from + (size_t)y * (size_t)stride, width);
    cairo_destroy(cairo);
    cairo_surface_destroy(surface);
    return ok;
}

/* Note a character that no font has. @return whether it was not told before; false also if there is
 * no room for more of them. */
static bool note_missing(unsigned code, sc_font_told *told)
{
    for (size_t i = 0; i < told->missing_count; i++) {
        if (told->missing[i] == code)
            return false;
    }
    if (told->missing_count == SC_COUNT_OF(told->missing))
        return false;
    told->missing[told->missing_count++] = code;
    return true;
}

/* Warn of the characters of all lines that no font has, once of each. */
static sc_status warn_of_missing(const sc_ctx *ctx, const sc_font *font, const sc_text_line *lines,
                                 size_t count, sc_font_told *told)
{
    size_t found = 0;
    SC_OWN(sc_text_clear) sc_text text = {0};

    for (size_t i = 0; i < count; i++) {
        for (size_t at = 0, length; at < lines[i].bytes; at += length ? length : 1) {
            unsigned code;

            length = sc_utf8_bytes(lines[i].text + at);
            code = sc_utf8_code(lines[i].text + at, length ? length : 1);
            if (sc_font_has(font, code) || !note_missing(code, told))
                continue;
            SC_PASS(sc_text_add(ctx, &text, "%s%.*s (U+%04X)", found++ ? ", " : "", (int)length,
                                lines[i].text + at, code));
        }
    }
    if (found)
        sc_warn(
            ctx,
            "no font here has %s: a box stands for %s in the pictures; install a font that has %s",
            text.data, found > 1 ? "each of them" : "it", found > 1 ? "them" : "it");
    return SC_OK;
}

/* Put the lines, whose outlines are known, into one block. */
static sc_status pack(const sc_ctx *ctx, const drawn_line *drawn, const sc_text_line *lines,
                      size_t count, sc_lettering **out)
{
    uint64_t bytes = sizeof(sc_lettering) + count * sizeof(sc_word);
    uint64_t at = bytes;
    sc_lettering *lettering;

    for (size_t i = 0; i < count; i++)
        bytes += 2 * (uint64_t)drawn[i].word.width_px * (uint64_t)drawn[i].word.height_px;
    SC_PASS(sc_zalloc(ctx, bytes, 1, &lettering));
    lettering->bytes = bytes;
    lettering->count = count;
    for (size_t i = 0; i < count; i++) {
        sc_word *word = &lettering->words[i];
        const size_t pixels = (size_t)drawn[i].word.width_px * (size_t)drawn[i].word.height_px;

        *word = drawn[i].word;
        word->at = at;
        if (!fill_mask(&drawn[i], lines[i].size_px, true, (uint8_t *)lettering + at) ||
            !fill_mask(&drawn[i], lines[i].size_px, false, (uint8_t *)lettering + at + pixels)) {
            sc_free(lettering);
            return sc_fail(ctx, SC_ERR_MEMORY, "drawing a text of %d x %d pixels: out of memory",
                           word->width_px, word->height_px);
        }
        at += 2 * pixels;
    }
    *out = lettering;
    return SC_OK;
}

sc_status sc_lettering_make(const sc_ctx *ctx, sc_font *font, const sc_text_line *lines,
                            size_t count, sc_font_told *told, sc_lettering **out)
{
    /* A surface without borders: cairo leaves out glyphs that lie outside of one. */
    cairo_surface_t *surface = cairo_recording_surface_create(CAIRO_CONTENT_ALPHA, NULL);
    cairo_t *cairo = cairo_create(surface);
    drawn_line *drawn = NULL;
    sc_status status;

    SC_TRY(warn_of_missing(ctx, font, lines, count, told));
    SC_TRY(SC_ZALLOC(ctx, count + 1, &drawn));
    for (size_t i = 0; i < count; i++)
        outline_line(font, &lines[i], cairo, &drawn[i]);
    if (sc_font_failed(font) || cairo_status(cairo) != CAIRO_STATUS_SUCCESS) {
        status = sc_fail(ctx, SC_ERR_MEMORY, "drawing text: out of memory");
        goto out;
    }
    status = pack(ctx, drawn, lines, count, out);
out:
    for (size_t i = 0; drawn && i < count; i++)
        cairo_path_destroy(drawn[i].path);
    sc_free(drawn);
    cairo_destroy(cairo);
    cairo_surface_destroy(surface);
    return status;
}

const sc_word *sc_lettering_find(const sc_lettering *lettering, int kind, int number)
{
    for (uint64_t i = 0; i < lettering->count; i++) {
        if (lettering->words[i].kind == kind && lettering->words[i].number == number)
            return &lettering->words[i];
    }
    return NULL;
}

void sc_lettering_draw(const sc_lettering *lettering, const sc_word *word, int x, int y,
                       const sc_letters *letters, int alpha, sc_image *image, const sc_rows *rows)
{
    const sc_viewport all = {x + word->left_px, y + word->top_px, word->width_px, word->height_px};
    const sc_viewport part = sc_blend_part(image, &all, rows);
    const uint8_t *masks = (const uint8_t *)lettering + word->at;
    const size_t pixels = (size_t)word->width_px * (size_t)word->height_px;
    const unsigned strong = (unsigned)alpha, weak = ((unsigned)alpha * HALO_ALPHA + 127) / 255;

    for (int row = 0; row < part.height_px; row++) {
        const size_t at = (size_t)(part.y_px + row - all.y_px) * (size_t)word->width_px +
                          (size_t)(part.x_px - all.x_px);
        uint8_t *to = sc_blend_pixel(image, part.x_px, part.y_px + row);

        for (size_t i = at; i < at + (size_t)(part.width_px > 0 ? part.width_px : 0); i++) {
            sc_blend(letters->halo, (masks[i] * weak + 127) / 255, image->alpha, to);
            sc_blend(letters->rgb, (masks[pixels + i] * strong + 127) / 255, image->alpha, to);
            to += sc_pixel_bytes(image->alpha);
        }
    }
}
