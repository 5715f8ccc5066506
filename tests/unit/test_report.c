/* SPDX-License-Identifier: BSD-3-Clause */
/* The blocks of which reports are made: escaping, axes, tables, plots, colours. */
#include "check.h"

#include "segcast/image.h"
#include "segcast/report.h"

#include <math.h>

/* Assert that @p add has added @p expected to a page. */
#define assert_adds(add, expected)                                                                 \
    do {                                                                                           \
        sc_page page = {.ctx = &quiet};                                                            \
        add;                                                                                       \
        assert_ok(page.status);                                                                    \
        assert_string_equal(page.text.data, expected);                                             \
        sc_page_clear(&page);                                                                      \
    } while (0)

TEST(texts_are_shown_as_they_are)
{
    assert_adds(sc_page_text(&page, "a<b & \"c\" 'd' > e"),
                "a&lt;b &amp; &quot;c&quot; &#39;d&#39; &gt; e");
    assert_adds(sc_page_text(&page, "</script><script>alert(1)</script>"),
                "&lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt;");
    assert_adds(sc_page_text(&page, "Herz \xc3\xa4 \xe2\x9d\xa4"), "Herz \xc3\xa4 \xe2\x9d\xa4");
    /* what is no UTF-8, controls, what turns the direction of writing, and what XML does not have
     */
    assert_adds(sc_page_text(&page, "\xff\x1b[31m"), "\\xff\\x1b[31m");
    assert_adds(sc_page_text(&page, "a\xe2\x80\xae<b"), "a\\u202e&lt;b");
    assert_adds(sc_page_text(&page, "\xef\xbf\xbf\xef\xbf\xbe"), "\\uffff\\ufffe");
    assert_adds(sc_page_text(&page, "two\n\tlines"), "two\n\tlines");
    assert_adds(sc_page_textf(&page, "%s %d%%", "<i>", 7), "&lt;i&gt; 7%");
    assert_adds(sc_page_prose(&page, "use `segcast <x>` now"),
                "use <code>segcast &lt;x&gt;</code> now");
    assert_adds(sc_page_prose(&page, "an `open end"), "an <code>open end</code>");
}

TEST(long_texts_are_whole)
{
    char text[3000];
    sc_page page = {.ctx = &quiet};

    memset(text, 'x', sizeof text);
    text[1000] = '<';
    text[sizeof text - 1] = '\0';
    sc_page_text(&page, text);
    sc_page_add(&page, "%s", text);
    assert_ok(page.status);
    assert_int_equal(page.text.length_bytes, 2 * (sizeof text - 1) + 3);
    sc_page_clear(&page);
}

TEST(addresses_lead_to_files_only)
{
    assert_adds(sc_page_address(&page, "javascript:alert(1).mp4"), "javascript%3Aalert%281%29.mp4");
    assert_adds(sc_page_address(&page, "a b\"<\xc3\xa4#?.mp4"), "a%20b%22%3C%C3%A4%23%3F.mp4");
    assert_adds(sc_page_address(&page, "stats.0of2.json"), "stats.0of2.json");
}

TEST(base_64)
{
    uint8_t bytes[100];

    assert_adds(sc_page_base64(&page, "M", 1), "TQ==");
    assert_adds(sc_page_base64(&page, "Ma", 2), "TWE=");
    assert_adds(sc_page_base64(&page, "Man", 3), "TWFu");
    assert_adds(sc_page_base64(&page, "\xfb\xff\xfe", 3), "+//+");
    memset(bytes, 0, sizeof bytes);
    {
        sc_page page = {.ctx = &quiet};

        sc_page_base64(&page, bytes, sizeof bytes);
        assert_int_equal(page.text.length_bytes, 136);
        assert_string_equal(page.text.data + 132, "AA==");
        sc_page_clear(&page);
    }
}

/* The first error stays, and nothing is added after it. */
TEST(the_first_error_stays)
{
    long budget = 3;
    const sc_ctx failing = {.alloc_budget = &budget};
    sc_page page = sc_page_begin(&failing, "title");

    for (int i = 0; i < 100000 && page.status == SC_OK; i++)
        sc_page_textf(&page, "%d", i);
    assert_int_equal(page.status, SC_ERR_MEMORY);
    budget = 1000;
    sc_page_text(&page, "more");
    assert_int_equal(sc_page_end(&page), SC_ERR_MEMORY);
    sc_page_clear(&page);
}

/* Steps are 1, 2 or 5 times a power of ten, about as many as were asked for, and hold all values.
 */
TEST(axes_have_nice_ticks)
{
    uint64_t random = 5;

    for (int i = 0; i < 20000; i++) {
        const double size = pow(10, random_real(&random, -9, 12));
        const double low = random_real(&random, -1, 1) * size;
        const double high = low + random_real(&random, 0.001, 1) * size;
        const int ticks = 1 + i % 10;
        const sc_axis axis = sc_axis_make(low, high, ticks);
        const double first = axis.step / pow(10, floor(log10(axis.step) + 1e-9));

        assert_true(axis.low <= low + 1e-6 * size && axis.high >= high - 1e-6 * size);
        assert_true(fabs(first - 1) < 1e-6 || fabs(first - 2) < 1e-6 || fabs(first - 5) < 1e-6);
        assert_true(sc_axis_ticks(&axis) >= 2 && sc_axis_ticks(&axis) <= 2 * ticks + 3);
        assert_near(sc_axis_percent(&axis, axis.high), 100, 1e-9);
    }
    assert_near(sc_axis_make(0, 0.93, 5).step, 0.2, 1e-12);
    assert_near(sc_axis_make(0, 0.93, 5).high, 1, 1e-12);
    assert_int_equal(sc_axis_make(0, 0.93, 5).decimals, 1);
    assert_int_equal(sc_axis_make(0, 8000, 4).decimals, 0);
}

TEST(axes_of_nothing)
{
    static const double odd[][2] = {{0, 0}, {3, 3}, {NAN, 1}, {0, INFINITY}, {2, 1}, {-4, -4}};

    for (size_t i = 0; i < SC_COUNT_OF(odd); i++) {
        const sc_axis axis = sc_axis_make(odd[i][0], odd[i][1], 5);

        assert_true(axis.high > axis.low && axis.step > 0 && isfinite(axis.high));
        assert_true(sc_axis_ticks(&axis) >= 2 && sc_axis_ticks(&axis) < 20);
    }
    assert_near(sc_axis_to(90, 6, true).high, 90, 0);
    assert_near(sc_axis_to(2, 6, true).step, 1, 0);
    assert_int_equal(sc_axis_ticks(&(sc_axis){.high = 90, .step = 20}), 5);
}

/* A logarithmic axis has its ticks at powers of two, at even distances, and not too many. */
TEST(axes_double)
{
    const sc_axis axis = sc_axis_doubling(1, 64), wide = sc_axis_doubling(0.3, 1e6);
    const sc_axis one = sc_axis_doubling(8, 8), none = sc_axis_doubling(0, NAN);

    assert_int_equal(sc_axis_ticks(&axis), 7);
    for (int i = 0; i < 7; i++) {
        assert_near(sc_axis_tick(&axis, i), 1 << i, 0);
        assert_near(sc_axis_percent(&axis, 1 << i), i / 6.0 * 100, 1e-9);
    }
    assert_near(sc_axis_percent(&axis, 0), 0, 0);
    assert_near(sc_axis_tick(&wide, 0), 0.25, 0);
    assert_true(sc_axis_ticks(&wide) <= 12 && sc_axis_percent(&wide, 1e6) <= 100);
    assert_int_equal(sc_axis_ticks(&one), 2);
    assert_near(sc_axis_tick(&none, 1), 2, 0);
}

TEST(dots_and_intervals_lie_on_the_axis)
{
    const double x[] = {1, 4}, y[] = {0.5, 1}, times[] = {1, 3};
    sc_page page = {.ctx = &quiet};
    const sc_plot_words words = {"c", "e", "f"};
    sc_plot plot =
        sc_plot_begin(&page, &words, sc_axis_doubling(1, 16), (sc_axis){.high = 1, .step = 1});
    sc_row_chart rows;

    sc_plot_points(&plot, x, y, 2, 3);
    sc_plot_end(&plot);
    rows = sc_rows_begin(&page, "c", sc_axis_to(4, 4, true), false);
    sc_row_begin(&rows, "r", "d");
    sc_row_dots(&rows, times, 2);
    sc_row_interval(&rows, 1, 2);
    sc_row_end(&rows, "2");
    sc_rows_end(&rows, "s");
    assert_ok(page.status);
    assert_non_null(strstr(page.text.data, ">16</text>"));
    assert_non_null(strstr(page.text.data, "class=\"c3 dots\" d=\"M0.0 500.0 h0M500.0 0.0 h0\""));
    assert_non_null(strstr(page.text.data, "cx=\"25.000%\" cy=\"50%\""));
    assert_non_null(strstr(page.text.data, "cx=\"75.000%\" cy=\"50%\""));
    assert_non_null(strstr(page.text.data, "x1=\"25.000%\" x2=\"50.000%\" y1=\"50%\""));
    sc_page_clear(&page);
}

TEST(tables_name_their_cells)
{
    static const char *const heads[] = {"name", "a < b"};
    sc_page page = {.ctx = &quiet};
    sc_table table = sc_table_begin(&page, "rows", heads, 2);

    sc_table_cell(&table, "%s", "<x>");
    sc_table_cell(&table, "%d", 3);
    sc_table_end(&table);
    assert_ok(page.status);
    assert_non_null(strstr(page.text.data, "<tr><th scope=\"row\" data-head=\"name\">&lt;x&gt;</th>"
                                           "<td class=\"n\" data-head=\"a &lt; b\">3</td></tr>"));
    sc_page_clear(&page);
}

/* A line has a gap where a value is missing, and a point by itself is drawn. */
TEST(lines_have_gaps)
{
    const double x[] = {0, 1, 2, 3, 4}, y[] = {0, 1, NAN, 1, NAN};
    sc_page page = {.ctx = &quiet};
    const sc_plot_words words = {"c<d", "e", "f"};
    sc_plot plot =
        sc_plot_begin(&page, &words, sc_axis_to(4, 4, true), (sc_axis){.high = 1, .step = 1});

    sc_plot_line(&plot, x, y, 5, 2, false);
    sc_plot_end(&plot);
    assert_ok(page.status);
    assert_non_null(strstr(page.text.data, "d=\"M0.0 1000.0 250.0 0.0 M750.0 0.0 h0.1 \""));
    assert_non_null(strstr(page.text.data, "<title id=\"title1\">c&lt;d</title>"));
    sc_page_clear(&page);
}

/* A strip has one piece for each thing that was done, with a gap before those that are long. */
TEST(strips_show_what_begins)
{
    static const int8_t kinds[12] = {-1, 3, 3, 3, 3, 3, 3, 3, 3, 3, -1, 0};
    static const bool begins[12] = {[5] = true};
    sc_page page = {.ctx = &quiet};
    sc_row_chart rows = sc_rows_begin(&page, "c", sc_axis_to(12, 3, true), true);

    sc_row_begin(&rows, "r", "d");
    sc_row_strip(&rows, kinds, begins, 12);
    sc_row_end(&rows, "");
    sc_rows_end(&rows, "s");
    assert_ok(page.status);
    assert_non_null(strstr(page.text.data, "class=\"c3\" d=\"M1.7 0V1H5V0zM5.7 0V1H10V0z\""));
    assert_non_null(strstr(page.text.data, "class=\"c0\" d=\"M11 0V1H12V0z\""));
    sc_page_clear(&page);
}

/* Colours of series can be told apart by everybody, those of neighbouring phases best. */
TEST(colors_differ)
{
    for (int i = 0; i < SC_SERIES_COLORS; i++) {
        for (int j = 0; j < i; j++) {
            const sc_seen_color a = sc_see_color(sc_series_colors[i]);
            const sc_seen_color b = sc_see_color(sc_series_colors[j]);
            const double contrast = sc_color_contrast(&a, &b);

            if (contrast < (i - j == 1 ? SC_CONTRAST : 0.085))
                fail_msg("colours %d and %d are %.3f apart", j, i, contrast);
        }
    }
}

RUN_TESTS(NULL, NULL)
