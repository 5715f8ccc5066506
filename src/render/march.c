/* SPDX-License-Identifier: BSD-3-Clause */
/* Marches batches of rays: through the volume, or where parts are moved through each of them.
 *
 * In the second case a ray is first followed through each part by itself. Then the part that it
 * meets first is taken, up to where the next one begins; what is left of the ray is followed on
 * from there, until it is opaque or meets only one part. So layers of translucent parts that lie
 * between each other are blended in their order, as if the tissues stood in one volume. */
#include "internal.h"

/* Surfaces of two parts that lie so near to each other, in voxels, are those in which they touched
 * before they moved: the part that the ray is in is left before the other is entered. */
#define TOUCH_VOXELS 0.05
/* What takes less than this share of the light does not enter the signature of a ray. */
#define NOTICED (1.0f / 32)
enum {
    ROUNDS_MAX = 100 /* in which parts take turns; then what is left is blended part by part */
};

void sc_march_rays(const sc_renderer *r, const sc_ray *rays, size_t count, sc_radiance *out,
                   sc_radiance *white, sc_march_counters *counters)
{
    sc_march_counters again = {0}; /* the work is not counted a second time */

    r->kernel->march(&r->march, rays, NULL, count, out, counters);
    if (!sc_fades_away(r))
        return;
    /* Fading to white, they are lighter than with black by the share of the background that the
     * picture shows. So that share is added to the transmittance; the picture lets through what has
     * faded, and not only what no tissue hides. */
    r->kernel->march(&r->on_white, rays, NULL, count, white, &again);
    for (size_t i = 0; i < count; i++) {
        float more = 0;

        for (int c = 0; c < 3; c++)
            more += white[i].rgb[c] - out[i].rgb[c];
        out[i].transmittance += more * (1.0f / 3);
    }
}

/* A batch of rays on their way through the parts. */
typedef struct bundle {
    const sc_renderer *renderer;
    const double (*at_px)[2];
    sc_part_room *room;
    sc_radiance *out;
    sc_march_counters *counters;
    size_t count;
    double touch_mm;
    int met_count;
    int order[SC_PARTS_MAX]; /* [met_count] parts that rays can meet, the nearest first: so rays are
                                followed. The same for all rays of a frame, as where two parts
                                nearly touch the last bits of what is met depend on it: a ray ends
                                behind the face of one within the cell of the other's */
} bundle;

/* @return the state of ray @p i in part @p p. */
static inline sc_part_ray *state_of(const bundle *b, int p, size_t i)
{
    return &b->room->state[(size_t)p * SC_APART_BATCH + i];
}

/* Part @p p as a bit. */
static inline uint64_t part_bit(int p)
{
    return (uint64_t)1 << p;
}

/* Does a ray bring back anything? */
static inline bool is_lit(const sc_radiance *light)
{
    return light->transmittance < 1;
}

/* Is nothing of what is behind seen, and nothing but the first surface? */
static inline bool is_one_face(const sc_radiance *light)
{
    return light->transmittance < SC_OPAQUE && light->signature == light->label + 1;
}

/* Cut a ray through a part down to the stretch from @p begin_mm to @p end_mm, from the eye. @return
 * false if nothing of it is kept. */
static bool keep_stretch(const sc_lens *lens, double begin_mm, double end_mm, sc_ray *ray)
{
    const double step = lens->renderer->march.step_mm, base_mm = (double)ray->base_mm;
    const float begin = (float)(begin_mm - base_mm), end = (float)(end_mm - base_mm);
    bool any = false;

    for (int g = 0; g < ray->clip_sets; g++) {
        int kept = 0;

        for (int i = 0; i < ray->part_count[g]; i++) {
            sc_ray_part part = ray->parts[g][i];

            if (begin > part.begin_mm) { /* its cut face has been met before */
                part.begin_mm = begin;
                part.cap_plane = -1;
                if (lens->from_eye)
                    part.first = (int32_t)ceil((begin_mm - base_mm) / step - 0.5);
            }
            if (end < part.end_mm) {
                part.end_mm = end;
                if (lens->from_eye)
                    part.last = (int32_t)ceil((end_mm - base_mm) / step - 0.5);
            }
            if (part.begin_mm < part.end_mm)
                ray->parts[g][kept++] = part;
        }
        ray->part_count[g] = (uint8_t)kept;
        any = any || kept;
    }
    return any;
}

/* Queue ray @p i through part @p p, from where it has come there to @p end_mm, unless it meets
 * nothing there. @param queued how many are in the queue. @return how many are then. */
static size_t queue_ray(const bundle *b, const sc_part *part, const sc_part_ray *state, size_t i,
                        double end_mm, size_t queued)
{
    sc_ray *ray = &b->room->rays[queued];

    if (!sc_make_ray(&part->lens, b->at_px[i][0], b->at_px[i][1], ray))
        return queued;
    if ((state->begin_mm > 0 || end_mm < HUGE_VAL) &&
        !keep_stretch(&part->lens, state->begin_mm, end_mm, ray))
        return queued;
    b->room->target[queued] = (uint32_t)i;
    return queued + 1;
}

/* March the queue through a part. */
static void march_queue(const bundle *b, const sc_part *part, size_t queued)
{
    if (queued)
        sc_march_rays(part->renderer, b->room->rays, queued, b->room->light, b->room->white,
                      b->counters);
}

/* Can ray @p i meet anything of a part before it ends? */
static inline bool may_meet(const bundle *b, const sc_part *part, size_t i)
{
    const int level = part->cover.squares[b->room->square[i]];

    return level &&
           sc_cover_near_mm(&part->cover, level) * b->room->longer[i] <= b->room->end_mm[i];
}

/* March the queue through part @p p, and store what its rays bring back in their states. A ray
 * needs not go further than an opaque face that it has met in another part. */
static void march_followed(const bundle *b, int p, size_t queued)
{
    sc_part_room *room = b->room;

    march_queue(b, &b->renderer->parts->list[p], queued);
    for (size_t k = 0; k < queued; k++) {
        const size_t i = room->target[k];

        if (!is_lit(&room->light[k]))
            continue;
        state_of(b, p, i)->light = room->light[k];
        room->lit[i] |= part_bit(p);
        if (is_one_face(&room->light[k]))
            room->end_mm[i] = fmin(room->end_mm[i], (double)room->light[k].depth_mm + b->touch_mm);
    }
}

/* Follow rays through part @p p to their ends. In the first round those go there that can meet it,
 * from their beginnings, else those whose room->part it is. */
static void follow(const bundle *b, int p, bool first_round)
{
    const sc_parts *parts = b->renderer->parts;
    const sc_part *part = &parts->list[p];
    sc_part_room *room = b->room;
    size_t queued = 0;

    for (size_t i = 0; i < b->count; i++) {
        sc_part_ray *state = state_of(b, p, i);

        if (first_round ? !(parts->met[room->square[i]] & part_bit(p)) : room->part[i] != p)
            continue;
        if (first_round)
            state->begin_mm = 0;
        room->lit[i] &= ~part_bit(p);
        if (may_meet(b, part, i))
            queued = queue_ray(b, part, state, i, room->end_mm[i], queued);
        if (queued == SC_RAY_BATCH) {
            march_followed(b, p, queued);
            queued = 0;
        }
    }
    march_followed(b, p, queued);
}

/* Blend what a stretch of a ray brings back behind what has been met before. */
static void blend(const sc_radiance *from, sc_radiance *to)
{
    if (from->label && !to->label) {
        to->label = from->label;
        to->depth_mm = from->depth_mm;
        for (int c = 0; c < 3; c++)
            to->normal[c] = from->normal[c];
    }
    if (to->transmittance * (1 - from->transmittance) >= NOTICED)
        to->signature = to->signature * 31 + from->signature;
    for (int c = 0; c < 3; c++)
        to->rgb[c] += to->transmittance * from->rgb[c];
    to->transmittance *= from->transmittance;
}

/* Blend what ray @p i meets in the part that it meets first, if it is alone there, or if nothing is
 * seen behind. @return that part if another one begins before it ends, and the end of its stretch
 * in
 * *@p end_mm; -1 if the ray is done. */
static int take_first(const bundle *b, size_t i, bool last_round, double *end_mm)
{
    uint64_t *lit = &b->room->lit[i];

    while (*lit && b->out[i].transmittance >= SC_OPAQUE) {
        int first = -1, second = -1;

        /* By their numbers: in which order they are followed must not matter, not even where two
         * are met at the same depth. */
        for (uint64_t left = *lit; left; left &= left - 1) {
            const int p = __builtin_ctzll(left);
            const sc_radiance *light = &state_of(b, p, i)->light;

            if (!light->label) { /* a veil, of which it is not known where it is met */
                blend(light, &b->out[i]);
                *lit &= ~part_bit(p);
            } else if (first < 0 || light->depth_mm < state_of(b, first, i)->light.depth_mm) {
                second = first;
                first = p;
            } else if (second < 0 || light->depth_mm < state_of(b, second, i)->light.depth_mm) {
                second = p;
            }
        }
        if (first < 0)
            break;
        if (second >= 0 && !last_round && !is_one_face(&state_of(b, first, i)->light)) {
            *end_mm = (double)state_of(b, second, i)->light.depth_mm + b->touch_mm;
            return first;
        }
        blend(&state_of(b, first, i)->light, &b->out[i]);
        *lit &= ~part_bit(first);
    }
    return -1;
}

/* March the queue through part @p p to where the next one begins, and blend what its rays meet.
 * Those that meet more behind in that part, unless they are opaque, keep it as their room->part;
 * the others' is set to that of no part, but not to -1. @return how many keep it. */
static size_t march_stretches(const bundle *b, int p, size_t queued)
{
    sc_part_room *room = b->room;
    size_t left = 0;

    march_queue(b, &b->renderer->parts->list[p], queued);
    for (size_t k = 0; k < queued; k++) {
        const size_t i = room->target[k];
        sc_part_ray *state = state_of(b, p, i);
        const bool is_all = room->light[k].transmittance <= state->light.transmittance &&
                            room->light[k].signature == state->light.signature;

        blend(&room->light[k], &b->out[i]);
        state->begin_mm = room->end_mm[i];
        room->lit[i] &= ~part_bit(p);
        if (is_all || b->out[i].transmittance < SC_OPAQUE)
            room->part[i] = SC_PARTS_MAX;
        else
            left++;
    }
    return left;
}

/* Follow all rays whose room->part is @p p up to their room->end_mm. @return as march_stretches. */
static size_t follow_stretches(const bundle *b, int p)
{
    const sc_part *part = &b->renderer->parts->list[p];
    sc_part_room *room = b->room;
    size_t queued = 0, left = 0;

    for (size_t i = 0; i < b->count; i++) {
        if (room->part[i] == p)
            queued = queue_ray(b, part, state_of(b, p, i), i, room->end_mm[i], queued);
        if (queued == SC_RAY_BATCH) {
            left += march_stretches(b, p, queued);
            queued = 0;
        }
    }
    return left + march_stretches(b, p, queued);
}

/* Begin to follow the rays of a bundle: sets out, and what of its room they have by their indices,
 * and the parts that they can meet, order and met_count. */
static void begin_rays(bundle *b)
{
    const sc_parts *parts = b->renderer->parts;
    sc_part_room *room = b->room;
    uint64_t met = 0;

    for (size_t i = 0; i < b->count; i++) {
        const int square =
            sc_cover_square(&parts->layout, (int)floor(b->at_px[i][0]), (int)floor(b->at_px[i][1]));

        b->out[i] = (sc_radiance){.transmittance = 1, .depth_mm = HUGE_VALF};
        room->part[i] = SC_PARTS_MAX;
        room->end_mm[i] = HUGE_VAL;
        room->square[i] = square;
        room->lit[i] = 0;
        room->longer[i] =
            sc_ray_longer(&parts->list[parts->shown[0]].lens, b->at_px[i][0], b->at_px[i][1]);
        met |= parts->met[square];
    }
    for (int k = 0; k < parts->shown_count; k++) {
        if (met & part_bit(parts->shown[k]))
            b->order[b->met_count++] = parts->shown[k];
    }
}

/* Follow the rays that take_first() has given to a part through that. */
static void follow_on(const bundle *b, int p)
{
    sc_part_room *room = b->room;

    if (!follow_stretches(b, p))
        return;
    for (size_t i = 0; i < b->count; i++)
        room->end_mm[i] = room->part[i] == p ? HUGE_VAL : room->end_mm[i];
    follow(b, p, false);
}

void sc_march_apart(const sc_renderer *r, const double (*at_px)[2], size_t count, int thread,
                    sc_radiance *out, sc_march_counters *counters)
{
    bundle b = {.renderer = r,
                .at_px = at_px,
                .room = &r->parts->rooms[thread],
                .out = out,
                .counters = counters,
                .count = count,
                .touch_mm = TOUCH_VOXELS * (double)r->march.voxel_mm};
    bool any = true;

    begin_rays(&b);
    for (int k = 0; k < b.met_count; k++)
        follow(&b, b.order[k], true);
    for (int round = 0; any; round++) {
        uint64_t going_on = 0;

        any = false;
        for (size_t i = 0; i < count; i++) {
            if (b.room->part[i] >= 0)
                b.room->part[i] = take_first(&b, i, round == ROUNDS_MAX, &b.room->end_mm[i]);
            if (b.room->part[i] < 0)
                continue;
            going_on |= part_bit(b.room->part[i]);
            any = true;
        }
        for (int k = 0; k < b.met_count; k++) {
            if (going_on & part_bit(b.order[k]))
                follow_on(&b, b.order[k]);
        }
    }
}
