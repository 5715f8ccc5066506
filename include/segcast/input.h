/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  From the files of a job to its volumes on every rank: read, named, edited, coloured, hidden,
 *  resampled and prepared. */
#ifndef SEGCAST_INPUT_H
#define SEGCAST_INPUT_H

#include "segcast/prepare.h"
#include "segcast/process.h"
#include "segcast/render.h"
#include "segcast/resample.h"

/** A volume of a job, from what is given of it to what it is held by. */
typedef struct sc_input {
    bool measure;        /**< measure all labels, so that none is hidden; set before it is loaded */
    bool is_later_phase; /**< of a beat: not the first, whose colours count, and which is told of */
    bool is_between;     /**< a phase that is interpolated, prepared as `volume` says before */
    sc_volume *given;    /**< its voxels then, on rank 0, taken over when they are read; borrowed */
    bool drawn_known;    /**< the grid on which it was drawn is known, and not measured again; */
    sc_drawn_grid drawn; /**< that is it */
    sc_shared *shared;   /**< the block that holds it, or NULL: it is in a file; owned */
    sc_watched_file *mapped; /**< the prepared file that the job names, or NULL; owned */
    sc_watched_file *kept;   /**< the file of the cache that holds it, or NULL; owned */
    size_t bytes;            /**< size of what is prepared, wherever it is */
    sc_label *labels;        /**< of a volume in a file, or inspected, by the job's names; owned */
    sc_label_stats *stats;   /**< of an inspected volume; owned */
    sc_prepared volume;      /**< a view of what the members above hold */
} sc_input;

/** So many phases are loaded at once while frames are drawn: that of the frame, and one more, which
 * is that of the other shot under a cross-fade, or else of the frame before. */
enum { SC_PHASES_LOADED = 2 };
/** A phase from which this rank has drawn. */
typedef struct sc_loaded_phase {
    sc_renderer *renderer; /**< NULL: none; borrowed */
    int phase;             /**< which */
} sc_loaded_phase;

/** All volumes of a job: one, or the phases of a beat, or the subjects of a comparison. */
typedef struct sc_inputs {
    int count;                                /**< of them */
    sc_input *all;                            /**< [count], owned */
    sc_loaded_phase loaded[SC_PHASES_LOADED]; /**< from which this rank has drawn, the last first */
    bool in_files; /**< phases, and what is derived from them, are held in files */
} sc_inputs;

/** @return how many subjects are compared by a job: 1 without a comparison. */
int sc_subject_count(const sc_job *job);
/** Write a job whose only volume is number @p i of those of @p job, before interpolation, to @p
 * out, which borrows from it. */
void sc_job_of_input(const sc_job *job, int i, sc_job *out);
/** Leave of the tissues that a job chooses for overlays only those of one use. */
void sc_job_keep_tissues(sc_job *job, sc_tissue_use use);
/** Prepare all volumes of a job, which all ranks have, or map them. @param times what that took is
 * added. Collective. Caller owns *out, also after an error: sc_inputs_free. @return SC_ERR_DATA,
 * logged, also if phases differ in their grids or labels. */
sc_status sc_inputs_load(sc_app *app, sc_job *job, bool measure, sc_rank_record *times,
                         sc_inputs **out);
/** Find out whether the volumes of a job, @p inputs, which were prepared as @p of asks, are
 * prepared as @p job asks, too. Both have been loaded. @return SC_ERR_MEMORY. Not collective. */
sc_status sc_inputs_fit(const sc_app *app, const sc_inputs *inputs, const sc_job *of,
                        const sc_job *job, bool *fits);
/** @return SC_ERR_WRITE, logged, if something has written into a prepared file from which frames
 * are drawn, and which must not change meanwhile (sc_watched_file_is_changed). */
sc_status sc_inputs_check_files(const sc_ctx *ctx, const sc_inputs *inputs);
/** Find what can be known of the volumes of a job without preparing them: their sizes, geometry and
 * labels, and the voxels and bounding boxes of these; all else stays empty. This takes one pass
 * over the voxels, in bounded memory. With @p header_only there is none: then the labels are those
 * of the label tables and those that the job names by number, and the boxes are empty. For a
 * process that is the only rank. Caller owns *out, also after an error: sc_inputs_free. */
sc_status sc_inputs_inspect(sc_app *app, sc_job *job, bool header_only, sc_inputs **out);
/** Free inputs; NULL is allowed. Collective. */
void sc_inputs_free(sc_inputs *inputs);
/** @return the hash of all volumes, in their order. */
uint64_t sc_inputs_hash(const sc_inputs *inputs);
/** @return the bytes of all volumes as they are prepared. */
uint64_t sc_inputs_bytes(const sc_inputs *inputs);
/** Tell the system what becomes of the memory of a volume, as far as it is in a file. */
void sc_input_advise(const sc_input *input, sc_memory_use use);

/** As sc_inputs_load, of the only volume of a job. */
sc_status sc_input_load(sc_app *app, sc_job *job, sc_rank_record *times, sc_input *input);
/** As sc_inputs_inspect, of the only volume of a job. */
sc_status sc_input_inspect(sc_app *app, sc_job *job, bool header_only, sc_input *input);
/** As sc_input_inspect, with the voxels in memory, and colours as pictures have them. @param voxels
 * what input->volume borrows; caller owns, also after an error: sc_volume_clear. */
sc_status sc_input_look(sc_app *app, sc_job *job, sc_input *input, sc_volume *voxels);
/** Map the prepared file that is the volume of a job on every rank, and make sure that it is the
 * same file on all. @param usable whether the job can use it as it is; if not, a warning says why,
 * and it has to be prepared again. Collective. */
sc_status sc_input_map(const sc_app *app, sc_job *job, sc_input *input, bool *usable);
/** Free what holds a volume. Collective. */
void sc_input_clear(sc_input *input);
/** On this rank alone: read the voxels of the volume of a job as they stand in its file, or in the
 * prepared file that is mapped, with the names of its label table. Nothing is hidden, resampled or
 * coloured. @param out caller owns, also after an error: sc_volume_clear. */
sc_status sc_input_voxels(const sc_app *app, const sc_job *job, const sc_input *input,
                          sc_volume *out);

/** A volume that was read and edited for a job, and how it is to be prepared. */
typedef struct sc_edited {
    sc_volume volume;             /**< owned */
    sc_prepare_settings settings; /**< with the arrays below; no team yet */
    bool *hidden;                 /**< [label_count], owned: labels that became background */
    sc_vec3 *tissue_smooth;       /**< [label_count], owned */
    bool resample;       /**< it is still to be brought to the grid on which it was drawn */
    sc_drawn_grid drawn; /**< that grid, once it is measured: drawn_known */
    bool drawn_known;
} sc_edited;
/** On this rank alone: read the volume of a job into @p edited and prepare what the job shows of
 * it; all of it if input->measure. @param preparation borrows @p edited. Caller owns both outputs,
 * also after an error: sc_preparation_free, then sc_edited_clear. */
sc_status sc_input_prepare(const sc_app *app, const sc_job *job, const sc_input *input,
                           sc_edited *edited, sc_preparation **preparation);
/** Free what @p edited owns. */
void sc_edited_clear(sc_edited *edited);

/** Write the directory in which prepared volumes are kept from one command to the next to *out:
 * that of SEGCAST_CACHE, or else in the user's cache directory, but not in a batch job. NULL:
 * nothing is kept. @return SC_ERR_MEMORY. Caller owns *out: sc_free. */
sc_status sc_kept_directory(const sc_ctx *ctx, char **out);
/** Remove prepared volumes, and light, from the directory in which they are kept, those not used
 * for longest first, until all have at most @p most_bytes bytes. @param files how many volumes
 * stay. @param bytes of all that does.
 * @return SC_ERR_MEMORY. */
sc_status sc_kept_trim(const sc_ctx *ctx, const char *directory, uint64_t most_bytes, int *files,
                       uint64_t *bytes);

/** A grey volume (CT, MR) in memory that the ranks of a node share. */
typedef struct sc_grey_input {
    sc_grey grey;          /**< codes NULL: there is none, or not yet */
    sc_shared *codes;      /**< block that holds its codes; NULL: none, or another's; owned */
    sc_grey_window window; /**< that of the job, or found; the same on all ranks */
    uint64_t hash;         /**< of codes and geometry; the same on all ranks */
    sc_vec3 moved_mm; /**< how far it is moved from where its file places it, with the labels */
} sc_grey_input;
/** Read the grey volume of a job, if it has one, once on every node, and choose its window. @param
 * volume the labels, moved by out->moved_mm. @param times as of sc_inputs_load. Collective. @return
 * SC_ERR_DATA also for one that lies nowhere in the box of the volume. */
sc_status sc_grey_load(sc_app *app, const sc_job *job, const sc_prepared *volume,
                       sc_rank_record *times, sc_grey_input *out);
/** As sc_grey_load, for the same file as that of @p from, whose codes it borrows. Collective. */
sc_status sc_grey_borrow(sc_app *app, const sc_job *job, const sc_prepared *volume,
                         const sc_grey_input *from, sc_grey_input *out);
/** Check the header of the grey volume of a job, if it has one, and where it lies, moved by
 * @p moved_mm. @return as sc_grey_load. */
sc_status sc_grey_check(const sc_app *app, const sc_job *job, const sc_prepared *volume,
                        sc_vec3 moved_mm);

/** If the argument of a command that has no job file is a pattern, such as heart_*.nrrd, and no
 * file, let the series of files be phases of a beat, as the default. */
sc_status sc_expect_series(sc_app *app);
/** Write to @p out a copy of @p app that keeps the phases of a job while they are read one after
 * the other: those of one file in a store, which the caller owns: sc_phase_store_free. @return
 * SC_ERR_MEMORY; the store is NULL then, as where there is none. */
sc_status sc_begin_phase_store(sc_app *app, const sc_job *job, sc_app *out);
/** Begin a later phase of a beat, which is measured as the first. */
void sc_input_begin_phase(const sc_input *first, sc_input *out);
/** Begin a phase that is interpolated behind one which is prepared as @p before. The caller sets
 * out->given on rank 0. */
void sc_input_begin_between(const sc_prepared *before, const sc_input *first, sc_input *out);
/** Refuse phase @p index of a job, @p b, if its grid or labels are not those of the first, @p a.
 * @param all labels of volumes whose voxels were read, so that the lack of one is known. @return
 * SC_ERR_DATA. */
sc_status sc_check_phase(const sc_ctx *ctx, const sc_job *job, const sc_prepared *a,
                         const sc_prepared *b, int index, bool all);
/** Append the number of a phase to the name of a file, before its ending @p ending, with as many
 * digits as the last of @p count has, so that names sort. @param text empty; the caller clears it,
 * also after an error. */
sc_status sc_phase_path(const sc_ctx *ctx, const char *path, const char *ending, int phase,
                        int count, sc_text *text);

/** Read the size in voxels from "phantom" or "phantom:WxDxH", the value of @p key. @return
 * SC_ERR_USAGE for another text. */
sc_status sc_phantom_size(const sc_ctx *ctx, const char *key, const char *volume, int size[3]);
/** Copy the voxels and the labels of a prepared volume. @return SC_ERR_MEMORY. Caller owns *out:
 * sc_volume_clear. */
sc_status sc_copy_prepared(const sc_ctx *ctx, const sc_prepared *from, sc_volume *out);
/** Log all tissues that the job names and that are not among the @p labels of its volume, and all
 * names that could stand for several. @return SC_ERR_DATA if there are any. */
sc_status sc_check_tissues(const sc_ctx *ctx, const sc_job *job, const sc_label *labels,
                           int label_count);
/** Find the label table of a volume that has no names, where other programs look for it: for a
 * "..._dseg.nii.gz" of BIDS, a dseg.tsv whose words the name of the volume has, too, beside it or
 * above it in the data set; for an MGH file, FreeSurferColorLUT.txt beside it or in
 * $FREESURFER_HOME. It is told. @param out [SC_PATH_BYTES] its path; empty if there is none. */
void sc_find_labels(const sc_app *app, const char *volume, char *out);
/** Read a label table, or what the header of the volume at @p path says of its labels. @param
 * volume for which it is read, NULL: none; the numbers of a table must not be segcast's own unless
 * those of @p volume are. Caller owns *out: sc_label_table_clear, also after an error. */
sc_status sc_read_label_table(const sc_app *app, const char *path, sc_table_format format,
                              const sc_volume *volume, sc_label_table *out);
/** Free the table and set @p source to zero. */
void sc_label_source_clear(sc_label_source *source);

#endif
