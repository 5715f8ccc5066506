/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: what the text in a TIFF file, its ImageDescription, says of the volume. */
#ifndef SC_VOLUME_TIFF_NOTES_H
#define SC_VOLUME_TIFF_NOTES_H

#include "source.h"

/* What was read of it. */
typedef struct sc_tiff_notes {
    const char *program;      /* "ImageJ" or "OME-XML", static; NULL: the text is of neither */
    int64_t slices;           /* 0: not said */
    int64_t channels, frames; /* 1 if not said */
    int64_t images;           /* ImageJ: all pictures of the file; OME-XML: elements Image; 0: not
                                 said */
    int64_t width, height;    /* OME-XML; 0: not said */
    double spacing_mm[3];     /* along x, y, z; 0: not given */
    bool unit_missing;        /* spacings are given without a unit, and taken as mm */
    bool reordered;           /* OME-XML: the planes do not stand in the order of the slices */
} sc_tiff_notes;

/* Read the text @p text of the file @p path, NULL for none. @param pixels_per_unit the resolution
 * of the file along x and y, which has ImageJ's unit; 0: none. @return SC_ERR_DATA for OME-XML that
 * is broken; SC_ERR_MEMORY; both logged. OME-XML without Expat is left out with a warning. */
sc_status sc_tiff_notes_read(const sc_ctx *ctx, const char *path, const char *text,
                             const double pixels_per_unit[2], sc_tiff_notes *out);

#endif
