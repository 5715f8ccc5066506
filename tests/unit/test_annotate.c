/* SPDX-License-Identifier: BSD-3-Clause */
/* Tests what is written onto pictures: that it does not depend on which rows are drawn, that it can
 * be read on any background, and that it says what is so. */
#include "check.h"

#include "internal.h"

enum { WIDTH = 640, HEIGHT = 360, FRAMES = 11 };

enum { LABELS = 40 };

/* A film with overlays. */
typedef struct film {
    sc_label labels[LABELS];
    sc_label_stats stats[LABELS];
    sc_tissue tissues[LABELS];
    sc_prepared volume;
    float fades[LABELS];
    sc_overlays overlays;
    sc_caption captions[3];
    sc_timeline timeline;
    sc_annotations annotations;
    sc_scene scene;
    sc_lettering *lettering;
} film;

/* A film with captions, whose camera sees 180 mm from top to bottom by parallel rays. */
static void begin_film(film *f, size_t captions)
{
    memset(f, 0, sizeof *f);
    f->overlays = (sc_overlays){.font = "DejaVu Sans", .text_percent = 4};
    for (size_t i = 0; i < captions; i++) {
        f->captions[i] = (sc_caption){.end = SC_CAPTION_STAYS, .place = SC_PLACE_BOTTOM};
        snprintf(f->captions[i].where, sizeof f->captions[i].where, "job.yaml:%zu", 7 + i);
    }
    f->timeline.animation.frames = FRAMES;
    f->timeline.low_mm = (sc_vec3){-50, -50, -50};
    f->timeline.high_mm = (sc_vec3){50, 50, 50};
    f->scene.camera = sc_camera_look((sc_vec3){0, 400, 0}, (sc_vec3){0, 0, 0}, (sc_vec3){0, 0, 1},
                                     SC_ORTHOGRAPHIC, 90);
    f->annotations = (sc_annotations){.overlays = &f->overlays,
                                      .lists = {.captions = f->captions, .caption_count = captions},
                                      .timeline = &f->timeline,
                                      .within = {0, 0, WIDTH, HEIGHT},
                                      .fps = 25};
    f->scene.dark_text = 1;
}

/* Give a film @p count tissues, boxes of 10 mm that lie 20 mm from each other along y. */
static void add_tissues(film *f, int count)
{
    f->volume = (sc_prepared){
        .label_count = count + 1, .labels = f->labels, .stats = f->stats, .oriented = true};
    f->volume.to_ras_mm = (sc_affine){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    for (int id = 1; id <= count; id++) {
        f->labels[id].value = 2 * id;
        snprintf(f->labels[id].name, sizeof f->labels[id].name, "tissue_%d", id);
        f->tissues[id] = (sc_tissue){.visible = true, .opacity = 0.5, .rgb_linear = {1, 0, 0}};
        f->fades[id] = 1;
        f->stats[id] = (sc_label_stats){
            .voxels = (uint64_t)(1000 + id), .low = {0, 20 * id, 0}, .high = {9, 20 * id + 9, 9}};
    }
    f->scene.fades = f->fades;
    f->annotations.volume = &f->volume;
    f->annotations.tissues = f->tissues;
}

static void letter_film(film *f)
{
    assert_ok(sc_annotations_letter(&quiet, &f->annotations, &f->lettering));
    f->annotations.lettering = f->lettering;
}

/* The words of a film cannot be lettered: so many errors, of which the last says @p text. */
static void expect_refusal(film *f, int errors, const char *text)
{
    const sc_ctx *ctx = listening_anew();

    assert_int_equal(sc_annotations_letter(ctx, &f->annotations, &f->lettering), SC_ERR_DATA);
    assert_int_equal(said.errors, errors);
    assert_non_null(strstr(said.text, text));
}

static void end_film(film *f)
{
    sc_free(f->lettering);
}

/* A picture of one grey level; with alpha it is transparent. */
static sc_image blank(bool alpha, int level)
{
    sc_image image;

    assert_ok(sc_image_init_alpha(&quiet, WIDTH, HEIGHT, alpha, &image));
    memset(image.rgb, alpha ? 0 : level, sc_image_bytes(&image));
    return image;
}

static sc_image draw(const film *f, int k, bool alpha, int level)
{
    sc_image image = blank(alpha, level);
    sc_scene scene = f->scene;

    scene.frame = k;
    scene.time = sc_frame_time(k, FRAMES);
    assert_ok(sc_annotations_draw(&quiet, &f->annotations, &scene, &image, NULL));
    return image;
}

static const uint8_t *pixel(const sc_image *image, int x, int y)
{
    return image->rgb +
           ((size_t)y * (size_t)image->width_px + (size_t)x) * sc_pixel_bytes(image->alpha);
}

/* The bounding box of the pixels of frame @p k on white that are darker than half: left, top,
 * right, bottom. @return how many they are. */
static int ink(const film *f, int k, int box[4])
{
    SC_OWN(sc_image_clear) sc_image image = draw(f, k, false, 255);
    int count = 0;

    box[0] = box[1] = 10000;
    box[2] = box[3] = -1;
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            if (pixel(&image, x, y)[0] > 127)
                continue;
            box[0] = x < box[0] ? x : box[0];
            box[1] = y < box[1] ? y : box[1];
            box[2] = x > box[2] ? x : box[2];
            box[3] = y > box[3] ? y : box[3];
            count++;
        }
    }
    return count;
}

/* Everything that there is. */
static void begin_full_film(film *f)
{
    begin_film(f, 2);
    add_tissues(f, 5);
    f->overlays.legend = SC_PLACE_BOTTOM_RIGHT;
    strcpy(f->captions[0].text, "A caption of two\nlines, with \303\244 and a\314\201");
    strcpy(f->captions[1].text, "Another one");
    f->captions[1].place = SC_PLACE_TOP_LEFT;
    f->overlays.time = SC_PLACE_TOP_RIGHT;
    f->overlays.scale_bar = SC_PLACE_BOTTOM_LEFT;
    f->overlays.orientation = SC_PLACE_TOP_RIGHT;
    letter_film(f);
}

TEST(rows_can_be_drawn_by_themselves)
{
    SC_OWN(end_film) film f = {0};

    begin_full_film(&f);
    f.scene.frame = 3;
    f.scene.time = sc_frame_time(3, FRAMES);
    for (int alpha = 0; alpha < 2; alpha++) {
        SC_OWN(sc_image_clear) sc_image whole = draw(&f, 3, alpha, 200), parts = blank(alpha, 200);

        for (int row = 0; row < HEIGHT; row += 7) {
            const sc_rows rows = {row, row + 7 < HEIGHT ? row + 7 : HEIGHT};

            assert_ok(sc_annotations_draw(&quiet, &f.annotations, &f.scene, &parts, &rows));
        }
        assert_int_equal(sc_image_hash(&whole), sc_image_hash(&parts));
    }
}

TEST(without_overlays_a_picture_stays_as_it_is)
{
    SC_OWN(sc_image_clear) sc_image untouched = blank(false, 90), image = {0};
    film f;

    begin_film(&f, 0);
    assert_false(sc_annotations_any(&f.annotations));
    image = draw(&f, 0, false, 90);
    assert_int_equal(sc_image_hash(&image), sc_image_hash(&untouched));
}

/* Text holds both dark and light pixels, whatever lies behind it, and so does a scale bar. */
TEST(text_can_be_read_on_any_background)
{
    film f;

    for (int kind = 0; kind < 4; kind++) {
        const bool dark = kind & 1, is_bar = kind & 2;

        begin_film(&f, 1);
        strcpy(f.captions[0].text, "A caption");
        f.overlays.scale_bar = is_bar ? SC_PLACE_TOP_LEFT : SC_PLACE_NONE;
        f.annotations.lists.caption_count = !is_bar;
        f.scene.dark_text = !dark;
        letter_film(&f);
        for (int level = 0; level < 256; level += 51) {
            SC_OWN(sc_image_clear) sc_image image = draw(&f, 3, false, level);
            int darkest = 255, lightest = 0;

            for (size_t i = 0; i < sc_image_bytes(&image); i++) {
                darkest = image.rgb[i] < darkest ? image.rgb[i] : darkest;
                lightest = image.rgb[i] > lightest ? image.rgb[i] : lightest;
            }
            assert_true(lightest - darkest > 150);
        }
        end_film(&f);
    }
}

TEST(over_transparency_text_is_opaque)
{
    SC_OWN(sc_image_clear) sc_image image = {0};
    SC_OWN(end_film) film f = {0};
    int opaque = 0, clear = 0;

    begin_full_film(&f);
    image = draw(&f, 3, true, 0);
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            opaque += pixel(&image, x, y)[3] == 255;
            clear += pixel(&image, x, y)[3] == 0;
        }
    }
    assert_true(opaque > 1000 && clear > WIDTH * HEIGHT / 2);
}

/* The longest row of dark pixels of frame 0 on white. */
static int longest_row(const film *f)
{
    SC_OWN(sc_image_clear) sc_image image = draw(f, 0, false, 255);
    int longest = 0;

    for (int y = 0; y < HEIGHT; y++) {
        int run = 0;

        for (int x = 0; x < WIDTH; x++) {
            run = pixel(&image, x, y)[0] < 60 ? run + 1 : 0;
            longest = run > longest ? run : longest;
        }
    }
    return longest;
}

TEST(a_scale_bar_is_as_long_as_it_says)
{
    SC_OWN(end_film) film f = {0};

    begin_film(&f, 0);
    f.overlays.scale_bar = SC_PLACE_BOTTOM_LEFT;
    letter_film(&f);
    /* 180 mm on 360 pixels: a fifth of 640 pixels is 64 mm, so the bar is 50 mm: 100 pixels. */
    assert_int_equal(longest_row(&f), 100);
    /* Perspective: half the height is 90 mm at 400 mm, where the middle of the box is. */
    f.scene.camera.projection = SC_PERSPECTIVE;
    f.scene.camera.half_height = 90.0 / 400;
    assert_int_equal(longest_row(&f), 100);
    f.scene.camera.position_mm.y = -400; /* it looks away from all that is visible */
    f.scene.camera.forward.y = -1;
    assert_int_equal(longest_row(&f), 0);
}

TEST(captions_are_shown_in_their_time)
{
    static const char seen[FRAMES + 1] = "00011100001"; /* frames 3 to 5; the last one */
    SC_OWN(end_film) film f = {0};

    begin_film(&f, 2);
    strcpy(f.captions[0].text, "first");
    strcpy(f.captions[1].text, "second");
    f.captions[0].begin = 0.3;
    f.captions[0].end = 0.6;
    f.captions[1].begin = 1;
    letter_film(&f);
    for (int k = 0; k < FRAMES; k++) {
        int box[4];

        assert_int_equal(ink(&f, k, box) > 0, seen[k] == '1');
    }
}

/* A long text is broken, also where it has no blanks, and stays within the picture. */
TEST(long_captions_fit)
{
    film f;

    for (int kind = 0; kind < 3; kind++) {
        int box[4];

        begin_film(&f, 1);
        for (size_t i = 0; i < (kind == 2 ? 240 : 120); i++)
            f.captions[0].text[i] = kind == 1 && i % 6 == 5 ? ' ' : 'W';
        letter_film(&f);
        assert_true(ink(&f, 0, box) > 0);
        assert_true(box[0] > 4 && box[2] < WIDTH - 4);
        assert_true(box[1] > HEIGHT / 2 && box[3] < HEIGHT - 4);
        assert_true(box[3] - box[1] > 20); /* more than one line */
        end_film(&f);
    }
}

/* The red pixels of squares in row @p row of a legend in the upper left corner: how many, and the
 * least value of green among them. */
static int square(const sc_image *image, const film *f, int row, int *green)
{
    const sc_word *word = sc_lettering_find(f->lettering, SC_WORD_LEGEND, 1); /* the first row */
    const int margin = (int)(0.8 * 0.04 * HEIGHT + 0.5);
    int count = 0;

    assert_non_null(word);
    *green = 255;
    for (int y = margin + row * word->line_px; y < margin + row * word->line_px + word->capitals_px;
         y++) {
        for (int x = margin; x < margin + word->capitals_px; x++) {
            const uint8_t *p = pixel(image, x, y);

            count += p[0] > 250 && p[1] < 250;
            *green = p[1] < *green ? p[1] : *green;
        }
    }
    return count;
}

TEST(a_legend_shows_what_is_seen_now)
{
    sc_image image;
    SC_OWN(end_film) film f = {0};
    int green;

    begin_film(&f, 0);
    add_tissues(&f, 5);
    f.overlays.legend = SC_PLACE_TOP_LEFT;
    f.tissues[3].visible = false; /* it has no row */
    letter_film(&f);
    assert_null(sc_lettering_find(f.lettering, SC_WORD_LEGEND, 3));
    image = draw(&f, 0, false, 255);
    for (int row = 0; row < 4; row++) {
        assert_true(square(&image, &f, row, &green) > 50);
        assert_int_equal(green, 0);
    }
    sc_image_clear(&image);
    /* Tissue 2 has faded to a half, tissue 5, in the fourth row, is cut away; no row moves. */
    f.fades[2] = 0.5f;
    f.scene.clip.planes[0] = (sc_plane){{0, -1, 0}, 99}; /* keeps y up to 99 */
    f.scene.clip.count = 1;
    f.scene.clip.set_count = 1;
    f.scene.clip.sets[0] = 1;
    image = draw(&f, 0, false, 255);
    assert_true(square(&image, &f, 0, &green) > 50 && green == 0);
    assert_true(square(&image, &f, 1, &green) > 50 && green > 100 && green < 140);
    assert_true(square(&image, &f, 2, &green) > 50 && green == 0);
    assert_true(square(&image, &f, 3, &green) == 0);
    sc_image_clear(&image);
}

/* A legend of chosen tissues has rows for these alone; names that are chosen for the pictures do
 * not matter. */
TEST(a_legend_shows_chosen_tissues)
{
    sc_named_tissue chosen[] = {{.of = SC_USE_LEGEND, .pattern = "tissue_4"},
                                {.of = SC_USE_NAMES, .pattern = "tissue_1"},
                                {.of = SC_USE_LEGEND, .pattern = "4"}, /* the label */
                                {.of = SC_USE_LEGEND, .pattern = "*_5"}};
    SC_OWN(end_film) film f = {0};

    begin_film(&f, 0);
    add_tissues(&f, 5);
    f.overlays.legend = SC_PLACE_TOP_LEFT;
    f.overlays.names_percent = 4;
    f.annotations.lists.tissues = chosen;
    f.annotations.lists.tissue_count = SC_COUNT_OF(chosen);
    f.tissues[5].visible = false; /* it has no row though it is chosen */
    letter_film(&f);
    for (int id = 1; id <= 5; id++) {
        assert_int_equal(sc_lettering_find(f.lettering, SC_WORD_LEGEND, id) != NULL,
                         id == 2 || id == 4);
        assert_int_equal(sc_lettering_find(f.lettering, SC_WORD_NAME, id) != NULL, id == 1);
    }
    assert_null(sc_lettering_find(f.lettering, SC_WORD_MORE, 'm'));
}

/* @return in how many rows of a legend in the upper left corner squares are red, as in square. */
static int red_rows(film *f)
{
    const int line_px = sc_lettering_find(f->lettering, SC_WORD_LEGEND, 1)->line_px;
    SC_OWN(sc_image_clear) sc_image image = draw(f, 0, false, 255);
    int rows = 0, green;

    for (int row = 0; row < 0.8 * HEIGHT / line_px; row++)
        rows += square(&image, f, row, &green) > 5 && green == 0;
    return rows;
}

/* A legend for which there is no room shows the largest tissues that are seen now, and how many
 * there are beside. */
TEST(a_long_legend_names_the_largest)
{
    film f;
    int box[4], lower[4], rows;

    begin_film(&f, 0);
    add_tissues(&f, LABELS - 1); /* voxels rise with the id */
    f.overlays.legend = SC_PLACE_TOP_LEFT;
    memset(f.labels[39].name, 'W', SC_NAME_BYTES - 1);
    for (int id = 1; id <= 10; id++) /* the smallest are blue */
        f.tissues[id].rgb_linear[0] = 0, f.tissues[id].rgb_linear[2] = 1;
    letter_film(&f);
    assert_non_null(sc_lettering_find(f.lettering, SC_WORD_MORE, 'm'));
    rows = red_rows(&f);
    assert_true(rows > 10 && rows < LABELS - 11);
    assert_true(ink(&f, 0, box) > 0 && box[2] < WIDTH / 2 && box[3] < 0.8 * HEIGHT);
    /* If others are faded away, there is room for the smaller ones, at last for all of them. */
    f.fades[39] = f.fades[30] = 0;
    assert_int_equal(red_rows(&f), rows);
    for (int id = 16; id < LABELS; id++)
        f.fades[id] = 0;
    assert_int_equal(red_rows(&f), 5);
    assert_true(ink(&f, 0, lower) > 0 && lower[3] < box[3]); /* no last row that counts */
    for (int id = 1; id < LABELS; id++)
        f.fades[id] = 0;
    assert_int_equal(ink(&f, 0, lower), 0);
    end_film(&f);
    /* At a lower edge the rows end where the last of all would. */
    begin_film(&f, 0);
    add_tissues(&f, LABELS - 1);
    f.overlays.legend = SC_PLACE_BOTTOM_RIGHT;
    letter_film(&f);
    assert_true(ink(&f, 0, box) > 0);
    assert_true(box[0] > WIDTH / 2 && box[2] < WIDTH && box[1] > HEIGHT / 5 && box[3] < HEIGHT);
    for (int id = 4; id < LABELS; id++)
        f.fades[id] = 0;
    assert_true(ink(&f, 0, lower) > 0 && lower[1] > box[1] + 50 && lower[3] + 8 > box[3]);
    end_film(&f);
}

TEST(names_that_cannot_be_written_are_refused)
{
    film f;

    begin_film(&f, 0);
    add_tissues(&f, 2);
    f.overlays.legend = SC_PLACE_TOP;
    strcpy(f.labels[2].name, "\327\220");
    expect_refusal(&f, 1, "(label 4) cannot be written onto pictures: U+05D0");
}

/* Remove the letter from the lettering of a film. */
static void blank_letter(film *f, char letter)
{
    const sc_word *word = sc_lettering_find(f->lettering, SC_WORD_ORIENTATION, letter);

    assert_non_null(word);
    memset((uint8_t *)f->lettering + word->at, 0,
           2 * (size_t)word->width_px * (size_t)word->height_px);
}

/* @return whether the letter is drawn in a picture seen from @p from, up the direction @p up. */
static bool shows_letter(char letter, sc_vec3 from, sc_vec3 up)
{
    SC_OWN(sc_image_clear) sc_image with = {0}, without = {0};
    uint64_t hashes[2];
    SC_OWN(end_film) film f = {0};

    begin_film(&f, 0);
    add_tissues(&f, 1);
    f.overlays.orientation = SC_PLACE_BOTTOM_RIGHT;
    f.scene.camera =
        sc_camera_look(sc_vec3_scale(from, 400), (sc_vec3){0, 0, 0}, up, SC_ORTHOGRAPHIC, 90);
    letter_film(&f);
    with = draw(&f, 0, false, 255);
    blank_letter(&f, letter);
    without = draw(&f, 0, false, 255);
    hashes[0] = sc_image_hash(&with);
    hashes[1] = sc_image_hash(&without);
    return hashes[0] != hashes[1];
}

/* Seen from a side of the patient, the cube shows the letter of this side and no other. */
TEST(the_cube_shows_the_side_that_is_seen)
{
    static const char letters[] = "RLAPSI";
    static const sc_vec3 sides[] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                    {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};

    for (int side = 0; side < 6; side++) {
        const sc_vec3 up = side < 4 ? (sc_vec3){0, 0, 1} : (sc_vec3){0, 1, 0};

        for (int i = 0; i < 6; i++)
            assert_int_equal(shows_letter(letters[i], sides[side], up), i == side);
    }
    assert_true(shows_letter('R', sc_vec3_unit((sc_vec3){1, 1, 1}), (sc_vec3){0, 0, 1}));
    assert_true(shows_letter('A', sc_vec3_unit((sc_vec3){1, 1, 1}), (sc_vec3){0, 0, 1}));
    assert_true(shows_letter('S', sc_vec3_unit((sc_vec3){1, 1, 1}), (sc_vec3){0, 0, 1}));
    assert_false(shows_letter('L', sc_vec3_unit((sc_vec3){1, 1, 1}), (sc_vec3){0, 0, 1}));
}

TEST(without_orientation_there_is_no_cube)
{
    SC_OWN(end_film) film f = {0};
    int box[4];

    begin_film(&f, 0);
    add_tissues(&f, 1);
    f.volume.oriented = false;
    f.overlays.orientation = SC_PLACE_BOTTOM_RIGHT;
    assert_ok(sc_annotations_letter(&listening, &f.annotations, &f.lettering));
    assert_int_equal(said.warnings, 1);
    f.annotations.lettering = f.lettering;
    assert_int_equal(ink(&f, 0, box), 0);
}

/* A logo is scaled to its size with its transparency, and no further than its own pixels. */
TEST(a_logo_is_scaled_to_its_size)
{
    sc_image logo, image;
    SC_OWN(end_film) film f = {0};
    int red = 0, mixed = 0;

    begin_film(&f, 0);
    f.overlays.logo_place = SC_PLACE_BOTTOM_RIGHT;
    f.overlays.logo_percent = 10;
    strcpy(f.overlays.logo, "logo-of-test-annotate.png");
    assert_ok(sc_image_init_alpha(&quiet, 144, 72, true, &logo));
    for (int i = 0; i < 144 * 72; i++) { /* red on the left, clear on the right */
        const uint8_t pixel[4] = {255, 0, 0, 255}, clear[4] = {0};

        memcpy(logo.rgb + 4 * (size_t)i, i % 144 < 71 ? pixel : clear, 4);
    }
    assert_ok(sc_image_save_png(&quiet, &logo, f.overlays.logo, true));
    sc_image_clear(&logo);
    assert_true(sc_annotations_any(&f.annotations));
    letter_film(&f);
    assert_ok(sc_annotations_logo(&quiet, &f.annotations, &f.annotations.logo));
    assert_int_equal(f.annotations.logo.width_px, 72);
    assert_int_equal(f.annotations.logo.height_px, 36);
    image = draw(&f, 0, false, 255);
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            red += pixel(&image, x, y)[1] == 0;
            mixed += pixel(&image, x, y)[1] > 0 && pixel(&image, x, y)[1] < 255;
        }
    }
    assert_int_equal(red, 35 * 36); /* 71 columns are 35 and a half */
    assert_int_equal(mixed, 36);
    sc_image_clear(&image);
    sc_image_clear(&f.annotations.logo);
    f.overlays.logo_percent = 100;
    assert_ok(sc_annotations_logo(&quiet, &f.annotations, &f.annotations.logo));
    assert_int_equal(f.annotations.logo.height_px, 72);
    sc_image_clear(&f.annotations.logo);
    assert_int_equal(remove(f.overlays.logo), 0);
}

/* The text of a title card stands in the middle of the picture, and shrinks or is broken to fit. */
TEST(a_title_card_stands_in_the_middle)
{
    for (int kind = 0; kind < 3; kind++) {
        sc_card card = {.has_subtitle = kind > 0};
        int box[4];
        SC_OWN(end_film) film f = {0};

        begin_film(&f, 0);
        strcpy(card.title, kind == 2 ? "A title that is so long that it has to stand in several "
                                       "lines, one below the other, or become small"
                                     : "HEH");
        strcpy(card.subtitle, "HEHEHEHEH");
        f.annotations.card = &card;
        assert_true(sc_annotations_any(&f.annotations));
        letter_film(&f);
        assert_true(ink(&f, 0, box) > 0);
        assert_true(abs(box[0] + box[2] - WIDTH) <= 6);
        assert_true(abs(box[1] + box[3] - HEIGHT) <= 6);
        assert_true(box[0] > WIDTH / 20 && box[1] > HEIGHT / 20);
    }
}

TEST(a_title_card_that_cannot_fit_is_refused)
{
    sc_card card = {.where = "job.yaml:5"};
    film f;

    begin_film(&f, 0);
    memset(card.title, 'W', SC_CAPTION_BYTES - 1);
    f.annotations.card = &card;
    expect_refusal(&f, 1, "job.yaml:5: the text of the title card does not fit");
}

TEST(captions_that_cannot_fit_are_refused)
{
    film f;

    begin_film(&f, 2);
    memset(f.captions[0].text, 'W', SC_CAPTION_BYTES - 1);
    memset(f.captions[1].text, 'W', SC_CAPTION_BYTES - 1);
    expect_refusal(&f, 2, "job.yaml:8: a caption of 511 bytes does not fit");
    strcpy(f.overlays.font, "DejaVu Snas");
    strcpy(f.overlays.font_where, "job.yaml:3");
    expect_refusal(&f, 1,
                   "job.yaml:3: there is no font \"DejaVu Snas\" here; did you mean \"DejaVu S");
}

TEST(a_missing_character_is_named_once)
{
    sc_font_told told = {0};
    film f;

    begin_film(&f, 2); /* U+F0000 is for private use */
    strcpy(f.captions[0].text, "a \363\260\200\200 b \363\260\200\200");
    strcpy(f.captions[1].text, "\363\260\200\200");
    assert_ok(sc_annotations_letter(&listening, &f.annotations, &f.lettering));
    assert_int_equal(said.warnings, 1);
    assert_non_null(strstr(said.text, "(U+F0000)"));
    assert_null(strstr(strstr(said.text, "U+F0000") + 1, "U+F0000"));
    end_film(&f);
    /* Shots of one film: the second has one of its own. */
    for (int shot = 0; shot < 3; shot++) {
        begin_film(&f, 2);
        f.annotations.told = &told;
        strcpy(f.overlays.font, "DejaVu Sans");
        strcpy(f.captions[0].text, "\363\260\200\200");
        strcpy(f.captions[1].text, shot == 1 ? "\363\260\200\201" : "a");
        said = (heard){0};
        assert_ok(sc_annotations_letter(&listening, &f.annotations, &f.lettering));
        assert_int_equal(said.warnings, shot < 2);
        assert_int_equal(strstr(said.text, "(U+F0000)") != NULL, shot == 0);
        assert_int_equal(strstr(said.text, "(U+F0001)") != NULL, shot == 1);
        assert_null(strstr(said.text, "in the font of")); /* said holds the last message alone */
        end_film(&f);
    }
}

TEST(characters_that_cannot_be_set_are_known)
{
    assert_null(sc_font_refuses('a'));
    assert_null(sc_font_refuses(0xe9));
    assert_null(sc_font_refuses(0x301)); /* a combining mark */
    assert_null(sc_font_refuses(0x5fc3));
    assert_non_null(sc_font_refuses(7));
    assert_non_null(sc_font_refuses(0x202e)); /* turns the direction around */
    assert_non_null(strstr(sc_font_refuses(0x5d0), "right to left"));
    assert_non_null(strstr(sc_font_refuses(0x627), "right to left"));
    assert_non_null(strstr(sc_font_refuses(0x915), "letters join"));
}

TEST(time_codes_tell_frames_apart)
{
    char text[SC_TIME_CODE_BYTES];

    sc_time_code(0, 25, text);
    assert_string_equal(text, "0:00.00");
    sc_time_code(25 * 62 + 10, 25, text);
    assert_string_equal(text, "1:02.40");
    sc_time_code(14399, 240, text);
    assert_string_equal(text, "0:59.996");
    sc_time_code(1799, 30, text); /* 59.9667 */
    assert_string_equal(text, "0:59.97");
    sc_time_code(999999, 1, text);
    assert_string_equal(text, "16666:39.00");
}

RUN_TESTS(NULL, NULL)
