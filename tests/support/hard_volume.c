/* SPDX-License-Identifier: BSD-3-Clause */
/* Volumes that are hard to draw, written as NRRD with the names of their tissues:
 *
 *   hard_volume torso|slices|hand|seams FILE.nrrd
 *
 * torso: an invented trunk of 2.5 mm voxels, with a skin one voxel thick, ribs, lungs with vessels
 * of one and two voxels, a windpipe whose wall is one voxel thick, heart and abdomen. slices: the
 * same in slices six times as thick as voxels are wide. hand: the same voxels as of slices, each
 * slice moved by up to a voxel and a fifth of its border flipped, as if drawn by hand. seams: a
 * ball of cells that meet three by three along lines and four by four in points. */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { AIR, SKIN, FAT, MUSCLE, RIBS, SPINE, DISCS, RIGHT_LUNG, LEFT_LUNG, LUNG_VESSELS, WINDPIPE };
enum { HEART_WALL = 11, HEART_CAVITY, CORONARIES, AORTA, LIVER, STOMACH, NODULES, TISSUES };
enum { CELLS = 12 };

static const char *const names[TISSUES] = {
    "",         "skin",       "fat",          "muscle",     "ribs",
    "spine",    "discs",      "right lung",   "left lung",  "lung vessels",
    "windpipe", "heart wall", "heart cavity", "coronaries", "aorta",
    "liver",    "stomach",    "nodules"};
static const char *const colors[TISSUES] = {
    "0 0 0",          "0.90 0.74 0.62", "0.93 0.84 0.55", "0.66 0.26 0.24", "0.93 0.90 0.82",
    "0.90 0.86 0.76", "0.55 0.70 0.80", "0.88 0.62 0.62", "0.80 0.55 0.60", "0.25 0.35 0.75",
    "0.35 0.70 0.55", "0.70 0.16 0.16", "0.45 0.05 0.10", "0.95 0.80 0.15", "0.85 0.20 0.15",
    "0.52 0.25 0.18", "0.80 0.55 0.35", "0.10 0.80 0.20"};

typedef struct point {
    double x, y, z;
} point;

/* Voxels: size, millimetres per voxel, and the label of each, x fastest. */
typedef struct grid {
    int size[3];
    double mm[3];
    uint8_t *labels;
} grid;

static uint64_t seed = 20;

/* @return a random number from 0 to below 1. */
static double chance(void)
{
    seed = seed * 6364136223846793005U + 1442695040888963407U;
    return (double)(seed >> 11) / 9007199254740992.0;
}

/* @return a random point of the cube from 0 to 1. */
static point any_point(void)
{
    const double x = chance(), y = chance(), z = chance();

    return (point){x, y, z};
}

static uint8_t *at(const grid *g, int x, int y, int z)
{
    return g->labels + ((size_t)z * (size_t)g->size[1] + (size_t)y) * (size_t)g->size[0] + x;
}

/* The middle of a voxel in mm: x to the right, y to the front, z upwards, 0 in the middle below. */
static point place(const grid *g, int x, int y, int z)
{
    return (point){(x - (g->size[0] - 1) / 2.0) * g->mm[0], (y - (g->size[1] - 1) / 2.0) * g->mm[1],
                   (z + 0.5) * g->mm[2]};
}

/* How far @p p is outside of an ellipsoid (below 0: within), about in mm. */
static double ellipsoid(point p, point middle, point radii)
{
    const double x = (p.x - middle.x) / radii.x, y = (p.y - middle.y) / radii.y;
    const double z = (p.z - middle.z) / radii.z;

    return (sqrt(x * x + y * y + z * z) - 1) * fmin(radii.x, fmin(radii.y, radii.z));
}

/* From 0 where @p v is below @p low to 1 where it is above @p high. */
static double step(double v, double low, double high)
{
    const double t = fmin(1, fmax(0, (v - low) / (high - low)));

    return t * t * (3 - 2 * t);
}

/* How far @p p is from the middle line of the aorta: up from the heart, an arch, and down. */
static double from_aorta(point p)
{
    const double turn = 26, middle = -14;

    if (p.z > 178)
        return hypot(hypot(p.y - middle, p.z - 178) - turn, p.x + 6);
    if (p.y > middle && p.z > 135)
        return hypot(p.y - middle - turn, p.x + 6);
    return hypot(p.y - middle + turn, p.x + 6);
}

static bool is_body(point p)
{
    const double shoulders = step(p.z, 190, 246);
    const double width = 142 + 6 * sin(p.z / 40) - 84 * shoulders;
    const double depth = 98 - 6 * step(p.z, 60, 130) - 42 * shoulders;

    return pow(fabs(p.x / width), 2.4) + pow(fabs(p.y / depth), 2.4) < 1;
}

/* The tissue of the heart and the aorta there; AIR: none of them. */
static int heart_at(point p)
{
    const double turned = p.x + 0.35 * (p.z - 120);
    const double wall =
        ellipsoid((point){turned, p.y, p.z}, (point){-16, 16, 120}, (point){46, 36, 40});

    if (from_aorta(p) < 10)
        return AORTA;
    if (wall < -9)
        return HEART_CAVITY;
    if (wall < 0)
        return HEART_WALL;
    if (wall < 2.5 && fmin(fabs(turned + 8 - 0.4 * p.y), fabs(p.z - 126 - 0.3 * p.y)) < 1.6)
        return CORONARIES;
    return AIR;
}

/* The tissue of the spine, its discs and its processes there; AIR: none of them. */
static int spine_at(point p)
{
    const double along = fmod(p.z + 300, 27), body = hypot(p.x, p.y + 58);
    const bool bone = along < 22;

    if (body < 17 - (bone ? 2 * sin(along / 22 * M_PI) : 0))
        return bone ? SPINE : DISCS;
    if (hypot(p.x, p.y + 80) < 7)
        return FAT; /* its canal */
    if (bone && along > 4 && along < 17 && fabs(p.x) < 3 && p.y < -80 && p.y > -93)
        return SPINE;
    if (bone && along > 6 && along < 13 && fabs(p.x) < 34 && fabs(p.y + 76) < 4)
        return SPINE;
    return AIR;
}

/* The tissue of the body there but for its skin and for vessels of the lungs. */
static int torso_at(point p)
{
    const double cage = ellipsoid(p, (point){0, -4, 78}, (point){112, 80, 150});
    const double rib = fabs(fmod(p.z + 0.38 * p.y + 400, 24) - 12);
    const double dome = 88 + 26 * exp(-(pow(fabs(p.x) - 52, 2) + p.y * p.y) / 2600);
    const double pipe = hypot(p.x - 4, p.y + 12 - 0.1 * (p.z - 170));
    int tissue;

    if (!is_body(p))
        return AIR;
    tissue = spine_at(p);
    if (tissue != AIR)
        return tissue;
    if (p.z > 172 && pipe < 9)
        return pipe < 6.5 ? AIR : WINDPIPE;
    tissue = cage < -5 || p.z > 150 ? heart_at(p) : AIR;
    if (tissue != AIR)
        return tissue;
    if (fabs(cage) < 4 && p.z > 30) {
        if (fabs(p.x) < 13 && p.y > 0)
            return p.z > 80 ? RIBS : MUSCLE;
        return rib < 4.5 && p.z < 216 ? RIBS : MUSCLE;
    }
    if (cage < -4 && p.z > dome)
        return fabs(p.x) < 16 ? FAT : p.x > 0 ? RIGHT_LUNG : LEFT_LUNG;
    if (cage < -6 && ellipsoid(p, (point){46, 4, 62}, (point){74, 58, 52}) < 0)
        return LIVER;
    if (cage < -6 && ellipsoid(p, (point){-56, 10, 58}, (point){36, 40, 44}) < 0)
        return STOMACH;
    if (cage > -6 && cage < 12 + 5 * sin(p.x / 30))
        return MUSCLE;
    return FAT;
}

/* Set the voxels of the lungs within @p radius_mm of @p p, and at least that in which it lies. */
static void draw_dot(grid *g, point p, double radius_mm)
{
    const double along[3] = {p.x, p.y, p.z};
    int low[3], high[3];

    for (int k = 0; k < 3; k++) {
        const double index = along[k] / g->mm[k] + (k < 2 ? (g->size[k] - 1) / 2.0 : -0.5);
        const double reach = fmax(0, radius_mm / g->mm[k] - 0.5);

        low[k] = (int)fmax(0, floor(index - reach + 0.5));
        high[k] = (int)fmin(g->size[k] - 1, floor(index + reach + 0.5));
    }
    for (int z = low[2]; z <= high[2]; z++) {
        for (int y = low[1]; y <= high[1]; y++) {
            for (int x = low[0]; x <= high[0]; x++) {
                uint8_t *label = at(g, x, y, z);

                if (*label == RIGHT_LUNG || *label == LEFT_LUNG)
                    *label = LUNG_VESSELS;
            }
        }
    }
}

/* Draw a straight vessel. */
static void draw_vessel(grid *g, point from, point to, double radius_mm)
{
    const point d = {to.x - from.x, to.y - from.y, to.z - from.z};
    const int steps = 1 + (int)(hypot(hypot(d.x, d.y), d.z) / 0.4);

    for (int n = 0; n <= steps; n++) {
        const double t = (double)n / steps;

        draw_dot(g, (point){from.x + t * d.x, from.y + t * d.y, from.z + t * d.z}, radius_mm);
    }
}

/* Draw a branch and, at its end, two thinner ones. */
static void draw_tree(grid *g, point from, point along, double radius_mm, int levels)
{
    const point to = {from.x + along.x, from.y + along.y, from.z + along.z};

    draw_vessel(g, from, to, radius_mm);
    for (int side = -1; side <= 1 && levels > 0; side += 2) {
        const double length = 0.82 * hypot(hypot(along.x, along.y), along.z);
        const point u = any_point();
        point next = {along.x + side * length * (u.x - 0.2), along.y + length * (1.6 * u.y - 0.8),
                      along.z + side * length * (0.9 * u.z + 0.2)};
        const double scale = length / hypot(hypot(next.x, next.y), next.z);

        next = (point){next.x * scale, next.y * scale, next.z * scale};
        draw_tree(g, to, next, 0.62 * radius_mm, levels - 1);
    }
}

/* Does a voxel of the body share a face with the air around it? */
static bool is_outermost(const grid *g, int x, int y, int z)
{
    if (!is_body(place(g, x, y, z)))
        return false;
    for (int n = 0; n < 6; n++) {
        const int side = n % 2 ? 1 : -1, up = z + (n / 2 == 2 ? side : 0);
        const int right = x + (n / 2 == 0 ? side : 0), front = y + (n / 2 == 1 ? side : 0);

        if (up >= 0 && up < g->size[2] && !is_body(place(g, right, front, up)))
            return true;
    }
    return false;
}

/* Set every voxel to what @p tissue_of says of it, as far as that is not below 0. */
static void fill(grid *g, int (*tissue_of)(const grid *g, int x, int y, int z))
{
    for (int z = 0; z < g->size[2]; z++) {
        for (int y = 0; y < g->size[1]; y++) {
            for (int x = 0; x < g->size[0]; x++) {
                const int tissue = tissue_of(g, x, y, z);

                if (tissue >= 0)
                    *at(g, x, y, z) = (uint8_t)tissue;
            }
        }
    }
}

static int torso_of(const grid *g, int x, int y, int z)
{
    return torso_at(place(g, x, y, z));
}

static int skin_of(const grid *g, int x, int y, int z)
{
    return is_outermost(g, x, y, z) ? SKIN : -1;
}

/* A ball of cells: each voxel is of the nearest of some points. */
static int cell_of(const grid *g, int x, int y, int z)
{
    const point p = place(g, x, y, z);
    double least = HUGE_VAL;
    int nearest = 0;

    seed = 20;
    for (int n = 0; n < CELLS; n++) {
        const point u = any_point(), q = {80 * u.x - 40, 80 * u.y - 40, 80 * u.z + 8};
        const double d = hypot(hypot(p.x - q.x, p.y - q.y), p.z - q.z);

        if (d < least)
            nearest = n + 1;
        least = fmin(least, d);
    }
    return hypot(hypot(p.x, p.y), p.z - 48) < 42 ? nearest : AIR;
}

/* What hands do: each slice is up to a voxel off, and a fifth of the voxels at borders are those of
 * a neighbour. */
static void draw_by_hand(grid *g)
{
    const size_t voxels = (size_t)g->size[0] * (size_t)g->size[1] * (size_t)g->size[2];
    grid old = *g;

    old.labels = malloc(voxels);
    memcpy(old.labels, g->labels, voxels);
    for (int z = 0; z < g->size[2]; z++) {
        const int right = (int)(3 * chance()) - 1, front = (int)(3 * chance()) - 1;

        for (int y = 2; y < g->size[1] - 2; y++) {
            for (int x = 2; x < g->size[0] - 2; x++) {
                const int other = chance() < 0.2 ? 1 : 0, upright = chance() < 0.5 ? 1 : 0;

                *at(g, x, y, z) =
                    *at(&old, x + right + other * upright, y + front + other * (1 - upright), z);
            }
        }
    }
    free(old.labels);
}

static void fill_torso(grid *g, bool by_hand)
{
    fill(g, torso_of);
    for (int side = -1; side <= 1; side += 2) {
        for (int n = 0; n < 4; n++)
            draw_tree(g, (point){side * 15, -6, 140 + 8 * n},
                      (point){side * 22, 10 * n - 14, 9 * n - 16}, 2.8, 6);
    }
    for (int n = 0; n < 60; n++) { /* single voxels */
        const point u = any_point();
        uint8_t *label =
            at(g, (int)(u.x * g->size[0]), (int)(u.y * g->size[1]), (int)(u.z * g->size[2]));

        if (*label == RIGHT_LUNG || *label == LEFT_LUNG)
            *label = NODULES;
    }
    fill(g, skin_of);
    if (by_hand)
        draw_by_hand(g);
}

/* @return whether all could be written. */
static bool write_nrrd(const char *path, const grid *g, bool named)
{
    const size_t voxels = (size_t)g->size[0] * (size_t)g->size[1] * (size_t)g->size[2];
    FILE *file = fopen(path, "wb");
    bool ok;

    if (!file)
        return false;
    fprintf(
        file,
        "NRRD0004\ntype: uchar\ndimension: 3\nspace: right-anterior-superior\nsizes: %d %d %d\n"
        "space directions: (%g,0,0) (0,%g,0) (0,0,%g)\nspace origin: (%g,%g,0)\nencoding: raw\n",
        g->size[0], g->size[1], g->size[2], g->mm[0], g->mm[1], g->mm[2],
        -(g->size[0] - 1) / 2.0 * g->mm[0], -(g->size[1] - 1) / 2.0 * g->mm[1]);
    for (int n = 1; n < TISSUES && named; n++)
        fprintf(file,
                "Segment%d_ID:=s%d\nSegment%d_LabelValue:=%d\nSegment%d_Name:=%s\nSegment%d_Color:="
                "%s\n",
                n - 1, n, n - 1, n, n - 1, names[n], n - 1, colors[n]);
    fputc('\n', file);
    ok = fwrite(g->labels, 1, voxels, file) == voxels;
    return fclose(file) == 0 && ok;
}

int main(int argc, char **argv)
{
    const char *what = argc == 3 ? argv[1] : "";
    const bool seams = !strcmp(what, "seams"), cubes = seams || !strcmp(what, "torso");
    const bool by_hand = !strcmp(what, "hand");
    grid g = {.size = {248, 168, 37}, .mm = {1.25, 1.25, 7.5}};
    bool ok;

    if (!cubes && !by_hand && strcmp(what, "slices") != 0) {
        fprintf(stderr, "usage: hard_volume torso|slices|hand|seams FILE.nrrd\n");
        return 64;
    }
    if (cubes)
        g = (grid){.size = {124, 84, 112}, .mm = {2.5, 2.5, 2.5}};
    if (seams)
        g = (grid){.size = {64, 64, 64}, .mm = {1.5, 1.5, 1.5}};
    g.labels = calloc((size_t)g.size[0] * (size_t)g.size[1], (size_t)g.size[2]);
    if (seams)
        fill(&g, cell_of);
    else
        fill_torso(&g, by_hand);
    ok = write_nrrd(argv[2], &g, !seams);
    free(g.labels);
    return ok ? 0 : 73;
}
