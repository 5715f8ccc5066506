/* SPDX-License-Identifier: BSD-3-Clause */
/* What a DICOM file is, and whether its data set is whole: one pass over it without a library. */
#include "bytes.h"
#include "compressed_file.h"
#include "dicom/dicom.h"

#include <errno.h>

enum {
    META_AT = 132,     /* behind 128 bytes for other programs, and "DICM" */
    UID_BYTES = 65,    /* with the terminator */
    DEPTH_MAX = 16,    /* levels of sequences and items, of which segmentations have six */
    ELEMENT_COST = 256 /* bytes of memory that DCMTK takes for an attribute or an item */
};
#define UNDEFINED UINT32_MAX /* as a length: up to a delimiter */
#define NO_END UINT64_MAX

#define TAG_ITEM SC_DICOM_TAG(0xfffe, 0xe000)
#define TAG_ITEM_END SC_DICOM_TAG(0xfffe, 0xe00d)
#define TAG_SEQUENCE_END SC_DICOM_TAG(0xfffe, 0xe0dd)
#define TAG_PIXELS SC_DICOM_TAG(0x7fe0, 0x0010)

/* How a data set is written: by its transfer syntax. */
typedef struct coding {
    bool is_implicit, is_big, is_deflated, is_compressed;
} coding;

/* A data set that is being read. */
typedef struct reader {
    const sc_ctx *ctx;
    const char *path;
    FILE *file;
    coding coding;
    sc_compressed_file *deflated; /* NULL: it is not */
    uint64_t at, end;             /* place in the data set; its bytes, NO_END: not known */
    uint64_t elements;
} reader;

/* ---- kinds of objects ---- */

#define STORAGE "1.2.840.10008.5.1.4.1.1."

/* What a file is by its class; "" for none of these. The first prefix that fits decides. */
static const char *name_of_class(const char *uid)
{
    static const struct {
        const char *prefix, *name;
    } classes[] = {{STORAGE "2.", "an enhanced CT image"},
                   {STORAGE "2", "a slice of a CT image"},
                   {STORAGE "4.", "an enhanced MR image"},
                   {STORAGE "4", "a slice of an MR image"},
                   {STORAGE "128", "a slice of a PET image"},
                   {STORAGE "130", "an enhanced PET image"},
                   {STORAGE "20", "a slice of a nuclear medicine image"},
                   {STORAGE "6.", "an ultrasound image"},
                   {STORAGE "3.", "an ultrasound image"},
                   {STORAGE "7", "a secondary capture, a picture"},
                   {STORAGE "30", "a parametric map"},
                   {STORAGE "77.1.6", "a slide microscopy image"},
                   {STORAGE "481.3", "an RT structure set"},
                   {STORAGE "66.5", "a surface segmentation"}};
    const char *found = "";

    for (size_t i = 0; i < SC_COUNT_OF(classes) && !*found; i++) {
        const size_t length = strlen(classes[i].prefix);

        if (!strncmp(uid, classes[i].prefix, length) &&
            (!uid[length] || uid[length] == '.' || uid[length - 1] == '.'))
            found = classes[i].name;
    }
    return found;
}

static bool is_segmentation(const char *uid)
{
    return !strcmp(uid, STORAGE "66.4") || !strcmp(uid, STORAGE "66.7");
}

/* Log that a file holds something else. @return SC_ERR_DATA always. */
static sc_status refuse_class(const sc_ctx *ctx, const char *path, const char *uid)
{
    const char *name = name_of_class(uid);

    if (!strcmp(uid, STORAGE "481.3") || !strcmp(uid, STORAGE "66.5"))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: is DICOM, %s, which holds contours and no voxels; expected a "
                       "segmentation (DICOM SEG); open it in 3D Slicer (SlicerRT) and save the "
                       "segmentation as .nrrd",
                       path, name);
    if (!*name)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: is DICOM of the class %s, expected a segmentation (" STORAGE
                       "66.4, or " STORAGE "66.7 for label maps); labels stored otherwise are "
                       "converted by 3D Slicer (save the segmentation as .nrrd)",
                       path, *uid ? uid : "(none is named)");
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s: is DICOM, %s, not a segmentation; expected a DICOM SEG object, which "
                   "stands in a file of its own; to show the image behind a segmentation (image: "
                   "in the job), convert its directory: `dcm2niix DIRECTORY`; labels stored as an "
                   "image are converted by 3D Slicer (save the segmentation as .nrrd)",
                   path, name);
}

#undef STORAGE

/* ---- transfer syntaxes ---- */

#define SYNTAX "1.2.840.10008.1.2"

/* @return the usual name of a transfer syntax that is not read; "" if it is not known. */
static const char *name_of_syntax(const char *uid)
{
    static const struct {
        const char *prefix, *name;
    } names[] = {
        {SYNTAX ".4.5", "JPEG"},           {SYNTAX ".4.7", "JPEG lossless"},
        {SYNTAX ".4.8", "JPEG-LS"},        {SYNTAX ".4.9", "JPEG 2000"},
        {SYNTAX ".4.20", "HTJ2K"},         {SYNTAX ".4.10", "MPEG"},
        {SYNTAX ".4.11", "JPEG XL"},       {SYNTAX ".1.98", "encapsulated, not compressed"},
        {SYNTAX ".8.1", "deflated images"}};

    for (size_t i = 0; i < SC_COUNT_OF(names); i++) {
        if (!strncmp(uid, names[i].prefix, strlen(names[i].prefix)))
            return names[i].name;
    }
    return "";
}

/* Write how the data set is coded to *out. @return SC_ERR_DATA for what is not read. */
static sc_status coding_of(const sc_ctx *ctx, const char *path, const char *uid, coding *out)
{
    static const struct {
        const char *uid;
        coding coding;
    } codings[] = {{SYNTAX, {.is_implicit = true}},
                   {SYNTAX ".1", {0}},
                   {SYNTAX ".2", {.is_big = true}},
                   {SYNTAX ".1.99", {.is_deflated = true}},
                   {SYNTAX ".5", {.is_compressed = true}}};
    const char *name = name_of_syntax(uid);

    for (size_t i = 0; i < SC_COUNT_OF(codings); i++) {
        if (!strcmp(uid, codings[i].uid)) {
            *out = codings[i].coding;
            return SC_OK;
        }
    }
    if (!*uid)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: does not name its transfer syntax (0002,0010); the file is damaged: "
                       "get it anew, or repair it with `dcmconv IN OUT` of DCMTK",
                       path);
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s: has the transfer syntax %s%s%s%s, expected one without compression, RLE or "
                   "deflated; convert it, for example with `gdcmconv --raw IN OUT`",
                   path, uid, *name ? " (" : "", name, *name ? ")" : ", which is not known");
}

#undef SYNTAX

/* ---- the first group ---- */

static uint32_t number_at(const unsigned char *bytes, int count, bool is_big)
{
    return (uint32_t)sc_number_at(bytes, count, is_big);
}

/* @return whether the two letters of a type stand before a length of four bytes; *known: whether
 * there is such a type. */
static bool has_long_length(const unsigned char type[2], bool *known)
{
    static const char wide[] = "OB OD OF OL OV OW SQ SV UC UN UR UT UV ";
    static const char narrow[] = "AE AS AT CS DA DS DT FD FL IS LO LT PN SH SL SS ST TM UI UL US ";
    const char letters[] = {(char)type[0], (char)type[1], ' ', '\0'};
    const bool is_word = type[0] >= 'A' && type[0] <= 'Z' && type[1] >= 'A' && type[1] <= 'Z';
    const bool is_wide = is_word && strstr(wide, letters);

    *known = is_wide || (is_word && strstr(narrow, letters));
    return is_wide;
}

/* Copy a text of @p length bytes, at which @p file stands, to uid. @return whether it is a UID. */
static bool take_uid(FILE *file, uint32_t length, char uid[UID_BYTES])
{
    if (length >= UID_BYTES || fread(uid, 1, length, file) != length)
        return false;
    uid[length] = '\0';
    uid[strspn(uid, "0123456789.")] = '\0';
    return true;
}

/* Read the first group of a file, which stands behind "DICM" and is always written the same way,
 * and leave @p file at the data set. Texts that are missing become empty. @return false if the
 * group is damaged. */
static bool read_meta(FILE *file, char class_uid[UID_BYTES], char syntax_uid[UID_BYTES])
{
    unsigned char head[12];

    class_uid[0] = syntax_uid[0] = '\0';
    if (fseeko(file, META_AT - 4, SEEK_SET) || fread(head, 1, 4, file) != 4 ||
        memcmp(head, "DICM", 4) != 0)
        return false;
    for (;;) {
        const off_t begin = ftello(file);
        uint32_t element, length;
        bool known, is_wide;

        if (fread(head, 1, 8, file) != 8 || number_at(head, 2, false) != 2)
            return fseeko(file, begin, SEEK_SET) == 0;
        element = number_at(head + 2, 2, false);
        is_wide = has_long_length(head + 4, &known);
        if (!known || (is_wide && fread(head + 8, 1, 4, file) != 4))
            return false;
        length = is_wide ? number_at(head + 8, 4, false) : number_at(head + 6, 2, false);
        if (element == 0x0002 || element == 0x0010) {
            if (!take_uid(file, length, element == 2 ? class_uid : syntax_uid))
                return false;
        } else if (fseeko(file, (off_t)length, SEEK_CUR)) {
            return false;
        }
    }
}

/* ---- bytes of the data set ---- */

/* Read up to @p count bytes to @p out, or, if that is NULL, pass over them. @return how many there
 * were. */
static uint64_t take(reader *r, unsigned char *out, uint64_t count)
{
    uint64_t done = 0;

    if (r->deflated) {
        done = out ? sc_compressed_read(r->deflated, out, (size_t)count)
                   : sc_compressed_skip(r->deflated, count);
    } else {
        const uint64_t left = r->end - r->at, some = count < left ? count : left;

        if (out)
            done = fread(out, 1, (size_t)some, r->file);
        else if (fseeko(r->file, (off_t)some, SEEK_CUR) == 0)
            done = some;
    }
    r->at += done;
    return done;
}

/* ---- elements ---- */

/* A level of nesting. */
typedef struct level {
    uint64_t end;      /* place behind it; NO_END: up to a delimiter */
    bool holds_items;  /* a sequence, or the parts of compressed pixels; else attributes */
    bool is_fragments; /* such parts */
    bool is_implicit;
} level;

/* The levels from the data set down to the current place. */
typedef struct nesting {
    level levels[DEPTH_MAX + 1];
    int depth;
} nesting;

/* Log that the data set is damaged at the attribute @p tag. @return SC_ERR_DATA always. */
static sc_status bad_element(const reader *r, uint32_t tag, const char *what)
{
    return sc_fail(
        r->ctx, SC_ERR_DATA,
        "%s: byte %llu of its data set, attribute (%04x,%04x): %s; the file is damaged or "
        "cut short: get it anew",
        r->path, (unsigned long long)r->at, tag >> 16, tag & 0xffff, what);
}

static sc_status push(const reader *r, nesting *n, uint32_t tag, level below)
{
    const level *top = &n->levels[n->depth];

    if (n->depth == DEPTH_MAX)
        return sc_fail(r->ctx, SC_ERR_DATA,
                       "%s: attribute (%04x,%04x): sequences are nested deeper than %d levels, "
                       "expected at most so many; the file is damaged: get it anew",
                       r->path, tag >> 16, tag & 0xffff, DEPTH_MAX);
    if (below.end != NO_END && top->end != NO_END && below.end > top->end)
        return bad_element(r, tag, "reaches beyond what it is a part of");
    n->levels[++n->depth] = below;
    return SC_OK;
}

/* Check that what DCMTK takes for the data set, with @p more bytes of a value, is not more than a
 * volume may take. */
static sc_status check_cost(const reader *r, uint64_t more)
{
    const uint64_t bytes = r->elements * ELEMENT_COST + (r->coding.is_deflated ? r->at + more : 0);

    if (r->ctx->memory_max_bytes == 0 || bytes <= r->ctx->memory_max_bytes)
        return SC_OK;
    return sc_fail(r->ctx, SC_ERR_SYSTEM,
                   "%s: its attributes take more memory than the limit of %s; raise the limit "
                   "where there is more memory: --max-memory",
                   r->path, sc_size_text((double)r->ctx->memory_max_bytes, (char[24]){0}));
}

/* Pass over @p length bytes of the value of @p tag. */
static sc_status skip(reader *r, const nesting *n, uint32_t tag, uint64_t length)
{
    const uint64_t end = n->levels[n->depth].end;

    SC_PASS(check_cost(r, length));
    if (end != NO_END && length > end - r->at && n->depth > 0)
        return bad_element(r, tag, "reaches beyond what it is a part of");
    if (take(r, NULL, length) != length)
        return bad_element(r, tag, "promises more bytes than the file has");
    return SC_OK;
}

/* Read the tag that stands in what holds items, @p tag, and go into its item or out. */
static sc_status read_item(reader *r, nesting *n, uint32_t tag, uint32_t length)
{
    const level top = n->levels[n->depth];
    const uint64_t end = length == UNDEFINED ? NO_END : r->at + length;

    if (tag == TAG_SEQUENCE_END && top.end == NO_END) {
        n->depth--;
        return SC_OK;
    }
    if (tag != TAG_ITEM)
        return bad_element(r, tag, "stands where an item of a sequence is expected");
    if (top.is_fragments)
        return length == UNDEFINED ? bad_element(r, tag, "has no length") : skip(r, n, tag, length);
    return push(r, n, tag, (level){.end = end, .is_implicit = top.is_implicit});
}

/* The head of an attribute. */
typedef struct head {
    uint32_t tag, length;
    bool is_sequence, is_unknown; /* by its type; both false: another one */
    bool is_bytes;                /* may be compressed pixels */
} head;

/* Read the rest of the head of an attribute, whose first 8 bytes are at @p bytes. */
static sc_status read_head(reader *r, const unsigned char bytes[8], bool is_implicit, head *h)
{
    const bool is_big = r->coding.is_big;
    unsigned char rest[4];
    bool known, is_wide;

    h->is_unknown = is_implicit;
    h->is_sequence = h->is_bytes = false;
    if (is_implicit) {
        h->length = number_at(bytes + 4, 4, is_big);
        return SC_OK;
    }
    is_wide = has_long_length(bytes + 4, &known);
    if (!known)
        return bad_element(r, h->tag, "has no type that DICOM knows");
    h->length = number_at(bytes + 6, 2, is_big);
    if (is_wide) {
        if (take(r, rest, 4) != 4)
            return bad_element(r, h->tag, "is cut off");
        h->length = number_at(rest, 4, is_big);
    }
    h->is_sequence = !memcmp(bytes + 4, "SQ", 2);
    h->is_unknown = !memcmp(bytes + 4, "UN", 2);
    h->is_bytes = !memcmp(bytes + 4, "OB", 2) || !memcmp(bytes + 4, "OW", 2);
    return SC_OK;
}

/* Go into the value of an attribute, or pass over it. What may be a sequence is taken as one: then
 * it is checked, whatever DCMTK takes it for. @param first set to the tag that was read already as
 * the beginning of its value; else 0. */
static sc_status read_value(reader *r, nesting *n, const head *h, uint32_t *first)
{
    level below = {.end = r->at + h->length,
                   .holds_items = true,
                   .is_implicit = n->levels[n->depth].is_implicit || h->is_unknown};
    unsigned char bytes[4];

    *first = 0;
    if (h->length == UNDEFINED) {
        below.end = NO_END;
        below.is_fragments = h->is_bytes && h->tag == TAG_PIXELS && r->coding.is_compressed;
        if (!below.is_fragments && !h->is_sequence && !h->is_unknown)
            return bad_element(r, h->tag, "has no length");
        return push(r, n, h->tag, below);
    }
    if (h->is_sequence)
        return push(r, n, h->tag, below);
    if (!h->is_unknown || h->length < 8 || (h->tag == TAG_PIXELS && n->depth == 0))
        return skip(r, n, h->tag, h->length);
    SC_PASS(push(r, n, h->tag, below));
    if (take(r, bytes, 4) != 4)
        return bad_element(r, h->tag, "promises more bytes than the file has");
    *first =
        number_at(bytes, 2, r->coding.is_big) << 16 | number_at(bytes + 2, 2, r->coding.is_big);
    if (*first == TAG_ITEM)
        return SC_OK;
    *first = 0;
    n->depth--;
    return skip(r, n, h->tag, h->length - 4);
}

/* Read the next attribute, item or delimiter. @param first as of read_value, of the one before. */
static sc_status read_element(reader *r, nesting *n, uint32_t *first, bool *end)
{
    const level top = n->levels[n->depth];
    const bool is_big = r->coding.is_big;
    unsigned char bytes[8];
    const size_t done = *first ? 4 : 0;
    head h = {.tag = *first};
    const uint64_t count = take(r, bytes + done, 8 - done);
    sc_status status;

    *end = count == 0 && n->depth == 0 && !done;
    if (*end)
        return SC_OK;
    if (count != 8 - done)
        return bad_element(r, 0, "the data set ends within an attribute or a sequence");
    if (!done)
        h.tag = number_at(bytes, 2, is_big) << 16 | number_at(bytes + 2, 2, is_big);
    *first = 0;
    if (top.end != NO_END && r->at > top.end)
        return bad_element(r, h.tag, "reaches beyond what it is a part of");
    if (top.holds_items)
        return read_item(r, n, h.tag, number_at(bytes + 4, 4, is_big));
    if (h.tag == TAG_ITEM_END && n->depth > 0 && top.end == NO_END) {
        n->depth--;
        return SC_OK;
    }
    if (h.tag >> 16 == 0xfffe)
        return bad_element(r, h.tag, "stands outside of any sequence");
    status = read_head(r, bytes, top.is_implicit, &h);
    return status == SC_OK ? read_value(r, n, &h, first) : status;
}

/* Go through the data set. */
static sc_status walk(reader *r)
{
    nesting n = {.levels[0] = {.end = r->end, .is_implicit = r->coding.is_implicit}};
    uint32_t first = 0;
    bool end = false;
    sc_status status = SC_OK;

    while (!end && status == SC_OK) {
        status = read_element(r, &n, &first, &end);
        r->elements++;
        if (status == SC_OK && r->elements % 4096 == 0)
            status = check_cost(r, 0);
        while (status == SC_OK && !first && n.depth > 0 && n.levels[n.depth].end == r->at)
            n.depth--;
    }
    return status == SC_OK ? check_cost(r, 0) : status;
}

/* Walk the data set at which @p r->file stands. */
static sc_status check_data_set(reader *r)
{
    const off_t begin = ftello(r->file);
    SC_OWN(sc_compressed_close) sc_compressed_file *deflated = NULL;

    r->end = NO_END;
    if (!r->coding.is_deflated) {
        if (fseeko(r->file, 0, SEEK_END) == 0)
            r->end = (uint64_t)(ftello(r->file) - begin);
        if (r->end == NO_END || fseeko(r->file, begin, SEEK_SET))
            return sc_fail(r->ctx, SC_ERR_WRITE, "%s: %s", r->path, strerror(errno));
        return walk(r);
    }
    SC_PASS(
        sc_compressed_open(r->ctx, r->path, (uint64_t)begin, SC_COMPRESSION_DEFLATE, &deflated));
    r->deflated = deflated;
    SC_PASS(walk(r));
    if (!sc_compressed_has_ended(deflated))
        return sc_fail(
            r->ctx, SC_ERR_DATA,
            "%s: its deflated data set cannot be unpacked to its end; the file is damaged "
            "or cut short: get it anew",
            r->path);
    return SC_OK;
}

sc_status sc_dicom_check(const sc_ctx *ctx, const char *path, sc_dicom_kind *out)
{
    reader r = {.ctx = ctx, .path = path};
    char class_uid[UID_BYTES], syntax_uid[UID_BYTES];
    SC_OWN(sc_fclose_at) FILE *file = NULL;

    SC_PASS(sc_open_input(ctx, path, &file));
    r.file = file;
    if (!read_meta(file, class_uid, syntax_uid))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: the first group of its attributes cannot be read; the file is damaged "
                       "or cut short: get it anew",
                       path);
    if (!is_segmentation(class_uid))
        return refuse_class(ctx, path, class_uid);
    SC_PASS(coding_of(ctx, path, syntax_uid, &r.coding));
    SC_PASS(check_data_set(&r));
    out->is_labels = strstr(class_uid, "66.7") != NULL;
    out->is_compressed = r.coding.is_compressed;
    return SC_OK;
}

bool sc_dicom_is_segmentation(const char *path, bool *is_dicom)
{
    SC_OWN(sc_fclose_at) FILE *file = fopen(path, "rb");
    char class_uid[UID_BYTES], syntax_uid[UID_BYTES];

    *is_dicom = file && read_meta(file, class_uid, syntax_uid);
    return *is_dicom && is_segmentation(class_uid);
}
