/* SPDX-License-Identifier: BSD-3-Clause */
/* The looks of tissues, from the label table and the rules of the job. */
#include "segcast/image.h"
#include "segcast/scene.h"

#include <limits.h>
#include <string.h>

/* The ends of the scale in bodies of 100 mm and more: at these thicknesses, in mm, and opacities. A
 * skin of 1 mm, or a tube of 2 mm, is thin; a tube of 30 mm, as wide as the largest vessels, is as
 * thick as tissues get to be told apart. */
#define THIN_MM 1.0
#define THICK_MM 15.0
#define LEAST 0.5
#define MOST 0.95
#define HUMAN_MM 100.0
/* Opacities of the outermost cover, and of those between it and what they enclose. */
#define OUTER_COVER 0.16
#define INNER_COVER 0.06

double sc_auto_opacity(const sc_opacity_scale *scale, double thickness_mm)
{
    const double range = log(scale->thick_mm / scale->thin_mm);
    double share;

    if (!(thickness_mm > 0) || !(range > 0))
        return scale->most;
    share = log(thickness_mm / scale->thin_mm) / range;
    return scale->least + (scale->most - scale->least) * fmin(fmax(share, 0), 1);
}

sc_opacity_scale sc_local_opacity_scale(sc_opacity_scale scale)
{
    if (scale.thick_mm > scale.thin_mm)
        scale.thick_mm *= 2;
    return scale;
}

/* Convert a colour from sRGB levels to linear light, 0 to 1. */
static void color_of(const uint8_t rgb[3], float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = (float)sc_srgb_to_linear(rgb[i] / 255.0);
}

/* @return the look that the label table gives a label, with clip_set 0. A table that names no
 * opacity leaves it to the thickness of the tissue. */
static sc_tissue tissue_of_table(const sc_label *label)
{
    sc_tissue tissue = {.visible = !label->hidden,
                        .opacity = label->opacity,
                        .opacity_auto = label->opacity < 0,
                        .material = {.specular = SC_MATERIAL_SPECULAR,
                                     .roughness = SC_MATERIAL_ROUGHNESS,
                                     .coat = SC_MATERIAL_COAT}};

    tissue.is_rest =
        tissue.visible && tissue.opacity_auto && sc_name_role_of(label->name) == SC_NAME_REST;
    tissue.color_given = label->has_color;
    color_of(label->rgb, tissue.rgb_linear);
    return tissue;
}

/* Overwrite what a rule sets in @p tissue. Whether the rule matches is up to the caller. */
static void apply_rule(const sc_tissue_rule *rule, sc_tissue *tissue)
{
    if (rule->has.visible) {
        tissue->visible = rule->visible;
        tissue->visible_track = rule->visible_track;
    }
    tissue->is_rest = tissue->is_rest && !rule->has.visible && !rule->has.opacity;
    if (rule->has.offset) {
        tissue->offset_mm = rule->offset_mm;
        tissue->offset_track = rule->offset_track;
    }
    if (rule->has.color) {
        color_of(rule->rgb, tissue->rgb_linear);
        tissue->color_track = rule->color_track;
        tissue->color_by_rule = true;
    }
    tissue->color_given = tissue->color_given || rule->has.color;
    if (rule->has.opacity) {
        tissue->opacity = rule->opacity;
        tissue->opacity_auto = rule->opacity_auto;
        tissue->opacity_track = rule->opacity > 0 ? rule->opacity_track : 0;
    }
    if (rule->has.specular)
        tissue->material.specular = rule->material.specular;
    if (rule->has.roughness)
        tissue->material.roughness = rule->material.roughness;
    if (rule->has.coat)
        tissue->material.coat = rule->material.coat;
    if (rule->has.interior_opacity)
        tissue->interior_opacity = rule->interior_opacity;
}

/* Call @p apply for each rule and each label that it means, in the order of the rules. */
static void each_match(const sc_label *labels, int label_count, const sc_tissue_rule *rules,
                       size_t rule_count, void (*apply)(void *user, const sc_tissue_rule *, int id),
                       void *user)
{
    for (size_t r = 0; r < rule_count; r++) {
        const sc_pattern pattern = sc_pattern_of(rules[r].pattern);
        const sc_match best = sc_pattern_match(labels, label_count, &pattern);

        for (int id = 1; id < label_count && best != SC_MATCH_NONE; id++) {
            if (sc_label_match(&labels[id], &pattern) == best)
                apply(user, &rules[r], id);
        }
    }
}

/* Give a label the look that a rule gives; @p user [label_count] sc_tissue. */
static void apply_look(void *user, const sc_tissue_rule *rule, int id)
{
    sc_tissue *looks = user;

    apply_rule(rule, &looks[id]);
}

/* Hide what is left over, such as "heart other", whose scraps would lie on what is shown, unless
 * nothing else is. @param looks [label_count]: is_rest if the name says so and nothing else how the
 * tissue looks. */
static void hide_rests(int label_count, sc_tissue *looks)
{
    bool has_parts = false;

    for (int id = 1; id < label_count; id++)
        has_parts = has_parts || (looks[id].visible && !looks[id].is_rest);
    for (int id = 1; id < label_count; id++) {
        looks[id].is_rest = looks[id].is_rest && has_parts;
        looks[id].visible = looks[id].visible && !looks[id].is_rest;
    }
}

/* Find the looks of all labels by table, names and rules, of which later ones win. Where an opacity
 * is automatic, the value is still to be filled in: that takes the measured thickness of all
 * tissues.
 * @param out [label_count]; that of the background is zero. */
static void find_looks(const sc_label *labels, int label_count, const sc_tissue_rule *rules,
                       size_t rule_count, sc_tissue *out)
{
    out[0] = (sc_tissue){0}; /* background is never shown */
    for (int id = 1; id < label_count; id++)
        out[id] = tissue_of_table(&labels[id]);
    each_match(labels, label_count, rules, rule_count, apply_look, out);
    hide_rests(label_count, out);
}

/* Give a label the strength of smoothing that a rule gives; @p user [label_count] sc_vec3. */
static void apply_strength(void *user, const sc_tissue_rule *rule, int id)
{
    sc_vec3 *strengths = user;

    if (rule->has.smooth)
        strengths[id] = rule->smooth;
}

void sc_tissue_strengths(const sc_label *labels, int label_count, const sc_tissue_rule *rules,
                         size_t rule_count, sc_vec3 smooth, sc_vec3 *out)
{
    for (int id = 0; id < label_count; id++)
        out[id] = smooth;
    each_match(labels, label_count, rules, rule_count, apply_strength, out);
}

sc_status sc_hidden_labels(const sc_ctx *ctx, const sc_label *labels, int label_count,
                           const sc_tissue_rule *rules, size_t rule_count, bool *hidden)
{
    SC_OWN(sc_free_at) sc_tissue *looks = NULL;

    SC_PASS(SC_ALLOC(ctx, (size_t)label_count, &looks));
    find_looks(labels, label_count, rules, rule_count, looks);
    hidden[0] = false;
    for (int id = 1; id < label_count; id++) {
        const sc_tissue *t = &looks[id];

        hidden[id] =
            !t->visible || (!t->opacity_auto && !(t->opacity > 0) && !(t->interior_opacity > 0));
    }
    return SC_OK;
}

/* @return the scale of the paper: from the thinnest to the thickest visible tissue. */
static sc_opacity_scale scale_of_paper(const sc_prepared *volume, const sc_tissue *tissues)
{
    sc_opacity_scale out = {.least = 0.3, .most = 0.9, .thin_mm = HUGE_VAL, .thick_mm = 0};

    for (int id = 1; id < volume->label_count; id++) {
        const double thickness = volume->stats[id].thickness_mm;

        if (tissues[id].visible && thickness > 0) {
            out.thin_mm = fmin(out.thin_mm, thickness);
            out.thick_mm = fmax(out.thick_mm, thickness);
        }
    }
    out.thin_mm = fmin(out.thin_mm, out.thick_mm);
    return out;
}

/* @return the length of the diagonal of the box, along the axes of the volume, around the visible
 * tissues, in mm; 0 if there are none. */
static double diagonal_mm(const sc_prepared *volume, const sc_tissue *tissues)
{
    double squares = 0;

    for (int i = 0; i < 3; i++) {
        const double step_mm = sc_vec3_length(sc_affine_column(&volume->to_ras_mm, i));
        int low = INT_MAX, high = -1;

        for (int id = 1; id < volume->label_count; id++) {
            const sc_label_stats *s = &volume->stats[id];

            if (tissues[id].visible && s->voxels) {
                low = s->low[i] < low ? s->low[i] : low;
                high = s->high[i] > high ? s->high[i] : high;
            }
        }
        squares += high < low ? 0 : pow(step_mm * (high - low + 1), 2);
    }
    return sqrt(squares);
}

sc_opacity_scale sc_opacity_scale_of(const sc_prepared *volume, const sc_tissue *tissues,
                                     sc_opacity_rule rule)
{
    const double share = fmin(diagonal_mm(volume, tissues) / HUMAN_MM, 1);

    if (rule == SC_OPACITY_PAPER)
        return scale_of_paper(volume, tissues);
    return (sc_opacity_scale){.least = LEAST,
                              .most = MOST,
                              .thin_mm = share > 0 ? share * THIN_MM : THIN_MM,
                              .thick_mm = share > 0 ? share * THICK_MM : THICK_MM};
}

/* @return whether a tissue is to be seen through, because it encloses others, by rays or by its
 * name. */
static bool encloses(const sc_prepared *volume, int id)
{
    return volume->stats[id].cover_layer > 0 ||
           sc_name_role_of(volume->labels[id].name) == SC_NAME_OUTSIDE;
}

/* Set opacity, and is_cover, where opacity_auto is set, by the measurements in the volume's stats;
 * 0 for invisible tissues. Parts of a brain are opaque: they tile it, and one sees its surface.
 * @param tissues [label_count]. */
static void fill_auto(const sc_prepared *volume, sc_opacity_rule rule, sc_tissue *tissues)
{
    const sc_opacity_scale scale = sc_opacity_scale_of(volume, tissues, rule);
    const bool of_brain = rule == SC_OPACITY_MEASURED &&
                          sc_names_kind_of(volume->labels, volume->label_count) == SC_NAMES_BRAIN;
    bool others = false;

    for (int id = 1; id < volume->label_count; id++)
        others = others || (tissues[id].visible && !encloses(volume, id));
    for (int id = 1; id < volume->label_count; id++) {
        const sc_label_stats *stats = &volume->stats[id];
        sc_tissue *tissue = &tissues[id];

        if (!tissue->opacity_auto)
            continue;
        tissue->is_cover =
            rule == SC_OPACITY_MEASURED && (others ? encloses(volume, id) : stats->cover_layer > 0);
        if (!tissue->visible)
            tissue->opacity = 0;
        else if (tissue->is_cover)
            tissue->opacity = stats->cover_layer == 1 ? OUTER_COVER : INNER_COVER;
        else if (of_brain)
            tissue->opacity = 1;
        else
            tissue->opacity = sc_auto_opacity(&scale, stats->thickness_mm);
    }
}

/* @return the contrast of a colour in linear light to one that is seen. */
static double contrast_of(const sc_srgb_table *table, const float rgb_linear[3],
                          const sc_seen_color *other)
{
    uint8_t color[3];
    sc_seen_color seen;

    for (int i = 0; i < 3; i++)
        color[i] = sc_srgb_level(table, rgb_linear[i]);
    seen = sc_see_color(color);
    return sc_color_contrast(&seen, other);
}

/* Make a colour in linear light darker or lighter until its contrast to the background is enough.
 */
static void part_color(const sc_srgb_table *table, const sc_seen_color *behind, float rgb_linear[3])
{
    enum { STEPS = 24 };
    const float own[3] = {rgb_linear[0], rgb_linear[1], rgb_linear[2]};
    double most = contrast_of(table, own, behind);
    float left = 1; /* of the colour, the rest being black or white */

    for (int step = 0; step < STEPS && most < SC_CONTRAST; step++) {
        left *= 0.9f;
        for (int white = 0; white < 2; white++) {
            const float tried[3] = {left * own[0] + (1 - left) * (float)white,
                                    left * own[1] + (1 - left) * (float)white,
                                    left * own[2] + (1 - left) * (float)white};
            const double contrast = contrast_of(table, tried, behind);

            if (contrast > most) {
                most = contrast;
                memcpy(rgb_linear, tried, sizeof tried);
            }
        }
    }
}

void sc_part_from_background(int label_count, const uint8_t background[3], sc_tissue *tissues)
{
    const sc_seen_color behind = sc_see_color(background);
    sc_srgb_table table;

    sc_srgb_table_init(&table);
    for (int id = 1; id < label_count; id++) {
        if (!tissues[id].color_given)
            part_color(&table, &behind, tissues[id].rgb_linear);
    }
}

void sc_choose_background(const sc_prepared *volume, const sc_tissue *tissues, uint8_t rgb[3])
{
    static const uint8_t white[3] = {255, 255, 255}, slate[3] = {46, 52, 62};
    const double near = 0.1, most = 0.25; /* in OKLab, and of what is seen */
    const sc_seen_color behind = sc_see_color(white);
    sc_srgb_table table;
    double lost = 0;

    sc_srgb_table_init(&table);
    for (int id = 1; id < volume->label_count; id++) {
        uint8_t color[3];
        sc_seen_color seen;

        for (int i = 0; i < 3; i++)
            color[i] = sc_srgb_level(&table, tissues[id].rgb_linear[i]);
        seen = sc_see_color(color);
        if (tissues[id].visible && sc_color_distance(&seen, &behind, SC_VISION_FULL) < near)
            lost += volume->stats[id].shown;
    }
    memcpy(rgb, lost >= most ? slate : white, sizeof white);
}

void sc_transfer_resolve(const sc_prepared *volume, const sc_tissue_rule *rules, size_t rule_count,
                         sc_opacity_rule opacity, sc_tissue *out)
{
    find_looks(volume->labels, volume->label_count, rules, rule_count, out);
    fill_auto(volume, opacity, out);
}
