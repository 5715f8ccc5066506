/* SPDX-License-Identifier: BSD-3-Clause */
/* Scenes: room for what they say of tissues, and what differs between two of them. */
#include "segcast/scene.h"

#include <string.h>

sc_status sc_scene_room_init(const sc_ctx *ctx, int label_count, sc_scene_room *out)
{
    const size_t labels = (size_t)label_count;

    SC_PASS(sc_zalloc(ctx, labels,
                      sizeof *out->offsets_mm + sizeof *out->colors + sizeof *out->fades,
                      &out->offsets_mm));
    out->colors = (float(*)[3])(void *)(out->offsets_mm + labels);
    out->fades = (float *)(out->colors + labels);
    return SC_OK;
}

void sc_scene_room_clear(sc_scene_room *room)
{
    sc_free(room->offsets_mm);
    *room = (sc_scene_room){0};
}

/* @return whether two arrays differ, NULL being one of its own. */
static bool differ(const void *a, const void *b, size_t bytes)
{
    return a && b ? memcmp(a, b, bytes) != 0 : a != b;
}

static bool cameras_differ(const sc_scene *a, const sc_scene *b)
{
    const sc_camera *from = &a->camera, *to = &b->camera;

    /* all but the projection is numbers without a gap between them */
    return from->projection != to->projection || a->inside != b->inside ||
           differ(&from->position_mm, &to->position_mm,
                  sizeof *from - offsetof(sc_camera, position_mm));
}

static bool cuts_differ(const sc_scene *a, const sc_scene *b)
{
    return a->clip.which != b->clip.which || a->clip.mode != b->clip.mode || a->slice != b->slice ||
           differ(&a->divider, &b->divider, sizeof a->divider) ||
           differ(&a->point_mm, &b->point_mm, sizeof a->point_mm) ||
           differ(a->clip.planes, b->clip.planes, (size_t)a->clip.count * sizeof *a->clip.planes) ||
           differ(a->clip.sets, b->clip.sets, sizeof a->clip.sets);
}

/* light.method and light.lamp, which are the same in a film, are left out, with the gaps in them.
 */
unsigned sc_scene_changes(const sc_scene *a, const sc_scene *b, int label_count)
{
    const size_t labels = (size_t)label_count;
    const sc_look *from = &a->look, *to = &b->look;
    const bool light = differ(&from->light.ambient, &to->light.ambient,
                              sizeof from->light - offsetof(sc_lighting, ambient));
    const bool grey =
        differ(&from->grey_caps, &to->grey_caps, sizeof *from - offsetof(sc_look, grey_caps));
    const bool colors = differ(from->background, to->background, sizeof from->background) ||
                        differ(a->colors, b->colors, labels * sizeof *a->colors);

    return (cameras_differ(a, b) ? SC_CHANGED_CAMERA : 0u) |
           (cuts_differ(a, b) ? SC_CHANGED_CUTS : 0u) | (light ? SC_CHANGED_LIGHT : 0u) |
           (grey ? SC_CHANGED_GREY : 0u) | (colors ? SC_CHANGED_COLORS : 0u) |
           (differ(a->fades, b->fades, labels * sizeof *a->fades) ? SC_CHANGED_OPACITIES : 0u) |
           (differ(a->offsets_mm, b->offsets_mm, labels * sizeof *a->offsets_mm) ? SC_CHANGED_PLACES
                                                                                 : 0u);
}
