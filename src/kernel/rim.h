/* SPDX-License-Identifier: BSD-3-Clause */
/* The dark rims of cut faces of smooth surfaces. The fall of the blurred occupancy (sc_rim), or of
 * the labels (sc_face_rim), tells of a rim about three voxels wide. Where a voxel covers many
 * pixels that is a broad band, which the bricks of the blur make patchy. There the votes in the
 * cell tell how far away the border is, and the rim is as wide as the picture asks. */
#ifndef SC_KERNEL_RIM_H
#define SC_KERNEL_RIM_H

#include "cell.h"
#include "shade.h"

/* A fine rim is dark up to a third of its width, which is at most so many voxels: about as far as
 * the cells that hold a border surely reach. */
#define SC_FINE_RIM_VOXELS 0.5f
/* All of the rim is a fine one where the picture asks for so many voxels or less, nothing of it
 * from twice as many on. */
#define SC_FINE_RIM_ALL 0.8f

/* What share, 0 to 1, of the rim is a fine one at @p depth_mm from the eye. @param width_mm set to
 * the width of that. */
static inline float sc_fine_rim_share(const sc_march *m, float depth_mm, float *width_mm)
{
    const float asked_mm = m->cut_faces.rim_mm + m->cut_faces.rim_per_mm * depth_mm;
    const float most_mm = SC_FINE_RIM_VOXELS * m->voxel_mm;

    *width_mm = asked_mm < most_mm ? asked_mm : most_mm;
    return asked_mm > 0 ? sc_clamp01(2 - asked_mm / (SC_FINE_RIM_ALL * m->voxel_mm)) : 0;
}

/* How dark, 0 to 1, a fine rim of a width is at the point @p a of the cell, which has been read, on
 * a cut face with unit normal @p n (RAS): by the distance along the face to where @p owner ends and
 * nothing visible begins. */
static inline float sc_fine_rim(const sc_march *m, const sc_cell *cell, uint32_t owner,
                                const float a[3], const float n[3], float width_mm)
{
    uint32_t others[SC_CORNERS + 1];
    const int count = sc_cell_others(cell, owner, others);
    float nearest_mm = width_mm;

    for (int k = 0; k < count; k++) {
        float lead[SC_CORNERS], slope[3], per_mm[3] = {0, 0, 0}, across, distance_mm;

        if (m->tissues[others[k]].show & SC_SHOW_BOUNDARY)
            continue;
        sc_cell_lead(cell, owner, others[k], lead);
        sc_cell_slope(lead, a, slope);
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++)
                per_mm[j] += slope[i] * m->grid_per_mm[i][j];
        }
        across = sc_dot3(per_mm, n);
        for (int j = 0; j < 3; j++)
            per_mm[j] -= across * n[j];
        distance_mm = sc_trilinear(lead, a) / (sqrtf(sc_dot3(per_mm, per_mm)) + 1e-6f);
        nearest_mm = distance_mm < nearest_mm ? distance_mm : nearest_mm;
    }
    return sc_clamp01(1.5f - 1.5f * nearest_mm / width_mm);
}

/* Set the rim of a spot at the point @p a of a cell, on a cut face: spot->normal. @param mixed
 * whether the cell holds more than one label, and has been filled. */
static inline void sc_set_cut_rim(const sc_march *m, const sc_cell *cell, bool mixed,
                                  uint32_t owner, const float a[3], sc_spot *spot)
{
    float width_mm;
    const float fine = sc_fine_rim_share(m, spot->depth_mm, &width_mm);

    spot->rim = fine < 1 ? (1 - fine) * sc_rim(m, &m->tissues[owner], spot) : 0;
    if (fine > 0 && mixed)
        spot->rim += fine * SC_RIM_DARK * m->light.occlusion *
                     sc_fine_rim(m, cell, owner, a, spot->normal, width_mm);
}

/* @return the rim of a spot at the point @p a of a cell, which has been read, on a face of the
 * volume across axis @p axis that cuts @p owner. */
static inline float sc_volume_face_rim(const sc_march *m, const sc_cell *cell, uint32_t owner,
                                       const float a[3], const sc_spot *spot, int axis)
{
    float width_mm, rim = 0;
    const float fine = sc_fine_rim_share(m, spot->depth_mm, &width_mm);

    if (fine < 1)
        rim = (1 - fine) * sc_face_rim(m, axis, spot->point);
    if (fine > 0)
        rim += fine * SC_RIM_DARK * m->light.occlusion *
               sc_fine_rim(m, cell, owner, a, spot->normal, width_mm);
    return rim;
}

#endif
