/* What is known of a field without its samples: defaults, sizes, and the check that every field passes. */
#include "grid/field.h"

#include <math.h>
#include <string.h>

vv_field_info vv_field_info_default(void)
{
    return (vv_field_info){
        .grid = {.dims = {1, 1, 1}, .index_to_world = vv_affine_identity(), .unit = "voxels"},
        .type = VV_TYPE_U8,
        .components = 1,
        .value_scale = 1,
        .n_frames = 1,
    };
}

const char *vv_component_name(const vv_field_info *info, int component)
{
    static const char *const colors[] = {"red", "green", "blue", "alpha"}, *const axes[] = {"x", "y", "z"};
    const bool color = info->meaning == VV_MEANING_RGB || info->meaning == VV_MEANING_RGBA;
    const int n = color ? 4 : info->meaning == VV_MEANING_VECTOR ? 3 : 0;
    if (component < 0 || component >= info->components || component >= n)
        return NULL;
    return color ? colors[component] : axes[component];
}

vv_status vv_field_info_bytes(uint64_t *bytes_out, const vv_field_info *info)
{
    uint64_t bytes = vv_type_bytes(info->type);
    const int64_t factors[4] = {info->components, info->grid.dims[0], info->grid.dims[1], info->grid.dims[2]};
    for (int f = 0; f < 4; f++) {
        if (factors[f] < 1)
            return vv_fail(VV_E_LIMIT, "%s is %lld; it must be at least 1",
                           f ? "a dimension" : "the number of channels", (long long)factors[f]);
        if (__builtin_mul_overflow(bytes, (uint64_t)factors[f], &bytes) || bytes > INT64_MAX)
            return vv_fail(VV_E_LIMIT, "%lld x %lld x %lld samples of %d %s are more bytes than can be counted",
                           (long long)factors[1], (long long)factors[2], (long long)factors[3], info->components,
                           vv_type_name(info->type));
    }
    *bytes_out = bytes;
    return VV_OK;
}

static bool finite3(vv_vec3 v)
{
    return isfinite(v.x) && isfinite(v.y) && isfinite(v.z);
}

/* So that squares of lengths and volumes are numbers too, and none of them 0. */
#define LENGTH_MOST 1e100
#define SPACING_LEAST 1e-100

static vv_status check_lengths(const vv_grid *grid)
{
    for (int a = 0; a < 3; a++) {
        const double spacing = vv_grid_spacing(grid, a), length = spacing * (double)grid->dims[a];
        if (spacing > 0 && spacing < SPACING_LEAST)
            return vv_fail(VV_E_FORMAT, "the spacing along %c is %g %s; expected no less than %g: it is damaged",
                           "xyz"[a], spacing, grid -> unit, SPACING_LEAST);
        if (!(length <= LENGTH_MOST))
            return vv_fail(VV_E_FORMAT,
                           "the volume is %g %s long along %c; expected no more than %g: its spacing (%g) is "
                           "damaged",
                           length, grid->unit, "xyz"[a], LENGTH_MOST, spacing);
    }
    return VV_OK;
}

static vv_status check_grid(const vv_grid *grid)
{
    const vv_affine *m = &grid->index_to_world;
    double volume = 1;
    for (int a = 0; a < 3; a++) {
        if (grid->dims[a] < 1)
            return vv_fail(VV_E_FORMAT, "dimension %d is %lld; it must be at least 1", a, (long long)grid->dims[a]);
        if (!finite3(m->axis[a]))
            return vv_fail(VV_E_FORMAT, "the direction of axis %d is not finite", a);
        volume *= vv_grid_spacing(grid, a);
    }
    if (!finite3(m->origin))
        return vv_fail(VV_E_FORMAT, "the origin is not finite");
    const vv_status st = check_lengths(grid);
    if (st != VV_OK)
        return st;
    /* Relative to the axes' lengths, so that a grid in metres is judged as the same grid in micrometres. */
    if (!(fabs(vv_affine_determinant(*m)) > 1e-10 * volume) || !isfinite(volume))
        return vv_fail(VV_E_FORMAT, "the three axis directions do not span space (determinant %g)",
                       vv_affine_determinant(*m));
    if (grid->space != VV_SPACE_PLAIN && grid->space != VV_SPACE_RAS)
        return vv_fail(VV_E_FORMAT, "the space %d is unknown", (int)grid->space);
    if (!memchr(grid->unit, 0, sizeof grid->unit))
        return vv_fail(VV_E_FORMAT, "the unit of length has no end");
    return VV_OK;
}

static vv_status check_meaning(const vv_field_info *info)
{
    if ((unsigned)info->type >= VV_TYPE_COUNT)
        return vv_fail(VV_E_FORMAT, "the sample type %d is unknown", (int)info->type);
    if (info->components < 1)
        return vv_fail(VV_E_FORMAT, "the number of channels is %d; it must be at least 1", info->components);
    switch (info->meaning) {
    case VV_MEANING_SCALAR:
    case VV_MEANING_VECTOR:
        return VV_OK;
    case VV_MEANING_RGB:
    case VV_MEANING_RGBA:
        if (info->components != (info->meaning == VV_MEANING_RGB ? 3 : 4))
            return vv_fail(VV_E_FORMAT, "colours with %d channels; RGB has 3, RGBA 4", info->components);
        return VV_OK;
    case VV_MEANING_LABEL:
        if (vv_type_is_float(info->type))
            return vv_fail(VV_E_FORMAT, "labels of type %s; they must be integers", vv_type_name(info->type));
        return VV_OK;
    }
    return vv_fail(VV_E_FORMAT, "the meaning %d of the channels is unknown", (int)info->meaning);
}

vv_status vv_field_info_check(const vv_field_info *info)
{
    vv_status st;
    uint64_t bytes;
    if ((st = check_grid(&info->grid)) != VV_OK || (st = check_meaning(info)) != VV_OK ||
        (st = vv_field_info_bytes(&bytes, info)) != VV_OK)
        return st;
    if (!isfinite(info->value_scale) || info->value_scale == 0 || !isfinite(info->value_offset))
        return vv_fail(VV_E_FORMAT,
                       "values are stored * %g + %g; the scale must be finite and not 0, the offset finite",
                       info->value_scale, info->value_offset);
    if (info->n_frames < 1 || info->frame < 0 || info->frame >= info->n_frames)
        return vv_fail(VV_E_FORMAT, "time step %lld of %lld does not exist", (long long)info->frame,
                       (long long)info->n_frames);
    if (!isfinite(info->frame_step))
        return vv_fail(VV_E_FORMAT, "the time between time steps is not finite");
    if (!memchr(info->value_unit, 0, sizeof info->value_unit) || !memchr(info->name, 0, sizeof info->name) ||
        !memchr(info->frame_unit, 0, sizeof info->frame_unit))
        return vv_fail(VV_E_FORMAT, "a name or a unit has no end");
    return VV_OK;
}
