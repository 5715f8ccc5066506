/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Lines of text as pixels. They are made once, by one process that has the fonts, and can then be
 *  sent to others as bytes: all draw the same pixels, whichever fonts and libraries they have.
 *  Letters are drawn without hinting and with grey levels, not colours, at their edges. Letters
 *  stand side by side in the order of the text: it is not turned around, and none are joined. */
#ifndef SEGCAST_LETTERING_H
#define SEGCAST_LETTERING_H

#include "segcast/overlay.h"

/** A bold font of one family, with others for characters that it lacks. Threads: one at a time. */
typedef struct sc_font sc_font;

/** Find the font. @param family for example "DejaVu Sans". @param where as sc_tissue_rule.where, of
 *  the key that names it. @return SC_ERR_DATA if there is no such family, with those that there
 *  are; SC_ERR_SYSTEM if there is no font at all; SC_ERR_MEMORY. Caller owns: sc_font_close. */
SC_MUST_USE sc_status sc_font_open(const sc_ctx *ctx, const char *family, const char *where,
                                   sc_font **out);
/** Free a font; NULL is allowed. */
void sc_font_close(sc_font *font);
SC_CLOSE_AT(sc_font_close, sc_font)
/** @return the path of the file of the font; owned by it. */
const char *sc_font_file(const sc_font *font);
/** @return the width of a line of text in pixels, its halo not counted. @param text UTF-8.
 *  @param bytes how many of them belong to the line. */
double sc_font_width_px(sc_font *font, const char *text, size_t bytes, double size_px);
/** @return why a character cannot be drawn, as words that follow the character in a message, or
 *  NULL if it can: one that a terminal would obey, or of a script that is written from right to
 *  left or whose letters change their shape beside others. @param code its number. */
const char *sc_font_refuses(unsigned code);

/** A line of text that is to become pixels. */
typedef struct sc_text_line {
    int kind, number; /**< the caller's own, by which the line is found again */
    int32_t data;     /**< the caller's own */
    const char *text; /**< [bytes] of UTF-8, borrowed */
    size_t bytes;
    double size_px; /**< font size */
} sc_text_line;

/** One line of text as pixels. */
typedef struct sc_word {
    int32_t kind, number, data;   /**< as of sc_text_line */
    int32_t left_px, top_px;      /**< upper left corner of its pixels, from where the text begins
                                       on its base line; y down */
    int32_t width_px, height_px;  /**< of its pixels */
    int32_t advance_px;           /**< from where the text begins to where one behind it does */
    int32_t capitals_px, line_px; /**< height of capital letters; distance of two base lines */
    uint64_t at; /**< where its pixels begin in the lettering: [2][height_px][width_px], how much of
                      each pixel the halo covers, and then the letters, 0 to 255 */
} sc_word;

/** Lines of text as pixels: one block without pointers, which may be copied as bytes. */
typedef struct sc_lettering {
    uint64_t bytes; /**< of the whole block */
    uint64_t count; /**< of words, which stand behind this struct; their pixels follow */
    sc_word words[];
} sc_lettering;

/** What was told about fonts, so that the shots of a film do not tell it again; empty at first. */
typedef struct sc_font_told {
    char family[64];      /**< of the font whose file was named last */
    unsigned missing[64]; /**< [missing_count] characters that no font has */
    size_t missing_count;
} sc_font_told;

/** Turn lines of text into pixels. Warns of characters that no font has, once for each: a box
 *  stands for them. @param told to which they are added; those that are in it are not told again.
 *  @return SC_ERR_MEMORY. Caller owns *out: sc_free. */
SC_MUST_USE sc_status sc_lettering_make(const sc_ctx *ctx, sc_font *font, const sc_text_line *lines,
                                        size_t count, sc_font_told *told, sc_lettering **out);
/** @return the first word of @p kind and @p number, or NULL. */
const sc_word *sc_lettering_find(const sc_lettering *lettering, int kind, int number);
/** Draw a word over @p image at once. @param x and @p y where it begins on its base line, in whole
 *  pixels; it may lie outside of the picture. @param letters its colours; size_px is not read.
 *  @param alpha opacity in [0, 255]. @param rows as of sc_overlay_begin_within. */
void sc_lettering_draw(const sc_lettering *lettering, const sc_word *word, int x, int y,
                       const sc_letters *letters, int alpha, sc_image *image, const sc_rows *rows);

#endif
