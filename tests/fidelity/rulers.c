/* SPDX-License-Identifier: BSD-3-Clause */
/* Prints what the rulers measure. */
#include "rulers.h"

sc_status print_wobble(const sc_ctx *ctx, const ruling *r)
{
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    wobble w;

    SC_PASS(sc_volume_read(ctx, r->path, &volume));
    SC_PASS(measure_wobble(ctx, &volume, &r->how, &w));
    if (r->json) {
        printf("{\"schema\": \"segcast-wobble-1\", ");
        print_value("outline_voxels", w.outline, false);
        print_value("seam_voxels", w.seam, false);
        print_value("outline_points", (double)w.outline_points, false);
        print_value("seam_points", (double)w.seam_points, false);
        print_value("pairs", (double)w.pairs, true);
        printf("}\n");
    } else {
        printf("outline %.3f voxels (%zu points); seams %.3f voxels (%zu points, %zu pairs)\n",
               w.outline, w.outline_points, w.seam, w.seam_points, w.pairs);
    }
    return SC_OK;
}

sc_status print_lines(const sc_ctx *ctx, const ruling *r)
{
    if (r->json)
        printf("{\"schema\": \"segcast-lines-1\", \"lines\": [\n");
    else
        printf("%-34s %9s %9s %12s %9s\n", "lines", "voxels %", "links %", "pieces", "width");
    for (size_t n = 0; n < line_count(); n++) {
        survivors s;

        SC_PASS(measure_lines(ctx, n, &r->how, &s));
        if (r->json) {
            printf("%s  {\"lines\": \"%s\", ", n ? ",\n" : "", s.name);
            print_value("voxels_share", s.voxels, false);
            print_value("links_share", s.links, false);
            print_value("pieces", s.pieces, false);
            print_value("true_pieces", s.true_pieces, false);
            print_value("width_voxels", s.width, true);
            printf("}");
        } else {
            printf("%-34s %9.1f %9.1f %5d of %3d %9.2f\n", s.name, 100 * s.voxels, 100 * s.links,
                   s.pieces, s.true_pieces, s.width);
        }
    }
    if (r->json)
        printf("\n]}\n");
    return SC_OK;
}

sc_status print_edges(const sc_ctx *ctx, const ruling *r)
{
    if (r->json)
        printf("{\"schema\": \"segcast-edges-1\", \"edges\": [\n");
    else
        printf("%-38s %9s %9s %9s\n", "edges", "retreat", "wobble", "voxels %");
    for (size_t n = 0; n < edge_count(); n++) {
        sharp_edge e;

        SC_PASS(measure_edge(ctx, n, &r->how, &e));
        if (r->json) {
            printf("%s  {\"edge\": \"%s\", ", n ? ",\n" : "", e.name);
            print_value("retreat_voxels", e.retreat, false);
            print_value("wobble_voxels", e.wobble, false);
            print_value("voxels_share", e.voxels, true);
            printf("}");
        } else {
            printf("%-38s %9.3f %9.3f %9.2f\n", e.name, e.retreat, e.wobble, 100 * e.voxels);
        }
    }
    if (r->json)
        printf("\n]}\n");
    return SC_OK;
}

sc_status print_locality(const sc_ctx *ctx, const ruling *r)
{
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    locality l;

    SC_PASS(sc_volume_read(ctx, r->path, &volume));
    SC_PASS(measure_locality(ctx, &volume, &r->how, r->halo, &l));
    if (r->json) {
        printf("{\"schema\": \"segcast-locality-1\", ");
        print_value("halo_voxels", r->halo, false);
        print_value("crops", l.crops, false);
        print_value("points", l.points, false);
        print_value("points_differing", l.points_off, false);
        print_value("rays", l.rays, false);
        print_value("rays_differing", l.rays_off, true);
        printf("}\n");
    } else {
        printf("%d crops, halo %d: %.0f of %.0f points and %.0f of %.0f rays differ\n", l.crops,
               r->halo, l.points_off, l.points, l.rays_off, l.rays);
    }
    return SC_OK;
}

sc_status print_cliffs(const sc_ctx *ctx, const ruling *r)
{
    if (r->json)
        printf("{\"schema\": \"segcast-cliffs-1\", \"cliffs\": [\n");
    else
        printf("%-12s %-10s %10s %10s %10s %12s\n", "shape", "changing", "largest", "at step",
               "median", "their ratio");
    for (size_t n = 0; n < cliff_count(); n++) {
        cliff c;
        const char *what;

        SC_PASS(measure_cliff(ctx, n, &r->how, &c));
        what = c.by_noise ? "noise" : "strength";
        if (r->json) {
            printf("%s  {\"shape\": \"%s\", \"changing\": \"%s\", ", n ? ",\n" : "", c.shape, what);
            print_value("steps", c.steps, false);
            print_value("largest_voxels", c.largest, false);
            print_value("largest_at_step", c.at, false);
            print_value("median_voxels", c.median, false);
            print_value("largest_over_median", c.median > 0 ? c.largest / c.median : NAN, true);
            printf("}");
        } else {
            printf("%-12s %-10s %10.4f %5d / %2d %10.4f %12.1f\n", c.shape, what, c.largest, c.at,
                   c.steps, c.median, c.largest / c.median);
        }
        fflush(stdout);
    }
    if (r->json)
        printf("\n]}\n");
    return SC_OK;
}
