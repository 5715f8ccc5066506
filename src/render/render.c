/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/render.h"

#include <string.h>

enum { BATCH = 256, SAMPLES_MAX = 4 };

struct sc_renderer {
    sc_render_settings settings;
    const sc_prepared *volume;
    const sc_kernel *kernel;
    sc_march march;
    sc_march_tissue *tissues;
    uint64_t *visible;
    sc_vec3 *hull;
    size_t hull_count;
    sc_affine to_voxel;
    sc_box3 box; /* in voxels: what the kernel has to look at */
    sc_srgb_table srgb;
    float background[3];    /* linear */
    sc_render_stats *stats; /* [threads]; of the frame in work */
};

/* A frame in work. */
typedef struct frame {
    sc_renderer *renderer;
    const sc_scene *scene;
    sc_image *image;
    int tiles_x;
} frame;

/* Rays waiting to be marched together, and the pixels of the tile that they belong to. */
typedef struct batch {
    sc_ray rays[BATCH];
    sc_radiance light[BATCH];
    uint32_t pixel[BATCH];
    size_t count;
} batch;

/* Positions within a pixel: centre; diagonal; three; rotated grid. */
static const double pattern[SAMPLES_MAX][SAMPLES_MAX][2] = {
    {{0, 0}},
    {{-0.25, -0.25}, {0.25, 0.25}},
    {{-0.3333, -0.1667}, {0.0, 0.3333}, {0.3333, -0.1667}},
    {{-0.125, -0.375}, {0.375, -0.125}, {0.125, 0.375}, {-0.375, 0.125}},
};

static double voxel_length_mm(const sc_prepared *volume)
{
    double least = HUGE_VAL;

    for (int i = 0; i < 3; i++)
        least = fmin(least, sc_vec3_length(sc_affine_column(&volume->to_ras_mm, i)));
    return least;
}

static float per_sample(double opacity, double step_voxels)
{
    return (float)(1 - pow(1 - opacity, step_voxels));
}

static uint8_t shown(const sc_tissue *tissue)
{
    if (!tissue->visible)
        return 0;
    return (uint8_t)((tissue->opacity > 0 ? SC_SHOW_BOUNDARY : 0) |
                     (tissue->interior_opacity > 0 ? SC_SHOW_INTERIOR : 0));
}

static void fill_tissues(sc_renderer *r, const sc_tissue *tissues, uint8_t *show)
{
    for (int id = 0; id < r->volume->label_count; id++) {
        sc_march_tissue *to = &r->tissues[id];

        memcpy(to->rgb, tissues[id].rgb_linear, sizeof to->rgb);
        to->boundary_alpha = per_sample(tissues[id].opacity, r->settings.step_voxels);
        to->interior_alpha = per_sample(tissues[id].interior_opacity, r->settings.step_voxels);
        to->show = show[id] = id ? shown(&tissues[id]) : 0;
        to->clip_group = tissues[id].clip_group;
    }
}

/* The voxels a ray must cross: the plain method looks at the whole volume, the accelerated one at
 * the box of what is visible. Half a voxel wider than needed; the kernel tests every index. */
static void fill_box(sc_renderer *r)
{
    const sc_prepared *v = r->volume;
    double low[3] = {-1, -1, -1}, high[3];

    for (int i = 0; i < 3; i++)
        high[i] = v->size[i];
    if (r->settings.skip != SC_SKIP_NONE) {
        for (int i = 0; i < 3; i++) {
            low[i] = v->size[i];
            high[i] = -1;
        }
        for (int id = 1; id < v->label_count; id++) {
            for (int i = 0; i < 3 && r->tissues[id].show; i++) {
                low[i] = fmin(low[i], v->stats[id].low[i] - 1);
                high[i] = fmax(high[i], v->stats[id].high[i] + 1);
            }
        }
    }
    r->box = (sc_box3){{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
}

sc_status sc_renderer_new(const sc_ctx *ctx, const sc_render_settings *settings,
                          const sc_prepared *volume, const sc_tissue *tissues, sc_renderer **out)
{
    const size_t labels = (size_t)volume->label_count;
    sc_renderer *r = NULL;
    void *block = NULL, *show = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, 1, sizeof *r, &block));
    r = block;
    r->settings = *settings;
    r->volume = volume;
    r->kernel = sc_kernel_find(settings->surface, settings->skip, volume->label_bytes);
    if (!sc_affine_invert(&volume->to_ras_mm, &r->to_voxel)) {
        status = sc_fail(ctx, SC_ERR_DATA, "the geometry of the volume is singular");
        goto out;
    }
    SC_TRY(sc_alloc(ctx, labels, sizeof *r->tissues, &block));
    r->tissues = block;
    SC_TRY(sc_alloc(ctx, labels, 1, &show));
    fill_tissues(r, tissues, show);
    SC_TRY(sc_visible_masks(ctx, volume, show, settings->threads, &r->visible));
    SC_TRY(sc_hull_points(ctx, volume, r->visible, &r->hull, &r->hull_count));
    SC_TRY(sc_zalloc(ctx, (size_t)settings->threads, sizeof *r->stats, &block));
    r->stats = block;
    fill_box(r);
    sc_srgb_table_init(&r->srgb);
    for (int i = 0; i < 3; i++)
        r->background[i] = (float)sc_srgb_to_linear(settings->background[i] / 255.0);
    r->march = (sc_march){
        .volume = volume,
        .visible = r->visible,
        .visible_row = volume->bricks[0] + 2,
        .visible_layer = (volume->bricks[0] + 2) * (volume->bricks[1] + 2),
        .tissues = r->tissues,
        .step_mm = (float)(settings->step_voxels * voxel_length_mm(volume)),
        .caps = settings->caps,
    };
    *out = r;
    r = NULL;
out:
    sc_free(show);
    sc_renderer_free(r);
    return status;
}

void sc_renderer_free(sc_renderer *r)
{
    if (!r)
        return;
    sc_free(r->tissues);
    sc_free(r->visible);
    sc_free(r->hull);
    sc_free(r->stats);
    sc_free(r);
}

const sc_vec3 *sc_renderer_hull(const sc_renderer *renderer, size_t *count)
{
    *count = renderer->hull_count;
    return renderer->hull;
}

const sc_kernel *sc_renderer_kernel(const sc_renderer *renderer)
{
    return renderer->kernel;
}

/* Kept parts of the ray per clip group, as ranges of samples. @return false if nothing is kept. */
static bool fill_parts(const sc_renderer *r, const sc_scene *scene, sc_vec3 origin,
                       sc_vec3 direction, double begin, double end, sc_ray *ray)
{
    const double step = r->march.step_mm;
    bool any = false;

    ray->groups = (uint8_t)scene->group_count;
    for (int g = 0; g < scene->group_count; g++) {
        sc_interval kept[2];

        ray->parts[g] = (uint8_t)sc_clip_ray(scene->planes, scene->groups[g], scene->clip_mode,
                                             origin, direction, begin, end, kept);
        for (int i = 0; i < ray->parts[g]; i++) {
            ray->first[g][i] = (int32_t)ceil(kept[i].begin_mm / step - 0.5);
            ray->last[g][i] = (int32_t)ceil(kept[i].end_mm / step - 0.5);
            ray->cap_mm[g][i] = (float)kept[i].begin_mm;
            ray->cap_plane[g][i] = (int8_t)kept[i].begin_plane;
            any = true;
        }
    }
    return any;
}

static bool make_ray(const frame *f, double px, double py, sc_ray *ray)
{
    const sc_renderer *r = f->renderer;
    const sc_render_settings *s = &r->settings;
    sc_vec3 origin_mm, direction, origin, along;
    double begin = 0, end = 1e12;

    sc_camera_ray(&f->scene->camera, 2 * px / s->width_px - 1, 1 - 2 * py / s->height_px,
                  (double)s->width_px / s->height_px, &origin_mm, &direction);
    origin = sc_affine_point(&r->to_voxel, origin_mm);
    along = sc_affine_vector(&r->to_voxel, direction);
    if (!sc_box3_clip_line(&r->box, origin, along, &begin, &end))
        return false;
    ray->origin[0] = (float)(origin.x + 1.5);
    ray->origin[1] = (float)(origin.y + 1.5);
    ray->origin[2] = (float)(origin.z + 1.5);
    ray->direction[0] = (float)along.x;
    ray->direction[1] = (float)along.y;
    ray->direction[2] = (float)along.z;
    ray->toward_eye[0] = (float)-direction.x;
    ray->toward_eye[1] = (float)-direction.y;
    ray->toward_eye[2] = (float)-direction.z;
    return fill_parts(r, f->scene, origin_mm, direction, begin, end, ray);
}

/* March the waiting rays and add what they bring to their pixels' sums. */
static void flush_batch(const frame *f, batch *b, float (*sums)[4], sc_march_counters *counters)
{
    f->renderer->kernel->march(&f->renderer->march, b->rays, b->count, b->light, counters);
    for (size_t i = 0; i < b->count; i++) {
        float *sum = sums[b->pixel[i]];

        for (int c = 0; c < 3; c++)
            sum[c] += b->light[i].rgb[c];
        sum[3] += 1 - b->light[i].transmittance;
    }
    b->count = 0;
}

/* One row of a tile: rays, sums, pixels. */
static void draw_row(const frame *f, int x0, int x1, int y, batch *b, sc_march_counters *counters)
{
    const sc_renderer *r = f->renderer;
    const int samples = r->settings.samples;
    float sums[BATCH][4];

    memset(sums, 0, sizeof sums);
    for (int x = x0; x < x1; x++) {
        for (int s = 0; s < samples; s++) {
            const double *at = pattern[samples - 1][s];

            if (b->count == BATCH)
                flush_batch(f, b, sums, counters);
            if (!make_ray(f, x + 0.5 + at[0], y + 0.5 + at[1], &b->rays[b->count]))
                continue;
            b->pixel[b->count++] = (uint32_t)(x - x0);
        }
    }
    flush_batch(f, b, sums, counters);
    for (int x = x0; x < x1; x++) {
        const float *sum = sums[x - x0];
        uint8_t *pixel = f->image->rgb + ((size_t)y * (size_t)f->image->width_px + (size_t)x) * 3;

        for (int c = 0; c < 3; c++)
            pixel[c] = sc_srgb_level(
                &r->srgb, (sum[c] + ((float)samples - sum[3]) * r->background[c]) / (float)samples);
    }
}

static void add_counters(sc_march_counters *to, const sc_march_counters *from)
{
    to->rays += from->rays;
    to->samples += from->samples;
    to->contributions += from->contributions;
}

static void draw_tiles(void *user, size_t begin, size_t end, int thread)
{
    const frame *f = user;
    const sc_render_settings *s = &f->renderer->settings;
    const double begin_s = sc_thread_cpu_s();
    sc_render_stats *stats = &f->renderer->stats[thread];
    sc_march_counters counters = {0};
    batch b;

    b.count = 0;
    for (size_t tile = begin; tile < end; tile++) {
        const int x0 = (int)(tile % (size_t)f->tiles_x) * s->tile_px;
        const int y0 = (int)(tile / (size_t)f->tiles_x) * s->tile_px;
        const int x1 = x0 + s->tile_px < s->width_px ? x0 + s->tile_px : s->width_px;
        const int y1 = y0 + s->tile_px < s->height_px ? y0 + s->tile_px : s->height_px;

        for (int y = y0; y < y1; y++)
            draw_row(f, x0, x1, y, &b, &counters);
    }
    add_counters(&stats->counters, &counters);
    stats->cpu_s += sc_thread_cpu_s() - begin_s;
}

/* Above the viewer's left shoulder. */
static void place_light(sc_renderer *r, const sc_scene *scene)
{
    const sc_camera *c = &scene->camera;
    const sc_vec3 light = sc_vec3_unit(
        sc_vec3_along(sc_vec3_along(sc_vec3_scale(c->forward, -1), -0.55, c->right), 0.75, c->up));

    r->march.key_light[0] = (float)light.x;
    r->march.key_light[1] = (float)light.y;
    r->march.key_light[2] = (float)light.z;
    for (int i = 0; i < scene->plane_count; i++) {
        r->march.plane_normals[i][0] = (float)scene->planes[i].normal.x;
        r->march.plane_normals[i][1] = (float)scene->planes[i].normal.y;
        r->march.plane_normals[i][2] = (float)scene->planes[i].normal.z;
    }
}

void sc_render_frame(sc_renderer *r, const sc_scene *scene, sc_image *image, sc_render_stats *stats)
{
    const double begin_s = sc_wall_s();
    const int tile = r->settings.tile_px;
    const int tiles_y = (r->settings.height_px + tile - 1) / tile;
    frame f = {.renderer = r,
               .scene = scene,
               .image = image,
               .tiles_x = (r->settings.width_px + tile - 1) / tile};

    place_light(r, scene);
    memset(r->stats, 0, (size_t)r->settings.threads * sizeof *r->stats);
    sc_parallel_for(r->settings.threads, (size_t)f.tiles_x * (size_t)tiles_y, 1, draw_tiles, &f);
    *stats = (sc_render_stats){0};
    for (int i = 0; i < r->settings.threads; i++) {
        add_counters(&stats->counters, &r->stats[i].counters);
        stats->cpu_s += r->stats[i].cpu_s;
    }
    stats->wall_s = sc_wall_s() - begin_s;
}
