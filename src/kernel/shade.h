/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: normals and light, shared by all march templates. Plain arithmetic and sqrt
 * only, so that every compiler and processor gives the same bits. */
#ifndef SC_KERNEL_SHADE_H
#define SC_KERNEL_SHADE_H

#include "segcast/kernel.h"

#define SC_AMBIENT 0.22f
#define SC_KEY 0.62f
#define SC_HEAD 0.30f
#define SC_SPECULAR 0.12f

static inline float sc_dot3(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Turn a normal towards the eye. A slightly averted one on a silhouette is laid flat instead of
 * turned over, which would make it flash. */
static inline void sc_face_eye(const float eye[3], float n[3])
{
    const float toward = sc_dot3(n, eye);
    float length;

    if (toward >= 0)
        return;
    if (toward < -0.35f) {
        for (int i = 0; i < 3; i++)
            n[i] = -n[i];
        return;
    }
    for (int i = 0; i < 3; i++)
        n[i] -= toward * eye[i];
    length = sqrtf(sc_dot3(n, n));
    for (int i = 0; i < 3; i++)
        n[i] /= length;
}

/* Blinn-Phong with a key light and a light at the eye. @p n is unit and faces the eye. */
static inline void sc_light(const sc_march *m, const float eye[3], const float n[3],
                            const float rgb[3], float out[3])
{
    const float key = sc_dot3(n, m->key_light), head = sc_dot3(n, eye);
    const float diffuse =
        SC_AMBIENT + SC_KEY * (key > 0 ? key : 0) + SC_HEAD * (head > 0 ? head : 0);
    float h[3], shine = 0, length;

    for (int i = 0; i < 3; i++)
        h[i] = m->key_light[i] + eye[i];
    length = sqrtf(sc_dot3(h, h));
    if (length > 0 && key > 0)
        shine = sc_dot3(n, h) / length;
    shine = shine > 0 ? shine : 0;
    shine *= shine; /* to the 32nd power */
    shine *= shine;
    shine *= shine;
    shine *= shine;
    shine *= shine;
    for (int i = 0; i < 3; i++)
        out[i] = rgb[i] * diffuse + SC_SPECULAR * shine;
}

/* A cut face keeps its tissue's colour, a little darker where it is seen from the side. */
static inline void sc_light_cut(const float eye[3], const float n[3], const float rgb[3],
                                float out[3])
{
    const float head = sc_dot3(n, eye);
    const float diffuse = 0.68f + 0.32f * (head > 0 ? head : -head);

    for (int i = 0; i < 3; i++)
        out[i] = rgb[i] * diffuse;
}

#endif
