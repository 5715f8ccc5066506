/* SPDX-License-Identifier: BSD-3-Clause */
/* A list of lines that grows. */
#include "internal.h"

sc_status sc_add_line(const sc_ctx *ctx, sc_line_list *list, const sc_text_line *line)
{
    SC_PASS(SC_GROW(ctx, list->count, &list->room, &list->lines));
    list->lines[list->count++] = *line;
    return SC_OK;
}

sc_status sc_keep_text(const sc_ctx *ctx, sc_line_list *list, const char *text, const char **out)
{
    char *copy;

    SC_PASS(SC_RESIZE(ctx, list->text_count, list->text_count + 1, &list->texts));
    SC_PASS(sc_text_copy(ctx, text, &copy));
    list->texts[list->text_count++] = copy;
    *out = copy;
    return SC_OK;
}

sc_status sc_add_cut_line(const sc_ctx *ctx, sc_font *font, double widest, sc_text *room,
                          sc_text_line *line, sc_line_list *list)
{
    size_t bytes = line->bytes;

    if (sc_font_width_px(font, line->text, bytes, line->size_px) > widest) {
        do {
            do
                bytes--;
            while (bytes > 1 && ((unsigned char)line->text[bytes] & 0xc0) == 0x80);
        } while (bytes > 1 &&
                 sc_font_width_px(font, line->text, bytes, line->size_px) + line->size_px > widest);
        room->length_bytes = 0;
        SC_PASS(sc_text_add(ctx, room, "%.*s...", (int)bytes, line->text));
        SC_PASS(sc_keep_text(ctx, list, room->data, &line->text));
        line->bytes = strlen(line->text);
    }
    return sc_add_line(ctx, list, line);
}

void sc_lines_clear(sc_line_list *list)
{
    for (size_t i = 0; i < list->text_count; i++)
        sc_free(list->texts[i]);
    sc_free(list->texts);
    sc_free(list->lines);
    *list = (sc_line_list){0};
}
