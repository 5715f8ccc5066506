/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to commands: the sheet of segcast still. */
#ifndef SC_COMMANDS_STILL_H
#define SC_COMMANDS_STILL_H

#include "commands.h"

/* Draw small pictures of the frames that --sheet or --frames asks for on one sheet, write it to @p
 * path as PNG and print the path. @param job_path NULL: there is no job file, only settings.
 * Collective; @return the status of the command, with everything logged. */
sc_status sc_draw_sheet(sc_app *app, const char *job_path, const char *path);

#endif
