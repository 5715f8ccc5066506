/* SPDX-License-Identifier: BSD-3-Clause */
/* The events of a simulation, in a binary heap. */
#include "internal.h"

/* @return whether @p a happens before @p b. */
static bool is_before(const sim_event *a, const sim_event *b)
{
    return a->time_s < b->time_s || (a->time_s <= b->time_s && a->order < b->order);
}

/* Make room for one more event. @return false if there is no memory. */
static bool make_room(sim_events *all)
{
    if (all->status == SC_OK)
        all->status = SC_GROW(all->ctx, all->count, &all->capacity, &all->heap);
    return all->count < all->capacity;
}

void sc_sim_push(sim_events *all, sim_event e)
{
    size_t i;

    if (!make_room(all))
        return;
    e.order = all->pushed++;
    for (i = all->count++; i > 0 && is_before(&e, &all->heap[(i - 1) / 2]); i = (i - 1) / 2)
        all->heap[i] = all->heap[(i - 1) / 2];
    all->heap[i] = e;
}

sim_event sc_sim_pop(sim_events *all)
{
    const sim_event top = all->heap[0], last = all->heap[--all->count];
    size_t i = 0;

    for (size_t child = 1; child < all->count; child = 2 * i + 1) {
        if (child + 1 < all->count && is_before(&all->heap[child + 1], &all->heap[child]))
            child++;
        if (!is_before(&all->heap[child], &last))
            break;
        all->heap[i] = all->heap[child];
        i = child;
    }
    all->heap[i] = last;
    return top;
}
