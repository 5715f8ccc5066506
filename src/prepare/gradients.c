/* SPDX-License-Identifier: BSD-3-Clause */
/* The choice between the variants of sc_gradients_fn. */
#include "gradients.h"

static sc_gradients_fn *const variants[] = {sc_find_gradients_plain,
#ifdef SC_GRADIENTS_AVX2
                                            sc_find_gradients_avx2
#endif
};

/* @return whether this processor can run variant @p n. */
static bool can_run(size_t n)
{
#ifdef SC_GRADIENTS_AVX2
    return n == 0 || __builtin_cpu_supports("avx2");
#else
    return n == 0;
#endif
}

sc_gradients_fn *sc_gradients_variant(size_t n)
{
    return n < SC_COUNT_OF(variants) && can_run(n) ? variants[n] : NULL;
}

sc_gradients_fn *sc_gradients_fastest(void)
{
    size_t n = SC_COUNT_OF(variants) - 1;

    while (!can_run(n))
        n--;
    return variants[n];
}
