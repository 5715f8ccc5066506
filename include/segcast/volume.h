/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Label volumes: voxels as dense ids, their geometry in patient space and their label table;
 *  readers for NRRD, NIfTI-1, NIfTI-2, MGH, MetaImage, TIFF,
 *  DICOM segmentations and Zarr; a writer for NRRD.
 *
 *  A file that can be read but is hardly a label volume in millimetres gets a warning:
 *  - as a grey-value image, if it has more than 32 labels and runs of equal labels along x are
 *    shorter than two voxels on average, background and the commonest label left out;
 *  - for negative label values;
 *  - for a voxel spacing outside of 1e-6 mm to 100 mm, or spacings that differ by more than 100
 *    times: most likely a wrong unit.
 *  A geometry that cannot be drawn is an error: see sc_geometry_check. */
#ifndef SEGCAST_VOLUME_H
#define SEGCAST_VOLUME_H

#include "segcast/base.h"
#include "segcast/geom.h"

enum {
    SC_LABELS_MAX = 65534, /**< distinct labels, background included: two ids of 16 bits have a
                                meaning of their own where surfaces are found (prepare) */
    SC_NAME_BYTES = 256    /**< longest name of a label, terminator included: a term of SNOMED CT,
                                which has at most 255 bytes, fits */
};

/** One distinct label of a volume, or one row of a label table. */
typedef struct sc_label {
    int64_t value;            /**< as stored in the file */
    char name[SC_NAME_BYTES]; /**< valid UTF-8; empty: none given. What a file has beyond the
                                   room is left out at a whole character, with a warning */
    uint8_t rgb[3];           /**< sRGB */
    bool has_color;           /**< rgb was given by a file; else a volume's label has
                                   sc_label_base_color, or what sc_volume_color gave it */
    bool hidden;              /**< a table says that it is not shown */
    float opacity;            /**< of a boundary, 0 to 1; negative: not given */
} sc_label;

/** Rows of a label table, in the order of the file. Zero-initialise; sc_label_table_clear frees. */
typedef struct sc_label_table {
    sc_label *rows;         /**< [capacity], the first count of which are used; owned */
    size_t count, capacity; /**< in rows */
} sc_label_table;

/** What one label of a volume covers. */
typedef struct sc_label_tally {
    uint64_t voxels;
    int low[3],
        high[3]; /**< bounding box in voxels, inclusive: x, y, z; low > high if there are none */
} sc_label_tally;

/** A segmented volume, or what is known of it without its voxels; owns ids, tallies, labels and the
 *  tables. Zero-initialise; sc_volume_clear frees. */
typedef struct sc_volume {
    int size[3];     /**< voxels along x (fastest), y, z */
    int label_bytes; /**< width of a dense id: 1 for up to 256 labels, else 2 */
    void *ids;       /**< dense ids, [size z][size y][size x]; id 0 is the label 0, background;
                          NULL: not in memory */
    sc_label_tally *tallies; /**< [label_count], of a volume without ids whose voxels were looked
                                at; else NULL */
    int label_count;         /**< background included: 1 to SC_LABELS_MAX */
    sc_label *labels;        /**< by dense id: background, then the other values in rising order */
    sc_affine to_ras_mm;     /**< voxel index (centres at whole numbers) -> patient mm, RAS+ */
    bool oriented;           /**< false: the file does not say where left is; RAS was taken */
    bool numbered; /**< the numbers of its labels are segcast's own: the file names tissues without
                        numbers, or gives one number to several */
    sc_label_table table;  /**< the rows of the file's own label table, as they stand there; none if
                                the volume is numbered */
    sc_label_table absent; /**< tissues that the file names and none of whose voxels was read */
    sc_label_table outside; /**< labels all of whose voxels lie outside of the box that was read; of
                                 formats in chunks, which are not read there, none are known */
    bool is_part;           /**< such a box was read of a format in chunks */
    bool looks_grey;        /**< its values are many and mixed as those of a CT or MR image */
} sc_volume;

/** Check that a volume of @p size voxels may be read and prepared within ctx->memory_max_bytes: its
 *  ids, what is measured on them and the prepared copy take about 4 bytes for each voxel. Files
 * that are compressed well promise more than a machine has. @param more_bytes what reading takes
 * beside that. @return SC_ERR_SYSTEM, logged under @p path with the option that raises the limit.
 */
SC_MUST_USE sc_status sc_volume_memory_check(const sc_ctx *ctx, const char *path, const int size[3],
                                             double more_bytes);

/** Free what the volume owns and set it to zero. A zeroed volume is allowed. */
void sc_volume_clear(sc_volume *volume);
/** @return the dense id of a voxel, by its place in the ids. */
static inline uint32_t sc_volume_id(const sc_volume *volume, size_t voxel)
{
    return volume->label_bytes == 1 ? ((const uint8_t *)volume->ids)[voxel]
                                    : ((const uint16_t *)volume->ids)[voxel];
}
/** Read the dense ids of @p count voxels that follow each other in memory, from index @p voxel on,
 * to to[count]. Any thread. */
static inline void sc_volume_read_ids(const sc_volume *volume, size_t voxel, size_t count,
                                      uint16_t *to)
{
    const uint8_t *from = (const uint8_t *)volume->ids + voxel;
    size_t i = 0;

    if (volume->label_bytes == 2) {
        memcpy(to, (const uint16_t *)volume->ids + voxel, count * sizeof *to);
        return;
    }
    for (; i + 8 <= count; i += 8) { /* one vector each: bytes in memory may change with a store */
        uint8_t eight[8];

        memcpy(eight, from + i, sizeof eight);
        for (int k = 0; k < 8; k++)
            to[i + k] = eight[k];
    }
    for (; i < count; i++)
        to[i] = from[i];
}
/** @return the number of voxels, from the size alone. */
size_t sc_volume_voxels(const sc_volume *volume);
/** @return a hash of ids, label values, size and geometry, independent of names, colours and
 *  file format. It reads all ids. */
uint64_t sc_volume_hash(const sc_volume *volume);

/** What a geometry that is accepted stays within. Rays are marched in single precision, in units of
 *  voxels and of millimetres: SC_EXTENT_MOST_VOXELS keeps the error of a position below 1/32 of a
 *  voxel, and the bounds of the spacing, from a picometre to 100 km, keep areas and volumes in the
 *  range of the numbers. */
#define SC_SPACING_LEAST_MM 1e-9
#define SC_SPACING_MOST_MM 1e8
#define SC_EXTENT_MOST_VOXELS 262144.0
#define SC_ORIGIN_MOST_VOXELS 4e9

/** Check that a volume of @p size voxels with this map from voxels to RAS mm can be drawn: all
 *  numbers are finite; the axes are independent; the voxels measure between SC_SPACING_LEAST_MM and
 *  SC_SPACING_MOST_MM along each axis; no line through the volume is longer than
 *  SC_EXTENT_MOST_VOXELS, counted in voxels of the axis along which it passes most of them (this
 *  bounds the ratio of the spacings and the shear); the origin is at most SC_ORIGIN_MOST_VOXELS
 *  of the smallest spacing away. @return SC_ERR_DATA, logged under @p path with what was found and
 *  expected. */
SC_MUST_USE sc_status sc_geometry_check(const sc_ctx *ctx, const char *path, const int size[3],
                                        const sc_affine *to_ras_mm);

/** Read a label volume. The format is told by content, not by name. Names and colours come from
 *  the file where it has some, else colours depend on the label value alone. A directory with
 *  volume files is one volume: each file is the mask of one tissue, which has the name of the file;
 *  the labels are 1, 2, ... in the order of the names (of their bytes). A directory without such
 * files that holds one DICOM segmentation, be it among the slices of its image, is that
 * segmentation. All masks have one size and geometry, and hold one label beside 0. Where masks
 * overlap, the one with fewer voxels has the voxel, and a warning tells of how many voxels that is
 * so. Caller owns *out: sc_volume_clear. @return SC_ERR_MISSING (also for a directory without
 * volumes), SC_ERR_DATA (logged with what was found, what was expected, and for known other formats
 * how to convert them), SC_ERR_MEMORY. Threads: the libraries behind it keep global state: one call
 * at a time. */
SC_MUST_USE sc_status sc_volume_read(const sc_ctx *ctx, const char *path, sc_volume *out);

/** @return how many bytes of the path of a volume are that of its file: fewer than all if a colon
 *  and a path inside that file follow ("cells.h5:/labels", of HDF5). A file or directory of the
 *  whole name goes before. */
size_t sc_volume_file_length(const char *path);
/** @return how many of the first @p bytes bytes of the name of a volume are left without its
 * endings, such as ".seg.nrrd": at least one. */
size_t sc_volume_stem_bytes(const char *name, size_t bytes);
/** As realpath, of the path of a volume, which may go on inside of its file. @return NULL with
 *  errno. Caller owns: free(). */
char *sc_volume_real_path(const char *path);

/** What a file is, by its first bytes, and the ending of its name where it has no mark. */
typedef enum sc_file_kind {
    SC_FILE_TEXT,   /**< text of no known kind, or it cannot be read */
    SC_FILE_VOLUME, /**< of a format that is read */
    SC_FILE_OTHER   /**< neither; reading it as a volume says what it is and what to do */
} sc_file_kind;
/** @return the kind of a file. */
sc_file_kind sc_file_kind_of(const char *path);
/** Write the names of all formats that this build can read, separated by commas, to text[size], cut
 *  off if there is no room. */
void sc_volume_formats(char *text, size_t size);

/** Which label a voxel gets where masks of a directory, or segments in layers, overlap. */
typedef enum sc_overlap {
    SC_OVERLAP_SMALLER, /**< that of the tissue with fewer voxels; of equal ones, the later */
    SC_OVERLAP_ORDER,   /**< that of the later, by name of the file or number of the segment */
    SC_OVERLAP_NAMES /**< that which a list names first; of those it does not name, as the first */
} sc_overlap;
/** How many voxels one tissue has though another one covers them, too. Where more than two cover a
 *  voxel, each that has lost it counts once. */
typedef struct sc_overlap_pair {
    size_t winner, loser; /**< indices of rows of tissues */
    uint64_t voxels;
} sc_overlap_pair;
/** All pairs of tissues that overlap, most voxels first. Zero-initialise; sc_overlap_list_clear
 *  frees. */
typedef struct sc_overlap_list {
    sc_overlap_pair *pairs; /**< [capacity], the first count of which are used; owned */
    size_t count, capacity;
    sc_label_table tissues; /**< as the file names them */
} sc_overlap_list;
void sc_overlap_list_clear(sc_overlap_list *list);
/** Room for the names of sc_read_choice.overlap_names. */
#define SC_OVERLAP_NAMES_BYTES 1024
/** In what the box of a sc_read_choice is given. */
typedef enum sc_read_box {
    SC_READ_ALL,    /**< there is no box */
    SC_READ_VOXELS, /**< voxels of the level that is read */
    SC_READ_MM      /**< patient space, RAS mm: the voxels whose centres lie in the box */
} sc_read_box;
/** Where the phases of a file (4-D) are kept while they are read one after the other: a file
 *  without a name, to which they are unpacked once. Without it, each phase of a compressed file
 *  costs unpacking all that stands before it. */
typedef struct sc_phase_store sc_phase_store;
/** Make an empty store. @param folder where its file is made when it is needed; copied. @return
 *  SC_ERR_MEMORY. Caller owns *out: sc_phase_store_free. Threads: one at a time, as the reads that
 *  use it. */
SC_MUST_USE sc_status sc_phase_store_new(const sc_ctx *ctx, const char *folder,
                                         sc_phase_store **out);
/** Free the store, and the file with it; NULL is allowed. */
void sc_phase_store_free(sc_phase_store *store);

/** What is kept of a volume file. */
typedef enum sc_read_depth {
    SC_READ_IDS,     /**< the voxels */
    SC_READ_TALLIES, /**< what labels cover, from one pass over the voxels in bounded memory (a few
                          MB; masks of a directory take up to 2.25 bytes for each voxel; NRRD files
                          in a rare form, in encoding ascii, hex or bzip2, in several data files or
                          counted from the end of a compressed file, are read whole by Teem first)
                      */
    SC_READ_HEADER   /**< the header: the labels are background and those that the file's own label
                          table names, which need not occur in the voxels; damage behind the header
                          is not noticed */
} sc_read_depth;
/** What of a volume file is read. Zeroed: all of it, in its finest resolution. */
typedef struct sc_read_choice {
    sc_read_depth depth;       /**< but for it, names, colours, warnings and errors are the same */
    sc_overlap overlap;        /**< of masks and segments */
    const char *overlap_names; /**< SC_OVERLAP_NAMES: names or globs (* ? [...]) of tissues, each
                                  ended by a newline; borrowed */
    int level;                 /**< of resolution of an OME-Zarr image, 0 the finest */
    int phase;                 /**< which volume of a file that holds those of several phases (4-D),
                                    counted from 1; 0: such a file is refused */
    sc_phase_store *store; /**< for those who read several phases of a file; borrowed; NULL: none */
    sc_read_box box;
    int voxels[3][2];   /**< SC_READ_VOXELS: along x, y, z the first voxel, and the one behind the
                             last */
    sc_vec3 corners[2]; /**< SC_READ_MM: two opposite corners */
    const char
        *header;      /**< what the user says of spacing and axes, and of a file without a header of
                           type and size, too (header_line.c); borrowed; NULL or empty: nothing */
    double threshold; /**< of a directory of soft masks: a voxel belongs to a tissue from this share
                         of the largest value of its file on; 0: masks hold one value beside 0 */
    const char *where; /**< "file:line" for messages; NULL: none */
    bool is_image;     /**< a grey volume is read: for messages */
    /** Called if tissues may overlap: set left_out[i], which are all false, for those rows of @p
     * table whose tissues shall not take voxels from others. They are labels of the volume, without
     * voxels. @param numbered as of sc_volume. NULL: all count. */
    sc_status (*leave_out)(void *user, const sc_label_table *table, bool numbered, bool *left_out);
    void *user; /**< of leave_out; borrowed */
    sc_overlap_list
        *overlaps; /**< where overlaps are noted, instead of what it holds; NULL: nowhere
                    */
} sc_read_choice;
/** Find how many phases a volume file holds (4-D), from its header: 1 also for a file that is
 *  missing or broken, without a message. @param step_s the time from one to the next; 0 if there is
 *  one, or the file does not say. @return SC_ERR_MEMORY, or that another part of the machine
 *  failed, logged. Threads as of sc_volume_read. */
SC_MUST_USE sc_status sc_volume_phases(const sc_ctx *ctx, const char *path, int *count,
                                       double *step_s);
/** As sc_volume_read, of a part or another resolution. The volume is as if its file held nothing
 *  else: labels that occur elsewhere are not among its labels, and voxels stay where they were in
 *  patient space. Of a Zarr store or a HDF5 file only those chunks are read in which the box has
 * voxels; files of other formats are read as a whole, but only the box is kept. @return also
 * SC_ERR_DATA for a level that the file has not, and for a box that lies outside of the volume, or
 * in voxels reaches beyond it. */
SC_MUST_USE sc_status sc_volume_read_by(const sc_ctx *ctx, const char *path,
                                        const sc_read_choice *choice, sc_volume *out);

/** Append to @p out, each with a NUL byte behind it, the paths of the files that a volume is read
 * from: its own, those that its header names for the voxels, the masks of a directory; of a store
 * of Zarr, N5 or Neuroglancer all that it holds, but none if that is more than @p store_most_bytes.
 * A file may be listed twice. No message, for a volume that is missing or broken. @return
 * SC_ERR_MEMORY, or that another part of the machine failed, logged. Threads as of sc_volume_read.
 */
SC_MUST_USE sc_status sc_volume_files(const sc_ctx *ctx, const char *path,
                                      uint64_t store_most_bytes, sc_text *out);
/** Set *out to whether @p path is one of these files, by whatever symbolic or hard links. */
SC_MUST_USE sc_status sc_volume_reads(const sc_ctx *ctx, const char *volume, const char *path,
                                      bool *out);

/** Write a volume, with its ids, as NRRD, gzip-compressed, with the label names and colours in
 *  the keys that 3D Slicer uses for segmentations (Segment0_Name and so on; none for
 *  background). The voxels are written as label values in the narrowest integer type that holds
 *  them. The file gets its name only when it is complete. @param replace as of
 *  sc_outfile_open. @return
 *  SC_ERR_CREATE, SC_ERR_WRITE, SC_ERR_MEMORY; what was under @p path before stays then. */
SC_MUST_USE sc_status sc_volume_save_nrrd(const sc_ctx *ctx, const sc_volume *volume,
                                          const char *path, bool replace);

/** The phases of a series, which are made one after the other. */
typedef struct sc_volume_series {
    int count;     /**< of phases, at least 1 */
    double step_s; /**< from one to the next */
    /** Make a phase, counted from 0; all have the same grid and labels. Owned by who called. */
    sc_status (*make)(void *user, int phase, sc_volume *out);
    void *user;
} sc_volume_series;
/** As sc_volume_save_nrrd, of all phases of a series in one file: the fourth axis, of kind time, is
 *  the slowest. Two volumes are held at a time at most. @return the errors of make, too. */
SC_MUST_USE sc_status sc_volume_save_series_nrrd(const sc_ctx *ctx, const sc_volume_series *series,
                                                 const char *path, bool replace);

/** How a label table is written: one label a line, XML, columns with headings, or JSON. */
typedef enum sc_table_format {
    SC_TABLE_AUTO,       /**< to be guessed from the text */
    SC_TABLE_SLICER,     /**< id name R G B A, A = opacity, 0 to 255 */
    SC_TABLE_FREESURFER, /**< id name R G B T, T = transparency, 0 to 255 */
    SC_TABLE_ITKSNAP,    /**< id R G B A VIS MSH "name", A = opacity, 0 to 1 */
    SC_TABLE_XML,        /**< the first LabelTable of a document of GIFTI or Connectome Workbench,
                              levels from 0 to 1, the data of an atlas of FSL, or the labelset of
                              BrainSuite: attributes of labels, and elements in them, are columns */
    SC_TABLE_DELIMITED,  /**< a line of headings, as "value,name,color", and a line for each label,
                              separated by commas, semicolons or tabs: BIDS, 3D Slicer, spreadsheets.
                              Levels go from 0 to 1 if none is above 1, else to 255; those in a
                            column  "opacity" are percent if none is above 100 */
    SC_TABLE_JSON,       /**< Neuroglancer, OME-Zarr, NiiVue, nnU-Net; lists of objects, and maps
                              between numbers and names; levels as of SC_TABLE_DELIMITED */
    SC_TABLE_WORKBENCH,  /**< as `wb_command -volume-label-export-table` writes it: a line with the
                              name, and below it key R G B A, 0 to 255, A = opacity */
    SC_TABLE_NAMES /**< a number and a name, such as "1 spleen", "1,spleen" or the class lists of
                        TotalSegmentator in Python: 1: "spleen", */
} sc_table_format;

/** Free the rows and set the table to zero. */
void sc_label_table_clear(sc_label_table *table);
/** Append a copy of @p row. @return SC_ERR_MEMORY, the table unchanged. */
SC_MUST_USE sc_status sc_label_table_add(const sc_ctx *ctx, sc_label_table *table,
                                         const sc_label *row);
/** Read a label table, a text of at most 64 MiB (JSON: 16) and 1,048,576 rows, in UTF-8, UTF-16
 * with byte order mark, or Latin-1. SC_TABLE_AUTO guesses the format and logs which. Rows of label
 * 0 are left out; lines of another form, too, with a warning. A value may have several rows. Caller
 * owns *out: sc_label_table_clear. @return SC_ERR_MISSING; SC_ERR_DATA if no line has the form of
 * the table (with the first line, unless the file is empty) or the file is no such text;
 * SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_label_table_read(const sc_ctx *ctx, const char *path,
                                          sc_table_format format, sc_label_table *out);
/** Write the words of a name, by which names are compared: ASCII letters in lower case, a single
 *  blank where blanks, "_" or "-" separate words, and none at its ends. */
void sc_words_of_name(const char *name, char out[SC_NAME_BYTES]);
/** How well the name of a label fits a pattern. Of the labels of a volume a pattern means those
 * that fit it best. */
typedef enum sc_match {
    SC_MATCH_NONE,
    SC_MATCH_WORDS, /**< ASCII case ignored, and whether blanks, "_" or "-" separate words */
    SC_MATCH_CASE,  /**< ASCII case ignored */
    SC_MATCH_EXACT  /**< the same bytes, the number of the label, or the pattern "*" */
} sc_match;
/** A pattern, taken apart for comparing: a whole number means the label of that value only, "*"
 *  (or "**") every label, and everything else a name or a glob for names (* ? [...]), which a label
 * without a name never fits. */
typedef struct sc_pattern {
    char text[SC_NAME_BYTES], folded[SC_NAME_BYTES], words[SC_NAME_BYTES]; /**< by sc_match */
    bool is_number, is_all, is_glob;
    long long number;
} sc_pattern;
/** @return the pattern that is written as @p text, which is shorter than SC_NAME_BYTES. */
sc_pattern sc_pattern_of(const char *text);
/** @return how well a label fits. */
sc_match sc_label_match(const sc_label *label, const sc_pattern *pattern);
/** @return how well that label fits that fits best. @param labels [label_count], background first,
 *  which is skipped. The pattern means the labels for which sc_label_match gives the same, unless
 *  that is SC_MATCH_NONE. */
sc_match sc_pattern_match(const sc_label *labels, int label_count, const sc_pattern *pattern);
/** @return whether the name of a label leads to it alone in a job; otherwise its number has to.
 *  @param labels [label_count], background first. */
bool sc_label_name_is_clear(const sc_label *labels, int label_count, int id);
/** Append a label to a list for a message: its name, or else its number; of more than 8 labels
 * "..." follows.
 *  @param before how many labels stand there. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_label_list_add(const sc_ctx *ctx, sc_text *list, size_t before,
                                        const sc_label *label);
/** @return the label of a volume with this value, borrowed from the volume; NULL if there is none.
 *  Background is not found. */
sc_label *sc_volume_label(const sc_volume *volume, int64_t value);
/** Give the labels of @p volume what the rows with their values hold: name, colour and opacity
 *  if the row has them, and hidden in any case. The first row of a value wins. Rows of values
 *  that the volume has not, or of 0, are ignored. */
void sc_volume_apply_table(sc_volume *volume, const sc_label_table *table);
/** Give @p volume also those labels of the rows that it has not, sorted in, and then apply the
 *  table. For a volume without voxels (SC_READ_HEADER), since dense ids change; it has
 *  background at least. @return SC_ERR_MEMORY, the volume unchanged. */
SC_MUST_USE sc_status sc_volume_add_labels(const sc_ctx *ctx, sc_volume *volume,
                                           const sc_label_table *table);
/** Turn the voxels of some labels into background in the ids; the labels themselves stay in the
 *  table. @param hidden [label_count] by dense id; that of background does not matter.
 *  @param threads as of sc_parallel_for. */
void sc_volume_hide(sc_volume *volume, const bool *hidden, int threads);

/** New labels instead of old ones. Zero-initialise; sc_relabel_clear frees. */
typedef struct sc_relabel {
    int *to;          /**< [old labels] the new dense id of each; owned */
    sc_label *labels; /**< [label_count], background first, then by rising value; owned */
    int label_count;
} sc_relabel;
/** Leave out labels and merge labels into others.
 *  @param labels [count] of a volume, background first.
 *  @param into [count] by dense id, what becomes of a label: itself, 0 for background, or another
 *  label that stays itself. into[0] is 0.
 *  @param names [count] new names of labels that others are merged into; NULL: as before. A label
 *  without a colour gets that of the first one merged into it that has one. Values stay.
 *  @return SC_ERR_MEMORY. Caller owns *out. */
SC_MUST_USE sc_status sc_relabel_make(const sc_ctx *ctx, const sc_label *labels, int count,
                                      const int *into, const char *const *names, sc_relabel *out);
void sc_relabel_clear(sc_relabel *relabel);
/** Give labels beside themselves those of the rows of a table that they lack, without voxels.
 *  @param labels [label_count] of a volume, background first. @return SC_ERR_MEMORY. Caller owns
 *  *out. */
SC_MUST_USE sc_status sc_relabel_with(const sc_ctx *ctx, const sc_label *labels, int label_count,
                                      const sc_label_table *more, sc_relabel *out);
/** Give a volume new labels: ids become others, and tallies are added up. Takes the labels of
 *  @p relabel, which keeps its ids. @param threads as of sc_parallel_for. @return SC_ERR_MEMORY, of
 *  ids if they have to become wider, for more labels than before; nothing has changed then. */
SC_MUST_USE sc_status sc_volume_relabel(const sc_ctx *ctx, sc_volume *volume, sc_relabel *relabel,
                                        int threads);
/** Find for each row of a table the label that it names, by the words of the names
 *  (sc_words_of_name); of several rows of a name the first has the label. @param label_of
 *  [table->count] set to dense ids; 0: none. @param found how many rows have one. @return
 *  SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_label_table_match(const sc_ctx *ctx, const sc_label *labels,
                                           int label_count, const sc_label_table *table,
                                           int *label_of, size_t *found);
/** Give labels the numbers of the rows that name them (sc_label_table_match), so that the table and
 *  they agree by number; labels without a row get the least numbers from 1 on that no row has.
 *  @param labels [label_count] of a volume, background first. @return SC_ERR_MEMORY. Caller owns
 *  *out. */
SC_MUST_USE sc_status sc_relabel_by_table(const sc_ctx *ctx, const sc_label *labels,
                                          int label_count, const sc_label_table *table,
                                          const int *label_of, sc_relabel *out);
/** The reverse: give rows the numbers of the labels that they name, and leave out those that name
 *  none. */
void sc_label_table_number(const sc_label *labels, const int *label_of, sc_label_table *table);

/** A box of voxels, inclusive: low > high along all axes if it holds none. */
typedef struct sc_voxel_box {
    int low[3], high[3];
} sc_voxel_box;
/** @return the box of all voxels whose centres lie in the box between two corners in RAS mm; low >
 *  high along an axis if there are none. @param size, to_ras_mm those of the volume; the map has an
 *  inverse. */
sc_voxel_box sc_voxels_between(const int size[3], const sc_affine *to_ras_mm,
                               const sc_vec3 corners[2]);
/** @return the smallest box with all voxels of some labels. @param which [label_count] by dense id;
 * that of background is not read. One thread reads all ids. */
sc_voxel_box sc_volume_box(const sc_volume *volume, const bool *which);
/** Keep only the voxels of @p box, which lies within the volume and is not empty. The labels stay,
 * and each voxel stays where it was in patient space. Boxes of tallies are cut off at @p box; how
 * many voxels labels have beyond it is not known, so that numbers stay what they were where a label
 * reaches into the box, and become 0 where it does not. */
void sc_volume_crop(sc_volume *volume, const sc_voxel_box *box);
/** Write the colour that a label value has in the palette to @p rgb (sRGB). The palette has 24
 *  colours that sit together: about the same chroma, five steps of lightness, and as far apart as
 *  possible for everybody, the colour-blind included. Values from 1 to 24 have them in their order,
 *  which then begins again. */
void sc_label_base_color(int64_t value, uint8_t rgb[3]);
/** @return a label with sc_label_base_color and no more than its value. */
sc_label sc_label_new(int64_t value);
/** What names are about: abbreviations mean other things in a heart (LA) and in a brain (SMA). */
typedef enum sc_names_kind { SC_NAMES_BODY, SC_NAMES_HEART, SC_NAMES_BRAIN } sc_names_kind;
/** @return the kind of the names of @p labels [count], background first: of a brain if half of
 * those that have one are of its parts, or if none has one and their numbers are FreeSurfer's; of a
 * heart if left and right ventricle (LV, RV) are among them. */
sc_names_kind sc_names_kind_of(const sc_label *labels, int count);
/** Find the colour that anatomists expect of a tissue, by the words of its name, in English or
 * Latin, however they are written together: "Left-Lateral-Ventricle", "heart_atrium_left",
 * "LeftLung". @param rgb sRGB; set if there is one. @return whether there is one. */
bool sc_anatomy_color(const char *name, sc_names_kind kind, uint8_t rgb[3]);
/** What the words of its name say of a tissue: one among others, the outside of all others (skin),
 * or what is left over (other, rest, unclassified). */
typedef enum sc_name_role { SC_NAME_PART, SC_NAME_OUTSIDE, SC_NAME_REST } sc_name_role;
sc_name_role sc_name_role_of(const char *name);
enum { SC_NAME_KEY_BYTES = 4 * SC_NAME_BYTES };
/** Write the words of a name in English without those of its side, numbers with leading zeros, so
 * that both sides of a pair have the same, and members of a series are in their order. */
void sc_name_without_side(const char *name, sc_names_kind kind, char out[SC_NAME_KEY_BYTES]);
/** Which colours the tissues of a volume get. */
typedef enum sc_appearance {
    SC_APPEARANCE_TABLE,   /**< those of the table; those that it does not colour as below */
    SC_APPEARANCE_ANATOMY, /**< those of sc_anatomy_color where there are some, else of the table,
                              or of the palette */
    SC_APPEARANCE_DISTINCT /**< those of the palette */
} sc_appearance;
enum { SC_COLORED_LABELS_MAX = 1024 /**< of volumes with more, sc_volume_color does nothing */ };
/** @return whether sc_volume_color has anything to do: labels without a colour from a table, or
 *  with one that @p appearance does not want. */
bool sc_volume_lacks_colors(const sc_volume *volume, sc_appearance appearance);
/** Give the labels that no table gives a colour, or not one that @p appearance wants, their
 * colours. Those that anatomists know by name get that of sc_anatomy_color, or a shade of it where
 * they touch others like it. The others get one of the palette, so that those that touch or lie
 * near each other can be told apart, by everybody, and colours repeat as little as possible: that
 * of the label's value unless a label of a smaller value, or one whose colour is given or that of
 *  anatomy, that it touches, or that is near it, looks much like it. @param cover dense id of a
 *  tissue that encloses the others (sc_find_outer_cover), which gets a pale colour of its own
 *  instead of one of the palette; 0: none. @param threads as of sc_parallel_for; the result does
 * not depend on it. @return SC_ERR_MEMORY, the volume unchanged. */
SC_MUST_USE sc_status sc_volume_color(const sc_ctx *ctx, sc_volume *volume, int cover,
                                      sc_appearance appearance, int threads);
/** A voxel and its 26 neighbours, x fastest, and the place of the voxel itself among them. */
enum { SC_AROUND = 27, SC_AROUND_CENTRE = 13 };
/** What a sheet of tissue one voxel thick keeps apart: voxels of different labels, of the same, or
 * both. */
enum { SC_APART_LABELS = 1, SC_APART_SAME_LABEL = 2 };
/** @return what a voxel keeps apart as one of a sheet, by the dense ids around it: SC_APART_* bits;
 * 0 if it is none, or if it has one label on both sides and lies flat, so that nothing can show
 * through. A voxel belongs to a sheet if those of its neighbours that carry other labels fall into
 * two or more parts that touch its faces and are not connected with each other by faces. */
int sc_sheet_keeps_apart(const uint32_t ids[SC_AROUND]);

#endif
