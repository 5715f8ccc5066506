/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to store. */
#ifndef SC_STORE_INTERNAL_H
#define SC_STORE_INTERNAL_H

#include "segcast/store.h"

enum { SC_NAME_BYTES = 1024 };

/* ---- manifest.c: lines ---- */

/* What is known of a frame from a manifest. */
typedef struct sc_line {
    bool known;
    sc_done_frame done;
} sc_line;

typedef struct sc_head {
    bool known;
    char version[64];
    uint64_t job_hash, volume_hash;
    int frames, size_px[2];
} sc_head;

/* The end line. */
typedef struct sc_end {
    bool known;
    uint64_t video_bytes, video_hash;
} sc_end;

typedef struct sc_journal {
    sc_head head;
    sc_end end;
    sc_line *lines; /* [frames]; NULL: not wanted */
    int frames;
    int count; /* of lines that were read, doubled ones included */
} sc_journal;

/* Read one manifest into @p journal, whose lines have room. A torn tail, or all of a file that is
 * none, is not believed and no error. */
sc_status sc_journal_read(const sc_ctx *ctx, const char *path, sc_journal *journal);

typedef struct sc_manifest sc_manifest;
/* Write @p path anew with the head and the lines for which @p keep is set, appear by rename, and
 * stay open to be added to. */
sc_status sc_manifest_begin(const sc_ctx *ctx, const char *path, const sc_store_job *job,
                            const sc_line *lines, const bool *keep, sc_manifest **out);
sc_status sc_manifest_add(const sc_ctx *ctx, sc_manifest *manifest, const sc_done_frame *done);
sc_status sc_manifest_end(const sc_ctx *ctx, sc_manifest *manifest, const sc_store_job *job,
                          const sc_end *end);
/* To the disk. NULL is allowed. */
sc_status sc_manifest_sync(const sc_ctx *ctx, sc_manifest *manifest);
void sc_manifest_close(sc_manifest *manifest);

/* ---- parts.c: pictures of groups that are not whole yet ---- */

/* Where a picture lies. */
typedef struct sc_part_place {
    int file; /* index into sc_parts.files, or -1 */
    uint64_t offset, hash;
} sc_part_place;

/* Part files of a directory, and the one that is being written. */
typedef struct sc_parts {
    char directory[SC_NAME_BYTES];
    uint64_t identity;
    size_t picture_bytes;
    int frames;
    sc_part_place *places; /* [frames] */
    char **files;
    int file_count, file_capacity;
    FILE *stream;
    int stream_group, stream_file;
} sc_parts;

sc_status sc_parts_open(const sc_ctx *ctx, const char *directory, uint64_t identity,
                        size_t picture_bytes, int frames, sc_parts *out);
/* Believe what a file proves. */
sc_status sc_parts_scan(const sc_ctx *ctx, sc_parts *parts, const char *path);
sc_status sc_parts_add(const sc_ctx *ctx, sc_parts *parts, int group, int frame,
                       const void *picture, uint64_t hash);
/* Read a picture back, proving it. SC_ERR_DATA if it is gone. */
sc_status sc_parts_read(const sc_ctx *ctx, sc_parts *parts, int frame, void *picture);
/* What was written reaches the disk, and no file is open. */
sc_status sc_parts_sync(const sc_ctx *ctx, sc_parts *parts);
/* Remove the files of a group, and forget its pictures. */
void sc_parts_remove(sc_parts *parts, int group, int first, int count);
void sc_parts_forget(sc_parts *parts);
void sc_parts_close(sc_parts *parts);

/* ---- the store ---- */

struct sc_store {
    char directory[SC_NAME_BYTES];
    sc_store_job job;
    const char *slice;
    bool has_video, complete;
    uint64_t identity;
    int group, group_count; /* frames of a group of pictures, and how many there are */
    sc_journal journal;     /* of all processes */
    bool *wanted;           /* [frames]: of this process, and not done when it began */
    bool *png;              /* [frames]: proven */
    bool *segment;          /* [groups]: proven */
    sc_parts parts;
    sc_manifest *manifest;
    double synced_s;
    sc_encoder *encoder;
    int encoding;  /* the group in work, or -1 */
    void *picture; /* one, read back */
    sc_store_times times;
};

/* "DIR/NAME" with a formatted name. */
SC_PRINTF(3, 4)
void sc_store_path(const sc_store *store, char out[2 * SC_NAME_BYTES], const char *fmt, ...);
void sc_store_manifest_path(const sc_store *store, char out[2 * SC_NAME_BYTES]);
/* Frames of group @p g. */
int sc_store_group_frames(const sc_store *store, int g);
/* Is the picture of frame @p k kept, in a segment or a part? */
bool sc_store_has_picture(const sc_store *store, int k);

/* survey.c: look at everything on the disk, and believe only what it proves. */
sc_status sc_store_survey(const sc_ctx *ctx, sc_store *store);
/* Call @p each for the files of a directory in order of their names; none if it is not there. */
typedef sc_status sc_each_file_fn(const sc_ctx *ctx, void *user, const char *name);
sc_status sc_each_file(const sc_ctx *ctx, const char *directory, void *user, sc_each_file_fn *each);
bool sc_is_manifest_name(const char *name);
/* Does the whole file have these bytes? */
bool sc_file_is(const char *path, uint64_t bytes, uint64_t hash);
/* Prove the PNG files of frames with known hashes, on all threads. */
void sc_prove_frames(const char *directory, const sc_line *lines, int frames, int threads,
                     bool *out);

/* encode.c: pictures to segments, segments to the video. */
/* Have an encoder; nothing happens if there is one. */
sc_status sc_store_open_encoder(const sc_ctx *ctx, sc_store *store);
sc_status sc_store_encode(const sc_ctx *ctx, sc_store *store, int frame, const void *picture);
/* Encode the groups of which all pictures are in parts. */
sc_status sc_store_encode_parts(const sc_ctx *ctx, sc_store *store);
/* Join the first @p groups segments to @p path. */
sc_status sc_store_join(const sc_ctx *ctx, sc_store *store, const char *path, int groups);
sc_status sc_store_publish_segment(const sc_ctx *ctx, sc_store *store, int group,
                                   const sc_segment *segment);

#endif
