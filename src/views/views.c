/* SPDX-License-Identifier: BSD-3-Clause */
/* Each panel is a picture of its own, drawn by the renderer into its quarter of the image; lines
 * and text are drawn over the slices afterwards. */
#include "segcast/views.h"

enum { TRANSVERSE, CORONAL, SAGITTAL, SLICES, SPACE = SLICES }; /* the panels */

/* From where a slice is seen: unit vectors in patient coordinates (RAS). */
static const struct view {
    const char *name;
    sc_vec3 forward, up, right;
    const char letters[4][2]; /* at the left, right, upper and lower edge */
    uint8_t rgb[3];           /* of its frame and title, and of its line in the other slices */
} slice_views[SLICES] = {
    {"transverse", {0, 0, 1}, {0, 1, 0}, {-1, 0, 0}, {"R", "L", "A", "P"}, {208, 64, 52}},
    {"coronal", {0, -1, 0}, {0, 0, 1}, {-1, 0, 0}, {"R", "L", "S", "I"}, {52, 150, 62}},
    {"sagittal", {1, 0, 0}, {0, 0, 1}, {0, -1, 0}, {"A", "P", "S", "I"}, {44, 104, 206}},
};

#define MARGIN 0.10 /* of the width and height of a panel, on each side of the box: for letters */

/* Panel number @p which (TRANSVERSE to SPACE) of a picture of the given size. The panels are
 * its quarters: above transverse and coronal, below sagittal and the picture in space. An odd
 * row goes to the lower ones, an odd column to the right ones. */
static sc_viewport panel(int width_px, int height_px, int which)
{
    const int half_width = width_px / 2, half_height = height_px / 2;

    return (sc_viewport){which & 1 ? half_width : 0, which & 2 ? half_height : 0,
                         which & 1 ? width_px - half_width : half_width,
                         which & 2 ? height_px - half_height : half_height};
}

sc_viewport sc_views_space(int width_px, int height_px)
{
    return panel(width_px, height_px, SPACE);
}

double sc_views_aspect(int width_px, int height_px)
{
    const sc_viewport space = sc_views_space(width_px, height_px);

    return (double)space.width_px / space.height_px;
}

/* Size of the box in mm along @p direction, a unit vector along x, y or z. */
static double extent(const sc_views *v, sc_vec3 direction)
{
    const sc_vec3 size = sc_vec3_sub(v->high_mm, v->low_mm);

    return fabs(direction.x) * size.x + fabs(direction.y) * size.y + fabs(direction.z) * size.z;
}

/* Millimetres per pixel of slice @p which, such that the box fills its panel but for a margin. */
static double scale_of(const sc_views *v, int which, sc_viewport p)
{
    const double room = 1 - 2 * MARGIN;

    return fmax(1e-6, fmax(extent(v, slice_views[which].right) / (room * p.width_px),
                           extent(v, slice_views[which].up) / (room * p.height_px)));
}

/* Middle of the box, in mm, which stands in the middle of each slice. */
static sc_vec3 middle_of(const sc_views *v)
{
    return sc_vec3_scale(sc_vec3_add(v->low_mm, v->high_mm), 0.5);
}

/* The scene of a slice of a scene: one clip plane through its point, seen along the normal.
 * @p half_height_mm: half of what the panel shows from top to bottom. */
static sc_scene slice_scene(const sc_views *v, const struct view *kind, double half_height_mm,
                            const sc_scene *of)
{
    const sc_vec3 middle = middle_of(v);
    const double reach = sc_vec3_length(sc_vec3_sub(v->high_mm, v->low_mm)) +
                         sc_vec3_length(sc_vec3_sub(of->point_mm, middle)) + 1;
    const sc_vec3 eye = sc_vec3_along(middle, -reach, kind->forward);
    sc_scene scene = {.clip = {.count = 1, .set_count = of->clip.set_count},
                      .slice = true,
                      .fades = of->fades,
                      .colors = of->colors,
                      .has_look = of->has_look,
                      .look = of->look};

    scene.camera = sc_camera_look(eye, middle, kind->up, SC_ORTHOGRAPHIC, half_height_mm);
    scene.clip.planes[0] = (sc_plane){kind->forward, -sc_vec3_dot(kind->forward, of->point_mm)};
    for (int g = 0; g < of->clip.set_count; g++)
        scene.clip.sets[g] = 1;
    return scene;
}

sc_scene sc_views_slice(const sc_views *views, int which, const int size_px[2],
                        const sc_scene *scene)
{
    const sc_viewport whole = {0, 0, size_px[0], size_px[1]};

    return slice_scene(views, &slice_views[which], scale_of(views, which, whole) * size_px[1] / 2,
                       scene);
}

/* What all functions draw_* need. Each draws one thing over panel @p p, a part of the picture. */
typedef struct drawing {
    const sc_views *v;
    sc_vec3 point_mm; /* in which the slices meet */
    sc_overlay *overlay;
    double mm_per_px, text_px; /* scale of the slice; font size */
    uint8_t text_rgb[3], halo_rgb[3];
} drawing;

/* Letters of @p size times the size of text, in colour @p rgb, or in that of text if it is NULL. */
static sc_letters letters_of(const drawing *d, double size, const uint8_t *rgb)
{
    sc_letters out = {.size_px = size * d->text_px};

    for (int i = 0; i < 3; i++) {
        out.rgb[i] = rgb ? rgb[i] : d->text_rgb[i];
        out.halo[i] = d->halo_rgb[i];
    }
    return out;
}

/* The four letters of the patient's sides, each in the middle of its edge. */
static void draw_letters(const drawing *d, const struct view *kind, sc_viewport p)
{
    const sc_letters letters = letters_of(d, 1.15, NULL);
    const double inset = 0.6 * d->text_px;
    const double left = p.x_px + inset, right = p.x_px + p.width_px - inset;
    const double top = p.y_px + inset, bottom = p.y_px + p.height_px - inset;
    const double x = (left + right) / 2, y = (top + bottom) / 2;

    sc_overlay_text(d->overlay, left, y, -1, 0, &letters, kind->letters[0]);
    sc_overlay_text(d->overlay, right, y, 1, 0, &letters, kind->letters[1]);
    sc_overlay_text(d->overlay, x, top, 0, -1, &letters, kind->letters[2]);
    sc_overlay_text(d->overlay, x, bottom, 0, 1, &letters, kind->letters[3]);
}

/* Lines in slice @p which where the other two slices cross it, each in the colour of its slice. */
static void draw_lines(const drawing *d, int which, sc_viewport p)
{
    const struct view *kind = &slice_views[which];
    const sc_vec3 off = sc_vec3_sub(d->point_mm, middle_of(d->v));
    const double x = p.x_px + p.width_px / 2.0 + sc_vec3_dot(off, kind->right) / d->mm_per_px;
    const double y = p.y_px + p.height_px / 2.0 - sc_vec3_dot(off, kind->up) / d->mm_per_px;
    const double line_px = fmax(1, d->text_px / 14);

    for (int other = 0; other < SLICES; other++) {
        const bool upright = fabs(sc_vec3_dot(slice_views[other].forward, kind->right)) > 0.5;

        if (other == which)
            continue;
        if (upright)
            sc_overlay_line(d->overlay, x, p.y_px, x, p.y_px + p.height_px, line_px,
                            slice_views[other].rgb, 0.8);
        else
            sc_overlay_line(d->overlay, p.x_px, y, p.x_px + p.width_px, y, line_px,
                            slice_views[other].rgb, 0.8);
    }
}

/* A scale bar of a round length, at most a fifth of the panel wide. */
static void draw_scale_bar(const drawing *d, sc_viewport p)
{
    const double length_mm = sc_round_length_mm(0.2 * p.width_px * d->mm_per_px);
    const double length_px = length_mm / d->mm_per_px, thick = fmax(2, d->text_px / 6);
    const double x = p.x_px + 0.9 * d->text_px, y = p.y_px + p.height_px - 0.9 * d->text_px;
    const sc_letters letters = letters_of(d, 0.8, NULL);
    const sc_length_unit unit = sc_length_unit_for(length_mm);
    char text[32];

    sc_overlay_line(d->overlay, x - 1, y, x + length_px + 1, y, thick + 2, d->halo_rgb, 0.85);
    sc_overlay_line(d->overlay, x, y, x + length_px, y, thick, d->text_rgb, 1);
    snprintf(text, sizeof text, "%g %s", length_mm / unit.mm, unit.name);
    sc_overlay_text(d->overlay, x + length_px / 2, y - thick - 0.2 * d->text_px, 0, 1, &letters,
                    text);
}

/* The unit of coordinates: a hundredth of what is shown is worth a digit before the point, so
 * that one behind it is enough. */
static sc_length_unit coordinate_unit(const sc_views *v)
{
    const sc_vec3 size = sc_vec3_sub(v->high_mm, v->low_mm);

    return sc_length_unit_for(fmax(size.x, fmax(size.y, size.z)) / 100);
}

/* The name and the coordinate of slice @p which. RAS coordinates grow towards the patient's
 * right, front (anterior) and head (superior); where it is unknown which side is left, "z = "
 * and the signed coordinate. */
static void draw_title(const drawing *d, int which, sc_viewport p)
{
    static const char *const ends[SLICES][2] = {{"I", "S"}, {"P", "A"}, {"L", "R"}};
    const sc_vec3 at = d->point_mm;
    const sc_letters letters = letters_of(d, 0.8, slice_views[which].rgb);
    const sc_length_unit unit = coordinate_unit(d->v);
    const double mm = which == TRANSVERSE ? at.z : which == CORONAL ? at.y : at.x;
    const double value = sc_no_negative_zero(mm / unit.mm, 1);
    char text[64];

    if (d->v->oriented)
        snprintf(text, sizeof text, "%s %.1f %s %s", slice_views[which].name, fabs(value),
                 unit.name, ends[which][mm >= 0]);
    else
        snprintf(text, sizeof text, "%c = %.1f %s", "zyx"[which], value, unit.name);
    sc_overlay_text(d->overlay, p.x_px + 0.6 * d->text_px, p.y_px + 0.6 * d->text_px, -1, -1,
                    &letters, text);
}

/* Draw all lines and text of slice @p which over its panel, and the frame around it. */
static void annotate(drawing *d, int which, sc_viewport p)
{
    const double line_px = fmax(1, d->text_px / 10);

    d->mm_per_px = scale_of(d->v, which, p);
    draw_lines(d, which, p);
    if (d->v->oriented)
        draw_letters(d, &slice_views[which], p);
    draw_scale_bar(d, p);
    draw_title(d, which, p);
    sc_overlay_frame(d->overlay, p.x_px + line_px / 2, p.y_px + line_px / 2, p.width_px - line_px,
                     p.height_px - line_px, line_px, slice_views[which].rgb);
}

sc_status sc_views_draw(const sc_ctx *ctx, sc_renderer *renderer, const sc_views *views,
                        const sc_scene *scene, const sc_rows *rows, sc_image *image,
                        sc_render_stats *stats)
{
    const int width_px = image->width_px, height_px = image->height_px;
    drawing d = {.v = views, .point_mm = scene->point_mm};
    const sc_viewport space = panel(width_px, height_px, SPACE);
    sc_render_stats sum = {0}, each;

    d.text_px = fmax(9, height_px / 42.0);
    sc_text_colors(scene->dark_text, d.text_rgb, d.halo_rgb);
    sc_render_view(renderer, scene, &space, NULL, rows, image, &sum);
    for (int i = 0; i < SLICES; i++) {
        const sc_viewport p = panel(width_px, height_px, i);
        const sc_scene slice =
            slice_scene(views, &slice_views[i], scale_of(views, i, p) * p.height_px / 2, scene);

        sc_render_view(renderer, &slice, &p, NULL, rows, image, &each);
        sc_render_stats_add(&sum, &each);
    }
    SC_PASS(sc_overlay_begin(ctx, image, &d.overlay));
    for (int i = 0; i < SLICES; i++)
        annotate(&d, i, panel(width_px, height_px, i));
    *stats = sum;
    return sc_overlay_finish(ctx, d.overlay);
}
