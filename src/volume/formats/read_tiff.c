/* SPDX-License-Identifier: BSD-3-Clause */
/* TIFF and BigTIFF: the pages of a file are the slices of a volume, from the first on; x goes along
 * the rows, y from row to row. Read with libtiff, which is optional: without it these files are
 * refused with its name. */
#include "formats/tiff_notes.h"
#include "source.h"

#if SC_HAVE_TIFF

#include <tiffio.h>

enum {
    WHY_BYTES = 256,
    PAGES_MAX = 1 << 20 /* a chain of more pages is refused: each costs a seek before any voxel */
};

/* A file that is open; the voxels are read through it. */
typedef struct tiff_file {
    TIFF *tiff;
    uint64_t *pages; /* [count], owned: where in the file the page of each slice begins */
    size_t count, capacity;
    void *tile; /* [tile_bytes], owned; NULL while all pages have strips */
    size_t tile_bytes;
    char why[WHY_BYTES]; /* the last error of libtiff; empty: none */
} tiff_file;

/* How the pixels of a page are stored. All pages of a volume agree. */
typedef struct page_form {
    uint32_t width, height;
    uint16_t bits, samples, format, photometric;
} page_form;

/* For libtiff: keep its last error for our message. @p user is a tiff_file. */
static int on_error(TIFF *tiff, void *user, const char *module, const char *format, va_list values)
{
    tiff_file *file = user;

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral" /* the formats are those of libtiff */
    vsnprintf(file->why, sizeof file->why, format, values);
#pragma GCC diagnostic pop
    return 1;
}

/* For libtiff: its warnings, most of them about unknown tags, help nobody here. */
static int on_warning(TIFF *tiff, void *user, const char *module, const char *format,
                      va_list values)
{
    return 1;
}

static void release(void *data)
{
    tiff_file *file = data;

    if (!file)
        return;
    if (file->tiff)
        TIFFClose(file->tiff);
    sc_free(file->pages);
    sc_free(file->tile);
    sc_free(file);
}

/* Open the file. Caller owns *out: release. @return SC_ERR_DATA if its first page cannot be read;
 * SC_ERR_MEMORY. */
static sc_status open_tiff(const sc_ctx *ctx, const char *path, tiff_file **out)
{
    TIFFOpenOptions *options;
    tiff_file *file;
    sc_status status;

    SC_PASS(SC_ZALLOC(ctx, 1, &file));
    options = TIFFOpenOptionsAlloc();
    if (!options) {
        sc_free(file);
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
    }
    TIFFOpenOptionsSetErrorHandlerExtR(options, on_error, file);
    TIFFOpenOptionsSetWarningHandlerExtR(options, on_warning, NULL);
    if (ctx->memory_max_bytes && ctx->memory_max_bytes < INT64_MAX)
        TIFFOpenOptionsSetMaxSingleMemAlloc(options, (tmsize_t)ctx->memory_max_bytes);
    /* m: not mapped, so that a file that is cut short meanwhile is an error and no signal */
    file->tiff = TIFFOpenExt(path, "rm", options);
    TIFFOpenOptionsFree(options);
    if (!file->tiff) {
        status = sc_fail(
            ctx, SC_ERR_DATA, "%s: cannot be read as TIFF: %s; save it anew, for example with Fiji",
            path, file->why[0] ? file->why : "has no page, as if it was never finished");
        release(file);
        return status;
    }
    *out = file;
    return SC_OK;
}

/* ---- pages ---- */

static page_form form_of(TIFF *tiff)
{
    page_form form = {.bits = 1, .samples = 1, .format = SAMPLEFORMAT_UINT};

    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &form.width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &form.height);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &form.bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &form.samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &form.format);
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &form.photometric);
    form.format = form.format == SAMPLEFORMAT_VOID ? SAMPLEFORMAT_UINT : form.format;
    return form;
}

/* Write how a page stores its voxels to *type. @return SC_ERR_DATA for pages that hold no labels,
 * or not one for each pixel. */
static sc_status voxel_type(const sc_ctx *ctx, const char *path, const page_form *form,
                            sc_voxel_type *type)
{
    enum { INTEGERS = SAMPLEFORMAT_INT << 8, NATURAL = SAMPLEFORMAT_UINT << 8 };
    static const int types[SC_VOXEL_TYPES] = {INTEGERS | 8,
                                              NATURAL | 8,
                                              INTEGERS | 16,
                                              NATURAL | 16,
                                              INTEGERS | 32,
                                              NATURAL | 32,
                                              INTEGERS | 64,
                                              NATURAL | 64,
                                              SAMPLEFORMAT_IEEEFP << 8 | 32,
                                              SAMPLEFORMAT_IEEEFP << 8 | 64};

    if (form->samples != 1)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has %d values for each pixel, a colour picture; expected one, the "
                       "number of a label: save the labels, not their colours",
                       path, form->samples);
    if (form->bits <= 64 && sc_voxel_type_coded(form->format << 8 | form->bits, types, type))
        return SC_OK;
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s: has pixels of %d bits of sample format %d, expected 8, 16, 32 or 64 bits "
                   "of integers (1, 2) or 32 or 64 of floats (3); convert it in Fiji: Image > Type",
                   path, form->bits, form->format);
}

/* Check what has to hold for the page that libtiff is at. @param form that of the first page. */
static sc_status check_page(const sc_ctx *ctx, const char *path, tiff_file *file,
                            const page_form *form, size_t page)
{
    const page_form own = form_of(file->tiff);
    uint16_t compression = COMPRESSION_NONE, orientation = ORIENTATION_TOPLEFT;
    uint32_t depth = 1, tile_depth = 1;

    TIFFGetFieldDefaulted(file->tiff, TIFFTAG_COMPRESSION, &compression);
    TIFFGetFieldDefaulted(file->tiff, TIFFTAG_ORIENTATION, &orientation);
    TIFFGetFieldDefaulted(file->tiff, TIFFTAG_IMAGEDEPTH, &depth);
    TIFFGetFieldDefaulted(file->tiff, TIFFTAG_TILEDEPTH, &tile_depth);
    if (own.width != form->width || own.height != form->height || own.bits != form->bits ||
        own.samples != form->samples || own.format != form->format)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: page %zu has %u x %u pixels of %d bits, page 0 %u x %u of %d; expected "
                       "the slices of one volume, all of one size and type",
                       path, page, own.width, own.height, own.bits, form->width, form->height,
                       form->bits);
    if (compression == COMPRESSION_JPEG || compression == COMPRESSION_OJPEG)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: page %zu is compressed as JPEG, which changes labels; expected a "
                       "lossless compression, such as LZW or Deflate",
                       path, page);
    if (!TIFFIsCODECConfigured(compression))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: page %zu has the compression %d, which the libtiff of this machine "
                       "cannot unpack; save it with another, such as LZW or Deflate",
                       path, page, compression);
    if (orientation != ORIENTATION_TOPLEFT && page == 0)
        sc_warn(ctx,
                "%s: its rows are to be turned or mirrored for display (orientation %d); they are "
                "taken as stored",
                path, orientation);
    if (depth > 1 || tile_depth > 1)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: page %zu has a depth of %u, expected one slice for each page; save it "
                       "as a stack of pages",
                       path, page, depth > 1 ? depth : tile_depth);
    return SC_OK;
}

static sc_status add_page(const sc_ctx *ctx, const char *path, tiff_file *file)
{
    if (file->count == PAGES_MAX)
        return sc_fail(ctx, SC_ERR_DATA, "%s: has more than %d pages, expected at most so many",
                       path, PAGES_MAX);
    SC_PASS(SC_GROW(ctx, file->count, &file->capacity, &file->pages));
    file->pages[file->count++] = TIFFCurrentDirOffset(file->tiff);
    return SC_OK;
}

/* Find the pages, all but smaller copies of others, and check them. Ends at the last page. */
static sc_status find_pages(const sc_ctx *ctx, const char *path, tiff_file *file,
                            const page_form *form)
{
    size_t page = 0;

    do {
        uint32_t kind = 0;

        TIFFGetFieldDefaulted(file->tiff, TIFFTAG_SUBFILETYPE, &kind);
        if (kind & FILETYPE_REDUCEDIMAGE && page > 0)
            continue;
        SC_PASS(check_page(ctx, path, file, form, page));
        SC_PASS(add_page(ctx, path, file));
        page++;
        file->why[0] = '\0';
    } while (TIFFReadDirectory(file->tiff));
    if (file->why[0])
        return sc_fail(ctx, SC_ERR_DATA, "%s: the page behind page %zu cannot be read: %s", path,
                       page - 1, file->why);
    if (!TIFFLastDirectory(file->tiff)) /* libtiff ends at a loop with no more than a warning */
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: the page behind page %zu is one before it, so that the pages have no "
                       "end; the file is damaged: get it anew",
                       path, page - 1);
    return SC_OK;
}

/* ---- voxels ---- */

/* Log that pixels of a page cannot be read. @return SC_ERR_DATA always. */
static sc_status bad_pixels(const sc_ctx *ctx, const char *path, const tiff_file *file, int page,
                            const char *part, uint32_t number)
{
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s: page %d, %s %u: %s; the file is damaged or cut short: get it anew", path,
                   page, part, number,
                   file->why[0] ? file->why : "has fewer pixels than the page promises");
}

/* Read the page that libtiff is at, of strips, to out[height][width] of @p each bytes. */
static sc_status read_strips(const sc_ctx *ctx, const char *path, tiff_file *file,
                             const sc_source *source, int page, unsigned char *out)
{
    const size_t row = (size_t)source->size[0] * sc_voxel_type_bytes(source->type);
    const uint32_t height = (uint32_t)source->size[1];
    uint32_t rows = height;

    TIFFGetFieldDefaulted(file->tiff, TIFFTAG_ROWSPERSTRIP, &rows);
    rows = rows == 0 || rows > height ? height : rows;
    for (uint32_t strip = 0, y = 0; y < height; strip++, y += rows) {
        const tmsize_t bytes = (tmsize_t)((y + rows <= height ? rows : height - y) * row);

        if (TIFFReadEncodedStrip(file->tiff, strip, out + y * row, bytes) != bytes)
            return bad_pixels(ctx, path, file, page, "strip", strip);
    }
    return SC_OK;
}

/* As read_strips, of tiles. */
static sc_status read_tiles(const sc_ctx *ctx, const char *path, tiff_file *file,
                            const sc_source *source, int page, unsigned char *out)
{
    const size_t each = sc_voxel_type_bytes(source->type);
    const uint32_t width = (uint32_t)source->size[0], height = (uint32_t)source->size[1];
    const tmsize_t bytes = TIFFTileSize(file->tiff);
    uint32_t across = 0, down = 0, tile = 0;

    TIFFGetField(file->tiff, TIFFTAG_TILEWIDTH, &across);
    TIFFGetField(file->tiff, TIFFTAG_TILELENGTH, &down);
    if (across == 0 || down == 0 || bytes <= 0 ||
        (double)bytes < (double)across * down * (double)each)
        return bad_pixels(ctx, path, file, page, "tile", 0);
    if (ctx->memory_max_bytes && (uint64_t)bytes > ctx->memory_max_bytes)
        return sc_fail(ctx, SC_ERR_SYSTEM,
                       "%s: page %d has tiles of %s, more than the limit of memory; raise it "
                       "where there is more: --max-memory",
                       path, page, sc_size_text((double)bytes, (char[24]){0}));
    if ((size_t)bytes > file->tile_bytes) {
        sc_free(file->tile);
        file->tile = NULL;
        file->tile_bytes = 0;
        SC_PASS(sc_alloc(ctx, (size_t)bytes, 1, &file->tile));
        file->tile_bytes = (size_t)bytes;
    }
    for (uint32_t y = 0; y < height; y += down) {
        for (uint32_t x = 0; x < width; x += across, tile++) {
            const uint32_t columns = width - x < across ? width - x : across;

            if (TIFFReadEncodedTile(file->tiff, tile, file->tile, bytes) != bytes)
                return bad_pixels(ctx, path, file, page, "tile", tile);
            for (uint32_t i = 0; i < down && y + i < height; i++)
                memcpy(out + ((size_t)(y + i) * width + x) * each,
                       (const unsigned char *)file->tile + (size_t)i * across * each,
                       columns * each);
        }
    }
    return SC_OK;
}

/* sc_slices_fn of this format: one at a time. */
static sc_status read_slice(const sc_ctx *ctx, const char *path, const sc_source *source, int page,
                            int count, void *out)
{
    tiff_file *file = source->reader.data;

    file->why[0] = '\0';
    if (!TIFFSetSubDirectory(file->tiff, file->pages[page]))
        return sc_fail(ctx, SC_ERR_DATA, "%s: page %d cannot be read: %s", path, page, file->why);
    return (TIFFIsTiled(file->tiff) ? read_tiles : read_strips)(ctx, path, file, source, page, out);
}

/* ---- header ---- */

/* Give the source the colours of a palette, unless these are grey levels. */
static sc_status read_palette(const sc_ctx *ctx, tiff_file *file, const page_form *form,
                              sc_source *source)
{
    const size_t count = form->bits <= 16 ? (size_t)1 << form->bits : 0;
    uint16_t *levels[3];
    bool grey = true;

    if (form->photometric != PHOTOMETRIC_PALETTE || !count || form->format != SAMPLEFORMAT_UINT ||
        !TIFFGetField(file->tiff, TIFFTAG_COLORMAP, &levels[0], &levels[1], &levels[2]))
        return SC_OK;
    for (size_t i = 0; i < count && grey; i++)
        grey = levels[0][i] == levels[1][i] && levels[1][i] == levels[2][i];
    for (size_t i = 1; i < count && !grey; i++) {
        sc_label row = {.value = (int64_t)i, .opacity = -1, .has_color = true};

        for (int k = 0; k < 3; k++)
            row.rgb[k] = (uint8_t)(levels[k][i] >> 8);
        SC_PASS(sc_label_table_add(ctx, &source->table, &row));
    }
    return SC_OK;
}

/* A file of ImageJ of more than 4 GiB has one page, behind whose pixels lie those of all others:
 * read them so. @return whether it is such a file, and *source says where they are. */
static bool is_one_long_page(tiff_file *file, const sc_tiff_notes *notes, sc_source *source)
{
    uint16_t compression = COMPRESSION_NONE;

    TIFFGetFieldDefaulted(file->tiff, TIFFTAG_COMPRESSION, &compression);
    if (file->count != 1 || !notes->program || strcmp(notes->program, "ImageJ") != 0 ||
        notes->images < 2 || compression != COMPRESSION_NONE || TIFFIsTiled(file->tiff))
        return false;
    source->stored.encoding = SC_ENCODING_PLAIN;
    source->stored.offset_bytes = TIFFGetStrileOffset(file->tiff, 0);
    source->stored.swapped = sc_voxel_type_bytes(source->type) > 1 &&
                             (TIFFIsBigEndian(file->tiff) != 0) == SC_IS_LITTLE_ENDIAN;
    return true;
}

/* Check the pages against what the text of the file says of them. @param slices all there are. */
static sc_status check_notes(const sc_ctx *ctx, const char *path, const sc_tiff_notes *notes,
                             const page_form *form, int64_t slices)
{
    /* many programs write a stack without saying which axis it has: readers take it for channels */
    const bool stack = notes->slices <= 1 && slices > 1 &&
                       notes->channels * notes->frames == slices &&
                       (notes->channels == 1 || notes->frames == 1);

    if (!notes->program)
        return SC_OK;
    if (stack)
        sc_warn(ctx, "%s: has one slice of %lld %s (%s); they are taken as slices", path,
                (long long)slices, notes->frames == 1 ? "channels" : "times", notes->program);
    else if (notes->channels != 1 || notes->frames != 1)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has %lld channels and %lld times (%s), expected one of each; save one "
                       "of them, for example in Fiji: Image > Duplicate",
                       path, (long long)notes->channels, (long long)notes->frames, notes->program);
    if (!strcmp(notes->program, "OME-XML") && notes->images > 1)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: holds %lld images (OME-XML), expected one; save one of them", path,
                       (long long)notes->images);
    if (!stack && notes->slices > 0 && notes->slices != slices)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has %lld pages of pixels, but %lld slices by its %s; expected all of "
                       "them in this file, one for each page",
                       path, (long long)slices, (long long)notes->slices, notes->program);
    if (notes->width > 0 && (notes->width != form->width || notes->height != form->height))
        return sc_fail(
            ctx, SC_ERR_DATA, "%s: has pages of %u x %u pixels, but %lld x %lld by its OME-XML",
            path, form->width, form->height, (long long)notes->width, (long long)notes->height);
    if (notes->reordered)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: its pages do not stand in the order of the slices (OME-XML, TiffData); "
                       "expected slice by slice: save it anew, for example with Fiji",
                       path);
    return SC_OK;
}

/* Set the geometry of @p source. Spacings that are not given are 1 mm, or those of the pixels. */
static void geometry(const sc_ctx *ctx, const char *path, const sc_tiff_notes *notes,
                     sc_source *source)
{
    const double *given = notes->spacing_mm;

    source->oriented = false;
    for (int i = 0; i < 3; i++) {
        const double most = fmax(given[0], given[1]);

        source->to_ras_mm.m[i][i] = given[i] > 0 ? given[i] : most > 0 ? most : 1;
    }
    if (given[0] <= 0 || given[1] <= 0 || (given[2] <= 0 && source->size[2] > 1))
        sc_warn(ctx,
                "%s: does not give the spacing of its voxels along all axes (TIFF of ImageJ or OME "
                "may); taken as %g x %g x %g mm",
                path, source->to_ras_mm.m[0][0], source->to_ras_mm.m[1][1],
                source->to_ras_mm.m[2][2]);
    else if (notes->unit_missing)
        sc_warn(ctx, "%s: gives the spacing of its voxels without a known unit (%s); taken as mm",
                path, notes->program);
}

/* Fill @p source, whose data is an open file. */
static sc_status read_header(const sc_ctx *ctx, const char *path, sc_source *source)
{
    tiff_file *file = source->reader.data;
    const page_form form = form_of(file->tiff);
    sc_tiff_notes notes = {0};
    float resolution[2] = {0, 0};
    double pixels_per_unit[2];
    char *text = NULL;
    int64_t size[3];
    size_t voxels;

    SC_PASS(voxel_type(ctx, path, &form, &source->type));
    SC_PASS(read_palette(ctx, file, &form, source));
    TIFFGetField(file->tiff, TIFFTAG_XRESOLUTION, &resolution[0]);
    TIFFGetField(file->tiff, TIFFTAG_YRESOLUTION, &resolution[1]);
    for (int i = 0; i < 2; i++)
        pixels_per_unit[i] = isfinite(resolution[i]) ? (double)resolution[i] : 0;
    if (!TIFFGetField(file->tiff, TIFFTAG_IMAGEDESCRIPTION, &text))
        text = NULL;
    SC_PASS(sc_tiff_notes_read(ctx, path, text, pixels_per_unit, &notes));
    SC_PASS(find_pages(ctx, path, file, &form));
    size[0] = form.width;
    size[1] = form.height;
    size[2] = is_one_long_page(file, &notes, source) ? notes.images : (int64_t)file->count;
    SC_PASS(check_notes(ctx, path, &notes, &form, size[2]));
    SC_PASS(
        sc_grid_voxels(ctx, path, size, sc_voxel_type_bytes(source->type), source->size, &voxels));
    if (source->stored.encoding == SC_ENCODING_PLAIN)
        SC_PASS(
            sc_check_file_bytes(ctx, path,
                                (double)source->stored.offset_bytes +
                                    (double)voxels * (double)sc_voxel_type_bytes(source->type)));
    geometry(ctx, path, &notes, source);
    return sc_path_join(ctx, "", path, &source->stored.file);
}

sc_status sc_open_tiff(const sc_ctx *ctx, const char *path, sc_source *out)
{
    SC_OWN(sc_source_clear)
    sc_source source = {.slope = 1,
                        .stored.encoding = SC_ENCODING_SLICES,
                        .reader = {.read_slices = read_slice, .slices = 1, .release = release}};
    tiff_file *file = NULL;

    SC_PASS(open_tiff(ctx, path, &file));
    source.reader.data = file;
    SC_PASS(read_header(ctx, path, &source));
    SC_HAND_OVER(source, out);
    return SC_OK;
}

#else

sc_status sc_open_tiff(const sc_ctx *ctx, const char *path, sc_source *out)
{
    return sc_fail(
        ctx, SC_ERR_DATA,
        "%s: is TIFF, and segcast was built without libtiff 4.5 or newer, which reads it "
        "(Debian: libtiff-dev); install it and build again, or open the file in Fiji and "
        "save as NRRD (File > Save As > Nrrd)",
        path);
}

#endif
