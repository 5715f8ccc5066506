/* SPDX-License-Identifier: BSD-3-Clause */
/* A list of lines that grows. */
#include "internal.h"

#include <string.h>

sc_status sc_add_line(const sc_ctx *ctx, sc_line_list *list, const sc_text_line *line)
{
    const size_t room = 2 * list->room + 32;
    void *grown;
    sc_status status;

    if (list->count == list->room) {
        status = sc_alloc(ctx, room, sizeof *list->lines, &grown);
        if (status != SC_OK)
            return status;
        if (list->count)
            memcpy(grown, list->lines, list->count * sizeof *list->lines);
        sc_free(list->lines);
        list->lines = grown;
        list->room = room;
    }
    list->lines[list->count++] = *line;
    return SC_OK;
}

sc_status sc_keep_text(const sc_ctx *ctx, sc_line_list *list, const char *text, const char **out)
{
    void *grown;
    char *copy;
    sc_status status;

    SC_TRY(sc_alloc(ctx, list->text_count + 1, sizeof *list->texts, &grown));
    if (list->text_count)
        memcpy(grown, list->texts, list->text_count * sizeof *list->texts);
    sc_free(list->texts);
    list->texts = grown;
    SC_TRY(sc_text_copy(ctx, text, &copy));
    list->texts[list->text_count++] = copy;
    *out = copy;
out:
    return status;
}

sc_status sc_add_cut_line(const sc_ctx *ctx, sc_font *font, double widest, sc_text *room,
                          sc_text_line *line, sc_line_list *list)
{
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

void sc_lines_clear(sc_line_list *list)
{
    for (size_t i = 0; i < list->text_count; i++)
        sc_free(list->texts[i]);
    sc_free(list->texts);
    sc_free(list->lines);
    *list = (sc_line_list){0};
}
