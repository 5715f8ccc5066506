/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads Radiance files (Ward 1991): a header of text, and rows of pixels of four bytes, three
 * numbers and their common exponent: none is negative. Nothing in them is trusted; files with the
 * runs of before 1991 have too few rows. */
#include "segcast/panorama.h"

#include <errno.h>
#include <math.h>

enum { LINE_MOST = 1024, LINES_MOST = 200, WIDTH_MOST = 32766 };

/* A file that is being read. */
typedef struct hdr_file {
    const sc_ctx *ctx;
    const char *path;
    FILE *stream;
    int size[2];        /* width and height */
    uint8_t (*row)[4];  /* [width] */
    int step;           /* pixels along each edge of the squares that become one */
    sc_panorama result; /* borrowed */
} hdr_file;

static sc_status fail(const hdr_file *f, const char *what)
{
    return sc_fail(f->ctx, SC_ERR_DATA, "%s: %s", f->path, what);
}

/* Read a line of the header, without its end. @return false at the end of the file, or if it is too
 * long. */
static bool read_line(const hdr_file *f, char line[LINE_MOST])
{
    size_t length;

    if (!fgets(line, LINE_MOST, f->stream))
        return false;
    length = strlen(line);
    if (!length || line[length - 1] != '\n')
        return false;
    line[length - 1] = '\0';
    return true;
}

/* Read the header up to the first row. */
static sc_status read_header(hdr_file *f)
{
    char line[LINE_MOST], more;
    bool is_rgbe = false;
    int lines = 0;

    if (!read_line(f, line) || strncmp(line, "#?", 2) != 0)
        return fail(f, "is no Radiance file (.hdr)");
    while (read_line(f, line) && line[0]) {
        is_rgbe = is_rgbe || !strcmp(line, "FORMAT=32-bit_rle_rgbe");
        if (++lines > LINES_MOST)
            return fail(f, "has a header without an end");
    }
    if (!is_rgbe)
        return fail(f, "has no pixels of the format 32-bit_rle_rgbe, the only one that is read");
    if (!read_line(f, line) ||
        sscanf(line, "-Y %9d +X %9d%c", &f->size[1], &f->size[0], &more) != 2)
        return fail(f, "does not give its size as \"-Y HEIGHT +X WIDTH\"");
    if (f->size[0] < 2 || f->size[0] > WIDTH_MOST || f->size[0] != 2 * (int64_t)f->size[1])
        return sc_fail(f->ctx, SC_ERR_DATA,
                       "%s: has %d x %d pixels; a picture of all directions is twice as wide as "
                       "high, and at most %d wide",
                       f->path, f->size[0], f->size[1], WIDTH_MOST);
    return SC_OK;
}

/* Read one component of all pixels of a row, run by run. @return whether it was there. */
static bool read_runs(const hdr_file *f, int component)
{
    for (int x = 0; x < f->size[0];) {
        const int count = getc(f->stream), run = count > 128 ? count - 128 : count;
        int value = 0;

        if (count <= 0 || run > f->size[0] - x)
            return false;
        for (int i = 0; i < run; i++, x++) {
            if (i == 0 || count <= 128)
                value = getc(f->stream);
            if (value == EOF)
                return false;
            f->row[x][component] = (uint8_t)value;
        }
    }
    return true;
}

/* Read the next row. @return whether it was there. */
static bool read_row(const hdr_file *f)
{
    const uint8_t *first = f->row[0];
    const size_t rest = (size_t)f->size[0] - 1;

    if (fread(f->row[0], 4, 1, f->stream) != 1)
        return false;
    if (f->size[0] < 8 || first[0] != 2 || first[1] != 2 || first[2] >= 128) /* no runs */
        return fread(f->row[1], 4, rest, f->stream) == rest;
    if ((first[2] << 8 | first[3]) != f->size[0])
        return false;
    for (int component = 0; component < 4; component++) {
        if (!read_runs(f, component))
            return false;
    }
    return true;
}

/* Add a row of pixels to the sums of the row of squares @p to. @param share of each pixel in them.
 */
static void add_row(const hdr_file *f, float (*to)[3], float share)
{
    for (int x = 0; x < f->size[0]; x++) {
        const uint8_t *pixel = f->row[x];
        const float unit = pixel[3] ? ldexpf(share, pixel[3] - (128 + 8)) : 0;

        for (int i = 0; i < 3; i++)
            to[x / f->step][i] += unit * (float)pixel[i];
    }
}

/* Read all rows into f->result. */
static sc_status read_rows(hdr_file *f)
{
    sc_panorama *out = &f->result;
    double sum = 0;

    for (int y = 0; y < f->size[1]; y++) {
        const int across = y / f->step, high = f->size[1] - across * f->step;

        if (!read_row(f))
            return sc_fail(f->ctx, SC_ERR_DATA,
                           "%s: is damaged, or ends, in row %d of %d: get it anew", f->path, y + 1,
                           f->size[1]);
        add_row(f, out->rgb + (size_t)across * (size_t)out->width_px,
                1 / (float)(f->step * (high < f->step ? high : f->step)));
    }
    /* The last column of squares may be narrower, too. */
    for (size_t i = 0; i < (size_t)out->width_px * (size_t)out->height_px; i++) {
        const int left = f->size[0] - (int)(i % (size_t)out->width_px) * f->step;

        for (int k = 0; k < 3; k++) {
            out->rgb[i][k] *= left < f->step ? (float)f->step / (float)left : 1;
            sum += out->rgb[i][k];
        }
    }
    if (!(sum > 0) || !(sum < 1e30))
        return fail(f, sum > 0 ? "is too bright to be light" : "is black: no light comes from it");
    return SC_OK;
}

sc_status sc_panorama_load(const sc_ctx *ctx, const char *path, sc_panorama *out)
{
    SC_OWN(sc_fclose_at) FILE *stream = fopen(path, "rb");
    SC_OWN(sc_free_at) uint8_t(*row)[4] = NULL;
    SC_OWN(sc_panorama_clear) sc_panorama result = {0};
    hdr_file f = {.ctx = ctx, .path = path, .stream = stream};

    if (!stream)
        return sc_fail(ctx, sc_input_status(errno), "%s: cannot be opened: %s", path,
                       strerror(errno));
    SC_PASS(read_header(&f));
    f.step = (f.size[0] + SC_PANORAMA_WIDTH_MOST - 1) / SC_PANORAMA_WIDTH_MOST;
    result.width_px = (f.size[0] + f.step - 1) / f.step;
    result.height_px = (f.size[1] + f.step - 1) / f.step;
    SC_PASS(SC_ALLOC(ctx, (size_t)f.size[0], &row));
    SC_PASS(SC_ZALLOC(ctx, (size_t)result.width_px * (size_t)result.height_px, &result.rgb));
    f.row = row;
    f.result = result;
    SC_PASS(read_rows(&f));
    SC_HAND_OVER(result, out);
    return SC_OK;
}

void sc_panorama_clear(sc_panorama *panorama)
{
    sc_free(panorama->rgb);
    *panorama = (sc_panorama){0};
}
