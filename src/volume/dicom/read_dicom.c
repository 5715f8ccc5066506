/* SPDX-License-Identifier: BSD-3-Clause */
/* DICOM segmentations (PS3.3, A.51): Segmentation, in which each frame is one segment in one slice,
 * and Label Map Segmentation, in which a frame is a slice of labels. Read with DCMTK, which is
 * optional: without it these files are refused with its name. */
#include "source.h"

#if SC_HAVE_DICOM

#include "dicom/dicom.h"

#define FRAME_GROUPS SC_DICOM_TAG(0x5200, 0x9230)
#define NUMBER_OF_FRAMES SC_DICOM_TAG(0x0028, 0x0008)
#define ROWS SC_DICOM_TAG(0x0028, 0x0010)
#define COLUMNS SC_DICOM_TAG(0x0028, 0x0011)
#define SAMPLES SC_DICOM_TAG(0x0028, 0x0002)
#define BITS_ALLOCATED SC_DICOM_TAG(0x0028, 0x0100)
#define PIXEL_SIGN SC_DICOM_TAG(0x0028, 0x0103)
#define WHOLE_COLUMNS SC_DICOM_TAG(0x0048, 0x0006)
#define PADDING SC_DICOM_TAG(0x0028, 0x0120)
#define SEGMENTATION_TYPE SC_DICOM_TAG(0x0062, 0x0001)
#define FRACTION_MOST SC_DICOM_TAG(0x0062, 0x000e)
#define FRACTION_TYPE SC_DICOM_TAG(0x0062, 0x0010)

enum { FRAMES_MAX = 1 << 24, SEGMENTS_MAX = 65536, TYPE_BYTES = 32 };

/* How a frame holds what it shows. */
typedef enum pixel_form {
    FORM_BITS,     /* one bit: whether the pixel belongs to the segment; frames without a gap */
    FORM_SHARES,   /* a byte: how much of it does */
    FORM_LABELS_8, /* the number of a segment */
    FORM_LABELS_16
} pixel_form;

/* An open file: what read_slices and load work on. */
typedef struct volume_file {
    sc_dicom *dicom;
    sc_dicom_kind kind;
    pixel_form form;
    size_t pixels;          /* of a frame */
    double half;            /* FORM_SHARES: from this value on a pixel belongs to the segment */
    uint32_t background;    /* FORM_LABELS: this value is background, beside 0 */
    sc_dicom_frame *frames; /* [count], owned; by slice and segment */
    uint32_t count;
    unsigned char *packed; /* owned; the bytes of one frame as stored */
    char type[TYPE_BYTES]; /* FORM_SHARES: of what the shares are */
} volume_file;

static void release(void *data)
{
    volume_file *f = data;

    if (!f)
        return;
    sc_dicom_close(f->dicom);
    sc_free(f->frames);
    sc_free(f->packed);
    sc_free(f);
}

/* ---- header ---- */

/* Read a whole number of the data set. @return @p missing if it is not there. */
static double number_of(const volume_file *f, uint32_t tag, double missing)
{
    double number;

    return sc_dicom_numbers(sc_dicom_root(f->dicom), tag, &number, 1) >= 1 ? number : missing;
}

/* Set how pixels are stored, by the type of the segmentation. */
static sc_status read_form(const sc_ctx *ctx, const char *path, volume_file *f)
{
    const double bits = number_of(f, BITS_ALLOCATED, 0), most = number_of(f, FRACTION_MOST, 255);
    char type[TYPE_BYTES];

    sc_dicom_text(f->dicom, sc_dicom_root(f->dicom), SEGMENTATION_TYPE, type, sizeof type);
    if (number_of(f, SAMPLES, 1) != 1 || number_of(f, PIXEL_SIGN, 0) != 0)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: its pixels have several values or signs, expected one whole number from "
            "0 on; the file is damaged: write it anew",
            path);
    if (!strcmp(type, "BINARY") && !f->kind.is_labels && bits == 1) {
        f->form = FORM_BITS;
    } else if (!strcmp(type, "FRACTIONAL") && !f->kind.is_labels && bits == 8 && most >= 1) {
        f->form = FORM_SHARES;
        f->half = most / 2;
        sc_dicom_text(f->dicom, sc_dicom_root(f->dicom), FRACTION_TYPE, f->type, sizeof f->type);
    } else if (!strcmp(type, "LABELMAP") && f->kind.is_labels && (bits == 8 || bits == 16)) {
        f->form = bits == 8 ? FORM_LABELS_8 : FORM_LABELS_16;
        f->background = (uint32_t)number_of(f, PADDING, 0);
    } else {
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: is of the type \"%s\" (SegmentationType) with %g bits for each pixel, "
            "expected BINARY with 1, FRACTIONAL with 8, or in label maps LABELMAP with 8 "
            "or 16",
            path, type, bits);
    }
    if (f->form == FORM_BITS && f->kind.is_compressed)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has pixels of 1 bit packed by RLE, which DICOM does not allow; convert "
                       "it with `gdcmconv --raw IN OUT`",
                       path);
    return SC_OK;
}

/* @return how many bytes a frame takes as it is stored; of FORM_BITS, which may begin within a
 * byte, the most there can be. */
static size_t frame_bytes(const volume_file *f)
{
    if (f->form == FORM_BITS)
        return (f->pixels + 7) / 8 + 1;
    return f->form == FORM_LABELS_16 ? 2 * f->pixels : f->pixels;
}

/* Read the size of the frames into @p size_px, and how many there are, and check that the file has
 * the bytes for them. */
static sc_status read_size(const sc_ctx *ctx, const char *path, volume_file *f, int size_px[2])
{
    const double columns = number_of(f, COLUMNS, 0), rows = number_of(f, ROWS, 0);
    const double frames = number_of(f, NUMBER_OF_FRAMES, 1);
    const double pixel_bits = f->form == FORM_BITS ? 1 : f->form == FORM_LABELS_16 ? 16 : 8;
    const double needed = ceil(columns * rows * frames * pixel_bits / 8);
    const uint64_t has = sc_dicom_pixel_bytes(f->dicom);
    const sc_dicom_item *frame = NULL;
    double described = 0;

    if (number_of(f, WHOLE_COLUMNS, 0) > 0)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: is a segmentation of a slide, in tiles (TILED_FULL or TILED_SPARSE), "
                       "which has one slice; expected the slices of a volume",
                       path);
    if (columns < 1 || rows < 1 || frames < 1 || frames > FRAMES_MAX)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has %g frames of %g x %g pixels, expected 1 to %d frames, and at least "
                       "one pixel; an empty segmentation cannot be shown",
                       path, frames, columns, rows, FRAMES_MAX);
    if (!f->kind.is_compressed && needed > (double)has)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: promises %.0f frames of %.0f x %.0f pixels, which take %.0f bytes, but has "
            "%llu; the file is cut short: get it anew",
            path, frames, columns, rows, needed, (unsigned long long)has);
    while ((frame = sc_dicom_next(sc_dicom_root(f->dicom), FRAME_GROUPS, frame)) != NULL)
        described++;
    if (described != frames)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: promises %.0f frames (NumberOfFrames), but describes %.0f "
            "(PerFrameFunctionalGroupsSequence), expected the same; the file is damaged: "
            "write it anew",
            path, frames, described);
    size_px[0] = (int)columns;
    size_px[1] = (int)rows;
    f->pixels = (size_t)size_px[0] * (size_t)size_px[1];
    f->count = (uint32_t)frames;
    return SC_OK;
}

/* Check that each frame shows a segment that is named. */
static sc_status check_segments(const sc_ctx *ctx, const char *path, const volume_file *f,
                                const sc_label_table *table)
{
    SC_OWN(sc_free_at) bool *named = NULL;

    SC_PASS(SC_ZALLOC(ctx, SEGMENTS_MAX, &named));
    for (size_t i = 0; i < table->count; i++)
        named[table->rows[i].value] = true;
    for (uint32_t i = 0; i < f->count; i++) {
        if (!named[f->frames[i].segment])
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s: frame %u shows segment %d, which is none of the %zu segments of "
                           "the file (SegmentSequence); the file is damaged: write it anew",
                           path, f->frames[i].number + 1, f->frames[i].segment, table->count);
    }
    return SC_OK;
}

/* ---- frames ---- */

/* Read a frame as it is stored into f->packed. @return the bit of f->packed that is its first
 * pixel, of FORM_BITS, in *shift. */
static sc_status read_frame(const sc_ctx *ctx, const char *path, volume_file *f, uint32_t number,
                            unsigned *shift)
{
    const uint64_t pixel = (uint64_t)number * f->pixels;
    uint64_t offset = pixel * (f->form == FORM_LABELS_16 ? 2 : 1);
    size_t bytes = frame_bytes(f);
    sc_dicom_result result;

    *shift = 0;
    if (!f->packed) /* not before the memory for such a slice was found to be there */
        SC_PASS(sc_alloc(ctx, bytes + 1, 1, &f->packed));
    if (f->form == FORM_BITS) { /* frames follow each other without a gap between their bits */
        offset = pixel / 8;
        *shift = (unsigned)(pixel % 8);
        bytes = (*shift + f->pixels + 7) / 8;
    }
    result = f->kind.is_compressed ? sc_dicom_read_frame(f->dicom, number, bytes, f->packed)
                                   : sc_dicom_read_bytes(f->dicom, offset, bytes, f->packed);
    if (result == SC_DICOM_MEMORY)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
    if (result != SC_DICOM_OK)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: the pixels of frame %u cannot be read; the file is damaged or cut short: "
            "get it anew",
            path, number + 1);
    return SC_OK;
}

/* @return whether pixel @p i of the frame in f->packed belongs to its segment. */
static inline bool is_inside(const volume_file *f, unsigned shift, size_t i)
{
    if (f->form == FORM_BITS)
        return f->packed[(i + shift) / 8] >> (i + shift) % 8 & 1;
    return f->packed[i] >= f->half;
}

/* ---- label maps ---- */

/* @return the first frame of slice @p slice or of a later one. */
static uint32_t first_of_slice(const volume_file *f, int slice)
{
    uint32_t low = 0, high = f->count;

    while (low < high) {
        const uint32_t middle = low + (high - low) / 2;

        if (f->frames[middle].slice < slice)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Unpack the frame of labels in f->packed, of 8 or 16 bits, to @p out; the label of the background
 * becomes 0. */
static void unpack_labels(const volume_file *f, uint16_t *out)
{
    for (size_t i = 0; i < f->pixels; i++) {
        const unsigned char *at = f->packed + 2 * i;
        uint32_t value = f->form == FORM_LABELS_8 ? f->packed[i] : at[0] | (uint32_t)at[1] << 8;

        if (f->form == FORM_LABELS_16 && f->kind.is_compressed) { /* in the order of this machine */
            uint16_t own;

            memcpy(&own, at, sizeof own);
            value = own;
        }
        out[i] = value == f->background ? 0 : (uint16_t)value;
    }
}

/* sc_slices_fn of label maps. */
static sc_status read_slices(const sc_ctx *ctx, const char *path, const sc_source *source,
                             int first, int count, void *out)
{
    volume_file *f = source->reader.data;
    uint16_t *labels = out;
    unsigned shift;

    memset(out, 0, (size_t)count * f->pixels * sizeof *labels);
    for (uint32_t i = first_of_slice(f, first); i < f->count && f->frames[i].slice < first + count;
         i++) {
        SC_PASS(read_frame(ctx, path, f, f->frames[i].number, &shift));
        unpack_labels(f, labels + (size_t)(f->frames[i].slice - first) * f->pixels);
    }
    return SC_OK;
}

/* ---- segments ---- */

/* The segments while they are read. The arrays belong to load. */
typedef struct painting {
    sc_claims *claims;
    volume_file *file;
    size_t *rows;   /* [SEGMENTS_MAX]: in the table, of each segment */
    uint8_t *twice; /* [pixels] of a slice: whether more than one segment covers it */
} painting;

/* Give the voxels of a frame, which is in the memory of the file, to the segment in row @p row. */
static void paint_frame(const painting *p, int slice, size_t row, unsigned shift)
{
    const volume_file *f = p->file;
    const sc_label *rows = p->claims->source->table.rows;
    uint16_t *labels = p->claims->labels + (size_t)slice * f->pixels;

    for (size_t k = 0; k < f->pixels; k++) {
        size_t winner = row;

        if (!is_inside(f, shift, k))
            continue;
        if (labels[k]) {
            winner = sc_claims_settle(p->claims, row, p->rows[labels[k]]);
            p->claims->source->overlaps.voxels += !p->twice[k];
            p->twice[k] = 1;
        }
        labels[k] = (uint16_t)rows[winner].value;
    }
}

/* Go once through the frames: count the voxels of segments, or, if @p paints, give them labels. */
static sc_status pass(const painting *p, bool paints)
{
    const sc_claims *c = p->claims;
    volume_file *f = p->file;

    for (uint32_t i = 0; i < f->count; i++) {
        const sc_dicom_frame *frame = &f->frames[i];
        const size_t row = p->rows[frame->segment];
        unsigned shift;

        if (i == 0 || frame->slice != frame[-1].slice)
            memset(p->twice, 0, f->pixels);
        if (paints && c->rule->left_out[row])
            continue;
        SC_PASS(read_frame(c->ctx, c->path, f, frame->number, &shift));
        if (paints)
            paint_frame(p, frame->slice, row, shift);
        for (size_t k = 0; k < f->pixels && !paints; k++)
            c->voxels[row] += is_inside(f, shift, k);
        sc_stage_add(c->ctx, f->pixels);
    }
    return SC_OK;
}

/* sc_load_fn of segments in frames of their own, which are read as a whole. */
static sc_status load(const sc_ctx *ctx, const char *path, const sc_overlap_rule *rule,
                      sc_source *source)
{
    volume_file *f = source->reader.data;
    const sc_label_table *table = &source->table;
    SC_OWN(sc_claims_clear) sc_claims claims = {0};
    SC_OWN(sc_free_at) size_t *rows = NULL;
    SC_OWN(sc_free_at) uint8_t *twice = NULL;
    painting p = {.claims = &claims, .file = f};
    int part[3], low[3];

    memcpy(part, source->part, sizeof part);
    memcpy(low, source->low, sizeof low);
    memcpy(source->part, source->size, sizeof source->part);
    memset(source->low, 0, sizeof source->low);
    SC_PASS(sc_claims_begin(ctx, path, rule, source, &claims));
    claims.by_number = true;
    SC_PASS(SC_ZALLOC(ctx, SEGMENTS_MAX, &rows));
    SC_PASS(SC_ALLOC(ctx, f->pixels, &twice));
    p.rows = rows;
    p.twice = twice;
    for (size_t i = 0; i < table->count; i++)
        rows[table->rows[i].value] = i;
    if (f->form == FORM_SHARES)
        sc_info(ctx,
                "%s: holds fractions%s%s; a voxel belongs to a segment from half of the largest on "
                "(MaximumFractionalValue), %g",
                path, *f->type ? " of the type " : "", f->type, f->half);
    sc_stage_begin(ctx, "reading", 0, 2 * (uint64_t)f->count * f->pixels);
    SC_PASS(pass(&p, false));
    SC_PASS(pass(&p, true));
    SC_PASS(sc_claims_end(&claims));
    memcpy(source->part, part, sizeof part);
    memcpy(source->low, low, sizeof low);
    return SC_OK;
}

/* ---- opening ---- */

/* Read the data set of a file, which sc_dicom_check has accepted, into @p f. */
static sc_status open_dicom(const sc_ctx *ctx, const char *path, volume_file *f)
{
    char why[SC_DICOM_WHY_BYTES];
    const sc_dicom_result result = sc_dicom_open(path, why, &f->dicom);

    if (result == SC_DICOM_MEMORY)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
    if (result != SC_DICOM_OK)
        return sc_fail(ctx, SC_ERR_DATA, "%s: cannot be read as DICOM: %s; get the file anew", path,
                       why);
    return SC_OK;
}

/* Fill @p source, whose data is @p f. */
static sc_status read_header(const sc_ctx *ctx, const char *path, volume_file *f, sc_source *source)
{
    int size_px[2];

    SC_PASS(sc_dicom_check(ctx, path, &f->kind));
    SC_PASS(open_dicom(ctx, path, f));
    SC_PASS(read_form(ctx, path, f));
    SC_PASS(read_size(ctx, path, f, size_px));
    SC_PASS(sc_dicom_read_segments(ctx, path, f->dicom, &source->table));
    SC_PASS(SC_ZALLOC(ctx, f->count, &f->frames));
    SC_PASS(sc_dicom_place_frames(ctx, path, f->dicom, !f->kind.is_labels, size_px, f->frames,
                                  f->count, source));
    if (!f->kind.is_labels)
        SC_PASS(check_segments(ctx, path, f, &source->table));
    return sc_path_join(ctx, "", path, &source->stored.file);
}

sc_status sc_open_dicom(const sc_ctx *ctx, const char *path, sc_source *out)
{
    SC_OWN(sc_source_clear)
    sc_source source = {.slope = 1,
                        .type = SC_VOXEL_UINT16,
                        .stored.encoding = SC_ENCODING_SLICES,
                        .reader = {.read_slices = read_slices, .slices = 1, .release = release}};

    SC_PASS(sc_zalloc(ctx, 1, sizeof(volume_file), &source.reader.data));
    SC_PASS(read_header(ctx, path, source.reader.data, &source));
    if (!((volume_file *)source.reader.data)->kind.is_labels)
        source.load = load;
    SC_HAND_OVER(source, out);
    return SC_OK;
}

#else

sc_status sc_open_dicom(const sc_ctx *ctx, const char *path, sc_source *out)
{
    return sc_fail(
        ctx, SC_ERR_DATA,
        "%s: is DICOM, and segcast was built without DCMTK, which reads segmentations in it "
        "(Debian: libdcmtk-dev); install it and build again, or convert the file with "
        "`segimage2itkimage --inputDICOM FILE --outputType nrrd` of dcmqi",
        path);
}

#endif
