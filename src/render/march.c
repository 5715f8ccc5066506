/* SPDX-License-Identifier: BSD-3-Clause */
/* Marches batches of rays: through the volume, or where parts are moved through each of them.
 *
 * In the second case a ray goes on in the part whose next surface is the nearest, up to the next
 * surface of another part, as if the tissues stood in one volume; what is hidden is not looked for.
 * As long as a ray has not been to a part, the map or the box of that tells how near its first
 * surface can be. That decides when surfaces are looked for, but never which of them comes first:
 * the picture is the same without them. */
#include "internal.h"

/* Surfaces of two parts that lie so near to each other, in voxels, are those in which they touched
 * before they moved: the part that the ray is in is left before the other is entered. */
#define TOUCH_VOXELS 0.05f
enum {
    TURNS_MAX = 100, /* in which parts take turns; then a ray is followed through one after the
                        other */
    NO_PART = -1
};

/* Let through what has faded of rays: fading to white, they are lighter than with black by the
 * share of the background that the picture shows. That share is added to the transmittance, so that
 * the picture lets through what has faded, and not only what no tissue hides. */
static void fade_away(size_t count, sc_radiance *out, const sc_radiance *white)
{
    for (size_t i = 0; i < count; i++) {
        float more = 0;

        for (int c = 0; c < 3; c++)
            more += white[i].rgb[c] - out[i].rgb[c];
        out[i].transmittance += more * (1.0f / 3);
    }
}

void sc_march_rays(const sc_renderer *r, const sc_ray *rays, size_t count, sc_radiance *out,
                   sc_radiance *white, sc_march_counters *counters)
{
    sc_march_counters again = {0}; /* the work is not counted a second time */

    r->kernel->march(&r->march, rays, NULL, count, out, counters);
    if (!sc_fades_away(r))
        return;
    r->kernel->march(&r->behind.on_white, rays, NULL, count, white, &again);
    fade_away(count, out, white);
}

/* A batch of rays on their way through the parts. */
typedef struct bundle {
    const sc_renderer *renderer;
    const sc_aim *aims;
    const sc_line *lines; /* NULL: rays go where aims say */
    sc_part_room *room;
    sc_radiance *out;
    sc_march_counters *counters;
    float touch_mm;
    int waiting[SC_PARTS_MAX]; /* by part: how many rays go on there */
    int first[SC_PARTS_MAX];   /* the first of them; the others follow by room->after */
} bundle;

/* Part @p p as a bit. */
static inline uint64_t part_bit(int p)
{
    return (uint64_t)1 << p;
}

/* Make ray @p i as it stands to part @p p. @return false if it misses that. */
static bool make_ray(const bundle *b, int p, size_t i, sc_ray *ray)
{
    const sc_part *part = &b->renderer->parts->list[p];
    sc_line line;

    if (!b->lines)
        return sc_make_ray(&part->lens, &b->aims[i], ray);
    line = b->lines[i];
    line.from_mm = sc_vec3_sub(line.from_mm, part->scene.offsets_mm[part->label]);
    return sc_make_ray_from(&part->lens, &line, ray);
}

/* @return the way of ray @p i through part @p p. */
static inline sc_way *way_of(const bundle *b, int p, size_t i)
{
    return &b->room->ways[(size_t)p * SC_APART_BATCH + i];
}

/* Find the parts that ray @p i meets first and second, but for the one that it is in: of equal
 * distances that of the lower number. Both are NO_PART if there is none. */
static void find_nearest(const bundle *b, size_t i, int in, int *first, int *second)
{
    float nearest = HUGE_VALF, next = HUGE_VALF;

    *first = *second = NO_PART;
    for (uint64_t left = b->room->left[i]; left; left &= left - 1) {
        const int p = __builtin_ctzll(left);
        const float mm = way_of(b, p, i)->next_mm;

        if (p == in)
            continue;
        if (*first == NO_PART || mm < nearest) {
            *second = *first;
            next = nearest;
            *first = p;
            nearest = mm;
        } else if (*second == NO_PART || mm < next) {
            *second = p;
            next = mm;
        }
    }
}

/* The distance before which the first surface of part @p p, of which only a bound is known, comes
 * before all those of part @p other. */
static inline float before_other(const bundle *b, size_t i, int p, int other)
{
    const float mm = way_of(b, other, i)->next_mm;

    return p < other ? nextafterf(mm, HUGE_VALF) : mm;
}

/* Choose the part in which ray @p i goes on, and set how far in its way. @return it; NO_PART if the
 * ray is done. */
static int choose_part(const bundle *b, size_t i)
{
    const sc_part_room *room = b->room;
    const bool last_turn = room->turns[i] >= TURNS_MAX;
    const int in = room->part[i] != NO_PART && room->left[i] & part_bit(room->part[i])
                       ? room->part[i]
                       : NO_PART;
    int first, second;
    float limit_mm = HUGE_VALF;
    sc_way *way;

    if (!room->left[i] || b->out[i].transmittance < SC_OPAQUE ||
        (b->lines && b->out[i].transmittance < b->lines[i].ends_below))
        return NO_PART;
    find_nearest(b, i, in, &first, &second);
    if (first != NO_PART && !last_turn)
        limit_mm = way_of(b, first, i)->next_mm + b->touch_mm;
    if (in != NO_PART && way_of(b, in, i)->next_mm < limit_mm) {
        way = way_of(b, in, i);
        way->before_mm = way->limit_mm = limit_mm;
        return in;
    }
    way = way_of(b, first, i);
    way->before_mm = way->limit_mm = HUGE_VALF;
    if (second != NO_PART) {
        way->before_mm = before_other(b, i, first, second);
        way->limit_mm = way_of(b, second, i)->next_mm + b->touch_mm;
    }
    if (in != NO_PART) { /* twice, for what rounding takes away */
        way->before_mm = fminf(way->before_mm, way_of(b, in, i)->next_mm - 2 * b->touch_mm);
        way->limit_mm = fminf(way->limit_mm, way_of(b, in, i)->next_mm + b->touch_mm);
    }
    if (room->known[i] & part_bit(first))
        way->before_mm = HUGE_VALF;
    if (last_turn)
        way->limit_mm = HUGE_VALF;
    return first;
}

/* Let ray @p i wait for the part in which it goes on, unless it is done. */
static void send_on(bundle *b, size_t i)
{
    const int p = choose_part(b, i);

    if (p == NO_PART)
        return;
    b->room->after[i] = b->first[p];
    b->first[p] = (int)i;
    b->waiting[p]++;
}

/* Take ray @p i over from part @p p, where it has come to. */
static void take_over(bundle *b, int p, size_t i)
{
    sc_part_room *room = b->room;
    const sc_way *way = way_of(b, p, i);

    room->known[i] |= part_bit(p);
    if (way->next_mm == HUGE_VALF)
        room->left[i] &= ~part_bit(p);
    if (way->passed && room->part[i] != p) {
        room->part[i] = (int8_t)p;
        room->turns[i]++;
    }
    send_on(b, i);
}

/* March the first @p count rays of the room through part @p p, as far as their ways allow. */
static void march_part(const bundle *b, int p, size_t count)
{
    const sc_renderer *own = b->renderer->parts->list[p].renderer;
    sc_part_room *room = b->room;
    sc_march_counters again = {0}; /* the work is not counted a second time */

    for (size_t k = 0; k < count; k++) {
        const size_t i = room->target[k];

        room->part_ways[k] = *way_of(b, p, i);
        room->light[k] = b->out[i];
        room->again[k] = room->part_ways[k];
    }
    own->kernel->march(b->lines ? &own->light.traced : &own->march, room->rays, room->part_ways,
                       count, room->light, b->counters);
    for (size_t k = 0; k < count; k++) {
        *way_of(b, p, room->target[k]) = room->part_ways[k];
        b->out[room->target[k]] = room->light[k];
    }
    if (b->lines || !sc_fades_away(own))
        return;
    for (size_t k = 0; k < count; k++)
        room->light[k] = room->white[room->target[k]];
    own->kernel->march(&own->behind.on_white, room->rays, room->again, count, room->light, &again);
    for (size_t k = 0; k < count; k++)
        room->white[room->target[k]] = room->light[k];
}

/* Follow rays that wait for part @p p, at most SC_RAY_BATCH, as far as their ways allow. */
static void follow(bundle *b, int p)
{
    sc_part_room *room = b->room;
    size_t count = 0;

    while (b->first[p] >= 0 && count < SC_RAY_BATCH) {
        const size_t i = (size_t)b->first[p];

        b->first[p] = room->after[i];
        b->waiting[p]--;
        if (make_ray(b, p, i, &room->rays[count])) {
            room->target[count++] = (uint32_t)i;
            continue;
        }
        room->left[i] &= ~part_bit(p);
        send_on(b, i);
    }
    march_part(b, p, count);
    for (size_t k = 0; k < count; k++)
        take_over(b, p, room->target[k]);
}

/* Find whether a line meets the box of part @p p, and not nearer than where: sets *near_mm. */
static bool meets_box(const bundle *b, int p, const sc_line *line, float *near_mm)
{
    const sc_part *part = &b->renderer->parts->list[p];
    const sc_affine *to_voxel = &part->renderer->space.to_voxel;
    const sc_box3 *box = &part->renderer->space.box;
    const sc_vec3 from =
        sc_affine_point(to_voxel, sc_vec3_sub(line->from_mm, part->scene.offsets_mm[part->label]));
    const sc_vec3 along = sc_affine_vector(to_voxel, line->direction);
    const double ends[3][3] = {{box->low.x - from.x, box->high.x - from.x, along.x},
                               {box->low.y - from.y, box->high.y - from.y, along.y},
                               {box->low.z - from.z, box->high.z - from.z, along.z}};
    double near = 0, far = HUGE_VAL;

    for (int i = 0; i < 3; i++) {
        const double low = ends[i][0] / ends[i][2], high = ends[i][1] / ends[i][2];

        near = fmax(near, fmin(low, high));
        far = fmin(far, fmax(low, high));
    }
    *near_mm = (float)(near - (double)b->touch_mm); /* for what rounding takes away */
    return near <= far;
}

/* Begin to follow ray @p i: sets what it brings back, and what of the room it has by its index,
 * with the parts that it can meet, and lets it wait for one. */
static void begin_ray(bundle *b, size_t i)
{
    const sc_parts *parts = b->renderer->parts;
    sc_part_room *room = b->room;
    const sc_aim *aim = b->lines ? NULL : &b->aims[i];
    const int square =
        aim ? sc_cover_square(&parts->layout, (int)floor(aim->x_px), (int)floor(aim->y_px)) : 0;
    const double longer =
        aim ? 1 / sc_line_of_sight(&parts->list[parts->shown[0]].lens, aim).shorten : 0;

    b->out[i] = room->white[i] = sc_no_light();
    room->left[i] = room->known[i] = 0;
    room->part[i] = NO_PART;
    room->turns[i] = 0;
    for (int k = 0; k < parts->shown_count; k++) {
        const int p = parts->shown[k];
        const sc_cover *cover = &parts->list[p].cover;
        const int level = cover->squares[square];
        sc_way *way = way_of(b, p, i);

        *way = sc_way_begin();
        if (aim)
            way->next_mm = (float)((cover->near_mm + (level - 1) * cover->level_mm) * longer);
        if (aim ? level > 0 : meets_box(b, p, &b->lines[i], &way->next_mm))
            room->left[i] |= part_bit(p);
    }
    send_on(b, i);
}

/* @return the part for which most rays wait; NO_PART if none does. In which order parts are
 * followed does not matter. */
static int busiest(const bundle *b)
{
    int most = NO_PART;

    for (int p = 0; p < b->renderer->parts->count; p++) {
        if (b->waiting[p] && (most == NO_PART || b->waiting[p] > b->waiting[most]))
            most = p;
    }
    return most;
}

void sc_march_apart(const sc_renderer *r, const sc_aim *aims, const sc_line *lines, size_t count,
                    int thread, sc_radiance *out, sc_march_counters *counters)
{
    bundle b = {.renderer = r,
                .aims = aims,
                .lines = lines,
                .room = &r->parts->rooms[thread],
                .out = out,
                .counters = counters,
                .touch_mm = TOUCH_VOXELS * r->march.voxel_mm};

    for (int p = 0; p < r->parts->count; p++)
        b.first[p] = -1;
    for (size_t i = 0; i < count; i++)
        begin_ray(&b, i);
    for (int p = busiest(&b); p != NO_PART; p = busiest(&b))
        follow(&b, p);
    if (!lines && sc_fades_away(r))
        fade_away(count, out, b.room->white);
}
