/* SPDX-License-Identifier: BSD-3-Clause */
/* Colours of labels for which no table has one. They come from a palette of colours that sit
 * together and are far apart in OKLab. Every label value has a place in the palette, and only where
 * it would look like a label with a smaller value that it touches, or be the same as one that lies
 * near, it takes the nearest colour that does not. So what a label looks like depends on its value
 * first, then on its neighbours, and on nothing that is far away: a part of a volume has nearly the
 * colours of the whole. A tissue whose name anatomists know has the colour of anatomy.c, or a shade
 * of it where it touches others of that colour. */
#include "segcast/image.h"
#include "source.h"

#include <math.h>
#include <stdlib.h>

enum { PALETTE = 97 };

/* Found by search in OKLab. The first 24 are of chroma 0.115 and lightness 0.53, 0.60, 0.67, 0.74
 * and 0.80, each hue 6 degrees from the next: again and again the one that is farthest from those
 * found before, full colour vision counting 1 and each colour blindness 1.5 times; then put in an
 * order in which the first few look well together. The others, of chroma 0.09, 0.115 and 0.14 and
 * lightness 0.50 to 0.84, are those of which the fewest look alike (CLEAR and CLEAR_BLIND, below),
 * in an order in which values that differ by up to 12, which often touch, look alike least. The
 * number is a prime, so that values that differ by 1000, as the sides of some atlases do, have
 * other places. */
static const uint8_t palette[PALETTE][3] = {
    {210, 121, 106}, {73, 105, 174},  {211, 161, 80},  {95, 193, 148},  {160, 132, 209},
    {162, 76, 97},   {85, 208, 237},  {111, 140, 58},  {251, 158, 187}, {3, 145, 156},
    {197, 195, 104}, {110, 121, 196}, {127, 107, 3},   {207, 145, 212}, {33, 172, 152},
    {183, 97, 125},  {143, 209, 142}, {144, 81, 139},  {151, 164, 243}, {233, 144, 119},
    {61, 125, 62},   {170, 149, 54},  {151, 107, 178}, {189, 122, 183}, {149, 61, 124},
    {229, 127, 79},  {182, 171, 252}, {238, 198, 81},  {196, 87, 109},  {117, 209, 197},
    {74, 94, 164},   {160, 173, 235}, {55, 184, 128},  {237, 145, 174}, {143, 92, 47},
    {93, 83, 174},   {45, 134, 159},  {138, 132, 228}, {205, 95, 98},   {123, 95, 27},
    {162, 223, 128}, {205, 175, 51},  {157, 58, 103},  {160, 116, 208}, {42, 120, 153},
    {170, 161, 224}, {102, 196, 190}, {220, 131, 109}, {153, 74, 114},  {199, 160, 30},
    {129, 102, 195}, {59, 157, 157},  {179, 75, 113},  {200, 113, 91},  {138, 115, 0},
    {186, 207, 120}, {249, 170, 253}, {43, 115, 81},   {172, 137, 232}, {70, 206, 206},
    {225, 117, 90},  {97, 109, 183},  {180, 138, 212}, {247, 172, 77},  {183, 215, 153},
    {101, 176, 144}, {177, 69, 84},   {124, 146, 23},  {138, 66, 142},  {120, 194, 230},
    {97, 98, 189},   {186, 189, 120}, {163, 57, 73},   {239, 169, 232}, {187, 117, 133},
    {102, 143, 194}, {90, 100, 157},  {197, 188, 66},  {239, 125, 136}, {147, 108, 50},
    {130, 158, 75},  {197, 94, 138},  {121, 129, 63},  {170, 150, 229}, {222, 142, 96},
    {70, 135, 216},  {250, 166, 213}, {157, 199, 254}, {141, 81, 54},   {181, 83, 134},
    {110, 82, 154},  {66, 188, 160},  {191, 216, 105}, {81, 118, 205},  {210, 100, 121},
    {144, 129, 29},  {156, 150, 248}};

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

/* How far apart the colours of labels that touch must lie to full vision, and to colour-blind eyes.
 */
#define CLEAR 0.111
#define CLEAR_BLIND 0.061

/* What counts as touching: this share of what either of the two shares with all others. */
#define TOUCHING_SHARE 0.025

/* The contrast that a label which moves needs to those that are near it without touching: being
 * near with nearly all of its parts. Below that share of the contrast two colours count as the
 * same. */
#define NEAR_CONTRAST 0.08
#define NEAR_SHARE 0.8
#define SAME_SHARE 0.3

/* How well each colour of the palette goes beside a colour: 1 and more is well. */
typedef struct fitness {
    float touching[PALETTE], near[PALETTE];
} fitness;

/* What the name of a tissue tells. */
typedef struct tissue_name {
    char
        key[SC_NAME_KEY_BYTES]; /* of sc_name_without_side; empty where all colours are to differ */
    bool has_base;              /* anatomists know it */
    uint8_t base[3];            /* its colour of anatomy */
    int id;
} tissue_name;

/* The assignment in work. Owns its arrays: clear_coloring. */
typedef struct coloring {
    const sc_volume *volume;
    tissue_name *names;           /* [label_count] */
    const tissue_name **in_order; /* [label_count] the same, by key */
    uint64_t *contact;            /* of sc_count_contacts */
    uint32_t *near;               /* of sc_count_near */
    double *total_contact;        /* [label_count]: of each label with all others */
    fitness *fitness; /* [label_count]: beside each label's colour; set for labels that have
                         their final colour */
    bool *colored;    /* [label_count]: the label has its final colour */
    sc_seen_color places[PALETTE]; /* the palette */
} coloring;

/* Note that a label has its final colour. */
static void settle(coloring *c, int id)
{
    const sc_seen_color seen = sc_see_color(c->volume->labels[id].rgb);

    for (int i = 0; i < PALETTE; i++) {
        double blind = HUGE_VAL;

        for (int vision = SC_VISION_FULL + 1; vision < SC_VISION_COUNT; vision++)
            blind = fmin(blind, sc_color_distance(&seen, &c->places[i], (sc_vision)vision));
        c->fitness[id].touching[i] = (float)fmin(
            sc_color_distance(&seen, &c->places[i], SC_VISION_FULL) / CLEAR, blind / CLEAR_BLIND);
        c->fitness[id].near[i] = (float)(sc_color_contrast(&seen, &c->places[i]) / NEAR_CONTRAST);
    }
    c->colored[id] = true;
}

/* Are two labels the left and the right of a pair, or the same one? Both sides of a heart, whose
 * colours differ, are none. */
static bool is_same(const coloring *c, int a, int b)
{
    const tissue_name *x = &c->names[a], *y = &c->names[b];

    return a == b || (x->key[0] && !strcmp(x->key, y->key) && x->has_base == y->has_base &&
                      !memcmp(x->base, y->base, sizeof x->base));
}

/* Give a label its final colour, and with it those of the same pair that have none. */
static void settle_all(coloring *c, int id, const uint8_t rgb[3])
{
    for (int other = id; other < c->volume->label_count; other++) {
        if (!c->colored[other] && is_same(c, id, other)) {
            memcpy(c->volume->labels[other].rgb, rgb, 3);
            settle(c, other);
        }
    }
}

/* Lower @p fits to how well each colour of the palette goes beside those of the labels that touch a
 * label, and of those that are near it: the least of all. */
static void look_around(const coloring *c, int id, fitness *fits)
{
    const int count = c->volume->label_count;
    const uint64_t *contact = c->contact + (size_t)id * (size_t)count;
    const uint32_t *near = c->near + (size_t)id * (size_t)count;

    for (int other = 1; other < count; other++) {
        const double least = fmin(c->total_contact[id], c->total_contact[other]);
        const bool touches = (double)contact[other] > TOUCHING_SHARE * least;
        const bool is_near = near[other] > 0 && near[other] >= NEAR_SHARE * near[id];

        for (int i = 0; i < PALETTE && c->colored[other] && touches; i++)
            fits->touching[i] = fminf(fits->touching[i], c->fitness[other].touching[i]);
        for (int i = 0; i < PALETTE && c->colored[other] && is_near; i++)
            fits->near[i] = fminf(fits->near[i], c->fitness[other].near[i]);
    }
}

/* @return the place of the colour that is nearest to that of @p home among those that go at least
 * as well as asked beside their neighbours, or -1. */
static int nearest_place(const coloring *c, int home, const fitness *fits, double touching,
                         double near)
{
    double least = HUGE_VAL;
    int best = -1;

    for (int i = 0; i < PALETTE; i++) {
        const double distance = sc_color_distance(&c->places[home], &c->places[i], SC_VISION_FULL);

        if (fits->touching[i] >= touching && fits->near[i] >= near && distance < least) {
            least = distance;
            best = i;
        }
    }
    return best;
}

/* Choose a colour for a label: the one of its place, unless it looks like that of a label that it
 * touches or is the same as that of one that is near; then the nearest to it that does not; and if
 * there is none, the one that looks least like those that it touches. */
static void choose(coloring *c, int id)
{
    const int home = place_of(c->volume->labels[id].value);
    fitness fits;
    int best = home;

    for (int i = 0; i < PALETTE; i++)
        fits.touching[i] = fits.near[i] = HUGE_VALF;
    for (int side = id; side < c->volume->label_count; side++) {
        if (is_same(c, id, side))
            look_around(c, side, &fits);
    }
    if (fits.near[home] < SAME_SHARE)
        best = nearest_place(c, home, &fits, 1, 1);
    if (best < 0 || fits.touching[best] < 1)
        best = nearest_place(c, home, &fits, 1, SAME_SHARE);
    if (best < 0)
        best = nearest_place(c, home, &fits, 1, 0);
    if (best < 0) {
        best = home;
        for (int i = 0; i < PALETTE; i++)
            best = fits.touching[i] > fits.touching[best] ? i : best;
    }
    settle_all(c, id, palette[best]);
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

/* @return how much contrast a colour lacks to those of the labels of the same kind, which have the
 * same colour of anatomy, that touch a label. */
static double lacking_beside(const coloring *c, int id, const uint8_t rgb[3])
{
    const int count = c->volume->label_count;
    const uint64_t *contact = c->contact + (size_t)id * (size_t)count;
    const sc_seen_color seen = sc_see_color(rgb);
    double out = 0;

    for (int other = 1; other < count; other++) {
        const tissue_name *name = &c->names[other];

        if (contact[other] && c->colored[other] && name->has_base &&
            !memcmp(name->base, c->names[id].base, sizeof name->base)) {
            const sc_seen_color beside = sc_see_color(c->volume->labels[other].rgb);
            const double lacking = 1 - sc_color_contrast(&seen, &beside) / NEAR_CONTRAST;

            out += lacking > 0 ? lacking * lacking : 0;
        }
    }
    return out;
}

/* Give a label, and the other of its pair, the shade of its colour of anatomy that differs most
 * from those of its kind that it touches; the colour itself unless that is hard to tell from one of
 * them. Other neighbours do not matter: a liver looks the same in every volume. */
static void choose_shade(coloring *c, int id)
{
    const double leave = 0.02; /* of leaving the colour, for each step of shades */
    double least = HUGE_VAL;
    uint8_t best[3];

    for (size_t i = 0; i < SC_COUNT_OF(shades); i++) {
        double cost = leave * (double)i;
        uint8_t tried[3];

        mix_shade(c->names[id].base, shades[i], tried);
        for (int side = 1; side < c->volume->label_count; side++)
            cost += is_same(c, id, side) ? lacking_beside(c, side, tried) : 0;
        if (cost < least) {
            least = cost;
            memcpy(best, tried, sizeof best);
        }
    }
    settle_all(c, id, best);
}

/* For qsort: by key, then by number. */
static int by_key(const void *a, const void *b)
{
    const tissue_name *x = *(tissue_name *const *)a, *y = *(tissue_name *const *)b;
    const int order = strcmp(x->key, y->key);

    return order ? order : x->id - y->id;
}

/* Find what the names tell, and their order. */
static void read_names(coloring *c, sc_appearance appearance)
{
    const sc_volume *v = c->volume;
    const sc_names_kind kind = sc_names_kind_of(v->labels, v->label_count);

    for (int id = 0; id < v->label_count; id++) {
        tissue_name *name = &c->names[id];

        c->in_order[id] = name;
        name->id = id;
        if (appearance == SC_APPEARANCE_DISTINCT)
            continue;
        sc_name_without_side(v->labels[id].name, kind, name->key);
        name->has_base = sc_anatomy_color(v->labels[id].name, kind, name->base);
    }
    qsort(c->in_order, (size_t)v->label_count, sizeof(const tissue_name *), by_key);
}

/* Give a colour to all labels that have none: first to those that anatomists know, by name, so that
 * it does not depend on how a file numbers them; then to the others, by value. */
static void color_all(coloring *c, int cover)
{
    const int count = c->volume->label_count;
    sc_label *labels = c->volume->labels;

    for (int i = 0; i < PALETTE; i++)
        c->places[i] = sc_see_color(palette[i]);
    for (int id = 1; id < count; id++) {
        for (int other = 1; other < count; other++)
            c->total_contact[id] += (double)c->contact[(size_t)id * (size_t)count + (size_t)other];
    }
    for (int id = 1; id < count; id++) {
        const bool is_pale = id == cover && !labels[id].has_color && !c->names[id].has_base;

        if (is_pale)
            memcpy(labels[id].rgb, cover_color, 3);
        if (labels[id].has_color || is_pale)
            settle(c, id);
    }
    for (int i = 0; i < count; i++) {
        const tissue_name *name = c->in_order[i];

        if (name->id && name->has_base && !c->colored[name->id])
            choose_shade(c, name->id);
    }
    for (int id = 1; id < count; id++) {
        if (!c->colored[id])
            choose(c, id);
    }
}

/* @return whether a label keeps the colour that a table gives it. */
static bool keeps_color(const sc_label *label, sc_appearance appearance, sc_names_kind kind)
{
    uint8_t rgb[3];

    return label->has_color && appearance != SC_APPEARANCE_DISTINCT &&
           !(appearance == SC_APPEARANCE_ANATOMY && sc_anatomy_color(label->name, kind, rgb));
}

bool sc_volume_lacks_colors(const sc_volume *volume, sc_appearance appearance)
{
    const sc_names_kind kind = sc_names_kind_of(volume->labels, volume->label_count);
    bool lacks = false;

    for (int id = 1; id < volume->label_count; id++)
        lacks = lacks || !keeps_color(&volume->labels[id], appearance, kind);
    return lacks && volume->label_count <= SC_COLORED_LABELS_MAX;
}

/* For SC_OWN. */
static void clear_coloring(coloring *c)
{
    sc_free(c->names);
    sc_free(c->in_order);
    sc_free(c->contact);
    sc_free(c->near);
    sc_free(c->total_contact);
    sc_free(c->fitness);
    sc_free(c->colored);
}

sc_status sc_volume_color(const sc_ctx *ctx, sc_volume *volume, int cover, sc_appearance appearance,
                          int threads)
{
    const size_t count = (size_t)volume->label_count;
    const sc_names_kind kind = sc_names_kind_of(volume->labels, volume->label_count);
    SC_OWN(clear_coloring) coloring c = {.volume = volume};

    if (!sc_volume_lacks_colors(volume, appearance))
        return SC_OK;
    SC_PASS(SC_ZALLOC(ctx, count, &c.names));
    SC_PASS(SC_ALLOC(ctx, count, &c.in_order));
    SC_PASS(SC_ZALLOC(ctx, count, &c.fitness));
    SC_PASS(SC_ZALLOC(ctx, count, &c.colored));
    SC_PASS(SC_ZALLOC(ctx, count, &c.total_contact));
    SC_PASS(sc_count_contacts(ctx, volume, threads, &c.contact));
    SC_PASS(sc_count_near(ctx, volume, &c.near));
    for (int id = 1; id < volume->label_count; id++)
        volume->labels[id].has_color = keeps_color(&volume->labels[id], appearance, kind);
    read_names(&c, appearance);
    color_all(&c, cover);
    return SC_OK;
}
