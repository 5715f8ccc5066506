/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to store. The public functions are in store.c, finish.c and verify.c. They and the files
 * named below call only functions of files that are named further down in this header. */
#ifndef SC_STORE_INTERNAL_H
#define SC_STORE_INTERNAL_H

#include "segcast/store.h"

enum { SC_NAME_BYTES = 1024 }; /* room for the path of the directory; twice that: of its files */

/* The line of a frame in a manifest. */
typedef struct sc_frame_line {
    bool known; /* there is a line; otherwise `done` means nothing */
    sc_done_frame done;
} sc_frame_line;

/* The first line of a manifest: what sc_store_job has under the same names. */
typedef struct sc_manifest_head {
    bool known; /* the line was there; otherwise the rest is zero */
    char version[64];
    uint64_t job_hash, volume_hash;
    int frames, size_px[2]; /* width and height */
} sc_manifest_head;

/* The last line in the manifest of a finished job. */
typedef struct sc_manifest_end {
    bool known;
    uint64_t video_bytes, video_hash; /* size and sc_hash_bytes of the video; 0 without one */
    char video[256];                  /* name of the video; empty without one */
} sc_manifest_end;

/* The content of one or several manifests. */
typedef struct sc_manifest_data {
    sc_manifest_head head; /* of the manifest that was read last */
    sc_manifest_end end;   /* of any of them */
    sc_frame_line *lines;  /* [frames], allocated and freed by the caller, or NULL to count only */
    int frames;            /* set by the caller */
    int count;             /* of the lines of frames that were read; a frame may have several */
} sc_manifest_data;

/* A manifest that is open, so that lines can be appended. */
typedef struct sc_manifest_writer sc_manifest_writer;

/* Where the picture of a frame lies in the files of partial GOPs. */
typedef struct sc_picture_location {
    int file;        /* index into sc_partial_gops.files, or -1: nowhere */
    uint64_t offset; /* of the picture's head in the file, in bytes */
    uint64_t hash;   /* sc_image_hash of the frame */
} sc_picture_location;

/* The files of partial GOPs in a directory, and the one that is being written. */
typedef struct sc_partial_gops {
    char directory[SC_NAME_BYTES]; /* that of the segments */
    uint64_t identity;             /* of the job: pictures of another one are ignored */
    size_t picture_bytes;          /* sc_picture_bytes: the same for all pictures */
    int frames;
    sc_picture_location *locations; /* [frames], owned */
    char **files;                   /* [file_count], paths, owned; one may stand there twice */
    int file_count, file_capacity;
    FILE *stream;                /* of the file that is being written, or NULL */
    int stream_gop, stream_file; /* the GOP of that file, and its index in `files` */
} sc_partial_gops;

struct sc_store {
    char directory[SC_NAME_BYTES];
    sc_store_job job;
    const char *slice;         /* NULL: this process does the whole job */
    bool has_video;            /* job.video is not "none"; without one there are no segments */
    bool complete;             /* the job is finished and verified */
    uint64_t identity;         /* hash of job_hash, volume_hash, frames and version */
    int gop_frames, gop_count; /* length of a GOP, but for the last one, and number of GOPs */
    sc_manifest_data data;     /* of all manifests in the directory, kept up to date; owns lines */
    bool *wanted;              /* [frames]: not there when opened, and this process accepts it */
    bool *has_png;             /* [frames]: the PNG file is verified, or was written here */
    bool *has_segment;         /* [gop_count]: the segment is verified, or was written here */
    sc_partial_gops partial;
    sc_manifest_writer *manifest; /* of this process; NULL: complete, or nothing wanted */
    double synced_s;              /* when the manifest was last flushed to disk, by sc_wall_s */
    sc_encoder *encoder;          /* NULL until sc_store_open_encoder */
    int encoding;                 /* the GOP that the encoder works on, or -1 */
    void *picture;                /* buffer of sc_picture_bytes for a picture that is read back */
    sc_store_times times;
};

/* ---- encode.c: pictures to segments, segments to the video ---- */

/* Open store->encoder unless it is open. Only in a job with video. @return as sc_encoder_open. */
sc_status sc_store_open_encoder(const sc_ctx *ctx, sc_store *store);
/* Encode @p picture of frame @p frame, which the caller has put into a partial GOP, and the
 * pictures that follow it there; when the GOP is whole, write its segment. Nothing is encoded while
 * a picture before it is missing, nor if another process has to deliver some of the GOP; that is no
 * error. A GOP that the encoder had begun before is dropped; its pictures are in partial GOPs. */
sc_status sc_store_encode(const sc_ctx *ctx, sc_store *store, int frame, const void *picture);
/* Encode the GOPs without a segment of which all pictures are in partial GOPs, and write their
 * segments. Reads the pictures back from disk. */
sc_status sc_store_encode_partial(const sc_ctx *ctx, sc_store *store);
/* Write the segment of GOP @p gop, set has_segment, remove its partial GOPs, and flush the
 * manifest. */
sc_status sc_store_write_segment(const sc_ctx *ctx, sc_store *store, int gop,
                                 const sc_segment *segment);
/* Join the segments of the GOPs [0, gops), at least one, to the video @p path.
 * @return SC_ERR_MISSING if a segment is gone, or as the muxer. */
sc_status sc_store_join(const sc_ctx *ctx, sc_store *store, const char *path, int gops);

/* ---- scan.c: reading and verifying what is in the directory ---- */

/* Read and verify all manifests, segments, partial GOPs and PNG files; sets data, has_segment,
 * has_png, partial and complete, whatever they held before. Warns of damaged segments and of a
 * video that is not the one of the manifest. @return SC_ERR_CREATE if a manifest belongs to another
 * job. */
sc_status sc_store_scan(const sc_ctx *ctx, sc_store *store);

/* ---- remove.c: what is removed from the directory. A file that is not there, or that cannot be
 * removed, is no error. The state of the store is left as it is. ---- */

/* Remove everything that runs of segcast write, except job.yaml and statistics. @return an error if
 * a directory cannot be listed. */
sc_status sc_store_remove_run(const sc_ctx *ctx, sc_store *store);
/* Remove the segments, partial GOPs and temporary files of segments/, whichever slice wrote them,
 * and the folder if it is empty then. Failures are ignored. */
void sc_store_remove_segments(const sc_ctx *ctx, sc_store *store);
/* Remove the video of an unfinished run, sc_video_partial_name. */
void sc_store_remove_partial_video(const sc_ctx *ctx, const sc_store *store);
/* Remove the manifests of slices, not that of the whole job. */
sc_status sc_store_remove_slices(const sc_ctx *ctx, sc_store *store);

/* ---- state.c: what the store knows ---- */

/* @return the number of frames of GOP @p gop; the last one may be shorter. */
int sc_store_gop_frames(const sc_store *store, int gop);
/* @return whether the picture of frame @p k is in a segment or a partial GOP, as the last scan and
 * what was accepted since have it. */
bool sc_store_has_picture(const sc_store *store, int k);

/* ---- outputs.c: verifying finished files against the manifest ---- */

/* Decode the PNG files of the frames that have one of the @p lines [frames], on @p threads threads.
 * @param out [frames], set to whether the pixels have the hash that the line names: false without a
 * line or a file. Prints no messages. */
void sc_verify_png_files(const char *directory, const sc_frame_line *lines, int frames, int threads,
                         bool *out);
/* @return true if the file has the given size and hash (sc_hash_bytes); false, without a message,
 * if it has not or cannot be read. Reads the whole file if the size is right. */
bool sc_verify_file(const char *path, uint64_t bytes, uint64_t hash);

/* ---- partial_gops.c: pictures of GOPs that are not whole yet ---- */

/* Begin with no files and no pictures. @param directory that of the segments, copied.
 * @param picture_bytes as of sc_picture_bytes. @return SC_ERR_MEMORY. Caller owns *out:
 * sc_partial_close. */
sc_status sc_partial_open(const sc_ctx *ctx, const char *directory, uint64_t identity,
                          size_t picture_bytes, int frames, sc_partial_gops *out);
/* Set the locations of the pictures in the file @p path, up to the first that is damaged or of
 * another job. A frame that is found again gets the new location. A file that cannot be opened has
 * none. @return SC_ERR_MEMORY. */
sc_status sc_partial_scan(const sc_ctx *ctx, sc_partial_gops *partial, const char *path);
/* Append a picture of GOP @p gop to this process's file for it, which is made if need be, and set
 * its location. @p hash: sc_image_hash of the frame. @return SC_ERR_CREATE, SC_ERR_WRITE,
 * SC_ERR_MEMORY. */
sc_status sc_partial_add(const sc_ctx *ctx, sc_partial_gops *partial, int gop, int frame,
                         const void *picture, uint64_t hash);
/* Read the picture of a frame that has a location into @p picture, which has room for
 * picture_bytes, and verify it. @return SC_ERR_DATA if it is damaged or gone. */
sc_status sc_partial_read(const sc_ctx *ctx, const sc_partial_gops *partial, int frame,
                          void *picture);
/* Flush the file that is being written to disk and close it, also after an error. Does nothing if
 * there is none. @return SC_ERR_WRITE. */
sc_status sc_partial_sync(const sc_ctx *ctx, sc_partial_gops *partial);
/* Remove the files of GOP @p gop that were scanned or written, whichever process wrote them, and
 * the locations of its frames, [first, first + count). */
void sc_partial_remove(sc_partial_gops *partial, int gop, int first, int count);
/* Clear the list of files and all locations; the files stay on disk. No file is being written then:
 * sc_partial_sync before. */
void sc_partial_forget(sc_partial_gops *partial);
/* Close the file that is being written, without flushing it to disk, and free everything. All zero
 * is allowed. */
void sc_partial_close(sc_partial_gops *partial);

/* ---- manifest.c: lines. All that write return SC_ERR_WRITE, or SC_ERR_MEMORY. ---- */

/* Read one manifest into @p data: `head` is replaced, lines and count are added to what earlier
 * ones gave (a later line of a frame wins), and so is `end` if there is an end line. Reading ends,
 * without an error, at the first line that is truncated, not of a manifest, or of a frame beyond
 * data->frames; head.known is false if that is the first. @return SC_ERR_MISSING, SC_ERR_DATA if
 * the file is too large, SC_ERR_MEMORY. */
sc_status sc_manifest_read(const sc_ctx *ctx, const char *path, sc_manifest_data *data);
/* Write a new manifest @p path, with a head and the lines of those frames k for which keep[k] is
 * set; it replaces an older one in one step, and stays open for more lines. @param lines
 * [job->frames], with @p keep, or NULL for the head alone. @return SC_ERR_CREATE, too. Caller owns
 * *out: sc_manifest_close. */
sc_status sc_manifest_create(const sc_ctx *ctx, const char *path, const sc_store_job *job,
                             const sc_frame_line *lines, const bool *keep,
                             sc_manifest_writer **out);
/* Append the line of a frame; it is with the system then, but not yet flushed to disk. */
sc_status sc_manifest_add_frame(const sc_ctx *ctx, sc_manifest_writer *manifest,
                                const sc_done_frame *done);
/* Append the end line, in the same way. A job without a video has neither its size nor its hash. */
sc_status sc_manifest_add_end(const sc_ctx *ctx, sc_manifest_writer *manifest,
                              const sc_store_job *job, const sc_manifest_end *end);
/* Flush to disk; blocks until it is there. NULL is allowed. */
sc_status sc_manifest_sync(const sc_ctx *ctx, sc_manifest_writer *manifest);
/* Close and free, without flushing to disk. NULL is allowed. */
void sc_manifest_close(sc_manifest_writer *manifest);

/* ---- files.c: names in the directory ---- */

/* Write "DIR/NAME", with a formatted name, into @p out; what is too long is cut off. */
SC_PRINTF(3, 4)
void sc_store_path(const sc_store *store, char out[2 * SC_NAME_BYTES], const char *fmt, ...);
/* Write the path of this process's manifest into @p out: that of the slice, or of the whole job. */
void sc_store_manifest_path(const sc_store *store, char out[2 * SC_NAME_BYTES]);
/* @return whether @p name, without directory, is "manifest.jsonl" or "manifest.S.jsonl" with a
 * non-empty S. */
bool sc_is_manifest_name(const char *name);
/* Receives the @p name, without directory, of one entry of a directory, borrowed for the call. */
typedef sc_status sc_each_file_fn(const sc_ctx *ctx, void *user, const char *name);
/* Call @p each with @p user for the entries of a directory (folders are entries, too) in order of
 * their names, hidden ones excepted, until one call fails. The names are listed before the first
 * call: a file may be gone when its turn comes. A directory that does not exist has no entries.
 * @return the error of the call that failed, or SC_ERR_MISSING if it cannot be listed. */
sc_status sc_each_file(const sc_ctx *ctx, const char *directory, void *user, sc_each_file_fn *each);

#endif
