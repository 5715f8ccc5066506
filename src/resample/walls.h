/* SPDX-License-Identifier: BSD-3-Clause */
/* Thin walls between thick slices. Where a wall lies on one side of a pixel in a slice, and on the
 * other side in the next one, it has passed over the pixel in between. Its distances in the two
 * slices do not tell: interpolated, they let a wall become thinner that moves by more than its
 * thickness from slice to slice, and tear if it moves by twice as much. But the labels on its two
 * sides tell: one ends before the other one begins. What is left between them belongs to the wall.
 */
#ifndef SEGCAST_RESAMPLE_WALLS_H
#define SEGCAST_RESAMPLE_WALLS_H

#include "spline.h"

/* Give what is left to the walls that pass over pixels of a layer behind slice @p z. @param d holds
 * the slices around the layer. @param least [y][x] the least of the distances of all labels there.
 * @param open [y][x] scratch. @param winner [y][x] the dense id of the label with the least
 * distance, and receives that of the wall. */
void sc_walls_keep(const distances *d, const blend *layer, int z, const float *least, float *open,
                   uint32_t *winner);

#endif
