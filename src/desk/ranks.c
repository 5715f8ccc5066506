/* SPDX-License-Identifier: BSD-3-Clause */
/* Several ranks draw one picture together. Rank 0 serves the pages and sends requests to the
 * others. All ranks hold the same session, and the bands of rows of a picture are dealt out to them
 * in turn. Only the main thread of a rank calls MPI. On all ranks but rank 0 a second thread draws,
 * so that the main thread can receive the request to cancel the picture meanwhile. */
#include "desk.h"

#include <math.h>
#include <pthread.h>

enum { TAG_ROWS = SC_TAG_ORDER + 1, TAG_STOP };
/* Bands of each rank, and the least number of rows of one. Few bands balance the load badly, as
 * rows differ in cost; low ones are inefficient, as each band has a fixed cost. */
enum { BANDS = 4, ROWS_LEAST = 16 };
/* Sleeps between two tests for messages: so a rank that has nothing to do takes less than 1 % of a
 * core, and hears of the next picture at most 2 ms late. */
#define NAP_S 1e-4
#define NAP_LONGEST_S 2e-3

/* ---- drawing ---- */

/* What a rank draws of a picture. */
typedef struct share {
    sc_desk *desk;
    const sc_order *order;
    sc_image image; /* of which its bands are drawn */
    char *rows;     /* 1 if all of them are; then these, one after the other; room for a picture */
    size_t bytes;   /* in use */
    atomic_int is_done;
} share;

static void clear_share(share *s)
{
    sc_image_clear(&s->image);
    sc_free(s->rows);
}

static sc_status draw_rows(sc_desk *desk, const sc_order *o, const sc_rows *rows, sc_image *image)
{
    sc_render_stats stats;

    return (o->hurries ? sc_session_sketch : sc_session_draw)(&desk->app, desk->sessions.now,
                                                              o->frame, rows, image, &stats);
}

/* Draw the bands of a rank, each to s->image and from there to s->rows: other rows of the picture
 * are spoiled then. @param to not NULL: only copy them from s->rows to this picture. */
static void do_bands(share *s, int rank, sc_image *to)
{
    const sc_image *image = to ? to : &s->image;
    const int ranks = sc_comm_size(s->desk->app.comm), height_px = image->height_px;
    const int even = (height_px - 1) / (ranks * BANDS) + 1;
    const int rows = even > ROWS_LEAST ? even : ROWS_LEAST;
    const size_t row = (size_t)image->width_px * sc_pixel_bytes(image->alpha);
    sc_status status = SC_OK;

    s->bytes = 1;
    for (int y = rank * rows; y < height_px && status == SC_OK; y += ranks * rows) {
        const sc_rows part = {y, y + rows < height_px ? y + rows : height_px};
        const size_t bytes = row * (size_t)(part.end - y);
        uint8_t *at = image->rgb + row * (size_t)y;

        if (!to)
            status = *s->desk->interrupt ? SC_ERR_INCOMPLETE
                                         : draw_rows(s->desk, s->order, &part, &s->image);
        memcpy(to ? (void *)at : s->rows + s->bytes, to ? (void *)(s->rows + s->bytes) : at, bytes);
        s->bytes += bytes;
    }
    if (!to)
        s->rows[0] = status == SC_OK;
}

/* Make room for what a rank draws, if there are others. */
static sc_status make_room(sc_desk *desk, const sc_order *o, share *s)
{
    s->desk = desk;
    s->order = o;
    if (sc_comm_size(desk->app.comm) == 1)
        return SC_OK;
    SC_PASS(sc_image_init_alpha(&desk->ctx, o->size_px[0], o->size_px[1],
                                desk->sessions.now->job.render.background.is_none, &s->image));
    return SC_ALLOC(&desk->ctx, sc_image_bytes(&s->image) + 1, &s->rows);
}

/* Begin to draw a picture, all ranks together. */
static sc_status begin(sc_desk *desk, const sc_order *o)
{
    int frame;
    sc_timeline *t = &sc_session_panel(desk->sessions.now, o->frame, &frame)->timeline;
    const sc_looks looks = t->looks;
    const sc_way_point *ways = t->ways;

    if (o->is_nudged)
        sc_comm_broadcast(desk->app.comm, t, sizeof *t);
    t->looks = looks; /* what was received are addresses of rank 0 */
    t->ways = ways;
    sc_session_hurry(desk->sessions.now, o->hurries);
    return o->hurries ? SC_OK : sc_session_light(&desk->app, desk->sessions.now);
}

/* Receive the rows that the other ranks have drawn, into @p image. @return false if a rank has not
 * drawn all of its rows. */
static bool collect(sc_desk *desk, share *s, sc_image *image)
{
    sc_comm *comm = desk->app.comm;
    bool is_whole = true, is_told = false;
    sc_message message;

    for (int left = sc_comm_size(comm) - 1; left > 0;) {
        if (*desk->interrupt && !is_told)
            sc_desk_tell(desk, &(sc_order){.what = SC_ORDER_GIVE_UP});
        is_told = is_told || *desk->interrupt;
        if (!sc_comm_poll(comm, &message)) {
            sc_sleep_s(NAP_S);
            continue;
        }
        sc_comm_receive(comm, &message, s->rows);
        if (message.tag == TAG_STOP) {
            desk->is_asked_to_stop = true;
            continue;
        }
        left--;
        is_whole = is_whole && s->rows[0];
        if (is_whole)
            do_bands(s, message.source, image);
    }
    return is_whole;
}

sc_status sc_desk_draw(sc_desk *desk, int frame, bool hurries, sc_image *image)
{
    const sc_order o = {.what = SC_ORDER_DRAW,
                        .frame = frame,
                        .size_px = {image->width_px, image->height_px},
                        .hurries = hurries,
                        .is_nudged = desk->sessions.is_nudged};
    SC_OWN(clear_share) share s = {0};
    sc_status status;

    SC_PASS(make_room(desk, &o, &s));
    sc_desk_tell(desk, &o);
    status = begin(desk, &o);
    if (!s.rows)
        return status == SC_OK ? draw_rows(desk, &o, NULL, image) : status;
    if (status == SC_OK) {
        do_bands(&s, 0, NULL);
        do_bands(&s, 0, image);
    }
    if (!collect(desk, &s, image) && status == SC_OK && !*desk->interrupt)
        status = sc_fail(&desk->ctx, SC_ERR_INTERNAL, "a rank cannot draw its part of the picture");
    return status;
}

/* ---- other ranks than rank 0 ---- */

/* Body of the thread that draws. */
static void *run(void *user)
{
    share *s = user;

    do_bands(s, sc_comm_rank(s->desk->app.comm), NULL);
    s->is_done = 1;
    return NULL;
}

/* @return whether there is an order. */
static bool hears(const sc_desk *desk, sc_order *out)
{
    sc_message message;

    if (!sc_comm_poll(desk->app.comm, &message))
        return false;
    sc_comm_receive(desk->app.comm, &message, out);
    return true;
}

/* Draw what is ordered, and send it to rank 0. */
static void draw(sc_desk *desk, const sc_order *o)
{
    static const char nothing = 0;
    SC_OWN(clear_share) share s = {0};
    const sc_status room = make_room(desk, o, &s);
    pthread_t thread;
    sc_order next;

    if (begin(desk, o) != SC_OK || room != SC_OK) {
        sc_comm_post(desk->app.comm, 0, TAG_ROWS, &nothing, 1);
        return;
    }
    if (pthread_create(&thread, NULL, run, &s)) {
        (void)run(&s);
    } else {
        while (!s.is_done) {
            if (!hears(desk, &next))
                sc_sleep_s(NAP_S);
            else if (next.what == SC_ORDER_GIVE_UP)
                *desk->interrupt = 1;
        }
        pthread_join(thread, NULL);
    }
    *desk->interrupt = 0;
    sc_comm_post(desk->app.comm, 0, TAG_ROWS, s.rows, s.bytes);
    sc_comm_flush(desk->app.comm);
}

void sc_desk_obey(sc_desk *desk, const atomic_int *stop)
{
    bool asks = false;
    double nap_s = NAP_S;
    sc_order o = {.what = SC_ORDER_FOLLOW};

    while (o.what != SC_ORDER_END) {
        if (*stop && !asks) /* rank 0 need not have got the signal */
            sc_comm_post(desk->app.comm, 0, TAG_STOP, NULL, 0);
        asks = asks || *stop;
        if (!hears(desk, &o)) {
            sc_sleep_s(nap_s);
            nap_s = fmin(1.5 * nap_s, NAP_LONGEST_S);
            continue;
        }
        nap_s = NAP_S;
        if (o.what == SC_ORDER_FOLLOW)
            (void)sc_desk_follow(desk, &desk->steps.now);
        else if (o.what == SC_ORDER_RELOAD)
            (void)sc_desk_reload(desk);
        else if (o.what == SC_ORDER_DRAW)
            draw(desk, &o);
    }
}

bool sc_desk_is_asked_to_stop(sc_desk *desk)
{
    sc_message message;

    while (sc_comm_poll(desk->app.comm, &message)) {
        sc_comm_receive(desk->app.comm, &message, NULL);
        desk->is_asked_to_stop = true;
    }
    return desk->is_asked_to_stop;
}
