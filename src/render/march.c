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

    r->kernel->march(&r->march, rays, count, out, counters);
    if (!sc_fades_away(r))
        return;
    /* Fading to white, they are lighter than with black by the share of the background that the
     * picture shows. So that share is added to the transmittance; the picture lets through what has
     * faded, and not only what no tissue hides. */
    r->kernel->march(&r->on_white, rays, count, white, &again);
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
    int met[SC_PARTS_MAX];   /* [met_count] parts that rays can meet, by their numbers */
    int order[SC_PARTS_MAX]; /* [met_count] the same, the nearest first: so rays are followed */
} bundle;

/* @return the state of ray @p i in part @p p. */
static inline sc_part_ray *state_of(const bundle *b, int p, size_t i)
{
    return &b->room->state[(size_t)p * SC_RAY_BATCH + i];
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

    return level && sc_cover_near_mm(&part->cover, level) <= b->room->end_mm[i];
}

/* Follow rays through part @p p to their ends, and store what they bring back in their states. All
 * go there in the first round, else those whose room->part it is. A ray needs not go further than
 * an opaque face that it has met in another part. */
static void follow(const bundle *b, int p, bool all)
{
    const sc_part *part = &b->renderer->parts->list[p];
    sc_part_room *room = b->room;
    size_t queued = 0;

    for (size_t i = 0; i < b->count; i++) {
        sc_part_ray *state = state_of(b, p, i);

        if (!all && room->part[i] != p)
            continue;
        state->light = (sc_radiance){.transmittance = 1, .depth_mm = HUGE_VALF};
        if (may_meet(b, part, i))
            queued = queue_ray(b, part, state, i, room->end_mm[i], queued);
    }
    march_queue(b, part, queued);
    for (size_t k = 0; k < queued; k++) {
        const size_t i = room->target[k];

        state_of(b, p, i)->light = room->light[k];
        if (is_one_face(&room->light[k]))
            room->end_mm[i] = fmin(room->end_mm[i], (double)room->light[k].depth_mm + b->touch_mm);
    }
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

/* Does a ray bring back anything? */
static inline bool is_lit(const sc_radiance *light)
{
    return light->transmittance < 1;
}

/* Blend what ray @p i meets in the part that it meets first, if it is alone there, or if nothing is
 * seen behind. @return that part if another one begins before it ends, and the end of its stretch
 * in
 * *@p end_mm; -1 if the ray is done. */
static int take_first(const bundle *b, size_t i, bool last_round, double *end_mm)
{
    while (b->out[i].transmittance >= SC_OPAQUE) {
        int first = -1, second = -1;

        /* By their numbers: in which order they are followed must not matter, not even where two
         * are met at the same depth. */
        for (int k = 0; k < b->met_count; k++) {
            const int p = b->met[k];
            const sc_radiance *light = &state_of(b, p, i)->light;

            if (!is_lit(light))
                continue;
            if (!light->label) { /* a veil, of which it is not known where it is met */
                blend(light, &b->out[i]);
                state_of(b, p, i)->light.transmittance = 1;
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
        state_of(b, first, i)->light.transmittance = 1;
    }
    return -1;
}

/* Follow all rays whose room->part is @p p up to their room->end_mm, and blend what they meet.
 * Those that meet more behind in that part, unless they are opaque, keep it as their room->part;
 * the others' is set to that of no part, but not to -1. @return how many keep it. */
static size_t follow_stretch(const bundle *b, int p)
{
    const sc_part *part = &b->renderer->parts->list[p];
    sc_part_room *room = b->room;
    size_t queued = 0, left = 0;

    for (size_t i = 0; i < b->count; i++) {
        if (room->part[i] == p)
            queued = queue_ray(b, part, state_of(b, p, i), i, room->end_mm[i], queued);
    }
    march_queue(b, part, queued);
    for (size_t k = 0; k < queued; k++) {
        const size_t i = room->target[k];
        sc_part_ray *state = state_of(b, p, i);
        const bool is_all = room->light[k].transmittance <= state->light.transmittance &&
                            room->light[k].signature == state->light.signature;

        blend(&room->light[k], &b->out[i]);
        state->begin_mm = room->end_mm[i];
        state->light.transmittance = 1;
        if (is_all || b->out[i].transmittance < SC_OPAQUE)
            room->part[i] = SC_PARTS_MAX;
        else
            left++;
    }
    return left;
}

/* Find the parts that rays can meet: sets met, order and met_count. */
static void find_met(bundle *b)
{
    const sc_parts *parts = b->renderer->parts;
    bool meets[SC_PARTS_MAX] = {false};
    int n = 0;

    for (int k = 0; k < parts->shown_count; k++) {
        const int p = parts->shown[k];
        const uint8_t *squares = parts->list[p].cover.squares;

        for (size_t i = 0; i < b->count && !meets[p]; i++)
            meets[p] = squares[b->room->square[i]];
        if (meets[p])
            b->order[n++] = p;
    }
    for (int p = 0; p < parts->count; p++) {
        if (meets[p])
            b->met[b->met_count++] = p;
    }
}

void sc_march_apart(const sc_renderer *r, const double (*at_px)[2], size_t count, int thread,
                    sc_radiance *out, sc_march_counters *counters)
{
    const sc_parts *parts = r->parts;
    bundle b = {.renderer = r,
                .at_px = at_px,
                .room = &parts->rooms[thread],
                .out = out,
                .counters = counters,
                .count = count,
                .touch_mm = TOUCH_VOXELS * (double)r->march.voxel_mm};
    bool any = true;

    for (size_t i = 0; i < count; i++) {
        out[i] = (sc_radiance){.transmittance = 1, .depth_mm = HUGE_VALF};
        b.room->part[i] = SC_PARTS_MAX;
        b.room->end_mm[i] = HUGE_VAL;
        b.room->square[i] = sc_cover_square(&parts->list[parts->shown[0]].cover,
                                            (int)floor(at_px[i][0]), (int)floor(at_px[i][1]));
    }
    find_met(&b);
    for (int k = 0; k < b.met_count; k++) {
        for (size_t i = 0; i < count; i++)
            state_of(&b, b.met[k], i)->begin_mm = 0;
    }
    for (int k = 0; k < b.met_count; k++)
        follow(&b, b.order[k], true);
    for (int round = 0; any; round++) {
        bool goes_on[SC_PARTS_MAX] = {false};

        any = false;
        for (size_t i = 0; i < count; i++) {
            if (b.room->part[i] >= 0)
                b.room->part[i] = take_first(&b, i, round == ROUNDS_MAX, &b.room->end_mm[i]);
            if (b.room->part[i] < 0)
                continue;
            goes_on[b.room->part[i]] = true;
            any = true;
        }
        for (int k = 0; k < b.met_count; k++) {
            const int p = b.order[k];

            if (goes_on[p] && follow_stretch(&b, p)) {
                for (size_t i = 0; i < count; i++)
                    b.room->end_mm[i] = b.room->part[i] == p ? HUGE_VAL : b.room->end_mm[i];
                follow(&b, p, false);
            }
        }
    }
}
