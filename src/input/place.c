/* SPDX-License-Identifier: BSD-3-Clause */
/* Errors about a file that a job names begin with the place in the job that names it. */
#include "recipe.h"

/* For sc_ctx.write, with an sc_input_place as user. */
static void write_with_place(void *user, sc_log_level level, const char *text)
{
    const sc_input_place *place = user;

    if (level == SC_LOG_ERROR && place->where[0] &&
        !strncmp(text, place->path, strlen(place->path)))
        (void)sc_fail(place->to, SC_ERR_INTERNAL, "%s: %s", place->where, text);
    else if (place->to->write)
        place->to->write(place->to->user, level, text);
}

sc_ctx sc_ctx_of_input(const sc_ctx *to, const char *where, const char *path, sc_input_place *place)
{
    sc_ctx ctx = *to;

    *place = (sc_input_place){to, where, path};
    if (to->write) {
        ctx.rank = 0; /* that of @p to is told */
        ctx.write = write_with_place;
        ctx.user = place;
    }
    return ctx;
}
