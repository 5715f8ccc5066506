/* SPDX-License-Identifier: BSD-3-Clause */
/* NIfTI-1 and NIfTI-2. The header is checked here first, because nifticlib does not check what it
 * reads. nifticlib then interprets it (byte order, sform, qform), and the voxels are read here, so
 * that a short or damaged stream is noticed and no value is changed silently. */
#include "tables/label_table.h"

#include <nifti2_io.h>
#include <sys/stat.h>

enum { HEADER1_BYTES = 348, HEADER2_BYTES = 540 };

/* The fields that can mislead a reader, of either version of the header. */
typedef struct fields {
    int version; /* 1 or 2 */
    int64_t dim[8];
    double pixdim[8];
    int datatype, bitpix;
    double turn[6];      /* quatern_b, _c, _d, and qoffset_x, _y, _z */
    double voxel_offset; /* vox_offset, in bytes of the file that holds the voxels */
    char magic[4];
    unsigned char bytes[HEADER2_BYTES]; /* the header as it stands in the file */
} fields;

/* Copy the fields of a header of either version, which have the same names. */
#define COPY_FIELDS(header, out)                                                                   \
    do {                                                                                           \
        for (int i = 0; i < 8; i++) {                                                              \
            (out)->dim[i] = (header).dim[i];                                                       \
            (out)->pixdim[i] = (header).pixdim[i];                                                 \
        }                                                                                          \
        (out)->datatype = (header).datatype;                                                       \
        (out)->bitpix = (header).bitpix;                                                           \
        (out)->voxel_offset = (double)(header).vox_offset;                                         \
        memcpy((out)->magic, (header).magic, 4);                                                   \
        memcpy((out)->turn,                                                                        \
               (const double[]){(header).quatern_b, (header).quatern_c, (header).quatern_d,        \
                                (header).qoffset_x, (header).qoffset_y, (header).qoffset_z},       \
               sizeof(out)->turn);                                                                 \
    } while (0)

/* Fill *out, whose version is set, from the bytes of a header. @p swapped: it is in the byte order
 * that this machine does not have. */
static void fields_of_header(bool swapped, fields *out)
{
    nifti_1_header header1;
    nifti_2_header header2;

    if (out->version == 1) {
        memcpy(&header1, out->bytes, sizeof header1);
        if (swapped)
            nifti_swap_as_nifti1(&header1);
        COPY_FIELDS(header1, out);
    } else { /* NIfTI-2, which is larger and has wider fields */
        memcpy(&header2, out->bytes, sizeof header2);
        if (swapped)
            nifti_swap_as_nifti2(&header2);
        COPY_FIELDS(header2, out);
    }
}

/* Fill *out from the header of the file, in this machine's byte order. What is not of version 1
 * by its size field is taken for version 2, in the other byte order if that size is wrong, too:
 * check_magic refuses other files afterwards. @return SC_ERR_MISSING, SC_ERR_DATA if the file
 * is too short. */
static sc_status parse_header(const sc_ctx *ctx, const char *path, fields *out)
{
    int32_t size;
    size_t count = 0;

    SC_PASS(
        sc_read_header_bytes(ctx, path, "NIfTI", out->bytes, HEADER2_BYTES, HEADER1_BYTES, &count));
    memcpy(&size, out->bytes, sizeof size);
    out->version = size == HEADER1_BYTES || size == 0x5c010000 ? 1 : 2;
    if (out->version == 2 && count < HEADER2_BYTES)
        return sc_fail(ctx, SC_ERR_DATA, "%s: ends after %zu bytes, expected a header of %d", path,
                       count, HEADER2_BYTES);
    fields_of_header(size != (out->version == 1 ? HEADER1_BYTES : HEADER2_BYTES), out);
    return SC_OK;
}

/* Write the type of the voxels to *out. A bitpix that contradicts it gives a warning. @return
 * SC_ERR_DATA for types other than integers of 8 to 64 bits and floats of 32 and 64. */
static sc_status check_type(const sc_ctx *ctx, const char *path, const fields *f,
                            sc_voxel_type *out)
{
    static const int types[SC_VOXEL_TYPES] = {DT_INT8,    DT_UINT8,  DT_INT16, DT_UINT16,
                                              DT_INT32,   DT_UINT32, DT_INT64, DT_UINT64,
                                              DT_FLOAT32, DT_FLOAT64};

    if (sc_voxel_type_coded(f->datatype, types, out)) {
        const int bits = 8 * (int)sc_voxel_type_bytes(*out);

        if (f->bitpix != bits)
            sc_warn(ctx, "%s: bitpix is %d, datatype %d has %d; the datatype is used", path,
                    f->bitpix, f->datatype, bits);
        return SC_OK;
    }
    return sc_fail(ctx, SC_ERR_DATA, "%s: datatype is %d (%s), expected integers or floats", path,
                   f->datatype, nifti_datatype_string(f->datatype));
}

/* Fill size[3], with 1 for axes that the file does not have, and the phases of a file with several
 * times, the fourth dimension. @return SC_ERR_DATA if a number of dimensions or samples or a voxel
 * size cannot be used, or if a voxel has several values. */
static sc_status check_dims(const sc_ctx *ctx, const char *path, const fields *f, int64_t size[3],
                            int *phases)
{
    if (f->dim[0] < 1 || f->dim[0] > 7)
        return sc_fail(ctx, SC_ERR_DATA, "%s: dim[0] is %lld, expected 1 to 7", path,
                       (long long)f->dim[0]);
    for (int i = 1; i <= f->dim[0]; i++) {
        if (f->dim[i] < 1)
            return sc_fail(ctx, SC_ERR_DATA, "%s: dim[%d] is %lld, expected at least 1", path, i,
                           (long long)f->dim[i]);
        if (i > (f->dim[i] > INT32_MAX ? 3 : 4) && f->dim[i] > 1)
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s: dim[%d] is %lld: several values for a voxel, expected one volume, "
                           "or one for each time along dim[4]; extract one, for example with "
                           "nibabel",
                           path, i, (long long)f->dim[i]);
    }
    *phases = f->dim[0] > 3 ? (int)f->dim[4] : 1;
    for (int i = 0; i < 3; i++) {
        size[i] = i < f->dim[0] ? f->dim[i + 1] : 1;
        if (i < f->dim[0] && (!isfinite(f->pixdim[i + 1]) || f->pixdim[i + 1] == 0))
            return sc_fail(ctx, SC_ERR_DATA, "%s: pixdim[%d] is %g, expected a voxel size", path,
                           i + 1, f->pixdim[i + 1]);
    }
    return SC_OK;
}

/* @return SC_ERR_DATA unless the voxels begin at a whole byte, which in a single file (@p pair
 * false) lies behind the header. */
static sc_status check_offset(const sc_ctx *ctx, const char *path, const fields *f, bool pair)
{
    const double least = pair ? 0 : f->version == 1 ? HEADER1_BYTES + 4 : HEADER2_BYTES + 4;

    if (!isfinite(f->voxel_offset) || f->voxel_offset != floor(f->voxel_offset) ||
        f->voxel_offset < least || f->voxel_offset > 1e15)
        return sc_fail(ctx, SC_ERR_DATA, "%s: vox_offset is %g, expected a byte at or after %g",
                       path, f->voxel_offset, least);
    return SC_OK;
}

/* Set *pair: true if the voxels are in a file of their own beside the header. @return
 * SC_ERR_DATA if the file is not NIfTI of the version found. */
static sc_status check_magic(const sc_ctx *ctx, const char *path, const fields *f, bool *pair)
{
    static const char single[2][4] = {"n+1", "n+2"}, two[2][4] = {"ni1", "ni2"};

    if (!memcmp(f->magic, single[f->version - 1], 4))
        *pair = false;
    else if (!memcmp(f->magic, two[f->version - 1], 4))
        *pair = true;
    else
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: magic is \"%.3s\", expected \"%s\" or \"%s\" (ANALYZE 7.5 does not "
                       "say where left is)",
                       path, f->magic[0] >= ' ' && f->magic[0] < 127 ? f->magic : "?",
                       single[f->version - 1], two[f->version - 1]);
    return SC_OK;
}

/* Make the path of the file that holds the voxels: @p path itself or, of a pair, the .img
 * beside the .hdr. @return SC_ERR_DATA if that is not there, SC_ERR_MEMORY. Caller owns *out:
 * sc_free. */
static sc_status voxel_file(const sc_ctx *ctx, const char *path, bool pair, char **out)
{
    static const char *const endings[] = {".img", ".img.gz", ".IMG"};
    const char *dot = strstr(sc_file_name(path), ".hdr");
    struct stat info;
    uint64_t bytes;

    if (!pair)
        return sc_path_join(ctx, "", path, out);
    for (size_t i = 0; dot && i < SC_COUNT_OF(endings); i++) {
        SC_OWN(sc_text_clear) sc_text text = {0};

        SC_PASS(sc_text_add(ctx, &text, "%.*s%s", (int)(dot - path), path, endings[i]));
        if (!stat(text.data, &info))
            return sc_data_file(ctx, path, "the file of the voxels", sc_file_name(text.data), out,
                                &bytes);
    }
    return sc_fail(ctx, SC_ERR_DATA, "%s: is the header of a pair, but its .img is not there",
                   path);
}

/* Is the map finite, of plausible size, and invertible? */
static bool usable(const nifti_dmat44 *m)
{
    sc_affine a, inverse;

    for (int i = 0; i < 12; i++)
        a.m[i / 4][i % 4] = m->m[i / 4][i % 4];
    for (int i = 0; i < 12; i++) {
        if (!isfinite(a.m[i / 4][i % 4]) || fabs(a.m[i / 4][i % 4]) > 1e9)
            return false;
    }
    return sc_affine_invert(&a, &inverse);
}

/* @return whether the qform of the header is made of numbers: nifticlib takes others for 0. */
static bool has_turn(const fields *f)
{
    bool finite = true;

    for (int i = 0; i < 6; i++)
        finite = finite && isfinite(f->turn[i]);
    return finite;
}

/* Set to_ras_mm and oriented of @p source: by the sform if it is given and usable, else by the
 * qform likewise, else by the voxel sizes alone, which say nothing about orientation. Lengths
 * in m and um become mm; other units are taken for mm. An sform or qform that is not usable gives a
 * warning. */
static void geometry(const sc_ctx *ctx, const char *path, const fields *f, const nifti_image *nim,
                     sc_source *source)
{
    double mm = 1;
    const nifti_dmat44 *chosen = NULL;

    if (nim->xyz_units == NIFTI_UNITS_METER)
        mm = 1000;
    else if (nim->xyz_units == NIFTI_UNITS_MICRON)
        mm = 1e-3;
    if (nim->sform_code > 0 && usable(&nim->sto_xyz))
        chosen = &nim->sto_xyz;
    else if (nim->qform_code > 0 && has_turn(f) && usable(&nim->qto_xyz))
        chosen = &nim->qto_xyz;
    if (nim->sform_code > 0 && chosen != &nim->sto_xyz)
        sc_warn(ctx, "%s: sform is not a usable matrix; %s is used", path,
                chosen ? "qform" : "the voxel size alone");
    else if (nim->qform_code > 0 && !chosen)
        sc_warn(ctx, "%s: qform is not usable%s; the voxel size alone is used", path,
                has_turn(f) ? "" : ", its quaternion or offset is not a number");
    source->oriented = chosen != NULL;
    if (!chosen) {
        const double size[3] = {nim->dx, nim->dy, nim->dz};

        for (int i = 0; i < 3; i++)
            source->to_ras_mm.m[i][i] = size[i] != 0 ? fabs(size[i]) * mm : mm;
        return;
    }
    for (int i = 0; i < 12; i++)
        source->to_ras_mm.m[i / 4][i % 4] = mm * chosen->m[i / 4][i % 4];
}

/* @return the time from one phase to the next; 0: the header does not say. */
static double step_s(const nifti_image *nim)
{
    const double unit_s = nim->time_units == NIFTI_UNITS_SEC    ? 1
                          : nim->time_units == NIFTI_UNITS_MSEC ? 1e-3
                          : nim->time_units == NIFTI_UNITS_USEC ? 1e-6
                                                                : 0;

    return nim->dt > 0 && isfinite(nim->dt) ? nim->dt * unit_s : 0;
}

/* Set slope and intercept of @p source; a slope of 0 or that is not finite means no scaling. */
static void scaling(const nifti_image *nim, sc_source *source)
{
    const bool scaled = isfinite(nim->scl_slope) && nim->scl_slope != 0;

    source->slope = scaled ? nim->scl_slope : 1;
    source->intercept = scaled && isfinite(nim->scl_inter) ? nim->scl_inter : 0;
}

/* Set size, encoding and skip_bytes of @p source, whose type and file are set, after a check that
 * the file can hold as many voxels as the header promises. @return SC_ERR_DATA, SC_ERR_MISSING. */
static sc_status find_voxels(const sc_ctx *ctx, const fields *f, const int64_t size[3],
                             sc_source *source)
{
    const size_t each = sc_voxel_type_bytes(source->type);
    size_t voxels;

    SC_PASS(sc_grid_voxels(ctx, source->stored.file, size, each, source->size, &voxels));
    SC_PASS(sc_check_file_bytes(ctx, source->stored.file,
                                f->voxel_offset +
                                    (double)voxels * (double)each * source->series.count));
    source->stored.encoding = SC_ENCODING_GZIP;
    source->stored.skip_bytes = (uint64_t)f->voxel_offset;
    return SC_OK;
}

/* Let nifticlib interpret the header alone: it would also read the extensions, whose lengths it
 * believes; sc_nifti_labels reads them. @return an image of nifti_image_free; NULL if it cannot.
 */
static nifti_image *interpret(const fields *f, const char *path)
{
    nifti_1_header header1;
    nifti_2_header header2;

    if (f->version == 1) {
        memcpy(&header1, f->bytes, sizeof header1);
        return nifti_convert_n1hdr2nim(header1, path);
    }
    memcpy(&header2, f->bytes, sizeof header2);
    return nifti_convert_n2hdr2nim(header2, path);
}

/* For SC_OWN. */
static void free_image(nifti_image **nim)
{
    nifti_image_free(*nim);
}

sc_status sc_open_nifti(const sc_ctx *ctx, const char *path, sc_source *out)
{
    fields f = {0};
    SC_OWN(sc_source_clear) sc_source source = {.slope = 1};
    SC_OWN(free_image) nifti_image *nim = NULL;
    int64_t size[3];
    bool pair = false, swapped;

    nifti_set_debug_level(0);
    SC_PASS(parse_header(ctx, path, &f));
    SC_PASS(check_magic(ctx, path, &f, &pair));
    SC_PASS(check_dims(ctx, path, &f, size, &source.series.count));
    SC_PASS(check_type(ctx, path, &f, &source.type));
    SC_PASS(check_offset(ctx, path, &f, pair));
    SC_PASS(voxel_file(ctx, path, pair, &source.stored.file));
    SC_PASS(find_voxels(ctx, &f, size, &source));
    nim = interpret(&f, path);
    if (!nim)
        return sc_fail(ctx, SC_ERR_DATA, "%s: not a readable NIfTI header", path);
    swapped = nim->byteorder != nifti_short_order();
    source.stored.swapped = swapped && sc_voxel_type_bytes(source.type) > 1;
    source.series.step_s = step_s(nim);
    geometry(ctx, path, &f, nim, &source);
    scaling(nim, &source);
    SC_PASS(sc_nifti_labels(ctx, path, f.version == 1 ? HEADER1_BYTES : HEADER2_BYTES,
                            pair ? UINT64_MAX : (uint64_t)f.voxel_offset, swapped, &source.table));
    SC_HAND_OVER(source, out);
    return SC_OK;
}
