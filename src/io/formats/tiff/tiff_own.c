#include "io/formats/tiff/tiff_own.h"
#include "core/text.h"
#include "core/units.h"
#include "io/formats/tiff/tiff_write.h"
#include "io/placement.h"
#include "io/scan.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

const char *const vvi_tiff_own_keys[VVI_TIFF_OWN_KEYS] = {
    [VVI_TIFF_OWN_DIMS] = "dims",
    [VVI_TIFF_OWN_PLACEMENT] = "placement",
    [VVI_TIFF_OWN_SPACE] = "space",
    [VVI_TIFF_OWN_UNIT] = "unit",
    [VVI_TIFF_OWN_VALUE_SCALE] = "value_scale",
    [VVI_TIFF_OWN_VALUE_OFFSET] = "value_offset",
    [VVI_TIFF_OWN_VALUE_UNIT] = "value_unit",
    [VVI_TIFF_OWN_MEANING] = "meaning",
    [VVI_TIFF_OWN_TIME_STEP] = "time_step",
    [VVI_TIFF_OWN_TIME_UNIT] = "time_unit",
};

/* Reading -------------------------------------------------------------------------------------------------------- */

int vvi_tiff_own_key(const char *name)
{
    for (int k = 0; k < VVI_TIFF_OWN_KEYS; k++)
        if (strcmp(vvi_tiff_own_keys[k], name) == 0)
            return k;
    return -1;
}

void vvi_tiff_own_add(vvi_tiff_own *own, int key, const char *text, size_t n)
{
    const size_t at = strlen(own->text[key]);
    if (n >= sizeof own->text[key] - at) {
        own->bad = true;
        return;
    }
    memcpy(own->text[key] + at, text, n);
    own->text[key][at + n] = 0;
}

/* Exactly n finite numbers. */
static bool parse_reals(double *out, int n, const char *text)
{
    for (int i = 0; i < n; i++)
        if (!vvi_scan_real(&out[i], text, &text) || !isfinite(out[i]))
            return false;
    return text[strspn(text, " ")] == 0;
}

static void copy(char *out, size_t room, const char *text)
{
    snprintf(out, room, "%.*s", (int)vvi_utf8_cut(text, strlen(text), room - 1), text);
    vvi_text_clean(out);
}

static void apply_placement(vv_field_info *info, const vvi_tiff_own *own)
{
    double dims[3], m[12];
    if (!parse_reals(dims, 3, own->text[VVI_TIFF_OWN_DIMS]) || !parse_reals(m, 12, own->text[VVI_TIFF_OWN_PLACEMENT]) ||
        !own->text[VVI_TIFF_OWN_UNIT][0])
        return;
    for (int a = 0; a < 3; a++)
        if (dims[a] != (double)info->grid.dims[a])
            return;
    const vv_grid old = info->grid;
    info->grid.index_to_world =
        (vv_affine){{{m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}}, {m[9], m[10], m[11]}};
    info->grid.space = strcmp(own->text[VVI_TIFF_OWN_SPACE], "RAS") == 0 ? VV_SPACE_RAS : VV_SPACE_PLAIN;
    copy(info->grid.unit, sizeof info->grid.unit, own->text[VVI_TIFF_OWN_UNIT]);
    if (vv_field_info_check(info) != VV_OK)
        info->grid = old;
}

static void apply_values(vv_field_info *info, const vvi_tiff_own *own)
{
    double scale, offset;
    if (parse_reals(&scale, 1, own->text[VVI_TIFF_OWN_VALUE_SCALE]) && scale != 0 &&
        parse_reals(&offset, 1, own->text[VVI_TIFF_OWN_VALUE_OFFSET])) {
        info->value_scale = scale;
        info->value_offset = offset;
    }
    if (own->text[VVI_TIFF_OWN_VALUE_UNIT][0])
        copy(info->value_unit, sizeof info->value_unit, own->text[VVI_TIFF_OWN_VALUE_UNIT]);
    if (info->meaning == VV_MEANING_SCALAR && strcmp(own->text[VVI_TIFF_OWN_MEANING], "vector") == 0)
        info->meaning = VV_MEANING_VECTOR;
    if (info->meaning == VV_MEANING_SCALAR && !vv_type_is_float(info->type) &&
        strcmp(own->text[VVI_TIFF_OWN_MEANING], "label") == 0)
        info->meaning = VV_MEANING_LABEL;
}

void vvi_tiff_own_apply(vv_field_info *info, const vvi_tiff_own *own)
{
    double step;
    if (own->bad)
        return;
    apply_placement(info, own);
    apply_values(info, own);
    if (info->n_frames > 1 && parse_reals(&step, 1, own->text[VVI_TIFF_OWN_TIME_STEP])) {
        info->frame_step = step;
        copy(info->frame_unit, sizeof info->frame_unit, own->text[VVI_TIFF_OWN_TIME_UNIT]);
    }
}

/* Writing -------------------------------------------------------------------------------------------------------- */

static void add_real(vvi_tiff_own *own, int key, double v)
{
    char number[32];
    vvi_print_number(number, v);
    if (own->text[key][0])
        vvi_tiff_own_add(own, key, " ", 1);
    vvi_tiff_own_add(own, key, number, strlen(number));
}

static void set(vvi_tiff_own *own, int key, const char *text)
{
    copy(own->text[key], sizeof own->text[key], text);
}

/* Whether steps along x, y and z are all that there is. */
static bool is_plain(const vv_grid *grid)
{
    const bool measured = strcmp(grid->unit, "voxels") != 0;
    vv_affine a = grid->index_to_world;
    for (int i = 0; i < 3 && measured; i++) {
        double *step = &(&a.axis[i].x)[i];
        *step = *step > 0 ? 1 : 0;
    }
    return grid->space == VV_SPACE_PLAIN && vvi_is_identity(&a);
}

static void fill_placement(vvi_tiff_own *own, const vv_grid *grid)
{
    const vv_affine *a = &grid->index_to_world;
    const vv_vec3 rows[4] = {a->axis[0], a->axis[1], a->axis[2], a->origin};
    for (int i = 0; i < 3; i++)
        add_real(own, VVI_TIFF_OWN_DIMS, (double)grid->dims[i]);
    for (int i = 0; i < 4; i++) {
        add_real(own, VVI_TIFF_OWN_PLACEMENT, rows[i].x + 0.0); /* no -0 */
        add_real(own, VVI_TIFF_OWN_PLACEMENT, rows[i].y + 0.0);
        add_real(own, VVI_TIFF_OWN_PLACEMENT, rows[i].z + 0.0);
    }
    set(own, VVI_TIFF_OWN_SPACE, grid->space == VV_SPACE_RAS ? "RAS" : "");
    set(own, VVI_TIFF_OWN_UNIT, grid->unit);
}

void vvi_tiff_own_fill(vvi_tiff_own *own, const vv_field_info *info, const vv_grid *grid, size_t n_frames, bool ome)
{
    *own = (vvi_tiff_own){0};
    if (!is_plain(grid) || (ome && !vvi_tiff_ome_unit(grid->unit)))
        fill_placement(own, grid);
    if (ome && (info->value_scale != 1 || info->value_offset != 0)) {
        add_real(own, VVI_TIFF_OWN_VALUE_SCALE, info->value_scale);
        add_real(own, VVI_TIFF_OWN_VALUE_OFFSET, info->value_offset);
    }
    if (ome)
        set(own, VVI_TIFF_OWN_VALUE_UNIT, info->value_unit);
    if (info->meaning == VV_MEANING_LABEL || info->meaning == VV_MEANING_VECTOR)
        set(own, VVI_TIFF_OWN_MEANING, info->meaning == VV_MEANING_LABEL ? "label" : "vector");
    /* a step of 1 without a unit is what headers have that know nothing of time */
    if (n_frames > 1 && info->frame_step != 0 && info->frame_step != 1 && vvi_tiff_seconds(info->frame_unit) == 0) {
        add_real(own, VVI_TIFF_OWN_TIME_STEP, info->frame_step);
        set(own, VVI_TIFF_OWN_TIME_UNIT, info->frame_unit);
    }
}
