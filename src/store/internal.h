/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to store. The public functions are in store.c, finish.c and verify.c. They and the files
 * named below call only functions of files that are named further down in this header. */
#ifndef SC_STORE_INTERNAL_H
#define SC_STORE_INTERNAL_H

#include "segcast/store.h"

enum { SC_NAME_BYTES = 1024 };

/* The line of a frame in a manifest. */
typedef struct sc_frame_line {
    bool known; /* false: there is none */
    sc_done_frame done;
} sc_frame_line;

/* The first line of a manifest: which job it belongs to. */
typedef struct sc_manifest_head {
    bool known;
    char version[64];
    uint64_t job_hash, volume_hash;
    int frames, size_px[2];
} sc_manifest_head;

/* The last line in the manifest of a finished job. */
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
    int count; /* number of lines of frames that were read; a frame may have several */
} sc_manifest_data;

typedef struct sc_manifest_writer sc_manifest_writer;

/* Where the picture of a frame lies in the files of partial GOPs. */
typedef struct sc_picture_location {
    int file;        /* index into sc_partial_gops.files; -1: it is in none */
    uint64_t offset; /* of its head in the file */
    uint64_t hash;   /* of the frame's pixels */
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
    FILE *stream;    /* the file that is being written, or NULL */
    int stream_gop;  /* its GOP */
    int stream_file; /* its index in files */
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
    bool *wanted;          /* [frames]: this process is still to accept the frame */
    bool *has_png;         /* [frames]: the PNG file is verified */
    bool *has_segment;     /* [gop_count]: the segment is verified */
    sc_partial_gops partial;
    sc_manifest_writer *manifest;
    double synced_s; /* when the manifest was last flushed to disk */
    sc_encoder *encoder;
    int encoding;  /* the GOP that was begun in the encoder, or -1 */
    void *picture; /* buffer for a picture that is read back from a partial GOP */
    sc_store_times times;
};

/* ---- encode.c: pictures to segments, segments to the video ---- */

/* Open store->encoder, unless it is open. */
sc_status sc_store_open_encoder(const sc_ctx *ctx, sc_store *store);
/* Encode @p picture, that of frame @p frame, and the pictures after it that are there; with the
 * last one of the GOP, write its segment. The picture must have been added to a partial GOP before.
 * Nothing is encoded while a picture before it is missing, nor if another process has to deliver
 * some of the GOP: then the picture only stays in the partial GOP. */
sc_status sc_store_encode(const sc_ctx *ctx, sc_store *store, int frame, const void *picture);
/* Encode the GOPs that have no segment, and of which all pictures are in partial GOPs. */
sc_status sc_store_encode_partial(const sc_ctx *ctx, sc_store *store);
/* Write the segment of GOP @p gop, and remove its partial GOPs. */
sc_status sc_store_write_segment(const sc_ctx *ctx, sc_store *store, int gop,
                                 const sc_segment *segment);
/* Join the first @p gops segments, which must be there, to the video @p path. */
sc_status sc_store_join(const sc_ctx *ctx, sc_store *store, const char *path, int gops);

/* ---- scan.c: reading and verifying what is in the directory ---- */

/* Read and verify all manifests, segments, partial GOPs and PNG files; sets data, has_segment,
 * has_png, partial and complete. @return SC_ERR_CREATE if a manifest belongs to another job. */
sc_status sc_store_scan(const sc_ctx *ctx, sc_store *store);

/* ---- remove.c: removing files from the directory ---- */

/* Remove everything that runs of segcast write, except job.yaml and the statistics. */
sc_status sc_store_remove_run(const sc_ctx *ctx, sc_store *store);
/* Remove all segments and partial GOPs, and their folder. */
void sc_store_remove_segments(const sc_ctx *ctx, sc_store *store);
void sc_store_remove_partial_video(const sc_ctx *ctx, const sc_store *store);
/* Remove the manifests of slices, but not that of the whole job. */
sc_status sc_store_remove_slices(const sc_ctx *ctx, sc_store *store);

/* ---- state.c: what the store knows ---- */

/* The number of frames of GOP @p gop; the last one may be shorter. */
int sc_store_gop_frames(const sc_store *store, int gop);
/* @return whether the picture of frame @p k is in a segment or a partial GOP. */
bool sc_store_has_picture(const sc_store *store, int k);

/* ---- outputs.c: verifying finished files against the manifest ---- */

/* Decode the PNG files of the frames that have a line, on @p threads threads.
 * @param out [frames]: whether the file is there and its pixels have the hash that the line names.
 */
void sc_verify_png_files(const char *directory, const sc_frame_line *lines, int frames, int threads,
                         bool *out);
/* @return true if the file has the given size and hash. */
bool sc_verify_file(const char *path, uint64_t bytes, uint64_t hash);

/* ---- partial_gops.c: pictures of GOPs that are not whole yet ---- */

/* Begin without any files. @param directory that of the segments. @param picture_bytes as of
 * sc_picture_bytes. Caller owns *out: sc_partial_close. */
sc_status sc_partial_open(const sc_ctx *ctx, const char *directory, uint64_t identity,
                          size_t picture_bytes, int frames, sc_partial_gops *out);
/* Find the pictures in the file @p path, up to the first that is damaged or of another job, and
 * note their locations. */
sc_status sc_partial_scan(const sc_ctx *ctx, sc_partial_gops *partial, const char *path);
/* Append the picture of a frame of GOP @p gop to this process's file of that GOP, and note its
 * location. @param hash that of the frame's pixels. */
sc_status sc_partial_add(const sc_ctx *ctx, sc_partial_gops *partial, int gop, int frame,
                         const void *picture, uint64_t hash);
/* Read the picture of a frame, which must have a location, back into @p picture, and verify it.
 * @return SC_ERR_DATA if it is damaged or gone. */
sc_status sc_partial_read(const sc_ctx *ctx, const sc_partial_gops *partial, int frame,
                          void *picture);
/* Flush the file that is being written to disk and close it. */
sc_status sc_partial_sync(const sc_ctx *ctx, sc_partial_gops *partial);
/* Remove all files of GOP @p gop, whose @p count frames begin with @p first, and their locations.
 */
void sc_partial_remove(sc_partial_gops *partial, int gop, int first, int count);
/* Forget all files and locations; the files stay on disk. */
void sc_partial_forget(sc_partial_gops *partial);
void sc_partial_close(sc_partial_gops *partial);

/* ---- manifest.c: reading and writing lines ---- */

/* Read one manifest: its head replaces data->head, its lines are added to those of manifests read
 * before. Reading ends, without an error, at the first line that is truncated or not of a manifest;
 * head.known is false if that is the first line. */
sc_status sc_manifest_read(const sc_ctx *ctx, const char *path, sc_manifest_data *data);
/* Write a new manifest @p path, with a head and the lines of those frames k for which keep[k] is
 * set; it replaces an older one in one step. It stays open for more lines. Caller owns *out:
 * sc_manifest_close. */
sc_status sc_manifest_create(const sc_ctx *ctx, const char *path, const sc_store_job *job,
                             const sc_frame_line *lines, const bool *keep,
                             sc_manifest_writer **out);
/* Append the line of a frame; it is on disk after sc_manifest_sync. */
sc_status sc_manifest_add_frame(const sc_ctx *ctx, sc_manifest_writer *manifest,
                                const sc_done_frame *done);
/* Append the line that ends the manifest of a finished job. */
sc_status sc_manifest_add_end(const sc_ctx *ctx, sc_manifest_writer *manifest,
                              const sc_store_job *job, const sc_manifest_end *end);
/* Flush the lines to disk (fsync). NULL is allowed. */
sc_status sc_manifest_sync(const sc_ctx *ctx, sc_manifest_writer *manifest);
void sc_manifest_close(sc_manifest_writer *manifest);

/* ---- files.c: names in the directory ---- */

/* Make "DIR/NAME" in @p out; the arguments format NAME. */
SC_PRINTF(3, 4)
void sc_store_path(const sc_store *store, char out[2 * SC_NAME_BYTES], const char *fmt, ...);
/* Make the path of this process's manifest: that of the slice, or that of the whole job. */
void sc_store_manifest_path(const sc_store *store, char out[2 * SC_NAME_BYTES]);
/* @return whether a file of that name is the manifest of a job or of a slice. */
bool sc_is_manifest_name(const char *name);
typedef sc_status sc_each_file_fn(const sc_ctx *ctx, void *user, const char *name);
/* Call @p each with the name of each file of a directory, in the order of names, except hidden
 * files. The first error ends this and is returned. A directory that does not exist has no files.
 */
sc_status sc_each_file(const sc_ctx *ctx, const char *directory, void *user, sc_each_file_fn *each);

#endif
