/* SPDX-License-Identifier: BSD-3-Clause */
/* A volume file that is an input: the same for all formats, each of which is a target of its own so
 * that it has its own corpus. */
#ifndef SC_FUZZ_VOLUME_H
#define SC_FUZZ_VOLUME_H

#include "fuzz.h"
#include "segcast/grey.h"

#include <sys/stat.h>

/* Labels are as volume.h promises: background, then rising values; names are UTF-8. */
static inline void fuzz_check_labels(const sc_volume *v)
{
    FUZZ_CHECK(v->label_count >= 1 && v->label_count <= SC_LABELS_MAX && v->labels[0].value == 0);
    for (int i = 0; i < v->label_count; i++) {
        const sc_label *label = &v->labels[i];
        const char *at = label->name;

        FUZZ_CHECK(memchr(label->name, 0, sizeof label->name));
        while (*at) {
            FUZZ_CHECK(sc_utf8_bytes(at));
            at += sc_utf8_bytes(at);
        }
        FUZZ_CHECK(label->opacity <= 1);
        FUZZ_CHECK(i < 2 || label->value > v->labels[i - 1].value);
    }
}

/* Read the header, the labels and the voxels of the volume @p path. What is read whole can
 * also be read in part, and what is read twice is the same. */
static inline void fuzz_read_volume(const char *path)
{
    SC_OWN(sc_volume_clear) sc_volume header = {0}, scan = {0};
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    const sc_status read_header =
        sc_volume_read_by(&fuzz_ctx, path, &(sc_read_choice){.depth = SC_READ_HEADER}, &header);
    const sc_status scanned =
        sc_volume_read_by(&fuzz_ctx, path, &(sc_read_choice){.depth = SC_READ_TALLIES}, &scan);
    const sc_status read = sc_volume_read(&fuzz_ctx, path, &volume);

    FUZZ_CHECK(read != SC_ERR_INTERNAL && read != SC_ERR_MEMORY);
    FUZZ_CHECK(read != SC_OK || (read_header == SC_OK && scanned == SC_OK));
    FUZZ_CHECK(scanned != SC_OK || read == SC_OK || read == SC_ERR_SYSTEM);
    if (read_header == SC_OK)
        fuzz_check_labels(&header);
    if (scanned == SC_OK)
        fuzz_check_labels(&scan);
    if (read == SC_OK) {
        const size_t voxels = sc_volume_voxels(&volume);

        fuzz_check_labels(&volume);
        FUZZ_CHECK(volume.label_count == scan.label_count);
        for (size_t i = 0; i < voxels; i++)
            FUZZ_CHECK((volume.label_bytes == 1
                            ? ((uint8_t *)volume.ids)[i]
                            : ((uint16_t *)volume.ids)[i]) < volume.label_count);
    }
}

/* Read the volume as a grey one: whatever holds labels without layers or masks holds numbers. */
static inline void fuzz_read_grey(const char *path)
{
    sc_grey grey;
    SC_OWN(sc_free_at) void *codes = NULL;
    sc_status read;

    if (sc_grey_read_header(&fuzz_ctx, path, &grey) != SC_OK ||
        sc_alloc(&fuzz_ctx, sc_grey_bytes(&grey), 1, &codes) != SC_OK)
        return;
    grey.codes = codes;
    read = sc_grey_read(&fuzz_ctx, path, NULL, &grey);
    FUZZ_CHECK(read != SC_ERR_INTERNAL && read != SC_ERR_MEMORY);
    FUZZ_CHECK(read != SC_OK || (isfinite(grey.low) && isfinite(grey.per_code)));
    FUZZ_CHECK(read != SC_OK || grey.per_code != 0);
}

/* The same of an input that is a file. */
static inline void fuzz_volume(const char *name, const uint8_t *data, size_t size)
{
    const char *path = fuzz_write(name, data, size);

    fuzz_read_volume(path);
    fuzz_read_grey(path);
}

/* Make the directories of an input that is one, in that of this process. */
static inline void fuzz_make_directories(const char *const *names, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const char *path = fuzz_path(names[i]);

        FUZZ_CHECK(!mkdir(path, 0777));
    }
}

/* Define a target whose inputs are files named @p input; beside them lie files of the names that
 * follow, which they may name for their voxels. */
#define FUZZ_VOLUME_TARGET(input, ...)                                                             \
    int LLVMFuzzerInitialize(int *argc, char ***argv)                                              \
    {                                                                                              \
        static const char *const beside[] = {__VA_ARGS__};                                         \
        static const uint8_t voxels[64] = {0, 1, 2, 3, 4};                                         \
                                                                                                   \
        (void)argc;                                                                                \
        (void)argv;                                                                                \
        for (size_t i = 0; i < SC_COUNT_OF(beside); i++)                                           \
            fuzz_write(beside[i], voxels, sizeof voxels);                                          \
        return 0;                                                                                  \
    }                                                                                              \
                                                                                                   \
    int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)                                   \
    {                                                                                              \
        fuzz_volume(input, data, size);                                                            \
        return 0;                                                                                  \
    }

#endif
