/* SPDX-License-Identifier: BSD-3-Clause */
/* Which work unit goes out next. It uses neither messages nor a clock, so that test_farm.c can
 * simulate up to 65,536 ranks. */
#include "segcast/farm.h"

#include <math.h>

enum {
    WINDOW_MIB = 256,       /* limit of the window in MiB, */
    WINDOW_RANK_MIB = 4,    /* and what each rank adds to it, a fraction of what it holds itself, */
    WINDOW_MOST_MIB = 4096, /* up to this; see docs/studies.md for what follows from them */
    WINDOW_WHOLE = 3,       /* frames are split if it holds fewer than this for each rank */
    WINDOW_PER_RANK = 64,   /* limit of the window in frames, for each rank */
    BAND_ROWS = 16,         /* the height of a band is a multiple of this: sub-pixel rays are traced
                               where neighbouring pixels differ, and thinner bands would trace many
                               pixels of their neighbours again */
    BANDS_PER_RANK = 16,    /* number of bands, for each rank, that the frames which are drawn at
                               the same time are split into */
    SPLIT_PER_RANK = 4,     /* this many of the last frames, for each rank, are split: enough that a
                               rank with a fourth of the others' speed ends together with them */
    RANKS_TO_FEED = 4,      /* with fewer ranks the encoder of rank 0 is fast enough for all */
    GOPS_PER_RANK = 3       /* with fewer whole GOPs for each rank, ranks would end far apart */
};

/* A rank asks for its next work unit when the one that it draws is expected to end within this
 * time. That is many times the duration of a message, and short compared with a work unit, so that
 * no rank holds back work that another could begin. */
#define ASK_AHEAD_S 0.01

static int min_int(int a, int b)
{
    return a < b ? a : b;
}

static int max_int(int a, int b)
{
    return a > b ? a : b;
}

/* @return the size of the window in frames: as many as the memory allows, so that one costly frame
 * does not hold up the others, but not more than are useful, and at least 2. */
static int window_for(const sc_work *work)
{
    const size_t frame_bytes = (size_t)work->width_px * (size_t)work->height_px * 3;
    const long limit_mib = WINDOW_MIB + (long)WINDOW_RANK_MIB * work->ranks;
    const size_t bytes = (size_t)(limit_mib < WINDOW_MOST_MIB ? limit_mib : WINDOW_MOST_MIB) << 20;
    const size_t affordable = bytes / (frame_bytes ? frame_bytes : 1);
    const long useful = (long)WINDOW_PER_RANK * work->ranks;
    const long wanted = useful < work->frames ? useful : work->frames;
    const long window = wanted < (long)affordable ? wanted : (long)affordable;

    return window < 2 ? 2 : (int)window;
}

/* @return the index of the first frame that goes out in bands; the frames before it go out whole.
 * @param window its size in frames. */
static int first_split(const sc_work *work, int window)
{
    if (work->partition == SC_PARTITION_FRAMES)
        return work->frames;
    if (work->partition == SC_PARTITION_TILES)
        return 0;
    if (work->ranks == 1)
        return work->frames;
    /* If the window holds few frames for each rank, it fills behind a frame that is more costly
     * than others, and leaves ranks without work. Then several ranks draw each frame. */
    return window < WINDOW_WHOLE * work->ranks
               ? 0
               : max_int(work->frames - SPLIT_PER_RANK * work->ranks, 0);
}

sc_handout sc_handout_begin(const sc_work *work)
{
    const int window = window_for(work), from = first_split(work, window);
    /* number of frames that are split at the same time */
    const int together = max_int(min_int(work->frames - from, min_int(work->ranks, window)), 1);
    const long bands = (long)BANDS_PER_RANK * work->ranks / together;
    const long rows = work->height_px / (bands > 0 ? bands : 1);

    return (sc_handout){.gops = work->gops,
                        .frames = work->frames,
                        .height_px = work->height_px,
                        .window = window,
                        .split_from = from,
                        .band_rows = max_int((int)(rows / BAND_ROWS * BAND_ROWS), BAND_ROWS)};
}

/* @return whether no GOP or frame is left to be begun, and no frame is handed out in part only. */
static bool has_begun_all(const sc_handout *h)
{
    return h->next_row == 0 &&
           (h->stopped || (h->next_gop == h->gops && h->next_frame == h->frames));
}

sc_handout_answer sc_handout_next(sc_handout *h, sc_work_unit *out)
{
    if (has_begun_all(h))
        return SC_HANDOUT_END;
    if (h->next_row == 0 && h->next_gop < h->gops) {
        *out = (sc_work_unit){.kind = SC_UNIT_GOP, .index = h->next_gop++};
    } else if (h->next_frame >= h->accepted + h->window) {
        return SC_HANDOUT_WAIT;
    } else if (h->next_frame < h->split_from) {
        *out = (sc_work_unit){SC_UNIT_FRAME, h->next_frame++, 0, h->height_px};
    } else {
        const int rows = min_int(h->band_rows, h->height_px - h->next_row);

        *out = (sc_work_unit){SC_UNIT_BAND, h->next_frame, h->next_row, rows};
        h->next_row += rows;
        if (h->next_row == h->height_px) {
            h->next_row = 0;
            h->next_frame++;
        }
    }
    h->out++;
    return SC_HANDOUT_UNIT;
}

void sc_handout_unit_done(sc_handout *handout)
{
    handout->out--;
}

bool sc_handout_finished(const sc_handout *h)
{
    return h->out == 0 && has_begun_all(h);
}

int sc_handout_gops(int gops, int ranks, bool always)
{
    /* the last GOPs, which go out as frames: as many as rank 0 can encode meanwhile */
    const int last = max_int(min_int(ranks / 2, 4), 1);

    return always || (ranks >= RANKS_TO_FEED && gops >= GOPS_PER_RANK * ranks)
               ? max_int(gops - last, 0)
               : 0;
}

double sc_handout_ask_age_s(double rows, double row_s)
{
    const double age_s = rows * row_s - ASK_AHEAD_S;

    /* Where nothing is known, the unit may be long, and a rank that has none could begin the next
     * one at once. */
    if (row_s <= 0)
        return (double)INFINITY;
    return age_s > 0 ? age_s : 0;
}
