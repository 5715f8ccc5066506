/* SPDX-License-Identifier: BSD-3-Clause */
/* Compares every kernel that this processor can run with the plain march, ray by ray and bit by
 * bit, on rays that are likely to expose errors, and prints how long each takes.
 *
 * usage: kernels [RAYS]     RAYS for every surface and label width; releases are tested with
 * 10000000
 */
#include "check.h"

#include "shapes.h"

#include "segcast/kernel.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum {
    LABELS = 7,
    BATCH = 509, /* not a multiple of any number of SIMD lanes */
    KERNELS_MAX = 32
};

static const int size[3] = {61, 45, 53};

/* A prepared volume, and everything else that a kernel needs. */
typedef struct stage {
    sc_volume volume;
    prepared_copy prepared;
    sc_team *team; /* of what follows, down to the cells */
    uint64_t *masks;
    uint8_t *distances, *cell_distances[2]; /* by sc_metric */
    sc_pyramid pyramid;
    sc_cells cells;
    sc_march_tissue tissues[LABELS];
    sc_march march;
} stage;

/* The dense id of the voxel at (x, y, z): balls and walls in much empty space, a grid of single
 * voxels, and noise in a corner. */
static int scenery(double x, double y, double z)
{
    const double a = (x - 20) * (x - 20) + (y - 20) * (y - 20) + (z - 24) * (z - 24);
    const double b = (x - 45) * (x - 45) + (y - 25) * (y - 25) + (z - 35) * (z - 35);
    uint64_t seed = 1 + (uint64_t)x * 7919 + (uint64_t)y * 104729 + (uint64_t)z * 1299709;

    if (x > 44 && y > 34 && z < 12) {
        random_bits(&seed);
        return (int)((random_bits(&seed) >> 40) % 9) % LABELS;
    }
    if (a < 130)
        return a < 60 ? 2 : 1;
    if (b < 90)
        return x < 45 ? 3 : 4;
    if (fabs(0.3 * x + 0.1 * y + 0.95 * z - 48) < 0.56)
        return 5;
    return (int)x % 8 == 3 && (int)y % 8 == 3 && z > 40 ? 6 : 0;
}

/* Make and prepare the volume, with one tissue hidden and one in a second clip set, and
 * everything that kernels of the surface need, except s.march, which set_march sets once the
 * stage has its final address. The caller frees volume and block, and closes the team. */
static stage make_stage(sc_surface surface, int label_bytes)
{
    const double spacing[3] = {1, 1.2, 0.9};
    stage s = {.volume = shape_volume(size, spacing, label_bytes, LABELS, scenery)};
    const sc_prepared *v;
    uint8_t show[LABELS];

    s.prepared = prepare_copy(&s.volume, 2);
    v = &s.prepared.view;
    for (int id = 0; id < LABELS; id++) {
        show[id] = id == 0 ? 0 : id == 2 && surface == SC_SURFACE_VOXEL ? 3 : id == 4 ? 0 : 1;
        s.tissues[id] = (sc_march_tissue){.rgb = {0.1f * (float)id, 0.9f, 0.3f},
                                          .boundary_alpha = id == 3 ? 1 : 0.3f,
                                          .cap_alpha = 1,
                                          .thickness_factor = 1,
                                          .interior_alpha = 0.05f,
                                          .specular = 0.2f,
                                          .shininess = 1 + 3 * id,
                                          .show = show[id],
                                          .clip_set = id == 5};
    }
    assert_ok(sc_team_open(&quiet, NULL, 2, NULL, &s.team));
    if (surface == SC_SURFACE_SMOOTH) {
        assert_ok(sc_visible_cells(&quiet, s.team, v, show, &s.masks));
        assert_ok(sc_cells_build(&quiet, s.team, v, s.masks, &s.cells));
    } else {
        assert_ok(sc_visible_masks(&quiet, s.team, v, show, &s.masks));
    }
    assert_ok(sc_brick_distances(&quiet, s.team, v->bricks, s.masks, &s.distances));
    for (int metric = 0; metric < 2; metric++)
        assert_ok(sc_cell_distances(&quiet, s.team, v, s.masks, (sc_metric)metric,
                                    &s.cell_distances[metric]));
    assert_ok(sc_pyramid_build(&quiet, s.team, v, &s.masks, &s.pyramid));
    return s;
}

/* Fill in s->march, which points into the stage. */
static void set_march(stage *s)
{
    const sc_prepared *v = &s->prepared.view;
    sc_affine to_voxel = {0};

    s->march = (sc_march){
        .volume = v,
        .marked.masks = s->masks,
        .marked.row = sc_framed_row(v->bricks),
        .marked.layer = sc_framed_layer(v->bricks),
        .box_low = {-1.5f, -1.5f, -1.5f},
        .box_high = {(float)v->size[0] + 2.5f, (float)v->size[1] + 2.5f, (float)v->size[2] + 2.5f},
        .marked.distances = s->distances,
        .marked.pyramid = &s->pyramid,
        .marked.cell_start = s->cells.start,
        .marked.cells = s->cells.cells,
        .tissues = s->tissues,
        .step_mm = 0.45f,
        .opaque_below = SC_OPAQUE,
        .light = {.key_direction = {0.6f, 0, 0.8f},
                  .fill_direction = {0, 1, 0},
                  .ambient = 0.2f,
                  .key = 0.5f,
                  .fill = 0.2f,
                  .head = 0.2f,
                  .edges = 0.5f,
                  .cue = 0.3f,
                  .cue_near_mm = 10,
                  .cue_far_mm = 90,
                  .cue_rgb = {1, 1, 1}}};
    assert_true(sc_affine_invert(&v->to_ras_mm, &to_voxel));
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            s->march.grid_per_mm[i][j] = (float)to_voxel.m[i][j];
    }
}

/* One of @p count values at random. */
static double pick(uint64_t *seed, const double *values, int count)
{
    return values[(random_bits(seed) >> 33) % (uint64_t)count];
}

/* @return a component of a direction that is zero, denormal or very small. */
static double least_component(uint64_t *seed)
{
    static const double values[] = {0, -0.0, 1e-45, -1e-38, 1e-30, 1e-20, -1.1e-20, 1e-12, -1e-7};

    return pick(seed, values, SC_COUNT_OF(values));
}

/* Origin and direction of a random ray, in grid coordinates, to @p from and @p along, which is
 * not of unit length. @p kind: 1 to 4: special directions that random ones never have; else
 * random. */
static void aim(uint64_t *seed, int kind, double from[3], double along[3])
{
    static const double small[] = {-3, -2, -1, 0, 1, 2, 3};

    for (int i = 0; i < 3; i++) {
        from[i] = random_real(seed, -1, size[i] + 2);
        along[i] = random_real(seed, -1, 1);
    }
    if (kind == 1 || kind == 2) { /* 1: in a plane of the grid; 2: along an axis, or nearly so */
        for (int i = 0; i < kind; i++)
            along[(random_bits(seed) >> 33) % 3] = least_component(seed);
        for (int i = 0; i < 3; i++)
            from[i] = i == kind ? from[i] : floor(from[i]) + pick(seed, (double[]){0, 0.5}, 2);
    } else if (kind == 3) { /* through edges and corners of cells */
        for (int i = 0; i < 3; i++) {
            from[i] = floor(from[i]);
            along[i] = pick(seed, small, SC_COUNT_OF(small));
        }
    } else if (kind == 4) { /* nearly along an axis, and nearly in a plane of the grid */
        const int axis = (int)((random_bits(seed) >> 33) % 3);

        for (int i = 0; i < 3; i++) {
            along[i] = i == axis ? 1 : random_real(seed, -1e-4, 1e-4);
            from[i] = floor(from[i]) + random_real(seed, -1e-5, 1e-5);
        }
    }
    if (along[0] * along[0] + along[1] * along[1] + along[2] * along[2] < 1e-6)
        along[2] = -1;
}

/* The stretch of the ray within the volume and a voxel around it, from its origin on, to @p
 * begin and @p end (in lengths of @p along). @return false if there is none. */
static bool within(const double from[3], const double along[3], double *begin, double *end)
{
    const sc_box3 box = {{-1.5, -1.5, -1.5}, {size[0] + 2.5, size[1] + 2.5, size[2] + 2.5}};

    *begin = 0;
    *end = 1e9;
    return sc_box3_clip_line(&box, (sc_vec3){from[0], from[1], from[2]},
                             (sc_vec3){along[0], along[1], along[2]}, begin, end);
}

/* Fill in a part of a ray from @p begin to @p end, in mm, without a cut face; @p step: between
 * samples, in mm. */
static void set_part(sc_ray_part *part, double begin, double end, double step)
{
    *part = (sc_ray_part){.begin_mm = (float)begin,
                          .end_mm = (float)end,
                          .first = (int32_t)ceil(begin / step - 0.5),
                          .last = (int32_t)ceil(end / step - 0.5),
                          .cap_plane = -1};
}

/* A random ray that meets the volume, with one or two clip sets and parts of several kinds.
 * @param seed advanced. @param step_mm distance between samples. */
static sc_ray make_ray(uint64_t *seed, sc_surface surface, double step_mm)
{
    const int kind = (int)((random_bits(seed) >> 33) % 6);
    const double shift = surface == SC_SURFACE_VOXEL ? 0.5 : 0;
    double from[3], along[3], begin, end, length;
    sc_ray ray = {.clip_sets = 1, .part_count = {1, 1}};

    do {
        aim(seed, kind, from, along);
        length = sqrt(along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
        for (int i = 0; i < 3; i++) {
            along[i] /= length;
            if (kind == 5) /* the origin lies far outside the volume */
                from[i] -= 70 * along[i];
        }
    } while (!within(from, along, &begin, &end));
    for (int i = 0; i < 3; i++) {
        ray.origin[i] = (float)(from[i] + shift);
        ray.direction[i] = (float)along[i];
        ray.toward_eye[i] = (float)-along[i];
    }
    set_part(&ray.parts[0][0], begin, end, step_mm);
    switch ((random_bits(seed) >> 33) % 8) {
    case 0: /* an empty part */
        set_part(&ray.parts[0][0], begin, begin, step_mm);
        break;
    case 1: /* two clip sets with different parts, one of them with two */
        ray.clip_sets = 2;
        ray.part_count[1] = 2;
        set_part(&ray.parts[0][0], begin, begin + 0.6 * (end - begin), step_mm);
        set_part(&ray.parts[1][0], begin, begin + 0.3 * (end - begin), step_mm);
        set_part(&ray.parts[1][1], begin + 0.5 * (end - begin), end, step_mm);
        break;
    case 2: /* a part that begins within the volume */
        set_part(&ray.parts[0][0], begin + 0.43 * (end - begin), end, step_mm);
        break;
    case 3: /* a ray that ends where less than half of the light is left */
        ray.ends_below = 0.5f;
        break;
    default:
        break;
    }
    return ray;
}

/* Fail the test, naming the kernel and the ray, unless every byte of both results is the same. */
static void expect_equal(const sc_kernel *kernel, const sc_ray *ray, const sc_radiance *expected,
                         const sc_radiance *found)
{
    if (memcmp(expected, found, sizeof *found) == 0)
        return;
    fail_msg("%s/%s: the ray from (%a, %a, %a) along (%a, %a, %a), %a to %a mm, has colour "
             "(%a, %a, %a), depth %a, transmittance %a; expected (%a, %a, %a), %a, %a",
             kernel->name, kernel->cpu, ray->origin[0], ray->origin[1], ray->origin[2],
             ray->direction[0], ray->direction[1], ray->direction[2], ray->parts[0][0].begin_mm,
             ray->parts[0][0].end_mm, found->rgb[0], found->rgb[1], found->rgb[2], found->depth_mm,
             found->transmittance, expected->rgb[0], expected->rgb[1], expected->rgb[2],
             expected->depth_mm, expected->transmittance);
}

/* Find the kernels for a surface and the label width of a volume that this processor can run, to
 * @p out, the plain march (SC_SKIP_NONE) first. @return how many. */
static int find_kernels(sc_surface surface, const sc_prepared *v, const sc_kernel *out[KERNELS_MAX])
{
    int count = 0;

    for (int skip = SC_SKIP_NONE; skip <= SC_SKIP_LEAP; skip++) {
        for (int i = 1; sc_cpu_names[i]; i++) {
            const sc_kernel *kernel = NULL;

            if (sc_cpu_has(sc_cpu_names[i]))
                kernel = sc_kernel_find(surface, (sc_skip)skip, v, sc_cpu_names[i]);
            if (kernel && (count == 0 || out[count - 1] != kernel))
                out[count++] = kernel;
            assert_true(count < KERNELS_MAX);
        }
    }
    return count;
}

/* Set how far a ray goes next: only to see where a surface comes, past that one, or on beyond it.
 * The same for every kernel, if all have stopped at the same places. @param turn number of the
 * piece. */
static void allow(sc_way *way, int turn)
{
    uint64_t seed = 5 + (uint64_t)turn * 131 + (uint64_t)(way->next_mm * 1024);

    random_bits(&seed);
    way->before_mm = turn ? nextafterf(way->next_mm, HUGE_VALF) : 0;
    way->limit_mm = way->before_mm + (float)pick(&seed, (double[]){0, 0.5, 3, 20}, 4);
}

/* March a batch piece by piece, to @p out. @param stops [BATCH] set to a hash of where each ray has
 * stopped. */
static void march_in_pieces(const sc_kernel *kernel, const sc_march *march, const sc_ray *batch,
                            sc_radiance *out, uint64_t *stops, sc_march_counters *counters)
{
    enum { TURNS_MAX = 100000 /* so many only if rays do not come on */ };
    static sc_ray rays[BATCH];
    static sc_way ways[BATCH];
    static sc_radiance light[BATCH];
    int index[BATCH], left = BATCH; /* rays that are not done, and how many */

    for (int i = 0; i < BATCH; i++) {
        index[i] = i;
        rays[i] = batch[i];
        ways[i] = sc_way_begin();
        light[i] = sc_no_light();
        stops[i] = 0;
    }
    for (int turn = 0, count; left; turn++) {
        assert_true(turn < TURNS_MAX);
        for (int k = 0; k < left; k++)
            allow(&ways[k], turn);
        kernel->march(march, rays, ways, (size_t)left, light, counters);
        count = left;
        left = 0;
        for (int k = 0; k < count; k++) {
            if (ways[k].next_mm == HUGE_VALF) {
                out[index[k]] = light[k];
                continue;
            }
            assert_true(ways[k].next_mm >= ways[k].before_mm);
            assert_int_equal(ways[k].passed, turn > 0);
            stops[index[k]] = stops[index[k]] * 31 + (uint64_t)(ways[k].next_mm * 1e6f);
            index[left] = index[k];
            rays[left] = rays[k];
            ways[left] = ways[k];
            light[left++] = light[k];
        }
    }
}

/* Fail unless every kernel brings back the light @p expected from a batch also if it stops on the
 * way, and stops where the first one does. */
static void compare_pieces(const sc_kernel *const *kernels, int count, stage *s,
                           const sc_ray *batch, const sc_radiance *expected)
{
    static sc_radiance found[BATCH];
    static uint64_t stops[2][BATCH];
    sc_march_counters counters[2];

    for (int k = 0; k < count; k++) {
        sc_march_counters *here = &counters[k > 0];

        *here = (sc_march_counters){0};
        s->march.marked.cell_distances = s->cell_distances[kernels[k]->skip == SC_SKIP_CHESSBOARD];
        march_in_pieces(kernels[k], &s->march, batch, found, stops[k > 0], here);
        for (int i = 0; i < BATCH; i++) {
            expect_equal(kernels[k], &batch[i], &expected[i], &found[i]);
            assert_int_equal(stops[k > 0][i], stops[0][i]);
        }
        assert_int_equal(here->contributions, counters[0].contributions);
        assert_int_equal(here->rays, counters[0].rays);
        assert_true(here->rays > BATCH);
    }
}

/* March @p rays random rays (rounded up to whole batches) with every kernel of a surface and
 * label width; fail unless all results and contributions equal those of the plain march. Prints
 * the time of each. */
static void compare(sc_surface surface, int label_bytes, long rays)
{
    enum { PIECES_EVERY = 16 /* batches: it takes long */ };
    static sc_ray batch[BATCH];
    static sc_radiance expected[BATCH], found[BATCH];
    stage s = make_stage(surface, label_bytes);
    const sc_kernel *kernels[KERNELS_MAX];
    sc_march_counters counters[KERNELS_MAX] = {{0}};
    double cpu_s[KERNELS_MAX] = {0};
    uint64_t seed = 77 + (uint64_t)label_bytes;
    int count;

    set_march(&s);
    count = find_kernels(surface, &s.prepared.view, kernels);
    for (long done = 0; done < rays; done += BATCH) {
        for (int i = 0; i < BATCH; i++)
            batch[i] = make_ray(&seed, surface, (double)s.march.step_mm);
        for (int k = 0; k < count; k++) {
            const double begin_s = sc_thread_cpu_s();

            s.march.marked.cell_distances =
                s.cell_distances[kernels[k]->skip == SC_SKIP_CHESSBOARD];
            kernels[k]->march(&s.march, batch, NULL, BATCH, k ? found : expected, &counters[k]);
            cpu_s[k] += sc_thread_cpu_s() - begin_s;
            for (int i = 0; k && i < BATCH; i++)
                expect_equal(kernels[k], &batch[i], &expected[i], &found[i]);
        }
        if (done / BATCH % PIECES_EVERY == 0)
            compare_pieces(kernels, count, &s, batch, expected);
    }
    assert_true(counters[0].contributions > counters[0].rays / 4);
    for (int k = 0; k < count; k++) {
        assert_int_equal(counters[k].contributions, counters[0].contributions);
        printf("%-20s %-7s %10llu rays equal, %7.1f ns a ray, %5.2f of the plain march's time\n",
               kernels[k]->name, kernels[k]->cpu, (unsigned long long)counters[k].rays,
               1e9 * cpu_s[k] / (double)counters[k].rays, cpu_s[k] / cpu_s[0]);
    }
    sc_team_close(s.team);
    sc_free(s.prepared.block);
    sc_volume_clear(&s.volume);
}

/* Rays for every surface and label width; main() sets it from the command line. */
static long ray_count = 100000;

/* For both surfaces and both label widths, with ray_count rays each. */
TEST(every_kernel_gives_the_bits_of_the_plain_march)
{
    for (int bytes = 1; bytes <= 2; bytes++) {
        compare(SC_SURFACE_VOXEL, bytes, ray_count);
        compare(SC_SURFACE_SMOOTH, bytes, ray_count);
    }
}

int main(int argc, char **argv)
{
    if (argc > 1)
        ray_count = strtol(argv[1], NULL, 10);
    return run_all_tests(NULL, NULL);
}
