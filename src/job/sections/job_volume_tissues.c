/* SPDX-License-Identifier: BSD-3-Clause */
/* The tissues of a job's volume that are kept, and those that are merged into one. */
#include "key.h"
#include "segcast/job.h"

/* Make room for @p more tissues. */
static sc_status grow(const sc_ctx *ctx, sc_job *job, size_t more)
{
    return SC_RESIZE(ctx, job->volume.tissue_count, job->volume.tissue_count + more,
                     &job->volume.tissues);
}

/* Read a tissue or a list of some to place *at and behind it, for which there is room. @param into
 * as of sc_volume_tissue. @return the first mistake; all are logged. */
static sc_status read_list(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                           const char *into, sc_job *job, size_t *at)
{
    const size_t count = sc_yaml_length(node);
    sc_status status = SC_OK;

    if (node->kind == SC_YAML_MAP || !count)
        return sc_wrong_type(ctx, node, key->type->expected);
    for (size_t i = 0; i < count; i++) {
        const sc_yaml item = sc_yaml_item(node, i);
        sc_volume_tissue *to = &job->volume.tissues[*at];
        const sc_status found = sc_read_tissue(ctx, key, &item, to->pattern, to->where);

        strcpy(to->into, into);
        *at += found == SC_OK;
        if (!sc_goes_on(&status, found))
            break;
    }
    return status;
}

/* Append the tissues from *i on that become parts of the same one, as a list. *i becomes the index
 * of the first that does not. */
static sc_status write_list(const sc_ctx *ctx, const sc_job *job, size_t *i, sc_text *text)
{
    const sc_volume_tissue *all = job->volume.tissues, *first = &all[*i];
    const char *comma = "[";

    for (; *i < job->volume.tissue_count && !strcmp(all[*i].into, first->into); ++*i)
        SC_PASS(sc_write_item(ctx, &comma, all[*i].pattern, text));
    return sc_text_add(ctx, text, "]");
}

/* @p value is the whole sc_job, as of all types of this file. */
static sc_status read_keep(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_job *job = value;

    SC_PASS(grow(ctx, job, sc_yaml_length(node)));
    return read_list(ctx, key, node, "", job, &job->volume.tissue_count);
}

/* @return the index of the first tissue that is kept. */
static size_t first_kept(const sc_job *job)
{
    size_t i = 0;

    while (i < job->volume.tissue_count && job->volume.tissues[i].into[0])
        i++;
    return i;
}

static sc_status write_keep(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    size_t i = first_kept(value);

    return write_list(ctx, value, &i, text);
}

#define KEPT_SCHEMA                                                                                \
    "{anyOf: [{type: integer}, {type: [string, array], minItems: 1, items: {type: [string, "       \
    "integer]}}]}"

const sc_value_type sc_type_kept_tissues = {
    .name = "tissues",
    .expected = "a list of tissues: names, globs or label numbers",
    .read = read_keep,
    .write = write_keep,
    .schema = KEPT_SCHEMA,
};

/* Read the map of merged tissues to place *at and behind it, for which there is room. */
static sc_status read_merged(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, sc_job *job,
                             size_t *at)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < node->count; i++) {
        const sc_yaml *item = node->items[i];

        if (!item->key[0] || strlen(item->key) >= SC_NAME_BYTES)
            return sc_yaml_fail(ctx, item,
                                "the name of a merged tissue has %zu bytes, expected 1 to %d",
                                strlen(item->key), SC_NAME_BYTES - 1);
        if (sc_pattern_of(item->key).is_number)
            return sc_yaml_fail(ctx, item,
                                "the name of a merged tissue is the number %s, which means the "
                                "tissue with that label; expected a name",
                                item->key);
        if (!sc_goes_on(&status, read_list(ctx, key, item, item->key, job, at)))
            break;
    }
    return status;
}

/* Tissues that are kept stand behind those that are merged: they make room, all at once. */
static sc_status read_merge(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_job *job = value;
    const size_t begin = first_kept(job), kept = job->volume.tissue_count - begin;
    size_t at = begin, most = 0;
    sc_volume_tissue *behind;
    sc_status status = SC_OK;

    if (node->kind != SC_YAML_MAP || !node->count)
        return sc_wrong_type(ctx, node, key->type->expected);
    for (size_t i = 0; i < node->count; i++)
        most += sc_yaml_length(node->items[i]);
    SC_PASS(grow(ctx, job, most));
    behind = job->volume.tissues + begin + most;
    memmove(behind, job->volume.tissues + begin, kept * sizeof *behind);
    status = read_merged(ctx, key, node, job, &at);
    memmove(job->volume.tissues + at, behind, kept * sizeof *behind);
    job->volume.tissue_count = at + kept;
    return status;
}

static sc_status write_merge(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const sc_job *job = value;
    const size_t end = first_kept(job);
    const char *comma = "{";

    for (size_t i = 0; i < end;) {
        SC_PASS(sc_write_item(ctx, &comma, job->volume.tissues[i].into, text));
        SC_PASS(sc_text_add(ctx, text, ": "));
        SC_PASS(write_list(ctx, job, &i, text));
    }
    return sc_text_add(ctx, text, "}");
}

const sc_value_type sc_type_merged_tissues = {
    .name = "map of lists of tissues",
    .expected =
        "{name: [tissues], ...}: names, globs or label numbers under the name of what they become",
    .read = read_merge,
    .write = write_merge,
    .schema = "{type: object, minProperties: 1, additionalProperties: " KEPT_SCHEMA "}",
};

/* ---- overlaps ---- */

static const char *const overlap_words[] = {"smaller", "order"}; /* as sc_overlap */

/* Add a name of @p length bytes to job->volume.overlap_names, of which *used are used. @return
 * whether it is one, and there is room. */
static bool add_overlap_name(sc_job *job, const char *name, size_t length, size_t *used)
{
    if (!length || memchr(name, '\n', length) ||
        *used + length + 2 > sizeof job->volume.overlap_names)
        return false;
    memcpy(job->volume.overlap_names + *used, name, length);
    *used += length;
    memcpy(job->volume.overlap_names + (*used)++, "\n", 2);
    return true;
}

/* Read "[a, b]", as an option has it. @return whether it is such a list. */
static bool read_overlap_text(sc_job *job, const char *text, size_t *used)
{
    if (*text++ != '[')
        return false;
    for (;;) {
        const char *end, *begin = text + strspn(text, " ");
        const char quote = *begin == '"' || *begin == '\'' ? *begin : '\0';
        size_t length;

        begin += quote != '\0';
        length = strcspn(begin, quote == '"' ? "\"" : quote ? "'" : ",]");
        end = begin + length + (quote && begin[length]);
        while (!quote && length && begin[length - 1] == ' ')
            length--;
        end += strspn(end, " ");
        if (!add_overlap_name(job, begin, length, used))
            return false;
        if (*end != ',')
            return !strcmp(end, "]");
        text = end + 1;
    }
}

/* Read a word, or a list of names into job->volume.overlap_names. */
static sc_status read_overlap(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                              void *value)
{
    sc_job *job = value;
    size_t used = 0;

    for (int i = 0; i < 2 && node->kind == SC_YAML_SCALAR; i++) {
        if (!strcmp(node->text, overlap_words[i])) {
            job->volume.overlap = i;
            job->volume.overlap_names[0] = '\0';
            return SC_OK;
        }
    }
    if (node->kind == SC_YAML_SCALAR ? !read_overlap_text(job, node->text, &used)
                                     : node->kind != SC_YAML_LIST || !node->count)
        return sc_wrong_type(ctx, node, key->type->expected);
    for (size_t i = 0; i < node->count && node->kind == SC_YAML_LIST; i++) {
        const sc_yaml named = sc_yaml_item(node, i);

        if (named.kind != SC_YAML_SCALAR)
            return sc_wrong_type(ctx, &named, key->type->expected);
        if (!add_overlap_name(job, named.text, strlen(named.text), &used))
            return sc_wrong_type(ctx, &named, "names of 1023 bytes together at most");
    }
    job->volume.overlap = SC_OVERLAP_NAMES;
    return SC_OK;
}

static sc_status write_overlap(const sc_ctx *ctx, const sc_key *key, const void *value,
                               sc_text *text)
{
    const sc_job *job = value;
    char name[SC_OVERLAP_NAMES_BYTES];
    const char *comma = "[";

    if (job->volume.overlap != SC_OVERLAP_NAMES)
        return sc_text_add(ctx, text, "%s", overlap_words[job->volume.overlap]);
    for (const char *at = job->volume.overlap_names; *at; at += strlen(name) + 1) {
        snprintf(name, sizeof name, "%.*s", (int)strcspn(at, "\n"), at);
        SC_PASS(sc_write_item(ctx, &comma, name, text));
    }
    return sc_text_add(ctx, text, "]");
}

const sc_value_type sc_type_overlap = {
    .name = "smaller, order, or names",
    .expected = "smaller, order, or a list of tissues: [tumour, \"*artery\"]",
    .read = read_overlap,
    .write = write_overlap,
    .schema =
        "{anyOf: [{enum: [smaller, order]}, {type: array, minItems: 1, items: {type: string}}]}",
};
