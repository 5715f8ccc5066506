/* SPDX-License-Identifier: BSD-3-Clause */
/* Centre lines against the courses of the phantom's vessels, and what is refused. */
#include "check.h"

#include "segcast/centerline.h"
#include "segcast/phantom.h"

static double off_segment(sc_vec3 p, sc_vec3 a, sc_vec3 b)
{
    const sc_vec3 ab = sc_vec3_sub(b, a), ap = sc_vec3_sub(p, a);
    const double t = fmin(fmax(sc_vec3_dot(ap, ab) / sc_vec3_dot(ab, ab), 0), 1);

    return sc_vec3_length(sc_vec3_sub(ap, sc_vec3_scale(ab, t)));
}

/* @return how far a point is from a course, and, in *share, where along it. */
static double off_course(sc_vec3 p, const sc_vec3 *course, int count, double *share)
{
    double least = HUGE_VAL;

    for (int i = 0; i + 1 < count; i++) {
        const double off = off_segment(p, course[i], course[i + 1]);

        if (off < least) {
            least = off;
            *share = (i + 0.5) / (count - 1);
        }
    }
    return least;
}

/* Find the centre line of a tissue of a phantom volume. */
static sc_status find(const sc_ctx *ctx, const sc_volume *v, int label, const sc_vec3 *through,
                      size_t count, sc_centerline *out)
{
    int order[256] = {0};
    sc_centerline_request request = {.volume = v,
                                     .order = order,
                                     .through = through,
                                     .through_count = count,
                                     .clearance = SC_CLEARANCE,
                                     .what = "it",
                                     .where = "job.yaml:7"};

    order[label] = 1;
    return sc_centerline_find(ctx, &request, out);
}

enum { AORTA = 6, CORONARIES = 5, SVC = 13, IVC = 14 };

TEST(lines_keep_within_a_voxel_of_the_axes_of_vessels)
{
    /* The parts of tubes that no other shape reaches, and where the course has no kink, which a
     * smooth line cuts off: there lines of the coronary arteries are up to 1.5 voxels away. */
    static const struct {
        int label, tube;
        double from, to;
    } vessels[] = {{SVC, 0, 0.25, 0.8},         {IVC, 0, 0.35, 0.75},
                   {CORONARIES, 0, 0.25, 0.95}, {CORONARIES, 2, 0.1, 0.95},
                   {CORONARIES, 3, 0.1, 0.75},  {AORTA, 0, 0.63, 0.72}};
    const sc_ctx loud = {.level = SC_LOG_ERROR, .write = sc_log_to_stderr};
    const int size[3] = {235, 163, 244};
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    assert_ok(sc_phantom_new(&quiet, &phantom));
    assert_ok(sc_phantom_volume(&quiet, phantom, size, 2, &v));
    for (size_t n = 0; n < SC_COUNT_OF(vessels); n++) {
        const double voxel_mm = sc_vec3_length(sc_affine_column(&v.to_ras_mm, 0));
        const sc_vec3 *course;
        SC_OWN(sc_centerline_clear) sc_centerline line = {0};
        double radius_mm[2], most = 0, wrong_mm = 0, squares = 0;
        int count, looked_at = 0;
        sc_vec3 ends[2];

        assert_true(sc_phantom_tube(phantom, vessels[n].label, vessels[n].tube, &course, &count,
                                    radius_mm));
        ends[0] = course[(int)(vessels[n].from * (count - 1))];
        ends[1] = course[(int)(vessels[n].to * (count - 1))];
        assert_ok(find(&loud, &v, vessels[n].label, ends, 2, &line));
        for (size_t i = 0; i < line.count; i++) {
            double share = 0;
            const double off = off_course(line.points[i].at_mm, course, count, &share);
            const double radius = radius_mm[0] + share * (radius_mm[1] - radius_mm[0]);

            looked_at++;
            squares += off * off;
            most = fmax(most, off);
            wrong_mm = fmax(wrong_mm, fabs(line.points[i].radius_mm - radius));
        }
        assert_true(looked_at > 10);
        assert_true(most <= voxel_mm);
        assert_true(sqrt(squares / looked_at) <= 0.5 * voxel_mm);
        assert_true(wrong_mm <= voxel_mm);
    }
}

/* A bent tube of label 1 and a piece of label 2 that does not touch it, with voxels of 1 x 1 x 2
 * mm. */
enum { NX = 40, NY = 30, NZ = 24 };
static uint8_t ids[NX * NY * NZ];
static sc_label labels[3];

static sc_volume small_volume(void)
{
    sc_volume v = {.size = {NX, NY, NZ},
                   .label_bytes = 1,
                   .ids = ids,
                   .label_count = 3,
                   .labels = labels,
                   .to_ras_mm = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 2, 0}}}};

    for (int n = 0; n < NX * NY * NZ; n++) {
        const int slice = n / NX / NY;
        const double x = n % NX - 20, y = n / NX % NY, z = 2 * slice - 16;
        const double off = sqrt(x * x + y * y) - 14;

        ids[n] = 0;
        if (off * off + z * z < 16)
            ids[n] = 1;
        else if (z > 22)
            ids[n] = 2;
    }
    return v;
}

TEST(lines_without_points_run_from_end_to_end)
{
    const sc_volume v = small_volume();
    SC_OWN(sc_centerline_clear) sc_centerline line = {0}, again = {0};

    assert_ok(find(&quiet, &v, 1, NULL, 0, &line));
    assert_int_equal(line.parts, 1);
    assert_true(line.length_mm > 30 && line.length_mm < 50); /* of a half circle of 44 mm */
    for (size_t i = 0; i < line.count; i++) {
        const sc_vec3 p = line.points[i].at_mm;
        const double off = sqrt((p.x - 20) * (p.x - 20) + p.y * p.y) - 14;

        assert_true(fabs(off) < 1 && fabs(p.z - 16) < 1.5);
        if (i > 0) /* the samples are evenly spaced */
            assert_near(sc_vec3_length(sc_vec3_sub(p, line.points[i - 1].at_mm)),
                        line.length_mm / (double)(line.count - 1), 0.05);
    }
    assert_ok(find(&quiet, &v, 1, NULL, 0, &again));
    assert_int_equal(line.count, again.count);
    assert_memory_equal(line.points, again.points, line.count * sizeof *line.points);
}

/* The wall is ahead of the end of a tube, be that a point or not, and not ahead of a point half
 * way, although the tube is bent there. */
TEST(lines_tell_whether_they_end_at_a_wall)
{
    const sc_vec3 half[] = {{6, 2, 16}, {20, 14, 16}}, whole[] = {{20, 14, 16}, {34, 2, 16}};
    const sc_volume v = small_volume();
    sc_centerline line = {0};

    assert_ok(find(&quiet, &v, 1, NULL, 0, &line));
    assert_true(line.ends_at_wall);
    sc_centerline_clear(&line);
    assert_ok(find(&quiet, &v, 1, half, 2, &line));
    assert_false(line.ends_at_wall);
    sc_centerline_clear(&line);
    assert_ok(find(&quiet, &v, 1, whole, 2, &line));
    assert_true(line.ends_at_wall);
    sc_centerline_clear(&line);
}

TEST(what_has_no_way_is_refused_with_where_it_ends)
{
    const sc_volume v = small_volume();
    const sc_vec3 outside[] = {{6, 2, 16}, {20, 2, 16}}, apart[] = {{6, 2, 16}, {20, 20, 40}};
    const int both[] = {0, 1, 1}, in_turn[] = {0, 1, 2};
    const char *const names[] = {"tube", "slab"};
    sc_centerline_request request = {.volume = &v,
                                     .order = both,
                                     .names = names,
                                     .through = apart,
                                     .through_count = 2,
                                     .clearance = SC_CLEARANCE,
                                     .what = "both",
                                     .where = "job.yaml:7"};
    sc_centerline line = {0};

    assert_int_equal(find(&listening, &v, 1, outside, 2, &line), SC_ERR_DATA);
    assert_non_null(strstr(said.text,
                           "job.yaml:7: point 2 (20.0, 2.0, 16.0) lies outside of it; the "
                           "nearest place in it is (19.0, 10.0, 16.0), 8.1 mm away"));
    assert_int_equal(sc_centerline_find(&listening, &request, &line), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "there is no way within both from point 1"));
    assert_non_null(strstr(said.text, "from there it ends at (20.0, "));
    assert_null(line.points);
    /* Without points: one pattern for both means either of them, two mean one after the other. */
    request.through_count = 0;
    assert_ok(sc_centerline_find(&listening, &request, &line));
    assert_int_equal(line.parts, 2);
    sc_centerline_clear(&line);
    request.order = in_turn;
    assert_int_equal(sc_centerline_find(&listening, &request, &line), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "job.yaml:7: both do not touch one another"));
    assert_non_null(strstr(said.text, "mm before \"tube\" at ("));
    assert_null(line.points);
}

TEST(the_middle_is_where_tissues_are_thickest)
{
    const sc_volume v = small_volume();
    const int slab[] = {0, 0, 1}, tube[] = {0, 1, 0}, none[] = {0, 0, 0};
    sc_centerline_request request = {
        .volume = &v, .order = slab, .what = "slab", .where = "job.yaml:7"};
    sc_vec3 at = {0, 0, 0};

    /* The slab has its greatest depth nearly everywhere: its middle is that of its slices. */
    assert_ok(sc_centerline_middle(&quiet, &request, &at));
    assert_near(at.x, 19.5, 0.51);
    assert_near(at.y, 14.5, 0.51);
    assert_near(at.z, 43, 1.01);
    /* The bent tube holds its middle on its axis, half way along it, not at its center of mass. */
    request.order = tube;
    assert_ok(sc_centerline_middle(&quiet, &request, &at));
    assert_near(sqrt((at.x - 20) * (at.x - 20) + at.y * at.y), 14, 1.01);
    assert_near(at.x, 20, 3);
    assert_near(at.z, 16, 0.01);
    request.order = none;
    request.what = "nothing";
    assert_int_equal(sc_centerline_middle(&listening, &request, &at), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "job.yaml:7: the volume has no voxel of nothing"));
}

TEST(lines_take_no_more_memory_than_allowed)
{
    const sc_volume v = small_volume();
    sc_ctx ctx = quiet;
    SC_OWN(sc_centerline_clear) sc_centerline line = {0};

    ctx.memory_max_bytes = 1000;
    assert_int_equal(find(&ctx, &v, 1, NULL, 0, &line), SC_ERR_SYSTEM);
    for (long budget = 0;; budget++) { /* and one call after the other that gets none */
        long left = budget;
        sc_status status;

        ctx = quiet;
        ctx.alloc_budget = &left;
        status = find(&ctx, &v, 1, NULL, 0, &line);
        if (status == SC_OK)
            break;
        assert_int_equal(status, SC_ERR_MEMORY);
        assert_null(line.points);
    }
}

RUN_TESTS(NULL, NULL)
