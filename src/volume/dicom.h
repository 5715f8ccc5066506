/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the parts of the reader of DICOM segmentations. Source of all that is said of
 * the format: the DICOM standard, PS3.3 (attributes), PS3.5 (encoding), PS3.10 (files). */
#ifndef SC_VOLUME_DICOM_H
#define SC_VOLUME_DICOM_H

#include "dicom_file.h"
#include "source.h"

/* What a file says of itself before its data set. */
typedef struct sc_dicom_kind {
    bool is_labels;     /* Label Map Segmentation, not Segmentation */
    bool is_compressed; /* the pixels, by RLE */
} sc_dicom_kind;

/* Check that @p path is a DICOM file of a segmentation in a transfer syntax that can be read, and
 * go once through its data set: that all lengths lie within the file, and sequences are not nested
 * deeper than such files have them, as DCMTK does not check. @return SC_ERR_DATA with advice for
 * what is another kind of DICOM or damaged; SC_ERR_SYSTEM if the attributes take more memory than a
 * volume may; SC_ERR_MISSING, SC_ERR_WRITE, SC_ERR_MEMORY. */
sc_status sc_dicom_check(const sc_ctx *ctx, const char *path, sc_dicom_kind *out);
/* @return whether the file @p path is DICOM and says that it is a segmentation. @param is_dicom set
 * to whether it is DICOM at all. False also for what cannot be read. */
bool sc_dicom_is_segmentation(const char *path, bool *is_dicom);

/* Read the segments of a file into a table: a row for each, its number being the value; names and
 * colours. @return SC_ERR_DATA for a number that cannot be or stands twice; SC_ERR_MEMORY. */
sc_status sc_dicom_read_segments(const sc_ctx *ctx, const char *path, const sc_dicom *file,
                                 sc_label_table *table);

/* One frame: where its pixels are. */
typedef struct sc_dicom_frame {
    uint32_t number;     /* in the file, from 0 */
    int segment;         /* the number of its segment; 0 in a label map */
    int slice;           /* from 0 */
    sc_vec3 position_mm; /* of its first pixel, LPS */
    double along_mm;     /* that, along the normal of the slices */
} sc_dicom_frame;

/* Read where the frames of a file lie and what they show, and set size and geometry of @p source.
 * @param has_segments each frame shows one segment.
 * @param frames [count], all that the file describes; sorted by slice and segment when they come
 * back.
 * @param size_px columns and rows.
 * @return SC_ERR_DATA for what is missing or does not agree: directions or spacings that differ
 * between frames, positions that are not those of parallel slices at equal distances (to a tenth of
 * it), or two frames of one segment in one slice. */
sc_status sc_dicom_place_frames(const sc_ctx *ctx, const char *path, const sc_dicom *file,
                                bool has_segments, const int size_px[2], sc_dicom_frame *frames,
                                uint32_t count, sc_source *source);

#endif
