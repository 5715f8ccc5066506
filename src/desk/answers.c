/* SPDX-License-Identifier: BSD-3-Clause */
/* What all answers have in common: sizes that are asked for, messages, refusals. */
#include "desk.h"

/* The most a page may ask for: 8 K. */
enum { SIDE_LEAST_PX = 16, SIDE_MOST_PX = 7680 };

void sc_desk_refuse(sc_desk *desk, sc_call *call, const char *why)
{
    json_t *list = desk->notes.errors ? json_deep_copy(desk->notes.list) : json_pack("[s]", why);

    /* A mistake in a value is no failure of the server, of which browsers would complain. */
    sc_http_answer_json(call, 200, json_pack("{s:b, s:o}", "refused", 1, "notes", list));
}

int sc_desk_frame(const sc_desk *desk, const json_t *body)
{
    const json_t *frame = json_object_get(body, "frame");
    const json_int_t last = desk->sessions.now->job.animation.frames - 1,
                     k = json_integer_value(frame);

    return !json_is_integer(frame) ? desk->frame : (int)(k < 0 ? 0 : k > last ? last : k);
}

bool sc_desk_size(json_t *body, int out[2])
{
    json_int_t size[2];

    if (json_unpack(body, "{s:[I,I]}", "size", &size[0], &size[1]))
        return false;
    out[0] = size[0] <= SIDE_MOST_PX ? (int)size[0] : 0;
    out[1] = size[1] <= SIDE_MOST_PX ? (int)size[1] : 0;
    return out[0] >= SIDE_LEAST_PX && out[1] >= SIDE_LEAST_PX;
}

void sc_desk_note(void *user, sc_log_level level, const char *text)
{
    sc_notes *notes = user;

    if (level > SC_LOG_WARN || json_array_size(notes->list) >= SC_MISTAKES_MAX)
        return;
    if (level == SC_LOG_ERROR)
        notes->errors++;
    json_array_append_new(notes->list, json_string(text));
}
