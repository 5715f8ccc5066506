/* SPDX-License-Identifier: BSD-3-Clause */
/* Tests the names beside the tissues: that none covers another, that no lines cross, that nothing
 * jumps from frame to frame, and that they name what is seen. */
#include "check.h"

#include "internal.h"

enum { WIDTH = 640, HEIGHT = 360, SIZE = 60, LABELS = 25, FRAMES = 240 };

/* A film of a volume of boxes and balls, which the camera circles. */
typedef struct film {
    uint8_t ids[SIZE * SIZE * SIZE];
    sc_label labels[LABELS];
    sc_label_stats stats[LABELS];
    sc_tissue tissues[LABELS];
    sc_prepared volume;
    sc_overlays overlays;
    sc_named_tissue chosen;
    sc_timeline timeline;
    sc_annotations annotations;
    sc_lettering *lettering;
    sc_name_plan *plan;
} film;

static void begin_volume(film *f, int labels)
{
    memset(f, 0, sizeof *f);
    f->volume = (sc_prepared){.size = {SIZE, SIZE, SIZE},
                              .label_bytes = 1,
                              .label_count = labels,
                              .labels = f->labels,
                              .stats = f->stats,
                              .ids = f->ids,
                              .to_ras_mm = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}};
    for (int id = 1; id < labels; id++) {
        snprintf(f->labels[id].name, sizeof f->labels[id].name, "tissue_%d", id);
        f->tissues[id] = (sc_tissue){.visible = true, .opacity = 1};
    }
}

/* Fill an ellipsoid, or a box, with a tissue. */
static void fill(film *f, int id, const int middle[3], const int radius[3], bool box)
{
    for (int z = 0; z < SIZE; z++) {
        for (int y = 0; y < SIZE; y++) {
            for (int x = 0; x < SIZE; x++) {
                const double a = (double)(x - middle[0]) / radius[0];
                const double b = (double)(y - middle[1]) / radius[1];
                const double c = (double)(z - middle[2]) / radius[2];

                if (box ? fmax(fabs(a), fmax(fabs(b), fabs(c))) <= 1 : a * a + b * b + c * c <= 1)
                    f->ids[(z * SIZE + y) * SIZE + x] = (uint8_t)id;
            }
        }
    }
}

/* Measure the tissues. */
static void measure(film *f)
{
    for (int id = 0; id < LABELS; id++)
        f->stats[id] = (sc_label_stats){.low = {SIZE, SIZE, SIZE}, .high = {-1, -1, -1}};
    for (int i = 0; i < SIZE * SIZE * SIZE; i++) {
        const int at[3] = {i % SIZE, i / SIZE % SIZE, i / SIZE / SIZE};
        sc_label_stats *s = &f->stats[f->ids[i]];

        s->voxels++;
        for (int axis = 0; axis < 3; axis++) {
            s->low[axis] = at[axis] < s->low[axis] ? at[axis] : s->low[axis];
            s->high[axis] = at[axis] > s->high[axis] ? at[axis] : s->high[axis];
        }
    }
}

/* Begin a film of one turn about a volume of random tissues, with all their names. */
static void begin_film(film *f, uint64_t seed)
{
    const sc_animation animation = {.frames = FRAMES,
                                    .camera = {.axis = {0, 0, 1},
                                               .turns = 1,
                                               .elevation_deg = (double)(seed % 5) * 10,
                                               .fov_deg = 30,
                                               .zoom = 1}};
    sc_vec3 corners[8];

    begin_volume(f, LABELS);
    for (int id = 1; id < LABELS; id++) {
        const int middle[3] = {6 + (int)(random_bits(&seed) % 48),
                               6 + (int)(random_bits(&seed) % 48),
                               6 + (int)(random_bits(&seed) % 48)};
        const int radius[3] = {2 + (int)(random_bits(&seed) % 6), 2 + (int)(random_bits(&seed) % 6),
                               2 + (int)(random_bits(&seed) % 6)};

        fill(f, id, middle, radius, id % 2);
        f->tissues[id].opacity = id % 3 ? 1 : 0.3;
    }
    measure(f);
    for (int i = 0; i < 8; i++)
        corners[i] = (sc_vec3){i & 1 ? SIZE : 0, i & 2 ? SIZE : 0, i & 4 ? SIZE : 0};
    sc_timeline_resolve(&animation, corners, 8, (double)WIDTH / HEIGHT, &f->timeline);
    f->overlays = (sc_overlays){.font = "DejaVu Sans", .text_percent = 3, .names_percent = 3};
    f->chosen = (sc_named_tissue){.of = SC_USE_NAMES, .pattern = "*"};
    f->annotations = (sc_annotations){.overlays = &f->overlays,
                                      .lists = {.tissues = &f->chosen, .tissue_count = 1},
                                      .volume = &f->volume,
                                      .tissues = f->tissues,
                                      .timeline = &f->timeline,
                                      .within = {0, 0, WIDTH, HEIGHT},
                                      .fps = 30};
    assert_ok(sc_annotations_letter(&quiet, &f->annotations, &f->lettering));
    f->annotations.lettering = f->lettering;
}

static void plan_film(film *f, int threads)
{
    assert_ok(sc_annotations_plan_names(&quiet, &f->annotations, threads, &f->plan));
    f->annotations.names = f->plan;
}

static void end_film(film *f)
{
    sc_free(f->plan);
    sc_free(f->lettering);
}

static const sc_name_place *place_of(const film *f, int k, int n)
{
    return &f->plan->places[k * f->plan->count + n];
}

/* @return on which side of the line from @p a to @p b the point @p c lies: its sign. */
static double side_of(const float a[2], const float b[2], const float c[2])
{
    return (double)(b[0] - a[0]) * (double)(c[1] - a[1]) -
           (double)(b[1] - a[1]) * (double)(c[0] - a[0]);
}

static bool cross(const float a[2], const float b[2], const float c[2], const float d[2])
{
    return side_of(a, b, c) * side_of(a, b, d) < 0 && side_of(c, d, a) * side_of(c, d, b) < 0;
}

/* @return whether the leader lines of two names cross. */
static bool lines_cross(const sc_name_place *p, const sc_name_place *q)
{
    const float lines[2][3][2] = {{{p->dot_px[0], p->dot_px[1]},
                                   {p->elbow_px, p->dot_px[1]},
                                   {p->label_px[0], p->label_px[1]}},
                                  {{q->dot_px[0], q->dot_px[1]},
                                   {q->elbow_px, q->dot_px[1]},
                                   {q->label_px[0], q->label_px[1]}}};

    for (int i = 0; i < 2; i++) {
        for (int j = 0; j < 2; j++) {
            if (cross(lines[0][i], lines[0][i + 1], lines[1][j], lines[1][j + 1]))
                return true;
        }
    }
    return false;
}

/* Check the names of one frame. @return how many are seen. */
static int check_frame(const film *f, int k, double row_px)
{
    int named = 0;

    for (int n = 0; n < f->plan->count; n++) {
        const sc_name_place *p = place_of(f, k, n);
        const int advance_px = f->lettering->words[n].advance_px;

        if (!p->alpha)
            continue;
        named++;
        assert_true(p->label_px[1] >= row_px / 2 && p->label_px[1] <= HEIGHT - row_px / 2);
        assert_true(p->is_right ? p->label_px[0] + advance_px < WIDTH
                                : p->label_px[0] - advance_px > 0);
        for (int m = 0; m < n; m++) {
            const sc_name_place *q = place_of(f, k, m);

            if (!q->alpha)
                continue;
            assert_false(lines_cross(p, q));
            if (p->is_right == q->is_right)
                assert_true(fabs((double)(p->label_px[1] - q->label_px[1])) > 0.79 * row_px);
        }
    }
    return named;
}

/* In films of random tissues no name covers another or leaves the picture, and no lines cross. */
TEST(names_stand_apart_and_lines_do_not_cross)
{
    static film f;
    int named = 0;

    for (uint64_t seed = 1; seed <= 6; seed++) {
        begin_film(&f, seed);
        plan_film(&f, 2);
        assert_int_equal(f.plan->frames, FRAMES);
        for (int k = 0; k < FRAMES; k++)
            named += check_frame(&f, k, f.lettering->words[0].line_px);
        end_film(&f);
    }
    assert_true(named > 6 * FRAMES * 4); /* there are names at all */
}

/* Check that a name moves little from one frame to the next. */
static void check_step(const sc_name_place *before, const sc_name_place *now, double row_px)
{
    assert_true(abs(now->alpha - before->alpha) < 72);
    if (!now->alpha || !before->alpha)
        return;
    assert_int_equal(now->is_right, before->is_right);
    for (int i = 0; i < 2; i++) {
        assert_true(fabs((double)(now->dot_px[i] - before->dot_px[i])) < 6);
        assert_true(fabs((double)(now->label_px[i] - before->label_px[i])) < 0.75 * row_px);
    }
}

/* From frame to frame a name that is seen moves by few pixels and stays on its side, and it appears
 * and disappears by degrees. */
TEST(names_do_not_jump)
{
    static film f;

    for (uint64_t seed = 1; seed <= 6; seed++) {
        begin_film(&f, seed);
        plan_film(&f, 2);
        for (int k = 1; k < FRAMES; k++) {
            for (int n = 0; n < f.plan->count; n++)
                check_step(place_of(&f, k - 1, n), place_of(&f, k, n),
                           f.lettering->words[0].line_px);
        }
        end_film(&f);
    }
}

/* @return in how many frames and names a name stands over a rectangle of the picture, by the halves
 * of the letters' height. */
static int count_covering(const film *f, const sc_viewport *rectangle)
{
    int covering = 0;

    for (int i = 0; i < FRAMES * f->plan->count; i++) {
        const sc_name_place *p = &f->plan->places[i];
        const sc_word *word = &f->lettering->words[i % f->plan->count];
        const double begin_px = (double)p->label_px[0] - (p->is_right ? 0 : word->advance_px);
        const double top_px = (double)p->label_px[1] - word->capitals_px / 2.0;

        covering += p->alpha && begin_px < rectangle->x_px + rectangle->width_px &&
                    begin_px + word->advance_px > rectangle->x_px &&
                    top_px < rectangle->y_px + rectangle->height_px &&
                    top_px + word->capitals_px > rectangle->y_px;
    }
    return covering;
}

/* Names of a part of a picture do not stand where something is written over the whole: a legend in
 * a corner, of which only the part beside it knows. */
TEST(names_leave_room_for_what_is_written_over_all)
{
    static const int corners[] = {SC_PLACE_TOP_LEFT, SC_PLACE_TOP_RIGHT, SC_PLACE_BOTTOM_LEFT,
                                  SC_PLACE_BOTTOM_RIGHT};
    static film f;

    for (int corner = 0; corner < 4; corner++) {
        for (int part = 0; part < 2; part++) {
            const bool is_beside = corner % 2 == part;
            sc_overlays overlays = {.text_percent = 2.5, .legend = corners[corner]};
            sc_annotations over;
            SC_OWN(sc_free_at) sc_lettering *legend = NULL;
            sc_drawing d;
            const sc_viewport *taken = &d.taken[corners[corner]];
            SC_OWN(sc_free_at) sc_name_plan *without = NULL;
            sc_scene scene;

            begin_film(&f, 1);
            snprintf(overlays.font, sizeof overlays.font, "%s", f.overlays.font);
            over = f.annotations;
            over.overlays = &overlays;
            over.lists.tissue_count = 0;
            assert_ok(sc_annotations_letter(&quiet, &over, &legend));
            over.lettering = legend;
            scene = sc_timeline_scene(&f.timeline, 0, NULL);
            d = sc_drawing_begin(&over, &scene, &(sc_image){.width_px = WIDTH, .height_px = HEIGHT},
                                 &(sc_rows){0, 0});
            assert_ok(sc_draw_fixed(&quiet, &d, &scene));
            assert_true(taken->height_px > HEIGHT / 2 && taken->width_px < WIDTH / 2);

            f.annotations.within = (sc_viewport){part * WIDTH / 2, 0, WIDTH / 2, HEIGHT};
            plan_film(&f, 2);
            without = f.plan;
            assert_true((count_covering(&f, taken) > 0) == is_beside);
            f.annotations.over = &over;
            plan_film(&f, 2);
            assert_int_equal(count_covering(&f, taken), 0);
            assert_true((memcmp(without, f.plan, without->bytes) != 0) == is_beside);
            end_film(&f);
        }
    }
}

/* Check that each name of frame @p k is on the side of the divider that shows its tissue. @return
 * the number of visible names. */
static int check_beside(const film *f, int k)
{
    const sc_annotations *a = &f->annotations;
    const double sign = a->is_behind_divider ? 1 : -1, row_px = f->lettering->words[0].line_px;

    for (int n = 0; n < f->plan->count; n++) {
        const sc_name_place *p = place_of(f, k, n);
        const double divider = sc_timeline_scene(&f->timeline, k, NULL).divider;
        const double distance_px =
            sign * ((double)p->dot_px[0] - sc_divider_px(divider, a->divided_px));

        if (k)
            check_step(place_of(f, k - 1, n), p, row_px);
        if (!p->alpha)
            continue;
        assert_int_equal(p->is_right, a->is_behind_divider);
        assert_true(distance_px > 0.28 * sc_names_px(a)); /* radius of the dot, with its halo */
        assert_true(sign * (double)(p->elbow_px - p->dot_px[0]) >= 0);
        assert_true(sign * (double)(p->label_px[0] - p->elbow_px) >= 0);
    }
    return check_frame(f, k, row_px);
}

/* Beside a divider, which stands or moves over the picture, a name is seen only where its dot, its
 * line and its words are all shown: on both sides of it, from frame to frame without a jump. */
TEST(names_stand_beside_a_divider)
{
    enum { STANDING = 4 };
    static film f;
    static const sc_track stands;

    for (int test = 0; test < 2 * (1 + STANDING); test++) {
        /* one that moves also stands at both ends, and between them has passed its column whole */
        const double before = 0.499 / WIDTH;
        const double share = (WIDTH / 2 - 50 + 25 * (test / 2)) / (double)WIDTH;
        const sc_track moves = {
            2,
            {{.at = 20.0 / (FRAMES - 1), .value = {-before, 0, 0}},
             {.at = (FRAMES - 20.0) / (FRAMES - 1), .value = {1 - before, 0, 0}}}};
        int named = 0;

        begin_film(&f, 4);
        f.timeline.looks.divider = &share;
        f.timeline.looks.divider_track = test > 1 ? &stands : &moves;
        f.annotations.divided_px = WIDTH;
        f.annotations.is_behind_divider = test % 2;
        plan_film(&f, 2);
        for (int k = 0; k < FRAMES; k++)
            named += check_beside(&f, k);
        assert_true(named > FRAMES);
        end_film(&f);
    }
}

TEST_OF_THREADS(the_plan_does_not_depend_on_threads)
{
    static film f;
    SC_OWN(sc_free_at) sc_name_plan *one = NULL;

    begin_film(&f, 3);
    plan_film(&f, 1);
    one = f.plan;
    plan_film(&f, 3);
    assert_int_equal(one->bytes, f.plan->bytes);
    assert_memory_equal(one, f.plan, one->bytes);
    end_film(&f);
}

/* The deepest point of a box is its middle; all points of a ring lie in it, and apart. */
TEST(anchors_lie_deep_in_their_tissue)
{
    static film f;
    sc_anchors anchors;
    const int middle[3] = {30, 25, 35}, box[3] = {12, 8, 10}, ring[3] = {24, 24, 6},
              hole[3] = {16, 16, 8};

    begin_volume(&f, 3);
    fill(&f, 1, middle, ring, false);
    fill(&f, 0, middle, hole, false);
    measure(&f);
    assert_ok(sc_find_anchors(&quiet, &f.volume, 1, &anchors));
    assert_int_equal(anchors.count, SC_ANCHORS_MAX);
    for (int i = 0; i < anchors.count; i++) {
        const int *at = anchors.voxel[i];
        int apart = 0;

        assert_int_equal(f.ids[(at[2] * SIZE + at[1]) * SIZE + at[0]], 1);
        for (int j = 0; j < i; j++) {
            apart = abs(at[0] - anchors.voxel[j][0]) + abs(at[1] - anchors.voxel[j][1]);
            assert_true(apart > 4);
        }
    }
    fill(&f, 2, middle, box, true);
    measure(&f);
    assert_ok(sc_find_anchors(&quiet, &f.volume, 2, &anchors));
    for (int axis = 0; axis < 3; axis++) /* many are as deep: the first along x and z */
        assert_true(abs(anchors.voxel[0][axis] - middle[axis]) <= (axis == 1 ? 0 : 4));
}

/* What hides a point: both sides of another tissue, and a cut face, but not its own tissue, and
 * nothing that a clip plane has taken away. */
TEST(light_passes_what_does_not_hide)
{
    static film f;
    const sc_annotations a = {.volume = &f.volume, .tissues = f.tissues};
    const int middle[3] = {30, 10, 30}, wall[3] = {30, 45, 30}, own[3] = {30, 20, 30},
              radius[3] = {4, 4, 4}, thin[3] = {20, 2, 20};
    const sc_vec3 point_mm = {30, 10, 30};
    sc_scene scene = {.clip.set_count = 1};

    begin_volume(&f, 3);
    fill(&f, 1, middle, radius, true);
    fill(&f, 1, own, thin, true);
    fill(&f, 2, wall, thin, true);
    for (int perspective = 0; perspective < 2; perspective++) {
        scene.camera = sc_camera_look((sc_vec3){30, 200, 30}, point_mm, (sc_vec3){0, 0, 1},
                                      perspective ? SC_PERSPECTIVE : SC_ORTHOGRAPHIC, 0.5);
        f.tissues[2].opacity = 1;
        assert_true(sc_light_of(&a, &f.volume.to_ras_mm, &scene, 1, point_mm) <= 0.01);
        f.tissues[2].opacity = 0.5;
        assert_near(sc_light_of(&a, &f.volume.to_ras_mm, &scene, 1, point_mm), 0.25, 1e-9);
        scene.clip.sets[0] = 1;
        scene.clip.count = 1;
        scene.clip.planes[0] = (sc_plane){{0, -1, 0}, 35}; /* keeps y up to 35, without the wall */
        assert_near(sc_light_of(&a, &f.volume.to_ras_mm, &scene, 1, point_mm), 1, 1e-9);
        scene.clip.planes[0] =
            (sc_plane){{0, -1, 0}, 45}; /* a cut face in the middle of the wall */
        assert_true(sc_light_of(&a, &f.volume.to_ras_mm, &scene, 1, point_mm) <= 0.01);
        scene.clip.planes[0] = (sc_plane){{0, -1, 0}, 8}; /* the point itself is taken away */
        assert_true(sc_light_of(&a, &f.volume.to_ras_mm, &scene, 1, point_mm) <= 0);
        scene.clip.count = 0;
        scene.clip.sets[0] = 0;
    }
}

/* Names in a column stand in order, apart and within it; they move by no more than what moves
 * them. */
TEST(a_column_spreads_names)
{
    uint64_t seed = 5;
    double at[SC_NAMES_MAX];

    for (int n = 0; n < 2000; n++) {
        const int count = 1 + (int)(random_bits(&seed) % 12);
        double want[SC_NAMES_MAX], room[SC_NAMES_MAX], moved[SC_NAMES_MAX];
        double y = -20;

        for (int i = 0; i < count; i++) {
            y += (double)(random_bits(&seed) % 40);
            want[i] = y;
            room[i] = i % 3 ? 20 : (double)(random_bits(&seed) % 21);
        }
        sc_spread(want, room, count, 0, 300, at);
        for (int i = 0; i < count; i++) {
            assert_true(at[i] - room[i] / 2 >= -1e-9 && at[i] + room[i] / 2 <= 300 + 1e-9);
            assert_true(!i || at[i] - at[i - 1] >= (room[i] + room[i - 1]) / 2 - 1e-9);
            want[i] += (double)(random_bits(&seed) % 5) / 10; /* at most 0.4 */
        }
        sc_spread(want, room, count, 0, 300, moved);
        for (int i = 0; i < count; i++)
            assert_true(fabs(moved[i] - at[i]) <= 0.4 + 1e-9);
    }
    /* Where there is room, a name stands where it wants to. */
    sc_spread((const double[]){50, 100}, (const double[]){20, 20}, 2, 0, 300, (double[]){0, 0});
}

/* The most important names get the rows, and a name is seen only once it has nearly all of one. */
TEST(rows_go_to_the_most_important)
{
    const double shown[] = {1, 0.3, 1, 1};
    double room[4], alpha[4];

    sc_share_rows(shown, 4, 2.3, room, alpha);
    assert_near(room[0], 1, 1e-9);
    assert_near(room[1], 0.5, 1e-9);
    assert_near(room[2], 0.8, 1e-9);
    assert_near(room[3], 0, 1e-9);
    assert_near(alpha[0], 1, 1e-9);
    assert_near(alpha[1], 0, 1e-9);
    assert_near(alpha[2], 0, 1e-9);
    assert_near(alpha[3], 0, 1e-9);
}

/* With more names than rows, some are left out, and that is told once. */
TEST(names_without_room_are_told)
{
    static film f;

    begin_film(&f, 2);
    sc_free(f.lettering);
    f.overlays.names_percent = 20;
    assert_ok(sc_annotations_letter(&listening, &f.annotations, &f.lettering));
    f.annotations.lettering = f.lettering;
    assert_int_equal(said.warnings, 1);
    assert_non_null(
        strstr(said.text, "there is room for the names of 8 tissues; those of the 16 "));
    assert_ok(sc_annotations_plan_names(&listening, &f.annotations, 2, &f.plan));
    assert_int_equal(f.plan->count, 8);
    end_film(&f);
}

/* Tissues that no frame names are told, by their numbers if they have no names. */
TEST(hidden_tissues_are_told)
{
    static film f;
    const int middle[3] = {30, 30, 30}, large[3] = {20, 20, 20}, small[3] = {5, 5, 5};

    begin_film(&f, 5);
    sc_free(f.lettering);
    memset(f.ids, 0, sizeof f.ids);
    fill(&f, 1, middle, large, false);
    fill(&f, 2, middle, small, false);
    measure(&f);
    f.labels[2].name[0] = '\0';
    f.labels[2].value = 17;
    f.tissues[1].opacity = 1;
    assert_ok(sc_annotations_letter(&quiet, &f.annotations, &f.lettering));
    f.annotations.lettering = f.lettering;
    assert_ok(sc_annotations_plan_names(&listening, &f.annotations, 2, &f.plan));
    assert_int_equal(said.warnings, 0);
    assert_non_null(strstr(said.text, "their tissues are hidden: label 17"));
    end_film(&f);
}

/* @return how many names frame @p k shows. */
static int shown_in(const film *f, int k)
{
    int shown = 0;

    for (int n = 0; n < f->plan->count; n++)
        shown += place_of(f, k, n)->alpha > 0;
    return shown;
}

/* There is none where another shot is seen more, nor while the camera flies through a vessel. */
TEST(names_of_other_shots_and_in_flights_are_left_out)
{
    static film f;
    static sc_way_point ways[SC_WAY_POINTS];
    const sc_vec3 line[2] = {{5, 30, 30}, {55, 30, 30}};

    begin_film(&f, 2);
    f.annotations.nameless[0] = 20;
    f.annotations.nameless[1] = 30;
    sc_way_make(line, NULL, 2, 0.1, ways);
    f.timeline.ways = ways;
    f.timeline.animation.move_count = 1;
    f.timeline.moves[0] = (sc_move){
        .verb = {.kind = SC_VERB_FLY, .begin = 100.0 / (FRAMES - 1), .end = 1}, .half_height = 1};
    plan_film(&f, 2);
    for (int k = 0; k < 20; k++)
        assert_int_equal(shown_in(&f, k), 0);
    assert_true(shown_in(&f, 60) > 5);
    for (int k = 100; k < FRAMES; k++)
        assert_int_equal(shown_in(&f, k), 0);
    f.timeline.animation.move_count = 0;
    sc_free(f.plan);
    plan_film(&f, 2);
    assert_true(shown_in(&f, 150) > 5);
    for (int k = FRAMES - 30; k < FRAMES; k++)
        assert_int_equal(shown_in(&f, k), 0);
    end_film(&f);
}

/* Names stand below what another overlay has written into the corner above them. */
TEST(names_keep_clear_of_other_overlays)
{
    static film f;
    const sc_scene scene = {.dark_text = 1};
    SC_OWN(sc_image_clear) sc_image image = {0};
    int bottom_px = 0, named = 0;

    begin_film(&f, 4);
    sc_free(f.lettering);
    f.overlays.legend = SC_PLACE_TOP_RIGHT;
    assert_ok(sc_annotations_letter(&quiet, &f.annotations, &f.lettering));
    f.annotations.lettering = f.lettering;
    assert_ok(sc_image_init(&quiet, WIDTH, HEIGHT, &image));
    memset(image.rgb, 255, sc_image_bytes(&image));
    assert_ok(sc_annotations_draw(&quiet, &f.annotations, &scene, &image, NULL));
    for (size_t i = 0; i < sc_image_bytes(&image); i++)
        bottom_px = image.rgb[i] < 128 ? (int)(i / 3 / WIDTH) : bottom_px;
    assert_true(bottom_px > HEIGHT / 2);
    plan_film(&f, 2);
    for (int i = 0; i < FRAMES * f.plan->count; i++) {
        const sc_name_place *p = &f.plan->places[i];

        if (!p->alpha || !p->is_right)
            continue;
        named++;
        assert_true((double)p->label_px[1] - 0.5 * f.overlays.names_percent / 100 * HEIGHT >
                    bottom_px + 4);
    }
    assert_true(named > FRAMES);
    end_film(&f);
}

/* @return whether a leader line leads through a rectangle: looked for at many points of it. */
static bool leads_through(const sc_name_place *p, const sc_viewport *taken)
{
    const double points[3][2] = {{(double)p->dot_px[0], (double)p->dot_px[1]},
                                 {(double)p->elbow_px, (double)p->dot_px[1]},
                                 {(double)p->label_px[0], (double)p->label_px[1]}};

    for (int i = 0; i < 2000; i++) {
        const double *a = points[i / 1000], *b = points[i / 1000 + 1], u = i % 1000 / 999.0;
        const double x = a[0] + u * (b[0] - a[0]), y = a[1] + u * (b[1] - a[1]);

        if (x >= taken->x_px && x < taken->x_px + taken->width_px && y >= taken->y_px &&
            y < taken->y_px + taken->height_px)
            return true;
    }
    return false;
}

/* Leader lines lead around a legend that is wider than the column of names above or below it. */
TEST(lines_keep_clear_of_a_wide_legend)
{
    static const int corners[] = {SC_PLACE_TOP_LEFT, SC_PLACE_TOP_RIGHT, SC_PLACE_BOTTOM_LEFT,
                                  SC_PLACE_BOTTOM_RIGHT};

    for (int corner = 0; corner < 4; corner++) {
        static sc_named_tissue chosen[] = {{.of = SC_USE_NAMES, .pattern = "?"},
                                           {.of = SC_USE_NAMES, .pattern = "??"},
                                           {.of = SC_USE_LEGEND, .pattern = "a*"}};
        static film f;
        const sc_viewport *taken;
        sc_scene scene;
        sc_drawing d;
        int named = 0;

        begin_film(&f, 4);
        sc_free(f.lettering);
        f.overlays.legend = corners[corner];
        f.overlays.names_percent = 2;
        for (int id = 1; id < LABELS; id++)
            snprintf(f.labels[id].name, sizeof f.labels[id].name,
                     id < 16 ? "a tissue of which a long name is known, number %d" : "%d", id);
        f.annotations.lists.tissues = chosen;
        f.annotations.lists.tissue_count = 3;
        assert_ok(sc_annotations_letter(&quiet, &f.annotations, &f.lettering));
        f.annotations.lettering = f.lettering;
        plan_film(&f, 2);
        scene = sc_timeline_scene(&f.timeline, 0, NULL);
        d = sc_drawing_begin(&f.annotations, &scene,
                             &(sc_image){.width_px = WIDTH, .height_px = HEIGHT}, &(sc_rows){0, 0});
        assert_ok(sc_draw_fixed(&quiet, &d, &scene));
        taken = &d.taken[corners[corner]];
        for (int i = 0; i < FRAMES * f.plan->count; i++) {
            const sc_name_place *p = &f.plan->places[i];

            named += p->alpha > 0;
            assert_false(p->alpha && leads_through(p, taken));
        }
        assert_true(named > FRAMES);
        end_film(&f);
    }
}

/* A frame is drawn the same in parts, and names are in it. */
TEST(names_are_drawn_by_rows)
{
    static film f;
    sc_image whole, parts, bare;
    const sc_scene scene = {.frame = 7, .dark_text = 1};

    begin_film(&f, 4);
    plan_film(&f, 2);
    for (int alpha = 0; alpha < 2; alpha++) {
        sc_image *images[] = {&whole, &parts, &bare};

        for (int i = 0; i < 3; i++) {
            assert_ok(sc_image_init_alpha(&quiet, WIDTH, HEIGHT, alpha, images[i]));
            memset(images[i]->rgb, 200, sc_image_bytes(images[i]));
        }
        assert_ok(sc_annotations_draw(&quiet, &f.annotations, &scene, &whole, NULL));
        for (int row = 0; row < HEIGHT; row += 9) {
            const sc_rows rows = {row, row + 9};

            assert_ok(sc_annotations_draw(&quiet, &f.annotations, &scene, &parts, &rows));
        }
        assert_int_equal(sc_image_hash(&whole), sc_image_hash(&parts));
        assert_int_not_equal(sc_image_hash(&whole), sc_image_hash(&bare));
        for (int i = 0; i < 3; i++)
            sc_image_clear(images[i]);
    }
    end_film(&f);
}

RUN_TESTS(NULL, NULL)
