/* SPDX-License-Identifier: BSD-3-Clause */
/* Measures how many frames a second rank 0 can hand out and collect, without a renderer.
 *
 *   farm_load simulate WORKERS RATE FRAMES
 *       rank 0 with simulated worker ranks that together finish RATE frames a second
 *   mpirun -n N farm_load ranks FRAMES
 *       real ranks that draw nothing, as fast as they can
 *   mpirun -n N farm_load compare FRAMES MEAN_S MESSAGE_S NOTICE_S
 *       real ranks that sleep instead of drawing, MEAN_S for a frame in the mean, and what
 *       sc_simulate tells for them; MESSAGE_S and NOTICE_S as in sc_sim_machine
 *
 * Frames have 320 x 180 pixels. Prints frames per second, and the share of one core that the main
 * thread of rank 0 needs. */
#include "../../src/comm/comm_ops.h"
#include "../../src/farm/internal.h"
#include "events.h"
#include "segcast/simulate.h"

#include <stdlib.h>
#include <string.h>

enum { WIDTH_PX = 320, HEIGHT_PX = 180 };

/* ---- a communicator whose worker ranks are simulated ---- */

/* Rank 0 of a communicator whose other ranks are simulated. The farm sees only base. */
typedef struct sim_comm {
    sc_comm base;
    double draw_s;   /* of a frame on a worker rank */
    events mail;     /* what the simulated ranks will send, and when */
    uint8_t *pixels; /* of a frame: [HEIGHT_PX][WIDTH_PX][3], the same for all */
} sim_comm;

/* All simulated ranks agree with rank 0. */
static sc_status sim_agree(sc_comm *comm, sc_status mine)
{
    return mine;
}

/* Take a work unit that rank 0 hands to rank @p target: when it is drawn, draw_s from now, its
 * result arrives, and the rank asks for the next. A unit of kind SC_UNIT_NONE is answered at
 * once with a farewell. */
static void sim_post(sc_comm *comm, int target, int tag, const void *data, size_t bytes)
{
    sim_comm *c = (sim_comm *)comm;
    const double now_s = sc_wall_s();
    sc_work_unit unit;

    memcpy(&unit, data, bytes);
    if (unit.kind == SC_UNIT_NONE) {
        push_event(&c->mail, (event){now_s, target, SC_TAG_BYE, unit});
        return;
    }
    push_event(&c->mail, (event){now_s + c->draw_s, target, SC_TAG_RESULT, unit});
    push_event(&c->mail, (event){now_s + c->draw_s, target, SC_TAG_READY, unit});
}

/* Messages are delivered at once: none is ever pending. */
static int sim_pending(sc_comm *comm)
{
    return 0;
}

static void sim_flush(sc_comm *comm)
{
}

/* Describe the earliest message in @p out, if it is due by now; it stays until sim_receive
 * fetches it. */
static bool sim_poll(sc_comm *comm, sc_message *out)
{
    const sim_comm *c = (const sim_comm *)comm;
    const event *m = &c->mail.heap[0];

    if (c->mail.count == 0 || m->time_s > sc_wall_s())
        return false;
    *out = (sc_message){m->rank, m->tag, sizeof(int32_t)};
    if (m->tag == SC_TAG_RESULT)
        out->bytes = sizeof(sc_result_message) + (size_t)m->unit.rows * WIDTH_PX * 3;
    return true;
}

/* Fetch the message that sim_poll has described and write its contents, message->bytes, to @p
 * data: a result with its pixels, or zeros. */
static void sim_receive(sc_comm *comm, const sc_message *message, void *data)
{
    sim_comm *c = (sim_comm *)comm;
    const event m = pop_event(&c->mail);
    const sc_result_message done = {.unit = m.unit, .result = {.rank = m.rank}};

    if (m.tag != SC_TAG_RESULT) {
        memset(data, 0, message->bytes);
        return;
    }
    memcpy(data, &done, sizeof done);
    memcpy((char *)data + sizeof done, c->pixels, message->bytes - sizeof done);
}

/* Worker ranks are on other nodes: no memory is shared with them, so that their pixels arrive as
 * messages. */
static sc_status sim_share(const sc_ctx *ctx, sc_comm *comm, size_t bytes, const char *folder,
                           sc_shared **out)
{
    return sc_fail(ctx, SC_ERR_MEMORY, "nothing is shared");
}

static const sc_comm_ops sim_ops = {.agree = sim_agree,
                                    .share = sim_share,
                                    .post = sim_post,
                                    .pending = sim_pending,
                                    .flush = sim_flush,
                                    .poll = sim_poll,
                                    .receive = sim_receive};

/* ---- the farm ---- */

/* What the callbacks of the farm get as user. */
typedef struct load {
    double draw_s;    /* that drawing a frame takes in the mean; 0: no time */
    bool varied;      /* frames take between half of that and half as much again */
    atomic_int units; /* work units drawn on this rank */
    double farm_s;    /* result: how long the farm took */
    int accepted;     /* frames that have reached rank 0 */
    atomic_int stop;  /* for the farm; never set */
} load;

/* @return what drawing a frame takes in seconds. */
static double frame_s(const load *l, int frame)
{
    return l->varied ? l->draw_s * (0.5 + (frame * 7919L % 1000 + 0.5) / 1000) : l->draw_s;
}

/* Draw nothing: sleep as long as drawing would take. See sc_farm_calls.draw. */
static sc_status draw(void *user, int frame, int row, int rows, sc_image *image,
                      sc_frame_result *result)
{
    load *l = user;

    l->units++;
    if (l->draw_s > 0)
        sc_sleep_s(frame_s(l, frame) * rows / HEIGHT_PX);
    return SC_OK;
}

/* Count the frame. See sc_farm_calls.accept_frame. */
static sc_status accept_frame(void *user, const sc_frame_result *result, const sc_image *image)
{
    ((load *)user)->accepted++;
    return SC_OK;
}

/* Run a farm of @p frames frames over @p comm and print on rank 0 what it took. @return an exit
 * code: 1 if the farm failed or rank 0 has not got all frames. */
static int run(sc_comm *comm, load *l, int frames)
{
    const sc_ctx ctx = {.level = SC_LOG_INFO, .write = sc_log_to_stderr};
    sc_farm farm = {.width_px = WIDTH_PX,
                    .height_px = HEIGHT_PX,
                    .partition = SC_PARTITION_FRAMES,
                    .frame_count = frames,
                    .share_frames = l->varied,
                    .calls.draw = draw,
                    .calls.accept_frame = accept_frame,
                    .stop = &l->stop,
                    .calls.user = l};
    int *numbers = malloc((size_t)frames * sizeof *numbers);
    sc_farm_times times;
    sc_status status;

    for (int k = 0; k < frames; k++)
        numbers[k] = k;
    farm.frames = numbers;
    status = sc_farm_run(&ctx, comm, &farm, &times);
    if (sc_comm_rank(comm) == 0)
        printf("%d ranks: %d frames in %.2f s, %.0f a second; rank 0: %.1f %% of a core\n",
               sc_comm_size(comm), l->accepted, times.wall_s, l->accepted / times.wall_s,
               100 * times.gather_cpu_s / times.wall_s);
    free(numbers);
    l->farm_s = times.wall_s;
    return status == SC_OK && (sc_comm_rank(comm) > 0 || l->accepted == frames) ? 0 : 1;
}

/* Run the farm on rank 0 alone with simulated worker ranks that together finish @p rate frames a
 * second. @return an exit code. */
static int simulate(int workers, double rate, int frames)
{
    load l = {.draw_s = workers / rate};
    sim_comm c = {.base = {.ops = &sim_ops, .size = workers + 1, .node_count = 1},
                  .draw_s = l.draw_s,
                  .mail.heap = malloc(((size_t)workers * 4 + 16) * sizeof(event)),
                  .pixels = calloc((size_t)WIDTH_PX * HEIGHT_PX, 3)};
    int code;

    for (int rank = 1; rank <= workers;
         rank++) /* the first results are spread over the time of a frame */
        push_event(&c.mail,
                   (event){sc_wall_s() + l.draw_s * rank / workers, rank, SC_TAG_READY, {0}});
    code = run(&c.base, &l, frames);
    free(c.mail.heap);
    free(c.pixels);
    return code;
}

/* Run the farm with sleeping ranks, simulate it, and print both on rank 0. @return an exit code: 1
 * if the farm or the simulation failed, or not every frame was drawn once. */
static int compare(sc_comm *comm, int frames, double mean_s, double message_s, double notice_s)
{
    const sc_ctx ctx = {.level = SC_LOG_INFO, .write = sc_log_to_stderr};
    const int ranks = sc_comm_size(comm);
    load l = {.draw_s = mean_s, .varied = true};
    double *costs = malloc((size_t)frames * sizeof *costs);
    int *units = NULL, mine, drawn = 0;
    const sc_sim_film film = {.frames = frames,
                              .gop_frames = 1,
                              .width_px = WIDTH_PX,
                              .height_px = HEIGHT_PX,
                              .partition = SC_PARTITION_FRAMES,
                              .draw_cpu_s = costs};
    const sc_sim_machine machine = {.ranks = ranks,
                                    .ranks_per_node = ranks,
                                    .threads = 1,
                                    .message_s = message_s,
                                    .notice_s = notice_s,
                                    .slow_node = -1};
    sc_sim_result predicted;
    int code = run(comm, &l, frames);

    mine = l.units;
    code |= sc_comm_gather(&ctx, comm, &mine, sizeof mine, &units) != SC_OK;
    for (int k = 0; k < frames; k++)
        costs[k] = frame_s(&l, k);
    if (units) {
        code |= sc_simulate(&ctx, &film, &machine, &predicted) != SC_OK;
        for (int rank = 0; rank < ranks; rank++)
            drawn += units[rank];
        if (!code)
            printf("measured %.3f s, predicted %.3f s, %+.1f %%; units drawn %d, predicted %ld\n",
                   l.farm_s, predicted.farm_s, 100 * (predicted.farm_s / l.farm_s - 1), drawn,
                   predicted.units);
        code |= drawn != predicted.units;
    }
    free(costs);
    sc_free(units);
    return code;
}

int main(int argc, char **argv)
{
    const sc_ctx ctx = {.level = SC_LOG_INFO, .write = sc_log_to_stderr};
    sc_comm *comm;
    load l = {0};
    int code;

    if (argc == 5 && !strcmp(argv[1], "simulate"))
        return simulate(atoi(argv[2]), atof(argv[3]), atoi(argv[4]));
    if ((argc != 3 || strcmp(argv[1], "ranks") != 0) &&
        (argc != 6 || strcmp(argv[1], "compare") != 0)) {
        fprintf(stderr, "usage: farm_load simulate WORKERS RATE FRAMES | ranks FRAMES | compare "
                        "FRAMES MEAN_S MESSAGE_S NOTICE_S\n");
        return 64;
    }
    if (sc_comm_open(&ctx, true, &comm) != SC_OK)
        return 70;
    code = argc == 3 ? run(comm, &l, atoi(argv[2]))
                     : compare(comm, atoi(argv[2]), atof(argv[3]), atof(argv[4]), atof(argv[5]));
    sc_comm_close(comm);
    return code;
}
