/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to commands: what segcast convert writes, each to app->options.output. All return the
 * status of the command, with everything logged. */
#ifndef SC_COMMANDS_CONVERT_H
#define SC_COMMANDS_CONVERT_H

#include "commands.h"

/* A label table in the format of another program. */
sc_status sc_convert_table(sc_app *app);
/* The centre line of a vessel. */
sc_status sc_convert_line(sc_app *app);
/* The built-in heart, or the phases of its beat. */
sc_status sc_convert_phantom(sc_app *app);
/* The prepared volume of the job file @p job; NULL: of app->options.input, which is a volume. */
sc_status sc_convert_prepared(sc_app *app, const char *job);

#endif
