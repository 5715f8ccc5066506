/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast plan --calibrate: measures what segcast plan cannot measure with a job, and keeps it. */
#include "plan/calibration.h"

#include <unistd.h>

enum {
    BLOCK_BYTES = 32 << 20, /* that are copied, sent and written at a time */
    COPIES = 8,
    NAPS = 400,
    PINGS = 300,
    SENDINGS = 8
};
#define NAP_S 0.25e-3 /* half of how long main threads of the farm sleep at most */

enum { TAG_PING = 1, TAG_BLOCK = 2 };

/* Fill a block with numbers that neither a file system nor a network can compress, and so that all
 * its pages are in memory: pages of zeros would be copied faster. */
static void fill(char *block)
{
    uint64_t state = 1;

    for (size_t at = 0; at < BLOCK_BYTES; at += sizeof state) {
        state = state * 6364136223846793005U + 1442695040888963407U;
        memcpy(block + at, &state, sizeof state);
    }
}

/* ---- this node ---- */

/* Measure naps and copies. @param block [BLOCK_BYTES], filled. */
static sc_status measure_node(const sc_ctx *ctx, char *block, sc_unit_costs *costs)
{
    SC_OWN(sc_free_at) void *copy = NULL;
    double begin_s, best_s = 1e9;

    SC_PASS(sc_alloc(ctx, BLOCK_BYTES, 1, &copy));
    for (int i = 0; i < COPIES; i++) {
        begin_s = sc_wall_s();
        block[i] = (char)i; /* so that no copy is the same as the one before */
        memcpy(copy, block, BLOCK_BYTES);
        best_s = sc_wall_s() - begin_s < best_s ? sc_wall_s() - begin_s : best_s;
    }
    costs->copy_bytes_per_s = BLOCK_BYTES / (best_s > 1e-6 ? best_s : 1e-6);
    begin_s = sc_wall_s();
    for (int i = 0; i < NAPS; i++)
        sc_sleep_s(NAP_S);
    costs->notice_s = (sc_wall_s() - begin_s) / NAPS;
    return SC_OK;
}

/* Measure writing, by way of a file in the directory of the calibration that never gets a name. */
static sc_status measure_file(const sc_ctx *ctx, const char *path, const char *block,
                              sc_unit_costs *costs)
{
    sc_outfile file = {0};
    const double begin_s = sc_wall_s();
    double wall_s;
    sc_status status = SC_OK;

    SC_PASS(sc_outfile_open(ctx, path, true, &file));
    if (fwrite(block, BLOCK_BYTES, 1, file.stream) != 1 || fflush(file.stream) != 0 ||
        fsync(fileno(file.stream)) != 0)
        status = sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written", path);
    wall_s = sc_wall_s() - begin_s;
    sc_outfile_discard(&file);
    costs->file_bytes_per_s = BLOCK_BYTES / (wall_s > 1e-6 ? wall_s : 1e-6);
    return status;
}

/* ---- messages, between rank 0 and the last one ---- */

/* Wait for a message without sleeping, and receive it. */
static void await(sc_comm *comm, void *data)
{
    sc_message mail;

    while (!sc_comm_poll(comm, &mail))
        (void)sc_comm_pending(comm);
    sc_comm_receive(comm, &mail, data);
}

/* Send @p count messages to and fro. @return the wall time of one way. */
static double exchange(sc_comm *comm, int tag, void *data, size_t bytes, int count)
{
    const int other = sc_comm_rank(comm) == 0 ? sc_comm_size(comm) - 1 : 0;
    const double begin_s = sc_wall_s();

    for (int i = 0; i < count; i++) {
        if (other > 0)
            sc_comm_post(comm, other, tag, data, bytes);
        else
            await(comm, data);
        sc_comm_flush(comm);
        if (other > 0)
            await(comm, data);
        else
            sc_comm_post(comm, other, tag, data, bytes);
    }
    sc_comm_flush(comm);
    return (sc_wall_s() - begin_s) / (2.0 * count);
}

/* Measure messages; the ranks between wait. Collective. @return SC_OK. */
static sc_status measure_messages(sc_comm *comm, char *block, sc_unit_costs *costs)
{
    const int rank = sc_comm_rank(comm), last = sc_comm_size(comm) - 1;

    if (last > 0 && (rank == 0 || rank == last)) {
        const double ping_s = exchange(comm, TAG_PING, block, 64, PINGS);
        const double block_s = exchange(comm, TAG_BLOCK, block, BLOCK_BYTES, SENDINGS);

        costs->messages_measured = true;
        costs->message_s = ping_s;
        if (sc_comm_node_count(comm) > 1) {
            costs->network_measured = true;
            costs->latency_s = ping_s;
            costs->link_bytes_per_s = BLOCK_BYTES / (block_s > 1e-6 ? block_s : 1e-6);
        }
    }
    return sc_comm_agree(comm, SC_OK);
}

/* ---- what is told ---- */

/* Print one number. @param measured false: it is assumed. */
static void print_row(const char *name, double value, const char *unit, bool measured)
{
    printf("%-28s %.3g %s%s\n", name, value, unit, measured ? "" : " (assumed)");
}

/* Print the costs. @return SC_ERR_MEMORY. */
static sc_status print_costs(const sc_ctx *ctx, const sc_unit_costs *c, bool as_json,
                             const char *path)
{
    json_t *json;

    if (!as_json) {
        print_row("copying in memory", c->copy_bytes_per_s / 1e9, "GB/s", true);
        print_row("writing to the cache", c->file_bytes_per_s / 1e9, "GB/s", true);
        print_row("until a sleeper notices", c->notice_s * 1e6, "us", true);
        print_row("a message", c->message_s * 1e6, "us", c->messages_measured);
        print_row("latency between nodes", c->latency_s * 1e6, "us", c->network_measured);
        print_row("bandwidth between nodes", c->link_bytes_per_s / 1e9, "GB/s",
                  c->network_measured);
        sc_print_made(path);
        return SC_OK;
    }
    json = json_pack("{s:s, s:f, s:f, s:f, s:f, s:f, s:f, s:b, s:b}", "schema",
                     "segcast-calibration-1", "copy_bytes_per_s", c->copy_bytes_per_s,
                     "file_bytes_per_s", c->file_bytes_per_s, "notice_s", c->notice_s, "message_s",
                     c->message_s, "latency_s", c->latency_s, "link_bytes_per_s",
                     c->link_bytes_per_s, "messages_measured", c->messages_measured,
                     "network_measured", c->network_measured);
    return sc_print_json(ctx, json, JSON_INDENT(1) | JSON_REAL_PRECISION(9), "calibration");
}

/* On rank 0: say what is wrong with a file that is there, make its directory, and measure what
 * needs no other rank; writing first, so that a directory which cannot be written to is told at
 * once. @param path receives the name of the file; the caller owns it. */
static sc_status begin(const sc_ctx *ctx, char *block, sc_unit_costs *costs, char **path)
{
    SC_PASS(sc_calibration_path(ctx, path));
    SC_PASS(sc_calibration_check(ctx, *path));
    *costs = sc_calibration_load(ctx); /* what is not measured now stays as it was measured once */
    SC_PASS(sc_calibration_make_directory(ctx, *path));
    SC_PASS(measure_file(ctx, *path, block, costs));
    return measure_node(ctx, block, costs);
}

sc_status sc_calibrate(sc_app *app)
{
    const sc_ctx *ctx = app->ctx;
    const bool is_root = sc_comm_rank(app->comm) == 0;
    sc_unit_costs costs = sc_unit_costs_assumed();
    SC_OWN(sc_free_at) void *block = NULL;
    SC_OWN(sc_free_at) char *path = NULL;
    sc_status status = sc_alloc(ctx, BLOCK_BYTES, 1, &block);

    if (status == SC_OK)
        fill(block);
    if (is_root && status == SC_OK)
        sc_stage_begin(ctx, "measuring", 0, 0);
    if (is_root && status == SC_OK)
        status = begin(ctx, block, &costs, &path);
    SC_PASS(sc_comm_agree(app->comm, status));
    SC_PASS(measure_messages(app->comm, block, &costs));
    if (is_root) {
        status = sc_calibration_save(ctx, &costs, path);
        sc_display_end_stage(app);
        if (status == SC_OK)
            status = print_costs(ctx, &costs, app->options.json, path);
    }
    return sc_comm_agree(app->comm, status);
}
