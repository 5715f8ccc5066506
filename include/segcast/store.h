/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  What of a job is done, kept on disk so that a run can continue after any accident. Used by rank
 * 0 only; functions are local (not collective), one call at a time per store.
 *
 *  DIR/manifest.jsonl    a head, one line for each finished frame, an end line when all are there
 *  DIR/manifest.S.jsonl  the same for slice S, where several processes share a directory
 *  DIR/segments/         until the job is complete: NNNNNN.seg, GOP number NNNNNN encoded, and
 *                        NNNNNN.HOST.PID.part, pictures of a partial GOP
 *  DIR/frames/NNNNNN.png the frames as PNG files, where asked for
 *  DIR/VIDEO             when every frame is there
 *
 *  There are no locks: a file has a unique name while it is written, and two processes that write a
 *  file of the same name write the same bytes. Everything read from disk is verified: segments and
 *  partial GOPs hold a hash of themselves and the identity of the job, PNG files are decoded and
 *  their pixels hashed. What fails is drawn again. */
#ifndef SEGCAST_STORE_H
#define SEGCAST_STORE_H

#include "segcast/video.h"

/** The directory of a job, opened by one process. */
typedef struct sc_store sc_store;

/** The job that a directory belongs to. Strings are borrowed for the life of the store. */
typedef struct sc_store_job {
    const char *version;            /**< version of segcast: another one may draw other pixels */
    uint64_t job_hash, volume_hash; /**< hashes of all that determines pictures and encoding */
    int frames;                     /**< number of frames of the whole animation */
    const char *video;              /**< name of the video in the directory, or "none" */
    bool png;                       /**< write the frames as PNG files, too */
    sc_video_settings settings;
    int threads; /**< number of threads that verify PNG files */
} sc_store_job;

/** What sc_store_open does with a directory that holds a run. */
typedef enum sc_store_mode {
    SC_STORE_NEW,      /**< refuse it */
    SC_STORE_RESUME,   /**< continue the run (or begin one, if there is none) */
    SC_STORE_OVERWRITE /**< remove what the run has left, and begin anew */
} sc_store_mode;

/** A finished frame: what its line in the manifest holds. */
typedef struct sc_done_frame {
    int frame, rank;
    double render_cpu_s;
    uint64_t hash; /**< sc_image_hash */
} sc_done_frame;

/** Check whether sc_store_open would refuse @p directory to a new run, before anything costs time.
 *  @param slice as for sc_store_open. @return SC_ERR_CREATE if so. */
SC_MUST_USE sc_status sc_store_check_new(const sc_ctx *ctx, const char *directory,
                                         const char *slice);
/** Open @p directory, which is made if it does not exist, and verify what is there of the job.
 *  @param wanted the frames that this process is to do, in rising order; with none of them the
 * store can only be finished, which joins what others did.
 *  @param slice NULL for the whole job, or a name for the frames that this process does while
 *  others do other frames in the same directory; borrowed.
 *  @return SC_ERR_CREATE if the directory holds another job, or if @p mode is SC_STORE_NEW and it
 *  holds a run; SC_ERR_WRITE, SC_ERR_MISSING, SC_ERR_MEMORY. Caller owns: sc_store_close. */
SC_MUST_USE sc_status sc_store_open(const sc_ctx *ctx, const char *directory,
                                    const sc_store_job *job, const int *wanted, int wanted_count,
                                    const char *slice, sc_store_mode mode, sc_store **out);
/** Close and free. What was not finished stays on disk for a later run. NULL is allowed. */
void sc_store_close(sc_store *store);

/** @return true if all that is asked for of frame @p k is on disk and verified. */
bool sc_store_has(const sc_store *store, int k);
/** @return true if the whole job is finished and verified: there is nothing to do. */
bool sc_store_is_complete(const sc_store *store);
/** @return the identity of the job, which ranks that encode GOPs put into the segments. */
uint64_t sc_store_identity(const sc_store *store);
/** List the GOPs of which no picture is there and all frames are wanted: any rank may draw and
 * encode them. @p out receives the numbers of their first frames, @p count of them, in rising
 * order.
 *  @return SC_ERR_MEMORY. Caller owns *out: sc_free. */
SC_MUST_USE sc_status sc_store_whole_gops(const sc_ctx *ctx, const sc_store *store, int **out,
                                          int *count);

/** Accept a wanted frame: keep its picture in a partial GOP, encode it when its turn has come,
 * write its PNG file and its line in the manifest. Returns when this is done, which takes as long
 * as the encoder. Frames of a GOP should come in rising order; otherwise pictures have to be read
 * back.
 *  @return SC_ERR_WRITE, SC_ERR_CREATE, or as sc_encoder_push. After an error the store can only be
 *  closed; a later run continues. */
SC_MUST_USE sc_status sc_store_add_frame(const sc_ctx *ctx, sc_store *store,
                                         const sc_done_frame *done, const sc_image *image);
/** Accept a whole GOP that a rank has drawn and encoded. @param done [count], its frames in order.
 *  @param png [count], the bytes of the PNG files; NULL where none are asked for.
 *  @return SC_ERR_INTERNAL if the segment is damaged, of another job or of other frames; else as
 *  sc_store_add_frame. */
SC_MUST_USE sc_status sc_store_add_gop(const sc_ctx *ctx, sc_store *store,
                                       const sc_done_frame *done, int count,
                                       const sc_segment *segment, const sc_segment *png);
/** Wall time that callers have spent in a store so far. */
typedef struct sc_store_times {
    double encode_wall_s, write_wall_s;
} sc_store_times;
/** @return the times so far. */
sc_store_times sc_store_time(const sc_store *store);

/** Flush everything to disk. If every frame is there, counting what other processes did, join the
 *  video and complete the manifest. Otherwise, and unless this is a slice, join what is there
 *  without a gap from frame 0 on to sc_video_partial_name.
 *  @param missing the number of frames that are not there. @return SC_ERR_WRITE, SC_ERR_CREATE. */
SC_MUST_USE sc_status sc_store_finish(const sc_ctx *ctx, sc_store *store, int *missing);

/** Read from a manifest in @p directory which job it belongs to. Sets version, hashes, frames and
 * size of @p job, and leaves the rest as it is. @param version room for at least 64 bytes, to which
 *  job->version points afterwards. @return SC_ERR_MISSING if there is no manifest. */
SC_MUST_USE sc_status sc_store_identify(const sc_ctx *ctx, const char *directory, sc_store_job *job,
                                        char *version);
/** Verify a finished directory: the manifest names every frame once, every PNG file is decoded and
 *  its pixels hashed, the bytes of the video are hashed, its frames decoded, counted, and their
 * sizes and times compared. @return SC_ERR_INCOMPLETE if the job is not finished, SC_ERR_DATA
 * naming the first thing that is wrong. */
SC_MUST_USE sc_status sc_store_verify(const sc_ctx *ctx, const char *directory,
                                      const sc_store_job *job);

#endif
