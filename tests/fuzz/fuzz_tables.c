/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a label table, read in each of the formats, and applied to a volume. */
#include "volume.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const char *path = fuzz_write("input", data, size);

    for (int format = SC_TABLE_AUTO; format <= SC_TABLE_XML; format++) {
        sc_label_table table = {0};
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
            if (sc_volume_add_labels(&fuzz_ctx, &volume, &table) == SC_OK)
                fuzz_check_labels(&volume);
        }
        sc_volume_clear(&volume);
        sc_label_table_clear(&table);
    }
    return 0;
}
