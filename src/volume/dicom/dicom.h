/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the parts of the reader of DICOM segmentations. Source of all that is said of
 * the format: the DICOM standard, PS3.3 (attributes), PS3.5 (encoding), PS3.10 (files). */
#ifndef SC_VOLUME_DICOM_H
#define SC_VOLUME_DICOM_H

#include "dicom/dicom_file.h"
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
    int image;           /* its place in the list of sc_dicom_images, or -1 */
    sc_vec3 position_mm; /* of its first pixel, LPS */
    double along_mm;     /* that, along the normal of the slices */
} sc_dicom_frame;

enum { SC_DICOM_IMAGES_MAX = 1 << 20 /* in longer lists nothing is looked up */ };

/* The images that a file says it was made of, in the order of their names. */
typedef struct sc_dicom_image sc_dicom_image;
typedef struct sc_dicom_images {
    sc_dicom_image *images; /* [count] */
    int count;              /* 0 if it names none, or those of several series */
} sc_dicom_images;

/* Read the list of images. Caller owns *out: sc_dicom_images_clear. @return SC_ERR_MEMORY. */
sc_status sc_dicom_images_read(const sc_ctx *ctx, const sc_dicom *file, sc_dicom_images *out);
void sc_dicom_images_clear(sc_dicom_images *images);
/* @return the place in the list, from 0, of the image that a frame was made of, by the functional
 * groups of the frame; -1 if it names none, several, or one that is not in the list. */
int sc_dicom_image_of(const sc_dicom_images *images, const sc_dicom *file,
                      const sc_dicom_item *frame);

/* Slices in which nothing is, and for which there are no frames. */
typedef struct sc_dicom_ends {
    int before, behind; /* the first slice, and the last */
    bool is_known;      /* the file tells how many they are; otherwise there are more images than
                           slices, but not where, and each end gets one slice */
} sc_dicom_ends;

/* Find how many slices were left out at both ends. @param frames sorted by slice. @param slices
 * from the first to the last that has frames. */
sc_dicom_ends sc_dicom_left_out(const sc_dicom_images *images, const sc_dicom_frame *frames,
                                uint32_t count, int slices);

/* Read where the frames of a file lie and what they show, and set size and geometry of @p source.
 * Slices that were left out at the ends are there, as far as the file tells of them, which is said.
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
