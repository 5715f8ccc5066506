/* SPDX-License-Identifier: BSD-3-Clause */
/* The grey volume in pictures: what of it the march shows, and what is seen of it behind the
 * tissues.
 */
#include "internal.h"

#include <string.h>

sc_status sc_fill_grey(const sc_ctx *ctx, sc_renderer *r)
{
    const sc_grey *from = r->settings.grey;
    const sc_grey_window *w = &r->settings.grey_look.window;
    sc_march_grey *g = &r->grey;
    sc_affine from_ras, from_voxel;

    if (!from)
        return SC_OK;
    if (!sc_affine_invert(&from->to_ras_mm, &from_ras))
        return sc_fail(ctx, SC_ERR_DATA, "the geometry of the image is singular");
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
    g->black = (float)((w->level - w->width / 2 - from->low) / from->per_code);
    g->white_less = (float)(from->per_code / w->width);
    for (int i = 0; i <= SC_GREY_STEPS; i++)
        g->tones[i] = sqrtf((float)sc_srgb_to_linear((double)i / SC_GREY_STEPS));
    return SC_OK;
}

void sc_set_grey(sc_renderer *r, const sc_scene *scene)
{
    const sc_grey_look *all = &r->settings.grey_look;
    const double caps = scene->has_look ? scene->look.grey_caps : all->caps;
    const double slices = scene->has_look ? scene->look.grey_slices : all->slices;

    if (!r->settings.grey)
        return;
    r->march.grey_share = (float)(scene->slice ? slices : caps);
    r->march.grey = r->march.grey_share > 0 ? &r->grey : NULL;
    r->grey_behind = scene->slice && r->march.grey;
}

/* Where a slice is seen at a point of the viewport: its first clip plane, in an orthographic view.
 * @param point in grid coordinates. @return the distance from the eye in mm. */
static float slice_point(const sc_lens *lens, double x_px, double y_px, float point[3])
{
    const sc_camera *c = &lens->scene->camera;
    const sc_plane *plane = &lens->scene->planes[0];
    const double across = (x_px - lens->middle_px[0]) * lens->px_scale;
    const double upward = (lens->middle_px[1] - y_px) * lens->px_scale;
    const sc_vec3 eye =
        sc_vec3_along(sc_vec3_along(c->position_mm, across, c->right), upward, c->up);
    const double depth = -(sc_vec3_dot(plane->normal, eye) + plane->offset_mm) /
                         sc_vec3_dot(plane->normal, c->forward);
    const sc_vec3 at =
        sc_affine_point(&lens->renderer->to_voxel, sc_vec3_along(eye, depth, c->forward));

    point[0] = (float)(at.x + 1);
    point[1] = (float)(at.y + 1);
    point[2] = (float)(at.z + 1);
    return (float)depth;
}

void sc_put_grey_behind(const sc_lens *lens, const double (*at_px)[2], size_t count,
                        sc_radiance *light)
{
    const sc_renderer *r = lens->renderer;

    for (size_t i = 0; i < count; i++) {
        sc_radiance *here = &light[i];
        float point[3], tone[3], on_white[3], depth_mm, left = 0;

        if (!(here->transmittance > 0))
            continue;
        depth_mm = slice_point(lens, at_px[i][0], at_px[i][1], point);
        if (!sc_kernel_grey(&r->march, point, depth_mm, tone))
            continue;
        if (sc_fades_away(r) && sc_kernel_grey(&r->on_white, point, depth_mm, on_white))
            left = on_white[0] - tone[0]; /* as in sc_march_rays; all channels are alike */
        for (int c = 0; c < 3; c++)
            here->rgb[c] += here->transmittance * tone[c];
        here->transmittance *= left;
    }
}
