/* SPDX-License-Identifier: BSD-3-Clause */
/* Label fields of AmiraMesh, as Amira and Avizo write them: a header in words, then the voxels of
 * one lattice behind a line "@1", as bytes, as decimal digits, or packed by HxByteRLE or HxZip.
 * Source: "AmiraMesh Format" in the Amira User's Guide, and files of Amira. A voxel counts the
 * materials from 0 on, in their order; their "Id" is one more in files of Amira and the same number
 * in others, and is not used. */
#include "formats/meta_files.h"

#include <errno.h>
#include <stdlib.h>

enum {
    HEADER_MAX_BYTES = 1 << 20, /* a longer header is refused */
    WORD_BYTES = 512,           /* what words have beyond is left out */
    GROUPS_MAX = 3,             /* groups within groups whose names count */
    RLE_RATIO_MAX = 64          /* HxByteRLE: 127 bytes at most from two */
};

/* A kind of word of the header. */
typedef enum amira_kind { END, OPEN, CLOSE, WORD } amira_kind;

/* The one field whose voxels are read. */
typedef struct amira_field {
    char type[32];         /* empty: there is none */
    sc_encoding encoding;  /* SC_ENCODING_SLICES: HxByteRLE */
    uint64_t packed_bytes; /* of what is packed */
} amira_field;

/* Where the volume lies, as far as the file says. */
typedef struct amira_place {
    double box[6];     /* least and most along x, y, z: centres of voxels */
    double matrix[16]; /* column by column */
    bool has_box, has_matrix;
    double unit_mm;
} amira_place;

/* The header while it is read. */
typedef struct amira {
    const sc_ctx *ctx;
    const char *path; /* borrowed */
    char *text;       /* the begin of the file, owned */
    const char *at;   /* the next character */
    char word[WORD_BYTES];
    bool first_of_line;                     /* word is */
    char groups[GROUPS_MAX][SC_NAME_BYTES]; /* the open ones, the outer first */
    int depth;                              /* how many are open */
    int64_t size[3];                        /* 0: none */
    amira_place place;
    int materials; /* so far */
    sc_label row;  /* the open one */
    sc_label_table table;
    sc_name_count names;
    amira_field field; /* of the voxels behind "@1" */
    bool stacked;      /* its slices have places of their own */
    bool is_text, big_endian;
    uint64_t data_bytes; /* where the voxels begin in the file; 0: not found */
} amira;

/* Copy the next word to a->word; commas only separate words. */
static amira_kind next_word(amira *a)
{
    const char *begin;
    size_t length;

    for (;;) {
        a->at += strspn(a->at, " \t\r\n,");
        if (*a->at != '#')
            break;
        a->at += strcspn(a->at, "\n");
    }
    a->first_of_line = a->at == a->text || a->at[-1] == '\n';
    begin = a->at;
    if (!*begin)
        return END;
    if (*begin == '{' || *begin == '}') {
        a->at++;
        return *begin == '{' ? OPEN : CLOSE;
    }
    if (*begin == '"') {
        length = strcspn(++begin, "\"");
        a->at = begin + length + (begin[length] == '"');
    } else {
        length = strcspn(begin, *begin == '@' ? " \t\r\n" : " \t\r\n,{}\"");
        a->at = begin + length;
    }
    snprintf(a->word, sizeof a->word, "%.*s", (int)(length < WORD_BYTES ? length : WORD_BYTES),
             begin);
    return WORD;
}

/* Read @p count finite numbers. @return false if there are fewer. */
static bool read_numbers(amira *a, int count, double *out)
{
    for (int i = 0; i < count; i++) {
        char *end;

        out[i] = strtod(a->at, &end);
        if (end == a->at || !isfinite(out[i]))
            return false;
        a->at = end;
    }
    return true;
}

/* Read the size of the lattice. One that is negative or too large becomes -1, which sc_grid_voxels
 * refuses. */
static void read_size(amira *a)
{
    double size[3];

    if (!read_numbers(a, 3, size))
        return;
    for (int i = 0; i < 3; i++)
        a->size[i] = size[i] >= 1 && size[i] <= INT32_MAX ? (int64_t)size[i] : -1;
}

/* Read the declaration "{ TYPE NAME } @NUMBER(PACKING,BYTES)" of a field of the lattice. The voxels
 * of the first come first in the file. */
static void read_field(amira *a)
{
    amira_field field = {.encoding = SC_ENCODING_PLAIN};
    const char *packing;

    if (next_word(a) != OPEN || next_word(a) != WORD)
        return;
    snprintf(field.type, sizeof field.type, "%.31s", a->word);
    while (next_word(a) == WORD) {
    }
    if (next_word(a) == WORD && !strcmp(a->word, "=") && next_word(a) != WORD)
        return;
    packing = strchr(a->word, '(');
    if (packing && !strncmp(packing, "(HxByteRLE,", 11))
        field.encoding = SC_ENCODING_SLICES;
    else if (packing && !strncmp(packing, "(HxZip,", 7))
        field.encoding = SC_ENCODING_ZLIB;
    else if (packing)
        field.encoding = SC_ENCODING_LOADED; /* not known; find_voxels refuses it */
    if (packing && strchr(packing, ','))
        field.packed_bytes = strtoull(strchr(packing, ',') + 1, NULL, 10);
    if (strtol(a->word + 1, NULL, 10) == 1)
        a->field = field;
}

/* Read what the key a->word of a group says, if it is of interest. */
static void read_key(amira *a)
{
    const bool in_parameters = a->depth >= 1 && !strcmp(a->groups[0], "Parameters");
    double rgb[3];

    if (!in_parameters) {
        return;
    } else if (a->depth == 1 && !strcmp(a->word, "BoundingBox")) {
        a->place.has_box = read_numbers(a, 6, a->place.box);
    } else if (a->depth == 1 && !strcmp(a->word, "TransformationMatrix")) {
        a->place.has_matrix = read_numbers(a, 16, a->place.matrix);
    } else if (a->depth == 1 && !strcmp(a->word, "CoordType") && next_word(a) == WORD) {
        a->stacked = strcmp(a->word, "uniform") != 0;
    } else if (a->depth == 2 && !strcmp(a->groups[1], "Units") && !strcmp(a->word, "Coordinates") &&
               next_word(a) == WORD) {
        a->place.unit_mm = sc_length_unit_mm(a->word);
    } else if (a->depth == 3 && !strcmp(a->groups[1], "Materials") && !strcmp(a->word, "Color") &&
               read_numbers(a, 3, rgb)) {
        a->row.has_color = true;
        for (int i = 0; i < 3; i++)
            a->row.rgb[i] = (uint8_t)lround(sc_level_mend(255 * rgb[i], 255, false, &a->names));
    }
}

/* Begin the group @p name: in the materials, a row of the table. */
static void begin_group(amira *a, const char *name)
{
    if (a->depth < GROUPS_MAX)
        snprintf(a->groups[a->depth], SC_NAME_BYTES, "%.*s", SC_NAME_BYTES - 1, name);
    a->depth++;
    if (a->depth != 3 || strcmp(a->groups[0], "Parameters") || strcmp(a->groups[1], "Materials"))
        return;
    a->row = (sc_label){.value = a->materials++, .opacity = -1};
    if (a->row.value)
        sc_name_read(name, a->row.name, &a->names);
}

/* End a group: a material is added to the table, but for the first, which is what lies outside. */
static sc_status end_group(amira *a)
{
    const int depth = a->depth;

    a->depth -= depth > 0;
    if (depth != 3 || strcmp(a->groups[0], "Parameters") || strcmp(a->groups[1], "Materials") ||
        !a->row.value)
        return SC_OK;
    return sc_label_table_add(a->ctx, &a->table, &a->row);
}

/* Read the words of the header, up to the line of the voxels. @return SC_ERR_DATA if there is none;
 * SC_ERR_MEMORY. */
static sc_status read_words(amira *a)
{
    char name[WORD_BYTES] = ""; /* the word before */

    for (amira_kind kind = next_word(a); kind != END; kind = next_word(a)) {
        if (kind == OPEN) {
            begin_group(a, name);
        } else if (kind == CLOSE) {
            SC_PASS(end_group(a));
        } else if (a->first_of_line && a->word[0] == '@') {
            a->at += strcspn(a->at, "\n");
            a->data_bytes = (uint64_t)(a->at - a->text) + (*a->at == '\n');
            return SC_OK;
        } else if (a->depth == 0 && !strcmp(name, "define") && !strcmp(a->word, "Lattice")) {
            read_size(a);
        } else if (a->depth == 0 && !strcmp(a->word, "Lattice")) {
            read_field(a);
        } else {
            memcpy(name, a->word, sizeof name);
            read_key(a);
            continue;
        }
        name[0] = '\0';
    }
    return sc_fail(a->ctx, SC_ERR_DATA,
                   "%s: has no line \"@1\", behind which the voxels stand, in its first %d bytes",
                   a->path, HEADER_MAX_BYTES);
}

/* Read the begin of the file and what it says. */
static sc_status read_header(amira *a)
{
    SC_OWN(sc_fclose_at) FILE *stream = NULL;
    size_t line;

    SC_PASS(sc_open_input(a->ctx, a->path, &stream));
    SC_PASS(sc_alloc(a->ctx, HEADER_MAX_BYTES + 1, 1, &a->text));
    a->text[fread(a->text, 1, HEADER_MAX_BYTES, stream)] = '\0';
    line = strcspn(a->text, "\n");
    snprintf(a->word, sizeof a->word, "%.*s", (int)(line < WORD_BYTES ? line : WORD_BYTES),
             a->text);
    a->is_text = strstr(a->word, "ASCII") != NULL;
    a->big_endian = !strstr(a->word, "LITTLE-ENDIAN");
    a->at = a->text;
    return read_words(a);
}

/* ---- voxels ---- */

/* Where unpacking HxByteRLE has got to: sc_voxel_reader.data. */
typedef struct rle_file {
    FILE *stream;          /* owned */
    uint64_t packed_bytes; /* of all */
    uint64_t left;         /* of them, not read yet */
    int run;               /* bytes that still follow from the last count */
    int value;             /* which they all have; EOF: each stands for itself */
} rle_file;

static void release_rle(void *data)
{
    rle_file *rle = data;

    if (rle->stream)
        fclose(rle->stream);
    sc_free(rle);
}

/* @return the next packed byte; EOF at their end, or where they cannot be read. */
static int next_packed(rle_file *rle)
{
    if (rle->left == 0)
        return EOF;
    rle->left--;
    return getc(rle->stream);
}

/* sc_slices_fn of HxByteRLE: a count, and then the byte that is repeated so often, or behind a
 * count with the highest bit so many bytes. */
static sc_status read_rle(const sc_ctx *ctx, const char *path, const sc_source *source, int first,
                          int count, void *out)
{
    const size_t slice =
        (size_t)source->size[0] * (size_t)source->size[1] * sc_voxel_type_bytes(source->type);
    rle_file *rle = source->reader.data;
    unsigned char *to = out;

    if (first == 0 && fseeko(rle->stream, (off_t)source->stored.offset_bytes, SEEK_SET))
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", source->stored.file, strerror(errno));
    if (first == 0) {
        rle->left = rle->packed_bytes;
        rle->run = 0;
    }
    for (size_t done = 0; done < slice * (size_t)count; done++) {
        int byte = rle->value;

        if (rle->run == 0) {
            const int head = next_packed(rle);

            rle->run = head == EOF ? 0 : head & 0x7f;
            byte = rle->value = head == EOF || head & 0x80 ? EOF : next_packed(rle);
        }
        if (byte == EOF)
            byte = next_packed(rle);
        if (byte == EOF || rle->run == 0)
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s: its labels, packed by HxByteRLE, end or are damaged after %zu of "
                           "%zu bytes",
                           path, (size_t)first * slice + done, slice * (size_t)source->size[2]);
        rle->run--;
        to[done] = (unsigned char)byte;
    }
    return SC_OK;
}

/* Let the voxels of @p source be unpacked by read_rle. */
static sc_status open_rle(const amira *a, sc_source *source)
{
    rle_file *rle;

    SC_PASS(SC_ZALLOC(a->ctx, 1, &rle));
    rle->packed_bytes = a->field.packed_bytes;
    source->reader.data = rle;
    source->reader.release = release_rle;
    source->reader.read_slices = read_rle;
    source->reader.slices = 1;
    return sc_open_input(a->ctx, source->stored.file, &rle->stream);
}

/* Write the type of the voxels to *out. */
static sc_status field_type(const amira *a, sc_voxel_type *out)
{
    static const char *const names[SC_VOXEL_TYPES] = {
        [SC_VOXEL_UINT8] = "byte",   [SC_VOXEL_INT16] = "short", [SC_VOXEL_UINT16] = "ushort",
        [SC_VOXEL_INT32] = "int",    [SC_VOXEL_UINT32] = "uint", [SC_VOXEL_FLOAT] = "float",
        [SC_VOXEL_DOUBLE] = "double"};
    const char *name = strcmp(a->field.type, "int32") ? a->field.type : "int";

    if (!a->size[0] || !a->field.type[0])
        return sc_fail(a->ctx, SC_ERR_DATA,
                       "%s: is AmiraMesh without a lattice of labels as its first data, such as a "
                       "surface or a graph; expected a label field",
                       a->path);
    if (sc_voxel_type_named(name, names, out))
        return SC_OK;
    return sc_fail(a->ctx, SC_ERR_DATA,
                   "%s: has voxels of the type %s, expected those of a label field: byte, ushort "
                   "or int",
                   a->path, a->field.type);
}

/* Set size and what tells where the voxels are of @p source, whose type is set. */
static sc_status find_voxels(const amira *a, sc_source *source)
{
    const size_t each = sc_voxel_type_bytes(source->type);
    const double ratio = a->field.encoding == SC_ENCODING_SLICES ? RLE_RATIO_MAX
                         : a->field.encoding == SC_ENCODING_ZLIB ? SC_DEFLATE_RATIO_MAX
                                                                 : 1;
    uint64_t bytes;
    size_t voxels;

    SC_PASS(sc_grid_voxels(a->ctx, a->path, a->size, each, source->size, &voxels));
    if (a->field.encoding == SC_ENCODING_LOADED || (a->is_text && ratio > 1))
        return sc_fail(a->ctx, SC_ERR_DATA,
                       "%s: its voxels are packed in a way that is not known, expected HxByteRLE "
                       "or HxZip of binary voxels; save it anew as AmiraMesh binary",
                       a->path);
    SC_PASS(sc_input_bytes(a->ctx, a->path, &bytes));
    bytes = bytes > a->data_bytes ? bytes - a->data_bytes : 0;
    if (ratio > 1 && bytes > a->field.packed_bytes)
        bytes = a->field.packed_bytes;
    if ((double)voxels * (a->is_text ? 1 : (double)each) > (double)bytes * ratio)
        return sc_fail(a->ctx, SC_ERR_DATA,
                       "%s: the header promises %zu voxels, more than the file can hold (%llu "
                       "bytes%s)",
                       a->path, voxels, (unsigned long long)bytes, ratio > 1 ? ", packed" : "");
    SC_PASS(sc_path_join(a->ctx, "", a->path, &source->stored.file));
    source->stored.offset_bytes = a->data_bytes;
    source->stored.encoding = a->field.encoding;
    source->stored.swapped = each > 1 && a->big_endian == SC_IS_LITTLE_ENDIAN;
    if (a->is_text)
        return sc_meta_open_text(a->ctx, source);
    return source->stored.encoding == SC_ENCODING_SLICES ? open_rle(a, source) : SC_OK;
}

/* Set the geometry of @p source, whose size is set. The box of a single slice may be flat. */
static sc_status geometry(const amira *a, sc_source *source)
{
    sc_affine *to = &source->to_ras_mm;

    if (a->stacked)
        return sc_fail(a->ctx, SC_ERR_DATA,
                       "%s: its slices are not evenly spaced (CoordType), expected \"uniform\"; "
                       "resample it in Amira",
                       a->path);
    if (!a->place.has_box)
        sc_warn_without_spacing(a->ctx, a->path, "BoundingBox");
    for (int i = 0; i < 3; i++) {
        const double steps = source->size[i] > 1 ? source->size[i] - 1 : 1;
        const double spacing = (a->place.box[2 * i + 1] - a->place.box[2 * i]) / steps;

        to->m[i][i] = a->place.has_box && spacing > 0 ? spacing : 1;
        to->m[i][3] = a->place.has_box ? a->place.box[2 * i] : 0;
    }
    if (a->place.has_matrix) {
        sc_affine matrix;

        for (int i = 0; i < 12; i++)
            matrix.m[i % 3][i / 3] = a->place.matrix[i / 3 * 4 + i % 3];
        *to = sc_affine_compose(&matrix, to);
    }
    for (int i = 0; i < 12; i++)
        to->m[i / 4][i % 4] *= a->place.unit_mm > 0 ? a->place.unit_mm : 1;
    return SC_OK;
}

sc_status sc_open_amira(const sc_ctx *ctx, const char *path, sc_source *out)
{
    amira a = {.ctx = ctx, .path = path};
    SC_OWN(sc_source_clear) sc_source source = {.slope = 1};
    sc_status status = read_header(&a);

    source.table = a.table;
    sc_free(a.text);
    SC_PASS(status);
    SC_PASS(field_type(&a, &source.type));
    SC_PASS(find_voxels(&a, &source));
    SC_PASS(geometry(&a, &source));
    sc_name_warn(ctx, path, &a.names);
    SC_HAND_OVER(source, out);
    return SC_OK;
}
