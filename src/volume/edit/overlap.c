/* SPDX-License-Identifier: BSD-3-Clause */
/* Voxels that belong to several tissues: which one has them, and what the user is told. */
#include "source.h"

#include <fnmatch.h>
#include <limits.h>
#include <stdlib.h>

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
    SC_OWN(sc_overlap_rule_clear) sc_overlap_rule rule = {.overlap = choice->overlap};
    const char *name = choice->overlap_names;

    SC_PASS(SC_ZALLOC(ctx, table->count + 1, &rule.left_out));
    if (choice->leave_out)
        SC_PASS(choice->leave_out(choice->user, table, source->numbered, rule.left_out));
    if (choice->overlap == SC_OVERLAP_NAMES) {
        SC_PASS(SC_ALLOC(ctx, table->count + 1, &rule.ranks));
        for (size_t i = 0; i < table->count; i++)
            rule.ranks[i] = INT_MAX;
    }
    for (int rank = 0; rule.ranks && name && *name; rank++) {
        const size_t length = strcspn(name, "\n");

        SC_PASS(rank_rows(ctx, path, name, length, rank, table, rule.ranks));
        name += length + (name[length] == '\n');
    }
    SC_HAND_OVER(rule, out);
    return SC_OK;
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

/* ---- what is told ---- */

enum { PAIRS_LISTED_MAX = 1 << 20 };

sc_status sc_overlap_count_begin(const sc_ctx *ctx, size_t rows, sc_overlap_count *out)
{
    SC_PASS(SC_ZALLOC(ctx, rows + 1, &out->lost));
    return SC_ZALLOC(ctx, rows + 1, &out->covers);
}

sc_status sc_overlap_add(const sc_ctx *ctx, size_t winner, size_t loser, uint64_t voxels,
                         sc_overlap_count *count)
{
    sc_overlap_list *list = &count->pairs;

    if (!voxels || list->count == PAIRS_LISTED_MAX)
        return SC_OK;
    SC_PASS(SC_GROW(ctx, list->count, &list->capacity, &list->pairs));
    list->pairs[list->count++] = (sc_overlap_pair){winner, loser, voxels};
    count->lost[loser] = true;
    return SC_OK;
}

void sc_overlap_list_clear(sc_overlap_list *list)
{
    sc_free(list->pairs);
    sc_label_table_clear(&list->tissues);
    *list = (sc_overlap_list){0};
}

void sc_overlap_count_clear(sc_overlap_count *count)
{
    sc_free(count->lost);
    sc_free(count->covers);
    sc_overlap_list_clear(&count->pairs);
    *count = (sc_overlap_count){0};
}

/* Warn of tissues of which nothing is left because others cover them. */
static sc_status warn_of_covered(const sc_ctx *ctx, const char *path, const sc_source *source,
                                 const sc_volume *volume)
{
    const sc_label_table *table = &source->table;
    SC_OWN(sc_text_clear) sc_text names = {0};
    size_t covered = 0;

    for (size_t i = 0; source->overlaps.lost && i < table->count; i++) {
        if (source->overlaps.lost[i] && !sc_volume_label(volume, table->rows[i].value))
            SC_PASS(sc_label_list_add(ctx, &names, covered++, &table->rows[i]));
    }
    if (covered)
        sc_warn(ctx,
                "%s: nothing is shown of %zu tissue%s, all of whose voxels belong to others, too: "
                "%s; `overlap: [NAME, ...]` shows those first that it names",
                path, covered, covered == 1 ? "" : "s", names.data);
    return SC_OK;
}

sc_status sc_overlap_warn(const sc_ctx *ctx, const char *path, const sc_source *source,
                          const sc_overlap_rule *rule, const sc_volume *volume)
{
    static const struct {
        const char *shown, *name;
    } rules[] = {[SC_OVERLAP_SMALLER] = {"the smallest of them", "smaller"},
                 [SC_OVERLAP_ORDER] = {"the last of them", "order"},
                 [SC_OVERLAP_NAMES] = {"that which is named first, or else the smallest", "names"}};
    const sc_overlap_count *count = &source->overlaps;
    const sc_overlap_pair *most = count->pairs.pairs;
    SC_OWN(sc_text_clear) sc_text pair = {0};

    if (!count->voxels)
        return SC_OK;
    SC_PASS(warn_of_covered(ctx, path, source, volume));
    for (size_t i = 0; i < count->pairs.count; i++)
        most = count->pairs.pairs[i].voxels > most->voxels ? &count->pairs.pairs[i] : most;
    if (most)
        SC_PASS(sc_text_add(ctx, &pair, ", most often as \"%s\" and not \"%s\" (%llu)",
                            source->table.rows[most->winner].name,
                            source->table.rows[most->loser].name,
                            (unsigned long long)most->voxels));
    sc_warn(ctx, "%s: %llu voxel%s to several %s; each is shown as %s (overlap: %s)%s", path,
            (unsigned long long)count->voxels, count->voxels == 1 ? " belongs" : "s belong",
            source->mask_files.count ? "masks" : "segments", rules[rule->overlap].shown,
            rules[rule->overlap].name, pair.data ? pair.data : "");
    return SC_OK;
}

/* For qsort of sc_overlap_pair: most voxels first, then in the order of the rows. */
static int by_voxels(const void *a, const void *b)
{
    const sc_overlap_pair *x = a, *y = b;

    if (x->voxels != y->voxels)
        return (y->voxels > x->voxels) - (y->voxels < x->voxels);
    if (x->winner != y->winner)
        return (x->winner > y->winner) - (x->winner < y->winner);
    return (x->loser > y->loser) - (x->loser < y->loser);
}

sc_status sc_overlap_list_take(const sc_ctx *ctx, sc_source *source, sc_overlap_list *out)
{
    SC_OWN(sc_overlap_list_clear) sc_overlap_list list = source->overlaps.pairs;

    source->overlaps.pairs = (sc_overlap_list){0};
    for (size_t i = 0; list.count && i < source->table.count; i++)
        SC_PASS(sc_label_table_add(ctx, &list.tissues, &source->table.rows[i]));
    if (list.count)
        qsort(list.pairs, list.count, sizeof *list.pairs, by_voxels);
    sc_overlap_list_clear(out);
    SC_HAND_OVER(list, out);
    return SC_OK;
}
