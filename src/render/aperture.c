/* SPDX-License-Identifier: BSD-3-Clause */
/* Draws tiles of pictures with depth of field, or with light by paths. The rays of a pixel begin
 * all over the aperture, and meet again in the plane in focus; the mean of the linear light that
 * they bring back is the colour of the pixel.
 *
 * The same points for all pixels would show every edge out of focus as often as there are points,
 * and points by chance would be noise. So the samples of the 4 x 4 pixels of a square, taken
 * together, are one net of a scrambled Sobol sequence, and those of each pixel, in the order of a Z
 * through the square, are a net, too: what a pixel misses its neighbours have, and the error that
 * is left is as fine as pixels are (after Ahmed and Wonka 2020, "Screen-space blue-noise diffusion
 * of Monte Carlo sampling error via hierarchical ordering of pixels"). All squares are alike, in
 * all frames, so that nothing flickers. */
#include "directions.h"
#include "tile.h"

#include <string.h>

enum {
    SQUARE_PIXELS = SC_LENS_BLOCK * SC_LENS_BLOCK,
    PILOT_SHARE = 8, /* of a pixel's rays, one in so many goes ahead, */
    PILOT_LEAST = 4, /* if these are so many or more, */
    SEED = 41        /* any: of the scrambled sequences */
};
/* and if these differ no more than by this, in tone (of 255 levels about 6), no others follow. The
 * mean of these few rays is then within a level of that of all. */
#define SAME_TONE 0.024f

/* @return the place of a pixel of a square, by its column and row, in the order of a Z. */
static uint32_t z_order(int x, int y)
{
    uint32_t place = 0;

    for (int bit = 0; 1 << bit < SC_LENS_BLOCK; bit++)
        place |= (uint32_t)((x >> bit & 1) | (y >> bit & 1) << 1) << 2 * bit;
    return place;
}

/* Set the samples of a square of pixels. */
static void set_samples(sc_lens_sample *out, int each)
{
    const uint32_t count = (uint32_t)(SQUARE_PIXELS * each);

    for (int pixel = 0; pixel < SQUARE_PIXELS; pixel++) {
        const uint32_t first =
            (uint32_t)each * z_order(pixel % SC_LENS_BLOCK, pixel / SC_LENS_BLOCK);

        for (int i = 0; i < each; i++) {
            double point[4];

            sc_sobol_point(first + (uint32_t)i, SEED, point);
            sc_sobol_point(sc_shuffled(first + (uint32_t)i, count, SEED + 1), SEED + 2, point + 2);
            for (int c = 0; c < 4; c++)
                out[pixel * each + i].at[c] = (uint16_t)(point[c] * 0x1p16);
        }
    }
}

sc_status sc_lens_samples_make(const sc_ctx *ctx, sc_renderer *r)
{
    const size_t side = (size_t)r->settings.work.tile_px + 2,
                 each = (size_t)r->settings.sampling.lens_samples;

    if (!each)
        return SC_OK;
    SC_PASS(SC_ALLOC(ctx, (size_t)r->settings.work.threads * side * side, &r->room.blurred));
    SC_PASS(SC_ALLOC(ctx, SQUARE_PIXELS * each, &r->room.lens_samples));
    set_samples(r->room.lens_samples, (int)each);
    return SC_OK;
}

/* @return where ray @p i of pixel (x, y), which may be of the border of the viewport, goes. */
static sc_aim aim_of(const sc_renderer *r, int x, int y, int i)
{
    const int column = x & (SC_LENS_BLOCK - 1), row = y & (SC_LENS_BLOCK - 1);
    const int each = r->settings.sampling.lens_samples;
    const sc_lens_sample *sample = &r->room.lens_samples[(row * SC_LENS_BLOCK + column) * each + i];
    double at[4], lens[3];

    for (int c = 0; c < 4; c++)
        at[c] = (sample->at[c] + 0.5) * 0x1p-16;
    sc_cosine_direction(at + 2, lens);
    return (sc_aim){x + at[0], y + at[1], lens[0], lens[1], each * (int)z_order(column, row) + i};
}

/* March the rays waiting, add what they bring back to that of their pixels, and empty the queue. */
static void flush(sc_tile *t)
{
    const sc_renderer *r = t->f->renderer;

    sc_tile_march(t);
    for (size_t i = 0; i < t->rays.count; i++) {
        const sc_radiance *light = &t->rays.light[i];
        sc_blurred_pixel *pixel = &t->blurred[t->rays.target[i]];
        const float cover = sc_cover_of(r, light);
        float seen[4] = {0, 0, 0, cover};

        for (int c = 0; c < 3; c++) {
            seen[c] = light->rgb[c] + light->transmittance * r->behind.tone[c];
            /* Without a background the tone is of what covers the pixel, by its share. */
            if (!r->settings.transparent)
                pixel->light[c] += seen[c] * seen[c] - r->behind.tone[c] * r->behind.tone[c];
            else if (cover > 0)
                pixel->light[c] += seen[c] * seen[c] / cover;
        }
        pixel->cover += cover;
        for (int c = 0; c < 4; c++) {
            pixel->low[c] = fminf(pixel->low[c], seen[c]);
            pixel->high[c] = fmaxf(pixel->high[c], seen[c]);
        }
    }
    t->rays.count = 0;
}

/* Send out rays @p first to @p end of a pixel. Those that meet nothing see the background, which
 * counts, too. */
static void send_rays(sc_tile *t, int x, int y, int first, int end)
{
    const sc_renderer *r = t->f->renderer;
    const uint32_t at = sc_tile_index(t, x, y);
    sc_blurred_pixel *pixel = &t->blurred[at];

    pixel->rays += end - first;
    for (int i = first; i < end; i++) {
        const sc_aim aim = aim_of(r, x, y, i);
        const size_t before = t->rays.count;

        if (t->rays.count == t->rays.most)
            flush(t);
        sc_tile_add_ray(t, &aim, at);
        for (int c = 0; c < 4 && t->rays.count == before; c++) {
            const float behind = c < 3 ? r->behind.tone[c] : 0;

            pixel->low[c] = fminf(pixel->low[c], behind);
            pixel->high[c] = fmaxf(pixel->high[c], behind);
        }
    }
}

/* Do the rays of a pixel that went ahead differ? */
static bool differs(const sc_blurred_pixel *pixel)
{
    for (int c = 0; c < 4; c++) {
        if (pixel->high[c] - pixel->low[c] > SAME_TONE)
            return true;
    }
    return false;
}

/* Do those of a pixel or of one of the four beside it? What only few points of the aperture see may
 * be missed by a pixel, hardly by all of them. */
static bool is_uneven(const sc_tile *t, const sc_blurred_pixel *pixel)
{
    return differs(pixel) || differs(pixel - 1) || differs(pixel + 1) ||
           differs(pixel - t->stride) || differs(pixel + t->stride);
}

/* Store a pixel of the image. */
static void store(const sc_renderer *r, const sc_blurred_pixel *p, uint8_t *to)
{
    const float share = 1 / (float)p->rays;

    if (!r->settings.transparent) {
        for (int c = 0; c < 3; c++)
            to[c] = sc_srgb_level(&r->srgb,
                                  r->behind.tone[c] * r->behind.tone[c] + share * p->light[c]);
        return;
    }
    memcpy(to, r->behind.empty, 4);
    if (!(share * p->cover > 0.5f / 255))
        return;
    for (int c = 0; c < 3; c++)
        to[c] = sc_srgb_level(&r->srgb, p->light[c] / p->cover);
    to[3] = (uint8_t)(255 * fminf(share * p->cover, 1) + 0.5f);
}

/* Find which rays of a pixel are of the moment that a scene shows, from @p first to @p end: of
 * several moments each has its part, or they take turns with one. @return how many of them go
 * ahead of the others. */
static int find_rays(const sc_renderer *r, const sc_scene *scene, int *first, int *end)
{
    const int all = r->settings.sampling.lens_samples,
              moments = scene->moments > 1 ? scene->moments : 1;
    const int each = all > moments ? all / moments : 1;

    *first = scene->moment * each % all;
    *end = *first + each;
    /* Paths always differ. */
    return r->settings.sampling.everywhere || r->light.traces || each < PILOT_SHARE * PILOT_LEAST
               ? each
               : each / PILOT_SHARE;
}

void sc_tile_draw_blurred(sc_tile *t)
{
    const sc_renderer *r = t->f->renderer;
    const sc_image *image = t->f->image;
    const sc_viewport *viewport = t->f->viewport;
    const size_t bytes = sc_pixel_bytes(image->alpha);
    int first, end;
    const int ahead = find_rays(r, t->f->scene, &first, &end);
    const int border = ahead < end - first;

    for (int y = t->y0 - border; y < t->y1 + border && !sc_is_given_up(r); y++) {
        for (int x = t->x0 - border; x < t->x1 + border; x++) {
            sc_blurred_pixel *pixel = &t->blurred[sc_tile_index(t, x, y)];

            *pixel = (sc_blurred_pixel){.low = {1, 1, 1, 1}};
            if (sc_may_show(t->f, x, y))
                send_rays(t, x, y, first, first + ahead);
            else
                *pixel = (sc_blurred_pixel){.rays = 1};
        }
    }
    flush(t);
    if (sc_is_given_up(r))
        return; /* a tile of paths takes seconds */
    /* All are looked at before more rays are added to any. */
    for (int y = t->y0; y < t->y1 && border; y++) {
        for (int x = t->x0; x < t->x1; x++)
            t->pixels[sc_tile_index(t, x, y)].sampled =
                is_uneven(t, &t->blurred[sc_tile_index(t, x, y)]);
    }
    for (int y = t->y0; y < t->y1 && border && !sc_is_given_up(r); y++) {
        for (int x = t->x0; x < t->x1; x++) {
            if (t->pixels[sc_tile_index(t, x, y)].sampled && sc_may_show(t->f, x, y))
                send_rays(t, x, y, first + ahead, end);
        }
    }
    flush(t);
    for (int y = t->y0; y < t->y1; y++) {
        const size_t row = (size_t)(viewport->y_px + y) * (size_t)image->width_px;
        uint8_t *to = image->rgb + (row + (size_t)(viewport->x_px + t->x0)) * bytes;

        for (int x = t->x0; x < t->x1; x++, to += bytes)
            store(r, &t->blurred[sc_tile_index(t, x, y)], to);
    }
}
