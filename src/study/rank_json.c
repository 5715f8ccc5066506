/* SPDX-License-Identifier: BSD-3-Clause */
/* The records of ranks in stats.json: written and read here, from one list of members. */
#include "rank_json.h"
#include "segcast/json_values.h"

#define ROW(kind, member) SC_JSON_ROW(kind, sc_rank_record, member)

/* The arrays beside those of phases. */
static const sc_json_row members[] = {ROW(SECONDS, cpu_s), ROW(SECONDS, farm_idle_s),
                                      ROW(SECONDS, accept_wall_s), ROW(INT, threads)};

const char *sc_phase_key(sc_phase phase)
{
    static const char *const keys[SC_PHASE_COUNT] = {"read",   "prepare", "share", "render",
                                                     "gather", "encode",  "write", "idle"};

    return keys[phase];
}

/* @return an array of a member of each record; NULL: no memory. */
static json_t *column(const sc_json_row *row, const sc_rank_record *ranks, int count)
{
    json_t *array = json_array();

    for (int i = 0; i < count && array; i++)
        array = sc_json_with(array, sc_json_of_row(row, &ranks[i]));
    return array;
}

/* @return the row of the times of a phase in a record. @param cpu those of the CPU */
static sc_json_row row_of_phase(int phase, bool cpu)
{
    return (sc_json_row){
        cpu ? "cpu_s" : "wall_s", SC_JSON_SECONDS,
        offsetof(sc_rank_record, phases) + (size_t)phase * sizeof(sc_phase_time) +
            (cpu ? offsetof(sc_phase_time, cpu_s) : offsetof(sc_phase_time, wall_s)),
        sizeof(double)};
}

json_t *sc_ranks_to_json(const sc_rank_record *ranks, int count)
{
    json_t *phases = json_object(), *all;

    for (int p = 0; p < SC_PHASE_COUNT && phases; p++) {
        const sc_json_row wall = row_of_phase(p, false), cpu = row_of_phase(p, true);

        phases = sc_json_with_key(phases, sc_phase_key(p),
                                  json_pack("{s:o, s:o}", wall.key, column(&wall, ranks, count),
                                            cpu.key, column(&cpu, ranks, count)));
    }
    all = json_object();
    for (size_t i = 0; i < SC_COUNT_OF(members) && all; i++)
        all = sc_json_with_key(all, members[i].key, column(&members[i], ranks, count));
    return sc_json_with_key(all, "phases", phases);
}

/* Read the array of a member of each record from @p object. */
static bool read_column(const sc_json_row *row, const json_t *object, sc_rank_record *ranks,
                        int count)
{
    const json_t *array = json_object_get(object, row->key);
    bool good = json_array_size(array) == (size_t)count;

    for (int i = 0; i < count && good; i++)
        good = sc_json_read_row(row, json_array_get(array, (size_t)i), &ranks[i]);
    return good;
}

bool sc_ranks_from_json(const json_t *json, sc_rank_record *ranks, int count)
{
    const json_t *phases = json_object_get(json, "phases");
    bool good = true;

    for (int p = 0; p < 2 * SC_PHASE_COUNT && good; p++) {
        const sc_json_row row = row_of_phase(p / 2, p % 2);

        good = read_column(&row, json_object_get(phases, sc_phase_key(p / 2)), ranks, count);
    }
    for (size_t i = 0; i < SC_COUNT_OF(members) && good; i++)
        good = read_column(&members[i], json, ranks, count);
    for (int i = 0; i < count && good; i++)
        good = ranks[i].threads <= INT16_MAX;
    return good;
}
