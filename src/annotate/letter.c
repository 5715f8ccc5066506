/* SPDX-License-Identifier: BSD-3-Clause */
/* All text of a film, turned into pixels at once. */
#include "internal.h"

/* Append the characters of which time codes and scale bars are composed. */
static sc_status add_glyphs(const sc_ctx *ctx, const sc_annotations *a, sc_line_list *list)
{
    static const char glyphs[] = SC_GLYPHS;

    for (size_t i = 0; glyphs[i]; i++)
        SC_PASS(sc_add_line(ctx, list,
                            &(sc_text_line){.kind = SC_WORD_GLYPH,
                                            .number = glyphs[i],
                                            .text = &glyphs[i],
                                            .bytes = 1,
                                            .size_px = sc_text_px(a)}));
    return SC_OK;
}

sc_status sc_annotations_letter(const sc_ctx *ctx, const sc_annotations *annotations,
                                sc_lettering **out)
{
    const sc_overlays *o = annotations->overlays;
    sc_font_told nothing = {0}, *told = annotations->told ? annotations->told : &nothing;
    SC_OWN(sc_lines_clear) sc_line_list list = {0};
    SC_OWN(sc_font_close_at) sc_font *font = NULL;

    SC_PASS(sc_font_open(ctx, o->font, o->font_where, &font));
    if (strcmp(told->family, o->font) != 0)
        sc_info(ctx, "text is drawn in the font of %s", sc_font_file(font));
    memcpy(told->family, o->font, sizeof told->family);
    if (o->time || o->scale_bar)
        SC_PASS(add_glyphs(ctx, annotations, &list));
    if (o->color_bar)
        SC_PASS(sc_add_color_bar(ctx, annotations, font, &list));
    if (o->orientation)
        SC_PASS(sc_add_orientation(ctx, annotations, &list));
    if (o->legend)
        SC_PASS(sc_add_legend(ctx, annotations, font, &list));
    if (sc_annotations_names(annotations))
        SC_PASS(sc_add_names(ctx, annotations, font, &list));
    if (annotations->card)
        SC_PASS(sc_add_card(ctx, annotations, font, &list));
    SC_PASS(sc_add_captions(ctx, annotations, font, &list));
    return sc_lettering_make(ctx, font, list.lines, list.count, told, out);
}
