/* SPDX-License-Identifier: BSD-3-Clause */
/* The records of ranks in stats.json: written and read here, from one list of members. */
#include "rank_json.h"

#include <stddef.h>

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

        if (json_array_append_new(array, json_real(*value))) {
            json_decref(array);
            array = NULL;
        }
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

    for (int i = 0; i < count && array; i++) {
        if (json_array_append_new(array, json_integer(ranks[i].threads))) {
            json_decref(array);
            array = NULL;
        }
    }
    return array;
}

json_t *sc_ranks_to_json(const sc_rank_record *ranks, int count)
{
    json_t *all = json_object(), *phases = json_object();
    int failed = !all || !phases;

    for (int p = 0; p < SC_PHASE_COUNT && !failed; p++)
        failed = json_object_set_new(
            phases, sc_phase_key(p),
            json_pack("{s:o, s:o}", "wall_s", column(ranks, count, phase_offset(p, false)), "cpu_s",
                      column(ranks, count, phase_offset(p, true))));
    for (size_t i = 0; i < SC_COUNT_OF(members) && !failed; i++)
        failed = json_object_set_new(all, members[i].key, column(ranks, count, members[i].offset));
    if (!failed)
        failed = json_object_set_new(all, "threads", threads_to_json(ranks, count)) ||
                 json_object_set(all, "phases", phases);
    json_decref(phases);
    if (failed)
        json_decref(all);
    return failed ? NULL : all;
}

/* Read an array of seconds into the doubles at @p offset in each record. */
static bool read_column(const json_t *array, sc_rank_record *ranks, int count, size_t offset)
{
    if (json_array_size(array) != (size_t)count)
        return false;
    for (int i = 0; i < count; i++) {
        const json_t *value = json_array_get(array, (size_t)i);
        const double seconds = json_number_value(value);
        double *out = (void *)((char *)&ranks[i] + offset);

        if (!json_is_number(value) || !(seconds >= 0 && seconds < 1e12))
            return false;
        *out = seconds;
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
        const json_int_t number = json_integer_value(json_array_get(threads, (size_t)i));

        if (number < 0 || number > INT16_MAX)
            return false;
        ranks[i].threads = (int32_t)number;
    }
    return true;
}
