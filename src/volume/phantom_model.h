/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the phantom's fields as its voxeliser needs them. */
#ifndef SC_PHANTOM_MODEL_H
#define SC_PHANTOM_MODEL_H

#include "phantom_shapes.h"
#include "segcast/phantom.h"

/* Field in mm of tissue @p label, in [1, count], at @p p (mm), before earlier tissues are taken
 * out of it: negative inside. It changes by at most SC_SHAPE_LIPSCHITZ mm per mm. As with
 * sc_shape_field, it is exact where it is below @p limit_mm, and elsewhere at least that. */
double sc_phantom_field(const sc_phantom *phantom, int label, sc_vec3 p, double limit_mm);

#endif
