/* SPDX-License-Identifier: BSD-3-Clause */
/* The data of pages as JSON. */
#include "internal.h"
#include "segcast/image.h"
#include "segcast/page.h"

#include <math.h>
#include <unistd.h>

enum {
    FILE_BYTES_MAX = 1 << 20, /* the largest file of settings, and how much of it is shown */
    FILE_BYTES_SHOWN = 1 << 14,
    DIGITS = 6 /* of numbers: more than anything measured has */
};

json_t *sc_json_text(const char *text)
{
    char shown[SC_REPORT_PATH_BYTES];

    (void)sc_printable(text, shown, sizeof shown);
    return json_string(shown);
}

json_t *sc_json_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

sc_status sc_json_set(const sc_ctx *ctx, json_t *data, const char *key, json_t *value)
{
    return json_object_set_new(data, key, value) == 0
               ? SC_OK
               : sc_fail(ctx, SC_ERR_MEMORY, "out of memory for the data of a page");
}

json_t *sc_json_core_time(const sc_core_time *time)
{
    json_t *json = json_pack("{s:f}", "core_s", time->core_s);

    for (int i = 0; i < SC_CAUSE_COUNT; i++)
        (void)json_object_set_new(json, sc_cause_key(i), json_real(time->causes_s[i]));
    return json;
}

/* Write @p bytes bytes in base 64 to @p out, which has room for 4 characters for every 3 of them,
 * begun ones included. */
static void encode_base64(const uint8_t *from, size_t bytes, char *out)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

    for (size_t at = 0; at < bytes; at += 3) {
        const unsigned group = (unsigned)from[at] << 16 |
                               (at + 1 < bytes ? (unsigned)from[at + 1] << 8 : 0) |
                               (at + 2 < bytes ? (unsigned)from[at + 2] : 0);

        *out++ = digits[group >> 18];
        *out++ = digits[group >> 12 & 63];
        *out++ = at + 1 < bytes ? digits[group >> 6 & 63] : '=';
        *out++ = at + 2 < bytes ? digits[group & 63] : '=';
    }
}

sc_status sc_json_png(const sc_ctx *ctx, const sc_image *image, json_t **out)
{
    SC_OWN(sc_free_at) char *data = NULL;
    size_t bytes = 0;
    SC_OWN(sc_free_at) void *text = NULL;

    SC_PASS(sc_image_compress_png(ctx, image, "a picture of the page", &data, &bytes));
    SC_PASS(sc_alloc(ctx, (bytes + 2) / 3, 4, &text));
    encode_base64((const uint8_t *)data, bytes, text);
    *out = json_stringn(text, (bytes + 2) / 3 * 4);
    return SC_OK;
}

/* @return the text of a file, without what is too long, as JSON; null if it cannot be shown. */
static json_t *file_json(const sc_ctx *ctx, const char *path)
{
    const sc_ctx looking = sc_quiet(ctx);
    json_t *json = NULL;
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes;

    if (sc_file_read(&looking, path, FILE_BYTES_MAX, &text, &bytes) == SC_OK) {
        if (bytes > FILE_BYTES_SHOWN) {
            for (bytes = FILE_BYTES_SHOWN; bytes > 0 && text[bytes] != '\n'; bytes--)
                ;
            memset(text + bytes + 1, '.', 3); /* behind the newline, to tell that there is more */
            bytes += 4;
        }
        json = json_stringn(text, bytes);
    }
    return json ? json : json_null();
}

sc_status sc_json_sources(const sc_ctx *ctx, const char *directory, const char *settings,
                          const char *const *names, size_t count, json_t *data)
{
    char path[SC_REPORT_PATH_BYTES];
    json_auto_t *files = json_array();

    snprintf(path, sizeof path, "%s/%s", directory, settings);
    SC_PASS(sc_json_set(ctx, data, "settings", file_json(ctx, path)));
    for (size_t i = 0; i < count; i++) {
        snprintf(path, sizeof path, "%s/%s", directory, names[i]);
        if (access(path, R_OK) == 0)
            files = sc_json_with(files, sc_json_text(names[i]));
    }
    return sc_json_set(ctx, data, "files", json_incref(files));
}

sc_status sc_json_page(const sc_ctx *ctx, const json_t *data, sc_text *out)
{
    SC_OWN(sc_free_at) char *text = json_dumps(data, JSON_COMPACT | JSON_REAL_PRECISION(DIGITS));

    return text ? sc_page_make(ctx, text, out)
                : sc_fail(ctx, SC_ERR_MEMORY, "out of memory for a page");
}
