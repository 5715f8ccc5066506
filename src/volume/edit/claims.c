/* SPDX-License-Identifier: BSD-3-Clause */
/* Gives voxels that several segments of a file claim, in layers or in frames, to one of them. */
#include "source.h"

enum { PAIRS_MAX = 1024 /* for so many segments, voxels are counted for each two */ };

sc_status sc_claims_begin(const sc_ctx *ctx, const char *path, const sc_overlap_rule *rule,
                          sc_source *source, sc_claims *out)
{
    const int *part = source->part;
    const size_t wanted = (size_t)part[0] * (size_t)part[1] * (size_t)part[2];

    *out = (sc_claims){
        .ctx = ctx, .path = path, .rule = rule, .source = source, .rows = source->table.count};
    SC_PASS(sc_volume_memory_check(ctx, path, part, (double)wanted * sizeof *out->labels));
    SC_PASS(SC_ZALLOC(ctx, wanted, &out->labels));
    SC_PASS(SC_ZALLOC(ctx, out->rows, &out->voxels));
    if (out->rows <= PAIRS_MAX)
        SC_PASS(SC_ZALLOC(ctx, out->rows * out->rows, &out->pairs));
    return sc_overlap_count_begin(ctx, out->rows, &source->overlaps);
}

/* @return the segment in a row as one that claims a voxel. */
static sc_contender contender_of(const sc_claims *c, size_t row)
{
    const int64_t number = c->source->table.rows[row].value;

    return (sc_contender){c->voxels[row], c->by_number ? (size_t)number : row, row};
}

size_t sc_claims_settle(sc_claims *c, size_t row, size_t before)
{
    const bool wins = sc_overlap_wins(c->rule, contender_of(c, row), contender_of(c, before));
    const size_t winner = wins ? row : before, loser = wins ? before : row;

    c->source->overlaps.lost[loser] = true;
    if (c->pairs)
        c->pairs[winner * c->rows + loser]++;
    return winner;
}

sc_status sc_claims_end(sc_claims *c)
{
    sc_overlap_count *count = &c->source->overlaps;

    for (size_t i = 0; i < c->rows; i++)
        count->covers[i] = c->voxels[i] > 0;
    for (size_t i = 0; c->pairs && i < c->rows * c->rows; i++)
        SC_PASS(sc_overlap_add(c->ctx, i / c->rows, i % c->rows, c->pairs[i], count));
    sc_source_set_labels(c->source, SC_VOXEL_UINT16, c->labels);
    c->labels = NULL;
    return SC_OK;
}

void sc_claims_clear(sc_claims *claims)
{
    sc_free(claims->labels);
    sc_free(claims->voxels);
    sc_free(claims->pairs);
    *claims = (sc_claims){0};
}
