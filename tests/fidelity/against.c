/* SPDX-License-Identifier: BSD-3-Clause */
/* Compares the surfaces of a volume with those of the volume that it was made from, its truth. */
#include "against.h"

#include <stdlib.h>
#include <string.h>

enum { QUERIES = 400000 }; /* about how many distances are measured in each direction */

/* A comparison at work. */
typedef struct work {
    const comparison *c;
    sc_volume truth, volume;
    region in;
    tissue *tissues; /* [count] */
    int count;
    int *tissue_of_truth, *tissue_of_volume; /* by dense id; -1 for background and others */
    tiles **surfaces; /* [count]: for each tissue, the list that add_drawn fills */
} work;

bool region_holds(const region *r, sc_vec3 mm)
{
    const sc_vec3 p = sc_affine_point(&r->to_voxel, mm);
    const double at[3] = {p.x, p.y, p.z};

    for (int i = 0; i < 3; i++) {
        if (at[i] < r->low[i] - 0.5 || at[i] > r->high[i] + 0.5)
            return false;
    }
    return true;
}

/* Set the region that the volumes have in common: two voxels within the middles of the outermost
 * voxels of both. Where a volume ends, its outermost voxels have surfaces that are none of it, one
 * voxel deep; a region of that depth would hold bits of these. Exact for volumes whose axes are
 * parallel. @return SC_ERR_DATA if it is empty. */
static sc_status set_region(const sc_ctx *ctx, work *w)
{
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    region *r = &w->in;

    r->to_ras_mm = w->truth.to_ras_mm;
    (void)sc_affine_invert(&r->to_ras_mm, &r->to_voxel);
    for (int n = 0; n < 8; n++) {
        const int *size = w->volume.size;
        const sc_vec3 corner = {n & 1 ? size[0] - 1 : 0, n & 2 ? size[1] - 1 : 0,
                                n & 4 ? size[2] - 1 : 0};
        const sc_vec3 p =
            sc_affine_point(&r->to_voxel, sc_affine_point(&w->volume.to_ras_mm, corner));
        const double at[3] = {p.x, p.y, p.z};

        for (int i = 0; i < 3; i++) {
            low[i] = fmin(low[i], at[i]);
            high[i] = fmax(high[i], at[i]);
        }
    }
    for (int i = 0; i < 3; i++) {
        r->low[i] = (int)ceil(fmax(0, low[i]) + 1.999);
        r->high[i] = (int)floor(fmin(w->truth.size[i] - 1, high[i]) - 1.999);
        if (r->low[i] > r->high[i])
            return sc_fail(ctx, SC_ERR_DATA, "%s and %s have no space in common", w->c->truth,
                           w->c->volume);
    }
    return SC_OK;
}

/* Read both volumes and match their labels by value. @return errors of reading, SC_ERR_DATA if
 * they have no tissue or no space in common, SC_ERR_MEMORY. */
static sc_status open_work(const sc_ctx *ctx, work *w)
{
    void *block;
    int common = 0;
    sc_status status;

    SC_TRY(sc_volume_read(ctx, w->c->truth, &w->truth));
    SC_TRY(sc_volume_read(ctx, w->c->volume, &w->volume));
    SC_TRY(sc_zalloc(ctx, (size_t)w->truth.label_count, sizeof(tissue), &block));
    w->tissues = block;
    SC_TRY(sc_alloc(ctx, (size_t)w->truth.label_count, sizeof *w->surfaces, &block));
    w->surfaces = block;
    SC_TRY(sc_alloc(ctx, (size_t)w->truth.label_count, sizeof(int), &block));
    w->tissue_of_truth = block;
    SC_TRY(sc_alloc(ctx, (size_t)w->volume.label_count, sizeof(int), &block));
    w->tissue_of_volume = block;
    w->count = w->truth.label_count - 1;
    for (int id = 0; id < w->volume.label_count; id++)
        w->tissue_of_volume[id] = -1;
    w->tissue_of_truth[0] = -1;
    for (int n = 0; n < w->count; n++) {
        const sc_label *label = &w->truth.labels[n + 1];

        w->tissue_of_truth[n + 1] = n;
        w->tissues[n] = (tissue){.value = label->value, .name = label->name};
        for (int id = 1; id < w->volume.label_count; id++) {
            if (w->volume.labels[id].value != label->value)
                continue;
            w->tissues[n].in_volume = true;
            w->tissue_of_volume[id] = n;
            common++;
        }
    }
    if (!common)
        status = sc_fail(ctx, SC_ERR_DATA, "%s and %s have no label in common", w->c->truth,
                         w->c->volume);
    else
        status = set_region(ctx, w);
out:
    return status;
}

/* Free all that the work owns. */
static void close_work(work *w)
{
    for (int n = 0; n < w->count; n++) {
        tiles_free(&w->tissues[n].truth);
        tiles_free(&w->tissues[n].drawn);
        free(w->tissues[n].to.mm);
        free(w->tissues[n].from.mm);
    }
    sc_free(w->tissues);
    sc_free(w->surfaces);
    sc_free(w->tissue_of_truth);
    sc_free(w->tissue_of_volume);
    sc_volume_clear(&w->truth);
    sc_volume_clear(&w->volume);
}

/* What the worker count_layers needs, and its result for each layer. */
typedef struct counting {
    const work *w;
    const stage *st;
    double (*sums)[3]; /* [layers][count]: voxels in the truth, voxels drawn, and mm2 of the faces
                          of the former to other labels */
} counting;

/* Add the area of the faces of the voxel (@p x, @p y, @p z) of the truth, towards the next ones
 * along each axis, to both tissues that they part. */
static void add_area(const work *w, int x, int y, int z, double (*sums)[3])
{
    const sc_volume *v = &w->truth;
    const int own = w->tissue_of_truth[id_at(v, x, y, z)];

    for (int axis = 0; axis < 3; axis++) {
        const int next =
            w->tissue_of_truth[id_at(v, x + (axis == 0), y + (axis == 1), z + (axis == 2))];
        const double area =
            sc_vec3_length(sc_vec3_cross(sc_affine_column(&v->to_ras_mm, (axis + 1) % 3),
                                         sc_affine_column(&v->to_ras_mm, (axis + 2) % 3)));

        if (own == next)
            continue;
        if (own >= 0)
            sums[own][2] += area;
        if (next >= 0)
            sums[next][2] += area;
    }
}

/* Worker of sc_parallel_for: sum up, for layers [@p begin, @p end) of the region, the voxels of
 * each tissue in the truth with their faces, and the random points, one in each voxel, that are
 * drawn as that tissue. */
static void count_layers(void *user, size_t begin, size_t end, int thread)
{
    const counting *k = user;
    const region *r = &k->w->in;
    const sc_volume *v = &k->w->truth;

    for (size_t n = begin; n < end; n++) {
        const int z = r->low[2] + (int)n;
        double(*sums)[3] = k->sums + n * (size_t)k->w->count;
        uint64_t seed = 15485863 * (n + 1);

        for (int y = r->low[1]; y <= r->high[1]; y++) {
            for (int x = r->low[0]; x <= r->high[0]; x++) {
                const int truth = k->w->tissue_of_truth[id_at(v, x, y, z)];
                const double i = x + random_of(&seed) - 0.5, j = y + random_of(&seed) - 0.5;
                const sc_vec3 p = {i, j, z + random_of(&seed) - 0.5};
                int drawn = -1;

                if (k->st)
                    drawn =
                        k->w->tissue_of_volume[owner_at(k->st, sc_affine_point(&v->to_ras_mm, p))];
                add_area(k->w, x, y, z, sums);
                if (truth >= 0)
                    sums[truth][0]++;
                if (drawn >= 0)
                    sums[drawn][1]++;
            }
        }
    }
}

/* Set how much there is of each tissue in the truth, how thick it is there, and how much of it is
 * drawn (@p st), within the region. Without @p st only the former. @return SC_ERR_MEMORY. */
static sc_status measure_volumes(const sc_ctx *ctx, work *w, const stage *st)
{
    const size_t layers = (size_t)(w->in.high[2] - w->in.low[2] + 1), count = (size_t)w->count;
    const double mm3 = fabs(sc_affine_determinant(&w->truth.to_ras_mm));
    counting k = {.w = w, .st = st};
    SC_OWN(sc_free_at) void *block = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, layers * count, sizeof *k.sums, &block));
    k.sums = block;
    sc_parallel_for(w->c->how.threads, layers, 1, count_layers, &k);
    for (size_t n = 0; n < count; n++) {
        double sum[3] = {0};

        for (size_t i = 0; i < layers; i++) {
            for (int j = 0; j < 3; j++)
                sum[j] += k.sums[i * count + n][j];
        }
        w->tissues[n].true_mm3 = sum[0] * mm3;
        /* The faces of the voxels of a surface that lies at random are 1.5 times as large as it. */
        w->tissues[n].thickness_mm = sum[2] > 0 ? 2 * sum[0] * mm3 / (sum[2] / 1.5) : 0;
        if (st)
            w->tissues[n].kept = sum[0] > 0 ? sum[1] / sum[0] : NAN;
    }
out:
    return status;
}

/* The volume in mm3 that a closed mesh encloses within the region: by the divergence theorem for
 * the field that points along z of the truth's voxels, grows with z inside of the region, and is 0
 * beside it. */
static double mesh_volume(const region *r, const mesh *m)
{
    double sum = 0;

    for (size_t i = 0; i < m->triangle_count; i++) {
        sc_vec3 p[3], middle = {0}, cross;

        for (int k = 0; k < 3; k++) {
            p[k] = sc_affine_point(&r->to_voxel, m->vertices[m->triangles[i][k]]);
            middle = sc_vec3_along(middle, 1.0 / 3, p[k]);
        }
        if (middle.x < r->low[0] - 0.5 || middle.x > r->high[0] + 0.5 ||
            middle.y < r->low[1] - 0.5 || middle.y > r->high[1] + 0.5)
            continue;
        cross = sc_vec3_cross(sc_vec3_sub(p[1], p[0]), sc_vec3_sub(p[2], p[0]));
        sum += fmin(r->high[2] + 0.5, fmax(r->low[2] - 0.5, middle.z)) * cross.z / 2;
    }
    return fabs(sum * sc_affine_determinant(&r->to_ras_mm));
}

/* Set the drawn surfaces and volumes of all tissues from the meshes LABEL.ply of the directory
 * c->meshes; a tissue without one is gone. @return errors of reading, with a message. */
static sc_status take_meshes(const sc_ctx *ctx, work *w)
{
    sc_status status = SC_OK;

    SC_TRY(measure_volumes(ctx, w, NULL));
    for (int n = 0; n < w->count; n++) {
        tissue *t = &w->tissues[n];
        mesh m = {0};
        char path[4096];

        if (!t->in_volume)
            continue;
        snprintf(path, sizeof path, "%s/%lld.ply", w->c->meshes, (long long)t->value);
        status = mesh_read(ctx, path, &m);
        if (status == SC_OK) {
            add_mesh(&m, &t->drawn);
            t->kept = mesh_volume(&w->in, &m) / t->true_mm3;
        }
        mesh_free(&m);
        if (status != SC_OK)
            break;
    }
out:
    return status;
}

/* Draw @p volume as @p how says and add its surfaces to those of the tissues: the drawn ones, for
 * which volumes are measured too, or with @p is_truth the true ones. */
static sc_status take_drawn(const sc_ctx *ctx, work *w, const sc_volume *volume, const drawing *how,
                            bool is_truth)
{
    const int *tissue_of = is_truth ? w->tissue_of_truth : w->tissue_of_volume;
    SC_OWN(stage_close) stage st = {0};
    sc_status status;

    for (int n = 0; n < w->count; n++)
        w->surfaces[n] = is_truth ? &w->tissues[n].truth : &w->tissues[n].drawn;
    SC_TRY(stage_open(ctx, volume, how, 1.02, 0.1, &st));
    SC_TRY(add_drawn(ctx, &st, tissue_of, how->threads, w->surfaces));
    if (!is_truth)
        SC_TRY(measure_volumes(ctx, w, &st));
out:
    return status;
}

/* What the worker query needs: points, the tree from which their distances are measured, and where
 * these go: every stride-th of the points, NAN for those outside of the region. */
typedef struct querying {
    const tiles *points;
    const tree *from;
    const region *in;
    size_t stride;
    double *mm;
} querying;

/* Worker of sc_parallel_for: measure distances [@p begin, @p end). */
static void query(void *user, size_t begin, size_t end, int thread)
{
    const querying *q = user;

    for (size_t i = begin; i < end; i++) {
        const float *m = q->points->list[i * q->stride].middle;
        const sc_vec3 p = {(double)m[0], (double)m[1], (double)m[2]};

        q->mm[i] = region_holds(q->in, p) ? tree_distance(q->from, p) : NAN;
    }
}

/* Measure the distances of every @p stride-th of @p points, as far as they lie in the region, from
 * the nearest of the tiles that @p from holds, to @p out. @return SC_ERR_MEMORY. */
static sc_status measure_distances(const sc_ctx *ctx, const work *w, const tiles *points,
                                   const tree *from, size_t stride, distances *out)
{
    const size_t count = (points->count + stride - 1) / stride;
    querying q = {.points = points, .from = from, .in = &w->in, .stride = stride};

    out->mm = malloc((count + 1) * sizeof(double));
    if (!out->mm)
        return sc_fail(ctx, SC_ERR_MEMORY, "no memory for %zu distances", count);
    q.mm = out->mm;
    sc_parallel_for(w->c->how.threads, count, 256, query, &q);
    for (size_t i = 0; i < count; i++) {
        if (!isnan(out->mm[i]))
            out->mm[out->count++] = out->mm[i];
    }
    return SC_OK;
}

/* Measure the distances between the surfaces of all tissues that both volumes have. */
static sc_status measure_surfaces(const sc_ctx *ctx, work *w)
{
    size_t drawn = 0, truth = 0;
    sc_status status = SC_OK;

    for (int n = 0; n < w->count; n++) {
        drawn += w->tissues[n].drawn.count;
        truth += w->tissues[n].truth.count;
    }
    for (int n = 0; n < w->count && status == SC_OK; n++) {
        tissue *t = &w->tissues[n];
        tree *trees[2] = {NULL, NULL};

        if (!t->drawn.count || !t->truth.count)
            continue;
        status = tree_build(ctx, &t->truth, &trees[0]);
        if (status == SC_OK)
            status = tree_build(ctx, &t->drawn, &trees[1]);
        if (status == SC_OK)
            status = measure_distances(ctx, w, &t->drawn, trees[0], 1 + drawn / QUERIES, &t->to);
        if (status == SC_OK)
            status = measure_distances(ctx, w, &t->truth, trees[1], 1 + truth / QUERIES, &t->from);
        tree_free(trees[0]);
        tree_free(trees[1]);
    }
    return status;
}

sc_status compare_volumes(const sc_ctx *ctx, const comparison *c)
{
    SC_OWN(close_work) work w = {.c = c};
    drawing how = c->how;
    sc_status status;

    SC_TRY(open_work(ctx, &w));
    if (isnan(c->truth_smooth)) {
        for (int n = 0; n < w.count; n++)
            w.surfaces[n] = &w.tissues[n].truth;
        add_faces(&w.truth, w.tissue_of_truth, w.surfaces);
    } else {
        how.surface = SC_SURFACE_SMOOTH;
        how.smooth = c->truth_smooth;
        SC_TRY(take_drawn(ctx, &w, &w.truth, &how, true));
    }
    if (c->meshes)
        SC_TRY(take_meshes(ctx, &w));
    else
        SC_TRY(take_drawn(ctx, &w, &w.volume, &c->how, false));
    SC_TRY(measure_surfaces(ctx, &w));
    print_comparison(c, w.tissues, w.count);
out:
    return status;
}
