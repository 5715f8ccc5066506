/* SPDX-License-Identifier: BSD-3-Clause */
/* Completions of the command line for bash, zsh and fish, from the tables of commands, options and
 * keys. */
#include "segcast/cli.h"

/* Print a key that --set offers. Left out are keys in lists and of tissues, because a part of their
 * path is chosen by the user. For sc_job_each_key, with the stream as user. */
static sc_status print_key(void *user, const sc_key_info *info)
{
    if (info->is_value && !strstr(info->path, ".N.") && !strstr(info->path, ".NAME."))
        fprintf(user, " %s=", info->path);
    return SC_OK;
}

/* Print @p text in single quotes, as a shell reads it. */
static void print_quoted(FILE *stream, const char *text)
{
    fputc('\'', stream);
    for (; *text; text++)
        fputs(*text == '\'' ? "'\\''" : (char[2]){*text, '\0'}, stream);
    fputc('\'', stream);
}

/* Print the names of all commands, separated by spaces. */
static void print_command_names(const sc_command *commands, FILE *stream)
{
    for (const sc_command *c = commands; c->name; c++)
        fprintf(stream, "%s%s", c == commands ? "" : " ", c->name);
}

/* ---- bash, and zsh by way of its bash completion ---- */

/* Print a bash script. It completes the command, then options of that command or names of files,
 * and the keys after --set. */
static sc_status print_bash(const sc_ctx *ctx, const sc_command *commands, FILE *stream)
{
    fputs("# Completion of segcast for bash.\n_segcast_keys='", stream);
    SC_PASS(sc_job_each_key(ctx, print_key, stream));
    fputs("'\n_segcast() {\n    local word=${COMP_WORDS[COMP_CWORD]} "
          "previous=${COMP_WORDS[COMP_CWORD-1]}\n"
          "    local options=\n    COMPREPLY=()\n"
          "    if [ \"$COMP_CWORD\" = 1 ] || [ \"$previous\" = help ]; then\n"
          "        local more='--help --version'\n"
          "        [ \"$previous\" = help ] && more='keys cache'\n"
          "        COMPREPLY=($(compgen -W \"",
          stream);
    print_command_names(commands, stream);
    fputs(" $more\" -- \"$word\"))\n        return\n    fi\n"
          "    case $previous in\n    --set)\n"
          "        compopt -o nospace 2>/dev/null\n"
          "        COMPREPLY=($(compgen -W \"$_segcast_keys\" -- \"$word\"))\n        return ;;\n  "
          "  esac\n"
          "    case ${COMP_WORDS[1]} in\n",
          stream);
    for (const sc_command *c = commands; c->name; c++) {
        sc_option_list list;

        SC_PASS(sc_options_list(ctx, c, &list));
        fprintf(stream, "    %s) options='", c->name);
        for (size_t i = 0; i < list.count; i++)
            fprintf(stream, "%s--%s", i ? " " : "", list.rows[i].name);
        fputs("' ;;\n", stream);
    }
    fputs("    esac\n    case $word in\n"
          "    -*) COMPREPLY=($(compgen -W \"$options\" -- \"$word\")) ;;\n"
          "    *) COMPREPLY=($(compgen -f -- \"$word\")) ;;\n    esac\n}\n"
          "complete -o filenames -F _segcast segcast\n",
          stream);
    return SC_OK;
}

/* ---- zsh ---- */

/* Print text within a specification of zsh's _arguments, in single quotes: brackets, colons and
 * quotes are escaped. */
static void print_zsh_text(FILE *stream, const char *text)
{
    for (; *text; text++)
        fputs(strchr("[]:", *text) ? (char[3]){'\\', *text, '\0'}
              : *text == '\''      ? "'\\''"
                                   : (char[2]){*text, '\0'},
              stream);
}

/* Print a zsh script. It does the same as that for bash, and also shows the help of each command
 * and option. */
static sc_status print_zsh(const sc_ctx *ctx, const sc_command *commands, FILE *stream)
{
    fputs("#compdef segcast\n# Completion of segcast for zsh.\n_segcast_keys=(", stream);
    SC_PASS(sc_job_each_key(ctx, print_key, stream));
    fputs(" )\n_segcast() {\n    local -a commands=(\n", stream);
    for (const sc_command *c = commands; c->name; c++) {
        fprintf(stream, "        '%s:", c->name);
        print_zsh_text(stream, c->help);
        fputs("'\n", stream);
    }
    fputs("    )\n    if (( CURRENT == 2 )); then _describe command commands; return; fi\n"
          "    local command=$words[2]\n    shift words; (( CURRENT-- ))\n    case $command in\n",
          stream);
    for (const sc_command *c = commands; c->name; c++) {
        sc_option_list list;

        SC_PASS(sc_options_list(ctx, c, &list));
        fprintf(stream, "    %s) _arguments", c->name);
        for (size_t i = 0; i < list.count; i++) {
            const sc_option *row = &list.rows[i];

            fprintf(stream, " \\\n        '%s--%s%s[", strcmp(row->name, "set") ? "" : "*",
                    row->name, row->argument ? "=" : "");
            print_zsh_text(stream, row->help);
            fprintf(stream, "]%s%s%s'", row->argument ? ":" : "",
                    row->argument ? row->argument : "",
                    !row->argument                       ? ""
                    : !strcmp(row->name, "set")          ? ":compadd -S \"\" -a _segcast_keys"
                    : !strncmp(row->argument, "FILE", 4) ? ":_files"
                                                         : ": ");
        }
        fprintf(stream, " \\\n        '*:argument:%s' ;;\n",
                strcmp(c->name, "help") ? "_files" : "compadd keys cache ${commands%%:*}");
    }
    fputs("    esac\n}\n_segcast \"$@\"\n", stream);
    return SC_OK;
}

/* ---- fish ---- */

/* Print a fish script: a line for each command and for each of its options. */
static sc_status print_fish(const sc_ctx *ctx, const sc_command *commands, FILE *stream)
{
    fputs("# Completion of segcast for fish.\nset -g __segcast_keys", stream);
    SC_PASS(sc_job_each_key(ctx, print_key, stream));
    fputs("\n", stream);
    for (const sc_command *c = commands; c->name; c++) {
        sc_option_list list;

        fprintf(stream, "complete -c segcast -n '__fish_use_subcommand' -f -a %s -d ", c->name);
        print_quoted(stream, c->help);
        fputs("\n", stream);
        SC_PASS(sc_options_list(ctx, c, &list));
        for (size_t i = 0; i < list.count; i++) {
            const sc_option *row = &list.rows[i];

            fprintf(stream, "complete -c segcast -n '__fish_seen_subcommand_from %s' -l %s",
                    c->name, row->name);
            if (row->letter)
                fprintf(stream, " -s %c", row->letter);
            if (row->argument)
                fputs(strcmp(row->name, "set") ? " -r" : " -x -a '$__segcast_keys'", stream);
            fputs(" -d ", stream);
            print_quoted(stream, row->help);
            fputs("\n", stream);
        }
    }
    fputs("complete -c segcast -n '__fish_seen_subcommand_from help' -f -a '", stream);
    print_command_names(commands, stream);
    fputs(" keys cache'\n", stream);
    return SC_OK;
}

sc_status sc_print_completion(const sc_ctx *ctx, const sc_command *commands, const char *shell,
                              FILE *stream)
{
    if (!strcmp(shell, "bash"))
        return print_bash(ctx, commands, stream);
    return !strcmp(shell, "zsh") ? print_zsh(ctx, commands, stream)
                                 : print_fish(ctx, commands, stream);
}
