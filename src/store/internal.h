/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to store. The public functions are in store.c, finish.c, job_text.c and verify.c. They
 * and the files named below call only functions of files that are named further down in this
 * header. */
#ifndef SC_STORE_INTERNAL_H
#define SC_STORE_INTERNAL_H

#include "segcast/store.h"

/* Longest path of the directory, so that the system takes the paths of all files in it (PATH_MAX is
 * 4096). */
enum { SC_DIRECTORY_MAX = 3700 };
/* Room for the path of the directory, and of a file in it. */
enum { SC_DIRECTORY_BYTES = SC_DIRECTORY_MAX + 1, SC_FILE_BYTES = 4096 };
/* The largest segment that is read back: a second of video. */
#define SC_SEGMENT_MAX_BYTES ((size_t)1 << 32)
/* The most frames that a job may have, and a manifest may name. */
enum { SC_STORE_FRAMES_MAX = 1000000 };

/* The line of a frame in a manifest. */
typedef struct sc_frame_line {
    bool known; /* there is a line; otherwise `done` means nothing */
    sc_done_frame done;
} sc_frame_line;

/* The line of another file in a manifest: what it held when it was complete. */
typedef struct sc_file_line {
    char *name; /* in the directory; owned */
    uint64_t bytes, hash;
} sc_file_line;
/* The lines of files, each name once, in the order in which they were added until
 * sc_file_lines_sort. Zero-initialise; owns its memory: sc_file_lines_clear. */
typedef struct sc_file_lines {
    sc_file_line *lines; /* [capacity], the first `count` are used */
    int count, capacity;
    struct json_t *index; /* finds the number of a line by its name; private to names.c */
} sc_file_lines;
/* Names, each once: lines of 0 bytes. */
typedef sc_file_lines sc_names;

/* Texts that segcast has written as job.yaml in a directory, or was about to write: lines of which
 * each is named by its hash. Slices of a job may write different ones. */
typedef sc_file_lines sc_job_texts;

/* The first line of a manifest: what sc_store_job has under the same names. */
typedef struct sc_manifest_head {
    bool known;          /* the line was there and proves itself; otherwise the rest is zero */
    const char *problem; /* without a known head: why, as words that follow the path; static */
    char version[64];
    uint64_t job_hash, volume_hash;
    int frames, size_px[2]; /* width and height */
} sc_manifest_head;

/* @return the hash of what sc_store_identity stands for. */
uint64_t sc_identity_of(uint64_t job_hash, uint64_t volume_hash, int frames, const char *version);

/* Is it the head of sc_store_begin, which knows neither hash yet? */
static inline bool sc_head_has_no_hashes(const sc_manifest_head *head)
{
    return head->job_hash == 0 && head->volume_hash == 0;
}

/* What the line says that a manifest has when the outputs of a job are there. */
typedef struct sc_manifest_end {
    bool known;
    uint64_t video_bytes, video_hash; /* size and sc_store_hash_file of the video; 0 without one */
    char video[256];                  /* name of the video; empty without one */
} sc_manifest_end;

/* The content of one or several manifests. Zero-initialise: sc_manifest_data_clear. */
typedef struct sc_manifest_data {
    sc_manifest_head head; /* of the manifest that was read last */
    sc_names owned;        /* what segcast has made in the directory, or is going to: sc_own_name */
    sc_manifest_end end;   /* of any of them */
    bool closed;           /* the last line of one that was read last is there: nothing follows */
    sc_file_lines files;   /* of all of them, but for job.yaml */
    sc_job_texts jobs;     /* of all of them; that of a finished job has one, which is proven */
    sc_frame_line *lines;  /* [frames], allocated and freed by the caller, or NULL to count only */
    int frames;            /* set by the caller */
    int count;             /* of the lines of frames that were read; a frame may have several */
    int damaged_line;      /* of the manifest read last: number, from 1, of the first line that does
                            * not prove itself although something follows it; 0: none */
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
    char directory[SC_FILE_BYTES]; /* that of the segments */
    uint64_t identity;             /* of the job: pictures of another one are ignored */
    size_t picture_bytes;          /* sc_picture_bytes: the same for all pictures */
    int frames;
    sc_picture_location *locations; /* [frames], owned */
    char **files;                   /* [file_count], paths, owned; one may stand there twice */
    int file_count, file_capacity;
    int scanned_count; /* the first so many of `files` were found; this process made the others */
    FILE *stream;      /* of the file that is being written, or NULL */
    int stream_gop, stream_file; /* the GOP of that file, and its index in `files` */
} sc_partial_gops;

/* Which file it is, whatever has its name. */
typedef struct sc_file_id {
    uint64_t device, inode;
} sc_file_id;

/* What this process does of the job. */
typedef struct sc_store_role {
    const char *slice; /* NULL: the whole job */
    bool joins;        /* it draws nothing */
    bool takes_over;   /* it completes the job even if another slice has not ended */
} sc_store_role;

/* Which outputs are still to be made, and which are there. */
typedef struct sc_store_outputs {
    bool *wanted;      /* [frames]: not there when opened, and this process accepts it */
    bool *has_png;     /* [frames]: the PNG file is verified, or was written here */
    bool *has_segment; /* [gop_count]: the segment is verified, or was written here */
} sc_store_outputs;

/* The manifest of this process. */
typedef struct sc_own_manifest {
    sc_manifest_writer *writer; /* NULL: complete, or nothing wanted */
    sc_file_id id;              /* of the file, as this process has made it; zero: not made */
    double synced_s;            /* when it was last flushed to disk, by sc_wall_s */
} sc_own_manifest;

struct sc_store {
    char directory[SC_DIRECTORY_BYTES];
    sc_store_job job;
    sc_store_role role;
    bool has_video;            /* job.video is not "none"; without one there are no segments */
    bool owns_more;            /* it makes what no manifest in the directory names */
    bool complete;             /* the job is finished and verified */
    bool sealed;               /* and so are its records; nothing more is written */
    int open_slices;           /* manifests of other slices that have not ended in order */
    uint64_t identity;         /* hash of job_hash, volume_hash, frames and version */
    int gop_frames, gop_count; /* length of a GOP, but for the last one, and number of GOPs */
    sc_manifest_data data;     /* of all manifests in the directory, kept up to date; owns lines */
    sc_store_outputs outputs;
    sc_partial_gops partial;
    sc_own_manifest manifest;
    sc_encoder *encoder; /* NULL until sc_store_open_encoder */
    int encoding;        /* the GOP that the encoder works on, or -1 */
    void *picture;       /* buffer of sc_picture_bytes for a picture that is read back */
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

/* ---- remove.c: what is removed from the directory: nothing but regular files that the manifests
 * name, and folders that are empty then. No symbolic link is followed. A file that is not there, or
 * that cannot be removed, is no error. The state of the store is left as it is. ---- */

/* Remove everything that the manifests in the directory name but job.yaml, which the new run
 * replaces, these manifests included; instead of them comes, first of all, one of this job without
 * any frame, which names the same, and that job.yaml as well.
 * @return SC_ERR_CREATE, SC_ERR_WRITE, SC_ERR_MEMORY; an error if a directory cannot be listed. */
sc_status sc_store_remove_run(const sc_ctx *ctx, sc_store *store);
/* Remove what only an unfinished job needs, as far as store->data.owned names it: segments, partial
 * GOPs, the partial video and temporary files, and the folder of the segments. */
void sc_store_remove_unfinished(const sc_ctx *ctx, const sc_store *store);
/* Remove the manifests of slices, not that of the whole job. */
sc_status sc_store_remove_slices(const sc_ctx *ctx, sc_store *store);

/* ---- owned.c: what belongs to segcast ---- */

/* What a run needs to know of the files that are there already. */
typedef struct sc_store_place {
    const char *directory; /* of SC_DIRECTORY_MAX bytes at most */
    const char *slice;     /* NULL: the whole job */
    const char *video;     /* name of the video, or "none" */
    bool png;
    bool joins; /* no records are written */
    bool fresh; /* what earlier runs made was removed: what manifests name is not read */
    int frames;
} sc_store_place;
/* Refuse a directory in which something stands in the way of a run and was not made by segcast: a
 * file, folder or link under a name that the run is going to use and no manifest names, or anything
 * but segments and partial GOPs in segments/. Nothing is written.
 * @param owned names are added to it: what the manifests name, and what this run is going to make.
 * @param more whether the run is going to make something that no manifest names.
 * @return SC_ERR_CREATE, with a message, also if it cannot be listed; SC_ERR_MEMORY. */
sc_status sc_store_check_place(const sc_ctx *ctx, const sc_store_place *place, sc_names *owned,
                               bool *more);

/* ---- job_text.c: job.yaml, which its user may change, and which slices write in turn. Each text
 * is noted in the manifest of its process, and that is on disk, before it is written: so every text
 * that no manifest names is somebody else's. ---- */

/* Add the text of the job.yaml that is there, if any: it may be replaced then. @return
 * SC_ERR_MEMORY, or that another part of the machine failed, logged. */
sc_status sc_job_texts_put_file(const sc_ctx *ctx, const char *directory, sc_job_texts *jobs);
/* Set *out to whether job.yaml in the directory is one of the texts: false, without a message, also
 * if it is missing or no regular file. @return as sc_job_texts_put_file. */
sc_status sc_job_texts_have_file(const sc_ctx *ctx, const char *directory, const sc_job_texts *jobs,
                                 bool *out);

/* ---- aside.c: finished outputs that were changed ---- */

/* Rename the file @p path to PATH.changed, or PATH.changed-2 and so on. @param kept receives that
 * path, which the caller clears; it stays empty if there is no file any more. @return
 * SC_ERR_CREATE, SC_ERR_MEMORY. */
sc_status sc_store_rename_aside(const sc_ctx *ctx, const char *path, sc_text *kept);
/* Warn that the file @p path was changed and is now @p kept. */
void sc_store_warn_of_aside(const sc_ctx *ctx, const char *path, const char *kept);

/* Rename the regular file @p path to PATH.changed, or PATH.changed-2 and so on, unless it has this
 * size and hash (sc_store_hash_file), and warn of it. Anything else of that name, and a file that
 * is missing, is left alone. @return SC_ERR_CREATE, SC_ERR_MEMORY, or as sc_verify_file. */
sc_status sc_store_set_aside(const sc_ctx *ctx, const char *path, uint64_t bytes, uint64_t hash);
/* After a scan, before a run makes outputs again: set aside those that the manifests prove and that
 * are not what they were, but for job.yaml. @return as sc_store_set_aside. */
sc_status sc_store_set_all_aside(const sc_ctx *ctx, const sc_store *store);

/* ---- state.c: what the store knows ---- */

/* @return the number of frames of GOP @p gop; the last one may be shorter. */
int sc_store_gop_frames(const sc_store *store, int gop);
/* @return whether a segment that says this of itself is GOP @p gop of the job. */
bool sc_store_is_segment_of(const sc_store *store, const sc_segment_info *info, int gop);
/* @return whether the picture of frame @p k is in a segment or a partial GOP, as the last scan and
 * what was accepted since have it. */
bool sc_store_has_picture(const sc_store *store, int k);

/* ---- outputs.c: verifying finished files against the manifest ---- */

/* Verify the PNG files of the frames that have one of the @p lines [frames], on @p threads threads:
 * their bytes have the hash that the line names, and their pixels, decoded, the other one. A line
 * that does not name the bytes (png_bytes is 0) gets size and hash of a file with the right pixels.
 * @param out [frames], set to whether the file is right: false, without a message, if there is no
 * line or no file. The frames are counted in the stage of @p ctx. @return SC_ERR_MEMORY, or that
 * another part of the machine failed, logged once. */
sc_status sc_verify_png_files(const sc_ctx *ctx, const char *directory, sc_frame_line *lines,
                              int frames, int threads, bool *out);
/* Read the whole file: set its size and the hash of its bytes. No symbolic link is followed.
 * @return SC_ERR_MISSING if it cannot be read or is no regular file, SC_ERR_MEMORY. */
sc_status sc_store_hash_file(const sc_ctx *ctx, const char *path, uint64_t *bytes, uint64_t *hash);
/* @return the hash that sc_store_hash_file gives for a file that holds these bytes. */
uint64_t sc_store_hash_bytes(const void *data, size_t bytes);
/* Set *out to whether the file has the given size and hash (sc_store_hash_file): false, without a
 * message, also if it is missing or no regular file. Reads the whole file if the size is right.
 * @return SC_ERR_MEMORY, or that another part of the machine failed, logged. */
sc_status sc_verify_file(const sc_ctx *ctx, const char *path, uint64_t bytes, uint64_t hash,
                         bool *out);

/* ---- partial_gops.c: pictures of GOPs that are not whole yet ---- */

/* Begin with no files and no pictures. @param directory that of the segments, copied.
 * @param picture_bytes as of sc_picture_bytes. @return SC_ERR_MEMORY. Caller owns *out:
 * sc_partial_close. */
sc_status sc_partial_open(const sc_ctx *ctx, const char *directory, uint64_t identity,
                          size_t picture_bytes, int frames, sc_partial_gops *out);
/* Set the locations of the pictures in the file @p path, up to the first that is damaged, of
 * another job, or not one of the frames [first, first + count) of the file's GOP. A frame that is
 * found again gets the new location. A file that cannot be opened has none. @return SC_ERR_MEMORY.
 */
sc_status sc_partial_scan(const sc_ctx *ctx, sc_partial_gops *partial, const char *path, int first,
                          int count);
/* Append a picture of GOP @p gop to this process's file for it, which is made if need be, and set
 * its location. @p hash: sc_image_hash of the frame. @return SC_ERR_CREATE, SC_ERR_WRITE,
 * SC_ERR_MEMORY. */
sc_status sc_partial_add(const sc_ctx *ctx, sc_partial_gops *partial, int gop, int frame,
                         const void *picture, uint64_t hash);
/* Read the picture of a frame that has a location into @p picture, which has room for
 * picture_bytes, and verify it. @return SC_ERR_DATA if it is damaged, SC_ERR_INCOMPLETE if its file
 * is gone. */
sc_status sc_partial_read(const sc_ctx *ctx, const sc_partial_gops *partial, int frame,
                          void *picture);
/* @return whether the file @p path begins with a picture of the job @p identity, or is empty. */
bool sc_is_partial_of(const char *path, uint64_t identity);
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

/* ---- manifest.c: lines. All that write return SC_ERR_WRITE, or SC_ERR_MEMORY.
 *
 * Each line ends with the hash of itself, seeded with that of the line before it: so it proves
 * itself and that no line before it was changed or removed. ---- */

/* Read one manifest into @p data: head, closed and damaged_line are replaced; lines, count, owned,
 * files and jobs are added to what earlier ones gave (a later line of a frame or file wins), and so
 * is `end` if there is such a line. Reading ends, without an error, at the first line that is
 * truncated, does not prove itself, or says what cannot be; head.known is false if that is the
 * first. @return SC_ERR_MISSING, SC_ERR_DATA if the file is too large, SC_ERR_MEMORY. */
sc_status sc_manifest_read(const sc_ctx *ctx, const char *path, sc_manifest_data *data);
/* Read the first line alone: sets head, and adds to owned. @return as sc_manifest_read. */
sc_status sc_manifest_read_head(const sc_ctx *ctx, const char *path, sc_manifest_data *data);
/* Write a new manifest @p path: a head with the names of data->owned, the lines data->lines[k] of
 * those frames k for which keep[k] is set (NULL: of all that are known), the end data->end, if that
 * is known, data->files and data->jobs; owned, files and jobs are sorted before. It replaces an
 * older one in one step. @param close add the last line, that of a finished job. @param id NULL, or
 * set to which file it is, also if an error came when it was in place. @param out a writer for more
 * lines, or NULL. @return SC_ERR_CREATE, too. Caller owns *out: sc_manifest_close. */
sc_status sc_manifest_create(const sc_ctx *ctx, const char *path, const sc_store_job *job,
                             sc_manifest_data *data, const bool *keep, bool close, sc_file_id *id,
                             sc_manifest_writer **out);
/* Log that a directory has no manifest, or is not there. @return SC_ERR_MISSING. */
sc_status sc_fail_no_run(const sc_ctx *ctx, const char *directory);
/* @return whether the file @p path is the one that @p id tells of. */
bool sc_file_has_id(const char *path, const sc_file_id *id);
/* Append the line of a frame; it is with the system then, but not yet flushed to disk. */
sc_status sc_manifest_add_frame(const sc_ctx *ctx, sc_manifest_writer *manifest,
                                const sc_done_frame *done);
/* Append the line of a text of job.yaml, in the same way. */
sc_status sc_manifest_add_job(const sc_ctx *ctx, sc_manifest_writer *manifest, uint64_t bytes,
                              uint64_t hash);
/* Append the lines of files and the last line, in the same way. */
sc_status sc_manifest_add_close(const sc_ctx *ctx, sc_manifest_writer *manifest,
                                const sc_file_lines *files);
/* Flush to disk; blocks until it is there. NULL is allowed. */
sc_status sc_manifest_sync(const sc_ctx *ctx, sc_manifest_writer *manifest);
/* Close and free, without flushing to disk. NULL is allowed. */
void sc_manifest_close(sc_manifest_writer *manifest);
SC_CLOSE_AT(sc_manifest_close, sc_manifest_writer)
/* Free what @p data owns, and zero that; data->lines is the caller's. */
void sc_manifest_data_clear(sc_manifest_data *data);

/* ---- names.c: lists of names. To add, find or remove one takes the same time whatever their
 * number is. ---- */

/* Append a copy of @p name, unless it is there. @return SC_ERR_MEMORY. */
sc_status sc_names_add(const sc_ctx *ctx, sc_names *names, const char *name);
/* Append the line of a file, or replace that of the same name. @return SC_ERR_MEMORY. */
sc_status sc_file_lines_put(const sc_ctx *ctx, sc_file_lines *files, const char *name,
                            uint64_t bytes, uint64_t hash);
bool sc_file_lines_has(const sc_file_lines *files, const char *name);
/* Remove the line of a file, if there is one; the last line takes its place. */
void sc_file_lines_remove(sc_file_lines *files, const char *name);
/* Put the lines into the order of strcmp of their names. */
void sc_file_lines_sort(sc_file_lines *files);
void sc_file_lines_clear(sc_file_lines *files);
/* Append a text of job.yaml, unless it is there. @return SC_ERR_MEMORY. */
sc_status sc_job_texts_put(const sc_ctx *ctx, sc_job_texts *jobs, uint64_t bytes, uint64_t hash);
bool sc_job_texts_have(const sc_job_texts *jobs, uint64_t bytes, uint64_t hash);

/* ---- files.c: names in the directory ---- */

/* What sc_own_name accepts for the files in the two folders. */
#define SC_OWN_PNG "frames/*.png"
#define SC_OWN_SEGMENTS "segments/*"
/* @return whether a manifest may say that segcast made a file of this name: a record such as
 * job.yaml or stats.S.json, a video, "frames/", "segments/", SC_OWN_PNG, or SC_OWN_SEGMENTS. None
 * leads out of the directory. */
bool sc_own_name(const char *name);
/* @return whether @p name, without folder, is "NNNNNN.png" with a number, of six digits or more,
 * below @p frames. */
bool sc_is_frame_name(const char *name, int frames);
/* @return whether @p name, without folder, is "NNNNNN.seg" or "NNNNNN.HOST.PID.part". */
bool sc_is_segment_name(const char *name);
/* The names of records, for @p slice (NULL: the whole job): calls @p each with every one. */
sc_status sc_each_record(const sc_ctx *ctx, const char *slice, void *user,
                         sc_status (*each)(const sc_ctx *ctx, void *user, const char *name));
/* Write "DIR/NAME", with a formatted name, into @p out; sc_store_check_place has made sure that
 * there is room. */
SC_PRINTF(3, 4)
void sc_store_path(const char *directory, char out[SC_FILE_BYTES], const char *fmt, ...);
/* Write the path of this process's manifest into @p out: that of the slice, or of the whole job. */
void sc_store_manifest_path(const sc_store *store, char out[SC_FILE_BYTES]);
/* @return whether @p name, without directory, is "manifest.jsonl" or "manifest.S.jsonl" with a
 * non-empty S. */
bool sc_is_manifest_name(const char *name);
/* Receives one entry of a directory: its path, and its @p name, without directory. Both are
 * borrowed for the call. */
typedef sc_status sc_each_file_fn(const sc_ctx *ctx, void *user, const char *path,
                                  const char *name);
/* Call @p each with @p user for the entries of a directory (folders are entries, too) whose names
 * are wanted (sc_is_manifest_name, sc_is_segment_name), in order of these, until one call fails.
 * They are listed before the first call: a file may be gone when its turn comes. A directory that
 * does not exist has no entries. @return the error of the call that failed, or SC_ERR_MISSING if it
 * cannot be listed. */
sc_status sc_each_file(const sc_ctx *ctx, const char *directory,
                       bool (*is_wanted)(const char *name), void *user, sc_each_file_fn *each);

#endif
