/* SPDX-License-Identifier: BSD-3-Clause */
/* NRRD. nrrd_header.c splits the header, nrrd_segments.c reads the segments of 3D Slicer; Teem
 * reads the fields, so that sizes are checked against the files before anything is allocated for
 * them. The voxels of the usual encodings (raw and gzip, in one file) are then streamed, those of
 * encoding ascii are read here, and Teem reads all others. Teem opens no file but those that
 * nrrd_header.c has checked. */
#include "formats/nrrd_header.h"

#include <errno.h>
#include <stdlib.h>
#include <teem/nrrd.h>

/* Log the cause of Teem's last error, and empty Teem's error log. @param error errno after the
 * call, which was 0 before it. @return SC_ERR_DATA, or SC_ERR_MEMORY: Teem takes a part of the file
 * that found no memory for one that is damaged. */
static sc_status teem_error(const sc_ctx *ctx, const char *path, int error)
{
    SC_OWN(sc_free_at) char *text = biffCheck(NRRD) ? biffGetDone(NRRD) : NULL;
    const char *line = text ? text : "unknown";

    /* Teem's error log has a line for each function that was left, with the cause in the last one.
     */
    for (char *c = text; c && *c; c++) {
        if (*c == '\n' && c[1])
            line = c + 1;
    }
    if (line[0] == '[' && strstr(line, ": ")) /* "[nrrd] function: reason" */
        line = strstr(line, ": ") + 2;
    if (error == ENOMEM)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory while the NRRD was read", path);
    return sc_fail(ctx, SC_ERR_DATA, "%s: not a readable NRRD: %.*s", path,
                   (int)strcspn(line, "\n"), line);
}

/* Write our name of Teem's voxel type @p type to *out. @return SC_ERR_DATA for types that are
 * no numbers. */
static sc_status voxel_type(const sc_ctx *ctx, const char *path, int type, sc_voxel_type *out)
{
    static const int types[SC_VOXEL_TYPES] = {
        nrrdTypeChar, nrrdTypeUChar, nrrdTypeShort,  nrrdTypeUShort, nrrdTypeInt,
        nrrdTypeUInt, nrrdTypeLLong, nrrdTypeULLong, nrrdTypeFloat,  nrrdTypeDouble};

    if (sc_voxel_type_coded(type, types, out))
        return SC_OK;
    return sc_fail(ctx, SC_ERR_DATA, "%s: type is %s, expected integers or floats", path,
                   airEnumStr(nrrdType, type));
}

/* @return the time from one sample of an axis to the next, if it is given in a unit of time; else
 * 0. */
static double axis_step_s(const NrrdAxisInfo *axis)
{
    const bool is_known = axis->units && AIR_EXISTS(axis->spacing) && axis->spacing > 0;

    return is_known ? axis->spacing * sc_time_unit_s(axis->units) : 0;
}

/* Can an axis beside the three in space be that of the phases: the slowest of four or, where their
 * values stand side by side, the fastest, and of a kind that can stand for times? */
static bool is_phase_axis(const Nrrd *nrrd, unsigned i)
{
    const int kind = nrrd->axis[i].kind;

    return nrrd->dim == 4 && (i == 0 || i == 3) && nrrd->axis[i].size <= INT32_MAX &&
           (kind == nrrdKindTime || kind == nrrdKindList || kind == nrrdKindUnknown ||
            kind == nrrdKindDomain);
}

/* Write to axes[3] the indices of the spatial axes, the fastest first: the first three whose
 * kind is domain, space, or not given. Further axes are left out if they have one sample. The
 * fastest may have the layers of the segments of @p header, if there are any; layers of @p source
 * is their number, or 1. The fastest or slowest may have the phases of a series, which @p source
 * gets, too. @return SC_ERR_DATA if other axes have more, or if fewer than three axes are found. */
static sc_status spatial_axes(const sc_ctx *ctx, const char *path, const Nrrd *nrrd,
                              const sc_nrrd_header *header, int axes[3], sc_source *source)
{
    int found = 0;

    source->layers = source->series.count = 1;

    for (unsigned i = 0; i < nrrd->dim; i++) {
        const NrrdAxisInfo *axis = &nrrd->axis[i];
        const bool spatial = axis->kind == nrrdKindUnknown || axis->kind == nrrdKindDomain ||
                             axis->kind == nrrdKindSpace;

        if (spatial && found < 3)
            axes[found++] = (int)i;
        else if (i == 0 && axis->size <= SC_LAYERS_MAX &&
                 (header->label_groups || (header->segment_count && axis->kind == nrrdKindList)))
            source->layers = (int)axis->size;
        else if (axis->size != 1 && is_phase_axis(nrrd, i)) {
            source->series.count = (int)axis->size;
            source->series.side_by_side = i == 0;
            source->series.step_s = axis_step_s(axis);
        } else if (axis->size != 1)
            return sc_fail(
                ctx, SC_ERR_DATA,
                "%s: axis %u (%s) has %zu samples, expected three spatial axes; with "
                "the phases of a series (time or list) as the slowest or the fastest, "
                "or up to 4096 layers of a .seg.nrrd or of MITK as the fastest; with Teem, `unu "
                "axmerge` or `unu permute` bring axes to another place, and `unu slice "
                "-a %u -p 0 -i IN -o OUT.nrrd` takes one sample",
                path, i, airEnumStr(nrrdKind, axis->kind), axis->size, i);
    }
    if (found != 3)
        return sc_fail(ctx, SC_ERR_DATA, "%s: has %d spatial axes, expected 3", path, found);
    return SC_OK;
}

/* Fill signs[3] with the factors 1 and -1 that turn the file's world axes into right, anterior,
 * superior. @return false if the file does not name its space or names another; all are 1 then. */
static bool space_signs(const sc_ctx *ctx, const char *path, int space, double signs[3])
{
    static const struct {
        int spaces[2]; /* alone, and with an axis of time */
        double x, y;
    } known[] = {{{nrrdSpaceRightAnteriorSuperior, nrrdSpaceRightAnteriorSuperiorTime}, 1, 1},
                 {{nrrdSpaceLeftAnteriorSuperior, nrrdSpaceLeftAnteriorSuperiorTime}, -1, 1},
                 {{nrrdSpaceLeftPosteriorSuperior, nrrdSpaceLeftPosteriorSuperiorTime}, -1, -1},
                 {{nrrdSpaceScannerXYZ, nrrdSpaceScannerXYZTime}, -1, -1}};

    signs[0] = signs[1] = signs[2] = 1;
    for (size_t i = 0; i < SC_COUNT_OF(known); i++) {
        if (space != known[i].spaces[0] && space != known[i].spaces[1])
            continue;
        if (known[i].spaces[0] == nrrdSpaceScannerXYZ)
            sc_warn(ctx, "%s: space is scanner-xyz, read as left-posterior-superior", path);
        signs[0] = known[i].x;
        signs[1] = known[i].y;
        return true;
    }
    return false;
}

/* @return the millimetres of one @p unit of the file's world axes; 1 if it is NULL or empty,
 * and, with a warning, if it is not known. */
static double unit_mm(const sc_ctx *ctx, const char *path, const char *unit)
{
    const double mm = unit ? sc_length_unit_mm(unit) : 1;

    if (mm == 0 && unit[0])
        sc_warn(ctx, "%s: unit \"%s\" is not known, read as mm", path, unit);
    return mm > 0 ? mm : 1;
}

/* Set the geometry of a file whose axes have no directions: voxels of the given spacings, 1 mm
 * where none is given, along R, A, S, and oriented is false. The map of @p source was zero. */
static void plain_geometry(const sc_ctx *ctx, const char *path, const Nrrd *nrrd, const int axes[3],
                           sc_source *source)
{
    bool is_given = true;

    for (int i = 0; i < 3; i++) {
        const NrrdAxisInfo *axis = &nrrd->axis[axes[i]];
        const bool is_known = AIR_EXISTS(axis->spacing) && axis->spacing != 0;

        is_given = is_given && is_known;
        source->to_ras_mm.m[i][i] =
            is_known ? fabs(axis->spacing) * unit_mm(ctx, path, axis->units) : 1;
    }
    if (!is_given)
        sc_warn_without_spacing(ctx, path, "spacings");
    source->oriented = false;
}

/* Set to_ras_mm and oriented of @p source from the directions of @p axes (of spatial_axes) and
 * the origin, in the unit of the file. @return SC_ERR_DATA if only some of the axes have a
 * direction. */
static sc_status geometry(const sc_ctx *ctx, const char *path, const Nrrd *nrrd, const int axes[3],
                          sc_source *source)
{
    double signs[3];
    int directions = 0;

    source->oriented = space_signs(ctx, path, nrrd->space, signs);
    for (int i = 0; i < 3 && nrrd->spaceDim >= 3; i++) /* a fourth one is the time */
        directions += AIR_EXISTS(nrrd->axis[axes[i]].spaceDirection[0]) != 0;
    if (directions == 0) {
        plain_geometry(ctx, path, nrrd, axes, source);
        return SC_OK;
    }
    if (directions < 3)
        return sc_fail(ctx, SC_ERR_DATA, "%s: %d of 3 axes have a space direction", path,
                       directions);
    for (int row = 0; row < 3; row++) {
        const double mm = unit_mm(ctx, path, nrrd->spaceUnits[row]) * signs[row];
        const double origin = nrrd->spaceOrigin[row];

        for (int i = 0; i < 3; i++)
            source->to_ras_mm.m[row][i] = mm * nrrd->axis[axes[i]].spaceDirection[row];
        source->to_ras_mm.m[row][3] = AIR_EXISTS(origin) ? mm * origin : 0;
    }
    return SC_OK;
}

/* Set size, layers and geometry of @p source, whose type is set, from the axes; in the size, layers
 * count as voxels along x. @return
 * SC_ERR_DATA if the axes, sizes, geometry or byte skip cannot be used, or if the data files
 * are too short for so many voxels even if they are compressed as well as their encoding
 * allows. */
static sc_status check_sizes(const sc_ctx *ctx, const char *path, const sc_nrrd_header *header,
                             const Nrrd *nrrd, const NrrdIoState *nio, sc_source *source)
{
    const size_t bytes_each = sc_voxel_type_bytes(source->type);
    int64_t size[3];
    int axes[3];
    size_t voxels;
    double bytes, limit = (double)header->file_bytes;

    if (nio->byteSkip < -1)
        return sc_fail(ctx, SC_ERR_DATA, "%s: byte skip is %ld, expected -1, 0 or more", path,
                       nio->byteSkip);
    SC_PASS(spatial_axes(ctx, path, nrrd, header, axes, source));
    for (int i = 0; i < 3; i++)
        size[i] =
            nrrd->axis[axes[i]].size > INT32_MAX ? INT64_MAX : (int64_t)nrrd->axis[axes[i]].size;
    size[0] = size[0] > INT32_MAX ? size[0] : size[0] * source->layers;
    SC_PASS(sc_grid_voxels(ctx, path, size, bytes_each, source->size, &voxels));
    bytes = (double)voxels * (double)bytes_each * source->series.count;
    if (nio->encoding == nrrdEncodingGzip)
        limit *= SC_DEFLATE_RATIO_MAX;
    else if (nio->encoding == nrrdEncodingBzip2)
        limit *= 1e5;
    else if (nio->encoding == nrrdEncodingAscii)
        limit *= (double)bytes_each / 2; /* a number takes two characters, but for the last one */
    else if (nio->encoding == nrrdEncodingHex)
        limit /= 2;
    if (bytes > limit + (double)bytes_each)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: the header promises %.0f bytes of voxels, more than the file can "
                       "hold (%.0f)",
                       path, bytes, limit);
    return geometry(ctx, path, nrrd, axes, source);
}

/* Let Teem read the fields of the header into @p nrrd and @p nio, which the caller has made and
 * frees. No file is opened. @return SC_ERR_DATA if Teem cannot, or a field that every NRRD file
 * needs is missing. */
static sc_status read_fields(const sc_ctx *ctx, const char *path, const sc_nrrd_header *header,
                             Nrrd *nrrd, NrrdIoState *nio)
{
    static const int required[] = {nrrdField_type, nrrdField_dimension, nrrdField_sizes,
                                   nrrdField_encoding};

    nrrdStateVerboseIO = 0; /* teem_error logs what went wrong */
    nio->skipData = AIR_TRUE;
    errno = 0;
    if (nrrdStringRead(nrrd, header->fields.data, nio))
        return teem_error(ctx, path, errno);
    if (errno == ENOMEM) /* Teem has left something out */
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory while the NRRD was read", path);
    if (nio->format && nio->format != nrrdFormatNRRD)
        return sc_fail(ctx, SC_ERR_DATA, "%s: is %s, expected NRRD", path, nio->format->name);
    for (size_t i = 0; i < SC_COUNT_OF(required); i++) {
        if (!nio->seen[required[i]])
            return sc_fail(ctx, SC_ERR_DATA, "%s: its header has no field \"%s\"", path,
                           airEnumStr(nrrdField, required[i]));
    }
    return SC_OK;
}

/* Can a stream read the voxels? Else they have to be read whole. */
static bool is_streamable(const sc_nrrd_header *header, const NrrdIoState *nio)
{
    const bool gzip = nio->encoding == nrrdEncodingGzip;

    return (gzip || nio->encoding == nrrdEncodingRaw) && header->file_count <= 1 &&
           !(gzip && nio->byteSkip < 0);
}

/* Move *offset_bytes behind @p lines lines of the file; the last byte of a line is LF, CR or both.
 * @return SC_ERR_DATA if there are fewer, SC_ERR_MISSING if the file cannot be opened. */
static sc_status skip_lines(const sc_ctx *ctx, const char *file, unsigned lines,
                            uint64_t *offset_bytes)
{
    SC_OWN(sc_fclose_at) FILE *stream = NULL;
    int c = 0, last = 0;

    SC_PASS(sc_open_input(ctx, file, &stream));
    (void)fseeko(stream, (off_t)*offset_bytes, SEEK_SET); /* reading notices an error */
    for (; c != EOF; last = c) {
        c = getc(stream);
        if (c == '\n' && last == '\r') { /* the second half of a line's end */
            ++*offset_bytes;
            continue;
        }
        if (lines == 0 || c == EOF)
            break;
        ++*offset_bytes;
        lines -= c == '\n' || c == '\r';
    }
    return lines ? sc_fail(ctx, SC_ERR_DATA, "%s: ends before the lines that line skip skips", file)
                 : SC_OK;
}

/* Set encoding, file, offset_bytes, skip_bytes and swapped of @p source, whose type and size are
 * set. The voxels begin behind the header or at the begin of their own file, and then behind the
 * lines and bytes that the header says to skip; a byte skip of -1: they are the last of the file.
 * @return SC_ERR_DATA, SC_ERR_MISSING, SC_ERR_MEMORY. */
static sc_status find_voxels(const sc_ctx *ctx, const char *path, const sc_nrrd_header *header,
                             const NrrdIoState *nio, sc_source *source)
{
    const bool gzip = nio->encoding == nrrdEncodingGzip;
    const uint64_t each = sc_voxel_type_bytes(source->type);
    const uint64_t bytes = sc_source_voxels(source) * (uint64_t)source->series.count * each;

    SC_PASS(
        sc_path_join(ctx, "", header->attached ? path : header->first_file, &source->stored.file));
    source->stored.encoding = gzip ? SC_ENCODING_GZIP : SC_ENCODING_PLAIN;
    source->stored.offset_bytes = header->end_bytes;
    if (nio->lineSkip)
        SC_PASS(skip_lines(ctx, source->stored.file, nio->lineSkip, &source->stored.offset_bytes));
    if (gzip && !sc_is_gzip(source->stored.file, source->stored.offset_bytes))
        sc_warn(
            ctx,
            "%s: says that its encoding is gzip, but its voxels are not compressed; they are read "
            "as they are",
            path);
    if (gzip)
        source->stored.skip_bytes = (uint64_t)nio->byteSkip;
    else if (nio->byteSkip >= 0)
        source->stored.offset_bytes += (uint64_t)nio->byteSkip;
    else /* check_sizes: the file has so many bytes */
        source->stored.offset_bytes = header->file_bytes - bytes;
    source->stored.swapped =
        each > 1 && nio->endian != airEndianUnknown && nio->endian != airMyEndian();
    return SC_OK;
}

/* ---- encodings that are read whole ---- */

/* Make the file as Teem is to read it: the fields, then the data file or the voxels that follow the
 * header of an attached one. The caller owns *out: sc_free. */
static sc_status file_for_teem(const sc_ctx *ctx, const char *path, const sc_nrrd_header *header,
                               char **out, size_t *out_bytes)
{
    const size_t begin = header->fields.length_bytes;
    SC_OWN(sc_free_at) char *file = NULL;
    size_t file_bytes = 0, bytes;
    sc_text text = {0};

    if (!header->attached) {
        SC_PASS(sc_text_add(ctx, &text, "%s%s", header->fields.data, header->list.data));
        *out = text.data;
        *out_bytes = text.length_bytes;
        return SC_OK;
    }
    SC_PASS(sc_file_read(ctx, path, SIZE_MAX / 2, &file, &file_bytes));
    bytes = file_bytes > header->end_bytes ? file_bytes - header->end_bytes : 0;
    SC_PASS(sc_alloc(ctx, begin + 1 + bytes, 1, out));
    *out_bytes = begin + 1 + bytes;
    memcpy(*out, header->fields.data, begin);
    (*out)[begin] = '\n';
    if (bytes)
        memcpy(*out + begin + 1, file + header->end_bytes, bytes);
    return SC_OK;
}

/* What Teem works on. Owns both: clear_teem. */
typedef struct teem_reading {
    Nrrd *nrrd;
    NrrdIoState *nio;
} teem_reading;

/* For SC_OWN. */
static void clear_teem(teem_reading *t)
{
    nrrdNuke(t->nrrd);
    nrrdIoStateNix(t->nio);
}

static sc_status begin_teem(const sc_ctx *ctx, const char *path, teem_reading *t)
{
    *t = (teem_reading){nrrdNew(), nrrdIoStateNew()};
    return t->nrrd && t->nio ? SC_OK : sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
}

/* Let Teem read all voxels, for encodings that cannot be streamed. Sets data and release of @p
 * source, which owns the voxels; its encoding stays SC_ENCODING_LOADED, which is 0. @return
 * SC_ERR_DATA, SC_ERR_MEMORY. */
static sc_status load_voxels(const sc_ctx *ctx, const char *path, const sc_nrrd_header *header,
                             sc_source *source)
{
    SC_OWN(clear_teem) teem_reading t = {0};
    const char *slash = strrchr(path, '/');
    SC_OWN(sc_free_at) char *text = NULL;
    SC_OWN(sc_fclose_at) FILE *stream = NULL;
    size_t bytes = 0;

    SC_PASS(begin_teem(ctx, path, &t));
    SC_PASS(file_for_teem(ctx, path, header, &text, &bytes));
    stream = fmemopen(text, bytes, "r");
    if (stream) /* Teem frees this path, and names are relative to it */
        t.nio->path = slash ? strndup(path, (size_t)(slash - path) + (slash == path)) : strdup(".");
    if (!stream || !t.nio->path)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
    errno = 0;
    if (nrrdRead(t.nrrd, stream, t.nio))
        return teem_error(ctx, path, errno);
    source->reader.data = t.nrrd->data;
    source->reader.release = free;
    nrrdNix(t.nrrd); /* keeps the voxels, frees the rest */
    t.nrrd = NULL;
    return SC_OK;
}

/* Read the numbers of encoding ascii from byte @p begin of @p text, which ends with a NUL byte,
 * into values[count], or real[count] if that is not NULL. Blanks, ends of lines and commas separate
 * them. @param path of the text, for messages. @return SC_ERR_DATA with the byte for what is no
 * number, or one that the @p type cannot hold: such a label would silently be another one. */
static sc_status parse_numbers(const sc_ctx *ctx, const char *path, const char *text, size_t begin,
                               size_t count, sc_voxel_type type, int64_t *values, double *real)
{
    const char *at = text + begin;

    for (size_t i = 0; i < count; i++) {
        char *end = NULL;
        int64_t value = 0;

        at += strspn(at, " \t\r\n\f\v,");
        if (!*at)
            return sc_fail(ctx, SC_ERR_DATA, "%s: ends after %zu numbers, expected %zu", path, i,
                           count);
        errno = 0;
        if (real)
            real[i] = strtod(at, &end);
        else
            values[i] = value = strtoll(at, &end, 10);
        if (end == at || !strchr(" \t\r\n\f\v,", *end) ||
            (!real && (errno || !sc_voxel_type_fits(type, value))))
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s: byte %td begins \"%.20s\", expected a %s that fits the type of the "
                           "voxels",
                           path, at - text, at, real ? "number" : "whole number");
        at = end;
    }
    return SC_OK;
}

/* Read the voxels of encoding ascii: data and release of @p source, whose type becomes int64 or
 * double. Teem would wrap numbers that do not fit, and write past its buffer for a number of more
 * than 1,024 digits. @return SC_ERR_DATA, also if the numbers are in several files; SC_ERR_MEMORY.
 */
static sc_status load_ascii(const sc_ctx *ctx, const char *path, const sc_nrrd_header *header,
                            const NrrdIoState *nio, sc_source *source)
{
    const char *file = header->attached ? path : header->first_file;
    const bool real = !sc_voxel_type_is_integer(source->type);
    const size_t count = sc_source_voxels(source) * (size_t)source->series.count;
    uint64_t offset = header->end_bytes;
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes = 0;

    if (header->file_count > 1 || nio->byteSkip < 0)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: encoding ascii with %s, which segcast does not read; save the volume as "
            "one file, for example with Teem: `unu save -f nrrd -e gzip -i IN -o "
            "OUT.nrrd`",
            path, nio->byteSkip < 0 ? "a negative byte skip" : "several data files");
    if (nio->lineSkip)
        SC_PASS(skip_lines(ctx, file, nio->lineSkip, &offset));
    offset += (uint64_t)nio->byteSkip;
    SC_PASS(sc_file_read(ctx, file, SIZE_MAX / 2, &text, &bytes));
    SC_PASS(sc_alloc(ctx, count, sizeof(int64_t), &source->reader.data));
    source->reader.release = sc_free;
    SC_PASS(parse_numbers(ctx, file, text, offset < bytes ? offset : bytes, count, source->type,
                          real ? NULL : source->reader.data, real ? source->reader.data : NULL));
    source->type = real ? SC_VOXEL_DOUBLE : SC_VOXEL_INT64;
    return SC_OK;
}

/* Check that the voxels may be read whole, beside the file itself if that is read whole, too.
 * @return SC_ERR_SYSTEM. */
static sc_status check_loaded(const sc_ctx *ctx, const char *path, const sc_nrrd_header *header,
                              const NrrdIoState *nio, const sc_source *source)
{
    const bool ascii = nio->encoding == nrrdEncodingAscii;
    const double each = ascii ? sizeof(int64_t) : (double)sc_voxel_type_bytes(source->type);
    const double file = ascii || header->attached ? 2 * (double)header->file_bytes : 0;

    return sc_volume_memory_check(ctx, path, source->size,
                                  (double)sc_source_voxels(source) * source->series.count * each +
                                      file);
}

sc_status sc_open_nrrd(const sc_ctx *ctx, const char *path, bool header_only, sc_source *out)
{
    SC_OWN(clear_teem) teem_reading t = {0};
    SC_OWN(sc_nrrd_header_clear) sc_nrrd_header header = {0};
    SC_OWN(sc_source_clear) sc_source source = {.slope = 1};

    SC_PASS(begin_teem(ctx, path, &t));
    SC_PASS(sc_nrrd_header_read(ctx, path, &header));
    SC_PASS(read_fields(ctx, path, &header, t.nrrd, t.nio));
    SC_PASS(voxel_type(ctx, path, t.nrrd->type, &source.type));
    SC_PASS(check_sizes(ctx, path, &header, t.nrrd, t.nio, &source));
    SC_PASS(sc_nrrd_read_segments(ctx, path, &header, &source));
    if (is_streamable(&header, t.nio))
        SC_PASS(find_voxels(ctx, path, &header, t.nio, &source));
    else if (!header_only)
        SC_PASS(check_loaded(ctx, path, &header, t.nio, &source));
    if (!header_only && !source.stored.file && t.nio->encoding == nrrdEncodingAscii)
        SC_PASS(load_ascii(ctx, path, &header, t.nio, &source));
    else if (!header_only && !source.stored.file)
        SC_PASS(load_voxels(ctx, path, &header, &source));
    if (source.layers > 1)
        source.size[0] /= source.layers; /* from now on they do not count */
    source.stored.data_files = header.paths;
    header.paths = (sc_text){0};
    SC_HAND_OVER(source, out);
    return SC_OK;
}
