/* SPDX-License-Identifier: BSD-3-Clause */
/* The moments at which a frame with motion blur is drawn: how far what is visible moves in the
 * picture while the shutter is open. */
#include "motion.h"

/* How far beyond the edges of the picture, in halves of its height, points count. */
#define BEYOND 2.0
/* Depths below this share of the size of what is visible count as so large: of what is nearer,
 * little is seen, and it would move by any number of pixels. */
#define NEAR_SHARE 0.05

/* Where a point is seen, in pixels from the middle of the picture. @return false if that is behind
 * the camera, or far outside of the picture. */
static bool place_of(const sc_camera *c, sc_vec3 point_mm, double scale, double out[2])
{
    const sc_vec3 way = sc_vec3_sub(point_mm, c->position_mm);
    const double depth = sc_vec3_dot(way, c->forward);
    const double right = sc_vec3_dot(way, c->right), up = sc_vec3_dot(way, c->up);

    if (c->projection == SC_EQUIRECTANGULAR) {
        out[0] = scale * atan2(right, depth);
        out[1] = scale * asin(fmax(-1, fmin(1, up / fmax(sc_vec3_length(way), 1e-9))));
        return true;
    }
    if (c->projection == SC_PERSPECTIVE && depth <= 0)
        return false;
    out[0] = scale * right / (c->projection == SC_PERSPECTIVE ? depth : 1);
    out[1] = scale * up / (c->projection == SC_PERSPECTIVE ? depth : 1);
    return fabs(out[0]) < BEYOND * scale * c->half_height &&
           fabs(out[1]) < BEYOND * scale * c->half_height;
}

/* @return by how many pixels points that lie still move in the picture, with the camera. */
static double moved_by_camera(const sc_camera *from, const sc_camera *to, int height_px,
                              const sc_vec3 *points, size_t count)
{
    const double scales[2] = {height_px / (2 * from->half_height),
                              height_px / (2 * to->half_height)};
    double most = 0;

    for (size_t i = 0; i < count; i++) {
        double a[2], b[2], across;

        if (!place_of(from, points[i], scales[0], a) || !place_of(to, points[i], scales[1], b))
            continue;
        across = fabs(a[0] - b[0]);
        /* Past an edge of all directions it comes in at the other one. */
        if (from->projection == SC_EQUIRECTANGULAR)
            across = fmin(across, 2 * height_px - across);
        most = fmax(most, hypot(across, a[1] - b[1]));
    }
    return most;
}

/* @return by how many pixels the wall of a vessel moves in which the camera flies: what of it is as
 * far ahead as it is wide, when the camera goes there, and all of it when the camera turns. */
static double moved_by_flight(const sc_scene *from, const sc_scene *to, int height_px)
{
    const sc_camera *a = &from->camera, *b = &to->camera;
    const double way_mm = sc_vec3_length(sc_vec3_sub(b->position_mm, a->position_mm));
    const double turn = sc_vec3_length(sc_vec3_sub(b->forward, a->forward)) +
                        sc_vec3_length(sc_vec3_sub(b->up, a->up));
    const double around_mm = fmin(from->around_mm, to->around_mm);

    return height_px / (2 * a->half_height) *
           (turn + (around_mm > 0 ? way_mm / (2 * around_mm) : 0));
}

/* @return by how many millimetres a clip plane that cuts at one of two times moves, at most, within
 * the box around what is visible. */
static double moved_plane_mm(const sc_timeline *t, int plane, double from, double to)
{
    const sc_plane a = sc_plane_at(t, plane, from), b = sc_plane_at(t, plane, to);
    double most = 0;

    for (int i = 0; i < 8; i++) {
        const sc_vec3 corner = sc_box3_corner(&(sc_box3){t->low_mm, t->high_mm}, i);

        most = fmax(most, fabs(sc_vec3_dot(sc_vec3_sub(a.normal, b.normal), corner) + a.offset_mm -
                               b.offset_mm));
    }
    return most;
}

/* @return by how many millimetres planes and tissues move at most between two times. */
static double moved_mm(const sc_timeline *t, double from, double to)
{
    double most = 0, tissue = 0;
    int id = 0;

    for (int i = 0; i < t->animation.sweep_count; i++)
        most = fmax(most, moved_plane_mm(t, i, from, to));
    for (size_t i = 0; i < t->looks.shift_count; i++) { /* by rising id */
        const sc_change *s = &t->looks.shifts[i];

        tissue = (s->id == id ? tissue : 0) + fabs(sc_progress(s->begin, s->end, s->ease, to) -
                                                   sc_progress(s->begin, s->end, s->ease, from)) *
                                                  sc_vec3_length(s->to);
        id = s->id;
        most = fmax(most, tissue);
    }
    return most;
}

/* @return how many pixels a millimetre is where what is visible is nearest to the camera. */
static double most_px_per_mm(const sc_timeline *t, const sc_camera *c, int height_px,
                             const sc_vec3 *points, size_t count)
{
    const double scale = height_px / (2 * c->half_height);
    double depth = HUGE_VAL;

    for (size_t i = 0; i < count; i++)
        depth = fmin(depth, sc_vec3_dot(sc_vec3_sub(points[i], c->position_mm), c->forward));
    depth = fmax(depth, NEAR_SHARE * sc_vec3_length(sc_vec3_sub(t->high_mm, t->low_mm)));
    return c->projection == SC_ORTHOGRAPHIC ? scale : scale / fmax(depth, 1e-9);
}

double sc_timeline_moment(const sc_timeline *t, int k, int i, int moments)
{
    return k + t->animation.camera.optics.shutter * ((i + 0.5) / moments - 0.5);
}

int sc_timeline_moments(const sc_timeline *t, int k, const sc_vec3 *points, size_t count,
                        int height_px)
{
    const sc_optics *o = &t->animation.camera.optics;
    double ends[2], moved_px = 0, mm;
    sc_scene scenes[2];
    int moments = 1;

    if (!(o->shutter > 0) || !count)
        return 1;
    for (int i = 0; i < 2; i++) {
        ends[i] = k + o->shutter * (i - 0.5);
        scenes[i] = sc_timeline_scene(t, ends[i], NULL);
    }
    if (sc_scene_changes(&scenes[0], &scenes[1], 0) & SC_CHANGED_CAMERA)
        moved_px = moved_by_camera(&scenes[0].camera, &scenes[1].camera, height_px, points, count);
    if (scenes[0].inside != scenes[1].inside) /* a cut: two pictures would be mixed */
        return 1;
    if (scenes[0].inside)
        moved_px = fmax(moved_px, moved_by_flight(&scenes[0], &scenes[1], height_px));
    mm = moved_mm(t, sc_frame_time(ends[0], t->animation.frames),
                  sc_frame_time(ends[1], t->animation.frames));
    if (mm > 0)
        moved_px += mm * most_px_per_mm(t, &scenes[0].camera, height_px, points, count);
    if (!(o->aperture_mm > 0))
        return (int)fmax(1, fmin(ceil(moved_px), SC_MOMENTS_MAX));
    while (moments < moved_px && moments < SC_MOMENTS_MAX)
        moments *= 2;
    return moments;
}
