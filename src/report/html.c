/* SPDX-License-Identifier: BSD-3-Clause */
/* Pages: escaping, their frame, tables. */
#include "internal.h"

#include <stdarg.h>
#include <string.h>

/* ---- text ---- */

void sc_page_add(sc_page *page, const char *fmt, ...)
{
    char buffer[512];
    va_list args, again;
    int count;

    if (page->status != SC_OK)
        return;
    va_start(args, fmt);
    va_copy(again, args);
    count = vsnprintf(buffer, sizeof buffer, fmt, args);
    if (count >= 0 && count < (int)sizeof buffer) {
        page->status = sc_text_add(page->ctx, &page->text, "%s", buffer);
    } else if (count >= 0) {
        void *block;

        page->status = sc_alloc(page->ctx, (size_t)count + 1, 1, &block);
        if (page->status == SC_OK) {
            vsnprintf(block, (size_t)count + 1, fmt, again);
            page->status = sc_text_add(page->ctx, &page->text, "%s", (const char *)block);
            sc_free(block);
        }
    }
    va_end(again);
    va_end(args);
}

/* @return the entity for a character that HTML obeys, or NULL. */
static const char *entity(char c)
{
    return c == '&'    ? "&amp;"
           : c == '<'  ? "&lt;"
           : c == '>'  ? "&gt;"
           : c == '"'  ? "&quot;"
           : c == '\'' ? "&#39;"
                       : NULL;
}

/* Is it a character that can stand in a page as it is: printable ASCII without an entity, a newline
 * or a tab? */
static bool is_plain(char c)
{
    return (c >= ' ' && c < 0x7f && !entity(c)) || c == '\n' || c == '\t';
}

/* Add the character of @p bytes bytes (0: a byte that is none of UTF-8) at @p text. @return how
 * many bytes were used. */
static size_t add_character(sc_page *page, const char *text, size_t bytes)
{
    char one[5] = "", shown[32];
    const size_t used = bytes ? bytes : 1;

    if (bytes == 1 && entity(*text)) {
        sc_page_add(page, "%s", entity(*text));
        return 1;
    }
    memcpy(one, text, used);
    (void)sc_printable(one, shown, sizeof shown);
    /* XML has no characters U+FFFE and U+FFFF */
    if (bytes == 3 && !memcmp(text, "\xef\xbf", 2) && (unsigned char)text[2] >= 0xbe)
        snprintf(shown, sizeof shown, "\\uff%02x", 0x40 + (unsigned char)text[2]);
    sc_page_add(page, "%s", shown);
    return used;
}

void sc_page_text(sc_page *page, const char *text)
{
    while (*text && page->status == SC_OK) {
        size_t plain = 0;

        while (plain < 400 && is_plain(text[plain]))
            plain++;
        if (plain)
            sc_page_add(page, "%.*s", (int)plain, text);
        text += plain;
        if (*text && !is_plain(*text))
            text += add_character(page, text, sc_utf8_bytes(text));
    }
}

/* As sc_page_text, of a formatted text. */
SC_PRINTF(2, 0)
static void add_formatted(sc_page *page, const char *fmt, va_list args)
{
    va_list again;
    void *block;
    int count;

    va_copy(again, args);
    count = vsnprintf(NULL, 0, fmt, args);
    if (page->status == SC_OK && count >= 0)
        page->status = sc_alloc(page->ctx, (size_t)count + 1, 1, &block);
    if (page->status == SC_OK && count >= 0) {
        vsnprintf(block, (size_t)count + 1, fmt, again);
        sc_page_text(page, block);
        sc_free(block);
    }
    va_end(again);
}

void sc_page_textf(sc_page *page, const char *fmt, ...)
{
    va_list args;

    va_start(args, fmt);
    add_formatted(page, fmt, args);
    va_end(args);
}

void sc_page_prose(sc_page *page, const char *text)
{
    bool code = false;

    while (*text) {
        const size_t length = strcspn(text, "`");

        sc_page_textf(page, "%.*s", (int)length, text);
        text += length;
        if (*text == '`') {
            sc_page_add(page, code ? "</code>" : "<code>");
            code = !code;
            text++;
        }
    }
    if (code)
        sc_page_add(page, "</code>");
}

void sc_page_address(sc_page *page, const char *name)
{
    static const char plain[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._~/";

    for (; *name; name++) {
        if (strchr(plain, *name))
            sc_page_add(page, "%c", *name);
        else
            sc_page_add(page, "%%%02X", (unsigned)(unsigned char)*name);
    }
}

void sc_page_base64(sc_page *page, const void *data, size_t bytes)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const uint8_t *from = data;
    char line[4 * 64 + 1];
    size_t used = 0;

    for (size_t at = 0; at < bytes; at += 3) {
        const unsigned group = (unsigned)from[at] << 16 |
                               (at + 1 < bytes ? (unsigned)from[at + 1] << 8 : 0) |
                               (at + 2 < bytes ? (unsigned)from[at + 2] : 0);

        line[used++] = digits[group >> 18];
        line[used++] = digits[group >> 12 & 63];
        line[used++] = at + 1 < bytes ? digits[group >> 6 & 63] : '=';
        line[used++] = at + 2 < bytes ? digits[group & 63] : '=';
        if (used == sizeof line - 1 || at + 3 >= bytes) {
            sc_page_add(page, "%.*s", (int)used, line);
            used = 0;
        }
    }
}

/* ---- the frame of a page ---- */

sc_page sc_page_begin(const sc_ctx *ctx, const char *title)
{
    sc_page page = {.ctx = ctx};

    sc_page_add(&page, "<!DOCTYPE html>\n"
                       "<html xmlns=\"http://www.w3.org/1999/xhtml\" lang=\"en\">\n<head>\n"
                       "<meta charset=\"utf-8\"/>\n"
                       "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
                       "<meta name=\"color-scheme\" content=\"light dark\"/>\n<title>");
    sc_page_text(&page, title);
    sc_page_add(&page, "</title>\n<style>\n%s", sc_page_style);
    for (int i = 0; i < SC_SERIES_COLORS; i++) {
        const uint8_t *c = sc_series_colors[i];

        sc_page_add(&page, ".c%d { fill: #%02x%02x%02x; stroke: #%02x%02x%02x; }\n", i, c[0], c[1],
                    c[2], c[0], c[1], c[2]);
    }
    sc_page_add(&page, "</style>\n</head>\n<body>\n<main>\n<h1>");
    sc_page_text(&page, title);
    sc_page_add(&page, "</h1>\n");
    return page;
}

sc_status sc_page_end(sc_page *page)
{
    sc_page_add(page, "</main>\n</body>\n</html>\n");
    return page->status;
}

void sc_page_clear(sc_page *page)
{
    sc_text_clear(&page->text);
    *page = (sc_page){0};
}

void sc_page_section(sc_page *page, const char *heading)
{
    sc_page_add(page, "<section>\n<h2>");
    sc_page_text(page, heading);
    sc_page_add(page, "</h2>\n");
}

void sc_page_section_end(sc_page *page)
{
    sc_page_add(page, "</section>\n");
}

/* ---- tables ---- */

sc_table sc_table_begin(sc_page *page, const char *caption, const char *const *heads, int columns)
{
    sc_page_add(page, "<table class=\"data%s\">\n<caption>", columns > 4 ? " wide" : "");
    sc_page_text(page, caption);
    sc_page_add(page, "</caption>\n<thead><tr>");
    for (int i = 0; i < columns; i++) {
        sc_page_add(page, "<th scope=\"col\">");
        sc_page_text(page, heads[i]);
        sc_page_add(page, "</th>");
    }
    sc_page_add(page, "</tr></thead>\n<tbody>\n");
    return (sc_table){.page = page, .heads = heads, .columns = columns};
}

/* Is it a number, several with few words, or short? Then no line may break within a word. */
SC_PRINTF(1, 0)
static bool is_short(const char *fmt, va_list args)
{
    char text[32];
    const int length = vsnprintf(text, sizeof text, fmt, args);

    return length <= 10 || (length < (int)sizeof text && *text >= '0' && *text <= '9');
}

void sc_table_cell(sc_table *table, const char *fmt, ...)
{
    sc_page *page = table->page;
    const char *tag = table->column == 0 ? "th" : "td";
    bool numbers;
    va_list args;

    va_start(args, fmt);
    numbers = table->column > 0 && is_short(fmt, args);
    va_end(args);
    sc_page_add(page, "%s<%s%s%s data-head=\"", table->column == 0 ? "<tr>" : "", tag,
                table->column == 0 ? " scope=\"row\"" : "", numbers ? " class=\"n\"" : "");
    sc_page_text(page, table->heads[table->column]);
    sc_page_add(page, "\">");
    va_start(args, fmt);
    add_formatted(page, fmt, args);
    va_end(args);
    sc_page_add(page, "</%s>", tag);
    table->column++;
    if (table->column == table->columns) {
        sc_page_add(page, "</tr>\n");
        table->column = 0;
    }
}

void sc_table_end(sc_table *table)
{
    sc_page_add(table->page, "</tbody>\n</table>\n");
}

void sc_facts_begin(sc_page *page)
{
    sc_page_add(page, "<dl>\n");
}

void sc_fact(sc_page *page, const char *name, const char *fmt, ...)
{
    va_list args;

    sc_page_add(page, "<div><dt>");
    sc_page_text(page, name);
    sc_page_add(page, "</dt><dd>");
    va_start(args, fmt);
    add_formatted(page, fmt, args);
    va_end(args);
    sc_page_add(page, "</dd></div>\n");
}

void sc_facts_end(sc_page *page)
{
    sc_page_add(page, "</dl>\n");
}
