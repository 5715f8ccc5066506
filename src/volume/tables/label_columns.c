/* SPDX-License-Identifier: BSD-3-Clause */
/* What the columns of label tables hold, by their headings. */
#include "tables/label_table.h"

#include <ctype.h>

/* Words, blanks between them, and what they mean. */
typedef struct meaning {
    sc_column column;
    const char *words;
} meaning;

/* Headings, without case, blanks and punctuation, that programs write: BIDS (index, name,
 * abbreviation, color), 3D Slicer (LabelValue, Name, Color_R), FastSurfer (ID, LabelName, R, G, B,
 * A), NiiVue (I, labels, R, G, B, A), GIFTI (Key, Red), OME-Zarr (label-value, rgba), the Allen
 * Institute (id, name, acronym, color_hex_triplet), and what people write by hand. */
static const meaning headings[] = {
    {SC_COLUMN_VALUE, "value index idx i id segid key no number num nr voxelvalue pixelvalue "
                      "greyvalue grayvalue maskvalue"},
    {SC_COLUMN_NAME, "name segmentlabel structname structure region tissue organ"},
    {SC_COLUMN_LABEL, "label labels roi segment"},
    {SC_COLUMN_SHORT, "abbreviation acronym description segmentdescription anatomy title term "
                      "material class"},
    {SC_COLUMN_COLOR, "color rgb rgba hex html hexcode hextriplet rgbtriplet rgbvalue "
                      "recommendeddisplayrgbvalue"},
    {SC_COLUMN_RED, "r red"},
    {SC_COLUMN_GREEN, "g green"},
    {SC_COLUMN_BLUE, "b blue"},
    {SC_COLUMN_ALPHA, "a alpha"},
    {SC_COLUMN_OPACITY, "opacity opacity3d"},
    {SC_COLUMN_TRANSPARENCY, "transparency"},
    {SC_COLUMN_VISIBLE, "visible visibility show"},
    {SC_COLUMN_MEANING, "typecodemeaning"},
    {SC_COLUMN_MODIFIER, "typemodifiercodemeaning"}};

/* Words that headings put before what the label is of, and what stands behind them:
 * "segment_name", "ROI number". */
static const char things[] = "label segment region roi structure anatomical class tissue organ "
                             "parcel atlas brain full long display material object area";
static const meaning endings[] = {{SC_COLUMN_VALUE, "value id index idx number num no nr"},
                                  {SC_COLUMN_NAME, "name text title region structure"}};
/* Words beside "color" in headings of whole colours. */
static const meaning color_words[] = {
    {SC_COLUMN_COLOR, "label segment display html web rgb rgba hex value code hextriplet"}};

/* @return whether @p word, of @p bytes, is one of @p words. */
static bool is_among(const char *words, const char *word, size_t bytes)
{
    for (; *words; words += strspn(words, " ")) {
        const size_t length = strcspn(words, " ");

        if (length == bytes && !memcmp(words, word, bytes))
            return true;
        words += length;
    }
    return false;
}

/* @return what @p word means; SC_COLUMN_OTHER: nothing. */
static sc_column find(const meaning *list, size_t count, const char *word)
{
    for (size_t i = 0; i < count; i++) {
        if (is_among(list[i].words, word, strlen(word)))
            return list[i].column;
    }
    return SC_COLUMN_OTHER;
}

/* Cut @p word off the begin or the end of letters. @return whether it stands there. */
static bool cut_off(char *letters, const char *word)
{
    const size_t bytes = strlen(word), all = strlen(letters);

    if (all >= bytes && !strcmp(letters + all - bytes, word))
        letters[all - bytes] = '\0';
    else if (!strncmp(letters, word, bytes))
        memmove(letters, letters + bytes, all - bytes + 1);
    else
        return false;
    return true;
}

/* @return what a heading of two words holds: "roi" and "name", "color" and "red", "right" and
 * "label"; @p letters may be changed. */
static sc_column column_of_two(char *letters)
{
    char *color = strstr(letters, "color");
    const bool right = !color && cut_off(letters, "right");
    sc_column column;

    if (right || (!color && cut_off(letters, "left"))) {
        column = find(headings, SC_COUNT_OF(headings), letters);
        return column != SC_COLUMN_VALUE && column != SC_COLUMN_LABEL ? SC_COLUMN_OTHER
               : right                                                ? SC_COLUMN_RIGHT
                                                                      : SC_COLUMN_LEFT;
    }
    for (size_t bytes = strlen(letters); bytes > 0 && !color; bytes--) {
        column = is_among(things, letters, bytes)
                     ? find(endings, SC_COUNT_OF(endings), letters + bytes)
                     : SC_COLUMN_OTHER;
        if (column != SC_COLUMN_OTHER)
            return column;
    }
    if (!color)
        return SC_COLUMN_OTHER;
    memmove(color, color + strlen("color"), strlen(color + strlen("color")) + 1);
    column = find(headings, SC_COUNT_OF(headings), letters);
    if (column >= SC_COLUMN_RED && column <= SC_COLUMN_ALPHA)
        return column;
    return find(color_words, SC_COUNT_OF(color_words), letters);
}

static char lower(char c)
{
    return (char)tolower((unsigned char)c);
}

/* Copy the letters and digits of a heading to letters[bytes], in lower case, without what stands in
 * brackets, a unit or a range as in "R (0-255)". @return false if there are too many. */
static bool copy_letters(const char *heading, char *letters, size_t bytes)
{
    size_t count = 0;

    for (; *heading && count < bytes - 1; heading++) {
        if ((*heading == '(' || *heading == '[') && count)
            heading += strcspn(heading, ")]");
        if (!*heading)
            break;
        if (isalnum((unsigned char)*heading))
            letters[count++] = lower(*heading);
    }
    letters[count] = '\0';
    return !*heading;
}

sc_column sc_column_of(const char *heading)
{
    char letters[32];
    char *british;
    sc_column column;

    if (!copy_letters(heading, letters, sizeof letters)) /* longer than any that is known */
        return SC_COLUMN_OTHER;
    british = strstr(letters, "colour");
    if (british)
        memmove(british + 4, british + 5, strlen(british + 5) + 1);
    column = find(headings, SC_COUNT_OF(headings), letters);
    return column != SC_COLUMN_OTHER ? column : column_of_two(letters);
}

static bool has_column(const sc_column *columns, size_t count, sc_column wanted)
{
    for (size_t i = 0; i < count; i++) {
        if (columns[i] == wanted)
            return true;
    }
    return false;
}

/* Let columns of the kind @p from be of the kind @p to. */
static void turn(sc_column *columns, size_t count, sc_column from, sc_column to)
{
    for (size_t i = 0; i < count; i++)
        columns[i] = columns[i] == from ? to : columns[i];
}

/* The same if there is none of that kind yet; else they are of no use. */
static void settle(sc_column *columns, size_t count, sc_column from, sc_column to)
{
    turn(columns, count, from, has_column(columns, count, to) ? SC_COLUMN_OTHER : to);
}

bool sc_columns_settle(sc_column *columns, size_t count)
{
    const bool sides = has_column(columns, count, SC_COLUMN_RIGHT) &&
                       has_column(columns, count, SC_COLUMN_LEFT) &&
                       !has_column(columns, count, SC_COLUMN_VALUE);
    const bool named =
        has_column(columns, count, SC_COLUMN_NAME) || has_column(columns, count, SC_COLUMN_SHORT);
    const bool has_value = sides || has_column(columns, count, SC_COLUMN_VALUE);

    settle(columns, count, SC_COLUMN_LABEL, named && !has_value ? SC_COLUMN_VALUE : SC_COLUMN_NAME);
    settle(columns, count, SC_COLUMN_SHORT, SC_COLUMN_NAME);
    if (!sides) {
        turn(columns, count, SC_COLUMN_RIGHT, SC_COLUMN_OTHER);
        turn(columns, count, SC_COLUMN_LEFT, SC_COLUMN_OTHER);
    }
    for (size_t i = 0; i < count; i++) {
        if (columns[i] != SC_COLUMN_OTHER && has_column(columns, i, columns[i]))
            columns[i] = SC_COLUMN_OTHER;
    }
    return (sides || has_column(columns, count, SC_COLUMN_VALUE)) &&
           (has_column(columns, count, SC_COLUMN_NAME) ||
            has_column(columns, count, SC_COLUMN_MEANING) ||
            has_column(columns, count, SC_COLUMN_COLOR) ||
            has_column(columns, count, SC_COLUMN_RED));
}
