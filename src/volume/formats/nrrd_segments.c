/* SPDX-License-Identifier: BSD-3-Clause */
/* The segments that the header of a .seg.nrrd of 3D Slicer lists: a label table, and for layers
 * that overlap, which label of which layer each segment is. MITK has groups of labels for that. */
#include "formats/nrrd_header.h"

#include "tables/label_table.h"

#include <errno.h>
#include <jansson.h>
#include <stdlib.h>

/* Read "R G B", each from 0 to 1, as 8-bit levels. @return false if @p text is NULL or no such
 * colour; @p rgb may have changed then. */
static bool parse_color(const char *text, uint8_t rgb[3])
{
    double channel[3];

    if (!text || sscanf(text, "%lf %lf %lf", &channel[0], &channel[1], &channel[2]) != 3)
        return false;
    for (int i = 0; i < 3; i++) {
        if (!(channel[i] >= 0 && channel[i] <= 1))
            return false;
        rgb[i] = (uint8_t)(channel[i] * 255 + 0.5);
    }
    return true;
}

/* Append one segment of Slicer's header to @p table as a row. A segment without LabelValue has
 * the value index + 1. One whose value cannot be read is left out, and so is a colour that
 * cannot be read, with a warning each. @return SC_ERR_MEMORY only. */
static sc_status read_segment(const sc_ctx *ctx, const char *path, const sc_nrrd_segment *segment,
                              size_t index, sc_source *source, sc_name_count *names)
{
    sc_label row = {.opacity = -1};
    char *end = NULL;

    errno = 0;
    row.value = segment->value ? strtoll(segment->value, &end, 10) : (int64_t)index + 1;
    if (segment->value && (end == segment->value || *end || errno)) {
        sc_warn(ctx,
                "%s: Segment%zu_LabelValue is \"%.40s\", expected a whole number; the "
                "segment's name and colour are not used",
                path, index, segment->value);
        return SC_OK;
    }
    sc_name_read(segment->name ? segment->name : "", row.name, names);
    row.has_color = parse_color(segment->color, row.rgb);
    if (segment->color && !row.has_color)
        sc_warn(ctx, "%s: Segment%zu_Color is \"%.40s\", expected three numbers from 0 to 1", path,
                index, segment->color);
    return sc_label_table_add(ctx, &source->table, &row);
}

/* Warn if a segment of a file without layers is said to be in another one than the first. */
static void check_layer(const sc_ctx *ctx, const char *path, const sc_nrrd_segment *segment,
                        size_t index)
{
    if (segment->layer && strcmp(segment->layer, "0"))
        sc_warn(ctx,
                "%s: Segment%zu_Layer is \"%.40s\", but the file has one layer, 0; the segment "
                "is taken to be there",
                path, index, segment->layer);
}

/* Note that the last row of the table is this segment of a file with layers. One whose layer the
 * file has not is left out, with a warning. */
static void place_segment(const sc_ctx *ctx, const char *path, const sc_nrrd_segment *segment,
                          size_t index, sc_source *source)
{
    const size_t row = source->table.count - 1;
    char *end = NULL;
    const long layer = segment->layer ? strtol(segment->layer, &end, 10) : 0;

    source->segments[row] =
        (sc_segment){.layer = (int)layer, .value = source->table.rows[row].value, .row = row};
    if (!segment->layer || (end != segment->layer && !*end && layer >= 0 && layer < source->layers))
        return;
    sc_warn(ctx, "%s: Segment%zu_Layer is \"%.40s\", expected 0 to %d; the segment is not shown",
            path, index, segment->layer, source->layers - 1);
    source->table.count--;
}

/* Give the segments of several layers labels: those of the file if no two have the same and they
 * fit into two bytes, else their place in the header, from 1. */
static void number_segments(const sc_ctx *ctx, const char *path, sc_source *source)
{
    uint8_t seen[(UINT16_MAX + 1) / 8] = {0};
    bool distinct = true;

    for (size_t i = 0; i < source->table.count && distinct; i++) {
        const int64_t value = source->table.rows[i].value;

        distinct = value > 0 && value <= UINT16_MAX && !(seen[value / 8] >> value % 8 & 1);
        if (distinct)
            seen[value / 8] |= (uint8_t)(1 << value % 8);
    }
    for (size_t i = 0; i < source->table.count && !distinct; i++)
        source->table.rows[i].value = (int64_t)i + 1;
    source->numbered = !distinct;
    if (!distinct)
        sc_info(ctx,
                "%s: its layers use the same numbers for several segments; the labels are numbered "
                "anew, from 1, in the order of the segments",
                path);
}

/* Warn of segments whose numbers no voxel can have: the first one is told, and how many there are.
 */
static void warn_of_values(const sc_ctx *ctx, const char *path, const sc_source *source)
{
    const sc_label *first = NULL;
    size_t count = 0;

    for (size_t i = 0; i < source->table.count && sc_voxel_type_is_integer(source->type); i++) {
        if (sc_voxel_type_fits(source->type, source->table.rows[i].value))
            continue;
        first = first ? first : &source->table.rows[i];
        count++;
    }
    if (count)
        sc_warn(ctx,
                "%s: the LabelValue of the segment \"%s\" is %lld, which no voxel of this type can "
                "have, so that the segment has none; %zu segment%s so; was the volume saved as "
                "another type?",
                path, first->name, (long long)first->value, count, count == 1 ? " is" : "s are");
}

/* Append the labels of MITK's groups, [{"labels": [...]}, ...]. A group is a layer. Opacities are
 * not used: they are those of slices, less than 1 of all labels. */
static sc_status read_groups(const sc_ctx *ctx, const char *path, const char *text,
                             sc_source *source)
{
    sc_label_table *table = &source->table;
    json_error_t error;
    json_auto_t *groups = json_loads(text, 0, &error);
    size_t capacity = 0, count = 0;

    if (!groups)
        return sc_fail(ctx, SC_ERR_DATA, "%s: its label groups of MITK are no JSON: %s", path,
                       error.text);
    if (source->layers > 1)
        SC_PASS(SC_GROW(ctx, 0, &capacity, &source->segments));
    for (size_t g = 0; g < json_array_size(groups); g++) {
        json_t *labels = json_object_get(json_array_get(groups, g), "labels");
        const int layer = source->layers > 1 ? (int)g : 0;

        if (layer >= source->layers) {
            sc_warn(ctx, "%s: has %zu groups of labels, expected %d, one for each layer", path,
                    json_array_size(groups), source->layers);
            break;
        }
        if (json_array_size(labels))
            SC_PASS(sc_label_json_read(ctx, path, labels, table));
        for (; count < table->count; count++) {
            table->rows[count].opacity = -1;
            if (source->layers == 1)
                continue;
            SC_PASS(SC_GROW(ctx, count, &capacity, &source->segments));
            source->segments[count] =
                (sc_segment){.layer = layer, .value = table->rows[count].value, .row = count};
        }
    }
    return SC_OK;
}

sc_status sc_nrrd_read_segments(const sc_ctx *ctx, const char *path, const sc_nrrd_header *header,
                                sc_source *source)
{
    sc_name_count names = {0};
    sc_label_table *table = &source->table;

    if (header->label_groups)
        SC_PASS(read_groups(ctx, path, header->label_groups, source));
    else if (source->layers > 1)
        SC_PASS(sc_zalloc(ctx, header->segment_count, sizeof(sc_segment), &source->segments));
    for (size_t i = 0; i < header->segment_count; i++) {
        const size_t count = table->count;

        if (!header->segments[i].id && !header->segments[i].value)
            break;
        SC_PASS(read_segment(ctx, path, &header->segments[i], i, source, &names));
        if (source->layers > 1 && table->count > count)
            place_segment(ctx, path, &header->segments[i], i, source);
        else if (source->layers <= 1)
            check_layer(ctx, path, &header->segments[i], i);
    }
    warn_of_values(ctx, path, source);
    if (source->layers > 1)
        number_segments(ctx, path, source);
    sc_name_warn(ctx, path, &names);
    return SC_OK;
}
