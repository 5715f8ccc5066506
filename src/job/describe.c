/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of keys in every format: for people at a terminal, as JSON and as a JSON schema;
 * documents are made by document.c. */
#include "describe.h"

#include <ctype.h>
#include <stdlib.h>

enum { PATH_BYTES = 256 };

static bool has_prefix(const char *path, const char *prefix)
{
    return !prefix || !strncmp(path, prefix, strlen(prefix));
}

void sc_key_variable(const char *path, char *name, size_t size)
{
    snprintf(name, size, "SEGCAST_%s", path);
    if (strstr(path, ".NAME."))
        name[0] = '\0';
    for (; *name; name++)
        *name = (char)(*name == '.' ? '_' : toupper((unsigned char)*name));
}

/* ---- for people ---- */

/* A listing that is being made. */
typedef struct listing {
    const char *prefix; /* of the paths to be listed; NULL: all */
    sc_text *text;      /* lines for people are appended here */
    json_t *array;      /* objects for machines are appended here */
    size_t count;       /* rows listed so far */
} listing;

/* Append @p text to the listing, cut at a blank to fit into @p width characters. */
static sc_status add_cut(const sc_ctx *ctx, const char *text, size_t width, sc_text *out)
{
    size_t length = strlen(text);

    if (length <= width)
        return sc_text_add(ctx, out, "%s", text);
    for (length = width - 4; length > 1 && text[length] != ' '; length--)
        continue;
    length -= text[length - 1] == ',' || text[length - 1] == ';' || text[length - 1] == ':';
    return sc_text_add(ctx, out, "%.*s ...", (int)length, text);
}

/* Append a row as one line of text: its name in its section, its default, and the beginning of its
 * help. A map at the top of the file begins a section. */
static sc_status add_short_row(const sc_ctx *ctx, void *user, const sc_key_visit *visit)
{
    enum { NAME = 27, DEFAULT = 17, HELP = 66 };
    listing *l = user;
    const sc_key *key = visit->key;
    const char *name = strchr(visit->path, '.');
    SC_OWN(sc_text_clear) sc_text value = {0};

    l->count++;
    if (!visit->depth && key->keys) {
        SC_PASS(sc_text_add(ctx, l->text, "%s: ", key->name));
        SC_PASS(add_cut(ctx, key->help, NAME + DEFAULT + HELP, l->text));
        return sc_text_add(ctx, l->text, "\n");
    }
    if (key->keys && key->type->container == SC_CONTAINER_MAP && !key->fallback &&
        !key->shorthand.key)
        return SC_OK; /* its keys say all */
    SC_PASS(add_cut(ctx, sc_key_default(key), DEFAULT, &value));
    SC_PASS(sc_text_add(ctx, l->text, "%s%-*s %-*s ", name ? "  " : "", name ? NAME : NAME + 2,
                        name ? name + 1 : visit->path, DEFAULT, value.data ? value.data : ""));
    SC_PASS(add_cut(ctx, key->help, HELP, l->text));
    return sc_text_add(ctx, l->text, "\n");
}

/* Append a row as lines of text to the listing, if its path begins with the prefix. */
static sc_status add_text_row(const sc_ctx *ctx, void *user, const sc_key_visit *visit)
{
    listing *l = user;
    const sc_key *key = visit->key;
    const char *value = sc_key_default(key);

    if (!has_prefix(visit->path, l->prefix))
        return SC_OK;
    l->count++;
    SC_PASS(sc_text_add(ctx, l->text, "%s\n    %s\n    ", visit->path, key->help));
    SC_PASS(sc_key_values(ctx, key, l->text));
    if (value[0])
        SC_PASS(sc_text_add(ctx, l->text, key->required ? " %s" : "; default: %s", value));
    if (key->option)
        SC_PASS(
            sc_text_add(ctx, l->text, "; also --%s %s", key->option->name, key->option->argument));
    return sc_text_add(ctx, l->text, "\n");
}

/* ---- for machines ---- */

/* Append a row as an object to the array of the listing, if its path begins with the prefix. */
static sc_status add_json_row(const sc_ctx *ctx, void *user, const sc_key_visit *visit)
{
    listing *l = user;
    const sc_key *key = visit->key;
    char variable[PATH_BYTES + 16];
    SC_OWN(sc_text_clear) sc_text values = {0};
    json_t *row;

    if (!has_prefix(visit->path, l->prefix))
        return SC_OK;
    l->count++;
    sc_key_variable(visit->path, variable, sizeof variable);
    SC_PASS(sc_key_values(ctx, key, &values));
    row = json_pack("{s:s, s:s, s:s, s:s?, s:s?, s:s?, s:b, s:b, s:s?, s:s?, s:s}", "key",
                    visit->path, "help", key->help, "values", values.data, "default", key->fallback,
                    "without", key->without, "unit", key->unit, "required", key->required,
                    "changes_pictures", !key->scope.outside_identity, "option",
                    key->option ? key->option->name : NULL, "commands",
                    key->option ? key->option->commands : NULL, "environment", variable);
    if (row && key->high > key->low) {
        json_object_set_new(row, "minimum", json_real(key->low));
        json_object_set_new(row, "maximum", json_real(key->high));
    }
    if (!row || json_array_append_new(l->array, row))
        return sc_fail(ctx, SC_ERR_MEMORY, "out of memory");
    return SC_OK;
}

/* Append @p json as text to @p out. Takes ownership of @p json. */
static sc_status print_json(const sc_ctx *ctx, json_t *json, sc_text *out)
{
    char *text = json ? json_dumps(json, JSON_INDENT(2) | JSON_REAL_PRECISION(12)) : NULL;
    sc_status status =
        text ? sc_text_add(ctx, out, "%s\n", text) : sc_fail(ctx, SC_ERR_MEMORY, "out of memory");

    free(text);
    json_decref(json);
    return status;
}

/* Append the JSON schema of a whole file, which has these keys. */
static sc_status write_schema(const sc_ctx *ctx, const sc_key *keys, const char *title,
                              sc_text *out)
{
    json_t *schema = sc_keys_schema(keys);

    json_object_set_new(schema, "$schema", json_string("http://json-schema.org/draft-07/schema#"));
    json_object_set_new(schema, "title", json_string(title));
    return print_json(ctx, schema, out);
}

/* Append all rows whose path begins with @p prefix, as text or as JSON; without one as a short
 * text. @return SC_ERR_USAGE if there is none. */
static sc_status list_keys(const sc_ctx *ctx, const char *prefix, sc_keys_format format,
                           sc_text *out)
{
    listing l = {.prefix = prefix, .text = out};
    const bool as_json = format == SC_KEYS_JSON;
    sc_status status;

    l.array = as_json ? json_array() : NULL;
    status = sc_keys_walk(ctx, as_json ? add_json_row : prefix ? add_text_row : add_short_row, &l);
    if (status == SC_OK && l.count == 0)
        status =
            sc_fail(ctx, SC_ERR_USAGE,
                    "no key is \"%s\" or begins with it; `segcast help keys` lists all", prefix);
    if (status == SC_OK && as_json)
        return print_json(ctx, l.array, out);
    json_decref(l.array);
    return status;
}

sc_status sc_keys_describe(const sc_ctx *ctx, const char *prefix, sc_keys_format format,
                           sc_text *out)
{
    switch (format) {
    case SC_KEYS_SCHEMA:
        return write_schema(ctx, sc_job_keys, "segcast job", out);
    case SC_KEYS_STUDY:
        return write_schema(ctx, sc_study_keys, "segcast study", out);
    case SC_KEYS_MARKDOWN:
        return sc_keys_markdown(ctx, out);
    case SC_KEYS_MAN:
        return sc_keys_man(ctx, out);
    case SC_KEYS_TABLE:
    case SC_KEYS_JSON:
        break;
    }
    return list_keys(ctx, prefix, format, out);
}
