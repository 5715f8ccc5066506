/* SPDX-License-Identifier: BSD-3-Clause */
/* The voxels of the tissues of a centre line: see internal.h. */
#include "internal.h"

enum { BYTES_PER_BOX_VOXEL = 4, BYTES_PER_VOXEL = 32 }; /* of a region and a search */

/* @return whether the line may enter the voxel at @p index of the volume. */
static bool is_member(const sc_centerline_request *request, size_t index)
{
    const void *ids = request->volume->ids;

    return request->order[request->volume->label_bytes == 1 ? ((const uint8_t *)ids)[index]
                                                            : ((const uint16_t *)ids)[index]] > 0;
}

/* Find the box around the voxels and count these. */
static void find_box(const sc_centerline_request *request, sc_region *r)
{
    const int *size = request->volume->size;
    int high[3] = {-1, -1, -1};
    size_t index = 0, count = 0;

    for (int i = 0; i < 3; i++)
        r->low[i] = size[i];
    for (int z = 0; z < size[2]; z++) {
        for (int y = 0; y < size[1]; y++) {
            int first = size[0], last = -1;

            for (int x = 0; x < size[0]; x++, index++) {
                if (!is_member(request, index))
                    continue;
                first = x < first ? x : first;
                last = x;
                count++;
            }
            if (last < 0)
                continue;
            r->low[0] = first < r->low[0] ? first : r->low[0];
            high[0] = last > high[0] ? last : high[0];
            r->low[1] = y < r->low[1] ? y : r->low[1];
            high[1] = y > high[1] ? y : high[1];
            r->low[2] = z < r->low[2] ? z : r->low[2];
            high[2] = z;
        }
    }
    r->count = count < SC_NO_VOXEL ? (uint32_t)count : SC_NO_VOXEL;
    for (int i = 0; i < 3; i++) { /* with the frame */
        r->low[i]--;
        r->size[i] = high[i] - r->low[i] + 2;
        r->stride[i] = i ? r->stride[i - 1] * (size_t)r->size[i - 1] : 1;
    }
}

/* Refuse a region without voxels, or one that takes too much memory. */
static sc_status check_size(const sc_ctx *ctx, const sc_region *r)
{
    const sc_centerline_request *q = r->request;
    const char *colon = q->where[0] ? ": " : "";
    double box, bytes;

    if (!r->count)
        return sc_fail(ctx, SC_ERR_DATA, "%s%sthe volume has no voxel of %s", q->where, colon,
                       q->what);
    box = (double)r->size[0] * r->size[1] * r->size[2];
    bytes = BYTES_PER_BOX_VOXEL * box + BYTES_PER_VOXEL * (double)r->count;
    if (box > INT32_MAX || (ctx->memory_max_bytes && bytes > (double)ctx->memory_max_bytes))
        return sc_fail(
            ctx, SC_ERR_SYSTEM,
            "%s%sthe centre line of %s takes %.0f MB of memory, which is more than there "
            "is or than --max-memory allows",
            q->where, colon, q->what, bytes / 1e6);
    return SC_OK;
}

/* Number the voxels of the region. */
static void number_voxels(sc_region *r)
{
    const sc_volume *v = r->request->volume;
    uint32_t n = 0;

    for (int z = 1; z + 1 < r->size[2]; z++) {
        for (int y = 1; y + 1 < r->size[1]; y++) {
            const size_t row =
                (((size_t)(z + r->low[2]) * (size_t)v->size[1] + (size_t)(y + r->low[1])) *
                 (size_t)v->size[0]) +
                (size_t)(1 + r->low[0]);
            const size_t at = (size_t)z * r->stride[2] + (size_t)y * r->stride[1] + 1;

            for (size_t x = 0; x + 2 < (size_t)r->size[0]; x++) {
                if (!is_member(r->request, row + x))
                    continue;
                r->place[n] = (uint32_t)(at + x);
                r->number[at + x] = ++n;
            }
        }
    }
}

/* ---- depths ---- */

/* One pass of the distance transform along an axis; run by run, so that empty parts of the box cost
 * nothing. @param work room for a run and for sc_distance_pass. */
static void pass_along(sc_region *r, int axis, double *work)
{
    const size_t stride = r->stride[axis];
    double *run = work + SC_DISTANCE_WORK(r->size[axis]);

    for (uint32_t n = 0; n < r->count; n++) {
        size_t at = r->place[n];
        int count = 0;

        if (r->number[at - stride])
            continue; /* not the first of its run */
        for (; r->number[at]; at += stride) {
            const float before = r->depth_mm[r->number[at] - 1];

            run[count++] = axis ? (double)before : HUGE_VAL;
        }
        sc_distance_pass(run, count, r->step_mm[axis], work);
        at = r->place[n];
        for (int i = 0; i < count; i++, at += stride)
            r->depth_mm[r->number[at] - 1] = (float)run[i];
    }
}

/* Fill depth_mm. @return SC_ERR_MEMORY. */
static sc_status find_depths(const sc_ctx *ctx, sc_region *r)
{
    int longest = r->size[0];
    SC_OWN(sc_free_at) void *work = NULL;

    for (int i = 1; i < 3; i++)
        longest = r->size[i] > longest ? r->size[i] : longest;
    SC_PASS(sc_alloc(ctx, SC_DISTANCE_WORK(longest) + (size_t)longest, sizeof(double), &work));
    for (int axis = 0; axis < 3; axis++)
        pass_along(r, axis, work);
    for (uint32_t n = 0; n < r->count; n++)
        r->depth_mm[n] = sqrtf(r->depth_mm[n]);
    return SC_OK;
}

/* ---- pieces ---- */

/* Give all voxels that touch the voxel @p first, one after the other, to the next piece. @param
 * queue room for [count]. @return how many they are. */
static uint32_t fill_part(sc_region *r, uint32_t first, uint32_t *queue)
{
    uint32_t begin = 0, end = 0;

    queue[end++] = first;
    r->part[first] = r->parts;
    while (begin < end) {
        const int64_t place = r->place[queue[begin++]];

        for (int i = 0; i < 26; i++) {
            const uint32_t other = r->number[place + r->offset[i]];

            if (!other || r->part[other - 1] != SC_NO_VOXEL)
                continue;
            r->part[other - 1] = r->parts;
            queue[end++] = other - 1;
        }
    }
    return end;
}

/* Fill part, parts and largest_part. @param queue room for [count]. */
static void find_parts(sc_region *r, uint32_t *queue)
{
    uint32_t most = 0;

    memset(r->part, 0xff, r->count * sizeof *r->part);
    for (uint32_t first = 0; first < r->count; first++) {
        uint32_t voxels;

        if (r->part[first] != SC_NO_VOXEL)
            continue;
        voxels = fill_part(r, first, queue);
        if (voxels > most) {
            most = voxels;
            r->largest_part = r->parts;
        }
        r->parts++;
    }
}

/* Set the way to each of the 26 neighbours. */
static void set_neighbours(sc_region *r)
{
    for (int i = 0; i < 26; i++) {
        const int n = i < 13 ? i : i + 1, x = n % 3 - 1, y = n / 3 % 3 - 1, z = n / 9 - 1;

        r->offset[i] = z * (int)r->stride[2] + y * (int)r->stride[1] + x;
        r->length_mm[i] =
            sc_vec3_length(sc_affine_vector(&r->request->volume->to_ras_mm, (sc_vec3){x, y, z}));
    }
}

sc_status sc_region_make(const sc_ctx *ctx, const sc_centerline_request *request, sc_region *out)
{
    SC_OWN(sc_free_at) void *queue = NULL;
    sc_region *r = out;

    *r = (sc_region){.request = request};
    find_box(request, r);
    SC_PASS(check_size(ctx, r));
    for (int i = 0; i < 3; i++) {
        r->step_mm[i] = sc_vec3_length(sc_affine_column(&request->volume->to_ras_mm, i));
        r->least_mm = i ? fmin(r->least_mm, r->step_mm[i]) : r->step_mm[i];
    }
    set_neighbours(r);
    SC_PASS(SC_ZALLOC(ctx, r->stride[2] * (size_t)r->size[2], &r->number));
    SC_PASS(SC_ALLOC(ctx, r->count, &r->place));
    SC_PASS(SC_ALLOC(ctx, r->count, &r->depth_mm));
    SC_PASS(SC_ALLOC(ctx, r->count, &r->part));
    SC_PASS(sc_alloc(ctx, r->count, sizeof(uint32_t), &queue));
    number_voxels(r);
    SC_PASS(find_depths(ctx, r));
    find_parts(r, queue);
    return SC_OK;
}

void sc_region_clear(sc_region *region)
{
    sc_free(region->number);
    sc_free(region->place);
    sc_free(region->depth_mm);
    sc_free(region->part);
    *region = (sc_region){0};
}

/* ---- places ---- */

/* @return the middle of a voxel in voxel coordinates of the volume. */
static sc_vec3 middle_of(const sc_region *r, uint32_t voxel)
{
    const size_t at = r->place[voxel];
    const size_t x = at % r->stride[1], y = at / r->stride[1] % (size_t)r->size[1],
                 z = at / r->stride[2];

    return (sc_vec3){(double)x + r->low[0], (double)y + r->low[1], (double)z + r->low[2]};
}

int sc_region_order(const sc_region *region, uint32_t voxel)
{
    const sc_volume *v = region->request->volume;
    const size_t place = region->place[voxel];
    const size_t x = place % region->stride[1] + (size_t)region->low[0];
    const size_t y = place / region->stride[1] % (size_t)region->size[1] + (size_t)region->low[1];
    const size_t z = place / region->stride[2] + (size_t)region->low[2];
    const size_t index = (z * (size_t)v->size[1] + y) * (size_t)v->size[0] + x;

    return region->request->order[v->label_bytes == 1 ? ((const uint8_t *)v->ids)[index]
                                                      : ((const uint16_t *)v->ids)[index]];
}

sc_vec3 sc_region_point(const sc_region *region, uint32_t voxel)
{
    return sc_affine_point(&region->request->volume->to_ras_mm, middle_of(region, voxel));
}

/* @return the voxel at a place of the box, or SC_NO_VOXEL. */
static uint32_t voxel_at(const sc_region *r, double x, double y, double z)
{
    const double at[3] = {x - r->low[0], y - r->low[1], z - r->low[2]};
    size_t index = 0;

    for (int i = 0; i < 3; i++) {
        if (!(at[i] >= 0 && at[i] < r->size[i]))
            return SC_NO_VOXEL;
        index += (size_t)at[i] * r->stride[i];
    }
    return r->number[index] ? r->number[index] - 1 : SC_NO_VOXEL;
}

uint32_t sc_region_voxel(const sc_region *region, sc_vec3 at)
{
    return voxel_at(region, floor(at.x + 0.5), floor(at.y + 0.5), floor(at.z + 0.5));
}

double sc_region_depth(const sc_region *region, sc_vec3 at)
{
    const double x = floor(at.x), y = floor(at.y), z = floor(at.z);
    double depth_mm = 0;

    for (int corner = 0; corner < 8; corner++) {
        const int i = corner & 1, j = corner >> 1 & 1, k = corner >> 2;
        const double share = (i ? at.x - x : 1 - at.x + x) * (j ? at.y - y : 1 - at.y + y) *
                             (k ? at.z - z : 1 - at.z + z);
        const uint32_t voxel = voxel_at(region, x + i, y + j, z + k);

        if (voxel != SC_NO_VOXEL)
            depth_mm += share * (double)region->depth_mm[voxel];
    }
    return depth_mm;
}

uint32_t sc_region_nearest(const sc_region *region, sc_vec3 point_mm, uint32_t part)
{
    uint32_t nearest = SC_NO_VOXEL;
    double least = HUGE_VAL;

    for (uint32_t n = 0; n < region->count; n++) {
        const sc_vec3 off = sc_vec3_sub(sc_region_point(region, n), point_mm);

        if ((part == SC_NO_VOXEL || region->part[n] == part) && sc_vec3_dot(off, off) < least) {
            least = sc_vec3_dot(off, off);
            nearest = n;
        }
    }
    return nearest;
}

/* @return whether the straight line between two points of voxel coordinates stays in the tissues.
 */
static bool sees(const sc_region *r, sc_vec3 from, sc_vec3 to)
{
    const sc_vec3 way = sc_vec3_sub(to, from);
    const int steps = 1 + (int)(2 * sc_vec3_length(way));

    for (int i = 1; i < steps; i++) {
        if (sc_region_voxel(r, sc_vec3_along(from, (double)i / steps, way)) == SC_NO_VOXEL)
            return false;
    }
    return true;
}

uint32_t sc_region_middle(const sc_region *region, uint32_t voxel)
{
    const sc_vec3 from = middle_of(region, voxel), from_mm = sc_region_point(region, voxel);
    double most = (double)region->depth_mm[voxel];
    uint32_t best = voxel;

    for (uint32_t n = 0; n < region->count; n++) {
        const double depth = (double)region->depth_mm[n];
        double worth;

        if (depth <= most) /* also where it is near */
            continue;
        worth = depth - 0.5 * sc_vec3_length(sc_vec3_sub(sc_region_point(region, n), from_mm));
        if (worth > most && sees(region, from, middle_of(region, n))) {
            most = worth;
            best = n;
        }
    }
    return best;
}
