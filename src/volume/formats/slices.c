/* SPDX-License-Identifier: BSD-3-Clause */
/* A directory with a picture for each slice, PNG or TIFF of one page, whose names differ in their
 * numbers alone. */
#include "source.h"

#include "segcast/image.h"

#include <ctype.h>
#include <stdlib.h>
#include <strings.h>
#include <sys/stat.h>

/* ---- names ---- */

/* Compare two names by the values of the numbers in them, else by their bytes. @param step set to
 * the difference of the last two numbers that differ; 0 if none do. @param alike set to whether the
 * names differ in nothing else. @return as of strcmp. */
static int compare(const char *a, const char *b, long long *step, bool *alike)
{
    int order = 0;

    *step = 0;
    *alike = true;
    while (*a && *b && *alike) {
        if (isdigit((unsigned char)*a) && isdigit((unsigned char)*b)) {
            char *ends[2];
            const long long from = strtoll(a, &ends[0], 10), to = strtoll(b, &ends[1], 10);

            if (from != to) {
                order = order ? order : (from > to) - (from < to);
                *step = to - from;
            }
            a = ends[0];
            b = ends[1];
        } else if (*a != *b) {
            *alike = false;
        } else {
            a++;
            b++;
        }
    }
    *alike = *alike && !*a && !*b;
    return order ? order : (unsigned char)*a - (unsigned char)*b;
}

/* For qsort of paths in one directory. */
static int by_number(const void *a, const void *b)
{
    const char *x = *(const char *const *)a, *y = *(const char *const *)b;
    long long step;
    bool alike;
    const int order = compare(x, y, &step, &alike);

    return order ? order : strcmp(x, y);
}

/* Note a file of the directory. @param other set to true for a volume of another format, beside
 * which pictures show something else. @return SC_ERR_MEMORY. */
static sc_status note_file(const sc_ctx *ctx, const char *directory, const char *name,
                           sc_slice_files *files, bool *other)
{
    const char *dot = strrchr(name, '.');
    const bool is_png = dot && !strcasecmp(dot, ".png");
    const bool is_tiff = dot && (!strcasecmp(dot, ".tif") || !strcasecmp(dot, ".tiff"));
    struct stat info;
    SC_OWN(sc_free_at) char *path = NULL;

    SC_PASS(sc_path_join(ctx, directory, name, &path));
    if (!is_png && !is_tiff) {
        *other = sc_is_volume_file(path);
        return SC_OK;
    }
    if (stat(path, &info) || !S_ISREG(info.st_mode)) /* a pipe would never end */
        return SC_OK;
    *other = files->count && files->is_packed != is_png;
    files->is_packed = is_png;
    SC_PASS(SC_GROW(ctx, files->count, &files->capacity, &files->paths));
    SC_HAND_OVER(path, &files->paths[files->count++]);
    return SC_OK;
}

/* Find the pictures of a directory, in their order; none unless they are named as slices are.
 * Caller owns *out, also after an error. @return SC_ERR_MEMORY. */
static sc_status find_slices(const sc_ctx *ctx, const char *directory, sc_slice_files *out)
{
    SC_OWN(sc_entries_clear) sc_entries entries = {0};
    bool other = false, alike;
    long long step;

    SC_PASS(sc_entries_list(ctx, directory, &entries));
    for (int i = 0; i < entries.count && !other; i++)
        SC_PASS(note_file(ctx, directory, entries.list[i]->d_name, out, &other));
    if (!other && out->count)
        qsort(out->paths, out->count, sizeof *out->paths, by_number);
    for (size_t i = 1; i < out->count && !other; i++) {
        compare(out->paths[i - 1], out->paths[i], &step, &alike);
        other = !alike || step == 0;
    }
    if (other || out->count < 2)
        sc_slice_files_clear(out);
    return SC_OK;
}

/* Warn of the first place where a number is left out: that slice is missing. */
static void warn_of_gap(const sc_ctx *ctx, const char *path, const sc_slice_files *files)
{
    long long first = 0, step = 0;
    bool alike;

    for (size_t i = 1; i < files->count && step == first; i++) {
        compare(files->paths[i - 1], files->paths[i], &step, &alike);
        first = i == 1 ? step : first;
        if (step != first)
            sc_warn(ctx,
                    "%s: between %s and %s slices seem to be missing; the others are taken as if "
                    "none were",
                    path, strrchr(files->paths[i - 1], '/') + 1, strrchr(files->paths[i], '/') + 1);
    }
}

/* ---- pixels ---- */

/* Read a PNG file, as a volume of one slice. Caller owns *out: sc_source_clear. */
static sc_status open_png(const sc_ctx *ctx, const char *file, sc_source *out)
{
    SC_OWN(sc_source_clear) sc_source source = {.slope = 1, .reader.release = sc_free};
    sc_levels levels;

    SC_PASS(sc_image_load_levels(ctx, file, &levels));
    source.reader.data = levels.levels;
    source.size[0] = levels.width_px;
    source.size[1] = levels.height_px;
    source.size[2] = 1;
    source.type = levels.bytes == 2 ? SC_VOXEL_UINT16 : SC_VOXEL_UINT8;
    for (int i = 0; i < 3; i++)
        source.to_ras_mm.m[i][i] = 1;
    for (int i = 1; i < levels.colors; i++) {
        sc_label row = {.value = i, .opacity = -1, .has_color = true};

        memcpy(row.rgb, levels.palette[i], sizeof row.rgb);
        SC_PASS(sc_label_table_add(ctx, &source.table, &row));
    }
    SC_HAND_OVER(source, out);
    return SC_OK;
}

/* Open slice @p i. Caller owns *out: sc_source_clear. */
static sc_status open_slice(const sc_ctx *ctx, const sc_slice_files *files, size_t i,
                            sc_source *out)
{
    const char *file = files->paths[i];

    return files->is_packed ? open_png(ctx, file, out) : sc_open_file(ctx, file, false, out);
}

sc_status sc_open_slices(const sc_ctx *ctx, const char *path, sc_source *out)
{
    SC_OWN(sc_slice_files_clear) sc_slice_files files = {.open = open_slice};
    SC_OWN(sc_source_clear) sc_source source = {.slope = 1}, first = {.slope = 1};
    int64_t size[3];

    SC_PASS(find_slices(ctx, path, &files));
    if (!files.count)
        return SC_OK;
    SC_PASS(open_slice(ctx, &files, 0, &first));
    if (first.size[2] > 1) /* masks, whose names have numbers */
        return SC_OK;
    size[0] = first.size[0];
    size[1] = first.size[1];
    size[2] = (int64_t)files.count;
    source.type = first.type;
    source.to_ras_mm = first.to_ras_mm;
    SC_PASS(sc_grid_voxels(ctx, path, size, sc_voxel_type_bytes(source.type), source.size, NULL));
    source.table = first.table;
    first.table = (sc_label_table){0};
    if (files.is_packed)
        sc_warn(ctx,
                "%s: PNG does not give the spacing of its voxels; taken as 1 x 1 x 1 mm (--header "
                "\"0.5x0.5x1 mm\" says another)",
                path);
    warn_of_gap(ctx, path, &files);
    SC_PASS(sc_slice_files_use(ctx, &files, &source));
    SC_HAND_OVER(source, out);
    return SC_OK;
}
