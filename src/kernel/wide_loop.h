/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: the last part of the wide templates, which include it once, at their end: the
 * kernel itself. Before it a template defines `packet` and PACKETS, init_packet, start_packet,
 * find_next, which takes all packets to where their rays may meet something, and add_found, which
 * adds that. */
#ifndef SC_KERNEL_WIDE_LOOP_H
#define SC_KERNEL_WIDE_LOOP_H

/* Lanes that a packet uses when @p left rays are left: LANES at most. */
static int lanes_used(size_t left)
{
    return left < LANES ? (int)left : LANES;
}

/* The kernel: see sc_march_fn. Rays are marched in PACKETS * LANES at a time. */
void MARCH_NAME(const sc_march *march, const sc_ray *rays, sc_way *ways, size_t count,
                sc_radiance *out, sc_march_counters *counters)
{
    packet p[PACKETS];

    for (int k = 0; k < PACKETS; k++)
        init_packet(&p[k], march);
    for (size_t i = 0; i < count; i += PACKETS * LANES) {
        const int lanes[PACKETS] = {lanes_used(count - i),
                                    count - i > LANES ? lanes_used(count - i - LANES) : 0};

        for (int k = 0; k < PACKETS; k++) {
            const size_t first = i + (size_t)k * LANES;

            start_packet(&p[k], rays + first, ways ? ways + first : NULL, out + first, lanes[k]);
        }
        while (m_any(p[0].alive) || m_any(p[1].alive)) {
            find_next(p);
            add_found(&p[0]);
            add_found(&p[1]);
        }
        for (int k = 0; k < PACKETS; k++) {
            for (int lane = 0; lane < lanes[k]; lane++)
                out[i + (size_t)(k * LANES + lane)] = v_radiance_get_lane(&p[k].light, lane);
        }
    }
    counters->rays += count;
    for (int k = 0; k < PACKETS; k++)
        sc_add_counters(counters, &p[k].counters);
}

#endif
