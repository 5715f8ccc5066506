/* SPDX-License-Identifier: BSD-3-Clause */
/* The variants of the gradients in a brick: all that this processor can run give the same bits, and
 * these are what the definition of the filter gives. */
#include "check.h"

#include "../../src/prepare/gradients.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A filter of random taps. Caller frees its table. */
static sc_normal_filter random_filter(uint64_t *state)
{
    sc_normal_filter f;
    float *sums;

    f.table = aligned_alloc(64, SC_FIELD_PATTERNS * sizeof *f.table);
    assert_non_null(f.table);
    sums = (float *)(void *)f.table;
    for (size_t i = 0; i < SC_FIELD_PATTERNS * sizeof *f.table / sizeof *sums; i++)
        sums[i] = (float)random_real(state, -1, 1);
    for (int axis = 0; axis < 3; axis++) {
        for (int i = 0; i < SC_FIELD_TAPS; i++) {
            f.value[axis][i] = (float)random_real(state, 0, 1);
            f.slope[axis][i] = (float)random_real(state, -1, 1);
        }
    }
    return f;
}

/* @return the sum of the filter at a vertex of the brick: along x by the table's value or
 * derivative, along y and z by the taps @p along_y and @p along_z. */
static double sum_at(const sc_normal_filter *f, const uint32_t *bits, int bit, bool derivative,
                     const float *along_y, const float *along_z)
{
    double sum = 0;

    for (int z = 0; z < SC_FIELD_TAPS; z++) {
        for (int y = 0; y < SC_FIELD_TAPS; y++) {
            const int row = (sc_bit_z(bit) + z) * SC_FIELD_WINDOW + sc_bit_y(bit) + y;

            sum += (double)f->table[bits[row]][derivative][sc_bit_x(bit)] * along_y[y] * along_z[z];
        }
    }
    return sum;
}

/* Compare the layers of @p mask of what the plain variant gives with the definition. */
static void check_plain(const sc_normal_filter *f, const uint32_t *bits, uint64_t mask,
                        const sc_gradients *g)
{
    for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
        if (!(mask >> bit & 1))
            continue;
        assert_true(fabs(g->along[0][bit] - sum_at(f, bits, bit, true, f->value[1], f->value[2])) <
                    1e-3);
        assert_true(fabs(g->along[1][bit] - sum_at(f, bits, bit, false, f->slope[1], f->value[2])) <
                    1e-3);
        assert_true(fabs(g->along[2][bit] - sum_at(f, bits, bit, false, f->value[1], f->slope[2])) <
                    1e-3);
    }
}

static void variants_give_the_same_bits(void **state)
{
    uint64_t seed = 7;
    sc_normal_filter f = random_filter(&seed);
    sc_gradients *plain = calloc(2, sizeof *plain), *other = plain + 1;
    uint32_t bits[SC_FIELD_ROWS];

    (void)state;
    assert_non_null(plain);
    assert_non_null(sc_gradients_variant(0));
    assert_null(sc_gradients_variant(1000));
    for (int round = 0; round < 200; round++) {
        /* One vertex, some of a few layers, or many. */
        const uint64_t mask = round % 3 == 0   ? 1ull << random_bits(&seed) % 64
                              : round % 3 == 1 ? random_bits(&seed) & 0xffffffff0000u
                                               : random_bits(&seed);

        for (int row = 0; row < SC_FIELD_ROWS; row++)
            bits[row] = (uint32_t)(random_bits(&seed) % SC_FIELD_PATTERNS);
        if (!mask)
            continue;
        sc_gradients_variant(0)(&f, bits, mask, plain);
        check_plain(&f, bits, mask, plain);
        for (size_t n = 1; sc_gradients_variant(n); n++) {
            sc_gradients_variant(n)(&f, bits, mask, other);
            for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
                for (int axis = 0; axis < 3 && mask >> bit & 1; axis++)
                    assert_memory_equal(&other->along[axis][bit], &plain->along[axis][bit],
                                        sizeof(float));
            }
        }
    }
    free(plain);
    free(f.table);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(variants_give_the_same_bits)};

    return cmocka_run_group_tests(tests, NULL, NULL);
}
