/* SPDX-License-Identifier: BSD-3-Clause */
/* MetaImage (.mha, .mhd): "Key = value" lines, then voxels in the same file or in one beside it.
 * Grammar after ITK's MetaIO documentation. CompressedDataSize is not needed and not trusted. */
#include "raw.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <zlib.h>

enum { HEADER_MAX_BYTES = 1 << 16, VALUE_BYTES = 512 };

typedef struct meta {
    const sc_ctx *ctx;
    const char *path;
    int64_t size[3];
    int dimensions;
    double spacing[3], offset[3], matrix[9];
    char anatomy[8], element_type[32], data_file[VALUE_BYTES];
    bool compressed, msb, has_matrix, has_size;
    long header_bytes; /* where the voxels of an .mha begin */
} meta;

/* Read up to @p count numbers; @return how many there were. */
static int numbers(const char *text, int count, double *out)
{
    char *end;
    int found = 0;

    while (found < count) {
        const double value = strtod(text, &end);

        if (end == text)
            break;
        out[found++] = value;
        text = end;
    }
    return found;
}

static bool truth(const char *value)
{
    return value[0] == 'T' || value[0] == 't' || value[0] == '1';
}

static bool parse_size(meta *m, const char *value)
{
    double size[3];

    m->has_size = numbers(value, 3, size) == 3;
    for (int i = 0; i < 3 && m->has_size; i++)
        m->size[i] = size[i] >= 0 && size[i] < 1e15 ? (int64_t)size[i] : -1;
    return m->has_size;
}

/* One "Key = value" line. @return false if the value cannot be read. */
static bool parse_field(meta *m, const char *key, const char *value)
{
    if (!strcmp(key, "NDims"))
        m->dimensions = atoi(value);
    else if (!strcmp(key, "DimSize"))
        return parse_size(m, value);
    else if (!strcmp(key, "ElementSpacing") || (!strcmp(key, "ElementSize") && m->spacing[0] == 0))
        return numbers(value, 3, m->spacing) == 3;
    else if (!strcmp(key, "Offset") || !strcmp(key, "Position") || !strcmp(key, "Origin"))
        return numbers(value, 3, m->offset) == 3;
    else if (!strcmp(key, "TransformMatrix") || !strcmp(key, "Rotation") ||
             !strcmp(key, "Orientation"))
        return m->has_matrix = numbers(value, 9, m->matrix) == 9;
    else if (!strcmp(key, "AnatomicalOrientation"))
        snprintf(m->anatomy, sizeof m->anatomy, "%.7s", value);
    else if (!strcmp(key, "ElementType"))
        snprintf(m->element_type, sizeof m->element_type, "%.31s", value);
    else if (!strcmp(key, "CompressedData"))
        m->compressed = truth(value);
    else if (!strcmp(key, "BinaryDataByteOrderMSB") || !strcmp(key, "ElementByteOrderMSB"))
        m->msb = truth(value);
    else if (!strcmp(key, "ElementNumberOfChannels"))
        return atoi(value) == 1;
    else if (!strcmp(key, "ElementDataFile"))
        snprintf(m->data_file, sizeof m->data_file, "%s", value);
    return true;
}

static char *trim(char *text)
{
    char *end;

    while (*text == ' ' || *text == '\t')
        text++;
    end = text + strlen(text);
    while (end > text && strchr(" \t\r\n", end[-1]))
        *--end = '\0';
    return text;
}

static sc_status parse_header(meta *m, FILE *stream)
{
    char line[VALUE_BYTES];
    int number = 0;

    while (fgets(line, sizeof line, stream) && ftell(stream) < HEADER_MAX_BYTES) {
        char *equals = strchr(line, '='), *key, *value;

        number++;
        if (!equals)
            return sc_fail(m->ctx, SC_ERR_DATA, "%s:%d: expected \"Key = value\"", m->path, number);
        *equals = '\0';
        key = trim(line);
        value = trim(equals + 1);
        if (!parse_field(m, key, value))
            return sc_fail(m->ctx, SC_ERR_DATA, "%s:%d: %s is \"%.60s\", which is not supported",
                           m->path, number, key, value);
        if (m->data_file[0]) {
            m->header_bytes = ftell(stream);
            return SC_OK;
        }
    }
    return sc_fail(m->ctx, SC_ERR_DATA, "%s: has no ElementDataFile", m->path);
}

static sc_status element_type(const meta *m, sc_raw_type *out)
{
    static const char *const names[] = {"MET_CHAR",  "MET_UCHAR", "MET_SHORT",     "MET_USHORT",
                                        "MET_INT",   "MET_UINT",  "MET_LONG_LONG", "MET_ULONG_LONG",
                                        "MET_FLOAT", "MET_DOUBLE"};
    const char *nearest;

    for (size_t i = 0; i < SC_COUNT_OF(names); i++) {
        if (!strcmp(m->element_type, names[i])) {
            *out = (sc_raw_type)i;
            return SC_OK;
        }
    }
    nearest = sc_nearest_word(m->element_type, names, SC_COUNT_OF(names));
    return sc_fail(m->ctx, SC_ERR_DATA, "%s: ElementType is \"%s\"; expected for example %s",
                   m->path, m->element_type, nearest ? nearest : "MET_UCHAR");
}

/* World axes are left, posterior, superior (DICOM); columns of the matrix are the voxel axes. */
static void geometry(const meta *m, sc_raw *raw)
{
    static const double ras[3] = {-1, -1, 1};

    for (int row = 0; row < 3; row++) {
        for (int axis = 0; axis < 3; axis++) {
            const double direction = m->has_matrix ? m->matrix[3 * axis + row] : row == axis;
            const double spacing = m->spacing[axis] != 0 ? m->spacing[axis] : 1;

            raw->to_ras_mm.m[row][axis] = ras[row] * direction * spacing;
        }
        raw->to_ras_mm.m[row][3] = ras[row] * m->offset[row];
    }
    raw->oriented = m->has_matrix && m->anatomy[0] != '?';
}

/* A name that leads out of the header's folder, or names many files, is refused. */
static sc_status data_path(const meta *m, char **out)
{
    const char *slash = strrchr(m->path, '/');
    char directory[4096];

    if (!strcmp(m->data_file, "LOCAL"))
        return sc_path_join(m->ctx, "", m->path, out);
    if (m->data_file[0] == '/' || strstr(m->data_file, ".."))
        return sc_fail(m->ctx, SC_ERR_DATA,
                       "%s: ElementDataFile is \"%s\", expected a file beside the header", m->path,
                       m->data_file);
    if (strchr(m->data_file, '%') || !strncmp(m->data_file, "LIST", 4))
        return sc_fail(m->ctx, SC_ERR_DATA,
                       "%s: ElementDataFile is \"%s\"; series of files are not supported", m->path,
                       m->data_file);
    snprintf(directory, sizeof directory, "%.*s", slash ? (int)(slash - m->path) : 0, m->path);
    return sc_path_join(m->ctx, directory, m->data_file, out);
}

static sc_status inflate_voxels(const meta *m, const char *file, uint64_t offset, void *data,
                                size_t bytes)
{
    char *packed = NULL;
    size_t packed_bytes;
    z_stream z = {0};
    int result;
    sc_status status = sc_file_read(m->ctx, file, SIZE_MAX / 2, &packed, &packed_bytes);

    if (status != SC_OK)
        return status;
    if (inflateInit2(&z, 15 + 32) != Z_OK) {
        status = sc_fail(m->ctx, SC_ERR_MEMORY, "%s: out of memory", file);
        goto out;
    }
    for (size_t in = offset, at = 0; status == SC_OK && at < bytes;) {
        const size_t in_step = packed_bytes - in < 1 << 30 ? packed_bytes - in : 1 << 30;
        const size_t out_step = bytes - at < 1 << 30 ? bytes - at : 1 << 30;

        z.next_in = (Bytef *)packed + in;
        z.avail_in = (uInt)in_step;
        z.next_out = (Bytef *)data + at;
        z.avail_out = (uInt)out_step;
        result = inflate(&z, Z_NO_FLUSH);
        in += in_step - z.avail_in;
        at += out_step - z.avail_out;
        if ((result != Z_OK || in_step == 0) && at < bytes)
            status =
                sc_fail(m->ctx, SC_ERR_DATA, "%s: unpacks to %zu bytes of voxels, expected %zu%s%s",
                        file, at, bytes, z.msg ? "; " : "", z.msg ? z.msg : "");
    }
    inflateEnd(&z);
out:
    sc_free(packed);
    return status;
}

static sc_status plain_voxels(const meta *m, const char *file, uint64_t offset, void *data,
                              size_t bytes)
{
    FILE *stream = fopen(file, "rb");
    size_t got = 0;

    if (!stream)
        return sc_fail(m->ctx, SC_ERR_MISSING, "%s: %s", file, strerror(errno));
    if (!fseek(stream, (long)offset, SEEK_SET))
        got = fread(data, 1, bytes, stream);
    fclose(stream);
    if (got < bytes)
        return sc_fail(m->ctx, SC_ERR_DATA, "%s: ends after %zu bytes of voxels, expected %zu",
                       file, got, bytes);
    return SC_OK;
}

static sc_status read_voxels(const meta *m, sc_raw *raw)
{
    const size_t each = sc_raw_type_bytes(raw->type);
    const uint64_t offset = strcmp(m->data_file, "LOCAL") ? 0 : (uint64_t)m->header_bytes;
    struct stat info;
    char *file = NULL;
    size_t voxels;
    sc_status status;

    SC_TRY(sc_grid_voxels(m->ctx, m->path, m->size, each, &voxels));
    SC_TRY(data_path(m, &file));
    if (stat(file, &info)) {
        status = sc_fail(m->ctx, SC_ERR_DATA, "%s: the file of its voxels, %s: %s", m->path, file,
                         strerror(errno));
        goto out;
    }
    if ((double)voxels * (double)each >
        (double)info.st_size * (m->compressed ? SC_DEFLATE_RATIO_MAX : 1)) {
        status = sc_fail(m->ctx, SC_ERR_DATA,
                         "%s: the header promises %zu voxels, more than %s can hold (%lld bytes)",
                         m->path, voxels, file, (long long)info.st_size);
        goto out;
    }
    SC_TRY(sc_alloc(m->ctx, voxels, each, &raw->data));
    SC_TRY(
        (m->compressed ? inflate_voxels : plain_voxels)(m, file, offset, raw->data, voxels * each));
    if (m->msb && each > 1) {
        unsigned char *b = raw->data;

        for (size_t i = 0; i < voxels * each; i += each) {
            for (size_t j = 0; j < each / 2; j++) {
                const unsigned char swap = b[i + j];

                b[i + j] = b[i + each - 1 - j];
                b[i + each - 1 - j] = swap;
            }
        }
    }
out:
    sc_free(file);
    return status;
}

sc_status sc_read_meta(const sc_ctx *ctx, const char *path, sc_raw *out)
{
    meta m = {.ctx = ctx, .path = path, .dimensions = 3};
    sc_raw raw = {.slope = 1, .release = sc_free};
    FILE *stream = fopen(path, "rb");
    sc_status status;

    if (!stream)
        return sc_fail(ctx, SC_ERR_MISSING, "%s: %s", path, strerror(errno));
    SC_TRY(parse_header(&m, stream));
    if (m.dimensions != 3 || !m.has_size) {
        status = sc_fail(ctx, SC_ERR_DATA, "%s: NDims is %d and DimSize is %s; expected 3 axes",
                         path, m.dimensions, m.has_size ? "given" : "missing");
        goto out;
    }
    SC_TRY(element_type(&m, &raw.type));
    geometry(&m, &raw);
    SC_TRY(sc_geometry_check(ctx, path, &raw.to_ras_mm));
    SC_TRY(read_voxels(&m, &raw));
    for (int i = 0; i < 3; i++)
        raw.size[i] = (int)m.size[i];
    *out = raw;
    raw = (sc_raw){0};
out:
    fclose(stream);
    sc_raw_clear(&raw);
    return status;
}
