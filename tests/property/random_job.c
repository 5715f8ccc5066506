/* SPDX-License-Identifier: BSD-3-Clause */
/* Writes a job file of random verbs, shots, overlays and other subjects for property.films, the
 * same for the same numbers on any machine. usage: random_job SEED NUMBER    the job to standard
 * output; its inputs are those that films.sh makes random_job --keys         all keys of which jobs
 * are made, one on a line */
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COUNT_OF(array) (sizeof(array) / sizeof *(array))

enum { FRAMES = 4, SHOTS_MAX = 3, VERBS = 3 };

/* What a job is about beside its verbs; each is the subject of every sixth job. */
enum subject { PLAIN, SHOTS, CINE, COMPARE, IMAGE, VALUES, SUBJECTS };

/* The job that is being written. */
struct maker {
    uint64_t state;   /* of the generator of random numbers */
    char text[32768]; /* the job so far */
    size_t length;    /* of text */
    enum subject subject;
    uint64_t number; /* of the job */
    int fps;         /* frames per second */
    int frames;      /* of the animation that is being written */
    int planes;      /* clip planes of that animation */
    bool is_turning; /* its camera is an orbit with turns, which hold needs */
    bool is_orthographic;
    bool has_image;
    bool is_in_shot;     /* what is being written belongs to a shot */
    bool is_measured;    /* color_by: by a measure, not by a table */
    bool is_transparent; /* no background */
    bool has_floor;      /* with it light is gathered, or comes by paths */
    int way;             /* of a flight: through tissues, from middle to middle, points */
};

/* A key of a map and what writes its value. A function that writes nothing leaves the key out. */
struct row {
    const char *key;
    int percent; /* how often the key is there */
    void (*value)(struct maker *maker, const char *arg);
    const char *arg;
};

/* ---- random numbers and text ---- */

static uint64_t random_bits(struct maker *maker) /* splitmix64 */
{
    uint64_t bits = maker->state += 0x9e3779b97f4a7c15u;

    bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9u;
    bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebu;
    return bits ^ (bits >> 31);
}

/* @return a number from @p low to @p high, both included. */
static int whole(struct maker *maker, int low, int high)
{
    return low + (int)(random_bits(maker) % (uint64_t)(high - low + 1));
}

static bool chance(struct maker *maker, int percent)
{
    return whole(maker, 1, 100) <= percent;
}

__attribute__((format(printf, 2, 3))) static void add(struct maker *maker, const char *format, ...)
{
    const size_t room = sizeof maker->text - maker->length;
    va_list args;
    int length;

    va_start(args, format);
    length = vsnprintf(maker->text + maker->length, room, format, args);
    va_end(args);
    if (length < 0 || (size_t)length >= room) {
        fprintf(stderr, "random_job: the job is longer than %zu bytes\n", sizeof maker->text);
        exit(1);
    }
    maker->length += (size_t)length;
}

/* Add the rows of a map that chance chooses: "{key: value, key: value}". */
static void add_map(struct maker *maker, const struct row *rows, size_t count)
{
    const char *separator = "";

    add(maker, "{");
    for (size_t i = 0; i < count; i++) {
        const size_t before = maker->length;
        size_t after;

        if (!chance(maker, rows[i].percent))
            continue;
        add(maker, "%s%s: ", separator, rows[i].key);
        after = maker->length;
        rows[i].value(maker, rows[i].arg);
        if (maker->length == after) {
            maker->length = before;
            maker->text[before] = '\0';
        } else {
            separator = ", ";
        }
    }
    add(maker, "}");
}

/* ---- values ---- */

/* One of the words of @p arg, which a | separates. */
static void put_word(struct maker *maker, const char *arg)
{
    int words = 1;

    for (const char *at = arg; *at; at++)
        words += *at == '|';
    for (int skipped = whole(maker, 0, words - 1); skipped > 0; skipped--)
        arg = strchr(arg, '|') + 1;
    add(maker, "%.*s", (int)strcspn(arg, "|"), arg);
}

static void put_flag(struct maker *maker, const char *arg)
{
    put_word(maker, "true|false");
}

/* @return a number in the range "LOW:HIGH" of @p arg. */
static double in_range(struct maker *maker, const char *arg)
{
    char *colon;
    const double low = strtod(arg, &colon);

    return low + (strtod(colon + 1, NULL) - low) * whole(maker, 0, 1000) / 1000;
}

static void put_number(struct maker *maker, const char *arg)
{
    add(maker, "%.4g", in_range(maker, arg));
}

static void put_whole(struct maker *maker, const char *arg)
{
    add(maker, "%.0f", in_range(maker, arg));
}

static void put_share(struct maker *maker, const char *arg)
{
    add(maker, "%.3g%%", in_range(maker, arg));
}

/* The time of @p tenths tenths of the animation, whose last frame is the end, in any of the ways to
 * write one. */
static void put_time(struct maker *maker, int tenths)
{
    const double frames = (maker->frames - 1) * tenths / 10.0, seconds = frames / maker->fps;

    switch (whole(maker, 0, 4)) {
    case 0:
        if (frames == (int)frames) {
            add(maker, "%.0ff", frames);
            break;
        }
        /* fall through */
    case 1:
        add(maker, "%.6g s", seconds);
        break;
    case 2:
        add(maker, "%.6g ms", 1000 * seconds);
        break;
    case 3:
        if (seconds == (int)seconds) {
            add(maker, "0:%02.0f", seconds);
            break;
        }
        /* fall through */
    default:
        add(maker, "%d%%", 10 * tenths);
    }
}

/* A part of the animation, of at least as many tenths as @p arg says (1 without). */
static void put_during(struct maker *maker, const char *arg)
{
    const int least = arg ? atoi(arg) : 1, begin = whole(maker, 0, 9 - least);
    const int end = begin + whole(maker, least, 10 - begin - (begin == 0));

    add(maker, "[");
    put_time(maker, begin);
    add(maker, ", ");
    put_time(maker, end);
    add(maker, "]");
}

static void put_ease(struct maker *maker, const char *arg)
{
    if (chance(maker, 70))
        put_word(maker, "linear|smooth|in|out");
    else
        add(maker, "[0.%d, 0.%d, 0.%d, 1]", whole(maker, 0, 9), whole(maker, 0, 9),
            whole(maker, 0, 9));
}

/* A number in a range, or key frames of some. */
static void put_track(struct maker *maker, const char *arg)
{
    int at = whole(maker, 0, 4);

    if (chance(maker, 50)) {
        put_number(maker, arg);
        return;
    }
    add(maker, "{");
    for (int i = 0; i < 3 && at <= 10; i++, at += whole(maker, 1, 4)) {
        add(maker, "%s", i ? ", " : "");
        put_time(maker, at);
        add(maker, ": {value: ");
        put_number(maker, arg);
        if (chance(maker, 50)) {
            add(maker, ", ease: ");
            put_ease(maker, NULL);
        }
        add(maker, "}");
    }
    add(maker, "}");
}

#define TISSUES                                                                                    \
    "aorta|coronary arteries|pulmonary artery|left ventricle|\"*ventricle\"|\"*atri*\"|"           \
    "\"* vena cava\"|\"*myocardium\"|18|\"*valve\"|interventricular septum"

/* A tissue, or some of them. */
static void put_tissues(struct maker *maker, const char *arg)
{
    if (chance(maker, 25)) {
        add(maker, "\"*\"");
    } else if (chance(maker, 40)) {
        put_word(maker, TISSUES);
    } else {
        add(maker, "[");
        put_word(maker, "aorta|11|right ventric*|\"* vena cava\"");
        add(maker, ", ");
        put_word(maker, TISSUES);
        add(maker, "]");
    }
}

static void put_tissue_list(struct maker *maker, const char *arg)
{
    add(maker, "[");
    put_word(maker, TISSUES);
    add(maker, "]");
}

static void put_names(struct maker *maker, const char *arg)
{
    if (chance(maker, 60))
        put_word(maker, "all|none|all");
    else
        put_tissue_list(maker, NULL);
}

static void put_opacity(struct maker *maker, const char *arg)
{
    if (chance(maker, 30))
        add(maker, "0");
    else if (chance(maker, 50))
        put_number(maker, "0:1");
    else
        put_share(maker, arg);
}

static void put_position(struct maker *maker, const char *arg)
{
    if (chance(maker, 70))
        put_share(maker, arg);
    else
        add(maker, "%d mm", whole(maker, -30, 40));
}

/* A direction whose components are all unlike 0, so that it is none of the words. */
static void put_vector(struct maker *maker, const char *arg)
{
    add(maker, "[0.%d, -0.%d, 0.%d]", whole(maker, 1, 9), whole(maker, 1, 9), whole(maker, 1, 9));
}

static void put_direction(struct maker *maker, const char *arg)
{
    if (chance(maker, 75))
        put_word(maker, "left|right|anterior|posterior|superior|inferior");
    else
        put_vector(maker, arg);
}

static void put_point(struct maker *maker, const char *arg)
{
    add(maker, "[%d, %d, %d]", whole(maker, -40, 40), whole(maker, -30, 30), whole(maker, -40, 40));
}

/* A point, or key frames of two. */
static void put_point_track(struct maker *maker, const char *arg)
{
    if (chance(maker, 60)) {
        put_point(maker, arg);
        return;
    }
    add(maker, "{");
    put_time(maker, whole(maker, 0, 4));
    add(maker, ": ");
    put_point(maker, arg);
    add(maker, ", ");
    put_time(maker, whole(maker, 5, 10));
    add(maker, ": ");
    put_point(maker, arg);
    add(maker, "}");
}

static void put_color(struct maker *maker, const char *arg)
{
    if (chance(maker, 50))
        put_word(maker, "red|dark orange|\"#0f8\"|\"#102030\"|[1.0, 0.5, 0]");
    else
        add(maker, "[%d, %d, %d]", whole(maker, 0, 255), whole(maker, 0, 255),
            whole(maker, 0, 255));
}

static void put_text(struct maker *maker, const char *arg)
{
    put_word(maker, "The heart|\"Cœur\"|\"two\\nlines\"|\"心\"|\"1 %: [b]\"");
}

#define PLACES "top-left|top|top-right|bottom-left|bottom|bottom-right"

/* A text, or key frames of some, each of which is shown in a frame. */
static void put_line(struct maker *maker, const char *arg)
{
    const int tenths_per_frame = (10 + maker->frames - 2) / (maker->frames - 1); /* rounded up */
    const int at = whole(maker, 1, 4);

    if (chance(maker, 50)) {
        put_text(maker, arg);
        return;
    }
    add(maker, "{0%%: %s, ", chance(maker, 50) ? "none" : "first");
    put_time(maker, at);
    add(maker, ": ");
    put_text(maker, arg);
    add(maker, ", ");
    put_time(maker, whole(maker, at + tenths_per_frame < 5 ? 5 : at + tenths_per_frame, 9));
    add(maker, ": %s}", chance(maker, 50) ? "none" : "last");
}

static void put_captions(struct maker *maker, const char *arg)
{
    static const char *const places[] = {"bottom",   "top",         "bottom-right",
                                         "top-left", "bottom-left", "top-right"};
    const int first = whole(maker, 0, 5), count = whole(maker, 0, 3);

    if (!count) {
        put_line(maker, arg);
        return;
    }
    for (int i = 0; i < count; i++) {
        add(maker, "%s%s: ", i ? ", " : "{", places[(first + i) % (int)COUNT_OF(places)]);
        put_line(maker, arg);
    }
    add(maker, "}");
}

static void put_color_bar(struct maker *maker, const char *arg)
{
    if (maker->subject == VALUES)
        put_word(maker, arg);
}

/* ---- verbs ---- */

static void put_plane(struct maker *maker, const char *arg)
{
    add(maker, "%d", whole(maker, 1, maker->planes));
}

static void put_fly(struct maker *maker, const char *arg)
{
    if (maker->way == 0)
        put_word(maker, "aorta|[aorta]");
    if (maker->way == 1)
        put_word(maker, "[left atrium, left ventricle]|[left ventricle, aorta]");
    if (maker->way != 2)
        return;
    add(maker, "[");
    put_point(maker, arg);
    add(maker, ", [70, %d, 50], ", whole(maker, -20, 20));
    put_point(maker, arg);
    add(maker, "]");
}

static void put_through(struct maker *maker, const char *arg)
{
    if (maker->way == 1)
        add(maker, "middles");
}

/* The first row of each verb is its own. */
#define DURING                                                                                     \
    {                                                                                              \
        "during", 80, put_during, NULL                                                             \
    }
#define EASE                                                                                       \
    {                                                                                              \
        "ease", 50, put_ease, NULL                                                                 \
    }
static const struct row fade_rows[] = {
    {"fade", 100, put_tissues, NULL}, {"to", 80, put_opacity, "0:150"}, DURING, EASE};
static const struct row appear_rows[] = {
    {"appear", 100, put_tissues, NULL},
    {"order", 60, put_word,
     "list|largest|smallest|right|left|anterior|posterior|superior|inferior"},
    {"stagger", 60, put_share, "0:100"},
    DURING,
    EASE,
};
static const struct row pulse_rows[] = {{"pulse", 100, put_tissues, NULL},
                                        {"to", 60, put_opacity, "0:100"},
                                        {"times", 60, put_whole, "1:4"},
                                        DURING,
                                        EASE};
static const struct row orbit_verb_rows[] = {{"orbit", 100, put_number, "-200:200"},
                                             {"elevation", 60, put_number, "-120:120"},
                                             DURING,
                                             EASE};
static const struct row rock_rows[] = {{"rock", 100, put_number, "-50:50"},
                                       {"elevation", 50, put_number, "-100:100"},
                                       {"times", 60, put_whole, "1:3"},
                                       DURING,
                                       EASE};
static const struct row zoom_verb_rows[] = {{"zoom", 100, put_number, "0.4:3"}, DURING, EASE};
static const struct row dolly_rows[] = {{"dolly", 100, put_number, "0.1:2"}, DURING, EASE};
static const struct row hold_rows[] = {
    {"hold", 100, put_word, "orbit"},
    {"during", 100, put_during, NULL},
    {"soft", 60, put_share, "0:50"},
};
static const struct row frame_rows[] = {{"frame", 100, put_tissues, NULL}, DURING, EASE};
static const struct row fly_rows[] = {
    {"fly", 100, put_fly, NULL},
    {"through", 100, put_through, NULL},
    {"ahead", 50, put_share, "1:40"},
    {"clearance", 50, put_share, "0:100"},
    {"fov", 50, put_number, "20:140"},
    {"during", 70, put_during, NULL},
    EASE,
};
static const struct row turn_rows[] = {
    {"turn", 100, put_number, "-200:200"},
    {"plane", 60, put_plane, NULL},
    {"axis", 50, put_vector, NULL},
    {"center", 40, put_point, NULL},
    DURING,
    EASE,
};
static const struct row explode_rows[] = {
    {"explode", 100, put_tissues, NULL},
    {"by", 70, put_position, "-60:120"},
    {"center", 40, put_point, NULL},
    {"axis", 40, put_direction, NULL},
    {"together", 40, put_flag, NULL},
    DURING,
    EASE,
};

static const struct verb {
    const struct row *rows;
    size_t count;
} verbs[] = {
#define VERB(rows)                                                                                 \
    {                                                                                              \
        rows, COUNT_OF(rows)                                                                       \
    }
    VERB(fade_rows),  VERB(appear_rows),    VERB(pulse_rows), VERB(orbit_verb_rows),
    VERB(rock_rows),  VERB(zoom_verb_rows), VERB(dolly_rows), VERB(hold_rows),
    VERB(frame_rows), VERB(fly_rows),       VERB(turn_rows),  VERB(explode_rows),
};

/* ---- camera, planes, slices ---- */

/* A camera that turns, as hold needs, does not turn by 0. */
static void put_turns(struct maker *maker, const char *arg)
{
    double turns;

    if (!maker->is_turning)
        return;
    do
        turns = in_range(maker, arg);
    while (turns > -0.01 && turns < 0.01);
    add(maker, "%.4g", turns);
}

static const struct row orbit_rows[] = {
    {"axis", 30, put_direction, NULL},        {"turns", 100, put_turns, "-2:2"},
    {"angle", 100, put_track, "-200:200"},    {"elevation", 50, put_track, "-90:120"},
    {"target_mm", 20, put_point_track, NULL}, {"distance_mm", 20, put_track, "150:600"},
};
static const struct row fixed_rows[] = {
    {"position_mm", 100, put_word, "[10, 400, 30]|[-300, 200, 80]|[0, 0, 0]"},
    {"target_mm", 100, put_word, "[1, -1, 2]|[5, -20, -1]"},
    {"up", 50, put_direction, NULL},
};
static void add_camera(struct maker *maker)
{
    add(maker, "{");
    if (maker->is_turning || chance(maker, 75)) {
        add(maker, "orbit: ");
        add_map(maker, orbit_rows, COUNT_OF(orbit_rows));
    } else {
        add(maker, "fixed: ");
        add_map(maker, fixed_rows, COUNT_OF(fixed_rows));
    }
    add(maker, ", projection: %s", maker->is_orthographic ? "orthographic" : "perspective");
    if (chance(maker, 40)) {
        add(maker, ", fov: ");
        put_track(maker, "10:80");
    }
    if (chance(maker, 40)) {
        add(maker, ", zoom: ");
        put_track(maker, "0.6:3");
    }
    if (!maker->is_orthographic && chance(maker, 25)) {
        add(maker, ", aperture_mm: ");
        put_number(maker, "1:40");
    }
    if (chance(maker, 25)) {
        add(maker, ", focus: ");
        put_word(maker, "middle|[10, 0, 20]|\"*\"");
    }
    if (chance(maker, 25)) {
        add(maker, ", shutter: ");
        put_number(maker, "0:1");
    }
    add(maker, "}");
}

static void put_corner(struct maker *maker, const char *arg)
{
    add(maker, "[");
    put_share(maker, arg);
    add(maker, ", ");
    put_share(maker, arg);
    add(maker, ", ");
    put_share(maker, arg);
    add(maker, "]");
}

static void put_box(struct maker *maker, const char *arg)
{
    add(maker, "[");
    put_corner(maker, "0:40");
    add(maker, ", ");
    put_corner(maker, "60:100");
    add(maker, "]");
}

/* Key frames of the scene: two or three, of what @p put writes. Their times are shares, since what
 * a film has holds for shots of any length. @param can_ease whether values change between them. */
static void put_scene_track(struct maker *maker, void (*put)(struct maker *maker, const char *arg),
                            const char *arg, bool can_ease)
{
    int at = whole(maker, 0, 5);

    add(maker, "{");
    for (int i = 0; i < 3 && at <= 10; i++, at += whole(maker, 1, 5)) {
        add(maker, "%s%d%%: ", i ? ", " : "", 10 * at);
        put(maker, arg);
    }
    if (can_ease && chance(maker, 50)) {
        add(maker, ", ease: ");
        put_ease(maker, NULL);
    }
    add(maker, "}");
}

/* True or false, or key frames of such. */
static void put_active(struct maker *maker, const char *arg)
{
    if (chance(maker, 20))
        put_word(maker, arg);
    else
        put_scene_track(maker, put_word, arg, false);
}

/* A position, or key frames of some. */
static void put_position_track(struct maker *maker, const char *arg)
{
    if (chance(maker, 50))
        put_position(maker, arg);
    else
        put_scene_track(maker, put_position, arg, true);
}

/* A list of tissues, or key frames of two. */
static void put_exceptions(struct maker *maker, const char *arg)
{
    if (chance(maker, 60)) {
        put_tissue_list(maker, NULL);
        return;
    }
    add(maker, "{");
    put_time(maker, whole(maker, 0, 4));
    add(maker, ": ");
    put_tissue_list(maker, NULL);
    add(maker, ", ");
    put_time(maker, whole(maker, 5, 9));
    add(maker, ": ");
    if (chance(maker, 50))
        add(maker, "[]");
    else
        put_tissue_list(maker, NULL);
    add(maker, "}");
}

static const struct row plane_rows[] = {
    {"normal", 100, put_direction, NULL},
    {"at", 70, put_position_track, "10:60"},
    {"active", 30, put_active, "true|false"},
    {"except", 40, put_exceptions, NULL},
};
static const struct row point_plane_rows[] = {
    {"normal", 100, put_direction, NULL},
    {"at", 100, put_point, NULL},
    {"except", 40, put_exceptions, NULL},
};
static const struct row box_rows[] = {
    {"box", 100, put_box, NULL},
    {"except", 40, put_exceptions, NULL},
};
/* Up to two clip entries; the caller has set the number of planes to what verbs need at least. */
static void add_clip(struct maker *maker)
{
    const int entries = whole(maker, maker->planes, 2);

    maker->planes = 0;
    if (entries)
        add(maker, "  clip_mode: %s\n  clip:\n", chance(maker, 70) ? "keep" : "cut");
    for (int i = 0; i < entries; i++) {
        const int kind = whole(maker, 0, 5);

        add(maker, "    - ");
        if (kind < 4)
            add_map(maker, plane_rows, COUNT_OF(plane_rows));
        else if (kind == 4)
            add_map(maker, point_plane_rows, COUNT_OF(point_plane_rows));
        else
            add_map(maker, box_rows, COUNT_OF(box_rows));
        maker->planes += kind == 5 ? 6 : 1;
        add(maker, "\n");
    }
}

static void put_share_track(struct maker *maker, const char *arg)
{
    if (chance(maker, 50))
        put_share(maker, arg);
    else
        put_scene_track(maker, put_share, arg, true);
}

static void put_slices(struct maker *maker, const char *arg)
{
    if (chance(maker, 20))
        put_word(maker, "none|through");
    else if (chance(maker, 30))
        put_point(maker, NULL);
    else
        put_share_track(maker, arg);
}

static const struct row slices_rows[] = {{"slices", 80, put_slices, "0:100"}};

/* The lines of an animation. Verbs come in turn, so that few jobs have them all. */
static void add_animation(struct maker *maker, uint64_t turn)
{
    const struct verb *chosen[VERBS];
    char indented[sizeof maker->text];
    size_t begin;

    maker->is_turning = chance(maker, 40);
    maker->is_orthographic = chance(maker, 30);
    maker->planes = 0;
    for (size_t i = 0; i < VERBS; i++) {
        chosen[i] = &verbs[(turn * VERBS + i) % COUNT_OF(verbs)];
        maker->is_turning |= chosen[i]->rows == hold_rows;
        maker->is_orthographic &= chosen[i]->rows != dolly_rows;
        if (chosen[i]->rows == turn_rows)
            maker->planes = 1;
    }
    begin = maker->length;
    if (chance(maker, 50))
        add(maker, "  frames: %d\n", maker->frames);
    else
        add(maker, "  frames: %.6g s\n", (double)maker->frames / maker->fps);
    add(maker, "  camera: ");
    add_camera(maker);
    add(maker, "\n");
    add_clip(maker);
    if (maker->subject != COMPARE && chance(maker, 30)) {
        add(maker, "  slices: ");
        put_slices(maker, slices_rows[0].arg);
        add(maker, "\n");
    }
    add(maker, "  verbs:\n");
    for (size_t i = 0; i < VERBS; i++) {
        maker->way = whole(maker, 0, 2);
        add(maker, "    - ");
        add_map(maker, chosen[i]->rows, chosen[i]->count);
        add(maker, "\n");
    }
    if (!maker->is_in_shot)
        return;
    strcpy(indented, maker->text + begin); /* a shot stands further to the right */
    maker->length = begin;
    for (const char *line = indented; *line; line = strchr(line, '\n') + 1)
        add(maker, "    %.*s\n", (int)strcspn(line, "\n"), line);
}

/* ---- everything else of a job ---- */

static void put_legend(struct maker *maker, const char *arg)
{
    if (chance(maker, 70)) {
        put_word(maker, PLACES);
        return;
    }
    add(maker, "{");
    put_word(maker, PLACES);
    add(maker, ": ");
    put_tissue_list(maker, arg);
    add(maker, "}");
}

static void put_logo(struct maker *maker, const char *arg)
{
    if (chance(maker, 50)) {
        add(maker, "logo.png");
        return;
    }
    add(maker, "{");
    put_word(maker, PLACES);
    add(maker, ": logo.png}");
}

static const struct row overlay_rows[] = {
    {"caption", 50, put_captions, NULL},
    {"time", 30, put_word, PLACES "|none"},
    {"scale_bar", 40, put_word, PLACES},
    {"color_bar", 60, put_color_bar, PLACES},
    {"orientation", 40, put_word, PLACES},
    {"legend", 40, put_legend, NULL},
    {"names", 50, put_names, NULL},
    {"names_size", 30, put_number, "2:8"},
    {"logo", 30, put_logo, NULL},
    {"logo_size", 50, put_number, "5:30"},
    {"text_size", 40, put_number, "2:5"},
    {"font", 20, put_word, "DejaVu Sans|serif|DejaVu Sans Mono"},
};

/* Without a background are all shots, or none. */
static void put_background(struct maker *maker, const char *arg)
{
    if (maker->is_transparent)
        return;
    if (chance(maker, 70))
        put_color(maker, arg);
    else
        add(maker, "auto");
}

static void put_film_background(struct maker *maker, const char *arg)
{
    if (maker->is_transparent)
        add(maker, "none");
    else
        put_background(maker, arg);
}

static void put_stage(struct maker *maker, const char *arg)
{
    if (maker->has_floor)
        put_word(maker, arg);
}

static void put_surface(struct maker *maker, const char *arg)
{
    if (!maker->has_floor)
        put_word(maker, arg);
}

static void put_method(struct maker *maker, const char *arg)
{
    if (maker->has_floor)
        put_word(maker, "global|global|path");
    else if (chance(maker, 40))
        put_word(maker, arg);
}

#define LOOK_OF_RENDER                                                                             \
    {"caps", 30, put_word, "none|solid"}, {"cap_outline", 30, put_number, "0:1"},                  \
        {"quality", 70, put_word, "draft|film|still"},                                             \
    {                                                                                              \
        "auto_opacity", 30, put_word, "measured|paper|local|local-paper"                           \
    }

static const struct row render_of_shot_rows[] = {
    {"background", 30, put_background, NULL},
    LOOK_OF_RENDER,
};
static const struct row render_rows[] = {
    {"background", 100, put_film_background, NULL},
    LOOK_OF_RENDER,
    {"stage", 100, put_stage, "floor|cove|none"},
    {"surface", 40, put_surface, "voxel|smooth"},
    {"smooth", 30, put_number, "0:2.5"},
    {"step", 30, put_number, "0.2:2"},
    {"early_termination", 30, put_flag, NULL},
};
/* A number in a range, or key frames of some. */
static void put_scene_number(struct maker *maker, const char *arg)
{
    if (chance(maker, 70))
        put_number(maker, arg);
    else
        put_scene_track(maker, put_number, arg, true);
}

static void put_shadows(struct maker *maker, const char *arg)
{
    if (chance(maker, 60))
        put_flag(maker, arg);
    else
        put_scene_number(maker, "0:1");
}

static void put_lamp(struct maker *maker, const char *arg)
{
    add(maker, "{%s: [%d, %d, %d, %d]}", chance(maker, 50) ? "body" : "camera",
        whole(maker, -180, 180), whole(maker, -30, 80), whole(maker, 1, 90), whole(maker, 1, 90));
}

static const struct row light_rows[] = {
    {"method", 100, put_method, "plain|global|global|global|flat|path"},
    {"environment", 20, put_word, "sky.hdr|{sky.hdr: 70}"},
    {"lamp", 30, put_lamp, NULL},
    {"ambient", 20, put_scene_number, "0:1"},
    {"key", 20, put_scene_number, "0:1"},
    {"head", 20, put_scene_number, "0:1"},
    {"occlusion", 40, put_scene_number, "0:1"},
    {"shadows", 40, put_shadows, NULL},
    {"edges", 30, put_scene_number, "0:1"},
    {"depth_cue", 30, put_scene_number, "0:1"},
};
/* The smoothing of surfaces is not of a shot, but of the film. */
static void put_film_smooth(struct maker *maker, const char *arg)
{
    if (!maker->is_in_shot)
        put_word(maker, arg);
}

static void put_tissue_opacity(struct maker *maker, const char *arg)
{
    if (chance(maker, 70)) {
        put_word(maker, arg);
        return;
    } /* verbs are refused if none of their tissues is ever seen */
    add(maker, "{%d%%: ", 10 * whole(maker, 0, 4));
    put_word(maker, "1|0.5|0.2|0");
    add(maker, ", %d%%: {value: ", 10 * whole(maker, 5, 9));
    put_word(maker, "0.8|0.25|1");
    add(maker, ", ease: ");
    put_ease(maker, NULL);
    add(maker, "}, 100%%: ");
    put_word(maker, "0.8|0.25|1|0|0");
    add(maker, "}");
}

static void put_tissue_color(struct maker *maker, const char *arg)
{
    if (chance(maker, 70))
        put_color(maker, arg);
    else
        put_scene_track(maker, put_color, arg, true);
}

static void put_offset(struct maker *maker, const char *arg)
{
    if (chance(maker, 50))
        put_point(maker, arg);
    else
        put_scene_track(maker, put_point, arg, true);
}

/* Verbs are refused if none of their tissues is ever seen. */
static void put_coming(struct maker *maker, const char *arg)
{
    const bool comes = chance(maker, 50);
    const int from = 10 * whole(maker, 0, 4), to = 10 * whole(maker, 5, 10);

    add(maker, "{%d%%: %s, %d%%: %s}", from, comes ? "false" : "true", to,
        comes ? "true" : "false");
}

static const struct row tissue_rows[] = {
    {"color", 40, put_tissue_color, NULL},
    {"opacity", 100, put_tissue_opacity, "auto|1|0.5|0.2|1|0.8"},
    {"visible", 15, put_coming, NULL},
    {"offset", 15, put_offset, NULL},
    {"coat", 20, put_number, "0:1"},
    {"specular", 20, put_number, "0:2"},
    {"roughness", 20, put_number, "0.1:1"},
    {"interior_opacity", 10, put_number, "0:0.2"},
    {"smooth", 30, put_film_smooth, "0.5|1.5"},
};

static void put_values(struct maker *maker, const char *arg)
{
    put_word(maker, maker->is_measured ? arg : "values.csv");
}

/* A heading of the table, or key frames of some. */
static void put_column(struct maker *maker, const char *arg)
{
    if (maker->is_measured)
        return;
    if (chance(maker, 50))
        put_word(maker, arg);
    else
        put_scene_track(maker, put_word, arg, true);
}

static const struct row color_by_rows[] = {
    {"values", 100, put_values, "volume|thickness|surface"},
    {"column", 100, put_column, "change|weight"},
    {"map", 60, put_word, "viridis|cividis|magma|inferno|plasma|coolwarm"},
    {"range", 40, put_word, "auto|[-1, 5]|[0, 100]"},
    {"missing", 40, put_color, NULL},
    {"title", 40, put_word, "The heart|\"Cœur\"|\"心\"|\"1 %: [b]\""}, /* of one line */
};
/* Level and width of a window. */
static void put_pair(struct maker *maker, const char *arg)
{
    add(maker, "[%d, %d]", whole(maker, -100, 300), whole(maker, 1, 500));
}

static void put_window(struct maker *maker, const char *arg)
{
    if (chance(maker, 60))
        put_word(maker, arg);
    else
        put_scene_track(maker, put_pair, NULL, true);
}

static const struct row image_rows[] = {
    {"path", 100, put_word, "phantom|phantom:16x12x20|ct.nrrd"},
    {"window", 50, put_window, "auto|[50, 400]|[200, 90]"},
    {"caps", 60, put_scene_number, "0:1"},
    {"slices", 60, put_scene_number, "0:1"},
    {"backdrop", 50, put_scene_number, "0:1"},
};
static const struct row cine_rows[] = {
    {"bpm", 100, put_number, "20:240"},
    {"loop", 60, put_word, "true|false|1|2"},
    {"between", 40, put_word, "1|2"},
    {"phases", 50, put_word, "0-2|\"2,0\"|0-2:2"},
};
#define SUBJECT_ROWS                                                                               \
    {"volume", 100, put_word, "phantom:20x16x22|other.nrrd"},                                      \
        {"labels", 40, put_word, "other.ctbl"},                                                    \
    {                                                                                              \
        "name", 60, put_text, NULL                                                                 \
    }
static const struct row subject_rows[] = {SUBJECT_ROWS};
static const struct row subject_with_image_rows[] = {
    SUBJECT_ROWS,
    {"image", 60, put_word, "none|phantom:16x12x20|ct.nrrd"},
};

static const struct row hidden_rows[] = {{"visible", 100, put_flag, NULL}};

/* A row of the job, or of a shot of it: "key: {...}". */
static void add_line(struct maker *maker, int indent, const char *key, const struct row *rows,
                     size_t count)
{
    add(maker, "%*s%s: ", indent, "", key);
    add_map(maker, rows, count);
    add(maker, "\n");
}

static void add_tissues(struct maker *maker, int indent)
{
    add(maker, "%*stissues: {\"*\": ", indent, "");
    add_map(maker, tissue_rows, COUNT_OF(tissue_rows));
    if (chance(maker, 50)) {
        add(maker, ", \"*ventricle\": ");
        add_map(maker, tissue_rows, COUNT_OF(tissue_rows));
    }
    if (chance(maker, 50)) {
        add(maker, ", epicardial fat: ");
        add_map(maker, hidden_rows, COUNT_OF(hidden_rows));
    }
    add(maker, "}\n");
}

static void add_color_by(struct maker *maker, int indent)
{
    maker->is_measured = chance(maker, 50);
    add_line(maker, indent, "color_by", color_by_rows, COUNT_OF(color_by_rows));
}

static const struct row image_of_shot_rows[] = {
    {"caps", 60, put_scene_number, "0:1"},
    {"slices", 60, put_scene_number, "0:1"},
    {"backdrop", 50, put_scene_number, "0:1"},
};

/* What may change from shot to shot, beside the animation. */
static void add_looks(struct maker *maker, int indent)
{
    if (chance(maker, 50))
        add_line(maker, indent, "render", render_of_shot_rows, COUNT_OF(render_of_shot_rows));
    if (chance(maker, 50))
        add_line(maker, indent, "light", light_rows, COUNT_OF(light_rows));
    if (chance(maker, 60))
        add_tissues(maker, indent);
    if (chance(maker, 60))
        add_line(maker, indent, "overlays", overlay_rows, COUNT_OF(overlay_rows));
    if (chance(maker, 20))
        add_color_by(maker, indent);
    if (maker->has_image && chance(maker, 40))
        add_line(maker, indent, "image", image_of_shot_rows, COUNT_OF(image_of_shot_rows));
}

/* How long a transition takes: two frames, so that a shot of four can have one at each end. */
static void put_two_frames(struct maker *maker, const char *arg)
{
    const double seconds = 2.0 / maker->fps;

    if (chance(maker, 30))
        add(maker, "2f");
    else if (chance(maker, 50))
        add(maker, "%.6g s", seconds);
    else
        add(maker, "%.6g ms", 1000 * seconds);
}

/* A title, or one with a subtitle. */
static void add_card(struct maker *maker)
{
    const bool has_subtitle = chance(maker, 50);

    add(maker, has_subtitle ? "    card: [" : "    card: ");
    put_text(maker, NULL);
    if (has_subtitle) {
        add(maker, ", ");
        put_text(maker, NULL);
        add(maker, "]");
    }
    add(maker, "\n");
}

static void add_shots(struct maker *maker)
{
    const int count = whole(maker, 2, SHOTS_MAX),
              card = chance(maker, 60) ? whole(maker, 0, 2) : -1;

    maker->is_in_shot = true;
    add(maker, "shots:\n");
    for (int i = 0; i < count; i++) {
        const int transition = whole(maker, i ? 0 : 1, 2);

        add(maker, "  - name: ");
        put_text(maker, NULL);
        add(maker, "\n    transition: ");
        add(maker, transition == 0 ? "cross_fade " : transition == 1 ? "fade " : "cut");
        if (transition < 2)
            put_two_frames(maker, NULL);
        add(maker, "\n");
        if (i == count - 1 && chance(maker, 50)) {
            add(maker, "    fade_out: ");
            put_two_frames(maker, NULL);
            add(maker, "\n");
        }
        maker->frames = FRAMES;
        if (i == card)
            add_card(maker);
        add_looks(maker, 4);
        add(maker, "    animation:\n");
        add_animation(maker, maker->number * SHOTS_MAX + (uint64_t)i);
    }
}

/* The volume, and what belongs to some kinds of volumes alone. */
static void add_subject(struct maker *maker)
{
    if (maker->subject == CINE) {
        add(maker, "volume: %s\n",
            chance(maker, 50) ? "beat-*.nrrd" : "[beat-00.nrrd, beat-02.nrrd, beat-01.nrrd]");
        add_line(maker, 0, "cine", cine_rows, COUNT_OF(cine_rows));
    } else {
        add(maker, "volume: phantom:24x18x24\n");
    }
    if (maker->has_image)
        add_line(maker, 0, "image", image_rows, COUNT_OF(image_rows));
    if (maker->subject == VALUES)
        add_color_by(maker, 0);
    if (maker->subject != COMPARE)
        return;
    add(maker, "compare: {align: %s", chance(maker, 50) ? "center" : "none");
    if (chance(maker, 50)) {
        add(maker, ", name: ");
        put_text(maker, NULL);
    }
    if (chance(maker, 50)) {
        add(maker, ", divider: ");
        put_share_track(maker, "0:100");
        add(maker, ", with: [");
    } else {
        add(maker, ", with: [other.nrrd, ");
    }
    if (maker->has_image)
        add_map(maker, subject_with_image_rows, COUNT_OF(subject_with_image_rows));
    else
        add_map(maker, subject_rows, COUNT_OF(subject_rows));
    add(maker, "]}\n");
}

static void make_job(struct maker *maker)
{
    static const char *const sizes[] = {"[160, 120]", "[120, 168]", "[141, 107]", "[192, 108]"};
    static const int rates[] = {1, 2, 10};

    maker->subject = (enum subject)(maker->number % SUBJECTS);
    maker->fps = rates[whole(maker, 0, 2)];
    maker->frames = FRAMES + (maker->subject == SHOTS ? 0 : whole(maker, 0, 2));
    maker->is_transparent = chance(maker, 10);
    maker->has_floor = chance(maker, 15);
    maker->has_image =
        maker->subject == IMAGE || chance(maker, maker->subject == COMPARE ? 60 : 15);
    add_subject(maker);
    add(maker, "output: {size: %s, fps: %d, video: none}\n", sizes[whole(maker, 0, 3)], maker->fps);
    add_line(maker, 0, "overlays", overlay_rows, COUNT_OF(overlay_rows));
    add_tissues(maker, 0);
    add_line(maker, 0, "light", light_rows, COUNT_OF(light_rows));
    add_line(maker, 0, "render", render_rows, COUNT_OF(render_rows));
    add(maker, "animation:\n");
    if (maker->subject == SHOTS) {
        add(maker, "  frames: %d\n", FRAMES);
        add_shots(maker);
    } else {
        add_animation(maker, maker->number);
    }
}

/* ---- all keys ---- */

static void print_rows(const char *map, const struct row *rows, size_t count)
{
    for (size_t i = 0; i < count; i++)
        printf("%s.%s\n", map, rows[i].key);
}

static void print_keys(void)
{
#define PRINT(map, rows) print_rows(map, rows, COUNT_OF(rows))
    for (size_t i = 0; i < COUNT_OF(verbs); i++)
        print_rows("animation.verbs.N", verbs[i].rows, verbs[i].count);
    PRINT("animation.clip.N", plane_rows);
    PRINT("animation.clip.N", box_rows);
    PRINT("animation.camera.orbit", orbit_rows);
    PRINT("animation.camera.fixed", fixed_rows);
    PRINT("animation", slices_rows);
    PRINT("overlays", overlay_rows);
    PRINT("light", light_rows);
    PRINT("tissues.NAME", tissue_rows);
    PRINT("tissues.NAME", hidden_rows);
    PRINT("color_by", color_by_rows);
    PRINT("image", image_rows);
    PRINT("cine", cine_rows);
    PRINT("compare.with.N", subject_with_image_rows);
#undef PRINT
}

int main(int argc, char **argv)
{
    static struct maker maker;

    if (argc == 2 && !strcmp(argv[1], "--keys")) {
        print_keys();
        return 0;
    }
    if (argc != 3) {
        fprintf(stderr, "usage: random_job SEED NUMBER, or random_job --keys\n");
        return 64;
    }
    maker.number = strtoull(argv[2], NULL, 10);
    maker.state = strtoull(argv[1], NULL, 10) * 1000003 + maker.number;
    make_job(&maker);
    fputs(maker.text, stdout);
    return 0;
}
