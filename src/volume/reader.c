/* SPDX-License-Identifier: BSD-3-Clause */
/* What is common to all formats once the header has been read; directories that hold no volume. */
#include "chunked/zarr.h"
#include "dicom/dicom.h"
#include "source.h"

#include <errno.h>
#include <fts.h>
#include <strings.h>
#include <sys/stat.h>

/* ---- directories ---- */

/* Is there an entry @p name of any kind in the directory? False also if it cannot be looked up. */
static bool holds_file(const char *directory, const char *name)
{
    char path[4096];
    struct stat info;

    return snprintf(path, sizeof path, "%s/%s", directory, name) < (int)sizeof path &&
           stat(path, &info) == 0;
}

/* Does a directory with these entries hold a DICOMDIR or a file whose name ends in .dcm or .ima?
 * Subdirectories are not searched. */
static bool holds_dicom(const sc_entries *entries)
{
    bool found = false;

    for (int i = 0; i < entries->count && !found; i++) {
        const char *name = entries->list[i]->d_name, *dot = strrchr(name, '.');

        found = (dot && (!strcasecmp(dot, ".dcm") || !strcasecmp(dot, ".ima"))) ||
                !strcmp(name, "DICOMDIR");
    }
    return found;
}

/* Is the directory a store of Zarr that lacks its own metadata: by its name, or because there are
 * some one level below? */
static bool is_headless_zarr(const char *directory, const sc_entries *entries)
{
    const char *end = directory + strlen(directory);
    bool found;

    while (end > directory + 1 && end[-1] == '/')
        end--;
    found = end - directory > 5 && !strncasecmp(end - 5, ".zarr", 5);
    for (int i = 0; i < entries->count && !found; i++) {
        char below[4096];

        found = snprintf(below, sizeof below, "%s/%s", directory, entries->list[i]->d_name) <
                    (int)sizeof below &&
                sc_zarr_is_node(below);
    }
    return found;
}

/* @return advice for a directory whose first file ends in @p ending; empty: none. */
static const char *advice_of(const char *ending)
{
    static const struct {
        const char *ending, *advice;
    } kinds[] = {{".png", ": expected slices of one volume, whose names differ in a number alone"},
                 {".jpg", ": JPEG changes labels; expected slices as PNG or TIFF"},
                 {".jpeg", ": JPEG changes labels; expected slices as PNG or TIFF"}};

    for (size_t i = 0; ending && i < SC_COUNT_OF(kinds); i++) {
        if (!strcasecmp(ending, kinds[i].ending))
            return kinds[i].advice;
    }
    return "";
}

/* Log that @p path is a directory, with advice by what it holds. @param is_dicom there are DICOM
 * files in it. @return SC_ERR_MISSING. */
static sc_status refuse_directory(const sc_ctx *ctx, const char *path, const sc_entries *entries,
                                  bool is_dicom)
{
    const char *advice = NULL, *first = entries->count ? entries->list[0]->d_name : "";
    char above[4096], contents[512] = "is empty";

    if (snprintf(above, sizeof above, "%s/..", path) < (int)sizeof above &&
        sc_is_precomputed(above))
        advice = " of chunks; give the directory above it, which holds \"info\", and which of its "
                 "scales is to be read with --set volume.level=N, 0 the finest";
    if (is_headless_zarr(path, entries))
        advice =
            " of Zarr, but its metadata are missing: there is neither zarr.json nor .zgroup nor "
            ".zarray in it; get the store anew, or give the path of an array or an image in it";
    if (holds_file(path, "datasource-properties.json") || holds_file(path, "header.wkw"))
        advice =
            " of WEBKNOSSOS (WKW), which is not read; `webknossos export-as-tiff` of its Python "
            "package writes a layer as a directory of TIFF slices, which is";
    if (is_dicom || holds_dicom(entries))
        advice = " of DICOM files, none of them a segmentation (DICOM SEG; subdirectories are not "
                 "searched); RTSTRUCT contours and labels stored as a series are converted by 3D "
                 "Slicer (save as .nrrd), an image by `dcm2niix DIRECTORY`";
    if (advice)
        return sc_fail(ctx, SC_ERR_MISSING, "%s: is a directory%s", path, advice);
    if (entries->count)
        snprintf(contents, sizeof contents, "holds %d %s \"%s\"%s", entries->count,
                 entries->count == 1 ? "entry," : "entries, the first", first,
                 advice_of(strrchr(first, '.')));
    return sc_fail(
        ctx, SC_ERR_MISSING,
        "%s: is a directory; give the path of a NRRD, NIfTI, MGH, MetaImage, TIFF, AmiraMesh or "
        "DICOM SEG file in it, of a store of Zarr or N5, of a volume of Neuroglancer, or of a "
        "directory of masks or of slices; this one %s",
        path, contents);
}

/* Open the DICOM segmentation in a directory, the only one there, which may lie among the slices of
 * its image. The names of files say nothing. @return also SC_ERR_MISSING if there is none or
 * several. */
static sc_status open_dicom_in(const sc_ctx *ctx, const char *path, sc_source *out)
{
    SC_OWN(sc_entries_clear) sc_entries entries = {0};
    SC_OWN(sc_free_at) char *first = NULL, *last = NULL;
    size_t count = 0, others = 0;

    SC_PASS(sc_entries_list(ctx, path, &entries));
    for (int i = 0; i < entries.count; i++) {
        SC_OWN(sc_free_at) char *file = NULL;
        struct stat info;
        bool is_dicom;

        SC_PASS(sc_path_join(ctx, path, entries.list[i]->d_name, &file));
        if (stat(file, &info) || !S_ISREG(info.st_mode)) /* a pipe would never end */
            continue;
        if (!sc_dicom_is_segmentation(file, &is_dicom)) {
            others += is_dicom;
            continue;
        }
        sc_free(last);
        last = NULL;
        SC_HAND_OVER(file, count++ ? &last : &first);
    }
    if (count == 0)
        return refuse_directory(ctx, path, &entries, others > 0);
    if (count > 1)
        return sc_fail(ctx, SC_ERR_MISSING,
                       "%s: holds %zu DICOM segmentations, expected one; give the path of the file "
                       "that is to be shown, such as %s or %s",
                       path, count, first, last);
    if (others)
        sc_info(ctx, "%s: of %zu DICOM files, %s is a segmentation, and read", path, others + 1,
                first);
    return sc_open_dicom(ctx, first, out);
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

sc_status sc_open_source(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                         bool header_only, sc_source *out)
{
    SC_OWN(sc_source_clear) sc_source source = {.slope = 1};
    struct stat info;
    const bool is_directory = !stat(path, &info) && S_ISDIR(info.st_mode);
    bool is_raw;

    SC_PASS(sc_header_check(ctx, path, choice, &is_raw));
    if (is_raw && !choice->level) {
        SC_PASS(sc_open_raw(ctx, path, choice, &source));
    } else if (is_directory && (sc_zarr_is_node(path) || sc_n5_is_node(path))) {
        SC_PASS(sc_open_zarr(ctx, path, choice, header_only, &source));
    } else if (is_directory && sc_is_precomputed(path)) {
        SC_PASS(sc_open_precomputed(ctx, path, choice, header_only, &source));
    } else if (choice->level) {
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: level: %s has one resolution, expected level 0, or an image of "
                       "OME-Zarr, N5 or Neuroglancer, which may have several",
                       sc_read_where(choice, path), path);
    } else if (sc_is_hdf5(path)) {
        SC_PASS(sc_open_hdf5(ctx, path, choice, header_only, &source));
    } else if (path[sc_volume_file_length(path)]) {
        return sc_fail(ctx, SC_ERR_MISSING,
                       "%s: its file is no HDF5, in which volumes have paths; expected the path "
                       "of a file alone",
                       path);
    } else if (is_directory) {
        SC_PASS(sc_open_slices(ctx, path, &source));
        if (!source.reader.slices)
            SC_PASS(sc_open_masks(ctx, path, &source));
        source.mask_files.threshold = choice->threshold;
        if (!source.reader.slices && source.mask_files.count == 0)
            SC_PASS(open_dicom_in(ctx, path, &source));
    } else {
        SC_PASS(sc_open_file(ctx, path, header_only, &source));
    }
    SC_PASS(sc_source_choose_phase(ctx, path, choice, header_only, &source));
    if (choice->threshold > 0 && !source.mask_files.count)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: threshold is for a directory of soft masks, and %s is none",
                       sc_read_where(choice, path), path);
    SC_PASS(sc_geometry_check(ctx, path, source.size, &source.to_ras_mm));
    if (!source.part[0])
        SC_PASS(sc_source_cut(ctx, path, choice, &source));
    warn_of_shear(ctx, path, &source.to_ras_mm);
    warn_of_spacing(ctx, path, &source.to_ras_mm);
    if (!source.oriented)
        sc_warn(ctx,
                "%s: does not say where left and front are; its axes are taken as right, "
                "anterior, superior",
                path);
    SC_HAND_OVER(source, out);
    return SC_OK;
}

/* Note which named rows of the table of a source are those of labels that the volume has not, and
 * which of its labels lie outside of the part that was read. */
static sc_status note_absent(const sc_ctx *ctx, const sc_source *source, sc_volume *volume)
{
    const sc_label_table *table = &source->table;
    const sc_overlap_count *overlaps = &source->overlaps;

    for (size_t i = 0; i < table->count; i++) {
        const sc_label *row = &table->rows[i];

        if (!row->value || sc_volume_label(volume, row->value))
            continue;
        if (row->name[0])
            SC_PASS(sc_label_table_add(ctx, &volume->absent, row));
        if (overlaps->covers && overlaps->covers[i] && !overlaps->lost[i])
            SC_PASS(sc_label_table_add(ctx, &volume->outside, row));
    }
    return SC_OK;
}

/* Warn where the first of several phases holds 0 and 1 alone, and no time lies between them: most
 * likely they are channels, one for each tissue, as programs that learn write them. */
static void warn_of_channels(const sc_ctx *ctx, const char *path, const sc_source *source,
                             const sc_volume *volume)
{
    if (source->series.count > 1 && source->series.phase == 1 && source->series.step_s == 0 &&
        volume->label_count == 2 && volume->labels[1].value == 1)
        sc_warn(ctx,
                "%s: holds %d volumes, with 0 and 1 alone and no time between them; if each is a "
                "tissue and not a phase of a beat, write each as a mask to a file of its own, and "
                "give the directory of these",
                path, source->series.count);
}

/* Set what a volume has of its source, but for size and labels. */
static void describe(const sc_source *source, sc_volume *volume)
{
    volume->to_ras_mm = sc_source_part_to_ras(source);
    volume->oriented = source->oriented;
    volume->numbered = source->numbered;
    volume->is_part = source->is_part;
}

/* Move the table of a source to its volume, unless its numbers are segcast's own. */
static void keep_table(sc_source *source, sc_volume *volume)
{
    if (source->numbered)
        return;
    volume->table = source->table;
    source->table = (sc_label_table){0};
}

/* Give a volume the labels of those rows that took no voxels because they are left out. */
static sc_status add_left_out(const sc_ctx *ctx, const sc_label_table *table,
                              const sc_overlap_rule *rule, sc_volume *volume)
{
    SC_OWN(sc_label_table_clear) sc_label_table left_out = {0};
    SC_OWN(sc_relabel_clear) sc_relabel relabel = {0};

    for (size_t i = 0; rule->left_out && i < table->count; i++) {
        if (rule->left_out[i])
            SC_PASS(sc_label_table_add(ctx, &left_out, &table->rows[i]));
    }
    if (!left_out.count)
        return SC_OK;
    SC_PASS(sc_relabel_with(ctx, volume->labels, volume->label_count, &left_out, &relabel));
    return sc_volume_relabel(ctx, volume, &relabel, ctx->threads);
}

/* Fill *out by the header of a volume alone. */
static sc_status read_header(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                             sc_volume *out)
{
    SC_OWN(sc_source_clear) sc_source source = {0};
    SC_OWN(sc_volume_clear) sc_volume volume = {.label_count = 1};

    SC_PASS(sc_open_source(ctx, path, choice, true, &source));
    SC_PASS(SC_ZALLOC(ctx, 1, &volume.labels));
    volume.labels[0].opacity = -1;
    memcpy(volume.size, source.part, sizeof source.part);
    describe(&source, &volume);
    SC_PASS(sc_volume_add_labels(ctx, &volume, &source.table));
    keep_table(&source, &volume);
    SC_HAND_OVER(volume, out);
    return SC_OK;
}

sc_status sc_volume_read_by(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                            sc_volume *out)
{
    const bool keep_ids = choice->depth == SC_READ_IDS;
    SC_OWN(sc_source_clear) sc_source source = {0};
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    SC_OWN(sc_overlap_rule_clear) sc_overlap_rule rule = {0};

    if (choice->depth == SC_READ_HEADER)
        return read_header(ctx, path, choice, out);
    sc_stage_begin(ctx, "reading", 0, 0); /* some formats are unpacked as a whole before */
    SC_PASS(sc_open_source(ctx, path, choice, false, &source));
    if (keep_ids)
        SC_PASS(sc_volume_memory_check(ctx, path, source.part, 0));
    if (source.mask_files.count || source.load || source.layers > 1)
        SC_PASS(sc_overlap_rule_make(ctx, path, choice, &source, &rule));
    if (source.mask_files.count)
        SC_PASS(sc_load_masks(ctx, path, &rule, &source));
    else if (source.load)
        SC_PASS(source.load(ctx, path, &rule, &source));
    else if (source.layers > 1)
        SC_PASS(sc_load_layers(ctx, path, &rule, &source));
    SC_PASS(sc_read_labels(ctx, path, &source, keep_ids, &volume));
    describe(&source, &volume);
    sc_volume_apply_table(&volume, &source.table);
    warn_of_channels(ctx, path, &source, &volume);
    SC_PASS(sc_overlap_warn(ctx, path, &source, &rule, &volume));
    if (choice->overlaps)
        SC_PASS(sc_overlap_list_take(ctx, &source, choice->overlaps));
    SC_PASS(add_left_out(ctx, &source.table, &rule, &volume));
    SC_PASS(note_absent(ctx, &source, &volume));
    keep_table(&source, &volume);
    SC_HAND_OVER(volume, out);
    return SC_OK;
}

sc_status sc_volume_phases(const sc_ctx *ctx, const char *path, int *count, double *step_s)
{
    const sc_ctx quiet = sc_quiet(ctx);
    const sc_read_choice first = {.phase = 1};
    SC_OWN(sc_source_clear) sc_source source = {0};
    const sc_status status = sc_open_source(&quiet, path, &first, true, &source);

    if (status != SC_OK && !sc_is_of_input(status))
        return status;
    *count = status == SC_OK && source.series.count > 1 ? source.series.count : 1;
    *step_s = *count > 1 ? source.series.step_s : 0;
    return SC_OK;
}

/* Append the path of a file to a list. */
static sc_status add_file(const sc_ctx *ctx, const char *path, sc_text *out)
{
    return path ? sc_text_add(ctx, out, "%s%c", path, '\0') : SC_OK;
}

/* Append the files below a directory, links not followed; none if they have more than @p most_bytes
 * bytes together. */
static sc_status add_below(const sc_ctx *ctx, const char *directory, uint64_t most_bytes,
                           sc_text *out)
{
    SC_OWN(sc_free_at) char *top = NULL;
    const FTSENT *entry;
    uint64_t bytes = 0;
    FTS *walk;
    sc_status status = sc_text_copy(ctx, directory, &top);

    walk = top ? fts_open((char *[]){top, NULL}, FTS_PHYSICAL | FTS_NOCHDIR, NULL) : NULL;
    if (status == SC_OK && !walk)
        status = sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", directory);
    while (status == SC_OK && bytes <= most_bytes && (entry = fts_read(walk))) {
        if (entry->fts_info == FTS_F) {
            bytes += (uint64_t)entry->fts_statp->st_size;
            status = add_file(ctx, entry->fts_path, out);
        }
    }
    if (walk)
        fts_close(walk);
    if (bytes > most_bytes)
        sc_text_clear(out);
    return status;
}

sc_status sc_volume_files(const sc_ctx *ctx, const char *path, uint64_t most_bytes, sc_text *out)
{
    const sc_ctx quiet = sc_quiet(ctx);
    SC_OWN(sc_source_clear) sc_source source = {0};
    const sc_text *files = &source.stored.data_files;
    struct stat info;
    sc_status status;

    if (sc_zarr_is_node(path) || sc_n5_is_node(path) || sc_is_precomputed(path))
        return add_below(ctx, path, most_bytes, out);
    if (!stat(path, &info) && !S_ISDIR(info.st_mode))
        SC_PASS(add_file(ctx, path, out));
    status = sc_open_source(&quiet, path, &(sc_read_choice){.phase = 1}, true, &source);
    if (status != SC_OK)
        return sc_is_of_input(status) ? SC_OK : status;
    SC_PASS(add_file(ctx, source.stored.file, out));
    for (size_t at = 0; at < files->length_bytes; at += strlen(files->data + at) + 1)
        SC_PASS(add_file(ctx, files->data + at, out));
    for (size_t i = 0; i < source.mask_files.count; i++)
        SC_PASS(add_file(ctx, source.mask_files.masks[i].file, out));
    return SC_OK;
}

sc_status sc_volume_reads(const sc_ctx *ctx, const char *volume, const char *path, bool *out)
{
    SC_OWN(sc_text_clear) sc_text files = {0};

    SC_PASS(sc_volume_files(ctx, volume, UINT64_MAX, &files));
    *out = false;
    for (size_t at = 0; at < files.length_bytes && !*out; at += strlen(files.data + at) + 1)
        *out = sc_same_file(files.data + at, path);
    return SC_OK;
}

sc_status sc_volume_read(const sc_ctx *ctx, const char *path, sc_volume *out)
{
    return sc_volume_read_by(ctx, path, &(sc_read_choice){0}, out);
}
