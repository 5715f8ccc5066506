/* SPDX-License-Identifier: BSD-3-Clause */
/* Grey volumes: the stream of voxels as numbers, brought to codes of 16 bits. */
#include "segcast/grey.h"
#include "source.h"

enum {
    CODES = 65536,
    ROUNDS_MAX = 16, /* in which the range is narrowed to what most voxels hold */
    COARSE = 1024    /* codes that most voxels share: if fewer, the range is narrowed */
};
/* Share of the voxels that may lie below and above what a range is narrowed to. */
#define EXTREME_SHARE 0.001
/* Share of the values of tissues that are black, and that are white, in an automatic window. */
#define WINDOW_SHARE 0.01
/* Larger values become this one, so that differences are finite. */
#define VALUE_MOST 1e300
/* About so many voxels of tissues are looked at for an automatic window. */
#define WINDOW_VOXELS ((size_t)1 << 20)

size_t sc_grey_bytes(const sc_grey *grey)
{
    return (size_t)grey->size[0] * (size_t)grey->size[1] * (size_t)grey->size[2] * sizeof(uint16_t);
}

/* Open a file as a grey volume. @param grey gets size and geometry. Caller owns *source:
 * sc_source_clear. */
static sc_status open_grey(const sc_ctx *ctx, const char *path, bool header_only, sc_source *source,
                           sc_grey *grey)
{
    const sc_read_choice whole = {.is_image = true};

    SC_PASS(sc_open_source(ctx, path, &whole, header_only, source));
    if (source->mask_files.count)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: is a directory of masks, expected a grey volume, such as a CT or MR "
                       "image: a NRRD, NIfTI, MGH, MetaImage or TIFF file",
                       path);
    if (source->load)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: is a DICOM segmentation, expected a grey volume, such as a CT or MR "
                       "image: a NRRD, NIfTI, MGH, MetaImage or TIFF file",
                       path);
    if (source->layers > 1)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: has %d values for each voxel, expected one: a grey volume, such as a CT "
            "or MR image",
            path, source->layers);
    memcpy(grey->size, source->size, sizeof grey->size);
    grey->to_ras_mm = source->to_ras_mm;
    return sc_voxels_memory_check(ctx, path, grey->size, (double)sc_grey_bytes(grey));
}

sc_status sc_grey_read_header(const sc_ctx *ctx, const char *path, sc_grey *out)
{
    SC_OWN(sc_source_clear) sc_source source = {0};
    sc_grey grey = {0};

    SC_PASS(open_grey(ctx, path, true, &source, &grey));
    *out = grey;
    return SC_OK;
}

/* ---- values to codes ---- */

/* What is done with the values of a file, block by block. */
typedef struct pass {
    sc_grey *grey;
    bool measures;          /* find the range of finite values; else set codes and counts */
    double least, most;     /* the range found */
    bool whole;             /* all values are whole numbers */
    uint64_t counts[CODES]; /* how many voxels have each code */
    uint64_t not_numbers;   /* how many voxels hold none */
    uint64_t infinite;      /* how many voxels hold an infinite value */
} pass;

/* Note the range of count values. */
static void measure(pass *p, const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const double value = values[i];

        if (!isfinite(value))
            continue;
        p->least = value < p->least ? value : p->least;
        p->most = value > p->most ? value : p->most;
        p->whole = p->whole && value == floor(value);
    }
}

/* Write the codes of count values, the first of which is voxel number @p at. */
static void encode(pass *p, const double *values, size_t count, size_t at)
{
    sc_grey *grey = p->grey;
    /* What is no number becomes the lowest value, which may have the highest code. */
    const double lowest = grey->per_code < 0 ? CODES - 1 : 0;

    for (size_t i = 0; i < count; i++) {
        double code = (values[i] - grey->low) / grey->per_code;

        if (isnan(code)) {
            p->not_numbers++;
            code = lowest;
        }
        if (isinf(values[i]))
            p->infinite++;
        code = code < 0 ? 0 : code > CODES - 1 ? CODES - 1 : code;
        grey->codes[at + i] = (uint16_t)(code + 0.5);
        p->counts[grey->codes[at + i]]++;
    }
}

/* Read all voxels of a source once. */
static sc_status read_all(const sc_ctx *ctx, const char *path, const sc_source *source, pass *p)
{
    const size_t voxels = sc_source_voxels(source);
    SC_OWN(sc_stream_close_at) sc_voxel_stream *stream = NULL;
    SC_OWN(sc_free_at) double *values = NULL;

    SC_PASS(SC_ALLOC(ctx, SC_STREAM_BLOCK, &values));
    SC_PASS(sc_stream_open(ctx, path, source, &stream));
    for (size_t at = 0; at < voxels; at += SC_STREAM_BLOCK) {
        const size_t count = voxels - at < SC_STREAM_BLOCK ? voxels - at : SC_STREAM_BLOCK;

        SC_PASS(sc_stream_next_numbers(stream, count, values));
        if (p->measures)
            measure(p, values, count);
        else
            encode(p, values, count, at);
    }
    return sc_stream_finish(stream);
}

/* @return the code below which a share of the voxels lies. */
static int code_below(const uint64_t *counts, double share)
{
    uint64_t all = 0, below = 0;
    int code = 0;

    for (int i = 0; i < CODES; i++)
        all += counts[i];
    while (code < CODES - 1 && (double)(below + counts[code]) <= share * (double)all)
        below += counts[code++];
    return code;
}

/* Set the range of codes, if the type of the voxels is so narrow that each of its values has a
 * code.
 * @return whether it is. */
static bool set_exact_range(const sc_source *source, sc_grey *grey)
{
    static const double least[] = {-128, 0, -32768, 0}; /* by sc_voxel_type */

    if (source->type > SC_VOXEL_UINT16)
        return false;
    grey->low = source->slope * least[source->type] + source->intercept;
    grey->per_code = source->slope;
    return true;
}

/* Spread the codes over the values from @p least to @p most, of which all are @p whole numbers or
 * not. */
static void set_range(double least, double most, bool whole, sc_grey *grey)
{
    const double span = most - least;

    grey->low = least;
    grey->per_code = whole && span < CODES ? 1 : span > 0 ? span / (CODES - 1) : 1;
}

/* Narrow the range of codes to what most voxels hold, with as much again on both sides, if they
 * share few codes. @return whether it was narrowed. */
static bool narrow(const pass *p, sc_grey *grey)
{
    const int low = code_below(p->counts, EXTREME_SHARE),
              high = code_below(p->counts, 1 - EXTREME_SHARE);
    const double spread = high - low + 1, low_value = grey->low + (low - spread) * grey->per_code;
    const double high_value = grey->low + (high + spread) * grey->per_code;

    if (grey->per_code == 1 || high - low >= COARSE)
        return false;
    set_range(low_value, high_value, false, grey);
    return true;
}

/* Find the range of the values of a wide type, and spread the codes over what of it lies near the
 * window, if that is known. @return SC_ERR_DATA if no voxel holds a finite number. */
static sc_status find_range(const sc_ctx *ctx, const char *path, const sc_source *source,
                            const sc_grey_window *window, pass *p)
{
    p->measures = true;
    p->least = HUGE_VAL;
    p->most = -HUGE_VAL;
    p->whole = true;
    SC_PASS(read_all(ctx, path, source, p));
    if (p->least > p->most)
        return sc_fail(ctx, SC_ERR_DATA, "%s: no voxel holds a finite number", path);
    p->measures = false;
    p->least = fmax(p->least, -VALUE_MOST);
    p->most = fmin(p->most, VALUE_MOST);
    if (window && !(p->whole && p->most - p->least < CODES)) {
        const double least = fmax(p->least, window->level - 1.5 * window->width);
        const double most = fmin(p->most, window->level + 1.5 * window->width);

        if (least < most) {
            p->least = least;
            p->most = most;
        }
    }
    set_range(p->least, p->most, p->whole, p->grey);
    return SC_OK;
}

/* Tell, in one message, how many voxels hold no number and how many an infinite value. */
static void warn_not_finite(const sc_ctx *ctx, const char *path, const pass *p)
{
    const unsigned long long none = p->not_numbers, infinite = p->infinite;

    if (none && infinite)
        sc_warn(ctx,
                "%s: voxels that are no number (NaN): %llu, shown as the lowest value; infinite "
                "ones: %llu, shown as the lowest or the highest",
                path, none, infinite);
    else if (none)
        sc_warn(ctx, "%s: voxels that are no number (NaN): %llu, shown as the lowest value", path,
                none);
    else if (infinite)
        sc_warn(ctx, "%s: infinite voxels: %llu, shown as the lowest or the highest value", path,
                infinite);
}

/* Read the voxels of a source into the codes. */
static sc_status fill_codes(const sc_ctx *ctx, const char *path, const sc_source *source,
                            const sc_grey_window *window, pass *p)
{
    const bool exact = set_exact_range(source, p->grey);

    if (!exact)
        SC_PASS(find_range(ctx, path, source, window, p));
    for (int round = 0; round < ROUNDS_MAX; round++) {
        memset(p->counts, 0, sizeof p->counts);
        p->not_numbers = 0;
        p->infinite = 0;
        SC_PASS(read_all(ctx, path, source, p));
        if (exact || window || round == ROUNDS_MAX - 1 || !narrow(p, p->grey))
            break;
    }
    if (!isfinite(p->grey->low) || !isfinite(p->grey->low + CODES * p->grey->per_code))
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: the scaling in its header (slope %g, intercept %g) leads to values that "
            "are not finite",
            path, source->slope, source->intercept);
    warn_not_finite(ctx, path, p);
    return SC_OK;
}

sc_status sc_grey_read(const sc_ctx *ctx, const char *path, const sc_grey_window *window,
                       sc_grey *grey)
{
    sc_ctx errors = *ctx;
    SC_OWN(sc_source_clear) sc_source source = {0};
    sc_grey found = {.codes = grey->codes};
    SC_OWN(sc_free_at) pass *p = NULL;

    sc_stage_begin(ctx, "reading the image", 0, 0);
    errors.level = SC_LOG_ERROR; /* sc_grey_read_header has told the warnings */
    SC_PASS(open_grey(&errors, path, false, &source, &found));
    if (memcmp(found.size, grey->size, sizeof found.size) != 0)
        return sc_fail(ctx, SC_ERR_DATA, "%s: has changed while it was read", path);
    SC_PASS(SC_ZALLOC(ctx, 1, &p));
    p->grey = &found;
    SC_PASS(fill_codes(ctx, path, &source, window, p));
    *grey = found;
    return SC_OK;
}

/* ---- windows ---- */

/* Count the codes nearest to the centres of voxels of tissues, of every @p stride th voxel, in
 * counts[CODES]. @return how many were counted. */
static uint64_t count_codes(const sc_grey *grey, const sc_volume *labels, const sc_affine *to_grey,
                            size_t stride, uint64_t *counts)
{
    const size_t voxels = sc_volume_voxels(labels);
    const size_t nx = (size_t)labels->size[0], ny = (size_t)labels->size[1];
    uint64_t counted = 0;

    for (size_t i = 0; i < voxels; i += stride) {
        const size_t row = i / nx;
        const size_t layer = row / ny;
        const sc_vec3 at = {(double)(i % nx), (double)(row % ny), (double)layer};
        const sc_vec3 p = sc_affine_point(to_grey, at);
        const double x = floor(p.x + 0.5), y = floor(p.y + 0.5), z = floor(p.z + 0.5);

        if (!sc_volume_id(labels, i) || !(x >= 0 && x < grey->size[0]) ||
            !(y >= 0 && y < grey->size[1]) || !(z >= 0 && z < grey->size[2]))
            continue;
        counts[grey->codes[((size_t)z * (size_t)grey->size[1] + (size_t)y) * (size_t)grey->size[0] +
                           (size_t)x]]++;
        counted++;
    }
    return counted;
}

sc_status sc_grey_auto_window(const sc_ctx *ctx, const sc_grey *grey, const sc_volume *labels,
                              sc_grey_window *out, bool *found)
{
    /* An odd stride visits all columns of rows of an even number of voxels, as most have. */
    const size_t stride = (sc_volume_voxels(labels) / WINDOW_VOXELS) | 1;
    double ends[2] = {grey->low, grey->low + grey->per_code * (CODES - 1)};
    sc_affine from_ras, to_grey;
    SC_OWN(sc_free_at) uint64_t *counts = NULL;

    if (!sc_affine_invert(&grey->to_ras_mm, &from_ras))
        return sc_fail(ctx, SC_ERR_DATA, "the geometry of the image is singular");
    SC_PASS(SC_ZALLOC(ctx, CODES, &counts));
    to_grey = sc_affine_compose(&from_ras, &labels->to_ras_mm);
    *found = count_codes(grey, labels, &to_grey, stride, counts) ||
             (stride > 1 && count_codes(grey, labels, &to_grey, 1, counts));
    if (*found) {
        ends[0] = grey->low + grey->per_code * code_below(counts, WINDOW_SHARE);
        ends[1] = grey->low + grey->per_code * code_below(counts, 1 - WINDOW_SHARE);
    }
    out->level = (ends[0] + ends[1]) / 2;
    out->width = fmax(fabs(ends[1] - ends[0]), fabs(grey->per_code) * CODES / 1000);
    return SC_OK;
}
