/* SPDX-License-Identifier: BSD-3-Clause */
/* Template: rays that look for the first vertex on the side of tissue, each in a SIMD lane, with
 * steps across empty bricks. Compiled once per variant, under the name MARCH_NAME. A lane whose ray
 * is done gets the next one as soon as enough of them wait. */
#include "variants.h"

#include "lanes/lanes_brick.h"

/* Steps end so far, in vertices, beyond the plane that they lead to, so that rounding leaves none
 * before it. */
#define BEYOND (1.0f / 256)
enum {
    STEPS_MAX = 4096, /* of a ray: far more than there are bricks along it */
    PACKETS = 4,      /* while one waits for memory, the processor works on the others */
    FEW_LANES = PACKETS * LANES * 3 / 4 /* so many rays on their way are worth a step before others
                                           join them */
};

/* Rays on their way. */
typedef struct packet {
    const sc_gather_march *m;
    vf origin[3], direction[3],
        inverse[3]; /* origin: plus 1/2, so that rounding down gives the nearest vertex */
    vf t;
    vi q[3], brick; /* where they are */
    vm forward[3], alive;
    size_t ray[LANES]; /* which one is in each lane */
} packet;

/* Put a ray into a lane. */
static void load(packet *p, int lane, const sc_gather_ray *ray)
{
    for (int i = 0; i < 3; i++) {
        const float d = ray->direction[i];
        const bool parallel = d > -1e-8f && d < 1e-8f;

        p->origin[i][lane] = ray->origin[i] + 0.5f;
        p->direction[i][lane] = parallel ? 0 : d;
        p->inverse[i][lane] = parallel ? 1e30f : 1 / d;
    }
    p->t[lane] = 0;
}

/* Does a ray meet tissue on its way from @p a to @p b beside vertex @p q, which is on the side of
 * tissue? The surface that passes there is taken as the plane that the record of the vertex tells
 * of: else rays would end at corners of vertices that reach out from it. */
static bool meets_tissue(const sc_gather_march *m, const int q[3], const float a[3],
                         const float b[3])
{
    const sc_border *outer = &m->volume->outer;
    const size_t brick =
        sc_brick_index(m->volume->bricks, sc_brick_of(q[0]), sc_brick_of(q[1]), sc_brick_of(q[2]));
    const uint32_t record = sc_border_record(outer, brick, sc_brick_bit(q[0], q[1], q[2]));
    float n[3], above[2] = {0, 0};

    if (!record)
        return true;
    sc_record_normal(record, n);
    for (int i = 0; i < 3; i++) {
        const float along = (n[0] * m->step[i][0] + n[1] * m->step[i][1] + n[2] * m->step[i][2]) /
                            SC_RECORD_LENGTH_STEPS;

        above[0] += along * (a[i] - (float)q[i]);
        above[1] += along * (b[i] - (float)q[i]);
    }
    return (above[0] < above[1] ? above[0] : above[1]) * SC_BORDER_STEPS <=
           (float)sc_record_value(record);
}

/* Find where rays are, and end those that have left the volume. What is read there is fetched,
 * while other packets take their steps. */
static inline void locate(packet *p)
{
    const sc_gather_march *m = p->m;

    for (int i = 0; i < 3; i++) {
        const vf at = p->origin[i] + p->direction[i] * p->t;

        p->alive = m_and(p->alive, m_and(f_at_most(f_set(m->box_low[i]), at),
                                         f_below(at, f_set(m->box_high[i]))));
        p->q[i] = i_of(at);
    }
    p->brick = v_framed_index(m->row, m->layer, p->q[0], p->q[1], p->q[2]);
    for (int lane = 0; lane < LANES; lane++) {
        __builtin_prefetch(m->distances + p->brick[lane]);
        __builtin_prefetch(m->masks + p->brick[lane]);
    }
}

/* Take rays one step ahead, or note what they have met and let them end. */
static inline void step(packet *p, sc_gather_hit *out)
{
    const sc_gather_march *m = p->m;
    const vi *q = p->q, brick = p->brick;
    const vm on = p->alive;
    vi far, mask, ahead, back;
    vm marked, leaps;
    vf t = f_set(1e30f);

    if (!m_any(on))
        return;
    far = i_gather(m->distances, brick, on) & 255;
    leaps = m_and(on, i_below(i_set(0), far));
    marked = v_bit_set(v_half_mask(m->masks, brick, q[2], m_without(on, leaps)),
                       v_half_bit(q[0], q[1], q[2]), m_without(on, leaps));
    mask = i_pick(leaps, i_set(~SC_BRICK_MASK), i_set(-1));
    ahead = i_pick(leaps, far * SC_BRICK, i_set(1));
    back = i_pick(leaps, (1 - far) * SC_BRICK, i_set(0));
    for (int i = 0; i < 3; i++) {
        const vi plane = (q[i] & mask) + i_pick(p->forward[i], ahead, back);
        const vf mm = (f_of(plane) - p->origin[i]) * p->inverse[i];
        const vf there = f_pick(f_below(mm, f_set(0)), f_set(1e30f), mm);

        t = f_pick(f_below(there, t), there, t);
    }
    for (uint32_t left = m_bits(marked); left; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        const int at[3] = {q[0][lane], q[1][lane], q[2][lane]};
        float a[3], b[3];

        for (int i = 0; i < 3; i++) {
            a[i] = p->origin[i][lane] - 0.5f + p->direction[i][lane] * p->t[lane];
            b[i] = p->origin[i][lane] - 0.5f + p->direction[i][lane] * t[lane];
        }
        if (!meets_tissue(m, at, a, b))
            continue;
        for (int i = 0; i < 3; i++)
            out[p->ray[lane]].at[i] = at[i];
        p->alive = m_without(p->alive, m_of_bits(1u << lane));
    }
    t += BEYOND;
    p->t = f_pick(f_below(p->t, t), t, p->t + BEYOND);
    locate(p);
}

/* Put rays from number @p next on into the lanes of a packet that have none. @return the number of
 * the next one. */
static size_t fill(packet *p, const sc_gather_ray *rays, size_t next, size_t count)
{
    uint32_t idle = ~m_bits(p->alive) & (uint32_t)((1ull << LANES) - 1);

    for (; idle && next < count; idle &= idle - 1, next++) {
        const int lane = __builtin_ctz(idle);

        load(p, lane, &rays[next]);
        p->ray[lane] = next;
        p->alive = m_or(p->alive, m_of_bits(1u << lane));
    }
    for (int i = 0; i < 3; i++)
        p->forward[i] = f_below(f_set(0), p->inverse[i]);
    locate(p);
    return next;
}

/* @return how many rays are on their way. */
static inline int count_alive(const packet p[PACKETS])
{
    int count = 0;

    for (int k = 0; k < PACKETS; k++)
        count += m_count(p[k].alive);
    return count;
}

/* The kernel: see sc_gather_fn. */
void MARCH_NAME(const sc_gather_march *march, const sc_gather_ray *rays, size_t count,
                sc_gather_hit *out)
{
    packet p[PACKETS];
    size_t next = 0;

    for (int k = 0; k < PACKETS; k++) {
        p[k].m = march;
        p[k].alive = m_none();
        p[k].t = f_set(0);
        for (int i = 0; i < 3; i++) {
            p[k].origin[i] = p[k].direction[i] = f_set(0);
            p[k].inverse[i] = f_set(1);
        }
    }
    for (size_t i = 0; i < count; i++)
        out[i].at[0] = -1;
    for (int alive = 0; next < count || alive;) {
        for (int k = 0; k < PACKETS; k++)
            next = fill(&p[k], rays, next, count);
        do {
            for (int k = 0; k < PACKETS; k++)
                step(&p[k], out);
            alive = count_alive(p);
        } while (alive && (next == count || alive >= FEW_LANES));
    }
}
