/* SPDX-License-Identifier: BSD-3-Clause */
/* Gradients by the vectors of two quads that AVX2 has. */
#define FIND_GRADIENTS sc_find_gradients_avx2
#define TARGET __attribute__((target("avx2")))
#define QUADS 2
#include "gradients.h"

#ifdef SC_GRADIENTS_AVX2
#include "gradients_tmpl.h"
#endif
