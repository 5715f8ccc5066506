/* SPDX-License-Identifier: BSD-3-Clause */
/* The looks of tissues, from the label table and the rules of the job. */
#include "segcast/image.h"
#include "segcast/scene.h"

#include <ctype.h>
#include <fnmatch.h>
#include <stdlib.h>
#include <string.h>

/* Copy the first SC_NAME_BYTES - 1 bytes of a string, ASCII letters in lower case, to @p to, which
 * has SC_NAME_BYTES, and terminate it. */
static void lower(const char *from, char *to)
{
    size_t i = 0;

    for (; from[i] && i + 1 < SC_NAME_BYTES; i++)
        to[i] = (char)tolower((unsigned char)from[i]);
    to[i] = '\0';
}

bool sc_label_matches(const sc_label *label, const char *pattern)
{
    char name[SC_NAME_BYTES], wanted[SC_NAME_BYTES], *end;
    const long long number = strtoll(pattern, &end, 10);

    if (end != pattern && !*end)
        return label->value == number;
    if (!strcmp(pattern, "*"))
        return true;
    lower(label->name, name);
    lower(pattern, wanted);
    return name[0] && (!strcmp(name, wanted) || fnmatch(wanted, name, 0) == 0);
}

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

/* @return the look of a label by table and rules, of which later ones win. Where its opacity is
 * automatic, the value is still to be filled in: that takes the measured thickness of all tissues.
 */
static sc_tissue tissue_of(const sc_label *label, const sc_tissue_rule *rules, size_t rule_count)
{
    sc_tissue tissue = tissue_of_table(label);

    for (size_t r = 0; r < rule_count; r++) {
        if (sc_label_matches(label, rules[r].pattern))
            apply_rule(&rules[r], &tissue);
    }
    return tissue;
}

sc_status sc_tissue_unknown(const sc_ctx *ctx, const sc_prepared *volume, const char *pattern,
                            const char *where)
{
    const char **names;
    const char *nearest;
    void *block;
    sc_status status = sc_zalloc(ctx, (size_t)volume->label_count, sizeof(const char *), &block);

    if (status != SC_OK)
        return status;
    names = block;
    for (int id = 1; id < volume->label_count; id++)
        names[id] = volume->labels[id].name[0] ? volume->labels[id].name : NULL;
    nearest = sc_nearest_word(pattern, names, (size_t)volume->label_count);
    status = sc_fail(ctx, SC_ERR_DATA, "%s%stissue \"%s\" matches no label of the volume%s%s%s",
                     where, where[0] ? ": " : "", pattern, nearest ? "; did you mean \"" : "",
                     nearest ? nearest : "", nearest ? "\"?" : "");
    sc_free(block);
    return status;
}

void sc_hidden_labels(const sc_label *labels, int label_count, const sc_tissue_rule *rules,
                      size_t rule_count, bool *hidden, bool *needs_thickness)
{
    *needs_thickness = false;
    hidden[0] = false;
    for (int id = 1; id < label_count; id++) {
        const sc_tissue t = tissue_of(&labels[id], rules, rule_count);

        hidden[id] =
            !t.visible || (!t.opacity_auto && !(t.opacity > 0) && !(t.interior_opacity > 0));
        *needs_thickness = *needs_thickness || (!hidden[id] && t.opacity_auto);
    }
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

/* Returns SC_ERR_DATA, logged, for the first rule that matches no label, else SC_OK. The pattern
 * "*" is allowed even where there are no labels. */
static sc_status check_rules(const sc_ctx *ctx, const sc_prepared *volume,
                             const sc_tissue_rule *rules, size_t rule_count)
{
    for (size_t r = 0; r < rule_count; r++) {
        bool matched = !strcmp(rules[r].pattern, "*");

        for (int id = 1; id < volume->label_count && !matched; id++)
            matched = sc_label_matches(&volume->labels[id], rules[r].pattern);
        if (!matched)
            return sc_tissue_unknown(ctx, volume, rules[r].pattern, rules[r].where);
    }
    return SC_OK;
}

sc_status sc_transfer_resolve(const sc_ctx *ctx, const sc_prepared *volume,
                              const sc_tissue_rule *rules, size_t rule_count, sc_tissue *out)
{
    const sc_status status = check_rules(ctx, volume, rules, rule_count);

    if (status != SC_OK)
        return status;
    out[0] = (sc_tissue){0}; /* background is never shown */
    for (int id = 1; id < volume->label_count; id++)
        out[id] = tissue_of(&volume->labels[id], rules, rule_count);
    fill_auto(volume, out);
    return SC_OK;
}
