/* SPDX-License-Identifier: BSD-3-Clause */
/* HDF5: a dataset of a file is the volume, FILE:/PATH. The file is read by a program of its own,
 * which a damaged file can crash: src/hdf5. Without libhdf5 these files are refused with its name.
 */
#include "formats/hdf5_process.h"
#include "source.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- paths ---- */

static bool is_file(const char *path)
{
    struct stat info;

    return stat(path, &info) == 0 && S_ISREG(info.st_mode);
}

/* Does a regular file hold the mark of HDF5: at its begin, or behind a block of the user's, of 512
 * bytes or twice as many, and so on? */
static bool is_hdf5(const char *path)
{
    enum { LAST_MARK = 1 << 20 };
    const int file = is_file(path) ? open(path, O_RDONLY | O_CLOEXEC) : -1;
    unsigned char mark[8];
    bool found = false;

    for (off_t at = 0; at <= LAST_MARK && !found; at = at ? 2 * at : 512) {
        if (file < 0 || pread(file, mark, sizeof mark, at) != (ssize_t)sizeof mark)
            break;
        found = !memcmp(mark, "\x89HDF\r\n\x1a\n", sizeof mark);
    }
    if (file >= 0)
        close(file);
    return found;
}

size_t sc_volume_file_length(const char *path)
{
    const size_t length = strlen(path);
    char file[4096];
    struct stat info;

    if (length >= sizeof file || lstat(path, &info) == 0)
        return length;
    for (size_t at = length; at-- > 1;) { /* the last colon first: a file's name may hold some */
        if (path[at] != ':')
            continue;
        snprintf(file, sizeof file, "%.*s", (int)at, path);
        if (is_file(file))
            return at;
    }
    return length;
}

char *sc_volume_real_path(const char *path)
{
    const size_t length = sc_volume_file_length(path);
    char *file = strndup(path, length), *real = file ? realpath(file, NULL) : NULL, *whole = real;
    const int error = errno;

    if (real && path[length]) {
        whole = malloc(strlen(real) + strlen(path + length) + 1);
        if (whole)
            strcat(strcpy(whole, real), path + length);
        free(real);
    }
    free(file);
    errno = error;
    return whole;
}

bool sc_is_hdf5(const char *path)
{
    const size_t length = sc_volume_file_length(path);
    char file[4096];

    return snprintf(file, sizeof file, "%.*s", (int)length, path) < (int)sizeof file &&
           is_hdf5(file);
}

#if SC_HAVE_HDF5

/* ---- voxels ---- */

/* A volume while it is read: sc_voxel_reader.data. */
typedef struct hdf5_reading {
    int file;                /* descriptor, owned */
    char *inside;            /* the path of the dataset, owned */
    int voxels[3][2];        /* first and number along x, y, z of the part that is wanted */
    sc_hdf5_answer answer;   /* what was said of it before */
    sc_hdf5_process process; /* of the voxels */
} hdf5_reading;

static void release(void *data)
{
    hdf5_reading *r = data;

    if (!r)
        return;
    sc_hdf5_end(&r->process);
    if (r->file >= 0)
        close(r->file);
    sc_free(r->inside);
    sc_free(r);
}

/* Start the program once more, for the voxels. */
static sc_status begin_voxels(const sc_ctx *ctx, const char *path, hdf5_reading *r)
{
    char text[SC_HDF5_TEXT_BYTES + 1];
    sc_hdf5_answer answer;

    sc_hdf5_end(&r->process);
    SC_PASS(sc_hdf5_begin(ctx, path, r->file, r->inside, (const int(*)[2])r->voxels, &r->process));
    SC_PASS(sc_hdf5_read_answer(ctx, &r->process, &answer, text));
    if (answer.type != r->answer.type || memcmp(answer.size, r->answer.size, sizeof answer.size))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has changed while it was read; run again when it "
                       "is written",
                       path);
    return SC_OK;
}

/* sc_slices_fn of this format. */
static sc_status read_slices(const sc_ctx *ctx, const char *path, const sc_source *source,
                             int first, int count, void *out)
{
    hdf5_reading *r = source->reader.data;
    const size_t slice =
        (size_t)source->size[0] * (size_t)source->size[1] * sc_voxel_type_bytes(source->type);

    if (first == 0)
        SC_PASS(begin_voxels(ctx, path, r));
    SC_PASS(sc_hdf5_read_voxels(ctx, &r->process, (size_t)count * slice, out));
    if (first + count == source->size[2])
        sc_hdf5_end(&r->process);
    return SC_OK;
}

/* ---- header ---- */

/* Fill @p source by what was answered. */
static sc_status use_answer(const sc_ctx *ctx, const char *path, const sc_hdf5_answer *answer,
                            sc_source *source)
{
    _Static_assert((int)SC_HDF5_TYPES == (int)SC_VOXEL_TYPES, "both lists have one order");
    int64_t size[3];

    source->type = (sc_voxel_type)answer->type;
    for (int i = 0; i < 3; i++)
        size[i] = (int64_t)answer->size[i];
    SC_PASS(sc_grid_voxels(ctx, path, size, sc_voxel_type_bytes(source->type), source->size, NULL));
    memcpy(source->to_ras_mm.m, answer->to_ras_mm, sizeof answer->to_ras_mm);
    source->oriented = answer->flags & SC_HDF5_ORIENTED;
    source->slope = answer->slope;
    source->intercept = answer->intercept;
    if (!(answer->flags & SC_HDF5_SPACED))
        sc_warn(ctx,
                "%s: nothing gives the spacing of its voxels (the attribute element_size_um does, "
                "in micrometres along z, y, x); taken as 1 mm",
                path);
    return SC_OK;
}

/* Let @p source, of the whole dataset, be of the part that is wanted. */
static sc_status cut(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                     hdf5_reading *r, sc_source *source)
{
    const double slab_bytes = 4 << 20;
    double slice_bytes;
    int low[3];

    SC_PASS(sc_source_take_part(ctx, path, choice, low, source));
    for (int i = 0; i < 3; i++) {
        r->voxels[i][0] = low[i];
        r->voxels[i][1] = source->part[i];
    }
    slice_bytes =
        (double)source->size[0] * source->size[1] * (double)sc_voxel_type_bytes(source->type);
    source->reader.slices = (int)fmin(floor(slab_bytes / slice_bytes) + 1, source->size[2]);
    return SC_OK;
}

/* Open the file of a path with a path inside, and keep both. */
static sc_status open_file(const sc_ctx *ctx, const char *path, hdf5_reading *r, char **file)
{
    const size_t length = sc_volume_file_length(path);
    struct stat info;
    sc_text text = {0};

    SC_PASS(sc_text_add(ctx, &text, "%.*s", (int)length, path));
    *file = text.data;
    SC_PASS(sc_text_copy(ctx, path[length] ? path + length + 1 : "", &r->inside));
    r->file = open(*file, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* a pipe would not open else */
    if (r->file < 0 || fstat(r->file, &info))
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", *file, sc_reason(errno));
    else if (!S_ISREG(info.st_mode))
        return sc_fail(ctx, SC_ERR_DATA, "%s: is no regular file", *file);
    return SC_OK;
}

sc_status sc_open_hdf5(const sc_ctx *ctx, const char *path, const sc_read_choice *read,
                       bool header_only, sc_source *out)
{
    SC_OWN(sc_source_clear)
    sc_source source = {.slope = 1,
                        .stored.encoding = SC_ENCODING_SLICES,
                        .reader = {.read_slices = read_slices, .release = release}};
    SC_OWN(sc_hdf5_end) sc_hdf5_process process = {.out = -1};
    char text[SC_HDF5_TEXT_BYTES + 1];
    hdf5_reading *r;

    SC_PASS(SC_ZALLOC(ctx, 1, &r));
    source.reader.data = r;
    r->file = r->process.out = -1;
    SC_PASS(open_file(ctx, path, r, &source.stored.file));
    SC_PASS(sc_hdf5_begin(ctx, path, r->file, r->inside, NULL, &process));
    SC_PASS(sc_hdf5_read_answer(ctx, &process, &r->answer, text));
    SC_PASS(use_answer(ctx, path, &r->answer, &source));
    if (r->answer.flags & SC_HDF5_ONLY) {
        sc_info(ctx, "%s: its dataset %s is read, the only one that may be a volume", path, text);
        sc_free(r->inside);
        r->inside = NULL;
        SC_PASS(sc_text_copy(ctx, text, &r->inside));
    }
    SC_PASS(cut(ctx, path, read, r, &source));
    if (!header_only) /* a dataset without any chunk may promise a tebibyte */
        SC_PASS(sc_volume_memory_check(ctx, path, source.size, 0));
    SC_HAND_OVER(source, out);
    return SC_OK;
}

#else

sc_status sc_open_hdf5(const sc_ctx *ctx, const char *path, const sc_read_choice *read,
                       bool header_only, sc_source *out)
{
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s: is HDF5, and segcast was built without libhdf5 1.10 or newer, which reads "
                   "it (Debian: libhdf5-dev); install it and build again, or write the labels as "
                   "NRRD, for example in Python with h5py and pynrrd: nrrd.write(\"labels.nrrd\", "
                   "h5py.File(\"FILE\")[\"NAME\"][:].T)",
                   path);
}

#endif
