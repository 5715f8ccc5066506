/* SPDX-License-Identifier: BSD-3-Clause */
/* Label tables that stand where other programs look for them: beside a volume of BIDS, and the
 * look-up table of FreeSurfer. */
#include "recipe.h"

#include <dirent.h>
#include <stdlib.h>
#include <sys/stat.h>

enum { LEVELS_MAX = 8 /* directories of a data set above a volume that are searched */ };

/* @return whether @p path is a regular file. */
static bool is_file(const char *path)
{
    struct stat info;

    return stat(path, &info) == 0 && S_ISREG(info.st_mode);
}

/* @return whether @p directory holds a regular file @p name. */
static bool holds(const char *directory, const char *name)
{
    char path[SC_PATH_BYTES];

    return snprintf(path, sizeof path, "%s/%s", directory, name) < (int)sizeof path &&
           is_file(path);
}

/* Count the words of @p name, which "_" separates, up to its first dot. @return 0 if there is one
 * that @p volume has not, or if the last one is not "dseg". */
static int matching_words(const char *name, const char *volume)
{
    const size_t end = strcspn(name, "."), volume_end = strcspn(volume, ".");
    int words = 0;

    for (size_t at = 0; at < end;) {
        const size_t length = strcspn(name + at, "_.");
        bool found = false;

        for (size_t from = 0; from < volume_end && !found;) {
            const size_t other = strcspn(volume + from, "_.");

            found = other == length && !strncmp(volume + from, name + at, length);
            from += other + 1;
        }
        if (!found || (at + length == end && strncmp(name + at, "dseg", length)))
            return 0;
        words++;
        at += length + 1;
    }
    return words;
}

/* Find the table in @p directory that fits a volume best: that with the most words in common, of
 * several the first by name. @param out [SC_PATH_BYTES]; empty if there is none. */
static void find_table(const char *directory, const char *volume, char *out)
{
    DIR *stream = opendir(directory);
    const struct dirent *entry;
    char best[256] = ""; /* no file system has longer names */
    int most = 0;

    *out = '\0';
    while (stream && (entry = readdir(stream))) {
        const size_t length = strlen(entry->d_name);
        int words;

        if (length < 8 || strcmp(entry->d_name + length - 8, "dseg.tsv") ||
            !holds(directory, entry->d_name))
            continue;
        words = matching_words(entry->d_name, volume);
        if (words > most || (words && words == most && strcmp(entry->d_name, best) < 0)) {
            most = words;
            snprintf(best, sizeof best, "%s", entry->d_name);
        }
    }
    if (stream)
        closedir(stream);
    if (most && snprintf(out, SC_PATH_BYTES, "%s/%s", directory, best) >= SC_PATH_BYTES)
        *out = '\0';
}

/* @return how many directories from the absolute path @p directory on upwards belong to its data
 * set of BIDS, whose uppermost one holds dataset_description.json; 1 if there is no data set. */
static int levels_of(const char *directory)
{
    char at[SC_PATH_BYTES];

    snprintf(at, sizeof at, "%s", directory);
    for (int level = 1; level <= LEVELS_MAX; level++) {
        char *slash = strrchr(at, '/');

        if (holds(at, "dataset_description.json"))
            return level;
        if (!slash || slash == at)
            break;
        *slash = '\0';
    }
    return 1;
}

/* Find the table of a volume of BIDS, in its directory or, by the inheritance principle, above it
 * in the data set; the nearest directory counts. @param directory of the volume, an absolute path,
 * which is cut. @param out [SC_PATH_BYTES]; empty if there is none. */
static void find_inherited(char *directory, const char *volume, char *out)
{
    for (int levels = levels_of(directory); levels > 0; levels--) {
        char *slash = strrchr(directory, '/');

        find_table(directory, volume, out);
        if (*out || !slash)
            return;
        *slash = '\0';
    }
}

/* Write the path of @p name in @p directory to out[SC_PATH_BYTES] if there is such a file; else out
 * is empty. @return whether there is. */
static bool find_file(const char *directory, const char *name, char *out)
{
    if (snprintf(out, SC_PATH_BYTES, "%s/%s", directory, name) < SC_PATH_BYTES && is_file(out))
        return true;
    *out = '\0';
    return false;
}

void sc_hint_labels(const sc_app *app, const char *path, const sc_volume *volume)
{
    const char *home = getenv("FREESURFER_HOME");
    char table[SC_PATH_BYTES] = "";

    if (sc_names_kind_of(volume->labels, volume->label_count) != SC_NAMES_BRAIN)
        return;
    if (home && *home)
        (void)find_file(home, "FreeSurferColorLUT.txt", table);
    sc_info(app->ctx,
            "%s: has the numbers of FreeSurfer, and no names; names and colours are in %s, "
            "which FreeSurfer installs: `labels: FILE` in a job, or --labels FILE",
            path, table[0] ? table : "FreeSurferColorLUT.txt");
}

void sc_find_labels(const sc_app *app, const char *volume, char *out)
{
    static const char *const bids[] = {"dseg.nii", "dseg.nii.gz"}, *const mgh[] = {".mgz", ".mgh"};
    const char *name = sc_file_name(volume);
    const char *home = getenv("FREESURFER_HOME");
    char directory[SC_PATH_BYTES] = ".", *whole;

    *out = '\0';
    if (name > volume)
        snprintf(directory, sizeof directory, "%.*s", (int)(name - volume) - (name - volume > 1),
                 volume);
    if (sc_stem_length(name, bids, SC_COUNT_OF(bids))) {
        whole = realpath(directory, NULL);
        if (whole && snprintf(directory, sizeof directory, "%s", whole) < (int)sizeof directory)
            find_inherited(directory, name, out);
        free(whole);
    } else if (sc_stem_length(name, mgh, SC_COUNT_OF(mgh))) {
        if (!find_file(directory, "FreeSurferColorLUT.txt", out) && home && *home)
            (void)find_file(home, "FreeSurferColorLUT.txt", out);
    }
    if (*out)
        sc_info(app->ctx,
                "%s: names and colours come from %s; `labels:` or --labels names another table",
                volume, out);
}
