/* SPDX-License-Identifier: BSD-3-Clause */
#include "bytes.h"
#include "compressed_file.h"
#include "tables/label_table.h"

enum { HEAD_BYTES = 8 /* of an extension: its size with this head, and its code */ };

/* Append the rows of the label table in the extension text[bytes], behind which a NUL byte stands,
 * to @p table; *found tells whether there is one. @return SC_ERR_MEMORY only. */
static sc_status read_table(const sc_ctx *ctx, const char *path, const char *text, size_t bytes,
                            sc_label_table *table, bool *found)
{
    char why[SC_XML_WHY_BYTES];
    const char *begin = text + strspn(text, " \t\r\n");
    sc_status status;

    *found = strstr(begin, "<LabelTable") != NULL;
    if (!*found)
        return SC_OK;
    bytes -= (size_t)(begin - text);
    while (bytes && !begin[bytes - 1]) /* extensions are filled up to a multiple of 16 bytes */
        bytes--;
    status = sc_label_xml_parse(ctx, path, begin, bytes, table, why);
    if (status != SC_ERR_DATA)
        return status;
    sc_warn(ctx,
            "%s: the label table in its header is not used: %s; give its names and colours by "
            "a label table of their own",
            path, why);
    return SC_OK;
}

/* Read the extensions one by one until one holds a label table. */
static sc_status read_extensions(const sc_ctx *ctx, const char *path, sc_compressed_file *file,
                                 uint64_t left, bool swapped, sc_label_table *table)
{
    unsigned char head[HEAD_BYTES];
    bool found = false;
    sc_status status = SC_OK;

    while (!found && status == SC_OK && left >= HEAD_BYTES &&
           sc_compressed_read(file, head, HEAD_BYTES) == HEAD_BYTES) {
        const int64_t size = (int32_t)sc_number_at(head, 4, swapped == SC_IS_LITTLE_ENDIAN);
        size_t count;
        void *text;

        if (size < HEAD_BYTES || (uint64_t)size > left || size > SC_TABLE_BYTES_MAX) {
            sc_warn(ctx,
                    "%s: an extension of its header has %lld bytes, expected %d to %llu; labels "
                    "that are named behind it have no names",
                    path, (long long)size, HEAD_BYTES,
                    (unsigned long long)(left < SC_TABLE_BYTES_MAX ? left : SC_TABLE_BYTES_MAX));
            return SC_OK;
        }
        left -= (uint64_t)size;
        SC_PASS(sc_zalloc(ctx, (size_t)size - HEAD_BYTES + 1, 1, &text));
        count = sc_compressed_read(file, text, (size_t)size - HEAD_BYTES);
        status = read_table(ctx, path, text, count, table, &found);
        sc_free(text);
    }
    return status;
}

sc_status sc_nifti_labels(const sc_ctx *ctx, const char *path, uint64_t begin, uint64_t end,
                          bool swapped, sc_label_table *table)
{
    unsigned char extender[4] = {0};
    SC_OWN(sc_compressed_close) sc_compressed_file *file = NULL;

    if (end < begin + sizeof extender)
        return SC_OK;
    SC_PASS(sc_compressed_open(ctx, path, 0, SC_COMPRESSION_GZIP, &file));
    /* The first of four bytes says whether there are extensions. */
    if (sc_compressed_skip(file, begin) == begin &&
        sc_compressed_read(file, extender, sizeof extender) == sizeof extender && extender[0])
        SC_PASS(read_extensions(ctx, path, file, end - begin - sizeof extender, swapped, table));
    return sc_compressed_check(ctx, file);
}
