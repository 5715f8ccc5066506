/* SPDX-License-Identifier: BSD-3-Clause */
/* The axes of a camera. */
#include "segcast/scene.h"

sc_camera sc_camera_look(sc_vec3 position_mm, sc_vec3 target_mm, sc_vec3 up,
                         sc_projection projection, double half_height)
{
    sc_camera camera = {
        .projection = projection, .position_mm = position_mm, .half_height = half_height};
    sc_vec3 right;

    camera.forward = sc_vec3_unit(sc_vec3_sub(target_mm, position_mm));
    right = sc_vec3_cross(camera.forward, up);
    if (sc_vec3_length(right) < 1e-9) /* up is parallel to the view: any perpendicular will do */
        right = sc_vec3_perpendicular(camera.forward);
    camera.right = sc_vec3_unit(right);
    camera.up = sc_vec3_cross(camera.right, camera.forward);
    return camera;
}
