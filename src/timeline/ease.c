/* SPDX-License-Identifier: BSD-3-Clause */
/* How values change with time: easing, parts of the animation, and key frames. */
#include "segcast/image.h"
#include "segcast/timeline.h"

/* @return a cubic Bezier curve from 0 to 1 at @p s. @param p, q the inner control values. */
static double bezier_at(double p, double q, double s)
{
    const double r = 1 - s;

    return s * (3 * r * (r * p + s * q) + s * s);
}

/* @return y of the curve where its x is @p u. x rises with s, so that halving finds s to the last
 * bits; a search by slopes would fail where the curve stands upright. */
static double bezier_value(const double b[4], double u)
{
    enum { STEPS = 60 };
    double low = 0, high = 1;

    if (u <= 0 || u >= 1)
        return u <= 0 ? 0 : 1;
    for (int i = 0; i < STEPS; i++) {
        const double s = 0.5 * (low + high);

        if (bezier_at(b[0], b[2], s) < u)
            low = s;
        else
            high = s;
    }
    return bezier_at(b[1], b[3], 0.5 * (low + high));
}

double sc_ease_value(sc_ease ease, double u)
{
    switch (ease.kind) {
    case SC_EASE_SMOOTH:
        return u * u * (3 - 2 * u);
    case SC_EASE_IN:
        return u * u;
    case SC_EASE_OUT:
        return u * (2 - u);
    case SC_EASE_BEZIER:
        return bezier_value(ease.bezier, u);
    case SC_EASE_LINEAR:
        break;
    }
    return u;
}

double sc_frame_time(double k, int frames)
{
    return frames > 1 ? k / (frames - 1) : 0;
}

double sc_progress(double begin, double end, sc_ease ease, double at)
{
    const double u = end > begin ? (at - begin) / (end - begin) : at >= begin;

    return sc_ease_value(ease, u < 0 ? 0 : u > 1 ? 1 : u);
}

/* Find between which key frames a time lies. @param share set to how far it is on the way between
 * them. @return the index of the second of them; 0 before the first, and the count from the last
 * one on. */
static int next_key(const sc_track *track, double at, double *share)
{
    const sc_key_frame *keys = track->keys;
    int next = 0;

    *share = 0;
    while (next < track->count && keys[next].at <= at)
        next++;
    if (next > 0 && next < track->count)
        *share = sc_ease_value(keys[next].ease,
                               (at - keys[next - 1].at) / (keys[next].at - keys[next - 1].at));
    return next;
}

sc_vec3 sc_track_step(const sc_track *track, double at)
{
    int last = 0;

    while (last + 1 < track->count && track->keys[last + 1].at <= at)
        last++;
    return track->keys[last].value;
}

sc_vec3 sc_track_value(const sc_track *track, double at)
{
    const sc_key_frame *keys = track->keys;
    double share;
    const int next = next_key(track, at, &share);

    if (next == 0 || next == track->count)
        return keys[next ? next - 1 : 0].value;
    return sc_vec3_along(keys[next - 1].value, share,
                         sc_vec3_sub(keys[next].value, keys[next - 1].value));
}

sc_vec3 sc_track_direction(const sc_track *track, double at)
{
    const sc_key_frame *keys = track->keys;
    double share, sine;
    const int next = next_key(track, at, &share);
    sc_vec3 from, to, across;

    if (next == 0 || next == track->count)
        return keys[next ? next - 1 : 0].value;
    from = keys[next - 1].value;
    to = keys[next].value;
    across = sc_vec3_cross(from, to);
    sine = sc_vec3_length(across);
    if (!(sine > 0)) /* they are the same */
        return from;
    return sc_vec3_rotate(from, sc_vec3_scale(across, 1 / sine),
                          share * atan2(sine, sc_vec3_dot(from, to)));
}

sc_vec3 sc_value_at(const sc_track *track, sc_vec3 constant, double at)
{
    return track->count ? sc_track_value(track, at) : constant;
}

double sc_number_at(const sc_track *track, double constant, double at)
{
    return sc_value_at(track, (sc_vec3){constant, 0, 0}, at).x;
}

double sc_track_most(const sc_track *track, double constant)
{
    double most = track->count ? 0 : constant;

    for (int i = 0; i < track->count; i++)
        most = fmax(most, track->keys[i].value.x);
    return most;
}

sc_lighting sc_light_at(const sc_lighting *light, const sc_light_tracks *tracks, double at)
{
    sc_lighting out = *light;

    out.ambient = sc_number_at(&tracks->ambient, light->ambient, at);
    out.key = sc_number_at(&tracks->key, light->key, at);
    out.head = sc_number_at(&tracks->head, light->head, at);
    out.occlusion = sc_number_at(&tracks->occlusion, light->occlusion, at);
    out.shadows = sc_number_at(&tracks->shadows, light->shadows, at);
    out.edges = sc_number_at(&tracks->edges, light->edges, at);
    out.depth_cue = sc_number_at(&tracks->depth_cue, light->depth_cue, at);
    return out;
}

sc_lighting sc_light_of_all(const sc_lighting *light, const sc_light_tracks *tracks)
{
    sc_lighting out = *light;

    out.occlusion = sc_track_most(&tracks->occlusion, light->occlusion);
    out.shadows = sc_track_most(&tracks->shadows, light->shadows);
    return out;
}

/* @return the tone of a level of sRGB, 0 to 255. */
static double tone_of(double level)
{
    return sqrt(sc_srgb_to_linear(level / 255));
}

void sc_track_tones(const sc_track *levels, sc_track *tones)
{
    *tones = *levels;
    for (int i = 0; i < levels->count; i++) {
        const sc_vec3 *value = &levels->keys[i].value;

        tones->keys[i].value = (sc_vec3){tone_of(value->x), tone_of(value->y), tone_of(value->z)};
    }
}

void sc_track_color(const sc_track *tones, double at, float linear[3])
{
    const sc_vec3 tone = sc_track_value(tones, at);

    linear[0] = (float)(tone.x * tone.x);
    linear[1] = (float)(tone.y * tone.y);
    linear[2] = (float)(tone.z * tone.z);
}
