/* Attributes of the data set that we write: all that is known of it besides its samples (docs/formats.md). */
#include "core/memory.h"
#include "core/text.h"
#include "core/units.h"
#include "grid/label_id.h"
#include "io/formats/hdf5/hdf5.h"
#include "io/formats/nifti/nifti.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ATTRIBUTE_MOST 60000 /* bytes; the format has room for 64 KiB */

static void put_text(hid_t data, const char *name, const char *text)
{
    const size_t n = strlen(text);
    if (n == 0 || n > ATTRIBUTE_MOST)
        return;
    const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
    H5Tset_size(type, n + 1);
    H5Tset_cset(type, H5T_CSET_UTF8);
    const hid_t attribute = H5Acreate2(data, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type, text);
    H5Aclose(attribute);
    H5Sclose(space);
    H5Tclose(type);
}

/* n rows of m numbers; m 0: n numbers. */
static void put_numbers(hid_t data, const char *name, const double *value, size_t n, size_t m)
{
    const hsize_t dims[2] = {n, m};
    if (n * (m ? m : 1) * sizeof *value > ATTRIBUTE_MOST)
        return;
    const hid_t space = n == 1 && m == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(m ? 2 : 1, dims, NULL);
    const hid_t attribute = H5Acreate2(data, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, H5T_NATIVE_DOUBLE, value);
    H5Aclose(attribute);
    H5Sclose(space);
}

static void put_placement(hid_t data, const vv_grid *grid)
{
    const vv_affine *a = &grid->index_to_world;
    const double metres = vvi_length_unit_metres(grid->unit);
    double size[3], directions[9], um[3];
    for (int i = 0; i < 3; i++) {
        size[2 - i] = vv_grid_spacing(grid, i); /* z, y, x as the axes are */
        um[2 - i] = size[2 - i] * metres * 1e6;
        directions[3 * i] = a->axis[i].x;
        directions[3 * i + 1] = a->axis[i].y;
        directions[3 * i + 2] = a->axis[i].z;
    }
    const double origin[3] = {a->origin.x, a->origin.y, a->origin.z};
    put_numbers(data, "element_size", size, 3, 0);
    if (metres > 0)
        put_numbers(data, "element_size_um", um, 3, 0);
    put_numbers(data, "directions", directions, 3, 3);
    put_numbers(data, "origin", origin, 3, 0);
    put_text(data, "unit", grid->unit);
    put_text(data, "space", grid->space == VV_SPACE_RAS ? "RAS" : "plain");
}

static void put_values(hid_t data, const vv_field_info *info)
{
    static const char *const meanings[] = {"scalar", "rgb", "rgba", "vector", "label"};
    put_text(data, "meaning", meanings[info->meaning]);
    put_text(data, "name", info->name);
    put_text(data, "value_unit", info->value_unit);
    if (info->value_scale != 1 || info->value_offset != 0) {
        put_numbers(data, "scale_factor", &info->value_scale, 1, 0);
        put_numbers(data, "add_offset", &info->value_offset, 1, 0);
    }
    if (info->frame_step != 0)
        put_numbers(data, "frame_step", &info->frame_step, 1, 0);
    put_text(data, "frame_unit", info->frame_unit);
}

/* Rows of numbers, and lines of text with the name of each row. */
typedef struct table {
    const char *numbers, *names; /* attributes */
    size_t n_columns, n_rows_most;
    const char *(*row)(double *numbers_out, const vv_write_options *options, size_t index); /* gives the name */
} table;

static const char *channel_row(double *out, const vv_write_options *options, size_t index)
{
    const vv_channel *c = &options->channels[index];
    const double numbers[7] = {c->has_color, c->color.r, c->color.g, c->color.b, c->color.a, c->lo, c->hi};
    memcpy(out, numbers, sizeof numbers);
    return c->name;
}

static const char *label_row(double *out, const vv_write_options *options, size_t index)
{
    const vv_label *l = &options->labels[index];
    const double numbers[6] = {(double)l->value, l->has_color, l->color.r, l->color.g, l->color.b, l->color.a};
    memcpy(out, numbers, sizeof numbers);
    return l->name;
}

static const table channels = {"channels", "channel_names", 7, 1023, channel_row};
static const table labels = {"labels", "label_names", 6, 1199, label_row};

static void put_table(hid_t data, const table *t, size_t n, const vv_write_options *options)
{
    vvi_text names = {0};
    double *numbers = n > 0 && n <= t->n_rows_most ? vvi_calloc(n, t->n_columns * sizeof *numbers) : NULL;
    for (size_t i = 0; numbers && i < n; i++)
        vvi_text_printf(&names, "%s%s", i ? "\n" : "", t->row(numbers + t->n_columns * i, options, i));
    if (numbers && names.s && !names.bad)
        put_text(data, t->names, names.s);
    if (numbers)
        put_numbers(data, t->numbers, numbers, n, t->n_columns);
    vvi_text_free(&names);
    free(numbers);
}

/* Where doubles do not have all digits of them, the first column of the table once more. */
static void put_label_ids(hid_t data, const vv_field_info *info, const vv_write_options *options)
{
    const bool is_unsigned = vvi_label_is_unsigned(info->type);
    const hsize_t n = options->n_labels;
    bool far = false;
    for (size_t i = 0; i < n; i++)
        far |= !(fabs(vvi_label_value(options->labels[i].value, is_unsigned)) < 0x1p53);
    vv_label_id *ids = far && n <= labels.n_rows_most ? vvi_calloc(n, sizeof *ids) : NULL;
    if (!ids)
        return;
    for (size_t i = 0; i < n; i++)
        ids[i] = options->labels[i].value;
    const hid_t space = H5Screate_simple(1, &n, NULL);
    const hid_t attribute =
        H5Acreate2(data, "label_ids", is_unsigned ? H5T_STD_U64LE : H5T_STD_I64LE, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, is_unsigned ? H5T_NATIVE_UINT64 : H5T_NATIVE_INT64, ids);
    H5Aclose(attribute);
    H5Sclose(space);
    free(ids);
}

static void put_nifti(hid_t data, const vv_field_info *info, size_t n_frames, const vv_write_options *options)
{
    vvi_text lines = {0};
    vvi_nifti_add_words(&lines, "", "=", info, n_frames, options);
    if (lines.s && !lines.bad)
        put_text(data, VVI_H5_NIFTI, lines.s);
    vvi_text_free(&lines);
}

void vvi_h5_write_attributes(hid_t data, const char *axes, const vv_field_info *info, size_t n_frames,
                             const vv_write_options *options)
{
    put_text(data, "axes", axes);
    put_placement(data, &info->grid);
    put_values(data, info);
    put_nifti(data, info, n_frames, options);
    put_table(data, &channels, options->n_channels, options);
    put_table(data, &labels, options->n_labels, options);
    put_label_ids(data, info, options);
}
