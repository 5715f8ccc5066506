/* SPDX-License-Identifier: BSD-3-Clause */
/* Draws one frame, tile by tile. First one ray goes through the middle of every pixel of the tile
 * and of a border one pixel wide. Pixels that differ from a neighbour then get more rays. The
 * colour of a pixel depends on it and its four neighbours alone, not on the division into tiles. */
#include "path.h"

#include <string.h>

/* Positions of the n rays in a pixel, on an n x n grid: there is one in each column, and this is
 * its row. No two are in one row, either (N-rooks sampling), so that edges that are nearly
 * horizontal or vertical get n shades. Of 5 and of 7, one lies in the middle of the pixel. */
static const uint8_t subpixel_rows[SC_SAMPLES_MAX][SC_SAMPLES_MAX] = {{0},
                                                                      {0, 1},
                                                                      {1, 2, 0},
                                                                      {1, 3, 0, 2},
                                                                      {3, 0, 2, 4, 1},
                                                                      {3, 0, 4, 1, 5, 2},
                                                                      {4, 6, 1, 3, 5, 0, 2},
                                                                      {3, 6, 1, 4, 7, 2, 5, 0}};

/* Position of ray @p i of @p samples within a pixel, each coordinate between 0 and 1, to @p out.
 * Ray 0 is the one in the middle, where there is such. */
static void sample_position(int samples, int i, double out[2])
{
    const int column = (i + samples / 2) % samples;

    out[0] = (column + 0.5) / samples;
    out[1] = (subpixel_rows[samples - 1][column] + 0.5) / samples;
}

/* Does one of @p samples rays go through the middle of the pixel? */
static bool has_middle_ray(int samples)
{
    double at[2];

    sample_position(samples, 0, at);
    return at[0] == 0.5 && at[1] == 0.5;
}

/* March the rays queued by queue_first_ray, store what each pixel has seen in t->pixels, and
 * empty the queue. */
static void flush_first_rays(sc_tile *t)
{
    const float *behind = t->f->renderer->behind.tone;

    sc_tile_march(t);
    for (size_t i = 0; i < t->rays.count; i++) {
        const sc_radiance *light = &t->rays.light[i];
        sc_pixel_state *g = &t->pixels[t->rays.target[i]];

        for (int c = 0; c < 3; c++) {
            g->tone[c] = light->rgb[c] + light->transmittance * behind[c];
            g->normal[c] = light->normal[c];
        }
        g->cover = sc_cover_of(t->f->renderer, light);
        g->label = light->label;
        g->signature = light->signature;
        g->nothing = light->transmittance == 1;
    }
    t->rays.count = 0;
}

/* Set the state of a pixel of the tile or its border to that of one that shows nothing, and
 * queue the ray through its middle unless nothing can be seen there. Marches the queue when it
 * is full. */
static void queue_first_ray(sc_tile *t, int x, int y)
{
    const uint32_t at = sc_tile_index(t, x, y);

    t->pixels[at] = t->f->nothing;
    if (!sc_may_show(t->f, x, y))
        return;
    if (t->rays.count == t->rays.most)
        flush_first_rays(t);
    sc_tile_add_ray(t, &(sc_aim){x + 0.5, y + 0.5, 0, 0, 0}, at);
}

/* One ray through every pixel of the tile, and of its border if neighbours will be compared:
 * sets t->pixels. In squares of 4 x 4 pixels and in these in squares of 2 x 2, so that rays that
 * are marched side by side go through the same part of the volume. */
static void cast_first_rays(sc_tile *t)
{
    const int apron = t->f->renderer->settings.sampling.samples > 1 &&
                      !t->f->renderer->hurries; /* neighbours are needed for comparison */
    const int x1 = t->x1 + apron, y1 = t->y1 + apron;

    for (int y = t->y0 - apron; y < y1; y += 4) {
        for (int x = t->x0 - apron; x < x1; x += 4) {
            for (int i = 0; i < 16; i++) {
                const int px = x + (i & 1) + (i >> 1 & 2), py = y + (i >> 1 & 1) + (i >> 2 & 2);

                if (px < x1 && py < y1)
                    queue_first_ray(t, px, py);
            }
        }
    }
    flush_first_rays(t);
}

/* Pixels differ if a colour does by this (of sc_pixel_state.tone: about 14 of 255 levels), or if
 * the cosine between their normals is less than this. */
#define TONE_DIFFERENCE 0.055f
#define NORMAL_COSINE 0.85f

/* Do two colours (sc_pixel_state.tone) differ visibly? */
static bool colours_differ(const float a[3], const float b[3])
{
    for (int i = 0; i < 3; i++) {
        const float d = a[i] - b[i];

        if (d > TONE_DIFFERENCE || d < -TONE_DIFFERENCE)
            return true;
    }
    return false;
}

/* Have two pixels seen different tissues, faces of different direction, or different colours? */
static bool differ(const sc_pixel_state *a, const sc_pixel_state *b)
{
    const float cosine =
        a->normal[0] * b->normal[0] + a->normal[1] * b->normal[1] + a->normal[2] * b->normal[2];

    return a->label != b->label || a->signature != b->signature ||
           (a->label && cosine < NORMAL_COSINE) || colours_differ(a->tone, b->tone) ||
           a->cover - b->cover > TONE_DIFFERENCE || b->cover - a->cover > TONE_DIFFERENCE;
}

/* Does a pixel of the tile differ from one of the four beside it? @param pixel one of t->pixels,
 * not of the border. */
static bool differs_from_neighbours(const sc_tile *t, const sc_pixel_state *pixel)
{
    return differ(pixel, pixel - 1) || differ(pixel, pixel + 1) ||
           differ(pixel, pixel - t->stride) || differ(pixel, pixel + t->stride);
}

/* March the rays queued by sample_pixel, add what each adds to the tone of the background to that
 * of its pixel, and empty the queue. */
static void flush_samples(sc_tile *t)
{
    const float *behind = t->f->renderer->behind.tone;

    sc_tile_march(t);
    for (size_t i = 0; i < t->rays.count; i++) {
        const sc_radiance *light = &t->rays.light[i];
        sc_pixel_state *pixel = &t->pixels[t->rays.target[i]];
        float *added = pixel->added;

        /* What the ray adds to the background: exactly nothing if it has met nothing. */
        for (int c = 0; c < 3; c++)
            added[c] += light->rgb[c] + light->transmittance * behind[c] - behind[c];
        pixel->added_cover += sc_cover_of(t->f->renderer, light);
    }
    t->rays.count = 0;
}

/* Queue the rays of a pixel that have not been marched yet, unless nothing can be seen there, and
 * begin the sum of what they add. Marches the queue when it is full. @param target index in
 * t->pixels of the pixel at (x, y) of the viewport. */
static void sample_pixel(sc_tile *t, int x, int y, uint32_t target)
{
    const sc_render_settings *s = &t->f->renderer->settings;
    const bool has_first = !s->sampling.everywhere && has_middle_ray(s->sampling.samples);
    sc_pixel_state *pixel = &t->pixels[target];

    for (int c = 0; c < 3; c++)
        pixel->added[c] = has_first ? pixel->tone[c] - t->f->renderer->behind.tone[c] : 0;
    pixel->added_cover = has_first ? pixel->cover : 0;
    if (!sc_may_show(t->f, x, y))
        return;
    for (int i = has_first; i < s->sampling.samples; i++) {
        double at[2];

        sample_position(s->sampling.samples, i, at);
        if (t->rays.count == t->rays.most)
            flush_samples(t);
        sc_tile_add_ray(t, &(sc_aim){x + at[0], y + at[1], 0, 0, 0}, target);
    }
}

/* Mark the pixels that differ from a neighbour, or all (settings.everywhere), as sampled, and
 * march settings.samples rays in each, less the one through the middle if it is one of them and has
 * been marched. */
static void refine(sc_tile *t)
{
    const sc_render_settings *s = &t->f->renderer->settings;

    for (int y = t->y0; y < t->y1; y++) {
        sc_pixel_state *row = t->pixels + (y - t->y0 + 1) * t->stride + 1;

        for (int x = 0; x < t->x1 - t->x0; x++)
            row[x].sampled = s->sampling.everywhere || differs_from_neighbours(t, &row[x]);
    }
    for (int y = t->y0; y < t->y1; y++) {
        const int row = (y - t->y0 + 1) * t->stride + 1;

        for (int x = 0; x < t->x1 - t->x0; x++) {
            if (t->pixels[row + x].sampled)
                sample_pixel(t, t->x0 + x, y, (uint32_t)(row + x));
        }
    }
    flush_samples(t);
}

/* Write a pixel of a picture with alpha: the colour is that of what covers the pixel alone, so that
 * nothing of a background is in it. Tones are blended with what is behind as the levels of sRGB
 * nearly are, which is how browsers, players and video editors blend. */
static void store_transparent(const sc_renderer *r, const sc_pixel_state *g, uint8_t *pixel)
{
    const float share = g->sampled ? 1 / (float)r->settings.sampling.samples : 1;
    const float cover = share * (g->sampled ? g->added_cover : g->cover);
    const float *tone = g->sampled ? g->added : g->tone;

    memcpy(pixel, r->behind.empty, 4);
    if (!(cover > 0.5f / 255))
        return;
    for (int c = 0; c < 3; c++) {
        const float own = share * tone[c] / cover;

        pixel[c] = sc_srgb_level(&r->srgb, own * own);
    }
    pixel[3] = (uint8_t)(255 * (cover < 1 ? cover : 1) + 0.5f);
}

/* Write row @p y of the tile (counted in the viewport) from t->pixels to the image, as sRGB. The
 * mean of several rays is that of their tones, nearly as the eye sees them: in linear light, an
 * edge of a dark tissue on white looks as jagged as without antialiasing, because half of the light
 * is three fourths of the lightness. */
static void store_row(const sc_tile *t, int y)
{
    const sc_renderer *r = t->f->renderer;
    const sc_viewport *viewport = t->f->viewport;
    const sc_image *image = t->f->image;
    const size_t row = (size_t)(viewport->y_px + y) * (size_t)image->width_px;
    const sc_pixel_state *g = t->pixels + (y - t->y0 + 1) * t->stride + 1;
    const size_t bytes = sc_pixel_bytes(image->alpha);
    uint8_t *pixel = image->rgb + (row + (size_t)(viewport->x_px + t->x0)) * bytes;

    for (int x = t->x0; x < t->x1; x++, g++, pixel += bytes) {
        if (!g->sampled && g->nothing) {
            memcpy(pixel, r->behind.empty, bytes);
            continue;
        }
        if (image->alpha) {
            store_transparent(r, g, pixel);
            continue;
        }
        for (int c = 0; c < 3; c++) {
            const float tone =
                g->sampled ? r->behind.tone[c] + g->added[c] / (float)r->settings.sampling.samples
                           : g->tone[c];

            pixel[c] = sc_srgb_level(&r->srgb, tone * tone);
        }
    }
}

/* Is nothing visible in any square of the map in the tile? Its border is not examined. */
static bool is_empty(const sc_tile *t)
{
    const int px = 1 << t->f->cover.shift;

    for (int y = t->y0 & -px; y < t->y1; y += px) {
        for (int x = t->x0 & -px; x < t->x1; x += px) {
            if (sc_may_show(t->f, x, y))
                return false;
        }
    }
    return true;
}

/* Write the background to all pixels of the tile in the image. */
static void fill_empty(const sc_tile *t)
{
    const sc_viewport *viewport = t->f->viewport;
    const sc_image *image = t->f->image;
    const size_t bytes = sc_pixel_bytes(image->alpha);

    for (int y = t->y0; y < t->y1; y++) {
        const size_t row = (size_t)(viewport->y_px + y) * (size_t)image->width_px;
        uint8_t *pixel = image->rgb + (row + (size_t)(viewport->x_px + t->x0)) * bytes;

        for (int x = t->x0; x < t->x1; x++, pixel += bytes)
            memcpy(pixel, t->f->renderer->behind.empty, bytes);
    }
}

/* Draw one tile into the image: the background alone where nothing can be seen; else one ray in
 * each pixel and more where pixels differ, or with settings.everywhere all rays of each pixel at
 * once. The caller has set its pixels, bounds and empty queue. */
static void draw_tile(sc_tile *t)
{
    const sc_render_settings *s = &t->f->renderer->settings;

    const bool once = t->f->renderer->hurries;

    if (is_empty(t)) {
        fill_empty(t);
        return;
    }
    if (!once && sc_is_blurred(t->f->renderer, t->f->scene)) {
        sc_tile_draw_blurred(t);
        return;
    }
    if (!s->sampling.everywhere || once)
        cast_first_rays(t);
    if (!once && (s->sampling.everywhere || s->sampling.samples > 1))
        refine(t);
    for (int y = t->y0; y < t->y1; y++)
        store_row(t, y);
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

/* Draw tiles [@p begin, @p end) of the frame @p user, numbered row by row, as far as it is not to
 * be given up: what is left then is not even measured, for asking for the CPU time of the many
 * tiles of a large frame would take seconds. Adds to the stats and the span of the thread. */
static void draw_tiles(void *user, size_t begin, size_t end, int thread)
{
    const sc_frame *f = user;
    const sc_render_settings *s = &f->renderer->settings;
    sc_render_span *span = &f->renderer->room.spans[thread];
    const int side = s->work.tile_px + 2;
    sc_render_stats *stats = &f->renderer->room.stats[thread];
    sc_tile t; /* not initialised as a whole, because it is large */
    double begin_s;

    if (sc_is_given_up(f->renderer))
        return;
    begin_s = sc_thread_cpu_s();
    if (span->begin_s == 0)
        span->begin_s = sc_wall_s();
    t.f = f;
    t.pixels = f->renderer->room.pixels + (size_t)thread * (size_t)side * (size_t)side;
    t.blurred = f->renderer->room.blurred
                    ? f->renderer->room.blurred + (size_t)thread * (size_t)side * (size_t)side
                    : NULL;
    t.stride = side;
    t.thread = thread;
    t.counters = (sc_march_counters){0};
    t.rays.count = 0;
    t.rays.most = sc_parts_apart(f->renderer) && !sc_traces_paths(f->renderer, f->scene)
                      ? SC_APART_BATCH
                      : SC_RAY_BATCH;
    for (size_t i = begin; i < end && !sc_is_given_up(f->renderer); i++) {
        t.x0 = f->column0 + (int)(i % (size_t)f->tiles_x) * s->work.tile_px;
        t.y0 = f->row0 + (int)(i / (size_t)f->tiles_x) * s->work.tile_px;
        t.x1 = least(t.x0 + s->work.tile_px, f->column1);
        t.y1 = least(t.y0 + s->work.tile_px, f->row1);
        draw_tile(&t);
    }
    sc_add_counters(&stats->counters, &t.counters);
    stats->cpu_s += sc_thread_cpu_s() - begin_s;
    span->end_s = sc_wall_s();
}

void sc_render_stats_add(sc_render_stats *sum, const sc_render_stats *more)
{
    sc_add_counters(&sum->counters, &more->counters);
    sum->wall_s += more->wall_s;
    sum->cpu_s += more->cpu_s;
}

void sc_renderer_spans(sc_renderer *r, sc_render_span *out)
{
    const size_t bytes = (size_t)r->settings.work.threads * sizeof *r->room.spans;

    memcpy(out, r->room.spans, bytes);
    memset(r->room.spans, 0, bytes);
}

/* @p value limited to [0, @p high]. */
static int within(int value, int high)
{
    return value < 0 ? 0 : least(value, high);
}

/* Set up light, clip planes, lens, map and parts for a frame whose scene and viewport are set. */
static void begin_view(sc_frame *f)
{
    sc_renderer *r = f->renderer;

    sc_begin_tissues(r, f->scene);
    sc_begin_scene(r, f->scene, f->viewport->height_px);
    if (r->light.gather && !r->hurries && !f->scene->slice && !f->scene->inside)
        sc_gather_scene(r->light.gather, r, f->scene);
    else if (r->hurries)
        memset(r->march.around, 0, sizeof r->march.around);
    if (sc_fades_away(r)) {
        r->behind.on_white = r->march;
        for (int i = 0; i < 3; i++)
            r->behind.on_white.light.cue_rgb[i] = 1;
    }
    sc_lens_init(&f->lens, r, f->scene, f->viewport);
    /* The map is made anew only if scene or viewport differ from the last ones: a rank may draw
     * several bands of one frame, one after the other. */
    sc_cover_view(r, f->scene, f->viewport);
    f->cover = r->cover.map;
    sc_parts_begin(r, f->scene, f->viewport);
    if (sc_traces_paths(r, f->scene))
        sc_paths_begin(r);
}

void sc_render_view(sc_renderer *r, const sc_scene *scene, const sc_viewport *part,
                    const sc_columns_px *columns, const sc_rows *rows, sc_image *image,
                    sc_render_stats *stats)
{
    const double begin_s = sc_wall_s();
    const sc_viewport whole = {0, 0, image->width_px, image->height_px};
    const sc_viewport *viewport = part ? part : &whole;
    const int px = r->settings.work.tile_px, height_px = viewport->height_px;
    const int width_px = viewport->width_px;
    const int column0 = columns ? within(columns->first - viewport->x_px, width_px) : 0;
    const int column1 = columns ? within(columns->end - viewport->x_px, width_px) : width_px;
    const int row0 = rows ? within(rows->first - viewport->y_px, height_px) : 0;
    const int row1 = rows ? within(rows->end - viewport->y_px, height_px) : height_px;
    const int tiles_y = (row1 - row0 + px - 1) / px;
    sc_frame f = {.renderer = r,
                  .scene = scene,
                  .viewport = viewport,
                  .image = image,
                  .nothing = {.nothing = true},
                  .tiles_x = (column1 - column0 + px - 1) / px,
                  .column0 = column0,
                  .column1 = column1,
                  .row0 = row0,
                  .row1 = row1};

    *stats = (sc_render_stats){0};
    if (row0 >= row1 || column0 >= column1)
        return;

    begin_view(&f);
    memcpy(f.nothing.tone, r->behind.tone, sizeof f.nothing.tone);
    memset(r->room.stats, 0, (size_t)r->settings.work.threads * sizeof *r->room.stats);
    sc_parallel_for(r->settings.work.threads, (size_t)f.tiles_x * (size_t)tiles_y, 1, draw_tiles,
                    &f);
    for (int i = 0; i < r->settings.work.threads; i++) {
        sc_add_counters(&stats->counters, &r->room.stats[i].counters);
        stats->cpu_s += r->room.stats[i].cpu_s;
    }
    stats->wall_s = sc_wall_s() - begin_s;
}

void sc_renderer_hurry(sc_renderer *r, bool hurries)
{
    r->hurries = hurries;
    r->cover.viewport = (sc_viewport){0}; /* what scenes point to may have changed meanwhile */
}

sc_pick sc_render_pick(sc_renderer *r, const sc_scene *scene, const int size_px[2], double x_px,
                       double y_px)
{
    const sc_viewport viewport = {0, 0, size_px[0], size_px[1]};
    sc_frame f = {.renderer = r, .scene = scene, .viewport = &viewport};
    const sc_aim aim = {x_px, y_px, 0, 0, 0};
    sc_march_counters counters = {0};
    sc_radiance light = sc_no_light();
    sc_pick pick = {0};
    sc_sight sight;
    sc_ray ray;

    begin_view(&f);
    if (sc_parts_apart(r))
        sc_march_apart(r, &aim, NULL, 1, 0, &light, &counters);
    else if (sc_make_ray(&f.lens, &aim, &ray))
        r->kernel->march(&r->march, &ray, NULL, 1, &light, &counters);
    if (!light.label)
        return pick;
    pick.id = (int)light.label;
    sight = sc_line_of_sight(&f.lens, &aim);
    pick.at_mm = sc_vec3_along(sight.eye_mm, light.depth_mm, sight.direction);
    return pick;
}

/* ---- counts for each pixel ---- */

/* A frame whose work is counted pixel by pixel, into out [height of the viewport][width]. */
typedef struct counting {
    sc_frame f;
    sc_march_counters *out;
} counting;

/* Worker of sc_parallel_for: count rows [@p begin, @p end), marching each ray by itself. */
static void count_rows(void *user, size_t begin, size_t end, int thread)
{
    const counting *c = user;
    const sc_frame *f = &c->f;
    const sc_renderer *r = f->renderer;
    const int width = f->viewport->width_px;
    const double begin_s = sc_thread_cpu_s();

    for (size_t y = begin; y < end && !sc_is_given_up(f->renderer); y++) {
        for (int x = 0; x < width; x++) {
            const sc_aim aim = {x + 0.5, (double)y + 0.5, 0, 0, 0};
            sc_march_counters *out = &c->out[y * (size_t)width + (size_t)x];
            sc_ray ray;
            sc_radiance light;

            if (!sc_may_show_tissue(f, x, (int)y))
                continue;
            if (sc_parts_apart(r))
                sc_march_apart(r, &aim, NULL, 1, thread, &light, out);
            else if (sc_make_ray(&f->lens, &aim, &ray))
                r->kernel->march(&r->march, &ray, NULL, 1, &light, out);
        }
    }
    f->renderer->room.stats[thread].cpu_s += sc_thread_cpu_s() - begin_s;
}

void sc_render_counts(sc_renderer *r, const sc_scene *scene, int width_px, int height_px,
                      sc_march_counters *out, sc_render_stats *stats)
{
    const sc_viewport viewport = {0, 0, width_px, height_px};
    const size_t pixels = (size_t)width_px * (size_t)height_px;
    const double begin_s = sc_wall_s();
    counting c = {.f = {.renderer = r, .scene = scene, .viewport = &viewport}, .out = out};

    *stats = (sc_render_stats){0};
    memset(out, 0, pixels * sizeof *out);
    begin_view(&c.f);
    memset(r->room.stats, 0, (size_t)r->settings.work.threads * sizeof *r->room.stats);
    sc_parallel_for(r->settings.work.threads, (size_t)height_px, 1, count_rows, &c);
    for (size_t i = 0; i < pixels; i++)
        sc_add_counters(&stats->counters, &out[i]);
    for (int i = 0; i < r->settings.work.threads; i++)
        stats->cpu_s += r->room.stats[i].cpu_s;
    stats->wall_s = sc_wall_s() - begin_s;
}
