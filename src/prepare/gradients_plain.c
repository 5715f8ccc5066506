/* SPDX-License-Identifier: BSD-3-Clause */
/* Gradients by vectors of one quad, which all processors have, or compilers make do without. */
#define FIND_GRADIENTS sc_find_gradients_plain
#define TARGET
#define QUADS 1
#include "gradients_tmpl.h"
