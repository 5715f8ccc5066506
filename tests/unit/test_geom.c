/* SPDX-License-Identifier: BSD-3-Clause */
/* Affine maps, rotations, and lines clipped to boxes. */
#include "check.h"

#include "segcast/geom.h"

static void the_inverse_of_an_oblique_map_undoes_it(void **state)
{
    const sc_affine a = {{{1.5, 0.2, 0, 10}, {-0.1, 0.9, 0.3, -20}, {0, 0.4, -2, 5}}};
    sc_affine inverse;
    const sc_vec3 p = {3, -4, 5};
    sc_vec3 q;

    (void)state;
    assert_true(sc_affine_invert(&a, &inverse));
    q = sc_affine_point(&inverse, sc_affine_point(&a, p));
    assert_near(q.x, p.x, 1e-12);
    assert_near(q.y, p.y, 1e-12);
    assert_near(q.z, p.z, 1e-12);
    assert_near(sc_affine_determinant(&a) * sc_affine_determinant(&inverse), 1, 1e-12);
}

static void singular_maps_are_refused_at_any_scale(void **state)
{
    const sc_affine flat = {{{1, 0, 1, 0}, {0, 1, 0, 0}, {1, 0, 1, 0}}};
    const sc_affine tiny = {{{1e-6, 0, 0, 0}, {0, 1e-6, 0, 0}, {0, 0, 1e-6, 0}}};
    const sc_affine bad = {{{NAN, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    sc_affine out;

    (void)state;
    assert_false(sc_affine_invert(&flat, &out));
    assert_false(sc_affine_invert(&bad, &out));
    assert_true(sc_affine_invert(&tiny, &out));
}

static void rotations_are_right_handed(void **state)
{
    const sc_vec3 front = {0, 1, 0}, up = {0, 0, 1};
    const sc_vec3 turned = sc_vec3_rotate(front, up, M_PI / 2);

    (void)state;
    assert_near(turned.x, -1, 1e-12); /* from the front to the patient's left */
    assert_near(turned.y, 0, 1e-12);
}

static void lines_are_clipped_to_boxes(void **state)
{
    const sc_box3 box = {{0, 0, 0}, {10, 10, 10}};
    double begin = 0, end = 100;

    (void)state;
    assert_true(sc_box3_clip_line(&box, (sc_vec3){-5, 5, 5}, (sc_vec3){1, 0, 0}, &begin, &end));
    assert_near(begin, 5, 0);
    assert_near(end, 15, 0);
    begin = 0, end = 100;
    assert_false(sc_box3_clip_line(&box, (sc_vec3){-5, 11, 5}, (sc_vec3){1, 0, 0}, &begin, &end));
    begin = 0, end = 100; /* the line lies in a face of the box */
    assert_true(sc_box3_clip_line(&box, (sc_vec3){-5, 10, 5}, (sc_vec3){1, 0, 0}, &begin, &end));
    begin = 0, end = 100; /* the box is behind the origin */
    assert_false(sc_box3_clip_line(&box, (sc_vec3){15, 5, 5}, (sc_vec3){1, 0, 0}, &begin, &end));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_inverse_of_an_oblique_map_undoes_it),
        cmocka_unit_test(singular_maps_are_refused_at_any_scale),
        cmocka_unit_test(rotations_are_right_handed),
        cmocka_unit_test(lines_are_clipped_to_boxes),
    };

    return RUN(tests);
}
