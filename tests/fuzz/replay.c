/* SPDX-License-Identifier: BSD-3-Clause */
/* Runs a fuzz target over files, without libFuzzer: replay FILE|FOLDER... Each file, in the order
 * of the names, is one input. It ends with 1 if there are no files; a finding aborts, as under
 * libFuzzer. */
#include "fuzz.h"

#include <dirent.h>
#include <sys/stat.h>

/* Targets that need no preparation do not define it. */
#pragma weak LLVMFuzzerInitialize

/* Try the input in the file @p path, in a block without a byte behind its end. */
static void try_file(const char *path)
{
    char *text;
    size_t bytes;
    uint8_t *exact;

    FUZZ_CHECK(sc_file_read(&fuzz_ctx, path, (size_t)1 << 30, &text, &bytes) == SC_OK);
    exact = malloc(bytes ? bytes : 1);
    FUZZ_CHECK(exact);
    memcpy(exact, text, bytes);
    sc_free(text);
    printf("%s\n", path);
    fflush(stdout); /* before a crash */
    LLVMFuzzerTestOneInput(exact, bytes);
    free(exact);
}

/* Try the files in a folder, hidden ones excepted. @return how many there are. */
static int try_folder(const char *folder)
{
    struct dirent **entries;
    const int found = scandir(folder, &entries, NULL, alphasort);
    int tried = 0;

    FUZZ_CHECK(found >= 0);
    for (int i = 0; i < found; i++) {
        char path[4096];

        snprintf(path, sizeof path, "%s/%s", folder, entries[i]->d_name);
        if (entries[i]->d_name[0] != '.') {
            try_file(path);
            tried++;
        }
        free(entries[i]);
    }
    free(entries);
    return tried;
}

int main(int argc, char **argv)
{
    int tried = 0;

    if (LLVMFuzzerInitialize)
        LLVMFuzzerInitialize(&argc, &argv);
    for (int i = 1; i < argc; i++) {
        struct stat info;

        if (stat(argv[i], &info) == 0 && S_ISDIR(info.st_mode)) {
            tried += try_folder(argv[i]);
        } else {
            try_file(argv[i]);
            tried++;
        }
    }
    printf("%d inputs\n", tried);
    return tried == 0;
}
