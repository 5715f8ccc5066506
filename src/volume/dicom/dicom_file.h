/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: a DICOM file as DCMTK reads it. This is all that the rest of segcast, which is
 * C, sees of DCMTK, which is C++. No function throws, logs, or keeps what it is given. Threads: one
 * call at a time, since DCMTK has global state. To be called only for files that sc_dicom_check has
 * accepted: DCMTK 3.6.7 ends the process at sequences that are nested very deep. */
#ifndef SC_VOLUME_DICOM_FILE_H
#define SC_VOLUME_DICOM_FILE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* An open file. */
typedef struct sc_dicom sc_dicom;
/* The data set of a file, or an item of a sequence in it. Borrowed from the file. */
typedef struct sc_dicom_item sc_dicom_item;

/* What became of a call. */
typedef enum sc_dicom_result { SC_DICOM_OK, SC_DICOM_BAD, SC_DICOM_MEMORY } sc_dicom_result;

/* The tag (group, element) of an attribute. */
#define SC_DICOM_TAG(group, element) ((uint32_t)(group) << 16 | (element))
enum { SC_DICOM_WHY_BYTES = 256 };

/* Read a file but for its larger values, which are left in it (unless it is deflated). @param why
 * set to the reason, in the words of DCMTK, if the result is SC_DICOM_BAD. Caller owns *out:
 * sc_dicom_close. */
sc_dicom_result sc_dicom_open(const char *path, char why[SC_DICOM_WHY_BYTES], sc_dicom **out);
/* NULL is allowed. */
void sc_dicom_close(sc_dicom *file);

/* @return the data set. */
const sc_dicom_item *sc_dicom_root(const sc_dicom *file);
/* @return the item of the sequence @p tag of @p item that comes after @p previous, NULL being
 * before the first; NULL after the last, and if there is no such sequence. */
const sc_dicom_item *sc_dicom_next(const sc_dicom_item *item, uint32_t tag,
                                   const sc_dicom_item *previous);
/* Write up to @p most numbers of an attribute to @p out. @return how many values it has: 0 if it is
 * missing, empty or holds no numbers; 1 more than @p most stands for all larger counts. */
size_t sc_dicom_numbers(const sc_dicom_item *item, uint32_t tag, double *out, size_t most);
/* Write the first value of a text attribute to out[size], in UTF-8 by the character set of the
 * file, cut off if it is too long; empty if it is missing. It may hold any bytes if the file is
 * wrong. */
void sc_dicom_text(const sc_dicom *file, const sc_dicom_item *item, uint32_t tag, char *out,
                   size_t size);

/* @return how many bytes of pixels the file has that are not compressed; 0 if it has none. */
uint64_t sc_dicom_pixel_bytes(const sc_dicom *file);
/* Copy bytes of pixels that are not compressed, as they stand in a file of little-endian order. */
sc_dicom_result sc_dicom_read_bytes(sc_dicom *file, uint64_t offset, size_t bytes, void *out);
/* Unpack a frame that is compressed by RLE, of so many bytes, in the byte order of this machine.
 * If they are odd in number, one more is written.
 * @param frame counts from 0. */
sc_dicom_result sc_dicom_read_frame(sc_dicom *file, uint32_t frame, size_t bytes, void *out);

#ifdef __cplusplus
}
#endif

#endif
