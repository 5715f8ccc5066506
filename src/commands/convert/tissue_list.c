/* SPDX-License-Identifier: BSD-3-Clause */
/* The tissues that --tissue names, for a mesh or a centre line. */
#include "commands.h"

void sc_tissue_list_clear(sc_tissue_list *list)
{
    sc_text_clear(&list->text);
}

sc_status sc_tissue_list_read(const sc_ctx *ctx, const char *tissues, sc_tissue_list *out)
{
    if (!tissues || !tissues[0] || tissues[0] == ',')
        return sc_fail(ctx, SC_ERR_USAGE,
                       "no tissue: give one as --tissue NAME, or several with commas between them; "
                       "`segcast info VOLUME` lists those of a volume");
    SC_PASS(sc_text_add(ctx, &out->text, "%s", tissues));
    for (char *at = out->text.data; at;) {
        char *comma = strchr(at, ',');

        if (comma)
            *comma++ = '\0';
        if (!at[0] || strlen(at) >= SC_NAME_BYTES || out->count == SC_TISSUES_MAX)
            return sc_fail(
                ctx, SC_ERR_USAGE,
                "--tissue is \"%s\", expected up to %d names of tissues with commas between them; "
                "one with a comma in its name can be given by the number of its label",
                tissues, SC_TISSUES_MAX);
        out->names[out->count++] = at;
        at = comma;
    }
    return SC_OK;
}
