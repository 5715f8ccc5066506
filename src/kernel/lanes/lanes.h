/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: vectors of MARCH_LANES SIMD lanes of 32 bits; in the wide kernels each lane
 * works on a ray of its own. Arithmetic is written with the compiler's vector types and operators,
 * which are exact IEEE operations on any processor. What those do not offer (masks, selection,
 * gathers, square roots) is written here with the intrinsics of each variant, and in plain C for
 * the variant "c".
 *
 * The build defines MARCH_CPU_<NAME> for the variant that is being compiled. The compiler's own
 * macros such as __AVX2__ must not be asked instead: with -march=native they are set for narrower
 * variants, too. */
#ifndef SC_KERNEL_LANES_H
#define SC_KERNEL_LANES_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#if defined MARCH_CPU_AVX512 || defined MARCH_CPU_AVX2 || defined MARCH_CPU_SSE4
#include <immintrin.h>
#elif defined MARCH_CPU_NEON
#include <arm_neon.h>
#endif

#if defined MARCH_CPU_AVX512
_Static_assert(MARCH_LANES == 16, "registers of AVX-512 hold 16 SIMD lanes");
#elif defined MARCH_CPU_AVX2
_Static_assert(MARCH_LANES == 8, "registers of AVX2 hold 8 SIMD lanes");
#elif defined MARCH_CPU_SSE4
_Static_assert(MARCH_LANES == 4, "registers of SSE hold 4 SIMD lanes");
#elif defined MARCH_CPU_NEON
_Static_assert(MARCH_LANES == 4, "registers of NEON hold 4 SIMD lanes");
#elif !defined MARCH_CPU_C
#error "the build must define MARCH_CPU_<NAME> for a variant that this file knows"
#endif
_Static_assert(MARCH_LANES <= 32, "a mask is kept as 32 bits");
_Static_assert(sizeof(float) == 4 && sizeof(int) == 4, "a SIMD lane holds a float or an int");
/* i_gather reads four bytes at once; the kernels pick one or two of them, or one half of 64 bits,
 * by shifting. On other machines only the plain march would work. */
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "the wide kernels are written for little-endian processors");

enum { LANES = MARCH_LANES };

/* One float, one int or one unsigned int for each SIMD lane. Functions that begin with f_, i_ and
 * m_ work on floats, ints and masks. */
typedef float vf __attribute__((vector_size(4 * MARCH_LANES)));
typedef int32_t vi __attribute__((vector_size(4 * MARCH_LANES)));
typedef uint32_t vu __attribute__((vector_size(4 * MARCH_LANES)));

/* The same number in all lanes. Subtracting 0 keeps -0.0 as it is. */
static inline vf f_set(float x)
{
    return x - (vf){0};
}

static inline vi i_set(int32_t x)
{
    return x - (vi){0};
}

/* Each int as the nearest float. */
static inline vf f_of(vi x)
{
    return __builtin_convertvector(x, vf);
}

/* Each float rounded towards zero. The result is unspecified, and may differ between variants,
 * for numbers that an int cannot hold. */
static inline vi i_of(vf x)
{
#if defined MARCH_CPU_AVX512
    return (vi)_mm512_cvttps_epi32((__m512)x);
#elif defined MARCH_CPU_AVX2
    return (vi)_mm256_cvttps_epi32((__m256)x);
#elif defined MARCH_CPU_SSE4
    return (vi)_mm_cvttps_epi32((__m128)x);
#elif defined MARCH_CPU_NEON
    return (vi)vcvtq_s32_f32((float32x4_t)x);
#else
    vi out;

    for (int i = 0; i < LANES; i++)
        out[i] = x[i] > -2e9f && x[i] < 2e9f ? (int32_t)x[i] : INT32_MIN;
    return out;
#endif
}

/* ---- masks: one truth value for each lane ----
 *
 * Every variant has the same functions: with AVX-512 a mask is a number with one bit for each lane,
 * elsewhere a vector of ints that are -1 (true) or 0. */

#if defined MARCH_CPU_AVX512
typedef __mmask16 vm;

/* No lane. */
static inline vm m_none(void)
{
    return 0;
}

static inline vm m_and(vm a, vm b)
{
    return (vm)(a & b);
}

static inline vm m_or(vm a, vm b)
{
    return (vm)(a | b);
}

/* The lanes of @p a that are not in @p b. */
static inline vm m_without(vm a, vm b)
{
    return (vm)(a & ~b);
}

/* Comparisons: the lanes in which a < b, a <= b or a == b. NaN compares as false. */
static inline vm f_below(vf a, vf b)
{
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LT_OQ);
}

/* a <= b. */
static inline vm f_at_most(vf a, vf b)
{
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_LE_OQ);
}

/* a == b; 0.0 equals -0.0. */
static inline vm f_equal(vf a, vf b)
{
    return _mm512_cmp_ps_mask((__m512)a, (__m512)b, _CMP_EQ_OQ);
}

/* The same for ints: a == b, and below a < b, with sign. */
static inline vm i_equal(vi a, vi b)
{
    return _mm512_cmpeq_epi32_mask((__m512i)a, (__m512i)b);
}

static inline vm i_below(vi a, vi b)
{
    return _mm512_cmplt_epi32_mask((__m512i)a, (__m512i)b);
}

/* @p yes in the lanes of @p m, @p no in the others. */
static inline vf f_pick(vm m, vf yes, vf no)
{
    return (vf)_mm512_mask_blend_ps(m, (__m512)no, (__m512)yes);
}

/* As f_pick, for ints. */
static inline vi i_pick(vm m, vi yes, vi no)
{
    return (vi)_mm512_mask_blend_epi32(m, (__m512i)no, (__m512i)yes);
}

/* As a number: bit i for lane i. */
static inline uint32_t m_bits(vm m)
{
    return m;
}

/* The reverse of m_bits: lane i is set if bit i is; bits beyond the lanes must be 0. */
static inline vm m_of_bits(uint32_t bits)
{
    return (vm)bits;
}
#else
/* The same functions for all other variants. */
typedef vi vm;

static inline vm m_none(void)
{
    return (vi){0};
}

static inline vm m_and(vm a, vm b)
{
    return a & b;
}

static inline vm m_or(vm a, vm b)
{
    return a | b;
}

static inline vm m_without(vm a, vm b)
{
    return a & ~b;
}

static inline vm f_below(vf a, vf b)
{
    return a < b;
}

static inline vm f_at_most(vf a, vf b)
{
    return a <= b;
}

static inline vm f_equal(vf a, vf b)
{
    return a == b;
}

static inline vm i_equal(vi a, vi b)
{
    return a == b;
}

static inline vm i_below(vi a, vi b)
{
    return a < b;
}

/* @p yes in the lanes of @p m, @p no in the others. */
static inline vi i_pick(vm m, vi yes, vi no)
{
#if defined MARCH_CPU_AVX2
    return (vi)_mm256_blendv_epi8((__m256i)no, (__m256i)yes, (__m256i)m);
#elif defined MARCH_CPU_SSE4
    return (vi)_mm_blendv_epi8((__m128i)no, (__m128i)yes, (__m128i)m);
#elif defined MARCH_CPU_NEON
    return (vi)vbslq_s32((uint32x4_t)m, (int32x4_t)yes, (int32x4_t)no);
#else
    return (yes & m) | (no & ~m);
#endif
}

static inline vf f_pick(vm m, vf yes, vf no)
{
    return (vf)i_pick(m, (vi)yes, (vi)no);
}

/* As a number: bit i for lane i. */
static inline uint32_t m_bits(vm m)
{
#if defined MARCH_CPU_AVX2
    return (uint32_t)_mm256_movemask_ps((__m256)m);
#elif defined MARCH_CPU_SSE4
    return (uint32_t)_mm_movemask_ps((__m128)m);
#elif defined MARCH_CPU_NEON
    return vaddvq_u32((uint32x4_t)((vu)m & (vu){1, 2, 4, 8}));
#else
    uint32_t bits = 0;

    for (int i = 0; i < LANES; i++)
        bits |= (uint32_t)(m[i] & 1) << i;
    return bits;
#endif
}

/* The lanes whose bits are set. */
static inline vm m_of_bits(uint32_t bits)
{
    vi out;

    for (int i = 0; i < LANES; i++)
        out[i] = -(int32_t)(bits >> i & 1);
    return out;
}
#endif

/* Is any lane set? */
static inline bool m_any(vm m)
{
    return m_bits(m) != 0;
}

/* How many lanes are set. */
static inline unsigned m_count(vm m)
{
    return (unsigned)__builtin_popcount(m_bits(m));
}

/* ---- the rest, built on these ---- */

/* Square root of each lane, correctly rounded as IEEE demands; NaN of negative numbers. */
static inline vf f_sqrt(vf x)
{
#if defined MARCH_CPU_AVX512
    return (vf)_mm512_sqrt_ps((__m512)x);
#elif defined MARCH_CPU_AVX2
    return (vf)_mm256_sqrt_ps((__m256)x);
#elif defined MARCH_CPU_SSE4
    return (vf)_mm_sqrt_ps((__m128)x);
#elif defined MARCH_CPU_NEON
    return (vf)vsqrtq_f32((float32x4_t)x);
#else
    for (int i = 0; i < LANES; i++)
        x[i] = sqrtf(x[i]);
    return x;
#endif
}

/* For each lane of @p m the four bytes at base + offset; 0 for the other lanes, which read nothing.
 */
static inline vi i_gather(const void *base, vi offset_bytes, vm m)
{
#if defined MARCH_CPU_AVX512
    return (vi)_mm512_mask_i32gather_epi32(_mm512_setzero_si512(), m, (__m512i)offset_bytes, base,
                                           1);
#elif defined MARCH_CPU_AVX2
    return (vi)_mm256_mask_i32gather_epi32(_mm256_setzero_si256(), (const int *)base,
                                           (__m256i)offset_bytes, (__m256i)m, 1);
#else
    vi out = {0};

    for (uint32_t left = m_bits(m); left; left &= left - 1) {
        const int i = __builtin_ctz(left);
        int32_t each;

        memcpy(&each, (const uint8_t *)base + offset_bytes[i], sizeof each);
        out[i] = each;
    }
    return out;
#endif
}

/* For each lane the number that @p index, 0 to 3, names of @p four. */
static inline vi i_of_four(const int32_t four[4], vi index)
{
#if defined MARCH_CPU_AVX512
    return (vi)_mm512_permutexvar_epi32(
        (__m512i)index, _mm512_castsi128_si512(_mm_loadu_si128((const __m128i *)four)));
#elif defined MARCH_CPU_AVX2
    return (vi)_mm256_permutevar8x32_epi32(
        _mm256_castsi128_si256(_mm_loadu_si128((const __m128i *)four)), (__m256i)index);
#else
    vi out;

    for (int i = 0; i < LANES; i++)
        out[i] = four[index[i] & 3];
    return out;
#endif
}

/* As i_gather, the four bytes being a float. */
static inline vf f_gather(const void *base, vi offset_bytes, vm m)
{
    return (vf)i_gather(base, offset_bytes, m);
}

/* Each float rounded down. Only for numbers that an int can hold, as i_of and i_ceil. */
static inline vi i_floor(vf x)
{
    const vi whole = i_of(x);

    return i_pick(f_below(x, f_of(whole)), whole - 1, whole);
}

/* Each float rounded up. */
static inline vi i_ceil(vf x)
{
    const vi whole = i_of(x);

    return i_pick(f_below(f_of(whole), x), whole + 1, whole);
}

/* Each float limited to [0, 1], as sc_clamp01 does it; NaN stays NaN. */
static inline vf f_clamp01(vf x)
{
    return f_pick(f_below(x, f_set(0)), f_set(0), f_pick(f_below(f_set(1), x), f_set(1), x));
}

static inline vf f_abs(vf x)
{
    return f_pick(f_below(x, f_set(0)), -x, x);
}

/* The greater of x and 0; 0 for NaN. */
static inline vf f_max0(vf x)
{
    return f_pick(f_below(f_set(0), x), x, f_set(0));
}

/* How many of the 32 bits of each lane are set. */
static inline vi i_count_bits(vi x)
{
    vu v = (vu)x;

    v -= v >> 1 & 0x55555555u;
    v = (v & 0x33333333u) + (v >> 2 & 0x33333333u);
    v = (v + (v >> 4)) & 0x0f0f0f0fu;
    return (vi)(v * 0x01010101u >> 24);
}

/* Dot product of two 3D vectors in each lane, summed in the order of sc_dot3. */
static inline vf f_dot(const vf a[3], const vf b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline vf f_length(const vf a[3])
{
    return f_sqrt(f_dot(a, a));
}

/* As sc_lerp: exactly @p low for @p at 0 and exactly @p high for 1. */
static inline vf f_lerp(vf low, vf high, vf at)
{
    return low * (1 - at) + high * at;
}

#endif
