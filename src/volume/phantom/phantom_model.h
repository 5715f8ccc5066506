/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the phantom's fields as its voxeliser needs them. */
#ifndef SC_PHANTOM_MODEL_H
#define SC_PHANTOM_MODEL_H

#include "phantom/phantom_shapes.h"
#include "segcast/phantom.h"

/* How far the chambers have contracted: 0 not at all, 1 as far as they do. */
typedef struct sc_beat {
    double ventricles, atria;
} sc_beat;

/* The beat of the heart at a time: @p phase is 0 at the end of diastole, when the ventricles are
 * full, and 1 a beat later; it may be any finite number. Periodic, and smooth (its derivative is
 * continuous), in the order of Wiggers' diagram: ejection, rapid filling, diastasis, and the
 * contraction of the atria. */
sc_beat sc_beat_at(double phase);

/* Field in mm of tissue @p label, in [1, count], at @p p (mm), before earlier tissues are taken
 * out of it: negative inside. It changes by at most SC_SHAPE_LIPSCHITZ mm per mm. As with
 * sc_shape_field, it is exact where it is below @p limit_mm, and elsewhere at least that. */
double sc_phantom_field(const sc_phantom *phantom, int label, sc_vec3 p, double limit_mm);
/* @return the Hounsfield units of tissue @p label, in [1, count]. */
int sc_phantom_hu(int label);

#endif
