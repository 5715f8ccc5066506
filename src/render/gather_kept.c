/* SPDX-License-Identifier: BSD-3-Clause */
/* Light that was gathered, kept in a file beside the prepared volume of the cache, whose name says
 * what it follows from: so the next picture of that volume, in the same look, need not gather it
 * again. What is in the file is believed only if it is whole and its user's own. */
#include "gather.h"
#include "internal.h"

#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { DIGITS = 16 /* of the name of the prepared volume, and of the hash */ };

enum { ARRAYS = SC_GATHER_FIELDS + 1 /* of the vertices of each field, and of the floor */ };

/* What a file begins with; the arrays follow. */
typedef struct kept_head {
    uint64_t bytes[ARRAYS]; /* of each; 0: there is none */
    uint64_t checksum;      /* of what follows */
} kept_head;

/* @return a hash of all that light follows from but the volume as it was prepared. */
static uint64_t hash_of(const sc_renderer *r, const sc_scene *scene)
{
    const sc_prepared *v = r->volume;
    const sc_lighting *l = scene->has_look ? &scene->look.light : &r->settings.light;
    uint64_t hash = sc_hash_bytes(&v->to_ras_mm, sizeof v->to_ras_mm, 0);

    hash = sc_hash_bytes(&l->ambient, sizeof l->ambient, hash);
    hash = sc_hash_bytes(&l->key, sizeof l->key, hash);
    hash = sc_hash_bytes(&r->light.sky.lamp, sizeof r->light.sky.lamp, hash);
    hash = sc_hash_bytes(&r->light.sky.gain, sizeof r->light.sky.gain, hash);
    hash = sc_hash_bytes(r->light.sky.coarse, sizeof r->light.sky.coarse, hash);
    hash = sc_hash_bytes(&r->march.box_low, sizeof r->march.box_low, hash);
    hash = sc_hash_bytes(&r->march.box_high, sizeof r->march.box_high, hash);
    for (int id = 0; id < v->label_count; id++) {
        const sc_march_tissue *t = &r->tissues[id];
        const float numbers[] = {t->rgb[0],
                                 t->rgb[1],
                                 t->rgb[2],
                                 t->boundary_alpha,
                                 (float)scene->clip.sets[t->clip_set],
                                 (float)t->show,
                                 (float)r->looks[id].show};

        hash = sc_hash_bytes(numbers, sizeof numbers, hash);
    }
    hash = sc_hash_bytes(&scene->clip.mode, sizeof scene->clip.mode, hash);
    for (int i = 0; i < scene->clip.count; i++) {
        const double plane[] = {scene->clip.planes[i].normal.x, scene->clip.planes[i].normal.y,
                                scene->clip.planes[i].normal.z, scene->clip.planes[i].offset_mm};

        hash = sc_hash_bytes(plane, sizeof plane, hash);
    }
    hash = sc_hash_bytes(&r->settings.floor, sizeof r->settings.floor, hash);
    return sc_hash_bytes(&r->derived.shows_inner, sizeof r->derived.shows_inner, hash);
}

sc_status sc_gather_kept_path(const sc_ctx *ctx, const sc_renderer *r, const sc_scene *scene,
                              const char *prepared, char **out)
{
    const char *slash = prepared ? strrchr(prepared, '/') : NULL;
    sc_text path = {0};

    *out = NULL;
    if (!slash || strlen(slash + 1) < DIGITS)
        return SC_OK;
    SC_PASS(sc_text_add(ctx, &path, "%.*s%.*s%016llx.light", (int)(slash + 1 - prepared), prepared,
                        DIGITS, slash + 1, (unsigned long long)hash_of(r, scene)));
    *out = path.data;
    return SC_OK;
}

/* @return array number @p i of a gather; NULL: there is none. @param bytes set to its size. */
static void *array_of(const sc_gather *g, int i, uint64_t *bytes)
{
    void *array = i < SC_GATHER_FIELDS ? (void *)g->fields[i].around : (void *)g->floor.light;

    *bytes = !array ? 0
             : i < SC_GATHER_FIELDS
                 ? g->fields[i].border->count * sizeof *g->fields[i].around
                 : (uint64_t)SC_FLOOR_SIDE * SC_FLOOR_SIDE * sizeof *g->floor.light;
    return array;
}

/* The head of the light of a gather. */
static kept_head head_of(const sc_gather *g)
{
    kept_head head = {.checksum = 0};

    for (int i = 0; i < ARRAYS; i++) {
        const void *array = array_of(g, i, &head.bytes[i]);

        if (array)
            head.checksum = sc_hash_bytes(array, head.bytes[i], head.checksum);
    }
    return head;
}

bool sc_gather_load(sc_gather *g, const char *path)
{
    const kept_head expected = head_of(g);
    const int file = open(path, O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
    FILE *stream = file >= 0 ? fdopen(file, "rb") : NULL;
    kept_head head;
    struct stat info;
    bool good = stream && !fstat(file, &info) && S_ISREG(info.st_mode) &&
                info.st_uid == geteuid() && fread(&head, sizeof head, 1, stream) == 1 &&
                !memcmp(head.bytes, expected.bytes, sizeof head.bytes);

    for (int i = 0; good && i < ARRAYS; i++) {
        uint64_t bytes;
        void *array = array_of(g, i, &bytes);

        good = !array || fread(array, 1, bytes, stream) == bytes;
    }
    good = good && head_of(g).checksum == head.checksum;
    if (good) /* it is used now: see kept.c */
        (void)!futimens(file,
                        (const struct timespec[]){{.tv_nsec = UTIME_NOW}, {.tv_nsec = UTIME_OMIT}});
    if (stream)
        fclose(stream);
    else if (file >= 0)
        close(file);
    return good;
}

void sc_gather_save(const sc_ctx *ctx, const sc_gather *g, const char *path)
{
    const kept_head head = head_of(g);
    sc_ctx silent = sc_quiet(ctx);
    SC_OWN(sc_outfile_discard) sc_outfile file = {0};

    silent.write = NULL; /* without it the light is gathered again, which is no error */
    if (sc_outfile_open(&silent, path, true, &file) != SC_OK)
        return;
    file.fleeting = true;
    fwrite(&head, sizeof head, 1, file.stream);
    for (int i = 0; i < ARRAYS; i++) {
        uint64_t bytes;
        const void *array = array_of(g, i, &bytes);

        if (array)
            fwrite(array, 1, bytes, file.stream);
    }
    (void)!sc_outfile_commit(&silent, &file);
}
