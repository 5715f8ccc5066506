/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  What of a job is done, on disk, so that it can go on after any accident. Rank 0 only.
 *
 *  DIR/manifest.jsonl    a head, a line for each finished frame, an end line when all is there
 *  DIR/manifest.S.jsonl  the same of slice S, of several processes that share a directory
 *  DIR/segments/         while the job lasts: NNNNNN.seg, encoded groups of pictures, and
 *                        NNNNNN.HOST.PID.part, pictures of groups that are not whole yet
 *  DIR/frames/NNNNNN.png where asked for, and the video, when all is there
 *
 *  Nothing is locked. Names are unique while a file is written, and equal names hold equal bytes.
 *  Nothing on disk is believed: segments and parts carry a hash of themselves and the identity of
 *  the job, frames are decoded and hashed. */
#ifndef SEGCAST_STORE_H
#define SEGCAST_STORE_H

#include "segcast/video.h"

typedef struct sc_store sc_store;

/** What a directory belongs to. Strings are borrowed for the store's life. */
typedef struct sc_store_job {
    const char *version;
    uint64_t job_hash, volume_hash;
    int frames;        /**< of the whole animation */
    const char *video; /**< name of the file in the directory, or "none" */
    bool png;          /**< frames as PNG, too */
    sc_video_settings settings;
    int threads; /**< for proving */
} sc_store_job;

typedef enum sc_store_mode {
    SC_STORE_NEW,      /**< refuse a directory that holds a run */
    SC_STORE_RESUME,   /**< go on with what is proven; a directory without a run is begun */
    SC_STORE_OVERWRITE /**< remove what an earlier run left */
} sc_store_mode;

/** A finished frame. */
typedef struct sc_done_frame {
    int frame, rank;
    double render_cpu_s;
    uint64_t hash; /**< sc_image_hash */
} sc_done_frame;

/** Would sc_store_open refuse @p directory to a new run? To be asked before anything costs time.
 *  @return SC_ERR_CREATE. */
SC_MUST_USE sc_status sc_store_check_new(const sc_ctx *ctx, const char *directory,
                                         const char *slice);
/** Open @p directory, which is made if need be, for the frames @p wanted, in rising order.
 *  @param slice NULL, or the name of the part of the job that this process does beside others.
 *  @return SC_ERR_CREATE if the directory holds another job, or a run and @p mode is new;
 *  SC_ERR_WRITE, SC_ERR_MISSING. Caller owns: sc_store_close. */
SC_MUST_USE sc_status sc_store_open(const sc_ctx *ctx, const char *directory,
                                    const sc_store_job *job, const int *wanted, int wanted_count,
                                    const char *slice, sc_store_mode mode, sc_store **out);
/** Close; what was not finished is left to be gone on with. NULL is allowed. */
void sc_store_close(sc_store *store);

/** Is frame @p k done, and proven? */
bool sc_store_has(const sc_store *store, int k);
/** Was the whole job finished already, and is proven? */
bool sc_store_is_complete(const sc_store *store);
/** What ranks that encode have to put into their segments. */
uint64_t sc_store_identity(const sc_store *store);
/** The groups of pictures that are to be drawn whole, so that any rank may encode them: numbers of
 *  their first frames. Caller owns *out: sc_free. */
SC_MUST_USE sc_status sc_store_whole_groups(const sc_ctx *ctx, const sc_store *store, int **out,
                                            int *count);

/** Take a frame that was wanted. In rising order within a group of pictures. Threads: one call at a
 *  time. @return SC_ERR_WRITE, SC_ERR_CREATE. */
SC_MUST_USE sc_status sc_store_take(const sc_ctx *ctx, sc_store *store, const sc_done_frame *done,
                                    const sc_image *image);
/** Take a whole group that a rank has encoded. @p png: the frames' files, or NULL where none are
 *  asked for. @return SC_ERR_INTERNAL if the segment is not of this job, or as sc_store_take. */
SC_MUST_USE sc_status sc_store_take_group(const sc_ctx *ctx, sc_store *store,
                                          const sc_done_frame *done, int count,
                                          const sc_segment *segment, const sc_segment *png);
/** Seconds of the calling threads so far: in encoding, and in writing. */
typedef struct sc_store_times {
    double encode_wall_s, write_wall_s;
} sc_store_times;
sc_store_times sc_store_time(const sc_store *store);

/** All that was taken reaches the disk. If with what other processes did every frame is there, the
 *  video is made and the job is complete; else what is there from the beginning on becomes
 *  NAME.partial.mp4 (not for slices). @param missing frames that are not there.
 *  @return SC_ERR_WRITE, SC_ERR_CREATE. */
SC_MUST_USE sc_status sc_store_finish(const sc_ctx *ctx, sc_store *store, int *missing);

/** Read what a directory belongs to: hashes, frames and version of @p job; the rest stays.
 *  @p version: room for at least 64 bytes. @return SC_ERR_MISSING. */
SC_MUST_USE sc_status sc_store_identify(const sc_ctx *ctx, const char *directory, sc_store_job *job,
                                        char *version);
/** Prove a finished directory: every frame of the manifest once, every PNG decoded and hashed, the
 *  video's bytes hashed, and its frames decoded and counted. @return SC_ERR_INCOMPLETE if the job
 *  is not finished, SC_ERR_DATA naming the first thing that is wrong. */
SC_MUST_USE sc_status sc_store_verify(const sc_ctx *ctx, const char *directory,
                                      const sc_store_job *job);

#endif
