/* SPDX-License-Identifier: BSD-3-Clause */
/* The looks of tissues, from the label table and the rules of the job. */
#include "segcast/image.h"
#include "segcast/scene.h"

double sc_auto_opacity(double thickness_mm, double thinnest_mm, double thickest_mm)
{
    const double least = 0.3, most = 0.9; /* of the thinnest and of the thickest tissue */

    if (!(thickness_mm > 0) || !(thickest_mm > thinnest_mm))
        return most;
    return least +
           (most - least) * log(thickness_mm / thinnest_mm) / log(thickest_mm / thinnest_mm);
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
                        .material = {.diffuse = SC_MATERIAL_DIFFUSE,
                                     .specular = SC_MATERIAL_SPECULAR,
                                     .shininess = SC_MATERIAL_SHININESS}};

    color_of(label->rgb, tissue.rgb_linear);
    return tissue;
}

/* Overwrite what a rule sets in @p tissue. Whether the rule matches is up to the caller. */
static void apply_rule(const sc_tissue_rule *rule, sc_tissue *tissue)
{
    if (rule->has_visible)
        tissue->visible = rule->visible;
    if (rule->has_color)
        color_of(rule->rgb, tissue->rgb_linear);
    if (rule->has_opacity) {
        tissue->opacity = rule->opacity;
        tissue->opacity_auto = rule->opacity_auto;
    }
    if (rule->has_diffuse)
        tissue->material.diffuse = rule->material.diffuse;
    if (rule->has_specular)
        tissue->material.specular = rule->material.specular;
    if (rule->has_shininess)
        tissue->material.shininess = rule->material.shininess;
    if (rule->has_interior_opacity)
        tissue->interior_opacity = rule->interior_opacity;
    tissue->interior_given = tissue->interior_given || rule->has_interior_opacity;
}

/* Find the looks of all labels by table and rules, of which later ones win. Where an opacity is
 * automatic, the value is still to be filled in: that takes the measured thickness of all tissues.
 * @param out [label_count]; that of the background is zero. */
static void find_looks(const sc_label *labels, int label_count, const sc_tissue_rule *rules,
                       size_t rule_count, sc_tissue *out)
{
    out[0] = (sc_tissue){0}; /* background is never shown */
    for (int id = 1; id < label_count; id++)
        out[id] = tissue_of_table(&labels[id]);
    for (size_t r = 0; r < rule_count; r++) {
        const sc_pattern pattern = sc_pattern_of(rules[r].pattern);
        const sc_match best = sc_pattern_match(labels, label_count, &pattern);

        for (int id = 1; id < label_count && best != SC_MATCH_NONE; id++) {
            if (sc_label_match(&labels[id], &pattern) == best)
                apply_rule(&rules[r], &out[id]);
        }
    }
}

sc_status sc_hidden_labels(const sc_ctx *ctx, const sc_label *labels, int label_count,
                           const sc_tissue_rule *rules, size_t rule_count, bool *hidden,
                           bool *needs_thickness)
{
    sc_tissue *looks;
    void *block;
    sc_status status = sc_alloc(ctx, (size_t)label_count, sizeof *looks, &block);

    if (status != SC_OK)
        return status;
    looks = block;
    find_looks(labels, label_count, rules, rule_count, looks);
    *needs_thickness = false;
    hidden[0] = false;
    for (int id = 1; id < label_count; id++) {
        const sc_tissue *t = &looks[id];

        hidden[id] =
            !t->visible || (!t->opacity_auto && !(t->opacity > 0) && !(t->interior_opacity > 0));
        *needs_thickness = *needs_thickness || (!hidden[id] && t->opacity_auto);
    }
    sc_free(block);
    return SC_OK;
}

void sc_thickness_range(const sc_prepared *volume, const sc_tissue *tissues, double *thinnest_mm,
                        double *thickest_mm)
{
    *thinnest_mm = HUGE_VAL;
    *thickest_mm = 0;
    for (int id = 1; id < volume->label_count; id++) {
        const double thickness = volume->stats[id].thickness_mm;

        if (tissues[id].visible && thickness > 0) {
            *thinnest_mm = fmin(*thinnest_mm, thickness);
            *thickest_mm = fmax(*thickest_mm, thickness);
        }
    }
    *thinnest_mm = fmin(*thinnest_mm, *thickest_mm);
}

/* Set opacity where opacity_auto is set, by the thickness in the volume's stats; 0 for invisible
 * tissues. @param tissues [label_count]. */
static void fill_auto(const sc_prepared *volume, sc_tissue *tissues)
{
    double thinnest, thickest;

    sc_thickness_range(volume, tissues, &thinnest, &thickest);
    for (int id = 1; id < volume->label_count; id++) {
        sc_tissue *tissue = &tissues[id];

        if (tissue->opacity_auto)
            tissue->opacity = tissue->visible ? sc_auto_opacity(volume->stats[id].thickness_mm,
                                                                thinnest, thickest)
                                              : 0;
    }
}

sc_status sc_tissue_rules_check(const sc_ctx *ctx, const sc_prepared *volume,
                                const sc_tissue_rule *rules, size_t rule_count)
{
    const sc_ctx quiet = sc_quiet(ctx);
    size_t mistakes = 0;

    for (size_t r = 0; r < rule_count; r++) {
        const sc_status status = sc_pattern_check(mistakes < SC_MISTAKES_MAX ? ctx : &quiet, volume,
                                                  rules[r].pattern, rules[r].where);

        if (status != SC_OK && status != SC_ERR_DATA)
            return status;
        mistakes += status == SC_ERR_DATA;
    }
    if (mistakes > SC_MISTAKES_MAX)
        sc_warn(ctx, "%zu further tissues that are not found are not shown",
                mistakes - SC_MISTAKES_MAX);
    return mistakes ? SC_ERR_DATA : SC_OK;
}

sc_status sc_transfer_resolve(const sc_ctx *ctx, const sc_prepared *volume,
                              const sc_tissue_rule *rules, size_t rule_count, sc_tissue *out)
{
    const sc_status status = sc_tissue_rules_check(ctx, volume, rules, rule_count);

    if (status != SC_OK)
        return status;
    find_looks(volume->labels, volume->label_count, rules, rule_count, out);
    fill_auto(volume, out);
    return SC_OK;
}
