/* SPDX-License-Identifier: BSD-3-Clause */
/* FreeSurfer's MGH (.mgh) and the same compressed (.mgz): a header of 284 bytes, the voxels, and
 * tags (mgh_tags.c); all numbers have the highest byte first. Source: FreeSurfer's
 * description of the format (FsTutorial, MghFormat). */
#include "bytes.h"
#include "tables/label_table.h"

enum {
    HEADER_BYTES = 284,
    AT_SIZE = 4,        /* width, height, depth, frames */
    AT_TYPE = 20,       /* after which come the degrees of freedom */
    AT_GOOD = 28,       /* 2 bytes: whether the geometry is given */
    AT_SPACING = 30,    /* 3 floats, in mm */
    AT_DIRECTIONS = 42, /* 3 x 3 floats: right, anterior, superior of each voxel axis */
    AT_CENTRE = 78      /* 3 floats: where voxel (width, height, depth) / 2 lies, in RAS mm */
};

static int32_t whole_at(const unsigned char *h, size_t at)
{
    return (int32_t)sc_number_at(h + at, 4, true);
}

static double real_at(const unsigned char *h, size_t at)
{
    const uint32_t bits = (uint32_t)sc_number_at(h + at, 4, true);
    float value;

    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Write the type of the voxels to *out. @return SC_ERR_DATA for types that hold no labels. */
static sc_status voxel_type(const sc_ctx *ctx, const char *path, int32_t type, sc_voxel_type *out)
{
    static const int types[SC_VOXEL_TYPES] = {-1, 0, 4, 10, 1, -1, -1, -1, 3, -1};

    if (sc_voxel_type_coded(type, types, out))
        return SC_OK;
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s: its type is %d, expected 0, 1, 3, 4 or 10 (MGH: bytes, integers, floats, "
                   "short integers); convert it with `mri_convert -odt int -rt nearest IN OUT.mgz`",
                   path, type);
}

/* Set size and file of @p source, whose type is set. @return SC_ERR_DATA for a size that cannot
 * be, more frames than one, or more voxels than the file can hold. */
static sc_status find_voxels(const sc_ctx *ctx, const char *path, const unsigned char *h,
                             sc_source *source)
{
    const size_t each = sc_voxel_type_bytes(source->type);
    const int32_t frames = whole_at(h, AT_SIZE + 12);
    int64_t size[3];
    size_t voxels;

    if (frames != 1)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: has %d frames, expected one; extract one with `mri_convert --frame 0 IN "
            "OUT.mgz`",
            path, frames);
    for (size_t i = 0; i < 3; i++)
        size[i] = whole_at(h, AT_SIZE + 4 * i);
    SC_PASS(sc_grid_voxels(ctx, path, size, each, source->size, &voxels));
    SC_PASS(sc_check_file_bytes(ctx, path, HEADER_BYTES + (double)voxels * (double)each));
    return sc_path_join(ctx, "", path, &source->stored.file);
}

/* Set to_ras_mm and oriented of @p source, whose size is set. A file without geometry is coronal
 * with voxels of 1 mm, as FreeSurfer takes it. */
static void geometry(const sc_ctx *ctx, const char *path, const unsigned char *h, sc_source *source)
{
    static const double coronal[3][3] = {{-1, 0, 0}, {0, 0, -1}, {0, 1, 0}}; /* [axis][R, A, S] */
    const bool given = h[AT_GOOD] || h[AT_GOOD + 1];

    if (!given)
        sc_warn(ctx,
                "%s: does not give its geometry; read as FreeSurfer does, as coronal slices with "
                "voxels of 1 mm",
                path);
    source->oriented = true;
    for (size_t row = 0; row < 3; row++) {
        double *m = source->to_ras_mm.m[row];

        m[3] = given ? real_at(h, AT_CENTRE + 4 * row) : 0;
        for (size_t i = 0; i < 3; i++) {
            m[i] = given ? real_at(h, AT_DIRECTIONS + 12 * i + 4 * row) *
                               real_at(h, AT_SPACING + 4 * i)
                         : coronal[i][row];
            m[3] -= m[i] * source->size[i] / 2;
        }
    }
}

sc_status sc_open_mgh(const sc_ctx *ctx, const char *path, sc_source *out)
{
    unsigned char h[HEADER_BYTES] = {0};
    size_t count;
    SC_OWN(sc_source_clear)
    sc_source source = {
        .slope = 1, .stored.encoding = SC_ENCODING_GZIP, .stored.skip_bytes = HEADER_BYTES};

    SC_PASS(sc_read_header_bytes(ctx, path, "MGH", h, HEADER_BYTES, HEADER_BYTES, &count));
    SC_PASS(voxel_type(ctx, path, whole_at(h, AT_TYPE), &source.type));
    SC_PASS(find_voxels(ctx, path, h, &source));
    geometry(ctx, path, h, &source);
    SC_PASS(sc_mgh_labels(ctx, path,
                          HEADER_BYTES + (uint64_t)sc_source_voxels(&source) *
                                             sc_voxel_type_bytes(source.type),
                          &source.table));
    source.stored.swapped = sc_voxel_type_bytes(source.type) > 1 && SC_IS_LITTLE_ENDIAN;
    SC_HAND_OVER(source, out);
    return SC_OK;
}
