/* SPDX-License-Identifier: BSD-3-Clause */
/* What programs of several fields write: label tables in XML, in files of their own and in the
 * header extensions of NIfTI; MGH of FreeSurfer;
 * directories of masks; segments in layers. The files are written here, byte by byte. */
#include "check.h"

#include "segcast/volume.h"

#include <math.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

/* ---- label tables in XML ---- */

#define LABELS                                                                                     \
    "<LabelTable>\n<Label Key=\"0\">none</Label>\n"                                                \
    "<Label Key=\"2\" Red=\"0.0\" Green=\"0.5\" Blue=\"1.0\" Alpha=\"1\">"                         \
    "<![CDATA[left & right]]></Label>\n"                                                           \
    "<Label Key=\"-7\" Alpha=\"0.25\"> \n caf\xc3\xa9 &amp; co\n </Label>\n"                       \
    "<Label Key=\"9\" Red=\"1\" Green=\"1\" Blue=\"1\" Alpha=\"0\"/></LabelTable>"

/* Expect what LABELS holds. @return whether XML can be read: if not, so it was said. */
static bool expect_labels(sc_status status, const sc_label_table *table)
{
    if (strstr(said.text, "built without Expat"))
        return false;
    assert_ok(status);
    assert_int_equal(table->count, 3);
    assert_int_equal(table->rows[0].value, 2);
    assert_string_equal(table->rows[0].name, "left & right");
    assert_true(table->rows[0].has_color && table->rows[0].rgb[1] == 128);
    assert_int_equal(table->rows[0].rgb[2], 255);
    assert_true(table->rows[0].opacity < 0 && !table->rows[0].hidden);
    assert_int_equal(table->rows[1].value, -7);
    assert_string_equal(table->rows[1].name, "caf\xc3\xa9 & co");
    assert_false(table->rows[1].has_color);
    assert_near(table->rows[1].opacity, 0.25, 1e-6);
    assert_true(table->rows[2].hidden && !table->rows[2].name[0]);
    return true;
}

TEST(tables_in_xml_are_known_by_their_first_character)
{
    static const char *const documents[] = {
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<!DOCTYPE GIFTI SYSTEM \"http://www.nitrc.org/frs/download.php/115/gifti.dtd\">\n"
        "<GIFTI Version=\"1.0\" NumberOfDataArrays=\"0\">" LABELS
        "<LabelTable><Label Key=\"2\">second</Label></LabelTable></GIFTI>\n",
        "\xef\xbb\xbf\r\n " LABELS};

    for (size_t i = 0; i < SC_COUNT_OF(documents); i++) {
        const sc_ctx *ctx = listening_anew();
        SC_OWN(sc_label_table_clear) sc_label_table table = {0};
        sc_status status;

        write_text("f.xml", documents[i]);
        status = sc_label_table_read(ctx, "f.xml", SC_TABLE_AUTO, &table);
        if (expect_labels(status, &table))
            assert_non_null(strstr(said.text, "read as a GIFTI"));
    }
    unlink("f.xml");
}

/* Nothing that an XML document says is believed, and entities are not expanded. */
TEST(bad_xml_is_refused_with_its_line)
{
    static const struct {
        const char *document, *message;
    } cases[] = {
        {"<a>\n<LabelTable></b>", "line 2 of the XML: mismatched tag"},
        {"<LabelTable><Label Key=\"1\">x</Label>", "no element found"},
        {"<GIFTI></GIFTI>", "has no LabelTable"},
        {"<!DOCTYPE a [\n<!ENTITY b \"bb\"> <!ENTITY c \"&b;&b;\">]>\n<LabelTable>"
         "<Label Key=\"1\">&c;</Label></LabelTable>",
         "line 1 of the XML: its DOCTYPE declares entities"},
        {"<!DOCTYPE a [<!ENTITY b SYSTEM \"/etc/passwd\">]><LabelTable/>", "declares entities"},
        {"<LabelTable><Label Key=\"1\">\xff</Label></LabelTable>", "not well-formed"}};
    sc_label_table table = {0};

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        write_text("f.xml", cases[i].document);
        assert_int_equal(sc_label_table_read(&listening, "f.xml", SC_TABLE_XML, &table),
                         SC_ERR_DATA);
        if (!strstr(said.text, cases[i].message) && !strstr(said.text, "built without Expat"))
            fail_msg("case %zu: \"%s\", expected \"%s\"", i, said.text, cases[i].message);
    }
    unlink("f.xml");
}

TEST(labels_that_cannot_be_read_are_left_out_with_one_warning)
{
    SC_OWN(sc_label_table_clear) sc_label_table table = {0};
    sc_status status;

    write_text("f.xml", "<LabelTable>\n<Label Key=\"one\">a</Label>\n"
                        "<Label Key=\"2\" Red=\"255\" Green=\"0\" Blue=\"0\">b</Label>\n"
                        "<Label Key=\"99999999999999999999\">c</Label>\n"
                        "<Label Key=\"4\" Alpha=\"nan\">d</Label></LabelTable>");
    status = sc_label_table_read(&listening, "f.xml", SC_TABLE_XML, &table);
    if (!strstr(said.text, "built without Expat")) {
        assert_ok(status);
        assert_int_equal(said.warnings, 1);
        assert_non_null(strstr(said.text, "line 2 of its XML: 4 labels have"));
        assert_int_equal(table.count, 2);
        assert_int_equal(table.rows[0].value, 2);
        assert_false(table.rows[0].has_color);
        assert_string_equal(table.rows[1].name, "d");
        assert_true(table.rows[1].opacity < 0);
    }
    unlink("f.xml");
}

/* ---- header extensions of NIfTI ---- */

/* An extension in the byte order of this machine. */
typedef struct extension {
    int code, size; /* size 0: that of the text, filled up to a multiple of 16 */
    const char *text;
} extension;

/* Write a volume of 3 x 1 x 1 voxels with the labels 0, 2 and 9, and extensions. */
static void write_nifti(const char *path, const extension *extensions, size_t count)
{
    unsigned char bytes[4096] = {0};
    size_t end = 352;

    put32(bytes, 348);
    put16(bytes + 40, 3);
    put16(bytes + 42, 3);
    for (size_t i = 44; i < 56; i += 2)
        put16(bytes + i, 1);
    put16(bytes + 70, 2);
    put16(bytes + 72, 8);
    for (size_t i = 76; i < 92; i += 4)
        put_real(bytes + i, 1);
    memcpy(bytes + 344, "n+1", 4);
    put16(bytes + 254, 1); /* sform */
    for (size_t i = 280; i < 328; i += 20)
        put_real(bytes + i, 1);
    bytes[348] = count > 0;
    for (size_t i = 0; i < count; i++) {
        const size_t size = (8 + strlen(extensions[i].text) + 15) / 16 * 16;

        put32(bytes + end, extensions[i].size ? extensions[i].size : (int32_t)size);
        put32(bytes + end + 4, extensions[i].code);
        memcpy(bytes + end + 8, extensions[i].text, strlen(extensions[i].text));
        end += size;
    }
    put_real(bytes + 108, (float)end);
    bytes[end + 1] = 2;
    bytes[end + 2] = 9;
    write_bytes(path, "", bytes, end + 3);
}

/* Whatever the code of the extension is, as TotalSegmentator and Workbench differ in it. */
TEST(names_come_from_an_extension_of_the_header)
{
    static const extension caret = {
        0, 0, "<?xml version=\"1.0\"?> <CaretExtension>" LABELS "</CaretExtension>"};
    const extension two[] = {{6, 0, "a comment"}, caret};

    for (size_t skip = 0; skip < 2; skip++) {
        const sc_ctx *ctx = listening_anew();
        SC_OWN(sc_volume_clear) sc_volume v = {0};

        write_nifti("f.nii", two + skip, 2 - skip);
        assert_ok(sc_volume_read(ctx, "f.nii", &v));
        assert_int_equal(v.label_count, 3);
        if (!strstr(said.text, "built without Expat")) {
            assert_string_equal(v.labels[1].name, "left & right");
            assert_true(v.labels[1].has_color && v.labels[1].rgb[1] == 128);
            assert_true(v.labels[2].hidden);
        }
    }
    unlink("f.nii");
}

/* The voxels are read in any case. */
TEST(damaged_extensions_give_a_warning)
{
    static const struct {
        extension extension;
        const char *message; /* NULL: none */
    } cases[] = {{{0, 0, "no table"}, NULL},
                 {{0, 0, "<LabelTable><Label Key=\"2\">x</Label>"}, "no element found"},
                 {{0, 7, "<LabelTable/>"}, "has 7 bytes, expected 8 to 32"},
                 {{0, -16, "<LabelTable/>"}, "has -16 bytes"},
                 {{0, 1 << 30, "<LabelTable/>"}, "has 1073741824 bytes"}};

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        sc_ctx ctx = *listening_anew();
        sc_volume scan = {0};

        write_nifti("f.nii", &cases[i].extension, 1);
        assert_ok(
            sc_volume_read_by(&ctx, "f.nii", &(sc_read_choice){.depth = SC_READ_HEADER}, &scan));
        assert_int_equal(scan.label_count, 1);
        sc_volume_clear(&scan);
        ctx = *listening_anew();
        ctx.level = SC_LOG_WARN;
        assert_ok(
            sc_volume_read_by(&ctx, "f.nii", &(sc_read_choice){.depth = SC_READ_TALLIES}, &scan));
        assert_int_equal(scan.label_count, 3);
        assert_int_equal(said.warnings, cases[i].message != NULL);
        if (cases[i].message && !strstr(said.text, cases[i].message) &&
            !strstr(said.text, "built without Expat"))
            fail_msg("case %zu: \"%s\", expected \"%s\"", i, said.text, cases[i].message);
        sc_volume_clear(&scan);
    }
    unlink("f.nii");
}

/* ---- MGH ---- */

enum { MGH_HEAD = 284 };

static void put_big(unsigned char *at, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        at[i] = (unsigned char)(value >> (24 - 8 * i));
}

static void put_big_real(unsigned char *at, float value)
{
    uint32_t bits;

    memcpy(&bits, &value, 4);
    put_big(at, bits);
}

/* The header of 3 x 2 x 1 voxels of type @p type: x runs to the left by 2 mm, y down by 3 mm, z to
 * the front by 4 mm. */
static void mgh_header(unsigned char h[MGH_HEAD], uint32_t type)
{
    static const float reals[] = {2, 3, 4, -1, 0, 0, 0, 0, -1, 0, 1, 0, 10, 20, 30};

    memset(h, 0, MGH_HEAD);
    put_big(h, 1);
    put_big(h + 4, 3);
    put_big(h + 8, 2);
    put_big(h + 12, 1);
    put_big(h + 16, 1);
    put_big(h + 20, type);
    h[29] = 1;
    for (size_t i = 0; i < SC_COUNT_OF(reals); i++)
        put_big_real(h + 30 + 4 * i, reals[i]);
}

/* Write the labels 0, 0, 0, 0, 0, 7 behind the header, and @p tags bytes of tags. */
static void write_mgh(const char *path, const unsigned char h[MGH_HEAD], size_t each, size_t tags)
{
    static unsigned char bytes[1 << 22];
    gzFile file = gzopen(path, strstr(path, ".mgz") ? "wb" : "wbT");
    const size_t end = MGH_HEAD + 6 * each;
    uint64_t random = 1;

    memset(bytes, 0, sizeof bytes);
    memcpy(bytes, h, MGH_HEAD);
    bytes[end - 1] = 7;
    for (size_t i = 0; i < tags; i++) /* which do not compress: zlib must not unpack all at once */
        bytes[end + i] = (unsigned char)random_bits(&random);
    assert_non_null(file);
    assert_int_equal(gzwrite(file, bytes, (unsigned)(end + tags)), end + tags);
    assert_int_equal(gzclose(file), Z_OK);
}

TEST(mgh_of_every_type_is_read)
{
    static const struct {
        uint32_t type;
        size_t bytes;
    } types[] = {{0, 1}, {4, 2}, {10, 2}, {1, 4}};
    static const double to_ras[12] = {-2, 0, 0, 13, 0, 0, 4, 18, 0, -3, 0, 33};

    for (size_t i = 0; i < 2 * SC_COUNT_OF(types); i++) {
        const char *path = i % 2 ? "f.mgz" : "f.mgh";
        unsigned char h[MGH_HEAD];
        const sc_ctx *ctx = listening_anew();
        SC_OWN(sc_volume_clear) sc_volume v = {0};

        mgh_header(h, types[i / 2].type);
        write_mgh(path, h, types[i / 2].bytes, i / 2 * 30000);
        assert_ok(sc_volume_read(ctx, path, &v));
        assert_int_equal(v.size[0], 3);
        assert_int_equal(v.label_count, 2);
        assert_int_equal(v.labels[1].value, 7);
        assert_int_equal(((const uint8_t *)v.ids)[5], 1);
        assert_true(v.oriented);
        assert_int_equal(said.warnings, 0);
        for (int k = 0; k < 12; k++)
            assert_near(v.to_ras_mm.m[k / 4][k % 4], to_ras[k], 1e-5);
        unlink(path);
    }
}

/* Append a number, or a text behind its length, to the tags. */
static size_t put_number(unsigned char *tags, size_t at, uint32_t value)
{
    put_big(tags + at, value);
    return at + 4;
}

static size_t put_text(unsigned char *tags, size_t at, const char *text)
{
    at = put_number(tags, at, (uint32_t)strlen(text) + 1);
    memcpy(tags + at, text, strlen(text) + 1);
    return at + strlen(text) + 1;
}

static size_t put_row(unsigned char *tags, size_t at, const char *name, const int level[4])
{
    at = put_text(tags, at, name);
    for (int i = 0; i < 4; i++)
        at = put_number(tags, at, (uint32_t)level[i]);
    return at;
}

/* Write tags as FreeSurfer 7 does: a transform, its kind of phase, and a colour table of version 1
 * or 2 with the labels 0, 7 and 8. @return how many bytes there are. */
static size_t mgh_tags(unsigned char *tags, int version)
{
    static const int level[3][4] = {{0, 0, 0, 0}, {230, 148, 34, 0}, {1, 2, 300, 51}};
    static const char *const names[3] = {"Unknown", "Left-Cerebellum-White-Matter", "Clear"};
    size_t at = 20; /* numbers of the scanner */

    at = put_number(tags, at, 31);
    at = put_number(tags, put_number(tags, at, 0), 6);
    memcpy(tags + at, "t.xfm", 6);
    at = put_number(tags, at + 6, 2); /* TAG_OLD_USEREALRAS has no length */
    at = put_number(tags, at, 30);
    at = put_number(tags, at, 3) + 3;
    at = put_number(tags, at, 1);
    if (version == 2)
        at = put_number(tags, at, (uint32_t)-2);
    at = put_number(tags, at, 9);
    at = put_text(tags, at, "/home/me/FreeSurferColorLUT.txt");
    if (version == 2)
        at = put_number(tags, at, 3);
    for (int i = 0; i < (version == 2 ? 3 : 9); i++) {
        const int row = version == 2 ? i : i < 7 ? 0 : i - 6;

        if (version == 2)
            at = put_number(tags, at, row ? (uint32_t)row + 6 : 0);
        at = put_row(tags, at, names[row], level[row]);
    }
    return at;
}

/* Write the labels 0, 0, 0, 0, 7, 8 with these tags to f.mgz, and read them. */
static void read_tags(const unsigned char *tags, size_t count, sc_volume *v)
{
    static const unsigned char labels[6] = {0, 0, 0, 0, 7, 8};
    unsigned char h[MGH_HEAD];
    const sc_ctx *ctx = listening_anew();
    gzFile file = gzopen("f.mgz", "wb");

    mgh_header(h, 0);
    assert_non_null(file);
    gzwrite(file, h, MGH_HEAD);
    gzwrite(file, labels, sizeof labels);
    gzwrite(file, tags, (unsigned)count);
    assert_int_equal(gzclose(file), Z_OK);
    *v = (sc_volume){0};
    assert_ok(sc_volume_read(ctx, "f.mgz", v));
}

TEST(the_colour_table_of_mgh_is_used)
{
    unsigned char tags[4096] = {0};
    sc_volume v;

    for (int version = 1; version <= 2; version++) {
        const size_t bytes = mgh_tags(tags, version);

        read_tags(tags, bytes, &v);
        assert_int_equal(said.warnings, 0);
        assert_string_equal(v.labels[1].name, "Left-Cerebellum-White-Matter");
        assert_true(v.labels[1].has_color && v.labels[1].opacity < 0);
        assert_int_equal(v.labels[1].rgb[1], 148);
        assert_string_equal(v.labels[2].name, "Clear");
        assert_int_equal(v.labels[2].rgb[2], 255);
        assert_near(v.labels[2].opacity, 0.8, 1e-6);
        sc_volume_clear(&v);
        read_tags(tags, bytes - 3, &v); /* the table ends early */
        assert_int_equal(said.warnings, 1);
        assert_non_null(strstr(said.text, "colour table behind its voxels is damaged"));
        assert_string_equal(v.labels[1].name, "");
        sc_volume_clear(&v);
        read_tags(tags, 50, &v); /* the file ends in another tag, which is no fault */
        assert_int_equal(said.warnings, 0);
        sc_volume_clear(&v);
    }
    unlink("f.mgz");
}

TEST(mgh_without_geometry_is_coronal)
{
    unsigned char h[MGH_HEAD];
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    mgh_header(h, 0);
    h[29] = 0;
    write_mgh("f.mgh", h, 1, 0);
    assert_ok(sc_volume_read(&listening, "f.mgh", &v));
    assert_int_equal(said.warnings, 1);
    assert_non_null(strstr(said.text, "does not give its geometry; read as FreeSurfer does"));
    assert_near(v.to_ras_mm.m[0][0], -1, 0);
    assert_near(v.to_ras_mm.m[1][2], 1, 0);
    assert_near(v.to_ras_mm.m[2][1], -1, 0);
    assert_near(v.to_ras_mm.m[0][3], 1.5, 0);
    unlink("f.mgh");
}

TEST(bad_mgh_is_refused)
{
    static const struct {
        size_t at;
        uint32_t value;
        const char *message;
    } cases[] = {{20, 2, "its type is 2, expected 0, 1, 3, 4 or 10"},
                 {16, 5, "has 5 frames, expected one"},
                 {16, 0, "has 0 frames"},
                 {4, 0, "size 0 along axis 0"},
                 {8, 0x80000000u, "size -2147483648 along axis 1"},
                 {12, 0x7fffffff, "the header promises"},
                 {30, 0, "its voxels measure 0 to 4 mm"},
                 {78, 0x7fc00000, "geometry holds nan"}};
    unsigned char h[MGH_HEAD];
    sc_volume v = {0};

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        mgh_header(h, 0);
        put_big(h + cases[i].at, cases[i].value);
        write_mgh("f.mgz", h, 1, 0);
        assert_int_equal(sc_volume_read(&listening, "f.mgz", &v), SC_ERR_DATA);
        if (!strstr(said.text, cases[i].message))
            fail_msg("case %zu: \"%s\", expected \"%s\"", i, said.text, cases[i].message);
    }
    mgh_header(h, 1); /* voxels of four bytes are promised, and of one written */
    write_mgh("f.mgh", h, 1, 0);
    assert_int_equal(sc_volume_read(&listening, "f.mgh", &v), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "more than the file can hold"));
    unlink("f.mgz");
    unlink("f.mgh");
}

/* The check sum of a gzip file is verified although tags follow the voxels. */
TEST(damage_behind_the_voxels_of_mgz_is_noticed)
{
    unsigned char h[MGH_HEAD];
    sc_volume v = {0};
    FILE *file;

    mgh_header(h, 0);
    write_mgh("f.mgz", h, 1, 3000000);
    file = fopen("f.mgz", "rb+");
    assert_non_null(file);
    assert_int_equal(fseek(file, -8, SEEK_END), 0); /* the check sum, then the length */
    assert_true(fputs("1234", file) >= 0);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(sc_volume_read(&listening, "f.mgz", &v), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "the compressed data are damaged"));
    unlink("f.mgz");
}

/* ---- directories of masks ---- */

enum { MASK_VOXELS = 6 };

/* Write a NRRD of 6 x 1 x 1 voxels, the bytes of @p voxels less '0', with an origin of @p x mm. */
static void write_mask(const char *path, const char *voxels, double x)
{
    FILE *file = fopen(path, "wb");

    assert_non_null(file);
    fprintf(file,
            "NRRD0004\ntype: uint8\ndimension: 3\nspace: RAS\nsizes: %zu 1 1\n"
            "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (%.9g,0,0)\n"
            "encoding: raw\n\n",
            strlen(voxels), x);
    for (; *voxels; voxels++)
        fputc(*voxels - '0', file);
    assert_int_equal(fclose(file), 0);
}

/* Expect that @p v holds the labels @p values, as digits. */
static void expect_voxels(const sc_volume *v, const char *values)
{
    for (int i = 0; i < MASK_VOXELS; i++)
        assert_int_equal(v->labels[((const uint8_t *)v->ids)[i]].value, values[i] - '0');
}

TEST(masks_of_a_directory_become_labels_by_their_names)
{
    sc_volume scan = {0};
    SC_OWN(sc_volume_clear) sc_volume v = {0};
    bool reads = false;

    assert_int_equal(mkdir("m.dir", 0777), 0);
    write_mask("m.dir/liver.nrrd", "011100", 3);
    write_mask("m.dir/aorta.seg.nrrd", "000001", 3.0000001);
    write_mask("m.dir/Spleen.nrrd", "000000", 3);
    write_mask("m.dir/kidney left.nrrd", "500000", 3);
    write_text("m.dir/.liver.nrrd", "hidden");
    write_text("m.dir/statistics.json", "{}");
    assert_ok(sc_volume_read(&listening, "m.dir", &v));
    assert_int_equal(said.warnings, 0);
    assert_int_equal(v.label_count, 4); /* Spleen has 1, and no voxel */
    expect_voxels(&v, "344402");
    assert_string_equal(v.labels[1].name, "aorta");
    assert_string_equal(v.labels[2].name, "kidney left");
    assert_string_equal(v.labels[3].name, "liver");
    assert_near(v.to_ras_mm.m[0][3], 3, 1e-6);
    assert_non_null(strstr(said.text, "1 of 4 masks is empty: Spleen"));
    assert_ok(sc_volume_read_by(&listening, "m.dir/", &(sc_read_choice){.depth = SC_READ_TALLIES},
                                &scan));
    assert_int_equal(scan.label_count, 4);
    assert_int_equal(scan.tallies[3].voxels, 3);
    sc_volume_clear(&scan);
    assert_ok(
        sc_volume_read_by(&listening, "m.dir", &(sc_read_choice){.depth = SC_READ_HEADER}, &scan));
    assert_int_equal(scan.label_count, 5);
    assert_string_equal(scan.labels[1].name, "Spleen");
    sc_volume_clear(&scan);
    assert_ok(sc_volume_reads(&listening, "m.dir", "m.dir/liver.nrrd", &reads));
    assert_true(reads);
    assert_ok(sc_volume_reads(&listening, "m.dir", "m.dir/statistics.json", &reads));
    assert_false(reads);
    (void)!system("rm -r m.dir");
}

/* A tumour within a liver is seen, whatever their names; and each rule says how many voxels it
 * decides. */
TEST(overlaps_are_resolved_by_a_rule_and_told)
{
    static const struct {
        sc_overlap overlap;
        const char *labels, *message, *names;
    } cases[] = {
        {SC_OVERLAP_SMALLER, "121333",
         "m.dir: 4 voxels belong to several masks; each is shown as the smallest of them (overlap: "
         "smaller), most often as \"tumour\" and not \"liver\" (3)",
         NULL},
        {SC_OVERLAP_ORDER, "122333",
         "m.dir: 4 voxels belong to several masks; each is shown as the last of them (overlap: "
         "order), most often as \"tumour\" and not \"liver\" (3)",
         NULL},
        {SC_OVERLAP_NAMES, "122222",
         "m.dir: 4 voxels belong to several masks; each is shown as that which is named first, or "
         "else the smallest (overlap: names), most often as \"liver\" and not \"tumour\" (3)",
         "Liver\n"},
        {SC_OVERLAP_NAMES, "122333",
         "m.dir: 4 voxels belong to several masks; each is shown as that which is named first, or "
         "else the smallest (overlap: names), most often as \"tumour\" and not \"liver\" (3)",
         "tum*\nli?er\n"}};

    assert_int_equal(mkdir("m.dir", 0777), 0);
    write_mask("m.dir/duct.nrrd", "101000", 0);
    write_mask("m.dir/liver.nrrd", "011111", 0);
    write_mask("m.dir/tumour.nrrd", "000111", 0);
    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        const sc_ctx *ctx = listening_anew();
        SC_OWN(sc_volume_clear) sc_volume v = {0};

        assert_ok(sc_volume_read_by(
            ctx, "m.dir",
            &(sc_read_choice){.overlap = cases[i].overlap, .overlap_names = cases[i].names}, &v));
        /* of a tissue that has no voxel left, another warning tells */
        assert_int_equal(said.warnings, strchr(cases[i].labels, '3') ? 1 : 2);
        assert_string_equal(said.text, cases[i].message);
        expect_voxels(&v, cases[i].labels);
    }
    {
        const sc_ctx *ctx = listening_anew();
        sc_volume v = {0};

        assert_int_equal(sc_volume_read_by(ctx, "m.dir",
                                           &(sc_read_choice){.overlap = SC_OVERLAP_NAMES,
                                                             .overlap_names = "liver\nspleen\n"},
                                           &v),
                         SC_ERR_DATA);
        assert_int_equal(said.errors, 1);
        assert_non_null(strstr(said.text, "overlap: no tissue is called \"spleen\""));
    }
    (void)!system("rm -r m.dir");
}

/* Only the box is kept, and what overlaps outside of it is not told; which tissue is the smaller
 * one follows from whole masks. */
TEST(a_box_of_masks_is_as_if_cut_off)
{
    const sc_read_choice box = {.box = SC_READ_VOXELS, .voxels = {{2, 5}, {0, 1}, {0, 1}}};

    assert_int_equal(mkdir("m.dir", 0777), 0);
    write_mask("m.dir/duct.nrrd", "101000", 7);
    write_mask("m.dir/liver.nrrd", "011011", 7);
    write_mask("m.dir/tumour.nrrd", "000051", 7); /* two labels: refused by whichever thread */
    for (int threads = 1; threads < 4; threads++) {
        sc_ctx ctx = *listening_anew();
        SC_OWN(sc_volume_clear) sc_volume v = {0};

        ctx.threads = threads;
        write_mask("m.dir/tumour.nrrd", "000051", 7);
        assert_int_equal(sc_volume_read_by(&ctx, "m.dir", &box, &v), SC_ERR_DATA);
        assert_int_equal(said.errors, 1);
        assert_non_null(strstr(said.text, "m.dir/tumour.nrrd: holds the labels 5 and 1"));
        write_mask("m.dir/tumour.nrrd", "000055", 7);
        assert_ok(sc_volume_read_by(&ctx, "m.dir", &box, &v));
        assert_non_null(strstr(said.text, "m.dir: 2 voxels belong to several masks"));
        assert_int_equal(v.size[0], 3);
        assert_int_equal(v.label_count, 3);
        assert_near(v.to_ras_mm.m[0][3], 9, 1e-9);
        for (int i = 0; i < 3; i++)
            assert_int_equal(v.labels[((const uint8_t *)v.ids)[i]].value, "103"[i] - '0');
    }
    (void)!system("rm -r m.dir");
}

TEST(masks_of_parts_of_one_grid_are_united)
{
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    assert_int_equal(mkdir("m.dir", 0777), 0);
    write_mask("m.dir/a.nrrd", "100000", 0);
    write_mask("m.dir/b.nrrd", "01110", -2);
    assert_ok(sc_volume_read(&listening, "m.dir", &v));
    assert_int_equal(v.size[0], 8);
    assert_near(v.to_ras_mm.m[0][3], -2, 1e-9);
    for (int i = 0; i < 8; i++)
        assert_int_equal(v.labels[((const uint8_t *)v.ids)[i]].value, "02120000"[i] - '0');
    (void)!system("rm -r m.dir");
}

TEST(masks_that_do_not_fit_together_are_refused)
{
    static const struct {
        const char *name, *voxels, *message;
        double x;
    } cases[] = {
        {"m.dir/b.nrrd", "01110",
         "m.dir/b.nrrd has another voxel size or orientation than m.dir/a.nrrd, or voxels between "
         "its voxels",
         0.5},
        {"m.dir/b.nrrd", "000001",
         "m.dir/b.nrrd has another voxel size or orientation than m.dir/a.nrrd", 0.1},
        {"m.dir/b.nrrd", "012000", "m.dir/b.nrrd: holds the labels 1 and 2, expected the mask", 0},
        {"m.dir/a.nii", "", "m.dir/a.nii and m.dir/a.nrrd name the same tissue", 0},
        {"m.dir/b.mha", "", "m.dir/b.mha:", 0}};
    sc_ctx ctx = *listening_anew();
    sc_volume v = {0};

    assert_int_equal(mkdir("m.dir", 0777), 0);
    write_mask("m.dir/a.nrrd", "100000", 0);
    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        said.errors = 0;
        write_mask(cases[i].name, cases[i].voxels, cases[i].x);
        assert_int_equal(sc_volume_read(&ctx, "m.dir", &v), SC_ERR_DATA);
        assert_int_equal(said.errors, 1);
        if (!strstr(said.text, cases[i].message))
            fail_msg("case %zu: \"%s\", expected \"%s\"", i, said.text, cases[i].message);
        unlink(cases[i].name);
    }
    ctx.memory_max_bytes = 20;
    assert_int_equal(sc_volume_read(&ctx, "m.dir", &v), SC_ERR_SYSTEM);
    (void)!system("rm -r m.dir");
}

/* ---- segments in layers ---- */

/* A segment of Slicer: value, layer, name. */
#define SEGMENT(i, value, layer, name)                                                             \
    "Segment" i "_ID:=s" i "\nSegment" i "_LabelValue:=" value "\nSegment" i "_Layer:=" layer "\n" \
    "Segment" i "_Name:=" name "\nSegment" i "_Color:=1 0 0\n"

/* Write 6 x 1 x 1 voxels with the values @p a in the first layer and @p b in the second. */
static void write_layers(const char *path, const char *segments, const char *a, const char *b)
{
    FILE *file = fopen(path, "wb");

    assert_non_null(file);
    fprintf(file,
            "NRRD0004\ntype: uint8\ndimension: 4\nspace: left-posterior-superior\n"
            "sizes: 2 6 1 1\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\n"
            "kinds: list domain domain domain\nspace origin: (0,0,0)\nencoding: raw\n%s\n",
            segments);
    for (int i = 0; a[i] && b[i]; i++) {
        fputc(a[i] - '0', file);
        fputc(b[i] - '0', file);
    }
    assert_int_equal(fclose(file), 0);
}

TEST(segments_in_layers_become_labels)
{
    static const struct {
        const char *segments;
        sc_overlap overlap;
        const char *labels, *names[3], *message;
    } cases[] = {
        {SEGMENT("0", "1", "0", "liver") SEGMENT("1", "2", "0", "aorta")
             SEGMENT("2", "3", "1", "tumour"),
         SC_OVERLAP_SMALLER,
         "113302",
         {"liver", "aorta", "tumour"},
         "f.seg.nrrd: 2 voxels belong to several segments; each is shown as the smallest of them "
         "(overlap: smaller), most often as \"tumour\" and not \"liver\" (2)"},
        {SEGMENT("0", "3", "1", "tumour") SEGMENT("1", "1", "0", "liver")
             SEGMENT("2", "2", "0", "aorta"),
         SC_OVERLAP_ORDER,
         "111102",
         {"liver", "aorta", NULL},
         "f.seg.nrrd: 2 voxels belong to several segments; each is shown as the last of them "
         "(overlap: order), most often as \"liver\" and not \"tumour\" (2)"},
        {SEGMENT("0", "1", "0", "liver") SEGMENT("1", "2", "0", "aorta")
             SEGMENT("2", "3", "1", "tumour"),
         SC_OVERLAP_NAMES,
         "111102",
         {"liver", "aorta", NULL},
         "f.seg.nrrd: 2 voxels belong to several segments; each is shown as that which is named "
         "first, or else the smallest (overlap: names), most often as \"liver\" and not \"tumour\" "
         "(2)"},
        {SEGMENT("0", "1", "0", "liver") SEGMENT("1", "3", "1", "tumour"),
         SC_OVERLAP_SMALLER,
         "113300",
         {"liver", "tumour", NULL},
         "f.seg.nrrd: 2 voxels belong to several segments; each is shown as the smallest of them "
         "(overlap: smaller), most often as \"tumour\" and not \"liver\" (2)"},
        {SEGMENT("0", "1", "0", "liver") SEGMENT("1", "2", "0", "aorta")
             SEGMENT("2", "3", "2", "tumour"),
         SC_OVERLAP_SMALLER,
         "111102",
         {"liver", "aorta", NULL},
         "f.seg.nrrd: 2 voxels of its layers hold a value that no segment has; they are left out"}};

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        const sc_ctx *ctx = listening_anew();
        SC_OWN(sc_volume_clear) sc_volume v = {0};

        write_layers("f.seg.nrrd", cases[i].segments, "111102", "003300");
        assert_ok(sc_volume_read_by(
            ctx, "f.seg.nrrd",
            &(sc_read_choice){.overlap = cases[i].overlap, .overlap_names = "liver\n"}, &v));
        assert_string_equal(said.text, cases[i].message);
        assert_int_equal(said.warnings,
                         i == 0 ? 1 : 2); /* the tumour is covered, or has no layer */
        assert_int_equal(v.size[0], MASK_VOXELS);
        expect_voxels(&v, cases[i].labels);
        for (int k = 1; k < v.label_count; k++) {
            assert_string_equal(v.labels[k].name, cases[i].names[k - 1]);
            assert_int_equal(v.labels[k].rgb[0], 255);
        }
    }
    unlink("f.seg.nrrd");
}

TEST(a_box_of_layers_is_as_if_cut_off)
{
    const sc_read_choice box = {.box = SC_READ_VOXELS, .voxels = {{1, 4}, {0, 1}, {0, 1}}};
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    write_layers("f.seg.nrrd",
                 SEGMENT("0", "1", "0", "liver") SEGMENT("1", "2", "0", "aorta")
                     SEGMENT("2", "3", "1", "tumour"),
                 "111112", "000033");
    assert_ok(sc_volume_read_by(&listening, "f.seg.nrrd", &box, &v));
    assert_int_equal(said.warnings, 0); /* nothing overlaps in the box */
    assert_int_equal(v.size[0], 3);
    assert_int_equal(v.label_count, 2);
    assert_near(v.to_ras_mm.m[0][3], -1, 1e-9);
    unlink("f.seg.nrrd");
}

/* As 3D Slicer writes them: it begins with 1 in each layer. */
TEST(numbers_that_layers_share_are_given_anew)
{
    sc_volume scan = {0};
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    write_layers("f.seg.nrrd",
                 SEGMENT("0", "1", "0", "liver") SEGMENT("1", "2", "0", "aorta")
                     SEGMENT("2", "1", "1", "spleen"),
                 "111002", "001100");
    assert_ok(sc_volume_read(&listening, "f.seg.nrrd", &v));
    assert_int_equal(said.warnings, 1);
    expect_voxels(&v, "113302"); /* spleen is smaller than liver */
    assert_ok(sc_volume_read_by(&listening, "f.seg.nrrd",
                                &(sc_read_choice){.depth = SC_READ_TALLIES}, &scan));
    assert_int_equal(scan.tallies[3].voxels, 2);
    sc_volume_clear(&scan);
    assert_ok(sc_volume_read_by(&listening, "f.seg.nrrd",
                                &(sc_read_choice){.depth = SC_READ_HEADER}, &scan));
    assert_int_equal(scan.label_count, 4);
    assert_int_equal(scan.size[0], MASK_VOXELS);
    assert_string_equal(scan.labels[3].name, "spleen");
    assert_non_null(strstr(said.text, "numbered anew"));
    sc_volume_clear(&scan);
    unlink("f.seg.nrrd");
}

TEST(layers_that_cannot_be_read_are_refused)
{
    sc_volume v = {0};

    write_layers("f.seg.nrrd", "", "111102", "003300");
    assert_int_equal(sc_volume_read(&listening, "f.seg.nrrd", &v), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "holds 2 volumes, one for each time (4-D)"));
    write_layers("f.seg.nrrd", SEGMENT("0", "1", "0", "a"), "11", "00");
    assert_int_equal(sc_volume_read(&listening, "f.seg.nrrd", &v), SC_ERR_DATA);
    assert_int_equal(said.errors, 2);
    write_layers("f.seg.nrrd", SEGMENT("0", "x", "0", "a"), "111102", "003300");
    assert_ok(sc_volume_read(&listening, "f.seg.nrrd",
                             &v)); /* no segment can be used: all is background */
    assert_int_equal(v.label_count, 1);
    sc_volume_clear(&v);
    write_layers("f.seg.nrrd", SEGMENT("0", "1", "-1", "a"), "111102", "003300");
    assert_ok(sc_volume_read(&listening, "f.seg.nrrd", &v));
    assert_int_equal(v.label_count, 1);
    sc_volume_clear(&v);
    unlink("f.seg.nrrd");
}

RUN_TESTS(NULL, NULL)
