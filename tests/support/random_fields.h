/* SPDX-License-Identifier: BSD-3-Clause */
/* Prepared volumes whose two fields are random, as far as the rule of sc_prepared allows: what
 * holds for them holds for whatever finds the fields. */
#ifndef SC_TEST_RANDOM_FIELDS_H
#define SC_TEST_RANDOM_FIELDS_H

#include "border/border_group.h"
#include "shapes.h"

/* What is random at a vertex is a function of the seed and of the vertex. */
typedef struct random_fields {
    uint64_t seed;
    sc_record_writer fields;
} random_fields;

static inline uint64_t bits_of_vertex(uint64_t seed, size_t brick, int bit)
{
    uint64_t state = seed + 1 + (brick * SC_BRICK_VERTICES + (size_t)bit) * 7919;

    random_bits(&state);
    return random_bits(&state) >> 8;
}

/* Choose a voxel of tissue in the 3x3x3 around the voxel (x, y, z), mostly that itself. @return its
 * code; -1: there is none. */
static inline int random_tissue(const sc_volume *v, int x, int y, int z, uint64_t bits)
{
    int codes[SC_TISSUE_CODES], count = 0;

    if (sc_id_or_nearest(v, x, y, z) && bits % 16)
        return SC_TISSUE_OWN;
    for (int code = 0; code < SC_TISSUE_CODES; code++) {
        if (sc_id_or_nearest(v, x + sc_tissue_step(code, 0), y + sc_tissue_step(code, 1),
                             z + sc_tissue_step(code, 2)))
            codes[count++] = code;
    }
    return count ? codes[bits / 16 % (unsigned)count] : -1;
}

/* May the voxel (x, y, z) change sides? Then all those around it must find a tissue. */
static inline bool may_change(const sc_volume *v, int x, int y, int z)
{
    for (int n = 0; n < 27; n++) {
        if (random_tissue(v, x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1, 0) < 0)
            return false;
    }
    return true;
}

/* Write random records to the vertices of a brick that have one. */
static inline void fill_brick(const random_fields *r, size_t brick)
{
    const sc_border *const borders[2] = {&r->fields.p->outer, &r->fields.p->inner};
    const uint32_t number = r->fields.number[brick] - 1;

    for (int i = 0; i < 2; i++) {
        uint32_t *record = (uint32_t *)(uintptr_t)borders[i]->records + borders[i]->start[brick];

        for (uint64_t left = borders[i]->masks[brick]; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);
            uint64_t bits = bits_of_vertex(r->seed + 1 + (uint64_t)i, brick, bit);
            const int value = 1 + (int)(bits % SC_VALUE_MAX);
            const bool side = r->fields.sides[number].tissue >> bit & 1;
            const sc_vec3 direction = {random_real(&bits, -1, 1), random_real(&bits, -1, 1),
                                       random_real(&bits, -1, 1)};

            *record++ =
                sc_record_pack(i || side ? value : -value, direction, random_real(&bits, 0, 1)) |
                (uint32_t)r->fields.codes[number][bit] << SC_RECORD_TISSUE_SHIFT;
        }
    }
}

/* As prepare_copy, with random fields. */
static inline prepared_copy prepare_random_fields(const sc_volume *volume, uint64_t seed)
{
    const sc_prepare_settings settings = {.local_thickness = true, .threads = 2};
    random_fields r = {.seed = seed};
    SC_OWN(sc_free_at) void *number = NULL, *sides = NULL, *codes = NULL, *wanted = NULL;
    sc_preparation *p;

    assert_ok(sc_prepare(&quiet, volume, &settings, &p));
    assert_ok(sc_alloc(&quiet, p->brick_count, sizeof(uint32_t), &number));
    assert_ok(sc_alloc(&quiet, p->brick_count, sizeof(uint64_t), &wanted));
    assert_ok(sc_zalloc(&quiet, p->brick_count, sizeof(sc_brick_sides), &sides));
    assert_ok(sc_alloc(&quiet, p->brick_count, SC_BRICK_VERTICES, &codes));
    for (size_t brick = 0; brick < p->brick_count; brick++) {
        int low[3];

        ((uint32_t *)number)[brick] = (uint32_t)brick + 1;
        ((uint64_t *)wanted)[brick] = 1;
        sc_brick_low(p->bricks, brick, low);
        for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
            const uint64_t bits = bits_of_vertex(seed, brick, bit);
            const int x = low[0] + sc_bit_x(bit) - 1, y = low[1] + sc_bit_y(bit) - 1,
                      z = low[2] + sc_bit_z(bit) - 1;
            const int code = random_tissue(volume, x, y, z, bits >> 8);
            bool side = sc_id_or_nearest(volume, x, y, z) != 0;

            side ^= bits % 16 == 0 && may_change(volume, x, y, z);
            ((sc_brick_sides *)sides)[brick].tissue |= (uint64_t)side << bit;
            ((sc_brick_sides *)sides)[brick].moved |= (uint64_t)(code >= 0 && code != SC_TISSUE_OWN)
                                                      << bit;
            ((uint8_t *)codes)[brick * SC_BRICK_VERTICES + (size_t)bit] =
                (uint8_t)(code < 0 ? SC_TISSUE_OWN : code);
        }
    }
    r.fields = (sc_record_writer){
        .p = p, .wanted = wanted, .number = number, .sides = sides, .codes = codes};
    for (int i = 0; i < 3; i++)
        r.fields.groups[i] = (p->bricks[i] + SC_GROUP_EDGE - 1) / SC_GROUP_EDGE;
    assert_ok(sc_mark_borders(&quiet, &r.fields));
    for (size_t brick = 0; brick < p->brick_count; brick++)
        fill_brick(&r, brick);
    return pack_copy(p);
}

#endif
