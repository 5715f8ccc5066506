/* SPDX-License-Identifier: BSD-3-Clause */
/* Warnings of jobs that can run, but do not make what was probably meant. */
#include "app.h"

#include <math.h>
#include <string.h>

/* ---- a zoom that crops ---- */

/* Is a point removed by a clip plane? Only for scenes in which all planes cut all tissues. */
static bool is_clipped(const sc_scene *scene, sc_vec3 p)
{
    for (int i = 0; i < scene->plane_count; i++) {
        if (sc_vec3_dot(scene->planes[i].normal, p) + scene->planes[i].offset_mm < 0)
            return true;
    }
    return false;
}

/* @return how far the points that are not clipped reach, as a multiple of half the picture: above 1
 * some are outside of it. @param step look at every so many points only. */
static double reach_of(const sc_scene *scene, bool clips, double aspect, const sc_vec3 *points,
                       size_t count, size_t step)
{
    const sc_camera *camera = &scene->camera;
    double most = 0;

    for (size_t i = 0; i < count; i += step) {
        const sc_vec3 d = sc_vec3_sub(points[i], camera->position_mm);
        const double depth = sc_vec3_dot(d, camera->forward);
        const double scale =
            camera->half_height * (camera->projection == SC_PERSPECTIVE ? depth : 1);
        double reach;

        if (clips && is_clipped(scene, points[i]))
            continue;
        reach =
            fmax(fabs(sc_vec3_dot(d, camera->right)) / aspect, fabs(sc_vec3_dot(d, camera->up)));
        most = fmax(most, scale > 0 ? reach / scale : HUGE_VAL);
    }
    return most;
}

void sc_warn_of_zoom(const sc_app *app, const sc_session *session, double aspect,
                     const sc_vec3 *points, size_t count)
{
    enum { FRAMES = 24, POINTS = 20000 }; /* at how many to look; all frames and points are alike */
    const sc_timeline *t = &session->timeline;
    const int frames = t->animation.frames;
    const bool clips = t->animation.clip_mode == SC_CLIP_KEEP && t->clip_set_count == 1;
    double worst = 1.005, worst_zoom = 1; /* a reach of less is within the rim of a tissue */
    int at = -1;

    if (t->animation.move_count || t->animation.camera.fov_track.count)
        return; /* what is left of the picture then is meant to be seen */
    for (int i = 0; i < FRAMES && i < frames; i++) {
        const int k = frames <= FRAMES ? i : (int)((double)i * (frames - 1) / (FRAMES - 1));
        const sc_scene scene = sc_timeline_scene(t, k);
        const double zoom = t->half_height / scene.camera.half_height;
        double reach;

        if (zoom <= 1)
            continue;
        reach = reach_of(&scene, clips, aspect, points, count, count / POINTS + 1);
        if (reach > worst && reach / zoom <= 1.005) { /* without the zoom it would fit */
            worst = reach;
            worst_zoom = zoom;
            at = k;
        }
    }
    if (at >= 0)
        sc_warn(app->ctx,
                "the zoom of %.3g crops what is shown, for example in frame %d; up to %.3g all of "
                "it would be in the picture there",
                worst_zoom, at + (session->shot ? session->shot->span.first : 0),
                floor(100 * worst_zoom / worst) / 100);
}
