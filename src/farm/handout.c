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
    GOPS_PER_RANK = 3,      /* with fewer whole GOPs for each rank, ranks would end far apart */
    RANKS_TO_GATHER = 64, /* with fewer ranks GOPs are not gathered unasked: rank 0, which does not
                             draw frames of gathered GOPs, would be missed */
    GATHER_MOST_MIB = 4 * WINDOW_MOST_MIB, /* limit of the window of all encoders together */
    BANDS_LEFT = 16,  /* bands of gathered GOPs are so high that so many are left for each rank, */
    WINDOW_SHARE = 6, /* and that the frames which are drawn at the same time, if each rank draws
                         one band, fill this fraction of the window: frames differ in cost */
    THIN_LEFT = 4,    /* at the end, with so many of the thinnest bands left for each rank, they are
                         halved: a band takes longer than what is left otherwise */
    RANKS_PER_ENCODER = 256 /* as long as nothing is known of costs */
};

/* So many times as many encoders as could just keep up: they draw, too, which slows encoding. */
#define SPARE_ENCODERS 3

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

/* @return the size of a window for @p frames frames: as many as the memory allows, so that one
 * costly frame does not hold up the others, but not more than are useful, and at least 2. @param
 * most_mib limit of the memory, whatever the ranks. */
static int window_for(const sc_work *work, int frames, long most_mib)
{
    const size_t frame_bytes =
        (size_t)work->width_px * (size_t)work->height_px * sc_pixel_bytes(work->alpha);
    const long limit_mib = WINDOW_MIB + (long)WINDOW_RANK_MIB * work->ranks;
    const size_t bytes = (size_t)(limit_mib < most_mib ? limit_mib : most_mib) << 20;
    const size_t affordable = bytes / (frame_bytes ? frame_bytes : 1);
    const long useful = (long)WINDOW_PER_RANK * work->ranks;
    const long wanted = useful < frames ? useful : frames;
    const long window = wanted < (long)affordable ? wanted : (long)affordable;

    return window < 2 ? 2 : (int)window;
}

/* @return how many of @p frames frames go out whole, before all others go out in bands.
 * @param window its size in frames. */
static int first_split(const sc_work *work, int frames, int window)
{
    if (work->partition == SC_PARTITION_FRAMES)
        return frames;
    if (work->partition == SC_PARTITION_TILES)
        return 0;
    if (work->ranks == 1)
        return frames;
    /* If the window holds few frames for each rank, it fills behind a frame that is more costly
     * than others, and leaves ranks without work. Then several ranks draw each frame. */
    return window < WINDOW_WHOLE * work->ranks ? 0
                                               : max_int(frames - SPLIT_PER_RANK * work->ranks, 0);
}

sc_handout sc_handout_begin(const sc_work *work)
{
    const int gathered = work->gathered * work->gop_frames, all = work->frames + gathered;
    const int window = window_for(work, all, WINDOW_MOST_MIB),
              from = first_split(work, all, window);
    /* number of frames that are split at the same time */
    const int together = max_int(min_int(all - from, min_int(work->ranks, window)), 1);
    const long bands = (long)BANDS_PER_RANK * work->ranks / together;
    const long rows = work->height_px / (bands > 0 ? bands : 1);

    return (sc_handout){.work = *work,
                        .window = window_for(work, work->frames, WINDOW_MOST_MIB),
                        .split_from = min_int(from, work->frames),
                        .band_rows = max_int((int)(rows / BAND_ROWS * BAND_ROWS), BAND_ROWS),
                        .encoders = sc_handout_encoders(work->ranks, 0, 0),
                        .gather_window = window_for(work, gathered, GATHER_MOST_MIB),
                        .gather_window_least = window_for(work, gathered, WINDOW_MOST_MIB),
                        .gather_split_from = max_int(from - work->frames, 0)};
}

/* @return whether no frame of a gathered GOP is left to be begun. */
static bool has_gathered_all(const sc_handout *h)
{
    return h->next_gathered == h->work.gathered * h->work.gop_frames;
}

/* @return whether no GOP or frame is left to be begun, and no frame is handed out in part only. */
static bool has_begun_all(const sc_handout *h)
{
    return h->next_row == 0 && h->next_gathered_row == 0 &&
           (h->stopped || (h->next_gop == h->work.gops && h->next_frame == h->work.frames &&
                           has_gathered_all(h)));
}

/* @return whether a frame for rank 0, or the next band of one, may go out. */
static bool may_hand_frame(const sc_handout *h)
{
    return h->next_row > 0 || (!h->stopped && h->next_frame < h->work.frames &&
                               h->next_frame < h->accepted + h->window);
}

/* @return the index of the frame with which the next group of gathered GOPs begins. */
static int group_end(const sc_handout *h)
{
    return h->group.first_frame + h->group.gops * h->work.gop_frames;
}

/* @return the size of the window of gathered GOPs for the present group: as many frames as one rank
 * could hold, or, if that is more, a GOP for each encoder. */
static int gather_window(const sc_handout *h)
{
    const int gops = h->group.gops * h->work.gop_frames;

    return max_int(min_int(gops, h->gather_window), h->gather_window_least);
}

/* @return whether a frame of a gathered GOP, or the next band of one, may go out. A group waits
 * until all encoders of the one before it have begun, so that each gets its GOPs in order. */
static bool may_gather(const sc_handout *h)
{
    if (h->next_gathered_row > 0)
        return true;
    return !h->stopped && !has_gathered_all(h) && h->next_gathered < h->taken + gather_window(h) &&
           (h->next_gathered < group_end(h) || h->taken >= h->group.first_frame + h->group.gops);
}

/* Hand out the frame *next, or, if it is split, its next band, from *row on, of @p band_rows rows.
 */
static sc_work_unit cut(const sc_handout *h, int split_from, int band_rows, int *next, int *row)
{
    sc_work_unit unit = {SC_UNIT_FRAME, *next, 0, h->work.height_px, 0, 0, 0};

    if (*next >= split_from) {
        unit.kind = SC_UNIT_BAND;
        unit.row = *row;
        unit.rows = min_int(band_rows, h->work.height_px - *row);
    }
    *row += unit.rows;
    if (*row == h->work.height_px) {
        *row = 0;
        ++*next;
    }
    return unit;
}

/* Begin the next group of gathered GOPs: with as many GOPs as encoders are wanted, or fewer, so
 * that the groups to come have about as many. */
static void begin_group(sc_handout *h)
{
    const int first = h->group.first + h->group.gops, left = h->work.gathered - first;
    const int wanted =
        h->work.encoders_most > 0 ? min_int(h->encoders, h->work.encoders_most) : h->encoders;
    const int most = max_int(min_int(min_int(wanted, left), h->work.ranks - 1), 1);
    const int groups = (left + most - 1) / most;

    h->group =
        (sc_gop_group){first, (left + groups - 1) / groups, h->next_gathered, !h->group.is_odd};
}

/* @return the rank that encodes GOP number @p i of the group. They are spread over all ranks but
 * the first, so that few are on the same node, and every second group has others, since those of
 * the group before are still busy when it begins. */
static int encoder_of(const sc_handout *h, int i)
{
    const long ranks = h->work.ranks - 1, shift = h->group.is_odd ? 0 : ranks / (2 * h->group.gops);

    return 1 + (int)((i * ranks / h->group.gops + shift) % ranks);
}

/* @return the height of the next band of a gathered GOP. As long as much is left for each rank,
 * bands are higher than at the end, because each costs something beside its rows; but not so high
 * that a window could not hold the frames that are drawn at the same time. */
static int gather_band_rows(const sc_handout *h)
{
    const long left =
        (long)(h->work.gathered * h->work.gop_frames - h->next_gathered) * h->work.height_px;
    const long fair = left / (BANDS_LEFT * (long)h->work.ranks);
    const long most =
        (long)gather_window(h) * h->work.height_px / (WINDOW_SHARE * (long)h->work.ranks);
    const int rows = (int)(fair < most ? fair : most) / BAND_ROWS * BAND_ROWS;

    if (h->band_rows == BAND_ROWS && left < (long)THIN_LEFT * BAND_ROWS * h->work.ranks)
        return BAND_ROWS / 2;
    return max_int(rows, h->band_rows);
}

/* Hand out a frame or band of a gathered GOP. */
static sc_work_unit gather(sc_handout *h)
{
    sc_work_unit unit;
    int at;

    if (h->next_gathered_row == 0 && h->next_gathered == group_end(h))
        begin_group(h);
    at = h->next_gathered - h->group.first_frame;
    unit =
        cut(h, h->gather_split_from, gather_band_rows(h), &h->next_gathered, &h->next_gathered_row);
    unit.encoder = encoder_of(h, at % h->group.gops);
    unit.gop = h->group.first + at % h->group.gops;
    unit.place = at / h->group.gops;
    return unit;
}

sc_handout_answer sc_handout_next(sc_handout *h, sc_work_unit *out)
{
    if (has_begun_all(h))
        return SC_HANDOUT_END;
    if (h->next_row == 0 && h->next_gop < h->work.gops && !h->stopped)
        *out = (sc_work_unit){.kind = SC_UNIT_GOP, .index = h->next_gop++};
    else if (may_hand_frame(h))
        *out = cut(h, h->split_from, h->band_rows, &h->next_frame, &h->next_row);
    else if (may_gather(h))
        *out = gather(h);
    else
        return SC_HANDOUT_WAIT;
    h->out++;
    return SC_HANDOUT_UNIT;
}

bool sc_handout_gathers_next(const sc_handout *h)
{
    return (h->next_row > 0 || h->next_gop == h->work.gops || h->stopped) && !may_hand_frame(h);
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

int sc_handout_encoders(int ranks, double draw_s, double encode_s)
{
    double wanted;

    if (draw_s <= 0 || encode_s <= 0)
        return 1 + ranks / RANKS_PER_ENCODER;
    wanted = ceil(SPARE_ENCODERS * encode_s / draw_s * ranks);
    return wanted < ranks ? (int)wanted : ranks;
}

int sc_handout_gathered(int gops, int ranks, bool always)
{
    return ranks > 1 && (always || (ranks >= RANKS_TO_GATHER && gops < GOPS_PER_RANK * ranks))
               ? max_int(gops - 1, 0)
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
