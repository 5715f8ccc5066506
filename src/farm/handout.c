/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/farm.h"

enum {
    WINDOW_BYTES = 256 << 20, /* of frames on rank 0 */
    WINDOW_PER_RANK = 64,
    BAND_ROWS = 16,      /* no thinner ones: rays look at their neighbours */
    BANDS_PER_RANK = 16, /* at least, of the frames that are split last */
    SPLIT_PER_RANK = 4,  /* so many are: also a rank of a fourth of the speed ends in time */
    RANKS_TO_FEED = 4,   /* fewer: one encoder keeps up with them */
    GROUPS_PER_RANK = 3  /* fewer: ranks would end at different times */
};

static int least(int a, int b)
{
    return a < b ? a : b;
}

static int most(int a, int b)
{
    return a > b ? a : b;
}

/* Frames in the window: as many as memory allows, so that one costly frame holds nobody back, but
 * not more than there is use for. */
static int window_for(const sc_work *work)
{
    const size_t frame_bytes = (size_t)work->width_px * (size_t)work->height_px * 3;
    const size_t affordable = (size_t)WINDOW_BYTES / (frame_bytes ? frame_bytes : 1);
    const long useful = (long)WINDOW_PER_RANK * work->ranks;
    const long wanted = useful < work->frames ? useful : work->frames;
    const long window = wanted < (long)affordable ? wanted : (long)affordable;

    return window < 2 ? 2 : (int)window;
}

/* From which frame on frames are split. */
static int first_split(const sc_work *work, int window)
{
    if (work->partition == SC_PARTITION_FRAMES)
        return work->frames;
    if (work->partition == SC_PARTITION_TILES)
        return 0;
    if (work->ranks == 1)
        return work->frames;
    /* Too few fit into the memory of rank 0 to keep all ranks busy: several ranks to each. */
    return window < 2 * work->ranks ? 0 : most(work->frames - SPLIT_PER_RANK * work->ranks, 0);
}

sc_handout sc_handout_begin(const sc_work *work)
{
    const int window = window_for(work), from = first_split(work, window);
    const int together = most(least(work->frames - from, least(work->ranks, window)), 1);
    const long bands = (long)BANDS_PER_RANK * work->ranks / together;
    const long rows = work->height_px / (bands > 0 ? bands : 1);

    return (sc_handout){.groups = work->groups,
                        .frames = work->frames,
                        .height_px = work->height_px,
                        .window = window,
                        .split_from = from,
                        .band_rows = most((int)(rows / BAND_ROWS * BAND_ROWS), BAND_ROWS)};
}

sc_handout_answer sc_handout_next(sc_handout *h, sc_unit *out)
{
    if (h->next_row == 0 &&
        (h->stopped || (h->next_group == h->groups && h->next_frame == h->frames)))
        return SC_HANDOUT_END;
    if (h->next_row == 0 && h->next_group < h->groups) {
        *out = (sc_unit){.kind = SC_UNIT_GROUP, .index = h->next_group++};
    } else if (h->next_frame >= h->taken + h->window) {
        return SC_HANDOUT_WAIT;
    } else if (h->next_frame < h->split_from) {
        *out = (sc_unit){SC_UNIT_FRAME, h->next_frame++, 0, h->height_px};
    } else {
        const int rows = least(h->band_rows, h->height_px - h->next_row);

        *out = (sc_unit){SC_UNIT_BAND, h->next_frame, h->next_row, rows};
        h->next_row += rows;
        if (h->next_row == h->height_px) {
            h->next_row = 0;
            h->next_frame++;
        }
    }
    h->out++;
    return SC_HANDOUT_UNIT;
}

void sc_handout_back(sc_handout *handout)
{
    handout->out--;
}

bool sc_handout_finished(const sc_handout *h)
{
    return h->out == 0 && h->next_row == 0 &&
           (h->stopped || (h->next_group == h->groups && h->next_frame == h->frames));
}

int sc_handout_groups(int groups, int ranks, bool always)
{
    const int last = most(least(ranks / 2, 4), 1); /* as many as rank 0 encodes meanwhile */

    return always || (ranks >= RANKS_TO_FEED && groups >= GROUPS_PER_RANK * ranks)
               ? most(groups - last, 0)
               : 0;
}
