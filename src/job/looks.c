/* SPDX-License-Identifier: BSD-3-Clause */
/* The looks: named sets of values for keys that a job does not give itself. */
#include "key.h"
#include "segcast/job.h"

/* A look, as a part of a job file. A rule for tissues has the glob of all tissues that is least
 * likely to be in the job, too, where a later entry would have to win over earlier ones; those
 * without a name are meant, too. The values were chosen by eye, on hearts, bodies and brains. */
static const struct {
    const char *name;
    const char *job;
} looks[] = {
    /* White paper, a large soft lamp, and enough sky that no side is dark. */
    {"studio", "light: {method: global, ambient: 0.5, key: 0.7, head: 0.12}"},
    /* Night, and a lamp whose shadows tell the shape. */
    {"cinematic", "light: {method: global, ambient: 0.28, key: 1, head: 0.04}\n"
                  "render: {background: '#14161a'}\n"
                  "tissues: {'**': {specular: 0.2, roughness: 0.424}}"},
    /* An overcast sky, without highlights: colours are those of the table nearly everywhere. */
    {"atlas", "light: {method: global, ambient: 0.95, key: 0, head: 0.2}\n"
              "render: {background: white, cap_outline: 0.3}\n"
              "tissues: {'**': {specular: 0}}"},
    /* Veils whose outlines are dense, as those of a radiograph. */
    {"xray", "light: {method: flat, edges: 1}\n"
             "render: {background: '#05070a'}\n"
             "tissues: {'**': {opacity: 0.08}}"},
};

/* @return the part of a job of the look that a tree names; NULL: it names none of these. */
static const char *find_look(const sc_yaml *root)
{
    const sc_yaml *node = sc_yaml_member(root, "look");

    for (size_t i = 0; node && node->kind == SC_YAML_SCALAR && i < SC_COUNT_OF(looks); i++) {
        if (!strcmp(node->text, looks[i].name))
            return looks[i].job;
    }
    return NULL;
}

sc_status sc_look_apply(const sc_ctx *ctx, sc_yaml *root)
{
    const char *job = find_look(root);
    SC_OWN(sc_yaml_free_at) sc_yaml *tree = NULL;
    sc_yaml *own = NULL, look;

    if (!job)
        return SC_OK;
    SC_PASS(sc_yaml_parse(ctx, "look", job, strlen(job), &tree));
    SC_PASS(sc_yaml_copy(ctx, root, &own));
    SC_PASS(sc_settings_merge(ctx, sc_job_keys, tree, own));
    /* What both hold changes place; the root stays where its owner has it. */
    look = *tree;
    *tree = *root;
    *root = look;
    return SC_OK;
}
