/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a clip plane lies: key frames move it along its normal; then the verbs turn turn it about
 * their lines, in the order in which they begin. */
#include "motion.h"

/* An axis and a normal are parallel if the sine between them is below this. */
#define PARALLEL 1e-6

/* @return the direction of the line of a turn where the job gives none: what is up in the picture,
 * or a direction across it for a plane which would only turn in itself about that. */
static sc_vec3 default_axis(const sc_timeline *t, sc_vec3 normal)
{
    const sc_orbit *camera = &t->animation.camera;
    const sc_vec3 up = sc_vec3_unit(camera->fixed ? camera->up : camera->axis);

    return sc_vec3_length(sc_vec3_cross(up, normal)) > PARALLEL ? up : sc_orbit_reference(up);
}

/* @return the plane, turned by a verb as far as it has come at a time. */
static sc_plane turn(const sc_timeline *t, const sc_verb *verb, double at, sc_plane plane)
{
    const double share = sc_progress(verb->begin, verb->end, verb->ease, at);
    const int index = verb->plane - 1;
    /* The axis must not change on the way: it follows from the plane as the job gives it. */
    const sc_vec3 axis =
        verb->line.has_axis ? verb->line.axis : default_axis(t, t->animation.sweeps[index].normal);
    const sc_vec3 middle = sc_vec3_scale(sc_vec3_add(t->low_mm, t->high_mm), 0.5);
    const sc_vec3 point = verb->line.has_point ? verb->line.point_mm : middle;
    const double side_mm = sc_vec3_dot(plane.normal, point) + plane.offset_mm;

    if (share <= 0)
        return plane;
    plane.normal = sc_vec3_rotate(plane.normal, axis, share * verb->angle_deg * M_PI / 180);
    /* The point of the line stays as far from the plane. */
    plane.offset_mm = side_mm - sc_vec3_dot(plane.normal, point);
    return plane;
}

sc_plane sc_plane_at(const sc_timeline *t, int plane, double at)
{
    const sc_sweep *sweep = &t->animation.sweeps[plane];
    /* Along its normal from the origin or, where its normal has key frames, from its pivot. */
    sc_plane out = {sweep->normal, -sc_number_at(&sweep->at_track, t->at_mm[plane], at)};

    if (sweep->normal_track.count) {
        out.normal = sc_track_direction(&sweep->normal_track, at);
        out.offset_mm -= sc_vec3_dot(out.normal, sweep->point_mm);
    }
    for (int i = 0; i < t->animation.move_count; i++) {
        const sc_verb *verb = &t->moves[i].verb;

        if (verb->kind == SC_VERB_TURN && verb->plane == plane + 1)
            out = turn(t, verb, at, out);
    }
    return out;
}
