/* SPDX-License-Identifier: BSD-3-Clause */
/* Help and the manual page, from the tables of commands, options, keys and exit codes. */
#include "segcast/cli.h"

void sc_print_help(const sc_command *commands, FILE *stream)
{
    fprintf(stream,
            "Usage: segcast COMMAND [ARGUMENT] [OPTION]...   alone, or under mpirun or srun\n\n"
            "Videos of segmented volumes, ray-cast on CPUs under MPI and OpenMP.\n\n");
    for (const sc_command *c = commands; c->name; c++)
        fprintf(stream, "%s%-8s %-7s %-23s  %s\n", c->group && c > commands ? "\n" : "",
                c->group ? c->group : "", c->name, c->argument, c->help);
    fprintf(
        stream,
        "\n`segcast orbit VOLUME` makes a first video, `segcast init VOLUME` a job to begin with.\n"
        "`segcast help COMMAND` explains a command and its options.\n\n"
        "Exit codes:\n");
    for (const sc_exit_code *row = sc_exit_codes; row->meaning; row++)
        fprintf(stream, "  %2d  %s\n", row->code, row->meaning);
}

/* Print @p text in lines of at most 88 characters. */
static void print_wrapped(FILE *stream, const char *text)
{
    enum { WIDTH = 88 };

    while (*text) {
        size_t length = strlen(text);

        if (length > WIDTH) {
            length = WIDTH;
            while (length > 0 && text[length] != ' ')
                length--;
        }
        fprintf(stream, "%.*s\n", (int)length, text);
        text += length;
        text += *text == ' ';
    }
}

sc_status sc_print_command_help(const sc_ctx *ctx, const sc_command *command, FILE *stream)
{
    sc_option_list list;

    SC_PASS(sc_options_list(ctx, command, &list));
    fprintf(stream, "Usage: segcast %s%s%s [OPTION]...\n\n%s\n", command->name,
            command->argument[0] ? " " : "", command->argument, command->help);
    if (command->details) {
        fputs("\n", stream);
        print_wrapped(stream, command->details);
    }
    fputs("\n", stream);
    for (size_t i = 0; i < list.count; i++) {
        const sc_option *row = &list.rows[i];
        char left[64];

        snprintf(left, sizeof left, "--%s%s%s", row->name, row->argument ? " " : "",
                 row->argument ? row->argument : "");
        fprintf(stream, "  %c%c%c %-26s %s\n", row->letter ? '-' : ' ',
                row->letter ? row->letter : ' ', row->letter ? ',' : ' ', left, row->help);
    }
    return SC_OK;
}

/* ---- segcast(1) ---- */

/* Print text for roff: backslashes are escaped, and hyphens become minus signs, as options need. */
static void print_roff(FILE *stream, const char *text)
{
    for (; *text; text++)
        fprintf(stream, *text == '-' ? "\\-" : *text == '\\' ? "\\e" : "%c", *text);
}

/* Print an option as an item of a roff list, with its help and the key that it sets. */
static void print_option_roff(FILE *stream, const sc_option *row)
{
    fputs(".TP\n", stream);
    if (row->letter)
        fprintf(stream, "\\fB\\-%c\\fR, ", row->letter);
    fputs("\\fB\\-\\-", stream);
    print_roff(stream, row->name);
    fputs("\\fR", stream);
    if (row->argument)
        fprintf(stream, " \\fI%s\\fR", row->argument);
    fputs("\n", stream);
    print_roff(stream, row->help);
    if (row->key[0])
        fprintf(stream, " (key \\fB%s\\fR)", row->key);
    fputs("\n", stream);
}

sc_status sc_print_manual(const sc_ctx *ctx, const sc_command *commands, FILE *stream)
{
    fprintf(stream,
            ".TH SEGCAST 1 \"\" \"segcast %s\" \"User commands\"\n.SH NAME\n"
            "segcast \\- videos of segmented volumes, ray\\-cast on CPUs\n.SH SYNOPSIS\n"
            ".B segcast\n.I COMMAND\n[\\fIARGUMENT\\fR] [\\fIOPTION\\fR]...\n.SH DESCRIPTION\n"
            "Every command runs alone. Under mpirun or srun all ranks work in ",
            sc_version());
    for (const sc_command *c = commands; c->name; c++) {
        if (c->by_all)
            fprintf(stream, "%s, ", c->name);
    }
    fputs("and plan \\-\\-calibrate, and one of them in the other commands. Results go to\n"
          "standard output, messages to standard error. Keys of a job file are described in\n"
          "segcast\\-job(5).\n.SH COMMANDS\n",
          stream);
    for (const sc_command *c = commands; c->name; c++) {
        sc_option_list list;

        SC_PASS(sc_options_list(ctx, c, &list));
        fprintf(stream, ".SS segcast %s %s\n", c->name, c->argument);
        print_roff(stream, c->help);
        fputs(".\n", stream);
        if (c->details)
            print_roff(stream, c->details);
        fputs("\n", stream);
        for (size_t i = 0; i < list.count; i++)
            print_option_roff(stream, &list.rows[i]);
    }
    fputs(".SH EXIT STATUS\n", stream);
    for (const sc_exit_code *row = sc_exit_codes; row->meaning; row++)
        fprintf(stream, ".TP\n%d\n%s\n", row->code, row->meaning);
    fputs(".SH ENVIRONMENT\n.TP\nSEGCAST_THREADS\nthreads of each "
          "rank\n.TP\nSEGCAST_MAX_MEMORY\nas \\-\\-max\\-memory\n"
          ".TP\nSEGCAST_MPI\nyes: start MPI; no: work alone; auto: as the launcher\\(aqs variables "
          "say\n"
          ".TP\nSEGCAST_CACHE\nthe directory in which prepared volumes are kept for the next "
          "command, or off\n"
          ".TP\nSEGCAST_\\fIKEY\\fR\n"
          "any key of a job file, for example SEGCAST_RENDER_QUALITY=still\n.SH SEE ALSO\n"
          "segcast\\-job(5)\n",
          stream);
    return SC_OK;
}
