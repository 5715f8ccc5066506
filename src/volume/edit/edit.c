/* SPDX-License-Identifier: BSD-3-Clause */
/* Changes of a volume that was read: labels left out or merged, and parts cut off. */
#include "segcast/grey.h"
#include "source.h"

#include <stdlib.h>

/* ---- labels ---- */

sc_status sc_relabel_make(const sc_ctx *ctx, const sc_label *labels, int count, const int *into,
                          const char *const *names, sc_relabel *out)
{
    SC_OWN(sc_relabel_clear) sc_relabel made = {0};

    SC_PASS(SC_ZALLOC(ctx, (size_t)count, &made.to));
    SC_PASS(SC_ALLOC(ctx, (size_t)count, &made.labels));
    for (int id = 0; id < count; id++) {
        if (into[id] != id)
            continue;
        made.to[id] = made.label_count;
        made.labels[made.label_count] = labels[id];
        if (names && names[id])
            snprintf(made.labels[made.label_count].name, SC_NAME_BYTES, "%s", names[id]);
        made.label_count++;
    }
    for (int id = 1; id < count; id++) {
        sc_label *label;

        if (into[id] == id)
            continue;
        made.to[id] = made.to[into[id]];
        label = &made.labels[made.to[id]];
        if (made.to[id] && labels[id].has_color && !label->has_color) {
            memcpy(label->rgb, labels[id].rgb, sizeof label->rgb);
            label->has_color = true;
        }
    }
    SC_HAND_OVER(made, out);
    return SC_OK;
}

void sc_relabel_clear(sc_relabel *relabel)
{
    sc_free(relabel->to);
    sc_free(relabel->labels);
    *relabel = (sc_relabel){0};
}

/* A label of a volume, or a row that is to become one. */
typedef struct candidate {
    const sc_label *label;
    int id; /* dense id; of a row 0 */
} candidate;

/* For qsort of candidate: rising by value; of one value the label first, then the first row. */
static int by_value(const void *a, const void *b)
{
    const candidate *x = a, *y = b;

    if (x->label->value != y->label->value)
        return (x->label->value > y->label->value) - (x->label->value < y->label->value);
    if (x->id != y->id)
        return (y->id > x->id) - (y->id < x->id);
    return (x->label > y->label) - (x->label < y->label);
}

sc_status sc_relabel_with(const sc_ctx *ctx, const sc_label *labels, int label_count,
                          const sc_label_table *more, sc_relabel *out)
{
    const size_t most = (size_t)label_count + more->count;
    SC_OWN(sc_relabel_clear) sc_relabel made = {.label_count = 1};
    SC_OWN(sc_free_at) candidate *all = NULL;
    size_t count = 0;

    SC_PASS(SC_ZALLOC(ctx, (size_t)label_count, &made.to));
    SC_PASS(SC_ALLOC(ctx, most, &made.labels));
    SC_PASS(SC_ALLOC(ctx, most, &all));
    for (int id = 1; id < label_count; id++)
        all[count++] = (candidate){&labels[id], id};
    for (size_t i = 0; i < more->count; i++) {
        if (more->rows[i].value)
            all[count++] = (candidate){&more->rows[i], 0};
    }
    qsort(all, count, sizeof *all, by_value);
    made.labels[0] = labels[0];
    for (size_t i = 0; i < count; i++) {
        sc_label *label = &made.labels[made.label_count];

        if (i && all[i].label->value == all[i - 1].label->value)
            continue;
        *label = *all[i].label;
        if (!label->has_color && !all[i].id)
            sc_label_base_color(label->value, label->rgb);
        if (all[i].id)
            made.to[all[i].id] = made.label_count;
        made.label_count++;
    }
    SC_HAND_OVER(made, out);
    return SC_OK;
}

sc_status sc_volume_add_labels(const sc_ctx *ctx, sc_volume *volume, const sc_label_table *table)
{
    SC_OWN(sc_relabel_clear) sc_relabel made = {0};

    SC_PASS(sc_relabel_with(ctx, volume->labels, volume->label_count, table, &made));
    sc_free(volume->labels);
    SC_HAND_OVER(made.labels, &volume->labels);
    volume->label_count = made.label_count;
    sc_volume_apply_table(volume, table);
    return SC_OK;
}

static const sc_label_tally no_voxels = {0, {0, 0, 0}, {-1, -1, -1}};

/* What the threads share that give voxels other ids. */
typedef struct relabel_work {
    const void *from;
    void *to;                 /* the same, or ids of two bytes instead of one */
    int from_bytes, to_bytes; /* of an id */
    const int *map;
} relabel_work;

/* An sc_range_fn over voxels: replaces their ids, a run of equal ones at a time. @p user is a
 * relabel_work. Ids that do not change are not written, so that the system never has to provide
 * memory for pages that hold only background. */
static void relabel_range(void *user, size_t begin, size_t end, int thread)
{
    const relabel_work *w = user;
    const char *from = (const char *)w->from + begin * (size_t)w->from_bytes;
    uint16_t *wide = (uint16_t *)w->to + begin;
    const int count = (int)(end - begin);

    for (int i = 0, next; i < count; i = next) {
        int64_t id;
        int becomes;

        next =
            sc_run_end(w->from_bytes == 1 ? SC_VOXEL_UINT8 : SC_VOXEL_UINT16, from, i, count, &id);
        becomes = w->map[id];
        if (w->to == w->from ? becomes == id : !becomes)
            continue;
        if (w->to_bytes == 1)
            memset((uint8_t *)w->to + begin + i, becomes, (size_t)(next - i));
        for (int k = i; k < next && w->to_bytes == 2; k++)
            wide[k] = (uint16_t)becomes;
    }
}

sc_status sc_ids_map(const sc_ctx *ctx, size_t voxels, const int *map, int to_bytes, int threads,
                     int *bytes, void **ids)
{
    relabel_work w = {*ids, *ids, *bytes, to_bytes, map};

    if (to_bytes > *bytes)
        SC_PASS(sc_zalloc(ctx, voxels, (size_t)to_bytes, &w.to));
    sc_parallel_for(threads, voxels, 1 << 20, relabel_range, &w);
    if (w.to != *ids)
        sc_free(*ids);
    *ids = w.to;
    *bytes = to_bytes;
    return SC_OK;
}

void sc_volume_hide(sc_volume *volume, const bool *hidden, int threads)
{
    int map[SC_LABELS_MAX];
    const sc_ctx quiet = {.rank = 0};
    bool any = false;

    for (int id = 0; id < volume->label_count; id++) {
        map[id] = hidden[id] ? 0 : id;
        any = any || (id && hidden[id]);
    }
    if (any)
        (void)sc_ids_map(&quiet, sc_volume_voxels(volume), map, volume->label_bytes, threads,
                         &volume->label_bytes, &volume->ids); /* which needs no memory */
}

/* Add up the tallies of a volume by their new labels, in tallies[relabel->label_count]. */
static void relabel_tallies(const sc_volume *volume, const sc_relabel *relabel,
                            sc_label_tally *tallies)
{
    for (int id = 0; id < relabel->label_count; id++)
        tallies[id] = no_voxels;
    for (int id = 0; id < volume->label_count; id++) {
        const sc_label_tally *from = &volume->tallies[id];

        if (from->voxels)
            sc_tally_add(&tallies[relabel->to[id]], from->low, from->high, from->voxels);
    }
}

sc_status sc_volume_relabel(const sc_ctx *ctx, sc_volume *volume, sc_relabel *relabel, int threads)
{
    SC_OWN(sc_free_at) sc_label_tally *tallies = NULL;

    if (volume->tallies) {
        SC_PASS(SC_ALLOC(ctx, (size_t)relabel->label_count, &tallies));
        relabel_tallies(volume, relabel, tallies);
    }
    if (volume->ids)
        SC_PASS(sc_ids_map(ctx, sc_volume_voxels(volume), relabel->to,
                           relabel->label_count > UINT8_MAX + 1 ? 2 : volume->label_bytes, threads,
                           &volume->label_bytes, &volume->ids));
    sc_free(volume->tallies);
    SC_HAND_OVER(tallies, &volume->tallies);
    sc_free(volume->labels);
    SC_HAND_OVER(relabel->labels, &volume->labels);
    volume->label_count = relabel->label_count;
    return SC_OK;
}

/* ---- boxes ---- */

sc_voxel_box sc_voxels_between(const int size[3], const sc_affine *to_ras_mm,
                               const sc_vec3 corners[2])
{
    sc_voxel_box box;
    sc_affine to_voxel;
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

    (void)sc_affine_invert(to_ras_mm, &to_voxel); /* readers refuse what has no inverse */
    for (int corner = 0; corner < 8; corner++) {
        const sc_vec3 p =
            sc_affine_point(&to_voxel, (sc_vec3){corners[corner & 1].x, corners[corner >> 1 & 1].y,
                                                 corners[corner >> 2 & 1].z});
        const double at[3] = {p.x, p.y, p.z};

        for (int axis = 0; axis < 3; axis++) {
            low[axis] = fmin(low[axis], at[axis]);
            high[axis] = fmax(high[axis], at[axis]);
        }
    }
    for (int axis = 0; axis < 3; axis++) {
        box.low[axis] = (int)fmax(0, fmin(ceil(low[axis] - 1e-6), size[axis]));
        box.high[axis] = (int)fmin(size[axis] - 1, fmax(floor(high[axis] + 1e-6), -1));
    }
    return box;
}

sc_box3 sc_grid_box_mm(const int size[3], const sc_affine *to_ras_mm)
{
    sc_box3 box = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};

    for (int corner = 0; corner < 8; corner++) {
        const sc_vec3 at = {corner & 1 ? size[0] - 0.5 : -0.5, corner & 2 ? size[1] - 0.5 : -0.5,
                            corner & 4 ? size[2] - 0.5 : -0.5};
        const sc_vec3 p = sc_affine_point(to_ras_mm, at);

        box.low = (sc_vec3){fmin(box.low.x, p.x), fmin(box.low.y, p.y), fmin(box.low.z, p.z)};
        box.high = (sc_vec3){fmax(box.high.x, p.x), fmax(box.high.y, p.y), fmax(box.high.z, p.z)};
    }
    return box;
}

sc_voxel_box sc_volume_box(const sc_volume *volume, const bool *which)
{
    const int *size = volume->size;
    sc_voxel_box box = {{size[0], size[1], size[2]}, {-1, -1, -1}};
    size_t row = 0;

    for (int z = 0; z < size[2]; z++) {
        for (int y = 0; y < size[1]; y++, row += (size_t)size[0]) {
            int first = 0, last = size[0] - 1;

            while (first < size[0] && !(sc_volume_id(volume, row + (size_t)first) &&
                                        which[sc_volume_id(volume, row + (size_t)first)]))
                first++;
            if (first == size[0])
                continue;
            while (!(sc_volume_id(volume, row + (size_t)last) &&
                     which[sc_volume_id(volume, row + (size_t)last)]))
                last--;
            box.low[0] = first < box.low[0] ? first : box.low[0];
            box.high[0] = last > box.high[0] ? last : box.high[0];
            box.low[1] = y < box.low[1] ? y : box.low[1];
            box.high[1] = y > box.high[1] ? y : box.high[1];
            box.low[2] = z < box.low[2] ? z : box.low[2];
            box.high[2] = z;
        }
    }
    return box;
}

/* Keep only the ids of the voxels of a box. */
static void crop_ids(sc_volume *volume, const sc_voxel_box *box)
{
    const size_t bytes = (size_t)volume->label_bytes;
    const size_t row = (size_t)(box->high[0] - box->low[0] + 1) * bytes;
    uint8_t *ids = volume->ids, *to = ids;

    /* Rows move towards the begin, in the order in which they stand: none is overwritten before it
     * has moved. */
    for (int z = box->low[2]; z <= box->high[2]; z++) {
        for (int y = box->low[1]; y <= box->high[1]; y++, to += row) {
            const size_t voxel =
                ((size_t)z * (size_t)volume->size[1] + (size_t)y) * (size_t)volume->size[0] +
                (size_t)box->low[0];

            memmove(to, ids + voxel * bytes, row);
        }
    }
}

/* Cut off the boxes of labels at a box. */
static void crop_tallies(sc_volume *volume, const sc_voxel_box *box)
{
    for (int id = 0; id < volume->label_count; id++) {
        sc_label_tally *tally = &volume->tallies[id];
        bool is_empty = tally->voxels == 0;

        for (int axis = 0; axis < 3; axis++) {
            const int low = tally->low[axis] > box->low[axis] ? tally->low[axis] : box->low[axis];
            const int high =
                tally->high[axis] < box->high[axis] ? tally->high[axis] : box->high[axis];

            tally->low[axis] = low - box->low[axis];
            tally->high[axis] = high - box->low[axis];
            is_empty = is_empty || low > high;
        }
        if (is_empty)
            *tally = no_voxels;
    }
}

void sc_volume_crop(sc_volume *volume, const sc_voxel_box *box)
{
    const sc_vec3 first =
        sc_affine_point(&volume->to_ras_mm,
                        (sc_vec3){(double)box->low[0], (double)box->low[1], (double)box->low[2]});

    if (volume->ids)
        crop_ids(volume, box);
    if (volume->tallies)
        crop_tallies(volume, box);
    volume->to_ras_mm.m[0][3] = first.x;
    volume->to_ras_mm.m[1][3] = first.y;
    volume->to_ras_mm.m[2][3] = first.z;
    for (int axis = 0; axis < 3; axis++)
        volume->size[axis] = box->high[axis] - box->low[axis] + 1;
}
