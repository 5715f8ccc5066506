/* SPDX-License-Identifier: BSD-3-Clause */
/* A queue of the next events of simulated ranks, from which the earliest is removed first (a binary
 * heap). */
#ifndef SC_TEST_EVENTS_H
#define SC_TEST_EVENTS_H

#include "segcast/farm.h"

typedef struct event {
    double time_s;
    int rank, tag; /* tag: what happens; the simulation gives the number a meaning */
    sc_work_unit unit;
} event;

typedef struct events {
    event *heap; /* allocated by the simulation, with room for all events at a time */
    int count;
} events;

static inline void push_event(events *all, event e)
{
    int i = all->count++;

    for (; i > 0 && all->heap[(i - 1) / 2].time_s > e.time_s; i = (i - 1) / 2)
        all->heap[i] = all->heap[(i - 1) / 2];
    all->heap[i] = e;
}

/* Remove the earliest event; there must be one. */
static inline event pop_event(events *all)
{
    const event top = all->heap[0], last = all->heap[--all->count];
    int i = 0;

    for (int child = 1; child < all->count; child = 2 * i + 1) {
        if (child + 1 < all->count && all->heap[child + 1].time_s < all->heap[child].time_s)
            child++;
        if (all->heap[child].time_s >= last.time_s)
            break;
        all->heap[i] = all->heap[child];
        i = child;
    }
    all->heap[i] = last;
    return top;
}

#endif
