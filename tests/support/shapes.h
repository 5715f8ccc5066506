/* SPDX-License-Identifier: BSD-3-Clause */
/* Small label volumes of simple shapes, for which results are known. */
#ifndef SC_TEST_SHAPES_H
#define SC_TEST_SHAPES_H

#include "segcast/prepare.h"

/* A volume whose dense ids a function of the voxel indices gives; the label of id i is 3 i. */
static inline sc_volume shape_volume(const int size[3], const double spacing_mm[3], int label_bytes,
                                     int label_count, int (*id_of)(double x, double y, double z))
{
    sc_volume v = {.size = {size[0], size[1], size[2]},
                   .label_bytes = label_bytes,
                   .label_count = label_count,
                   .oriented = true};
    size_t n = 0;

    assert_ok(sc_alloc(&quiet, sc_volume_voxels(&v), (size_t)label_bytes, &v.ids));
    assert_ok(SC_ZALLOC(&quiet, (size_t)label_count, &v.labels));
    for (int i = 0; i < label_count; i++) {
        v.labels[i].value = 3 * i;
        v.labels[i].opacity = -1;
        snprintf(v.labels[i].name, sizeof v.labels[i].name, "tissue %d", i);
        sc_label_base_color(3 * i, v.labels[i].rgb);
    }
    for (int z = 0; z < size[2]; z++) {
        for (int y = 0; y < size[1]; y++) {
            for (int x = 0; x < size[0]; x++, n++) {
                const int id = id_of(x, y, z);

                if (label_bytes == 1)
                    ((uint8_t *)v.ids)[n] = (uint8_t)id;
                else
                    ((uint16_t *)v.ids)[n] = (uint16_t)id;
            }
        }
    }
    for (int i = 0; i < 3; i++)
        v.to_ras_mm.m[i][i] = spacing_mm[i];
    return v;
}

/* The same as a cube of voxels of 1 mm. */
static inline sc_volume cube_volume(int side, int label_count, int id_at(double, double, double))
{
    return shape_volume((const int[3]){side, side, side}, (const double[3]){1, 1, 1}, 1,
                        label_count, id_at);
}

/* A prepared volume: a block, which clear_copy frees, and the view of it. */
typedef struct prepared_copy {
    void *block;
    size_t bytes;
    sc_prepared view;
} prepared_copy;

static inline void clear_copy(prepared_copy *copy)
{
    sc_free(copy->block);
}

/* @return a copy of @p p, which is freed. */
static inline prepared_copy pack_copy(sc_preparation *p)
{
    prepared_copy out = {.bytes = sc_preparation_bytes(p)};

    assert_ok(sc_zalloc(&quiet, out.bytes, 1, &out.block));
    sc_preparation_pack(p, out.block);
    sc_preparation_free(p);
    assert_ok(sc_prepared_view(&quiet, out.block, out.bytes, &out.view));
    return out;
}

static inline prepared_copy prepare_as(const sc_volume *volume, const sc_prepare_settings *settings)
{
    sc_preparation *p;

    assert_ok(sc_prepare(&quiet, volume, settings, &p));
    return pack_copy(p);
}

/* prepare_copy, smoothed by @p strength. */
static inline prepared_copy prepare_copy_smooth(const sc_volume *volume, int threads,
                                                double strength)
{
    const sc_prepare_settings settings = {
        .smooth = {strength, strength, strength}, .local_thickness = true, .threads = threads};

    return prepare_as(volume, &settings);
}

static inline prepared_copy prepare_copy(const sc_volume *volume, int threads)
{
    return prepare_copy_smooth(volume, threads, 1);
}

#endif
