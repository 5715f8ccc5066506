/* SPDX-License-Identifier: BSD-3-Clause */
/* Every key of a job file outside the animation and the tissues: one row each. The order is that of
 * the job as resolved and of the documents. */
#include "key.h"
#include "segcast/job.h"
#include "segcast/video.h"

#define PICTURE_COMMANDS "orbit still"

/* ---- output ---- */

static const sc_choice frame_files[] = {
    {"none", SC_FRAMES_NONE}, {"png", SC_FRAMES_PNG}, {NULL, 0}};
static const sc_choice codecs[] = {
    {"auto", SC_CODEC_AUTO}, {"h264", SC_CODEC_H264}, {"h265", SC_CODEC_H265},
    {"av1", SC_CODEC_AV1},   {"vp9", SC_CODEC_VP9},   {"prores", SC_CODEC_PRORES},
    {"webp", SC_CODEC_WEBP}, {"gif", SC_CODEC_GIF},   {NULL, 0}};
/* The presets of x264 and x265. The other codecs have none and ignore the choice. */
static const char *const presets[] = {"ultrafast", "superfast", "veryfast", "faster",   "fast",
                                      "medium",    "slow",      "slower",   "veryslow", NULL};

#define OUTPUT(member) offsetof(sc_output, member)

static const sc_key output_keys[] = {
    {"directory", &sc_type_text, OUTPUT(directory), "segcast-out",
     .help = "directory for everything that the job makes; relative to the job file",
     .bytes = SC_PATH_BYTES, .scope.outside_identity = true},
    {"size", &sc_type_size, OUTPUT(size_px), "[1280, 720]",
     .help = "width and height of the picture, also as WxH or by name: 360p, 480p, 720p, 1080p, "
             "1440p, 4k, 8k, square (1080x1080) or vertical, portrait (1080x1920)",
     .low = 16, .high = 16384, .unit = "pixels",
     .option = &(const sc_key_option){"size", "WxH", PICTURE_COMMANDS}},
    {"fps", &sc_type_int, OUTPUT(fps), "30", .help = "frames per second of the video", .low = 1,
     .high = 240, .option = &(const sc_key_option){"fps", "N", "orbit"}},
    {"video", &sc_type_text, OUTPUT(video), "video.mp4",
     .help = "name of the video: ending in .mp4 or .mkv (H.264), .webm (VP9; also transparent), "
             ".mov (ProRes 4444, for editing; also transparent) or .webp (a picture that moves, "
             "for slides and web pages; also transparent) or .gif; or none",
     .bytes = SC_PATH_BYTES, .scope.outside_identity = true},
    {"codec", &sc_type_choice, OUTPUT(codec), "auto",
     .help = "what encodes the video; auto: what is usual for the extension of its name; .mp4 can "
             "also hold h265 and av1, .mkv these and vp9, .webm av1, and .mov h264 and h265",
     .choices = codecs},
    {"title", &sc_type_text, OUTPUT(title), "\"\"",
     .help = "title of the film, in the metadata of the video",
     .bytes = sizeof(((sc_output *)0)->title)},
    {"author", &sc_type_text, OUTPUT(author), "\"\"",
     .help = "who made the film, in the metadata of the video, beside the hashes of job and "
             "volume; behind it perhaps the licence of the film, as in \"A. Author; CC-BY-4.0\"",
     .bytes = sizeof(((sc_output *)0)->author)},
    {"frames", &sc_type_choice, OUTPUT(frames), "none",
     .help = "png: every frame also as a file frames/000000.png", .choices = frame_files,
     .scope.outside_identity = true},
    {"crf", &sc_type_int, OUTPUT(crf), "18",
     .help = "quality of the encoder: constant rate factor, smaller is better and larger; 0 not "
             "for H.264 and H.265; ProRes has always the same; of WebP 0 loses nothing, and 18 is "
             "its quality 88",
     .low = 0, .high = 51},
    {"preset", &sc_type_choice, OUTPUT(preset), "medium",
     .help = "speed of the encoders of H.264 and H.265: slower makes smaller files",
     .words = presets},
    {0}};

/* ---- render ---- */

static const sc_choice surfaces[] = {
    {"voxel", SC_SURFACE_VOXEL}, {"smooth", SC_SURFACE_SMOOTH}, {NULL, 0}};
static const sc_choice skips[] = {{"none", SC_SKIP_NONE},
                                  {"interior", SC_SKIP_INTERIOR},
                                  {"octree", SC_SKIP_OCTREE},
                                  {"proximity", SC_SKIP_PROXIMITY},
                                  {"chessboard", SC_SKIP_CHESSBOARD},
                                  {"leap", SC_SKIP_LEAP},
                                  {NULL, 0}};
static const sc_choice qualities[] = {
    {"draft", SC_QUALITY_DRAFT}, {"film", SC_QUALITY_FILM}, {"still", SC_QUALITY_STILL}, {NULL, 0}};
static const sc_choice auto_opacities[] = {{"measured", SC_OPACITY_MEASURED},
                                           {"paper", SC_OPACITY_PAPER},
                                           {"local", SC_OPACITY_MEASURED + SC_OPACITY_LOCAL},
                                           {"local-paper", SC_OPACITY_PAPER + SC_OPACITY_LOCAL},
                                           {NULL, 0}};
static const sc_choice stages[] = {
    {"none", SC_GROUND_NONE}, {"floor", SC_GROUND_FLOOR}, {"cove", SC_GROUND_COVE}, {NULL, 0}};
static const sc_choice caps[] = {{"none", SC_CAPS_NONE}, {"solid", SC_CAPS_SOLID}, {NULL, 0}};

#define RENDER(member) offsetof(sc_render_options, member)

static const sc_key render_keys[] = {
    {"surface", &sc_type_choice, RENDER(surface), "smooth",
     .help = "smooth: smooth surfaces, placed more finely than voxels; voxel: those of the paper, "
             "with the corners of voxels",
     .choices = surfaces, .scope.of_film = true},
    {"smooth", &sc_type_smooth, RENDER(smooth), "auto",
     .help = "strength of the smoothing of surfaces, from 0 (crisp), by which the lengths of its "
             "filter are multiplied; one for all, or three along the axes of the volume; auto: 1, "
             "on the grid on which the volume was drawn: without copied voxels, with layers "
             "between thick slices, and slices that jump moved back",
     .low = 0, .high = SC_SMOOTH_MAX,
     .option = &(const sc_key_option){"smooth", "S", PICTURE_COMMANDS}, .scope.of_film = true},
    {"skip", &sc_type_choice, RENDER(skip), "leap",
     .help = "how empty space is skipped: leap (fast, with little memory), none or interior (the "
             "paper's plain and accelerated methods), octree, proximity or chessboard (methods of "
             "others, to compare with); same pictures",
     .choices = skips, .scope.outside_identity = true, .scope.of_film = true},
    {"cpu", &sc_type_choice, RENDER(cpu), "auto",
     .help = "instruction set of the program that draws: auto (the best that the processor has), "
             "avx512, avx2, sse4, neon, or c for plain C; same pictures",
     .words = sc_cpu_names, .scope.outside_identity = true,
     .option = &(const sc_key_option){"cpu", "NAME", "render check plan still orbit"},
     .scope.of_film = true},
    {"early_termination", &sc_type_bool, RENDER(early_termination), "true",
     .help = "rays end behind what is opaque; false: they go on, to compare with; same pictures",
     .scope.outside_identity = true},
    {"background", &sc_type_background, RENDER(background), "auto",
     .track = offsetof(sc_background, track),
     .help = "colour behind the tissues; auto: white, or dark slate where much of what is seen is "
             "nearly white; none: pictures are transparent (PNG with alpha, .webm, .webp, .mov)"},
    {"caps", &sc_type_choice, RENDER(caps), "solid",
     .help = "faces where clip planes cut tissues: solid, in the colour of the tissue; none: "
             "tissues are hollow there",
     .choices = caps},
    {"cap_outline", &sc_type_real, RENDER(cap_outline), "0",
     .help = "width of the lines between tissues on cut faces", .low = 0, .high = 1,
     .unit = "voxels"},
    {"stage", &sc_type_choice, RENDER(stage), "none",
     .help =
         "floor: below the tissues lies a floor, in the colour of the background, on which "
         "they throw shadows; clip planes do not cut it; with light.method global or path; cove: "
         "it rises behind the body in a curve",
     .choices = stages},
    {"quality", &sc_type_choice, RENDER(quality), "film",
     .help = "draft: one ray for a pixel; film: 5 where neighbouring pixels differ; still: 8 in "
             "all of them. Where they show what is not in focus, or the paths of light: 8, 128, "
             "1,024",
     .choices = qualities, .option = &(const sc_key_option){"quality", "HOW", PICTURE_COMMANDS}},
    {"auto_opacity", &sc_type_choice, RENDER(auto_opacity), "measured",
     .help = "what opacity: auto is. measured: by thickness in mm, and tissues that enclose the "
             "others nearly transparent; paper: from 0.3 for the thinnest tissue to 0.9 for the "
             "thickest; local, local-paper: the same by the thickness at each point, instead of "
             "that of the whole tissue",
     .choices = auto_opacities},
    {"step", &sc_type_real, RENDER(step_voxels), "0.5",
     .help = "distance of samples on a ray; only for surface: voxel", .low = 0.05, .high = 4,
     .unit = "voxels"},
    {0}};

/* ---- light ---- */

#define LIGHT(member) offsetof(sc_light_options, member)
/* A strength of the light, which may have key frames. */
#define STRENGTH(member)                                                                           \
    &sc_type_tracked, LIGHT(constant.member), .track = LIGHT(tracks.member) - LIGHT(constant.member)

static const sc_choice light_methods[] = {{"plain", SC_LIGHT_PLAIN},
                                          {"global", SC_LIGHT_GLOBAL},
                                          {"path", SC_LIGHT_PATH},
                                          {"flat", SC_LIGHT_FLAT},
                                          {NULL, 0}};

static const sc_key light_keys[] = {
    {"method", &sc_type_choice, LIGHT(constant.method), "plain",
     .help =
         "plain: lamps that move with the camera, and cavities darkened by how much around them is "
         "filled; global: a soft lamp and a sky that stand to the body, whose light also comes by "
         "way of other tissues and takes their colours along; path: the same light to the last "
         "detail, by following it anew in each frame, which takes a thousand times as long; flat: "
         "no light at all, plain colours",
     .choices = light_methods},
    {"ambient", STRENGTH(ambient), .fallback = "0.12",
     .help = "strength of the light from everywhere; with method: global from the sky", .low = 0,
     .high = 2},
    {"environment", &sc_type_environment, LIGHT(environment), NULL,
     .help = "a Radiance file (.hdr), a picture of all directions in place of the sky, twice as "
             "wide as high, whose middle stands before the body; for method: global and path. Its "
             "brightness is that of the sky, whatever its exposure. {room.hdr: 90}: it is turned "
             "by 90 degrees about the axis of the body, to its right",
     .bytes = SC_PATH_BYTES, .low = -360, .high = 360, .scope.outside_identity = true,
     .without = "the sky"},
    {"lamp", &sc_type_lamp, LIGHT(constant.lamp), NULL,
     .help = "a rectangular lamp in place of the disc, for method: global and path, as far away as "
             "the sky: where its middle stands, counted as camera.orbit.angle and elevation, and "
             "how wide and high it is seen. camera: it moves with the camera, is behind it at "
             "angle 0 and to its right at 90; with method: global light is then gathered anew "
             "wherever the camera turns",
     .high = 150, .unit = "degrees", .given = SC_GIVEN(sc_lighting, lamp.is_given),
     .without = "a disc before the body, high and to its right"},
    {"key", STRENGTH(key), .fallback = "0.76",
     .help = "strength of the light from above the left shoulder of the viewer; with method: "
             "global that of the lamp",
     .low = 0, .high = 2},
    {"head", STRENGTH(head), .fallback = "0.3", .help = "strength of the light from the eye",
     .low = 0, .high = 2},
    {"occlusion", STRENGTH(occlusion), .fallback = "1", .help = "how dark cavities are", .low = 0,
     .high = 1},
    {"shadows", &sc_type_tracked_strength, LIGHT(constant.shadows), "false",
     .track = LIGHT(tracks.shadows) - LIGHT(constant.shadows),
     .help = "soft shadows of the key light: true, or how dark they are", .low = 0, .high = 1},
    {"edges", STRENGTH(edges), .fallback = "0.5",
     .help = "how much opacity grows where a surface is seen from the side", .low = 0, .high = 1},
    {"depth_cue", STRENGTH(depth_cue), .fallback = "0",
     .help = "how much the far end fades into the background", .low = 0, .high = 1},
    {0}};

/* ---- animation ---- */

static const sc_choice clip_modes[] = {{"keep", SC_CLIP_KEEP}, {"cut", SC_CLIP_CUT}, {NULL, 0}};

/* Offsets into sc_job, as in the whole file: a clip entry also names tissues. */
static const sc_key animation_keys[] = {
    {"frames", &sc_type_frames, 0, "180",
     .help = "length of the whole animation: a number of frames, or a time such as 10s, 1.5 min or "
             "0:10, which makes so many seconds times output.fps",
     .low = 1, .high = SC_JOB_FRAMES_MAX,
     .option = &(const sc_key_option){"frames", "N|TIME", "orbit"}},
    {"camera", &sc_type_map, offsetof(sc_job, animation.camera), NULL,
     .help = "where the picture is seen from", .keys = sc_camera_keys},
    {"clip_mode", &sc_type_choice, offsetof(sc_job, animation.clip_mode), "keep",
     .help = "keep what all planes keep, or cut away only what every plane removes (a wedge)",
     .choices = clip_modes},
    {"clip", &sc_type_clip, 0, NULL, .help = "clip planes", .keys = sc_clip_keys,
     .without = "none"},
    {"verbs", &sc_type_verbs, 0, NULL,
     .help = "what happens to tissues, one verb after the other or at the same time",
     .keys = sc_verb_keys, .without = "none", .given = SC_GIVEN(sc_job, given.verbs)},
    {"slices", &sc_type_slices, offsetof(sc_job, animation.slices), NULL,
     .help =
         "the three regular slices beside the picture, and where they cross: a point in RAS mm, or "
         "how far they are on the way through what is visible; through: they go all of that way",
     .low = -1e6, .high = 1e6, .given = SC_GIVEN(sc_job, animation.slices.is_given),
     .without = "none", .option = &(const sc_key_option){"point", "R,A,S", "still"}},
    {0}};

/* ---- farm ---- */

static const sc_choice partitions[] = {{"auto", SC_PARTITION_AUTO},
                                       {"frames", SC_PARTITION_FRAMES},
                                       {"tiles", SC_PARTITION_TILES},
                                       {NULL, 0}};
static const sc_choice encodes[] = {{"auto", SC_ENCODE_AUTO},
                                    {"rank0", SC_ENCODE_ROOT},
                                    {"segments", SC_ENCODE_SEGMENTS},
                                    {"gather", SC_ENCODE_GATHER},
                                    {NULL, 0}};

#define FARM(member) offsetof(sc_farm_options, member)

static const sc_key farm_keys[] = {
    {"partition", &sc_type_choice, FARM(partition), "auto",
     .help = "frames: each frame is drawn by one rank; tiles: each by all ranks; auto: as frames, "
             "but the last frames, and those so large that rank 0 holds only a few, are drawn by "
             "several ranks",
     .choices = partitions},
    {"encode", &sc_type_choice, FARM(encode), "auto",
     .help = "who encodes the video. rank0: rank 0; segments: each rank draws and encodes a second "
             "of video at a time, and rank 0 joins them; gather: some ranks encode seconds whose "
             "frames all ranks draw; auto: segments from four ranks on if there are three seconds "
             "for each rank, gather from 64 ranks on if not (segments does the same then), else "
             "rank0; same bytes",
     .choices = encodes},
    {"share", &sc_type_bool, FARM(share), "true",
     .help = "ranks on the node of rank 0 draw into its memory where /dev/shm has room; false: "
             "they send their pixels"},
    {"tile", &sc_type_int, FARM(tile_px), "32", .help = "side of the squares that threads draw",
     .low = 8, .high = 256, .unit = "pixels"},
    {0}};

/* ---- the whole file ---- */

static const sc_choice table_formats[] = {{"auto", SC_TABLE_AUTO},
                                          {"slicer", SC_TABLE_SLICER},
                                          {"freesurfer", SC_TABLE_FREESURFER},
                                          {"itksnap", SC_TABLE_ITKSNAP},
                                          {"xml", SC_TABLE_XML},
                                          {"csv", SC_TABLE_DELIMITED},
                                          {"json", SC_TABLE_JSON},
                                          {"names", SC_TABLE_NAMES},
                                          {"workbench", SC_TABLE_WORKBENCH},
                                          {NULL, 0}};

static const sc_choice appearances[] = {{"table", SC_APPEARANCE_TABLE},
                                        {"anatomy", SC_APPEARANCE_ANATOMY},
                                        {"distinct", SC_APPEARANCE_DISTINCT},
                                        {NULL, 0}};

static const sc_choice look_names[] = {{"plain", SC_LOOK_PLAIN},         {"studio", SC_LOOK_STUDIO},
                                       {"cinematic", SC_LOOK_CINEMATIC}, {"atlas", SC_LOOK_ATLAS},
                                       {"xray", SC_LOOK_XRAY},           {NULL, 0}};
#define LOOK_ROW                                                                                   \
    "look", &sc_type_choice, offsetof(sc_job, look), "plain",                                      \
        .help = "a set of values for the keys of light, background and tissues that the job does " \
                "not give itself. plain: those that these lists name; studio: a large soft lamp "  \
                "on white; cinematic: the same by night, with deep shadows; atlas: even light, "   \
                "true colours, lines between tissues on cut faces; xray: veils with dense "        \
                "outlines. orbit and still draw a volume in studio",                               \
        .choices = look_names, .scope.outside_identity = true

#define SHOT(member) offsetof(sc_shot, member)

/* The keys of a shot. Those of the job have the same place in sc_shot as in sc_job, which it begins
 * with; listings leave them out, because the file has them all. */
#define OF_JOB(key, kind, place, table, is_given)                                                  \
    {                                                                                              \
        key, &sc_type_##kind, place, NULL, .help = "as " key " of the file, of this shot",         \
                                           .keys = (table), .scope.of_job = true,                  \
                                           .given = (is_given)                                     \
    }

const sc_key sc_shot_keys[] = {
    {"name", &sc_type_text, SHOT(name), "\"\"",
     .help = "name of the shot; each shot that has one begins a chapter of the video",
     .bytes = sizeof(((sc_shot *)0)->name), .without = "none"},
    {"transition", &sc_type_transition, SHOT(transition), "cut",
     .help = "how the shot follows the one before: cut; cross_fade 1s: the one before is replaced "
             "step by step, in linear light, and both overlap for this long, by which the film is "
             "shorter; or fade 1s: half of this time the one before fades to the background, and "
             "in the other half the shot appears from its own (the first shot only appears)"},
    {"fade_out", &sc_type_length, SHOT(fade_out), NULL, .given = SC_GIVEN(sc_shot, has_fade_out),
     .without = "it does not",
     .help = "how long it fades to the background at its end; for the last shot, and those before "
             "a cut"},
    {"card", &sc_type_card, SHOT(card), NULL,
     .help = "the shot is a title card: a text in the middle of the background, or [title, "
             "subtitle], and no tissues; \\n in double quotes begins a new line",
     .given = SC_GIVEN(sc_shot, has_card), .without = "tissues are shown"},
    {LOOK_ROW, .scope.of_job = true},
    OF_JOB("color_by", flow_map, offsetof(sc_job, color_by), sc_color_by_keys,
           SC_GIVEN(sc_job, given.color_by)),
    OF_JOB("image", map, offsetof(sc_job, image), sc_image_keys, SC_GIVEN(sc_job, given.image)),
    OF_JOB("render", map, offsetof(sc_job, render), render_keys, 0),
    OF_JOB("light", map, offsetof(sc_job, light), light_keys, 0),
    OF_JOB("tissues", tissues, 0, sc_tissue_keys, 0),
    OF_JOB("animation", map, 0, animation_keys, 0),
    OF_JOB("overlays", map, 0, sc_overlays_keys, 0),
    {0}};

const sc_key sc_job_keys[] = {
    {"volume", &sc_type_volume, 0, NULL,
     .help = "the labels: a path, or a map with the path and what is changed of the volume",
     .keys = sc_volume_keys, .shorthand = {"path", true}, .scope.outside_identity = true,
     .required = true, .scope.of_film = true},
    {"labels", &sc_type_text, offsetof(sc_job, volume.labels), NULL,
     .help = "label table with the names and colours of the tissues, or a volume that has one in "
             "its header",
     .bytes = SC_PATH_BYTES, .scope.outside_identity = true,
     .without = "names and colours of the volume's file",
     .option = &(const sc_key_option){"labels", "FILE", LABEL_COMMANDS}, .scope.of_film = true},
    {"labels_format", &sc_type_choice, offsetof(sc_job, volume.labels_format), "auto",
     .help = "format of the label table: slicer, freesurfer, itksnap, xml, csv, json, workbench or "
             "names (a number and a name a line); auto: by its content",
     .choices = table_formats, .scope.outside_identity = true,
     .option = &(const sc_key_option){"labels-format", "NAME", LABEL_COMMANDS},
     .scope.of_film = true},
    {"overlap", &sc_type_overlap, 0, "smaller",
     .help =
         "which tissue has a voxel that several masks of a directory, or segments of a .seg.nrrd "
         "or DICOM SEG, cover; smaller: the one with fewer voxels, order: the last of them, "
         "[tumour, \"*artery\"]: the one that this list names first, or else the smaller",
     .scope.outside_identity = true,
     .option = &(const sc_key_option){"overlap", "NAME", LABEL_COMMANDS}, .scope.of_film = true},
    {"appearance", &sc_type_choice, offsetof(sc_job, volume.appearance), "table",
     .help = "colours of the tissues. table: those of the label table; a tissue without one there "
             "has that of anatomy, or else a distinct one. anatomy: those that anatomists expect, "
             "where the name of a tissue is known, also instead of the table's. distinct: colours "
             "that differ as much as possible",
     .choices = appearances,
     .option =
         &(const sc_key_option){"appearance", "NAME", LABEL_COMMANDS " render check plan study"},
     .scope.of_film = true},
    {LOOK_ROW,
     .option = &(const sc_key_option){"look", "NAME", LABEL_COMMANDS " render check plan study"}},
    {"cine", &sc_type_flow_map, offsetof(sc_job, cine), NULL,
     .help =
         "the volume is a series, a list of files, a pattern such as heart_*.nrrd, or a file that "
         "holds several volumes (4-D): phases of a beat, which follow each other in the film",
     .keys = sc_cine_keys, .given = SC_GIVEN(sc_job, given.cine), .scope.of_film = true,
     .without = "the volume is one"},
    {"color_by", &sc_type_flow_map, offsetof(sc_job, color_by), NULL,
     .help = "colours of the tissues by values of a table, or by what is measured; colours under "
             "tissues go before",
     .keys = sc_color_by_keys, .given = SC_GIVEN(sc_job, given.color_by),
     .without = "colours as appearance says"},
    {"compare", &sc_type_map, offsetof(sc_job, compare), NULL,
     .help =
         "other volumes that are shown beside this one, in the same way and from the same camera",
     .keys = sc_compare_keys, .given = SC_GIVEN(sc_job, given.compare), .scope.of_film = true,
     .without = "one volume"},
    {"image", &sc_type_map, offsetof(sc_job, image), NULL,
     .help = "a grey volume (CT, MR) that is seen on cut faces, on slices and behind the tissues",
     .keys = sc_image_keys, .given = SC_GIVEN(sc_job, given.image), .without = "none"},
    {"output", &sc_type_map, offsetof(sc_job, output), NULL, .help = "what is made, and where",
     .keys = output_keys, .scope.of_film = true},
    {"render", &sc_type_map, offsetof(sc_job, render), NULL, .help = "how a picture is drawn",
     .keys = render_keys},
    {"light", &sc_type_map, offsetof(sc_job, light), NULL,
     .help = "strengths of lights, and what light does to the picture", .keys = light_keys},
    {"tissues", &sc_type_tissues, 0, NULL,
     .help = "how tissues look: by name, glob or label number; later entries win",
     .keys = sc_tissue_keys, .without = "all as the label table says"},
    {"animation", &sc_type_map, 0, NULL, .help = "what moves", .keys = animation_keys},
    {"overlays", &sc_type_map, 0, NULL, .help = "what is written onto the pictures",
     .keys = sc_overlays_keys},
    {"shots", &sc_type_shots, 0, NULL,
     .help = "the film as a list of shots, one after the other: each is a map of keys of its own, "
             "and of look, color_by, image, render, light, tissues, animation and overlays as in "
             "the file, which are merged over those outside of the list",
     .keys = sc_shot_keys, .given = SC_GIVEN(sc_job, given.shots), .scope.of_film = true,
     .without = "one shot"},
    {"farm", &sc_type_map, offsetof(sc_job, farm), NULL,
     .help = "how ranks share the work; same pictures", .keys = farm_keys,
     .scope.outside_identity = true, .scope.of_film = true},
    {0}};

const char *sc_job_encode_word(int encode)
{
    return encodes[encode].word;
}

const char *sc_job_preset(const sc_job *job)
{
    return presets[job->output.preset];
}
