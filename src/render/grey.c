/* SPDX-License-Identifier: BSD-3-Clause */
/* The grey volume in pictures: what of it the march shows, and what is seen of it behind the
 * tissues.
 */
#include "internal.h"

#include <string.h>

/* A backdrop is sampled at steps as long as the smallest spacing of its voxels. Its opacity is that
 * of so many mm. */
#define OPACITY_MM 10.0
/* A ray that moves across fewer voxels in a mm than this never leaves the box along that axis. */
#define PARALLEL 1e-12

/* Let the march show a window of the grey volume. */
static void set_window(sc_renderer *r, const sc_grey_window *window)
{
    const sc_grey *from = r->settings.grey;

    r->grey.march.black = (float)((window->level - window->width / 2 - from->low) / from->per_code);
    r->grey.march.white_less = (float)(from->per_code / window->width);
}

sc_status sc_fill_grey(const sc_ctx *ctx, sc_renderer *r)
{
    const sc_grey *from = r->settings.grey;
    sc_march_grey *g = &r->grey.march;
    sc_affine from_ras, from_voxel;

    if (!from)
        return SC_OK;
    if (!sc_affine_invert(&from->to_ras_mm, &from_ras))
        return sc_fail(ctx, SC_ERR_DATA, "the geometry of the image is singular");
    r->grey.to_grey = from_ras;
    from_voxel = sc_affine_compose(&from_ras, &r->volume->to_ras_mm);
    g->codes = from->codes;
    memcpy(g->size, from->size, sizeof g->size);
    for (int i = 0; i < 3; i++) {
        const double *row = from_voxel.m[i];

        for (int j = 0; j < 3; j++)
            g->from_grid[i][j] = (float)row[j];
        /* grid coordinates are those of voxels plus one */
        g->from_grid[i][3] = (float)(row[3] - row[0] - row[1] - row[2]);
    }
    set_window(r, &r->settings.grey_look.window);
    for (int i = 0; i <= SC_GREY_STEPS; i++)
        g->tones[i] = sqrtf((float)sc_srgb_to_linear((double)i / SC_GREY_STEPS));
    return SC_OK;
}

/* ---- the backdrop ---- */

/* A search for bricks of a grey volume in which something is seen. */
typedef struct brick_finder {
    const sc_march_grey *grey;
    double limit; /* codes from here on are seen, ... */
    bool below;   /* or those up to here */
    int bricks[3];
    uint64_t *masks; /* with a frame */
} brick_finder;

/* Is a code seen in the cells of the brick (x, y, z)? */
static bool is_seen(const brick_finder *f, int x, int y, int z)
{
    const int *size = f->grey->size, low[3] = {x * SC_BRICK, y * SC_BRICK, z * SC_BRICK};
    int end[3];
    bool any = false;

    for (int i = 0; i < 3; i++)
        end[i] = low[i] + SC_BRICK + 1 < size[i] ? low[i] + SC_BRICK + 1 : size[i];
    for (int k = low[2]; k < end[2]; k++) {
        for (int j = low[1]; j < end[1]; j++) {
            const uint16_t *row =
                f->grey->codes + ((size_t)k * (size_t)size[1] + (size_t)j) * (size_t)size[0];

            for (int i = low[0]; i < end[0]; i++)
                any |= f->below ? row[i] <= f->limit : row[i] >= f->limit;
        }
    }
    return any;
}

/* Mark the bricks of layers [begin, end) in which something is seen; an sc_range_fn on a
 * brick_finder. */
static void mark_bricks(void *user, size_t begin, size_t end, int thread)
{
    const brick_finder *f = user;
    const int row = sc_framed_row(f->bricks), layer = sc_framed_layer(f->bricks);

    for (size_t z = begin; z < end; z++) {
        for (int y = 0; y < f->bricks[1]; y++) {
            for (int x = 0; x < f->bricks[0]; x++)
                f->masks[sc_framed_index(row, layer, x, y, (int)z)] = is_seen(f, x, y, (int)z);
        }
    }
}

/* Set r->grey.backdrop.distances. Codes of which a sample may round to a place above 0 are seen; a
 * quarter of a step and a share of a code are more than what rounding adds to a sample. */
static sc_status find_bricks(const sc_ctx *ctx, sc_renderer *r)
{
    sc_march_backdrop *b = &r->grey.backdrop;
    const double white_less = (double)r->grey.march.white_less;
    brick_finder f = {.grey = &r->grey.march, .below = white_less < 0};
    void *masks = NULL;
    uint8_t *distances;
    int framed[3];
    sc_status status;

    f.limit = (double)r->grey.march.black + 0.25 / SC_BACKDROP_STEPS / white_less;
    f.limit += f.below ? 0.05 : -0.05;
    for (int i = 0; i < 3; i++)
        f.bricks[i] = b->bricks[i] = (r->grey.march.size[i] + SC_BRICK - 2) / SC_BRICK + 1;
    sc_framed_size(f.bricks, framed);
    SC_TRY(sc_team_alloc(ctx, r->team, sc_brick_count(framed), sizeof *f.masks, &masks));
    f.masks = masks;
    sc_team_for(r->team, (size_t)f.bricks[2], 1, mark_bricks, &f);
    SC_TRY(sc_brick_distances(ctx, r->team, f.bricks, f.masks, &distances));
    b->distances = distances;
out:
    sc_team_free(r->team, masks);
    return status;
}

sc_status sc_find_backdrop(const sc_ctx *ctx, sc_renderer *r)
{
    const sc_renderer *lender = r->settings.work.lender;
    sc_march_backdrop *b = &r->grey.backdrop;

    if (!r->settings.grey || !(r->settings.grey_look.backdrop > 0))
        return SC_OK;
    b->grey = &r->grey.march;
    b->step_mm = HUGE_VALF;
    for (int i = 0; i < 3; i++)
        b->step_mm = fminf(
            b->step_mm, (float)sc_vec3_length(sc_affine_column(&r->settings.grey->to_ras_mm, i)));
    r->grey.follow_backdrop =
        sc_backdrop_find(r->settings.skip, r->grey.march.size, r->settings.cpu);
    if (!sc_skip_is_wide(r->settings.skip))
        return SC_OK;
    if (lender && lender->grey.backdrop.distances) { /* of the same grey volume */
        b->distances = lender->grey.backdrop.distances;
        memcpy(b->bricks, lender->grey.backdrop.bricks, sizeof b->bricks);
        return SC_OK;
    }
    return find_bricks(ctx, r);
}

/* Set what of the backdrop depends on the view. @param opacity of 10 mm of what is white. */
static void set_backdrop(sc_renderer *r, double opacity)
{
    sc_march_backdrop *b = &r->grey.backdrop;
    const sc_march_light *l = &r->march.light;

    /* Attenuation grows with the place in the window: half as white is half as dense. */
    for (int i = 1; i <= SC_BACKDROP_STEPS; i++) {
        const double place = (double)i / SC_BACKDROP_STEPS;
        const double alpha = 1 - pow(1 - opacity, place * (double)b->step_mm / OPACITY_MM);

        b->alphas[i] = (float)alpha;
        b->tones[i] = (float)(alpha * sqrt(sc_srgb_to_linear(place)));
    }
    b->cue = l->cue;
    b->cue_near_mm = l->cue_near_mm;
    b->cue_per_mm = l->cue > 0 ? 1 / (l->cue_far_mm - l->cue_near_mm) : 0;
}

void sc_set_grey(sc_renderer *r, const sc_scene *scene)
{
    const sc_grey_look *all = &r->settings.grey_look;
    const double caps = scene->has_look ? scene->look.grey_caps : all->caps;
    const double slices = scene->has_look ? scene->look.grey_slices : all->slices;
    const double backdrop = scene->has_look ? scene->look.grey_backdrop : all->backdrop;

    if (!r->settings.grey)
        return;
    set_window(r, scene->has_look ? &scene->look.grey_window : &all->window);
    r->march.cut_faces.grey_share = (float)(scene->slice ? slices : caps);
    r->march.cut_faces.grey = r->march.cut_faces.grey_share > 0 ? &r->grey.march : NULL;
    r->grey.is_behind =
        scene->slice ? r->march.cut_faces.grey != NULL : r->grey.follow_backdrop && backdrop > 0;
    if (r->grey.is_behind && !scene->slice)
        set_backdrop(r, fmin(backdrop, 1));
}

/* Where a slice is seen at a point of the viewport: its first clip plane, in an orthographic view.
 * @param point in grid coordinates. @return the distance from the eye in mm. */
static float slice_point(const sc_lens *lens, double x_px, double y_px, float point[3])
{
    const sc_camera *c = &lens->scene->camera;
    const sc_plane *plane = &lens->scene->clip.planes[0];
    const double across = (x_px - lens->middle_px[0]) * lens->px_scale;
    const double upward = (lens->middle_px[1] - y_px) * lens->px_scale;
    const sc_vec3 eye =
        sc_vec3_along(sc_vec3_along(c->position_mm, across, c->right), upward, c->up);
    const double depth = -(sc_vec3_dot(plane->normal, eye) + plane->offset_mm) /
                         sc_vec3_dot(plane->normal, c->forward);
    const sc_vec3 at =
        sc_affine_point(&lens->renderer->space.to_voxel, sc_vec3_along(eye, depth, c->forward));

    point[0] = (float)(at.x + 1);
    point[1] = (float)(at.y + 1);
    point[2] = (float)(at.z + 1);
    return (float)depth;
}

/* Put a slice of the grey volume behind what rays bring back: see sc_put_grey_behind. */
static void put_slice(const sc_lens *lens, const sc_aim *aims, size_t count, sc_radiance *light)
{
    const sc_renderer *r = lens->renderer;

    for (size_t i = 0; i < count; i++) {
        sc_radiance *here = &light[i];
        float point[3], tone[3], on_white[3], depth_mm, left = 0;

        if (!(here->transmittance > 0))
            continue;
        depth_mm = slice_point(lens, aims[i].x_px, aims[i].y_px, point);
        if (!sc_kernel_grey(&r->march, point, depth_mm, tone))
            continue;
        if (sc_fades_away(r) && sc_kernel_grey(&r->behind.on_white, point, depth_mm, on_white))
            left = on_white[0] - tone[0]; /* as in sc_march_rays; all channels are alike */
        for (int c = 0; c < 3; c++)
            here->rgb[c] += here->transmittance * tone[c];
        here->transmittance *= left;
    }
}

/* Cut the ray @p from, in voxels of the grey volume and per mm, down to its box: the outermost
 * faces of its voxels. @param ends in: of the ray, from the eye, in mm; out: of what is left.
 * @return whether anything is. */
static bool clip_to_box(const sc_march_grey *g, sc_vec3 from, sc_vec3 along, double ends[2])
{
    const double at[3] = {from.x, from.y, from.z}, speed[3] = {along.x, along.y, along.z};

    for (int i = 0; i < 3; i++) {
        const double low = (-0.5 - at[i]) / speed[i];
        const double high = (g->size[i] - 0.5 - at[i]) / speed[i];

        if (fabs(speed[i]) < PARALLEL) {
            if (at[i] < -0.5 || at[i] > g->size[i] - 0.5)
                return false;
            continue;
        }
        ends[0] = fmax(ends[0], fmin(low, high));
        ends[1] = fmin(ends[1], fmax(low, high));
    }
    return ends[0] < ends[1];
}

/* Make the ray through the backdrop. Every clip plane cuts the backdrop,
 * as it does tissues that are in no exception. @return false if it meets nothing of it. */
static bool make_backdrop_ray(const sc_lens *lens, const sc_aim *aim, sc_backdrop_ray *ray)
{
    const sc_renderer *r = lens->renderer;
    const sc_scene *scene = lens->scene;
    const sc_sight sight = sc_line_of_sight(lens, aim);
    const sc_vec3 eye = sc_affine_point(&r->grey.to_grey, sight.eye_mm);
    const sc_vec3 along = sc_affine_vector(&r->grey.to_grey, sight.direction);
    double ends[2] = {0, HUGE_VAL};
    sc_vec3 origin;
    sc_interval kept[2];

    if (!clip_to_box(&r->grey.march, eye, along, ends))
        return false;
    ray->stretches =
        sc_clip_ray(scene->clip.planes, scene->clip.set_count ? scene->clip.sets[0] : 0,
                    scene->clip.mode, sight.eye_mm, sight.direction, ends[0], ends[1], kept);
    origin = sc_vec3_along(eye, ends[0], along);
    ray->base_mm = (float)ends[0];
    ray->origin[0] = (float)origin.x;
    ray->origin[1] = (float)origin.y;
    ray->origin[2] = (float)origin.z;
    ray->direction[0] = (float)along.x;
    ray->direction[1] = (float)along.y;
    ray->direction[2] = (float)along.z;
    for (int i = 0; i < ray->stretches; i++) {
        ray->begin_mm[i] = (float)(kept[i].begin_mm - ends[0]);
        ray->end_mm[i] = (float)(kept[i].end_mm - ends[0]);
    }
    return ray->stretches > 0;
}

/* Put the backdrop behind what rays bring back: see sc_put_grey_behind. Those that end at something
 * opaque see nothing of it. @param count at most SC_RAY_BATCH. */
static void put_backdrop(const sc_lens *lens, const sc_aim *aims, size_t count, sc_radiance *light)
{
    const sc_renderer *r = lens->renderer;
    sc_backdrop_ray rays[SC_RAY_BATCH];
    sc_backdrop_light behind[SC_RAY_BATCH];
    size_t target[SC_RAY_BATCH], found = 0;

    for (size_t i = 0; i < count; i++) {
        if (light[i].transmittance >= SC_OPAQUE && make_backdrop_ray(lens, &aims[i], &rays[found]))
            target[found++] = i;
    }
    if (!found)
        return;
    r->grey.follow_backdrop(&r->grey.backdrop, rays, found, behind);
    for (size_t k = 0; k < found; k++) {
        sc_radiance *here = &light[target[k]];

        for (int c = 0; c < 3; c++)
            here->rgb[c] += here->transmittance * behind[k].tone;
        here->transmittance *= behind[k].transmittance;
    }
}

void sc_put_grey_behind(const sc_lens *lens, const sc_aim *aims, size_t count, sc_radiance *light)
{
    if (lens->scene->slice) {
        put_slice(lens, aims, count, light);
        return;
    }
    for (size_t first = 0; first < count; first += SC_RAY_BATCH) /* batches of parts are larger */
        put_backdrop(lens, aims + first,
                     count - first < SC_RAY_BATCH ? count - first : SC_RAY_BATCH, light + first);
}
