/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/image.h"
#include "source.h"

void sc_volume_clear(sc_volume *volume)
{
    sc_free(volume->ids);
    sc_free(volume->tallies);
    sc_free(volume->labels);
    sc_label_table_clear(&volume->table);
    sc_label_table_clear(&volume->absent);
    sc_label_table_clear(&volume->outside);
    *volume = (sc_volume){0};
}

sc_status sc_volume_memory_check(const sc_ctx *ctx, const char *path, const int size[3],
                                 double more_bytes)
{
    static const double bytes_per_voxel = 4;
    const double voxels = (double)size[0] * size[1] * size[2];

    return sc_voxels_memory_check(ctx, path, size, voxels * bytes_per_voxel + more_bytes);
}

sc_status sc_voxels_memory_check(const sc_ctx *ctx, const char *path, const int size[3],
                                 double bytes)
{
    return sc_memory_check(ctx, bytes, "crop or resample the volume, or ",
                           "%s: %d x %d x %d voxels take about", path, size[0], size[1], size[2]);
}

size_t sc_volume_voxels(const sc_volume *volume)
{
    return (size_t)volume->size[0] * (size_t)volume->size[1] * (size_t)volume->size[2];
}

uint64_t sc_volume_hash(const sc_volume *volume)
{
    uint64_t hash = sc_hash_bytes(volume->size, sizeof volume->size, 0);

    hash = sc_hash_bytes(&volume->to_ras_mm, sizeof volume->to_ras_mm, hash);
    for (int i = 0; i < volume->label_count; i++)
        hash = sc_hash_bytes(&volume->labels[i].value, sizeof(int64_t), hash);
    return sc_hash_bytes(volume->ids, sc_volume_voxels(volume) * (size_t)volume->label_bytes, hash);
}

void sc_source_clear(sc_source *source)
{
    if (source->reader.release && source->reader.data)
        source->reader.release(source->reader.data);
    sc_free(source->stored.file);
    for (size_t i = 0; i < source->mask_files.count; i++)
        sc_free(source->mask_files.masks[i].file);
    sc_free(source->mask_files.masks);
    sc_overlap_count_clear(&source->overlaps);
    sc_free(source->segments);
    sc_text_clear(&source->stored.data_files);
    sc_label_table_clear(&source->table);
    *source = (sc_source){0};
}

size_t sc_source_voxels(const sc_source *source)
{
    return (size_t)source->size[0] * (size_t)source->size[1] * (size_t)source->size[2];
}

sc_status sc_grid_voxels(const sc_ctx *ctx, const char *path, const int64_t size[3],
                         size_t bytes_per_voxel, int out_size[3], size_t *out)
{
    double bytes = (double)bytes_per_voxel;
    size_t voxels = 1;

    for (int i = 0; i < 3; i++) {
        if (size[i] < 1 || size[i] > INT32_MAX)
            return sc_fail(ctx, SC_ERR_DATA, "%s: size %lld along axis %d, expected 1 to %d", path,
                           (long long)size[i], i, INT32_MAX);
        bytes *= (double)size[i];
        voxels *= bytes < 9e18 ? (size_t)size[i] : 1;
    }
    if (bytes > (double)SC_VOLUME_BYTES_MAX)
        return sc_fail(ctx, SC_ERR_DATA, "%s: %lld x %lld x %lld voxels are more than 1 TiB", path,
                       (long long)size[0], (long long)size[1], (long long)size[2]);
    for (int i = 0; i < 3; i++)
        out_size[i] = (int)size[i];
    if (out)
        *out = voxels;
    return SC_OK;
}

/* Check the spacings and the distance of the origin; see sc_geometry_check. */
static sc_status check_spacing(const sc_ctx *ctx, const char *path, const sc_affine *to_mm)
{
    double least_mm = HUGE_VAL, most_mm = 0;
    const double origin_mm = sc_vec3_length(sc_affine_column(to_mm, 3));

    for (int i = 0; i < 3; i++) {
        const double spacing_mm = sc_vec3_length(sc_affine_column(to_mm, i));

        least_mm = fmin(least_mm, spacing_mm);
        most_mm = fmax(most_mm, spacing_mm);
    }
    if (least_mm < SC_SPACING_LEAST_MM || most_mm > SC_SPACING_MOST_MM)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: its voxels measure %.4g to %.4g mm, expected %g to %g mm; correct the "
                       "spacing in its header",
                       path, least_mm, most_mm, SC_SPACING_LEAST_MM, SC_SPACING_MOST_MM);
    if (origin_mm > SC_ORIGIN_MOST_VOXELS * least_mm)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: its origin lies %.4g mm away, more than %g voxels of %.4g mm; correct the "
            "origin in its header",
            path, origin_mm, SC_ORIGIN_MOST_VOXELS, least_mm);
    return SC_OK;
}

/* Length of the diagonal of the volume, with two voxels more on every side, in mm. */
static double longest_line_mm(const int size[3], const sc_affine *to_mm)
{
    double most_mm = 0;

    for (int corner = 0; corner < 4; corner++) { /* four diagonals */
        const sc_vec3 diagonal = {size[0] + 4.0, (corner & 1 ? -1 : 1) * (size[1] + 4.0),
                                  (corner & 2 ? -1 : 1) * (size[2] + 4.0)};

        most_mm = fmax(most_mm, sc_vec3_length(sc_affine_vector(to_mm, diagonal)));
    }
    return most_mm;
}

sc_status sc_geometry_check(const sc_ctx *ctx, const char *path, const int size[3],
                            const sc_affine *to_ras_mm)
{
    sc_affine to_voxel;
    double line_mm;

    for (int i = 0; i < 12; i++) {
        const double value = to_ras_mm->m[i / 4][i % 4];

        if (!isfinite(value) || fabs(value) > 1e9)
            return sc_fail(ctx, SC_ERR_DATA, "%s: geometry holds %g, expected finite millimetres",
                           path, value);
    }
    SC_PASS(check_spacing(ctx, path, to_ras_mm));
    if (!sc_affine_invert(to_ras_mm, &to_voxel))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: the voxel axes are not independent (singular geometry)", path);
    line_mm = longest_line_mm(size, to_ras_mm);
    for (int i = 0; i < 3; i++) {
        const double *row = to_voxel.m[i];
        const double per_mm = sqrt(row[0] * row[0] + row[1] * row[1] + row[2] * row[2]);

        if (line_mm * per_mm > SC_EXTENT_MOST_VOXELS)
            return sc_fail(
                ctx, SC_ERR_DATA,
                "%s: measures %.4g mm from corner to corner, which are %.3g voxels of its "
                "axis %d (%.4g mm); at most %.0f can be drawn: correct the spacing in its "
                "header, or resample it",
                path, line_mm, line_mm * per_mm, i, 1 / per_mm, SC_EXTENT_MOST_VOXELS);
    }
    return SC_OK;
}
