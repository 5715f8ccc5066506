/* SPDX-License-Identifier: BSD-3-Clause */
/* NRRD. Teem reads the header, so that sizes are checked against the files before anything is
 * allocated for them. The voxels of the usual encodings (raw and gzip, in one file) are then
 * streamed; Teem reads those of all others. */
#include "source.h"

#include <errno.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <teem/nrrd.h>

/* Log the cause of Teem's last error, and empty Teem's error log. @return SC_ERR_DATA always. */
static sc_status teem_error(const sc_ctx *ctx, const char *path)
{
    char *text = biffGetDone(NRRD);
    const char *line = text ? text : "unknown";
    sc_status status;

    /* Teem's error log has a line for each function that was left, with the cause in the last one.
     */
    for (char *c = text; c && *c; c++) {
        if (*c == '\n' && c[1])
            line = c + 1;
    }
    if (line[0] == '[' && strstr(line, ": ")) /* "[nrrd] function: reason" */
        line = strstr(line, ": ") + 2;
    status = sc_fail(ctx, SC_ERR_DATA, "%s: not a readable NRRD: %.*s", path,
                     (int)strcspn(line, "\n"), line);
    free(text);
    return status;
}

/* Write our name of Teem's voxel type @p type to *out. @return SC_ERR_DATA for types that are
 * no numbers. */
static sc_status voxel_type(const sc_ctx *ctx, const char *path, int type, sc_voxel_type *out)
{
    static const struct {
        int teem;
        sc_voxel_type type;
    } types[] = {{nrrdTypeChar, SC_VOXEL_INT8},   {nrrdTypeUChar, SC_VOXEL_UINT8},
                 {nrrdTypeShort, SC_VOXEL_INT16}, {nrrdTypeUShort, SC_VOXEL_UINT16},
                 {nrrdTypeInt, SC_VOXEL_INT32},   {nrrdTypeUInt, SC_VOXEL_UINT32},
                 {nrrdTypeLLong, SC_VOXEL_INT64}, {nrrdTypeULLong, SC_VOXEL_UINT64},
                 {nrrdTypeFloat, SC_VOXEL_FLOAT}, {nrrdTypeDouble, SC_VOXEL_DOUBLE}};

    for (size_t i = 0; i < SC_COUNT_OF(types); i++) {
        if (types[i].teem == type) {
            *out = types[i].type;
            return SC_OK;
        }
    }
    return sc_fail(ctx, SC_ERR_DATA, "%s: type is %s, expected integers or floats", path,
                   airEnumStr(nrrdType, type));
}

/* Write to axes[3] the indices of the spatial axes, the fastest first: the first three whose
 * kind is domain, space, or not given. Further axes are left out if they have one sample.
 * @return SC_ERR_DATA if they have more, or if fewer than three axes are found. */
static sc_status spatial_axes(const sc_ctx *ctx, const char *path, const Nrrd *nrrd, int axes[3])
{
    int found = 0;

    for (unsigned i = 0; i < nrrd->dim; i++) {
        const NrrdAxisInfo *axis = &nrrd->axis[i];
        const bool spatial = axis->kind == nrrdKindUnknown || axis->kind == nrrdKindDomain ||
                             axis->kind == nrrdKindSpace;

        if (spatial && found < 3)
            axes[found++] = (int)i;
        else if (axis->size != 1)
            return sc_fail(
                ctx, SC_ERR_DATA,
                "%s: axis %u (%s) has %zu samples: overlapping layers or a series, expected "
                "three spatial axes; in 3D Slicer's Segment Editor merge the segments "
                "(Export to new labelmap) and save that, or take one layer with Teem: "
                "`unu slice -a %u -p 0 -i IN -o OUT.nrrd`",
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
    signs[0] = signs[1] = signs[2] = 1;
    switch (space) {
    case nrrdSpaceRightAnteriorSuperior:
    case nrrdSpaceRightAnteriorSuperiorTime:
        return true;
    case nrrdSpaceLeftAnteriorSuperior:
    case nrrdSpaceLeftAnteriorSuperiorTime:
        signs[0] = -1;
        return true;
    case nrrdSpaceScannerXYZ:
    case nrrdSpaceScannerXYZTime:
        sc_warn(ctx, "%s: space is scanner-xyz, read as left-posterior-superior", path);
        signs[0] = signs[1] = -1;
        return true;
    case nrrdSpaceLeftPosteriorSuperior:
    case nrrdSpaceLeftPosteriorSuperiorTime:
        signs[0] = signs[1] = -1;
        return true;
    default:
        return false;
    }
}

/* @return the millimetres of one @p unit of the file's world axes; 1 if it is NULL or empty,
 * and, with a warning, if it is not known. */
static double unit_mm(const sc_ctx *ctx, const char *path, const char *unit)
{
    static const struct {
        const char *name;
        double mm;
    } units[] = {{"mm", 1},           {"millimeter", 1},   {"cm", 10},
                 {"m", 1000},         {"um", 1e-3},        {"micron", 1e-3},
                 {"\xc2\xb5m", 1e-3}, {"\xce\xbcm", 1e-3}, {"nm", 1e-6}};

    for (size_t i = 0; unit && i < SC_COUNT_OF(units); i++) {
        if (!strcmp(unit, units[i].name))
            return units[i].mm;
    }
    if (unit && unit[0])
        sc_warn(ctx, "%s: space unit \"%s\" is not known, read as mm", path, unit);
    return 1;
}

/* Set the geometry of a file whose axes have no directions: voxels of the given spacings, 1 mm
 * where none is given, along R, A, S, and oriented is false. The map of @p source was zero. */
static void plain_geometry(const Nrrd *nrrd, const int axes[3], sc_source *source)
{
    for (int i = 0; i < 3; i++) {
        const double spacing = nrrd->axis[axes[i]].spacing;

        source->to_ras_mm.m[i][i] = AIR_EXISTS(spacing) && spacing != 0 ? fabs(spacing) : 1;
    }
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
    for (int i = 0; i < 3 && nrrd->spaceDim == 3; i++)
        directions += AIR_EXISTS(nrrd->axis[axes[i]].spaceDirection[0]) != 0;
    if (directions == 0) {
        plain_geometry(nrrd, axes, source);
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

/* The value of the key "Segment7_Name" for index 7 and field "Name"; NULL if absent. Caller
 * frees with free(). */
static char *segment_value(const Nrrd *nrrd, unsigned index, const char *field)
{
    char key[64];

    snprintf(key, sizeof key, "Segment%u_%s", index, field);
    return nrrdKeyValueGet(nrrd, key);
}

/* Read "R G B", each from 0 to 1, as 8-bit levels. @return false if @p text is NULL or no such
 * colour; @p rgb may have changed then. */
static bool parse_color(const char *text, uint8_t rgb[3])
{
    double channel[3];

    if (!text || sscanf(text, "%lf %lf %lf", &channel[0], &channel[1], &channel[2]) != 3)
        return false;
    for (int i = 0; i < 3; i++) {
        if (!(channel[i] >= 0 && channel[i] <= 1))
            return false;
        rgb[i] = (uint8_t)(channel[i] * 255 + 0.5);
    }
    return true;
}

/* Append one segment of Slicer's header to @p table as a row. A segment without LabelValue has
 * the value index + 1. One whose value cannot be read is left out, and so is a colour that
 * cannot be read, with a warning each. @return SC_ERR_MEMORY only. */
static sc_status read_segment(const sc_ctx *ctx, const char *path, const Nrrd *nrrd, unsigned index,
                              sc_label_table *table, sc_name_count *names)
{
    char *value = segment_value(nrrd, index, "LabelValue");
    char *name = segment_value(nrrd, index, "Name");
    char *color = segment_value(nrrd, index, "Color");
    sc_label row = {.opacity = -1};
    char *end = NULL;
    sc_status status = SC_OK;

    errno = 0;
    row.value = value ? strtoll(value, &end, 10) : (int64_t)index + 1;
    if (value && (end == value || *end || errno)) {
        sc_warn(ctx,
                "%s: Segment%u_LabelValue is \"%.40s\", expected a whole number; the "
                "segment's name and colour are not used",
                path, index, value);
        goto out;
    }
    sc_name_read(name ? name : "", row.name, names);
    row.has_color = parse_color(color, row.rgb);
    if (color && !row.has_color)
        sc_warn(ctx, "%s: Segment%u_Color is \"%.40s\", expected three numbers from 0 to 1", path,
                index, color);
    status = sc_label_table_add(ctx, table, &row);
out:
    free(value);
    free(name);
    free(color);
    return status;
}

/* Append the segments, from number 0 up to the first that has neither ID nor LabelValue, to @p
 * table. @return SC_ERR_MEMORY only. */
static sc_status read_segments(const sc_ctx *ctx, const char *path, const Nrrd *nrrd,
                               sc_label_table *table)
{
    sc_name_count names = {0};
    sc_status status = SC_OK;

    for (unsigned i = 0; i < SC_LABELS_MAX && status == SC_OK; i++) {
        char *id = segment_value(nrrd, i, "ID");
        char *value = segment_value(nrrd, i, "LabelValue");
        const bool exists = id || value;

        free(id);
        free(value);
        if (!exists)
            break;
        status = read_segment(ctx, path, nrrd, i, table, &names);
    }
    if (status == SC_OK)
        sc_name_warn(ctx, path, &names);
    return status;
}

/* Make the path of data file @p index of a detached header, whose names are relative to the
 * header. Caller owns *out: sc_free. */
static sc_status data_file_name(const sc_ctx *ctx, const NrrdIoState *nio, unsigned index,
                                char **out)
{
    return sc_path_join(ctx, nio->path ? nio->path : "", nio->dataFN[index], out);
}

/* Do the voxels follow the header in the same file? */
static bool is_attached(const NrrdIoState *nio)
{
    return !nio->dataFNFormat && (!nio->dataFNArr || nio->dataFNArr->len == 0);
}

/* Write to *out the bytes of all files that hold the voxels, the header of an attached one
 * included; -1 if the names are a pattern or a file is missing. @return SC_ERR_MEMORY only. */
static sc_status data_file_bytes(const sc_ctx *ctx, const char *path, const NrrdIoState *nio,
                                 double *out)
{
    struct stat info;
    double total = 0;

    *out = -1;
    if (nio->dataFNFormat)
        return SC_OK;
    if (is_attached(nio)) {
        *out = stat(path, &info) ? -1 : (double)info.st_size;
        return SC_OK;
    }
    for (unsigned i = 0; i < nio->dataFNArr->len; i++) {
        char *name = NULL;
        const sc_status status = data_file_name(ctx, nio, i, &name);
        const bool missing = status == SC_OK && stat(name, &info);

        sc_free(name);
        if (status != SC_OK)
            return status;
        if (missing)
            return SC_OK; /* a file is missing; opening it later logs which one */
        total += (double)info.st_size;
    }
    *out = total;
    return SC_OK;
}

/* Set size and geometry of @p source, whose type is set, from the spatial axes. @return
 * SC_ERR_DATA if the axes, sizes, geometry or byte skip cannot be used, or if the data files
 * are too short for so many voxels even if they are compressed as well as their encoding
 * allows. */
static sc_status check_sizes(const sc_ctx *ctx, const char *path, const Nrrd *nrrd,
                             const NrrdIoState *nio, sc_source *source)
{
    const size_t bytes_each = sc_voxel_type_bytes(source->type);
    int64_t size[3];
    int axes[3];
    size_t voxels;
    double bytes, limit;
    sc_status status;

    if (nio->byteSkip < -1)
        return sc_fail(ctx, SC_ERR_DATA, "%s: byte skip is %ld, expected -1, 0 or more", path,
                       nio->byteSkip);
    SC_TRY(data_file_bytes(ctx, path, nio, &limit));
    SC_TRY(spatial_axes(ctx, path, nrrd, axes));
    for (int i = 0; i < 3; i++)
        size[i] =
            nrrd->axis[axes[i]].size > INT32_MAX ? INT64_MAX : (int64_t)nrrd->axis[axes[i]].size;
    SC_TRY(sc_grid_voxels(ctx, path, size, bytes_each, &voxels));
    for (int i = 0; i < 3; i++)
        source->size[i] = (int)size[i];
    bytes = (double)voxels * (double)bytes_each;
    if (nio->encoding == nrrdEncodingGzip)
        limit *= SC_DEFLATE_RATIO_MAX;
    else if (nio->encoding == nrrdEncodingBzip2)
        limit *= 1e5;
    else if (nio->encoding == nrrdEncodingAscii)
        limit *= (double)bytes_each; /* a number takes two characters or more */
    if (limit >= 0 && bytes > limit)
        status = sc_fail(ctx, SC_ERR_DATA,
                         "%s: the header promises %.0f bytes of voxels, more than the file can "
                         "hold (%.0f)",
                         path, bytes, limit);
    else
        status = geometry(ctx, path, nrrd, axes, source);
out:
    return status;
}

/* A header that lists its data files must be text to its end: behind a damaged list Teem would
 * take what follows, such as voxels, for names of files. Only the first 64 KiB are examined.
 * @return SC_ERR_DATA with the byte, SC_ERR_MISSING if the file cannot be opened; SC_OK without
 * such a list. */
static sc_status check_list(const sc_ctx *ctx, const char *path)
{
    enum { LOOK_BYTES = 1 << 16 };
    char text[LOOK_BYTES + 1];
    FILE *stream = fopen(path, "rb");
    const char *list;
    size_t count;

    if (!stream)
        return sc_fail(ctx, SC_ERR_MISSING, "%s: %s", path, strerror(errno));
    count = fread(text, 1, LOOK_BYTES, stream);
    fclose(stream);
    text[count] = '\0';
    list = strstr(text, "\ndata file: LIST");
    if (!list)
        list = strstr(text, "\ndatafile: LIST");
    for (const char *c = list; c && c < text + count; c++) {
        if ((unsigned char)*c < ' ' && *c != '\n' && *c != '\r' && *c != '\t')
            return sc_fail(ctx, SC_ERR_DATA, "%s: byte %td is not text, expected a list of files",
                           path, c - text);
    }
    return SC_OK;
}

/* Let Teem read the file into @p nrrd and @p nio, which the caller has made and frees. @p
 * header_only: Teem reads no voxels, but leaves nio->dataFile open at the first of them if
 * there is one such file (to be closed by close_data_file). @return SC_ERR_DATA; no file is
 * open then. */
static sc_status load(const sc_ctx *ctx, const char *path, bool header_only, Nrrd *nrrd,
                      NrrdIoState *nio)
{
    nrrdStateVerboseIO = 0; /* teem_error logs what went wrong */
    nio->skipData = header_only ? AIR_TRUE : AIR_FALSE;
    nio->keepNrrdDataFileOpen = nio->skipData;
    errno = 0;
    if (nrrdLoad(nrrd, path, nio)) {
        nio->dataFile = NULL; /* Teem has closed it */
        return teem_error(ctx, path);
    }
    if (nio->format && nio->format != nrrdFormatNRRD) {
        nio->dataFile = NULL; /* Teem has closed it */
        return sc_fail(ctx, SC_ERR_DATA, "%s: is %s, expected NRRD", path, nio->format->name);
    }
    return SC_OK;
}

/* @return SC_ERR_DATA with the byte if a number of encoding ascii does not fit the type of the
 * voxels: Teem would wrap it, so that wrong labels would be shown. The numbers are looked for
 * in the text itself, which stands behind the blank line that ends the header. SC_OK for other
 * encodings; text in a file of its own, and types of 64 bits and floats, are not checked. */
static sc_status check_ascii(const sc_ctx *ctx, const char *path, const NrrdIoState *nio,
                             const sc_source *source)
{
    static const double lowest[] = {-128, 0, -32768, 0, -2147483648.0, 0};
    static const double highest[] = {127, 255, 32767, 65535, 2147483647.0, 4294967295.0};
    char *text = NULL, *at, *end;
    size_t bytes;
    sc_status status;

    if (nio->encoding != nrrdEncodingAscii || source->type > SC_VOXEL_UINT32 || nio->lineSkip ||
        (nio->dataFNArr && nio->dataFNArr->len > 0))
        return SC_OK;
    status = sc_file_read(ctx, path, SIZE_MAX / 2, &text, &bytes);
    if (status != SC_OK)
        return status;
    at = strstr(text, "\n\n") ? strstr(text, "\n\n") : strstr(text, "\n\r\n");
    for (double value; at && status == SC_OK; at = end) {
        value = strtod(at, &end);
        if (end == at)
            break;
        if (value < lowest[source->type] || value > highest[source->type])
            status = sc_fail(ctx, SC_ERR_DATA,
                             "%s: byte %td holds %.15g, which does not fit its "
                             "type",
                             path, at - text, value);
        end += strspn(end, ", \t\r\n");
    }
    sc_free(text);
    return status;
}

/* Can sc_voxel_stream read the voxels? @p nio is of load with header_only. Else Teem has to
 * read them whole. */
static bool is_streamable(const NrrdIoState *nio)
{
    const bool gzip = nio->encoding == nrrdEncodingGzip;

    return (gzip || nio->encoding == nrrdEncodingRaw) && nio->dataFile && !nio->dataFNFormat &&
           (!nio->dataFNArr || nio->dataFNArr->len <= 1) && !(gzip && nio->byteSkip < 0);
}

/* Set encoding, file, offset_bytes, skip_bytes and swapped of @p source, whose type is set. The
 * voxels begin where Teem has left nio->dataFile: behind the header, and behind the lines and
 * (of a file that is not compressed) bytes that the header says to skip. @return SC_ERR_DATA,
 * SC_ERR_MEMORY. */
static sc_status find_voxels(const sc_ctx *ctx, const char *path, const NrrdIoState *nio,
                             sc_source *source)
{
    const bool gzip = nio->encoding == nrrdEncodingGzip;
    const off_t offset = ftello(nio->dataFile);

    if (offset < 0)
        return sc_fail(ctx, SC_ERR_DATA, "%s: its voxels cannot be found: %s", path,
                       strerror(errno));
    source->encoding = gzip ? SC_ENCODING_GZIP : SC_ENCODING_PLAIN;
    source->offset_bytes = (uint64_t)offset;
    source->skip_bytes = gzip ? (uint64_t)nio->byteSkip : 0;
    source->swapped = sc_voxel_type_bytes(source->type) > 1 && nio->endian != airEndianUnknown &&
                      nio->endian != airMyEndian();
    return is_attached(nio) ? sc_path_join(ctx, "", path, &source->file)
                            : data_file_name(ctx, nio, 0, &source->file);
}

/* Let Teem read all voxels, for encodings that cannot be streamed. Sets data and release of @p
 * source, which owns the voxels; its encoding stays SC_ENCODING_LOADED, which is 0. @return
 * SC_ERR_DATA, SC_ERR_MEMORY. */
static sc_status load_voxels(const sc_ctx *ctx, const char *path, sc_source *source)
{
    Nrrd *nrrd = nrrdNew();
    NrrdIoState *nio = nrrdIoStateNew();
    sc_status status;

    if (!nrrd || !nio) {
        status = sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
        goto out;
    }
    SC_TRY(load(ctx, path, false, nrrd, nio));
    SC_TRY(check_ascii(ctx, path, nio, source));
    source->data = nrrd->data;
    source->release = free;
    nrrdNix(nrrd); /* keeps the voxels, frees the rest */
    nrrd = NULL;
out:
    nrrdNuke(nrrd);
    nrrdIoStateNix(nio);
    return status;
}

/* Close the data file that load left open, if any, and free @p nio. NULL is allowed. */
static void close_data_file(NrrdIoState *nio)
{
    if (nio && nio->dataFile)
        fclose(nio->dataFile);
    nrrdIoStateNix(nio);
}

sc_status sc_open_nrrd(const sc_ctx *ctx, const char *path, bool header_only, sc_source *out)
{
    Nrrd *header = nrrdNew();
    NrrdIoState *nio = nrrdIoStateNew();
    sc_source source = {.slope = 1};
    sc_status status;

    if (!header || !nio) {
        status = sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
        goto out;
    }
    SC_TRY(check_list(ctx, path));
    SC_TRY(load(ctx, path, true, header, nio));
    SC_TRY(voxel_type(ctx, path, header->type, &source.type));
    SC_TRY(check_sizes(ctx, path, header, nio, &source));
    SC_TRY(read_segments(ctx, path, header, &source.table));
    if (is_streamable(nio))
        SC_TRY(find_voxels(ctx, path, nio, &source));
    else if (!header_only)
        SC_TRY(load_voxels(ctx, path, &source));
    *out = source;
    source = (sc_source){0};
out:
    sc_source_clear(&source);
    nrrdNuke(header);
    close_data_file(nio);
    return status;
}
