/* SPDX-License-Identifier: BSD-3-Clause */
/* Label tables with headings, in JSON and in other encodings of text, and writing them. */
#include "check.h"

#include "segcast/label_files.h"

#include <unistd.h>

/* Read @p text of @p bytes bytes as a table. */
static sc_status read_as(sc_table_format format, const char *text, size_t bytes,
                         sc_label_table *out)
{
    const sc_ctx *ctx = listening_anew();
    sc_status status;

    write_bytes("table.txt", "", text, bytes);
    status = sc_label_table_read(ctx, "table.txt", format, out);
    unlink("table.txt");
    return status;
}

/* As read_as, with the format to be guessed. */
static sc_status read_table(const char *text, size_t bytes, sc_label_table *out)
{
    return read_as(SC_TABLE_AUTO, text, bytes, out);
}

/* Expect a table of the labels 4, "left atrium", of the colour 255, 128, 0, and 5, "b", half
 * opaque. */
static void expect_two(const char *text, bool has_color, float opacity)
{
    SC_OWN(sc_label_table_clear) sc_label_table table = {0};

    if (read_table(text, strlen(text), &table) != SC_OK || table.count < 2)
        fail_msg("\"%s\": %s", text, said.text);
    assert_int_equal(table.rows[0].value, 4);
    assert_string_equal(table.rows[0].name, "left atrium");
    assert_int_equal(table.rows[0].has_color, has_color);
    if (has_color)
        assert_true(table.rows[0].rgb[0] == 255 && table.rows[0].rgb[1] == 128 &&
                    table.rows[0].rgb[2] == 0);
    assert_true(table.rows[0].opacity < 0 && !table.rows[0].hidden);
    assert_int_equal(table.rows[1].value, 5);
    assert_near(table.rows[1].opacity, opacity, 0.003);
}

/* A label that is expected. */
typedef struct named {
    int value;
    const char *name;
} named;

/* Expect a table of these labels, and no others. */
static void expect_names(const char *text, const named *expected, size_t count)
{
    SC_OWN(sc_label_table_clear) sc_label_table table = {0};

    assert_ok(read_table(text, strlen(text), &table));
    assert_int_equal(table.count, count);
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(table.rows[i].value, expected[i].value);
        assert_string_equal(table.rows[i].name, expected[i].name);
    }
}

TEST(columns_are_known_by_their_headings)
{
    expect_two("value|name|r|g|b\n4|left atrium|255|128|0\n5|b|1|2|3\n", true, -1);
    /* BIDS; spreadsheets in three ways; 3D Slicer; FastSurfer, whose A is transparency */
    expect_two("index\tname\tabbreviation\tcolor\n4\tleft atrium\tLA\t#ff8000\n5\tb\tB\tn/a\n",
               true, -1);
    expect_two("\xef\xbb\xbf# made by hand\r\nValue;Label;Colour;Opacity\r\n"
               "0;none;;\r\n4;\"left atrium\";255 128 0;100\r\n\r\n5;b;;50\r\n",
               true, 0.5F);
    expect_two("name , id,rgba\n\"left atrium\",4,\"rgba(255, 128, 0, 1)\"\nb,5,\"rgb(1,2,3)\"\n",
               true, -1);
    expect_two("LabelValue,Name,Color_R,Color_G,Color_B,Color_A,Type_CodeMeaning\n"
               "4,left atrium,255,128,0,255,\"a, \"\"b\"\"\nc\"\n5,b,1,2,3,128,\n",
               true, 0.5F);
    expect_two("ID\tLabelName\tR\tG\tB\tA\n4\tleft atrium\t255\t128\t0\t0\n5\tb\t1\t2\t3\t127\n"
               "6\tc\t1\t1\t1\t0\n",
               true, 0.5F);
    expect_two("label,structure,r,g,b,alpha\n4,left atrium,1,0.5,0,1\n5,b,0,0,0,0.5\n", true, 0.5F);
    /* decimal commas, percent signs */
    expect_two("value;name;r;g;b;a\n4;left atrium;1;0,502;0;1\n5;b;0;0;0;0,5\n", true, 0.5F);
    expect_two("value,name,color,opacity\n4,left atrium,#ff8000,100%\n5,b,n/a,50%\n", true, 0.5F);
}

/* Headings of two words, of the number, the name and the colour, with units behind them. */
TEST(headings_of_two_words_are_known)
{
    static const char *const numbers[] = {"ROI",          "roi_id",      "Class ID",
                                          "label_idx",    "Segment",     "SegmentNumber",
                                          "RegionNumber", "Voxel value", "num"};
    static const char *const names[] = {"ROI name",   "Class_Name",   "full name",   "long_name",
                                        "TissueName", "Brain region", "description", "segment"};
    static const char *const colors[] = {"Label Color", "displayColour", "RGB color",  "colour_hex",
                                         "hex code",    "HTML",          "color value"};
    char text[256];

    for (size_t i = 0; i < SC_COUNT_OF(numbers); i++) {
        snprintf(text, sizeof text, "%s,name,color,opacity\n4,left atrium,#ff8000,1\n5,b,,0.5\n",
                 numbers[i]);
        expect_two(text, true, 0.5F);
    }
    for (size_t i = 0; i < SC_COUNT_OF(names); i++) {
        snprintf(text, sizeof text, "value,%s,color,opacity\n4,left atrium,#ff8000,1\n5,b,,0.5\n",
                 names[i]);
        expect_two(text, true, 0.5F);
    }
    for (size_t i = 0; i < SC_COUNT_OF(colors); i++) {
        snprintf(text, sizeof text,
                 "value,name,%s,Opacity (0-1)\n4,left atrium,#ff8000,1\n5,b,,0.5\n", colors[i]);
        expect_two(text, true, 0.5F);
    }
    expect_two(
        "value,name,Colour_R,color green,B (0-255),color_alpha\n4,left atrium,255,128,0,255\n"
        "5,b,1,2,3,128\n",
        true, 0.5F);
    /* what only looks like it: numbers of voxels, codes of terminologies */
    expect_two("voxel number,Type_CodeValue,value,name,color,opacity\n"
               "17,99,4,left atrium,#ff8000,1\n18,98,5,b,,0.5\n",
               true, 0.5F);
}

/* Lists of classes, which have no colours: of TotalSegmentator, whose file in Python has several,
 * the first; its lists in JSON, "total"; and what people write. */
TEST(lists_of_classes_are_read)
{
    expect_two("4 left atrium\n5 b\n", false, -1);
    expect_two("0\tbackground\n4\tleft atrium\n5\tb\n", false, -1);
    expect_two("4,left atrium,\r\n5,b,\r\n", false, -1);
    expect_two("4: left atrium\n5: b\n", false, -1);
    expect_two("class_map = {\n    \"total\": {\n        4: \"left atrium\",\n        5: \"b\",\n"
               "    },\n    \"vessels\": {\n        4: \"other\",\n        5: \"x\"\n    }\n}\n",
               false, -1);
    expect_two("{4: 'left atrium', 5: \"b\"}", false, -1);
    expect_two("| 4 | left atrium | atrium |\n|5|b||\n", false, -1);
    expect_two("{\"vessels\": {\"4\": \"x\", \"5\": \"y\"},"
               " \"total\": {\"4\": \"left atrium\", \"5\": \"b\"}}",
               false, -1);
}

/* Tables of 3D Slicer and FreeSurfer are told by the comments with which they begin, whatever the
 * opacities are, unless all labels would be invisible. */
TEST(slicer_and_freesurfer_are_told_by_their_comments)
{
    static const struct {
        const char *text;
        float opacity[2];
        bool hidden[2];
    } cases[] = {
        {"#No. Label Name:  R   G   B   A\n1 a 1 2 3 0\n2 b 1 2 3 255\n", {-1, 0}, {false, true}},
        {"#No. Label Name:  R   G   B   A\n1 a 1 2 3 255\n2 b 1 2 3 255\n",
         {-1, -1},
         {false, false}},
        {"# Color table file x.ctbl\n1 a 1 2 3 0\n2 b 1 2 3 255\n", {0, -1}, {true, false}},
        {"# Color table file x.ctbl\n1 a 1 2 3 0\n2 b 1 2 3 0\n3 c 1 2 3 255\n",
         {0, 0},
         {true, true}}};

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        SC_OWN(sc_label_table_clear) sc_label_table table = {0};

        assert_ok(read_table(cases[i].text, strlen(cases[i].text), &table));
        for (int k = 0; k < 2; k++) {
            assert_true(table.rows[k].opacity == cases[i].opacity[k]);
            assert_int_equal(table.rows[k].hidden, cases[i].hidden[k]);
        }
    }
}

/* A colour may stand at the end of a row: hexadecimal, or as three or four numbers, as in the
 * tables of MRtrix, where the last of two names counts. */
TEST(colors_behind_names_are_read)
{
    expect_two("4 left atrium #ff8000\n5 b #00ff0080\n", true, 128 / 255.0F);
    expect_two("4 LA\tleft atrium\t255 128 0 255\n5 B\tb\t0 0 0 128\n", true, 128 / 255.0F);
    expect_two("# MRtrix\n0  ??  Unknown  0 0 0 0\n4  LA  left atrium  255 128   0 255\n"
               "5  B   b            0   0 255 255\n",
               true, -1);
    expect_two("4,left atrium,255,128,0\n5,b,1,2,3\n", true, -1);
    expect_two("4,left atrium,#ff8000\n5,b,#00ff00\n", true, -1);
    expect_two("4 left atrium 255 128 0 255\n5 b 255 0 1 128\n", true, 128 / 255.0F);
}

/* Without headings, quotation marks tell columns: a number, a name and perhaps a colour. */
TEST(quoted_columns_need_no_headings)
{
    static const named expected[] = {{4, "atrium, left"}, {5, "b, c"}};

    expect_two("\"4\",\"left atrium\",\"255\",\"128\",\"0\"\n\"5\",\"b\",\"1\",\"2\",\"3\"\n", true,
               -1);
    expect_two(
        "4;\"left atrium\";\"255\";\"128\";\"0\";\"255\"\n5;\"b\";\"1\";\"2\";\"3\";\"128\"\n",
        true, 128 / 255.0F);
    expect_two("\"4\",\"left atrium\",\"#ff8000\"\r\n\"5\",\"b\",\"#010203\"\r\n", true, -1);
    expect_names("4,\"atrium, left\"\n5,\"b, c\"\n", expected, 2);
}

/* Atlases of mice have a row for both sides of a structure, and two numbers in it, which are the
 * same for what lies in the middle. */
TEST(rows_may_have_a_number_for_each_side)
{
    static const char text[] = "\"Structure\",\"right label\",\"left label\",\"hierarchy\"\n"
                               "\"amygdala\",51,151,\"x\"\n\"fourth ventricle\",118,118,\"y\"\n"
                               "\"only right\",7,,\n\"neither\",,,\n";
    static const named expected[] = {{51, "right amygdala"},
                                     {151, "left amygdala"},
                                     {118, "fourth ventricle"},
                                     {7, "right only right"}};

    expect_names(text, expected, SC_COUNT_OF(expected));
    assert_non_null(strstr(said.text, "table.txt:5: 1 line has no whole number"));
}

/* The info_label.txt of the Spinal Cord Toolbox, whose headings are a comment. */
TEST(headings_may_be_a_comment)
{
    static const char text[] =
        "# Atlas of x\n# Keyword=IndivLabels (Please DO NOT change this line)\n# ID, name, file\n"
        "4, left atrium, x_04.nii.gz\n5, b, x_05.nii.gz\n\n# Combined labels\n"
        "# Keyword=CombinedLabels (Please DO NOT change this line)\n# ID, name, IDgroup\n"
        "50, the heart, 4:5\n51, both, 4,5\n";
    static const named expected[] = {{4, "left atrium"}, {5, "b"}, {50, "the heart"}, {51, "both"}};

    expect_names(text, expected, SC_COUNT_OF(expected));
    assert_int_equal(said.warnings, 0);
}

/* Of several lists in Python only the first is read. */
TEST(further_lists_of_classes_are_left_out)
{
    static const char text[] =
        "class_map = {\n \"total\": {\n  1: \"spleen\",\n  2: \"liver\"\n },\n"
        " \"heart\": {\n  1: \"x\",\n  3: \"y\"\n }\n}\n";
    static const named expected[] = {{1, "spleen"}, {2, "liver"}};

    expect_names(text, expected, 2);
}

/* A row of 3D Slicer without a name of its own has that of its terminology. */
TEST(terminologies_name_rows)
{
    static const char text[] =
        "LabelValue,Name,Color_R,Color_G,Color_B,Type_CodeMeaning,TypeModifier_CodeMeaning\n"
        "1,,1,2,3,Kidney,Left\n2,,1,2,3,Liver,\n3,Mine,1,2,3,Spleen,\n";
    static const named expected[] = {{1, "Kidney, Left"}, {2, "Liver"}, {3, "Mine"}};

    expect_names(text, expected, 3);
}

TEST(json_is_known_by_its_bracket)
{
    /* lists and maps of objects; nnU-Net in two ways; names in the order of their numbers */
    expect_two("[{\"value\": 4, \"name\": \"left atrium\", \"color\": [255, 128, 0]},"
               " {\"value\": 5, \"name\": \"b\", \"opacity\": 0.5}]",
               true, 0.5F);
    expect_two("{\"4\": {\"name\": \"left atrium\", \"color\": \"#ff8000\"},"
               " \"5\": {\"label\": \"b\"}}",
               true, -1);
    expect_two("{\"labels\": {\"background\": 0, \"left atrium\": 4, \"b\": 5}}", false, -1);
    expect_two(" {\"labels\": {\"0\": \"none\", \"4\": \"left atrium\", \"5\": \"b\"}}", false, -1);
    expect_two("[\"\", \"\", \"\", \"\", \"left atrium\", \"b\"]", false, -1);
    expect_two("[{\"value\": 4, \"name\": \"left atrium\", \"color\": {\"r\": 255, \"g\": 128, "
               "\"b\": 0}}, {\"value\": 5, \"name\": \"b\", \"color\": {\"red\": 1, \"green\": 2, "
               "\"blue\": 3, \"alpha\": 128}}]",
               true, 128 / 255.0F);
}

/* Ontologies: the structure graph of the Allen Institute, its root alone, as ABBA keeps it with the
 * members of nodes apart, and the flat list of BrainGlobe. */
TEST(ontologies_are_read_with_all_their_levels)
{
#define NODE(id, short, name, hex)                                                                 \
    "{\"id\": " id ", \"atlas_id\": 9" id                                                          \
    ", \"ontology_id\": 1, \"acronym\": \"" short "\", \"name\": \"" name                          \
                                                  "\", \"color_hex_triplet\": \"" hex              \
                                                  "\", \"hemisphere_id\": 3, "                     \
                                                  "\"parent_structure_id\": null"
#define TREE                                                                                       \
    NODE("4", "LA", "left atrium", "FF8000")                                                       \
    ", \"children\": [" NODE("5", "B", "b", "010203") ", \"children\": []}, " NODE(                \
        "6", "C", "c", "FFFFFF") ", \"children\": [" NODE("7", "D", "d", "FFFFFF") "}]}]}"
    static const char *const texts[] = {
        "{\"success\": true, \"id\": 0, \"num_rows\": 1, \"total_rows\": 1, \"msg\": [" TREE "]}",
        TREE,
        "{\"root\": {\"data\": " NODE(
            "4", "LA", "left atrium",
            "FF8000") "}, \"children\": [{\"data\": " NODE("5", "B", "b",
                                                           "010203") "}, \"children\": []}]}}",
        "[{\"id\": 4, \"acronym\": \"LA\", \"name\": \"left atrium\", \"structure_id_path\": [4], "
        "\"rgb_triplet\": [255, 128, 0]}, {\"id\": 5, \"acronym\": \"B\", \"name\": \"b\"}]",
        "{\"rois\": [" NODE("4", "LA", "left atrium", "FF8000") "}, " NODE("5", "B", "b",
                                                                           "0") "}]}"};
    static const named expected[] = {{4, "left atrium"}, {5, "b"}, {6, "c"}, {7, "d"}};

    for (size_t i = 0; i < SC_COUNT_OF(texts); i++)
        expect_two(texts[i], true, -1);
    expect_names(TREE, expected, SC_COUNT_OF(expected));
#undef TREE
#undef NODE
}

/* Colours of segments of Neuroglancer have no names. */
TEST(colors_of_neuroglancer_are_read)
{
    static const char text[] =
        "{\"layers\": [{\"type\": \"image\"}, {\"type\": \"segmentation\", \"segmentColors\": "
        "{\"4\": \"#ff8000\", \"18446744073709551615\": \"#000\"}}]}";
    SC_OWN(sc_label_table_clear) sc_label_table table = {0};

    assert_ok(read_table(text, sizeof text - 1, &table));
    assert_int_equal(table.count, 1);
    assert_int_equal(table.rows[0].value, 4);
    assert_true(table.rows[0].has_color && table.rows[0].rgb[1] == 128 && !table.rows[0].name[0]);
}

/* Atlases of FSL: the numbers of labels, or of images of probabilities, which begin with 0. */
TEST(atlases_of_fsl_are_read)
{
    static const char *const types[2] = {"Label", "Probabilistic"};

    for (int i = 0; i < 2; i++) {
        char text[512];

        snprintf(text, sizeof text,
                 "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>\n<atlas version=\"1.0\">"
                 "<header><name>Label of x</name><type>%s</type><images><imagefile>/a"
                 "</imagefile></images></header>\n<data>\n<label index=\"%d\" x=\"48\" y=\"94\">"
                 "left atrium</label>\n<label index=\"%d\">b</label></data></atlas>",
                 types[i], 4 - i, 5 - i);
        expect_two(text, false, -1);
    }
}

/* The label descriptions of BrainSuite, and atlases whose labels consist of elements. */
TEST(xml_of_other_programs_is_read)
{
    expect_two("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<labelset>\n"
               "<label id=\"0\" tag=\"bg\" color=\"0x000000\" fullname=\"background\" />\n"
               "<label id=\"4\" tag=\"LA\" color=\"0xff8000\" fullname=\"left atrium\" />\n"
               "<label id=\"5\" tag=\"B\" color=\"0x010203\" fullname=\"b\" />\n</labelset>\n",
               true, -1);
    expect_two("<atlas version=\"2.0\"><header><name>x</name><type>Label</type></header><data>\n"
               "<label><index>4</index><short_name>LA</short_name><name>left atrium</name></label>"
               "<label><index>5</index><short_name>B</short_name><name>b</name></label>"
               "</data></atlas>",
               false, -1);
}

/* Documents of Neuroglancer, OME-Zarr (0.4 and in Zarr 3), NiiVue, and dcmqi. */
TEST(json_of_viewers_is_read)
{
    expect_two("{\"@type\": \"neuroglancer_segment_properties\", \"inline\": {\"ids\": "
               "[\"4\", \"5\"], \"properties\": [{\"id\": \"d\", \"type\": \"description\", "
               "\"values\": [\"x\", \"y\"]}, {\"id\": \"n\", \"type\": \"label\", \"values\": "
               "[\"left atrium\", \"b\"]}]}}",
               false, -1);
    expect_two("{\"R\": [0, 255, 1], \"G\": [0, 128, 1], \"B\": [0, 0, 1], \"A\": [0, 255, 128],"
               " \"I\": [0, 4, 5], \"labels\": [\"air\", \"left atrium\", \"b\"]}",
               true, 0.5F);
    expect_two(
        "{\"ContentLabel\": \"SEGMENTATION\", \"segmentAttributes\": [[{\"labelID\": 4, "
        "\"SegmentDescription\": \"left atrium\", \"recommendedDisplayRGBValue\": [255, 128, "
        "0]}], [{\"labelID\": 5, \"SegmentLabel\": \"b\"}]]}",
        true, -1);
}

TEST(ome_metadata_is_applied_to_a_volume)
{
    static const char *const documents[] = {
        "{\"image-label\": {\"version\": \"0.4\", \"colors\": [{\"label-value\": 4, \"rgba\": "
        "[255, 128, 0, 0]}], \"properties\": [{\"label-value\": 4, \"class\": \"atrium\"}]}}",
        "{\"zarr_format\": 3, \"attributes\": {\"ome\": {\"image-label\": {\"colors\": "
        "[{\"label-value\": 4, \"rgba\": [255, 128, 0, 0]}, {\"label-value\": 9, \"rgba\": "
        "[1, 1, 1, 255]}], \"properties\": [{\"label-value\": 4, \"name\": \"atrium\"}]}}}}"};

    for (size_t i = 0; i < SC_COUNT_OF(documents); i++) {
        SC_OWN(sc_volume_clear) sc_volume v = {.label_count = 1};
        SC_OWN(sc_label_table_clear) sc_label_table table = {0};
        const sc_ctx *ctx = listening_anew();
        void *labels;

        assert_ok(sc_zalloc(ctx, 1, sizeof(sc_label), &labels));
        v.labels = labels;
        assert_ok(read_table(documents[i], strlen(documents[i]), &table));
        assert_ok(sc_volume_add_labels(ctx, &v, &table));
        assert_int_equal(v.labels[1].value, 4);
        assert_string_equal(v.labels[1].name, "atrium");
        assert_true(v.labels[1].has_color && v.labels[1].rgb[1] == 128);
    }
}

/* The same table as UTF-16 of both byte orders, and in Latin-1, which is said. */
TEST(other_encodings_become_utf8)
{
    static const char utf16[] = "\xff\xfe"
                                "4\0 \0\xe9\0=\xd8\x00\xde \0001\0 \0002\0 \0003\0\n\0";
    sc_label_table table = {0};
    char swapped[sizeof utf16];
    static const char *const latin1[] = {"value,name\n4,caf\xe9\n", "4 caf\xe9 1 2 3\n"};

    assert_ok(read_table(utf16, sizeof utf16 - 1, &table));
    assert_string_equal(table.rows[0].name, "\xc3\xa9\xf0\x9f\x98\x80");
    assert_int_equal(table.rows[0].rgb[2], 3);
    sc_label_table_clear(&table);
    for (size_t i = 0; i + 1 < sizeof utf16; i++)
        swapped[i] = utf16[i ^ 1];
    assert_ok(read_table(swapped, sizeof utf16 - 1, &table));
    assert_string_equal(table.rows[0].name, "\xc3\xa9\xf0\x9f\x98\x80");
    sc_label_table_clear(&table);
    assert_int_equal(read_table(utf16, sizeof utf16 - 2, &table), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "ends within a character"));
    for (size_t i = 0; i < SC_COUNT_OF(latin1); i++) {
        assert_ok(read_as(i ? SC_TABLE_SLICER : SC_TABLE_DELIMITED, latin1[i], strlen(latin1[i]),
                          &table));
        assert_string_equal(table.rows[0].name, "caf\xc3\xa9");
        assert_non_null(strstr(said.text, "Latin-1"));
        assert_int_equal(said.warnings, 0);
        sc_label_table_clear(&table);
    }
}

/* The same as UTF-32 of both byte orders; numbers beyond Unicode and halves of characters are
 * replaced. */
TEST(utf32_becomes_utf8)
{
    static const uint32_t text[] = {0xfeff, '4', ' ', 0xe9, 0x1f600, 0xd800, 0x110000,
                                    ' ',    '1', ' ', '2',  ' ',     '3',    '\n'};
    char bytes[sizeof text];

    for (int big = 0; big < 2; big++) {
        SC_OWN(sc_label_table_clear) sc_label_table table = {0};

        for (size_t i = 0; i < sizeof text; i++)
            bytes[i] = (char)(text[i / 4] >> 8 * (big ? 3 - i % 4 : i % 4));
        assert_ok(read_table(bytes, sizeof bytes, &table));
        assert_string_equal(table.rows[0].name, "\xc3\xa9\xf0\x9f\x98\x80\xef\xbf\xbd\xef\xbf\xbd");
        assert_int_equal(table.rows[0].rgb[2], 3);
        assert_int_equal(said.warnings, 0);
        assert_int_equal(read_table(bytes, sizeof bytes - 2, &table), SC_ERR_DATA);
        assert_non_null(strstr(said.text, "it is UTF-32"));
    }
}

/* Read XML whose declaration names the encoding in which it was, of units of so many bytes. */
static void read_wide_xml(const char *xml, size_t unit)
{
    const size_t characters = strlen(xml);
    char *text = test_calloc(characters + 1, unit);
    SC_OWN(sc_label_table_clear) sc_label_table table = {0};
    sc_status status;

    text[0] = '\xff';
    text[1] = '\xfe';
    for (size_t i = 0; i < characters; i++)
        text[(i + 1) * unit] = xml[i];
    status = read_table(text, (characters + 1) * unit, &table);
    test_free(text);
    if (status != SC_OK && strstr(said.text, "built without Expat"))
        skip();
    assert_ok(status);
    assert_string_equal(table.rows[0].name, "aorta");
}

/* XML in UTF-16 and UTF-32, whose declaration still says so when it has been decoded. */
TEST(wide_xml_is_read)
{
#define BODY                                                                                       \
    "<LabelTable><Label Key=\"4\" Red=\"1\" Green=\"0\" Blue=\"0\" "                               \
    "Alpha=\"1\">aorta</Label></LabelTable>"
    read_wide_xml("<?xml version=\"1.0\" encoding=\"utf-16\"?>" BODY, 2);
    read_wide_xml("<?xml version=\"1.0\" encoding=\"UTF-32\"?>" BODY, 4);
}

/* 3D Slicer drops the quotation marks around a name. */
TEST(names_of_slicer_have_no_quotes)
{
    static const named expected[] = {{1, "Left Atrium"}, {2, "b"}};

    expect_names("1 'Left_Atrium' 225 95 120 255\n2 b 1 2 3 255\n", expected, 2);
}

TEST(what_cannot_be_read_is_told_with_its_place)
{
    static const struct {
        const char *text, *message;
        sc_status status;
    } cases[] = {
        {"value,name\n\nx,a\n", "table.txt:3: has no whole number", SC_ERR_DATA},
        {"value,name\n", "has headings, but no labels", SC_ERR_DATA},
        {"1,a,x\n2,b,y\n", "has no line of headings", SC_ERR_DATA},
        {"foo,bar,baz\n1,a,1\n2,b,2\n", "has no line of headings", SC_ERR_DATA},
        {"value,name,r,g,b\n1,a,x,0,0\n", "1 colour cannot be read, such as \"x\"", SC_OK},
        {"value,name\n1,a\nx,b\n2.5,c\n", "table.txt:3: 2 lines have no whole number", SC_OK},
        {"value,color\n1,#12345\n2,blue-ish\n", "2 colours cannot be read, such as \"#12345\"",
         SC_OK},
        {"{\"a\":\n }", "table.txt:2: is no JSON", SC_ERR_DATA},
        {"{\"a\": {\"b\": 2}}", "holds no label table that segcast knows", SC_ERR_DATA},
        {"[{\"value\": 1, \"name\": \"a\"}, {\"value\": \"x\", \"name\": \"b\"}, 3]",
         "2 entries have no number", SC_OK}};

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        SC_OWN(sc_label_table_clear) sc_label_table table = {0};

        assert_int_equal(read_table(cases[i].text, strlen(cases[i].text), &table), cases[i].status);
        if (!strstr(said.text, cases[i].message))
            fail_msg("\"%s\": \"%s\", expected \"%s\"", cases[i].text, said.text, cases[i].message);
    }
}

/* A label list of Connectome Workbench has two lines for a label. */
TEST(two_lines_for_a_label_are_read)
{
    sc_label_table table = {0};

    expect_two("left atrium\n4 255 128 0 255\nb\n5 1 2 3 128\n", true, 0.5F);
    expect_two("  left atrium \r\n4 255 128 0 255\r\n\r\nb\r\n5 1 2 3 128", true, 0.5F);
    assert_int_equal(read_table("a\n1 2 3 4 255\nb\n2 2 3\n", 22, &table), SC_ERR_DATA);
    assert_non_null(
        strstr(said.text, "table.txt:4: is \"2 2 3\", expected the key of the label \"b\""));
    assert_int_equal(read_as(SC_TABLE_WORKBENCH, "\n\n", 2, &table), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "has no labels; expected two lines for each"));
}

/* Levels that a format cannot have are told: they would make labels invisible, or look like others.
 */
TEST(colors_are_known_by_their_names)
{
    static const char *const texts[] = {
        "value,name,color\n1,a,Dark Orange\n2,b,#0000ff80\n",
        "{\"1\": {\"name\": \"a\", \"color\": \"darkorange\"}, \"2\": {\"color\": \"#0000ff80\"}}"};

    for (size_t i = 0; i < SC_COUNT_OF(texts); i++) {
        SC_OWN(sc_label_table_clear) sc_label_table table = {0};

        assert_int_equal(read_table(texts[i], strlen(texts[i]), &table), SC_OK);
        assert_int_equal(table.count, 2);
        assert_true(table.rows[0].has_color && table.rows[0].rgb[0] == 255 &&
                    table.rows[0].rgb[1] == 140 && table.rows[0].rgb[2] == 0);
        assert_true(table.rows[0].opacity < 0); /* names say nothing of opacity */
        assert_near(table.rows[1].opacity, 128 / 255.0, 0.003);
    }
}

TEST(levels_that_are_changed_are_told)
{
    static const struct {
        const char *text, *such;
        float opacity;
    } cases[] = {{"4 x 255 128 0 0.5\n5 b 1 2 3 255\n", "such as 0.5;", 1 / 255.0F},
                 {"4 x 300 128 0 -1\n5 b 1 2 3 255\n",
                  "2 levels of colour or opacity cannot be as "
                  "they are, such as 300;",
                  0},
                 {"4 1 2 3 2 1 1 \"x\"\n", "such as 2;", -1},
                 {"x\n4 1 2 3 256\n", "such as 256;", -1},
                 {"value,name,r,g,b,opacity\n4,x,255,0,0,-1\n5,y,255,0,0,0.5\n", "such as -1;", 0}};

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        SC_OWN(sc_label_table_clear) sc_label_table table = {0};

        assert_ok(read_table(cases[i].text, strlen(cases[i].text), &table));
        if (said.warnings != 1 || !strstr(said.text, cases[i].such))
            fail_msg("case %zu: %s", i, said.text);
        assert_near(table.rows[0].opacity, cases[i].opacity, 1e-6);
    }
}

/* ---- writing ---- */

/* What is written in each format is read again as it was, but for what the format cannot hold. */
TEST(tables_are_written_as_they_are_read)
{
    sc_label rows[] = {
        {.value = 7, .name = "a, \"b\" & <c>", .rgb = {1, 2, 3}, .has_color = true, .opacity = -1},
        {.value = 3, .name = "x y", .rgb = {255, 128, 0}, .has_color = true, .opacity = 0.4F},
        {.value = 9,
         .name = "",
         .rgb = {9, 9, 9},
         .has_color = true,
         .opacity = -1,
         .hidden = true},
        {.value = 3, .name = "second of its value", .opacity = -1}};
    const sc_label_table table = {rows, SC_COUNT_OF(rows), SC_COUNT_OF(rows)};
    static const sc_table_format formats[] = {
        SC_TABLE_SLICER,    SC_TABLE_FREESURFER, SC_TABLE_ITKSNAP, SC_TABLE_XML, SC_TABLE_DELIMITED,
        SC_TABLE_DELIMITED, SC_TABLE_JSON,       SC_TABLE_JSON,    SC_TABLE_XML, SC_TABLE_WORKBENCH,
        SC_TABLE_NAMES,     SC_TABLE_JSON,       SC_TABLE_JSON};

    for (size_t i = 0; sc_table_writer_name(i); i++) {
        const char *name = sc_table_writer_name(i);
        const bool has_color =
            strcmp(name, "neuroglancer") && strcmp(name, "names") && strcmp(name, "nnunet");
        const bool has_opacity = has_color && strcmp(name, "bids");
        const bool has_words = !strcmp(name, "slicer") || !strcmp(name, "freesurfer");
        SC_OWN(sc_label_table_clear) sc_label_table back = {0};
        sc_text text = {0};
        const sc_ctx *ctx = listening_anew();

        assert_ok(sc_label_table_print(ctx, "out", &table, sc_table_writer_find(name), &text));
        if (!has_opacity)
            assert_non_null(strstr(said.text, "the opacities of 1 label"));
        if (read_as(formats[i], text.data, text.length_bytes, &back) != SC_OK) {
            sc_text_clear(&text);
            if (formats[i] == SC_TABLE_XML && strstr(said.text, "built without Expat"))
                continue;
            fail_msg("%s: %s", name, said.text);
        }
        assert_true(back.count >= 3);
        if (strcmp(name, "ome-zarr")) { /* which lists colours and names apart */
            assert_int_equal(back.count, 3);
            assert_int_equal(back.rows[0].value, 3);
            assert_int_equal(back.rows[2].value, 9);
            assert_string_equal(back.rows[0].name, strcmp(name, "freesurfer") ? "x y" : "x_y");
            if (!has_words && strcmp(name, "itksnap"))
                assert_string_equal(back.rows[1].name, rows[0].name);
        }
        if (has_color)
            assert_memory_equal(back.rows[0].rgb, rows[1].rgb, 3);
        if (has_opacity) {
            assert_near(back.rows[0].opacity, 0.4, 0.003);
            assert_true(back.rows[2].hidden);
        }
        sc_text_clear(&text);
    }
}

TEST(what_a_format_cannot_hold_is_told)
{
    sc_label rows[] = {{.value = -4, .name = "a", .opacity = -1},
                       {.value = 70000, .name = "b", .opacity = -1},
                       {.value = 5, .name = "say \"c\"", .opacity = -1}};
    const sc_label_table table = {rows, SC_COUNT_OF(rows), SC_COUNT_OF(rows)};
    const sc_label_table large = {rows + 1, 1, 1};
    const sc_table_writer *writer = sc_table_writer_find("ITKSNAP");
    sc_text text = {0};

    assert_ok(sc_label_table_print(&listening, "out", &table, writer, &text));
    assert_int_equal(said.warnings, 3);
    assert_non_null(strstr(said.text, "1 label has no colour"));
    sc_text_clear(&text);
    rows[2].has_color = true;
    assert_ok(sc_label_table_print(&listening, "out", &table, writer, &text));
    assert_non_null(strstr(said.text, "1 name is changed"));
    sc_text_clear(&text);
    strcpy(rows[2].name, "c");
    assert_ok(sc_label_table_print(&listening, "out", &table, writer, &text));
    assert_non_null(strstr(said.text, "numbers are too large, or negative) of 2 labels"));
    sc_text_clear(&text);
    assert_int_equal(sc_label_table_print(&listening, "out", &large, writer, &text), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "no label that a label description of ITK-SNAP can hold"));
    assert_null(text.data);
    assert_ptr_equal(sc_table_writer_for("A.TSV"), sc_table_writer_find("bids"));
    assert_null(sc_table_writer_for("a.txt"));
    assert_null(sc_table_writer_for(".csv"));
}

/* Names that spreadsheets take as formulas are told, where these open the table. */
TEST(names_that_are_formulas_are_told)
{
    sc_label rows[] = {{.value = 1, .name = "a=b", .opacity = -1, .has_color = true},
                       {.value = 2, .name = "=1+1", .opacity = -1, .has_color = true},
                       {.value = 3, .name = "@x", .opacity = -1, .has_color = true}};
    const sc_label_table table = {rows, SC_COUNT_OF(rows), SC_COUNT_OF(rows)};
    static const char *const writers[] = {"csv", "bids", "json"};

    for (size_t i = 0; i < SC_COUNT_OF(writers); i++) {
        SC_OWN(sc_text_clear) sc_text text = {0};
        const sc_ctx *ctx = listening_anew();

        assert_ok(
            sc_label_table_print(ctx, "out", &table, sc_table_writer_find(writers[i]), &text));
        assert_int_equal(said.warnings, i < 2 ? 1 : 0);
        if (i < 2)
            assert_non_null(strstr(said.text, "2 names begin as a formula does, such as \"=1+1\""));
        assert_non_null(strstr(text.data, "=1+1")); /* what is written stays as it is */
    }
}

RUN_TESTS(NULL, NULL)
