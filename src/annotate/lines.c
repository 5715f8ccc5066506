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
