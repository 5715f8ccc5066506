/* SPDX-License-Identifier: BSD-3-Clause */
/* A label table in the format of another program. */
#include "commands.h"

#include "segcast/label_files.h"

/* Choose the format to be written, by --to or by the ending of the file. @return SC_ERR_USAGE. */
static sc_status choose_writer(const sc_app *app, const sc_table_writer **out)
{
    const char *names[16], *nearest;
    size_t count = 0;

    while (count < SC_COUNT_OF(names) && sc_table_writer_name(count)) {
        names[count] = sc_table_writer_name(count);
        count++;
    }
    *out = app->options.convert.to ? sc_table_writer_find(app->options.convert.to)
                                   : sc_table_writer_for(app->options.output);
    if (*out)
        return SC_OK;
    if (!app->options.convert.to)
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "%s: its ending does not tell what to write; the format of a label table "
                       "can be given as --to NAME, for example --to freesurfer (`segcast help "
                       "convert` lists formats and endings)",
                       app->options.output);
    nearest = sc_nearest_word(app->options.convert.to, names, count);
    return sc_fail(app->ctx, SC_ERR_USAGE, "--to is \"%s\"; %s%s%s", app->options.convert.to,
                   nearest ? "did you mean \"" : "`segcast help convert` lists the formats",
                   nearest ? nearest : "", nearest ? "\"?" : "");
}

sc_status sc_convert_table(sc_app *app)
{
    const sc_table_writer *writer;
    SC_OWN(sc_session_clear) sc_session session = {0};
    SC_OWN(sc_label_table_clear) sc_label_table table = {0};
    SC_OWN(sc_text_clear) sc_text text = {0};
    const bool to_stdout = !strcmp(app->options.output, "-");

    SC_PASS(choose_writer(app, &writer));
    SC_PASS(sc_options_set_text(app->ctx, &app->options, "volume", app->options.input));
    SC_PASS(sc_session_job(app, NULL, &session));
    if (!to_stdout)
        SC_PASS(
            sc_check_output(app, NULL, app->options.output, true)); /* other tables stay unread */
    SC_PASS(sc_read_label_table(app, app->options.input,
                                (sc_table_format)session.job.volume.labels_format, NULL, &table));
    SC_PASS(sc_label_table_print(app->ctx, to_stdout ? "standard output" : app->options.output,
                                 &table, writer, &text));
    return sc_write_text(app, &text, app->options.output);
}
