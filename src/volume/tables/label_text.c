/* SPDX-License-Identifier: BSD-3-Clause */
/* The text of label tables in UTF-8, whatever it was written in. */
#include "tables/label_table.h"

/* What Windows-1252 has in place of the control characters 0x80 to 0x9f of Latin-1; 0: nothing. */
static const uint16_t windows_1252[32] = {
    0x20ac, 0,      0x201a, 0x0192, 0x201e, 0x2026, 0x2020, 0x2021, 0x02c6, 0x2030, 0x0160,
    0x2039, 0x0152, 0,      0x017d, 0,      0,      0x2018, 0x2019, 0x201c, 0x201d, 0x2022,
    0x2013, 0x2014, 0x02dc, 0x2122, 0x0161, 0x203a, 0x0153, 0,      0x017e, 0x0178};
enum {
    REPLACEMENT = 0xfffd, /* the character that stands for what cannot be decoded */
    UTF8_MOST = 3         /* bytes of UTF-8 that a unit of UTF-16, or a byte, takes at most */
};

/* Write the character @p code, or that which stands for none, as UTF-8. @return behind it. */
static char *put(char *out, uint32_t code)
{
    const bool is_none = code > 0x10ffff || (code >= 0xd800 && code < 0xe000);
    const uint32_t c = is_none ? REPLACEMENT : code;
    const int more = c < 0x80 ? 0 : c < 0x800 ? 1 : c < 0x10000 ? 2 : 3;
    static const uint8_t first[] = {0, 0xc0, 0xe0, 0xf0};

    *out++ = (char)(first[more] | c >> 6 * more);
    for (int i = more; i-- > 0;)
        *out++ = (char)(0x80 | (c >> 6 * i & 0x3f));
    return out;
}

/* @return unit @p i of a text, of @p unit bytes each. @param big its first byte is the upper one.
 */
static uint32_t unit_at(const char *text, size_t i, size_t unit, bool big)
{
    uint32_t code = 0;

    for (size_t k = 0; k < unit; k++)
        code = code << 8 | (uint8_t)text[unit * i + (big ? k : unit - 1 - k)];
    return code;
}

/* Decode @p count units of UTF-32, of UTF-16, or of Windows-1252, whose units are bytes, to @p out.
 * @return behind what was written. */
static char *decode(const char *text, size_t count, size_t unit, bool big, char *out)
{
    for (size_t i = 0; i < count; i++) {
        uint32_t code = unit_at(text, i, unit, big);

        if (unit == 1 && code >= 0x80 && code < 0xa0)
            code = windows_1252[code - 0x80] ? windows_1252[code - 0x80] : REPLACEMENT;
        if (unit == 2 && code >= 0xd800 && code < 0xdc00 && i + 1 < count) {
            const uint32_t low = unit_at(text, i + 1, unit, big);

            if (low >= 0xdc00 && low < 0xe000) {
                code = 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
                i++;
            }
        }
        out = put(out, code);
    }
    return out;
}

/* Has the text bytes that are no ASCII, and not one character of UTF-8 among them? A text of UTF-8
 * with some damage has. XML, which names its encoding itself, is left to its parser. */
static bool is_not_utf8(const char *text)
{
    bool is_ascii = true;

    if (text[strspn(text, " \t\r\n")] == '<')
        return false;
    for (; *text; text++) {
        if (sc_utf8_bytes(text) > 1)
            return false;
        is_ascii = is_ascii && (unsigned char)*text < 0x80;
    }
    return !is_ascii;
}

/* An encoding that a byte order mark tells. */
typedef struct marked_encoding {
    const char *name, *mark;
    size_t unit; /* bytes of a unit, and of the mark */
    bool is_big; /* the first byte of a unit is its upper one */
} marked_encoding;

/* UTF-32 first: its mark begins with that of UTF-16, behind which a text has no NUL. */
static const marked_encoding encodings[] = {
    {"UTF-32", "\xff\xfe\0\0", 4, false},
    {"UTF-32", "\0\0\xfe\xff", 4, true},
    {"UTF-16", "\xff\xfe", 2, false},
    {"UTF-16", "\xfe\xff", 2, true},
};

/* @return the encoding that the mark at the begin of a text tells, or NULL. */
static const marked_encoding *find_encoding(const char *text, size_t bytes)
{
    for (size_t i = 0; i < SC_COUNT_OF(encodings); i++) {
        if (bytes >= encodings[i].unit && !memcmp(text, encodings[i].mark, encodings[i].unit))
            return &encodings[i];
    }
    return NULL;
}

sc_status sc_label_text_decode(const sc_ctx *ctx, const char *path, char **text, size_t *bytes)
{
    const marked_encoding *marked = find_encoding(*text, *bytes);
    char *end;
    void *to;

    if (marked && *bytes % marked->unit)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: ends within a character: it is %s, but has %zu bytes; it was cut "
                       "off, or save it as UTF-8",
                       path, marked->name, *bytes);
    if (*bytes >= 3 && !memcmp(*text, "\xef\xbb\xbf", 3)) {
        *bytes -= 3;
        memmove(*text, *text + 3, *bytes + 1);
    } else if (marked || (strlen(*text) == *bytes && is_not_utf8(*text))) {
        SC_PASS(sc_alloc(ctx, *bytes + 1, UTF8_MOST, &to));
        end = marked ? decode(*text + marked->unit, *bytes / marked->unit - 1, marked->unit,
                              marked->is_big, to)
                     : decode(*text, *bytes, 1, false, to);
        if (!marked)
            sc_info(ctx, "%s: is not UTF-8; read as Latin-1 (Windows-1252)", path);
        *end = '\0';
        sc_free(*text);
        *text = to;
        *bytes = (size_t)(end - *text);
    }
    if (strlen(*text) != *bytes)
        return sc_fail(ctx, SC_ERR_DATA, "%s: byte %zu is NUL; expected a text in UTF-8", path,
                       strlen(*text));
    return SC_OK;
}

char *sc_label_cut_line(char *line)
{
    char *next = sc_delimited_next_line(line);

    line[strcspn(line, "\r\n")] = '\0';
    return next;
}
