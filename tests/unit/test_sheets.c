/* SPDX-License-Identifier: BSD-3-Clause */
/* Sheets of tissue one voxel thick: how much they have to weigh, and that they do. */
#include "check.h"

#include "shapes.h"

#include <string.h>

enum { STEPS = 32, POINTS = STEPS + 1, CELL = POINTS * POINTS * POINTS };

/* Write to part[8], for each corner of a cell that is not in @p sheet, the lowest corner of those
 * that it is connected with along edges of the cell; -1 for corners of the sheet.
 * @return whether there are two parts or more. */
static bool find_parts(unsigned sheet, int part[8])
{
    int first = -1;
    bool several = false;

    for (int i = 0; i < 8; i++)
        part[i] = sheet >> i & 1 ? -1 : i;
    for (int round = 0; round < 8; round++) {
        for (int i = 0; i < 8; i++) {
            for (int axis = 1; axis < 8 && part[i] >= 0; axis *= 2) {
                if (part[i ^ axis] >= 0 && part[i ^ axis] < part[i])
                    part[i] = part[i ^ axis];
            }
        }
    }
    for (int i = 0; i < 8; i++) {
        first = first < 0 ? part[i] : first;
        several = several || (part[i] >= 0 && part[i] != first);
    }
    return several;
}

/* @return whether the sheet wins at a point of a cell, in steps. @param same the parts share one
 * label. @param ratio weight of the sheet's corners; that of all others is 1. */
static bool sheet_wins(const int part[8], bool same, double ratio, const int at[3])
{
    double votes[8] = {0}, sheet = 0, most = 0;

    for (int i = 0; i < 8; i++) {
        double share = 1;

        for (int axis = 0; axis < 3; axis++)
            share *= (double)(i >> axis & 1 ? at[axis] : STEPS - at[axis]) / STEPS;
        if (part[i] < 0)
            sheet += ratio * share;
        else
            votes[same ? 0 : part[i]] += share;
    }
    for (int i = 0; i < 8; i++)
        most = votes[i] > most ? votes[i] : most;
    return sheet >= most;
}

/* Do the points of a cell that the sheet does not win connect two of its parts? Spreads the number
 * of each part from its corners to neighbouring points. */
static bool leaks(unsigned sheet, bool same, double ratio)
{
    static int owner[CELL]; /* -1: the sheet, 0: not reached, else 1 + part */
    int part[8];
    bool changed = true, leak = false;

    if (!find_parts(sheet, part))
        return false;
    for (int i = 0; i < CELL; i++) {
        const int at[3] = {i % POINTS, i / POINTS % POINTS, i / POINTS / POINTS};

        owner[i] = sheet_wins(part, same, ratio, at) ? -1 : 0;
    }
    for (int i = 0; i < 8; i++) {
        if (part[i] >= 0)
            owner[STEPS * ((i & 1) + POINTS * (i >> 1 & 1) + POINTS * POINTS * (i >> 2))] =
                1 + part[i];
    }
    while (changed) {
        changed = false;
        for (int i = 0; i < CELL; i++) {
            const int at[3] = {i % POINTS, i / POINTS % POINTS, i / POINTS / POINTS};
            const int step[3] = {1, POINTS, POINTS * POINTS};

            for (int axis = 0; axis < 3; axis++) {
                int *a = owner + i, *b = a + step[axis];

                if (at[axis] == STEPS || *a < 0 || *b < 0 || *a == *b)
                    continue;
                leak = leak || (*a && *b);
                *a = *b = *a > *b ? *a : *b;
                changed = true;
            }
        }
        if (leak)
            return true;
    }
    return false;
}

/* The ratios that prepare/sheets.c names are enough for all 256 patterns of sheet and no sheet at
 * the corners of a cell, and five percent less would not be. */
static void the_ratios_of_weights_keep_the_sides_apart(void **state)
{
    static const double enough[2] = {0.65, 1.30}, too_small[2] = {0.60, 1.20};

    (void)state;
    for (int same = 0; same < 2; same++) {
        int leaking = 0;

        for (unsigned sheet = 0; sheet < 256; sheet++) {
            assert_false(leaks(sheet, same, enough[same]));
            leaking += leaks(sheet, same, too_small[same]);
        }
        assert_true(leaking > 0);
    }
}

static bool one_tissue; /* nothing but background on both sides of the sheet */

/* A digital plane, the thinnest that no path by faces crosses, with or without tissue behind it. */
static int tilted_sheet(double x, double y, double z)
{
    const double height = z - floor(20.5 + 0.43 * (x - 20) - 0.81 * (y - 20));

    return height < 0 ? 0 : height < 1 ? 1 : one_tissue ? 0 : 2;
}

/* @return the weight of a vertex of the grid near an interface. */
static int weight_at(const sc_prepared *v, int x, int y, int z)
{
    const size_t brick = sc_brick_index(v->bricks, sc_brick_of(x), sc_brick_of(y), sc_brick_of(z));
    const int bit = sc_brick_bit(x, y, z);

    assert_true(v->near[brick] >> bit & 1);
    return (int)sc_record_weight(
        sc_record_read(v->records, v->near_start[brick] + sc_brick_rank(v->near[brick], bit)));
}

/* Check one cell: if the sheet keeps parts of it apart, it weighs @p ratio times as much as others.
 * @return whether it does. */
static bool check_cell(const sc_prepared *v, int x, int y, int z, double ratio)
{
    int least = SC_WEIGHT_MAX + 1, most = 0, part[8];
    unsigned sheet = 0;

    for (int i = 0; i < 8; i++)
        sheet |= (unsigned)(sc_id_at_vertex(v, x + (i & 1), y + (i >> 1 & 1), z + (i >> 2)) == 1)
                 << i;
    if (!find_parts(sheet, part))
        return false;
    for (int i = 0; i < 8; i++) {
        const int weight = weight_at(v, x + (i & 1), y + (i >> 1 & 1), z + (i >> 2));

        if (sheet >> i & 1)
            least = weight < least ? weight : least;
        else
            most = weight > most ? weight : most;
    }
    assert_true(least >= ratio * most);
    return true;
}

/* Both kinds of sheet weigh what the ratios ask for, in cubes and in thick slices. */
static void a_sheet_outweighs_what_lies_beside_it(void **state)
{
    static const double spacings[2][3] = {{1, 1, 1}, {1, 2.7, 6.4}};
    const int size[3] = {41, 41, 41};

    (void)state;
    for (int n = 0; n < 4; n++) {
        sc_volume volume;
        prepared_copy p;
        int checked = 0;

        one_tissue = n & 1;
        volume = shape_volume(size, spacings[n >> 1], 1, 3, tilted_sheet);
        p = prepare_copy(&volume, 2);
        for (int i = 0; i < 20 * 20 * 20; i++)
            checked += check_cell(&p.view, 11 + i % 20, 11 + i / 20 % 20, 11 + i / 400,
                                  one_tissue ? 1.25 : 0.637);
        assert_true(checked > 400);
        sc_free(p.block);
        sc_volume_clear(&volume);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_ratios_of_weights_keep_the_sides_apart),
        cmocka_unit_test(a_sheet_outweighs_what_lies_beside_it),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
