/* SPDX-License-Identifier: BSD-3-Clause */
/* Which reader a file needs, found by its first bytes, and what to do with files of other kinds. */
#include "compressed_file.h"
#include "source.h"

#include <errno.h>
#include <strings.h>
#include <sys/stat.h>

enum { HEAD_BYTES = 1024 };

/* The first bytes of a file, unpacked if it is a gzip file. */
typedef struct head {
    unsigned char bytes[HEAD_BYTES];
    size_t count;    /* of the bytes, after unpacking; fewer than HEAD_BYTES of a short file */
    bool compressed; /* the file on disk is a gzip file */
} head;

/* Read the first bytes of a file into *out. A gzip file that cannot be unpacked gives a count
 * of 0 and SC_OK. @return SC_ERR_MISSING if there is no such file,
 * SC_ERR_DATA if it is empty, SC_ERR_MEMORY, SC_ERR_WRITE if it cannot be read. */
static sc_status read_head(const sc_ctx *ctx, const char *path, head *out)
{
    struct stat info;
    SC_OWN(sc_compressed_close) sc_compressed_file *file = NULL;

    if (stat(path, &info))
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
    if (!S_ISREG(info.st_mode))
        return sc_fail(ctx, SC_ERR_MISSING,
                       "%s: is a pipe or a device, expected a file, which is read several times; "
                       "write it to a file first",
                       path);
    if (info.st_size == 0)
        return sc_fail(ctx, SC_ERR_DATA, "%s: is empty, expected a volume", path);
    SC_PASS(sc_compressed_open(ctx, path, 0, SC_COMPRESSION_GZIP, &file));
    *out = (head){.compressed = sc_file_is_compressed(file)};
    out->count = sc_compressed_read(file, out->bytes, HEAD_BYTES);
    return sc_compressed_check(ctx, file);
}

/* Bytes by which a kind of files is known. */
typedef struct mark {
    const char *magic;
    size_t length, offset; /* how many, and where in the file */
} mark;

static bool has_mark(const head *h, const mark *m)
{
    return h->count >= m->offset + m->length && !memcmp(h->bytes + m->offset, m->magic, m->length);
}

/* MetaImage has no mark: one of its keys stands first, or somewhere in the first bytes. */
static bool is_meta(const head *h)
{
    char text[HEAD_BYTES + 1];

    memcpy(text, h->bytes, h->count);
    text[h->count] = '\0';
    return !h->compressed && (strstr(text, "ElementType") || strstr(text, "ElementDataFile") ||
                              !strncmp(text, "ObjectType", 10) || !strncmp(text, "NDims", 5));
}

/* A format that can be read. */
typedef struct reader {
    mark mark;
    bool may_be_packed; /* by gzip */
    /* NULL: NRRD, whose voxels a library may read with the header. */
    sc_status (*open)(const sc_ctx *ctx, const char *path, sc_source *out);
} reader;

/* The first whose mark a file has reads it; it checks the header. DICOM has its mark behind 128
 * bytes for other programs, which may be those of another format. NIfTI begins with the size of its
 * header, of either version and in either byte order; MGH has a version number only. TIFF is
 * written in either byte order, and BigTIFF has 43 in place of 42. */
static const reader readers[] = {
    {{"DICM", 4, 128}, false, sc_open_dicom},    {{"NRRD", 4, 0}, false, NULL},
    {{"\x5c\1\0\0", 4, 0}, true, sc_open_nifti}, {{"\0\0\1\x5c", 4, 0}, true, sc_open_nifti},
    {{"\x1c\2\0\0", 4, 0}, true, sc_open_nifti}, {{"\0\0\2\x1c", 4, 0}, true, sc_open_nifti},
    {{"\0\0\0\1", 4, 0}, true, sc_open_mgh},     {{"II*\0", 4, 0}, false, sc_open_tiff},
    {{"MM\0*", 4, 0}, false, sc_open_tiff},      {{"II+\0", 4, 0}, false, sc_open_tiff},
    {{"MM\0+", 4, 0}, false, sc_open_tiff},      {{"# AmiraMesh", 11, 0}, false, sc_open_amira},
    {{"# Avizo", 7, 0}, false, sc_open_amira}};

/* @return the reader of a file that begins with @p h; NULL: none. */
static const reader *reader_of(const head *h)
{
    static const reader meta = {.open = sc_open_meta};

    for (size_t i = 0; i < SC_COUNT_OF(readers); i++) {
        if (has_mark(h, &readers[i].mark) && (!h->compressed || readers[i].may_be_packed))
            return &readers[i];
    }
    return is_meta(h) ? &meta : NULL;
}

static const char mesh_advice[] =
    "is a mesh, a surface without voxels; give the segmentation from which it was made, or make "
    "one of it in 3D Slicer (Add Data as a segmentation, then save as .seg.nrrd)";

/* Files that are often given by mistake, and for the message what each is and what to do instead.
 */
static const struct {
    mark mark;
    const char *advice;
} known_files[] = {
    {{"version https://git-lfs", 23, 0},
     "is a Git LFS pointer, not the volume itself; run \"git lfs pull\""},
    {{"\x00\x05\x16\x07", 4, 0},
     "is a macOS companion file (AppleDouble), not the volume itself; use the file without \"._\" "
     "before its name"},
    {{"\x89HDF", 4, 0},
     "is HDF5, which is read as a volume of its own, but not as one mask of several; write it as "
     "NRRD, for example in Python with h5py and pynrrd: nrrd.write(\"labels.nrrd\", "
     "h5py.File(\"FILE\")[\"NAME\"][:].T)"},
    {{"PK\x03\x04", 4, 0}, "is a ZIP archive; unpack it and use the volume in it"},
    {{"7z\xbc\xaf", 4, 0}, "is a 7z archive; unpack it and use the volume in it"},
    {{"Rar!", 4, 0}, "is a RAR archive; unpack it and use the volume in it"},
    {{"ustar", 5, 257}, "is a tar archive; unpack it (tar xf) and use the volume in it"},
    {{"BZh", 3, 0}, "is packed by bzip2; unpack it with \"bunzip2\""},
    {{"\xfd"
      "7zXZ",
      5, 0},
     "is packed by xz; unpack it with \"unxz\""},
    {{"\x28\xb5\x2f\xfd", 4, 0}, "is packed by Zstandard; unpack it with \"unzstd\""},
    {{"\x93NUMPY", 6, 0},
     "is a NumPy array, which does not say its voxel size; write it as NRRD in Python with pynrrd: "
     "nrrd.write(\"labels.nrrd\", numpy.load(\"FILE\").T)"},
    {{"# vtk DataFile", 14, 0},
     "is a legacy VTK file; open it in 3D Slicer or ParaView and save as .nrrd or .mha"},
    {{"segc", 4, 0},
     "is a prepared file of segcast, expected a volume of another program; give the volume of "
     "which it was made"},
    {{"<MRML", 5, 0},
     "is a scene of 3D Slicer, which names files; give the segmentation among them, a .seg.nrrd"},
    {{"MATLAB 5.0", 10, 0},
     "is a MATLAB file of version 5, which is not read; write it in MATLAB as NIfTI, "
     "niftiwrite(labels, \"labels.nii\"), or as version 7.3, which is HDF5: save(\"labels.mat\", "
     "\"labels\", \"-v7.3\")"},
    {{"WKW", 3, 0},
     "is a cube of WEBKNOSSOS (WKW), which is not read; `webknossos export-as-tiff` of its Python "
     "package writes a layer as a directory of TIFF slices, which is"},
    {{"MAP ", 4, 208},
     "is MRC, which is not read; `mrc2tif -s FILE labels.tif` of IMOD writes a TIFF stack of it"},
    {{"ply\n", 4, 0}, mesh_advice},
    {{"ply\r", 4, 0}, mesh_advice},
    {{"solid ", 6, 0}, mesh_advice},
    {{"OFF\n", 4, 0}, mesh_advice},
    {{"ZISRAWFILE", 10, 0}, "is CZI of Zeiss; save it in Fiji as TIFF (File > Save As > Tiff)"},
    {{"\xff\xd8\xff", 3, 0},
     "is a JPEG picture, which cannot hold labels: it changes them; give a volume, or a directory "
     "of its slices as PNG or TIFF"},
    {{"%PDF", 4, 0}, "is a PDF document, not a volume"},
    {{"<!DOCTYPE html", 14, 0},
     "is a page of HTML, as servers send it instead of a file; download the volume anew"},
    {{"<?xml", 5, 0},
     "is XML; a VTK image (.vti) is converted by opening it in 3D Slicer and saving as .nrrd"},
    {{"# HyperSurface", 14, 0}, mesh_advice},
    {{"\x89PNG", 4, 0},
     "is one PNG picture; of the slices of a volume, give the directory that holds them all, named "
     "by their numbers"},
};

/* @return the length of @p path without its ending, if that is one of the voxels of a pair of
 * NIfTI; else 0. */
static size_t pair_stem_bytes(const char *path)
{
    static const char *const endings[] = {".img", ".img.gz"};

    return sc_stem_length(path, endings, SC_COUNT_OF(endings));
}

/* @return whether @p h is the header of a pair of NIfTI. */
static bool is_pair_header(const head *h)
{
    const reader *r = reader_of(h);

    return r && r->open == sc_open_nifti && h->count >= 348 &&
           (!memcmp(h->bytes + 344, "ni1", 3) || !memcmp(h->bytes + 4, "ni2", 3));
}

/* Find the header of a pair of NIfTI whose voxels are at @p path, by its name. @param out NULL if
 * there is none; else caller owns: sc_free. @return SC_ERR_MEMORY. */
static sc_status find_pair_header(const sc_ctx *ctx, const char *path, char **out)
{
    static const char *const endings[] = {".hdr", ".hdr.gz", ".HDR"};
    const sc_ctx quiet = sc_quiet(ctx);
    const size_t stem = pair_stem_bytes(path);
    sc_text text = {0};
    head h;

    *out = NULL;
    for (size_t i = 0; stem && !*out && i < SC_COUNT_OF(endings); i++) {
        SC_PASS(sc_text_add(ctx, &text, "%.*s%s", (int)stem, path, endings[i]));
        if (read_head(&quiet, text.data, &h) == SC_OK && is_pair_header(&h)) {
            *out = text.data;
            text = (sc_text){0};
        }
        sc_text_clear(&text);
    }
    return SC_OK;
}

/* Is the file a mesh, by the ending of its name? Binary ones have no mark. */
static bool is_mesh(const char *path)
{
    static const char *const endings[] = {".stl", ".obj", ".ply", ".vtp", ".glb", ".gltf"};

    return sc_stem_length(path, endings, SC_COUNT_OF(endings)) > 0;
}

/* @return what a file that no reader accepts is, and what to do, if its kind is known; else NULL.
 */
static const char *advice_for(const char *path, const head *h)
{
    if (is_mesh(path)) /* some are XML */
        return mesh_advice;
    for (size_t i = 0; i < SC_COUNT_OF(known_files); i++) {
        if (has_mark(h, &known_files[i].mark))
            return known_files[i].advice;
    }
    return NULL;
}

/* Log that no reader accepts the file, with advice if its kind is known. @return SC_ERR_DATA
 * always. */
static sc_status refuse_file(const sc_ctx *ctx, const char *path, const head *h)
{
    const size_t stem = pair_stem_bytes(path);
    const char *advice = advice_for(path, h);

    if (advice)
        return sc_fail(ctx, SC_ERR_DATA, "%s: %s", path, advice);
    if (h->count == 0)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: is gzip, but cannot be unpacked: it is damaged or cut short; get it "
                       "anew",
                       path);
    if (stem)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has no header of its own, as the voxels of a pair of NIfTI have none, "
                       "and %.*s.hdr is no header of a pair; copy it beside the voxels",
                       path, (int)stem, path);
    return sc_fail(
        ctx, SC_ERR_DATA,
        "%s: begins with bytes %02x %02x %02x %02x, expected NRRD (\"NRRD\"), NIfTI "
        "(348 or 540), MGH, TIFF, MetaImage, AmiraMesh or DICOM SEG; 3D Slicer and ITK-SNAP can "
        "save segmentations of many other formats as .nrrd or .nii.gz; voxels without "
        "a header are described by a line: --header \"uint8 256x256x128 1x1x1.5 mm\"",
        path, h->bytes[0], h->bytes[1], h->bytes[2], h->bytes[3]);
}

bool sc_is_volume_file(const char *path)
{
    const sc_ctx silent = {.rank = 0};
    head h;

    return read_head(&silent, path, &h) == SC_OK && reader_of(&h);
}

sc_file_kind sc_file_kind_of(const char *path)
{
    const sc_ctx silent = {.rank = 0};
    head h;

    if (read_head(&silent, path, &h) != SC_OK)
        return SC_FILE_TEXT;
    if (reader_of(&h) || has_mark(&h, &(mark){"\x89HDF", 4, 0}) ||
        has_mark(&h, &(mark){"segc", 4, 0}))
        return SC_FILE_VOLUME;
    return advice_for(path, &h) || h.compressed || memchr(h.bytes, 0, h.count) ? SC_FILE_OTHER
                                                                               : SC_FILE_TEXT;
}

size_t sc_volume_stem_bytes(const char *name, size_t bytes)
{
    static const char *const endings[] = {
        ".gz",  ".nii", ".seg",  ".nrrd", ".nhdr", ".mgz",  ".mgh", ".mha",  ".mhd", ".hdr",
        ".img", ".tif", ".tiff", ".ome",  ".am",   ".zarr", ".n5",  ".segc", ".dcm"};

    for (size_t i = 0; i < SC_COUNT_OF(endings); i++) {
        const size_t ending = strlen(endings[i]);

        if (bytes > ending && !strncasecmp(name + bytes - ending, endings[i], ending)) {
            bytes -= ending;
            i = (size_t)-1; /* it may have another one before that */
        }
    }
    return bytes;
}

/* Open the file at @p path, which is no voxels of a pair, by its own first bytes. */
static sc_status open_by_mark(const sc_ctx *ctx, const char *path, bool header_only, sc_source *out)
{
    const reader *r;
    head h;

    SC_PASS(read_head(ctx, path, &h));
    r = reader_of(&h);
    if (!r)
        return refuse_file(ctx, path, &h);
    return r->open ? r->open(ctx, path, out) : sc_open_nrrd(ctx, path, header_only, out);
}

sc_status sc_open_file(const sc_ctx *ctx, const char *path, bool header_only, sc_source *out)
{
    SC_OWN(sc_free_at) char *header = NULL;

    SC_PASS(find_pair_header(ctx, path, &header));
    return open_by_mark(ctx, header ? header : path, header_only, out);
}

void sc_volume_formats(char *text, size_t size)
{
    static const struct {
        const char *name;
        bool is_here;
    } formats[] = {{"NRRD, NIfTI, MGH, MetaImage, AmiraMesh", true},
                   {", TIFF", SC_HAVE_TIFF},
                   {", DICOM SEG", SC_HAVE_DICOM},
                   {", HDF5", SC_HAVE_HDF5},
                   {", Zarr and N5 (gzip, zlib", true},
                   {", blosc", SC_HAVE_BLOSC},
                   {", zstd", SC_HAVE_ZSTD},
                   {", lz4", SC_HAVE_LZ4},
                   {"), Neuroglancer", true}};
    size_t used = 0;

    text[0] = '\0';
    for (size_t i = 0; i < SC_COUNT_OF(formats) && used < size; i++) {
        if (formats[i].is_here)
            used += (size_t)snprintf(text + used, size - used, "%s", formats[i].name);
    }
}
