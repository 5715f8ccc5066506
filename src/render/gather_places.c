/* SPDX-License-Identifier: BSD-3-Clause */
/* The places at which light is gathered, and how something is done for all of them. */
#include "directions.h"
#include "gather.h"
#include "internal.h"

/* So far above the surface do rays begin, in voxels. With more of it crevices are lit too much, and
 * all of it is farther from what the paths of unit.gather bring. */
#define LIFT_VOXELS 0.2
/* The surface is at most so many voxels from a vertex beside which it passes. */
#define MOVED_MOST_VOXELS 1.5
/* Bricks along the side of a tile, whose places are numbered together. */
enum { TILE = 8 };

void sc_gather_for(sc_gather *g, size_t count, size_t chunk, sc_range_fn *body)
{
    if (g->together)
        sc_team_for(g->renderer->team, count, chunk, body, g);
    else
        sc_parallel_for(g->renderer->settings.work.threads, count, chunk, body, g);
}

bool sc_gather_ends(const sc_gather *g)
{
    return !g->together && sc_is_given_up(g->renderer);
}

uint32_t sc_gather_number(const sc_gather *g, uint32_t first, uint32_t *counts)
{
    const size_t bricks = sc_brick_count(g->renderer->volume->bricks);

    if (sc_team_is_first(g->renderer->team)) {
        for (size_t brick = 0; brick <= bricks; brick++) {
            const uint32_t own = counts[brick];

            counts[brick] = first;
            first += own;
        }
    }
    (void)!sc_team_agree(g->renderer->team, SC_OK); /* all wait until it is done */
    return counts[bricks];
}

/* Number the places of the bricks of the tile that begins at brick @p low, of which f->start has
 * the counts, from @p next on. @return the number of the next one. */
static uint32_t number_tile(const int bricks[3], sc_gather_field *f, const int low[3],
                            uint32_t next)
{
    for (int i = 0; i < TILE * TILE * TILE; i++) {
        const int x = low[0] + i % TILE, y = low[1] + i / TILE % TILE, z = low[2] + i / TILE / TILE;

        if (x < bricks[0] && y < bricks[1] && z < bricks[2]) {
            uint32_t *start = &f->start[sc_brick_index(bricks, x, y, z)];
            const uint32_t count = *start;

            *start = next;
            next += count;
        }
    }
    return next;
}

/* Replace the count of each brick by the number of its first place, and add all to g->count. Places
 * near each other get numbers near each other, as rays that are followed together then read the
 * same memory. Collective. */
static void number_places(sc_gather *g, sc_gather_field *f)
{
    const int *bricks = g->renderer->volume->bricks;
    uint32_t *end = &f->start[sc_brick_count(bricks)];

    if (sc_team_is_first(g->renderer->team)) {
        *end = (uint32_t)g->count;
        for (int z = 0; z < bricks[2]; z += TILE) {
            for (int y = 0; y < bricks[1]; y += TILE) {
                for (int x = 0; x < bricks[0]; x += TILE)
                    *end = number_tile(bricks, f, (int[3]){x, y, z}, *end);
            }
        }
    }
    (void)!sc_team_agree(g->renderer->team, SC_OK); /* all wait until it is done */
    g->count = *end;
}

/* @return whether two vertex records look to opposite sides. */
static bool look_apart(uint32_t a, uint32_t b)
{
    float n[3], other[3];

    sc_record_octant(a, n);
    sc_record_octant(b, other);
    return sc_dot(n, other) < 0;
}

/* @return whether vertex @p q, which has a record, is a place: whether one of its six neighbours is
 * on the other side of the surface. On the side of the background that neighbour must look the
 * other way: it belongs to a sheet a voxel thick, which has a single normal there, but two sides.
 */
static bool is_place(const sc_prepared *v, bool inner, const int q[3], uint32_t record)
{
    const uint32_t tissue = inner ? sc_vertex_at(v, q[0], q[1], q[2]).tissue : 0;
    const bool behind = !inner && sc_record_value(record) < 0;

    for (int i = 0; i < 6; i++) {
        int at[3] = {q[0], q[1], q[2]};
        sc_vertex other;

        at[i >> 1] += i & 1 ? 1 : -1;
        if (at[i >> 1] < 0 || at[i >> 1] > v->size[i >> 1] + 1)
            continue;
        other = sc_vertex_at(v, at[0], at[1], at[2]);
        if (behind  ? other.outer_value > 0 && other.outer && look_apart(record, other.outer)
            : inner ? other.outer_value > 0 && other.tissue != tissue
                    : other.outer_value < 0)
            return true;
    }
    return false;
}

/* Note which vertices of bricks [begin, end) may be places: an sc_range_fn on a gather. */
static void mark_places(void *user, size_t begin, size_t end, int thread)
{
    sc_gather *g = user;

    for (int k = 0; k < SC_GATHER_FIELDS; k++) {
        sc_gather_field *f = &g->fields[k];

        for (size_t brick = begin; f->masks && brick < end; brick++) {
            uint64_t mask = 0;
            uint32_t at = f->border->start[brick];
            int low[3];

            sc_brick_low(g->renderer->volume->bricks, brick, low);
            for (uint64_t left = f->border->masks[brick]; left; left &= left - 1, at++) {
                const int bit = __builtin_ctzll(left);
                const int q[3] = {low[0] + sc_bit_x(bit), low[1] + sc_bit_y(bit),
                                  low[2] + sc_bit_z(bit)};

                if (is_place(g->renderer->volume, k == 1, q, f->border->records[at]))
                    mask |= left & -left;
            }
            f->masks[brick] = mask;
        }
    }
}

/* @return whether a place at vertex @p q, with a record, can be left out: one of its six neighbours
 * is a place that looks the same way. Those with an even sum of coordinates always stay: half of
 * all vertices, of which every other one is a neighbour. */
static bool is_spare(const sc_gather *g, const sc_gather_field *f, const int q[3], uint32_t record)
{
    const int *size = g->renderer->volume->size;

    for (int i = 0; i < 6 && (q[0] + q[1] + q[2]) % 2; i++) {
        int at[3] = {q[0], q[1], q[2]};
        size_t brick;
        int bit;

        at[i >> 1] += i & 1 ? 1 : -1;
        if (at[i >> 1] < 0 || at[i >> 1] > size[i >> 1] + 1)
            continue;
        brick = sc_brick_index(g->renderer->volume->bricks, sc_brick_of(at[0]), sc_brick_of(at[1]),
                               sc_brick_of(at[2]));
        bit = sc_brick_bit(at[0], at[1], at[2]);
        if (f->masks[brick] >> bit & 1 &&
            !look_apart(record, sc_border_record(f->border, brick, bit)))
            return true;
    }
    return false;
}

/* Set f->thinned to the places of bricks [begin, end) that stay, and count them: an sc_range_fn on
 * a gather. */
static void thin_places(void *user, size_t begin, size_t end, int thread)
{
    sc_gather *g = user;

    for (int k = 0; k < SC_GATHER_FIELDS; k++) {
        sc_gather_field *f = &g->fields[k];

        for (size_t brick = begin; f->masks && brick < end; brick++) {
            uint64_t mask = f->masks[brick];
            int low[3];

            sc_brick_low(g->renderer->volume->bricks, brick, low);
            for (uint64_t left = mask; left; left &= left - 1) {
                const int bit = __builtin_ctzll(left);
                const int q[3] = {low[0] + sc_bit_x(bit), low[1] + sc_bit_y(bit),
                                  low[2] + sc_bit_z(bit)};

                if (is_spare(g, f, q, sc_border_record(f->border, brick, bit)))
                    mask &= ~(left & -left);
            }
            f->thinned[brick] = mask;
            f->start[brick] = sc_count_bits(mask);
        }
    }
}

/* The value of a field at a point of the grid and its slope, by the eight vertices around it. */
static double field_at(const sc_prepared *v, bool inner, uint16_t tissue, const double p[3],
                       double slope[3])
{
    int low[3];
    double share[3], value = 0;

    slope[0] = slope[1] = slope[2] = 0;
    for (int i = 0; i < 3; i++) {
        low[i] = (int)floor(p[i]);
        low[i] = low[i] < 0 ? 0 : low[i] > v->size[i] ? v->size[i] : low[i];
        share[i] = p[i] - low[i];
    }
    for (int corner = 0; corner < 8; corner++) {
        const sc_vertex at = sc_vertex_at(v, low[0] + (corner & 1), low[1] + (corner >> 1 & 1),
                                          low[2] + (corner >> 2));
        const double of = !inner                ? at.outer_value
                          : at.tissue == tissue ? at.inner_value
                                                : -at.inner_value;
        double weight[3];

        for (int i = 0; i < 3; i++)
            weight[i] = corner >> i & 1 ? share[i] : 1 - share[i];
        value += of * weight[0] * weight[1] * weight[2];
        for (int i = 0; i < 3; i++)
            slope[i] += (corner >> i & 1 ? of : -of) * weight[(i + 1) % 3] * weight[(i + 2) % 3];
    }
    return value;
}

/* Move a point of the grid onto the surface along the direction @p n of the grid, at most
 * MOVED_MOST_VOXELS. */
static void move_to_surface(const sc_prepared *v, bool inner, uint16_t tissue, const double n[3],
                            double p[3])
{
    const double start[3] = {p[0], p[1], p[2]};
    double moved = 0;

    for (int step = 0; step < 3; step++) {
        double slope[3], along;
        const double value = field_at(v, inner, tissue, p, slope);

        along = slope[0] * n[0] + slope[1] * n[1] + slope[2] * n[2];
        if (along > -1)
            break; /* nothing falls that way: it stays where it is */
        moved = fmin(fmax(moved - value / along, -MOVED_MOST_VOXELS), MOVED_MOST_VOXELS);
        for (int i = 0; i < 3; i++)
            p[i] = start[i] + moved * n[i];
    }
}

/* Fill in the place at vertex @p q, whose record is @p record. */
static void set_place(const sc_renderer *r, bool inner, const int q[3], uint32_t record,
                      sc_gather_place *out)
{
    const sc_prepared *v = r->volume;
    double direction[3], p[3] = {q[0], q[1], q[2]}, length = 0;
    const sc_vertex vertex = sc_vertex_at(v, q[0], q[1], q[2]);
    float n[3];

    sc_record_normal(record, n);
    for (int i = 0; i < 3; i++)
        length += (double)n[i] * n[i];
    length = sqrt(length);
    for (int i = 0; i < 3; i++)
        out->normal[i] = (float)(n[i] / length);
    length = 0;
    for (int i = 0; i < 3; i++) {
        direction[i] = 0;
        for (int j = 0; j < 3; j++)
            direction[i] += r->space.to_voxel.m[i][j] * out->normal[j];
        length += direction[i] * direction[i];
    }
    length = sqrt(length);
    for (int i = 0; i < 3; i++)
        direction[i] /= length;
    out->tissue = (uint16_t)vertex.tissue;
    move_to_surface(v, inner, out->tissue, direction, p);
    for (int i = 0; i < 3; i++)
        out->at[i] = (float)(p[i] + LIFT_VOXELS * direction[i]);
    out->part = 0;
    for (int bit = 0; bit < 6; bit++)
        out->part |= (uint8_t)((q[bit % 3] >> (bit / 3) & 1) << bit);
}

/* Fill in the places of bricks [begin, end): an sc_range_fn on a gather. */
static void fill_places(void *user, size_t begin, size_t end, int thread)
{
    sc_gather *g = user;
    const sc_prepared *v = g->renderer->volume;

    for (int k = 0; k < SC_GATHER_FIELDS; k++) {
        const sc_gather_field *f = &g->fields[k];

        for (size_t brick = begin; f->masks && brick < end; brick++) {
            uint32_t at = f->start[brick];
            int low[3];

            sc_brick_low(v->bricks, brick, low);
            for (uint64_t left = f->masks[brick]; left; left &= left - 1, at++) {
                const int bit = __builtin_ctzll(left);
                const int q[3] = {low[0] + sc_bit_x(bit), low[1] + sc_bit_y(bit),
                                  low[2] + sc_bit_z(bit)};

                set_place(g->renderer, k == 1, q, sc_border_record(f->border, brick, bit),
                          &g->places[at]);
            }
        }
    }
}

/* Allocate the masks of a field, and the numbers of its places. */
static sc_status allocate_field(const sc_ctx *ctx, const sc_gather *g, sc_gather_field *f)
{
    const size_t bricks = sc_brick_count(g->renderer->volume->bricks);
    sc_team *team = g->renderer->team;
    void *data;

    SC_PASS(sc_team_alloc(ctx, team, bricks, sizeof *f->masks, &data));
    f->masks = data;
    SC_PASS(sc_team_alloc(ctx, team, bricks, sizeof *f->thinned, &data));
    f->thinned = data;
    SC_PASS(sc_team_alloc(ctx, team, bricks + 1, sizeof *f->start, &data));
    f->start = data;
    return SC_OK;
}

sc_status sc_gather_find_places(const sc_ctx *ctx, sc_gather *g)
{
    const sc_renderer *r = g->renderer;
    const size_t bricks = sc_brick_count(r->volume->bricks);
    void *data;

    for (int k = 0; k < (r->derived.shows_inner ? SC_GATHER_FIELDS : 1); k++)
        SC_PASS(allocate_field(ctx, g, &g->fields[k]));
    sc_gather_for(g, bricks, 1024, mark_places);
    sc_gather_for(g, bricks, 1024, thin_places);
    for (int k = 0; k < SC_GATHER_FIELDS && g->fields[k].masks; k++) {
        sc_gather_field *f = &g->fields[k];

        sc_team_free(r->team, f->masks);
        f->masks = f->thinned;
        f->thinned = NULL;
        number_places(g, f);
    }
    g->floor.first = g->count;
    g->count += r->settings.floor ? SC_FLOOR_SIDE * SC_FLOOR_SIDE : 0;
    SC_PASS(sc_team_alloc(ctx, r->team, g->count + 1, sizeof *g->places, &data));
    g->places = data;
    sc_gather_for(g, bricks, 1024, fill_places);
    sc_gather_for(g, g->count - g->floor.first, 4096, sc_floor_points);
    return SC_OK;
}

int32_t sc_gather_place_at(const sc_gather *g, const sc_gather_field *f, const int q[3])
{
    const int bit = sc_brick_bit(q[0], q[1], q[2]);
    const size_t brick = sc_brick_index(g->renderer->volume->bricks, sc_brick_of(q[0]),
                                        sc_brick_of(q[1]), sc_brick_of(q[2]));

    if (!f->masks || !(f->masks[brick] >> bit & 1))
        return SC_GATHER_LOST;
    return (int32_t)(f->start[brick] + sc_brick_rank(f->masks[brick], bit));
}

void sc_gather_direction(const sc_gather *g, const sc_gather_place *p, int i, float out[3])
{
    const double n[3] = {p->normal[0], p->normal[1], p->normal[2]};
    const float *own = g->directions[p->part][i];
    double t[3], b[3];

    sc_frame_about(n, t, b);
    for (int k = 0; k < 3; k++)
        out[k] = i < SC_GATHER_DIRECTIONS ? (float)(own[0] * t[k] + own[1] * b[k] + own[2] * n[k])
                                          : own[k];
}
