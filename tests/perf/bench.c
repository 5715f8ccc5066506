/* SPDX-License-Identifier: BSD-3-Clause */
/* Measures how long frames take: one volume, prepared once, is drawn with every combination of the
 * values given. CPU seconds are those of the whole process, the least of several repetitions. In
 * each repetition all combinations are drawn in turn, so that a disturbance of the machine meets
 * them all.
 *
 * usage: bench VOLUME [KEY=VALUE,VALUE...]...
 *   scene    peers (colours, opacities, light and camera of the programs it is compared with),
 *            heart, or paper: heart without light
 *   surface  smooth, voxel           layers   opaque, all
 *   skip     as render.skip of a job cpu      auto, or a variant: see segcast render --help
 *   size     1920x1080               threads  1
 *   samples  1 (rays per pixel at edges)
 *   light    plain; path: 16 paths in each pixel; gather: no frame is drawn, but the rays of all
 *            places are followed through which light is gathered all around
 *   frames   of a turn of 36         repeat   times */
#include "segcast/job.h"
#include "segcast/render.h"
#include "segcast/timeline.h"

#include "internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

enum { LIST_MAX = 8, TURN = 36, FAT = 11 };

/* The values given for one key of the command line; text is cut at its commas into values. */
typedef struct list {
    const char *key;
    char text[200];
    const char *values[LIST_MAX];
    int count;
} list;

enum { SCENE, SURFACE, LAYERS, SKIP, CPU, SIZE, THREADS, SAMPLES, LIGHT, FRAMES, REPEAT, KEYS };

static list lists[KEYS] = {
    {.key = "scene", .text = "heart"},   {.key = "surface", .text = "smooth"},
    {.key = "layers", .text = "opaque"}, {.key = "skip", .text = "leap"},
    {.key = "cpu", .text = "auto"},      {.key = "size", .text = "1920x1080"},
    {.key = "threads", .text = "1"},     {.key = "samples", .text = "1"},
    {.key = "light", .text = "plain"},   {.key = "frames", .text = "3"},
    {.key = "repeat", .text = "3"}};

/* A prepared volume, and the tissues with which it was last drawn. */
typedef struct prepared_set {
    void *block;      /* owned: sc_free */
    sc_prepared view; /* of the block */
    sc_tissue tissues[SC_LABELS_MAX];
    double cpu_s; /* that preparing took */
    bool opaque;  /* prepared for layers=opaque; else for all */
} prepared_set;

/* One combination of values, and what was measured of it. */
typedef struct entry {
    const char *value[KEYS];
    sc_renderer *renderer;
    sc_timeline timeline;
    sc_image image;
    double derive_cpu_s;        /* to make the renderer */
    double cpu_s, wall_s;       /* a frame, the least of all repetitions */
    sc_march_counters counters; /* of all frames of the last repetition */
} entry;

static const sc_ctx ctx = {.level = SC_LOG_WARN};

/* End the program with exit code 1 if a call has failed; the library has written why. */
static void must(sc_status status)
{
    if (status != SC_OK)
        exit(1);
}

/* CPU seconds that all threads of the process have used so far. */
static double process_cpu_s(void)
{
    struct rusage r;

    getrusage(RUSAGE_SELF, &r);
    return (double)(r.ru_utime.tv_sec + r.ru_stime.tv_sec) +
           1e-6 * (double)(r.ru_utime.tv_usec + r.ru_stime.tv_usec);
}

/* The colour and opacity that the programs segcast is compared with give label @p value (13 and
 * more: those of 12): the opacity of one crossing (smooth), or as they have it for volumes,
 * which draw a boundary two voxel lengths thick (@p voxel). Fat is hidden if @p opaque. */
static sc_tissue peers_tissue(uint32_t value, bool opaque, bool voxel)
{
    static const float rgb[13][3] = {{0},
                                     {.75f, .30f, .28f},
                                     {.86f, .10f, .12f},
                                     {.20f, .30f, .80f},
                                     {.90f, .35f, .25f},
                                     {.35f, .45f, .90f},
                                     {.95f, .15f, .10f},
                                     {.25f, .55f, .85f},
                                     {.93f, .75f, .60f},
                                     {.65f, .42f, .40f},
                                     {.80f, .58f, .45f},
                                     {.95f, .85f, .45f},
                                     {1, .9f, .1f}};
    static const double alpha[13] = {0, .35, .8, .8, .8, .8, .9, .8, .45, .35, .4, .15, 1};
    const uint32_t n = value < 13 ? value : 12;
    sc_tissue t = {.visible = !(opaque && n == FAT), .material = {.roughness = 1}};

    t.opacity = opaque ? 1 : voxel ? 1 - sqrt(1 - 0.98 * alpha[n]) : alpha[n];
    memcpy(t.rgb_linear, rgb[n], sizeof t.rgb_linear);
    return t;
}

/* Set p->tissues: those of the peers, or by the rules of the heart, opaque or by thickness. */
static void set_tissues(prepared_set *p, bool peers, bool voxel)
{
    const sc_tissue_rule solid = {.pattern = "*", .has.opacity = true, .opacity = 1};
    const sc_tissue_rule by_thickness = {.pattern = "*", .has.opacity = true, .opacity_auto = true};

    if (!peers) {
        sc_transfer_resolve(&p->view, p->opaque ? &solid : &by_thickness, 1, SC_OPACITY_PAPER,
                            p->tissues);
        return;
    }
    for (int id = 1; id < p->view.label_count; id++)
        p->tissues[id] = peers_tissue((uint32_t)p->view.labels[id].value, p->opaque, voxel);
}

/* Read and prepare a volume as a job would, to @p out: hidden tissues are background.
 * Ends the program on failure. The caller
 * frees out->block. */
static void prepare(const char *path, bool peers, bool opaque, prepared_set *out)
{
    sc_prepare_settings settings = {.smooth = {1, 1, 1}, .threads = atoi(lists[THREADS].values[0])};
    sc_preparation *preparation;
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    bool hidden[SC_LABELS_MAX] = {false};
    double begin_s;
    size_t bytes;

    must(sc_volume_read(&ctx, path, &volume));
    begin_s = process_cpu_s();
    for (int id = 1; peers && opaque && id < volume.label_count; id++)
        hidden[id] = volume.labels[id].value == FAT;
    sc_volume_hide(&volume, hidden, settings.threads);
    must(sc_prepare(&ctx, &volume, &settings, &preparation));
    bytes = sc_preparation_bytes(preparation);
    must(sc_alloc(&ctx, bytes, 1, &out->block));
    sc_preparation_pack(preparation, out->block);
    must(sc_prepared_view(&ctx, out->block, bytes, &out->view));
    out->cpu_s = process_cpu_s() - begin_s;
    out->opaque = opaque;
    sc_preparation_free(preparation);
}

/* The camera of the peers at frame @p frame of a turn around the middle of the heart. */
static sc_camera peers_camera(int frame)
{
    const sc_vec3 middle = {234, 162, 243};
    const double turn = 2 * 3.14159265358979323846 * frame / TURN, up = 0.20943951023931956;
    const sc_vec3 eye = {234 + 1100 * cos(up) * sin(turn), 162 - 1100 * cos(up) * cos(turn),
                         243 + 1100 * sin(up)};

    return sc_camera_look(eye, middle, (sc_vec3){0, 0, 1}, SC_PERSPECTIVE, tan(0.2617993877991494));
}

/* Draw a frame of the turn into e->image, and add to e->counters. */
static void draw(entry *e, int frame)
{
    sc_scene scene = sc_timeline_scene(&e->timeline, frame, NULL);
    sc_render_stats stats;

    if (strcmp(e->value[SCENE], "peers") == 0)
        scene.camera = peers_camera(frame);
    if (e->renderer->light.gather) {
        sc_gather_trace(NULL, e->renderer->light.gather, &scene, false, 0);
        e->counters.rays += e->renderer->light.gather->count * SC_GATHER_DIRECTIONS;
        return;
    }
    sc_render_view(e->renderer, &scene, NULL, NULL, NULL, &e->image, &stats);
    sc_add_counters(&e->counters, &stats.counters);
}

/* Set the skip method of that name, and the light of a job that sets none of its keys. */
static void set_from_job(const char *skip, sc_render_settings *s)
{
    const sc_setting settings[] = {{"bench", "volume", "phantom", true},
                                   {"bench", "render.skip", skip, true}};
    const sc_job_sources sources = {.settings = settings, .setting_count = 2};
    SC_OWN(sc_job_clear) sc_job job = {0};

    must(sc_job_load(&ctx, &sources, &job));
    s->light = job.light.constant;
    s->skip = (sc_skip)job.render.skip;
}

/* Make the renderer, image and timeline of an entry whose values have been set, and draw a first
 * frame, which is not measured. Ends the program on failure. The caller frees renderer and
 * image; both borrow @p p. */
static void start(entry *e, prepared_set *p)
{
    const bool voxel = strcmp(e->value[SURFACE], "voxel") == 0;
    const bool peers = strcmp(e->value[SCENE], "peers") == 0;
    const bool paths = strcmp(e->value[LIGHT], "path") == 0;
    const bool gathers = strcmp(e->value[LIGHT], "gather") == 0;
    sc_scene scene;
    sc_animation a = {
        .frames = TURN,
        .camera = {.axis = {0, 0, 1}, .turns = 1, .elevation_deg = 12, .fov_deg = 30, .zoom = 1}};
    sc_render_settings s = {
        .surface = voxel ? SC_SURFACE_VOXEL : SC_SURFACE_SMOOTH,
        .cpu = e->value[CPU],
        .sampling.samples = atoi(e->value[SAMPLES]),
        .step_voxels = 0.5,
        .caps = true,
        .work = {.tile_px = 32, .threads = atoi(e->value[THREADS])},
    };
    const sc_vec3 *hull;
    size_t count;

    if (sscanf(e->value[SIZE], "%dx%d", &s.width_px, &s.height_px) != 2)
        exit(64);
    set_from_job(e->value[SKIP], &s);
    if (peers) /* in those programs 0.2 of the light is ambient, and 0.8 comes from the eye */
        s.light = (sc_lighting){.ambient = 0.2, .head = 0.8};
    if (strcmp(e->value[SCENE], "paper") == 0)
        s.light.method = SC_LIGHT_FLAT;
    if (paths || gathers) {
        s.light = (sc_lighting){.method = paths ? SC_LIGHT_PATH : SC_LIGHT_GLOBAL, .ambient = 1};
        s.sampling.lens_samples = paths ? 16 : 0;
    }
    set_tissues(p, peers, voxel);
    e->derive_cpu_s = process_cpu_s();
    must(sc_renderer_new(&ctx, &s, &p->view, p->tissues, &e->renderer));
    e->derive_cpu_s = process_cpu_s() - e->derive_cpu_s;
    must(sc_image_init(&ctx, s.width_px, s.height_px, &e->image));
    hull = sc_renderer_hull(e->renderer, &count);
    sc_timeline_resolve(&a, hull, count, (double)s.width_px / s.height_px, &e->timeline);
    e->cpu_s = e->wall_s = HUGE_VAL;
    scene = sc_timeline_scene(&e->timeline, 0, NULL);
    must(sc_renderer_gather(&ctx, e->renderer, &scene, SC_LIGHT_NEW_RAYS, NULL));
    draw(e, 0);
}

/* Draw the frames of one repetition; keep the counters, and the times of a frame if they are the
 * least so far. */
static void measure(entry *e)
{
    const int frames = atoi(e->value[FRAMES]);
    const double cpu_s = process_cpu_s(), wall_s = sc_wall_s();
    double cpu, wall;

    memset(&e->counters, 0, sizeof e->counters);
    for (int i = 0; i < frames; i++)
        draw(e, i * TURN / frames + 2);
    cpu = (process_cpu_s() - cpu_s) / frames;
    wall = (sc_wall_s() - wall_s) / frames;
    e->cpu_s = cpu < e->cpu_s ? cpu : e->cpu_s;
    e->wall_s = wall < e->wall_s ? wall : e->wall_s;
}

/* Print one line of KEY=VALUE with what was measured of an entry. */
static void report(const entry *e, const prepared_set *p)
{
    const double frames = atoi(e->value[FRAMES]);
    const sc_march_counters *c = &e->counters;
    const double rays = (double)c->rays / frames;
    const double pixels = (double)e->image.width_px * e->image.height_px;

    for (int key = 0; key <= LIGHT; key++)
        printf("%s=%s ", lists[key].key, e->value[key]);
    printf(
        "kernel=%s/%s cpu_s=%.4f wall_s=%.4f mrays_per_cpu_s=%.2f prepare_cpu_s=%.2f "
        "derive_cpu_s=%.2f derived_mb=%.1f "
        "rays=%.0f brick_steps_per_ray=%.2f cell_visits_per_ray=%.2f contributions_per_ray=%.3f\n",
        sc_renderer_kernel(e->renderer)->name, sc_renderer_kernel(e->renderer)->cpu, e->cpu_s,
        e->wall_s, pixels / e->cpu_s * 1e-6, p->cpu_s, e->derive_cpu_s,
        (double)sc_renderer_derived_bytes(e->renderer) * 1e-6, rays,
        (double)c->brick_steps / frames / rays, (double)c->cell_visits / frames / rays,
        (double)c->contributions / frames / rays);
    fflush(stdout);
}

/* Cut l->text at its commas into l->values; values beyond LIST_MAX are dropped. */
static void split(list *l)
{
    l->count = 0;
    for (char *at = strtok(l->text, ","); at && l->count < LIST_MAX; at = strtok(NULL, ","))
        l->values[l->count++] = at;
}

/* Clear @p e and set its values to combination number @p n of the values of all lists except the
 * layers, which are given. The texts stay borrowed. */
static void combine(int n, const char *layers, entry *e)
{
    *e = (entry){0};
    for (int key = 0; key < KEYS; key++) {
        if (key == LAYERS) {
            e->value[key] = layers;
            continue;
        }
        e->value[key] = lists[key].values[n % lists[key].count];
        n /= lists[key].count;
    }
}

/* Prepare the volume for one value of layers, measure all combinations of the other keys with it
 * and print a line for each. Ends the program if there are more than 128. */
static void bench_layers(const char *path, const char *layers)
{
    static entry entries[128];
    prepared_set *p = calloc(1, sizeof *p);
    int count = 1;

    for (int key = 0; key < KEYS; key++)
        count *= key == LAYERS ? 1 : lists[key].count;
    if (!p || count > 128)
        exit(70);
    prepare(path, strcmp(lists[SCENE].values[0], "peers") == 0, strcmp(layers, "opaque") == 0, p);
    for (int n = 0; n < count; n++) {
        combine(n, layers, &entries[n]);
        start(&entries[n], p);
    }
    for (int i = 0; i < atoi(lists[REPEAT].values[0]); i++) {
        for (int n = 0; n < count; n++)
            measure(&entries[n]);
    }
    for (int n = 0; n < count; n++) {
        report(&entries[n], p);
        sc_renderer_free(entries[n].renderer);
        sc_image_clear(&entries[n].image);
    }
    sc_free(p->block);
    free(p);
}

/* Store KEY=VALUE,... in the list of its key; a text too long for it is cut. @return false if it
 * is none, or the key is unknown. */
static bool parse_argument(const char *argument)
{
    for (int key = 0; key < KEYS; key++) {
        const size_t length = strlen(lists[key].key);

        if (strncmp(argument, lists[key].key, length) == 0 && argument[length] == '=') {
            snprintf(lists[key].text, sizeof lists[key].text, "%s", argument + length + 1);
            return true;
        }
    }
    return false;
}

int main(int argc, char **argv)
{
    for (int i = 2; i < argc; i++) {
        if (!parse_argument(argv[i])) {
            fprintf(
                stderr,
                "bench: \"%s\" is not KEY=VALUE,... with a known key; see the head of bench.c\n",
                argv[i]);
            return 64;
        }
    }
    if (argc < 2) {
        fprintf(stderr, "usage: bench VOLUME [KEY=VALUE,VALUE...]...\n");
        return 64;
    }
    for (int key = 0; key < KEYS; key++)
        split(&lists[key]);
    for (int i = 0; i < lists[LAYERS].count; i++)
        bench_layers(argv[1], lists[LAYERS].values[i]);
    return 0;
}
