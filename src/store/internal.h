/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to store. The public functions are in store.c, finish.c and verify.c; they and the files
 * below call only functions of files that stand further down in this header. */
#ifndef SC_STORE_INTERNAL_H
#define SC_STORE_INTERNAL_H

#include "segcast/store.h"

enum { SC_NAME_BYTES = 1024 };

/* What the manifest has of a frame. */
typedef struct sc_frame_line {
    bool known;
    sc_done_frame done;
} sc_frame_line;

/* The first line. */
typedef struct sc_manifest_head {
    bool known;
    char version[64];
    uint64_t job_hash, volume_hash;
    int frames, size_px[2];
} sc_manifest_head;

/* The last line of a finished job. */
typedef struct sc_manifest_end {
    bool known;
    uint64_t video_bytes, video_hash;
} sc_manifest_end;

/* The content of one or several manifests. */
typedef struct sc_manifest_data {
    sc_manifest_head head;
    sc_manifest_end end;
    sc_frame_line *lines; /* [frames], or NULL to count the lines only */
    int frames;
    int count; /* of the lines of frames that were read; a frame may have several */
} sc_manifest_data;

typedef struct sc_manifest_writer sc_manifest_writer;

/* Where the picture of a frame stands in the files of partial GOPs. */
typedef struct sc_picture_location {
    int file; /* index into sc_partial_gops.files, or -1: nowhere */
    uint64_t offset;
    uint64_t hash; /* of the frame's pixels */
} sc_picture_location;

/* The files of partial GOPs in a directory, and the one that is being written. */
typedef struct sc_partial_gops {
    char directory[SC_NAME_BYTES];
    uint64_t identity;
    size_t picture_bytes;
    int frames;
    sc_picture_location *locations; /* [frames] */
    char **files;                   /* [file_count], paths */
    int file_count, file_capacity;
    FILE *stream; /* of the file that is being written, or NULL */
    int stream_gop, stream_file;
} sc_partial_gops;

struct sc_store {
    char directory[SC_NAME_BYTES];
    sc_store_job job;
    const char *slice; /* NULL: this process does the whole job */
    bool has_video;
    bool complete; /* the job is finished and verified */
    uint64_t identity;
    int gop_frames, gop_count;
    sc_manifest_data data; /* of all manifests in the directory */
    bool *wanted;          /* [frames]: to be accepted by this process */
    bool *has_png;         /* [frames]: the PNG file is verified */
    bool *has_segment;     /* [gop_count]: the segment is verified */
    sc_partial_gops partial;
    sc_manifest_writer *manifest;
    double synced_s; /* when the manifest was last flushed to disk */
    sc_encoder *encoder;
    int encoding;  /* the GOP that the encoder works on, or -1 */
    void *picture; /* buffer for a picture that is read back */
    sc_store_times times;
};

/* ---- encode.c: pictures to segments, segments to the video ---- */

/* Open the encoder unless it is open. */
sc_status sc_store_open_encoder(const sc_ctx *ctx, sc_store *store);
/* Encode @p picture of frame @p frame, which is in a partial GOP already, and what follows it
 * there. It stays in the partial GOP only, if pictures before it or after it will come from
 * elsewhere. */
sc_status sc_store_encode(const sc_ctx *ctx, sc_store *store, int frame, const void *picture);
/* Encode the GOPs of which all pictures are in partial GOPs. */
sc_status sc_store_encode_partial(const sc_ctx *ctx, sc_store *store);
/* Write the segment of GOP @p gop, and remove its partial GOPs. */
sc_status sc_store_write_segment(const sc_ctx *ctx, sc_store *store, int gop,
                                 const sc_segment *segment);
/* Join the first @p gops segments to the video @p path. */
sc_status sc_store_join(const sc_ctx *ctx, sc_store *store, const char *path, int gops);

/* ---- scan.c: what is in the directory, verified ---- */

/* Read and verify all manifests, segments, partial GOPs and PNG files; sets data, has_segment,
 * has_png, partial and complete. @return SC_ERR_CREATE if a manifest belongs to another job. */
sc_status sc_store_scan(const sc_ctx *ctx, sc_store *store);

/* ---- remove.c: what is removed from the directory ---- */

/* Everything that runs of segcast write, except job.yaml and statistics. */
sc_status sc_store_remove_run(const sc_ctx *ctx, sc_store *store);
void sc_store_remove_segments(const sc_ctx *ctx, sc_store *store);
void sc_store_remove_partial_video(const sc_ctx *ctx, const sc_store *store);
/* The manifests of slices. */
sc_status sc_store_remove_slices(const sc_ctx *ctx, sc_store *store);

/* ---- state.c: what the store knows ---- */

/* The number of frames of GOP @p gop; the last one may be shorter. */
int sc_store_gop_frames(const sc_store *store, int gop);
/* Is the picture of frame @p k in a segment or a partial GOP? */
bool sc_store_has_picture(const sc_store *store, int k);

/* ---- outputs.c: are finished files what the manifest says? ---- */

/* Decode the PNG files of the frames that have a line, on @p threads threads.
 * @param out [frames], whether the pixels have the hash that the line names. */
void sc_verify_png_files(const char *directory, const sc_frame_line *lines, int frames, int threads,
                         bool *out);
/* @return true if the file has the given size and hash. */
bool sc_verify_file(const char *path, uint64_t bytes, uint64_t hash);

/* ---- partial_gops.c: pictures of GOPs that are not whole yet ---- */

sc_status sc_partial_open(const sc_ctx *ctx, const char *directory, uint64_t identity,
                          size_t picture_bytes, int frames, sc_partial_gops *out);
/* Find the pictures in the file @p path, up to the first that is damaged or of another job. */
sc_status sc_partial_scan(const sc_ctx *ctx, sc_partial_gops *partial, const char *path);
/* Append a picture of GOP @p gop to the file of this process. @p hash: of the frame's pixels. */
sc_status sc_partial_add(const sc_ctx *ctx, sc_partial_gops *partial, int gop, int frame,
                         const void *picture, uint64_t hash);
/* Read a picture back and verify it. @return SC_ERR_DATA if it is damaged or gone. */
sc_status sc_partial_read(const sc_ctx *ctx, const sc_partial_gops *partial, int frame,
                          void *picture);
/* Flush the file that is being written to disk and close it. */
sc_status sc_partial_sync(const sc_ctx *ctx, sc_partial_gops *partial);
/* Remove the files of GOP @p gop, whose frames are @p first to @p first + @p count - 1. */
void sc_partial_remove(sc_partial_gops *partial, int gop, int first, int count);
/* Forget all files that were scanned or written. */
void sc_partial_forget(sc_partial_gops *partial);
void sc_partial_close(sc_partial_gops *partial);

/* ---- manifest.c: lines ---- */

/* Read one manifest into @p data, to what earlier ones gave. Reading ends, without an error, at the
 * first line that is truncated or not of a manifest; head.known is false if that is the first. */
sc_status sc_manifest_read(const sc_ctx *ctx, const char *path, sc_manifest_data *data);
/* Write @p path anew, with the head and the lines k for which keep[k] is set, so that it appears
 * complete, and keep it open for more lines. */
sc_status sc_manifest_create(const sc_ctx *ctx, const char *path, const sc_store_job *job,
                             const sc_frame_line *lines, const bool *keep,
                             sc_manifest_writer **out);
sc_status sc_manifest_add_frame(const sc_ctx *ctx, sc_manifest_writer *manifest,
                                const sc_done_frame *done);
sc_status sc_manifest_add_end(const sc_ctx *ctx, sc_manifest_writer *manifest,
                              const sc_store_job *job, const sc_manifest_end *end);
/* Flush to disk. NULL is allowed. */
sc_status sc_manifest_sync(const sc_ctx *ctx, sc_manifest_writer *manifest);
void sc_manifest_close(sc_manifest_writer *manifest);

/* ---- files.c: names in the directory ---- */

/* "DIR/NAME", with a formatted name. */
SC_PRINTF(3, 4)
void sc_store_path(const sc_store *store, char out[2 * SC_NAME_BYTES], const char *fmt, ...);
/* The manifest of this process: of the slice, or of the whole job. */
void sc_store_manifest_path(const sc_store *store, char out[2 * SC_NAME_BYTES]);
bool sc_is_manifest_name(const char *name);
typedef sc_status sc_each_file_fn(const sc_ctx *ctx, void *user, const char *name);
/* Call @p each for the files of a directory in order of their names, hidden files excepted, until
 * one call fails. A directory that does not exist has no files. */
sc_status sc_each_file(const sc_ctx *ctx, const char *directory, void *user, sc_each_file_fn *each);

#endif
