/* SPDX-License-Identifier: BSD-3-Clause */
/* Voxels that belong to several tissues: which one has them, and what the user is told. */
#include "source.h"

#include <fnmatch.h>
#include <limits.h>
#include <string.h>

/* Give all rows that the name or glob at @p name fits, and no earlier one, the rank @p rank. */
static sc_status rank_rows(const sc_ctx *ctx, const char *path, const char *name, size_t length,
                           int rank, const sc_label_table *table, int *ranks)
{
    char text[SC_NAME_BYTES], words[SC_NAME_BYTES], row[SC_NAME_BYTES];
    sc_pattern pattern;
    bool fits = false;

    snprintf(text, sizeof text, "%.*s", (int)length, name);
    pattern = sc_pattern_of(text);
    sc_words_of_name(text, words);
    for (size_t i = 0; i < table->count; i++) {
        sc_words_of_name(table->rows[i].name, row);
        if (strcmp(words, row) != 0 && fnmatch(pattern.words, row, 0) != 0)
            continue;
        fits = true;
        ranks[i] = ranks[i] < rank ? ranks[i] : rank;
    }
    if (!fits)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: overlap: no tissue is called \"%.*s\"; expected names or globs of its "
                       "masks or segments, such as \"%s\"",
                       path, (int)length, name, table->count ? table->rows[0].name : "tumour");
    return SC_OK;
}

sc_status sc_overlap_rule_make(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                               const sc_source *source, sc_overlap_rule *out)
{
    const sc_label_table *table = &source->table;
    sc_overlap_rule rule = {.overlap = choice->overlap};
    const char *name = choice->overlap_names;
    void *block;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, table->count + 1, sizeof *rule.left_out, &block));
    rule.left_out = block;
    if (choice->leave_out)
        SC_TRY(choice->leave_out(choice->user, table, source->numbered, rule.left_out));
    if (choice->overlap == SC_OVERLAP_NAMES) {
        SC_TRY(sc_alloc(ctx, table->count + 1, sizeof *rule.ranks, &block));
        rule.ranks = block;
        for (size_t i = 0; i < table->count; i++)
            rule.ranks[i] = INT_MAX;
    }
    for (int rank = 0; rule.ranks && name && *name; rank++) {
        const size_t length = strcspn(name, "\n");

        SC_TRY(rank_rows(ctx, path, name, length, rank, table, rule.ranks));
        name += length + (name[length] == '\n');
    }
    *out = rule;
    rule = (sc_overlap_rule){0};
out:
    sc_overlap_rule_clear(&rule);
    return status;
}

void sc_overlap_rule_clear(sc_overlap_rule *rule)
{
    sc_free(rule->ranks);
    sc_free(rule->left_out);
    *rule = (sc_overlap_rule){0};
}

bool sc_overlap_wins(const sc_overlap_rule *rule, sc_contender one, sc_contender other)
{
    if (rule->ranks && rule->ranks[one.row] != rule->ranks[other.row])
        return rule->ranks[one.row] < rule->ranks[other.row];
    if (rule->overlap != SC_OVERLAP_ORDER && one.voxels != other.voxels)
        return one.voxels < other.voxels;
    return one.place > other.place;
}

void sc_overlap_warn(const sc_ctx *ctx, const char *path, const char *what,
                     const sc_overlap_rule *rule, const sc_overlap_count *count,
                     const sc_label_table *table)
{
    static const struct {
        const char *shown, *name;
    } rules[] = {[SC_OVERLAP_SMALLER] = {"the smallest of them", "smaller"},
                 [SC_OVERLAP_ORDER] = {"the last of them", "order"},
                 [SC_OVERLAP_NAMES] = {"that which is named first, or else the smallest", "names"}};
    sc_text pair = {0};

    if (!count->voxels)
        return;
    if (count->most && sc_text_add(ctx, &pair, ", most often as \"%s\" and not \"%s\" (%llu)",
                                   table->rows[count->winner].name, table->rows[count->loser].name,
                                   (unsigned long long)count->most) != SC_OK)
        return; /* the allocation has told so */
    sc_warn(ctx, "%s: %llu voxel%s to several %s; each is shown as %s (overlap: %s)%s", path,
            (unsigned long long)count->voxels, count->voxels == 1 ? " belongs" : "s belong", what,
            rules[rule->overlap].shown, rules[rule->overlap].name, pair.data ? pair.data : "");
    sc_text_clear(&pair);
}
