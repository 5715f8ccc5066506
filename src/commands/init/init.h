/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to segcast init: what is known of the tissues of a volume beside their measurements. */
#ifndef SC_COMMANDS_INIT_H
#define SC_COMMANDS_INIT_H

#include "segcast/process.h"

/* A system of the body, as anatomical atlases are divided; in the order of a job file. */
typedef enum sc_system {
    SC_SYSTEM_COVERS, /* tissues that enclose others */
    SC_SYSTEM_SKELETON,
    SC_SYSTEM_MUSCLES,
    SC_SYSTEM_HEART,
    SC_SYSTEM_VESSELS,
    SC_SYSTEM_AIRWAYS,
    SC_SYSTEM_DIGESTIVE,
    SC_SYSTEM_UROGENITAL,
    SC_SYSTEM_GLANDS,
    SC_SYSTEM_NERVES,
    SC_SYSTEM_OTHER,
    SC_SYSTEM_COUNT
} sc_system;
/* @return words for a comment, such as "Skeleton". */
const char *sc_system_title(sc_system system);

/* A tissue in its place. */
typedef struct sc_place {
    int id;                   /* dense id */
    sc_system system;         /* by the words of its name */
    int layer;                /* of a cover: 1 for the outermost; else 0 */
    int side;                 /* 0: right, 1: left, 2: neither */
    double height_mm;         /* of its middle above the origin, towards the head */
    double group_mm;          /* the largest height of the tissues with the same stem */
    char stem[SC_NAME_BYTES]; /* its name without sides and numbers, in lower case */
} sc_place;

/* Put the tissues that have voxels in the order in which an atlas lists them: covers from the
 * outside, then by system; within one from the head to the feet, but both sides of a pair and all
 * members of a series (ribs, vertebrae) together. @param layers [label_count] of sc_name_covers.
 * @param out [*count]; caller owns: sc_free. @return SC_ERR_MEMORY. */
sc_status sc_places_find(const sc_ctx *ctx, const sc_prepared *volume, const int *layers,
                         sc_place **out, int *count);

/* Find the tissues that hide what they enclose, as sc_find_covers does, and those whose name says
 * that they are skin, or what is left over, as one more layer. @param hidden [label_count] of
 * sc_hidden_labels: as if they were not there. @param layers [label_count]: 1 for the outermost
 * cover, 0 for all that are none. @return SC_ERR_MEMORY. */
sc_status sc_name_covers(const sc_ctx *ctx, const sc_prepared *volume, const bool *hidden,
                         int *layers);

/* Copy a name to @p to, which has SC_NAME_BYTES: in lower case, its words separated by one blank.
 */
void sc_plain_words(const char *name, char *to);
/* @return whether a word of @p words, which sc_plain_words has made, begins with @p beginning. */
bool sc_word_begins(const char *words, const char *beginning);

/* Write a job to begin with to @p out, and the name of its file, which is not there yet, to @p
 * path: that of --output, or one that follows from the volume. Both are empty before, and cleared
 * by the caller also after an error. @param measures comments tell how thick tissues are, for which
 * the volume is prepared. @return as the command. */
sc_status sc_init_write(struct sc_app *app, bool measures, sc_text *path, sc_text *out);

#endif
