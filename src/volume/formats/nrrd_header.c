/* SPDX-License-Identifier: BSD-3-Clause */
#include "formats/nrrd_header.h"
#include "tables/label_table.h"

#include <errno.h>
#include <stdlib.h>
#include <strings.h>
#include <teem/nrrd.h>

enum {
    HEADER_MAX_BYTES = 64 << 20, /* segments and what 3D Slicer notes of them */
    FIELDS_MAX_BYTES = 1 << 20,
    FILES_MAX = 65536,
    FIRST_BYTES = 1 << 16, /* so many are read first, then twice as many, and so on */
    FIELD_NAME_BYTES = 32  /* no field of NRRD has a longer name */
};

/* Where reading a header has got to. */
typedef struct reading {
    const sc_ctx *ctx;
    const char *path;
    int line; /* number of the current line, from 1 */
    sc_nrrd_header *header;
    const char *spacings, *directions; /* values of these fields; NULL: not given */
} reading;

void sc_nrrd_header_clear(sc_nrrd_header *header)
{
    sc_free(header->text);
    sc_text_clear(&header->fields);
    sc_free(header->segments);
    sc_text_clear(&header->list);
    sc_text_clear(&header->paths);
    sc_free(header->first_file);
    *header = (sc_nrrd_header){0};
}

/* ---- the text ---- */

/* Find the empty line that ends a header. *at and *line: where to go on in text[bytes], and where
 * the line begins that goes on there; both are moved. A line ends with LF, CR or both. @return the
 * first byte behind the empty line; 0 if it has not come yet, or, at the @p end of the file, not at
 * all. */
static size_t find_end(const char *text, size_t bytes, bool end, size_t *at, size_t *line)
{
    for (; *at < bytes; (*at)++) {
        const size_t begin = *line;

        if (text[*at] != '\n' && text[*at] != '\r')
            continue;
        if (text[*at] == '\r' && *at + 1 == bytes && !end)
            return 0; /* whether LF follows is not known yet */
        if (text[*at] == '\r' && *at + 1 < bytes && text[*at + 1] == '\n') {
            (*at)++;
            *line = *at + 1;
            if (begin == *at - 1)
                return *line;
            continue;
        }
        *line = *at + 1;
        if (begin == *at)
            return *line;
    }
    return 0;
}

/* Read @p stream up to the empty line or its end: header->text, with a NUL byte behind it,
 * end_bytes and attached; *bytes is the length of the text. @return SC_ERR_DATA if the header is
 * too long, SC_ERR_MEMORY. */
static sc_status read_text(const reading *r, FILE *stream, size_t *bytes)
{
    size_t capacity = FIRST_BYTES, count = 0, at = 0, line = 0, end = 0;
    bool last = false;

    while (!end && !last) {
        if (count >= HEADER_MAX_BYTES)
            return sc_fail(r->ctx, SC_ERR_DATA,
                           "%s: its header does not end within %d bytes, expected an empty line",
                           r->path, HEADER_MAX_BYTES);
        SC_PASS(SC_RESIZE(r->ctx, count, capacity + 1, &r->header->text));
        count += fread(r->header->text + count, 1, capacity - count, stream);
        last = count < capacity;
        end = find_end(r->header->text, count, last, &at, &line);
        capacity *= 2;
    }
    *bytes = end ? end : count;
    r->header->text[*bytes] = '\0';
    r->header->attached = end != 0;
    r->header->end_bytes = end;
    return SC_OK;
}

/* Cut off the line at @p line. @return the next one; NULL behind the last. */
static char *cut_line(char *line)
{
    char *next = sc_label_cut_line(line);

    return next && *next ? next : NULL;
}

/* ---- data files ---- */

/* Add one data file to list, paths, file_count, first_file and file_bytes. */
static sc_status add_file(reading *r, const char *name)
{
    sc_nrrd_header *h = r->header;
    uint64_t bytes = 0;
    SC_OWN(sc_free_at) char *path = NULL;

    if (h->file_count == FILES_MAX)
        return sc_fail(r->ctx, SC_ERR_DATA,
                       "%s:%d: names more than %d data files; join them, for example with Teem: "
                       "`unu join -a 2 -i FILE... -o labels.nrrd`",
                       r->path, r->line, FILES_MAX);
    SC_PASS(sc_data_file(r->ctx, r->path, "data file", name, &path, &bytes));
    SC_PASS(sc_text_add(r->ctx, &h->paths, "%s%c", path, '\0'));
    if (!h->first_file)
        SC_HAND_OVER(path, &h->first_file);
    h->file_count++;
    h->file_bytes += bytes;
    return sc_text_add(r->ctx, &h->list, "%s\n", name);
}

/* Add the files of "x%03d.raw 1 20 1 2": the numbers from 1 to 20 in steps of 1; the last number,
 * which may be missing, is the dimension of a file. @p value is changed. */
static sc_status add_pattern(reading *r, char *value)
{
    char *numbers = value + strcspn(value, " \t");
    long long from, to, step;
    sc_name_pattern pattern;
    int used = 0;
    unsigned dimension = 0;
    SC_OWN(sc_text_clear) sc_text name = {0};

    if (*numbers)
        *numbers++ = '\0';
    if (sscanf(numbers, "%11lld %11lld %11lld%n", &from, &to, &step, &used) != 3 || step == 0 ||
        (to - from) / step < 0 ||
        (numbers[used] && numbers[used] != ' ' && numbers[used] != '\t') ||
        !sc_name_pattern_read(value, &pattern))
        return sc_fail(r->ctx, SC_ERR_DATA,
                       "%s:%d: data file is \"%.80s %.80s\", expected a pattern such as "
                       "\"x%%03d.raw 1 20 1\": first number, last number, step",
                       r->path, r->line, value, numbers);
    if ((to - from) / step >= FILES_MAX)
        return sc_fail(r->ctx, SC_ERR_DATA,
                       "%s:%d: data file names %lld files, expected at most %d; join them, for "
                       "example with Teem: `unu join -a 2 -i FILE... -o labels.nrrd`",
                       r->path, r->line, (to - from) / step + 1, FILES_MAX);
    if (sscanf(numbers + used, "%3u", &dimension) == 1)
        SC_PASS(sc_text_add(r->ctx, &r->header->list, "data file: LIST %u\n", dimension));
    else
        SC_PASS(sc_text_add(r->ctx, &r->header->list, "data file: LIST\n"));
    for (long long i = 0; i <= (to - from) / step; i++) {
        SC_PASS(sc_name_pattern_write(r->ctx, &pattern, from + i * step, &name));
        SC_PASS(add_file(r, name.data));
    }
    return SC_OK;
}

/* Take the value of the field "data file"; *next is the line behind it, moved behind the names of a
 * list. */
static sc_status read_data_file(reading *r, char *value, char **next)
{
    const char *dimension = value + 4;

    if (r->header->file_count)
        return sc_fail(r->ctx, SC_ERR_DATA, "%s:%d: data file is given twice", r->path, r->line);
    if (!strncmp(value, "SKIPLIST", 8))
        return sc_fail(r->ctx, SC_ERR_DATA,
                       "%s:%d: data file is SKIPLIST, which segcast does not read; save the volume "
                       "as one file, for example with Teem: `unu save -f nrrd -i IN -o OUT.nrrd`",
                       r->path, r->line);
    if (strchr(value, '%'))
        return add_pattern(r, value);
    if (strncmp(value, "LIST", 4) != 0) {
        SC_PASS(sc_text_add(r->ctx, &r->header->list, "data file: "));
        return add_file(r, value);
    }
    if (strlen(dimension) > 8 || dimension[strspn(dimension, " \t0123456789")])
        return sc_fail(r->ctx, SC_ERR_DATA,
                       "%s:%d: data file is \"%.80s\", expected LIST and the dimension of a file",
                       r->path, r->line, value);
    SC_PASS(sc_text_add(r->ctx, &r->header->list, "data file: %s\n", value));
    while (*next && **next) {
        char *name = *next;

        *next = cut_line(name);
        r->line++;
        if (*name)
            SC_PASS(add_file(r, name));
    }
    return SC_OK;
}

/* ---- keys and values ---- */

/* The member of segment @p number; its array is made longer if needed. */
static sc_status segment_at(const reading *r, size_t number, sc_nrrd_segment **out)
{
    sc_nrrd_header *h = r->header;

    if (number >= h->segment_capacity) {
        size_t capacity = h->segment_capacity ? h->segment_capacity : 64;

        while (capacity <= number)
            capacity *= 2;
        SC_PASS(SC_RESIZE(r->ctx, h->segment_count, capacity, &h->segments));
        memset(h->segments + h->segment_count, 0,
               (capacity - h->segment_count) * sizeof *h->segments);
        h->segment_capacity = capacity;
    }
    if (number >= h->segment_count)
        h->segment_count = number + 1;
    *out = &h->segments[number];
    return SC_OK;
}

/* Keep the value of a key such as Segment7_Name, or the groups of labels of MITK; of a key that
 * comes twice the last value holds, and other keys are ignored. Both texts are freed of their
 * escapes (backslash n) in place. */
static sc_status read_key(const reading *r, char *key, char *value)
{
    static const struct {
        const char *name;
        size_t offset;
    } fields[] = {{"_ID", offsetof(sc_nrrd_segment, id)},
                  {"_LabelValue", offsetof(sc_nrrd_segment, value)},
                  {"_Name", offsetof(sc_nrrd_segment, name)},
                  {"_Color", offsetof(sc_nrrd_segment, color)},
                  {"_Layer", offsetof(sc_nrrd_segment, layer)}};
    sc_nrrd_segment *segment;
    size_t number;
    char *end;

    airUnescape(key);
    if (!strcmp(key, "org.mitk.multilabel.segmentation.labelgroups")) {
        airUnescape(value);
        r->header->label_groups = value;
        return SC_OK;
    }
    if (strncmp(key, "Segment", 7) != 0 || key[7] < '0' || key[7] > '9' ||
        (key[7] == '0' && key[8] != '_'))
        return SC_OK;
    number = strtoul(key + 7, &end, 10);
    for (size_t i = 0; i < SC_COUNT_OF(fields) && number < SC_LABELS_MAX; i++) {
        if (!strcmp(end, fields[i].name)) {

            SC_PASS(segment_at(r, number, &segment));
            airUnescape(value);
            *(const char **)((char *)segment + fields[i].offset) = value;
        }
    }
    return SC_OK;
}

/* ---- lines ---- */

/* The value of the line if it is a field of NRRD ("sizes: 4 4 4"), and *field which one; NULL for
 * other lines. */
static char *field_of(char *line, int *field)
{
    char *colon = strstr(line, ": "), name[FIELD_NAME_BYTES];

    if (!colon || (size_t)(colon - line) >= sizeof name)
        return NULL;
    memcpy(name, line, (size_t)(colon - line));
    name[colon - line] = '\0';
    *field = airEnumVal(nrrdField, name);
    return *field == nrrdField_unknown ? NULL : colon + 2 + strspn(colon + 2, " \t");
}

/* Check that the value of the field "sizes" consists of numbers of samples: Teem says of all others
 * that they are zero. */
static sc_status check_sizes(const reading *r, const char *value)
{
    const char *at = value + strspn(value, " \t");

    while (*at) {
        char *end;
        long long size;

        errno = 0;
        size = strtoll(at, &end, 10);
        if (end == at || (*end && *end != ' ' && *end != '\t') || size < 1 || errno)
            return sc_fail(r->ctx, SC_ERR_DATA,
                           "%s:%d: sizes is \"%.80s\", expected for each axis how many samples it "
                           "has, a whole number from 1 on",
                           r->path, r->line, value);
        at = end + strspn(end, " \t");
    }
    return SC_OK;
}

/* @return the value of the next axis in the text of "space directions", a vector or the word none,
 * and move *at behind it; NULL behind the last. */
static const char *next_direction(const char **at)
{
    const char *begin = *at + strspn(*at, " \t");
    const size_t length = *begin == '(' ? strcspn(begin, ")") : strcspn(begin, " \t");

    *at = begin + length + (*begin == '(' && begin[length]);
    return *begin ? begin : NULL;
}

/* Add the field "spacings" to the fields. Axes with a direction have their spacing in its length: a
 * second one, which the format forbids and Teem refuses, is left out, with a warning. */
static sc_status add_spacings(const reading *r)
{
    const char *spacing = r->spacings, *directions = r->directions ? r->directions : "";
    bool doubled = false;

    if (!spacing)
        return SC_OK;
    SC_PASS(sc_text_add(r->ctx, &r->header->fields, "spacings:"));
    for (spacing += strspn(spacing, " \t"); *spacing; spacing += strspn(spacing, " \t")) {
        const int length = (int)strcspn(spacing, " \t");
        const char *direction = next_direction(&directions);
        const bool has_both = direction && *direction == '(' && strncasecmp(spacing, "nan", 3) != 0;

        SC_PASS(sc_text_add(r->ctx, &r->header->fields, " %.*s", has_both ? 3 : length,
                            has_both ? "nan" : spacing));
        doubled = doubled || has_both;
        spacing += length;
    }
    SC_PASS(sc_text_add(r->ctx, &r->header->fields, "\n"));
    if (doubled)
        sc_warn(r->ctx,
                "%s: has spacings beside space directions, which say the same; the directions are "
                "used",
                r->path);
    return SC_OK;
}

/* Sort one line into the header; *next as in read_data_file. */
static sc_status read_line(reading *r, char *line, char **next)
{
    int field = nrrdField_unknown;
    char *value, *separator;

    if (*line == '#')
        return SC_OK;
    value = field_of(line, &field);
    if (value && field == nrrdField_data_file)
        return read_data_file(r, value, next);
    separator = value ? NULL : strstr(line, ":=");
    if (separator) {
        *separator = '\0';
        return read_key(r, line, separator + 2);
    }
    if (value && field == nrrdField_sizes)
        SC_PASS(check_sizes(r, value));
    if (value && field == nrrdField_space_directions)
        r->directions = value;
    if (value && field == nrrdField_spacings && !r->spacings) {
        r->spacings = value;
        return SC_OK;
    }
    if (r->header->fields.length_bytes + strlen(line) > FIELDS_MAX_BYTES)
        return sc_fail(r->ctx, SC_ERR_DATA,
                       "%s:%d: the fields of the header are longer than %d bytes", r->path, r->line,
                       FIELDS_MAX_BYTES);
    return sc_text_add(r->ctx, &r->header->fields, "%s\n", line);
}

sc_status sc_nrrd_header_read(const sc_ctx *ctx, const char *path, sc_nrrd_header *out)
{
    SC_OWN(sc_nrrd_header_clear) sc_nrrd_header header = {0};
    reading r = {.ctx = ctx, .path = path, .header = &header};
    SC_OWN(sc_fclose_at) FILE *stream = NULL;
    uint64_t file_bytes;
    size_t bytes = 0;

    SC_PASS(sc_open_input(ctx, path, &stream));
    SC_PASS(sc_input_bytes(ctx, path, &file_bytes));
    SC_PASS(read_text(&r, stream, &bytes));
    if (strlen(header.text) != bytes)
        return sc_fail(ctx, SC_ERR_DATA, "%s: byte %zu of its header is NUL, expected text", path,
                       strlen(header.text));
    for (char *line = header.text, *next; line && *line; line = next) {
        r.line++;
        next = cut_line(line);
        if (*line)
            SC_PASS(read_line(&r, line, &next));
    }
    SC_PASS(add_spacings(&r));
    if (header.file_count) { /* also if an empty line follows, as pynrrd writes it */
        header.attached = false;
        header.end_bytes = 0;
    } else {
        header.file_bytes = file_bytes;
    }
    if (!header.file_count && !header.attached)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: not a readable NRRD: its header has neither an empty line, behind "
                       "which the voxels begin, nor a data file",
                       path);
    SC_HAND_OVER(header, out);
    return SC_OK;
}
