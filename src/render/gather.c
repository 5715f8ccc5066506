/* SPDX-License-Identifier: BSD-3-Clause */
/* Light that is gathered: its memory, and when it has to be gathered anew. */
#include "gather.h"

#include "directions.h"
#include "internal.h"

#include <string.h>

/* Compute the ray directions of all parts, to the sky and to the lamp as it stands in this view. */
static void make_directions(sc_gather *g)
{
    g->known.lamp = g->renderer->light.sky.lamp;
    for (uint32_t i = 0; i < SC_GATHER_PARTS * SC_GATHER_RAYS; i++) {
        const uint32_t part = i / SC_GATHER_RAYS, ray = i % SC_GATHER_RAYS;
        double point[2], direction[3];

        if (ray < SC_GATHER_DIRECTIONS) {
            sc_sobol_point(part * SC_GATHER_DIRECTIONS + ray, 1, point);
            sc_cosine_direction(point, direction);
        } else {
            sc_sobol_point(part * SC_GATHER_LAMP + ray - SC_GATHER_DIRECTIONS, 3, point);
            sc_lamp_point(&g->known.lamp, point, direction);
        }
        for (int k = 0; k < 3; k++)
            g->directions[part][ray][k] = (float)direction[k];
    }
}

/* Allocate what each rank has for itself, whatever changes. */
static sc_status allocate_own(const sc_ctx *ctx, sc_gather *g)
{
    const size_t labels = (size_t)g->renderer->volume->label_count;

    SC_PASS(SC_ALLOC(ctx, SC_GATHER_PARTS, &g->directions));
    SC_PASS(SC_ALLOC(ctx, SC_GATHER_RAYS * labels, &g->targets.absent));
    SC_PASS(SC_ALLOC(ctx, SC_GATHER_RAYS * labels, &g->targets.absent_before));
    SC_PASS(SC_ALLOC(ctx, labels, &g->targets.cuts));
    return SC_ZALLOC(ctx, labels, &g->known.tissues);
}

static inline bool shares_hits(const sc_gather *g)
{
    return g->change < SC_LIGHT_NEW_RAYS;
}

static inline bool shares_light(const sc_gather *g)
{
    return g->change < SC_LIGHT_NEW_SUMS;
}

/* Allocate an array at @p out: of the team, or of this rank alone. */
static sc_status allocate(const sc_ctx *ctx, const sc_gather *g, bool shared, size_t count,
                          size_t size, void *out)
{
    void *data = NULL;

    SC_PASS(shared ? sc_team_alloc(ctx, g->renderer->team, count, size, &data)
                   : sc_zalloc(ctx, count, size, &data));
    memcpy(out, &data, sizeof data);
    return SC_OK;
}

/* Allocate hits and light. @return SC_ERR_MEMORY. */
static sc_status allocate_light(const sc_ctx *ctx, sc_gather *g)
{
    const bool hits = shares_hits(g), light = shares_light(g);
    const size_t count = g->count + 1; /* there may be none */
    int framed[3];
    size_t bricks;

    sc_framed_size(g->renderer->volume->bricks, framed);
    bricks = sc_brick_count(framed);
    SC_PASS(allocate(ctx, g, hits, bricks, sizeof *g->targets.occupied, &g->targets.occupied));
    SC_PASS(allocate(ctx, g, hits, bricks + SC_GATHER_BYTES, 1, &g->targets.distances));
    for (int i = 0; i < SC_GATHER_RAYS; i++)
        SC_PASS(allocate(ctx, g, hits, count, sizeof *g->hits[i], &g->hits[i]));
    SC_PASS(allocate(ctx, g, light, count, sizeof *g->light.sky, &g->light.sky));
    SC_PASS(allocate(ctx, g, light, count, sizeof *g->light.all, &g->light.all));
    SC_PASS(allocate(ctx, g, light, count, sizeof *g->light.radiosity, &g->light.radiosity));
    SC_PASS(allocate(ctx, g, light, count, sizeof *g->light.gone, &g->light.gone));
    if (g->floor.first < g->count)
        SC_PASS(allocate(ctx, g, light, g->count - g->floor.first, sizeof *g->floor.light,
                         &g->floor.light));
    for (int k = 0; k < SC_GATHER_FIELDS; k++) {
        sc_gather_field *f = &g->fields[k];

        if (f->masks)
            SC_PASS(allocate(ctx, g, light, f->border->count + 1, sizeof *f->around, &f->around));
    }
    return SC_OK;
}

/* Set what rays are followed through, where nothing that is not shown is met. */
static void begin_march(sc_gather *g)
{
    const sc_renderer *r = g->renderer;
    const sc_prepared *v = r->volume;
    double voxel_mm = 0;
    int framed[3];

    sc_framed_size(v->bricks, framed);
    if (!shares_hits(g) || sc_team_is_first(r->team))
        memcpy(g->targets.distances, g->targets.far, sc_brick_count(framed));
    g->march = (sc_gather_march){.volume = v,
                                 .masks = g->targets.occupied,
                                 .distances = g->targets.distances,
                                 .row = sc_framed_row(v->bricks),
                                 .layer = sc_framed_layer(v->bricks)};
    for (int i = 0; i < 3; i++) {
        const sc_vec3 step = sc_affine_column(&v->to_ras_mm, i);

        g->march.step[i][0] = (float)step.x;
        g->march.step[i][1] = (float)step.y;
        g->march.step[i][2] = (float)step.z;
        voxel_mm += sc_vec3_length(step) / 3;
        g->march.box_low[i] = fmaxf(r->march.box_low[i], 0);
        g->march.box_high[i] = fminf(r->march.box_high[i] + 1, (float)(v->size[i] + 2));
    }
    for (int i = 0; i < 9; i++)
        g->march.step[i / 3][i % 3] /= (float)voxel_mm;
    g->follow = sc_gather_find(r->settings.cpu);
}

/* Free the gather at @p g. For SC_OWN. */
static void free_at(sc_gather **g)
{
    sc_gather_free(*g);
}

sc_status sc_gather_new(const sc_ctx *ctx, const sc_renderer *r, sc_light_change change,
                        sc_gather **out)
{
    SC_OWN(free_at) sc_gather *g = NULL;
    sc_status status = SC_ZALLOC(ctx, 1, &g);

    if (status == SC_OK) {
        g->renderer = r;
        g->change = change;
        g->together = true;
        status = allocate_own(ctx, g);
    }
    /* No rank begins what all do together before all have come as far. */
    SC_PASS(sc_team_agree(r->team, status));
    make_directions(g);
    g->fields[0].border = &r->volume->outer;
    g->fields[1].border = &r->volume->inner;
    SC_PASS(sc_gather_find_places(ctx, g));
    SC_PASS(sc_gather_find_parts(ctx, g));
    SC_PASS(sc_team_agree(r->team, allocate_light(ctx, g)));
    begin_march(g);
    SC_PASS(sc_team_agree(r->team, SC_OK)); /* no rank traces before the distances are there */
    g->together = false;
    SC_HAND_OVER(g, out);
    return SC_OK;
}

sc_status sc_gather_new_kept(const sc_ctx *ctx, const sc_renderer *r, sc_gather **out)
{
    SC_OWN(free_at) sc_gather *g = NULL;

    SC_PASS(sc_team_agree(r->team, SC_ZALLOC(ctx, 1, &g)));
    g->renderer = r;
    g->is_kept = true;
    g->fields[0].border = &r->volume->outer;
    g->fields[1].border = &r->volume->inner;
    for (int k = 0; k < (r->derived.shows_inner ? SC_GATHER_FIELDS : 1); k++)
        SC_PASS(allocate(ctx, g, true, g->fields[k].border->count + 1, sizeof *g->fields[k].around,
                         &g->fields[k].around));
    if (r->settings.floor)
        SC_PASS(allocate(ctx, g, true, SC_FLOOR_SIDE * SC_FLOOR_SIDE, sizeof *g->floor.light,
                         &g->floor.light));
    SC_HAND_OVER(g, out);
    return SC_OK;
}

/* @return whether what the planes of a scene keep is convex, the same for all tissues. */
static bool is_convex(const sc_scene *scene)
{
    for (int set = 1; set < scene->clip.set_count; set++) {
        if (scene->clip.sets[set] != scene->clip.sets[0])
            return false;
    }
    return scene->clip.mode == SC_CLIP_KEEP || scene->clip.count < 2;
}

static bool same_plane(const sc_plane *a, const sc_plane *b)
{
    return a->normal.x == b->normal.x && a->normal.y == b->normal.y && a->normal.z == b->normal.z &&
           a->offset_mm == b->offset_mm;
}

/* @return whether two scenes are cut by as many planes, and these cut the same tissues. */
static bool same_cuts(const sc_scene *a, const sc_scene *b)
{
    bool same = a->clip.count == b->clip.count && a->clip.mode == b->clip.mode &&
                a->clip.set_count == b->clip.set_count;

    for (int i = 0; same && i < a->clip.set_count; i++)
        same = a->clip.sets[i] == b->clip.sets[i];
    return same;
}

/* @return whether two scenes are cut in the same way. */
static bool same_planes(const sc_scene *a, const sc_scene *b)
{
    bool same = same_cuts(a, b);

    for (int i = 0; same && i < a->clip.count; i++)
        same = same_plane(&a->clip.planes[i], &b->clip.planes[i]);
    return same;
}

static bool same_color(const sc_march_tissue *a, const sc_march_tissue *b)
{
    return a->rgb[0] == b->rgb[0] && a->rgb[1] == b->rgb[1] && a->rgb[2] == b->rgb[2];
}

/* How much of the tissues of two scenes is compared: what is shown and cut; also how much light
 * they let through; also their colours. */
typedef enum tissue_share { SHOWN, OPACITIES, COLORS } tissue_share;

/* @return whether the tissues of the march are those of the last scene. */
static bool same_tissues(const sc_gather *g, tissue_share share)
{
    const sc_renderer *r = g->renderer;
    bool same = true;

    for (int id = 1; same && id < r->volume->label_count; id++) {
        const sc_march_tissue *a = &r->tissues[id], *b = &g->known.tissues[id];

        same = a->show == b->show && a->clip_set == b->clip_set &&
               (share < OPACITIES || a->boundary_alpha == b->boundary_alpha) &&
               (share < COLORS || same_color(a, b));
    }
    return same;
}

/* @return whether a lamp stands where it did; its shape is the same in a film. */
static bool same_lamp(const sc_lamp_frame *a, const sc_lamp_frame *b)
{
    bool same = true;

    for (int i = 0; i < 3; i++)
        same = same && a->middle[i] == b->middle[i] && a->right[i] == b->right[i];
    return same;
}

/* As sc_gather_scene. @param ctx as of sc_gather_trace. */
static void gather(const sc_ctx *ctx, sc_gather *g, sc_renderer *r, const sc_scene *scene)
{
    const sc_march_light *light = &r->march.light;
    const bool convex = is_convex(scene);
    const bool again = g->known.is_known && same_tissues(g, SHOWN) &&
                       convex == g->known.is_convex &&
                       (convex || same_planes(scene, &g->known.scene)) &&
                       (light->lamp > 0) == (g->known.lamp_strength > 0);
    const bool lamp_moves = !same_lamp(&g->known.lamp, &r->light.sky.lamp);
    const bool stays = again && same_tissues(g, OPACITIES), traced = stays && !lamp_moves;
    const bool summed = traced && same_tissues(g, COLORS) && same_planes(scene, &g->known.scene) &&
                        light->sky == g->known.sky_strength &&
                        light->lamp == g->known.lamp_strength;
    /* The floor may lie beyond the planes. */
    const bool lays_bare = stays && r->settings.floor && !same_planes(scene, &g->known.scene);

    for (int k = 0; k < SC_GATHER_FIELDS; k++)
        r->march.around[k] = g->fields[k].around;
    r->light.floor.light = (const float(*)[3])g->floor.light;
    if (summed || g->is_kept)
        return;
    /* What is shared is never written by one rank: moments between frames, which alone may differ
     * where frames do not, have the light of the frames. */
    if (!g->together && (traced && !lays_bare ? shares_light(g) : shares_hits(g)))
        return;
    g->known.is_convex = convex;
    g->known.sky_strength = light->sky;
    g->known.lamp_strength = light->lamp;
    g->known.is_known = false;
    g->known.lamp_moves = lamp_moves;
    if (lamp_moves)
        make_directions(g);
    if (!traced || lays_bare)
        sc_gather_trace(ctx, g, scene, again && !lays_bare, traced ? g->floor.first : 0);
    if (sc_gather_ends(g))
        return;
    g->together = g->together && shares_light(g);
    sc_gather_sum(g);
    memcpy(g->known.tissues, r->tissues, (size_t)r->volume->label_count * sizeof *r->tissues);
    g->known.scene = *scene;
    g->known.is_known = true;
}

void sc_gather_scene(sc_gather *g, sc_renderer *r, const sc_scene *scene)
{
    gather(NULL, g, r, scene);
}

void sc_gather_first(const sc_ctx *ctx, sc_gather *g, sc_renderer *r, const sc_scene *scene)
{
    if (!shares_hits(g))
        return;
    g->together = true;
    gather(ctx, g, r, scene);
    g->together = false;
}

sc_light_change sc_light_between(const sc_scene *a, const sc_scene *b, int label_count, bool floor)
{
    const unsigned changes = sc_scene_changes(a, b, label_count);
    const bool light = (changes & SC_CHANGED_LIGHT) != 0;
    const bool cuts = changes & SC_CHANGED_CUTS && !same_planes(a, b);

    if (changes & SC_CHANGED_OPACITIES ||
        (changes & SC_CHANGED_CAMERA && a->look.light.lamp.follows) ||
        (cuts && !(!floor && is_convex(a) && is_convex(b))) ||
        (light && (a->look.light.key > 0) != (b->look.light.key > 0)))
        return SC_LIGHT_NEW_RAYS;
    return cuts || light || changes & SC_CHANGED_COLORS ? SC_LIGHT_NEW_SUMS : SC_LIGHT_STAYS;
}

/* Free hits and light, unless they are the team's. */
static void free_light(sc_gather *g)
{
    if (!shares_hits(g)) {
        sc_free(g->targets.occupied);
        sc_free(g->targets.distances);
        for (int i = 0; i < SC_GATHER_RAYS; i++)
            sc_free(g->hits[i]);
    }
    for (int k = 0; k < SC_GATHER_FIELDS && g->is_kept; k++)
        sc_team_free(g->renderer->team, g->fields[k].around);
    if (g->is_kept)
        sc_team_free(g->renderer->team, g->floor.light);
    if (shares_light(g))
        return;
    sc_free(g->light.sky);
    sc_free(g->light.all);
    sc_free(g->light.radiosity);
    sc_free(g->light.gone);
    sc_free(g->floor.light);
    for (int k = 0; k < SC_GATHER_FIELDS; k++)
        sc_free(g->fields[k].around);
}

void sc_gather_free(sc_gather *g)
{
    if (!g)
        return;
    free_light(g);
    sc_free(g->directions);
    sc_free(g->targets.absent);
    sc_free(g->targets.absent_before);
    sc_free(g->targets.cuts);
    sc_free(g->known.tissues);
    sc_free(g);
}

uint64_t sc_gather_bytes(const sc_gather *g)
{
    uint64_t bytes = 0;

    if (!g)
        return 0;
    if (!shares_hits(g))
        bytes += g->count * SC_GATHER_RAYS * sizeof *g->hits[0];
    if (shares_light(g))
        return bytes;
    for (int k = 0; k < SC_GATHER_FIELDS; k++)
        bytes += g->fields[k].masks ? g->fields[k].border->count * sizeof(uint32_t) : 0;
    return bytes + g->count * (3 * sizeof *g->light.sky + sizeof *g->light.gone);
}
