/* SPDX-License-Identifier: BSD-3-Clause */
/* Which reader a file needs, told by its first bytes; and the common end of every reading. */
#include "raw.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <zlib.h>

enum { HEAD_BYTES = 1024 };

typedef struct head {
    unsigned char bytes[HEAD_BYTES];
    size_t count;
    bool compressed;
} head;

static sc_status read_head(const sc_ctx *ctx, const char *path, head *out)
{
    struct stat info;
    gzFile file;
    int count;

    if (stat(path, &info))
        return sc_fail(ctx, SC_ERR_MISSING, "%s: %s", path, strerror(errno));
    if (S_ISDIR(info.st_mode))
        return sc_fail(ctx, SC_ERR_MISSING, "%s: is a directory, expected a volume file", path);
    if (info.st_size == 0)
        return sc_fail(ctx, SC_ERR_DATA, "%s: is empty, expected a volume", path);
    file = gzopen(path, "rb");
    if (!file)
        return sc_fail(ctx, SC_ERR_MISSING, "%s: %s", path, strerror(errno));
    *out = (head){0};
    count = gzread(file, out->bytes, HEAD_BYTES);
    out->compressed = !gzdirect(file);
    out->count = count > 0 ? (size_t)count : 0;
    gzclose_r(file);
    return SC_OK;
}

static bool starts_with(const head *h, const char *magic, size_t length)
{
    return h->count >= length && !memcmp(h->bytes, magic, length);
}

static bool is_nrrd(const head *h)
{
    return !h->compressed && starts_with(h, "NRRD", 4);
}

/* The first field is the header's own size, in either byte order. */
static bool is_nifti(const head *h)
{
    static const unsigned char sizes[4][4] = {
        {92, 1, 0, 0}, {0, 0, 1, 92}, {28, 2, 0, 0}, {0, 0, 2, 28}};

    for (size_t i = 0; i < SC_COUNT_OF(sizes); i++) {
        if (h->count >= 4 && !memcmp(h->bytes, sizes[i], 4))
            return true;
    }
    return false;
}

static bool is_meta(const head *h)
{
    char text[HEAD_BYTES + 1];

    memcpy(text, h->bytes, h->count);
    text[h->count] = '\0';
    return !h->compressed && (strstr(text, "ElementType") || strstr(text, "ElementDataFile") ||
                              starts_with(h, "ObjectType", 10) || starts_with(h, "NDims", 5));
}

static const struct {
    bool (*probe)(const head *h);
    sc_status (*read)(const sc_ctx *ctx, const char *path, sc_raw *out);
} readers[] = {{is_nrrd, sc_read_nrrd}, {is_nifti, sc_read_nifti}, {is_meta, sc_read_meta}};

/* Files that are often handed to a reader by mistake, and what to do about them. */
static const struct {
    const char *magic;
    size_t length, offset;
    const char *advice;
} strangers[] = {
    {"version https://git-lfs", 23, 0,
     "is a Git LFS pointer, not the volume itself; run \"git lfs pull\""},
    {"\x00\x05\x16\x07", 4, 0, "is a macOS companion file (AppleDouble), not the volume itself"},
    {"DICM", 4, 128, "is DICOM; convert it to NRRD or NIfTI"},
    {"\x00\x00\x00\x01\x00\x00", 6, 0, "looks like FreeSurfer MGH/MGZ; convert it to NIfTI"},
    {"\x89PNG", 4, 0, "is a PNG picture, not a volume"},
};

static sc_status refuse_stranger(const sc_ctx *ctx, const char *path, const head *h)
{
    for (size_t i = 0; i < SC_COUNT_OF(strangers); i++) {
        const size_t end = strangers[i].offset + strangers[i].length;

        if (h->count >= end &&
            !memcmp(h->bytes + strangers[i].offset, strangers[i].magic, strangers[i].length))
            return sc_fail(ctx, SC_ERR_DATA, "%s: %s", path, strangers[i].advice);
    }
    if (h->count == 0)
        return sc_fail(ctx, SC_ERR_DATA, "%s: a broken gzip file", path);
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s: begins with bytes %02x %02x %02x %02x, expected NRRD (\"NRRD\"), NIfTI "
                   "(348 or 540) or MetaImage",
                   path, h->bytes[0], h->bytes[1], h->bytes[2], h->bytes[3]);
}

sc_status sc_read_gz(const sc_ctx *ctx, const char *path, uint64_t offset, void *data, size_t bytes)
{
    enum { STEP = 1 << 20 };
    gzFile file = gzopen(path, "rb");
    sc_status status = SC_OK;
    size_t at = 0;
    char rest[512];
    const char *reason;
    int error;

    if (!file)
        return sc_fail(ctx, SC_ERR_MISSING, "%s: %s", path, strerror(errno));
    gzbuffer(file, STEP);
    if (gzseek(file, (z_off_t)offset, SEEK_SET) >= 0) {
        while (at < bytes) {
            const size_t want = bytes - at < STEP ? bytes - at : STEP;
            const int got = gzread(file, (char *)data + at, (unsigned)want);

            if (got <= 0)
                break;
            at += (size_t)got;
        }
    }
    /* A little beyond the data: a stream that ends here has its check sum verified. */
    if (at == bytes)
        gzread(file, rest, sizeof rest);
    reason = gzerror(file, &error);
    if (at < bytes)
        status = sc_fail(ctx, SC_ERR_DATA, "%s: ends after %zu bytes of voxels, expected %zu%s%s",
                         path, at, bytes, error < 0 ? "; " : "", error < 0 ? reason : "");
    else if (error < 0 && error != Z_BUF_ERROR)
        status = sc_fail(ctx, SC_ERR_DATA, "%s: the compressed data are damaged: %s", path, reason);
    else if (gzeof(file) && !gzdirect(file)) {
        struct stat info;

        if (!stat(path, &info) && (int64_t)gzoffset(file) < (int64_t)info.st_size)
            sc_warn(ctx, "%s: bytes after the end of the compressed data are ignored", path);
    }
    gzclose_r(file);
    return status;
}

/* Axes that are not at right angles are shown as they are stored; most often they are an accident.
 */
static void warn_of_shear(const sc_ctx *ctx, const char *path, const sc_affine *to_mm)
{
    double worst = 0;

    for (int i = 0; i < 3; i++) {
        const sc_vec3 a = sc_vec3_unit(sc_affine_column(to_mm, i));
        const sc_vec3 b = sc_vec3_unit(sc_affine_column(to_mm, (i + 1) % 3));

        worst = fmax(worst, fabs(sc_vec3_dot(a, b)));
    }
    if (worst > 1e-3)
        sc_warn(ctx, "%s: its voxel axes are sheared, by up to %.2f degrees; shown as stored", path,
                asin(fmin(worst, 1)) * 180 / M_PI);
}

sc_status sc_volume_read(const sc_ctx *ctx, const char *path, sc_volume *out)
{
    head h;
    sc_raw raw = {.slope = 1};
    sc_volume volume = {0};
    size_t which = 0;
    sc_status status;

    SC_TRY(read_head(ctx, path, &h));
    while (which < SC_COUNT_OF(readers) && !readers[which].probe(&h))
        which++;
    if (which == SC_COUNT_OF(readers)) {
        status = refuse_stranger(ctx, path, &h);
        goto out;
    }
    SC_TRY(readers[which].read(ctx, path, &raw));
    SC_TRY(sc_geometry_check(ctx, path, &raw.to_ras_mm));
    warn_of_shear(ctx, path, &raw.to_ras_mm);
    SC_TRY(sc_densify(ctx, path, &raw, &volume));
    volume.to_ras_mm = raw.to_ras_mm;
    volume.oriented = raw.oriented;
    if (!raw.oriented)
        sc_warn(ctx,
                "%s: does not say where left and front are; its axes are taken as right, "
                "anterior, superior",
                path);
    sc_volume_apply_table(&volume, &raw.table);
    *out = volume;
out:
    sc_raw_clear(&raw);
    return status;
}
