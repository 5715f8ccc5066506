/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/json_values.h"

#include <errno.h>
#include <stdlib.h>

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
