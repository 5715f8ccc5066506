/* SPDX-License-Identifier: BSD-3-Clause */
/* The images that a DICOM segmentation was made of, as far as it names them: how many there are,
 * and which of them each frame shows. From this follows how many slices before the first and behind
 * the last were left out because nothing is in them. */
#include "dicom/dicom.h"

#include <stdlib.h>

#define REFERENCED_SERIES SC_DICOM_TAG(0x0008, 0x1115)
#define REFERENCED_INSTANCES SC_DICOM_TAG(0x0008, 0x114a)
#define DERIVATION_IMAGES SC_DICOM_TAG(0x0008, 0x9124)
#define SOURCE_IMAGES SC_DICOM_TAG(0x0008, 0x2112)
#define INSTANCE_UID SC_DICOM_TAG(0x0008, 0x1155)

enum { UID_BYTES = 72 /* of a UID with its NUL, which has at most 64 characters */ };

struct sc_dicom_image {
    char uid[UID_BYTES];
    int place; /* in the list of images, from 0 */
};

/* For qsort and bsearch of sc_dicom_image. */
static int by_uid(const void *a, const void *b)
{
    return strcmp(((const sc_dicom_image *)a)->uid, ((const sc_dicom_image *)b)->uid);
}

/* @return the list of images, if the file has one; NULL for none, and for several series. */
static const sc_dicom_item *only_series(const sc_dicom *file)
{
    const sc_dicom_item *root = sc_dicom_root(file);
    const sc_dicom_item *series = sc_dicom_next(root, REFERENCED_SERIES, NULL);

    return series && !sc_dicom_next(root, REFERENCED_SERIES, series) ? series : NULL;
}

sc_status sc_dicom_images_read(const sc_ctx *ctx, const sc_dicom *file, sc_dicom_images *out)
{
    const sc_dicom_item *series = only_series(file), *item = NULL;
    size_t count = 0;

    *out = (sc_dicom_images){0};
    while (series && (item = sc_dicom_next(series, REFERENCED_INSTANCES, item)) != NULL)
        count++;
    if (count == 0 || count > SC_DICOM_IMAGES_MAX)
        return SC_OK;
    SC_PASS(SC_ALLOC(ctx, count, &out->images));
    for (; (item = sc_dicom_next(series, REFERENCED_INSTANCES, item)) != NULL; out->count++) {
        sc_dicom_image *image = &out->images[out->count];

        sc_dicom_text(file, item, INSTANCE_UID, image->uid, sizeof image->uid);
        image->place = out->count;
    }
    qsort(out->images, count, sizeof *out->images, by_uid);
    for (int i = 1; i < out->count; i++) {
        if (by_uid(&out->images[i - 1], &out->images[i]) == 0) { /* a list that tells nothing */
            sc_dicom_images_clear(out);
            break;
        }
    }
    return SC_OK;
}

void sc_dicom_images_clear(sc_dicom_images *images)
{
    sc_free(images->images);
    *images = (sc_dicom_images){0};
}

int sc_dicom_image_of(const sc_dicom_images *images, const sc_dicom *file,
                      const sc_dicom_item *frame)
{
    const sc_dicom_item *derivation =
        images->count && frame ? sc_dicom_next(frame, DERIVATION_IMAGES, NULL) : NULL;
    const sc_dicom_item *source =
        derivation ? sc_dicom_next(derivation, SOURCE_IMAGES, NULL) : NULL;
    const sc_dicom_image *found;
    sc_dicom_image wanted;

    if (!source || sc_dicom_next(derivation, SOURCE_IMAGES, source))
        return -1;
    sc_dicom_text(file, source, INSTANCE_UID, wanted.uid, sizeof wanted.uid);
    found = bsearch(&wanted, images->images, (size_t)images->count, sizeof wanted, by_uid);
    return found ? found->place : -1;
}

/* @return whether the images stand in the list in the order of the slices, or, with @p step -1, the
 * other way round: each frame's as far from that of the first as its slice is. */
static bool in_order(const sc_dicom_frame *frames, uint32_t count, int step)
{
    for (uint32_t i = 0; i < count; i++) {
        if (frames[i].image < 0 ||
            frames[i].image != frames[0].image + step * (frames[i].slice - frames[0].slice))
            return false;
    }
    return true;
}

sc_dicom_ends sc_dicom_left_out(const sc_dicom_images *images, const sc_dicom_frame *frames,
                                uint32_t count, int slices)
{
    const int last = images->count - 1;

    if (images->count <= slices)
        return (sc_dicom_ends){0};
    if (slices > 1 && in_order(frames, count, 1))
        return (sc_dicom_ends){frames[0].image, last - frames[count - 1].image, true};
    if (slices > 1 && in_order(frames, count, -1))
        return (sc_dicom_ends){last - frames[0].image, frames[count - 1].image, true};
    return (sc_dicom_ends){1, 1, false};
}
