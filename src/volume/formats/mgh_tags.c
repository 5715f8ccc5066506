/* SPDX-License-Identifier: BSD-3-Clause */
/* Behind the voxels of an MGH file stand five numbers of the scanner and then tags, of which the
 * colour table of labels is read. All numbers have the highest byte first. Source: FreeSurfer's
 * description of its formats (MghFormat, LabelsClutsAnnotationFiles), and files that mri_convert
 * and recon-all of FreeSurfer 7 have written. */
#include "bytes.h"
#include "compressed_file.h"
#include "tables/label_table.h"

enum {
    SCAN_BYTES = 20, /* repetition time, flip angle, echo time, inversion time, field of view */
    TAG_OLD_COLOR_TABLE = 1, /* its data follow at once, without a length */
    TAG_OLD_REAL_RAS = 2,    /* neither a length nor data follows this tag */
    TAG_COLOR_TABLE = 5,
    TAG_OLD_SURFACE_GEOMETRY =
        20, /* has a length of four bytes, as the next one; others of eight */
    TAG_OLD_TRANSFORM = 30,
    TAGS_MAX = 4096,  /* more are not followed */
    TEXT_BYTES = 4096 /* names are longer nowhere; what is beyond is left out */
};

/* The file while its tags are read. */
typedef struct tag_reading {
    const sc_ctx *ctx;
    const char *path;
    sc_compressed_file *file;
    uint64_t left; /* bytes that may still be unpacked */
    sc_name_count names;
    sc_label_table *table;
} tag_reading;

/* Read @p bytes bytes to @p out. @return false where the file ends before or cannot be unpacked,
 * which the reader of the voxels notices. */
static bool read_bytes(tag_reading *r, void *out, size_t bytes)
{
    if (bytes > r->left || sc_compressed_read(r->file, out, bytes) != bytes)
        return false;
    r->left -= bytes;
    return true;
}

static bool skip_bytes(tag_reading *r, int64_t bytes)
{
    if (bytes < 0 || (uint64_t)bytes > r->left ||
        sc_compressed_skip(r->file, (uint64_t)bytes) != (uint64_t)bytes)
        return false;
    r->left -= (uint64_t)bytes;
    return true;
}

/* Read a number of @p bytes bytes, 4 or 8. */
static bool read_number(tag_reading *r, int bytes, int64_t *out)
{
    unsigned char b[8];

    if (!read_bytes(r, b, (size_t)bytes))
        return false;
    *out = (int64_t)sc_number_at(b, bytes, true);
    *out = bytes == 4 ? (int32_t)*out : *out;
    return true;
}

/* Read a number of four bytes. */
static bool read_whole(tag_reading *r, int64_t *out)
{
    return read_number(r, 4, out);
}

/* Read a text behind its length, which counts a NUL byte at its end, to @p out[TEXT_BYTES]. */
static bool read_text(tag_reading *r, char *out)
{
    int64_t bytes;
    size_t kept;

    if (!read_whole(r, &bytes) || bytes < 0)
        return false;
    kept = bytes < TEXT_BYTES ? (size_t)bytes : TEXT_BYTES - 1;
    out[kept] = '\0';
    return read_bytes(r, out, kept) && skip_bytes(r, bytes - (int64_t)kept);
}

/* Read one row behind its number, and append it. *status is SC_ERR_MEMORY if there is no memory.
 * @return false if there is none, or if the file ends. */
static bool read_row(tag_reading *r, int64_t value, sc_status *status)
{
    char name[TEXT_BYTES];
    sc_label row = {.value = value, .has_color = true, .opacity = -1};
    int64_t level[4]; /* red, green, blue, transparency */

    if (!read_text(r, name))
        return false;
    for (int i = 0; i < 4; i++) {
        if (!read_whole(r, &level[i]))
            return false;
        level[i] = level[i] < 0 ? 0 : level[i] > 255 ? 255 : level[i];
    }
    if (value == 0)
        return true;
    sc_name_read(name, row.name, &r->names);
    for (int i = 0; i < 3; i++)
        row.rgb[i] = (uint8_t)level[i];
    if (level[3] > 0)
        row.opacity = (float)(255 - level[3]) / 255;
    row.hidden = level[3] == 255;
    *status = sc_label_table_add(r->ctx, r->table, &row);
    return *status == SC_OK;
}

/* Read a colour table. Version 1 has one row for each number from 0 on; version 2, rows with their
 * numbers. @return false if it is damaged. */
static bool read_color_table(tag_reading *r, sc_status *status)
{
    char text[TEXT_BYTES];
    int64_t first, rows;
    bool numbered;

    if (!read_whole(r, &first))
        return false;
    numbered = first == -2;
    if (numbered ? !read_whole(r, &rows) : first < 0) /* of version 2: the largest number, plus 1 */
        return false;
    if (!read_text(r, text)) /* the file that the table was from */
        return false;
    if (numbered ? !read_whole(r, &rows) : (rows = first, false))
        return false;
    if (rows < 0 || rows > SC_TABLE_ROWS_MAX)
        return false;
    for (int64_t i = 0; i < rows; i++) {
        int64_t value = i;

        if ((numbered && !read_whole(r, &value)) || !read_row(r, value, status))
            return false;
    }
    return true;
}

/* Follow the tags to the colour table. @return SC_ERR_MEMORY only. */
static sc_status read_tags(tag_reading *r)
{
    const size_t rows_before = r->table->count;
    int64_t tag, length;
    sc_status status = SC_OK;

    if (!skip_bytes(r, SCAN_BYTES))
        return SC_OK;
    for (int i = 0; i < TAGS_MAX && read_whole(r, &tag) && tag > 0; i++) {
        length = 0;
        const bool is_short = tag == TAG_OLD_SURFACE_GEOMETRY || tag == TAG_OLD_TRANSFORM;

        if (tag != TAG_OLD_COLOR_TABLE && tag != TAG_OLD_REAL_RAS &&
            !read_number(r, is_short ? 4 : 8, &length))
            return SC_OK;
        if (tag == TAG_OLD_COLOR_TABLE || tag == TAG_COLOR_TABLE) {
            if (read_color_table(r, &status) || status != SC_OK)
                return status;
            r->table->count = rows_before;
            sc_warn(
                r->ctx,
                "%s: the colour table behind its voxels is damaged and not used; give names and "
                "colours by FreeSurfer's FreeSurferColorLUT.txt (--labels)",
                r->path);
            return SC_OK;
        }
        if (!skip_bytes(r, length))
            return SC_OK;
    }
    return SC_OK;
}

sc_status sc_mgh_labels(const sc_ctx *ctx, const char *path, uint64_t end, sc_label_table *table)
{
    SC_OWN(sc_compressed_close) sc_compressed_file *file = NULL;
    tag_reading r = {.ctx = ctx, .path = path, .left = SC_TABLE_BYTES_MAX, .table = table};

    SC_PASS(sc_compressed_open(ctx, path, 0, SC_COMPRESSION_GZIP, &file));
    r.file = file;
    if (sc_compressed_skip(file, end) == end)
        SC_PASS(read_tags(&r));
    SC_PASS(sc_compressed_check(ctx, file));
    sc_name_warn(ctx, path, &r.names);
    return SC_OK;
}
