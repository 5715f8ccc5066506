/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a label table, read in each of the formats, applied to a volume, and written in the
 * formats of other programs; and a table of values. */
#include "volume.h"

#include "segcast/label_files.h"
#include "segcast/value_table.h"

#include <math.h>

/* Write the table in all formats: each is a text, or no row fits. */
static void print_all(const sc_label_table *table)
{
    for (size_t i = 0; sc_table_writer_name(i); i++) {
        SC_OWN(sc_text_clear) sc_text text = {0};
        const sc_status status = sc_label_table_print(
            &fuzz_ctx, "output", table, sc_table_writer_find(sc_table_writer_name(i)), &text);

        FUZZ_CHECK(status == SC_OK ? text.length_bytes > 0 : status == SC_ERR_DATA);
    }
}

/* Read the file as a table of values: every row has a number or a name, and a finite value or none.
 */
static void read_values(const char *path)
{
    static const char *const columns[] = {"", "x"};

    for (size_t i = 0; i < SC_COUNT_OF(columns); i++) {
        SC_OWN(sc_value_table_clear) sc_value_table table = {0};
        const sc_status status = sc_value_table_read(&fuzz_ctx, path, columns[i], &table);

        FUZZ_CHECK(status == SC_OK || status == SC_ERR_DATA);
        FUZZ_CHECK(status == SC_OK ? table.count > 0 : !table.text);
        for (size_t k = 0; k < table.count; k++) {
            const sc_value_row *row = &table.rows[k];

            FUZZ_CHECK(row->has_number || row->name[0]);
            FUZZ_CHECK(!isinf(row->value) && row->line > 0);
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const char *path = fuzz_write("input", data, size);

    read_values(path);
    for (int format = SC_TABLE_AUTO; format <= SC_TABLE_JSON; format++) {
        SC_OWN(sc_label_table_clear) sc_label_table table = {0};
        SC_OWN(sc_volume_clear)
        sc_volume volume = {.size = {1, 1, 1}, .label_bytes = 1, .label_count = 1};
        const sc_status status =
            sc_label_table_read(&fuzz_ctx, path, (sc_table_format)format, &table);
        void *labels;

        FUZZ_CHECK(status == SC_OK || status == SC_ERR_DATA);
        FUZZ_CHECK(sc_zalloc(&fuzz_ctx, 1, sizeof(sc_label), &labels) == SC_OK);
        volume.labels = labels;
        volume.labels[0].opacity = -1;
        if (status == SC_OK) {
            for (size_t i = 0; i < table.count; i++)
                FUZZ_CHECK(table.rows[i].value != 0);
            print_all(&table);
            if (sc_volume_add_labels(&fuzz_ctx, &volume, &table) == SC_OK)
                fuzz_check_labels(&volume);
        }
    }
    return 0;
}
