/* SPDX-License-Identifier: BSD-3-Clause */
/* Which point of its tissue each name stands for in each frame, and on which side. These follow
 * one another with hysteresis, so that a name does not go back and forth; they are found for the
 * whole film before its first frame, so that each frame still follows from its number alone. */
#include "internal.h"

#include <math.h>

#define ENTER 0.10 /* share of light at which a point can be named, and ... */
#define LEAVE 0.05 /* ... at which it is no longer; */
#define SHINE                                                                                      \
    3.0 /* both also as shares of that of the brightest point of the tissue, times this            \
         */
#define STAY                                                                                       \
    0.03                  /* share of the width by which a point crosses the middle before its     \
                             name changes sides */
#define STRIP 3.0         /* width in font sizes in which leader lines turn to their names */
#define MOST 0.45         /* share of the width that a column may take from its edge inwards */
#define SHOWN (255 * 0.3) /* how much is shown of a tissue whose name is fully shown */

/* What the threads fill. */
typedef struct survey {
    const sc_name_film *film;
    sc_scene_room *rooms; /* [threads] */
    uint8_t *lights;      /* [frames][count][SC_ANCHORS_MAX] */
} survey;

/* @return where an anchor lies, in mm. */
static sc_vec3 anchor_mm(const sc_name_film *film, int name, int anchor)
{
    const int *voxel = film->anchors[name].voxel[anchor];

    return sc_affine_point(&film->a->volume->to_ras_mm, (sc_vec3){voxel[0], voxel[1], voxel[2]});
}

/* @return how far a tissue is moved. */
static sc_vec3 moved_mm(const sc_scene *scene, int id)
{
    return scene->offsets_mm ? scene->offsets_mm[id] : (sc_vec3){0, 0, 0};
}

/* As project(), in a picture of all directions. @param at from the camera. */
static double project_around(const sc_viewport *within, const sc_camera *camera, sc_vec3 at,
                             double out[2])
{
    const double px_per_rad = within->height_px / M_PI, length_mm = sc_vec3_length(at);
    const double right = sc_vec3_dot(at, camera->right), ahead = sc_vec3_dot(at, camera->forward);

    if (length_mm <= 0)
        return 0;
    out[0] = within->x_px + within->width_px / 2.0 + px_per_rad * atan2(right, ahead);
    out[1] = within->y_px + within->height_px / 2.0 -
             px_per_rad * asin(fmax(-1, fmin(1, sc_vec3_dot(at, camera->up) / length_mm)));
    return px_per_rad / length_mm;
}

/* Find where a point lies in the picture. @return pixels for a mm at its depth; 0 if it does not
 * lie before the camera. */
static double project(const sc_viewport *within, const sc_camera *camera, sc_vec3 point_mm,
                      double out[2])
{
    const sc_vec3 at = sc_vec3_sub(point_mm, camera->position_mm);
    const double depth_mm = sc_vec3_dot(at, camera->forward);
    const double half_mm =
        camera->projection == SC_PERSPECTIVE ? camera->half_height * depth_mm : camera->half_height;
    const double scale = within->height_px / 2.0 / half_mm;

    if (camera->projection == SC_EQUIRECTANGULAR)
        return project_around(within, camera, at, out);
    if (depth_mm <= 0)
        return 0;
    out[0] = within->x_px + within->width_px / 2.0 + scale * sc_vec3_dot(at, camera->right);
    out[1] = within->y_px + within->height_px / 2.0 - scale * sc_vec3_dot(at, camera->up);
    return scale;
}

/* @return the columns of a frame: left and right of the sphere around what is shown, as far as that
 * lies in the picture. */
static sc_columns columns_of(const sc_name_film *film, const sc_camera *camera)
{
    const sc_annotations *a = film->a;
    const sc_viewport *within = &a->within;
    const sc_vec3 low = a->timeline->low_mm, high = a->timeline->high_mm;
    const double radius_mm = sc_vec3_length(sc_vec3_sub(high, low)) / 2;
    const double strip_px = STRIP * sc_names_px(a);
    const double outer_px = sc_margin_px(a) + film->widest_px;
    const double right_px = within->x_px + within->width_px;
    const double most_px = MOST * within->width_px;
    double at[2] = {within->x_px + within->width_px / 2.0, 0};
    const double scale = project(within, camera, sc_vec3_scale(sc_vec3_add(low, high), 0.5), at);
    const double reach_px = scale > 0 ? radius_mm * scale + strip_px : within->width_px;
    sc_columns out;

    out.edge_px[0] = fmin(fmax(at[0] - reach_px, within->x_px + outer_px), within->x_px + most_px);
    out.edge_px[1] = fmax(fmin(at[0] + reach_px, right_px - outer_px), right_px - most_px);
    out.elbow_px[0] = out.edge_px[0] + strip_px;
    out.elbow_px[1] = out.edge_px[1] - strip_px;
    out.middle_px = fmin(fmax(at[0], out.elbow_px[0]), out.elbow_px[1]);
    return out;
}

/* @return whether a point is shown on its side of the divider, with its dot. The line and the name,
 * which lead away from the divider, are then shown, too. */
static bool is_beside_divider(const sc_name_film *film, const sc_scene *scene, double x_px)
{
    const sc_annotations *a = film->a;
    const double margin_px = film->row_px / 2;
    const int divider_px = sc_divider_px(scene->divider, a->divided_px);

    if (!a->divided_px)
        return true;
    return a->is_behind_divider ? x_px > divider_px + margin_px : x_px < divider_px - margin_px;
}

/* Does a rectangle that overlays take, with @p margin_px around it, reach into columns @p x0 to @p
 * x1 and rows @p y0 to @p y1? In any order. */
static bool reaches_into(const sc_viewport *taken, double margin_px, double x0, double x1,
                         double y0, double y1)
{
    return fmax(x0, x1) > taken->x_px - margin_px &&
           fmin(x0, x1) < taken->x_px + taken->width_px + margin_px &&
           fmax(y0, y1) > taken->y_px - margin_px &&
           fmin(y0, y1) < taken->y_px + taken->height_px + margin_px;
}

/* @return whether the leader line from the point @p at in frame @p k to a name on one side keeps
 * away from other overlays by @p margin_px: on its level part, and where it turns to a name that
 * stands beside none of them. */
static bool is_line_clear(const sc_name_film *film, int k, int side, const double at[2],
                          double margin_px)
{
    const sc_columns *columns = &film->columns[k];
    const double elbow_px = columns->elbow_px[side], edge_px = columns->edge_px[side];
    const double name_px = fmax(film->low_px[side], fmin(film->high_px[side], at[1]));

    for (int i = 0; i < film->taken_count; i++) {
        if (reaches_into(&film->taken[i], margin_px, at[0], elbow_px, at[1], at[1]) ||
            (name_px != at[1] &&
             reaches_into(&film->taken[i], margin_px, elbow_px, edge_px, at[1], name_px)))
            return false;
    }
    return true;
}

/* @return whether the point @p at, in pixels, lies in the part of the picture of a frame that is
 * between the two columns of names. */
static bool is_between(const sc_name_film *film, const sc_scene *scene, const double at[2])
{
    const sc_viewport *within = &film->a->within;
    const sc_columns *columns = &film->columns[scene->frame];
    const double margin_px = film->row_px / 2;

    if (!is_beside_divider(film, scene, at[0]))
        return false;
    return at[0] > columns->elbow_px[0] && at[0] < columns->elbow_px[1] &&
           at[1] > within->y_px + margin_px && at[1] < within->y_px + within->height_px - margin_px;
}

/* @return whether an anchor can be named, or if it is already, can stay. */
static bool is_bright(const uint8_t *lights, int anchor, double least)
{
    double brightest = 0;

    for (int i = 0; i < SC_ANCHORS_MAX; i++)
        brightest = fmax(brightest, lights[i]);
    return lights[anchor] >= least * fmax(255, SHINE * brightest);
}

/* Let points of a tissue from which no line can lead to a name without crossing other overlays go
 * dark, if another one can be named. @param lights of all points, updated. @param is_clear by
 * point. */
static void prefer_clear(const bool is_clear[SC_ANCHORS_MAX], uint8_t lights[SC_ANCHORS_MAX])
{
    bool any = false;

    for (int i = 0; i < SC_ANCHORS_MAX; i++)
        any = any || (is_clear[i] && is_bright(lights, i, ENTER));
    for (int i = 0; i < SC_ANCHORS_MAX && any; i++)
        lights[i] = is_clear[i] ? lights[i] : 0;
}

/* Find how much light of each anchor of name @p n reaches the camera in a frame, 0 where it lies
 * outside of the picture, to @p lights [SC_ANCHORS_MAX], zeroed by the caller. */
static void survey_name(const sc_name_film *film, int n, const sc_scene *scene, uint8_t *lights)
{
    const sc_annotations *a = film->a;
    const int id = film->words[n]->number;
    bool is_clear[SC_ANCHORS_MAX] = {false};

    for (int i = 0; i < film->anchors[n].count; i++) {
        const sc_vec3 point_mm = anchor_mm(film, n, i);
        const sc_vec3 at_mm = sc_vec3_add(point_mm, moved_mm(scene, id));
        double dot_px[2] = {0, 0};

        if (project(&a->within, &scene->camera, at_mm, dot_px) <= 0 ||
            !is_between(film, scene, dot_px))
            continue;
        lights[i] = (uint8_t)(255 * sc_light_of(a, &film->from_ras_mm, scene, id, point_mm) + 0.5);
        is_clear[i] = is_line_clear(film, scene->frame, 0, dot_px, 0) ||
                      is_line_clear(film, scene->frame, 1, dot_px, 0);
    }
    prefer_clear(is_clear, lights);
}

/* Can names stand in a frame? Not in a flight: within a vessel nothing lies beside what is shown.
 */
static bool has_names(const sc_name_film *film, const sc_scene *scene)
{
    const int *nameless = film->a->nameless;

    return !scene->inside && scene->frame >= nameless[0] &&
           scene->frame < film->frames - nameless[1];
}

/* Find the columns of some frames, and what survey_name() finds for all names. sc_range_fn. */
static void survey_frames(void *user, size_t begin, size_t end, int thread)
{
    const survey *s = user;
    const sc_name_film *film = s->film;
    const sc_annotations *a = film->a;

    for (size_t k = begin; k < end; k++) {
        const sc_scene scene = sc_timeline_scene(a->timeline, (int)k, &s->rooms[thread]);

        film->columns[k] = columns_of(film, &scene.camera);
        for (int n = 0; n < film->count && has_names(film, &scene); n++) {
            const size_t at = k * (size_t)film->count + (size_t)n;
            const int id = film->words[n]->number;

            film->states[at].shown = (uint8_t)sc_shown_alpha(a, &scene, id);
            if (film->states[at].shown)
                survey_name(film, n, &scene, s->lights + at * SC_ANCHORS_MAX);
        }
    }
}

/* @return the anchor of a name in frame @p k: that of the frame before, @p last, as long as it can
 * be seen well enough, or else that which can be for the longest time from now on; -1 for none.
 * @param lights as of survey.lights, of that name in its first frame. */
static int choose_anchor(const sc_name_film *film, const uint8_t *lights, int k, int last)
{
    const size_t stride = (size_t)film->count * SC_ANCHORS_MAX;
    const uint8_t *now = lights + (size_t)k * stride;
    int longest = 0, out = -1;

    if (last >= 0 && is_bright(now, last, LEAVE))
        return last;
    for (int i = 0; i < SC_ANCHORS_MAX; i++) {
        int j = k + 1;

        if (!is_bright(now, i, ENTER))
            continue;
        while (j < film->frames && is_bright(lights + (size_t)j * stride, i, LEAVE))
            j++;
        if (j - k > longest) {
            longest = j - k;
            out = i;
        }
    }
    return out;
}

/* @return whether the name of the point @p at can stand on a side in frame @p k: there the line
 * keeps away from other overlays, further if it does not stand there already. @param last as of
 * find_state. */
static bool can_stand(const sc_name_film *film, int k, int side, const double at[2],
                      const sc_name_state *last)
{
    const bool stays = last && last->anchor >= 0 && last->right == side;

    return is_line_clear(film, k, side, at, stays ? 0 : film->row_px / 2);
}

/* Find the state of a name in a frame. @param last that of the frame before; NULL: there is none.
 */
static void find_state(const sc_name_film *film, int k, int n, const sc_scene *scene,
                       const uint8_t *lights, const sc_name_state *last, sc_name_state *out)
{
    const sc_columns *columns = &film->columns[k];
    const double stay_px = STAY * film->a->within.width_px;
    const bool has_room[2] = {film->high_px[0] - film->low_px[0] >= film->row_px,
                              film->high_px[1] - film->low_px[1] >= film->row_px};
    double dot_px[2], right_px;
    sc_vec3 at_mm;

    out->anchor = (int8_t)choose_anchor(film, lights, k, last ? last->anchor : -1);
    if (out->anchor < 0)
        return;
    at_mm = sc_vec3_add(anchor_mm(film, n, out->anchor), moved_mm(scene, film->words[n]->number));
    (void)project(&film->a->within, &scene->camera, at_mm, dot_px);
    out->dot_px[0] = (float)dot_px[0];
    out->dot_px[1] = (float)dot_px[1];
    right_px = dot_px[0] - columns->middle_px;
    if (last && last->anchor == out->anchor)
        right_px += last->right ? stay_px : -stay_px;
    out->right = has_room[1] && (right_px >= 0 || !has_room[0]);
    if (has_room[!out->right] && !can_stand(film, k, out->right, dot_px, last) &&
        can_stand(film, k, !out->right, dot_px, last))
        out->right = !out->right;
    if (film->a->divided_px)
        out->right = film->a->is_behind_divider;
}

/* @return whether name @p n stands before @p other where both are on one side. */
static bool is_above(const sc_name_film *film, int k, int n, int other)
{
    const sc_name_state *states = &film->states[k * film->count];
    const float y = states[n].dot_px[1], other_y = states[other].dot_px[1];

    return y < other_y || (y <= other_y && n < other);
}

/* @return whether a name changes its point, its side, or its order among more important names,
 * between frames @p k - 1 and @p k. */
static bool changes(const sc_name_film *film, int k, int n)
{
    const sc_name_state *now = &film->states[k * film->count];
    const sc_name_state *then = now - film->count;

    if (now[n].anchor != then[n].anchor || now[n].right != then[n].right)
        return true;
    for (int other = 0; other < n && now[n].anchor >= 0; other++) {
        if (now[other].anchor >= 0 && then[other].anchor >= 0 && now[other].right == now[n].right &&
            then[other].right == now[n].right &&
            is_above(film, k, n, other) != is_above(film, k - 1, n, other))
            return true;
    }
    return false;
}

/* Find which names change in some frames. sc_range_fn. */
static void find_changes(void *user, size_t begin, size_t end, int thread)
{
    const survey *s = user;
    const sc_name_film *film = s->film;

    for (size_t k = begin > 0 ? begin : 1; k < end; k++) {
        for (int n = 0; n < film->count; n++)
            film->states[k * (size_t)film->count + (size_t)n].changes = changes(film, (int)k, n);
    }
}

sc_status sc_find_name_states(const sc_ctx *ctx, int threads, sc_name_film *film)
{
    const size_t states = (size_t)film->frames * (size_t)film->count;
    survey s = {.film = film};
    void *rooms = NULL, *lights = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, (size_t)threads, sizeof *s.rooms, &rooms));
    s.rooms = rooms;
    for (int i = 0; i < threads; i++)
        SC_TRY(sc_scene_room_init(ctx, film->a->volume->label_count, &s.rooms[i]));
    SC_TRY(sc_zalloc(ctx, states, SC_ANCHORS_MAX, &lights));
    s.lights = lights;
    sc_parallel_for(threads, (size_t)film->frames, 1, survey_frames, &s);
    for (int k = 0; k < film->frames; k++) {
        const sc_scene scene = sc_timeline_scene(film->a->timeline, k, s.rooms);

        for (int n = 0; n < film->count; n++) {
            sc_name_state *state = &film->states[k * film->count + n];

            find_state(film, k, n, &scene, s.lights + (size_t)n * SC_ANCHORS_MAX,
                       k ? state - film->count : NULL, state);
        }
    }
    sc_parallel_for(threads, (size_t)film->frames, 16, find_changes, &s);
out:
    for (int i = 0; rooms && i < threads; i++)
        sc_scene_room_clear(&s.rooms[i]);
    sc_free(rooms);
    sc_free(lights);
    return status;
}

/* @return whether a name changes between frames @p k - 1 and @p k, if there are both. */
static bool has_change(const sc_name_film *film, int k, int n)
{
    return k > 0 && k < film->frames && film->states[k * film->count + n].changes;
}

void sc_name_fades(const sc_name_film *film, int k, int fade_frames, double *out)
{
    for (int n = 0; n < film->count; n++) {
        const sc_name_state *state = &film->states[k * film->count + n];
        int distance = 0;

        out[n] = 0;
        if (state->anchor < 0)
            continue;
        while (distance < fade_frames && !has_change(film, k - distance, n) &&
               !has_change(film, k + distance + 1, n))
            distance++;
        out[n] = fmin((double)distance / fade_frames, fmin(1, state->shown / SHOWN));
    }
}
