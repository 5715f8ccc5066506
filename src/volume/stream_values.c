/* SPDX-License-Identifier: BSD-3-Clause */
/* The voxels of a volume file as labels, which are checked to be whole numbers, or as numbers of
 * any kind: brought into the byte order of this machine, and scaled. */
#include "stream.h"

/* Voxels of a run that are compared at a time. */
enum { RUN_BLOCK = 32 };

/* Write each of @p count numbers of @p each bytes at @p raw to @p out with its bytes reversed. */
static void swap_bytes(const unsigned char *raw, size_t count, size_t each, unsigned char *out)
{
    for (size_t i = 0; i < count; i++, raw += each, out += each) {
        for (size_t k = 0; k < each; k++)
            out[k] = raw[each - 1 - k];
    }
}

/* @return why @p value is no label; NULL: it is one. */
static const char *why_no_label(double value)
{
    if (!isfinite(value))
        return "not a number";
    if (value != floor(value))
        return "a fraction";
    if (fabs(value) > 9007199254740992.0) /* 2^53: beyond it a double skips whole numbers */
        return "too large for a label";
    return NULL;
}

/* @return what voxel @p i stands for, a float or an integer that the header scales. Floats are read
 * from @p raw; integers stand in @p out already. */
static double scaled_value(const sc_source *source, const void *raw, const int64_t *out, size_t i)
{
    double value = (double)out[i];

    if (source->type == SC_VOXEL_FLOAT)
        value = ((const float *)raw)[i];
    else if (source->type == SC_VOXEL_DOUBLE)
        value = ((const double *)raw)[i];
    return source->slope * value + source->intercept;
}

/* @return @p value, brought to the next whole number where it lies within half a step of it: as far
 * as labels move when a writer stores numbers of floating point as integers with a slope. */
static double nearest_label(const sc_source *source, double value)
{
    const double step = fabs(source->slope), whole = round(value);

    return sc_voxel_type_is_integer(source->type) && step < 1 &&
                   fabs(value - whole) <= 0.5000001 * step
               ? whole
               : value;
}

/* Write slope * value + intercept to out[count]; see scaled_value. @return the index of the first
 * that is no label, @p count if all are. */
static size_t load_scaled(sc_voxel_stream *s, const void *raw, size_t count, int64_t *out)
{
    bool moved = false;
    size_t i;

    for (i = 0; i < count; i++) {
        const double value = scaled_value(s->source, raw, out, i);
        const double label = nearest_label(s->source, value);

        if (why_no_label(label))
            break;
        moved = moved || label != value;
        out[i] = (int64_t)label;
    }
    if (moved)
        atomic_store_explicit(&s->rounded, true, memory_order_relaxed);
    return i;
}

/* The cases of a switch over the types of integers: DO(type) for each. */
#define CASE(name, type, DO)                                                                       \
    case SC_VOXEL_##name:                                                                          \
        DO(type);                                                                                  \
        break
#define INTEGER_CASES(DO)                                                                          \
    CASE(INT8, int8_t, DO);                                                                        \
    CASE(UINT8, uint8_t, DO);                                                                      \
    CASE(INT16, int16_t, DO);                                                                      \
    CASE(UINT16, uint16_t, DO);                                                                    \
    CASE(INT32, int32_t, DO);                                                                      \
    CASE(UINT32, uint32_t, DO);                                                                    \
    CASE(UINT64, uint64_t, DO);                                                                    \
    CASE(INT64, int64_t, DO)

/* Copy raw[count], of this type, to out[count]; for widen only. */
#define WIDEN(type)                                                                                \
    do {                                                                                           \
        const type *in = raw;                                                                      \
        for (size_t i = 0; i < count; i++)                                                         \
            out[i] = (int64_t)in[i];                                                               \
    } while (0)

/* Copy integers of this type, in this machine's byte order, to out[count]; floats are left out. */
static void widen(sc_voxel_type type, const void *raw, size_t count, int64_t *out)
{
    switch (type) {
        INTEGER_CASES(WIDEN);
    case SC_VOXEL_FLOAT:
    case SC_VOXEL_DOUBLE:
        break;
    }
}

bool sc_stream_is_plain(const sc_source *source)
{
    return !source->stored.swapped && source->slope == 1 && source->intercept == 0 &&
           sc_voxel_type_is_integer(source->type) && source->type != SC_VOXEL_UINT64;
}

/* What sc_run_end does with values of one type. Long runs are compared by blocks, which compilers
 * turn into vectors. */
#define RUN_END(type)                                                                              \
    do {                                                                                           \
        const type *in = values;                                                                   \
        const type first = in[i];                                                                  \
        for (; end + RUN_BLOCK <= count; end += RUN_BLOCK) {                                       \
            type differs = 0;                                                                      \
            for (int k = 0; k < RUN_BLOCK; k++)                                                    \
                differs = (type)(differs | (in[end + k] ^ first));                                 \
            if (differs)                                                                           \
                break;                                                                             \
        }                                                                                          \
        while (end < count && in[end] == first)                                                    \
            end++;                                                                                 \
        *value = (int64_t)first;                                                                   \
    } while (0)

int sc_run_end(sc_voxel_type type, const void *values, int i, int count, int64_t *value)
{
    int end = i + 1;

    switch (type) {
        INTEGER_CASES(RUN_END);
    default: /* sc_stream_values has turned it into int64_t */
        RUN_END(int64_t);
        break;
    }
    return end;
}

size_t sc_stream_values(sc_voxel_stream *s, const void *raw, size_t count, void *room, int64_t *out)
{
    const sc_source *source = s->source;

    if (source->stored.swapped) {
        swap_bytes(raw, count, sc_voxel_type_bytes(source->type), room);
        raw = room;
    }
    widen(source->type, raw, count, out);
    if (!sc_voxel_type_is_integer(source->type))
        return load_scaled(s, raw, count, out);
    for (size_t i = 0; i < count && source->type == SC_VOXEL_UINT64; i++) {
        if (out[i] < 0)
            return i;
    }
    if (source->slope != 1 || source->intercept != 0)
        return load_scaled(s, raw, count, out);
    return count;
}

sc_status sc_stream_refuse(const sc_voxel_stream *s, const void *raw, size_t index)
{
    const sc_source *source = s->source;
    const size_t nx = (size_t)source->size[0], ny = (size_t)source->size[1];
    const size_t each = sc_voxel_type_bytes(source->type);
    unsigned char room[SC_VOXEL_BYTES_MAX];
    const char *why;
    int64_t stored = 0;
    double value;

    if (source->stored.swapped && each <= sizeof room) { /* always: the compiler does not know it */
        swap_bytes(raw, 1, each, room);
        raw = room;
    }
    widen(source->type, raw, 1, &stored);
    if (source->type == SC_VOXEL_UINT64 && stored < 0)
        return sc_fail(s->ctx, SC_ERR_DATA,
                       "%s: voxel (%zu, %zu, %zu) holds the label %llu; expected labels below "
                       "2^63 = 9223372036854775808: give the tissues smaller numbers",
                       s->path, index % nx, index / nx % ny, index / nx / ny,
                       (unsigned long long)stored);
    value = scaled_value(source, raw, &stored, 0);
    why = why_no_label(value);
    return sc_fail(
        s->ctx, SC_ERR_DATA,
        "%s: voxel (%zu, %zu, %zu) holds %.10g, %s; expected whole label numbers: use a "
        "segmentation, not a grey-value image or a probability map; of a directory of soft "
        "masks --set volume.threshold=50%% makes tissues",
        s->path, index % nx, index / nx % ny, index / nx / ny, value, why ? why : "no label");
}

sc_status sc_stream_next(sc_voxel_stream *s, size_t count, int64_t *out)
{
    const size_t each = sc_voxel_type_bytes(s->source->type);
    const void *raw;
    size_t good;

    SC_PASS(sc_stream_stored(s, count, &raw));
    good = sc_stream_values(s, raw, count, s->swapped, out);
    if (good < count)
        return sc_stream_refuse(s, (const unsigned char *)raw + good * each, s->position + good);
    s->position += count;
    return SC_OK;
}

/* Copy raw[count], of this type, to out[count] as slope * value + intercept; for load_numbers only.
 */
#define SCALE(type)                                                                                \
    do {                                                                                           \
        const type *in = raw;                                                                      \
        for (size_t i = 0; i < count; i++)                                                         \
            out[i] = slope * (double)in[i] + intercept;                                            \
    } while (0)

/* Write the numbers of raw[count], stored as the source's type in this machine's byte order, to
 * out[count]. */
static void load_numbers(const sc_source *source, const void *raw, size_t count, double *out)
{
    const double slope = source->slope, intercept = source->intercept;

    switch (source->type) {
        INTEGER_CASES(SCALE);
        CASE(FLOAT, float, SCALE);
        CASE(DOUBLE, double, SCALE);
    }
}

sc_status sc_stream_next_numbers(sc_voxel_stream *s, size_t count, double *out)
{
    const void *raw;

    SC_PASS(sc_stream_stored(s, count, &raw));
    if (s->source->stored.swapped) {
        swap_bytes(raw, count, sc_voxel_type_bytes(s->source->type), s->swapped);
        raw = s->swapped;
    }
    load_numbers(s->source, raw, count, out);
    s->position += count;
    return SC_OK;
}
