/* Volumes that are told sample by sample with the one that is measured: masks, and the values of labels. */
#include "core/status.h"
#include "grid/alike.h"
#include "grid/true_values.h"
#include "measure.h"
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
static vv_status check_covered(const cli_measuring *m, const vv_field *other, const vv_box *box, bool marks,
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
        cli_command_note(m->command, "the %s covers %s of %s; beyond it nothing is marked", about, range,
                         m->input.path);
        return VV_OK;
    }
    return vv_fail(VV_E_ARGUMENT,
                   "the %s: expected samples wherever %s has some, found them for %s only; crop that to them: 'volvis "
                   "crop %s %s -o OUT'",
                   about, m->input.path, range, m->input.path, options);
}

/* Samples that lie in the same places, but have other numbers: of a segmentation of a part, or stored in another
 * order. */
static vv_status fit(vv_field **field, const cli_measuring *m, bool marks, const char *about)
{
    const vv_grid *grid = &vv_field_get_info(m->field)->grid, *other = &vv_field_get_info(*field)->grid;
    vvi_grid_fit fit;
    vv_field *fitted;
    const bool fits = vvi_grid_fits(&fit, grid, other);
    const vv_box box = fits ? vvi_grid_covered(grid, other, &fit) : (vv_box){0};
    if (!box.n[0] || !box.n[1] || !box.n[2])
        return vvi_grid_alike(grid, other, about); /* says what differs */
    vv_status st = check_covered(m, *field, &box, marks, about);
    if (st == VV_OK && (st = vvi_field_fitted(&fitted, *field, grid, &fit, m->command->job)) == VV_OK) {
        vv_field_release(*field);
        *field = fitted;
    }
    return st;
}

vv_status cli_measuring_beside(vv_field **out, const cli_measuring *m, cli_input *input, vvi_stream *stream, bool marks,
                               const char *word)
{
    char about[192];
    vv_status st = cli_measuring_read(out, input, stream, m->command, word);
    snprintf(about, sizeof about, "%s %.160s", marks ? "mask" : "volume of values", word);
    if (st != VV_OK || (st = cli_measuring_put_at(out, &m->place)) != VV_OK)
        return st;
    return vvi_grid_alike(&vv_field_get_info(m->field)->grid, &vv_field_get_info(*out)->grid, about) == VV_OK
               ? VV_OK
               : fit(out, m, marks, about);
}
