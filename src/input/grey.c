/* SPDX-License-Identifier: BSD-3-Clause */
/* The grey volume of a job (CT, MR): read by rank 0, into memory that the ranks of a node share. */
#include "recipe.h"

#include "segcast/phantom.h"

/* Refuse a grey volume of which no part lies in the box of the label volume. */
static sc_status check_place(const sc_ctx *ctx, const char *path, const sc_grey *grey,
                             const sc_prepared *labels)
{
    const sc_box3 a = sc_grid_box_mm(grey->size, &grey->to_ras_mm);
    const sc_box3 b = sc_grid_box_mm(labels->size, &labels->to_ras_mm);

    if (a.low.x < b.high.x && b.low.x < a.high.x && a.low.y < b.high.y && b.low.y < a.high.y &&
        a.low.z < b.high.z && b.low.z < a.high.z)
        return SC_OK;
    return sc_fail(
        ctx, SC_ERR_DATA,
        "%s: the image lies nowhere in the volume: it reaches from (%.1f, %.1f, %.1f) to "
        "(%.1f, %.1f, %.1f) mm, the volume from (%.1f, %.1f, %.1f) to (%.1f, %.1f, %.1f) "
        "mm (RAS); expected the image from which the volume was segmented, or one that is "
        "registered to it",
        path, a.low.x, a.low.y, a.low.z, a.high.x, a.high.y, a.high.z, b.low.x, b.low.y, b.low.z,
        b.high.x, b.high.y, b.high.z);
}

/* Read the header of the image, or make that of the phantom. */
static sc_status read_header(const sc_app *app, const sc_job *job, sc_grey *out)
{
    const char *path = job->image.path;
    sc_input_place place;
    const sc_ctx ctx = sc_ctx_of_input(app->ctx, job->lines.image, path, &place);

    if (!sc_job_is_phantom(path))
        return sc_grey_read_header(&ctx, path, out);
    *out = (sc_grey){0};
    SC_PASS(sc_phantom_size(app->ctx, "image.path", path, out->size));
    for (int i = 0; i < 3; i++) {
        if (out->size[i] < 2 || out->size[i] > 4096)
            return sc_fail(app->ctx, SC_ERR_USAGE,
                           "image.path is \"%s\", expected 2 to 4096 voxels along each axis", path);
    }
    SC_PASS(sc_volume_memory_check(app->ctx, path, out->size, 0));
    out->to_ras_mm = sc_phantom_geometry(out->size);
    return SC_OK;
}

/* Move an image as a comparison has moved the volume to which it belongs. */
static void move(sc_vec3 by_mm, sc_grey *grey)
{
    grey->to_ras_mm.m[0][3] += by_mm.x;
    grey->to_ras_mm.m[1][3] += by_mm.y;
    grey->to_ras_mm.m[2][3] += by_mm.z;
}

/* As read_header, of an image that is moved to its place and has to lie in the volume. */
static sc_status place_header(const sc_app *app, const sc_job *job, const sc_prepared *volume,
                              sc_vec3 moved_mm, sc_grey *out)
{
    SC_PASS(read_header(app, job, out));
    move(moved_mm, out);
    return check_place(app->ctx, job->image.path, out, volume);
}

/* The windows of all frames of a job, which are not found in the image. @param all from the darkest
 * value that any shows as black to the lightest one. @return as sc_grey_look.window. */
static sc_grey_window windows_of(const sc_grey_options *image, sc_grey_window *all)
{
    const sc_grey_window *w = &image->shown.window;
    double black = w->level - w->width / 2, white = w->level + w->width / 2, width = w->width;

    for (int i = 0; i < image->shown.window_track.count; i++) {
        const sc_vec3 *key = &image->shown.window_track.keys[i].value;

        black = fmin(black, key->x - key->y / 2);
        white = fmax(white, key->x + key->y / 2);
        width = fmin(width, key->y);
    }
    *all = (sc_grey_window){black + (white - black) / 2, white - black};
    return image->shown.window_track.count ? (sc_grey_window){black + width / 2, width} : *w;
}

/* Read the voxels of the image, or make those of the phantom. */
static sc_status read_voxels(const sc_app *app, const sc_job *job, sc_grey *grey)
{
    const sc_grey_options *image = &job->image;
    sc_input_place place;
    const sc_ctx ctx = sc_ctx_of_input(app->ctx, job->lines.image, image->path, &place);
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;
    sc_grey_window all;

    (void)windows_of(image, &all);
    if (!sc_job_is_phantom(image->path))
        return sc_grey_read(&ctx, image->path, image->window_auto ? NULL : &all, grey);
    SC_PASS(sc_phantom_new(app->ctx, &phantom));
    return sc_phantom_grey(app->ctx, phantom, app->threads, grey);
}

sc_status sc_grey_check(const sc_app *app, const sc_job *job, const sc_prepared *volume,
                        sc_vec3 moved_mm)
{
    sc_grey grey;

    return job->given.image ? place_header(app, job, volume, moved_mm, &grey) : SC_OK;
}

/* @return the hash of the codes and the geometry of an image. @param codes that of the codes. */
static uint64_t hash_of(const sc_grey *grey, uint64_t codes)
{
    uint64_t hash = sc_hash_bytes(&grey->to_ras_mm, sizeof grey->to_ras_mm, codes);

    hash = sc_hash_bytes(&grey->low, sizeof grey->low, hash);
    return sc_hash_bytes(&grey->per_code, sizeof grey->per_code, hash);
}

/* Write the values that a window shows as black and white, with so many digits that one is told
 * from the other. */
static void window_text(const sc_grey_window *window, char black[32], char white[32])
{
    static const int digits[] = {6, 10, 17}; /* with 17 any two numbers differ */

    for (size_t i = 0; i < SC_COUNT_OF(digits); i++) {
        snprintf(black, 32, "%.*g", digits[i], window->level - window->width / 2);
        snprintf(white, 32, "%.*g", digits[i], window->level + window->width / 2);
        if (strcmp(black, white) != 0)
            break;
    }
}

/* The part of sc_grey_load that rank 0 does with the voxels: read them into out->grey.codes, and
 * choose the window. */
static sc_status read_codes(const sc_app *app, const sc_job *job, const sc_prepared *volume,
                            sc_grey_input *out)
{
    const sc_grey_options *image = &job->image;
    const sc_volume labels = sc_volume_of_prepared(volume);
    sc_grey *grey = &out->grey;
    const sc_affine place = grey->to_ras_mm; /* reading sets that of the file */
    sc_grey_window found_window, all;
    char black[32], white[32], size[24];
    bool found;

    SC_PASS(read_voxels(app, job, grey));
    grey->to_ras_mm = place;
    SC_PASS(sc_grey_auto_window(app->ctx, grey, &labels, &found_window, &found));
    out->window = windows_of(image, &all);
    if (image->window_auto)
        out->window = all = found_window;
    out->hash = hash_of(grey, sc_hash_bytes(grey->codes, sc_grey_bytes(grey), 0));
    if (!found)
        sc_warn(app->ctx, "%s: no tissue that is shown lies within the image", image->path);
    window_text(&all, black, white);
    sc_info(app->ctx, "%s: %d x %d x %d grey values (%s), shown from %s (black) to %s (white)",
            image->path, grey->size[0], grey->size[1], grey->size[2],
            sc_size_text((double)sc_grey_bytes(grey), size), black, white);
    return SC_OK;
}

sc_status sc_grey_load(sc_app *app, const sc_job *job, const sc_prepared *volume,
                       sc_rank_record *times, sc_grey_input *out)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    const double wall_s = sc_wall_s(), cpu_s = sc_cpu_s();
    sc_grey *grey = &out->grey;
    uint16_t *codes;
    sc_status status = SC_OK;

    if (!job->given.image)
        return SC_OK;
    if (first)
        status = place_header(app, job, volume, out->moved_mm, grey);
    SC_PASS(sc_comm_agree(app->comm, status));
    sc_comm_broadcast(app->comm, grey, sizeof *grey);
    SC_PASS(sc_shared_alloc(app->ctx, app->comm, sc_grey_bytes(grey), sc_temporary_folder(),
                            &out->codes));
    codes = sc_shared_data(out->codes);
    grey->codes = codes;
    SC_PASS(sc_comm_agree(app->comm, first ? read_codes(app, job, volume, out) : SC_OK));
    sc_shared_publish(app->comm, out->codes);
    sc_comm_broadcast(app->comm, grey, sizeof *grey);
    grey->codes = codes; /* rank 0's address means nothing here */
    sc_comm_broadcast(app->comm, &out->window, sizeof out->window);
    sc_comm_broadcast(app->comm, &out->hash, sizeof out->hash);
    sc_add_time(app, times, first ? SC_PHASE_READ : SC_PHASE_IDLE, wall_s, cpu_s);
    return SC_OK;
}

sc_status sc_grey_borrow(sc_app *app, const sc_job *job, const sc_prepared *volume,
                         const sc_grey_input *from, sc_grey_input *out)
{
    const sc_grey_options *image = &job->image;
    sc_grey_window all;
    sc_status status;

    out->grey = from->grey;
    move(sc_vec3_sub(out->moved_mm, from->moved_mm), &out->grey);
    out->window = image->window_auto ? from->window : windows_of(image, &all);
    out->hash = hash_of(&out->grey, from->hash);
    status = check_place(app->ctx, image->path, &out->grey, volume);
    return sc_comm_agree(app->comm, status);
}
