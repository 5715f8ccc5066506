/* SPDX-License-Identifier: BSD-3-Clause */
/* The prepared volume as one block: a header, then sections at 64-byte boundaries. */
#include "internal.h"

#include <string.h>

enum { ALIGN_BYTES = 64, SECTIONS = 7 };

static const char magic[8] = "segcprep";

typedef struct block_header {
    char magic[8];
    uint32_t version, header_bytes;
    int32_t size[3], bricks[3];
    int32_t label_bytes, label_count, oriented, local_thickness;
    sc_affine to_ras_mm;
    uint64_t volume_hash, boundary_count, near_count, total_bytes;
    uint64_t offset[SECTIONS]; /* ids, labels, stats, near, near_start, records, thickness */
} block_header;

static uint64_t aligned(uint64_t bytes)
{
    return (bytes + ALIGN_BYTES - 1) / ALIGN_BYTES * ALIGN_BYTES;
}

static block_header layout(const sc_preparation *p, uint64_t bytes[SECTIONS])
{
    const sc_volume *v = p->volume;
    block_header h = {.version = 2, .header_bytes = sizeof h};

    memcpy(h.magic, magic, sizeof magic);
    memcpy(h.size, v->size, sizeof h.size);
    memcpy(h.bricks, p->bricks, sizeof h.bricks);
    h.label_bytes = v->label_bytes;
    h.label_count = v->label_count;
    h.oriented = v->oriented;
    h.local_thickness = p->thickness != NULL;
    h.to_ras_mm = v->to_ras_mm;
    h.volume_hash = p->volume_hash;
    h.boundary_count = p->boundary_count;
    h.near_count = p->near_count;
    bytes[0] = sc_volume_voxels(v) * (uint64_t)v->label_bytes;
    bytes[1] = (uint64_t)v->label_count * sizeof(sc_label);
    bytes[2] = (uint64_t)v->label_count * sizeof(sc_label_stats);
    bytes[3] = p->brick_count * sizeof(uint64_t);
    bytes[4] = p->brick_count * sizeof(uint32_t);
    bytes[5] = p->near_count * SC_RECORD_BYTES;
    bytes[6] = p->thickness ? p->near_count : 0;
    h.total_bytes = aligned(sizeof h);
    for (int i = 0; i < SECTIONS; i++) {
        h.offset[i] = h.total_bytes;
        h.total_bytes += aligned(bytes[i] + SC_GATHER_BYTES);
    }
    return h;
}

size_t sc_preparation_bytes(const sc_preparation *preparation)
{
    uint64_t bytes[SECTIONS];

    return layout(preparation, bytes).total_bytes;
}

void sc_preparation_pack(const sc_preparation *p, void *block)
{
    uint64_t bytes[SECTIONS];
    const block_header h = layout(p, bytes);
    const void *const sources[SECTIONS] = {p->volume->ids, p->volume->labels, p->stats,    p->near,
                                           p->near_start,  p->records,        p->thickness};

    memcpy(block, &h, sizeof h);
    for (int i = 0; i < SECTIONS; i++) {
        if (bytes[i])
            memcpy((char *)block + h.offset[i], sources[i], bytes[i]);
    }
}

sc_status sc_prepared_view(const sc_ctx *ctx, const void *block, size_t bytes, sc_prepared *out)
{
    const block_header *h = block;
    const char *base = block;
    sc_prepared view;

    if (bytes < sizeof *h || memcmp(h->magic, magic, sizeof magic) || h->version != 2 ||
        h->header_bytes != sizeof *h || h->total_bytes > bytes)
        return sc_fail(ctx, SC_ERR_DATA, "not a prepared volume of this version of segcast");
    view = (sc_prepared){
        .label_bytes = h->label_bytes,
        .label_count = h->label_count,
        .oriented = h->oriented != 0,
        .to_ras_mm = h->to_ras_mm,
        .volume_hash = h->volume_hash,
        .boundary_count = h->boundary_count,
        .ids = base + h->offset[0],
        .labels = (const sc_label *)(base + h->offset[1]),
        .stats = (const sc_label_stats *)(base + h->offset[2]),
        .near_count = h->near_count,
        .near = (const uint64_t *)(base + h->offset[3]),
        .near_start = (const uint32_t *)(base + h->offset[4]),
        .records = (const uint8_t *)(base + h->offset[5]),
    };
    if (h->local_thickness)
        view.thickness = (const uint8_t *)(base + h->offset[6]);
    memcpy(view.size, h->size, sizeof view.size);
    memcpy(view.bricks, h->bricks, sizeof view.bricks);
    *out = view;
    return SC_OK;
}
