/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: a volume file whose header has been read, and the stream of its voxels. A
 * format's reader fills an sc_source; everything after that is common to all formats. */
#ifndef SC_VOLUME_SOURCE_H
#define SC_VOLUME_SOURCE_H

#include "bytes.h"
#include "segcast/volume.h"

#include <dirent.h>

/* How one voxel is stored. The readers' tables of type names are in this order. */
typedef enum sc_voxel_type {
    SC_VOXEL_INT8,
    SC_VOXEL_UINT8,
    SC_VOXEL_INT16,
    SC_VOXEL_UINT16,
    SC_VOXEL_INT32,
    SC_VOXEL_UINT32,
    SC_VOXEL_INT64,
    SC_VOXEL_UINT64,
    SC_VOXEL_FLOAT,
    SC_VOXEL_DOUBLE
} sc_voxel_type;
enum { SC_VOXEL_TYPES = SC_VOXEL_DOUBLE + 1 };

/* How the voxels are stored in the file that holds them. */
typedef enum sc_encoding {
    SC_ENCODING_LOADED, /* a library has read all of them into memory (rare encodings) */
    SC_ENCODING_PLAIN,
    SC_ENCODING_GZIP,  /* gzip members one after the other, or bytes that are not compressed */
    SC_ENCODING_ZLIB,  /* one zlib or gzip stream */
    SC_ENCODING_SLICES /* sc_voxel_reader.read_slices unpacks whole slices */
} sc_encoding;

/* Which of several tissues has a voxel. */
typedef struct sc_overlap_rule {
    sc_overlap overlap;
    int *ranks; /* SC_OVERLAP_NAMES: [rows of the table] the place of each in the list, INT_MAX if
                   it is not there; owned; else NULL */
    bool *left_out; /* [rows of the table]: has no voxels, whatever the file says; owned */
} sc_overlap_rule;

/* What was found out about overlaps. Zero-initialise; sc_overlap_count_clear frees. */
typedef struct sc_overlap_count {
    uint64_t voxels;       /* that more than one tissue covers */
    bool *covers;          /* [rows of the table] has voxels, somewhere in the file; owned */
    bool *lost;            /* [rows of the table] a voxel that it covers is another's; owned */
    sc_overlap_list pairs; /* without tissues, in any order; empty if there are too many to count */
} sc_overlap_count;

struct sc_source;
/* Unpack slices [first, first + count) of a source to @p out, x fastest, in the byte order that
 * source->stored.swapped tells. The stream asks for them in rising order, each once, and for no
 * more than source->reader.slices at a time. @return SC_ERR_DATA, SC_ERR_MISSING, SC_ERR_WRITE,
 * SC_ERR_MEMORY, all logged under @p path or that of a file of the volume. */
typedef sc_status sc_slices_fn(const sc_ctx *ctx, const char *path, const struct sc_source *source,
                               int first, int count, void *out);

/* Read the voxels of a source, in which tissues may overlap, into its data, as labels; sets
 * encoding, type, data and release. Where they overlap, @p rule decides, and a warning tells of
 * it. @return the errors of sc_load_masks. */
typedef sc_status sc_load_fn(const sc_ctx *ctx, const char *path, const sc_overlap_rule *rule,
                             struct sc_source *source);

/* How and where the voxels are stored. */
typedef struct sc_stored_voxels {
    sc_encoding encoding;
    char *file;            /* path of the file with the voxels, owned; NULL if loaded */
    sc_text data_files;    /* paths of all files with voxels that the header names, each with a NUL
                              byte behind it; empty where file is the only one; owned */
    uint64_t offset_bytes; /* where in the file they begin */
    uint64_t skip_bytes;   /* gzip: bytes to skip in what is unpacked from there */
    bool swapped;          /* in the byte order that this machine does not have */
    FILE *unpacked; /* SC_ENCODING_PLAIN: the voxels are in this file of a store; borrowed; NULL:
                       in file */
} sc_stored_voxels;

/* Voxels that a reader loads or unpacks by itself. */
typedef struct sc_voxel_reader {
    void *data; /* SC_ENCODING_LOADED: the voxels, x fastest, in this byte order, owned;
                   NULL if only the header was asked for. SC_ENCODING_SLICES: what
                   read_slices works on, owned */
    void (*release)(void *data); /* frees data; NULL: nothing to free */
    sc_slices_fn *read_slices;   /* SC_ENCODING_SLICES: data is what it works on */
    int slices;                  /* SC_ENCODING_SLICES: how many are read at a time, at least 1 */
    int first_slices;            /* how many instead the first time; 0: as many */
} sc_voxel_reader;

/* The volumes in a file, of which a source is one (4-D). */
typedef struct sc_series {
    int count;         /* 0 and 1: one */
    bool side_by_side; /* the values of all of a voxel follow each other; else one volume follows
                          the other */
    double step_s;     /* from one to the next; 0: the file does not say */
    int phase;         /* that which is read, from 1; 0: all of them, or there is one */
} sc_series;

/* A directory of masks. */
typedef struct sc_mask_files {
    struct sc_mask *masks; /* [count], else NULL; owned */
    size_t count;
    double threshold; /* as in sc_read_choice */
} sc_mask_files;

/* A volume file after its header has been read. Zero-initialise; sc_source_clear frees. */
typedef struct sc_source {
    int size[3];         /* voxels along x (fastest), y, z */
    int low[3], part[3]; /* the first voxel that is wanted, and how many along x, y, z;
                            sc_source_cut sets them */
    sc_voxel_type type;
    double slope, intercept; /* label = slope * stored + intercept; 1 and 0 change nothing */
    sc_affine to_ras_mm;     /* as in sc_volume */
    bool oriented;           /* as in sc_volume */
    bool numbered;           /* likewise */
    bool is_part;            /* the file has voxels outside of part, which nobody looks at */
    sc_label_table table;    /* what the file itself says about its labels */
    sc_stored_voxels stored;
    sc_voxel_reader reader;
    sc_series series;
    sc_load_fn *load;            /* NULL: nothing overlaps, or masks or layers do */
    int layers;                  /* values of each voxel, side by side in the file; 0 and 1: one */
    struct sc_segment *segments; /* [table.count] if there are several layers, else NULL; owned */
    sc_mask_files mask_files;
    sc_overlap_count overlaps; /* voxels that several tissues claim; counted while loading */
} sc_source;

/* Which value in which layer is the tissue of a row of the table. */
typedef struct sc_segment {
    int layer;
    int64_t value;
    size_t row;
} sc_segment;

/* One tissue of a directory of masks. The row of the table with the same index has its name. */
typedef struct sc_mask {
    char *file;      /* path, owned by the source */
    uint64_t voxels; /* set by sc_load_masks */
    int size[3];     /* of the file, along its own axes */
    int axis[3];     /* along which axis of the source each of these leads */
    bool flip[3];    /* from its end to its begin */
    int low[3];      /* where in the source its box begins, by the axes of the source */
} sc_mask;

/* Free the voxels, the file name and the table, and zero the source. A zeroed source is
 * allowed. */
void sc_source_clear(sc_source *source);
/* @return where a choice is from, for messages: the line of a job, or else the volume. */
static inline const char *sc_read_where(const sc_read_choice *choice, const char *path)
{
    return choice->where && choice->where[0] ? choice->where : path;
}
/* Let a source have the labels [part] in memory in the place of the voxels of its file, and only
 * the part that was wanted. @param labels which the source owns now: sc_free. */
void sc_source_set_labels(sc_source *source, sc_voxel_type type, void *labels);
/* Set which voxels of a source are wanted, by its size and geometry. @return SC_ERR_DATA, logged,
 * for a box that lies outside, or in voxels reaches beyond them. */
sc_status sc_source_cut(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                        sc_source *source);
/* Make a source of the whole volume, from which parts can be read alone, one of the part that is
 * wanted. @param low receives its first voxel. @return the errors of sc_geometry_check and
 * sc_source_cut. */
sc_status sc_source_take_part(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                              int low[3], sc_source *source);
/* Of a source of several phases, whose size is that of one: let it be of that which is chosen, and
 * fill the store of the choice where that saves time. @return SC_ERR_DATA, logged, for a phase that
 * the file has not, or if none is chosen; the errors of reading. */
sc_status sc_source_choose_phase(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                                 bool header_only, sc_source *source);
/* @return the geometry of the voxels that are wanted. */
sc_affine sc_source_part_to_ras(const sc_source *source);
/* Number of voxels; size must be set. */
size_t sc_source_voxels(const sc_source *source);
/* Bytes of one voxel as stored. */
size_t sc_voxel_type_bytes(sc_voxel_type type);

/* How many names of labels a file has that had to be mended, and the first of them, mended; and how
 * many levels of colour and opacity, and the first of them, as it stands there. */
typedef struct sc_name_count {
    int mended;
    char first[SC_NAME_BYTES];
    int levels;
    double first_level;
} sc_name_count;
/* Copy a label's name to out[SC_NAME_BYTES] by sc_copy_name, and count it in @p count if bytes of
 * it were replaced or left out. */
void sc_name_read(const char *from, char *out, sc_name_count *count);
/* Bring a level into the range from 0 to @p most, and count it if it was outside, or, if @p whole,
 * a fraction, which is rounded. @return the level. */
double sc_level_mend(double level, double most, bool whole, sc_name_count *count);
/* Log one warning for all names that were mended, and one for levels; nothing if there are none. */
void sc_name_warn(const sc_ctx *ctx, const char *path, const sc_name_count *count);

/* Check that voxels, of labels or of an image, may take so many bytes of memory. @return
 * SC_ERR_SYSTEM, logged with the option that raises the limit. */
sc_status sc_voxels_memory_check(const sc_ctx *ctx, const char *path, const int size[3],
                                 double bytes);

/* Most bytes a volume may have once read, whatever its header claims. */
#define SC_VOLUME_BYTES_MAX ((uint64_t)1 << 40)
/* A deflate stream cannot expand by more than this (zlib's technical details: 1032 to 1). */
#define SC_DEFLATE_RATIO_MAX 1032.0

/* Write the size of a grid to @p out_size, and the number of its voxels to *out, which may be NULL.
 * SC_ERR_DATA (logged under @p path) if a size is below 1 or above INT32_MAX, or if the voxels take
 * more than SC_VOLUME_BYTES_MAX. */
sc_status sc_grid_voxels(const sc_ctx *ctx, const char *path, const int64_t size[3],
                         size_t bytes_per_voxel, int out_size[3], size_t *out);

/* @return why a name in a header is refused, whatever file it leads to: static text, for the end of
 * a message; NULL if nothing is wrong with it. */
const char *sc_bad_name(const char *name);

/* Make the path of a file that the header @p header names in its field @p field as @p name,
 * relative to the folder of the header. SC_ERR_DATA (logged with what to do) unless it is a regular
 * file in that folder or below it: absolute paths, ".." and links that lead out of the folder, and
 * "-", are refused. A header that is itself a link (the user named it) has two folders: that of the
 * link and that of the file. *bytes is the size of the file. Caller owns *out: sc_free. @return
 * also SC_ERR_MEMORY. */
sc_status sc_data_file(const sc_ctx *ctx, const char *header, const char *field, const char *name,
                       char **out, uint64_t *bytes);

/* What is in a directory, but for hidden entries, some of which macOS leaves behind; rising by the
 * bytes of the names, so that nothing depends on the file system. Zero-initialise. */
typedef struct sc_entries {
    struct dirent **list; /* [count] */
    int count;
} sc_entries;
/* List a directory. @return SC_ERR_MISSING and others of sc_input_status, SC_ERR_MEMORY, logged.
 * Caller owns *out: sc_entries_clear. */
sc_status sc_entries_list(const sc_ctx *ctx, const char *directory, sc_entries *out);
void sc_entries_clear(sc_entries *entries);

/* @return how many mm a unit of length has that a header calls @p name: "mm", "microns", "um" or
 * "micrometer"; the Greek letter may also be written as \u00B5, as ImageJ does; 0 for what is no
 * known unit. */
double sc_length_unit_mm(const char *name);
/* The same of a unit of time, in seconds. */
double sc_time_unit_s(const char *name);
/* Warn that a file does not say how large its voxels are. @param key that would tell it. */
void sc_warn_without_spacing(const sc_ctx *ctx, const char *path, const char *key);

/* A pattern of numbered names: before, a number of at least @c width digits, and after. The texts
 * are borrowed from the header. */
typedef struct sc_name_pattern {
    const char *before, *after;
    int width;
    bool zeros; /* zeros, not blanks, in front of the number */
} sc_name_pattern;
/* Read a pattern such as "slice%03d.raw", which is changed. @return false if it is none, or if its
 * numbers would have more than 100 digits. */
bool sc_name_pattern_read(char *text, sc_name_pattern *out);
/* Write the name with a number to @p name, which is emptied before. @return SC_ERR_MEMORY. */
sc_status sc_name_pattern_write(const sc_ctx *ctx, const sc_name_pattern *pattern, long long number,
                                sc_text *name);

/* Open a file for reading. Caller owns *out: sc_fclose_at. @return SC_ERR_MISSING, logged. */
sc_status sc_open_input(const sc_ctx *ctx, const char *path, FILE **out);
/* Find how many bytes a file has. @return as sc_open_input. */
sc_status sc_input_bytes(const sc_ctx *ctx, const char *path, uint64_t *bytes);
/* Read the first @p bytes bytes of a file, unpacked if it is a gzip file, to @p out. *count is how
 * many there are. @return SC_ERR_MISSING; SC_ERR_DATA for fewer than @p least, the bytes of a
 * header of @p format; SC_ERR_MEMORY, SC_ERR_WRITE. */
sc_status sc_read_header_bytes(const sc_ctx *ctx, const char *path, const char *format, void *out,
                               size_t bytes, size_t least, size_t *count);
/* Find which type @p name means, one of names[SC_VOXEL_TYPES], in the order of the types; NULL:
 * int8 to uint64, float32, float64. @return false if it is none. */
bool sc_voxel_type_named(const char *name, const char *const *names, sc_voxel_type *out);
/* The same of a number; -1 stands for types that the format has not. */
bool sc_voxel_type_coded(int code, const int codes[SC_VOXEL_TYPES], sc_voxel_type *out);
/* @return whether voxels of a type, of integers, can have a value. */
bool sc_voxel_type_fits(sc_voxel_type type, int64_t value);
/* @return whether voxels of a type are integers. */
bool sc_voxel_type_is_integer(sc_voxel_type type);

/* Check that a file, which may be a gzip file, can hold @p needed bytes even if it is compressed as
 * well as possible. @return SC_ERR_DATA if not; SC_ERR_MISSING if it cannot be opened,
 * SC_ERR_MEMORY; all logged. */
sc_status sc_check_file_bytes(const sc_ctx *ctx, const char *path, double needed);

/* Read and check the header of a file, whose first bytes are those of the format (sc_open_file: of
 * any of them, else it is refused with advice), and fill *out,
 * which the caller owns (sc_source_clear); *out is untouched after an error. The voxels
 * themselves are left in the file, except those of encodings which only a library can read. @p
 * header_only: voxels will not be asked for, so these are not read either, and data stays NULL.
 * @return SC_ERR_MISSING, SC_ERR_DATA, SC_ERR_MEMORY, all logged. */
sc_status sc_open_file(const sc_ctx *ctx, const char *path, bool header_only, sc_source *out);
sc_status sc_open_nrrd(const sc_ctx *ctx, const char *path, bool header_only, sc_source *out);
sc_status sc_open_nifti(const sc_ctx *ctx, const char *path, sc_source *out);
sc_status sc_open_mgh(const sc_ctx *ctx, const char *path, sc_source *out);
sc_status sc_open_tiff(const sc_ctx *ctx, const char *path, sc_source *out);
/* A label field of Amira or Avizo. */
sc_status sc_open_amira(const sc_ctx *ctx, const char *path, sc_source *out);
/* A DICOM segmentation. */
sc_status sc_open_dicom(const sc_ctx *ctx, const char *path, sc_source *out);
/* As the others, of a directory of Zarr or N5: sc_zarr_is_node, sc_n5_is_node. The source is the
 * part that @p read wants, of the level that it wants: SC_ERR_DATA also if there is no such level
 * or part. */
sc_status sc_open_zarr(const sc_ctx *ctx, const char *path, const sc_read_choice *read,
                       bool header_only, sc_source *out);
/* Is the directory @p path one of Neuroglancer's precomputed format, by its file "info"? */
bool sc_is_precomputed(const char *path);
/* As sc_open_zarr, of such a directory. */
sc_status sc_open_precomputed(const sc_ctx *ctx, const char *path, const sc_read_choice *read,
                              bool header_only, sc_source *out);
/* Is @p path a HDF5 file, or one with a path inside? By its mark. */
bool sc_is_hdf5(const char *path);
/* As sc_open_zarr, of such a file; of several resolutions it knows nothing. @return also
 * SC_ERR_SYSTEM if the program that reads it cannot be started. */
sc_status sc_open_hdf5(const sc_ctx *ctx, const char *path, const sc_read_choice *read,
                       bool header_only, sc_source *out);
sc_status sc_open_meta(const sc_ctx *ctx, const char *path, sc_source *out);
/* Check the header line of a choice, if it has one. *is_raw: it describes a file without a header,
 * as it names a type. @return SC_ERR_DATA, logged. */
sc_status sc_header_check(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                          bool *is_raw);
/* Give a source the spacing and axes that the header line of a choice says, instead of those of its
 * file, and tell so. @return SC_ERR_DATA, logged. */
sc_status sc_header_apply(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                          sc_source *source);
/* Open a file without a header by the line in read->header, and check that it has as many bytes as
 * that says; it may be a gzip file. @return the errors of sc_open_file. */
sc_status sc_open_raw(const sc_ctx *ctx, const char *path, const sc_read_choice *read,
                      sc_source *out);
/* @return whether a file, by its first bytes, is a volume of a format that has a mark. */
bool sc_is_volume_file(const char *path);
/* Does a gzip file begin at this byte of the file? False also if it cannot be read. */
bool sc_is_gzip(const char *path, uint64_t offset);

/* Read the header of a file of any format, of a Zarr store, or of a directory of masks, into *out,
 * check it, log all warnings about its geometry, and find which part of it is wanted. @param
 * header_only as of sc_open_nrrd. @return the errors of sc_volume_read_by. Caller owns:
 * sc_source_clear. */
sc_status sc_open_source(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                         bool header_only, sc_source *out);

/* Find the masks in the directory @p path, files of a volume each, and check their headers. *out,
 * to which as above the caller clears, has size, geometry and orientation of the first, the masks
 * in the order of their names, and as table a row for each: the label 1 for the first, and so on,
 * and as name that of the file without its ending. mask_count is 0 if the directory has no such
 * file.
 * A mask whose voxels are the same along other axes is turned when it is read. Masks of parts of
 * one grid are united: size and geometry are those of the box that holds them all.
 * @return SC_ERR_DATA if two masks are of different grids or have the same name, or are more
 * than SC_LABELS_MAX - 1; the errors of sc_open_file. */
sc_status sc_open_masks(const sc_ctx *ctx, const char *path, sc_source *out);
/* A volume of a file for each slice. */
typedef struct sc_slice_files {
    char **paths; /* [count], in the order of the slices; owned, as each of them is */
    size_t count, capacity;
    /* Open a slice as a volume. Caller owns *out: sc_source_clear. */
    sc_status (*open)(const sc_ctx *ctx, const struct sc_slice_files *files, size_t i,
                      sc_source *out);
    bool is_packed; /* of pictures: they are PNG; of MetaImage: each is a zlib stream, and */
    int size[2];    /* columns and rows of each, */
    sc_voxel_type type;
    int64_t header_bytes; /* and as in sc_meta_series */
} sc_slice_files;
void sc_slice_files_clear(sc_slice_files *files);
/* Let @p source, whose size and type are set, be read from the files, which it owns then: sets
 * encoding, data, release, read_slices, slices, and data_files. @return SC_ERR_MEMORY. */
sc_status sc_slice_files_use(const sc_ctx *ctx, sc_slice_files *files, sc_source *source);
/* As sc_open_file, of a directory with a picture for each slice: PNG, or TIFF of one page, whose
 * names differ in their numbers. *out is not written if the directory
 * holds no such pictures. */
sc_status sc_open_slices(const sc_ctx *ctx, const char *path, sc_source *out);
/* Open the file of a mask, as sc_open_file does; of HDF5 the only array in it. */
sc_status sc_open_mask(const sc_ctx *ctx, const char *file, bool header_only, sc_source *out);
/* Check that mask @p i of @p source has voxels of the grid of the first, be it along other axes, or
 * fewer or more of them where files say where they lie, and note which. @param header what its file
 * says. @return SC_ERR_DATA. */
sc_status sc_mask_place(const sc_ctx *ctx, const sc_source *source, size_t i,
                        const sc_source *header);
/* @return whether a mask of @p source is stored along other axes, or has not just its voxels. */
bool sc_mask_is_placed(const sc_source *source, const sc_mask *mask);
/* Read the masks of @p source one after the other into its data, which become labels in the bytes
 * that they need; sets encoding, type, data, release, and the voxels of the masks. Where masks
 * overlap, @p overlap decides, and a warning tells of it. Takes 1.25 or 2.25 bytes for each voxel.
 * @return SC_ERR_DATA for a file with more than one label beside 0; the errors of sc_stream_next;
 * SC_ERR_MEMORY, and SC_ERR_SYSTEM as sc_volume_memory_check. */
sc_status sc_load_masks(const sc_ctx *ctx, const char *path, const sc_overlap_rule *rule,
                        sc_source *source);

/* Read the layers of @p source, which has several, into its data, as labels of two bytes; sets
 * encoding, type, data, release and layers. Where segments overlap, @p overlap decides, and a
 * warning tells of it, and of values that no segment has. @return as sc_load_masks. */
sc_status sc_load_layers(const sc_ctx *ctx, const char *path, const sc_overlap_rule *rule,
                         sc_source *source);

/* A tissue that covers a voxel. */
typedef struct sc_contender {
    uint64_t voxels; /* of the whole tissue */
    size_t place;    /* in the order of masks or segments */
    size_t row;      /* in the table */
} sc_contender;
/* Make the rule of @p choice for the tissues of the table of @p source. @return SC_ERR_DATA,
 * logged, for a name that no tissue has; SC_ERR_MEMORY. Caller owns *out: sc_overlap_rule_clear. */
sc_status sc_overlap_rule_make(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                               const sc_source *source, sc_overlap_rule *out);
void sc_overlap_rule_clear(sc_overlap_rule *rule);
/* @return whether a voxel that both cover belongs to @p one and not to @p other. */
bool sc_overlap_wins(const sc_overlap_rule *rule, sc_contender one, sc_contender other);
/* Begin to count for @p rows tissues. @return SC_ERR_MEMORY. */
sc_status sc_overlap_count_begin(const sc_ctx *ctx, size_t rows, sc_overlap_count *out);
/* Add that a tissue has so many voxels which another one covers, too; nothing for no voxels.
 * @return SC_ERR_MEMORY. */
sc_status sc_overlap_add(const sc_ctx *ctx, size_t winner, size_t loser, uint64_t voxels,
                         sc_overlap_count *count);

/* Segments of a source that may overlap, while they are painted: the first pass counts their
 * voxels, the second gives each voxel to one of them. Owns its arrays: sc_claims_clear. */
typedef struct sc_claims {
    const sc_ctx *ctx;
    const char *path;
    const sc_overlap_rule *rule;
    sc_source *source;
    size_t rows;      /* of the table: the segments */
    bool by_number;   /* the order of segments is that of their numbers, not of the rows */
    uint64_t *voxels; /* [rows]: how many each covers */
    uint64_t *pairs;  /* [rows][rows]: voxels that the first took from the second; NULL: too many */
    uint16_t *labels; /* [the part of the source that is wanted] */
} sc_claims;
/* Begin. @return SC_ERR_MEMORY, and SC_ERR_SYSTEM as sc_volume_memory_check; sc_claims_clear frees.
 */
sc_status sc_claims_begin(const sc_ctx *ctx, const char *path, const sc_overlap_rule *rule,
                          sc_source *source, sc_claims *out);
/* Note that the segment in row @p row covers a voxel that that in row @p before has so far. @return
 * the row of the one that has it. */
size_t sc_claims_settle(sc_claims *claims, size_t row, size_t before);
/* When all voxels have been painted: put the labels in the place of the voxels of the source, and
 * note what overlaps. @return SC_ERR_MEMORY. */
sc_status sc_claims_end(sc_claims *claims);
void sc_claims_clear(sc_claims *claims);
void sc_overlap_count_clear(sc_overlap_count *count);
/* Warn of tissues of which nothing is left because others cover them, and of overlaps. @param
 * volume that was made of the source. @return SC_ERR_MEMORY. */
sc_status sc_overlap_warn(const sc_ctx *ctx, const char *path, const sc_source *source,
                          const sc_overlap_rule *rule, const sc_volume *volume);
/* Move what was counted to a list, sorted, with the names of the tissues. @return SC_ERR_MEMORY. */
sc_status sc_overlap_list_take(const sc_ctx *ctx, sc_source *source, sc_overlap_list *out);

/* The voxels of a source as whole numbers, block by block, in bounded memory. */
typedef struct sc_voxel_stream sc_voxel_stream;
enum {
    SC_STREAM_BLOCK = 16384, /* most voxels that one call of sc_stream_next delivers */
    SC_LAYERS_MAX = 4096,    /* most layers of segments; fewer than such voxels */
    SC_BATCH_BYTES = 8 << 20 /* most bytes that sc_stream_next_raw delivers of a file that is
                                streamed; few enough to stay in a cache */
};

/* Add voxels in a box to a tally, whose box does not count while it has none. */
static inline void sc_tally_add(sc_label_tally *tally, const int low[3], const int high[3],
                                uint64_t voxels)
{
    for (int i = 0; i < 3; i++) {
        if (!tally->voxels || low[i] < tally->low[i])
            tally->low[i] = low[i];
        if (!tally->voxels || high[i] > tally->high[i])
            tally->high[i] = high[i];
    }
    tally->voxels += voxels;
}

/* Replace the ids of voxels by map[id]. @param bytes of an id, which become @p to_bytes, at least
 * as many; *ids is replaced then. @return SC_ERR_MEMORY for wider ids, nothing changed. */
sc_status sc_ids_map(const sc_ctx *ctx, size_t voxels, const int *map, int to_bytes, int threads,
                     int *bytes, void **ids);

/* Begin at the first voxel. @p source was filled with header_only false. @p path: the volume as
 * the user named it, for messages. Both are borrowed until sc_stream_close, as is @p ctx.
 * @return SC_ERR_MISSING, SC_ERR_DATA, SC_ERR_MEMORY. Caller owns *out: sc_stream_close. */
sc_status sc_stream_open(const sc_ctx *ctx, const char *path, const sc_source *source,
                         sc_voxel_stream **out);
/* Write the values of the next @p count voxels to out[count], and move on. count is at most
 * SC_STREAM_BLOCK and at most what is left. SC_ERR_DATA (logged) where the file ends too early,
 * is damaged, or holds a value that is no whole number; the stream can only be closed then. */
sc_status sc_stream_next(sc_voxel_stream *stream, size_t count, int64_t *out);
/* Instead of sc_stream_next, from the first voxel to the last: the next voxels as they are stored,
 * so that several threads turn them into values side by side. *raw, valid until the next call,
 * points at the first, *count receives how many there are, at least 1. To be called while voxels
 * are left. @return the errors of sc_stream_next but for values. */
sc_status sc_stream_next_raw(sc_voxel_stream *stream, const void **raw, size_t *count);
/* Read the voxels that the next call of sc_stream_next_raw will deliver, if that helps: while other
 * threads look at those that the last call delivered. What goes wrong, the next call says. Threads:
 * one at a time. */
void sc_stream_read_ahead(sc_voxel_stream *stream);
/* @return whether the labels of a source are the numbers that it stores, integers in this byte
 * order that are not scaled, of at most 63 bits: sc_stream_values would only widen them. */
bool sc_stream_is_plain(const sc_source *source);
/* Of @p count values of a type of integers at @p values, in this byte order: @return the first
 * behind value @p i that differs from it, or @p count; *value receives value i. */
int sc_run_end(sc_voxel_type type, const void *values, int i, int count, int64_t *value);
/* Write the values of @p count voxels as stored at @p raw to out[count]. @param room 8 bytes for
 * each voxel, which may be written. Integers with a slope below 1 are rounded where they lie within
 * half a step of a whole number. @return how many of them, from the first on, are labels: fewer
 * than @p count if one is no whole number or too large. Threads: any, on memory of their own. */
size_t sc_stream_values(sc_voxel_stream *stream, const void *raw, size_t count, void *room,
                        int64_t *out);
/* Log that voxel @p index of the volume, stored at @p raw, is no label. @return SC_ERR_DATA. */
sc_status sc_stream_refuse(const sc_voxel_stream *stream, const void *raw, size_t index);
/* The same for numbers of any kind, of a grey volume: fractions, and also infinite ones and NaN.
 * All reads of a stream are of one kind. */
sc_status sc_stream_next_numbers(sc_voxel_stream *stream, size_t count, double *out);
/* After the last voxel: warn if labels were rounded, verify the check sum of SC_ENCODING_GZIP and
 * SC_ENCODING_ZLIB, and warn of bytes behind the end of the former. SC_ERR_DATA (logged) if it is
 * wrong or missing. Other encodings are not checked. */
sc_status sc_stream_finish(sc_voxel_stream *stream);
/* Close the file and free the stream; NULL is allowed. */
void sc_stream_close(sc_voxel_stream *stream);
SC_CLOSE_AT(sc_stream_close, sc_voxel_stream)

/* One pass over the voxels of the wanted part, by ctx->threads threads; the result does not depend
 * on their number: the distinct labels, what they cover, and, if @p keep_ids, the voxels as dense
 * ids. Fills size, label_count, label_bytes, labels (values only), and ids or, without
 * keep_ids, tallies of *volume and sets the rest to zero. The caller owns it: sc_volume_clear; it
 * is untouched after an error. Warns of what looks like a grey-value image. @return the errors of
 * sc_stream_next; SC_ERR_DATA for more than SC_LABELS_MAX labels; SC_ERR_MEMORY. */
sc_status sc_read_labels(const sc_ctx *ctx, const char *path, const sc_source *source,
                         bool keep_ids, sc_volume *volume);

/* Measure the area on which every two labels of a volume touch across faces of voxels, background
 * left out, with up to @p threads threads. @param out [label_count][label_count], symmetric; the
 * largest face of a voxel counts 1001, the others in proportion. Caller owns: sc_free.
 * @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_count_contacts(const sc_ctx *ctx, const sc_volume *volume, int threads,
                                        uint64_t **out);
/* Measure which labels lie near each other, whether they touch or not. The volume is cut into
 * blocks, 32 along its longest axis, and a sample of the voxels is looked at. @param out
 * [label_count][label_count]: in how many blocks the one with the first id is while the other is in
 * the same block or in one of the 26 about it; on the diagonal thus the blocks where a label is.
 * Background is left out. Caller owns: sc_free. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_count_near(const sc_ctx *ctx, const sc_volume *volume, uint32_t **out);

#endif
