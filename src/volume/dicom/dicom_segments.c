/* SPDX-License-Identifier: BSD-3-Clause */
/* The segments of a DICOM segmentation: their numbers, names and colours. */
#include "dicom/dicom.h"
#include "segcast/image.h"

#include <ctype.h>

#define SEGMENTS SC_DICOM_TAG(0x0062, 0x0002)
#define NUMBER SC_DICOM_TAG(0x0062, 0x0004)
#define LABEL SC_DICOM_TAG(0x0062, 0x0005)
#define DISPLAY_LAB SC_DICOM_TAG(0x0062, 0x000d)
#define TYPE_CODE SC_DICOM_TAG(0x0062, 0x000f)
#define TYPE_MODIFIER SC_DICOM_TAG(0x0062, 0x0011)
#define CODE_MEANING SC_DICOM_TAG(0x0008, 0x0104)

enum { TEXT_BYTES = 2 * SC_NAME_BYTES, NUMBER_MOST = 65535 };

/* ---- colours ---- */

/* What CIELab's function of lightness is undone by. */
static double lab_inverse(double f)
{
    return f > 6.0 / 29 ? f * f * f : 3 * (6.0 / 29) * (6.0 / 29) * (f - 4.0 / 29);
}

/* Write the sRGB colour of a value of CIELab as DICOM stores it (PS3.3, C.10.7.1.1: 16 bits, white
 * D50) to @p rgb; what sRGB cannot show is clamped. The matrix goes from XYZ with the white D50 to
 * linear sRGB, whose white is D65, with Bradford's adaptation (B. Lindbloom, brucelindbloom.com).
 */
static void lab_to_srgb(const double stored[3], uint8_t rgb[3])
{
    static const double white[3] = {0.96422, 1, 0.82521};
    static const double to_linear[3][3] = {{3.1338561, -1.6168667, -0.4906146},
                                           {-0.9787684, 1.9161415, 0.0334540},
                                           {0.0719453, -0.2289914, 1.4052427}};
    const double lightness = stored[0] * 100 / 65535;
    const double a = stored[1] * 255 / 65535 - 128, b = stored[2] * 255 / 65535 - 128;
    const double middle = (lightness + 16) / 116;
    const double xyz[3] = {white[0] * lab_inverse(middle + a / 500), white[1] * lab_inverse(middle),
                           white[2] * lab_inverse(middle - b / 200)};
    sc_srgb_table levels;

    sc_srgb_table_init(&levels);
    for (int i = 0; i < 3; i++) {
        const double linear =
            to_linear[i][0] * xyz[0] + to_linear[i][1] * xyz[1] + to_linear[i][2] * xyz[2];

        rgb[i] = sc_srgb_level(&levels, (float)linear);
    }
}

/* ---- names ---- */

/* Is a label no more than "Segment" and a number, as programs make it? */
static bool is_generic(const char *label)
{
    static const char word[] = "segment";
    size_t i = 0;

    while (word[i] && tolower((unsigned char)label[i]) == word[i])
        i++;
    return !*label || (!word[i] && !label[i + strspn(label + i, "_- 0123456789")]);
}

/* Write the meaning of the code in the first item of sequence @p tag of @p item to @p out. */
static void meaning(const sc_dicom *file, const sc_dicom_item *item, uint32_t tag,
                    char out[TEXT_BYTES])
{
    const sc_dicom_item *code = sc_dicom_next(item, tag, NULL);

    out[0] = '\0';
    if (code)
        sc_dicom_text(file, code, CODE_MEANING, out, TEXT_BYTES);
}

/* Write the name of a segment: its label, or, if that says nothing, what its code means, such as
 * "Kidney, Right". */
static void name_segment(const sc_dicom *file, const sc_dicom_item *segment,
                         char out[SC_NAME_BYTES], sc_name_count *names)
{
    char label[TEXT_BYTES], type[TEXT_BYTES], modifier[TEXT_BYTES];
    char both[2 * TEXT_BYTES + 2];
    const sc_dicom_item *code = sc_dicom_next(segment, TYPE_CODE, NULL);

    sc_dicom_text(file, segment, LABEL, label, sizeof label);
    meaning(file, segment, TYPE_CODE, type);
    if (!is_generic(label) || !*type || !strcmp(type, "Tissue")) {
        sc_name_read(label, out, names);
        return;
    }
    meaning(file, segment, TYPE_MODIFIER,
            modifier); /* beside the code, as the standard has it now, */
    if (!*modifier && code)
        meaning(file, code, TYPE_MODIFIER, modifier); /* or in it, as programs do */
    snprintf(both, sizeof both, "%s%s%s", type, *modifier ? ", " : "", modifier);
    sc_name_read(both, out, names);
}

/* ---- the sequence ---- */

/* Read the number of a segment into *out. @param index of its item, from 1, for the message. */
static sc_status read_number(const sc_ctx *ctx, const char *path, const sc_dicom_item *segment,
                             size_t index, int *out)
{
    double number = 0;

    if (sc_dicom_numbers(segment, NUMBER, &number, 1) != 1 || number < 0 || number > NUMBER_MOST)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: segment %zu of its SegmentSequence has no number from 0 to %d; the file "
            "is damaged: write it anew",
            path, index, NUMBER_MOST);
    *out = (int)number;
    return SC_OK;
}

sc_status sc_dicom_read_segments(const sc_ctx *ctx, const char *path, const sc_dicom *file,
                                 sc_label_table *table)
{
    const sc_dicom_item *segment = NULL;
    sc_name_count names = {0};
    SC_OWN(sc_free_at) void *block = NULL;
    uint8_t *seen;
    size_t index = 0;

    SC_PASS(sc_zalloc(ctx, NUMBER_MOST + 1, 1, &block));
    seen = block;
    while ((segment = sc_dicom_next(sc_dicom_root(file), SEGMENTS, segment)) != NULL) {
        sc_label row = {.opacity = -1};
        double lab[3];
        int number = 0;

        SC_PASS(read_number(ctx, path, segment, ++index, &number));
        if (seen[number])
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s: two segments have the number %d, expected another for each; the "
                           "file is damaged: write it anew",
                           path, number);
        seen[number] = 1;
        if (number == 0) /* the background of a label map */
            continue;
        row.value = number;
        name_segment(file, segment, row.name, &names);
        row.has_color = sc_dicom_numbers(segment, DISPLAY_LAB, lab, 3) == 3;
        if (row.has_color)
            lab_to_srgb(lab, row.rgb);
        SC_PASS(sc_label_table_add(ctx, table, &row));
    }
    if (index == 0)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: names no segments (SegmentSequence), expected one for each tissue; "
                       "the file is damaged: write it anew",
                       path);
    sc_name_warn(ctx, path, &names);
    return SC_OK;
}
