/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the parts that label tables are read with. */
#ifndef SC_VOLUME_LABEL_TABLE_H
#define SC_VOLUME_LABEL_TABLE_H

#include "source.h"

enum {
    SC_TABLE_BYTES_MAX = 64 << 20, /* longer texts of label tables are refused */
    SC_JSON_BYTES_MAX = 16 << 20,  /* so is longer JSON, which takes far more memory than text */
    SC_TABLE_ROWS_MAX = 1 << 20,   /* and more rows: 16 for each label that a volume can have */
    SC_COLUMNS_MAX = 64,           /* columns of a table that are looked at */
    SC_FIELD_BYTES = 4 * SC_NAME_BYTES, /* of a longer field of JSON or XML the rest is left out */
    SC_HEADING_BYTES = 8192,            /* longer lines are no headings */
    SC_XML_WHY_BYTES = 256
};

/* Text in which commas, semicolons, tabs or bars separate fields (RFC 4180, but for the separator).
 * SC_DELIMITERS: what may separate them. */
#define SC_DELIMITERS "\t,;|"

/* Take the line at *at apart; a field in quotation marks may go over several. @param fields [most];
 * what is beyond is left out. *at moves to the next line; NULL behind the last one. @param lines
 * counts the lines that were read. @return the number of fields. */
size_t sc_delimited_record(char **at, char delimiter, char **fields, size_t most, int *lines);
/* @return the line behind @p line, whatever quotation marks are in that; NULL behind the last one.
 */
char *sc_delimited_next_line(char *line);
/* @return the first line that is neither blank nor a comment. @param lines counts those before. */
const char *sc_delimited_skip_comments(const char *text, int *lines);

/* Turn a text of *bytes bytes, behind which a NUL byte stands, into UTF-8 without a byte order
 * mark: UTF-16 and UTF-32 are told by it; a text that is no UTF-8 anywhere, and no XML, is taken as
 * Windows-1252, of which Latin-1 is a part, and that is said. What cannot be decoded becomes
 * U+FFFD. *text, which sc_alloc has given, is replaced where it changes.
 * @return SC_ERR_DATA for a NUL character, and for a part of a character at the end;
 * SC_ERR_MEMORY; both logged under @p path. */
sc_status sc_label_text_decode(const sc_ctx *ctx, const char *path, char **text, size_t *bytes);

/* What a column of a table holds, told by its heading. */
typedef enum sc_column {
    SC_COLUMN_OTHER, /* nothing that is used */
    SC_COLUMN_VALUE, /* the number of the label */
    SC_COLUMN_RIGHT, /* two numbers of one row: of the part on the right, and of that on the left */
    SC_COLUMN_LEFT,
    SC_COLUMN_NAME,
    SC_COLUMN_LABEL, /* the name; the number, if no column has it and another one has the name */
    SC_COLUMN_SHORT, /* a short name, used if there is no other */
    SC_COLUMN_COLOR, /* all of a colour in one text */
    SC_COLUMN_RED,
    SC_COLUMN_GREEN,
    SC_COLUMN_BLUE,
    SC_COLUMN_ALPHA,        /* opacity, or as FreeSurfer writes it, transparency */
    SC_COLUMN_OPACITY,      /* opacity for sure */
    SC_COLUMN_TRANSPARENCY, /* its opposite */
    SC_COLUMN_VISIBLE,
    SC_COLUMN_MEANING, /* what the code of a terminology means, the name of rows without one */
    SC_COLUMN_MODIFIER /* what is added to it, such as "Left" */
} sc_column;
/* @return what a column with this heading holds; case, blanks and punctuation are ignored. */
sc_column sc_column_of(const char *heading);
/* Decide what SC_COLUMN_LABEL and SC_COLUMN_SHORT mean beside the other columns: they become
 * SC_COLUMN_VALUE, SC_COLUMN_NAME or SC_COLUMN_OTHER; and of several columns of a kind the first
 * counts. @return whether there is a number, and a name or a colour. */
bool sc_columns_settle(sc_column *columns, size_t count);

/* A row of a table, whatever it is written in: fields, and what each holds. */
typedef struct sc_row {
    size_t count;
    sc_column columns[SC_COLUMNS_MAX];
    const char *fields[SC_COLUMNS_MAX];         /* borrowed, or in texts */
    char texts[SC_COLUMNS_MAX][SC_FIELD_BYTES]; /* of fields that stand nowhere else */
    int line;                                   /* where it begins; 0: not known */
} sc_row;
/* Add a field; nothing if the row is full. @param field NULL: it is written to the texts by who
 * calls. @return the text of the field, of SC_FIELD_BYTES, empty; NULL if the row is full. */
char *sc_row_add(sc_row *row, sc_column column, const char *field);

/* Read the whole number of a label and nothing else. */
bool sc_label_value_read(const char *text, int64_t *out);

/* What programs write differently in rows of the same grammar. */
typedef struct sc_dialect {
    const char *name; /* for messages */
    /* Headings of columns that stand in this order in every row; NULL: the text names them. */
    const char *headings;
    size_t columns_least; /* fields that a row of these headings has to have */
    float full[2];        /* the level of full colour, and of opacity; 0: the levels tell */
    bool is_strict;       /* levels beyond are no levels; else they are brought into the range */
    int64_t highest;      /* number of a label, from 0 on; 0: any */
    const char *where[2]; /* the place of a row: what stands before its line, and behind it */
    const char *rows[2];  /* what rows are called: of one, of several */
    const char *lack;     /* what a row that is left out has not */
    const char *refused;  /* why a table without any row is refused, behind the place of a row */
    const char *empty;    /* why one without rows is; NULL: it is not */
} sc_dialect;

/* The rows of a table on their way to labels. What levels of colour and opacity mean, from 0 to 1
 * or from 0 to 255, is known only when all of them were seen, unless the dialect says it. */
typedef struct sc_rows {
    const sc_ctx *ctx;
    const char *path; /* for messages */
    const sc_dialect *dialect;
    sc_label_table *table; /* to which labels are appended */
    size_t first;          /* its labels before */
    double (*levels)[4];   /* [level_capacity] red, green, blue, opacity of the labels since then;
                              NAN: none; owned */
    size_t level_capacity;
    double most[2];       /* the largest level of colour, and of opacity */
    size_t clear, opaque; /* labels whose opacity is 0, or 255 */
    sc_column alpha;      /* what the opacities are; SC_COLUMN_COLOR: part of colours;
                             SC_COLUMN_OTHER: there are none */
    sc_name_count names;
    size_t bad_colors; /* rows whose colour cannot be read */
    char bad_color[64];
    bool any;      /* a row was read, be it that of label 0 */
    size_t unread; /* rows that are no labels, and the line of the first of them */
    int first_unread;
    sc_status status; /* the first error, logged */
} sc_rows;
/* Begin to append to @p table. Ended by sc_rows_end, also after an error. */
sc_rows sc_rows_begin(const sc_ctx *ctx, const char *path, const sc_dialect *dialect,
                      sc_label_table *table);
/* Append the labels of a row whose columns are settled, unless there was an error; that of label 0
 * is left out. rows->status may become SC_ERR_MEMORY, or SC_ERR_DATA for too many rows, logged. */
void sc_rows_add(sc_rows *rows, const sc_row *row);
/* Count a row that is left out. */
void sc_rows_skip(sc_rows *rows, int line);
/* Give the labels their colours and opacities, warn of what could not be read, and free what @p
 * rows owns. @return rows->status; SC_ERR_DATA, logged, if there are no labels. */
sc_status sc_rows_end(sc_rows *rows);

/* A table in text while its rows are cut into fields. */
typedef struct sc_text_reading {
    sc_row row;
    sc_column columns[SC_COLUMNS_MAX]; /* of every row */
    size_t column_count, columns_least;
    char *headings[SC_COLUMNS_MAX]; /* [column_count] in heading_line, if the text has them */
    char heading_line[SC_HEADING_BYTES];
    char *at; /* the rest of the text; NULL: it has ended */
    char delimiter;
    bool is_slicer; /* names are written as 3D Slicer writes them */
    int line;       /* number of the last line that was read, counted from 1 */
} sc_text_reading;
/* Cut the next row off the text, into the fields of t->row. @return whether it has the form of one.
 */
typedef bool sc_row_cut(sc_text_reading *t);
/* Words that blanks separate, in the order of t->columns; a name at the end stands in quotes. */
sc_row_cut sc_row_cut_words;
/* A line with the name, and one with the other columns. */
sc_row_cut sc_row_cut_pair;
/* Fields that t->delimiter separates, which may go over several lines in quotes. */
sc_row_cut sc_row_cut_delimited;
/* A row of a list of classes: a number, what separates it, a name, and perhaps a colour, "#ff8000"
 * or three or four numbers from 0 to 255. */
sc_row_cut sc_row_cut_class;

/* Find the headings of a text that commas, semicolons, tabs or bars separate: in the first line
 * that is no comment, or in the comment above it, as in info_label.txt of the Spinal Cord Toolbox.
 * t->at becomes the first row. @return whether they are those of a label table. */
bool sc_headings_find(char *text, sc_text_reading *t);
/* The same of a text without headings whose first row is a number, a name and perhaps a colour. */
bool sc_headings_guess(char *text, sc_text_reading *t);
/* Does @p text begin as a label list of Connectome Workbench: a line with a name, and one with five
 * whole numbers below it? */
bool sc_label_workbench_is(const char *text);
/* Does the line look like one of a class list: a number, something that separates it, and a letter
 * or a quote? *has_color: it ends with a colour; *more_fields: with something else behind number
 * and name. */
bool sc_class_is(char *line, bool *has_color, bool *more_fields);
/* Cut off the line that begins at @p line, which is changed: its end, one of CR, LF or both,
 * becomes NUL. @return the next line; NULL behind the last one. Each line is cut before anything
 * reads it, because sscanf and strtod look for the end of the string first: on the whole text their
 * time would be the square of its length. */
char *sc_label_cut_line(char *line);
/* @return @p text without the blanks around it, which are cut off. */
char *sc_label_trim(char *text);

/* Append the rows of the JSON document text[bytes] to @p table, as SC_TABLE_JSON.
 * @return SC_ERR_DATA, logged under @p path; SC_ERR_MEMORY. */
sc_status sc_label_json_parse(const sc_ctx *ctx, const char *path, const char *text, size_t bytes,
                              sc_label_table *table);
struct json_error_t;
struct json_t; /* of jansson */
/* Read a document, as json_loadb without flags does. The caller owns it. Any thread. */
struct json_t *sc_json_load(const char *text, size_t bytes, struct json_error_t *error);
/* Did the last sc_json_load of this thread fail for want of memory? */
bool sc_json_lacks_memory(const struct json_error_t *error);
/* As sc_label_json_parse, of a document that has been read. */
sc_status sc_label_json_read(const sc_ctx *ctx, const char *path, struct json_t *root,
                             sc_label_table *table);

/* Append the rows of the XML document text[bytes] to @p table: of the first <LabelTable> elements
 * <Label Key="4" Red="1" Green="0.5" Blue="0" Alpha="1">name</Label>, as GIFTI, Connectome
 * Workbench and TotalSegmentator write them, or of the data of an atlas of FSL, or of a set of
 * labels of BrainSuite. Attributes, and elements within, are columns. Entities are not expanded: a
 * document whose DOCTYPE has declarations of its own is refused.
 * @param why receives, for SC_ERR_DATA, which is not logged, what is wrong: the document is no XML
 * or has no label table, or segcast was built without Expat. @return also SC_ERR_MEMORY, logged.
 * After an error @p table is as it was, but for its capacity. */
sc_status sc_label_xml_parse(const sc_ctx *ctx, const char *path, const char *text, size_t bytes,
                             sc_label_table *table, char why[SC_XML_WHY_BYTES]);

/* ---- label tables within files of volumes ---- */

/* Append the rows of the colour table behind the voxels of an MGH file to @p table: number, name,
 * colour and opacity of each label but 0. @param end where the voxels end, unpacked; what is before
 * is unpacked and left out. Tags that cannot be followed end the search silently, since they are
 * optional and FreeSurfer adds new ones; a colour table that cannot be read gives a warning.
 * @return SC_ERR_MEMORY, SC_ERR_WRITE, SC_ERR_MISSING, logged. */
sc_status sc_mgh_labels(const sc_ctx *ctx, const char *path, uint64_t end, sc_label_table *table);
/* Append the rows of the first label table in the header extensions of a NIfTI file to @p table:
 * XML as of sc_label_xml_parse, in an extension of any code (Connectome Workbench writes 30,
 * TotalSegmentator 0). @param begin,end the bytes of the file, unpacked, from behind the header to
 * before the voxels; what lies beyond the end of the file does not count. @param swapped the header
 * is in the byte order that this machine does not have. Extensions that are damaged or larger than
 * 64 MiB, and a table that cannot be read, give a warning. @return SC_ERR_MEMORY, SC_ERR_WRITE,
 * SC_ERR_MISSING, logged. */
sc_status sc_nifti_labels(const sc_ctx *ctx, const char *path, uint64_t begin, uint64_t end,
                          bool swapped, sc_label_table *table);

#endif
