/* SPDX-License-Identifier: BSD-3-Clause */
/* The options of all commands in one table, and those that stand in the job's table of keys. */
#include "option_values.h"

#define JOB_COMMANDS "render check plan still orbit"
#define AT(member) offsetof(sc_options, member)

/* A row of an option without a value, and one of --output. */
#define FLAG(name, letter, member, help, commands)                                                 \
    {                                                                                              \
        name, letter, NULL, help, commands, sc_store_flag, AT(member), ""                          \
    }
#define OUTPUT(argument, help, commands)                                                           \
    {                                                                                              \
        "output", 'o', argument, help, commands, sc_store_output, AT(output), ""                   \
    }

static const sc_option option_rows[] = {
    OUTPUT("DIR", "directory for everything the job makes", "render"),
    OUTPUT("DIR", "the directory that render is to write to: it is checked, too", "check"),
    OUTPUT("DIR", "directory for what the study measures (segcast-study)", "study"),
    OUTPUT("FILE.html", "the page that compares several directories (comparison.html)", "report"),
    OUTPUT("FILE.png", "the picture to write (still.png)", "still"),
    OUTPUT("FILE", "the video to write (orbit.mp4): .mp4, .mkv, .webm, .mov, .webp or .gif",
           "orbit"),
    OUTPUT("FILE.yaml", "the job to write (named like the volume); - for standard output", "init"),
    OUTPUT("FILE", "the file to write; - for standard output", "convert"),
    {"frames", 0, "LIST", "only these frames of the animation, for example 0-35:2,40", "render",
     sc_store_frames, AT(part.frames), ""},
    {"frames", 0, "LIST", "draw these frames on a sheet, for example 0-35:2,40", "still",
     sc_store_frames, AT(part.frames), ""},
    FLAG("resume", 0, resume, "go on with what the directory holds of this job, after verifying it",
         "render"),
    FLAG("overwrite", 0, overwrite, "begin anew in a directory that holds a run", "render"),
    FLAG("overwrite", 0, overwrite, "replace the file if there is one",
         "still orbit report convert"),
    FLAG("resume", 0, resume, "go on with the measurements that the directory holds of this study",
         "study"),
    FLAG("overwrite", 0, overwrite, "begin anew in a directory that holds a study", "study"),
    {"time-limit", 0, "HH:MM:SS",
     "stop in order before so much time has passed since the start, with exit code 75",
     "render study", sc_store_time_limit, 0, ""},
    {"slice", 0, "I/N", "only part I of N, counted from 0: for job arrays that share the directory",
     "render", sc_store_slice, 0, ""},
    {"frame", 0, "K", "number of the frame to draw", "still", sc_store_frame, 0, ""},
    {"time", 0, "T",
     "draw the frame at this time: seconds, MM:SS, or a share of the film such as 50%", "still",
     sc_store_moment, 0, ""},
    {"sheet", 0, "N|views|looks|slices",
     "draw N frames, from the first to the last, on one sheet; views: the six sides and four "
     "obliques instead, each with the --view that gets it; looks: one picture in each look; "
     "slices: the three regular slices beside the picture",
     "still", sc_store_sheet, 0, ""},
    {"view", 0, "WORD|DEG,DEG",
     "where the camera stands, at the beginning of a turn: anterior (or ventral, front), posterior "
     "(dorsal, back), left, right, superior (cranial, top), inferior (caudal, bottom), x, -x, y "
     "..., or an angle around the patient, 0 in front and 90 at the left, and one above, such as "
     "30,15",
     "orbit still", sc_store_view, 0, ""},
    {"tissue", 0, "NAME",
     "let this tissue of a volume fill the picture, the others nearly transparent: a name, a glob "
     "or a label number",
     "orbit still", sc_store_framed, 0, ""},
    {"set", 0, "KEY.PATH=VALUE",
     "set a key of the job, such as render.quality=still; may be repeated",
     JOB_COMMANDS " convert study info", sc_store_set, 0, ""},
    {"beating", 0, "N",
     "of the phantom: write N phases of its beat, files with -00, -01 ... before their ending, "
     "from the end of diastole on; to a name that ends in .seq.nrrd all in one file (4-D)",
     "convert", sc_store_count, AT(convert.beating), ""},
    FLAG("ct", 0, convert.ct, "of the phantom: write its synthetic CT image instead of the labels",
         "convert"),
    {"to", 0, "NAME",
     "format of the table: slicer, freesurfer, itksnap, xml, csv, bids, json, neuroglancer, gifti, "
     "workbench, names, nnunet or ome-zarr; of a centre line: csv or json (default: by the ending "
     "of the file)",
     "convert", sc_store_text, AT(convert.to), ""},
    {"tissue", 0, "NAME[,NAME]",
     "of a mesh: write only these tissues; else the centre line through them: names, globs or "
     "label numbers",
     "convert", sc_store_text, AT(convert.tissue), ""},
    {"simplify", 0, "MM",
     "of a mesh: leave out triangles, up to this error in mm, a mean: the surface moves by a third "
     "of it on average, at some places by more, and stays where tissues meet",
     "convert", sc_store_text, AT(convert.simplify), ""},
    {"begin", 0, "X,Y,Z", "where the line begins, in RAS mm (default: at the end of the tissue)",
     "convert", sc_store_text, AT(convert.begin), ""},
    {"end", 0, "X,Y,Z", "where it ends (default: as far as possible from where it begins)",
     "convert", sc_store_text, AT(convert.end), ""},
    FLAG("middles", 0, convert.middles,
         "lead from the middle of the first tissue to that of the next, up to that of the last",
         "convert"),
    FLAG("fast", 0, check.fast, "read only the header of the volume, not its voxels", "check"),
    FLAG("expand", 0, check.expand,
         "print the job with all its keys, and verbs as the key frames that they stand for where "
         "frames stay the same to the last bit",
         "check"),
    {"nodes", 0, "N",
     "number of nodes like this one to estimate for (1, 4 and 16, and a table up to 64)", "plan",
     sc_store_count, AT(plan.nodes), ""},
    {"ranks", 0, "N", "ranks on each node (1), of --threads N, or else of a thread for each core",
     "plan", sc_store_count, AT(plan.ranks), ""},
    FLAG("calibrate", 0, plan.calibrate,
         "take no job, but measure what plans need to know of this machine, and keep it", "plan"),
    {"port", 0, "N", "port of the address (default: one that is free)", "desk", sc_store_count,
     AT(desk.port), ""},
    {"listen", 0, "ADDRESS",
     "address of this machine at which others can connect, too, or unix:PATH, a socket that only "
     "you can use (default: 127.0.0.1, where all of this machine can)",
     "desk", sc_store_text, AT(desk.listen), ""},
    {"idle", 0, "MINUTES", "end when nobody has done anything for so long", "desk", sc_store_count,
     AT(desk.idle_min), ""},
    FLAG("json", 0, json, "as JSON, for machines", "info plan status"),
    FLAG("json", 0, json, "keys: as JSON, for machines", "help"),
    FLAG("markdown", 0, help.markdown, "keys: as Markdown, which docs/job.md is", "help"),
    FLAG("markdown", 0, help.markdown, "print the tables of a study in Markdown, and make no page",
         "report"),
    FLAG("schema", 0, help.schema,
         "keys: as a JSON schema, with which editors complete and check job files", "help"),
    FLAG("study-schema", 0, help.study, "keys: as a JSON schema of study files", "help"),
    FLAG("clear", 0, help.clear, "cache: remove the prepared volumes that are kept", "help"),
    FLAG("man", 0, help.man, "everything as a manual page: segcast(1); keys: segcast-job(5)",
         "help"),
    FLAG("bash", 0, help.bash, "completions of the command line for bash", "help"),
    FLAG("zsh", 0, help.zsh, "completions for zsh", "help"),
    FLAG("fish", 0, help.fish, "completions for fish", "help"),
    {"threads", 0, "N",
     "threads of each rank (also SEGCAST_THREADS; default: OMP_NUM_THREADS, or one for each core)",
     JOB_COMMANDS " desk info init convert join verify study", sc_store_threads, 0, ""},
    {"max-memory", 0, "SIZE",
     "refuse volumes that take more memory, for example 8G (also SEGCAST_MAX_MEMORY; default: what "
     "the machine has)",
     JOB_COMMANDS " desk info convert study", sc_store_max_memory, 0, ""},
    FLAG("quiet", 'q', quiet, "errors and warnings only",
         JOB_COMMANDS " desk info init convert join verify status study report"),
    FLAG("help", 'h', help.help, "explain the command and its options", NULL),
    FLAG("version", 'V', help.version, "print version, commit, compiler and libraries", NULL),
};

/* Is @p command one of the names in @p commands, which spaces separate? */
static bool names_command(const char *commands, const char *command)
{
    const size_t length = strlen(command);

    for (; commands; commands = strchr(commands, ' ')) {
        commands += *commands == ' ';
        if (!strncmp(commands, command, length) &&
            (commands[length] == '\0' || commands[length] == ' '))
            return true;
    }
    return false;
}

bool sc_command_has_threads(const sc_command *command)
{
    for (size_t i = 0; i < SC_COUNT_OF(option_rows); i++) {
        if (!strcmp(option_rows[i].name, "threads"))
            return names_command(option_rows[i].commands, command->name);
    }
    return false;
}

/* Lists the options of a command. */
typedef struct lister {
    const sc_ctx *ctx;
    const char *name;     /* of the command */
    sc_option_list *list; /* rows are appended here, unless an option of that name is there */
} lister;

static sc_status add_row(const lister *l, const sc_option *row)
{
    for (size_t i = 0; i < l->list->count; i++) {
        if (!strcmp(l->list->rows[i].name, row->name))
            return SC_OK;
    }
    if (l->list->count == SC_OPTIONS_MAX)
        return sc_fail(l->ctx, SC_ERR_INTERNAL, "a command has more than %d options",
                       SC_OPTIONS_MAX);
    l->list->rows[l->list->count++] = *row;
    return SC_OK;
}

/* Append the option of a key to the list, if the command has it. For sc_job_each_key, with a lister
 * as user. */
static sc_status add_key(void *user, const sc_key_info *info)
{
    const lister *l = user;
    sc_option row = {.name = info->option,
                     .argument = info->argument,
                     .help = info->help,
                     .commands = info->commands,
                     .store = sc_store_key};

    if (!info->option || !names_command(info->commands, l->name))
        return SC_OK;
    if (strlen(info->path) >= sizeof row.key)
        return sc_fail(l->ctx, SC_ERR_INTERNAL, "the key %s is too long for an option", info->path);
    strcpy(row.key, info->path);
    return add_row(l, &row);
}

sc_status sc_options_list_more(const sc_ctx *ctx, const char *command, sc_option_list *list)
{
    lister l = {.ctx = ctx, .name = command, .list = list};

    SC_PASS(sc_job_each_key(ctx, add_key, &l));
    for (size_t i = 0; i < SC_COUNT_OF(option_rows); i++) {
        if (!option_rows[i].commands || names_command(option_rows[i].commands, command))
            SC_PASS(add_row(&l, &option_rows[i]));
    }
    return SC_OK;
}

sc_status sc_options_list(const sc_ctx *ctx, const sc_command *command, sc_option_list *out)
{
    out->count = 0;
    return sc_options_list_more(ctx, command->name, out);
}

static void add_owners(sc_option_owners *o, const char *option, const char *commands)
{
    char *end = o->commands + strlen(o->commands);

    if (option && commands && !strcmp(option, o->option))
        snprintf(end, (size_t)(o->commands + sizeof o->commands - end), "%s%s",
                 o->commands[0] ? " " : "", commands);
}

/* Add the commands that have the option of a key. For sc_job_each_key, with sc_option_owners as
 * user. */
static sc_status add_owners_of_key(void *user, const sc_key_info *info)
{
    add_owners(user, info->option, info->commands);
    return SC_OK;
}

sc_status sc_options_find_owners(const sc_ctx *ctx, const char *option, sc_option_owners *out)
{
    *out = (sc_option_owners){.option = option};
    for (size_t i = 0; i < SC_COUNT_OF(option_rows); i++)
        add_owners(out, option_rows[i].name, option_rows[i].commands);
    return sc_job_each_key(ctx, add_owners_of_key, out);
}
