/* SPDX-License-Identifier: BSD-3-Clause */
/* Labels of any width become dense ids: background 0 first, then the other values in rising
 * order. Neighbouring voxels mostly agree, so a look-up is done once per run of equal values. */
#include "raw.h"

#include <stdlib.h>
#include <string.h>

enum { BLOCK = 4096, SLOTS = 1 << 18 };

/* Open-addressing set of label values, each with its dense id. */
typedef struct value_set {
    int64_t *values;
    int32_t *ids; /* -1: slot free */
    int count;
} value_set;

typedef struct densifier {
    const sc_ctx *ctx;
    const char *path;
    const sc_raw *raw;
    value_set set;
} densifier;

static size_t slot_of(const value_set *set, int64_t value)
{
    size_t slot = (size_t)(((uint64_t)value * 0x9e3779b97f4a7c15u) >> 46);

    while (set->ids[slot] >= 0 && set->values[slot] != value)
        slot = (slot + 1) & (SLOTS - 1);
    return slot;
}

static sc_status set_add(const densifier *job, value_set *set, int64_t value)
{
    const size_t slot = slot_of(set, value);

    if (set->ids[slot] >= 0)
        return SC_OK;
    if (set->count == SC_LABELS_MAX)
        return sc_fail(job->ctx, SC_ERR_DATA,
                       "%s: more than %d different labels; is this a grey-value image?", job->path,
                       SC_LABELS_MAX - 1);
    set->values[slot] = value;
    set->ids[slot] = set->count++;
    return SC_OK;
}

#define WIDEN(type)                                                                                \
    do {                                                                                           \
        const type *in = (const type *)job->raw->data + begin;                                     \
        for (size_t i = 0; i < count; i++)                                                         \
            out[i] = (int64_t)in[i];                                                               \
    } while (0)

static sc_status bad_voxel(const densifier *job, size_t index, double value, const char *what)
{
    const size_t nx = (size_t)job->raw->size[0], ny = (size_t)job->raw->size[1];

    return sc_fail(job->ctx, SC_ERR_DATA,
                   "%s: voxel (%zu, %zu, %zu) holds %.10g, %s; expected whole label numbers",
                   job->path, index % nx, index / nx % ny, index / nx / ny, value, what);
}

/* Values of voxels [begin, begin + count) as whole numbers, or the reason why they are not. */
static sc_status load_scaled(const densifier *job, size_t begin, size_t count, int64_t *out)
{
    const sc_raw *raw = job->raw;

    for (size_t i = 0; i < count; i++) {
        double value = (double)out[i];

        if (raw->type == SC_RAW_FLOAT)
            value = ((const float *)raw->data)[begin + i];
        else if (raw->type == SC_RAW_DOUBLE)
            value = ((const double *)raw->data)[begin + i];
        value = raw->slope * value + raw->intercept;
        if (!isfinite(value))
            return bad_voxel(job, begin + i, value, "not a number");
        if (value != floor(value))
            return bad_voxel(job, begin + i, value, "a fraction");
        if (fabs(value) > 9007199254740992.0)
            return bad_voxel(job, begin + i, value, "too large for a label");
        out[i] = (int64_t)value;
    }
    return SC_OK;
}

static sc_status load_block(const densifier *job, size_t begin, size_t count, int64_t *out)
{
    switch (job->raw->type) {
    case SC_RAW_INT8:
        WIDEN(int8_t);
        break;
    case SC_RAW_UINT8:
        WIDEN(uint8_t);
        break;
    case SC_RAW_INT16:
        WIDEN(int16_t);
        break;
    case SC_RAW_UINT16:
        WIDEN(uint16_t);
        break;
    case SC_RAW_INT32:
        WIDEN(int32_t);
        break;
    case SC_RAW_UINT32:
        WIDEN(uint32_t);
        break;
    case SC_RAW_INT64:
        WIDEN(int64_t);
        break;
    case SC_RAW_UINT64:
        WIDEN(uint64_t);
        for (size_t i = 0; i < count; i++) {
            if (out[i] < 0)
                return bad_voxel(job, begin + i, (double)(uint64_t)out[i], "too large for a label");
        }
        break;
    case SC_RAW_FLOAT:
    case SC_RAW_DOUBLE:
        return load_scaled(job, begin, count, out);
    }
    if (job->raw->slope != 1 || job->raw->intercept != 0)
        return load_scaled(job, begin, count, out);
    return SC_OK;
}

static sc_status collect_values(densifier *job, size_t voxels)
{
    int64_t block[BLOCK], last = 0;
    sc_status status;

    SC_TRY(set_add(job, &job->set, 0));
    for (size_t begin = 0; begin < voxels; begin += BLOCK) {
        const size_t count = voxels - begin < BLOCK ? voxels - begin : BLOCK;

        SC_TRY(load_block(job, begin, count, block));
        for (size_t i = 0; i < count; i++) {
            if (block[i] == last)
                continue;
            last = block[i];
            SC_TRY(set_add(job, &job->set, last));
        }
    }
out:
    return status;
}

static int by_value(const void *a, const void *b)
{
    const int64_t x = ((const sc_label *)a)->value, y = ((const sc_label *)b)->value;

    return (x > y) - (x < y);
}

/* Background stays first; the rest is sorted, and the set learns the final ids. */
static void number_labels(densifier *job, sc_label *labels)
{
    value_set *set = &job->set;

    for (size_t slot = 0; slot < SLOTS; slot++) {
        if (set->ids[slot] >= 0)
            labels[set->ids[slot]].value = set->values[slot];
    }
    qsort(labels + 1, (size_t)set->count - 1, sizeof *labels, by_value);
    for (int i = 0; i < set->count; i++) {
        set->ids[slot_of(set, labels[i].value)] = i;
        labels[i].opacity = -1;
    }
}

static sc_status write_ids(const densifier *job, size_t voxels, sc_volume *volume)
{
    int64_t block[BLOCK], last = 0;
    int32_t id = 0;
    sc_status status = SC_OK;

    for (size_t begin = 0; begin < voxels; begin += BLOCK) {
        const size_t count = voxels - begin < BLOCK ? voxels - begin : BLOCK;

        SC_TRY(load_block(job, begin, count, block));
        for (size_t i = 0; i < count; i++) {
            if (block[i] != last) {
                last = block[i];
                id = job->set.ids[slot_of(&job->set, last)];
            }
            if (volume->label_bytes == 1)
                ((uint8_t *)volume->ids)[begin + i] = (uint8_t)id;
            else
                ((uint16_t *)volume->ids)[begin + i] = (uint16_t)id;
        }
    }
out:
    return status;
}

sc_status sc_densify(const sc_ctx *ctx, const char *path, const sc_raw *raw, sc_volume *out)
{
    const size_t voxels = (size_t)raw->size[0] * (size_t)raw->size[1] * (size_t)raw->size[2];
    densifier job = {.ctx = ctx, .path = path, .raw = raw};
    sc_volume volume = {.size = {raw->size[0], raw->size[1], raw->size[2]}};
    void *values = NULL, *ids = NULL, *labels = NULL;
    sc_status status;

    SC_TRY(sc_alloc(ctx, SLOTS, sizeof(int64_t), &values));
    SC_TRY(sc_alloc(ctx, SLOTS, sizeof(int32_t), &ids));
    memset(ids, 0xff, SLOTS * sizeof(int32_t));
    job.set = (value_set){.values = values, .ids = ids};
    SC_TRY(collect_values(&job, voxels));
    SC_TRY(sc_zalloc(ctx, (size_t)job.set.count, sizeof(sc_label), &labels));
    volume.labels = labels;
    volume.label_count = job.set.count;
    volume.label_bytes = job.set.count <= 256 ? 1 : 2;
    number_labels(&job, volume.labels);
    SC_TRY(sc_alloc(ctx, voxels, (size_t)volume.label_bytes, &volume.ids));
    SC_TRY(write_ids(&job, voxels, &volume));
    *out = volume;
    volume = (sc_volume){0};
out:
    sc_volume_clear(&volume);
    sc_free(values);
    sc_free(ids);
    return status;
}
