/* SPDX-License-Identifier: BSD-3-Clause */
/* Where the subjects of a comparison stand: in space, and in the picture; and what they are called
 * there. */
#include "panels.h"
#include "segcast/views.h"

#include <math.h>

/* ---- in space ---- */

/* Find the middle, RAS mm, of the box around the tissues that a subject shows; of its whole volume
 * if it shows none, or if its voxels were not read. */
static sc_status find_middle(const sc_ctx *ctx, const sc_panel *subject, sc_vec3 *out)
{
    const sc_prepared *v = &subject->volume;
    sc_box3 box = SC_BOX3_EMPTY;
    SC_OWN(sc_free_at) bool *hidden = NULL;

    SC_PASS(SC_ZALLOC(ctx, (size_t)v->label_count, &hidden));
    SC_PASS(sc_hidden_labels(ctx, v->labels, v->label_count, subject->job.tissues.rules,
                             subject->job.tissues.rule_count, hidden));
    for (int id = 1; id < v->label_count; id++) {
        for (int corner = 0; corner < 8 && !hidden[id] && v->stats[id].voxels; corner++)
            sc_box3_hold(&box, sc_tissue_corner(v, id, corner));
    }
    if (box.low.x > box.high.x)
        box = sc_grid_box_mm(v->size, &v->to_ras_mm);
    *out = sc_vec3_scale(sc_vec3_add(box.low, box.high), 0.5);
    return SC_OK;
}

/* Move the view of a subject's volume. */
static sc_status move(const sc_ctx *ctx, sc_vec3 by_mm, sc_panel *subject, sc_joined *joined)
{
    sc_prepared *v = &subject->volume;
    sc_stored *stored = &v->stored;
    sc_vec3 *hull;

    if (sc_vec3_length(by_mm) == 0)
        return SC_OK;
    subject->grey.moved_mm = by_mm;
    v->to_ras_mm.m[0][3] += by_mm.x;
    v->to_ras_mm.m[1][3] += by_mm.y;
    v->to_ras_mm.m[2][3] += by_mm.z;
    if (!stored->hull)
        return SC_OK;
    SC_PASS(SC_ALLOC(ctx, stored->hull_count, &hull));
    joined->owned[6] = hull;
    for (size_t i = 0; i < stored->hull_count; i++)
        hull[i] = sc_vec3_add(stored->hull[i], by_mm);
    stored->hull = hull;
    return SC_OK;
}

sc_status sc_align_subjects(sc_app *app, sc_panel *subjects, int count, sc_joined *joined)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_vec3 middles[SC_SUBJECTS_MAX] = {{0, 0, 0}};
    sc_status status = SC_OK;

    if (subjects[0].job.compare.align == SC_ALIGN_NONE)
        return SC_OK;
    for (int s = 0; s < count && first && status == SC_OK; s++)
        status = find_middle(app->ctx, &subjects[s], &middles[s]);
    SC_PASS(sc_comm_agree(app->comm, status));
    sc_comm_broadcast(app->comm, middles, sizeof middles);
    for (int s = 1; s < count && status == SC_OK; s++)
        status = move(app->ctx, sc_vec3_sub(middles[0], middles[s]), &subjects[s], &joined[s]);
    return sc_comm_agree(app->comm, status);
}

/* ---- in the picture ---- */

/* Sizes in those of the font of the overlays, of which captions are larger. */
#define CAPTION 1.25
#define LETTER (0.72 * CAPTION) /* mean width of a letter, in bold */
#define ONE_LINE 2.2            /* height for one line of text below a picture, with its margins */
#define NEXT_LINE (1.3 * CAPTION)
#define WIDTH 0.9        /* share of a panel that a name takes */
#define CORNER_WIDTH 0.4 /* ... of the picture, in a corner */
#define SMALLEST 0.55    /* what the font of long names may shrink to */
enum { LEAST_PX = 9 };   /* the smallest font */

/* @return how many letters the longest line of a name has. */
static int longest_line(const char *name)
{
    int most = 0, letters = 0;

    for (size_t at = 0, bytes; name[at]; at += bytes ? bytes : 1) {
        bytes = sc_utf8_bytes(name + at);
        letters = name[at] == '\n' ? 0 : letters + 1;
        most = letters > most ? letters : most;
    }
    return most;
}

/* @return how many lines a name takes, if about so many letters fit into one. */
static int lines_of(const char *name, double letters)
{
    int lines = 0;

    while (*name && lines < SC_CAPTION_LINES_MAX) {
        char line[SC_CAPTION_BYTES];
        const size_t bytes = strcspn(name, "\n");

        snprintf(line, sizeof line, "%.*s", (int)bytes, name);
        lines += (int)fmax(1, ceil(longest_line(line) / fmax(letters, 1)));
        name += bytes + (name[bytes] == '\n');
    }
    return lines < SC_CAPTION_LINES_MAX ? lines : SC_CAPTION_LINES_MAX;
}

/* Choose the size of the font of the names, and the room for them, in panels that are so wide. */
static void size_names(const sc_job *job, const sc_caption *names, const int size_px[2],
                       double width_px, sc_places *out)
{
    const double full_px = fmax(LEAST_PX, job->overlays.text_percent / 100 * size_px[1]);
    int longest = 1, lines = 1;

    for (int s = 0; s < sc_subject_count(job); s++) {
        const int letters = longest_line(names[s].text);

        longest = letters > longest ? letters : longest;
    }
    out->text_px = fmin(full_px, width_px / (LETTER * longest));
    out->text_px = fmax(out->text_px, fmax(LEAST_PX, SMALLEST * full_px));
    for (int s = 0; s < sc_subject_count(job); s++) {
        const int own = lines_of(names[s].text, width_px / (LETTER * out->text_px));

        lines = own > lines ? own : lines;
    }
    out->below_px =
        (int)fmin(ceil((ONE_LINE + (lines - 1) * NEXT_LINE) * out->text_px), size_px[1] / 3.0);
}

/* @return the shorter side of a panel: what is shown in it turns, so that it is about as wide as it
 * is high. */
static int shorter_side(const sc_viewport *panel)
{
    return panel->width_px < panel->height_px ? panel->width_px : panel->height_px;
}

void sc_place_subjects(const sc_job *job, const sc_caption *names, const int size_px[2],
                       sc_places *out)
{
    const int count = sc_subject_count(job);
    sc_places tried = {.below_px = 0};

    *out = tried;
    if (job->compare.has_divider) {
        size_names(job, names, size_px, CORNER_WIDTH * size_px[0], out);
        for (int s = 0; s < count; s++)
            out->panels[s] = (sc_viewport){0, 0, size_px[0], size_px[1] - out->below_px};
        return;
    }
    for (int columns = 1; columns <= count; columns++) {
        const double width_px = (double)size_px[0] / columns;

        size_names(job, names, size_px, WIDTH * width_px, &tried);
        sc_place_panels(size_px, count, columns, tried.below_px, tried.panels);
        if (columns == 1 || shorter_side(&tried.panels[0]) > shorter_side(&out->panels[0]))
            *out = tried;
    }
}

/* ---- names ---- */

void sc_name_of_file(const char *volume, char out[SC_CAPTION_BYTES])
{
    enum { LONGEST = 60 };
    size_t end = strlen(volume), begin, used = 0, bytes;

    while (end > 1 && volume[end - 1] == '/')
        end--;
    for (begin = end; begin > 0 && volume[begin - 1] != '/';)
        begin--;
    end = begin + sc_volume_stem_bytes(volume + begin, end - begin);
    for (size_t at = begin; at < end && used < LONGEST; at += bytes) {
        const size_t whole = sc_utf8_bytes(volume + at);

        bytes = whole ? whole : 1;
        if (!whole || sc_font_refuses(sc_utf8_code(volume + at, bytes))) {
            out[used++] = '?';
            continue;
        }
        memcpy(out + used, volume + at, bytes);
        used += bytes;
    }
    out[used] = '\0';
    for (char *c = out; *c; c++)
        *c = (char)(*c == '_' ? ' ' : *c);
}
