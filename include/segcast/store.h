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

/** The name of the file that says where a film comes from, as RO-Crates have it: one for all slices
 *  of a job. */
#define SC_CRATE_NAME "ro-crate-metadata.json"
/** The longest name of a video, in bytes, so that its temporary names fit (NAME_MAX is 255). */
enum { SC_VIDEO_NAME_MAX = 140 };
/** @return whether a video in the directory of a job can have this name: not too long, without a
 *  directory and control characters, not beginning with a dot, as temporary files do, and with an
 *  extension that sc_video_name_ok accepts. */
bool sc_store_video_ok(const char *name);

/** The directory of a job, open for one process. */
typedef struct sc_store sc_store;

/** The job that a directory belongs to. Strings are borrowed for the life of the store. */
typedef struct sc_store_job {
    const char *version;            /**< version of segcast: another one may draw other pixels */
    uint64_t job_hash, volume_hash; /**< hashes of all that determines pictures and encoding */
    int frames;                     /**< number of frames of the whole animation */
    const char *video;              /**< name of the video in the directory, or "none" */
    bool png;                       /**< write the frames as PNG files, too */
    bool keeps_job; /**< job.yaml in the directory is the very file that was given: it stays, and
                     * is not proven, since it is the user's */
    sc_video_settings settings;
    int threads; /**< for verifying PNG files, at least 1 */
} sc_store_job;

/** What sc_store_open does with a run that the directory holds already. */
typedef enum sc_store_mode {
    SC_STORE_NEW,      /**< refuse it */
    SC_STORE_RESUME,   /**< continue the run (or begin one, if there is none) */
    SC_STORE_OVERWRITE /**< remove what the run has left, and begin anew */
} sc_store_mode;

/** A finished frame: what its line in the manifest holds. Rank and time are not known if the line
 * was made anew from a segment or partial GOP on disk. */
typedef struct sc_done_frame {
    int frame;           /**< its number in the animation, from 0 */
    int rank;            /**< the rank that drew it; 0 if it is not known */
    double render_cpu_s; /**< CPU seconds of drawing it; 0 if they are not known */
    uint64_t hash;       /**< sc_image_hash */
    uint64_t png_bytes;  /**< size of its PNG file; 0: there is none. Set by the store */
    uint64_t png_hash;   /**< hash of the bytes of that file. Set by the store */
} sc_done_frame;

/** Check whether sc_store_open would refuse @p directory, before anything costs time: because
 *  something stands in the way that segcast did not make (no manifest in the directory names it),
 * or because it holds a run although @p mode is SC_STORE_NEW. A run is there if a manifest is: for
 * a slice its own or that of the whole job, otherwise any. Nothing is written. @param job of which
 *  video, png and frames are read. @param slice as for sc_store_open.
 *  @return SC_ERR_CREATE if so, or if the directory cannot be listed; SC_OK also if it does not
 *  exist; SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_store_check(const sc_ctx *ctx, const char *directory,
                                     const sc_store_job *job, const char *slice,
                                     sc_store_mode mode);
/** What sc_store_begin has made. Zero-initialise; owns its texts: sc_store_begun_clear. */
typedef struct sc_store_begun {
    bool may_write;                      /**< the record status.json may be written */
    bool made;                           /**< a manifest was written */
    bool made_directory;                 /**< and the directory made for it */
    char *directory, *manifest, *status; /**< paths; NULL: not made */
    int numbers[3];                      /**< see sc_unfinished_add */
} sc_store_begun;
/** After sc_store_check, before the volume is read: if the directory holds no manifest of this
 * slice or job, make it and write one that names what the run is going to make and has no hashes
 * yet, so that status.json may be written. Such a manifest is no run: sc_store_open replaces it,
 * and sc_store_check takes no notice of it. @param job of which video, png, frames, settings and
 *  version are read. @return SC_ERR_CREATE, SC_ERR_WRITE, SC_ERR_MEMORY. Caller owns *out:
 *  sc_store_unbegin, or sc_store_begun_clear when the store is open. */
SC_MUST_USE sc_status sc_store_begin(const sc_ctx *ctx, const char *directory,
                                     const sc_store_job *job, const char *slice, sc_store_mode mode,
                                     sc_store_begun *out);
/** Remove what sc_store_begin has made, and status.json beside it. All zero is allowed. */
void sc_store_unbegin(sc_store_begun *begun);
/** Free @p begun; what was made stays. All zero is allowed. */
void sc_store_begun_clear(sc_store_begun *begun);
/** Open @p directory, which is made if it does not exist, and verify what is there of the job.
 *  Unless the job is complete already, the directory then holds a manifest of this process with
 *  the lines of those wanted frames that are there. Warns of each file that is damaged. An output
 *  of a complete job that was changed since is renamed to NAME.changed, with a warning, before it
 *  is made again; of job.yaml see sc_store_write_job.
 *  @param wanted [wanted_count], the frames that this process is to do, in rising order, borrowed
 *  for the call; NULL: the store can only be finished, which joins what others did.
 *  @param slice NULL for the whole job, or a name for the frames that this process does while
 *  others do other frames in the same directory; borrowed.
 *  @return SC_ERR_CREATE if the directory holds another job, or if @p mode is SC_STORE_NEW and it
 *  holds a run; SC_ERR_WRITE, SC_ERR_MISSING, SC_ERR_MEMORY. Caller owns: sc_store_close. */
SC_MUST_USE sc_status sc_store_open(const sc_ctx *ctx, const char *directory,
                                    const sc_store_job *job, const int *wanted, int wanted_count,
                                    const char *slice, sc_store_mode mode, sc_store **out);
/** Write job.yaml, the job of this process as resolved, into the directory of a store that is not
 * sealed. A job.yaml there that neither this nor another slice or run of the job has written is
 * renamed to job.yaml.changed, with a warning. @return SC_ERR_CREATE, SC_ERR_WRITE, SC_ERR_MEMORY.
 */
SC_MUST_USE sc_status sc_store_write_job(const sc_ctx *ctx, sc_store *store, const void *text,
                                         size_t bytes);
/** Close and free, without sc_store_finish: what was not finished stays on disk for a later run.
 *  NULL is allowed. */
void sc_store_close(sc_store *store);
SC_CLOSE_AT(sc_store_close, sc_store)

/** @return true if all that is asked for of frame @p k, in [0, job.frames), is on disk and
 *  verified: its line, its PNG file, and its picture in a segment or a partial GOP. */
bool sc_store_has(const sc_store *store, int k);
/** @return what the manifest says of frame @p k, in [0, job.frames); NULL: nothing. Borrowed until
 *  a frame or GOP is added. */
const sc_done_frame *sc_store_done(const sc_store *store, int k);
/** @return true if the whole job is finished and verified: there is nothing to do, and no frame or
 *  GOP may be added. */
bool sc_store_is_complete(const sc_store *store);
/** @return true if the records of a complete job are proven, too (sc_store_seal): then nothing is
 *  to be written to the directory any more. */
bool sc_store_is_sealed(const sc_store *store);
/** @return true if the manifest that this process writes is not in the directory any more: another
 *  run has begun there, or has completed the job, and what is there is its own: nothing more is
 *  accepted. Also true of a slice that has completed the job. Threads: any, while the store is
 *  open. */
bool sc_store_is_replaced(const sc_store *store);
/** @return the identity of the job, which ranks that encode GOPs put into the segments. */
uint64_t sc_store_identity(const sc_store *store);
/** List the GOPs of which no picture is there and all frames are still to be done by this process:
 *  any rank may draw and encode them. @p out receives the numbers of their first frames, @p count
 *  of them, in rising order; 0 of them in a job without video.
 *  @return SC_ERR_MEMORY. Caller owns *out: sc_free, also if @p count is 0. */
SC_MUST_USE sc_status sc_store_whole_gops(const sc_ctx *ctx, const sc_store *store, int **out,
                                          int *count);

/** Accept a frame that was wanted and not there: keep its picture in a partial GOP, encode it,
 *  write its PNG and its line in the manifest. Blocks until that is written. Frames of a GOP should
 *  come in rising order; otherwise pictures have to be read back. @p image is only read.
 *  @return SC_ERR_WRITE, SC_ERR_CREATE, SC_ERR_DATA (a picture that was read back is damaged),
 *  SC_ERR_MEMORY, or as sc_encoder_push; SC_ERR_INCOMPLETE, without a message, if the store is
 *  replaced (sc_store_is_replaced). After an error the store can only be closed; a later run
 *  continues. */
SC_MUST_USE sc_status sc_store_add_frame(const sc_ctx *ctx, sc_store *store,
                                         const sc_done_frame *done, const sc_image *image);
/** Accept a whole GOP of sc_store_whole_gops that a rank has drawn and encoded: write its PNG
 *  files, lines and segment. All parameters are borrowed for the call.
 *  @param done [count], its frames in order.
 *  @param png [count], the bytes of the PNG files, written unread; NULL where none are asked for.
 *  @return SC_ERR_INTERNAL if the segment is damaged, of another job or of other frames; else as
 *  sc_store_add_frame. */
SC_MUST_USE sc_status sc_store_add_gop(const sc_ctx *ctx, sc_store *store,
                                       const sc_done_frame *done, int count,
                                       const sc_segment *segment, const sc_segment *png);
/** Wall seconds that the calling threads have spent in a store so far. */
typedef struct sc_store_times {
    double encode_wall_s; /**< encoding with the files of partial GOPs, and sc_store_finish */
    double write_wall_s;  /**< PNG files, manifest, and segments that other ranks have encoded */
} sc_store_times;
/** @return the times of @p store so far. */
sc_store_times sc_store_time(const sc_store *store);

/** Flush everything to disk; blocks until that is done. If every frame is there, counting what
 *  other processes did, join the video, complete the manifest and remove the files that are not
 *  needed any more. Otherwise, and unless this is a slice, join the whole GOPs that are there
 *  without a gap from frame 0 on to sc_video_partial_name. Does nothing if the job is complete.
 *  @param missing receives the number of frames of the whole job that are not there, 0 when it is
 *  complete; written also with an error, and then without meaning.
 *  @return SC_OK also if frames are missing; SC_ERR_INCOMPLETE, without a message, if this is no
 *  slice and the store is replaced (sc_store_is_replaced); SC_ERR_WRITE, SC_ERR_CREATE,
 * SC_ERR_MISSING, SC_ERR_MEMORY, or as sc_encoder_push and sc_muxer_add. */
SC_MUST_USE sc_status sc_store_finish(const sc_ctx *ctx, sc_store *store, int *missing);

/** After sc_store_finish, and after the records of the run (job.yaml, status, statistics, trace,
 * report) were written for the last time: if the job is complete, put their sizes and hashes into
 * the manifest and close it; then sc_store_verify can prove every file, and nothing more may be
 * written. Does nothing otherwise. @return as sc_store_finish. */
SC_MUST_USE sc_status sc_store_seal(const sc_ctx *ctx, sc_store *store);
/** Before sc_store_finish of a slice, when its frames and records are written: put the sizes and
 *  hashes of the records into its manifest, and close that. A job is completed by the slice that
 *  ends last in this way, or by one that is resumed and finds all of its frames. Does nothing
 *  without a slice. @return as sc_store_seal. */
SC_MUST_USE sc_status sc_store_end_slice(const sc_ctx *ctx, sc_store *store);

/** Read from a manifest in @p directory which job it belongs to: version, both hashes, frames and
 *  the size in settings of @p job are set, the rest is left as it is. @param version room for at
 *  least 64 bytes, to which job->version points then. @return SC_ERR_MISSING if there is no
 *  manifest, SC_ERR_DATA if its first line is damaged or of another format. */
SC_MUST_USE sc_status sc_store_identify(const sc_ctx *ctx, const char *directory, sc_store_job *job,
                                        char *version);
/** What sc_store_status finds. */
typedef enum sc_store_condition {
    SC_STORE_COMPLETE,   /**< the manifest has its end line, and the outputs have their sizes */
    SC_STORE_INCOMPLETE, /**< frames or the video are still to be made */
    SC_STORE_DAMAGED     /**< what is there is not what segcast wrote */
} sc_store_condition;
/** The state of the job in a directory. */
typedef struct sc_store_report {
    sc_store_condition condition;
    int done, frames; /**< frames that the manifests name; frames of the job, 0 if unknown */
    char video[256];  /**< name of the video of a complete job; empty: none */
    char reason[256]; /**< what is damaged, in words; empty otherwise */
} sc_store_report;
/** Find out quickly whether the job in @p directory is complete: from its manifests and the size
 *  of the video, without reading pictures. @param wanted NULL, or the frames [count] of a slice:
 *  then the report is of them alone, and complete also if frames of other slices are still to be
 *  made. @return SC_OK with @p out filled, also for a damaged
 *  directory; SC_ERR_MISSING, logged, if it does not exist or holds no run; SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_store_status(const sc_ctx *ctx, const char *directory, const int *wanted,
                                      int count, sc_store_report *out);
/** Verify the manifest of a finished directory, line by line, and the records that it names, byte
 * by byte; before job.yaml, one of them, is read. @param names ", NAME" is appended for each.
 *  @return SC_ERR_INCOMPLETE if the job is not finished, SC_ERR_DATA naming the first thing that is
 *  wrong, SC_ERR_MEMORY. Caller owns @p names. */
SC_MUST_USE sc_status sc_store_verify_records(const sc_ctx *ctx, const char *directory,
                                              sc_text *names);
/** Verify a finished directory: the manifest names every frame once, every PNG file is decoded and
 *  its pixels hashed, the bytes of the video are hashed, its frames decoded, counted, and their
 * sizes and times compared. @return SC_ERR_INCOMPLETE if the job is not finished, SC_ERR_DATA
 *  naming the first thing that is wrong, SC_ERR_MISSING without a manifest. @param job as
 *  sc_store_identify and the job file have it; its hashes and version are not compared. */
SC_MUST_USE sc_status sc_store_verify(const sc_ctx *ctx, const char *directory,
                                      const sc_store_job *job);

/** Append to @p out, each with a NUL byte behind it, what is in @p directory and what its manifests
 * name as made by segcast, but for segments: names of files, manifest.jsonl among them, and
 * "frames/", in the order of names. @return SC_ERR_MEMORY, the errors of listing. */
SC_MUST_USE sc_status sc_store_parts(const sc_ctx *ctx, const char *directory, sc_text *out);

/** Write a record of a run, such as report.html, anew: after the run, or while nobody runs it. The
 *  manifest of a finished job gets its new size and hash, so that it stays proven.
 *  @param name in the directory. @param text [bytes]. @return SC_ERR_CREATE if something of that
 *  name is there that no manifest names; SC_ERR_DATA if the manifest is damaged; SC_ERR_WRITE,
 *  SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_store_replace_record(const sc_ctx *ctx, const char *directory,
                                              const char *name, const void *text, size_t bytes);

#endif
