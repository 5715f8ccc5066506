/* SPDX-License-Identifier: BSD-3-Clause */
/* What a rank other than 0 does with the job that rank 0 sends. */
#include "check.h"
#include "thread_comm.h"

#include "segcast/film.h"
#include "segcast/phantom.h"

#include <unistd.h>

enum { RANKS = 3 };

typedef struct scenario {
    int poor_rank; /* the rank on which only the first `budget` allocations succeed */
    long budget;
    sc_status outcomes[RANKS];
    char *received[RANKS];
} scenario;

static void send_array(sc_comm *comm, void *user)
{
    scenario *s = user;
    const int rank = sc_comm_rank(comm);
    long budget = rank == s->poor_rank ? s->budget : 1000;
    sc_ctx ctx = {.alloc_budget = &budget};
    sc_app app = {.ctx = &ctx, .comm = comm};
    static char stale[] =
        "rank 0's"; /* stands for an address of rank 0, which the other ranks must not keep */
    void *array = stale;

    if (rank == 0) {
        assert_ok(sc_alloc(&quiet, 6, 1, &array));
        memcpy(array, "hello", 6);
    }
    s->outcomes[rank] = sc_broadcast_array(&app, &array, 6, 1);
    s->received[rank] = array;
}

TEST(an_array_reaches_all_ranks)
{
    scenario s = {.poor_rank = -1};

    run_ranks(RANKS, false, send_array, &s);
    for (int rank = 0; rank < RANKS; rank++) {
        assert_ok(s.outcomes[rank]);
        assert_string_equal(s.received[rank], "hello");
        sc_free(s.received[rank]);
    }
}

/* No other rank may keep rank 0's address, because it would free it. */
TEST(an_array_that_one_rank_has_no_memory_for_is_on_rank_0_alone)
{
    scenario s = {.poor_rank = 1};

    run_ranks(RANKS, false, send_array, &s);
    for (int rank = 0; rank < RANKS; rank++)
        assert_int_equal(s.outcomes[rank], SC_ERR_MEMORY);
    assert_string_equal(s.received[0], "hello");
    assert_null(s.received[1]);
    assert_null(s.received[2]);
    sc_free(s.received[0]);
}

static void load_job(sc_comm *comm, void *user)
{
    scenario *s = user;
    const int rank = sc_comm_rank(comm);
    long budget = rank == s->poor_rank ? s->budget : 100000;
    sc_ctx ctx = {.alloc_budget = &budget};
    sc_app app = {.ctx = &ctx, .comm = comm, .threads = 1};
    sc_session session;

    s->outcomes[rank] = sc_session_job(&app, "session.yaml", &session);
    sc_session_clear(&session); /* must free only what belongs to this rank */
}

TEST(a_job_that_one_rank_has_no_memory_for_is_cleared_on_all)
{
    write_text("session.yaml",
               "volume: {path: phantom, keep: '*'}\ntissues:\n  \"*\": {opacity: 0.6, color: {0%: "
               "red}}\nanimation:\n  "
               "frames: 7\n  clip:\n"
               "    - {normal: posterior, at: {0%: 0%, 100%: 60%},\n"
               "       except: [coronary arteries]}\n  verbs: [{fade: myocardium, to: 0}]\n"
               "overlays: {caption: The heart, names: aorta}\nshots: [{name: One}, {name: Two}]\n");
    for (long budget = 0; budget < 32; budget++) { /* ten arrays of the film and of each shot */
        scenario s = {.poor_rank = 2, .budget = budget};

        run_ranks(RANKS, false, load_job, &s);
        assert_int_equal(s.outcomes[0], budget < 30 ? SC_ERR_MEMORY : SC_OK);
        assert_int_equal(s.outcomes[1], s.outcomes[0]);
        assert_int_equal(s.outcomes[2], s.outcomes[0]);
    }
    unlink("session.yaml");
}

/* ---- a prepared file that is not the same for all ranks ---- */

/* How often a file was checked. The linker lets calls of sc_prepared_file_view end here. */
static _Atomic int checks;
sc_status __real_sc_prepared_file_view(const sc_ctx *ctx, const char *path, const void *block,
                                       size_t bytes, sc_prepared *out);
sc_status __wrap_sc_prepared_file_view(const sc_ctx *ctx, const char *path, const void *block,
                                       size_t bytes, sc_prepared *out);
sc_status __wrap_sc_prepared_file_view(const sc_ctx *ctx, const char *path, const void *block,
                                       size_t bytes, sc_prepared *out)
{
    checks++;
    return __real_sc_prepared_file_view(ctx, path, block, bytes, out);
}

typedef struct mapping {
    const char *files[RANKS]; /* the file that the job's path means on each rank */
    sc_status outcomes[RANKS];
    heard said[RANKS];
} mapping;

static void map_file(sc_comm *comm, void *user)
{
    mapping *m = user;
    const int rank = sc_comm_rank(comm);
    sc_ctx ctx = {.level = SC_LOG_INFO, .write = hear, .user = &m->said[rank]};
    sc_app app = {.ctx = &ctx, .comm = comm, .threads = 1};
    sc_job job = {.render.smooth = {1, 1, 1}};
    SC_OWN(sc_input_clear) sc_input input = {0};
    bool usable = false;

    snprintf(job.volume.path, sizeof job.volume.path, "%s", m->files[rank]);
    m->outcomes[rank] = sc_input_map(&app, &job, &input, &usable);
    if (m->outcomes[rank] == SC_OK)
        assert_true(usable);
}

static void prepare_file(const char *path, int side)
{
    const int size[3] = {side, side, side};
    const sc_prepare_settings settings = {.smooth = {1, 1, 1}, .threads = 1};
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    sc_preparation *preparation;

    assert_ok(sc_phantom_new(&quiet, &phantom));
    assert_ok(sc_phantom_volume(&quiet, phantom, size, 1, &volume));
    assert_ok(sc_prepare(&quiet, &volume, &settings, &preparation));
    assert_ok(sc_preparation_save(&quiet, preparation, path, true, true));
    sc_preparation_free(preparation);
}

TEST(ranks_refuse_prepared_files_that_differ)
{
    static const struct {
        const char *files[RANKS];
        sc_status outcome;
        int checks; /* by ranks that share memory: of the first one's file, and of all others */
        const char *message;
    } cases[] = {
        {{"a.segc", "a.segc", "a.segc"}, SC_OK, 1, ""},
        {{"a.segc", "same.segc", "a.segc"}, SC_OK, 2, ""},
        {{"a.segc", "a.segc", "b.segc"},
         SC_ERR_DATA,
         2,
         "1 of 3 ranks have not, the first of them "
         "rank 2, which has another file"},
        {{"a.segc", "b.segc", "b.segc"}, SC_ERR_DATA, 3, "rank 1, which has another file"},
        {{"a.segc", "none.segc", "a.segc"}, SC_ERR_DATA, 1, "rank 1, which has no such file"},
        {{"a.segc", "a.segc", "cut.segc"}, SC_ERR_DATA, 2, "rank 2, which has a damaged file"},
        {{"none.segc", "a.segc", "none.segc"}, SC_ERR_MISSING, 1, "none.segc: "},
        {{"cut.segc", "cut.segc", "cut.segc"}, SC_ERR_DATA, 3, "cut.segc: "},
    };
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes;

    prepare_file("a.segc", 12);
    prepare_file("b.segc", 13);
    assert_ok(sc_file_read(&quiet, "a.segc", 1 << 30, &text, &bytes));
    assert_ok(sc_file_write(&quiet, "cut.segc", text, bytes / 2));
    assert_ok(sc_file_write(&quiet, "same.segc", text, bytes));
    for (size_t i = 0; i < 2 * SC_COUNT_OF(cases); i++) {
        const size_t c = i / 2;
        const bool shares = i % 2;
        mapping m = {.files = {cases[c].files[0], cases[c].files[1], cases[c].files[2]}};

        checks = 0;
        run_ranks(RANKS, shares, map_file, &m);
        if (shares)
            assert_int_equal(checks, cases[c].checks);
        for (int rank = 0; rank < RANKS; rank++) {
            assert_int_equal(m.outcomes[rank], cases[c].outcome);
            assert_int_equal(m.said[rank].errors, rank == 0 && cases[c].outcome != SC_OK);
        }
        if (!strstr(m.said[0].text, cases[c].message))
            fail_msg("case %zu: \"%s\", expected \"%s\"", c, m.said[0].text, cases[c].message);
    }
    unlink("a.segc");
    unlink("b.segc");
    unlink("cut.segc");
    unlink("same.segc");
}

/* ---- what floating point decides ---- */

typedef struct looks {
    sc_status outcomes[RANKS];
    sc_tissue tissues[RANKS][3];
    uint8_t backgrounds[RANKS][3];
    double distances_mm[RANKS];
} looks;

/* A sc_points_fn: each rank finds others. */
static sc_status find_points(const sc_app *app, const sc_panel *panel, sc_vec3 **out, size_t *count)
{
    void *block;

    assert_ok(sc_alloc(app->ctx, 2, sizeof **out, &block));
    *out = block;
    (*out)[0] = (sc_vec3){0, 0, 0};
    (*out)[1] = (sc_vec3){30 + sc_comm_rank(app->comm), 40, 50};
    *count = 2;
    return SC_OK;
}

/* A white tissue and a red one. Of the white one rank 0 sees much, and the other ranks nothing; of
 * the thickness of both each rank has another opinion. */
static void decide_looks(sc_comm *comm, void *user)
{
    looks *l = user;
    const int rank = sc_comm_rank(comm);
    sc_ctx ctx = {.rank = rank};
    sc_app app = {.ctx = &ctx, .comm = comm, .threads = 1};
    sc_label labels[3] = {{.value = 0},
                          {.value = 1, .name = "white", .has_color = true, .rgb = {250, 250, 250}},
                          {.value = 2, .name = "red", .has_color = true, .rgb = {200, 20, 20}}};
    sc_label_stats stats[3] = {{.voxels = 0}};
    sc_input input = {0};
    sc_inputs inputs = {.count = 1, .all = &input};
    SC_OWN(sc_session_clear) sc_session session = {0};

    l->outcomes[rank] = sc_session_job(&app, "session.yaml", &session);
    for (int id = 1; id < 3; id++) {
        stats[id] = (sc_label_stats){.voxels = 100, .boundary_voxels = 50, .high = {9, 9, 9}};
        stats[id].thickness_mm = 2 + rank;
        stats[id].shown = (id == 1) == (rank == 0) ? 0.9 : 0.1;
    }
    input.volume = (sc_prepared){.labels = labels, .stats = stats, .label_count = 3};
    session.inputs = &inputs;
    if (l->outcomes[rank] == SC_OK)
        l->outcomes[rank] = sc_session_panels(&app, &session);
    if (l->outcomes[rank] == SC_OK)
        l->outcomes[rank] = sc_session_tissues(&app, &session);
    if (l->outcomes[rank] == SC_OK) {
        const sc_panel *panel = &session.panels[0];

        sc_session_timelines(&app, &session, find_points);
        memcpy(l->tissues[rank], panel->looks.tissues, sizeof l->tissues[rank]);
        memcpy(l->backgrounds[rank], panel->job.render.background.rgb, 3);
        l->distances_mm[rank] = panel->timeline.animation.camera.distance_mm;
    }
    session.inputs = NULL;
}

TEST(rank_0_decides_looks_and_framing)
{
    looks l = {.backgrounds = {{0}}};

    write_text("session.yaml", "volume: phantom\n");
    run_ranks(RANKS, false, decide_looks, &l);
    assert_true(l.backgrounds[0][0] < 128); /* slate */
    for (int rank = 0; rank < RANKS; rank++) {
        assert_ok(l.outcomes[rank]);
        assert_memory_equal(l.tissues[rank], l.tissues[0], sizeof l.tissues[0]);
        assert_memory_equal(l.backgrounds[rank], l.backgrounds[0], 3);
        assert_true(l.distances_mm[rank] == l.distances_mm[0]);
    }
    unlink("session.yaml");
}

RUN_TESTS(NULL, NULL)
