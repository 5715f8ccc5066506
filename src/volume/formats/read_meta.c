/* SPDX-License-Identifier: BSD-3-Clause */
/* MetaImage (.mha, .mhd): lines "Key = value", then the voxels, in the same file or in one beside
 * it. Source: the MetaIO documentation of ITK. The key CompressedDataSize is not used: the
 * compressed stream itself says where it ends, and in some files the key is too small.
 */
#include "formats/meta_files.h"
#include "tables/label_table.h"

#include <stdlib.h>
#include <strings.h>

enum {
    HEADER_MAX_BYTES = 1 << 20, /* a longer header is refused */
    DIMENSIONS_MAX = 8          /* axes of a file whose further axes are of one voxel */
};

/* The header while it is read. Keys that the file does not give keep their zero, except for
 * dimensions. */
typedef struct meta {
    const sc_ctx *ctx;
    const char *path; /* of the header; borrowed */
    char *text;       /* the begin of the file, cut into lines and values; owned */
    int64_t size[3];
    int dimensions;
    double spacing[3], offset[3]; /* in unit_mm, along the voxel axes and the file's world axes */
    double matrix[9];             /* [voxel axis][world axis] */
    const char *anatomy, *element_type; /* in text, or a constant */
    sc_meta_series series;              /* texts of it are in text */
    bool msb, has_matrix, has_size;
    bool is_series;   /* there are more than three axes of more than one voxel */
    double unit_mm;   /* of spacing and offset */
    bool is_text;     /* the voxels are decimal digits */
    size_t end_bytes; /* where in an .mha the voxels begin, unless HeaderSize tells it */
} meta;

/* Read up to @p count numbers separated by blanks into out[count]. @return how many there were. */
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

/* Is a value of MetaImage true? ITK writes "True", others "T" or "1": the first letter tells. */
static bool truth(const char *value)
{
    return value[0] == 'T' || value[0] == 't' || value[0] == '1';
}

/* @return whether a key is @p name; MetaImage is also written with other capitals. */
static bool is_key(const char *key, const char *name)
{
    return !strcasecmp(key, name);
}

/* Set m->size and m->has_size, and m->dimensions to 3 where the axes behind the third are of one
 * voxel. A size that is negative or too large becomes -1, which sc_grid_voxels refuses. @return
 * false unless there are three numbers. */
static bool parse_size(meta *m, const char *value)
{
    double size[DIMENSIONS_MAX];
    const int count = numbers(value, DIMENSIONS_MAX, size);
    int axes = count;

    m->has_size = count >= 3;
    for (int i = 0; i < 3 && m->has_size; i++)
        m->size[i] = size[i] >= 0 && size[i] < 1e15 ? (int64_t)size[i] : -1;
    while (axes > 3 && size[axes - 1] == 1)
        axes--;
    m->is_series = axes > 3;
    return m->has_size;
}

/* Store the directions of the axes. Of more axes than three, the others are left out. @return false
 * if there are too few numbers. */
static bool parse_matrix(meta *m, const char *value)
{
    const int axes = m->dimensions;
    double matrix[DIMENSIONS_MAX * DIMENSIONS_MAX];

    if (axes < 3 || axes > DIMENSIONS_MAX || numbers(value, axes * axes, matrix) != axes * axes)
        return false;
    for (int axis = 0; axis < 3; axis++) {
        for (int row = 0; row < 3; row++)
            m->matrix[3 * axis + row] = matrix[axes * axis + row];
    }
    return m->has_matrix = true;
}

/* Store the value of one "Key = value" line in @p m. Keys are known in any case; those that segcast
 * does not need are ignored. @return false if the value cannot be read or is not supported. */
static bool parse_field(meta *m, const char *key, char *value)
{
    if (is_key(key, "NDims"))
        m->dimensions = atoi(value);
    else if (is_key(key, "DimSize"))
        return parse_size(m, value);
    else if (is_key(key, "ElementSpacing") || (is_key(key, "ElementSize") && m->spacing[0] == 0))
        return numbers(value, 3, m->spacing) == 3;
    else if (is_key(key, "Offset") || is_key(key, "Position") || is_key(key, "Origin"))
        return numbers(value, 3, m->offset) == 3;
    else if (is_key(key, "TransformMatrix") || is_key(key, "Rotation") ||
             is_key(key, "Orientation"))
        return parse_matrix(m, value);
    else if (is_key(key, "AnatomicalOrientation"))
        m->anatomy = value;
    else if (is_key(key, "DistanceUnits"))
        return (m->unit_mm = strcmp(value, "?") ? sc_length_unit_mm(value) : 1) > 0;
    else if (is_key(key, "ElementType"))
        m->element_type = value;
    else if (is_key(key, "CompressedData"))
        m->series.compressed = truth(value);
    else if (is_key(key, "BinaryData"))
        m->is_text = !truth(value);
    else if (is_key(key, "HeaderSize"))
        return (m->series.header_bytes = strtoll(value, NULL, 10)) >= SC_META_AT_END;
    else if (is_key(key, "BinaryDataByteOrderMSB") || is_key(key, "ElementByteOrderMSB"))
        m->msb = truth(value);
    else if (is_key(key, "ElementNumberOfChannels"))
        return atoi(value) == 1;
    else if (is_key(key, "ElementDataFile"))
        m->series.names = value;
    return true;
}

/* Read the first HEADER_MAX_BYTES bytes of the file into m->text, with a NUL byte behind them. */
static sc_status read_text(meta *m)
{
    SC_OWN(sc_fclose_at) FILE *stream = NULL;

    SC_PASS(sc_open_input(m->ctx, m->path, &stream));
    SC_PASS(sc_alloc(m->ctx, HEADER_MAX_BYTES + 1, 1, &m->text));
    m->text[fread(m->text, 1, HEADER_MAX_BYTES, stream)] = '\0';
    return SC_OK;
}

/* Read the lines of m->text into @p m up to ElementDataFile, which is the last key, and set
 * header_bytes behind it. The values stay in the text. @return SC_ERR_DATA with the line, also if
 * that key does not come within HEADER_MAX_BYTES. */
static sc_status parse_header(meta *m)
{
    char *next = NULL;
    int number = 0;

    for (char *line = m->text; *line; line = next) {
        char *end = strchr(line, '\n'), *equals, *key, *value;

        next = end ? end + 1 : line + strlen(line);
        if (end)
            *end = '\0';
        number++;
        equals = strchr(line, '=');
        if (!equals)
            return sc_fail(m->ctx, SC_ERR_DATA, "%s:%d: expected \"Key = value\"", m->path, number);
        *equals = '\0';
        key = sc_label_trim(line);
        value = sc_label_trim(equals + 1);
        if (!parse_field(m, key, value))
            return sc_fail(m->ctx, SC_ERR_DATA, "%s:%d: %.60s is \"%.60s\", which is not supported",
                           m->path, number, key, value);
        if (m->series.names && m->series.names[0]) {
            m->end_bytes = (size_t)(next - m->text);
            m->series.list = next;
            return SC_OK;
        }
    }
    return sc_fail(m->ctx, SC_ERR_DATA, "%s: has no ElementDataFile in its first %d bytes", m->path,
                   HEADER_MAX_BYTES);
}

/* Write the type of the voxels to *out. @return SC_ERR_DATA with the nearest name that is
 * known. */
static sc_status element_type(const meta *m, sc_voxel_type *out)
{
    static const char *const names[SC_VOXEL_TYPES] = {
        "MET_CHAR", "MET_UCHAR",     "MET_SHORT",      "MET_USHORT", "MET_INT",
        "MET_UINT", "MET_LONG_LONG", "MET_ULONG_LONG", "MET_FLOAT",  "MET_DOUBLE"};
    const char *nearest, *name = m->element_type;

    if (!strcmp(name, "MET_LONG")) /* MetaIO: four bytes on every machine */
        name = "MET_INT";
    else if (!strcmp(name, "MET_ULONG"))
        name = "MET_UINT";
    if (sc_voxel_type_named(name, names, out))
        return SC_OK;
    nearest = sc_nearest_word(m->element_type, names, SC_COUNT_OF(names));
    return sc_fail(m->ctx, SC_ERR_DATA, "%s: ElementType is \"%.60s\"; expected for example %s",
                   m->path, m->element_type, nearest ? nearest : "MET_UCHAR");
}

/* Are the voxels in the file of the header? */
static bool is_local(const meta *m)
{
    return !strcmp(m->series.names, "LOCAL") || !strcmp(m->series.names, "Local") ||
           !strcmp(m->series.names, "local");
}

/* Set to_ras_mm and oriented of @p source. The file's world axes point to the left, posterior
 * and superior (as in DICOM). TransformMatrix lists the direction of one voxel axis after the
 * other; without it the voxel axes are the world axes. A spacing that is 0 or not given is 1
 * mm. */
static void geometry(const meta *m, sc_source *source)
{
    static const double ras[3] = {-1, -1, 1};

    for (int row = 0; row < 3; row++) {
        for (int axis = 0; axis < 3; axis++) {
            const double direction = m->has_matrix ? m->matrix[3 * axis + row] : row == axis;
            const double spacing = m->spacing[axis] != 0 ? m->spacing[axis] * m->unit_mm : 1;

            source->to_ras_mm.m[row][axis] = ras[row] * direction * spacing;
        }
        source->to_ras_mm.m[row][3] = ras[row] * m->offset[row] * m->unit_mm;
    }
    if (m->spacing[0] == 0 || m->spacing[1] == 0 || m->spacing[2] == 0)
        sc_warn_without_spacing(m->ctx, m->path, "ElementSpacing");
    source->oriented = m->has_matrix && m->anatomy[0] != '?';
}

/* Make the path of the one file with the voxels, and find its size. Refused with SC_ERR_DATA is
 * what sc_data_file refuses. Caller owns *out: sc_free. */
static sc_status data_path(const meta *m, char **out, uint64_t *bytes)
{
    if (!is_local(m))
        return sc_data_file(m->ctx, m->path, "ElementDataFile", m->series.names, out, bytes);
    SC_PASS(sc_input_bytes(m->ctx, m->path, bytes));
    return sc_path_join(m->ctx, "", m->path, out);
}

/* Set file, encoding and offset_bytes of @p source, whose size and type are set, from one file.
 * @return SC_ERR_DATA if the file is not there or cannot hold @p voxels. */
static sc_status find_file(const meta *m, size_t voxels, sc_source *source)
{
    const size_t each = m->is_text ? 1 : sc_voxel_type_bytes(source->type); /* at least */
    const uint64_t needed = (uint64_t)voxels * each;
    uint64_t bytes = 0;

    SC_PASS(data_path(m, &source->stored.file, &bytes));
    source->stored.encoding = m->series.compressed ? SC_ENCODING_ZLIB : SC_ENCODING_PLAIN;
    source->stored.offset_bytes = m->series.header_bytes > 0 ? (uint64_t)m->series.header_bytes
                                  : is_local(m)              ? (uint64_t)m->end_bytes
                                                             : 0;
    if (m->series.header_bytes == SC_META_AT_END && !m->series.compressed && !m->is_text &&
        bytes >= needed)
        source->stored.offset_bytes = bytes - needed;
    bytes -= source->stored.offset_bytes < bytes ? source->stored.offset_bytes : bytes;
    if ((double)needed > (double)bytes * (m->series.compressed ? SC_DEFLATE_RATIO_MAX : 1))
        return sc_fail(m->ctx, SC_ERR_DATA,
                       "%s: the header promises %zu voxels, more than %s can hold (%llu bytes)",
                       m->path, voxels, source->stored.file, (unsigned long long)bytes);
    return m->is_text ? sc_meta_open_text(m->ctx, source) : SC_OK;
}

/* Set size, what tells where the voxels are, and swapped of @p source, whose type is set. @return
 * SC_ERR_DATA if the files with the voxels are not there or cannot hold as many as the header
 * promises. */
static sc_status find_voxels(const meta *m, sc_source *source)
{
    const size_t each = sc_voxel_type_bytes(source->type);
    size_t voxels;

    SC_PASS(sc_grid_voxels(m->ctx, m->path, m->size, each, source->size, &voxels));
    if (m->is_text && (m->series.compressed || sc_meta_is_series(m->series.names)))
        return sc_fail(m->ctx, SC_ERR_DATA,
                       "%s: BinaryData is False, and the voxels are compressed or in several "
                       "files; expected digits in one file, or BinaryData = True",
                       m->path);
    source->stored.swapped = m->msb != (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__) && each > 1;
    return sc_meta_is_series(m->series.names)
               ? sc_meta_open_series(m->ctx, m->path, &m->series, source)
               : find_file(m, voxels, source);
}

/* For SC_OWN. */
static void clear(meta *m)
{
    sc_free(m->text);
}

sc_status sc_open_meta(const sc_ctx *ctx, const char *path, sc_source *out)
{
    SC_OWN(clear)
    meta m = {
        .ctx = ctx, .path = path, .dimensions = 3, .unit_mm = 1, .anatomy = "", .element_type = ""};
    SC_OWN(sc_source_clear) sc_source source = {.slope = 1};

    SC_PASS(read_text(&m));
    SC_PASS(parse_header(&m));
    if (m.dimensions < 3 || m.is_series || !m.has_size)
        return sc_fail(ctx, SC_ERR_DATA, "%s: NDims is %d and DimSize is %s; expected 3 axes%s",
                       path, m.dimensions, m.has_size ? "given" : "missing",
                       m.dimensions > 3 ? "; save the one volume wanted of the series, for example "
                                          "in 3D Slicer or with SimpleITK: image[:, :, :, 0]"
                                        : "");
    SC_PASS(element_type(&m, &source.type));
    geometry(&m, &source);
    SC_PASS(find_voxels(&m, &source));
    SC_HAND_OVER(source, out);
    return SC_OK;
}
