/* SPDX-License-Identifier: BSD-3-Clause */
/* Saves the job: the text of its file, in which only the values of the keys that were changed are
 * others. */
#include "desk.h"

#include <unistd.h>

enum { FILE_MAX_BYTES = 1 << 20 };

/* @return a hash of the changes. */
static uint64_t hash_of(const sc_edits *edits)
{
    uint64_t hash = 0;

    for (size_t i = 0; i < edits->count; i++) {
        hash = sc_hash_bytes(edits->all[i].path, strlen(edits->all[i].path) + 1, hash);
        hash = sc_hash_bytes(edits->all[i].value, strlen(edits->all[i].value) + 1, hash);
    }
    return hash;
}

sc_status sc_desk_open_file(sc_desk *desk)
{
    SC_PASS(sc_text_copy(desk->outer, desk->plan->path, &desk->file.path));
    return desk->plan->is_new ? SC_OK
                              : sc_text_copy(desk->outer, desk->plan->text, &desk->file.on_disk);
}

bool sc_desk_is_unsaved(const sc_desk *desk)
{
    return !desk->file.on_disk || desk->file.saved != hash_of(&desk->steps.now);
}

/* @return whether a page may give the job this name: that of a job file in the same directory. */
static bool is_good_name(const char *name)
{
    const char *ending = strrchr(name, '.');

    for (const char *c = name; *c; c += sc_utf8_bytes(c)) {
        if (!sc_utf8_bytes(c) || *c == '/' || sc_is_control(sc_utf8_code(c, sc_utf8_bytes(c))))
            return false;
    }
    return name[0] != '.' && name[0] != '-' && strlen(name) <= 200 && ending &&
           (!strcmp(ending, ".yaml") || !strcmp(ending, ".yml"));
}

/* Make the path of the file: that of the job, or in its directory of @p name, NULL: its own. Caller
 * owns *out: sc_free. */
static sc_status find_path(const sc_desk *desk, const char *name, char **out)
{
    const char *path = desk->file.path;
    SC_OWN(sc_text_clear) sc_text text = {0};

    if (!name)
        return sc_text_copy(&desk->ctx, path, out);
    if (!is_good_name(name))
        return sc_fail(&desk->ctx, SC_ERR_USAGE,
                       "\"%s\" is no name for a job, expected one that ends in .yaml, without /",
                       name);
    SC_PASS(sc_text_add(&desk->ctx, &text, "%.*s%s", (int)(sc_file_name(path) - path), path, name));
    SC_HAND_OVER(text.data, out);
    return SC_OK;
}

/* Write the job that @p sources give to @p out, as it is resolved. */
static sc_status resolve(const sc_desk *desk, const sc_job_sources *sources, sc_text *out)
{
    SC_OWN(sc_job_clear) sc_job job = {0};

    SC_PASS(sc_job_load(&desk->ctx, sources, &job));
    return sc_job_write(&desk->ctx, &job, false, out);
}

/* Check that a text is the job that is looked at. @param from the text that the changes are made
 * in. */
static sc_status prove(const sc_desk *desk, const char *from, const sc_setting *settings,
                       const char *text)
{
    const sc_job_sources before = {.path = desk->file.path,
                                   .text = from,
                                   .settings = settings,
                                   .setting_count = desk->steps.now.count,
                                   .no_video = true};
    const sc_job_sources after = {.path = desk->file.path, .text = text, .no_video = true};
    SC_OWN(sc_text_clear) sc_text wanted = {0}, found = {0};

    SC_PASS(resolve(desk, &before, &wanted));
    SC_PASS(resolve(desk, &after, &found));
    return !strcmp(wanted.data, found.data) ? SC_OK
                                            : sc_fail(&desk->ctx, SC_ERR_INTERNAL,
                                                      "the changes cannot be written into this "
                                                      "file as it stands; nothing was saved");
}

/* Make the changes in the text of a job file. Caller owns *out: sc_free. */
static sc_status rewrite(const sc_desk *desk, const char *from, char **out)
{
    const sc_edits *edits = &desk->steps.now;
    SC_OWN(sc_free_at) sc_setting *settings = NULL;
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(SC_ALLOC(&desk->ctx, edits->count + 1, &settings));
    (void)sc_desk_sources(desk, edits, settings);
    SC_PASS(sc_text_add(&desk->ctx, &text, "%s", from));
    for (size_t i = 0; i < edits->count; i++) {
        sc_text next = {0};
        const sc_status status = sc_job_rewrite(&desk->ctx, text.data, &settings[i], &next);

        sc_text_clear(&text);
        text = next;
        SC_PASS(status);
    }
    SC_PASS(prove(desk, from, settings, text.data));
    SC_HAND_OVER(text.data, out);
    return SC_OK;
}

/* Read what stands in a file. @param out NULL: there is none. Caller owns: sc_free. */
static sc_status read_file(const sc_desk *desk, const char *path, char **out)
{
    size_t bytes;

    *out = NULL;
    return access(path, F_OK) ? SC_OK : sc_file_read(&desk->ctx, path, FILE_MAX_BYTES, out, &bytes);
}

/* A file is written: note it. */
static void note_saved(sc_desk *desk, char **path, char **text)
{
    sc_free(desk->file.path);
    sc_free(desk->file.on_disk);
    SC_HAND_OVER(*path, &desk->file.path);
    SC_HAND_OVER(*text, &desk->file.on_disk);
    desk->file.saved = hash_of(&desk->steps.now);
    desk->revision++;
}

/* Save, or answer with both texts if the file is another one than the page has seen. @param
 * confirm the hash of what it has seen; NULL: nothing. */
static sc_status save(sc_desk *desk, sc_call *call, const char *name, const char *confirm)
{
    SC_OWN(sc_free_at) char *path = NULL;
    SC_OWN(sc_free_at) char *there = NULL;
    SC_OWN(sc_free_at) char *text = NULL;
    char seen[24] = "";
    bool is_own;

    SC_PASS(find_path(desk, name, &path));
    SC_PASS(read_file(desk, path, &there));
    is_own = !strcmp(path, desk->file.path);
    /* Where somebody else has written into the file meanwhile, both changes are kept. */
    SC_PASS(rewrite(desk,
                    is_own && there && desk->file.on_disk && strcmp(there, desk->file.on_disk) != 0
                        ? there
                        : desk->plan->text,
                    &text));
    if (there)
        snprintf(seen, sizeof seen, "%016llx",
                 (unsigned long long)sc_hash_bytes(there, strlen(there),
                                                   sc_hash_bytes(text, strlen(text), 0)));
    if (there && strcmp(there, text) != 0 && (!confirm || strcmp(confirm, seen) != 0)) {
        sc_http_answer_json(call, 200,
                            json_pack("{s:s, s:s, s:s, s:s}", "path", path, "old", there, "new",
                                      text, "confirm", seen));
        return SC_OK;
    }
    SC_PASS(sc_file_write(&desk->ctx, path, text, strlen(text)));
    note_saved(desk, &path, &text);
    sc_http_answer_json(call, 200, json_pack("{s:s, s:b}", "path", desk->file.path, "saved", 1));
    return SC_OK;
}

void sc_desk_save(sc_desk *desk, sc_call *call)
{
    const json_t *body = call->body;

    json_array_clear(desk->notes.list);
    desk->notes.errors = 0;
    if (save(desk, call, json_string_value(json_object_get(body, "name")),
             json_string_value(json_object_get(body, "confirm"))) != SC_OK)
        sc_desk_refuse(desk, call, "the job could not be saved");
}
