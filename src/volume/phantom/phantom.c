/* SPDX-License-Identifier: BSD-3-Clause */
/* The synthetic heart: measures of an adult heart, in mm, RAS+ (x to the right, y to the front,
 * z up), origin at the centre of the grid. Shapes overlap; the tissue listed first owns a point. */
#include "phantom/phantom_model.h"

/* Index into sc_phantom.shapes. */
typedef enum shape_id {
    LV,
    LV_CAVITY,
    RV,
    LA,
    RA,
    AORTA,
    PULMONARY,
    SVC,
    IVC,
    VEINS,
    CORONARIES,
    FAT,
    MITRAL,
    AORTIC_VALVE,
    TRICUSPID,
    PULMONARY_VALVE,
    SHAPES
} shape_id;

enum {
    NONE = -1,        /* no shape_id */
    TUBE_POINTS = 40, /* of each tube */
    TUBES = 24,       /* most tubes there can be */
    COURSES = 6       /* coronary arteries */
};

/* A tissue fills its shape after the surface has been moved outward by grow_mm, and by systole_mm
 * more when the ventricles have contracted; where `within` names a second shape, only the part that
 * also lies inside that one, moved by within_grow_mm. */
typedef struct tissue {
    const char *name;
    uint8_t rgb[3]; /* sRGB */
    int shape;      /* shape_id */
    double grow_mm;
    int hu;     /* what it absorbs in CT with contrast agent in the left heart */
    int within; /* shape_id or NONE */
    double within_grow_mm, systole_mm;
} tissue;

/* By label value minus 1. */
static const tissue tissues[] = {
    {"aortic valve", {250, 240, 200}, AORTIC_VALVE, 0, 140, NONE, 0, 0},
    {"pulmonary valve", {235, 240, 215}, PULMONARY_VALVE, 0, 120, NONE, 0, 0},
    {"mitral valve", {250, 230, 190}, MITRAL, 0, 140, NONE, 0, 0},
    {"tricuspid valve", {235, 230, 205}, TRICUSPID, 0, 120, NONE, 0, 0},
    {"coronary arteries", {225, 30, 30}, CORONARIES, 0, 380, NONE, 0, 0},
    {"aorta", {214, 66, 58}, AORTA, 0, 390, NONE, 0, 0},
    {"pulmonary artery", {66, 116, 196}, PULMONARY, 0, 210, NONE, 0, 0},
    {"left ventricle", {172, 24, 38}, LV_CAVITY, 0, 370, NONE, 0, 0},
    {"interventricular septum", {170, 88, 78}, LV, 0, 112, RV, 5, 0},
    {"left ventricular myocardium", {186, 98, 84}, LV, 0, 118, NONE, 0, 0},
    {"right ventricle", {52, 74, 150}, RV, -3.5, 190, NONE, 0, -1.5},
    {"right ventricular myocardium", {198, 122, 100}, RV, 0, 95, NONE, 0, 0},
    {"superior vena cava", {78, 108, 190}, SVC, 0, 170, NONE, 0, 0},
    {"inferior vena cava", {60, 90, 172}, IVC, 0, 130, NONE, 0, 0},
    {"pulmonary veins", {222, 112, 110}, VEINS, 0, 360, NONE, 0, 0},
    {"left atrium", {196, 62, 72}, LA, -2.5, 365, NONE, 0, 0},
    {"left atrial wall", {208, 136, 122}, LA, 0, 85, NONE, 0, 0},
    {"right atrium", {70, 92, 168}, RA, -2.5, 180, NONE, 0, 0},
    {"right atrial wall", {192, 128, 124}, RA, 0, 80, NONE, 0, 0},
    {"epicardial fat", {240, 214, 140}, FAT, -0.8, -95, NONE, 0, 0},
};

enum { TISSUES = SC_COUNT_OF(tissues) };

struct sc_phantom {
    sc_shape shapes[SHAPES];            /* by shape_id */
    sc_vec3 points[TUBES][TUBE_POINTS]; /* of the tubes, in mm; parts borrow them */
    int tubes;                          /* rows of points in use */
    sc_beat beat;                       /* how far the chambers have contracted */
    sc_label labels[TISSUES];           /* by label value minus 1 */
};

/* The functions add_* append a part (or a cut) to the shape @p id. Lengths and positions are in
 * mm, and @p blend_mm is the width of the smooth union with the parts before it. The limits
 * SC_SHAPE_PARTS, SC_SHAPE_CUTS and TUBES are not checked: the heart below fits into them.
 * add_part returns the part as stored in the phantom. */
static sc_part *add_part(sc_phantom *phantom, shape_id id, sc_part part)
{
    sc_shape *shape = &phantom->shapes[id];

    shape->parts[shape->part_count] = part;
    return &shape->parts[shape->part_count++];
}

/* Two spheres, around @p a and @p b, and the cone between them. */
static void add_cone(sc_phantom *phantom, shape_id id, sc_vec3 a, double radius_a_mm, sc_vec3 b,
                     double radius_b_mm, double blend_mm)
{
    add_part(phantom, id,
             (sc_part){.kind = SC_PART_CONE,
                       .blend_mm = blend_mm,
                       .a = a,
                       .b = b,
                       .radius_a_mm = radius_a_mm,
                       .radius_b_mm = radius_b_mm});
}

/* An ellipsoid with its axes along x, y and z. */
static void add_ellipsoid(sc_phantom *phantom, shape_id id, sc_vec3 centre, sc_vec3 radii,
                          double blend_mm)
{
    add_part(phantom, id,
             (sc_part){.kind = SC_PART_ELLIPSOID, .blend_mm = blend_mm, .a = centre, .b = radii});
}

/* A tube along the Catmull-Rom spline through @p count controls, whose radius changes evenly
 * from radius_a_mm to radius_b_mm. Its blend_mm is 4. @return the points [TUBE_POINTS] of its
 * course, stored in the phantom; moving them moves the tube. */
static sc_vec3 *add_tube(sc_phantom *phantom, shape_id id, const sc_vec3 *controls, int count,
                         double radius_a_mm, double radius_b_mm)
{
    sc_vec3 *points = phantom->points[phantom->tubes++];

    sc_spline_points(controls, count, points, TUBE_POINTS);
    add_part(phantom, id,
             (sc_part){.kind = SC_PART_TUBE,
                       .blend_mm = 4,
                       .points = points,
                       .point_count = TUBE_POINTS,
                       .radius_a_mm = radius_a_mm,
                       .radius_b_mm = radius_b_mm});
    return points;
}

/* Cut off what lies beyond the plane through @p point, where @p normal points to; the edge is
 * rounded over @p blend_mm. */
static void add_cut(sc_phantom *phantom, shape_id id, sc_vec3 point, sc_vec3 normal,
                    double blend_mm)
{
    sc_shape *shape = &phantom->shapes[id];

    shape->cuts[shape->cut_count++] =
        (sc_cut){.point = point, .normal = sc_vec3_unit(normal), .blend_mm = blend_mm};
}

/* A valve, 1.8 mm thick: a cap of a spherical shell, radius_mm wide from its middle at
 * @p centre to its rim, that bulges along @p axis. */
static void add_leaflet(sc_phantom *phantom, shape_id id, sc_vec3 centre, sc_vec3 axis,
                        double radius_mm)
{
    add_part(phantom, id,
             (sc_part){.kind = SC_PART_LEAFLET,
                       .a = centre,
                       .b = sc_vec3_unit(axis),
                       .radius_a_mm = radius_mm,
                       .radius_b_mm = 0.9});
}

/* Positions in mm. base_axis points from the apex (left, front, below) towards the base. */
static const sc_vec3 base_axis = {0.62, -0.42, 0.66};
static const sc_vec3 mitral_centre = {1, -14, 9};
static const sc_vec3 tricuspid_centre = {27, 6, 3};
static const sc_vec3 tricuspid_axis = {0.78, -0.52, 0.34};

/* How the heart moves when its ventricles contract: the planes of the valves between atria and
 * ventricles descend towards the apex by so much, in mm, while the apex stays where it is. */
#define MITRAL_DESCENT_MM 12.0
#define TRICUSPID_DESCENT_MM 15.0

static sc_vec3 mitral_shift(const sc_phantom *phantom)
{
    return sc_vec3_scale(base_axis, -MITRAL_DESCENT_MM * phantom->beat.ventricles);
}

static sc_vec3 tricuspid_shift(const sc_phantom *phantom)
{
    return sc_vec3_scale(tricuspid_axis, -TRICUSPID_DESCENT_MM * phantom->beat.ventricles);
}

/* Where a point of the grooves between the chambers goes: with the plane of the mitral valve at
 * its height, less towards the apex, and less again above the atria. */
static sc_vec3 with_grooves(const sc_phantom *phantom, sc_vec3 p)
{
    const sc_vec3 apex = {-52, 24, -48};
    const double above_mm = 25; /* the plane; from there on nothing moves */
    const double plane = sc_vec3_dot(sc_vec3_sub(mitral_centre, apex), base_axis);
    const double height = sc_vec3_dot(sc_vec3_sub(p, apex), base_axis);
    const double share = height < plane ? height / plane : 1 - (height - plane) / above_mm;

    return sc_vec3_along(p, fmin(fmax(share, 0), 1), mitral_shift(phantom));
}

/* @return the outer radius, in mm, of a wall whose inner radius was @p inner_mm at rest, and is
 * @p share of that now. The muscle keeps its volume while the chamber gets shorter, to @p length
 * of what it was. */
static double wall_radius_mm(double outer_mm, double inner_mm, double share, double length)
{
    const double rest = outer_mm * outer_mm - inner_mm * inner_mm;

    return share == 1 && length == 1 ? outer_mm
                                     : sqrt(rest / length + share * share * inner_mm * inner_mm);
}

/* The functions build_* add the parts of their organs to the shapes of a phantom that is zeroed
 * but for its beat. build_fat and build_coronaries use the shapes of those before them. */
static void build_left_ventricle(sc_phantom *phantom)
{
    const double contracted = phantom->beat.ventricles;
    const double share = 1 - 0.3 * contracted, length = 1 - 0.16 * contracted;
    const sc_vec3 shift = mitral_shift(phantom), valve = sc_vec3_add(mitral_centre, shift);
    const sc_vec3 upper = sc_vec3_add((sc_vec3){-7, -9, 2}, shift);

    add_cone(phantom, LV, upper, wall_radius_mm(32, 21.5, share, length), (sc_vec3){-43, 17, -38},
             wall_radius_mm(19, 9, share, length), 0);
    add_cut(phantom, LV, sc_vec3_along(valve, 3, base_axis), base_axis, 8);
    add_cone(phantom, LV_CAVITY, upper, 21.5 * share, (sc_vec3){-40, 15, -34}, 9 * share, 0);
    add_cut(phantom, LV_CAVITY, sc_vec3_along(valve, 1, base_axis), base_axis, 3);
    add_leaflet(phantom, MITRAL, valve, (sc_vec3){-0.62, 0.42, -0.66}, 15);
}

static void build_right_ventricle(sc_phantom *phantom)
{
    const double contracted = phantom->beat.ventricles;
    const sc_vec3 shift = tricuspid_shift(phantom), valve = sc_vec3_add(tricuspid_centre, shift);

    add_cone(phantom, RV, sc_vec3_along((sc_vec3){11, 15, -3}, 0.5, shift), 25 - 3.5 * contracted,
             (sc_vec3){-30, 28, -36}, 12 - contracted, 0);
    add_cone(phantom, RV, (sc_vec3){3, 24, 8}, 18 - 3 * contracted, (sc_vec3){-8, 22, 27}, 11.5,
             14);
    add_cut(phantom, RV, sc_vec3_along(valve, 2, tricuspid_axis), tricuspid_axis, 6);
    add_leaflet(phantom, TRICUSPID, valve, (sc_vec3){-0.78, 0.52, -0.34}, 14);
}

/* An atrium: an ellipsoid that reaches as far as its valve goes, and is filled by that, until it
 * contracts itself. */
static void add_atrium(sc_phantom *phantom, shape_id id, sc_vec3 centre, sc_vec3 radii,
                       sc_vec3 shift)
{
    const double share = 1 - 0.12 * phantom->beat.atria;
    const sc_vec3 reach = {fabs(shift.x), fabs(shift.y), fabs(shift.z)};

    add_ellipsoid(phantom, id, sc_vec3_along(centre, 0.5, shift),
                  sc_vec3_scale(sc_vec3_along(radii, 0.5, reach), share), 0);
}

/* LA and RA, each an ellipsoid with its auricle. */
static void build_atria(sc_phantom *phantom)
{
    static const sc_vec3 left_auricle[] = {{-14, -20, 22}, {-28, -10, 24}, {-35, 4, 22}};
    static const sc_vec3 right_auricle[] = {{36, 6, 24}, {28, 19, 26}, {17, 25, 24}};

    add_atrium(phantom, LA, (sc_vec3){5, -28, 18}, (sc_vec3){28, 18, 18.5}, mitral_shift(phantom));
    add_tube(phantom, LA, left_auricle, 3, 9, 6);
    phantom->shapes[LA].parts[1].blend_mm = 9;
    add_atrium(phantom, RA, (sc_vec3){39, -6, 12}, (sc_vec3){22, 23, 27}, tricuspid_shift(phantom));
    add_tube(phantom, RA, right_auricle, 3, 11, 7);
    phantom->shapes[RA].parts[1].blend_mm = 9;
}

/* AORTA and PULMONARY with their branches, cut off at their ends, and both of their valves. */
static void build_great_arteries(sc_phantom *phantom)
{
    static const sc_vec3 trunk[] = {{-7, 23, 24}, {-9, 18, 35}, {-11, 5, 43}, {-11, -9, 43}};
    static const sc_vec3 right[] = {{-11, -4, 43}, {4, -17, 43}, {24, -21, 42}, {52, -23, 39}};
    static const sc_vec3 left[] = {{-11, -5, 43}, {-20, -14, 44}, {-34, -22, 44}, {-52, -30, 40}};
    sc_vec3 aorta[] = {{3, 0, 13},      {9, 4, 27},     {13, 7, 42},    {8, 2, 54},
                       {-6, -12, 60},   {-19, -30, 52}, {-24, -41, 34}, {-24, -43, 5},
                       {-22, -43, -40}, {-20, -43, -84}};
    static const sc_vec3 brachiocephalic[] = {{7, 1, 55}, {13, 0, 68}, {21, 0, 88}};
    static const sc_vec3 carotid[] = {{-3, -9, 59}, {-6, -8, 72}, {-8, -8, 90}};
    static const sc_vec3 subclavian[] = {{-13, -20, 57}, {-19, -20, 70}, {-26, -19, 90}};
    const sc_vec3 top = {0, 0, 79.5}, up = {0, 0, 1}, bottom = {0, 0, -79.5}, down = {0, 0, -1};
    const double follows = 0.6; /* the root of the aorta, the plane of the mitral valve */
    const sc_vec3 shift = sc_vec3_scale(mitral_shift(phantom), follows);

    aorta[0] = sc_vec3_add(aorta[0], shift);
    aorta[1] = sc_vec3_along(aorta[1], 0.5, shift);

    add_tube(phantom, AORTA, aorta, 10, 13, 9.5);
    add_tube(phantom, AORTA, brachiocephalic, 3, 5.5, 5);
    add_tube(phantom, AORTA, carotid, 3, 3.8, 3.4);
    add_tube(phantom, AORTA, subclavian, 3, 4.4, 4);
    add_cut(phantom, AORTA, top, up, 0.5);
    add_cut(phantom, AORTA, bottom, down, 0.5);
    add_tube(phantom, PULMONARY, trunk, 4, 13, 11.5);
    add_tube(phantom, PULMONARY, right, 4, 9.5, 7);
    add_tube(phantom, PULMONARY, left, 4, 9.5, 7);
    add_cut(phantom, PULMONARY, (sc_vec3){48, -22, 40}, (sc_vec3){1, -0.07, -0.11}, 0.5);
    add_cut(phantom, PULMONARY, (sc_vec3){-48, -28, 41}, (sc_vec3){-0.9, -0.4, -0.2}, 0.5);
    add_leaflet(phantom, AORTIC_VALVE, sc_vec3_add((sc_vec3){6, 2, 20}, shift),
                (sc_vec3){-0.35, -0.2, -0.9}, 12);
    add_leaflet(phantom, PULMONARY_VALVE, (sc_vec3){-7.6, 21, 29}, (sc_vec3){0.1, 0.4, -0.9}, 11);
}

/* SVC, IVC and the four pulmonary VEINS, cut off at their ends. */
static void build_veins(sc_phantom *phantom)
{
    static const sc_vec3 svc[] = {{38, -4, 28}, {36, -2, 48}, {32, 0, 66}, {29, 2, 86}};
    static const sc_vec3 ivc[] = {{40, -12, -4}, {38, -15, -22}, {35, -17, -42}, {33, -18, -70}};
    static const sc_vec3 veins[4][3] = {{{20, -31, 24}, {40, -33, 26}, {64, -37, 29}},
                                        {{20, -35, 10}, {40, -38, 6}, {62, -42, 1}},
                                        {{-10, -29, 24}, {-28, -28, 26}, {-56, -30, 28}},
                                        {{-8, -31, 13}, {-28, -31, 12}, {-56, -35, 8}}};

    add_tube(phantom, SVC, svc, 4, 10, 8.5);
    add_cut(phantom, SVC, (sc_vec3){0, 0, 79.5}, (sc_vec3){0, 0, 1}, 0.5);
    add_tube(phantom, IVC, ivc, 4, 12, 11);
    add_cut(phantom, IVC, (sc_vec3){0, 0, -62}, (sc_vec3){0, 0, -1}, 0.5);
    for (int i = 0; i < 4; i++)
        add_tube(phantom, VEINS, veins[i], 3, 7, 5.5);
    add_cut(phantom, VEINS, (sc_vec3){58, 0, 0}, (sc_vec3){1, 0, 0}, 0.5);
    add_cut(phantom, VEINS, (sc_vec3){-51, 0, 0}, (sc_vec3){-1, 0, 0}, 0.5);
}

/* Fat fills the grooves between the chambers: their union, blended more widely than they are. */
static void build_fat(sc_phantom *phantom)
{
    static const shape_id chambers[] = {LV, RV, LA, RA};

    for (size_t i = 0; i < SC_COUNT_OF(chambers); i++) {
        const sc_shape *chamber = &phantom->shapes[chambers[i]];

        for (int part = 0; part < chamber->part_count; part++)
            add_part(phantom, FAT, chamber->parts[part])->blend_mm = 11;
    }
}

/* Field of the heart's outer surface at @p p (mm), on which the coronary arteries run. Needs
 * fat and great arteries. */
static double surface_field(const sc_phantom *phantom, sc_vec3 p)
{
    const double blend = 4;
    const double fat = sc_shape_field(&phantom->shapes[FAT], p, HUGE_VAL);
    const double limit =
        fat + 2 * blend; /* the arteries' own union is at most blend / 4 below both */
    const double arteries =
        sc_smooth_min(sc_shape_field(&phantom->shapes[AORTA], p, limit),
                      sc_shape_field(&phantom->shapes[PULMONARY], p, limit), blend);

    return sc_smooth_min(fat, arteries, blend);
}

/* Gradient of the heart's outer surface at @p p, by central differences over 1e-4 mm: about a unit
 * vector, pointing outward. */
static sc_vec3 surface_slope(const sc_phantom *phantom, sc_vec3 p)
{
    const double h = 1e-4;
    const sc_vec3 steps[3] = {{h, 0, 0}, {0, h, 0}, {0, 0, h}};
    double out[3];

    for (int i = 0; i < 3; i++)
        out[i] = (surface_field(phantom, sc_vec3_add(p, steps[i])) -
                  surface_field(phantom, sc_vec3_sub(p, steps[i]))) /
                 (2 * h);
    return (sc_vec3){out[0], out[1], out[2]};
}

/* Move points[TUBE_POINTS], the course of a tube, onto the heart's outer surface, @p lift_mm
 * above it, by Newton steps, and make the course smooth in between; the last pass only moves. */
static void lay_on_surface(const sc_phantom *phantom, sc_vec3 *points, double lift_mm)
{
    for (int pass = 0; pass < 6; pass++) {
        for (int i = 0; i < TUBE_POINTS; i++) {
            for (int step = 0; step < 8; step++) {
                const double field = surface_field(phantom, points[i]) - lift_mm;
                sc_vec3 slope;

                if (fabs(field) < 1e-9) /* mm: below what the differences of the slope can tell */
                    break;
                slope = surface_slope(phantom, points[i]);
                points[i] =
                    sc_vec3_along(points[i], -field / fmax(sc_vec3_dot(slope, slope), 0.1), slope);
            }
        }
        for (int i = 1; i + 1 < TUBE_POINTS && pass < 5; i++) {
            const sc_vec3 middle = sc_vec3_scale(sc_vec3_add(points[i - 1], points[i + 1]), 0.5);

            points[i] = sc_vec3_scale(sc_vec3_add(points[i], middle), 0.5);
        }
    }
}

/* CORONARIES: each course is laid on the outer surface of the heart. */
static void build_coronaries(sc_phantom *phantom)
{
    static const struct {
        sc_vec3 controls[6];
        int count;
        double radius_a, radius_b;
    } courses[COURSES] = {
        /* right coronary in the groove between right atrium and ventricle */
        {{{17, 16, 24}, {27, 27, 14}, {38, 22, -8}, {33, 8, -24}, {14, -8, -32}}, 5, 2.2, 1.7},
        /* posterior descending, along the lower groove to the apex */
        {{{14, -8, -32}, {0, 4, -38}, {-18, 16, -48}, {-36, 24, -54}}, 4, 1.7, 1.1},
        /* left anterior descending, along the front groove to the apex */
        {{{-5, 10, 28}, {-18, 20, 22}, {-26, 34, 6}, {-38, 38, -16}, {-50, 36, -40}}, 5, 2.3, 1.1},
        /* circumflex in the groove between left atrium and ventricle */
        {{{-12, 14, 25}, {-30, 0, 16}, {-36, -18, 8}, {-26, -36, 0}, {-6, -40, -8}}, 5, 2.0, 1.4},
        /* obtuse marginal */
        {{{-33, -8, 12}, {-46, -8, -6}, {-54, 2, -26}, {-58, 14, -42}}, 4, 1.7, 1.0},
        /* diagonal */
        {{{-24, 30, 12}, {-40, 26, -2}, {-52, 20, -18}, {-60, 18, -36}}, 4, 1.7, 1.0},
    };

    for (int i = 0; i < COURSES; i++) {
        sc_vec3 controls[SC_COUNT_OF(courses[i].controls)], *points;

        for (int c = 0; c < courses[i].count; c++)
            controls[c] = with_grooves(phantom, courses[i].controls[c]);
        points = add_tube(phantom, CORONARIES, controls, courses[i].count, courses[i].radius_a,
                          courses[i].radius_b);

        lay_on_surface(phantom, points, 0.7);
        phantom->shapes[CORONARIES].parts[i].blend_mm = 1.5;
    }
}

/* Make the fields of all shapes quick that have parts. */
static void measure_shapes(sc_phantom *phantom)
{
    for (int i = 0; i < SHAPES; i++)
        sc_shape_measure(&phantom->shapes[i]);
}

/* Added to limits of fields, so that rounding does not bring a field that is not exact below. */
static const double ROUNDING_MM = 1e-6;

double sc_phantom_field(const sc_phantom *phantom, int label, sc_vec3 p, double limit_mm)
{
    const tissue *t = &tissues[label - 1];
    const double grow_mm = t->grow_mm + t->systole_mm * phantom->beat.ventricles;
    double field = sc_shape_field(&phantom->shapes[t->shape], p, limit_mm + grow_mm + ROUNDING_MM);

    field -= grow_mm;
    if (t->within != NONE && field < limit_mm) {
        const sc_shape *within = &phantom->shapes[t->within];
        const double other = sc_shape_field(within, p, limit_mm + t->within_grow_mm + ROUNDING_MM) -
                             t->within_grow_mm;

        field = field > other ? field : other;
    }
    return field;
}

sc_status sc_phantom_new_beating(const sc_ctx *ctx, double phase, sc_phantom **out)
{
    sc_phantom *phantom;

    SC_PASS(sc_zalloc(ctx, 1, sizeof(sc_phantom), &phantom));
    phantom->beat = sc_beat_at(phase);
    build_left_ventricle(phantom);
    build_right_ventricle(phantom);
    build_atria(phantom);
    build_great_arteries(phantom);
    build_veins(phantom);
    build_fat(phantom);
    measure_shapes(phantom);
    build_coronaries(phantom);
    measure_shapes(phantom);
    for (int i = 0; i < TISSUES; i++) {
        sc_label *label = &phantom->labels[i];

        label->value = i + 1;
        snprintf(label->name, sizeof label->name, "%s", tissues[i].name);
        memcpy(label->rgb, tissues[i].rgb, sizeof label->rgb);
        label->has_color = true;
        label->opacity = -1;
    }
    *out = phantom;
    return SC_OK;
}

sc_status sc_phantom_new(const sc_ctx *ctx, sc_phantom **out)
{
    return sc_phantom_new_beating(ctx, 0, out);
}

void sc_phantom_free(sc_phantom *phantom)
{
    sc_free(phantom);
}

int sc_phantom_tissue_count(const sc_phantom *phantom)
{
    return TISSUES;
}

const sc_label *sc_phantom_label(const sc_phantom *phantom, int label)
{
    return &phantom->labels[label - 1];
}

int sc_phantom_hu(int label)
{
    return tissues[label - 1].hu;
}

bool sc_phantom_tube(const sc_phantom *phantom, int label, int tube, const sc_vec3 **points,
                     int *count, double radius_mm[2])
{
    const sc_shape *shape = &phantom->shapes[tissues[label - 1].shape];

    for (int i = 0; i < shape->part_count; i++) {
        const sc_part *part = &shape->parts[i];

        if (part->kind != SC_PART_TUBE || tube-- > 0)
            continue;
        *points = part->points;
        *count = part->point_count;
        radius_mm[0] = part->radius_a_mm;
        radius_mm[1] = part->radius_b_mm;
        return true;
    }
    return false;
}
