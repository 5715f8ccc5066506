/* SPDX-License-Identifier: BSD-3-Clause */
/* Every key of a job file, its type and range. */
#include "job_fields.h"

#include <limits.h>

const char *const sc_preset_names[] = {"ultrafast", "superfast", "veryfast", "faster",   "fast",
                                       "medium",    "slow",      "slower",   "veryslow", NULL};
static const char *const table_formats[] = {"auto", "slicer", "freesurfer", "itksnap", NULL};
static const char *const frame_kinds[] = {"none", "png", NULL};
static const char *const layouts[] = {"picture", "views", NULL};
static const char *const modes[] = {"standard", "paper", "paper-accelerated", NULL};
static const char *const surfaces[] = {"voxel", "smooth", NULL};
static const char *const antialiasings[] = {"adaptive", "full", NULL};
static const char *const thicknesses[] = {"tissue", "local", NULL};
static const char *const skips[] = {"none", "interior", "leap", NULL};
static const char *const caps[] = {"none", "solid", NULL};
static const char *const clip_modes[] = {"keep", "cut", NULL};
static const char *const partitions[] = {"auto", "frames", "tiles", NULL};
static const char *const encodes[] = {"auto", "rank0", "segments", NULL};

static const sc_field output_fields[] = {
    {.name = "directory",
     .type = &sc_type_text,
     .offset = offsetof(sc_output, directory),
     .high = SC_PATH_BYTES,
     .aside = true},
    {.name = "size",
     .type = &sc_type_size,
     .offset = offsetof(sc_output, size_px),
     .low = 16,
     .high = 16384},
    {.name = "fps",
     .type = &sc_type_int,
     .offset = offsetof(sc_output, fps),
     .low = 1,
     .high = 240},
    {.name = "video",
     .type = &sc_type_text,
     .offset = offsetof(sc_output, video),
     .high = SC_PATH_BYTES,
     .aside = true},
    {.name = "frames",
     .type = &sc_type_choice,
     .offset = offsetof(sc_output, frames),
     .choices = frame_kinds,
     .aside = true},
    {.name = "layout",
     .type = &sc_type_choice,
     .offset = offsetof(sc_output, layout),
     .choices = layouts},
    {.name = "crf", .type = &sc_type_int, .offset = offsetof(sc_output, crf), .low = 0, .high = 51},
    {.name = "preset",
     .type = &sc_type_choice,
     .offset = offsetof(sc_output, preset),
     .choices = sc_preset_names},
    {0}};

static const sc_field render_fields[] = {{.name = "mode",
                                          .type = &sc_type_choice,
                                          .offset = offsetof(sc_render_options, mode),
                                          .choices = modes},
                                         {.name = "surface",
                                          .type = &sc_type_choice,
                                          .offset = offsetof(sc_render_options, surface),
                                          .choices = surfaces},
                                         {.name = "smooth",
                                          .type = &sc_type_real,
                                          .offset = offsetof(sc_render_options, smooth),
                                          .low = 0,
                                          .high = SC_SMOOTH_MAX},
                                         {.name = "skip",
                                          .type = &sc_type_choice,
                                          .offset = offsetof(sc_render_options, skip),
                                          .choices = skips,
                                          .aside = true},
                                         {.name = "cpu",
                                          .type = &sc_type_choice,
                                          .offset = offsetof(sc_render_options, cpu),
                                          .choices = sc_cpu_names,
                                          .aside = true},
                                         {.name = "background",
                                          .type = &sc_type_color,
                                          .offset = offsetof(sc_render_options, background)},
                                         {.name = "caps",
                                          .type = &sc_type_choice,
                                          .offset = offsetof(sc_render_options, caps),
                                          .choices = caps},
                                         {.name = "cap_outline",
                                          .type = &sc_type_real,
                                          .offset = offsetof(sc_render_options, cap_outline),
                                          .low = 0,
                                          .high = 1},
                                         {.name = "samples",
                                          .type = &sc_type_int,
                                          .offset = offsetof(sc_render_options, samples),
                                          .low = 1,
                                          .high = SC_SAMPLES_MAX},
                                         {.name = "antialiasing",
                                          .type = &sc_type_choice,
                                          .offset = offsetof(sc_render_options, antialiasing),
                                          .choices = antialiasings},
                                         {.name = "thickness",
                                          .type = &sc_type_choice,
                                          .offset = offsetof(sc_render_options, thickness),
                                          .choices = thicknesses},
                                         {.name = "step",
                                          .type = &sc_type_real,
                                          .offset = offsetof(sc_render_options, step_voxels),
                                          .low = 0.05,
                                          .high = 4},
                                         {0}};

/* NOLINTBEGIN(bugprone-macro-parentheses): the argument is a name */
#define LIGHT_FIELD(key, highest)                                                                  \
    {                                                                                              \
        .name = #key, .type = &sc_type_real, .offset = offsetof(sc_lighting, key), .low = 0,       \
        .high = (highest)                                                                          \
    }

/* NOLINTEND(bugprone-macro-parentheses) */

static const sc_field light_fields[] = {
    {.name = "flat", .type = &sc_type_bool, .offset = offsetof(sc_lighting, flat)},
    LIGHT_FIELD(ambient, 2),
    LIGHT_FIELD(key, 2),
    LIGHT_FIELD(fill, 2),
    LIGHT_FIELD(head, 2),
    LIGHT_FIELD(occlusion, 1),
    {.name = "shadows", .type = &sc_type_bool, .offset = offsetof(sc_lighting, shadows)},
    LIGHT_FIELD(edges, 1),
    LIGHT_FIELD(depth_cue, 1),
    {0}};

static const sc_field camera_fields[] = {
    {.name = "orbit", .type = &sc_type_orbit, .offset = 0},
    {.name = "fixed", .type = &sc_type_fixed, .offset = 0},
    {.name = "projection",
     .type = &sc_type_choice,
     .offset = offsetof(sc_orbit, projection),
     .choices = sc_projection_names},
    {.name = "zoom", .type = &sc_type_zoom, .offset = offsetof(sc_orbit, zoom)},
    {0}};

/* Of sc_job, like the whole: a clip item also names tissues. */
static const sc_field animation_fields[] = {
    {.name = "frames",
     .type = &sc_type_int,
     .offset = offsetof(sc_job, animation.frames),
     .low = 1,
     .high = 1000000},
    {.name = "camera",
     .type = &sc_type_map,
     .offset = offsetof(sc_job, animation.camera),
     .fields = camera_fields},
    {.name = "clip_mode",
     .type = &sc_type_choice,
     .offset = offsetof(sc_job, animation.clip_mode),
     .choices = clip_modes},
    {.name = "clip", .type = &sc_type_clip, .offset = 0},
    {.name = "slices", .type = &sc_type_slices, .offset = offsetof(sc_job, animation.slices)},
    {0}};

static const sc_field farm_fields[] = {
    {.name = "partition",
     .type = &sc_type_choice,
     .offset = offsetof(sc_farm_options, partition),
     .choices = partitions},
    {.name = "encode",
     .type = &sc_type_choice,
     .offset = offsetof(sc_farm_options, encode),
     .choices = encodes},
    {.name = "share", .type = &sc_type_bool, .offset = offsetof(sc_farm_options, share)},
    {.name = "tile",
     .type = &sc_type_int,
     .offset = offsetof(sc_farm_options, tile_px),
     .low = 8,
     .high = 256},
    {0}};

const sc_field sc_job_fields[] = {
    {.name = "volume",
     .type = &sc_type_text,
     .offset = offsetof(sc_job, volume),
     .high = SC_PATH_BYTES,
     .aside = true},
    {.name = "labels",
     .type = &sc_type_text,
     .offset = offsetof(sc_job, labels),
     .high = SC_PATH_BYTES,
     .aside = true},
    {.name = "labels_format",
     .type = &sc_type_choice,
     .offset = offsetof(sc_job, labels_format),
     .choices = table_formats,
     .aside = true},
    {.name = "output",
     .type = &sc_type_map,
     .offset = offsetof(sc_job, output),
     .fields = output_fields},
    {.name = "render",
     .type = &sc_type_map,
     .offset = offsetof(sc_job, render),
     .fields = render_fields},
    {.name = "light",
     .type = &sc_type_map,
     .offset = offsetof(sc_job, light),
     .fields = light_fields},
    {.name = "tissues", .type = &sc_type_tissues, .offset = 0},
    {.name = "animation", .type = &sc_type_map, .offset = 0, .fields = animation_fields},
    {.name = "farm",
     .type = &sc_type_map,
     .offset = offsetof(sc_job, farm),
     .fields = farm_fields,
     .aside = true},
    {0}};

const char *sc_job_preset(const sc_job *job)
{
    return sc_preset_names[job->output.preset];
}
