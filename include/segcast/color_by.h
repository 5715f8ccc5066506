/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Colours of tissues that follow from values: those of a table, or what was measured. */
#ifndef SEGCAST_COLOR_BY_H
#define SEGCAST_COLOR_BY_H

#include "segcast/scene.h"

/** What is measured of a tissue. */
typedef enum sc_measure {
    SC_MEASURE_VOLUME,    /**< in ml */
    SC_MEASURE_THICKNESS, /**< mean thickness, in mm */
    SC_MEASURE_SURFACE    /**< in square centimetres */
} sc_measure;

/** Colour maps: a colour for each number from 0 to 1. */
typedef enum sc_color_map {
    SC_MAP_VIRIDIS,
    SC_MAP_CIVIDIS,
    SC_MAP_MAGMA,
    SC_MAP_INFERNO,
    SC_MAP_PLASMA,
    SC_MAP_COOLWARM /**< diverging: blue, light grey in the middle, red */
} sc_color_map;

/** How tissues are coloured by values. Members that hold an enum are of type int, as in job.h. */
typedef struct sc_color_by {
    char table[4096];           /**< path of a table of values; empty: none */
    char column[SC_NAME_BYTES]; /**< heading of the values; empty: see sc_value_table_read */
    char title[SC_NAME_BYTES];  /**< of the colour bar; empty: the column or the measure */
    bool has_measure;           /**< the values are the measure instead */
    int measure;                /**< sc_measure */
    int map;                    /**< sc_color_map */
    bool range_auto;            /**< low and high are those of the tissues that are not hidden */
    double low, high;           /**< values of the ends of the map */
    uint8_t missing[3];         /**< sRGB, of tissues without a value */
} sc_color_by;
/** @return whether tissues are coloured by values at all. */
static inline bool sc_color_by_any(const sc_color_by *by)
{
    return by->table[0] || by->has_measure;
}

/** The scale from values to colours. Plain data, so that it can be sent to other ranks. */
typedef struct sc_color_scale {
    bool is_used;       /**< false: tissues are not coloured by values */
    bool lacks_some;    /**< a tissue that is not hidden has no value */
    int map;            /**< sc_color_map */
    double low, high;   /**< finite, low <= high */
    uint8_t missing[3]; /**< sRGB */
    char title[SC_NAME_BYTES];
} sc_color_scale;

/** Write the colour of @p share, clamped to 0 to 1, in a map to @p rgb (sRGB). */
void sc_color_map_at(sc_color_map map, double share, uint8_t rgb[3]);
/** Write the colour of a value to @p rgb (sRGB); of NAN, that of missing values. */
void sc_color_scale_at(const sc_color_scale *scale, double value, uint8_t rgb[3]);

/** Write the colour of a value on its way from one to another to @p rgb (sRGB): the colour of the
 * value between them, so that the way leads along the map. If one of them is missing (NAN), it
 * leads straight from the colour of one to that of the other. @param share of the way, 0 to 1. */
void sc_color_scale_between(const sc_color_scale *scale, double from, double to, double share,
                            uint8_t rgb[3]);

/** Find the values of all labels. Rows of a table belong to the label of their number, or else to
 *  the labels of their name; ASCII case, and whether blanks, "_" or "-" separate words, is ignored
 *  unless a name is the same to the letter. Rows of labels that the volume has not are not used,
 *  which a warning tells. @param volume of which labels, statistics and geometry are read; measures
 *  that were not made are missing. @param values [label_count] by dense id; NAN: missing.
 *  @param title where to write what the values are; may be empty afterwards.
 *  @return as sc_value_table_read; SC_ERR_DATA also for two rows of a label, and if no row belongs
 *  to a label. */
SC_MUST_USE sc_status sc_color_values(const sc_ctx *ctx, const sc_color_by *by,
                                      const sc_prepared *volume, double *values,
                                      char title[SC_NAME_BYTES]);
/** Find the scale for these values. An automatic range goes from the least to the greatest value of
 *  the tissues that have voxels and are not hidden; a diverging map has 0 in its middle if values
 *  lie on both sides of it. @param values [columns][label_count]: all that tissues have in turn.
 *  @param title of the colour bar. */
void sc_color_scale_find(const sc_color_by *by, const sc_prepared *volume, const double *values,
                         int columns, const char *title, sc_color_scale *out);

#endif
