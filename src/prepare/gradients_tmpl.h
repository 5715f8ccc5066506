/* SPDX-License-Identifier: BSD-3-Clause */
/* One variant of sc_gradients_fn. The file that includes it defines FIND_GRADIENTS, its name;
 * TARGET, an attribute that lets the compiler use the instructions of a processor; and QUADS, how
 * many quads, 1 to SC_BRICK, a vector holds. Quads that are neighbours along y are computed side by
 * side; each number comes from the same operations in the same order in all variants. */
#include "gradients.h"

#include <string.h>

enum { PARTS = SC_BRICK / QUADS };

/* So many floats, which are aligned as quads are and are stored as such. */
typedef float vec
    __attribute__((vector_size(QUADS * sizeof(sc_quad)), aligned(sizeof(sc_quad)), may_alias));

/* Filter layer @p z of the window along y. */
TARGET static inline void filter_along_y(const sc_normal_filter *f, int z, sc_gradients *g)
{
    vec flat[PARTS] = {{0}}, x_slope[PARTS] = {{0}}, y_slope[PARTS] = {{0}};

    for (int i = 0; i < SC_FIELD_TAPS; i++) {
        const sc_quad *value = g->value + z * SC_FIELD_WINDOW + i;
        const sc_quad *along_x = g->along_x + z * SC_FIELD_WINDOW + i;

        for (int part = 0; part < PARTS; part++) {
            const vec v = *(const vec *)(value + part * QUADS);

            flat[part] += v * f->value[1][i];
            y_slope[part] += v * f->slope[1][i];
            x_slope[part] += *(const vec *)(along_x + part * QUADS) * f->value[1][i];
        }
    }
    memcpy(g->flat[z], flat, sizeof flat);
    memcpy(g->x_slope[z], x_slope, sizeof x_slope);
    memcpy(g->y_slope[z], y_slope, sizeof y_slope);
}

/* Filter what was filtered along x and y along z, for layer @p z of the brick. */
TARGET static inline void filter_along_z(const sc_normal_filter *f, int z, sc_gradients *g)
{
    vec along[3][PARTS] = {{{0}}};

    for (int i = 0; i < SC_FIELD_TAPS; i++) {
        for (int part = 0; part < PARTS; part++) {
            const int y = part * QUADS;

            along[0][part] += *(const vec *)&g->x_slope[z + i][y] * f->value[2][i];
            along[1][part] += *(const vec *)&g->y_slope[z + i][y] * f->value[2][i];
            along[2][part] += *(const vec *)&g->flat[z + i][y] * f->slope[2][i];
        }
    }
    for (int axis = 0; axis < 3; axis++)
        memcpy(g->along[axis] + sc_brick_bit(0, 0, z), along[axis], sizeof along[axis]);
}

TARGET void FIND_GRADIENTS(const sc_normal_filter *f, const uint32_t bits[SC_FIELD_ROWS],
                           uint64_t mask, sc_gradients *out)
{
    const int low = sc_bit_z(__builtin_ctzll(mask)), high = sc_bit_z(63 - __builtin_clzll(mask));

    for (int z = low; z < high + SC_FIELD_TAPS; z++) {
        for (int y = 0; y < SC_FIELD_WINDOW; y++) {
            const int row = z * SC_FIELD_WINDOW + y;
            const sc_quad *sums = f->table[bits[row]];

            out->value[row] = sums[0];
            out->along_x[row] = sums[1];
        }
        filter_along_y(f, z, out);
    }
    for (int z = low; z <= high; z++)
        filter_along_z(f, z, out);
}
