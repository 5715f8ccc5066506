/* SPDX-License-Identifier: BSD-3-Clause */
/* NRRD with Slicer's Segment keys. Written by hand: the header is text, and Teem cannot write to
 * a temporary name and report a full disk at the same time. */
#include "segcast/phantom.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

static sc_status header_text(const sc_ctx *ctx, const sc_volume *volume, sc_text *text)
{
    const sc_affine *m = &volume->to_ras_mm;
    sc_status status;

    SC_TRY(sc_text_add(ctx, text,
                       "NRRD0005\ntype: %s\ndimension: 3\nspace: right-anterior-superior\n"
                       "sizes: %d %d %d\n",
                       volume->label_bytes == 1 ? "uint8" : "uint16", volume->size[0],
                       volume->size[1], volume->size[2]));
    SC_TRY(sc_text_add(ctx, text, "space directions:"));
    for (int i = 0; i < 3; i++)
        SC_TRY(sc_text_add(ctx, text, " (%.17g,%.17g,%.17g)", m->m[0][i], m->m[1][i], m->m[2][i]));
    SC_TRY(sc_text_add(ctx, text,
                       "\nspace origin: (%.17g,%.17g,%.17g)\nkinds: domain domain domain\n"
                       "endian: little\nencoding: gzip\n",
                       m->m[0][3], m->m[1][3], m->m[2][3]));
    for (int i = 1; i < volume->label_count; i++) {
        const sc_label *label = &volume->labels[i];

        SC_TRY(sc_text_add(ctx, text,
                           "Segment%d_ID:=%s\nSegment%d_Name:=%s\nSegment%d_LabelValue:=%lld\n"
                           "Segment%d_Color:=%.6f %.6f %.6f\n",
                           i - 1, label->name, i - 1, label->name, i - 1, (long long)label->value,
                           i - 1, label->rgb[0] / 255.0, label->rgb[1] / 255.0,
                           label->rgb[2] / 255.0));
    }
    status = sc_text_add(ctx, text, "\n");
out:
    return status;
}

/* The voxels as label values, gzip-compressed, behind the header. */
static sc_status write_voxels(const sc_ctx *ctx, const sc_volume *volume, const char *path, int fd)
{
    enum { BLOCK = 1 << 16 };
    const size_t voxels = sc_volume_voxels(volume);
    gzFile file = gzdopen(fd, "wb4");
    uint16_t wide[BLOCK];
    uint8_t narrow[BLOCK];
    bool failed = !file;

    for (size_t begin = 0; begin < voxels && !failed; begin += BLOCK) {
        const size_t count = voxels - begin < BLOCK ? voxels - begin : BLOCK;
        const unsigned bytes = (unsigned)(count * (size_t)volume->label_bytes);

        for (size_t i = 0; i < count; i++) {
            const int id = volume->label_bytes == 1 ? ((const uint8_t *)volume->ids)[begin + i]
                                                    : ((const uint16_t *)volume->ids)[begin + i];

            narrow[i] = (uint8_t)volume->labels[id].value;
            wide[i] = (uint16_t)volume->labels[id].value;
        }
        failed = gzwrite(file, volume->label_bytes == 1 ? (void *)narrow : (void *)wide, bytes) !=
                 (int)bytes;
    }
    if (file && gzclose_w(file) != Z_OK)
        failed = true;
    return failed ? sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s", path, strerror(errno))
                  : SC_OK;
}

sc_status sc_volume_save_nrrd(const sc_ctx *ctx, const sc_volume *volume, const char *path)
{
    sc_outfile file = {0};
    sc_text text = {0};
    sc_status status;

    SC_TRY(header_text(ctx, volume, &text));
    SC_TRY(sc_outfile_open(ctx, path, &file));
    fwrite(text.data, 1, text.length_bytes, file.stream);
    if (fflush(file.stream)) {
        status = sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s", path, strerror(errno));
        goto out;
    }
    SC_TRY(write_voxels(ctx, volume, path, dup(fileno(file.stream))));
    status = sc_outfile_commit(ctx, &file);
out:
    sc_outfile_discard(&file);
    sc_text_clear(&text);
    return status;
}
