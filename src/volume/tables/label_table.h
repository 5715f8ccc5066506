/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: the parts that label tables are read with. */
#ifndef SC_VOLUME_LABEL_TABLE_H
#define SC_VOLUME_LABEL_TABLE_H

#include "source.h"

enum {
    SC_TABLE_BYTES_MAX = 64 << 20, /* longer texts of label tables are refused */
    SC_JSON_BYTES_MAX = 16 << 20,  /* so is longer JSON, which takes far more memory than text */
    SC_TABLE_ROWS_MAX = 1 << 20,   /* and more rows: 16 for each label that a volume can have */
    SC_COLUMNS_MAX = 64            /* columns of a table that are looked at */
};

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

/* Rows of columns on their way into a label table. What levels of colour and opacity mean, from 0
 * to 1 or from 0 to 255, is known only when all of them were seen. */
typedef struct sc_column_rows {
    sc_label_table *table; /* to which rows are appended */
    size_t first;          /* its rows before */
    float (*levels)[4]; /* [level_capacity] red, green, blue, opacity of the rows since then; NAN:
                           none; owned */
    size_t level_capacity;
    float most[2];   /* the largest level of colour, and of opacity */
    size_t clear;    /* rows whose opacity is 0 */
    size_t full;     /* rows whose opacity is 255 */
    sc_column alpha; /* what the opacities are; SC_COLUMN_COLOR: part of colours;
                              SC_COLUMN_OTHER: there are none */
    sc_name_count names;
    size_t bad_colors; /* rows whose colour cannot be read */
    char bad_color[64];
} sc_column_rows;
/* Begin to append to @p table. Ended by sc_column_rows_end, also after an error. */
sc_column_rows sc_column_rows_begin(sc_label_table *table);
/* Append the row of these fields, [count], of columns that are settled; the row of label 0 is left
 * out, and counts as read. @param read set to whether the row has a number.
 * @return SC_ERR_MEMORY, logged; SC_ERR_DATA, not logged, if there are too many rows. */
sc_status sc_column_rows_add(const sc_ctx *ctx, sc_column_rows *rows, const sc_column *columns,
                             const char *const *fields, size_t count, bool *read);
/* Read rrggbb, rrggbbaa or rgb, hexadecimal, into levels from 0 to 255. @return whether it is one
 * of these; level[3] is NAN without opacity. */
bool sc_hexadecimal_read(const char *text, float level[4]);
/* Give the rows their colours and opacities, warn under @p path of what could not be read, and free
 * what @p rows owns. */
void sc_column_rows_end(const sc_ctx *ctx, const char *path, sc_column_rows *rows);

/* Read a row of a list of classes, which is changed: a number, what separates it, a name, and
 * perhaps a colour, "#ff8000" or three or four numbers from 0 to 255. @param row of which value and
 * name are set, and the colour if there is one. @return false if the line has not this form. */
bool sc_class_parse(char *line, sc_label *row, sc_name_count *names);
/* Does the line look like one of a class list: a number, something that separates it, and a letter
 * or a quote? *has_color: it ends with a colour; *more_fields: with something else behind number
 * and name. */
bool sc_class_is(const char *line, bool *has_color, bool *more_fields);

/* Cut off the line that begins at @p line, which is changed: its end, one of CR, LF or both,
 * becomes NUL. @return the next line; NULL behind the last one. Each line is cut before anything
 * reads it, because sscanf and strtod look for the end of the string first: on the whole text their
 * time would be the square of its length. */
char *sc_label_cut_line(char *line);
/* Does @p text begin as a label list of Connectome Workbench: a line with a name, and one with five
 * whole numbers below it? */
bool sc_label_workbench_is(const char *text);
/* Append the rows of @p text, which is cut into lines, to @p table, as SC_TABLE_WORKBENCH.
 * @return SC_ERR_DATA, logged under @p path; SC_ERR_MEMORY. */
sc_status sc_label_workbench_parse(const sc_ctx *ctx, const char *path, char *text,
                                   sc_label_table *table);

/* Does the first line of @p text that is no comment name the columns of a label table, which
 * commas, semicolons, tabs or bars separate? *delimiter is what separates them. */
bool sc_label_delimited_is(const char *text, char *delimiter);
/* Append the rows of @p text, which is taken apart, to @p table, as SC_TABLE_DELIMITED.
 * @return SC_ERR_DATA, logged under @p path; SC_ERR_MEMORY. */
sc_status sc_label_delimited_parse(const sc_ctx *ctx, const char *path, char *text,
                                   sc_label_table *table);
/* Append the rows of the JSON document text[bytes] to @p table, as SC_TABLE_JSON.
 * @return SC_ERR_DATA, logged under @p path; SC_ERR_MEMORY. */
sc_status sc_label_json_parse(const sc_ctx *ctx, const char *path, const char *text, size_t bytes,
                              sc_label_table *table);
struct json_t; /* of jansson */
/* As sc_label_json_parse, of a document that has been read. */
sc_status sc_label_json_read(const sc_ctx *ctx, const char *path, struct json_t *root,
                             sc_label_table *table);

#endif
