/* SPDX-License-Identifier: BSD-3-Clause */
/* Text from files: what of it is UTF-8, and what a terminal would obey. */
#include "segcast/base.h"

#include <unistd.h>

size_t sc_utf8_bytes(const char *text)
{
    const unsigned char *c = (const unsigned char *)text;
    /* The shortest form and the end of Unicode bound the second byte behind some first bytes
     * (Unicode 15, table 3-7). */
    const unsigned char low = c[0] == 0xe0 ? 0xa0 : c[0] == 0xf0 ? 0x90 : 0x80;
    const unsigned char high = c[0] == 0xed ? 0x9f : c[0] == 0xf4 ? 0x8f : 0xbf;
    size_t bytes = 1;

    if (c[0] == 0)
        return 0;
    if (c[0] < 0x80)
        return 1;
    if (c[0] < 0xc2 || c[0] > 0xf4 || c[1] < low || c[1] > high)
        return 0;
    for (bytes = 2; bytes < (c[0] < 0xe0 ? 2u : c[0] < 0xf0 ? 3u : 4u); bytes++) {
        if ((c[bytes] & 0xc0) != 0x80)
            return 0;
    }
    return bytes;
}

unsigned sc_utf8_code(const char *text, size_t bytes)
{
    unsigned code = (unsigned char)text[0];

    if (bytes > 1)
        code &= 0xffu >> (bytes + 1);
    for (size_t i = 1; i < bytes; i++)
        code = code << 6 | ((unsigned char)text[i] & 0x3f);
    return code;
}

/* The second set of control characters, U+0080 to U+009F, begins escape sequences in one byte. */
bool sc_is_control(unsigned code)
{
    return code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x061c || code == 0x200e ||
           code == 0x200f || (code >= 0x2028 && code <= 0x202e) ||
           (code >= 0x2066 && code <= 0x2069);
}

/* Write what is shown of the character that begins at *at to @p out, which has room for 9 bytes,
 * and move *at behind it: the character itself, or \\x and two digits for a byte, or \\u and four
 * for a character of several bytes. @return how many bytes were written. */
static size_t show(const char **at, char *out)
{
    const size_t bytes = sc_utf8_bytes(*at);
    const unsigned code = sc_utf8_code(*at, bytes ? bytes : 1);
    const char *from = *at;

    *at += bytes ? bytes : 1;
    if (bytes && !sc_is_control(code)) {
        memcpy(out, from, bytes);
        return bytes;
    }
    return (size_t)snprintf(out, 9, bytes > 1 ? "\\u%04x" : "\\x%02x",
                            bytes > 1 ? code : (unsigned char)*from);
}

size_t sc_printable(const char *text, char *out, size_t size)
{
    size_t used = 0;
    bool fits = size > 0;

    if (fits)
        out[0] = '\0';
    while (*text) {
        char shown[9];
        const size_t count = show(&text, shown);

        fits = fits && used + count < size;
        if (fits) {
            memcpy(out + used, shown, count);
            out[used + count] = '\0';
        }
        used += count;
    }
    return used;
}

void sc_print(FILE *stream, const char *text)
{
    while (*text) {
        char shown[9];
        const size_t count = show(&text, shown);

        fwrite(shown, 1, count, stream);
    }
}

void sc_print_path(FILE *stream, const char *path)
{
    if (isatty(fileno(stream)))
        sc_print(stream, path);
    else
        fputs(path, stream);
}

bool sc_copy_name(const char *from, char *out, size_t size)
{
    static const char replacement[] = "\xef\xbf\xbd"; /* U+FFFD */
    size_t used = 0;
    bool whole = true;

    while (*from) {
        const size_t bytes = sc_utf8_bytes(from);
        const unsigned code = sc_utf8_code(from, bytes ? bytes : 1);
        const bool control = bytes && (code < 0x20 || (code >= 0x7f && code < 0xa0));
        const char *to = bytes ? control ? " " : from : replacement;
        const size_t count = bytes ? control ? 1 : bytes : sizeof replacement - 1;

        whole = whole && bytes;
        if (used + count >= size) {
            whole = false;
            break;
        }
        memcpy(out + used, to, count);
        used += count;
        from += bytes ? bytes : 1;
    }
    out[used] = '\0';
    return whole;
}
