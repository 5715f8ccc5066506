/* SPDX-License-Identifier: BSD-3-Clause */
/* A directory of masks, one file for each tissue, as TotalSegmentator writes it: which files are
 * masks, what they are called, and where each lies on the grid of all. */
#include "source.h"

#include <stdlib.h>
#include <sys/stat.h>

enum { PLACE_MOST = 1 << 30 /* voxels that a mask may lie away from the first */ };

/* ---- names ---- */

/* @return the length of the name of a file without the ending that tells a volume; 0 if it has
 * none, or nothing else. */
static size_t stem_length(const char *name)
{
    static const char *const endings[] = {".nii.gz", ".nii", ".seg.nrrd", ".nrrd", ".nhdr",
                                          ".mha",    ".mhd", ".mgz",      ".mgh",  ".tif",
                                          ".tiff",   ".hdr", ".h5",       ".hdf5"};

    return sc_stem_length(name, endings, SC_COUNT_OF(endings));
}

/* For qsort of sc_mask: rising by the bytes of the name without its ending, then of the whole. All
 * are in one directory. */
static int by_name(const void *a, const void *b)
{
    const char *x = strrchr(((const sc_mask *)a)->file, '/') + 1;
    const char *y = strrchr(((const sc_mask *)b)->file, '/') + 1;
    const size_t m = stem_length(x), n = stem_length(y);
    const int order = memcmp(x, y, m < n ? m : n);

    return order ? order : m != n ? (m > n) - (m < n) : strcmp(x, y);
}

/* Append a mask to the source, whose masks have room for *capacity. */
static sc_status add_mask(const sc_ctx *ctx, const char *directory, const char *name,
                          size_t *capacity, sc_source *source)
{
    sc_text text = {0};

    if (source->mask_files.count == SC_LABELS_MAX - 1)
        return sc_fail(ctx, SC_ERR_DATA, "%s: has more than %d masks, expected at most so many",
                       directory, SC_LABELS_MAX - 1);
    SC_PASS(SC_GROW(ctx, source->mask_files.count, capacity, &source->mask_files.masks));
    SC_PASS(sc_text_add(ctx, &text, "%s/%s", directory, name));
    source->mask_files.masks[source->mask_files.count++] = (sc_mask){.file = text.data};
    return SC_OK;
}

/* Find the files that are named like volumes, and sort them. */
static sc_status list_masks(const sc_ctx *ctx, const char *directory, sc_source *source)
{
    SC_OWN(sc_entries_clear) sc_entries entries = {0};
    size_t capacity = 0;

    SC_PASS(sc_entries_list(ctx, directory, &entries));
    for (int i = 0; i < entries.count; i++) {
        if (stem_length(entries.list[i]->d_name))
            SC_PASS(add_mask(ctx, directory, entries.list[i]->d_name, &capacity, source));
    }
    if (source->mask_files.count)
        qsort(source->mask_files.masks, source->mask_files.count, sizeof *source->mask_files.masks,
              by_name);
    return SC_OK;
}

/* Make the rows of the table: label and name of each mask. @return SC_ERR_DATA if two have one
 * name. */
static sc_status name_masks(const sc_ctx *ctx, const char *path, sc_source *source)
{
    sc_name_count names = {0};

    for (size_t i = 0; i < source->mask_files.count; i++) {
        const char *name = strrchr(source->mask_files.masks[i].file, '/') + 1;
        sc_label row = {.value = (int64_t)i + 1, .opacity = -1};
        char *stem = strndup(name, stem_length(name));

        if (!stem)
            return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
        sc_name_read(stem, row.name, &names);
        free(stem);
        if (i && !strcmp(row.name, source->table.rows[i - 1].name))
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s and %s name the same tissue; expected one mask for each: move one "
                           "out of the directory",
                           source->mask_files.masks[i - 1].file, source->mask_files.masks[i].file);
        SC_PASS(sc_label_table_add(ctx, &source->table, &row));
    }
    sc_name_warn(ctx, path, &names);
    return SC_OK;
}

/* ---- headers ---- */

/* Do two geometries put all corners of a volume of so many voxels at the same places, to a
 * hundredth of a voxel? Programs round what they write. */
static bool same_geometry(const int size[3], const sc_affine *a, const sc_affine *b)
{
    double spacing_mm = HUGE_VAL, most_mm = 0;

    for (int i = 0; i < 3; i++)
        spacing_mm = fmin(spacing_mm, sc_vec3_length(sc_affine_column(a, i)));
    for (int corner = 0; corner < 8; corner++) {
        const sc_vec3 at = {corner & 1 ? size[0] : 0, corner & 2 ? size[1] : 0,
                            corner & 4 ? size[2] : 0};
        const sc_vec3 x = sc_affine_point(a, at), y = sc_affine_point(b, at);

        most_mm = fmax(most_mm, sc_vec3_length(sc_vec3_sub(x, y)));
    }
    return most_mm <= 0.01 * spacing_mm;
}

/* Do the axes of a mask lead along those of the source as mask->axis and mask->flip say, and its
 * voxels lie on those of the same grid? If so, sets mask->low. @param to_ras_mm of the mask. */
static bool is_placed_so(const sc_source *source, sc_mask *mask, const sc_affine *to_ras_mm)
{
    sc_affine turned = *to_ras_mm; /* of the voxels of the mask by the axes of the source */
    sc_affine moved = source->to_ras_mm, from_ras;
    sc_vec3 first;
    int size[3];

    for (int i = 0; i < 3; i++) {
        size[mask->axis[i]] = mask->size[i];
        for (int row = 0; row < 3; row++) {
            const double step = to_ras_mm->m[row][i];

            turned.m[row][mask->axis[i]] = mask->flip[i] ? -step : step;
            turned.m[row][3] += mask->flip[i] ? step * (mask->size[i] - 1) : 0;
        }
    }
    if (!sc_affine_invert(&source->to_ras_mm, &from_ras))
        return false;
    first = sc_affine_point(&from_ras, (sc_vec3){turned.m[0][3], turned.m[1][3], turned.m[2][3]});
    if (!(fabs(first.x) < PLACE_MOST && fabs(first.y) < PLACE_MOST && fabs(first.z) < PLACE_MOST))
        return false;
    mask->low[0] = (int)lround(first.x);
    mask->low[1] = (int)lround(first.y);
    mask->low[2] = (int)lround(first.z);
    first =
        sc_affine_point(&source->to_ras_mm, (sc_vec3){mask->low[0], mask->low[1], mask->low[2]});
    moved.m[0][3] = first.x;
    moved.m[1][3] = first.y;
    moved.m[2][3] = first.z;
    return same_geometry(size, &moved, &turned);
}

/* Find how the axes of a mask lead along those of the source, and where it lies: most often they
 * are the same, but some programs store masks along other axes, or only the box around the tissue.
 * @return false if its voxels are none of the same grid. */
static bool find_place(const sc_source *source, const sc_affine *to_ras_mm, sc_mask *mask)
{
    static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                     {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};

    for (int turn = 0; turn < 48; turn++) {
        for (int i = 0; i < 3; i++) {
            mask->axis[i] = orders[turn / 8][i];
            mask->flip[i] = turn >> i & 1;
        }
        if (is_placed_so(source, mask, to_ras_mm))
            return true;
    }
    return false;
}

/* @return whether a mask is stored along other axes than the source. */
static bool is_turned(const sc_mask *mask)
{
    bool turned = false;

    for (int i = 0; i < 3; i++)
        turned = turned || mask->axis[i] != i || mask->flip[i];
    return turned;
}

/* @return whether a mask has not just the voxels of the source. */
static bool is_cropped(const sc_source *source, const sc_mask *mask)
{
    bool cropped = false;

    for (int i = 0; i < 3; i++)
        cropped = cropped || mask->size[i] != source->size[mask->axis[i]] || mask->low[i];
    return cropped;
}

bool sc_mask_is_placed(const sc_source *source, const sc_mask *mask)
{
    return is_turned(mask) || is_cropped(source, mask);
}

sc_status sc_mask_place(const sc_ctx *ctx, const sc_source *source, size_t i,
                        const sc_source *header)
{
    static const char advice[] =
        "expected masks of one grid: resample one to the other, or move it "
        "out of the directory";
    const char *first = source->mask_files.masks[0].file;
    const int *a = source->size, *b = header->size;
    sc_mask *mask = &source->mask_files.masks[i];

    memcpy(mask->size, b, sizeof mask->size);
    if (find_place(source, &header->to_ras_mm, mask) &&
        ((source->oriented && header->oriented) || !is_cropped(source, mask)))
        return SC_OK;
    if (memcmp(a, b, sizeof source->size) != 0 && !(source->oriented && header->oriented))
        return sc_fail(ctx, SC_ERR_DATA, "%s has %d x %d x %d voxels, but %s %d x %d x %d; %s",
                       mask->file, b[0], b[1], b[2], first, a[0], a[1], a[2], advice);
    return sc_fail(
        ctx, SC_ERR_DATA,
        "%s has another voxel size or orientation than %s, or voxels between its voxels; %s",
        mask->file, first, advice);
}

/* Let the source be the box that holds all masks, which have their places by those of the first. */
static sc_status unite(const sc_ctx *ctx, const char *path, sc_source *source)
{
    int64_t low[3] = {0, 0, 0}, high[3], size[3];
    sc_vec3 first;

    for (int a = 0; a < 3; a++)
        high[a] = source->size[a];
    for (size_t i = 0; i < source->mask_files.count; i++) {
        const sc_mask *mask = &source->mask_files.masks[i];

        for (int k = 0; k < 3; k++) {
            const int a = mask->axis[k];
            const int64_t end = (int64_t)mask->low[a] + mask->size[k];

            low[a] = mask->low[a] < low[a] ? mask->low[a] : low[a];
            high[a] = end > high[a] ? end : high[a];
        }
    }
    for (int a = 0; a < 3; a++)
        size[a] = high[a] - low[a];
    SC_PASS(sc_grid_voxels(ctx, path, size, 2, source->size, NULL));
    first = sc_affine_point(&source->to_ras_mm,
                            (sc_vec3){(double)low[0], (double)low[1], (double)low[2]});
    source->to_ras_mm.m[0][3] = first.x;
    source->to_ras_mm.m[1][3] = first.y;
    source->to_ras_mm.m[2][3] = first.z;
    for (int a = 0; a < 3; a++) {
        for (size_t i = 0; i < source->mask_files.count; i++)
            source->mask_files.masks[i].low[a] -= (int)low[a];
    }
    return SC_OK;
}

/* Tell how many masks are stored along other axes than the first, and how many have parts of the
 * grid. */
static void tell_places(const sc_ctx *ctx, const char *path, const sc_source *source)
{
    size_t turned = 0, cropped = 0;

    for (size_t i = 0; i < source->mask_files.count; i++) {
        turned += is_turned(&source->mask_files.masks[i]);
        cropped += is_cropped(source, &source->mask_files.masks[i]);
    }
    if (turned)
        sc_info(ctx, "%s: %zu of %zu masks are stored along other axes than %s, and turned to them",
                path, turned, source->mask_files.count, source->mask_files.masks[0].file);
    if (cropped)
        sc_info(
            ctx,
            "%s: %zu of %zu masks have a part of the grid; together they have %d x %d x %d voxels",
            path, cropped, source->mask_files.count, source->size[0], source->size[1],
            source->size[2]);
}

sc_status sc_open_mask(const sc_ctx *ctx, const char *file, bool header_only, sc_source *out)
{
    return sc_is_hdf5(file) ? sc_open_hdf5(ctx, file, &(sc_read_choice){0}, header_only, out)
                            : sc_open_file(ctx, file, header_only, out);
}

sc_status sc_open_masks(const sc_ctx *ctx, const char *path, sc_source *out)
{
    SC_OWN(sc_source_clear) sc_source source = {.slope = 1, .numbered = true}, mask = {.slope = 1};
    sc_ctx errors = *ctx; /* what is warned of one mask, is so of all */

    errors.level = SC_LOG_ERROR;
    SC_PASS(list_masks(ctx, path, &source));
    SC_PASS(name_masks(ctx, path, &source));
    for (size_t i = 0; i < source.mask_files.count; i++) {
        SC_PASS(sc_open_mask(i ? &errors : ctx, source.mask_files.masks[i].file, true, &mask));
        SC_PASS(sc_source_choose_phase(ctx, source.mask_files.masks[i].file, &(sc_read_choice){0},
                                       true, &mask));
        if (i == 0) {
            memcpy(source.size, mask.size, sizeof source.size);
            source.to_ras_mm = mask.to_ras_mm;
            source.oriented = mask.oriented;
        }
        SC_PASS(sc_mask_place(ctx, &source, i, &mask));
        sc_source_clear(&mask);
        mask.slope = 1;
    }
    if (source.mask_files.count)
        SC_PASS(unite(ctx, path, &source));
    tell_places(ctx, path, &source);
    SC_HAND_OVER(source, out);
    return SC_OK;
}
