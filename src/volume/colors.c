/* SPDX-License-Identifier: BSD-3-Clause */
/* Colours of labels for which no table has one. They come from a palette of colours that sit
 * together: in OKLab all have about the same chroma, five steps of lightness, and are far apart.
 * Every label value has a place in the palette. Where labels that touch, or lie near each other,
 * would look alike, the one with the larger value takes another place: a greedy colouring of the
 * graph of contacts. A tissue whose name anatomists know has the colour of anatomy.c, or a shade of
 * it where it touches others of that colour. */
#include "segcast/image.h"
#include "source.h"

#include <math.h>
#include <string.h>

enum { PALETTE = 24 };

/* Found by search among colours of chroma 0.115 and lightness 0.53, 0.60, 0.67, 0.74 and 0.80 in
 * OKLab, each hue 6 degrees from the next: again and again the one that is farthest from those
 * found before, full colour vision counting 1 and each colour blindness 1.5 times. Then put in an
 * order in which the first few look well together. */
static const uint8_t palette[PALETTE][3] = {
    {210, 121, 106}, {73, 105, 174},  {211, 161, 80},  {95, 193, 148},  {160, 132, 209},
    {162, 76, 97},   {85, 208, 237},  {111, 140, 58},  {251, 158, 187}, {3, 145, 156},
    {197, 195, 104}, {110, 121, 196}, {127, 107, 3},   {207, 145, 212}, {33, 172, 152},
    {183, 97, 125},  {143, 209, 142}, {144, 81, 139},  {151, 164, 243}, {233, 144, 119},
    {61, 125, 62},   {170, 149, 54},  {151, 107, 178}, {189, 122, 183}};

/* What encloses all others is seen most: as light as the lightest of the palette, near that of
 * skin, and with less than half of their chroma, so that they stand out. */
static const uint8_t cover_color[3] = {219, 190, 171};

/* @return the place of a label value in the palette: consecutive values have different ones. */
static int place_of(int64_t value)
{
    const int rest = (int)((value - 1) % PALETTE);

    return rest < 0 ? rest + PALETTE : rest;
}

void sc_label_base_color(int64_t value, uint8_t rgb[3])
{
    memcpy(rgb, palette[place_of(value)], 3);
}

sc_label sc_label_new(int64_t value)
{
    sc_label label = {.value = value, .opacity = -1};

    sc_label_base_color(value, label.rgb);
    return label;
}

/* Two colours nearer than this, as the eye sees them, count as the same. */
#define SAME 0.04

/* The contrast that labels need which are near each other without touching. */
#define NEAR_CONTRAST 0.08

/* @return how bad a contrast is: 0 if it is @p enough, 1 if there is none. */
static double penalty(double contrast, double enough)
{
    const double lacking = contrast < enough ? 1 - contrast / enough : 0;

    return lacking * lacking;
}

/* How far apart hues must lie in the plane of hue and chroma: light and shadow change lightness, so
 * that a light and a dark blue look alike on a round surface. And how much this counts. */
#define HUE_DISTANCE 0.08
#define HUE_SHARE 0.3

/* @return how badly two colours go beside each other that differ by too little else than lightness.
 */
static double hue_penalty(const sc_seen_color *a, const sc_seen_color *b)
{
    const double *one = a->lab[SC_VISION_FULL], *other = b->lab[SC_VISION_FULL];

    return HUE_SHARE * penalty(hypot(one[1] - other[1], one[2] - other[2]), HUE_DISTANCE);
}

/* How badly a colour goes beside each of the palette. */
typedef struct penalties {
    double touching[PALETTE], near[PALETTE];
} penalties;

/* The assignment in work. Its arrays belong to sc_volume_color. */
typedef struct coloring {
    const sc_volume *volume;
    const uint64_t *contact; /* of sc_count_contacts */
    const uint32_t *near;    /* of sc_count_near */
    penalties *penalties;    /* [label_count]: of each label's colour beside each of the
                                palette; set for labels that have their final colour */
    bool *colored;           /* [label_count]: the label has its final colour */
    sc_appearance appearance;
    sc_seen_color places[PALETTE]; /* the palette */
    double uses[PALETTE];          /* how many labels have this colour, or one like it */
} coloring;

/* Note that a label has its final colour. */
static void settle(coloring *c, int id)
{
    const sc_seen_color seen = sc_see_color(c->volume->labels[id].rgb);

    for (int i = 0; i < PALETTE; i++) {
        const double contrast = sc_color_contrast(&seen, &c->places[i]);

        c->penalties[id].touching[i] =
            penalty(contrast, SC_CONTRAST) + hue_penalty(&seen, &c->places[i]);
        c->penalties[id].near[i] = penalty(contrast, NEAR_CONTRAST);
        c->uses[i] += sc_color_distance(&seen, &c->places[i], SC_VISION_FULL) < SAME;
    }
    c->colored[id] = true;
}

/* Choose a colour for a label: the one of its place, unless it looks like that of labels that it
 * touches or that are near it, or is used more often than others. */
static void choose(coloring *c, int id, int colored_count)
{
    /* Touching at all, being near with every part, being one of several labels with a colour, and
     * leaving one's place. */
    const double touch = 0.02, nearness = 0.1;
    const double repeat = 0.01 / (1 + (double)colored_count / PALETTE), move = 0.003;
    const int count = c->volume->label_count, home = place_of(c->volume->labels[id].value);
    const uint64_t *contact = c->contact + (size_t)id * (size_t)count;
    const uint32_t *near = c->near + (size_t)id * (size_t)count;
    const double blocks = near[id] > 0 ? near[id] : 1;
    double total = 0, costs[PALETTE];
    int best = home;

    for (int other = 1; other < count; other++)
        total += (double)contact[other];
    for (int i = 0; i < PALETTE; i++)
        costs[i] = repeat * c->uses[i] + (i == home ? 0 : move);
    for (int other = 1; other < count; other++) {
        const double touching = contact[other] ? touch + (double)contact[other] / total : 0;
        const double nearby = nearness * near[other] / blocks;

        for (int i = 0; i < PALETTE && touching + nearby > 0 && c->colored[other]; i++) {
            costs[i] +=
                touching * c->penalties[other].touching[i] + nearby * c->penalties[other].near[i];
        }
    }
    for (int i = 0; i < PALETTE; i++)
        best = costs[i] < costs[best] ? i : best;
    memcpy(c->volume->labels[id].rgb, palette[best], 3);
}

/* How much of white, or, negative, of black is mixed into the colour of anatomy to tell tissues of
 * the same kind apart: neighbouring vertebrae, lobes of a lung. */
static const double shades[] = {0, 0.22, -0.18, 0.4, -0.32};

/* Write a shade of @p base to @p rgb. */
static void mix_shade(const uint8_t base[3], double shade, uint8_t rgb[3])
{
    const double share = fabs(shade), other = shade > 0 ? 255 : 0;

    for (int i = 0; i < 3; i++)
        rgb[i] = (uint8_t)(base[i] * (1 - share) + other * share + 0.5);
}

/* Give a label the shade of its colour of anatomy that differs most from the colours of those that
 * it touches; the colour itself unless that is hard to tell from one of them. */
static void choose_shade(coloring *c, int id, const uint8_t base[3])
{
    const double leave = 0.02; /* of leaving the colour, for each step of shades */
    const int count = c->volume->label_count;
    const uint64_t *contact = c->contact + (size_t)id * (size_t)count;
    double least = HUGE_VAL;

    for (size_t i = 0; i < SC_COUNT_OF(shades); i++) {
        double cost = leave * (double)i;
        uint8_t tried[3];
        sc_seen_color seen;

        mix_shade(base, shades[i], tried);
        seen = sc_see_color(tried);
        for (int other = 1; other < count; other++) {
            if (contact[other] && c->colored[other]) {
                const sc_seen_color beside = sc_see_color(c->volume->labels[other].rgb);

                cost += penalty(sc_color_contrast(&seen, &beside), NEAR_CONTRAST);
            }
        }
        if (cost < least) {
            least = cost;
            memcpy(c->volume->labels[id].rgb, tried, sizeof tried);
        }
    }
}

/* Colour one label that has no colour yet. @param known whether tissues that anatomists know are to
 * be coloured, or the others. @return whether it was coloured. */
static bool color_label(coloring *c, int id, bool known, int settled)
{
    uint8_t base[3];
    const bool has_base = c->appearance != SC_APPEARANCE_DISTINCT &&
                          sc_anatomy_color(c->volume->labels[id].name, base);

    if (c->colored[id] || has_base != known)
        return false;
    if (known)
        choose_shade(c, id, base);
    else
        choose(c, id, settled);
    settle(c, id);
    return true;
}

/* Give a colour to all labels that have none, one after the other by value, first those that
 * anatomists know. */
static void color_all(coloring *c, int cover)
{
    const int count = c->volume->label_count;
    sc_label *labels = c->volume->labels;
    uint8_t base[3];
    int settled = 0;

    for (int i = 0; i < PALETTE; i++)
        c->places[i] = sc_see_color(palette[i]);
    if (cover > 0 && !labels[cover].has_color)
        memcpy(labels[cover].rgb, cover_color, 3);
    for (int id = 1; id < count; id++) {
        const bool is_pale = id == cover && (c->appearance == SC_APPEARANCE_DISTINCT ||
                                             !sc_anatomy_color(labels[id].name, base));

        if (labels[id].has_color || is_pale) {
            settle(c, id);
            settled++;
        }
    }
    for (int known = 1; known >= 0; known--) {
        for (int id = 1; id < count; id++)
            settled += color_label(c, id, known, settled);
    }
}

/* @return whether a label keeps the colour that a table gives it. */
static bool keeps_color(const sc_label *label, sc_appearance appearance)
{
    uint8_t rgb[3];

    return label->has_color && appearance != SC_APPEARANCE_DISTINCT &&
           !(appearance == SC_APPEARANCE_ANATOMY && sc_anatomy_color(label->name, rgb));
}

bool sc_volume_lacks_colors(const sc_volume *volume, sc_appearance appearance)
{
    bool lacks = false;

    for (int id = 1; id < volume->label_count; id++)
        lacks = lacks || !keeps_color(&volume->labels[id], appearance);
    return lacks && volume->label_count <= SC_COLORED_LABELS_MAX;
}

sc_status sc_volume_color(const sc_ctx *ctx, sc_volume *volume, int cover, sc_appearance appearance,
                          int threads)
{
    const size_t count = (size_t)volume->label_count;
    coloring c = {.volume = volume, .appearance = appearance};
    void *badness = NULL, *colored = NULL;
    uint64_t *contact = NULL;
    uint32_t *near = NULL;
    sc_status status;

    if (!sc_volume_lacks_colors(volume, appearance))
        return SC_OK;
    SC_TRY(sc_zalloc(ctx, count, sizeof *c.penalties, &badness));
    SC_TRY(sc_zalloc(ctx, count, sizeof *c.colored, &colored));
    SC_TRY(sc_count_contacts(ctx, volume, threads, &contact));
    SC_TRY(sc_count_near(ctx, volume, &near));
    c.penalties = badness;
    c.colored = colored;
    c.contact = contact;
    c.near = near;
    for (int id = 1; id < volume->label_count; id++)
        volume->labels[id].has_color = keeps_color(&volume->labels[id], appearance);
    color_all(&c, cover);
out:
    sc_free(near);
    sc_free(contact);
    sc_free(colored);
    sc_free(badness);
    return status;
}
