/* SPDX-License-Identifier: BSD-3-Clause */
/* NRRD through Teem. The header is read alone first, so that sizes are checked against the files
 * before anything is allocated for them. */
#include "raw.h"

#include <errno.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <teem/nrrd.h>

static sc_status teem_error(const sc_ctx *ctx, const char *path)
{
    char *text = biffGetDone(NRRD);
    const char *line = text ? text : "unknown";
    sc_status status;

    /* biff stacks one line per caller, the cause last. */
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

static sc_status raw_type(const sc_ctx *ctx, const char *path, int type, sc_raw_type *out)
{
    static const struct {
        int teem;
        sc_raw_type raw;
    } types[] = {{nrrdTypeChar, SC_RAW_INT8},   {nrrdTypeUChar, SC_RAW_UINT8},
                 {nrrdTypeShort, SC_RAW_INT16}, {nrrdTypeUShort, SC_RAW_UINT16},
                 {nrrdTypeInt, SC_RAW_INT32},   {nrrdTypeUInt, SC_RAW_UINT32},
                 {nrrdTypeLLong, SC_RAW_INT64}, {nrrdTypeULLong, SC_RAW_UINT64},
                 {nrrdTypeFloat, SC_RAW_FLOAT}, {nrrdTypeDouble, SC_RAW_DOUBLE}};

    for (size_t i = 0; i < SC_COUNT_OF(types); i++) {
        if (types[i].teem == type) {
            *out = types[i].raw;
            return SC_OK;
        }
    }
    return sc_fail(ctx, SC_ERR_DATA, "%s: type is %s, expected integers or floats", path,
                   airEnumStr(nrrdType, type));
}

/* The three spatial axes; a further axis is allowed only with one sample. */
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
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s: axis %u (%s) has %zu samples; overlapping layers and series are "
                           "not supported, expected three spatial axes",
                           path, i, airEnumStr(nrrdKind, axis->kind), axis->size);
    }
    if (found != 3)
        return sc_fail(ctx, SC_ERR_DATA, "%s: has %d spatial axes, expected 3", path, found);
    return SC_OK;
}

/* Signs that turn the file's world axes into right, anterior, superior. */
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

/* Millimetres per unit of the file's world axes. */
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

/* Axes without directions: a grid of spacings (1 where none is given). */
static void plain_geometry(const Nrrd *nrrd, const int axes[3], sc_raw *raw)
{
    for (int i = 0; i < 3; i++) {
        const double spacing = nrrd->axis[axes[i]].spacing;

        raw->to_ras_mm.m[i][i] = AIR_EXISTS(spacing) && spacing != 0 ? fabs(spacing) : 1;
    }
    raw->oriented = false;
}

static sc_status geometry(const sc_ctx *ctx, const char *path, const Nrrd *nrrd, const int axes[3],
                          sc_raw *raw)
{
    double signs[3];
    int directions = 0;

    raw->oriented = space_signs(ctx, path, nrrd->space, signs);
    for (int i = 0; i < 3 && nrrd->spaceDim == 3; i++)
        directions += AIR_EXISTS(nrrd->axis[axes[i]].spaceDirection[0]) != 0;
    if (directions == 0) {
        plain_geometry(nrrd, axes, raw);
        return SC_OK;
    }
    if (directions < 3)
        return sc_fail(ctx, SC_ERR_DATA, "%s: %d of 3 axes have a space direction", path,
                       directions);
    for (int row = 0; row < 3; row++) {
        const double mm = unit_mm(ctx, path, nrrd->spaceUnits[row]) * signs[row];
        const double origin = nrrd->spaceOrigin[row];

        for (int i = 0; i < 3; i++)
            raw->to_ras_mm.m[row][i] = mm * nrrd->axis[axes[i]].spaceDirection[row];
        raw->to_ras_mm.m[row][3] = AIR_EXISTS(origin) ? mm * origin : 0;
    }
    return SC_OK;
}

/* "Segment7_Name" and so on; NULL if absent. Caller frees with free(). */
static char *segment_value(const Nrrd *nrrd, unsigned index, const char *field)
{
    char key[64];

    snprintf(key, sizeof key, "Segment%u_%s", index, field);
    return nrrdKeyValueGet(nrrd, key);
}

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

/* One segment of Slicer's header; unreadable parts are left out with a warning. */
static sc_status read_segment(const sc_ctx *ctx, const char *path, const Nrrd *nrrd, unsigned index,
                              sc_label_table *table)
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
    snprintf(row.name, sizeof row.name, "%s", name ? name : "");
    for (char *c = row.name; *c; c++)
        *c = (unsigned char)*c < ' ' || *c == 127 ? ' ' : *c;
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

static sc_status read_segments(const sc_ctx *ctx, const char *path, const Nrrd *nrrd,
                               sc_label_table *table)
{
    sc_status status = SC_OK;

    for (unsigned i = 0; i < SC_LABELS_MAX && status == SC_OK; i++) {
        char *id = segment_value(nrrd, i, "ID");
        char *value = segment_value(nrrd, i, "LabelValue");
        const bool exists = id || value;

        free(id);
        free(value);
        if (!exists)
            break;
        status = read_segment(ctx, path, nrrd, i, table);
    }
    return status;
}

/* Bytes of the files that hold the voxels; -1 if that cannot be told from the header. */
static double data_file_bytes(const char *path, const NrrdIoState *nio)
{
    double total = 0;
    struct stat info;

    if (nio->dataFNFormat)
        return -1;
    if (!nio->dataFNArr || nio->dataFNArr->len == 0)
        return stat(path, &info) ? -1 : (double)info.st_size;
    for (unsigned i = 0; i < nio->dataFNArr->len; i++) {
        char name[4096];

        if (nio->dataFN[i][0] == '/' || !nio->path || !nio->path[0])
            snprintf(name, sizeof name, "%s", nio->dataFN[i]);
        else
            snprintf(name, sizeof name, "%s/%s", nio->path, nio->dataFN[i]);
        if (stat(name, &info))
            return -1; /* the real read names the missing file */
        total += (double)info.st_size;
    }
    return total;
}

static sc_status check_sizes(const sc_ctx *ctx, const char *path, const Nrrd *nrrd,
                             const NrrdIoState *nio, sc_raw *raw)
{
    const size_t bytes_each = sc_raw_type_bytes(raw->type);
    int64_t size[3];
    int axes[3];
    size_t voxels;
    double bytes, limit = data_file_bytes(path, nio);
    sc_status status;

    if (nio->byteSkip < -1)
        return sc_fail(ctx, SC_ERR_DATA, "%s: byte skip is %ld, expected -1, 0 or more", path,
                       nio->byteSkip);
    SC_TRY(spatial_axes(ctx, path, nrrd, axes));
    for (int i = 0; i < 3; i++)
        size[i] =
            nrrd->axis[axes[i]].size > INT32_MAX ? INT64_MAX : (int64_t)nrrd->axis[axes[i]].size;
    SC_TRY(sc_grid_voxels(ctx, path, size, bytes_each, &voxels));
    for (int i = 0; i < 3; i++)
        raw->size[i] = (int)size[i];
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
        status = geometry(ctx, path, nrrd, axes, raw);
out:
    return status;
}

/* A header that lists its data files must be text to its end: Teem reads on behind a list that is
 * none. @return SC_ERR_DATA with the byte. */
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

static sc_status load(const sc_ctx *ctx, const char *path, bool header_only, Nrrd *nrrd,
                      NrrdIoState *nio)
{
    nrrdStateVerboseIO = 0; /* errors are told by us, once */
    nio->skipData = header_only ? AIR_TRUE : AIR_FALSE;
    errno = 0;
    if (nrrdLoad(nrrd, path, nio))
        return teem_error(ctx, path);
    if (nio->format && nio->format != nrrdFormatNRRD)
        return sc_fail(ctx, SC_ERR_DATA, "%s: is %s, expected NRRD", path, nio->format->name);
    return SC_OK;
}

/* Teem wraps ascii numbers that do not fit the type; the text itself tells. Checked where the text
 * stands in this very file, behind the blank line. */
static sc_status check_ascii(const sc_ctx *ctx, const char *path, const NrrdIoState *io,
                             const sc_raw *raw)
{
    static const double lowest[] = {-128, 0, -32768, 0, -2147483648.0, 0};
    static const double highest[] = {127, 255, 32767, 65535, 2147483647.0, 4294967295.0};
    char *text = NULL, *at, *end;
    size_t bytes;
    sc_status status;

    if (io->encoding != nrrdEncodingAscii || raw->type > SC_RAW_UINT32 || io->lineSkip ||
        (io->dataFNArr && io->dataFNArr->len > 0))
        return SC_OK;
    status = sc_file_read(ctx, path, SIZE_MAX / 2, &text, &bytes);
    if (status != SC_OK)
        return status;
    at = strstr(text, "\n\n") ? strstr(text, "\n\n") : strstr(text, "\n\r\n");
    for (double value; at && status == SC_OK; at = end) {
        value = strtod(at, &end);
        if (end == at)
            break;
        if (value < lowest[raw->type] || value > highest[raw->type])
            status = sc_fail(ctx, SC_ERR_DATA,
                             "%s: byte %td holds %.15g, which does not fit its "
                             "type",
                             path, at - text, value);
        end += strspn(end, ", \t\r\n");
    }
    sc_free(text);
    return status;
}

sc_status sc_read_nrrd(const sc_ctx *ctx, const char *path, sc_raw *out)
{
    Nrrd *header = nrrdNew(), *nrrd = nrrdNew();
    NrrdIoState *header_io = nrrdIoStateNew(), *io = nrrdIoStateNew();
    sc_raw raw = {.slope = 1, .release = free};
    sc_status status;

    if (!header || !nrrd || !header_io || !io) {
        status = sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
        goto out;
    }
    SC_TRY(check_list(ctx, path));
    SC_TRY(load(ctx, path, true, header, header_io));
    SC_TRY(raw_type(ctx, path, header->type, &raw.type));
    SC_TRY(check_sizes(ctx, path, header, header_io, &raw));
    SC_TRY(load(ctx, path, false, nrrd, io));
    SC_TRY(check_ascii(ctx, path, io, &raw));
    SC_TRY(read_segments(ctx, path, nrrd, &raw.table));
    raw.data = nrrd->data;
    nrrdNix(nrrd); /* keeps the voxels, frees the rest */
    nrrd = NULL;
    *out = raw;
    raw = (sc_raw){0};
out:
    sc_raw_clear(&raw);
    nrrdNuke(header);
    nrrdNuke(nrrd);
    nrrdIoStateNix(header_io);
    nrrdIoStateNix(io);
    return status;
}
