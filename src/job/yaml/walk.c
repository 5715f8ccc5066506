/* SPDX-License-Identifier: BSD-3-Clause */
/* Walking the table of keys, and what a listing says of one row. */
#include "describe.h"

/* Visit the rows of @p keys and those of their maps, but those of shots that are as in the file,
 * which come last. @param path the path of the map that holds the
 * keys; it is extended during the walk, and restored when this returns SC_OK. */
static sc_status walk(const sc_ctx *ctx, const sc_key *keys, sc_text *path, int depth,
                      sc_key_visitor *visitor, void *user)
{
    static const char *const steps[] = {[SC_CONTAINER_NONE] = "",
                                        [SC_CONTAINER_MAP] = "",
                                        [SC_CONTAINER_LIST] = ".N",
                                        [SC_CONTAINER_DICT] = ".NAME"};
    const size_t length = path->length_bytes;

    for (; keys->name && !keys->scope.of_job; keys++) {
        sc_key_visit visit = {.key = keys, .depth = depth};

        SC_PASS(sc_text_add(ctx, path, "%s%s", length ? "." : "", keys->name));
        visit.path = path->data;
        SC_PASS(visitor(ctx, user, &visit));
        if (keys->keys) {
            SC_PASS(sc_text_add(ctx, path, "%s", steps[keys->type->container]));
            SC_PASS(walk(ctx, keys->keys, path, depth + 1, visitor, user));
        }
        path->length_bytes = length;
        path->data[length] = '\0';
    }
    return SC_OK;
}

sc_status sc_keys_walk(const sc_ctx *ctx, sc_key_visitor *visitor, void *user)
{
    SC_OWN(sc_text_clear) sc_text path = {0};

    return walk(ctx, sc_job_keys, &path, 0, visitor, user);
}

typedef struct info_visitor {
    sc_status (*visit)(void *user, const sc_key_info *info);
    void *user;
} info_visitor;

/* Give a row to the visitor of sc_job_each_key as an sc_key_info. */
static sc_status visit_info(const sc_ctx *ctx, void *user, const sc_key_visit *visit)
{
    const info_visitor *v = user;
    const sc_key *key = visit->key;
    const sc_key_info info = {.path = visit->path,
                              .help = key->help,
                              .option = key->option ? key->option->name : NULL,
                              .argument = key->option ? key->option->argument : NULL,
                              .commands = key->option ? key->option->commands : NULL,
                              .is_value = !key->keys || key->shorthand.key};

    return v->visit(v->user, &info);
}

sc_status sc_job_each_key(const sc_ctx *ctx,
                          sc_status (*visit)(void *user, const sc_key_info *info), void *user)
{
    info_visitor v = {visit, user};

    return sc_keys_walk(ctx, visit_info, &v);
}

/* ---- parts of a listing ---- */

/* @return word number @p i of a choice; NULL after the last, or after the last that is listed:
 * other words for values that have one follow. */
static const char *listed_word(const sc_key *key, size_t i)
{
    if (key->words)
        return key->words[i];
    for (size_t k = 0; k < i && key->choices[i].word; k++) {
        if (key->choices[k].value == key->choices[i].value)
            return NULL;
    }
    return key->choices[i].word;
}

/* Append the words of a choice: "none, interior or leap". */
static sc_status add_words(const sc_ctx *ctx, const sc_key *key, sc_text *text)
{
    const char *word;
    sc_status status = SC_OK;

    for (size_t i = 0; status == SC_OK && (word = listed_word(key, i)) != NULL; i++)
        status = sc_text_add(ctx, text, "%s%s",
                             i == 0                    ? ""
                             : listed_word(key, i + 1) ? ", "
                                                       : " or ",
                             word);
    return status;
}

sc_status sc_key_values(const sc_ctx *ctx, const sc_key *key, sc_text *text)
{
    if (key->words || key->choices)
        return add_words(ctx, key, text);
    SC_PASS(sc_text_add(ctx, text, "%s", key->type->name));
    if (key->high > key->low && key->high < 1e6)
        SC_PASS(sc_text_add(ctx, text, " from %g to %g", key->low, key->high));
    if (key->unit)
        SC_PASS(sc_text_add(ctx, text, ", %s", key->unit));
    return SC_OK;
}

const char *sc_key_default(const sc_key *key)
{
    if (key->required)
        return key->alternative ? "(one of these)" : "(required)";
    if (key->fallback)
        return key->fallback;
    return key->without ? key->without : "";
}
