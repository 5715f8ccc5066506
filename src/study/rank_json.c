/* SPDX-License-Identifier: BSD-3-Clause */
/* The records of ranks in stats.json: written and read here, from one list of members. */
#include "rank_json.h"
#include "segcast/json_values.h"

/* The arrays beside those of phases; all hold seconds. */
static const struct {
    const char *key;
    size_t offset;
} members[] = {{"cpu_s", offsetof(sc_rank_record, cpu_s)},
               {"farm_idle_s", offsetof(sc_rank_record, farm_idle_s)},
               {"accept_wall_s", offsetof(sc_rank_record, accept_wall_s)}};

const char *sc_phase_key(sc_phase phase)
{
    static const char *const keys[SC_PHASE_COUNT] = {"read",   "prepare", "share", "render",
                                                     "gather", "encode",  "write", "idle"};

    return keys[phase];
}

/* @return an array of the doubles at @p offset in each record; NULL: no memory. */
static json_t *column(const sc_rank_record *ranks, int count, size_t offset)
{
    json_t *array = json_array();

    for (int i = 0; i < count && array; i++) {
        const double *value = (const void *)((const char *)&ranks[i] + offset);

        array = sc_json_with(array, json_real(*value));
    }
    return array;
}

/* @return where in a record the times of a phase are; @p cpu: those of the CPU. */
static size_t phase_offset(int phase, bool cpu)
{
    return offsetof(sc_rank_record, phases) + (size_t)phase * sizeof(sc_phase_time) +
           (cpu ? offsetof(sc_phase_time, cpu_s) : offsetof(sc_phase_time, wall_s));
}

/* @return the array of the numbers of threads; NULL: no memory. */
static json_t *threads_to_json(const sc_rank_record *ranks, int count)
{
    json_t *array = json_array();

    for (int i = 0; i < count && array; i++)
        array = sc_json_with(array, json_integer(ranks[i].threads));
    return array;
}

json_t *sc_ranks_to_json(const sc_rank_record *ranks, int count)
{
    json_t *phases = json_object(), *all;

    for (int p = 0; p < SC_PHASE_COUNT && phases; p++)
        phases = sc_json_with_key(phases, sc_phase_key(p),
                                  json_pack("{s:o, s:o}", "wall_s",
                                            column(ranks, count, phase_offset(p, false)), "cpu_s",
                                            column(ranks, count, phase_offset(p, true))));
    all = json_object();
    for (size_t i = 0; i < SC_COUNT_OF(members) && all; i++)
        all = sc_json_with_key(all, members[i].key, column(ranks, count, members[i].offset));
    all = sc_json_with_key(all, "threads", threads_to_json(ranks, count));
    return sc_json_with_key(all, "phases", phases);
}

/* Read an array of seconds into the doubles at @p offset in each record. */
static bool read_column(const json_t *array, sc_rank_record *ranks, int count, size_t offset)
{
    if (json_array_size(array) != (size_t)count)
        return false;
    for (int i = 0; i < count; i++) {
        if (!sc_json_real(json_array_get(array, (size_t)i), 0, 1e12,
                          (void *)((char *)&ranks[i] + offset)))
            return false;
    }
    return true;
}

bool sc_ranks_from_json(const json_t *json, sc_rank_record *ranks, int count)
{
    const json_t *phases = json_object_get(json, "phases");
    const json_t *threads = json_object_get(json, "threads");

    for (int p = 0; p < SC_PHASE_COUNT; p++) {
        const json_t *phase = json_object_get(phases, sc_phase_key(p));

        if (!read_column(json_object_get(phase, "wall_s"), ranks, count, phase_offset(p, false)) ||
            !read_column(json_object_get(phase, "cpu_s"), ranks, count, phase_offset(p, true)))
            return false;
    }
    for (size_t i = 0; i < SC_COUNT_OF(members); i++) {
        if (!read_column(json_object_get(json, members[i].key), ranks, count, members[i].offset))
            return false;
    }
    if (json_array_size(threads) != (size_t)count)
        return false;
    for (int i = 0; i < count; i++) {
        if (!sc_json_int(json_array_get(threads, (size_t)i), 0, INT16_MAX, &ranks[i].threads))
            return false;
    }
    return true;
}
