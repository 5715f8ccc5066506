/* SPDX-License-Identifier: BSD-3-Clause */
/* Follows paths: all those of a batch go on by one surface before any goes on by the next, so that
 * kernels have many rays to march. */
#include "path.h"

#include "directions.h"

#include <string.h>

/* Rays begin so far above a surface, in voxels: more than a float leaves open, less than crevices
 * are wide. A sample of the voxel surface lies somewhere in a voxel, which a ray must leave. */
#define LIFT_VOXELS 0.02
#define LIFT_FROM_VOXEL 1.0
enum {
    /* Numbers by chance come in pairs, of which each surface of a path takes these: */
    DIRECTION, /* in which the path goes on, */
    LIGHT,     /* to which point of the lamp a ray goes, */
    CHOICE,    /* whether the face reflects, and whether the path goes on at all, */
    ARRIVAL, /* and at which of the surfaces that let light through it has arrived; and whether the
                lamp or the sky is looked at */
    PAIRS,
    TABLED = 4 * PAIRS, /* of the first surfaces pairs are points of nets, of others just random */
    SEED = 97,          /* any: of these nets */
    SURE = 3,           /* surfaces after which a path may end by chance */
    BOUNCES_MAX = 200   /* without any that is black a path in a dead end would have none */
};

/* A path on its way. */
typedef struct path {
    sc_vec3 at, direction; /* RAS mm: where its present ray begins, and whereto */
    uint32_t seed, index;  /* of its numbers: of the square of pixels, and its own */
    double share[3];       /* of the light at its end that it brings */
    double density;        /* with which its present direction was chosen */
    double light[3];       /* what it has brought */
    float ends_below;      /* of its present ray */
    float depth_mm;        /* of its first surface; HUGE_VALF: none */
    bool on_floor;         /* that is the floor: then light is its share, as of sc_floor.light */
    sc_vec3 to_light;      /* where its further ray goes, and what that brings if it is free */
    double waiting[3];
} path;

/* The paths of a batch. */
typedef struct tracer {
    const sc_tile *tile;
    sc_batch *batch;
    sc_march_counters *counters;
    path paths[SC_RAY_BATCH];
    uint32_t alive[SC_RAY_BATCH]; /* [alive_count] those that go on */
    size_t alive_count;
    uint32_t of[SC_RAY_BATCH];   /* the path of each ray of the batch */
    sc_line lines[SC_RAY_BATCH]; /* the same rays, used where tissues have moved */
} tracer;

/* @return how many paths the pixels of a square have together. */
static uint32_t square_count(const sc_renderer *r)
{
    return (uint32_t)(SC_LENS_BLOCK * SC_LENS_BLOCK * r->settings.sampling.lens_samples);
}

uint64_t sc_path_numbers_bytes(const sc_renderer *r)
{
    return r->light.path_numbers
               ? (uint64_t)TABLED * square_count(r) * sizeof *r->light.path_numbers
               : 0;
}

sc_status sc_path_numbers_make(const sc_ctx *ctx, sc_renderer *r)
{
    const uint32_t count = square_count(r);

    if (!r->light.traces)
        return SC_OK;
    SC_PASS(SC_ALLOC(ctx, (size_t)TABLED * count, &r->light.path_numbers));
    for (uint32_t i = 0; i < TABLED * count; i++) {
        const uint32_t pair = i / count;
        double point[2];

        sc_sobol_point(sc_shuffled(i % count, count, sc_mix(SEED, pair)), sc_mix(SEED + 1, pair),
                       point);
        for (int k = 0; k < 2; k++)
            r->light.path_numbers[i][k] = (uint32_t)(point[k] * 0x1p32);
    }
    return SC_OK;
}

/* Two numbers, each in [0, 1), of a path at its surface number @p bounce, to @p out. */
static void take_pair(const sc_renderer *r, const path *p, uint32_t bounce, uint32_t use,
                      double out[2])
{
    const uint32_t pair = bounce * PAIRS + use, seed = sc_mix(p->seed, pair);

    for (uint32_t k = 0; k < 2; k++) {
        const uint32_t own =
            pair < TABLED ? r->light.path_numbers[(size_t)pair * square_count(r) + p->index][k]
                          : sc_mix(p->index, seed + k);

        out[k] = (own ^ sc_mix(seed, k)) * 0x1p-32;
    }
}

/* Choose how much light must be left for the ray of a path towards surface number @p bounce not to
 * end. */
static void choose_end(const sc_renderer *r, path *p, uint32_t bounce)
{
    double pair[2];

    take_pair(r, p, bounce, ARRIVAL, pair);
    p->ends_below = fmaxf((float)(1 - pair[0]), SC_OPAQUE);
}

/* Begin the paths of all rays that wait. */
static void begin(tracer *t)
{
    const sc_frame *f = t->tile->f;

    for (size_t i = 0; i < t->batch->count; i++) {
        const sc_aim *aim = &t->batch->aims[i];
        const int x = (int)floor(aim->x_px), y = (int)floor(aim->y_px);
        const sc_sight sight = sc_line_of_sight(&f->lens, aim);
        path *p = &t->paths[i];

        *p = (path){.at = sight.eye_mm,
                    .direction = sight.direction,
                    .share = {1, 1, 1},
                    .depth_mm = HUGE_VALF};
        p->seed = sc_mix(sc_mix((uint32_t)(x & -SC_LENS_BLOCK), (uint32_t)(y & -SC_LENS_BLOCK)),
                         (uint32_t)f->scene->frame);
        p->index = (uint32_t)aim->number;
        choose_end(f->renderer, p, 0);
        t->batch->rays[i].ends_below = p->ends_below;
        t->lines[i] = (sc_line){sight.eye_mm, sight.direction, p->ends_below};
        t->of[i] = (uint32_t)i;
    }
}

/* March the rays of the batch. */
static void march(tracer *t, size_t count)
{
    const sc_renderer *r = t->tile->f->renderer;

    if (sc_parts_apart(r))
        sc_march_apart(r, NULL, t->lines, count, t->tile->thread, t->batch->light, t->counters);
    else
        r->kernel->march(&r->light.traced, t->batch->rays, NULL, count, t->batch->light,
                         t->counters);
}

/* Make ray number @p k of the batch, from where a path is. @return false if it meets nothing. */
static bool make_ray(tracer *t, size_t k, const path *p, sc_vec3 direction, float ends_below)
{
    const sc_frame *f = t->tile->f;

    t->lines[k] = (sc_line){p->at, direction, ends_below};
    return sc_parts_apart(f->renderer) ||
           sc_make_ray_from(&f->lens, &t->lines[k], &t->batch->rays[k]);
}

static void to_array(sc_vec3 v, double out[3])
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

/* Let a path see what is behind all tissue: it ends there. Its own eye sees the background. */
static void leave(const tracer *t, path *p, uint32_t bounce)
{
    const sc_renderer *r = t->tile->f->renderer;
    const sc_march_light *light = &r->march.light;
    double d[3], seen[3] = {0};
    double weight;

    if (!bounce)
        return;
    to_array(p->direction, d);
    sc_add_light_from(&r->light.sky, light, d, seen);
    weight = p->density / (p->density + sc_light_density(&r->light.sky, light, d));
    for (int i = 0; i < 3; i++)
        p->light[i] += p->share[i] * weight * seen[i];
}

/* A surface that a path has met, in its own frame. */
typedef struct meeting {
    sc_reflector reflector;
    double axes[3][3]; /* RAS; the third is the normal, on the side of the path */
} meeting;

/* Bring a direction, RAS, into the frame of a surface, or back. */
static void into_frame(const meeting *m, const double d[3], double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = m->axes[k][0] * d[0] + m->axes[k][1] * d[1] + m->axes[k][2] * d[2];
}

static void out_of_frame(const meeting *m, const double d[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m->axes[0][i] * d[0] + m->axes[1][i] * d[1] + m->axes[2][i] * d[2];
}

/* Move a path to the surface that its ray has met, and describe that. */
static void arrive(const sc_renderer *r, path *p, const sc_radiance *hit, meeting *m)
{
    double back[3], out[3], rgb[3], in_grid = 0;

    for (int i = 0; i < 3; i++) {
        const float *row = r->march.grid_per_mm[i];
        const double along =
            row[0] * hit->normal[0] + row[1] * hit->normal[1] + row[2] * hit->normal[2];

        m->axes[2][i] = hit->normal[i];
        rgb[i] = (double)hit->rgb[i] * hit->rgb[i];
        in_grid += along * along;
    }
    sc_frame_about(m->axes[2], m->axes[0], m->axes[1]);
    to_array(sc_vec3_scale(p->direction, -1), back);
    into_frame(m, back, out);
    m->reflector = sc_reflector_of(&r->tissues[hit->label], rgb, out);
    p->at = sc_vec3_along(
        sc_vec3_along(p->at, hit->depth_mm, p->direction),
        (r->settings.surface == SC_SURFACE_SMOOTH ? LIFT_VOXELS : LIFT_FROM_VOXEL) / sqrt(in_grid),
        (sc_vec3){hit->normal[0], hit->normal[1], hit->normal[2]});
}

/* @return the light of component @p i that the floor would get without tissues where its normal is
 * @p n, by what white gives back. */
static double light_without(const sc_renderer *r, const double n[3], int i)
{
    const sc_march_light *light = &r->march.light;
    const float *d = r->march.light.key_direction, *around = light->around[i];
    const double lamp = fmax(n[0] * d[0] + n[1] * d[1] + n[2] * d[2], 0) * light->key;
    const double sky = light->has_map
                           ? around[0] + n[0] * around[1] + n[1] * around[2] + n[2] * around[3]
                           : SC_SKY_MEAN + SC_SKY_UP * n[2] * 2 / 3;

    return fmax(lamp + light->sky * sky, 1e-6);
}

/* Let a path whose eye sees the floor arrive there. @return whether it does. */
static bool land(const sc_renderer *r, path *p, meeting *m)
{
    const sc_sight sight = {.eye_mm = p->at, .direction = p->direction};

    *m = (meeting){.reflector = {.out = {0, 0, 1}}};
    if (!r->light.floor.is_shown || !sc_floor_meets(&r->light.floor, &sight, &p->at, m->axes[2]))
        return false;
    p->on_floor = true;
    sc_frame_about(m->axes[2], m->axes[0], m->axes[1]);
    for (int i = 0; i < 3; i++)
        m->reflector.albedo[i] = 1 / light_without(r, m->axes[2], i);
    return true;
}

/* Choose a point of lamp or sky, and note what comes from there if nothing is between. */
static void look_to_light(const sc_renderer *r, path *p, uint32_t bounce, const meeting *m)
{
    const sc_march_light *light = &r->march.light;
    double pair[2], point[2], d[3], in[3], share[3], seen[3] = {0}, density, weight;

    p->waiting[0] = p->waiting[1] = p->waiting[2] = 0;
    take_pair(r, p, bounce, LIGHT, point);
    take_pair(r, p, bounce, ARRIVAL, pair);
    density = sc_choose_light(&r->light.sky, light, pair[1], point, d);
    if (!(density > 0))
        return;
    into_frame(m, d, in);
    weight = 1 / (density + sc_reflector_share(&m->reflector, in, share));
    sc_add_light_from(&r->light.sky, light, d, seen);
    p->to_light = (sc_vec3){d[0], d[1], d[2]};
    for (int i = 0; i < 3; i++)
        p->waiting[i] = p->share[i] * share[i] * seen[i] * weight;
}

/* Choose where a path goes on. @return whether it does. */
static bool go_on(const sc_renderer *r, path *p, uint32_t bounce, const meeting *m)
{
    double point[2], pair[2], in[3], share[3], d[3], most = 0;

    take_pair(r, p, bounce, DIRECTION, point);
    take_pair(r, p, bounce, CHOICE, pair);
    sc_reflector_choose(&m->reflector, pair[0], point, in);
    p->density = sc_reflector_share(&m->reflector, in, share);
    if (!(p->density > 0))
        return false;
    for (int i = 0; i < 3; i++) {
        p->share[i] *= share[i] / p->density;
        most = fmax(most, p->share[i]);
    }
    out_of_frame(m, in, d);
    p->direction = sc_vec3_unit((sc_vec3){d[0], d[1], d[2]});
    if (bounce >= SURE && !(pair[1] < most))
        return false;
    for (int i = 0; i < 3 && bounce >= SURE && most < 1; i++)
        p->share[i] /= most;
    choose_end(r, p, bounce + 1);
    return most > 0;
}

/* Begin the light on the floor with what there would be without tissues, less what the rays of the
 * path bring if nothing is in their way: so what is seen has no noise where nothing is. */
static void owe_light(const tracer *t, path *p)
{
    path free = *p;

    if (p->density > 0)
        leave(t, &free, 1);
    for (int i = 0; i < 3; i++)
        p->light[i] = 1 - p->waiting[i] - free.light[i];
}

/* Let all paths whose rays have been marched meet what these have found: sets t->alive. */
static void meet(tracer *t, size_t count, uint32_t bounce)
{
    const sc_renderer *r = t->tile->f->renderer;

    t->alive_count = 0;
    for (size_t k = 0; k < count; k++) {
        const sc_radiance *hit = &t->batch->light[k];
        path *p = &t->paths[t->of[k]];
        meeting m;

        if (hit->transmittance < p->ends_below) {
            arrive(r, p, hit, &m);
            for (int i = 0; i < 3 && !bounce; i++) /* the light at the eye, which sees no shadows */
                p->light[i] += m.reflector.albedo[i] * r->march.light.head * m.reflector.out[2];
            if (!bounce)
                p->depth_mm = hit->depth_mm;
        } else if (bounce || !land(r, p, &m)) {
            leave(t, p, bounce);
            continue;
        }
        look_to_light(r, p, bounce, &m);
        if (!go_on(r, p, bounce, &m))
            p->density = 0;
        if (p->on_floor && !bounce)
            owe_light(t, p);
        t->alive[t->alive_count++] = t->of[k];
    }
}

/* Add what comes to the paths from the lamp. */
static void light_up(tracer *t)
{
    size_t count = 0;

    for (size_t k = 0; k < t->alive_count; k++) {
        path *p = &t->paths[t->alive[k]];

        if (!(p->waiting[0] + p->waiting[1] + p->waiting[2] > 0))
            continue;
        if (make_ray(t, count, p, p->to_light, 0)) {
            t->of[count++] = t->alive[k];
            continue;
        }
        for (int i = 0; i < 3; i++)
            p->light[i] += p->waiting[i];
    }
    march(t, count);
    for (size_t k = 0; k < count; k++) {
        path *p = &t->paths[t->of[k]];

        for (int i = 0; i < 3; i++)
            p->light[i] += p->waiting[i] * t->batch->light[k].transmittance;
    }
}

/* Send the paths on: makes their rays. @return how many. */
static size_t send_on(tracer *t, uint32_t bounce)
{
    size_t count = 0;

    for (size_t k = 0; k < t->alive_count; k++) {
        path *p = &t->paths[t->alive[k]];

        if (!(p->density > 0))
            continue;
        if (!make_ray(t, count, p, p->direction, p->ends_below)) {
            leave(t, p, bounce);
            continue;
        }
        t->of[count++] = t->alive[k];
    }
    return count;
}

/* What the eye sees of a path, with the depth cue, to @p out. */
static void finish(const sc_renderer *r, const path *p, sc_radiance *out)
{
    const sc_march_light *light = &r->march.light;
    const float far = (p->depth_mm - light->cue_near_mm) / (light->cue_far_mm - light->cue_near_mm);
    const double cue = light->cue > 0 ? light->cue * fmin(fmax(far, 0), 1) : 0;

    *out = sc_no_light();
    if (p->on_floor) {
        float share[3];

        for (int i = 0; i < 3; i++)
            share[i] = (float)fmax(p->light[i], 0);
        sc_floor_show(r, share, out);
    }
    if (p->depth_mm == HUGE_VALF)
        return;
    out->transmittance = r->settings.transparent ? (float)cue : 0;
    for (int i = 0; i < 3; i++)
        out->rgb[i] = (float)(r->settings.transparent
                                  ? (1 - cue) * sqrt(p->light[i])
                                  : sqrt((1 - cue) * p->light[i] + cue * light->cue_rgb[i]));
}

void sc_tile_trace(sc_tile *t)
{
    tracer all; /* not initialised as a whole, because it is large */
    size_t count = t->rays.count;

    all.tile = t;
    all.batch = &t->rays;
    all.counters = &t->counters;
    begin(&all);
    for (uint32_t bounce = 0; count && bounce < BOUNCES_MAX; bounce++) {
        march(&all, count);
        meet(&all, count, bounce);
        light_up(&all);
        count = send_on(&all, bounce + 1);
    }
    for (size_t i = 0; i < t->rays.count; i++)
        finish(t->f->renderer, &all.paths[i], &t->rays.light[i]);
}

void sc_paths_begin(sc_renderer *r)
{
    r->light.traced = r->march;
    r->light.traced.light = (sc_march_light){.flat = true, .edges = r->march.light.edges};
    for (int k = 0; sc_parts_apart(r) && k < r->parts->shown_count; k++) {
        sc_renderer *own = r->parts->list[r->parts->shown[k]].renderer;

        own->light.traced = own->march;
        own->light.traced.light = r->light.traced.light;
    }
}
