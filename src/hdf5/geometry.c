/* SPDX-License-Identifier: BSD-3-Clause */
/* Where the voxels lie, and what their numbers stand for, by the layouts of the programs that write
 * volumes as HDF5. Sources: itkHDF5ImageIO.cxx of ITK; the MINC 2.0 file format reference
 * (libminc); h5 files of Fiji, ilastik and PlantSeg (element_size_um); the CREMI challenge
 * (resolution). */
#include "program.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define MINC "/minc-2.0"

enum { SLICES_MAX = 1 << 16 /* of MINC, that may have a scale each */ };

/* ---- numbers in datasets ---- */

/* Read a dataset of numbers. @return how many there are, at most @p most; 0 if there are more, or
 * none. */
static int read_dataset(hid_t file, const char *path, int most, double *out, answer *a)
{
    const hid_t dataset =
        H5Oexists_by_name(file, path, H5P_DEFAULT) > 0 ? open_object(file, path, a) : -1;
    hid_t space, type;
    hssize_t count = 0;

    if (dataset < 0 || H5Iget_type(dataset) != H5I_DATASET) {
        if (dataset >= 0)
            H5Oclose(dataset);
        return 0;
    }
    space = H5Dget_space(dataset);
    type = H5Dget_type(dataset);
    if (H5Tget_class(type) == H5T_INTEGER || H5Tget_class(type) == H5T_FLOAT)
        count = H5Sget_simple_extent_npoints(space);
    if (count < 0 || count > most ||
        (count && H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, out) < 0))
        count = 0;
    H5Tclose(type);
    H5Sclose(space);
    H5Oclose(dataset);
    return (int)count;
}

/* ---- ITK ---- */

/* @return whether the dataset @p path is the image of a file of ITK; then its geometry, of which
 * the axes are those of the stream, and which is in LPS, is set. */
static bool itk_geometry(hid_t file, const char *path, answer *a)
{
    static const char name[] = "/VoxelData";
    const size_t length = strlen(path), n = strlen(name);
    double spacing_mm[3], origin_mm[3], directions[9];
    char other[SC_HDF5_TEXT_BYTES + 16];
    const struct {
        const char *name;
        double *out;
        int count;
    } parts[] = {
        {"/Spacing", spacing_mm, 3}, {"/Origin", origin_mm, 3}, {"/Directions", directions, 9}};

    if (length <= n || strcmp(path + length - n, name) != 0)
        return false;
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        snprintf(other, sizeof other, "%.*s%s", (int)(length - n), path, parts[i].name);
        if (read_dataset(file, other, parts[i].count, parts[i].out, a) != parts[i].count)
            return false;
    }
    for (int row = 0; row < 3; row++) {
        const double sign = row < 2 ? -1 : 1;

        for (int i = 0; i < 3; i++) /* a row of the directions is that of an axis */
            a->head.to_ras_mm[row][i] = sign * directions[3 * i + row] * spacing_mm[i] + 0.;
        a->head.to_ras_mm[row][3] = sign * origin_mm[row] + 0.; /* no -0 */
    }
    a->head.flags |= SC_HDF5_SPACED | SC_HDF5_ORIENTED;
    return true;
}

/* ---- MINC ---- */

/* Add to the geometry what a dimension of MINC says of the axis @p i of the stream. */
static bool minc_axis(hid_t file, const char *name, int i, answer *a)
{
    static const char *const names[] = {"xspace", "yspace", "zspace"};
    double start = 0, step = 1, cosines[3] = {0, 0, 0};
    char path[320];
    hid_t dimension;

    for (int k = 0; k < 3; k++)
        cosines[k] = !strcmp(name, names[k]);
    if (cosines[0] + cosines[1] + cosines[2] != 1)
        return false;
    snprintf(path, sizeof path, MINC "/dimensions/%s", name);
    dimension = H5Oexists_by_name(file, path, H5P_DEFAULT) > 0 ? open_object(file, path, a) : -1;
    if (dimension < 0)
        return false;
    (void)read_numbers(dimension, "start", 1, &start);
    (void)read_numbers(dimension, "step", 1, &step);
    (void)read_numbers(dimension, "direction_cosines", 3, cosines);
    H5Oclose(dimension);
    for (int row = 0; row < 3; row++) {
        a->head.to_ras_mm[row][i] = cosines[row] * step;
        a->head.to_ras_mm[row][3] += cosines[row] * start;
    }
    return true;
}

/* Set the geometry of a volume of MINC by the names of its dimensions, slowest first, as the
 * attribute dimorder lists them. */
static bool minc_geometry(hid_t file, const volume *v, answer *a)
{
    char order[256], *at = order;

    if (!read_text(v->dataset, "dimorder", order, sizeof order))
        return say(a, SC_HDF5_DAMAGED, "a volume of MINC without the attribute dimorder");
    for (int dimension = 0; dimension < v->rank; dimension++) {
        const size_t length = strcspn(at, ",");
        char *next = at + length + (at[length] == ',');
        bool done = true;

        at[length] = '\0';
        for (int i = 0; i < 3 && done; i++) {
            if (v->axis[i] == dimension)
                done = minc_axis(file, at, i, a);
        }
        if (!done)
            return say(a, SC_HDF5_DAMAGED,
                       "its dimension %d is \"%.60s\" (MINC, dimorder), expected xspace, yspace or "
                       "zspace, described in " MINC "/dimensions",
                       dimension, at);
        at = next;
    }
    a->head.flags |= SC_HDF5_SPACED | SC_HDF5_ORIENTED;
    return true;
}

/* The least and the largest value that voxels of a type may have, where MINC gives no valid_range.
 */
static void range_of(sc_hdf5_type type, double range[2])
{
    const int bits = 8 << type / 2;
    const bool is_signed = type % 2 == 0;

    range[0] = is_signed ? -ldexp(1, bits - 1) : 0;
    range[1] = ldexp(1, bits - is_signed) - 1;
}

/* Set the scale of a volume of integers of MINC: valid_range stands for what lies between image-min
 * and image-max, which may be given for each slice, but have to be the same for labels. */
static bool minc_scale(hid_t file, const char *path, const volume *v, answer *a)
{
    static double least[SLICES_MAX], most[SLICES_MAX];
    const int length = (int)(strlen(path) - strlen("/image"));
    char other[SC_HDF5_TEXT_BYTES + 16];
    double range[2], slope, intercept;
    int count;

    if (v->type >= SC_HDF5_FLOAT)
        return true;
    range_of(v->type, range);
    (void)read_numbers(v->dataset, "valid_range", 2, range);
    snprintf(other, sizeof other, "%.*s/image-min", length, path);
    count = read_dataset(file, other, SLICES_MAX, least, a);
    snprintf(other, sizeof other, "%.*s/image-max", length, path);
    if (count == 0 || read_dataset(file, other, SLICES_MAX, most, a) != count ||
        range[0] == range[1])
        return true;
    for (int i = 0; i < count; i++) {
        slope = (most[i] - least[i]) / (range[1] - range[0]);
        intercept = least[i] - slope * range[0];
        /* rounded: programs compute the limits in single precision */
        slope = fabs(slope - 1) < 1e-6 ? 1 : slope;
        intercept = fabs(intercept - rint(intercept)) < 1e-3 ? rint(intercept) : intercept;
        if (i == 0) {
            a->head.slope = slope;
            a->head.intercept = intercept;
        } else if (slope != a->head.slope || intercept != a->head.intercept) {
            return say(a, SC_HDF5_DAMAGED,
                       "slice %d has another scale than slice 0 (MINC, image-max), as images have; "
                       "expected one for all: write it as labels, for example by mincreshape "
                       "-image_range 0 255 -valid_range 0 255",
                       i);
        }
    }
    return true;
}

/* ---- attributes ---- */

/* @return which of x, y and z the axis @p i of the stream is. */
static int row_of(const volume *v, int i)
{
    return v->names[i] - 'x';
}

/* Set the geometry of voxels of so many mm along x, y, z, in the directions of RAS. */
static void set_spacing(const volume *v, const double spacing_mm[3], const double origin_mm[3],
                        answer *a)
{
    for (int i = 0; i < 3; i++)
        a->head.to_ras_mm[row_of(v, i)][i] = spacing_mm[row_of(v, i)];
    for (int row = 0; row < 3; row++)
        a->head.to_ras_mm[row][3] = origin_mm[row];
}

/* Set the geometry by attributes of the dataset, in units of @p mm, along z, y, x. @return whether
 * they are there. */
static bool by_attributes(const volume *v, const char *spacing, const char *origin, double mm,
                          answer *a)
{
    double given[2][3] = {{0}}, found[2][3];

    if (read_numbers(v->dataset, spacing, 3, given[0]) != 3)
        return false;
    if (origin && read_numbers(v->dataset, origin, 3, given[1]) != 3)
        memset(given[1], 0, sizeof given[1]);
    for (int i = 0; i < 3; i++) {
        found[0][i] = given[0][2 - i] * mm;
        found[1][i] = given[1][2 - i] * mm;
    }
    set_spacing(v, found[0], found[1], a);
    a->head.flags |= SC_HDF5_SPACED;
    return true;
}

bool find_geometry(hid_t file, const char *path, const volume *v, answer *a)
{
    static const double none[3] = {0, 0, 0}, one[3] = {1, 1, 1};

    a->head.slope = 1;
    if (!strncmp(path, MINC "/image/", strlen(MINC "/image/")) &&
        strncmp(path, MINC "/image/0/", strlen(MINC "/image/0/")) != 0)
        return say(a, SC_HDF5_DAMAGED,
                   "%.200s is a coarser copy (MINC), whose place is not known; give " MINC
                   "/image/0/image",
                   path);
    if (!strncmp(path, MINC "/image/", strlen(MINC "/image/")))
        return minc_geometry(file, v, a) && minc_scale(file, path, v, a);
    if (!itk_geometry(file, path, a) && !by_attributes(v, "element_size_um", NULL, 1e-3, a) &&
        !by_attributes(v, "resolution", "offset", 1e-6, a))
        set_spacing(v, one, none, a);
    return true;
}
