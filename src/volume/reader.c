/* SPDX-License-Identifier: BSD-3-Clause */
/* Which reader a file needs, found by its first bytes; what to do with files of other kinds; and
 * what is common to all formats once the header has been read. */
#include "source.h"

#include <dirent.h>
#include <errno.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <zlib.h>

enum { HEAD_BYTES = 1024 };

/* The first bytes of a file, unpacked if it is a gzip file. */
typedef struct head {
    unsigned char bytes[HEAD_BYTES];
    size_t count;    /* of the bytes, after unpacking; fewer than HEAD_BYTES of a short file */
    bool compressed; /* the file on disk is a gzip file */
} head;

/* ---- directories ---- */

/* Is there an entry @p name of any kind in the directory? False also if it cannot be looked up. */
static bool holds_file(const char *directory, const char *name)
{
    char path[4096];
    struct stat info;

    return snprintf(path, sizeof path, "%s/%s", directory, name) < (int)sizeof path &&
           stat(path, &info) == 0;
}

/* Does the directory hold a DICOMDIR or a file whose name ends in .dcm or .ima? Subdirectories
 * are not searched. */
static bool holds_dicom(const char *directory)
{
    DIR *stream = opendir(directory);
    const struct dirent *entry;
    bool found = false;

    while (stream && !found && (entry = readdir(stream))) {
        const char *dot = strrchr(entry->d_name, '.');

        found = dot && (!strcasecmp(dot, ".dcm") || !strcasecmp(dot, ".ima"));
    }
    if (stream)
        closedir(stream);
    return found || holds_file(directory, "DICOMDIR");
}

/* Log that @p path is a directory, with advice by what it holds. @return SC_ERR_MISSING always. */
static sc_status refuse_directory(const sc_ctx *ctx, const char *path)
{
    const char *advice = "; give the path of a NRRD, NIfTI, MGH or MetaImage file in it";

    if (holds_file(path, ".zarray") || holds_file(path, ".zgroup") || holds_file(path, "zarr.json"))
        advice = " (Zarr); convert the label array to NIfTI or NRRD, for example in Python with "
                 "zarr and SimpleITK: SimpleITK.WriteImage(SimpleITK.GetImageFromArray("
                 "zarr.open(\"...\")[:]), \"labels.nrrd\"), and set the spacing";
    else if (holds_dicom(path))
        advice = " of DICOM files; a segmentation object (DICOM SEG) is converted by "
                 "`segimage2itkimage` of dcmqi, RTSTRUCT contours and labels stored as a series by "
                 "3D Slicer (save as .nrrd)";
    return sc_fail(ctx, SC_ERR_MISSING, "%s: is a directory%s", path, advice);
}

/* ---- formats ---- */

/* Read the first bytes of a file into *out. A gzip file that cannot be unpacked gives a count
 * of 0 and SC_OK. @return SC_ERR_MISSING if there is no such file or it is a directory,
 * SC_ERR_DATA if it is empty, SC_ERR_MEMORY, SC_ERR_WRITE if it cannot be read. */
static sc_status read_head(const sc_ctx *ctx, const char *path, head *out)
{
    struct stat info;
    gzFile file;
    int count;
    sc_status status;

    if (stat(path, &info))
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
    if (S_ISDIR(info.st_mode))
        return refuse_directory(ctx, path);
    if (!S_ISREG(info.st_mode))
        return sc_fail(ctx, SC_ERR_MISSING,
                       "%s: is a pipe or a device, expected a file, which is read several times; "
                       "write it to a file first",
                       path);
    if (info.st_size == 0)
        return sc_fail(ctx, SC_ERR_DATA, "%s: is empty, expected a volume", path);
    file = gzopen(path, "rb");
    if (!file)
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
    *out = (head){0};
    count = gzread(file, out->bytes, HEAD_BYTES);
    out->compressed = !gzdirect(file);
    out->count = count > 0 ? (size_t)count : 0;
    status = sc_gzip_status(file);
    gzclose_r(file);
    if (status == SC_ERR_MEMORY || status == SC_ERR_WRITE)
        return sc_fail(ctx, status, "%s: cannot be read: %s", path,
                       status == SC_ERR_MEMORY ? "out of memory" : "I/O error");
    return SC_OK;
}

static bool starts_with(const head *h, const char *magic, size_t length)
{
    return h->count >= length && !memcmp(h->bytes, magic, length);
}

/* The probes of the formats: @return whether the file that begins with @p h is to be read as
 * this format. They look for its mark only; the format's own reader checks the header. */
static bool is_nrrd(const head *h)
{
    return !h->compressed && starts_with(h, "NRRD", 4);
}

/* Compressed or not. The first field is the header's own size, in either byte order. */
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

/* MGH of FreeSurfer, compressed or not, has a version number only. */
static bool is_mgh(const head *h)
{
    return starts_with(h, "\0\0\0\1", 4);
}

/* MetaImage has no mark: one of its keys stands first, or somewhere in the first bytes. */
static bool is_meta(const head *h)
{
    char text[HEAD_BYTES + 1];

    memcpy(text, h->bytes, h->count);
    text[h->count] = '\0';
    return !h->compressed && (strstr(text, "ElementType") || strstr(text, "ElementDataFile") ||
                              starts_with(h, "ObjectType", 10) || starts_with(h, "NDims", 5));
}

/* The formats that can be read; the first whose probe accepts a file reads it. */
static const struct {
    bool (*probe)(const head *h);
    sc_status (*open)(const sc_ctx *ctx, const char *path, bool header_only, sc_source *out);
} readers[] = {{is_nrrd, sc_open_nrrd},
               {is_nifti, sc_open_nifti},
               {is_mgh, sc_open_mgh},
               {is_meta, sc_open_meta}};

/* Files that are often given by mistake: the bytes at @p offset by which each is known, and for
 * the message what it is and what to do instead. */
static const struct {
    const char *magic;
    size_t length, offset;
    const char *advice;
} known_files[] = {
    {"version https://git-lfs", 23, 0,
     "is a Git LFS pointer, not the volume itself; run \"git lfs pull\""},
    {"\x00\x05\x16\x07", 4, 0,
     "is a macOS companion file (AppleDouble), not the volume itself; use the file without \"._\" "
     "before its name"},
    {"DICM", 4, 128,
     "is DICOM; a segmentation object (DICOM SEG) is converted by `segimage2itkimage --inputDICOM "
     "FILE --outputType nrrd` of dcmqi, all else by 3D Slicer (save the segmentation as .nrrd)"},
    {"II*\x00", 4, 0,
     "is TIFF, which does not say its voxel size; open it in Fiji and save as NRRD (File > Save As "
     "> Nrrd)"},
    {"MM\x00*", 4, 0,
     "is TIFF, which does not say its voxel size; open it in Fiji and save as NRRD (File > Save As "
     "> Nrrd)"},
    {"II+\x00", 4, 0, "is BigTIFF; open it in Fiji and save as NRRD (File > Save As > Nrrd)"},
    {"\x89HDF", 4, 0,
     "is HDF5; write its label array as NRRD, for example in Python with h5py and pynrrd: "
     "nrrd.write(\"labels.nrrd\", h5py.File(\"FILE\")[\"NAME\"][:].T)"},
    {"PK\x03\x04", 4, 0, "is a ZIP archive; unpack it and use the volume in it"},
    {"BZh", 3, 0, "is packed by bzip2; unpack it with \"bunzip2\""},
    {"\xfd"
     "7zXZ",
     5, 0, "is packed by xz; unpack it with \"unxz\""},
    {"\x28\xb5\x2f\xfd", 4, 0, "is packed by Zstandard; unpack it with \"unzstd\""},
    {"\x93NUMPY", 6, 0,
     "is a NumPy array, which does not say its voxel size; write it as NRRD in Python with pynrrd: "
     "nrrd.write(\"labels.nrrd\", numpy.load(\"FILE\").T)"},
    {"# vtk DataFile", 14, 0,
     "is a legacy VTK file; open it in 3D Slicer or ParaView and save as .nrrd or .mha"},
    {"<?xml", 5, 0,
     "is XML; a VTK image (.vti) is converted by opening it in 3D Slicer and saving as .nrrd"},
    {"# AmiraMesh", 11, 0, "is AmiraMesh; export the label field from Amira as NRRD or NIfTI"},
    {"\x89PNG", 4, 0,
     "is a PNG picture, not a volume; a stack of pictures becomes a volume in Fiji (File > Import "
     "> "
     "Image Sequence, then File > Save As > Nrrd)"},
};

/* Log that no reader accepts the file, with advice if its kind is known. @return SC_ERR_DATA
 * always. */
static sc_status refuse_file(const sc_ctx *ctx, const char *path, const head *h)
{
    for (size_t i = 0; i < SC_COUNT_OF(known_files); i++) {
        const size_t end = known_files[i].offset + known_files[i].length;

        if (h->count >= end &&
            !memcmp(h->bytes + known_files[i].offset, known_files[i].magic, known_files[i].length))
            return sc_fail(ctx, SC_ERR_DATA, "%s: %s", path, known_files[i].advice);
    }
    if (h->count == 0)
        return sc_fail(ctx, SC_ERR_DATA, "%s: a broken gzip file", path);
    return sc_fail(
        ctx, SC_ERR_DATA,
        "%s: begins with bytes %02x %02x %02x %02x, expected NRRD (\"NRRD\"), NIfTI "
        "(348 or 540), MGH or MetaImage; 3D Slicer and ITK-SNAP can save segmentations of "
        "many other formats as .nrrd or .nii.gz",
        path, h->bytes[0], h->bytes[1], h->bytes[2], h->bytes[3]);
}

/* ---- geometry ---- */

/* Warn if two voxel axes differ from a right angle by more than 0.001 in the cosine. Such axes
 * are used as they are stored; most often they are an accident. */
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

/* From electron microscopy (1 nm) to whole bodies; beyond, most likely the unit is wrong. */
#define USUAL_SPACING_LEAST_MM 1e-6
#define USUAL_SPACING_MOST_MM 100.0
#define USUAL_SPACING_RATIO 100.0

/* Warn of one spacing outside of the limits above, or else of spacings that differ too much. */
static void warn_of_spacing(const sc_ctx *ctx, const char *path, const sc_affine *to_mm)
{
    double least = HUGE_VAL, most = 0;

    for (int i = 0; i < 3; i++) {
        const double spacing_mm = sc_vec3_length(sc_affine_column(to_mm, i));

        least = fmin(least, spacing_mm);
        most = fmax(most, spacing_mm);
    }
    if (least < USUAL_SPACING_LEAST_MM || most > USUAL_SPACING_MOST_MM)
        sc_warn(ctx,
                "%s: its voxels measure %.4g to %.4g mm, expected %g to %g mm; is the unit of its "
                "spacing right?",
                path, least, most, USUAL_SPACING_LEAST_MM, USUAL_SPACING_MOST_MM);
    else if (most > USUAL_SPACING_RATIO * least)
        sc_warn(ctx,
                "%s: its voxels measure %.4g mm along one axis and %.4g mm along another; is the "
                "spacing right?",
                path, least, most);
}

/* ---- reading ---- */

/* Read the header of a file of any format into *out, check it, and log all warnings about its
 * geometry. @param header_only as of sc_open_nrrd. @return the errors of sc_volume_read. Caller
 * owns: sc_source_clear. */
static sc_status open_source(const sc_ctx *ctx, const char *path, bool header_only, sc_source *out)
{
    sc_source source = {.slope = 1};
    size_t which = 0;
    head h;
    sc_status status;

    SC_TRY(read_head(ctx, path, &h));
    while (which < SC_COUNT_OF(readers) && !readers[which].probe(&h))
        which++;
    if (which == SC_COUNT_OF(readers)) {
        status = refuse_file(ctx, path, &h);
        goto out;
    }
    SC_TRY(readers[which].open(ctx, path, header_only, &source));
    SC_TRY(sc_geometry_check(ctx, path, source.size, &source.to_ras_mm));
    warn_of_shear(ctx, path, &source.to_ras_mm);
    warn_of_spacing(ctx, path, &source.to_ras_mm);
    if (!source.oriented)
        sc_warn(ctx,
                "%s: does not say where left and front are; its axes are taken as right, "
                "anterior, superior",
                path);
    *out = source;
    source = (sc_source){0};
out:
    sc_source_clear(&source);
    return status;
}

/* Read a whole file: the volume, without ids unless @p keep_ids, and *tallies, [label_count].
 * The caller owns both (sc_volume_clear, sc_free); both are untouched after an error. */
static sc_status read_voxels(const sc_ctx *ctx, const char *path, bool keep_ids, sc_volume *out,
                             sc_label_tally **tallies)
{
    sc_source source = {0};
    sc_volume volume = {0};
    sc_status status;

    sc_stage_begin(ctx, "reading", 0, 0); /* some formats are unpacked as a whole before */
    SC_TRY(open_source(ctx, path, false, &source));
    if (keep_ids)
        SC_TRY(sc_volume_memory_check(ctx, path, source.size, 0));
    SC_TRY(sc_read_labels(ctx, path, &source, keep_ids, &volume, tallies));
    volume.to_ras_mm = source.to_ras_mm;
    volume.oriented = source.oriented;
    sc_volume_apply_table(&volume, &source.table);
    *out = volume;
out:
    sc_source_clear(&source);
    return status;
}

sc_status sc_volume_reads(const sc_ctx *ctx, const char *volume, const char *path, bool *out)
{
    const sc_ctx quiet = sc_quiet(ctx);
    sc_source source = {0};
    sc_status status = SC_OK;
    bool reads = sc_same_file(volume, path);

    if (!reads)
        status = open_source(&quiet, volume, true, &source);
    if (!reads && status == SC_OK)
        reads = source.file && sc_same_file(source.file, path);
    sc_source_clear(&source);
    if (status != SC_OK && !sc_is_of_input(status))
        return status;
    *out = reads;
    return SC_OK;
}

sc_status sc_volume_read(const sc_ctx *ctx, const char *path, sc_volume *out)
{
    sc_label_tally *tallies = NULL;
    const sc_status status = read_voxels(ctx, path, true, out, &tallies);

    sc_free(tallies);
    return status;
}

sc_status sc_volume_scan_labels(const sc_ctx *ctx, const char *path, sc_label_scan *out)
{
    sc_label_scan scan = {0};
    const sc_status status = read_voxels(ctx, path, false, &scan.volume, &scan.tallies);

    if (status == SC_OK)
        *out = scan;
    return status;
}

sc_status sc_volume_read_header(const sc_ctx *ctx, const char *path, sc_label_scan *out)
{
    sc_source source = {0};
    sc_label_scan scan = {0};
    void *labels;
    sc_status status;

    SC_TRY(open_source(ctx, path, true, &source));
    SC_TRY(sc_zalloc(ctx, 1, sizeof(sc_label), &labels));
    scan.volume = (sc_volume){.label_count = 1,
                              .labels = labels,
                              .to_ras_mm = source.to_ras_mm,
                              .oriented = source.oriented};
    scan.volume.labels[0].opacity = -1;
    memcpy(scan.volume.size, source.size, sizeof source.size);
    SC_TRY(sc_volume_add_labels(ctx, &scan.volume, &source.table));
    *out = scan;
    scan = (sc_label_scan){0};
out:
    sc_label_scan_clear(&scan);
    sc_source_clear(&source);
    return status;
}
