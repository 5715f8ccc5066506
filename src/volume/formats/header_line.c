/* SPDX-License-Identifier: BSD-3-Clause */
/* What the user says of a file beside its header: "0.5x0.5x2 um LPS", or of a file without one:
 * "uint16 512x512x300 0.5x0.5x1 mm LPS big skip 1024". */
#include "source.h"

#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>

enum { WORD_BYTES = 64 };

/* The line while it is read. */
typedef struct header_line {
    const sc_ctx *ctx;
    const char *where; /* for messages */
    bool is_raw;       /* the line has a type: the file has no header */
    bool has_type, has_size, has_spacing, has_unit, has_axes, has_order, has_skip;
    sc_voxel_type type;
    int64_t size[3];
    double spacing[3], unit_mm;
    char axes[4]; /* where x, y and z lead, such as RAS */
    bool big;     /* the highest byte of a number stands first */
    uint64_t skip_bytes;
} header_line;

static const char *const type_names[] = {"int8",    "uint8",   "int16", "uint16",
                                         "int32",   "uint32",  "int64", "uint64",
                                         "float32", "float64", "float", "double"};

/* Log that the word is wrong. @return SC_ERR_DATA always. */
static sc_status refuse(const header_line *r, const char *word, const char *why)
{
    return sc_fail(r->ctx, SC_ERR_DATA,
                   "%s: header: \"%.40s\" %s; expected the spacing of voxels and where x, y and z "
                   "lead, such as "
                   "\"0.5x0.5x2 um LPS\", or, if the file has no header, such as \"uint16 "
                   "512x512x300 0.5x0.5x1 mm "
                   "LPS big skip 1024\"",
                   r->where, word, why);
}

/* Is the word a type? The names are in the order of the types, other words for two of them last. */
static bool is_type(const char *word, sc_voxel_type *type)
{
    for (size_t i = 0; i < SC_COUNT_OF(type_names); i++) {
        *type = (sc_voxel_type)(i < SC_VOXEL_TYPES ? i : i - 2);
        if (!strcmp(word, type_names[i]))
            return true;
    }
    return false;
}

/* Read three numbers with an x between them, and behind them a unit of length, if there is one.
 * @return behind the numbers, NULL if it is something else. */
static const char *three_numbers(const char *word, double out[3])
{
    for (int i = 0; i < 3; i++) {
        const size_t length = strspn(word, "0123456789.eE+-");
        char number[WORD_BYTES], *end;

        if (*word < '0' || *word > '9')
            return NULL;
        snprintf(number, sizeof number, "%.*s", (int)length, word); /* strtod would read 0x36 */
        out[i] = strtod(number, &end);
        word += end - number;
        if (i < 2 && *word++ != 'x')
            return NULL;
    }
    return word;
}

/* Take three numbers: of a file without a header first the size, then the spacing. */
static sc_status take_numbers(header_line *r, const char *word, const double numbers[3],
                              const char *rest)
{
    if (r->is_raw && !r->has_size) {
        for (int i = 0; i < 3; i++) {
            if (numbers[i] != floor(numbers[i]) || numbers[i] < 1 || numbers[i] > INT32_MAX)
                return refuse(r, word, "is no size in voxels");
            r->size[i] = (int64_t)numbers[i];
        }
        r->has_size = true;
        return *rest ? refuse(r, word, "is no size in voxels") : SC_OK;
    }
    if (r->has_spacing)
        return refuse(r, word,
                      r->is_raw ? "stands after a size and a spacing" : "is a second spacing");
    for (int i = 0; i < 3; i++) {
        if (!(numbers[i] > 0))
            return refuse(r, word, "is no spacing above 0");
    }
    memcpy(r->spacing, numbers, sizeof r->spacing);
    r->has_spacing = true;
    if (!*rest)
        return SC_OK;
    r->unit_mm = sc_length_unit_mm(rest);
    r->has_unit = true;
    return r->unit_mm > 0 ? SC_OK : refuse(r, word, "has no known unit of length");
}

/* Are these three letters of the six directions, one of each pair? */
static bool are_axes(const char *word)
{
    static const char *const pairs[] = {"RL", "AP", "SI"};
    unsigned found = 0;

    for (int i = 0; i < 3 && word[i]; i++) {
        for (unsigned k = 0; k < 3; k++)
            found |= strchr(pairs[k], word[i]) ? 1U << k : 0;
    }
    return strlen(word) == 3 && found == 7;
}

/* Are these letters a direction of BrainGlobe, such as asr: where the axes begin, the slowest
 * first?
 * @param out [4] the same as three letters of ours. */
static bool are_origins(const char *word, char out[4])
{
    static const char letters[] = "rlapsi", opposite[] = "LRPAIS";

    for (int i = 0; i < 3; i++) {
        const char *at = word[i] ? strchr(letters, word[i]) : NULL;

        if (!at)
            return false;
        out[2 - i] = opposite[at - letters];
    }
    out[3] = '\0';
    return !word[3] && are_axes(out);
}

/* Log that no such word is known, with what may have been meant. @return SC_ERR_DATA always. */
static sc_status refuse_unknown(const header_line *r, const char *word)
{
    const char *nearest = sc_nearest_word(word, type_names, SC_COUNT_OF(type_names));
    char why[128] = "is not known", axes[4];

    if (are_origins(word, axes))
        snprintf(
            why, sizeof why,
            "is written as BrainGlobe does, where axes begin and the slowest first; here %s says "
            "where they lead",
            axes);
    else if (nearest)
        snprintf(why, sizeof why, "is not known; did you mean %s?", nearest);
    return refuse(r, word, why);
}

/* Take one word, or with "skip" also the next. @param next the word behind it; "" if there is none.
 * @param both receives whether that one was used, too. */
static sc_status take_word(header_line *r, const char *word, const char *next, bool *both)
{
    double numbers[3];
    const char *rest = three_numbers(word, numbers);
    char *end;

    *both = false;
    if (rest)
        return take_numbers(r, word, numbers, rest);
    if (!r->has_type && is_type(word, &r->type)) {
        r->has_type = true;
    } else if (r->is_raw && !r->has_order && (!strcmp(word, "big") || !strcmp(word, "little"))) {
        r->has_order = true;
        r->big = word[0] == 'b';
    } else if (!r->has_axes && are_axes(word)) {
        r->has_axes = true;
        memcpy(r->axes, word, sizeof r->axes);
    } else if (r->is_raw && !r->has_skip && !strcmp(word, "skip") && *next >= '0' && *next <= '9') {
        r->skip_bytes = strtoull(next, &end, 10);
        r->has_skip = *both = true;
        if (*end || r->skip_bytes > SC_VOLUME_BYTES_MAX)
            return refuse(r, next, "is no number of bytes");
    } else if (r->has_spacing && !r->has_unit && sc_length_unit_mm(word) > 0) {
        r->unit_mm = sc_length_unit_mm(word);
        r->has_unit = true;
    } else {
        return refuse_unknown(r, word);
    }
    return SC_OK;
}

/* Copy the next word of *text, which ends at a blank or comma, to word[WORD_BYTES], "" at the end;
 * *text is behind it then. */
static void next_word(const char **text, char *word)
{
    const char *begin = *text + strspn(*text, " \t,;");
    const size_t length = strcspn(begin, " \t,;");

    snprintf(word, WORD_BYTES, "%.*s", (int)(length < WORD_BYTES ? length : WORD_BYTES - 1), begin);
    *text = begin + length;
}

/* Does a line name a type? */
static bool has_type(const char *line)
{
    char word[WORD_BYTES];
    sc_voxel_type type;

    do
        next_word(&line, word);
    while (word[0] && !is_type(word, &type));
    return word[0];
}

/* Read the whole line. */
static sc_status read_line(header_line *r, const char *text)
{
    char word[WORD_BYTES], next[WORD_BYTES];
    const char *all = text;
    sc_status status = SC_OK;

    r->is_raw = has_type(text);
    next_word(&text, word);
    while (word[0] && status == SC_OK) {
        bool both;

        next_word(&text, next);
        status = take_word(r, word, next, &both);
        if (both)
            next_word(&text, next);
        memcpy(word, next, sizeof word);
    }
    if (status == SC_OK && r->is_raw && !r->has_size)
        return refuse(r, all, "gives no size");
    return status;
}

sc_status sc_header_check(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                          bool *is_raw)
{
    header_line r = {.ctx = ctx, .where = sc_read_where(choice, path), .unit_mm = 1};
    const sc_status status = read_line(&r, choice->header ? choice->header : "");

    *is_raw = r.is_raw;
    return status;
}

/* Let voxel axis @p i of a map lead where @p letter says, or where it leads if that is 0, by
 * @p spacing_mm. */
static void set_axis(sc_affine *to_ras_mm, int i, char letter, double spacing_mm)
{
    static const char directions[] = "RASLPI";
    const double before_mm = sc_vec3_length(sc_affine_column(to_ras_mm, i));
    const int direction = letter ? (int)(strchr(directions, letter) - directions) : 0;

    for (int row = 0; row < 3; row++) {
        if (letter)
            to_ras_mm->m[row][i] = row != direction % 3 ? 0
                                   : direction < 3      ? spacing_mm
                                                        : -spacing_mm;
        else
            to_ras_mm->m[row][i] *= spacing_mm / before_mm;
    }
}

sc_status sc_header_apply(const sc_ctx *ctx, const char *path, const sc_read_choice *choice,
                          sc_source *source)
{
    header_line r = {.ctx = ctx, .where = sc_read_where(choice, path), .unit_mm = 1};
    sc_affine *to_ras_mm = &source->to_ras_mm;
    double before[3];

    if (!choice->header || !choice->header[0])
        return SC_OK;
    SC_PASS(read_line(&r, choice->header));
    for (int i = 0; i < 3; i++)
        before[i] = sc_vec3_length(sc_affine_column(to_ras_mm, i));
    for (int i = 0; i < 3; i++)
        set_axis(to_ras_mm, i, r.has_axes ? r.axes[i] : '\0',
                 r.has_spacing ? r.spacing[i] * r.unit_mm : before[i]);
    if (r.is_raw && !r.has_spacing)
        sc_warn(ctx,
                "%s: header: gives no spacing; a voxel is taken to measure 1 x 1 x 1 mm (\"%s\")",
                path, "... 0.5x0.5x1 mm");
    if (!r.is_raw && r.has_spacing)
        sc_info(ctx,
                "%s: its voxels are said to measure %g x %g x %g mm (%g x %g x %g in the file)",
                path, r.spacing[0] * r.unit_mm, r.spacing[1] * r.unit_mm, r.spacing[2] * r.unit_mm,
                before[0], before[1], before[2]);
    if (!r.is_raw && r.has_axes && source->oriented)
        sc_info(ctx, "%s: its axes are said to lead to %s, whatever the file says", path, r.axes);
    source->oriented = source->oriented || r.has_axes;
    return SC_OK;
}

/* Set size, file, encoding, offset_bytes, skip_bytes and swapped of @p source. @return
 * SC_ERR_MISSING, SC_ERR_DATA if the file has not as many bytes as its description says. */
static sc_status find_voxels(const header_line *r, const char *path, sc_source *source)
{
    const size_t each = sc_voxel_type_bytes(source->type);
    struct stat info;
    uint64_t needed, bytes;
    size_t voxels;

    SC_PASS(sc_grid_voxels(r->ctx, r->where, r->size, each, source->size, &voxels));
    if (stat(path, &info))
        return sc_fail(r->ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
    if (!S_ISREG(info.st_mode))
        return sc_fail(r->ctx, SC_ERR_MISSING, "%s: is no file; expected one of raw voxels", path);
    needed = r->skip_bytes + (uint64_t)voxels * each;
    bytes = (uint64_t)info.st_size;
    source->stored.encoding = SC_ENCODING_PLAIN;
    source->stored.offset_bytes = r->skip_bytes;
    if (bytes != needed && sc_is_gzip(path, 0)) {
        SC_PASS(sc_check_file_bytes(r->ctx, path, (double)needed));
        source->stored.encoding = SC_ENCODING_GZIP;
        source->stored.offset_bytes = 0;
        source->stored.skip_bytes = r->skip_bytes;
    } else if (bytes != needed) {
        return sc_fail(
            r->ctx, SC_ERR_DATA,
            "%s: has %llu bytes, but %lld x %lld x %lld voxels of %zu byte%s%s are %llu; "
            "are type and size of `header` right? \"skip N\" leaves out a header",
            path, (unsigned long long)bytes, (long long)r->size[0], (long long)r->size[1],
            (long long)r->size[2], each, each > 1 ? "s" : "",
            r->skip_bytes ? " behind what is skipped" : "", (unsigned long long)needed);
    }
    source->stored.swapped = r->big != (__BYTE_ORDER__ == __ORDER_BIG_ENDIAN__) && each > 1;
    return sc_path_join(r->ctx, "", path, &source->stored.file);
}

sc_status sc_open_raw(const sc_ctx *ctx, const char *path, const sc_read_choice *read,
                      sc_source *out)
{
    header_line r = {.ctx = ctx, .where = sc_read_where(read, path), .unit_mm = 1};
    SC_OWN(sc_source_clear) sc_source source = {.slope = 1};

    SC_PASS(read_line(&r, read->header));
    source.type = r.type;
    SC_PASS(find_voxels(&r, path, &source));
    for (int i = 0; i < 3; i++)
        source.to_ras_mm.m[i][i] = 1;
    SC_HAND_OVER(source, out);
    return SC_OK;
}
