/* SPDX-License-Identifier: BSD-3-Clause */
/* NRRD with the Segment keys of 3D Slicer. Written without Teem, which cannot write through a file
 * that is open already; that is what makes the file appear whole or not at all. */
#include "bytes.h"
#include "segcast/grey.h"

#include <errno.h>
#include <unistd.h>
#include <zlib.h>

/* The integer types of NRRD that label values are written in, from the narrowest to the widest. */
static const struct {
    const char *name;
    int64_t lowest, highest;
    unsigned bytes;
} types[] = {{"uint8", 0, UINT8_MAX, 1},
             {"uint16", 0, UINT16_MAX, 2},
             {"int32", INT32_MIN, INT32_MAX, 4},
             {"int64", INT64_MIN, INT64_MAX, 8}};

/* Index into types of the narrowest type that holds all label values. */
static size_t type_for(const sc_volume *volume)
{
    size_t type = 0;

    for (int i = 0; i < volume->label_count; i++) {
        while (volume->labels[i].value < types[type].lowest ||
               volume->labels[i].value > types[type].highest)
            type++;
    }
    return type;
}

/* Append "Segment3_Name:=name", with a backslash before what would end the line or be taken for an
 * escape. */
static sc_status add_name(const sc_ctx *ctx, int segment, const char *field, const char *name,
                          sc_text *text)
{
    sc_status status = sc_text_add(ctx, text, "Segment%d_%s:=", segment, field);

    for (; *name && status == SC_OK; name++)
        status = *name == '\n'   ? sc_text_add(ctx, text, "\\n")
                 : *name == '\\' ? sc_text_add(ctx, text, "\\\\")
                                 : sc_text_add(ctx, text, "%c", *name);
    return status == SC_OK ? sc_text_add(ctx, text, "\n") : status;
}

/* Append the header to @p text, without the blank line that ends it: voxels of @p type in this
 * machine's byte order, encoding gzip. @param series NULL: there is one volume. The caller clears
 * the text, also after an error. @return SC_ERR_MEMORY. */
static sc_status grid_text(const sc_ctx *ctx, const char *type, const int size[3],
                           const sc_affine *m, const sc_volume_series *series, sc_text *text)
{
    SC_PASS(sc_text_add(ctx, text,
                        "NRRD0005\ntype: %s\ndimension: %d\nspace: right-anterior-superior\n"
                        "sizes: %d %d %d",
                        type, series ? 4 : 3, size[0], size[1], size[2]));
    SC_PASS(series ? sc_text_add(ctx, text, " %d\nspacings: nan nan nan %.17g\n", series->count,
                                 series->step_s)
                   : sc_text_add(ctx, text, "\n"));
    SC_PASS(sc_text_add(ctx, text, "space directions:"));
    for (int i = 0; i < 3; i++)
        SC_PASS(sc_text_add(ctx, text, " (%.17g,%.17g,%.17g)", m->m[0][i], m->m[1][i], m->m[2][i]));
    return sc_text_add(ctx, text,
                       "%s\nspace origin: (%.17g,%.17g,%.17g)\nkinds: domain domain domain%s\n"
                       "endian: %s\nencoding: gzip\n",
                       series ? " none" : "", m->m[0][3], m->m[1][3], m->m[2][3],
                       series ? " time\nunits: \"\" \"\" \"\" \"s\"" : "",
                       __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__ ? "big" : "little");
}

/* Append the whole header of a label volume to @p text: type of type_for, and a segment for each
 * label but background. The caller clears the text, also after an error. @return SC_ERR_MEMORY. */
static sc_status header_text(const sc_ctx *ctx, const sc_volume *volume,
                             const sc_volume_series *series, sc_text *text)
{
    SC_PASS(grid_text(ctx, types[type_for(volume)].name, volume->size, &volume->to_ras_mm, series,
                      text));
    for (int i = 1; i < volume->label_count; i++) {
        const sc_label *label = &volume->labels[i];

        SC_PASS(add_name(ctx, i - 1, "ID", label->name, text));
        SC_PASS(add_name(ctx, i - 1, "Name", label->name, text));
        SC_PASS(sc_text_add(ctx, text,
                            "Segment%d_LabelValue:=%lld\nSegment%d_Color:=%.6f %.6f %.6f\n", i - 1,
                            (long long)label->value, i - 1, label->rgb[0] / 255.0,
                            label->rgb[1] / 255.0, label->rgb[2] / 255.0));
    }
    return sc_text_add(ctx, text, "\n");
}

/* Write the label values of @p count voxels from voxel @p begin on to out[count], in the type
 * with index @p type. */
static void values_of(const sc_volume *volume, size_t begin, size_t count, size_t type, void *out)
{
    for (size_t i = 0; i < count; i++) {
        const int64_t value = volume->labels[sc_volume_id(volume, begin + i)].value;

        sc_number_put((uint64_t)value, types[type].bytes,
                      (unsigned char *)out + i * types[type].bytes);
    }
}

/* The voxels of a file: those of a label volume or of a grey one. */
typedef struct content {
    const sc_volume *labels; /* NULL: grey */
    const sc_grey *grey;
    size_t voxels, type;            /* index into types; of grey values not read */
    const sc_volume_series *series; /* labels is the first of its phases; NULL: there is one */
} content;

/* Write the grey values of @p count voxels from voxel @p begin on to out[count]. */
static void grey_values_of(const sc_grey *grey, size_t begin, size_t count, int16_t *out)
{
    for (size_t i = 0; i < count; i++) {
        const double value = floor(grey->low + grey->per_code * grey->codes[begin + i] + 0.5);

        out[i] = (int16_t)(value < INT16_MIN ? INT16_MIN : value > INT16_MAX ? INT16_MAX : value);
    }
}

/* Append the voxels of one volume to @p file. @return whether that failed, with errno set. */
static bool write_volume(const sc_ctx *ctx, const content *from, gzFile file)
{
    enum { BLOCK = 1 << 14 };
    const size_t voxels = from->voxels;
    const unsigned each = from->labels ? types[from->type].bytes : sizeof(int16_t);
    int64_t block[BLOCK]; /* room for the widest type */
    bool failed = false;

    for (size_t begin = 0; begin < voxels && !failed; begin += BLOCK) {
        const size_t count = voxels - begin < BLOCK ? voxels - begin : BLOCK;
        const unsigned bytes = (unsigned)count * each;

        if (from->labels)
            values_of(from->labels, begin, count, from->type, block);
        else
            grey_values_of(from->grey, begin, count, (int16_t *)(void *)block);
        failed = gzwrite(file, block, bytes) != (int)bytes;
        sc_stage_add(ctx, count);
    }
    return failed;
}

/* Append the phases of a series behind the first to @p file. *failed receives whether writing
 * failed, with errno set. @return the errors of making them; SC_ERR_INTERNAL for labels that do not
 * fit into the type of the first. */
static sc_status write_later(const sc_ctx *ctx, const content *from, gzFile file, bool *failed)
{
    for (int phase = 1; from->series && phase < from->series->count && !*failed; phase++) {
        SC_OWN(sc_volume_clear) sc_volume volume = {0};
        content next = *from;

        SC_PASS(from->series->make(from->series->user, phase, &volume));
        if (type_for(&volume) > from->type)
            return sc_fail(ctx, SC_ERR_INTERNAL, "phase %d has larger labels", phase);
        next.labels = &volume;
        *failed = write_volume(ctx, &next, file);
    }
    return SC_OK;
}

/* Append the voxels, gzip-compressed, to the file open as @p fd, which stands behind the header,
 * and close it. @return SC_ERR_WRITE; the errors of the series. */
static sc_status write_voxels(const sc_ctx *ctx, const content *from, const char *path, int fd)
{
    gzFile file = gzdopen(fd, "wb4");
    bool failed = !file;
    sc_status status = SC_OK;

    sc_stage_begin(ctx, "writing", 0,
                   from->voxels * (size_t)(from->series ? from->series->count : 1));
    if (!file && fd >= 0)
        close(fd);
    if (file)
        failed = write_volume(ctx, from, file);
    if (!failed)
        status = write_later(ctx, from, file, &failed);
    if (file && gzclose_w(file) != Z_OK)
        failed = true;
    if (status != SC_OK)
        return status;
    return failed ? sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s", path, sc_reason(errno))
                  : SC_OK;
}

/* Write a file of a header and voxels, which gets its name when it is complete. */
static sc_status save(const sc_ctx *ctx, const sc_text *header, const content *from,
                      const char *path, bool replace)
{
    SC_OWN(sc_outfile_discard) sc_outfile file = {0};

    SC_PASS(sc_outfile_open(ctx, path, replace, &file));
    fwrite(header->data, 1, header->length_bytes, file.stream);
    if (fflush(file.stream))
        return sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s", path, sc_reason(errno));
    SC_PASS(write_voxels(ctx, from, path, dup(fileno(file.stream))));
    return sc_outfile_commit(ctx, &file);
}

sc_status sc_volume_save_nrrd(const sc_ctx *ctx, const sc_volume *volume, const char *path,
                              bool replace)
{
    const content from = {
        .labels = volume, .voxels = sc_volume_voxels(volume), .type = type_for(volume)};
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(header_text(ctx, volume, NULL, &text));
    return save(ctx, &text, &from, path, replace);
}

sc_status sc_volume_save_series_nrrd(const sc_ctx *ctx, const sc_volume_series *series,
                                     const char *path, bool replace)
{
    SC_OWN(sc_volume_clear) sc_volume first = {0};
    content from = {.labels = &first, .series = series};
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(series->make(series->user, 0, &first));
    from.voxels = sc_volume_voxels(&first);
    from.type = type_for(&first);
    SC_PASS(header_text(ctx, &first, series, &text));
    return save(ctx, &text, &from, path, replace);
}

sc_status sc_grey_save_nrrd(const sc_ctx *ctx, const sc_grey *grey, const char *path, bool replace)
{
    const content from = {.grey = grey, .voxels = sc_grey_bytes(grey) / sizeof *grey->codes};
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(grid_text(ctx, "int16", grey->size, &grey->to_ras_mm, NULL, &text));
    SC_PASS(sc_text_add(ctx, &text, "\n"));
    return save(ctx, &text, &from, path, replace);
}
