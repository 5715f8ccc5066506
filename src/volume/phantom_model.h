/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the phantom's fields as its voxeliser needs them. */
#ifndef SC_PHANTOM_MODEL_H
#define SC_PHANTOM_MODEL_H

#include "phantom_shapes.h"
#include "segcast/phantom.h"

/* Field of one tissue before earlier ones are taken out of it; at most SC_SHAPE_LIPSCHITZ steep. */
double sc_phantom_field(const sc_phantom *phantom, int label, sc_vec3 p);

#endif
