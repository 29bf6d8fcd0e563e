/* Volumes that are told sample by sample with the one that is measured: masks, and the values of labels. */
#include "core/status.h"
#include "grid/field.h"
#include "grid/same_grid.h"
#include "grid/true_values.h"
#include "measuring/measuring.h"
#include "measuring/world_data.h"
#include <inttypes.h>
#include <stdio.h>

/* "x 0..28, y 0..22, z 0..17", or by another format the options of crop. */
static void print_box(char out[160], const vv_box *box, const char *format, const char *between)
{
    size_t at = 0;
    for (int a = 0; a < 3; a++)
        at += (size_t)snprintf(out + at, 160 - at, format, a ? between : "", "xyz"[a], box -> lo[a],
                               box -> lo[a] + box -> n[a] - 1);
}

/* What one lacks of the other's samples has no values; no mark is no mark. */
static vv_status check_covered(const vvi_measuring *m, const vv_field *other, const vv_box *box, bool marks,
                               const char *about)
{
    char range[160], options[160];
    const int64_t *d = vv_field_get_info(m->field)->grid.dims;
    const bool whole = box->n[0] == d[0] && box->n[1] == d[1] && box->n[2] == d[2];
    if (whole)
        return VV_OK;
    print_box(range, box, "%s%c %" PRId64 "..%" PRId64, ", ");
    print_box(options, box, "%s--%c %" PRId64 "..%" PRId64, " ");
    if (marks && !vvi_has_scale(vv_field_get_info(other))) {
        vvi_tell_note(m->answer, "the %s covers %s of %s; beyond it nothing is marked", about, range, m->input->name);
        return VV_OK;
    }
    return vv_fail(VV_E_ARGUMENT,
                   "the %s: expected samples wherever %s has some, found them for %s only; crop that to them: 'volvis "
                   "crop %s %s -o OUT'",
                   about, m->input->name, range, m->input->name, options);
}

/* Samples that lie in the same places, but have other numbers: of a segmentation of a part, or stored in another
 * order. */
static vv_status fit(vv_field **field, const vvi_measuring *m, bool marks, const char *about)
{
    const vv_grid *grid = &vv_field_get_info(m->field)->grid, *other = &vv_field_get_info(*field)->grid;
    vvi_grid_fit fit;
    vv_field *fitted;
    const bool fits = vvi_grid_fits(&fit, grid, other);
    const vv_box box = fits ? vvi_grid_covered(grid, other, &fit) : (vv_box){0};
    if (!box.n[0] || !box.n[1] || !box.n[2])
        return vvi_grid_alike(grid, other, about); /* says what differs */
    vv_status st = check_covered(m, *field, &box, marks, about);
    if (st == VV_OK && (st = vvi_field_fitted(&fitted, *field, grid, &fit, m->job)) == VV_OK) {
        vv_field_release(*field);
        *field = fitted;
    }
    return st;
}

/* The same samples elsewhere in the world, in the unit of those that are measured. */
static vv_status put_at(vv_field **out, const vv_measured_data *data, const vvi_measuring *m)
{
    vv_field_info info = *vv_field_get_info(data->field);
    vvi_grid_take_unit(&info.grid, vv_field_get_info(m->field)->grid.unit);
    info.grid.index_to_world = vv_affine_compose(m->input->place, info.grid.index_to_world);
    return vvi_field_relabel(out, data->field, &info);
}

vv_status vvi_measuring_beside(vv_field **out, const vvi_measuring *m, const vv_measured_data *data, bool marks)
{
    char about[192];
    if (!data || !data->field)
        return vv_fail(VV_E_ARGUMENT, "the %s is not there", marks ? "mask" : "volume of values");
    const vv_status st = put_at(out, data, m);
    snprintf(about, sizeof about, "%s %.160s", marks ? "mask" : "volume of values", data->name);
    if (st != VV_OK)
        return st;
    return vvi_grid_alike(&vv_field_get_info(m->field)->grid, &vv_field_get_info(*out)->grid, about) == VV_OK
               ? VV_OK
               : fit(out, m, marks, about);
}
