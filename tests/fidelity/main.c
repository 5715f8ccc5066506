/* SPDX-License-Identifier: BSD-3-Clause */
/* Measures how far drawn surfaces are from the true ones. */
#include "rulers.h"

#include <getopt.h>
#include <stdlib.h>
#include <string.h>

static const char usage[] =
    "usage: fidelity [--json] [--surface smooth|voxel] [--smooth S|auto] [--rays N] [SHAPE...]\n"
    "       fidelity [--json] --mesh FILE SHAPE     a PLY or STL mesh of that shape, in mm\n"
    "       fidelity --write FILE.nrrd SHAPE        the voxels of a shape, for other programs\n"
    "       fidelity [--json] [--smooth S|auto] [--rays N] --skin LABEL VOLUME\n"
    "                                               rays that get through the closed skin LABEL\n"
    "       fidelity [--json] [--surface smooth|voxel] [--smooth S|auto] --wobble VOLUME\n"
    "                                               how outlines and seams waver, in voxels\n"
    "       fidelity [--json] [--surface smooth|voxel] [--smooth S|auto] --lines\n"
    "                                               lines and points one voxel thick\n"
    "       fidelity [--json] [--surface smooth|voxel] [--smooth S|auto] --edges\n"
    "                                               sharp edges, and thin tissue on thick one\n"
    "       fidelity [--json] [--smooth S] --locality HALO VOLUME\n"
    "                                               crops of a volume, HALO voxels larger than "
    "what\n"
    "                                               is compared, against the whole\n"
    "       fidelity [--json] [--surface smooth|voxel] [--smooth S|auto] --cliffs\n"
    "                                               steps of growing noise and strength\n"
    "shapes:  ellipsoid torus-6 torus-3 torus-1.5 torus-1 (default: these)\n"
    "voxels half as high again as wide: ellipsoid-tall\n"
    "slices six times as thick as voxels are wide: ellipsoid-slices torus-18-slices\n"
    "         torus-12-slices torus-6-slices\n"
    "voxels of 4 mm copied up to 1 mm: ellipsoid-copied torus-18-copied torus-12-copied\n"
    "         torus-6-copied; with a tenth of the voxels at the border flipped: ellipsoid-noisy\n"
    "         torus-18-noisy torus-12-noisy\n"
    "skins one voxel thick, by --rays rays (2500000): skin-ellipsoid skin-balls skin-planes\n"
    "         skin-rough; in slices, 1 : 2.7 : 6.4: the same names with -slices\n";

/* The command line. mesh, write and skin are NULL unless given. */
typedef struct options {
    bool json;
    drawing how;
    size_t rays;
    const char *mesh, *write, *skin;
    sc_status (*ruler)(const sc_ctx *ctx, const ruling *r); /* NULL: none */
    int halo;                                               /* of --locality; 0: not given */
} options;

void print_value(const char *name, double value, bool last)
{
    if (isnan(value) || value < 0)
        printf("\"%s\": null%s", name, last ? "" : ", ");
    else
        printf("\"%s\": %.6g%s", name, value, last ? "" : ", ");
}

/* Print one element of the JSON array of shapes. */
static void print_json(const shape *s, const fidelity *f)
{
    printf("  {\"shape\": \"%s\", ", s->name);
    print_value("position_rms_voxels", f->position_rms, false);
    print_value("position_95_voxels", f->position_95, false);
    print_value("position_max_voxels", f->position_max, false);
    print_value("normal_rms_deg", f->normal_rms, false);
    print_value("volume_kept", f->volume_kept, false);
    print_value("owner_errors_per_million", f->owner_errors, false);
    print_value("silhouette_voxels", f->silhouette, false);
    print_value("gaps", f->gaps, false);
    print_value("hits", (double)f->hits, true);
    printf("}");
}

/* Print @p value times @p scale as a cell of the table, with @p digits decimals; "-" for what
 * was not measured. */
static void print_cell(double value, int digits, double scale)
{
    if (isnan(value) || value < 0)
        printf(" %9s", "-");
    else
        printf(" %9.*f", digits, value * scale);
}

/* Print a row of the table; its columns are those of print_head. */
static void print_row(const shape *s, const fidelity *f)
{
    printf("%-16s", s->name);
    print_cell(f->position_rms, 3, 1);
    print_cell(f->position_95, 3, 1);
    print_cell(f->position_max, 3, 1);
    print_cell(f->normal_rms, 2, 1);
    print_cell(f->volume_kept, 1, 100);
    print_cell(f->owner_errors, 0, 1);
    print_cell(f->silhouette, 3, 1);
    print_cell(f->gaps, 0, 1);
    printf("\n");
}

/* Print the head of the table whose rows print_row (@p of_skins: print_leaks) prints. */
static void print_head(bool of_skins)
{
    if (of_skins)
        printf("%-22s %14s %12s %12s %12s\n", "skin", "leaks/million", "not skin %", "rays",
               "without skin");
    else
        printf("%-16s %9s %9s %9s %9s %9s %9s %9s %9s\n", "shape", "pos. rms", "95 %", "max",
               "norm. deg", "volume %", "owner ppm", "outline", "gaps");
}

/* Print what rays have met of a skin as a row of the table or, with @p json, as an element of the
 * array of shapes. */
static void print_leaks(const char *name, const leaks *l, bool json)
{
    const double leaking = l->rays > 0 ? 1e6 * l->leaking / l->rays : NAN;
    const double share = l->hits > 0 ? l->leaking / l->hits : NAN;

    if (!json) {
        printf("%-22s %14.1f %12.4f %12.0f %12.0f\n", name, leaking, 100 * share, l->rays, l->bare);
        return;
    }
    printf("  {\"shape\": \"%s\", ", name);
    print_value("leaks_per_million", leaking, false);
    print_value("not_skin_share", share, false);
    print_value("rays_through", l->rays, false);
    print_value("rays_without_skin", l->bare, false);
    print_value("hits", l->hits, true);
    printf("}");
}

/* Count the leaks of a skin of the table, or write the voxels of its first variant to a file. */
static sc_status run_skin(const sc_ctx *ctx, const options *o, const skin *k)
{
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    leaks l = {0};

    if (o->mesh)
        return sc_fail(ctx, SC_ERR_USAGE, "meshes of skins are not measured");
    if (o->write) {
        SC_PASS(skin_volume(ctx, k, 0, &volume));
        return sc_volume_save_nrrd(ctx, &volume, o->write, true);
    }
    SC_PASS(measure_skin(ctx, k, &o->how, o->rays, &l));
    print_leaks(k->name, &l, o->json);
    return SC_OK;
}

/* Count the leaks of the label o->skin of a volume file. @return SC_ERR_USAGE if it has no such
 * label; errors of reading and measuring. */
static sc_status run_skin_of_file(const sc_ctx *ctx, const options *o, const char *path)
{
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    leaks l = {0};
    int id;

    SC_PASS(sc_volume_read(ctx, path, &volume));
    for (id = volume.label_count - 1; id > 0; id--) {
        if (volume.labels[id].value == strtoll(o->skin, NULL, 10))
            break;
    }
    if (id <= 0)
        return sc_fail(ctx, SC_ERR_USAGE, "%s: no label %s", path, o->skin);
    SC_PASS(count_leaks(ctx, &volume, id, &o->how, 1, o->rays, &l));
    print_leaks(path, &l, o->json);
    return SC_OK;
}

/* Measure a shape of the table as the options say and print its row or JSON element, or write its
 * voxels to a file. @return errors of measuring, with a message. */
static sc_status run_shape(const sc_ctx *ctx, const options *o, const shape *s)
{
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    fidelity f = {0};

    if (o->write) {
        SC_PASS(shape_volume(ctx, s, o->how.threads, &volume));
        return sc_volume_save_nrrd(ctx, &volume, o->write, true);
    }
    SC_PASS(o->mesh ? measure_mesh(ctx, s, o->mesh, &f) : measure_volume(ctx, s, &o->how, &f));
    if (o->json)
        print_json(s, &f);
    else
        print_row(s, &f);
    return SC_OK;
}

/* Measure what the argument @p name stands for: a shape or a skin of the tables, or a file.
 * @p before: the argument before it, NULL for the first. @return SC_ERR_USAGE for an unknown name;
 * errors of measuring, with a message. */
static sc_status measure(const sc_ctx *ctx, const options *o, const char *name, const char *before)
{
    const skin *k = skin_find(name);
    const shape *s = shape_find(name);
    const bool leaking = k || o->skin;
    sc_status status;

    if (!k && !s && !o->skin)
        return sc_fail(ctx, SC_ERR_USAGE, "unknown shape \"%s\"; --help lists them", name);
    if (o->json && before)
        printf(",\n");
    if (!o->json && !o->write && (!before || (!o->skin && leaking != !!skin_find(before))))
        print_head(leaking);
    if (o->skin)
        status = run_skin_of_file(ctx, o, name);
    else
        status = k ? run_skin(ctx, o, k) : run_shape(ctx, o, s);
    fflush(stdout);
    return status;
}

/* Read a strength of smoothing, or auto, to @p how. @return false if the text is neither. */
static bool parse_smooth(const char *text, drawing *how)
{
    char *end;

    how->resample = !strcmp(text, "auto");
    if (how->resample) {
        how->smooth = 1;
        return true;
    }
    how->smooth = strtod(text, &end);
    return end != text && !*end && how->smooth >= 0 && how->smooth <= SC_SMOOTH_MAX;
}

/* Read the options of the command line; the shapes that follow start at optind. @return false if
 * they are wrong, or an option that takes one argument comes with another number of them. */
static bool parse(int argc, char **argv, options *o)
{
    static const struct option known[] = {
        {"json", no_argument, NULL, 'j'},           {"surface", required_argument, NULL, 'f'},
        {"smooth", required_argument, NULL, 's'},   {"rays", required_argument, NULL, 'r'},
        {"mesh", required_argument, NULL, 'm'},     {"write", required_argument, NULL, 'w'},
        {"skin", required_argument, NULL, 'k'},     {"wobble", no_argument, NULL, 'o'},
        {"lines", no_argument, NULL, 'l'},          {"edges", no_argument, NULL, 'e'},
        {"locality", required_argument, NULL, 'c'}, {"cliffs", no_argument, NULL, 'i'},
        {"help", no_argument, NULL, 'h'},           {0}};
    char *end;
    int c;

    while ((c = getopt_long(argc, argv, "", known, NULL)) != -1) {
        if (c == 'j')
            o->json = true;
        else if (c == 'f' && (!strcmp(optarg, "smooth") || !strcmp(optarg, "voxel")))
            o->how.surface = optarg[0] == 's' ? SC_SURFACE_SMOOTH : SC_SURFACE_VOXEL;
        else if (c == 's' && parse_smooth(optarg, &o->how))
            continue;
        else if (c == 'r' && (o->rays = strtoul(optarg, &end, 10), !*end && o->rays > 0))
            continue;
        else if (c == 'm')
            o->mesh = optarg;
        else if (c == 'w')
            o->write = optarg;
        else if (c == 'k')
            o->skin = optarg;
        else if (c == 'o')
            o->ruler = print_wobble;
        else if (c == 'l')
            o->ruler = print_lines;
        else if (c == 'e')
            o->ruler = print_edges;
        else if (c == 'i')
            o->ruler = print_cliffs;
        else if (c == 'c' && (o->halo = (int)strtol(optarg, &end, 10), !*end && o->halo > 0))
            o->ruler = print_locality;
        else
            return false;
    }
    if (o->ruler)
        return argc - optind == (o->ruler == print_wobble || o->ruler == print_locality);
    return !(o->mesh || o->write || o->skin) || argc - optind == 1;
}

int main(int argc, char **argv)
{
    const sc_ctx ctx = {.level = SC_LOG_WARN, .rank = -1, .write = sc_log_to_stderr};
    options o = {.how = {.surface = SC_SURFACE_SMOOTH, .smooth = 1}, .rays = 2500000};
    const char *before = NULL;
    sc_status status = SC_OK;

    o.how.threads = sc_default_threads();
    if (!parse(argc, argv, &o)) {
        fputs(usage, stderr);
        return 64;
    }
    if (o.ruler) {
        const ruling r = {.path = argv[optind], .halo = o.halo, .how = o.how, .json = o.json};

        return o.ruler(&ctx, &r) == SC_OK ? 0 : 65;
    }
    if (o.json)
        printf("{\"schema\": \"segcast-fidelity-1\", \"shapes\": [\n");
    for (int i = optind; i < argc && status == SC_OK; i++, before = argv[i - 1])
        status = measure(&ctx, &o, argv[i], before);
    for (size_t i = 0; i < IDEAL_SHAPES && optind == argc && status == SC_OK; i++) {
        status = measure(&ctx, &o, shapes[i].name, before);
        before = shapes[i].name;
    }
    if (o.json)
        printf("\n]}\n");
    return status == SC_OK ? 0 : status == SC_ERR_USAGE ? 64 : 65;
}
