/* SPDX-License-Identifier: BSD-3-Clause */
/* Pages: nothing of their data becomes HTML, and their colours can be told apart. */
#include "check.h"

#include "segcast/image.h"
#include "segcast/page.h"
#include "segcast/report.h"

/* @return what a page has where its data stand. */
static const char *made_of(const char *json, sc_text *page)
{
    static const char begin[] = "<script type=\"application/json\" id=\"data\">";
    const char *at;

    assert_ok(sc_page_make(&quiet, json, page));
    at = strstr(page->data, begin);
    assert_non_null(at);
    return at + strlen(begin);
}

TEST(data_cannot_end_their_script)
{
    sc_text page = {0};

    assert_memory_equal(made_of("{\"a\":\"</script><b>\"}", &page),
                        "{\"a\":\"\\u003c/script>\\u003cb>\"}</script>", 39);
    assert_non_null(strstr(page.data, "</html>"));
    sc_text_clear(&page);
    assert_memory_equal(made_of("{}", &page), "{}</script>", 11);
    sc_text_clear(&page);
}

/* The first error is told, and nothing is left. */
TEST(without_memory_there_is_no_page)
{
    long budget = 0;
    const sc_ctx failing = {.alloc_budget = &budget};
    sc_text page = {0};

    assert_int_equal(sc_page_make(&failing, "{}", &page), SC_ERR_MEMORY);
    assert_null(page.data);
}

/* Read the colour of a series from the style of the page. */
static void color_of(int series, uint8_t rgb[3])
{
    char name[16];
    const char *at;
    unsigned value = 0;

    snprintf(name, sizeof name, "--c%d: #", series);
    at = strstr(sc_page_html, name);
    assert_non_null(at);
    assert_int_equal(sscanf(at + strlen(name), "%6x", &value), 1);
    for (int c = 0; c < 3; c++)
        rgb[c] = (uint8_t)(value >> (16 - 8 * c));
}

/* Colours of series can be told apart by everybody, those of neighbouring phases best. */
TEST(colors_differ)
{
    for (int i = 0; i < 8; i++) {
        for (int j = 0; j < i; j++) {
            uint8_t first[3], second[3];
            sc_seen_color a, b;

            color_of(i, first);
            color_of(j, second);
            a = sc_see_color(first);
            b = sc_see_color(second);
            if (sc_color_contrast(&a, &b) < (i - j == 1 ? SC_CONTRAST : 0.085))
                fail_msg("colours %d and %d are %.3f apart", j, i, sc_color_contrast(&a, &b));
        }
    }
}

RUN_TESTS(NULL, NULL)
