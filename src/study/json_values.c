/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/json_values.h"

#include <errno.h>
#include <stdlib.h>

#define REAL_MOST 1e15

bool sc_json_int(const json_t *value, json_int_t low, json_int_t high, int32_t *out)
{
    const json_int_t number = json_integer_value(value);

    if (!json_is_integer(value) || number < low || number > high)
        return false;
    *out = (int32_t)number;
    return true;
}

bool sc_json_count(const json_t *value, uint64_t *out)
{
    *out = (uint64_t)json_integer_value(value);
    return json_is_integer(value) && json_integer_value(value) >= 0;
}

bool sc_json_real(const json_t *value, double low, double most, double *out)
{
    *out = json_number_value(value);
    return json_is_number(value) && *out >= low && *out < most;
}

bool sc_json_hash(const json_t *value, uint64_t *out)
{
    const char *text = json_string_value(value);

    if (!text || strlen(text) != 16 || strspn(text, "0123456789abcdef") != 16)
        return false;
    *out = strtoull(text, NULL, 16);
    return true;
}

json_t *sc_json_of_hash(uint64_t hash)
{
    return json_sprintf("%016llx", (unsigned long long)hash);
}

json_t *sc_json_of_row(const sc_json_row *row, const void *from)
{
    const void *at = (const char *)from + row->offset;
    char valid[256]; /* texts of the system need not be UTF-8 */

    switch (row->kind) {
    case SC_JSON_BOOL:
        return json_boolean(*(const bool *)at);
    case SC_JSON_INT:
        return json_integer(*(const int32_t *)at);
    case SC_JSON_COUNT:
        return json_integer((json_int_t) * (const uint64_t *)at);
    case SC_JSON_TIME:
        return json_integer(*(const int64_t *)at);
    case SC_JSON_HASH:
        return sc_json_of_hash(*(const uint64_t *)at);
    case SC_JSON_TEXT:
        (void)sc_copy_name(at, valid, row->bytes < sizeof valid ? row->bytes : sizeof valid);
        return valid[0] ? json_string(valid) : json_null();
    case SC_JSON_SECONDS:
    case SC_JSON_REAL:
        break;
    }
    return json_real(*(const double *)at);
}

json_t *sc_json_of_rows(const sc_json_row *rows, const void *from)
{
    json_t *json = json_object();

    for (; rows->key && json; rows++)
        json = sc_json_with_key(json, rows->key, sc_json_of_row(rows, from));
    return json;
}

/* Read a text into out[size]; null, or none, is an empty one. */
static bool read_text(const json_t *value, char *out, size_t size)
{
    const char *text = json_string_value(value);

    out[0] = '\0';
    if (!text)
        return !value || json_is_null(value);
    if (strlen(text) >= size || strlen(text) != json_string_length(value))
        return false; /* segcast has not written this */
    strcpy(out, text);
    return true;
}

bool sc_json_read_row(const sc_json_row *row, const json_t *value, void *to)
{
    void *at = (char *)to + row->offset;

    switch (row->kind) {
    case SC_JSON_BOOL:
        *(bool *)at = json_is_true(value);
        return json_is_boolean(value);
    case SC_JSON_INT:
        return sc_json_int(value, 0, INT32_MAX, at);
    case SC_JSON_COUNT:
        return sc_json_count(value, at);
    case SC_JSON_TIME:
        *(int64_t *)at = json_integer_value(value);
        return json_is_integer(value) && json_integer_value(value) >= 0;
    case SC_JSON_HASH:
        return sc_json_hash(value, at);
    case SC_JSON_TEXT:
        return read_text(value, at, row->bytes);
    case SC_JSON_SECONDS:
    case SC_JSON_REAL:
        break;
    }
    return sc_json_real(value, row->kind == SC_JSON_REAL ? -1 : 0, REAL_MOST, at);
}

bool sc_json_read_rows(const sc_json_row *rows, const json_t *object, void *to)
{
    bool good = json_is_object(object);

    for (; rows->key && good; rows++)
        good = sc_json_read_row(rows, json_object_get(object, rows->key), to);
    return good;
}

/* @return @p to, or NULL, with it freed, if something failed. */
static json_t *kept(json_t *to, int failed)
{
    if (!failed)
        return to;
    json_decref(to);
    return NULL;
}

json_t *sc_json_with(json_t *to, json_t *item)
{
    return kept(to, json_array_append_new(to, item));
}

json_t *sc_json_with_key(json_t *to, const char *key, json_t *item)
{
    return kept(to, json_object_set_new(to, key, item));
}

sc_status sc_json_add_text(const sc_ctx *ctx, json_t *json, size_t flags, const char *what,
                           sc_text *out)
{
    SC_OWN(sc_free_at) char *text = NULL;

    errno = 0;
    text = json ? json_dumps(json, flags) : NULL;
    json_decref(json);
    if (!text || errno == ENOMEM)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", what);
    return sc_text_add(ctx, out, "%s\n", text);
}
