/* SPDX-License-Identifier: BSD-3-Clause */
/* Where the frames of a DICOM segmentation lie: each says its own place, in any order, and frames
 * in which a segment does not occur are left out. */
#include "dicom/dicom.h"

#include <stdlib.h>

#define SHARED_GROUPS SC_DICOM_TAG(0x5200, 0x9229)
#define FRAME_GROUPS SC_DICOM_TAG(0x5200, 0x9230)
#define PLANE_POSITION SC_DICOM_TAG(0x0020, 0x9113)
#define POSITION SC_DICOM_TAG(0x0020, 0x0032)
#define PLANE_ORIENTATION SC_DICOM_TAG(0x0020, 0x9116)
#define ORIENTATION SC_DICOM_TAG(0x0020, 0x0037)
#define MEASURES SC_DICOM_TAG(0x0028, 0x9110)
#define PIXEL_SPACING SC_DICOM_TAG(0x0028, 0x0030)
#define SLICE_SPACING SC_DICOM_TAG(0x0018, 0x0088)
#define SLICE_THICKNESS SC_DICOM_TAG(0x0018, 0x0050)
#define IDENTIFICATION SC_DICOM_TAG(0x0062, 0x000a)
#define SEGMENT_NUMBER SC_DICOM_TAG(0x0062, 0x000b)

/* How far a frame may lie from its place: along the normal in distances of slices, and within the
 * slice in pixels. Beyond the first of each, it is told; beyond the second, refused. */
#define TOLD_SLICES 0.01
#define MOST_SLICES 0.1
#define TOLD_PX 0.05
#define MOST_PX 0.5
/* Frames whose positions differ by less, in pixels, lie in one slice where no spacing is given. */
#define SAME_PX 0.2
/* A spacing that is given fits exactly if no frame is off by more, in slices and in pixels. */
#define EXACT 1e-3
#define SAME_DIRECTION 1e-4
#define SAME_SPACING 1e-4 /* as a share of it */
#define NUMBER_MOST 1e12

/* The pixels of a frame in space. */
typedef struct plane {
    sc_vec3 directions[2]; /* of rising columns and rows; unit vectors, LPS */
    double spacing_mm[2];  /* between columns, and between rows */
    double given_mm;       /* between slices; 0: not given */
    double thickness_mm;   /* of a slice; 0: not given */
} plane;

typedef struct placing {
    const sc_ctx *ctx;
    const char *path;
    plane plane;
    sc_vec3 normal;
    const sc_dicom *file;
    sc_dicom_images images;
    sc_dicom_frame *frames;
    uint32_t count;
} placing;

/* @return the first item of a functional group, of the frame, else of all; NULL: there is none. */
static const sc_dicom_item *group(const sc_dicom_item *own, const sc_dicom_item *shared,
                                  uint32_t tag)
{
    const sc_dicom_item *item = own ? sc_dicom_next(own, tag, NULL) : NULL;

    return item || !shared ? item : sc_dicom_next(shared, tag, NULL);
}

/* Read @p count numbers of @p item, which may be NULL. @return whether there are so many, none of
 * them beyond all reason. */
static bool read_numbers(const sc_dicom_item *item, uint32_t tag, double *out, size_t count)
{
    if (!item || sc_dicom_numbers(item, tag, out, count) != count)
        return false;
    for (size_t i = 0; i < count; i++) {
        if (!(fabs(out[i]) <= NUMBER_MOST))
            return false;
    }
    return true;
}

static sc_status lacks(const placing *p, uint32_t frame, const char *what)
{
    return sc_fail(p->ctx, SC_ERR_DATA,
                   "%s: frame %u has no %s, expected one for each frame or for all; write the file "
                   "anew, or convert it with `segimage2itkimage` of dcmqi",
                   p->path, frame + 1, what);
}

/* ---- one frame ---- */

/* Read the plane of a frame. */
static sc_status read_plane(const placing *p, uint32_t frame, const sc_dicom_item *own,
                            const sc_dicom_item *shared, plane *out)
{
    const sc_dicom_item *measures = group(own, shared, MEASURES);
    const sc_dicom_item *orientation = group(own, shared, PLANE_ORIENTATION);
    double cosines[6], spacing[2];
    plane found = {0};

    if (!read_numbers(orientation, ORIENTATION, cosines, 6))
        return lacks(p, frame, "orientation (ImageOrientationPatient, six numbers)");
    if (!read_numbers(measures, PIXEL_SPACING, spacing, 2))
        return lacks(p, frame, "spacing of pixels (PixelSpacing, two numbers)");
    for (int i = 0; i < 2; i++) {
        const sc_vec3 given = {cosines[3 * i], cosines[3 * i + 1], cosines[3 * i + 2]};

        if (fabs(sc_vec3_length(given) - 1) > 0.01)
            return sc_fail(p->ctx, SC_ERR_DATA,
                           "%s: frame %u: ImageOrientationPatient has a direction of length %g, "
                           "expected 1; the file is damaged: write it anew",
                           p->path, frame + 1, sc_vec3_length(given));
        found.directions[i] = sc_vec3_unit(given);
        found.spacing_mm[i] = spacing[1 - i];
    }
    if (fabs(sc_vec3_dot(found.directions[0], found.directions[1])) > 0.01)
        return sc_fail(p->ctx, SC_ERR_DATA,
                       "%s: frame %u: the directions of ImageOrientationPatient are not at right "
                       "angles; the file is damaged: write it anew",
                       p->path, frame + 1);
    if (!(spacing[0] > 0) || !(spacing[1] > 0))
        return sc_fail(p->ctx, SC_ERR_DATA,
                       "%s: frame %u: PixelSpacing is %g and %g mm, expected more than 0; the file "
                       "is damaged: write it anew",
                       p->path, frame + 1, spacing[0], spacing[1]);
    if (!read_numbers(measures, SLICE_SPACING, &found.given_mm, 1) || !(found.given_mm > 0))
        found.given_mm = 0;
    if (!read_numbers(measures, SLICE_THICKNESS, &found.thickness_mm, 1) ||
        !(found.thickness_mm > 0))
        found.thickness_mm = 0;
    *out = found;
    return SC_OK;
}

/* Check that a frame has the plane of the first. */
static sc_status check_plane(const placing *p, uint32_t frame, const plane *own)
{
    for (int i = 0; i < 2; i++) {
        const double apart =
            sc_vec3_length(sc_vec3_sub(own->directions[i], p->plane.directions[i]));
        const double share = own->spacing_mm[i] / p->plane.spacing_mm[i];

        if (apart > SAME_DIRECTION || fabs(share - 1) > SAME_SPACING)
            return sc_fail(p->ctx, SC_ERR_DATA,
                           "%s: frame %u has another %s than frame 1; expected the parallel slices "
                           "of one volume: convert it with `segimage2itkimage` of dcmqi",
                           p->path, frame + 1,
                           apart > SAME_DIRECTION ? "orientation" : "spacing of pixels");
    }
    return SC_OK;
}

/* Read one frame; the first one's plane becomes that of all. */
static sc_status read_frame(placing *p, uint32_t number, const sc_dicom_item *own,
                            const sc_dicom_item *shared, bool has_segments)
{
    sc_dicom_frame *frame = &p->frames[number];
    double position[3], segment = 0;
    plane found;

    frame->number = number;
    if (!read_numbers(group(own, shared, PLANE_POSITION), POSITION, position, 3))
        return lacks(p, number, "position (ImagePositionPatient, three numbers)");
    SC_PASS(read_plane(p, number, own, shared, &found));
    if (number == 0) {
        p->plane = found;
        p->normal = sc_vec3_unit(sc_vec3_cross(found.directions[0], found.directions[1]));
    }
    frame->position_mm = (sc_vec3){position[0], position[1], position[2]};
    frame->along_mm = sc_vec3_dot(frame->position_mm, p->normal);
    frame->image = sc_dicom_image_of(&p->images, p->file, own);
    if (has_segments &&
        (!read_numbers(group(own, shared, IDENTIFICATION), SEGMENT_NUMBER, &segment, 1) ||
         segment < 1 || segment > UINT16_MAX))
        return lacks(p, number, "segment (ReferencedSegmentNumber, from 1 to 65535)");
    frame->segment = (int)segment;
    return check_plane(p, number, &found);
}

static sc_status read_frames(placing *p, bool has_segments)
{
    const sc_dicom_item *root = sc_dicom_root(p->file), *own = NULL;
    const sc_dicom_item *shared = sc_dicom_next(root, SHARED_GROUPS, NULL);
    uint32_t count = 0;

    while (count < p->count && (own = sc_dicom_next(root, FRAME_GROUPS, own)) != NULL)
        SC_PASS(read_frame(p, count++, own, shared, has_segments));
    return SC_OK;
}

/* ---- all frames ---- */

/* For qsort of sc_dicom_frame: rising along the normal; by number, so that the order is one. */
static int by_position(const void *a, const void *b)
{
    const sc_dicom_frame *x = a, *y = b;

    if (x->along_mm != y->along_mm)
        return x->along_mm < y->along_mm ? -1 : 1;
    return (x->number > y->number) - (x->number < y->number);
}

/* The same: rising by slice, segment and number. */
static int by_slice(const void *a, const void *b)
{
    const sc_dicom_frame *x = a, *y = b;

    if (x->slice != y->slice)
        return x->slice < y->slice ? -1 : 1;
    if (x->segment != y->segment)
        return x->segment < y->segment ? -1 : 1;
    return (x->number > y->number) - (x->number < y->number);
}

/* How well slices at equal distances fit the frames. */
typedef struct fit {
    sc_vec3 step_mm;      /* from a slice to the next, LPS */
    sc_vec3 first_mm;     /* of the first pixel of the first slice, LPS */
    double slices;        /* how many there are */
    double worst_slices;  /* the largest distance of a frame from its slice, along the normal, */
    double worst_px;      /* and within it; */
    uint32_t worst_frame; /* the frame for which one of the two is most of what is allowed */
} fit;

/* Measure how far the frames, whose slices are numbered, are from where this step would have them.
 */
static void measure(const placing *p, sc_vec3 step_mm, fit *f)
{
    const double pixel_mm = fmin(p->plane.spacing_mm[0], p->plane.spacing_mm[1]);
    const double distance_mm = sc_vec3_dot(step_mm, p->normal);
    double worst = 0;

    f->step_mm = step_mm;
    f->worst_slices = f->worst_px = 0;
    f->worst_frame = p->frames[0].number;
    for (uint32_t i = 1; i < p->count; i++) {
        const sc_vec3 place = sc_vec3_along(p->frames[0].position_mm, p->frames[i].slice, step_mm);
        const sc_vec3 off = sc_vec3_sub(p->frames[i].position_mm, place);
        const double along_mm = sc_vec3_dot(off, p->normal);
        const double across_mm = sc_vec3_length(sc_vec3_along(off, -along_mm, p->normal));
        const double slices = fabs(along_mm) / distance_mm, px = across_mm / pixel_mm;
        const double share = fmax(slices / MOST_SLICES, px / MOST_PX);

        f->worst_slices = fmax(f->worst_slices, slices);
        f->worst_px = fmax(f->worst_px, px);
        if (share > worst) {
            worst = share;
            f->worst_frame = p->frames[i].number;
        }
    }
}

/* Number the slices of the frames, which are sorted, by a spacing, and measure how well slices at
 * equal distances fit: at this one, or, if that is not exact, at the one that puts the first and
 * the last frame where they are. @return false if some lie nearer together than half the spacing,
 * or too far apart. */
static bool number_slices(placing *p, double spacing_mm, double same_mm, fit *out)
{
    const sc_vec3 across_mm =
        sc_vec3_sub(p->frames[p->count - 1].position_mm, p->frames[0].position_mm);
    double slice = 0;

    p->frames[0].slice = 0;
    for (uint32_t i = 1; i < p->count; i++) {
        const double gap_mm = p->frames[i].along_mm - p->frames[i - 1].along_mm;
        const double steps = floor(gap_mm / spacing_mm + 0.5);

        slice += gap_mm > same_mm ? steps : 0;
        if (!(slice < INT32_MAX))
            return false;
        p->frames[i].slice = (int)slice;
    }
    out->slices = slice + 1;
    measure(p, sc_vec3_scale(p->normal, spacing_mm), out);
    if (slice > 0 && (out->worst_slices > EXACT || out->worst_px > EXACT))
        measure(p, sc_vec3_scale(across_mm, 1 / slice), out);
    return true;
}

static bool fits(const fit *f)
{
    return f->worst_slices <= MOST_SLICES && f->worst_px <= MOST_PX;
}

/* @return the smallest distance between slices, of frames that are sorted; 0: all lie in one. */
static double smallest_gap(const placing *p, double same_mm)
{
    double smallest_mm = 0;

    for (uint32_t i = 1; i < p->count; i++) {
        const double gap_mm = p->frames[i].along_mm - p->frames[i - 1].along_mm;

        if (gap_mm > same_mm && (smallest_mm == 0 || gap_mm < smallest_mm))
            smallest_mm = gap_mm;
    }
    return smallest_mm;
}

/* Find the slices: by the spacing that is given, else by the smallest distance there is. */
static sc_status find_slices(placing *p, fit *out)
{
    const double same_mm = SAME_PX * fmin(p->plane.spacing_mm[0], p->plane.spacing_mm[1]);
    const double gap_mm = smallest_gap(p, same_mm), given_mm = p->plane.given_mm;
    const double alone_mm = given_mm > 0 ? given_mm : p->plane.thickness_mm;
    bool numbered = given_mm > 0 && number_slices(p, given_mm, 0, out);

    if ((!numbered || !fits(out)) && gap_mm > 0) {
        numbered = number_slices(p, gap_mm, same_mm, out);
    } else if (!numbered) {
        if (!(alone_mm > 0))
            sc_warn(p->ctx,
                    "%s: has one slice, and does not say how thick it is (SpacingBetweenSlices, "
                    "SliceThickness); taken as 1 mm",
                    p->path);
        numbered = number_slices(p, alone_mm > 0 ? alone_mm : 1, same_mm, out);
    }
    if (numbered && fits(out) && given_mm > 0 &&
        fabs(sc_vec3_dot(out->step_mm, p->normal) / given_mm - 1) > TOLD_SLICES)
        sc_warn(p->ctx,
                "%s: its slices lie %.4g mm apart, not %.4g mm as it says (SpacingBetweenSlices); "
                "taken as they lie",
                p->path, sc_vec3_dot(out->step_mm, p->normal), given_mm);
    if (!numbered)
        return sc_fail(p->ctx, SC_ERR_DATA,
                       "%s: its slices lie %g mm apart or less, but as far as %g mm: more slices "
                       "than can be; the file is damaged: write it anew",
                       p->path, gap_mm, p->frames[p->count - 1].along_mm - p->frames[0].along_mm);
    if (!fits(out))
        return sc_fail(p->ctx, SC_ERR_DATA,
                       "%s: frame %u lies %.2g slices and %.2g pixels beside where slices at equal "
                       "distances (%.4g mm) would be, expected at most %g and %g; resample it, for "
                       "example by `segimage2itkimage` of dcmqi or in 3D Slicer (save as .nrrd)",
                       p->path, out->worst_frame + 1, out->worst_slices, out->worst_px,
                       sc_vec3_dot(out->step_mm, p->normal), MOST_SLICES, MOST_PX);
    if (out->worst_slices > TOLD_SLICES || out->worst_px > TOLD_PX)
        sc_warn(p->ctx,
                "%s: its slices do not lie at equal distances: frame %u is off by %.2g slices and "
                "%.2g pixels; shown as if they did",
                p->path, out->worst_frame + 1, out->worst_slices, out->worst_px);
    return SC_OK;
}

/* Check that no two frames show one segment in one slice; they are sorted by these. */
static sc_status check_doubles(const placing *p)
{
    for (uint32_t i = 1; i < p->count; i++) {
        const sc_dicom_frame *a = &p->frames[i - 1], *b = &p->frames[i];

        if (a->slice == b->slice && a->segment == b->segment)
            return sc_fail(p->ctx, SC_ERR_DATA,
                           "%s: frames %u and %u show the same%s in one slice, expected one frame "
                           "for each; of a series over time, save one time",
                           p->path, a->number + 1, b->number + 1, a->segment ? " segment" : "");
    }
    return SC_OK;
}

/* Add the slices that were left out at the ends, where nothing is. */
static void add_ends(const placing *p, fit *f)
{
    const sc_dicom_ends ends = sc_dicom_left_out(&p->images, p->frames, p->count, (int)f->slices);

    if (ends.before + ends.behind == 0)
        return;
    for (uint32_t i = 0; i < p->count; i++)
        p->frames[i].slice += ends.before;
    f->first_mm = sc_vec3_along(f->first_mm, -ends.before, f->step_mm);
    f->slices += ends.before + ends.behind;
    if (ends.is_known)
        sc_info(p->ctx,
                "%s: was made of %d images; %d before its first slice and %d behind its last have "
                "no frames, and are empty",
                p->path, p->images.count, ends.before, ends.behind);
    else
        sc_info(p->ctx,
                "%s: was made of %d images, more than it has slices; slices without tissue were "
                "left out, but it does not say at which end: an empty one stands at each",
                p->path, p->images.count);
}

/* For SC_OWN. */
static void clear_placing(placing *p)
{
    sc_dicom_images_clear(&p->images);
}

sc_status sc_dicom_place_frames(const sc_ctx *ctx, const char *path, const sc_dicom *file,
                                bool has_segments, const int size_px[2], sc_dicom_frame *frames,
                                uint32_t count, sc_source *source)
{
    SC_OWN(clear_placing)
    placing p = {.ctx = ctx, .path = path, .file = file, .frames = frames, .count = count};
    sc_vec3 axes_mm[4]; /* and where the first voxel lies */
    fit found = {0};

    SC_PASS(sc_dicom_images_read(ctx, file, &p.images));
    SC_PASS(read_frames(&p, has_segments));
    qsort(frames, count, sizeof *frames, by_position);
    SC_PASS(find_slices(&p, &found));
    found.first_mm = frames[0].position_mm;
    add_ends(&p, &found);
    for (int i = 0; i < 2; i++)
        axes_mm[i] = sc_vec3_scale(p.plane.directions[i], p.plane.spacing_mm[i]);
    axes_mm[2] = found.step_mm;
    axes_mm[3] = found.first_mm;
    for (int column = 0; column < 4; column++) { /* x and y of DICOM go to the left and the back */
        source->to_ras_mm.m[0][column] = 0 - axes_mm[column].x; /* so 0 has no sign */
        source->to_ras_mm.m[1][column] = 0 - axes_mm[column].y;
        source->to_ras_mm.m[2][column] = axes_mm[column].z;
    }
    source->oriented = true;
    SC_PASS(sc_grid_voxels(ctx, path, (int64_t[3]){size_px[0], size_px[1], (int64_t)found.slices},
                           2, source->size, NULL));
    qsort(frames, count, sizeof *frames, by_slice);
    return check_doubles(&p);
}
