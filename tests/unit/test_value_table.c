/* SPDX-License-Identifier: BSD-3-Clause */
/* Tables of values: their headings, separators, encodings and mistakes. */
#include "check.h"

#include "segcast/value_table.h"

#include <math.h>
#include <unistd.h>

/* Read @p text of @p bytes bytes as a table of values. */
static sc_status read_bytes(const char *text, size_t bytes, const char *column, sc_value_table *out)
{
    const sc_ctx *ctx = listening_anew();
    sc_status status;

    write_bytes("v.csv", "", text, bytes);
    status = sc_value_table_read(ctx, "v.csv", column, out);
    unlink("v.csv");
    return status;
}

/* Expect two rows, of the number 4 or of "left atrium" with 2.5, and of 5 or "b" without a value.
 */
static void expect_two(const char *text, const char *column, bool has_number)
{
    SC_OWN(sc_value_table_clear) sc_value_table table = {0};

    if (read_bytes(text, strlen(text), column, &table) != SC_OK || table.count != 2)
        fail_msg("\"%s\": %zu rows: %s", text, table.count, said.text);
    for (size_t i = 0; i < 2; i++) {
        const sc_value_row *row = &table.rows[i];

        assert_int_equal(row->has_number, has_number);
        if (has_number)
            assert_int_equal(row->number, 4 + i);
        else
            assert_string_equal(row->name, i ? "b" : "left atrium");
        assert_true(i ? isnan(row->value) : row->value == 2.5);
    }
}

TEST(the_tissue_is_told_by_number_or_name)
{
    expect_two("index,thickness\n4,2.5\n5,n/a\n", "thickness", true);
    expect_two("# by hand\n\nname;Thickness;other\n\"left atrium\";2.5;7\nb;;8\n", "thickness",
               false);
    expect_two("thickness\tid\r\n2.5\t4\r\nNaN\t5\r\n", "", true);
    expect_two("label,x\nleft atrium,2.5\nb,-\n", "x", false);
    expect_two("label,x\n4,2.5\n5,none\n", "x", true);
    expect_two("name,value\nleft atrium,2.5\nb,null\n", "", false);
    expect_two("name,value\nleft atrium, 2.5 \nb\n", "value", false);
    expect_two("Index,SegId,StructName,x\n1,4,left atrium,2.5\n2,5,b,\n", "x", true);
    expect_two("id,X,x\n4,9,2.5\n# a \"quote\n5,9,\n", "x", true);
    expect_two("region,r,g,b,mean\nleft atrium,1,2,3,2.5\nb,1,2,3,\n", "", false);
    expect_two("region,r,g,b,mean\nleft atrium,2.5,2,3,9\nb,,2,3,\n", "R", false);
}

TEST(other_encodings_are_read)
{
    static const char utf16[] = "\xff\xfei\0d\0,\0x\0\n\0"
                                "4\0,\0"
                                "1\0";
    sc_value_table table = {0};

    assert_int_equal(read_bytes(utf16, sizeof utf16 - 1, "", &table), SC_OK);
    assert_true(table.count == 1 && table.rows[0].number == 4 && table.rows[0].value == 1);
    sc_value_table_clear(&table);
    assert_int_equal(read_bytes("name,x\nh\xf6he,1\n", 14, "", &table), SC_OK);
    assert_string_equal(table.rows[0].name, "h\xc3\xb6he");
    assert_string_equal(table.column, "x");
    sc_value_table_clear(&table);
}

/* Expect that a table is refused, with these words. */
static void expect_refused(const char *text, const char *column, const char *words)
{
    sc_value_table table = {0};

    assert_int_equal(read_bytes(text, strlen(text), column, &table), SC_ERR_DATA);
    if (said.errors != 1 || !strstr(said.text, words))
        fail_msg("\"%s\": expected \"%s\": %s", text, words, said.text);
    assert_true(!table.rows && !table.text);
}

TEST(mistakes_are_told_with_their_line)
{
    SC_OWN(sc_value_table_clear) sc_value_table table = {0};

    expect_refused("", "", "v.csv:1: is no line of headings");
    expect_refused("1,2,3\n4,5,6\n", "", "v.csv:1: is no line of headings");
    expect_refused("# a\nid,x,y\n4,1,2\n", "z",
                   "v.csv:2: has not exactly one column \"z\"; expected as color_by.column the "
                   "heading of the values, one of: \"x\", \"y\"");
    expect_refused("id,x,X,x\n4,1,2,3\n", "x", "has not exactly one column \"x\"");
    expect_refused("id,x,y\n4,1,2\n", "", "has not exactly one column that may hold the values");
    expect_refused("id,x\n4,1\n5,tall\n", "x", "v.csv:3: the value is \"tall\"");
    expect_refused("id;x\n4;1,5\n", "x", "expected a number with a decimal point");
    expect_refused("id,x\n4,inf\n", "x", "the value is \"inf\"");
    expect_refused("id,x\n", "x", "no tissues below them");
    assert_int_equal(read_bytes("id,name,x\n,,1\n4,,2\n", 19, "x", &table), SC_OK);
    assert_int_equal(table.count, 1);
    assert_non_null(strstr(said.text, "v.csv:2: 1 line has neither number nor name"));
}

RUN_TESTS(NULL, NULL)
