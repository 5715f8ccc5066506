/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to simulate: events, the state of a simulated farm, and its two kinds of actors. Times
 * are seconds since the farm began. */
#ifndef SC_SIMULATE_INTERNAL_H
#define SC_SIMULATE_INTERNAL_H

#include "segcast/simulate.h"

/* ---- events.c: what will happen ---- */

typedef enum sim_event_kind {
    SIM_ARRIVED,  /* a message of a rank is at another one: a request (unit.kind SC_UNIT_NONE), the
                   * result of a work unit, or its pixels */
    SIM_HANDLED,  /* the main thread of the receiving rank has handled that message */
    SIM_UNIT,     /* a work unit is at the rank that it was handed to */
    SIM_ASK,      /* it is time for a rank to ask for a work unit */
    SIM_DRAWN,    /* a rank has drawn its work unit */
    SIM_ACCEPTED, /* a rank has encoded a frame: rank 0, or an encoder */
    SIM_NOTICED,  /* the main thread of rank 0 has noticed that */
    SIM_TAKEN     /* rank 0 has heard that an encoder has encoded a frame, or ended a GOP */
} sim_event_kind;

typedef struct sim_event {
    double time_s;
    uint64_t order; /* of events at the same time the one that was pushed first happens first */
    sim_event_kind kind;
    int rank;      /* whose event it is; of a message: the sender */
    bool gathered; /* of a message: its pixels are for the encoder of its unit, and it goes there */
    long generation; /* what the event was made for; it is void if that is over */
    double seconds;  /* of a result, or a frame that was encoded: how long it took */
    sc_work_unit unit;
} sim_event;

/* A binary heap, the earliest event first. */
typedef struct sim_events {
    const sc_ctx *ctx;
    sim_event *heap; /* owned */
    size_t count, capacity;
    uint64_t pushed;
    sc_status status; /* SC_ERR_MEMORY: an event is lost, and the simulation has to end */
} sim_events;

void sc_sim_push(sim_events *all, sim_event e);
/* Remove the earliest event; there must be one. */
sim_event sc_sim_pop(sim_events *all);

/* ---- the state ---- */

/* One of the two threads of a rank that need its cores: drawing and encoding. */
typedef struct sim_load {
    bool busy;
    double left_s;   /* what is left to do, in seconds of it running alone */
    double since_s;  /* when that was so */
    long generation; /* changes with every new forecast of its end */
} sim_load;

/* A rank. */
typedef struct sim_rank {
    sc_work_unit units[SC_UNITS_PER_RANK]; /* the first is drawn, the others wait */
    int in_hand;
    bool asked;          /* and not answered */
    bool window_full;    /* it waits for an answer since the window was full */
    bool held_back;      /* it does not ask, because it is behind with encoding */
    double row_s;        /* of the unit drawn last */
    double begin_s;      /* of the unit that is drawn */
    double ask_s;        /* when the rank asks for the one that follows it */
    double idle_since_s; /* when in_hand became 0 */
    long generation;     /* units begun */
    sim_load drawing, encoding;
    double main_free_s; /* when its main thread will have handled all that has arrived */
    /* of an encoder: frames of gathered GOPs that it is to encode, in order, as a list */
    int first, last; /* indices in sim_farm.gathered; -1: none */
    int behind;      /* frames with all rows that it has not encoded */
} sim_rank;

/* A frame of a gathered GOP. */
typedef struct sim_gathered {
    int rows_left; /* that are not at the encoder */
    int next; /* the one that the same encoder encodes next, as index in sim_farm.gathered; or -1 */
    bool ends_gop;
    bool taken;     /* rank 0 knows that it is encoded */
    double begin_s; /* when the encoder began it */
} sim_gathered;

/* The ranks without an answer: a ring, oldest first. */
typedef struct sim_ready {
    int *ranks; /* [machine->ranks] */
    int first, count;
} sim_ready;

/* What rank 0 knows of costs: of drawing, seconds of rows, and of encoding, seconds of frames. */
typedef struct sim_costs {
    double drawn_s, drawn_rows, encoded_s;
    int encoded;
} sim_costs;

/* A simulated farm. */
typedef struct sim_farm {
    const sc_sim_film *film;
    const sc_sim_machine *machine;
    sc_handout handout;
    int whole; /* index in the film of the first frame that is not drawn in a whole GOP */
    int nodes;
    sim_events events;
    sim_rank *ranks; /* [machine->ranks] */
    sim_ready ready;
    int *rows_left;         /* [handout.frames]: rows that are not at rank 0 */
    int next_to_accept;     /* the first frame that the accepting thread does not have */
    int accepted;           /* frames it is done with; handout.accepted, when that is noticed */
    double accept_begin_s;  /* when it began the one that it has */
    int full;               /* frames with all rows, accepted ones included */
    sim_gathered *gathered; /* [frames of gathered GOPs] */
    int gops_left;          /* gathered GOPs that are not at rank 0 */
    double encoder_cores;   /* that an encoder can use */
    sim_costs costs;
    double now_s;
    sc_sim_result *out;
} sim_farm;

/* ---- machine.c: speeds, bandwidths, and what comes before and after the farm ---- */

/* @return the speed of the cores of @p rank. */
double sc_sim_speed(const sc_sim_machine *machine, int rank);
/* @return the time that @p bytes need from the node of @p rank to that of @p target, without
 * latency; 0 on the same node. */
double sc_sim_transfer_s(const sc_sim_machine *machine, int rank, int target, double bytes);
/* Fill in start_s, read_s, prepare_s, share_s and finish_s. */
void sc_sim_phases(const sc_sim_film *film, const sc_sim_machine *machine, sc_sim_result *out);
/* Fill in everything that follows from farm_s and the times of all phases. */
void sc_sim_conclude(const sc_sim_film *film, const sc_sim_machine *machine, sc_sim_result *out);

/* ---- ranks.c: drawing ---- */

/* A rank receives a work unit: it draws it, now or after the one that it draws. */
void sc_sim_receive_unit(sim_farm *f, int rank, const sc_work_unit *unit);
/* Ask rank 0 for a work unit, unless there are enough. @param generation that of the event. */
void sc_sim_ask(sim_farm *f, int rank, long generation);
/* A rank has drawn its unit: it sends the result, and goes on with the next. */
void sc_sim_drawn(sim_farm *f, int rank, long generation);
/* Let the encoding thread of a rank work on a frame from now on, as its cores allow. */
void sc_sim_begin_encoding(sim_farm *f, int rank);
/* @return whether the event SIM_ACCEPTED of @p generation holds; encoding has ended then. */
bool sc_sim_end_encoding(sim_farm *f, int rank, long generation);

/* ---- encoders.c: gathered GOPs ---- */

/* Note that a unit of a gathered GOP has gone out, so that its encoder knows the order. */
void sc_sim_note_gathered(sim_farm *f, const sc_work_unit *unit);
/* The pixels of a unit are at its encoder. */
void sc_sim_gather(sim_farm *f, const sc_work_unit *unit);
/* An encoder has encoded a frame. */
void sc_sim_encoded(sim_farm *f, int rank);
/* Rank 0 has heard of that. */
void sc_sim_taken(sim_farm *f, const sim_event *e);

/* ---- root.c: what the main thread of rank 0 does ---- */

/* A message has arrived: it is handled when those before it are. */
void sc_sim_arrive(sim_farm *f, const sim_event *e);
/* It is handled now. */
void sc_sim_handle(sim_farm *f, const sim_event *e);
/* Rank 0 has accepted a frame. */
void sc_sim_accepted(sim_farm *f);
/* Hand out work units to the ranks that wait, then to rank 0. */
void sc_sim_hand_out(sim_farm *f);

#endif
