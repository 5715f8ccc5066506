/* SPDX-License-Identifier: BSD-3-Clause */
/* Puts data into the page. */
#include "segcast/page.h"

sc_status sc_page_make(const sc_ctx *ctx, const char *json, sc_text *out)
{
    static const char mark[] = "@DATA@";
    const char *at = strstr(sc_page_html, mark);
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(sc_text_add(ctx, &text, "%.*s", (int)(at - sc_page_html), sc_page_html));
    while (*json) {
        const size_t plain = strcspn(json, "<");

        SC_PASS(sc_text_add(ctx, &text, "%.*s%s", (int)plain, json, json[plain] ? "\\u003c" : ""));
        json += plain + (json[plain] != '\0');
    }
    SC_PASS(sc_text_add(ctx, &text, "%s", at + strlen(mark)));
    SC_HAND_OVER(text, out);
    return SC_OK;
}
