/* SPDX-License-Identifier: BSD-3-Clause */
/* The shots of a film: which of them a frame shows, and how two meet. */
#include "segcast/timeline.h"

int sc_shots_place(sc_shot_span *shots, int count)
{
    int end = 0;

    for (int i = 0; i < count; i++) {
        const bool overlaps = shots[i].transition == SC_TRANSITION_CROSS_FADE;

        shots[i].first = end - (overlaps ? shots[i].transition_frames : 0);
        end = shots[i].first + shots[i].frames;
    }
    return end;
}

/* @return how many frames at the beginning of a shot belong to the transition into it. */
static int frames_in(const sc_shot_span *shot)
{
    return shot->transition == SC_TRANSITION_CUT ? 0
           : shot->transition == SC_TRANSITION_FADE
               ? shot->transition_frames - shot->transition_frames / 2
               : shot->transition_frames;
}

/* @return in how many frames shot @p i fades out at its end. */
static int fade_out_frames(const sc_shot_span *shots, int count, int i)
{
    if (i + 1 == count || shots[i + 1].transition == SC_TRANSITION_CUT)
        return shots[i].fade_out_frames;
    return shots[i + 1].transition == SC_TRANSITION_FADE
               ? shots[i + 1].transition_frames - frames_in(&shots[i + 1])
               : 0;
}

int sc_shot_transitions(const sc_shot_span *shots, int count, int i)
{
    const bool is_covered = i + 1 < count && shots[i + 1].transition == SC_TRANSITION_CROSS_FADE;

    return frames_in(&shots[i]) +
           (is_covered ? shots[i + 1].transition_frames : fade_out_frames(shots, count, i));
}

/* @return the share of a transition of @p frames frames that has passed in the middle of its frame
 * @p k. The division is exact to the last bit on any machine. */
static float share_of(int k, int frames)
{
    return ((float)k + 0.5F) / (float)frames;
}

sc_film_frame sc_film_frame_at(const sc_shot_span *shots, int count, int k)
{
    sc_film_frame out = {.before = -1, .share = 1};
    int left, fading;

    while (out.shot + 1 < count && shots[out.shot + 1].first <= k)
        out.shot++;
    out.frame = k - shots[out.shot].first;
    left = shots[out.shot].frames - 1 - out.frame;
    fading = fade_out_frames(shots, count, out.shot);
    if (out.frame < frames_in(&shots[out.shot])) {
        out.share = share_of(out.frame, frames_in(&shots[out.shot]));
        if (shots[out.shot].transition == SC_TRANSITION_CROSS_FADE) {
            out.before = out.shot - 1;
            out.before_frame = k - shots[out.before].first;
        }
    } else if (left < fading) {
        out.share = share_of(left, fading);
    }
    return out;
}
