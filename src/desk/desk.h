/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to desk: the job that is looked at, and what pages have changed in it. All of it belongs
 * to the one thread that answers calls. */
#ifndef SC_DESK_DESK_H
#define SC_DESK_DESK_H

#include "http.h"
#include "segcast/desk.h"

/* ---- edits.c ---- */

/* A change of the job: a key and its value, as of --set. Owns both. */
typedef struct sc_edit {
    char *path, *value;
} sc_edit;
/* Changes, in their order. Zero-initialise; sc_edits_clear frees. */
typedef struct sc_edits {
    sc_edit *all; /* [count] */
    size_t count, room;
} sc_edits;
void sc_edits_clear(sc_edits *edits);
/* Copy all. @param out empty; cleared by the caller also after an error. */
sc_status sc_edits_copy(const sc_ctx *ctx, const sc_edits *from, sc_edits *out);
/* Add a change, which replaces those before it of the same key, or of keys within it. @param value
 * NULL: only remove those, so that the key is what the file says. */
sc_status sc_edits_add(const sc_ctx *ctx, sc_edits *edits, const char *path, const char *value);

/* The changes, and those before each step and after it, for undo and redo. */
enum { SC_STEPS_MAX = 200 };
typedef struct sc_steps {
    sc_edits now;
    sc_edits undo[SC_STEPS_MAX], redo[SC_STEPS_MAX]; /* the last one is on top */
    int undo_count, redo_count;
    char group[64]; /* what the last step belongs to: more of it is the same step; empty: nothing */
} sc_steps;
void sc_steps_clear(sc_steps *steps);
/* Begin a step whose result is *next, which the history takes over. @param group see sc_steps. */
void sc_steps_begin(sc_steps *steps, const char *group, sc_edits *next);
/* Go a step back, or forward. @return whether there was one. */
bool sc_steps_go(sc_steps *steps, bool back);

/* ---- the desk ---- */

/* A picture that is shown. */
typedef struct sc_shown {
    int size_px[2];
    double scale;    /* of a sketch: its size as a share of this */
    double s_per_px; /* what a pixel of a sketch has taken lately */
} sc_shown;

/* Messages of the job, as `segcast check` tells them. */
typedef struct sc_notes {
    json_t *list; /* of strings */
    int errors;
} sc_notes;

/* The file of the job. */
typedef struct sc_job_file {
    char *path;     /* owned */
    char *on_disk;  /* what stood there when it was read or written last; NULL: nothing; owned */
    uint64_t saved; /* hash of the changes that were saved */
} sc_job_file;

/* A run of segcast that the page has started. */
typedef struct sc_rendering {
    pid_t process; /* 0: none */
    FILE *said;    /* what it writes to standard error; NULL: none was started */
    int exit_code; /* of the last one */
} sc_rendering;

/* A call that waits for news. */
typedef struct sc_waiting {
    sc_call *call;
    double since_s;
} sc_waiting;
enum { SC_WAITING_MAX = 64 }; /* as many pages may look on */
typedef struct sc_waiting_list {
    sc_waiting all[SC_WAITING_MAX]; /* [count] */
    int count;
} sc_waiting_list;

/* How the volumes are prepared. */
typedef struct sc_desk_volumes {
    struct sc_preparing *preparing; /* NULL: nothing is being prepared */
    bool failed;                    /* and will again, until something is changed */
    sc_job prepared;                /* as which job they are prepared */
    bool fit;                       /* they are prepared as the job asks now */
} sc_desk_volumes;

/* What pictures are drawn with. */
typedef struct sc_desk_sessions {
    sc_session *base; /* owns volumes, and what is drawn from them; NULL: not loaded yet */
    sc_session *now;  /* that of the job as it is now; may borrow from base, or be base */
    bool is_nudged;   /* changes were put into it as it is: see sc_desk_settle */
    bool is_lit;      /* light was gathered for what is shown, or was not asked for */
} sc_desk_sessions;

typedef struct sc_desk {
    sc_app app; /* whose context collects messages in notes */
    sc_ctx ctx;
    const sc_ctx *outer; /* that of the command */
    const sc_desk_plan *plan;
    sc_http *http;
    atomic_int may_interrupt, *interrupt; /* see sc_http_settings; the latter is of sessions, too */
    bool is_asked_to_stop;                /* by another rank */
    sc_steps steps;
    sc_notes notes;
    sc_desk_volumes volumes;
    sc_desk_sessions sessions;
    long revision;  /* counts changes */
    int size_px[2]; /* of the frames of the job, whatever the pictures that are shown have */
    int frame;      /* at which the film is looked at */
    sc_shown shown;
    sc_job_file file; /* where the job is saved */
    sc_rendering rendering;
    sc_waiting_list waits;
    double changed_s; /* when something was changed for the last time */
} sc_desk;

/* ---- session.c ---- */

/* Fill @p out with the sources of the job with @p edits. @param settings room for as many. */
sc_job_sources sc_desk_sources(const sc_desk *desk, const sc_edits *edits, sc_setting *settings);
/* Read and check the job with these edits. @param out caller owns: sc_job_clear. @return as
 * sc_job_load. */
sc_status sc_desk_read(sc_desk *desk, const sc_edits *edits, sc_job *out);
/* Make desk->sessions.now anew, for the job with these edits and the size of the picture. It stays
 * as it was after an error, which is in the notes. Collective, as are sc_desk_reload and
 * sc_desk_draw: rank 0 requests it from the others, whose own arguments are ignored. */
sc_status sc_desk_follow(sc_desk *desk, const sc_edits *edits);
/* The same, with volumes that are loaded anew. */
sc_status sc_desk_reload(sc_desk *desk);
/* Free both sessions. */
void sc_desk_close(sc_desk *desk);

/* ---- orders.c ---- */

typedef enum sc_order_kind {
    SC_ORDER_FOLLOW,
    SC_ORDER_RELOAD,
    SC_ORDER_DRAW,
    SC_ORDER_GIVE_UP,
    SC_ORDER_END
} sc_order_kind;
enum { SC_TAG_ORDER }; /* of messages; larger ones are of ranks.c */
/* A request of rank 0 to the other ranks. All members but the first are for SC_ORDER_DRAW only. */
typedef struct sc_order {
    sc_order_kind what;
    int frame, size_px[2]; /* of the picture */
    bool hurries;
    bool is_nudged; /* camera or planes have moved since the session was made */
} sc_order;
/* Send a request to all other ranks; does nothing if called on one of those. */
void sc_desk_tell(const sc_desk *desk, const sc_order *order);

/* ---- ranks.c ---- */

/* Draw frame @p frame to @p image: as it is asked for, or in a hurry. After *desk->interrupt was
 * set, what is drawn is of no use. */
sc_status sc_desk_draw(sc_desk *desk, int frame, bool hurries, sc_image *image);
/* Do what rank 0 orders until that is to end. @param stop rank 0 is asked to end when it is set. */
void sc_desk_obey(sc_desk *desk, const atomic_int *stop);
/* @return whether another rank has asked rank 0 to end. */
bool sc_desk_is_asked_to_stop(sc_desk *desk);

/* ---- nudge.c ---- */

/* If changes, pairs of key and value, are of the camera or of planes alone, put the job of @p
 * edits, which holds them, into the session as it is. @param done whether that was so simple;
 * otherwise nothing has changed. @return as sc_job_load. */
sc_status sc_desk_nudge(sc_desk *desk, const json_t *pairs, const sc_edits *edits, bool *done);
/* Make the session anew if that was done. */
void sc_desk_settle(sc_desk *desk);

/* ---- prepare.c ---- */

/* If the volumes do not fit, begin to prepare them anew as the job asks now, on a thread of its
 * own; meanwhile those that there are are drawn. */
void sc_desk_begin_preparing(sc_desk *desk);
/* Take what that thread has prepared, if it has ended. @return whether there is anything new to
 * see. */
bool sc_desk_take_prepared(sc_desk *desk);
/* Wait for the thread, and drop what it has prepared. */
void sc_desk_drop_preparing(sc_desk *desk);

/* ---- state.c ---- */

/* @return all that pages show of the job; NULL: no memory. */
json_t *sc_desk_state(sc_desk *desk);
/* @return what a picture of a scene shows; NULL: no memory. @param more the same picture follows,
 * lit as the job asks. */
json_t *sc_desk_view_of(const sc_desk *desk, const sc_scene *scene, bool more);
/* @return what a picture shows: the camera and the planes of its frame; NULL: no memory. */
json_t *sc_desk_view(sc_desk *desk, bool more);

/* ---- pictures.c ---- */

/* Draw a picture in a hurry, and answer @p call with it as JPEG. */
void sc_desk_sketch(sc_desk *desk, sc_call *call);
/* Draw the picture, or for a sheet that of another frame, as `segcast still` does, and answer @p
 * call with it as PNG. Where light has to be gathered first, which takes seconds, a picture in
 * plain light comes before it. @return false if it was given up, and not answered. */
bool sc_desk_refine(sc_desk *desk, sc_call *call);
/* Tell what is seen at a point of the picture. */
void sc_desk_pick(sc_desk *desk, sc_call *call);
/* Draw one of the three slices. */
void sc_desk_slice(sc_desk *desk, sc_call *call);

/* ---- save.c ---- */

/* Begin with the file that the plan names. */
sc_status sc_desk_open_file(sc_desk *desk);
/* @return whether there are changes that were not saved. */
bool sc_desk_is_unsaved(const sc_desk *desk);
/* Save the job, or tell what would change in the file that is there. */
void sc_desk_save(sc_desk *desk, sc_call *call);

/* ---- rendering.c ---- */

/* Start `segcast render` of the saved job. */
void sc_desk_render(sc_desk *desk, sc_call *call);
/* Tell how far that is. */
void sc_desk_rendering(sc_desk *desk, sc_call *call);
/* Answer with the video. */
void sc_desk_film(sc_desk *desk, sc_call *call);
/* End what was started. */
void sc_desk_end_rendering(sc_desk *desk);

/* ---- answers.c ---- */

/* Keep a message for the page: for sc_ctx.write, with sc_notes as user. */
void sc_desk_note(void *user, sc_log_level level, const char *text);

/* Answer that something is not as it has to be: with the messages, or @p why. */
void sc_desk_refuse(sc_desk *desk, sc_call *call, const char *why);
/* @return the frame that is asked for, within the film; without one that which is looked at. */
int sc_desk_frame(const sc_desk *desk, const json_t *body);
/* Read a size in pixels from the member "size" of what is asked. @return whether it is one. */
bool sc_desk_size(json_t *body, int out[2]);

#endif
