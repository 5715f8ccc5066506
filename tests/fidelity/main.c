/* SPDX-License-Identifier: BSD-3-Clause */
/* Measures how far drawn surfaces are from the true ones. */
#include "fidelity.h"

#include <getopt.h>
#include <stdlib.h>
#include <string.h>

static const char usage[] =
    "usage: fidelity [--json] [--surface smooth|voxel] [--smooth S] [SHAPE...]\n"
    "       fidelity [--json] --mesh FILE SHAPE     a PLY or STL mesh of that shape, in mm\n"
    "       fidelity --write FILE.nrrd SHAPE        the voxels of a shape, for other programs\n"
    "shapes: ellipsoid torus-6 torus-3 torus-1.5 torus-1 (default: these) phantom\n";

/* The command line. mesh and write are NULL unless given. */
typedef struct options {
    bool json;
    sc_surface surface;
    double smooth;
    const char *mesh, *write;
} options;

/* Print a member of a JSON object, followed by a comma unless @p last; null for what was not
 * measured. */
static void print_value(const char *name, double value, bool last)
{
    if (isnan(value) || value < 0)
        printf("\"%s\": null%s", name, last ? "" : ", ");
    else
        printf("\"%s\": %.6g%s", name, value, last ? "" : ", ");
}

/* Print one element of the JSON array of shapes, preceded by a comma unless @p first. */
static void print_json(const shape *s, const fidelity *f, bool first)
{
    printf("%s  {\"shape\": \"%s\", ", first ? "" : ",\n", s->name);
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

/* Print a row of the table; its columns are those of the head in main(). */
static void print_row(const shape *s, const fidelity *f)
{
    printf("%-10s", s->name);
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

/* Measure the shape @p name as the options say and print its row or JSON element, or write its
 * voxels to a file. @p first: nothing has been printed before. @return SC_ERR_USAGE for an
 * unknown name; errors of measuring, with a message. */
static sc_status measure(const sc_ctx *ctx, const options *o, const char *name, bool first)
{
    const shape *known = shape_find(name);
    shape s;
    fidelity f = {0};
    sc_volume volume = {0};
    sc_status status = SC_OK;

    if (!known)
        return sc_fail(ctx, SC_ERR_USAGE, "unknown shape \"%s\"\n%s", name, usage);
    s = *known;
    if (!strcmp(name, "phantom")) {
        SC_TRY(sc_phantom_new(ctx, &s.phantom));
        s.voxel_mm = 1.0 / 3;
    }
    if (o->write) {
        SC_TRY(shape_volume(ctx, &s, sc_default_threads(), &volume));
        SC_TRY(sc_volume_save_nrrd(ctx, &volume, o->write, true));
        goto out;
    }
    if (o->mesh)
        SC_TRY(measure_mesh(ctx, &s, o->mesh, &f));
    else
        SC_TRY(measure_volume(ctx, &s, o->surface, o->smooth, sc_default_threads(), &f));
    if (o->json)
        print_json(&s, &f, first);
    else
        print_row(&s, &f);
    fflush(stdout);
out:
    sc_volume_clear(&volume);
    sc_phantom_free(s.phantom);
    return status;
}

/* Read the options of the command line; the shapes that follow start at optind. @return false if
 * they are wrong, or --mesh or --write comes with other than one shape. */
static bool parse(int argc, char **argv, options *o)
{
    static const struct option known[] = {{"json", no_argument, NULL, 'j'},
                                          {"surface", required_argument, NULL, 'f'},
                                          {"smooth", required_argument, NULL, 's'},
                                          {"mesh", required_argument, NULL, 'm'},
                                          {"write", required_argument, NULL, 'w'},
                                          {"help", no_argument, NULL, 'h'},
                                          {0}};
    char *end;
    int c;

    while ((c = getopt_long(argc, argv, "", known, NULL)) != -1) {
        if (c == 'j')
            o->json = true;
        else if (c == 'f' && (!strcmp(optarg, "smooth") || !strcmp(optarg, "voxel")))
            o->surface = optarg[0] == 's' ? SC_SURFACE_SMOOTH : SC_SURFACE_VOXEL;
        else if (c == 's' && (o->smooth = strtod(optarg, &end),
                              !*end && o->smooth >= 0 && o->smooth <= SC_SMOOTH_MAX))
            continue;
        else if (c == 'm')
            o->mesh = optarg;
        else if (c == 'w')
            o->write = optarg;
        else
            return false;
    }
    return !(o->mesh || o->write) || argc - optind == 1;
}

int main(int argc, char **argv)
{
    const sc_ctx ctx = {.level = SC_LOG_WARN, .rank = -1, .write = sc_log_to_stderr};
    options o = {.surface = SC_SURFACE_SMOOTH, .smooth = 1};
    sc_status status = SC_OK;
    int first = 1;

    if (!parse(argc, argv, &o)) {
        fputs(usage, stderr);
        return 64;
    }
    if (o.json)
        printf("{\"schema\": \"segcast-fidelity-1\", \"shapes\": [\n");
    else if (!o.write)
        printf("%-10s %9s %9s %9s %9s %9s %9s %9s %9s\n", "shape", "pos. rms", "95 %", "max",
               "norm. deg", "volume %", "owner ppm", "outline", "gaps");
    for (int i = optind; i < argc && status == SC_OK; i++, first = 0)
        status = measure(&ctx, &o, argv[i], first);
    for (size_t i = 0; i + 1 < shape_count && optind == argc && status == SC_OK; i++, first = 0)
        status = measure(&ctx, &o, shapes[i].name, first);
    if (o.json)
        printf("\n]}\n");
    return status == SC_OK ? 0 : status == SC_ERR_USAGE ? 64 : 65;
}
