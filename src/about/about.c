/* What a header says. */
#include "about/about.h"
#include "core/memory.h"
#include "core/units.h"
#include "grid/info_text.h"
#include "io/channel_colors.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define TILT_LEAST 0.05 /* degrees; less is the rounding of numbers in headers */

static const char *const meaning_names[] = {"scalar", "RGB", "RGBA", "vector", "label"};
static const char *const space_names[] = {"plain", "RAS"};

/* Place ----------------------------------------------------------------------------------------------------------- */

static void tell_place_keys(vv_answer *a, const vv_grid *grid)
{
    const double dims[3] = {(double)grid->dims[0], (double)grid->dims[1], (double)grid->dims[2]};
    const double spacing[3] = {vv_grid_spacing(grid, 0), vv_grid_spacing(grid, 1), vv_grid_spacing(grid, 2)};
    const vv_affine *map = &grid->index_to_world;
    const double origin[3] = {map->origin.x, map->origin.y, map->origin.z};
    vvi_tell_numbers(a, "dims", dims, 3);
    vvi_tell_numbers(a, "spacing", spacing, 3);
    vvi_tell_numbers(a, "origin", origin, 3);
    vvi_tell_open(a, "directions", "[");
    for (int i = 0; i < 3; i++) {
        const double unit[3] = {map->axis[i].x / spacing[i], map->axis[i].y / spacing[i], map->axis[i].z / spacing[i]};
        vvi_tell_numbers(a, NULL, unit, 3);
    }
    vvi_tell_close(a, "]");
    vvi_tell_text(a, "unit", grid->unit);
    vvi_tell_text(a, "space", space_names[grid->space]);
}

/* The largest angle between an axis of the grid and the axis of the world that it runs along, in degrees. */
static double tilt_of(const vv_grid *grid)
{
    double most = 0;
    for (int i = 0; i < 3; i++) {
        const vv_vec3 a = grid->index_to_world.axis[i];
        const double along = fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z)));
        const double beside = sqrt(fmax(0, a.x * a.x + a.y * a.y + a.z * a.z - along * along));
        most = fmax(most, atan2(beside, along) * 180 / 3.14159265358979323846);
    }
    return most;
}

static void tell_tilt(vv_answer *a, const vv_grid *grid)
{
    const double tilt = tilt_of(grid);
    vvi_text rows = {0};
    const vv_affine *m = &grid->index_to_world;
    const double row[3][4] = {{m->axis[0].x, m->axis[1].x, m->axis[2].x, m->origin.x},
                              {m->axis[0].y, m->axis[1].y, m->axis[2].y, m->origin.y},
                              {m->axis[0].z, m->axis[1].z, m->axis[2].z, m->origin.z}};
    if (!(tilt >= TILT_LEAST))
        return;
    vvi_tell_line(a, "tilt", "%.2f degrees from the axes of the world", tilt);
    for (int r = 0; r < 3; r++) /* in columns, which a line would close up */
        vvi_text_printf(&rows, "%-13s%11.6g %11.6g %11.6g  %11.6g\n", r ? "" : "to world", row[r][0] + 0.0,
                        row[r][1] + 0.0, row[r][2] + 0.0, row[r][3] + 0.0);
    vvi_tell_block(a, &rows);
}

static void tell_place(vv_answer *a, const vv_grid *grid)
{
    char letters[16];
    const double spacing[3] = {vv_grid_spacing(grid, 0), vv_grid_spacing(grid, 1), vv_grid_spacing(grid, 2)};
    const bool measured = strcmp(grid->unit, "voxels") != 0;
    const char *unit = measured ? grid->unit : "(the file gives no spacing)";
    const vv_vec3 o = grid->index_to_world.origin;
    vv_grid_orientation(letters, grid);
    vvi_tell_line(a, "spacing", "%g x %g x %g %s", spacing[0], spacing[1], spacing[2], unit);
    vvi_tell_line(a, "size", "%g x %g x %g %s", spacing[0] * (double)grid->dims[0], spacing[1] * (double)grid->dims[1],
                  spacing[2] * (double)grid->dims[2], grid->unit);
    if (grid->space == VV_SPACE_RAS)
        vvi_tell_line(a, "orientation", "%s (letter = direction of increase along x, y, z)", letters);
    else
        vvi_tell_line(a, "orientation", "%s (the world axis that x, y, z run along)", letters);
    vvi_tell_line(a, "origin", "%g, %g, %g %s", o.x + 0.0, o.y + 0.0, o.z + 0.0, grid->unit);
    tell_tilt(a, grid);
}

/* Samples --------------------------------------------------------------------------------------------------------- */

/* Keys from "dims" to "memory_bytes". id: of the volume; NULL: not told. */
static vv_status tell_info(vv_answer *a, const vv_field_info *info, const char *id)
{
    char letters[16];
    uint64_t bytes = 0;
    const vv_status st = vv_field_info_bytes(&bytes, info);
    vv_grid_orientation(letters, &info->grid);
    tell_place_keys(a, &info->grid);
    vvi_tell_text(a, "orientation", letters);
    vvi_tell_text(a, "type", vv_type_name(info->type));
    vvi_tell_count(a, "components", (uint64_t)info->components);
    vvi_tell_text(a, "meaning", meaning_names[info->meaning]);
    vvi_tell_count(a, "frames", (uint64_t)info->n_frames);
    vvi_tell_number(a, "frame_step", info->frame_step);
    vvi_tell_text(a, "frame_unit", info->frame_unit);
    vvi_tell_text(a, "name", info->name);
    if (id)
        vvi_tell_text(a, "volume", id);
    vvi_tell_text(a, "value_unit", info->value_unit);
    vvi_tell_number(a, "value_scale", info->value_scale);
    vvi_tell_number(a, "value_offset", info->value_offset);
    vvi_tell_count(a, "memory_bytes", bytes);
    return st;
}

static void tell_samples(vv_answer *a, const vv_field_info *info)
{
    char about[VVI_SAMPLES_TEXT];
    vvi_samples_print(about, info, info->n_frames);
    vvi_tell_line(a, "samples", "%s, %s", about, meaning_names[info->meaning]);
    tell_place(a, &info->grid);
}

static void tell_values(vv_answer *a, const vv_field_info *info)
{
    char scaled[96];
    vvi_scaled_print(scaled, "stored", info->value_scale, info->value_offset);
    if (info->value_scale != 1 || info->value_offset != 0)
        vvi_tell_line(a, "values", "%s %s", scaled, info->value_unit);
    else if (info->value_unit[0])
        vvi_tell_line(a, "values", "in %s", info->value_unit);
    if (info->n_frames > 1 && info->frame_step > 0)
        vvi_tell_line(a, "time", "%" PRId64 " steps of %g %s", info->n_frames, info->frame_step, info->frame_unit);
}

vv_status vvi_about_end(const vv_answer *a, vv_status st)
{
    return st == VV_OK && a->bad ? vv_fail_memory(a->n * sizeof *a->item) : st;
}

vv_status vv_about_samples(vv_answer **out, const vv_field_info *info)
{
    vv_answer *a = *out = vvi_calloc(1, sizeof *a);
    if (!a)
        return vv_fail_memory(sizeof *a);
    const vv_status st = tell_info(a, info, NULL);
    tell_samples(a, info);
    tell_values(a, info);
    return vvi_about_end(a, st);
}

/* Files ----------------------------------------------------------------------------------------------------------- */

static void tell_notes(vv_answer *a, const vv_file *file)
{
    const char *key, *value;
    vvi_tell_bool(a, "mappable", vv_file_mappable(file));
    vvi_tell_open(a, "metadata", "{");
    for (size_t i = 0; vv_file_metadata(file, i, &key, &value); i++)
        vvi_tell_text(a, key, value);
    vvi_tell_close(a, "}");
    vvi_tell_open(a, "warnings", "[");
    for (size_t i = 0; (value = vv_file_warning(file, i)); i++)
        vvi_tell_text(a, NULL, value);
    vvi_tell_close(a, "]");
}

static vv_status tell_header(const vvi_about *about)
{
    vv_answer *a = about->answer;
    const vv_field_info *info = vv_file_info(about->file);
    const char *format = vv_file_format(about->file), *id = about->options.id, *key, *value;
    uint64_t bytes = 0;
    char size[32];
    vvi_tell_text(a, "format", format);
    vv_status st = tell_info(a, info, id);
    if (st != VV_OK || (st = vv_field_info_bytes(&bytes, info)) != VV_OK)
        return st;
    tell_notes(a, about->file);
    vvi_tell_line(a, "format", "%s", format);
    tell_samples(a, info);
    tell_values(a, info);
    vvi_about_missing(about);
    vvi_print_bytes(size, bytes);
    vvi_tell_line(a, "memory", "%s%s", size, vv_file_mappable(about->file) ? " (used where it lies, not read)" : "");
    if (id)
        vvi_tell_line(a, "in a scene", "volumes.%s%s", id, vvi_has_channels(info) ? " and so on" : "");
    for (size_t i = 0; about->options.all && vv_file_metadata(about->file, i, &key, &value); i++)
        vvi_tell_line(a, i ? "" : "header", "%s: %s", key, value);
    return VV_OK;
}

static vv_status tell(const vvi_about *about)
{
    const unsigned what = about->options.what;
    vv_status st = VV_OK;
    if (what & (VV_ABOUT_RANGE | VV_ABOUT_STATISTICS) && !about->options.field)
        return vv_fail(VV_E_ARGUMENT, "what is about samples needs a field of them");
    if (what & VV_ABOUT_HEADER && (st = tell_header(about)) != VV_OK)
        return st;
    if (what & VV_ABOUT_PARTS)
        vvi_about_parts(about);
    if (what & VV_ABOUT_NAMES) {
        vvi_about_channels(about);
        vvi_about_labels(about);
    }
    if (what & VV_ABOUT_RANGE && (st = vvi_about_range(about)) != VV_OK)
        return st;
    return what & VV_ABOUT_STATISTICS ? vvi_about_statistics(about) : VV_OK;
}

void vv_about_options_init(vv_about_options *options, size_t size)
{
    const vv_about_options defaults = {.size = size, .what = VV_ABOUT_HEADER};
    memset(options, 0, size);
    memcpy(options, &defaults, size < sizeof defaults ? size : sizeof defaults);
}

vv_status vvi_about_begin(vvi_about *about, vv_answer **out, const vv_about_options *options, vv_job *job)
{
    *about = (vvi_about){.answer = *out = vvi_calloc(1, sizeof *about->answer), .job = job};
    vv_about_options_init(&about->options, sizeof about->options);
    if (options)
        memcpy(&about->options, options, options->size < sizeof about->options ? options->size : sizeof about->options);
    return about->answer ? VV_OK : vv_fail_memory(sizeof *about->answer);
}

vv_status vv_about_file(vv_answer **out, vv_file *file, const vv_about_options *options, vv_job *job)
{
    vvi_about about;
    const vv_status st = vvi_about_begin(&about, out, options, job);
    about.file = file;
    return st == VV_OK ? vvi_about_end(about.answer, tell(&about)) : st;
}
