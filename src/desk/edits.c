/* SPDX-License-Identifier: BSD-3-Clause */
/* What pages have changed in the job: lists of keys with values, one for each step that can be
 * undone. */
#include "desk.h"

void sc_edits_clear(sc_edits *edits)
{
    for (size_t i = 0; i < edits->count; i++) {
        sc_free(edits->all[i].path);
        sc_free(edits->all[i].value);
    }
    sc_free(edits->all);
    *edits = (sc_edits){0};
}

/* Append a copy of a change. */
static sc_status append(const sc_ctx *ctx, sc_edits *edits, const char *path, const char *value)
{
    SC_OWN(sc_free_at) char *own_path = NULL;
    SC_OWN(sc_free_at) char *own_value = NULL;

    SC_PASS(sc_text_copy(ctx, path, &own_path));
    SC_PASS(sc_text_copy(ctx, value, &own_value));
    SC_PASS(SC_GROW(ctx, edits->count, &edits->room, &edits->all));
    edits->all[edits->count++] = (sc_edit){own_path, own_value};
    own_path = own_value = NULL;
    return SC_OK;
}

sc_status sc_edits_copy(const sc_ctx *ctx, const sc_edits *from, sc_edits *out)
{
    for (size_t i = 0; i < from->count; i++)
        SC_PASS(append(ctx, out, from->all[i].path, from->all[i].value));
    return SC_OK;
}

/* @return whether the key @p path is @p of, or a part of what that holds. */
static bool is_within(const char *path, const char *of)
{
    const size_t length = strlen(of);

    return !strncmp(path, of, length) && (!path[length] || strchr(".[", path[length]));
}

sc_status sc_edits_add(const sc_ctx *ctx, sc_edits *edits, const char *path, const char *value)
{
    size_t kept = 0;

    for (size_t i = 0; i < edits->count; i++) {
        if (is_within(edits->all[i].path, path)) {
            sc_free(edits->all[i].path);
            sc_free(edits->all[i].value);
        } else {
            edits->all[kept++] = edits->all[i];
        }
    }
    edits->count = kept;
    return value ? append(ctx, edits, path, value) : SC_OK;
}

/* ---- undo and redo ---- */

/* Put *from on a pile, of which the lowest is lost if it is full; *from is empty then. */
static void push(sc_edits *pile, int *count, sc_edits *from)
{
    if (*count == SC_STEPS_MAX) {
        sc_edits_clear(&pile[0]);
        memmove(pile, pile + 1, (SC_STEPS_MAX - 1) * sizeof *pile);
        --*count;
    }
    SC_HAND_OVER(*from, &pile[*count]);
    ++*count;
}

static void clear_pile(sc_edits *pile, int *count)
{
    while (*count > 0)
        sc_edits_clear(&pile[--*count]);
}

void sc_steps_clear(sc_steps *steps)
{
    sc_edits_clear(&steps->now);
    clear_pile(steps->undo, &steps->undo_count);
    clear_pile(steps->redo, &steps->redo_count);
}

void sc_steps_begin(sc_steps *steps, const char *group, sc_edits *next)
{
    if (steps->group[0] && !strcmp(steps->group, group) && steps->undo_count)
        sc_edits_clear(&steps->now); /* that before the step is on the pile */
    else
        push(steps->undo, &steps->undo_count, &steps->now);
    snprintf(steps->group, sizeof steps->group, "%s", group);
    clear_pile(steps->redo, &steps->redo_count);
    SC_HAND_OVER(*next, &steps->now);
}

bool sc_steps_go(sc_steps *steps, bool back)
{
    sc_edits *from = back ? steps->undo : steps->redo, *to = back ? steps->redo : steps->undo;
    int *from_count = back ? &steps->undo_count : &steps->redo_count;

    if (!*from_count)
        return false;
    push(to, back ? &steps->redo_count : &steps->undo_count, &steps->now);
    --*from_count;
    SC_HAND_OVER(from[*from_count], &steps->now);
    steps->group[0] = '\0';
    return true;
}
