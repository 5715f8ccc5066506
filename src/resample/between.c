/* SPDX-License-Identifier: BSD-3-Clause */
/* What lies between two phases of a series: borders that move instead of jumping. Shape-based
 * interpolation (Raya and Udupa, Shape-Based Interpolation of Multidimensional Objects, 1990) in
 * time: a voxel that changes from one label to another does so when the border between them, which
 * is to come from as far away as it was in the first phase and to go as far as it is in the second,
 * passes it. Only voxels that change are looked at, so that what stands still stays as it is.
 *
 * Interpolated signed distances of each label by itself would tear a wall that moves by more than
 * its thickness: halfway, no place is nearer to the wall than to what lies on its sides. So a third
 * label may pass a voxel between the two: it begins where its front, and ends where its back
 * arrives. It is one that moves itself, by the voxels that it leaves and those that it takes, and
 * lies nearer than the second label in the first phase, and nearer than the first label in the
 * second; so no label is invented that neither phase has at that border.
 *
 * Thin tissue within one other, such as the leaflets of a valve or a small vessel, leaves no voxel
 * behind that changes from one label to another. Where it moves so far that the two phases do not
 * overlap, its voxels are carried along straight lines to the nearest of the other phase. */
#include "internal.h"

enum {
    MARGIN = 12 /* voxels around those that change in which their borders are looked for */
};
#define FAR 1e18f /* the square of a distance from nothing */

/* What becomes of one voxel that changes. Until all is known, leave and arrive hold distances. */
typedef struct change {
    size_t at;                  /* its index */
    uint16_t from, to, through; /* dense ids; through: of the label that passes, or from */
    float leave, arrive;        /* when the first label leaves, and the second arrives, 0 to 1 */
} change;

/* A voxel of thin tissue that is carried from one place to another. */
typedef struct carrier {
    int from[3], to[3]; /* voxels along x, y, z in the first phase, and in the second */
    uint16_t id;
} carrier;

struct sc_between {
    change *all; /* [count], in the order of the voxels; owned */
    size_t count;
    carrier *carriers; /* [carrier_count], of at most 2 count; owned; NULL: there are none */
    size_t carrier_count;
    int size[3];
};

/* A box of voxels, in which distances are measured. */
typedef struct field {
    int low[3], size[3];
    float *squared;   /* [z][y][x], mm^2; owned by between_work */
    int32_t *nearest; /* [z][y][x], likewise */
} field;

/* The work on two phases. */
typedef struct between_work {
    const sc_volume *a, *b;
    sc_between *result;
    sc_label_tally *boxes; /* [label_count], around the voxels that change from or to a label */
    uint64_t *voxels;      /* [label_count], of each label in the first phase; owned */
    float *near;           /* [count]: the least sum of distances of a third label, then
                              [count][2] these: in the first phase and in the second; owned */
    float *values[2];      /* room for two fields; owned */
    int32_t *nearest[2];   /* of each value, which voxel of the field it is from; owned */
    float *scratch;        /* [threads][3][longest line + 1]; owned */
    int32_t *places;       /* [threads][longest line + 1]; owned */
    size_t line;           /* longest line + 1 */
    float step_mm[3];
    int threads;
    /* what is being measured */
    field field;
    int id, axis;
    bool moved;          /* voxels that have the label in both phases do not count */
    const sc_volume *in; /* a or b */
} between_work;

/* ---- distances ---- */

/* Is the voxel one of those from which distances are measured? */
static bool is_source(const between_work *w, size_t at)
{
    const sc_volume *against = w->in == w->a ? w->b : w->a;

    return (int)sc_volume_id(w->in, at) == w->id &&
           (!w->moved || (int)sc_volume_id(against, at) != w->id);
}

/* @return the index in the volume of the first voxel of row @p row of the field. */
static size_t row_begin(const between_work *w, size_t row)
{
    const field *f = &w->field;
    const size_t y = row % (size_t)f->size[1] + (size_t)f->low[1];
    const size_t z = row / (size_t)f->size[1] + (size_t)f->low[2];

    return (z * (size_t)w->a->size[1] + y) * (size_t)w->a->size[0] + (size_t)f->low[0];
}

/* Measure along the rows [begin, end); an sc_range_fn on between_work. */
static void measure_rows(void *user, size_t begin, size_t end, int thread)
{
    const between_work *w = user;
    const int nx = w->field.size[0];

    for (size_t row = begin; row < end; row++) {
        const size_t at = row_begin(w, row);
        float *out = w->field.squared + row * (size_t)nx;
        int32_t *nearest = w->field.nearest + row * (size_t)nx;
        const int32_t first = (int32_t)(row * (size_t)nx);
        float steps = FAR;

        for (int x = 0; x < nx; x++) {
            steps = is_source(w, at + (size_t)x) ? 0 : steps + 1;
            out[x] = steps;
            nearest[x] = steps < 1e9f ? first + x - (int32_t)steps : first;
        }
        steps = FAR;
        for (int x = nx - 1; x >= 0; x--) {
            steps = out[x] == 0 ? 0 : steps + 1;
            nearest[x] = steps < out[x] ? first + x + (int32_t)steps : nearest[x];
            out[x] = steps < out[x] ? steps : out[x];
        }
        for (int x = 0; x < nx; x++)
            out[x] = out[x] < 1e9f ? out[x] * w->step_mm[0] * (out[x] * w->step_mm[0]) : FAR;
    }
}

/* Turn the squared distances of a line into those that may also lead along it: the lower envelope
 * of parabolas (Felzenszwalb and Huttenlocher, Distance Transforms of Sampled Functions, 2012).
 * @param first of the values of the line, @p stride apart, w->field.size[w->axis] of them. @param
 * scratch [3][w->line]. @param places [w->line] */
static void measure_line(const between_work *w, size_t first, size_t stride, float *scratch,
                         int32_t *places)
{
    const size_t line = w->line;
    float *values = w->field.squared + first, *at = scratch;
    float *height = scratch + line, *from = scratch + 2 * line;
    int32_t *nearest = w->field.nearest + first;
    const int count = w->field.size[w->axis];
    const float unit = w->step_mm[w->axis] * w->step_mm[w->axis];
    int parabolas = 0;

    for (int i = 0; i < count; i++) {
        const float h = values[(size_t)i * stride] / unit;
        float begin = -FAR;

        if (values[(size_t)i * stride] >= FAR)
            continue;
        while (parabolas > 0) {
            const int last = parabolas - 1;

            begin = 0.5f * ((h - height[last]) / ((float)i - at[last]) + (float)i + at[last]);
            if (begin > from[last])
                break;
            begin = -FAR;
            parabolas--;
        }
        at[parabolas] = (float)i;
        height[parabolas] = h;
        from[parabolas++] = begin;
    }
    for (int i = 0; i < parabolas; i++)
        places[i] = nearest[(size_t)at[i] * stride];
    for (int i = 0, n = 0; i < count && parabolas; i++) {
        while (n + 1 < parabolas && from[n + 1] < (float)i)
            n++;
        nearest[(size_t)i * stride] = places[n];
        values[(size_t)i * stride] = unit * (((float)i - at[n]) * ((float)i - at[n]) + height[n]);
    }
}

/* Measure along the lines [begin, end) of w->axis, y or z; an sc_range_fn on between_work. */
static void measure_lines(void *user, size_t begin, size_t end, int thread)
{
    const between_work *w = user;
    const field *f = &w->field;
    const size_t nx = (size_t)f->size[0], slice = nx * (size_t)f->size[1];
    float *scratch = w->scratch + (size_t)thread * 3 * w->line;

    for (size_t n = begin; n < end; n++) {
        const size_t first = w->axis == 1 ? n / nx * slice + n % nx : n;

        measure_line(w, first, w->axis == 1 ? nx : slice, scratch,
                     w->places + (size_t)thread * w->line);
    }
}

/* Fill the field @p which with the squared distances from a label in phase @p in. @param moved
 * those of its voxels alone that it has not in the other phase. */
static void measure(between_work *w, int which, int id, const sc_volume *in, bool moved)
{
    const int *size = w->field.size;

    w->field.squared = w->values[which];
    w->field.nearest = w->nearest[which];
    w->id = id;
    w->in = in;
    w->moved = moved;
    sc_parallel_for(w->threads, (size_t)size[1] * (size_t)size[2], 16, measure_rows, w);
    w->axis = 1;
    sc_parallel_for(w->threads, (size_t)size[0] * (size_t)size[2], 64, measure_lines, w);
    w->axis = 2;
    sc_parallel_for(w->threads, (size_t)size[0] * (size_t)size[1], 64, measure_lines, w);
}

/* Set the field to the voxels of a label that change, and a margin. */
static void set_field(between_work *w, const sc_label_tally *box)
{
    for (int i = 0; i < 3; i++) {
        const int low = box->low[i] - MARGIN, high = box->high[i] + MARGIN;
        const int last = w->a->size[i] - 1;

        w->field.low[i] = low > 0 ? low : 0;
        w->field.size[i] = (high < last ? high : last) - w->field.low[i] + 1;
    }
}

/* Write the place of a voxel of the volume along x, y, z. */
static void place_of(const sc_volume *v, size_t at, int out[3])
{
    const size_t nx = (size_t)v->size[0], ny = (size_t)v->size[1];

    out[0] = (int)(at % nx);
    out[1] = (int)(at / nx % ny);
    out[2] = (int)(at / nx / ny);
}

/* Find the index in the field of a voxel of the volume. @return false outside of the field. */
static bool find_in_field(const between_work *w, size_t at, size_t *out)
{
    const field *f = &w->field;
    size_t index = 0;
    int voxel[3];

    place_of(w->a, at, voxel);
    for (int i = 2; i >= 0; i--) {
        const int along = voxel[i] - f->low[i];

        if (along < 0 || along >= f->size[i])
            return false;
        index = index * (size_t)f->size[i] + (size_t)along;
    }
    *out = index;
    return true;
}

/* @return the distance of voxel @p at from the border of what a field was measured from, in mm, at
 * least half a voxel; FAR outside of the field, and if there is nothing. */
static float border_at(const between_work *w, int which, size_t at)
{
    const float half = 0.5f * fminf(w->step_mm[0], fminf(w->step_mm[1], w->step_mm[2]));
    size_t index;
    float squared;

    if (!find_in_field(w, at, &index))
        return FAR;
    squared = w->values[which][index];
    return squared < FAR ? sqrtf(squared) - half : FAR;
}

/* ---- what changes ---- */

/* Check that what the search and the result take may be used: see sc_between_find. @param changes
 * voxels that change. @param box voxels of the largest box; 0: not known yet. */
static sc_status check_memory(const sc_ctx *ctx, const sc_volume *v, size_t changes, size_t box)
{
    const double bytes =
        (double)sc_volume_voxels(v) * v->label_bytes +
        (double)changes * (sizeof(change) + 2 * sizeof(carrier) + 3 * sizeof(float)) +
        2.0 * (double)box * (sizeof(float) + sizeof(int32_t));

    return sc_memory_check(ctx, bytes, "crop or resample the volumes, leave between out, or ",
                           "cine: between: %zu voxels change from one phase to the next, and to "
                           "interpolate them takes about",
                           changes);
}

/* Fill the list of the voxels that change, and the boxes. @return SC_ERR_MEMORY, SC_ERR_SYSTEM. */
static sc_status list_changes(const sc_ctx *ctx, between_work *w)
{
    const size_t voxels = sc_volume_voxels(w->a), nx = (size_t)w->a->size[0];
    const size_t ny = (size_t)w->a->size[1];
    size_t count = 0;

    for (size_t at = 0; at < voxels; at++) {
        count += sc_volume_id(w->a, at) != sc_volume_id(w->b, at);
        w->voxels[sc_volume_id(w->a, at)]++;
    }
    if (!count)
        return SC_OK;
    SC_PASS(check_memory(ctx, w->a, count, 0));
    SC_PASS(SC_ALLOC(ctx, count, &w->result->all));
    for (size_t at = 0; at < voxels; at++) {
        const uint32_t ids[2] = {sc_volume_id(w->a, at), sc_volume_id(w->b, at)};
        const int voxel[3] = {(int)(at % nx), (int)(at / nx % ny), (int)(at / nx / ny)};

        if (ids[0] == ids[1])
            continue;
        w->result->all[w->result->count++] =
            (change){at, (uint16_t)ids[0], (uint16_t)ids[1], (uint16_t)ids[0], FAR, FAR};
        for (int k = 0; k < 2; k++) {
            sc_label_tally *box = &w->boxes[ids[k]];

            for (int i = 0; i < 3; i++) {
                box->low[i] = !box->voxels || voxel[i] < box->low[i] ? voxel[i] : box->low[i];
                box->high[i] = !box->voxels || voxel[i] > box->high[i] ? voxel[i] : box->high[i];
            }
            box->voxels++;
        }
    }
    return SC_OK;
}

/* Write the distances from a label to those voxels that change to it, and from it. */
static void measure_label(between_work *w, int id)
{
    set_field(w, &w->boxes[id]);
    measure(w, 0, id, w->a, false);
    measure(w, 1, id, w->b, false);
    for (size_t i = 0; i < w->result->count; i++) {
        change *c = &w->result->all[i];

        if (c->to == id)
            c->arrive = border_at(w, 0, c->at);
        else if (c->from == id)
            c->leave = border_at(w, 1, c->at);
    }
}

/* Does a voxel touch one that has the label in both phases? */
static bool touches_what_stays(const between_work *w, size_t at, int id)
{
    int voxel[3];

    place_of(w->a, at, voxel);
    for (int i = 0; i < SC_AROUND; i++) {
        const int near[3] = {voxel[0] + i % 3 - 1, voxel[1] + i / 3 % 3 - 1, voxel[2] + i / 9 - 1};
        const int *size = w->a->size;
        size_t other;

        if (near[0] < 0 || near[1] < 0 || near[2] < 0 || near[0] >= size[0] || near[1] >= size[1] ||
            near[2] >= size[2])
            continue;
        other = ((size_t)near[2] * (size_t)size[1] + (size_t)near[1]) * (size_t)size[0] +
                (size_t)near[0];
        if ((int)sc_volume_id(w->a, other) == id && (int)sc_volume_id(w->b, other) == id)
            return true;
    }
    return false;
}

/* @return whether so much of a label moves, of all its voxels, that it is thin. */
static bool is_thin(const between_work *w, int id)
{
    return 2 * w->boxes[id].voxels >= w->voxels[id];
}

/* Let a voxel that a label has in one phase alone be carried to or from the nearest of the other
 * phase, unless the label overlaps with itself there and is not thin. */
static void carry(between_work *w, const change *c, int id)
{
    const int other = c->from == id; /* the field of the phase that it is carried to or from */
    const float unit_mm = fminf(w->step_mm[0], fminf(w->step_mm[1], w->step_mm[2]));
    const float far_mm = border_at(w, other, c->at);
    carrier *k = &w->result->carriers[w->result->carrier_count];
    const field *f = &w->field;
    size_t index;
    int here[3], there[3], along;

    if (!id || far_mm > MARGIN * unit_mm || !find_in_field(w, c->at, &index) ||
        (!is_thin(w, id) && touches_what_stays(w, c->at, id)))
        return;
    along = w->nearest[other][index];
    place_of(w->a, c->at, here);
    for (int i = 0; i < 3; i++) {
        there[i] = along % f->size[i] + f->low[i];
        along /= f->size[i];
    }
    memcpy(k->from, other ? here : there, sizeof here);
    memcpy(k->to, other ? there : here, sizeof here);
    k->id = (uint16_t)id;
    w->result->carrier_count++;
}

/* Let a label that moves pass voxels that change from one label to another. The distances of the
 * change stay as they are: through tells that it does. */
static void pass_label(between_work *w, int id)
{
    set_field(w, &w->boxes[id]);
    measure(w, 0, id, w->a, true);
    measure(w, 1, id, w->b, true);
    for (size_t i = 0; i < w->result->count; i++) {
        change *c = &w->result->all[i];
        float before, behind;

        if (c->from == id || c->to == id) {
            carry(w, c, id);
            continue;
        }
        before = border_at(w, 0, c->at);
        behind = border_at(w, 1, c->at);
        if (before < c->arrive && behind < c->leave && before + behind < w->near[i]) {
            w->near[i] = before + behind;
            c->through = (uint16_t)id;
            w->near[w->result->count + 2 * i] = before;
            w->near[w->result->count + 2 * i + 1] = behind;
        }
    }
}

/* ---- borders between voxels ---- */

/* Distances between voxels know nothing of where between two of them a border lies, so that all
 * voxels of one that moves by less than a voxel would change in the same moment. But how much of a
 * ball around the voxel each label fills tells it. */

enum { BALL = 1, BALL_MAX = 27 }; /* voxels on either side; most in a ball of BALL_RADIUS */
#define BALL_RADIUS 1.8f          /* in the least widths of a voxel */
#define BALL_REACH 1.3f           /* up to this distance, in the same, a ball tells */

/* The voxels of the ball around one. */
typedef struct ball {
    int offset[BALL_MAX][3];
    int count;
    float unit_mm; /* least width of a voxel */
} ball;

static ball make_ball(const float step_mm[3])
{
    ball out = {.unit_mm = fminf(step_mm[0], fminf(step_mm[1], step_mm[2]))};
    const float radius_mm = BALL_RADIUS * out.unit_mm;

    for (int z = -BALL; z <= BALL; z++) {
        for (int y = -BALL; y <= BALL; y++) {
            for (int x = -BALL; x <= BALL; x++) {
                const float mm[3] = {(float)x * step_mm[0], (float)y * step_mm[1],
                                     (float)z * step_mm[2]};
                int *to = out.offset[out.count];

                if (mm[0] * mm[0] + mm[1] * mm[1] + mm[2] * mm[2] > radius_mm * radius_mm)
                    continue;
                to[0] = x;
                to[1] = y;
                to[2] = z;
                out.count++;
            }
        }
    }
    return out;
}

/* @return how far a plane is from the middle of a ball of radius 1 of which @p share, up to a half,
 * lies behind it: the volume of a cap, inverted by halving. */
static float plane_distance(float share)
{
    float low = 0, high = 1;

    for (int i = 0; i < 16; i++) {
        const float d = 0.5f * (low + high);

        if ((1 - d) * (1 - d) * (2 + d) * 0.25f > share)
            low = d;
        else
            high = d;
    }
    return 0.5f * (low + high);
}

/* @return the distance @p mm of a voxel from the border of label @p id in a phase where the voxel
 * has label @p own, as precisely as the voxels around it tell. */
static float refined(const sc_volume *v, const ball *b, const change *c, int own, int id, float mm)
{
    const size_t nx = (size_t)v->size[0], ny = (size_t)v->size[1];
    const int voxel[3] = {(int)(c->at % nx), (int)(c->at / nx % ny), (int)(c->at / nx / ny)};
    int counts[2] = {0, 0};
    float distance;

    if (mm > BALL_REACH * b->unit_mm)
        return mm;
    for (int i = 0; i < b->count; i++) {
        size_t at = 0;
        bool inside = true;
        int found;

        for (int k = 2; k >= 0 && inside; k--) {
            const int along = voxel[k] + b->offset[i][k];

            inside = along >= 0 && along < v->size[k];
            at = at * (size_t)v->size[k] + (size_t)along;
        }
        found = inside ? (int)sc_volume_id(v, at) : own;
        counts[0] += found == own;
        counts[1] += found == id;
    }
    distance = BALL_RADIUS * b->unit_mm *
               plane_distance((float)counts[1] / (float)(counts[0] + counts[1]));
    return fmaxf(distance, 0.02f * b->unit_mm);
}

/* Refine the distances of the changes [begin, end); an sc_range_fn on between_work. */
static void refine(void *user, size_t begin, size_t end, int thread)
{
    const between_work *w = user;
    const ball b = make_ball(w->step_mm);

    for (size_t i = begin; i < end; i++) {
        change *c = &w->result->all[i];

        if (c->through != c->from)
            continue;
        c->arrive = refined(w->a, &b, c, c->from, c->to, c->arrive);
        c->leave = refined(w->b, &b, c, c->to, c->from, c->leave);
    }
}

/* @return when a border passes that comes from @p far and goes to @p behind. */
static float moment(float far, float behind)
{
    return far < FAR && behind < FAR ? far / (far + behind) : 0.5f;
}

/* Turn distances into moments. */
static void find_moments(between_work *w)
{
    for (size_t i = 0; i < w->result->count; i++) {
        change *c = &w->result->all[i];
        const float *passing = w->near + w->result->count + 2 * i;
        const float to = c->arrive, from = c->leave;

        c->leave = c->arrive = moment(to, from);
        if (c->through == c->from)
            continue;
        c->leave = moment(passing[0], from);
        c->arrive = moment(to, passing[1]);
        if (c->leave >= c->arrive) { /* what passes is there for no time */
            c->through = c->from;
            c->leave = c->arrive = moment(to, from);
        }
    }
}

/* Make room for the fields and for what third labels need. @return SC_ERR_MEMORY. */
static sc_status make_room(const sc_ctx *ctx, between_work *w)
{
    const size_t count = w->result->count;
    size_t voxels, most = 0;

    for (int id = 0; id < w->a->label_count; id++) {
        if (!w->boxes[id].voxels)
            continue;
        set_field(w, &w->boxes[id]);
        voxels = (size_t)w->field.size[0] * (size_t)w->field.size[1] * (size_t)w->field.size[2];
        most = voxels > most ? voxels : most;
    }
    if (most > INT32_MAX)
        return sc_fail(
            ctx, SC_ERR_SYSTEM,
            "cine: between: tissues that move take %zu voxels, expected at most %d; draw "
            "a part of the volumes (crop), or leave between out",
            most, INT32_MAX);
    SC_PASS(check_memory(ctx, w->a, count, most));
    for (int i = 0; i < 3; i++) {
        w->step_mm[i] = (float)sc_vec3_length(sc_affine_column(&w->a->to_ras_mm, i));
        w->line = (size_t)w->a->size[i] + 1 > w->line ? (size_t)w->a->size[i] + 1 : w->line;
    }
    for (int i = 0; i < 2; i++) {
        SC_PASS(sc_alloc(ctx, most, sizeof(float), &w->values[i]));
        SC_PASS(sc_alloc(ctx, most, sizeof(int32_t), &w->nearest[i]));
    }
    SC_PASS(sc_alloc(ctx, (size_t)w->threads * w->line, sizeof(int32_t), &w->places));
    SC_PASS(sc_alloc(ctx, 2 * count, sizeof(carrier), &w->result->carriers));
    SC_PASS(sc_alloc(ctx, (size_t)w->threads * 3 * w->line, sizeof(float), &w->scratch));
    SC_PASS(sc_alloc(ctx, 3 * count, sizeof(float), &w->near));
    for (size_t i = 0; i < count; i++)
        w->near[i] = FAR;
    return SC_OK;
}

sc_status sc_between_find(const sc_ctx *ctx, const sc_volume *a, const sc_volume *b, int threads,
                          sc_between **out)
{
    between_work w = {.a = a, .b = b, .threads = threads > 1 ? threads : 1};
    sc_status status;

    SC_TRY(SC_ZALLOC(ctx, 1, &w.result));
    memcpy(w.result->size, a->size, sizeof a->size);
    SC_TRY(SC_ZALLOC(ctx, (size_t)a->label_count, &w.boxes));
    SC_TRY(SC_ZALLOC(ctx, (size_t)a->label_count, &w.voxels));
    SC_TRY(list_changes(ctx, &w));
    if (w.result->count)
        SC_TRY(make_room(ctx, &w));
    for (int id = 0; id < a->label_count; id++) {
        if (w.boxes[id].voxels)
            measure_label(&w, id);
    }
    for (int i = 0; i < 2 * a->label_count;
         i++) { /* what is thin is carried in front of the rest */
        const int id = i % a->label_count;

        if (w.boxes[id].voxels && is_thin(&w, id) == (i >= a->label_count))
            pass_label(&w, id);
    }
    sc_parallel_for(w.threads, w.result->count, 1024, refine, &w);
    find_moments(&w);
    *out = w.result;
    w.result = NULL;
out:
    sc_between_free(w.result);
    sc_free(w.boxes);
    sc_free(w.voxels);
    sc_free(w.near);
    for (int i = 0; i < 2; i++) {
        sc_free(w.values[i]);
        sc_free(w.nearest[i]);
    }
    sc_free(w.places);
    sc_free(w.scratch);
    return status;
}

static void set_id(sc_volume *v, size_t at, uint16_t id)
{
    if (v->label_bytes == 1)
        ((uint8_t *)v->ids)[at] = (uint8_t)id;
    else
        ((uint16_t *)v->ids)[at] = id;
}

void sc_between_at(const sc_between *between, double share, sc_volume *volume)
{
    const float t = (float)share;

    for (size_t i = 0; i < between->count; i++) {
        const change *c = &between->all[i];

        set_id(volume, c->at, t < c->leave ? c->from : t >= c->arrive ? c->to : c->through);
    }
    for (size_t i = 0; i < between->carrier_count && t > 0 && t < 1; i++) {
        const carrier *c = &between->carriers[i];
        size_t at = 0;

        for (int k = 2; k >= 0; k--) {
            const float along = (float)c->from[k] + t * (float)(c->to[k] - c->from[k]);

            at = at * (size_t)between->size[k] + (size_t)(along + 0.5f);
        }
        set_id(volume, at, c->id);
    }
}

void sc_between_free(sc_between *between)
{
    if (!between)
        return;
    sc_free(between->all);
    sc_free(between->carriers);
    sc_free(between);
}
